//! The engine itself behind the method trait: resolution-matched shadow maps (Lefohn et al. 2007; book, 4.4.2).

use super::rmsm_pages::RmsmPages;
use super::{
    DebugPicture, FrameTimes, LevelStatistics, Masks, Method, MethodInfo, MethodSpec, PageViews, Parameter, Sampling,
    Statistics, comparison, rmsm_pictures, rmsm_sampling,
};
use crate::engine::constants::ROOT_LEVEL;
use crate::engine::{Engine, LightId};
use crate::gpu::sync::Access;
use crate::lab::{Lab, LabError};
use crate::{Config, Error, Filter, LevelRule, Pressure, RequestRoute};

const PARAMETERS: &[Parameter] = &[
    Parameter {
        key: "atlas_mib",
        default: "64",
        allowed: "1 to 1024, 8 to 2048 pages",
        meaning: "device memory of the atlas in MiB",
    },
    Parameter {
        key: "bias",
        default: "-3",
        allowed: "-8 to 8",
        meaning: "finest level allowed, relative to one texel a pixel",
    },
    Parameter { key: "level", default: "area", allowed: "area or min_length", meaning: "level rule" },
    Parameter { key: "requests", default: "flags", allowed: "sort or flags", meaning: "route from pixels to pages" },
    Parameter { key: "page", default: "128", allowed: "64, 128, 256 or 512", meaning: "side of a page in texels" },
    Parameter {
        key: "gutter",
        default: "auto",
        allowed: "auto or 1 to 8",
        meaning: "border of a page in texels, at least auto: what the filter reads, 2 without one",
    },
    Parameter {
        key: "virtual",
        default: "21",
        allowed: "15 to 30",
        meaning: "texels of the virtual map along a side, as a power of two",
    },
    Parameter {
        key: "exact",
        default: "false",
        allowed: "true or false",
        meaning: "whether pixels that the map cannot decide are decided by rays against the casters",
    },
    Parameter {
        key: "rays",
        default: "auto",
        allowed: "auto, query or tree",
        meaning: "with exact=true: by ray queries or through the engine's own tree; auto: queries where a GPU has them",
    },
    Parameter {
        key: "samples",
        default: "1",
        allowed: "1, 4, 8 or 16; 1 without exact=true",
        meaning: "samples a pixel: visibility is the share of them that the light reaches",
    },
    comparison::DEPTH_BIAS,
    comparison::CULL,
    comparison::FILTER[0],
    comparison::FILTER[1],
    Parameter {
        key: "blend",
        default: "false",
        allowed: "true or false",
        meaning: "whether filtered shadows change smoothly from level to level, where bias is near 0 and the atlas has room",
    },
    Parameter {
        key: "pressure",
        default: "demand",
        allowed: "demand, histogram or level",
        meaning: "which pages give way when the atlas is full",
    },
    Parameter {
        key: "table_kib",
        default: "7680",
        allowed: "240 to 30720",
        meaning: "device memory of the page table in KiB",
    },
    Parameter {
        key: "spare",
        default: "10",
        allowed: "0 to 50",
        meaning: "percent of the atlas that a frame leaves to pages of earlier frames",
    },
    Parameter {
        key: "pages",
        default: "192",
        allowed: "16 to 4096",
        meaning: "most layers of the atlas drawn in a frame",
    },
    Parameter {
        key: "sun_pages",
        default: "96",
        allowed: "16 to 4096",
        meaning: "the same for frames in which the sun moved",
    },
    Parameter {
        key: "pairs",
        default: "auto",
        allowed: "auto or 1024 to 2097152, at least 2 for each cluster of the scene",
        meaning: "most (cluster, page) pairs drawn in a frame; auto: 131072 or what the scene needs",
    },
    Parameter {
        key: "cache",
        default: "on",
        allowed: "on or off",
        meaning: "whether pages are kept from frame to frame; off: each frame is a cold one, without a limit of pages",
    },
    Parameter {
        key: "still",
        default: "16",
        allowed: "1 to 10000",
        meaning: "frames after which a caster that stands still is cached",
    },
    Parameter {
        key: "drift",
        default: "0.5",
        allowed: "0 to 16",
        meaning: "texels by which cached shadows of the farthest casters may be off while the sun moves",
    },
    Parameter {
        key: "target_ms",
        default: "0",
        allowed: "0 to 1000000",
        meaning: "GPU time a frame that pages per frame and level bias are steered to; 0: none",
    },
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "rmsm",
    source: "Lefohn, Sengupta, Owens 2007; Eisemann et al. 2011, 4.4.2; order of service: Fernando 2002, 2.4",
    summary: "Resolution-matched pages from virtual maps of 2^21 texels a side, drawn and looked up on the GPU",
    parameters: PARAMETERS,
    check: |spec| config(spec, [1, 1]).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Rmsm::new(spec, lab)?)),
};

