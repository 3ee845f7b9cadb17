//! Visibility rays through a scene's casters: boxes in f32 with a margin, triangles in f64, alpha cut away. A corner is
//! the exact product of instance and position as stored but for the rounding of f64.

use super::alpha::alpha_at;
use super::bvh::Bvh;
use crate::casters::CastPolicy;
use crate::scene::{Instance, Material, Mesh, NO_TEXTURE, Scene};
use glam::{DMat3, DVec3};
use obvhs::aabb::Aabb;

/// Marks a triangle without an alpha test.
const OPAQUE: u32 = u32::MAX;
/// Most rays of one bundle.
pub(crate) const BUNDLE: usize = 4;

/// Above this many drawn triangles, meshes with several instances are kept once and placed by a second hierarchy.
/// A triangle costs about 110 bytes in the flat hierarchy and 340 while it is built.
const FLAT_TRIANGLES: u64 = 2_000_000;

/// The triangles of a scene's casting meshes, ready for shadow rays. Holds copies: the scene may be dropped.
pub struct Tracer {
    /// Triangles in space relative to the scene's origin.
    flat: Part,
    /// Meshes in their own space.
    parts: Vec<Part>,
    placements: Vec<Placement>,
    placement_bvh: Bvh,
    cuts: Vec<Cut>,
    /// `texel_offset` points into `alpha`.
    materials: Vec<Material>,
    alpha: Vec<u8>,
    /// Whether casters may let a share of the light through.
    translucent: bool,
}

/// Triangles in one space, sorted by their hierarchy's leaves.
struct Part {
    bvh: Bvh,
    triangles: Vec<[DVec3; 3]>,
    /// Entry in [`Tracer::cuts`] or [`OPAQUE`], parallel to `triangles`; empty when all are opaque.
    cuts: Vec<u32>,
}

/// What the alpha test of one triangle needs.
struct Cut {
    uv: [[f32; 2]; 3],
    alpha: [f32; 3],
    material: u32,
}

struct Placement {
    part: u32,
    part_from_world: DMat3,
    /// World position of the part's zero, relative to the scene's origin.
    translation: DVec3,
}

impl Tracer {
    /// Builds the hierarchies of all casting meshes. Triangles with a non-finite corner are left out.
    pub fn new(scene: &Scene) -> Tracer {
        Self::with_flat_limit(scene, FLAT_TRIANGLES)
    }

    /// Memory of triangles and hierarchies, in bytes.
    pub fn bytes(&self) -> u64 {
        let part = |p: &Part| p.bvh.bytes() + size_of_val(&p.triangles[..]) as u64 + size_of_val(&p.cuts[..]) as u64;
        let parts: u64 = self.parts.iter().map(part).sum();
        part(&self.flat) + parts + self.placement_bvh.bytes() + size_of_val(&self.placements[..]) as u64
    }

    /// As [`Tracer::new`], keeping instanced meshes once when the scene draws more than `flat_triangles`. Visibility does
    /// not depend on the limit but for rays that pass an edge within the rounding of f64.
    pub fn with_flat_limit(scene: &Scene, flat_triangles: u64) -> Tracer {
        let share = scene.drawn_triangles() > flat_triangles;
        let mut cutouts = Cutouts::new(scene);
        let mut flat = Soup::default();
        let mut parts = Vec::new();
        let mut placements = Vec::new();
        let mut boxes = Vec::new();
        for mesh in scene.meshes.iter().filter(|m| m.casts) {
            let first = mesh.first_instance as usize;
            let instances = &scene.instances[first..first + mesh.instance_count as usize];
            let mut shared = None;
            for instance in instances.iter().filter(|i| i.flags & 3 != CastPolicy::Never as u32) {
                let (linear, translation) = affine(instance);
                let inverse = linear.inverse();
                if !share || instances.len() == 1 || !inverse.is_finite() {
                    flat.push(scene, mesh, &mut cutouts, |p| linear * p + translation);
                    continue;
                }
                let part = *shared.get_or_insert_with(|| {
                    let mut soup = Soup::default();
                    soup.push(scene, mesh, &mut cutouts, |p| p);
                    parts.push(soup.build());
                    parts.len() - 1
                });
                let bounds: &Bvh = &parts[part].bvh;
                boxes.push(world_box(bounds, linear, translation));
                placements.push(Placement { part: part as u32, part_from_world: inverse, translation });
            }
        }
        let (placement_bvh, order) = Bvh::build(&boxes);
        let mut by_leaf: Vec<Option<Placement>> = placements.into_iter().map(Some).collect();
        let placements = order.iter().filter_map(|&i| by_leaf[i as usize].take()).collect();
        let Cutouts { cuts, materials, alpha, .. } = cutouts;
        let translucent = cuts.iter().any(|cut: &Cut| materials[cut.material as usize].translucent == 1);
        Tracer { flat: flat.build(), parts, placements, placement_bvh, cuts, materials, alpha, translucent }
    }

