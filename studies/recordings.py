"""Runs and judges the 1995 study between the built-in tables and recordings of a real Khepera.

    python studies/recordings.py --run DIRECTORY_OF_THE_RECORDINGS --out carried
    python studies/recordings.py studies/miglino1995/recordings/runs.csv

The first evolves, carries over and evolves on, and writes carried/runs.csv; it needs the program and Python alone. The second prints the
tables of studies/miglino1995/README.md: means of each condition, and the contrasts of studies/preregistration-1995-recordings.md. It needs pandas,
SciPy and statsmodels.
"""

import argparse
import csv
import json
import pathlib
import subprocess

EXPERIMENT = pathlib.Path(__file__).resolve().parent.parent / "experiments" / "khepera-avoidance.toml"
NOISES = {"none": {}, "sensor": {"noise.sensor": [0.0, 0.4]}, "conservative": {"noise.walk_range_mm": 30.0}}
# Collision rules of the simulator and of reality.
RULES = [("slide", "slide"), ("undo", "slide"), ("undo", "undo")]
WORLDS = ["recordings", "built-in"]
ON = 20
# Lives after evolution have seeds of their own.
LATER = 1000
HEAD = "to,simulator,reality,noise,seed,simulated,simulated_peak,simulated_deviation,quiet,real,real_peak,real_deviation,last"


class Study:
    def __init__(self, arguments):
        self.oneiro, self.out = arguments.oneiro, pathlib.Path(arguments.out).resolve()
        self.first, self.last = (int(seed) for seed in arguments.seeds.split(".."))
        files = [str(pathlib.Path(arguments.run).resolve() / f"{name}.sam") for name in ["wall", "round", "motor"]]
        self.worlds = {"built-in": {}, "recordings": {"robot.tables": files[:2], "robot.motors": files[2]}}

    def program(self, *words):
        subprocess.run([self.oneiro, *words, "--quiet"], check=True, stdout=subprocess.DEVNULL)

    def evolve(self, name, values):
        """One run for each seed, in a directory of its own."""
        sets = [word for key, value in {"evolution.finalists": 0, **values}.items() for word in ["--set", f"{key}={json.dumps(value)}"]]
        seeds = f"{self.first}..{self.last}"
        self.program("run", str(EXPERIMENT), "--seeds", seeds, *sets, "--out", str(self.out / name), "--backend", "cpu")

    def later(self, name, of, generations, values):
        """Rows of the generations that the last generations of these runs begin, for each seed."""
        seeds = range(self.first, self.last + 1)
        values = {"evolution.finalists": 0, "evolution.generations": generations, **values}
        populations = [f"{of}/seed-{seed}/population.npy" for seed in seeds]
        lines = [
            f"experiment = {json.dumps(str(EXPERIMENT))}",
            f"seeds = [{LATER + self.first}]",
            'seeds_by = "evolution.init"',
            "[set]",
            *[f"{key} = {json.dumps(value)}" for key, value in values.items()],
            "[grid]",
            f"evolution.init = {json.dumps(populations)}",
        ]
        (self.out / f"{name}.toml").write_text("\n".join(lines))
        self.program("sweep", "run", str(self.out / f"{name}.toml"), "--out", str(self.out / name), "--backend", "cpu")
        runs = {}
        with open(self.out / name / "results.csv") as results:
            for row, seed in zip(csv.DictReader(results), seeds, strict=True):
                assert int(row["seed"]) == LATER + seed, "a run has another seed"
        with open(self.out / name / "generations.csv") as rows:
            for row in csv.DictReader(rows):
                runs.setdefault(self.first + int(row["run"]), []).append(row)
        return runs

    def rows(self, to, noise, rules):
        """The rows of one direction, noise and pair of rules."""
        there = self.worlds[to]
        here = next(values for world, values in self.worlds.items() if world != to)
        simulator, reality = rules
        run = f"{to}-{simulator}-{noise}"
        here = {**here, "robot.collision": simulator}
        if not (self.out / run).exists():
            self.evolve(run, {**here, **NOISES[noise]})
            self.lived = [self.later(f"{run}-{name}", run, 1, values) for name, values in [("S", {**here, **NOISES[noise]}), ("Q", here)]]
        real = self.later(f"{run}-{reality}", run, ON, {**there, "robot.collision": reality})
        for seed in real:
            (simulated,), (quiet,) = (lived[seed] for lived in self.lived)
            first, *_, last = real[seed]
            figures = [simulated[figure] for figure in ["mean", "peak", "deviation"]] + [quiet["mean"]]
            yield [to, *rules, noise, seed, *figures, *[first[figure] for figure in ["mean", "peak", "deviation"]], last["mean"]]


def run(arguments):
    study = Study(arguments)
    study.out.mkdir(parents=True)
    with open(study.out / "runs.csv", "w") as table:
        print(HEAD, file=table)
        for to in WORLDS:
            for noise in NOISES:
                for rules in RULES:
                    for row in study.rows(to, noise, rules):
                        print(*row, sep=",", file=table)


