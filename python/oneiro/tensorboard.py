"""A callback for TensorBoard 2.15 and later."""

import json
import os
import time

from tensorboard.compat.proto.event_pb2 import Event
from tensorboard.compat.proto.summary_pb2 import Summary
from tensorboard.plugins.hparams.summary_v2 import hparams_pb
from tensorboard.summary.writer.event_file_writer import EventFileWriter

from . import _callbacks

__all__ = ["Callback"]


class Callback(_callbacks.Callback):
    """Writes each evolution's curves and hyperparameters to `folder/NAME`, for `tensorboard --logdir folder`."""

    def __init__(self, folder: str | os.PathLike[str] = "tensorboard") -> None:
        self._folder = folder

    def begin(self, name: str, settings: _callbacks.Settings, tags: _callbacks.Tags) -> None:
        self._writer = EventFileWriter(f"{os.fspath(self._folder)}/{name}")
        every = {**tags, **settings}.items()
        plain = {key: value if isinstance(value, (int, float, str)) else json.dumps(value) for key, value in every}
        self._writer.add_event(Event(summary=hparams_pb(plain), wall_time=time.time()))

    def generation(self, number: int, values: _callbacks.Values) -> None:
        scalars = [Summary.Value(tag=name, simple_value=value) for name, value in values.items()]
        self._writer.add_event(Event(summary=Summary(value=scalars), step=number, wall_time=time.time()))

    def end(self, files: _callbacks.Files, is_finished: bool) -> None:
        self._writer.close()
