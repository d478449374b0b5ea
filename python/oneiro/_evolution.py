"""Evolutions with `ask` for genomes and `tell` for their fitness."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from . import _native
from ._archive import Archive
from ._errors import InputError
from ._experiment import checked, numbers, whole
from ._html import facts
from ._native import Experiment

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


class Luckiest(NamedTuple):
    """The individual with the best score so far."""

    generation: int
    individual: int
    score: float
    genome: NDArray[np.float32]


class Evolution:
    """An evolution by the experiment's optimiser; the caller evaluates its genomes.

    With its `keys` and its `seed` in `evaluate`, it is the evolution of `oneiro run`, without finalists.
    It can be pickled between calls.
    """

    def __init__(self, exp: Experiment, *, seed: int, kind: str | None = None) -> None:
        """Starts before the first generation. `kind` replaces the experiment's `evolution.kind`."""
        seed = whole("seed", seed)
        if kind is None:
            self._native = _native.Evolution(checked(exp), seed)
        else:
            # An experiment of one kind need not have the key: what it evolves by has its name in any case.
            own = _native.Evolution(checked(exp), seed)
            self._native = own if own.kind == kind else _native.Evolution(exp._with([f"evolution.kind={kind}"]), seed)

    @property
    def kind(self) -> str:
        """Name of the optimiser."""
        return self._native.kind

    @property
    def seed(self) -> int:
        """Its seed."""
        return self._native.seed

    @property
    def generation(self) -> int:
        """Number of the next generation to evaluate, from 0."""
        return self._native.generation

    @property
    def is_finished(self) -> bool:
        """Whether all of the experiment's generations have been evaluated."""
        return self._native.is_finished

    @property
    def luckiest(self) -> Luckiest | None:
        """The individual with the best score so far; None before the first generation was evaluated."""
        best = self._native.luckiest()
        return None if best is None else Luckiest(*best)

    def _repr_html_(self) -> str:
        """For notebooks: how far it is."""
        best = self.luckiest
        values = {
            "optimiser": self.kind,
            "seed": self.seed,
            "evaluated generations": self.generation,
            "best score": "none yet" if best is None else best.score,
        }
        return facts("finished" if self.is_finished else "evolving", values)

    @property
    def keys(self) -> NDArray[np.uint64]:
        """`[n, 2]`: the generation and the number of each genome of `ask()`, for `evaluate`."""
        return self._native.keys()

    @property
    def archive(self) -> Archive | None:
        """The elites so far; None unless its optimiser keeps some (`map-elites`)."""
        found = self._native.archive()
        if found is None:
            return None
        cells, fitness, descriptors, genomes, coverage, quality = found
        return Archive(genomes, fitness, descriptors, cells, self.descriptor_names, coverage, quality)

    @property
    def mean(self) -> NDArray[np.float32] | None:
        """`[genes]`: the genome around which a strategy (`cma-es`, `sep-cma-es`, `open-es`) samples; None of other optimisers."""
        found = self._native.distribution()
        return None if found is None else found[0]

    @property
    def sigma(self) -> float | None:
        """The strategy's step size, in halves of the genes' initial ranges; None of other optimisers."""
        found = self._native.distribution()
        return None if found is None else found[1]

    @property
    def descriptor_names(self) -> list[str]:
        """Names of the behaviour measures that its optimiser uses; empty if it uses none."""
        return self._native.descriptor_names

    def ask(self) -> NDArray[np.float32]:
        """The genomes to evaluate next, `[n, genes]`; the same until `tell`."""
        return self._native.ask()

    def tell(self, fitness: ArrayLike, descriptors: ArrayLike | None = None) -> None:
        """Takes the fitness of `ask()`'s genomes, `[n]` or `[n, episodes]`, and makes the next generation.

        The experiment's `trial_score` combines a genome's episodes. NaN ranks last. An optimiser that uses behaviour also needs
        `descriptors`, `[n, measures]` or `[n, episodes, measures]`, whose means count: either those of `descriptor_names`, or
        all that `evaluate` measures.
        """
        import numpy as np

        fitness = numbers("fitness", fitness, np.float32)
        count = len(self.ask())
        if fitness.ndim not in (1, 2) or len(fitness) != count or fitness.size == 0:
            shape = list(fitness.shape)
            raise InputError(f"fitness: has the shape {shape}; allowed: [{count}] or [{count}, episodes]")
        self._native.tell(fitness.ravel(), self._behaviour(descriptors, count))

    def _behaviour(self, descriptors: ArrayLike | None, count: int) -> NDArray[np.float64]:
        """The numbers of `descriptor_names` for each episode of each genome, one after the other."""
        import numpy as np

        names = self.descriptor_names
        if descriptors is None and not names:
            return np.empty(0)
        if not names:
            raise InputError(f"descriptors: are given, but the optimiser {self.kind} uses none; allowed: None")
        if descriptors is None:
            wanted = f"[{count}, {len(names)}] of {', '.join(names)}"
            raise InputError(f"descriptors: are needed by the optimiser {self.kind}; allowed: {wanted}")
        own = numbers("descriptors", descriptors, np.float64)
        known = self._native.experiment.descriptor_names
        if own.ndim not in (2, 3) or len(own) != count or own.shape[-1] not in (len(names), len(known)):
            shape = list(own.shape)
            allowed = f"[{count}, {len(names)}] or [{count}, episodes, {len(names)}], or all {len(known)} measures"
            raise InputError(f"descriptors: have the shape {shape}; allowed: {allowed}")
        if own.shape[-1] != len(names):
            own = own[..., [known.index(name) for name in names]]
        return np.ascontiguousarray(own).ravel()

    def state(self) -> bytes:
        """Its state, sealed: only an evolution of the same experiment can restore it."""
        return self._native.state()

    def restore(self, state: bytes) -> None:
        """Continues from a state. A damaged state, or one of another experiment, is an error and changes nothing."""
        self._native.restore(state)

    def __repr__(self) -> str:
        return f"<oneiro.Evolution {self.kind}, seed {self.seed}, generation {self.generation}>"
