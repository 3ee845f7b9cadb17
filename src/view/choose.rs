//! Chooses camera and sun for a scene that comes without a view: a handful of candidates, judged by a few rays.

use super::{corners, depth_range};
use crate::lab::View;
use crate::scene::Scene;
use crate::truth::Tracer;
use crate::{Camera, Light};
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// Vertical field of view in degrees.
const FOV_Y_DEG: f64 = 50.0;
/// How far the camera outside looks down, in degrees.
const DESCENT_DEG: f64 = 25.0;
/// Height of the sun in degrees.
const SUN_DEG: f64 = 50.0;
/// Azimuth of the sun from the camera's back, in degrees: shadows fall to the side and stay in sight.
const SUN_SIDES_DEG: [f64; 4] = [65.0, -65.0, 155.0, -155.0];
/// Distance of the camera outside over the one at which the corners of the bounds just fit, for a scene without height and
/// its growth with height over width: bodies fill their bounds less than the bounds fill the picture, and of a landscape
/// the middle matters.
const CLOSENESS: [f64; 2] = [0.55, 0.3];
/// Rays a candidate is judged by, across and down.
const GRID: [u32; 2] = [32, 18];
/// A scene whose outer views all show more than this share of skin is a room, to be seen from inside.
const SKIN_OF_A_ROOM: f64 = 0.75;
/// Thickness of the skin over half the size of the bounds; of the scenes tried, rooms show 0.88 and more of it, others at
/// most 0.69.
const SKIN: f64 = 0.1;
/// Thickness of a scene that is a sheet, over its diagonal.
const FLAT: f64 = 1e-3;
/// Least middle distance of what is seen from inside, over the diagonal: nearer, the camera stands in a thing.
const LEAST_ROOM: f64 = 0.15;
/// Halvings that find the first surface on a ray: to 1/65536 of the depth range.
const HALVINGS: u32 = 16;
/// Distance below which a blocker counts as the surface itself, over the diagonal.
const OWN_SHADOW: f64 = 2e-3;

/// The candidate that shows most.
pub(super) fn view(scene: &Scene, size: [u32; 2]) -> View {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let judge = Judge { tracer: Tracer::new(scene), scene, aspect };
    let look = |camera: Camera| (judge.seen(&camera), camera);
    let mut looks: Vec<_> = outside(scene, aspect).into_iter().map(look).collect();
    if !flat(scene) && looks.iter().all(|(seen, _)| judge.skin(seen) > SKIN_OF_A_ROOM) {
        looks = inside(scene).into_iter().map(look).collect();
    }
    let mut best = (-1.0, camera(DVec3::Z, DVec3::ZERO), -DVec3::Y);
    for (seen, camera) in looks {
        for sun in suns(&camera) {
            let score = judge.score(&seen, sun);
            if score > best.0 {
                best = (score, camera, sun);
            }
        }
    }
    let (_, camera, sun) = best;
    let mut camera = Camera {
        eye: rounded(camera.eye, scene.diagonal()),
        target: rounded(camera.target, scene.diagonal()),
        ..camera
    };
    let [near, far] = depth_range(&camera, scene);
    [camera.near, camera.far] = [significant(near), significant(far * 1.1)];
    View { camera, lights: vec![Light::directional(rounded(sun, 1.0))], size, time_s: 0.0 }
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    Camera { eye, target, up: DVec3::Y, fov_y_deg: FOV_Y_DEG, near: 0.0, far: 0.0 }
}

/// Direction to a point at an azimuth around +Y and a height above the horizon.
fn direction(azimuth_deg: f64, height_deg: f64) -> DVec3 {
    let (sin, cos) = height_deg.to_radians().sin_cos();
    DQuat::from_rotation_y(azimuth_deg.to_radians()) * DVec3::new(0.0, sin, cos)
}

/// Cameras from slightly above that have most of the scene in sight.
fn outside(scene: &Scene, aspect: f64) -> Vec<Camera> {
    let center = 0.5 * (scene.bounds_min + scene.bounds_max);
    let half = (0.5 * FOV_Y_DEG).to_radians().tan();
    let size = scene.bounds_max - scene.bounds_min;
    let height = (size.y / size.x.max(size.z).max(1e-9)).min(1.0);
    let closeness = CLOSENESS[0] + CLOSENESS[1] * height;
    let look = |azimuth_deg: f64| {
        let back = direction(azimuth_deg, DESCENT_DEG);
        let view = camera(center + back, center).view_from_world();
        // each corner asks for the distance at which it just enters the picture
        let needed = corners(scene).map(|corner| {
            let at = view * (corner - center);
            at.z + (at.x.abs() / (half * aspect)).max(at.y.abs() / half)
        });
        let distance = closeness * needed.fold(scene.diagonal().max(1e-4) * 0.1, f64::max);
        camera(center + back * distance, center)
    };
    [35.0, -35.0, 145.0, -145.0].map(look).into()
}

