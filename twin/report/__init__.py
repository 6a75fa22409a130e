"""The report: one self-contained page of a run, no network, readable on a phone."""

from twin.report.page import write

__all__ = ["write"]
