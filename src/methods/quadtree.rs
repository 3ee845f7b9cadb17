//! What the adaptive shadow maps share: a quadtree of pages over the plane across a parallel light, tiles that hold them, and the
//! passes that place the tiles and pick one for each pixel.

use super::comparison::Comparison;
use super::map::{self, Given, Map, Screen, Shape, Step};
use super::{MethodSpec, Parameter, Statistics, map_light, tree};
use crate::gpu::structs::{Cell, Fit, Frame, MapLight, Slices, TilePage, VirtualMap};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Memory, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;
use glam::DVec3;

/// Keys of both methods, before those of the comparison.
pub(super) const MEMORY: Parameter =
    Parameter { key: "memory_mib", default: "16", allowed: "1 to 1024", meaning: "device memory of the tiles in MiB" };
pub(super) const CELL: Parameter = Parameter {
    key: "cell",
    default: "128",
    allowed: "32, 64, 128 or 256",
    meaning: "side of a page's tile in texels, its border included",
};
pub(super) const START: Parameter = Parameter {
    key: "start",
    default: "512",
    allowed: "128, 256, 512, 1024 or 2048, at least the tile's side, in at most half the tiles",
    meaning: "side of the map that refining starts from, in texels of its tiles; it is always there",
};
pub(super) const VIRTUAL: Parameter = Parameter {
    key: "virtual",
    default: "21",
    allowed: "12 to 22",
    meaning: "side of the finest virtual map in texels of its tiles, as a power of two",
};
pub(super) const LEVEL: Parameter = Parameter {
    key: "level",
    default: "area",
    allowed: "area or min_length",
    meaning: "what of a pixel is compared with a texel: its area or its shorter side",
};
pub(super) const LEVEL_BIAS: Parameter = Parameter {
    key: "level_bias",
    default: "-1",
    allowed: "-8 to 8",
    meaning: "levels by which texels may be larger than pixels; -1: two texels along a pixel, the thesis's Nyquist rate",
};

/// What their keys say.
pub(super) struct Settings {
    pub(super) tiles: u32,
    pub(super) side: u32,
    /// Depth of the pages that are always there.
    root_depth: u32,
    /// Greatest depth.
    finest: u32,
    rule: u32,
    level_bias: f32,
    comparison: Comparison,
}

impl Settings {
    pub(super) fn of(spec: &MethodSpec) -> Result<Self, LabError> {
        let word = |parameter: &Parameter, allowed: &[&str]| -> Result<u32, LabError> {
            let text = spec.one_of(parameter.key, parameter.default, allowed)?;
            Ok(text.parse().unwrap_or(0))
        };
        let side = word(&CELL, &["32", "64", "128", "256"])?;
        let start = word(&START, &["128", "256", "512", "1024", "2048"])?;
        let bytes = u64::from(spec.u32_in(MEMORY.key, 16, 1..=1024)?) << 20;
        let tiles = (bytes / (4 * u64::from(side * side))) as u32;
        let refuse = |why: String| Err(LabError::Usage(format!("'{spec}' has {why}")));
        if start < side {
            return refuse(format!("start={start} and cell={side}, allowed is a start of at least the cell"));
        }
        let roots = (start / side).pow(2);
        if 2 * roots > tiles {
            return refuse(format!("{tiles} tiles and starts with {roots}, allowed is to start with at most half"));
        }
        let finest = spec.u32_in(VIRTUAL.key, 21, 12..=22)? - side.ilog2();
        Ok(Self {
            tiles,
            side,
            root_depth: (start / side).ilog2(),
            finest,
            rule: u32::from(spec.one_of(LEVEL.key, LEVEL.default, &["area", "min_length"])? == "min_length"),
            level_bias: spec.f32_in(LEVEL_BIAS.key, -1.0, -8.0..=8.0)?,
            comparison: Comparison::of(spec)?,
        })
    }

    /// Cells that a tree needs whose tiles all lie at the greatest depth, if those above have none.
    pub(super) fn sparse_cells(&self) -> u32 {
        (1 << (2 * self.root_depth)) + self.tiles * (self.finest - self.root_depth)
    }

    /// What [`constants`] takes of them. `border`: of a tile, in texels.
    fn tree(&self, border: u32) -> [u32; 4] {
        [self.root_depth, self.finest, self.side, border]
    }
}

