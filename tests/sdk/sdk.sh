#!/bin/sh
# SPDX-License-Identifier: MIT
#
# The installed SDK, as third parties meet it: installs the build into a scratch prefix that is then
# moved, and builds a module with find_package and a program with pkg-config against it.
set -u
source=$STRATA_TEST_SOURCE
build=$STRATA_TEST_BUILD
unset STRATA_MODULE_PATH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# case NAME COMMAND...: one test case; the command's output is shown when it fails.
case_() {
    name=$1
    shift
    if "$@" >"$work/log" 2>&1; then
        echo "ok - $name"
    else
        sed 's/^/    /' "$work/log"
        echo "not ok - $name"
        failed=1
    fi
}

install_moved() {
    cmake --install "$build" --prefix "$work/first" && mv "$work/first" "$work/prefix" || return 1
    libdir=$(cd "$work/prefix" && dirname "$(ls -d lib*/strata lib/*/strata 2>/dev/null | head -n 1)")
    [ -f "$work/prefix/$libdir/libstrata.so" ] && [ -f "$work/prefix/include/strata/strata.h" ]
}

build_module() {
    cmake -G Ninja -S "$source/tests/sdk/module" -B "$work/module" \
        -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="-Wall -Wextra -Werror" &&
        cmake --build "$work/module" && [ -f "$work/module/glow.so" ]
}

# One symbol, one note, and nothing of libstrata, GL, Vulkan or C++ needed.
check_module() {
    [ "$(nm -D --defined-only "$work/module/glow.so" | awk '{print $3}')" = strata_module_v1 ] &&
        readelf -p .note.strata "$work/module/glow.so" | grep -q '"id":"glow"' &&
        ! readelf -d "$work/module/glow.so" | grep NEEDED | grep -E 'strata|libGL|vulkan|stdc'
}

install_module() {
    cmake --install "$work/module" --prefix "$work/other" &&
        cp "$work/other/$libdir/strata/glow.so" "$work/prefix/$libdir/strata/"
}

# A descriptor that breaks a rule does not build, and the message names the member.
bad_module() {
    cp -r "$source/tests/sdk/module" "$work/bad" &&
        sed -i 's/\.transmittance_channels = 1/.transmittance_channels = 2/' "$work/bad/glow.c" &&
        cmake -G Ninja -S "$work/bad" -B "$work/bad/build" -DCMAKE_PREFIX_PATH="$work/prefix" &&
        ! cmake --build "$work/bad/build" >"$work/bad/log" &&
        grep 'glow: transmittance_channels is 1 or 3, not 2' "$work/bad/log" &&
        [ ! -f "$work/bad/build/glow.so" ]
}

# Without CMake: cc, pkg-config and strata-note.
module_by_hand() {
    pc() { PKG_CONFIG_PATH="$work/prefix/$libdir/pkgconfig" pkg-config "$@" strata; }
    mkdir -p "$work/hand" && cd "$work/hand" &&
        cmake -DID=glow -DBASE="$source/tests/sdk/module" -DFOLDER=. \
            -DFILES="$source/tests/sdk/module/glow.glsl" \
            -P "$work/prefix/$libdir/cmake/Strata/embed_glsl.cmake" &&
        objects="$source/tests/sdk/module/glow.c glow_glsl.c" &&
        flags="-shared -fPIC -fvisibility=hidden -I. $(pc --cflags)" &&
        flags="$flags -Wl,--version-script=$(pc --variable=modulemap) -Wl,-z,defs" &&
        cc $flags -o bare.so $objects && "$(pc --variable=note)" bare.so note.c &&
        cc $flags -o glow.so $objects note.c &&
        readelf -p .note.strata glow.so | grep -q '"id":"glow"'
}

build_program() {
    # shellcheck disable=SC2046
    cc -std=c11 -Wall -Werror -o "$work/program" "$source/tests/sdk/program.c" \
        $(PKG_CONFIG_PATH="$work/prefix/$libdir/pkgconfig" pkg-config --cflags --libs strata) \
        "-Wl,-rpath,$work/prefix/$libdir"
}

# The example in examples/embed, with CMake, rendering on the null backend and on a real one.
embed_program() {
    cmake -G Ninja -S "$source/examples/embed" -B "$work/embed" \
        -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="-Wall -Wextra -Werror" &&
        cmake --build "$work/embed" && cd "$work" &&
        "$work/embed/embed" scene:shells null && "$work/embed/embed" scene:shells >"$work/embedded" &&
        grep -q '^frame 7: mean colour 0' "$work/embedded" && [ -s embed.png ]
}

# What a program and the command line see: the modules of the prefix, the third party's among them.
list_modules() {
    "$work/program" >"$work/list" && grep -q '"over"' "$work/list" && grep -q '"glow"' "$work/list"
}

command_line() {
    "$work/prefix/bin/strata" list --json >"$work/list" && grep -q '"glow"' "$work/list"
}

case_ "the installed tree can be moved" install_moved
case_ "a module builds with find_package" build_module
case_ "the module shows one symbol and needs nothing" check_module
case_ "the module installs" install_module
case_ "a bad descriptor does not build" bad_module
case_ "a module builds without CMake" module_by_hand
case_ "a program builds with pkg-config" build_program
case_ "the embedding example builds and renders" embed_program
case_ "the program finds the modules" list_modules
case_ "the command line finds the modules" command_line
exit $failed
