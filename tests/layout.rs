//! Structs shared with GLSL have the names and offsets of the committed SPIR-V, and every stage has all its files.
#![cfg(feature = "lab")]

#[path = "support/spirv.rs"]
mod spirv;

use spirv::{assert_layout, check_layout, committed, files, path, read};
use std::collections::BTreeSet;
use std::mem::offset_of;
use umbrage::gpu::structs::{
    AnalyzePush, AsmCounts, AsmGpuCounts, AsmGpuPush, AsmPush, AtlasPush, Cell, ChoosePush, Counters, DominantPlane,
    Edge, EdgeRun, Face, Fit, ForwardCounts, ForwardSample, Frame, ImportancePush, ItemPush, LightRecord, MapLight,
    MeshBounds, Node, Page, PreparePush, QvsmPush, Region, RequestPush, RetryPush, RtwPush, SamplingError, ShadeLight,
    ShadePush, Slices, Slot, StalePush, TemporalJitter, TemporalPush, TileCounts, TilePage, Tracked, TreeMeasurePush,
    TreeRequestPush, TreeState, TrianglePush, VirtualMap, WarpMeasure, WarpPush, WarpRecord,
};
use umbrage::scene::{Cluster, Instance, Material};

/// Name and offset of each field.
macro_rules! fields {
    ($type:ident, $($field:ident)*) => { &[$((stringify!($field), offset_of!($type, $field))),*] };
}

#[test]
fn engine_structs_are_those_of_the_shaders() {
    let all = committed("");
    assert_layout::<Frame>(
        &all,
        "Frame",
        fields!(Frame, clip_from_eye ray_corner ray_dx ray_dy eye eye_low size lights cache rule sun),
    );
    assert_layout::<LightRecord>(
        &all,
        "Light",
        fields!(LightRecord, axis_x axis_y axis_z low_x low_y place place_low eye scale rule eye_page kind),
    );
    assert_layout::<Node>(&all, "Node", fields!(Node, own below cost ranks parent page slot marks child));
    assert_layout::<Page>(
        &all,
        "Page",
        fields!(Page, key node slot dynamic_slot draws admitted turned scale pad origin),
    );
    assert_layout::<Counters>(
        &all,
        "Counters",
        fields!(Counters, requests unique leaves nodes failed shift threshold draw_threshold draw_order draws_asked pages hits stale
            admitted drawn drawn_dynamic deferred evicted invalidated pairs_opaque pairs_masked pairs_host pairs_asked indices
            triangles sorted changed dynamics items active_faces starved requested resident refused),
    );
    assert_layout::<Slot>(&all, "Slot", fields!(Slot, axis_x revision axis_z valid key seen used));
    let tracked = fields!(Tracked, rows low center reach material revision flags state since patience mesh pad);
    assert_layout::<Tracked>(&all, "Tracked", tracked);
    assert_layout::<MeshBounds>(&all, "MeshBounds", fields!(MeshBounds, center first_cluster extent cluster_count));
}

#[test]
fn scene_structs_are_those_of_the_shaders() {
    let all = committed("");
    assert_layout::<Cluster>(&all, "Cluster", fields!(Cluster, center first_index extent triangle_count));
    assert_layout::<Instance>(&all, "Instance", fields!(Instance, rows low material mesh revision flags));
    assert_layout::<Material>(
        &all,
        "Material",
        fields!(Material, base_color uv_row0 uv_row1 texel_offset width height wrap alpha_cutoff translucent pad),
    );
}

/// A constant buffer of one frame has no arrays of it, so its size is not checked by a stride.
#[test]
fn the_frame_has_no_tail() {
    assert_eq!(offset_of!(Frame, sun) + size_of::<LightRecord>(), size_of::<Frame>());
}

