#!/usr/bin/env python3
"""Recomputes a foraging run from its files, without the program.

    python3 studies/foragers.py RUN_DIR..

Of each run directory it recomputes equation 1 of O'Dowd, Studley and Winfield (2014) and the food of each second from
deposits.csv; the controller that acts, the four that stay and the six that are overwritten from controllers.csv; and the
fitness that robots reported, and whose simulator goes on, from pairs.csv. It prints how many values it compared with the other
tables, and those that differ. It exits with 1 if any does. It needs Python 3.11 and no packages.
"""

import csv
import sys
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

# Fitness is a sum of 32-bit numbers.
CLOSE = 1e-3


class Checks:
    """Counts what was compared, and prints what differs."""

    def __init__(self):
        self.compared, self.differing = Counter(), Counter()

    def same(self, what, found, expected, where):
        self.compared[what] += 1
        is_number = isinstance(found, float) and isinstance(expected, float)
        if abs(found - expected) > CLOSE if is_number else found != expected:
            self.differing[what] += 1
            if self.differing[what] <= 3:
                print(f"{what}: {found}, in the table {expected}, at {where}")


def table(directory, name):
    """The rows of a table, its numbers as numbers."""
    with open(directory / name, newline="") as file:
        return [{key: float(value) if value else None for key, value in row.items()} for row in csv.DictReader(file)]


def by_robot(rows):
    """Rows by interval and robot."""
    groups = defaultdict(list)
    for row in rows:
        groups[int(row["interval"]), int(row["robot"])].append(row)
    return groups


def food(checks, directory, deposits, intervals, length):
    """Equation 1: each item earns what is left of the interval. Returns what each robot had earned after each item."""
    earned = defaultdict(lambda: [0.0])
    for row in deposits:
        sums = earned[int(row["interval"]), int(row["robot"])]
        sums.append(sums[-1] + length - row["into_s"])
    for place, row in intervals.items():
        checks.same("F_R by equation 1", earned[place][-1], row["real"], place)
    # An item is of the second in which its cycle, a tenth of it, ends.
    brought = Counter((round(10 * row["time_s"]) - 1) // 10 for row in deposits)
    for row in table(directory, "food.csv"):
        checks.same("food of a second", brought[int(row["second"])], int(row["brought"]), row["second"])
    return earned


def genes(row):
    return row["g0"], row["g1"]


def controllers(checks, populations, intervals, pairs, swarm):
    """The best acts, the first ranks stay, and mutated copies of them overwrite the others. Returns changed and all genes."""
    settings, clock = swarm["controllers"], swarm["clock"]
    parents, guests = settings["parents"], settings["guests"]
    # In an interval's last second the robot acts by what was chosen in that interval, or in the one before.
    late = int(clock["installed_s"] == clock["interval_s"])
    changed = copied = 0
    for (interval, robot), rows in populations.items():
        ranked = sorted(rows, key=lambda row: row["rank"])
        fitness = [row["simulated"] for row in ranked]
        checks.same("order of the ranks", fitness, sorted(fitness, reverse=True), (interval, robot))
        acts = intervals.get((interval + late, robot))
        if acts:
            checks.same("controller that acts", genes(ranked[0]), genes(acts), (interval, robot))
            checks.same("F_sim of the best", fitness[0], acts["simulated"], (interval, robot))
        following = populations.get((interval + 1, robot))
        if not following:
            continue
        following = [genes(row) for row in sorted(following, key=lambda row: row["controller"])]
        for rank in range(parents):
            checks.same("controller that stays", following[rank], genes(ranked[rank]), (interval, robot, rank))
        received = [genes(pair) for pair in pairs[interval, robot][:guests]]
        own = len(following) - min(len(received), len(following) - parents)
        checks.same("received controllers", following[own:], received[: len(following) - own], (interval, robot))
        for index in range(parents, own):
            parent = genes(ranked[(index - parents) % parents])
            changed += sum(gene != other for gene, other in zip(following[index], parent))
            copied += 2
            checks.same("range of a gene", all(0 <= gene <= 0.99 for gene in following[index]), True, (interval, robot))
    return changed, copied


def simulators(checks, pairs, intervals, earned, swarm):
    """Pairs say what their senders had earned by then, and the best one above one's own is taken over."""
    credited = {"lagged": "s0", "matched": "chosen_under"}[swarm["simulators"]["credit"]]
    last = max((interval for interval, _ in intervals), default=-1)
    for place, row in intervals.items():
        stored = pairs[place]
        for pair in stored:
            sent = int(pair["sent_interval"]), int(pair["sender"])
            where = (*place, sent)
            if sent in intervals:
                checks.same("simulator of a pair", pair["s0"], intervals[sent][credited], where)
            if swarm["simulators"]["says"] == "so_far":
                is_partial = any(abs(pair["fitness"] - so_far) < CLOSE for so_far in earned[sent])
                checks.same("fitness of a pair by equation 1", is_partial, True, where)
        if place[0] < last:
            is_better = bool(stored) and max(pair["fitness"] for pair in stored) > row["real"]
            checks.same("whose simulator goes on", int(is_better), int(row["taken"]), place)


def recompute(directory):
    """Whether a run's tables agree."""
    checks = Checks()
    with open(directory / "config.toml", "rb") as file:
        swarm = tomllib.load(file)["swarm"]
    length = swarm["clock"]["interval_s"]
    intervals = {place: rows[0] for place, rows in by_robot(table(directory, "intervals.csv")).items()}
    pairs = by_robot(table(directory, "pairs.csv"))
    earned = food(checks, directory, table(directory, "deposits.csv"), intervals, length)
    if swarm["case"] != "random":
        populations = by_robot(table(directory, "controllers.csv"))
        changed, copied = controllers(checks, populations, intervals, pairs, swarm)
        rate = swarm["controllers"]["mutation_rate"]
        print(f"{changed} of {copied} copied genes were changed; at a rate of {rate}, {rate * copied:.0f} are expected")
        # A changed gene that is clamped may be what it was: fewer may be seen, not more.
        most = rate * copied + 5 * (rate * (1 - rate) * copied) ** 0.5
        checks.same("genes that were changed", changed <= most, True, f"{changed} of {copied}")
        if swarm.get("control", "evolved") == "evolved":
            simulators(checks, pairs, intervals, earned, swarm)
    for what, count in checks.compared.items():
        print(f"{what}: {checks.differing[what]} of {count} differ")
    print(f"{directory}: {checks.differing.total()} differences")
    return checks.differing.total() == 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(not all([recompute(Path(directory)) for directory in sys.argv[1:]]))
