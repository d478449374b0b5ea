#!/usr/bin/env bash
# pages.sh [PROGRAM]: opens a page of each kind in Chromium and in Firefox, in both colour schemes and three widths, with tests/pages.mjs:
# no message on the console, nothing wider than the window, no serious finding of axe; the curve of `oneiro watch --edit` in sight beside its
# form; how soon and how smoothly pages of episodes are drawn; and with tests/watched-day.mjs the memory of a run's page after a day. Pictures
# of all are in target/pages. Installs the browsers and what it needs from npm.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
root=$PWD
program=$(realpath "${1:-target/release/oneiro}")
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/pages")
command -v chromium >/dev/null && command -v firefox-esr >/dev/null || install chromium firefox-esr
# Not with them: where Node is not Debian's, npm came with it.
command -v npm >/dev/null || install npm
mkdir -p "$folder"
npm install --silent --no-fund --no-audit --prefix "$folder" puppeteer-core@24 axe-core@4
cp tests/pages.mjs tests/watched-day.mjs "$folder"
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
# Long enough that its curve has as many points as any.
say run first.toml --seed 1 --out long --set evolution.generations=5000 --set evolution.population=20 --set evolution.parents=4 --set evolution.finalists=0
cd ..
trap 'kill $(jobs -p)' EXIT
# serve WORDS..: begins `oneiro watch` of these, and sets $address to its page.
serve() {
    : >served
    "$program" watch --port 0 "$@" >served &
    until address=$(grep -o 'http://[^ ]*' served); do sleep 0.1; done
}
serve --edit pages/first.toml pages/single pages/other
find pages -name '*.html' | sort | xargs node pages.mjs "$address"
serve pages/long
node watched-day.mjs "$address"
