#!/usr/bin/env bash
# micropython.sh [OPTION..]: controllers as Python modules have the simulator's bits in MicroPython, in its build for Node.js. The options are
# Cargo's.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/micropython")
command -v npm >/dev/null || install npm
npm install --silent --no-fund --no-audit --prefix "$folder" @micropython/micropython-webassembly-pyscript@1.27
cp tests/micropython.mjs "$folder"
printf '#!/bin/sh\nexec node %s/micropython.mjs "$@"\n' "$folder" >"$folder/micropython"
chmod +x "$folder/micropython"
PATH=$folder:$PATH cargo test --locked --workspace --features oneiro-host/parquet "$@" --test library -- --ignored micropython --nocapture
