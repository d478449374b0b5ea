"""The examples, shortened, and that notebooks are the scripts."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

EXAMPLES = ROOT / "python/examples"
SCRIPTS = sorted(path.stem for path in EXAMPLES.glob("*.py"))


def run(name, folder, **values):
    """Runs a script from the repository's root with other values of its constants. Returns its variables."""
    source = (EXAMPLES / f"{name}.py").read_text()
    for constant, value in values.items():
        source, count = re.subn(rf"^{constant} = .*$", f"{constant} = {value!r}", source, flags=re.MULTILINE)
        assert count == 1, constant
    path = folder / f"{name}.py"
    path.write_text(source)
    variables = {"__name__": "example", "__file__": str(path)}
    before = os.getcwd()
    os.chdir(ROOT)
    try:
        exec(compile(source, path, "exec"), variables)
    finally:
        os.chdir(before)
    return variables


@pytest.fixture(autouse=True)
def no_windows(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")


def test_first_evolution(tmp_path):
    pytest.importorskip("matplotlib")
    short, longer = (run("first_evolution", tmp_path, GENERATIONS=count, FRESH_EPISODES=200) for count in (1, 15))
    # It learns.
    assert longer["fresh"].mean() > short["fresh"].mean() + 20
    assert len(longer["axes"].lines) == 2


def test_cma(tmp_path):
    pytest.importorskip("cma")
    one, twenty = (run("own_optimiser", tmp_path, GENERATIONS=count)["best"].mean() for count in (1, 20))
    # It learns.
    assert twenty > one + 20


def test_cma_goes_on_after_a_stop(tmp_path):
    pytest.importorskip("cma")
    import oneiro

    whole = run("own_optimiser", tmp_path, GENERATIONS=14)
    stopped = run("own_optimiser", tmp_path, GENERATIONS=12)
    recorder = oneiro.Recorder.open(stopped["FOLDER"])
    search, state = recorder.restore()
    assert recorder.generation == 10
    np.random.set_state(state)
    stopped["evolve"](recorder, search, 14)
    for generation in range(14):
        one, other = (
            recorder.recorded(generation),
            oneiro.Recorder.open(whole["FOLDER"]).recorded(generation),
        )
        assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True)), generation


def test_ribs(tmp_path):
    pytest.importorskip("ribs")
    pytest.importorskip("matplotlib")
    one, ten = (run("quality_diversity", tmp_path, ITERATIONS=count)["archive"] for count in (1, 10))
    assert ten.stats.coverage > one.stats.coverage > 0


def test_sweep_statistics(tmp_path, capsys):
    pytest.importorskip("pandas")
    pytest.importorskip("scipy")
    run("sweep_statistics", tmp_path)
    # A line for each of the four cells.
    assert capsys.readouterr().out.count("3 runs") == 4


@pytest.mark.parametrize(("library", "name"), [("distributed", "dask_sweep"), ("ray", "ray_sweep")])
def test_clusters(library, name, tmp_path):
    pytest.importorskip(library)
    import oneiro

    # A process of its own, since workers import the script. Ray would report its use, and keep a token in the home folder.
    command = [sys.executable, str(EXAMPLES / f"{name}.py")]
    alone = {**os.environ, "RAY_USAGE_STATS_ENABLED": "0", "RAY_AUTH_MODE": "disabled"}
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, env=alone).stdout
    assert "['1/4', '2/4', '3/4', '4/4']" in printed
    whole = oneiro.sweep(ROOT / "experiments/sweeps/small.toml", out=tmp_path / "whole", backend="cpu")
    assert f"{whole.runs} runs, hash {whole.hash}" in printed


def test_policy_ppo(tmp_path):
    pytest.importorskip("stable_baselines3")
    variables = run("policy_ppo", tmp_path, STEPS=8192, FRESH_EPISODES=16)
    assert np.isfinite(variables["policy"]).all()
    # Steps in an environment and in an episode are the same, up to rounding.
    assert np.allclose(variables["fresh"], variables["policy"], rtol=1e-2, atol=1)
    # Both begin at the same places, and evolution had as many steps.
    assert variables["spent"] >= 8192 // 500
    assert variables["champion"].shape == variables["policy"].shape == (16,)


def test_policy_own_loop(tmp_path):
    pytest.importorskip("torch")
    variables = run("policy_own_loop", tmp_path, UPDATES=24)
    # It learns.
    assert variables["last"] > variables["first"] + 10


@pytest.mark.parametrize("name", SCRIPTS)
def test_notebooks_are_the_scripts(name):
    jupytext = pytest.importorskip("jupytext")
    script, notebook = (jupytext.read(EXAMPLES / f"{name}.{kind}") for kind in ("py", "ipynb"))
    assert [(cell.cell_type, cell.source) for cell in script.cells] == [
        (cell.cell_type, cell.source) for cell in notebook.cells
    ]
    assert len(script.cells) > 2
    assert all(cell.cell_type != "code" or not cell.outputs for cell in notebook.cells)
