//! The program as a user meets it: files, tables, sentences and exit codes.
#![cfg(feature = "cli")]

use glam::DVec3;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use umbrage::methods::METHODS;
use umbrage::output::{ExrImage, read_exr};

const SIZE: [u32; 2] = [320, 180];

/// An empty folder of one test, removed at its end.
struct Place(PathBuf);

impl Place {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("umbrage-cli-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Without a display: no test opens a window.
    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage"));
        for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(name);
        }
        command.current_dir(&self.0).args(arguments.split_whitespace());
        command
    }

    fn good(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {stderr}");
        assert!(!stderr.contains("error:"), "{arguments}: {stderr}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs what must fail: one sentence with all of `words`, this exit code, and not a file more than before.
    fn bad(&self, arguments: &str, code: i32, words: &[&str]) {
        let before = names(&self.0);
        let output = self.run(arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        let errors: Vec<_> = stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
        assert_eq!(output.status.code(), Some(code), "{arguments}: {stderr}");
        assert!(matches!(errors[..], [line] if line.starts_with("error: ")), "{arguments}: {stderr}");
        assert!(!stderr.contains("defect") && !stderr.contains("panicked"), "{arguments}: {stderr}");
        for word in words {
            assert!(stderr.contains(word), "{arguments}: {word} is not in: {stderr}");
        }
        assert_eq!(names(&self.0), before, "{arguments}");
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&fs::read_to_string(self.0.join(name)).unwrap()).unwrap()
    }

    fn exr(&self, name: &str) -> ExrImage {
        read_exr(&self.0.join(name)).unwrap()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// All paths below `folder`, hidden ones too.
fn names(folder: &Path) -> Vec<PathBuf> {
    let mut list = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            list.extend(names(&path));
        }
        list.push(path);
    }
    list.sort();
    list
}

fn file_names(folder: &Path) -> Vec<String> {
    names(folder).iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

fn number(json: &Value, pointer: &str) -> f64 {
    json.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} is no number in {json}"))
}

fn ordered(spread: &Value, above_zero: bool) {
    let [min, median, max] = ["/min", "/median", "/max"].map(|key| number(spread, key));
    assert!(min <= median && median <= max && (min > 0.0 || !above_zero), "{spread}");
}

#[test]
fn usage_errors() {
    let place = Place::new("usage");
    let cases: &[(&str, &[&str])] = &[
        ("", &["command", "allowed"]),
        ("draw", &["'draw'"]),
        ("render", &["--out"]),
        ("render --out o --bogus", &["'--bogus'"]),
        ("render --out o --size 0x720", &["--size", "'0x720'", "1 to 16384"]),
        ("render --out o --size 1280x0", &["--size", "'1280x0'", "1 to 16384"]),
        ("render --out o --size 100000x100000", &["--size", "'100000x100000'", "1 to 16384"]),
        ("render --out o --size big", &["--size", "'big'", "allowed"]),
        ("render --out o --frames 0", &["--frames", "'0'"]),
        ("render --out o --device x", &["--device", "'x'"]),
        ("render --out o --method nope", &["--method", "'nope'", "rmsm"]),
        ("render --out o --method rmsm:nope=1", &["--method", "'nope'", "atlas_mib"]),
        ("render --out o --method rmsm:atlas_mib=x", &["'x'", "atlas_mib", "allowed"]),
        ("render --out o --method uniform:resolution=99999", &["'99999'", "resolution", "allowed"]),
        ("render --out o --method rmsm:level=odd", &["'odd'", "area", "min_length"]),
        ("render --out o --method csm:snap=true", &["snap=true", "fit=frustum"]),
        ("render --out o --method csm:partition=faces,blend=0.1", &["partition=faces and a blend", "partition=depth"]),
        ("render --out o --method csm:warp=auto,fit=frustum", &["has a warp", "warp=none with fit=frustum"]),
        ("render --out o --method uniform:bias=second,cull=back", &["bias=second", "cull", "allowed is none"]),
        ("render --out o --method csm:bias=slope,filter=pcf", &["bias=slope", "filter", "filter=hard"]),
        ("render --out o --method qvsm:tiles=3", &["'tiles'", "at least 4^start, 4"]),
        ("render --out o --method qvsm:levels=1,start=2", &["'start'", "at most levels, 1"]),
        ("render --out o --method fvsm:split=round", &["'round'", "rect or square"]),
        ("render --out o --method tiled:tiles=12", &["'12'", "8 or 16"]),
        ("render --out o --method lispsm:distance=near", &["'near'", "distance", "a number from 0.001"]),
        ("render --out o --method plane_optimal:plane=0/1/0", &["'0/1/0'", "plane", "auto or NX/NY/NZ/D"]),
        ("render --out o --method tsm:focus=0.8", &["'0.8'", "focus", "0.79"]),
        ("render --out o --method asm:sampling=3", &["'3'", "sampling", "8 or 16"]),
        ("render --out o --method asm:memory_mib=1", &["16 tiles", "starts with 16", "at most half"]),
        ("render --out o --method asm_gpu:cell=256,start=128", &["start=128", "cell=256", "at least the cell"]),
        ("render --out o --method silhouette:filter=pcf", &["'filter'", "resolution, fit, bias, depth_bias, cull"]),
        ("render --out o --method triangle_store:neighbours=5", &["'5'", "neighbours", "0 to 4"]),
        ("render --out o --method triangle_store:uncovered=dark", &["'dark'", "walk or depth or lit"]),
        ("render --out o --method rtw:edge=0.5", &["analysis=backward", "edge=1", "hybrid"]),
        ("render --out o --method rtw:view=false", &["view=false", "analysis=forward"]),
        ("render --out o --method rtw:subdivide=200", &["'200'", "subdivide", "from 0 to 100"]),
        ("render --out o --method rtw:bias=ids", &["unwarped maps", "bias=plane"]),
        ("render --out o --method raytraced:turned=yes", &["'yes'", "turned", "true or false"]),
        ("compare --out o", &["--methods"]),
        ("compare --out o --methods rmsm,", &["--methods"]),
        ("compare --out o --methods resolution=4096,rmsm", &["--methods", "'resolution=4096'"]),
        ("compare --out o --methods rmsm --sweep atlas_mib", &["--sweep", "'atlas_mib'", "allowed is KEY=A,B"]),
        ("compare --out o --methods rmsm --sweep atlas_mib=", &["--sweep", "'atlas_mib='", "allowed is KEY=A,B"]),
        ("compare --out o --methods rmsm --sweep atlas_mib=8,,16", &["--sweep", "empty", "allowed is KEY=A,B"]),
        ("compare --out o --methods rmsm --sweep atlas_mib=8,16,8", &["--sweep", "value 8 is there twice"]),
        ("compare --out o --methods rmsm --sweep atlas_mib=8..48", &["--sweep", "range is 8..48", "doubled"]),
        ("compare --out o --methods rmsm --sweep atlas_mib=8,x", &["'atlas_mib'", "'rmsm'", "'x'", "from 1 to 1024"]),
        ("compare --out o --methods rmsm,csm --sweep fog=1", &["rmsm, csm", "'fog'", "allowed is atlas_mib", "lambda"]),
        ("compare --out o --methods rmsm --sweep resolution=512", &["rmsm", "'resolution'", "allowed is atlas_mib"]),
        ("bench", &["--out"]),
        ("bench --out o --path spiral", &["--path", "'spiral'", "allowed is still, walk", ".json"]),
        ("bench --out o --frames 0", &["--frames", "'0'", "1..=100000"]),
        ("bench --out o --frames 100001", &["--frames", "'100001'", "1..=100000"]),
        ("bench --out o --sun-rate nan", &["--sun-rate", "'nan'", "allowed", "21600"]),
        ("bench --out o --sun-rate 1e999", &["--sun-rate", "'1e999'", "allowed"]),
        ("bench --out o --movers 65", &["--movers", "'65'", "0..=64"]),
        ("bench --out o --truth-every -1", &["'-1'"]),
        ("bench --out o --methods rmsm,nope", &["--methods", "'nope'"]),
        ("view --bogus", &["'--bogus'"]),
        ("view --size 0x0", &["--size", "'0x0'", "1 to 16384"]),
        ("view --methods rmsm,nope", &["--methods", "'nope'", "rmsm"]),
        ("view --methods rmsm:bias=9", &["--methods", "'9'", "bias", "allowed"]),
        ("view --present often", &["--present", "'often'", "fifo, mailbox or immediate"]),
        ("view --movers 65", &["--movers", "'65'", "0..=64"]),
    ];
    for (arguments, words) in cases {
        place.bad(arguments, 2, words);
    }
}

/// Where windows come from X or Wayland.
#[test]
#[cfg(all(unix, not(target_os = "macos")))]
fn a_window_needs_a_display() {
    let place = Place::new("display");
    place.bad("view --quiet --out deep/er/o", 1, &["no window can be opened", "DISPLAY", "umbrage render"]);
    for (name, value) in [("DISPLAY", ""), ("DISPLAY", ":4711"), ("DISPLAY", "nonsense"), ("WAYLAND_DISPLAY", "none-0")]
    {
        let output = place.command("view --quiet").env(name, value).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{name}={value}: {stderr}");
        assert!(stderr.starts_with("error: no window can be opened: "), "{name}={value}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{name}={value}: {stderr}");
        assert!(!stderr.contains(".rs"), "a place in a source: {stderr}");
    }
    assert!(names(&place.0).is_empty(), "{:?}", names(&place.0));
}

#[test]
fn input_that_cannot_be_used() {
    let place = Place::new("input");
    let write = |name: &str, text: &str| fs::write(place.0.join(name), text).unwrap();
    write("file", "");
    write("broken.json", "{");
    write("broken.glb", "glTF nonsense");
    write(
        "dark.json",
        r#"{"camera":{"eye":[0,1,5],"target":[0,0,0],"fov_y_deg":60},"lights":[{"type":"directional","direction":[0,0,0]}]}"#,
    );
    place.bad("render none.glb --out o", 1, &["none.glb"]);
    place.bad("render broken.glb --out deep/er/o", 1, &["broken.glb"]);
    place.bad("render --view none.json --out o", 1, &["none.json"]);
    place.bad("render --view broken.json --out o", 1, &["broken.json", "line 1"]);
    place.bad("compare --methods rmsm --view dark.json --out o", 1, &["dark.json", "lights[0].direction", "allowed"]);
    write("path.json", r#"{"keys":[{"frame":0,"eye":[0,0,0],"target":[0,0,0]}]}"#);
    place.bad("bench --path none.json --out o", 1, &["none.json", "cannot be read"]);
    place.bad("bench --path broken.json --out deep/er/o", 1, &["broken.json", "no camera path", "line 1"]);
    place.bad("bench --path path.json --out o", 1, &["path.json", "keys[0].target", "allowed"]);
    place.bad("bench none.glb --animate --out o", 1, &["none.glb"]);
    place.bad("view none.glb --out deep/er/o", 1, &["none.glb"]);
    place.bad("view --view broken.json", 1, &["broken.json", "line 1"]);
    place.bad("view --out file", 1, &["--out", "'file'", "allowed"]);
    place.bad("render --out file", 1, &["--out", "'file'", "allowed"]);
    place.bad("render --out file/below", 1, &["--out", "'file/below'"]);
    place.bad("render --out /proc/none", 1, &["--out", "'/proc/none'"]);
    place.bad("render --size 16x9 --device 99 --out o", 2, &["99"]);
}

#[test]
fn a_soft_light_is_refused_by_hard_methods() {
    let place = Place::new("soft");
    let light = r#"{"type":"directional","direction":[0,-1,0],"angular_diameter_deg":0.5}"#;
    let camera = r#"{"eye":[0,1,5],"target":[0,0,0],"fov_y_deg":60}"#;
    fs::write(place.0.join("v.json"), format!(r#"{{"camera":{camera},"lights":[{light}],"size":[16,9]}}"#)).unwrap();
    for method in METHODS.iter().map(|m| m.name).filter(|name| ["rmsm", "uniform"].contains(name)) {
        place.bad(&format!("render --view v.json --method {method} --out o"), 1, &[method]);
    }
}

#[test]
fn a_folder_in_a_files_place_leaves_nothing_behind() {
    let place = Place::new("place");
    fs::create_dir_all(place.0.join("o/image.png")).unwrap();
    place.bad("render --size 16x9 --frames 1 --out o", 1, &["--out", "image.png"]);
}

#[test]
fn help_has_examples() {
    let place = Place::new("help");
    for command in ["", "render", "compare", "bench", "methods", "info"] {
        let text = place.good(&format!("{command} --help"));
        assert!(text.contains("Example") && text.contains(&format!("umbrage {command}")), "{text}");
    }
}

#[test]
fn methods_lists_every_method_and_key() {
    let text = Place::new("methods").good("methods");
    for method in METHODS {
        assert!(text.contains(method.name) && text.contains(method.source), "{}", method.name);
        for key in method.parameters {
            assert!(text.contains(key.key) && text.contains(key.allowed), "{}:{}", method.name, key.key);
        }
    }
}

/// `docs/methods/keys.md`, as the program has it; `UPDATE_METHODS=1 cargo test --all-features --test cli keys` writes the file anew.
#[test]
fn documented_keys_are_those_of_the_program() {
    let mut text = "# Keys of every method\n\nWritten by a test from what the program takes (`umbrage methods` prints the same).\n".to_owned();
    for method in METHODS {
        text += &format!("\n## {}\n\n{}. Source: {}.\n", method.name, method.summary, method.source);
        if !method.parameters.is_empty() {
            text += "\n| key | default | allowed | meaning |\n|---|---|---|---|\n";
        }
        for p in method.parameters {
            text += &format!("| `{}` | {} | {} | {} |\n", p.key, p.default, p.allowed, p.meaning);
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/methods/keys.md");
    if std::env::var_os("UPDATE_METHODS").is_some() {
        fs::write(&path, &text).unwrap();
    }
    assert!(fs::read_to_string(&path).unwrap() == text, "UPDATE_METHODS=1 writes docs/methods/keys.md anew");
}

/// Each method has a page of its own or of its family, which `docs/methods/README.md` links, and a picture.
#[test]
fn every_method_has_its_page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/methods");
    let index = fs::read_to_string(folder.join("README.md")).unwrap();
    for name in METHODS.iter().map(|method| method.name) {
        let row = index.lines().find(|line| line.starts_with(&format!("| `{name}`")));
        let row = row.unwrap_or_else(|| panic!("docs/methods/README.md has no row of `{name}`"));
        let file = row.split(['(', ')']).find(|part| part.ends_with(".md")).expect("a link to a page");
        let page = fs::read_to_string(folder.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(page.contains(&format!("`{name}")) || page.starts_with(&format!("# {name}")), "{file} lacks `{name}`");
        let pictures: Vec<_> = page.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        let pictures: Vec<_> = pictures.iter().filter(|f| f.ends_with(".png") || f.ends_with(".svg")).collect();
        assert!(!pictures.is_empty(), "{file} has no picture");
        pictures.iter().for_each(|picture| assert!(folder.join(picture).is_file(), "{file}: {picture} is missing"));
    }
}

#[test]
fn info_lists_devices() {
    let text = Place::new("info").good("info");
    assert!(text.contains("lacks") || text.contains("mesa-vulkan-drivers"), "{text}");
}

#[test]
fn info_without_a_driver_says_how_to_get_one() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage"));
    let none = [("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")];
    let output = command.arg("info").envs(none).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stdout).contains("mesa-vulkan-drivers"));
}

#[test]
fn render_writes_what_it_promises() {
    let place = Place::new("render");
    let text = place.good("render --size 320x180 --truth --frames 2 --out deep/er/a");
    assert!(text.contains("mismatch") && text.contains("deep/er/a"), "{text}");
    let files = ["difference.png", "gbuffer.exr", "image.png", "stats.json", "view.json", "visibility.exr"];
    assert_eq!(file_names(&place.0.join("deep/er/a")), files);

    let visibility = place.exr("deep/er/a/visibility.exr");
    assert_eq!([visibility.width, visibility.height], SIZE);
    assert_eq!(visibility.channels.len(), 2);
    let v = visibility.channel("V").unwrap();
    assert_eq!(visibility.channel("V.0"), Some(v));
    assert!(v.iter().all(|v| (0.0..=1.0).contains(v)) && v.contains(&0.0) && v.contains(&1.0));

    let gbuffer = place.exr("deep/er/a/gbuffer.exr");
    assert_eq!(gbuffer.channels.len(), 7);
    let [px, py, pz] = ["P.X", "P.Y", "P.Z"].map(|name| gbuffer.channel(name).unwrap());
    let [nx, ny, nz] = ["N.X", "N.Y", "N.Z"].map(|name| gbuffer.channel(name).unwrap());
    let hit = gbuffer.channel("hit").unwrap();
    assert!(hit.contains(&1.0) && hit.iter().all(|h| [0.0, 1.0].contains(h)));
    let stats = place.json("deep/er/a/stats.json");
    let bound = |side: &str, axis: usize| number(&stats, &format!("/scene/bounds_{side}/{axis}")) as f32;
    for i in (0..hit.len()).filter(|&i| hit[i] == 1.0) {
        assert!(((nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i]) - 1.0).abs() < 1e-3);
        for (axis, p) in [px[i], py[i], pz[i]].into_iter().enumerate() {
            assert!(
                (bound("min", axis) - 0.05..=bound("max", axis) + 0.05).contains(&p),
                "pixel {i}, axis {axis}: {p}"
            );
        }
    }
    assert!((0..hit.len()).filter(|&i| hit[i] == 0.0).all(|i| v[i] == 1.0));

    for key in ["device", "driver", "method"] {
        assert!(stats[key].as_str().is_some_and(|text| !text.is_empty()), "{key}");
    }
    assert_eq!(number(&stats, "/frames"), 2.0);
    for time in ["prepass_ms", "ms", "wall_ms"] {
        ordered(&stats[time], true);
    }
    let stages = stats["stages"].as_object().unwrap();
    assert!(!stages.is_empty());
    stages.values().for_each(|stage| ordered(stage, false));
    for count in ["requested", "resident", "refused"] {
        let levels = stats["pages"]["levels"].as_array().unwrap();
        let sum: f64 = levels.iter().map(|level| number(level, &format!("/{count}"))).sum();
        assert_eq!(number(&stats, &format!("/pages/{count}")), sum, "{count}");
    }
    assert!(number(&stats, "/pages/resident") > 0.0 && number(&stats, "/effective_resolution") > 0.0);
    let purposes = stats["bytes"]["by_purpose"].as_object().unwrap();
    assert_eq!(number(&stats, "/bytes/total"), purposes.values().filter_map(Value::as_f64).sum::<f64>());
    assert!(number(&stats, "/scene/drawn_triangles") > 0.0 && stats["counters"].is_object());
    for metric in ["mismatch", "edge_error", "off_edge", "acne", "leak", "lost"] {
        assert!((0.0..100.0).contains(&number(&stats, &format!("/truth/{metric}"))), "{metric}");
    }
}

/// A view of the built-in scene from above with a sun, a spot light and a point light.
fn write_three_lights(place: &Place) {
    let view = r#"{
        "camera": {"eye": [-11, 9, -14], "target": [0, 1, 0], "fov_y_deg": 45},
        "lights": [
            {"type": "directional", "direction": [-0.5, -1, 0.3]},
            {"type": "spot", "position": [2, 7, -3], "direction": [-0.2, -1, 0.1], "inner_angle_deg": 25, "outer_angle_deg": 50, "range": 18},
            {"type": "point", "position": [-3, 4, 2], "range": 14.5}
        ],
        "size": [160, 90]
    }"#;
    fs::write(place.0.join("three.json"), view).unwrap();
}

#[test]
fn several_lights_are_rendered_and_measured_each_and_together() {
    let place = Place::new("lights");
    write_three_lights(&place);
    place.good("render --view three.json --method raytraced --truth --frames 1 --out a");
    let visibility = place.exr("a/visibility.exr");
    let names: Vec<_> = visibility.channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["V", "V.0", "V.1", "V.2"]);
    assert_eq!(visibility.channel("V"), visibility.channel("V.0"));
    for light in ["V.0", "V.1", "V.2"] {
        let lit = visibility.channel(light).unwrap().iter().filter(|v| **v == 1.0).count();
        assert!(lit > 500 && lit < 160 * 90 - 500, "{light}: {lit}");
    }
    let (written, given) = (place.json("a/view.json"), place.json("three.json"));
    for (light, pointer) in [(0, "/direction/0"), (1, "/outer_angle_deg"), (1, "/range"), (2, "/position/1")] {
        let of = |view: &Value| number(view, &format!("/lights/{light}{pointer}"));
        assert_eq!(of(&written), of(&given), "{light}{pointer}");
    }
    let stats = place.json("a/stats.json");
    let decided = |k: usize| number(&stats, &format!("/truth/lights/{k}/decided_pixels"));
    assert_eq!(number(&stats, "/truth/decided_pixels"), decided(0) + decided(1) + decided(2));
    assert_eq!(number(&stats, "/truth/mismatch"), 0.0);

    let text = place.good("compare --view a/view.json --methods raytraced,raytraced:turned=true --rounds 1 --out b");
    assert!(text.contains("light  mismatch %"), "{text}");
    let rows = &place.json("b/compare.json")["rows"];
    assert!(number(&rows[1], "/mismatch") < 0.02, "the floor: {}", rows[1]);
    let row = &rows[0];
    assert_eq!(row["lights"], stats["truth"]["lights"]);
    assert_eq!(row["edge_pixels"], stats["truth"]["edge_pixels"]);

    place.good("bench --view three.json --path turn --methods raytraced --frames 2 --truth-every 1 --out c");
    let frame = &place.json("c/bench.json")["runs"][0]["frames"][1];
    assert_eq!(frame["errors"]["lights"].as_array().map(Vec::len), Some(3));
    assert_eq!((number(frame, "/errors/mismatch"), number(frame, "/crawl/crawl")), (0.0, 0.0));
    place.good("compare --view three.json --methods rmsm,rmsm:exact=true,uniform:resolution=1024 --rounds 1 --out e");
    let rows = place.json("e/compare.json");
    let mismatch = |i: usize| number(&rows, &format!("/rows/{i}/mismatch"));
    assert!(mismatch(1) <= mismatch(0) && mismatch(0) < mismatch(2), "{} {} {}", mismatch(0), mismatch(1), mismatch(2));
    place.bad("render --view three.json --method csm --out d", 1, &["'csm'", "3"]);
}

