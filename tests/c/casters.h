// A caster that the host draws with a pipeline of its own: the shaders of examples/host.rs.
#pragma once
#include "device.h"

typedef struct {
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkDescriptorSet set;
    const UmbrageScene *scene;
    uint32_t instance, calls;
} Casters;

static VkShaderModule module_of(const char *path) {
    static uint32_t words[1 << 14];
    FILE *file = fopen(path, "rb");
    size_t bytes = file ? fread(words, 1, sizeof words, file) : 0;
    if (!bytes) fail("no shader", path);
    if (file) fclose(file);
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = bytes,
        .pCode = words,
    };
    VkShaderModule made = VK_NULL_HANDLE;
    CHECK(vkCreateShaderModule(device, &info, NULL, &made));
    return made;
}

// For `draw_casters`.
static Casters make_casters(const UmbrageEngine *engine, const UmbrageScene *scene, uint32_t instance) {
    Casters casters = {.scene = scene, .instance = instance};
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    CHECK(umbrage_casters(engine, &set_layout, &casters.set));
    const VkPushConstantRange wind = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(float)};
    const VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = 1,
        .pSetLayouts = &set_layout,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &wind,
    };
    CHECK(vkCreatePipelineLayout(device, &layout, NULL, &casters.layout));
    const VkPipelineShaderStageCreateInfo stage = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = VK_SHADER_STAGE_VERTEX_BIT,
        .module = module_of("spirv/examples/casters.vert.spv"),
        .pName = "main",
    };
    const VkVertexInputBindingDescription binding = {0, scene->position_stride, VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute = {0, 0, VK_FORMAT_R32G32B32_SFLOAT, scene->position_offset};
    const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = 1,
        .pVertexBindingDescriptions = &binding,
        .vertexAttributeDescriptionCount = 1,
        .pVertexAttributeDescriptions = &attribute,
    };
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
    };
    const VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1,
    };
    const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .lineWidth = 1.0f,
    };
    const VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
    };
    const VkPipelineDepthStencilStateCreateInfo depth = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = VK_TRUE,
        .depthWriteEnable = VK_TRUE,
        .depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL,
    };
    const VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
    };
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    const VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = 2,
        .pDynamicStates = states,
    };
    const VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .depthAttachmentFormat = VK_FORMAT_D32_SFLOAT,
    };
    const VkGraphicsPipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
        .pNext = &rendering,
        .stageCount = 1,
        .pStages = &stage,
        .pVertexInputState = &input,
        .pInputAssemblyState = &assembly,
        .pViewportState = &viewport,
        .pRasterizationState = &raster,
        .pMultisampleState = &samples,
        .pDepthStencilState = &depth,
        .pColorBlendState = &blend,
        .pDynamicState = &dynamic,
        .layout = casters.layout,
    };
    CHECK(vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &casters.pipeline));
    vkDestroyShaderModule(device, stage.module, NULL);
    return casters;
}

// An UmbrageDraw: the instance, in whatever pages Umbrage found for it.
static void draw_casters(VkCommandBuffer given, void *user) {
    Casters *casters = (Casters *)user;
    const VkDeviceSize zero = 0, stride = sizeof(VkDrawIndexedIndirectCommand);
    const float wind = 0.0f;
    casters->calls++;
    vkCmdBindPipeline(given, VK_PIPELINE_BIND_POINT_GRAPHICS, casters->pipeline);
    vkCmdBindDescriptorSets(given, VK_PIPELINE_BIND_POINT_GRAPHICS, casters->layout, 0, 1, &casters->set, 0, NULL);
    vkCmdPushConstants(given, casters->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof wind, &wind);
    vkCmdBindVertexBuffers(given, 0, 1, &casters->scene->positions, &zero);
    vkCmdBindIndexBuffer(given, casters->scene->indices, 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexedIndirect(given, casters->scene->host_draws, casters->instance * stride, 1, (uint32_t)stride);
}

static void destroy_casters(const Casters *casters) {
    vkDestroyPipeline(device, casters->pipeline, NULL);
    vkDestroyPipelineLayout(device, casters->layout, NULL);
}
