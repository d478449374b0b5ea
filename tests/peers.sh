#!/usr/bin/env bash
# peers.sh: clients that others wrote, from PyPI, against the robots that are scripted in tests/peers: what these send and obey
# must be what such clients expect, too. Skipped if there is no Python, or its packages aren't available.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
. tests/skips.sh

say() { printf '\n== clients of robots: %s\n' "$*"; }
python_with thymiodirect,numpy,socketio,unifr_api_epuck thymiodirect==0.1.2 unifr-api-epuck==1.3.11 || {
    skipped python "clients of robots: $problem"
    exit 0
}
ONEIRO_CLIENTS=$python cargo test --locked --workspace --features oneiro-host/parquet --test program clients:: -- --ignored
