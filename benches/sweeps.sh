#!/usr/bin/env bash
# sweeps.sh [ONEIRO [OTHER]]: measures the times of sweeps in docs/measurements.md, in turns with the bench. Takes two and a
# half minutes on two idle cores. With another program, compares the two in turns, without finalists, which versions up to
# 0.1.0 don't have: prints the median over seven pairs of OTHER's time over ONEIRO's, and the same of the bench's rates.
set -euo pipefail
oneiro=$(realpath "${1:-target/release/oneiro}")
experiment=$(realpath "$(dirname "$0")/../experiments/khepera-avoidance.toml")
other=${2:+$(realpath "$2")}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# A sweep's file: its name, its seeds, and what else it says.
sweep() { printf 'experiment = "%s"\nseeds = "%s"\n%s\n' "$experiment" "$2" "${3:-}" >"$1.toml"; }
# own PROGRAM NAME OUT: copies a sweep's file, with the program's own experiment, and no finalists where it has them.
own() {
    "$1" new "$3-experiment" --quiet
    sed -i 's/^finalists = .*/finalists = 0/' "$3-experiment.toml"
    sed "1s/=.*/= \"$3-experiment.toml\"/" "$2.toml" >"$3.toml"
}
timed() { TIMEFORMAT="$1: %R s"; shift; time "$@" >/dev/null; }
run() { rm -rf out; timed "$1" "$oneiro" sweep run "$2.toml" --out out --backend cpu --quiet "${@:3}"; }
bench() { "$oneiro" device bench --backend cpu --rollouts 10000 --quick 2>/dev/null | tail -n 2; }

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

if [ "$other" ]; then
    shopt -s inherit_errexit
    seconds() {
        local from=$EPOCHREALTIME
        rm -rf out
        "$1" sweep run "$2.toml" --out out --backend cpu --quiet --yes >/dev/null
        awk "BEGIN { print $EPOCHREALTIME - $from }"
    }
    quick=(bench --backend cpu --rollouts 10000 --quick)
    # Older programs have `bench` itself as a command.
    rate() { { "$1" device "${quick[@]}" || "$1" "${quick[@]}"; } 2>/dev/null | awk '/x$/ { rate = $(NF - 1) } END { print rate }'; }
    quotient() { awk "BEGIN { print $1 / $2 }"; }
    of_times() {
        local others own
        others=$(seconds "$other" others)
        own=$(seconds "$oneiro" own)
        quotient "$others" "$own"
    }
    of_rates() {
        local own others
        own=$(rate "$oneiro")
        others=$(rate "$other")
        quotient "$own" "$others"
    }
    # Runs a command that prints a number seven times, and prints their median.
    median() { for pair in 1 2 3 4 5 6 7; do "$@"; done | sort -n | sed -n 4p; }
    for name in runs100 alike unlike lives; do
        rm -f own-experiment.toml others-experiment.toml
        own "$oneiro" $name own
        own "$other" $name others
        echo "$name: $(median of_times)"
    done
    echo "bench: $(median of_rates)"
    exit
fi

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
