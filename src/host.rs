//! Everything that crosses the border between a host renderer and the engine, as plain handles.

use crate::gpu::{self, Image};
use crate::{Camera, Error};
use ash::vk;
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};

/// How a position is stored.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PositionFormat {
    /// `R32G32B32_SFLOAT`, 12 bytes.
    #[default]
    Float32 = 0,
    /// `R16G16B16A16_SFLOAT`, 8 bytes; the last component is not read.
    Float16 = 1,
    /// `R16G16B16A16_SNORM`, 8 bytes; the last component is not read. Meshes quantised to -1..1, which the matrices of their
    /// instances scale (as glTF's `KHR_mesh_quantization`).
    Snorm16 = 2,
}

impl PositionFormat {
    fn bytes(self) -> u32 {
        if self == Self::Float32 { 12 } else { 8 }
    }

    pub(crate) fn vulkan(self) -> vk::Format {
        match self {
            Self::Float32 => vk::Format::R32G32B32_SFLOAT,
            Self::Float16 => vk::Format::R16G16B16A16_SFLOAT,
            Self::Snorm16 => vk::Format::R16G16B16A16_SNORM,
        }
    }
}

/// Where positions lie in a buffer of vertices, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PositionLayout {
    /// How each is stored.
    pub format: PositionFormat,
    /// Bytes from a vertex to the next: a multiple of 4 up to 2048 that holds a position.
    pub stride: u32,
    /// Bytes from the beginning of a vertex to its position: a multiple of 4, so that the position ends within the vertex.
    pub offset: u32,
}

impl PositionLayout {
    /// Positions of three floats and nothing else.
    pub const PACKED: Self = Self { format: PositionFormat::Float32, stride: 12, offset: 0 };

    /// The constants POSITION_STRIDE, POSITION_OFFSET and POSITION_FORMAT of the shaders.
    pub(crate) fn words(self) -> [u32; 3] {
        [self.stride / 4, self.offset / 4, self.format as u32]
    }

    fn check(self) -> Result<(), Error> {
        let Self { format, stride, offset } = self;
        let bytes = format.bytes();
        let right = (bytes..=2048).contains(&stride) && offset <= stride - bytes && stride % 4 == 0 && offset % 4 == 0;
        let limit =
            format!("a stride of {bytes} to 2048 that holds {bytes} bytes from the offset, both multiples of 4");
        let given = format!("a stride of {stride} and an offset of {offset}");
        if right { Ok(()) } else { Err(Error::Limit { field: "position_layout", given, limit }) }
    }
}

