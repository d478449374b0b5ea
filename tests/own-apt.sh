#!/usr/bin/env bash
# Sourced: own_apt FOLDER [SETTINGS] makes the apt-get and apt-cache of this script keep all of their state in FOLDER,
# where the file `status` lists installed packages. The system isn't changed, and root isn't needed.
own_apt() {
    mkdir -p "$1"/lists/partial "$1"/cache/archives/partial
    cat >"$1/apt.conf" <<END
APT::Sandbox::User "$(id -un)";
Acquire::Languages "none";
Dir::State "$1";
Dir::State::Status "$1/status";
Dir::Cache "$1/cache";
${2:-}
END
    export APT_CONFIG=$1/apt.conf
    apt-get update -q >/dev/null 2>&1
}
