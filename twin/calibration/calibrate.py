"""A log and a machine's file to the machine and the soil that explain the log."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from estimators.lag import Lag
from estimators.zero_slip import zero_slip_scale
from twin import logs
from twin.calibration import files as written
from twin.calibration import gears as found_gears
from twin.calibration.applied import believed, can_fit, machine_with, soil_with
from twin.calibration.evidence import evidence
from twin.calibration.fitting import Fit, Prior, fit
from twin.calibration.gears import Gear
from twin.calibration.holdout import Holdout, held_out
from twin.calibration.known import KNOWN, known
from twin.calibration.posterior import Posterior
from twin.calibration.seconds import seconds, with_speeds
from twin.calibration.segments import RULE as SEGMENT_RULE
from twin.calibration.segments import Segment, segments
from twin.calibration.steady import Steady
from twin.calibration.steady_rows import RULE as ROW_RULE
from twin.calibration.steady_rows import steady_rows
from twin.calibration.verdicts import Told, misfit_note, together, told
from twin.errors import BadInput, UnknownName
from twin.io.atomic import write_text
from twin.logs import Log
from twin.pipeline.log_check import log_lag
from twin.scenario import Soil
from twin.streams import Table
from twin.vehicle import Machine, files
from twin.vehicle.derive import RPM
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

SCHEMA = 1
FAST_S = 0.3
"""Wheels that are sampled more slowly belong to a log that is fitted in steady rows [s]."""
STEADY_NAMES = (
    "soil.cone_index_kpa", "soil.friction", "transmission.efficiency", "engine.parasitic_nm",
    "engine.fuel_l_per_kwh", "log.reference_torque_nm", "log.wheel_scale", "log.carried_kg",
)  # fmt: skip
ROLLOUT_NAMES = (
    "rear.free_rolling_radius_m", "front.free_rolling_radius_m", "transmission.efficiency",
    "engine.no_load_rpm", "engine.fuel_l_per_kwh", "soil.cone_index_kpa", "soil.friction",
    "soil.draft_scale", "soil.mobility_resistance", "log.set_rpm", "log.reference_torque_nm",
    "log.wheel_scale",
)  # fmt: skip
"""What is fitted where nobody says what, by rows and by rollouts."""
HELD_SHARE = 0.25
CARRIED_SHARE = 0.2
"""Load that an implement puts on its tractor, over the tractor's mass, before the log."""
REFERENCE_OVER_PEAK = 1.02
SCALES = (0.93, 1.07)
"""A scale of the wheels beyond these says that the map is another machine's."""
RADII = (0.885, 0.995)
"""A free rolling radius over half of the tyre's diameter."""
LEAST_SCALE_SD, EMPTY_ROWS, EMPTY_MPS = 0.015, 20, 1.0


@dataclass(frozen=True)
class Calibration:
    """What a log says of a machine and a soil."""

    name: str
    machine: Machine
    """With the values that were found."""
    soil: Soil
    parameters: tuple[Told, ...]
    posterior: Posterior
    together: tuple[str, ...]
    gears: tuple[Gear, ...]
    lag: Lag
    fit: Fit
    channels: tuple[str, ...]
    time_s: Array
    foretold: Array
    """What the machine foretells of the rows that were fitted, (n, c)."""
    holdout: Holdout | None
    rule: str
    notes: tuple[str, ...]

    @property
    def scores(self) -> dict[str, object]:
        """What `--json` gives."""
        rows = [{k: getattr(p, k) for k in ("name", "value", "low", "high", "verdict")}
                for p in self.parameters]  # fmt: skip
        names = ("slip_rms", "slip_mae", "coverage", "line_rms", "constant_rms", "gain_low",
                 "gain_high")  # fmt: skip
        held: Mapping[str, float | None] = self.holdout.scores if self.holdout else {}
        return {"schema": SCHEMA, "parameters": rows, "holdout": {n: held.get(n) for n in names}}

    def save(self, folder: Path, stem: str, command: str = "") -> dict[str, Path]:
        """Write machine, posterior, soil, report and the rows held back; where each is."""
        from twin.calibration.page import page

        base = folder / f"{stem}.calibrated.toml"
        paths = {"machine": base, "posterior": base.with_suffix(".posterior.json"),
                 "soil": base.with_suffix(".soil.toml"), "report": base.with_suffix(".html"),
                 "holdout": base.with_suffix(".holdout.csv")}  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        source = f"twin calibrate {self.name}"
        texts = {
            "machine": written.machine_toml(self.machine, self.parameters, source),
            "soil": written.soil_toml(self.soil, self.name),
            "report": page(self, command),
        }
        for what, text in texts.items():
            write_text(paths[what], text)
        self.posterior.write(paths["posterior"])
        if self.holdout is not None:
            write_text(paths["holdout"], _csv(self.holdout))
        else:
            del paths["holdout"]
        return paths


