#!/usr/bin/env bash
# all.sh: all checks, from a clean checkout: formatting, lints, the build without a GPU, all tests, the Python package, the docs. All in
# the development profile, in which what computes is optimised (Cargo.toml). Skipped tests are listed at the end, and are failures unless
# ONEIRO_MAY_SKIP names the missing thing: by default the recordings of a real robot, which can't be installed. docs/testing.md has
# more; tests/long.sh has longer tests, those that need other machines or programs among them.
set -euo pipefail
[ $# = 0 ] || {
    echo "usage: $0" >&2
    exit 2
}
cd "$(dirname "$0")/.."
. tests/skips.sh

# Each stage is timed, for the summary.
stage="preparations"
stages=()
began=$SECONDS
say() {
    stages+=("$(printf '%5d s  %s' $((SECONDS - began)) "$stage")")
    stage=$*
    began=$SECONDS
    printf '\n== %s\n' "$*"
}

export ONEIRO_MAY_SKIP=${ONEIRO_MAY_SKIP-recordings,networks}
mkdir -p "${CARGO_TARGET_DIR:-target}"
ONEIRO_SKIPPED=$(realpath -m "${CARGO_TARGET_DIR:-target}/skipped")
export ONEIRO_SKIPPED
: >"$ONEIRO_SKIPPED"

# start NICENESS COMMAND..: starts a command in a session of its own, hence a group for the scheduler, whose niceness is the
# group's. `started` is its group.
start() {
    setsid sh -c '{ echo "$0" >/proc/self/autogroup; } 2>/dev/null; exec nice -n "$0" "$@"' "$@" &
    started=$!
}

# beside NAME NICENESS COMMAND..: starts what runs beside other stages; `join NAME` shows its output, and fails if it failed.
output=$(mktemp -d)
declare -A jobs since
beside() {
    since[$1]=$EPOCHSECONDS
    start "${@:2}" >"$output/$1" 2>&1
    jobs[$1]=$started
}
join() {
    local code=0
    say "waiting for $1"
    wait "${jobs[$1]}" || code=$?
    unset "jobs[$1]"
    cat "$output/$1"
    # Until it last wrote something.
    stages+=("$(printf '%5d s  %s, beside others' $(($(date -r "$output/$1" +%s) - since[$1])) "$1")")
    return $code
}
# lowered NICENESS COMMAND..: runs a command that leaves the processors to what needs them at once.
lowered() {
    local code=0
    start "$@"
    jobs[lowered]=$started
    wait "$started" || code=$?
    unset "jobs[lowered]"
    return $code
}
finish() {
    local group
    for group in "${jobs[@]}"; do kill -- -"$group" 2>/dev/null || true; done
    rm -rf "$output"
    say "what each stage took"
    printf '%s\n' "${stages[@]}"
}
trap finish EXIT

folder=${CARGO_TARGET_DIR:-target}
is_new=yes
[ ! -e "$folder/debug" ] || is_new=

# Beside the lints, which need none of them; a password can be asked for in the foreground alone.
if [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; then
    beside "tools" 0 tests/tools.sh
else
    tests/tools.sh
fi

say "formatting"
cargo fmt --all --check

say "lints"
cargo clippy --workspace --all-targets --features oneiro-host/parquet --locked -- -D warnings

[ -z "${jobs[tools]:-}" ] || join "tools"

say "the book"
docs/build.sh

say "documentation"
# With the examples, what these need counts as well: all is then checked as for the lints, and nothing a second time.
RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --features oneiro-host/parquet --no-deps --lib --examples --quiet

say "the program without the GPU backend, as on robots"
cargo clippy --locked -p oneiro-host --no-default-features -- -D warnings

say "building the tests"
# One run names all that fails.
all=(cargo test --locked --workspace --features oneiro-host/parquet --no-fail-fast)
"${all[@]}" --no-run

# What build scripts, the tests and their Python package need with different features is compiled for each of them (host/Cargo.toml).
compiled_once() {
    local name built
    [ -n "$is_new" ] || return 0
    for name in naga cranelift_codegen wgpu_core; do
        built=("$folder/debug/deps/lib$name"-*.rlib)
        [ ${#built[@]} = 1 ] || {
            echo "$name was compiled ${#built[@]} times: cargo tree --duplicates or cargo build --unit-graph shows which features differ" >&2
            return 1
        }
    done
}
compiled_once

# Tests that wait for robots in real time leave the processors idle, and must get them at once when they need them: they run beside
# all others, which have a lower priority.
beside "robots in real time" 0 "${all[@]}" --test program -- real_time::
beside "Python" 5 bash -ec "tests/python-package.sh; tests/python.sh"
say "all other tests"
# Kernels have no tests in their library, and would be compiled a second time.
failed=
# Random files, parts, kernels and bytes, and twins of fleets, are for tests/long.sh.
lowered 10 "${all[@]}" --exclude oneiro-shaders --lib -- --skip mutants:: --skip fuzz:: || failed=yes
lowered 10 "${all[@]}" --test '*' -- --skip real_time:: --skip mutants:: --skip random:: --skip twins:: || failed=yes
lowered 10 "${all[@]}" --doc || failed=yes

join "robots in real time" || failed=yes
join "Python" || failed=yes
[ -z "$failed" ] || {
    echo "Some tests failed: their names are above, after each \"failures:\"." >&2
    exit 1
}

compiled_once

say "what was skipped"
skip_summary

say "all is well"
