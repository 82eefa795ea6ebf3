#!/bin/sh
# SPDX-License-Identifier: MIT
#
# strata sweep: results.json has the guide's shape and holds what the sweep promises, a sweep that was
# killed goes on where it was, and files that are no such sweep are refused with one line.
. "$(dirname "$0")/lib.sh"
STRATA_CACHE_DIR=$folder/cache # sweeps learn what techniques cost
export STRATA_CACHE_DIR

if ! have_device; then
    echo "skip - sweep: no device that draws"
    exit 0
fi

# value NAME FILE PATH WANTED
value() {
    [ "$(get "$2" "$3")" = "$4" ] || echo "  $3 is '$(get "$2" "$3")', not '$4'"
    [ "$(get "$2" "$3")" = "$4" ]
    verdict "$1"
}

# ---- options
refuse 'sweep without a scene' 2 'SCENE is missing' sweep
refuse 'sweep: --use' 2 '--use does not go with a sweep' sweep scene:stack --use peel
refuse 'sweep: --set' 2 '--set does not go with a sweep' sweep scene:stack --set peel.layers=2
refuse 'sweep: frame settings' 2 '--set does not go' sweep scene:stack --set frame.bands=2
refuse 'sweep: --tolerance' 2 '--tolerance does not go' sweep scene:stack --tolerance 0.1
refuse 'sweep: null' 2 'draws nothing' sweep scene:stack --backend null
refuse 'sweep: --repeat' 2 '--repeat 0: expected' sweep scene:stack --repeat 0
refuse 'sweep: no scene' 1 'none.glb' sweep none.glb -o none
refuse 'sweep: nothing to go on with' 1 'there is none to go on with' sweep scene:stack -o new --resume

# ---- a sweep
scene='scene:layers?count=12'
set -- sweep "$scene" --size 32x32 --repeat 2 --only abuffer --only 'kplus k=4' --only wboit
run "$@" -o one
[ "$status" -eq 0 ] && [ ! -s err ] && [ -s one/report.html ] && clean
verdict 'a sweep is done'
r=one/results.json
"$json_get" $r >/dev/null
verdict 'results are one object'
value 'format' $r format strata-sweep/3
value 'complete' $r complete true
value 'no violations' $r violations '[]'
value 'scene' $r cases/0/scene 'scene:layers?count=12'
value 'size' $r cases/0/size '[32,32]'
value 'depth' $r cases/0/fragments/max_per_pixel 12
value 'complexity: all pixels hold 12' $r cases/0/complexity/held '[[12,1024]]'
value 'the floor is the first' $r cases/0/configurations/0/name floor
value 'the floor is measured' $r cases/0/configurations/0/state measured
value 'the floor is 1 x floor' $r cases/0/configurations/0/x_floor 1
value 'the floor has no certificate' $r cases/0/configurations/0/bound null
value 'the plan is the second' $r cases/0/configurations/1/use ''
value 'the plan is exact' $r cases/0/configurations/1/error/max 0
value 'frames' $r cases/0/configurations/1/frames 2
value 'device' $r device/backend "$(get devices.json devices/0/backend)"
count=$(get $r 'cases/0/configurations/#')
[ "$count" -gt 10 ]
verdict 'there are configurations'
grep -q 'Exact costs' out && grep -q 'one/report.html' out
verdict 'it ends with words'

# Each configuration by itself: state, figures, and that exact ones are.
i=0 wrong=
while [ $i -lt "$count" ]; do
    c=cases/0/configurations/$i
    name=$(get $r $c/name)
    [ "$(get $r $c/state)" = measured ] || wrong="$wrong; $name: $(get $r $c/state)"
    [ "$(get $r $c/error/violations)" = 0 ] || wrong="$wrong; $name: beyond its certificate"
    get $r $c/pace_ms | grep -q '[1-9]' || wrong="$wrong; $name: no pace"
    for member in ms mad_ms cpu_frame_ms x_floor memory command passes/0/label error/flip/mean \
        error/rmse error/uncertified_pixels rounds/0/0 pace_ms/0 pace/0; do
        get $r $c/$member >value && [ -s value ] || wrong="$wrong; $name: no $member"
    done
    case $name in
    'abuffer mode=contiguous + ppc' | 'abuffer mode=linked + ppc')
        [ "$(get $r $c/error/max)$(get $r $c/exact)" = 0true ] || wrong="$wrong; $name: not exact"
        ;;
    'kplus k=4 + ppc')
        [ "$(get $r $c/keeps)$(get $r $c/exact)" = 4false ] || wrong="$wrong; $name: exact"
        [ "$(get $r $c/error/max)" != 0 ] || wrong="$wrong; $name: no error"
        ;;
    esac
    i=$((i + 1))
