"""Callbacks: their arguments, and the records of TensorBoard, W&B and MLflow, by their own readers."""

import struct
import subprocess
import sys
import threading

import numpy as np
import pytest
from conftest import AVOIDANCE, EXPERIMENTS

import oneiro
from oneiro import _callbacks

GENERATIONS = 12
SET = {
    "cycles": 40,
    "evolution.population": 20,
    "evolution.parents": 4,
    "evolution.generations": GENERATIONS,
    "evolution.finalists": 2,
    "evolution.finalist_lives": 4,
}
COLUMNS = ["best", "peak", "mean", "least", "deviation", "nan"]


class Noted(oneiro.Callback):
    """Notes what it is told, and fails at a generation."""

    def __init__(self, fails_at=-1):
        self.runs = []
        self.fails_at = fails_at

    def begin(self, name, settings, tags):
        self.runs.append({"name": name, "settings": settings, "tags": tags, "values": []})

    def generation(self, number, values):
        assert number == len(self.runs[-1]["values"])
        if number == self.fails_at:
            raise RuntimeError("enough")
        self.runs[-1]["values"].append(values)

    def end(self, files, is_finished):
        self.runs[-1] |= {"files": [path.name for path in files], "is_finished": is_finished}


@pytest.fixture
def short():
    return oneiro.Experiment.load(AVOIDANCE, set=SET)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    exp = oneiro.Experiment.load(AVOIDANCE, set=SET)
    return oneiro.run(exp, seed=3, out=tmp_path_factory.mktemp("finished") / "run", backend="cpu")


def has_table(values, table):
    return all([own[name] for own in values] == list(table[name]) for name in COLUMNS)


def test_settings_are_those_that_set_takes(short):
    assert {key: short.settings[key] for key in SET} == SET
    changed = {"noise.sensor": [0.0, 0.25], "task.speed": "signed"}
    other = oneiro.Experiment.load(AVOIDANCE, set=changed)
    assert changed.items() <= other.settings.items() and not changed.items() <= short.settings.items()
    again = oneiro.Experiment.load(AVOIDANCE, set={key: other.settings[key] for key in changed})
    assert again == other != short


def test_a_run_tells_its_callbacks(short, finished, tmp_path):
    noted = [Noted(), Noted()]
    run = oneiro.run(short, seed=3, out=tmp_path / "run", backend="cpu", callbacks=noted)
    assert run.result == finished.result
    for (own,) in (noted[0].runs, noted[1].runs):
        assert own["name"] == "khepera-avoidance-3" and own["settings"] == {**short.settings, "seed": 3}
        assert own["tags"] == {"seed": "3", "experiment": short.hash}
        assert len(own["values"]) == GENERATIONS and has_table(own["values"], run.generations)
        assert set(own["values"][0]) == set(COLUMNS)
        assert own["is_finished"] and {"champion.json", "champion.npy", "report.html", "DONE"} <= set(own["files"])
    later = Noted()
    oneiro.log_runs(oneiro.load_run(tmp_path / "run"), [later], follow=True)
    assert later.runs == noted[0].runs


@pytest.mark.parametrize("has_bar", [False, True])
def test_a_callback_that_fails_stops_the_run(tmp_path, monkeypatch, has_bar):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: has_bar)
    exp = oneiro.Experiment.load(AVOIDANCE, set={**SET, "evolution.generations": 100_000})
    noted, failing = Noted(), Noted(fails_at=7)
    with pytest.raises(RuntimeError, match="enough"):
        oneiro.run(exp, seed=1, out=tmp_path / "run", backend="cpu", callbacks=[noted, failing])
    run = oneiro.load_run(tmp_path / "run")
    assert run.result is None and len(run.generations["mean"]) < 100_000
    for callback in (noted, failing):
        assert not callback.runs[0]["is_finished"] and callback.runs[0]["files"] == []
    # It can go on, and all of it is told.
    with pytest.raises(RuntimeError, match="enough"):
        oneiro.resume(tmp_path / "run", backend="cpu", callbacks=[again := Noted(fails_at=200)])
    assert again.runs[0]["values"][:7] == failing.runs[0]["values"]
    assert oneiro.load_run(tmp_path / "run").result is None


def test_a_callback_may_raise_stop_iteration(short, tmp_path):
    class Enough(Noted):
        def generation(self, number, values):
            if number == GENERATIONS - 1:
                raise StopIteration("enough")

    noted = Enough()
    for exp in (short, oneiro.Experiment.load(AVOIDANCE, set={**SET, "evolution.generations": 100_000})):
        with pytest.raises(StopIteration, match="enough"):
            oneiro.run(exp, seed=1, out=tmp_path / exp.hash, backend="cpu", callbacks=[noted])
        assert not noted.runs[-1]["is_finished"]


def test_a_refused_run_tells_nothing_of_the_other(short, finished):
    noted = Noted()
    with pytest.raises(oneiro.InputError, match="holds the run of another experiment or seed"):
        oneiro.run(short, seed=4, out=finished.path, callbacks=[noted])
    assert noted.runs[0]["values"] == [] and not noted.runs[0]["is_finished"]


