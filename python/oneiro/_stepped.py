"""Episodes that are commanded cycle by cycle, many at a time. The environments of Gymnasium and of PettingZoo use them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

from . import _native
from ._errors import InputError
from ._experiment import checked, numbers, whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._native import Experiment

Seeds: TypeAlias = "int | list[int | None] | tuple[int | None, ...] | NDArray[np.integer[Any]] | None"
"""One seed, or one for each episode."""
MOTORS = 2
"""Commands of an action."""
GREATEST_READING = 1000.0
"""Readings of custom sensors are clipped to this magnitude; those of reference models that aren't from 0 to 1 are smaller."""


def autoreset(mode: str | AutoresetMode) -> AutoresetMode:
    """The mode of this name or value."""
    named = {str(own.value): own for own in AutoresetMode} | {own.name: own for own in AutoresetMode}
    found = mode if isinstance(mode, AutoresetMode) else named.get(mode) if isinstance(mode, str) else None
    if found is None:
        raise InputError(f"autoreset_mode: is {mode!r}; allowed: {', '.join(own.value for own in AutoresetMode)}")
    return found


class Episodes:
    """Episodes, of one robot or of several that share a world, and the seeds of the next ones. Arrays are `[episodes, robots, ..]`."""

    def __init__(
        self, exp: Experiment, count: int, backend: str, mode: str | AutoresetMode = AutoresetMode.NEXT_STEP
    ) -> None:
        self.count = whole("num_envs", count, 1)
        self.native = _native.Stepped(checked(exp), self.count, backend)
        self.robots = self.native.robots
        self.names = self.native.names
        self.mode = autoreset(mode)
        self.seeds: NDArray[np.uint64] | None = None
        # For each episode the number of the genome, and its own.
        self.numbers = np.zeros((self.count, 2), np.uint64)
        self.done = np.zeros(self.count, bool)
        self.begun = np.zeros(self.count, bool)
        self._have_begun = False
        self._length = self.native.length

    def spaces(self) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
        """Space of a robot's observations, and of its actions."""
        bounded = np.array(self.native.bounded, bool)
        low = np.where(bounded, np.float32(0), np.float32(-GREATEST_READING))
        high = np.where(bounded, np.float32(1), np.float32(GREATEST_READING))
        return gymnasium.spaces.Box(low, high), gymnasium.spaces.Box(-1.0, 1.0, (MOTORS,), np.float32)

    def actions(self, actions: Any, shape: tuple[int, ...]) -> NDArray[Any]:
        """Actions of all episodes, which have this shape."""
        is_single = getattr(actions, "dtype", None) == np.float32
        actions = numbers("actions", actions, np.float32 if is_single else np.float64)
        if actions.shape != shape:
            raise InputError(f"actions: have the shape {list(actions.shape)}; allowed: {list(shape)}")
        # Not a number is no maximum either.
        if not np.abs(actions).max(initial=0) <= 1:
            wrong = np.argwhere(~np.isfinite(actions))
            if len(wrong):
                place = "".join(f"[{index}]" for index in wrong[0])
                raise InputError(
                    f"actions{place}: is {actions[tuple(wrong[0])]}; allowed: -1 to 1; beyond, numbers are clipped"
                )
            actions = np.clip(actions, -1, 1)
        return actions.reshape(self.count, self.robots, MOTORS)

    def reset(self, seed: Seeds, options: dict[str, Any] | None) -> None:
        """Begins all episodes, or those of `options["reset_mask"]`."""
        mask = np.ones(self.count, bool)
        known(options, ["reset_mask"])
        if options and "reset_mask" in options:
            mask = options["reset_mask"]
            if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.count,):
                raise InputError(f"options: reset_mask isn't allowed; allowed: a boolean array, [{self.count}]")
            if not mask.any():
                raise InputError("options: reset_mask is False throughout; allowed: at least one True")
        self._begin(mask, *self._seeded(seed, mask))
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
            self._begin(self.done, *self._next(self.done), np.flatnonzero(going).astype(np.uintp), actions[going])
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
                self._begin(done, *self._next(done))
                observations = native.state()[0]
                self.done = np.zeros(self.count, bool)
        return observations, rewards, ended, truncated, infos

    def _seeded(self, seed: Seeds, mask: NDArray[np.bool_]) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
        """Seeds and numbers with which the episodes of a mask begin: first ones if they have a new seed, else next ones."""
        if self.seeds is None:
            self.seeds = np.random.default_rng().integers(2**63, size=self.count, dtype=np.uint64)
        seeds, numbers = self.seeds.copy(), self.numbers.copy()
        new = np.zeros(self.count, bool)
        if isinstance(seed, np.ndarray):
            seed = seed.tolist()
        if isinstance(seed, (list, tuple)):
            if len(seed) != self.count:
                raise InputError(f"seed: has {len(seed)} seeds; allowed: {self.count}, or one")
            for episode, own in enumerate(seed):
                if own is not None:
                    seeds[episode] = whole("seed", own)
                    numbers[episode] = 0
                    new[episode] = True
        elif seed is not None:
            seeds[:] = whole("seed", seed)
            numbers[:, 0] = np.arange(self.count)
            numbers[:, 1] = 0
            new[:] = True
        numbers[self.begun & ~new, 1] += np.uint64(1)
        # Episodes that go on keep theirs.
        return np.where(mask, seeds, self.seeds), np.where(mask[:, None], numbers, self.numbers)

    def _next(self, which: NDArray[np.bool_]) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
        """Seeds, and numbers of which some are the next."""
        assert self.seeds is not None
        numbers = self.numbers.copy()
        numbers[which, 1] += np.uint64(1)
        return self.seeds, numbers

    def _begin(
        self,
        which: NDArray[np.bool_],
        seeds: NDArray[np.uint64],
        numbers: NDArray[np.uint64],
        going: NDArray[np.uintp] | None = None,
        actions: NDArray[Any] | None = None,
    ) -> None:
        """Begins episodes, and steps those that go on. What is refused changes nothing."""
        self.native.step(going, actions, (np.flatnonzero(which).astype(np.uintp), seeds[which], numbers[which]))
        self.seeds, self.numbers = seeds, numbers


