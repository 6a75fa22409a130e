"""Errors of every estimator on a log from which GNSS is removed in regular time intervals."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs import Log
from twin.pipeline.drive import phases_of
from twin.pipeline.estimating import Estimator, all_estimates
from twin.scores import hidden
from twin.scores.hidden import Score

LONGEST_S = 3600.0


def hidden_scores(
    log: Log, estimators: Mapping[str, Estimator], hide_s: Sequence[float]
) -> list[dict[str, Plain]]:
    """One score for each estimator and each length of the hidden intervals.

    Args:
        log: the recorded drive.
        estimators: name -> estimator; an estimator that fails has no estimates.
        hide_s: lengths of the intervals without GNSS [s].

    Raises:
        BadInput: the log has no GNSS speed, or is too short for one of the lengths.
    """
    found: list[Score] = []
    for hidden_s in hide_s:
        if not 0.0 < hidden_s <= LONGEST_S:
            raise BadInput(f"--hide {hidden_s:g} s: it has to be above 0 and at most {LONGEST_S:g}")
        found += _of_one(log, estimators, hidden_s)
    return [dataclasses.asdict(score) for score in found]


def _of_one(log: Log, estimators: Mapping[str, Estimator], hidden_s: float) -> list[Score]:
    gnss = "gnss" in log.streams
    places = list(hidden.passes(log.setup, log.streams, hidden_s)) if gnss else []
    if not places:
        raise BadInput(
            f"--hide {hidden_s:g} s: the log has less than {hidden.LEARN_S + hidden_s:g} s of GNSS "
            "speed; a longer log would do"
        )
    errors: dict[str, list[hidden.Errors]] = {name: [] for name in estimators}
    phases: dict[str, list[NDArray[np.int64]]] = {name: [] for name in estimators}
    driven = phases_of(log.streams, {})
    for start_ns in places:
        seen = hidden.without_gnss(log.streams, start_ns, hidden_s)
        tables = all_estimates(estimators, log.setup, seen).tables
        for name, table in tables.items():
            errors[name].append(hidden.errors(log.setup, log.streams, table, start_ns, hidden_s))
            rows, _ = hidden.ends(log.setup, log.streams, table, start_ns, hidden_s)
            if driven is not None:
                phases[name].append(driven.at(log.streams["gnss"]["epoch_ns"][rows]))
    return [
        hidden.summed_up(name, hidden_s, each, phases[name] or None)
        for name, each in errors.items()
    ]
