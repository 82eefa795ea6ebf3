#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Modules that break a rule of the calls between them and the host (tests/modules/flawed): each is named
# in one line, nothing else of the render fails for it, and errors that a module handled are forgotten.
. "$(dirname "$0")/lib.sh"
export STRATA_MODULE_PATH="$STRATA_MODULE_PATH:$STRATA_TEST_BUILD/tests/modules/flawed"

if ! have_device; then
    echo "skip - rules: no device that draws"
    exit 0
fi
set -- render 'scene:layers?count=12' --size 16x16

refuse 'a pass outside of record()' 1 'flawed: a pass outside of record()' "$@" --use flawed \
    --set flawed.breaks=record -o out.exr
refuse 'who retries for ever is named' 1 'recorded 64 times in vain, at last for flawed' "$@" --use flawed \
    --set flawed.breaks=retry -o out.exr
refuse 'a capture without fragments' 1 'silent: prepare: it published no fragments/1' "$@" --use silent -o out.exr
run "$@" --use flawed --set flawed.breaks=memory -o out.exr --account account.json
[ "$status" -eq 0 ] && [ ! -s err ] && [ "$(get account.json bands)" -gt 1 ]
verdict 'what a technique returns decides, not an error that it handled'
finish