/// Words of constants: `own`, up to seven, then those of a pixel's samples and those of `glsl/methods/quadtree.glsl`. `tree`: depth of the
/// root pages and the greatest depth, side and border of a tile in texels.
pub(crate) fn constants(own: &[u32], tree: [u32; 4]) -> [u32; 15] {
    let mut words = [0; 15];
    words[..own.len()].copy_from_slice(own);
    words[9] = 1;
    words[11..].copy_from_slice(&tree);
    words
}

/// The tree and its tiles.
pub(super) struct Quadtree {
    pub(super) settings: Settings,
    pub(super) screen: Screen,
    pub(super) map: [Map; 1],
    /// A [`VirtualMap`].
    place: Buffer,
    /// A [`Cell`] for each node; the first are those that are always there.
    pub(super) cells: Buffer,
    /// A [`TilePage`] for each tile.
    pub(super) pages: Buffer,
    begin: Compute,
    find: Compute,
    /// The light of the last frame; none before the first.
    light: Option<MapLight>,
    frame: u32,
}

/// What the CPU gives for a frame.
pub(super) struct Seen {
    given: [Given; 1],
    pub(super) place: VirtualMap,
}

impl Quadtree {
    /// `cells`: nodes of the tree.
    pub(super) fn new(spec: &MethodSpec, lab: &Lab, settings: Settings, cells: u32) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let gpu = lab.gpu();
        let screen = Screen::new(lab)?;
        let Settings { side, tiles, comparison, .. } = settings;
        let shape = Shape { side, layers: tiles, tiled: true, blend: 0.0, comparison };
        let map = Map::new(spec, lab, &screen, &lab.view().lights[0], shape)?;
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let place = Buffer::new(gpu, "virtual map", size_of::<VirtualMap>() as u64, usage, Memory::Device)?;
        let storage = |name, each: usize, count: u32| {
            Buffer::storage(gpu, name, each as u64 * u64::from(count), vk::BufferUsageFlags::empty())
        };
        let cells = storage("cells", size_of::<Cell>(), cells)?;
        let pages = storage("pages of tiles", size_of::<TilePage>(), tiles)?;
        let own = tree::layers(&map)?;
        let tree = [Binding::Uniform(&place), Binding::Storage(&cells), Binding::Storage(&pages)];
        let border = map.shape().border();
        let begin = [&tree[..], &[Binding::Storage(map.fits()), Binding::Storage(&own.drawn)]].concat();
        let find = [&map.samples(&screen)[..], &tree, &[Binding::Storage(&own.picked)]].concat();
        Ok(Self {
            begin: Compute::new(
                gpu,
                "asm_begin",
                spirv!("methods/asm_begin.comp"),
                &begin,
                &constants(&[tiles], settings.tree(border)),
                0,
            )?,
            find: Compute::new(
                gpu,
                "asm_find",
                spirv!("methods/asm_find.comp"),
                &find,
                &constants(&[1, 0], settings.tree(border)),
                0,
            )?,
            settings,
            screen,
            map: [map],
            place,
            cells,
            pages,
            light: None,
            frame: 1,
        })
    }

    /// Constants of a pass of the method's own.
    pub(super) fn constants(&self, own: &[u32]) -> [u32; 15] {
        constants(own, self.settings.tree(self.map[0].shape().border()))
    }

    pub(super) fn tile_count(&self) -> u32 {
        self.settings.tiles
    }

    pub(super) fn fits(&self) -> Binding<'_> {
        Binding::Storage(self.map[0].fits())
    }

    pub(super) fn light(&self) -> Binding<'_> {
        self.map[0].samples(&self.screen)[3]
    }

    /// Marks of the tiles that the next draw clears and draws.
    pub(super) fn drawn(&self) -> Result<Binding<'_>, LabError> {
        Ok(Binding::Storage(&tree::layers(&self.map[0])?.drawn))
    }

    /// The virtual map, the cells and the pages.
    pub(super) fn tree(&self) -> [Binding<'_>; 3] {
        [Binding::Uniform(&self.place), Binding::Storage(&self.cells), Binding::Storage(&self.pages)]
    }

    /// What passes over samples bind: `glsl/methods/asm_samples.glsl`, the pages, the fits and the tiles.
    pub(super) fn sampled(&self) -> Vec<Binding<'_>> {
        let own = [self.fits(), Binding::Sampled(self.map[0].image())];
        [&self.map[0].samples(&self.screen)[..], &self.tree(), &own].concat()
    }

    /// What is new to a frame; `keep`: whether pages of the last one stay where they can.
    pub(super) fn look(&mut self, lab: &Lab, keep: bool) -> Result<Seen, LabError> {
        map::check_lights(lab, &self.map)?;
        let light = &lab.view().lights[0];
        let constants = map_light::constants(light, lab, self.settings.comparison.bias_texels)?;
        let mut fixed = constants;
        // the eye moves without the pages
        fixed.eye = [0.0; 4];
        fixed.faces[0].z[3] = 0.0;
        fixed.faces.iter_mut().for_each(|face| (face.x[3], face.y[3]) = (0.0, 0.0));
        let reset = !keep || self.light != Some(fixed);
        self.light = Some(fixed);
        self.frame += 1;
        let extent = map_light::extent(light, lab.scene_buffers());
        let page = extent / f64::from(1u32 << self.settings.finest);
        let eye = lab.view().camera.eye - lab.scene().origin;
        // by the axes as shaders know them: what they make of an eye and a distance from it does not depend on the eye
        let units = [constants.faces[0].x, constants.faces[0].y].map(|[x, y, z, _]| {
            let axis = DVec3::new(x.into(), y.into(), z.into());
            (eye.dot(axis) + 0.5 * extent) / page
        });
        let interior = f64::from(self.settings.side - 2 * self.map[0].shape().border());
        let texel = extent / interior;
        let square = texel * texel * (-2.0 * f64::from(self.settings.level_bias)).exp2();
        Ok(Seen {
            given: [Given { light: constants, fits: Some(vec![Fit::zeroed()]), slices: Slices::zeroed() }],
            place: VirtualMap {
                eye_page: units.map(|u| u.floor().clamp(-1e9, 1e9) as i32),
                eye_inside: units.map(|u| (u - u.floor()) as f32),
                page: page as f32,
                square: square as f32,
                rule: self.settings.rule,
                frame: self.frame,
                reset: reset.into(),
            },
        })
    }

    /// Records what comes before anything is drawn: receivers, and the tiles as the eye sees them. `transfers`: the method's own.
    pub(super) fn record_begin(
        &self,
        lab: &Lab,
        camera: &Frame,
        (cmd, timer): (vk::CommandBuffer, &mut Timer),
        seen: &Seen,
        transfers: impl Fn(vk::CommandBuffer),
    ) {
        let device = &lab.gpu().device;
        map::record_fits((lab, camera), (cmd, timer), &self.screen, &self.map, &seen.given, |step, cmd, _| {
            if step == Step::Reset {
                // SAFETY: the command buffer is recording; the data is smaller than 64 KiB
                unsafe { device.cmd_update_buffer(cmd, self.place.raw, 0, bytemuck::bytes_of(&seen.place)) };
                transfers(cmd);
            }
        });
        let cells = (self.cells.size / size_of::<Cell>() as u64) as u32;
        let threads = if seen.place.reset == 1 { cells.max(self.settings.tiles) } else { self.settings.tiles };
        self.begin.dispatch(cmd, &(), [threads.div_ceil(64), 1, 1]);
        sync::barrier(device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
    }

    /// Draws the marked tiles; what shaders wrote is ordered before.
    pub(super) fn record_draw(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        self.map[0].draw(lab, cmd);
        // marks and lists may change again
        sync::barrier(&lab.gpu().device, cmd, &[(Access::GraphicsRead, Access::ComputeWrite)]);
    }

    /// Picks the tile of each pixel and looks it up.
    pub(super) fn record_lookup(&self, lab: &Lab, cmd: vk::CommandBuffer, timer: &mut Timer) {
        let device = &lab.gpu().device;
        let [width, height] = lab.view().size;
        sync::barrier(device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        self.find.dispatch(cmd, &(), [width.div_ceil(8), height.div_ceil(8), 1]);
        sync::barrier(device, cmd, &[(Access::ComputeWrite, Access::ComputeRead)]);
        timer.mark(cmd, "find");
        self.map[0].look_up(cmd, &self.screen);
        timer.mark(cmd, "lookup");
    }

    /// Device memory by purpose, in bytes.
    pub(super) fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut all = map::memory(&self.screen, &self.map);
        all.push(("tree", self.place.size + self.cells.size + self.pages.size));
        all
    }

    pub(super) fn statistics(&self, lab: &Lab) -> Result<Statistics, LabError> {
        map::statistics(lab, &self.map)
    }
}
