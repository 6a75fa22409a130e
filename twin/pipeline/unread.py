"""Fields of a scenario that a run would not read; setting such a field raises an error.

`RULES` has the condition of each field that is only sometimes read. Patches and faults have
functions of their own. All other fields are always read. A scenario that has only signals, and no
machine, has a method of its own: `unread() -> {field: what it needs}`.

The module is longer than 300 lines because `RULES` is one table with a row for each field.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields

import numpy as np

from twin.errors import BadInput
from twin.physics.law_reads import fields_read
from twin.plugins.lookup import Thing
from twin.scenario import Plough, Scenario, Soil
from twin.scenario.soil import DEFORMABLE_RANGES
from twin.sensors.faults import KINDS
from twin.sensors.fix import Mode, timeline

OTHER = "field.other_soil"
KEPT = "numbers"
"""The part of a soil that a scenario.json keeps of its preset, and nobody sets."""
KEPT_FILES = ("machine_numbers", "implement_numbers")
"""What a scenario.json keeps of files, and nobody sets."""
Met = Callable[[Scenario], bool]


@dataclass(frozen=True)
class Rule:
    """Condition under which a run reads a group of fields."""

    needs: str
    """The condition, as messages say it."""
    met: Met
    fields: tuple[str, ...]


def _both(*names: str) -> tuple[str, ...]:
    """Fields of the soil and of the other soil."""
    return tuple(f"{soil}.{name}" for soil in ("soil", OTHER) for name in names)


def _under(prefix: str, names: str) -> tuple[str, ...]:
    return tuple(f"{prefix}.{name}" for name in names.split())


def _never(scenario: Scenario) -> bool:
    return False


def _ploughs(scenario: Scenario) -> bool:
    return scenario.plough is not None


def _hitch(holds: Callable[[Plough], bool]) -> Met:
    """A condition on how the plough is hitched; a plough that is absent has no fields to set."""

    def met(scenario: Scenario) -> bool:
        return scenario.plough is None or holds(scenario.plough)

    return met


def _turns(scenario: Scenario) -> bool:
    return scenario.course.passes > 1


def _does(scenario: Scenario, action: str) -> bool:
    return any(event.do == action for event in scenario.events)


def _turns_or_reverses(scenario: Scenario) -> bool:
    """Where the driver goes at the pace of the headland."""
    return _turns(scenario) or _does(scenario, "reverse")


def _mixed(scenario: Scenario) -> bool:
    return scenario.field.mixed


def _law_reads(*names: str) -> Met:
    """Whether a law of the ground reads one of these; where soils meet, each law reads both."""

    def met(scenario: Scenario) -> bool:
        other = {scenario.field.other_soil.law} if _mixed(scenario) else set()
        return any(not _read_by(law).isdisjoint(names) for law in {scenario.soil.law, *other})

    return met


def _read_by(law: str) -> frozenset[str]:
    """Fields of a soil that a law reads, of those that laws differ in."""
    return LAW_READS[law] if law in LAW_READS else fields_read(law)


def _of(sensor: str, holds: Callable[[Thing], bool]) -> Met:
    """A condition on a sensor; one that is absent has no fields to set."""

    def met(scenario: Scenario) -> bool:
        fitted = getattr(scenario.sensors, sensor)
        return fitted is None or holds(fitted)

    return met


def _solved(*modes: Mode) -> Met:
    """Whether the outages bring the receiver into one of the modes."""

    def holds(gnss: Thing) -> bool:
        found = timeline(gnss.outages, np.zeros(3), np.random.default_rng(0)).mode
        return bool(np.isin(found, modes).any())

    return _of("gnss", holds)


def _outage(*kinds: str) -> Met:
    return _of("gnss", lambda gnss: any(outage.kind in kinds for outage in gnss.outages))


DEFORMABLE = tuple(DEFORMABLE_RANGES)
LAW_READS = {
    "brixius": frozenset({"friction", "cone_index_kpa"}),
    "bekker": frozenset({"friction", *DEFORMABLE}),
}
STRENGTH = ("cone_index_kpa", "k_c_kn_per_m_n1", "k_phi_kn_per_m_n2")
"""What varies with the cone index from place to place."""
OWN_LAW = "a law of your own that reads it"
ALL_OF_THEM = "all of the numbers of Bekker's law, which the preset lacks"
RULES = (
    Rule("field.soil_map, or field.other_share above 0", _mixed,
         (*(f"{OTHER}.{f.name}" for f in fields(Soil) if f.name != KEPT), "field.other_length_m")),
    Rule("field.other_share above 0", lambda s: s.field.other_share > 0.0,
         ("field.other_length_m",)),
    Rule("field.height_map or field.soil_map",
         lambda s: s.field.height_map is not None or s.field.soil_map is not None,
         ("field.map_cell_m", "field.map_start_m")),
    Rule(f"soil.law = brixius or bekker, or {OWN_LAW}", _law_reads("friction"),
         _both("friction")),
    Rule(f"soil.law = brixius, or {OWN_LAW}", _law_reads("cone_index_kpa"),
         _both("cone_index_kpa")),
    *(Rule(f"soil.law = bekker, or {OWN_LAW}", _law_reads(name), _both(name))
      for name in DEFORMABLE),
    Rule(f"soil.law = brixius or bekker, or {OWN_LAW}", _law_reads("friction", *STRENGTH),
         ("soil.strength_cv",)),
    Rule(ALL_OF_THEM, lambda s: s.soil.resolved.deformable is not None,
         tuple(f"soil.{name}" for name in DEFORMABLE)),
    Rule(ALL_OF_THEM, lambda s: s.field.other_soil.resolved.deformable is not None,
         tuple(f"{OTHER}.{name}" for name in DEFORMABLE)),
    Rule("a plough", _ploughs,
         (*_both("draft_scale"),
          *_under("soil", "draft_cv draft_length_m ripple_cv rocks_per_100m2 rock_kn"),
          *_under("sensors.depth", "laser_sd_m clod_sd_m clod_length_m inclinometer_sd_rad "
                                   "laser_bias_m inclination_bias_rad"),
          "sensors.machine.draft_pin_scale_error")),
    Rule("plough.hitch = depth, position or mix",
         _hitch(lambda p: p.hitch != "float" and not p.wheel_up), ("plough.wheel_share",)),
    Rule("plough.hitch other than depth, or plough.wheel_share above 0",
         _hitch(lambda p: p.hitch != "depth" or p.wheel_share > 0.0),
         ("plough.expected_draft_scale",)),
    Rule("plough.hitch = mix", _hitch(lambda p: p.hitch == "mix"), ("plough.draft_mix",)),
    Rule("plough.hitch = draft, or mix with plough.draft_mix above 0",
         _hitch(lambda p: p.mix > 0.0), _under("plough", "sensitivity_rad deepest_m")),
    Rule("to be set as that of `soil`, which holds for the whole field", _never,
         _under(OTHER, "draft_cv draft_length_m ripple_cv rocks_per_100m2 rock_kn strength_cv")),
    Rule("soil.draft_cv above 0", lambda s: s.soil.draft_cv > 0.0, ("soil.draft_length_m",)),
    Rule("soil.rocks_per_100m2 above 0", lambda s: s.soil.rocks_per_100m2 > 0.0,
         ("soil.rock_kn",)),
    Rule("a linkage, which the machine lacks", lambda s: s.facts.linkage,
         ("sensors.machine.lower_link_m",)),
    Rule("a differential lock, which the machine lacks", lambda s: s.facts.lock,
         ("drive.differential_lock",)),
    Rule("a diesel, which the machine has not", lambda s: s.facts.diesel,
         ("drive.exhaust_brake",)),
    Rule("course.passes above 1", _turns, ("course.headland",)),
    Rule("course.passes above 1, or an event reverse", _turns_or_reverses,
         ("driver.headland_rpm", "driver.headland_kmh")),
    Rule("course.headland = backing, and course.passes above 1",
         lambda s: _turns(s) and s.course.headland == "backing", ("course.backings",)),
    Rule("driver.headland_rpm, and course.passes above 1 or an event reverse",
         lambda s: _turns_or_reverses(s) and s.driver.headland_rpm is not None,
         ("driver.headland_rpm_sd",)),
    Rule("course.road_m above 0", lambda s: s.course.road_m > 0.0,
         ("driver.road_rpm", "driver.road_kmh")),
    Rule("an event reverse, or course.headland = backing with course.passes above 1",
         lambda s: (_turns(s) and s.course.headland == "backing") or _does(s, "reverse"),
         ("driver.pause_s",)),
    Rule("gears, which the machine lacks",
         lambda s: len(s.gearbox.ratios) > 1 and not s.gearbox.stepless, ("driver.shifts",)),
    Rule("driver.shifts, or an event with a condition",
         lambda s: s.driver.shifts or any(e.when is not None for e in s.events),
         ("driver.reaction_s",)),
    Rule("sensors.gnss.coloured_sd_m above 0", _of("gnss", lambda g: g.coloured_sd_m > 0.0),
         ("sensors.gnss.coloured_tau_s",)),
    Rule("an outage long enough for a float solution", _solved(Mode.FLOAT),
         _under("sensors.gnss", "float_sd_m float_tau_s")),
    Rule("sensors.gnss.float_sd_m above 0", _of("gnss", lambda g: g.float_sd_m > 0.0),
         ("sensors.gnss.float_tau_s",)),
    Rule("an outage long enough for a single-point solution", _solved(Mode.SINGLE),
         _under("sensors.gnss", "single_sd_m single_tau_s")),
    Rule("sensors.gnss.single_sd_m above 0", _of("gnss", lambda g: g.single_sd_m > 0.0),
         ("sensors.gnss.single_tau_s",)),
    Rule("an outage of the corrections", _solved(Mode.EXTRAPOLATED),
         ("sensors.gnss.extrapolation_sd_mps",)),
    Rule("an outage of kind mask", _outage("mask"), ("sensors.gnss.masked_velocity_factor",)),
    Rule("sensors.gnss.velocity_sd_mps above 0", _of("gnss", lambda g: g.velocity_sd_mps > 0.0),
         _under("sensors.gnss", "masked_velocity_factor rest_velocity_sd_mps rest_velocity_tau_s")),
    Rule("sensors.gnss.rest_velocity_sd_mps above 0",
         _of("gnss", lambda g: g.rest_velocity_sd_mps > 0.0),
         ("sensors.gnss.rest_velocity_tau_s",)),
    Rule("an outage of kind mask or mask-aux", _outage("mask", "mask-aux"),
         ("sensors.gnss.satellites_masked",)),
    Rule("an error of position or velocity above 0",
         _of("gnss", lambda g: bool(g.white_sd_m or g.coloured_sd_m or g.velocity_sd_mps
                                    or g.outages)),
         ("sensors.gnss.vertical_factor",)),
    Rule("a bias instability above 0",
         _of("imu", lambda u: bool(u.gyro_instability_radps or u.accel_instability_mps2)),
         ("sensors.imu.wander_tau_s",)),
    Rule("sensors.imu.vibration_rms_mps2 above 0", _of("imu", lambda u: u.vibration_rms_mps2 > 0.0),
         ("sensors.imu.firing_order",)),
    Rule("sensors.depth.clod_sd_m above 0", _of("depth", lambda d: d.clod_sd_m > 0.0),
         ("sensors.depth.clod_length_m",)),
    Rule("sensors.camera.odometry on board", _of("camera", lambda c: c.odometry != "none"),
         ("sensors.camera.processing_s",)),
)  # fmt: skip


def unread(scenario: Thing) -> dict[str, str]:
    """Path of each field that a run does not read -> condition under which the run reads it."""
    if not isinstance(scenario, Scenario):
        told = getattr(scenario, "unread", None)
        return dict(told()) if callable(told) else {}
    found: dict[str, str] = {}
    for rule in RULES:
        if not rule.met(scenario):
            found = dict.fromkeys(rule.fields, rule.needs) | found
    return found | dict(_idle_patches(scenario)) | dict(_idle_faults(scenario))


def _idle_patches(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """What patches change that a law of the user's own does not read."""
    factors = {"friction_factor": ("friction",), "cone_index_factor": STRENGTH}
    idle = [f for f, names in factors.items() if not _law_reads(*names)(scenario)]
    for i, factor in itertools.product(range(len(scenario.field.patches)), idle):
        yield f"field.patches.{i}.{factor}", OWN_LAW