/// Writes a scene and a view: a ground of 10 km, a tower 250 m high that ends at z = 3050, `more` boxes (node transforms of
/// one that spans -1 to 1 in x and z and 0 to 1 in y), and an eye 2 cm above the ground, 2 km from the tower in its shadow's
/// side edge. The sun shines along x, 1 down in 10.
fn write_huge(place: &Place, more: &[Value]) {
    let corner = |i: usize, y: f32| [if i & 1 == 0 { -1.0 } else { 1.0 }, y, if i & 2 == 0 { -1.0 } else { 1.0f32 }];
    let ring = [[0, 1, 5, 0, 5, 4], [1, 3, 7, 1, 7, 5], [3, 2, 6, 3, 6, 7], [2, 0, 4, 2, 4, 6], [4, 5, 7, 4, 7, 6]];
    let sides = ring.as_flattened().iter().map(|&i| corner(i & 3, if i & 4 == 0 { 0.0 } else { 1.0 }));
    let positions: Vec<_> = [0, 2, 3, 0, 3, 1].iter().map(|&i| corner(i, 0.0)).chain(sides).collect();
    let bytes: Vec<u8> = positions.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(place.0.join("huge.bin"), &bytes).unwrap();
    let accessor = |first: usize, count: usize| {
        serde_json::json!({ "bufferView": 0, "byteOffset": 12 * first, "componentType": 5126, "count": count,
            "type": "VEC3", "min": [-1, 0, -1], "max": [1, 1, 1] })
    };
    let mut nodes = vec![
        serde_json::json!({ "mesh": 0, "scale": [5000, 1, 5000] }),
        serde_json::json!({ "mesh": 1, "scale": [10, 250, 50], "translation": [-1700, 0, 3000] }),
    ];
    nodes.extend_from_slice(more);
    let gltf = serde_json::json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] },
                   { "primitives": [{ "attributes": { "POSITION": 1 } }] }],
        "accessors": [accessor(0, 6), accessor(6, 30)],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "buffers": [{ "uri": "huge.bin", "byteLength": bytes.len() }],
    });
    fs::write(place.0.join("huge.gltf"), gltf.to_string()).unwrap();
    let view = r#"{
        "camera": {"eye": [300.25, 0.02, 3050.02], "target": [300.35, 0, 3050.0], "fov_y_deg": 60, "near": 0.001, "far": 20000},
        "lights": [{"type": "directional", "direction": [10, -1, 0]},
                   {"type": "point", "position": [300.3, 0.05, 3050], "range": 0.3}], "size": [160, 90]
    }"#;
    fs::write(place.0.join("v.json"), view).unwrap();
}

