"""Policies as genomes: the weights, and what they command."""

import numpy as np
import pytest

import oneiro
from oneiro import Layer


def network(inputs, sizes, activations, seed=1):
    """Layers of random weights."""
    generator = np.random.default_rng(seed)
    layers = []
    for units, activation in zip(sizes, activations, strict=True):
        weights = generator.normal(0, 1, (units, inputs)).astype(np.float32)
        layers.append(Layer(weights, generator.normal(0, 1, units).astype(np.float32), activation))
        inputs = units
    return layers


def acts(layers, readings):
    """What a policy does, in double precision."""
    functions = {
        "linear": lambda x: x,
        "tanh": np.tanh,
        "relu": lambda x: np.maximum(x, 0),
        "logistic": lambda x: 1 / (1 + np.exp(-x)),
    }
    values = np.asarray(readings, np.float64)
    for weights, biases, activation in layers:
        values = functions[activation](values @ weights.T.astype(np.float64) + biases)
    return np.clip(values, -1, 1)


def readings_of(exp):
    perceptron = exp.with_({"controller.kind": "perceptron"})
    return len(oneiro.Controller(perceptron, np.zeros(perceptron.genes)).inputs)


def compared(exp, layers):
    """The policy's experiment and genome, whose actions are the policy's."""
    made = exp.with_policy(layers)
    genome = made.genome_of(layers)
    assert made.genes == len(genome) and genome.dtype == np.float32
    back = made.layers_of(genome)
    assert [layer.activation for layer in back] == [layer.activation for layer in layers]
    for ours, theirs in zip(back, layers, strict=True):
        assert (ours.weights == theirs.weights).all() and (ours.biases == theirs.biases).all()
    readings = np.random.default_rng(3).uniform(0, 1, (50, layers[0].weights.shape[1]))
    controller = oneiro.Controller(made, np.tile(genome, (50, 1)))
    actions = 2 * controller.step(readings).astype(np.float64) - 1
    assert np.abs(actions - acts(layers, readings)).max() < 2e-5
    assert np.ptp(actions) > 0.5
    return made, genome


@pytest.mark.parametrize("hidden", ["linear", "tanh", "relu", "logistic"])
@pytest.mark.parametrize("last", ["linear", "tanh"])
def test_a_policy_is_its_genome(avoidance, hidden, last):
    compared(avoidance, network(8, [5, 4, 2], [hidden, hidden, last]))


def test_a_policy_without_hidden_layers(avoidance):
    compared(avoidance, network(8, [2], ["linear"]))


@pytest.mark.parametrize(
    "name", ["khepera-hidden", "kheperax", "homing", "light-switching", "aggregation", "evostick-network", "road-sign"]
)
def test_any_experiment_takes_a_policy(name):
    exp = oneiro.Experiment.example(name)
    made, genome = compared(exp, network(readings_of(exp), [6, 2], ["tanh", "linear"]))
    ours, theirs = (
        {key: value for key, value in one.settings.items() if not key.startswith(("controller.", "files."))}
        for one in (made, exp)
    )
    assert ours == theirs
    assert oneiro.evaluate(made, genome, seed=1, backend="cpu").fitness.shape == (1, 1)


def test_an_environment_by_a_policy_is_an_episode_of_its_genome(avoidance):
    from oneiro.gym import Env

    # It turns away from what its left sensors see, and from the right ones'.
    side = np.array([1, 1, 1, -1, -1, -1, 0, 0], np.float32)
    layers = [Layer(np.stack([side, -side]), np.full(2, 0.4, np.float32), "tanh")]
    made = avoidance.with_policy(layers)
    env = Env(avoidance)
    total, over = 0.0, False
    readings, _ = env.reset(seed=4)
    while not over:
        readings, reward, terminated, truncated, _ = env.step(acts(layers, readings))
        total, over = total + reward, terminated or truncated
    fitness = oneiro.evaluate(made, made.genome_of(layers), seed=4).fitness[0, 0]
    assert total == pytest.approx(fitness, rel=1e-3) and fitness > 0