def test_a_run_is_followed(tmp_path):
    exp = oneiro.Experiment.load(AVOIDANCE, set={**SET, "evolution.generations": 3000})
    thread = threading.Thread(
        target=oneiro.run, args=[exp], kwargs={"seed": 1, "out": tmp_path / "run", "backend": "cpu"}
    )
    thread.start()
    while not (tmp_path / "run/config.toml").exists():
        pass
    noted = Noted()
    run = oneiro.load_run(tmp_path / "run")
    oneiro.log_runs(run, [noted], follow=True)
    assert noted.runs[0]["is_finished"] and has_table(noted.runs[0]["values"], run.generations)
    assert len(noted.runs[0]["values"]) == 3000
    thread.join()


def test_a_swarms_intervals_are_means_over_robots(tmp_path):
    exp = oneiro.Experiment.load(EXPERIMENTS / "odowd2014-over.toml", set={"swarm.robots": 3, "swarm.minutes": 4})
    noted = Noted()
    run = oneiro.run(exp, seed=1, out=tmp_path / "run", backend="cpu", callbacks=[noted])
    table = run.generations
    number, real, robots = (np.asarray(table[name]) for name in ("interval", "real", "robot"))
    assert robots.max() == 2 and number.max() > 0
    expected = [real[number == interval].mean() for interval in range(number.max() + 1)]
    np.testing.assert_allclose([own["real"] for own in noted.runs[0]["values"]], expected)
    assert "robot" not in noted.runs[0]["values"][0] and "simulated" not in noted.runs[0]["values"][0]


def test_a_table_is_read_while_it_grows(tmp_path):
    path = tmp_path / "intervals.csv"
    table = _callbacks._Table(path)
    assert list(table.steps(False)) == []
    path.write_text("interval,robot,real,simulated\n0,0,1,\n0,1,2,\n1,0,3,4.")
    # The other robots of the first interval may follow.
    assert list(table.steps(False)) == []
    path.write_text(path.read_text() + "5\n1,1,4,\n2,0,7,8\n")
    assert list(table.steps(False)) == [(0, {"real": 1.5}), (1, {"real": 3.5, "simulated": 4.5})]
    whole = path.read_text()
    # A run that is resumed cuts it.
    path.write_text(whole[:40])
    assert list(table.steps(False)) == []
    path.write_text(whole + "2,1,9,10\n")
    assert list(table.steps(True)) == [(2, {"real": 8.0, "simulated": 9.0})]


def test_each_run_of_a_sweep_is_logged(tmp_path):
    sweep = oneiro.sweep(EXPERIMENTS / "sweeps/small.toml", out=tmp_path / "small", backend="cpu")
    noted = Noted()
    oneiro.log_runs(sweep, [noted])
    results, table = sweep.results, sweep.generations
    assert len(noted.runs) == sweep.runs == 12
    for run, own in enumerate(noted.runs):
        assert own["name"] == f"small-{run}" and own["is_finished"]
        assert own["settings"] == {
            "noise.sensor": [0.0, 0.0] if run < 6 else [0.0, 0.4],
            "evolution.population": results["evolution.population"][run],
            "seed": results["seed"][run],
        }
        assert own["tags"] == {
            "seed": str(results["seed"][run]),
            "sweep": sweep.hash,
            "result": results["result"][run],
        }
        rows = {name: np.asarray(table[name])[np.asarray(table["run"]) == run] for name in COLUMNS}
        assert has_table(own["values"], rows)


def test_a_loop_of_ones_own_is_logged(short):
    noted = Noted()
    with oneiro.log_loop(short, [noted], seed=5) as log:
        log([1.0, 2.0, 9.0, float("nan")])
        log([[1.0, 3.0], [5.0, 9.0]])
        log([float("nan")])
    (own,) = noted.runs
    assert own["is_finished"] and own["name"] == "khepera-avoidance-5" and own["files"] == []
    one, two, three = own["values"]
    assert (one["best"], one["mean"], one["median"], one["episodes"]) == (9.0, 4.0, 2.0, 4)
    assert (two["best"], two["mean"], two["median"], two["episodes"]) == (7.0, 4.5, 4.5, 8)
    assert np.isnan(three["best"]) and three["episodes"] == 9
    assert all(own["episodes_per_s"] > 0 for own in own["values"])
    with pytest.raises(ZeroDivisionError), oneiro.log_loop(short, [noted], seed=6):
        1 / 0  # noqa: B018
    assert not noted.runs[1]["is_finished"]


