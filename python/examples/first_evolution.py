# %% [markdown]
# # A first evolution
#
# A Khepera learns to avoid walls with its experiment's optimiser, by `ask` for genomes and `tell` for their fitness. Run from the
# repository's root, with `pip install matplotlib` and the package (docs/python.md says how to build it).

# %%
import matplotlib.pyplot as plt
import numpy as np

import oneiro

GENERATIONS = 60
FRESH_EPISODES = 1000

exp = oneiro.Experiment.load("experiments/khepera-avoidance.toml", set={"evolution.generations": GENERATIONS})
print(f"{exp.name}: {exp.genes} genes, {exp.trials} episode of each individual in a generation")

# %% [markdown]
# Each genome has one episode, with the same random numbers as in `oneiro run`: with the same seed this evolution
# has the bits of a run of the program.

# %%
evolution = oneiro.Evolution(exp, seed=1)
scores = []
while not evolution.is_finished:
    outcome = oneiro.evaluate(exp, evolution.ask(), seed=1, keys=evolution.keys, episodes=exp.trials)
    scores.append(outcome.fitness.mean(axis=1))
    evolution.tell(outcome.fitness)

# %%
figure, axes = plt.subplots()
axes.plot([generation.max() for generation in scores], label="best")
axes.plot([generation.mean() for generation in scores], label="mean")
axes.set(xlabel="generation", ylabel="fitness", title=exp.name)
axes.legend()

# %% [markdown]
# The best score of an evolution is also its luckiest: evaluate its genome on new episodes to see what it is worth.

# %%
luckiest = evolution.luckiest
fresh = oneiro.evaluate(exp, luckiest.genome, seed=2, episodes=FRESH_EPISODES).fitness[0]
error = fresh.std(ddof=1) / np.sqrt(fresh.size)
print(f"luckiest episode {luckiest.score:.1f}, mean of {fresh.size} new episodes {fresh.mean():.1f} +- {error:.1f}")
