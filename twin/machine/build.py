"""Compile a scenario's machine: MJCF, ground, parameter block, working linkage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine import memory
from twin.machine.ground_frame import world_from_ground
from twin.machine.hitch import Hitch
from twin.machine.join import joined
from twin.machine.parameters import parameter_block, wheel_radii_m
from twin.machine.plough_setting import (
    Setting,
    by_geometry,
    furrow_roll_rad,
    levelled,
    mounted,
    set_plough,
)
from twin.machine.start import standing, unloaded_speed_mps, unsettled
from twin.machine.tanks import fit_tanks, refuse_overload
from twin.machine.turnover import turn_over
from twin.physics import block
from twin.physics.callback import install
from twin.scenario import Plough, Scenario
from twin.terrain.grid import GridMap
from twin.terrain.maps import ground_maps
from twin.terrain.place import add_envelopes, add_map, fill, show_heights

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Machine:
    """A compiled machine on its ground, ready to run."""

    scenario: Scenario
    model: mujoco.MjModel
    """mujoco.MjModel with the parameter block."""
    numbers: dict[str, float]
    """Values of the <numeric> elements of the machine's and the implement's MJCF, by name."""
    world_from_ground: Array
    """Rotation from the ground plane's frame to the world. Shape (3, 3)."""
    hitch: Hitch | None
    """None where there is no linkage."""
    work_rad: float
    """Lower-link angle at which the plough has its depth, if the tyres sink no further [rad]."""
    setting: Setting | None
    """Lever and depth-wheel setting of the plough; None without a plough."""
    start_qpos: Array
    """At the start of the course, the plough carried. Shape (nq,)."""
    start_act: Array
    """Activations at the start of the course, with the deflections of the tyres. Shape (na,)."""
    start_speed_mps: float
    start_load_n: Array
    """Load of each wheel at the start of the course, in the order of block.WHEELS. Shape (4,)."""
    maps: dict[str, GridMap]
    """Maps of the ground, if any: `heights` [m] and `mixture`, the share of the other soil."""

    @property
    def throttle(self) -> float:
        """Governor setting of the scenario, 0 at idle, 1 at full."""
        idle, top = self.numbers["engine.idle_rpm"], self.numbers["engine.no_load_rpm"]
        return (self.scenario.gear.set_rpm - idle) / (top - idle)


def assemble(
    scenario: Scenario,
    *,
    looks: bool = False,
    setting: Setting | None = None,
    find: Callable[[Setting], Setting] | None = None,
    dress: Callable[[mujoco.MjSpec], None] | None = None,
    maps: dict[str, GridMap] | None = None,
) -> Machine:
    """Compile the machine of a scenario, put it at the start of its course, and install the laws.

    MuJoCo's contact of the wheels is switched off, because the callback computes their forces.
    Visual geometry is left out, as it would nearly double the time of a step.

    Args:
        scenario: names machine, implement, ground and course.
        looks: keep the visual geometry.
        setting: lever and depth-wheel setting of the plough; None for `by_geometry`.
        find: where `setting` is None, computes the setting from that of `by_geometry`.
        dress: adds visual geometry to the specification before it is compiled.
        maps: of the ground; None for the scenario's.
    """
    install()
    spec, numbers = joined(scenario.machine_file, scenario.implement_file)
    for geom in (*(f"{w}_tyre" for w in block.WHEELS), "plough.depth_wheel_rim"):
        if (rim := spec.geom(geom)) is not None:
            rim.contype = rim.conaffinity = 0
    rotation = world_from_ground(scenario.field, scenario.course)
    maps = ground_maps(scenario) if maps is None else maps
    _add_ground(spec, rotation, maps, numbers)
    _add_activations(spec)
    if scenario.plough is not None:
        _fit_tractor(spec, scenario.plough, numbers)
        turn_over(spec, scenario.plough, numbers)
        spec.body("plough.frame").quat = levelled(furrow_roll_rad(scenario, spec))
    fit_tanks(spec, scenario.events, numbers)
    spec.option.timestep = scenario.timestep_s
    spec.add_sensor(name="potential_j", type=mujoco.mjtSensor.mjSENS_E_POTENTIAL)
    spec.add_sensor(name="kinetic_j", type=mujoco.mjtSensor.mjSENS_E_KINETIC)
    spec.nuserdata = block.RATE_SLOTS + _activation_count(spec)
    spec.add_numeric(name="tractor_twin", size=block.SIZE, data=[0.0] * block.SIZE)
    spec.compiler.discardvisual = not looks
    if dress is not None:
        dress(spec)
    model = spec.compile()
    refuse_overload(model, scenario.events)
    fill(model, maps, wheel_radii_m(numbers))
    hitch = _hitch(spec)
    reflected = numbers["engine.inertia_kgm2"] * scenario.gear.ratio**2
    model.dof_armature[model.joint("drive").dofadr[0]] = reflected
    model.numeric_data[-block.SIZE :] = parameter_block(scenario, model, numbers, rotation, maps)
    axle_height_m = model.body("tractor").pos[2]
    work_rad = 0.0
    if scenario.plough is not None and hitch is not None:
        if scenario.plough.furrow != "none":  # one side lower by the depth, the middle by half
            axle_height_m -= 0.5 * scenario.plough.depth_m
        plough, draft_scale = scenario.plough, scenario.expected_draft_scale
        here = mounted(
            model, plough, draft_scale, numbers, hitch, axle_height_m, scenario.deepest_m
        )
        work_rad = here.work_rad
        if setting is None:
            setting = by_geometry(here)
            setting = setting if find is None else find(setting)
        set_plough(model, here, setting)
    speed = unloaded_speed_mps(scenario, numbers)
    start = unsettled(
        model, standing(model, scenario, rotation, hitch, work_rad, maps.get("heights"))
    )
    return Machine(
        scenario, model, numbers, rotation, hitch, work_rad, setting, start.qpos, start.act, speed,
        start.load_n, maps,
    )  # fmt: skip


