"""The examples, shortened."""

import importlib.util

import pytest
from conftest import ROOT


def example(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / f"python/examples/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_cma():
    pytest.importorskip("cma")
    optimiser = example("own_optimiser")
    # It learns: ten generations are better than one.
    assert optimiser.main(10) > optimiser.main(1) + 20


def test_ribs():
    pytest.importorskip("ribs")
    archive = example("quality_diversity")
    assert archive.main(10) > archive.main(1) > 0
