//! The ray tracer against brute force, the rule of decided pixels, and the metrics on images small enough to count.
#![cfg(feature = "lab")]

use glam::{DVec3, Vec3};
use umbrage::scene::{Attributes, Instance, Material, Mesh, Scene};
use umbrage::truth::{
    GBuffer, Metrics, PixelClass, Reference, Tracer, alpha_at, classify, compare, compare_coverage, ray_offsets,
    reference, reference_coverage, reference_soft, rmse, trace_visibility,
};
use umbrage::{Light, sample_places};

const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

struct Random(u64);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }
    /// In 0..1.
    fn unit(&mut self) -> f32 {
        self.bits() as f32 / 4_294_967_808.0
    }
    /// In -1..1.
    fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
    fn vec(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}

fn material() -> Material {
    Material::default()
}

fn empty_scene() -> Scene {
    Scene {
        bounds_min: DVec3::splat(-1.0),
        bounds_max: DVec3::splat(1.0),
        materials: vec![material()],
        ..Scene::default()
    }
}

/// Adds a mesh of loose triangles (corner, uv, vertex alpha) with its own copy of `material`.
fn add_mesh(scene: &mut Scene, corners: &[(Vec3, [f32; 2], u8)], material: Material, rows: &[[[f32; 4]; 3]]) {
    let (mesh, first_index) = (scene.meshes.len() as u32, scene.indices.len() as u32);
    let material_index = scene.materials.len() as u32;
    scene.materials.push(material);
    for (position, uv, alpha) in corners {
        scene.indices.push(scene.positions.len() as u32);
        scene.positions.push(position.to_array());
        scene.attributes.push(Attributes { uv: *uv, color: u32::from(*alpha) << 24 | 0x00ff_ffff });
    }
    scene.meshes.push(Mesh {
        first_index,
        index_count: corners.len() as u32,
        first_cluster: 0,
        cluster_count: 0,
        material: material_index,
        first_instance: scene.instances.len() as u32,
        instance_count: rows.len() as u32,
        casts: true,
        alpha_tested: material.alpha_cutoff > 0.0,
    });
    let instance =
        |rows: &_| Instance { rows: *rows, low: [0.0; 4], material: material_index, mesh, revision: 0, flags: 0 };
    scene.instances.extend(rows.iter().map(instance));
}

/// A quad at height `y` over `min..max` in x and z.
fn add_quad(scene: &mut Scene, y: f32, min: [f32; 2], max: [f32; 2]) {
    let p = |x: f32, z: f32| (Vec3::new(x, y, z), [0.0; 2], 255);
    let (a, b, c, d) = (p(min[0], min[1]), p(max[0], min[1]), p(max[0], max[1]), p(min[0], max[1]));
    add_mesh(scene, &[a, b, c, a, c, d], material(), &[IDENTITY]);
}

fn soup(random: &mut Random, triangles: usize, instances: usize, wrap: u32, alpha: bool) -> Scene {
    let mut scene = empty_scene();
    scene.texels = (0..5 * 3).map(|_| random.bits()).collect();
    for textured in [false, alpha] {
        let corners: Vec<_> = (0..triangles)
            .flat_map(|_| {
                let (center, size) = (random.vec(), 1.5 * random.unit());
                [0; 3].map(|_| {
                    let alpha = 128 + (random.bits() % 128) as u8;
                    (center + size * random.vec(), [3.0 * random.signed(), 3.0 * random.signed()], alpha)
                })
            })
            .collect();
        let mut m = material();
        if textured {
            m = Material {
                texel_offset: 0,
                width: 5,
                height: 3,
                wrap,
                alpha_cutoff: 0.4,
                uv_row0: [0.8, -0.3, 0.2, 0.0],
                uv_row1: [0.4, 1.1, -0.1, 0.0],
                ..m
            };
            m.base_color[3] = 0.9;
        }
        let rows: Vec<_> = (0..instances)
            .map(|k| {
                let (axes, at) = ([random.vec(), random.vec(), random.vec()], 2.0 * random.vec());
                // one instance is flattened: its matrix has no inverse
                let x = if k == 1 { Vec3::ZERO } else { axes[0] };
                [0, 1, 2].map(|r| [x[r], axes[1][r], axes[2][r], at[r]])
            })
            .collect();
        add_mesh(&mut scene, &corners, m, &rows);
    }
    scene
}

/// Texture alpha by its definition: the sum over all texels of a tent filter, in f64, each mode as a list of copies.
fn tent_alpha(m: &Material, texels: &[u32], uv: [f64; 2]) -> f64 {
    let row = |r: [f32; 4]| f64::from(r[0]) * uv[0] + f64::from(r[1]) * uv[1] + f64::from(r[2]);
    let weights = |x: f64, n: i64, mode: u32| -> Vec<f64> {
        let mut w = vec![0.0; n as usize];
        for i in -20 * n..20 * n {
            let tent = 1.0 - (x * n as f64 - (i as f64 + 0.5)).abs();
            if tent > 0.0 {
                let folded = match mode {
                    0 => i.rem_euclid(n),
                    1 if i.div_euclid(n) % 2 != 0 => n - 1 - i.rem_euclid(n),
                    1 => i.rem_euclid(n),
                    _ => i.max(0).min(n - 1),
                };
                w[folded as usize] += tent;
            }
        }
        w
    };
    let wx = weights(row(m.uv_row0), i64::from(m.width), m.wrap & 3);
    let wy = weights(row(m.uv_row1), i64::from(m.height), m.wrap >> 2);
    let alpha = |x: usize, y: usize| f64::from(texels[y * m.width as usize + x] >> 24) / 255.0;
    let sum_row = |y: usize| (0..wx.len()).map(|x| wx[x] * alpha(x, y)).sum::<f64>();
    (0..wy.len()).map(|y| wy[y] * sum_row(y)).sum()
}

