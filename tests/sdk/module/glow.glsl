// SPDX-License-Identifier: MIT
//
// Adds light and hides nothing.
void glow_emit(StrataSurface surface, inout StrataPayload payload) {
    payload.color = vec4(surface.color.rgb, 0.0);
}

StrataElement glow_event(StrataPayload payload) {
    return StrataElement(payload.color, STRATA_TRANSMITTANCE(1.0));
}
