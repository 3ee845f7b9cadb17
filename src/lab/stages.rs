//! Single stages of the engine on the GPU, with given inputs and their outputs read back: what tests compare with
//! [`crate::twin`].

use super::{Lab, LabError};
use crate::engine::allocate::Allocate;
use crate::engine::buffers::{Buffers, arguments};
use crate::engine::compact::Compact;
use crate::engine::constants::{History, constants, light_record};
use crate::engine::depth_prepass::DepthPrepass;
use crate::engine::gradient::Gradient;
use crate::engine::request::Request;
use crate::engine::sort::{BLOCK, Sort};
use crate::engine::view::ViewBuffers;
use crate::engine::{Engine, FrameId, LightId};
use crate::gpu::structs::{Counters, Frame, LightRecord, Node, Page, Slot, Tracked, light_kind};
use crate::gpu::sync::{self, Access, Access::*};
use crate::gpu::{Binding, Buffer, Compute, Image, ImageSpec, Memory, spirv};
use crate::host::{FrameInput, HostImage, ImageUse, ReceiverImages, Receivers};
use crate::twin::allocate::{Input, NONE};
use crate::twin::compact::compact;
use crate::twin::key::{from_words, words};
use crate::{Camera, Config, RequestRoute};
use ash::vk;
use bytemuck::{Pod, Zeroable};

type Result<T> = std::result::Result<T, LabError>;

/// Copies `data` to the start of a buffer.
pub(super) fn write<T: Pod>(lab: &Lab, buffer: &Buffer, data: &[T]) -> Result<()> {
    let bytes: &[u8] = bytemuck::cast_slice(data);
    if bytes.is_empty() {
        return Ok(());
    }
    let staging = staging(lab, bytes)?;
    lab.submit(|cmd| {
        let device = &lab.gpu.device;
        sync::barrier(device, cmd, &[(HostWrite, TransferRead)]);
        let copy = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: bytes.len() as u64 }];
        // SAFETY: callers pass no more than the buffer holds
        unsafe { device.cmd_copy_buffer(cmd, staging.raw, buffer.raw, &copy) };
        sync::barrier(device, cmd, &[(TransferWrite, ComputeWrite), (TransferWrite, ComputeRead)]);
    })?;
    Ok(())
}

fn staging(lab: &Lab, bytes: &[u8]) -> Result<Buffer> {
    let mut staging =
        Buffer::new(&lab.gpu, "stage input", bytes.len() as u64, vk::BufferUsageFlags::TRANSFER_SRC, Memory::Upload)?;
    staging.bytes_mut()[..bytes.len()].copy_from_slice(bytes);
    Ok(staging)
}

/// Fills an image and leaves it readable by compute shaders.
pub(super) fn write_image<T: Pod>(lab: &Lab, image: &Image, data: &[T]) -> Result<()> {
    let staging = staging(lab, bytemuck::cast_slice(data))?;
    lab.submit(|cmd| {
        let device = &lab.gpu.device;
        sync::barrier(device, cmd, &[(HostWrite, TransferRead)]);
        sync::image(device, cmd, image, Nothing, TransferWrite);
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: image.aspect(),
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let extent = vk::Extent3D { width: image.extent.width, height: image.extent.height, depth: 1 };
        let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
        // SAFETY: callers pass as many texels as the image has
        unsafe {
            device.cmd_copy_buffer_to_image(cmd, staging.raw, image.raw, vk::ImageLayout::TRANSFER_DST_OPTIMAL, &region)
        };
        sync::image(device, cmd, image, TransferWrite, ComputeRead);
    })?;
    Ok(())
}

/// Fills buffers with zeros.
fn clear(lab: &Lab, buffers: &[&Buffer]) -> Result<()> {
    lab.submit(|cmd| {
        for buffer in buffers {
            // SAFETY: storage buffers can be filled
            unsafe { lab.gpu.device.cmd_fill_buffer(cmd, buffer.raw, 0, vk::WHOLE_SIZE, 0) };
        }
        sync::barrier(&lab.gpu.device, cmd, &[(TransferWrite, ComputeWrite), (TransferWrite, ComputeRead)]);
    })?;
    Ok(())
}

