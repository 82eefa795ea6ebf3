# SPDX-License-Identifier: MIT
function(strata_add_module id)
endfunction()
