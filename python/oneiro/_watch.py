"""For notebooks: runs and sweeps while they evolve."""

from __future__ import annotations

import html
import importlib
import os
import threading
import time
from typing import Any

from . import _native
from ._errors import Error, InputError, StoppedError
from ._html import frame
from ._runs import Run, Sweep

_PLAYED = 25.0
"""Seconds in which pages play an episode."""


class Watch:
    """What `watch` shows. A thread updates it until the runs have ended or `stop` is called; as a context, until its end."""

    def __init__(self, dirs: list[str], every: float) -> None:
        place = _notebook()
        self._native = _native.View(dirs)
        self._every = every
        self._places = [place(), place()]
        self._is_stopped = threading.Event()
        self._has_ended = threading.Event()
        threading.Thread(target=self._update, name="oneiro.watch", daemon=True).start()

    def stop(self) -> None:
        """Shows what is newest and ends. Runs continue."""
        self._is_stopped.set()
        try:
            # If Ctrl-C interrupts a thread's `join`, older versions of Python take it for ended.
            self._has_ended.wait()
        finally:
            # Unless this was interrupted, nothing is simulated any more.
            self._native.stop()

    def wait(self) -> None:
        """Waits until the runs have ended. Ctrl-C, or interrupting the kernel, ends only the watch."""
        try:
            self._has_ended.wait()
        finally:
            self.stop()

    def __enter__(self) -> Watch:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _ipython_display_(self) -> None:
        """It is shown already."""

    def _update(self) -> None:
        try:
            self._show()
        finally:
            self._has_ended.set()

    def _show(self) -> None:
        shown = ["", ""]

        def show(place: int, text: str) -> None:
            if text != shown[place]:
                shown[place] = text
                self._places[place](text)

        seen, began = "", float("-inf")
        while True:
            # The last look comes after the end.
            is_last = self._is_stopped.is_set()
            have_ended, curve, tables = self._native.look()
            is_last |= have_ended
            drawn = curve.replace("<svg ", "<svg style='max-width:100%;height:auto' ", 1)
            show(0, f"<div style='overflow-x:auto'>{drawn}{tables}</div>")
            # An episode that is replaced begins anew: it plays to its end first.
            if is_last or curve != seen and time.monotonic() - began >= _PLAYED:
                seen = curve
                if page := self._page():
                    show(1, page)
                    began = time.monotonic()
            if is_last:
                return
            self._is_stopped.wait(self._every)

    def _page(self) -> str:
        try:
            episode = self._native.episode()
        except StoppedError:
            return ""
        except Error as error:
            return f"<p>{html.escape(str(error))}</p>"
        if episode is None:
            return ""
        words, page = episode
        return f"<p>{words}</p>" + frame("The newest best's episode", page)


def _notebook() -> Any:
    """A function that adds a place to the cell's output, and returns a function that sets its HTML."""
    try:
        shell = importlib.import_module("IPython").get_ipython()
    except ModuleNotFoundError:
        shell = None
    if not hasattr(shell, "kernel"):
        raise InputError(
            "watch: this is no notebook; allowed: Jupyter and the like; elsewhere `oneiro watch DIR` in a terminal"
        )
    display = importlib.import_module("IPython.display")

    def place() -> Any:
        handle = display.display(display.HTML(""), display_id=True)
        return lambda text: handle.update(display.HTML(text))

    return place


def watch(*dirs: str | os.PathLike[str] | Run | Sweep, every: float = 2.0) -> Watch:
    """Shows the learning curve, the newest best's episode and a table of runs and sweeps in a notebook while they evolve.

    The directories may appear later, and hold several. By default they are `runs` and `sweeps`. The cell's output is updated at most
    once in `every` seconds, and needs no connection but the notebook's. An episode is replaced once it could be seen.
    """
    if not every >= 0.1:
        raise InputError(f"every: is {every}; allowed: seconds, 0.1 and more")
    paths = [one.path if isinstance(one, (Run, Sweep)) else one for one in dirs]
    return Watch([os.fspath(path) for path in paths] or ["runs", "sweeps"], every)