pub(super) fn read<T: Pod>(lab: &Lab, buffer: &Buffer) -> Result<Vec<T>> {
    let bytes = lab.read_buffer(buffer)?;
    let whole = bytes.len() / size_of::<T>() * size_of::<T>();
    Ok(bytemuck::pod_collect_to_vec(&bytes[..whole]))
}

fn read_counters(lab: &Lab, b: &Buffers) -> Result<Counters> {
    Ok(read(lab, &b.counters)?[0])
}

/// The key of each slot of the page table, 0 where it is empty.
fn read_keys(lab: &Lab, b: &Buffers) -> Result<Vec<u64>> {
    let stored: Vec<[u32; 2]> = read(lab, &b.table_keys)?;
    Ok(stored.into_iter().map(|[x, y]| if x == 0 { 0 } else { from_words([x, !y]) }).collect())
}

/// The least that [`Buffers`] can be made for; single stages use few of them.
fn small(size: [u32; 2]) -> Config {
    let page_texels = 64;
    Config {
        atlas_bytes: 16 * 4 * 64 * 64,
        page_texels,
        page_table_bytes: Config::table_bytes(1 << 10),
        pair_capacity: 1024,
        ..Config::new(size)
    }
}

/// Sort and compact.
pub struct SortStage {
    b: Buffers,
    sort: Sort,
    compact: Compact,
}

/// A list after compact.
pub struct Compacted {
    /// Distinct keys and the sums of their values.
    pub entries: Vec<(u64, u32)>,
    /// Runs of equal keys for each coarsening.
    pub runs: [u32; 4],
}

impl SortStage {
    /// Sorts at most `capacity` entries.
    pub fn new(lab: &Lab, capacity: u32) -> Result<Self> {
        let b = Buffers::new(&lab.gpu, &small([8, 8]), &lab.buffers, 1)?;
        let sort = Sort::new(&lab.gpu, &b.counters, &b.arguments, capacity)?;
        let compact = Compact::new(&lab.gpu, &b, &sort)?;
        Ok(Self { b, sort, compact })
    }

    fn fill(&self, lab: &Lab, entries: &[(u64, u32)], counters: &Counters) -> Result<()> {
        let fitting = &entries[..entries.len().min(self.sort.capacity as usize)];
        write(lab, self.sort.keys(), &fitting.iter().map(|e| words(e.0)).collect::<Vec<_>>())?;
        write(lab, self.sort.values(), &fitting.iter().map(|e| e.1).collect::<Vec<_>>())?;
        write(lab, &self.b.counters, std::slice::from_ref(counters))
    }

    fn entries(&self, lab: &Lab, [keys, values]: [&Buffer; 2], count: u32) -> Result<Vec<(u64, u32)>> {
        let (keys, values): (Vec<[u32; 2]>, Vec<u32>) = (read(lab, keys)?, read(lab, values)?);
        Ok(keys.into_iter().map(from_words).zip(values).take(count as usize).collect())
    }

    /// Sorts; entries beyond the capacity are counted but have no room.
    pub fn sort(&self, lab: &Lab, entries: &[(u64, u32)]) -> Result<Vec<(u64, u32)>> {
        let mut counters = Counters::zeroed();
        counters.requests[0] = entries.len() as u32;
        self.fill(lab, entries, &counters)?;
        lab.submit(|cmd| self.sort.record(cmd, &self.b))?;
        let sorted = read_counters(lab, &self.b)?.sorted;
        self.entries(lab, [self.sort.keys(), self.sort.values()], sorted)
    }

