//! What is kept from frame to frame: which instances stand still, which pages are still right, which layers they have.
//!
//! A page's content depends on its address, on the casters that touch it and on the light's axes only, so a page stays
//! right until one of these changes. Casters that move are drawn into a second layer of the pages they touch, every
//! frame; those that stand still are cached.
//!
//! Reads: instances, meshes, page table, chosen pages. Writes: tracked instances, layers, their order of eviction.
//! At capacity: the least recently used layer is taken; never one of a page chosen in this frame.

use super::buffers::{Buffers, arguments};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

pub(crate) struct Cache {
    track: Compute,
    invalidate: Compute,
    adopt: Compute,
    assign: Compute,
    instances: u32,
    slot_groups: u32,
}

impl Cache {
    /// `changes`: where to tell what changed of each instance.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        b: &Buffers,
        scene: &SceneBuffers,
        changes: Option<&Buffer>,
    ) -> Result<Self, Error> {
        let page = [config.page_texels, config.gutter];
        let slots = config.page_capacity();
        let frame = b.frame(0);
        let counters = Binding::Storage(&b.counters);
        let (layers, order) = (Binding::Storage(&b.slots), Binding::Storage(&b.order));
        let changed = Binding::Storage(&b.changed);
        let instances = [Binding::External(scene.instances), Binding::External(scene.meshes)];
        Ok(Self {
            track: Compute::new(
                gpu,
                "cache_track",
                spirv!("engine/cache_track.comp"),
                &[
                    frame,
                    counters,
                    instances[0],
                    instances[1],
                    Binding::Storage(&b.tracked),
                    changed,
                    Binding::Storage(&b.items[1]),
                    Binding::Storage(changes.unwrap_or(&b.nothing[0])),
                    scene.host_draws.map_or(Binding::Storage(&b.nothing[0]), Binding::External),
                ],
                &[page[0], page[1], u32::from(changes.is_some()), u32::from(scene.host_draws.is_some())],
                4,
            )?,
            invalidate: Compute::new(
                gpu,
                "cache_invalidate",
                spirv!("engine/cache_invalidate.comp"),
                &[frame, counters, changed, layers, order, Binding::Storage(&b.lights)],
                &[page[0], page[1], slots],
                0,
            )?,
            adopt: Compute::new(
                gpu,
                "cache_adopt",
                spirv!("engine/cache_adopt.comp"),
                &[
                    frame,
                    Binding::Storage(&b.table_keys),
                    Binding::Storage(&b.nodes),
                    layers,
                    Binding::Storage(&b.lights),
                ],
                &[config.table_size(), slots],
                0,
            )?,
            assign: Compute::new(
                gpu,
                "cache_assign",
                spirv!("engine/cache_assign.comp"),
                &[
                    frame,
                    counters,
                    Binding::Storage(&b.pages),
                    layers,
                    order,
                    Binding::Storage(&b.cleared),
                    Binding::Storage(&b.arguments),
                    Binding::Storage(&b.lights),
                ],
                &[slots],
                4,
            )?,
            instances: scene.instance_count,
            slot_groups: slots.div_ceil(64),
        })
    }

    /// Compares the instances with the last frame.
    pub(crate) fn record_track(&self, cmd: vk::CommandBuffer) {
        self.track.dispatch(cmd, &self.instances, super::cull::groups(self.instances));
    }

    /// Marks pages that are no longer right.
    pub(crate) fn record_invalidate(&self, cmd: vk::CommandBuffer) {
        self.invalidate.dispatch(cmd, &(), [self.slot_groups, 1, 1]);
    }

    /// Finds the kept pages in the quadtree.
    pub(crate) fn record_adopt(&self, cmd: vk::CommandBuffer) {
        self.adopt.dispatch(cmd, &(), [self.slot_groups, 1, 1]);
    }

    /// Gives layers to the admitted pages.
    pub(crate) fn record_assign(&self, cmd: vk::CommandBuffer) {
        self.assign.dispatch(cmd, &arguments::CLEAR, [1, 1, 1]);
    }
}
