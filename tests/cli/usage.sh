#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Bad usage ends with status 2 and says what is expected; help goes to stdout with status 0.
. "$(dirname "$0")/lib.sh"

refuse 'no command' 2 'a command is missing'
refuse 'unknown command' 2 'render, plan, list, compare, sweep and scene' frobnicate
refuse 'unknown option' 2 "unrecognized option '--frob'" render --frob
refuse 'unknown option before the command' 2 "unrecognized option '--frob'" --frob render
refuse 'option without a value' 2 'requires an argument' render scene:layers -o

refuse 'render without a scene' 2 'SCENE is missing' render -o x.png
refuse 'render without -o' 2 '-o is missing' render scene:layers
refuse 'render two scenes' 2 'one scene at a time' render a.gltf b.gltf -o x.png
refuse 'picture of unknown kind' 2 '.png or .exr' render scene:layers -o x.jpg
refuse 'a suffix is not a name' 2 '.png or .exr' render scene:layers -o .png
refuse 'deep is EXR' 2 '.exr' render scene:layers -o x.png --deep d.png
refuse 'deep over the picture' 2 'same file' render scene:layers -o x.exr --deep x.exr
refuse 'account over the picture' 2 'same file' render scene:layers -o x.exr --account x.exr
refuse 'bound over the picture' 2 'same file' render scene:layers -o x.exr --bound x.exr
refuse 'bound as png' 2 'ends in .exr' render scene:layers -o x.exr --bound b.png
refuse 'a negative tolerance' 2 'tolerance' render scene:layers -o x.exr --tolerance -1

for size in 0x5 5x0 5 5x 5x5x5 -5x5 5X5 ' 5x5' 70000x5 99999999999999999999x5 0x10x5 1e2x5; do
    refuse "size '$size'" 2 'expected WxH' render scene:layers -o x.png --size "$size"
done
for color in 1,2 1,2,3,4 a,b,c -1,0,0 nan,0,0 inf,0,0 '' 1,,2; do
    refuse "background '$color'" 2 'expected R,G,B' render scene:layers -o x.png --background "$color"
done
for count in 0 -1 1.5 x '' 1000001; do
    refuse "repeat '$count'" 2 'whole number' render scene:layers -o x.png --repeat "$count"
done
for bytes in 0 -1 x K 1.5M 1T 99999999999999999999 18446744073709551615K; do
    refuse "memory '$bytes'" 2 'expected bytes' plan scene:layers --memory "$bytes"
done
for seconds in x nan inf 1e99 '' 1s; do
    refuse "time '$seconds'" 2 'expected seconds' plan scene:layers --time "$seconds"
done
for samples in 0 2 8 1089 -4 4.0 x ''; do
    refuse "samples '$samples'" 2 'one of 1, 4, 9' plan scene:layers --samples "$samples"
done
refuse 'filter' 2 'box, tent or gaussian' plan scene:layers --filter lanczos
refuse 'deep of sub-pixels' 2 'one sample a pixel' render scene:layers -o x.png --deep x.exr \
    --samples 4
refuse 'backend' 2 'vulkan, gl or null' plan scene:layers --backend metal
refuse 'list takes nothing' 2 'takes no arguments' list modules
refuse 'compare one' 2 'two pictures' compare a.png
refuse 'compare three' 2 'two pictures' compare a.png b.png c.png
refuse 'heat is PNG' 2 '.png' compare a.png b.png --heat h.exr
refuse 'scene without a name' 2 'NAME is missing' scene -o x.glb
refuse 'scene without -o' 2 '-o is missing' scene layers
refuse 'scene is GLB' 2 '.glb' scene layers -o x.gltf
refuse 'scene knob' 2 'expected K=V' scene layers -o x.glb --set count
[ -z "$(find . -name 'x.*')" ]
verdict 'bad usage writes nothing'

# what only the plan knows
refuse 'unknown technique' 2 "did you mean 'abuffer'" plan scene:layers --use abufer
refuse 'unknown effect' 2 "did you mean 'over'" plan scene:layers --effects ovr
refuse 'unknown knob' 2 'its knobs: mode, payload' plan scene:layers --set abuffer.depth=1
refuse 'unknown choice' 2 'contiguous, linked' plan scene:layers --set abuffer.mode=tree
refuse 'setting of no technique' 2 'there is no technique' render scene:layers -o x.png --set a.b=1
for setting in abuffer abuffer.mode =1 .=1 abuffer=1; do
    refuse "setting '$setting'" 2 'expected ID.KNOB=VALUE' plan scene:layers --set "$setting"
done
refuse 'bands' 2 'whole number from 1' plan scene:layers --set frame.bands=0
refuse 'knob of the frame' 2 'bands, shuffle and turn' plan scene:layers --set frame.size=1
refuse 'scene of unknown name' 1 'layers' scene lairs -o x.glb
refuse 'scene with an unknown knob' 2 'count=' scene layers -o x.glb --set n=1
refuse 'scene with a knob out of range' 2 'count' scene layers -o x.glb --set count=-1
refuse 'scene:NAME of unknown name' 1 'layers' plan scene:lairs
refuse 'hard:NAME of unknown name' 1 'strata list' plan hard:lairs
refuse 'hard:NAME with a knob' 2 'no knobs' plan 'hard:layers-1?count=2'
refuse 'hard:NAME that is refused' 1 "mesh 'broken'" plan hard:not-a-number
refuse 'scene:NAME with an unknown knob' 2 'count=' plan 'scene:layers?n=1'
refuse 'unknown camera' 1 'no camera' plan scene:layers --camera nowhere

for verb in '' render plan list compare sweep scene; do
    # shellcheck disable=SC2086 # an empty verb is no argument
    run $verb --help
    [ "$status" -eq 0 ] && [ ! -s err ] && grep -q 'Usage: strata' out
    verdict "help of '$verb'"
done
run --version
[ "$status" -eq 0 ] && [ ! -s err ] && grep -Eqx 'strata [0-9]+\.[0-9]+\.[0-9]+, host ABI [0-9]+\.[0-9]+' out
verdict 'version'
finish
