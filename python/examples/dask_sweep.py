# %% [markdown]
# # A sweep on a Dask cluster
#
# Each shard of the sweep is a task. Shards merge into the tables that a single process makes, byte for byte, however many there
# are. Run from the repository's root, with `pip install "dask[distributed]"` and the package (docs/python.md says how to build
# it). Here the cluster is this machine's; on another one the folder must be shared, or each shard gets a separate folder and
# `oneiro.merge` all of them.

# %%
import tempfile
from pathlib import Path

from dask.distributed import Client, LocalCluster

import oneiro

PLAN = str(Path("experiments/sweeps/small.toml").resolve())
FOLDER = Path(tempfile.mkdtemp()) / "sweep"
SHARDS = 4


def run_shard(shard):
    oneiro.sweep_shard(PLAN, out=FOLDER, shard=shard, backend="cpu")
    return shard


# %%
# Processes that are spawned import this file again.
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1) as cluster, Client(cluster) as client:
        tasks = client.map(run_shard, [f"{index + 1}/{SHARDS}" for index in range(SHARDS)], pure=False)
        print(client.gather(tasks))
    sweep = oneiro.merge(FOLDER)
    print(f"{sweep.runs} runs, hash {sweep.hash}")
