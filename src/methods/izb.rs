//! Alias-free shadow maps, irregular z-buffers (Aila, Laine 2004; Johnson et al. 2005; book, 4.5): no texels are compared. The
//! visible samples are put into lists by texel of a grid in light space, casters are drawn conservatively over that grid, and
//! each is tested exactly against the samples of every texel that it touches.

use super::izb_owner::{bare, draw};
use super::map::{self, Fits, Fitted, Given, Screen};
use super::{DebugPicture, FrameTimes, Masks, Method, MethodInfo, MethodSpec, Parameter, Statistics, map_light};
use crate::Light;
use crate::config::BEND;
use crate::engine::constants::ray_start;
use crate::engine::exact::hit_bindings;
use crate::gpu::structs::{Fit, Slices};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Graphics, Image, Shaders, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;

/// The key [`own`].
pub(super) const OWN: Parameter = Parameter {
    key: "own",
    default: "id",
    allowed: "id or offset",
    meaning: "what keeps triangles from shadowing their own samples: their numbers, which takes another camera pass, or the start of rays off the surface alone",
};

/// Whether the triangle under each pixel is found.
pub(super) fn own(spec: &MethodSpec) -> Result<bool, LabError> {
    Ok(spec.one_of(OWN.key, OWN.default, &["id", "offset"])? == "id")
}

const PARAMETERS: &[Parameter] = &[
    Parameter {
        key: "resolution",
        default: "1024",
        allowed: "16 to 4096",
        meaning: "side of the grid in texels, which changes the time but not the image; a cube's grids share the same number of texels",
    },
    Parameter {
        key: "samples",
        default: "1",
        allowed: "1, 4, 8 or 16",
        meaning: "samples a pixel: visibility is the share of them that the light reaches",
    },
    OWN,
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "izb",
    source: "Aila, Laine 2004; Johnson et al. 2005; Sintorn et al. 2008; Eisemann et al. 2011, 4.5",
    summary: "Every visible sample in a list of a light-space grid, tested exactly against the casters drawn over it",
    parameters: PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Izb::new(spec, lab)?)),
};

#[derive(Clone, Copy)]
struct Settings {
    resolution: u32,
    samples: u32,
    /// Whether the triangle under each pixel is found.
    own: bool,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    Ok(Settings {
        resolution: spec.u32_in("resolution", 1024, 16..=4096)?,
        samples: spec.one_of("samples", "1", &["1", "4", "8", "16"])?.parse().unwrap_or(1),
        own: own(spec)?,
    })
}

/// Grid and lists of one light.
struct Grid {
    fitted: Fitted,
    side: u32,
    /// First sample of each list.
    heads: Buffer,
    /// Place and successor of each sample.
    listed: Buffer,
    /// A bit for each sample of a pixel.
    shadowed: Buffer,
    /// What translucent casters hold back of each sample's light, where there are any.
    held_back: Option<Buffer>,
    visibility: Image,
    lists: Compute,
    /// Without and with alpha test, for each layer.
    draws: Vec<[Graphics; 2]>,
    resolve: Compute,
}

