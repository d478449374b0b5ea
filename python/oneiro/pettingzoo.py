"""Swarms as environments for PettingZoo 1.25 and later, and many of them at a time.

A step is a control cycle of 100 ms. An action commands a robot's two motors, from -1, fastest backwards, to 1, fastest forwards; an
observation is the robot's readings, as its controller gets them (`ParallelEnv.readings` names them). The reward is what the task
gives the robot, plus what the mission gives to all together; if the mission has a score, it is the change of that score. The
experiment's controller is not used. The mission may end an episode early, which terminates it; after its last cycle it is truncated.

With the seed `s`, episode `j` of arena `i` is episode `j` of genome `i` in `oneiro.evaluate(exp, genomes, seed=s)`: a controller's
outputs as actions, `2 * output - 1` in double precision, give the same bits of fitness. (Outputs below 2^-29 are rounded.)

In the foraging study a robot also reads whether it carries food, and the reward is for food brought to the nest. All robots are
switched on from the start, and their intervals begin together. There is no on-board evolution.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
import pettingzoo
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _native
from ._errors import InputError
from ._experiment import checked, numbers, whole
from ._stepped import MOTORS, Attributes, Episodes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._native import Experiment

__all__ = ["ParallelEnv", "VectorEnv"]


class _Foragers:
    """The arena of the foraging study, as `Episodes` has one."""

    def __init__(self, exp: Experiment, backend: str) -> None:
        self._arena = _native.Arena(exp, backend)
        self.robots = self._arena.robots
        self.names = list(self._arena.names)
        self._seed: int | None = None
        self._life = 0

    def spaces(self) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
        return (
            gymnasium.spaces.Box(0.0, 1.0, (len(self.names),), np.float32),
            gymnasium.spaces.Box(-1.0, 1.0, (MOTORS,), np.float32),
        )

    def reset(self, seed: int | None) -> NDArray[np.float32]:
        if seed is None and self._seed is not None:
            self._life += 1
        else:
            self._seed = int(np.random.default_rng().integers(2**63)) if seed is None else whole("seed", seed)
            self._life = 0
        self._arena.begin(self._seed, self._life)
        return self._arena.state()[0]

    def step(self, actions: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[Any], bool, bool, dict[str, Any]]:
        self._arena.step(actions.astype(np.float32))
        readings, rewards = self._arena.state()
        return readings, rewards, False, self._arena.cycle == self._arena.length, {}

    def poses(self) -> NDArray[np.float32]:
        return self._arena.poses()


class _Arena:
    """One arena of any other swarm."""

    def __init__(self, exp: Experiment, backend: str) -> None:
        self._episodes = _swarm(exp, 1, backend, AutoresetMode.DISABLED)
        self.robots = self._episodes.robots
        self.names = self._episodes.names
        self.spaces = self._episodes.spaces

    def reset(self, seed: int | None) -> NDArray[np.float32]:
        self._episodes.reset(seed, None)
        return self._episodes.native.state()[0][0]

    def step(self, actions: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[Any], bool, bool, dict[str, Any]]:
        readings, rewards, ended, truncated, infos = self._episodes.step(actions[None])
        final = {"fitness": float(infos["fitness"][0])} if infos else {}
        return readings[0], rewards[0], bool(ended[0]), bool(truncated[0]), final

    def poses(self) -> NDArray[np.float32]:
        return self._episodes.native.poses()[0]


def _swarm(exp: Experiment, count: int, backend: str, mode: str | AutoresetMode) -> Episodes:
    if "robot.count" not in exp.settings:
        raise InputError(f"{exp.name}: it has a single robot, not a swarm; allowed: experiments with robot.count")
    return Episodes(exp, count, backend, mode)


def _is_foraging(exp: Experiment) -> bool:
    """Whether it is of the foraging study."""
    return any(key.startswith("swarm.") for key in checked(exp).settings)


class ParallelEnv(pettingzoo.ParallelEnv):
    """The robots of a swarm as agents: `robot_0`, `robot_1`, and so on. All act at once, and their episode ends for all."""

    metadata: dict[str, Any] = {"name": "oneiro_swarm_v0", "render_modes": []}

    def __init__(self, exp: Experiment, *, backend: str = "cpu") -> None:
        self._arena = _Foragers(exp, backend) if _is_foraging(exp) else _Arena(exp, backend)
        self.exp = exp
        self.render_mode = None
        self.readings = list(self._arena.names)
        self.possible_agents = [f"robot_{robot}" for robot in range(self._arena.robots)]
        self.agents: list[str] = []
        spaces = [self._arena.spaces() for _ in self.possible_agents]
        self._observation_spaces = {agent: own[0] for agent, own in zip(self.possible_agents, spaces, strict=True)}
        self._action_spaces = {agent: own[1] for agent, own in zip(self.possible_agents, spaces, strict=True)}
        self.state_space = gymnasium.spaces.Box(-np.inf, np.inf, (self._arena.robots, 3), np.float32)

    def observation_space(self, agent: str) -> gymnasium.spaces.Box:
        """Space of an agent's observations."""
        return self._observation_spaces[agent]

    def action_space(self, agent: str) -> gymnasium.spaces.Box:
        """Space of an agent's actions."""
        return self._action_spaces[agent]

    def state(self) -> NDArray[np.float32]:
        """The robots' poses, `[robots, 3]`: x and y in mm, and the heading in turns."""
        return self._arena.poses()

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begins an episode: with a seed its first one, otherwise the next."""
        # PettingZoo's own tests give options that no environment knows.
        readings = self._arena.reset(seed)
        self.agents = list(self.possible_agents)
        return self._named(readings), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[
        dict[str, NDArray[np.float32]],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Steps all robots by one cycle. At the end of an episode each info has its `fitness`, except in the foraging study."""
        if not self.agents:
            return {}, {}, {}, {}, {}
        if not isinstance(actions, Mapping) or set(actions) != set(self.agents):
            given = f"of {list(actions)}" if isinstance(actions, Mapping) else f"{type(actions).__name__}"
            raise InputError(f"actions: are {given}; allowed: one for each of {self.agents}")
        told = [numbers(f"actions[{agent!r}]", actions[agent], np.float64) for agent in self.agents]
        for agent, own in zip(self.agents, told, strict=True):
            if own.shape != (MOTORS,):
                raise InputError(f"actions[{agent!r}]: has the shape {list(own.shape)}; allowed: [{MOTORS}]")
            if not np.isfinite(own).all():
                raise InputError(
                    f"actions[{agent!r}]: is {own.tolist()}; allowed: -1 to 1; beyond, numbers are clipped"
                )
        readings, rewards, terminated, truncated, info = self._arena.step(np.clip(told, -1.0, 1.0))
        agents = self.agents
        if terminated or truncated:
            self.agents = []
        return (
            self._named(readings),
            {agent: float(reward) for agent, reward in zip(agents, rewards, strict=True)},
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            {agent: dict(info) for agent in agents},
        )

    def _named(self, readings: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
        return {agent: readings[robot].copy() for robot, agent in enumerate(self.possible_agents)}

    def render(self) -> None:
        """Draws nothing."""

    def close(self) -> None:
        """Ends."""


class VectorEnv(Attributes):
    """Many arenas of a swarm, stepped together in the simulator's kernels: all arrays are `[num_envs, robots, ..]`.

    It is used like `oneiro.gym.VectorEnv`, with the same seeds and modes. Observations and rewards have a row for each robot, and so has
    `pose` in `infos`; `fitness`, and whether an episode is terminated or truncated, are of the whole arena. `single_observation_space`
    and `single_action_space` are a robot's. Not for the foraging study.
    """

    metadata: dict[str, Any] = {"name": "oneiro_swarm_v0", "render_modes": []}

    def __init__(
        self,
        exp: Experiment,
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        *,
        backend: str = "cpu",
    ) -> None:
        if _is_foraging(exp):
            raise InputError(
                f"{exp.name}: is of the foraging study; allowed: ParallelEnv, or experiments with robot.count"
            )
        self._episodes = _swarm(exp, num_envs, backend, autoreset_mode)
        self.exp = exp
        self.num_envs = num_envs = self._episodes.count
        self.robots = self._episodes.robots
        self.autoreset_mode = self._episodes.mode
        self.readings = list(self._episodes.names)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.render_mode = None
        self.single_observation_space, self.single_action_space = self._episodes.spaces()
        rows = (batch_space(space, self.robots) for space in self._episodes.spaces())
        self.observation_space, self.action_space = (batch_space(space, num_envs) for space in rows)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins all episodes, or those of `options["reset_mask"]`."""
        self._episodes.reset(seed, options)
        return self._episodes.native.state()[0], {}

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Steps all robots of all arenas by one cycle. Ended episodes restart according to `autoreset_mode`."""
        return self._episodes.step(self._episodes.actions(actions, (self.num_envs, self.robots, MOTORS)))

    def state(self) -> NDArray[np.float32]:
        """All robots' poses, `[num_envs, robots, 3]`: x and y in mm, and the heading in turns."""
        return self._poses()

    def _poses(self) -> NDArray[np.float32]:
        return self._episodes.native.poses()

    def close(self) -> None:
        """Ends."""
