//! Rays through the GPU's tree, and by ray queries where the device has them, against the tracer on the CPU: every kind of
//! ray, scene and placement, and trees that are brought up to date or wrongly left as they were.

use crate::bench::{Bench, Lcg};
use crate::scenes;
use glam::{DMat3, DVec3};
use std::path::{Path, PathBuf};
use std::time::Instant;
use umbrage::CastPolicy;
use umbrage::lab::stages_exact::{CHANGED_PLACE, CHANGED_SHAPE, ExactStage, Ray};
use umbrage::lab::{Lab, LabError, LabOptions, View};
use umbrage::scene::{self, Changes, Instance, LoadOptions, Mesh, Motion, Scene, builtin, mesh_bounds};
use umbrage::view::ViewFile;
use umbrage::{Config, Cull, Light};

const SIZE: [u32; 2] = [64, 48];

fn ray(origin: DVec3, direction: DVec3, t_max: f64) -> Ray {
    let (o, d) = (origin.as_vec3(), direction.as_vec3());
    [o.x, o.y, o.z, t_max as f32, d.x, d.y, d.z, 0.0]
}

/// Origin, direction and `t_max`.
fn split(ray: &Ray) -> (DVec3, DVec3, f64) {
    let word = |i: usize| f64::from(ray[i]);
    (DVec3::new(word(0), word(1), word(2)), DVec3::new(word(4), word(5), word(6)), word(3))
}

/// Rays of every kind: between points in the scene's bounds, from far outside, along the axes, short ones, to a sun.
fn random_rays(scene: &Scene, seed: u64, count: u32) -> Vec<Ray> {
    let mut lcg = Lcg(seed);
    let (low, high) = (scene.bounds_min - scene.origin, scene.bounds_max - scene.origin);
    let mut point = |scale: f64| {
        let unit = DVec3::new(lcg.unit(), lcg.unit(), lcg.unit());
        0.5 * (low + high) + (unit - 0.5) * (high - low) * scale
    };
    let make = |i: u32| {
        let (from, to, far) = (point(1.0), point(1.0), point(20.0));
        let sign = if (i / 18).is_multiple_of(2) { 1.0 } else { -1.0 };
        match i % 6 {
            0 => ray(from, to - from, 1.0),
            1 => ray(far, to - far, f64::INFINITY),
            2 => ray(from, sign * DVec3::AXES[i as usize / 6 % 3], f64::INFINITY),
            3 => ray(from, (to - from) * 1e-3, 400.0),
            _ => ray(from, DVec3::new(0.4, 1.0, 0.3), f64::INFINITY),
        }
    };
    (0..count).map(make).collect()
}

fn traced(lab: &Lab, ray: &Ray) -> bool {
    let (origin, direction, t_max) = split(ray);
    lab.tracer().occluded(origin, direction, t_max)
}

/// Whether the tracer's answer depends on a few roundings of the scene's size: sideways, along the ray, at its end.
fn grazing(lab: &Lab, ray: &Ray) -> bool {
    let (origin, direction, t_max) = split(ray);
    let off = 2e-6 * lab.scene().diagonal().max(origin.length());
    let met = |o: DVec3, t: f64| lab.tracer().occluded(o, direction, t);
    let want = met(origin, t_max);
    let side = direction.any_orthogonal_vector().normalize();
    let up = direction.cross(side).normalize();
    let around = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 8.0;
        origin + off * (angle.cos() * side + angle.sin() * up)
    };
    let along = off / direction.length();
    (0..8).any(|i| met(around(i), t_max) != want)
        || [-along, along]
            .into_iter()
            .any(|t| met(origin + direction * t, t_max) != want || met(origin, t_max + t) != want)
}

/// Rays whose answers differ, and how many of these graze nothing.
struct Verdict {
    differ: usize,
    wrong: Vec<usize>,
}

fn compare(lab: &Lab, rays: &[Ray], got: &[bool]) -> Verdict {
    let want: Vec<bool> = rays.iter().map(|r| traced(lab, r)).collect();
    let met = want.iter().filter(|&&w| w).count();
    let rare = rays.len() / 200;
    assert!(met > rare && met < rays.len() - rare, "nothing to compare: {met} of {} rays are met", rays.len());
    let differ: Vec<usize> = (0..rays.len()).filter(|&i| want[i] != got[i]).collect();
    let wrong = differ.iter().copied().filter(|&i| !grazing(lab, &rays[i])).collect();
    Verdict { differ: differ.len(), wrong }
}

