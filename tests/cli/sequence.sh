#!/bin/sh
# SPDX-License-Identifier: MIT
#
# strata render --frames: names with a number, paths, time, the account of all frames; that history
# is kept and does not show; refusals before anything is written.
. "$(dirname "$0")/lib.sh"
scene='scene:layers?count=3'

cat >path.json <<'END'
{"keys": [{"time": 0, "camera": "orbit:0,0"},
          {"time": 1, "eye": [1, 0.5, 2], "target": [0, 0, 0]},
          {"time": 2, "eye": [-2, 0, 1], "target": [0, 0, 0], "cut": true}]}
END
sed 's/\[-2, 0, 1\]/[-2, 0, "1"]/' path.json >wrong.json
echo '{"keys":[{"time":0,"eye":[0,0,1],"target":[0,0,-1]},{"time":1,"eye":[0,0,-1],"target":[0,0,1]}]}' \
    >meets.json

for name in '%s' '%' '%4d' '%0d' '%00d' '%-4d' '%04x' '%ld' '%d%d' '%d/x' '%010d'; do
    refuse "name '$name'" 2 '%d or %0Nd' render $scene -o "f$name.exr" --frames 2 --backend null
done
refuse 'deep with two numbers' 2 '--deep' render $scene -o x.exr --deep '%d%d.exr' --frames 2
refuse 'the same numbered names' 2 'same file' render $scene -o 'f%d.exr' --deep 'f%01d.exr' --frames 2
refuse 'one name is a number of the other' 2 'same file' \
    render $scene -o 'f%d.exr' --deep 'f3.exr' --frames 4
while IFS='|' read -r color deep frames same; do
    refuse "$color and $deep, $frames frames" 2 "-o and --deep name the same file, $same" \
        render $scene -o "$color" --deep "$deep" --frames "$frames" --backend null
done <<'END'
a%d.exr|a1%d.exr|12|a10.exr
a1%d.exr|a%d.exr|11|a10.exr
a%d.exr|a%d0.exr|11|a10.exr
a%d1.exr|a1%d.exr|2|a11.exr
a0%d.exr|a%02d.exr|1|a00.exr
a%02d.exr|a1%d.exr|11|a10.exr
a%d.exr|a7.exr|8|a7.exr
END
for count in 0 -1 1.5 x '' 100001; do
    refuse "frames '$count'" 2 'whole number' render $scene -o x.png --frames "$count"
done
for fps in 0 -1 nan inf x ''; do
    refuse "fps '$fps'" 2 'frames a second' render $scene -o x.png --frames 2 --fps "$fps"
done
for turns in '' x nan 1001 1,2; do
    refuse "turns '$turns'" 2 'orbit:TURNS' render $scene -o x.png --frames 2 --path "orbit:$turns"
done
refuse 'a path without frames' 2 'goes with --frames' render $scene -o x.png --path orbit
refuse 'fps without frames' 2 'goes with --frames' render $scene -o x.png --fps 25
refuse 'frames and repeat' 2 'does not go with --repeat' render $scene -o x.png --frames 2 --repeat 2
refuse 'frames and turn' 2 'frame.turn' render $scene -o x.png --frames 2 --set frame.turn=3
refuse 'a path and a camera' 2 '--camera does not go' \
    render $scene -o x.png --frames 2 --path path.json --camera 0
refuse 'no path' 1 'none.json: ' render $scene -o 'f%d.png' --frames 2 --path none.json --backend null
refuse 'a wrong path' 1 'wrong.json: key 2: eye: ' \
    render $scene -o 'f%d.png' --frames 2 --path wrong.json --backend null
refuse 'the eye meets its target' 1 'meets.json: in frame 2 ' \
    render $scene -o 'f%d.png' --frames 5 --path meets.json --backend null
refuse 'numbered in no folder' 1 'no/f0.png: cannot write' \
    render $scene -o 'no/f%d.png' --frames 2 --backend null
[ -z "$(find . -name '*.png' -o -name '*.exr')" ]
verdict 'what is refused writes nothing'

