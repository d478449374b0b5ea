#!/usr/bin/env bash
# long.sh: tests that take too long for tests/all.sh, on a machine where that has passed: both studies with all their
# parts, large swarms compared with another physics engine, champions that live in Aseba's simulator, random kernels and
# files for half an hour, random bytes for drivers of robots for ten minutes and by radio for another ten (all of them by
# what processors give, so that a busy machine does no less), a whole robot that is sampled, runs and sweeps that are
# killed thousands of times, long lives on every device, the size of the program for a robot, machine code for cards that
# are not there, a hundred thousand runs, and bare machines. Some three and a half hours on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
export ONEIRO_LONG=1
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")

say() { printf '\n== %s (%s s so far)\n' "$*" "$SECONDS"; }
long() { cargo test --release --locked --workspace --features oneiro-host/parquet "$@"; }

tests/tools.sh

say "long lives on every lane code and adapter; both studies with all their parts"
long --test library --test program -- --include-ignored goldens:: parity::

say "a hundred thousand lives by specialised kernels"
long --test library gpu::a_hundred_thousand -- --include-ignored --nocapture

say "a network of 65,536 genes on a software driver"
long --test library network::the_largest -- --include-ignored

say "all experiments and sweeps begin on a software driver, and unequal swarms end as on the CPU"
long --test program shipped:: -- --nocapture

say "every command under little memory and few descriptors"
long --test program ends:: -- --nocapture

say "machine code for cards of AMD, NVIDIA and Intel"
tests/machine-code.sh --release

say "random kernels; experiments, sweeps and parts with random mistakes"
long --test compiler --test native --test library -- random:: mutants::

say "every float of each function of ordinary WGSL"
long --test native ordinary:: -- --nocapture
long -p oneiro-lab --lib mutants

say "every key in every place that takes it"
long --lib -- what_is_accepted_has_an_effect each_key_of_an_experiment

say "ten thousand parts drawn or changed at random, by all code"
long --test program one_hash:: -- --nocapture

say "five minutes of robots that are driven from outside"
long --test library minds_outside

say "a hundred thousand lives of each well-known experiment on every device"
long --test program classics::the_same_bits -- --nocapture

say "controllers in other languages and on other processors, all cycles"
long --test library export:: chips:: -- --include-ignored --nocapture
long --test program export:: -- --include-ignored --nocapture
tests/micropython.sh --release

say "all pinned worlds on emulated 64-bit ARM"
tests/aarch64.sh
say "a thousand lives of each there"
arm=$(tests/aarch64.sh --program)
ONEIRO_ARM_PROGRAM=$arm long --test program emulated_arm -- --include-ignored --nocapture

say "anything over the links of robots"
long --lib -- fuzz:: a_file_may_have_anything

say "a whole robot is sampled, 20 rows of two objects and all motor states, and killed ten times on the way"
long --lib -- a_robot_is_sampled_into --nocapture

say "anything by radio, and two million forged or damaged datagrams"
long -p oneiro-lab --lib -- exchange::radio --nocapture

say "the whole study of 1995, killed, on one thread and on a GPU"
long --test program function_of_

say "a swarm of daemons of which a hundred are killed, and one that lives for a day"
long --test program twins:: -- --include-ignored --nocapture

say "evolution beside a robot that drives"
long --test program evolution_beside -- --ignored --nocapture

say "ten daemons that evolve, in real time; a million hostile datagrams and a hundred thousand lines of a lying tracker"
long --test program real_time::fleets:: -- --nocapture

say "every command that writes, killed at each change of a file and thousands of times at random; foreign files behind every name"
long --test program -- kills:: foreign:: --nocapture
long --test program survives_being_killed
long --test program bytes::are_the_same_after_kills

say "a sweep on a real Slurm"
cargo build --locked -p oneiro-host --features parquet
tests/slurm.sh

say "optimisers, both studies' judgements and clients of robots by what others wrote; learners that need torch"
tests/optimisers.sh
studies/recompute.sh
tests/peers.sh
tests/python-package.sh --with-learning

say "pages in browsers"
cargo build --release --locked
tests/pages.sh
tests/web.sh target/release/oneiro
long --lib --exclude oneiro-shaders random_kernels_do_in_node -- --ignored --nocapture

say "whatever pages and experiments tell a user to type"
long --test program documented:: -- --nocapture

say "robots that another physics engine moves, in crowds too"
long --features oneiro-tests/rapier --test library rapier:: -- --include-ignored

say "a robot sampled in Aseba's simulator, and its champions there"
# One at a time: the simulator has to keep up.
long --test program real_time::transfer:: -- --nocapture --test-threads=1

say "instructions of an on-board generation on 64-bit ARM"
tests/arm-instructions.sh

say "the Python package for 64-bit ARM"
tests/python-arm.sh

say "daemons on 32-bit and 64-bit ARM"
tests/arm-daemons.sh

say "the size of the program for a robot, for this machine"
cargo build --profile robot --locked -p oneiro-host --no-default-features
size=$(stat -c %s "$target/robot/oneiro")
echo "$size bytes"
[ "$size" -lt 8000000 ] || {
    echo "the program for a robot has $size bytes; allowed: fewer than 8000000" >&2
    exit 1
}

say "a hundred thousand runs, in one go and in shards"
cargo build --release --locked -p oneiro-host --features parquet
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cat >"$scratch/tiny.toml" <<'END'
cycles = 20
[evolution]
population = 4
parents = 2
generations = 3
END
cat >"$scratch/sweep.toml" <<'END'
experiment = "tiny.toml"
seeds = "1..50000"
[grid]
noise.motor = [0.0, 0.1]
END
sweep() { "$target/release/oneiro" sweep run "$scratch/sweep.toml" --quiet "$@"; }
sweep --out "$scratch/whole"
for shard in 3 1 2; do
    sweep --out "$scratch/shards" --shard "$shard/3"
done
"$target/release/oneiro" sweep merge "$scratch/shards" --quiet
for table in results.csv generations.csv; do
    cmp "$scratch/whole/$table" "$scratch/shards/$table"
done
[ "$(wc -l <"$scratch/whole/results.csv")" = 100001 ] || {
    echo "there are not a hundred thousand runs" >&2
    exit 1
}

say "what a release publishes"
tests/package.sh

say "the README's commands on bare machines"
tests/fresh.sh

say "all is well"
