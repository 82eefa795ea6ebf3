# SPDX-License-Identifier: MIT
#
# For tests of the command line: sourced by them. A case runs `strata` and looks at its status, at
# what it wrote, and at the files it left; each prints "ok - NAME" or "not ok - NAME".
set -u
strata=$STRATA_TEST_BUILD/bin/strata
json_get=$STRATA_TEST_BUILD/tests/json_get
folder=$(mktemp -d "${TMPDIR:-/tmp}/strata-cli-XXXXXX") || exit 1
trap 'chmod -R u+w "$folder"; rm -rf "$folder"' EXIT
cd "$folder" || exit 1
export STRATA_CACHE_DIR="${STRATA_CACHE_DIR:-$STRATA_TEST_BUILD/tests/cache}"
unset STRATA_LOG STRATA_CHECK
failures=0

# run ARGUMENTS: strata's status is in $status, its streams in the files out and err.
run() {
    status=0
    "$strata" "$@" >out 2>err || status=$?
}

pass() { echo "ok - $1"; }

fail() {
    echo "not ok - $1"
    echo "  status $status, stdout $(wc -c <out) bytes, stderr:"
    sed 's/^/    /' err | head -n 5
    failures=$((failures + 1))
}

# verdict NAME: the case holds when the last command did.
verdict() {
    if [ $? -eq 0 ]; then pass "$1"; else fail "$1"; fi
}

# is_line TEXT: stderr is one line and holds TEXT.
is_line() { [ "$(wc -l <err)" -eq 1 ] && grep -qF -- "$1" err; }

# refuse NAME STATUS TEXT ARGUMENTS: ends with STATUS, says TEXT on stderr, nothing on stdout. A
# failure is one line; bad usage may add the hint at --help.
refuse() {
    name=$1 wanted=$2 text=$3
    shift 3
    run "$@"
    [ "$status" -eq "$wanted" ] && [ ! -s out ] && grep -qF -- "$text" err &&
        { [ "$wanted" -eq 2 ] || is_line "$text"; } && [ "$(wc -l <err)" -le 2 ]
    verdict "$name"
}

# get FILE PATH: a value in a JSON file, "" when it is not there.
get() { "$json_get" "$1" "$2" 2>/dev/null; }

# No temporary file of a picture or a text is left.
clean() { [ -z "$(find . -name '*.part*')" ]; }

# A device that draws; else the cases that need one are skipped.
have_device() {
    "$strata" list --json >devices.json 2>/dev/null && [ "$(get devices.json devices/#)" -gt 0 ]
}

finish() { [ "$failures" -eq 0 ]; }
