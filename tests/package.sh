#!/usr/bin/env bash
# package.sh [crates|wheel|archive]..: makes what a release publishes, installs each where nothing of the repository is, and compares the
# first experiment's result with the README's. Then it prints bytes, and seconds from the files to the result. Without arguments, all.
# ONEIRO_PACKAGES=FOLDER keeps the packages. ONEIRO_BUILT=FOLDER takes a wheel and a program from there, of any size, instead of building
# them. Needs Python and a network; tools are installed in the build folder.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
say() { printf '\n== packages: %s\n' "$*"; }
fail() {
    echo "packages: $*" >&2
    exit 1
}
# What is packed, unpacked.
source=$(realpath -m "${CARGO_TARGET_DIR:-target}")/packed-source
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
packages=$(realpath -m "${ONEIRO_PACKAGES:-$scratch/packages}")
mkdir -p "$packages"
# Sources without a repository don't know their commit.
commit=$(git rev-parse --short=12 HEAD)
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
golden=$(sed -n 's/^result  *//p' README.md)
[ -n "$golden" ] || fail "the README shows no result"
table=()

# first WAY BYTES PROGRAM..: writes and runs the first experiment in an empty folder, by a program that finds nothing else there.
first() {
    local way=$1 bytes=$2 began took result
    shift 2
    mkdir -p "$scratch/installed-$way"
    began=$EPOCHREALTIME
    result=$(cd "$scratch/installed-$way" && env -i HOME="$scratch" PATH=/usr/bin:/bin "$@" new --example khepera-avoidance --quiet &&
        env -i HOME="$scratch" PATH=/usr/bin:/bin "$@" run khepera-avoidance.toml --seed 1 2>&1) || fail "$way: $result"
    took=$(echo "($EPOCHREALTIME - $began + ${installed:-0}) / 1" | bc)
    [[ $result =~ result\ +$golden ]] || fail "$way: the result is not $golden: $result"
    [ -n "${ONEIRO_BUILT:-}" ] || grep -q "$commit" "$scratch/installed-$way/runs/khepera-avoidance-1/meta.json" || fail "$way: runs don't say their commit"
    table+=("$(printf '%-20s %12s %8s' "$way" "$bytes" "$took")")
}

