//! The example host, which uses only what is public: its mask is that of the lab's engine.

use crate::bench::Bench;
use ash::vk;
use example::{Content, Geometry, Pass};
use std::sync::atomic::Ordering;
use umbrage::lab::View;
use umbrage::lab::stages::EngineStage;
use umbrage::scene::{Scene, builtin};
use umbrage::truth::compare;
use umbrage::{
    CastPolicy, Config, Engine, FrameInput, ImageUse, Light, Meshes, PositionLayout, Receivers, SceneBuffers,
};

#[path = "../../examples/host.rs"]
pub mod example;

#[test]
fn a_renderer_of_its_own_gets_the_same_mask() {
    let scene = example::opaque(builtin());
    let (camera, sun) = example::look(&scene);
    let lab = Bench::new(scene.clone(), View { camera, lights: vec![sun.clone()], size: example::SIZE, time_s: 0.0 });
    let reference = lab.reference(0, &|_| {}).unwrap();
    let vulkan = example::Vulkan::new(true).unwrap();
    let plain = Config::new(example::SIZE);
    let exact = Config { exact: true, ..plain.clone() };
    for (normals, config) in [(true, &plain), (false, &plain), (true, &exact)] {
        let mut stage = EngineStage::new(&lab, config).unwrap();
        let want = (0..3).map(|_| stage.frame(&lab).unwrap().0).last().unwrap();
        let pictures = example::render(&vulkan, &scene, &(camera, sun.clone()), normals, config, None).unwrap();
        let visibility = |pixels: &Vec<u32>| pixels.iter().map(|p| (p >> 24) as f32 / 255.0).collect::<Vec<_>>();
        let [got, looked_up] = [0, 1].map(|i| visibility(&pictures[i]));
        // pixels without a surface are lit in the mask and not drawn by the lookup; there pages are found by derivatives
        // of other triangles beside edges
        let drawn = pictures[1].iter().map(|p| p & 0xff_ffff != 0);
        let apart = got.iter().zip(&looked_up).zip(drawn).filter(|((a, b), drawn)| *drawn && a != b).count();
        println!("normals {normals}: {apart} pixels differ where looked up");
        // lookups trace no rays, and have the shader's own normals
        let other = config.exact || !normals;
        assert!(other == (apart > 50) && apart <= want.len() / 100, "normals {normals}: {apart} looked up otherwise");
        let differ = got.iter().zip(&want).filter(|(a, b)| a != b).count();
        let (host, lab) = (compare(&got, &reference).unwrap(), compare(&want, &reference).unwrap());
        println!("normals {normals}: {differ} pixels differ, off_edge {} and {}", host.off_edge, lab.off_edge);
        // depths of two pipelines differ in their last bits; normals from depth are wrong where leaves are small
        let most = if normals { want.len() / 2000 } else { want.len() / 50 };
        assert!(differ <= most && want.contains(&0.0), "normals {normals}: {differ}");
    }
    assert_eq!(example::MESSAGES.load(Ordering::Relaxed), 0, "validation messages, see above");
}

