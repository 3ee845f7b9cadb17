//! The configuration as plain data.

use super::guard::{Failure, UmbrageResult, guard};
use super::input::{fill, output, sized, zero};
use super::vulkan::VkBool32;
use crate::{Config, Cull, Filter, LevelRule, Pressure, RequestRoute, sample_places};
use std::ffi::c_char;

/// What the lookup makes of the casters around a receiver: one of UMBRAGE_FILTER_*.
pub type UmbrageFilter = u32;
/// Lit or shadowed.
pub const UMBRAGE_FILTER_HARD: UmbrageFilter = 0;
/// The share of the filter_taps x filter_taps nearest texels.
pub const UMBRAGE_FILTER_PCF: UmbrageFilter = 1;
/// The share of 16 to 32 points of a disc of filter_taps texels, turned by a hash of the pixel.
pub const UMBRAGE_FILTER_POISSON: UmbrageFilter = 2;
/// The mean of filter_taps x filter_taps bilinear lookups, a texel apart.
pub const UMBRAGE_FILTER_BILINEAR: UmbrageFilter = 3;

/// Sides of casters that are left out, by the winding of their triangles (counter-clockwise is front).
pub type UmbrageCull = u32;
/// Both sides cast.
pub const UMBRAGE_CULL_NONE: UmbrageCull = 0;
/// Sides turned away from the light do not cast.
pub const UMBRAGE_CULL_BACK: UmbrageCull = 1;
/// Sides turned to the light do not cast.
pub const UMBRAGE_CULL_FRONT: UmbrageCull = 2;

/// How the footprint of a pixel becomes a level.
pub type UmbrageLevelRule = u32;
/// log2 of the square root of the footprint's area.
pub const UMBRAGE_LEVEL_RULE_AREA: UmbrageLevelRule = 0;
/// log2 of the shorter of the footprint's two sides.
pub const UMBRAGE_LEVEL_RULE_MIN_LENGTH: UmbrageLevelRule = 1;

/// How the pages that pixels ask for become a list; both ways give the same pages.
pub type UmbrageRoute = u32;
/// Flag each page in the page table at once.
pub const UMBRAGE_ROUTE_FLAGS: UmbrageRoute = 0;
/// Append, radix sort, compact; at most 16 lights.
pub const UMBRAGE_ROUTE_SORT: UmbrageRoute = 1;

/// Which pages give way when the atlas does not hold all that are asked for.
pub type UmbragePressure = u32;
/// Those whose samples gain least per page, counting how far each is from its wish.
pub const UMBRAGE_PRESSURE_DEMAND: UmbragePressure = 0;
/// Those that the fewest samples ask for.
pub const UMBRAGE_PRESSURE_HISTOGRAM: UmbragePressure = 1;
/// Those of the finest levels everywhere.
pub const UMBRAGE_PRESSURE_LEVEL: UmbragePressure = 2;

