"""Evolutions, runs and sweeps: those of the program."""

import json
import pickle
import re
import sys

import numpy as np
import pytest
from conftest import AVOIDANCE, EXPERIMENTS, interrupted, program

import oneiro

SET = {
    "cycles": 40,
    "evolution.population": 30,
    "evolution.parents": 6,
    "evolution.generations": 5,
    "evolution.finalist_lives": 10,
    "trials": 2,
    "record.individuals": True,
}
SETTINGS = [word for key, value in SET.items() for word in ("--set", f"{key}={json.dumps(value)}")]


@pytest.fixture
def short():
    return oneiro.Experiment.load(AVOIDANCE, set=SET)


def evolve(exp, evolution):
    while not evolution.is_finished:
        outcome = oneiro.evaluate(
            exp, evolution.ask(), seed=evolution.seed, keys=evolution.keys, episodes=exp.trials, backend="cpu"
        )
        evolution.tell(outcome.fitness)
    return evolution.luckiest


def test_an_evolution_that_is_told_is_the_programs(short, tmp_path):
    program("run", AVOIDANCE, *SETTINGS, "--seed", 3, "--out", tmp_path / "run", "--backend", "cpu")
    luckiest = evolve(short, oneiro.Evolution(short, seed=3))
    recorded = json.loads((tmp_path / "run/luckiest.json").read_text())
    genome = np.load(tmp_path / "run/luckiest.npy").ravel()
    assert luckiest.genome.view(np.uint32).tolist() == genome.view(np.uint32).tolist()
    assert (luckiest.generation, luckiest.individual) == (recorded["generation"], recorded["individual"])
    other = evolve(short, oneiro.Evolution(short, seed=4))
    assert other.genome.tolist() != luckiest.genome.tolist()


def test_states_continue(short):
    whole = evolve(short, oneiro.Evolution(short, seed=3))
    evolution = oneiro.Evolution(short, seed=3)
    first = evolution.state()
    assert evolution.luckiest is None and evolution.generation == 0
    for generation in range(5):
        evolution = pickle.loads(pickle.dumps(evolution))
        fresh = oneiro.Evolution(short, seed=3)
        fresh.restore(evolution.state())
        assert fresh.generation == generation and fresh.ask().tobytes() == evolution.ask().tobytes()
        outcome = oneiro.evaluate(short, fresh.ask(), seed=3, keys=fresh.keys, episodes=2, backend="cpu")
        fresh.tell(outcome.fitness)
        evolution = fresh
    assert evolution.luckiest.genome.tobytes() == whole.genome.tobytes()
    with pytest.raises(oneiro.FailedError, match="all 5 generations have been evaluated"):
        evolution.tell(np.zeros(30))
    before = evolution.state()
    with pytest.raises(oneiro.CorruptError, match="is cut off or damaged"):
        evolution.restore(first[:-1])
    other = oneiro.Experiment.load(AVOIDANCE, set={**SET, "evolution.parents": 5})
    with pytest.raises(oneiro.CorruptError, match="belongs to other settings"):
        evolution.restore(oneiro.Evolution(other, seed=3).state())
    assert evolution.state() == before


BEHAVIOUR = {
    "evolution.kind": "map-elites",
    "evolution.descriptors": [
        {"measure": "end_y_mm", "least": 0.0, "greatest": 1000.0, "cells": 10},
        {"measure": "end_x_mm", "least": 0.0, "greatest": 1000.0, "cells": 10},
    ],
}