fn trace(lab: &Lab, stage: &ExactStage, rays: &[Ray]) -> Vec<bool> {
    stage.load(lab, rays).unwrap();
    stage.trace(lab).unwrap();
    stage.occluded(lab, rays.len()).unwrap()
}

/// No ray that grazes nothing differs, and of the others few.
#[track_caller]
fn agrees(lab: &Lab, stage: &ExactStage, rays: &[Ray]) {
    let verdict = compare(lab, rays, &trace(lab, stage, rays));
    let name = &lab.scene().name;
    assert!(verdict.wrong.is_empty(), "{name}: {:?}", verdict.wrong.iter().map(|&i| rays[i]).next());
    assert!(verdict.differ <= 2 + rays.len() / 10_000, "{name}: {} of {} rays differ", verdict.differ, rays.len());
}

/// The tree, then ray queries if the device has them; `config` for both.
fn routes(lab: &Lab, config: &Config, capacity: usize) -> Vec<ExactStage> {
    let make = |ray_query| {
        let stage = ExactStage::new(lab, &Config { ray_query, ..config.clone() }, capacity as u32).unwrap();
        stage.build_all(lab).unwrap();
        stage
    };
    let (tree, other) = (make(false), make(true));
    assert!(tree.has_tree());
    let queries = lab.has_ray_queries();
    assert_eq!(other.has_tree(), !queries, "ray queries where the device has them");
    if queries { vec![tree, other] } else { vec![tree] }
}

fn built(lab: &Lab, capacity: usize) -> Vec<ExactStage> {
    routes(lab, &Config::new(SIZE), capacity)
}

/// All routes agree with the tracer.
#[track_caller]
fn all_agree(lab: &Lab, rays: &[Ray]) {
    built(lab, rays.len()).iter().for_each(|stage| agrees(lab, stage, rays));
}

/// What is to be told when instances changed.
fn told(lab: &Lab, instances: impl IntoIterator<Item = u32>, change: u32) -> Vec<u32> {
    let mut changes = vec![0; lab.scene().instances.len()];
    instances.into_iter().for_each(|i| changes[i as usize] = change);
    changes
}

#[test]
fn rays_meet_what_the_tracer_meets() {
    let made = [
        scenes::street(SIZE),
        scenes::sphere_on_plane(SIZE),
        scenes::thin_poles(SIZE),
        scenes::leaves(SIZE),
        scenes::random(SIZE, 3),
    ];
    for (seed, (scene, view)) in (1..).zip(made) {
        let lab = Bench::new(scene, view);
        let rays = random_rays(lab.scene(), seed, 20_000);
        all_agree(&lab, &rays);
    }
}

/// A scene whose only mesh is a box of twelve triangles, or of fewer, placed many times: turned, sheared, mirrored, flat.
fn crowd(count: u32, triangles: u32, seed: u64) -> (Scene, View) {
    let (mut scene, view) = scenes::thin_poles(SIZE);
    let mut lcg = Lcg(seed);
    let own = scene.meshes[1];
    let index_count = 3 * triangles;
    scene.clusters[own.first_cluster as usize].triangle_count = triangles;
    let (center, _) = mesh_bounds(&scene, &own);
    let reach = 10.0 + f64::from(count).cbrt();
    scene.meshes = vec![Mesh { index_count, first_instance: 0, instance_count: count, ..own }];
    let mut place = |i: u32| {
        let axis = DVec3::new(lcg.between(-1.0, 1.0), lcg.between(-1.0, 1.0), 0.3).normalize();
        let turn = DMat3::from_axis_angle(axis, lcg.between(0.0, 6.0));
        let mut scale = DVec3::new(lcg.between(5.0, 40.0), lcg.between(0.2, 2.0), lcg.between(5.0, 40.0));
        match i % 5 {
            1 => scale.x = -scale.x,
            2 => scale.z = 0.0,
            3 => scale *= DVec3::new(20.0, 0.01, 1.0),
            _ => {}
        }
        let mut linear = turn * DMat3::from_diagonal(scale);
        linear.y_axis += if i % 5 == 4 { linear.x_axis * 0.01 } else { DVec3::ZERO };
        let middle = DVec3::new(lcg.between(-reach, reach), lcg.between(-reach, reach), lcg.between(-reach, reach));
        let translation = middle - linear * glam::Vec3::from(center).as_dvec3();
        let rows =
            [0, 1, 2].map(|k| [linear.row(k).x, linear.row(k).y, linear.row(k).z, translation[k]].map(|v| v as f32));
        Instance { rows, mesh: 0, ..scene.instances[1] }
    };
    scene.instances = (0..count).map(&mut place).collect();
    (scene.bounds_min, scene.bounds_max) = (scene.origin - 2.0 * reach, scene.origin + 2.0 * reach);
    (scene, view)
}

