"""This machine's devices."""

from __future__ import annotations

import json
from typing import Any

from . import _native


def devices() -> dict[str, Any]:
    """This machine's CPU and adapters, as `oneiro devices --json` prints them."""
    return json.loads(_native.devices())


def selftest(backend: str = "all") -> dict[str, Any]:
    """Checks that this machine computes the same bits as every other; returns the report of `oneiro selftest --json`.

    Its `passed` is whether all `checks` did. After Ctrl-C nobody waits for it, but it goes on in the background.
    """
    return json.loads(_native.selftest(backend))