impl Grid {
    fn new(spec: &MethodSpec, lab: &Lab, screen: &Screen, light: &Light, settings: Settings) -> Result<Self, LabError> {
        let Settings { resolution, samples, .. } = settings;
        let (gpu, kind, layers) = (lab.gpu(), map_light::kind(light), map_light::layers(light));
        let side = (f64::from(resolution) / f64::from(layers).sqrt()) as u32;
        let [width, height] = lab.view().size;
        let pixels = u64::from(width) * u64::from(height);
        let storage = |name, bytes: u64| {
            let limit = u64::from(gpu.limits.max_storage_buffer_range);
            if bytes > limit {
                return Err(LabError::Refused(format!(
                    "'{spec}': {name} need {bytes} bytes, this device allows {limit}"
                )));
            }
            Ok(Buffer::storage(gpu, name, bytes, vk::BufferUsageFlags::empty())?)
        };
        let heads = storage("heads of lists", 4 * u64::from(layers) * u64::from(side).pow(2))?;
        let listed = storage("listed samples", 16 * pixels * u64::from(samples))?;
        let shadowed = storage("shadowed samples", 4 * pixels)?;
        let translucent = lab.scene().materials.iter().any(|m| m.translucent == 1);
        let held_back = if translucent {
            Some(storage("samples behind translucent casters", 4 * pixels * u64::from(samples))?)
        } else {
            None
        };
        // rounding keeps every sample inside
        let fitted = Fitted::new(lab, screen, kind, [side, layers, layers, 1], 0.0, samples)?;
        let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
        let visibility = map::screen_image(lab, "visibility", vk::Format::R32_SFLOAT, usage)?;
        let own = [Binding::Storage(&heads), Binding::Storage(&listed), Binding::Storage(&shadowed)];
        let (scene, fits, position) = (lab.scene_buffers(), Binding::Storage(&fitted.fits), fitted.position());
        let seen = fitted.samples(screen);
        let lists = [&seen[..], &[fits], &own].concat();
        let drawn = [&[seen[0], seen[3], fits], &hit_bindings(scene)[..], &[Binding::External(scene.indices)], &own];
        let owners = screen.owners();
        let owned = owners.map(|owners| Binding::Sampled(&owners.image)).unwrap_or(seen[2]);
        // without translucent casters the shaders do not read it
        let held = Binding::Storage(held_back.as_ref().unwrap_or(&shadowed));
        let drawn = [&drawn.concat()[..], &[owned, held]].concat();
        let pipeline = |layer: u32, masked: bool| {
            let [stride, offset, format] = scene.position_layout.words();
            let constants = [
                layer,
                position,
                side,
                stride,
                offset,
                format,
                samples,
                u32::from(masked),
                u32::from(owners.is_some()),
                u32::from(translucent),
            ];
            let (vertex, fragment) = (spirv!("methods/izb_casters.vert"), spirv!("methods/izb_casters.frag"));
            let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants: &constants };
            Graphics::new(gpu, "izb_casters", &shaders, &drawn, &bare(scene))
        };
        Ok(Self {
            lists: Compute::new(
                gpu,
                "izb_lists",
                spirv!("methods/izb_lists.comp"),
                &lists,
                &[layers, position, side, 0, 0, 0, 0, 0, 0, samples, BEND.to_bits()],
                0,
            )?,
            draws: (0..layers)
                .map(|l| Ok([pipeline(l, false)?, pipeline(l, true)?]))
                .collect::<Result<_, LabError>>()?,
            resolve: Compute::new(
                gpu,
                "izb_resolve",
                spirv!("methods/izb_resolve.comp"),
                &[seen[0], own[2], Binding::StorageImage(&visibility), held],
                &[samples, u32::from(translucent)],
                0,
            )?,
            fitted,
            side,
            heads,
            listed,
            shadowed,
            held_back,
            visibility,
        })
    }

    fn record(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        let extent = vk::Extent2D { width: self.side, height: self.side };
        for pipelines in &self.draws {
            draw(lab, cmd, extent, vk::RenderingInfo::default(), pipelines, |m| map::casters(lab, m));
        }
    }

    /// Samples in each list of the last frame, by layer, row and texel.
    fn lengths(&self, lab: &Lab) -> Result<Vec<u32>, LabError> {
        let gpu = lab.gpu();
        let count = (self.heads.size / 4) as u32;
        let lengths = Buffer::storage(gpu, "lengths of lists", self.heads.size, vk::BufferUsageFlags::empty())?;
        let bindings = [&self.heads, &self.listed, &lengths].map(Binding::Storage);
        let pass = Compute::new(gpu, "izb_lengths", spirv!("methods/izb_lengths.comp"), &bindings, &[count], 0)?;
        lab.submit(|cmd| pass.dispatch(cmd, &(), [1024, count.div_ceil(64 * 1024), 1]))?;
        Ok(bytemuck::pod_collect_to_vec(&lab.read_buffer(&lengths)?))
    }
}

impl Fits for Grid {
    fn fitted(&self) -> &Fitted {
        &self.fitted
    }
}

pub(super) struct Izb {
    screen: Screen,
    /// One for each light.
    grids: Vec<Grid>,
}

impl Izb {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let settings = settings(spec)?;
        super::fragment_stores(spec, lab)?;
        let screen = if settings.own { Screen::with_owners(lab)? } else { Screen::new(lab)? };
        let lights = lab.view().lights.iter();
        let grids = lights.map(|light| Grid::new(spec, lab, &screen, light, settings)).collect::<Result<_, _>>()?;
        Ok(Self { screen, grids })
    }
}

