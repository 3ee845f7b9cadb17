//! What draws maps that bend the edges of triangles (Lloyd et al. 2008; Rosen 2012; book, 4.2.4): a box for each triangle, whose texels ask
//! the triangle where they lie without the bend: `glsl/methods/bent_vertex.glsl`, `bent_fragment.glsl`.

use super::MethodSpec;
use super::comparison::{BiasKind, Comparison};
use super::map::Map;
use crate::gpu::{Binding, Graphics, GraphicsState, Shaders};
use crate::lab::{Lab, LabError};
use ash::vk;

/// Of a map with one layer; without and with alpha test. `warp`: what the shaders read after the casters'; `cells`: their constant 3.
pub(super) fn draws(
    (lab, map, name): (&Lab, &Map, &'static str),
    [vertex, fragment]: [&[u8]; 2],
    warp: &[Binding<'_>],
    cells: u32,
) -> Result<[Graphics; 2], LabError> {
    let scene = lab.scene_buffers();
    let (side, cull) = (map.shape().side, map.shape().comparison.cull as u32);
    let attributes = scene.attributes.unwrap_or(scene.positions);
    let fetched = [scene.positions, scene.indices, attributes].map(Binding::External);
    let bindings = [&map.casters(lab)[..], warp, &fetched].concat();
    let [stride, offset, format] = scene.position_layout.words();
    let state = GraphicsState {
        depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
        positions: None,
        attributes: false,
        ..GraphicsState::casters(scene.position_layout, true)
    };
    let pipeline = |masked| {
        let constants = &[0, 0, cull, cells, masked, side, stride, offset, format];
        let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants };
        Graphics::new(lab.gpu(), name, &shaders, &bindings, &state)
    };
    Ok([pipeline(0)?, pipeline(1)?])
}

/// Refuses what bent maps do not hold.
pub(super) fn check(spec: &MethodSpec, comparison: &Comparison) -> Result<(), LabError> {
    if comparison.bias.peels() || comparison.bias == BiasKind::Ids {
        return Err(LabError::Usage(format!(
            "method '{spec}' has a bias by what only unwarped maps hold, allowed is bias=plane, constant, slope or second"
        )));
    }
    Ok(())
}
