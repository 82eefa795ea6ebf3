/* SPDX-License-Identifier: MIT
 *
 * abi/strata's layout as C11 sees it. */
#define LAYOUT_FUNCTION abi_layout_c
#include "abi/layout.inc"
