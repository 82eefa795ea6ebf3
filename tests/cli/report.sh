#!/bin/sh
# SPDX-License-Identifier: MIT
#
# The report of a sweep in a real browser, 1280 and 400 pixels wide, and what it is where Strata was
# built without the library that draws plots. Needs Chromium and node. STRATA_TEST_PICTURES=PREFIX
# keeps screenshots.
. "$(dirname "$0")/lib.sh"
STRATA_CACHE_DIR=$folder/cache # sweeps learn what techniques cost
export STRATA_CACHE_DIR

chromium=
for name in chromium chromium-browser google-chrome; do
    [ -n "$chromium" ] || chromium=$(command -v "$name") || chromium=
done
if ! have_device; then
    echo "skip - report: no device that draws"
    exit 0
elif [ -z "$chromium" ] || ! command -v node >/dev/null 2>&1; then
    echo "skip - report: no Chromium or no node to read it with"
    exit 0
fi

hostile='x<img src=1 onerror="broken=1"><b>.glb'
"$strata" scene glass -o "$hostile" >/dev/null || fail 'a scene with markup in its name'
set -- sweep scene:glass -o sweep --size 24x18 --also 12x9 --also "./$hostile" --repeat 1 \
    --only 'abuffer mode=contiguous + ppc' --only 'kplus + ppc' --only 'kplus k=4 + ppc' --only 'kplus k=2 + ppc' --only wboit
run "$@"
[ "$status" -eq 0 ]
verdict 'a sweep of three cases'
# look NAME plots|bare
look() {
    node "$STRATA_TEST_SOURCE/tests/cli/browser.mjs" "$chromium" sweep/report.html "$2" \
        "${STRATA_TEST_PICTURES:+$STRATA_TEST_PICTURES$2-}" >seen 2>err || failures=$((failures + 1))
    sed "s/^\(not \)*ok - /&$1: /" seen
    [ -s seen ] && [ ! -s err ]
    verdict "$1: the browser had its say"
}
built=bare
! grep -q '^STRATA_CHART_JS:[A-Z]*=/' "$STRATA_TEST_BUILD/CMakeCache.txt" || built=plots
look 'as built' $built
strata=$STRATA_TEST_BUILD/tests/strata_bare
run "$@" --resume
[ "$status" -eq 0 ]
verdict 'the report anew, without plots'
look bare bare
finish