class Attributes:
    """Attributes of the environments of a vector."""

    num_envs: int
    single_observation_space: gymnasium.Space[Any]
    single_action_space: gymnasium.Space[Any]
    _episodes: Episodes

    def _poses(self) -> NDArray[np.float32]:
        raise NotImplementedError

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Calls each environment's method, or returns each one's attribute: those that `get_attr` has, and `render`."""
        if name == "render":
            return (None,) * self.num_envs
        values = self.get_attr(name)
        return tuple(value(*args, **kwargs) if callable(value) else value for value in values)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each environment: its `fitness` so far, `cycles` that have passed, its `pose`, or what all have."""
        _, _, fitness, cycles, _ = self._episodes.native.state()
        own = {"fitness": fitness, "cycles": cycles, "pose": self._poses()}
        if name in own:
            return tuple(own[name])
        spaces = {"observation_space": self.single_observation_space, "action_space": self.single_action_space}
        return (spaces[name] if name in spaces else getattr(self, name),) * self.num_envs

    def set_attr(self, name: str, values: Any) -> None:
        """Attributes of single environments can't be set."""
        raise NotImplementedError("the environments share one object, whose attributes can't be set")


def known(options: dict[str, Any] | None, allowed: list[str]) -> None:
    """Refuses options of a reset that have no effect."""
    if options is not None and not isinstance(options, dict):
        raise InputError(f"options: is {options!r}; allowed: a dictionary")
    for name in options or {}:
        if name not in allowed:
            raise InputError(f"options: {name} is unknown; allowed: {', '.join(allowed) or 'none'}")
