//! Scenes: files made here with known results, every error's sentence, damaged files, cluster invariants.
#![cfg(feature = "lab")]

#[path = "scene/builder.rs"]
mod builder;

use builder::{Doc, F32, Folder, I16, Random, U8, U16, U32, base64};
use glam::{DVec3, Vec3, Vec4};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use umbrage::scene::{self, Blend, CLUSTER_TRIANGLES, LoadOptions, NO_TEXTURE, Scene, SceneError};

fn load_with(doc: &Doc, options: &LoadOptions) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    let scene = scene::load(&folder.file("test.glb", &doc.glb()), options);
    scene.inspect(check)
}

fn load(doc: &Doc) -> Scene {
    load_with(doc, &LoadOptions::default()).unwrap()
}

fn load_at(doc: &Doc, time_s: f64) -> Scene {
    load_with(doc, &LoadOptions { time_s, ..LoadOptions::default() }).unwrap()
}

/// What every scene promises.
fn check(scene: &Scene) {
    assert_eq!(scene.positions.len(), scene.attributes.len());
    assert!(!scene.materials.is_empty() && !scene.meshes.is_empty());
    assert!(scene.diagonal() > 0.0);
    assert!((scene.origin - (scene.bounds_min + scene.bounds_max) * 0.5).length() <= 1e-12 * scene.origin.length());
    let (mut index, mut cluster, mut instance) = (0, 0, 0);
    for (number, mesh) in scene.meshes.iter().enumerate() {
        assert_eq!((mesh.first_index, mesh.first_cluster, mesh.first_instance), (index, cluster, instance));
        assert!(mesh.instance_count > 0 && mesh.cluster_count > 0 && mesh.index_count % 3 == 0);
        for c in &scene.clusters[cluster as usize..][..mesh.cluster_count as usize] {
            assert_eq!(c.first_index, index);
            assert!((1..=CLUSTER_TRIANGLES as u32).contains(&c.triangle_count));
            for &i in &scene.indices[index as usize..][..c.triangle_count as usize * 3] {
                for axis in 0..3 {
                    let v = scene.positions[i as usize][axis];
                    assert!(c.center[axis] - c.extent[axis] <= v && v <= c.center[axis] + c.extent[axis]);
                }
            }
            index += c.triangle_count * 3;
        }
        assert_eq!(index, mesh.first_index + mesh.index_count);
        for placed in &scene.instances[instance as usize..][..mesh.instance_count as usize] {
            assert_eq!((placed.mesh, placed.material, placed.revision), (number as u32, mesh.material, 0));
        }
        let material = &scene.materials[mesh.material as usize];
        assert!(material.alpha_cutoff > 0.0 || !mesh.alpha_tested);
        cluster += mesh.cluster_count;
        instance += mesh.instance_count;
    }
    assert_eq!(index as usize, scene.indices.len());
    assert_eq!(cluster as usize, scene.clusters.len());
    assert_eq!(instance as usize, scene.instances.len());
    for material in scene.materials.iter().filter(|m| m.texel_offset != NO_TEXTURE) {
        assert!(material.width > 0 && material.height > 0);
        assert!((material.texel_offset + material.width * material.height) as usize <= scene.texels.len());
    }
    let slack = DVec3::splat(scene.diagonal() * 1e-6);
    for triangle in world(scene) {
        for p in triangle {
            assert!(p.cmpge(scene.bounds_min - slack).all() && p.cmple(scene.bounds_max + slack).all(), "{p}");
        }
    }
}

/// All triangles of all instances in world space, as single precision places them.
fn world(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for instance in &scene.instances {
        let mesh = scene.meshes[instance.mesh as usize];
        let place = |i: u32| {
            let p = Vec3::from(scene.positions[i as usize]).extend(1.0);
            let rows = instance.rows.map(|r| Vec4::from(r).dot(p));
            scene.origin + Vec3::from(rows).as_dvec3()
        };
        let indices = &scene.indices[mesh.first_index as usize..][..mesh.index_count as usize];
        out.extend(indices.chunks(3).map(|t| [place(t[0]), place(t[1]), place(t[2])]));
    }
    out
}

#[track_caller]
fn near(found: DVec3, x: f64, y: f64, z: f64) {
    assert!((found - DVec3::new(x, y, z)).length() < 1e-5, "{found} instead of {x} {y} {z}");
}

/// Corners of the only triangle.
#[track_caller]
fn only(scene: &Scene) -> [DVec3; 3] {
    let world = world(scene);
    assert_eq!(world.len(), 1);
    world[0]
}

#[track_caller]
fn fails(doc: &Doc, sentence: &str) {
    let error = load_with(doc, &LoadOptions::default()).unwrap_err();
    assert!(error.what.contains(sentence), "`{}` instead of `{sentence}`", error.what);
    assert!(error.to_string().contains("test.glb"));
}

#[test]
fn plain_triangle() {
    let scene = load(&Doc::triangle());
    let [a, b, c] = only(&scene);
    near(a, 0.0, 0.0, 0.0);
    near(b, 1.0, 0.0, 0.0);
    near(c, 0.0, 1.0, 0.0);
    assert_eq!(scene.name, "test");
    assert_eq!((scene.bounds_min, scene.bounds_max), (DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)));
    assert_eq!(scene.materials.len(), 1);
    assert_eq!((scene.materials[0].base_color, scene.materials[0].texel_offset), ([1.0; 4], NO_TEXTURE));
    assert_eq!(scene.attributes[0].color, u32::MAX);
    assert!(scene.meshes[0].casts && !scene.meshes[0].alpha_tested);
    assert!(scene.warnings.is_empty());
}

