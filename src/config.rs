//! What a host chooses about the engine.

use crate::Error;

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

/// Plain data; every field is checked when the engine is made.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Image size in pixels, 1 to 16384 each.
    pub size: [u32; 2],
    /// Device memory for the physical atlas, in bytes: one layer of `page_texels`^2 texels of 4 bytes a page.
    pub atlas_bytes: u64,
    /// Side of a page in texels: 64, 128, 256 or 512.
    pub page_texels: u32,
    /// Texels along each side of a page that repeat its neighbours, for filters; 1 to 8: the lookup needs one.
    pub gutter: u32,
    /// Finest level that pixels may ask for, relative to one texel a pixel: -1 is half a pixel. -8 to 8.
    /// Pages this fine are drawn where the atlas has room; coarser ones serve elsewhere.
    pub level_bias: f32,
    /// Sides of casters that are left out; off by default, since shadow truth is geometric.
    pub cull: Cull,
    /// The level rule.
    pub level_rule: LevelRule,
    /// The route from pixels to the list of pages. Both give the same pages.
    pub route: RequestRoute,
    /// Most distinct pages that pixels may ask for; beyond it all requests are coarsened. A power of two, 1024 to 65536.
    pub request_capacity: u32,
    /// Most (cluster, page) pairs drawn in a frame; beyond it coarser pages serve. Raised to four times the number of
    /// casters where that is more, so that the root pages can always be drawn. 28 bytes a pair, twice.
    pub pair_capacity: u32,
    /// Room for the indices of culled clusters; beyond it whole clusters are drawn.
    pub index_capacity: u32,
    /// Threads that cull the triangles of one (cluster, page) pair: a power of two, 8 to 128. On GPUs 64; a CPU driver
    /// such as lavapipe pays for each thread of a group and is fastest at 16.
    pub cull_group: u32,
    /// Depth bias beyond the receiver plane's: this times (a texel of the page plus a quarter of the receiver's depth
    /// change across it); 0 to 16.
    pub bias_texels: f32,
}

impl Config {
    /// The defaults for an image size.
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            atlas_bytes: 64 << 20,
            page_texels: 128,
            gutter: 1,
            level_bias: -3.0,
            cull: Cull::None,
            level_rule: LevelRule::MinLength,
            route: RequestRoute::Flags,
            request_capacity: 16384,
            pair_capacity: 131_072,
            index_capacity: 6 << 20,
            cull_group: 64,
            bias_texels: 1.0,
        }
    }

    /// Pages the atlas holds.
    pub fn page_capacity(&self) -> u32 {
        (self.atlas_bytes / (4 * u64::from(self.page_texels).pow(2))).min(u64::from(u32::MAX)) as u32
    }

    /// Entries of the page table. Requests and their ancestors fill a fifth of it in ordinary views; requests so sparse that
    /// they fill it (none shares an ancestor below level 6) are served by coarser pages and counted.
    pub(crate) fn table_size(&self) -> u32 {
        8 * self.request_capacity
    }

    /// Nodes of the quadtree that are listed: as many as the table holds.
    pub(crate) fn node_capacity(&self) -> u32 {
        self.table_size()
    }

    /// A pixel that is d levels short of its wish weighs 2^d, d at most this, so that the weights of all pixels fit 31 bits.
    #[doc(hidden)]
    pub fn weight_bits(&self) -> u32 {
        (30 - (u64::from(self.size[0]) * u64::from(self.size[1])).max(1).ilog2()).min(10)
    }

    /// Checks every field; `max_layers` is what the device allows in one array image.
    pub(crate) fn check(&self, max_layers: u32) -> Result<(), Error> {
        fn limit<T: std::fmt::Display>(ok: bool, field: &'static str, given: T, limit: String) -> Result<(), Error> {
            if ok { Ok(()) } else { Err(Error::Limit { field, given: given.to_string(), limit }) }
        }
        let [w, h] = self.size;
        limit(
            (1..=16384).contains(&w) && (1..=16384).contains(&h),
            "size",
            format!("{w}x{h}"),
            "1 to 16384 pixels a side".into(),
        )?;
        let texels = self.page_texels;
        limit(matches!(texels, 64 | 128 | 256 | 512), "page_texels", texels, "64, 128, 256 or 512".into())?;
        limit((1..=8).contains(&self.gutter), "gutter", self.gutter, "1 to 8 texels".into())?;
        let page_bytes = 4 * u64::from(texels).pow(2);
        limit(
            (8..=u64::from(max_layers)).contains(&(self.atlas_bytes / page_bytes)),
            "atlas_bytes",
            self.atlas_bytes,
            format!(
                "{} to {} bytes (8 to {max_layers} pages of {texels}x{texels} texels)",
                8 * page_bytes,
                u64::from(max_layers) * page_bytes
            ),
        )?;
        limit((-8.0..=8.0).contains(&self.level_bias), "level_bias", self.level_bias, "-8 to 8".into())?;
        limit((0.0..=16.0).contains(&self.bias_texels), "bias_texels", self.bias_texels, "0 to 16".into())?;
        let group = self.cull_group;
        limit(
            group.is_power_of_two() && (8..=128).contains(&group),
            "cull_group",
            group,
            "a power of two from 8 to 128".into(),
        )?;
        let requests = self.request_capacity;
        limit(
            requests.is_power_of_two() && (1024..=65536).contains(&requests),
            "request_capacity",
            requests,
            "a power of two from 1024 to 65536".into(),
        )?;
        limit(
            (1024..=1 << 20).contains(&self.pair_capacity),
            "pair_capacity",
            self.pair_capacity,
            "1024 to 1048576".into(),
        )?;
        limit(
            (0..=30 << 20).contains(&self.index_capacity),
            "index_capacity",
            self.index_capacity,
            "0 to 31457280".into(),
        )
    }
}