run render $scene -o '%%%02d%%.png' --frames 3 --size 8x8 --backend null
[ "$status" -eq 0 ] && [ ! -s err ] && [ -s %00%.png ] && [ -s %02%.png ] && [ ! -e %03%.png ]
verdict 'percent signs and zeros'
run render $scene -o '%d.png' --size 8x8 --backend null
[ "$status" -eq 0 ] && [ -s %d.png ]
verdict 'one picture is named as it says'
mkdir apart
while IFS='|' read -r color deep frames; do
    run render $scene -o "apart/$color" --deep "apart/$deep" --frames "$frames" --size 4x4 --backend null
    [ "$status" -eq 0 ] && [ "$(find apart -name '*.exr' | wc -l)" -eq $((2 * frames)) ]
    verdict "$color and $deep, $frames frames, are apart"
    rm -f apart/*
done <<'END'
a%d.exr|a1%d.exr|10
a%d.exr|a%d0.exr|10
a%d.exr|a%02d.exr|10
a%d.exr|b%d.exr|2
END
run render $scene -o last.png --frames 3 --size 8x8 --backend null
[ "$status" -eq 0 ] && [ "$(find . -name 'last*')" = ./last.png ]
verdict 'without a number: the last alone'

# The plan goes by the camera: from the side these layers are peeled, from the front captured.
run render $scene -o x.png --size 64x48 --backend null --frames 4 --camera orbit:0,0 --path orbit \
    --account account.json
[ "$status" -eq 0 ] && [ ! -s out ] && [ ! -s err ] && "$json_get" account.json
verdict 'account is one object'
[ "$(get account.json frames/#)" = 4 ] && [ "$(get account.json frame_ms/#)" = 4 ] &&
    [ "$(get account.json frames/0/prepared)" -gt 0 ] &&
    [ "$(get account.json plan/0/technique)" = abuffer ]
verdict 'every frame is accounted'
for frame in 1 2 3; do
    [ "$(get account.json frames/$frame/prepared)" = 0 ] &&
        [ -n "$(get account.json frames/$frame/passes/0/label)" ] &&
        [ "$(get account.json frames/$frame/ms)" = "$(get account.json frame_ms/$frame)" ]
    verdict "frame $frame prepares nothing anew"
done
[ "$(get account.json frames/2/file)" = null ] && [ "$(get account.json frames/3/file)" = x.png ]
verdict 'files are those of the frames'
run render $scene -o x.png --size 8x8 --backend null --frames 3 --use surface --account -
grep -c warning: err >count
[ "$status" -ne 0 ] || [ "$(cat count)" -le 1 ]
verdict 'a warning is said once'

echo old >kept.png
status=0
timeout --foreground --preserve-status -s INT 1 "$strata" render scene:shells -o kept.png --backend null \
    --frames 100000 --path orbit --account a.json >out 2>err || status=$?
[ "$status" -eq 1 ] && is_line 'strata: stopped' && [ "$(cat kept.png)" = old ] && [ ! -e a.json ]
verdict 'SIGINT stops between frames'

if ! have_device; then
    echo 'skip - pictures: no device'
    finish
    exit
fi
for backend in vulkan gl; do
    run render $scene -o "$backend%d.exr" --size 64x48 --backend $backend --frames 5 --path path.json \
        --use abuffer,ppc --account $backend.json
    [ "$status" -eq 0 ] && [ ! -s err ] && [ -s "${backend}4.exr" ]
    verdict "$backend: a path"
    # frames 0, 2 and 4 stand at the keys; 3 stands before the cut
    for frame in 1 2 4; do
        run compare "${backend}0.exr" "$backend$frame.exr" --json
        [ "$(get out differing)" -gt 0 ]
        verdict "$backend: frame $frame shows another view"
    done
    cmp -s "${backend}2.exr" "${backend}3.exr"
    verdict "$backend: before a cut the camera stands"
    sed '2d; s/"time": 0, "camera": "orbit:0,0"/"time": 0, "eye": [-2, 0, 1], "target": [0, 0, 0]/' \
        path.json | sed 's/, "cut": true//' >alone.json
    run render $scene -o "$backend-alone.exr" --size 64x48 --backend $backend --frames 1 \
        --path alone.json --use abuffer,ppc
    [ "$status" -eq 0 ] && cmp -s "${backend}4.exr" "$backend-alone.exr"
    verdict "$backend: after four others a frame is what it is alone"
done
if [ -s vulkan4.exr ] && [ -s gl4.exr ]; then
    for frame in 0 1 4; do
        cmp -s vulkan$frame.exr gl$frame.exr
        verdict "frame $frame: Vulkan and OpenGL agree"
    done
fi
# A triangle that moves from x = 0 to 1 in a second.
zero='\0\0\0\0' one='\0\0\200\077' minus='\0\0\200\277'
bytes=$(printf "$minus$minus$zero$one$minus$zero$zero$one$zero$zero$one$zero$zero$zero$one$zero$zero" |
    base64 -w0)
cat >moves.gltf <<END
{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"materials":[{"doubleSided":true,"alphaMode":"BLEND","extensions":{"KHR_materials_unlit":{}}}],
"extensionsUsed":["KHR_materials_unlit"],
"animations":[{"samplers":[{"input":1,"output":2}],
"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},
{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":8},
{"buffer":0,"byteOffset":44,"byteLength":24}],
"buffers":[{"byteLength":68,"uri":"data:application/octet-stream;base64,$bytes"}]}
END
echo '{"keys":[{"time":0,"eye":[0.5,0,4],"target":[0.5,0,0]}]}' >stand.json
run render moves.gltf -o m%d.exr --size 64x48 --frames 5 --fps 4 --time 0.25 --path stand.json \
    --account m.json
[ "$status" -eq 0 ] && [ ! -s err ] && [ "$(get m.json frames/2/prepared)" = 0 ]
verdict 'a scene that moves prepares nothing anew'
for frame in 0 1 3 4; do
    time=$(echo 0.25 0.5 0.75 1 1.25 | cut -d' ' -f$((frame + 1)))
    run render moves.gltf -o alone.exr --size 64x48 --frames 1 --time $time --path stand.json
    [ "$status" -eq 0 ] && cmp -s m$frame.exr alone.exr && { [ $frame -eq 1 ] || ! cmp -s m1.exr m$frame.exr; }
    verdict "frame $frame stands at $time s"
done
cmp -s m3.exr m4.exr
verdict 'beyond the last key it stands'
run render moves.gltf -o s%d.exr --size 64x48 --frames 2 --time 0.5 --path stand.json
cmp -s s0.exr m1.exr && cmp -s s1.exr m1.exr
verdict 'without --fps the scene stands'
run render $scene -o o%d.exr --size 64x48 --frames 4 --path orbit:-2
run render $scene -o p%d.exr --size 64x48 --frames 2 --path orbit
[ "$status" -eq 0 ] && cmp -s o0.exr p0.exr && cmp -s o0.exr o2.exr && cmp -s o1.exr p1.exr
verdict 'turns go round'
run render $scene -o t%d.exr --size 64x48 --frames 2 --deep d%d.exr
[ "$status" -eq 0 ] && [ -s d0.exr ] && [ -s d1.exr ] && cmp -s t0.exr t1.exr
verdict 'numbered fragments'
clean
verdict 'nothing half-written is left'
finish
