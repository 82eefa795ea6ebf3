/* SPDX-License-Identifier: MIT
 *
 * The one function of strata/host.h that needs nothing of the host: which ABI this library speaks.
 */
#include "strata/host.h"

uint32_t strata_version(void) {
    return STRATA_ABI_VERSION;
}
