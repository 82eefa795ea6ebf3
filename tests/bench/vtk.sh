#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Beside VTK on the same meshes, camera and opacities, one after the other on one machine:
#
#     sh tests/bench/vtk.sh BUILD [OUT [FRAMES]]     OUT: a folder, '.' by default
#
# For nested shells of 60,000 to 80,000 triangles, 20 and 60 deep in the middle, 512x512: writes
# OUT/vtk-DEPTH.json with VTK's figures ("vtk") and those of Strata's bench ("strata"), and prints the
# ratios. Needs Debian's python3-vtk9 and xvfb; without them it says so and ends with status 77.
set -eu
[ $# -ge 1 ] && [ -x "$1/tests/bench/bench" ] || {
    echo "usage: tests/bench/vtk.sh BUILD [OUT [FRAMES]]" >&2
    exit 2
}
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
out=${2:-.}
frames=${3:-11}
python=/usr/bin/python3 # the one that Debian's modules are for
command -v xvfb-run >/dev/null && "$python" -c 'import vtk' 2>/dev/null || {
    echo "vtk.sh: python3-vtk9 and xvfb are not installed" >&2
    exit 77
}
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
# Both keep the memory that their driver frees, see strata_keep_memory.
MALLOC_MMAP_THRESHOLD_=33554432 MALLOC_TRIM_THRESHOLD_=536870912
export MALLOC_MMAP_THRESHOLD_ MALLOC_TRIM_THRESHOLD_
STRATA_CACHE_DIR=$work/cache # what was learnt here would change the settings that are not named
export STRATA_CACHE_DIR

# A shell is crossed twice: half as many as layers, of 8 * 4^n triangles.
for row in '20 10 5' '60 30 4'; do
    set -- $row
    depth=$1
    "$build/bin/strata" scene shells --set "count=$2" --set "subdivision=$3" --set alpha=0.15 \
        --set core=0 -o "$work/scene.glb" >&2
    echo "vtk.sh: $depth layers: VTK" >&2
    xvfb-run -a "$python" "$here/vtk_frames.py" "$work/scene.glb" 512 512 "$frames" >"$work/vtk"
    echo "vtk.sh: $depth layers: Strata" >&2
    "$build/tests/bench/bench" --scene "$work/scene.glb" --size 512x512 --frames "$frames" \
        --backends vulkan,gl --config abuffer,ppc --config 'kplus,ppc kplus.k=8' --config wboit \
        </dev/null >"$work/strata"
    { printf '{"layers": %s, "vtk": ' "$depth" && cat "$work/vtk" && printf ', "strata": ' &&
        sed "s|\"scene\": \"[^\"]*\"|\"scene\": \"shells?count=$2\&subdivision=$3\&alpha=0.15\&core=0\"|" \
            "$work/strata" && echo '}'; } >"$out/vtk-$depth.json"
    "$python" - "$out/vtk-$depth.json" <<'RATIOS'
import json
import sys

run = json.load(open(sys.argv[1]))
vtk = {r["name"]: r["ms"] for r in run["vtk"]["results"]}
for r in run["strata"]["results"]:
    print("%d layers, %s %s: %.1f ms; VTK's dual peeling takes %.2f of it, its CPU sort %.2f, weighted %.2f, floor %.2f"
          % (run["layers"], r["backend"], r["name"], r["ms"], *(vtk[k] / r["ms"] for k in
             ("dual", "sort", "weighted", "floor"))))
RATIOS
done
