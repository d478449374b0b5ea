#!/usr/bin/env bash
# arm-daemons.sh: the program for robots' computers, built for 32-bit ARM (ARMv7) and for 64-bit ARM: its size, and the record of a
# swarm whose daemons run it on emulated processors, which is that of daemons on this machine, to the last bit. Needs qemu, linkers
# for both, and Rust's standard library for both. Building takes minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/skips.sh

limit=8000000
not_run() {
    skipped arm "no daemon was built for ARM: $*"
    exit 0
}
for tool in qemu-arm qemu-aarch64 arm-linux-gnueabihf-gcc aarch64-linux-gnu-gcc; do
    command -v $tool >/dev/null || not_run "there is no $tool (Debian: qemu-user, gcc-arm-linux-gnueabihf, gcc-aarch64-linux-gnu)"
done
library() { [ -d "$(rustc --print sysroot)/lib/rustlib/$1/lib" ] || rustup target add "$1" >/dev/null 2>&1; }
for target in armv7-unknown-linux-gnueabihf aarch64-unknown-linux-gnu; do
    library $target || not_run "there is no standard library (rustup target add $target)"
done
export CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_LINKER=arm-linux-gnueabihf-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc

folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cargo build --release --locked -p oneiro-host --no-default-features --features twin
oneiro=$folder/release/oneiro

# Three robots for two minutes, with intervals of 20 s, of whose datagrams a tenth is lost.
sed -e 's/^robots = 10/robots = 3/' \
    -e 's/^\[swarm\]/[swarm]\nminutes = 2\nlight_moves_minute = 0\nclock.interval_s = 20\nclock.installed_s = 10/' \
    experiments/odowd2014-over.toml >"$scratch/experiment.toml"
cat >"$scratch/fleet.toml" <<'END'
experiment = "experiment.toml"
seed = 5
key = "experiment.key"
operator = "10.0.0.1:4711"
binary = "oneiro"
tracker.listen = "0.0.0.0:5005"
robots = [
    { number = 0, host = "pi@10.0.1.0", address = "serial:/dev/rfcomm0" },
    { number = 1, host = "pi@10.0.1.1", address = "serial:/dev/rfcomm0" },
    { number = 2, host = "pi@10.0.1.2", address = "serial:/dev/rfcomm0" },
]
END
printf 'seed = 3\n[[packets]]\nlatency_ms = [1.0, 20.0]\nlost = 0.1\n' >"$scratch/faults.toml"
"$oneiro" fleet key "$scratch/experiment.key"

# record NAME [OPTION...]: the hash of what daemons do.
record() {
    local name=$1
    shift
    "$oneiro" fleet twin "$scratch/fleet.toml" --faults "$scratch/faults.toml" --out "$scratch/$name" --quiet "$@"
}
here=$(record here)
echo "this machine: $here"

# daemons TARGET EMULATOR
daemons() {
    local program=$folder/$1/robot/oneiro size there
    cargo build --profile robot --locked -p oneiro-host --no-default-features --target "$1"
    size=$(stat -c %s "$program")
    printf '#!/bin/sh\nexec %s %s "$@"\n' "$2" "$program" >"$scratch/$1.sh"
    chmod +x "$scratch/$1.sh"
    there=$(record "$1" --program "$scratch/$1.sh")
    echo "$1: $there; $size bytes"
    [ "$there" = "$here" ] || {
        echo "daemons for $1 do something else than on this machine" >&2
        exit 1
    }
    [ "$size" -lt $limit ] || {
        echo "the program for $1 has $size bytes; allowed: fewer than $limit" >&2
        exit 1
    }
}
daemons armv7-unknown-linux-gnueabihf "qemu-arm -L /usr/arm-linux-gnueabihf"
daemons aarch64-unknown-linux-gnu "qemu-aarch64 -L /usr/aarch64-linux-gnu"
