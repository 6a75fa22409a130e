"""Where everything is in a recording: entity paths, timelines, colours of the scene."""

from __future__ import annotations

APPLICATION = "tractor-twin"
SIM_TIME, STEP = "sim_time", "step"

WORLD = "world"
TRACTOR = "world/truth/tractor"
PATH = "world/truth/path"
FURROW = "world/truth/furrow"
FOLLOW = "world/truth/follow"
GROUND = "world/ground"
GNSS = "world/sensors/gnss"
MAP = "map/gnss"
SLIP, SPEED, SIDESLIP, DRAFT, DEPTH = (
    "plots/slip", "plots/speed", "plots/sideslip", "plots/draft", "plots/depth",
)  # fmt: skip

DARK, SKY, ORANGE = [22, 23, 26], [214, 226, 235], [230, 159, 0]
TRUTH_COLOUR = "#F5F5F5"
"""Truth is white here, on plots that are dark whatever the viewer's theme."""
