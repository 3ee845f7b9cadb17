//! What a host chooses about the engine.

use crate::Error;
use crate::engine::constants::FACES;
use crate::engine::lights::MAX_LIGHTS;

/// How the footprint of a pixel becomes a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LevelRule {
    /// log2 of the square root of the footprint's area (Lefohn et al. 2007, section 4).
    Area,
    /// log2 of the shorter of the footprint's two sides.
    MinLength,
}

/// How the pages that pixels ask for become a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RequestRoute {
    /// Append, radix sort, compact: the route of the sources (Lefohn et al. 2007).
    Sort,
    /// Flag each page in the (hashed) page table at once.
    Flags,
}

/// Which pages give way when the atlas does not hold all that are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pressure {
    /// Those whose samples gain least per page, counting how far each is from its wish (Fernando 2002, section 2.4).
    Demand = 0,
    /// Those that the fewest samples ask for, however far from their wish (FVSM's histogram, Giegl and Wimmer 2007).
    Histogram = 1,
    /// Those of the finest levels everywhere: a bias for the whole image.
    Level = 2,
}

/// Sides of casters that are left out of the shadow map, by the winding of their triangles (counter-clockwise is front).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cull {
    /// Both sides cast.
    None = 0,
    /// Sides turned away from the light do not cast.
    Back = 1,
    /// Sides turned to the light do not cast.
    Front = 2,
}

/// How the casters at the texels around a receiver decide how much of the light it sees. Kernels are `taps` texels of the
/// serving page across, 2 to 9 (percentage-closer filtering, Reeves et al. 1987; book, 5.1.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Lit or shadowed: the edge is the line that parts the lit of the 4 x 4 nearest texels from the dark.
    Hard,
    /// The share of the `taps` x `taps` nearest texels.
    Pcf {
        /// Texels along a side.
        taps: u32,
    },
    /// The share of 16 to 32 points of a disc, turned by a hash of the pixel.
    Poisson {
        /// Diameter in texels.
        taps: u32,
    },
    /// The mean of `taps` x `taps` bilinear lookups.
    Bilinear {
        /// Lookups along a side, a texel apart.
        taps: u32,
    },
}

impl Filter {
    /// The constants FILTER and TAPS of the shaders.
    pub(crate) fn words(self) -> [u32; 2] {
        match self {
            Filter::Hard => [0, 1],
            Filter::Pcf { taps } => [1, taps],
            Filter::Poisson { taps } => [2, taps],
            Filter::Bilinear { taps } => [3, taps],
        }
    }

    /// Whether looking at a layer's depth range first pays: kernels of 9 texels take half the time on lavapipe, those of 4
    /// do not gain.
    pub(crate) fn ranged(self) -> bool {
        self.words()[1] > 4
    }

    /// Factor on the depth bias: half the width of the kernel in texels, since a surface that meets the receiver's plane in a
    /// concave edge rises above it in proportion.
    pub(crate) fn bias(self) -> f32 {
        0.5 * self.words()[1].max(2) as f32
    }

    /// Texels around a receiver's own that are read: the least gutter.
    pub fn reach(self) -> u32 {
        if self == Filter::Hard { 2 } else { self.words()[1].div_ceil(2) }
    }
}

/// Bytes of the page table for each distinct page asked for: four slots of key, entry and node.
const REQUEST_BYTES: u64 = 4 * (8 + 4 + size_of::<crate::gpu::structs::Node>() as u64);

/// Rise of a surface above the plane of a pixel's middle, over the way from there, that samples bear.
pub(crate) const BEND: f32 = 0.2;

/// Most pairs of a frame.
pub(crate) const MAX_PAIRS: u32 = 1 << 21;

/// Where the samples of a pixel lie, right of and below its middle, in pixels: Hammersley's points, no two in a row or a column,
/// so that edges of any direction give all shares. The same in all pixels: turned ones would trade steps that follow an edge for
/// noise. `samples`: a power of two, 1 to 65536; others give the places of the next.
pub fn sample_places(samples: u32) -> Vec<[f64; 2]> {
    let count = samples.clamp(1, 65536).next_power_of_two();
    let least = 0.5 / f64::from(count) - 0.5;
    let place = |i: u32| {
        let mirrored = f64::from(i.reverse_bits()) / 4_294_967_296.0;
        [f64::from(i) / f64::from(count) + least, mirrored + least]
    };
    (0..count).map(place).collect()
}