#[test]
fn instances_share_one_mesh() {
    let mut doc = Doc::triangle();
    for i in 1..1000 {
        doc.push("nodes", json!({"mesh": 0, "translation": [i, 0, 0]}));
    }
    let scene = load(&doc);
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 1000));
    assert_eq!((scene.unique_triangles(), scene.drawn_triangles(), scene.positions.len()), (1, 1000, 3));
    near(world(&scene)[999][1], 1000.0, 0.0, 0.0);
}

#[test]
fn transforms_accumulate() {
    let mut doc = Doc::triangle();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    doc.json["nodes"][0]["translation"] = json!([1, 0, 0]);
    // a quarter turn about z, twice as large, then shifted
    doc.push("nodes", json!({"children": [0], "rotation": [0, 0, half, half], "scale": [2, 2, 2]}));
    doc.push("nodes", json!({"children": [1], "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}));
    let [a, b, c] = only(&load(&doc));
    near(a, 5.0, 8.0, 7.0);
    near(b, 5.0, 10.0, 7.0);
    near(c, 3.0, 8.0, 7.0);
}

#[test]
fn only_the_default_scene_is_shown() {
    let mut doc = Doc::triangle();
    doc.push("nodes", json!({"mesh": 0, "translation": [9, 0, 0]}));
    doc.json["scenes"] = json!([{"nodes": [0, 1]}, {"nodes": [1]}]);
    assert_eq!(load(&doc).instances.len(), 2);
    doc.json["scene"] = json!(1);
    near(only(&load(&doc))[0], 9.0, 0.0, 0.0);
}

#[test]
fn strips_fans_and_index_types() {
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0];
    let cases: [(u32, u32, &[[usize; 3]]); 3] = [
        (4, U16, &[[0, 1, 2]]),
        (5, U8, &[[0, 1, 2], [1, 3, 2], [2, 3, 4]]),
        (6, U32, &[[1, 2, 0], [2, 3, 0], [3, 4, 0]]),
    ];
    for (mode, component, want) in cases {
        let mut doc = Doc::new();
        let positions = doc.floats("VEC3", &corners);
        let list: &[u32] = if mode == 4 { &[0, 1, 2] } else { &[0, 1, 2, 3, 4] };
        let bytes: Vec<u8> = match component {
            U8 => list.iter().map(|i| *i as u8).collect(),
            U16 => list.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect(),
            _ => list.iter().flat_map(|i| i.to_le_bytes()).collect(),
        };
        let indices = doc.accessor("SCALAR", component, list.len(), &bytes);
        let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": mode}));
        doc.push("nodes", json!({"mesh": mesh}));
        let scene = load(&doc);
        let corner = |i: usize| DVec3::new(corners[3 * i].into(), corners[3 * i + 1].into(), corners[3 * i + 2].into());
        assert_eq!(world(&scene), want.iter().map(|w| w.map(corner)).collect::<Vec<_>>(), "mode {mode}");
    }
}

#[test]
fn lines_are_left_out_with_a_warning() {
    let mut doc = Doc::triangle();
    let line = json!({"attributes": {"POSITION": 0}, "mode": 1});
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(line);
    let scene = load(&doc);
    assert_eq!(scene.unique_triangles(), 1);
    assert_eq!(scene.warnings, ["mesh 0 `thing`, primitive 1: points and lines were left out"]);
}

#[test]
fn degenerate_triangles_and_unused_vertices_go() {
    let mut doc = Doc::new();
    let corners = [9.0, 9.0, 9.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0];
    let positions = doc.floats("VEC3", &corners);
    let indices = doc.indices(&[1, 2, 2, 1, 2, 4, 1, 2, 3]);
    let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    doc.push("nodes", json!({"mesh": mesh}));
    let scene = load(&doc);
    assert_eq!((scene.unique_triangles(), scene.positions.len()), (1, 3));
    assert_eq!(scene.bounds_max, DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(scene.warnings, ["2 triangles of zero area were dropped"]);
}

/// A sheet has no inside; a camera in it looked along its own up direction.
#[test]
fn a_sheet_is_seen_from_outside() {
    let scene = load(&Doc::triangle());
    let view = umbrage::lab::View::default_for(&scene, [64, 64]);
    view.check().unwrap();
    assert!(view.camera.eye.z.abs() > 0.3, "{:?}", view.camera);
}

#[test]
fn files_with_companions() {
    let folder = Folder::new();
    let doc = Doc::triangle();
    folder.file("my data.bin", &doc.bin);
    let paths = [
        folder.file("a.gltf", doc.text(Some("my%20data.bin".into())).as_bytes()),
        folder.file(
            "b.gltf",
            doc.text(Some(format!("data:application/gltf-buffer;base64,{}", base64(&doc.bin)))).as_bytes(),
        ),
    ];
    for path in paths {
        let scene = scene::load(&path, &LoadOptions::default()).unwrap();
        near(only(&scene)[1], 1.0, 0.0, 0.0);
    }
    let path = folder.file("c.gltf", doc.text(Some("gone.bin".into())).as_bytes());
    let error = scene::load(&path, &LoadOptions::default()).unwrap_err();
    assert!(error.what.starts_with("buffer 0 names the file `gone.bin`, which cannot be read"), "{error}");
    let error = scene::load(&folder.0.join("none.glb"), &LoadOptions::default()).unwrap_err();
    assert!(error.what.starts_with("the file cannot be read"), "{error}");
}

#[test]
fn sparse_and_quantised_positions() {
    let mut doc = Doc::triangle();
    let indices = doc.view(&[2, 0]);
    let values = doc.view(bytemuck::cast_slice(&[0.0f32, 5.0, 0.0]));
    doc.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": indices, "componentType": U16}, "values": {"bufferView": values}
    });
    near(only(&load(&doc))[2], 0.0, 5.0, 0.0);

    let mut doc = Doc::new();
    let corners: [i16; 12] = [0, 0, 0, 0, 32767, 0, 0, 0, 0, -32767, 0, 0];
    let positions = doc.accessor("VEC3", I16, 3, bytemuck::cast_slice(&corners));
    doc.json["bufferViews"][0]["byteStride"] = json!(8);
    doc.json["accessors"][0]["normalized"] = json!(true);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}}));
    doc.push("nodes", json!({"mesh": mesh}));
    let [_, b, c] = only(&load(&doc));
    near(b, 1.0, 0.0, 0.0);
    near(c, 0.0, -1.0, 0.0);
}