    /// Compacts a sorted list that is no longer than the capacity.
    pub fn compact(&self, lab: &Lab, sorted: &[(u64, u32)]) -> Result<Compacted> {
        let count = sorted.len() as u32;
        self.fill(lab, sorted, &Counters { sorted: count, ..Counters::zeroed() })?;
        let mut words = vec![0; arguments::WORDS as usize];
        words[arguments::SORT as usize..][..3].copy_from_slice(&[count.div_ceil(BLOCK), 1, 1]);
        write(lab, &self.b.arguments, &words)?;
        clear(lab, &[&self.compact.counts])?;
        lab.submit(|cmd| {
            sync::barrier(&lab.gpu.device, cmd, &[(TransferWrite, IndirectRead)]);
            self.compact.record(cmd, &self.b);
        })?;
        let [a, b, c, d] = read_counters(lab, &self.b)?.unique;
        Ok(Compacted { entries: self.entries(lab, [&self.compact.keys, &self.compact.counts], a)?, runs: [a, b, c, d] })
    }
}

/// What the gradient pass leaves of each pixel.
pub struct Seen {
    /// Depth along the view direction, 0 where there is no surface.
    pub depth: Vec<f32>,
    /// Packed planes.
    pub planes: Vec<[u32; 4]>,
}

/// Gradient and request.
pub struct ScreenStage {
    b: Buffers,
    view: ViewBuffers,
    depth: Image,
    normal: Image,
    /// With and without normals.
    gradients: [Gradient; 2],
    request: Request,
    sort: Sort,
    route: RequestRoute,
}

/// What request left.
pub struct Requested {
    /// The counters.
    pub counters: Counters,
    /// Keys and pixels: of the page table (flags route) or as appended, in Morton form (sort route). Cut off at the capacity.
    pub entries: Vec<(u64, u32)>,
}

