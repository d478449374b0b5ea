#!/usr/bin/env bash
# recompute.sh: studies/recompute.py judges small sweeps of both studies' second editions as the program does, and notices a
# verdict and a figure that are not the program's; studies/foragers.py computes foraging runs again from their files;
# studies/noise.py and studies/recordings.py print the tables that
# studies/miglino1995/README.md has. Skipped if there is no Python, or its packages aren't available.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
say() { printf '\n== recomputing: %s\n' "$*"; }
fail() {
    echo "recomputing: $*" >&2
    exit 1
}

python_with pandas,scipy,statsmodels pandas scipy statsmodels || {
    skipped python "studies/recompute.py: $problem"
    exit 0
}
[ -x "$folder/debug/oneiro" ] || fail "build the program first: cargo build --features oneiro-host/parquet"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
oneiro() { "$folder/debug/oneiro" "$@"; }

say "a small sweep of each of two severities"
for severity in 0.5 1; do
    # Lives of 300 cycles, long enough for some runs to converge and others not.
    sed -e 's|"\.\./\.\./\.\.|"'"$PWD"'|; s/^seeds = .*/seeds = "1..4"/; /"surrogate:[0-9]*", "surr/d' \
        -e 's/^reality.robot = \[/&"surrogate:1", "surrogate:2", "surrogate:3", "surrogate:4"/' \
        -e 's/^evolution.generations.*/evolution = { generations = 14, population = 40, parents = 8, finalists = 0 }\ncycles = 300/' \
        -e '/^evolution.finalists/d; s/^reality.generations.*/reality.generations = 3/' \
        "studies/miglino1995/second/collision-$severity.toml" >"$scratch/$severity.toml"
    oneiro sweep run "$scratch/$severity.toml" --out "$scratch/$severity" --quiet >/dev/null
done
oneiro reproduce miglino1995 --sweeps "$scratch/0.5,$scratch/1" --out "$scratch/judged"

# recompute DIRECTORY SWEEP..: the sweeps, against what the program said of them.
recompute() { "$python" studies/recompute.py --judged "$@"; }
same() { recompute "$@" | tee "$scratch/printed"; tail -n 1 "$scratch/printed" | grep -q "^0 differences from the program"; }
say "studies/recompute.py"
same "$scratch/judged" "$scratch/0.5" "$scratch/1" || fail "it differs from the program"

# small STUDY PARTS WHAT: a small sweep of a later study at severity 0.5, judged in so many parts.
small() {
    say "a small sweep of studies/miglino1995/$1"
    sed -e 's|"\.\./\.\./\.\.|"'"$PWD"'|; s|^experiment = "experiment|experiment = "'"$PWD/studies/miglino1995/$1"'/experiment|' \
        -e 's/^seeds = .*/seeds = "1..4"/; /"surrogate:[0-9]*", "surr/d' \
        -e 's/^reality.robot = \[/&"surrogate:101", "surrogate:102", "surrogate:103"/' \
        -e 's/^evolution.generations.*/evolution = { generations = 14, population = 40, parents = 8, finalists = 0 }\ncycles = 300/' \
        -e '/^evolution.finalists/d; s/^reality.generations.*/reality.generations = 3/' "studies/miglino1995/$1/severity-0.5.toml" >"$scratch/$1.toml"
    oneiro sweep run "$scratch/$1.toml" --out "$scratch/$1" --quiet >/dev/null
    oneiro reproduce miglino1995 --sweeps "$scratch/$1" --out "$scratch/judged-$1" >/dev/null
    [ "$(tail -n +2 "$scratch/judged-$1/contrasts.csv" | cut -d, -f2 | sort -u | wc -l)" = "$2" ] || fail "not $3 are judged"
    same "$scratch/judged-$1" "$scratch/$1" || fail "it judges studies/miglino1995/$1 otherwise than the program"
}
small third 18 "8 cells, 4 pairs of rules and 6 of readings"
small plastic 3 "2 controllers and their pair"

say "the same with effects: sensor noise made better in the simulator, conservative noise worse in the last generation"
# Columns are counted from the right, since text before them is quoted.
mkdir "$scratch/effects"
awk -F, -v OFS=, 'NR > 1 && /0\.4\]/ { $(NF - 14) += 90; $(NF - 13) += 90 } NR > 1 && /,30\.0,/ { $(NF - 5) -= 90 } { print }' \
    "$scratch/1/results.csv" >"$scratch/effects/results.csv"