pub(super) fn config(spec: &MethodSpec, size: [u32; 2]) -> Result<Config, LabError> {
    let mut config = Config::new(size);
    config.atlas_bytes = u64::from(spec.u32_in("atlas_mib", 64, 1..=1024)?) << 20;
    config.level_bias = spec.f32_in("bias", config.level_bias, -8.0..=8.0)?;
    config.level_rule = match spec.one_of("level", "area", &["area", "min_length"])? {
        "min_length" => LevelRule::MinLength,
        _ => LevelRule::Area,
    };
    config.route = match spec.one_of("requests", "flags", &["sort", "flags"])? {
        "sort" => RequestRoute::Sort,
        _ => RequestRoute::Flags,
    };
    config.page_texels = spec.one_of("page", "128", &["64", "128", "256", "512"])?.parse().unwrap_or(128);
    config.filter = comparison::filter(spec)?;
    config.level_blend = spec.one_of("blend", "false", &["true", "false"])? == "true";
    config.gutter = if spec.is_auto("gutter") { config.filter.reach() } else { spec.u32_in("gutter", 2, 1..=8)? };
    config.exact = spec.one_of("exact", "false", &["true", "false"])? == "true";
    config.ray_query = spec.one_of("rays", "auto", &["auto", "query", "tree"])? != "tree";
    config.samples = spec.one_of("samples", "1", &["1", "4", "8", "16"])?.parse().unwrap_or(1);
    config.virtual_bits = spec.u32_in("virtual", config.virtual_bits, 15..=30)?;
    config.bias_texels = spec.f32_in("depth_bias", config.bias_texels, 0.0..=16.0)?;
    config.cull = comparison::cull(spec)?;
    config.pressure = match spec.one_of("pressure", "demand", &["demand", "histogram", "level"])? {
        "histogram" => Pressure::Histogram,
        "level" => Pressure::Level,
        _ => Pressure::Demand,
    };
    config.page_table_bytes =
        u64::from(spec.u32_in("table_kib", (config.page_table_bytes >> 10) as u32, 240..=30720)?) << 10;
    config.spare_percent = spec.u32_in("spare", config.spare_percent, 0..=50)?;
    config.pages_per_frame = spec.u32_in("pages", config.pages_per_frame, 16..=4096)?;
    config.sun_pages_per_frame = spec.u32_in("sun_pages", config.sun_pages_per_frame, 16..=4096)?;
    if !spec.is_auto("pairs") {
        config.pair_capacity = spec.u32_in("pairs", config.pair_capacity, 1024..=1 << 21)?;
    }
    config.cache = spec.one_of("cache", "on", &["on", "off"])? == "on";
    config.still_frames = spec.u32_in("still", config.still_frames, 1..=10_000)?;
    config.drift_texels = spec.f32_in("drift", config.drift_texels, 0.0..=16.0)?;
    config.target_ms = spec.f32_in("target_ms", config.target_ms, 0.0..=1e6)?;
    Ok(config)
}

/// Lights up to which the mask holds floats.
const FLOAT_MASKS: usize = 4;

pub(super) struct Rmsm {
    engine: Engine,
    lights: Vec<LightId>,
    pages: Option<RmsmPages>,
}

impl Rmsm {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let mut config = config(spec, lab.view().size)?;
        if lab.device_is_cpu() {
            config.cull_group = 16;
            // a CPU traces them in software, and takes twice as long as with the tree
            config.ray_query &= !spec.is_auto("rays");
        }
        if spec.value("rays") == Some("query") && !lab.has_ray_queries() {
            let device = lab.device_name();
            return Err(LabError::Refused(format!(
                "'{spec}' needs ray queries, which device '{device}' does not have"
            )));
        }
        if spec.is_auto("pairs") {
            config.pair_capacity = config.pair_capacity.max(Config::least_pairs(lab.scene_buffers().caster_count));
        }
        let lights = &lab.view().lights;
        config.lights = lights.len() as u32;
        // hard shadows are bits; a few lights are given as floats, which take no unpacking
        let few = lights.len() <= FLOAT_MASKS;
        config.mask_bits = if few {
            32
        } else if config.filter == Filter::Hard && config.samples == 1 {
            1
        } else {
            8
        };
        let mut engine = lab
            .with_receivers(|seen| Engine::on(lab.gpu(), &config, lab.scene_buffers(), &[seen]))
            .map_err(|error| as_typed(error, spec))?;
        let lights = lights.iter().map(|light| engine.add_light(light)).collect::<Result<_, _>>()?;
        Ok(Self { engine, lights, pages: None })
    }
}

/// The atlas' size in the words of the command line.
fn as_typed(error: Error, spec: &MethodSpec) -> LabError {
    match error {
        Error::Limit { field: "atlas_bytes", given, limit } => LabError::Usage(format!(
            "keys 'atlas_mib' and 'page' of '{spec}' make an atlas of {given} bytes, this device allows {limit}"
        )),
        Error::Limit { field: "gutter", given, limit } => {
            LabError::Usage(format!("key 'gutter' of '{spec}' is {given}, allowed is {limit}"))
        }
        Error::Limit { field: "level_blend", .. } => {
            LabError::Usage(format!("key 'blend' of '{spec}' is true, allowed is false where filter is hard"))
        }
        Error::Limit { field: "samples", given, limit } => {
            LabError::Usage(format!("key 'samples' of '{spec}' is {given}, allowed is {limit}"))
        }
        Error::Limit { field: "pair_capacity", given, limit } => {
            LabError::Usage(format!("key 'pairs' of '{spec}' is {given}, this scene needs {limit}"))
        }
        other => other.into(),
    }
}

