"""Nominal dimensions of a machine, as a tape measure and the manual give them."""

from __future__ import annotations

from twin.machine.build import Machine
from twin.machine.zero_slip import radius_factors
from twin.physics import block
from twin.sensors import Geometry

ORIGIN = (36.17, 117.16, 130.0)
"""Where the world's origin lies: latitude, longitude [deg], height [m]; near Taian, assumed."""


def geometry(machine: Machine) -> Geometry:
    """Nominal dimensions of a machine, which estimators get in the set-up of a run."""
    model, numbers = machine.model, machine.numbers
    sites = {}
    for name in ("gnss_main", "gnss_aux", "imu", "cg"):
        x, y, z = (float(p) for p in model.site(name).pos)
        sites[name] = (x, y, z)
    plough = machine.scenario.plough is not None
    laser_above_sole_m = 0.0
    if plough:
        laser_m = float(model.site("plough.depth_laser").pos[2])
        laser_above_sole_m = numbers["plough.sole_below_hitch_m"] + laser_m
    factors = radius_factors(machine.scenario, model.numeric_data[-block.SIZE :]).tolist()
    all_wheels = machine.scenario.drive.all_wheel_drive
    return Geometry(
        machine=machine.scenario.machine_file.name,
        wheelbase_m=float(model.body("front_axle").pos[0]),
        track_front_m=2.0 * float(model.body("fl_knuckle").pos[1]),
        track_rear_m=2.0 * float(model.body("rl_wheel").pos[1]),
        cg_x_m=sites["cg"][0],
        wheel_radius_m={
            w: factor
            * numbers[f"tyre_{'front' if w[0] == 'f' else 'rear'}.nominal_rolling_radius_m"]
            for w, factor in zip(block.WHEELS, factors, strict=True)
        },
        zero_slip=machine.scenario.zero_slip,
        antenna_main_m=sites["gnss_main"],
        antenna_aux_m=sites["gnss_aux"],
        imu_m=sites["imu"],
        depth_zero_m=laser_above_sole_m,
        driven=("fl", "fr", "rl", "rr") if all_wheels else ("rl", "rr"),
        origin=ORIGIN,
    )