#[test]
fn truth_two_centimetres_above_ten_kilometres() {
    let place = Place::new("huge");
    write_huge(&place, &[]);
    place.good("render huge.gltf --view v.json --method raytraced --truth --frames 1 --out a");
    let (visibility, gbuffer) = (place.exr("a/visibility.exr"), place.exr("a/gbuffer.exr"));
    let [sun, lamp] = ["V.0", "V.1"].map(|name| visibility.channel(name).unwrap());
    let [x, y, z, hit] = ["P.X", "P.Y", "P.Z", "hit"].map(|name| gbuffer.channel(name).unwrap());
    let (mut lit, mut dark) = (0, 0);
    // single precision holds x and z to a quarter of a millimetre
    for i in (0..hit.len()).filter(|&i| hit[i] == 1.0 && (x[i] - 300.25).hypot(z[i] - 3050.02) < 1.0) {
        assert!(y[i].abs() < 1e-7, "pixel {i} lies {} above the ground", y[i]);
        let from_lamp = DVec3::new(f64::from(x[i]) - 300.3, 0.05, f64::from(z[i]) - 3050.0).length();
        if (from_lamp - 0.3).abs() > 1e-3 {
            assert_eq!(lamp[i], f32::from(u8::from(from_lamp < 0.3)), "pixel {i}, {from_lamp} from the lamp");
        }
        if (z[i] - 3050.0).abs() > 5e-4 {
            assert_eq!(sun[i], f32::from(u8::from(z[i] > 3050.0)), "pixel {i} at {}, {}", x[i], z[i]);
            *(if sun[i] == 1.0 { &mut lit } else { &mut dark }) += 1;
        }
    }
    assert!(lit > 500 && dark > 500, "{lit} lit, {dark} dark");
    let stats = place.json("a/stats.json");
    assert!(number(&stats, "/truth/lights/0/decided_pixels") > f64::from(lit + dark) * 0.95);
}