/// Numbers of casters around each number of levels, the last with a trail of two words; triangles around those of a leaf.
#[test]
fn instances_of_every_kind_in_every_number() {
    for (count, triangles) in
        [(1, 12), (3, 1), (4, 2), (5, 3), (16, 8), (17, 9), (64, 12), (65, 11), (1000, 12), (16_385, 12)]
    {
        let (scene, view) = crowd(count, triangles, u64::from(count));
        let lab = Bench::new(scene, view);
        // towards the instances, so that enough of them are met
        let mut lcg = Lcg(7);
        let rays: Vec<Ray> = (0..8000)
            .map(|_| {
                let rows = lab.scene().instances[lcg.below(count) as usize].rows;
                let (center, extent) = mesh_bounds(lab.scene(), &lab.scene().meshes[0]);
                let mut inside = || lcg.between(-1.2, 1.2) as f32;
                let p = [0, 1, 2].map(|k| center[k] + extent[k] * inside());
                let to = rows.map(|r| f64::from(r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]));
                let from = DVec3::new(lcg.between(-15.0, 15.0), lcg.between(-15.0, 15.0), lcg.between(-15.0, 15.0));
                ray(from, DVec3::from(to) - from, lcg.between(0.5, 2.0))
            })
            .collect();
        all_agree(&lab, &rays);
    }
}

#[test]
fn what_moved_is_met_where_it_is() {
    let (mut scene, base) = scenes::random(SIZE, 4);
    let motion = Motion::synthetic(&mut scene, base.camera.eye, base.camera.target, 3, 5);
    let mut lab = Bench::new(scene, base);
    lab.set_motion(motion);
    let rays = random_rays(lab.scene(), 9, 20_000);
    let stages = built(&lab, rays.len());
    for time in [0.6, 1.7] {
        lab.animate(time).unwrap();
        for stage in &stages {
            let stale = compare(&lab, &rays, &trace(&lab, stage, &rays));
            assert!(!stale.wrong.is_empty(), "what nobody told is right all the same");
            stage.build(&lab, &told(&lab, [], 0)).unwrap();
            let stale = compare(&lab, &rays, &trace(&lab, stage, &rays));
            assert_eq!(stale.wrong.is_empty(), !stage.has_tree(), "a tree is built although nothing changed");
            let movers = lab.scene().instances.len() as u32 - 3..lab.scene().instances.len() as u32;
            stage.build(&lab, &told(&lab, movers, CHANGED_PLACE)).unwrap();
            agrees(&lab, stage, &rays);
        }
    }
}

/// Swells and shrinks every other vertex of a mesh about its middle.
fn deform(lab: &mut Lab, mesh: usize, share: f32) {
    let edit = |scene: &mut Scene| {
        let m = scene.meshes[mesh];
        let (center, extent) = mesh_bounds(scene, &m);
        let vertices = &scene.indices[m.first_index as usize..][..m.index_count as usize];
        let (low, high) = (*vertices.iter().min().unwrap(), *vertices.iter().max().unwrap());
        for v in (low..=high).step_by(2) {
            let p = &mut scene.positions[v as usize];
            *p = std::array::from_fn(|c| p[c] + (center[c] - p[c]) * share);
        }
        let clusters = m.first_cluster..m.first_cluster + m.cluster_count;
        for c in clusters.clone() {
            let cluster = &mut scene.clusters[c as usize];
            (cluster.center, cluster.extent) = (center, extent.map(|e| e * (1.0 + share.abs()) + 1e-6));
        }
        let instances: Vec<u32> = (m.first_instance..m.first_instance + m.instance_count).collect();
        instances.iter().for_each(|&i| scene.instances[i as usize].revision += 1);
        let vertices = low..high + 1;
        let changes = Changes { instances, meshes: vec![mesh as u32], ..Changes::default() };
        Ok::<_, LabError>(Changes { vertices: vec![vertices], clusters: vec![clusters], ..changes })
    };
    lab.edit(edit).unwrap();
}

