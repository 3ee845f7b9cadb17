//! Pointers, sizes and numbers that mean nothing are refused with a message.

use super::guard::message;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use umbrage::capi::*;
use umbrage::{Config, Instance, Meshes};

/// Fails unless the call was refused with this code and a message that says so.
fn refused(result: UmbrageResult, code: UmbrageResult, word: &str) {
    let text = message();
    assert!(result == code && text.contains(word), "{result}, not {code}: {text}, not {word}");
}

fn default(width: u32, height: u32) -> UmbrageConfig {
    let mut config = MaybeUninit::uninit();
    // SAFETY: there is room
    let result = unsafe { umbrage_config_default(config.as_mut_ptr(), size_of::<UmbrageConfig>(), width, height) };
    assert_eq!(result, UMBRAGE_OK);
    // SAFETY: filled
    unsafe { config.assume_init() }
}

#[test]
fn defaults_are_those_of_rust() {
    let (config, rust) = (default(640, 360), Config::new([640, 360]));
    assert_eq!([config.width, config.height], rust.size);
    assert_eq!((config.atlas_bytes, config.page_table_bytes), (rust.atlas_bytes, rust.page_table_bytes));
    assert_eq!((config.struct_size, config.reserved), (size_of::<UmbrageConfig>(), 0));
    // SAFETY: a whole struct
    assert_eq!(unsafe { UmbrageConfig::read(&config) }.unwrap(), rust);
}

#[test]
fn every_field_arrives() {
    // where each word of the struct is changed, one field of the config is; floats and flags too
    let words = size_of::<UmbrageConfig>() / 4;
    let default = default(640, 360);
    // SAFETY: a whole struct
    let before = unsafe { UmbrageConfig::read(&default) }.unwrap();
    let mut silent = Vec::new();
    for word in 2..words {
        let mut config = default;
        // SAFETY: inside of the struct, which has no padding
        unsafe {
            let at = (&raw mut config).cast::<u32>().add(word);
            *at = if *at == 0 { 1 } else { 0 };
        }
        // SAFETY: a whole struct
        match unsafe { UmbrageConfig::read(&config) } {
            Ok(after) if after == before => silent.push(word),
            _ => {}
        }
    }
    // the taps of no filter, and upper halves of sizes are not silent
    let taps = std::mem::offset_of!(UmbrageConfig, filter_taps) / 4;
    assert_eq!(silent, [taps]);
}

#[test]
fn sizes_that_are_not_the_structs_are_refused() {
    let mut config = MaybeUninit::<UmbrageConfig>::uninit();
    for size in [0, 4, size_of::<UmbrageConfig>() - 4, size_of::<UmbrageConfig>() + 4, usize::MAX] {
        // SAFETY: refused before anything is written
        let result = unsafe { umbrage_config_default(config.as_mut_ptr(), size, 1, 1) };
        refused(result, UMBRAGE_ERROR_ARGUMENT, "size of the config");
        let config = UmbrageConfig { struct_size: size, ..default(1, 1) };
        // SAFETY: refused before anything is read
        assert!(unsafe { UmbrageConfig::read(&config) }.is_err());
    }
    // SAFETY: refused
    let result = unsafe { umbrage_config_default(null_mut(), size_of::<UmbrageConfig>(), 1, 1) };
    refused(result, UMBRAGE_ERROR_ARGUMENT, "null");
}

#[test]
fn null_is_refused_everywhere() {
    // SAFETY: all of these are refused before a pointer is followed
    unsafe {
        let results = [
            umbrage_check_device(null()),
            umbrage_enable_features(null(), null_mut(), null_mut(), null_mut()),
            umbrage_enable_ray_queries(null(), null_mut(), null_mut(), null_mut(), null_mut(), null_mut()),
            umbrage_engine_create(null(), null(), null(), null(), 0, null_mut()),
            umbrage_add_light(null_mut(), null(), null_mut()),
            umbrage_set_light(null_mut(), 1, null()),
            umbrage_remove_light(null_mut(), 1),
            umbrage_forget(null_mut()),
            umbrage_record(null_mut(), ash::vk::CommandBuffer::null(), null(), 0, null_mut()),
            umbrage_resize(null_mut(), null(), 0),
            umbrage_steer(null_mut(), 1, 1.0, 0.0),
            umbrage_counters(null(), 1, null_mut(), 0),
            umbrage_memory(null(), null_mut(), null_mut()),
            umbrage_mask(null(), 0, null_mut(), null_mut()),
            umbrage_lookup(null(), 0, null_mut(), null_mut()),
            umbrage_meshes_create(null(), 3, null(), 1, null_mut()),
            umbrage_meshes_data(null(), null_mut()),
            umbrage_meshes_caster_count(null(), null(), 1, null_mut()),
            umbrage_instance_init(null_mut(), null(), 0, 0),
            umbrage_material_init(null_mut()),
            umbrage_prepass_create(null(), null(), 1, 1, null_mut()),
            umbrage_prepass_images(null(), null_mut()),
            umbrage_prepass_record(null(), ash::vk::CommandBuffer::null(), null(), null(), 0),
            umbrage_sample_places(4, null_mut()),
        ];
        assert_eq!(results, [UMBRAGE_ERROR_ARGUMENT; 24]);
        umbrage_engine_destroy(null_mut());
        umbrage_meshes_destroy(null_mut());
        umbrage_prepass_destroy(null_mut());
    }
}

