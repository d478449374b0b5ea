"""Experiments and evaluations: the program's bits, and its messages."""

import json
import pickle
import threading
import time

import numpy as np
import pytest
from conftest import AVOIDANCE, EXPERIMENTS, interrupted, program, refusal

import oneiro


def genomes(count, genes, seed=5):
    return np.random.default_rng(seed).uniform(-3, 3, (count, genes)).astype(np.float32)


def bits(array):
    return np.ascontiguousarray(array, np.float32).view(np.uint32).tolist()


def test_experiment(avoidance, own):
    assert avoidance.genes == 18 == len(avoidance.gene_names)
    assert avoidance.gene_names[0] == "left_90_to_left"
    assert avoidance.bounds.shape == (18, 2) and avoidance.bounds.dtype == np.float32
    again = oneiro.Experiment.load(AVOIDANCE, set={"cycles": 60})
    assert again.hash == avoidance.hash and again == avoidance and hash(again) == hash(avoidance)
    other = oneiro.Experiment.load(AVOIDANCE, set={"cycles": 61})
    assert other.hash != avoidance.hash and other != avoidance
    assert "\ncycles = 60\n" in avoidance.to_toml() and "\nseed" not in avoidance.to_toml()
    # Values of all types are those that the program reads.
    lists = {"evolution.initial": (-2, 2.5), "evolution.population": np.int64(40), "record.individuals": True}
    changed = oneiro.Experiment.load(AVOIDANCE, set=lists).to_toml()
    assert "initial = [-2.0, 2.5]" in changed and "population = 40" in changed
    assert "individuals = true" in changed
    assert own.genes != 18 and own.name == "homing"


def test_other_values_may_replace_files():
    for values in [{"task": {"kind": "avoidance"}}, {"controller": {"kind": "perceptron"}}]:
        other = oneiro.Experiment.load(EXPERIMENTS / "homing.toml").with_(values)
        assert other.hash == oneiro.Experiment.load(EXPERIMENTS / "homing.toml", set=values).hash


def test_an_experiment_has_values_for_tests():
    own = oneiro.Experiment.load(AVOIDANCE, set={"test": {"noise.sensor": [0.0, 0.2], "cycles": 50}})
    tested = own.tested_in()
    assert tested.hash == oneiro.Experiment.load(AVOIDANCE, set={"noise.sensor": [0.0, 0.2], "cycles": 50}).hash
    assert own.hash == oneiro.Experiment.load(AVOIDANCE).hash != tested.hash
    with pytest.raises(oneiro.InputError, match=r"no table \[test\]"):
        tested.tested_in()


def test_values_that_are_refused_have_the_programs_messages(tmp_path):
    for values in [{"cycles": 0}, {"cyles": 60}, {"evolution.population": "many"}]:
        settings = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
        code, message = refusal("check", AVOIDANCE, *settings)
        with pytest.raises(oneiro.InputError) as caught:
            oneiro.Experiment.load(AVOIDANCE, set=values)
        assert (caught.value.code, str(caught.value)) == (code, message) == (3, message)
        assert isinstance(caught.value, oneiro.Error) and isinstance(caught.value, ValueError)
    with pytest.raises(oneiro.InputError, match="missing.toml: No such file"):
        oneiro.Experiment.load(tmp_path / "missing.toml")
    swarm = oneiro.Experiment.load(EXPERIMENTS / "odowd2014-over.toml")
    with pytest.raises(oneiro.InputError, match="is of the foraging study"):
        swarm.genes  # noqa: B018