/// What a host chooses about the engine; umbrage_config_default fills it, umbrage_engine_create checks every field.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UmbrageConfig {
    /// sizeof(UmbrageConfig), as umbrage_config_default sets it.
    pub struct_size: usize,
    /// Width in pixels that no view ever exceeds, 1 to 16384.
    pub width: u32,
    /// Height in pixels that no view ever exceeds, 1 to 16384.
    pub height: u32,
    /// Device memory for the atlas: one layer of page_texels^2 texels of 4 bytes a page.
    pub atlas_bytes: u64,
    /// Device memory for the page table: umbrage_table_bytes of a power of two from 1024 to 131072 distinct pages that
    /// pixels may ask for; beyond them all requests are coarsened.
    pub page_table_bytes: u64,
    /// Side of a page in texels: 64, 128, 256 or 512.
    pub page_texels: u32,
    /// Texels along each side of a page that repeat its neighbours, up to 8; at least 2, with a filter half its taps,
    /// rounded up.
    pub gutter: u32,
    /// Finest level that pixels may ask for, relative to one texel a pixel: -1 is half a pixel. -8 to 8.
    pub level_bias: f32,
    /// Texels of the virtual map along a side, as a power of two: 15 to 30. What pixels ask for beyond it is served by
    /// the finest level. Beyond 21, stored depths are coarser than texels.
    pub virtual_bits: u32,
    /// Most lights at a time, 1 to 1365.
    pub lights: u32,
    /// Bits of a light in the mask: 32 (a float), 8 (fractions of 255) or, without a filter, 1.
    pub mask_bits: u32,
    /// Whether pixels that the map cannot decide are decided by rays against the casters; without a filter only.
    pub exact: VkBool32,
    /// Whether rays are traced by ray queries where UmbrageDevice and UmbrageScene allow it, else through a tree of the
    /// engine's own.
    pub ray_query: VkBool32,
    /// Samples a pixel with exact: 1, 4, 8 or 16; more than one needs 8 or 32 bits of the mask.
    pub samples: u32,
    /// What the lookup makes of the casters around a receiver.
    pub filter: UmbrageFilter,
    /// Width of the filter in texels, 2 to 9; without a filter it means nothing.
    pub filter_taps: u32,
    /// Whether filtered visibility changes smoothly from level to level; the coarser pages are asked for too.
    pub level_blend: VkBool32,
    /// Sides of casters that are left out.
    pub cull: UmbrageCull,
    /// The level rule.
    pub level_rule: UmbrageLevelRule,
    /// The route from pixels to the list of pages.
    pub route: UmbrageRoute,
    /// Which pages give way when the atlas is full.
    pub pressure: UmbragePressure,
    /// Share of the atlas, in percent, that a frame leaves to pages of earlier frames; 0 to 50.
    pub spare_percent: u32,
    /// Most layers of the atlas drawn in a frame, 16 to 4096. A page that moving casters touch has two layers. What is
    /// put off is served by coarser pages meanwhile.
    pub pages_per_frame: u32,
    /// The same for frames in which the light turned, 16 to 4096; the lesser of the two holds.
    pub sun_pages_per_frame: u32,
    /// Most (cluster, page) pairs drawn in a frame, 1024 to 2097152; at least umbrage_least_pairs. 44 bytes a pair,
    /// twice.
    pub pair_capacity: u32,
    /// What drawing a page costs beside its pairs, as a number of pairs; 0 to 1024.
    pub page_cost: u32,
    /// Frames without a change after which a caster of policy auto is cached again; 1 to 10000.
    pub still_frames: u32,
    /// Texels of the page that serves by which cached shadows may be off while the light turns; 0 to 16.
    pub drift_texels: f32,
    /// Frames of which umbrage_counters are kept, 1 to 16: as many as the host has in flight before it asks.
    pub frames_in_flight: u32,
    /// Whether pages are kept from frame to frame.
    pub cache: VkBool32,
    /// GPU time in milliseconds towards which umbrage_steer steers; 0: none.
    pub target_ms: f32,
    /// Room for the indices of culled clusters behind the scene's own, 0 to 31457280; beyond it whole clusters are
    /// drawn.
    pub index_capacity: u32,
    /// Threads that cull the triangles of one (cluster, page) pair: a power of two, 8 to 128. On GPUs 64, on CPUs 16.
    pub cull_group: u32,
    /// Depth bias beyond the receiver plane's, in texels of the page; 0 to 16.
    pub bias_texels: f32,
    /// Zero.
    pub reserved: u32,
}

// What is not a field would be a field of a later version with whatever an older caller left there.
#[cfg(target_pointer_width = "64")]
const _: () = assert!(size_of::<UmbrageConfig>() == 8 + 2 * 4 + 2 * 8 + 30 * 4);

/// Bytes that every version of the struct has.
const LEAST: usize = size_of::<UmbrageConfig>();

impl UmbrageConfig {
    fn new(config: &Config) -> Self {
        let flag = |on: bool| VkBool32::from(on);
        let [filter, taps] = config.filter.words();
        Self {
            struct_size: size_of::<Self>(),
            width: config.size[0],
            height: config.size[1],
            atlas_bytes: config.atlas_bytes,
            page_table_bytes: config.page_table_bytes,
            page_texels: config.page_texels,
            gutter: config.gutter,
            level_bias: config.level_bias,
            virtual_bits: config.virtual_bits,
            lights: config.lights,
            mask_bits: config.mask_bits,
            exact: flag(config.exact),
            ray_query: flag(config.ray_query),
            samples: config.samples,
            filter,
            filter_taps: taps.max(2),
            level_blend: flag(config.level_blend),
            cull: config.cull as u32,
            level_rule: match config.level_rule {
                LevelRule::Area => UMBRAGE_LEVEL_RULE_AREA,
                LevelRule::MinLength => UMBRAGE_LEVEL_RULE_MIN_LENGTH,
            },
            route: match config.route {
                RequestRoute::Flags => UMBRAGE_ROUTE_FLAGS,
                RequestRoute::Sort => UMBRAGE_ROUTE_SORT,
            },
            pressure: config.pressure as u32,
            spare_percent: config.spare_percent,
            pages_per_frame: config.pages_per_frame,
            sun_pages_per_frame: config.sun_pages_per_frame,
            pair_capacity: config.pair_capacity,
            page_cost: config.page_cost,
            still_frames: config.still_frames,
            drift_texels: config.drift_texels,
            frames_in_flight: config.frames_in_flight,
            cache: flag(config.cache),
            target_ms: config.target_ms,
            index_capacity: config.index_capacity,
            cull_group: config.cull_group,
            bias_texels: config.bias_texels,
            reserved: 0,
        }
    }

    /// # Safety
    /// Null, or a struct as long as it says of itself.
    #[doc(hidden)]
    pub unsafe fn read(pointer: *const Self) -> Result<Config, Failure> {
        let default = Self::new(&Config::new([1, 1]));
        // SAFETY: the caller vouches for the pointer
        unsafe { sized(pointer, default, LEAST, "the config")? }.config()
    }

