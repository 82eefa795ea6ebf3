#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds, and runs every test: `sh tests/run.sh [ARGUMENTS OF CTEST]`.
# The last line is "N passed, N failed[, N skipped]", counted in test cases; the exit status is 0
# when all that ran passed and something ran.
set -eu
cd "$(dirname "$0")/.."
. host/cmake/setup.sh
setup_install "$SETUP_BUILD $SETUP_RUN $SETUP_TEST"
setup_build ON

status=0
ctest --test-dir build --parallel 2 --output-on-failure --no-tests=error "$@" || status=$?
[ -f build/Testing/Temporary/LastTest.log ] || setup_fail "ctest ran no test"
awk -v status="$status" -f tests/count.awk build/Testing/Temporary/LastTest.log
