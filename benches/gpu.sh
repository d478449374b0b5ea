#!/usr/bin/env bash
# gpu.sh [ONEIRO [BACKEND [FOLDER]]]: everything that docs/gpu.md asks of a card, by the program alone. Takes some 20 minutes on a fast
# card. BACKEND is a name as of `oneiro devices`, such as gpu:0; by default the best GPU. FOLDER, `gpu-figures` by default, gets:
#   devices.json        what is here, and registers and instructions of all kernels where the driver tells
#   selftest.json       differing bits of both kinds of kernels, over lives of all worlds
#   steps-*.json        steps per second of 10^3 to 10^7 rollouts, by the kernel for any world and by specialised ones
#   cost.json           the operations of a cycle, and the most that cards can do
#   sweep.txt           time of 1,000 evolutions of the 1995 experiment, on the GPU and on the processor
#   share.json          what to send to others
# With SMALL=1 it takes less than two minutes on a software GPU, to try the script.
set -euo pipefail
oneiro=$(realpath "${1:-target/release/oneiro}")
backend=${2:-gpu}
folder=${3:-gpu-figures}
experiment=$(realpath "$(dirname "$0")/../experiments/khepera-avoidance.toml")
mkdir -p "$folder"
cd "$folder"
if [ "${SMALL:-}" ]; then
    sizes=1000,10000 lives=1000 seeds=1..2
else
    # A million rollouts of each kind of controller are 10^9 steps and more.
    sizes=1000,10000,100000,1000000,10000000 lives=1000000 seeds=1..1000
fi
say() { echo "$(date +%T) $*" >&2; }

say "what is here"
"$oneiro" devices --explain --json >devices.json
say "differing bits"
"$oneiro" selftest --backend "$backend" --rollouts "$lives" --json >selftest.json || say "SOME BITS DIFFER: see selftest.json"
for when in never always; do
    say "steps per second, --specialise $when"
    "$oneiro" bench --backend "$backend" --rollouts "$sizes" --specialise "$when" --json >"steps-$when.json"
done
say "what a cycle costs"
"$oneiro" check "$experiment" --cost --json >cost.json
printf 'experiment = "%s"\nseeds = "%s"\n' "$experiment" "$seeds" >sweep.toml
for device in "$backend" cpu; do
    say "a sweep on $device"
    rm -rf out
    TIMEFORMAT="$device: %R s, %U s of processors"
    { time "$oneiro" sweep run sweep.toml --out out --backend "$device" --quiet >/dev/null; } 2>>sweep.txt
done
rm -rf out
say "what to send to others"
"$oneiro" bench --quick --backend "$backend" --share share.json --quiet >/dev/null
cat sweep.txt
