//! Irregular z-buffers: images against ray tracing.

use crate::bench::Bench;
use crate::comparators::mixed;
use crate::scenes;
use umbrage::methods::{Method, MethodSpec, create};
use umbrage::truth::compare;

const SIZE: [u32; 2] = [320, 180];

fn draw(lab: &Bench, spec: &str) -> (Box<dyn Method>, Vec<f32>) {
    let mut method = create(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    method.frame(lab).unwrap();
    let visibility = method.visibility(lab, 0).unwrap();
    (method, visibility)
}

#[test]
fn images_are_those_of_ray_tracing() {
    let all = [
        scenes::street(SIZE),
        scenes::sphere_on_plane(SIZE),
        scenes::thin_poles(SIZE),
        scenes::leaves(SIZE),
        scenes::huge_ground(SIZE),
        scenes::swarm(SIZE),
    ];
    for (scene, view) in all {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        mixed(&reference.visibility_image()).unwrap_or_else(|why| panic!("{name}: {why}"));
        for spec in ["izb", "izb:resolution=16", "rmsm:exact=true,pages=4096"] {
            let (_, visibility) = draw(&lab, spec);
            let m = compare(&visibility, &reference).unwrap();
            println!("{name}, {spec}: {m:?}");
        }
    }
}
