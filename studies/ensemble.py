"""Judges an ensemble of realities for the 1995 study: python studies/ensemble.py ensemble/results.csv

Prints the share of realities in which each statement of studies/preregistration-1995-ensemble.md is true, for all realities and for those that
agree with the paper, and the regressions of the gap on the severities of the nine differences. Needs pandas, NumPy and statsmodels.
"""

import itertools
import sys

import numpy as np
import pandas as pd
import statsmodels.api as sm
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import proportion_confint

from recompute import CONDITIONS, REPEATABILITY, effect

DIFFERENCES = ["geometry", "reflectivity", "illumination", "read_noise", "latency", "motor_lag", "wheels", "arcs", "slip"]
LEVEL = 0.05


def read(path):
    """The runs, with names for their noise, and the index of their reality."""
    runs = pd.read_csv(path)
    columns = {f"reality.differences.{name}": name for name in DIFFERENCES}
    runs = runs.rename(columns={**columns, "robot.collision": "rule", "reality.robot": "robot"})
    sensor, walk = runs["noise.sensor"] != "[0.0, 0.0]", runs["noise.walk_range_mm"] != 0
    runs["noise"] = np.select([sensor & ~walk, walk & ~sensor, ~sensor & ~walk], ["sensor", "conservative", "none"], "both")
    assert (runs.noise != "both").all(), "a run has both kinds of noise"
    runs["reality"] = runs.groupby(DIFFERENCES, sort=False).ngroup()
    return runs


def figures(runs):
    """A row for each rule and reality; columns for each figure and noise."""
    keys = ["rule", "reality", "noise"]
    runs = runs.assign(
        gap=runs.simulated - runs.real,
        true_gap=runs.quiet - runs.real,
        fall=runs.simulated_peak - runs.real_peak,
        on=runs["last"] - runs.real,
        path=runs.path_gap_mm,
        repeat=runs.path_repeat_mm,
    )
    means = runs.groupby(keys)[["simulated", "real", "gap", "true_gap", "fall", "on", "path", "repeat"]].mean()
    d = runs.groupby([*keys, "robot"])[["simulated", "simulated_deviation", "real", "real_deviation"]].apply(effect)
    wide = means.assign(d=d.groupby(keys).mean()).unstack("noise")
    assert wide.notna().all().all(), "a condition is missing"
    return wide


def statements(of):
    """Which statements are true in which reality."""
    of = {noise: of.xs(noise, axis=1, level="noise") for noise in CONDITIONS}
    none, sensor, conservative = (of[noise] for noise in CONDITIONS)
    order = [sensor.gap > none.gap, none.gap > conservative.gap]
    return pd.DataFrame({
        "sensor > none": order[0],
        "none > conservative": order[1],
        "order": order[0] & order[1],
        "conservative smallest": (conservative.d.abs() < none.d.abs()) & (conservative.d.abs() < sensor.d.abs()),
        "true gap": none.true_gap > conservative.true_gap,
        "peak": sensor.fall < none.fall,
        "simulated": (conservative.simulated < none.simulated) & (conservative.simulated < sensor.simulated),
        "real": (conservative.real > none.real) & (conservative.real > sensor.real),
        "on": (none.on > 0) & (sensor.on > 0) & (conservative.on > 0),
        "recovery": none.on > sensor.on,
        "paths": (conservative.path < none.path / 2) & (conservative.path < sensor.path / 2),
    })


def shares(true):
    """The share of each statement, with its interval and outcome."""
    count, of = true.sum(), len(true)
    low, high = proportion_confint(count, of, method="wilson")
    outcome = np.select([low > 0.5, high < 0.5], ["holds generally", "refuted generally"], "depends")
    return pd.DataFrame({"share": count / of, "low": low, "high": high, "outcome": outcome})


def surface(severities, gaps):
    """The regressions of all gaps: coefficients, R squared, and whether differences act together."""
    centred = severities - 1
    products = {f"{a} {b}": centred[a] * centred[b] for a, b in itertools.combinations(DIFFERENCES, 2)}
    rows, whole = [], []
    for name, gap in gaps.items():
        alone = sm.OLS(gap, sm.add_constant(centred)).fit()
        together = sm.OLS(gap, sm.add_constant(centred.assign(**products))).fit()
        whole.append((*name, alone.params["const"], alone.rsquared, together.compare_f_test(alone)[1]))
        interval = alone.conf_int()
        rows += [(*name, of, alone.params[of], *interval.loc[of], alone.pvalues[of]) for of in DIFFERENCES]
    rows = pd.DataFrame(rows, columns=["rule", "gap", "difference", "per severity", "low", "high", "p"])
    whole = pd.DataFrame(whole, columns=["rule", "gap", "mean", "r squared", "p together"])
    rows["corrected"] = rows.groupby("rule").p.transform(lambda p: multipletests(p, method="holm")[1])
    rows["makes the gap"] = np.where((rows.corrected < LEVEL) & (rows["per severity"] > 0), "yes", "no")
    whole["corrected"] = multipletests(whole["p together"], method="holm")[1]
    return rows, whole


def main(path):
    runs = read(path)
    wide = figures(runs)
    severities = runs.groupby("reality")[DIFFERENCES].first()
    slide = wide.loc["slide"]
    agree = slide["repeat", "none"] <= REPEATABILITY * slide["path", "none"]
    print(f"{len(severities)} realities, {agree.sum()} of which agree with the paper; {len(runs)} runs")
    gaps = {}
    for rule in wide.index.unique("rule"):
        of = wide.loc[rule]
        for name, own in [("all", of), ("that agree", of[agree])]:
            if len(own):
                print(f"\n{rule}, {len(own)} realities, {name}\n{shares(statements(own)).round(3).to_string()}")
        gaps[rule, "Q - R, none"] = of["true_gap", "none"]
        gaps |= {(rule, f"S - R, {noise}"): of["gap", noise] for noise in CONDITIONS}
    if len(severities) > 1 + len(DIFFERENCES) * (1 + len(DIFFERENCES)) // 2:
        rows, whole = surface(severities, gaps)
        print(f"\n{rows.round(4).to_string(index=False)}\n\n{whole.round(4).to_string(index=False)}")


if __name__ == "__main__":
    main(sys.argv[1])
