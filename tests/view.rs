//! View files: what is read, what is filled in, what is refused.
#![cfg(feature = "lab")]

use glam::DVec3;
use serde_json::{Value, json};
use umbrage::Light;
use umbrage::lab::View;
use umbrage::scene::{self, Scene};
use umbrage::view::{DEFAULT_SIZE, ViewFile};

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
    let cases = [
        ("/lights/0/direction", json!([0, 0, 0]), "lights[0].direction is [0.0, 0.0, 0.0]"),
        ("/lights/0/direction", json!([1e-320, 0, 0]), "lights[0].direction is"),
        ("/lights/0/direction", json!([1e300, 0, 0]), "lights[0].direction is"),
        ("/lights/0/angular_diameter_deg", json!(-1), "lights[0].angular_diameter_deg is -1"),
        ("/lights/0/angular_diameter_deg", json!(180), "lights[0].angular_diameter_deg is 180"),
        ("/lights/0", json!({ "type": "area", "polygon": [[0, 0, 0], [1, 0, 0]] }), "lights[0].polygon is 2 corners"),
        ("/lights", json!([]), "lights is empty"),
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
        (with("/lights/0/type", json!("spot")), "unknown variant `spot`"),
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