def test_genes_of_tables_are_found_by_name(avoidance):
    import pandas

    population = genomes(3, avoidance.genes)
    expected = bits(oneiro.evaluate(avoidance, population, seed=1).fitness)
    names = list(reversed(avoidance.gene_names))
    frame = pandas.DataFrame(population, columns=avoidance.gene_names)[names]
    assert bits(oneiro.evaluate(avoidance, frame, seed=1).fitness) == expected
    upper = frame.rename(columns=str.upper)
    assert bits(oneiro.evaluate(avoidance, upper, seed=1).fitness) == expected
    assert bits(oneiro.evaluate(avoidance, {name: frame[name] for name in names}, seed=1).fitness) == expected
    assert bits(oneiro.evaluate(avoidance, frame.to_records(index=False), seed=1).fitness) == expected
    with pytest.warns(UserWarning, match="other columns, which are ignored: `run`"):
        assert bits(oneiro.evaluate(avoidance, frame.assign(run=7), seed=1).fitness) == expected
    # The genes of a row also have names.
    for row in [frame.iloc[1], frame.iloc[1].to_dict()]:
        assert bits(oneiro.evaluate(avoidance, row, seed=1, keys=[1]).fitness) == expected[1:2]
    with pytest.raises(oneiro.InputError, match="none is called `left_90_to_left`"):
        oneiro.evaluate(avoidance, frame.rename(columns={"left_90_to_left": "other"}), seed=1)
    with pytest.warns(UserWarning, match="no names"):
        assert bits(oneiro.evaluate(avoidance, pandas.DataFrame(population), seed=1).fitness) == expected


@pytest.mark.parametrize("name", ["avoidance", "own"])
def test_fitness_has_the_programs_bits(name, request, tmp_path):
    exp = request.getfixturevalue(name)
    population = genomes(70, exp.genes)
    np.save(tmp_path / "genomes.npy", population)
    (tmp_path / "inputs").mkdir()
    path = EXPERIMENTS / f"{'khepera-avoidance' if name == 'avoidance' else 'homing'}.toml"
    settings = ["--set", "cycles=60"] if name == "avoidance" else []
    for common in [False, True]:
        rows = json.loads(
            program(
                *("evaluate", path, *settings, "--genomes", tmp_path / "genomes.npy", "--trials", 3, "--seed", 7),
                *(["--common-starts"] if common else []),
                *("--measures", "--json", "--backend", "cpu"),
            )
        )
        outcome = oneiro.evaluate(exp, population, seed=7, episodes=3, common_starts=common, backend="cpu")
        assert outcome.fitness.shape == (70, 3) and outcome.fitness.dtype == np.float32
        assert outcome.exact and outcome.device.startswith("cpu (")
        assert bits(outcome.fitness.ravel()) == [int(row["bits"], 16) for row in rows]
        measured = oneiro.evaluate(
            exp, population, seed=7, episodes=3, common_starts=common, backend="cpu", descriptors=True, traces=True
        )
        assert bits(measured.fitness) == bits(outcome.fitness)
        assert measured.descriptors.shape == (70, 3, len(exp.descriptor_names))
        for at, measure in enumerate(exp.descriptor_names):
            expected = np.array([row[measure] for row in rows], float).reshape(70, 3)
            np.testing.assert_allclose(measured.descriptors[..., at], expected, rtol=1e-5)
    # A bit that is wrong would be seen.
    outcome.fitness[3, 1] = np.nextafter(outcome.fitness[3, 1], np.float32(1e9))
    assert bits(outcome.fitness.ravel()) != [int(row["bits"], 16) for row in rows]


def test_traces_are_those_of_the_program(own, tmp_path):
    population = genomes(3, own.genes)
    np.save(tmp_path / "genomes.npy", population)
    program(
        *("evaluate", EXPERIMENTS / "homing.toml", "--genomes", tmp_path / "genomes.npy", "--trials", 2),
        *("--seed", 4, "--traces", tmp_path / "traces", "--out", tmp_path / "out.csv", "--backend", "cpu"),
    )
    outcome = oneiro.evaluate(own, population, seed=4, episodes=2, backend="cpu", traces=True)
    for genome in range(3):
        for life in range(2):
            head, *lines = (tmp_path / f"traces/trace-{genome}-{life}.csv").read_text().splitlines()
            trace = outcome.traces[genome, life]
            length = outcome.lengths[genome, life]
            assert length == len(lines) and list(trace.dtype.names) == head.split(",")[1:]
            for row, line in zip(trace, lines, strict=False):
                cells = line.split(",")[1:]
                for name, cell in zip(trace.dtype.names, cells, strict=True):
                    assert row[name] == trace.dtype[name].type(cell), (name, line)
            assert not trace[length:].view(np.uint8).any()
    assert outcome.lengths.min() > 0