oneiro reproduce miglino1995 --sweeps "$scratch/effects" --out "$scratch/judged-effects" >"$scratch/claims"
for outcome in holds undecided opposed; do
    grep -q "$outcome" "$scratch/judged-effects/contrasts.csv" || fail "no contrast has the outcome $outcome"
done
# changed FILE SED: a copy of what the program judged, with a table that was changed so.
changed() {
    cp -r "$scratch/judged-effects" "$scratch/other-$1"
    sed -i "$2" "$scratch/other-$1/$1.csv"
    ! cmp -s "$scratch/other-$1/$1.csv" "$scratch/judged-effects/$1.csv" || fail "CONTROL: nothing was changed in $1.csv by $2"
}
changed claims '2s/,holds,/,undecided,/; t; 2s/,opposed,/,holds,/; t; 2s/,undecided,/,holds,/'
changed contrasts '2s/,yes$/,no/; t; 2s/,no$/,yes/'
changed cells '2s/,\([0-9]\)\([0-9.]*\)$/,1\1\2/'
# Judged once, and compared with all four.
! recompute "$scratch/judged-effects" --judged "$scratch/other-claims" --judged "$scratch/other-contrasts" --judged "$scratch/other-cells" \
    "$scratch/effects" >"$scratch/printed" || fail "CONTROL: changed tables are not noticed"
grep "differences from the program" "$scratch/printed" | tee "$scratch/counts"
[ "$(wc -l <"$scratch/counts")" = 4 ] || fail "it was not compared with four directories"
head -n 1 "$scratch/counts" | grep -q "^0 " || fail "it differs from the program where there are effects"
! tail -n 3 "$scratch/counts" | grep -q "^0 " || fail "CONTROL: a changed claim, contrast or figure is not noticed"

say "a small ensemble of realities, and one in which conservative noise is best in reality"
sed -e 's|"\.\./\.\./\.\.|"'"$PWD"'|; s/^seeds = .*/seeds = [1]/; s/^samples = .*/samples = 6/' \
    -e 's/^evolution.generations.*/evolution = { generations = 14, population = 40, parents = 8, finalists = 0 }\ncycles = 300/' \
    -e '/^evolution.finalists/d; s/^reality.generations.*/reality.generations = 3/' \
    studies/miglino1995/second/ensemble.toml >"$scratch/ensemble.toml"
oneiro sweep run "$scratch/ensemble.toml" --out "$scratch/ensemble" --quiet >/dev/null
awk -F, -v OFS=, 'NR > 1 && /,30\.0,/ { $(NF - 8) += 900 } { print }' "$scratch/ensemble/results.csv" >"$scratch/better.csv"
for table in ensemble/results better; do
    "$python" studies/ensemble.py "$scratch/$table.csv" >"$scratch/shares"
    grep -q "^6 realities, .*; 72 runs$" "$scratch/shares" || fail "the ensemble has other realities"
    awk '$1 == "real" && $2 == 1 { count++ } END { print count + 0 }' "$scratch/shares"
done >"$scratch/counts"
[ "$(tail -n 1 "$scratch/counts")" -ge 2 ] || fail "conservative noise is not best in reality in all realities"
[ "$(head -n 1 "$scratch/counts")" = 0 ] || fail "conservative noise is best in all realities of the small ensemble"

say "the response surface, of gaps that are known"
PYTHONPATH=studies "$python" - <<'END'
import numpy as np, pandas as pd
from ensemble import DIFFERENCES, surface

random = np.random.default_rng(1)
severities = pd.DataFrame(random.uniform(0, 2, (60, 9)), columns=DIFFERENCES)
alone = 25 * severities.latency + random.normal(0, 10, 60)
product = (severities.wheels - 1) * (severities.slip - 1)
rows, whole = surface(severities, {("slide", "alone"): alone, ("slide", "together"): alone + 100 * product})
found = rows[rows["makes the gap"] == "yes"]
assert set(found.difference) == {"latency"}, found
assert 20 < rows[(rows.gap == "alone") & (rows.difference == "latency")]["per severity"].item() < 30, rows
assert list(whole.corrected < 0.05) == [False, True], whole
END

