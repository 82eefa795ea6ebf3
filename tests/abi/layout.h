/* SPDX-License-Identifier: MIT
 *
 * Prints the layout of abi/strata as the C and the C++ compiler see it.
 */
#ifndef STRATA_TESTS_ABI_LAYOUT_H
#define STRATA_TESTS_ABI_LAYOUT_H

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif
void abi_layout_c(FILE *out);
void abi_layout_cpp(FILE *out);
#ifdef __cplusplus
}
#endif
#endif