/// What the engine draws: buffers that the host fills, keeps alive, and changes only between frames. Positions may change
/// with the bounds of their clusters and meshes and the revisions of their instances.
/// All need `STORAGE_BUFFER` usage; `positions` and `attributes` also `VERTEX_BUFFER`, `indices` also `INDEX_BUFFER`. The
/// vertices may be those that the host draws with.
#[derive(Debug, Clone, Copy)]
pub struct SceneBuffers {
    /// Vertices with positions in mesh space.
    pub positions: vk::Buffer,
    /// Where the positions lie in them.
    pub position_layout: PositionLayout,
    /// 12 bytes a vertex: `vec2` texture coordinate, RGBA8 colour ([`crate::Attributes`]). Needed where anything is alpha
    /// tested.
    pub attributes: Option<vk::Buffer>,
    /// 32-bit absolute indices, three a triangle, followed by room for [`crate::Config::index_capacity`] more, which the engine
    /// writes: (`index_count` + `index_capacity`) * 4 bytes.
    pub indices: vk::Buffer,
    /// Number of indices before that room.
    pub index_count: u32,
    /// `Cluster` structs.
    pub clusters: vk::Buffer,
    /// 32-bit words: for each cluster where its meshlet begins; then meshlets: the number of distinct vertices, these as
    /// absolute indices, then a word a triangle with three 10-bit positions in that list.
    pub meshlets: vk::Buffer,
    /// `Instance` structs. A host may change them between frames, and raises `revision` where the casters changed otherwise
    /// than by matrix, mesh, material or flags. Another mesh must not have more clusters than the first. In worlds of
    /// kilometres `low` holds what single precision leaves of the translation; zero is allowed.
    pub instances: vk::Buffer,
    /// Number of instances. Room for more is kept by instances of policy [`crate::CastPolicy::Never`].
    pub instance_count: u32,
    /// [`crate::gpu::structs::MeshBounds`] structs.
    pub meshes: vk::Buffer,
    /// `Material` structs, at least one.
    pub materials: vk::Buffer,
    /// RGBA8 texels; any buffer of 4 bytes and more where nothing is textured.
    pub texels: vk::Buffer,
    /// For ray queries: the device address (64 bits) of a bottom-level acceleration structure for each mesh, over its
    /// triangles in the order of its indices, in one geometry. The host builds them and, where a mesh deforms, builds or
    /// refits them, ordered before the engine's commands as writes of acceleration structures before a build of one reads
    /// them and before compute shaders do.
    pub shapes: Option<vk::Buffer>,
    /// For casters that the host draws with pipelines of its own, in [`crate::Engine::record_with`]: a
    /// `VkDrawIndexedIndirectCommand` for each instance, of `STORAGE_BUFFER` and `INDIRECT_BUFFER` usage. The host fills in
    /// index count, first index and vertex offset of the instances that it draws ([`crate::HOST_DRAWN`]), the
    /// engine, every frame, how many pages each is drawn into (`instanceCount`) and where these are listed (`firstInstance`).
    /// Their meshes come last ([`crate::Meshes::add_bounds`]). Not with [`crate::Config::exact`], whose
    /// rays would not see them.
    pub host_draws: Option<vk::Buffer>,
    /// Number of casters: clusters of all instances together.
    pub caster_count: u32,
    /// Whether any instance is alpha tested.
    pub alpha_tested: bool,
    /// Lower corner of the casters' bounds at all times, relative to the scene's origin, which lies best in their middle. Parts of
    /// casters beyond them may cast nothing.
    pub bounds_min: [f64; 3],
    /// Upper corner.
    pub bounds_max: [f64; 3],
}

impl SceneBuffers {
    /// Checks what can be checked without a device.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.position_layout.check()?;
        if self.alpha_tested && self.attributes.is_none() {
            let (field, given) = ("attributes", "none, with alpha-tested casters".into());
            return Err(Error::Limit { field, given, limit: "texture coordinates and colours of all vertices".into() });
        }
        check_bounds(self.bounds_min, self.bounds_max)?;
        Ok(())
    }

    /// Buffers of vertices as pipelines bind them; without attributes nothing reads the second.
    pub(crate) fn vertices(&self) -> [vk::Buffer; 2] {
        [self.positions, self.attributes.unwrap_or(self.positions)]
    }
}

/// Fails for corners of a box that are not finite or not in this order.
pub(crate) fn check_bounds(low: [f64; 3], high: [f64; 3]) -> Result<(), Error> {
    if (0..3).all(|i| low[i].is_finite() && high[i].is_finite() && low[i] <= high[i]) {
        return Ok(());
    }
    let given = format!("{low:?} to {high:?}");
    Err(Error::Limit { field: "bounds", given, limit: "finite, the lower corner first".into() })
}

/// How the host uses an image before the engine's commands and after them. One value serves both: a host that, for instance,
/// draws a depth image before and samples it after joins the stages and accesses of both, and finds the image in one layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageUse {
    /// The layout in which the engine finds and leaves the image.
    pub layout: vk::ImageLayout,
    /// The stages that use it.
    pub stage: vk::PipelineStageFlags2,
    /// What they do with it.
    pub access: vk::AccessFlags2,
}

