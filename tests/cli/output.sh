#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Pictures and scenes that are written: kinds, equality where it is promised, interruption.
. "$(dirname "$0")/lib.sh"

# render NAME FILE ARGUMENTS: done, in silence.
render() {
    name=$1 file=$2
    shift 2
    run render "$@" -o "$file"
    [ "$status" -eq 0 ] && [ ! -s out ] && [ ! -s err ] && [ -s "$file" ]
    verdict "$name"
}
same() { cmp -s "$2" "$3"; verdict "$1"; }
starts() { [ "$(head -c "${#3}" "$2" | tr -d '\0')" = "$3" ]; verdict "$1"; }

run scene layers -o layers.glb --set count=5
[ "$status" -eq 0 ] && [ ! -s out ] && [ ! -s err ]
verdict 'scene'
starts 'scene is GLB' layers.glb glTF
run scene layers -o again.glb --set count=5
same 'scene is reproducible' layers.glb again.glb

# One frame is far shorter than the second that passes before the signal. Without --foreground the
# program would be sent two: once itself and once with its group.
run_interrupted() {
    status=0
    timeout --foreground --preserve-status -s INT 1 "$strata" "$@" >out 2>err || status=$?
}
echo old >kept.png
run_interrupted render scene:layers -o kept.png --backend null --repeat 1000000 --account a.json
[ "$status" -eq 1 ] && is_line 'strata: stopped' && [ "$(cat kept.png)" = old ] && [ ! -e a.json ]
verdict 'SIGINT stops and leaves the old file'

if ! have_device; then
    echo 'skip - pictures: no device'
    clean
    verdict 'nothing half-written is left'
    finish
    exit
fi
render 'PNG' a.png layers.glb --size 64x48
[ "$(head -c 4 a.png | tail -c 3)" = PNG ]
verdict 'PNG begins as one'
render 'EXR' a.exr layers.glb --size 64x48
render 'again' b.exr layers.glb --size 64x48
same 'twice the same bits' a.exr b.exr
render 'generated in memory' b.exr 'scene:layers?count=5' --size 64x48
same 'a written scene renders as in memory' a.exr b.exr
render 'seven bands' b.exr layers.glb --size 64x48 --set frame.bands=7
same 'bands do not show' a.exr b.exr
render 'shuffled' b.exr layers.glb --size 64x48 --set frame.shuffle=9
same 'order of submission does not show' a.exr b.exr
render 'linked' b.exr layers.glb --size 64x48 --set abuffer.mode=linked
same 'linked equals contiguous' a.exr b.exr
render 'several frames' b.exr layers.glb --size 64x48 --repeat 3
same 'the last frame is the picture' a.exr b.exr
render 'background' b.exr layers.glb --size 64x48 --background 1,0,0
run compare a.exr b.exr --json
[ "$status" -eq 0 ] && [ "$(get out differing)" -gt 0 ]
verdict 'a background shows'
render 'camera' b.exr layers.glb --size 64x48 --camera orbit:30,20
run compare a.exr b.exr --json --heat heat.png
[ "$status" -eq 0 ] && [ "$(get out differing)" -gt 0 ] && [ -s heat.png ]
verdict 'a camera shows; heat map'
render 'deep' b.exr layers.glb --size 64x48 --deep deep.exr
same 'deep does not change the picture' a.exr b.exr
[ -s deep.exr ]
verdict 'deep is written'
render 'one pixel' one.png layers.glb --size 1x1
run compare a.exr one.png
[ "$status" -eq 1 ] && is_line '64 x 48 and 1 x 1'
verdict 'pictures of two sizes are not compared'
for backend in vulkan gl; do
    run render layers.glb -o "$backend.exr" --size 64x48 --backend $backend
done
if [ -s vulkan.exr ] && [ -s gl.exr ]; then
    same 'Vulkan and OpenGL agree' vulkan.exr gl.exr
else
    echo 'skip - Vulkan and OpenGL agree: one of them has no device'
fi
refuse 'unknown device' 1 'nowhere' render layers.glb -o x.png --device nowhere
clean
verdict 'nothing half-written is left'
finish
