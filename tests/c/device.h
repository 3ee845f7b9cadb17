// The host's own Vulkan: a device with what Umbrage needs, buffers, a depth image, one command buffer.
#pragma once
#include "analytic.h"
#include "check.h"
#include "umbrage.h"

static VkBool32 VKAPI_PTR on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                     VkDebugUtilsMessageTypeFlagsEXT type,
                                     const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    (void)severity, (void)type, (void)user;
    fail("validation", data->pMessage);
    return VK_FALSE;
}

static VkInstance instance;
static VkPhysicalDevice physical_device;
static VkDevice device;
static VkQueue queue;
static VkCommandPool pool;
static VkCommandBuffer commands;
static VkDeviceMemory memories[32];
static VkBuffer buffers[32];
static uint32_t memory_count = 0, buffer_count = 0;

static VkDebugUtilsMessengerEXT bring_up_instance(void) {
    const VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    const VkValidationFeatureEnableEXT enable = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkDebugUtilsMessengerCreateInfoEXT messages = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = on_message,
    };
    const VkValidationFeaturesEXT validation = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .pNext = &messages,
        .enabledValidationFeatureCount = 1,
        .pEnabledValidationFeatures = &enable,
    };
    const char *layer = "VK_LAYER_KHRONOS_validation", *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = &validation,
        .pApplicationInfo = &app,
        .enabledLayerCount = 1,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = 1,
        .ppEnabledExtensionNames = &extension,
    };
    CHECK(vkCreateInstance(&info, NULL, &instance));
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT");
    VkDebugUtilsMessengerEXT messenger;
    CHECK(create(instance, &messages, NULL, &messenger));
    return messenger;
}

// The first device on which Umbrage runs, with what Umbrage needs switched on.
static UmbrageDevice bring_up_device(void) {
    VkPhysicalDevice devices[16];
    uint32_t count = 16, family = 0;
    vkEnumeratePhysicalDevices(instance, &count, devices);
    UmbrageDevice host = {
        .struct_size = sizeof host,
        .get_instance_proc_addr = vkGetInstanceProcAddr,
        .instance = instance,
        .debug_utils = VK_TRUE,
    };
    UmbrageResult found = UMBRAGE_ERROR_UNSUPPORTED;
    for (uint32_t i = 0; i < count && found != UMBRAGE_OK; i++) {
        host.physical_device = physical_device = devices[i];
        found = umbrage_check_device(&host);
    }
    CHECK(found);

    VkPhysicalDeviceFeatures features = {.samplerAnisotropy = VK_FALSE};
    VkPhysicalDeviceVulkan12Features vulkan12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceVulkan13Features vulkan13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    REFUSED(umbrage_enable_features(&host, &features, &vulkan12, NULL), UMBRAGE_ERROR_ARGUMENT, "vulkan13");
    vulkan13.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    REFUSED(umbrage_enable_features(&host, &features, &vulkan12, &vulkan13), UMBRAGE_ERROR_LIMIT, "sType");
    vulkan13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    vulkan12.pNext = &vulkan13;
    vulkan12.timelineSemaphore = VK_TRUE; // of the host itself; stays on
    CHECK(umbrage_enable_features(&host, &features, &vulkan12, &vulkan13));
    if (!vulkan12.timelineSemaphore || vulkan12.pNext != &vulkan13) fail("enable", "the host's own features are gone");
    if (!features.multiDrawIndirect || !features.drawIndirectFirstInstance || !vulkan12.shaderOutputLayer ||
        !vulkan13.dynamicRendering || !vulkan13.synchronization2 || features.wideLines || vulkan13.maintenance4)
        fail("enable", "not what is needed");

    VkPhysicalDeviceAccelerationStructureFeaturesKHR structure = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceRayQueryFeaturesKHR query = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
    VkPhysicalDeviceVulkan12Features copy = vulkan12;
    const char *const *names = NULL;
    uint32_t name_count = 0;
    UmbrageResult rays = umbrage_enable_ray_queries(&host, &copy, &structure, &query, &names, &name_count);
    int all = name_count == 3 && strcmp(names[1], VK_KHR_RAY_QUERY_EXTENSION_NAME) == 0 && query.rayQuery;
    if (rays == UMBRAGE_OK ? !all : rays != UMBRAGE_ERROR_UNSUPPORTED || name_count)
        fail("ray queries", umbrage_last_error());
    if (rays == UMBRAGE_OK) {
        vulkan12 = copy;
        vulkan13.pNext = &structure;
        structure.pNext = &query;
        host.ray_query = VK_TRUE;
    }
    printf("%s\n", host.ray_query ? "ray queries: on" : umbrage_last_error());

    VkQueueFamilyProperties families[16];
    count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, families);
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    while (family < count && (families[family].queueFlags & wanted) != wanted) family++;
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queues = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueFamilyIndex = family,
        .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    const VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &vulkan12,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queues,
        .enabledExtensionCount = name_count,
        .ppEnabledExtensionNames = names,
        .pEnabledFeatures = &features,
    };
    CHECK(vkCreateDevice(physical_device, &info, NULL, &device));
    vkGetDeviceQueue(device, family, 0, &queue);
    const VkCommandPoolCreateInfo pools = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
        .queueFamilyIndex = family,
    };
    CHECK(vkCreateCommandPool(device, &pools, NULL, &pool));
    const VkCommandBufferAllocateInfo one = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = pool, .commandBufferCount = 1};
    CHECK(vkAllocateCommandBuffers(device, &one, &commands));
    host.device = device;
    return host;
}

