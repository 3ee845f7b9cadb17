//! The sampling errors of the pages that serve: `glsl/methods/rmsm_sampling.comp`.

use super::sampling::{Sampling, measure};
use crate::LightId;
use crate::engine::Engine;
use crate::engine::lookup::Lookup;
use crate::gpu::{Compute, spirv};
use crate::lab::{Lab, LabError};

/// Those of the last frame.
pub(super) fn sampling(engine: &Engine, lab: &Lab, light: LightId) -> Result<Sampling, LabError> {
    let (config, view) = (&engine.config, &engine.views[0].buffers);
    let errors = measure(lab, &light.slot(), |target| {
        let bindings = [&Lookup::common(&engine.buffers, 0, view)[..], &[target]].concat();
        let constants = [config.table_size(), config.gutter];
        Compute::new(lab.gpu(), "rmsm_sampling", spirv!("methods/rmsm_sampling.comp"), &bindings, &constants, 4)
    })?;
    let part_texels = f64::from(config.interior()).powi(2);
    Ok(Sampling { size: lab.view().size, errors, part_texels, inputs: None })
}