/// What the host draws itself casts as if the engine had drawn it: the same mask, whatever the caster looks like, in both layers,
/// through tessellation, and when it changes from frame to frame.
#[test]
fn casters_drawn_by_the_host_cast_the_same() {
    let scene = example::opaque(builtin());
    let (camera, sun) = example::look(&scene);
    let vulkan = example::Vulkan::new(true).unwrap();
    let config = Config { pages_per_frame: 4096, ..Config::new(example::SIZE) };
    let mask = |scene: &Scene, bent: Option<&example::Bent<'_>>, sun: &Light| -> Vec<f32> {
        let [mask, _] = example::render(&vulkan, scene, &(camera, sun.clone()), true, &config, bent).unwrap();
        mask.iter().map(|p| (p >> 24) as f32 / 255.0).collect()
    };
    let still = mask(&scene, None, &sun);
    const WIND: f32 = 0.06;
    let swayed = swayed(&scene, WIND);
    let lab = Bench::new(swayed.clone(), View { camera, lights: vec![sun.clone()], size: example::SIZE, time_s: 0.0 });
    let reference = lab.reference(0, &|_| {}).unwrap();
    let by_engine = mask(&swayed, None, &sun);
    let moving = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.instances.iter_mut().for_each(|i| i.flags = CastPolicy::Always as u32);
        mask(&scene, None, &sun)
    };
    let (still_moving, bent_moving) = (moving(&scene), moving(&swayed));
    let differ = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    assert!(differ(&still, &by_engine) > 1000, "the wind moves shadows");
    let (auto, always) = (CastPolicy::Auto, CastPolicy::Always);
    // tessellation rounds otherwise
    type Case<'a> = (&'a str, &'a [f32], CastPolicy, bool, &'a [f32], usize);
    let cases: [Case<'_>; 5] = [
        ("still", &[0.0; 3], auto, false, &still, 0),
        ("bent", &[WIND; 3], auto, false, &by_engine, 0),
        ("bending", &[0.0, -WIND, 0.5 * WIND, WIND], always, false, &bent_moving, 0),
        ("tessellated", &[0.0; 3], auto, true, &still, 60),
        ("tessellated and bending", &[0.0, WIND, 0.0], always, true, &still_moving, 60),
    ];
    for (case, winds, policy, tessellated, want, most) in cases {
        let got = mask(&scene, Some(&example::Bent { winds, policy, tessellated }), &sun);
        let apart = differ(&got, want);
        println!("{case}: {apart} pixels differ");
        assert!(apart <= most, "{case}: {apart} of {} pixels differ", got.len());
    }
    // and as rays see it
    let error = compare(&by_engine, &reference).unwrap();
    println!("mismatch {}, off_edge {}", error.mismatch, error.off_edge);
    assert!(error.mismatch < 0.1 && error.off_edge < 0.02, "{error:?}");
    // a light with faces, where pages are in perspective
    let lamp = Light::Point { position: camera.target + glam::DVec3::new(1.0, 4.0, 1.0), range: 60.0 };
    let winds = [0.0; 2];
    let bent = example::Bent { winds: &winds, policy: auto, tessellated: false };
    let (host, engine) = (mask(&scene, Some(&bent), &lamp), mask(&scene, None, &lamp));
    assert_eq!(differ(&host, &engine), 0, "towards a point light");
    assert!(engine.contains(&0.0) && engine.contains(&1.0));
    assert_eq!(example::MESSAGES.load(Ordering::Relaxed), 0, "validation messages, see above");
}

/// The scene with vertices where `glsl/examples/sway.glsl` puts them.
fn swayed(scene: &Scene, wind: f32) -> Scene {
    let mut scene = scene.clone();
    scene.positions.iter_mut().for_each(|p| p[0] += wind * p[1] * p[1]);
    for cluster in &mut scene.clusters {
        let corners = &scene.indices[cluster.first_index as usize..][..3 * cluster.triangle_count as usize];
        let of = |&i: &u32| glam::Vec3::from(scene.positions[i as usize]);
        let (low, high) = (
            corners.iter().map(of).reduce(glam::Vec3::min).unwrap(),
            corners.iter().map(of).reduce(glam::Vec3::max).unwrap(),
        );
        let center = 0.5 * (low + high);
        cluster.center = center.to_array();
        cluster.extent = (high - center).max(center - low).to_array().map(|e| e.next_up().next_up());
    }
    scene
}

#[test]
fn casters_of_the_host_must_be_drawn() {
    let scene = example::opaque(builtin());
    let (camera, sun) = example::look(&scene);
    let vulkan = example::Vulkan::new(true).unwrap();
    let winds = [0.0];
    let bent = example::Bent { winds: &winds, policy: CastPolicy::Auto, tessellated: false };
    let content = Content::new(&vulkan, &scene, Some(&bent)).unwrap();
    let images = content.images(true);
    let views = [Receivers { size: example::SIZE, images: &images, mask: ImageUse::SAMPLED }];
    let config = Config { index_capacity: 1 << 20, ..Config::new(example::SIZE) };
    // SAFETY: the handles live to the end
    let make = |config: &Config| unsafe { Engine::new(&vulkan.host, config, &content.buffers, &views) };
    let refused = make(&Config { exact: true, ..config.clone() }).map(drop).unwrap_err().to_string();
    assert_eq!(refused, "exact is true, allowed is false with casters that the host draws, which rays do not see");
    let mut engine = make(&config).unwrap();
    engine.add_light(&sun).unwrap();
    let input = FrameInput::new(&camera, example::SIZE, scene.origin);
    vulkan
        .record(|cmd| {
            // SAFETY: recording; the commands are thrown away
            let refused = unsafe { engine.record(cmd, &[input]) }.unwrap_err().to_string();
            assert_eq!(
                refused,
                "host_draws is recorded without a callback that draws them, allowed is record_with, or no host_draws"
            );
            let mut calls = 0;
            // SAFETY: as above
            unsafe { engine.record_with(cmd, &[input], &mut |_| calls += 1) }.unwrap();
            assert_eq!(calls, 1);
        })
        .unwrap();
    for (low, high) in
        [([0.0; 3], [f32::NAN, 1.0, 1.0]), ([2.0, 0.0, 0.0], [1.0; 3]), ([f32::NEG_INFINITY; 3], [0.0; 3])]
    {
        let refused = Meshes::default().add_bounds(low, high).unwrap_err().to_string();
        assert!(refused.starts_with("bounds is ") && refused.contains("finite, the lower corner first"), "{refused}");
    }
}