def test_keys_name_lives(avoidance):
    population = genomes(40, 18)
    whole = oneiro.evaluate(avoidance, population, seed=3, episodes=2, backend="cpu").fitness
    part = oneiro.evaluate(avoidance, population[25:], seed=3, episodes=2, keys=range(25, 40), backend="cpu").fitness
    assert bits(part) == bits(whole[25:])
    without = oneiro.evaluate(avoidance, population[25:], seed=3, episodes=2, backend="cpu").fitness
    assert bits(without) != bits(whole[25:])
    generation = oneiro.evaluate(
        avoidance, population[25:], seed=3, keys=[[1, key] for key in range(15)], backend="cpu"
    )
    assert bits(generation.fitness) != bits(without[:, :1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"genomes": np.zeros((2, 17))}, r"genomes: have the shape \[2, 17\]; allowed: \[n, 18\]"),
        ({"genomes": np.full((2, 18), np.nan)}, r"genomes\[0, 0\]: is NaN"),
        ({"keys": [1.5, 2]}, "keys: aren't whole numbers"),
        ({"keys": [1, 2, 3]}, r"keys: have the shape \[3\]; allowed: \[2\] or \[2, 2\]"),
        ({"seed": -1}, "seed: is -1; allowed: a whole number, 0 to 9223372036854775807"),
        ({"seed": "one"}, "seed: is 'one'"),
        ({"episodes": 0}, "episodes: is 0; allowed: a whole number, 1 to"),
        ({"traces": 3}, "traces: is 3; allowed: True, False or None"),
    ],
)
def test_arguments_that_are_refused(avoidance, arguments, message):
    given = {"genomes": np.zeros((2, 18)), "seed": 1, "backend": "cpu", **arguments}
    with pytest.raises(oneiro.InputError, match=message):
        oneiro.evaluate(avoidance, given.pop("genomes"), **given)


def test_devices(avoidance):
    assert oneiro.devices()["cpu"]["exact"]
    with pytest.raises(oneiro.DeviceError, match="no backend `abacus`; allowed:") as caught:
        oneiro.evaluate(avoidance, np.zeros((1, 18)), seed=1, backend="abacus")
    assert caught.value.code == 4
    with pytest.raises(oneiro.InputError, match="answers without simulating anything"):
        oneiro.evaluate(avoidance, np.zeros((1, 18)), seed=1, backend="null")


def test_selftest():
    report = oneiro.selftest("cpu", rollouts=1000)
    assert report["passed"] and len(report["checks"]) > 10
    with pytest.raises(oneiro.InputError, match="rollouts: is 10; allowed: 1000 to 1000000"):
        oneiro.selftest("cpu", rollouts=10)
    with pytest.raises(oneiro.DeviceError, match="no backend `abacus`"):
        oneiro.selftest("abacus")


def test_pickles_are_whole(own, avoidance):
    for exp in [own, avoidance]:
        again = pickle.loads(pickle.dumps(exp))
        assert again == exp and again.hash == exp.hash and again.to_toml() == exp.to_toml()
        population = genomes(3, exp.genes)
        here = oneiro.evaluate(exp, population, seed=1, backend="cpu").fitness
        assert bits(oneiro.evaluate(again, population, seed=1, backend="cpu").fitness) == bits(here)


