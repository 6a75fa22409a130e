"""The uneven ground: its spectrum, and a tractor on a tilted map beside one on a tilted plane."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from twin.physics.block import WheelSlot
from twin.rig.tractor import tractor
from twin.scenario import Field, Soil
from twin.scenario.field import ROUGHNESS
from twin.terrain.random import CELL_M, rough_heights
from twin.validate.by_hand import parked, wheels
from twin.validate.check import Basis, Check, near

Array = NDArray[np.float64]

OCTAVES = (0.03, 0.06, 0.12, 0.24)
"""Lower ends, in cycles per metre; the ground's waves are 0.8 to 50 m long."""
SEEDS, NODES = 4, 2048
TILT_DEG = 6.0


def spectrum() -> list[Check]:
    """Spectrum of the height field along its lines, by octave."""
    lines = [
        rough_heights("C", (NODES, NODES), np.random.default_rng(seed))[::50]
        for seed in range(SEEDS)
    ]
    n, density = welch(np.concatenate(lines), 1.0 / CELL_M, nperseg=NODES, detrend=False)
    mean = density.mean(axis=0)
    out = []
    for low in OCTAVES:
        band = (n >= low) & (n < 2.0 * low)
        found = 1e6 * float(mean[band].mean())
        wanted = 1e6 * float(np.mean(ROUGHNESS["C"] * (n[band] / 0.1) ** -2.0))
        out.append(
            near(
                f"height field of class C, {low:g} to {2.0 * low:g} cycles/m",
                "G_d",
                found,
                "cm3",
                wanted,
                relative=0.1,
                basis=Basis(
                    grade="assumed",
                    source="ISO 8608: G_d(n) = G_d(n0) (n / n0)**-2, mean of the class from memory",
                    why="a class spans a factor of 4; a tenth is the scatter of four fields",
                ),
            )
        )
    return out


def tilted_map() -> list[Check]:
    """Wheel loads on a map that is tilted, against those on a plane that is."""
    tilt = math.tan(math.radians(TILT_DEG))
    across, _ = np.mgrid[-40:41, -40:81] * 0.25
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "tilted.npy"
        np.save(file, tilt * across)
        map_n = _loads_n(Field(height_map=str(file), map_cell_m=0.25, map_start_m=-10.0))
    plane_n = _loads_n(Field(cross_slope_deg=TILT_DEG))
    names = ("front left", "front right", "rear left", "rear right")
    return [
        near(
            f"parked on a map tilted by {TILT_DEG:g} deg",
            f"load, {name}",
            1e-3 * ours,
            "kN",
            1e-3 * wanted,
            relative=0.01,
            basis=Basis(
                grade="derived",
                source="the same on a tilted plane",
                why="each tyre touches the map, and the plane, at one point",
            ),
        )
        for name, ours, wanted in zip(names, map_n, plane_n, strict=True)
    ]


def _loads_n(shape: Field) -> Array:
    return wheels(parked(tractor("validate-terrain", Soil(), shape)))[:, WheelSlot.LOAD_N]