def test_tensorboard(finished, tmp_path):
    pytest.importorskip("tensorboard")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
    from tensorboard.plugins.hparams import metadata

    oneiro.log_runs(finished, [oneiro.tensorboard.Callback(tmp_path)])
    events = EventAccumulator(str(tmp_path / "khepera-avoidance-3"))
    events.Reload()
    assert set(events.Tags()["scalars"]) == set(COLUMNS)
    for name in COLUMNS:
        scalars = events.Scalars(name)
        assert [scalar.step for scalar in scalars] == list(range(GENERATIONS))
        assert [scalar.value for scalar in scalars] == np.asarray(finished.generations[name], np.float32).tolist()
    content = events.PluginTagToContent("hparams")[metadata.SESSION_START_INFO_TAG]
    values = metadata.parse_session_start_info_plugin_data(content).hparams
    assert values["evolution.population"].number_value == 20 and values["noise.sensor"].string_value == "[0.0, 0.0]"
    assert values["experiment"].string_value == finished.experiment.hash and values["seed"].number_value == 3


def wandb_records(path):
    """The records of W&B's file: blocks of 32 KiB, in which a record is whole (1), or begins (2), goes on (3) and ends (4)."""
    from wandb.proto.wandb_internal_pb2 import Record

    data, at, record = path.read_bytes(), 7, b""
    while at + 7 <= len(data):
        left = -at % 32768
        if 0 < left < 7:
            at += left
            continue
        _, length, kind = struct.unpack_from("<IHB", data, at)
        record += data[at + 7 : at + 7 + length]
        at += 7 + length
        if kind in (1, 4):
            yield Record.FromString(record)
            record = b""


def test_wandb(finished, tmp_path, monkeypatch):
    monkeypatch.setenv("WANDB_SILENT", "true")
    monkeypatch.setenv("WANDB_ERROR_REPORTING", "false")
    wandb = pytest.importorskip("wandb")
    oneiro.log_runs(finished, [oneiro.wandb.Callback(mode="offline", dir=str(tmp_path), project="robots")])
    # Its other process closes the file.
    wandb.teardown()
    (path,) = tmp_path.glob("wandb/offline-run-*/*.wandb")
    records = {}
    for record in wandb_records(path):
        records.setdefault(record.WhichOneof("record_type"), []).append(record)
    run = records["run"][0].run
    assert (run.display_name, run.project) == ("khepera-avoidance-3", "robots")
    assert list(run.tags) == ["seed-3", f"experiment-{finished.experiment.hash[:12]}"]
    config = {item.key: item.value_json for item in run.config.update}
    assert config["evolution.population"] == "20" and config["experiment"] == f'"{finished.experiment.hash}"'
    rows = [
        {item.nested_key[0]: float(item.value_json) for item in record.history.item} for record in records["history"]
    ]
    assert [row["_step"] for row in rows] == list(range(GENERATIONS))
    for name in COLUMNS:
        np.testing.assert_allclose([row[name] for row in rows], finished.generations[name], rtol=1e-6)
    files = {entry.path for entry in records["artifact"][0].artifact.manifest.contents}
    assert {"champion.json", "report.html", "DONE"} <= files
    assert records["exit"][0].exit.exit_code == 0


def test_mlflow(finished, tmp_path, monkeypatch):
    monkeypatch.setenv("MLFLOW_ALLOW_FILE_STORE", "true")
    monkeypatch.setenv("MLFLOW_DISABLE_TELEMETRY", "true")
    mlflow = pytest.importorskip("mlflow")
    mlflow.set_tracking_uri(tmp_path.as_uri())
    mlflow.set_experiment("robots")
    # Within a run of the caller's, which goes on.
    with mlflow.start_run() as outer:
        oneiro.log_runs(finished, [oneiro.mlflow.Callback(description="short")])
        assert mlflow.active_run().info.run_id == outer.info.run_id
    client = mlflow.MlflowClient()
    experiment = client.get_experiment_by_name("robots").experiment_id
    (run,) = (run for run in client.search_runs([experiment]) if run.info.run_id != outer.info.run_id)
    assert (run.info.run_name, run.info.status) == ("khepera-avoidance-3", "FINISHED")
    assert run.data.tags["seed"] == "3" and run.data.tags["experiment"] == finished.experiment.hash
    assert run.data.tags["mlflow.note.content"] == "short"
    assert run.data.tags["mlflow.parentRunId"] == outer.info.run_id
    assert run.data.params["evolution.population"] == "20"
    for name in COLUMNS:
        history = sorted(client.get_metric_history(run.info.run_id, name), key=lambda metric: metric.step)
        assert [metric.step for metric in history] == list(range(GENERATIONS))
        assert [metric.value for metric in history] == list(finished.generations[name])
    files = {file.path for file in client.list_artifacts(run.info.run_id)}
    assert {"champion.json", "report.html", "DONE"} <= files


MISSING = """
import sys
import oneiro
for name in ["tensorboard", "wandb", "mlflow"]:
    sys.modules[name] = None
    try:
        getattr(oneiro, name)
    except AttributeError as error:
        print(error)
"""


def test_a_package_that_is_missing_is_named():
    printed = subprocess.run([sys.executable, "-c", MISSING], capture_output=True, text=True, check=True).stdout
    for name, line in zip(["tensorboard", "wandb", "mlflow"], printed.splitlines(), strict=True):
        assert line.startswith(f"oneiro.{name} needs {name}") and f"pip install '{name}>=" in line
