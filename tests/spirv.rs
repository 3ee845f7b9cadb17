//! The committed SPIR-V belongs to the sources beside it, and the reader that other tests rely on can fail.

#[path = "support/spirv.rs"]
mod spirv;

use spirv::{
    Module, Resource, Shader, Struct, assert_layout, check_layout, committed, files, instructions, path, read,
    resources,
};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::mem::offset_of;

/// The sum that POSIX cksum(1) prints: CRC-32 over the bytes and then over their number, low byte first.
fn cksum(bytes: &[u8]) -> u32 {
    let length = std::iter::successors(Some(bytes.len()), |rest| Some(rest >> 8)).take_while(|&rest| rest != 0);
    !bytes.iter().copied().chain(length.map(|rest| rest as u8)).fold(0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(byte) << 24, |c, _| (c << 1) ^ if c >> 31 == 1 { 0x04c1_1db7 } else { 0 })
    })
}

/// What MANIFEST says: files with sums and sizes, modules with their sources.
struct Manifest {
    sums: BTreeMap<String, (u32, usize)>,
    modules: BTreeMap<String, Vec<String>>,
}

impl Manifest {
    fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        assert!(lines.next().is_some_and(|l| l.starts_with("glslang ")), "line 1 is the compiler");
        let flags = lines.next().expect("line 2 is the flags");
        assert!(flags.contains("--target-env vulkan1.2") && !flags.contains(" -g"), "{flags}");
        let (mut sums, mut modules) = (BTreeMap::new(), BTreeMap::new());
        for line in lines {
            let (file, sources) = line.split_once(": ").map_or((line, None), |(f, s)| (f, Some(s)));
            let [sum, size, name] = file.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
            sums.insert(name.to_owned(), (sum.parse().unwrap(), size.parse().unwrap()));
            if let Some(sources) = sources {
                modules.insert(name.to_owned(), sources.split(' ').map(str::to_owned).collect());
            }
        }
        Self { sums, modules }
    }
}

#[test]
fn cksum_is_the_posix_one() {
    // printf '' | cksum; printf 123456789 | cksum; head -c 300 /dev/zero | cksum
    assert_eq!(cksum(b""), 4_294_967_295);
    assert_eq!(cksum(b"123456789"), 930_766_865);
    assert_eq!(cksum(&[0; 300]), 351_385_237);
}

#[test]
fn modules_are_up_to_date() {
    let text = fs::read_to_string(path("spirv/MANIFEST")).expect("spirv/MANIFEST: run tools/shaders");
    let manifest = Manifest::parse(&text);
    let mut wrong = Vec::new();
    for (file, &(sum, size)) in &manifest.sums {
        match fs::read(path(file)) {
            Ok(bytes) if bytes.len() == size && cksum(&bytes) == sum => {}
            Ok(_) => wrong.push(format!("{file} has changed")),
            Err(error) => wrong.push(format!("{file}: {error}")),
        }
    }
    let sources: BTreeSet<_> = manifest.modules.values().flatten().collect();
    wrong.extend(sources.iter().filter(|s| !manifest.sums.contains_key(**s)).map(|s| format!("{s} has no sum")));
    for (module, sources) in &manifest.modules {
        let source = module.replacen("spirv/", "glsl/", 1).replace(".spv", "");
        if !sources.contains(&source) {
            wrong.push(format!("{module} is not made from {source}"));
        }
    }
    let listed: BTreeSet<_> = manifest.modules.keys().cloned().collect();
    let present: BTreeSet<_> = files("spirv").into_iter().filter(|f| f != "spirv/MANIFEST").collect();
    let compiled = |f: &String| [".comp", ".vert", ".tesc", ".tese", ".frag"].iter().any(|end| f.ends_with(end));
    let wanted = files("glsl").into_iter().filter(compiled).map(|f| f.replacen("glsl/", "spirv/", 1) + ".spv");
    let wanted: BTreeSet<_> = wanted.collect();
    wrong.extend(listed.symmetric_difference(&wanted).map(|f| format!("{f} is in one of MANIFEST and glsl/ only")));
    wrong.extend(present.symmetric_difference(&wanted).map(|f| format!("{f} or its source is missing")));
    assert!(wrong.is_empty(), "run tools/shaders:\n{}", wrong.join("\n"));
}

#[test]
fn modules_run_on_vulkan_1_2_and_carry_no_debug_text() {
    let shaders = committed("");
    assert!(!shaders.is_empty());
    for Shader { name, words } in shaders {
        assert!(words[1] <= 0x0001_0500, "{name}: SPIR-V {:#x}", words[1]);
        for (op, operands) in instructions(&words) {
            // OpSource with a file or text, OpSourceContinued, OpString, OpLine, OpModuleProcessed: what -g adds
            assert!(!(op == 3 && operands.len() > 2 || matches!(op, 2 | 7 | 8 | 330)), "{name}: compiled with -g");
            // LocalSizeId forces a host to turn on maintenance4
            assert!(!(op == 331 && operands[1] == 38), "{name}: LocalSizeId");
        }
    }
}

