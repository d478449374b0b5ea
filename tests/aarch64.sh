#!/usr/bin/env bash
# The lane code for 64-bit ARM on an emulated processor: every operation, the compiler's corpus, and lives, all
# with the bits that they have here. Needs qemu and a linker for ARM, and a Rust compiler with its standard
# library: rustup's target if it is there or can be had, else Debian's packages, unpacked under target/ without
# being installed.
set -euo pipefail
cd "$(dirname "$0")/.."

target=aarch64-unknown-linux-gnu
work=$(realpath -m "${CARGO_TARGET_DIR:-target}")/aarch64
say() { printf '\n== 64-bit ARM: %s\n' "$*"; }
not_run() {
    say "NOT RUN, NOT EVEN TYPE-CHECKED: $*"
    exit 0
}

# Debian's compiler of at least this project's version, in $debian; whatever is missing is why it fails.
debian=$work/debian
debian_rust() {
    [ -x "$debian/rustc" ] && return
    [ "$(dpkg --print-architecture 2>/dev/null)" = amd64 ] || {
        echo "this is no Debian on x86-64"
        return 1
    }
    rm -rf "$debian"
    mkdir -p "$debian"/{lists,archives,packages}/partial "$debian/root"
    : >"$debian/status"
    # Its own state: the system's packages and architectures stay as they are.
    cat >"$debian/apt.conf" <<-END
		APT::Architecture "amd64";
		APT::Architectures { "amd64"; "arm64"; };
		APT::Sandbox::User "$(id -un)";
		Acquire::Languages "none";
		Dir::State::Lists "$debian/lists";
		Dir::State::status "$debian/status";
		Dir::Cache "$debian/archives";
	END
    export APT_CONFIG=$debian/apt.conf
    apt-get update -q >/dev/null || {
        echo "Debian's package lists can't be had"
        return 1
    }
    local least name version standard llvm
    least=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    for name in rustc-web rustc; do
        version=$(apt-cache policy "$name" | sed -n 's/^  Candidate: //p')
        dpkg --compare-versions "${version:-0}" ge "$least" && break
        name=
    done
    [ -n "$name" ] || {
        echo "Debian's compilers are older than $least"
        return 1
    }
    standard=libstd-${name/rustc/rust}
    # The compiler's library, LLVM, and what this needs that is not here.
    local compiler
    compiler=$(apt-cache depends --important "$standard-dev" | sed -n 's/^ *Depends: \(libstd-.*\)/\1/p')
    llvm=$(apt-cache depends --important "$compiler" | sed -n 's/^ *Depends: \(libllvm.*\)/\1/p')
    unpack "$name" "$compiler" "$standard-dev" "$standard-dev:arm64" "$llvm" || return 1
    if missing | grep -q .; then
        # shellcheck disable=SC2046 # one word a package
        unpack $(apt-cache depends --important --recurse "$llvm:amd64" | grep -E '^lib' |
            grep -vE ':arm64|^(libc6|libgcc-s1|libcrypt1|libllvm.*)$') || return 1
    fi
    if missing | grep -q .; then
        echo "Debian's compiler lacks libraries: $(missing | tr '\n' ' ')"
        return 1
    fi
    printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s "$@"\n' \
        "$debian/root/usr/lib/x86_64-linux-gnu:$debian/root/lib/x86_64-linux-gnu" "$debian/root/usr/bin/rustc" >"$debian/rustc"
    chmod +x "$debian/rustc"
}

unpack() {
    (cd "$debian/packages" && rm -f ./*.deb && apt-get download -q "$@" >/dev/null) || {
        echo "Debian's packages can't be had: $*"
        return 1
    }
    local package
    for package in "$debian"/packages/*.deb; do
        dpkg -x "$package" "$debian/root"
    done
}

# The libraries that the compiler does not find.
missing() {
    LD_LIBRARY_PATH=$debian/root/usr/lib/x86_64-linux-gnu:$debian/root/lib/x86_64-linux-gnu \
        ldd "$debian"/root/usr/lib/x86_64-linux-gnu/librustc_driver*.so | sed -n 's/^\s*\(.*\) => not found/\1/p'
}

command -v qemu-aarch64 >/dev/null || not_run "there is no qemu-aarch64 (Debian: qemu-user)"
command -v aarch64-linux-gnu-gcc >/dev/null || not_run "there is no linker (Debian: gcc-aarch64-linux-gnu)"
has_target() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; }
has_target || timeout 60 rustup target add $target >/dev/null 2>&1 || true
if has_target; then
    compiler=$(rustc --version)
else
    say "getting Debian's compiler"
    problem=$(debian_rust) || not_run "$problem"
    export RUSTC=$debian/rustc
    compiler="Debian's $("$RUSTC" --version)"
fi

say "compiling with $compiler, running on qemu"
# Without optimisation for speed: the bits do not depend on it, and compiling is what takes the time.
emulated=$(
    env CARGO_TARGET_DIR="$work" CARGO_PROFILE_RELEASE_OPT_LEVEL=1 \
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu" \
        cargo test --release --locked --target $target -p oneiro-shader-corpus -p oneiro --no-default-features \
        --test variants --test operations --test machines -- --nocapture | tee >(cat >&2)
)
unset RUSTC
say "the same lives here"
here=$(cargo test --release --locked -p oneiro --no-default-features --test machines -- --nocapture)
digests() { grep -o 'digests .*' <<<"$1"; }
if [ "$(digests "$emulated")" != "$(digests "$here")" ]; then
    printf 'the bits differ:\n    on ARM: %s\n    here:   %s\n' "$(digests "$emulated")" "$(digests "$here")" >&2
    exit 1
fi
say "$(digests "$here"), the same on both"
