"""Where everything is in a recording: entity paths, timelines, colours of the scene."""

from __future__ import annotations

APPLICATION = "tractor-twin"
SIM_TIME, STEP = "sim_time", "step"

WORLD = "world"
TRACTOR = "world/truth/tractor"
PATH = "world/truth/path"
NO_SIDESLIP = "world/truth/no_sideslip"
FURROW, LAND = "world/truth/furrow", "world/truth/land"
FOLLOW = "world/truth/follow"
FORCES = "world/forces"
ESTIMATES = "world/estimates"
GROUND = "world/ground"
GNSS = "world/sensors/gnss"
CAMERA = "camera"
MAP = "map/gnss"
EVENTS = "events"
SLIP, SPEED, SIDESLIP, DRAFT, DEPTH = (
    "plots/slip", "plots/speed", "plots/sideslip", "plots/draft", "plots/depth",
)  # fmt: skip
ACTIONS, REWARD = "plots/actions", "plots/reward"
WHEELS, LOADS, POWER = "plots/wheel_slip", "plots/wheel_load", "plots/power"
SENSED_SPEED, FIX, GYRO, ACCELERATION, SENSED_DEPTH = (
    "sensors/speed", "sensors/fix", "sensors/gyro", "sensors/acceleration", "sensors/depth",
)  # fmt: skip

DARK, SKY, ORANGE = [22, 23, 26], [214, 226, 235], [230, 159, 0]
TRUTH_COLOUR = "#F5F5F5"
"""Truth is white here, on plots that are dark whatever the viewer's theme."""
