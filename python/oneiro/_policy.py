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
# What the last layer may apply: its outputs are actions, -1 to 1.
_OF_OUTPUTS = ("linear", "tanh")


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
    layers = _layers(policy)
    values: dict[str, Any] = {"controller.kind": "network", "controller.activation": layers[-1].activation}
    if len(layers) > 1:
        values["controller.layers"] = [
            {"kind": "dense", "units": len(layer.biases), "activation": layer.activation} for layer in layers[:-1]
        ]
    # First another kind, so that nothing is left of a network that the experiment has.
    made = exp.with_({"controller.kind": "perceptron"}).with_(values)
    readings = [one.name for one in Controller(made, [0.0] * made.genes).inputs]
    inputs = layers[0].weights.shape[1]
    if inputs != len(readings):
        raise InputError(f"policy: takes {inputs} readings; allowed: {len(readings)}, {', '.join(readings)}")
    return made


def genome_of(exp: Experiment, policy: Any) -> NDArray[np.float32]:
    """A policy's weights as a genome. Called by `Experiment.genome_of`."""
    import numpy as np

    layers = _layers(policy)
    if _controller(with_policy(exp, layers)) != _controller(exp):
        raise InputError(
            f"policy: {exp.name} has another controller; allowed: policies of its shape, or exp.with_policy(policy)"
        )
    # Each unit's weights, then its bias.
    return np.concatenate([np.c_[layer.weights, layer.biases].ravel() for layer in layers])


def layers_of(exp: Experiment, genome: ArrayLike | Table) -> list[Layer]:
    """A genome's layers. Called by `Experiment.layers_of`."""
    own = exp.settings
    hidden = own.get("controller.layers", [])
    last = own.get("controller.activation", "logistic")
    kept = {"controller.kind", "controller.activation", "controller.layers"}
    plain = all(set(layer) <= {"kind", "units", "activation"} and layer["kind"] == "dense" for layer in hidden)
    if own.get("controller.kind") != "network" or not plain or set(_controller(exp)) - kept:
        raise InputError(
            f"{exp.name}: its controller isn't made of dense layers alone; allowed: those of exp.with_policy"
        )
    rest = in_order(exp, genome)
    if rest.shape != (exp.genes,):
        raise InputError(f"genome: has the shape {list(rest.shape)}; allowed: [{exp.genes}]")
    inputs = len(Controller(exp, rest).inputs)
    found = []
    for units, activation in [*((one["units"], one.get("activation", "logistic")) for one in hidden), (2, last)]:
        rows, rest = rest[: units * (inputs + 1)].reshape(units, inputs + 1), rest[units * (inputs + 1) :]
        found.append(Layer(rows[:, :-1].copy(), rows[:, -1].copy(), activation))
        inputs = units
    return found


def _controller(exp: Experiment) -> dict[str, Any]:
    return {key: value for key, value in exp.settings.items() if key.startswith("controller.")}


def _layers(policy: Any) -> list[Layer]:
    """The layers of a trained model of Stable-Baselines3, of a module of torch, or of a list of `Layer`."""
    import numpy as np

    given = policy if isinstance(policy, (list, tuple)) else _from_torch(_flat(_modules(policy)))
    if not given:
        raise InputError("policy: has no layers; allowed: at least one linear layer")
    found: list[Layer] = []
    for place, layer in enumerate(given):
        name = f"policy[{place}]"
        if not isinstance(layer, Layer):
            raise InputError(f"{name}: is {layer!r}; allowed: Layer(weights, biases, activation)")
        weights, biases = (numbers(name, values, np.float32) for values in layer[:2])
        allowed = _OF_OUTPUTS if place == len(given) - 1 else ("linear", *_ACTIVATIONS.values())
        if layer.activation not in allowed:
            raise InputError(f"{name}.activation: is {layer.activation!r}; allowed: {', '.join(allowed)}")
        inputs: Any = len(found[-1].biases) if found else "inputs"
        if weights.ndim != 2 or biases.shape != weights.shape[:1] or (found and weights.shape[1] != inputs):
            shapes = f"{list(weights.shape)} and {list(biases.shape)}"
            raise InputError(f"{name}: has weights and biases of {shapes}; allowed: [units, {inputs}] and [units]")
        found.append(Layer(weights, biases, layer.activation))
    if len(found[-1].biases) != 2:
        raise InputError(f"policy: has {len(found[-1].biases)} outputs; allowed: 2, the left and the right motor")
    return found


def _modules(policy: Any) -> list[Any]:
    """The modules that observations pass, in order. Nothing of torch is imported: whoever has a policy has imported it."""
    policy = getattr(policy, "policy", policy)
    actor = getattr(policy, "actor", None)
    if hasattr(policy, "action_net"):
        # PPO and A2C: the mean of a normal distribution.
        return [policy.mlp_extractor.policy_net, policy.action_net]
    if hasattr(actor, "latent_pi"):
        # SAC and TQC squash the mean.
        return [actor.latent_pi, actor.mu, "Tanh"]
    # TD3 and DDPG, or a module.
    return [policy if actor is None else actor.mu]


def _flat(modules: Iterable[Any]) -> Iterator[Any]:
    for module in modules:
        if type(module).__name__ == "Sequential":
            yield from _flat(module.children())
        else:
            yield module


def _from_torch(modules: Iterable[Any]) -> list[Layer]:
    found: list[Layer] = []
    for module in modules:
        kind = module if isinstance(module, str) else type(module).__name__
        if kind == "Linear":
            weights = module.weight.detach().cpu().numpy()
            biases = 0 * weights[:, 0] if module.bias is None else module.bias.detach().cpu().numpy()
            found.append(Layer(weights, biases, "linear"))
        elif kind in _ACTIVATIONS and found and found[-1].activation == "linear":
            found[-1] = found[-1]._replace(activation=_ACTIVATIONS[kind])
        elif kind not in _IDLE:
            allowed = ", ".join(["Sequential", "Linear", *_ACTIVATIONS, *_IDLE])
            raise InputError(f"policy: has {kind} after {len(found)} linear layers; allowed: {allowed}")
    return found
