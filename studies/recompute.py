"""Judges the second and third editions of the studies again, from the tables of their sweeps, with pandas, SciPy and statsmodels alone.

    pip install pandas scipy statsmodels
    oneiro reproduce miglino1995 --sweeps collision-1,collision-1.75 --out second
    python studies/recompute.py --judged second collision-1 collision-1.75
    oneiro reproduce odowd2014 --sweeps random,scale-0.2 --out second-2014
    python studies/recompute.py --judged second-2014 random scale-0.2

It prints each contrast, and compares every figure and every outcome with those that the program wrote to the judged directory. What is
judged, and how, stands in studies/preregistration-1995-second.md, -1995-third.md and -2014-second.md. The mixed models of 1995 are
fitted by statsmodels' MixedLM, not by the program's closed form. Without single robots and by halves, where only outcomes count, SciPy
minimises the same restricted likelihood, which is faster; it must agree with MixedLM on all runs. Ends with exit code 1 if anything
differs.
"""

import argparse
import gc
import pathlib
import sys
import warnings

import numpy as np
import pandas as pd
import statsmodels.api as sm
from scipy import optimize, stats
from statsmodels.stats.multitest import multipletests

# multipletests collects garbage each time that it is called: what was imported is left out of that, which takes a third of the time.
gc.freeze()

FAILED_BELOW = 100.0
MARGIN = 25.0
ALPHA = 0.05
# Targets of the calibration: d without noise, and how far two real lives may part.
D = 0.81
REPEATABILITY = 0.5
INDIVIDUALS = 100
CONDITIONS = ["none", "sensor", "conservative"]
KEY = ["robot", "seed"]

# Names, claims, whether the claim is that there is no difference, and the figure of a run number's three conditions.
OF_CONDITIONS = [
    ("gap sensor - none", "C3 C4", False, lambda w: w.gap["sensor"] - w.gap["none"]),
    ("gap none - conservative", "C3", False, lambda w: w.gap["none"] - w.gap["conservative"]),
    ("gap conservative = 0", "C3", True, lambda w: w.gap["conservative"]),
    ("true gap none - conservative", "", False, lambda w: w.true_gap["none"] - w.true_gap["conservative"]),
    ("peak fall none - sensor", "C4", False, lambda w: w.peak_fall["none"] - w.peak_fall["sensor"]),
    ("simulated none - conservative", "C5", False, lambda w: w.simulated["none"] - w.simulated["conservative"]),
    ("simulated sensor - conservative", "C5", False, lambda w: w.simulated["sensor"] - w.simulated["conservative"]),
    ("real conservative - none", "C5", False, lambda w: w.real["conservative"] - w.real["none"]),
    ("real conservative - sensor", "C5", False, lambda w: w.real["conservative"] - w.real["sensor"]),
    ("on none", "C6", False, lambda w: w.on["none"]),
    ("on sensor", "C6", False, lambda w: w.on["sensor"]),
    ("on conservative", "C6", False, lambda w: w.on["conservative"]),
    ("on none - sensor", "C7", False, lambda w: w.on["none"] - w.on["sensor"]),
    ("path none / 2 - conservative", "C8", False, lambda w: w.path["none"] / 2 - w.path["conservative"]),
    ("path sensor / 2 - conservative", "C8", False, lambda w: w.path["sensor"] / 2 - w.path["conservative"]),
    ("failed conservative - none", "", False, lambda w: w.failed["conservative"] - w.failed["none"]),
]
OF_RULES = [
    ("failed none", lambda u, s: u.failed["none"] - s.failed["none"]),
    ("failed sensor", lambda u, s: u.failed["sensor"] - s.failed["sensor"]),
    ("failed conservative", lambda u, s: u.failed["conservative"] - s.failed["conservative"]),
    ("true gap none - conservative", lambda u, s: OF_CONDITIONS[3][3](s) - OF_CONDITIONS[3][3](u)),
    ("gap sensor - none", lambda u, s: OF_CONDITIONS[0][3](s) - OF_CONDITIONS[0][3](u)),
    ("gap none - conservative", lambda u, s: OF_CONDITIONS[1][3](s) - OF_CONDITIONS[1][3](u)),
]
# What a sweep may vary beside the collision rule: of a reading of equation 1 and the one that earlier editions have, and of a controller and the one that does not learn.
VARIED = ["task.speed", "task.difference", "controller.layers.0.kind"]
BASES = ["unsigned root", "elman"]
OF_READINGS = [
    ("gap none", lambda e, o: o.gap["none"] - e.gap["none"]),
    ("gap conservative", lambda e, o: o.gap["conservative"] - e.gap["conservative"]),
    ("gap sensor - none", lambda e, o: OF_CONDITIONS[0][3](o) - OF_CONDITIONS[0][3](e)),
    ("gap none - conservative", lambda e, o: OF_CONDITIONS[1][3](o) - OF_CONDITIONS[1][3](e)),
    ("real conservative - none", lambda e, o: OF_CONDITIONS[7][3](o) - OF_CONDITIONS[7][3](e)),
    ("path repeat none - conservative", lambda e, o: (o.path_repeat["none"] - o.path_repeat["conservative"]) - (e.path_repeat["none"] - e.path_repeat["conservative"])),
]


