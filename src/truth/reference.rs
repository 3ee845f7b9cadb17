//! Ray-traced hard shadows at every pixel, and which pixels have a stable answer.

use super::trace::BUNDLE;
use super::{GBuffer, Tracer, TruthError};
use crate::{Light, scene::Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Pixels whose n.l is not above this are never decided.
pub const DECIDED_N_DOT_L: f64 = 0.01;

/// Distances of ray origins from the surface along the normal, as shares of the length that [`ray_offsets`] chooses; the
/// first is the reference's own.
const OFFSETS: [f64; BUNDLE] = [1e-5, 1e-6, 3e-5, 1e-4];
/// Pixels whose footprint is below this share of the scene's diagonal have offsets that follow the footprint.
const SMALL_FOOTPRINT: f64 = 1e-5;
/// The length of such a pixel in footprints: its offsets are 0.001 to 0.1 footprints.
const FOOTPRINTS: f64 = 1000.0;

/// Where casters are translucent: pixels that get half of the light give or take this share are never decided.
const HALF: f64 = 1e-3;

/// How far a sample may lie off the surface that it shows, in its distances from the eye: twice what was seen at 2 cm from a
/// triangle of 10 km.
const SNAP: f64 = 5e-3;

/// Ray-traced visibility of a light without extent, one entry a pixel, row 0 at the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 1 lit, 0 shadowed, by half of the light where casters are translucent; 0 where there is no surface, n.l <= 0 or the light
    /// does not reach.
    pub visibility: Vec<u8>,
    /// n.l above [`DECIDED_N_DOT_L`], in reach of the light from all ray origins, and the same answer for all of them.
    pub decided: Vec<bool>,
    /// Whether there is a surface.
    pub hit: Vec<bool>,
    /// Whether there is a surface with n.l > 0 that the light reaches ([`Light::reaches`]).
    pub facing: Vec<bool>,
}

impl Reference {
    /// As `visibility.exr` holds it: 1 lit, 0 shadowed, 1 where there is no surface, 0 where n.l <= 0 or the light does not
    /// reach.
    pub fn visibility_image(&self) -> Vec<f32> {
        self.visibility.iter().zip(&self.hit).map(|(&v, &hit)| if hit { f32::from(v) } else { 1.0 }).collect()
    }
}

/// Traces `light` at every pixel of `gbuffer` on all cores.
///
/// The reference ray starts at the first of [`ray_offsets`] along the normal; a pixel is decided when n.l > 0.01 and rays
/// from the others agree. Rays end at a spot or point light. `progress` is called from any thread with the share that is
/// done, 0 to 1. Fails for lights with extent (see [`super::reference_soft`]), a light that is malformed, such as a direction without
/// length, and a malformed G-buffer.
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
            let (position, normal) = (gbuffer.point(i), dvec3(gbuffer.normal[i]));
            let Some(n_dot_l) = facing_light(light, scene.origin, position, normal) else { continue };
            facing[x] = true;
            let origins = ray_offsets(scene, gbuffer, i).map(|offset| position + normal * offset);
            let stable = n_dot_l > DECIDED_N_DOT_L && origins.iter().all(|&o| light.reaches(scene.origin + o));
            let count = if stable { BUNDLE } else { 1 };
            let blocked = blocked(tracer, light, scene.origin, &origins[..count]);
            visibility[x] = u8::from(blocked & 1 == 0);
            // rounding decides what lets half of the light through
            let clear = |o| (transmittance(tracer, light, scene.origin, o) - 0.5).abs() > HALF;
            decided[x] = stable
                && (blocked == 0 || blocked == (1 << BUNDLE) - 1)
                && (!tracer.is_translucent() || clear(origins[0]));
        }
        let rows_done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(rows_done as f64 / rows as f64);
    });
    Ok(out)
}

