"""A made-up 20 s run: smooth truth, streams, two estimators' tables, and a small tractor model."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from twin.errors import check_range
from twin.io.run_folder import Record
from twin.streams import WHEELS, GnssSetup, Setup, Streams, Table, WheelsSetup


@dataclass(frozen=True, kw_only=True)
class Soil:
    preset: Literal["firm", "tilled", "soft"] = "firm"
    friction: float = 0.6

    def __post_init__(self) -> None:
        check_range("soil.friction", self.friction, 0.05, 1.5)


@dataclass(frozen=True, kw_only=True)
class Field:
    cross_slope_deg: float = 0.0

    def __post_init__(self) -> None:
        check_range("field.cross_slope_deg", self.cross_slope_deg, -30.0, 30.0)


@dataclass(frozen=True, kw_only=True)
class Plough:
    depth_m: float = 0.25
    offsets_m: tuple[float, ...] = (0.0, 0.35)

    def __post_init__(self) -> None:
        check_range("plough.depth_m", self.depth_m, 0.0, 0.4)


@dataclass(frozen=True, kw_only=True)
class Course:
    edge_m: float | None = None


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A short furrow on firm soil."""

    name: str = "stub"
    about: str = "a short furrow on firm soil"
    machine: str = "taishan_1404a"
    seed: int = 1
    soil: Soil = field(default_factory=Soil)
    field: Field = dataclasses.field(default_factory=Field)
    plough: Plough | None = dataclasses.field(default_factory=Plough)
    course: Course = dataclasses.field(default_factory=Course)
    length_m: float = 20.0

    def __post_init__(self) -> None:
        check_range("length_m", self.length_m, 1.0, 2000.0)


STUB = Scenario()

SETUP = Setup(
    machine="taishan_1404a",
    wheelbase_m=2.55,
    track_front_m=1.6,
    track_rear_m=1.6,
    cg_x_m=1.0,
    wheels=WheelsSetup(rate_hz=50.0, radius_m={"fl": 0.6, "fr": 0.6, "rl": 0.8, "rr": 0.8}),
    gnss=GnssSetup(
        rate_hz=20.0,
        lever_arm_m=(1.0, 0.0, 2.6),
        position_sd_m=0.01,
        velocity_sd_mps=0.03,
        heading_sd_rad=0.002,
    ),
)