def read(tables):
    runs = pd.concat(tables, ignore_index=True)
    runs = runs.rename(columns={"reality.severity": "severity", "robot.collision": "rule", "reality.robot": "robot"})
    if "reality.motion_severity" in runs:
        motion = runs["reality.motion_severity"].map(repr)
        runs["severity"] = np.where(motion == runs.severity, runs.severity, runs.severity + "/" + motion)
    for varied in VARIED:
        if varied in runs:
            runs["rule"] += " " + runs[varied]
    quiet, still = runs["noise.sensor"] == "[0.0, 0.0]", runs["noise.walk_range_mm"] == 0
    assert (quiet | still).all(), "a run has both kinds of noise"
    runs["noise"] = np.select([quiet & still, still], ["none", "sensor"], "conservative")
    runs["gap"] = runs.simulated - runs.real
    runs["true_gap"] = runs.quiet - runs.real
    runs["on"] = runs["last"] - runs.real
    runs["peak_fall"] = runs.simulated_peak - runs.real_peak
    runs["failed"] = (runs.simulated_peak < FAILED_BELOW).astype(float)
    runs["path"] = runs.path_gap_mm
    runs["path_repeat"] = runs.path_repeat_mm
    return runs


def fitted_by(model):
    """The likeliest fit of those that the optimisers find; not all of them get through each likelihood."""
    fits = []
    for method in ["lbfgs", "nm", "powell"]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                fits.append(model.fit(reml=True, method=method, **({"xtol": 1e-12, "ftol": 1e-14} if method != "lbfgs" else {"pgtol": 1e-12})))
            except np.linalg.LinAlgError:
                continue
    return max(fits, key=lambda fit: fit.llf)


def nested_by_scipy(values):
    """As `nested`: the restricted likelihood of the ratio of variances, over robots and over runs, minimised."""
    sizes = values.groupby(level="robot").size().to_numpy()
    means = values.groupby(level="robot").mean().to_numpy()
    within = ((values - values.groupby(level="robot").transform("mean")) ** 2).sum()
    if values.nunique() == 1:
        return values.iloc[0], 0.0, len(sizes) - 1

    def fit(ratio):
        weights = sizes / (1 + sizes * ratio)
        mean = (weights * means).sum() / weights.sum()
        squares = within + (weights * (means - mean) ** 2).sum()
        deviance = (len(values) - 1) * np.log(squares) + np.log1p(sizes * ratio).sum() + np.log(weights.sum())
        return deviance, mean, np.sqrt(squares / (len(values) - 1) / weights.sum())

    found = optimize.minimize_scalar(lambda log: fit(np.exp(log))[0], bounds=(-15, 15), method="bounded", options={"xatol": 1e-9})
    _, mean, error = min(fit(0.0), fit(np.exp(found.x)))
    return mean, error, len(sizes) - 1