    fn config(&self) -> Result<Config, Failure> {
        let taps = self.filter_taps;
        zero(self.reserved)?;
        Ok(Config {
            size: [self.width, self.height],
            atlas_bytes: self.atlas_bytes,
            page_texels: self.page_texels,
            gutter: self.gutter,
            level_bias: self.level_bias,
            virtual_bits: self.virtual_bits,
            lights: self.lights,
            mask_bits: self.mask_bits,
            exact: self.exact != 0,
            ray_query: self.ray_query != 0,
            samples: self.samples,
            filter: match self.filter {
                UMBRAGE_FILTER_HARD => Filter::Hard,
                UMBRAGE_FILTER_PCF => Filter::Pcf { taps },
                UMBRAGE_FILTER_POISSON => Filter::Poisson { taps },
                UMBRAGE_FILTER_BILINEAR => Filter::Bilinear { taps },
                other => return Err(unknown("filter", other, "UMBRAGE_FILTER")),
            },
            level_blend: self.level_blend != 0,
            cull: match self.cull {
                UMBRAGE_CULL_NONE => Cull::None,
                UMBRAGE_CULL_BACK => Cull::Back,
                UMBRAGE_CULL_FRONT => Cull::Front,
                other => return Err(unknown("cull", other, "UMBRAGE_CULL")),
            },
            level_rule: match self.level_rule {
                UMBRAGE_LEVEL_RULE_AREA => LevelRule::Area,
                UMBRAGE_LEVEL_RULE_MIN_LENGTH => LevelRule::MinLength,
                other => return Err(unknown("level_rule", other, "UMBRAGE_LEVEL_RULE")),
            },
            route: match self.route {
                UMBRAGE_ROUTE_FLAGS => RequestRoute::Flags,
                UMBRAGE_ROUTE_SORT => RequestRoute::Sort,
                other => return Err(unknown("route", other, "UMBRAGE_ROUTE")),
            },
            pressure: match self.pressure {
                UMBRAGE_PRESSURE_DEMAND => Pressure::Demand,
                UMBRAGE_PRESSURE_HISTOGRAM => Pressure::Histogram,
                UMBRAGE_PRESSURE_LEVEL => Pressure::Level,
                other => return Err(unknown("pressure", other, "UMBRAGE_PRESSURE")),
            },
            page_table_bytes: self.page_table_bytes,
            spare_percent: self.spare_percent,
            pages_per_frame: self.pages_per_frame,
            sun_pages_per_frame: self.sun_pages_per_frame,
            pair_capacity: self.pair_capacity,
            page_cost: self.page_cost,
            still_frames: self.still_frames,
            drift_texels: self.drift_texels,
            frames_in_flight: self.frames_in_flight,
            cache: self.cache != 0,
            target_ms: self.target_ms,
            index_capacity: self.index_capacity,
            cull_group: self.cull_group,
            bias_texels: self.bias_texels,
        })
    }
}

/// A number that names nothing.
pub(super) fn unknown(field: &'static str, given: u32, constants: &str) -> Failure {
    Failure::limit(field, given, format!("one of {constants}_*"))
}

/// Fills a config with the defaults for an image of so many pixels. struct_size: sizeof(UmbrageConfig).
///
/// # Safety
/// config: room for struct_size bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_config_default(
    config: *mut UmbrageConfig,
    struct_size: usize,
    width: u32,
    height: u32,
) -> UmbrageResult {
    guard(|| {
        let mut default = UmbrageConfig::new(&Config::new([width, height]));
        default.struct_size = struct_size;
        // SAFETY: the caller vouches for the pointer
        unsafe { fill(config, struct_size, &default, LEAST, "the config") }
    })
}

/// The least pair_capacity for a number of casters; see UmbrageScene.
#[unsafe(no_mangle)]
pub extern "C" fn umbrage_least_pairs(casters: u32) -> u32 {
    Config::least_pairs(casters)
}

/// Bytes of a page table for so many distinct pages that pixels may ask for.
#[unsafe(no_mangle)]
pub extern "C" fn umbrage_table_bytes(requests: u32) -> u64 {
    Config::table_bytes(requests)
}

/// Where the samples of a pixel lie, right of and below its middle, in pixels; the same in all pixels. places: room for
/// samples of them, 1, 4, 8 or 16.
///
/// # Safety
/// places: room for as many as samples says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_sample_places(samples: u32, places: *mut [f64; 2]) -> UmbrageResult {
    guard(|| {
        if !matches!(samples, 1 | 4 | 8 | 16) {
            return Err(Failure::limit("samples", samples, "1, 4, 8 or 16"));
        }
        for (i, place) in sample_places(samples).into_iter().enumerate() {
            // SAFETY: the caller vouches for so many
            unsafe { output(places.wrapping_add(i), "places")? }.write(place);
        }
        Ok(())
    })
}

/// Version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn umbrage_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