#[test]
fn a_wrong_layout_is_seen() {
    let all = committed("engine/");
    let right: &[(&str, usize)] = &[("instance", 0), ("first_cluster", 4)];
    assert!(check_layout(&all, "Item", 8, right).is_ok());
    assert!(check_layout(&all, "Item", 12, right).is_err(), "size");
    assert!(check_layout(&all, "Item", 8, &[("instance", 4), ("first_cluster", 0)]).is_err(), "offsets");
    assert!(check_layout(&all, "Item", 8, &[("first_cluster", 0), ("instance", 4)]).is_err(), "names");
    assert!(check_layout(&all, "Itom", 8, right).is_err(), "a struct that no shader has");
}

/// Structs without a Rust type that a test can name: fixed by Vulkan, or private.
#[test]
fn other_structs_have_their_known_layout() {
    type Command = ash::vk::DrawIndexedIndirectCommand;
    let all = committed("");
    let fields = fields!(Command, index_count instance_count first_index vertex_offset first_instance);
    assert_layout::<Command>(&all, "DrawCommand", fields);
    assert_eq!(
        check_layout(&all, "Pair", 24, &[("target", 0), ("instance", 4), ("cluster", 8), ("anchor", 12)]),
        Ok(())
    );
    let item: &[(&str, usize)] = &[("tile", 0), ("instance", 4), ("first_cluster", 8)];
    assert_eq!(check_layout(&all, "TileItem", 12, item), Ok(()));
    assert_eq!(check_layout(&all, "TilePair", 8, &[("tile", 0), ("instance", 4)]), Ok(()));
}

#[test]
fn map_structs_are_those_of_the_shaders() {
    let all = committed("methods/");
    assert_layout::<Fit>(&all, "Fit", fields!(Fit, row_u row_v row_w texel));
    assert_layout::<Face>(&all, "Face", fields!(Face, x y z origin));
    assert_layout::<MapLight>(&all, "MapLight", fields!(MapLight, faces eye depth rule));
    let counts = fields!(TileCounts, groups items opaque masked dropped);
    assert_layout::<TileCounts>(&all, "TileCounts", counts);
    let warp = fields!(WarpRecord, bounds slopes depths costs middle line distance extent warped through_eye axis sine moved fit);
    assert_layout::<WarpRecord>(&all, "Warp", warp);
    let plane = fields!(DominantPlane, plane forward sums bin count pad);
    assert_layout::<DominantPlane>(&all, "DominantPlane", plane);
    let measure = committed("methods/warp_measure.comp");
    assert_layout::<WarpMeasure>(&measure, "Push", fields!(WarpMeasure, step resolution));
    let push = fields!(WarpPush, step resolution border parameter always);
    assert_layout::<WarpPush>(&committed("methods/warp_choose.comp"), "Push", push);
    let jitter = committed("methods/temporal_jitter.comp");
    assert_layout::<TemporalJitter>(&jitter, "Push", fields!(TemporalJitter, turn shift));
    let push = fields!(TemporalPush, clip_before eye_moved exponent memory rejection moved side history);
    assert_layout::<TemporalPush>(&committed("methods/temporal_blend.comp"), "Push", push);
    for shader in ["backward", "forward"] {
        let push = fields!(RtwPush, nearness normal edge view stride);
        assert_layout::<RtwPush>(&committed(&format!("methods/rtw_{shader}.comp")), "Push", push);
    }
    let error = fields!(SamplingError, s t perspective_s perspective_t part);
    assert_layout::<SamplingError>(&all, "SamplingError", error);
    let sample = fields!(ForwardSample, at_x at_y nearest farthest slope_x slope_y layer pad);
    assert_layout::<ForwardSample>(&all, "ForwardSample", sample);
    let counts = fields!(ForwardCounts, vertices instances first_vertex first_instance holes);
    assert_layout::<ForwardCounts>(&all, "ForwardCounts", counts);
    assert_layout::<Slices>(&all, "Slices", fields!(Slices, extremes outside splits exits));
    assert_layout::<Edge>(&all, "Edge", fields!(Edge, ends first count));
    assert_layout::<EdgeRun>(&all, "EdgeRun", fields!(EdgeRun, instance first count));
    assert_eq!(offset_of!(MapLight, rule) + 16, size_of::<MapLight>());
}