def nested(values):
    """The mean of values by robot, its standard error by restricted maximum likelihood, and its degrees of freedom."""
    by_scipy = nested_by_scipy(values)
    fitted = nested_by_statsmodels(values)
    assert np.allclose(by_scipy, fitted, rtol=1e-4, atol=1e-9), f"{fitted} by statsmodels, {by_scipy} by SciPy"
    return fitted


def nested_by_statsmodels(values):
    robots = values.index.get_level_values("robot")
    df = robots.nunique() - 1
    if values.nunique() == 1:
        return values.iloc[0], 0.0, df
    ones = np.ones(len(values))
    means, within = values.groupby(level="robot").mean(), values.groupby(level="robot").var(ddof=1)
    size = len(values) / (df + 1)
    if size * means.var(ddof=1) > within.mean() * (1 + 1e-9):
        # In units of its standard deviation, so that the optimiser's tolerance is that of the figures.
        unit = values.std()
        model = sm.MixedLM(values.to_numpy() / unit, ones, groups=robots.to_numpy())
        fitted = fitted_by(model)
        return fitted.fe_params[0] * unit, fitted.bse_fe[0] * unit, df
    # The estimate lies at its bound: robots do not differ more than their runs, and a common variance is left.
    fitted = sm.OLS(values.to_numpy(), ones).fit()
    return fitted.params[0], fitted.bse[0], df


def of_means(values):
    means = values.groupby(level="robot").mean()
    if len(means) < 2:
        return np.nan, np.nan, 1
    return means.mean(), stats.sem(means), len(means) - 1


def tested(fit, margin):
    """Estimate, interval and p of a mean above 0 or, with a margin, equivalent to 0."""
    value, error, df = fit
    if not np.isfinite([value, error]).all():
        return np.nan, np.nan, np.nan, 1.0
    reach = stats.t.ppf(1 - ALPHA / 2, df) * error
    if error == 0:
        p = float(value == 0) if np.isnan(margin) else float(abs(value) >= margin)
    elif not np.isnan(margin):
        p = max(stats.t.sf((value + margin) / error, df), stats.t.cdf((value - margin) / error, df))
    else:
        p = 2 * stats.t.sf(abs(value / error), df)
    return value, value - reach, value + reach, p


def outcomes(table, p, level=ALPHA):
    """Outcomes by a p that may be corrected."""
    significant = p < level
    beyond = (table.low > table.margin) | (table.high < -table.margin)
    opposed = np.where(table.margin.notna(), beyond, significant & (table.estimate < 0))
    return np.select([opposed, significant], ["opposed", "holds"], "undecided")


def family(columns, fit):
    """Judges the contrasts of a family: a list of names, claims, the margin of an equivalence or NaN, and values."""
    rows = [(name, claims, margin, *tested(fit(values), margin)) for name, claims, margin, values in columns]
    table = pd.DataFrame(rows, columns=["contrast", "claims", "margin", "estimate", "low", "high", "p"])
    table["p_holm"] = multipletests(table.p, method="holm")[1]
    table["outcome"] = outcomes(table, table.p_holm)
    return table


def by_other_criteria(table):
    """Adds the outcomes of all contrasts that are judged together by criteria next to the registered one."""
    table = table.reset_index(drop=True)
    table["uncorrected"] = outcomes(table, table.p)
    table["level_0.01"] = outcomes(table, table.p_holm, 0.01)
    table["one_family"] = outcomes(table, multipletests(table.p, method="holm")[1])
    return table


def worst(outcomes):
    return next((word for word in ["opposed", "undecided"] if (outcomes == word).any()), "holds")


def half(values, second):
    place = values.groupby(level="robot").cumcount()
    middle = values.groupby(level="robot").transform("size") // 2
    return values[(place >= middle) if second else (place < middle)]


