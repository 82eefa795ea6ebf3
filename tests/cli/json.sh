#!/bin/sh
# SPDX-License-Identifier: MIT
#
# What --json and --account write is one JSON object of the guide's shape, and nothing else stands
# on stdout.
. "$(dirname "$0")/lib.sh"

# value NAME FILE PATH WANTED
value() {
    [ "$(get "$2" "$3")" = "$4" ] || echo "  $3 is '$(get "$2" "$3")', not '$4'"
    [ "$(get "$2" "$3")" = "$4" ]
    verdict "$1"
}

run plan scene:layers --json --backend null --size 320x200
mv out plan.json
[ "$status" -eq 0 ] && [ ! -s err ] && "$json_get" plan.json
verdict 'plan is one object'
value 'plan: scene' plan.json scene layers
value 'plan: size' plan.json size '[320,200]'
value 'plan: device' plan.json device/backend null
value 'plan: fact' plan.json facts/materials.blend 1
value 'plan: effect' plan.json effects/0/id over
value 'plan: evidence' plan.json effects/0/evidence '1 material with alphaMode BLEND, 64 triangles'
value 'plan: not called for' plan.json effects/1/called_for false
value 'plan: no evidence' plan.json effects/1/evidence null
value 'plan: capture' plan.json techniques/0/technique abuffer
value 'plan: setting' plan.json techniques/0/settings/mode contiguous
value 'plan: resolve' plan.json techniques/1/technique ppc
value 'plan: record' plan.json fragments/bytes_per_fragment 24
value 'plan: planes' plan.json fragments/planes '[8,8]'
at=0
while [ "$(get plan.json left_out/$at/technique)" != surface ] && [ $at -lt 50 ]; do
    at=$((at + 1))
done
value 'plan: left out' plan.json left_out/$at/technique surface
value 'plan: reason' plan.json left_out/$at/reason 'nothing opaque is drawn'
value 'plan: warnings' plan.json warnings '[]'
for member in estimate/transparent_fragments estimate/largest_depth cost effects/0/reason \
    techniques/0/cost techniques/0/module techniques/0/stage techniques/0/title; do
    [ -n "$(get plan.json $member)" ] && [ "$(get plan.json $member)" != null ]
    verdict "plan has $member"
done

run plan scene:layers --json --backend null --effects none
mv out plan.json
value 'opaque: no fragments' plan.json fragments null
value 'opaque: surface alone' plan.json 'techniques/#' 1
value 'opaque: forced off' plan.json effects/0/forced true
run plan scene:layers --json --backend null --set abuffer.payload=unorm8 --set abuffer.mode=linked
mv out plan.json
value 'linked unorm8: record' plan.json fragments/bytes_per_fragment 20
value 'linked unorm8: planes' plan.json fragments/planes '[4]'

run list --json
mv out list.json
[ "$status" -eq 0 ] && [ ! -s err ] && "$json_get" list.json
verdict 'list is one object'
value 'list: ABI' list.json version 1.0
value 'list: release' list.json release "$(run --version && sed 's/strata //; s/,.*//' out)"
value 'list: sorted modules' list.json modules/0/id abuffer
value 'list: knob' list.json modules/0/techniques/0/knobs/0/name mode
value 'list: choices' list.json modules/0/techniques/0/knobs/0/choices '["contiguous","linked"]'
value 'list: order' list.json modules/0/techniques/0/promises/order exact
value 'list: no rejects' list.json rejected '[]'
[ "$(get list.json 'scenes/#')" -ge 8 ] && [ -n "$(get list.json scenes/0/knobs/0/title)" ]
verdict 'list: scenes'
echo 'not a module' >bad.so
status=0
STRATA_MODULE_PATH=$folder "$strata" list --json >list.json 2>err || status=$?
[ "$status" -eq 0 ] && [ "$(get list.json 'modules/#')" = 0 ] &&
    [ "$(get list.json rejected/0/path)" = "$folder/bad.so" ]
verdict 'list: a file that is no module is rejected, not fatal'
rm bad.so

run render scene:layers -o x.png --backend null --repeat 3 --account account.json
[ "$status" -eq 0 ] && [ ! -s out ] && [ ! -s err ] && "$json_get" account.json
verdict 'account is one object'
value 'account: scene' account.json scene layers
value 'account: plan' account.json plan/0/technique abuffer
value 'account: frames' account.json 'frame_ms/#' 3
value 'account: bound' account.json bound null
for member in passes/0/label passes/0/technique modules_opened/0 bytes/abuffer fragments retries \
    bands device/name effects/0/evidence warnings; do
    get account.json $member >value
    verdict "account has $member"
done
run render scene:layers -o x.png --backend null --account -
"$json_get" out
verdict 'account to stdout'
run render scene:layers -o x.png --backend null --use abuffer --effects none --account account.json
[ "$status" -eq 0 ] && grep -q 'strata: warning: --use abuffer: it does not run' err &&
    [ -n "$(get account.json warnings/0)" ]
verdict 'warnings are said and accounted'
STRATA_LOG=error "$strata" render scene:layers -o x.png --backend null --use abuffer \
    --effects none 2>err && [ ! -s err ]
verdict 'STRATA_LOG=error says no warnings'

run compare x.png x.png --json
[ "$status" -eq 0 ] && [ "$(get out max)" = 0 ] && [ "$(get out psnr)" = null ]
verdict 'compare: equal'

refuse 'a failed plan writes no JSON' 1 'none.gltf' plan none.gltf --json
refuse 'a failed comparison writes no JSON' 1 'none.png' compare none.png none.png --json
finish
