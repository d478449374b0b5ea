"""The native module: `oneiro` says what of it users may call."""

import os
from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from . import _arena, _policy

__version__: str

Progress = Callable[[int, int], None] | None

@final
class Experiment:
    """A checked experiment. It can be pickled, with the files that it names."""

    @staticmethod
    def load(path: str | os.PathLike[str], set: Mapping[str, Any] | None = None) -> Experiment:
        """Reads an experiment's file, with other values for some keys, as `--set` does: `{"evolution.population": 50}`."""

    @staticmethod
    def example(name: str, set: Mapping[str, Any] | None = None) -> Experiment:
        """An experiment that ships with Oneiro, with the files that it names: `Experiment.example("khepera-avoidance")`. A wrong name's
        error lists all; `oneiro new --example` also says what they are."""

    def _repr_html_(self) -> str:
        """For notebooks: its main values, and all settings to unfold."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def seed(self) -> int | None:
        """The seed in its file, if any."""

    @property
    def warnings(self) -> list[str]:
        """Warnings about its files and values."""

    @property
    def genes(self) -> int:
        """Genes of a genome."""

    @property
    def gene_names(self) -> list[str]:
        """Name of each gene."""

    @property
    def bounds(self) -> NDArray[np.float32]:
        """`[genes, 2]`: minimum and maximum of each gene: its range, else `evolution.limits`, else -1e6 to 1e6."""

    @property
    def hash(self) -> str:
        """Hash of everything that decides its results, except the seed."""

    @property
    def trials(self) -> int:
        """Episodes of each individual in its evolution."""

    @property
    def cycles(self) -> int:
        """Maximum control cycles of an episode."""

    @property
    def descriptor_names(self) -> list[str]:
        """Names of the measures of an episode, as `oneiro evaluate --measures` has them."""

    @property
    def settings(self) -> dict[str, Any]:
        """Every value by the key that `set` takes: `{"evolution.population": 100, ..}`."""

    @property
    def arena(self) -> _arena.Arena:
        """Walls, objects, lights and the floor, as arrays."""

    def with_(self, set: Mapping[str, Any]) -> Experiment:
        """The same experiment with other values for some keys, as `load` takes them."""

    def tested_in(self) -> Experiment:
        """The same experiment with the values of its table `[test]`."""

    def with_policy(self, policy: Any) -> Experiment:
        """The same experiment with the network of a policy as its controller, and `genome_of(policy)` as the genome that is the policy.

        A policy is a trained model of Stable-Baselines3 (PPO, A2C, SAC, TD3, DDPG), a module of torch made of linear layers with tanh,
        relu or sigmoid between them, or a list of `Layer`. Its two outputs are an environment's actions: clipped to -1 to 1, or a tanh's.
        """

    def genome_of(self, policy: Any) -> NDArray[np.float32]:
        """`[genes]`: the weights of a policy, of the shape of this experiment's network.

        The genome's actions are the policy's up to rounding: other programs add in another order.
        """

    def layers_of(self, genome: Any) -> list[_policy.Layer]:
        """The layers of a genome, `[genes]`, whose weights are those of torch's `Linear`; `genome_of` has the same genome for them."""

    def to_toml(self) -> str:
        """The experiment as TOML with all defaults. `save` also writes the files that it names."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes `to_toml` to a file, and the files that it names to `inputs/` in the same folder: `load` then has an equal experiment."""

    def _adopting(self, genomes: NDArray[np.float32], trials: int) -> Experiment: ...
    def _with(self, set: list[str]) -> Experiment: ...
    def _gene_columns(self, names: list[str]) -> tuple[list[int], str | None]: ...
    def _trace_columns(self) -> list[tuple[str, str]]: ...

