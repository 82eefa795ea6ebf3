/* SPDX-License-Identifier: MIT
 *
 * Passes whose shaders read the colour attachments that they replace: input attachments in
 * rasterisation order (VK_EXT_rasterization_order_attachment_access). That takes a render pass
 * object, while all other passes use dynamic rendering; render passes and framebuffers are kept for
 * each set of attachments until one of the images goes.
 */
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

typedef struct target_key { /* no padding, compared as bytes */
    const vk_image *color[GPU_VK_MAX_COLORS], *depth;
    uint32_t loads[GPU_VK_MAX_COLORS];
    uint32_t depth_load, reads, color_count, unused;
} target_key;

struct vk_target {
    target_key key;
    VkRenderPass pass;
    VkFramebuffer framebuffer;
};

uint32_t vk_reads(const gpu_native_pass *pass) {
    uint32_t reads = 0;
    for (uint32_t i = 0; i < pass->pass->color_count; i++)
        reads |= pass->pass->color[i].read << i;
    return reads;
}

static target_key make_key(const gpu_native_pass *pass) {
    const strata_pass *p = pass->pass;
    target_key key;
    memset(&key, 0, sizeof key);
    key.color_count = p->color_count;
    key.reads = vk_reads(pass);
    for (uint32_t i = 0; i < p->color_count; i++) {
        key.color[i] = pass->color[i];
        key.loads[i] = p->color[i].load;
    }
    key.depth = pass->depth;
    key.depth_load = pass->depth ? p->depth->load : 0;
    return key;
}

static VkAttachmentDescription2 describe(const vk_image *image, uint32_t load) {
    return (VkAttachmentDescription2){.sType = VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2,
                                      .format = image->format,
                                      .samples = VK_SAMPLE_COUNT_1_BIT,
                                      .loadOp = vk_load_op(load),
                                      .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                      .stencilLoadOp = vk_load_op(load),
                                      .stencilStoreOp = VK_ATTACHMENT_STORE_OP_STORE,
                                      .initialLayout = VK_IMAGE_LAYOUT_GENERAL,
                                      .finalLayout = VK_IMAGE_LAYOUT_GENERAL};
}

static VkAttachmentReference2 refer(uint32_t attachment, VkImageAspectFlags aspects) {
    return (VkAttachmentReference2){.sType = VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2,
                                    .attachment = attachment,
                                    .layout = VK_IMAGE_LAYOUT_GENERAL,
                                    .aspectMask = aspects};
}

/* The pass's own barriers order it against others, so there are no external dependencies. */
static VkResult create_render_pass(vk *v, const target_key *key, VkRenderPass *out) {
    VkAttachmentDescription2 attachments[GPU_VK_MAX_COLORS + 1];
    VkAttachmentReference2 colors[GPU_VK_MAX_COLORS], inputs[GPU_VK_MAX_COLORS], depth;
    uint32_t count = key->color_count;
    for (uint32_t i = 0; i < key->color_count; i++) {
        const int is_read = key->reads >> i & 1u;
        attachments[i] = describe(key->color[i], key->loads[i]);
        colors[i] = refer(i, VK_IMAGE_ASPECT_COLOR_BIT);
        inputs[i] = refer(is_read ? i : VK_ATTACHMENT_UNUSED, VK_IMAGE_ASPECT_COLOR_BIT);
    }
    if (key->depth) {
        attachments[count] = describe(key->depth, key->depth_load);
        depth = refer(count++, key->depth->aspects);
    }
    const VkSubpassDescription2 subpass = {
        .sType = VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2,
        .flags = VK_SUBPASS_DESCRIPTION_RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_BIT_EXT,
        .pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
        .inputAttachmentCount = key->color_count,
        .pInputAttachments = inputs,
        .colorAttachmentCount = key->color_count,
        .pColorAttachments = colors,
        .pDepthStencilAttachment = key->depth ? &depth : NULL};
    const VkRenderPassCreateInfo2 info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2,
                                          .attachmentCount = count,
                                          .pAttachments = attachments,
                                          .subpassCount = 1,
                                          .pSubpasses = &subpass};
    return vkCreateRenderPass2(v->device, &info, NULL, out);
}

static VkResult create_framebuffer(vk *v, const gpu_native_pass *pass, vk_target *target) {
    VkImageView views[GPU_VK_MAX_COLORS + 1];
    uint32_t count = target->key.color_count;
    for (uint32_t i = 0; i < count; i++)
        views[i] = target->key.color[i]->attachment;
    if (target->key.depth)
        views[count++] = target->key.depth->attachment;
    const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                          .renderPass = target->pass,
                                          .attachmentCount = count,
                                          .pAttachments = views,
                                          .width = pass->width,
                                          .height = pass->height,
                                          .layers = 1};
    return vkCreateFramebuffer(v->device, &info, NULL, &target->framebuffer);
}

static void release(vk *v, const vk_target *target) {
    vkDestroyFramebuffer(v->device, target->framebuffer, NULL);
    vkDestroyRenderPass(v->device, target->pass, NULL);
}

const vk_target *vk_target_get(vk *v, const gpu_native_pass *pass, base_error *err) {
    vk_target target = {.key = make_key(pass)};
    for (size_t i = 0; i < v->target_count; i++)
        if (!memcmp(&v->targets[i].key, &target.key, sizeof target.key))
            return &v->targets[i];
    vk_target *list = base_grow(v->targets, &v->target_capacity, v->target_count, sizeof *list);
    if (!list) {
        base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
        return NULL;
    }
    v->targets = list;
    VkResult code = create_render_pass(v, &target.key, &target.pass);
    if (code == VK_SUCCESS)
        code = create_framebuffer(v, pass, &target);
    if (code != VK_SUCCESS) {
        release(v, &target);
        vk_fail(v, code, err, pass->pass->label);
        return NULL;
    }
    list[v->target_count] = target;
    return &list[v->target_count++];
}

VkRenderPass vk_target_pass(const vk_target *target) {
    return target->pass;
}

void vk_target_begin(VkCommandBuffer commands, const vk_target *target,
                     const gpu_native_pass *pass) {
    VkClearValue clears[GPU_VK_MAX_COLORS + 1];
    uint32_t count = target->key.color_count;
    for (uint32_t i = 0; i < count; i++)
        clears[i].color = vk_clear_color(target->key.color[i], pass->pass->color[i].clear);
    if (target->key.depth)
        clears[count++].depthStencil = vk_clear_depth(pass->pass->depth->clear);
    const VkRenderPassBeginInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                        .renderPass = target->pass,
                                        .framebuffer = target->framebuffer,
                                        .renderArea = {{0, 0}, {pass->width, pass->height}},
                                        .clearValueCount = count,
                                        .pClearValues = clears};
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
}

void vk_targets_forget(vk *v, const vk_image *image) {
    size_t kept = 0;
    for (size_t i = 0; i < v->target_count; i++) {
        const vk_target *target = &v->targets[i];
        int gone = !image || target->key.depth == image;
        for (uint32_t k = 0; k < GPU_VK_MAX_COLORS; k++)
            gone = gone || target->key.color[k] == image;
        if (gone)
            release(v, target);
        else
            v->targets[kept++] = *target;
    }
    v->target_count = kept;
}
