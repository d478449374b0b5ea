"""How fast the Python package is, beside the program and beside Gymnasium's own vector environment.

    ONEIRO_PROGRAM=target/release/oneiro PYTHON benches/python.py

with a Python into which the release's wheel and Gymnasium are installed, on a quiet machine. Each figure is the least of several turns, and
what is compared takes turns.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gymnasium
import numpy as np

import oneiro
import oneiro.gym
import oneiro.pettingzoo

EXPERIMENT = Path(__file__).resolve().parents[1] / "experiments/khepera-avoidance.toml"
PROGRAM = os.environ["ONEIRO_PROGRAM"]
TURNS = 7


def seconds(work):
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def least(*works):
    """The least time of each, which take turns."""
    times = [[seconds(work) for work in works] for _ in range(TURNS)]
    return [min(own) for own in zip(*times, strict=True)]


def evaluations(exp):
    genomes = np.random.default_rng(1).uniform(-1, 1, (10_000, exp.genes)).astype(np.float32)
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/genomes.npy", genomes)

        def program():
            out = Path(folder) / "out.npy"
            out.unlink(missing_ok=True)
            command = [PROGRAM, "evaluate", EXPERIMENT, "--genomes", f"{folder}/genomes.npy", "--seed", "1"]
            subprocess.run([*command, "--backend", "cpu", "--out", out, "-q"], check=True)

        def package():
            oneiro.evaluate(exp, genomes, seed=1, backend="cpu")

        package()
        there, here = least(program, package)
        same = np.array_equal(np.load(f"{folder}/out.npy"), oneiro.evaluate(exp, genomes, seed=1, backend="cpu").fitness)
    print(f"10,000 genomes: program {1000 * there:.1f} ms with its start, evaluate {1000 * here:.1f} ms,", end=" ")
    print(f"{here / there:.3f} of it; the same bits: {same}")


def single():
    exp = oneiro.Experiment.load(EXPERIMENT, set={"cycles": 1})
    genome = np.zeros((1, exp.genes), np.float32)

    def many():
        for _ in range(1000):
            oneiro.evaluate(exp, genome, seed=1, backend="cpu")

    many()
    print(f"one genome that lives for a single cycle: {1e6 * least(many)[0] / 1000:.1f} microseconds")


def environments(exp, count):
    steps = 2_000_000 // count
    ours = oneiro.gym.VectorEnv(exp, count)
    theirs = gymnasium.make_vec("CartPole-v1", num_envs=count, vectorization_mode="vector_entry_point")
    works = []
    for envs in (ours, theirs):
        envs.reset(seed=1)
        envs.action_space.seed(1)
        actions = [envs.action_space.sample() for _ in range(16)]

        def run(envs=envs, actions=actions):
            for step in range(steps):
                envs.step(actions[step % 16])

        run()
        works.append(run)
    for name, took in zip(["oneiro.gym.VectorEnv", "Gymnasium's CartPole"], least(*works), strict=True):
        print(f"{name}, {count} environments: {count * steps / took / 1e6:.2f} M steps/s")


def arenas(count=1024, steps=20):
    exp = oneiro.Experiment.load(EXPERIMENT.with_name("aggregation.toml"))
    envs = oneiro.pettingzoo.VectorEnv(exp, count)
    robots = envs.reset(seed=1)[0].shape[1]
    actions = np.random.default_rng(1).uniform(-1, 1, (count, robots, 2)).astype(np.float32)

    def run():
        for _ in range(steps):
            envs.step(actions)

    run()
    print(f"oneiro.pettingzoo.VectorEnv, {count} arenas of {robots}: {count * robots * steps / least(run)[0] / 1e6:.2f} M robot-steps/s")


if __name__ == "__main__":
    print(f"Python {sys.version.split()[0]}, NumPy {np.__version__}, Gymnasium {gymnasium.__version__}, {os.cpu_count()} processors")
    exp = oneiro.Experiment.load(EXPERIMENT)
    evaluations(exp)
    single()
    for count in (1024, 4096, 16384):
        environments(exp, count)
    arenas()
