//! The shaded picture and the picture of differences.

use super::{DIFFERENCE_LEGEND, OutputError, Picture};
use crate::truth::{GBuffer, PixelClass, Reference, classify, to_light};
use crate::{Camera, Light};
use glam::{DVec3, Vec3};

pub(crate) const SUN: Vec3 = Vec3::new(2.9, 2.65, 2.25);
pub(crate) const SKY_AMBIENT: Vec3 = Vec3::new(0.42, 0.52, 0.70);
pub(crate) const GROUND_AMBIENT: Vec3 = Vec3::new(0.22, 0.20, 0.17);
pub(crate) const SKY_ZENITH: Vec3 = Vec3::new(0.16, 0.33, 0.72);
pub(crate) const SKY_HORIZON: Vec3 = Vec3::new(0.72, 0.82, 0.95);
pub(crate) const SKY_GROUND: Vec3 = Vec3::new(0.30, 0.29, 0.28);

/// Brightness of the sky of a view without a directional light, against daylight.
pub(crate) const NIGHT: f32 = 0.12;
/// Share of its range at which a spot or point light is as bright as the sun, but for the window that ends it.
pub(crate) const SUN_AT: f64 = 0.25;

/// The view under a sky and its lights, each dimmed by its visibility: tone-mapped albedo, a sky where there is no surface.
/// Spot and point lights fade as in glTF's KHR_lights_punctual and have the sun's brightness at a quarter of their range;
/// without a directional light it is night. `origin` is [`crate::scene::Scene::origin`]; up is the camera's.
///
/// Fails when a visibility image or the G-buffer does not have one entry a pixel.
pub fn shade(
    gbuffer: &GBuffer,
    camera: &Camera,
    origin: DVec3,
    lights: &[(&Light, &[f32])],
) -> Result<Picture, OutputError> {
    let (width, height) = (gbuffer.width, gbuffer.height);
    let pixels = width as usize * height as usize;
    let images = lights.iter().map(|(_, visibility)| ("visibility", visibility.len()));
    for (name, len) in images.chain([
        ("position", gbuffer.position.len()),
        ("normal", gbuffer.normal.len()),
        ("albedo", gbuffer.albedo.len()),
        ("hit", gbuffer.hit.len()),
    ]) {
        if len != pixels || pixels == 0 {
            return Err(OutputError::size(name, len, width, height));
        }
    }
    let up = camera.up.normalize_or(DVec3::Y).as_vec3();
    let rays = PixelRays::new(camera, width, height);
    let day = lights.iter().any(|(light, _)| matches!(light, Light::Directional { .. }));
    let dim = if day { 1.0 } else { NIGHT };
    let color = |i: usize| {
        if !gbuffer.hit[i] {
            return sky(rays.direction(i).dot(up)) * dim;
        }
        let ambient = GROUND_AMBIENT.lerp(SKY_AMBIENT, 0.5 + 0.5 * Vec3::from_array(gbuffer.normal[i]).dot(up));
        let lit = lights
            .iter()
            .map(|(light, visibility)| received(gbuffer, i, light, origin) * visibility[i].clamp(0.0, 1.0));
        albedo(gbuffer.albedo[i]) * (ambient * dim + SUN * lit.sum::<f32>())
    };
    Ok(Picture { width, height, rgb: (0..pixels).flat_map(|i| tone(color(i))).collect() })
}

