"""How often five runs of one robot show what 30 robots did: python chances.py [slide/results.csv]

Of each robot's eight runs of three conditions all sets of five run numbers are judged as `oneiro reproduce miglino1995` judges its
five: each contrast by the 95 % interval of its mean over run numbers, each claim by its worst contrast. It prints the table of
studies/miglino1995/README.md, and fails if experiments/miglino1995/planned.toml, made by the program's code, has other figures.
"""

import csv
import itertools
import pathlib
import sys
import tomllib
from collections import Counter, defaultdict
from statistics import mean, stdev

# Student's t of 95 % with four degrees of freedom.
T = 2.7764451051977987
FEW = 5
MARGIN = 25.0
NONE, SENSOR, CONSERVATIVE = range(3)


def gap(run):
    return run["simulated"] - run["real"]


def fall(run):
    return run["simulated_peak"] - run["real_peak"]


def on(run):
    return run["last"] - run["real"]


def path(trio, other):
    return trio[other]["path_gap_mm"] / 2 - trio[CONSERVATIVE]["path_gap_mm"]


# Contrasts of each claim: a figure that should be above 0, or, where it says so, within the margin of 0.
CLAIMS = {
    "C3": [
        ("gap sensor - none", lambda t: gap(t[SENSOR]) - gap(t[NONE]), False),
        ("gap none - conservative", lambda t: gap(t[NONE]) - gap(t[CONSERVATIVE]), False),
        ("gap conservative = 0", lambda t: gap(t[CONSERVATIVE]), True),
    ],
    "C4": [
        ("gap sensor - none", lambda t: gap(t[SENSOR]) - gap(t[NONE]), False),
        ("peak fall none - sensor", lambda t: fall(t[NONE]) - fall(t[SENSOR]), False),
    ],
    "C5": [
        ("simulated none - conservative", lambda t: t[NONE]["simulated"] - t[CONSERVATIVE]["simulated"], False),
        ("simulated sensor - conservative", lambda t: t[SENSOR]["simulated"] - t[CONSERVATIVE]["simulated"], False),
        ("real conservative - none", lambda t: t[CONSERVATIVE]["real"] - t[NONE]["real"], False),
        ("real conservative - sensor", lambda t: t[CONSERVATIVE]["real"] - t[SENSOR]["real"], False),
    ],
    "C6": [
        ("on none", lambda t: on(t[NONE]), False),
        ("on sensor", lambda t: on(t[SENSOR]), False),
        ("on conservative", lambda t: on(t[CONSERVATIVE]), False),
    ],
    "C7": [("on none - sensor", lambda t: on(t[NONE]) - on(t[SENSOR]), False)],
    "C8": [
        ("path none / 2 - conservative", lambda t: path(t, NONE), False),
        ("path sensor / 2 - conservative", lambda t: path(t, SENSOR), False),
    ],
    "C13": [
        ("25 - peak fall none", lambda t: MARGIN - fall(t[NONE]), False),
        ("25 - peak fall sensor", lambda t: MARGIN - fall(t[SENSOR]), False),
        ("25 - peak fall conservative", lambda t: MARGIN - fall(t[CONSERVATIVE]), False),
    ],
}
WORST = ["holds", "undecided", "opposed"]


def outcome(values, is_equivalence):
    reach = T * stdev(values) / len(values) ** 0.5
    low, high = mean(values) - reach, mean(values) + reach
    start, end = (-MARGIN, MARGIN) if is_equivalence else (0.0, float("inf"))
    if low > start and high < end:
        return "holds"
    return "opposed" if high < start or low > end else "undecided"


def robots(table):
    """The runs of each robot: a trio of conditions for each seed."""
    runs = defaultdict(dict)
    with open(table, newline="") as file:
        for row in csv.DictReader(file):
            condition = SENSOR if row["noise.sensor"] != "[0.0, 0.0]" else CONSERVATIVE if row["noise.walk_range_mm"] != "0.0" else NONE
            names = ["simulated", "simulated_peak", "real", "real_peak", "last", "path_gap_mm"]
            trio = runs[row["reality.robot"]].setdefault(int(row["seed"]), [None] * 3)
            trio[condition] = {name: float(row[name]) for name in names}
    return [list(trios.values()) for trios in runs.values()]


def row(claim, name, robots, shares):
    return " ".join(["|", claim, "|", name, "|", robots, *(f"| {100 * shares[word]:.1f} %" for word in WORST), "|"]).replace("|  |", "| |")


def main():
    beside = pathlib.Path(__file__).parent / "slide" / "results.csv"
    sets = [five for trios in robots(sys.argv[1] if len(sys.argv) > 1 else beside) for five in itertools.combinations(trios, FEW)]
    planned = tomllib.loads((pathlib.Path(__file__).parents[3] / "experiments/miglino1995/planned.toml").read_text())
    of_claims = {claim["id"]: claim for claim in planned["claims"]}
    of_contrasts = {contrast["name"]: contrast for contrast in planned["contrasts"]}
    differ = []
    for claim, contrasts in CLAIMS.items():
        outcomes = [[outcome([of(trio) for trio in five], margin) for _, of, margin in contrasts] for five in sets]
        worst = Counter(max(all_of, key=WORST.index) for all_of in outcomes)
        shares = {word: worst[word] / len(sets) for word in WORST}
        differ += [claim for word in WORST if abs(shares[word] - of_claims[claim][word]) > 1e-6]
        print(row(claim, "", of_claims[claim]["verdict"], shares))
        for (name, *_), of_set in zip(contrasts, zip(*outcomes)):
            counts = Counter(of_set)
            shares = {word: counts[word] / len(sets) for word in WORST}
            contrast = of_contrasts[name]
            differ += [name] if abs(shares[contrast["outcome"]] - contrast["chance"]) > 1e-6 else []
            print(row("", name, contrast["outcome"], shares))
    if differ:
        sys.exit(f"experiments/miglino1995/planned.toml has other figures of {', '.join(differ)}")


if __name__ == "__main__":
    main()
