//! What the methods that refine a map from its root share (book, 4.4): a tree of tiles over the fit to the visible samples, refined
//! in rounds on the GPU. Each round has a list of regions; those that are to be split give their parts to the next one's.

use super::comparison::Comparison;
use super::map::{self, Map, Screen, Shape, Step};
use super::tiles::Tiles;
use super::{FrameTimes, MethodSpec, Parameter, map_light};
use crate::engine::constants::light_axes;
use crate::gpu::structs::{Fit, Region, TreeMeasurePush, TreeRequestPush, TreeState};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use glam::DVec3;
use std::sync::Arc;

/// The key that all have.
pub(super) const fn tile(default: &'static str) -> Parameter {
    Parameter { key: "tile", default, allowed: "32 to 4096", meaning: "side of a tile in texels" }
}

/// What makes a region split; as in `glsl/methods/tree_measure.comp`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Along each axis, by what its samples ask for along it.
    Rectangles,
    /// Along both, by what they ask for along either.
    Squares,
    /// Along both, by the pixels that changed.
    Changed,
}

/// Size and rule of a tree.
#[derive(Debug, Clone, Copy)]
pub struct TreeShape {
    /// Splits along an axis that are possible.
    pub levels: u32,
    /// Most regions in a list.
    pub tiles: u32,
    /// What splits them.
    pub rule: Rule,
}

impl TreeShape {
    /// Entries of the page table.
    fn entries(&self) -> u64 {
        1 << (2 * self.levels)
    }

    /// Levels that requests tell apart, the last of them finer than there is.
    pub fn bins(&self) -> u32 {
        if self.rule == Rule::Changed { 1 } else { self.levels + 2 }
    }

    /// Words of the request buffer.
    pub fn request_words(&self) -> u64 {
        let axes = if self.rule == Rule::Changed { 1 } else { 2 };
        axes * u64::from(self.bins()) * self.entries()
    }
}

/// Requests, lists and the passes that refine them.
pub(crate) struct Tree {
    pub(crate) shape: TreeShape,
    /// Samples, or for each axis and level those that need it, of each entry.
    pub(crate) requests: Buffer,
    /// Lists of even and odd rounds.
    pub(crate) regions: Buffer,
    pub(crate) state: Buffer,
    measure: Compute,
    expand: Compute,
    gpu: Arc<Gpu>,
}

impl Tree {
    pub(crate) fn new(gpu: &Arc<Gpu>, shape: TreeShape) -> Result<Self, LabError> {
        let storage = |name, bytes: u64| Buffer::storage(gpu, name, bytes, vk::BufferUsageFlags::empty());
        let requests = storage("tile requests", 4 * shape.request_words())?;
        let regions = storage("regions", 2 * u64::from(shape.tiles) * size_of::<Region>() as u64)?;
        let state = storage("tree", size_of::<TreeState>() as u64)?;
        let all = [&requests, &regions, &state].map(Binding::Storage);
        let constants = [shape.levels, shape.tiles, shape.bins(), shape.rule as u32];
        let keep = u32::from(shape.rule != Rule::Changed);
        let (measure, expand) = (spirv!("methods/tree_measure.comp"), spirv!("methods/tree_expand.comp"));
        Ok(Self {
            measure: Compute::new(gpu, "tree_measure", measure, &all, &constants, size_of::<TreeMeasurePush>())?,
            expand: Compute::new(gpu, "tree_expand", expand, &all[1..], &[shape.levels, shape.tiles, keep], 4)?,
            shape,
            requests,
            regions,
            state,
            gpu: gpu.clone(),
        })
    }

    /// Among the first transfers of a frame: one region, the root, and no requests.
    pub(crate) fn reset(&self, cmd: vk::CommandBuffer) {
        let side = 1 << self.shape.levels;
        let root = Region { size: [side, side], ..bytemuck::Zeroable::zeroed() };
        let mut state: TreeState = bytemuck::Zeroable::zeroed();
        state.counts[0] = 1;
        let device = &self.gpu.device;
        // SAFETY: the command buffer is recording; the caller orders this after the last frame
        unsafe {
            device.cmd_fill_buffer(cmd, self.requests.raw, 0, vk::WHOLE_SIZE, 0);
            device.cmd_update_buffer(cmd, self.regions.raw, 0, bytemuck::bytes_of(&root));
            device.cmd_update_buffer(cmd, self.state.raw, 0, bytemuck::bytes_of(&state));
        }
    }