def _add_ground(
    spec: mujoco.MjSpec, rotation: Array, maps: dict[str, GridMap], numbers: dict[str, float]
) -> None:
    """The plane that catches what is not a wheel, below all heights; and the maps."""
    for name, grid in maps.items():
        add_map(spec, name, grid)
    lowest_m, heights = 0.0, maps.get("heights")
    if heights is not None:
        lowest_m = float(heights.nodes.min())
        show_heights(spec, heights, rotation, quaternion.from_matrix(rotation))
        add_envelopes(spec, heights, wheel_radii_m(numbers))
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        pos=lowest_m * rotation[:, 2],
        quat=quaternion.from_matrix(rotation),
        contype=1,
        conaffinity=2,
        rgba=[0.48, 0.40, 0.27, 1.0],
    )


def _fit_tractor(spec: mujoco.MjSpec, plough: Plough, numbers: dict[str, float]) -> None:
    """Weights on the tractor's front, which move its centre of gravity; the top link's hole."""
    spec.site("top_link_front").pos[2] -= plough.drop_m
    if plough.ballast_kg == 0.0:
        return
    place = np.array([numbers["front_ballast.x_m"], 0.0, numbers["front_ballast.z_m"]])
    tractor, centre = spec.body("tractor"), spec.site("cg")
    own_kg = sum(b.mass for b in spec.bodies if not b.name.startswith(("plough.", "world")))
    centre.pos = (own_kg * centre.pos + plough.ballast_kg * place) / (own_kg + plough.ballast_kg)
    inertia = plough.ballast_kg * np.array([0.08, 0.02, 0.08])  # a row 0.9 m wide
    tractor.add_body(
        name="front_ballast", pos=place, ipos=np.zeros(3), mass=plough.ballast_kg, inertia=inertia,
        explicitinertial=True,
    )  # fmt: skip


def _add_activations(spec: mujoco.MjSpec) -> None:
    """One actuator that moves nothing and holds what the laws remember: `twin.machine.memory`."""
    shares = sum(site.name.startswith("plough.share_") for site in spec.sites)
    spec.add_actuator(
        name=memory.ACTUATOR,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target="drive",
        dyntype=mujoco.mjtDyn.mjDYN_USER,
        actdim=len(memory.names(shares)),
        gainprm=[0.0] * 10,
    )


def _activation_count(spec: mujoco.MjSpec) -> int:
    """How many activations the model will have, those of its own actuators too."""
    none = mujoco.mjtDyn.mjDYN_NONE
    return sum(max(1, a.actdim) for a in spec.actuators if a.dyntype != none)


def _hitch(spec: mujoco.MjSpec) -> Hitch | None:
    if spec.body("lower_links") is None:
        return None
    links, frame = spec.body("lower_links"), spec.frame("hitch")
    top, mast = spec.site("top_link_front"), spec.site("plough.top_link_rear")
    return Hitch(
        lower_front=(float(links.pos[0]), float(links.pos[2])),
        lower_length_m=-float(frame.pos[0]),
        top_front=(float(top.pos[0]), float(top.pos[2])),
        mast=(0.0, 0.0) if mast is None else (float(mast.pos[0]), float(mast.pos[2])),
    )