impl ImageUse {
    /// Sampled in fragment and compute shaders.
    pub const SAMPLED: Self = Self {
        layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        stage: vk::PipelineStageFlags2::from_raw(
            vk::PipelineStageFlags2::FRAGMENT_SHADER.as_raw() | vk::PipelineStageFlags2::COMPUTE_SHADER.as_raw(),
        ),
        access: vk::AccessFlags2::SHADER_SAMPLED_READ,
    };
    /// A depth attachment that is tested and written.
    pub const DEPTH_ATTACHMENT: Self = Self {
        layout: vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL,
        stage: vk::PipelineStageFlags2::from_raw(
            vk::PipelineStageFlags2::EARLY_FRAGMENT_TESTS.as_raw()
                | vk::PipelineStageFlags2::LATE_FRAGMENT_TESTS.as_raw(),
        ),
        access: vk::AccessFlags2::from_raw(
            vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()
                | vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
        ),
    };
    /// A colour attachment that is written.
    pub const COLOR_ATTACHMENT: Self = Self {
        layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        stage: vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT,
        access: vk::AccessFlags2::COLOR_ATTACHMENT_WRITE,
    };
    /// The source of a copy.
    pub const COPIED: Self = Self {
        layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        stage: vk::PipelineStageFlags2::ALL_TRANSFER,
        access: vk::AccessFlags2::TRANSFER_READ,
    };

    /// Whether the layout is one in which shaders sample.
    fn is_sampled(&self) -> bool {
        use vk::ImageLayout as L;
        matches!(
            self.layout,
            L::GENERAL
                | L::SHADER_READ_ONLY_OPTIMAL
                | L::READ_ONLY_OPTIMAL
                | L::DEPTH_READ_ONLY_OPTIMAL
                | L::DEPTH_STENCIL_READ_ONLY_OPTIMAL
                | L::DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL
        )
    }
}

/// An image of the host that the engine samples: 2-D, one sample a texel, usage `SAMPLED`.
#[derive(Debug, Clone, Copy)]
pub struct HostImage {
    /// The image.
    pub image: vk::Image,
    /// A 2-D view of the layer below, of the depth aspect alone where the format has two.
    pub view: vk::ImageView,
    /// Format of the image.
    pub format: vk::Format,
    /// Samples a texel; the engine reads images of one only.
    pub samples: vk::SampleCountFlags,
    /// Layer of the image that the view shows.
    pub layer: u32,
    /// What used it last before the engine's commands, and what uses it first after them. Layouts other than those in which
    /// shaders sample are left for `SHADER_READ_ONLY_OPTIMAL` and entered again.
    pub used: ImageUse,
}

impl HostImage {
    /// An image of ours that is sampled before and after.
    pub(crate) fn own(image: &Image, format: vk::Format) -> Self {
        let (samples, used) = (vk::SampleCountFlags::TYPE_1, ImageUse::SAMPLED);
        Self { image: image.raw, view: image.view, format, samples, layer: 0, used }
    }

    /// The layout in which the engine samples it.
    pub(crate) fn sampled_layout(&self) -> vk::ImageLayout {
        if self.used.is_sampled() { self.used.layout } else { vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL }
    }

    /// By how much depths of a format of integers are rounded; those of floats by a share of themselves.
    pub(crate) fn rounding(&self) -> f32 {
        use vk::Format as F;
        match self.format {
            F::D16_UNORM | F::D16_UNORM_S8_UINT => 0.5 / 65_535.0,
            F::X8_D24_UNORM_PACK32 | F::D24_UNORM_S8_UINT => 0.5 / 16_777_215.0,
            _ => 0.0,
        }
    }

    /// All aspects of the format.
    pub(crate) fn aspect(&self) -> vk::ImageAspectFlags {
        gpu::aspects(self.format)
    }

    fn check(&self, field: &'static str, right: bool, formats: &str) -> Result<(), Error> {
        let limit = |ok: bool, given: String, limit: String| {
            if ok { Ok(()) } else { Err(Error::Limit { field, given, limit }) }
        };
        limit(right, format!("an image of format {:?}", self.format), formats.into())?;
        let samples = format!("an image of {} samples a texel", self.samples.as_raw());
        limit(self.samples == vk::SampleCountFlags::TYPE_1, samples, "1 sample: resolve it first".into())?;
        let layout = self.used.layout;
        let known = layout != vk::ImageLayout::UNDEFINED && layout != vk::ImageLayout::PREINITIALIZED;
        limit(known, format!("an image in layout {layout:?}"), "a layout that keeps what was drawn".into())
    }
}

