#!/usr/bin/env bash
# What docs/measurements.md says of sweeps, measured again, in turns with the bench: sweeps.sh [ONEIRO]. Two minutes and
# a half on two cores that have nothing else to do.
set -euo pipefail
oneiro=$(realpath "${1:-target/release/oneiro}")
experiment=$(realpath "$(dirname "$0")/../experiments/khepera-avoidance.toml")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# A sweep's file: its name, its seeds, and what else it says.
sweep() { printf 'experiment = "%s"\nseeds = "%s"\n%s\n' "$experiment" "$2" "${3:-}" >"$1.toml"; }
timed() { TIMEFORMAT="$1: %R s"; shift; time "$@" >/dev/null; }
run() { rm -rf out; timed "$1" "$oneiro" sweep run "$2.toml" --out out --backend cpu --quiet "${@:3}"; }
bench() { "$oneiro" bench --backend cpu --rollouts 10000 --quick 2>/dev/null | tail -n 2; }

small='[set]
evolution.population = 20
evolution.parents = 4
[grid]'
sweep runs10 1..10
sweep runs100 1..100
sweep runs1000 1..1000
sweep alike 1..20 "$small
evolution.mutation.rate = [0.05, 0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]"
sweep unlike 1..20 "$small
noise.motor = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09]"
drawn='[random.ranges]
evolution.mutation.rate = { from = 0.0, to = 1.0 }'
sweep seeds 1..100 "[random]
samples = 1000
$drawn"
sweep cells 1..1 "[random]
samples = 100000
$drawn
noise.motor = { from = 0.0, to = 1.0 }"
sweep lives 1..100 "[set]
cycles = 10
evolution.population = 4
evolution.parents = 2
evolution.generations = 3
[random]
samples = 1000
$drawn"

bench
run "1,000 runs, 10 billion steps" runs1000
bench
for turn in 1 2 3; do
    run "10 runs" runs10
    run "100 runs" runs100
    run "200 runs of 20 individuals" alike
    run "200 of them in ten worlds with motor noise" unlike
done
run "200 runs of 20 individuals, one at a time" alike --jobs 1
bench
timed "plan, 1,000 cells from 100 seeds" "$oneiro" sweep plan seeds.toml
timed "plan, 100,000 cells" "$oneiro" sweep plan cells.toml --no-estimate
timed "plan, 100,000 cells, devices timed" "$oneiro" sweep plan cells.toml
run "100,000 runs of 12 lives" lives --yes
timed "status of them" "$oneiro" sweep status out
timed "report of them" "$oneiro" sweep report out
