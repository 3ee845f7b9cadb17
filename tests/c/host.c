// A host in C: brings up Vulkan by itself, makes depth of a plane and a box on the CPU, has Umbrage record into its command
// buffer and compares the mask with the analytic shadow. Under validation; exit code 1 for any difference or message.
#include "umbrage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 240, PIXELS = WIDTH * HEIGHT, INDEX_ROOM = 1 << 16 };

static int failures = 0;

static void fail(const char *what, const char *more) {
    fprintf(stderr, "FAILED: %s: %s\n", what, more);
    failures++;
}

// Ends the program where nothing further makes sense.
#define CHECK(call)                                                                                                  \
    do {                                                                                                             \
        int result_ = (int)(call);                                                                                   \
        if (result_ != 0) {                                                                                          \
            fprintf(stderr, "FAILED: %s: %d, %s\n", #call, result_, umbrage_last_error());                           \
            exit(1);                                                                                                 \
        }                                                                                                            \
    } while (0)

// The call must be refused with this code, and the message must have this word in it.
#define REFUSED(call, code, word)                                                                                    \
    do {                                                                                                             \
        UmbrageResult result_ = (call);                                                                              \
        const char *text_ = umbrage_last_error();                                                                    \
        if (result_ != (code) || !strstr(text_, word)) fail(#call, text_);                                           \
    } while (0)

// The scene, relative to its origin; the plane is y = 0.
static const double ORIGIN[3] = {1000.0, -20.0, 500.0};
static const double PLANE_REACH = 8.0;
static const double BOX[2][3] = {{-1.0, 0.75, -1.5}, {1.5, 2.5, 1.0}};

// The camera: reversed depth to infinity, off centre.
static const double EYE[3] = {4.0, 4.0, 5.5};
static const double NEAR_PLANE = 0.1, FOCAL = 1.5, SHIFT_X = 0.1, SHIFT_Y = -0.05;

typedef struct { double t; int surface; double normal[3], place[3]; } Hit;

// Where a ray enters the box; t is negative where it does not.
static Hit hit_box(const double from[3], const double along[3]) {
    Hit hit = {-1.0, 0, {0}, {0}};
    double enter = -1e30, leave = 1e30;
    int axis = 0;
    for (int i = 0; i < 3; i++) {
        double a = (BOX[0][i] - from[i]) / along[i], b = (BOX[1][i] - from[i]) / along[i];
        if (fmin(a, b) > enter) enter = fmin(a, b), axis = i;
        leave = fmin(leave, fmax(a, b));
    }
    if (enter > leave || leave < 0.0) return hit;
    double sign = along[axis] > 0.0 ? -1.0 : 1.0;
    hit.t = enter;
    hit.surface = 2 + 2 * axis + (sign > 0.0);
    hit.normal[axis] = sign;
    return hit;
}

// The nearest surface; 0 for none, 1 for the plane.
static Hit hit_scene(const double from[3], const double along[3]) {
    Hit hit = hit_box(from, along);
    double t = -from[1] / along[1], x = from[0] + t * along[0], z = from[2] + t * along[2];
    if (t > 0.0 && fabs(x) < PLANE_REACH && fabs(z) < PLANE_REACH && (hit.t < 0.0 || t < hit.t)) {
        Hit plane = {t, 1, {0.0, 1.0, 0.0}, {0}};
        return plane;
    }
    return hit;
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalize(double v[3]) {
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) v[i] /= length;
}

static UmbrageFrameInput camera(void) {
    UmbrageFrameInput input;
    memset(&input, 0, sizeof input);
    const double up[3] = {0.0, 1.0, 0.0};
    double (*rows)[3] = input.view_from_world;
    for (int i = 0; i < 3; i++) rows[2][i] = EYE[i] - (i == 1 ? 0.75 : 0.0);
    normalize(rows[2]);
    cross(up, rows[2], rows[0]);
    normalize(rows[0]);
    cross(rows[2], rows[0], rows[1]);
    input.clip_from_view[0][0] = FOCAL * HEIGHT / WIDTH;
    input.clip_from_view[0][2] = SHIFT_X;
    input.clip_from_view[1][1] = -FOCAL;
    input.clip_from_view[1][2] = SHIFT_Y;
    input.clip_from_view[2][3] = NEAR_PLANE;
    input.clip_from_view[3][2] = -1.0;
    for (int i = 0; i < 3; i++) {
        input.origin[i] = ORIGIN[i];
        input.eye[i] = ORIGIN[i] + EYE[i];
    }
    return input;
}

// What each pixel sees; t is the distance along the view direction.
static void look(const UmbrageFrameInput *input, Hit *hits) {
    for (int p = 0; p < PIXELS; p++) {
        double x = 2.0 * (p % WIDTH + 0.5) / WIDTH - 1.0, y = 2.0 * (p / WIDTH + 0.5) / HEIGHT - 1.0, along[3];
        double view[3] = {(x + SHIFT_X) / input->clip_from_view[0][0], (y + SHIFT_Y) / -FOCAL, -1.0};
        for (int i = 0; i < 3; i++) {
            along[i] = 0.0;
            for (int j = 0; j < 3; j++) along[i] += input->view_from_world[j][i] * view[j];
        }
        hits[p] = hit_scene(EYE, along);
        for (int i = 0; i < 3; i++) hits[p].place[i] = EYE[i] + hits[p].t * along[i];
    }
}

// Whether the sun reaches what a pixel sees; nothing shadows the box but itself.
static int lit(const Hit *hit, const double sun[3]) {
    const double against[3] = {-sun[0], -sun[1], -sun[2]};
    if (hit->surface == 0) return 1;
    if (hit->surface == 1) return hit_box(hit->place, against).t < 0.0;
    return dot(hit->normal, against) > 0.0;
}

// Differences between the mask and the analytic answer, more than two pixels away from any edge.
static void compare(const char *what, const Hit *hits, const double sun[3], const float *mask) {
    int checked[2] = {0, 0}, wrong = 0;
    for (int y = 2; y < HEIGHT - 2; y++) {
        for (int x = 2; x < WIDTH - 2; x++) {
            const Hit *hit = &hits[y * WIDTH + x];
            int want = lit(hit, sun), same = hit->surface != 0;
            for (int i = 0; i < 25 && same; i++) {
                const Hit *other = &hits[(y + i / 5 - 2) * WIDTH + x + i % 5 - 2];
                same = other->surface == hit->surface && lit(other, sun) == want;
            }
            if (!same) continue;
            checked[want]++;
            wrong += mask[y * WIDTH + x] != (float)want;
        }
    }
    printf("%s: %d lit and %d shadowed pixels checked, %d wrong\n", what, checked[1], checked[0], wrong);
    if (wrong || checked[0] < 2000 || checked[1] < 10000) fail(what, "not the analytic mask");
}

static VkBool32 VKAPI_PTR on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT type,
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
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
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
    if (rays == UMBRAGE_OK ? !all : rays != UMBRAGE_ERROR_UNSUPPORTED || name_count) fail("ray queries", umbrage_last_error());

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
    while (!(needs.memoryTypeBits >> type & 1) || (properties.memoryTypes[type].propertyFlags & wanted) != wanted) type++;
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size, .memoryTypeIndex = type};
    CHECK(vkAllocateMemory(device, &info, NULL, &memories[memory_count]));
    return memories[memory_count++];
}

