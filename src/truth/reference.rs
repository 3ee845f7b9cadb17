//! Ray-traced hard shadows at every pixel, and which pixels have a stable answer.

use super::{GBuffer, Tracer, TruthError};
use crate::{Light, scene::Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Pixels whose n.l is not above this are never decided.
pub const DECIDED_N_DOT_L: f64 = 0.01;

/// Distances along the normal, as shares of the diagonal of the scene's bounds; the first is the reference's own.
const OFFSETS: [f64; super::trace::BUNDLE] = [1e-5, 1e-6, 3e-5, 1e-4];

/// Ray-traced visibility of a light without extent, one entry a pixel, row 0 at the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 1 lit, 0 shadowed; 0 where there is no surface or n.l <= 0.
    pub visibility: Vec<u8>,
    /// n.l above [`DECIDED_N_DOT_L`] and the same answer for all ray origins.
    pub decided: Vec<bool>,
    /// Whether there is a surface.
    pub hit: Vec<bool>,
    /// Whether there is a surface with n.l > 0.
    pub facing: Vec<bool>,
}

impl Reference {
    /// As `visibility.exr` holds it: 1 lit, 0 shadowed, 1 where there is no surface, 0 where n.l <= 0.
    pub fn visibility_image(&self) -> Vec<f32> {
        self.visibility.iter().zip(&self.hit).map(|(&v, &hit)| if hit { f32::from(v) } else { 1.0 }).collect()
    }
}

/// Traces `light` at every pixel of `gbuffer` on all cores.
///
/// The reference ray starts 1e-5 of the scene's diagonal along the normal; a pixel is decided when n.l > 0.01 and rays
/// from 1e-6, 3e-5 and 1e-4 agree. `progress` is called from any thread with the share that is done, 0 to 1.
/// Fails for lights with extent (see [`super::reference_soft`]), a direction without length, and a malformed G-buffer.
pub fn reference(
    tracer: &Tracer,
    scene: &Scene,
    gbuffer: &GBuffer,
    light: &Light,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Reference, TruthError> {
    if light.has_extent() {
        return Err(TruthError::new("the hard reference takes lights without extent"));
    }
    let pixels = gbuffer.checked_len()?;
    check_light(light)?;
    let (width, rows) = (gbuffer.width as usize, gbuffer.height as usize);
    let diagonal = scene.diagonal();
    let mut out = Reference {
        width: gbuffer.width,
        height: gbuffer.height,
        visibility: vec![0; pixels],
        decided: vec![false; pixels],
        hit: gbuffer.hit.clone(),
        facing: vec![false; pixels],
    };
    let done = AtomicUsize::new(0);
    let lists = (&mut out.visibility, &mut out.decided, &mut out.facing);
    let chunks = (lists.0.par_chunks_mut(width), lists.1.par_chunks_mut(width), lists.2.par_chunks_mut(width));
    chunks.into_par_iter().enumerate().for_each(|(y, (visibility, decided, facing))| {
        for x in 0..width {
            let i = y * width + x;
            if !gbuffer.hit[i] {
                continue;
            }
            let position = dvec3(gbuffer.position[i]);
            let normal = dvec3(gbuffer.normal[i]);
            let Some(to_light) = to_light(light, scene.origin, position) else { continue };
            let n_dot_l = normal.dot(to_light.normalize());
            if n_dot_l.is_nan() || n_dot_l <= 0.0 {
                continue;
            }
            facing[x] = true;
            let stable = n_dot_l > DECIDED_N_DOT_L;
            let origins = OFFSETS.map(|o| position + normal * (o * diagonal));
            let count = if stable { OFFSETS.len() } else { 1 };
            let blocked = tracer.occluded_bundle(&origins[..count], to_light, f64::INFINITY);
            visibility[x] = u8::from(blocked & 1 == 0);
            decided[x] = stable && (blocked == 0 || blocked == (1 << OFFSETS.len()) - 1);
        }
        let rows_done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(rows_done as f64 / rows as f64);
    });
    Ok(out)
}

/// Vector towards the light at `position` (relative to `origin`, the scene's origin): a unit vector for a directional
/// light, towards the polygon's centre for an area light; `None` if it has no direction.
pub(crate) fn to_light(light: &Light, origin: DVec3, position: DVec3) -> Option<DVec3> {
    match light {
        Light::Directional { direction, .. } => (-*direction).try_normalize(),
        Light::Spot { position: p, .. } | Light::Point { position: p, .. } => {
            let d = *p - origin - position;
            (d.is_finite() && d != DVec3::ZERO).then_some(d)
        }
        Light::Area { polygon } => {
            let center = polygon.iter().map(|&p| p - origin).sum::<DVec3>() / polygon.len().max(1) as f64;
            let d = center - position;
            (d.is_finite() && d != DVec3::ZERO).then_some(d)
        }
    }
}

pub(super) fn check_light(light: &Light) -> Result<(), TruthError> {
    match light {
        Light::Directional { direction, .. } if direction.try_normalize().is_none() => {
            Err(TruthError::new(format!("the light's direction is {direction}, a finite length above 0 is needed")))
        }
        Light::Directional { angular_diameter_deg: d, .. } if !(0.0..180.0).contains(d) => {
            Err(TruthError::new(format!("the light's angular diameter is {d} degrees, allowed is 0 up to 180")))
        }
        Light::Directional { .. } | Light::Spot { .. } | Light::Point { .. } => Ok(()),
        Light::Area { polygon } if polygon.len() < 3 => {
            Err(TruthError::new(format!("the light's polygon has {} corners, at least 3 are needed", polygon.len())))
        }
        Light::Area { polygon } => match polygon.iter().find(|p| !p.is_finite()) {
            Some(p) => Err(TruthError::new(format!("a corner of the light's polygon is {p}, which is not finite"))),
            None => Ok(()),
        },
    }
}

pub(super) fn dvec3(v: [f32; 3]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// One ray a pixel, as the method `raytraced`: visibility as `visibility.exr` holds it (see
/// [`Reference::visibility_image`]), on all cores. Fails as [`reference()`] does.
pub fn trace_visibility(
    tracer: &Tracer,
    scene: &Scene,
    gbuffer: &GBuffer,
    light: &Light,
) -> Result<Vec<f32>, TruthError> {
    let pixels = gbuffer.checked_len()?;
    check_light(light)?;
    let offset = OFFSETS[0] * scene.diagonal();
    let visible = |i: usize| {
        let (position, normal) = (dvec3(gbuffer.position[i]), dvec3(gbuffer.normal[i]));
        to_light(light, scene.origin, position)
            .is_some_and(|l| normal.dot(l) > 0.0 && !tracer.occluded(position + normal * offset, l, f64::INFINITY))
    };
    Ok((0..pixels).into_par_iter().map(|i| f32::from(u8::from(!gbuffer.hit[i] || visible(i)))).collect())
}
