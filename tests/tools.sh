#!/usr/bin/env bash
# tools.sh: installs what tests/all.sh needs and is not there. Only the software Vulkan driver must be: it fails without it.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh

say() { printf '\n== %s\n' "$*"; }

# The GPU tests run on Mesa's software driver, on any machine.
has_software_vulkan() {
    local driver
    ldconfig -p 2>/dev/null | grep 'libvulkan\.so\.1' >/dev/null || return 1
    for driver in /usr/share/vulkan/icd.d/lvp_icd*.json /etc/vulkan/icd.d/lvp_icd*.json; do
        [ -e "$driver" ] && return
    done
    return 1
}

software_vulkan() {
    has_software_vulkan && return
    say "installing the software Vulkan driver"
    install mesa-vulkan-drivers libvulkan1 && has_software_vulkan && return
    echo "no software Vulkan driver (lavapipe), and it could not be installed: the GPU tests need it" >&2
    exit 4
}

# The page that plays a swarm is opened in a browser if one is available.
browser() {
    local name
    for name in chromium chromium-browser google-chrome; do
        command -v "$name" >/dev/null && return
    done
    say "installing a browser"
    install chromium || echo "no browser: the page that plays a swarm will not be tested in one"
}

# The types of pages' scripts are checked if their compiler is available.
type_checker() {
    command -v tsc >/dev/null && return
    say "installing the TypeScript compiler"
    install nodejs node-typescript || echo "no tsc: the types of pages' scripts will not be checked"
}

# The compiler's output is checked by a validator if it is available.
validator() {
    command -v spirv-val >/dev/null && return
    say "installing a validator of SPIR-V"
    install spirv-tools || echo "no validator: SPIR-V will not be validated"
}

# Controllers as C are compiled by these, and run.
c_compilers() {
    local name
    for name in gcc clang cppcheck; do
        command -v "$name" >/dev/null && continue
        say "installing C compilers"
        install gcc clang cppcheck || echo "no $name: controllers as C will not be compiled by it"
        return
    done
}

# Controllers in other languages run there.
languages() {
    local name
    for name in g++ node lua5.1 lua5.4 python3; do
        command -v "$name" >/dev/null && continue
        say "installing languages that controllers are exported to"
        install g++ nodejs lua5.1 lua5.4 python3 || echo "no $name: controllers will not run in its language"
        return
    done
}

# Controllers as C run on microcontrollers, which are emulated.
microcontrollers() {
    local name
    local long=(riscv64-unknown-elf-gcc qemu-system-riscv64 clang wasm-ld)
    [ -n "${ONEIRO_LONG:-}" ] || long=()
    for name in arm-none-eabi-gcc qemu-system-arm avr-gcc simavr "${long[@]}" /usr/share/arduino/hardware/arduino/avr/cores/arduino/main.cpp; do
        command -v "$name" >/dev/null || [ -e "$name" ] && continue
        say "installing compilers and emulators of microcontrollers"
        [ ${#long[@]} = 0 ] || install gcc-riscv64-unknown-elf qemu-system-misc clang lld || echo "no $name"
        install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm gcc-avr avr-libc simavr arduino-core-avr ||
            echo "no $name: controllers as C will not run on microcontrollers"
        return
    done
}

# Robots are driven in a simulator if it is available.
simulator() {
    local name
    for name in asebaplayground asebaswitch faketime ip unshare /usr/share/i18n/locales/en_US; do
        { command -v "$name" || [ -e "$name" ]; } >/dev/null && continue
        say "installing a simulator of robots"
        # Aseba's compiler asks for a locale.
        install aseba faketime iproute2 util-linux locales || echo "no asebaplayground: robots will not be driven in it"
        return
    done
}

# Scripts in pages run with the packages that they say they need (tests/python.sh has the same environment).
python_packages() {
    python_folder=python-sweeps python_with numpy,pandas,polars,pyarrow numpy pandas polars pyarrow ||
        echo "Python: $problem; scripts in pages will not be run"
}

software_vulkan
python_packages
browser
type_checker
validator
c_compilers
languages
microcontrollers
simulator
