"""Runs and sweeps in directories."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _native
from ._archive import Archive, data_frame
from ._callbacks import Callback, Logged
from ._errors import CorruptError, FailedError, InputError, StorageError
from ._experiment import in_order, whole
from ._html import facts, framed
from ._native import Experiment
from ._progress import bar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._experiment import Table


def table(path: Path) -> Any:
    """A table as a DataFrame of pandas, or else of Polars, or else as a dictionary of NumPy's arrays.

    Numbers have all their bits in each of these.
    """
    import csv

    import numpy as np

    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    columns = zip(*rows, strict=True) if rows else ((),) * len(head)
    return data_frame({name: _column(np, cells) for name, cells in zip(head, columns, strict=True)})


def _column(np: Any, cells: Sequence[str]) -> NDArray[Any]:
    """Whole numbers, or else numbers, of which those that are missing are NaN, or else words."""
    if all(cells):
        try:
            return np.array([int(cell) for cell in cells], np.int64)
        except ValueError:
            pass
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells], np.float64)
    except ValueError:
        return np.array(cells, object)


class Run:
    """A run in its directory, finished or not."""

    def __init__(self, native: _native.Run) -> None:
        self._native = native

    @property
    def path(self) -> Path:
        """Its directory."""
        return Path(self._native.path)

    @property
    def experiment(self) -> Experiment:
        """Its experiment."""
        return self._native.experiment

    @property
    def seed(self) -> int:
        """Its seed."""
        return self._native.seed

    @property
    def result(self) -> str | None:
        """Hash of its results, the same on every machine; None while it is not finished."""
        return self._native.result

    @property
    def generations(self) -> Any:
        """Its generations, or a swarm's intervals: a DataFrame of pandas, or else of Polars, or else a dictionary of arrays."""
        return table(Path(self._native.table))

    @property
    def champion(self) -> Champion:
        """Its champion."""
        import json

        genome = self._native.champion()
        values = json.loads((self.path / "champion.json").read_text())
        return Champion(genome, values)

    @property
    def archive(self) -> Archive | None:
        """The elites of a finished run; None unless its optimiser keeps some (`map-elites`)."""
        import csv

        import numpy as np

        if self.experiment.settings.get("evolution.kind") != "map-elites":
            return None
        if self.result is None:
            raise FailedError(f"{self.path}: is not finished; `oneiro.resume({str(self.path)!r})` finishes it")
        try:
            with (self.path / "archive.csv").open(newline="") as file:
                head, *rows = csv.reader(file)
            with (self.path / "coverage.csv").open(newline="") as file:
                *_, last = csv.DictReader(file)
            genomes = np.load(self.path / "archive.npy")
            # Before the measures: cell, fitness, and where an elite was evaluated.
            first = head.index("score_bits") + 1
            values = np.array([row[first:] for row in rows], np.float64).reshape(len(rows), len(head) - first)
            cells = np.array([row[head.index("cell")] for row in rows], np.int64)
            fitness = np.array([row[head.index("fitness")] for row in rows], np.float64)
            coverage, quality = float(last["coverage"]), float(last["qd_score"])
        except OSError as error:
            raise StorageError(f"{self.path}: {error}") from error
        except (ValueError, KeyError) as error:
            raise CorruptError(f"{self.path}: its archive is damaged: {error}") from error
        return Archive(genomes, fitness, values, cells, head[first:], coverage, quality)

    def verify(self) -> str:
        """Checks that its files are unchanged; returns the hash of its results."""
        return self._native.verify()

    def audit(self, share: float = 0.01, *, backend: str = "auto") -> dict[str, Any]:
        """Re-evaluates a fraction (`share`) of its recorded individuals; raises `FailedError` if a bit differs."""
        import json

        return json.loads(self._native.audit(share, backend))

    def __repr__(self) -> str:
        return f"<oneiro.Run {str(self.path)!r}, seed {self.seed}>"

    def _repr_html_(self) -> str:
        """For notebooks: its pages, `report.html` and, if it was replayed, `replay.html`."""
        result = self.result
        values = {"run": self.path, "seed": self.seed, "result": result[:12] if result else "not finished"}
        pages = [framed(self.path / name) for name in ("report.html", "replay.html")]
        return facts(self.experiment.name, values) + "".join(pages)


class Champion(NamedTuple):
    """A run's best controller."""

    genome: NDArray[np.float32]
    values: dict[str, Any]
    """What `champion.json` says of it."""


