#!/usr/bin/env bash
# watch.sh [ONEIRO]: measures `oneiro run --watch` for docs/measurements.md: when the first curve and the first episode are served, what the
# page costs a run, in turns without it, with it, and with a reader that fetches what the page's script fetches; and the page of a run of a
# million generations. Takes four minutes on two cores. Needs curl.
set -euo pipefail
oneiro=$(realpath "${1:-target/release/oneiro}")
scratch=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; wait; rm -rf "$scratch"' EXIT
cd "$scratch"
"$oneiro" new first --quiet

now() { date +%s.%N; }
minus() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.3f\n", a - b }'; }
median() { sort -n | awk '{ own[NR] = $1 } END { print (own[int((NR + 1) / 2)] + own[int(NR / 2) + 1]) / 2 }'; }

# begin OPTION..: starts a run in out, and its page if asked to; `link`, `token` and `port` are the page's.
begin() {
    rm -rf out said
    "$oneiro" run first.toml --seed 1 --out out --quiet "$@" >/dev/null 2>said &
    run=$!
    [[ " $* " = *" --watch "* ]] || return 0
    until link=$(grep -so 'http://[^ ]*' said); do sleep 0.005; done
    token=${link#*token=} port=${link#*127.0.0.1:} port=${port%%/*}
}
get() { curl -s --max-time 5 -b "oneiro-$port=$token" "http://127.0.0.1:$port/$1"; }
# The first source that the page is told of.
source_id() { timeout 5 curl -sN -b "oneiro-$port=$token" "http://127.0.0.1:$port/events" | grep -m 1 -o '"id":"[0-9a-f]*"' | cut -d '"' -f 4 || true; }
# What the page's script does: it listens, and fetches the curve and the scene once a second.
reader() {
    local id events
    curl -sN -b "oneiro-$port=$token" "http://127.0.0.1:$port/events" >/dev/null &
    events=$!
    id=$(source_id)
    until [ -e out/DONE ]; do
        get "curve/$id?width=600" >/dev/null
        get "scene/$id" >/dev/null
        sleep 1
    done
    kill "$events"
}
# Seconds from a run's configuration to its last file.
took() { minus "$(stat -c %.9Y out/DONE)" "$(stat -c %.9Y out/config.toml)"; }

echo "seconds from the link to the first curve, and to the first episode"
for _ in 1 2 3 4 5; do
    begin --set evolution.generations=20000 --watch
    opened=$(now)
    curl -s "$link" >/dev/null
    id=$(source_id)
    until get "curve/$id?width=600" | grep -c '<polyline' >/dev/null; do sleep 0.02; done
    curve=$(now)
    until generation=$(get "scene/$id" | grep -o '"generation":[0-9]*'); do sleep 0.02; done
    get "episode/$id/${generation#*:}" | grep -c '<canvas' >/dev/null
    echo "$(minus "$curve" "$opened") $(minus "$(now)" "$opened")"
    kill "$run"
    wait "$run" || true
done

# Processor seconds of the page's process so far.
page_took() { awk -v tick="$(getconf CLK_TCK)" '{ print ($14 + $15) / tick }' "/proc/$(pgrep -f "$oneiro watch --beside")/stat"; }

echo "processor seconds of the page's process as a fraction of those of all processors during the run: without and with a reader"
for kind in page reader; do
    begin --set evolution.generations=40000 --watch
    if [ "$kind" = reader ]; then reader; else until [ -e out/DONE ]; do sleep 0.1; done; fi
    spent=$(page_took)
    wait "$run"
    awk -v kind="$kind" -v spent="$spent" -v took="$(took)" -v cores="$(nproc)" \
        'BEGIN { printf "%s: %.2f s of %d times %.1f s: %.2f %%\n", kind, spent, cores, took, 100 * spent / took / cores }'
done

echo "seconds of a run alone, with the page, and with a reader; then both over the first (median)"
for _ in 1 2 3 4 5 6 7 8 9; do
    begin --set evolution.generations=12000
    wait "$run"
    alone=$(took)
    begin --set evolution.generations=12000 --watch
    wait "$run"
    page=$(took)
    begin --set evolution.generations=12000 --watch
    reader
    wait "$run"
    echo "$alone $page $(took)"
done | tee times
awk '{ print $2 / $1 }' times | median
awk '{ print $3 / $1 }' times | median

echo "a million generations: bytes of the curve and of the list, and memory of the page's process"
begin --set evolution.generations=1000000 --set evolution.population=4 --set evolution.parents=1 --set cycles=20 \
    --set evolution.finalists=0 --set record.checkpoint_every=50000 --watch
curl -sN -b "oneiro-$port=$token" "http://127.0.0.1:$port/events" >events &
id=$(source_id)
until [ -e out/DONE ]; do sleep 0.5; done
sleep 1
get "curve/$id?width=600" | wc -c
tail -n 2 events | wc -c
ps -o rss=,args= -C oneiro | awk '/watch --beside/ { print $1 " kB" }'
