#!/usr/bin/env python3
"""Lives of champions of experiments/discrimination.toml that start as evorobotpy2's do: with a cylinder elsewhere in each life.

    benches/discrimination.py ONEIRO RUN...

ONEIRO is the program, each RUN the directory of a run. All runs live the same lives; their controllers may differ.
"""

import csv
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

LIVES = 100


def life(oneiro, runs, seed):
    """Fitness of each run's champion in one life."""
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
        command = [oneiro, "evaluate", "--quiet", "--starts", starts, "--seed", str(seed), "--genomes", *runs]
        command += [word for value in values for word in ("--set", value)]
        output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [float(row["fitness"]) for row in csv.DictReader(output.splitlines())]


def main():
    oneiro, *runs = sys.argv[1:]
    means = [statistics.mean(lived) for lived in zip(*(life(oneiro, runs, seed) for seed in range(1, LIVES + 1)))]
    for run, mean in zip(runs, means):
        print(f"{run}: {mean:.1f}")
    print(f"median {statistics.median(means):.1f}")


if __name__ == "__main__":
    main()
