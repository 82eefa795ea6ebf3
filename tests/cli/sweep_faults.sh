#!/bin/sh
# SPDX-License-Identifier: MIT
#
# strata sweep where something is wrong: techniques that fail or whose certificate is a lie (the
# module of tests/modules/flawed), and what each makes of the status, the words and results.json;
# folders that cannot be written, disks that are full, scenes that are not there or vanish.
. "$(dirname "$0")/lib.sh"
installed=$STRATA_MODULE_PATH
export STRATA_MODULE_PATH="$installed:$STRATA_TEST_BUILD/tests/modules/flawed"

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
[ "$(at $r flawed exact)$(at $r flawed front_certified)" = falsefalse ] && ! grep -q 'certified, costs.*(flawed' out &&
    grep -q "Exact costs.*(the plan's own choice)" out
verdict 'a lie is not called exact, nor what it claims certified'

# ---- surroundings
STRATA_MODULE_PATH=$installed STRATA_CACHE_DIR=$folder/cache3
set -- scene:layers --size 8x8 --repeat 1 --only wboit
echo kept >file
refuse 'a folder that is a file' 1 'file: cannot make the folder' sweep "$@" -o file
[ -d /proc/self ] && refuse 'where nobody may write' 1 '/proc/sweep: cannot make the folder' sweep "$@" -o /proc/sweep
refuse 'a folder in none' 1 'no/sweep: cannot make the folder' sweep "$@" -o no/sweep
mkdir -p odd/results.json
refuse 'results that are a folder' 1 'there is one already' sweep "$@" -o odd
refuse 'going on with a folder' 1 'it is no file of results' sweep "$@" -o odd --resume
mkdir -p page/report.html
run sweep "$@" -o page
[ "$status" -eq 1 ] && is_line 'page/report.html: cannot write' && [ "$(get page/results.json complete)" = true ] &&
    clean && rmdir page/report.html && run sweep "$@" -o page --resume && [ "$status" -eq 0 ]
verdict 'a report that cannot be written is written later'
refuse 'a scene that is missing' 1 'none.glb' sweep "$@" --also none.glb -o missing
[ ! -e missing ]
verdict 'it is found before the first is measured'
"$strata" scene layers -o vanishes.glb >/dev/null
latin=$(printf 'not\377utf8.glb')
cp vanishes.glb "$latin"
refuse 'a name that is not UTF-8' 1 'it is not UTF-8' sweep "$latin" --size 8x8 --repeat 1 -o name
refuse 'a camera whose name is not' 1 'it is not UTF-8' sweep "$@" --camera "$latin" -o name

"$strata" sweep scene:layers --size 8x8 --repeat 300 --only wboit --also vanishes.glb -o vanished >out 2>err &
worker=$!
tries=0
while ! grep -qs '"state": "measured"' vanished/results.json && [ $tries -lt 600 ]; do
    sleep 0.05
    tries=$((tries + 1))
done
mv vanishes.glb away.glb
status=0
wait $worker || status=$?
[ "$status" -eq 1 ] && is_line 'vanishes.glb' && [ "$(get vanished/results.json complete)" = false ] && clean
verdict 'a scene that vanishes'
mv away.glb vanishes.glb
run sweep scene:layers --size 8x8 --repeat 300 --only wboit --also vanishes.glb -o vanished --resume
[ "$status" -eq 0 ] && [ "$(get vanished/results.json 'cases/#')" = 2 ]
verdict 'it is gone on with when the scene is back'

# No file may grow beyond some KiB, in blocks of 512 bytes: as a disk that is full from the beginning, or later.
for blocks in 1 16 24 32; do
    status=0
    (ulimit -f $blocks && exec "$strata" sweep "$@" -o full) >out 2>err || status=$?
    [ "$status" -eq 1 ] && is_line 'full/' && clean &&
        { [ ! -e full/results.json ] || "$json_get" full/results.json >/dev/null; }
    verdict "a disk that is full after $blocks blocks"
    again=
    [ ! -e full/results.json ] || again=--resume
    run sweep "$@" -o full $again
    [ "$status" -eq 0 ] && [ "$(get full/results.json complete)" = true ]
    verdict "it is gone on with when there is room ($again)"
    rm -r full
done
if [ -c /dev/full ]; then
    status=0
    "$strata" sweep "$@" -o words >/dev/full 2>err || status=$?
    [ "$status" -eq 1 ] && is_line 'standard output: cannot write' && [ -s words/report.html ]
    verdict 'words that cannot be said'
fi
if command -v script >/dev/null 2>&1; then
    script -qec "ulimit -f 24; '$strata' sweep scene:layers --size 8x8 --only wboit -o tty" /dev/null \
        >seen </dev/null
    tr '\r' '\n' <seen >lines
    grep -q '%.*floor' lines && grep -q '^strata: tty/' lines
    verdict 'on a terminal a failure stands alone on its line'
fi
finish