def _idle_faults(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Faults of sensors that are not fitted."""
    for i, fault in enumerate(scenario.sensors.faults):
        stream = KINDS[fault.kind][0]
        if getattr(scenario.sensors, stream) is None:
            yield f"sensors.faults.{i}.kind", f"sensors.{stream}, which is not fitted"


def complaint(
    scenario: Thing, named: Collection[str] = (), also: Mapping[str, str] | None = None
) -> str | None:
    """Sentence on the fields that are set but not read; None if every set field is read.

    A field is set if its value differs from the default or if the user named the field. A sensor
    error that is switched off, as in `twin.sensors.ideal`, does not count as set.

    Args:
        scenario: scenario to check.
        named: paths of fields that the user gave.
        also: further fields that this use of the scenario does not read, and what they need.
    """
    for path in named:
        if KEPT in path.split("."):
            return f"{path} is kept of soil.preset and not set; set the soil's own fields"
        if path.partition(".")[0] in KEPT_FILES:
            what = path.partition("_")[0]
            return f"{path} is kept of {what} and not set; a file of your own would do"
    for path, needs in (unread(scenario) | dict(also or {})).items():
        held, usual = _held(scenario, path)
        off = path.startswith("sensors.") and held == 0.0
        if path in named or (held != usual and not off):
            return f"{path} = {held} would not be read: it needs {needs}"
    return None


def refuse_unread(
    scenario: Thing, named: Collection[str] = (), also: Mapping[str, str] | None = None
) -> None:
    """Raise BadInput if a set field is not read. The arguments are those of `complaint`."""
    if (said := complaint(scenario, named, also)) is not None:
        raise BadInput(said)


def _held(scenario: Thing, path: str) -> tuple[Thing, Thing]:
    """What a field holds, and its default; the same where there is no such field."""
    held, usual = scenario, None
    for name in path.split("."):
        if held is None:
            return None, None
        if isinstance(held, tuple):
            held, usual = held[int(name)], None
            continue
        usual = getattr(usual, name) if type(usual) is type(held) else _default(held, name)
        held = getattr(held, name)
    return held, usual


def _default(thing: Thing, name: str) -> Thing:
    """A field's default; MISSING where it has none."""
    field = next(f for f in fields(thing) if f.name == name)
    return field.default if field.default_factory is MISSING else field.default_factory()