    /// Orders passes of a frame.
    pub(crate) fn next(&self, cmd: vk::CommandBuffer) {
        sync::barrier(&self.gpu.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
    }

    /// Decides which regions of a round are to be split.
    pub(crate) fn measure(&self, cmd: vk::CommandBuffer, push: TreeMeasurePush) {
        // no list is longer than the last one's parts
        let most = 1u32.checked_shl(2 * push.round).map_or(self.shape.tiles, |most| most.min(self.shape.tiles));
        self.measure.dispatch(cmd, &push, [most, 1, 1]);
        self.next(cmd);
    }

    /// Makes the next round's list of them.
    pub(crate) fn expand(&self, cmd: vk::CommandBuffer, round: u32) {
        self.expand.dispatch(cmd, &round, [1, 1, 1]);
        self.next(cmd);
    }

    /// Regions and counts of a frame; the list is that of a round.
    pub(crate) fn read(&self, lab: &Lab, round: u32) -> Result<(Vec<Region>, TreeState), LabError> {
        let state: TreeState = bytemuck::pod_read_unaligned(&lab.read_buffer(&self.state)?[..size_of::<TreeState>()]);
        let regions: Vec<Region> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.regions)?);
        let first = (round & 1) * self.shape.tiles;
        let list = first as usize..(first + state.counts[round as usize]) as usize;
        Ok((regions[list].to_vec(), state))
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.requests.size + self.regions.size + self.state.size
    }
}

/// What a frame left.
pub struct TreeFrame {
    /// Axes of the light: across, across, along.
    pub axes: [DVec3; 3],
    /// Where the root lies.
    pub root: Fit,
    /// See `glsl/methods/tree_request.comp`.
    pub requests: Vec<u32>,
    /// The list of the last round.
    pub regions: Vec<Region>,
    /// Counts of all rounds.
    pub state: TreeState,
    /// The tile of each pixel.
    pub picked: Vec<u32>,
    /// One value a pixel.
    pub visibility: Vec<f32>,
}

/// What a map of tiles has beside the image.
pub(super) fn layers(map: &Map) -> Result<&Tiles, LabError> {
    map.tiles().ok_or_else(|| LabError::Refused("the map of a tree has no tiles".into()))
}

/// A tree whose regions are the tiles of a parallel light's map.
pub(super) struct TreeMap {
    pub(super) screen: Screen,
    pub(super) map: [Map; 1],
    pub(super) tree: Tree,
    comparison: Comparison,
    table: Buffer,
    request: Compute,
    place: Compute,
    pick: Compute,
    size: [u32; 2],
    /// Texels of a tile along a side that samples may fall on.
    texels: f32,
}

impl TreeMap {
    /// `side`: of a tile in texels.
    pub(super) fn new(
        spec: &MethodSpec,
        lab: &Lab,
        side: u32,
        shape: TreeShape,
        comparison: Comparison,
    ) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let (gpu, screen) = (lab.gpu(), Screen::new(lab)?);
        let TreeShape { levels, tiles, .. } = shape;
        let layer = Shape { side, layers: tiles, tiled: true, blend: 0.0, comparison };
        let map = Map::new(spec, lab, &screen, &lab.view().lights[0], layer)?;
        let tree = Tree::new(gpu, shape)?;
        let table = Buffer::storage(gpu, "tile table", 4 * tree.shape.entries(), vk::BufferUsageFlags::empty())?;
        let samples = map.samples(&screen);
        let layers = layers(&map)?;
        let [root, drawn, picked] = [&layers.root, &layers.drawn, &layers.picked].map(Binding::Storage);
        let [requests, regions, state, table_at] =
            [&tree.requests, &tree.regions, &tree.state, &table].map(Binding::Storage);
        let (side, border) = (map.shape().side as f32, map.shape().border() as f32);
        let compute = |name, spirv: &[u8], bindings: &[&[Binding<'_>]], constants: &[u32], push: usize| {
            Compute::new(gpu, name, spirv, &bindings.concat(), constants, push)
        };
        let request = spirv!("methods/tree_request.comp");
        let (place, pick) = (spirv!("methods/tree_place.comp"), spirv!("methods/tree_pick.comp"));
        Ok(Self {
            request: compute(
                "tree_request",
                request,
                &[&samples, &[root, requests]],
                &[1, 0, 0, 0, 0, 0, levels, tree.shape.bins()],
                size_of::<TreeRequestPush>(),
            )?,
            place: compute(
                "tree_place",
                place,
                &[&[root, regions, state, Binding::Storage(map.fits()), drawn, table_at]],
                &[levels, tiles, side.to_bits(), border.to_bits()],
                4,
            )?,
            pick: compute("tree_pick", pick, &[&samples, &[root, table_at, picked]], &[1, 0, 0, 0, 0, 0, levels], 4)?,
            screen,
            map: [map],
            tree,
            comparison,
            table,
            size: lab.view().size,
            texels: side - 2.0 * border,
        })
    }