/// Blades of grass, less than a millimetre wide, stand before the eye.
#[test]
fn exact_two_centimetres_above_ten_kilometres() {
    let place = Place::new("grass");
    let share = |i: u32, by: f64| (f64::from(i) * by).fract();
    let blade = |i: u32| {
        let [height, x, z] = [0.618_034, 0.754_878, 0.569_840].map(|by| share(i, by));
        serde_json::json!({ "mesh": 1, "scale": [0.0002, 0.002 + 0.01 * height, 0.0004],
            "translation": [300.25 + 0.15 * x, 0, 3049.95 + 0.08 * z] })
    };
    write_huge(&place, &(0..40).map(blade).collect::<Vec<_>>());
    let queries = place.good("info").contains("ray queries: yes");
    for rays in if queries { &["tree", "query"][..] } else { &["tree"] } {
        let methods = format!("rmsm:exact=true,rays={rays},raytraced:turned=true");
        place.good(&format!("compare huge.gltf --view v.json --methods {methods} --rounds 1 --out {rays}"));
        let rows = &place.json(&format!("{rays}/compare.json"))["rows"];
        let share = |row: usize, metric: &str| number(&rows[row], &format!("/{metric}"));
        let (found, floor) = (share(0, "mismatch"), share(1, "mismatch"));
        println!("{rays}: {found}, the floor is {floor}");
        assert_eq!(share(0, "off_edge"), 0.0, "{}", rows[0]);
        assert!(found < floor + 0.02, "the floor is {floor}: {}", rows[0]);
        assert!(share(0, "edge_pixels") > 500.0, "{}", rows[0]);
    }
    if !queries {
        place.bad("render --method rmsm:exact=true,rays=query --out b", 1, &["rays=query", "ray queries", "device"]);
    }
}

