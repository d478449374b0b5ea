# %% [markdown]
# # An optimiser of your own
#
# `cma` evolves obstacle avoidance, every generation is recorded, and fresh lives judge what it found. Run from the repository's
# root, with `pip install cma` and the package (docs/python.md says how to build it). Bits are promised of the lives only: what
# `cma` makes of them may differ between its versions and NumPy's.

# %%
import tempfile
from pathlib import Path

import cma
import numpy as np

import oneiro

GENERATIONS = 60
FOLDER = Path(tempfile.mkdtemp()) / "cma"

exp = oneiro.Experiment.load("experiments/khepera-avoidance.toml")
search = cma.CMAEvolutionStrategy(np.zeros(exp.genes), 1.0, {"popsize": 40, "seed": 1, "verbose": -9})
recorder = oneiro.Recorder(exp, seed=1, out=FOLDER, optimiser=f"cma {cma.__version__}", lives=5)

# %% [markdown]
# All genomes of a generation get the same random numbers, so that they differ by what they are and not by their luck.
# Every tenth generation the state is saved: `cma` draws from NumPy's global generator, which is part of it.


# %%
def evolve(recorder, search, generations):
    while recorder.generation < generations:
        genomes = search.ask()
        fitness = recorder.evaluate(genomes).fitness.mean(axis=1)
        # `cma` minimises.
        search.tell(genomes, (-fitness.astype(float)).tolist())
        if recorder.generation % 10 == 0:
            recorder.save((search, np.random.get_state()))
    return search


search = evolve(recorder, search, GENERATIONS)

# %% [markdown]
# A stopped evolution goes on from what was saved: `recorder = oneiro.Recorder.open(FOLDER)`, `search, state = recorder.restore()`,
# `np.random.set_state(state)`. Some of what was recorded lives again: a single bit that differs is an error.

# %%
print(recorder.audit(share=0.05))
best = oneiro.evaluate(exp, search.result.xfavorite, seed=2, lives=1000).fitness
print(
    f"{best.mean():.1f} +- {best.std() / np.sqrt(best.size):.1f}, mean of {best.size} fresh lives and its standard error"
)