    /// Whether a caster lies on `origin + t * direction` with 0 < t < `t_max`.
    ///
    /// `origin` is relative to [`Scene::origin`]; `direction` points towards the light and may have any length but
    /// zero; `t_max` counts in lengths of `direction` and may be infinite. Both sides of a triangle count; points whose
    /// alpha is below the material's cutoff do not. Where casters are translucent the answer is whether less than half of the
    /// light passes ([`Tracer::transmittance`]).
    pub fn occluded(&self, origin: DVec3, direction: DVec3, t_max: f64) -> bool {
        self.occluded_bundle(&[origin], direction, t_max) != 0
    }

    /// [`Tracer::occluded`] for at most [`BUNDLE`] origins that lie close together: bit i answers origin i.
    pub(crate) fn occluded_bundle(&self, origins: &[DVec3], direction: DVec3, t_max: f64) -> u32 {
        let mut ray = Rays { origins: [DVec3::ZERO; BUNDLE], count: origins.len().min(BUNDLE), direction, t_max };
        ray.origins[..ray.count].copy_from_slice(&origins[..ray.count]);
        if self.translucent {
            let dark = |(i, &origin)| u32::from(self.transmittance(origin, direction, t_max) < 0.5) << i;
            return origins.iter().enumerate().map(dark).sum();
        }
        let all = (1u32 << ray.count) - 1;
        let mut blocked = self.trace_part(&self.flat, &ray, 0);
        if blocked == all {
            return blocked;
        }
        let (center, spread) = ray.center();
        if let Some(line) = self.placement_bvh.enter(center, spread, direction, t_max) {
            self.placement_bvh.walk(&line, |range| {
                for placement in &self.placements[range] {
                    blocked |= self.trace_part(&self.parts[placement.part as usize], &ray.moved(placement), blocked);
                }
                blocked == all
            });
        }
        blocked
    }

    /// The share of the light that passes: 0 where [`Material::translucent`] is 0 for a caster on the way, else the product of
    /// 1 - alpha over all that are met (book, 4.5.2). Arguments as for [`Tracer::occluded`].
    pub fn transmittance(&self, origin: DVec3, direction: DVec3, t_max: f64) -> f64 {
        if !self.translucent {
            return f64::from(u8::from(!self.occluded(origin, direction, t_max)));
        }
        let ray = Rays { origins: [origin; BUNDLE], count: 1, direction, t_max };
        let mut passes = self.through_part(&self.flat, &ray, 1.0);
        if let Some(line) = self.placement_bvh.enter(origin, 0.0, direction, t_max) {
            self.placement_bvh.walk(&line, |range| {
                for placement in &self.placements[range] {
                    passes = self.through_part(&self.parts[placement.part as usize], &ray.moved(placement), passes);
                }
                passes == 0.0
            });
        }
        passes
    }

    /// Whether rays tell shares of light.
    pub(crate) fn is_translucent(&self) -> bool {
        self.translucent
    }

    /// What of the share `passes` passes the casters of `part` along the first of `rays`.
    fn through_part(&self, part: &Part, rays: &Rays, mut passes: f64) -> f64 {
        let [origin, ..] = rays.origins;
        let Some(line) = part.bvh.enter(origin, 0.0, rays.direction, rays.t_max) else { return passes };
        let shear = Shear::new(rays.direction);
        part.bvh.walk(&line, |range| {
            for i in range {
                let cut = part.cuts.get(i).copied().unwrap_or(OPAQUE);
                if let Some((_, weights)) = shear.hit(&part.triangles[i], origin, rays.t_max) {
                    passes *= if cut == OPAQUE { 0.0 } else { 1.0 - self.opacity(cut, weights) };
                }
            }
            passes == 0.0
        });
        passes
    }

    /// Where the first caster on `origin + t * direction` with 0 < t < `t_max` lies, in lengths of `direction`; arguments as
    /// for [`Tracer::occluded`].
    pub fn first_hit(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
        let mut ray = Rays { origins: [origin; BUNDLE], count: 1, direction, t_max };
        ray.t_max = self.first_in_part(&self.flat, &ray);
        if let Some(line) = self.placement_bvh.enter(origin, 0.0, direction, t_max) {
            self.placement_bvh.walk(&line, |range| {
                for placement in &self.placements[range] {
                    ray.t_max = self.first_in_part(&self.parts[placement.part as usize], &ray.moved(placement));
                }
                false
            });
        }
        (ray.t_max < t_max).then_some(ray.t_max)
    }

