"""Episodes that are commanded cycle by cycle, many at a time. The environments of Gymnasium and of PettingZoo use them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

from . import _native
from ._errors import InputError
from ._experiment import whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._native import Experiment

MOTORS = 2
"""Commands of an action."""
GREATEST_READING = 1000.0
"""Readings of custom sensors are clipped to this magnitude."""


class Episodes:
    """Episodes, of one robot or of several that share a world, and the seeds of the next ones. Arrays are `[episodes, robots, ..]`."""

    def __init__(
        self, exp: Experiment, count: int, backend: str, mode: str | AutoresetMode = AutoresetMode.NEXT_STEP
    ) -> None:
        self.native = _native.Stepped(exp, whole("num_envs", count, 1), backend)
        self.count = count
        self.robots = self.native.robots
        self.names = self.native.names
        self.mode = AutoresetMode(mode)
        self.seeds: NDArray[np.uint64] | None = None
        # For each episode the number of the genome, and its own.
        self.numbers = np.zeros((count, 2), np.uint64)
        self.done = np.zeros(count, bool)
        self.begun = np.zeros(count, bool)
        self._have_begun = False
        self._length = self.native.length

    def spaces(self) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
        """Space of a robot's observations, and of its actions."""
        bounded = self.native.bounded
        own = len(self.names) - bounded
        low = np.array([0.0] * bounded + [-GREATEST_READING] * own, np.float32)
        high = np.array([1.0] * bounded + [GREATEST_READING] * own, np.float32)
        return gymnasium.spaces.Box(low, high), gymnasium.spaces.Box(-1.0, 1.0, (MOTORS,), np.float32)

    def actions(self, actions: Any, shape: tuple[int, ...]) -> NDArray[Any]:
        """Actions of all episodes, which have this shape."""
        actions = np.asarray(actions)
        if actions.dtype != np.float32:
            actions = actions.astype(np.float64)
        if actions.shape != shape:
            raise InputError(f"actions: have the shape {list(actions.shape)}; allowed: {list(shape)}")
        return np.ascontiguousarray(actions).reshape(self.count, self.robots, MOTORS)

    def reset(
        self, seed: int | list[int | None] | tuple[int | None, ...] | None, options: dict[str, Any] | None
    ) -> None:
        """Begins all episodes, or those of `options["reset_mask"]`."""
        mask = np.ones(self.count, bool)
        if options and "reset_mask" in options:
            mask = options["reset_mask"]
            if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.count,):
                raise InputError(f"options: reset_mask isn't allowed; allowed: a boolean array, [{self.count}]")
            if not mask.any():
                raise InputError("options: reset_mask is False throughout; allowed: at least one True")
        new = self._seed(seed)
        self.native.step(None, None, self._beginning(mask, new | ~self.begun))
        self.begun |= mask
        self._have_begun = bool(self.begun.all())
        self.done &= ~mask

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Steps all episodes by one cycle. Ended ones restart according to the mode."""
        if not self._have_begun:
            raise InputError("step: some environments haven't begun; allowed: after reset")
        native = self.native
        if not self.done.any():
            native.step(None, actions, None)
        elif self.mode is AutoresetMode.NEXT_STEP:
            going = ~self.done
            native.step(np.flatnonzero(going).astype(np.uintp), actions[going], self._beginning(self.done))
        else:
            raise InputError("step: some episodes have ended; allowed: after reset with options={'reset_mask': ..}")
        observations, rewards, fitness, cycles, ended = native.state()
        truncated = (cycles == self._length) & ~ended
        done = self.done = ended | truncated
        infos: dict[str, Any] = {}
        if done.any():
            poses = np.where(done[:, None, None], native.poses(), np.float32(0))
            infos = {
                "fitness": np.where(done, fitness, np.float32(0)),
                "_fitness": done.copy(),
                "pose": poses,
                "_pose": done.copy(),
            }
            if self.mode is AutoresetMode.SAME_STEP:
                final = np.full(self.count, None, object)
                for episode in np.flatnonzero(done):
                    final[episode] = observations[episode].copy()
                infos = {"final_obs": final, "_final_obs": done, "final_info": infos, "_final_info": done.copy()}
                native.step(None, None, self._beginning(done))
                observations = native.state()[0]
                self.done = np.zeros(self.count, bool)
        return observations, rewards, ended, truncated, infos

    def _seed(self, seed: int | list[int | None] | tuple[int | None, ...] | None) -> NDArray[np.bool_]:
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
            for episode, own in enumerate(seed):
                if own is not None:
                    self.seeds[episode] = whole("seed", own)
                    self.numbers[episode] = 0
                    new[episode] = True
            return new
        self.seeds[:] = whole("seed", seed)
        self.numbers[:, 0] = np.arange(self.count)
        self.numbers[:, 1] = 0
        new[:] = True
        return new

    def _beginning(self, which: NDArray[np.bool_], new: NDArray[np.bool_] | None = None) -> _native.Beginning:
        """What begins episodes: new ones by their seeds, the others with their next number."""
        assert self.seeds is not None
        self.numbers[which if new is None else which & ~new, 1] += np.uint64(1)
        return np.flatnonzero(which).astype(np.uintp), self.seeds[which], self.numbers[which]
