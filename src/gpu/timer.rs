//! GPU timestamps, one name a stage.

use super::Gpu;
use super::sync::{self, Access};
use crate::error::{Context, Error};
use ash::vk;
use std::sync::Arc;

/// Marks the ends of stages in a command buffer; the first mark is the start.
pub(crate) struct Timer {
    pool: vk::QueryPool,
    capacity: u32,
    names: Vec<&'static str>,
    gpu: Arc<Gpu>,
}

impl Timer {
    pub(crate) fn new(gpu: &Arc<Gpu>, capacity: u32) -> Result<Self, Error> {
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(capacity);
        // SAFETY: a plain create call with a complete info
        let pool = unsafe { gpu.device.create_query_pool(&info, None) }.context("vkCreateQueryPool")?;
        Ok(Self { pool, capacity, names: Vec::new(), gpu: gpu.clone() })
    }

    /// Starts a new series of marks.
    pub(crate) fn begin(&mut self, cmd: vk::CommandBuffer) {
        self.names.clear();
        // SAFETY: the command buffer is recording outside of rendering
        unsafe { self.gpu.device.cmd_reset_query_pool(cmd, self.pool, 0, self.capacity) };
        self.mark(cmd, "begin");
    }

    /// Ends the stage `name`. Marks beyond the capacity are dropped.
    pub(crate) fn mark(&mut self, cmd: vk::CommandBuffer, name: &'static str) {
        let index = self.names.len() as u32;
        if index < self.capacity {
            self.names.push(name);
            // SAFETY: the query was reset by `begin`
            unsafe { self.gpu.device.cmd_write_timestamp2(cmd, sync::TIMESTAMP_STAGE, self.pool, index) };
            // without it lavapipe may run what follows before it takes the time
            sync::barrier(&self.gpu.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        }
    }

    /// Milliseconds of each stage of the last series, after its submission was waited for.
    pub(crate) fn read(&self) -> Result<Vec<(&'static str, f64)>, Error> {
        let mut ticks = vec![0u64; self.names.len()];
        // SAFETY: the queries were written by a finished submission
        unsafe {
            self.gpu.device.get_query_pool_results(
                self.pool,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )
        }
        .context("vkGetQueryPoolResults")?;
        let ms = f64::from(self.gpu.limits.timestamp_period) * 1e-6;
        Ok((1..ticks.len()).map(|i| (self.names[i], ticks[i].saturating_sub(ticks[i - 1]) as f64 * ms)).collect())
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the GPU before dropping resources
        unsafe { self.gpu.device.destroy_query_pool(self.pool, None) };
    }
}
