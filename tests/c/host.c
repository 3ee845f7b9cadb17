// A host in C: brings up Vulkan by itself, makes depth of a plane and a box on the CPU, has Umbrage record into its
// command buffer and compares the mask with the analytic shadow. Under validation; exit code 1 for any difference or
// message.
#include "analytic.h"
#include "casters.h"
#include "check.h"
#include "device.h"
#include "umbrage.h"

enum { INDEX_ROOM = 1 << 16 };

// The plane and the box, cut into clusters by Umbrage; or the box drawn by the host.
static UmbrageScene make_scene(int host_drawn) {
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
    uint32_t box_mesh = 1;
    const float low[3] = {-0.5f, -0.5f, -0.5f}, high[3] = {0.5f, 0.5f, 0.5f};
    REFUSED(umbrage_meshes_add_bounds(meshes, high, low, &box_mesh), UMBRAGE_ERROR_LIMIT, "bounds is");
    if (host_drawn) CHECK(umbrage_meshes_add_bounds(meshes, low, high, &box_mesh));
    CHECK(umbrage_meshes_data(meshes, &data));

    UmbrageInstance instances[2];
    double rows[2][3][4] = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, {{0}}};
    for (int i = 0; i < 3; i++) {
        rows[1][i][i] = BOX[1][i] - BOX[0][i];
        rows[1][i][3] = 0.5 * (BOX[0][i] + BOX[1][i]);
    }
    for (uint32_t i = 0; i < 2; i++) CHECK(umbrage_instance_init(&instances[i], (const double(*)[4])rows[i], i, 0));
    instances[1].mesh = box_mesh;
    if (host_drawn) instances[1].flags |= UMBRAGE_CAST_HOST_DRAWN;
    const VkDrawIndexedIndirectCommand draws[2] = {{0}, {.indexCount = 36, .firstIndex = 6}};
    UmbrageMaterial material;
    CHECK(umbrage_material_init(&material));
    // in vertices of the host's, which have more before and after
    float vertices[12][5] = {{0}};
    for (int i = 0; i < 12; i++) memcpy(&vertices[i][1], positions[i], sizeof positions[i]);
    const uint32_t texel = 0xffffffff;

    const VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vertex = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    const VkBufferUsageFlags index = VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
    UmbrageScene scene = {
        .struct_size = sizeof scene,
        .positions = buffer(vertices, sizeof vertices, 0, storage | vertex, NULL),
        .position_stride = sizeof vertices[0],
        .position_offset = sizeof(float),
        .indices = buffer(data.indices, data.index_count * 4, INDEX_ROOM * 4, storage | index, NULL),
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
    if (host_drawn) scene.host_draws = buffer(draws, sizeof draws, 0, storage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, NULL);
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
    REFUSED(umbrage_engine_create(host, config, &empty, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "positions is");
    empty = *scene;
    empty.position_offset = 12;
    REFUSED(umbrage_engine_create(host, config, &empty, view, 1, &engine), UMBRAGE_ERROR_LIMIT, "position_layout");
    empty = *scene;
    empty.bounds_max[1] = -50.0;
    REFUSED(umbrage_engine_create(host, config, &empty, view, 1, &engine), UMBRAGE_ERROR_LIMIT, "bounds is");
    empty = *scene;
    empty.position_format = 3;
    REFUSED(umbrage_engine_create(host, config, &empty, view, 1, &engine), UMBRAGE_ERROR_LIMIT, "position_format is 3");
    empty = *scene;
    empty.alpha_tested = VK_TRUE;
    REFUSED(umbrage_engine_create(host, config, &empty, view, 1, &engine), UMBRAGE_ERROR_LIMIT, "attributes");
    UmbrageView blind = *view;
    blind.image_count = 0;
    REFUSED(umbrage_engine_create(host, config, scene, &blind, 1, &engine), UMBRAGE_ERROR_LIMIT, "images of a view");
    UmbrageDevice nothing = *host;
    nothing.device = VK_NULL_HANDLE;
    REFUSED(umbrage_engine_create(&nothing, config, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "device's");
    nothing = *host;
    nothing.get_instance_proc_addr = NULL;
    REFUSED(umbrage_engine_create(&nothing, config, scene, view, 1, &engine), UMBRAGE_ERROR_ARGUMENT, "proc_addr");
    nothing = *host;
    nothing.ray_query = VK_TRUE;
    if (!host->ray_query)
        REFUSED(umbrage_engine_create(&nothing, config, scene, view, 1, &engine), UMBRAGE_ERROR_UNSUPPORTED, "ray quer");
    if (engine) fail("create", "an engine that was refused");
}

// Counts how often it is called.
static void draw_nothing(VkCommandBuffer given, void *user) {
    if (given != commands) fail("draw", "other commands than were given");
    ++*(uint64_t *)user;
}

// Lights, frames and views that there are not; the commands are recording.
static void refused_calls(UmbrageEngine *engine, const UmbrageFrameInput *input, UmbrageLight light) {
    UmbrageFrameInput inputs[2] = {*input, *input};
    UmbrageLightId id = 0, none = 0;
    UmbrageCounters counters;
    VkImage image;
    VkImageView view;
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
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
    REFUSED(umbrage_record_with(engine, commands, inputs, 1, NULL, NULL, &frame), UMBRAGE_ERROR_ARGUMENT, "draw is a null");
    REFUSED(umbrage_record_with(engine, commands, inputs, 2, draw_nothing, &frame, &frame), UMBRAGE_ERROR_LIMIT, "views is 2");
    REFUSED(umbrage_casters(engine, &layout, &set), UMBRAGE_ERROR_LIMIT, "host_draws is none");
    REFUSED(umbrage_counters(engine, 0, &counters, sizeof counters), UMBRAGE_ERROR_LIMIT, "frame is 0");
    REFUSED(umbrage_counters(engine, 1, &counters, sizeof counters), UMBRAGE_ERROR_LIMIT, "frame is 1");
    REFUSED(umbrage_mask(engine, 1, &image, &view), UMBRAGE_ERROR_LIMIT, "view is 1");
    REFUSED(umbrage_lookup(engine, 1, &layout, &set), UMBRAGE_ERROR_LIMIT, "view is 1");
    REFUSED(umbrage_resize(engine, NULL, 0), UMBRAGE_ERROR_LIMIT, "views is 0");
    if (none || id || frame != 77 || layout || set) fail("outputs", "changed by calls that were refused");
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
    const UmbrageScene scene = make_scene(0), shared = make_scene(1);
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
            .used = {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0, VK_PIPELINE_STAGE_2_COPY_BIT,
                     VK_ACCESS_2_TRANSFER_WRITE_BIT},
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
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
    CHECK(umbrage_lookup(engine, 0, &layout, &set));
    if (!layout || !set) fail("lookup", "no set");

    // the box drawn by the host casts the same shadow
    UmbrageEngine *beside = NULL;
    CHECK(umbrage_engine_create(&host, &config, &shared, &own, 1, &beside));
    CHECK(umbrage_add_light(beside, &sun, &id));
    Casters casters = make_casters(beside, &shared, 1);
    VkImage image;
    VkImageView image_view;
    CHECK(umbrage_mask(beside, 0, &image, &image_view));
    begin();
    REFUSED(umbrage_record(beside, commands, &input, 1, NULL), UMBRAGE_ERROR_LIMIT, "without a callback");
    CHECK(umbrage_prepass_record(prepass, commands, &input, draws, 2));
    CHECK(umbrage_record_with(beside, commands, &input, 1, draw_casters, &casters, NULL));
    read_back(image, result);
    submit();
    compare("drawn by the host", hits, sun.direction, mask);
    if (casters.calls != 1) fail("draw", "calls");

    destroy_casters(&casters);
    umbrage_engine_destroy(beside);
    umbrage_engine_destroy(engine);
    umbrage_prepass_destroy(prepass);
    vkDestroyImageView(device, images.depth.view, NULL);
    vkDestroyImage(device, images.depth.image, NULL);
    take_down(messenger);
    printf("%s\n", failures ? "FAILED" : "passed");
    return failures != 0;
}
