#!/bin/sh
# SPDX-License-Identifier: MIT
#
# --budget and --learn: budgets that any machine meets, and such as none does; what is turned on the
# way gives the same picture as when it is set; what was learnt is said, and can be forgotten.
. "$(dirname "$0")/lib.sh"
scene='scene:shells?count=6&subdivision=2'
STRATA_CACHE_DIR=$folder/cache
export STRATA_CACHE_DIR

for ms in 0 -1 x nan inf 1e10 ''; do
    refuse "budget '$ms'" 2 'milliseconds' render $scene -o x.png --budget "$ms"
done
have_device || { echo 'ok - # SKIP no device'; finish; exit; }
size='--size 48x32'

run render $scene $size -o exact.exr --account exact.json
[ "$status" -eq 0 ] && [ "$(get exact.json budget)" = null ]
verdict 'no budget, none accounted'

run render $scene $size -o met.exr --repeat 4 --budget 1e9 --account met.json
[ "$status" -eq 0 ] && [ ! -s err ] && [ "$(get met.json budget/met)" = true ] &&
    [ "$(get met.json budget/knob)" = null ] && [ "$(get met.json budget/frames/#)" = 4 ] &&
    [ "$(get met.json budget/frames/0/judged)" = false ] &&
    [ "$(get met.json budget/frames/3/judged)" = true ] && cmp -s exact.exr met.exr
verdict 'a budget that is met takes the exact way'

run render $scene $size -o missed.exr --repeat 8 --budget 0.001 --account missed.json
[ "$status" -eq 0 ] && grep -qF 'the budget of 0.001 ms is missed' err &&
    [ "$(get missed.json budget/met)" = false ] && [ "$(get missed.json budget/frames/#)" = 8 ] &&
    [ "$(get missed.json frame_ms/#)" = 8 ]
verdict 'one that is missed is a warning'
last=$(get missed.json budget/frames/7/plan)
[ "$(get missed.json budget/frames/0/plan)" = 0 ] && [ "$last" -gt 0 ] &&
    [ "$(get missed.json 'budget/plans/#')" = $((last + 1)) ] &&
    [ "$(get missed.json budget/plans/0)" != "$(get missed.json budget/plans/$last)" ] &&
    name=$(get missed.json "budget/plans/$last") &&
    for i in 0 1 2; do get missed.json plan/$i/technique; done | grep -qx "${name%% *}"
verdict 'its plans are told'

run render scene:soup $size -o deep.exr --use abuffer,ppc --account deep.json
run render scene:soup $size -o deeper.exr --repeat 4 --budget 0.001 --account deeper.json
estimated=$(run plan scene:soup $size --json && get out estimate/largest_depth)
reported=$(get deep.json fragments/max_per_pixel)
[ "${estimated%.*}" -lt "$reported" ] && [ "$(get deeper.json budget/depth)" = "$reported" ]
verdict "another plan goes by the depth that frames had: $reported, not $estimated"

run render $scene $size -o turned.exr --repeat 12 --use kplus,ppc --budget 0.001 --account turned.json
k=$(get turned.json plan/1/settings/k)
[ "$status" -eq 0 ] && [ "$k" = 1 ] && [ "$(get turned.json budget/knob)" = k ] &&
    run render $scene $size -o set.exr --use kplus,ppc --set kplus.k=$k && cmp -s turned.exr set.exr
verdict 'what is turned is as if it were set'

run render $scene $size -o frame.exr --frames 12 --use kplus,ppc --budget 0.001 --account frames.json
[ "$status" -eq 0 ] && [ "$(get frames.json plan/1/settings/k)" = 1 ] && cmp -s turned.exr frame.exr &&
    [ "$(get frames.json budget/frames/#)" = 12 ] && [ "$(get frames.json frames/11/prepared)" = 0 ]
verdict 'the same over the frames of a sequence, which then prepare no more'
run render $scene $size -o short.exr --frames 3 --budget 0.001 --use abuffer,ppc --account short.json
[ "$status" -eq 0 ] && [ "$(grep -cF 'the budget of 0.001 ms is missed' err)" = 1 ] &&
    get short.json warnings | grep -qF 'the budget of 0.001 ms is missed'
