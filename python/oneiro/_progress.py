"""Progress bars, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
import importlib
import sys
from collections.abc import Callable, Iterator
from typing import Any


@contextlib.contextmanager
def bar(label: str, update: Callable[[], None] | None = None) -> Iterator[Callable[[int, int], None] | None]:
    """Yields a function that takes the robot-steps done and in all, and also calls `update`; None if it has nothing to do.

    tqdm is only imported once there is something to show, after about 50 ms of work.
    """
    if not sys.stderr.isatty() and "ipykernel" not in sys.modules:
        yield None if update is None else lambda *_: update()
        return
    shown: Any = None

    def show(done: int, total: int) -> None:
        nonlocal shown
        if update is not None:
            update()
        if shown is None:
            try:
                make = importlib.import_module("tqdm.auto").tqdm
            except ImportError:
                shown = False
            else:
                shown = make(total=total or None, desc=label, unit="step", unit_scale=True, leave=False)
        if shown is not False:
            shown.total = total or None
            shown.update(min(done, total or done) - shown.n)

    try:
        yield show
    finally:
        # A bar of no steps counts as false.
        if shown is not None and shown is not False:
            shown.close()
