//! The lab's scene over time: poses it, uploads what changed, and forgets what was computed from the old state.

use super::{Lab, LabError, View, upload};
#[cfg(feature = "window")]
use crate::engine::depth_prepass::DepthPrepass;
use crate::scene::{Changes, Motion, Scene};

impl Lab {
    /// Gives the lab what moves its scene. Nothing moves before [`Lab::animate`].
    pub fn set_motion(&mut self, motion: Motion) {
        self.motion = Some(motion);
    }

    /// Brings the scene to a time, on the CPU and on the device. Without a motion only the view's time changes.
    ///
    /// What was traced, drawn or built from the old state is forgotten if anything changed.
    ///
    /// # Errors
    /// [`LabError::Usage`] for a time that is not finite, [`LabError::Refused`] as [`Motion::pose`],
    /// [`LabError::Engine`] for everything Vulkan reports.
    pub fn animate(&mut self, time_s: f64) -> Result<(), LabError> {
        if !time_s.is_finite() {
            return Err(LabError::Usage(format!("the time is {time_s} s; it must be finite")));
        }
        if let Some(motion) = self.motion.take() {
            let posed = self.edit(|scene| motion.pose(scene, time_s).map_err(|e| LabError::Refused(e.to_string())));
            self.motion = Some(motion);
            posed?;
        }
        self.view.time_s = time_s;
        Ok(())
    }

    /// Changes the scene and uploads what `edit` says it changed. Numbers of vertices, instances and clusters stay, and all
    /// casters stay within the scene's bounds; an instance that is to cast differently gets another revision.
    ///
    /// # Errors
    /// Those of `edit`; [`LabError::Engine`] for everything Vulkan reports.
    pub fn edit(&mut self, edit: impl FnOnce(&mut Scene) -> Result<Changes, LabError>) -> Result<(), LabError> {
        let changes = edit(&mut self.scene)?;
        if !changes.is_empty() {
            self.tracer.take();
            self.gbuffer.take();
            self.reference.take();
            upload::changes(&self.gpu, &self.device, &self.scene, &self.buffers, &changes)?;
            if let Some(shapes) = self.shapes.as_ref().filter(|_| !changes.meshes.is_empty()) {
                let meshes = changes.meshes.iter().map(|&m| m as usize);
                shapes.build(&self.gpu, &self.device, &self.scene, meshes)?;
            }
        }
        Ok(())
    }

    /// Changes camera and lights; the time of `view` is ignored, as [`Lab::animate`] sets it.
    ///
    /// # Errors
    /// [`LabError::Usage`] for another image size or a view without a light.
    pub fn look(&mut self, view: View) -> Result<(), LabError> {
        if view.size != self.view.size {
            let ([w, h], [ow, oh]) = (view.size, self.view.size);
            return Err(LabError::Usage(format!("the view has {w}x{h} pixels; this lab was made for {ow}x{oh}")));
        }
        if view.lights.is_empty() {
            return Err(LabError::Usage("the view has no light; at least one is needed".into()));
        }
        self.gbuffer.take();
        self.reference.take();
        self.view = View { time_s: self.view.time_s, ..view };
        Ok(())
    }

    #[cfg(feature = "window")]
    /// Gives the images another size. Methods are made for one size: those of the old one are of no use any more.
    pub(crate) fn resize(&mut self, size: [u32; 2]) -> Result<(), LabError> {
        self.prepass = DepthPrepass::on(&self.gpu, size, &self.buffers)?;
        self.gbuffer.take();
        self.reference.take();
        self.view.size = size;
        Ok(())
    }
}