impl ScreenStage {
    /// `capacity`: most keys, a power of two (flags route), or most entries of the list (sort route). At most `lights`.
    pub fn new(lab: &Lab, size: [u32; 2], route: RequestRoute, capacity: u32, lights: u32) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |name, format, usage| {
            let usage = usage | U::SAMPLED | U::TRANSFER_DST;
            Image::new(&lab.gpu, name, &ImageSpec { format, width: size[0], height: size[1], layers: 0, usage })
        };
        let keys = if route == RequestRoute::Flags { capacity } else { 1024 };
        let config = Config { route, page_table_bytes: Config::table_bytes(keys), lights, mask_bits: 1, ..small(size) };
        let b = Buffers::new(&lab.gpu, &config, &lab.buffers, 1)?;
        let view = ViewBuffers::new(&lab.gpu, &config, size)?;
        let depth = image("depth", vk::Format::D32_SFLOAT, U::empty())?;
        let normal = image("normal", vk::Format::R32_UINT, U::empty())?;
        let normals = Some(HostImage::own(&normal, vk::Format::R32_UINT));
        let images = ReceiverImages { depth: HostImage::own(&depth, vk::Format::D32_SFLOAT), normal: normals };
        let sort = Sort::new(&lab.gpu, &b.counters, &b.arguments, capacity)?;
        let appends = (route == RequestRoute::Sort).then_some(&sort);
        let gradient = |images| Gradient::new(&lab.gpu, b.frame(0), images, &view.receivers);
        Ok(Self {
            gradients: [gradient(&images)?, gradient(&ReceiverImages { normal: None, ..images })?],
            request: Request::new(&lab.gpu, &config, &b, (0, &view), appends, size)?,
            b,
            view,
            depth,
            normal,
            sort,
            route,
        })
    }

    /// Receivers of the pixels, given stored depths; normals from depths where none are given.
    pub fn gradient(&self, lab: &Lab, frame: &Frame, depth: &[f32], normal: Option<&[u32]>) -> Result<Seen> {
        write(lab, &self.b.frames[0], std::slice::from_ref(frame))?;
        write_image(lab, &self.depth, depth)?;
        if let Some(normal) = normal {
            write_image(lab, &self.normal, normal)?;
        }
        let receivers = &self.view.receivers;
        lab.submit(|cmd| {
            receivers.record_discard(&lab.gpu.device, cmd);
            self.gradients[usize::from(normal.is_none())].record(cmd, [frame.size[0], frame.size[1]]);
            receivers.record_written(&lab.gpu.device, cmd);
        })?;
        Ok(Seen {
            depth: bytemuck::pod_collect_to_vec(&lab.read_image(&receivers.depth, ComputeRead, 4)?),
            planes: bytemuck::pod_collect_to_vec(&lab.read_image(&receivers.planes, ComputeRead, 16)?),
        })
    }

    /// All attempts of the request stage, as the engine records them, given depths along the view direction.
    pub fn request(
        &self,
        lab: &Lab,
        frame: &Frame,
        lights: &[LightRecord],
        depth: &[f32],
        receiver: &[[u32; 4]],
    ) -> Result<Requested> {
        let b = &self.b;
        write(lab, &self.b.frames[0], std::slice::from_ref(frame))?;
        write(lab, &b.lights, lights)?;
        write_image(lab, &self.view.receivers.depth, depth)?;
        write_image(lab, &self.view.receivers.planes, receiver)?;
        clear(lab, &[&b.counters, &b.table_keys, &b.nodes])?;
        let sun = lights.len() == 1 && lights[0].kind[0] == light_kind::DIRECTIONAL;
        lab.submit(|cmd| {
            let device = &lab.gpu.device;
            self.request.record_first(cmd, sun);
            for attempt in 1..=3 {
                sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
                self.request.record_decision(cmd, attempt, [frame.size[0], frame.size[1]]);
                sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
                self.request.record_retry(cmd, b, attempt, sun);
            }
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
            self.request.record_decision(cmd, 4, [frame.size[0], frame.size[1]]);
        })?;
        let counters = read_counters(lab, b)?;
        let entries: Vec<(u64, u32)> = if self.route == RequestRoute::Flags {
            let (list, nodes): (Vec<u32>, Vec<Node>) = (read(lab, &b.node_list)?, read(lab, &b.nodes)?);
            let table = read_keys(lab, b)?;
            let filled = |slot: &u32| (table[*slot as usize], nodes[*slot as usize].own);
            list[..counters.leaves as usize].iter().map(filled).collect()
        } else {
            let keys: Vec<[u32; 2]> = read(lab, self.sort.keys())?;
            let values: Vec<u32> = read(lab, self.sort.values())?;
            let last = counters.requests.iter().rev().find(|&&r| r > 0).copied().unwrap_or(0);
            keys.into_iter().map(from_words).zip(values).take(last as usize).collect()
        };
        Ok(Requested { counters, entries })
    }
}

/// Allocate, fed by the sort route.
pub struct AllocateStage {
    config: Config,
    b: Buffers,
    compact: Compact,
    allocate: Allocate,
}

/// The page table of a frame as it lies on the device.
#[derive(Clone)]
pub struct Table {
    /// The counters.
    pub counters: Counters,
    /// Key of each slot, 0 where it is empty.
    pub keys: Vec<u64>,
    /// Node of each slot.
    pub nodes: Vec<Node>,
    /// Entry of each slot.
    pub entries: Vec<u32>,
    /// The pages selected.
    pub pages: Vec<Page>,
    /// The layers of the atlas.
    pub slots: Vec<Slot>,
}

impl Table {
    fn read(lab: &Lab, b: &Buffers) -> Result<Self> {
        let counters = read_counters(lab, b)?;
        let mut pages: Vec<Page> = read(lab, &b.pages)?;
        pages.truncate(counters.sorted as usize);
        Ok(Self {
            counters,
            keys: read_keys(lab, b)?,
            nodes: read(lab, &b.nodes)?,
            entries: read(lab, &b.entries)?,
            pages,
            slots: read(lab, &b.slots)?,
        })
    }
}

