"""Environments for Gymnasium 1.1 and later.

A step is a control cycle of 100 ms. An action commands the two motors, from -1, fastest backwards, to 1, fastest
forwards, beyond which actions are clipped; an observation is the robot's readings, as a controller gets them; the reward is the task's,
or the change of its score if it has one (`task_score`). The experiment's controller is not used. The task or an empty battery may end an episode early, which terminates it; after its last cycle it is truncated.

With the seed `s`, episode `j` of environment `i` is episode `j` of genome `i` in `oneiro.evaluate(exp, genomes, seed=s)`: a
controller's outputs as actions, `2 * output - 1` in double precision, give the same bits of rewards and fitness. (Outputs below
2^-29 are rounded.)

Once this module is imported, the experiments that ship have ids, such as `oneiro/KheperaAvoidance-v0`; `oneiro/Experiment-v0` takes the
argument `path`, and all take `set` and `backend`. Without an import, write `oneiro.gym:oneiro/KheperaAvoidance-v0`. Swarms are environments of PettingZoo: `oneiro.pettingzoo`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _native
from ._errors import InputError
from ._experiment import checked
from ._native import Experiment
from ._stepped import MOTORS, Attributes, Episodes, known

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from numpy.typing import NDArray

__all__ = ["Env", "VectorEnv", "make", "make_vec"]


def _single(exp: Experiment, count: int, backend: str, mode: str | AutoresetMode = AutoresetMode.NEXT_STEP) -> Episodes:
    """Episodes of single robots."""
    if "robot.count" in checked(exp).settings:
        raise InputError(f"{exp.name}: is a swarm; allowed: single robots here, and swarms in oneiro.pettingzoo")
    return Episodes(exp, count, backend, mode)


class VectorEnv(Attributes, gymnasium.vector.VectorEnv):
    """Many environments, stepped together in the simulator's kernels.

    `infos` has the `fitness` of episodes that end with this step, their last `pose` (x and y in mm, and the heading in turns) and the
    masks `_fitness` and `_pose`; with `SAME_STEP` these are in `final_info`, beside `final_obs`. Observations are new arrays in every
    step. Readings of a terminated episode are 0.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        exp: Experiment,
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        *,
        backend: str = "cpu",
    ) -> None:
        self._episodes = _single(exp, num_envs, backend, autoreset_mode)
        self.exp = exp
        self.num_envs = num_envs = self._episodes.count
        self.autoreset_mode = self._episodes.mode
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.render_mode = None
        self.single_observation_space, self.single_action_space = self._episodes.spaces()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins all episodes, or those of `options["reset_mask"]`.

        One seed gives each environment different starts and noise; with a list, each has those of a single `Env` with that seed.
        """
        self._episodes.reset(seed, options)
        return self._episodes.native.state()[0][:, 0], {}

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Steps all episodes by one cycle. Ended ones restart according to `autoreset_mode`."""
        episodes = self._episodes
        observations, rewards, ended, truncated, infos = episodes.step(
            episodes.actions(actions, (self.num_envs, MOTORS))
        )
        if infos:
            # Of the one robot.
            final = infos.get("final_info", infos)
            final["pose"] = final["pose"][:, 0]
            for episode in np.flatnonzero(infos.get("_final_obs", ())):
                infos["final_obs"][episode] = infos["final_obs"][episode][0]
        return observations[:, 0], rewards[:, 0], ended, truncated, infos

    def _poses(self) -> NDArray[np.float32]:
        return self._episodes.native.poses()[:, 0]


class Env(gymnasium.Env):
    """A single environment. Many are stepped together much faster: `VectorEnv`."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, exp: Experiment, *, backend: str = "cpu") -> None:
        self._episodes = _single(exp, 1, backend, AutoresetMode.DISABLED)
        self.exp = exp
        self.render_mode = None
        self.observation_space, self.action_space = self._episodes.spaces()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode: with a seed its first one, otherwise the next."""
        super().reset(seed=seed)
        known(options, [])
        self._episodes.reset(seed, None)
        return self._episodes.native.state()[0][0, 0], {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Steps the episode by one cycle. At its end `info` has its `fitness` and its last `pose`."""
        episodes = self._episodes
        observations, rewards, ended, truncated, infos = episodes.step(episodes.actions(action, (MOTORS,)))
        info = {"fitness": float(infos["fitness"][0]), "pose": infos["pose"][0, 0]} if infos else {}
        return observations[0, 0], float(rewards[0, 0]), bool(ended[0]), bool(truncated[0]), info


def _experiment(
    experiment: str | None, path: str | os.PathLike[str] | None, set: Mapping[str, Any] | None
) -> Experiment:
    if (experiment is None) == (path is None):
        raise InputError("make: takes `path`, of an experiment's file; allowed: one of `path` and `experiment`, a name")
    return Experiment.load(path, set) if path is not None else Experiment.example(str(experiment), set)


def make(
    experiment: str | None = None,
    path: str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    backend: str = "cpu",
) -> Env:
    """The environment of an experiment that ships, or of a file; called by `gymnasium.make`."""
    return Env(_experiment(experiment, path, set), backend=backend)


def make_vec(
    num_envs: int = 1,
    experiment: str | None = None,
    path: str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    backend: str = "cpu",
) -> VectorEnv:
    """Many of them; called by `gymnasium.make_vec`."""
    return VectorEnv(_experiment(experiment, path, set), num_envs, autoreset_mode, backend=backend)


def _register() -> None:
    """Registers ids. Gymnasium 1 asks no package for its environments: they are there once this module is imported."""
    for experiment in [None, *_native.examples_of_single_robots()]:
        name = "".join(word.capitalize() for word in (experiment or "experiment").split("-"))
        gymnasium.register(
            id=f"oneiro/{name}-v0",
            entry_point="oneiro.gym:make",
            vector_entry_point="oneiro.gym:make_vec",
            kwargs={} if experiment is None else {"experiment": experiment},
        )


_register()