/// Where results differ from the reference, over the dimmed reference in grey; colours as in [`DIFFERENCE_LEGEND`], which
/// stands below the picture. Of several lights each pixel shows the worst. Undecided pixels are tinted only where the light
/// reaches and n.l > 0. Errors off the edges are drawn 3 pixels wide so that single ones can be seen. `lights` are a light,
/// the result and the reference each; `origin` is [`crate::scene::Scene::origin`].
///
/// Fails for the same inputs as [`crate::truth::compare`], without a light, and when the G-buffer has another size than a
/// reference.
pub fn difference(
    gbuffer: &GBuffer,
    origin: DVec3,
    lights: &[(&Light, &[f32], &Reference)],
) -> Result<Picture, OutputError> {
    let error = |what: String| OutputError { path: "difference".to_owned(), what };
    let (width, height) = (gbuffer.width, gbuffer.height);
    let pixels = width as usize * height as usize;
    let lists = [gbuffer.position.len(), gbuffer.normal.len(), gbuffer.hit.len()];
    if lights.is_empty() || lists.iter().any(|&len| len != pixels) {
        return Err(error(format!("{} lights and {lists:?} entries of a G-buffer of {width}x{height}", lights.len())));
    }
    let mut classes = Vec::new();
    for (_, result, reference) in lights {
        if (reference.width, reference.height) != (width, height) {
            let (w, h) = (reference.width, reference.height);
            return Err(error(format!("the G-buffer is {width}x{height}, the reference {w}x{h}")));
        }
        classes.push(classify(result, reference).map_err(|e| error(e.to_string()))?);
    }
    let [on_edge, acne, leak, lost, undecided] = DIFFERENCE_LEGEND.map(|(_, color)| color);
    let most = |value: &dyn Fn(usize) -> f32| (0..lights.len()).map(value).fold(0.0, f32::max);
    let base = |i: usize| -> [u8; 3] {
        let facing = |l: usize| received(gbuffer, i, lights[l].0, origin).min(1.0);
        let grey = 34.0 + 26.0 * most(&facing) + 70.0 * most(&|l| facing(l) * f32::from(lights[l].2.visibility[i]));
        let open = |l: usize| classes[l][i] == PixelClass::Undecided && lights[l].2.facing[i];
        if !gbuffer.hit[i] {
            [16, 18, 24]
        } else if (0..lights.len()).any(open) {
            [0, 1, 2].map(|k| (0.5 * grey + 0.5 * f32::from(undecided[k])) as u8)
        } else {
            [grey as u8; 3]
        }
    };
    let mut picture = Picture { width, height, rgb: (0..pixels).flat_map(base).collect() };
    // later classes are worse and cover earlier ones
    for (class, color, wide) in [
        (PixelClass::OnEdge, on_edge, 0),
        (PixelClass::Acne, acne, 1),
        (PixelClass::Leak, leak, 1),
        (PixelClass::Lost, lost, 1),
    ] {
        for i in (0..pixels).filter(|&i| classes.iter().any(|of_light| of_light[i] == class)) {
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

/// What a pixel receives of an unshadowed light: n.l times the light's brightness there, 1 for the sun; 0 or more.
fn received(gbuffer: &GBuffer, i: usize, light: &Light, origin: DVec3) -> f32 {
    let to_light = to_light(light, origin, gbuffer.point(i)).unwrap_or(DVec3::ZERO);
    let lambert = Vec3::from_array(gbuffer.normal[i]).dot(to_light.normalize_or_zero().as_vec3());
    lambert.max(0.0) * brightness(light, to_light)
}

/// Brightness of a light at the end of `-to_light`, 1 for the sun: the falloff of KHR_lights_punctual, 0 beyond the range.
fn brightness(light: &Light, to_light: DVec3) -> f32 {
    let (range, cone) = match light {
        Light::Directional { .. } | Light::Area { .. } => return 1.0,
        Light::Point { range, .. } => (*range, 1.0),
        Light::Spot { direction, inner_angle_deg, outer_angle_deg, range, .. } => {
            let [inner, outer] = [inner_angle_deg, outer_angle_deg].map(|angle| angle.to_radians().cos());
            let cosine = -to_light.normalize_or_zero().dot(direction.normalize_or_zero());
            (*range, ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2))
        }
    };
    let share = to_light.length() / range;
    let window = (1.0 - share.powi(4)).clamp(0.0, 1.0);
    // a floor for what touches the light: tone mapping is white long before
    (cone * window * (SUN_AT / share.max(1e-3)).powi(2)) as f32
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