/// The share of the light that passes, by Moeller-Trumbore over everything; `None` when the answer hangs on rounding.
fn brute_force(scene: &Scene, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
    let mut passes = 1.0;
    for mesh in scene.meshes.iter().filter(|m| m.casts) {
        let m = &scene.materials[mesh.material as usize];
        for instance in &scene.instances[mesh.first_instance as usize..][..mesh.instance_count as usize] {
            let rows = instance.rows.map(|r| r.map(f64::from));
            for corner in scene.indices[mesh.first_index as usize..][..mesh.index_count as usize].chunks(3) {
                let at = |k: usize| {
                    let p = Vec3::from_array(scene.positions[corner[k] as usize]).as_dvec3();
                    DVec3::from_array(rows.map(|r| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]))
                };
                let (p0, e1, e2) = (at(0), at(1) - at(0), at(2) - at(0));
                let q = direction.cross(e2);
                let det = e1.dot(q);
                if det.abs() < 1e-9 {
                    continue;
                }
                let u = (origin - p0).dot(q) / det;
                let r = (origin - p0).cross(e1);
                let (v, t) = (direction.dot(r) / det, e2.dot(r) / det);
                let inside = u.min(v).min(1.0 - u - v).min(t).min(t_max - t);
                if inside.abs() < 1e-4 {
                    return None;
                }
                if inside < 0.0 {
                    continue;
                }
                if mesh.alpha_tested {
                    let a = [0, 1, 2].map(|k| scene.attributes[corner[k] as usize]);
                    let mix = |f: &dyn Fn(&Attributes) -> f64| (1.0 - u - v) * f(&a[0]) + u * f(&a[1]) + v * f(&a[2]);
                    let uv = [mix(&|a| a.uv[0].into()), mix(&|a| a.uv[1].into())];
                    let vertex = mix(&|a| f64::from(a.color >> 24) / 255.0);
                    let alpha = f64::from(m.base_color[3]) * vertex * tent_alpha(m, &scene.texels, uv);
                    if m.translucent == 1 {
                        passes *= 1.0 - alpha;
                        continue;
                    }
                    let over = alpha - f64::from(m.alpha_cutoff);
                    if over.abs() < 1e-3 {
                        return None;
                    }
                    if over < 0.0 {
                        continue;
                    }
                }
                passes = 0.0;
            }
        }
    }
    Some(passes)
}

#[test]
fn tracer_equals_brute_force() {
    let mut total = (0, 0);
    for (seed, triangles, instances, alpha) in [
        (1, 0, 1, false),
        (2, 1, 1, false),
        (3, 2, 3, true),
        (4, 5, 1, true),
        (5, 40, 1, true),
        (6, 6, 9, true),
        (7, 6, 9, false),
    ] {
        for wrap in [0b0000, 0b0101, 0b1010, 0b0110] {
            let mut random = Random(seed);
            let scene = soup(&mut random, triangles, instances, wrap, alpha);
            let tracers = [Tracer::new(&scene), Tracer::with_flat_limit(&scene, 0)];
            let (mut hits, mut misses) = (0, 0);
            for _ in 0..300 {
                let origin = 3.0 * random.vec().as_dvec3();
                let direction = (2.0 * random.vec().as_dvec3() - origin) * 10f64.powi(random.bits() as i32 % 3);
                let t_max = if random.bits() < 1 << 31 { f64::INFINITY } else { f64::from(2.0 * random.unit()) };
                let Some(passes) = brute_force(&scene, origin, direction, t_max) else { continue };
                let want = passes == 0.0;
                if want {
                    hits += 1
                } else {
                    misses += 1
                }
                for (k, tracer) in tracers.iter().enumerate() {
                    let got = tracer.occluded(origin, direction, t_max);
                    assert_eq!(
                        got, want,
                        "seed {seed} wrap {wrap} tracer {k} from {origin} along {direction} to {t_max}"
                    );
                    let first = tracer.first_hit(origin, direction, t_max);
                    assert_eq!(first.is_some(), want, "seed {seed} wrap {wrap} tracer {k}");
                    for (share, blocked) in [(1.0 - 1e-6, false), (1.0 + 1e-6, true)] {
                        let to = |t| tracer.occluded(origin, direction, t * share);
                        assert!(
                            first.is_none_or(|t| to(t) == blocked),
                            "seed {seed} wrap {wrap} tracer {k}: {first:?}"
                        );
                    }
                }
            }
            total = (total.0 + hits, total.1 + misses);
            assert!(misses > 20, "seed {seed}: {misses} misses");
            assert!(hits > 20 || triangles * instances < 20, "seed {seed}: {hits} hits");
        }
    }
    assert!(total.0 > 800 && total.1 > 800, "hits and misses: {total:?}");
}

#[test]
fn transmittance_is_the_product_over_all_casters() {
    let (mut shares, mut dark, mut clear) = (0, 0, 0);
    for (seed, triangles, instances) in [(1, 5, 1), (2, 40, 1), (3, 6, 9)] {
        let mut random = Random(seed);
        let mut scene = soup(&mut random, triangles, instances, 0b0101, true);
        scene.materials.iter_mut().filter(|m| m.alpha_cutoff > 0.0).for_each(|m| m.translucent = 1);
        let tracers = [Tracer::new(&scene), Tracer::with_flat_limit(&scene, 0)];
        for _ in 0..1000 {
            let origin = 3.0 * random.vec().as_dvec3();
            let direction = 2.0 * random.vec().as_dvec3() - origin;
            let t_max = if random.bits() < 1 << 31 { f64::INFINITY } else { f64::from(2.0 * random.unit()) };
            let Some(want) = brute_force(&scene, origin, direction, t_max) else { continue };
            for (k, tracer) in tracers.iter().enumerate() {
                let got = tracer.transmittance(origin, direction, t_max);
                assert!((got - want).abs() < 1e-5, "seed {seed} tracer {k}: {got}, not {want}");
                let dark = tracer.occluded(origin, direction, t_max);
                assert!(dark == (want < 0.5) || (want - 0.5).abs() < 1e-5, "seed {seed} tracer {k}: {want}");
            }
            match want {
                0.0 => dark += 1,
                1.0 => clear += 1,
                _ => shares += 1,
            }
        }
    }
    assert!(shares > 300 && dark > 100 && clear > 300, "{shares} shares, {dark} dark, {clear} clear");
}

