"""Progress bars, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def bar(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """Yields a function that takes the robot-steps done and in all; None without tqdm or a terminal.

    tqdm is only imported once there is something to show, after some 50 ms of work.
    """
    if not sys.stderr.isatty() and "ipykernel" not in sys.modules:
        yield None
        return
    shown = None

    def show(done: int, total: int) -> None:
        nonlocal shown
        if shown is None:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                shown = False
            else:
                shown = tqdm(total=total or None, desc=label, unit="step", unit_scale=True, leave=False)
        if shown is not False:
            shown.total = total or None
            shown.update(min(done, total or done) - shown.n)

    try:
        yield show
    finally:
        if shown:
            shown.close()
