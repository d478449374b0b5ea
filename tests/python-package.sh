#!/usr/bin/env bash
# python-package.sh [--with-learning]: the wheel of the Python package, built and installed into a fresh virtual environment, and all
# of python/tests there: against the program, and by Gymnasium's and PettingZoo's own checkers. With --with-learning also
# Stable-Baselines3's, which brings torch. Skipped if there is no Python, or its packages aren't available.
# ONEIRO_PYTHON_PROFILE=release builds and measures the wheel as users get it; by default it is built as tests are.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

case $* in
"") learning= ;;
--with-learning) learning=yes ;;
*)
    echo "usage: $0 [--with-learning]" >&2
    exit 2
    ;;
esac
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
say() { printf '\n== Python package: %s\n' "$*"; }
fail() {
    echo "Python package: $*" >&2
    exit 1
}
no_python() {
    skipped python "the Python package: $*"
    exit 0
}

profile=${ONEIRO_PYTHON_PROFILE:-dev}
case $profile in
dev) built=debug options=(--profile dev --features checked) ;;
release) built=release options=(--profile release) ;;
*) fail "ONEIRO_PYTHON_PROFILE is $profile; allowed: dev, release" ;;
esac
program=$folder/$built/oneiro
[ -x "$program" ] || fail "build the program first: cargo build --profile $profile -p oneiro-host --features oneiro-host/parquet"

export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_RETRIES=2
install=(install --quiet --only-binary :all:)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -c 'import venv, ensurepip' 2>/dev/null || no_python "there is no python3 that makes virtual environments"
python3 -m venv "$scratch/build" || no_python "python3 makes no virtual environment"
"$scratch/build/bin/python" -m pip "${install[@]}" 'maturin>=1.16,<2' || no_python "maturin can't be had: is there a network?"

say "the wheel"
(cd python && "$scratch/build/bin/maturin" build "${options[@]}" --locked --auditwheel skip \
    --interpreter python3 --out "$scratch/wheels" --target-dir "$folder")
wheel=$(echo "$scratch"/wheels/oneiro-*.whl)
size=$(stat -c %s "$wheel")
echo "$(basename "$wheel"): $size bytes"
[ "$profile" = dev ] || [ "$size" -lt 12000000 ] || fail "the wheel has $size bytes; the target is less than 12 MB"

say "a fresh virtual environment"
python3 -m venv "$scratch/fresh"
python=$scratch/fresh/bin/python
"$python" -m pip "${install[@]}" "$wheel" || no_python "NumPy can't be had: is there a network?"
# No tool of Rust's is found, and nothing but NumPy is installed.
example() {
    awk '/^```python$/ { on = 1; next } /^```$/ { on = 0 } on' "$1" >"$scratch/example.py"
    [ -s "$scratch/example.py" ] || fail "there is no example in $1"
    (cd "$2" && env -i HOME="$HOME" PATH=/usr/bin:/bin "$python" -W error "$scratch/example.py")
}
example README.md .
example docs/python.md .
example python/README.md experiments
tutorial=docs/tutorials/from-python.md
example $tutorial . >"$scratch/printed"
awk '/^```text$/ { on = 1; next } /^```$/ { on = 0 } on' $tutorial | diff - "$scratch/printed" ||
    fail "$tutorial shows other output than its blocks print (above, after >)"

say "its tests"
packages=(
    pytest pandas scipy tqdm cloudpickle matplotlib jupytext 'dask[distributed]' 'gymnasium>=1.1' 'pettingzoo>=1.25' cma 'ribs[visualize]'
    # `mlflow-skinny` is `mlflow` without a server.
    'tensorboard>=2.15' 'wandb>=0.20' 'mlflow-skinny>=2.14' nbclient ipykernel onnxruntime
)
# It brings torch; and Ray is large too.
[ -z "$learning" ] || packages+=('stable-baselines3>=2.6' ray)
# Most of their modules are never imported.
"$python" -m pip "${install[@]}" --no-compile "${packages[@]}" || no_python "${packages[*]} can't be had"
ONEIRO_PROGRAM=$program "$python" -m pytest -q -p no:cacheprovider --durations 5 python/tests

say "lints, and type stubs"
"$python" -m pip "${install[@]}" 'mypy>=1.15' ruff || no_python "mypy and ruff can't be had"
(cd python && "$python" -m ruff check --no-cache oneiro tests examples && "$python" -m ruff format --no-cache --check oneiro tests examples)
config=$PWD/python/pyproject.toml
(cd "$scratch" && "$python" -m mypy --no-error-summary -p oneiro --follow-untyped-imports --config-file "$config")
# The native module has what its stub says, but for the name of a type, and what older versions of mypy don't know of classes.
echo 'oneiro\._native\.(__all__|Progress|Beginning|Arena|Evolution|Experiment|Run|Stepped)' >"$scratch/allowed"
(cd "$scratch" && "$python" -m mypy.stubtest oneiro._native --allowlist allowed --ignore-unused-allowlist)
stub=$("$python" -c 'import oneiro._native as native; print(native.__file__)')
stub=${stub%/*}/_native.pyi
cp "$stub" "$scratch/right.pyi"
sed -i 's/shard: str | None/shards: str | None/' "$stub"
! (cd "$scratch" && "$python" -m mypy.stubtest oneiro._native --allowlist allowed --ignore-unused-allowlist >/dev/null) ||
    fail "CONTROL: a wrong stub passes"
cp "$scratch/right.pyi" "$stub"
printf 'import oneiro\nexp = oneiro.Experiment.load(1)\n' >"$scratch/wrong.py"
! (cd "$scratch" && "$python" -m mypy --no-error-summary wrong.py >/dev/null) || fail "CONTROL: a wrong argument passes"

say "import"
"$python" - <<'PYTHON'
import resource, subprocess, sys

def seconds(code):
    """The least processor time of ten new processes, since other tests may run beside them."""
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    times = []
    for _ in range(10):
        before = used()
        subprocess.run([sys.executable, "-c", code], check=True)
        times.append(used() - before)
    return min(times)

took = 1000 * (seconds("import oneiro") - seconds("pass"))
print(f"import oneiro: {took:.1f} ms of processor time")
modules = subprocess.run(
    [sys.executable, "-c", "import sys, oneiro; print('numpy' in sys.modules, 'gymnasium' in sys.modules)"],
    check=True, capture_output=True, text=True,
).stdout.split()
assert modules == ["False", "False"], "packages of others are imported with oneiro"
# 30 ms on a quiet machine; processor time itself doubles while other tests run.
assert took < 100, "importing oneiro takes too long"
PYTHON
say "all is well"