impl Method for Rmsm {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let lights = &lab.view().lights;
        if lights.len() != self.lights.len() {
            let (now, made) = (lights.len(), self.lights.len());
            return Err(LabError::Refused(format!("the view has {now} lights, the method was made for {made}")));
        }
        for (&id, light) in self.lights.iter().zip(lights) {
            self.engine.set_light(id, light)?;
        }
        let (frame, times) = lab.engine_frame(&mut self.engine)?;
        let tiles_ms = times.stages.iter().filter(|s| matches!(s.0, "cull" | "tiles")).map(|s| s.1).sum();
        self.engine.steer(frame, times.ms, tiles_ms);
        Ok(times)
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        let slot = super::of_light(&self.lights, INFO.name, light)?.slot();
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&lab.read_image(
            &self.engine.views[0].buffers.mask,
            Access::TransferRead,
            4,
        )?);
        let pixels = words.len() / self.engine.config.mask_layers() as usize;
        let bits = self.engine.config.mask_bits;
        let (layer, shift) = ((slot * bits / 32) as usize, slot * bits % 32);
        let layer = &words[layer * pixels..][..pixels];
        let most = (1u64 << bits) - 1;
        Ok(layer
            .iter()
            .map(|&word| match bits {
                32 => f32::from_bits(word),
                _ => (u64::from(word >> shift) & most) as f32 / most as f32,
            })
            .collect())
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        self.engine.memory()
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let c = self.engine.last_counters();
        let levels = (0..=ROOT_LEVEL as usize)
            .map(|l| LevelStatistics {
                level: l as u32,
                requested: c.requested[l],
                resident: c.resident[l],
                refused: c.refused[l],
            })
            .collect::<Vec<_>>();
        let config = &self.engine.config;
        let finest = levels.iter().find(|l| l.resident > 0).map_or(ROOT_LEVEL as u32, |l| l.level);
        let exact = self.engine.views[0].exact.as_ref();
        let traced = exact.map(|exact| lab.read_buffer(&exact.count)).transpose()?;
        let rays = traced.map_or(0, |bytes| bytemuck::pod_read_unaligned::<u32>(&bytes[..4]));
        Ok(Statistics {
            effective_resolution: f64::from(config.interior()) * f64::from(1u32 << (ROOT_LEVEL as u32 - finest)),
            levels,
            counters: [
                ("requests", c.leaves),
                ("nodes", c.leaves + c.nodes),
                ("failed_insertions", c.failed),
                ("coarsened_levels", c.shift),
                ("pages_requested", c.pages),
                ("pages_hit", c.hits),
                ("pages_stale", c.stale),
                ("pages_serving", c.admitted),
                ("pages_drawn", c.drawn + c.drawn_dynamic),
                ("pages_drawn_dynamic", c.drawn_dynamic),
                ("pages_deferred", c.deferred),
                ("pages_evicted", c.evicted),
                ("pages_invalidated", c.invalidated),
                ("faces", c.active_faces[0]),
                ("faces_starved", c.starved),
                ("rays", rays),
                ("page_capacity", config.page_capacity()),
                ("moving_instances", c.dynamics),
                ("changed_bounds", c.changed),
                ("pairs", c.pairs_asked),
                ("pairs_drawn", c.pairs_opaque + c.pairs_masked),
                ("triangles_drawn", c.triangles),
                ("compacted_indices", c.indices),
            ]
            .map(|(name, value)| (name, u64::from(value)))
            .to_vec(),
        })
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        rmsm_pictures::draw(&self.engine, lab)
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        let light = *super::of_light(&self.lights, INFO.name, light)?;
        rmsm_sampling::sampling(&self.engine, lab, light).map(Some)
    }

    fn masks(&self) -> Option<Masks<'_>> {
        // lights were added in order to an engine without any, so that light i has slot i
        Some(Masks { images: vec![&self.engine.views[0].buffers.mask], bits: self.engine.config.mask_bits })
    }

    fn update_pages(&mut self, lab: &Lab) -> Result<bool, LabError> {
        let pages = match self.pages.take() {
            Some(pages) => pages,
            None => RmsmPages::new(&self.engine, lab)?,
        };
        self.pages.insert(pages).update(&self.engine, lab)?;
        Ok(true)
    }

    fn page_views(&self) -> Option<PageViews<'_>> {
        self.pages.as_ref().map(|pages| pages.views(&self.engine))
    }

    fn frozen_frame(&mut self, lab: &Lab) -> Result<Option<FrameTimes>, LabError> {
        let input = lab.frame_input();
        let mut recorded = Ok(());
        let times = lab.frame(|cmd, timer| recorded = self.engine.record_frozen(cmd, &input, timer))?;
        recorded?;
        Ok(Some(times))
    }
}