/// The tower's side edge and its top edge cast their shadows from 2 km, under suns that no axis of the world is parallel to.
#[test]
fn fine_pages_two_centimetres_above_ten_kilometres() {
    let place = Place::new("fine");
    write_huge(&place, &[]);
    let side = 3050.0 + 1990.3 * 0.001_13;
    for (z, direction) in [(side, [10.0, -1.0, 0.0113]), (3040.0, [1990.3, -250.0, 0.37])] {
        let mut view = place.json("v.json");
        view["camera"]["eye"] = serde_json::json!([300.25, 0.015, z + 0.02]);
        view["camera"]["target"] = serde_json::json!([300.35, 0, z]);
        view["lights"] = serde_json::json!([{ "type": "directional", "direction": direction }]);
        fs::write(place.0.join("far.json"), view.to_string()).unwrap();
        place.good("compare huge.gltf --view far.json --methods rmsm:virtual=30,rmsm --rounds 1 --out a");
        let rows = &place.json("a/compare.json")["rows"];
        assert!(number(&rows[0], "/mismatch") < 0.5 && number(&rows[0], "/off_edge") == 0.0, "{}", rows[0]);
        assert!(number(&rows[0], "/edge_pixels") > 100.0, "{}", rows[0]);
        // so few, as lines through coarse texels come close to straight edges
        assert!(number(&rows[1], "/off_edge") > 0.1, "coarse pages do as well: {}", rows[1]);
    }
}

