#!/usr/bin/env bash
# machine-code.sh [OPTION OF CARGO]...: what the compilers for NVIDIA's and Intel's cards, and for AMD's newer ones, make of the
# kernels, without a card: tests/optimised/machine_code.rs with Mesa's drivers of Debian 13, which are unpacked into the build folder
# and run there; nothing is installed. They want a device, so two libraries of Mesa's own source are compiled, which answer for the
# kernel's driver and execute nothing. Needs Debian on x86-64, a C compiler and Python. A quarter of a gigabyte; the first call
# fetches 130 MB.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/skips.sh
# shellcheck source=tests/own-apt.sh
. tests/own-apt.sh
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/mesa")

# Fails, unless ONEIRO_MAY_SKIP names mesa.
not_run() {
    ONEIRO_SKIPPED=$(mktemp)
    trap 'rm -f "$ONEIRO_SKIPPED"' EXIT
    skipped mesa "what cards of NVIDIA and Intel run was not looked at: $*"
    skip_summary
    exit
}

# Debian 13's lists, from where this machine has its own.
lists() {
    local own
    own=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
    apt-get indextargets --format "\$(REPO_URI)" "Created-By: Packages" "Release: $own" "Component: main" |
        sort -u | while read -r archive; do
        printf '%s [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] '"$archive"' trixie main\n' deb deb-src
    done >"$folder/sources.list"
    [ -s "$folder/sources.list" ] &&
        own_apt "$folder" "Dir::Etc::SourceList \"$folder/sources.list\"; Dir::Etc::SourceParts \"/dev/null\";"
}

# What the drivers need, and what compiling needs; and Mesa's source, of the same version.
fetch() {
    local packages
    mapfile -t packages < <(apt-cache depends --important --recurse mesa-vulkan-drivers libvulkan1 | grep -E '^[a-z][^:<]*$')
    [ ${#packages[@]} -gt 0 ] &&
        (cd "$folder/packages" &&
            apt-get download -q "${packages[@]}" libdrm-dev python3-mako python3-markupsafe &&
            apt-get source -q --download-only mesa) >/dev/null 2>&1
}

# shim NAME FILE...: compiles one of the libraries. Most of what the files have is not used, and left out.
shim() {
    local name=$1 util=$source/src/util file
    local all=("${@:2}" "$source"/src/drm-shim/{device,drm_shim}.c)
    for file in anon_file hash_table log os_misc ralloc set simple_mtx u_call_once u_debug u_process vma; do
        all+=("$util/$file.c")
    done
    cc -shared -fPIC -O1 -w -std=gnu11 -fvisibility=hidden -ffunction-sections -fdata-sections -Wl,--gc-sections -Wl,-z,defs \
        -Wl,--defsym=intel_device_info_from_json=0 \
        -D_GNU_SOURCE -DHAVE_PTHREAD -DHAVE_STRUCT_TIMESPEC -DHAVE_SECURE_GETENV -DHAVE_MEMFD_CREATE -DHAVE_ENDIAN_H \
        -I"$source"/{include,src,src/intel} -I"$root"/usr/include{,/libdrm} \
        -o "$folder/$name.so" "${all[@]}" 2>"$folder/errors" || not_run "$name.so was not compiled: $(grep -m 1 error "$folder/errors")"
}

if [ ! -x "$folder/run" ]; then
    root=$folder/root
    source=$folder/source
    [ "$(dpkg --print-architecture 2>/dev/null)" = amd64 ] || not_run "this is no Debian on x86-64"
    command -v cc >/dev/null || not_run "there is no C compiler (Debian: gcc)"
    command -v python3 >/dev/null || not_run "there is no python3"
    # Without what an interrupted call left.
    rm -rf "$folder"
    mkdir -p "$folder"/packages "$root" "$source"
    : >"$folder/status"
    lists || not_run "Debian's package lists can't be had"
    fetch || not_run "Debian's packages can't be had"
    for package in "$folder"/packages/*.deb; do
        dpkg -x "$package" "$root"
    done
    tar xf "$folder"/packages/mesa_*.orig.tar.?z -C "$source" --strip-components 1 --wildcards \
        'mesa-*/include' 'mesa-*/src/'{c11,compiler,drm-shim,util,intel,nouveau,gallium/drivers/nouveau}

    devices=$source/src/intel/dev
    generated() { PYTHONPATH=$root/usr/lib/python3/dist-packages python3 "$@" || not_run "Mesa's table of devices was not made"; }
    generated "$devices/gen_wa_helpers.py" "$devices/mesa_defs.json" "$devices"/intel_wa.{h,c}
    generated "$devices/intel_device_info_gen_h.py" "$devices/intel_device_info_gen.h"
    shim nouveau "$source/src/nouveau/drm-shim/nouveau_noop.c"
    shim intel "$source/src/intel/tools/intel_noop_drm_shim.c" "$devices"/{intel_device_info,i915/intel_device_info,intel_wa}.c

    rm -rf "$folder"/{packages,source,lists,cache}
    cat >"$folder/run.new" <<END
#!/bin/sh
# run DRIVER COMMAND...: with Debian 13's libraries and one driver, and a device for it.
driver=\$1
shift
[ ! -e "$folder/\$driver.so" ] || set -- --preload "$folder/\$driver.so" "\$@"
export NVK_I_WANT_A_BROKEN_VULKAN_DRIVER=1 INTEL_STUB_GPU=1 VK_DRIVER_FILES="$root/usr/share/vulkan/icd.d/\${driver}_icd.json"
exec "$root/usr/lib64/ld-linux-x86-64.so.2" --library-path "$root/usr/lib/x86_64-linux-gnu" "\$@"
END
    chmod +x "$folder/run.new"
    mv "$folder/run.new" "$folder/run"
fi

# With the features of all tests, which then have built it already.
ONEIRO_MESA=$folder cargo test --locked --workspace --features oneiro-host/parquet "$@" --test optimised of_other_vendors -- --include-ignored --nocapture
