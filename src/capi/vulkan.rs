//! Vulkan's types under their C names. The header has them from `vulkan/vulkan.h`, so cbindgen does not read this file.

use ash::vk;

pub use vk::{
    AccessFlags2 as VkAccessFlags2, Bool32 as VkBool32, Buffer as VkBuffer, CommandBuffer as VkCommandBuffer,
    DescriptorSet as VkDescriptorSet, DescriptorSetLayout as VkDescriptorSetLayout, Device as VkDevice,
    Format as VkFormat, Image as VkImage, ImageLayout as VkImageLayout, ImageView as VkImageView,
    Instance as VkInstance, PhysicalDevice as VkPhysicalDevice, PhysicalDeviceFeatures as VkPhysicalDeviceFeatures,
    PipelineStageFlags2 as VkPipelineStageFlags2, SampleCountFlags as VkSampleCountFlagBits,
};

pub type VkPhysicalDeviceVulkan12Features = vk::PhysicalDeviceVulkan12Features<'static>;
pub type VkPhysicalDeviceVulkan13Features = vk::PhysicalDeviceVulkan13Features<'static>;
pub type VkPhysicalDeviceAccelerationStructureFeaturesKHR = vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>;
pub type VkPhysicalDeviceRayQueryFeaturesKHR = vk::PhysicalDeviceRayQueryFeaturesKHR<'static>;
/// C's function pointers may be null.
#[allow(non_camel_case_types)]
pub type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;
