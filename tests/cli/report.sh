#!/bin/sh
# SPDX-License-Identifier: MIT
#
# The report of a sweep in a real browser, 1280 and 400 pixels wide. Needs Chromium and node.
# STRATA_TEST_PICTURES=PREFIX keeps screenshots.
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
run sweep scene:glass -o sweep --size 24x18 --also 12x9 --also "./$hostile" --repeat 1 \
    --only 'abuffer + ppc' --only 'kplus + ppc' --only 'kplus k=4 + ppc' --only 'kplus k=2 + ppc' --only wboit
[ "$status" -eq 0 ]
verdict 'a sweep of three cases'
node "$STRATA_TEST_SOURCE/tests/cli/browser.mjs" "$chromium" sweep/report.html \
    "${STRATA_TEST_PICTURES:-}" >seen 2>err || failures=$((failures + 1))
cat seen
[ -s seen ] && [ ! -s err ]
verdict 'the browser had its say'
finish
