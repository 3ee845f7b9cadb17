//! View files: what is read, what is filled in, what is refused.
#![cfg(feature = "lab")]

use glam::DVec3;
use serde_json::{Value, json};
use umbrage::lab::View;
use umbrage::scene::{self, Scene};
use umbrage::view::{CameraPath, DEFAULT_SIZE, PATH_NAMES, PathFile, Surroundings, ViewFile};
use umbrage::{Camera, Light};

fn minimal() -> Value {
    json!({
        "camera": { "eye": [0, 1, 5], "target": [0, 1, 0], "fov_y_deg": 60 },
        "lights": [{ "type": "directional", "direction": [0.5, -1, 0.25] }]
    })
}

/// The minimal view with one field replaced; `path` is a JSON pointer.
fn with(path: &str, value: Value) -> String {
    let (parent, key) = path.rsplit_once('/').unwrap();
    let mut view = minimal();
    let place = view.pointer_mut(parent).unwrap();
    match key.parse::<usize>() {
        Ok(index) if place.is_array() => place[index] = value,
        _ => place[key] = value,
    }
    view.to_string()
}

fn sized_scene(low: DVec3, high: DVec3) -> Scene {
    Scene { bounds_min: low, bounds_max: high, origin: 0.5 * (low + high), ..Scene::default() }
}

fn room() -> Scene {
    sized_scene(DVec3::splat(-10.0), DVec3::splat(10.0))
}

fn complete(text: &str) -> View {
    ViewFile::parse("v.json", text).unwrap().complete(&room(), None).unwrap()
}

#[test]
fn absent_fields_come_from_the_scene() {
    let view = complete(&minimal().to_string());
    assert_eq!(view.camera.up, DVec3::Y);
    assert_eq!((view.size, view.time_s), (DEFAULT_SIZE, 0.0));
    assert_eq!(view.lights, [Light::directional(DVec3::new(0.5, -1.0, 0.25))]);
    assert!((view.camera.near - room().diagonal() * 1e-4).abs() < 1e-12);
    // the far corner lies 15 units behind the eye plane
    assert!(view.camera.far > 15.0 && view.camera.far < 20.0, "{}", view.camera.far);
}

#[test]
fn given_fields_are_kept() {
    let text = r#"{ "camera": { "eye": [1,2,3], "target": [4,5,6], "up": [0,0,1], "fov_y_deg": 5, "near": 0.5, "far": 7 },
        "lights": [{ "type": "directional", "direction": [0,-2,0], "angular_diameter_deg": 0.5 },
                   { "type": "area", "polygon": [[0,0,0],[1,0,0],[0,0,1]] }], "size": [320, 180], "time_s": 1.5 }"#;
    let view = complete(text);
    assert_eq!((view.camera.up, view.camera.near, view.camera.far), (DVec3::Z, 0.5, 7.0));
    assert_eq!((view.size, view.time_s), ([320, 180], 1.5));
    assert!(view.lights.iter().all(Light::has_extent));
    let again: Value = serde_json::from_str(&view.to_json().unwrap()).unwrap();
    assert_eq!(again["lights"][1]["polygon"][1], json!([1.0, 0.0, 0.0]));
}

#[test]
fn spot_and_point_lights_are_read_and_written() {
    let mut view = minimal();
    view["lights"] = json!([
        { "type": "spot", "position": [1, 2, 3], "direction": [0, -2, 0], "outer_angle_deg": 90, "range": 0.5 },
        { "type": "spot", "position": [0, 0, 0], "direction": [1, 0, 0], "inner_angle_deg": 20, "outer_angle_deg": 20, "range": 7 },
        { "type": "point", "position": [-1e6, 0, 0.1], "range": 1e6 }
    ]);
    let read = complete(&view.to_string());
    let position = DVec3::new(1.0, 2.0, 3.0);
    let direction = DVec3::new(0.0, -2.0, 0.0);
    let spot = Light::Spot { position, direction, inner_angle_deg: 0.0, outer_angle_deg: 90.0, range: 0.5 };
    assert_eq!(read.lights[0], spot);
    assert_eq!(read.lights[2], Light::Point { position: DVec3::new(-1e6, 0.0, 0.1), range: 1e6 });
    assert_eq!(complete(&read.to_json().unwrap()), read);
}

