"""Judges the second edition of the 1995 study again, from the tables of its sweeps, with pandas, SciPy and statsmodels alone.

    pip install pandas scipy statsmodels
    oneiro reproduce miglino1995 --sweeps collision-1,collision-1.75 --out second
    python docs/recompute.py --judged second collision-1 collision-1.75

It prints each contrast, and compares every figure and every outcome with those that the program wrote to `second`. What is
judged, and how, stands in docs/preregistration-1995-second.md. Models are fitted by statsmodels' MixedLM, not by the
program's closed form. Ends with exit code 1 if anything differs.
"""

import argparse
import pathlib
import sys
import warnings

import numpy as np
import pandas as pd
import statsmodels.api as sm
from scipy import stats
from statsmodels.stats.multitest import multipletests

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


def read(tables):
    runs = pd.concat(tables, ignore_index=True)
    runs = runs.rename(columns={"reality.severity": "severity", "robot.collision": "rule", "reality.robot": "robot"})
    if "reality.motion_severity" in runs:
        motion = runs["reality.motion_severity"].map(repr)
        runs["severity"] = np.where(motion == runs.severity, runs.severity, runs.severity + "/" + motion)
    quiet, still = runs["noise.sensor"] == "[0.0, 0.0]", runs["noise.walk_range_mm"] == 0
    assert (quiet | still).all(), "a run has both kinds of noise"
    runs["noise"] = np.select([quiet & still, still], ["none", "sensor"], "conservative")
    runs["gap"] = runs.simulated - runs.real
    runs["true_gap"] = runs.quiet - runs.real
    runs["on"] = runs["last"] - runs.real
    runs["peak_fall"] = runs.simulated_peak - runs.real_peak
    runs["failed"] = (runs.simulated_peak < FAILED_BELOW).astype(float)
    runs["path"] = runs.path_gap_mm
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


def nested(values):
    """The mean of values by robot, its standard error by restricted maximum likelihood, and its degrees of freedom."""
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


def tested(fit, is_equivalence):
    """Estimate, interval and p."""
    value, error, df = fit
    if np.isnan(value):
        return value, value, value, 1.0
    reach = stats.t.ppf(1 - ALPHA / 2, df) * error
    if error == 0:
        p = float(abs(value) >= MARGIN) if is_equivalence else float(value == 0)
    elif is_equivalence:
        p = max(stats.t.sf((value + MARGIN) / error, df), stats.t.cdf((value - MARGIN) / error, df))
    else:
        p = 2 * stats.t.sf(abs(value / error), df)
    return value, value - reach, value + reach, p


def family(columns, fit):
    """Judges the contrasts of a family: a list of names, claims, whether it is equivalence, and values by robot and seed."""
    rows = [(name, claims, equivalence, *tested(fit(values), equivalence)) for name, claims, equivalence, values in columns]
    table = pd.DataFrame(rows, columns=["contrast", "claims", "equivalence", "estimate", "low", "high", "p"])
    table["p_holm"] = multipletests(table.p, method="holm")[1]
    significant = table.p_holm < ALPHA
    beyond = (table.low > MARGIN) | (table.high < -MARGIN)
    opposed = np.where(table.equivalence, beyond, significant & (table.estimate < 0))
    table["outcome"] = np.select([opposed, significant], ["opposed", "holds"], "undecided")
    return table


def half(values, second):
    place = values.groupby(level="robot").cumcount()
    middle = values.groupby(level="robot").transform("size") // 2
    return values[(place >= middle) if second else (place < middle)]