/// Every draw command says how often it is drawn and where its pages are listed; of what is drawn nowhere, not at all.
#[test]
fn draws_of_the_host_are_counted() {
    let scene = example::opaque(builtin());
    let (camera, sun) = example::look(&scene);
    let vulkan = example::Vulkan::new(true).unwrap();
    let bent = example::Bent { winds: &[0.0], policy: CastPolicy::Auto, tessellated: false };
    let content = Content::new(&vulkan, &scene, Some(&bent)).unwrap();
    let count = scene.instances.len();
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER;
    let (draws, at) = vulkan.host_visible(20 * count as u64, usage).unwrap();
    let buffers = SceneBuffers { host_draws: Some(draws), ..content.buffers };
    let images = content.images(true);
    let views = [Receivers { size: example::SIZE, images: &images, mask: ImageUse::SAMPLED }];
    let config = Config { index_capacity: 1 << 20, pages_per_frame: 4096, ..Config::new(example::SIZE) };
    // SAFETY: the handles live to the end
    let mut engine = unsafe { Engine::new(&vulkan.host, &config, &buffers, &views) }.unwrap();
    engine.add_light(&sun).unwrap();
    let input = FrameInput::new(&camera, example::SIZE, scene.origin);
    let before = vulkan.draw_pipeline(Pass::Camera).unwrap();
    let geometry = Geometry { buffers: &buffers, scene: &scene, input: &input, wind: 0.0 };
    // pages are drawn in the first frame, and kept in the second
    for (frame, drawn) in [(0, true), (1, false)] {
        let mut recorded = None;
        vulkan
            .submit(|cmd| {
                vulkan.draw(cmd, &before, [content.color, content.normal, content.depth], &geometry);
                // SAFETY: recording; submitted, in order
                recorded = Some(unsafe { engine.record_with(cmd, &[input], &mut |_| ()) });
            })
            .unwrap();
        let counters = engine.counters(recorded.unwrap().unwrap()).unwrap();
        // SAFETY: mapped; the frame was waited for
        let commands = unsafe { std::slice::from_raw_parts(at.cast::<[u32; 5]>(), count) };
        let mut lists: Vec<[u32; 2]> = commands.iter().filter(|c| c[1] > 0).map(|c| [c[4], c[4] + c[1]]).collect();
        lists.sort_unstable();
        assert_eq!(!lists.is_empty(), drawn, "frame {frame}");
        assert!(lists.windows(2).all(|two| two[0][1] == two[1][0]), "frame {frame}: lists beside each other");
        assert_eq!(lists.last().map_or(0, |list| list[1]), counters.pairs_host, "frame {frame}");
    }
}

