/* SPDX-License-Identifier: MIT
 *
 * The fold oracle: a pixel's records, decoded and composited in double, and by how much a float
 * fold in the order of shaders/strata/fold.glsl may differ. See oracle.h.
 *
 * The bound. Every float operation gives its exact result times 1 + d, |d| <= u = 2^-24 (`precise`
 * forbids contraction); what underflows is lost whole, at most 2^-126. Record i of n, i = 0 .. n -
 * 1, adds T_i c_i to a channel, T_i = t_0 .. t_(i-1); i = n is what lies behind. Errors are
 * followed step by step, beside the exact values, in double:
 *
 *   t_i  comes from the payload: exact for coloured transmission, 1 - alpha with one rounding for
 *        plain transparency; in general with an error e(t_i).
 *   T_i  E(T_(i+1)) = (|T_i| + E(T_i)) (|t_i| + e(t_i)) (1 + u) - |T_i t_i|
 *   p_i  = T_i c_i; E(p_i) = (|T_i| + E(T_i)) (|c_i| + e(c_i)) (1 + u) - |T_i c_i|
 *   S_i  the sum so far: E(S_(i+1)) = E(S_i) + E(p_i) + the rounding of x + y, which is no more
 * than u |x + y|, nor than |x| or |y|, since x and y are floats themselves.
 *
 * Summed up over a plain walk in float this is at most sum gamma_m |T_i c_i| with m = 2i + 1 for
 * T_i, c_i and their product and n - i + 1 for the additions, so m <= 2n + 2: within the 3n that a
 * walk with three roundings a step is granted. test_bound holds it to that.
 *
 * Alpha under three transmittances is composed by itself: S' = S + (1 - S) c. An error of S enters
 * twice and nearly cancels: with R = 1 - S,
 *        E(S') = E(S) (|1 - c| + e(c)) + |R| e(c) + gamma_2 (|R| + E(S)) (|c| + e(c)) + the
 * addition's.
 */
#include "oracle/oracle.h"

#include <math.h>
#include <string.h>

#define SMALLEST_NORMAL 0x1p-126

double oracle_gamma(double m, double unit) {
    return m * unit / (1.0 - m * unit);
}

/* ---- payload --------------------------------------------------------------------------------- */

static double from_half(uint32_t bits) {
    const int exponent = (int)(bits >> 10 & 31u);
    const double sign = bits & 0x8000u ? -1.0 : 1.0;
    const double mantissa = (double)(bits & 0x3ffu);
    assert_int_not_equal(exponent, 31); /* infinities are never stored */
    return exponent == 0 ? sign * ldexp(mantissa, -24)
                         : sign * ldexp(mantissa + 1024.0, exponent - 25);
}

static double from_float(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    assert_true(isfinite(value));
    return (double)value;
}

double oracle_payload(const plan_payload *payload, const oracle_record *record, const char *field,
                      uint32_t channel, int *rounded) {
    *rounded = 0;
    for (uint32_t i = 0; i < payload->field_count; i++) {
        const plan_field *found = &payload->fields[i];
        if (strcmp(found->name, field) != 0 || channel >= found->channels)
            continue;
        const plan_channel *at = &found->at[channel];
        const uint32_t word = record->words[at->word] >> at->bit;
        if (at->bits == 32)
            return from_float(word);
        if (at->bits == 16)
            return from_half(word & 0xffffu);
        *rounded = word & 0xffu ? 2 : 0; /* the constant 1/255 and the product with it */
        return (double)(word & 0xffu) / 255.0;
    }
    return NAN;
}

static oracle_value load(const plan *p, const oracle_record *record, const char *field,
                         uint32_t channel) {
    int rounded = 0;
    const double value = oracle_payload(&p->payload, record, field, channel, &rounded);
    if (isnan(value))
        fail_msg("the payload has no %s.%u", field, channel);
    return (oracle_value){value, oracle_gamma(rounded, ORACLE_UNIT) * fabs(value)};
}

/* 1 - x in float. */
static oracle_value complement(oracle_value x) {
    const double value = 1.0 - x.value;
    return (oracle_value){value, x.error + ORACLE_UNIT * (fabs(value) + x.error)};
}

/* Mean of three in float, as above. */
static oracle_value mean(const oracle_value x[3]) {
    double sum = 0, size = 0;
    for (int c = 0; c < 3; c++) {
        sum += x[c].value / 3.0;
        size += (fabs(x[c].value) + x[c].error) / 3.0;
    }
    double error = size * oracle_gamma(4, ORACLE_UNIT);
    for (int c = 0; c < 3; c++)
        error += x[c].error / 3.0;
    return (oracle_value){sum, error};
}

/* ---- effects --------------------------------------------------------------------------------- */