#[test]
fn the_callers_size_wins() {
    let file = ViewFile::parse("v.json", &with("/size", json!([100, 50]))).unwrap();
    assert_eq!(file.complete(&room(), None).unwrap().size, [100, 50]);
    assert_eq!(file.complete(&room(), Some([30, 20])).unwrap().size, [30, 20]);
}

#[test]
fn a_plane_given_alone_moves_the_other() {
    for (path, value) in [("/camera/near", 1000.0), ("/camera/far", 1e-5), ("/camera/near", 1e-9)] {
        let view = complete(&with(path, json!(value)));
        assert!(view.camera.near < view.camera.far, "{path} {value}");
    }
}

#[test]
fn output_is_complete_and_reads_back_the_same() {
    let view = complete(&minimal().to_string());
    let text = view.to_json().unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    for path in ["eye", "target", "up", "fov_y_deg", "near", "far"].map(|key| format!("/camera/{key}")) {
        assert!(json.pointer(&path).is_some_and(|v| !v.is_null()), "{path}");
    }
    for path in ["/lights/0/type", "/lights/0/direction", "/lights/0/angular_diameter_deg", "/size/1", "/time_s"] {
        assert!(json.pointer(path).is_some_and(|v| !v.is_null()), "{path}");
    }
    assert_eq!(complete(&text), view);
}