def test_behaviour_is_told():
    settings = {key: value for key, value in SET.items() if key != "evolution.parents"}
    exp = oneiro.Experiment.load(AVOIDANCE, set={**settings, **BEHAVIOUR})
    evolution = oneiro.Evolution(exp, seed=1)
    assert evolution.descriptor_names == ["end_y_mm", "end_x_mm"]
    outcome = oneiro.evaluate(
        exp, evolution.ask(), seed=1, keys=evolution.keys, episodes=2, backend="cpu", descriptors=True
    )
    own = outcome.descriptors[..., [exp.descriptor_names.index(name) for name in evolution.descriptor_names]]
    count = len(own)
    for descriptors, message in [(None, "needed"), (own[1:], "have the shape"), (own[..., :1], "have the shape")]:
        with pytest.raises(oneiro.InputError, match=message):
            evolution.tell(outcome.fitness, descriptors)
    states = []
    for descriptors in [own, own.mean(axis=1), outcome.descriptors, own[..., ::-1]]:
        fresh = oneiro.Evolution(exp, seed=1)
        fresh.tell(outcome.fitness, descriptors)
        assert fresh.generation == 1 and len(fresh.ask()) == count
        states.append(fresh.state())
    assert states[0] == states[1] == states[2] != states[3]


def test_archives_are_those_of_the_run(tmp_path):
    settings = {key: value for key, value in SET.items() if key != "evolution.parents"}
    exp = oneiro.Experiment.load(AVOIDANCE, set={**settings, **BEHAVIOUR})
    evolution = oneiro.Evolution(exp, seed=1)
    assert len(evolution.archive.cells) == 0 and evolution.archive.coverage == 0.0
    while not evolution.is_finished:
        names = evolution.descriptor_names
        outcome = oneiro.evaluate(exp, evolution.ask(), seed=1, keys=evolution.keys, backend="cpu", descriptors=names)
        evolution.tell(outcome.fitness, outcome.descriptors)
    run = oneiro.run(exp, seed=1, out=tmp_path / "run", backend="cpu")
    told, recorded = evolution.archive, run.archive
    assert len(told.cells) > 10 and told.descriptor_names == recorded.descriptor_names == names
    for own, other in zip(told[:4], recorded[:4], strict=True):
        assert own.dtype == other.dtype or own is told.cells
        assert np.array_equal(own, other)
    assert told[5:] == recorded[5:]
    assert told.coverage == len(told.cells) / 100 and "elites" in repr(told)
    # Each is in the cell of its behaviour.
    places = (told.descriptors / 100).astype(int).clip(0, 9)
    assert (places[:, 0] * 10 + places[:, 1] == told.cells).all()
    table = recorded.table
    assert list(table) == ["cell", "fitness", *names] and len(table["cell"]) == len(told.cells)
    lines = (tmp_path / "run/archive.csv").read_text().splitlines()
    (tmp_path / "run/archive.csv").write_text("\n".join(lines[:-1]))
    with pytest.raises(oneiro.CorruptError, match="archive.csv is not what was recorded"):
        run.archive  # noqa: B018


def test_strategies_show_their_distribution(short):
    plain = oneiro.Evolution(short, seed=1)
    assert plain.archive is None and plain.mean is None and plain.sigma is None
    settings = {key: value for key, value in SET.items() if key != "evolution.parents"}
    for kind in ("cma-es", "sep-cma-es", "open-es"):
        exp = oneiro.Experiment.load(
            AVOIDANCE, set={**settings, "evolution.kind": kind, "evolution.strategy.sigma": 0.25}
        )
        evolution = oneiro.Evolution(exp, seed=1)
        assert evolution.sigma == 0.25 and evolution.mean.shape == (exp.genes,)
        first = evolution.mean
        # The mean of many samples is near to that of the distribution.
        assert np.abs(evolution.ask().mean(axis=0) - first).max() < 5.0
        evolution.tell(-np.square(evolution.ask()).sum(axis=1))
        assert not np.array_equal(evolution.mean, first)
        assert (evolution.sigma == 0.25) == (kind == "open-es")


