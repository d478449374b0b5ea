"""A callback for MLflow 2.14 and later."""

import time
from typing import Any

import mlflow
from mlflow.entities import Metric

from . import _callbacks

__all__ = ["Callback"]


class Callback(_callbacks.Callback):
    """Logs each evolution as a run, within yours if there is one. `start` are arguments of `mlflow.start_run`."""

    def __init__(self, **start: Any) -> None:
        self._start, self._waiting, self._sent = start, list[Metric](), 0.0

    def begin(self, name: str, settings: _callbacks.Settings, tags: _callbacks.Tags) -> None:
        self._run = mlflow.start_run(**{"run_name": name, "nested": True, "tags": dict(tags), **self._start})
        mlflow.log_params(dict(settings))

    def generation(self, number: int, values: _callbacks.Values) -> None:
        now = time.time()
        # They are sent together: a request takes longer than many a generation.
        self._waiting += [Metric(name, value, int(1000 * now), number) for name, value in values.items()]
        if now - self._sent >= 1:
            self._send()

    def _send(self) -> None:
        mlflow.MlflowClient().log_batch(self._run.info.run_id, metrics=self._waiting)
        self._waiting, self._sent = [], time.time()

    def end(self, files: _callbacks.Files, is_finished: bool) -> None:
        self._send()
        for path in files:
            mlflow.log_artifact(str(path))
        mlflow.end_run("FINISHED" if is_finished else "KILLED")
