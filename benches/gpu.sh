#!/usr/bin/env bash
# gpu.sh [ONEIRO [BACKEND [FOLDER]]]: measures a card's bits and speed as docs/gpu.md has them, by the program alone. Takes minutes on a
# fast card. BACKEND is a name as of `oneiro device list`, such as gpu:0; by default the best GPU. FOLDER, `gpu-figures` by default, gets:
#   devices.json        what is here, and registers and instructions of all kernels where the driver tells
#   selftest.json       differing bits of both kinds of kernels, over lives of all worlds
#   steps-*.json        steps per second of 10^3 to 10^7 rollouts, by the kernel for any world and by specialised ones
#   kernel-*.json       steps per second of other kernels and worlds, specialised
#   cpu.json            steps per second of the processor
#   cost.json           the operations of a cycle, and the most that cards can do
#   sweep.txt           time of 1,000 evolutions of the 1995 experiment, on the GPU and on the processor, and their results' hash
#   share.json          what to send to others
# With SMALL=1 it takes two minutes on a software GPU, to try the script.
set -euo pipefail
oneiro=$(realpath "${1:-target/release/oneiro}")
backend=${2:-gpu}
folder=${3:-gpu-figures}
experiments=$(realpath "$(dirname "$0")/../experiments")
mkdir -p "$folder"
cd "$folder"
if [ "${SMALL:-}" ]; then
    sizes=1000,10000 others=1000 members=100 lives=1000 seeds=1..2
else
    # A million rollouts of each kind of controller are 10^9 steps and more.
    sizes=1000,10000,100000,1000000,10000000 others=10000,100000,1000000 members=1000,10000,100000 lives=1000000 seeds=1..1000
fi
say() { echo "$(date +%T) $*" >&2; }
bench() { "$oneiro" device bench --quick --backend "$backend" --json "$@"; }

say "what is here"
"$oneiro" device list --explain --json >devices.json
for when in never always; do
    say "steps per second, --specialise $when"
    bench --rollouts "$sizes" --specialise "$when" >"steps-$when.json"
done
for name in khepera-sensor-noise khepera-conservative-noise khepera-hidden khepera-recurrent odowd2014-random homing; do
    say "steps per second of $name"
    bench --rollouts "$others" --specialise always "$experiments/$name.toml" >"kernel-$name.json"
done
say "steps per second of twenty robots in a world"
bench --rollouts "$members" --specialise always "$experiments/evostick-foraging.toml" >kernel-evostick-foraging.json
say "what a cycle costs"
"$oneiro" check "$experiments/khepera-avoidance.toml" --cost --json >cost.json
printf 'experiment = "%s"\nseeds = "%s"\n' "$experiments/khepera-avoidance.toml" "$seeds" >sweep.toml
: >sweep.txt
for device in "$backend" cpu; do
    say "a sweep on $device"
    rm -rf out
    TIMEFORMAT="$device: %R s, %U s of processors"
    { time "$oneiro" sweep run sweep.toml --out out --backend "$device" --quiet | head -n 1 >>sweep.txt; } 2>>sweep.txt
done
rm -rf out
say "steps per second of the processor"
"$oneiro" device bench --quick --backend cpu --json --rollouts 10000 >cpu.json
say "differing bits"
"$oneiro" device test --backend "$backend" --rollouts "$lives" --json >selftest.json || say "SOME BITS DIFFER: see selftest.json"
say "what to send to others"
rm -f share.json
"$oneiro" device bench --quick --backend "$backend" --share share.json --quiet >/dev/null
cat sweep.txt