/// Checks a width and height in pixels.
pub(crate) fn check_size(field: &'static str, given: [u32; 2], most: [u32; 2]) -> Result<(), Error> {
    if (0..2).all(|side| (1..=most[side]).contains(&given[side])) {
        return Ok(());
    }
    let [given, most] = [given, most].map(|[w, h]| format!("{w}x{h}"));
    Err(Error::Limit { field, given, limit: format!("1x1 to {most} pixels") })
}

/// Plain data; every field is checked when the engine is made.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Width and height in pixels that no view ever exceeds, 1 to 16384 each; every view has its own size
    /// ([`crate::host::Receivers::size`]), which [`crate::Engine::resize`] changes.
    pub size: [u32; 2],
    /// Device memory for the physical atlas, in bytes: one layer of `page_texels`^2 texels of 4 bytes a page.
    /// Default: 64 MiB.
    pub atlas_bytes: u64,
    /// Side of a page in texels: 64, 128, 256 or 512.
    /// Default: 128.
    pub page_texels: u32,
    /// Texels along each side of a page that repeat its neighbours, for filters; 1 to 8, at least [`Filter::reach`].
    /// Default: 2.
    pub gutter: u32,
    /// Finest level that pixels may ask for, relative to one texel a pixel: -1 is half a pixel. -8 to 8.
    /// Pages this fine are drawn where the atlas has room; coarser ones serve elsewhere.
    /// Default: -3.
    pub level_bias: f32,
    /// Texels of the virtual map along a side, as a power of two: 15 to 30. What pixels ask for beyond it is served by the
    /// finest level. Beyond 21, stored depths are coarser than texels: in worlds of kilometres casters that rise less than
    /// 1e-6 of the casters' bounds above a surface are lost without [`Config::exact`].
    /// Default: 21.
    pub virtual_bits: u32,
    /// Most lights at a time, 1 to 1365.
    /// Default: 1.
    pub lights: u32,
    /// Bits of a light in the mask: 32 (a float), 8 (fractions of 255) or, without a filter, 1.
    /// Default: 32.
    pub mask_bits: u32,
    /// Whether pixels that the map cannot decide are decided by rays against the casters; without a filter only.
    /// Default: false.
    pub exact: bool,
    /// Whether rays are traced by ray queries where [`crate::gpu::HostDevice::ray_query`] and
    /// [`crate::host::SceneBuffers::shapes`] allow it. Else, and without them, they walk through a tree of the engine's
    /// own, which takes about 27 bytes a triangle and decides the same but for rays that graze an edge by a few roundings.
    /// Default: true.
    pub ray_query: bool,
    /// Samples a pixel with [`Config::exact`]: 1, 4, 8 or 16. Visibility is the share of them that the light reaches, so
    /// that edges are antialiased (frustum-traced shadows, Wyman, Hoetzlein and Lefohn 2015, with points in place of the
    /// frustum). They lie on the receiver's plane under the pixel, see [`sample_places`]. More than one needs 8 or 32 bits of
    /// the mask. A view has room for one ray a pixel, or a quarter of its samples if these are more (44 bytes a ray); beyond
    /// that the map decides.
    /// Default: 1.
    pub samples: u32,
    /// What the lookup makes of the casters around a receiver.
    /// Default: [`Filter::Hard`].
    pub filter: Filter,
    /// Whether filtered visibility changes smoothly from level to level; the coarser pages are asked for too. It does so where
    /// pixels get the pages that they ask for, with a [`Config::level_bias`] near 0; where coarser ones serve, levels change
    /// from page to page as without. Half of the pixels see texels twice as large in part, and the coarser pages take room in
    /// the atlas: where that is full, edges err by up to a thirtieth more.
    /// Default: false.
    pub level_blend: bool,
    /// Sides of casters that are left out; off by default, since shadow truth is geometric.
    /// Default: [`Cull::None`].
    pub cull: Cull,
    /// The level rule.
    /// Default: [`LevelRule::Area`].
    pub level_rule: LevelRule,
    /// The route from pixels to the list of pages. Both give the same pages. The sort's list has room for 64 requests from
    /// each 8x8 pixels: it takes at most 16 lights.
    /// Default: [`RequestRoute::Flags`].
    pub route: RequestRoute,
    /// Which pages give way when the atlas is full.
    /// Default: [`Pressure::Demand`].
    pub pressure: Pressure,
    /// Device memory for the page table, in bytes: [`Config::table_bytes`] of a power of two from 1024 to 131072 distinct
    /// pages that pixels may ask for; beyond them all requests are coarsened.
    /// Default: that of 32768.
    pub page_table_bytes: u64,
    /// Share of the atlas, in percent, that a frame leaves to pages of earlier frames; 0 to 50. A small one keeps pages that
    /// come and go with a pixel's jitter from being drawn again and again.
    /// Default: 10.
    pub spare_percent: u32,
    /// Most layers of the atlas drawn in a frame, 16 to 4096. A page that moving casters touch has two layers. What is put
    /// off is served by coarser pages meanwhile.
    /// Default: 192.
    pub pages_per_frame: u32,
    /// The same for frames in which the light turned, 16 to 4096; the lesser of the two holds. A turning light makes coarse
    /// pages with many casters be drawn, which cost more than the few fine ones that a moving camera asks for.
    /// Default: 96.
    pub sun_pages_per_frame: u32,
    /// Most (cluster, page) pairs drawn in a frame, 1024 to 2097152; beyond it coarser pages serve. At least
    /// [`Config::least_pairs`]. 44 bytes a pair, twice.
    /// Default: 131072.
    pub pair_capacity: u32,
    /// What drawing a page costs beside its pairs, as a number of pairs: the constant part of the cost by which pages are
    /// served. 0 to 1024.
    /// Default: 16.
    pub page_cost: u32,
    /// Frames without a change after which a caster of policy [`crate::CastPolicy::Auto`] is cached again; 1 to 10000.
    /// Default: 16.
    pub still_frames: u32,
    /// Texels of the page that serves by which cached shadows may be off while the light turns; 0 to 16. The bound holds for
    /// the casters farthest from the origin; others are off by less. Such pages are looked up with as much more depth bias.
    /// Once the light rests, all pages are exact again within 32 frames. At 0 every turn of the light draws all pages anew.
    /// Default: 0.5.
    pub drift_texels: f32,
    /// Frames of which [`crate::Engine::counters`] are kept, 1 to 16: as many as the host has in flight before it asks.
    /// Default: 3.
    pub frames_in_flight: u32,
    /// Whether pages are kept from frame to frame. Without it every frame draws what it needs, without a limit of pages.
    /// Default: true.
    pub cache: bool,
    /// GPU time in milliseconds towards which [`crate::Engine::steer`] steers pages per frame and level bias; 0: none.
    /// Default: 0.
    pub target_ms: f32,
    /// Room for the indices of culled clusters, 0 to 31457280: four bytes each at the end of [`crate::SceneBuffers::indices`].
    /// Beyond it whole clusters are drawn, which is slower and right; [`crate::Counters::indices`] tells how many a frame asked for.
    /// Default: 6291456.
    pub index_capacity: u32,
    /// Threads that cull the triangles of one (cluster, page) pair: a power of two, 8 to 128. On GPUs 64; a CPU driver
    /// such as lavapipe pays for each thread of a group and is fastest at 16.
    /// Default: 64.
    pub cull_group: u32,
    /// Depth bias beyond the receiver plane's: this times (a texel of the page plus a quarter of the receiver's depth
    /// change across it); with a filter also times half its taps. 0 to 16.
    /// Default: 1.
    pub bias_texels: f32,
}