done
[ -z "$wrong" ] || echo "  $wrong"
[ -z "$wrong" ]
verdict 'each configuration has its figures'

# The k that pixels are said to need for 1/255: all alike here, so with fewer the error is above it.
run sweep "$scene" --size 8x8 --repeat 1 --only 'kplus k=' --only 'kplus + ppc' -o k
k=$(get k/results.json cases/0/complexity/needed/0/0)
[ "$status" -eq 0 ] && [ "$(get k/results.json 'cases/0/complexity/needed/#')" = 1 ] && [ "$k" -gt 1 ]
verdict 'all pixels need the same k'
i=2 wrong=
while [ $i -lt "$(get k/results.json 'cases/0/configurations/#')" ]; do
    c=cases/0/configurations/$i
    i=$((i + 1))
    [ "$(get k/results.json $c/payload)" = float ] || continue
    awk -v keeps="$(get k/results.json $c/keeps)" -v k="$k" \
        -v error="$(get k/results.json $c/error/max)" \
        'BEGIN { exit !((keeps == 0 || keeps >= k) == (error <= 1 / 255)) }' ||
        wrong="$wrong; $(get k/results.json $c/name) is off by $(get k/results.json $c/error/max)"
done
[ -z "$wrong" ] || echo "  $k are needed$wrong"
[ -z "$wrong" ]
verdict 'with so many it is right to 1/255, with fewer it is not'

# A command reproduces its point.
command=$(get $r cases/0/configurations/2/command)
(eval "\"\$strata\" ${command#strata }") >out 2>err && [ -s out.exr ]
verdict 'a command renders'

refuse 'results are not written over' 1 '--resume goes on with it' "$@" -o one

run sweep "$scene" --size 8x8 --repeat 1 --only wboit --only kplsu -o typo
[ "$status" -eq 0 ] && is_line "warning: --only 'kplsu': no way to render scene:layers?count=12 is named so"
verdict 'a name that no configuration has is said'

# What shows something else than the picture is no configuration; nor does a fold that the plan chose
# promise bits.
run sweep "$scene" --size 8x8 --repeat 1 --all --only cullcheck --only hiz -o diagnostic
[ "$status" -eq 0 ] && ! grep -q 'cullcheck show' diagnostic/results.json &&
    grep -q '"name": "cullcheck"' diagnostic/results.json
verdict 'what is not a picture is not judged as one'

# Without the technique that gives the exact image, another does, with what makes it exact.
mkdir without
for module in "$STRATA_MODULE_PATH"/*; do
    case $module in */abuffer.so) ;; *) ln -s "$module" without/ ;; esac
done
status=0
STRATA_MODULE_PATH=$folder/without "$strata" sweep "$scene" --size 8x8 --repeat 1 --only 'kplus k=0' -o other \
    >out 2>err || status=$?
[ "$status" -eq 0 ] && [ "$(get other/results.json cases/0/reference/settings)" = '["kplus.k=0"]' ]
verdict 'the exact image is made with the settings that make it exact'

# ---- killed and gone on with
"$strata" "$@" -o two >out 2>err &
worker=$!
tries=0
while ! grep -qs '"state": "measured"' two/results.json && [ $tries -lt 600 ]; do
    sleep 0.1
    tries=$((tries + 1))
