"""What all tests use: the experiments that ship, and the program."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import oneiro

ROOT = Path(__file__).resolve().parents[2]
EXPERIMENTS = ROOT / "experiments"
AVOIDANCE = EXPERIMENTS / "khepera-avoidance.toml"
PROGRAM = os.environ["ONEIRO_PROGRAM"]


def program(*arguments):
    """The program's standard output."""
    command = [PROGRAM, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def refusal(*arguments):
    """The program's exit code, and its message without `oneiro: `."""
    command = [PROGRAM, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.strip().removeprefix("oneiro: ")


def interrupted(code, *arguments, after):
    """What a script that prints `begun` prints after that, if Ctrl-C is pressed some seconds later; and how long it takes then."""
    command = [sys.executable, "-c", code, *map(str, arguments)]

    def heeds_control_c():
        # Background jobs of shells ignore it, and so would their children.
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=heeds_control_c) as process:
        try:
            assert process.stdout.readline() == "begun\n"
            time.sleep(after)
            began = time.monotonic()
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 0
    return rest, time.monotonic() - began


@pytest.fixture
def avoidance():
    return oneiro.Experiment.load(AVOIDANCE, set={"cycles": 60})


@pytest.fixture
def own():
    """Sensors, a controller and a task of its own."""
    return oneiro.Experiment.load(EXPERIMENTS / "homing.toml")
