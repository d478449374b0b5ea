"""Evaluations that SciPy's differential evolution needs, for the test of host/evolve/src/differential_evolution.rs.

differential.py FILE        writes the median of 21 seeds, by function, strategy and weight, there
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import differential_evolution

GENES = 10
# By Python's power: NumPy's depends on the processor.
FACTORS = np.array([1e6 ** (gene / (GENES - 1)) for gene in range(GENES)])


class Found(Exception):
    pass


def evaluations(factors, strategy, weight, seed):
    """Evaluations up to the first value of 1e-9, by 50 members that begin between -1 and 3."""
    count = 0

    def value(x):
        nonlocal count
        count += 1
        found = float(np.sum(factors * x * x))
        if found <= 1e-9:
            raise Found
        return found

    rng = np.random.default_rng(seed)
    try:
        differential_evolution(
            value,
            # Its bounds, from which it draws anew, are out of the way.
            [(-100, 100)] * GENES,
            strategy=strategy.replace("/", ""),
            mutation=weight,
            recombination=0.9,
            init=rng.uniform(-1, 3, (50, GENES)),
            updating="deferred",
            polish=False,
            tol=0,
            maxiter=5000,
            rng=rng,
        )
    except Found:
        return count
    raise AssertionError((strategy, seed))


lines = []
for name, factors in [("sphere", np.ones(GENES)), ("ellipsoid", FACTORS)]:
    for strategy, weight in [("rand/1/bin", 0.5), ("best/1/bin", 0.7)]:
        counts = sorted(evaluations(factors, strategy, weight, seed) for seed in range(1, 22))
        lines.append(f"{name} {strategy} {weight} {counts[10]}")
Path(sys.argv[1]).write_text("\n".join(lines) + "\n")
print("\n".join(lines))
