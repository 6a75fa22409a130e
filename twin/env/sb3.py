"""The native vector environments as stable-baselines3's `VecEnv`; needs the extra `rl`.

from twin.env.sb3 import TractorVecEnv
model = PPO("MlpPolicy", TractorVecEnv("Plough-v0", 64, observation="truth"))
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from twin.env.grounds import Options
from twin.env.infos import Infos
from twin.env.many import ManyEnv
from twin.errors import BadInput
from twin.plugins.extras import needed

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv
else:
    VecEnv = needed(
        "stable_baselines3.common.vec_env", "rl", "environments of stable-baselines3",
        "stable-baselines3",
    ).VecEnv  # fmt: skip

Indices = None | int | Iterable[int]


class TractorVecEnv(VecEnv):  # type: ignore[misc]  # Any where the extra is absent
    """Many tractors in one batch, as stable-baselines3 trains on them.

    An ended episode begins anew in the same step; its last observation is
    `infos[i]["terminal_observation"]`. `infos` hold what the environment's page says, and
    `TimeLimit.truncated`.
    """

    def __init__(self, env_id: str, num_envs: int, **arguments: Any) -> None:
        """Make the environment.

        Args:
            env_id: `Plough-v0`, say.
            num_envs: how many tractors.
            arguments: the vector environment's own; `max_episode_steps` is the registration's
                unless it is given.

        Raises:
            BadInput: `autoreset_mode` is given, which stable-baselines3 prescribes.
        """
        if "autoreset_mode" in arguments:
            raise BadInput("autoreset_mode cannot be given: stable-baselines3 resets in the step")
        env: Any = gymnasium.make_vec(
            f"twin.env:{env_id}", num_envs=num_envs, vectorization_mode="vector_entry_point",
            autoreset_mode=AutoresetMode.SAME_STEP, **arguments,
        )  # fmt: skip
        self.env: ManyEnv = env.unwrapped
        self.render_mode = self.env.render_mode
        self.taken: NDArray[np.float32] = np.zeros(0, np.float32)
        super().__init__(num_envs, self.env.single_observation_space, self.env.single_action_space)

    def reset(self) -> NDArray[np.float32]:
        """Begin all episodes, with the seeds and options that were set before."""
        seeds: list[int | None] = list(self._seeds)
        options: Options = self._one(self._options)
        observation, infos = self.env.reset(seed=seeds, options=options or None)
        self.reset_infos = self._rows(infos)
        self._reset_seeds()
        self._reset_options()
        return observation

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions for `step_wait`."""
        self.taken = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[Infos]]:
        """Drive all tractors for 20 ms."""
        observation, rewards, stalled, late, infos = self.env.step(self.taken)
        done = stalled | late
        final, last = infos.pop("final_obs", None), infos.pop("final_info", None)
        rows = self._rows(infos)
        ends = {} if last is None else dict(enumerate(self._rows(last)))
        for i in np.flatnonzero(done).tolist():
            rows[i] = {**ends[i], "terminal_observation": final[i]}
            rows[i]["TimeLimit.truncated"] = bool(late[i] and not stalled[i])
        return observation, rewards.astype(np.float32), done, rows

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """A picture of each tractor, with `render_mode` "rgb_array"."""
        return self.env.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """An attribute of the environment, the same for every tractor."""
        found = getattr(self, attr_name) if attr_name == "render_mode" else getattr(
            self.env, attr_name
        )  # fmt: skip
        return [found for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute of the environment, for all tractors at once."""
        setattr(self.env, attr_name, value)

    def env_method(
        self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any
    ) -> list[Any]:
        """Call a method of the environment once; its result for every tractor."""
        found = getattr(self.env, method_name)(*args, **kwargs)
        return [found for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type, indices: Indices = None) -> list[bool]:
        """No tractor is in a wrapper."""
        return [False for _ in self._get_indices(indices)]

    def _one(self, options: Sequence[Options]) -> Options:
        """Options of a reset. Raises BadInput where tractors have different ones."""
        if any(each != options[0] for each in options):
            raise BadInput("set_options: tractors have different options; give them as grounds=")
        return options[0]

    def _rows(self, infos: Infos) -> list[Infos]:
        """An info for each tractor from arrays over all."""
        columns = {n: v.tolist() for n, v in infos.items() if not n.startswith("_")}
        return [{name: column[i] for name, column in columns.items()} for i in range(self.num_envs)]
