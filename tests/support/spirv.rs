//! Reads what a committed shader says about itself: struct layouts, bindings, specialization constants, group size.
//! Self-contained, so that unit tests can include it with `#[path]`.
#![allow(dead_code)] // each test that includes this file uses a part of it

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A module's path below `spirv/`, without `.spv`, and its words.
pub struct Shader {
    pub name: String,
    pub words: Vec<u32>,
}

/// A struct as the shader lays it out in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Struct {
    pub name: String,
    /// Names and offsets in bytes, in order.
    pub members: Vec<(String, u32)>,
    /// Bytes from one element to the next, where the shader has an array of this struct.
    pub stride: Option<u32>,
}

/// What the reader keeps of a module.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Module {
    /// Only structs with offsets: the others never meet the CPU.
    pub structs: Vec<Struct>,
    /// Set and binding, sorted.
    pub bindings: Vec<(u32, u32)>,
    /// Names of the specialization constants by id; "" for those without a name.
    pub constants: BTreeMap<u32, String>,
    /// Group size of a compute shader; a size given by a specialization constant has its default.
    pub local_size: Option<[u32; 3]>,
}

/// Below the repository's root.
pub fn path(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The files below a folder of the repository, as paths relative to the root, sorted.
pub fn files(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(path(folder)).unwrap_or_else(|e| panic!("{folder}: {e}")) {
        let entry = entry.unwrap();
        let name = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() { found.extend(files(&name)) } else { found.push(name) }
    }
    found.sort();
    found
}

/// The committed shaders whose name starts with `prefix`: "" for all, "engine/request.comp" for one.
pub fn committed(prefix: &str) -> Vec<Shader> {
    let shader = |file: String| {
        let name = file.strip_prefix("spirv/")?.strip_suffix(".spv")?.to_owned();
        let bytes = fs::read(path(&file)).unwrap();
        let words = bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().expect("whole words"))).collect();
        name.starts_with(prefix).then_some(Shader { name, words })
    };
    files("spirv").into_iter().filter_map(shader).collect()
}

/// Opcode and operands of each instruction.
pub fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    assert_eq!(words.first(), Some(&0x0723_0203), "not a SPIR-V module");
    let mut rest = &words[5..];
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        rest = after;
        Some((first & 0xffff, &instruction[1..]))
    })
}

fn string(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).take_while(|&b| b != 0).collect();
    String::from_utf8(bytes).unwrap()
}

/// Reads a module. Names are those of the source; glslang keeps them without `-g`.
pub fn read(words: &[u32]) -> Module {
    let mut names = BTreeMap::new();
    let mut member_names = BTreeMap::new();
    let mut offsets = BTreeMap::new();
    let mut strides = BTreeMap::new();
    let mut types = Vec::new(); // structs and their member counts, in the order of the module
    let mut arrays = Vec::new();
    let (mut sets, mut bindings) = (BTreeMap::new(), BTreeMap::new());
    let mut spec_ids = BTreeMap::new();
    let mut module = Module::default();
    for (op, o) in instructions(words) {
        match (op, o) {
            (5, [id, name @ ..]) => _ = names.insert(*id, string(name)),
            (6, [id, member, name @ ..]) => _ = member_names.insert((*id, *member), string(name)),
            (16, [_, 17, x, y, z]) => module.local_size = Some([*x, *y, *z]),
            (28 | 29, [id, element, ..]) => arrays.push((*id, *element)),
            (30, [id, members @ ..]) => types.push((*id, members.len() as u32)),
            (71, [id, 1, value]) => _ = spec_ids.insert(*value, *id),
            (71, [id, 6, value]) => _ = strides.insert(*id, *value),
            (71, [id, 33, value]) => _ = bindings.insert(*id, *value),
            (71, [id, 34, value]) => _ = sets.insert(*id, *value),
            (72, [id, member, 35, value]) => _ = offsets.insert((*id, *member), *value),
            _ => {}
        }
    }
    let name = |id: &u32| names.get(id).cloned().unwrap_or_default();
    for (id, count) in types {
        let member = |m| Some((member_names.get(&(id, m)).cloned().unwrap_or_default(), *offsets.get(&(id, m))?));
        if let Some(members) = (0..count).map(member).collect() {
            let array = arrays.iter().find(|(array, element)| *element == id && strides.contains_key(array));
            let stride = array.map(|(array, _)| strides[array]);
            module.structs.push(Struct { name: name(&id), members, stride });
        }
    }
    module.bindings = bindings.iter().map(|(id, binding)| (sets.get(id).copied().unwrap_or(0), *binding)).collect();
    module.bindings.sort();
    module.constants = spec_ids.iter().map(|(value, id)| (*value, name(id))).collect();
    module
}

