#!/usr/bin/env bash
# debian-rust.sh FOLDER: Debian's Rust compiler with its standard libraries for x86-64 and 64-bit ARM, unpacked
# into FOLDER without being installed; FOLDER/rustc runs it. For machines that rustup doesn't support. Prints one line
# with the reason if it fails.
set -euo pipefail
# shellcheck source=tests/own-apt.sh
. "$(dirname "$0")/own-apt.sh"
folder=$(realpath -m "$1")
least=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$(dirname "$0")/../Cargo.toml")
libraries=$folder/root/usr/lib/x86_64-linux-gnu:$folder/root/lib/x86_64-linux-gnu

fail() {
    echo "$*"
    exit 1
}
[ -x "$folder/rustc" ] && exit
[ "$(dpkg --print-architecture 2>/dev/null)" = amd64 ] || fail "this is no Debian on x86-64"

rm -rf "$folder"
mkdir -p "$folder"/{packages,root}
: >"$folder/status"
own_apt "$folder" 'APT::Architecture "amd64"; APT::Architectures { "amd64"; "arm64"; };' ||
    fail "Debian's package lists can't be had"

unpack() {
    (cd "$folder/packages" && rm -f ./*.deb && apt-get download -q "$@" >/dev/null 2>&1) ||
        fail "these packages can't be had: $*"
    for package in "$folder"/packages/*.deb; do
        dpkg -x "$package" "$folder/root"
    done
}
# Dependency of a package, by the beginning of its name.
needs() { apt-cache depends --important "$1" | sed -n "s/^ *Depends: \($2.*\)/\1/p"; }
missing() { LD_LIBRARY_PATH=$libraries ldd "$folder"/root/usr/lib/x86_64-linux-gnu/librustc_driver*.so | grep "not found" || true; }

for name in rustc-web rustc ""; do
    version=$(apt-cache policy "$name" | sed -n 's/^  Candidate: //p')
    dpkg --compare-versions "${version:-0}" ge "$least" && break
done
[ -n "$name" ] || fail "Debian's compilers are older than $least"
standard=libstd-${name/rustc/rust}-dev
compiler=$(needs "$standard" libstd-)
llvm=$(needs "$compiler" libllvm)
unpack "$name" "$compiler" "$standard" "$standard:arm64" "$llvm"
if [ -n "$(missing)" ]; then
    mapfile -t others < <(apt-cache depends --important --recurse "$llvm" | grep -E '^lib[^:<]*$' |
        grep -vE '^(libc6|libgcc-s1|libcrypt1)$')
    unpack "${others[@]}"
fi
[ -z "$(missing)" ] || fail "Debian's compiler lacks $(missing | tr -s '[:space:]' ' ')"

printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s "$@"\n' "$libraries" "$folder/root/usr/bin/rustc" >"$folder/rustc"
chmod +x "$folder/rustc"
rm -rf "$folder"/{lists,cache,packages}