#[test]
fn axis_parallel_rays_and_flat_boxes() {
    let mut scene = empty_scene();
    add_quad(&mut scene, 0.25, [-1.0, -1.0], [1.0, 1.0]);
    let tracer = Tracer::new(&scene);
    for direction in [DVec3::Y, DVec3::new(0.0, 1e-3, 0.0), DVec3::new(-0.0, 2.0, 0.0)] {
        assert!(tracer.occluded(DVec3::new(0.1, 0.2499, 0.3), direction, f64::INFINITY));
        assert!(!tracer.occluded(DVec3::new(0.1, 0.2501, 0.3), direction, f64::INFINITY));
        assert!(tracer.occluded(DVec3::new(0.1, -1e9, 0.3), direction, f64::INFINITY), "from far away");
    }
    assert!(!tracer.occluded(DVec3::new(0.0, 0.0, 0.0), DVec3::Y, 0.25), "t_max is excluded");
    assert!(tracer.occluded(DVec3::new(0.0, 0.0, 0.0), DVec3::Y, 0.250001));
    assert!(!tracer.occluded(DVec3::new(0.0, 0.0, 0.0), DVec3::X, f64::INFINITY));
    scene.meshes[0].casts = false;
    assert!(!Tracer::new(&scene).occluded(DVec3::ZERO, DVec3::Y, f64::INFINITY), "does not cast");
}

#[test]
fn no_ray_slips_through_a_shared_edge() {
    const N: usize = 12;
    let mut random = Random(11);
    let heights: Vec<f32> = (0..(N + 1) * (N + 1)).map(|_| 0.3 * random.signed()).collect();
    let at = |x: usize, z: usize| Vec3::new(x as f32 / 7.0, heights[z * (N + 1) + x], z as f32 / 7.0);
    let mut corners = Vec::new();
    for (x, z) in (0..N * N).map(|i| (i % N, i / N)) {
        let quad = [at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)].map(|p| (p, [0.0; 2], 255));
        corners.extend([quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]]);
    }
    let mut scene = empty_scene();
    add_mesh(&mut scene, &corners, material(), &[IDENTITY, IDENTITY]);
    let tracers = [Tracer::new(&scene), Tracer::with_flat_limit(&scene, 0)];
    for _ in 0..20_000 {
        let (x, z) = (1 + random.bits() as usize % (N - 2), 1 + random.bits() as usize % (N - 2));
        let a = at(x, z).as_dvec3();
        let b = at(x + random.bits() as usize % 2, z + 1).as_dvec3();
        let direction = DVec3::new(0.2 * f64::from(random.signed()), 1.0, 0.2 * f64::from(random.signed()));
        let origin = a.lerp(b, f64::from(random.bits() % 5) / 4.0) - direction;
        for tracer in &tracers {
            assert!(tracer.occluded(origin, direction, f64::INFINITY), "from {origin} along {direction}");
        }
    }
}

#[test]
fn alpha_by_hand() {
    let texels = [0u8, 255, 255, 51];
    let textured = Material { texel_offset: 0, width: 2, height: 2, ..material() };
    let (repeat, mirror, clamp) = (0b0000, 0b0101, 0b1010);
    for (wrap, uv, want) in [
        (repeat, [0.25, 0.25], 0.0),
        (repeat, [0.75, 0.25], 1.0),
        (repeat, [0.75, 0.75], 0.2),
        (repeat, [0.5, 0.25], 0.5),
        (repeat, [0.5, 0.75], 0.6),
        (repeat, [0.0, 0.25], 0.5),
        (repeat, [-0.75, 2.25], 0.0),
        (mirror, [0.0, 0.25], 0.0),
        (mirror, [1.0, 0.25], 1.0),
        (mirror, [1.75, 0.25], 0.0),
        (mirror, [-0.75, 0.25], 1.0),
        (clamp, [0.0, 0.25], 0.0),
        (clamp, [9.0, -9.0], 1.0),
        (clamp, [9.0, 9.0], 0.2),
        (0b1000, [-0.25, 9.0], 0.2),
    ] {
        let got = alpha_at(&Material { wrap, ..textured }, |i| texels[i as usize], uv, 1.0);
        assert!((got - want).abs() < 1e-6, "wrap {wrap:04b} uv {uv:?}: {got}, not {want}");
    }
    let mut factor = material();
    factor.base_color[3] = 0.5;
    assert_eq!(alpha_at(&factor, |_| 0, [0.0; 2], 0.5), 0.25);
    let shifted = Material { uv_row0: [0.0, 1.0, 0.5, 0.0], uv_row1: [1.0, 0.0, 0.0, 0.0], ..textured };
    assert_eq!(alpha_at(&shifted, |i| texels[i as usize], [0.75, 0.25], 1.0), texels[3] as f32 / 255.0);
}

