# %% [markdown]
# # A policy by PPO against the evolved champion
#
# Stable-Baselines3 trains a network; evolution has as many steps. Both are tested on the same new starts.
# Run from the repository's root, with `pip install "stable-baselines3>=2.6"` (which brings torch) and the package
# (docs/python.md says how to build it).

# %%
import numpy as np
import torch
from stable_baselines3 import PPO

import oneiro
import oneiro.sb3

STEPS = 400_000
ENVIRONMENTS = 16
FRESH_EPISODES = 64

exp = oneiro.Experiment.load("experiments/khepera-avoidance.toml")
envs = oneiro.sb3.VecEnv(exp, ENVIRONMENTS)
envs.seed(1)
# Networks as small as these are slower on several threads.
torch.set_num_threads(1)
model = PPO("MlpPolicy", envs, n_steps=256, batch_size=512, seed=1, device="cpu")
model.learn(STEPS)

# %% [markdown]
# New episodes of the policy: the first episodes of environments with another seed are the first episodes of as many genomes of
# `oneiro.evaluate` with that seed, so both get the same starts and the same noise.

# %%
judges = oneiro.gym.VectorEnv(exp, FRESH_EPISODES)
observations, _ = judges.reset(seed=2)
policy, done = np.zeros(FRESH_EPISODES), np.zeros(FRESH_EPISODES, bool)
while not done.all():
    actions, _ = model.predict(observations, deterministic=True)
    observations, _, terminated, truncated, infos = judges.step(actions)
    over = (terminated | truncated) & ~done
    policy[over] = infos["fitness"][over] if over.any() else 0
    done |= over

# %%
episodes = exp.trials * STEPS // exp.cycles
evolution = oneiro.Evolution(exp, seed=1)
spent = 0
while spent < episodes and not evolution.is_finished:
    outcome = oneiro.evaluate(exp, evolution.ask(), seed=1, keys=evolution.keys, episodes=exp.trials)
    spent += outcome.fitness.size
    evolution.tell(outcome.fitness)
genome = evolution.luckiest.genome
champion = oneiro.evaluate(exp, np.tile(genome, (FRESH_EPISODES, 1)), seed=2).fitness[:, 0]


# %%
def summary(name, fitness):
    error = fitness.std(ddof=1) / np.sqrt(fitness.size)
    print(f"{name}: {fitness.mean():.1f} +- {error:.1f}, mean of {fitness.size} new episodes and its standard error")


summary(f"PPO after {STEPS} steps", policy)
summary(f"evolution after {spent} episodes", champion)

# %% [markdown]
# The policy as a genome, with which `oneiro.adopt` makes a run that can be replayed, exported and driven on a robot. Its fitness is
# that of the steps above, up to rounding.

# %%
same = exp.with_policy(model)
fresh = oneiro.evaluate(same, np.tile(same.genome_of(model), (FRESH_EPISODES, 1)), seed=2).fitness[:, 0]
summary("PPO as a genome", fresh)
