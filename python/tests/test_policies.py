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
    "name",
    [
        "khepera-hidden",
        "kheperax",
        "homing",
        "light-switching",
        "aggregation",
        "evostick-network",
        "road-sign",
    ],
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
        (
            object(),
            "policy: is <object .*; allowed: a model of Stable-Baselines3, a module of torch, or a list of Layer",
        ),
        (
            [layers[0]._replace(biases=[0, 0, 0, np.nan, 0]), layers[1]],
            r"policy\[0\]: has weights or biases that aren't finite",
        ),
        (network(8, [300, 300, 2], ["tanh", "tanh", "linear"]), r"policy: has 93602 weights; allowed: 65536"),
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


def test_an_experiment_may_need_so_many_genes():
    """Here `initial_shares` has a number for each gene."""
    exp = oneiro.Experiment.example("kheperax-elites")
    compared(exp, network(5, [8, 2], ["tanh", "linear"]))
    with pytest.raises(oneiro.InputError, match="initial_shares: has 66 numbers"):
        exp.with_policy(network(5, [7, 2], ["tanh", "linear"]))


def test_a_networks_genome_is_its_layers(avoidance):
    """Also of a network with other activations than a policy's, which no policy can become."""
    exp = avoidance.with_({"controller.kind": "network", "controller.layers": [{"kind": "dense", "units": 3}]})
    genome = np.random.default_rng(1).normal(0, 1, exp.genes).astype(np.float32)
    layers = exp.layers_of(genome)
    assert [layer.activation for layer in layers] == ["logistic", "logistic"]
    assert (exp.genome_of(layers) == genome).all()
    with pytest.raises(oneiro.InputError, match="is 'logistic'; allowed: linear, tanh"):
        exp.with_policy(layers)


def test_an_adopted_policy_is_read_again(avoidance, tmp_path):
    layers = network(8, [5, 2], ["tanh", "linear"])
    made = avoidance.with_policy(layers)
    oneiro.adopt(made, made.genome_of(layers), seed=1, out=tmp_path / "run", trials=2)
    again = oneiro.load_run(tmp_path / "run")
    assert (again.experiment.genome_of(layers) == again.champion.genome).all()
    assert (again.experiment.layers_of(again.champion.genome)[0].weights == layers[0].weights).all()


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
    # One activation for several layers.
    act = nn.Tanh()
    shared = nn.Sequential(nn.Linear(8, 6), act, nn.Linear(6, 5), act, nn.Linear(5, 2), act)
    assert [layer.activation for layer in made.with_policy(shared).layers_of(np.zeros(101))] == ["tanh"] * 3
    named = nn.Sequential()
    named.add_module("policy", nn.Linear(8, 2))
    named.add_module("actor", nn.Tanh())
    assert made.with_policy(named).settings["controller.activation"] == "tanh"
    hooked = nn.Sequential(nn.Linear(8, 2))
    hooked[0].register_forward_hook(lambda module, given, output: 2 * output)

    class Linear(nn.Linear):
        """Of another package."""

    for wrong, message in [
        (hooked, "Linear has hooks"),
        (nn.Sequential(Linear(8, 2)), r"policy: has \S+Linear after 0 linear layers"),
        (nn.Sequential(nn.Linear(8, 2, device="meta")), "weights can't be read"),
    ]:
        with pytest.raises(oneiro.InputError, match=message):
            avoidance.with_policy(wrong)
    half = nn.Sequential(nn.Linear(8, 2)).to(torch.bfloat16)
    assert avoidance.with_policy(half).genes == 18
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


def test_what_changes_readings_or_actions_is_refused_or_kept(avoidance):
    sb3 = pytest.importorskip("stable_baselines3")
    import gymnasium
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    from oneiro.gym import Env

    env = Env(avoidance)
    readings = np.random.default_rng(1).uniform(0, 1, (20, 8)).astype(np.float32)
    small = {"net_arch": [8]}
    squashed = sb3.PPO(
        "MlpPolicy", env, use_sde=True, seed=1, device="cpu", policy_kwargs=small | {"squash_output": True}
    )
    squashed.policy.action_net.weight.data *= 100
    made = avoidance.with_policy(squashed)
    commands = oneiro.Controller(made, np.tile(made.genome_of(squashed), (20, 1))).step(readings)
    assert np.abs(2 * commands - 1 - squashed.predict(readings, deterministic=True)[0]).max() < 1e-5

    class Doubled(BaseFeaturesExtractor):
        def __init__(self, space):
            super().__init__(space, 8)

        def forward(self, values):
            return 2 * values

    wider = gymnasium.wrappers.RescaleAction(env, np.float32(-2), np.float32(2))
    for model, message in [
        (
            sb3.PPO("MlpPolicy", env, policy_kwargs=small | {"features_extractor_class": Doubled}),
            "has Doubled; allowed",
        ),
        (
            sb3.TD3("MlpPolicy", env, policy_kwargs=small | {"features_extractor_class": Doubled}),
            "has Doubled; allowed",
        ),
        (sb3.PPO("MlpPolicy", wider, policy_kwargs=small), r"its actions are Box\(-2.0, 2.0"),
        (sb3.PPO("MlpPolicy", VecNormalize(DummyVecEnv([lambda: env])), policy_kwargs=small), "with VecNormalize"),
        (sb3.SAC("MlpPolicy", env), r"policy: has \d+ weights; allowed: 65536"),
    ]:
        with pytest.raises(oneiro.InputError, match=message):
            avoidance.with_policy(model)