def test_what_is_refused(avoidance):
    layers = network(8, [5, 2], ["tanh", "linear"])
    for wrong, message in [
        ([], "policy: has no layers"),
        ([1], r"policy\[0\]: is 1; allowed: Layer"),
        (network(8, [3], ["linear"]), "policy: has 3 outputs; allowed: 2"),
        (network(7, [2], ["linear"]), "policy: takes 7 readings; allowed: 8, left_90, "),
        (network(8, [2], ["relu"]), r"policy\[0\].activation: is 'relu'; allowed: linear, tanh"),
        (
            network(8, [5, 2], ["sin", "linear"]),
            r"policy\[0\].activation: is 'sin'; allowed: linear, tanh, relu, logistic",
        ),
        (
            [layers[0], network(4, [2], ["linear"])[0]],
            r"policy\[1\]: has weights and biases of \[2, 4\] and \[2\]; allowed: \[units, 5\]",
        ),
        ([layers[0]._replace(weights=[["a"]]), layers[1]], r"policy\[0\]: can't be made an array"),
        (object(), "policy: has object after 0 linear layers; allowed: Sequential, Linear, "),
    ]:
        with pytest.raises(oneiro.InputError, match=message):
            avoidance.with_policy(wrong)
    made = avoidance.with_policy(layers)
    with pytest.raises(
        oneiro.InputError, match=r"has another controller; allowed: policies of its shape, or exp.with_policy"
    ):
        made.genome_of(network(8, [4, 2], ["tanh", "linear"]))
    with pytest.raises(oneiro.InputError, match=r"genome: has the shape \[3\]; allowed: \[57\]"):
        made.layers_of([1, 2, 3])
    with pytest.raises(oneiro.InputError, match="isn't made of dense layers alone"):
        avoidance.layers_of(np.zeros(avoidance.genes))


def test_modules_of_torch(avoidance):
    torch = pytest.importorskip("torch")
    nn = torch.nn
    module = nn.Sequential(
        nn.Flatten(), nn.Sequential(nn.Linear(8, 6), nn.ReLU()), nn.Dropout(0.1), nn.Linear(6, 2, bias=False), nn.Tanh()
    ).eval()
    made = avoidance.with_policy(module)
    genome = made.genome_of(module)
    readings = np.random.default_rng(1).uniform(0, 1, (20, 8)).astype(np.float32)
    controller = oneiro.Controller(made, np.tile(genome, (20, 1)))
    with torch.no_grad():
        expected = module(torch.from_numpy(readings)).numpy()
    assert np.abs(2 * controller.step(readings) - 1 - expected).max() < 1e-6
    # And back.
    again = nn.Linear(8, 6)
    again.weight.data = torch.from_numpy(made.layers_of(genome)[0].weights)
    assert (again.weight == module[1][0].weight).all()
    with pytest.raises(oneiro.InputError, match="policy: has LayerNorm after 1 linear layers"):
        avoidance.with_policy(nn.Sequential(nn.Linear(8, 6), nn.LayerNorm(6), nn.Linear(6, 2)))


@pytest.mark.parametrize("algorithm", ["PPO", "A2C", "SAC", "TD3", "DDPG"])
def test_models_of_stable_baselines(avoidance, algorithm):
    sb3 = pytest.importorskip("stable_baselines3")
    from oneiro.gym import Env

    env = Env(avoidance)
    model = getattr(sb3, algorithm)("MlpPolicy", env, seed=1, device="cpu", policy_kwargs={"net_arch": [16, 8]})
    made = avoidance.with_policy(model)
    genome = made.genome_of(model)
    readings = np.random.default_rng(1).uniform(0, 1, (20, 8)).astype(np.float32)
    controller = oneiro.Controller(made, np.tile(genome, (20, 1)))
    expected, _ = model.predict(readings, deterministic=True)
    assert np.abs(2 * controller.step(readings) - 1 - expected).max() < 1e-5
    assert (made.genome_of(model.policy) == genome).all()