done
kill -9 $worker 2>/dev/null
wait $worker 2>/dev/null
"$json_get" two/results.json >/dev/null && [ "$(get two/results.json complete)" = false ]
verdict 'a killed sweep leaves whole results'
rm -f two/*.part
kept=$(get two/results.json cases/0/configurations/0/rounds)
run "$@" -o two --resume
[ "$status" -eq 0 ] && [ "$(get two/results.json complete)" = true ]
verdict 'it is gone on with'
[ "$kept" = '[]' ] || [ "$(get two/results.json cases/0/configurations/0/rounds)" = "$kept" ]
verdict 'what was measured stays'
[ "$(get two/results.json 'cases/0/configurations/#')" = "$count" ] &&
    [ "$(get two/results.json 'cases/#')" = 1 ]
verdict 'nothing is there twice'

# The pace of the first three rewritten: as usual, twice as slow, unknown.
member() { get two/results.json "cases/0/configurations/$1/$2"; }
awk '/"pace_ms": \[/ { at++; print; getline; $0 = (at == 2 ? 2 : at == 3 ? 0 : 1) } { print }' \
    two/results.json >two/paced && mv two/paced two/results.json
run "$@" -o two --resume
[ "$status" -eq 0 ] && [ "$(get two/results.json cases/0/pace_ms)" = 1 ] && [ "$(member 0 pace)" = '[1.0]' ] &&
    [ "$(member 1 pace)" = '[2.0]' ] && [ "$(member 2 pace)" = '[1.0]' ]
verdict 'paces are multiples of the usual one'
for at in 0 1 2; do
    echo "$(member $at rounds/0/0) $(member $at rounds/0/1) $(member $at pace/0) $(member $at ms)" \
        "$(member $at cpu_ms/0) $(member $at cpu_frame_ms)"
done | awk 'function near(a, b) { return a > 0 && a / b > 1 - 1e-6 && a / b < 1 + 1e-6 }
    { wrong += !(near(($1 + $2) / 2 / $3, $4) && near($5, $6)) } END { exit wrong || NR != 3 }'
verdict 'and times are divided by them'
# lose_third FIRST OTHERS: of two/ the times of the third configuration are lost, and the floor beside the
# first took FIRST ms, beside the others OTHERS; 0: as long as it did.
lose_third() {
    awk -v first="$1" -v others="$2" '
        /"state": / { pace = ++at == 1 ? first : others }
        /"state": / && at == 3 { sub(/"measured"/, "\"pending\"") }
        /"(rounds|cpu_ms|pace_ms)": \[/ && at == 3 { sub(/\[.*/, "[],"); print; lost = 1 }
        lost { lost = !/^     \]/; next }
        { print }
        /"pace_ms": \[/ && pace > 0 { getline; print pace }' two/results.json >two/edited &&
        mv two/edited two/results.json
}

# What is measured anew is learnt as if it were in the pace of the others, 100 s a frame.
lose_third 100000 100000
STRATA_CACHE_DIR=$folder/paced
run "$@" -o two --resume
STRATA_CACHE_DIR=$folder/cache
[ "$status" -eq 0 ] && [ "$(member 2 'rounds/#')" = 1 ] && [ "$(member 1 pace_ms/0)" = 100000 ] &&
    grep -Eq '"ms":[0-9]{4}' paced/costs/*.json
verdict 'what is learnt is in the usual pace'
lose_third 100000 1
run "$@" -o two --resume
[ "$status" -eq 0 ] && [ "$(member 2 'rounds/#')" = 1 ] && [ "$(member 0 'pace_ms/#')" = 1 ] &&
    [ "$(member 0 pace_ms/0)" != 100000 ] && [ "$(member 1 pace_ms/0)" = 1 ]
verdict 'what was measured in a slow moment is measured again'
rm -r two/pictures two/report.html
run "$@" -o two --resume
[ "$status" -eq 0 ] && [ -s two/report.html ] && [ -s two/pictures/0-0-exact.png ]
verdict 'a sweep that is done is done again at once'
run sweep scene:layers --size 8x8 --repeat 1 --only wboit --time 0.12345678901234 -o time
run sweep scene:layers --size 8x8 --repeat 1 --only wboit --time 0.12345678901234 -o time --resume
[ "$status" -eq 0 ]
verdict 'so is one at a time of many digits'

# What was much slower than others as accurate at its first turn has no other one; the others, and what
# the plan does, do. The floor, the plan's own choice, two exact ways, half and unorm8 records.
run sweep "$scene" --size 8x8 --repeat 3 --only 'kplus k=0' -o first
# second_round TIMES: of the frames of each, the floor beside them at one pace. $turns: how many each had.
second_round() {
    rm -rf far
    cp -r first far
    awk -v times="$1" 'BEGIN { split(times, ms) }
        /"state": / { at++ }
        /"(rounds|pace_ms)": \[/ { depth = /rounds/ ? 1 : 2; print; next }
        depth && /^ *[0-9]/ { sub(/[0-9][0-9.e+-]*/, depth == 1 ? ms[at] : 1) }
        depth && /^     \]/ { depth = 0 }
        /"frames": 3,/ && !at { sub(/3/, "6") } { print }' first/results.json >far/results.json
    run sweep "$scene" --size 8x8 --repeat 6 --only 'kplus k=0' -o far --resume
    turns=
    for at in 0 1 2 3 4 5; do
        turns=$turns$(get far/results.json "cases/0/configurations/$at/rounds/#")
    done
}
second_round '1 5 5 1 3 1'
[ "$status" -eq 0 ] && [ "$turns" = 221222 ] &&
    [ "$(get far/results.json cases/0/configurations/2/frames)" = 3 ]
