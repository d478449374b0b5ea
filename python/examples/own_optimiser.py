# %% [markdown]
# # A custom optimiser
#
# `cma` evolves obstacle avoidance. Every generation is recorded, and new episodes test the result. Run from the repository's
# root, with `pip install cma` and the package (docs/python.md says how to build it). Only simulated episodes are bit-reproducible:
# `cma`'s results may differ between its versions and NumPy's.

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
recorder = oneiro.Recorder(exp, seed=1, out=FOLDER, optimiser=f"cma {cma.__version__}", episodes=5)

# %% [markdown]
# All genomes of a generation get the same random numbers, so that luck doesn't decide between them.
# Every tenth generation saves the state, which includes NumPy's global generator: `cma` draws from it.


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
# A stopped evolution continues from the saved state: `recorder = oneiro.Recorder.open(FOLDER)`, `search, state = recorder.restore()`,
# `np.random.set_state(state)`. `audit` re-evaluates some recorded individuals: a bit that differs is an error.

# %%
print(recorder.audit(share=0.05))
best = oneiro.evaluate(exp, search.result.xfavorite, seed=2, episodes=1000).fitness
print(
    f"{best.mean():.1f} +- {best.std() / np.sqrt(best.size):.1f}, mean of {best.size} new episodes and its standard error"
)
