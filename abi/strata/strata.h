/* SPDX-License-Identifier: MIT
 *
 * strata/strata.h - the whole SDK: everything a module or an embedding program may use.
 */
#ifndef STRATA_STRATA_H
#define STRATA_STRATA_H

#include "base.h"
#include "effect.h"
#include "ext/gl.h"
#include "ext/vulkan.h"
#include "frame.h"
#include "gpu.h"
#include "host.h"
#include "scene.h"
#include "technique.h"

#endif
