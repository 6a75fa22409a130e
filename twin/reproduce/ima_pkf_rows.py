"""Errors of many trials as rows: with intervals, and with what is promised of their order."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from twin.compute.mean import mean
from twin.io.result_rows import Rows, row
from twin.reproduce.ima_pkf_trials import Errors

QUANTITIES = {"MAE": "mae", "RMSE": "rmse", "RMSE from 1 s": "rmse_settled"}
ORDER = ("KF", "PSO-PKF", "MA-PKF", "IMA-PKF")
"""From the largest error to the smallest, as published."""


def measured(
    case: str,
    found: Mapping[str, list[Errors]],
    published: Mapping[str, Mapping[str, float]],
) -> Rows:
    """Mean over seeds with its 95 % interval in low and high, and the largest error of all."""
    out = []
    for name, errors in found.items():
        said = published.get(name, {})
        for quantity, attribute in QUANTITIES.items():
            found_mean = mean(getattr(e, attribute) for e in errors)
            line = row(
                case, f"{quantity}, {name}", found_mean.mean, "1", published=said.get(quantity)
            )
            out.append(line | found_mean.bounds)
        largest = max(e.largest for e in errors)
        out.append(row(case, f"max, {name}", largest, "1", published=said.get("max")))
    return out


def leads(case: str, found: Mapping[str, list[Errors]]) -> Rows:
    """How much less the RMSE of each method is than that of the one before, seed by seed."""
    out = []
    for worse, better in pairwise(ORDER):
        pairs = zip(found[worse], found[better], strict=True)
        gain = mean(a.rmse - b.rmse for a, b in pairs)
        out.append(row(case, lead(worse, better), gain.mean, "1") | gain.bounds)
    return out


def lead(worse: str, better: str) -> str:
    """The quantity's name."""
    return f"RMSE of {worse} over {better}, paired"


def promises(case: str, found: Mapping[str, list[Errors]], rmse: float) -> Rows:
    """The published order of the methods' mean RMSE, and the published RMSE of the last."""
    means = {name: mean(e.rmse for e in found[name]).mean for name in ORDER}
    out = [
        row(case, f"RMSE of {worse} over {better}", means[worse] - means[better], "1", low=0.0)
        for worse, better in pairwise(ORDER)
    ]
    last = ORDER[-1]
    return [*out, row(case, f"RMSE of {last}", means[last], "1", high=rmse, published=rmse)]
