"""Policies of other packages as genomes, and genomes as layers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from ._controller import Controller
from ._errors import InputError
from ._experiment import in_order, numbers

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._experiment import Table
    from ._native import Experiment

# Modules of torch, and what `controller.layers` calls them.
_ACTIVATIONS = {"Tanh": "tanh", "ReLU": "relu", "Sigmoid": "logistic"}
# Modules that change nothing once a policy is trained.
_IDLE = ("Dropout", "Flatten", "Identity")
# Activations of a policy's last layer, whose outputs are actions, -1 to 1.
_OF_ACTIONS = ("linear", "tanh")
# Activations of a network's outputs.
_OF_OUTPUTS = ("linear", "tanh", "relu", "logistic")
_DEFAULT_ACTIVATION = "logistic"
# Values of a network that leave it with dense layers and weighted outputs.
_DEFAULTS = {
    "controller.outputs": "weighted",
    "controller.slope": 1.0,
    "controller.biases": True,
    "controller.interleaved": False,
}
# Of a network.
_MOST_GENES = 65536


class Layer(NamedTuple):
    """Units that each apply a function to the weighted sum of all outputs of the layer before."""

    weights: NDArray[np.float32]
    """`[units, inputs]`"""
    biases: NDArray[np.float32]
    """`[units]`"""
    activation: str
    """`linear`, `tanh`, `relu` or `logistic`; of the last layer `linear`, clipped to -1 to 1, or `tanh`"""


def with_policy(exp: Experiment, policy: Any) -> Experiment:
    """The experiment with a policy's network as its controller. Called by `Experiment.with_policy`."""
    layers = _layers(policy, _OF_ACTIONS)
    own = exp.settings
    if any(key.startswith("swarm.") for key in own):
        raise InputError(
            f"{exp.name}: is of the foraging study, whose controllers have two genes; allowed: other experiments"
        )
    genes = sum(layer.weights.size + layer.biases.size for layer in layers)
    if genes > _MOST_GENES:
        raise InputError(
            f'policy: has {genes} weights; allowed: {_MOST_GENES}, such as policy_kwargs={{"net_arch": [128, 128]}}'
        )
    values = _settings(layers)
    if own.get("controller.kind") == "network":
        # The experiment's network may have other values.
        values |= {key: value for key, value in _DEFAULTS.items() if key in own}
    made = exp.with_(values)
    readings = [one.name for one in Controller(made, [0.0] * made.genes).inputs]
    inputs = layers[0].weights.shape[1]
    if inputs != len(readings):
        raise InputError(f"policy: takes {inputs} readings; allowed: {len(readings)}, {', '.join(readings)}")
    return made


def genome_of(exp: Experiment, policy: Any) -> NDArray[np.float32]:
    """A policy's weights as a genome. Called by `Experiment.genome_of`."""
    import numpy as np

    layers = _layers(policy, _OF_OUTPUTS)
    # Each unit's weights, then its bias.
    genome = np.concatenate([np.c_[layer.weights, layer.biases].ravel() for layer in layers])
    if _settings(layers) != _network(exp) or len(genome) != exp.genes:
        raise InputError(
            f"policy: {exp.name} has another controller; allowed: policies of its shape, or exp.with_policy(policy)"
        )
    return genome


def layers_of(exp: Experiment, genome: ArrayLike | Table) -> list[Layer]:
    """A genome's layers. Called by `Experiment.layers_of`."""
    network = _network(exp)
    if network is None:
        raise InputError(
            f"{exp.name}: its controller isn't made of dense layers alone; allowed: those of exp.with_policy"
        )
    rest = in_order(exp, genome)
    if rest.shape != (exp.genes,):
        raise InputError(f"genome: has the shape {list(rest.shape)}; allowed: [{exp.genes}]")
    inputs = len(Controller(exp, rest).inputs)
    units = [(layer["units"], layer["activation"]) for layer in network.get("controller.layers", [])]
    found = []
    for count, activation in [*units, (2, network["controller.activation"])]:
        rows, rest = rest[: count * (inputs + 1)].reshape(count, inputs + 1), rest[count * (inputs + 1) :]
        found.append(Layer(rows[:, :-1].copy(), rows[:, -1].copy(), activation))
        inputs = count
    return found


def _settings(layers: list[Layer]) -> dict[str, Any]:
    """The values of a network of these layers."""
    values: dict[str, Any] = {"controller.kind": "network", "controller.activation": layers[-1].activation}
    hidden = [{"kind": "dense", "units": len(own.biases), "activation": own.activation} for own in layers[:-1]]
    return values | ({"controller.layers": hidden} if hidden else {})


def _network(exp: Experiment) -> dict[str, Any] | None:
    """The values of its network, with the activations that are their defaults; None if it has more than dense layers."""
    own: dict[str, Any] = {"controller.activation": _DEFAULT_ACTIVATION}
    own |= {key: value for key, value in exp.settings.items() if key.startswith("controller.")}
    own = {key: value for key, value in own.items() if value != _DEFAULTS.get(key)}
    layers = [{"activation": _DEFAULT_ACTIVATION} | layer for layer in own.pop("controller.layers", [])]
    is_plain = all(set(layer) == {"kind", "units", "activation"} and layer["kind"] == "dense" for layer in layers)
    if own.get("controller.kind") != "network" or len(own) > 2 or not is_plain:
        return None
    return own | ({"controller.layers": layers} if layers else {})


