"""What the driver of a scenario's machine is to do, and knows of it."""

from __future__ import annotations

from twin.machine.build import Machine
from twin.machine.start import raised_rad
from twin.simulation.braking import Drivetrain, governed_radps
from twin.simulation.driver import DriverTask, HitchControl, full_depth_m

CONTROL_OF = {
    "depth": HitchControl.DEPTH,
    "position": HitchControl.VALVE,
    "draft": HitchControl.VALVE,
    "mix": HitchControl.VALVE,
    "float": HitchControl.FLOAT,
}
"""What the lift follows in each of a plough's hitch modes."""


def course_task(machine: Machine) -> DriverTask:
    """The task of driving a machine along its scenario's course."""
    scenario, model = machine.scenario, machine.model
    plough, setting = scenario.plough, machine.setting
    bare = DriverTask(
        wheelbase_m=float(model.body("front_axle").pos[0]),
        track_m=2.0 * float(model.body("fl_knuckle").pos[1]),
        approach_m=scenario.course.approach_m,
        raised_rad=raised_rad(scenario),
        work_rad=machine.work_rad,
        throttle=machine.throttle,
        hold_line=scenario.course.hold_line,
        differential_lock=scenario.drive.differential_lock and scenario.facts.lock,
        front_drive=scenario.drive.all_wheel_drive,
    )
    if plough is None or setting is None:
        return bare
    return bare._replace(
        hitch=CONTROL_OF[plough.hitch],
        depth_m=plough.depth_m,
        full_depth_m=full_depth_m(plough.depth_m, plough.hitch),
        work_rad=setting.lever_rad,
        mix=plough.mix,
        draft_n=setting.draft_n,
        sensitivity_rad=plough.sensitivity_rad,
        lowest_rad=setting.lowest_rad,
        drop_rate_radps=plough.drop_rate_radps,
    )


def drivetrain(machine: Machine) -> Drivetrain:
    """A machine's; pedal per deceleration is m r / (2 C), with one brake C on each rear wheel."""
    numbers, model = machine.numbers, machine.model
    radius_m = numbers["tyre_rear.free_rolling_radius_m"]
    mass_kg = float(model.body_subtreemass[model.body("tractor").id])
    return Drivetrain(
        gear_ratio=machine.scenario.gear.ratio,
        idle_rpm=numbers["engine.idle_rpm"],
        no_load_rpm=numbers["engine.no_load_rpm"],
        mps_per_radps=radius_m / machine.scenario.gear.ratio,
        pedal_per_mps2=mass_kg * radius_m / (2.0 * numbers["brake.capacity_nm"]),
    )


def asked_mps(machine: Machine) -> float:
    """Speed of the driven rims that the scenario's throttle asks for, without load."""
    known = drivetrain(machine)
    return float(governed_radps(known, machine.throttle) * known.mps_per_radps)
