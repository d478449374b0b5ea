"""Experiments, and the evaluation of genomes."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from . import _native
from ._errors import InputError
from ._native import Experiment
from ._progress import bar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


def _toml(value: Any) -> str:
    """A value as `--set` takes it."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_inner(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        items = value.tolist() if hasattr(value, "tolist") else value
        if not isinstance(items, (list, tuple)):
            return _toml(items)
        return "[" + ", ".join(_inner(item) for item in items) + "]"
    return repr(value)


def _inner(value: Any) -> str:
    """A value within another, where words need quotes."""
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return _toml(value)


def settings(values: Mapping[str, Any] | None) -> list[str]:
    """Settings as `--set` takes them. Called by `Experiment.load`."""
    if values is None:
        return []
    if not isinstance(values, Mapping):
        raise InputError(f'set: is {values!r}; allowed: values by their keys, such as {{"evolution.population": 50}}')
    return [f"{key}={_toml(value)}" for key, value in values.items()]


def checked(exp: Experiment) -> Experiment:
    """The argument `exp`."""
    if not isinstance(exp, Experiment):
        raise InputError(f"exp: is {exp!r}; allowed: an Experiment, such as Experiment.load(path)")
    return exp


def numbers(name: str, values: Any, kind: type[np.floating[Any]]) -> NDArray[Any]:
    """An argument as an array without gaps."""
    import numpy as np

    try:
        given = np.asarray(values)
        if given.dtype.kind not in "biufO":
            raise TypeError(f"{given.dtype} aren't numbers")
        return np.ascontiguousarray(given, kind).reshape(given.shape)
    except (TypeError, ValueError, RuntimeError, OverflowError) as error:
        raise InputError(f"{name}: can't be made an array ({error}); allowed: numbers, in rows of one length") from None


def whole(name: str, value: Any, least: int = 0) -> int:
    """A whole number from `least` to 2^63 - 1, as seeds are."""
    try:
        number = value.__index__()
    except (AttributeError, TypeError):
        number = None
    if number is None or not least <= number < 2**63:
        raise InputError(f"{name}: is {value!r}; allowed: a whole number, {least} to 9223372036854775807")
    return int(number)


class Table(Protocol):
    """Columns by their names: a data frame or a row of one, a structured array, or a mapping of arrays."""

    def __getitem__(self, name: Any, /) -> Any: ...


def in_order(exp: Experiment, genomes: ArrayLike | Table) -> NDArray[np.float32]:
    """Genomes in the order of an experiment's genes. A table's are found by name; an array has no names."""
    import numpy as np

    names: Any = getattr(getattr(genomes, "dtype", None), "names", None)
    if names is None:
        # Mappings and the rows and frames of pandas have keys.
        keys = getattr(genomes, "keys", None)
        names = keys() if callable(keys) else getattr(genomes, "columns", None)
    if names is None:
        return numbers("genomes", genomes, np.float32)
    names = list(names)
    if not any(isinstance(name, str) for name in names):
        warnings.warn("genomes: the columns have no names, so they are taken in the order of gene_names", stacklevel=3)
        return numbers("genomes", genomes, np.float32)
    places, warning = exp._gene_columns([str(name) for name in names])
    if warning is not None:
        warnings.warn(warning, stacklevel=3)
    table: Any = genomes
    return np.stack([numbers(names[place], table[names[place]], np.float32) for place in places], axis=-1)


def numbered(keys: ArrayLike, count: int) -> NDArray[np.uint64]:
    """Keys as a generation and a number of each of `count` genomes or robots."""
    import numpy as np

    try:
        given = np.asarray(keys)
    except ValueError:
        given = np.asarray(None)
    if given.dtype.kind not in "iu" or (given.size and given.min() < 0):
        raise InputError("keys: aren't whole numbers from 0 on; allowed: integers, [n] or [n, 2]")
    if given.shape not in [(count,), (count, 2)]:
        raise InputError(f"keys: have the shape {list(given.shape)}; allowed: [{count}] or [{count}, 2]")
    pairs = np.zeros((count, 2), np.uint64)
    pairs[:, 2 - given.ndim :] = given.reshape(count, -1)
    return pairs


