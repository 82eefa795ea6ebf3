#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Test programs that take the name of a test: one that there is not is one line and status 1, and
# one that there is runs that test alone.
set -u
tests=$STRATA_TEST_BUILD/tests failures=0
folder=$(mktemp -d "${TMPDIR:-/tmp}/strata-named-XXXXXX") || exit 1
trap 'rm -rf "$folder"' EXIT

verdict() {
    if [ $? -eq 0 ]; then
        echo "ok - $1"
    else
        echo "not ok - $1: status $status: $(head -c 300 "$folder/err")"
        failures=$((failures + 1))
    fi
}

for program in test_hard hard_large test_exact test_agree test_bound test_kplus; do
    status=0
    "$tests/$program" 'no-such-*' >"$folder/out" 2>"$folder/err" || status=$?
    [ "$status" -eq 1 ] && [ ! -s "$folder/out" ] && [ "$(wc -l <"$folder/err")" -eq 1 ] &&
        grep -qF "no test is named 'no-such-*'" "$folder/err"
    verdict "$program: a name that there is not"
done
status=0
"$tests/test_hard" 'layers-?' >"$folder/out" 2>"$folder/err" || status=$?
[ "$status" -eq 0 ] && grep -q 'layers-1' "$folder/out" "$folder/err" &&
    ! grep -q 'layers-32' "$folder/out" "$folder/err"
verdict 'test_hard: names with a question mark'
[ "$failures" -eq 0 ]