impl Method for Izb {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        use Access::*;
        map::check_lights(lab, &self.grids)?;
        let given = |light: &Light| {
            Ok(Given { light: map_light::constants(light, lab, 0.0)?, fits: None, slices: Slices::zeroed() })
        };
        let given = lab.view().lights.iter().map(given).collect::<Result<Vec<_>, LabError>>()?;
        let mut camera = lab.camera_constants()?;
        camera.rule[3] = ray_start(lab.scene_buffers());
        let device = &lab.gpu().device;
        let [width, height] = lab.view().size;
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        let steps = |step, cmd, _: &mut Timer| match step {
            map::Step::Reset => self.grids.iter().for_each(|grid| {
                // SAFETY: the command buffer is recording; the map's own commands wait for the last frame and for this
                unsafe {
                    device.cmd_fill_buffer(cmd, grid.heads.raw, 0, vk::WHOLE_SIZE, 0);
                    if let Some(held_back) = &grid.held_back {
                        device.cmd_fill_buffer(cmd, held_back.raw, 0, vk::WHOLE_SIZE, 0);
                    }
                }
            }),
            map::Step::Slice | map::Step::Fitted | map::Step::Warp => {}
        };
        lab.frame(|cmd, timer| {
            map::record_fits((lab, &camera), (cmd, timer), &self.screen, &self.grids, &given, steps);
            self.grids.iter().for_each(|grid| grid.lists.dispatch(cmd, &(), groups));
            sync::barrier(device, cmd, &[(ComputeWrite, FragmentWrite)]);
            timer.mark(cmd, "lists");
            self.grids.iter().for_each(|grid| grid.record(lab, cmd));
            sync::barrier(device, cmd, &[(FragmentWrite, ComputeWrite)]);
            timer.mark(cmd, "casters");
            for grid in &self.grids {
                sync::discard(device, cmd, &grid.visibility, TransferRead, StorageImage);
                grid.resolve.dispatch(cmd, &(), groups);
                sync::image(device, cmd, &grid.visibility, StorageImage, TransferRead);
            }
            timer.mark(cmd, "resolve");
        })
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        let grid = super::of_light(&self.grids, INFO.name, light)?;
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&grid.visibility, Access::TransferRead, 4)?))
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(Masks { images: self.grids.iter().map(|grid| &grid.visibility).collect(), bits: 32 })
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let sum = |bytes: fn(&Grid) -> u64| self.grids.iter().map(bytes).sum::<u64>();
        vec![
            (
                "lists",
                sum(|g| {
                    g.heads.size + g.listed.size + g.shadowed.size + g.held_back.as_ref().map_or(0, |held| held.size)
                }),
            ),
            ("screen", self.screen.bytes() + sum(|g| g.visibility.bytes)),
            ("other", self.screen.frame.size + sum(|g| g.fitted.bytes())),
        ]
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut outside = 0;
        let mut lengths = Vec::new();
        for grid in &self.grids {
            outside += grid.fitted.outside(lab)?;
            lengths.extend(grid.lengths(lab)?);
        }
        let counters = vec![
            ("samples", lengths.iter().map(|&n| u64::from(n)).sum()),
            ("lists", lengths.iter().filter(|&&n| n > 0).count() as u64),
            ("longest_list", lengths.iter().copied().max().unwrap_or(0).into()),
            ("outside", outside),
        ];
        Ok(Statistics { counters, ..Statistics::default() })
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        let Some(grid) = self.grids.first() else { return Ok(Vec::new()) };
        let lengths = grid.lengths(lab)?;
        let level = |n: &u32| if *n == 0 { f32::NAN } else { (*n as f32).log2() };
        let values: Vec<f32> = lengths.iter().map(level).collect();
        let picture = crate::output::levels(grid.side, (values.len() / grid.side as usize) as u32, &values)
            .map_err(|error| LabError::Refused(error.to_string()))?;
        Ok(vec![DebugPicture { name: "list_length", width: picture.width, height: picture.height, rgb: picture.rgb }])
    }
}

/// What the lists of a directional light held after one frame, for tests.
#[doc(hidden)]
pub struct Lists {
    /// Texels along a side of the grid.
    pub side: u32,
    /// Where the grid lies.
    pub fit: Fit,
    /// Axes of light space, relative to the eye.
    pub axes: [[f32; 3]; 3],
    /// By row and texel: numbers and places of the samples.
    pub lists: Vec<Vec<(u32, [f32; 3])>>,
    /// By pixel: a bit for each sample that the light does not reach.
    pub shadowed: Vec<u32>,
}

/// Runs one frame and reads the lists of its first light.
///
/// # Errors
/// As [`super::create`].
#[doc(hidden)]
pub fn lists(spec: &MethodSpec, lab: &Lab) -> Result<Lists, LabError> {
    let mut method = Izb::new(spec, lab)?;
    method.frame(lab)?;
    let grid = &method.grids[0];
    let words = |buffer| -> Result<Vec<u32>, LabError> { Ok(bytemuck::pod_collect_to_vec(&lab.read_buffer(buffer)?)) };
    let listed: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&grid.listed)?);
    let list = |&head: &u32| {
        let next = |&number: &u32| Some(listed[number as usize - 1][3]).filter(|&next| next != 0);
        let numbers = std::iter::successors(Some(head).filter(|&head| head != 0), next).take(listed.len() + 1);
        let place = |number: u32| [0, 1, 2].map(|axis| f32::from_bits(listed[number as usize - 1][axis]));
        numbers.map(|number| (number - 1, place(number))).collect()
    };
    let face = map_light::constants(lab.light(0)?, lab, 0.0)?.faces[0];
    Ok(Lists {
        side: grid.side,
        fit: bytemuck::pod_read_unaligned(&lab.read_buffer(&grid.fitted.fits)?[..size_of::<Fit>()]),
        axes: [face.x, face.y, face.z].map(|axis| [axis[0], axis[1], axis[2]]),
        lists: words(&grid.heads)?.iter().map(list).collect(),
        shadowed: words(&grid.shadowed)?,
    })
}
