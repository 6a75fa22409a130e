"""Compiling that takes long is told, once."""

from __future__ import annotations

import time

import pytest

from twin.compute import waiting


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(waiting, "PATIENCE_S", 0.2)


def _compile(function: str, seconds: float) -> None:
    waiting.begins(function)
    time.sleep(seconds)
    waiting.ends(function)


def test_long_compiling_is_told_once_while_it_goes_on() -> None:
    told: list[str] = []
    with waiting.when_compiling(lambda: told.append("compiling")):
        waiting.begins("outer")
        _compile("inner", 0.5)
        assert told == ["compiling"]
        waiting.ends("outer")
        _compile("another", 0.5)
    assert told == ["compiling"]


def test_many_short_ones_count_together() -> None:
    told: list[str] = []
    with waiting.when_compiling(lambda: told.append("compiling")):
        for _ in range(6):
            _compile("f", 0.06)
    assert told == ["compiling"]


def test_short_compiling_and_other_work_are_not_told() -> None:
    told: list[str] = []
    with waiting.when_compiling(lambda: told.append("compiling")):
        _compile("f", 0.01)
        time.sleep(0.4)
    _compile("g", 0.3)
    assert told == []
