//! Files that appear whole or not at all, and the pictures in them.
#![cfg(feature = "lab")]

use glam::DVec3;
use std::path::{Path, PathBuf};
use umbrage::output::{
    DIFFERENCE_LEGEND, Picture, difference, ids, levels, read_exr, shade, side_by_side, write_exr, write_file,
    write_png,
};
use umbrage::truth::{GBuffer, Reference};
use umbrage::{Camera, Light};

/// A folder of its own, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("umbrage-output-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn noise(n: usize, seed: u32) -> Vec<f32> {
    (0..n as u32).map(|i| f32::from_bits(i.wrapping_mul(2_654_435_761).wrapping_add(seed))).collect()
}

#[test]
fn exr_keeps_every_bit_and_name() {
    let folder = Folder::new("exr");
    let (width, height) = (37, 29);
    let (a, b, c) = (noise(37 * 29, 1), noise(37 * 29, 2), noise(37 * 29, 3));
    let path = folder.0.join("image.exr");
    write_exr(&path, width, height, &[("light0.V", &a), ("V", &b), ("Normal.X", &c)]).unwrap();
    let image = read_exr(&path).unwrap();
    assert_eq!((image.width, image.height, image.channels.len()), (width, height, 3));
    for (name, values) in [("light0.V", &a), ("V", &b), ("Normal.X", &c)] {
        let read = image.channel(name).unwrap_or_else(|| panic!("no channel {name}"));
        let bits = |v: &[f32]| v.iter().map(|f| f.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(read), bits(values), "{name}");
    }
    assert!(image.channel("W").is_none());
    assert_eq!(folder.names(), ["image.exr"]);
}

