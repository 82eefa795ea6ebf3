#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Mutants: each line of tests/mutants/*.txt breaks one source and names the test that must fail then.
#
#     sh tests/mutants/run.sh BUILD [PATTERN]    mutants whose line matches PATTERN, all by default
#
# A line is FILE|SED EXPRESSION|TEST PROGRAM|WHAT IT IS; '#' begins a comment, and '.' stands for a
# bar in the expression. The program may have arguments, such as the test that is to run. What the
# file goes into is built again in a copy of the tree; of BUILD only the compilers' settings are used.
# A test must pass with nothing broken before it may kill. It ends with 'N killed, N survived'; the
# status is 0 when none survived. It is not part of tests/run.sh: it takes hours, for all.
set -eu
[ $# -ge 1 ] && [ -f "$1/CMakeCache.txt" ] || {
    echo "usage: tests/mutants/run.sh BUILD [PATTERN]" >&2
    exit 2
}
source=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$1" && pwd)
pattern=${2:-.}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM

tree=$work/tree
mkdir "$tree"
(cd "$source" && tar cf - --exclude=./build --exclude=./.git .) | (cd "$tree" && tar xf -)
cmake -S "$tree" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSTRATA_TESTS=ON \
    $(sed -n 's/^\(CMAKE_C[X]*_COMPILER_LAUNCHER\):[A-Z]*=\(..*\)/-D\1=\2/p' "$build/CMakeCache.txt") \
    >"$work/log" 2>&1 || {
    tail -5 "$work/log" >&2
    exit 1
}

export STRATA_MODULE_PATH="$work/build/lib/strata" STRATA_TEST_SOURCE="$tree" \
    STRATA_TEST_BUILD="$work/build" STRATA_CACHE_DIR="$work/cache"
export CMOCKA_TEST_ABORT=1 # the first failure kills

builds() { ninja -C "$work/build" plugins/all "${1%% *}" >"$work/log" 2>&1; }

passes() { timeout 300 sh -c "\"\$0\"/$1" "$work/build/tests" >"$work/log" 2>&1 </dev/null; }

# Once for each test: one that fails anyway would kill everything.
passes_unbroken() {
    if ! grep -qxF -e "$1" "$work/sound" "$work/unsound"; then
        builds "$1" && passes "$1" && echo "$1" >>"$work/sound" || echo "$1" >>"$work/unsound"
    fi
    grep -qxF -e "$1" "$work/sound"
}

: >"$work/sound"
: >"$work/unsound"
killed=0 survived=0
for list in "$source"/tests/mutants/*.txt; do
    while IFS='|' read -r file change test what; do
        case $file in '' | '#'*) continue ;; esac
        printf '%s|%s|%s|%s\n' "$file" "$change" "$test" "$what" | grep -q -e "$pattern" || continue
        name="$file: $what"
        if ! passes_unbroken "$test"; then
            verdict="survived - $name ($test fails with nothing broken)"
        elif ! sed "$change" "$source/$file" >"$tree/$file"; then
            verdict="survived - $name (not an expression of sed)"
        elif cmp -s "$source/$file" "$tree/$file"; then
            verdict="survived - $name (the expression changes nothing)"
        elif ! builds "$test"; then
            verdict="survived - $name (it does not build)"
        elif passes "$test"; then
            verdict="survived - $name"
        elif [ $? -eq 124 ]; then
            verdict="killed - $name (no end in 300 s)"
        else
            verdict="killed - $name"
        fi
        case $verdict in
        killed*) killed=$((killed + 1)) ;;
        *) survived=$((survived + 1)) ;;
        esac
        echo "$verdict"
        cp "$source/$file" "$tree/$file"
    done <"$list"
done
echo "$killed killed, $survived survived"
[ "$survived" -eq 0 ]
