"""Steps of CMA-ES as the Python package `cma` takes them, and how many evaluations it needs, as files for the tests of
host/evolve/src/cma/tests.rs.

    steps.py DIRECTORY        writes steps-N-ACTIVE.txt and evaluations.txt there
"""

import sys
import warnings
from pathlib import Path

import cma
import numpy as np

# `cma` 4.4.0 has other constants.
assert cma.__version__.split()[0] == "4.5.0", cma.__version__
# About options that a strategy of few dimensions does not need.
warnings.simplefilter("ignore")


def sphere(x):
    return float(np.sum(x * x))


def ellipsoid(x):
    return float(np.sum(1e6 ** (np.arange(len(x)) / max(1, len(x) - 1)) * x * x))


def words(numbers):
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


def steps(genes, active, count, seed):
    """Each step has a line of its samples, of their values, and of mean, step size and covariances after it."""
    options = {"CMA_active": active, "updatecovwait": 0, "verbose": -9, "seed": seed}
    es = cma.CMAEvolutionStrategy(genes * [1.0], 0.5, options)
    yield f"{genes} {es.popsize} {int(active)} {count}"
    yield words(es.mean)
    yield words(es.sigma)
    # Its first diagonal is spread by up to 1e-4.
    yield words(es.sm.C)
    for _ in range(count):
        samples = np.array(es.ask())
        values = [ellipsoid(sample) for sample in samples]
        es.tell(list(samples), values)
        yield words(samples)
        yield words(values)
        yield words(es.mean)
        yield words(es.sigma)
        yield words(es.sm.C)


def evaluations(function, diagonal, seed):
    """Evaluations up to the first value of 1e-9, of 10 genes from (1, .., 1) with the step size 0.5."""
    options = {"verbose": -9, "seed": seed, "CMA_diagonal": diagonal, "maxfevals": 200_000, "ftarget": 1e-9}
    es = cma.CMAEvolutionStrategy(10 * [1.0], 0.5, options)
    while not es.stop():
        samples = es.ask()
        es.tell(samples, [function(np.asarray(sample)) for sample in samples])
    assert es.best.f <= 1e-9, (function, diagonal, seed, es.stop())
    return es.best.evals


directory = Path(sys.argv[1])
for genes, count in [(2, 60), (10, 60), (66, 60)] if "--all" in sys.argv else [(3, 8)]:
    for active in [False, True]:
        lines = steps(genes, active, count, 7)
        (directory / f"steps-{genes}-{int(active)}.txt").write_text("\n".join(lines) + "\n")
rows = []
for name, function in [("sphere", sphere), ("ellipsoid", ellipsoid)]:
    for diagonal in [False, True]:
        own = sorted(evaluations(function, diagonal, seed) for seed in range(1, 22))
        rows.append(f"{name} {'sep-cma-es' if diagonal else 'cma-es'} {own[10]}")
(directory / "evaluations.txt").write_text("\n".join(rows) + "\n")
print("\n".join(rows))
