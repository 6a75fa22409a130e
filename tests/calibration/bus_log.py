"""A made-up log of a tractor's bus: passes under load in one gear, a turn after each, at 1 Hz."""

import numpy as np

RATED_RADPS, REFERENCE_NM, EFFICIENCY, RPM_PER_KMH = 2100.0 * np.pi / 30.0, 680.0, 0.87, 230.0
MAP = """
[log]
time = {column = "t", unit = "s"}
[gnss]
east = {column = "x", unit = "m"}
north = {column = "y", unit = "m"}
v_east = {column = "v", unit = "m/s"}
v_north = {column = "y", unit = "m/s"}
[wheels]
driven_speed = {column = "wheel_kmh", unit = "km/h"}
[machine]
engine_speed = {column = "rpm", unit = "rpm"}
engine_torque = {column = "torque_pct", unit = "%"}
[rows]
state = {column = "state"}
[steady]
where = {state = ["W"]}
min_speed_kmh = 2.5
[setup]
machine = "a tractor"
wheelbase_m = 2.8
[setup.gnss]
velocity_sd_mps = 0.03
"""


def slip_at(force_n):
    """The law that the log is made with: 3.2 % of slip for each 10 kN at the rims."""
    return 3.2e-6 * force_n


def bus_log(duration_s=1500, seed=1):
    """Columns of the log: passes of 100 s, whose torque walks from 45 to 85 %, turns of 20 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(float(duration_s))
    working = t % 120 < 100
    level = 0.65 + 0.2 * np.sin(t // 120 * 1.7) + 0.02 * np.sin(0.05 * t)
    torque = np.where(working, level, 0.25)
    rpm = 2050.0 - 250.0 * torque + rng.normal(0.0, 1.0, len(t))
    wheel_mps = rpm / RPM_PER_KMH / 3.6
    force_n = REFERENCE_NM * torque * EFFICIENCY * rpm * np.pi / 30.0 / wheel_mps
    v = wheel_mps * (1.0 - slip_at(force_n)) + rng.normal(0.0, 0.01, len(t))
    return {"t": t, "x": np.cumsum(v), "y": 0.0 * t, "v": v, "wheel_kmh": 3.6 * wheel_mps,
            "rpm": rpm, "torque_pct": 100.0 * torque,
            "state": np.where(working, "W", "T")}  # fmt: skip


def write(folder, columns, column_map=MAP):
    """drive.csv and drive.toml; gives the arguments of the command."""
    rows = zip(*(np.asarray(c).tolist() for c in columns.values()), strict=True)
    text = "\n".join([",".join(columns), *(",".join(map(str, row)) for row in rows)])
    (folder / "drive.csv").write_text(text + "\n", encoding="utf-8")
    (folder / "drive.toml").write_text(column_map, encoding="utf-8")
    return [str(folder / "drive.csv"), "--map", str(folder / "drive.toml")]
