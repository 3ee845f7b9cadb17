//! The example host, which uses only what is public: its mask is that of the lab's engine.

use crate::bench::Bench;
use std::sync::atomic::Ordering;
use umbrage::Config;
use umbrage::lab::View;
use umbrage::lab::stages::EngineStage;
use umbrage::scene::builtin;
use umbrage::truth::compare;

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
        let pictures = example::render(&vulkan, &scene, &(camera, sun.clone()), normals, config, 3).unwrap();
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
