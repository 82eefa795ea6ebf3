// SPDX-License-Identifier: MIT
//
// Effect `over`: a surface covers a part `alpha` of the pixel and lets the rest through unchanged
// (Porter and Duff 1984, premultiplied).

void over_emit(StrataSurface surface, inout StrataPayload payload) {
    payload.color = vec4(surface.color * surface.alpha, surface.alpha);
}

StrataElement over_event(StrataPayload payload) {
    precise float through = 1.0 - payload.color.a;
    return StrataElement(payload.color, STRATA_TRANSMITTANCE(through));
}
