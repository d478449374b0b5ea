"""Episodes as pages."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ._errors import InputError
from ._experiment import in_order, whole
from ._html import frame
from ._native import Experiment
from ._runs import Run, adopt

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._experiment import Table


class Replay:
    """A page that plays an episode. Notebooks show it."""

    def __init__(self, html: str) -> None:
        self.html = html
        """The page's text, which needs no other file."""

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the page to a file, which any browser opens."""
        Path(path).write_text(self.html, encoding="utf-8")
        return Path(path)

    def __repr__(self) -> str:
        return f"<oneiro.Replay, a page of {len(self.html)} characters; save(PATH) writes it>"

    def _repr_html_(self) -> str:
        """For notebooks: the page in a frame."""
        return frame("replay.html", self.html)


def replay(
    source: Run | ArrayLike | Table,
    exp: Experiment | None = None,
    *,
    trial: int = 0,
    seed: int | None = None,
    backend: str = "auto",
) -> Replay:
    """Plays an episode of a finished run's champion, or of a genome: the page of `oneiro replay`.

    A genome, `[genes]` or a table of one, needs its experiment. `trial` is the champion's episode, from 0; with a `seed` its random numbers
    are others than the run's. Nothing is written into the run's directory.
    """
    trial = min(whole("trial", trial), 2**32 - 1)
    seed = None if seed is None else whole("seed", seed)
    with tempfile.TemporaryDirectory(prefix="oneiro-") as folder:
        if isinstance(source, Run):
            run = source
        else:
            import numpy as np

            if exp is None:
                raise InputError(
                    "replay: has genomes and no experiment; allowed: a Run, or a genome and its experiment"
                )
            genome = np.atleast_2d(in_order(exp, source))
            if genome.shape != (1, exp.genes):
                raise InputError(f"genome: has the shape {list(genome.shape)}; allowed: [{exp.genes}], a single one")
            run = adopt(exp, genome, seed=seed or 0, out=Path(folder) / "run", trials=2, backend=backend)
            seed = None
        pages = Path(folder) / "replay"
        run._native.replay(os.fspath(pages), trial, seed, backend)
        # Its name says which episode it is.
        (page,) = pages.glob("*.html")
        return Replay(page.read_text(encoding="utf-8"))