#[test]
fn the_written_view_gives_the_same_picture() {
    let place = Place::new("again");
    place.good("render --size 320x180 --frames 1 --quiet --out a");
    place.good("render --view a/view.json --frames 1 --quiet --out b");
    assert_eq!(place.exr("a/visibility.exr"), place.exr("b/visibility.exr"));
    assert_eq!(place.exr("a/gbuffer.exr"), place.exr("b/gbuffer.exr"));
    assert_eq!(place.json("a/view.json"), place.json("b/view.json"));
    let view = place.json("a/view.json");
    assert_eq!(view["size"], serde_json::json!(SIZE));
    for key in ["eye", "target", "up", "fov_y_deg", "near", "far"] {
        assert!(!view["camera"][key].is_null(), "{key}");
    }
    place.good("render --view a/view.json --size 64x36 --frames 1 --quiet --out c");
    assert_eq!(place.json("c/view.json")["size"], serde_json::json!([64, 36]));
}

#[test]
fn debug_pictures_on_request() {
    let place = Place::new("debug");
    place.good("render --size 320x180 --frames 1 --debug --out a");
    let debug = file_names(&place.0.join("a")).into_iter().filter(|name| name.starts_with("debug_"));
    assert!(debug.count() >= 4 + 6);
    // what they show, in figures
    place.good("compare --size 320x180 --methods rmsm,uniform:resolution=256,raytraced --rounds 1 --out b");
    let rows = place.json("b/compare.json")["rows"].as_array().unwrap().clone();
    let sampling = |row: usize, figure: &str| rows[row]["sampling"][0][figure].as_f64().unwrap();
    assert!(sampling(0, "undersampled") < sampling(1, "undersampled"), "{rows:?}");
    assert!(sampling(1, "storage_factor") > 1.0 && rows[1]["sampling"][0]["t"]["p95"].as_f64().unwrap() > 1.0);
    assert!(rows[2].get("sampling").is_none(), "{rows:?}");
    assert_eq!(place.json("a/stats.json")["sampling"].as_array().unwrap().len(), 1);
}

#[test]
fn quiet_is_silent() {
    let place = Place::new("quiet");
    for command in ["render", "compare --methods raytraced --rounds 1"] {
        let output = place.run(&format!("{command} --size 16x9 --quiet --out o"));
        assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0), "{command}");
    }
}

#[test]
fn compare_writes_what_it_promises() {
    let place = Place::new("compare");
    let typed = ["rmsm", "uniform:fit=samples,resolution=2048", "raytraced", "rmsm:level=min_length"];
    let text = place.good(&format!("compare --size 320x180 --rounds 2 --methods {} --out a", typed.join(",")));
    for word in typed.iter().chain(&["ratio", "MiB", "mismatch", "edge_error", "off_edge", "lost"]) {
        assert!(text.contains(word), "{word} is not in: {text}");
    }
    assert_eq!(file_names(&place.0.join("a")), ["compare.json", "comparison.png", "report.html", "view.json"]);
    let json = place.json("a/compare.json");
    assert_eq!(json["scene"], "builtin");
    assert_eq!(json["view"], place.json("a/view.json"));
    assert!(json["device"].is_string() && json["driver"].is_string());
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.iter().map(|row| row["method"].as_str().unwrap()).collect::<Vec<_>>(), typed);
    let first = number(&rows[0], "/ms/median");
    for row in rows {
        ordered(&row["ms"], true);
        assert!((number(row, "/ratio") - number(row, "/ms/median") / first).abs() < 1e-9);
        for key in ["bytes", "cold_ms", "wall_ms"] {
            assert!(number(row, &format!("/{key}")) > 0.0, "{key}");
        }
        for metric in ["mismatch", "edge_error", "off_edge", "acne", "leak", "lost"] {
            assert!((0.0..100.0).contains(&number(row, &format!("/{metric}"))), "{metric}");
        }
        assert!(number(row, "/prepass_ms") >= 0.0 && row["stages"].is_object());
    }
    assert_eq!(number(&rows[2], "/mismatch"), 0.0);
}

