/* SPDX-License-Identifier: MIT
 *
 * The Vulkan instance, the validation layer that listens to everything made from it, and the choice
 * of a physical device. A device is usable when it speaks Vulkan 1.3.
 */
#define _GNU_SOURCE /* strcasestr */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

#define VALIDATION_LAYER "VK_LAYER_KHRONOS_validation"
#define MAX_DEVICES      16u

/* ---- validation ------------------------------------------------------------------------- */

/* May run on any thread that calls Vulkan, the driver's own among them. */
static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data,
                                                 void *user) {
    vk *v = user;
    (void)types;
    base_log(BASE_LOG_INFO, "vulkan %s: %s",
             severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? "error" : "warning",
             data->pMessage);
    pthread_mutex_lock(&v->message_lock);
    if (!v->message[0])
        snprintf(v->message, sizeof v->message, "%s", data->pMessage);
    pthread_mutex_unlock(&v->message_lock);
    return VK_FALSE;
}

static int layer_present(void) {
    uint32_t count = 0;
    if (vkEnumerateInstanceLayerProperties(&count, NULL) != VK_SUCCESS || !count)
        return 0;
    VkLayerProperties *layers = base_calloc(count, sizeof *layers);
    int found = 0;
    if (layers && vkEnumerateInstanceLayerProperties(&count, layers) >= VK_SUCCESS)
        for (uint32_t i = 0; i < count; i++)
            found |= !strcmp(layers[i].layerName, VALIDATION_LAYER);
    free(layers);
    return found;
}

static strata_result listen(vk *v, base_error *err) {
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(v->instance,
                                                                  "vkCreateDebugUtilsMessengerEXT");
    const VkDebugUtilsMessengerCreateInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = v};
    if (!create)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "no debug messenger");
    return vk_fail(v, create(v->instance, &info, NULL, &v->messenger), err, "messenger");
}

/* ---- the instance ----------------------------------------------------------------------- */

static VkResult instance_create(int check, VkInstance *out) {
    const VkValidationFeatureEnableEXT enables[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                              .enabledValidationFeatureCount = BASE_COUNT(enables),
                                              .pEnabledValidationFeatures = enables};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .pApplicationName = "strata",
                                           .pEngineName = "strata",
                                           .apiVersion = VK_API_VERSION_1_3};
    const char *layers[] = {VALIDATION_LAYER};
    const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pNext = check ? &features : NULL,
                                       .pApplicationInfo = &application,
                                       .enabledLayerCount = check ? BASE_COUNT(layers) : 0,
                                       .ppEnabledLayerNames = layers,
                                       .enabledExtensionCount = check ? BASE_COUNT(extensions) : 0,
                                       .ppEnabledExtensionNames = extensions};
    return vkCreateInstance(&info, NULL, out);
}

strata_result vk_instance_create(vk *v, base_error *err) {
    if (v->check && !layer_present())
        return base_fail(err, STRATA_ERROR_UNSUPPORTED,
                         "checking needs the layer " VALIDATION_LAYER ", which is not installed");
    VkResult code = instance_create(v->check, &v->instance);
    if (code == VK_ERROR_INCOMPATIBLE_DRIVER)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "no driver is installed");
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, "instance");
    return v->check ? listen(v, err) : STRATA_OK;
}

/* ---- physical devices ------------------------------------------------------------------- */

void vk_driver_text(VkPhysicalDevice physical, char *text, size_t size) {
    VkPhysicalDeviceDriverProperties driver = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                       .pNext = &driver};
    vkGetPhysicalDeviceProperties2(physical, &all);
    snprintf(text, size, "%.120s %.120s", driver.driverName, driver.driverInfo);
}

/* Usable devices in the loader's order: what an index counts. */
static strata_result usable(VkInstance instance, VkPhysicalDevice found[MAX_DEVICES],
                            uint32_t *count, base_error *err) {
    VkPhysicalDevice all[MAX_DEVICES];
    uint32_t all_count = MAX_DEVICES;
    *count = 0;
    VkResult code = vkEnumeratePhysicalDevices(instance, &all_count, all);
    if (code < VK_SUCCESS)
        return vk_fail(NULL, code, err, "devices");
    for (uint32_t i = 0; i < all_count; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(all[i], &properties);
        if (properties.apiVersion >= VK_API_VERSION_1_3)
            found[(*count)++] = all[i];
    }
    return STRATA_OK;
}

/* Whole text is a number: an index. */
static int as_index(const char *text, uint32_t *index) {
    char *end = NULL;
    if (!isdigit((unsigned char)text[0]))
        return 0;
    unsigned long value = strtoul(text, &end, 10);
    *index = value < MAX_DEVICES ? (uint32_t)value : MAX_DEVICES;
    return !*end;
}

strata_result vk_physical_choose(vk *v, const char *wanted, base_error *err) {
    VkPhysicalDevice found[MAX_DEVICES];
    uint32_t count, index = 0;
    strata_result result = usable(v->instance, found, &count, err);
    if (result != STRATA_OK)
        return result;
    if (!count)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "no device speaks Vulkan 1.3");
    if (wanted && wanted[0] && !as_index(wanted, &index))
        for (index = 0; index < count; index++) {
            VkPhysicalDeviceProperties properties;
            vkGetPhysicalDeviceProperties(found[index], &properties);
            if (strcasestr(properties.deviceName, wanted))
                break;
        }
    if (index >= count)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "no device \"%.100s\" among the %u found",
                         wanted, count);
    v->physical = found[index];
    return STRATA_OK;
}

void vk_enumerate(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                  void *user) {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice devices[MAX_DEVICES];
    uint32_t count = 0;
    if (instance_create(0, &instance) != VK_SUCCESS)
        return;
    if (usable(instance, devices, &count, NULL) == STRATA_OK)
        for (uint32_t i = 0; i < count; i++) {
            gpu_device_info info = {.backend = "vulkan"};
            VkPhysicalDeviceProperties properties;
            vkGetPhysicalDeviceProperties(devices[i], &properties);
            snprintf(info.name, sizeof info.name, "%s", properties.deviceName);
            vk_driver_text(devices[i], info.driver, sizeof info.driver);
            found(user, &info, i);
        }
    vkDestroyInstance(instance, NULL);
}