def firm(columns, converged):
    """A family's outcomes, and those by fewer runs."""
    table = family(columns, nested)
    robots = columns[0][3].index.get_level_values("robot").unique()
    kept = lambda of: [(name, claims, margin, of(values)) for name, claims, margin, values in columns]
    changed = np.zeros(len(table), int)
    for robot in robots:
        without = family(kept(lambda values: values.drop(robot, level="robot")), nested_by_scipy)
        changed += (without.outcome != table.outcome).to_numpy()
    table["changed_by_robots"] = changed
    table["first_half"] = family(kept(lambda values: half(values, False)), nested_by_scipy).outcome
    table["second_half"] = family(kept(lambda values: half(values, True)), nested_by_scipy).outcome
    table["converged"] = family(kept(lambda values: values[converged.reindex(values.index)]), of_means).outcome
    same = [table[column] == table.outcome for column in ["first_half", "second_half", "converged"]]
    table["survives"] = np.where((table.changed_by_robots == 0) & np.logical_and.reduce(same), "yes", "no")
    return table


def effect(runs):
    """Cohen's d of all individuals of a robot's runs."""

    def squares(mean, deviation):
        return ((INDIVIDUALS - 1) * deviation**2 + INDIVIDUALS * (mean - mean.mean()) ** 2).sum()

    pooled = squares(runs.simulated, runs.simulated_deviation) + squares(runs.real, runs.real_deviation)
    return (runs.simulated.mean() - runs.real.mean()) / np.sqrt(pooled / (2 * INDIVIDUALS * len(runs) - 2))


def judged(runs):
    contrasts, claims, cells, wide = [], [], [], {}
    for (severity, rule), own in runs.groupby(["severity", "rule"]):
        own = own.set_index([*KEY, "noise"]).sort_index()
        pivot = own[["gap", "true_gap", "peak_fall", "simulated", "real", "on", "path", "path_repeat", "failed"]].unstack("noise")
        assert pivot.notna().all().all(), "a condition is missing"
        wide[severity, rule] = pivot
        columns = [(name, of, MARGIN if equivalence else np.nan, values(pivot)) for name, of, equivalence, values in OF_CONDITIONS]
        table = firm(columns, pivot.failed.sum(axis=1) == 0)
        contrasts.append(table.assign(severity=severity, rule=rule))
        for claim in ["C3", "C4", "C5", "C6", "C7", "C8"]:
            contrasts_of = table.outcome[table.claims.str.split().map(lambda of: claim in of)]
            claims.append((severity, rule, claim, worst(contrasts_of)))
        for noise in CONDITIONS:
            of_noise = own.xs(noise, level="noise")
            d = pd.Series({robot: effect(group) for robot, group in of_noise.groupby(level="robot")})
            means = of_noise[["failed", "simulated", "quiet", "real", "last"]].mean()
            paths = of_noise[["path_gap_mm", "path_repeat_mm"]].mean()
            cells.append((severity, rule, noise, len(of_noise), *means, d.mean(), stats.sem(d), *paths))
    pairs = []
    for severity, cell in wide:
        rule, _, own = cell.partition(" ")
        if rule == "slide":
            pairs.append((severity, cell.replace("slide", "slide - undo"), cell.replace("slide", "undo"), cell, OF_RULES))
        if own not in ["", *BASES]:
            pairs.extend((severity, f"{cell} - {base}", f"{rule} {base}", cell, OF_READINGS) for base in BASES)
    for severity, what, first, second, compared in pairs:
        if (severity, first) in wide:
            first, second = wide[severity, first], wide[severity, second]
            columns = [(name, "", np.nan, values(first, second)) for name, values in compared]
            table = firm(columns, (first.failed.sum(axis=1) + second.failed.sum(axis=1)) == 0)
            contrasts.append(table.assign(severity=severity, rule=what))
    means = ["failed", "simulated", "quiet", "real", "last", "d", "d_error", "path_gap_mm", "path_repeat_mm"]
    return {
        "contrasts": by_other_criteria(pd.concat(contrasts)).drop(columns="margin").set_index(["severity", "rule", "contrast"]),
        "claims": pd.DataFrame(claims, columns=["severity", "rule", "claim", "outcome"]).set_index(["severity", "rule", "claim"]),
        "cells": pd.DataFrame(cells, columns=["severity", "rule", "noise", "runs", *means]).set_index(["severity", "rule", "noise"]),
    }


