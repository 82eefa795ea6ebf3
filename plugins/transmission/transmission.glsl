// SPDX-License-Identifier: MIT
//
// Effect `transmission`: a thin sheet that reflects, covers, and lets the rest through coloured
// (KHR_materials_transmission without bending). surface.color is the radiance that leaves the sheet
// itself, surface.tint the share of light from behind that passes it; alpha is coverage.

void transmission_emit(StrataSurface surface, inout StrataPayload payload) {
    payload.glow = surface.color * surface.alpha;
    precise vec3 through = vec3(1.0 - surface.alpha) + surface.tint * surface.alpha;
    payload.through = through;
}

StrataElement transmission_event(StrataPayload payload) {
    precise float mean = (payload.through.r + payload.through.g + payload.through.b) * (1.0 / 3.0);
    precise float cover = 1.0 - mean;
    return StrataElement(vec4(payload.glow, cover), STRATA_TRANSMITTANCE(payload.through));
}
