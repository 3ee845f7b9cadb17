//! A thin layer over raw Vulkan.