#[test]
fn cutoff_keeps_alpha_equal_to_it() {
    for (alpha, solid) in [(0.5, true), (0.499, false)] {
        let mut scene = empty_scene();
        let mut m = Material { alpha_cutoff: 0.5, ..material() };
        m.base_color[3] = alpha;
        let corners = [Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, 1.0, -1.0), Vec3::new(0.0, 1.0, 1.0)];
        add_mesh(&mut scene, &corners.map(|p| (p, [0.0; 2], 255)), m, &[IDENTITY]);
        assert_eq!(Tracer::new(&scene).occluded(DVec3::ZERO, DVec3::Y, f64::INFINITY), solid, "alpha {alpha}");
    }
}

/// Position and normal; `None` for the sky.
type Surface = Option<(Vec3, Vec3)>;

/// One pixel an entry, seen from afar: all footprints are large.
fn gbuffer(pixels: &[Surface]) -> GBuffer {
    let eye = Vec3::new(0.0, 64.0, 0.0);
    GBuffer {
        eye: eye.as_dvec3(),
        ray_steps: [DVec3::X, DVec3::Z],
        width: pixels.len() as u32,
        height: 1,
        position: pixels.iter().map(|p| p.map_or([0.0; 3], |p| (p.0 - eye).to_array())).collect(),
        normal: pixels.iter().map(|p| p.map_or([0.0; 3], |p| p.1.to_array())).collect(),
        albedo: vec![u32::MAX; pixels.len()],
        hit: pixels.iter().map(Option::is_some).collect(),
    }
}

fn trace(scene: &Scene, gbuffer: &GBuffer, light: &Light) -> Result<Reference, umbrage::truth::TruthError> {
    reference(&Tracer::new(scene), scene, gbuffer, light, &|_| {})
}

#[test]
fn decided_pixels() {
    let mut scene = Scene { bounds_min: DVec3::ZERO, bounds_max: DVec3::new(0.0, 100.0, 0.0), ..empty_scene() };
    // heights in the scene's diagonal of 100: above all origins, between them, and below the first
    for (x, share) in [(2.0, 0.3), (4.0, 5e-5), (6.0, 2e-5), (8.0, 5e-6), (10.0, 5e-7)] {
        add_quad(&mut scene, 100.0 * share, [x - 0.5, -0.5], [x + 0.5, 0.5]);
    }
    let up = |x: f32| Some((Vec3::new(x, 0.0, 0.0), Vec3::Y));
    let tilted = |n_dot_l: f32| Some((Vec3::ZERO, Vec3::new((1.0 - n_dot_l * n_dot_l).sqrt(), n_dot_l, 0.0)));
    let pixels = [
        ("lit", up(0.0), 1, true),
        ("shadowed", up(2.0), 0, true),
        ("the last origin is above the caster", up(4.0), 0, false),
        ("two origins are above the caster", up(6.0), 0, false),
        ("only the first origin is below the caster", up(8.0), 1, false),
        ("all origins are above the caster", up(10.0), 1, true),
        ("grazing, lit", tilted(0.0099), 1, false),
        ("just decided", tilted(0.0101), 1, true),
        ("away from the light", tilted(-0.5), 0, false),
        ("edge-on", tilted(0.0), 0, false),
        ("sky", None, 0, false),
    ];
    let gbuffer = gbuffer(&pixels.map(|p| p.1));
    // the length of the direction must not matter
    let got = trace(&scene, &gbuffer, &Light::directional(DVec3::new(0.0, -3.0, 0.0))).unwrap();
    for (i, (name, _, visibility, decided)) in pixels.iter().enumerate() {
        assert_eq!((got.visibility[i], got.decided[i]), (*visibility, *decided), "{name}");
    }
    let image = got.visibility_image();
    assert_eq!(image[10], 1.0, "sky is 1 in the file");
    assert_eq!((image[0], image[1], image[8], image[9]), (1.0, 0.0, 0.0, 0.0));
}

#[test]
fn coverage_is_the_share_of_samples_beside_the_caster() {
    let mut scene = Scene { bounds_min: DVec3::ZERO, bounds_max: DVec3::new(0.0, 100.0, 0.0), ..empty_scene() };
    add_quad(&mut scene, 2.0, [-9.0, -9.0], [0.0, 9.0]);
    // a bump within a fifth of the way to the samples is the pixel's own surface, one of two fifths is not
    add_quad(&mut scene, 0.02, [19.8, -0.2], [20.2, 0.2]);
    add_quad(&mut scene, 0.6, [29.0, -1.0], [31.0, 1.0]);
    let places = [-3.0f32, -0.5, -0.3, -0.1, 0.0, 0.2, 0.4, 0.49, 3.0];
    let up = |x: f32| Some((Vec3::new(x, 0.0, 0.0), Vec3::Y));
    let pixels: Vec<Surface> = places.into_iter().map(up).chain([up(19.5), up(30.0), None]).collect();
    // a pixel is as long and wide as a unit of the ground
    let gbuffer = GBuffer { ray_steps: [DVec3::X / 64.0, DVec3::Z / 64.0], ..gbuffer(&pixels) };
    let (tracer, light) = (Tracer::new(&scene), Light::directional(DVec3::NEG_Y));
    let whole = trace(&scene, &gbuffer, &light).unwrap();
    for samples in [1, 4, 16] {
        let got = reference_coverage(&tracer, &scene, &gbuffer, &light, samples, &|_| {}).unwrap();
        let lit = |x: f32| sample_places(samples).iter().filter(|place| f64::from(x) + place[0] > 0.0).count();
        let want = places.iter().map(|&x| lit(x) as f32 / samples as f32);
        let want: Vec<f32> = want.chain([1.0, 0.0, 1.0]).collect();
        assert_eq!(got[..4], want[..4], "{samples} samples");
        assert_eq!(got[5..], want[5..], "{samples} samples");
        let same = compare_coverage(&got, &got, &whole).unwrap();
        assert_eq!((same.mean, same.edge, same.worst, same.pixels), (0.0, 0.0, 0.0, 11), "{same:?}");
        let edges = got.iter().filter(|&&share| share > 0.0 && share < 1.0).count();
        assert_eq!(same.edge_pixels as usize, edges);
        assert!(edges >= if samples > 1 { 3 } else { 0 });
        let dark = compare_coverage(&vec![0.0; got.len()], &got, &whole).unwrap();
        let sum: f32 = got[..11].iter().sum();
        assert!((dark.mean - 100.0 * f64::from(sum) / 11.0).abs() < 1e-4 && dark.worst == 100.0, "{dark:?}");
    }
    let places = sample_places(16);
    for axis in 0..2 {
        let mut rows: Vec<f64> = places.iter().map(|place| 16.0 * (place[axis] + 0.5)).collect();
        rows.sort_by(f64::total_cmp);
        assert!((0..16).all(|i| rows[i] == i as f64 + 0.5), "{rows:?}");
    }
    assert!(compare_coverage(&[1.0], &[1.0], &whole).is_err());
    assert!(compare_coverage(&[f32::NAN; 12], &[0.0; 12], &whole).is_err());
}

