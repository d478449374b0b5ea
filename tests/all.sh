#!/usr/bin/env bash
# all.sh [--with-slurm] [--with-learning]: all checks, from a clean checkout: formatting, lints, the build without a GPU, all tests, the
# docs, and on request a sweep on a real Slurm, and learners for which torch is installed. All in the development profile, in which what computes is optimised (Cargo.toml).
# Skipped tests are listed at the end, and are failures unless ONEIRO_MAY_SKIP names the missing thing: by default the
# recordings of a real robot, which can't be installed. docs/testing.md has more; tests/long.sh has longer tests.
set -euo pipefail
# Where nothing is built a second time, nothing is kept for that.
[ -z "${CI:-}" ] || export CARGO_INCREMENTAL=0
slurm= learning=
for option in "$@"; do
    case $option in
    --with-slurm) slurm=yes ;;
    --with-learning) learning=--with-learning ;;
    *)
        echo "usage: $0 [--with-slurm] [--with-learning]" >&2
        exit 2
        ;;
    esac
done
cd "$(dirname "$0")/.."
. tests/install.sh
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

# The GPU tests run on Mesa's software driver, on any machine.
has_software_vulkan() {
    local driver
    ldconfig -p 2>/dev/null | grep 'libvulkan\.so\.1' >/dev/null || return 1
    for driver in /usr/share/vulkan/icd.d/lvp_icd*.json /etc/vulkan/icd.d/lvp_icd*.json; do
        [ -e "$driver" ] && return
    done
    return 1
}

software_vulkan() {
    has_software_vulkan && return
    say "installing the software Vulkan driver"
    install mesa-vulkan-drivers libvulkan1 && has_software_vulkan && return
    echo "no software Vulkan driver (lavapipe), and it could not be installed: the GPU tests need it" >&2
    exit 4
}

# 64-bit ARM: its lane code is compiled and run under an emulator if the tools are available.
arm_tools() {
    command -v qemu-aarch64 >/dev/null && command -v aarch64-linux-gnu-gcc >/dev/null && return
    say "installing an emulator and a linker for 64-bit ARM"
    install qemu-user gcc-aarch64-linux-gnu libc6-dev-arm64-cross ||
        echo "64-bit ARM: no emulator or linker; its lane code will not be tested"
}

# The page that plays a swarm is opened in a browser if one is available.
browser() {
    local name
    for name in chromium chromium-browser google-chrome; do
        command -v "$name" >/dev/null && return
    done
    say "installing a browser"
    install chromium || echo "no browser: the page that plays a swarm will not be tested in one"
}

# The compiler's output is checked by a validator if it is available.
validator() {
    command -v spirv-val >/dev/null && return
    say "installing a validator of SPIR-V"
    install spirv-tools || echo "no validator: SPIR-V will not be validated"
}

# Robots are driven in a simulator if it is available.
simulator() {
    local name
    for name in asebaplayground asebaswitch faketime ip unshare; do
        command -v "$name" >/dev/null && continue
        say "installing a simulator of robots"
        install aseba faketime iproute2 util-linux || echo "no asebaplayground: robots will not be driven in it"
        return
    done
}

software_vulkan
arm_tools
browser
validator
simulator

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
    start "$@"
    jobs[lowered]=$started
    wait "$started"
    unset "jobs[lowered]"
}
finish() {
    local group
    for group in "${jobs[@]}"; do kill -- -"$group" 2>/dev/null || true; done
    rm -rf "$output"
    say "what each stage took"
    printf '%s\n' "${stages[@]}"
}
trap finish EXIT

# With what other stages leave of the processors.
beside "64-bit ARM" 19 tests/aarch64.sh

say "formatting"
cargo fmt --all --check

say "lints"
cargo clippy --workspace --all-targets --features oneiro-host/parquet --locked -- -D warnings

say "documentation"
# With the examples, what these need counts as well: all is then checked as for the lints, and nothing a second time.
RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --features oneiro-host/parquet --no-deps --lib --examples --quiet

say "the program without the GPU backend, as on robots"
cargo clippy --locked -p oneiro-host --no-default-features --all-targets -- -D warnings

say "building the tests"
all=(cargo test --locked --workspace --features oneiro-host/parquet)
"${all[@]}" --no-run

# Tests that wait for robots in real time leave the processors idle, and must get them at once when they need them: they run beside
# all others, which have a lower priority. The patterns of the others are all names but those that begin with `rea`, and `rapier`.
beside "robots in real time" 0 "${all[@]}" --test 'real_time_*'
beside "Python" 5 bash -ec "tests/python-package.sh $learning; tests/python.sh; tests/optimisers.sh; tests/recompute.sh; tests/peers.sh"
say "all other tests"
# Kernels have no tests in their library, and would be compiled a second time.
lowered 10 "${all[@]}" --exclude oneiro-shaders --lib
lowered 10 "${all[@]}" --test '[!r]*' --test 'r[!ae]*' --test 'ra[!p]*' --test 're[!a]*'
lowered 10 "${all[@]}" --doc

join "robots in real time"
join "Python"
[ -z "$slurm" ] || tests/slurm.sh
join "64-bit ARM"

say "what was skipped"
skip_summary

say "all is well"
