"""What a column of a log can be: sections and keys of a column map, with the plausible range."""

from __future__ import annotations

import math
from dataclasses import dataclass

from twin.streams import WHEELS


@dataclass(frozen=True)
class Quantity:
    """A quantity that a column can measure, with its plausible range."""

    dimension: str
    """Key of UNITS."""
    column: str
    """Column of the stream it becomes, or a name the gnss builder works on."""
    low: float = -math.inf
    """Least plausible value, SI."""
    high: float = math.inf
    """Greatest plausible value, SI."""


_TURN = 2.0 * math.pi

GNSS = {
    "latitude": Quantity("angle", "latitude_rad", -math.pi / 2, math.pi / 2),
    "longitude": Quantity("angle", "longitude_rad", -math.pi, _TURN),
    "height": Quantity("length", "height_m", -500.0, 9000.0),
    "east": Quantity("length", "east_m", -1e5, 1e5),
    "north": Quantity("length", "north_m", -1e5, 1e5),
    "up": Quantity("length", "up_m", -1e4, 1e4),
    "speed": Quantity("speed", "speed_mps"),
    "course": Quantity("angle", "course_rad", -2 * _TURN, 2 * _TURN),
    "heading": Quantity("angle", "heading_rad", -2 * _TURN, 2 * _TURN),
    "v_east": Quantity("speed", "v_east_mps"),
    "v_north": Quantity("speed", "v_north_mps"),
    "v_up": Quantity("speed", "v_up_mps"),
    "v_forward": Quantity("speed", "v_forward_mps"),
    "v_left": Quantity("speed", "v_left_mps"),
    "quality": Quantity("count", "quality", 0, 8),
    "satellites": Quantity("count", "satellites_main", 0, 200),
    "satellites_aux": Quantity("count", "satellites_aux", 0, 200),
    "position_sd": Quantity("length", "position_sd_m", 0.0, 1e5),
    "velocity_sd": Quantity("speed", "velocity_sd_mps", 0.0),
    "heading_sd": Quantity("angle", "heading_sd_rad", 0.0, _TURN),
}

QUANTITIES: dict[str, dict[str, Quantity]] = {
    "gnss": GNSS,
    "imu": {
        **{f"gyro_{a}": Quantity("angular rate", f"gyro_{a}_radps", -40, 40) for a in "xyz"},
        **{f"accel_{a}": Quantity("acceleration", f"accel_{a}_mps2", -500, 500) for a in "xyz"},
    },
    "wheels": {
        "driven_speed": Quantity("speed", "driven_speed_mps"),
        **{f"speed_{w}": Quantity("speed", f"speed_{w}_mps") for w in WHEELS},
        **{f"ticks_{w}": Quantity("count", f"ticks_{w}", -(2.0**53), 2.0**53) for w in WHEELS},
        **{f"accel_{w}": Quantity("acceleration", f"accel_{w}_mps2", -500, 500) for w in WHEELS},
        "speed_sd": Quantity("speed", "speed_sd_mps", 0.0),
        "direction": Quantity("count", "direction", -16.0, 16.0),
    },
    "depth": {
        "laser": Quantity("length", "laser_m", 0.0, 100.0),
        "inclination": Quantity("angle", "inclination_rad", -math.pi, math.pi),
    },
    "machine": {
        "steer": Quantity("angle", "steer_rad", -math.pi, math.pi),
        "hitch": Quantity("length", "hitch_m", -5.0, 5.0),
        "draft_pin": Quantity("force", "draft_pin_n", -1e6, 1e6),
        "axle_torque": Quantity("torque", "axle_torque_nm", -1e6, 1e6),
        "engine_speed": Quantity("angular rate", "engine_radps", 0.0, 1000.0),
        "engine_load": Quantity("ratio", "engine_load", 0.0, 2.5),
        "engine_torque": Quantity("ratio", "engine_torque", -1.25, 1.25),
        "fuel_rate": Quantity("fuel rate", "fuel_lph", 0.0, 1000.0),
    },
    "reference": {
        "slip": Quantity("ratio", "slip", -2.0, 2.0),
        "speed": Quantity("speed", "speed_mps"),
        "wheel_speed": Quantity("speed", "wheel_speed_mps"),
        "sideslip_angle": Quantity("angle", "sideslip_rad", -math.pi, math.pi),
        "sideslip_amount": Quantity("length", "sideslip_m", -1e4, 1e4),
    },
}
"""Section -> key -> quantity. Speeds are held to 50 km/h at the median and 100 km/h anywhere
instead of a range, or to what the map says. Engine load reaches 250 % in SAE J1939 (SPN 92)."""