MJCF = """
<mujoco>
  <custom><numeric name="plough.body_width_m" data="0.45"/></custom>
  <default>
    <default class="visual"><geom group="2" contype="0" conaffinity="0"/></default>
    <default class="wheel"><geom group="2" type="cylinder" euler="90 0 0" rgba="0 0 0 1"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="50 50 1"/>
    <body name="tractor" pos="0 0 0.8">
      <freejoint/>
      <geom class="visual" type="box" size="1.6 0.35 0.35" pos="1.3 0 0.4" rgba=".7 .1 .1 1"/>
      <geom class="visual" type="capsule" size="0.08" fromto="2 .2 .7 2 .2 1.6" rgba=".2 .2 .2 1"/>
      <geom class="visual" type="box" size="0.6 0.6 0.5" pos="0.2 0 1.4" rgba=".3 .5 .7 1"/>
      <body name="rear_left" pos="0 0.8 0">
        <joint name="rl_spin" axis="0 1 0"/>
        <geom class="wheel" size="0.8 0.25" />
      </body>
      <body name="rear_right" pos="0 -0.8 0">
        <joint name="rr_spin" axis="0 1 0"/>
        <geom class="wheel" size="0.8 0.25" />
      </body>
      <body name="front_left" pos="2.55 0.8 -0.2">
        <joint name="fl_steer" axis="0 0 1"/>
        <joint name="fl_spin" axis="0 1 0"/>
        <geom class="wheel" size="0.6 0.18" mass="90"/>
      </body>
      <body name="plough" pos="-1 0 0">
        <joint name="lift" axis="0 1 0"/>
        <geom class="visual" type="box" size="1.5 0.06 0.06" pos="-1.5 0 0" rgba=".1 .3 .6 1"/>
        <geom class="visual" type="sphere" size="0.15" pos="-2 0 -0.3" rgba=".1 .3 .6 1"/>
        <site name="plough.share_1" pos="-1 -0.225 -0.8"/>
        <site name="plough.share_2" pos="-1.9 0.225 -0.8"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def truth_table(*, duration_s: float = 20.0, rate_hz: float = 50.0) -> Table:
    """Straight drive to the east at 1.5 m/s; the plough goes down at 5 s and is at depth at 6 s."""
    t = np.arange(round(duration_s * rate_hz) + 1) / rate_hz
    speed = np.full_like(t, 1.5)
    down = np.clip(t - 5.0, 0.0, 1.0)
    slip = 0.01 + 0.09 * down + 0.01 * np.sin(t) * down
    v_y = 0.02 * down
    zero = np.zeros_like(t)
    return {
        "epoch_ns": (t * 1e9).round().astype(np.int64),
        "east_m": 1.5 * t,
        "north_m": np.cumsum(v_y) / rate_hz,
        "up_m": np.full_like(t, 0.8),
        "qw": np.ones_like(t), "qx": zero, "qy": zero, "qz": zero,
        "v_x_rear_mps": speed, "v_x_mps": speed, "v_y_mps": v_y, "speed_mps": speed,
        "wheel_speed_mps": speed / (1.0 - slip),
        "slip": slip,
        "sideslip_rad": np.arctan2(v_y, speed),
        "sideslip_m": np.cumsum(v_y) / rate_hz,
        "draft_n": 18000.0 * down * (1.0 + 0.05 * np.sin(3.0 * t)),
        "depth_m": 0.25 * down,
        **{f"load_{wheel}_n": np.full_like(t, 13000.0) for wheel in WHEELS},
        **{f"shear_{wheel}_n": 4500.0 * down for wheel in WHEELS},
        "power_engine_w": 60e3 * down, "power_drawbar_w": 27e3 * down,
        "joint_rl_spin_rad": 1.5 * t / 0.8, "joint_rr_spin_rad": 1.5 * t / 0.8,
        "joint_lift_rad": 0.1 * (1.0 - down),
        "ploughing": down >= 1.0,
    }  # fmt: skip


def estimate_table(truth: Table, *, seed: int, slip_sd: float, every: int = 1) -> Table:
    """The truth with white noise of the stated standard deviation."""
    rng = np.random.default_rng(seed)
    rows = slice(None, None, every)
    n = len(truth["epoch_ns"][rows])
    return {
        "epoch_ns": truth["epoch_ns"][rows],
        "speed_mps": truth["speed_mps"][rows] + 0.02 * rng.standard_normal(n),
        "slip": truth["slip"][rows] + slip_sd * rng.standard_normal(n),
        "slip_sd": np.full(n, slip_sd),
        "sideslip_rad": truth["sideslip_rad"][rows] + 0.002 * rng.standard_normal(n),
        "sideslip_m": truth["sideslip_m"][rows] * 1.1,
    }


def streams(truth: Table) -> Streams:
    epoch = truth["epoch_ns"]
    wheels = {f"speed_{w}_mps": truth["wheel_speed_mps"] for w in ("rl", "rr")}
    gnss = {
        "epoch_ns": epoch[::5],
        "arrival_ns": epoch[::5] + 20_000_000,
        "east_m": truth["east_m"][::5],
        "north_m": truth["north_m"][::5],
        "v_east_mps": truth["speed_mps"][::5],
        "v_north_mps": truth["v_y_mps"][::5],
        "quality": np.full(len(epoch[::5]), 4),
    }
    return Streams({"gnss": gnss, "wheels": {"epoch_ns": epoch, "arrival_ns": epoch, **wheels}})


def synthetic_run(*, scenario: object = STUB, duration_s: float = 20.0) -> Record:
    truth = truth_table(duration_s=duration_s)
    raw = estimate_table(truth, seed=1, slip_sd=0.02, every=5)
    del raw["slip_sd"]
    return Record(
        scenario=scenario,
        setup=SETUP,
        streams=streams(truth),
        truth=truth,
        estimates={
            "raw_ratio": raw,
            "ekf4": estimate_table(truth, seed=2, slip_sd=0.005),
        },
        wall_s=0.5,
    )
