/* SPDX-License-Identifier: MIT
 *
 * abi/strata's layout as C++17 sees it. */
#define LAYOUT_FUNCTION abi_layout_cpp
#include "abi/layout.inc"