    /// Where the first of `rays` meets `part`, or its end.
    fn first_in_part(&self, part: &Part, rays: &Rays) -> f64 {
        let mut first = rays.t_max;
        let [origin, ..] = rays.origins;
        let Some(line) = part.bvh.enter(origin, 0.0, rays.direction, first) else { return first };
        let shear = Shear::new(rays.direction);
        part.bvh.walk(&line, |range| {
            for i in range {
                let cut = part.cuts.get(i).copied().unwrap_or(OPAQUE);
                if let Some((t, weights)) = shear.hit(&part.triangles[i], origin, first)
                    && (cut == OPAQUE || self.solid(cut, weights))
                {
                    first = t;
                }
            }
            false
        });
        first
    }

    /// The bits of `blocked` and of every ray that meets a triangle of `part`.
    fn trace_part(&self, part: &Part, rays: &Rays, mut blocked: u32) -> u32 {
        let all = (1u32 << rays.count) - 1;
        let (center, spread) = rays.center();
        let Some(line) = part.bvh.enter(center, spread, rays.direction, rays.t_max) else {
            return blocked;
        };
        let shear = Shear::new(rays.direction);
        part.bvh.walk(&line, |range| {
            for i in range {
                let triangle = &part.triangles[i];
                let cut = part.cuts.get(i).copied().unwrap_or(OPAQUE);
                for (r, &origin) in rays.origins[..rays.count].iter().enumerate() {
                    if blocked >> r & 1 != 0 {
                        continue;
                    }
                    if let Some((_, weights)) = shear.hit(triangle, origin, rays.t_max)
                        && (cut == OPAQUE || self.solid(cut, weights))
                    {
                        blocked |= 1 << r;
                    }
                }
                if blocked == all {
                    return true;
                }
            }
            false
        });
        blocked
    }

    /// Share of the light that a point holds back.
    fn opacity(&self, cut: u32, weights: [f64; 3]) -> f64 {
        let (alpha, material) = self.alpha(cut, weights);
        match material.translucent {
            1 => f64::from(alpha.clamp(0.0, 1.0)),
            _ => f64::from(u8::from(alpha >= material.alpha_cutoff)),
        }
    }

    fn solid(&self, cut: u32, weights: [f64; 3]) -> bool {
        let (alpha, material) = self.alpha(cut, weights);
        alpha >= material.alpha_cutoff
    }

    fn alpha(&self, cut: u32, weights: [f64; 3]) -> (f32, &Material) {
        let cut = &self.cuts[cut as usize];
        let w = weights.map(|w| w as f32);
        let mix = |v: [f32; 3]| v[0] * w[0] + v[1] * w[1] + v[2] * w[2];
        let uv = [0, 1].map(|k| mix([cut.uv[0][k], cut.uv[1][k], cut.uv[2][k]]));
        let material = &self.materials[cut.material as usize];
        (alpha_at(material, |i| self.alpha.get(i as usize).copied().unwrap_or(u8::MAX), uv, mix(cut.alpha)), material)
    }
}

/// Parallel rays in one space.
struct Rays {
    origins: [DVec3; BUNDLE],
    count: usize,
    direction: DVec3,
    t_max: f64,
}

impl Rays {
    /// Centre of the origins' bounds and the largest distance from it along an axis.
    fn center(&self) -> (DVec3, f64) {
        let (mut min, mut max) = (self.origins[0], self.origins[0]);
        for &o in &self.origins[1..self.count] {
            min = min.min(o);
            max = max.max(o);
        }
        ((min + max) * 0.5, (max - min).max_element() * 0.5)
    }

    fn moved(&self, placement: &Placement) -> Rays {
        let m = placement.part_from_world;
        Rays {
            origins: self.origins.map(|o| m * (o - placement.translation)),
            count: self.count,
            direction: m * self.direction,
            t_max: self.t_max,
        }
    }
}

/// Ray-triangle test of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: neighbours
/// compute the same edge function with opposite signs, so no ray slips through a shared edge.
struct Shear {
    axes: [usize; 3],
    s: DVec3,
}

impl Shear {
    fn new(d: DVec3) -> Shear {
        let a = d.abs();
        let kz = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        Shear { axes: [kx, ky, kz], s: DVec3::new(d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]) }
    }

    /// Place and barycentric weights of the hit with 0 < t < `t_max`; `None` for a miss and for a triangle seen edge-on.
    #[inline(always)]
    fn hit(&self, triangle: &[DVec3; 3], origin: DVec3, t_max: f64) -> Option<(f64, [f64; 3])> {
        let [kx, ky, kz] = self.axes;
        let corner = |i: usize| {
            let p = triangle[i] - origin;
            (p[kx] - self.s.x * p[kz], p[ky] - self.s.y * p[kz], p[kz])
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(0), corner(1), corner(2));
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let t = (u * az + v * bz + w * cz) * self.s.z / det;
        (t > 0.0 && t < t_max).then(|| (t, [u / det, v / det, w / det]))
    }
}

