#!/usr/bin/env bash
# aarch64.sh [--program]: the lane code for 64-bit ARM on an emulated processor, compiled ahead and at run time: every
# operation, the compiler's corpus, and lives, all with the bits that are pinned; random kernels; and the optimisers, with
# pinned bits too. With --program it only builds the program for 64-bit ARM and prints the path of a script that runs it on
# the emulated processor. Needs qemu, a linker for ARM, and Rust's standard library for it: rustup's, or Debian's with its
# compiler.
set -euo pipefail
case $* in
"" | --program) ;;
*)
    echo "usage: $0 [--program]" >&2
    exit 2
    ;;
esac
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

wanted=$*
arm=aarch64-unknown-linux-gnu
say() { printf '\n== 64-bit ARM: %s\n' "$*"; }
not_run() {
    [ -z "$wanted" ] || {
        echo "the program for 64-bit ARM can't be built: $*" >&2
        exit 1
    }
    skipped arm "its lane code is not even type-checked: $*"
    exit 0
}
has_tools() { command -v qemu-aarch64 >/dev/null && command -v aarch64-linux-gnu-gcc >/dev/null; }
has_tools || install qemu-user gcc-aarch64-linux-gnu libc6-dev-arm64-cross || true
command -v qemu-aarch64 >/dev/null || not_run "there is no qemu-aarch64 (Debian: qemu-user)"
command -v aarch64-linux-gnu-gcc >/dev/null || not_run "there is no linker (Debian: gcc-aarch64-linux-gnu)"

folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
has_library() { [ -d "$(rustc --print sysroot)/lib/rustlib/$arm/lib" ]; }
has_library || timeout 60 rustup target add $arm >/dev/null 2>&1 || true
# A folder of its own: two compilers must not share one, and other stages build at the same time.
emulated=(env CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_LTO=off CARGO_TARGET_DIR="$folder/aarch64")
if ! has_library; then
    say "getting Debian's compiler" >&2
    problem=$(tests/debian-rust.sh "$folder/debian-rust") || not_run "$problem"
    emulated+=(RUSTC="$folder/debian-rust/rustc")
fi
emulated+=(
    CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
)

# Little optimisation, and none of the program: bits don't depend on it, and compiling takes most of the time.
options=(--release --locked --target $arm --no-default-features)
for crate in tests host base evolve fleet lab report robots statistics studies; do
    options+=(--config "profile.release.package.oneiro-$crate.opt-level=0")
done

if [ "$wanted" = --program ]; then
    "${emulated[@]}" cargo build "${options[@]}" -p oneiro-host --features native >&2
    script=$folder/aarch64/oneiro
    printf '#!/bin/sh\nexec qemu-aarch64 -L /usr/aarch64-linux-gnu "%s" "$@"\n' "$folder/aarch64/$arm/release/oneiro" >"$script"
    chmod +x "$script"
    echo "$script"
    exit
fi

packages=(-p oneiro-shader-corpus -p oneiro-shader-native -p oneiro-tests --features oneiro-tests/native)
say "operations, corpus and lives on qemu"
"${emulated[@]}" cargo test "${options[@]}" "${packages[@]}" --test corpus --test library --test native -- \
    variants:: operations:: goldens:: random:: kernels::
# The rest of the program would take as long to compile as naga and Cranelift: tests/long.sh runs it on ARM.
say "optimisers, restored between any two generations"
"${emulated[@]}" cargo test "${options[@]}" -p oneiro-evolve --lib -- optimisers_are_as_pinned | tee "$folder/aarch64/optimisers"
grep -q "^test result: ok. 1 passed" "$folder/aarch64/optimisers"
say "the bits are those of tests/goldens/kernels and tests/goldens/optimisers"