fn textured(material: Value, rgba: &[u8], side: u32) -> Doc {
    let mut doc = Doc::triangle();
    let texture = doc.texture(side, side, rgba);
    let mut material = material;
    let info = material["pbrMetallicRoughness"]["baseColorTexture"].as_object_mut().unwrap();
    info.insert("index".into(), texture.into());
    doc.push("materials", material);
    let uvs = [doc.floats("VEC2", &[0.0; 6]), doc.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0])];
    doc.primitive()["material"] = json!(0);
    doc.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs[0]);
    doc.primitive()["attributes"]["TEXCOORD_1"] = json!(uvs[1]);
    doc
}

#[test]
fn texture_transform_and_sampler() {
    let transform =
        json!({"offset": [0.0, 1.0], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.25], "texCoord": 1});
    let info = json!({"texCoord": 0, "extensions": {"KHR_texture_transform": transform}});
    let mut doc = textured(
        json!({"pbrMetallicRoughness": {"baseColorTexture": info}}),
        &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16],
        2,
    );
    doc.push("samplers", json!({"wrapS": 33648, "wrapT": 33071}));
    doc.json["textures"][0]["sampler"] = json!(0);
    let scene = load(&doc);
    let material = scene.materials[0];
    // the specification's example: u' = v * scale, v' = 1 - u * scale
    for (row, want) in [(material.uv_row0, [0.0, 0.25, 0.0, 0.0]), (material.uv_row1, [-0.5, 0.0, 1.0, 0.0])] {
        assert!(row.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6), "{row:?}");
    }
    assert_eq!(material.wrap, 1 | 2 << 2);
    assert_eq!((material.width, material.height, material.texel_offset), (2, 2, 0));
    assert_eq!(scene.texels, [0x04030201, 0x08070605, 0x0c0b0a09, 0x100f0e0d]);
    assert!(scene.attributes.iter().any(|a| a.uv == [1.0, 0.0]));
}

#[test]
fn opaque_textures_shrink_and_tested_ones_do_not() {
    let rgba: Vec<u8> = (0..1024u32 * 1024).flat_map(|i| [(i % 2 * 200) as u8, 7, 9, (i % 2 * 255) as u8]).collect();
    let material = |mode: &str| json!({"alphaMode": mode, "pbrMetallicRoughness": {"baseColorTexture": {}}});
    let scene = load(&textured(material("OPAQUE"), &rgba, 1024));
    assert_eq!((scene.materials[0].width, scene.texels.len()), (512, 512 * 512));
    assert!(scene.texels.iter().all(|t| t & 0xffffff == 0x090764));
    let scene = load(&textured(material("MASK"), &rgba, 1024));
    assert_eq!((scene.materials[0].width, scene.texels.len()), (1024, 1024 * 1024));
    let scene = load(&textured(material("MASK"), &[255; 1024 * 1024 * 4], 1024));
    assert_eq!((scene.materials[0].width, scene.texels.len()), (512, 512 * 512));
}

#[test]
fn many_textures_fit_or_fail() {
    let many = |mode: &str| {
        let mut doc = Doc::triangle();
        let rgba: Vec<u8> = (0..512 * 512u32).flat_map(|i| [1, 2, 3, (i % 2 * 255) as u8]).collect();
        doc.texture(512, 512, &rgba);
        for i in 0..121 {
            if i > 0 {
                doc.push("images", doc.json["images"][0].clone());
                doc.push("textures", json!({"source": i}));
            }
            doc.push(
                "materials",
                json!({"alphaMode": mode, "pbrMetallicRoughness": {"baseColorTexture": {"index": i}}}),
            );
            let primitive = json!({"attributes": {"POSITION": 0}, "material": i});
            doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
        }
        doc
    };
    // 120 images of 512 x 512 are exactly 120 MiB
    let scene = load(&many("OPAQUE"));
    assert_eq!(scene.texels.len(), 121 * 256 * 256);
    assert!(scene.materials.iter().filter(|m| m.texel_offset != NO_TEXTURE).all(|m| m.width == 256));
    fails(&many("MASK"), "alpha is tested take more than 31457280 texels");
}

