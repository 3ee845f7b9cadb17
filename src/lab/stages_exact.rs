//! Rays through the GPU's tree over casters, or by ray queries, given by tests and answered in a list: what is compared
//! with [`crate::truth::Tracer`].

use super::{Lab, LabError};
use crate::Config;
use crate::engine::bvh::Bvh;
use crate::engine::exact::Exact;
use crate::engine::query::{self, RayQuery};
use crate::gpu::sync::{self, Access::*};
use crate::gpu::{Binding, Buffer, Memory, structs::Frame};
use ash::vk;
use bytemuck::{Pod, Zeroable};

pub use crate::engine::bvh::{CHANGED_PLACE, CHANGED_SHAPE};

type Result<T> = std::result::Result<T, LabError>;

/// A ray: origin relative to the scene's origin, `t_max`, direction, 0.
pub type Ray = [f32; 8];

/// The tree, if rays walk through it, and the pass that traces.
pub struct ExactStage {
    bvh: Option<Bvh>,
    exact: Exact,
    _frame: Buffer,
    capacity: u32,
}

/// Copies `data` to the start of a buffer.
fn write<T: Pod>(lab: &Lab, buffer: &Buffer, data: &[T]) -> Result<()> {
    let bytes: &[u8] = bytemuck::cast_slice(data);
    let size = bytes.len() as u64;
    let mut staging = Buffer::new(&lab.gpu, "rays", size, vk::BufferUsageFlags::TRANSFER_SRC, Memory::Upload)?;
    staging.bytes_mut()[..bytes.len()].copy_from_slice(bytes);
    lab.submit(|cmd| {
        sync::barrier(&lab.gpu.device, cmd, &[(HostWrite, TransferRead), (ComputeRead, TransferWrite)]);
        let copy = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size }];
        // SAFETY: callers pass no more than the buffer holds
        unsafe { lab.gpu.device.cmd_copy_buffer(cmd, staging.raw, buffer.raw, &copy) };
        sync::barrier(&lab.gpu.device, cmd, &[(TransferWrite, ComputeWrite)]);
    })?;
    Ok(())
}

impl ExactStage {
    /// For the lab's scene; most rays of a list.
    pub fn new(lab: &Lab, config: &Config, capacity: u32) -> Result<Self> {
        let tree = !query::chosen(&lab.gpu, &Config { exact: true, ..config.clone() }, &lab.buffers);
        let bvh = tree.then(|| Bvh::new(&lab.gpu, &lab.buffers)).transpose()?;
        // an eye in the scene's origin, and rays that start where they are given
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let frame = Buffer::new(&lab.gpu, "frame constants", size_of::<Frame>() as u64, usage, Memory::Device)?;
        write(lab, &frame, &[Frame::zeroed()])?;
        let frame_constants = Binding::Uniform(&frame);
        let exact = Exact::new(&lab.gpu, config, &lab.buffers, bvh.as_ref(), capacity, frame_constants, None)?;
        Ok(Self { bvh, exact, _frame: frame, capacity })
    }

    /// Whether rays walk through the tree.
    pub fn has_tree(&self) -> bool {
        self.bvh.is_some()
    }

    /// Brings tree or structure up to date; returns the wall time in milliseconds. `changes`: what changed of each instance,
    /// of which only the tree needs to know.
    pub fn build(&self, lab: &Lab, changes: &[u32]) -> Result<f64> {
        let Some(bvh) = &self.bvh else { return self.build_structure(lab) };
        let any = u32::from(changes.iter().any(|&c| c != 0));
        write(lab, &bvh.changes, &[&[any], changes].concat())?;
        lab.submit(|cmd| {
            let device = &lab.gpu.device;
            sync::barrier(device, cmd, &[(ComputeWrite, TransferWrite), (IndirectRead, ComputeWrite)]);
            bvh.record_reset(cmd);
            sync::barrier(device, cmd, &[(TransferWrite, ComputeWrite), (ComputeWrite, ComputeWrite)]);
            bvh.record(cmd);
        })
    }

    fn build_structure(&self, lab: &Lab) -> Result<f64> {
        lab.submit(|cmd| {
            RayQuery::record(&lab.gpu.device, cmd, self.exact.query.iter());
        })
    }

    /// Builds everything.
    pub fn build_all(&self, lab: &Lab) -> Result<f64> {
        self.build(lab, &vec![CHANGED_PLACE | CHANGED_SHAPE; lab.scene.instances.len()])
    }

    /// Uploads rays; those beyond the capacity are counted but have no room.
    pub fn load(&self, lab: &Lab, rays: &[Ray]) -> Result<()> {
        if !rays.is_empty() {
            write(lab, &self.exact.rays, &rays[..rays.len().min(self.capacity as usize)])?;
        }
        write(lab, &self.exact.count, &[rays.len() as u32])
    }

    /// Traces the loaded rays; returns the wall time in milliseconds.
    pub fn trace(&self, lab: &Lab) -> Result<f64> {
        lab.submit(|cmd| {
            let device = &lab.gpu.device;
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (IndirectRead, ComputeWrite)]);
            self.exact.record(cmd);
        })
    }

    /// What the last trace found: whether each ray met a caster.
    pub fn occluded(&self, lab: &Lab, rays: usize) -> Result<Vec<bool>> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.exact.visibility)?);
        Ok(words[..rays.min(self.capacity as usize)].iter().map(|&v| v == 0).collect())
    }

    /// Device memory of the tree and all that builds it, or of the structure over the meshes', in bytes.
    pub fn bytes(&self) -> u64 {
        let query = self.exact.query.as_ref().map(RayQuery::bytes);
        self.bvh.as_ref().map(Bvh::bytes).or(query).unwrap_or(0)
    }
}
