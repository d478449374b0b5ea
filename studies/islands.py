"""Judges the 2014 study as islands: python studies/islands.py islands/results.csv

Prints the tables of studies/odowd2014/README.md: food and takeover times by links and migration rate, beside two models of takeover, and
the contrasts of studies/preregistration-2014-islands.md. With --keep FILE it writes what it takes of the sweep's table to a file, and FILE
alone prints the same. Needs pandas and SciPy.
"""

import argparse

import numpy as np
import pandas as pd
from scaling import holm, interval
from scipy import stats

NAMES = {"swarm.case": "case", "swarm.robots": "robots", "swarm.messages.topology": "topology", "swarm.messages.migration": "migration", "swarm.control": "control"}
PLACE = ["case", "robots", "topology", "migration", "control", "seed"]
KEPT = [*PLACE, "rate", "second_rate", "late_right", "takeover_min"]
TOPOLOGIES = ["encounters", "all", "ring", "torus"]
# Food where the light stays, and from when it moves.
FOOD = {"over": "rate", "opposite-then-over": "second_rate"}
# Minutes, of which each is an interval.
MINUTES = 50
MODELS = 1000


def links(topology, robots):
    """Which robots each can hear."""
    if topology == "all":
        return ~np.eye(robots, dtype=bool)
    width = robots
    if topology == "torus":
        width = min(width for width in range(1, robots + 1) if robots % width == 0 and width * width >= robots)
    height = robots // width
    linked = np.zeros((robots, robots), dtype=bool)
    for robot in range(robots):
        row, column = divmod(robot, width)
        for step in [-1, 1]:
            linked[robot, row * width + (column + step) % width] = True
            linked[robot, (row + step) % height * width + column] = True
    np.fill_diagonal(linked, False)
    return linked


def takeovers(topology, robots, migration, is_chance, seed=1):
    """Takeover times of swarms in which only lineages move."""
    random = np.random.default_rng(seed)
    linked, rows = links(topology, robots), np.arange(MODELS)[:, None]
    founders = np.broadcast_to(np.arange(robots), (MODELS, robots))
    before, now = founders, founders
    times = np.full(MODELS, MINUTES)
    for minute in range(1, MINUTES):
        fitness = random.random((MODELS, robots)) if is_chance else before
        heard = linked & (random.random((MODELS, robots, robots)) < migration) | np.eye(robots, dtype=bool)
        best = np.where(heard, fitness[:, None, :], -1).argmax(axis=2)
        # Credit is matched: a simulator's fitness is that of the minute after, and its copy is there in the next but one.
        before, now = now, before[rows, best]
        is_one = (now == now[:, :1]).all(axis=1)
        times = np.where(is_one & (times == MINUTES), minute, times)
    return times


def median(times):
    """A median, or that more than half of the times are longer than the runs."""
    return f"{np.median(times):g}" if np.median(times) < MINUTES else f"over {MINUTES}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table")
    parser.add_argument("--keep")
    asked = parser.parse_args()
    runs = pd.read_csv(asked.table).rename(columns=NAMES)[KEPT]
    if asked.keep:
        runs.sort_values(PLACE).to_csv(asked.keep, index=False)
    wide = runs.set_index(PLACE).sort_index().unstack("control")
    counts, migrations = sorted(set(runs.robots)), sorted(set(runs.migration), reverse=True)
    for case, figure in FOOD.items():
        print(f"| {case}: robots | links | rate | food, items a robot-minute | more than with food shuffled | right simulators |\n|---|---|---|---|---|---|")
        for robots in counts:
            for topology in TOPOLOGIES:
                for migration in migrations:
                    own = wide.loc[case, robots, topology, migration]
                    food = own[figure]
                    added = interval(food["evolved"] - food["fitness-shuffled"])
                    print(f"| {robots} | {topology} | {migration:g} | {interval(food['evolved'])} | {added} | {own['late_right']['evolved'].mean():.2f} |")
        print()
    print("| takeover, min: robots | links | rate | evolved | food shuffled | never, % | the best spreads | chance |\n|---|---|---|---|---|---|---|---|")
    for robots in counts:
        for topology in TOPOLOGIES:
            for migration in migrations:
                times = wide.loc["over", robots, topology, migration]["takeover_min"]
                never = 100 * (times["evolved"] >= MINUTES).mean()
                models = ["-", "-"]
                if topology != "encounters":
                    models = [median(takeovers(topology, robots, migration, is_chance)) for is_chance in [False, True]]
                print(f"| {robots} | {topology} | {migration:g} | {median(times['evolved'])} | {median(times['fitness-shuffled'])} | {never:.0f} | {' | '.join(models)} |")

    def contrast(case, figure, one, other):
        values = [wide.loc[(case, *place)][figure]["evolved"] for place in [one, other]]
        words = [f"{robots} {topology}, {migration:g}" for robots, topology, migration in [one, other]]
        return case, figure, " - ".join(words), values[0] - values[1]

    slow, most = min(migrations), max(counts)
    primary = [contrast(case, figure, *pair) for case, figure in FOOD.items()
               for pair in [((most, "all", 1.0), (most, "ring", 1.0)), ((10, "encounters", 1.0), (10, "encounters", slow))]]
    secondary = [contrast("over", "takeover_min", *pair) for robots in counts
                 for pair in [((robots, "ring", 1.0), (robots, "all", 1.0)), ((robots, "all", 0.1), (robots, "all", 1.0))]]
    for name, contrasts in [("primary", primary), ("secondary", secondary)]:
        # Differences that are all the same have no p.
        corrected = holm([stats.ttest_1samp(own, 0).pvalue if own.std() > 0 else 1.0 for *_, own in contrasts])
        print(f"\n| {name} contrast | case | figure | difference | p after Holm | outcome |\n|---|---|---|---|---|---|")
        for (case, figure, words, own), p in zip(contrasts, corrected, strict=True):
            outcome = "undecided" if p >= 0.05 else "holds" if own.mean() > 0 else "opposed"
            print(f"| {words} | {case} | {figure} | {interval(own)} | {p:.2g} | {outcome} |")


if __name__ == "__main__":
    main()
