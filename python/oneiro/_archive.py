"""Archives of elites."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Archive(NamedTuple):
    """The elites of an evolution, in the order of their cells."""

    genomes: NDArray[np.float32]
    """`[n, genes]`"""
    fitness: NDArray[np.float64]
    """`[n]`: by which each is compared."""
    descriptors: NDArray[np.float64]
    """`[n, measures]`, in the order of `descriptor_names`."""
    cells: NDArray[Any]
    """`[n]`: numbers of their cells, counted along the last descriptor first in a grid."""
    descriptor_names: list[str]
    coverage: float
    """The fraction of all cells that have an elite."""
    qd_score: float
    """The sum over all elites of what their fitness is above `evolution.archive.offset`."""

    @property
    def table(self) -> Any:
        """A row for each elite, with its cell, fitness and descriptors: a DataFrame of pandas, or else of Polars, or else a
        dictionary of arrays.
        """
        measures = zip(self.descriptor_names, self.descriptors.T, strict=True)
        return data_frame({"cell": self.cells, "fitness": self.fitness, **dict(measures)})

    def __repr__(self) -> str:
        return f"<oneiro.Archive {len(self.cells)} elites, coverage {self.coverage:.3g}, QD score {self.qd_score:.6g}>"


def data_frame(columns: dict[str, Any]) -> Any:
    """Columns as a DataFrame of pandas, or else of Polars, or else unchanged."""
    for library in ("pandas", "polars"):
        try:
            return importlib.import_module(library).DataFrame(columns)
        except ImportError:
            pass
    return columns
