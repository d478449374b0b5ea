#!/usr/bin/env bash
# build.sh: makes the page that evolves in a browser: static files in target/web/site. A toolchain with the target
# wasm32-unknown-unknown (rustup target add wasm32-unknown-unknown) builds it. Without one, and on Debian, the compiler and the
# standard library's source come from Debian's packages, which are unpacked below target/web and not installed.
set -euo pipefail
cd "$(dirname "$0")/.."

target=wasm32-unknown-unknown
folder=${CARGO_TARGET_DIR:-$PWD/target}/web
site=$folder/site
mkdir -p "$folder"
options=(--locked --package oneiro-web --profile web --target "$target")
export CARGO_TARGET_DIR=$folder/build

unpacked() {
    local root=$folder/debian
    local packages=(rustc-web libstd-rust-web-dev rust-web-src lld-22)
    if ! [ -e "$root/whole" ]; then
        command -v apt-get > /dev/null || {
            echo "web/build.sh: the target $target is missing: rustup target add $target" >&2
            exit 1
        }
        rm -rf "$root"
        mkdir -p "$root/packages"
        # The compiler's library and the linker's have versions in their names.
        mapfile -t libraries < <(apt-cache depends libstd-rust-web-dev lld-22 |
            sed -n 's/.*Depends: \(libstd-rust-web-[0-9.]*\|libllvm[0-9]*\)$/\1/p' | sort -u)
        (cd "$root/packages" && apt-get download "${packages[@]}" "${libraries[@]}")
        for package in "$root"/packages/*.deb; do
            dpkg -x "$package" "$root"
        done
        rm -r "$root/packages"
        touch "$root/whole"
    fi
    export LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu
    export RUSTC=$root/usr/bin/rustc RUSTC_BOOTSTRAP=1
    export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$root/usr/bin/wasm-ld-22
    options+=(-Zbuild-std=std,panic_abort)
}

[ -d "$(rustc --print sysroot)/lib/rustlib/$target" ] || unpacked

rm -rf "$site"
mkdir -p "$site"
# One module for engines with vectors of 128 bits, one that also compiles, and one for engines without such vectors. What is compiled at run
# time is added to the module's table of functions.
build() {
    local name=$1 vectors=$2
    shift 2
    # There are no random numbers of the system: a run has its seed.
    RUSTFLAGS="-C target-feature=${vectors}simd128 -C link-arg=--export-table -C link-arg=--growable-table --cfg getrandom_backend=\"unsupported\"" \
        cargo build "${options[@]}" "$@"
    cp "$CARGO_TARGET_DIR/$target/web/oneiro_web.wasm" "$site/$name.wasm"
}
build oneiro +
build oneiro-compose + --features oneiro-web/compose
[ "${ONEIRO_WEB_SCALAR:-1}" = 0 ] || build oneiro-scalar -
cp web/site/* "$site/"
# The style of all pages, and what this page adds.
cat host/report/src/components/page.css web/site/page.css > "$site/page.css"
wc -c "$site"/*.wasm
for module in "$site"/*.wasm; do
    gzip -9c "$module" | wc -c
done
