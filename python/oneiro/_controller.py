"""Controllers that are stepped with readings from elsewhere: a robot, another simulator, or a recorded episode."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _native
from ._errors import InputError
from ._experiment import checked, in_order, numbered, numbers, whole
from ._native import Experiment

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._experiment import Table


class Input(NamedTuple):
    """A reading that a controller takes."""

    name: str
    about: str
    """Its range, unit and meaning."""


class Controller:
    """A controller without a simulator, by the same code and with the same bits as in simulated episodes.

    With the readings of an episode's trace it has that episode's outputs, cycle by cycle. It can be pickled between two cycles.
    """

    def __init__(
        self, exp: Experiment, genome: ArrayLike | Table, *, robots: int | None = None, number: int = 0
    ) -> None:
        """The controllers of `robots` robots by one genome, `[genes]`, or one robot for each genome of `[n, genes]`.

        Arrays then have a row for each robot; with one genome and without `robots` they are a single robot's. In a swarm,
        `number` is the robot's, from 0.
        """
        genomes = in_order(checked(exp), genome)
        if genomes.ndim not in (1, 2) or genomes.shape[-1] != exp.genes or len(genomes) == 0:
            raise InputError(f"genome: has the shape {list(genomes.shape)}; allowed: [{exp.genes}] or [n, {exp.genes}]")
        count = len(genomes) if genomes.ndim == 2 else 1
        if robots is None:
            robots = count
            self._single = genomes.ndim == 1
        else:
            robots = whole("robots", robots, 1)
            self._single = False
        if not (count in (1, robots) and robots < 2**24):
            raise InputError(
                f"robots: is {robots}; allowed: {f'{count}, one for each genome' if count > 1 else '1 to 16777215'}"
            )
        number = whole("number", number)
        self._native = _native.Controllers(exp, genomes.reshape(count, -1), min(number, 2**32 - 1), robots)

    @property
    def experiment(self) -> Experiment:
        """Its experiment."""
        return self._native.experiment

    @property
    def kind(self) -> str:
        """Its kind, as experiments name it."""
        return self._native.kind

    @property
    def robots(self) -> int:
        """Number of robots."""
        return self._native.robots

    @property
    def inputs(self) -> list[Input]:
        """What it reads in a cycle, in order."""
        return [Input(*each) for each in self._native.inputs]

    @property
    def cycle(self) -> int:
        """Number of the next cycle, from 0."""
        return int(self._native.cycles[0])

    def reset(self, *, seed: int = 0, keys: ArrayLike | None = None, episode: int = 0) -> None:
        """Begins an episode.

        If the controller draws random numbers, they are those of the episode `episode` in `evaluate` with the same `seed` and `keys`: by
        default robot `i` has those of genome `i`. Other controllers need none of these.
        """
        import numpy as np

        numbers = numbered(np.arange(self.robots) if keys is None else keys, self.robots)
        self._native.reset(whole("seed", seed), numbers, whole("episode", episode))

    def step(self, readings: ArrayLike) -> NDArray[np.float32]:
        """A control cycle of 100 ms: readings, `[inputs]` or `[robots, inputs]`, to the commands of the left and the right motor.

        They are `[2]` or `[robots, 2]`, from 0, fastest backwards, to 1, fastest forwards.
        """
        width = len(self._native.inputs)
        outputs = self._native.step(self._rows("readings", readings, width))
        return outputs[0] if self._single else outputs

    def wheels(self, outputs: ArrayLike) -> NDArray[np.float32]:
        """Speeds of the left and the right wheel that outputs command, as fractions of full speed, -1 to 1."""
        speeds = self._native.wheels(self._rows("outputs", outputs, 2))
        return speeds[0] if self._single else speeds

    def export(
        self,
        to: str,
        out: str | os.PathLike[str] | None = None,
        *,
        name: str | None = None,
        with_: Sequence[str] = (),
        seed: int = 1,
        checks: int = 16,
    ) -> Path:
        """Writes the controller of one genome as a file, or for some targets a folder, for another program or robot; returns its path.

        `to` is a target of `oneiro export`: "c", "cpp", "arduino", "rust", "javascript", "python", "lua", "argos", "webots", "ros2",
        "aseba" or "onnx". `name` begins the names in the file, by default the experiment's; without `out` it is also the file's. `with_` also
        prints what of its world: "sensors" and "task", for "c". The file checks itself by `checks` cycles, 1 to 1000, of the first episode
        with this seed. What exists is not overwritten.
        """
        if not isinstance(to, str):
            raise InputError(f"to: is {to!r}; allowed: a name, such as 'c'")
        if name is not None and not isinstance(name, str):
            raise InputError(f"name: is {name!r}; allowed: a name in C")
        if isinstance(with_, str) or not all(isinstance(what, str) for what in with_):
            raise InputError(f"with_: is {with_!r}; allowed: a list of 'sensors' and 'task'")
        count = whole("checks", checks, 1)
        if count > 1000:
            raise InputError(f"checks: is {checks}; allowed: 1 to 1000")
        where = None if out is None else os.fspath(out)
        return Path(self._native.export(to, where, name, list(with_), (whole("seed", seed), count)))

    def _rows(self, name: str, values: Any, width: int) -> NDArray[np.float32]:
        import numpy as np

        rows = numbers(name, values, np.float32)
        shape = (width,) if self._single else (self.robots, width)
        if rows.shape != shape:
            raise InputError(f"{name}: have the shape {list(rows.shape)}; allowed: {list(shape)}")
        return rows.ravel()

    def __repr__(self) -> str:
        robots = "1 robot" if self.robots == 1 else f"{self.robots} robots"
        return f"<oneiro.Controller {self.kind}, {robots}, cycle {self.cycle}>"