#[test]
fn quadtree_structs_are_those_of_the_shaders() {
    let all = committed("methods/");
    let map = fields!(VirtualMap, eye_page eye_inside page square rule frame reset);
    assert_layout::<VirtualMap>(&all, "VirtualMap", map);
    assert_layout::<Cell>(&all, "Cell", fields!(Cell, child tile));
    assert_layout::<TilePage>(&all, "TilePage", fields!(TilePage, depth x y parent used value seen benefit texels));
    let counts = fields!(AsmCounts, resident made evicted displaced waiting stale);
    assert_layout::<AsmCounts>(&all, "AsmCounts", counts);
    let counts = fields!(AsmGpuCounts, resident iterations requested outstanding cells asking);
    assert_layout::<AsmGpuCounts>(&all, "AsmGpuCounts", counts);
    // `KNOWN_BYTES` in src/methods/asm.rs
    assert_eq!(check_layout(&all, "Known", 112, &[("instance", 0), ("center", 80), ("extent", 96)]), Ok(()));
    let push = |shader: &str| committed(&format!("methods/{shader}.comp"));
    assert_layout::<AnalyzePush>(&push("asm_analyze"), "Push", fields!(AnalyzePush, step offset));
    assert_layout::<AsmPush>(&push("asm_choose"), "Push", fields!(AsmPush, most threshold overhead));
    assert_layout::<StalePush>(&push("asm_stale"), "Push", fields!(StalePush, instance_count tiles reset));
    let push = push("asm_gpu_allocate");
    assert_layout::<AsmGpuPush>(&push, "Push", fields!(AsmGpuPush, first last groups argument));
}

#[test]
fn tree_structs_are_those_of_the_shaders() {
    let all = committed("methods/");
    let region = fields!(Region, low size samples splits priority unmet changed);
    assert_layout::<Region>(&all, "Region", region);
    assert_layout::<TreeState>(&all, "TreeState", fields!(TreeState, counts refused));
    let push = |shader: &str| committed(&format!("methods/{shader}.comp"));
    let measure = fields!(TreeMeasurePush, round drop threshold start);
    assert_layout::<TreeMeasurePush>(&push("tree_measure"), "Push", measure);
    assert_layout::<TreeRequestPush>(&push("tree_request"), "Push", fields!(TreeRequestPush, texels density));
    assert_layout::<ImportancePush>(&push("tiled_importance"), "Push", fields!(ImportancePush, near jumps));
    assert_layout::<QvsmPush>(&push("qvsm_compare"), "Push", fields!(QvsmPush, round start));
}

#[test]
fn window_structs_are_those_of_the_shaders() {
    let of = |shader: &str| committed(&format!("window/{shader}.comp"));
    assert_layout::<ShadeLight>(&of("shade"), "ShadeLight", fields!(ShadeLight, place direction cone));
    assert_layout::<ShadePush>(&of("shade"), "Push", fields!(ShadePush, up count bits show sun_at));
    assert_layout::<AtlasPush>(&of("atlas"), "Push", fields!(AtlasPush, columns cell));
}

#[test]
fn push_constants_are_those_of_their_shaders() {
    let push = |shader: &str| committed(&format!("engine/{shader}.comp"));
    assert_layout::<RequestPush>(&push("request"), "Push", fields!(RequestPush, attempt shift));
    let retry = fields!(RetryPush, attempt shift groups_x groups_y argument);
    assert_layout::<RetryPush>(&push("request_retry"), "Push", retry);
    assert_layout::<PreparePush>(&push("sort_prepare"), "Push", fields!(PreparePush, capacity argument));
    for shader in ["allocate_choose", "allocate_defer"] {
        assert_layout::<ChoosePush>(&push(shader), "Push", fields!(ChoosePush, draw_budget step));
    }
    assert_layout::<ItemPush>(&push("cull_prepare"), "Push", fields!(ItemPush, layer argument));
    assert_layout::<TrianglePush>(&push("cull_triangles"), "Push", fields!(TrianglePush, masked first_compacted));
}

