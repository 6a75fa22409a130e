"""The MJCF of a machine from the numbers of its file, made with mjSpec.

Bodies, joints, sites, actuators, sensors and numerics have the names that a hand-made MJCF has
(models/taishan_1404a), so the loader treats both alike.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from twin.io.plain import Plain
from twin.machine.looks import dress_machine, dress_wheel
from twin.physics.block import WHEELS
from twin.vehicle.derive import Derived, derive
from twin.vehicle.machine import Machine
from twin.vehicle.numerics import machine_numerics

UPRIGHT = [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0]
"""Quaternion that turns a cylinder's axis from z to y."""
BODY_BOX = (3.55, 1.20, 1.31)
"""Box with the body's inertia [m], for a wheelbase of 2.55 m, a track of 1.80 m, 1.755 m tyres."""
SENSORS: tuple[tuple[str, str, str, str], ...] = (
    ("actuatorfrc", "steer_left_nm", "actuator", "steer_left"),
    ("actuatorfrc", "steer_right_nm", "actuator", "steer_right"),
    ("jointvel", "fl_steer_radps", "joint", "fl_steer"),
    ("jointvel", "fr_steer_radps", "joint", "fr_steer"),
    ("framepos", "position_w", "site", "rear_axle"),
    ("framequat", "world_from_body", "site", "rear_axle"),
    ("framelinvel", "velocity_w", "site", "rear_axle"),
    ("gyro", "gyro_b", "site", "imu"),
    ("accelerometer", "imu_accel_b", "site", "imu"),
    ("framepos", "antenna_main_w", "site", "gnss_main"),
    ("framelinvel", "antenna_main_velocity_w", "site", "gnss_main"),
    ("framepos", "antenna_aux_w", "site", "gnss_aux"),
    ("framelinvel", "cg_velocity_w", "site", "cg"),
    *(("jointpos", f"{w}_angle_rad", "joint", f"{w}_spin") for w in WHEELS),
    *(("jointvel", f"{w}_rate_radps", "joint", f"{w}_spin") for w in WHEELS),
    ("jointvel", "drive_radps", "joint", "drive"),
    ("jointpos", "fl_steer_rad", "joint", "fl_steer"),
    ("jointpos", "fr_steer_rad", "joint", "fr_steer"),
    ("jointpos", "front_swing_rad", "joint", "front_swing"),
)
LINKAGE_SENSORS = (
    ("actuatorfrc", "lift_nm", "actuator", "lift"),
    ("jointvel", "lift_radps", "joint", "lift"),
    ("jointpos", "hitch_rad", "joint", "lift"),
)
IDLE = ("throttle", "clutch_pedal", "brake", "differential_lock", "front_drive")
"""Actuators without gain: only the laws of `twin.physics` read their controls."""


def machine_spec(machine: Machine) -> mujoco.MjSpec:
    """mujoco.MjSpec of a machine without implement and without ground."""
    n = derive(machine)
    spec = mujoco.MjSpec()
    spec.modelname = machine.name
    spec.compiler.degree = False
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    for name, value in machine_numerics(machine, n).items():
        spec.add_numeric(name=name, size=1, data=[value])
    tractor = spec.worldbody.add_body(name="tractor", pos=[0.0, 0.0, n["rear.height_m"]])
    tractor.add_freejoint(name="tractor")
    _front_axle(tractor, n)
    shaft = tractor.add_body(name="drive_shaft")
    shaft.add_joint(name="drive", axis=[0, 1, 0])
    _weigh(shaft, max(0.1, n["scale"]), [1e-3 * max(0.1, n["scale"])] * 3)
    for side, name in ((1.0, "rl"), (-1.0, "rr")):
        wheel = tractor.add_body(
            name=f"{name}_wheel", pos=[0.0, side * 0.5 * n["rear.track_m"], 0.0]
        )
        _wheel(wheel, name, "rear", n, machine)
    if machine.linkage.fitted:
        _lower_links(tractor, n)
    for weight in machine.ballast:
        hung = tractor.add_body(name=f"ballast.{weight.name}", pos=[weight.x_m, 0.0, weight.z_m])
        _weigh(hung, weight.mass_kg, [weight.mass_kg * k for k in (0.08, 0.02, 0.08)])
    _body(spec, tractor, machine, n)
    dress_machine(spec, tractor, machine, n)
    for wheel, axle, side in (("fl", "front", 1), ("fr", "front", -1), ("rl", "rear", 1),
                              ("rr", "rear", -1)):  # fmt: skip
        dress_wheel(spec, spec.body(f"{wheel}_wheel"), axle, side, machine, n)
    _actuators(spec, machine, n)
    wanted = (*(LINKAGE_SENSORS if machine.linkage.fitted else ()), *SENSORS)
    for kind, name, what, which in wanted:
        spec.add_sensor(
            name=name, type=getattr(mujoco.mjtSensor, f"mjSENS_{kind.upper()}"),
            objtype=getattr(mujoco.mjtObj, f"mjOBJ_{what.upper()}"), objname=which,
        )  # fmt: skip
    return spec