def _layers(policy: Any, of_outputs: tuple[str, ...]) -> list[Layer]:
    """The layers of a trained model of Stable-Baselines3, of a module of torch, or of a list of `Layer`."""
    import numpy as np

    if isinstance(policy, (list, tuple)):
        given = list(policy)
    elif _is_of(policy, "stable_baselines3", "sb3_contrib"):
        given = _of_baselines(policy)
    elif _is_of(policy, "torch"):
        given = _of_torch([policy])
    else:
        raise InputError(
            f"policy: is {policy!r}; allowed: a model of Stable-Baselines3, a module of torch, or a list of Layer"
        )
    if not given:
        raise InputError("policy: has no layers; allowed: at least one linear layer")
    found: list[Layer] = []
    for place, layer in enumerate(given):
        name = f"policy[{place}]"
        if not isinstance(layer, Layer):
            raise InputError(f"{name}: is {layer!r}; allowed: Layer(weights, biases, activation)")
        with np.errstate(over="ignore"):
            weights, biases = (numbers(name, values, np.float32) for values in layer[:2])
        allowed = of_outputs if place == len(given) - 1 else ("linear", *_ACTIVATIONS.values())
        if layer.activation not in allowed:
            raise InputError(f"{name}.activation: is {layer.activation!r}; allowed: {', '.join(allowed)}")
        inputs: Any = len(found[-1].biases) if found else "inputs"
        if weights.ndim != 2 or biases.shape != weights.shape[:1] or (found and weights.shape[1] != inputs):
            shapes = f"{list(weights.shape)} and {list(biases.shape)}"
            raise InputError(f"{name}: has weights and biases of {shapes}; allowed: [units, {inputs}] and [units]")
        if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
            raise InputError(f"{name}: has weights or biases that aren't finite; allowed: finite numbers")
        found.append(Layer(weights, biases, layer.activation))
    if len(found[-1].biases) != 2:
        raise InputError(f"policy: has {len(found[-1].biases)} outputs; allowed: 2, the left and the right motor")
    return found


def _is_of(thing: Any, *packages: str) -> bool:
    """Whether a class of these packages is among its own. Nothing of theirs is imported: whoever has a policy has imported it."""
    return any(base.__module__.split(".")[0] in packages for base in type(thing).__mro__)


def _of_baselines(model: Any) -> list[Layer]:
    """The layers of `model.predict(.., deterministic=True)`."""
    normalised = getattr(model, "get_vec_normalize_env", lambda: None)()
    if normalised is not None:
        raise InputError(
            "policy: was trained with VecNormalize, which changes readings; allowed: models of plain readings"
        )
    policy = getattr(model, "policy", model)
    space = policy.action_space
    if type(space).__name__ != "Box" or space.shape != (2,) or not ((space.low == -1) & (space.high == 1)).all():
        raise InputError(f"policy: its actions are {space}; allowed: those of Oneiro's environments, Box(-1, 1, (2,))")
    actor: Any = getattr(policy, "actor", None)
    if hasattr(policy, "action_net"):
        # PPO and A2C: the mean of a normal distribution. Subclasses may have other layers.
        known, parts = policy.mlp_extractor, [policy.pi_features_extractor, policy.action_net]
        if type(known).__name__ != "MlpExtractor" or not _is_of(known, "stable_baselines3"):
            raise InputError(f"policy: has {type(known).__name__}; allowed: Stable-Baselines3's own MlpExtractor")
        parts[1:1] = [known.policy_net]
        is_squashed = bool(policy.squash_output)
    elif hasattr(actor, "latent_pi"):
        # SAC and TQC squash the mean.
        parts, is_squashed = [actor.features_extractor, actor.latent_pi, actor.mu], True
    elif hasattr(actor, "mu"):
        # TD3 and DDPG.
        parts, is_squashed = [actor.features_extractor, actor.mu], False
    else:
        raise InputError(f"policy: is a {type(policy).__name__}; allowed: of PPO, A2C, SAC, TQC, TD3 and DDPG")
    extractor = parts.pop(0)
    if type(extractor).__name__ != "FlattenExtractor" or len(policy.observation_space.shape) != 1:
        raise InputError(f"policy: has {type(extractor).__name__}; allowed: unchanged readings, by FlattenExtractor")
    layers = _of_torch(parts)
    if is_squashed and layers:
        layers[-1] = layers[-1]._replace(activation="tanh")
    return layers


def _of_torch(modules: Iterable[Any]) -> list[Layer]:
    import torch

    found: list[Layer] = []
    for module in _flat(modules):
        kind = type(module)
        name = kind.__name__
        if getattr(torch.nn, name, None) is not kind:
            name = f"{kind.__module__}.{name}"
        if module._forward_hooks or module._forward_pre_hooks:
            raise InputError(
                f"policy: {name} has hooks, which may change what it computes; allowed: modules without any"
            )
        if name == "Linear":
            try:
                weights = module.weight.detach().cpu().float().numpy()
                biases = 0 * weights.sum(1) if module.bias is None else module.bias.detach().cpu().float().numpy()
            except (TypeError, RuntimeError, NotImplementedError) as error:
                raise InputError(f"policy: a layer's weights can't be read ({error}); allowed: dense tensors") from None
            found.append(Layer(weights, biases, "linear"))
        elif name in _ACTIVATIONS and found and found[-1].activation == "linear":
            found[-1] = found[-1]._replace(activation=_ACTIVATIONS[name])
        elif name not in _IDLE:
            allowed = ", ".join(["Sequential", "Linear", *_ACTIVATIONS, *_IDLE])
            raise InputError(f"policy: has {name} after {len(found)} linear layers; allowed: {allowed}")
    return found


def _flat(modules: Iterable[Any]) -> Iterator[Any]:
    """Modules in the order in which they are called: one may be called twice."""
    import torch

    for module in modules:
        if type(module) is torch.nn.Sequential and not (module._forward_hooks or module._forward_pre_hooks):
            yield from _flat(module)
        else:
            yield module
