//! Ray-traced soft shadows: the visible share of a light with extent, by jittered samples.

use super::reference::{check_light, dvec3, ray_offsets, to_light};
use super::{GBuffer, Tracer, TruthError};
use crate::{Light, scene::Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Samples a side of the jittered grid.
const GRID: u32 = 32;
/// Samples a pixel.
pub const SOFT_SAMPLES: u32 = GRID * GRID;
/// Rays to an area light end this share of their length before it, so that its own geometry does not block it.
const END_GAP: f64 = 1e-6;

/// Points on the light, from two numbers in 0..1.
enum Emitter {
    /// Unit vector towards the centre, then two vectors of the disc's radius at distance 1.
    Disc(DVec3, DVec3, DVec3),
    /// Triangles relative to the scene's origin, each with the share of the area up to its end; the front's normal.
    Fan(Vec<([DVec3; 3], f64)>, DVec3),
}

/// The visible share of a light with extent at every pixel, 0 to 1; 1 where there is no surface.
///
/// [`SOFT_SAMPLES`] jittered samples a pixel, spread evenly over the disc of directions or over the polygon's area and
/// not weighted by angle; the jitter depends on the pixel's index only. Samples behind the surface count as blocked.
/// Pixels whose n.l is <= 0 for the centre of a directional light are 0. A polygon's front is where its corners run
/// counter-clockwise; pixels behind it are 0. A light without extent gives hard shadows.
/// `progress` and errors as for [`super::reference`].
pub fn reference_soft(
    tracer: &Tracer,
    scene: &Scene,
    gbuffer: &GBuffer,
    light: &Light,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<f32>, TruthError> {
    let pixels = gbuffer.checked_len()?;
    check_light(light)?;
    let emitter = Emitter::new(light, scene.origin)?;
    let (width, rows) = (gbuffer.width as usize, gbuffer.height as usize);
    let done = AtomicUsize::new(0);
    let mut out = vec![1.0f32; pixels];
    out.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            let i = y * width + x;
            if gbuffer.hit[i] {
                let normal = dvec3(gbuffer.normal[i]);
                let [offset, ..] = ray_offsets(scene, gbuffer, i);
                let origin = gbuffer.point(i) + normal * offset;
                *value = emitter.visible(tracer, origin, normal, i as u32);
            }
        }
        let rows_done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(rows_done as f64 / rows as f64);
    });
    Ok(out)
}

impl Emitter {
    fn new(light: &Light, origin: DVec3) -> Result<Emitter, TruthError> {
        match light {
            Light::Directional { angular_diameter_deg, .. } => {
                let center = to_light(light, origin, DVec3::ZERO).unwrap_or(DVec3::Y);
                let radius = (0.5 * angular_diameter_deg.to_radians()).tan();
                let (a, b) = center.any_orthonormal_pair();
                Ok(Emitter::Disc(center, a * radius, b * radius))
            }
            Light::Spot { .. } | Light::Point { .. } => {
                Err(TruthError::new("the soft reference takes lights with extent"))
            }
            Light::Area { polygon } => {
                let corners: Vec<DVec3> = polygon.iter().map(|&p| p - origin).collect();
                let crosses = corners[1..].windows(2).map(|p| (p[0] - corners[0]).cross(p[1] - corners[0]));
                let total: f64 = crosses.clone().map(DVec3::length).sum();
                let normal = crosses.clone().sum::<DVec3>();
                if total <= 0.0 || !total.is_finite() {
                    return Err(TruthError::new(format!(
                        "the light's polygon has area {}, above 0 is needed",
                        0.5 * total
                    )));
                }
                let mut end = 0.0;
                let fan = crosses.zip(corners[1..].windows(2)).map(|(cross, p)| {
                    end += cross.length() / total;
                    ([corners[0], p[0], p[1]], end)
                });
                Ok(Emitter::Fan(fan.collect(), normal))
            }
        }
    }

    fn visible(&self, tracer: &Tracer, origin: DVec3, normal: DVec3, pixel: u32) -> f32 {
        match self {
            Emitter::Disc(center, ..) if normal.dot(*center) <= 0.0 => return 0.0,
            Emitter::Fan(fan, front) if (origin - fan[0].0[0]).dot(*front) <= 0.0 => return 0.0,
            _ => {}
        }
        let mut seen = 0.0;
        for s in 0..SOFT_SAMPLES {
            let bits = hash(pixel.wrapping_mul(SOFT_SAMPLES).wrapping_add(s) ^ 0x9e37_79b9);
            let jitter = |b: u32| f64::from(b & 0xffff) / 65536.0;
            let u = (f64::from(s % GRID) + jitter(bits)) / f64::from(GRID);
            let v = (f64::from(s / GRID) + jitter(bits >> 16)) / f64::from(GRID);
            let (direction, t_max) = self.sample(origin, u, v);
            if normal.dot(direction) > 0.0 {
                seen += tracer.transmittance(origin, direction, t_max);
            }
        }
        (seen / f64::from(SOFT_SAMPLES)) as f32
    }

    /// Direction from `origin` to the sample and where its ray ends.
    fn sample(&self, origin: DVec3, u: f64, v: f64) -> (DVec3, f64) {
        match self {
            Emitter::Disc(center, a, b) => {
                let (sin, cos) = (v * std::f64::consts::TAU).sin_cos();
                (*center + (*a * cos + *b * sin) * u.sqrt(), f64::INFINITY)
            }
            Emitter::Fan(fan, _) => {
                let k = fan.iter().position(|&(_, end)| u < end).unwrap_or(fan.len() - 1);
                let start = if k == 0 { 0.0 } else { fan[k - 1].1 };
                let ([p, q, r], end) = fan[k];
                let along = ((u - start) / (end - start)).clamp(0.0, 1.0).sqrt();
                let point = p + ((q - p) * (1.0 - v) + (r - p) * v) * along;
                (point - origin, 1.0 - END_GAP)
            }
        }
    }
}

/// PCG hash (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020).
fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