#[test]
fn bad_values_name_file_field_value_and_what_is_allowed() {
    let spot = |direction: [i32; 3], outer: f64, inner: f64, range: f64| {
        json!({ "type": "spot", "position": [0, 0, 0], "direction": direction,
                "outer_angle_deg": outer, "inner_angle_deg": inner, "range": range })
    };
    let cases = [
        ("/lights/0/direction", json!([0, 0, 0]), "lights[0].direction is [0.0, 0.0, 0.0]"),
        ("/lights/0/direction", json!([1e-320, 0, 0]), "lights[0].direction is"),
        ("/lights/0/direction", json!([1e300, 0, 0]), "lights[0].direction is"),
        ("/lights/0/angular_diameter_deg", json!(-1), "lights[0].angular_diameter_deg is -1"),
        ("/lights/0/angular_diameter_deg", json!(180), "lights[0].angular_diameter_deg is 180"),
        ("/lights/0", json!({ "type": "area", "polygon": [[0, 0, 0], [1, 0, 0]] }), "lights[0].polygon is 2 corners"),
        ("/lights", json!([]), "lights is empty"),
        ("/lights/0", spot([0, 0, 0], 45.0, 0.0, 1.0), "lights[0].direction is [0.0, 0.0, 0.0]"),
        ("/lights/0", spot([0, -1, 0], 90.5, 0.0, 1.0), "lights[0].outer_angle_deg is 90.5"),
        ("/lights/0", spot([0, -1, 0], 0.0, 0.0, 1.0), "lights[0].outer_angle_deg is 0"),
        ("/lights/0", spot([0, -1, 0], 45.0, 45.5, 1.0), "lights[0].inner_angle_deg is 45.5"),
        ("/lights/0", spot([0, -1, 0], 45.0, -1.0, 1.0), "lights[0].inner_angle_deg is -1"),
        ("/lights/0", spot([0, -1, 0], 45.0, 0.0, 0.0), "lights[0].range is 0"),
        ("/lights/0", json!({ "type": "point", "position": [0, 1e13, 0], "range": 1 }), "lights[0].position is"),
        ("/lights/0", json!({ "type": "point", "position": [0, 0, 0], "range": -2 }), "lights[0].range is -2"),
        ("/camera/target", json!([0, 1, 5]), "camera.target is [0.0, 1.0, 5.0]"),
        ("/camera/eye", json!([1e300, 0, 0]), "camera.eye is [1e300, 0.0, 0.0]"),
        ("/camera/up", json!([0, 0, 3]), "camera.up is [0.0, 0.0, 3.0]"),
        ("/camera/up", json!([0, 0, 0]), "camera.up is [0.0, 0.0, 0.0]"),
        ("/camera/fov_y_deg", json!(0), "camera.fov_y_deg is 0"),
        ("/camera/fov_y_deg", json!(180), "camera.fov_y_deg is 180"),
        ("/camera/fov_y_deg", json!(-5), "camera.fov_y_deg is -5"),
        ("/camera/near", json!(0), "camera.near is 0"),
        ("/camera/near", json!(-1), "camera.near is -1"),
        ("/camera/far", json!(0), "camera.far is 0"),
        ("/camera/far", json!(1e30), "camera.far is 1000000"),
        ("/size", json!([0, 5]), "size is [0, 5]"),
        ("/size", json!([16385, 5]), "size is [16385, 5]"),
    ];
    for (path, value, expected) in cases {
        let error = ViewFile::parse("v.json", &with(path, value)).unwrap_err().to_string();
        assert!(error.starts_with("v.json: ") && error.contains(expected) && error.contains("allowed is"), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn far_must_lie_behind_near() {
    let mut view = minimal();
    view["camera"]["near"] = json!(2);
    view["camera"]["far"] = json!(2);
    let error = ViewFile::parse("v.json", &view.to_string()).unwrap_err().to_string();
    assert!(error.contains("camera.far is 2, allowed is above near (2.0)"), "{error}");
}

#[test]
fn what_is_no_view_is_placed_by_line_and_column() {
    let cases = [
        (String::new(), "EOF"),
        ("{".to_owned(), "EOF"),
        ("{}".to_owned(), "missing field `camera`"),
        (with("/lights/0/type", json!("torch")), "unknown variant `torch`"),
        (with("/lights/0/type", json!("spot")), "missing field `position`"),
        (with("/lights/0/colour", json!(1)), "unknown field `colour`"),
        (with("/camera/roll", json!(1)), "unknown field `roll`"),
        (with("/sky", json!(1)), "unknown field `sky`"),
        (with("/camera/eye", json!([1, 2])), "invalid length 2"),
        (with("/camera/eye", json!("here")), "invalid type"),
        (with("/size", json!([-5, 5])), "invalid value"),
        (minimal().to_string().replace("0.5", "NaN"), "expected"),
        (minimal().to_string().replace("0.5", "1e999"), "out of range"),
        (minimal().to_string() + "x", "trailing characters"),
    ];
    for (text, expected) in cases {
        let error = ViewFile::parse("v.json", &text).unwrap_err().to_string();
        assert!(
            error.starts_with("v.json: ") && error.contains(expected) && error.contains("line 1 column"),
            "{error}"
        );
    }
}

#[test]
fn an_absent_file_is_named() {
    let error = ViewFile::read("no/such/view.json".as_ref()).unwrap_err().to_string();
    assert!(error.starts_with("no/such/view.json: cannot be read"), "{error}");
}

#[test]
fn the_chosen_view_is_valid_and_survives_the_file() {
    let scenes = [
        scene::builtin(),
        room(),
        sized_scene(DVec3::splat(-0.07), DVec3::splat(0.08)),
        sized_scene(DVec3::new(1e6, 0.0, 1e6), DVec3::new(1e6 + 300.0, 40.0, 1e6 + 200.0)),
        sized_scene(DVec3::new(-5000.0, 0.0, -5000.0), DVec3::new(5000.0, 0.0, 5000.0)),
    ];
    for scene in &scenes {
        let view = View::default_for(scene, [320, 180]);
        view.check().unwrap();
        let again = ViewFile::parse("v.json", &view.to_json().unwrap()).unwrap().complete(scene, None).unwrap();
        assert_eq!(again, view);
        assert!(view.camera.near < scene.diagonal() * 0.01 && view.camera.far < scene.diagonal() * 10.0);
    }
}

/// The cameras of a path through an empty room with a wall at x = 2, without warm-up.
fn cameras(path: &CameraPath, base: &View, frames: u32, seed: u64) -> Vec<Camera> {
    let scene = room();
    let free = |from: DVec3, way: DVec3| (from.x < 2.0) == (from.x + way.x < 2.0);
    path.cameras(base, &Surroundings { scene: &scene, distance: 4.0, free: &free }, 0, frames, seed).unwrap()
}

fn base(eye: [f64; 3], target: [f64; 3]) -> View {
    let mut view = minimal();
    view["camera"]["eye"] = json!(eye);
    view["camera"]["target"] = json!(target);
    complete(&view.to_string())
}

fn heading(camera: &Camera) -> DVec3 {
    (camera.target - camera.eye).normalize()
}

#[test]
fn every_path_starts_at_the_view_and_holds_the_scene() {
    let base = base([-3.0, 1.0, 5.0], [0.0, 0.0, 0.0]);
    let pixel = (2.0 * 30f64.to_radians().tan()) / f64::from(base.size[1]);
    for name in PATH_NAMES {
        let path = CameraPath::named(name).unwrap();
        let cameras = cameras(&path, &base, 400, 7);
        assert_eq!(cameras.len(), 400, "{name}");
        assert_eq!(cameras, self::cameras(&path, &base, 400, 7), "{name} is not repeatable");
        assert_eq!(cameras[0].eye, base.camera.eye, "{name}");
        assert!(heading(&cameras[0]).distance(heading(&base.camera)) < pixel, "{name}");
        for camera in &cameras {
            View { camera: *camera, ..base.clone() }.check().unwrap();
            assert_eq!((camera.near, camera.far), (cameras[0].near, cameras[0].far), "{name}");
            let forward = heading(camera);
            let deepest = (0..8).map(|i| {
                DVec3::select(
                    glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0),
                    DVec3::splat(10.0),
                    DVec3::splat(-10.0),
                )
            });
            assert!(deepest.into_iter().all(|c| (c - camera.eye).dot(forward) < camera.far), "{name}");
        }
    }
    assert!(CameraPath::named("jump").is_none());
}

#[test]
fn still_jitters_within_a_pixel() {
    let base = base([-3.0, 1.0, 5.0], [0.0, 0.0, 0.0]);
    let still = cameras(&CameraPath::Still, &base, 500, 1);
    assert_ne!(still, cameras(&CameraPath::Still, &base, 500, 2));
    let view = base.camera.view_from_world();
    let scale = f64::from(base.size[1]) / (2.0 * 30f64.to_radians().tan());
    let offsets: Vec<_> =
        still.iter().map(|camera| view * heading(camera)).map(|h| [h.x, h.y].map(|v| v / -h.z * scale)).collect();
    for axis in [0, 1] {
        let (low, high) = offsets.iter().fold((0f64, 0f64), |(l, h), o| (l.min(o[axis]), h.max(o[axis])));
        assert!(low < -0.45 && high > 0.45 && low >= -0.5 && high <= 0.5, "{low} to {high}");
    }
}

#[test]
fn walking_keeps_to_its_pace_and_turns_back_before_walls_and_at_the_end() {
    for (eye, target) in [([-1.0, 1.0, 0.5], [3.0, 0.0, 0.0]), ([-1.0, 1.0, 0.0], [-1.5, 1.0, 9.0])] {
        let base = base(eye, target);
        let walk = cameras(&CameraPath::Walk, &base, 3000, 1);
        let mut turned_back = false;
        for pair in walk.windows(2) {
            let step = pair[1].eye - pair[0].eye;
            assert!(step.length() == 0.0 || (step.length() - 0.01).abs() < 1e-9, "{step}");
            assert!(step.y.abs() < 1e-12);
            turned_back |= heading(&pair[1]).dot(heading(&walk[0])) < -0.5;
            // a twentieth of the viewing distance stays before the wall, and the scene ends at 10
            assert!(pair[1].eye.x < 1.81 && pair[1].eye.abs().max_element() <= 10.0, "{}", pair[1].eye);
        }
        assert!(turned_back);
    }
}

#[test]
fn a_walker_with_walls_all_around_turns_on_the_spot() {
    let (base, scene) = (base([0.0; 3], [0.0, 0.0, -1.0]), room());
    let around = Surroundings { scene: &scene, distance: 4.0, free: &|_, _| false };
    let walk = CameraPath::Walk.cameras(&base, &around, 0, 200, 1).unwrap();
    assert!(walk.iter().all(|camera| camera.eye == base.camera.eye));
    assert!(heading(&walk[60]).dot(heading(&walk[0])) < -0.999);
}

#[test]
fn turn_fly_cut_and_zoom_do_what_they_say() {
    let base = base([-3.0, 1.0, 5.0], [-3.0, 1.0, 0.0]);
    let turn = cameras(&CameraPath::Turn, &base, 481, 1);
    assert!((heading(&turn[0]).angle_between(heading(&turn[1])).to_degrees() - 0.75).abs() < 1e-9);
    assert!(heading(&turn[120]).distance(-DVec3::X) < 1e-9 && heading(&turn[480]).distance(-DVec3::Z) < 1e-9);

    let fly = cameras(&CameraPath::Fly, &base, 100, 1);
    let step = fly[1].eye - fly[0].eye;
    assert!((step - DVec3::new(0.0, 0.004, -0.04)).length() < 1e-12, "{step}");
    assert!(fly.iter().any(|camera| heading(camera).angle_between(heading(&fly[0])).to_degrees() > 20.0));

    let cut = cameras(&CameraPath::Cut, &base, 97, 1);
    assert_eq!(CameraPath::named("teleport"), Some(CameraPath::Cut));
    for (i, pair) in cut.windows(2).enumerate() {
        let angle = heading(&pair[0]).angle_between(heading(&pair[1])).to_degrees();
        if (i + 1) % 12 == 0 {
            assert!((59.0..121.0).contains(&angle), "frame {i}: {angle}");
        } else {
            assert!(angle < 1.0 && pair[0].eye == pair[1].eye, "frame {i}: {angle}");
        }
        assert!(pair[0].eye.x < 2.0);
    }
    assert_eq!(cut[5].eye, cut[53].eye);
    assert!(cut[0].eye != cut[12].eye && cut[12].eye.distance(cut[0].eye) <= 0.15 * 4.0);

    let zoom = cameras(&CameraPath::Zoom, &base, 101, 1);
    let fov = |frame: usize| zoom[frame].fov_y_deg / base.camera.fov_y_deg;
    for (frame, share) in [(0, 1.0), (25, 0.125f64.sqrt()), (50, 0.125), (75, 0.125f64.sqrt()), (100, 1.0)] {
        assert!((fov(frame) - share).abs() < 1e-12, "frame {frame}: {}", fov(frame));
    }
    assert_eq!(cameras(&CameraPath::Zoom, &base, 1, 1)[0].fov_y_deg, base.camera.fov_y_deg);
}

#[test]
fn cuts_from_beside_the_scene_go_around_it() {
    let base = base([-14.0, 5.0, 0.0], [0.0, 1.0, 0.0]);
    let cut = cameras(&CameraPath::Cut, &base, 48, 3);
    let pivot = base.camera.eye + 4.0 * heading(&base.camera);
    for camera in cut.iter().step_by(12) {
        let to_pivot = pivot - camera.eye;
        // moved by up to 0.15 of the viewing distance
        assert!((to_pivot.length() - 4.0).abs() < 0.61, "{to_pivot}");
        assert!(heading(camera).angle_between(to_pivot).to_degrees() < 9.0, "{to_pivot}");
    }
    let side = cut[12].eye - pivot;
    assert!((base.camera.eye - pivot).with_y(0.0).angle_between(side.with_y(0.0)).to_degrees() > 60.0);
}

#[test]
fn the_warm_up_stands_where_frame_0_does() {
    let (base, scene) = (base([0.0; 3], [0.0, 0.0, -1.0]), room());
    let around = Surroundings { scene: &scene, distance: 4.0, free: &|_, _| true };
    let turn = CameraPath::Turn.cameras(&base, &around, 3, 10, 1).unwrap();
    assert_eq!((turn.len(), turn[0], turn[2]), (13, turn[3], turn[3]));
    assert_ne!(turn[3], turn[4]);
    let still = CameraPath::Still.cameras(&base, &around, 3, 10, 1).unwrap();
    assert_ne!(still[0], still[1]);
}

fn keys(text: &str) -> CameraPath {
    CameraPath::Keys(PathFile::parse("p.json", text).unwrap())
}

#[test]
fn keys_are_joined_by_lines() {
    let base = base([-3.0, 1.0, 5.0], [0.0, 0.0, 0.0]);
    let path = keys(
        r#"{"keys":[{"frame":2,"eye":[-4,0,0],"target":[-4,0,-1]},{"frame":6,"eye":[0,0,0],"target":[0,4,-1],"fov_y_deg":20}]}"#,
    );
    let cameras = cameras(&path, &base, 9, 1);
    let at = |i: usize| (cameras[i].eye.to_array(), cameras[i].target.to_array(), cameras[i].fov_y_deg);
    assert_eq!(at(0), at(2));
    assert_eq!(at(2), ([-4.0, 0.0, 0.0], [-4.0, 0.0, -1.0], 60.0));
    assert_eq!(at(3), ([-3.0, 0.0, 0.0], [-3.0, 1.0, -1.0], 50.0));
    assert_eq!(at(6), ([0.0, 0.0, 0.0], [0.0, 4.0, -1.0], 20.0));
    assert_eq!(at(8), at(6));
}

#[test]
fn bad_path_files_are_refused() {
    let key = |frame: &str, eye: &str, target: &str, more: &str| {
        format!(r#"{{"frame":{frame},"eye":{eye},"target":{target}{more}}}"#)
    };
    let good = key("3", "[0,0,0]", "[0,0,-1]", "");
    let cases = [
        (String::new(), "is no camera path"),
        ("[]".to_owned(), "is no camera path"),
        ("{}".to_owned(), "missing field `keys`"),
        (r#"{"keys":[]}"#.to_owned(), "keys is empty, allowed is at least one key"),
        (format!(r#"{{"keys":[{}]}}"#, key("-1", "[0,0,0]", "[0,0,1]", "")), "-1"),
        (format!(r#"{{"keys":[{}]}}"#, key("0", "[0,0]", "[0,0,1]", "")), "invalid length 2"),
        (format!(r#"{{"keys":[{}]}}"#, key("0", "[0,0,0]", "[0,0,1]", r#","roll":1"#)), "unknown field `roll`"),
        (
            format!(r#"{{"keys":[{good},{}]}}"#, key("4", "[0,0,0]", "[0,0,0]", "")),
            "keys[1].target is [0.0, 0.0, 0.0], allowed",
        ),
        (
            format!(r#"{{"keys":[{}]}}"#, key("0", "[1e300,0,0]", "[0,0,1]", "")),
            "keys[0].eye is [1e300, 0.0, 0.0], allowed",
        ),
        (
            format!(r#"{{"keys":[{}]}}"#, key("0", "[0,0,0]", "[0,0,1]", r#","fov_y_deg":180"#)),
            "keys[0].fov_y_deg is 180, allowed",
        ),
        (format!(r#"{{"keys":[{good},{good}]}}"#), "keys[1].frame is 3, allowed is above the 3"),
    ];
    for (text, expected) in cases {
        let error = PathFile::parse("p.json", &text).unwrap_err().to_string();
        assert!(error.starts_with("p.json: ") && error.contains(expected) && !error.contains('\n'), "{error}");
    }
    let error = PathFile::read("no/such/path.json".as_ref()).unwrap_err().to_string();
    assert!(error.starts_with("no/such/path.json: cannot be read"), "{error}");
}

#[test]
fn a_frame_between_keys_that_cannot_be_drawn_is_named() {
    // half way the camera looks along its up direction
    let path =
        keys(r#"{"keys":[{"frame":0,"eye":[0,0,0],"target":[1,1,0]},{"frame":2,"eye":[0,0,0],"target":[-1,1,0]}]}"#);
    let (base, scene) = (base([0.0; 3], [0.0, 0.0, -1.0]), room());
    let around = Surroundings { scene: &scene, distance: 4.0, free: &|_, _| true };
    let error = path.cameras(&base, &around, 3, 3, 1).unwrap_err().to_string();
    assert!(error.starts_with("p.json: at frame 1 camera.up is") && error.contains("allowed is"), "{error}");
}

#[test]
fn committed_views_are_read() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/views");
    let mut read = [0, 0];
    for (count, folder) in read.iter_mut().zip([folder.clone(), folder.join("local")]) {
        let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        for file in files.filter(|file| file.extension().is_some_and(|extension| extension == "json")) {
            ViewFile::read(&file).unwrap();
            *count += 1;
        }
    }
    assert_eq!(read, [24, 8]);
}