def calibrated(runs):
    """The pairs of severities of each rule, of which one is taken."""
    runs = runs.rename(columns={"robot.collision": "rule", "reality.severity": "severity", "reality.motion_severity": "motion_severity", "reality.robot": "robot"})
    runs["severity"] = runs.severity.astype(float)
    rows = []
    for key, own in runs.groupby(["rule", "severity", "motion_severity"]):
        robots = [group for _, group in own.groupby("robot")]
        d = pd.Series([effect(group) for group in robots])
        repeats = pd.Series([group.path_repeat_mm.sum() / group.path_gap_mm.sum() for group in robots])
        rows.append((*key, d.mean(), stats.sem(d), repeats.mean(), stats.sem(repeats)))
    columns = ["rule", "severity", "motion_severity", "d", "d_error", "repeatability", "repeatability_error"]
    table = pd.DataFrame(rows, columns=columns)
    far, total = (table.d - D).abs(), table.severity + table.motion_severity
    chosen = []
    for _, own in table.groupby("rule"):
        good = own[own.repeatability + own.repeatability_error <= REPEATABILITY]
        if len(good):
            chosen.append(min(good.index, key=lambda row: (far[row], total[row])))
        else:
            chosen.append(own.repeatability.idxmin())
    table["chosen"] = np.where(table.index.isin(chosen), "yes", "no")
    missed = np.where(far > 2 * table.d_error, "d ", "") + np.where(table.repeatability - REPEATABILITY > 2 * table.repeatability_error, "repeatability", "").astype(object)
    table["missed"] = [words.strip() for words in missed]
    return table.set_index(["rule", "severity", "motion_severity"])


# The 2014 study.
ROBOTS = 10
FACTORS = {
    "threshold": "swarm.robot.phototaxis_threshold",
    "scale": "swarm.simulators.mutation_scale",
    "credit": "swarm.simulators.credit",
    "installed_s": "swarm.clock.installed_s",
}
# The levels of which a factor's family is the difference, the second minus the first.
LEVELS = {"threshold": ("0.0", "0.16"), "credit": ("lagged", "matched"), "installed_s": ("60", "34")}
FOOD, SHARE, S0, BIN = 0.465, 0.15, 0.05, 0.165
NO_LIGHT, OVER, OPPOSITE, AWAY, TOWARDS = "no-light", "over", "opposite", "over-then-opposite", "opposite-then-over"
EVOLVED, NULL, RIGHT, DRAWN = "evolved", "fitness-shuffled", "simulator-right", "simulator-random"


class Combination:
    """The cells of a combination of factors: figures of runs by seed."""

    def __init__(self, runs, random):
        self.random_food = random.set_index("seed").sort_index().food
        self.cells = {cell: own.set_index("seed").sort_index() for cell, own in runs.groupby(["case", "control"])}

    def of(self, case, figure, control=EVOLVED):
        return self.cells[case, control][figure]

    def null(self, case, figure):
        """How much more than under the null, by seed."""
        return self.of(case, figure) - self.of(case, figure, NULL)


def no_margin(name, claims, of):
    return name, claims, np.nan, of


