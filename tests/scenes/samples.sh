#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Every glTF 2.0 sample of Debian's package assimp-testmodels, good and broken, on both devices: what
# loads gives the same bits on both, what is broken ends with status 1 and one line that names the
# file and the place. STRATA_SAMPLES: the folder that holds glTF2; STRATA_PICTURES: where to keep
# the pictures, else they are thrown away.
. "$(dirname "$0")/../cli/lib.sh"

for models in "${STRATA_SAMPLES:-}" /usr/share/assimp/models /usr/share/assimp/test/models; do
    [ -n "$models" ] && [ -d "$models/glTF2" ] && break
    models=
done
if [ -z "$models" ]; then
    echo 'skip - samples: neither STRATA_SAMPLES nor the package assimp-testmodels'
    exit 0
fi
backends=null
for backend in vulkan gl; do
    run render scene:layers -o probe.exr --size 4x4 --backend $backend
    if [ "$status" -eq 0 ]; then
        backends="$backends $backend"
    else
        echo "skip - $backend: $(head -n 1 err)"
    fi
done

# What must be refused, and what the line says of the place.
refused='BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf extensionsRequired[0]:
BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb meshes[0]
IndexOutOfRange/AllIndicesOutOfRange.gltf indices[0]
IndexOutOfRange/IndexOutOfRange.gltf indices[0]
MissingBin/BoxTextured.gltf buffers[0].uri:
RecursiveNodes/RecursiveNodes.gltf nodes[0]:
SchemaFailures/sceneWrongType.gltf scene:
TestNoRootNode/NoScene.gltf scene:
draco/2CylinderEngine.gltf extensionsRequired[0]:
wrongTypes/badArray.gltf meshes[0].primitives:
wrongTypes/badExtension.gltf KHR_texture_transform:
wrongTypes/badNumber.gltf normalTexture.scale:
wrongTypes/badObject.gltf pbrMetallicRoughness:
wrongTypes/badUint.gltf baseColorTexture.index:'

place_of() { echo "$refused" | sed -n "s|^$1 ||p"; }

# sample FILE BACKEND: renders it to BACKEND.exr; a crash or a hang is a status of more than 3.
sample() {
    status=0
    timeout 120 "$strata" render "$models/glTF2/$1" -o "$2.exr" --size 160x120 --backend "$2" \
        --account "$2.json" >out 2>err || status=$?
}

# Every line on stderr is a warning, which the account has too.
only_warnings() {
    [ "$(wc -l <err)" -eq "$(get "$1" 'warnings/#')" ] &&
        [ "$(wc -l <err)" -eq "$(grep -c '^strata: warning: ' err)" ]
}

rendered=0 refusals=0
check_sample() {
    place=$(place_of "$1")
    rm -f ./*.exr ./*.json
    for backend in $backends; do
        sample "$1" "$backend"
        if [ -n "$place" ]; then
            [ "$status" -eq 1 ] && is_line "$models/glTF2/$1: " && is_line "$place" &&
                [ ! -e "$backend.exr" ]
        else
            [ "$status" -eq 0 ] && [ -s "$backend.exr" ] && only_warnings "$backend.json"
        fi || { fail "$1 on $backend"; return; }
    done
    if [ -n "$place" ]; then
        refusals=$((refusals + 1))
        echo "  refused: $(cut -d' ' -f2- err | sed "s|^$models/||")"
    else
        rendered=$((rendered + 1))
    fi
    if [ -s vulkan.exr ] && [ -s gl.exr ] && ! cmp vulkan.exr gl.exr >out 2>err; then
        fail "$1: Vulkan and OpenGL differ"
    else
        pass "$1"
    fi
    for backend in $backends; do
        [ -z "${STRATA_PICTURES:-}" ] || [ ! -s "$backend.exr" ] ||
            cp "$backend.exr" "$STRATA_PICTURES/$(echo "$1" | tr / _).$backend.exr"
    done
}

(cd "$models/glTF2" && find . -name '*.gltf' -o -name '*.glb') | sed 's|^\./||' | sort >files
while read -r file; do
    check_sample "$file" </dev/null
done <files
[ "$refusals" -eq "$(echo "$refused" | wc -l)" ]
verdict "$rendered rendered on $backends, $refusals refused"

# The first version of glTF is another format.
find "$models/glTF" -name '*.gltf' -o -name '*.glb' 2>/dev/null | sort >files
while read -r file; do
    refuse "glTF 1: $(basename "$file")" 1 "$file: " render "$file" -o x.exr --backend null
done <files
clean
verdict 'nothing half-written is left'
finish
