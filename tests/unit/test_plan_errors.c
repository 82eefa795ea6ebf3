/* SPDX-License-Identifier: MIT
 *
 * host/plan: wishes that cannot be met, against the line that says why and what there is instead;
 * wishes that are idle, against their warning.
 */
#include "unit/plan_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void idle_wishes_are_warned_of(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *warning;
    } rows[] = {
        {{FOR(ALL, "o"), .use = "abuffer"},
         "--use abuffer: it does not run, for no effect is active"},
        {{FOR(ALL, "b"), .use = "surface"},
         "--use surface: it does not run, for nothing opaque is drawn"},
        {{FOR(ALL, "o"), .use = "facesort"},
         "--use facesort: it does not run, for nothing in this frame uses what it makes"},
        {{FOR(ALL, "ob"), .settings = {"kplus.k=9"}}, "--set kplus: it does not run in this frame"},
        {{FOR(ALL, "obd"), .use = "stencil"},
         "stencil holds 254 fragments a pixel, and about 300 are expected"},
        {{FOR(ALL, "ob"), .device = "?"},
         "no device is known: whether it has what stencil needs "
         "(feature.stencil_export) was not checked"},
        {{FOR("surface abuffer ppc over", "obt")},
         "no installed effect is called for by materials.transmission (1 material with glass)"},
        {{FOR(ALL, "ob")}, NULL},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        const char *warning = p->warning_count ? p->warnings[0] : NULL;
        if ((warning == NULL) != (rows[i].warning == NULL) ||
            (warning && strcmp(warning, rows[i].warning) != 0) || p->warning_count > 1)
            fail_msg("row %zu: '%s' (%u)", i, warning ? warning : "", p->warning_count);
        plan_free(p);
    }
}

/* ---- errors ---------------------------------------------------------------------------------- */