impl AllocateStage {
    /// Capacities, pressure and level bias are those of `config`, within no limits.
    pub fn new(lab: &Lab, config: &Config) -> Result<Self> {
        let b = Buffers::new(&lab.gpu, config, &lab.buffers, 1)?;
        // compact needs the sort only for its buffers
        let sort = Sort::new(&lab.gpu, &b.counters, &b.arguments, 8 * config.request_capacity())?;
        let compact = Compact::new(&lab.gpu, &b, &sort)?;
        let pixels = config.size.map(u64::from).into_iter().product();
        let allocate = Allocate::new(&lab.gpu, config, pixels, &b, Some(&compact))?;
        Ok(Self { config: config.clone(), b, compact, allocate })
    }

    /// Chooses pages and fills the entries. In between, pages get layers as [`crate::twin::allocate::Page`] says; those
    /// that are not `ready` do not serve if chosen, and lose their layer if only held.
    pub fn run(
        &self,
        lab: &Lab,
        frame: &Frame,
        lights: &[LightRecord],
        input: &Input,
        ready: impl Fn(u64) -> bool,
    ) -> Result<Table> {
        let b = &self.b;
        let requests = input.list();
        assert!(requests.len() <= 8 * self.config.request_capacity() as usize, "more requests than the list holds");
        assert!(input.held.len() <= self.config.page_capacity() as usize, "more pages held than the atlas has layers");
        clear(lab, &[&b.table_keys, &b.nodes, &b.histogram, &b.entries, &b.slots, &b.roots])?;
        write(lab, &b.frames[0], std::slice::from_ref(frame))?;
        write(lab, &b.lights, lights)?;
        write(lab, &self.compact.keys, &requests.iter().map(|r| words(r.0)).collect::<Vec<_>>())?;
        write(lab, &self.compact.counts, &requests.iter().map(|r| r.1).collect::<Vec<_>>())?;
        write(lab, &b.counters, &[Counters { unique: compact(&requests).runs, ..Counters::zeroed() }])?;
        let holds = |&(key, valid): &(u64, bool)| Slot { key: words(key), valid: u32::from(valid), ..Slot::zeroed() };
        write(lab, &b.slots, &input.held.iter().map(holds).collect::<Vec<_>>())?;
        lab.submit(|cmd| self.allocate.record_tree(cmd))?;

        let mut nodes: Vec<Node> = read(lab, &b.nodes)?;
        for (node, key) in nodes.iter_mut().zip(read_keys(lab, b)?) {
            let held = (1..).zip(&input.held).find(|(_, held)| held.0 == key);
            node.slot = held.map_or(0, |(slot, held)| slot | u32::from(!held.1) << 31);
            node.marks = u32::from(input.moving.contains(&key));
        }
        write(lab, &b.nodes, &nodes)?;
        lab.submit(|cmd| self.allocate.record_pages(cmd, input.draw_budget))?;

        let Table { mut counters, mut pages, mut slots, .. } = Table::read(lab, b)?;
        for (i, page) in (0..).zip(&mut pages) {
            let free = input.held.len() as u32 + 2 * i;
            page.slot = if page.slot == NONE { free } else { page.slot };
            page.dynamic_slot = if page.draws > 1 { free + 1 } else { page.dynamic_slot };
            page.admitted = u32::from(ready(from_words(page.key)));
            counters.deferred += if page.admitted == 0 { page.draws.count_ones() } else { 0 };
        }
        for slot in slots.iter_mut().filter(|slot| !ready(from_words(slot.key))) {
            slot.key = [0; 2];
        }
        write(lab, &b.pages, &pages)?;
        write(lab, &b.slots, &slots)?;
        write(lab, &b.counters, &[counters])?;
        lab.submit(|cmd| self.allocate.record_entries(cmd))?;
        Table::read(lab, b)
    }
}

/// What outlives a frame.
pub struct Kept {
    /// The layers of the atlas.
    pub slots: Vec<Slot>,
    /// Layers, the first to be taken first.
    pub order: Vec<u32>,
    /// The instances.
    pub tracked: Vec<Tracked>,
}

/// A whole frame of the engine.
pub struct EngineStage {
    engine: Engine,
    lights: Vec<LightId>,
}

