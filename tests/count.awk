# SPDX-License-Identifier: MIT
#
# Counts test cases in ctest's log: cmocka's "[  OK  ] name" lines and the "ok - name", "not ok -
# name", "skip - name" lines of tests written in sh. A program that ends badly without a failed case
# (it crashed, or took too long) is a failed case; one without any case and a good end passed.
function finish(good) {
    if (!good && !failed_here) {
        failed++
        print "failed: " name " did not end well"
    } else if (good && !cases) {
        passed++
    }
}
/^[0-9]+\/[0-9]+ Testing: / { name = $3; cases = failed_here = inside = 0 }
/^\[=+\].*[Rr]unning/ { inside = 1; next }
/^\[=+\].*run\.$/ { inside = 0; next }
inside && /^\[ +OK \]/ { passed++; cases++ }
inside && /^\[ +SKIPPED \]/ { skipped++; cases++; print "skipped: " name ": " $NF }
inside && /^\[ +FAILED +\]/ { failed++; cases++; failed_here++; print "failed: " name ": " $NF }
/^ok - / { passed++; cases++ }
/^skip - / { skipped++; cases++; print "skipped: " name ": " substr($0, 8) }
/^not ok - / { failed++; cases++; failed_here++; print "failed: " name ": " substr($0, 10) }
/^Test Passed\.$/ { finish(1) }
/^(Test Failed|Test Timeout|Test (time )?[Ee]xceeded|Exception|Could not|Unable to)/ { finish(0) }
END {
    if (status != 0 && !failed) {
        failed++
        print "failed: ctest, with exit status " status
    }
    printf "%d passed, %d failed%s\n", passed, failed, skipped ? ", " skipped " skipped" : ""
    exit failed > 0 || passed == 0
}