/// The largest pass needs as many storage buffers as are asked of a device, and nothing beyond what every device has.
#[test]
fn passes_need_what_is_asked_of_a_device() {
    let mut passes: BTreeMap<String, BTreeMap<(u32, u32), Resource>> = BTreeMap::new();
    for Shader { name, words } in committed("") {
        // the stages of a graphics pipeline share one layout, which every stage sees
        let pass = name.rsplit_once('.').expect("a stage").0.to_owned();
        passes.entry(pass).or_default().extend(resources(&words));
    }
    let most = |kind| {
        let count = |pass: &BTreeMap<_, Resource>| pass.values().filter(|&&r| r == kind).count() as u32;
        passes.iter().map(|(name, pass)| (count(pass), name)).max().expect("a pass")
    };
    let (storage_buffers, largest) = most(Resource::StorageBuffer);
    assert_eq!(storage_buffers, umbrage::gpu::STORAGE_BUFFERS, "{largest}");
    // required limits of Vulkan 1.3 (specification, table 53)
    for (kind, least) in [(Resource::UniformBuffer, 12), (Resource::SampledImage, 16), (Resource::StorageImage, 4)] {
        let (count, name) = most(kind);
        assert!((1..=least).contains(&count), "{name}: {count} of {kind:?}");
    }
    for Shader { name, words } in committed("") {
        let threads = read(&words).local_size.map_or(0, |size| size.iter().product());
        assert!(threads <= umbrage::gpu::GROUP_THREADS, "{name}: {threads} threads");
    }
}

#[derive(Clone, Copy)]
#[repr(C)]
struct Texel {
    #[allow(dead_code)] // only its place matters
    depth: f32,
    ws_normal: [f32; 3],
}

const FIELDS: [(&str, usize); 2] = [("depth", 0), ("ws_normal", offset_of!(Texel, ws_normal))];

/// One instruction; a string operand is given as text.
fn op(code: u32, operands: &[u32], text: &str) -> Vec<u32> {
    let mut words = operands.to_vec();
    if !text.is_empty() {
        let bytes = [text.as_bytes(), &[0; 4]].concat();
        words.extend(bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())));
    }
    [vec![(words.len() as u32 + 1) << 16 | code], words].concat()
}

/// A module with `Texel` in an array of the given stride, and a copy of it without offsets, as glslang makes for locals.
fn module(stride: u32, normal_at: u32) -> Vec<Shader> {
    let words = [
        vec![0x0723_0203, 0x0001_0500, 0, 9, 0],
        op(16, &[1, 17, 64, 1, 1], ""),
        op(5, &[2], "Texel"),
        op(6, &[2, 0], "depth"),
        op(6, &[2, 1], "ws_normal"),
        op(5, &[3], "Texel"),
        op(6, &[3, 0], "depth"),
        op(5, &[5], "GROUP"),
        op(71, &[4, 6, stride], ""),
        op(71, &[5, 1, 7], ""),
        op(71, &[6, 34, 1], ""),
        op(71, &[6, 33, 3], ""),
        op(72, &[2, 0, 35, 0], ""),
        op(72, &[2, 1, 35, normal_at], ""),
        op(30, &[2, 8, 8], ""),
        op(30, &[3, 8], ""),
        op(29, &[4, 2], ""),
    ];
    vec![Shader { name: "hand-made".to_owned(), words: words.concat() }]
}

#[test]
fn reader_finds_everything() {
    let members = vec![("depth".to_owned(), 0), ("ws_normal".to_owned(), 4)];
    let want = Module {
        structs: vec![Struct { name: "Texel".to_owned(), members, stride: Some(16) }],
        bindings: vec![(1, 3)],
        constants: BTreeMap::from([(7, "GROUP".to_owned())]),
        local_size: Some([64, 1, 1]),
    };
    assert_eq!(read(&module(16, 4)[0].words), want);
}

#[test]
fn layout_check_accepts_and_refuses() {
    assert_layout::<Texel>(&module(16, 4), "Texel", &FIELDS);
    let size = size_of::<Texel>();
    let check = |shaders: &[Shader], name, fields: &[_]| check_layout(shaders, name, size, fields).unwrap_err();
    assert!(check(&module(16, 4), "Other", &FIELDS).starts_with("no struct Other"));
    assert!(check(&[], "Texel", &FIELDS).starts_with("no struct Texel"));
    assert!(check(&module(16, 8), "Texel", &FIELDS).contains("in Rust [(\"depth\", 0)"));
    assert!(check(&module(32, 4), "Texel", &FIELDS).contains("stride of Some(32), in Rust 16"));
    assert!(check(&module(16, 4), "Texel", &FIELDS[..1]).contains("in Rust"));
    assert!(check(&module(16, 4), "Texel", &[FIELDS[0], ("normal", 4)]).contains("in Rust"));
    assert!(check(&module(16, 4), "Texel", &[FIELDS[0], FIELDS[1], ("pad", 16)]).contains("in Rust"));
    // one good shader does not excuse a bad one
    let both = [module(16, 4), module(16, 16)].map(|mut m| m.remove(0));
    assert!(check(&both, "Texel", &FIELDS).contains("in Rust"));
}

#[test]
#[should_panic(expected = "no struct Page")]
fn assert_layout_panics() {
    assert_layout::<Texel>(&module(16, 4), "Page", &FIELDS);
}

/// What a host includes takes no name that the host may have given to something of its own.
#[test]
fn names_of_the_host_include_are_prefixed() {
    let shaders = committed("examples/forward.frag");
    let mut checked = 0;
    // OpName of a function: its signature follows the name
    for (_, operands) in instructions(&shaders[0].words).filter(|(opcode, _)| *opcode == 5) {
        let text: Vec<u8> = operands[1..].iter().flat_map(|word| word.to_le_bytes()).collect();
        let name = String::from_utf8_lossy(&text);
        if let Some((function, _)) = name.split_once('(') {
            assert!(function.starts_with("umbrage_") || function == "main", "function {name}");
            checked += 1;
        }
    }
    assert!(checked > 15, "{checked} functions");
}
