#!/usr/bin/env bash
# pictures.sh PROGRAM: takes the documentation's pictures of pages, docs/swarms-page.png, docs/learning-page.png and
# docs/watch-page.png. Needs chromium.
set -euo pipefail
program=$(realpath "${1:?usage: docs/pictures.sh PROGRAM, such as target/release/oneiro}")
docs=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# take PAGE#PLACE PICTURE MILLISECONDS HEIGHT: the page of a file at that place, after some time.
take() {
    chromium --headless --no-sandbox --disable-gpu --user-data-dir="$folder/profile" --window-size=1280,"${4:-800}" \
        --virtual-time-budget="${3:-3000}" --screenshot="$docs/$2" "file://$folder/$1" 2>/dev/null
}

"$program" new --example gather
"$program" run gather.toml --seed 1 --out swarm --quiet
"$program" replay swarm --quiet
take 'swarm/replay-0.html#t=24&robot=6' swarms-page.png

"$program" new first
"$program" run first.toml --seed 1 --out first --quiet
"$program" replay first --generations 0,3,10,199 --quiet
take 'first/learning.html#t=20' learning-page.png 3000 900

for noise in 0.0 0.3; do
    "$program" run first.toml --seeds 1..3 --set "noise.motor=$noise" --quiet
done
"$program" watch --snapshot watch.html
take watch.html watch-page.png 12000