impl EngineStage {
    /// An engine for the lab's scene, view and lights.
    pub fn new(lab: &Lab, config: &Config) -> Result<Self> {
        let mut engine = lab.with_receivers(|seen| Engine::on(&lab.gpu, config, &lab.buffers, &[seen]))?;
        let add = |light| engine.add_light(light);
        Ok(Self { lights: lab.view.lights.iter().map(add).collect::<std::result::Result<_, _>>()?, engine })
    }

    /// An engine without lights; what is added to it stays as it is whatever the lab's view says.
    pub fn bare(lab: &Lab, config: &Config) -> Result<Self> {
        let engine = lab.with_receivers(|seen| Engine::on(&lab.gpu, config, &lab.buffers, &[seen]))?;
        Ok(Self { engine, lights: Vec::new() })
    }

    /// The engine.
    pub fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Whether rays walk through the engine's own tree.
    pub fn has_tree(&self) -> bool {
        self.engine.bvh.is_some()
    }

    /// Runs a frame: the words of the mask, layer by layer, and the page table.
    pub fn all(&mut self, lab: &Lab) -> Result<(Vec<u32>, Table)> {
        self.run(lab)?;
        Ok((self.mask(lab)?, Table::read(lab, &self.engine.buffers)?))
    }

    /// Runs a frame: visibility of every pixel towards the first light, and the page table.
    pub fn frame(&mut self, lab: &Lab) -> Result<(Vec<f32>, Table)> {
        self.run(lab)?;
        let mask = self.mask(lab)?;
        let words = mask[..lab.view.size[0] as usize * lab.view.size[1] as usize].iter();
        Ok((words.map(|&word| f32::from_bits(word)).collect(), Table::read(lab, &self.engine.buffers)?))
    }

    /// The words of the mask, layer by layer.
    pub fn mask(&self, lab: &Lab) -> Result<Vec<u32>> {
        let mask = &self.engine.views[0].buffers.mask;
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(mask, TransferRead, 4)?))
    }

    /// Runs a frame with the lights of the lab's view and reads nothing back but its counters.
    pub fn run(&mut self, lab: &Lab) -> Result<Counters> {
        for (&id, light) in self.lights.iter().zip(&lab.view.lights) {
            self.engine.set_light(id, light)?;
        }
        lab.engine_frame(&mut self.engine)?;
        Ok(self.engine.last_counters())
    }

    /// Rays that the first view of the last frame asked for.
    pub fn rays(&self, lab: &Lab) -> Result<u32> {
        let exact = self.engine.views[0].exact.as_ref();
        Ok(exact.map(|exact| read::<u32>(lab, &exact.count)).transpose()?.map_or(0, |words| words[0]))
    }

    /// Forgets all history.
    pub fn forget(&mut self) {
        self.engine.forget();
    }

    /// What is kept for the next frame.
    pub fn kept(&self, lab: &Lab) -> Result<Kept> {
        let b = &self.engine.buffers;
        let mut slots: Vec<Slot> = read(lab, &b.slots)?;
        let mut order: Vec<u32> = read(lab, &b.order)?;
        slots.truncate(self.engine.config.page_capacity() as usize);
        order.truncate(slots.len());
        Ok(Kept { slots, order, tracked: read(lab, &b.tracked)? })
    }

    /// Replaces what is known of the layers, to see that a wrong one is noticed.
    pub fn plant(&self, lab: &Lab, slots: &[Slot]) -> Result<()> {
        write(lab, &self.engine.buffers.slots, slots)
    }

    /// Target (2 * page + layer), instance and cluster of each opaque and each masked pair of the last frame.
    pub fn pairs(&self, lab: &Lab) -> Result<[Vec<[u32; 3]>; 2]> {
        let c = read_counters(lab, &self.engine.buffers)?;
        let words: Vec<[u32; 6]> = read(lab, &self.engine.buffers.pairs)?;
        let mut opaque: Vec<[u32; 3]> =
            words.iter().map(|&[target, instance, cluster, ..]| [target, instance, cluster]).collect();
        let mut masked = opaque.split_off(self.engine.config.pair_capacity as usize);
        opaque.truncate(c.pairs_opaque as usize);
        masked.truncate(c.pairs_masked as usize);
        Ok([opaque, masked])
    }
}

