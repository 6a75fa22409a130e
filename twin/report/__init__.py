"""The report: one self-contained page of a run, no network, readable on a phone."""

from twin.report import bare_matplotlib  # before all that imports matplotlib
from twin.report.page import write

__all__ = ["bare_matplotlib", "write"]
