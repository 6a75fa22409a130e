"""The motion across the body, and what measures it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.bounds.model import Model
from estimators.bounds.motion import ORDER, autoregression
from estimators.bounds.noises import EXACT, camera_var, frames_seen, late_steps, period_s
from estimators.riccati import System
from twin.streams import Setup, Streams, Table

GYRO_BIAS_PSD = 1e-12
"""Of a bias that is all but constant [rad2/s3]."""


def across_body(
    setup: Setup, streams: Streams, part: Table, step_s: float, drives: NDArray[np.bool_]
) -> Model | None:
    """The motion across the body, by GNSS, gyro and camera; None where none of them measures it.

    States: past increments of v_y, how far the heading is off the gyro's integral, and the gyro's
    bias, v_y now and before, each as many steps back as GNSS and camera are late. Without a gyro
    a past heading says nothing of the present one: its walk is as wide as a circle.
    """
    if "v_y_rear_mps" not in part:
        return None
    v_y = np.asarray(part["v_y_rear_mps"], np.float64)
    speed = float(np.mean(np.abs(part["speed_mps"][drives])))
    gnss = setup.gnss is not None and "heading_rad" in streams.tables.get("gnss", {})
    camera = frames_seen(streams, "v_y_mps") > 1
    if not gnss and not camera:
        return None
    late = {s: late_steps(streams, s, step_s) for s in ("gnss", "camera")}
    past = max(*late.values(), 1)
    weights, noise = autoregression(np.diff(v_y)[:, None], drives)
    bias, off, now = ORDER, ORDER + 1, ORDER + 2 + past  # off and its past, then v_y and its past
    size = now + past + 1
    f, q = np.zeros((size, size)), np.zeros((size, size))
    f[0, :ORDER], q[0, 0] = weights[0], noise[0, 0]
    f[1:ORDER, : ORDER - 1] = np.eye(ORDER - 1)
    f[now, :ORDER], f[now, now] = weights[0], 1.0
    q[now, now] = q[0, now] = q[now, 0] = noise[0, 0]
    for first in (off, now):
        f[first + 1 : first + 1 + past, first : first + past] = np.eye(past)
    if setup.imu is not None and "gyro_z_radps" in streams.tables.get("imu", {}):
        f[off, off], f[off, bias], f[bias, bias] = 1.0, step_s, 1.0
        q[off, off] = setup.imu.gyro_noise_radps_rthz**2 * step_s
        q[bias, bias] = GYRO_BIAS_PSD * step_s
    else:
        q[off, off] = np.pi**2
    rows, variances, of = [], [], []
    if gnss and setup.gnss is not None:
        per_step, ago = step_s / period_s(streams, "gnss"), late["gnss"]
        for at, sd in (
            ({off + ago: 1.0}, setup.gnss.heading_sd_rad),
            ({off + ago: speed, now + ago: 1.0}, setup.gnss.velocity_sd_mps),
        ):
            rows.append([at.get(i, 0.0) for i in range(size)])
            variances.append(max(sd**2 / per_step, EXACT))
            of.append("gnss")
    if camera:
        rows.append([float(i == now + late["camera"]) for i in range(size)])
        variances.append(camera_var(streams, "var_y_m2ps2", step_s))
        of.append("camera")
    system = System(
        transition=f, process=q + np.eye(size) * 1e-14,
        rows=np.array(rows), variances=np.array(variances),
    )  # fmt: skip
    return Model(system=system, of=of, at={"v_y": now})
