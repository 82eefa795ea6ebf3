# SPDX-License-Identifier: MIT
#
# What tests/run.sh and examples/demo.sh share: install what is missing (Debian 12, Debian 13,
# Ubuntu 24.04), configure, build. To be sourced from the top folder by a POSIX sh:
#
#     . host/cmake/setup.sh
#     setup_install "$SETUP_BUILD $SETUP_RUN"     packages, by name
#     setup_build OFF                             STRATA_TESTS
#
# Says what it is about to do, says nothing when there is nothing to do, and ends the script with
# one line that names what is missing when it cannot go on.

SETUP_BUILD="cmake ninja-build g++ gcc pkg-config glslang-dev spirv-tools libspirv-cross-c-shared-dev
    libcglm-dev libtinygltf-dev nlohmann-json3-dev libstb-dev libopenexr-dev libpng-dev libmeshoptimizer-dev libjansson-dev
    libvulkan-dev libegl-dev libgl-dev libjs-chart.js"
SETUP_RUN="mesa-vulkan-drivers libegl1 libgl1-mesa-dri"
SETUP_TEST="libcmocka-dev vulkan-validationlayers openimageio-tools binutils assimp-testmodels"
SETUP_LOG=build/setup.log

setup_say() {
    printf 'strata: %s\n' "$*" >&2
}

setup_fail() {
    setup_say "$*"
    exit 1
}

# The end of the log, indented, after a step failed.
setup_show_log() {
    tail -n "${1:-30}" "$SETUP_LOG" | sed 's/^/    /' >&2
}

# Prints those of the packages named that are not installed.
setup_missing() {
    for package in $1; do
        status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) || status=none
        [ "$status" = installed ] || printf '%s ' "$package"
    done
}

# Runs a command as root.
setup_as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif [ -t 0 ]; then
        sudo "$@"
    else
        sudo -n "$@"
    fi
}

setup_apt() {
    setup_as_root env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get -qq -o Dpkg::Use-Pty=0 \
        -o DPkg::Lock::Timeout=120 -o Acquire::Retries=2 "$@" >>"$SETUP_LOG" 2>&1 </dev/null
}

setup_install() {
    mkdir -p build && : >"$SETUP_LOG" || setup_fail "cannot write $PWD/build"
    if ! command -v dpkg-query >/dev/null 2>&1; then
        setup_say "not a Debian or Ubuntu system: going on with what is installed"
        for tool in cmake ninja cc c++ pkg-config; do
            command -v "$tool" >/dev/null 2>&1 || setup_fail "missing: $tool"
        done
        return 0
    fi
    missing=$(setup_missing "$1")
    [ -n "$missing" ] || return 0
    command -v apt-get >/dev/null 2>&1 ||
        setup_fail "these packages are missing, and there is no apt-get to install them: $missing"
    [ "$(id -u)" = 0 ] || command -v sudo >/dev/null 2>&1 ||
        setup_fail "these packages are missing, and installing them needs root or sudo: $missing"
    setup_say "installing with apt-get: $missing"
    setup_apt update || {
        setup_show_log 5
        setup_fail "apt-get update failed (see above); still missing: $missing"
    }
    # shellcheck disable=SC2086
    setup_apt install --no-install-recommends -y $missing || {
        setup_show_log 10
        ! grep -q 'Unable to locate' "$SETUP_LOG" || ! grep -qs '^ID=ubuntu' /etc/os-release ||
            setup_say "on Ubuntu, some of these are in the component universe; is it enabled?"
        setup_fail "apt-get install failed (see above); still missing: $(setup_missing "$missing")"
    }
}

# STRATA_TESTS as build/ has it: who has built the tests keeps them.
setup_keep_tests() {
    if grep -qs '^STRATA_TESTS:BOOL=ON' build/CMakeCache.txt; then echo ON; else echo OFF; fi
}

# Configures and builds everything into build/.
setup_build() {
    fresh=
    if [ -f build/CMakeCache.txt ]; then
        # A checkout that was moved or copied together with its build folder.
        grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$(pwd -P)" build/CMakeCache.txt || fresh=--fresh
    fi
    # shellcheck disable=SC2086
    cmake $fresh --preset release -DSTRATA_TESTS="$1" -DSTRATA_WERROR="${STRATA_WERROR:-OFF}" \
        >"$SETUP_LOG" 2>&1 || {
        setup_show_log
        setup_fail "cmake could not configure the build (see above)"
    }
    if ! ninja -C build -n 2>/dev/null | grep -q 'no work to do'; then
        setup_say "building into $PWD/build"
        ninja -C build --quiet >"$SETUP_LOG" 2>&1 || {
            setup_show_log 60
            setup_fail "the build failed (see above)"
        }
    fi
}
