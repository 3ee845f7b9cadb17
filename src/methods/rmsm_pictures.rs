//! Pictures of the engine's state after a frame: level and page of every pixel, the atlas, the page table.

use super::DebugPicture;
use crate::engine::Engine;
use crate::engine::constants::ROOT_LEVEL;
use crate::engine::lookup::Lookup;
use crate::gpu::structs::Page;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Image, ImageSpec};
use crate::lab::{Lab, LabError};
use crate::output::{OutputError, Picture, ids, levels};
use ash::vk;

/// Pixels of a page's thumbnail in the picture of the atlas.
const THUMBNAIL: u32 = 32;
/// Side of the picture of the page table; it spans a page of the root level.
const TABLE_SIDE: u32 = 1024;
const EMPTY: [u8; 3] = [24, 24, 28];

pub(super) fn draw(engine: &Engine, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
    let entries = entries(engine, lab)?;
    let [width, height] = lab.view().size;
    let level = |e: &u32| if *e == 0 { f32::NAN } else { (e >> 26 & 31) as f32 };
    let page = |e: &u32| if *e == 0 { u32::MAX } else { e & 0xfff };
    let by_level: Vec<_> = entries.iter().map(level).collect();
    let by_page: Vec<_> = entries.iter().map(page).collect();
    let pages = pages(engine, lab)?;
    Ok(vec![
        picture("level", levels(width, height, &by_level).map_err(refuse)?),
        picture("page", ids(width, height, &by_page).map_err(refuse)?),
        picture("atlas", atlas(engine, lab, &pages)?),
        picture("page_table", table(&pages)?),
    ])
}

fn refuse(error: OutputError) -> LabError {
    LabError::Refused(error.to_string())
}

fn picture(name: &'static str, p: Picture) -> DebugPicture {
    DebugPicture { name, width: p.width, height: p.height, rgb: p.rgb }
}

/// The page table entry that serves each pixel.
fn entries(engine: &Engine, lab: &Lab) -> Result<Vec<u32>, LabError> {
    let [width, height] = lab.view().size;
    let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
    let target =
        Image::new(lab.gpu(), "entries", &ImageSpec { format: vk::Format::R32_UINT, width, height, layers: 0, usage })?;
    let (b, view) = (&engine.buffers, &engine.views[0].buffers);
    let pass = Lookup::entries(lab.gpu(), &engine.config, b, (0, view), &target)?;
    lab.submit(|cmd| {
        let device = &lab.gpu().device;
        sync::discard(device, cmd, &target, Access::Nothing, Access::StorageImage);
        pass.dispatch(cmd, &(), [width.div_ceil(8), height.div_ceil(8), 1]);
        sync::image(device, cmd, &target, Access::StorageImage, Access::TransferRead);
    })?;
    Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&target, Access::TransferRead, 4)?))
}

/// The pages that were drawn, coarse ones first.
fn pages(engine: &Engine, lab: &Lab) -> Result<Vec<Page>, LabError> {
    let count = engine.last_counters().pages.min(engine.config.page_capacity()) as usize;
    let bytes = lab.read_buffer(&engine.buffers.pages)?;
    let pages: Vec<Page> = bytemuck::pod_collect_to_vec(&bytes[..count * size_of::<Page>()]);
    Ok(pages.into_iter().filter(|p| p.admitted != 0).collect())
}

fn key_level(key: [u32; 2]) -> u32 {
    ROOT_LEVEL as u32 + 1 - (key[0] >> 27)
}

/// A thumbnail of each layer: the depths of a drawn page between its nearest and farthest, tinted by its level.
fn atlas(engine: &Engine, lab: &Lab, pages: &[Page]) -> Result<Picture, LabError> {
    let side = engine.config.page_texels;
    let capacity = engine.config.page_capacity();
    let columns = f64::from(capacity).sqrt().ceil() as u32;
    let depths: Vec<f32> =
        bytemuck::pod_collect_to_vec(&lab.read_image(&engine.buffers.atlas, Access::ComputeRead, 4)?);
    let tints = level_colors(pages)?;
    let mut out = Picture::filled(columns * THUMBNAIL, capacity.div_ceil(columns) * THUMBNAIL, EMPTY);
    for (page, tint) in pages.iter().zip(tints) {
        let layer = &depths[(page.slot * side * side) as usize..((page.slot + 1) * side * side) as usize];
        let drawn = layer.iter().copied().filter(|d| *d > 0.0);
        let (low, high) = drawn.fold((1.0f32, 0.0f32), |(l, h), d| (l.min(d), h.max(d)));
        for i in 0..THUMBNAIL * THUMBNAIL {
            let (x, y) = (i % THUMBNAIL, i / THUMBNAIL);
            let depth = layer[((y * side / THUMBNAIL) * side + x * side / THUMBNAIL) as usize];
            let shade = if depth > 0.0 { 0.3 + 0.7 * (depth - low) / (high - low).max(1e-9) } else { 0.12 };
            let color = tint.map(|c| (f32::from(c) * shade) as u8);
            out.set(page.slot % columns * THUMBNAIL + x, page.slot / columns * THUMBNAIL + y, color);
        }
    }
    Ok(out)
}

/// The drawn pages where they lie in each face, fine ones over coarse ones; faces side by side.
fn table(pages: &[Page]) -> Result<Picture, LabError> {
    let face = |p: &Page| p.key[0] >> 14 & 0x1fff;
    let mut faces: Vec<u32> = pages.iter().map(face).collect();
    faces.sort_unstable();
    faces.dedup();
    let columns = (faces.len().max(1) as f64).sqrt().ceil() as u32;
    let cell = TABLE_SIDE / columns;
    let mut out = Picture::filled(TABLE_SIDE, TABLE_SIDE, EMPTY);
    for (page, color) in pages.iter().zip(level_colors(pages)?) {
        let level = key_level(page.key);
        let at = |coordinate: u32| ((u64::from(coordinate) * u64::from(cell)) << level >> ROOT_LEVEL) as u32;
        let (x, y) = ((page.key[0] & 0x3fff) << 9 | page.key[1] >> 23, page.key[1] & 0x7f_ffff);
        let place = faces.binary_search(&face(page)).unwrap_or(0) as u32;
        let (column, row) = (place % columns * cell, place / columns * cell);
        let (left, top) = (at(x), at(y));
        let (width, height) = ((at(x + 1) - left).max(1), (at(y + 1) - top).max(1));
        out.fill(column + left, row + top, width, height, color.map(|c| c / 2));
        if width > 2 && height > 2 {
            out.fill(column + left + 1, row + top + 1, width - 1, height - 1, color);
        }
    }
    Ok(out)
}

/// The colour of each page's level, as in the picture of levels.
fn level_colors(pages: &[Page]) -> Result<Vec<[u8; 3]>, LabError> {
    let values: Vec<_> = (0..=ROOT_LEVEL).map(|l| l as f32).collect();
    let strip = levels(values.len() as u32, 1, &values).map_err(refuse)?;
    Ok(pages.iter().map(|p| strip.get(key_level(p.key), 0).unwrap_or(EMPTY)).collect())
}
