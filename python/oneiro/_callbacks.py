"""What is told of evolutions while they run, or afterwards."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._errors import Error
from ._native import Experiment

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._runs import Run, Sweep

Settings = Mapping[str, Any]
Tags = Mapping[str, str]
Values = Mapping[str, float]
Files = Sequence[Path]

# What a finished run's directory offers to keep.
_FILES = ("champion.json", "champion.npy", "config.toml", "report.html", "DONE")
# Columns that are no measurements.
_NUMBERS = ("robot", "individual")
# The ending of columns that have a value's bits.
_BITS = "_bits"


class Callback:
    """Is told of evolutions, one after the other. Each method does nothing unless it is overridden."""

    def begin(self, name: str, settings: Settings, tags: Tags) -> None:
        """An evolution begins: its name, its experiment's values by their keys, and its seed and hashes."""

    def generation(self, number: int, values: Values) -> None:
        """A generation, from 0, was evaluated. In a swarm it is an interval, and values are means over robots."""

    def end(self, files: Files, is_finished: bool) -> None:
        """It has ended, or was stopped. A finished run has files to keep, such as its champion and its report."""


@contextlib.contextmanager
def _begun(
    callbacks: Sequence[Callback],
    name: str,
    settings: Settings,
    tags: Tags,
    run: Path | None = None,
) -> Iterator[None]:
    """Begins them, and ends each that has begun."""

    def end(callback: Callback, is_right: bool) -> None:
        is_finished = is_right and (run is None or (run / "DONE").exists())
        files = [run / name for name in _FILES if (run / name).exists()] if run and is_finished else []
        callback.end(files, is_finished)

    with contextlib.ExitStack() as stack:
        for callback in callbacks:
            callback.begin(name, settings, tags)
            stack.push(lambda error, _, __, callback=callback: end(callback, error is None))
        yield


def _of_run(exp: Experiment, seed: int) -> tuple[str, dict[str, Any], dict[str, str]]:
    """Its name, values and tags."""
    return f"{exp.name}-{seed}", {**exp.settings, "seed": seed}, {"seed": str(seed), "experiment": exp.hash}