// A buffer that the CPU sees; `mapped` may be null.
static VkBuffer buffer(const void *bytes, size_t size, size_t room, VkBufferUsageFlags usage, void **mapped) {
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size + room, .usage = usage};
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
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, NULL, 0, NULL,
                         1, &barrier);
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
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL, 0,
                         NULL);
}

// The plane and the box, cut into clusters by Umbrage.
static UmbrageScene make_scene(void) {
    const float reach = (float)PLANE_REACH;
    float positions[12][3] = {{-reach, 0, -reach}, {-reach, 0, reach}, {reach, 0, reach}, {reach, 0, -reach}};
    for (int i = 0; i < 8; i++) {
        // of unit size around zero: its instance places it
        for (int axis = 0; axis < 3; axis++) positions[4 + i][axis] = i >> axis & 1 ? 0.5f : -0.5f;
    }
    const uint32_t plane[] = {0, 1, 2, 0, 2, 3};
    uint32_t box[36], n = 0;
    for (uint32_t axis = 0; axis < 3; axis++) {
        for (uint32_t side = 0; side < 2; side++) {
            uint32_t u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, first = 4 + (side << axis);
            const uint32_t corners[] = {first, first + u, first + u + v, first, first + u + v, first + v};
            for (int i = 0; i < 6; i++) box[n++] = corners[i];
        }
    }
    const UmbrageTriangles triangles[] = {{plane, 6}, {box, 36}};
    UmbrageMeshes *meshes = NULL;
    UmbrageMeshData data;
    CHECK(umbrage_meshes_create((const float(*)[3])positions, 12, triangles, 2, &meshes));
    CHECK(umbrage_meshes_data(meshes, &data));

    UmbrageInstance instances[2];
    double rows[2][3][4] = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, {{0}}};
    for (int i = 0; i < 3; i++) {
        rows[1][i][i] = BOX[1][i] - BOX[0][i];
        rows[1][i][3] = 0.5 * (BOX[0][i] + BOX[1][i]);
    }
    for (uint32_t i = 0; i < 2; i++) CHECK(umbrage_instance_init(&instances[i], (const double(*)[4])rows[i], i, 0));
    UmbrageMaterial material;
    CHECK(umbrage_material_init(&material));
    const UmbrageAttributes attributes[12] = {{{0, 0}, 0xffffffff}};
    const uint32_t texel = 0xffffffff;

    const VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vertex = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    UmbrageScene scene = {
        .struct_size = sizeof scene,
        .positions = buffer(positions, sizeof positions, 0, storage | vertex, NULL),
        .attributes = buffer(attributes, sizeof attributes, 0, storage | vertex, NULL),
        .indices = buffer(data.indices, data.index_count * 4, INDEX_ROOM * 4, storage | VK_BUFFER_USAGE_INDEX_BUFFER_BIT, NULL),
        .clusters = buffer(data.clusters, data.cluster_count * sizeof *data.clusters, 0, storage, NULL),
        .meshlets = buffer(data.meshlets, data.meshlet_word_count * 4, 0, storage, NULL),
        .instances = buffer(instances, sizeof instances, 0, storage, NULL),
        .meshes = buffer(data.meshes, data.mesh_count * sizeof *data.meshes, 0, storage, NULL),
        .materials = buffer(&material, sizeof material, 0, storage, NULL),
        .texels = buffer(&texel, sizeof texel, 0, storage, NULL),
        .index_count = (uint32_t)data.index_count,
        .instance_count = 2,
        .bounds_min = {-PLANE_REACH, -0.1, -PLANE_REACH},
        .bounds_max = {PLANE_REACH, 3.0, PLANE_REACH},
    };
    CHECK(umbrage_meshes_caster_count(meshes, instances, 2, &scene.caster_count));
    umbrage_meshes_destroy(meshes);
    return scene;
}