def test_adopted_genomes_are_a_run(short, tmp_path):
    low, high = short.bounds.clip(-5, 5).T
    genomes = np.random.default_rng(3).uniform(low, high, (6, short.genes)).astype(np.float32)
    np.save(tmp_path / "genomes.npy", genomes)
    there = ("--out", tmp_path / "there", "--trials", 5, "--seed", 2, "--backend", "cpu")
    of_episodes = [f"--set={word}" for word in SETTINGS if "=" in word and not word.startswith("evolution.")]
    program("adopt", AVOIDANCE, "--genomes", tmp_path / "genomes.npy", *there, *of_episodes)
    run = oneiro.adopt(short, genomes, seed=2, out=tmp_path / "here", trials=5, backend="cpu")
    for file in ("champion.npy", "population.npy", "fitness.npy", "generations.csv"):
        assert (tmp_path / "here" / file).read_bytes() == (tmp_path / "there" / file).read_bytes(), file
    assert any(np.array_equal(run.champion.genome, own) for own in genomes)
    table = {name: genomes[:, place] for place, name in reversed(list(enumerate(short.gene_names)))}
    assert oneiro.adopt(short, table, seed=2, out=tmp_path / "by-name", trials=5, backend="cpu").result == run.result
    for call, message in [
        (lambda: oneiro.adopt(short, genomes[:, 1:], seed=2, out=tmp_path / "bad"), "genomes: have the shape"),
        (lambda: oneiro.adopt(short, genomes, seed=2, out=tmp_path / "bad", trials=1), "trials: is 1"),
        (lambda: oneiro.adopt(short, genomes * np.nan, seed=2, out=tmp_path / "bad"), "genomes.npy"),
    ]:
        with pytest.raises(oneiro.InputError, match=message):
            call()
    assert not (tmp_path / "bad").exists()


DESCRIPTOR = {"measure": "mean_speed_mm_s", "least": 0.0, "greatest": 80.0, "cells": 40}
PLACES = [{"measure": measure, "least": 0.0, "greatest": 600.0} for measure in ("end_x_mm", "end_y_mm")]
# What optimisers take besides the values below, or another experiment.
VALUES = {
    "genetic": ("khepera-avoidance", {"parents": 4}),
    "map-elites": ("khepera-avoidance", {"descriptors": [DESCRIPTOR]}),
    "novelty": ("khepera-avoidance", {"descriptors": PLACES, "parents": 4}),
    "grid": ("aggregation", {"grid.levels": 2, "population": 4}),
    "race": ("automode-cues", {"race.lives": 400}),
    "coevolution": ("predator-prey", {"parents": 4, "opponents.contests": 3}),
}


def test_every_kind_that_is_told_is_its_run(short, tmp_path):
    with pytest.raises(oneiro.InputError) as refused:
        oneiro.Evolution(short, seed=1, kind="prayer")
    kinds = str(refused.value).split("allowed: ")[1].split(", ")
    assert set(VALUES) < set(kinds) and len(kinds) >= 10, kinds
    for kind in kinds:
        name, own = VALUES.get(kind, ("khepera-avoidance", {}))
        values = {"cycles": 40, "evolution.kind": kind, "evolution.finalists": 0}
        if kind != "race":
            # Means of nine numbers depend on the order in which they are added.
            values |= {"trials": 9, "evolution.population": 12}
        if kind not in ("race", "grid"):
            values["evolution.generations"] = 4
        values |= {f"evolution.{key}": value for key, value in own.items()}
        exp = oneiro.Experiment.load(EXPERIMENTS / f"{name}.toml", set=values)
        evolution = oneiro.Evolution(exp, seed=5)
        while not evolution.is_finished:
            genomes = evolution.ask()
            names = evolution.descriptor_names
            outcome = oneiro.evaluate(exp, genomes, seed=5, keys=evolution.keys, backend="cpu", descriptors=names)
            evolution.tell(outcome.fitness, outcome.descriptors)
        assert evolution.generation >= 3, kind
        oneiro.run(exp, seed=5, out=tmp_path / kind, backend="cpu")
        assert genomes.tobytes() == np.load(tmp_path / kind / "population.npy").tobytes(), kind
        scores = np.load(tmp_path / kind / "fitness.npy").ravel()
        if kind != "coevolution":
            means = outcome.fitness.astype(np.float64).mean(axis=1)
            np.testing.assert_allclose(scores, means, rtol=1e-6, err_msg=kind)


