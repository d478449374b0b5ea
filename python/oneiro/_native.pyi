"""The native module: `oneiro` says what of it users may call."""

import os
from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

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

    def to_toml(self) -> str:
        """The experiment as TOML with all defaults. Files have their names in a run's directory."""

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
    def audit(self, share: float, backend: str) -> str: ...

@final
class Stepped:
    def __new__(cls, experiment: Experiment, lives: int, backend: str) -> Stepped: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def bounded(self) -> int: ...
    @property
    def length(self) -> int: ...
    def begin(self, who: NDArray[np.uintp], seeds: NDArray[np.uint64], numbers: NDArray[np.uint64]) -> None: ...
    def step(self, who: NDArray[np.uintp] | None, commands: NDArray[np.float32]) -> None: ...
    def state(
        self,
    ) -> tuple[
        NDArray[np.float32], NDArray[np.float64], NDArray[np.float32], NDArray[np.uint32], NDArray[np.bool_]
    ]: ...

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
    def begin(self, seed: int, life: int) -> None: ...
    def step(self, speeds: NDArray[np.float32]) -> None: ...
    def state(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...

@final
class View:
    def __new__(cls, folders: list[str]) -> View: ...
    def look(self) -> tuple[bool, str, str]: ...
    def episode(self) -> tuple[str, str] | None: ...
    def stop(self) -> None: ...

def main(path: str, words: list[str]) -> int: ...
def devices() -> str: ...
def selftest(backend: str, rollouts: int) -> str: ...
def evaluate(
    experiment: Experiment,
    genomes: NDArray[np.float32],
    seed: int,
    numbers: NDArray[np.uint64] | None,
    as_in_run: bool,
    lives: int,
    common_starts: bool,
    backend: str,
    descriptors: bool,
    traces: bool,
    progress: Progress,
) -> dict[str, Any]: ...
def run(experiment: Experiment, seed: int, out: str, backend: str, progress: Progress) -> Run: ...
def resume(path: str, backend: str, progress: Progress) -> Run: ...
def sweep(
    plan: str, out: str, shard: str | None, jobs: int | None, backend: str, progress: Progress
) -> tuple[int, str, list[str]] | None: ...
def merge(directories: list[str], out: str | None) -> tuple[int, str, list[str]]: ...
