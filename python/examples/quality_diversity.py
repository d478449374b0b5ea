"""Quality diversity by others: `ribs` (pip install ribs) fills an archive of the places where lives in Kheperax's maze end.

    python python/examples/quality_diversity.py [iterations]

Bits are promised of the lives only: what `ribs` makes of them may differ between its versions and NumPy's.
"""

import sys
from pathlib import Path

import numpy as np
from ribs.archives import GridArchive
from ribs.emitters import EvolutionStrategyEmitter
from ribs.schedulers import Scheduler

import oneiro

EXPERIMENT = Path(__file__).resolve().parents[2] / "experiments/kheperax.toml"


def main(iterations: int = 100) -> float:
    exp = oneiro.Experiment.load(EXPERIMENT)
    where = [exp.descriptor_names.index(name) for name in ("end_x_mm", "end_y_mm")]
    random = np.random.default_rng(1)
    start = random.uniform(-1, 1, exp.genes)
    # The maze is a square of a metre.
    archive = GridArchive(solution_dim=exp.genes, dims=[50, 50], ranges=[(0, 1000)] * 2, seed=1)
    emitters = [
        EvolutionStrategyEmitter(archive, x0=start, sigma0=0.2, batch_size=30, es="sep_cma_es", seed=seed)
        for seed in range(4)
    ]
    scheduler = Scheduler(archive, emitters)
    for iteration in range(iterations):
        genomes = scheduler.ask()
        keys = [[iteration, genome] for genome in range(len(genomes))]
        outcome = oneiro.evaluate(exp, genomes, seed=1, keys=keys, descriptors=True)
        scheduler.tell(outcome.fitness[:, 0].astype(float), outcome.descriptors[:, 0, where])
    print(f"coverage {100 * archive.stats.coverage:.1f} %, best {archive.stats.obj_max:.3f}")
    return archive.stats.coverage


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
