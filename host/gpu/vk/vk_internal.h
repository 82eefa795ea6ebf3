/* SPDX-License-Identifier: MIT
 *
 * What the files of the Vulkan backend share: the device, its objects, and the helpers that every
 * one of them leans on. Stands behind host/gpu/backend.h: calls are validated, barriers derived.
 *
 * Decisions that hold everywhere: one queue; images stay in VK_IMAGE_LAYOUT_GENERAL; a submission
 * is waited for before the call that made it returns, so the device is idle between calls.
 */
#ifndef STRATA_HOST_GPU_VK_INTERNAL_H
#define STRATA_HOST_GPU_VK_INTERNAL_H

#include <pthread.h>
#include <vulkan/vulkan.h>

#include "gpu/backend.h"

#define GPU_VK_MAX_BINDINGS 64u   /* of one program */
#define GPU_VK_MAX_TIMED    1024u /* measured passes of one submission; others stay unmeasured */
#define GPU_VK_MAX_COLORS   8u

/* ---- memory: vk_memory.c ---------------------------------------------------------------- */
typedef struct vk_block vk_block; /* one vkAllocateMemory that small objects share */

typedef struct vk_memory {
    VkDeviceMemory memory;
    VkDeviceSize offset;
    unsigned char *map; /* host address of the first byte; NULL: reached through staging */
    vk_block *block;    /* NULL: a dedicated allocation */
    uint32_t slot;
} vk_memory;

typedef enum vk_memory_use {
    GPU_VK_BUFFER, /* device local; mapped too where that costs nothing */
    GPU_VK_IMAGE,
    GPU_VK_STAGING /* always mapped */
} vk_memory_use;

typedef struct vk_buffer {
    VkBuffer handle;
    VkBufferView texels; /* its words; made when first bound as such */
    VkDeviceSize size;
    vk_memory memory;
} vk_buffer;

typedef struct vk_image {
    VkImage handle;
    VkImageView view;       /* for bindings; of depth images, the depth alone */
    VkImageView attachment; /* all aspects; the same view where there is one aspect */
    vk_memory memory;
    VkFormat format;
    VkImageAspectFlags aspects;
    uint32_t texel; /* bytes a texel on the host; depth with stencil: depth word, stencil word */
    uint32_t integer;
    uint32_t width, height, layers, samples; /* layers and samples >= 1 */
} vk_image;

/* ---- programs: vk_program.c ------------------------------------------------------------- */

/* What of a pass is baked into a graphics pipeline; the rest is dynamic state. No padding, compared
 * as bytes. */
typedef struct vk_pipeline_key {
    uint32_t color_count, depth_format;
    uint32_t reads; /* bit i: colour attachment i is read too */
    uint32_t samples, sample_mask;
    uint32_t formats[GPU_VK_MAX_COLORS], blends[GPU_VK_MAX_COLORS], mask_off[GPU_VK_MAX_COLORS];
} vk_pipeline_key;

typedef struct vk_pipeline {
    vk_pipeline_key key;
    VkPipeline handle;
} vk_pipeline;

typedef struct vk_program {
    uint32_t kind; /* STRATA_PROGRAM_* */
    VkShaderStageFlags stages;
    VkShaderModule modules[2];
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    uint32_t binding_count, params_size;
    VkPipeline compute;
    vk_pipeline *pipelines; /* graphics, in order of first use */
    size_t pipeline_count, pipeline_capacity;
} vk_program;

/* Render pass and framebuffer of passes that read attachments: vk_ordered.c */
typedef struct vk_target vk_target;

/* ---- the device: vk_device.c ------------------------------------------------------------ */
typedef struct vk {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    VkPhysicalDeviceLimits limits;
    VkPhysicalDeviceMemoryProperties memory;
    VkDeviceSize allocation_limit;
    uint64_t timestamp_mask;   /* 0: the queue has no timestamps */
    VkSampleCountFlags placed; /* numbers of samples, above 1, whose places can be set */

    int check, lost;
    VkDebugUtilsMessengerEXT messenger;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label; /* NULL unless checking */
    PFN_vkCmdEndDebugUtilsLabelEXT end_label;
    PFN_vkSetDebugUtilsObjectNameEXT set_name;
    pthread_mutex_t message_lock;
    char message[480]; /* the validation's first complaint since the last report */

    VkFence fence;
    VkCommandPool frame_pool, once_pool;
    VkCommandBuffer frame, once;
    int recording;      /* `frame` has been begun */
    base_error failure; /* of recording; returned by submit */
    VkQueryPool queries;
    uint32_t timed[GPU_VK_MAX_TIMED], timed_count; /* which pass each pair of queries measures */

    VkDescriptorPool *descriptor_pools;
    size_t descriptor_pool_count, descriptor_pool_capacity, descriptor_pool_current;
    VkSampler sampler;
    VkPipelineCache cache;
    char cache_path[4096]; /* "" = none */
    uint64_t cache_hash;   /* of what was read */

    vk_target *targets;
    size_t target_count, target_capacity;

    vk_block *blocks;
    vk_buffer staging; /* made at first use */
} vk;

/* vk_device.c: words a VkResult ("what: text"), remembers a lost device. VK_SUCCESS is STRATA_OK.
 */
