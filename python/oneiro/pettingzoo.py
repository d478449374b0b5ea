"""The arena of a swarm as an environment for PettingZoo 1.25 and later.

A step is a control cycle of 100 ms. An action is the speeds of a robot's two wheels as fractions of the maximum, -1 to 1. An observation
is its readings, and whether it carries food, 0 to 1 (`ParallelEnv.readings` names them). The reward is for food brought to the nest,
as in the study of 2014. All robots are switched on from the start, and their intervals begin together. There is no on-board
evolution.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
import pettingzoo

from . import _native
from ._errors import InputError
from ._experiment import whole

if TYPE_CHECKING:
    from ._native import Experiment

__all__ = ["ParallelEnv"]


class ParallelEnv(pettingzoo.ParallelEnv):
    """The robots of a swarm as agents: `robot_0`, `robot_1`, and so on. All act at once; the end of the episode truncates them."""

    metadata: dict[str, Any] = {"name": "oneiro_swarm_v0", "render_modes": []}

    def __init__(self, exp: Experiment, *, backend: str = "cpu") -> None:
        self._arena = _native.Arena(exp, backend)
        self.exp = exp
        self.render_mode = None
        self.readings = list(self._arena.names)
        self.possible_agents = [f"robot_{robot}" for robot in range(self._arena.robots)]
        self.agents: list[str] = []
        self._observation_spaces = {
            agent: gymnasium.spaces.Box(0.0, 1.0, (len(self.readings),), np.float32) for agent in self.possible_agents
        }
        self._action_spaces = {
            agent: gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32) for agent in self.possible_agents
        }
        self._seed: int | None = None
        self._life = 0

    def observation_space(self, agent: str) -> gymnasium.spaces.Box:
        """Space of an agent's observations."""
        return self._observation_spaces[agent]

    def action_space(self, agent: str) -> gymnasium.spaces.Box:
        """Space of an agent's actions."""
        return self._action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Begins an episode: with a seed its first one, otherwise the next."""
        if seed is None and self._seed is not None:
            self._life += 1
        else:
            self._seed = int(np.random.default_rng().integers(2**63)) if seed is None else whole("seed", seed)
            self._life = 0
        self._arena.begin(self._seed, self._life)
        self.agents = list(self.possible_agents)
        return self._named(self._arena.state()[0]), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[
        dict[str, np.ndarray],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Steps all robots by one cycle."""
        if not self.agents:
            return {}, {}, {}, {}, {}
        if set(actions) != set(self.agents):
            raise InputError(f"actions: are of {sorted(actions)}; allowed: one for each of {self.agents}")
        speeds = np.stack([np.asarray(actions[agent], np.float32) for agent in self.agents])
        if speeds.shape[1:] != (2,):
            raise InputError(f"actions: have the shape {list(speeds.shape[1:])}; allowed: [2]")
        self._arena.step(np.clip(speeds, -1.0, 1.0))
        readings, rewards = self._arena.state()
        ends = self._arena.cycle == self._arena.length
        agents = self.agents
        if ends:
            self.agents = []
        return (
            self._named(readings),
            {agent: float(reward) for agent, reward in zip(agents, rewards, strict=True)},
            dict.fromkeys(agents, False),
            dict.fromkeys(agents, ends),
            {agent: {} for agent in agents},
        )

    def _named(self, readings: np.ndarray) -> dict[str, np.ndarray]:
        return {agent: readings[robot].copy() for robot, agent in enumerate(self.possible_agents)}

    def render(self) -> None:
        """Draws nothing."""

    def close(self) -> None:
        """Ends."""
