#!/usr/bin/env bash
# optimisers.sh: the optimisers against the Python packages cma 4.5.0, which computes steps of CMA-ES with 2, 10 and 66 genes and
# evaluations that it needs, ribs 0.12.0, which fills an archive of elites, and scipy 1.17.1, which counts evaluations that differential
# evolution needs. What is committed of these (host/evolve/src) must be
# what they compute. Skipped if there is no Python, or the packages aren't available.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

say() { printf '\n== optimisers: %s\n' "$*"; }
fail() {
    echo "optimisers: $*" >&2
    exit 1
}

python_with cma,ribs,scipy cma==4.5.0 ribs==0.12.0 scipy==1.17.1 || {
    skipped python "the optimisers against cma, ribs and scipy: $problem"
    exit 0
}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# NumPy's linear algebra rounds otherwise on each kind of processor, so that cma needs 4057 to 4100 evaluations of the ellipsoid: one kind
# that every x86-64 has.
export OPENBLAS_CORETYPE=Prescott OPENBLAS_NUM_THREADS=1

say "what ribs does"
"$python" tests/optimisers/archive.py "$scratch/archive.txt"
cmp "$scratch/archive.txt" host/evolve/src/map_elites/oracle.txt || fail "ribs does something else than is committed"

say "what scipy does"
"$python" tests/optimisers/differential.py "$scratch/differential.txt"
cmp "$scratch/differential.txt" host/evolve/src/differential_evolution/evaluations.txt ||
    fail "scipy needs other evaluations than are committed"

say "what cma computes"
"$python" tests/optimisers/steps.py "$scratch" --all
cmp "$scratch/evaluations.txt" host/evolve/src/cma/oracles/evaluations.txt ||
    fail "cma needs other evaluations than are committed"

say "what the optimisers compute"
# Without the package's numbers this test compares with those that are committed. What the evaluations and the archive of others are
# compared with is committed whole, and was found to be the same: those tests are run with all others.
ONEIRO_OPTIMISERS=$scratch cargo test --locked --workspace --features oneiro-host/parquet --lib -- \
    cma::tests::steps --nocapture | tee "$scratch/printed"
for genes in 2 10 66; do
    [ "$(grep -c "steps-$genes-" "$scratch/printed")" = 2 ] || fail "steps with $genes genes were not compared"
done
say "all is well"