def test_messages_are_true_of_calls(short, tmp_path):
    from oneiro import gym, pettingzoo

    aggregation = oneiro.Experiment.load(EXPERIMENTS / "aggregation.toml")
    (tmp_path / "other").mkdir()
    (tmp_path / "other/file").write_text("not ours")
    oneiro.sweep_shard(EXPERIMENTS / "sweeps/small.toml", out=tmp_path / "sweep", shard="1/2", backend="cpu")
    oneiro.run(short, seed=1, out=tmp_path / "run", backend="cpu")
    (tmp_path / "run/DONE").unlink()
    for call, words in [
        (lambda: pettingzoo.ParallelEnv(short), "it has a single robot, not a swarm"),
        (lambda: gym.VectorEnv(aggregation), "is a swarm; allowed: single robots here"),
        (lambda: oneiro.run(short, seed=1, out=tmp_path / "other"), "name another directory as `out`"),
        (lambda: oneiro.run(short, seed=2, out=tmp_path / "run"), "holds the run of another experiment or seed"),
        (lambda: oneiro.load_run(tmp_path / "run").champion, "`oneiro.resume("),
        (lambda: oneiro.merge(tmp_path / "sweep"), "`oneiro.sweep` does them"),
        (lambda: oneiro.Experiment.load(EXPERIMENTS / "sweeps/small.toml"), "oneiro.sweep("),
        (lambda: oneiro.evaluate(short, short.bounds.T[:1], seed=1, backend="null"), "backend null"),
    ]:
        with pytest.raises(oneiro.Error) as caught:
            call()
        message = str(caught.value)
        assert words in message, message
        assert not re.search(r"--[a-z]|oneiro (run|resume|sweep (run|merge))|same command", message), message


def test_common_random_numbers_share_a_key():
    exp = oneiro.Experiment.load(AVOIDANCE, set={**SET, "evolution.common_random_numbers": True})
    assert (oneiro.Evolution(exp, seed=1).keys == 0).all()
    exp = oneiro.Experiment.load(AVOIDANCE, set=SET)
    assert oneiro.Evolution(exp, seed=1).keys[:, 1].tolist() == list(range(30))


def test_what_is_told_wrongly_is_refused(short):
    evolution = oneiro.Evolution(short, seed=1)
    for fitness in [np.zeros(29), np.zeros((30, 0)), np.zeros((30, 2, 1)), 1.0]:
        with pytest.raises(oneiro.InputError, match=r"allowed: \[30\] or \[30, episodes\]"):
            evolution.tell(fitness)
    with pytest.raises(oneiro.InputError, match="uses none"):
        evolution.tell(np.zeros(30), descriptors=np.zeros((30, 2)))
    with pytest.raises(oneiro.InputError):
        oneiro.Evolution(short, seed=1, kind="prayer")
    assert oneiro.Evolution(short, seed=1, kind=evolution.kind).ask().tobytes() == evolution.ask().tobytes()
    assert evolution.generation == 0


def test_runs_are_the_programs(short, tmp_path):
    program("run", AVOIDANCE, *SETTINGS, "--seed", 3, "--out", tmp_path / "there", "--backend", "cpu")
    run = oneiro.run(short, seed=3, out=tmp_path / "here", backend="cpu")
    assert run.result == json.loads((tmp_path / "there/DONE").read_text())["result"] == run.verify()
    assert run.experiment.hash == oneiro.load_run(tmp_path / "there").experiment.hash
    assert run.seed == 3 and len(run.generations["mean"]) == 5
    champion = run.champion
    assert champion.genome.tolist() == np.load(tmp_path / "there/champion.npy").ravel().tolist()
    assert champion.values["mean"] == json.loads((tmp_path / "there/champion.json").read_text())["mean"]
    report = run.audit(1.0, backend="cpu")
    assert report
    # Done once, it is left as it is.
    assert oneiro.run(short, seed=3, out=tmp_path / "here").result == run.result
    assert oneiro.resume(tmp_path / "here").result == run.result
    with pytest.raises(oneiro.InputError, match="holds the run of another experiment or seed"):
        oneiro.run(short, seed=4, out=tmp_path / "here")
    values = bytearray((tmp_path / "here/individuals.npy").read_bytes())
    values[-1] ^= 1
    (tmp_path / "here/individuals.npy").write_bytes(values)
    with pytest.raises(oneiro.CorruptError, match="individuals.npy is not what was recorded"):
        run.verify()
    with pytest.raises(oneiro.InputError, match="is not a run directory"):
        oneiro.load_run(tmp_path)


