"""Judges the 2014 study beside its rivals: python studies/rivals.py rivals/results.csv

Prints the tables of studies/odowd2014/README.md: the means of each method, and the contrasts of studies/preregistration-2014-rivals.md, or
with --study central those of studies/preregistration-2014-central.md.
With --keep FILE it writes what it takes of the sweep's table to a file, and FILE alone prints the same. Needs pandas and SciPy.
"""

import argparse

import pandas as pd
from scaling import holm, interval
from scipy import stats

KEPT = ["case", "control", "seed", "rate", "after_rate"]
CASES = ["over", "over-then-opposite", "opposite-then-over"]
# Methods, primary and secondary contrasts of each study.
STUDIES = {
    "rivals": (
        ["evolved", "embodied", "embodied-random", "disparity", "heard-by-all", "simulator-right", "fitness-shuffled"],
        [("evolved", "embodied")],
        [("evolved", "embodied-random"), ("disparity", "evolved"), ("heard-by-all", "evolved")],
    ),
    "central": (
        ["central", "evolved", "embodied", "simulator-right"],
        [("central", "evolved")],
        [("central", "embodied"), ("simulator-right", "central")],
    ),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table")
    parser.add_argument("--keep")
    parser.add_argument("--study", choices=STUDIES, default="rivals")
    asked = parser.parse_args()
    methods, primary, secondary = STUDIES[asked.study]
    runs = pd.read_csv(asked.table).rename(columns={"swarm.case": "case", "swarm.control": "control"})[KEPT]
    if asked.keep:
        runs.sort_values(KEPT[:3]).to_csv(asked.keep, index=False)
    wide = runs.pivot(index=["case", "seed"], columns="control")
    print("| case | method | food, items a robot-minute | in the 500 s after the light moves |")
    print("|---|---|---|---|")
    for case in CASES:
        for method in methods:
            own = wide.loc[case]
            after = "-" if case == "over" else interval(own["after_rate"][method])
            print(f"| {case} | {method} | {interval(own['rate'][method])} | {after} |")
    for name, pairs in [("primary", primary), ("secondary", secondary)]:
        contrasts = [(case, one, other) for case in CASES for one, other in pairs]
        differences = [wide.loc[case]["rate"][one] - wide.loc[case]["rate"][other] for case, one, other in contrasts]
        corrected = holm([stats.ttest_1samp(own, 0).pvalue for own in differences])
        print(f"\n| {name} contrast | case | difference | p after Holm | outcome |\n|---|---|---|---|---|")
        for (case, one, other), own, p in zip(contrasts, differences, corrected, strict=True):
            outcome = "undecided" if p >= 0.05 else "holds" if own.mean() > 0 else "opposed"
            print(f"| {one} - {other} | {case} | {interval(own)} | {p:.2g} | {outcome} |")


if __name__ == "__main__":
    main()
