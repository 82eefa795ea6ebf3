// SPDX-License-Identifier: MIT
//
// The effect of the test module: enough to be embedded; nothing compiles it.
void fixture_emit(StrataSurface surface, inout StrataPayload payload) {
    payload.tint = surface.color;
}

StrataElement fixture_event(StrataPayload payload) {
    return StrataElement(payload.tint, 1.0 - payload.tint.a);
}
