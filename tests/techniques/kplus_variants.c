/* SPDX-License-Identifier: MIT
 *
 * The paths; see kplus_variants.h.
 */
#include "techniques/kplus_variants.h"

const char *const kplus_backends[2] = {"vulkan claims:selftest.interlock",
                                       "gl claims:selftest.interlock"};

const kplus_variant kplus_variants[KPLUS_VARIANTS] = {
    {.settings = {"kplus.exclusion=auto"}, .cheap = 1},
    {.settings = {"kplus.exclusion=unlocked", "kplus.structure=array"},
     .fact = "selftest.ordered_rmw",
     .cheap = 1},
    {.settings = {"kplus.exclusion=unlocked", "kplus.structure=heap"},
     .fact = "selftest.ordered_rmw",
     .cheap = 1},
    {.settings = {"kplus.exclusion=unlocked", "kplus.structure=heap", "kplus.memory=exact"},
     .fact = "selftest.ordered_rmw",
     .cheap = 1},
    {.settings = {"kplus.exclusion=interlock", "kplus.structure=array"},
     .fact = "selftest.interlock",
     .cheap = 1},
    {.settings = {"kplus.exclusion=interlock", "kplus.structure=heap", "kplus.memory=exact"},
     .fact = "selftest.interlock",
     .cheap = 1},
    {.settings = {"kplus.exclusion=ordered"},
     .fact = "ordered_attachments",
     .cheap = 1,
     .k_most = 16},
    {.settings = {"kplus.exclusion=ordered", "kplus.memory=exact"},
     .fact = "ordered_attachments",
     .cheap = 1,
     .k_most = 16},
    {.settings = {"kplus.exclusion=lock", "kplus.structure=array"}, .cheap = 1},
    {.settings = {"kplus.exclusion=lock", "kplus.structure=heap", "kplus.memory=exact"},
     .cheap = 1},
    {.settings = {"kplus.exclusion=lock", "kplus.tries=0"}},
    {.settings = {"kplus.exclusion=atomic32"}, .cheap = 1},
    {.settings = {"kplus.exclusion=atomic32", "kplus.memory=exact"}},
    {.settings = {"kplus.exclusion=atomic64"}, .fact = "feature.int64_atomics", .cheap = 1},
    {.settings = {"kplus.exclusion=atomic64", "kplus.memory=exact"},
     .fact = "feature.int64_atomics"},
};

int kplus_runs(const strata *instance, const kplus_variant *v, uint32_t k) {
    return (!v->fact || picture_fact(instance, v->fact)) && (v->k_most == 0 || k <= v->k_most);
}
