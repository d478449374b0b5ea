#!/usr/bin/env bash
# fresh.sh [--times N] [SUITE]...: runs the README's two commands from nothing, in a bare root of each Debian suite (by default Debian
# 12 and 13) that has a C compiler, git and this machine's Rust toolchain, and nothing else; then again there, until they have passed N
# times in a row (by default once). It tests the last commit. Needs root, mmdebstrap and a network; 12 GB in the build folder, and for
# each suite on two quiet cores three quarters of an hour, and half an hour for each further time.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh
[ "$(id -u)" = 0 ] || {
    echo "fresh.sh mounts folders in another root: please run it as root" >&2
    exit 1
}
command -v mmdebstrap >/dev/null || install mmdebstrap
times=1
[ "${1:-}" != --times ] || {
    times=$2
    shift 2
}
suites=("$@")
[ $# -gt 0 ] || suites=(bookworm trixie)
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/fresh")
toolchain=$(rustc --print sysroot)

# The README's first two blocks of shell commands.
mapfile -t commands < <(awk '/^```/ { inside = !inside && /^```sh/; next } inside' README.md | head -n 2)
case "${commands[*]}" in
"cargo run --release -- run "*" tests/all.sh") ;;
*)
    echo "README.md does not begin with its two commands, but with: ${commands[*]}" >&2
    exit 1
    ;;
esac

# How this machine reaches the network; of all else it knows, the root knows nothing.
network=()
for name in http_proxy https_proxy no_proxy SSL_CERT_FILE PIP_CERT REQUESTS_CA_BUNDLE; do
    [ -z "${!name:-}" ] || network+=("$name=${!name}")
done

# inside ROOT COMMAND: runs a command in the root's copy of the repository. Its mounts and processes end with it.
inside() {
    unshare --mount --pid --fork --kill-child sh -ec '
        root=$1; toolchain=$2; command=$3; shift 3
        mount --rbind /dev "$root/dev"
        mount --rbind /sys "$root/sys"
        mount -t proc proc "$root/proc"
        mount --bind "$toolchain" "$root/opt/rust"
        exec chroot "$root" env -i HOME=/root LANG=C.UTF-8 PATH=/opt/rust/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@" \
            sh -c "cd /root/oneiro && exec $command"
    ' sh "$1" "$toolchain" "$2" "${network[@]}"
}

for suite in "${suites[@]}"; do
    root=$folder/$suite
    rm -rf "$root"
    mkdir -p "$root"
    mmdebstrap --quiet --variant=minbase --include=gcc,libc6-dev,git,ca-certificates "$suite" "$root"
    cp /etc/resolv.conf "$root/etc/"
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    mkdir -p "$root/opt/rust"
    git clone --quiet . "$root/root/oneiro"
    for ((time = 1; time <= times; time++)); do
        for command in "${commands[@]}"; do
            began=$SECONDS
            echo "$suite, $time of $times: $command"
            inside "$root" "$command" >"$folder/$suite.log" 2>&1 || {
                tail -n 50 "$folder/$suite.log"
                echo "$suite: $command failed; all that it printed is in $folder/$suite.log" >&2
                exit 1
            }
            echo "$suite: passed in $((SECONDS - began)) s"
        done
    done
    rm -rf "$root"
done
