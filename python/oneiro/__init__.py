"""Evolves robot controllers in simulation; the same seed gives the same bits on every device.

Fitness is maximised. Random numbers depend on seeds only, so the same call gives the same bits on every machine.
`docs/python.md` in the repository describes the whole interface.
"""

from __future__ import annotations

import importlib
import os as _os
from typing import TYPE_CHECKING

# Mesa's device-select layer prints to standard error where there is no desktop, and its order is not needed.
_os.environ.setdefault("NODEVICE_SELECT", "1")

from ._archive import Archive
from ._arena import Arena
from ._callbacks import Callback, log_loop, log_runs
from ._controller import Controller
from ._errors import (
    BrokenError,
    CorruptError,
    DeviceError,
    Error,
    FailedError,
    InputError,
    ShortMemoryError,
    StoppedError,
    StorageError,
)
from ._evolution import Evolution
from ._experiment import Experiment, Outcome, evaluate
from ._machine import devices, selftest
from ._native import __version__
from ._policy import Layer
from ._recorder import Recorder
from ._replay import Replay, replay
from ._runs import Run, Sweep, adopt, load_run, merge, resume, run, sweep, sweep_shard
from ._watch import Watch, watch

if TYPE_CHECKING:
    from . import gym, mlflow, pettingzoo, plot, sb3, tensorboard, wandb

__all__ = [
    "Archive",
    "Arena",
    "BrokenError",
    "Callback",
    "Controller",
    "CorruptError",
    "DeviceError",
    "Error",
    "Evolution",
    "Experiment",
    "FailedError",
    "InputError",
    "Layer",
    "Outcome",
    "Recorder",
    "Replay",
    "Run",
    "ShortMemoryError",
    "StorageError",
    "StoppedError",
    "Sweep",
    "Watch",
    "__version__",
    "adopt",
    "devices",
    "evaluate",
    "gym",
    "load_run",
    "log_loop",
    "log_runs",
    "merge",
    "mlflow",
    "pettingzoo",
    "plot",
    "replay",
    "resume",
    "run",
    "sb3",
    "selftest",
    "sweep",
    "sweep_shard",
    "tensorboard",
    "wandb",
    "watch",
]

# Modules that need packages of others are imported when they are first used.
_NEEDS = {
    "gym": "pip install 'gymnasium>=1.1'",
    "mlflow": "pip install 'mlflow>=2.14'",
    "pettingzoo": "pip install 'gymnasium>=1.1' 'pettingzoo>=1.25'",
    "plot": "pip install matplotlib",
    "sb3": "pip install 'gymnasium>=1.1' 'stable-baselines3>=2.6'",
    "tensorboard": "pip install 'tensorboard>=2.15'",
    "wandb": "pip install 'wandb>=0.20'",
}


def __getattr__(name: str) -> object:
    if name in _NEEDS:
        try:
            return importlib.import_module(f"oneiro.{name}")
        except ModuleNotFoundError as error:
            if (error.name or "").startswith("oneiro"):
                raise
            # So `help(oneiro)` leaves it out.
            raise AttributeError(f"oneiro.{name} needs {error.name}, which is not installed: {_NEEDS[name]}") from error
    raise AttributeError(f"module 'oneiro' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


# Users see one module, in reprs, in tracebacks and in pickles.
for _name in __all__:
    _value = globals().get(_name)
    if str(getattr(_value, "__module__", "")).startswith("oneiro._"):
        _value.__module__ = "oneiro"
del _name, _value
