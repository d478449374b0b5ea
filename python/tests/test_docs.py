"""docs/python.md has the whole interface, and no other."""

import ast
import inspect
import re
from pathlib import Path

import pytest
from conftest import ROOT

import oneiro
from oneiro._runs import Champion

TEXT = (ROOT / "docs/python.md").read_text()
# What a section is about, whose members it writes with a point before their names.
SECTIONS = {
    "Experiments": [oneiro.Experiment, oneiro.Arena],
    "Evaluating genomes": [oneiro.Outcome],
    "Evolutions": [oneiro.Evolution, oneiro.Archive],
    "Runs and sweeps": [oneiro.Run, oneiro.Sweep, Champion],
    "Controllers alone": [oneiro.Controller],
    "Notebooks": [oneiro.Watch],
    "Callbacks": [oneiro.Callback],
    "Pictures": [oneiro.Replay],
    "With others' optimisers": [oneiro.Recorder],
    "Exceptions": [oneiro.Error],
}
# What Python gives every named tuple.
TUPLES = {"count", "index"}


def section(text, name):
    return text.split(f"\n## {name}\n")[1].split("\n## ")[0]


def code(text):
    """What is written as code: between backquotes, or indented."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    indented = re.findall(r"(?:^    .*\n)+", text, flags=re.MULTILINE)
    return re.findall(r"`([^`\n]+)`", text) + indented


def members(kind):
    """Those of the class, and those that its methods set."""
    sources = [inspect.getsource(own) for own in vars(kind).values() if inspect.isfunction(own)]
    return {*dir(kind), *re.findall(r"self\.(\w+) = ", "".join(sources))}


def public(kind):
    own = {name for name in vars(kind) if not name.startswith("_")}
    return own - TUPLES if issubclass(kind, tuple) else own


def missing(text):
    """Names of the interface that the page doesn't have."""
    words = set(re.findall(r"\w+", " ".join(code(text))))
    lacking = {name for name in oneiro.__all__ if name not in words and name != "__version__"}
    for name, kinds in SECTIONS.items():
        written = set(re.findall(r"\.(\w+)", " ".join(code(section(text, name)))))
        lacking |= {f"{kind.__name__}.{member}" for kind in kinds for member in public(kind) - written}
    return lacking


def unknown(text):
    """Members that the page has and the classes of its sections don't."""
    found = set()
    for name, kinds in SECTIONS.items():
        for piece in code(section(text, name)):
            for member in re.findall(r"^\.(\w+)", piece):
                if not any(member in members(kind) for kind in kinds):
                    found.add(f"{name}: .{member}")
    return found


def signatures(text):
    """Calls as the page writes them, where it names what is optional: the callable's name, and its parameters."""
    heads = re.split(r"^## (.*)$", text, flags=re.MULTILINE)
    for name, part in zip(["", *heads[1::2]], heads[::2], strict=True):
        for piece in code(part):
            for called, parameters in re.findall(
                r"((?:\w+)?(?:\.\w+)*)\(((?:[^()]|\(\))*)\)", re.sub(r"\s+", " ", piece)
            ):
                try:
                    ast.parse(f"def f({parameters}): pass")
                except SyntaxError:
                    # A call with values.
                    continue
                yield name, called, parameters


def resolved(name, called):
    """What is called, or None where it isn't of the package."""
    owners = SECTIONS.get(name, []) if called.startswith(".") else [oneiro]
    for owner in owners:
        found = owner
        for word in called.removeprefix("oneiro.").removeprefix(".").split("."):
            try:
                found = getattr(found, word, None)
            except ModuleNotFoundError:
                # A module that needs a package that isn't installed.
                return None
        if found is not None:
            return found
    return None


def parameters(signature):
    """Name, kind and default of each."""
    given = [own for own in signature.parameters.values() if own.name != "self"]
    return [(own.name, own.kind, getattr(own.default, "value", own.default)) for own in given]


