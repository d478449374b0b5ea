#!/usr/bin/env bash
# optimisers.sh: the optimisers against the Python package cma 4.5.0, which computes steps of CMA-ES with 2, 10 and 66 genes, and
# evaluations that it needs. What is committed of these (host/src/evolve/cma/oracles) must be what it computes. Skipped if there is
# no Python, or the package isn't available.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

say() { printf '\n== optimisers: %s\n' "$*"; }
fail() {
    echo "optimisers: $*" >&2
    exit 1
}

python_with cma,numpy cma==4.5.0 numpy || {
    skipped python "the optimisers against cma: $problem"
    exit 0
}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

say "what cma computes"
"$python" tests/optimisers/steps.py "$scratch" --all
cmp "$scratch/evaluations.txt" host/src/evolve/cma/oracles/evaluations.txt ||
    fail "cma needs other evaluations than are committed"

say "what the optimisers compute"
# Without the package's numbers this test compares with those that are committed.
ONEIRO_OPTIMISERS=$scratch cargo test --locked -p oneiro-host --features parquet --bin oneiro -- cma::tests::steps cma::tests::it_needs \
    --nocapture | tee "$scratch/printed"
for genes in 2 10 66; do
    [ "$(grep -c "steps-$genes-" "$scratch/printed")" = 2 ] || fail "steps with $genes genes were not compared"
done
say "all is well"
