# For scripts to source: installs Debian packages by name.

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        echo "neither root nor sudo: please run as root: $*" >&2
        return 1
    fi
}

install() {
    command -v apt-get >/dev/null || {
        echo "apt-get is not here; please install by hand what Debian calls: $*" >&2
        return 1
    }
    as_root env DEBIAN_FRONTEND=noninteractive apt-get update -q >/dev/null
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@" >/dev/null
}
