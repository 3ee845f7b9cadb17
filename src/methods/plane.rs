//! The passes that lay the line of a warp by a plane (Chong, Gortler 2004; book, 4.2.5): `glsl/methods/plane_*.comp`. They come
//! before those of the warp, which measure along the axis found here.

use super::map::{Map, Screen};
use super::warp_passes::Passes;
use crate::gpu::structs::DominantPlane;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;
use glam::DVec3;
use std::sync::Arc;

/// Bins of normals and offsets; as in `glsl/methods/plane.glsl`.
const BINS: u64 = 9 * 9 * 9 * 128;

/// The plane for which a warp is optimal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Plane {
    /// That in which most of the visible samples lie that the light shines on.
    Dominant,
    /// Unit normal and offset of a plane in world space, n . x = d.
    Given(DVec3, f64),
}

pub(super) struct Planes {
    plane: Plane,
    record: Buffer,
    bins: Buffer,
    /// Of the dominant plane: count, pick, mean.
    find: Option<[Compute; 3]>,
    line: Compute,
    gpu: Arc<Gpu>,
}

impl Planes {
    pub(super) fn new(
        lab: &Lab,
        (screen, map): (&Screen, &Map),
        passes: &Passes,
        plane: Plane,
    ) -> Result<Self, LabError> {
        let gpu = lab.gpu();
        let storage = |name, bytes| Buffer::storage(gpu, name, bytes, vk::BufferUsageFlags::empty());
        let record = storage("dominant plane", size_of::<DominantPlane>() as u64)?;
        let dominant = plane == Plane::Dominant;
        let bins = storage("plane bins", if dominant { 4 * BINS } else { 4 })?;
        let own = [&record, &bins].map(Binding::Storage);
        let samples = map.samples(screen);
        let (count, pick) = (spirv!("methods/plane_count.comp"), spirv!("methods/plane_pick.comp"));
        let (mean, line) = (spirv!("methods/plane_mean.comp"), spirv!("methods/plane_line.comp"));
        let find = || -> Result<_, LabError> {
            Ok([
                Compute::new(gpu, "plane_count", count, &[&samples[..], &own].concat(), &[1], 0)?,
                Compute::new(gpu, "plane_pick", pick, &own, &[], 0)?,
                Compute::new(gpu, "plane_mean", mean, &[&samples[..], &own[..1]].concat(), &[1], 0)?,
            ])
        };
        let placed = [Binding::Uniform(map.light()), own[0], Binding::Storage(passes.records())];
        Ok(Self {
            plane,
            find: dominant.then(find).transpose()?,
            line: Compute::new(gpu, "plane_line", line, &placed, &[1, 0, dominant.into()], 0)?,
            record,
            bins,
            gpu: gpu.clone(),
        })
    }

    /// Among a frame's first transfers.
    pub(super) fn reset(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        let camera = &lab.view().camera;
        let word = |v: DVec3, w: f64| v.extend(w).as_vec4().to_array();
        let plane = match self.plane {
            Plane::Dominant => [0.0; 4],
            Plane::Given(normal, offset) => word(normal, offset - normal.dot(camera.eye)),
        };
        let forward = word(-camera.view_from_world().row(2), lab.scene().diagonal().max(1e-30));
        let record = DominantPlane { plane, forward, ..DominantPlane::zeroed() };
        // SAFETY: the command buffer is recording, the data is smaller than 64 KiB; the map's own commands wait for the last
        // frame and for this
        unsafe {
            self.gpu.device.cmd_update_buffer(cmd, self.record.raw, 0, bytemuck::bytes_of(&record));
            self.gpu.device.cmd_fill_buffer(cmd, self.bins.raw, 0, vk::WHOLE_SIZE, 0);
        }
    }

    /// After the layer was fitted, before the warp's passes: axis and line in its record.
    pub(super) fn record(&self, cmd: vk::CommandBuffer, screen: &Screen) {
        use Access::*;
        let next = || sync::barrier(&self.gpu.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        if let Some([count, pick, mean]) = &self.find {
            for (pass, groups) in [(count, screen.columns()), (pick, [1; 3]), (mean, screen.columns())] {
                pass.dispatch(cmd, &(), groups);
                next();
            }
        }
        self.line.dispatch(cmd, &(), [1; 3]);
        next();
    }

    /// Device memory in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.record.size + self.bins.size
    }

    /// Samples in the plane that the last frame found; `None` where it was given.
    pub(super) fn samples(&self, lab: &Lab) -> Result<Option<u64>, LabError> {
        let bytes = lab.read_buffer(&self.record)?;
        let record: DominantPlane = bytemuck::pod_read_unaligned(&bytes[..size_of::<DominantPlane>()]);
        Ok((self.plane == Plane::Dominant).then_some(record.count.into()))
    }
}