/// Words of the mask of a second frame, with casters as `buffers` say and receivers as `content` does.
fn mask_words(
    vulkan: &example::Vulkan,
    scene: &Scene,
    content: &Content,
    buffers: &SceneBuffers,
    config: &Config,
) -> Vec<u32> {
    let (camera, sun) = example::look(scene);
    let images = content.images(true);
    let views = [Receivers { size: example::SIZE, images: &images, mask: ImageUse::COPIED }];
    // SAFETY: the handles live to the end
    let mut engine = unsafe { Engine::new(&vulkan.host, config, buffers, &views) }.unwrap();
    engine.add_light(&sun).unwrap();
    let input = FrameInput::new(&camera, example::SIZE, scene.origin);
    let before = vulkan.draw_pipeline(Pass::Camera).unwrap();
    let geometry = Geometry { buffers: &content.buffers, scene, input: &input, wind: 0.0 };
    let [width, height] = example::SIZE;
    let (to, at) = vulkan.host_visible(4 * u64::from(width * height), vk::BufferUsageFlags::TRANSFER_DST).unwrap();
    let aspect_mask = vk::ImageAspectFlags::COLOR;
    let layers = vk::ImageSubresourceLayers { aspect_mask, layer_count: 1, ..Default::default() };
    let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
        width,
        height,
        depth: 1,
    })];
    for _ in 0..2 {
        vulkan
            .submit(|cmd| {
                vulkan.draw(cmd, &before, [content.color, content.normal, content.depth], &geometry);
                // SAFETY: recording; submitted, in order; the mask is left for copies
                unsafe {
                    engine.record(cmd, &[input]).unwrap();
                    let (mask, layout) = (engine.mask(0).0, ImageUse::COPIED.layout);
                    vulkan.host.device.cmd_copy_image_to_buffer(cmd, mask, layout, to, &region);
                }
                vulkan.to_host(cmd, vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
            })
            .unwrap();
    }
    // SAFETY: mapped; the frame was waited for
    unsafe { std::slice::from_raw_parts(at.cast::<u32>(), (width * height) as usize) }.to_vec()
}

/// Positions of 16 bits cast as the same positions of 32 bits do.
#[test]
fn positions_of_every_format() {
    let mut scene = example::opaque(builtin());
    let vulkan = example::Vulkan::new(true).unwrap();
    // all coordinates between -1 and 1, as far as both formats of 16 bits have them
    let reach = scene.positions.as_flattened().iter().fold(0f32, |most, v| most.max(v.abs()));
    let steps: Vec<[i16; 4]> = scene
        .positions
        .iter()
        .map(|p| [0, 1, 2, 3].map(|i| if i < 3 { (p[i] / reach * 1023.0).round() as i16 } else { 77 }))
        .collect();
    for row in scene.instances.iter_mut().flat_map(|i| &mut i.rows) {
        row[..3].iter_mut().for_each(|v| *v *= reach);
    }
    // sign, exponent and mantissa of numbers that need no rounding
    let half = |v: f32| match v.to_bits() {
        0 => 0u16,
        bits => (bits >> 16 & 0x8000) as u16 | ((bits >> 13 & 0x3ffff) as u16).wrapping_sub((127 - 15) << 10) & 0x7fff,
    };
    use umbrage::PositionFormat as F;
    for (format, unit, encode) in [
        (F::Float16, 1.0 / 1024.0, Box::new(|step: i16| half(f32::from(step) / 1024.0)) as Box<dyn Fn(i16) -> u16>),
        (F::Snorm16, 32.0 / 32767.0, Box::new(|step: i16| (32 * step) as u16)),
    ] {
        for (position, step) in scene.positions.iter_mut().zip(&steps) {
            *position = [0, 1, 2].map(|i| f32::from(step[i]) * unit);
        }
        let content = Content::new(&vulkan, &scene, None).unwrap();
        // four bytes of the host's own, then the position
        let vertices: Vec<[u16; 6]> =
            steps.iter().map(|s| [9, 9, encode(s[0]), encode(s[1]), encode(s[2]), s[3] as u16]).collect();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
        let positions = vulkan.buffer(bytemuck::cast_slice(&vertices), usage).unwrap();
        let position_layout = PositionLayout { format, stride: 12, offset: 4 };
        let short = SceneBuffers { positions, position_layout, ..content.buffers };
        for exact in [false, true] {
            let config = Config { index_capacity: 1 << 20, exact, ..Config::new(example::SIZE) };
            let mask = |buffers: &SceneBuffers| mask_words(&vulkan, &scene, &content, buffers, &config);
            let (want, got) = (mask(&content.buffers), mask(&short));
            let apart = want.iter().zip(&got).filter(|(a, b)| a != b).count();
            println!("{format:?}, exact {exact}: {apart} pixels differ");
            assert!(apart <= want.len() / 10_000, "{format:?}, exact {exact}: {apart} pixels differ");
            assert!(want.iter().filter(|&&word| word == 0).count() > 10_000);
        }
    }
    assert_eq!(example::MESSAGES.load(Ordering::Relaxed), 0, "validation messages, see above");
}
