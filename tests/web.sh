#!/usr/bin/env bash
# web.sh [PROGRAM]: builds the page that evolves in a browser, compares the hashes of its runs in node with the program's (tests/web.mjs),
# and evolves in Chromium, also what is compiled there (tests/web-page.mjs).
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
program=$(realpath "${1:-target/debug/oneiro}")
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/web")
command -v chromium >/dev/null || install chromium
# Not with it: where Node is not Debian's, npm came with it.
command -v npm >/dev/null || install npm
web/build.sh
node tests/web.mjs "$folder/site" "$program"

result=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server"; rm -rf "$result"' EXIT
# hash NAME SETTING..: the hash of the program's run.
hash() {
    local name=$1
    shift
    "$program" run "experiments/$name.toml" --seed 1 --out "$result/$name" --quiet "$@" >/dev/null
    sed -n 's/.*"result": "\([0-9a-f]*\)".*/\1/p' "$result/$name/DONE"
}
# A plain file server.
python3 -u -m http.server --bind 127.0.0.1 --directory "$folder/site" 0 >"$result/server" 2>/dev/null &
server=$!
until port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$result/server") && [ -n "$port" ]; do sleep 0.1; done
npm install --silent --no-fund --no-audit --prefix "$folder" puppeteer-core@24
cp tests/web-page.mjs "$folder"
node "$folder/web-page.mjs" "http://127.0.0.1:$port/" "$folder/page.png" 'seed=1&go' "$(hash khepera-avoidance)" \
    'example=gather&set=evolution.generations%3D3&seed=1&go' "$(hash gather --set evolution.generations=3)"