// What an engine must not be made of.
static void refused_engines(const UmbrageDevice *host, const UmbrageConfig *config, const UmbrageScene *scene,
                            const UmbrageView *view) {
    UmbrageEngine *engine = NULL;
    UmbrageConfig other = *config;
    REFUSED(umbrage_engine_create(NULL, config, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "device is a null");
    REFUSED(umbrage_engine_create(host, NULL, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "config is a null");
    REFUSED(umbrage_engine_create(host, config, NULL, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "scene is a null");
    REFUSED(umbrage_engine_create(host, config, scene, NULL, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "views is a null");
    REFUSED(umbrage_engine_create(host, config, scene, view, 1, NULL), UMBRAGE_ERROR_ARGUMENT, "engine is a null");
    REFUSED(umbrage_engine_create(host, config, scene, view, 0, &engine), UMBRAGE_ERROR_LIMIT, "views is 0");
    other.page_texels = 100;
    REFUSED(umbrage_engine_create(host, &other, scene, view, 1, &engine), UMBRAGE_ERROR_LIMIT, "page_texels is 100");
    other = *config;
    other.filter = 9;
    REFUSED(umbrage_engine_create(host, &other, scene, view, 1, &engine), UMBRAGE_ERROR_LIMIT, "filter is 9");
    other = *config;
    other.struct_size = 8;
    REFUSED(umbrage_engine_create(host, &other, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "size of the config");
    UmbrageScene empty = *scene;
    empty.positions = VK_NULL_HANDLE;
    REFUSED(umbrage_engine_create(host, config, &empty, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "positions is a null");
    UmbrageView blind = *view;
    blind.image_count = 0;
    REFUSED(umbrage_engine_create(host, config, scene, &blind, 1, &engine), UMBRAGE_ERROR_LIMIT, "images of a view");
    UmbrageDevice nothing = *host;
    nothing.device = VK_NULL_HANDLE;
    REFUSED(umbrage_engine_create(&nothing, config, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "device's handle");
    nothing = *host;
    nothing.get_instance_proc_addr = NULL;
    REFUSED(umbrage_engine_create(&nothing, config, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "proc_addr");
    nothing = *host;
    nothing.ray_query = VK_TRUE;
    REFUSED(umbrage_engine_create(&nothing, config, scene, view, 1, &engine), UMBRAGE_ERROR_UNSUPPORTED, "ray queries");
    if (engine) fail("create", "an engine that was refused");
}

// Lights, frames and views that there are not; the commands are recording.
static void refused_calls(UmbrageEngine *engine, const UmbrageFrameInput *input, UmbrageLight light) {
    UmbrageFrameInput inputs[2] = {*input, *input};
    UmbrageLightId id = 0, none = 0;
    UmbrageCounters counters;
    VkImage image;
    VkImageView view;
    uint64_t frame = 77;
    REFUSED(umbrage_add_light(engine, &light, &none), UMBRAGE_ERROR_LIMIT, "lights is 3");
    REFUSED(umbrage_set_light(engine, 0, &light), UMBRAGE_ERROR_LIMIT, "light id");
    REFUSED(umbrage_remove_light(engine, UINT64_MAX), UMBRAGE_ERROR_LIMIT, "light id");
    light.kind = 3;
    REFUSED(umbrage_add_light(engine, &light, &none), UMBRAGE_ERROR_LIMIT, "kind of light is 3");
    light.kind = UMBRAGE_LIGHT_POINT;
    REFUSED(umbrage_add_light(NULL, &light, &id), UMBRAGE_ERROR_ARGUMENT, "engine is a null");
    REFUSED(umbrage_record(engine, commands, inputs, 2, &frame), UMBRAGE_ERROR_LIMIT, "views is 2");
    REFUSED(umbrage_record(engine, commands, NULL, 1, &frame), UMBRAGE_ERROR_ARGUMENT, "inputs is a null");
    REFUSED(umbrage_record(engine, VK_NULL_HANDLE, inputs, 1, &frame), UMBRAGE_ERROR_ARGUMENT, "commands is a null");
    inputs[0].images = 1;
    REFUSED(umbrage_record(engine, commands, inputs, 1, &frame), UMBRAGE_ERROR_LIMIT, "images of a view is 1");
    REFUSED(umbrage_counters(engine, 0, &counters, sizeof counters), UMBRAGE_ERROR_LIMIT, "frame is 0");
    REFUSED(umbrage_counters(engine, 1, &counters, sizeof counters), UMBRAGE_ERROR_LIMIT, "frame is 1");
    REFUSED(umbrage_mask(engine, 1, &image, &view), UMBRAGE_ERROR_LIMIT, "view is 1");
    REFUSED(umbrage_resize(engine, NULL, 0), UMBRAGE_ERROR_LIMIT, "views is 0");
    if (none || id || frame != 77) fail("outputs", "changed by calls that were refused");
}

// Device memory by purpose adds up to something.
static void report(const UmbrageEngine *engine) {
    uint32_t count = 0, one = 1;
    UmbrageMemory memory[32];
    CHECK(umbrage_memory(engine, NULL, &count));
    REFUSED(umbrage_memory(engine, memory, &one), UMBRAGE_ERROR_LIMIT, "count is 1");
    if (count < 3 || count > 32 || one != count) fail("memory", "count");
    CHECK(umbrage_memory(engine, memory, &count));
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += memory[i].bytes;
    printf("%u purposes, the first %s, %u MiB\n", count, memory[0].purpose, (unsigned)(sum >> 20));
    if (sum < (16u << 20) || !memory[0].purpose[0]) fail("memory", "the atlas is not in it");
}

int main(void) {
    VkDebugUtilsMessengerEXT messenger = bring_up_instance();
    UmbrageDevice host = bring_up_device();
    const UmbrageScene scene = make_scene();
    const UmbrageFrameInput input = camera();

    static Hit hits[PIXELS];
    static float depths[PIXELS];
    look(&input, hits);
    for (int p = 0; p < PIXELS; p++) depths[p] = hits[p].surface ? (float)(NEAR_PLANE / hits[p].t) : 0.0f;
    float *mask;
    VkBuffer staging = buffer(depths, sizeof depths, 0, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, NULL);
    VkBuffer result = buffer(NULL, sizeof depths, 0, VK_BUFFER_USAGE_TRANSFER_DST_BIT, (void **)&mask);

    UmbrageReceiverImages images = {
        .depth = {
            .format = VK_FORMAT_D32_SFLOAT,
            .samples = VK_SAMPLE_COUNT_1_BIT,
            .used = {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT},
        },
    };
    images.depth.image = depth_image(&images.depth.view);
    const UmbrageView view = {
        .width = WIDTH,
        .height = HEIGHT,
        .images = &images,
        .image_count = 1,
        .mask = {VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT},
    };
    UmbrageConfig config;
    CHECK(umbrage_config_default(&config, sizeof config, WIDTH, HEIGHT));
    config.atlas_bytes = 16 << 20;
    config.index_capacity = INDEX_ROOM;
    config.cull_group = 16;
    config.lights = 2;
    refused_engines(&host, &config, &scene, &view);
    UmbrageEngine *engine = NULL;
    CHECK(umbrage_engine_create(&host, &config, &scene, &view, 1, &engine));

    // the first light is removed again: its id is stale, and the sun has its slot
    UmbrageLight sun = {.kind = UMBRAGE_LIGHT_DIRECTIONAL, .direction = {-0.5, -1.0, 0.3}};
    UmbrageLight point = {.kind = UMBRAGE_LIGHT_POINT, .position = {1000.0, -10.0, 500.0}, .range = 20.0};
    UmbrageLightId stale, id, other;
    CHECK(umbrage_add_light(engine, &sun, &stale));
    CHECK(umbrage_remove_light(engine, stale));
    CHECK(umbrage_add_light(engine, &sun, &id));
    CHECK(umbrage_add_light(engine, &point, &other));
    if (id == stale || umbrage_light_slot(id) != 0 || umbrage_light_slot(other) != 1) fail("lights", "ids or slots");
    REFUSED(umbrage_set_light(engine, stale, &sun), UMBRAGE_ERROR_LIMIT, "light id is 0 (1)");
    REFUSED(umbrage_remove_light(engine, stale), UMBRAGE_ERROR_LIMIT, "light id");

    // depth and normals that Umbrage draws, in place of the CPU's
    UmbragePrepass *prepass = NULL;
    UmbrageReceiverImages drawn;
    const UmbrageMeshDraw draws[] = {{6, 0, 1, 0, VK_FALSE}, {36, 6, 1, 1, VK_FALSE}};
    REFUSED(umbrage_prepass_create(&host, &scene, 0, HEIGHT, &prepass), UMBRAGE_ERROR_LIMIT, "size is 0x240");
    REFUSED(umbrage_prepass_images(prepass, &drawn), UMBRAGE_ERROR_ARGUMENT, "prepass is a null");
    CHECK(umbrage_prepass_create(&host, &scene, WIDTH, HEIGHT, &prepass));
    CHECK(umbrage_prepass_images(prepass, &drawn));
    UmbrageView own = view;
    own.images = &drawn;

    const char *names[] = {"first frame", "another sun", "after a resize", "own prepass"};
    for (int i = 0; i < 4; i++) {
        VkImage image;
        VkImageView image_view;
        UmbrageCounters counters;
        uint64_t frame = 0;
        if (i == 1) {
            sun.direction[0] = 0.6;
            sun.direction[2] = -0.4;
            CHECK(umbrage_set_light(engine, id, &sun));
            CHECK(umbrage_remove_light(engine, other));
        }
        if (i == 2) {
            CHECK(umbrage_resize(engine, &view, 1));
            CHECK(umbrage_forget(engine));
        }
        if (i == 3) CHECK(umbrage_resize(engine, &own, 1));
        CHECK(umbrage_mask(engine, 0, &image, &image_view));
        begin();
        if (i == 0) {
            refused_calls(engine, &input, sun);
            upload(staging, images.depth.image);
        }
        if (i == 3) CHECK(umbrage_prepass_record(prepass, commands, &input, draws, 2));
        CHECK(umbrage_record(engine, commands, &input, 1, &frame));
        read_back(image, result);
        submit();
        compare(names[i], hits, sun.direction, mask);
        CHECK(umbrage_counters(engine, frame, &counters, sizeof counters));
        REFUSED(umbrage_counters(engine, frame, &counters, 4), UMBRAGE_ERROR_ARGUMENT, "size of the counters");
        if (frame != (uint64_t)i + 1 || !counters.leaves || (i % 2 == 0 && !counters.drawn)) fail("counters", names[i]);
        CHECK(umbrage_steer(engine, frame, 5.0, 1.0));
    }
    report(engine);

    umbrage_engine_destroy(engine);
    umbrage_prepass_destroy(prepass);
    vkDestroyImageView(device, images.depth.view, NULL);
    vkDestroyImage(device, images.depth.image, NULL);
    for (uint32_t i = 0; i < buffer_count; i++) vkDestroyBuffer(device, buffers[i], NULL);
    for (uint32_t i = 0; i < memory_count; i++) vkFreeMemory(device, memories[i], NULL);
    vkDestroyCommandPool(device, pool, NULL);
    vkDestroyDevice(device, NULL);
    PFN_vkDestroyDebugUtilsMessengerEXT destroy =
        (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT");
    destroy(instance, messenger, NULL);
    vkDestroyInstance(instance, NULL);
    printf("%s\n", failures ? "FAILED" : "passed");
    return failures != 0;
}
