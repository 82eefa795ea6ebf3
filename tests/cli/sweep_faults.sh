#!/bin/sh
# SPDX-License-Identifier: MIT
#
# strata sweep where something is wrong: techniques that fail or whose certificate is a lie (the
# module of tests/modules/flawed), and what each makes of the status, the words and results.json.
. "$(dirname "$0")/lib.sh"
STRATA_MODULE_PATH=$STRATA_MODULE_PATH:$STRATA_TEST_BUILD/tests/modules/flawed
export STRATA_MODULE_PATH

if ! have_device; then
    echo "skip - faults of sweeps: no device that draws"
    exit 0
fi

# at FILE NAME MEMBER: of the configuration of this name in the first case.
at() {
    i=0
    while [ "$(get "$1" "cases/0/configurations/$i/name")" != "$2" ]; do
        i=$((i + 1))
        [ $i -lt 100 ] || return 1
    done
    get "$1" "cases/0/configurations/$i/$3"
}

# ---- some fail; with one fragment a pixel none is wrong
export STRATA_CACHE_DIR="$folder/cache"
set -- sweep 'scene:layers?count=1' --size 16x16 --repeat 4 --only flawed --only wboit -o failed
failed() {
    r=failed/results.json
    [ "$status" -eq 3 ] && [ ! -s err ] && grep -q '2 failed; every' out && grep -q failed/report.html out &&
        [ "$(get $r complete)$(get $r failed)$(get $r violations)" = 'true2[]' ]
}
run "$@"
failed
verdict 'less than was asked for: status 3'
for mode in fails late; do
    [ "$(at $r "flawed mode=$mode" state)" = failed ] &&
        [ "$(at $r "flawed mode=$mode" reason)" = 'flawed: it fails on purpose' ]
    verdict "mode=$mode stands there with its reason"
done
[ "$(at $r 'flawed mode=fails' error)" = '' ] && [ "$(at $r 'flawed mode=late' error/max)" = 0 ]
verdict 'what was known before it failed stays'
for name in floor "the plan's own choice" flawed wboit; do
    [ "$(at $r "$name" state)" = measured ] && [ "$(at $r "$name" frames)" = 4 ]
    verdict "$name is measured beside them"
done
grep -q 'it fails on purpose' failed/report.html
verdict 'the report says why'
run "$@" --resume
failed && [ "$(at $r 'flawed mode=late' state)" = failed ]
verdict 'what failed is not tried again'

# ---- a certificate that does not hold
export STRATA_CACHE_DIR="$folder/cache2"
run sweep 'scene:layers?count=12' --size 16x16 --repeat 1 --only flawed -o lies
r=lies/results.json line='flawed: channels farther from the exact image than certified'
[ "$status" -eq 1 ] && [ "$(grep -cF "does not hold: scene:layers?count=12: $line" err)" -eq 1 ]
verdict 'a certificate that does not hold: status 1'
[ "$(wc -l <err)" -eq 2 ] && [ "$(get $r 'violations/#')" = 2 ] && [ "$(get $r failed)" = 2 ] &&
    get $r violations/0 | grep -qF "$line"
verdict 'it is listed, and so is one that failed later'
[ "$(at $r flawed state)" = measured ] && [ "$(at $r flawed bound/max)" = 0 ] &&
    [ "$(at $r "the plan's own choice" error/violations)" = 0 ]
verdict 'the others hold'
finish
