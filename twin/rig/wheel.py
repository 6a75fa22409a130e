"""The single-wheel rig: forces and torque at imposed slip, slip angle and load."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.errors import BadInput, check_range
from twin.physics import block
from twin.physics.block import Wheel
from twin.physics.validity import outside_validity
from twin.rig.defaults import SPEED_MPS
from twin.rig.stand import stand
from twin.rig.steady import steady
from twin.rig.table import Measured
from twin.rig.tyre import MOST_DEFLECTION, Tyre
from twin.scenario import Soil

Array = NDArray[np.float64]

MOST_SLIP = 0.95
"""Largest slip or skid that can be imposed [-]: at 1 the carriage or the wheel stands still."""


@dataclass(frozen=True, kw_only=True)
class WheelPoints(Measured):
    """Measurements of the wheel rig, one value per point. Shape (n,)."""

    slip: Array
    """(w R - v) / max(|w R|, |v|), by the wheel's speeds and the rolling radius under load [-];
    negative for a skid."""
    slip_angle_rad: Array
    """From the wheel's plane to its path [rad]; positive when it slides to the right."""
    load_n: Array
    """Vertical load [N]."""
    net_pull_n: Array
    """Pull of the wheel on the carriage, forward positive [N]."""
    axle_torque_nm: Array
    """Torque of the spin servo [N m]."""
    lateral_n: Array
    """Side force of the ground, to the left positive [N]."""
    rolling_radius_m: Array
    """Zero-slip radius under the load [m]."""
    sinkage_m: Array
    """Sinkage by the soil law [m]; 0 under a law without sinkage."""


@dataclass(frozen=True, kw_only=True)
class WheelCurve(WheelPoints):
    """A wheel whose speeds are imposed."""

    law_resistance_n: Array
    """Resistance at the hub as the law reports it [N]."""

    @property
    def net_traction_ratio(self) -> Array:
        """NTR = pull / W"""
        return self.net_pull_n / self.load_n

    @property
    def gross_traction_ratio(self) -> Array:
        """GTR = T / (r W), T measured at the axle."""
        return self.axle_torque_nm / (self.rolling_radius_m * self.load_n)

    @property
    def motion_resistance_n(self) -> Array:
        """T / r - pull"""
        return self.axle_torque_nm / self.rolling_radius_m - self.net_pull_n

    @property
    def motion_resistance_ratio(self) -> Array:
        """MRR = GTR - NTR"""
        return self.gross_traction_ratio - self.net_traction_ratio

    @property
    def tractive_efficiency(self) -> Array:
        """TE = (1 - s) NTR / GTR while the wheel drives and pulls, NaN elsewhere."""
        net, gross = self.net_traction_ratio, self.gross_traction_ratio
        pulls = (net > 0.0) & (gross > 0.0)
        return np.where(pulls, (1.0 - self.slip) * net / np.where(pulls, gross, 1.0), np.nan)

    @property
    def lateral_ratio(self) -> Array:
        """Side force / W"""
        return self.lateral_n / self.load_n

    def columns(self) -> dict[str, Array]:
        """Everything measured and derived, by name."""
        return super().columns() | {name: getattr(self, name) for name in DERIVED}

    def where(self, keep: NDArray[np.bool_]) -> WheelCurve:
        """The points kept."""
        return WheelCurve(**{f.name: getattr(self, f.name)[keep] for f in dataclasses.fields(self)})


DERIVED = (
    "net_traction_ratio", "gross_traction_ratio", "motion_resistance_ratio", "motion_resistance_n",
    "tractive_efficiency", "lateral_ratio",
)  # fmt: skip


def wheel(
    tyre: Tyre,
    soil: Soil,
    *,
    slip: ArrayLike,
    load_n: ArrayLike,
    slip_angle_rad: ArrayLike = 0.0,
    speed_mps: float = SPEED_MPS,
    radial: bool = False,
) -> WheelCurve:
    """One wheel at imposed slip, slip angle and load, each point run to its steady state.

    Args:
        tyre: the wheel under test.
        soil: what lies under it, the same everywhere.
        slip: (w R - v) / max(|w R|, |v|) in the wheel's plane, within 0.95; broadcasts with the
            load and the slip angle.
        load_n: vertical load [N].
        slip_angle_rad: positive when the wheel slides to its right, within 80 degrees.
        speed_mps: speed of the carriage along its path.
        radial: Brixius' numbers for a radial tyre in place of the soil's.

    Raises:
        OutOfRange, BadInput: an argument outside what can be imposed.
        NotSteady: a point did not reach a steady state.
    """
    sizes = tyre.sizes()
    s, angle, load = _points(slip, slip_angle_rad, load_n)
    check_range("speed_mps", speed_mps, 0.2, 10.0)
    _check_load(load, sizes)
    roll = speed_mps * np.cos(angle)
    spin = np.where(s >= 0.0, roll / (1.0 - np.abs(s)), roll * (1.0 - np.abs(s)))  # at the radius
    side = -speed_mps * np.sin(angle)
    model = stand(sizes, soil, float(load.max()), radial=radial)
    out = steady(model, sizes, load, {"along": roll, "across": side, "spin": spin})
    return WheelCurve(
        slip=out["slip"],
        slip_angle_rad=out["slip_angle_rad"],
        load_n=load,
        net_pull_n=-out["along"],
        axle_torque_nm=out["spin"],
        lateral_n=-out["across"],
        rolling_radius_m=out["rolling_radius_m"],
        sinkage_m=out["sinkage_m"],
        law_resistance_n=out["resistance_n"],
    )