/// Triangles before their hierarchy is built.
#[derive(Default)]
struct Soup {
    triangles: Vec<[DVec3; 3]>,
    cuts: Vec<u32>,
}

impl Soup {
    fn push(&mut self, scene: &Scene, mesh: &Mesh, cutouts: &mut Cutouts, place: impl Fn(DVec3) -> DVec3) {
        let first = mesh.first_index as usize;
        let tested = mesh.alpha_tested && scene.materials[mesh.material as usize].alpha_cutoff > 0.0;
        if tested && self.cuts.is_empty() {
            self.cuts.resize(self.triangles.len(), OPAQUE);
        }
        let has_cuts = tested || !self.cuts.is_empty();
        for (n, corner) in scene.indices[first..first + mesh.index_count as usize].chunks_exact(3).enumerate() {
            let triangle = [0, 1, 2].map(|k| {
                let p = scene.positions[corner[k] as usize];
                place(DVec3::new(p[0].into(), p[1].into(), p[2].into()))
            });
            if !triangle.iter().all(|p| p.as_vec3().is_finite()) {
                continue;
            }
            self.triangles.push(triangle);
            if has_cuts {
                self.cuts.push(if tested { cutouts.triangle(scene, mesh, n) } else { OPAQUE });
            }
        }
    }

    fn build(self) -> Part {
        let boxes: Vec<Aabb> = self.triangles.iter().map(|t| Aabb::from_points(&t.map(|p| p.as_vec3a()))).collect();
        let (bvh, order) = Bvh::build(&boxes);
        drop(boxes);
        Part {
            triangles: order.iter().map(|&i| self.triangles[i as usize]).collect(),
            cuts: if self.cuts.is_empty() {
                Vec::new()
            } else {
                order.iter().map(|&i| self.cuts[i as usize]).collect()
            },
            bvh,
        }
    }
}

/// Gathers alpha records, once for each triangle of a mesh, and the alpha channels of the textures in use.
struct Cutouts {
    cuts: Vec<Cut>,
    /// First entry in `cuts` of each mesh seen, by its `first_index`.
    seen: std::collections::HashMap<(u32, u32), u32>,
    materials: Vec<Material>,
    copied: Vec<bool>,
    alpha: Vec<u8>,
}

impl Cutouts {
    fn new(scene: &Scene) -> Self {
        Self {
            cuts: Vec::new(),
            seen: std::collections::HashMap::new(),
            materials: scene.materials.clone(),
            copied: vec![false; scene.materials.len()],
            alpha: Vec::new(),
        }
    }

    /// The record of triangle `n` of `mesh`.
    fn triangle(&mut self, scene: &Scene, mesh: &Mesh, n: usize) -> u32 {
        let key = (mesh.first_index, mesh.material);
        let first = match self.seen.get(&key) {
            Some(&first) => first,
            None => {
                let first = self.add(scene, mesh);
                self.seen.insert(key, first);
                first
            }
        };
        first + n as u32
    }

    fn add(&mut self, scene: &Scene, mesh: &Mesh) -> u32 {
        let material = mesh.material as usize;
        let m = &mut self.materials[material];
        if !self.copied[material] && m.texel_offset != NO_TEXTURE {
            let first = m.texel_offset as usize;
            let texels = &scene.texels[first..first + m.width as usize * m.height as usize];
            m.texel_offset = self.alpha.len() as u32;
            self.alpha.extend(texels.iter().map(|t| (t >> 24) as u8));
        }
        self.copied[material] = true;
        let first = self.cuts.len() as u32;
        let range = mesh.first_index as usize..(mesh.first_index + mesh.index_count) as usize;
        self.cuts.extend(scene.indices[range].chunks_exact(3).map(|corner| {
            let at = [0, 1, 2].map(|k| scene.attributes[corner[k] as usize]);
            Cut { uv: at.map(|a| a.uv), alpha: at.map(|a| (a.color >> 24) as f32 / 255.0), material: mesh.material }
        }));
        first
    }
}

fn affine(instance: &Instance) -> (DMat3, DVec3) {
    let [x, y, z] = instance.rows.map(|r| r.map(f64::from));
    let linear = DMat3::from_cols_array_2d(&[[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]);
    (linear, instance.translation())
}

/// Bounds of a placed part, wide enough for the rounding to f32.
fn world_box(part: &Bvh, linear: DMat3, translation: DVec3) -> Aabb {
    let center = linear * ((part.min + part.max) * 0.5) + translation;
    let half = (part.max - part.min) * 0.5;
    let extent = linear.x_axis.abs() * half.x + linear.y_axis.abs() * half.y + linear.z_axis.abs() * half.z;
    let margin = DVec3::splat(1e-6 * (center.abs() + extent).max_element());
    Aabb::new((center - extent - margin).as_vec3a(), (center + extent + margin).as_vec3a())
}