static void bad_wishes_fail_with_what_there_is(void **state) {
    (void)state;
    static const struct {
        request r;
        strata_result result;
        const char *text; /* a part of the line */
    } rows[] = {
#define BAD    STRATA_ERROR_INVALID_ARGUMENT
#define CANNOT STRATA_ERROR_UNSUPPORTED
        {{FOR("surface abuffer ppc over", "o"), .use = "abufer"},
         BAD,
         "--use: there is no technique 'abufer' (did you mean 'abuffer'?); installed: surface, "
         "abuffer, ppc"},
        {{FOR("surface abuffer ppc over", "o"), .use = "xyzzy"},
         BAD,
         "--use: there is no technique 'xyzzy'; installed: surface, abuffer, ppc"},
        {{FOR(ALL, "o"), .use = "epex"}, BAD, "(did you mean 'peel'?)"},
        {{FOR("surface over", "o"), .use = "over"}, BAD, "'over' is an effect, not a technique"},
        {{FOR(ALL, "o"), .use = ""}, BAD, "--use '': an id is missing"},
        {{FOR(ALL, "o"), .use = "ppc,,fpc"}, BAD, "an id is missing"},
        {{FOR(ALL, "o"), .use = "ppc,"}, BAD, "an id is missing"},
        {{FOR(ALL, "o"), .effects = "ovr"},
         BAD,
         "--effects: there is no effect 'ovr' (did you mean 'over'?); installed: over, "
         "transmission"},
        {{FOR(ALL, "o"), .effects = "over,none"}, BAD, "'none' stands alone"},
        {{FOR("surface", "o"), .effects = "over"},
         BAD,
         "there is no effect 'over'; installed: none"},
        {{FOR(ALL, "ob"), .use = "abuffer,stencil"},
         BAD,
         "abuffer and stencil both produce fragments/1"},
        {{FOR(ALL, "ob"), .use = "ppc,fpc"}, BAD, "fpc and ppc both fold transparent fragments"},
        {{FOR(ALL, "ob"), .use = "peel,wboit"},
         BAD,
         "peel and wboit both fold transparent fragments"},
        {{FOR(ALL, "ob"), .use = "peel,ppc"},
         BAD,
         "peel folds transparent fragments by itself, ppc"},
        {{FOR(ALL, "ob"), .use = "abuffer,peel"},
         BAD,
         "peel folds transparent fragments by itself, abuffer"},
        {{FOR("surface flat", "o"), .use = "flat,surface"},
         BAD,
         "flat and surface: a frame takes one"},
        {{FOR("occupancy range kplus ppc over", "b"), .use = "occupancy,range,kplus"},
         BAD,
         "occupancy and range both produce limit/1; a slot has one producer"},
        {{FOR(ALL, "ob"), .use = "occupancy,abuffer"},
         BAD,
         "--use: occupancy cannot run: it hides what lies behind the nearest k fragments, and "
         "abuffer keeps all"},
        {{FOR(ALL, "ob"), .use = "occupancy"}, BAD, "and stencil keeps all"},
        {{FOR(ALL, "ob"), .use = "occupancy,kplus", .settings = {"kplus.k=0"}},
         BAD,
         "and kplus keeps all (its k is 0)"},
        {{FOR("worded over", "b"), .use = "worded", .settings = {"worded.payload=words"}},
         BAD,
         "--use: worded cannot run: of payloads this host knows float, half and unorm8 only"},
        {{FOR("occupancy window over", "b"), .use = "occupancy,window"},
         BAD,
         "and window blends all, in approximate order"},
        {{FOR("occupancy silent over", "b"), .use = "occupancy,silent"},
         BAD,
         "and silent promises no order"},
        {{FOR("occupancy peel over", "b"), .use = "occupancy,peel", .settings = {"peel.layers=8"}},
         BAD,
         "and peel does not say by a knob k how many it keeps"},
        {{FOR("surface egg hen", "o"), .use = "egg"},
         BAD,
         "cannot be ordered by their slots: hen waits for egg waits for hen"},
        {{FOR(ALL, "ob"), .use = "stencil", .device = "-"},
         CANNOT,
         "--use: stencil cannot run: needs feature.stencil_export"},
        {{FOR("surface mystic", "o"), .use = "mystic"},
         CANNOT,
         "this host knows no stage 'mystery'"},
        {{FOR("over", "ob")}, CANNOT, "nothing that can run here draws opaque surfaces"},
        {{FOR("surface over", "ob")}, CANNOT, "may fold them (none is installed)"},
        {{FOR("surface kplus ppc over", "ob")},
         CANNOT,
         "kplus: it keeps the nearest fragments only, and no tolerance is given; ppc: nothing "
         "fits"},
        {{FOR("chain ppc over", "b")}, CANNOT, "chain: nothing fits to it"},
        {{FOR("surface", "o"), .samples = 2}, CANNOT, "turns sub-pixels into pixels"},
        {{FOR(ALL, "ob"), .use = "peel", .deep = 1}, BAD, "deep output needs fragments/1"},
        {{FOR(ALL, "ob"), .use = "kplus", .deep = 1}, BAD, "deep output needs every fragment"},
        {{FOR("abuffer fpc media", "e"), .use = "fpc"}, BAD, "the effect media is sequential"},
        {{FOR("abuffer ppc over clash", "bu")},
         BAD,
         "declares the payload field 'color' differently"},
        /* settings */
        {{FOR(ALL, "o"), .settings = {"abufer.mode=linked"}}, BAD, "(did you mean 'abuffer'?)"},
        {{FOR(ALL, "o"), .settings = {"over.k=1"}}, BAD, "have no knobs"},
        {{FOR(ALL, "o"), .settings = {"abuffer.mod=linked"}},
         BAD,
         "abuffer has no knob 'mod' (did you mean 'mode'?); its knobs: mode, payload, threshold"},
        {{FOR(ALL, "o"), .settings = {"ppc.k=1"}}, BAD, "ppc has no knob 'k'; its knobs: none"},
        {{FOR(ALL, "o"), .settings = {"abuffer.mode=linkd"}},
         BAD,
         "no such choice (did you mean 'linked'?); there are: contiguous, linked"},
        {{FOR(ALL, "o"), .settings = {"abuffer.mode=1"}}, BAD, "there are: contiguous, linked"},
        {{FOR(ALL, "o"), .settings = {"abuffer"}}, BAD, "expected ID.KNOB=VALUE"},
        {{FOR(ALL, "o"), .settings = {"abuffer.mode"}}, BAD, "expected ID.KNOB=VALUE"},
        {{FOR(ALL, "o"), .settings = {"abuffer=linked"}}, BAD, "expected ID.KNOB=VALUE"},
        {{FOR(ALL, "o"), .settings = {".mode=linked"}}, BAD, "expected ID.KNOB=VALUE"},
        {{FOR(ALL, "o"), .settings = {"abuffer.=linked"}}, BAD, "expected ID.KNOB=VALUE"},
        {{FOR(ALL, "o"), .settings = {"abuffer.mode="}}, BAD, "expected ID.KNOB=VALUE"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=-1"}},
         BAD,
         "expected a whole number from 0 to 64 fragments"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=65"}}, BAD, "from 0 to 64"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=2.5"}}, BAD, "whole number"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=8x"}}, BAD, "whole number"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=0x8"}}, BAD, "whole number"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=nan"}}, BAD, "whole number"},
        {{FOR(ALL, "o"), .settings = {"kplus.k=1e99"}}, BAD, "whole number"},
        {{FOR(ALL, "o"), .settings = {"abuffer.threshold=inf"}},
         BAD,
         "expected a number from 0 to 1"},
        {{FOR(ALL, "o"), .settings = {"abuffer.threshold=1e999"}},
         BAD,
         "expected a number from 0 to 1"},
        {{FOR(ALL, "o"), .settings = {"abuffer.threshold=0,5"}},
         BAD,
         "expected a number from 0 to 1"},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = NULL;
        base_error err;
        strata_result result = ask(&rows[i].r, &k, &d, &p, &err);
        if (result != rows[i].result || result != err.result || p)
            fail_msg("row %zu: result %d (%s)", i, result, err.text);
        if (!strstr(err.text, rows[i].text))
            fail_msg("row %zu: '%s' does not say '%s'", i, err.text, rows[i].text);
    }
}

static void a_failed_technique_is_replaced(void **state) {
    (void)state;
    kit k;
    demand d;
    strata_scene_stats stats;
    plan *p = NULL;
    base_error err = {0};
    plan_exclusion failed[] = {{"abuffer", "the shader did not compile"}};
    plan_input in = {
        .demand = &d,
        .modules = (const modules_note *const *)k.list,
        .stats = &stats,
        .exclusions = failed,
        .exclusion_count = 1,
    };
    kit_make(&k, "abuffer ppc peel over");
    kit_scene("b", &d, &stats);
    in.module_count = k.count;
    assert_int_equal(plan_make(&in, &p, &err), STRATA_OK);
    assert_string_equal(order_of(p), "peel");
    assert_string_equal(reason_of(p, "abuffer"), "it failed: the shader did not compile");
    plan_free(p);
    in.use = "abuffer";
    assert_int_equal(plan_make(&in, &p, &err), STRATA_ERROR_UNSUPPORTED);
    assert_non_null(strstr(err.text, "it failed: the shader did not compile"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(idle_wishes_are_warned_of),
        cmocka_unit_test(bad_wishes_fail_with_what_there_is),
        cmocka_unit_test(a_failed_technique_is_replaced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