#[test]
fn exr_rejects_lists_that_do_not_fit() {
    let folder = Folder::new("exr-bad");
    let path = folder.0.join("image.exr");
    let one: &[f32] = &[1.0];
    for (size, channels, word) in [
        ((1, 1), vec![], "no channel"),
        ((2, 1), vec![("V", one)], "V has 1 values"),
        ((0, 0), vec![("V", &one[..0])], "0x0"),
        ((1, 1), vec![("V", one), ("V", one)], "twice"),
        ((1, 1), vec![("", one)], "name"),
    ] {
        let error = write_exr(&path, size.0, size.1, &channels).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn unwritable_places_are_named_and_left_clean() {
    let folder = Folder::new("unwritable");
    let file = folder.0.join("file");
    std::fs::write(&file, "x").unwrap();
    let taken = folder.0.join("taken");
    std::fs::create_dir_all(taken.join("full")).unwrap();
    for path in [folder.0.join("missing/a.exr"), file.join("a.exr"), taken] {
        for result in [
            write_exr(&path, 1, 1, &[("V", &[1.0])]),
            write_png(&path, &Picture::filled(1, 1, [0; 3])),
            write_file(&path, b"bytes"),
        ] {
            let error = result.unwrap_err();
            assert_eq!(error.path, path.display().to_string());
            assert!(error.to_string().starts_with(&error.path), "{error}");
        }
    }
    let mut names = folder.names();
    names.sort();
    assert_eq!(names, ["file", "taken"]);
    assert!(write_file(Path::new("/"), b"").is_err());
}

#[test]
fn a_failed_write_keeps_the_old_file() {
    let folder = Folder::new("keep");
    let path = folder.0.join("a.png");
    write_file(&path, b"old").unwrap();
    assert!(write_png(&path, &Picture { width: 2, height: 2, rgb: vec![0; 3] }).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    write_file(&path, b"new").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"new");
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn read_exr_names_the_file() {
    let folder = Folder::new("read");
    let path = folder.0.join("a.exr");
    assert!(read_exr(&path).unwrap_err().to_string().contains("a.exr"));
    write_file(&path, b"not an image").unwrap();
    assert!(read_exr(&path).unwrap_err().to_string().contains("a.exr"));
    write_exr(&path, 4, 4, &[("V", &[0.5; 16])]).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in 0..whole.len() {
        write_file(&path, &whole[..length]).unwrap();
        // a reader may accept a file that lost its last bytes, but it must not panic
        let _ = read_exr(&path);
    }
}

#[test]
fn png_round_trip() {
    let folder = Folder::new("png");
    let path = folder.0.join("a.png");
    let picture = Picture { width: 5, height: 3, rgb: (0..45).map(|i| i * 5).collect() };
    write_png(&path, &picture).unwrap();
    let read = image::open(&path).unwrap().into_rgb8();
    assert_eq!((read.width(), read.height()), (5, 3));
    assert_eq!(read.into_raw(), picture.rgb);
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn side_by_side_places_tiles() {
    let (red, blue) = (Picture::filled(60, 40, [255, 0, 0]), Picture::filled(50, 30, [0, 0, 255]));
    let row = side_by_side(&[("red", &red), ("blue", &blue)], 0);
    let grid = side_by_side(&[("red", &red), ("blue", &blue), ("third", &red)], 2);
    let column = side_by_side(&[("red", &red), ("blue", &blue)], 1);
    let count = |p: &Picture, color: [u8; 3]| p.rgb.chunks(3).filter(|c| **c == color).count();
    assert_eq!((row.rgb.len(), row.width > 120, row.height > 40), (3 * (row.width * row.height) as usize, true, true));
    assert_eq!((count(&row, [255, 0, 0]), count(&row, [0, 0, 255])), (60 * 40, 50 * 30));
    assert_eq!((grid.width, grid.height), (row.width, 2 * (row.height - 4) + 4));
    assert_eq!(count(&grid, [255, 0, 0]), 2 * 60 * 40);
    assert_eq!((column.height, column.width), (grid.height, 60 + 8));
    let unnamed = side_by_side(&[("", &red), ("", &blue)], 0);
    assert_eq!((unnamed.width, unnamed.height), (row.width, row.height));
    assert_ne!(unnamed.rgb, row.rgb, "labels are drawn");
    let cut = side_by_side(&[("a label that is much longer than its tile", &red)], 0);
    assert_eq!(cut.width, 60 + 8);
    assert!(side_by_side(&[], 0).width < 60);
}

#[test]
fn every_character_has_its_own_shape() {
    let draw = |c: char| {
        let mut p = Picture::filled(8, 8, [0; 3]);
        assert_eq!(p.text(1, 0, 1, [255; 3], &c.to_string()), 7);
        p.rgb
    };
    let shapes: Vec<_> = (' '..='~').map(draw).collect();
    for (i, shape) in shapes.iter().enumerate() {
        assert_eq!(shape.iter().all(|v| *v == 0), i == 0, "{}", char::from(32 + i as u8));
        assert!(!shapes[..i].contains(shape), "{}", char::from(32 + i as u8));
    }
    assert_eq!(draw('\u{e9}'), draw('\n'), "a box for what is missing");
}

fn view() -> (GBuffer, Camera, Light) {
    // a floor below a row of sky
    let (width, height) = (16usize, 12usize);
    let hit: Vec<bool> = (0..width * height).map(|i| i >= width).collect();
    let gbuffer = GBuffer {
        width: width as u32,
        height: height as u32,
        eye: DVec3::ZERO,
        ray_steps: [0.1 * DVec3::X, -0.1 * DVec3::Y],
        position: (0..width * height).map(|i| [i as f32, 0.0, 0.0]).collect(),
        normal: hit.iter().map(|h| if *h { [0.0, 1.0, 0.0] } else { [0.0; 3] }).collect(),
        albedo: vec![0xff80_8080; width * height],
        hit,
    };
    let camera = Camera {
        eye: DVec3::new(0.0, 2.0, 5.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        fov_y_deg: 60.0,
        near: 0.1,
        far: 100.0,
    };
    (gbuffer, camera, Light::directional(DVec3::new(-0.3, -1.0, -0.2)))
}

#[test]
fn shade_is_brighter_in_the_light() {
    let (gbuffer, camera, light) = view();
    let mut visibility = vec![1.0; 16 * 12];
    visibility[100] = 0.0;
    visibility[101] = 0.5;
    let picture = shade(&gbuffer, &camera, DVec3::ZERO, &[(&light, &visibility)]).unwrap();
    let green = |i: u32| picture.get(i % 16, i / 16).unwrap()[1];
    assert!(green(100) > 20 && green(100) < green(101) && green(101) < green(102) && green(102) < 255);
    let sky = picture.get(3, 0).unwrap();
    assert!(sky[2] > sky[0], "the sky is blue: {sky:?}");
    assert!(shade(&gbuffer, &camera, DVec3::ZERO, &[(&light, &[1.0])]).is_err());
}

#[test]
fn shade_adds_all_lights_within_cone_and_range() {
    // the floor's pixel i lies at x = i; the lights stand 10 above it
    let (gbuffer, camera, sun) = view();
    let all = vec![1.0; 16 * 12];
    let place = |x: f64| DVec3::new(x, 10.0, 0.0);
    let point = Light::Point { position: place(60.0), range: 20.0 };
    let spot = Light::Spot {
        position: place(120.0),
        direction: DVec3::NEG_Y,
        inner_angle_deg: 20.0,
        outer_angle_deg: 40.0,
        range: 40.0,
    };
    let green = |lights: &[(&Light, &[f32])], i: u32| {
        shade(&gbuffer, &camera, DVec3::ZERO, lights).unwrap().get(i % 16, i / 16).unwrap()[1]
    };
    let both: [(&Light, &[f32]); 2] = [(&point, &all), (&spot, &all)];
    let night = green(&both, 180);
    assert!(green(&both, 60) > green(&both, 70) && green(&both, 70) > night, "the point fades");
    assert_eq!(green(&both, 78), night, "10 and 18 are beyond the range 20");
    assert!(green(&both, 120) >= green(&both, 123) && green(&both, 123) > green(&both, 127), "the cone fades");
    assert_eq!(green(&both, 129), night, "10 and 9 are out of 40 degrees");
    assert_eq!(green(&[(&point, &all)], 120), night);
    assert!(green(&[(&sun, &all)], 180) > green(&[(&sun, &vec![0.0; 16 * 12])], 180));
    assert!(green(&[(&sun, &all), (&point, &all)], 60) > green(&[(&sun, &all)], 60));
    let touching = Light::Point { position: DVec3::new(60.0, 1e-9, 0.0), range: 20.0 };
    assert!(green(&[(&touching, &all)], 60) > 250);
}

#[test]
fn difference_shows_the_worst_of_all_lights() {
    let (gbuffer, _, light) = view();
    let hit = gbuffer.hit.clone();
    let reference = |lit: bool| Reference {
        width: 16,
        height: 12,
        visibility: hit.iter().map(|h| u8::from(*h && lit)).collect(),
        decided: hit.clone(),
        facing: hit.clone(),
        hit: hit.clone(),
    };
    let (lit, dark) = (reference(true), reference(false));
    let with = |value: f32, at: usize, other: f32| {
        let mut image = vec![value; 16 * 12];
        image[at] = other;
        image
    };
    // acne of one light, a lost shadow of the other, and a pixel where both are wrong
    let (mut acne, mut lost) = (with(1.0, 100, 0.0), vec![0.0; 16 * 12]);
    acne[104] = 0.0;
    for i in [86, 87, 88, 89, 90, 102, 103, 104, 105, 106, 118, 119, 120, 121, 122] {
        lost[i] = 1.0;
    }
    let picture = difference(&gbuffer, DVec3::ZERO, &[(&light, &acne, &lit), (&light, &lost, &dark)]).unwrap();
    let at = |i: u32| picture.get(i % 16, i / 16).unwrap();
    let [_, red, _, magenta, _] = DIFFERENCE_LEGEND.map(|(_, color)| color);
    assert_eq!((at(100), at(104)), (red, magenta));
    assert!(difference(&gbuffer, DVec3::ZERO, &[]).is_err());
}

#[test]
fn difference_shows_single_pixels() {
    let (gbuffer, _, light) = view();
    let hit = gbuffer.hit.clone();
    let lit: Vec<u8> = hit.iter().map(|h| u8::from(*h)).collect();
    let reference =
        Reference { width: 16, height: 12, visibility: lit, decided: hit.clone(), facing: hit.clone(), hit };
    let mut result = vec![1.0; 16 * 12];
    let clean = difference(&gbuffer, DVec3::ZERO, &[(&light, &result, &reference)]).unwrap();
    result[6 * 16 + 6] = 0.0;
    let dirty = difference(&gbuffer, DVec3::ZERO, &[(&light, &result, &reference)]).unwrap();
    let acne = DIFFERENCE_LEGEND[1].1;
    let count = |p: &Picture| (0..16 * 12).filter(|i| p.get(i % 16, i / 16) == Some(acne)).count();
    assert_eq!((count(&clean), count(&dirty)), (0, 9));
    assert_eq!(dirty.get(6, 6), Some(acne));
    assert!(dirty.height > 12, "the legend stands below");
    assert!(difference(&gbuffer, DVec3::ZERO, &[(&light, &[1.0], &reference)]).is_err());
}

#[test]
fn false_colors() {
    let picture = levels(4, 1, &[0.0, 1.0, 0.5, -1.0]).unwrap();
    let at = |x| picture.get(x, 0).unwrap();
    assert!(at(0) != at(1) && at(2) != at(0) && at(2) != at(1) && at(3) != at(0));
    assert!(picture.height > 1);
    assert_eq!(levels(1, 1, &[f32::NAN]).unwrap().get(0, 0), Some(at(3)));
    let picture = ids(4, 1, &[7, 8, 7, u32::MAX]).unwrap();
    let at = |x| picture.get(x, 0).unwrap();
    assert!(at(0) == at(2) && at(0) != at(1) && at(3) != at(0));
    assert!(levels(2, 2, &[0.0]).is_err() && ids(0, 0, &[]).is_err());
}