/// Whether there is no inside to look from.
fn flat(scene: &Scene) -> bool {
    (scene.bounds_max - scene.bounds_min).min_element() < FLAT * scene.diagonal()
}

/// Cameras in the middle and near the ends, at a third of the height, looking along the scene.
fn inside(scene: &Scene) -> Vec<Camera> {
    let (low, high) = (scene.bounds_min, scene.bounds_max);
    let at = |x: f64, y: f64, z: f64| low + (high - low) * DVec3::new(x, y, z);
    let mut cameras = Vec::new();
    for azimuth_deg in [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0] {
        let back = direction(azimuth_deg, 0.0);
        let reach = 0.35 / back.x.abs().max(back.z.abs());
        for share in [0.0, 0.5, 1.0] {
            let eye = at(0.5 + back.x * reach * share, 0.35, 0.5 + back.z * reach * share);
            let target = at(0.5 - back.x * reach, 0.25, 0.5 - back.z * reach);
            cameras.push(camera(eye, target));
        }
    }
    cameras
}

/// Directions in which the light travels.
fn suns(camera: &Camera) -> [DVec3; 4] {
    let back = camera.eye - camera.target;
    let azimuth_deg = back.x.atan2(back.z).to_degrees();
    SUN_SIDES_DEG.map(|side| -direction(azimuth_deg + side, SUN_DEG))
}

/// A point just in front of a surface that the camera sees, relative to the scene's origin.
struct Seen {
    position: DVec3,
    distance: f64,
}

struct Judge<'a> {
    tracer: Tracer,
    scene: &'a Scene,
    aspect: f64,
}

impl Judge<'_> {
    fn seen(&self, camera: &Camera) -> Vec<Seen> {
        let half = (0.5 * camera.fov_y_deg).to_radians().tan();
        let world_from_view = camera.view_from_world().transpose();
        let eye = camera.eye - self.scene.origin;
        let far = depth_range(camera, self.scene)[1] * 2.0;
        let [across, down] = GRID;
        let first = |i: u32| {
            let x = 2.0 * (f64::from(i % across) + 0.5) / f64::from(across) - 1.0;
            let y = 1.0 - 2.0 * (f64::from(i / across) + 0.5) / f64::from(down);
            let ray = (world_from_view * DVec3::new(x * half * self.aspect, y * half, -1.0)).normalize();
            let distance = self.free_distance(eye, ray, far)?;
            Some(Seen { position: eye + ray * distance, distance })
        };
        (0..across * down).into_par_iter().filter_map(first).collect()
    }

    /// A distance a little short of the first surface, by halving: the tracer only tells whether there is one.
    fn free_distance(&self, eye: DVec3, ray: DVec3, far: f64) -> Option<f64> {
        let (mut free, mut blocked) = (0.0, far);
        if !self.tracer.occluded(eye, ray, far) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (free + blocked);
            *(if self.tracer.occluded(eye, ray, middle) { &mut blocked } else { &mut free }) = middle;
        }
        Some(free)
    }

    /// Share of what is seen that lies on the bounds, the ground left aside.
    fn skin(&self, seen: &[Seen]) -> f64 {
        let inner = 0.5 * (1.0 - SKIN) * (self.scene.bounds_max - self.scene.bounds_min);
        let outer = |s: &&Seen| s.position.x.abs() > inner.x || s.position.z.abs() > inner.z || s.position.y > inner.y;
        seen.iter().filter(outer).count() as f64 / seen.len().max(1) as f64
    }

    /// High where much of the picture is filled and cast shadows share it with light.
    fn score(&self, seen: &[Seen], sun: DVec3) -> f64 {
        let mut distances: Vec<f64> = seen.iter().map(|s| s.distance).collect();
        distances.sort_by(f64::total_cmp);
        let room = LEAST_ROOM * self.scene.diagonal();
        if distances.get(distances.len() / 2).is_none_or(|&middle| middle < room) {
            return 0.0;
        }
        // what is blocked at once is turned away from the sun rather than shadowed by something
        let own = OWN_SHADOW * self.scene.diagonal();
        let facing = seen.par_iter().filter(|s| !self.tracer.occluded(s.position, -sun, own));
        let lit = |s: &&Seen| !self.tracer.occluded(s.position, -sun, f64::INFINITY);
        let (lit, dark): (Vec<_>, Vec<_>) = facing.partition(lit);
        let share = |part: usize| part as f64 / seen.len() as f64;
        let filled = seen.len() as f64 / f64::from(GRID[0] * GRID[1]);
        (filled / 0.5).min(1.0) * (0.02 + 4.0 * share(lit.len()) * share(dark.len()))
    }
}

/// Five digits of what matters at this scale: short in the file, and exactly the same when read back.
fn rounded(v: DVec3, scale: f64) -> DVec3 {
    let decimals = (4.0 - scale.max(1e-9).log10().floor()).clamp(0.0, 15.0) as usize;
    v.map(|x| format!("{x:.decimals$}").parse().unwrap_or(x) + 0.0)
}

fn significant(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}
