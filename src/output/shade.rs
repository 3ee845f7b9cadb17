//! The shaded picture and the picture of differences.

use super::{DIFFERENCE_LEGEND, OutputError, Picture};
use crate::truth::{GBuffer, PixelClass, Reference, classify, to_light};
use crate::{Camera, Light};
use glam::{DVec3, Vec3};

const SUN: Vec3 = Vec3::new(2.9, 2.65, 2.25);
const SKY_AMBIENT: Vec3 = Vec3::new(0.42, 0.52, 0.70);
const GROUND_AMBIENT: Vec3 = Vec3::new(0.22, 0.20, 0.17);
const SKY_ZENITH: Vec3 = Vec3::new(0.16, 0.33, 0.72);
const SKY_HORIZON: Vec3 = Vec3::new(0.72, 0.82, 0.95);
const SKY_GROUND: Vec3 = Vec3::new(0.30, 0.29, 0.28);

/// The view in daylight: albedo under a sky and one light dimmed by `visibility`, tone-mapped, a sky where there is no
/// surface. `origin` is [`crate::scene::Scene::origin`]; up is the camera's.
///
/// Fails when `visibility` or the G-buffer does not have one entry a pixel.
pub fn shade(
    gbuffer: &GBuffer,
    camera: &Camera,
    origin: DVec3,
    light: &Light,
    visibility: &[f32],
) -> Result<Picture, OutputError> {
    let (width, height) = (gbuffer.width, gbuffer.height);
    let pixels = width as usize * height as usize;
    for (name, len) in [
        ("visibility", visibility.len()),
        ("position", gbuffer.position.len()),
        ("normal", gbuffer.normal.len()),
        ("albedo", gbuffer.albedo.len()),
        ("hit", gbuffer.hit.len()),
    ] {
        if len != pixels || pixels == 0 {
            return Err(OutputError::size(name, len, width, height));
        }
    }
    let up = camera.up.normalize_or(DVec3::Y).as_vec3();
    let rays = PixelRays::new(camera, width, height);
    let color = |i: usize| {
        if !gbuffer.hit[i] {
            return sky(rays.direction(i).dot(up));
        }
        let normal = Vec3::from_array(gbuffer.normal[i]);
        let lambert = n_dot_l(gbuffer, i, light, origin).max(0.0);
        let ambient = GROUND_AMBIENT.lerp(SKY_AMBIENT, 0.5 + 0.5 * normal.dot(up));
        albedo(gbuffer.albedo[i]) * (ambient + SUN * (lambert * visibility[i].clamp(0.0, 1.0)))
    };
    Ok(Picture { width, height, rgb: (0..pixels).flat_map(|i| tone(color(i))).collect() })
}

/// Where `result` differs from the reference, over the dimmed reference in grey; colours as in [`DIFFERENCE_LEGEND`],
/// which stands below the picture. Undecided pixels are tinted only where n.l > 0. Errors off the edges are drawn 3 pixels wide so that single ones can be seen.
/// `origin` is [`crate::scene::Scene::origin`].
///
/// Fails for the same inputs as [`crate::truth::compare`], and when the G-buffer has another size than the reference.
pub fn difference(
    result: &[f32],
    reference: &Reference,
    gbuffer: &GBuffer,
    light: &Light,
    origin: DVec3,
) -> Result<Picture, OutputError> {
    let error = |what: String| OutputError { path: "difference".to_owned(), what };
    let classes = classify(result, reference).map_err(|e| error(e.to_string()))?;
    let (width, height) = (reference.width, reference.height);
    let lists = [gbuffer.position.len(), gbuffer.normal.len(), gbuffer.hit.len()];
    if (gbuffer.width, gbuffer.height) != (width, height) || lists.iter().any(|&len| len != classes.len()) {
        return Err(error(format!(
            "the G-buffer is {}x{}, the reference {width}x{height}",
            gbuffer.width, gbuffer.height
        )));
    }
    let [on_edge, acne, leak, lost, undecided] = DIFFERENCE_LEGEND.map(|(_, color)| color);
    let base = |i: usize| -> [u8; 3] {
        let lambert = n_dot_l(gbuffer, i, light, origin).max(0.0);
        let grey = 34.0 + 26.0 * lambert + 70.0 * lambert * f32::from(reference.visibility[i]);
        match classes[i] {
            PixelClass::Sky => [16, 18, 24],
            PixelClass::Undecided if reference.facing[i] => {
                [0, 1, 2].map(|k| (0.5 * grey + 0.5 * f32::from(undecided[k])) as u8)
            }
            _ => [grey as u8; 3],
        }
    };
    let mut picture = Picture { width, height, rgb: (0..classes.len()).flat_map(base).collect() };
    // later classes cover earlier ones
    for (class, color, wide) in [
        (PixelClass::OnEdge, on_edge, 0),
        (PixelClass::Acne, acne, 1),
        (PixelClass::Leak, leak, 1),
        (PixelClass::Lost, lost, 1),
    ] {
        for (i, _) in classes.iter().enumerate().filter(|(_, c)| **c == class) {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let (left, top) = (x.saturating_sub(wide), y.saturating_sub(wide));
            picture.fill(left, top, x + wide + 1 - left, y + wide + 1 - top, color);
        }
    }
    Ok(picture.with_legend(&DIFFERENCE_LEGEND))
}

/// View rays through pixel centres, in world space.
struct PixelRays {
    rows: [Vec3; 3],
    tan: f32,
    size: [u32; 2],
}

impl PixelRays {
    fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let view = camera.view_from_world();
        let tan = (0.5 * camera.fov_y_deg.to_radians()).tan() as f32;
        Self { rows: [0, 1, 2].map(|k| view.row(k).as_vec3()), tan, size: [width, height] }
    }

    fn direction(&self, pixel: usize) -> Vec3 {
        let [width, height] = self.size.map(|s| s as f32);
        let (x, y) = (pixel % self.size[0] as usize, pixel / self.size[0] as usize);
        let right = (2.0 * (x as f32 + 0.5) - width) / height * self.tan;
        let up = (height - 2.0 * (y as f32 + 0.5)) / height * self.tan;
        (self.rows[0] * right + self.rows[1] * up - self.rows[2]).normalize_or_zero()
    }
}

fn n_dot_l(gbuffer: &GBuffer, i: usize, light: &Light, origin: DVec3) -> f32 {
    let position = Vec3::from_array(gbuffer.position[i]).as_dvec3();
    let direction = to_light(light, origin, position).and_then(DVec3::try_normalize).unwrap_or(DVec3::ZERO);
    Vec3::from_array(gbuffer.normal[i]).dot(direction.as_vec3())
}

fn albedo(packed: u32) -> Vec3 {
    let [r, g, b, _] = packed.to_le_bytes().map(|c| f32::from(c) / 255.0);
    Vec3::new(r, g, b)
}

fn sky(height: f32) -> Vec3 {
    if height < 0.0 {
        SKY_HORIZON.lerp(SKY_GROUND, (-8.0 * height).min(1.0))
    } else {
        SKY_HORIZON.lerp(SKY_ZENITH, height.sqrt())
    }
}

/// Narkowicz's fit of the ACES film curve (2015), then the sRGB curve.
fn tone(color: Vec3) -> [u8; 3] {
    let x = color * 0.62;
    let film = (x * (x * 2.51 + 0.03)) / (x * (x * 2.43 + 0.59) + 0.14);
    film.clamp(Vec3::ZERO, Vec3::ONE).to_array().map(|c| {
        let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * s).round() as u8
    })
}