STOPPED = """
import sys
import oneiro
exp = oneiro.Experiment.load(sys.argv[1], set={"evolution.generations": 100_000, "cycles": 200})
print("begun", flush=True)
try:
    oneiro.run(exp, seed=1, out=sys.argv[2], backend="cpu")
except KeyboardInterrupt as stopped:
    print(getattr(stopped, "__notes__", ['oneiro.resume("'])[0].splitlines()[-1].split("run")[0].strip())
"""


def test_control_c_stops_a_run_that_goes_on(tmp_path):
    rest, _ = interrupted(STOPPED, AVOIDANCE, tmp_path / "run", after=2)
    assert rest.startswith('oneiro.resume("')
    run = oneiro.load_run(tmp_path / "run")
    done = len(run.generations["mean"])
    assert run.result is None and done > 0
    with pytest.raises(oneiro.FailedError, match="is not finished"):
        run.champion  # noqa: B018


def test_sweeps_are_the_programs(tmp_path):
    plan = EXPERIMENTS / "sweeps/small.toml"
    printed = json.loads(program("sweep", "run", plan, "--out", tmp_path / "there", "--json", "--backend", "cpu"))
    sweep = oneiro.sweep(plan, out=tmp_path / "here", jobs=2, backend="cpu")
    assert (sweep.hash, sweep.runs) == (printed["hash"], printed["runs"])
    assert len(sweep.results["run"]) == sweep.runs
    assert (tmp_path / "here/results.csv").read_bytes() == (tmp_path / "there/results.csv").read_bytes()
    assert oneiro.sweep(plan, out=tmp_path / "here").hash == sweep.hash
    with pytest.raises(oneiro.InputError, match="jobs: is 0"):
        oneiro.sweep(plan, out=tmp_path / "here", jobs=0)


def test_tables_without_libraries(tmp_path, monkeypatch):
    from oneiro import _runs

    (tmp_path / "table.csv").write_text('name,count,number\n"a,b",1,0.1\nc,-2,\n')
    frame = _runs.table(tmp_path / "table.csv")
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "polars", None)
    table = _runs.table(tmp_path / "table.csv")
    assert list(table) == ["name", "count", "number"]
    assert table["name"].tolist() == ["a,b", "c"] and table["count"].tolist() == [1, -2]
    assert table["number"][0] == 0.1 and np.isnan(table["number"][1])
    assert list(frame["count"]) == [1, -2] and frame["number"][0] == 0.1


def test_notebooks_show_pages(short, tmp_path):
    assert "<caption" in short._repr_html_() and "[evolution]" in short._repr_html_()
    evolution = oneiro.Evolution(short, seed=3)
    assert "none yet" in evolution._repr_html_()
    best = evolve(short, evolution)
    assert "finished" in evolution._repr_html_() and str(best.score) in evolution._repr_html_()
    run = oneiro.run(short, seed=3, out=tmp_path / "run<b>", backend="cpu")
    page = run._repr_html_()
    assert page.count("<iframe") == 1 and "sandbox=" in page
    # Its content is text for the notebook.
    frame = page[page.index("srcdoc=") :]
    assert frame.count('"') == 2 and "<script" not in page and "<b>" not in page.replace("<b>" + short.name, "")
    (tmp_path / "run<b>/report.html").unlink()
    assert "<iframe" not in run._repr_html_()
