#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Files that are missing, wrong or cannot be written: status 1 and one line that names the file; what
# stood under a name before stays as it was, and nothing half-written is left.
. "$(dirname "$0")/lib.sh"

mkdir dir
: >empty.gltf
: >empty.glb
echo '{"asset":{"version":"2.0"}' >cut.gltf
echo 'not a scene' >text.glb
printf 'glTF\002\000\000\000\377\377\377\377' >lying.glb
printf '\211PNG\r\n\032\n' >cut.png

for verb in plan 'render -o x.png'; do
    # shellcheck disable=SC2086 # a verb with its options
    {
        refuse "$verb: missing" 1 'none.gltf: ' $verb none.gltf
        refuse "$verb: missing folder" 1 'no/where.glb: ' $verb no/where.glb
        refuse "$verb: a folder" 1 'dir' $verb dir
        refuse "$verb: empty glTF" 1 'empty.gltf: ' $verb empty.gltf
        refuse "$verb: empty GLB" 1 'empty.glb: ' $verb empty.glb
        refuse "$verb: cut JSON" 1 'cut.gltf: ' $verb cut.gltf
        refuse "$verb: text" 1 'text.glb: ' $verb text.glb
        refuse "$verb: lying length" 1 'lying.glb: ' $verb lying.glb
    }
done
name=$(printf 'a\033[31m\nb.gltf')
refuse 'control characters in a name' 1 'a?[31m?b.gltf' plan "$name"
[ ! -e x.png ]
verdict 'no picture of a scene that cannot be read'

refuse 'compare: missing' 1 'none.png: ' compare none.png none.png
refuse 'compare: cut' 1 'cut.png: ' compare cut.png cut.png
refuse 'compare: wrong kind' 1 'text.glb' compare text.glb text.glb

# outputs, said before any work
refuse 'output in no folder' 1 'no/x.png: cannot write' render scene:layers -o no/x.png
refuse 'output over a folder' 1 'dir.png: cannot write' render scene:layers -o "$(mkdir dir.png; echo dir.png)"
refuse 'deep in no folder' 1 'no/d.exr: cannot write' render scene:layers -o x.png --deep no/d.exr
refuse 'account in no folder' 1 'no/a.json: cannot write' render scene:layers -o x.png --account no/a.json
refuse 'scene in no folder' 1 'no/x.glb: cannot write' scene layers -o no/x.glb
[ ! -e x.png ]
verdict 'no picture when another output cannot be written'
if [ "$(id -u)" -ne 0 ]; then
    mkdir closed && chmod a-w closed
    refuse 'output in a closed folder' 1 'closed/x.png: ' render scene:layers -o closed/x.png
else
    echo 'skip - output in a closed folder: root may write anywhere'
fi

# a failure leaves the old file
echo old >kept.png
refuse 'picture of a broken scene' 1 'cut.gltf: ' render cut.gltf -o kept.png
[ "$(cat kept.png)" = old ]
verdict 'the old picture is kept'

if [ -c /dev/full ]; then
    refuse 'account to a full device' 1 '/dev/full: cannot write' \
        render scene:layers -o x.png --backend null --account /dev/full
    for command in list 'plan scene:layers' '--help'; do
        status=0
        # shellcheck disable=SC2086
        "$strata" $command >/dev/full 2>err || status=$?
        : >out
        [ "$command" = --help ] || { [ "$status" -eq 1 ] && is_line 'standard output'; }
        verdict "$command to a full device"
    done
else
    echo 'skip - full device: there is no /dev/full'
fi
clean
verdict 'nothing half-written is left'
finish
