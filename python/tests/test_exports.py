"""Controllers as files for other programs."""

import sys

import numpy as np
import pytest
from conftest import EXPERIMENTS

import oneiro

# Experiments of all kinds of layers, activations and outputs.
NETWORKS = {
    "perceptron": {},
    "hidden": {"controller.kind": "hidden", "controller.units": 5},
    "recurrent": {"controller.kind": "recurrent"},
    "vehicle": {"controller.kind": "network", "controller.activation": "linear", "controller.interleaved": True},
    "step": {
        "controller.kind": "network",
        "controller.activation": "step",
        "controller.layers": [{"kind": "dense", "units": 3, "activation": "relu", "biases": False}],
    },
    "elman": {
        "controller.kind": "network",
        "controller.activation": "tanh",
        "controller.slope": 0.4,
        "controller.layers": [
            {"kind": "elman", "units": 4, "activation": "tanh", "slope": 0.7},
            {"kind": "dense", "units": 3, "activation": "linear"},
        ],
    },
    "ctrnn": {
        "controller.kind": "network",
        "controller.layers": [
            {"kind": "ctrnn", "units": 5, "time_constants_s": [0.2, 2.0]},
            {"kind": "ctrnn", "units": 3, "biases": False},
        ],
    },
    "lstm": {
        "controller.kind": "network",
        "controller.outputs": "first_two",
        "controller.layers": [{"kind": "dense", "units": 3}, {"kind": "lstm", "units": 4}],
    },
    "first": {
        "controller.kind": "network",
        "controller.outputs": "first_two",
        "controller.layers": [{"kind": "ctrnn", "units": 2}],
    },
}


def avoidance(values=None):
    return oneiro.Experiment.load(EXPERIMENTS / "khepera-avoidance.toml", set=values or {})


def random(exp, seed):
    low, high = exp.bounds.astype(np.float64).clip(-2, 2).T
    return np.random.default_rng(seed).uniform(low, high).astype(np.float32)


@pytest.mark.parametrize("name", NETWORKS)
def test_a_network_in_onnx_has_nearly_the_same_outputs(name, tmp_path):
    runtime = pytest.importorskip("onnxruntime")
    exp = avoidance(NETWORKS[name])
    genomes = [random(exp, seed) for seed in (1, 2)]
    rng = np.random.default_rng(7)
    for place, genome in enumerate(genomes):
        path = oneiro.Controller(exp, genome).export("onnx", tmp_path / f"{place}.onnx")
        session = runtime.InferenceSession(path, providers=["CPUExecutionProvider"])
        states = {one.name: np.zeros((3, one.shape[1]), np.float32) for one in session.get_inputs()}
        assert list(states)[0] == "readings" and states["readings"].shape == (3, 8)
        assert session.get_outputs()[0].name == "commands"
        controller = oneiro.Controller(exp, genome, robots=3)
        found = []
        for _ in range(60):
            states["readings"] = rng.uniform(0, 1, (3, 8)).astype(np.float32)
            outputs = dict(zip([one.name for one in session.get_outputs()], session.run(None, states), strict=True))
            expected = controller.step(states["readings"])
            found.append(expected)
            np.testing.assert_allclose(outputs["commands"], expected, atol=2e-5)
            states = {key: outputs.get(f"next_{key}", value) for key, value in states.items()}
        assert np.ptp(found) > 0.1


def test_a_network_that_learns_in_onnx_has_nearly_the_same_outputs(tmp_path):
    runtime = pytest.importorskip("onnxruntime")
    # More than one rule each, of all four.
    layers = [{"kind": "dense", "units": 3}, {"kind": "plastic", "units": 4, "slope": 1.5}]
    exp = avoidance({"controller.kind": "network", "controller.layers": layers})
    genome = random(exp, 3)
    path = oneiro.Controller(exp, genome).export("onnx", tmp_path / "learns.onnx")
    session = runtime.InferenceSession(path, providers=["CPUExecutionProvider"])
    shapes = {one.name: one.shape[1] for one in session.get_inputs()}
    assert shapes == {"readings": 8, "layer_1_unit": 4, "layer_1_strength": 28}
    controller = oneiro.Controller(exp, genome, robots=2)
    rng = np.random.default_rng(7)
    # The strengths that an episode begins with are drawn in its first cycle: here it goes on from the second.
    controller.step(rng.uniform(0, 1, (2, 8)).astype(np.float32))
    words = np.array(controller._native.__reduce__()[1][4], np.uint32)
    memory = words.reshape(2, -1)[:, 4:].copy().view(np.float32)
    states = {"layer_1_unit": memory[:, :4], "layer_1_strength": memory[:, 4:]}
    first = states["layer_1_strength"]
    for _ in range(60):
        states["readings"] = rng.uniform(0, 1, (2, 8)).astype(np.float32)
        outputs = dict(zip([one.name for one in session.get_outputs()], session.run(None, states), strict=True))
        np.testing.assert_allclose(outputs["commands"], controller.step(states["readings"]), atol=5e-5)
        states = {key: outputs.get(f"next_{key}", value) for key, value in states.items()}
    assert np.abs(states["layer_1_strength"] - first).max() > 0.1


