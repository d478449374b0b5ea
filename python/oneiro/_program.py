"""The program `oneiro`, as the package's script starts it."""

from __future__ import annotations

import os
import signal
import sys

from . import _native


def main() -> int:
    """Does what the command line says. Returns the exit code, if it doesn't end the process."""
    # As for any program: Python itself would only note the signal.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(os.path.abspath(sys.argv[0]), ["oneiro", *sys.argv[1:]])
