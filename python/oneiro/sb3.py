"""Environments for Stable-Baselines3 2.6 and later."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common import vec_env

from .gym import VectorEnv

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ._native import Experiment

__all__ = ["VecEnv"]


class VecEnv(vec_env.VecEnv):
    """Many environments, stepped together: those of `oneiro.gym.VectorEnv`, as Stable-Baselines3 calls them.

    Its learners need no `DummyVecEnv` or `SubprocVecEnv` around it. `infos` has `terminal_observation`, `TimeLimit.truncated` and the
    episode's return and length, as its `Monitor` records them; `fitness` is the episode's.
    """

    def __init__(self, exp: Experiment, num_envs: int = 1, *, backend: str = "cpu") -> None:
        self._envs = VectorEnv(exp, num_envs, AutoresetMode.SAME_STEP, backend=backend)
        self._actions: Any = None
        self._returns = np.zeros(num_envs)
        self._lengths = np.zeros(num_envs, np.int64)
        super().__init__(num_envs, self._envs.single_observation_space, self._envs.single_action_space)

    def reset(self) -> np.ndarray:
        """Begins all episodes."""
        seeds = list(self._seeds)
        observations, _ = self._envs.reset(seed=None if all(seed is None for seed in seeds) else seeds)
        self._reset_seeds()
        self._reset_options()
        self._returns[:] = 0
        self._lengths[:] = 0
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Takes actions."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Steps all episodes by one cycle."""
        observations, rewards, terminated, truncated, infos = self._envs.step(self._actions)
        self._returns += rewards
        self._lengths += 1
        done = terminated | truncated
        all_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for life in np.flatnonzero(done):
            all_infos[life] = {
                "terminal_observation": infos["final_obs"][life],
                "TimeLimit.truncated": bool(truncated[life]),
                "fitness": float(infos["final_info"]["fitness"][life]),
                "episode": {"r": float(self._returns[life]), "l": int(self._lengths[life])},
            }
        self._returns[done] = 0
        self._lengths[done] = 0
        return observations, rewards.astype(np.float32), done, all_infos

    def close(self) -> None:
        """Ends."""
        self._envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of each environment: those that `oneiro.gym.VectorEnv.get_attr` has."""
        values = self._envs.get_attr(attr_name)
        return [values[index] for index in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Attributes of single environments are not supported."""
        raise NotImplementedError("the environments share one object, whose attributes can't be set")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Methods of single environments are not supported."""
        raise NotImplementedError("the environments share one object, whose methods can't be called")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """None is wrapped."""
        return [False for _ in self._get_indices(indices)]

    def _get_indices(self, indices: Any) -> Sequence[int]:
        return range(self.num_envs) if indices is None else np.atleast_1d(indices).tolist()
