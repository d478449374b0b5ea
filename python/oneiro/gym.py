"""Environments for Gymnasium 1.1 and later.

A step is a control cycle of 100 ms. An action commands the two motors, from -1, fastest backwards, to 1, fastest
forwards; an observation is the robot's readings, as a controller gets them; the reward is the task's. The experiment's controller is
not used. The task or an empty battery may end an episode early, which terminates it; after its last cycle it is truncated.

With the seed `s`, episode `j` of environment `i` is episode `j` of genome `i` in `oneiro.evaluate(exp, genomes, seed=s)`: a
controller's outputs as actions, `2 * output - 1` in double precision, give the same bits of rewards and fitness. (Outputs below
2^-29 are rounded.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _native
from ._errors import InputError
from ._experiment import whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._native import Experiment

__all__ = ["Env", "VectorEnv"]

MOTORS = 2
"""Commands of an action."""
GREATEST_READING = 1000.0
"""Readings of custom sensors are clipped to this magnitude."""


def spaces(lives: _native.Stepped) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
    """Space of the observations, and of the actions."""
    own = len(lives.names) - lives.bounded
    low = np.array([0.0] * lives.bounded + [-GREATEST_READING] * own, np.float32)
    high = np.array([1.0] * lives.bounded + [GREATEST_READING] * own, np.float32)
    return gymnasium.spaces.Box(low, high), gymnasium.spaces.Box(-1.0, 1.0, (MOTORS,), np.float32)


def commands(actions: Any, lives: int) -> NDArray[np.float32]:
    """Actions as commands, 0 to 1. In double precision, so that a command from 2^-29 on that was made an action is the same again."""
    actions = np.asarray(actions, np.float64)
    if actions.shape != (lives, MOTORS):
        raise InputError(f"actions: have the shape {list(actions.shape)}; allowed: [{lives}, {MOTORS}]")
    return (0.5 * (actions + 1.0)).astype(np.float32)


class Lives:
    """Episodes, and the seeds of the next ones."""

    def __init__(self, exp: Experiment, count: int, backend: str) -> None:
        self.native = _native.Stepped(exp, whole("num_envs", count, 1), backend)
        self.count = count
        self.seeds: NDArray[np.uint64] | None = None
        # For each environment the number of the genome, and that of the episode.
        self.numbers = np.zeros((count, 2), np.uint64)

    def seed(self, seed: int | list[int | None] | tuple[int | None, ...] | None) -> NDArray[np.bool_]:
        """Sets the seeds of the next episodes. Returns which are new; the others continue with their next episode."""
        new = np.zeros(self.count, bool)
        if self.seeds is None:
            self.seeds = np.random.default_rng().integers(2**63, size=self.count, dtype=np.uint64)
            self.numbers[:, 1] = 0
            new[:] = True
        if seed is None:
            return new
        if isinstance(seed, (list, tuple)):
            if len(seed) != self.count:
                raise InputError(f"seed: has {len(seed)} seeds; allowed: {self.count}, or one")
            for life, own in enumerate(seed):
                if own is not None:
                    self.seeds[life] = whole("seed", own)
                    self.numbers[life] = 0
                    new[life] = True
            return new
        self.seeds[:] = whole("seed", seed)
        self.numbers[:, 0] = np.arange(self.count)
        self.numbers[:, 1] = 0
        new[:] = True
        return new

    def begin(self, which: NDArray[np.bool_], new: NDArray[np.bool_] | None = None) -> None:
        """Begins episodes: new ones by their seeds, the others with their next number."""
        assert self.seeds is not None
        self.numbers[which if new is None else which & ~new, 1] += np.uint64(1)
        who = np.flatnonzero(which).astype(np.uintp)
        self.native.begin(who, self.seeds[which], self.numbers[which])


class VectorEnv(gymnasium.vector.VectorEnv):
    """Many environments, stepped together in the simulator's kernels.

    `infos` has the `fitness` of episodes that end with this step, and the mask `_fitness`; with `SAME_STEP` these are in
    `final_info`, beside `final_obs`. Observations are new arrays in every step. Readings of a terminated episode are 0.
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
        self._lives = Lives(exp, num_envs, backend)
        self.exp = exp
        self.num_envs = num_envs
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.render_mode = None
        self.single_observation_space, self.single_action_space = spaces(self._lives.native)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._length = self._lives.native.length
        self._done = np.zeros(num_envs, bool)
        self._begun = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins all episodes, or those of `options["reset_mask"]`.

        One seed gives each environment different starts and noise; with a list, each has those of a single `Env` with that seed.
        """
        mask = np.ones(self.num_envs, bool)
        if options and "reset_mask" in options:
            mask = options["reset_mask"]
            if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
                raise InputError(f"options: reset_mask isn't allowed; allowed: a boolean array, [{self.num_envs}]")
            if not mask.any():
                raise InputError("options: reset_mask is False throughout; allowed: at least one True")
        new = self._lives.seed(seed)
        self._lives.begin(mask, new | ~self._begun)
        self._begun |= mask
        self._done &= ~mask
        return self._lives.native.state()[0], {}

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Steps all episodes by one cycle. Ended ones restart according to `autoreset_mode`."""
        if not self._begun.all():
            raise InputError("step: some environments haven't begun; allowed: after reset")
        told = commands(actions, self.num_envs)
        lives = self._lives
        if not self._done.any():
            lives.native.step(None, told)
        elif self.autoreset_mode is AutoresetMode.NEXT_STEP:
            who = np.flatnonzero(~self._done).astype(np.uintp)
            lives.native.step(who, told[~self._done])
            lives.begin(self._done)
        else:
            raise InputError("step: some episodes have ended; allowed: after reset with options={'reset_mask': ..}")
        observations, rewards, fitness, cycles, ended = lives.native.state()
        truncated = (cycles == self._length) & ~ended
        self._done = ended | truncated
        infos: dict[str, Any] = {}
        if self._done.any():
            done = self._done.copy()
            infos = {"fitness": np.where(done, fitness, np.float32(0)), "_fitness": done}
            if self.autoreset_mode is AutoresetMode.SAME_STEP:
                final = np.full(self.num_envs, None, object)
                for life in np.flatnonzero(done):
                    final[life] = observations[life].copy()
                infos = {"final_obs": final, "_final_obs": done, "final_info": infos, "_final_info": done.copy()}
                lives.begin(done)
                observations = lives.native.state()[0]
                self._done = np.zeros(self.num_envs, bool)
        return observations, rewards, ended, truncated, infos


class Env(gymnasium.Env):
    """A single environment. Many are stepped together much faster: `VectorEnv`."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, exp: Experiment, *, backend: str = "cpu") -> None:
        self._lives = Lives(exp, 1, backend)
        self.exp = exp
        self.render_mode = None
        self.observation_space, self.action_space = spaces(self._lives.native)
        self._length = self._lives.native.length

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode: with a seed its first one, otherwise the next."""
        super().reset(seed=seed)
        self._lives.begin(np.ones(1, bool), self._lives.seed(seed))
        return self._lives.native.state()[0][0], {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Steps the episode by one cycle. At its end `info` has its `fitness`."""
        self._lives.native.step(None, commands(np.asarray(action)[None], 1))
        observations, rewards, fitness, cycles, ended = self._lives.native.state()
        terminated = bool(ended[0])
        truncated = bool(cycles[0] == self._length) and not terminated
        info = {"fitness": float(fitness[0])} if terminated or truncated else {}
        return observations[0], float(rewards[0]), terminated, truncated, info