impl Config {
    /// The defaults for an image size.
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            atlas_bytes: 64 << 20,
            page_texels: 128,
            gutter: 2,
            level_bias: -3.0,
            virtual_bits: 21,
            lights: 1,
            mask_bits: 32,
            exact: false,
            ray_query: true,
            samples: 1,
            filter: Filter::Hard,
            level_blend: false,
            cull: Cull::None,
            level_rule: LevelRule::Area,
            route: RequestRoute::Flags,
            pressure: Pressure::Demand,
            page_table_bytes: Self::table_bytes(32768),
            spare_percent: 10,
            pages_per_frame: 192,
            sun_pages_per_frame: 96,
            pair_capacity: 131_072,
            page_cost: 16,
            still_frames: 16,
            drift_texels: 0.5,
            frames_in_flight: 3,
            cache: true,
            target_ms: 0.0,
            index_capacity: 6 << 20,
            cull_group: 64,
            bias_texels: 1.0,
        }
    }

    /// The least `pair_capacity` for a number of casters: twice as many, so that any page with its moving casters can be
    /// drawn. Scenes of more than 1,048,576 casters get the most that is allowed.
    pub fn least_pairs(casters: u32) -> u32 {
        casters.saturating_mul(2).min(MAX_PAIRS)
    }

    /// Texels of a page's side without gutters.
    pub(crate) fn interior(&self) -> u32 {
        self.page_texels - 2 * self.gutter
    }

    /// The level at which the whole face would have 2^`virtual_bits` texels a side, gutters included.
    pub(crate) fn finest_level(&self) -> i32 {
        (crate::engine::constants::ROOT_LEVEL + self.page_texels.ilog2() as i32 - self.virtual_bits as i32).max(0)
    }

    /// Layers of the mask: 32-bit words a pixel.
    pub(crate) fn mask_layers(&self) -> u32 {
        (self.lights * self.mask_bits).div_ceil(32)
    }

    /// Pages the atlas holds.
    pub fn page_capacity(&self) -> u32 {
        (self.atlas_bytes / (4 * u64::from(self.page_texels).pow(2))).min(u64::from(u32::MAX)) as u32
    }

    /// Layers of the atlas that one frame's pages may take.
    pub(crate) fn chosen_layers(&self) -> u32 {
        let pages = u64::from(self.page_capacity());
        (pages - pages * u64::from(self.spare_percent) / 100) as u32
    }

    /// Bytes of a page table for so many distinct pages that pixels may ask for.
    pub const fn table_bytes(requests: u32) -> u64 {
        requests as u64 * REQUEST_BYTES
    }

    /// Distinct pages that pixels may ask for: what the page table's memory allows.
    pub fn request_capacity(&self) -> u32 {
        let fitting = (self.page_table_bytes / REQUEST_BYTES).clamp(1, 1 << 20);
        1 << fitting.ilog2()
    }

    /// Entries of the page table. Requests and their ancestors fill less than a third of it in ordinary views; requests so
    /// sparse that they fill it (none shares an ancestor below level 4) are served by coarser pages and counted.
    pub(crate) fn table_size(&self) -> u32 {
        4 * self.request_capacity()
    }

    /// Nodes of the quadtree that are listed: as many as the table holds.
    pub(crate) fn node_capacity(&self) -> u32 {
        self.table_size()
    }

    /// A pixel that is d levels short of its wish weighs 2^d, d at most this, so that the weights of all pixels fit 31 bits.
    /// `pixels`: of all views, each of which asks for two pages where levels blend.
    #[doc(hidden)]
    pub fn weight_bits(&self, pixels: u64) -> u32 {
        if self.pressure == Pressure::Histogram {
            return 0;
        }
        30u32.saturating_sub((pixels << u32::from(self.level_blend)).max(1).ilog2()).min(10)
    }

    /// Checks every field; `max_layers` is what the device allows in one array image.
    pub(crate) fn check(&self, max_layers: u32) -> Result<(), Error> {
        fn limit<T: std::fmt::Display>(ok: bool, field: &'static str, given: T, limit: String) -> Result<(), Error> {
            if ok { Ok(()) } else { Err(Error::Limit { field, given: given.to_string(), limit }) }
        }
        check_size("size", self.size, [16384; 2])?;
        let texels = self.page_texels;
        limit(matches!(texels, 64 | 128 | 256 | 512), "page_texels", texels, "64, 128, 256 or 512".into())?;
        let (hard, reach) = (self.filter == Filter::Hard, self.filter.reach());
        let taps = self.filter.words()[1];
        limit(hard || (2..=9).contains(&taps), "filter", taps, "2 to 9 taps".into())?;
        limit(
            (reach..=8).contains(&self.gutter),
            "gutter",
            self.gutter,
            format!("{reach} to 8 texels with this filter"),
        )?;
        let page_bytes = 4 * u64::from(texels).pow(2);
        limit(
            (16..=u64::from(max_layers)).contains(&(self.atlas_bytes / page_bytes)),
            "atlas_bytes",
            self.atlas_bytes,
            format!(
                "{} to {} bytes (16 to {max_layers} pages of {texels}x{texels} texels)",
                16 * page_bytes,
                u64::from(max_layers) * page_bytes
            ),
        )?;
        limit((15..=30).contains(&self.virtual_bits), "virtual_bits", self.virtual_bits, "15 to 30".into())?;
        limit((1..=MAX_LIGHTS).contains(&self.lights), "lights", self.lights, format!("1 to {MAX_LIGHTS}"))?;
        let sorted = self.route == RequestRoute::Flags || self.lights <= 16;
        limit(sorted, "lights", self.lights, "at most 16 with the sort route".into())?;
        limit(
            self.mask_layers() <= max_layers,
            "mask_bits",
            self.mask_bits,
            format!("at most {max_layers} layers of the mask, not {} for {} lights", self.mask_layers(), self.lights),
        )?;
        let binary = hard && self.samples == 1;
        let bits = if binary { "1, 8 or 32" } else { "8 or 32 with a filter or with several samples a pixel" };
        limit(
            matches!(self.mask_bits, 8 | 32) || binary && self.mask_bits == 1,
            "mask_bits",
            self.mask_bits,
            bits.into(),
        )?;
        limit(hard || !self.exact, "exact", self.exact, "false with a filter".into())?;
        limit(
            self.samples == 1 || self.exact && matches!(self.samples, 4 | 8 | 16),
            "samples",
            self.samples,
            if self.exact { "1, 4, 8 or 16" } else { "1 without `exact`" }.into(),
        )?;
        limit(!(hard && self.level_blend), "level_blend", self.level_blend, "false without a filter".into())?;
        limit((-8.0..=8.0).contains(&self.level_bias), "level_bias", self.level_bias, "-8 to 8".into())?;
        limit((0.0..=16.0).contains(&self.bias_texels), "bias_texels", self.bias_texels, "0 to 16".into())?;
        let group = self.cull_group;
        limit(
            group.is_power_of_two() && (8..=128).contains(&group),
            "cull_group",
            group,
            "a power of two from 8 to 128".into(),
        )?;
        limit(
            (1024..=131_072).contains(&(self.page_table_bytes / REQUEST_BYTES)),
            "page_table_bytes",
            self.page_table_bytes,
            format!("{} to {} bytes", Self::table_bytes(1024), Self::table_bytes(131_072)),
        )?;
        limit(
            FACES * self.lights <= self.request_capacity(),
            "page_table_bytes",
            self.page_table_bytes,
            format!("a page for each of the faces of {} lights, {FACES} each", self.lights),
        )?;
        limit(self.spare_percent <= 50, "spare_percent", self.spare_percent, "0 to 50 percent".into())?;
        limit(
            (16..=4096).contains(&self.pages_per_frame),
            "pages_per_frame",
            self.pages_per_frame,
            "16 to 4096".into(),
        )?;
        let sun = self.sun_pages_per_frame;
        limit((16..=4096).contains(&sun), "sun_pages_per_frame", sun, "16 to 4096".into())?;
        limit(self.page_cost <= 1024, "page_cost", self.page_cost, "0 to 1024 pairs".into())?;
        limit((1..=10_000).contains(&self.still_frames), "still_frames", self.still_frames, "1 to 10000".into())?;
        limit((1..=16).contains(&self.frames_in_flight), "frames_in_flight", self.frames_in_flight, "1 to 16".into())?;
        limit((0.0..=1e6).contains(&self.target_ms), "target_ms", self.target_ms, "0 to 1000000".into())?;
        limit((0.0..=16.0).contains(&self.drift_texels), "drift_texels", self.drift_texels, "0 to 16".into())?;
        limit(
            (1024..=MAX_PAIRS).contains(&self.pair_capacity),
            "pair_capacity",
            self.pair_capacity,
            format!("1024 to {MAX_PAIRS}"),
        )?;
        limit(
            (0..=30 << 20).contains(&self.index_capacity),
            "index_capacity",
            self.index_capacity,
            "0 to 31457280".into(),
        )
    }
}
