//! The choice of pages of an adaptive shadow map on the GPU, with a tree given by tests.

use super::stages::{read, write};
use super::{Lab, LabError};
use crate::gpu::structs::{AsmCounts, AsmPush, Cell, Fit, TilePage, VirtualMap};
use crate::gpu::{Binding, Buffer, Compute, Memory, spirv};
use crate::methods::quadtree;
use ash::vk;
use bytemuck::Zeroable;

/// A tree and what was counted; a cell has the index of the tile that holds it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AsmTree {
    /// Nodes.
    pub cells: Vec<Cell>,
    /// What each tile holds.
    pub pages: Vec<TilePage>,
    /// 1 for tiles that are drawn.
    pub drawn: Vec<u32>,
    /// What was done.
    pub counts: AsmCounts,
}

/// Makes the pages of a frame. `depths`: those of the pages that are always there, and the greatest.
///
/// # Errors
/// [`LabError::Engine`] for everything Vulkan reports.
pub fn choose(
    lab: &Lab,
    tree: &AsmTree,
    depths: [u32; 2],
    frame: u32,
    push: AsmPush,
) -> Result<(AsmTree, Vec<Fit>), LabError> {
    let gpu = &lab.gpu;
    let tiles = tree.pages.len() as u32;
    let storage =
        |name, each: usize| Buffer::storage(gpu, name, each as u64 * u64::from(tiles), vk::BufferUsageFlags::empty());
    let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    let place = Buffer::new(gpu, "virtual map", size_of::<VirtualMap>() as u64, usage, Memory::Device)?;
    let (cells, pages) = (storage("cells", size_of::<Cell>())?, storage("pages", size_of::<TilePage>())?);
    let (fits, drawn) = (storage("fits", size_of::<Fit>())?, storage("tiles drawn", 4)?);
    let counts = Buffer::storage(gpu, "counts", size_of::<AsmCounts>() as u64, vk::BufferUsageFlags::empty())?;
    write(lab, &place, &[VirtualMap { frame, page: 1.0, square: 1.0, ..VirtualMap::zeroed() }])?;
    write(lab, &cells, &tree.cells)?;
    write(lab, &pages, &tree.pages)?;
    write(lab, &fits, &vec![Fit::zeroed(); tiles as usize])?;
    write(lab, &drawn, &tree.drawn)?;
    write(lab, &counts, &[tree.counts])?;
    let bindings = [
        Binding::Uniform(&place),
        Binding::Storage(&cells),
        Binding::Storage(&pages),
        Binding::Storage(&fits),
        Binding::Storage(&drawn),
        Binding::Storage(&counts),
    ];
    let constants = quadtree::constants(&[tiles], [depths[0], depths[1], 128, 1]);
    let words = spirv!("methods/asm_choose.comp");
    let pass = Compute::new(gpu, "asm_choose", words, &bindings, &constants, size_of::<AsmPush>())?;
    lab.submit(|cmd| pass.dispatch(cmd, &push, [1, 1, 1]))?;
    let first = |all: Vec<_>| all[0];
    let shorten = |mut all: Vec<u32>| {
        all.truncate(tiles as usize);
        all
    };
    let out = AsmTree {
        cells: read(lab, &cells)?,
        pages: read(lab, &pages)?,
        drawn: shorten(read(lab, &drawn)?),
        counts: first(read(lab, &counts)?),
    };
    Ok((out, read(lab, &fits)?))
}