# Names, claims, margins, and groups of runs whose means add up to the estimate.
OF_CELLS = [
    *[no_margin(f"food {case} - random", claims, lambda c, case=case: [c.of(case, "food"), -c.random_food])
      for case, claims in [(OVER, "D1"), (OPPOSITE, "D1 D3"), (AWAY, "D1"), (TOWARDS, "D1")]],
    ("food no-light = random", "D1", FOOD, lambda c: [c.of(NO_LIGHT, "food"), -c.random_food]),
    *[no_margin(f"food {case} - null", claims, lambda c, case=case: [c.null(case, "food")])
      for case, claims in [(OVER, "D1 D2"), (OPPOSITE, "D1 D3"), (AWAY, "D1"), (TOWARDS, "D1")]],
    no_margin("food over - 1.5 random", "D2", lambda c: [c.of(OVER, "food"), -1.5 * c.random_food]),
    no_margin("food 2.5 random - over", "D2", lambda c: [2.5 * c.random_food, -c.of(OVER, "food")]),
    no_margin("food over - opposite", "D3", lambda c: [c.of(OVER, "food"), -c.of(OPPOSITE, "food")]),
    no_margin("right no-light - null", "D4", lambda c: [c.null(NO_LIGHT, "settled_later")]),
    ("late S0 no-light = 0.495", "D4", BIN, lambda c: [c.of(NO_LIGHT, "late_s0") - 0.495]),
    no_margin("spread of G0 no-light - 0.214", "D4", lambda c: [c.of(NO_LIGHT, "late_g0_deviation") - 0.214]),
    no_margin("spread of G1 no-light - 0.214", "D4", lambda c: [c.of(NO_LIGHT, "late_g1_deviation") - 0.214]),
    no_margin("right over - null", "D5", lambda c: [c.null(OVER, "late_right")]),
    no_margin("late G0 over - 0.66", "D5", lambda c: [c.of(OVER, "late_g0") - 0.66]),
    no_margin("0.33 - late G1 over", "D5", lambda c: [0.33 - c.of(OVER, "late_g1")]),
    no_margin("spread of G0 no-light - over", "D5", lambda c: [c.of(NO_LIGHT, "late_g0_deviation"), -c.of(OVER, "late_g0_deviation")]),
    no_margin("spread of G1 no-light - over", "D5", lambda c: [c.of(NO_LIGHT, "late_g1_deviation"), -c.of(OVER, "late_g1_deviation")]),
    ("right opposite = null", "D6", SHARE, lambda c: [c.null(OPPOSITE, "late_right")]),
    ("late S0 opposite = 0.495", "D6", BIN, lambda c: [c.of(OPPOSITE, "late_s0") - 0.495]),
    no_margin("spread of G0 opposite - 0.214", "D6", lambda c: [c.of(OPPOSITE, "late_g0_deviation") - 0.214]),
    no_margin("spread of G1 opposite - 0.214", "D6", lambda c: [c.of(OPPOSITE, "late_g1_deviation") - 0.214]),
    no_margin("right before the move - null", "D7", lambda c: [c.null(AWAY, "before_right")]),
    no_margin("food 0.75 before - after the move", "D7", lambda c: [ROBOTS * (0.75 * c.of(AWAY, "before_rate") - c.of(AWAY, "after_rate"))]),
    no_margin("S0 before - late", "D7", lambda c: [c.of(AWAY, "before_s0") - c.of(AWAY, "late_s0")]),
    no_margin("0.5 - right late", "D7", lambda c: [0.5 - c.of(AWAY, "late_right")]),
    no_margin("food second half over - moved over", "D8", lambda c: [ROBOTS * c.of(OVER, "second_rate"), -ROBOTS * c.of(TOWARDS, "second_rate")]),
    no_margin("right late - before", "D8", lambda c: [c.of(TOWARDS, "late_right") - c.of(TOWARDS, "before_later")]),
    ("first S0 opposite = opposite-then-over", "D9", S0, lambda c: [c.of(OPPOSITE, "first_s0"), -c.of(TOWARDS, "first_s0")]),
    no_margin("food right opposite - random", "D12", lambda c: [c.of(OPPOSITE, "food", RIGHT), -c.random_food]),
    no_margin("food right gain over / 2 - opposite", "D12",
              lambda c: [0.5 * c.of(OVER, "food", RIGHT), -c.of(OPPOSITE, "food", RIGHT), 0.5 * c.random_food]),
    no_margin("area over - 0.5", "D13", lambda c: [c.of(OVER, "chosen_area", DRAWN) - 0.5]),
    no_margin("area opposite - 0.5", "D13", lambda c: [c.of(OPPOSITE, "chosen_area", DRAWN) - 0.5]),
    no_margin("food null opposite - random", "D14", lambda c: [c.of(OPPOSITE, "food", NULL), -c.random_food]),
    ("food opposite = null", "D14", FOOD, lambda c: [c.null(OPPOSITE, "food")]),
    no_margin("right second half over - moved", "D15", lambda c: [c.of(OVER, "second_later"), -c.of(AWAY, "second_later")]),
    no_margin("spread of S0 second half moved - over", "D15", lambda c: [c.of(AWAY, "second_s0_deviation"), -c.of(OVER, "second_s0_deviation")]),
    no_margin("spread of late S0 null - evolved", "D16", lambda c: [-c.null(NO_LIGHT, "late_s0_deviation")]),
    no_margin("food right - drawn over", "D17", lambda c: [c.of(OVER, "food", RIGHT) - c.of(OVER, "food", DRAWN)]),
    no_margin("food right - drawn opposite", "D17", lambda c: [c.of(OPPOSITE, "food", RIGHT) - c.of(OPPOSITE, "food", DRAWN)]),
]
OF_FACTORS = [
    ("food over", lambda c: c.of(OVER, "food")),
    ("food opposite", lambda c: c.of(OPPOSITE, "food")),
    ("food no-light", lambda c: c.of(NO_LIGHT, "food")),
    ("food null opposite", lambda c: c.of(OPPOSITE, "food", NULL)),
    ("right over - null", lambda c: c.null(OVER, "late_right")),
    ("right opposite - null", lambda c: c.null(OPPOSITE, "late_right")),
]
JUDGED = [*(f"D{number}" for number in range(1, 10)), *(f"D{number}" for number in range(12, 18))]


