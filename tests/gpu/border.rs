//! What crosses the border between a host and the engine: sizes that change, frames in flight, several engines on a device,
//! and input that is refused.

use crate::bench::Bench;
use crate::scenes;
use ash::vk;
use umbrage::lab::LabError;
use umbrage::lab::stages::{EngineStage, ViewsStage, in_flight, seeing};
use umbrage::truth::compare;
use umbrage::{Camera, Config, Error, Light, ReceiverImages};

const SIZE: [u32; 2] = [192, 108];

fn lab() -> (Bench, Light) {
    let (scene, view) = scenes::street(SIZE);
    let light = view.lights[0].clone();
    (Bench::new(scene, view), light)
}

/// Words of the mask of a first frame.
fn fresh(lab: &Bench, config: &Config, light: &Light, size: [u32; 2], camera: Camera) -> Vec<u32> {
    let mut stage = ViewsStage::new(lab, config, &[size]).unwrap();
    stage.engine().add_light(light).unwrap();
    stage.frame(lab, &[camera]).unwrap().0.remove(0)
}

#[test]
fn a_resized_view_is_a_new_one() {
    let (lab, light) = lab();
    let camera = lab.view().camera;
    for config in [Config::new(SIZE), Config { exact: true, samples: 4, ..Config::new(SIZE) }] {
        let config = Config { pages_per_frame: 4096, ..config };
        let mut stage = ViewsStage::new(&lab, &config, &[SIZE]).unwrap();
        stage.engine().add_light(&light).unwrap();
        let first = stage.frame(&lab, &[camera]).unwrap().0.remove(0);
        for size in [[96, 54], [33, 100], SIZE] {
            stage.resize(&lab, &[size]).unwrap();
            let mask = stage.frame(&lab, &[camera]).unwrap().0.remove(0);
            assert_eq!(mask.len(), (size[0] * size[1]) as usize);
            assert!(mask == fresh(&lab, &config, &light, size, camera), "{size:?}");
        }
        for (sizes, field) in [
            (&[[0, 54]][..], "size of a view"),
            (&[[96, 0]], "size of a view"),
            (&[[SIZE[0] + 1, 10]], "size of a view"),
            (&[SIZE, SIZE], "views"),
            (&[], "views"),
        ] {
            match stage.resize(&lab, sizes) {
                Err(LabError::Engine(Error::Limit { field: found, .. })) => assert_eq!(found, field, "{sizes:?}"),
                other => panic!("{sizes:?}: {other:?}"),
            }
            assert!(stage.frame(&lab, &[camera]).unwrap().0[0] == first, "after {sizes:?} was refused");
        }
    }
}

#[test]
fn frames_in_flight_and_engines_beside_each_other() {
    let (lab, light) = lab();
    let base = lab.view().camera;
    let cameras: Vec<Camera> =
        (0..4).map(|i| Camera { eye: base.eye + glam::DVec3::X * (0.1 * f64::from(i)), ..base }).collect();
    let config = Config { pages_per_frame: 4096, ..Config::new(SIZE) };
    let make = |config: &Config| {
        let mut stage = EngineStage::bare(&lab, config).unwrap();
        stage.engine().add_light(&light).unwrap();
        stage
    };
    let (mut one, mut other) = (make(&config), make(&Config { exact: true, lights: 3, ..config.clone() }));
    let frames = in_flight(&lab, &mut [&mut one, &mut other], &cameras).unwrap();
    let want = fresh(&lab, &config, &light, SIZE, cameras[3]);
    assert!(one.mask(&lab).unwrap() == want, "the last of four frames at once");
    let kept = config.frames_in_flight as usize;
    for (stage, frames) in [(&mut one, &frames[0]), (&mut other, &frames[1])] {
        let counters: Vec<_> = frames.iter().map(|&frame| stage.engine().counters(frame)).collect();
        assert_eq!(counters.iter().filter(|c| c.is_some()).count(), kept, "{counters:?}");
        assert!(counters[0].is_none() && counters.iter().flatten().all(|c| c.leaves > 10), "{counters:?}");
        let drawn: Vec<u32> = counters.iter().flatten().map(|c| c.drawn).collect();
        assert!(
            drawn.iter().all(|&drawn| drawn < counters[3].unwrap().pages / 2),
            "later frames keep pages: {drawn:?}"
        );
    }
}

