"""What all tests use: the experiments that ship, and the program."""

import os
import subprocess
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


@pytest.fixture
def avoidance():
    return oneiro.Experiment.load(AVOIDANCE, set={"cycles": 60})


@pytest.fixture
def own():
    """Sensors, a controller and a task of its own."""
    return oneiro.Experiment.load(EXPERIMENTS / "homing.toml")
