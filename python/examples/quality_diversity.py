# %% [markdown]
# # Quality diversity, with a picture of the archive
#
# `ribs` fills an archive of the places where episodes in Kheperax's maze end (CMA-ME). Run from the repository's root, with
# `pip install "ribs[visualize]"` and the package (docs/python.md says how to build it). Only simulated episodes are bit-reproducible:
# the results of `ribs` may differ between its versions and NumPy's. (Oneiro also has the optimiser `map-elites`, which is
# bit-reproducible.)

# %%
import matplotlib.pyplot as plt
import numpy as np
from ribs.archives import GridArchive
from ribs.emitters import EvolutionStrategyEmitter
from ribs.schedulers import Scheduler
from ribs.visualize import grid_archive_heatmap

import oneiro

ITERATIONS = 100

exp = oneiro.Experiment.load("experiments/kheperax.toml")
measures = [exp.descriptor_names.index(name) for name in ("end_x_mm", "end_y_mm")]
start = np.random.default_rng(1).uniform(-1, 1, exp.genes)
# The maze is a square of a metre.
archive = GridArchive(solution_dim=exp.genes, dims=[50, 50], ranges=[(0, 1000)] * 2, seed=1)
emitters = [
    EvolutionStrategyEmitter(archive, x0=start, sigma0=0.2, batch_size=30, es="sep_cma_es", seed=seed)
    for seed in range(4)
]
scheduler = Scheduler(archive, emitters)

# %%
for iteration in range(ITERATIONS):
    genomes = scheduler.ask()
    keys = [[iteration, genome] for genome in range(len(genomes))]
    outcome = oneiro.evaluate(exp, genomes, seed=1, keys=keys, descriptors=True)
    scheduler.tell(outcome.fitness[:, 0].astype(float), outcome.descriptors[:, 0, measures])
print(f"coverage {100 * archive.stats.coverage:.1f} %, best {archive.stats.obj_max:.3f}")

# %%
figure, axes = plt.subplots()
grid_archive_heatmap(archive, ax=axes)
axes.set(xlabel="end, x (mm)", ylabel="end, y (mm)", title=f"{len(archive)} elites: fitness by where an episode ends")
