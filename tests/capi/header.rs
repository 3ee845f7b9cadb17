//! `include/umbrage.h` is what cbindgen makes of the sources.
//! `UMBRAGE_HEADER=write cargo test --features capi --test capi header` writes it.

use std::path::{Path, PathBuf};

/// Everything that the header shows.
fn sources(root: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(root.join("src/capi")).unwrap().map(|f| f.unwrap().path()).collect();
    // cbindgen follows the modules of the one, and the header has the other from Vulkan's
    files.retain(|file| !file.ends_with("mod.rs") && !file.ends_with("vulkan.rs"));
    files.sort();
    files.extend(["src/casters.rs", "src/gpu/structs.rs"].map(|file| root.join(file)));
    files
}

fn made() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let builder = sources(root).into_iter().fold(cbindgen::Builder::new(), |builder, file| builder.with_src(file));
    let mut text = Vec::new();
    builder.with_config(config).generate().unwrap().write(&mut text);
    // links between Rust items, a heading
    let text = String::from_utf8(text).unwrap().replace("[`", "").replace("`]", "");
    text.replace("// # Safety", "// What the caller sees to:")
}

#[test]
fn the_committed_header_is_that_of_the_sources() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/umbrage.h");
    let made = made();
    if std::env::var_os("UMBRAGE_HEADER").is_some_and(|v| v == "write") {
        std::fs::write(&path, &made).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = made.lines().zip(committed.lines()).position(|(a, b)| a != b);
    assert!(made == committed, "line {differs:?} of include/umbrage.h differs; see the top of this file");
}

#[test]
fn every_function_is_in_the_header_and_every_body_is_guarded() {
    let made = made();
    let mut functions = 0;
    // these hand out a number or a pointer and call nothing that could fail
    let plain = [
        "umbrage_encode_normal",
        "umbrage_last_error",
        "umbrage_least_pairs",
        "umbrage_table_bytes",
        "umbrage_light_slot",
        "umbrage_version",
    ];
    for file in sources(Path::new(env!("CARGO_MANIFEST_DIR"))) {
        let text = std::fs::read_to_string(&file).unwrap();
        for part in text.split("extern \"C\" fn ").skip(1) {
            let name = part.split('(').next().unwrap();
            assert!(made.contains(&format!("{name}(")), "{name} is not in the header");
            let body = part.split_once(" {\n").unwrap().1.trim_start();
            let body = body.lines().find(|line| !line.trim_start().starts_with("//")).unwrap().trim_start();
            assert!(body.starts_with("guard(") || plain.contains(&name), "{name} begins with {body}");
            functions += 1;
        }
    }
    assert!(functions > 20, "{functions}");
}