strata_result vk_fail(vk *v, VkResult code, base_error *err, const char *what);
/* Ends a call: a validation message since the last report turns success into INTERNAL. */
strata_result vk_report(vk *v, strata_result result, base_error *err);
/* STRATA_OK, or DEVICE_LOST in err. */
strata_result vk_alive(const vk *v, base_error *err);
void vk_name(vk *v, VkObjectType type, uint64_t handle, const char *name);
strata_result vk_open(const gpu_open_info *info, void **self, gpu_backend_caps *caps,
                      base_error *err);
void vk_close(void *self);

/* vk_instance.c */
strata_result vk_instance_create(vk *v, base_error *err);
/* Picks the device that `wanted` names: an index among usable devices, a part of a name, NULL = the
 * first. */
strata_result vk_physical_choose(vk *v, const char *wanted, base_error *err);
void vk_enumerate(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                  void *user);
void vk_driver_text(VkPhysicalDevice physical, char *text, size_t size);

/* vk_features.c: what is enabled on the device; fills the caps that depend on it. */
strata_result vk_device_create(vk *v, gpu_backend_caps *caps, base_error *err);

/* vk_memory.c */
strata_result vk_memory_allocate(vk *v, const VkMemoryRequirements *needs, vk_memory_use use,
                                 vk_memory *out, base_error *err);
void vk_memory_free(vk *v, vk_memory *memory);
strata_result vk_buffer_init(vk *v, VkDeviceSize size, vk_memory_use use, vk_buffer *out,
                             base_error *err);
void vk_buffer_release(vk *v, vk_buffer *buffer);

/* vk_resource.c */
strata_result vk_buffer_create(void *self, const strata_buffer_desc *desc, void **native,
                               base_error *err);
void vk_buffer_destroy(void *self, void *native);
strata_result vk_image_create(void *self, const strata_image_desc *desc, void **native,
                              base_error *err);
void vk_image_destroy(void *self, void *native);
/* A clear value as the image's format wants it: integers are given as floats. */
VkClearColorValue vk_clear_color(const vk_image *image, const float value[4]);
uint32_t vk_clear_integer(float value); /* saturating; NaN and negative are 0 */
VkClearDepthStencilValue vk_clear_depth(const float value[4]);
VkAttachmentLoadOp vk_load_op(uint32_t load); /* STRATA_LOAD_* */

/* vk_transfer.c */
strata_result vk_buffer_read(void *self, void *native, uint64_t offset, uint64_t size, void *data,
                             base_error *err);
strata_result vk_buffer_write(void *self, void *native, uint64_t offset, uint64_t size,
                              const void *data, base_error *err);
strata_result vk_image_read(void *self, void *native, uint32_t layer, void *texels, size_t size,
                            base_error *err);
strata_result vk_image_write(void *self, void *native, uint32_t layer, uint32_t x, uint32_t y,
                             uint32_t width, uint32_t height, const void *texels, base_error *err);

/* vk_native.c */
uint64_t vk_native_handle(void *self, void *native, gpu_native_kind kind);
void *vk_get_proc(void *self, const char *name);

/* vk_program.c */
strata_result vk_program_create(void *self, const gpu_program_info *info, void **native,
                                base_error *err);
void vk_program_destroy(void *self, void *native);
VkDescriptorType vk_descriptor_type(gpu_binding_kind kind);
/* The pipeline of a pass that draws; made at first use, kept by the program. */
strata_result vk_pipeline_get(vk *v, vk_program *program, const gpu_native_pass *pass,
                              VkPipeline *out, base_error *err);

/* vk_ordered.c */

/* Bit i: the pass reads colour attachment i. */
uint32_t vk_reads(const gpu_native_pass *pass);
/* What such a pass draws into, valid until the next call; NULL after a failure. */
const vk_target *vk_target_get(vk *v, const gpu_native_pass *pass, base_error *err);
VkRenderPass vk_target_pass(const vk_target *target);
void vk_target_begin(VkCommandBuffer commands, const vk_target *target,
                     const gpu_native_pass *pass);
void vk_targets_forget(vk *v, const vk_image *image); /* NULL: all */

/* vk_cache.c */
void vk_cache_open(vk *v, const char *folder, const uint8_t uuid[VK_UUID_SIZE]);
void vk_cache_close(vk *v);

/* vk_submit.c: command buffers from begun to done. */
strata_result vk_commands_begin(vk *v, VkCommandBuffer commands, base_error *err);
strata_result vk_commands_run(vk *v, VkCommandBuffer commands, base_error *err);
strata_result vk_once_begin(vk *v, VkCommandBuffer *commands, base_error *err);
strata_result vk_once_run(vk *v, base_error *err);
void vk_full_barrier(VkCommandBuffer commands);
/* The frame's command buffer, begun if need be; NULL after a failure, which is kept. */
VkCommandBuffer vk_frame_commands(vk *v);
VkDescriptorSet vk_descriptor_set(vk *v, const vk_program *program, base_error *err);
void vk_begin(void *self);
strata_result vk_submit(void *self, double *ms, uint32_t timing_count, base_error *err);

/* vk_record.c */
void vk_pass(void *self, const gpu_native_pass *pass);
void vk_fill(void *self, void *buffer, uint64_t offset, uint64_t size, uint32_t value,
             const gpu_barrier *barriers, uint32_t barrier_count);
void vk_copy(void *self, void *to, uint64_t to_offset, void *from, uint64_t from_offset,
             uint64_t size, const gpu_barrier *barriers, uint32_t barrier_count);
void vk_clear_image(void *self, void *image, const float value[4], const gpu_barrier *barriers,
                    uint32_t barrier_count);

#endif