class Outcome(NamedTuple):
    """Results of evaluated genomes, for each of their episodes."""

    fitness: NDArray[np.float32]
    """`[n, episodes]`"""
    device: str
    """The device that computed them, such as `cpu (native256x16, 2 threads)`."""
    exact: bool
    """Whether that device guarantees the same bits as all exact devices."""
    descriptors: NDArray[np.float64] | None = None
    """`[n, episodes, measures]`, those that were requested in their order; None unless requested."""
    traces: NDArray[np.void] | None = None
    """`[n, episodes, cycles]`, a structured array with the columns of a run's `trace.csv`; zeros after an early end. None unless requested."""
    lengths: NDArray[np.uint32] | None = None
    """`[n, episodes]`, the cycles of each episode in `traces`."""

    def __repr__(self) -> str:
        genomes, episodes = self.fitness.shape
        best = f", best fitness {self.fitness.max():.6g}" if genomes else ""
        return f"<oneiro.Outcome {genomes} genomes, {episodes} episodes each{best}, on {self.device}>"


def evaluate(
    exp: Experiment,
    genomes: ArrayLike | Table,
    *,
    seed: int,
    keys: ArrayLike | None = None,
    episodes: int | None = None,
    common_starts: bool = False,
    backend: str = "auto",
    descriptors: bool | Sequence[str] = False,
    traces: bool | None = None,
) -> Outcome:
    """Evaluates genomes, `[n, genes]`, in the experiment's world, with `episodes` episodes each: by default one, with keys of `[n, 2]`
    the experiment's `trials`.

    An array's genomes are in the order of `exp.gene_names`. A table's genes, such as a data frame's, are found by its columns' names.

    An episode's random numbers, including its start, depend on `seed`, the genome's key and the episode's number. By default a
    genome's key is its index, as in `oneiro evaluate`. `keys`, `[n]`, sets other ones: parts of a population that keep their keys
    have the same results as in the whole. With `[n, 2]` the first number is a generation: with `Evolution.keys` the episodes are
    those of `oneiro run`, and their measures, as there, exclude the end of the last cycle. `common_starts` gives all genomes the
    random numbers of the first.

    `descriptors` are names of measures, or True for all of `exp.descriptor_names`. Few are faster than all, and where an episode
    ends costs next to nothing.
    """
    import numpy as np

    genomes = in_order(checked(exp), genomes)
    if genomes.ndim == 1:
        genomes = genomes[None]
    if genomes.ndim != 2 or genomes.shape[1] != exp.genes:
        raise InputError(f"genomes: have the shape {list(genomes.shape)}; allowed: [n, {exp.genes}]")
    numbered_by, as_in_run = (None, False) if keys is None else (numbered(keys, len(genomes)), np.ndim(keys) == 2)
    if traces not in (None, False, True):
        raise InputError(f"traces: is {traces!r}; allowed: True, False or None")
    measured: list[Any] = []
    if isinstance(descriptors, (bool, np.bool_)):
        measured = exp.descriptor_names if descriptors else []
    elif descriptors is not None:
        measured = list(descriptors) if isinstance(descriptors, Iterable) else [None]
        if isinstance(descriptors, str) or not all(isinstance(name, str) for name in measured):
            example = descriptors if isinstance(descriptors, str) else exp.descriptor_names[0]
            raise InputError(
                f"descriptors: is {descriptors!r}; allowed: a list of names, such as [{example!r}], or True"
            )
    seed = whole("seed", seed)
    episodes = whole("episodes", (exp.trials if as_in_run else 1) if episodes is None else episodes, 1)
    with bar("evaluating") as progress:
        result = _native.evaluate(
            exp,
            genomes,
            seed,
            numbered_by,
            as_in_run,
            episodes,
            common_starts,
            backend,
            measured,
            bool(traces),
            progress,
        )
    for warning in result.pop("warnings"):
        warnings.warn(warning, stacklevel=2)
    if traces:
        result["traces"] = result["traces"].view(np.dtype(exp._trace_columns()))[..., 0]
    return Outcome(**result)
