# %% [markdown]
# # A sweep on a Ray cluster
#
# Each shard of the sweep is a task. Shards merge into the tables that a single process makes, byte for byte, however many there
# are. Run from the repository's root, with `pip install ray` and the package (docs/python.md says how to build it). Here the
# cluster is this machine's; on another one the folder must be shared, or each shard gets a separate folder and `oneiro.merge`
# all of them.

# %%
import tempfile
from pathlib import Path

import ray

import oneiro

PLAN = str(Path("experiments/sweeps/small.toml").resolve())
FOLDER = Path(tempfile.mkdtemp()) / "sweep"
SHARDS = 4


@ray.remote
def run_shard(shard):
    oneiro.sweep_shard(PLAN, out=FOLDER, shard=shard, backend="cpu")
    return shard


# %%
# To join a cluster that runs, give `ray.init` its address instead.
ray.init(num_cpus=2, include_dashboard=False)
print(ray.get([run_shard.remote(f"{index + 1}/{SHARDS}") for index in range(SHARDS)]))
ray.shutdown()
sweep = oneiro.merge(FOLDER)
print(f"{sweep.runs} runs, hash {sweep.hash}")
