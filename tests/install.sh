# For scripts to source: installs Debian packages by name, and Python packages.

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

# python_with MODULES PACKAGE...: sets $python to one in the build folder, in $python_folder there if that is set, that imports the
# modules, a comma between them, and installs packages for that. Kept between calls, except for leftovers of an interrupted call.
# Fails with the reason in $problem.
python_with() {
    local modules=$1 folder
    shift
    folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/${python_folder:-python}")
    python=$folder/bin/python
    "$python" -c "import $modules" 2>/dev/null && return
    python3 -c 'import venv, ensurepip' 2>/dev/null || {
        say "installing Python"
        problem="there is no python3 that makes virtual environments"
        install python3 python3-venv || return
    }
    say "installing $*"
    problem="python3 makes no virtual environment"
    "$python" -m pip --version >/dev/null 2>&1 || python3 -m venv --clear "$folder" || return
    problem="$* can't be had: is there a network?"
    "$python" -m pip install --quiet --disable-pip-version-check --retries 2 --only-binary :all: "$@"
}
