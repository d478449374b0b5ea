"""Judges the 2014 study with more robots: python studies/scaling.py scaling/results.csv range/results.csv

Prints the tables of studies/odowd2014/README.md: the means of each swarm, what evolution adds to its null, and the slopes of
studies/preregistration-2014-scaling.md. With --keep FILE it writes what it takes of the sweeps' tables to a file, and FILE alone prints the
same. Needs pandas and SciPy.
"""

import argparse

import numpy as np
import pandas as pd
from scipy import stats

KEPT = ["arena", "robots", "range_mm", "control", "seed", "rate", "late_right", "matched_min"]
FIGURES = {"rate": ("food, items a robot-minute", "ratio, %"), "matched_min": ("time to a match, min", "difference"), "late_right": ("right simulators", "difference")}
# Radius of the paper's arena, mm.
RADIUS = 600.0
# Range of communication of the paper, mm.
RANGE = 250.0


def read(paths, keep=None):
    runs = pd.concat([pd.read_csv(path) for path in paths], ignore_index=True)
    if "arena" not in runs:
        runs = runs.rename(columns={"swarm.robots": "robots", "swarm.messages.range_mm": "range_mm", "swarm.control": "control"})
        at_density = np.isclose(runs["swarm.arena.radius_mm"], RADIUS * np.sqrt(runs.robots / 10))
        # Ten robots in the paper's arena belong to both.
        runs["arena"] = np.where(at_density, np.where(runs.robots == 10, "both", "grows"), "paper's")
    runs = runs[KEPT].sort_values(KEPT[:5])
    if keep:
        runs.to_csv(keep, index=False)
    both = runs[runs.arena == "both"]
    return pd.concat([runs[runs.arena != "both"], both.assign(arena="grows"), both[both.range_mm == RANGE].assign(arena="paper's")])


def interval(values):
    """The mean with its 95 % interval, by Student's t."""
    margin = stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)
    return f"{values.mean():.2f} ({values.mean() - margin:.2f} to {values.mean() + margin:.2f})"


def holm(p):
    """p values corrected by Holm."""
    order, corrected = np.argsort(p), np.empty(len(p))
    corrected[order] = np.minimum(np.maximum.accumulate([(len(p) - rank) * p[at] for rank, at in enumerate(order)]), 1)
    return corrected


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="+")
    parser.add_argument("--keep")
    asked = parser.parse_args()
    wide = read(asked.tables, asked.keep).pivot(index=["arena", "range_mm", "robots", "seed"], columns="control")
    # Each robot's food depends on the arena far more than on what evolves, so it is compared by its ratio: 100 times the logarithm.
    wide["rate"] = wide["rate"].where(wide["rate"] > 0)
    gains = {figure: wide[figure]["evolved"] - wide[figure]["fitness-shuffled"] for figure in FIGURES}
    gains["rate"] = 100 * np.log(wide["rate"]["evolved"] / wide["rate"]["fitness-shuffled"])
    assert not gains["rate"].isna().any(), "a run brought nothing"

    for figure, (words, added) in FIGURES.items():
        print(f"| arena | range, mm | robots | {words}, evolved | food shuffled | {added} (95 %) |")
        print("|---|---|---|---|---|---|")
        for key, own in wide[figure].groupby(level=[0, 1, 2]):
            arena, reach, robots = key
            means = " | ".join(f"{own[control].mean():.2f}" for control in ["evolved", "fitness-shuffled"])
            print(f"| {arena} | {reach:g} | {robots} | {means} | {interval(gains[figure].loc[key])} |")
        print()

    # What evolution adds by each doubling of the robots; then whether a range matters more to 40 robots than to 10: of each seed,
    # the gain at 500 mm minus that at 100 mm. The first two are the primary family.
    rows = []
    for arena in ["grows", "paper's"]:
        for figure in ["rate", "matched_min"]:
            own = gains[figure].loc[arena, RANGE]
            line = stats.linregress(np.log2(own.index.get_level_values("robots")), own)
            rows.append((f"robots, arena {arena}", figure, line.slope, line.stderr, len(own) - 2))
    for figure in ["rate", "matched_min"]:
        own = gains[figure].loc["grows"]
        by_range = own.loc[500.0] - own.loc[100.0]
        larger = by_range.loc[40] - by_range.loc[10]
        rows.append(("range, 40 robots - 10", figure, larger.mean(), stats.sem(larger), len(larger) - 1))
    print("| what | figure | estimate | 95 % interval | p | corrected p | outcome |")
    print("|---|---|---|---|---|---|---|")
    for family in [rows[:2], rows[2:]]:
        p = [2 * stats.t.sf(abs(estimate / error), df) for _, _, estimate, error, df in family]
        for (what, figure, estimate, error, df), p, corrected in zip(family, p, holm(p)):
            margin = stats.t.ppf(0.975, df) * error
            # More food, and less time.
            sign = 1 if figure == "rate" else -1
            outcome = "undecided" if corrected >= 0.05 else "holds" if sign * estimate > 0 else "opposed"
            print(f"| {what} | {figure} | {estimate:.3f} | {estimate - margin:.3f} to {estimate + margin:.3f} | {p:.3g} | {corrected:.3g} | {outcome} |")


if __name__ == "__main__":
    main()