# Packages of the workspace that are published, as `cargo publish` sees them.
crates() {
    local vendor=$folder/vendor home=$scratch/cargo crate name options=() private
    mapfile -t private < <(cargo metadata --format-version 1 --no-deps --locked |
        python3 -c 'import json, sys; [print(p["name"]) for p in json.load(sys.stdin)["packages"] if p["publish"] == []]')
    [ ${#private[@]} -gt 0 ] || fail "there are no private packages"
    for name in "${private[@]}"; do
        options+=(--exclude "$name")
        grep -qE -- "--exclude $name( |\$)" .github/workflows/release.yml || fail "release.yml would publish $name"
    done

    say "packing"
    # All of them, and then the one that no workspace has, against these.
    cargo package --workspace "${options[@]}" --locked --allow-dirty --no-verify --quiet --target-dir "$scratch/packed"
    # What is locked there is what is tested here.
    cp Cargo.lock packaging/oneiro/
    rm -rf "$vendor"
    cargo vendor --locked --versioned-dirs --quiet "$vendor" >/dev/null
    add() {
        tar -C "$vendor" -xf "$1"
        printf '{"files":{},"package":"%s"}' "$(sha256sum "$1" | cut -d' ' -f1)" >"$vendor/$(basename "$1" .crate)/.cargo-checksum.json"
    }
    for crate in "$scratch"/packed/package/*.crate; do add "$crate"; done
    # Of Cargo's own home, nothing is used.
    mkdir -p "$home"
    printf '[source.crates-io]\nreplace-with = "vendored"\n[source.vendored]\ndirectory = "%s"\n[net]\noffline = true\n' "$vendor" >"$home/config.toml"
    CARGO_HOME=$home cargo package --manifest-path packaging/oneiro/Cargo.toml --allow-dirty --no-verify --quiet --target-dir "$scratch/packed"
    cp "$scratch"/packed/package/*.crate "$packages/"
    for crate in "$scratch"/packed/package/*.crate; do
        name=$(basename "$crate" .crate)
        tar -tf "$crate" >"$scratch/list"
        for file in LICENSE-MIT LICENSE-APACHE Cargo.lock; do
            grep -qx "$name/$file" "$scratch/list" || fail "$name has no $file"
        done
        grep -qE "/(README|part)\.md$" "$scratch/list" || fail "$name has no README"
        tar -xOf "$crate" "$name/Cargo.toml" | grep -q '^repository' || fail "$name says no repository"
    done
    ls -l "$scratch"/packed/package/*.crate | awk '{ bytes += $5; files++ } END { print files " packages, " bytes " bytes" }'

    say "building from the packages alone"
    tar -C "$scratch" -xf "$scratch/packed/package/oneiro-$version.crate"
    # What a kernel needs is compiled when it is run, so that this needs no optimised program.
    began=$EPOCHREALTIME
    (cd "$scratch/oneiro-$version" && CARGO_HOME=$home CARGO_PROFILE_DEV_DEBUG=false CARGO_INCREMENTAL=0 \
        cargo build --quiet --target-dir "$folder/from-packages")
    installed="($EPOCHREALTIME - $began)"
    cp "$folder/from-packages/debug/oneiro" "$scratch/oneiro"
    first crates "$(stat -c %s "$scratch/packed/package/oneiro-$version.crate")" "$scratch/oneiro"

    say "the library alone"
    mkdir -p "$scratch/user/src"
    cat >"$scratch/user/Cargo.toml" <<USER
[package]
name = "user"
edition = "2024"
[dependencies]
oneiro = { version = "$version", default-features = false, features = ["native"] }
USER
    # The README's program.
    awk '/^```rust$/ { on = 1; next } /^```$/ { on = 0 } on' README.md | sed 's/^# //' >"$scratch/program"
    { echo 'fn main() -> Result<(), Box<dyn std::error::Error>> {' && cat "$scratch/program" && echo '}'; } >"$scratch/user/src/main.rs"
    add "$scratch/packed/package/oneiro-$version.crate"
    (cd "$scratch/user" && CARGO_HOME=$home CARGO_PROFILE_DEV_DEBUG=false CARGO_INCREMENTAL=0 cargo run --quiet --target-dir "$folder/from-packages")
    (cd "$scratch/user" && CARGO_HOME=$home cargo tree --prefix none) >"$scratch/tree"
    grep -q '^oneiro-library ' "$scratch/tree" || fail "oneiro has no library"
    ! grep -qE '^(clap|oneiro-host) ' "$scratch/tree" || fail "the library alone brings the program"
}

# The source distribution, unpacked, and the tools for all that is made of it.
sources() {
    tools=$folder/packaging
    [ -z "${sdist:-}" ] || return 0
    python_folder=packaging python_with maturin,ziglang 'maturin>=1.16,<2' cargo-zigbuild ziglang auditwheel abi3audit check-wheel-contents twine \
        pyroma 'validate-pyproject[all]' 'sp-repo-review[cli]' || fail "$problem"

    say "the source distribution"
    packaging/notices.py --check
    (cd python && "$tools/bin/validate-pyproject" pyproject.toml && "$tools/bin/sp-repo-review" . >"$scratch/review") || {
        grep -A 5 ❌ "$scratch/review"
        fail "sp-repo-review refuses python/"
    }
    (cd python && "$tools/bin/maturin" sdist --out "$packages" >"$scratch/log" 2>&1) || fail "$(cat "$scratch/log")"
    sdist=$packages/oneiro-$version.tar.gz
    # Rust's packages as they are published, the Python package, and its tests.
    tar -tf "$sdist" | sed "s|^oneiro-$version/||" >"$scratch/list"
    ! grep -vE '^(Cargo\.(toml|lock)|PKG-INFO|pyproject\.toml|README\.md|(packaging/)?part\.md|LICENSE-(MIT|APACHE)|THIRD-PARTY\.txt|(benches|examples|experiments|host|oneiro|python|shaders|src)/.*)$' "$scratch/list" ||
        fail "the source distribution has more than sources (above)"
    ! grep -E '^(python/)?(runs|target)/|__pycache__|\.(npy|so|whl|new)$' "$scratch/list" || fail "the source distribution has results (above)"
    rm -rf "$source"
    mkdir -p "$source"
    # As new as can be: Cargo looks at no more than a file's time.
    tar -C "$source" --strip-components 1 -xmf "$sdist"
}

# needs_libc FILE: fails if a program or library needs a newer libc than that of Debian 10, RHEL 8 and Ubuntu 18.10.
needs_libc() {
    local newest
    newest=$(objdump -T "$1" | grep -oE 'GLIBC_[0-9.]+' | sort -uV | tail -n 1)
    echo "the newest symbols of libc that it needs are of $newest"
    [ "$(printf '%s\n' GLIBC_2.28 "$newest" | sort -V | tail -n 1)" = GLIBC_2.28 ] || fail "$1 needs $newest; allowed: GLIBC_2.28"
}

# The wheel for x86-64 Linux, made from the source distribution.
wheel() {
    local wheel module bytes began environment=$scratch/environment
    sources
    say "the wheel, from it"
    if [ -n "${ONEIRO_BUILT:-}" ]; then
        cp "$ONEIRO_BUILT"/*.whl "$packages/"
    else
        (cd "$source" && ONEIRO_BUILT_FROM=$commit PATH=$tools/bin:$PATH maturin build --profile dist --zig --compatibility manylinux_2_28 \
            --interpreter python3.10 --out "$packages" --target-dir "$folder/wheel" >"$scratch/log" 2>&1) || fail "$(cat "$scratch/log")"
    fi
    wheel=$(echo "$packages/oneiro-$version"-cp310-abi3-manylinux_2_28_x86_64*.whl)
    [ -f "$wheel" ] || fail "there is no wheel cp310-abi3-manylinux_2_28_x86_64 in $(ls "$packages")"
    bytes=$(stat -c %s "$wheel")
    echo "$(basename "$wheel"): $bytes bytes"
    python3 -m zipfile -e "$wheel" "$scratch/wheel"
    sed '1,/^$/d' "$scratch/wheel/oneiro-$version.dist-info/METADATA" | diff -B - python/README.md || fail "the wheel has another description"
    [ -n "${ONEIRO_BUILT:-}" ] || [ "$bytes" -lt 12000000 ] || fail "the wheel has $bytes bytes; allowed: fewer than 12000000"

    say "what others check"
    PATH=$tools/bin:$PATH auditwheel show "$wheel"
    "$tools/bin/abi3audit" --strict --assume-minimum-abi3 3.10 "$wheel"
    "$tools/bin/check-wheel-contents" "$wheel"
    "$tools/bin/twine" check --strict "$wheel" "$sdist"
    (cd python && "$tools/bin/pyroma" --min 8 .)
    for file in LICENSE-MIT LICENSE-APACHE THIRD-PARTY.txt; do
        cmp "python/$file" "$scratch/wheel/oneiro-$version.dist-info/licenses/$file"
    done
    module=$scratch/wheel/oneiro/_native.abi3.so
    needs_libc "$module"

    say "installed"
    began=$EPOCHREALTIME
    python3 -m venv "$environment"
    "$environment/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: "$wheel"
    installed="($EPOCHREALTIME - $began)"
    first wheel "$bytes" "$environment/bin/oneiro"
    (cd "$scratch" && "$environment/bin/python" - <<'PYTHON'
import oneiro

exp = oneiro.Experiment.example("khepera-avoidance")
assert exp.name == "khepera-avoidance", exp.name
try:
    oneiro.Experiment.example("sweeps/small")
except oneiro.InputError as error:
    assert "khepera-avoidance" in str(error), error
else:
    raise AssertionError("a sweep is an experiment")
PYTHON
    )
    # Ctrl-C stops it as any program, and what it starts again is itself.
    local code=0
    timeout --preserve-status -s INT 5 "$environment/bin/oneiro" run "$scratch/installed-wheel/khepera-avoidance.toml" --seed 1 --quiet \
        --out "$scratch/stopped" --set evolution.generations=1000000 >"$scratch/stop" 2>&1 || code=$?
    [ "$code" = 75 ] || fail "after Ctrl-C, it ends with $code: $(cat "$scratch/stop")"
    (cd "$scratch/installed-wheel" && "$environment/bin/oneiro" new --example sweeps/small --quiet &&
        "$environment/bin/oneiro" sweep run sweeps/small.toml --out swept --print-slurm >slurm.sh)
    grep -q "$environment/bin/oneiro sweep run" "$scratch/installed-wheel/slurm.sh" || fail "what it starts again is not itself"
}

# The program for x86-64 Linux with its pages, as an archive and as a Debian package: the wheel's code, built from the same sources.
archive() {
    local name=oneiro-$version-x86_64-linux stage=$scratch/stage program shell
    sources
    say "the program"
    program=$stage/$name/bin/oneiro
    if [ -n "${ONEIRO_BUILT:-}" ]; then
        command install -D "$ONEIRO_BUILT/oneiro" "$program"
    else
        (cd "$source" && ONEIRO_BUILT_FROM=$commit PATH=$tools/bin:$PATH cargo zigbuild --profile dist --target x86_64-unknown-linux-gnu.2.28 -p oneiro-host --no-default-features \
            --features film,gpu,mimalloc,native,parquet,twin --target-dir "$folder/wheel" >"$scratch/log" 2>&1) || fail "$(cat "$scratch/log")"
        command install -D "$folder/wheel/x86_64-unknown-linux-gnu/dist/oneiro" "$program"
    fi
    strip "$program"
    needs_libc "$program"
    "$program" man "$stage/$name/share/man/man1" --quiet >/dev/null
    shared() { command install -D -m 644 "$1" "$stage/$name/share/$2"; }
    for shell in bash:bash-completion/completions/oneiro zsh:zsh/site-functions/_oneiro fish:fish/vendor_completions.d/oneiro.fish; do
        "$program" completions "${shell%%:*}" >"$scratch/completions"
        shared "$scratch/completions" "${shell#*:}"
    done
    for file in LICENSE-MIT LICENSE-APACHE CHANGELOG.md; do shared "$file" "doc/oneiro/$file"; done
    shared packaging/third-party.txt doc/oneiro/THIRD-PARTY.txt
    # The same bytes from the same files.
    tar -C "$stage" --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$(git log -1 --format=%ct)" -c "$name" | gzip -n9 >"$packages/$name.tar.gz"
    mkdir "$scratch/unpacked"
    began=$EPOCHREALTIME
    tar -C "$scratch/unpacked" -xf "$packages/$name.tar.gz"
    installed="($EPOCHREALTIME - $began)"
    first archive "$(stat -c %s "$packages/$name.tar.gz")" "$scratch/unpacked/$name/bin/oneiro"
    cmp <("$scratch/unpacked/$name/bin/oneiro" completions bash) "$scratch/unpacked/$name/share/bash-completion/completions/oneiro"
    man --warnings -l "$scratch/unpacked/$name/share/man/man1/oneiro-run.1" >/dev/null 2>"$scratch/man" || true
    [ ! -s "$scratch/man" ] || fail "$(cat "$scratch/man")"

    say "the Debian package"
    local root=$scratch/debian doc=$scratch/debian/usr/share/doc/oneiro deb=$packages/oneiro_${version}_amd64.deb
    mkdir -p "$root/DEBIAN" "$root/usr"
    cp -r "$stage/$name/bin" "$stage/$name/share" "$root/usr/"
    rm "$doc"/LICENSE-*
    mv "$root/usr/share/zsh/site-functions" "$root/usr/share/zsh/vendor-completions"
    gzip -n9 "$root"/usr/share/man/man1/* "$doc/CHANGELOG.md" "$doc/THIRD-PARTY.txt"
    printf '%s\n\n  * %s\n\n -- %s  %s\n' "oneiro ($version) unstable; urgency=low" "Released. CHANGELOG.md.gz has the changes." \
        "$(sed -n 's/^Maintainer: //p' packaging/debian/control)" "$(git log -1 --format=%cD)" | gzip -n9 >"$doc/changelog.gz"
    sed "s/@VERSION@/$version/; s/@SIZE@/$(du -sk "$root/usr" | cut -f1)/" packaging/debian/control >"$root/DEBIAN/control"
    { cat packaging/debian/copyright && sed 's/^$/./; s/^/ /' LICENSE-MIT; } >"$doc/copyright"
    (cd "$root" && find usr -type f -print0 | sort -z | xargs -0 md5sum) >"$root/DEBIAN/md5sums"
    find "$root" -type d -exec chmod 755 {} +
    find "$root/DEBIAN" "$root/usr/share" -type f -exec chmod 644 {} +
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct) dpkg-deb --root-owner-group -Zxz --build "$root" "$deb" >/dev/null
    if command -v lintian >/dev/null; then
        # A package of Debian itself would close the report that asked for it.
        lintian --fail-on warning,error --allow-root --suppress-tags initial-upload-closes-no-bugs "$deb"
    fi
    mkdir "$scratch/deb"
    began=$EPOCHREALTIME
    dpkg-deb -x "$deb" "$scratch/deb"
    installed="($EPOCHREALTIME - $began)"
    first deb "$(stat -c %s "$deb")" "$scratch/deb/usr/bin/oneiro"
}

[ $# -gt 0 ] || set -- crates wheel archive
for way; do
    case $way in
    crates | wheel | archive) "$way" ;;
    *)
        echo "usage: $0 [crates|wheel|archive].." >&2
        exit 2
        ;;
    esac
done
say "from the files to the first result"
printf '%-20s %12s %8s\n' way bytes seconds
printf '%s\n' "${table[@]}"
