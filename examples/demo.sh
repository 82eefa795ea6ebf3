#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds, renders the demo scene on both backends and says where the
# pictures and the accounts are: `sh examples/demo.sh [SCENE]`, a glTF file or a procedural scene.
set -eu
scene=${1:-scene:glass}
case $scene in
scene:* | /*) ;;
*) scene=$PWD/$scene ;;
esac
cd "$(dirname "$0")/.."
. host/cmake/setup.sh
setup_install "$SETUP_BUILD $SETUP_RUN"
setup_build "$(setup_keep_tests)"

strata=build/bin/strata
out=build/demo
mkdir -p "$out"
for backend in vulkan gl; do
    "$strata" render "$scene" -o "$out/$backend.png" --backend "$backend" \
        --account "$out/$backend.json" || setup_fail "rendering on $backend failed (see above)"
done
printf 'scene    %s\n' "$scene"
for backend in vulkan gl; do
    printf '%-8s %s\n         %s (what it cost)\n' "$backend" "$PWD/$out/$backend.png" \
        "$PWD/$out/$backend.json"
done
printf 'compare  '
"$strata" compare "$out/vulkan.png" "$out/gl.png" | tr -s ' \n' ' '
printf '\n'
