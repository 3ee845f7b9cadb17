//! Animated glTF files made in a test; each animation lasts 2 s.

use crate::builder::{Doc, U8};
use serde_json::{Value, json};

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Adds a linear channel to the file's only animation.
pub fn animate(doc: &mut Doc, node: usize, path: &str, times: &[f32], kind: &str, values: &[f32]) {
    let (input, output) = (doc.floats("SCALAR", times), doc.floats(kind, values));
    if doc.json["animations"].as_array().unwrap().is_empty() {
        doc.push("animations", json!({"channels": [], "samplers": []}));
    }
    let add = |list: &mut Value, value: Value| list.as_array_mut().unwrap().push(value);
    let animation = &mut doc.json["animations"][0];
    let sampler = animation["samplers"].as_array().unwrap().len();
    add(&mut animation["samplers"], json!({"input": input, "output": output}));
    add(&mut animation["channels"], json!({"sampler": sampler, "target": {"node": node, "path": path}}));
}

/// A wavy sheet of `n` x `n` cells, 1 wide, with a corner at `at`; returns its node.
pub fn grid(doc: &mut Doc, n: u32, at: [f32; 3]) -> usize {
    let side = n + 1;
    let point = |i: u32| {
        let (x, y) = ((i % side) as f32 / n as f32, (i / side) as f32 / n as f32);
        [at[0] + x, at[1] + y, at[2] + 0.1 * (7.0 * x).sin() * (5.0 * y).cos()]
    };
    let positions: Vec<f32> = (0..side * side).flat_map(point).collect();
    let positions = doc.floats("VEC3", &positions);
    let cell = |i: u32| {
        let a = i / n * side + i % n;
        [a, a + 1, a + side, a + 1, a + side + 1, a + side]
    };
    let indices = doc.indices(&(0..n * n).flat_map(cell).collect::<Vec<_>>());
    let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    doc.push("nodes", json!({"mesh": mesh}))
}

fn turn(doc: &mut Doc, node: usize) {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let keys = [0.0, 0.0, 0.0, 1.0, half, 0.0, 0.0, half, 0.0, 0.6, 0.0, 0.8];
    animate(doc, node, "rotation", &[0.0, 0.9, 2.0], "VEC4", &keys);
}

fn add_rigid(doc: &mut Doc) {
    let node = grid(doc, 12, [0.0, -2.0, 0.0]);
    let mesh = doc.json["nodes"][node]["mesh"].clone();
    // the same mesh at three places that stay and one that moves with its parent
    for i in 1..4 {
        doc.push("nodes", json!({"mesh": mesh, "translation": [1.5 * f64::from(i), 0, 1]}));
    }
    let child = doc.push("nodes", json!({"mesh": mesh, "translation": [0, 0.5, 0]}));
    let parent = doc.push("nodes", json!({"children": [child], "scale": [1, 2, 1]}));
    turn(doc, parent);
    animate(doc, parent, "translation", &[0.5, 1.0, 1.5], "VEC3", &[0.0, 0.0, 0.0, 2.0, 1.0, 0.0, -1.0, 0.0, 3.0]);
    // vertices far from their zero, so that loading moves them
    let far = grid(doc, 3, [40.0, 0.0, 0.0]);
    doc.json["nodes"][far]["translation"] = json!([-40, 1, 0]);
    animate(doc, far, "scale", &[0.0, 2.0], "VEC3", &[1.0, 1.0, 1.0, 1.0, 0.3, 1.0]);
}

fn add_skinned(doc: &mut Doc) {
    let node = grid(doc, 20, [2.0, 1.0, 0.0]);
    let mesh = doc.json["nodes"][node]["mesh"].as_u64().unwrap() as usize;
    let count = 21 * 21;
    let joints = doc.accessor("VEC4", U8, count, &[0, 1, 0, 0].repeat(count));
    // the right half follows the second joint more and more
    let weight = |i: usize| ((i % 21) as f32 / 10.0 - 1.0).clamp(0.0, 1.0);
    let weights: Vec<f32> = (0..count).flat_map(|i| [1.0 - weight(i), weight(i), 0.0, 0.0]).collect();
    let weights = doc.floats("VEC4", &weights);
    let binds = doc.floats("MAT4", &[IDENTITY, IDENTITY].concat());
    let moving = doc.push("nodes", json!({}));
    let root = doc.push("nodes", json!({"children": [moving]}));
    let skin = doc.push("skins", json!({"joints": [root, moving], "inverseBindMatrices": binds}));
    doc.json["nodes"][node]["skin"] = json!(skin);
    let attributes = &mut doc.json["meshes"][mesh]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    turn(doc, moving);
    animate(doc, moving, "scale", &[0.0, 2.0], "VEC3", &[1.0, 1.0, 1.0, 1.5, 1.0, 0.5]);
}

fn add_morphing(doc: &mut Doc) {
    let node = grid(doc, 10, [-2.0, 1.0, 0.0]);
    let mesh = doc.json["nodes"][node]["mesh"].as_u64().unwrap() as usize;
    let deltas: Vec<f32> = (0..121).flat_map(|i| [0.0, 0.02 * (i % 11) as f32, 1.0 - 0.01 * i as f32]).collect();
    let deltas = [doc.floats("VEC3", &deltas), doc.floats("VEC3", &[[0.5, 0.0, 0.0]; 121].concat())];
    doc.json["meshes"][mesh]["primitives"][0]["targets"] = json!([{"POSITION": deltas[0]}, {"POSITION": deltas[1]}]);
    doc.json["nodes"][node]["translation"] = json!([0, 0, 0.25]);
    // no weight at the start: the part is still one that deforms
    animate(doc, node, "weights", &[0.0, 1.0, 2.0], "SCALAR", &[0.0, 0.0, 1.0, 0.2, 0.1, 1.0]);
    // the same mesh with weights that stay
    doc.push("nodes", json!({"mesh": mesh, "translation": [-2, 0, 0], "weights": [0.5, 0.0]}));
}

fn with(parts: &[fn(&mut Doc)]) -> Doc {
    let mut doc = Doc::new();
    parts.iter().for_each(|add| add(&mut doc));
    doc
}

pub fn rigid() -> Doc {
    with(&[add_rigid])
}

pub fn skinned() -> Doc {
    with(&[add_skinned])
}

pub fn morphing() -> Doc {
    with(&[add_morphing])
}

pub fn deforming() -> Doc {
    with(&[add_skinned, add_morphing])
}

pub fn everything() -> Doc {
    with(&[add_rigid, add_skinned, add_morphing])
}
