"""A callback for Weights & Biases, `wandb` 0.20 and later."""

from typing import Any

import wandb

from . import _callbacks

__all__ = ["Callback"]


class Callback(_callbacks.Callback):
    """Logs each evolution as a run. `init` are arguments of `wandb.init`, such as `project`, by default `"oneiro"`, or `mode`."""

    def __init__(self, **init: Any) -> None:
        self._init = {"project": "oneiro", "reinit": "create_new", **init}

    def begin(self, name: str, settings: _callbacks.Settings, tags: _callbacks.Tags) -> None:
        # W&B's tags have 64 characters at most.
        short = [f"{key}-{value[:12]}" for key, value in tags.items()]
        self._run = wandb.init(**{"name": name, "config": {**tags, **settings}, "tags": short, **self._init})

    def generation(self, number: int, values: _callbacks.Values) -> None:
        self._run.log(dict(values), step=number)

    def end(self, files: _callbacks.Files, is_finished: bool) -> None:
        if files:
            artifact = wandb.Artifact(f"oneiro-{self._run.id}", type="run")
            for path in files:
                artifact.add_file(str(path))
            self._run.log_artifact(artifact)
        self._run.finish(exit_code=0 if is_finished else 1)
