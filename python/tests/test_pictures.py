"""Pages and pictures of episodes, arenas and runs."""

import subprocess
import sys

import numpy as np
import pytest
from conftest import EXPERIMENTS, program

import oneiro

SMALL = {
    "cycles": 40,
    "evolution.population": 10,
    "evolution.parents": 2,
    "evolution.generations": 3,
    "evolution.elite": 0,
}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    exp = oneiro.Experiment.load(EXPERIMENTS / "khepera-avoidance.toml", set=SMALL)
    return oneiro.run(exp, seed=1, out=tmp_path_factory.mktemp("runs") / "run", backend="cpu")


def test_a_runs_replay_is_the_programs(run, tmp_path):
    before = sorted(path.name for path in run.path.iterdir())
    replay = oneiro.replay(run)
    assert sorted(path.name for path in run.path.iterdir()) == before
    program("replay", run.path, "--out", tmp_path)
    assert replay.html == (tmp_path / "replay.html").read_text()
    assert replay.save(tmp_path / "page.html").read_text() == replay.html
    assert "srcdoc" in replay._repr_html_()
    other = oneiro.replay(run, seed=7)
    program("replay", run.path, "--out", tmp_path / "other", "--seed", 7)
    (page,) = (tmp_path / "other").glob("*.html")
    assert other.html == page.read_text() != replay.html
    with pytest.raises(oneiro.InputError, match="no such episode"):
        oneiro.replay(run, trial=1000)


def test_a_genomes_replay(run):
    exp = run.experiment
    genome = run.champion.genome
    page = oneiro.replay(genome, exp, seed=3).html
    assert "<script" in page and page != oneiro.replay(np.zeros(exp.genes), exp, seed=3).html
    assert page == oneiro.replay(dict(zip(exp.gene_names, genome[:, None], strict=True)), exp, seed=3).html
    with pytest.raises(oneiro.InputError, match="allowed: a Run, or a genome and its experiment"):
        oneiro.replay(genome)
    with pytest.raises(oneiro.InputError, match="a single one"):
        oneiro.replay(np.zeros((2, exp.genes)), exp)


def test_arenas():
    arena = oneiro.Experiment.example("khepera-avoidance").arena
    assert arena.field == (0.0, 0.0, 600.0, 350.0)
    assert arena.segments.shape == (4, 4) and arena.circles.shape == (3, 3) and arena.lights.shape == (0, 3)
    assert arena.segments.dtype == np.float32 and arena.segments.min() == 0 and arena.segments.max() == 600
    exp = oneiro.Experiment.example("puck-foraging")
    assert exp.arena.patches[:, :3].tolist() == [[300.0, 600.0, 250.0]] and exp.arena.lights.tolist() == [
        [300.0, 600.0, 0.0]
    ]
    blocks = oneiro.Experiment.example("khepera-block").arena.blocks
    assert blocks.shape[1] == 5 and len(blocks) >= 1
    with pytest.raises(oneiro.InputError, match="is of the foraging study"):
        oneiro.Experiment.example("odowd2014-over").arena  # noqa: B018


def test_plots(run):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    exp = run.experiment
    outcome = oneiro.evaluate(exp, run.champion.genome, seed=1, traces=True, backend="cpu")
    trace = outcome.traces[0, 0]
    _, (left, right) = plt.subplots(1, 2)
    assert oneiro.plot.path(exp, trace, left, color="red") is left
    way = next(line for line in left.lines if len(line.get_xdata()) == 40)
    assert (way.get_xdata() == trace["x_mm"]).all() and (way.get_ydata() == trace["y_mm"]).all()
    assert way.get_color() == "red" and len(left.patches) == 3 and left.get_xlim()[1] > 600
    oneiro.plot.curve(run, right)
    best, mean = right.lines
    assert (best.get_ydata() == np.asarray(run.generations["best"])).all() and mean.get_label() == "mean"
    plt.sca(right)
    assert oneiro.plot.arena(oneiro.Experiment.example("puck-foraging")) is right
    assert oneiro.plot.path(exp, np.zeros((5, 3)), length=2, ax=left) is left
    for length in [0, -5, 6]:
        with pytest.raises(oneiro.InputError, match=f"length: is {length}; allowed: "):
            oneiro.plot.path(exp, np.zeros((5, 3)), length=length)
    # After an early end there is nothing to draw.
    short = oneiro.Experiment.load(EXPERIMENTS / "discrimination.toml")
    ended = oneiro.evaluate(short, np.full((1, short.genes), 3.0), seed=1, traces=True)
    cycles = int(ended.lengths[0, 0])
    assert cycles < ended.traces.shape[2]
    drawn = oneiro.plot.path(short, ended.traces[0, 0])
    assert len(drawn.lines[-2].get_xdata()) == cycles
    with pytest.raises(oneiro.InputError, match="columns: has 'worst'; allowed: generation, "):
        oneiro.plot.curve(run, columns=("worst",))
    with pytest.raises(oneiro.InputError, match="allowed: one episode's"):
        oneiro.plot.path(exp, outcome.traces)
    plt.close("all")


def test_nothing_else_is_imported():
    code = "import sys, oneiro; print([name for name in ('numpy', 'gymnasium', 'matplotlib') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("name", ["khepera-avoidance", "homing", "khepera-block", "predator-prey", "line-follower"])
def test_saved_experiments_load_again(name, tmp_path, monkeypatch):
    exp = oneiro.Experiment.example(name, set={"cycles": 77})
    exp.save(tmp_path / "mine.toml")
    again = oneiro.Experiment.load(tmp_path / "mine.toml")
    assert again == exp and again.hash == exp.hash and again.cycles == 77
    assert (tmp_path / "mine.toml").read_text() == exp.to_toml() == again.to_toml()
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    again.save("other.toml")
    assert oneiro.Experiment.load("other.toml") == exp
    with pytest.raises(oneiro.StorageError, match="none/mine.toml|none/inputs"):
        exp.save(tmp_path / "none" / "mine.toml")


def test_experiments_share_a_folder_as_they_share_files(tmp_path):
    exp = oneiro.Experiment.example("homing")
    other = exp.with_({"evolution.population": 50})
    exp.save(tmp_path / "one.toml")
    exp.save(tmp_path / "one.toml")
    other.save(tmp_path / "other.toml")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    # Neither a file that it names nor the experiment itself is replaced by another.
    (tmp_path / "elsewhere").mkdir()
    task = tmp_path / "elsewhere" / "task.wgsl"
    task.write_text((tmp_path / "inputs" / "task.wgsl").read_text() + "// Changed.\n")
    changed = exp.with_({"task.part": str(task)})
    for exp_of, name in [(changed, "third.toml"), (other, "one.toml")]:
        with pytest.raises(oneiro.InputError, match="has another content; allowed: a new file, or another folder"):
            exp_of.save(tmp_path / name)
    assert {path: path.read_bytes() for path in before} == before and not (tmp_path / "third.toml").exists()
    assert oneiro.Experiment.load(tmp_path / "one.toml") == exp


def test_other_values(tmp_path):
    exp = oneiro.Experiment.example("homing")
    other = exp.with_({"cycles": 50, "evolution.population": 30})
    assert (other.cycles, other.settings["evolution.population"]) == (50, 30) and exp.cycles != 50
    assert exp.with_(set={"cycles": exp.cycles}) == exp
    with pytest.raises(oneiro.InputError, match="allowed: 1 to 1000000"):
        exp.with_({"cycles": 0})