def evaluated(exp):
    """In another process."""
    # More than 4096 are packed by several threads.
    fitness = oneiro.evaluate(exp, genomes(5000, exp.genes), seed=1, backend="cpu").fitness
    return bits(fitness[:, 0])


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_other_processes(avoidance, method):
    import multiprocessing

    here = evaluated(avoidance)
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(evaluated, [avoidance] * 3).get(timeout=120) == [here] * 3


def test_threads(avoidance):
    """The lock of Python is released: several threads evaluate, and another one goes on meanwhile."""
    here, there = evaluated(avoidance), []
    threads = [threading.Thread(target=lambda: there.append(evaluated(avoidance))) for _ in range(3)]
    for thread in threads:
        thread.start()
    turns = 0
    while any(thread.is_alive() for thread in threads):
        turns += 1
        time.sleep(0.001)
    assert there == [here] * 3 and turns > 3


LONG = """
import sys, time
import numpy as np
import oneiro
exp = oneiro.Experiment.load(sys.argv[1], set={"cycles": 1_000_000})
print("begun", flush=True)
try:
    oneiro.evaluate(exp, np.zeros((100_000, exp.genes)), seed=1, backend="cpu")
except KeyboardInterrupt as stopped:
    print(*getattr(stopped, "__notes__", ["to start again"]), flush=True)
# It can go on.
exp = oneiro.Experiment.load(sys.argv[1])
print(oneiro.evaluate(exp, np.zeros((1, exp.genes)), seed=1, backend="cpu").fitness.shape)
"""


def test_control_c_stops():
    rest, seconds = interrupted(LONG, AVOIDANCE, after=1)
    note, shape = rest.splitlines()
    assert note.endswith("to start again") and "command" not in note and shape == "(1, 1)"
    assert seconds < 20


def test_measures_by_name_are_those_of_all(avoidance):
    genomes = avoidance.bounds.clip(-4, 4).T.repeat(40, axis=0)
    every = oneiro.evaluate(avoidance, genomes, seed=2, episodes=2, backend="cpu", descriptors=True)
    names = avoidance.descriptor_names
    for wanted in (["stuck_s"], ["end_y_mm", "end_x_mm"], ["cells", "wall_distance_mm", "cells"], names[::-1]):
        own = oneiro.evaluate(avoidance, genomes, seed=2, episodes=2, backend="cpu", descriptors=wanted)
        places = [names.index(name) for name in wanted]
        assert own.descriptors.tobytes() == np.ascontiguousarray(every.descriptors[..., places]).tobytes(), wanted
        assert own.fitness.tobytes() == every.fitness.tobytes()
    assert oneiro.evaluate(avoidance, genomes, seed=2, descriptors=[]).descriptors is None
    for wrong in ("cells", ["cell"]):
        with pytest.raises(oneiro.InputError, match="descriptors: .*allowed: "):
            oneiro.evaluate(avoidance, genomes, seed=2, descriptors=wrong)


def test_no_genomes_have_empty_results(avoidance):
    nobody = np.zeros((0, avoidance.genes))
    outcome = oneiro.evaluate(avoidance, nobody, seed=1, episodes=3, backend="cpu", descriptors=True, traces=True)
    assert outcome.fitness.shape == (0, 3) and outcome.device.startswith("cpu")
    assert outcome.descriptors.shape == (0, 3, len(avoidance.descriptor_names))
    assert outcome.traces.shape == (0, 3, 60) and "x_mm" in outcome.traces.dtype.names
    assert "0 genomes" in repr(outcome)
    with pytest.raises(oneiro.InputError, match="descriptors: "):
        oneiro.evaluate(avoidance, nobody, seed=1, descriptors=["cell"])


def test_a_gene_that_is_no_number_is_named(avoidance):
    genomes = np.zeros((5, avoidance.genes))
    genomes[3, 2] = np.nan
    for more in ({}, {"episodes": 2}, {"descriptors": True}):
        with pytest.raises(oneiro.InputError, match=r"^genomes\[3, 2\]: is NaN; allowed: -1000000 to 1000000$"):
            oneiro.evaluate(avoidance, genomes, seed=1, **more)