/// How far along the normal the rays of a pixel start, in world units; the first is the reference's own.
///
/// They are 1e-5, 1e-6, 3e-5 and 1e-4 of a length: the diagonal of the scene's bounds, or 1000 footprints of the pixel where
/// its footprint is below 1e-5 of the diagonal, as in huge scenes and close to surfaces.
pub fn ray_offsets(scene: &Scene, gbuffer: &GBuffer, pixel: usize) -> [f64; BUNDLE] {
    let length = if is_small(scene, gbuffer, pixel) { FOOTPRINTS * gbuffer.footprint(pixel) } else { scene.diagonal() };
    OFFSETS.map(|share| share * length)
}

fn is_small(scene: &Scene, gbuffer: &GBuffer, pixel: usize) -> bool {
    gbuffer.footprint(pixel) < SMALL_FOOTPRINT * scene.diagonal()
}

/// Moves samples of small footprint along their view rays onto the nearest caster within [`SNAP`]: their offsets are below
/// what single precision leaves of a large triangle that is drawn. `tracer` is asked only where there are such samples.
pub(crate) fn snap<'a>(gbuffer: &mut GBuffer, scene: &Scene, tracer: impl FnOnce() -> &'a Tracer) {
    let small: Vec<bool> = (0..gbuffer.hit.len()).map(|i| gbuffer.hit[i] && is_small(scene, gbuffer, i)).collect();
    if !small.contains(&true) {
        return;
    }
    let (tracer, eye) = (tracer(), gbuffer.eye);
    gbuffer.position.par_iter_mut().zip(small).filter(|(_, small)| *small).for_each(|(position, _)| {
        let ray = dvec3(*position);
        // both ways start a hair behind the sample, so that they find a surface on which it lies exactly
        let hair = f64::from(f32::EPSILON);
        let found = [1.0, -1.0].map(|way| {
            let t = tracer.first_hit(eye + ray * (1.0 - way * hair), ray * way, SNAP)?;
            Some(way * (t - hair))
        });
        if let Some(t) = found.into_iter().flatten().min_by(|a, b| a.abs().total_cmp(&b.abs())) {
            *position = (ray * (1.0 + t)).as_vec3().to_array();
        }
    });
}

/// n.l at `position` (relative to `origin`, the scene's origin) where it is above 0 and the light reaches.
fn facing_light(light: &Light, origin: DVec3, position: DVec3, normal: DVec3) -> Option<f64> {
    let n_dot_l = normal.dot(to_light(light, origin, position)?.normalize());
    (n_dot_l > 0.0 && light.reaches(origin + position)).then_some(n_dot_l)
}

/// Whether a caster stands between the light and each of `ray_origins` (relative to `origin`, the scene's origin): bit i
/// answers ray origin i.
fn blocked(tracer: &Tracer, light: &Light, origin: DVec3, ray_origins: &[DVec3]) -> u32 {
    if let Light::Directional { .. } = light {
        let parallel = to_light(light, origin, DVec3::ZERO);
        return parallel.map_or(0, |direction| tracer.occluded_bundle(ray_origins, direction, f64::INFINITY));
    }
    let each = ray_origins.iter().enumerate().map(|(i, &from)| {
        u32::from(to_light(light, origin, from).is_some_and(|way| tracer.occluded(from, way, 1.0))) << i
    });
    each.sum()
}