#[test]
fn a_sweep_runs_every_value_and_plots_them() {
    let place = Place::new("sweep");
    let methods = "rmsm:atlas_mib=8,csm:lambda=0.5,resolution=4096,uniform";
    let text =
        place.good(&format!("compare --size 64x36 --rounds 2 --methods {methods} --sweep resolution=64..256 --out a"));
    let labels = ["rmsm:atlas_mib=8", "csm:lambda=0.5", "uniform"];
    let files = ["error_bytes", "error_time", "error_value", "time_value"].map(|name| format!("sweep_{name}.svg"));
    let all = ["compare.json", "comparison.png", "report.html"].map(str::to_owned).into_iter().chain(files.clone());
    assert_eq!(file_names(&place.0.join("a")), all.chain(["view.json".to_owned()]).collect::<Vec<_>>());
    for name in files {
        let svg = fs::read_to_string(place.0.join("a").join(&name)).unwrap();
        assert!(svg.trim_end().ends_with("</svg>") && svg.contains("resolution"), "{name}");
        assert!(labels.iter().all(|label| svg.contains(label)), "{name}");
    }
    let json = place.json("a/compare.json");
    assert_eq!(json["sweep"], serde_json::json!({ "key": "resolution", "values": ["64", "128", "256"] }));
    let rows = json["rows"].as_array().unwrap();
    let want = labels.iter().flat_map(|&label| match label {
        "rmsm:atlas_mib=8" => vec![(label.to_owned(), Value::Null, Value::Null)],
        _ => {
            let join = if label.contains(':') { "," } else { ":" };
            [64, 128, 256]
                .map(|value| (format!("{label}{join}resolution={value}"), label.into(), f64::from(value).into()))
                .to_vec()
        }
    });
    let found =
        rows.iter().map(|row| (row["method"].as_str().unwrap().to_owned(), row["of"].clone(), row["value"].clone()));
    assert_eq!(found.collect::<Vec<_>>(), want.collect::<Vec<_>>());
    assert!(rows.iter().all(|row| text.contains(row["method"].as_str().unwrap())), "{text}");
    // maps of 16 times the texels, and smaller errors
    assert!(number(&rows[1], "/bytes") < number(&rows[3], "/bytes"));
    assert!(number(&rows[1], "/mismatch") > number(&rows[3], "/mismatch"));
}

/// The page of a comparison, which loads nothing.
fn report(place: &Place, name: &str) -> String {
    let page = fs::read_to_string(place.0.join(name)).unwrap();
    assert!(
        !page.contains("http://") && !page.contains("https://") && !page.contains("url("),
        "{name} loads something"
    );
    let sources = page.matches("src=").count() + page.matches("href=").count();
    assert_eq!(page.matches("src=\"data:image/png;base64,iVBORw0KGgo").count(), sources, "{name} loads something");
    page
}

#[test]
fn the_report_holds_all_that_it_shows() {
    let place = Place::new("report");
    let methods = ["rmsm:atlas_mib=8", "uniform:resolution=64", "raytraced"];
    place.good(&format!("compare --size 64x36 --rounds 1 --methods {} --out a", methods.join(",")));
    let page = report(&place, "a/report.html");
    let pictures: Vec<_> = page.lines().filter(|line| line.starts_with("<img class=\"picture\"")).collect();
    let bytes = |i: usize| pictures[i].split_once("src=").unwrap().1;
    assert_eq!(pictures.len(), 4);
    assert!(bytes(0) == bytes(3) && bytes(0) != bytes(2), "the first is not ray traced");
    assert_eq!(page.matches("<img class=\"difference\"").count(), 3);
    for method in METHODS.iter().filter(|m| ["rmsm", "uniform", "raytraced"].contains(&m.name)) {
        assert!(page.contains(method.summary) && page.contains(method.source), "{}", method.name);
    }
    let json = place.json("a/compare.json");
    for (row, method) in json["rows"].as_array().unwrap().iter().zip(methods) {
        assert!(page.contains(&format!("<code>{}</code>", method.replace(':', ":<wbr>"))), "{method}");
        for key in ["/ms/median", "/ratio", "/mismatch", "/edge_error", "/off_edge", "/lost"] {
            let value = number(row, key);
            assert!(page.contains(&format!("<td data-value=\"{value}\">")), "{method}: {key} {value}");
        }
    }
    let command = format!("umbrage compare --size 64x36 --rounds 1 --methods {} --out a", methods.join(","));
    for text in
        [&command, json["device"].as_str().unwrap(), json["driver"].as_str().unwrap(), env!("CARGO_PKG_VERSION")]
    {
        assert!(page.contains(text), "{text}");
    }
    assert!(page.contains("&quot;fov_y_deg&quot;: ") && page.contains("64 x 36 pixels, 1 directional light."));
}

#[test]
fn the_report_of_a_sweep_shows_few_pictures_and_all_plots() {
    let place = Place::new("report-sweep");
    write_three_lights(&place);
    let sweep = "--sweep depth_bias=1,1.5,2,2.5,3,3.5,4,4.5,5";
    place.good(&format!(
        "compare --view three.json --size 32x18 --rounds 1 --coverage 2 --methods uniform:resolution=64 {sweep} --out a"
    ));
    let page = report(&place, "a/report.html");
    assert_eq!(page.matches("<img class=\"difference\"").count(), 8);
    assert!(page.contains("Of the 9 runs 8 are shown") && page.contains("depth_bias swept over 1, 1.5, 2,"));
    let plots = file_names(&place.0.join("a")).iter().filter(|name| name.ends_with(".svg")).count();
    assert_eq!((plots, page.matches("</svg>").count()), (3, 3));
    assert!(page.contains("Errors by light") && page.contains("coverage %") && page.contains("on edges %"));
}

/// A file's name is text in the report, whatever it is.
#[test]
#[cfg(unix)]
fn the_report_shows_a_nasty_name_as_it_is() {
    let place = Place::new("nasty");
    write_huge(&place, &[]);
    let name = "<img src=x onerror=alert(1)>.gltf";
    fs::rename(place.0.join("huge.gltf"), place.0.join(name)).unwrap();
    let output =
        place.command("compare --view v.json --size 16x9 --methods raytraced --rounds 1 --out a").arg(name).output();
    assert_eq!(output.unwrap().status.code(), Some(0));
    let page = fs::read_to_string(place.0.join("a/report.html")).unwrap();
    assert!(!page.contains("<img src"), "{name} became a part of the page");
    let shown = "&lt;img src=x onerror=alert(1)&gt;.gltf";
    assert!(page.contains(&format!("<h1>Shadows of {shown}</h1>")));
    assert!(page.contains(&format!("--out a &#39;{shown}&#39;</pre>")));
}

