// SPDX-License-Identifier: MIT
//
// Where each class's list begins, and its indirect dispatch; called by one invocation between the
// histogram and the lists. The includer declares CLASS_TABLE.
void strata_class_offsets() {
    uint offset = 0u;
    for (uint c = 0u; c < CLASS_COUNT; ++c) {
        classes[c].offset = offset;
        classes[c].groups = uvec4(strata_groups(classes[c].count), 0u);
        offset += classes[c].count;
    }
}
