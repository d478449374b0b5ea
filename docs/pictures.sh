#!/usr/bin/env bash
# pictures.sh PROGRAM: takes the documentation's pictures of pages, docs/swarms-page.png and docs/learning-page.png. Needs chromium.
set -euo pipefail
program=$(realpath "${1:?usage: docs/pictures.sh PROGRAM, such as target/release/oneiro}")
docs=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# take PAGE#PLACE PICTURE: the page at that place, paused there.
take() {
    chromium --headless --no-sandbox --disable-gpu --user-data-dir="$folder/profile" --window-size=1280,800 \
        --virtual-time-budget=3000 --screenshot="$docs/$2" "file://$folder/$1" 2>/dev/null
}

"$program" new --example gather
"$program" run gather.toml --seed 1 --out swarm --quiet
"$program" replay swarm --quiet
take 'swarm/replay-0.html#t=24&robot=6' swarms-page.png

"$program" new first
"$program" run first.toml --seed 1 --out first --quiet
"$program" replay first --generations 0,3,10,199 --quiet
take 'first/learning.html#t=20' learning-page.png