#[test]
fn alpha_classes() {
    use Blend::{Ignored, Tested, Translucent};
    // mode, cutoff, factor, texture alphas, vertex alpha, blend; expected: tested and casts, or dropped
    type Case = (&'static str, Option<f32>, f32, [u8; 2], u8, Blend, Option<(bool, bool)>);
    let cases: [Case; 16] = [
        ("OPAQUE", None, 0.1, [0, 0], 0, Tested, Some((false, true))),
        ("MASK", None, 1.0, [0, 255], 255, Tested, Some((true, true))),
        ("MASK", None, 1.0, [255, 255], 255, Tested, Some((false, true))),
        ("MASK", None, 1.0, [128, 255], 255, Tested, Some((false, true))),
        ("MASK", None, 1.0, [127, 255], 255, Tested, Some((true, true))),
        ("MASK", None, 0.4, [0, 255], 255, Tested, None),
        ("MASK", Some(0.25), 0.4, [0, 255], 255, Tested, Some((true, true))),
        ("MASK", None, 1.0, [0, 255], 100, Tested, None),
        ("MASK", Some(0.0), 1.0, [0, 255], 255, Tested, Some((false, true))),
        ("MASK", Some(1.5), 1.0, [255, 255], 255, Tested, None),
        ("BLEND", Some(0.9), 0.6, [255, 255], 255, Tested, Some((false, true))),
        ("BLEND", None, 0.6, [0, 255], 255, Ignored, Some((true, false))),
        ("BLEND", None, 0.4, [0, 255], 255, Tested, None),
        ("BLEND", None, 0.4, [0, 255], 255, Translucent, Some((true, true))),
        ("BLEND", None, 1.0, [255, 255], 255, Translucent, Some((false, true))),
        ("MASK", None, 0.4, [0, 255], 255, Translucent, None),
    ];
    for (mode, cutoff, factor, alphas, vertex, blend, want) in cases {
        let pbr = json!({"baseColorTexture": {}, "baseColorFactor": [1.0, 1.0, 1.0, factor]});
        let mut material = json!({"alphaMode": mode, "pbrMetallicRoughness": pbr});
        if let Some(cutoff) = cutoff {
            material["alphaCutoff"] = json!(cutoff);
        }
        let [low, high] = alphas;
        let mut doc = textured(material, &[9, 9, 9, low, 9, 9, 9, high, 9, 9, 9, high, 9, 9, 9, high], 2);
        let colors = doc.accessor("VEC4", U8, 3, &[255, 0, 0, vertex, 255, 0, 0, vertex, 255, 0, 0, vertex]);
        doc.json["accessors"][colors]["normalized"] = json!(true);
        doc.primitive()["attributes"]["COLOR_0"] = json!(colors);
        // a second mesh keeps the scene from being empty
        doc.mesh(json!({"attributes": {"POSITION": 0}}));
        doc.push("nodes", json!({"mesh": 1}));
        let scene = load_with(&doc, &LoadOptions { blend, ..LoadOptions::default() }).unwrap();
        let shown = (scene.meshes.len() == 2).then(|| (scene.meshes[0].alpha_tested, scene.meshes[0].casts));
        assert_eq!(shown, want, "{mode} {cutoff:?} {factor} {alphas:?} {vertex}");
        if want.is_some() {
            assert_eq!(scene.attributes[0].color, u32::from(vertex) << 24 | 255);
            let stored = scene.materials[scene.meshes[0].material as usize];
            assert_eq!(stored.translucent, u32::from(mode == "BLEND" && blend == Translucent));
            let cutoff = match mode {
                "OPAQUE" => 0.0,
                "BLEND" => 0.5,
                _ => cutoff.unwrap_or(0.5),
            };
            assert_eq!(stored.alpha_cutoff, cutoff);
        } else {
            assert_eq!(
                scene.warnings,
                ["mesh 0 `thing`, primitive 0: alpha is below the cutoff everywhere, so it was left out"]
            );
        }
    }
}

#[test]
fn vertex_colours_of_three_floats() {
    let mut doc = Doc::triangle();
    let colors = doc.floats("VEC3", &[1.0, 0.5, 0.0, 1.0, 0.5, 0.0, 1.0, 0.5, 0.0]);
    doc.primitive()["attributes"]["COLOR_0"] = json!(colors);
    assert_eq!(load(&doc).attributes[0].color, 0xff0080ff);
}

/// A triangle on two joints: the first stays, the second turns by 90 degrees about z at (0,1,0).
fn skinned() -> Doc {
    let mut doc = Doc::triangle();
    let joints = doc.accessor("VEC4", U8, 3, &[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 9, 0]);
    // weights that do not sum to one are normalised; joint 9 has none
    let weights = doc.floats("VEC4", &[2.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let shift = |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, y, 0.0, 1.0];
    let binds = doc.floats("MAT4", &[shift(0.0), shift(-1.0)].concat());
    let half = std::f64::consts::FRAC_1_SQRT_2;
    doc.push("nodes", json!({"children": [2]}));
    doc.push("nodes", json!({"translation": [0, 1, 0], "rotation": [0, 0, half, half]}));
    doc.push("skins", json!({"joints": [1, 2], "inverseBindMatrices": binds}));
    doc.json["nodes"][0]["skin"] = json!(0);
    // ignored: a skinned mesh stands where its joints are
    doc.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    doc
}

#[test]
fn skins_are_posed() {
    let scene = load(&skinned());
    let [a, b, c] = only(&scene);
    near(a, 0.0, 0.0, 0.0);
    // (1,0,0): half stays, half turns about (0,1,0) to (1,2,0)
    near(b, 1.0, 1.0, 0.0);
    near(c, 0.0, 1.0, 0.0);
    assert_eq!(scene.instances[0].rows, [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let mut doc = skinned();
    doc.json["skins"][0]["joints"] = json!([1]);
    fails(&doc, "vertex 1 names joint 1 but the skin has 1");
}

#[test]
fn morph_targets_and_animated_weights() {
    let mut doc = Doc::triangle();
    let deltas = [
        doc.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        doc.floats("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ];
    doc.primitive()["targets"] = json!([{"POSITION": deltas[0]}, {"POSITION": deltas[1]}]);
    near(only(&load(&doc))[0], 0.0, 0.0, 0.0);
    doc.json["meshes"][0]["weights"] = json!([0.5, 0.0]);
    near(only(&load(&doc))[0], 0.0, 0.0, 0.5);
    doc.json["nodes"][0]["weights"] = json!([0.0, 0.25]);
    doc.json["nodes"][0]["translation"] = json!([0, 0, 3]);
    let [a, b, _] = only(&load(&doc));
    near(a, 0.0, 0.0, 3.0);
    near(b, 2.0, 0.0, 3.0);
    animate(&mut doc, "weights", "LINEAR", &[0.0, 2.0], "SCALAR", &[0.0, 0.0, 1.0, 0.5]);
    let [a, b, _] = only(&load_at(&doc, 1.0));
    near(a, 0.0, 0.0, 3.5);
    near(b, 2.0, 0.0, 3.0);
}

fn animate(doc: &mut Doc, path: &str, interpolation: &str, times: &[f32], kind: &str, values: &[f32]) {
    let (input, output) = (doc.floats("SCALAR", times), doc.floats(kind, values));
    doc.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        }),
    );
}

#[test]
fn key_interpolation() {
    let moved = |interpolation: &str, values: &[f32], time: f64| {
        let mut doc = Doc::triangle();
        animate(&mut doc, "translation", interpolation, &[1.0, 3.0], "VEC3", values);
        only(&load_at(&doc, time))[0].x
    };
    let plain = [2.0, 0.0, 0.0, 6.0, 0.0, 0.0];
    // before the first key, on keys, between, at the end, wrapped around by one and by minus one duration
    for (time, step, linear) in
        [(0.0, 2.0, 2.0), (1.0, 2.0, 2.0), (1.5, 2.0, 3.0), (3.0, 6.0, 6.0), (4.5, 2.0, 3.0), (-1.5, 2.0, 3.0)]
    {
        assert!((moved("STEP", &plain, time) - step).abs() < 1e-6, "STEP at {time}");
        assert!((moved("LINEAR", &plain, time) - linear).abs() < 1e-6, "LINEAR at {time}");
    }
    let z = [0.0; 2];
    // in-tangent, value, out-tangent of each key; only the tangents inside count
    let spline =
        [9.0, z[0], z[1], 2.0, z[0], z[1], 1.0, z[0], z[1], -1.0, z[0], z[1], 6.0, z[0], z[1], 9.0, z[0], z[1]];
    // t = 1/4 of 2 s: 0.84375*2 + 2*0.140625*1 + 0.15625*6 + 2*(-0.046875)*(-1)
    assert!((moved("CUBICSPLINE", &spline, 1.5) - 3.0).abs() < 1e-6);
    assert!((moved("CUBICSPLINE", &spline, 2.0) - 4.5).abs() < 1e-6);
    assert!((moved("CUBICSPLINE", &spline, 0.0) - 2.0).abs() < 1e-6);
}

#[test]
fn rotations_take_the_short_way_and_read_integers() {
    let mut doc = Doc::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // the second key is the negative of a quarter turn
    animate(&mut doc, "rotation", "LINEAR", &[0.0, 1.0], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half]);
    near(only(&load_at(&doc, 0.5))[1], half.into(), half.into(), 0.0);

    let mut doc = Doc::triangle();
    animate(&mut doc, "rotation", "STEP", &[0.0], "VEC4", &[0.0; 4]);
    let keys: [i16; 4] = [0, 0, 23170, 23170];
    let output = doc.accessor("VEC4", I16, 1, bytemuck::cast_slice(&keys));
    doc.json["accessors"][output]["normalized"] = json!(true);
    doc.json["animations"][0]["samplers"][0]["output"] = json!(output);
    near(only(&load(&doc))[1], 0.0, 1.0, 0.0);
}

#[test]
fn far_from_zero() {
    // by the node, by the vertices, by a skin's joints
    let mut by_node = Doc::triangle();
    by_node.json["nodes"][0]["translation"] = json!([1e6, 2e6, -1e6]);
    by_node.push("nodes", json!({"children": [0], "translation": [0.015625, 0, 0]}));
    let mut by_vertex = Doc::new();
    let far = [1e4f32, 0.0, 0.0, 1e4 + 1.0, 0.0, 0.0, 1e4, 1.0, 0.0];
    let positions = by_vertex.floats("VEC3", &far);
    let mesh = by_vertex.mesh(json!({"attributes": {"POSITION": positions}}));
    let turn = std::f64::consts::FRAC_1_SQRT_2;
    by_vertex.push("nodes", json!({"mesh": mesh, "rotation": [0, 0, turn, turn]}));
    let mut by_joint = skinned();
    by_joint.push("nodes", json!({"children": [1], "translation": [1e6, 1e6, 1e6]}));
    // the corner at mesh space zero or (1e4,0,0), and the edge from it to the second corner
    let cases = [
        (by_node, [1e6 + 0.015625, 2e6, -1e6], [1.0, 0.0, 0.0]),
        (by_vertex, [0.0, 1e4, 0.0], [0.0, 1.0, 0.0]),
        (by_joint, [1e6, 1e6, 1e6], [1.0, 1.0, 0.0]),
    ];
    for (doc, corner, edge) in cases {
        let scene = load(&doc);
        assert!(scene.positions.iter().flatten().all(|v| v.abs() <= 2.0), "{:?}", scene.positions);
        assert!(scene.instances.iter().flat_map(|i| i.rows).all(|r| r[3].abs() <= 2.0));
        let [a, b, _] = only(&scene);
        assert!((b - a - DVec3::from(edge)).length() < 1e-6, "{}", b - a);
        assert!((a - DVec3::from(corner)).length() < 1e-3, "{a}");
    }
    let mut doc = Doc::triangle();
    doc.json["nodes"][0]["translation"] = json!([1000000.125, 0, 0]);
    assert!((load(&doc).origin.x - 1000000.625).abs() < 1e-9);
    let mut doc = Doc::triangle();
    doc.json["nodes"][0]["translation"] = json!([0.01, 0, 0]);
    doc.push("nodes", json!({"mesh": 0, "translation": [3.02, 0, 0]}));
    doc.push("nodes", json!({"children": [0, 1], "translation": [1e6, 0, 0]}));
    let found = world(&load(&doc));
    assert!((found[0][0].x - 1e6 - 0.01).abs() < 1e-6 && (found[1][0].x - 1e6 - 3.02).abs() < 1e-6, "{found:?}");
}

/// Translation of the first instance.
fn translation(scene: &Scene) -> Vec3 {
    Vec3::from(scene.instances[0].rows.map(|r| r[3]))
}

#[test]
fn clusters_tile_random_meshes() {
    for seed in 0..24u64 {
        let mut random = Random(seed);
        let count = [1, 2, 127, 128, 129, 255, 256, 257, 1000, 5000, 20000, 40000][seed as usize % 12];
        let vertices = count / 2 + 3;
        let stretch = [1.0, 100.0, 0.01][seed as usize % 3];
        let corners: Vec<f32> =
            (0..vertices).flat_map(|_| [random.unit() * stretch, random.unit(), random.unit() + 50.0]).collect();
        let distinct = |random: &mut Random| loop {
            let t = [0; 3].map(|_| random.below(vertices) as u32);
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                return t;
            }
        };
        let mut triangles: Vec<[u32; 3]> = (0..count).map(|_| distinct(&mut random)).collect();
        let mut doc = Doc::new();
        let (positions, indices) = (doc.floats("VEC3", &corners), doc.indices(triangles.as_flattened()));
        let numbers: Vec<u32> = (0..vertices as u32).collect();
        let colors = doc.accessor("VEC4", U8, vertices, bytemuck::cast_slice(&numbers));
        doc.json["accessors"][colors]["normalized"] = json!(true);
        let attributes = json!({"POSITION": positions, "COLOR_0": colors});
        let mesh = doc.mesh(json!({"attributes": attributes, "indices": indices}));
        doc.push("nodes", json!({"mesh": mesh}));
        let scene = load(&doc);
        assert_eq!(scene.clusters.len(), count.div_ceil(CLUSTER_TRIANGLES), "seed {seed}");
        // colours number the vertices, so the same triangles must come back, each with its own corners
        let number = |i: &u32| scene.attributes[*i as usize].color;
        let mut found: Vec<[u32; 3]> =
            scene.indices.chunks(3).map(|t| [number(&t[0]), number(&t[1]), number(&t[2])]).collect();
        found.sort_unstable();
        triangles.sort_unstable();
        assert!(found == triangles, "seed {seed}: triangles were lost or changed");
        for (attributes, p) in scene.attributes.iter().zip(&scene.positions) {
            let from = &corners[3 * attributes.color as usize..][..3];
            let back = scene.origin.as_vec3() + Vec3::from(*p) + translation(&scene);
            assert!((back - Vec3::from_slice(from)).length() < 1e-4 * stretch.max(1.0), "seed {seed}");
        }
        let again = load(&doc);
        assert_eq!((scene.indices, scene.clusters), (again.indices, again.clusters), "seed {seed}");
    }
}

#[test]
fn clusters_are_compact() {
    let (side, mut corners, mut indices) = (65u32, Vec::new(), Vec::new());
    for i in 0..side * side {
        corners.extend([(i % side) as f32, (i / side) as f32, 0.0]);
        if i % side + 1 < side && i / side + 1 < side {
            indices.extend([i, i + 1, i + side, i + 1, i + side + 1, i + side]);
        }
    }
    let mut doc = Doc::new();
    let (positions, indices) = (doc.floats("VEC3", &corners), doc.indices(&indices));
    let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    doc.push("nodes", json!({"mesh": mesh}));
    let scene = load(&doc);
    assert_eq!(scene.clusters.len(), 64);
    // 128 triangles cover 64 cells; rows of the file would be 64 long
    assert!(scene.clusters.iter().all(|c| c.extent[0] <= 6.0 && c.extent[1] <= 6.0));
}

#[test]
fn every_error_has_its_sentence() {
    let edit = |change: &dyn Fn(&mut Doc)| {
        let mut doc = Doc::triangle();
        change(&mut doc);
        doc
    };
    let list = |values: &[u32]| values.to_vec();
    let cases: Vec<(Doc, &str)> = vec![
        (edit(&|d| d.json["asset"]["version"] = json!("1.0")), "asset.version is `1.0`; only 2.x is supported"),
        (
            edit(&|d| d.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
            "requires the extension `KHR_draco_mesh_compression`",
        ),
        (
            edit(&|d| d.json["extensionsRequired"] = json!(["EXT_meshopt_compression"])),
            "requires the extension `EXT_meshopt_compression`",
        ),
        (
            edit(&|d| d.json["buffers"] = json!([{"byteLength": 1000}])),
            "buffer 0 holds 36 bytes but its byteLength is 1000",
        ),
        (
            edit(&|d| d.json["buffers"] = json!([{"byteLength": 1, "uri": "data:;base64,$"}])),
            "buffer 0 has a data URI with malformed base64",
        ),
        (
            edit(&|d| d.json["buffers"] = json!([{"byteLength": 1, "uri": "https://a.b/c"}])),
            "buffer 0 is at `https://a.b/c`",
        ),
        (
            edit(&|d| d.json["bufferViews"][0]["byteLength"] = json!(100)),
            "buffer view 0 covers 100 bytes from 0 but buffer 0 holds 36",
        ),
        (
            edit(&|d| d.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX)),
            "buffer view 0 covers 36 bytes from 18446744073709551615",
        ),
        (
            edit(&|d| d.json["bufferViews"][0]["byteLength"] = json!(35)),
            "accessor 0 (POSITION) needs 3 elements of 12 bytes (stride 12) from 0 but buffer view 0 holds 35 bytes",
        ),
        (
            edit(&|d| {
                let (at, values) = (d.view(&[3, 0]), d.view(&[0; 12]));
                d.json["accessors"][0]["sparse"] = json!({
                    "count": 1, "indices": {"bufferView": at, "componentType": U16}, "values": {"bufferView": values}
                });
            }),
            "accessor 0 (POSITION) has the sparse index 3 but 3 elements",
        ),
        (edit(&|d| d.json["bufferViews"][0]["byteStride"] = json!(4)), "buffer view 0 has a stride of 4"),
        (
            edit(&|d| d.json["bufferViews"][0]["byteStride"] = json!(100)),
            "needs 3 elements of 12 bytes (stride 100) from 0 but buffer view 0 holds 36 bytes",
        ),
        (edit(&|d| d.json["accessors"][0]["count"] = json!(4)), "accessor 0 (POSITION) needs 4 elements of 12 bytes"),
        (
            edit(&|d| d.json["accessors"][0]["count"] = json!(u64::MAX)),
            "accessor 0 (POSITION) has 18446744073709551615 elements",
        ),
        (edit(&|d| d.json["accessors"][0]["byteOffset"] = json!(4)), "accessor 0 (POSITION) needs 3 elements"),
        (
            edit(&|d| d.json["accessors"][0]["type"] = json!("VEC2")),
            "accessor 0 (POSITION) has 2 components; 3 are needed",
        ),
        (
            edit(&|d| d.json["accessors"][0]["componentType"] = json!(7)),
            "accessor 0 (POSITION) has an unknown component type",
        ),
        (edit(&|d| d.json["accessors"][0]["bufferView"] = json!(9)), "buffer view 9 is named but the file has 1"),
        (
            edit(&|d| {
                d.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            }),
            "accessor 0 (POSITION) has neither a buffer view nor sparse values",
        ),
        (edit(&|d| d.primitive()["attributes"] = json!({"POSITION": 5})), "accessor 5 is named but the file has 1"),
        (
            edit(&|d| d.primitive()["attributes"] = json!({})),
            "mesh 0 `thing`, primitive 0: the attribute POSITION is missing",
        ),
        (edit(&|d| d.primitive()["mode"] = json!(12)), "mesh 0 `thing`, primitive 0: the mode is unknown"),
        (edit(&|d| d.primitive()["material"] = json!(3)), "material 3 is named but the file has 0"),
        (
            edit(&|d| {
                let i = d.indices(&list(&[0, 1, 3]));
                d.primitive()["indices"] = json!(i);
            }),
            "mesh 0 `thing`, primitive 0: index 2 is 3 but there are 3 vertices",
        ),
        (
            edit(&|d| {
                let i = d.floats("SCALAR", &[0.0, 1.0, 2.0]);
                d.primitive()["indices"] = json!(i);
            }),
            "(indices) has component type 5126",
        ),
        (
            edit(&|d| d.bin[16..20].copy_from_slice(&f32::NAN.to_le_bytes())),
            "mesh 0 `thing`, primitive 0: vertex 1 has the position value NaN; it must be finite",
        ),
        (edit(&|d| d.bin[0..4].copy_from_slice(&f32::INFINITY.to_le_bytes())), "vertex 0 has the position value inf"),
        (edit(&|d| d.bin.fill(0)), "all 1 triangles of the scene have zero area"),
        (edit(&|d| d.json["nodes"] = json!([])), "the scene has no triangles"),
        (edit(&|d| d.json["nodes"] = json!([{"mesh": 4}])), "mesh 4 is named but the file has 1"),
        (edit(&|d| d.json["nodes"] = json!([{"children": [4]}])), "node 4 is named but the file has 1"),
        (
            edit(&|d| d.json["nodes"] = json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}])),
            "node 1 is part of a cycle; nodes must form a tree",
        ),
        (edit(&|d| d.json["nodes"] = json!([{"children": [0]}])), "node 0 is part of a cycle"),
        (
            edit(&|d| d.json["nodes"] = json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}])),
            "node 0 is a child of both node 1 and node 2",
        ),
        (edit(&|d| d.json["nodes"][0]["scale"] = json!([1e300, 1, 1])), "the JSON is malformed (number out of range"),
        (
            edit(&|d| d.json["nodes"][0]["scale"] = json!([1e30, 1e30, 1])),
            "allowed is more than 0 up to 1000000000000000000",
        ),
        (edit(&|d| d.json["scene"] = json!(2)), "scene 2 is named but the file has 0"),
        (edit(&|d| d.json["nodes"][0]["skin"] = json!(0)), "the scene has a skin"),
        (edit(&|d| image_of(d, json!({"uri": "gone.png"}))), "image 0 names the file `gone.png`, which cannot be read"),
        (edit(&|d| image_of(d, json!({"uri": "data:,hello"}))), "image 0 cannot be decoded"),
        (edit(&|d| image_of(d, json!({}))), "image 0 has neither a buffer view nor a uri"),
        (
            edit(&|d| image_of(d, json!({"bufferView": 8}))),
            "image 0 cannot be read: buffer view 8 is named but the file has 1",
        ),
        (
            edit(&|d| animate(d, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0; 3])),
            "animation 0, channel 0: 3 numbers for 2 keys; 6 are needed",
        ),
        (edit(&|d| animate(d, "translation", "LINEAR", &[], "VEC3", &[0.0; 3])), "animation 0, channel 0: 0 key times"),
        (
            edit(&|d| {
                animate(d, "scale", "LINEAR", &[0.0], "VEC3", &[1.0; 3]);
                d.json["animations"][0]["channels"][0]["target"]["node"] = json!(6);
            }),
            "animation 0 moves node 6 but the file has 1",
        ),
    ];
    for (doc, sentence) in cases {
        // a node's skin without joints in the mesh is ignored
        match sentence {
            "the scene has a skin" => assert_eq!(load(&doc).unique_triangles(), 1),
            _ => fails(&doc, sentence),
        }
    }
    let error = load_with(&Doc::triangle(), &LoadOptions { time_s: f64::NAN, ..LoadOptions::default() }).unwrap_err();
    assert_eq!(error.what, "the time is NaN s; it must be finite");
}