#[test]
fn samples_and_version_are_those_of_rust() {
    let mut places = [[0.0; 2]; 8];
    // SAFETY: there is room, and the text is a constant
    unsafe {
        assert_eq!(umbrage_sample_places(8, places.as_mut_ptr()), UMBRAGE_OK);
        refused(umbrage_sample_places(3, places.as_mut_ptr()), UMBRAGE_ERROR_LIMIT, "samples is 3");
        assert_eq!(std::ffi::CStr::from_ptr(umbrage_version()).to_str(), Ok(env!("CARGO_PKG_VERSION")));
    }
    assert_eq!(places[..], umbrage::sample_places(8));
}

#[test]
fn misaligned_pointers_and_impossible_lengths_are_refused() {
    let words = [0u32; 16];
    let odd = words.as_ptr().cast::<u8>().wrapping_add(1);
    let mut made = null_mut();
    // SAFETY: refused before a pointer is followed
    unsafe {
        let result = umbrage_meshes_create(odd.cast(), 1, null(), 0, &mut made);
        refused(result, UMBRAGE_ERROR_ARGUMENT, "aligned");
        let result = umbrage_meshes_create(words.as_ptr().cast(), usize::MAX / 4, null(), 0, &mut made);
        refused(result, UMBRAGE_ERROR_ARGUMENT, "elements");
    }
    assert!(made.is_null());
}

#[test]
fn meshes_are_those_of_rust() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5f32]];
    let (first, second) = ([0u32, 1, 2, 2, 1, 3], [3u32, 2, 1]);
    let rust = Meshes::new(&positions, &[&first, &second]).unwrap();
    let triangles = |indices: &[u32]| UmbrageTriangles { indices: indices.as_ptr(), index_count: indices.len() };
    let given = [triangles(&first), triangles(&second)];
    let (mut meshes, mut data) = (null_mut(), MaybeUninit::uninit());
    let mut instances = [MaybeUninit::<Instance>::uninit(); 3];
    // SAFETY: all pointers are to as much as their counts say
    unsafe {
        assert_eq!(umbrage_meshes_create(positions.as_ptr(), 4, given.as_ptr(), 2, &mut meshes), UMBRAGE_OK);
        assert_eq!(umbrage_meshes_data(meshes, data.as_mut_ptr()), UMBRAGE_OK);
        let data: UmbrageMeshData = data.assume_init();
        let slice = |at: *const u32, count| std::slice::from_raw_parts(at, count);
        assert_eq!(slice(data.indices, data.index_count), rust.indices);
        assert_eq!(slice(data.meshlets, data.meshlet_word_count), rust.meshlets);
        assert_eq!(std::slice::from_raw_parts(data.clusters, data.cluster_count), rust.clusters);
        assert_eq!(std::slice::from_raw_parts(data.meshes, data.mesh_count), rust.meshes);

        let rows = [[0.0, -1.0, 0.0, 1e7 + 0.1], [2.0, 0.0, 0.0, 2.0], [0.0, 0.0, 3.0, 3.0]];
        for (instance, mesh) in instances.iter_mut().zip([0, 1, 1]) {
            assert_eq!(umbrage_instance_init(instance.as_mut_ptr(), rows.as_ptr(), mesh, 5), UMBRAGE_OK);
        }
        let mut instances = instances.map(|instance| instance.assume_init());
        let translation = instances[0].translation();
        assert!((translation - glam::DVec3::new(1e7 + 0.1, 2.0, 3.0)).length() < 1e-6, "{translation}");
        assert_eq!(instances[0].rows[0][..3], [0.0, -1.0, 0.0]);
        assert_eq!(instances[0].rows[1][..3], [2.0, 0.0, 0.0]);
        assert_eq!([instances[1].mesh, instances[1].material], [1, 5]);
        let mut count = 0;
        assert_eq!(umbrage_meshes_caster_count(meshes, instances.as_ptr(), 3, &mut count), UMBRAGE_OK);
        assert_eq!(count, 3);
        instances[2].mesh = 2;
        let result = umbrage_meshes_caster_count(meshes, instances.as_ptr(), 3, &mut count);
        refused(result, UMBRAGE_ERROR_LIMIT, "mesh of an instance is 2");
        umbrage_meshes_destroy(meshes);

        let beyond = [triangles(&[0, 1, 4])];
        let mut none = null_mut();
        let result = umbrage_meshes_create(positions.as_ptr(), 4, beyond.as_ptr(), 1, &mut none);
        refused(result, UMBRAGE_ERROR_LIMIT, "index is 4");
        assert!(none.is_null());
    }
}
