"""Judges the 1995 study with other kinds of noise: python studies/noise.py paper/results.csv covering/results.csv without-delay/results.csv

Prints the tables of studies/miglino1995/README.md: the means of each condition, and the contrasts of studies/preregistration-1995-noise.md, judged
as recompute.py judges those of the second edition. With --keep FILE it writes what it takes of the sweeps' tables to a file, and
FILE alone prints the same. Needs pandas, SciPy and statsmodels.
"""

import argparse

import pandas as pd

from recompute import FAILED_BELOW, KEY, MARGIN, effect, family, half, nested, nested_by_scipy, of_means

NONE = float("nan")
NAMES = ["none", "sensor", "conservative", "envelope", "episode"]
DELAY = ["envelope", "episode"]
DROP = "without delay"
KEPT = ["rule", "noise", *KEY, "simulated", "simulated_peak", "simulated_deviation", "quiet", "real", "real_deviation", "last"]


def noise(run):
    """The name of a run's noise, of a table that may lack the keys of others. Delay is not swept, so no column has it."""
    drawn = run.get("noise.drawn")
    if pd.notna(drawn):
        name = {"cycle": "envelope", "life": "episode"}[drawn]
        return f"{name} {DROP}" if run["table"] == 2 else name
    if run["noise.walk_range_mm"] > 0:
        return "conservative"
    return "sensor" if run["noise.sensor"] != "[0.0, 0.0]" else "none"


def read(paths, keep=None):
    runs = pd.concat([pd.read_csv(path).assign(table=table) for table, path in enumerate(paths)], ignore_index=True)
    if "noise" not in runs:
        assert len(paths) == 3, "give the tables of paper.toml, covering.toml and without-delay.toml, in this order"
        runs = runs.rename(columns={"robot.collision": "rule", "reality.robot": "robot"})
        runs["noise"] = runs.apply(noise, axis=1)
    runs = runs[KEPT]
    if keep:
        runs.to_csv(keep, index=False)
    runs = runs.copy()
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
    table["changed"] = sum(
        (kept(lambda values, robot=robot: values.drop(robot, level="robot")) != table.outcome).astype(int) for robot in robots
    )
    table["first_half"] = kept(lambda values: half(values, False))
    table["second_half"] = kept(lambda values: half(values, True))
    return table


def shown(row):
    """A contrast as studies/miglino1995/README.md has it: bold if it holds, slanted if it is opposed, with a star if the outcome is not firm."""
    low, high = sorted([row.low, row.high])
    text = f"{row.estimate:.0f} ({low:.0f} to {high:.0f})".replace("-0 ", "0 ").replace("-0)", "0)")
    text = {"holds": f"**{text}**", "opposed": f"*{text}*"}.get(row.outcome, text)
    firm = row.changed == 0 and row.first_half == row.second_half == row.outcome
    return text if firm else text + "\\*"


def cells(runs):
    """One line for each rule and noise: shares of failed runs, means over runs with standard errors over robots, and d."""
    d = runs.groupby(["rule", "noise", "robot"])[runs.columns].apply(effect)
    print("| rule | noise | runs that fail | S | Q | R (s.e.) | L (s.e.) | d |\n|---|---|---|---|---|---|---|---|")
    for rule in ["slide", "undo"]:
        for noise in runs.noise.unique():
            own = runs[(runs.rule == rule) & (runs.noise == noise)]
            if own.empty:
                continue
            error = lambda figure: of_means(own.set_index("robot")[figure])[1]
            failed = f"{100 * own.failed.mean():.0f} %" if own.failed.any() else "0"
            figures = [f"{own.simulated.mean():.0f}", f"{own.quiet.mean():.0f}"]
            figures += [f"{own[figure].mean():.0f} ({error(figure):.0f})" for figure in ["real", "last"]]
            print("| " + " | ".join([f"`{rule}`", noise, failed, *figures, f"{d[rule, noise].mean():.2f}"]) + " |")


def main(arguments):
    runs = read(arguments.tables, arguments.keep)
    assert not runs.duplicated(["rule", "noise", *KEY]).any(), "a run is there twice"
    cells(runs)
    tables = {}
    for rule in ["slide", "undo"]:
        wide = runs[runs.rule == rule].set_index([*KEY, "noise"])[["gap", "true_gap", "real", "last"]].unstack("noise").sort_index()
        assert wide.notna().all().all(), f"a condition of {rule} is missing"
        for name, contrasts in families(wide, rule):
            tables.setdefault(name, {})[rule] = judged(contrasts)
    for name, of_rule in tables.items():
        print(f"\n| {name} | " + " | ".join(f"`{rule}`" for rule in of_rule) + " |\n|---|" + "---|" * len(of_rule))
        for place, contrast in enumerate(of_rule["slide"].contrast):
            print(f"| {contrast} | " + " | ".join(shown(table.iloc[place]) for table in of_rule.values()) + " |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="+", help="the tables of the three sweeps in this order, or the file that was kept of them")
    parser.add_argument("--keep", help="where to write what is taken of the tables")
    main(parser.parse_args())