def welch(groups):
    """The sum of means of groups of runs, its standard error, and Satterthwaite's degrees of freedom."""
    parts = np.array([group.var(ddof=1) / len(group) for group in groups])
    below = np.array([len(group) - 1 for group in groups])
    spread = (parts**2 / below).sum()
    return sum(group.mean(skipna=False) for group in groups), np.sqrt(parts.sum()), parts.sum() ** 2 / spread if spread > 0 else 1.0


def halves_of(groups, second):
    return [group[len(group) // 2 :] if second else group[: len(group) // 2] for group in groups]


def firm_of_runs(columns):
    """A family of 2014 and its outcomes by halves."""
    table = family(columns, welch)
    for name, second in [("first_half", False), ("second_half", True)]:
        kept = [(contrast, claims, margin, halves_of(groups, second)) for contrast, claims, margin, groups in columns]
        table[name] = family(kept, welch).outcome
    return table


def judged_2014(tables):
    random = pd.concat([table[table["swarm.case"] == "random"] for table in tables])
    runs = pd.concat([table[table["swarm.case"] != "random"] for table in tables], ignore_index=True)
    runs = runs.rename(columns={column: name for name, column in FACTORS.items()} | {"swarm.case": "case", "swarm.control": "control"})
    runs["food"], random["food"] = ROBOTS * runs.rate, ROBOTS * random.rate
    # What is fixed or drawn is run once for both credits.
    fixed = runs.control.isin([RIGHT, DRAWN])
    shared = [runs[fixed].assign(credit=credit) for credit in runs.credit.unique()]
    runs = pd.concat([runs[~fixed], *shared], ignore_index=True)
    keys = list(FACTORS)
    all_cells = {key: Combination(own, random) for key, own in runs.groupby(keys)}
    contrasts, claims, cells = [], [], []
    for key, combination in all_cells.items():
        table = firm_of_runs([(name, of, margin, groups(combination)) for name, of, margin, groups in OF_CELLS])
        contrasts.append(table.assign(**dict(zip(keys, key))))
        for claim in JUDGED:
            claims.append((*key, claim, worst(table.outcome[table.claims.str.split().map(lambda of: claim in of)])))
        for (case, control), own in [*combination.cells.items(), (("random", EVOLVED), random.set_index("seed"))]:
            figures = own[["late_right", "late_s0", "late_g0", "late_g1"]].mean()
            cells.append((*key, case, control, len(own), own.food.mean(), own.food.std(), *figures))
    for key, combination in all_cells.items():
        for factor, (first, second) in LEVELS.items():
            place = keys.index(factor)
            other = all_cells.get((*key[:place], second, *key[place + 1 :]))
            if key[place] == first and other:
                table = firm_of_runs([(name, "", np.nan, [of(other) - of(combination)]) for name, of in OF_FACTORS])
                words = dict(zip(keys, key)) | {factor: f"{second} - {first}"}
                contrasts.append(table.assign(**words))
    table = by_other_criteria(pd.concat(contrasts))
    criteria = ["first_half", "second_half", "uncorrected", "level_0.01", "one_family"]
    table["survives"] = np.where(table[criteria].eq(table.outcome, axis=0).all(axis=1), "yes", "no")
    means = ["runs", "food", "food_deviation", "late_right", "late_s0", "late_g0", "late_g1"]
    return {
        "contrasts": table.drop(columns="margin").set_index([*keys, "contrast"]),
        "claims": pd.DataFrame(claims, columns=[*keys, "claim", "outcome"]).set_index([*keys, "claim"]),
        "cells": pd.DataFrame(cells, columns=[*keys, "case", "control", *means]).set_index([*keys, "case", "control"]),
    }


def differences(name, own, program):
    """Prints each cell that differs from the program's: words at all, numbers by more than their rounding and the optimiser's."""
    count = 0
    if set(own.index) != set(program.index) or set(own.columns) != set(program.columns):
        print(f"{name}: other rows or columns than the program's")
        return 1
    for key in own.index:
        for column in own.columns:
            here, there = own.loc[key, column], program.loc[key, column]
            if isinstance(here, str):
                same = here == there
            elif column in ("p", "p_holm"):
                # p falls by powers where an error differs in the fifth place.
                same = abs(here - there) <= 1e-6 + 0.02 * there
            else:
                same = (pd.isna(here) and pd.isna(there)) or abs(here - there) <= 1e-6 + 1e-4 * max(abs(here), abs(there))
            if not same:
                print(f"{name}: {key}, {column}: {here} here, {there} by the program")
                count += 1
    return count


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweeps", nargs="+", help="directories of finished sweeps")
    parser.add_argument("--judged", action="append", default=[], help="the directory that `oneiro reproduce STUDY --sweeps .. --out` wrote")
    arguments = parser.parse_args()
    words = dict.fromkeys(["reality.severity", "severity", *FACTORS, *FACTORS.values()], str)
    tables = [pd.read_csv(pathlib.Path(directory) / "results.csv", dtype=words) for directory in arguments.sweeps]
    if "swarm.case" in tables[0]:
        own = judged_2014(tables)
    else:
        calibrations = [table for table in tables if "noise.sensor" not in table]
        others = [table for table in tables if "noise.sensor" in table]
        own = judged(read(others)) if others else {}
        if calibrations:
            # Severities are numbers there.
            own["calibration"] = calibrated(pd.concat(calibrations, ignore_index=True))
    with pd.option_context("display.width", 200, "display.max_rows", None, "display.max_columns", None):
        if "contrasts" in own:
            print(own["contrasts"][["estimate", "low", "high", "p_holm", "outcome", "survives"]])
        if "calibration" in own:
            print(own["calibration"])
    total = 0
    for directory in arguments.judged:
        count = 0
        for name, table in own.items():
            types = {} if name == "calibration" else words
            program = pd.read_csv(pathlib.Path(directory) / f"{name}.csv", dtype=types, keep_default_na=False, na_values=["NaN", "-"])
            # Words for readers.
            program = program.drop(columns="reason", errors="ignore")
            count += differences(name, table, program.set_index(list(table.index.names)))
        verdicts = sum(len(table) for name, table in own.items() if name != "cells")
        print(f"{count} differences from the program in {verdicts} verdicts and their figures")
        total += count
    sys.exit(total > 0)


if __name__ == "__main__":
    main()