def different(text):
    """Signatures that the page has otherwise than the package, and how many it has."""
    count, problems = 0, []
    for name, called, written in signatures(text):
        found = resolved(name, called)
        if found is None:
            continue
        scope = {}
        try:
            exec(f"def f({written}): pass", scope)
        except NameError:
            # A call with variables.
            continue
        count += 1
        if parameters(inspect.signature(found)) != parameters(inspect.signature(scope["f"])):
            problems.append(f"{called}({written}) is {inspect.signature(found)}")
    return count, problems


def test_the_page_has_the_whole_interface():
    assert missing(TEXT) == set()
    assert unknown(TEXT) == set()


def test_the_page_has_the_packages_signatures():
    count, problems = different(TEXT)
    assert problems == []
    # All functions, constructors and methods that take something.
    assert count >= 25, count


BLOCKS = dict(re.findall(r"^```python needs=(\S+)\n(.*?)^```$", TEXT, flags=re.DOTALL | re.MULTILINE))
LOGGERS, LEARNER = "tensorboard,wandb,mlflow", "stable_baselines3"


def run(needs, folder, monkeypatch, change=lambda source: source):
    """Runs a block, changed, if there are the packages that it needs."""
    for package in needs.split(","):
        pytest.importorskip(package)
    (folder / "experiments").symlink_to(ROOT / "experiments")
    monkeypatch.chdir(folder)
    exec(compile(change(BLOCKS[needs]), "docs/python.md", "exec"), {})


def test_a_policy_becomes_a_run(tmp_path, monkeypatch):
    run(LEARNER, tmp_path, monkeypatch, lambda source: source.replace("400_000", "4_096"))
    assert oneiro.load_run(tmp_path / "runs/ppo").champion.genome.shape == (4866,)


def test_callbacks_log(tmp_path, monkeypatch, capsys):
    # Some packages read the environment when they are imported.
    values = {"MLFLOW_TRACKING_URI": tmp_path.as_uri(), "MLFLOW_ALLOW_FILE_STORE": "true"}
    for key, value in {**values, "MLFLOW_DISABLE_TELEMETRY": "true", "WANDB_SILENT": "true"}.items():
        monkeypatch.setenv(key, value)
    run(LOGGERS, tmp_path, monkeypatch)
    assert "enough at generation" in capsys.readouterr().out
    # A run, the sweep's and the loop.
    assert len(list(tmp_path.glob("tensorboard/*/events.*"))) == 14
    assert len(list(tmp_path.glob("wandb/offline-run-*"))) == 2


def test_there_is_such_a_block():
    assert set(BLOCKS) == {LOGGERS, LEARNER}


@pytest.mark.parametrize(
    ("old", "new", "check"),
    [
        ("`.bounds`", "", missing),
        ("`resume(", "`resumed(", missing),
        ("`.is_finished`", "`.is_done`", unknown),
        ("kind=None)`", "kind=1)`", lambda text: different(text)[1]),
        ("episodes=None, common_starts=False", "common_starts=False", lambda text: different(text)[1]),
        ("share=0.01, *", "portion=0.01, *", lambda text: different(text)[1]),
    ],
)
def test_a_page_that_is_wrong_is_noticed(old, new, check):
    text = re.sub(re.escape(old), new.replace("\\", ""), TEXT)
    assert text != TEXT and check(text)


def test_everything_says_what_it_is():
    """At run time too, as the stubs say it; and nothing is of a module that users don't see."""
    stub = ast.parse((Path(oneiro.__file__).parent / "_native.pyi").read_text())
    (experiment,) = [own for own in stub.body if getattr(own, "name", None) == "Experiment"]
    documented = [own for own in experiment.body if isinstance(own, ast.FunctionDef) and ast.get_docstring(own)]
    assert len(documented) > 10
    for own in documented:
        words = inspect.getdoc(getattr(oneiro.Experiment, own.name)).split()
        assert words == ast.get_docstring(own).split(), own.name
    for name in oneiro.__all__:
        value = getattr(oneiro, name, None)
        if inspect.isclass(value) or inspect.isfunction(value):
            assert inspect.getdoc(value) and value.__module__ == "oneiro", name
        if inspect.isclass(value):
            members = vars(value).items()
            for member, own in members:
                if not member.startswith("_") and (callable(own) or isinstance(own, property)):
                    assert inspect.getdoc(own), f"{name}.{member}"