#[test]
fn a_sweep_of_words_has_no_plots() {
    let place = Place::new("words");
    place.good("compare --size 16x9 --rounds 1 --methods rmsm --sweep level=area,min_length --quiet --out a");
    assert_eq!(file_names(&place.0.join("a")), ["compare.json", "comparison.png", "report.html", "view.json"]);
    let rows = &place.json("a/compare.json")["rows"];
    assert_eq!([&rows[0]["value"], &rows[1]["value"]], ["area", "min_length"]);
    place.bad("compare --methods rmsm:atlas_mib=8 --sweep page=64..512 --quiet --out b", 2, &["page=512", "allows"]);
}

#[test]
fn bench_writes_what_it_promises() {
    let place = Place::new("bench");
    let typed = ["uniform:resolution=512,fit=samples", "rmsm:atlas_mib=8", "rmsm:atlas_mib=8,cache=off"];
    let text = place.good(&format!(
        "bench --size 64x36 --path turn --frames 4 --movers 1 --sun-rate 5 --truth-every 1 --methods {} --out a",
        typed.join(",")
    ));
    for word in typed.iter().chain(&["p95", "worst", "ratio", "/uniform", "/cold", "drawn", "MiB", "mismatch", "crawl"])
    {
        assert!(text.contains(word), "{word} is not in: {text}");
    }
    let files = ["bench.csv", "bench.json", "error.svg", "pages.svg", "time.svg", "view.json"];
    assert_eq!(file_names(&place.0.join("a")), files);
    let json = place.json("a/bench.json");
    assert_eq!((&json["scene"], &json["path"]), (&"builtin".into(), &"turn".into()));
    assert!(json["device"].is_string() && json["driver"].is_string());
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.iter().map(|run| run["method"].as_str().unwrap()).collect::<Vec<_>>(), typed);
    for run in runs {
        let [median, p95, worst] = ["median", "p95", "worst"].map(|key| number(run, &format!("/ms/{key}")));
        assert!(0.0 < median && median <= p95 && p95 <= worst);
        let ratio = |key: &str, time: &str| number(run, key) - number(run, time) / number(&runs[0], time);
        assert!(ratio("/ratio_median", "/ms/median").abs() < 1e-9 && ratio("/ratio_p95", "/ms/p95").abs() < 1e-9);
        assert!((number(run, "/ratio_uniform") - number(run, "/ratio_median")).abs() < 1e-9);
        assert!((number(run, "/ratio_cold") - median / number(&runs[2], "/ms/median")).abs() < 1e-9);
        let frames = run["frames"].as_array().unwrap();
        assert_eq!(frames.iter().map(|f| number(f, "/frame")).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
        let times: Vec<f64> = frames.iter().map(|f| number(f, "/ms")).collect();
        assert_eq!(times.iter().copied().fold(0.0, f64::max), worst);
        assert!(frames.iter().all(|f| f["stages"].is_object() && f["errors"].is_object()));
        assert!(frames[0].get("crawl").is_none() && frames[1..].iter().all(|f| f["crawl"].is_object()));
        assert!(number(run, "/crawl/crawl") <= number(run, "/crawl/flips"));
    }
    assert!(runs[0]["frames"][0]["counters"].get("pages_drawn").is_none());
    assert!(number(&runs[2], "/pages/pages_drawn/median") > 0.0);
    assert!((0..4).all(|k| number(&runs[2], &format!("/frames/{k}/counters/pages_drawn")) > 0.0));

    let csv = fs::read_to_string(place.0.join("a/bench.csv")).unwrap();
    let lines: Vec<_> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + 4 * typed.len());
    assert!(lines[0].starts_with("frame,time_s,method,ms,") && lines[0].ends_with("flips,reference_flips,crawl"));
    for column in
        ["lookup_ms", "pages_requested", "pages_hit", "pages_drawn", "pages_deferred", "pages_evicted", "bytes"]
    {
        assert!(lines[0].split(',').any(|name| name == column), "{column} is not in: {}", lines[0]);
    }
    for line in &lines[1..] {
        // commas in quotes belong to the method
        let commas = line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>();
        assert_eq!(commas, lines[0].matches(',').count(), "{line}");
    }
    assert!(lines[4].starts_with("1,0.016667,\"uniform:resolution=512,fit=samples\","), "{}", lines[4]);
    for chart in ["time", "pages", "error"] {
        let svg = fs::read_to_string(place.0.join(format!("a/{chart}.svg"))).unwrap();
        assert!(svg.contains("<svg") && svg.trim_end().ends_with("</svg>") && svg.contains("frame"), "{chart}");
    }
}

#[test]
fn bench_without_truth_pages_or_motion_leaves_their_columns_empty() {
    let place = Place::new("bench-plain");
    let keys =
        r#"{"keys":[{"frame":0,"eye":[-11,11,-16],"target":[0,2,0]},{"frame":2,"eye":[-9,9,-13],"target":[0,2,0]}]}"#;
    fs::write(place.0.join("keys.json"), keys).unwrap();
    let text = place.good("bench --size 64x36 --path keys.json --frames 2 --methods uniform:resolution=256 --out a");
    assert!(text.contains("keys.json") && !text.contains("mismatch") && !text.contains("/cold"), "{text}");
    assert_eq!(file_names(&place.0.join("a")), ["bench.csv", "bench.json", "time.svg", "view.json"]);
    let run = &place.json("a/bench.json")["runs"][0];
    for key in ["crawl", "mismatch", "ratio_cold"] {
        assert!(run.get(key).is_none(), "{key}");
    }
    let csv = fs::read_to_string(place.0.join("a/bench.csv")).unwrap();
    assert!(csv.lines().skip(1).all(|line| line.ends_with(",,,,,,,,,")), "{csv}");
}