/// Asserts visibility, decided and facing of each pixel, and that one ray a pixel gives the same visibility.
#[track_caller]
fn expect(scene: &Scene, light: &Light, pixels: &[(&str, Surface, u8, bool, bool)]) {
    let gbuffer = gbuffer(&pixels.iter().map(|p| p.1).collect::<Vec<_>>());
    let got = trace(scene, &gbuffer, light).unwrap();
    for (i, (name, _, visibility, decided, facing)) in pixels.iter().enumerate() {
        assert_eq!((got.visibility[i], got.decided[i], got.facing[i]), (*visibility, *decided, *facing), "{name}");
    }
    let traced = trace_visibility(&Tracer::new(scene), scene, &gbuffer, light).unwrap();
    assert_eq!(traced, got.visibility_image());
}

fn floor(x: f32) -> Surface {
    Some((Vec3::new(x, 0.0, 0.0), Vec3::Y))
}

#[test]
fn a_point_light_over_a_blocker() {
    // the scene's diagonal is 100; the light stands 4 above the scene's origin, which is not the world's
    let origin = DVec3::new(30.0, -7.0, 11.0);
    let mut scene = Scene { origin, bounds_min: DVec3::ZERO, bounds_max: DVec3::new(0.0, 100.0, 0.0), ..empty_scene() };
    add_quad(&mut scene, 2.0, [-1.0, -1.0], [1.0, 1.0]);
    let light = Light::Point { position: origin + DVec3::new(0.0, 4.0, 0.0), range: 5.0 };
    // the shadow of the quad's edge at x = 1, y = 2 falls on x = 2, that of y = 0.01 on x = 1.995
    expect(
        &scene,
        &light,
        &[
            ("below the blocker", floor(0.0), 0, true, true),
            ("just in the shadow", floor(1.98), 0, true, true),
            ("within the shadow's edge for some origins", floor(1.998), 0, false, true),
            ("just out of the shadow", floor(2.001), 1, true, true),
            ("within the range 5 of a light at 4", floor(2.99), 1, true, true),
            ("on the blocker's upper side", Some((Vec3::new(0.0, 2.0, 0.0), Vec3::Y)), 1, true, true),
            ("beyond the range", floor(3.01), 0, false, false),
            ("in range only from the upper origins", floor(3.001), 0, false, false),
            ("in range, but away from the light", Some((Vec3::new(2.5, 0.0, 0.0), Vec3::NEG_Y)), 0, false, false),
            ("at the light itself", Some((Vec3::new(0.0, 4.0, 0.0), Vec3::Y)), 0, false, false),
            ("sky", None, 0, false, false),
        ],
    );
}

#[test]
fn what_stands_behind_a_light_casts_nothing() {
    let mut scene = Scene { bounds_max: DVec3::ONE, bounds_min: DVec3::ZERO, ..empty_scene() };
    add_quad(&mut scene, 4.001, [-9.0, -9.0], [9.0, 9.0]);
    let position = DVec3::new(0.0, 4.0, 0.0);
    let spot =
        Light::Spot { position, direction: DVec3::NEG_Y, inner_angle_deg: 0.0, outer_angle_deg: 90.0, range: 20.0 };
    for light in [Light::Point { position, range: 20.0 }, spot] {
        expect(&scene, &light, &[("below", floor(0.0), 1, true, true), ("aside", floor(8.0), 1, true, true)]);
    }
    expect(&scene, &Light::directional(DVec3::NEG_Y), &[("from the sky", floor(0.0), 0, true, true)]);
}

#[test]
fn the_edge_of_a_cone() {
    // 45 degrees from 4 above: the cone meets the floor at x = 4, and at x = 3.99 for an origin 0.01 above it
    let scene = Scene { bounds_min: DVec3::ZERO, bounds_max: DVec3::new(0.0, 100.0, 0.0), ..empty_scene() };
    let light = Light::Spot {
        position: DVec3::new(0.0, 4.0, 0.0),
        direction: DVec3::new(0.0, -3.0, 0.0),
        inner_angle_deg: 10.0,
        outer_angle_deg: 45.0,
        range: 50.0,
    };
    expect(
        &scene,
        &light,
        &[
            ("on the axis", floor(0.0), 1, true, true),
            ("in the cone from all origins", floor(3.98), 1, true, true),
            ("in the cone from the lower origins", floor(3.995), 1, false, true),
            ("out of the cone", floor(4.001), 0, false, false),
            ("behind the light", Some((Vec3::new(0.0, 5.0, 0.0), Vec3::NEG_Y)), 0, false, false),
        ],
    );
}