def firm(columns, converged):
    """A family's outcomes, and those by fewer runs."""
    table = family(columns, nested)
    robots = columns[0][3].index.get_level_values("robot").unique()
    kept = lambda of: [(name, claims, equivalence, of(values)) for name, claims, equivalence, values in columns]
    changed = np.zeros(len(table), int)
    for robot in robots:
        without = family(kept(lambda values: values.drop(robot, level="robot")), nested)
        changed += (without.outcome != table.outcome).to_numpy()
    table["changed_by_robots"] = changed
    table["first_half"] = family(kept(lambda values: half(values, False)), nested).outcome
    table["second_half"] = family(kept(lambda values: half(values, True)), nested).outcome
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
        pivot = own[["gap", "true_gap", "peak_fall", "simulated", "real", "on", "path", "failed"]].unstack("noise")
        assert pivot.notna().all().all(), "a condition is missing"
        wide[severity, rule] = pivot
        columns = [(name, of, equivalence, values(pivot)) for name, of, equivalence, values in OF_CONDITIONS]
        table = firm(columns, pivot.failed.sum(axis=1) == 0)
        contrasts.append(table.assign(severity=severity, rule=rule))
        for claim in ["C3", "C4", "C5", "C6", "C7", "C8"]:
            outcomes = table.outcome[table.claims.str.split().map(lambda of: claim in of)]
            worst = next((word for word in ["opposed", "undecided"] if (outcomes == word).any()), "holds")
            claims.append((severity, rule, claim, worst))
        for noise in CONDITIONS:
            of_noise = own.xs(noise, level="noise")
            d = pd.Series({robot: effect(group) for robot, group in of_noise.groupby(level="robot")})
            means = of_noise[["failed", "simulated", "quiet", "real", "last"]].mean()
            paths = of_noise[["path_gap_mm", "path_repeat_mm"]].mean()
            cells.append((severity, rule, noise, len(of_noise), *means, d.mean(), stats.sem(d), *paths))
    for severity in runs.severity.unique():
        if {(severity, "undo"), (severity, "slide")} <= wide.keys():
            undo, slide = wide[severity, "undo"], wide[severity, "slide"]
            columns = [(name, "", False, values(undo, slide)) for name, values in OF_RULES]
            table = firm(columns, (undo.failed.sum(axis=1) + slide.failed.sum(axis=1)) == 0)
            contrasts.append(table.assign(severity=severity, rule="slide - undo"))
    means = ["failed", "simulated", "quiet", "real", "last", "d", "d_error", "path_gap_mm", "path_repeat_mm"]
    return {
        "contrasts": pd.concat(contrasts).drop(columns="equivalence").set_index(["severity", "rule", "contrast"]),
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
    parser.add_argument("--judged", help="the directory that `oneiro reproduce miglino1995 --sweeps .. --out` wrote")
    arguments = parser.parse_args()
    tables = {directory: pd.read_csv(pathlib.Path(directory) / "results.csv", dtype={"reality.severity": str}) for directory in arguments.sweeps}
    calibrations = [table for table in tables.values() if "noise.sensor" not in table]
    others = [table for table in tables.values() if "noise.sensor" in table]
    own = judged(read(others)) if others else {}
    if calibrations:
        own["calibration"] = calibrated(pd.concat(calibrations, ignore_index=True))
    with pd.option_context("display.width", 200, "display.max_rows", None, "display.max_columns", None):
        if "contrasts" in own:
            print(own["contrasts"][["estimate", "low", "high", "p_holm", "outcome", "survives"]])
        if "calibration" in own:
            print(own["calibration"])
    if arguments.judged is None:
        return
    count = 0
    types = {"contrasts": {"severity": str}, "claims": {"severity": str}, "cells": {"severity": str}, "calibration": {}}
    for name, table in own.items():
        program = pd.read_csv(pathlib.Path(arguments.judged) / f"{name}.csv", dtype=types[name], keep_default_na=False, na_values=["NaN", "-"])
        count += differences(name, table, program.set_index(list(table.index.names)))
    verdicts = sum(len(table) for name, table in own.items() if name != "cells")
    print(f"{count} differences from the program in {verdicts} verdicts and their figures")
    sys.exit(count > 0)


if __name__ == "__main__":
    main()