for robot in lives:holds epuck:opposed; do
    say "the 1995 study in Aseba's simulator: $robot"
    lives=studies/miglino1995/elsewhere/${robot%:*}.csv
    # The gap with sensor noise minus that without: the mean over seeds, of the table by awk.
    gap=$(awk -F, '$1 == "slide" && $4 != "on" { sign = ($2 == "sensor") - ($2 == "none"); sum += sign * (($4 == "simulated") - ($4 == "real")) * $6; seeds[$3] }
        END { printf "%.4f", sum / length(seeds) }' "$lives")
    "$python" studies/elsewhere.py "$lives" >"$scratch/elsewhere" || fail "studies/elsewhere.py"
    grep -q "gap, sensor - none .* $gap[0-9]* .* ${robot#*:}" "$scratch/elsewhere" || fail "studies/elsewhere.py has another gap than $gap"
done

# missing: how many lines of the printed tables the document lacks. Each study's are in it, and a changed run changes one.
missing() { grep '^|' "$scratch/printed" | grep -vxF -f studies/miglino1995/README.md | wc -l; }

say "the 1995 study with recordings"
runs=studies/miglino1995/recordings/runs.csv
"$python" studies/recordings.py "$runs" >"$scratch/printed" || fail "studies/recordings.py"
[ "$(grep -c '^|' "$scratch/printed")" = 66 ] || fail "studies/recordings.py prints other tables"
[ "$(missing)" = 0 ] || fail "studies/miglino1995/README.md lacks $(missing) lines of studies/recordings.py"
awk -F, -v OFS=, 'NR > 1 && $1 == "recordings" && $4 == "conservative" { $10 -= 3 } { print }' "$runs" >"$scratch/changed.csv"
"$python" studies/recordings.py "$scratch/changed.csv" >"$scratch/printed" || fail "studies/recordings.py"
[ "$(missing)" != 0 ] || fail "CONTROL: worse lives among the recordings are not noticed"
recordings=${ONEIRO_RECORDINGS:-../shared/data/khepera}
if [ -f "$recordings/wall.sam" ]; then
    "$python" studies/recordings.py --run "$recordings" --out "$scratch/carried" --seeds 1..1 --oneiro "$folder/debug/oneiro"
    [ "$(wc -l <"$scratch/carried/runs.csv")" = 19 ] || fail "the first seed has other rows"
    ! grep -vxF -f "$runs" "$scratch/carried/runs.csv" || fail "the first seed of the recordings gives other rows than $runs has"
else
    skipped recordings "the first seed of the 1995 study with recordings"
fi

say "what five runs of the 1995 study can show"
chances=studies/miglino1995/second/chances.py
runs=studies/miglino1995/second/slide/results.csv
"$python" "$chances" >"$scratch/printed" || fail "$chances"
[ "$(missing)" = 0 ] || fail "studies/miglino1995/README.md lacks $(missing) lines of $chances"
awk -F, -v OFS=, 'NR > 1 && /,30\.0,/ { $(NF - 8) += 9 } { print }' "$runs" >"$scratch/changed.csv"
! "$python" "$chances" "$scratch/changed.csv" >"$scratch/printed" 2>&1 || fail "CONTROL: better lives in reality with conservative noise are not noticed"

say "the 1995 study with other kinds of noise"
runs=studies/miglino1995/noise/runs.csv
"$python" studies/noise.py "$runs" >"$scratch/printed" || fail "studies/noise.py"
[ "$(missing)" = 0 ] || fail "studies/miglino1995/README.md lacks $(missing) lines of studies/noise.py"
awk -F, -v OFS=, 'NR > 1 && $2 == "envelope" { $9 -= 3 } { print }' "$runs" >"$scratch/noise.csv"
"$python" studies/noise.py "$scratch/noise.csv" >"$scratch/printed" || fail "studies/noise.py"
[ "$(missing)" != 0 ] || fail "CONTROL: worse lives in reality with the envelope are not noticed"

say "a small calibration"
sed -e 's|"\.\./\.\./\.\.|"'"$PWD"'|; s/^seeds = .*/seeds = "1..3"/; s/, 1.5, 2.0\]/]/; /"surrogate:[0-9]*", "surr/d' \
    -e 's/^reality.robot = \[/&"surrogate:1001", "surrogate:1002", "surrogate:1003"/' \
    -e 's/^evolution.generations.*/evolution = { generations = 14, population = 40, parents = 8, finalists = 0 }\ncycles = 300/' \
    -e '/^evolution.finalists/d' studies/miglino1995/second/calibration.toml >"$scratch/calibration.toml"
oneiro sweep run "$scratch/calibration.toml" --out "$scratch/calibration" --quiet >/dev/null
oneiro reproduce miglino1995 --sweeps "$scratch/calibration" --out "$scratch/calibrated"
[ "$(grep -c ',yes,' "$scratch/calibrated/calibration.csv")" = 3 ] || fail "not one pair of severities was taken for each rule"
same "$scratch/calibrated" "$scratch/calibration" || fail "it calibrates otherwise than the program"

say "small sweeps of the 2014 study"
# Ten minutes, of which the light moves in the fifth.
for name in random scale-0.2; do
    sed -e 's|"\.\./\.\./\.\.|"'"$PWD"'|; s/^seeds = "1\.\..*/seeds = "1..6"/; s/^seeds = "501.*/seeds = "501..506"/; s/^\[set\]$//' \
        -e 's/^swarm.controllers.mutation_scale = .*//' -e 's/^# Credit makes.*//' "studies/odowd2014/second/$name.toml" >"$scratch/$name.toml"
    printf '[set]\nswarm.minutes = 10\nswarm.light_moves_minute = 5\n' >>"$scratch/$name.toml"
    # Nothing evolves among robots that search at random.
    [ "$name" = random ] || echo 'swarm.controllers.mutation_scale = 0.2' >>"$scratch/$name.toml"
    oneiro sweep run "$scratch/$name.toml" --out "$scratch/$name" --quiet >/dev/null
done
oneiro reproduce odowd2014 --sweeps "$scratch/random,$scratch/scale-0.2" --out "$scratch/judged-2014"
for outcome in holds undecided opposed; do
    grep -q "$outcome" "$scratch/judged-2014/contrasts.csv" || fail "no contrast of 2014 has the outcome $outcome"
done
same "$scratch/judged-2014" "$scratch/random" "$scratch/scale-0.2" || fail "it judges the 2014 study otherwise than the program"

say "the tables of larger swarms"
"$python" studies/scaling.py studies/odowd2014/scaling/runs.csv >"$scratch/printed"
lacks() { grep -vxFf studies/odowd2014/README.md "$scratch/printed" | grep -c . || true; }
[ "$(lacks)" = 0 ] || fail "studies/odowd2014/README.md lacks $(lacks) lines of studies/scaling.py"
sed '2s/[0-9.]*$/50.0/' studies/odowd2014/scaling/runs.csv >"$scratch/swarms.csv"
"$python" studies/scaling.py "$scratch/swarms.csv" >"$scratch/printed"
[ "$(lacks)" != 0 ] || fail "CONTROL: a later match is not noticed"

say "the tables of rivals"
"$python" studies/rivals.py studies/odowd2014/rivals/runs.csv >"$scratch/printed"
[ "$(lacks)" = 0 ] || fail "studies/odowd2014/README.md lacks $(lacks) lines of studies/rivals.py"
sed '2s/[0-9.]*,[0-9.]*$/9,9/' studies/odowd2014/rivals/runs.csv >"$scratch/rivals.csv"
"$python" studies/rivals.py "$scratch/rivals.csv" >"$scratch/printed"
[ "$(lacks)" != 0 ] || fail "CONTROL: more food is not noticed"
# Two of its seeds again, bit for bit.
sed "s|101..160|101..102|; s|../../../|$PWD/|" studies/odowd2014/rivals/rivals.toml >"$scratch/rivals.toml"
oneiro sweep run "$scratch/rivals.toml" --out "$scratch/rivals" --quiet >/dev/null
"$python" studies/rivals.py "$scratch/rivals/results.csv" --keep "$scratch/again.csv" >/dev/null
[ "$(wc -l <"$scratch/again.csv")" = 43 ] || fail "two seeds of rivals have other runs"
! grep -vxFf studies/odowd2014/rivals/runs.csv "$scratch/again.csv" || fail "these runs of rivals differ (above)"

say "the tables of a central simulator"
"$python" studies/rivals.py --study central studies/odowd2014/central/runs.csv >"$scratch/printed"
[ "$(lacks)" = 0 ] || fail "studies/odowd2014/README.md lacks $(lacks) lines of studies/rivals.py --study central"
sed '2s/[0-9.]*,[0-9.]*$/9,9/' studies/odowd2014/central/runs.csv >"$scratch/central.csv"
"$python" studies/rivals.py --study central "$scratch/central.csv" >"$scratch/printed"
[ "$(lacks)" != 0 ] || fail "CONTROL: more food is not noticed"
sed "s|201..260|201..202|; s|../../../|$PWD/|" studies/odowd2014/central/central.toml >"$scratch/central.toml"
oneiro sweep run "$scratch/central.toml" --out "$scratch/central" --quiet >/dev/null
"$python" studies/rivals.py --study central "$scratch/central/results.csv" --keep "$scratch/again.csv" >/dev/null
[ "$(wc -l <"$scratch/again.csv")" = 25 ] || fail "two seeds of a central simulator have other runs"
! grep -vxFf studies/odowd2014/central/runs.csv "$scratch/again.csv" || fail "these runs of a central simulator differ (above)"

say "the tables of islands"
"$python" studies/islands.py studies/odowd2014/islands/runs.csv >"$scratch/printed"
[ "$(grep -c '^|' "$scratch/printed")" = 114 ] || fail "studies/islands.py prints other tables"
[ "$(lacks)" = 0 ] || fail "studies/odowd2014/README.md lacks $(lacks) lines of studies/islands.py"
awk -F, -v OFS=, '/^over,10,all,1.0,evolved/ { $NF = 9 } { print }' studies/odowd2014/islands/runs.csv >"$scratch/islands.csv"
"$python" studies/islands.py "$scratch/islands.csv" >"$scratch/printed"
[ "$(lacks)" != 0 ] || fail "CONTROL: later takeovers are not noticed"
# One seed of ten robots again, bit for bit.
sed "s|101..130|101..101|; s|../../../|$PWD/|" studies/odowd2014/islands/islands.toml |
    awk '/^\[\[list\]\]/ && ++lists == 2 { skip = 1 } /^\[grid\]/ { skip = 0 } !skip' >"$scratch/islands.toml"
oneiro sweep run "$scratch/islands.toml" --out "$scratch/islands" --quiet >/dev/null
"$python" studies/islands.py "$scratch/islands/results.csv" --keep "$scratch/again.csv" >/dev/null 2>&1 || true
[ "$(wc -l <"$scratch/again.csv")" = 65 ] || fail "a seed of islands has other runs"
! grep -vxFf studies/odowd2014/islands/runs.csv "$scratch/again.csv" || fail "these runs of islands differ (above)"

say "foraging runs from their files"
# foraging NAME SETTING..: a run of five minutes, computed again.
foraging() {
    local settings=()
    for setting in "${@:2}"; do settings+=(--set "$setting"); done
    oneiro run experiments/odowd2014-over.toml --seed 2 --out "$scratch/foraging-$1" --set swarm.minutes=5 "${settings[@]}" --quiet >/dev/null
    "$python" studies/foragers.py "$scratch/foraging-$1"
}
foraging lagged | tee "$scratch/foraging" || fail "a foraging run differs from its files"
for what in "F_R by equation 1" "controller that stays" "range of a gene" "fitness of a pair by equation 1" "whose simulator goes on"; do
    grep -q "^$what: 0 of [1-9][0-9]" "$scratch/foraging" || fail "little was compared: $what"
done
foraging matched swarm.simulators.credit=matched || fail "matched credit is computed otherwise"
foraging early swarm.clock.installed_s=34 swarm.controllers.guests=2 || fail "early controllers and guests are computed otherwise"
foraging random swarm.case=random || fail "food of Random Movement is computed otherwise"
foraging crowd swarm.robots=40 swarm.arena.food_scales=with_robots || fail "a crowd is computed otherwise"
# One deposit less, another genome of the controller that acts next, another fitness in simulation, a pair that says more than its sender had, and another's simulator.
cp -r "$scratch/foraging-lagged" "$scratch/foraging-changed"
for change in 'deposits 2d' 'controllers 0,/,0$/s/,[0-9.]*\(,[0-9.]*,[0-9.-]*,0\)$/,0.123\1/' 'controllers 45s/,[0-9.]*,\([0-9]\)$/,999,\1/' 'pairs 2s/,[0-9.]*\(,[0-9.]*,[0-9.]*\)$/,59\1/' \
    'intervals 2s/,0$/,x/; 2s/,1$/,0/; 2s/,x$/,1/'; do
    table=${change%% *}
    sed "${change#* }" "$scratch/foraging-lagged/$table.csv" >"$scratch/foraging-changed/$table.csv"
    ! "$python" studies/foragers.py "$scratch/foraging-changed" >"$scratch/printed" || fail "CONTROL: not noticed in $table.csv: ${change#* }"
    cp "$scratch/foraging-lagged/$table.csv" "$scratch/foraging-changed/$table.csv"
done

say "all is well"