verdict 'a sequence that ends over its budget says so'

run render $scene $size -o set2.exr --repeat 6 --use kplus,ppc --set kplus.k=3 --budget 0.001 \
    --account set2.json
[ "$status" -eq 0 ] && [ "$(get set2.json plan/1/settings/k)" = 3 ]
verdict 'what is set is not turned'

run render $scene $size -o both.exr --repeat 3 --tolerance 0.5 --budget 0.001 --account both.json
[ "$status" -eq 0 ] && [ "$(get both.json tolerance/certified)" = true ] &&
    [ "$(get both.json budget/met)" = false ] && grep -q 'is missed' err
verdict 'a tolerance comes first'

run render 'scene:stack?count=20' --camera orbit:90,0 $size -o turn.exr --repeat 10 --budget 1e9 --use abuffer,ppc \
    --set frame.turn=2 --account turn.json
i=1 doubted=0 wrong=0
while [ $i -lt 10 ]; do
    before=$(get turn.json frames/$((i - 1))/retries) now=$(get turn.json frames/$i/retries) said=true
    after=$(get turn.json frames/$((i - 1))/prepared)
    [ "$after" = 0 ] || before=0 # it says nothing
    if [ "$(get turn.json frames/$i/prepared)" != 0 ] || [ "$after" != 0 ]; then
        said=false
    elif [ "$now" -gt 0 ] && [ "$before" -eq 0 ]; then
        said=false doubted=1
    fi
    [ "$(get turn.json budget/frames/$i/judged)" = $said ] || wrong=1
    i=$((i + 1))
done
[ "$status" -eq 0 ] && [ $doubted = 1 ] && [ $wrong = 0 ]
verdict 'a frame that was recorded again is not judged, unless the next one is, too, nor one after it prepared'

run render scene:soup --size 160x120 -o soup.exr --repeat 16 --use abuffer,ppc --set frame.turn=1 \
    --account soup.json
i=1 again=0
while [ $i -lt 16 ]; do
    [ "$(get soup.json frames/$i/retries)" = 0 ] || again=$((again + 1))
    i=$((i + 1))
done
[ "$status" -eq 0 ] && [ $again -le 3 ]
verdict "what moves has a reserve: $again of 15 frames are recorded again"

run plan $scene $size --json
cp out before.json
run render $scene $size -o x.png --repeat 3 --learn
learnt=$(ls "$STRATA_CACHE_DIR"/costs/*.json 2>/dev/null)
if [ "$(get before.json measured_on)" = null ] && [ -s "$learnt" ] && clean; then
    run plan $scene $size --json
    [ "$(get out measured_on)" != null ] && [ "$(get out ms)" != null ] &&
        [ "$(get out techniques/1/points)" = 1 ] && [ "$(get out techniques/0/points)" = 1 ]
    verdict 'what was learnt is said'
    run render $scene $size -o x.png --repeat 3 --learn --use abuffer,ppc --set abuffer.payload=half
    grep -q '"abuffer.half"' "$learnt" && grep -q '"ppc.half"' "$learnt" && grep -q '"abuffer"' "$learnt"
    verdict 'records of less precision are learnt apart'
    run render $scene $size -o x.png --repeat 3 --learn --use occupancy,kplus,ppc --set occupancy.buckets=64
    run render $scene $size -o x.png --repeat 3 --learn --use kplus,ppc
    grep -q '"kplus"' "$learnt" && ! grep -q clipped "$learnt" &&
        run render $scene $size -o x.png --repeat 3 --learn --use occupancy,kplus,ppc &&
        grep -q '"kplus.clipped"' "$learnt"
    verdict 'what a clip technique leaves is learnt apart, as it usually does'
    echo '{"format":3,"device":7}' >"$learnt"
    run plan $scene $size --json
    [ "$status" -eq 0 ] && is_line 'is ignored' && [ "$(get out measured_on)" = null ]
    verdict 'a damaged file is ignored, with a line'
    rm -r "$STRATA_CACHE_DIR/costs"
    run plan $scene $size --json
    [ "$status" -eq 0 ] && [ ! -s err ] && cmp -s out before.json
    verdict 'what was learnt can be forgotten'
else
    fail 'learning'
fi
finish
