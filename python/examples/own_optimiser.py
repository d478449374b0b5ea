"""An optimiser of others: `cma` (pip install cma) evolves obstacle avoidance, and fresh lives judge what it found.

    python python/examples/own_optimiser.py [generations]

Bits are promised of the lives only: what `cma` makes of them may differ between its versions and NumPy's.
"""

import sys
from pathlib import Path

import cma
import numpy as np

import oneiro

EXPERIMENT = Path(__file__).resolve().parents[2] / "experiments/khepera-avoidance.toml"


def main(generations: int = 60) -> float:
    exp = oneiro.Experiment.load(EXPERIMENT)
    search = cma.CMAEvolutionStrategy(np.zeros(exp.genes), 1.0, {"popsize": 40, "seed": 1, "verbose": -9})
    for generation in range(generations):
        genomes = search.ask()
        # Each generation has lives of its own, the same for all of its genomes.
        keys = [[generation, 0]] * len(genomes)
        fitness = oneiro.evaluate(exp, genomes, seed=1, keys=keys, lives=5).fitness.mean(axis=1)
        # `cma` minimises.
        search.tell(genomes, (-fitness.astype(float)).tolist())
    # Lives that no selection has seen.
    best = oneiro.evaluate(exp, search.result.xfavorite, seed=2, lives=1000).fitness
    print(
        f"{best.mean():.1f} +- {best.std() / np.sqrt(best.size):.1f}, the mean of {best.size} fresh lives and its standard error"
    )
    return float(best.mean())


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
