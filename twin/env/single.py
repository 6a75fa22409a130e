"""One tractor as a Gymnasium environment: the part that all environments share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import gymnasium
import numpy as np
from gymnasium import Env
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from twin.env import grounds
from twin.env.episodes import REWARD, Episodes, checked
from twin.env.grounds import Options
from twin.env.infos import Infos
from twin.env.rendering import FPS, Look, Screen, screen
from twin.env.saved_state import KeepsState
from twin.env.schedule import Grounds, of_episode, schedules
from twin.errors import BadInput

RENDER_MODES = ["rgb_array", "human"]
Observation = NDArray[np.float32]
OneEnv: TypeAlias = Env[Observation, NDArray[np.float32]]
"""An environment of one tractor, in wrappers or not."""


def made(env_id: str) -> OneEnv:
    """A registered environment of one tractor, by its id."""
    env: OneEnv = gymnasium.make(f"twin.env:{env_id}")
    return env


def episodes_of(env: OneEnv) -> Episodes:
    """The episodes of an environment of one tractor. Raises BadInput for another's."""
    if not isinstance(env.unwrapped, SingleEnv):
        raise BadInput(f"{env} is no environment of one tractor of twin.env")
    return env.unwrapped.episodes


class SingleEnv(Env[Observation, NDArray[np.float32]], KeepsState):
    """Environment of one tractor; a subclass defines machine, observations and reward."""

    metadata = {"render_modes": RENDER_MODES, "render_fps": FPS}  # noqa: RUF012  Gymnasium's name

    kept = ("running", "ended", "count", "ground", "_np_random", "_np_random_seed")
    """What changes in it beside its episodes."""

    def _hold(self, episodes: Episodes, look: Look, grounds: Grounds = None) -> None:
        """Set what every environment has; called at the end of a constructor."""
        (self.schedule,) = schedules(grounds, 1, episodes.recipe)
        self.episodes, self.look, self.render_mode = episodes, look, look.render_mode
        self.entries = episodes.entries
        self.observation_space = episodes.observation_space
        self.action_space = episodes.action_space
        self.names = (*episodes.known, *episodes.rewarded, REWARD)
        self.screen: Screen | None = None
        self.running = self.ended = False
        self.count, self.ground = 0, Infos()

    def reset(
        self, *, seed: int | None = None, options: Options | None = None
    ) -> tuple[Observation, Infos]:
        """Begin an episode on a new ground.

        Raises:
            UnknownName, BadInput, OutOfRange: an invalid option; see `grounds.OPTIONS`.
        """
        recipe = self.episodes.recipe
        chosen = grounds.check_options(options, recipe)
        super().reset(seed=seed)
        chosen = of_episode(self.schedule, self.count, self.np_random, recipe) | chosen
        ground = grounds.draw(self.np_random, chosen, self.episodes.shapes, recipe)
        self.episodes.begin([0], [ground])
        self.running, self.ended = True, False
        self.count, self.ground = self.count + 1, ground.info(recipe)
        (observation,) = self.episodes.look()
        info = self._infos(self.episodes.known) | dict.fromkeys(self.episodes.rewarded, 0.0)
        self._show()
        return observation, info | self.ground

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, Infos]:
        """Drive for 20 ms.

        Raises:
            BadInput: an action of the wrong shape, or one that is not finite.
            Diverged: a state is not finite, or MuJoCo warned; reset to go on.
            ResetNeeded: there was no reset, the last step failed, or the episode has ended.
        """
        taken = checked(action, (), self.episodes.actions_named)
        if not self.running or self.ended:
            why = "the episode has ended; " if self.ended else ""
            raise ResetNeeded(f"{why}call reset() before step()")
        self.running = False  # until the step has gone well
        stalled = self.episodes.advance(taken)
        self.running, self.ended = True, bool(stalled[0])
        (observation,) = self.episodes.look()
        info = self._infos(self.names)
        reward = info.pop(REWARD)
        self._show()
        return observation, reward, self.ended, False, info | self.ground

    def render(self) -> NDArray[np.uint8] | None:
        """Render the tractor in its present state.

        Returns:
            An RGB picture, uint8, shape (height, width, 3), with `render_mode` "rgb_array"; None
            with "human", which draws in a window, and without a render mode.

        Raises:
            DependencyNotInstalled: there is no OpenGL driver, or no display for a window.
        """
        if self.render_mode is None:
            return None
        if self.screen is None:
            self.screen = screen(self.look, self.episodes.fleet)
        return self.screen.of(self.episodes.fleet, 0)

    def close(self) -> None:
        """Close the renderer."""
        if self.screen is not None:
            self.screen.close()
            self.screen = None

    def _infos(self, names: Sequence[str]) -> Infos:
        """What is known by name."""
        values, place = self.episodes.values[:, 0].tolist(), self.episodes.place
        return {name: values[place[name]] for name in names}

    def _show(self) -> None:
        """In a window, every control step is shown unasked."""
        if self.render_mode == "human":
            self.render()