    /// What the map's tiles are.
    pub(super) fn layers(&self) -> Result<&Tiles, LabError> {
        layers(&self.map[0])
    }

    /// A frame: the root is fitted to the samples; `refine` records what follows.
    pub(super) fn frame(
        &self,
        lab: &Lab,
        refine: impl FnOnce(vk::CommandBuffer, &mut Timer),
    ) -> Result<FrameTimes, LabError> {
        let given = map::given_samples(lab, &self.map, &self.comparison)?;
        let camera = lab.camera_constants()?;
        let steps = |step, cmd, _: &mut Timer| {
            if step == Step::Reset {
                self.reset(cmd);
            }
        };
        lab.frame(|cmd, timer| {
            map::record_fits((lab, &camera), (cmd, timer), &self.screen, &self.map, &given, steps);
            refine(cmd, timer);
        })
    }

    /// Makes the regions of a round the map's tiles, draws them and looks them up.
    pub(super) fn serve(&self, lab: &Lab, (cmd, timer): (vk::CommandBuffer, &mut Timer), round: u32) {
        self.place(cmd, round);
        timer.mark(cmd, "tree");
        self.map[0].draw(lab, cmd);
        timer.mark(cmd, "map");
        self.map[0].look_up(cmd, &self.screen);
    }

    /// Among the first transfers of a frame.
    fn reset(&self, cmd: vk::CommandBuffer) {
        self.tree.reset(cmd);
        // SAFETY: the command buffer is recording; the caller orders this after the last frame
        unsafe { self.tree.gpu.device.cmd_fill_buffer(cmd, self.table.raw, 0, vk::WHOLE_SIZE, 0) };
    }

    /// After the root was fitted: what the samples ask for. `density`: texels along a pixel's footprint.
    pub(super) fn request(&self, cmd: vk::CommandBuffer, density: f32) {
        self.request.dispatch(cmd, &TreeRequestPush { texels: self.texels, density }, self.screen.columns());
        self.tree.next(cmd);
    }

    /// Makes the regions of a round the map's tiles, and finds that of each sample.
    pub(super) fn place(&self, cmd: vk::CommandBuffer, round: u32) {
        // what the round before placed may still be drawn
        sync::barrier(&self.tree.gpu.device, cmd, &[(Access::GraphicsRead, Access::ComputeWrite)]);
        self.place.dispatch(cmd, &round, [self.tree.shape.tiles, 1, 1]);
        self.tree.next(cmd);
        self.pick.dispatch(cmd, &round, [self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1]);
        self.tree.next(cmd);
    }

    /// What the last frame left; the last list is that of a round.
    pub(super) fn left(&self, lab: &Lab, round: u32) -> Result<TreeFrame, LabError> {
        let layers = self.layers()?;
        let (regions, state) = self.tree.read(lab, round)?;
        Ok(TreeFrame {
            axes: light_axes(map_light::direction(lab.light(0)?))?,
            root: bytemuck::pod_read_unaligned(&lab.read_buffer(&layers.root)?[..size_of::<Fit>()]),
            requests: bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.tree.requests)?),
            regions,
            state,
            picked: bytemuck::pod_collect_to_vec(&lab.read_buffer(&layers.picked)?),
            visibility: self.map[0].visibility(lab)?,
        })
    }

    pub(super) fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = map::memory(&self.screen, &self.map);
        memory.push(("tree", self.tree.bytes() + self.table.size));
        memory
    }
}