#[test]
fn what_deformed_is_met_as_it_is() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view);
    let rays = random_rays(lab.scene(), 10, 20_000);
    let stages = built(&lab, rays.len());
    for share in [0.4, 0.3] {
        deform(&mut lab, 1, share);
        for stage in &stages {
            stage.build(&lab, &told(&lab, [1], CHANGED_PLACE)).unwrap();
            let stale = compare(&lab, &rays, &trace(&lab, stage, &rays));
            assert_eq!(
                stale.wrong.is_empty(),
                !stage.has_tree(),
                "clusters that nobody told of are built all the same"
            );
            stage.build(&lab, &told(&lab, [1], CHANGED_SHAPE)).unwrap();
            agrees(&lab, stage, &rays);
        }
    }
}

#[test]
fn who_casts_no_shadow_is_not_met() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view);
    let policy = |lab: &mut Lab, instances: &[u32], policy: CastPolicy| {
        let edit = |scene: &mut Scene| {
            instances.iter().for_each(|&i| scene.instances[i as usize].flags = policy as u32);
            Ok::<_, LabError>(Changes { instances: instances.to_vec(), ..Changes::default() })
        };
        lab.edit(edit).unwrap();
    };
    let rays = random_rays(lab.scene(), 11, 5000);
    policy(&mut lab, &[0, 1], CastPolicy::Never);
    for stage in built(&lab, rays.len()) {
        policy(&mut lab, &[0, 1], CastPolicy::Never);
        stage.build(&lab, &told(&lab, [0, 1], CHANGED_SHAPE)).unwrap();
        assert!(!trace(&lab, &stage, &rays).contains(&true), "nothing casts");
        // the plane alone: what is met lies below its height
        policy(&mut lab, &[0], CastPolicy::Auto);
        stage.build(&lab, &told(&lab, [0], CHANGED_SHAPE)).unwrap();
        let plane = trace(&lab, &stage, &rays);
        assert!(plane.contains(&true) && plane.contains(&false));
        policy(&mut lab, &[1], CastPolicy::Always);
        stage.build(&lab, &told(&lab, [1], CHANGED_SHAPE)).unwrap();
        agrees(&lab, &stage, &rays);
        let all = trace(&lab, &stage, &rays);
        assert!(plane.iter().zip(&all).all(|(p, a)| !p || *a) && plane != all);
    }
}

/// Whether a ray meets a triangle from the side that `cull` leaves in, tried one by one.
fn met_from_a_side(scene: &Scene, ray: &Ray, cull: Cull) -> bool {
    let (origin, d, t_max) = split(ray);
    scene.instances.iter().any(|instance| {
        let rows = instance.rows.map(|r| r.map(f64::from));
        let linear = DMat3::from_cols_array_2d(&[0, 1, 2].map(|c| [rows[0][c], rows[1][c], rows[2][c]]));
        let translation = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
        let m = scene.meshes[instance.mesh as usize];
        let corners = &scene.indices[m.first_index as usize..][..m.index_count as usize];
        corners.chunks_exact(3).any(|corner| {
            let at = |k: usize| linear * glam::Vec3::from(scene.positions[corner[k] as usize]).as_dvec3() + translation;
            let (a, b, c) = (at(0), at(1), at(2));
            let normal = (b - a).cross(c - a);
            let t = (a - origin).dot(normal) / d.dot(normal);
            let p = origin + t * d;
            let within = [(a, b), (b, c), (c, a)].iter().all(|(f, g)| (*g - *f).cross(p - *f).dot(normal) >= 0.0);
            let front = (d.dot(normal) > 0.0) == (linear.determinant() > 0.0);
            within && t > 0.0 && t < t_max && (cull == Cull::None || front == (cull == Cull::Back))
        })
    })
}