@final
class Evolution:
    def __new__(cls, experiment: Experiment, seed: int) -> Evolution: ...
    @property
    def kind(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def generation(self) -> int: ...
    @property
    def is_finished(self) -> bool: ...
    def luckiest(self) -> tuple[int, int, float, NDArray[np.float32]] | None: ...
    def archive(
        self,
    ) -> (
        tuple[NDArray[np.uint32], NDArray[np.float64], NDArray[np.float64], NDArray[np.float32], float, float] | None
    ): ...
    def distribution(self) -> tuple[NDArray[np.float32], float] | None: ...
    def ask(self) -> NDArray[np.float32]: ...
    @property
    def experiment(self) -> Experiment: ...
    def keys(self) -> NDArray[np.uint64]: ...
    @property
    def descriptor_names(self) -> list[str]: ...
    def tell(self, fitness: NDArray[np.float32], behaviour: NDArray[np.float64]) -> None: ...
    def state(self) -> bytes: ...
    def restore(self, state: bytes) -> None: ...

@final
class Controllers:
    def __new__(cls, experiment: Experiment, genomes: NDArray[np.float32], number: int, robots: int) -> Controllers: ...
    @property
    def experiment(self) -> Experiment: ...
    @property
    def kind(self) -> str: ...
    @property
    def robots(self) -> int: ...
    @property
    def inputs(self) -> list[tuple[str, str]]: ...
    @property
    def cycles(self) -> NDArray[np.uint32]: ...
    def export(self, to: str, out: str | None, name: str | None, with_: list[str], checked: tuple[int, int]) -> str: ...
    def reset(self, seed: int, numbers: NDArray[np.uint64], episode: int) -> None: ...
    def step(self, readings: NDArray[np.float32]) -> NDArray[np.float32]: ...
    def wheels(self, outputs: NDArray[np.float32]) -> NDArray[np.float32]: ...

@final
class Run:
    def __new__(cls, path: str) -> Run: ...
    @property
    def path(self) -> str: ...
    @property
    def table(self) -> str: ...
    @property
    def experiment(self) -> Experiment: ...
    @property
    def seed(self) -> int: ...
    @property
    def result(self) -> str | None: ...
    def champion(self) -> NDArray[np.float32]: ...
    def verify(self) -> str: ...
    def replay(self, out: str, trial: int, seed: int | None, backend: str) -> None: ...
    def audit(self, share: float, backend: str) -> str: ...

Beginning = tuple[NDArray[np.uintp], NDArray[np.uint64], NDArray[np.uint64]]

@final
class Stepped:
    def __new__(cls, experiment: Experiment, episodes: int, backend: str) -> Stepped: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def robots(self) -> int: ...
    @property
    def bounded(self) -> list[bool]: ...
    @property
    def length(self) -> int: ...
    def step(self, who: NDArray[np.uintp] | None, actions: NDArray[Any] | None, begin: Beginning | None) -> None: ...
    def state(
        self,
    ) -> tuple[
        NDArray[np.float32], NDArray[np.float64], NDArray[np.float32], NDArray[np.uint32], NDArray[np.bool_]
    ]: ...
    def poses(self) -> NDArray[np.float32]: ...

@final
class Arena:
    def __new__(cls, experiment: Experiment, backend: str) -> Arena: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def robots(self) -> int: ...
    @property
    def length(self) -> int: ...
    @property
    def cycle(self) -> int: ...
    def begin(self, seed: int, episode: int) -> None: ...
    def step(self, speeds: NDArray[np.float32]) -> None: ...
    def state(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def poses(self) -> NDArray[np.float32]: ...

@final
class View:
    def __new__(cls, folders: list[str]) -> View: ...
    def look(self) -> tuple[bool, str, str]: ...
    def episode(self) -> tuple[str, str] | None: ...
    def stop(self) -> None: ...

def main(path: str, words: list[str]) -> int: ...
def devices() -> str: ...
def selftest(backend: str, rollouts: int) -> str: ...
def examples_of_single_robots() -> list[str]: ...
def evaluate(
    experiment: Experiment,
    genomes: NDArray[np.float32],
    seed: int,
    numbers: NDArray[np.uint64] | None,
    as_in_run: bool,
    episodes: int,
    common_starts: bool,
    backend: str,
    descriptors: list[str],
    traces: bool,
    progress: Progress,
) -> dict[str, Any]: ...
def run(experiment: Experiment, seed: int, out: str, backend: str, progress: Progress) -> Run: ...
def resume(path: str, backend: str, progress: Progress) -> Run: ...
def sweep(
    plan: str, out: str, shard: str | None, jobs: int | None, backend: str, progress: Progress
) -> tuple[int, str, list[str]] | None: ...
def merge(directories: list[str], out: str | None) -> tuple[int, str, list[str]]: ...