def _weigh(
    body: Plain, mass_kg: float, inertia: Sequence[float], at: Sequence[float] = (0.0, 0.0, 0.0)
) -> None:
    """Give a body its mass and the inertia about its axes."""
    body.mass, body.ipos, body.inertia = mass_kg, list(at), list(inertia)
    body.explicitinertial = True


def _front_axle(tractor: Plain, n: Derived) -> None:
    mass_kg = n["mass_kg"]
    scale, half_m = n["scale"], 0.5 * n["front.track_m"]
    axle = tractor.add_body(name="front_axle", pos=[n["wheelbase_m"], 0.0, n["front.hub_m"]])
    swing = n["chassis.swing_limit_rad"]
    axle.add_joint(
        name="front_swing", axis=[1, 0, 0], range=[-swing, swing], limited=1, damping=200.0 * scale
    )
    beam_kg = 0.042 * mass_kg
    across = beam_kg * (2.0 * half_m) ** 2 / 10.0
    _weigh(axle, beam_kg, [across, 0.12 * across, across])
    limit = n["chassis.steer_limit_rad"]
    for side, name in ((1.0, "fl"), (-1.0, "fr")):
        knuckle = axle.add_body(name=f"{name}_knuckle", pos=[0.0, side * half_m, 0.0])
        knuckle.add_joint(
            name=f"{name}_steer", axis=[0, 0, 1], range=[-limit, limit], limited=1,
            damping=200.0 * scale,
        )  # fmt: skip
        knuckle_kg = 0.0057 * mass_kg
        _weigh(knuckle, knuckle_kg, [knuckle_kg * (0.12 * n["front.diameter_m"]) ** 2] * 3)
        _wheel(knuckle.add_body(name=f"{name}_wheel"), name, "front", n, None)


def _wheel(body: Plain, name: str, axle: str, n: Derived, machine: Machine | None) -> None:
    """Spin, mass and the rim that plain MuJoCo rolls on."""
    radius_m, width_m, mass_kg = (
        0.5 * n[f"{axle}.diameter_m"], n[f"{axle}.width_m"], n[f"{axle}.wheel_kg"]
    )  # fmt: skip
    body.add_joint(name=f"{name}_spin", axis=[0, 1, 0], damping=2.0 * n["scale"])
    about = mass_kg * (0.72 * radius_m) ** 2
    _weigh(body, mass_kg, [0.55 * about, about, 0.55 * about])
    body.add_geom(
        name=f"{name}_tyre", type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius_m, 0.5 * width_m, 0.0], quat=UPRIGHT, contype=2, conaffinity=1, group=3,
        friction=[0.7, 0.02, 0.01], rgba=[0.1, 0.1, 0.1, 0.3], mass=0.0,
    )  # fmt: skip


def _lower_links(tractor: Plain, n: Derived) -> None:
    length_m, scale = n["linkage.lower_link_m"], n["scale"]
    links = tractor.add_body(
        name="lower_links",
        pos=[n["linkage.lower_pivot_x_m"], 0.0, n["linkage.lower_pivot_z_m"]],
    )
    links.add_joint(
        name="lift", axis=[0, 1, 0], range=[-0.45, 1.0], limited=1, damping=2000.0 * scale
    )
    mass_kg = 0.0114 * n["mass_kg"]
    about = mass_kg * length_m**2 / 10.0
    _weigh(links, mass_kg, [0.6 * about, about, 1.3 * about], (-0.53 * length_m, 0.0, 0.0))
    for side in (1.0, -1.0):
        links.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.034 * length_m, 0.0, 0.0],
            fromto=[0.0, side * 0.25 * length_m, 0.0, -length_m, side * 0.44 * length_m, 0.0],
            rgba=[0.36, 0.37, 0.39, 1.0], contype=0, conaffinity=0, group=2, mass=0.0,
        )  # fmt: skip
    links.add_frame(name="hitch", pos=[-length_m, 0.0, 0.0])
    tractor.add_site(
        name="top_link_front",
        pos=[n["linkage.top_pivot_x_m"], 0.0, n["linkage.top_pivot_z_m"]],
    )


