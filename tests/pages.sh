#!/usr/bin/env bash
# pages.sh [PROGRAM]: opens a page of each kind in Chromium and in Firefox, in both colour schemes and three widths, with tests/pages.mjs:
# no message on the console, nothing wider than the window, no serious finding of axe; the curve of `oneiro watch --edit` in sight beside its
# form; and how soon and how smoothly pages of episodes are drawn. Pictures of all are in target/pages. Installs the browsers and what it
# needs from npm.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
root=$PWD
program=$(realpath "${1:-target/release/oneiro}")
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/pages")
command -v chromium >/dev/null && command -v firefox-esr >/dev/null && command -v npm >/dev/null || install chromium firefox-esr npm
mkdir -p "$folder"
npm install --silent --no-fund --no-audit --prefix "$folder" puppeteer-core@24 axe-core@4
cp tests/pages.mjs "$folder"
cd "$folder"
rm -rf pages pictures
mkdir pages pictures
cd pages

say() { "$program" "$@" --quiet >/dev/null; }
say new first
say run first.toml --seed 1 --out single
say replay single
say replay single --generations 0,3,10,199
say run first.toml --seeds 1..3 --set evolution.generations=20
say run first.toml --seed 9 --out other --set noise.motor=0.3 --set evolution.generations=20
say run "$root/experiments/gather.toml" --seed 1 --out swarm --set evolution.generations=5
say replay swarm
say run "$root/experiments/automode-foraging.toml" --seed 1 --out machines --set evolution.episodes=909
say replay machines
say run "$root/experiments/kheperax-elites.toml" --seed 1 --out elites --set evolution.generations=20
say replay elites --elites
say run "$root/experiments/predator-prey.toml" --seed 1 --out hunt --set evolution.generations=3
say replay hunt
say run "$root/experiments/odowd2014-over.toml" --seed 1 --out foragers --set swarm.minutes=4
say replay foragers
say compare single other --trials 5 --out comparison
cat >sweep.toml <<'END'
name = "noise"
experiment = "first.toml"
seeds = "1..3"

[set]
evolution.generations = 10

[grid]
noise.motor = [0.0, 0.3]
END
say sweep run sweep.toml --out sweep
say sweep report sweep
say watch --snapshot watch.html
cd ..
"$program" watch --edit pages/first.toml pages/single pages/other --port 0 >served &
trap 'kill $!' EXIT
until grep -q token= served; do sleep 0.1; done
find pages -name '*.html' | sort | xargs node pages.mjs "$(grep -o 'http://[^ ]*' served)"