/// The share of the light that comes to `from` (relative to `origin`, the scene's origin).
fn transmittance(tracer: &Tracer, light: &Light, origin: DVec3, from: DVec3) -> f64 {
    let end = if matches!(light, Light::Directional { .. }) { f64::INFINITY } else { 1.0 };
    to_light(light, origin, from).map_or(1.0, |way| tracer.transmittance(from, way, end))
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
    let require = |holds: bool, what: &dyn Fn() -> String| {
        if holds { Ok(()) } else { Err(TruthError::new(format!("the light's {}", what()))) }
    };
    let direction = |d: &DVec3| {
        require(d.try_normalize().is_some(), &|| format!("direction is {d}, a finite length above 0 is needed"))
    };
    let place = |position: &DVec3, range: f64| {
        require(position.is_finite(), &|| format!("position is {position}, three finite numbers are needed"))?;
        require(range > 0.0, &|| format!("range is {range}, above 0 is needed"))
    };
    match light {
        Light::Directional { direction: d, angular_diameter_deg: angle } => {
            direction(d)?;
            require((0.0..180.0).contains(angle), &|| {
                format!("angular diameter is {angle} degrees, allowed is 0 up to 180")
            })
        }
        Light::Spot { position, direction: d, outer_angle_deg: angle, range, .. } => {
            place(position, *range)?;
            direction(d)?;
            require(*angle > 0.0 && *angle <= 90.0, &|| {
                format!("outer angle is {angle} degrees, allowed is above 0 and up to 90")
            })
        }
        Light::Point { position, range } => place(position, *range),
        Light::Area { polygon } => {
            require(polygon.len() >= 3, &|| format!("polygon has {} corners, at least 3 are needed", polygon.len()))?;
            let odd = polygon.iter().find(|p| !p.is_finite()).copied().unwrap_or_default();
            require(odd.is_finite(), &|| format!("polygon has the corner {odd}, three finite numbers are needed"))
        }
    }
}

pub(super) fn dvec3(v: [f32; 3]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// One ray a pixel, as the method `raytraced`: visibility as `visibility.exr` holds it (see
/// [`Reference::visibility_image`]), but shares of light where casters are translucent, on all cores. Fails as [`reference()`] does.
pub fn trace_visibility(
    tracer: &Tracer,
    scene: &Scene,
    gbuffer: &GBuffer,
    light: &Light,
) -> Result<Vec<f32>, TruthError> {
    let pixels = gbuffer.checked_len()?;
    check_light(light)?;
    let visible = |i: usize| -> f64 {
        let (position, normal) = (gbuffer.point(i), dvec3(gbuffer.normal[i]));
        let [offset, ..] = ray_offsets(scene, gbuffer, i);
        let faces = facing_light(light, scene.origin, position, normal).is_some();
        if faces { transmittance(tracer, light, scene.origin, position + normal * offset) } else { 0.0 }
    };
    Ok((0..pixels).into_par_iter().map(|i| if gbuffer.hit[i] { visible(i) as f32 } else { 1.0 }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_samples_snap_to_their_surface() {
        let scene = crate::scene::builtin();
        let tracer = Tracer::new(&scene);
        let eye = DVec3::new(-11.0, 9.0, -14.0) - scene.origin;
        let fan = (0..400).map(|i| DVec3::new(0.4 + 0.03 * f64::from(i % 20), -0.5, 0.9 - 0.03 * f64::from(i / 20)));
        let exact: Vec<DVec3> =
            fan.filter_map(|way| tracer.first_hit(eye, way, 100.0).map(|distance| way * distance)).collect();
        assert!(exact.len() > 300, "{} samples", exact.len());
        for (pixel, off, snaps) in [(1e-9, 0.0, true), (1e-9, 1e-3, true), (1e-9, -1e-3, true), (1.0, 1e-3, false)] {
            let position: Vec<_> = exact.iter().map(|p| (*p * (1.0 + off)).as_vec3().to_array()).collect();
            let hit = vec![true; exact.len()];
            let ray_steps = [DVec3::X * pixel, DVec3::Y * pixel];
            let mut gbuffer = GBuffer { eye, ray_steps, position, hit, ..GBuffer::default() };
            snap(&mut gbuffer, &scene, || &tracer);
            let near = |i: &usize| (gbuffer.point(*i) - eye - exact[*i]).length() < 1e-6 * exact[*i].length();
            let count = (0..exact.len()).filter(near).count();
            // where two surfaces meet the nearest may be the other one
            let most = if off == 0.0 { exact.len() } else { exact.len() * 9 / 10 };
            assert!(if snaps { count >= most } else { count == 0 }, "{count} of {} at {pixel}, {off}", exact.len());
        }
    }
}