verdict 'what is much slower than others as accurate has one turn'
second_round '1 5 5 5 1 1'
[ "$status" -eq 0 ] && [ "$turns" = 222222 ]
verdict 'what is more accurate has all'

# ---- what cannot be gone on with
refuse 'another size' 1 'another scene, size' sweep "$scene" --size 16x16 -o two --resume
i=0
while IFS='|' read -r name edit; do
    i=$((i + 1))
    rm -rf bad
    mkdir bad
    sed "$edit" two/results.json >bad/results.json
    refuse "results that are $name" 1 'cannot go on with it' "$@" -o bad --resume
done <<'END'
empty|d
cut short|20q
of another format|s/strata-sweep.3/strata-sweep.2/
of another machine|s/"cores": /"cores": 9/
of another device|s/"driver": "/"driver": "x/
of other modules|s/"use": "wboit"/"use": "wbait"/
without configurations|s/"configurations": \[/"configurations": 3, "x": [/
with texts for times|s/^\( *\)"rounds": \[/\1"rounds": ["now"], "x": [/
with negative times|s/^\( *\)"cpu_ms": \[/\1"cpu_ms": [-1], "x": [/
with an unknown state|s/"state": "measured"/"state": "nice"/
measured without times|s/"rounds": \[/"rounds": [], "x": [/;s/"cpu_ms": \[/"cpu_ms": [], "y": [/;s/"pace_ms": \[/"pace_ms": [], "z": [/
with negative paces|s/"pace_ms": \[/"pace_ms": [-1], "x": [/
with more paces than rounds|s/"pace_ms": \[/"pace_ms": [1, /
with more rounds than costs|s/"cpu_ms": \[/"cpu_ms": [1, /
with texts for what is kept|s/"keeps": 4/"keeps": "4"/
with other promises|s/"bits": true/"bits": false/
of another payload|s/"payload": "half"/"payload": "float"/
with errors that lack figures|s/"rmse": /"rmsd": /
with texts for errors|s/"violations": 0/"violations": "0"/
without FLIP|s/"flip": {/"flap": {/
with texts for certificates|/"bound": {/,/}/s/"max": /"max": "x", "y": /
with passes that are no list|s/"passes": \[/"passes": 3, "x": [/
with passes of texts|s/"passes": \[/"passes": ["x", /
with another exact way|/"reference": {/,/}/s/"use": "[^"]*"/"use": "wboit"/
of cases twice|s/^ "cases": \[/ "cases": [{}, /
with cases that are no list|s/^ "cases": \[/ "cases": 1, "x": [/
not UTF-8|s/"kplus"/"\xff"/
END
for text in '{}' '[]' '"strata-sweep\/3"' '{"format":"strata-sweep/3"}' '{"format":"strata-sweep/3","format":1}'; do
    echo "$text" >bad/results.json
    refuse "results that are $text" 1 'cannot go on with it' "$@" -o bad --resume
done
mkdir -p odd
mkfifo odd/results.json
refuse 'a pipe for results' 1 'no file of results' "$@" -o odd --resume

# ---- several cases, and names that could break out of a page
cp one/report.html plain.html
hostile='a</script><script>alert(1)</script>&"'"'"'.glb'
mkdir -p "$(dirname "./$hostile")"
"$strata" scene stack --set count=2 -o out.glb >/dev/null && cp out.glb "./$hostile"
run sweep "./$hostile" --size 16x16 --also 8x8 --repeat 1 --only 'abuffer mode=linked + ppc' -o 'three & "four"'
[ "$status" -eq 0 ] && [ "$(get 'three & "four"/results.json' 'cases/#')" = 2 ]
verdict 'two sizes of a scene with a hostile name'
[ "$(grep -c '<script>alert' 'three & "four"/report.html')" = 0 ] &&
    [ "$(grep -o '</script>' 'three & "four"/report.html' | wc -l)" = "$(grep -o '</script>' plain.html | wc -l)" ]
verdict 'its name does not break out of the report'
(eval "\"\$strata\" $(get 'three & "four"/results.json' cases/1/configurations/2/command | sed 's/^strata //')") >out 2>err
verdict 'its command is quoted'
! grep -qE '(src|href)="?(https?:)?//' 'three & "four"/report.html'
verdict 'nothing is fetched'
[ "$(wc -c <one/report.html)" -lt 4000000 ]
verdict 'the report is small'
finish
