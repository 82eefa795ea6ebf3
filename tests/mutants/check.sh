#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Every mutation of tests/mutants/*.txt still changes its file, and names a test program that there is.
# Whether each is killed, tests/mutants/run.sh tells.
set -u
cd "$STRATA_TEST_SOURCE" || exit 1
failures=0
for list in tests/mutants/*.txt; do
    wrong=
    while IFS='|' read -r file change test what; do
        case $file in '' | '#'*) continue ;; esac
        if [ ! -f "$file" ]; then
            wrong="$wrong
  $file: no such file ($what)"
        elif sed "$change" "$file" 2>/dev/null | cmp -s - "$file"; then
            wrong="$wrong
  $file: the expression changes nothing ($what)"
        elif [ ! -x "$STRATA_TEST_BUILD/tests/${test%% *}" ]; then
            wrong="$wrong
  $test: no such test program ($what)"
        fi
    done <"$list"
    if [ -z "$wrong" ]; then
        echo "ok - $list"
    else
        echo "not ok - $list$wrong"
        failures=$((failures + 1))
    fi
done
[ "$failures" -eq 0 ]