fn image_of(doc: &mut Doc, image: Value) {
    doc.push("images", image);
    doc.push("textures", json!({"source": 0}));
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.primitive()["material"] = json!(0);
}

/// A small file that uses everything: texture, skin, morph target, animation, sparse values.
fn rich() -> Doc {
    let mut doc = skinned();
    let deltas = doc.floats("VEC3", &[0.0; 9]);
    doc.primitive()["targets"] = json!([{"POSITION": deltas}]);
    doc.json["meshes"][0]["weights"] = json!([1.0]);
    animate(&mut doc, "rotation", "CUBICSPLINE", &[0.0, 1.0], "VEC4", &[0.25; 24]);
    let texture = doc.texture(2, 2, &[200; 16]);
    let pbr = json!({"baseColorTexture": {"index": texture}});
    doc.push("materials", json!({"alphaMode": "MASK", "pbrMetallicRoughness": pbr}));
    let uv = doc.floats("VEC2", &[0.0; 6]);
    let indices = doc.accessor("SCALAR", U16, 3, &[0, 0, 1, 0, 2, 0]);
    doc.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    doc.primitive()["indices"] = json!(indices);
    doc.primitive()["material"] = json!(0);
    let (at, values) = (doc.view(&[1]), doc.view(bytemuck::cast_slice(&[0.5f32, 0.5])));
    doc.json["accessors"][uv]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": at, "componentType": U8}, "values": {"bufferView": values}
    });
    let kinds: BTreeSet<u64> =
        doc.json["accessors"].as_array().unwrap().iter().filter_map(|a| a["componentType"].as_u64()).collect();
    assert!(kinds.contains(&F32.into()) && kinds.contains(&U16.into()) && kinds.contains(&U8.into()));
    doc
}

