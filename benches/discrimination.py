#!/usr/bin/env python3
"""Lives of experiments/discrimination.toml that start as evorobotpy2's do: with a cylinder elsewhere in each life.

    benches/discrimination.py ONEIRO RUN...

ONEIRO is the program, each RUN the directory of a run. All runs live the same lives; their controllers may differ. Prints the mean of
each champion's 100 lives, and their median.

    benches/discrimination.py --scores ONEIRO RUN... [--set KEY=VALUE]

prints evorobotpy2's score, which it calls generalisation, of runs with the same controller: the best individual of each generation lives
20 lives, the same for all, and the best mean of any generation so far counts. Its generations are counted in cycles of lives. How
many cycles a generation lived is estimated from every tenth, whose individuals live again. Values that the runs don't have from the experiment are given again.
Needs NumPy.
"""

import csv
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

LIVES = 100
SCORED_LIVES = 20
MILLIONS = [10, 30, 60]
EXPERIMENT = Path(__file__).resolve().parents[1] / "experiments/discrimination.toml"
# Earns 1 in each cycle, and ends a life as the experiment's does.
CYCLES = """
struct TaskState { collided: u32, }
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState { return TaskState(0u); }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(1.0f, TaskState(select(0u, 1u, now.collided)));
}
fn task_ends(episode: Episode, own: TaskState) -> bool { return own.collided != 0u; }
"""


def evaluated(oneiro, *options):
    """Fitness of each life."""
    command = [oneiro, "evaluate", "--quiet", *map(str, options)]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    return [float(row["fitness"]) for row in csv.DictReader(output.splitlines())]


def life(oneiro, genomes, seed):
    """Fitness of each controller in one life. `genomes` are words of the command: runs, or an experiment and files."""
    draw = random.Random(seed)
    x, y = draw.uniform(100, 300), draw.uniform(100, 200)
    with tempfile.TemporaryDirectory() as scratch:
        starts = Path(scratch) / "starts.csv"
        starts.write_text(f"{draw.uniform(150, 250)},{draw.uniform(270, 370)},{draw.random()}\n")
        values = [
            f"arena.obstacles=[{{ x_mm = {x}, y_mm = {y}, radius_mm = 12.5 }}]",
            f"task.values.x={x}",
            f"task.values.y={y}",
        ]
        options = [word for value in values for word in ("--set", value)]
        return evaluated(oneiro, *genomes, "--starts", starts, "--seed", seed, *options)


def champions(oneiro, runs):
    lived = [life(oneiro, ["--genomes", *runs], seed) for seed in range(1, LIVES + 1)]
    means = [statistics.mean(own) for own in zip(*lived)]
    for run, mean in zip(runs, means):
        print(f"{run}: {mean:.1f}")
    print(f"median {statistics.median(means):.1f}")


def scores(oneiro, runs, options):
    import numpy as np

    reached = []
    with tempfile.TemporaryDirectory() as scratch:
        task, genomes = Path(scratch) / "cycles.wgsl", Path(scratch) / "genomes.npy"
        task.write_text(CYCLES)
        for run in runs:
            individuals = np.load(Path(run) / "individuals.npy", mmap_mode="r")
            generations, population, columns = individuals.shape
            settings = [EXPERIMENT, "--genomes", genomes, *options]
            np.save(genomes, individuals[::10, :, :-1].reshape(-1, columns - 1))
            lived = evaluated(oneiro, *settings, "--set", f"task.part={task}", "--trials", 10, "--seed", 1)
            a_generation = np.repeat(np.reshape(lived, (-1, population * 10)).sum(axis=1), 10)[:generations]
            cycles = a_generation.cumsum()
            best = individuals[:, :, -1].argmax(axis=1)
            np.save(genomes, individuals[np.arange(generations), best, :-1])
            means = np.mean([life(oneiro, settings, 1000 + seed) for seed in range(SCORED_LIVES)], axis=0)
            best_so_far = np.maximum.accumulate(means)
            # NaN where a run ended before.
            at = [np.searchsorted(cycles, 1e6 * millions) for millions in MILLIONS]
            own = [best_so_far[index] if index < generations else np.nan for index in at] + [best_so_far[-1]]
            reached.append(own)
            words = [f"{score:.0f} after {count} million" for score, count in zip(own, MILLIONS)]
            print(f"{run}: {', '.join(words)}, {own[-1]:.0f} after all {cycles[-1] / 1e6:.0f} million", flush=True)
    print("median", *(f"{score:.0f}" for score in np.median(reached, axis=0)))


def main():
    arguments = sys.argv[1:]
    if arguments[0] == "--scores":
        end = arguments.index("--set") if "--set" in arguments else len(arguments)
        scores(arguments[1], arguments[2:end], arguments[end:])
    else:
        champions(arguments[0], arguments[1:])


if __name__ == "__main__":
    main()