/// Frames of an engine with several views, each with a prepass of its own.
pub struct ViewsStage {
    engine: Engine,
    prepasses: Vec<DepthPrepass>,
}

impl ViewsStage {
    /// An engine without lights, with views of these sizes.
    pub fn new(lab: &Lab, config: &Config, sizes: &[[u32; 2]]) -> Result<Self> {
        let prepasses = Self::prepasses(lab, sizes)?;
        let images: Vec<_> = prepasses.iter().map(|prepass| [prepass.images()]).collect();
        let engine = Engine::on(&lab.gpu, config, &lab.buffers, &Self::receivers(&images, sizes))?;
        Ok(Self { engine, prepasses })
    }

    /// The engine.
    pub fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Gives the views other sizes; after an error everything is as it was.
    pub fn resize(&mut self, lab: &Lab, sizes: &[[u32; 2]]) -> Result<()> {
        let prepasses = Self::prepasses(lab, sizes)?;
        let images: Vec<_> = prepasses.iter().map(|prepass| [prepass.images()]).collect();
        // SAFETY: the lab waits for each submission
        unsafe { self.engine.resize(&Self::receivers(&images, sizes)) }?;
        self.prepasses = prepasses;
        Ok(())
    }

    fn prepasses(lab: &Lab, sizes: &[[u32; 2]]) -> Result<Vec<DepthPrepass>> {
        // what is refused must get that far
        let prepass = |size: &[u32; 2]| Ok(DepthPrepass::on(&lab.gpu, size.map(|side| side.max(1)), &lab.buffers)?);
        sizes.iter().map(prepass).collect()
    }

    fn receivers<'a>(images: &'a [[ReceiverImages; 1]], sizes: &[[u32; 2]]) -> Vec<Receivers<'a>> {
        let view = |(images, &size): (&'a [ReceiverImages; 1], _)| Receivers { size, images, mask: ImageUse::COPIED };
        images.iter().zip(sizes).map(view).collect()
    }

    /// Runs a frame with a camera for each view: the words of each view's mask, and the page table.
    pub fn frame(&mut self, lab: &Lab, cameras: &[Camera]) -> Result<(Vec<Vec<u32>>, Table)> {
        let input = |(camera, prepass): (&Camera, &DepthPrepass)| {
            FrameInput::new(camera, prepass.size(), lab.frame_input().origin)
        };
        let inputs: Vec<_> = cameras.iter().zip(&self.prepasses).map(input).collect();
        let mut recorded = Ok(());
        lab.submit(|cmd| {
            // SAFETY: outside of rendering; each submission is waited for
            let record = |(prepass, input): (&DepthPrepass, _)| unsafe { prepass.record(cmd, input, &lab.draws) };
            recorded = self.prepasses.iter().zip(&inputs).try_for_each(record);
        })?;
        recorded?;
        let mut recorded = None;
        lab.submit(|cmd| recorded = Some(self.engine.record_timed(cmd, &inputs, None, None)))?;
        recorded.transpose()?;
        let mask = |view: &crate::engine::view::View| {
            Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&view.buffers.mask, TransferRead, 4)?))
        };
        Ok((self.engine.views.iter().map(mask).collect::<Result<_>>()?, Table::read(lab, &self.engine.buffers)?))
    }
}

/// An engine whose view sees the lab's images after `edit`.
pub fn seeing(lab: &Lab, config: &Config, edit: impl Fn(&mut ReceiverImages)) -> Result<Engine> {
    let mut images = [lab.prepass.images()];
    edit(&mut images[0]);
    let view = Receivers { size: lab.view.size, images: &images, mask: ImageUse::COPIED };
    Ok(Engine::on(&lab.gpu, config, &lab.buffers, &[view])?)
}