def _body(spec: mujoco.MjSpec, tractor: Plain, machine: Machine, n: Derived) -> None:
    """What the other parts leave of mass and balance, the collision boxes, and the sites."""
    parts = [b for b in spec.bodies if b.name not in ("world", "tractor")]
    others_kg = sum(float(b.mass) for b in parts)
    total_kg, wheelbase_m = n["total_kg"], n["wheelbase_m"]
    hung_kg = sum(b.mass_kg for b in machine.ballast)
    own_kg = total_kg - others_kg
    rear_m = n["rear.height_m"]
    # the centre without ballast stands at its height; with it, the axles carry their loads
    bare = np.array([0.0, 0.0, n["cg_height_m"] - rear_m]) * (total_kg - hung_kg)
    moment = sum((np.array([b.x_m, 0.0, b.z_m]) * b.mass_kg for b in machine.ballast), bare)
    moment[0] = n["front_share"] * wheelbase_m * total_kg
    carried = sum((_place(b) * float(b.mass) for b in parts), np.zeros(3))
    centre = (moment - carried) / own_kg
    box = np.array(BODY_BOX) * (
        wheelbase_m / 2.55,
        n["rear.track_m"] / 1.80,
        n["rear.diameter_m"] / 1.755,
    )
    x, y, z = (box**2).tolist()
    _weigh(tractor, own_kg, [own_kg / 12.0 * s for s in (y + z, x + z, x + y)], centre.tolist())
    rear_r = 0.5 * n["rear.diameter_m"]
    collide: Plain = {
        "contype": 2, "conaffinity": 1, "group": 3, "rgba": [0.4, 0.5, 0.6, 0.3], "mass": 0.0,
        "type": mujoco.mjtGeom.mjGEOM_BOX,
    }  # fmt: skip
    hull = [0.59 * wheelbase_m, 0.194 * n["rear.track_m"], 0.4 * rear_r]
    tractor.add_geom(
        name="hull", size=hull, pos=[0.45 * wheelbase_m, 0.0, 0.17 * rear_r], **collide
    )
    top_m, floor_m = n["height_m"] - rear_m, 0.55 * rear_r
    if top_m - floor_m > 0.2:
        tractor.add_geom(
            name="cab", pos=[0.14 * wheelbase_m, 0.0, 0.5 * (top_m + floor_m)],
            size=[0.29 * wheelbase_m, 0.4 * n["rear.track_m"], 0.5 * (top_m - floor_m)], **collide,
        )  # fmt: skip
    tractor.add_site(name="rear_axle")
    tractor.add_site(name="cg", pos=(moment / total_kg).tolist())
    for name in ("imu", "gnss_main", "gnss_aux"):
        place = [n[f"places.{name}_m.{axis}"] for axis in "xyz"]
        tractor.add_site(name=name, pos=place)
    camera = [n[f"places.camera_m.{axis}"] for axis in "xyz"]
    tractor.add_site(name="camera", pos=camera, quat=[0.0, np.sqrt(0.5), -np.sqrt(0.5), 0.0])


def _place(body: Plain) -> np.ndarray:
    """Where a body's mass is, from the rear axle; all parts stand unturned."""
    place = np.array(body.ipos, dtype=np.float64)
    while body.name != "tractor":
        place = place + np.array(body.pos)
        body = body.parent
    return place


def _actuators(spec: mujoco.MjSpec, machine: Machine, n: Derived) -> None:
    joint, scale = mujoco.mjtTrn.mjTRN_JOINT, n["scale"]
    for name in IDLE:
        idle = spec.add_actuator(name=name, trntype=joint, target="drive")
        idle.ctrllimited, idle.ctrlrange, idle.gainprm = 1, [0.0, 1.0], [0.0] * 10
    limit = n["chassis.steer_limit_rad"] - 0.05
    for side, name in (("left", "fl_steer"), ("right", "fr_steer")):
        servo = spec.add_actuator(name=f"steer_{side}", trntype=joint, target=name)
        servo.set_to_position(kp=30e3 * scale, kv=3e3 * scale)
        servo.ctrllimited, servo.ctrlrange = 1, [-limit, limit]
        servo.forcelimited, servo.forcerange = 1, [-10e3 * scale, 10e3 * scale]
    if machine.linkage.fitted:
        lift = spec.add_actuator(name="lift", trntype=joint, target="lift")
        most_nm = n["linkage.lift_n"] * n["linkage.lower_link_m"]
        lift.set_to_position(kp=7.5 * most_nm, kv=0.75 * most_nm)
        lift.ctrllimited, lift.ctrlrange = 1, [-0.45, 1.0]
        lift.forcelimited, lift.forcerange = 1, [0.0, most_nm]
    if machine.engine.wheel_torque_nm is not None:
        most = machine.engine.wheel_torque_nm
        for side, name in (("left", "rl_spin"), ("right", "rr_spin")):
            motor = spec.add_actuator(name=f"torque_{side}", trntype=joint, target=name)
            motor.set_to_motor()
            motor.ctrllimited, motor.ctrlrange = 1, [-most, most]
