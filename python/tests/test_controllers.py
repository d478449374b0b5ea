"""Controllers that are stepped with readings from elsewhere."""

import pickle

import numpy as np
import pytest
from conftest import EXPERIMENTS

import oneiro


def experiments():
    """Every shipped experiment with genomes, shortened."""
    for path in sorted(EXPERIMENTS.glob("*.toml")):
        try:
            exp = oneiro.Experiment.load(path, set={"cycles": 60})
            exp.genes  # noqa: B018
        except oneiro.InputError:
            # Of the foraging study.
            continue
        yield path.stem, exp


def readings_and_outputs(exp, genomes, seed):
    """`[n, cycles, inputs]` and `[n, cycles, 2]` of traced episodes, up to the shortest one's end."""
    outcome = oneiro.evaluate(exp, genomes, seed=seed, backend="cpu", traces=True)
    traces = outcome.traces[:, 0, : outcome.lengths.min()]
    sensors = [name for name in traces.dtype.names if name.startswith("sensor_")]
    readings = np.stack([traces[name] for name in sensors], axis=-1)
    return readings, np.stack([traces[f"output_{side}"] for side in ("left", "right")], axis=-1)


def test_fed_with_a_traces_readings_it_has_the_episodes_bits():
    kinds = set()
    for name, exp in experiments():
        genomes = random(exp, 3, 7)
        controllers = oneiro.Controller(exp, genomes)
        readings, outputs = readings_and_outputs(exp, genomes, 5)
        assert readings.shape[2] == len(controllers.inputs), name
        controllers.reset(seed=5)
        for cycle in range(readings.shape[1]):
            assert controllers.step(readings[:, cycle]).tobytes() == outputs[:, cycle].tobytes(), (name, cycle)
        assert readings.shape[1] > 0 and controllers.cycle == readings.shape[1]
        kinds.add(controllers.kind)
    assert len(kinds) >= 4, kinds


def test_a_machine_draws_the_episodes_numbers():
    exp = oneiro.Experiment.load(EXPERIMENTS / "automode-cues.toml", set={"cycles": 200})
    genomes = random(exp, 8, 7)
    readings, outputs = readings_and_outputs(exp, genomes, 5)
    controllers = oneiro.Controller(exp, genomes)

    def is_the_episode(**reset):
        controllers.reset(**reset)
        return all(np.array_equal(controllers.step(readings[:, cycle]), outputs[:, cycle]) for cycle in range(200))

    assert is_the_episode(seed=5) and is_the_episode(seed=5, keys=range(8))
    assert not any(
        is_the_episode(**other) for other in ({"seed": 6}, {"seed": 5, "episode": 1}, {"seed": 5, "keys": range(1, 9)})
    )


def random(exp, count, seed):
    """Genomes within the range of each gene, or small ones."""
    low, high = exp.bounds.astype(np.float64).clip(-3, 3).T
    return np.random.default_rng(seed).uniform(low, high, (count, exp.genes)).astype(np.float32)


def test_one_genome_drives_many_robots():
    exp = oneiro.Experiment.load(EXPERIMENTS / "khepera-avoidance.toml")
    genome = random(exp, 1, 3)[0]
    one, many = oneiro.Controller(exp, genome), oneiro.Controller(exp, genome, robots=40)
    assert [each.name for each in one.inputs] and "0 to 1" in one.inputs[0].about
    readings = np.random.default_rng(1).uniform(0, 1, (40, len(one.inputs))).astype(np.float32)
    outputs = many.step(readings)
    assert outputs.shape == (40, 2) and outputs.dtype == np.float32
    assert one.step(readings[7]).tobytes() == outputs[7].tobytes()
    assert not np.array_equal(outputs[7], outputs[8])
    speeds = one.wheels([1.0, 0.5])
    assert speeds[0] == 1.0 and abs(speeds[1]) < 0.2
    assert "40 robots, cycle 1" in repr(many)


def test_it_is_pickled_between_cycles():
    exp = oneiro.Experiment.load(EXPERIMENTS / "automode-cues.toml")
    controllers = oneiro.Controller(exp, random(exp, 4, 2))
    readings = np.random.default_rng(4).uniform(0, 1, (30, 4, len(controllers.inputs))).astype(np.float32)
    controllers.reset(seed=9, episode=2)
    for cycle in readings[:15]:
        controllers.step(cycle)
    again = pickle.loads(pickle.dumps(controllers))
    assert again.cycle == 15
    for cycle in readings[15:]:
        assert again.step(cycle).tobytes() == controllers.step(cycle).tobytes()


def test_what_is_wrong_is_named():
    exp = oneiro.Experiment.load(EXPERIMENTS / "khepera-avoidance.toml")
    genomes = random(exp, 2, 1)
    controllers = oneiro.Controller(exp, genomes)
    inputs = len(controllers.inputs)
    bad = np.zeros((2, inputs))
    bad[1, 3] = np.nan
    for call, message in [
        (lambda: oneiro.Controller(exp, genomes[:, 1:]), "genome: has the shape"),
        (lambda: oneiro.Controller(exp, genomes, robots=3), "robots: is 3; allowed: 2"),
        (lambda: oneiro.Controller(exp, genomes, number=1), "robot: is 1"),
        (lambda: oneiro.Controller(exp, genomes * np.inf), r"genomes\[0\]: genes"),
        (lambda: controllers.step(bad[0]), "readings: have the shape"),
        (lambda: controllers.step(bad), r"readings\[1, 3\]"),
        (lambda: controllers.wheels([[2.0, 0.0], [0.0, 0.0]]), "outputs"),
        (lambda: controllers.reset(seed=-1), "seed: is -1"),
        (lambda: controllers.reset(keys=[1]), "keys: have the shape"),
    ]:
        with pytest.raises(oneiro.InputError, match=message):
            call()
    assert controllers.cycle == 0