#[test]
fn images_that_the_engine_cannot_read_are_refused() {
    let (lab, _) = lab();
    let config = Config::new(SIZE);
    type Edit = fn(&mut ReceiverImages);
    let cases: [(&str, Edit, &str, &str); 6] = [
        ("format", |i| i.depth.format = vk::Format::R8G8B8A8_UNORM, "depth", "D32"),
        ("samples", |i| i.depth.samples = vk::SampleCountFlags::TYPE_4, "depth", "resolve"),
        ("layout", |i| i.depth.used.layout = vk::ImageLayout::UNDEFINED, "depth", "layout"),
        ("normals", |i| i.normal.as_mut().unwrap().format = vk::Format::R8G8B8A8_UNORM, "normal", "R32_UINT"),
        (
            "samples of normals",
            |i| i.normal.as_mut().unwrap().samples = vk::SampleCountFlags::TYPE_2,
            "normal",
            "1 sample",
        ),
        ("stencil", |i| i.depth.format = vk::Format::S8_UINT, "depth", "D32_S8"),
    ];
    for (case, edit, field, word) in cases {
        match seeing(&lab, &config, edit).map(drop) {
            Err(LabError::Engine(error @ Error::Limit { .. })) => {
                let text = error.to_string();
                assert!(text.starts_with(field) && text.contains(word), "{case}: {text}");
            }
            other => panic!("{case}: {other:?}"),
        }
    }
    assert!(seeing(&lab, &config, |i| i.normal = None).is_ok());
}

/// Depth of any format and direction gives the shadows that the lab's own gives, as far as its precision goes.
#[test]
fn depth_of_every_format_and_direction() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let camera = lab.view().camera;
    let own = camera.clip_from_view(f64::from(SIZE[0]) / f64::from(SIZE[1]));
    // the same image, other depth: `near` and `far` are where it is 0 and 1
    let between = |near: f64, far: f64| {
        let mut clip = own;
        (clip.z_axis.z, clip.w_axis.z) = (far / (near - far), near * far / (near - far));
        clip
    };
    let infinite = {
        let mut clip = own;
        (clip.z_axis.z, clip.w_axis.z) = (0.0, camera.near);
        clip
    };
    use vk::Format as F;
    let cases = [
        ("as the lab's", F::D32_SFLOAT, own, 0.0),
        ("with stencil", F::D32_SFLOAT_S8_UINT, own, 0.0),
        ("to infinity", F::D32_SFLOAT, infinite, 0.02),
        ("nearer is less", F::D32_SFLOAT, between(0.5, 100.0), 0.02),
        ("24 bits, nearer is less", F::X8_D24_UNORM_PACK32, between(0.5, 100.0), 0.02),
        ("24 bits, reversed, with stencil", F::D24_UNORM_S8_UINT, between(100.0, 0.5), 0.02),
        ("16 bits, nearer is less", F::D16_UNORM, between(2.0, 20.0), 0.2),
        ("16 bits, reversed", F::D16_UNORM, between(20.0, 2.0), 0.2),
    ];
    let seen = |format, clip, exact| {
        let config = Config { exact, ..Config::new(SIZE) };
        umbrage::lab::foreign::visibility(&lab, &config, format, clip).unwrap()
    };
    let first = seen(F::D32_SFLOAT, own, true);
    for (case, format, clip, most) in cases {
        let got = seen(format, clip, true);
        let error = compare(&got, &reference).unwrap();
        let apart = got.iter().zip(&first).filter(|(a, b)| a != b).count();
        println!("{case}: {apart} pixels differ, mismatch {} %, off_edge {} %", error.mismatch, error.off_edge);
        assert!(100.0 * apart as f64 <= most * got.len() as f64, "{case}: {apart} pixels differ");
    }
    assert!(first.contains(&0.0) && first.contains(&1.0));
    // a near plane so close that depths say little: surfaces must not shadow themselves
    for (format, near) in [(F::D16_UNORM, 0.2), (F::D24_UNORM_S8_UINT, 0.005), (F::D32_SFLOAT, 0.005)] {
        for (exact, clip) in
            [(false, between(near, 100.0)), (true, between(near, 100.0)), (false, between(100.0, near))]
        {
            let error = compare(&seen(format, clip, exact), &reference).unwrap();
            println!(
                "{format:?}, near {near}, exact {exact}: mismatch {} %, off_edge {} %",
                error.mismatch, error.off_edge
            );
            assert!(error.off_edge < 0.05, "{format:?}, near {near}, exact {exact}: {error:?}");
        }
    }
}
