"""How likely a log is to a filter: the density of its innovations, by blocks of time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.plugins.failing import failing
from twin.plugins.lookup import Thing
from twin.plugins.percent import MOVING_MPS
from twin.scores.hidden import speeds
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

OUTLIER_SHARE, OUTLIER_SD = 0.01, 10.0
"""Share of measurements that are taken to be something else, and how much wider these spread."""
COLUMNS = ("epoch_ns", "sensor", "innovation", "variance")


def innovations(name: str, estimator: Thing, setup: Setup, streams: Streams) -> Table:
    """The innovations of an estimator while driving, each with its epoch and variance.

    Args:
        name: what messages call the estimator.
        estimator: with `innovations(setup, streams) -> table`.
        setup, streams: given to it.

    Raises:
        BadInput: it has none, fails, or its table lacks a column.
    """
    if not callable(getattr(estimator, "innovations", None)):
        raise BadInput(
            f"estimator '{name}' has no innovations(setup, streams), by which it could be tuned"
        )
    with failing(f"estimator '{name}'", estimator):
        found: Table = estimator.innovations(setup, streams)
        table = {column: np.asarray(found[column]) for column in COLUMNS}
    if len({values.shape for values in table.values()}) > 1:
        raise BadInput(f"estimator '{name}': the columns of its innovations differ in length")
    return while_driving(table, setup, streams)


def log_density(innovation: Array, variance: Array) -> Array:
    """Logarithm of the density of each innovation, with a share of outliers.

    ln ((1 - share) N(e; 0, S) + share N(e; 0, 10^2 S))

    Source: Tukey (1960), A survey of sampling from contaminated distributions.
    """
    square = innovation**2 / variance
    regular = np.log(1.0 - OUTLIER_SHARE) - 0.5 * square
    wide = np.log(OUTLIER_SHARE / OUTLIER_SD) - 0.5 * square / OUTLIER_SD**2
    return np.asarray(np.logaddexp(regular, wide) - 0.5 * np.log(2.0 * np.pi * variance))


def in_blocks(table: Table, edges_ns: NDArray[np.int64]) -> dict[str, Array]:
    """Sum of the log densities of each sensor's innovations in each block of time.

    Args:
        table: innovations.
        edges_ns: where blocks begin and the last one ends, (n + 1,).

    Returns:
        Sensor -> sums, (n,); a filter that is not finite is infinitely unlikely.
    """
    block = np.searchsorted(edges_ns, table["epoch_ns"], side="right") - 1
    inside = (block >= 0) & (block < len(edges_ns) - 1)
    density = log_density(table["innovation"], table["variance"])
    density = np.where(np.isfinite(density), density, -np.inf)
    sums = {}
    for sensor in np.unique(table["sensor"]):
        own = inside & (table["sensor"] == sensor)
        sums[str(sensor)] = np.bincount(block[own], density[own], len(edges_ns) - 1).astype(float)
    return sums


def while_driving(table: Table, setup: Setup, streams: Streams) -> Table:
    """The innovations while the receiver's last speed is above 0.5 m/s; all without a receiver.

    Standing still is most of many logs, and its noises are none of those at work.
    """
    if not len(streams.tables.get("gnss", {}).get("epoch_ns", ())):
        return table
    order = np.argsort(streams["gnss"]["epoch_ns"], kind="stable")
    speed = np.abs(speeds(setup, streams))[order]
    known = np.isfinite(speed)
    seen_ns = streams["gnss"]["epoch_ns"][order][known]
    if not len(seen_ns):
        return table
    last = np.searchsorted(seen_ns, table["epoch_ns"], side="right") - 1
    driving = (last >= 0) & (speed[known][np.maximum(last, 0)] > MOVING_MPS)
    return {name: values[driving] for name, values in table.items()}


Score = Callable[[Array], Array]
"""Logarithms of factors on the noises, (k,) -> log density by block, (n,)."""
