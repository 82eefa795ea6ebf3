// SPDX-License-Identifier: MIT
//
// kplus, atomics, first geometry pass: keys find their slots, nothing is shaded. With ORDERS_PASS, the pass
// after it: where keys are equal, orders do. The attachment counts by blending what arrived.
#ifdef WIDE
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "strata/shading.glsl"
#include "descend.glsl"
#include "strata/pool.glsl"

layout(early_fragment_tests) in;
#if !defined(EXACT) && !defined(ORDERS_PASS)
layout(location = 0) out float arrived;
#endif

void main() {
    if (!strata_covered())
        discard;
#if !defined(EXACT) && !defined(ORDERS_PASS)
    arrived = 1.0;
#endif
    if (strata_pool_short())
        return;
    uvec2 slots = slots_of(uvec2(gl_FragCoord.xy));
    uvec2 record = uvec2(strata_key(gl_FragCoord.z), strata_order(strata_primitive()));
#ifdef ORDERS_PASS
    descend_orders(slots_of_key(slots, record.x), record.y);
#else
    descend(slots, value_of(record));
#endif
}