/// Every struct of which shaders have an array is compared above.
#[test]
fn no_struct_is_forgotten() {
    let compared = [
        "Light",
        "Node",
        "Page",
        "Slot",
        "Tracked",
        "MeshBounds",
        "Item",
        "Cluster",
        "Instance",
        "Material",
        "Pair",
        "DrawCommand",
        "Fit",
        "Face",
        "Edge",
        "EdgeRun",
        "ShadeLight",
        "SamplingError",
        "ForwardSample",
        "Warp",
        "TileItem",
        "TilePair",
        "Cell",
        "TilePage",
        "Known",
        "Region",
    ];
    let structs = committed("").into_iter().flat_map(|s| read(&s.words).structs).filter(|s| s.stride.is_some());
    // what hosts include has a longer name
    let names: BTreeSet<_> = structs.map(|s| s.name.trim_start_matches("Umbrage").to_owned()).collect();
    assert_eq!(names, compared.map(str::to_owned).into());
}

/// What comes before the first '_', but for the depth prepass.
fn stems(files: &[String]) -> BTreeSet<String> {
    let stem = |file: &String| {
        let name = file.rsplit('/').next()?.split('.').next()?;
        Some(if name.starts_with("depth_prepass") { "depth_prepass" } else { name.split('_').next()? }.to_owned())
    };
    files.iter().filter_map(stem).collect()
}

#[test]
fn no_stage_is_an_orphan() {
    let shaders = stems(&files("glsl/engine"));
    assert!(shaders.len() >= 9, "{shaders:?}");
    assert_eq!(shaders, stems(&files("spirv/engine")));
    for stem in &shaders {
        assert!(path(&format!("src/engine/{stem}.rs")).is_file(), "src/engine/{stem}.rs is missing");
    }
    let helpers = ["buffers", "constants", "frame", "frozen", "lights", "mod", "steer", "view"];
    for file in files("src/engine") {
        let name = file.rsplit('/').next().unwrap().trim_end_matches(".rs");
        assert!(helpers.contains(&name) || shaders.contains(name), "{file} has no shader");
    }
    for stem in ["gradient", "request", "sort", "compact", "allocate"] {
        assert!(shaders.contains(stem), "{stem} has no shader");
        for file in [format!("src/twin/{stem}.rs"), format!("tests/gpu/{stem}.rs")] {
            assert!(path(&file).is_file(), "{file} is missing");
        }
    }
    for file in files("src/twin") {
        let name = file.rsplit('/').next().unwrap().trim_end_matches(".rs");
        let shared = ["shared", "methods"].iter().any(|place| path(&format!("glsl/{place}/{name}.glsl")).is_file());
        assert!(name == "mod" || shared || shaders.contains(name), "{file} is the twin of nothing");
    }
}

/// Validation is silent about two dispatches that both declare a buffer writable, so the order of a stage's own
/// dispatches is read from its source: each is followed by a barrier or ends its function.
#[test]
fn dispatches_of_a_stage_have_barriers_between_them() {
    for stem in ["sort", "compact", "allocate"] {
        let source = std::fs::read_to_string(path(&format!("src/engine/{stem}.rs"))).unwrap();
        let statements: Vec<&str> = source.split(';').map(str::trim).collect();
        let dispatches = |text: &str| text.contains(".dispatch");
        assert!(statements.iter().filter(|s| dispatches(s)).count() >= 3, "{stem}");
        for pair in statements.windows(2).filter(|pair| dispatches(pair[0])) {
            let ordered = pair[1].contains("barrier(") || pair[1].contains("next()");
            let rest_of_function = pair[1].split("fn ").next().unwrap_or_default();
            let last = rest_of_function.starts_with('}') && !dispatches(rest_of_function);
            assert!(ordered || last, "{stem}.rs: no barrier after `{}`", pair[0]);
        }
    }
}