/// What a descriptor is, by its Vulkan type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Resource {
    UniformBuffer,
    StorageBuffer,
    SampledImage,
    StorageImage,
}

/// The descriptors of a module by set and binding.
pub fn resources(words: &[u32]) -> BTreeMap<(u32, u32), Resource> {
    let (mut sets, mut bindings, mut pointers) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let (mut storage_images, mut variables) = (Vec::new(), Vec::new());
    for (op, o) in instructions(words) {
        match (op, o) {
            (25, [id, _, _, _, _, _, 2, ..]) => storage_images.push(*id),
            (32, [id, _, pointee]) => _ = pointers.insert(*id, *pointee),
            (59, [pointer, id, class, ..]) => variables.push((*id, *class, pointers[pointer])),
            (71, [id, 33, value]) => _ = bindings.insert(*id, *value),
            (71, [id, 34, value]) => _ = sets.insert(*id, *value),
            _ => {}
        }
    }
    let resource = |(id, class, of): (u32, u32, u32)| {
        let kind = match class {
            0 if storage_images.contains(&of) => Resource::StorageImage,
            0 => Resource::SampledImage,
            2 => Resource::UniformBuffer,
            12 => Resource::StorageBuffer,
            _ => return None,
        };
        Some(((sets.get(&id).copied().unwrap_or(0), *bindings.get(&id)?), kind))
    };
    variables.into_iter().filter_map(resource).collect()
}

/// Compares a struct of `size` bytes with every shader that has one of this name; the error says where they differ.
pub fn check_layout(shaders: &[Shader], name: &str, size: usize, fields: &[(&str, usize)]) -> Result<(), String> {
    let want: Vec<_> = fields.iter().map(|&(field, offset)| (field.to_owned(), offset as u32)).collect();
    let mut found = false;
    for shader in shaders {
        for s in read(&shader.words).structs.iter().filter(|s| s.name == name) {
            found = true;
            if s.members != want {
                return Err(format!("{}: {name} is {:?}, in Rust {want:?}", shader.name, s.members));
            }
            if s.stride.is_some_and(|stride| stride as usize != size) {
                return Err(format!("{}: {name} has a stride of {:?}, in Rust {size}", shader.name, s.stride));
            }
        }
    }
    let searched: Vec<_> = shaders.iter().map(|s| &s.name).collect();
    if found { Ok(()) } else { Err(format!("no struct {name} in {searched:?}")) }
}

/// Fails unless `T` has the names and offsets that `name` has in the shaders. A renamed struct fails too.
///
/// ```ignore
/// assert_layout::<Frame>(&committed("engine/"), "Frame", &[("ws_eye", offset_of!(Frame, ws_eye)), ..]);
/// assert_layout::<Push>(&committed("engine/request.comp"), "Push", &[..]);
/// ```
#[track_caller]
pub fn assert_layout<T>(shaders: &[Shader], name: &str, fields: &[(&str, usize)]) {
    if let Err(difference) = check_layout(shaders, name, size_of::<T>(), fields) {
        panic!("{difference}");
    }
}
