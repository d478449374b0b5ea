"""Records of evolutions by other libraries' optimisers."""

from __future__ import annotations

import json
import os
import pickle
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._errors import CorruptError, FailedError, InputError, StorageError
from ._experiment import Outcome, evaluate, in_order, whole
from ._native import Experiment

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._evolution import Luckiest
    from ._experiment import Table

_ABOUT = "recorder.json"
_EXPERIMENT = "experiment.pickle"
_STATE = "optimiser.pickle"
_PROMISE = "Only simulated episodes are bit-reproducible, on every exact device. Another library chose the genomes; its bits are not promised."


class Recorder:
    """Evaluates the genomes of another library's optimiser, generation after generation, and records them in a directory.

    `save` and `restore` the optimiser's state to continue a stopped evolution. `audit` re-evaluates recorded individuals and compares
    the bits. State is pickled: open only directories that you trust.
    """

    def __init__(
        self,
        exp: Experiment,
        *,
        seed: int,
        out: str | os.PathLike[str],
        optimiser: str,
        episodes: int | None = None,
        common_starts: bool = True,
        backend: str = "auto",
    ) -> None:
        """Starts in a new directory. `optimiser` names the library and its version, such as `"cma 4.5.0"`.

        Each genome has `episodes` episodes in a generation, by default the experiment's `trials`. With `common_starts` all genomes of a
        generation have the same random numbers.
        """
        about = {
            "oneiro": _native.__version__,
            "optimiser": optimiser,
            "experiment": exp.hash,
            "seed": whole("seed", seed),
            "episodes": exp.trials if episodes is None else whole("episodes", episodes, 1),
            "common_starts": bool(common_starts),
            "promise": _PROMISE,
        }
        path = Path(out)
        if path.exists() and any(path.iterdir()):
            raise InputError(f"{path}: is not empty; allowed: a new directory, or Recorder.open to continue this one")
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StorageError(f"{path}: {error.strerror}") from error
        (path / "experiment.toml").write_text(exp.to_toml())
        _write(path / _EXPERIMENT, pickle.dumps(exp))
        _write(path / _ABOUT, (json.dumps(about, indent=2) + "\n").encode())
        self._begin(path, exp, about, backend)

    def _begin(self, path: Path, exp: Experiment, about: dict[str, Any], backend: str) -> None:
        self.path = path
        self.experiment = exp
        self.about = about
        self.backend = backend
        """The device that evaluates; results don't depend on it."""
        self._counted = 0

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, backend: str = "auto") -> Recorder:
        """Opens a directory to continue or to read it."""
        path = Path(path)
        try:
            about = json.loads((path / _ABOUT).read_text())
            exp = pickle.loads((path / _EXPERIMENT).read_bytes())
        except FileNotFoundError as error:
            raise InputError(f"{error.filename}: doesn't exist; allowed: a directory of a Recorder") from error
        except (ValueError, pickle.UnpicklingError, EOFError) as error:
            raise CorruptError(f"{path}: is damaged: {error}") from error
        if exp.hash != about["experiment"]:
            raise CorruptError(f"{path / _EXPERIMENT}: isn't the experiment that {_ABOUT} names")
        recorder = cls.__new__(cls)
        recorder._begin(path, exp, about, backend)
        return recorder

    @property
    def generation(self) -> int:
        """Number of the next generation to evaluate, from 0."""
        # Counted again only if files came or went otherwise: an evolution may have very many.
        counted = self._counted
        if self._file(counted).exists() or (counted > 0 and not self._file(counted - 1).exists()):
            self._counted = len(self._files())
        return self._counted

    def evaluate(self, genomes: ArrayLike | Table, *, descriptors: bool = False) -> Outcome:
        """Evaluates the next generation's genomes, `[n, genes]`, and records them with their fitness."""
        import numpy as np

        generation = self.generation
        genomes = in_order(self.experiment, genomes)
        if genomes.ndim != 2:
            raise InputError(f"genomes: have the shape {list(genomes.shape)}; allowed: [n, genes]")
        outcome = self._lives(generation, genomes, np.arange(len(genomes)), descriptors)
        path = self._file(generation)
        part = path.with_name(".part.npz")
        try:
            np.savez(part, genomes=genomes, fitness=outcome.fitness)
            os.replace(part, path)
        except OSError as error:
            raise StorageError(f"{path}: {error.strerror}") from error
        self._counted += 1
        return outcome

    def save(self, state: Any) -> None:
        """Saves an optimiser's state after the last generation: anything that can be pickled."""
        _write(self.path / _STATE, pickle.dumps((self.generation, state)))

    def restore(self) -> Any:
        """The last saved state. Deletes the generations recorded after it: the optimiser makes them again."""
        try:
            generation, state = pickle.loads((self.path / _STATE).read_bytes())
        except FileNotFoundError:
            raise InputError(f"{self.path}: has no saved state; allowed: after save") from None
        except (ValueError, pickle.UnpicklingError, EOFError) as error:
            raise CorruptError(f"{self.path / _STATE}: is damaged: {error}") from error
        files = self._files()
        if generation > len(files):
            raise CorruptError(
                f"{self.path}: {len(files)} generations are recorded; its state is of generation {generation}"
            )
        # The last first, so that there is never a gap.
        for path in reversed(files[generation:]):
            path.unlink()
        return state

    def recorded(self, generation: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """A generation's genomes, `[n, genes]`, and their fitness, `[n, episodes]`."""
        import zipfile

        import numpy as np

        path = self._file(whole("generation", generation))
        try:
            with np.load(path) as arrays:
                return arrays["genomes"], arrays["fitness"]
        except FileNotFoundError:
            last = self.generation - 1
            raise InputError(f"generation: is {generation}; allowed: 0 to {last}, those that are recorded") from None
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise CorruptError(f"{path}: is damaged: {error}") from error

    @property
    def scores(self) -> list[NDArray[np.float32]]:
        """Mean fitness of each genome over its episodes, generation by generation."""
        return [self.recorded(generation)[1].mean(axis=1) for generation in range(self.generation)]

    @property
    def luckiest(self) -> Luckiest | None:
        """The genome with the best score so far; None before the first generation. Evaluate it on new episodes to see what it is worth."""
        import numpy as np

        from ._evolution import Luckiest

        best = None
        for generation, scores in enumerate(self.scores):
            if np.isnan(scores).all():
                continue
            individual = int(np.nanargmax(scores))
            if best is None or scores[individual] > best[2]:
                best = (generation, individual, float(scores[individual]))
        return None if best is None else Luckiest(*best, self.recorded(best[0])[0][best[1]])

    def audit(self, share: float = 0.01) -> dict[str, int]:
        """Re-evaluates a fraction (`share`) of the recorded individuals, at least one of each generation.

        Raises `FailedError` if a bit of their fitness differs; returns how many individuals and episodes (`episodes`) were compared.
        """
        import numpy as np

        if not 0 < share <= 1:
            raise InputError(f"share: is {share}; allowed: a number above 0 and up to 1, such as 0.01")
        compared = {"individuals": 0, "episodes": 0}
        for generation in range(self.generation):
            genomes, fitness = self.recorded(generation)
            count = max(1, round(share * len(genomes)))
            # Evenly spaced, others in each generation.
            chosen = np.unique((np.arange(count) * len(genomes) // count + generation) % len(genomes))
            again = self._lives(generation, genomes[chosen], chosen).fitness
            differ = np.flatnonzero((again.view(np.uint32) != fitness[chosen].view(np.uint32)).any(axis=1))
            if differ.size:
                individual = chosen[differ[0]]
                was, now = fitness[individual].tolist(), again[differ[0]].tolist()
                raise FailedError(f"{self.path}: generation {generation}, individual {individual}: {was} are now {now}")
            compared["individuals"] += len(chosen)
            compared["episodes"] += again.size
        return compared

    def _lives(
        self, generation: int, genomes: NDArray[np.float32], numbers: NDArray[Any], descriptors: bool = False
    ) -> Outcome:
        import numpy as np

        keys = np.zeros((len(genomes), 2), np.uint64)
        keys[:, 0] = generation
        if not self.about["common_starts"]:
            keys[:, 1] = numbers
        episodes, seed = self.about["episodes"], self.about["seed"]
        return evaluate(
            self.experiment,
            genomes,
            seed=seed,
            keys=keys,
            episodes=episodes,
            descriptors=descriptors,
            backend=self.backend,
        )

    def _file(self, generation: int) -> Path:
        return self.path / f"generation-{generation:06}.npz"

    def _files(self) -> list[Path]:
        """The recorded generations in their order."""
        files = sorted(self.path.glob("generation-*.npz"))
        if [path.name for path in files] != [self._file(number).name for number in range(len(files))]:
            raise CorruptError(f"{self.path}: generations are missing")
        return files

    def __repr__(self) -> str:
        return f"<oneiro.Recorder {str(self.path)!r}, {self.about['optimiser']}, generation {self.generation}>"


def _write(path: Path, data: bytes) -> None:
    """Writes a file as a whole or not at all."""
    part = path.with_name(f".part-{path.name}")
    try:
        part.write_bytes(data)
        os.replace(part, path)
    except OSError as error:
        raise StorageError(f"{path}: {error.strerror}") from error
