"""Judges the 1995 study in Aseba's simulator: python studies/elsewhere.py studies/miglino1995/elsewhere/lives.csv (or epuck.csv)

Prints the means of each condition and the contrasts of studies/preregistration-1995-elsewhere.md. Needs pandas, SciPy and statsmodels.
"""

import sys

import numpy as np
import pandas as pd
from scipy import stats

from recompute import family

MARGIN = 25.0
NONE = float("nan")


def read(path):
    """Columns for each place and figure, and rows for each rule, noise and seed."""
    lives = pd.read_csv(path)
    keys = ["rule", "noise", "seed"]
    carried = lives[lives["where"] != "on"].pivot(index=keys, columns="where", values=["mean", "sd", "late"])
    on = lives[lives["where"] == "on"].pivot(index=keys, columns="generation", values="mean")
    return carried, on


def fit(values):
    return values.mean(), stats.sem(values), len(values) - 1


def contrasts(means, conservative):
    """Contrasts of one rule: a name, a claim, a margin and a value for each seed."""
    figures = pd.DataFrame({
        "gap": means["simulated"] - means["real"],
        "true gap": means["quiet"] - means["real"],
        "S": means["simulated"],
        "R": means["real"],
    }).unstack("noise")

    def of(figure, noise):
        return figures[figure][noise]

    rows = [("gap, sensor - none", "C3", NONE, of("gap", "sensor") - of("gap", "none"))] if conservative == "conservative" else []
    return [
        *rows,
        (f"gap, none - {conservative}", "C3", NONE, of("gap", "none") - of("gap", conservative)),
        (f"gap, {conservative} = 0", "C3", MARGIN, of("gap", conservative)),
        (f"true gap, none - {conservative}", "-", NONE, of("true gap", "none") - of("true gap", conservative)),
        (f"S, none - {conservative}", "C5", NONE, of("S", "none") - of("S", conservative)),
        (f"R, {conservative} - none", "C5", NONE, of("R", conservative) - of("R", "none")),
        (f"R, {conservative} - sensor", "C5", NONE, of("R", conservative) - of("R", "sensor")),
    ]


def judged(columns):
    """A family, with the number of seeds without any one of which the outcome is another."""
    table = family(columns, fit)
    changed = np.zeros(len(table), dtype=int)
    for seed in columns[0][3].index:
        without = family([(*rest, values.drop(seed)) for *rest, values in columns], fit)
        changed += (without.outcome != table.outcome).to_numpy()
    return table.assign(changed=changed)


def main(path):
    carried, on = read(path)
    means = carried["mean"]
    pooled = np.sqrt((carried["sd"]["simulated"] ** 2 + carried["sd"]["real"] ** 2) / 2)
    cells = means.assign(d=(means["simulated"] - means["real"]) / pooled, late=carried["late"]["real"])
    print(cells.groupby(["rule", "noise"]).agg(["mean", "sem"]).round(3).to_string())
    for rule in means.index.unique("rule"):
        of_rule = means.loc[rule]
        gap = (of_rule["simulated"] - of_rule["real"]).xs("none", level="noise")
        print(f"\n{rule}: is there a gap without noise?\n", judged([("gap, none = 0", "-", MARGIN, gap)]).to_string(index=False))
        for conservative in [noise for noise in ["conservative", "conservative-30"] if noise in of_rule.index.get_level_values("noise")]:
            print(f"\n{rule}, {conservative}\n", judged(contrasts(of_rule, conservative)).to_string(index=False))
    last = on.columns.max()
    gains = (on[last] - on[0]).loc["slide"]
    columns = [(f"L - R, {noise}", "C6", NONE, gains.xs(noise)) for noise in ["none", "sensor", "conservative"]]
    print(f"\nevolved on, {last} generations\n", on.groupby(["rule", "noise"]).mean().round(1).to_string())
    print(judged(columns).to_string(index=False))


if __name__ == "__main__":
    main(sys.argv[1])