@dataclass
class Memory:
    """What was found before a calibration was killed, kept in a file until it is done."""

    path: Path | None
    key: str
    kept: dict[str, list[float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.path is not None and self.path.is_file():
            try:
                raw = json.loads(self.path.read_text(encoding="utf-8"))
                self.kept = raw["kept"] if raw["key"] == self.key else {}
            except (ValueError, KeyError, TypeError):
                self.kept = {}

    def __call__(self, name: str, find: Callable[[], Array]) -> Array:
        """What is kept under a name, or what is found and then kept."""
        if name not in self.kept:
            self.kept[name] = find().tolist()
            if self.path is not None:
                write_text(self.path, json.dumps({"key": self.key, "kept": self.kept}))
        return np.array(self.kept[name])

    def forget(self) -> None:
        """Remove the file."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)


def calibrate(
    log: str | Path | Iterable[str | Path],
    column_map: str | Path | None = None,
    *,
    machine: str | Machine,
    parameters: Sequence[str] | None = None,
    hold_out_s: tuple[float, float] | None = None,
    implement: str | None = None,
    soil: Soil | None = None,
    seed: int = 0,
    starts: int = 3,
    jobs: int = 1,
    resume: Path | None = None,
    told: Callable[[str], None] = lambda what: None,
) -> Calibration:
    """Find the machine and the soil that explain a recorded drive.

    Args:
        log: as `twin.estimate` takes it.
        column_map: TOML that says which column is what.
        machine: a name, a file, or what a file holds: what is believed before.
        parameters: names of what is fitted; None for all that the log can tell.
        hold_out_s: first and last second of the log that are not fitted; None for the last quarter
            of the work.
        implement: the implement; None for the machine's usual one.
        soil: what is believed of the soil; None for a tilled field.
        seed: of the random starts.
        starts: how many there are.
        jobs: threads.
        resume: file that keeps what is found, so that a killed calibration goes on.
        told: called with what is being done.

    Raises:
        BadInput: the log cannot be fitted; says what is missing.
        UnknownName: there is no such parameter.

    Example:
        >>> twin.calibrate("field.csv", "field.toml", machine="my.toml")  # doctest: +SKIP
    """
    for name in parameters or ():
        if name not in KNOWN:
            raise UnknownName("parameter", name, KNOWN)
    paths = [Path(log)] if isinstance(log, str | Path) else [Path(each) for each in log]
    known_machine = files.machine(machine) if isinstance(machine, str) else machine
    for name in parameters or ():
        if not can_fit(known_machine, name):
            raise BadInput(f"{name} cannot be fitted to {known_machine.name}, whose MJCF is made "
                           "by hand; another parameter would do")  # fmt: skip
    told("reading")
    read = logs.read(paths, None if column_map is None else Path(column_map))
    rows = seconds(read)
    lag = log_lag(replace(read, streams=with_speeds(read.streams, read.setup)), seed=seed)
    key = hashlib.sha256(
        repr((paths, [p.stat().st_mtime_ns for p in paths], column_map, known_machine, parameters,
              hold_out_s, implement, soil, seed, starts)).encode()
    ).hexdigest()  # fmt: skip
    task = _Task(
        name=" + ".join(p.name for p in paths), log=read, rows=rows, machine=known_machine,
        implement=implement, soil=soil or Soil(preset="tilled"), parameters=parameters, lag=lag,
        hold_out_s=hold_out_s, seed=seed, starts=starts, jobs=jobs, memory=Memory(resume, key),
        told=told, own=paths[0].is_dir(),
    )  # fmt: skip
    _refuse_without_engine(rows)
    step_s = float(np.median(np.diff(read.streams["wheels"]["epoch_ns"]))) * 1e-9
    found = _by_rollouts(task) if step_s < FAST_S else _by_rows(task)
    task.memory.forget()
    return found


@dataclass(frozen=True)
class _Task:
    name: str
    log: Log
    rows: Table
    machine: Machine
    implement: str | None
    soil: Soil
    parameters: Sequence[str] | None
    lag: Lag
    hold_out_s: tuple[float, float] | None
    seed: int
    starts: int
    jobs: int
    memory: Memory
    told: Callable[[str], None]
    own: bool
    """Whether the log is a run folder, whose engine load is torque over a reference."""


def _refuse_without_engine(rows: Table) -> None:
    if "engine_radps" not in rows:
        raise BadInput("the log has no engine speed, by which gears are found; map [machine] "
                       "engine_speed")  # fmt: skip


def _torque(task: _Task) -> tuple[Array, float, float, bool]:
    """Torque over its reference, the reference, its prior sd, and whether it is the axle's."""
    rows, machine = task.rows, task.machine
    numbers = machine_facts(machine).numbers
    peak_nm = numbers["engine.rated_torque_nm"] * numbers["engine.torque_rise"]
    if "engine_torque" in rows:
        return rows["engine_torque"], REFERENCE_OVER_PEAK * peak_nm, 0.15, False
    if "engine_load" not in rows:
        raise BadInput("the log has no engine torque; map [machine] engine_torque (SPN 513) or "
                       "engine_load (SPN 92)")  # fmt: skip
    load = rows["engine_load"]
    if task.own:
        return load, peak_nm, 0.3, False
    rpm = rows["engine_radps"] / RPM
    rated, at = numbers["engine.rated_rpm"], numbers["engine.peak_rpm"]
    full = (
        peak_nm - (peak_nm - numbers["engine.rated_torque_nm"]) * ((rpm - at) / (rated - at)) ** 2
    )
    most = numbers["engine.max_power_w"] / np.maximum(rpm * RPM, 1.0)
    return load * np.clip(np.minimum(full, most), 0.0, None) / peak_nm, peak_nm, 0.15, False


def _gears(task: _Task) -> tuple[list[Gear], Array, bool]:
    """Gears, engine turns per turn of the rear axle in each second, and whether radii are known."""
    rows, setup = task.rows, task.log.setup
    facts = machine_facts(task.machine)
    turned = setup.wheels is not None and setup.wheels.counts_per_turn is not None
    radius_m = facts.numbers["tyre_rear.free_rolling_radius_m"]
    if turned and setup.wheels is not None:
        radius_m = setup.wheels.radius_m["rl"]
    driven = (rows["wheel_speed_mps"] > 0.5) & (rows["engine_radps"] > 600.0 * RPM)
    ratio = np.where(driven, rows["engine_radps"] * radius_m
                     / np.maximum(rows["wheel_speed_mps"], 0.1), np.nan)  # fmt: skip
    kmh = 3.6 * facts.numbers["engine.rated_rpm"] * RPM * radius_m
    return found_gears.found(ratio, facts.ratios, kmh), ratio, turned


def _prior(task: _Task, names: Sequence[str], own: Mapping[str, tuple[float, float]]) -> Prior:
    """What is believed of the parameters; `own` are values and sd that the log itself gives."""
    mean, sd, grades = [], [], []
    for name in names:
        value, spread, grade = (
            (*own[name], "the log") if name in own
            else believed(task.machine, task.soil, name)
        )  # fmt: skip
        mean.append(math.log(value))
        sd.append(spread)
        grades.append(grade)
    low, high = (np.log([getattr(known(n), end) for n in names]) for end in ("low", "high"))
    facts = machine_facts(task.machine).numbers
    for i, name in enumerate(names):
        if name.startswith("log.set_rpm"):
            low[i] = math.log(max(300.0, 1.13 * facts["engine.idle_rpm"]))
            high[i] = math.log(0.985 * facts["engine.no_load_rpm"])
            mean[i] = min(max(mean[i], low[i]), high[i])
        if name.endswith("free_rolling_radius_m"):  # a file with another would be refused
            axle = name.partition(".")[0]
            radius_m = 0.5 * facts[f"tyre_{axle}.diameter_m"]
            low[i], high[i] = np.log(np.array(RADII) * radius_m)
        if name == "engine.no_load_rpm":
            low[i] = math.log(max(1.002 * facts["engine.rated_rpm"],
                                  0.99 * facts["engine.no_load_rpm"]))  # fmt: skip
    return Prior(tuple(names), np.array(mean), np.array(sd), low, high, tuple(grades))


def _chosen(task: _Task, usual: Sequence[str], absent: Iterable[str]) -> tuple[str, ...]:
    """What is fitted: what was asked for and can be, or what the log has."""
    left_out = set(absent)
    names = [n for n in usual if n not in left_out and can_fit(task.machine, n)]
    if task.parameters is None:
        return tuple(names)
    refused = [n for n in task.parameters if n not in usual]
    if refused:
        raise BadInput(f"{refused[0]} cannot be told from this kind of log; there are: "
                       f"{', '.join(names)}")  # fmt: skip
    needed = [n for n in names if n.startswith("log.")]
    return tuple(dict.fromkeys([*task.parameters, *needed]))


def _wheel_scale(task: _Task, fitted: NDArray[np.bool_]) -> tuple[float, float]:
    """Zero-slip scale before the fit, from driving empty: ground speed moved by its lag."""
    from twin.calibration.steady_rows import doing

    rows = task.rows
    time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
    lag_s = task.lag.lag_s if math.isfinite(task.lag.lag_s) else 0.0
    ground = np.interp(time_s + lag_s, time_s, rows["speed_mps"])
    empty = doing(task.log, rows)[1] & fitted & (rows["wheel_speed_mps"] > EMPTY_MPS)
    steady = np.abs(np.gradient(rows["wheel_speed_mps"])) < 0.15
    scale = zero_slip_scale(ground, rows["wheel_speed_mps"], empty & steady, seed=task.seed)
    if scale.n < EMPTY_ROWS:
        return 1.0, known("log.wheel_scale").spread
    return scale.scale, max(LEAST_SCALE_SD, (scale.high - scale.low) / 3.92)


def _held(task: _Task, time_s: Array, working: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which times are held back."""
    if task.hold_out_s is not None:
        first, last = task.hold_out_s
        return np.asarray((time_s >= first) & (time_s <= last))
    return np.asarray(time_s >= np.quantile(time_s[working], 1.0 - HELD_SHARE))


def _by_rows(task: _Task) -> Calibration:
    """A long log: steady rows."""
    torque, reference_nm, spread, of_axle = _torque(task)
    gears, _, _ = _gears(task)
    found = steady_rows(task.log, task.rows, torque)
    held = _held(task, found.time_s, found.working)
    fitted = found.chosen(~held & found.working & np.isfinite(found.ratio))
    back = found.chosen(held & found.working)
    if len(fitted) < 12 or not len(back):
        raise BadInput(
            f"{len(fitted)} rows of steady work are left to fit and {len(back)} to check; at least "
            "12 and 1 would do: hold back less, or drive longer"
        )
    time_s = (task.rows["epoch_ns"] - task.rows["epoch_ns"][0]) * 1e-9
    second_held = _held(task, time_s, time_s >= 0.0) if task.hold_out_s else (
        time_s >= back.time_s.min())  # fmt: skip
    own = {"log.reference_torque_nm": (reference_nm, spread),
           "log.wheel_scale": _wheel_scale(task, ~second_held),
           "log.carried_kg": (CARRIED_SHARE * _mass_kg(task.machine),
                              known("log.carried_kg").spread)}  # fmt: skip
    no_fuel = not np.isfinite(fitted.fuel_lph).mean() > 0.9
    names = _chosen(task, STEADY_NAMES, ["engine.fuel_l_per_kwh"] if no_fuel else [])
    all_wheels = task.machine.mjcf is None and task.machine.drive.driven == "all"
    model = Steady(task.machine, task.soil, names, fitted, all_wheels, of_axle)
    result = fit(model, _prior(task, names, own), seed=task.seed, starts=task.starts,
                 told=task.told, remember=task.memory)  # fmt: skip
    _refuse_other_machine(task, result, gears)
    ahead = Steady(task.machine, task.soil, names, back, all_wheels, of_axle)
    holdout = held_out(ahead, result, fitted, task.seed)
    return _calibration(task, result, gears, model.channels, model.measured, model.time_s,
                        holdout, ROW_RULE)  # fmt: skip


def _by_rollouts(task: _Task) -> Calibration:
    """A short log at a fast rate: the machine itself, rolled out."""
    from twin.calibration.rollouts import Condition, Drawn, Rollouts
    from twin.calibration.rollouts import Gear as Driven

    gears, ratio, turned = _gears(task)
    rows = task.rows
    chosen = segments(rows)
    if task.hold_out_s is not None:
        time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
        first, last = task.hold_out_s
        chosen = [replace(s, held_back=bool(np.any(
            (time_s[s.rows] >= first) & (time_s[s.rows] <= last)))) for s in chosen]  # fmt: skip
    kept, notes = [], []
    for segment in (s for s in chosen if not s.held_back):
        if (gear := found_gears.gear_of(float(np.nanmedian(ratio[segment.rows])), gears)) is None:
            notes.append("a segment whose gear is not found is left out")
        else:
            kept.append((segment, gear))
    if sum(s.working for s, _ in kept) < 2:
        raise BadInput("fewer than two segments of steady work in a gear are left to fit; drive "
                       "longer in one gear")  # fmt: skip
    driven = list(dict.fromkeys(g for _, g in kept))
    set_names = {g: "log.set_rpm" if i == 0 else f"log.set_rpm.{i + 1}"
                 for i, g in enumerate(driven)}  # fmt: skip
    proof = evidence(rows, [s for s, _ in kept])
    absent = _absent(task, proof.channels, turned)
    names = list(_chosen(task, ROLLOUT_NAMES, absent))
    names += [n for n in set_names.values() if n not in names]
    if "log.wheel_scale" in names:
        names = [n for n in names if not n.endswith("radius_m")]
    exact = {g: _ratio(task, g, turned) for g in driven}
    own: dict[str, tuple[float, float]] = {
        name: (1.01 * float(max(np.nanmax(rows["engine_radps"][s.rows]) for s, g in kept
                                if set_names[g] == name)) / RPM, known(name).spread)
        for name in set_names.values()
    }  # fmt: skip
    numbers = machine_facts(task.machine).numbers
    peak_nm = numbers["engine.rated_torque_nm"] * numbers["engine.torque_rise"]
    own |= {"log.reference_torque_nm": (peak_nm, 0.3), "log.wheel_scale": (1.0, 0.03)}
    part = files.implement(task.implement or files.usual_implement(task.machine)
                           or _usual(task.machine))  # fmt: skip
    depth_m = float(np.mean([np.nanmean(rows["depth_m"][s.rows]) for s, _ in kept if s.working])
                    ) if "depth_m" in rows else float(np.mean(part.depths_m))  # fmt: skip
    block = task.log.setup.wheels
    rear_m = numbers["tyre_rear.free_rolling_radius_m"]
    front_m = numbers["tyre_front.free_rolling_radius_m"]
    if block is not None and turned:
        front_m, rear_m = block.radius_m["fl"], block.radius_m["rl"]
    drawn = Drawn(task.machine, part, task.soil, depth_m, "fl" in task.log.setup.driven)
    conditions = tuple(Condition(s.working, Driven(exact[g], set_names[g])) for s, g in kept)
    prior = _prior(task, names, own)
    fixed = {n: own[n][0] for n in ("log.reference_torque_nm",) if n not in names}
    model = Rollouts(drawn, tuple(names), proof, conditions, (front_m, rear_m), task.jobs, fixed)
    result = fit(model, prior, seed=task.seed, starts=task.starts, told=task.told,
                 remember=task.memory)  # fmt: skip
    holdout = _row_holdout(task, result, chosen)
    if holdout is None:
        notes.append("the part held back has no rows steady enough to be foretold one by one")
    return _calibration(task, result, gears, proof.channels, proof.measured, proof.time_s,
                        holdout, SEGMENT_RULE,
                        notes)  # fmt: skip


def _absent(task: _Task, channels: Sequence[str], turned: bool) -> list[str]:
    """Parameters that nothing in the log depends on."""
    needs = {"engine_load": "log.reference_torque_nm", "fuel_lph": "engine.fuel_l_per_kwh",
             "front_speed_mps": "front.free_rolling_radius_m"}  # fmt: skip
    out = [name for channel, name in needs.items() if channel not in channels]
    if "axle_torque_nm" not in channels and "engine_load" not in channels:
        out.append("transmission.efficiency")
    return [*out, "log.wheel_scale"] if turned else out


def _ratio(task: _Task, gear: Gear, turned: bool) -> float:
    """The ratio of the machine's file where it has gears, else the log's."""
    known_ratios = machine_facts(task.machine).ratios
    if not known_ratios:
        return gear.ratio
    return min(known_ratios, key=lambda r: abs(math.log(r / gear.ratio)))


def _row_holdout(task: _Task, result: Fit, chosen: Sequence[Segment]) -> Holdout | None:
    """Rows held back, foretold by the soil that was found; the rows' own nuisances are fitted."""
    try:
        torque, reference_nm, _, of_axle = _torque(task)
        found = steady_rows(task.log, task.rows, torque, steady_mps2=math.inf)
    except BadInput:
        return None
    values, sds = result.values, dict(zip(result.prior.names, np.sqrt(np.diag(result.cov)),
                                          strict=True))  # fmt: skip
    held_from = (
        min(s.rows.start for s in chosen if s.held_back)
        if any(s.held_back for s in chosen)
        else len(task.rows["epoch_ns"])
    )
    held = _held(task, found.time_s, found.working) if task.hold_out_s else (
        found.time_s >= held_from)  # fmt: skip
    fitted = found.chosen(~held & found.working & np.isfinite(found.ratio))
    back = found.chosen(held & found.working)
    if len(fitted) < 6 or len(back) < 3:
        return None
    machine, soil = machine_with(task.machine, values), soil_with(task.soil, values)
    names = tuple(n for n in STEADY_NAMES if n != "engine.fuel_l_per_kwh")
    numbers = machine_facts(machine).numbers
    block = task.log.setup.wheels
    scale = 1.0
    if block is not None and block.counts_per_turn is not None:
        scale = numbers["tyre_rear.free_rolling_radius_m"] / block.radius_m["rl"]
    own = {
        "log.reference_torque_nm": (values.get("log.reference_torque_nm", reference_nm),
                                    sds.get("log.reference_torque_nm", 0.15)),
        "log.wheel_scale": (values.get("log.wheel_scale", scale),
                            sds.get("rear.free_rolling_radius_m", 0.03)),
        "log.carried_kg": (CARRIED_SHARE * _mass_kg(machine), 0.7),
    }  # fmt: skip
    for name in ("soil.cone_index_kpa", "soil.friction", "transmission.efficiency"):
        if name in values:
            own[name] = (values[name], float(sds[name]))
    later = replace(task, machine=machine, soil=soil, parameters=None)
    driven = "fl" in task.log.setup.driven
    prior = _prior(later, names, own)
    row_fit = fit(Steady(machine, soil, names, fitted, driven, of_axle), prior, seed=task.seed,
                  starts=1, told=task.told)  # fmt: skip
    return held_out(Steady(machine, soil, names, back, driven, of_axle), row_fit, fitted, task.seed)


def _refuse_other_machine(task: _Task, result: Fit, gears: Sequence[Gear]) -> None:
    scale = result.values.get("log.wheel_scale", 1.0)
    if not SCALES[0] <= scale <= SCALES[1]:
        raise BadInput(
            f"the wheels' true speed would be {scale:.2f} times the logged one: another machine's "
            "map, or another unit; a map of this log would do"
        )
    if not gears:
        raise BadInput(
            "no gear is found: engine and wheel speed keep no ratio; are both of this machine, and "
            "in the units of the map?"
        )


def _mass_kg(machine: Machine) -> float:
    return machine.mass_kg or 2.0 * sum(
        machine_facts(machine).numbers[f"tyre_{a}.nominal_load_n"] for a in ("front", "rear")
    ) / 9.81  # fmt: skip


def _usual(machine: Machine) -> str:
    from twin.scenario.scenario import POWERS_KW

    power_kw = 1e-3 * machine_facts(machine).numbers["engine.max_power_w"]
    return next(name for most_kw, name in POWERS_KW if power_kw <= most_kw)


def _calibration(
    task: _Task, result: Fit, gears: Sequence[Gear], channels: Sequence[str], measured: Array,
    time_s: Array, holdout: Holdout | None, rule: str, notes: Sequence[str] = (),
) -> Calibration:  # fmt: skip
    values = result.values
    found = told(result)
    noted = [*notes, *([said] if (said := misfit_note(result)) else [])]
    noted += [f"{p.name} is at its bound, {p.value:.4g} {p.unit}: the log asks for more than is "
              "allowed" for p in found if p.at_bound]  # fmt: skip
    away = np.abs(result.starts - result.u).max(axis=1) / np.sqrt(np.diag(result.cov)).max()
    if len(away) > 1 and away.max() > 1.0:
        noted.append("starts end in different places; the best of them is kept")
    return Calibration(
        name=task.name, machine=machine_with(task.machine, values),
        soil=soil_with(task.soil, values), parameters=tuple(found),
        posterior=Posterior(result.prior.names, result.u, result.cov),
        together=tuple(together(result)), gears=tuple(gears), lag=task.lag, fit=result,
        channels=tuple(channels), time_s=time_s,
        foretold=measured - result.residual, holdout=holdout, rule=rule,
        notes=(*task.log.notes, *noted),
    )  # fmt: skip


def _csv(holdout: Holdout) -> str:
    lines = ["time_s,slip,slip_low,slip_high,slip_measured,slip_line"]
    for row in zip(holdout.rows.time_s, holdout.slip, holdout.slip - 1.96 * holdout.slip_sd,
                   holdout.slip + 1.96 * holdout.slip_sd, holdout.measured, holdout.line,
                   strict=True):  # fmt: skip
        lines.append(",".join("" if not math.isfinite(v) else f"{v:.6g}" for v in row))
    return "\n".join(lines) + "\n"
