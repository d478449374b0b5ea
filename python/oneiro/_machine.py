"""This machine's devices."""

from __future__ import annotations

from typing import Any

from . import _native
from ._errors import InputError
from ._experiment import whole


def devices() -> dict[str, Any]:
    """This machine's CPU and adapters, as `oneiro device list --json` prints them."""
    import json

    return json.loads(_native.devices())


def selftest(backend: str = "all", *, rollouts: int = 4000) -> dict[str, Any]:
    """Checks that this machine computes the same bits as every other; returns the report of `oneiro device test --json`.

    Its `passed` is whether all `checks` passed. `rollouts`, at least 1000, is the number of episodes of each controller. After
    Ctrl-C the call returns, and the test continues in the background.
    """
    if not 1000 <= whole("rollouts", rollouts) <= 1_000_000:
        raise InputError(f"rollouts: is {rollouts}; allowed: 1000 to 1000000")
    import json

    return json.loads(_native.selftest(backend, rollouts))
