//! Antialiased hard shadows: the share of a pixel's samples that the light reaches.

use super::reference::{dvec3, snap, to_light, trace_visibility};
use super::{GBuffer, Reference, Tracer, TruthError};
use crate::config::{BEND, sample_places};
use crate::{Light, scene::Scene};
use glam::DVec3;

/// The share of `samples` of every pixel that the light reaches, ray-traced: 0 to 1, and 1 where there is no surface.
///
/// The samples lie on the plane through the pixel's surface, under the places of [`sample_places`]: derivatives of that plane
/// take them there, shortened to the distance from the eye where the plane is seen edge-on. Since surfaces bend, each is then
/// moved towards the light, by 0.2 of its way from the middle over n.l, but by no more than the way. It is traced as
/// [`trace_visibility`] does. `progress` is called with the share that is done, 0 to 1. Fails as [`super::reference()`] does.
pub fn reference_coverage(
    tracer: &Tracer,
    scene: &Scene,
    gbuffer: &GBuffer,
    light: &Light,
    samples: u32,
    progress: &dyn Fn(f64),
) -> Result<Vec<f32>, TruthError> {
    let places = sample_places(samples);
    let count = places.len() as f32;
    let bend = f64::from(BEND);
    let mut lit = vec![0.0; gbuffer.checked_len()?];
    for (i, place) in (1u8..).zip(&places) {
        let mut moved = gbuffer.clone();
        for pixel in (0..lit.len()).filter(|&pixel| gbuffer.hit[pixel]) {
            let [right, down] = sides(gbuffer, pixel);
            let shift = place[0] * right + place[1] * down;
            let at = dvec3(gbuffer.position[pixel]) + shift;
            let to_light = to_light(light, scene.origin, gbuffer.eye + at).unwrap_or(DVec3::ZERO);
            let unit = to_light.normalize_or_zero();
            let move_by = shift.length() * bend / dvec3(gbuffer.normal[pixel]).dot(unit).max(bend);
            let end = if matches!(light, Light::Directional { .. }) { f64::INFINITY } else { 0.5 * to_light.length() };
            moved.position[pixel] = (at + unit * move_by.min(end)).as_vec3().to_array();
        }
        snap(&mut moved, scene, || tracer);
        let visibility = trace_visibility(tracer, scene, &moved, light)?;
        lit.iter_mut().zip(visibility).for_each(|(lit, v)| *lit += v);
        progress(f64::from(i) / places.len() as f64);
    }
    lit.iter_mut().for_each(|lit| *lit /= count);
    Ok(lit)
}

/// What a pixel's surface spans to the right and down, on its plane.
fn sides(gbuffer: &GBuffer, pixel: usize) -> [DVec3; 2] {
    let (position, normal) = (dvec3(gbuffer.position[pixel]), dvec3(gbuffer.normal[pixel]));
    let [right, down] = gbuffer.ray_steps;
    let depth = position.dot(right.cross(down).normalize());
    let along = normal.dot(position).min(-1e-6 * position.length());
    gbuffer.ray_steps.map(|step| {
        let side = depth * (step - position * (normal.dot(step) / along));
        side * (position.length() / side.length()).min(1.0)
    })
}

/// How far an image of shares is from the traced one, in percent of full visibility.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoverageError {
    /// Mean distance over the decided pixels.
    pub mean: f64,
    /// Mean distance over those whose traced share is neither 0 nor 1; 0 without any.
    pub edge: f64,
    /// Largest distance of a decided pixel.
    pub worst: f64,
    /// Decided pixels ([`Reference::decided`]).
    pub pixels: u64,
    /// Decided pixels whose traced share is neither 0 nor 1.
    pub edge_pixels: u64,
}

/// Compares an image with that of [`reference_coverage`] where `reference` of the same light is decided.
///
/// Fails when an image is empty, has another size than the reference, or holds a value that is not finite.
pub fn compare_coverage(result: &[f32], coverage: &[f32], reference: &Reference) -> Result<CoverageError, TruthError> {
    super::metrics::check(result, reference)?;
    super::metrics::check(coverage, reference)?;
    let mut error = CoverageError::default();
    for i in (0..result.len()).filter(|&i| reference.decided[i]) {
        let distance = 100.0 * f64::from(result[i] - coverage[i]).abs();
        error.pixels += 1;
        error.mean += distance;
        error.worst = error.worst.max(distance);
        if coverage[i] > 0.0 && coverage[i] < 1.0 {
            error.edge_pixels += 1;
            error.edge += distance;
        }
    }
    error.mean /= error.pixels.max(1) as f64;
    error.edge /= error.edge_pixels.max(1) as f64;
    Ok(error)
}

/// Several images as one.
impl std::iter::Sum for CoverageError {
    fn sum<I: Iterator<Item = Self>>(images: I) -> Self {
        let mean = |a: (f64, u64), b: (f64, u64)| (a.0 * a.1 as f64 + b.0 * b.1 as f64) / (a.1 + b.1).max(1) as f64;
        images.fold(Self::default(), |a, b| Self {
            mean: mean((a.mean, a.pixels), (b.mean, b.pixels)),
            edge: mean((a.edge, a.edge_pixels), (b.edge, b.edge_pixels)),
            worst: a.worst.max(b.worst),
            pixels: a.pixels + b.pixels,
            edge_pixels: a.edge_pixels + b.edge_pixels,
        })
    }
}
