"""The guard against what is not finite: what went wrong first, and a folder that repeats it.

A run keeps its last second of states, one per decision of the driver. Where a number stops being
finite, or MuJoCo warns, the physics is repeated step by step from the last of them to find which
quantity it was; states and model go with the error:

    try:
        chunks = list(simulate(machine))
    except Diverged as error:
        error.evidence.write(folder)

    seen = replay(folder)  # every step of that last second, to the bit
    print(seen.failure)

The command line writes the folder by itself, as runs/failed-<name>-seed<N>.
"""

from __future__ import annotations

import copy
import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, TwinError
from twin.io.plain import from_plain, to_plain
from twin.machine.memory import name_of
from twin.physics import block
from twin.physics.block import Head, MachineSlot, PowerSlot, Soil, WheelSlot
from twin.physics.callback import install
from twin.physics.laws import law_number
from twin.scenario import Scenario
from twin.simulation.quiet import quiet

Array = NDArray[np.float64]

KEPT_S = 1.0
"""How much of the past a run keeps."""
STATE = mujoco.mjtState.mjSTATE_INTEGRATION
MODEL_FILE, STATES_FILE, SCENARIO_FILE, FAILURE_FILE = (
    "model.mjb", "states.npz", "scenario.json", "failure.json",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Failure:
    """What stopped being a number first, and when."""

    time_s: float
    """Time of the state whose step failed; settling and the run both begin at 0."""
    quantity: str
    """Slot, joint or activation; or MuJoCo's warning."""
    value: float
    """What it was; NaN for a warning."""


class Diverged(TwinError, ArithmeticError):
    """The simulation left the finite numbers, or MuJoCo warned."""

    def __init__(self, message: str, evidence: Evidence | None = None) -> None:
        super().__init__(message)
        self.evidence = evidence


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """All that repeats a failure."""

    scenario: Scenario
    model: mujoco.MjModel
    """mujoco.MjModel as it ran, with its parameter block."""
    states: Array
    """mjSTATE_INTEGRATION with the controls decided on, oldest first. Shape (n, nstate)."""
    steps: int
    """Physics steps from one state to the next."""
    failure: Failure

    def write(self, directory: Path) -> None:
        """Write model.mjb, states.npz, scenario.json and failure.json into a directory."""
        compiled = np.empty(mujoco.mj_sizeModel(self.model), np.uint8)
        mujoco.mj_saveModel(self.model, None, compiled)  # to a full disk it says nothing
        (directory / MODEL_FILE).write_bytes(compiled.tobytes())
        np.savez(directory / STATES_FILE, states=self.states, steps=self.steps)
        (directory / SCENARIO_FILE).write_text(_json(to_plain(self.scenario)))
        said = dataclasses.asdict(self.failure) | {
            "value": str(self.failure.value),  # JSON has no NaN
            "mujoco": mujoco.__version__,
            "repeat": "from twin.simulation.guard import replay; replay(folder)",
        }
        (directory / FAILURE_FILE).write_text(_json(said))


@dataclass(frozen=True, kw_only=True)
class Replay:
    """A repeated piece of a run, step by step."""

    states: Array
    """mjSTATE_INTEGRATION before each step, oldest first. Shape (n, nstate)."""
    failure: Failure | None
    """None where nothing failed."""


class StateRing:
    """The states at the last decisions: a ring that is written over."""

    def __init__(self, shape: tuple[int, ...], count: int) -> None:
        """Memory for a number of arrays of shape (nsim, nstate)."""
        self._rows = np.empty((count, *shape))
        self._count = 0

    def keep(self, state: Array) -> None:
        """Keep one more. Shape (nsim, nstate)."""
        self._rows[self._count % len(self._rows)] = state
        self._count += 1

    def states(self, i: int = 0) -> Array:
        """What is kept of one simulation, oldest first. Shape (n, nstate)."""
        rows = self._rows[: self._count, i]
        return np.roll(rows, -(self._count % len(rows)) if self._count > len(rows) else 0, axis=0)


def diverged(
    scenario: Scenario,
    model: mujoco.MjModel,
    states: Array,
    steps: int,
    *,
    during: str = "the run of",
) -> Diverged:
    """The error of a run whose last decision led to a failure, with its evidence.

    Args:
        scenario: what was run.
        model: as it ran.
        states: its last ones, oldest first. Shape (n, nstate).
        steps: physics steps from one of them to the next.
        during: what was being done.
    """
    failure = repeat(model, states[-1:], steps).failure or _unrepeatable(model, states[-1])
    evidence = Evidence(scenario=scenario, model=model, states=states, steps=steps, failure=failure)
    return Diverged(_message(failure, during, scenario), evidence)


def replay(folder: Path) -> Replay:
    """Repeat what a failed run left, step by step, to the bit.

    Args:
        folder: as `Evidence.write` filled it.

    Raises:
        BadInput: a file is missing or damaged, was written by another MuJoCo, or the user's own
            soil law is not the one that ran.
    """
    try:
        scenario = from_plain(Scenario, json.loads((folder / SCENARIO_FILE).read_text()))
        model = mujoco.MjModel.from_binary_path(str(folder / MODEL_FILE))
        with np.load(folder / STATES_FILE) as kept:
            states, steps = kept["states"], int(kept["steps"])
    except (OSError, ValueError, KeyError, mujoco.FatalError) as error:
        raise BadInput(f"{folder} does not repeat a failed run: {error}") from None
    install()
    head = tuple(model.numeric_data[-block.SIZE :][[Head.MAGIC, Head.VERSION]])
    if head != (block.MAGIC, block.VERSION):
        raise BadInput(f"{folder} was written by another version of this program")
    own = law_number(scenario.soil.law)
    if scenario.field.other_soil is not None:
        law_number(scenario.field.other_soil.law)
    if model.numeric_data[-block.SIZE + block.SOIL + Soil.LAW] != own and ":" in scenario.soil.law:
        raise BadInput(f"soil law '{scenario.soil.law}' has been edited since {folder} was written")
    return repeat(model, states, steps)


def repeat(model: mujoco.MjModel, states: Array, steps: int) -> Replay:
    """Step from the first state with each one's controls, up to the first failure.

    Args:
        model: with its parameter block; the laws are installed.
        states: mjSTATE_INTEGRATION, `steps` steps apart. Shape (n, nstate).
        steps: physics steps under each state's controls.
    """
    model = copy.copy(model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # or the state is lost
    state = mujoco.MjData(model)
    mujoco.mj_setState(model, state, states[0], STATE)
    taken = np.empty((len(states) * steps, states.shape[1]))
    for k in range(len(taken)):
        if k % steps == 0:
            row = mujoco.MjData(model) if k else state
            mujoco.mj_setState(model, row, states[k // steps], STATE)
            state.ctrl[:] = row.ctrl
        mujoco.mj_getState(model, state, taken[k], STATE)
        time_s = state.time
        with quiet():
            mujoco.mj_step(model, state)
        if (found := _fault(model, state)) is not None:
            failure = Failure(time_s=time_s, quantity=found[0], value=found[1])
            return Replay(states=taken[: k + 1], failure=failure)
    return Replay(states=taken, failure=None)


def _fault(model: mujoco.MjModel, state: mujoco.MjData) -> tuple[str, float] | None:
    """The first quantity that is no number or beyond MuJoCo's limit: cause before effect."""
    looked_at = (
        (state.userdata, math.inf, _slot),
        (state.qfrc_passive, math.inf, lambda m, k: f"passive force on {_dof(m, k)}"),
        (state.act, math.inf, lambda m, k: f"activation of {name_of(m, k)}"),
        (state.qacc, mujoco.mjMAXVAL, lambda m, k: f"acceleration of {_dof(m, k)}"),
        (state.qvel, mujoco.mjMAXVAL, lambda m, k: f"velocity of {_dof(m, k)}"),
        (state.qpos, mujoco.mjMAXVAL, lambda m, k: f"position of {_coordinate(m, k)}"),
    )
    for values, most, name in looked_at:
        bad = np.flatnonzero(~(np.isfinite(values) & (np.abs(values) <= most)))
        if bad.size:
            return name(model, int(bad[0])), float(values[bad[0]])
    warned = [i for i, w in enumerate(state.warning) if w.number]
    return (warning_text(warned[0]), math.nan) if warned else None


def _slot(model: mujoco.MjModel, k: int) -> str:
    """Name of a slot of userdata."""
    if k < block.MACHINE_SLOTS:
        wheel, slot = divmod(k, int(WheelSlot.SIZE))
        return f"{WheelSlot(slot).name.lower()} of wheel {block.WHEELS[wheel]}"
    if k < block.POWER_SLOTS:
        return MachineSlot(k - block.MACHINE_SLOTS).name.lower()
    if k < block.SCRATCH_SLOTS:
        return f"power {PowerSlot(k - block.POWER_SLOTS).name.lower()}"
    if k < block.RATE_SLOTS:
        return f"soil {Soil(k - block.SCRATCH_SLOTS).name.lower()} under a wheel or share"
    return f"rate of {name_of(model, k - block.RATE_SLOTS)}"


def _dof(model: mujoco.MjModel, k: int) -> str:
    return _joint(model, int(model.dof_jntid[k]), k - int(model.jnt_dofadr[model.dof_jntid[k]]))


def _coordinate(model: mujoco.MjModel, k: int) -> str:
    joint = int(np.flatnonzero(model.jnt_qposadr <= k)[-1])
    return _joint(model, joint, k - int(model.jnt_qposadr[joint]))


def _joint(model: mujoco.MjModel, joint: int, k: int) -> str:
    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
        body = model.body(int(model.jnt_bodyid[joint])).name
        return f"body {body} ({'along ' + 'xyz'[k] if k < 3 else 'rotation'})"
    return f"joint {model.joint(joint).name}"


def warning_text(number: int) -> str:
    """How a MuJoCo warning is named in messages."""
    return f"MuJoCo's warning {mujoco.mjtWarning(number).name}"


def _unrepeatable(model: mujoco.MjModel, state: Array) -> Failure:
    """A failure the repeated steps did not show."""
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, STATE)
    return Failure(time_s=data.time, quantity="some quantity after this", value=math.nan)


def _message(failure: Failure, during: str, scenario: Scenario) -> str:
    what = failure.quantity
    if not what.startswith("MuJoCo"):
        what += f" is {failure.value:g}"
    return f"{what} at {failure.time_s:.3f} s of {during} '{scenario.name}' (seed {scenario.seed})"


def _json(value: object) -> str:
    return json.dumps(value, indent=2, allow_nan=False) + "\n"
