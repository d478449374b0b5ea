#!/usr/bin/env bash
# arm-instructions.sh: how many instructions an on-board generation of the 2014 study takes on 64-bit ARM (ten controllers, 600
# cycles each), by the scalar and the NEON lane code, counted on an emulated processor; and what that would take on a Raspberry Pi
# Zero 2. Needs qemu with plugins, compilers for both machines, and Rust's standard library for ARM. Building takes minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/skips.sh

arm=aarch64-unknown-linux-gnu
not_run() {
    skipped arm "instructions were not counted: $*"
    exit 0
}
command -v qemu-aarch64 >/dev/null || not_run "there is no qemu-aarch64 (Debian: qemu-user)"
command -v aarch64-linux-gnu-gcc >/dev/null || not_run "there is no compiler (Debian: gcc-aarch64-linux-gnu)"
command -v cc >/dev/null || not_run "there is no C compiler (Debian: gcc)"
[ -d "$(rustc --print sysroot)/lib/rustlib/$arm/lib" ] || not_run "there is no standard library (rustup target add $arm)"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cc -O2 -Wall -shared -fPIC -o "$scratch/instructions.so" tests/arm/instructions.c

# counted COMMAND...: the instructions that it executes.
counted() {
    qemu-aarch64 -L /usr/aarch64-linux-gnu -plugin "file=$scratch/instructions.so" "$@" 2>&1 >/dev/null |
        sed -n 's/^\([0-9]*\) instructions$/\1/p'
}

# The counter is right: a million turns of a loop of four instructions are four million.
cat >"$scratch/loop.S" <<'END'
    .global _start
_start:
    mov x0, #0
    ldr x1, [sp]
    sub x1, x1, #1
    mov x2, #0x4240
    movk x2, #0xf, lsl #16
    mul x1, x1, x2
    cbz x1, 2f
1:  nop
    add x0, x0, #1
    cmp x0, x1
    b.ne 1b
2:  mov x0, #0
    mov x8, #93
    svc #0
END
aarch64-linux-gnu-gcc -nostdlib -static -o "$scratch/loop" "$scratch/loop.S"
loop=$(($(counted "$scratch/loop" again) - $(counted "$scratch/loop")))
[ "$loop" = 4000000 ] || {
    echo "a loop of 4,000,000 instructions is counted as $loop" >&2
    exit 1
}

CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
    cargo bench --no-run --locked --target $arm --no-default-features --bench on_board --message-format json |
    sed -n 's/.*"executable":"\([^"]*on_board[^"]*\)".*/\1/p' >"$scratch/program"
program=$(cat "$scratch/program")

few=5 many=25
printf '%-10s %16s %14s %22s %22s\n' "" instructions "per cycle" "s at 1 a clock tick" "s at 1 in 2 ticks"
for lane_code in scalarx1 neonx16; do
    [ "$(counted "$program" $lane_code 1)" -gt 0 ]
    # What the program needs to start is in both.
    generation=$((($(counted "$program" $lane_code $many) - $(counted "$program" $lane_code $few)) / (many - few)))
    awk -v name=$lane_code -v count=$generation \
        'BEGIN { printf "%-10s %16d %14.0f %22.3f %22.3f\n", name, count, count / 6000, count / 1e9, count / 5e8 }'
done
echo "on a Cortex-A53 at 1 GHz, if it executes one instruction in each clock tick, or in every other; the robot of 2014 took 34 s"
