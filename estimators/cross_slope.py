"""The sideslip chains of Liu et al. (2023), as printed and put right: baselines of one experiment.

They are for a run along the contour of a plane whose slope is known, on the whole log at once.

Source: Liu et al., Transactions of the Chinese Society for Agricultural Machinery 54(S2), 2023,
equations (11)-(16) and the section on adaptive fusion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.layout import FIXED, STALE_S
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

WEIGHTS = {4: 1.0, 5: 0.1, 1: 0.01, 0: 0.01}
"""Weight by NMEA quality; the paper names the inputs of its W and not its form."""
FULL_SATELLITES = 12.0
SLIDE_PSD, ACCEL_PSD = 0.0, 1e-3
SLIDE_SD_M, SPEED_SD_MPS = 0.01, 0.02
"""Q and R of the fusion, which the paper does not give."""


@dataclass(frozen=True, kw_only=True)
class GnssChain:
    """Slide from GNSS velocity, equations (11)-(13).

        V_x1 = V_e,  V_y1 = V_n / cos(slope),  V_y2 = V_y1 cos(b) - V_x1 sin(b),  S = integral V_y2

    As printed b is the course atan2(V_y1, V_x1), so that V_y2 is zero whatever the vehicle does.
    Put right it is the heading, carried by the gyro where there is none, and V_y2 is brought from
    the antenna to the centre of gravity.
    """

    offline: ClassVar[bool] = True

    slope_deg: float
    printed: bool = False

    def init(self, setup: Setup) -> Setup:
        """All it needs is the set-up."""
        return setup

    def run(self, state: Setup, chunk: Streams) -> tuple[Setup, Table]:
        """The slide at each GNSS sample."""
        gnss = chunk["gnss"]
        epoch_ns, ahead = gnss["epoch_ns"], gnss["v_east_mps"]
        left = gnss["v_north_mps"] / math.cos(math.radians(self.slope_deg))
        if self.printed:
            angle, arm = np.arctan2(left, ahead), 0.0
        else:
            angle = self._heading(state, chunk)
            arm = (state.gnss.lever_arm_m[0] if state.gnss else 0.0) - state.cg_x_m
        aside = left * np.cos(angle) - ahead * np.sin(angle) - arm * turning(chunk, epoch_ns)
        return state, {"epoch_ns": epoch_ns, "sideslip_m": integral(epoch_ns, aside)}

    def _heading(self, setup: Setup, chunk: Streams) -> Array:
        """In the plane: tan(heading) = tan(azimuth) / cos(slope), of the baseline."""
        gnss = chunk["gnss"]
        mount = setup.gnss.heading_mount_rad if setup.gnss else 0.0
        azimuth = gnss["heading_rad"]
        flat = math.cos(math.radians(self.slope_deg))
        across = np.arctan2(np.sin(azimuth) / flat, np.cos(azimuth)) - mount
        turned = integral(gnss["epoch_ns"], turning(chunk, gnss["epoch_ns"]))
        offset = np.angle(np.exp(1j * (across - turned)))
        known = np.isfinite(offset)
        if not known.any():
            return np.full(len(turned), np.nan)
        carried = turned + offset[known].mean()
        return np.where(known, across, carried)


@dataclass(frozen=True, kw_only=True)
class WeightedFusion:
    """Kalman filter on x = [S, v_y], z = [S of the GNSS chain, v_y of the camera].

    Where the position is fixed the paper does not fuse and takes GNSS. Elsewhere its weight W
    multiplies Q and R alike ("both"), which changes no gain; "sensor" divides R alone.
    """

    offline: ClassVar[bool] = True

    slope_deg: float
    weight: str = "both"
    """none, both or sensor."""

    def init(self, setup: Setup) -> Setup:
        """All it needs is the set-up."""
        return setup

    def run(self, state: Setup, chunk: Streams) -> tuple[Setup, Table]:
        """The slide at each GNSS sample."""
        _, chain = GnssChain(slope_deg=self.slope_deg).run(state, chunk)
        gnss = chunk["gnss"]
        seen_ns, v_y = camera_speed(state, chunk)
        x, p = np.zeros(2), np.diag([1e-6, 1e-2])
        now_ns, row, slides = int(chain["epoch_ns"][0]), 0, []
        for k, epoch_ns in enumerate(chain["epoch_ns"]):
            weight = self._weight(gnss, k)
            while row < len(seen_ns) and seen_ns[row] <= epoch_ns:
                x, p = self._predicted(x, p, (seen_ns[row] - now_ns) * 1e-9, weight)
                x, p = self._taken(x, p, 1, v_y[row], SPEED_SD_MPS, weight, 1.0)
                now_ns, row = int(seen_ns[row]), row + 1
            x, p = self._predicted(x, p, (int(epoch_ns) - now_ns) * 1e-9, weight)
            now_ns = int(epoch_ns)
            if gnss["quality"][k] == FIXED:
                x[0] = chain["sideslip_m"][k]
            elif np.isfinite(chain["sideslip_m"][k]):
                measured = float(chain["sideslip_m"][k])
                x, p = self._taken(x, p, 0, measured, SLIDE_SD_M, weight, weight)
            slides.append(x[0])
        return state, {"epoch_ns": chain["epoch_ns"], "sideslip_m": np.array(slides)}

    def _weight(self, gnss: Table, row: int) -> float:
        satellites = min(1.0, float(gnss["satellites_main"][row]) / FULL_SATELLITES)
        return max(WEIGHTS[int(gnss["quality"][row])] * satellites, 1e-3)

    def _predicted(self, x: Array, p: Array, dt: float, weight: float) -> tuple[Array, Array]:
        f = np.array([[1.0, dt], [0.0, 1.0]])
        q = dt * np.diag([SLIDE_PSD, ACCEL_PSD]) * (weight if self.weight == "both" else 1.0)
        return f @ x, f @ p @ f.T + q

    def _taken(
        self, x: Array, p: Array, i: int, z: float, sd: float, both: float, own: float
    ) -> tuple[Array, Array]:
        factor = {"none": 1.0, "both": both, "sensor": 1.0 / own}[self.weight]
        gain = p[:, i] / (p[i, i] + factor * sd * sd)
        return x + gain * (z - x[i]), p - np.outer(gain, p[i])


@dataclass(frozen=True, kw_only=True)
class CameraChain:
    """Slide as the integral of the camera's lateral speed, brought to the centre of gravity."""

    offline: ClassVar[bool] = True

    def init(self, setup: Setup) -> Setup:
        """All it needs is the set-up."""
        return setup

    def run(self, state: Setup, chunk: Streams) -> tuple[Setup, Table]:
        """The slide at each frame that was used."""
        epoch_ns, v_y = camera_speed(state, chunk)
        return state, {"epoch_ns": epoch_ns, "sideslip_m": integral(epoch_ns, v_y)}


