#!/bin/sh
# SPDX-License-Identifier: MIT
#
# The texts' tables: sh tests/bench/tables.sh BUILD OUT [TABLE..] [-- ARGUMENTS OF bench]
#
# Runs tests/bench/tables/TABLE.txt (all of them by default) through the benchmark and writes
# OUT/TABLE.json and OUT/TABLE.svg. A table's first lines are "title|TEXT", "x|WHAT X IS" and, if the
# chart shall not show x_floor, "y|FIGURE OF A RESULT", where the camera must stay, "turn|0"; every
# other one is X|SCENE|WIDTHxHEIGHT|CONFIG[|CONFIG..], run in one process beside the floor.
set -eu
[ $# -ge 2 ] && [ -x "$1/tests/bench/bench" ] || {
    echo "usage: tests/bench/tables.sh BUILD OUT [TABLE..] [-- ARGUMENTS OF bench]" >&2
    exit 2
}
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
out=$2
shift 2
mkdir -p "$out"
names=
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    names="$names $1"
    shift
done
[ $# -eq 0 ] || shift
[ -n "$names" ] || names=$(cd "$here/tables" && ls ./*.txt | sed 's|^\./||; s|\.txt$||')
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
STRATA_CACHE_DIR=$work/cache # what was learnt here would change the settings that are not named
export STRATA_CACHE_DIR

# SCENE SIZE CONFIG[|CONFIG..] [ARGUMENTS OF bench]
run_row() {
    scene=$1 size=$2 configs=$3
    shift 3
    while [ -n "$configs" ]; do
        set -- "$@" --config "${configs%%|*}"
        case $configs in
        *'|'*) configs=${configs#*|} ;;
        *) configs= ;;
        esac
    done
    "$build/tests/bench/bench" --scene "$scene" --size "$size" "$@" </dev/null
}

for name in $names; do
    list=$here/tables/$name.txt
    [ -f "$list" ] || {
        echo "tables.sh: no table $name" >&2
        exit 1
    }
    title=$(sed -n 's/^title|//p' "$list") x=$(sed -n 's/^x|//p' "$list")
    turn=$(sed -n 's/^turn|//p' "$list")
    y=$(sed -n 's/^y|//p' "$list")
    printf '{"table": "%s", "title": "%s", "x": "%s", "rows": [' "$name" "$title" "$x" \
        >"$work/table"
    comma=
    grep -v -e '^#' -e '^title|' -e '^x|' -e '^y|' -e '^turn|' -e '^$' "$list" >"$work/rows"
    while IFS='|' read -r value scene size configs; do
        echo "tables.sh: $name: $value: $scene $size" >&2
        run_row "$scene" "$size" "$configs" --turn "${turn:-1}" "$@" >"$work/row"
        printf '%s{"x": %s, "bench": %s}' "$comma" "$value" "$(cat "$work/row")" >>"$work/table"
        comma=,
    done <"$work/rows"
    echo ']}' >>"$work/table"
    "$build/tests/bench/chart" "$work/table" ${y:+"$y"} >"$work/chart"
    mv "$work/table" "$out/$name.json"
    mv "$work/chart" "$out/$name.svg"
    echo "$out/$name.json $out/$name.svg"
done
