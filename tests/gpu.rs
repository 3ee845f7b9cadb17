//! The engine on a Vulkan device, always under validation and synchronization validation: each stage against its twin,
//! whole frames, and images against ray tracing.
//!
//! Hazards between command buffers are seen only with
//! `VK_LAYER_ENABLES=VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT`, which `tools/test` sets.
#![cfg(feature = "lab")]

#[path = "gpu/allocate.rs"]
mod allocate;
#[path = "gpu/asm.rs"]
mod asm;
#[path = "gpu/bench.rs"]
mod bench;
#[path = "gpu/border.rs"]
mod border;
#[path = "gpu/cache.rs"]
mod cache;
#[path = "gpu/compact.rs"]
mod compact;
#[path = "gpu/comparators.rs"]
mod comparators;
#[path = "gpu/coverage.rs"]
mod coverage;
#[path = "gpu/exact.rs"]
mod exact;
#[path = "gpu/failing.rs"]
mod failing;
#[path = "gpu/filter.rs"]
mod filter;
#[path = "gpu/forward.rs"]
mod forward;
#[path = "gpu/frame.rs"]
mod frame;
#[path = "gpu/frozen.rs"]
mod frozen;
#[path = "gpu/gradient.rs"]
mod gradient;
#[path = "gpu/host.rs"]
mod host;
#[path = "gpu/hybrid.rs"]
mod hybrid;
#[path = "gpu/images.rs"]
mod images;
#[path = "gpu/izb.rs"]
mod izb;
#[path = "gpu/lacking.rs"]
mod lacking;
#[path = "gpu/lights.rs"]
mod lights;
#[path = "gpu/logpsm.rs"]
mod logpsm;
#[path = "gpu/maps.rs"]
mod maps;
#[path = "gpu/plane_optimal.rs"]
mod plane_optimal;
#[path = "gpu/request.rs"]
mod request;
#[path = "gpu/rtw.rs"]
mod rtw;
#[path = "gpu/sampling.rs"]
mod sampling;
#[path = "gpu/scenes.rs"]
mod scenes;
#[path = "gpu/silhouette.rs"]
mod silhouette;
#[path = "gpu/sort.rs"]
mod sort;
#[path = "gpu/temporal.rs"]
mod temporal;
#[path = "gpu/tree.rs"]
mod tree;
#[path = "gpu/triangle_store.rs"]
mod triangle_store;
#[path = "gpu/validation.rs"]
mod validation;
