"""Notebooks show runs while they evolve."""

import threading

import pytest
from conftest import AVOIDANCE, EXPERIMENTS

import oneiro
from oneiro import _watch

# A few seconds.
SET = {"evolution.generations": 3000, "cycles": 100, "record.checkpoint_every": 1000}


@pytest.fixture
def shown(monkeypatch):
    """What both places of a cell's output were set to."""
    places = []

    def place():
        places.append([])
        return places[-1].append

    monkeypatch.setattr(_watch, "_notebook", lambda: place)
    return places


def test_a_run_is_watched_to_its_end(shown, tmp_path):
    exp = oneiro.Experiment.load(AVOIDANCE, set=SET)
    watch = oneiro.watch(tmp_path / "run", every=0.1)
    run = oneiro.run(exp, seed=1, out=tmp_path / "run", backend="cpu")
    assert watch._has_ended.wait(60)
    boards, episodes = shown
    assert "Runs appear here when they begin" in boards[0]
    # The curve grows all the time, and an episode can be seen before the next replaces it.
    assert any("<td>running</td>" in board and "<svg style" in board for board in boards)
    assert len(boards) > 5 and len(set(boards)) == len(boards)
    assert len(episodes) == 2 and all(page.count("<iframe") == 1 for page in episodes)
    assert "<td>done</td>" in boards[-1] and "<p>Generation 2999: individual" in episodes[-1]
    # The notebook's page and the run's are apart.
    assert "<script" not in episodes[-1] and "sandbox='allow-scripts allow-downloads'" in episodes[-1]
    with oneiro.watch(run):
        pass
    assert "<td>done</td>" in shown[2][-1] and shown[3] == episodes[-1:]


def test_a_run_that_is_stopped_ends_the_watch(shown, tmp_path):
    class Stop(oneiro.Callback):
        def generation(self, number, values):
            if number == 500:
                raise KeyboardInterrupt

    exp = oneiro.Experiment.load(AVOIDANCE, set={**SET, "evolution.generations": 100_000})
    watch = oneiro.watch(tmp_path, tmp_path / "run", every=0.1)
    other = oneiro.watch(tmp_path / "run", every=0.1)
    with pytest.raises(KeyboardInterrupt):
        oneiro.run(exp, seed=1, out=tmp_path / "run", backend="cpu", callbacks=[Stop()])
    assert other._has_ended.wait(60)
    assert "<td>stopped</td>" in shown[2][-1]
    # In a directory of runs others may begin.
    assert not watch._has_ended.wait(3)
    watch.stop()
    assert "<td>stopped</td>" in shown[0][-1]


def test_a_sweep_is_watched(shown, tmp_path):
    plan = EXPERIMENTS / "sweeps/small.toml"
    oneiro.sweep_shard(plan, out=tmp_path / "sweep", shard="1/2", backend="cpu")
    watch = oneiro.watch(tmp_path / "sweep", every=0.1)
    oneiro.sweep(plan, out=tmp_path / "sweep", backend="cpu")
    assert watch._has_ended.wait(60)
    board = shown[0][-1]
    assert "<td>done</td>" in board and "noise.<wbr/>sensor" in board and board.count("3 of 3") == 4
    assert shown[1] == []


def test_outside_a_notebook_the_program_is_named():
    with pytest.raises(oneiro.InputError, match="this is no notebook; .*`oneiro watch DIR`"):
        oneiro.watch("runs")
    with pytest.raises(oneiro.InputError, match="every: is 0; allowed: seconds, 0.1 and more"):
        oneiro.watch("runs", every=0)
    assert all(thread.name != "oneiro.watch" for thread in threading.enumerate())


CELLS = [
    """
import os, signal, threading
import oneiro
exp = oneiro.Experiment.load({experiment!r}, set={set})
watch = oneiro.watch("runs", every=0.5)
watch
""",
    """
run = oneiro.run(exp, seed=1, out="runs/one", backend="cpu")
threading.Timer(1.0, os.kill, [os.getpid(), signal.SIGINT]).start()
try:
    watch.wait()
except KeyboardInterrupt:
    print("interrupted")
print(watch._has_ended.is_set())
""",
]


def test_a_notebook_shows_it(tmp_path, monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    # Nothing of the user's, and nothing is left.
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "jupyter"))
    sources = [CELLS[0].format(experiment=str(AVOIDANCE), set=SET), CELLS[1]]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source) for source in sources])
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    board, episode = (output["data"]["text/html"] for output in notebook.cells[0].outputs)
    assert "<td>done</td>" in board and "<svg" in board
    assert "<p>Generation 2999: individual" in episode and episode.count("<iframe") == 1
    text = "".join(output["text"] for output in notebook.cells[1].outputs if output.get("name") == "stdout")
    assert text == "interrupted\nTrue\n"
