#!/usr/bin/env bash
# python-arm.sh: the wheel of the Python package for 64-bit ARM Linux: built here, its size, and that all that it needs from outside is
# libc's and Python's stable interface. Needs a linker and Rust's standard library for 64-bit ARM, and Python. Building takes minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/skips.sh

not_run() {
    skipped arm "no wheel was built for 64-bit ARM: $*"
    exit 0
}
fail() {
    echo "Python package for 64-bit ARM: $*" >&2
    exit 1
}
target=aarch64-unknown-linux-gnu
command -v aarch64-linux-gnu-gcc >/dev/null || not_run "there is no aarch64-linux-gnu-gcc (Debian: gcc-aarch64-linux-gnu)"
[ -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ] || rustup target add $target >/dev/null 2>&1 ||
    not_run "there is no standard library (rustup target add $target)"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc

folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/build" || not_run "python3 makes no virtual environment"
"$scratch/build/bin/python" -m pip install --quiet --only-binary :all: 'maturin>=1.16,<2' ||
    not_run "maturin can't be had: is there a network?"
(cd python && "$scratch/build/bin/maturin" build --profile dist --locked --auditwheel skip --target $target \
    --interpreter python3.10 --out "$scratch/wheels" --target-dir "$folder")
wheel=$(echo "$scratch"/wheels/oneiro-*-cp310-abi3-*aarch64.whl)
[ -f "$wheel" ] || fail "there is no wheel cp310-abi3-*aarch64 in $(ls "$scratch/wheels")"
size=$(stat -c %s "$wheel")
echo "$(basename "$wheel"): $size bytes"
[ "$size" -lt 12000000 ] || fail "the wheel has $size bytes; the target is less than 12 MB"

python3 -m zipfile -e "$wheel" "$scratch/wheel"
module=$scratch/wheel/oneiro/_native.abi3.so
header=$(aarch64-linux-gnu-readelf --file-header "$module")
[[ $header == *AArch64* ]] || fail "the module is for another processor: $header"
symbols=$(aarch64-linux-gnu-nm --dynamic "$module")
[[ $symbols == *" T PyInit__native"* ]] || fail "the module has no PyInit__native"
# What is undefined without a version is of the interpreter: only names of its C interface.
others=$(awk '$1 == "U" && $2 !~ /@/ && $2 !~ /^_?Py/' <<<"$symbols")
[ -z "$others" ] || fail "the module needs more than libc and Python: $others"
needed=$(aarch64-linux-gnu-readelf --dynamic "$module" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort | xargs)
echo "it needs $needed"
for library in $needed; do
    [[ $library =~ ^(ld-linux-aarch64|libc|libm|libgcc_s|libdl|libpthread)\.so ]] || fail "the module needs $library"
done