/// What the camera saw.
#[derive(Debug, Clone, Copy)]
pub struct ReceiverImages {
    /// Depth of the nearest surface: D16, X8_D24, D24_S8, D32 or D32_S8, of any perspective projection. Texels of the far
    /// end (0 where nearer is greater, else 1) are no surface. D32 with nearer greater is the only one that keeps
    /// shadows of far surfaces as good as those of near ones: with others a surface at distance d is known to about
    /// d^2 / (near * 2^bits), 2^16 and 2^24 for integers, 2^23 for floats with nearer less. Receivers are moved towards the eye by as
    /// much, so that they do not shadow themselves; shadows that touch their casters end by as much too early.
    pub depth: HostImage,
    /// R32_UINT: geometric normal towards the eye in world space, octahedral, two 16-bit signed fractions (see
    /// [`encode_normal`]). Without it normals come from the depths of neighbours: a pixel with a foreign surface on
    /// both sides of it may get a wrong one.
    pub normal: Option<HostImage>,
}

/// One view: what its camera saw and how the host uses its mask.
#[derive(Debug, Clone, Copy)]
pub struct Receivers<'a> {
    /// Width and height of its images in pixels, 1 to those of [`crate::Config::size`].
    pub size: [u32; 2],
    /// The images that frames may come with, at least one: more where frames in flight have images of their own. A frame says
    /// which by [`FrameInput::images`].
    pub images: &'a [ReceiverImages],
    /// How the host uses the mask: what reads it after a frame, and may still read it when the next begins.
    pub mask: ImageUse,
}

impl Receivers<'_> {
    pub(crate) fn check(&self, largest: [u32; 2]) -> Result<(), Error> {
        crate::config::check_size("size of a view", self.size, largest)?;
        if self.images.is_empty() {
            let limit = "at least one".into();
            return Err(Error::Limit { field: "images of a view", given: "none".into(), limit });
        }
        for images in self.images {
            let depth = images.depth.aspect().contains(vk::ImageAspectFlags::DEPTH);
            images.depth.check("depth", depth, "D16, X8_D24, D24_S8, D32 or D32_S8")?;
            if let Some(normal) = &images.normal {
                normal.check("normal", normal.format == vk::Format::R32_UINT, "R32_UINT")?;
            }
        }
        Ok(())
    }
}

/// What changes from frame to frame in a view. All views of a frame have the same origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameInput {
    /// World position of the eye.
    pub eye: DVec3,
    /// Rows: right, up and backward (against the view direction), unit vectors in world space at right angles: of columns,
    /// `DMat3::from_cols(right, up, backward).transpose()`. A mirror's view may be left-handed.
    pub view_from_world: DMat3,
    /// Vulkan clip space (y down) from view space: any perspective projection without a shear of depth, whether nearer
    /// is less or greater, to infinity or not, off centre (jitter, stereo) or not. A matrix made for OpenGL has y up: negate
    /// its second row (`DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * matrix`), also where the host turns the image over by a
    /// viewport of negative height.
    pub clip_from_view: DMat4,
    /// World position of the scene's origin.
    pub origin: DVec3,
    /// Index into [`Receivers::images`].
    pub images: usize,
}

impl FrameInput {
    /// Of a camera for an image of `size` pixels; reversed depth, the first images.
    pub fn new(camera: &Camera, size: [u32; 2], origin: DVec3) -> Self {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        Self {
            eye: camera.eye,
            view_from_world: camera.view_from_world(),
            clip_from_view: camera.clip_from_view(aspect),
            origin,
            images: 0,
        }
    }
}

/// Packs a unit vector as [`ReceiverImages::normal`] holds it: x / (|x| + |y| + |z|) and y alike, folded over where z is
/// negative; x in the low half.
pub fn encode_normal(n: Vec3) -> u32 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    let folded = Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
    let p = if n.z < 0.0 { folded } else { p };
    let bits = |v: f32| u32::from((v.clamp(-1.0, 1.0) * 32767.0).round_ties_even() as i16 as u16);
    bits(p.x) | bits(p.y) << 16
}