/* A surface that covers `alpha` of the pixel. */
static oracle_element over(const plan *p, const oracle_record *record) {
    oracle_element e;
    for (uint32_t c = 0; c < 4; c++)
        e.color[c] = load(p, record, "color", c);
    for (int c = 0; c < 3; c++)
        e.through[c] = complement(e.color[3]);
    return e;
}

/* A sheet that lets a colour through; what it covers is what it keeps, in the mean. */
static oracle_element transmission(const plan *p, const oracle_record *record) {
    oracle_element e;
    for (uint32_t c = 0; c < 3; c++) {
        e.color[c] = load(p, record, "glow", c);
        e.through[c] = load(p, record, "through", c);
    }
    e.color[3] = complement(mean(e.through));
    return e;
}

oracle_element oracle_decode(const plan *p, const oracle_record *record) {
    int rounded = 0;
    const double id = oracle_payload(&p->payload, record, "id", 0, &rounded);
    for (uint32_t i = 0; i < p->effect_count; i++) {
        const plan_effect *effect = &p->effects[i];
        if (!effect->active || (p->active_effects > 1 && id != (double)effect->index))
            continue;
        if (strcmp(effect->effect->id, "over") == 0)
            return over(p, record);
        if (strcmp(effect->effect->id, "transmission") == 0)
            return transmission(p, record);
        fail_msg("the oracle does not know the effect %s", effect->effect->id);
    }
    fail_msg("a record of effect number %g, which is not active", id);
    return (oracle_element){0};
}

/* ---- fold ------------------------------------------------------------------------------------ */

/* How much x + y, each off by its error, may be rounded. */
static double sum_rounding(oracle_value x, oracle_value y) {
    const double left = fabs(x.value) + x.error, right = fabs(y.value) + y.error;
    const double sum = fabs(x.value + y.value) + x.error + y.error;
    return fmin(ORACLE_UNIT * sum, fmin(left, right));
}

static oracle_value product(oracle_value x, oracle_value y) {
    const double exact = x.value * y.value;
    const double most = (fabs(x.value) + x.error) * (fabs(y.value) + y.error);
    return (oracle_value){exact, most * (1.0 + ORACLE_UNIT) - fabs(exact) + SMALLEST_NORMAL};
}

/* sum + weight c */
static void add(oracle_value *sum, oracle_value weight, oracle_value c) {
    const oracle_value p = product(weight, c);
    const double rounding = sum_rounding(*sum, p);
    sum->value += p.value;
    sum->error += p.error + rounding;
}

/* sum + (1 - sum) c */
static void cover(oracle_value *sum, oracle_value c) {
    const double rest = 1.0 - sum->value, gamma = oracle_gamma(2, ORACLE_UNIT);
    const double size = (fabs(rest) + sum->error) * (fabs(c.value) + c.error);
    const oracle_value p = {rest * c.value, size - fabs(rest * c.value) + gamma * size};
    const double rounding = sum_rounding(*sum, p) + SMALLEST_NORMAL;
    sum->error = sum->error * (fabs(1.0 - c.value) + c.error) + fabs(rest) * c.error +
                 gamma * size + rounding;
    sum->value += p.value;
}

static void step(const plan *p, oracle_value out[4], const oracle_value through[3],
                 const oracle_value color[4]) {
    for (int c = 0; c < 3; c++)
        add(&out[c], through[c], color[c]);
    if (p->transmittance_channels == 3)
        cover(&out[3], color[3]);
    else
        add(&out[3], through[0], color[3]);
}

void oracle_fold(const plan *p, const oracle_record *sorted, size_t count, const float *behind,
                 oracle_value out[4]) {
    oracle_value through[3] = {{1, 0}, {1, 0}, {1, 0}}, last[4];
    for (int c = 0; c < 4; c++) {
        out[c] = (oracle_value){0, 0};
        last[c] = (oracle_value){behind ? (double)behind[c] : 0, 0};
    }
    for (size_t i = 0; i < count; i++) {
        const oracle_element e = oracle_decode(p, &sorted[i]);
        step(p, out, through, e.color);
        for (int c = 0; c < 3; c++)
            through[c] = product(through[c], e.through[c]);
    }
    if (behind)
        step(p, out, through, last);
}

void oracle_fold_backwards(const plan *p, const oracle_record *sorted, size_t count,
                           const float *behind, long double out[4]) {
    for (int c = 0; c < 4; c++)
        out[c] = behind ? (long double)behind[c] : 0.0L;
    for (size_t i = count; i-- > 0;) {
        const oracle_element e = oracle_decode(p, &sorted[i]);
        const long double covered = (long double)e.color[3].value;
        for (int c = 0; c < 4; c++) {
            const long double t = c == 3 ? 1.0L - covered : (long double)e.through[c].value;
            out[c] = (long double)e.color[c].value + t * out[c];
        }
    }
}