#[test]
fn sides_are_left_out_by_winding() {
    let (mut scene, view) = crowd(20, 12, 3);
    // a flat instance has no side
    let mut number = 0..;
    scene.instances.retain(|_| number.next().is_some_and(|i| i % 5 != 2));
    scene.meshes[0].instance_count = scene.instances.len() as u32;
    let lab = Bench::new(scene, view);
    let rays: Vec<Ray> = random_rays(lab.scene(), 12, 30_000).into_iter().filter(|r| traced(&lab, r)).collect();
    assert!(rays.len() > 200, "{} rays", rays.len());
    for cull in [Cull::None, Cull::Back, Cull::Front] {
        let want: Vec<bool> = rays.iter().map(|r| met_from_a_side(lab.scene(), r, cull)).collect();
        assert!(cull == Cull::None || want.contains(&true) && want.contains(&false));
        for stage in routes(&lab, &Config { cull, ..Config::new(SIZE) }, rays.len()) {
            let got = trace(&lab, &stage, &rays);
            let differ = want.iter().zip(&got).filter(|(w, g)| w != g).count();
            let tree = stage.has_tree();
            assert!(differ <= 1, "{cull:?}, tree {tree}: {differ} of {} rays differ", rays.len());
        }
    }
}

#[test]
fn lists_of_every_length_and_rays_that_are_none() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let rays = random_rays(lab.scene(), 13, 200);
    let stages = built(&lab, 130);
    let want: Vec<bool> = rays.iter().map(|r| traced(&lab, r)).collect();
    for (stage, count) in stages.iter().flat_map(|s| [0, 1, 63, 64, 65, 129, 130, 131, 200].map(|count| (s, count))) {
        let kept = trace(&lab, stage, &vec![ray(DVec3::ZERO, DVec3::ZERO, 1.0); 130]);
        assert!(!kept.contains(&true), "a ray without a direction is met");
        let got = trace(&lab, stage, &rays[..count]);
        assert_eq!(got, want[..count.min(130)], "{count} rays");
    }
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e38, 1e-38, 0.0];
    let words = || odd.iter().flat_map(|&a| odd.iter().map(move |&b| DVec3::new(a, b, 1.0)));
    let rays: Vec<Ray> = words().flat_map(|o| words().map(move |d| ray(o, d, f64::NAN))).take(130).collect();
    for stage in &stages {
        assert_eq!(trace(&lab, stage, &rays).len(), 130);
    }
}

/// Instances and vertices that are not finite end no walk late and hide no others.
#[test]
fn what_is_not_finite_is_not_met() {
    let (mut scene, view) = scenes::random(SIZE, 6);
    for row in &mut scene.instances[3].rows {
        row[1] = f32::NAN;
    }
    let last = scene.meshes[5];
    for i in &scene.indices[last.first_index as usize..][..12] {
        scene.positions[*i as usize][0] = f32::NAN;
    }
    let lab = Bench::new(scene, view);
    let rays = random_rays(lab.scene(), 14, 10_000);
    all_agree(&lab, &rays);
}

/// Scene files below `UMBRAGE_SCENES`, or that one.
fn files() -> Vec<PathBuf> {
    let given = std::env::var("UMBRAGE_SCENES").expect("UMBRAGE_SCENES names a scene file or a folder of them");
    let glb = |path: &PathBuf| path.extension().is_some_and(|e| e == "glb");
    let mut files = match std::fs::read_dir(&given) {
        Ok(entries) => entries.map(|e| e.unwrap().path()).filter(glb).collect(),
        Err(_) => vec![PathBuf::from(&given)],
    };
    files.sort();
    files
}

#[test]
#[ignore = "needs scene files"]
fn scene_files_are_met_as_the_tracer_meets_them() {
    for file in files() {
        let (scene, motion) = scene::load_moving(&file, &LoadOptions::default()).unwrap();
        let view = View::default_for(&scene, SIZE);
        let mut lab = Bench::new(scene, view);
        let rays = random_rays(lab.scene(), 15, 100_000);
        let stages = built(&lab, rays.len());
        let say = |what: &str, lab: &Lab| {
            for stage in &stages {
                let verdict = compare(lab, &rays, &trace(lab, stage, &rays));
                let route = if stage.has_tree() { "tree" } else { "queries" };
                println!(
                    "{} {what}, {route}: {} differ, {} wrong",
                    lab.scene().name,
                    verdict.differ,
                    verdict.wrong.len()
                );
                assert!(verdict.wrong.is_empty(), "{:?}", rays[verdict.wrong[0]]);
            }
        };
        say("as loaded", &lab);
        if let Some(motion) = motion {
            lab.set_motion(motion);
            lab.animate(0.4).unwrap();
            for stage in &stages {
                stage.build_all(&lab).unwrap();
            }
            say("moved", &lab);
        }
    }
}