def read(path):
    runs = pd.read_csv(path)
    runs["gap"] = runs.simulated - runs.real
    runs["true_gap"] = runs.quiet - runs.real
    runs["on"] = runs["last"] - runs.real
    runs["peak_fall"] = runs.simulated_peak - runs.real_peak
    runs["d"] = runs.gap / np.sqrt((runs.simulated_deviation**2 + runs.real_deviation**2) / 2)
    runs["failed"] = 100.0 * (runs.simulated_peak < FAILED_BELOW)
    return runs


def contrasts(wide, own):
    """A family: the second edition's contrasts but for paths and failed runs, and those of this study."""
    return [
        ("gap none = 0", "", MARGIN, wide.gap["none"]),
        *[(name, claims, MARGIN if is_none else NONE, of(wide)) for name, claims, is_none, of in OF_CONDITIONS[:13]],
        *[(f"own - real, {noise}", "", NONE, own - wide.real[noise]) for noise in ["none", "conservative"]],
    ]


def of_seeds(columns, some):
    return family([(*rest, values[some(values.index)]) for *rest, values in columns], fit).outcome


def judged(runs, to, rules):
    own = runs[(runs.to != to) & (runs.noise == "none") & (runs.simulator == rules[1]) & (runs.reality == rules[1])].set_index("seed").quiet
    wide = runs[(runs.to == to) & (runs.simulator == rules[0]) & (runs.reality == rules[1])].set_index(["seed", "noise"])
    wide = wide[["gap", "true_gap", "peak_fall", "simulated", "real", "on"]].unstack("noise")
    assert wide.notna().all().all(), "a condition is missing"
    columns = contrasts(wide, own)
    middle = wide.index[len(wide) // 2]
    halves = {"first_half": of_seeds(columns, lambda seed: seed < middle), "second_half": of_seeds(columns, lambda seed: seed >= middle)}
    return firm(columns).assign(**halves, to=to, rules=" to ".join(rules))


def cells(runs):
    print("| to | rules | noise | runs that fail | S | Q | R (s.e.) | L (s.e.) | d |\n|---|---|---|---|---|---|---|---|---|")
    for to in WORLDS:
        for rules in RULES:
            for noise in NOISES:
                some = runs[(runs.to == to) & (runs.simulator == rules[0]) & (runs.reality == rules[1]) & (runs.noise == noise)]
                mean, error = some.mean(numeric_only=True), some.sem(numeric_only=True)
                real, last = (f"{mean[figure]:.0f} ({error[figure]:.0f})" for figure in ["real", "last"])
                of = f"{to} | `{rules[0]}` to `{rules[1]}` | {noise} | {mean.failed:.0f} %"
                print(f"| {of} | {mean.simulated:.0f} | {mean.quiet:.0f} | {real} | {last} | {mean.d:.2f} |")


def main(path):
    runs = read(path)
    cells(runs)
    table = by_other_criteria(pd.concat([judged(runs, to, rules) for to in WORLDS for rules in RULES]))
    names = [" to ".join(rules) for rules in RULES]
    for to in WORLDS:
        of = {name: table[(table.to == to) & (table.rules == name)].reset_index() for name in names}
        print(f"\n| to the {to} | claim | " + " | ".join(f"`{name.replace(' to ', '` to `')}`" for name in names) + " |\n|---|---|---|---|---|")
        for place, (contrast, claims) in enumerate(zip(of[names[0]].contrast, of[names[0]].claims)):
            print(f"| {contrast} | {claims or '-'} | " + " | ".join(shown(of[name].loc[place]) for name in names) + " |")
        for claim in ["C3", "C4", "C5", "C6", "C7"]:
            outcome = lambda name: worst(of[name].outcome[of[name].claims.str.split().map(lambda claims: claim in claims)])
            print(f"| {claim} | | " + " | ".join(outcome(name) for name in names) + " |")
    print()
    for criterion in ["uncorrected", "level_0.01", "one_family"]:
        changed = table[table[criterion] != table.outcome]
        print(f"{criterion}: {len(changed)} of {len(table)} outcomes are others")
        for row in changed.itertuples(index=False):
            print(f"    to the {row.to}, {row.rules}: {row.contrast}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", nargs="?", help="the table to judge")
    parser.add_argument("--run", metavar="DIRECTORY", help="run the study with the recordings of this directory")
    parser.add_argument("--out", default="carried", help="a new directory for what runs")
    parser.add_argument("--seeds", default="1..100")
    parser.add_argument("--oneiro", default="oneiro", help="the program")
    arguments = parser.parse_args()
    if arguments.run:
        run(arguments)
    else:
        import numpy as np
        import pandas as pd

        from elsewhere import NONE, fit
        from elsewhere import judged as firm
        from noise import shown
        from recompute import FAILED_BELOW, MARGIN, OF_CONDITIONS, by_other_criteria, family, worst

        main(arguments.table)