def camera_speed(setup: Setup, chunk: Streams) -> tuple[NDArray[np.int64], Array]:
    """Epochs of the frames that were used, and lateral speed of the centre of gravity there."""
    camera = chunk["camera"]
    used = np.asarray(camera["used"], bool)
    epoch_ns = camera["epoch_ns"][used]
    arm = (setup.camera.lever_arm_m[0] if setup.camera else 0.0) - setup.cg_x_m
    return epoch_ns, camera["v_y_mps"][used] - arm * turning(chunk, epoch_ns)


def turning(chunk: Streams, epoch_ns: NDArray[np.int64]) -> Array:
    """The gyro's yaw rate at other epochs."""
    imu = chunk["imu"]
    own = (imu["epoch_ns"] - epoch_ns[0]).astype(np.float64)
    at: Array = np.interp((epoch_ns - epoch_ns[0]).astype(np.float64), own, imu["gyro_z_radps"])
    return at


def integral(epoch_ns: NDArray[np.int64], rate: Array) -> Array:
    """Trapezoids from the first epoch on; nothing over a gap, nothing beside a NaN."""
    dt = np.diff(epoch_ns) * 1e-9
    steps = np.where(dt < STALE_S, 0.5 * (rate[1:] + rate[:-1]) * dt, 0.0)
    return np.concatenate([[0.0], np.cumsum(np.nan_to_num(steps))])