#[test]
fn cut_files_fail() {
    let bytes = rich().glb();
    let folder = Folder::new();
    assert!(scene::load(&folder.file("whole.glb", &bytes), &LoadOptions::default()).is_ok());
    for length in 0..bytes.len() {
        let result = scene::load(&folder.file("cut.glb", &bytes[..length]), &LoadOptions::default());
        assert!(result.is_err(), "{length} of {} bytes were accepted", bytes.len());
    }
}

#[test]
fn cut_files_with_an_honest_header_do_not_panic() {
    let bytes = rich().glb();
    let folder = Folder::new();
    for length in 12..bytes.len() {
        let mut cut = bytes[..length].to_vec();
        cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        assert!(scene::load(&folder.file("cut.glb", &cut), &LoadOptions::default()).is_err(), "{length}");
    }
}

#[test]
fn damaged_files_do_not_panic() {
    let bytes = rich().glb();
    let folder = Folder::new();
    let mut loaded = 0;
    for seed in 0..3000 {
        let mut random = Random(seed);
        let mut damaged = bytes.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(8);
        }
        // half of the digits in the JSON are worth a wilder change
        if seed % 2 == 0 {
            let digits: Vec<usize> = (20..damaged.len()).filter(|&i| damaged[i].is_ascii_digit()).collect();
            damaged[digits[random.below(digits.len())]] = b'0' + random.below(10) as u8;
        }
        let path = folder.file("damaged.glb", &damaged);
        if let Ok(scene) = scene::load(&path, &LoadOptions { time_s: 0.3, ..LoadOptions::default() }) {
            check(&scene);
            loaded += 1;
        }
    }
    // flips in values load, flips in structure fail: both must happen or the test shows nothing
    assert!((100..2900).contains(&loaded), "{loaded} of 3000 loaded");
}