/// Records frames of all engines, one camera after the other, into one command buffer, and runs it: what each
/// frame of each engine is known by.
pub fn in_flight(lab: &Lab, engines: &mut [&mut EngineStage], cameras: &[Camera]) -> Result<Vec<Vec<FrameId>>> {
    let mut frames = vec![Vec::new(); engines.len()];
    let mut recorded = Ok(());
    lab.submit(|cmd| {
        for camera in cameras {
            let input = FrameInput::new(camera, lab.view.size, lab.scene.origin);
            // SAFETY: outside of rendering; the submission is waited for
            recorded = recorded.clone().and(unsafe { lab.prepass.record(cmd, &input, &lab.draws) });
            for (stage, frames) in engines.iter_mut().zip(&mut frames) {
                match stage.engine.record_timed(cmd, &[input], None, None) {
                    Ok(frame) => frames.push(frame),
                    Err(error) => recorded = recorded.clone().and(Err(error)),
                }
            }
        }
    })?;
    recorded?;
    Ok(frames)
}

/// What the camera of the lab sees: depth and packed normals.
pub fn prepass(lab: &Lab) -> Result<(Vec<f32>, Vec<u32>)> {
    lab.run_prepass()?;
    let read = |image| lab.read_image(image, Access::ComputeRead, 4);
    let (depth, normal) = (read(&lab.prepass.depth)?, read(&lab.prepass.normal)?);
    Ok((bytemuck::pod_collect_to_vec(&depth), bytemuck::pod_collect_to_vec(&normal)))
}

/// Constants of a frame of the lab's scene and view, and its lights.
pub fn frame_constants(lab: &Lab, config: &Config) -> Result<(Frame, Vec<LightRecord>)> {
    let input = lab.frame_input();
    let record = |light| Ok(light_record(config, &lab.buffers, light, &input, config.level_bias)?);
    let lights = lab.view.lights.iter().map(record).collect::<Result<Vec<_>>>()?;
    let mut frame = constants(config, config.size, &lab.buffers, &input, &History::default())?;
    frame.lights = [lights.len() as u32, 1, 0, 0];
    frame.sun = lights[0];
    Ok((frame, lights))
}

/// One dispatch writes a buffer and the next reads it; without `barrier` they race.
///
/// The layers (1.3.239) report reads after writes and writes after reads. They are silent about two dispatches that
/// both declare the buffer writable.
pub fn two_dispatches(lab: &Lab, barrier: bool) -> Result<()> {
    let make = |name, bytes| Buffer::storage(&lab.gpu, name, bytes, vk::BufferUsageFlags::empty());
    let (counters, values, histogram) =
        (make("counters", size_of::<Counters>() as u64)?, make("values", 4096)?, make("histogram", 4096)?);
    clear(lab, &[&counters, &values, &histogram])?;
    let [c, v, h] = [&counters, &values, &histogram].map(Binding::Storage);
    let scan = Compute::new(&lab.gpu, "sort_scan", spirv!("engine/sort_scan.comp"), &[c, v], &[BLOCK], 4)?;
    let count = Compute::new(&lab.gpu, "sort_count", spirv!("engine/sort_count.comp"), &[c, v, h], &[BLOCK], 4)?;
    lab.submit(|cmd| {
        scan.dispatch(cmd, &16u32, [1, 1, 1]);
        if barrier {
            sync::barrier(&lab.gpu.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        }
        count.dispatch(cmd, &0u32, [1, 1, 1]);
    })?;
    Ok(())
}

/// Makes a buffer of no bytes, which is not allowed, and frees it.
pub fn empty_buffer(lab: &Lab) {
    let info = vk::BufferCreateInfo::default().size(0).usage(vk::BufferUsageFlags::STORAGE_BUFFER);
    // SAFETY: validation reports the size; the buffer is never used
    unsafe {
        if let Ok(buffer) = lab.gpu.device.create_buffer(&info, None) {
            lab.gpu.device.destroy_buffer(buffer, None);
        }
    }
}
