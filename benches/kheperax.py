#!/usr/bin/env python3
"""Compares experiments/kheperax.toml with Kheperax's own program: where random policies end, and steps per second on one core.

    taskset -c 0 benches/kheperax.py ONEIRO KHEPERAX [POLICIES]

ONEIRO is the program, KHEPERAX a checkout of github.com/adaptive-intelligent-robotics/Kheperax. It needs Python's packages
jax[cpu], flax, chex and numpy. Of QDax, which Kheperax names for types only, stand-ins are enough. Speeds are by processor time, which
other programs on the machine hardly change. Code by Cranelift stands beside the widest.
"""

import json
import os
import subprocess
import sys
import tempfile
import types
from pathlib import Path

import numpy as np

STEPS = 250
ROUNDS = 3
EXPERIMENT = Path(__file__).parent.parent / "experiments/kheperax.toml"


def policies(count):
    """Genes in Oneiro's order: of each unit five weights, a bias and two output weights; then the outputs' biases."""
    random = np.random.default_rng(1)
    units = np.zeros((count, 8, 8), np.float32)
    units[:, :, :5] = random.uniform(-1, 1, (count, 8, 5)) * np.sqrt(3 / 5)
    units[:, :, 6:] = random.uniform(-1, 1, (count, 8, 2)) * np.sqrt(3 / 8)
    return np.concatenate([units.reshape(count, 64), np.zeros((count, 2), np.float32)], axis=1)


def kheperax(checkout):
    """A function from genes to the places where Kheperax's robots end and their fitness."""
    sys.path.insert(0, checkout)
    custom = types.ModuleType("qdax.custom_types")
    for name in "RNGKey Action Descriptor ExtraScores Fitness Genotype Params".split():
        setattr(custom, name, object)
    sys.modules |= {"qdax": types.ModuleType("qdax"), "qdax.custom_types": custom}
    import jax
    import jax.numpy as jnp
    from kheperax.envs.maze_maps import get_target_maze_map
    from kheperax.simu.maze import Maze
    from kheperax.simu.posture import Posture
    from kheperax.simu.robot import Robot

    maze = Maze.create(segments_list=get_target_maze_map("standard").segments)
    start = Robot.create_default_robot().replace(
        posture=Posture(jnp.float32(0.15), jnp.float32(0.15), jnp.float32(np.pi / 2)),
        lasers_return_minus_one_if_out_of_range=True,
    )
    key = jax.random.PRNGKey(0)

    def observed(robot, bumpers):
        return jnp.concatenate([robot.laser_measures(maze, random_key=key), bumpers])

    def life(genes):
        units = genes[:64].reshape(8, 8)

        def step(carry, _):
            robot, observation = carry
            hidden = jax.nn.relu(units[:, :5] @ observation + units[:, 5])
            wheels = 0.025 * jnp.tanh(hidden @ units[:, 6:] + genes[64:])
            after, bumpers = robot.move(wheels[0], wheels[1], maze)
            return (after, observed(after, bumpers)), -jnp.sum(wheels**2)

        first = (start, observed(start, start.bumper_measures(maze)))
        (robot, _), rewards = jax.lax.scan(step, first, None, length=STEPS)
        return jnp.array([robot.posture.x, robot.posture.y]), rewards.sum()

    lives = jax.jit(jax.vmap(life))
    return lambda genes: [np.asarray(result) for result in lives(genes)]


def processor():
    """Seconds of processor time of this process and of those that it waited for."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def oneiro(program, genes, *more, backend="cpu"):
    with tempfile.TemporaryDirectory() as directory:
        file = f"{directory}/genes.npy"
        np.save(file, genes)
        call = [program, "evaluate", EXPERIMENT, "--genomes", file, "--seed", "1", "--set", "task.values.goal=0"]
        began = processor()
        done = subprocess.run([*call, "--backend", backend, "--quiet", *more], check=True, capture_output=True, text=True)
        return done.stdout, processor() - began


def main():
    program, checkout, *count = sys.argv[1:]
    genes = policies(int(count[0]) if count else 2048)
    lives = kheperax(checkout)
    places, fitness = lives(genes)
    rows = json.loads(oneiro(program, genes, "--measures", "--json")[0])
    own = np.array([[row["end_x_mm"], row["end_y_mm"]] for row in rows]) / 1000
    off = np.hypot(*(own - places).T)
    print(f"{(off < 1e-3).sum()} of {len(genes)} end within 0.001 of each other, median {np.median(off):.1e}")
    apart = np.abs(np.array([row["fitness"] for row in rows]) - fitness) / np.maximum(np.abs(fitness), 1e-9)
    print(f"median relative difference of the fitness {np.median(apart):.1e}")
    for name, ends in [("Kheperax", places), ("Oneiro", own)]:
        cells = {(min(int(x * 50), 49), min(int(y * 50), 49)) for x, y in ends}
        print(f"{name} covers {len(cells) / 25:.1f} % of a 50 x 50 grid")
    many = np.tile(genes, (64, 1))
    for _ in range(ROUNDS):
        began = processor()
        lives(genes)
        theirs = genes.shape[0] * STEPS / (processor() - began) / 1e6
        print(f"{theirs:.2f} million steps per second by Kheperax")
        for backend in ("cpu:native128x16", "cpu"):
            # Without the start, which the smaller call has as well.
            seconds = oneiro(program, many, backend=backend)[1] - oneiro(program, genes, backend=backend)[1]
            ours = (len(many) - len(genes)) * STEPS / seconds / 1e6
            print(f"{ours:.2f} by Oneiro, {backend}: {ours / theirs:.1f} times")


if __name__ == "__main__":
    main()
