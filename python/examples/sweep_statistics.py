# %% [markdown]
# # A sweep's statistics
#
# A small sweep over mutation and population sizes, its table in pandas, and intervals by the bootstrap. Run from the repository's
# root, with `pip install pandas scipy` and the package (docs/python.md says how to build it).

# %%
import tempfile
from pathlib import Path

import numpy as np
from scipy import stats

import oneiro

PLAN = "experiments/sweeps/small.toml"
FOLDER = Path(tempfile.mkdtemp()) / "sweep"

sweep = oneiro.sweep(PLAN, out=FOLDER)
results = sweep.results
print(f"{sweep.runs} runs, hash {sweep.hash}")
print(results.head())

# %% [markdown]
# The cells of the plan are its varied values: columns between the run's number and its outcomes that differ.

# %%
varied = [name for name in results.columns if "." in name and results[name].nunique() > 1]
for values, runs in results.groupby(varied):
    best = runs["mean"].to_numpy()
    interval = stats.bootstrap((best,), np.mean, rng=np.random.default_rng(1)).confidence_interval
    cell = ", ".join(f"{name} {value}" for name, value in zip(varied, values, strict=True))
    print(
        f"{cell}: mean fitness of the last generation {best.mean():.1f} [{interval.low:.1f}, {interval.high:.1f}], {len(best)} runs"
    )