def outside_range(
    tyre: Tyre, soil: Soil, *, load_n: ArrayLike, radial: bool = False
) -> tuple[str, ...]:
    """What of the tests at these loads lies outside the range of the soil's law, in sentences."""
    sizes, (_, _, loads) = tyre.sizes(), _points(0.0, 0.0, load_n)
    _check_load(loads, sizes)
    parameters = stand(sizes, soil, float(loads.max()), radial=radial).numeric_data[-block.SIZE :]
    ground = parameters[block.SOIL : block.WHEEL]
    size = parameters[block.WHEEL : block.WHEEL + Wheel.SIZE]
    found = (text for load in loads for text in outside_validity(ground, size, float(load)))
    return tuple(dict.fromkeys(found))


@dataclass(frozen=True, kw_only=True)
class Free(WheelPoints):
    """A wheel that one of its speeds is left to: towed without torque, or driven without pull."""

    @property
    def towed_ratio(self) -> Array:
        """Towed force / W"""
        return -self.net_pull_n / self.load_n


def towed(
    tyre: Tyre,
    soil: Soil,
    *,
    load_n: ArrayLike,
    slip_angle_rad: ArrayLike = 0.0,
    speed_mps: float = SPEED_MPS,
    radial: bool = False,
) -> Free:
    """A wheel pulled without torque: its skid and the force it takes.

    Arguments and errors as for `wheel`.
    """
    points = _points(0.0, slip_angle_rad, load_n)
    return _free(tyre, soil, points, speed_mps, radial, held=("along", "across"))


def self_propelled(
    tyre: Tyre,
    soil: Soil,
    *,
    load_n: ArrayLike,
    speed_mps: float = SPEED_MPS,
    radial: bool = False,
) -> Free:
    """A wheel driven without pull: its slip and the torque it takes.

    Arguments and errors as for `wheel`. NaN both where the wheel digs in: its thrust does not
    overcome its resistance at any slip.
    """
    points = _points(0.0, 0.0, load_n)
    found = _free(tyre, soil, points, speed_mps, radial, held=("across", "spin"))
    runs = np.abs(found.slip) <= MOST_SLIP
    return dataclasses.replace(
        found,
        slip=np.where(runs, found.slip, np.nan),
        axle_torque_nm=np.where(runs, found.axle_torque_nm, np.nan),
    )


def _free(
    tyre: Tyre,
    soil: Soil,
    points: tuple[Array, Array, Array],
    speed_mps: float,
    radial: bool,
    held: tuple[str, ...],
) -> Free:
    sizes, (_, angle, load) = tyre.sizes(), points
    check_range("speed_mps", speed_mps, 0.2, 10.0)
    _check_load(load, sizes)
    model = stand(sizes, soil, float(load.max()), radial=radial, held=held)
    roll, side = speed_mps * np.cos(angle), -speed_mps * np.sin(angle)
    out = steady(model, sizes, load, {"along": roll, "across": side, "spin": roll})
    nothing = np.zeros(load.shape)
    return Free(
        slip=out["slip"],
        slip_angle_rad=out["slip_angle_rad"],
        load_n=load,
        net_pull_n=-out.get("along", nothing),
        axle_torque_nm=out.get("spin", nothing),
        lateral_n=-out["across"],
        rolling_radius_m=out["rolling_radius_m"],
        sinkage_m=out["sinkage_m"],
    )


def _points(*values: ArrayLike) -> tuple[Array, Array, Array]:
    """Slip, slip angle and load as flat arrays of one length. Shape (n,) each."""
    arrays = [np.asarray(v, dtype=np.float64) for v in values]
    try:
        s, angle, load = (a.ravel() for a in np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(str(a.shape) for a in arrays)
        raise BadInput(f"slip, slip angle and load have shapes {shapes}, not one shape") from None
    if not s.size:
        raise BadInput("the rig has no points; give at least one slip")
    for value in s:
        check_range("slip", float(value), -MOST_SLIP, MOST_SLIP)
    for value in angle:
        check_range("slip_angle_deg", math.degrees(value), -80.0, 80.0)
    return s, angle, load


def _check_load(load_n: Array, sizes: Mapping[Wheel, float]) -> None:
    for value in load_n:
        check_range("load_n", float(value), 5.0, 2e5)
    most_n = MOST_DEFLECTION * 0.5 * sizes[Wheel.DIAMETER_M] * sizes[Wheel.STIFFNESS_NPM]
    if load_n.max() > most_n:
        raise BadInput(
            f"load_n = {load_n.max():g} would press this tyre onto its rim; "
            f"up to {most_n:.0f} N, or a stiffer tyre, would do"
        )
