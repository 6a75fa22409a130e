"""The vector environments: all tractors in one Batch on all cores.

A constructor takes one keyword for each setting, because `gymnasium.make_vec` passes them so.
"""

from __future__ import annotations

import os

from gymnasium.utils import EzPickle
from gymnasium.vector import AutoresetMode

from twin.env.fieldwork import FieldWork
from twin.env.many import RENDER_MODES, ManyEnv
from twin.env.ploughing import Ploughing
from twin.env.pulling import USUAL_MACHINE, Pulling
from twin.env.rendering import Look
from twin.env.schedule import Grounds
from twin.env.torque_fleet import USUAL_IMPLEMENT
from twin.env.traction import Traction
from twin.errors import OutOfRange, UnknownName
from twin.scenario import Scenario


class PloughVectorEnv(ManyEnv):
    """Many tractors plough side by side; each sees what `PloughEnv` with its seed would, bit by bit.

    ```
    many = gymnasium.make_vec(
        "twin.env:Plough-v0", num_envs=256, vectorization_mode="vector_entry_point"
    )
    observations, infos = many.reset(seed=1)     # seeds 1, 2, 3, ...; or a list of them
    ```

    Arguments, actions, observations, reward and end are those of `twin.env.plough.PloughEnv`, and:

    | name | default | meaning |
    |---|---|---|
    | `num_envs` | 1 | tractors |
    | `max_episode_steps` | None, 1500 by the registration | control steps to a truncation |
    | `autoreset_mode` | NEXT_STEP | what follows an end, as Gymnasium defines it: NEXT_STEP, SAME_STEP or DISABLED |
    | `nthread` | all cores | threads of the physics |

    `reset(options={"reset_mask": mask})` begins new episodes of the tractors in the mask alone; the
    other options hold for all that are reset. Infos are arrays of length `num_envs` with a mask
    `_<name>` of whom they concern.
    """  # noqa: E501

    episodes: Ploughing

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        observation: str = "estimate",
        estimator: str = "slip-ekf",
        depth_m: float = 0.25,
        slip_target: float = 0.12,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        nthread: int | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = Scenario.machine,
        implement: str | None = None,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, num_envs, max_episode_steps, observation, estimator, depth_m, slip_target,
            render_mode, autoreset_mode, nthread, width, height, camera, machine, implement,
            grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        threads, mode = _threads(num_envs, nthread), _mode(autoreset_mode)
        episodes = Ploughing(
            observation, estimator, depth_m, slip_target, num_envs, threads, machine, implement
        )
        self._hold(episodes, look, max_episode_steps, mode, grounds)


class PloughFieldVectorEnv(ManyEnv):
    """Many tractors on fields of two soils; each sees what `PloughFieldEnv` with its seed would.

    Arguments, actions, observations, reward and end are those of
    `twin.env.plough_field.PloughFieldEnv`, and those arguments that `PloughVectorEnv` adds.
    """

    episodes: FieldWork

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        observation: str = "estimate",
        estimator: str = "slip-ekf",
        depth_m: float = 0.25,
        law: str = "brixius",
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        nthread: int | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = Scenario.machine,
        implement: str | None = None,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, num_envs, max_episode_steps, observation, estimator, depth_m, law,
            render_mode, autoreset_mode, nthread, width, height, camera, machine, implement,
            grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        threads, mode = _threads(num_envs, nthread), _mode(autoreset_mode)
        episodes = FieldWork(
            observation, estimator, depth_m, law, num_envs, threads, machine, implement
        )
        self._hold(episodes, look, max_episode_steps, mode, grounds)


class WheelSlipVectorEnv(ManyEnv):
    """Many electric tractors side by side; each sees what `WheelSlipEnv` with its seed would.

    Arguments, actions, observations, reward and end are those of
    `twin.env.wheel_slip.WheelSlipEnv`, and those arguments that `PloughVectorEnv` adds.
    """

    episodes: Pulling

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        observation: str = "estimate",
        estimator: str = "four-state",
        slip_target: float = 0.15,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        nthread: int | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = USUAL_MACHINE,
        implement: str = USUAL_IMPLEMENT,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, num_envs, max_episode_steps, observation, estimator, slip_target,
            render_mode, autoreset_mode, nthread, width, height, camera, machine, implement,
            grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        threads, mode = _threads(num_envs, nthread), _mode(autoreset_mode)
        episodes = Pulling(
            observation, estimator, slip_target, num_envs, threads, machine, implement
        )
        self._hold(episodes, look, max_episode_steps, mode, grounds)


class SlipLineVectorEnv(ManyEnv):
    """Many electric tractors along their lines; each sees what `SlipLineEnv` with its seed would.

    Arguments, actions, observations, reward and end are those of
    `twin.env.slip_line.SlipLineEnv`, and those arguments that `PloughVectorEnv` adds.
    """

    episodes: Traction

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        observation: str = "estimate",
        estimator: str = "four-state",
        actuation: str = "torque",
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        nthread: int | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = USUAL_MACHINE,
        implement: str = USUAL_IMPLEMENT,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, num_envs, max_episode_steps, observation, estimator, actuation,
            render_mode, autoreset_mode, nthread, width, height, camera, machine, implement,
            grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        threads, mode = _threads(num_envs, nthread), _mode(autoreset_mode)
        episodes = Traction(
            observation, estimator, actuation, num_envs, threads, machine, implement
        )
        self._hold(episodes, look, max_episode_steps, mode, grounds)


def _threads(num_envs: int, nthread: int | None) -> int:
    """Threads of the physics: all cores, no more than tractors."""
    if num_envs < 1:
        raise OutOfRange("num_envs", num_envs, "[1, inf)")
    return nthread or min(num_envs, os.cpu_count() or 1)


def _mode(wanted: AutoresetMode | str) -> AutoresetMode:
    if isinstance(wanted, AutoresetMode):
        return wanted
    for mode in AutoresetMode:
        if wanted in (mode.name, mode.value):
            return mode
    raise UnknownName("autoreset_mode", str(wanted), [mode.name for mode in AutoresetMode])
