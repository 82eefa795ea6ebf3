#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Hostile surroundings: full disks, folders that nobody may write, caches that cannot be written or
# hold rubbish, interruption at any moment. A failure is status 1 and one line; what was there before
# stays; the cache never changes the picture nor the outcome.
. "$(dirname "$0")/lib.sh"
scene='scene:soup?small=500&medium=30'

# A picture on a full device, through names with the right endings.
if [ -c /dev/full ]; then
    for name in full.png full.exr; do
        ln -s /dev/full $name
        refuse "$name" 1 "$name: " render $scene -o $name --size 64x48 --backend null
    done
    [ -c /dev/full ] && [ -L full.png ]
    verdict 'a device is not replaced'
else
    echo 'skip - full device: there is no /dev/full'
fi
if [ -d /proc/self ]; then
    refuse 'a folder that nobody may write' 1 '/proc/x.png: cannot write' \
        render $scene -o /proc/x.png --backend null
fi

# No file may grow beyond a few KiB: as a full disk, and one that begins to be full half-way.
limited() {
    status=0
    (ulimit -f 8 && exec "$strata" "$@") >out 2>err || status=$?
}
echo old >kept.glb
limited scene soup -o kept.glb
[ "$status" -eq 1 ] && is_line 'kept.glb: ' && [ "$(cat kept.glb)" = old ]
verdict 'scene too large for the disk'

if ! have_device; then
    echo 'skip - caches: no device'
    clean
    verdict 'nothing half-written is left'
    finish
    exit
fi

# The cache: absent, impossible, full, rubbish.
with_cache() {
    name=$1 STRATA_CACHE_DIR=$2
    run render $scene -o got.exr --size 64x48
    [ "$status" -eq 0 ] && [ ! -s err ] && cmp -s first.exr got.exr
    verdict "cache: $name"
}
STRATA_CACHE_DIR=
run render $scene -o first.exr --size 64x48
[ "$status" -eq 0 ] && [ ! -s err ]
verdict 'no cache'
: >file
with_cache 'new' "$folder/new"
[ -n "$(find new -type f)" ]
verdict 'the cache is written'
with_cache 'used' "$folder/new"
with_cache 'under a file' "$folder/file/cache"
with_cache 'is a file' "$folder/file"
with_cache 'where nobody may write' /proc/strata
ln -s /dev/null null.png
STRATA_CACHE_DIR="$folder/full"
limited render $scene -o null.png --size 64x48
[ "$status" -eq 0 ] && [ ! -s err ]
verdict 'cache: on a full disk'
with_cache 'after a full disk' "$folder/full"
spoil() {
    find new -type f | while read -r entry; do
        case $1 in
        empty) : >"$entry" ;;
        short) head -c 100 "$entry" >cut && cp cut "$entry" ;;
        cut) head -c $(($(wc -c <"$entry") - 4)) "$entry" >cut && cp cut "$entry" ;;
        long) echo more >>"$entry" ;;
        rubbish) head -c "$(wc -c <"$entry")" /dev/urandom >cut && cp cut "$entry" ;;
        flipped)
            { head -c $(($(wc -c <"$entry") / 2)) "$entry"; printf 'XXXX'
              tail -c +$(($(wc -c <"$entry") / 2 + 5)) "$entry"; } >cut && cp cut "$entry" ;;
        folder) rm "$entry" && mkdir "$entry" ;;
        esac
    done
    with_cache "entries are $1" "$folder/new"
}
for way in empty short cut long rubbish flipped folder; do spoil $way; done

# Pictures that do not fit, from a device so that there is something to compress.
for suffix in exr png; do
    echo old >kept.$suffix
    limited render $scene -o kept.$suffix --size 800x600
    [ "$status" -eq 1 ] && is_line "kept.$suffix: " && [ "$(cat kept.$suffix)" = old ]
    verdict "$suffix too large for the disk"
done

# Interrupted at any moment: the old picture, or the new one as a whole.
export STRATA_CACHE_DIR="$folder/used"
run render $scene -o whole.exr --size 800x600
[ "$status" -eq 0 ]
verdict 'a picture'
for after in 0.02 0.05 0.1 0.2 0.3 0.4 0.6 0.8; do
    echo old >kept.exr
    status=0
    case $after in 0.[135]) signal=TERM ;; *) signal=INT ;; esac
    # in the foreground, timeout signals the program once; a second signal may end it anywhere
    timeout --foreground --preserve-status -s $signal $after "$strata" render $scene -o kept.exr --size 800x600 \
        >out 2>err || status=$?
    case $status in
    0) cmp -s whole.exr kept.exr ;;
    1) is_line 'strata: stopped' && [ "$(cat kept.exr)" = old ] ;;
    130 | 143) [ "$(cat kept.exr)" = old ] || cmp -s whole.exr kept.exr ;; # caught by nobody yet, or no longer
    *) false ;;
    esac && clean
    verdict "SIG$signal after $after s"
done
clean
verdict 'nothing half-written is left'
finish