def test_what_is_no_network_is_refused(tmp_path):
    machine = oneiro.Experiment.load(EXPERIMENTS / "automode-cues.toml")
    with pytest.raises(oneiro.InputError, match=r"is `state-machine`; allowed for onnx: perceptron"):
        oneiro.Controller(machine, random(machine, 1)).export("onnx", tmp_path / "machine.onnx")
    assert not list(tmp_path.iterdir())


def test_every_target_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    swarm = oneiro.Experiment.load(EXPERIMENTS / "evostick-aggregation.toml")
    controller = oneiro.Controller(swarm, random(swarm, 3), number=2)
    for to in ("c", "cpp", "arduino", "rust", "javascript", "python", "lua", "argos", "onnx", "ros2"):
        path = controller.export(to, f"{to}.lua" if to == "argos" else None, name=f"{to}_1", checks=4)
        assert path.exists() and path.is_dir() == (to in ("arduino", "ros2")), to
        # The same again is there already; another is not written over it.
        assert controller.export(to, path, name=f"{to}_1", checks=4) == path
        with pytest.raises(oneiro.InputError, match="exists"):
            controller.export(to, path, name=f"{to}_2", checks=4)
    monkeypatch.syspath_prepend(tmp_path)
    import python_1

    assert python_1.check() == 0
    del sys.modules["python_1"]
    readings = np.random.default_rng(1).uniform(0, 1, len(controller.inputs)).astype(np.float32)
    controller.reset()
    assert python_1.Controller().step(readings.tolist()) == controller.step(readings).tolist()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"to": "cobol"}, r"to: is \"cobol\"; allowed: c \("),
        ({"to": 3}, "to: is 3"),
        ({"to": "c", "name": "2b"}, 'name: is "2b"'),
        ({"to": "c", "name": 2}, "name: is 2"),
        ({"to": "c", "checks": 0}, "checks: is 0"),
        ({"to": "c", "checks": 1001}, "checks: is 1001"),
        ({"to": "c", "seed": -1}, "seed: is -1"),
        ({"to": "c", "with_": "sensors"}, "with_: is 'sensors'"),
        ({"to": "c", "with_": ["motors"]}, 'with_: has "motors"; allowed: sensors, task'),
        ({"to": "lua", "with_": ["task"]}, "with_: is not for lua; allowed for: c"),
        ({"to": "c", "out": "x.txt"}, "x.txt.*ends in .c"),
        ({"to": "webots"}, "robot: was sampled"),
    ],
)
def test_what_is_wrong_is_refused(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exp = avoidance()
    with pytest.raises(oneiro.InputError, match=message):
        oneiro.Controller(exp, random(exp, 1)).export(**arguments)
    assert not list(tmp_path.iterdir())


def test_one_genome_is_exported(tmp_path):
    exp = avoidance()
    with pytest.raises(oneiro.InputError, match="genomes: are 2; allowed: one"):
        oneiro.Controller(exp, [random(exp, 1), random(exp, 2)]).export("c", tmp_path / "two.c")


def test_the_world_is_exported_too(tmp_path):
    exp = avoidance()
    controller = oneiro.Controller(exp, random(exp, 1))
    path = controller.export("c", tmp_path / "both.c", with_=["sensors", "task"])
    assert "_check_world(void)" in path.read_text()
    alone = controller.export("c", tmp_path / "alone.c").read_text()
    assert "_world" not in alone