/// A 10 km ground, a tower 2 km from an eye 2 cm above it, and a box of 1 cm beside the eye and 3 km from the scene's
/// origin, all stored in f32. The sun shines along x, 1 down in 10; the side edge of the tower's shadow and both of the
/// box's are known exactly.
#[test]
fn a_centimetre_in_ten_kilometres() {
    let at = |size: [f32; 3], to: [f32; 3]| {
        [0, 1, 2].map(|r| {
            [0, 1, 2, 3].map(|c| {
                if c == 3 {
                    to[r]
                } else if c == r {
                    size[r]
                } else {
                    0.0
                }
            })
        })
    };
    let mut scene = Scene { origin: DVec3::new(4e5, 70.0, -2e5), ..empty_scene() };
    (scene.bounds_min, scene.bounds_max) = (DVec3::new(-5e3, 0.0, -5e3), DVec3::new(5e3, 250.0, 5e3));
    add_quad(&mut scene, 0.0, [-5e3, -5e3], [5e3, 5e3]);
    let box_center = [300.3, 0.0051, 3050.05f32];
    let cube = unit_cube();
    add_mesh(&mut scene, &cube, material(), &[at([10.0, 125.0, 50.0], [-1700.0, 125.0, 3000.0])]);
    add_mesh(&mut scene, &cube, material(), &[at([0.005; 3], box_center), at([0.005; 3], [-300.3, 0.0051, -3050.05])]);
    let [box_x, _, box_z] = box_center.map(f64::from);
    let (box_low, box_high) = (box_z - f64::from(0.005f32), box_z + f64::from(0.005f32));

    let eye = DVec3::new(300.35, 0.02, 3050.02);
    let pixel = 1e-3;
    // x, the edge in z, what lies above it, what below; footprints are 30 to 60 micrometres
    let edges = [(300.36, 3050.0, 1, 0), (box_x + 0.03, box_low, 0, 1), (box_x + 0.08, box_high, 1, 0)];
    let mut want = Vec::new();
    let mut position = Vec::new();
    for (x, z, above, below) in edges {
        let footprint = pixel * (DVec3::new(x, 0.0, z) - eye).length();
        for (step, visible) in [(0.1, above), (-0.1, below), (3.0, above), (-3.0, below)] {
            position.push((DVec3::new(x, 0.0, z + step * footprint) - eye).as_vec3().to_array());
            want.push(visible);
        }
    }
    let count = want.len();
    let gbuffer = GBuffer {
        width: count as u32,
        height: 1,
        eye,
        ray_steps: [pixel * DVec3::X, pixel * DVec3::Z],
        position,
        normal: vec![[0.0, 1.0, 0.0]; count],
        albedo: vec![0; count],
        hit: vec![true; count],
    };
    for i in 0..count {
        let [own, least, _, most] = ray_offsets(&scene, &gbuffer, i).map(|offset| offset / gbuffer.footprint(i));
        assert!((own - 0.01).abs() < 1e-9 && (least - 0.001).abs() < 1e-9 && (most - 0.1).abs() < 1e-9);
    }
    let light = Light::directional(DVec3::new(10.0, -1.0, 0.0));
    for tracer in [Tracer::new(&scene), Tracer::with_flat_limit(&scene, 0)] {
        let got = reference(&tracer, &scene, &gbuffer, &light, &|_| {}).unwrap();
        assert_eq!(got.visibility, want);
        assert_eq!(got.decided, vec![true; count]);
        assert_eq!(trace_visibility(&tracer, &scene, &gbuffer, &light).unwrap(), got.visibility_image());
    }
}

/// The cube from -1 to 1.
fn unit_cube() -> Vec<(Vec3, [f32; 2], u8)> {
    let mut corners = Vec::new();
    for (axis, side) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0f32)] {
        let p = |u: f32, v: f32| {
            let mut p = Vec3::splat(side);
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
            (p, [0.0; 2], 255)
        };
        let quad = [p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)];
        corners.extend([quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]]);
    }
    corners
}

