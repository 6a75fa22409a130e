"""Many tractors as one vector environment: seeds, partial resets, autoreset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.random import Generator
from numpy.typing import NDArray

from twin.env import grounds
from twin.env.episodes import REWARD, Episodes, checked
from twin.env.grounds import Ground, Options
from twin.env.infos import Infos, add, columns, masked
from twin.env.rendering import FPS, Camera, Look
from twin.env.saved_state import KeepsState
from twin.env.schedule import Grounds, of_episode, schedules
from twin.errors import BadInput

RENDER_MODES = ["rgb_array"]
Observations = NDArray[np.float32]
Stepped = tuple[Observations, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Infos]


class ManyEnv(VectorEnv[Observations, NDArray[np.float32], NDArray[Any]], KeepsState):
    """Vector environment of independent simulations, one tractor each.

    A subclass defines machine, observations and reward.
    """

    metadata: Infos = {  # noqa: RUF012  Gymnasium's name
        "render_modes": RENDER_MODES,
        "render_fps": FPS,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    kept = (
        "running", "elapsed", "ended", "seen", "generators", "seeds", "counts", "grounds",
    )  # fmt: skip
    """What changes in it beside its episodes."""

    def _hold(
        self,
        episodes: Episodes,
        look: Look,
        max_episode_steps: int | None,
        mode: AutoresetMode,
        grounds: Grounds = None,
    ) -> None:
        """Set what every environment has; called at the end of a constructor."""
        self.episodes, self.look, self.render_mode = episodes, look, look.render_mode
        self.num_envs = num_envs = len(episodes.actions)
        self.limit, self.mode = max_episode_steps, mode
        self.metadata = {**type(self).metadata, "autoreset_mode": self.mode}
        self.entries = episodes.entries
        self.single_observation_space = episodes.observation_space
        self.single_action_space = episodes.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.schedules = schedules(grounds, num_envs, episodes.recipe)
        self.counts, self.grounds = [0] * num_envs, Infos()
        self.generators: list[Generator | None] = [None] * num_envs
        self.seeds: list[int | None] = [None] * num_envs
        self.elapsed = np.zeros(num_envs, dtype=np.int64)
        self.ended = np.zeros(num_envs, dtype=np.bool_)
        self.seen = np.zeros(self.observation_space.shape or (), dtype=np.float32)
        self.running = False
        self.camera: Camera | None = None

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: Options | None = None,
    ) -> tuple[Observations, Infos]:
        """Begin episodes of all tractors, or of those in the option `reset_mask`.

        Args:
            seed: seed of the first tractor; tractor i gets seed + i. Or a sequence of length
                num_envs, in which None continues that tractor's generator.
            options: those of the single environment, and `reset_mask`, a boolean array (num_envs,).

        Raises:
            UnknownName, BadInput, OutOfRange: an invalid option, seed or mask.
        """
        named = dict(options or {})
        mask = self._mask(named.pop("reset_mask", None))
        chosen = grounds.check_options(named, self.episodes.recipe)
        self._seed(seed, mask)
        infos = self._begin(mask, chosen)
        self.running = True
        add(infos, self._look(mask), mask)
        add(infos, dict.fromkeys(self.episodes.rewarded, 0.0), mask)
        return self.seen.copy(), infos

    def step(self, actions: NDArray[np.float32]) -> Stepped:
        """Drive all tractors for 20 ms.

        An ended episode is reset in this step (SAME_STEP), in the next one (NEXT_STEP, which
        ignores its action and gives reward 0), or by `reset` alone (DISABLED).

        Raises:
            BadInput: actions of the wrong shape, or not finite.
            Diverged: a state is not finite, or MuJoCo warned; reset all tractors to go on.
            ResetNeeded: a tractor needs a reset first.
        """
        taken = checked(actions, (self.num_envs,), self.episodes.actions_named)
        again = self.ended.copy()
        if not self.running or (self.mode is AutoresetMode.DISABLED and again.any()):
            raise ResetNeeded("call reset() before step(), for every tractor whose episode ended")
        self.running = False  # until the step has gone well
        terminations = self.episodes.advance(taken) & ~again
        self.elapsed += 1
        if again.any():
            self._begin(again, {})
        truncations = np.zeros(self.num_envs, dtype=np.bool_)
        if self.limit is not None:
            truncations = self.elapsed >= self.limit
        self.running, self.ended = True, terminations | truncations
        self.seen = self.episodes.look()
        told = self.episodes.values_of((*self.episodes.known, *self.episodes.rewarded, REWARD))
        told = {n: np.where(again, 0.0, v) if n.startswith(REWARD) else v for n, v in told.items()}
        rewards = told.pop(REWARD)
        infos, everyone = Infos(), np.ones(self.num_envs, dtype=np.bool_)
        add(infos, told, everyone)
        infos |= masked(self.grounds, everyone)
        if self.mode is AutoresetMode.SAME_STEP and self.ended.any():
            self._begin_at_once(self.ended.copy(), told, infos)
        return self.seen.copy(), rewards, terminations, truncations, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """An RGB picture of each tractor, uint8, (height, width, 3); None without a render mode.

        Raises:
            DependencyNotInstalled: there is no OpenGL driver.
        """
        if self.render_mode is None:
            return None
        fleet = self.episodes.fleet
        if self.camera is None:
            self.camera = Camera(self.look, fleet)
        return tuple(self.camera.of(fleet, i) for i in range(self.num_envs))

    def close_extras(self, **kwargs: object) -> None:
        """Close the renderer."""
        if self.camera is not None:
            self.camera.close()
            self.camera = None

    def _mask(self, mask: object) -> NDArray[np.bool_]:
        if mask is None:
            return np.ones(self.num_envs, dtype=np.bool_)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise BadInput("option reset_mask is not a numpy array of booleans")
        if mask.shape != (self.num_envs,) or not mask.any():
            raise BadInput(
                f"option reset_mask has shape {mask.shape} and {mask.sum()} true; "
                f"give shape ({self.num_envs},) with one true at least"
            )
        if not (self.running or mask.all()):
            raise BadInput(
                "option reset_mask leaves out tractors without a state: none was reset yet, or "
                "the last step failed; reset all"
            )
        return mask

    def _seed(self, seed: int | Sequence[int | None] | None, mask: NDArray[np.bool_]) -> None:
        """New generators where a seed is given, or where there is none yet."""
        if isinstance(seed, (int, np.integer)):
            seed = [int(seed) + i for i in range(self.num_envs)]
        if seed is not None and len(seed) != self.num_envs:
            raise BadInput(f"{len(seed)} seeds for {self.num_envs} tractors; give one for each")
        for i in np.flatnonzero(mask).tolist():
            own = None if seed is None else seed[i]
            if own is not None or self.generators[i] is None:
                self.generators[i], self.seeds[i] = seeding.np_random(own)

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """The seed of each tractor's generator, as other vector environments report them."""
        return tuple(self.seeds)

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[Generator | None, ...]:  # type: ignore[override]
        """Each tractor's generator."""
        return tuple(self.generators)

    def _begin(self, mask: NDArray[np.bool_], options: Options) -> Infos:
        """New episodes of the tractors in the mask; their grounds as infos."""
        ids = np.flatnonzero(mask).tolist()
        drawn = [
            self._drawn(i, generator, options) for i in ids if (generator := self.generators[i])
        ]
        self.episodes.begin(ids, drawn)
        self.elapsed[mask], self.ended[mask] = 0, False
        for i in ids:
            self.counts[i] += 1
        infos = columns([ground.info(self.episodes.recipe) for ground in drawn], ids, mask)
        for name, column in infos.items():
            if not name.startswith("_"):
                self.grounds.setdefault(name, column.copy())[mask] = column[mask]
        return infos

    def _drawn(self, i: int, generator: Generator, options: Options) -> Ground:
        """A ground for one tractor, by its schedule and the options of a reset."""
        recipe = self.episodes.recipe
        scheduled = of_episode(self.schedules[i], self.counts[i], generator, recipe)
        return grounds.draw(generator, scheduled | options, self.episodes.shapes, recipe)

    def _look(self, mask: NDArray[np.bool_]) -> Infos:
        """Observe the tractors in the mask, who have just begun; what is known of them."""
        ids = np.flatnonzero(mask)
        self.seen[ids] = self.episodes.look(ids)
        return {
            name: value[ids] for name, value in self.episodes.values_of(self.episodes.known).items()
        }

    def _begin_at_once(self, ended: NDArray[np.bool_], last: Infos, infos: Infos) -> None:
        """SAME_STEP: what was last seen goes to the infos, and the ended begin anew."""
        final, final_info = np.full(self.num_envs, None, dtype=object), Infos()
        for i in np.flatnonzero(ended):
            final[i] = self.seen[i].copy()
        add(final_info, {name: value[ended] for name, value in last.items()}, ended)
        final_info |= masked(self.grounds, ended)
        self._begin(ended, {})
        for name, value in self._look(ended).items():
            infos[name][ended] = value
        for name in self.episodes.rewarded:
            infos[name][ended] = 0.0
        infos |= masked(self.grounds, np.ones_like(ended))
        infos |= {"final_obs": final, "_final_obs": ended}
        infos |= {"final_info": final_info, "_final_info": ended.copy()}
