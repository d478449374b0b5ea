"""Judges the 1995 study with other kinds of noise: python docs/noise.py paper/results.csv covering/results.csv without-delay/results.csv

Prints the means of each condition and the contrasts of docs/preregistration-1995-noise.md, judged as recompute.py judges those of the
second edition. Needs pandas, SciPy and statsmodels.
"""

import sys

import numpy as np
import pandas as pd

from recompute import FAILED_BELOW, KEY, MARGIN, effect, family, half, nested, nested_by_scipy, of_means

NONE = float("nan")
NAMES = ["none", "sensor", "conservative", "envelope", "episode"]
DELAY = ["envelope", "episode"]
DROP = "without delay"


def noise(run):
    """The name of a run's noise, of a table that may lack the keys of others."""
    drawn = run.get("noise.drawn")
    if pd.notna(drawn):
        name = {"cycle": "envelope", "life": "episode"}[drawn]
        return name if run["noise.delay_cycles"] > 0 else f"{name} {DROP}"
    if run["noise.walk_range_mm"] > 0:
        return "conservative"
    return "sensor" if run["noise.sensor"] != "[0.0, 0.0]" else "none"


def read(paths):
    runs = pd.concat([pd.read_csv(path) for path in paths], ignore_index=True)
    runs = runs.rename(columns={"robot.collision": "rule", "reality.robot": "robot"})
    runs["noise"] = runs.apply(noise, axis=1)
    runs["gap"] = runs.simulated - runs.real
    runs["true_gap"] = runs.quiet - runs.real
    runs["failed"] = (runs.simulated_peak < FAILED_BELOW).astype(float)
    return runs


def families(wide, rule):
    """The registered families of a rule: a name, and contrasts with a margin or none, and values."""
    gap, true_gap, real, last = (wide[figure] for figure in ["gap", "true_gap", "real", "last"])
    others, ours = NAMES[1:], NAMES[2:]
    pairs = [(name, "none") for name in others]
    pairs += [("envelope", "conservative"), ("episode", "conservative"), ("episode", "envelope")]
    differences = lambda of, label: [(f"{label}, {one} - {other}", NONE, of[one] - of[other]) for one, other in pairs]
    yield "gap", [
        *[(f"gap, none - {name}", NONE, gap["none"] - gap[name]) for name in others],
        *[(f"gap, {name} = 0", MARGIN, gap[name]) for name in ours],
        *[(f"true gap, none - {name}", NONE, true_gap["none"] - true_gap[name]) for name in ours],
    ]
    yield "fitness at transfer", differences(real, "R")
    yield "fitness after evolving on", differences(last, "L")
    if rule == "slide":
        without = {name: f"{name} {DROP}" for name in DELAY}
        yield "delay", [
            *[(f"gap, {without[name]} - with", NONE, gap[without[name]] - gap[name]) for name in DELAY],
            *[(f"R, {name} with delay - without", NONE, real[name] - real[without[name]]) for name in DELAY],
            *[(f"R, {without[name]} - none", NONE, real[without[name]] - real["none"]) for name in DELAY],
        ]


def judged(contrasts):
    """A family, and how firm each outcome is: without each robot, and by halves of the seeds."""
    columns = [(name, "", margin, values) for name, margin, values in contrasts]
    table = family(columns, nested).drop(columns="claims")
    kept = lambda of: family([(*rest, of(values)) for *rest, values in columns], nested_by_scipy).outcome
    robots = columns[0][3].index.get_level_values("robot").unique()
    table["changed_by_robots"] = sum(
        (kept(lambda values, robot=robot: values.drop(robot, level="robot")) != table.outcome).astype(int) for robot in robots
    )
    table["first_half"] = kept(lambda values: half(values, False))
    table["second_half"] = kept(lambda values: half(values, True))
    return table


def main(paths):
    runs = read(paths)
    assert not runs.duplicated(["rule", "noise", *KEY]).any(), "a run is there twice"
    d = runs.groupby(["rule", "noise", "robot"])[runs.columns].apply(effect)
    means = runs.groupby(["rule", "noise"])[["failed", "simulated", "quiet", "real", "last", "gap", "true_gap"]].mean()
    errors = runs.groupby(["rule", "noise"]).apply(
        lambda of: pd.Series({f"{name}_se": of_means(of.set_index("robot")[name])[1] for name in ["real", "last"]})
    )
    cells = means.join(errors).assign(runs=runs.groupby(["rule", "noise"]).size(), d=d.groupby(["rule", "noise"]).mean())
    print(cells.round(2).to_string())
    figures = ["gap", "true_gap", "real", "last"]
    for rule, own in runs.groupby("rule"):
        wide = own.set_index([*KEY, "noise"])[figures].unstack("noise").sort_index()
        assert wide.notna().all().all(), f"a condition of {rule} is missing"
        for name, contrasts in families(wide, rule):
            print(f"\n{rule}: {name}\n{judged(contrasts).round(4).to_string(index=False)}")


if __name__ == "__main__":
    main(sys.argv[1:])