/// Every pixel's ray to the sun, from the reference's distance above the surface, in tiles of 8x8 pixels.
fn shadow_rays(lab: &Lab) -> Vec<Ray> {
    let g = lab.gbuffer().unwrap();
    let Light::Directional { direction, .. } = &lab.view().lights[0] else { panic!("a sun") };
    let sun = -direction.normalize();
    let off = 1e-5 * lab.scene().diagonal();
    let tiles = (0..g.height.div_ceil(8)).flat_map(|y| (0..g.width.div_ceil(8)).map(move |x| (x, y)));
    let pixels = tiles.flat_map(|(x, y)| (0..64).map(move |i| (8 * x + i % 8, 8 * y + i / 8)));
    let at = pixels.filter(|&(x, y)| x < g.width && y < g.height).map(|(x, y)| (y * g.width + x) as usize);
    let vector = |v: [f32; 3]| glam::Vec3::from(v).as_dvec3();
    at.filter(|&i| g.hit[i] && vector(g.normal[i]).dot(sun) > 0.0)
        .map(|i| ray(g.point(i) + off * vector(g.normal[i]), sun, f64::INFINITY))
        .collect()
}

/// Times of the shadow rays of all pixels at 1280x720, for files as above; a view of each may lie in `UMBRAGE_VIEW`.
#[test]
#[ignore = "a measurement"]
fn times_of_scene_files() {
    let size = [1280, 720];
    for file in files() {
        let scene = scene::load(&file, &LoadOptions::default()).unwrap();
        let view = match std::env::var("UMBRAGE_VIEW") {
            Ok(view) => ViewFile::read(Path::new(&view)).unwrap().complete(&scene, Some(size)).unwrap(),
            Err(_) => View::default_for(&scene, size),
        };
        let lab = Lab::new(&LabOptions { device: None, validation: false }, scene, view).unwrap();
        let rays = shadow_rays(&lab);
        let stages = built(&lab, rays.len());
        stages.iter().for_each(|stage| stage.load(&lab, &rays).unwrap());
        lab.tracer();
        let on_cpu = || {
            let start = Instant::now();
            let tracer = lab.tracer();
            let met = |part: &[Ray]| part.iter().map(split).filter(|&(o, d, t)| tracer.occluded(o, d, t)).count();
            let (one, other) = rays.split_at(rays.len() / 2);
            std::thread::scope(|scope| {
                scope.spawn(|| std::hint::black_box(met(one)));
                std::hint::black_box(met(other));
            });
            start.elapsed().as_secs_f64() * 1e3
        };
        let mut times = vec![[(); 5].map(|()| Vec::new()); stages.len()];
        for i in (0..5).flat_map(|_| 0..stages.len()) {
            let (stage, times) = (&stages[i], &mut times[i]);
            let all = |change| stage.build(&lab, &vec![change; lab.scene().instances.len()]).unwrap();
            let round = [all(CHANGED_SHAPE), all(CHANGED_PLACE), all(0), stage.trace(&lab).unwrap(), on_cpu()];
            times.iter_mut().zip(round).for_each(|(list, ms)| list.push(ms));
        }
        for (stage, times) in stages.iter().zip(times) {
            let [build, moved, still, gpu, cpu] = times.map(|mut list| {
                list.sort_by(f64::total_cmp);
                list[list.len() / 2]
            });
            let ns = |ms: f64| 1e6 * ms / rays.len() as f64;
            println!(
                "{}, {}: build {build:.1} ms, all moved {moved:.1} ms, still {still:.2} ms, {} rays of {:.0} ns ({:.0} ns by \
                 the tracer on two cores, ratio {:.1}), {:.1} MiB for {} triangles",
                lab.scene().name,
                if stage.has_tree() { "tree" } else { "queries" },
                rays.len(),
                ns(gpu),
                ns(cpu),
                gpu / cpu,
                stage.bytes() as f64 / f64::from(1 << 20),
                lab.scene().unique_triangles(),
            );
        }
    }
}

/// The built-in scene has alpha-tested casters and a few instances; its shadow rays are those that a frame would ask for.
#[test]
fn shadow_rays_of_the_builtin_scene() {
    let (_, view) = scenes::street([320, 180]);
    let lab = Bench::new(builtin(), view);
    let rays = shadow_rays(&lab);
    all_agree(&lab, &rays);
}