#[test]
fn reference_rejects_what_it_cannot_use() {
    let scene = empty_scene();
    let good = gbuffer(&[Some((Vec3::ZERO, Vec3::Y))]);
    let down = Light::directional(DVec3::NEG_Y);
    let spot = |direction, outer_angle_deg| Light::Spot {
        position: DVec3::ZERO,
        direction,
        inner_angle_deg: 0.0,
        outer_angle_deg,
        range: 1.0,
    };
    assert!(trace(&scene, &good, &down).is_ok());
    for (light, word) in [
        (Light::directional(DVec3::ZERO), "direction"),
        (Light::directional(DVec3::NAN), "direction"),
        (Light::Directional { direction: DVec3::X, angular_diameter_deg: 0.5 }, "extent"),
        (Light::Area { polygon: vec![DVec3::X; 3] }, "extent"),
        (Light::Point { position: DVec3::NAN, range: 1.0 }, "position"),
        (Light::Point { position: DVec3::X, range: f64::NAN }, "range is NaN, above 0"),
        (spot(DVec3::ZERO, 45.0), "direction"),
        (spot(DVec3::X, 91.0), "outer angle is 91 degrees"),
    ] {
        let error = trace(&scene, &good, &light).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    let short = GBuffer { normal: Vec::new(), ..good.clone() };
    assert!(trace(&scene, &short, &down).unwrap_err().to_string().contains("normal"));
    assert!(trace(&scene, &GBuffer::default(), &down).is_err(), "no pixel");
    let flat = GBuffer { ray_steps: [DVec3::X; 2], ..good.clone() };
    assert!(trace(&scene, &flat, &down).unwrap_err().to_string().contains("span a pixel"));
}

#[test]
fn progress_ends_at_one() {
    let (scene, light) = (empty_scene(), Light::directional(DVec3::NEG_Y));
    let rows = GBuffer { width: 1, height: 5, ..gbuffer(&[Some((Vec3::ZERO, Vec3::Y)); 5]) };
    let seen = std::sync::Mutex::new(Vec::new());
    reference(&Tracer::new(&scene), &scene, &rows, &light, &|p| seen.lock().unwrap().push(p)).unwrap();
    let mut seen = seen.into_inner().unwrap();
    seen.sort_by(f64::total_cmp);
    assert_eq!(seen, [0.2, 0.4, 0.6, 0.8, 1.0]);
}

/// `.` lit, `#` shadowed, `o` lit but undecided, `%` shadowed but undecided, `-` n.l <= 0, blank: no surface.
fn picture(rows: &[&str]) -> Reference {
    let text: Vec<u8> = rows.concat().into_bytes();
    let each = |set: &[u8]| text.iter().map(|c| set.contains(c)).collect::<Vec<_>>();
    Reference {
        width: rows[0].len() as u32,
        height: rows.len() as u32,
        visibility: text.iter().map(|c| u8::from(b".o".contains(c))).collect(),
        decided: each(b".#"),
        hit: each(b".#o%-"),
        facing: each(b".#o%"),
    }
}

/// Asserts the classes of `result` against `reference`: `e` on edge, `a` acne, `k` leak, `L` lost, the reference's own
/// character elsewhere; and that the metrics count the same.
fn check(name: &str, reference: &[&str], result: &[&str], want: &[&str], edge_pixels: u64) {
    let truth = picture(reference);
    let classes = classify(&picture(result).visibility_image(), &truth).unwrap();
    let got: String = classes
        .iter()
        .zip(reference.concat().chars())
        .map(|(class, c)| match class {
            PixelClass::OnEdge => 'e',
            PixelClass::Acne => 'a',
            PixelClass::Leak => 'k',
            PixelClass::Lost => 'L',
            PixelClass::Sky => ' ',
            PixelClass::Lit => '.',
            PixelClass::Shadowed => '#',
            PixelClass::Undecided => c,
        })
        .collect();
    assert_eq!(got, want.concat(), "{name}");
    let m = compare(&picture(result).visibility_image(), &truth).unwrap();
    let count = |set: &str| want.concat().chars().filter(|c| set.contains(*c)).count() as u64;
    let decided = truth.decided.iter().filter(|d| **d).count() as u64;
    assert_eq!(
        (m.decided_pixels, m.edge_pixels, m.differing, m.off_edge_pixels),
        (decided, edge_pixels, count("eakL"), count("akL")),
        "{name}"
    );
    assert_eq!((m.acne_pixels, m.leak_pixels, m.lost_pixels), (count("a"), count("kL"), count("L")), "{name}");
    let share = |n: u64| 100.0 * n as f64 / decided as f64;
    assert_eq!((m.mismatch, m.off_edge), (share(count("eakL")), share(count("akL"))), "{name}");
    assert_eq!((m.acne, m.leak, m.lost), (share(count("a")), share(count("kL")), share(count("L"))), "{name}");
}

#[test]
fn every_kind_of_error_is_one_known_pixel() {
    let lit = ["....."; 5];
    let dark = ["#####"; 5];
    check("equal", &lit, &lit, &lit, 0);
    check(
        "acne",
        &lit,
        &[".....", ".....", "..#..", ".....", "....."],
        &[".....", ".....", "..a..", ".....", "....."],
        0,
    );
    check(
        "leak",
        &dark,
        &["#####", "#####", "##.##", "#####", "#####"],
        &["#####", "#####", "##k##", "#####", "#####"],
        0,
    );
    check("all lost", &["###"; 2], &["..."; 2], &["LLL"; 2], 0);
    let dot = [".....", ".....", "..#..", ".....", "....."];
    check("lost dot", &dot, &lit, &[".....", ".....", "..L..", ".....", "....."], 5);
    let shifted = [".....", ".....", "...#.", ".....", "....."];
    check("moved dot", &dot, &shifted, &[".....", ".....", "..ee.", ".....", "....."], 5);
    let corner = [".....", "...#.", ".....", ".....", "....."];
    check("dot moved over a corner", &dot, &corner, &[".....", "...e.", "..e..", ".....", "....."], 5);
    let far = [".....", ".....", "....#", ".....", "....."];
    check("dot moved by two", &dot, &far, &[".....", ".....", "..L.a", ".....", "....."], 5);
    let knight = ["...#.", ".....", ".....", ".....", "....."];
    check("dot moved by sqrt 5", &dot, &knight, &["...a.", ".....", "..L..", ".....", "....."], 5);
}

#[test]
fn a_moved_edge_counts_once_a_row() {
    let edge = ["###....."; 4];
    check("by one", &edge, &["####...."; 4], &["###e...."; 4], 8);
    check("by one, back", &edge, &["##......"; 4], &["##e....."; 4], 8);
    check("by two", &edge, &["#####..."; 4], &["###aa..."; 4], 8);
    check("by two, back", &edge, &["#......."; 4], &["#kL....."; 4], 8);
}

#[test]
fn sky_and_terminator_are_edges() {
    // the result holds 1 in the sky and still counts as 0 there
    check("shadow grown from the sky", &["  ...."; 3], &["  #..."; 3], &["  e..."; 3], 3);
    check("acne away from the sky", &["  ......"], &["  ...#.."], &["  ...a.."], 1);
    check("thin shadow lost beside the sky", &[" #..."; 3], &[" ...."; 3], &[" e..."; 3], 6);
    check("terminator", &["--...."; 3], &["--#..."; 3], &["--e..."; 3], 3);
    let dark_sky = Reference {
        visibility: vec![0; 4],
        decided: vec![false; 4],
        hit: vec![false; 4],
        facing: vec![false; 4],
        width: 4,
        height: 1,
    };
    let m = compare(&[1.0, 0.0, 1.0, 0.0], &dark_sky).unwrap();
    assert_eq!((m.mismatch, m.edge_error, m.decided_pixels), (0.0, 0.0, 0));
}

#[test]
fn undecided_pixels_explain_but_do_not_count() {
    check("undecided", &["..o%##"], &["..%o##"], &["..o%##"], 0);
    check("explained by an undecided pixel", &["....%%%"], &["...####"], &["...e%%%"], 1);
}

#[test]
fn edge_error_without_edges() {
    let lit = picture(&["..."; 3]);
    assert_eq!(compare(&[1.0; 9], &lit).unwrap().edge_error, 0.0);
    assert_eq!(compare(&[0.0; 9], &lit).unwrap().edge_error, f64::INFINITY);
    let m = compare(&picture(&["##.."; 2]).visibility_image(), &picture(&["#..."; 2])).unwrap();
    assert_eq!((m.edge_error, m.mismatch), (50.0, 25.0));
}

#[test]
fn images_of_several_lights_are_one_of_many_pixels() {
    let of = |result: &[&str], truth: &[&str]| compare(&picture(result).visibility_image(), &picture(truth)).unwrap();
    let images = [of(&["##.."], &["#..."]), of(&["...."; 2], &["...."; 2]), of(&["...#"], &["...."])];
    let m: Metrics = images.into_iter().sum();
    assert_eq!((m.decided_pixels, m.edge_pixels, m.differing, m.acne_pixels), (16, 2, 2, 1));
    assert_eq!((m.mismatch, m.edge_error, m.off_edge, m.acne, m.lost), (12.5, 100.0, 6.25, 6.25, 0.0));
    assert_eq!(std::iter::empty().sum::<Metrics>(), Metrics::default());
}

#[test]
fn threshold_is_one_half() {
    let lit = picture(&["..."]);
    assert_eq!(compare(&[0.5, 1.0, 0.7], &lit).unwrap().differing, 0);
    assert_eq!(compare(&[0.499, 1.0, 0.7], &lit).unwrap().differing, 1);
}

#[test]
fn metrics_reject_garbage() {
    let lit = picture(&["..."]);
    for (result, word) in [(vec![1.0; 2], "2 pixels"), (vec![1.0; 4], "4 pixels"), (vec![1.0, f32::NAN, 1.0], "NaN")] {
        let error = compare(&result, &lit).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    assert!(compare(&[], &Reference::default()).is_err());
    assert!(compare(&[1.0; 3], &Reference { decided: Vec::new(), ..lit }).is_err());
}

#[test]
fn rmse_by_hand() {
    assert_eq!(rmse(&[1.0, 0.0, 9.0], &[0.0, 0.0, 0.0], &[true, true, false]).unwrap(), 0.5f64.sqrt());
    assert_eq!(rmse(&[1.0], &[0.0], &[false]).unwrap(), 0.0);
    assert!(rmse(&[1.0], &[0.0, 1.0], &[true]).is_err());
    assert!(rmse(&[], &[], &[]).is_err());
    assert!(rmse(&[f32::INFINITY], &[0.0], &[true]).is_err());
}

#[test]
fn soft_shadows_of_a_half_plane() {
    let mut scene = empty_scene();
    add_quad(&mut scene, 1.0, [0.0, -50.0], [100.0, 50.0]);
    let tracer = Tracer::new(&scene);
    let at = |x: f32| Some((Vec3::new(x, 0.0, 0.0), Vec3::Y));
    let pixels = gbuffer(&[at(-5.0), at(0.0), at(5.0), None, Some((Vec3::new(-5.0, 0.0, 0.0), Vec3::NEG_Y))]);
    let square = |flip: bool| {
        let mut corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| DVec3::new(x, 2.0, z));
        if flip {
            corners.reverse();
        }
        Light::Area { polygon: corners.to_vec() }
    };
    let sun = Light::Directional { direction: DVec3::NEG_Y, angular_diameter_deg: 40.0 };
    for (name, light) in [("sun", sun), ("area", square(false))] {
        let got = reference_soft(&tracer, &scene, &pixels, &light, &|_| {}).unwrap();
        assert_eq!(got[0], 1.0, "{name} open");
        assert!((got[1] - 0.5).abs() < 0.02, "{name} half: {}", got[1]);
        assert_eq!(got[2], 0.0, "{name} covered");
        assert_eq!(got[3..], [1.0, 0.0], "{name} sky and back");
        assert_eq!(got, reference_soft(&tracer, &scene, &pixels, &light, &|_| {}).unwrap(), "{name} twice");
    }
    // the light at the quarter of a disc of radius tan(20 deg): a known circle segment
    let quarter = gbuffer(&[at(-0.5 * 20f32.to_radians().tan())]);
    let sun = Light::Directional { direction: DVec3::NEG_Y, angular_diameter_deg: 40.0 };
    let got = f64::from(reference_soft(&tracer, &scene, &quarter, &sun, &|_| {}).unwrap()[0]);
    let segment = (0.5f64.acos() - 0.5 * 0.75f64.sqrt()) / std::f64::consts::PI;
    assert!((got - (1.0 - segment)).abs() < 0.01, "{got}, not {}", 1.0 - segment);
    let behind = reference_soft(&tracer, &scene, &pixels, &square(true), &|_| {}).unwrap();
    assert_eq!(behind, [0.0, 0.0, 0.0, 1.0, 0.0], "behind the light");
    let line = Light::Area { polygon: vec![DVec3::X, DVec3::Y, DVec3::X] };
    assert!(reference_soft(&tracer, &scene, &pixels, &line, &|_| {}).is_err(), "no area");
}