static VkDeviceMemory allocate(VkMemoryRequirements needs, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties properties;
    vkGetPhysicalDeviceMemoryProperties(physical_device, &properties);
    uint32_t type = 0;
    while (!(needs.memoryTypeBits >> type & 1) || (properties.memoryTypes[type].propertyFlags & wanted) != wanted)
        type++;
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size, .memoryTypeIndex = type};
    CHECK(vkAllocateMemory(device, &info, NULL, &memories[memory_count]));
    return memories[memory_count++];
}

// A buffer that the CPU sees; `mapped` may be null.
static VkBuffer buffer(const void *bytes, size_t size, size_t room, VkBufferUsageFlags usage, void **mapped) {
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size + room, .usage = usage};
    VkBuffer made;
    VkMemoryRequirements needs;
    void *to;
    CHECK(vkCreateBuffer(device, &info, NULL, &made));
    buffers[buffer_count++] = made;
    vkGetBufferMemoryRequirements(device, made, &needs);
    VkDeviceMemory memory = allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    CHECK(vkBindBufferMemory(device, made, memory, 0));
    CHECK(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &to));
    if (bytes) memcpy(to, bytes, size);
    if (mapped) *mapped = to;
    return made;
}

static VkImage depth_image(VkImageView *view) {
    const VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = VK_FORMAT_D32_SFLOAT,
        .extent = {WIDTH, HEIGHT, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
    };
    VkImage image;
    VkMemoryRequirements needs;
    CHECK(vkCreateImage(device, &info, NULL, &image));
    vkGetImageMemoryRequirements(device, image, &needs);
    CHECK(vkBindImageMemory(device, image, allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT), 0));
    const VkImageViewCreateInfo views = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = image,
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = info.format,
        .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1},
    };
    CHECK(vkCreateImageView(device, &views, NULL, view));
    return image;
}

static void begin(void) {
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    CHECK(vkBeginCommandBuffer(commands, &info));
}

static void submit(void) {
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    CHECK(vkEndCommandBuffer(commands));
    CHECK(vkQueueSubmit(queue, 1, &info, VK_NULL_HANDLE));
    CHECK(vkQueueWaitIdle(queue));
}

static VkBufferImageCopy whole(VkImageAspectFlags aspect) {
    const VkBufferImageCopy copy = {.imageSubresource = {aspect, 0, 0, 1}, .imageExtent = {WIDTH, HEIGHT, 1}};
    return copy;
}

static void upload(VkBuffer from, VkImage to) {
    const VkImageMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .oldLayout = VK_IMAGE_LAYOUT_UNDEFINED,
        .newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = to,
        .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1},
    };
    const VkBufferImageCopy copy = whole(VK_IMAGE_ASPECT_DEPTH_BIT);
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, NULL, 0,
                         NULL, 1, &barrier);
    vkCmdCopyBufferToImage(commands, from, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
}

static void read_back(VkImage from, VkBuffer to) {
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_HOST_READ_BIT,
    };
    const VkBufferImageCopy copy = whole(VK_IMAGE_ASPECT_COLOR_BIT);
    vkCmdCopyImageToBuffer(commands, from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to, 1, &copy);
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL,
                         0, NULL);
}

static void take_down(VkDebugUtilsMessengerEXT messenger) {
    for (uint32_t i = 0; i < buffer_count; i++) vkDestroyBuffer(device, buffers[i], NULL);
    for (uint32_t i = 0; i < memory_count; i++) vkFreeMemory(device, memories[i], NULL);
    vkDestroyCommandPool(device, pool, NULL);
    vkDestroyDevice(device, NULL);
    PFN_vkDestroyDebugUtilsMessengerEXT destroy =
        (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT");
    destroy(instance, messenger, NULL);
    vkDestroyInstance(instance, NULL);
}
