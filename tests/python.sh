#!/usr/bin/env bash
# python.sh [SWEEP]: docs/sweeps.py with the current pandas and Polars, on the tables of a small sweep, or of the given
# directory. Its output is compared with means computed by awk, and both checks are shown to fail if something is wrong.
# Skipped if there is no Python, or its packages aren't available.
set -euo pipefail
sweep=${1:+$(realpath -e "$1")}
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
say() { printf '\n== Python: %s\n' "$*"; }
fail() {
    echo "Python: $*" >&2
    exit 1
}
no_python() {
    skipped python "docs/sweeps.py: $*"
    exit 0
}

# It needs only what its head says: an environment with nothing else.
packages=$(sed -n 's/^# It needs `pip install \(.*\)`.*/\1/p' docs/sweeps.py)
[ -n "$packages" ] || fail "docs/sweeps.py does not say what it needs"
python_folder=python-sweeps
# shellcheck disable=SC2086 # Words.
python_with pandas,polars,pyarrow $packages || no_python "$problem"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
if [ -z "$sweep" ]; then
    say "a sweep"
    [ -x "$folder/debug/oneiro" ] || fail "build the program first: cargo build --features oneiro-host/parquet"
    sweep=$scratch/sweep
    "$folder/debug/oneiro" sweep run experiments/sweeps/small.toml --out "$sweep" --quiet
fi

say "docs/sweeps.py on $sweep"
"$python" -W error docs/sweeps.py "$sweep" | tee "$scratch/printed"

# Expected means in rows of the output: the beginning of a row, and the number that follows. First the means of the first
# outcome by each value of the first key, then those of the last scores by all keys. Only text before the seed is ever
# quoted, so later columns are counted from the right.
expected() {
    awk -F, '
        FNR == 1 { split("", column); for (i = 1; i <= NF; i++) column[$i] = i }
        NR == 1 { seed = column["seed"]; after = NF - seed; next }
        NR == FNR {
            text = $0
            sub(/^[^,]*,[^,]*,/, "", text)
            match(text, /^("([^"]|"")*"|[^,]*)/)
            first = substr(text, 1, RLENGTH)
            for (i = 0; i < after + (seed > 3); i++) sub(/,[^,]*$/, "", text)
            keys[$1] = text
            outcome = $(NF - after + 1)
            if (outcome != "" && outcome != "NaN") { sum[first] += outcome; count[first]++ }
            next
        }
        FNR == 1 {
            time = "generation" in column ? column["generation"] : column["interval"]
            score = "generation" in column ? column["mean"] : column["real"]
            next
        }
        $time > last { last = $time; split("", scores); split("", scored) }
        $time == last && $score != "" && $score != "NaN" { scores[keys[$1]] += $score; scored[keys[$1]]++ }
        END {
            for (key in sum) printf "%s %.17g\n", key, sum[key] / count[key]
            for (key in scores) printf "%s %d %.17g\n", key, last, scores[key] / scored[key]
        }
    ' "$sweep/results.csv" "$sweep/generations.csv"
}

# Checks that rows with all these means were printed, to nine digits, and names missing ones. Only the words of lists and
# quoted words are compared.
words() { tr ',"' '  ' <"$1"; }
is_printed() {
    words "$scratch/printed" >"$scratch/rows"
    words "$1" | awk -v rows="$scratch/rows" '
        BEGIN { while ((getline row < rows) > 0) printed[++count] = row }
        function size(x) { return x < 0 ? -x : x }
        function is_same(a, b) { return a == b || (a b ~ /^[-+.0-9e]+$/ && a + 0 == b + 0) }
        function begins(row,    cell, i) {
            if (split(row, cell, " ") < NF) return 0
            for (i = 1; i < NF; i++) if (!is_same(cell[i], $i)) return 0
            return cell[NF] ~ /[0-9]/ && size(cell[NF] - $NF) <= 1e-8 * size($NF)
        }
        {
            for (i = 1; i <= count; i++) if (begins(printed[i])) next
            print "not printed: " $0
            missing++
        }
        END { exit missing > 0 || NR == 0 }
    '
}

say "the means that awk takes"
expected >"$scratch/means"
is_printed "$scratch/means" >&2 || fail "docs/sweeps.py prints other means than awk takes"
echo "$(wc -l <"$scratch/means") means are those that were printed"

say "controls"
awk 'NR <= 20 { $NF = sprintf("%.17g", $NF * 1.0000001 + 1e-9); print }' "$scratch/means" >"$scratch/others"
while read -r mean; do
    echo "$mean" >"$scratch/other"
    ! is_printed "$scratch/other" >/dev/null || fail "CONTROL: this mean is off by a ten-millionth and passes: $mean"
done <"$scratch/others"
echo "means that are off by a ten-millionth are refused"

# Checks that a snippet detects a difference between two tables of a sweep.
differs() { ! "$python" "$1" "$2" >/dev/null 2>"$scratch/error" && grep -q AssertionError "$scratch/error"; }
sed 's/rows_pl\.join/rows_pl.filter(pl.col("run") > 0).join/' docs/sweeps.py >"$scratch/sweeps.py"
differs "$scratch/sweeps.py" "$sweep" || fail "CONTROL: Polars lacks a run, and the snippet does not notice"
echo "a run that Polars lacks is noticed"
if [ -e "$sweep/results.parquet" ]; then
    mkdir "$scratch/cut"
    cp "$sweep"/results.* "$sweep"/generations.* "$scratch/cut"
    sed -i '$d' "$scratch/cut/results.csv"
    differs docs/sweeps.py "$scratch/cut" || fail "CONTROL: results.parquet has a row more, and the snippet does not notice"
    echo "a table that differs from its Parquet is noticed"
else
    echo "there is no Parquet in $sweep: reading it is not tested"
fi
say "all is well"