class Sweep(NamedTuple):
    """A sweep's tables."""

    path: Path
    runs: int
    hash: str
    """Hash of its results and generations."""
    files: list[Path]

    @property
    def results(self) -> Any:
        """A row for each run: a DataFrame of pandas, or else of Polars, or else a dictionary of arrays."""
        return table(self.path / "results.csv")

    @property
    def generations(self) -> Any:
        """A row for each generation of each run, in the same form."""
        return table(self.path / "generations.csv")

    def _repr_html_(self) -> str:
        """For notebooks: its report, if `oneiro sweep report` has written one."""
        values = {"sweep": self.path, "runs": self.runs, "hash": self.hash[:12]}
        return facts(self.path.name, values) + framed(self.path / "report.html")


def run(
    exp: Experiment,
    *,
    seed: int,
    out: str | os.PathLike[str],
    backend: str = "auto",
    callbacks: Sequence[Callback] = (),
) -> Run:
    """Runs an experiment into a directory. A finished run there stays unchanged.

    `callbacks` are told of each generation. After Ctrl-C, `resume` continues it, also if a callback has raised an exception.
    """
    seed = whole("seed", seed)
    with Logged(exp, seed, out, callbacks) as update, bar(exp.name, update) as progress:
        return Run(_native.run(exp, seed, os.fspath(out), backend, progress))


def adopt(
    exp: Experiment,
    genomes: ArrayLike | Table,
    *,
    seed: int,
    out: str | os.PathLike[str],
    trials: int = 100,
    backend: str = "auto",
) -> Run:
    """Records genomes that others evolved, `[n, genes]` or one, as a run of one generation, as `oneiro adopt` does.

    All are finalists with `trials` episodes each: the best mean is the champion. `Run`, `evaluate`, `oneiro replay` and
    `oneiro export` take the directory like that of any run.
    """
    import numpy as np

    rows = np.atleast_2d(in_order(exp, genomes))
    if rows.ndim != 2 or rows.shape[1] != exp.genes:
        raise InputError(f"genomes: have the shape {list(rows.shape)}; allowed: [n, {exp.genes}]")
    return run(exp._adopting(rows, min(whole("trials", trials), 10_001)), seed=seed, out=out, backend=backend)


def resume(dir: str | os.PathLike[str], *, backend: str = "auto", callbacks: Sequence[Callback] = ()) -> Run:
    """Continues a stopped or killed run. `callbacks` are told of all its generations."""
    found = load_run(dir)
    with Logged(found.experiment, found.seed, dir, callbacks) as update, bar("resuming", update) as progress:
        return Run(_native.resume(os.fspath(dir), backend, progress))


def load_run(dir: str | os.PathLike[str]) -> Run:
    """Opens a run's directory."""
    return Run(_native.Run(os.fspath(dir)))


def sweep(
    plan: str | os.PathLike[str], *, out: str | os.PathLike[str], jobs: int | None = None, backend: str = "auto"
) -> Sweep:
    """Runs a sweep in a directory, or continues it. `jobs` limits the number of runs at a time."""
    tables = _swept(plan, out, None, jobs, backend)
    assert tables is not None
    return _sweep(Path(out), tables)


def sweep_shard(
    plan: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    shard: str,
    jobs: int | None = None,
    backend: str = "auto",
) -> None:
    """Runs a shard of a sweep, such as `"3/8"`: the third of eight. `merge` makes the tables once all shards are done.

    Shards may run in other processes or on other machines, in one shared directory or in separate ones.
    """
    _swept(plan, out, shard, jobs, backend)


def merge(*dirs: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Sweep:
    """Makes the tables of a sweep whose shards are done in these directories: in the first one, or in `out`.

    They are the tables that `sweep` would have made.
    """
    if not dirs:
        raise InputError("merge: names no directory; allowed: at least one")
    tables = _native.merge([os.fspath(folder) for folder in dirs], None if out is None else os.fspath(out))
    return _sweep(Path(dirs[0] if out is None else out), tables)


def _swept(
    plan: str | os.PathLike[str],
    out: str | os.PathLike[str],
    shard: str | None,
    jobs: int | None,
    backend: str,
) -> tuple[int, str, list[str]] | None:
    if jobs is not None and not 1 <= whole("jobs", jobs, 1) <= 1_000_000:
        raise InputError(f"jobs: is {jobs}; allowed: 1 to 1000000")
    with bar(Path(plan).stem) as progress:
        return _native.sweep(os.fspath(plan), os.fspath(out), shard, jobs, backend, progress)


def _sweep(path: Path, tables: tuple[int, str, list[str]]) -> Sweep:
    runs, digest, files = tables
    return Sweep(path, runs, digest, [Path(file) for file in files])