#[test]
fn builtin_scene() {
    let scene = scene::builtin();
    check(&scene);
    assert_eq!(scene.name, "builtin");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!((20_000..=60_000).contains(&scene.drawn_triangles()), "{}", scene.drawn_triangles());
    assert!(scene.unique_triangles() < scene.drawn_triangles());
    let size = scene.bounds_max - scene.bounds_min;
    assert!((size.x - 24.0).abs() < 0.1 && (size.z - 24.0).abs() < 0.1 && (3.0..8.0).contains(&size.y), "{size}");
    assert!(scene.meshes.iter().any(|m| m.instance_count >= 8 && m.index_count > 3000), "columns");
    assert!(scene.meshes.iter().any(|m| m.instance_count >= 24 && m.index_count < 600), "fence bars");
    let leaves: Vec<_> = scene.meshes.iter().filter(|m| m.alpha_tested).collect();
    assert!(leaves.len() == 1 && leaves[0].index_count >= 600 * 2);
    let texels = &scene.texels[..64 * 64];
    let opaque = texels.iter().filter(|t| *t >> 24 >= 128).count();
    assert!((texels.len() / 5..texels.len() * 4 / 5).contains(&opaque), "{opaque} opaque texels");
    let again = scene::builtin();
    assert_eq!((scene.positions, scene.indices, scene.texels), (again.positions, again.indices, again.texels));
}