def _steps(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[tuple[int, dict[str, float]]]:
    """The number and the values of each generation in a table's rows: the means of rows that have the same."""
    for number, group in itertools.groupby(rows, key=lambda row: row[0]):
        values = {}
        for name, *cells in zip(head, *group, strict=True):
            is_measured = name not in _NUMBERS and not name.endswith(_BITS)
            numbers = [float(cell) for cell in cells if cell] if is_measured else []
            if numbers and name != head[0]:
                values[name] = sum(numbers) / len(numbers)
        yield int(number), values


class _Table:
    """A run's table while it grows."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read = 0
        self._head: list[str] = []
        self._rows: list[list[str]] = []

    def steps(self, is_last: bool) -> Iterator[tuple[int, dict[str, float]]]:
        """Generations that were added. A run that is resumed may cut its table, and adds the same bytes again."""
        import csv

        try:
            with self._path.open("rb") as file:
                file.seek(self._read)
                text = file.read()
        except FileNotFoundError:
            text = b""
        text = text[: text.rfind(b"\n") + 1]
        self._read += len(text)
        rows = self._rows + list(csv.reader(text.decode().splitlines()))
        if rows and not self._head:
            self._head = rows.pop(0)
        # Other robots of the last interval may follow.
        has_more = "robot" in self._head and not is_last
        complete = [row for row in rows if row[0] != rows[-1][0]] if has_more else rows
        self._rows = rows[len(complete) :]
        return _steps(self._head, complete)


class Logged:
    """As a context, it gives a function that tells callbacks of what was added to a run's table, which is also called at the end; or None
    if there are no callbacks.

    It is no generator, since a generator can't raise what callbacks like to raise, `StopIteration`.
    """

    def __init__(self, exp: Experiment, seed: int, out: str | os.PathLike[str], callbacks: Sequence[Callback]) -> None:
        self._exp = exp
        self._seed = seed
        self._out = Path(out)
        self._callbacks = callbacks
        self._table: _Table | None = None
        self._is_broken = False
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> Callable[[], None] | None:
        if not self._callbacks:
            return None
        self._stack.enter_context(_begun(self._callbacks, *_of_run(self._exp, self._seed), self._out))
        self._stack.callback(self._update, is_last=True)
        return self._update

    def __exit__(self, *error: Any) -> bool | None:
        return self._stack.__exit__(*error)

    def _update(self, is_last: bool = False) -> None:
        if self._is_broken:
            # A callback has raised an exception, so they know different generations.
            return
        if self._table is None:
            try:
                run = _native.Run(os.fspath(self._out))
            except Error:
                # It has not begun.
                return
            if (run.experiment.hash, run.seed) != (self._exp.hash, self._seed):
                # It will be refused.
                return
            self._table = _Table(Path(run.table))
        self._is_broken = True
        for number, values in self._table.steps(is_last):
            for callback in self._callbacks:
                callback.generation(number, values)
        self._is_broken = False


def log_runs(source: Run | Sweep, callbacks: Sequence[Callback], *, follow: bool = False) -> None:
    """Tells callbacks of a run so far, or of each run of a sweep. With `follow`, of a run until it is finished."""
    from ._runs import Sweep

    if isinstance(source, Sweep):
        _log_sweep(source, callbacks)
        return
    with Logged(source.experiment, source.seed, source.path, callbacks) as update:
        while update and follow and source.result is None:
            update()
            time.sleep(1)


def _log_sweep(sweep: Sweep, callbacks: Sequence[Callback]) -> None:
    import csv

    with (sweep.path / "results.csv").open(newline="") as file:
        results = {row["run"]: row for row in csv.DictReader(file)}
    with (sweep.path / "generations.csv").open(newline="") as file:
        rows = csv.reader(file)
        head = next(rows)[1:]
        for run, own in itertools.groupby(rows, key=lambda row: row[0]):
            result = results[run]
            columns = list(result)
            # A run's number and identity stand before the keys of the sweep and the seed.
            settings = {key: _value(result[key]) for key in columns[2 : columns.index("seed") + 1]}
            tags = {"seed": result["seed"], "sweep": sweep.hash, "result": result["result"]}
            with _begun(callbacks, f"{sweep.path.name}-{run}", settings, tags):
                for number, values in _steps(head, (row[1:] for row in own)):
                    for callback in callbacks:
                        callback.generation(number, values)


def _value(cell: str) -> Any:
    try:
        return json.loads(cell)
    except ValueError:
        return cell


@contextlib.contextmanager
def log_loop(exp: Experiment, callbacks: Sequence[Callback], *, seed: int) -> Iterator[Callable[[ArrayLike], None]]:
    """For a loop of yours: yields a function to call with each generation's fitness, `[n]` or `[n, episodes]`.

    Callbacks get the best, mean and median of the genomes' mean fitness without NaN, the episodes so far, and the episodes per second
    since the call before.
    """
    import numpy as np

    number, episodes, before = 0, 0, time.perf_counter()

    def log(fitness: ArrayLike) -> None:
        nonlocal number, episodes, before
        all_lives = np.asarray(fitness, np.float64)
        scores = all_lives.reshape(len(all_lives), -1).mean(axis=1)
        scores = scores[~np.isnan(scores)] if not np.isnan(scores).all() else scores[:1]
        now = time.perf_counter()
        episodes += all_lives.size
        values = {
            "best": float(scores.max()),
            "mean": float(scores.mean()),
            "median": float(np.median(scores)),
            "episodes": episodes,
            "episodes_per_s": all_lives.size / (now - before),
        }
        for callback in callbacks:
            callback.generation(number, values)
        number, before = number + 1, now

    with _begun(callbacks, *_of_run(exp, seed)):
        yield log
