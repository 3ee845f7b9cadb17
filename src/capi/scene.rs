//! What crosses the border with every engine and every frame: buffers, images, cameras.

use super::guard::Failure;
use super::input::{present, sized, slice, zero};
use super::vulkan::*;
use crate::{FrameInput, HostImage, ImageUse, PositionFormat, PositionLayout, ReceiverImages, Receivers, SceneBuffers};
use ash::vk::Handle;
use glam::{DMat3, DMat4, DVec3};

/// How a position is stored.
pub type UmbragePositionFormat = u32;
/// VK_FORMAT_R32G32B32_SFLOAT, 12 bytes.
pub const UMBRAGE_POSITION_FLOAT32: UmbragePositionFormat = 0;
/// VK_FORMAT_R16G16B16A16_SFLOAT, 8 bytes; the last component is not read.
pub const UMBRAGE_POSITION_FLOAT16: UmbragePositionFormat = 1;
/// VK_FORMAT_R16G16B16A16_SNORM, 8 bytes; the last component is not read. Meshes quantised to -1..1, which the matrices
/// of their instances scale.
pub const UMBRAGE_POSITION_SNORM16: UmbragePositionFormat = 2;

fn position_format(format: UmbragePositionFormat) -> Result<PositionFormat, Failure> {
    match format {
        UMBRAGE_POSITION_FLOAT32 => Ok(PositionFormat::Float32),
        UMBRAGE_POSITION_FLOAT16 => Ok(PositionFormat::Float16),
        UMBRAGE_POSITION_SNORM16 => Ok(PositionFormat::Snorm16),
        _ => Err(Failure::limit("position_format", format, "an UMBRAGE_POSITION constant, 0 to 2")),
    }
}

/// What the engine draws: buffers that the host fills, keeps alive, and changes only between frames, ordered before the
/// engine's commands. All need storage usage; positions and attributes also vertex usage, indices also index usage.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageScene {
    /// sizeof(UmbrageScene).
    pub struct_size: usize,
    /// Vertices with positions in mesh space, as position_format, position_stride and position_offset say.
    pub positions: VkBuffer,
    /// UmbrageAttributes, one a vertex. VK_NULL_HANDLE where nothing is alpha tested.
    pub attributes: VkBuffer,
    /// 32-bit absolute indices, three a triangle (UmbrageMeshData), followed by room for index_capacity more, which the
    /// engine writes: (index_count + index_capacity) * 4 bytes.
    pub indices: VkBuffer,
    /// UmbrageCluster structs.
    pub clusters: VkBuffer,
    /// Vertex lists of the clusters, as UmbrageMeshData has them.
    pub meshlets: VkBuffer,
    /// UmbrageInstance structs. Another mesh for an instance must not have more clusters than the first.
    pub instances: VkBuffer,
    /// UmbrageMeshBounds structs.
    pub meshes: VkBuffer,
    /// UmbrageMaterial structs.
    pub materials: VkBuffer,
    /// RGBA8 texels; any buffer of 4 bytes and more where nothing is textured.
    pub texels: VkBuffer,
    /// For ray queries, else VK_NULL_HANDLE: the device address (64 bits) of a bottom-level acceleration structure for
    /// each mesh, over its triangles in the order of its indices, in one geometry.
    pub shapes: VkBuffer,
    /// Bytes from a vertex to the next: a multiple of 4 up to 2048 that holds a position; 0 stands for 12.
    pub position_stride: u32,
    /// Bytes from the beginning of a vertex to its position: a multiple of 4, so that the position ends within the vertex.
    pub position_offset: u32,
    /// How each position is stored.
    pub position_format: UmbragePositionFormat,
    /// Number of indices before the room.
    pub index_count: u32,
    /// Number of instances. Room for more is kept by instances of policy never.
    pub instance_count: u32,
    /// Clusters of all instances together: umbrage_meshes_caster_count.
    pub caster_count: u32,
    /// Whether any instance is alpha tested.
    pub alpha_tested: VkBool32,
    /// Zero.
    pub reserved: u32,
    /// Lower corner of the casters' bounds at all times, relative to the scene's origin, which lies best in their
    /// middle.
    pub bounds_min: [f64; 3],
    /// Upper corner.
    pub bounds_max: [f64; 3],
    /// For casters that the host draws with pipelines of its own (umbrage_record_with), else VK_NULL_HANDLE: a
    /// VkDrawIndexedIndirectCommand for each instance, of storage and indirect usage. The host fills in indexCount,
    /// firstIndex and vertexOffset of the instances that it draws (UMBRAGE_CAST_HOST_DRAWN), the engine, every frame, how
    /// many pages each is drawn into (instanceCount) and where these are listed (firstInstance). Their meshes come last
    /// (umbrage_meshes_add_bounds). Not with exact, whose rays would not see them.
    pub host_draws: VkBuffer,
}

#[cfg(target_pointer_width = "64")]
const _: () = assert!(size_of::<UmbrageScene>() == 8 + 11 * 8 + 8 * 4 + 6 * 8);

impl UmbrageScene {
    /// # Safety
    /// Null, or a struct as long as it says of itself.
    pub(super) unsafe fn read(scene: *const Self) -> Result<SceneBuffers, Failure> {
        let null = VkBuffer::null();
        let empty = Self {
            struct_size: 0,
            positions: null,
            attributes: null,
            indices: null,
            clusters: null,
            meshlets: null,
            instances: null,
            meshes: null,
            materials: null,
            texels: null,
            shapes: null,
            position_stride: 0,
            position_offset: 0,
            position_format: 0,
            index_count: 0,
            instance_count: 0,
            caster_count: 0,
            alpha_tested: 0,
            reserved: 0,
            bounds_min: [0.0; 3],
            bounds_max: [0.0; 3],
            host_draws: null,
        };
        // SAFETY: the caller vouches for the pointer
        let scene = unsafe { sized(scene, empty, size_of::<Self>(), "the scene")? };
        zero(scene.reserved)?;
        Ok(SceneBuffers {
            positions: present(scene.positions, "positions")?,
            position_layout: PositionLayout {
                format: position_format(scene.position_format)?,
                stride: if scene.position_stride == 0 { PositionLayout::PACKED.stride } else { scene.position_stride },
                offset: scene.position_offset,
            },
            attributes: (!scene.attributes.is_null()).then_some(scene.attributes),
            indices: present(scene.indices, "indices")?,
            index_count: scene.index_count,
            clusters: present(scene.clusters, "clusters")?,
            meshlets: present(scene.meshlets, "meshlets")?,
            instances: present(scene.instances, "instances")?,
            instance_count: scene.instance_count,
            meshes: present(scene.meshes, "meshes")?,
            materials: present(scene.materials, "materials")?,
            texels: present(scene.texels, "texels")?,
            shapes: (!scene.shapes.is_null()).then_some(scene.shapes),
            host_draws: (!scene.host_draws.is_null()).then_some(scene.host_draws),
            caster_count: scene.caster_count,
            alpha_tested: scene.alpha_tested != 0,
            bounds_min: scene.bounds_min,
            bounds_max: scene.bounds_max,
        })
    }
}

/// How the host uses an image before the engine's commands and after them.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageImageUse {
    /// The layout in which the engine finds and leaves the image.
    pub layout: VkImageLayout,
    /// Zero.
    pub reserved: u32,
    /// The stages that use it.
    pub stage: VkPipelineStageFlags2,
    /// What they do with it.
    pub access: VkAccessFlags2,
}

impl UmbrageImageUse {
    fn read(self) -> Result<ImageUse, Failure> {
        zero(self.reserved)?;
        Ok(ImageUse { layout: self.layout, stage: self.stage, access: self.access })
    }
}

/// An image of the host that the engine samples: 2-D, one sample a texel, usage sampled.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageImage {
    /// The image.
    pub image: VkImage,
    /// A 2-D view of the layer below, of the depth aspect alone where the format has two.
    pub view: VkImageView,
    /// Format of the image.
    pub format: VkFormat,
    /// Samples a texel; the engine reads images of one only.
    pub samples: VkSampleCountFlagBits,
    /// Layer of the image that the view shows.
    pub layer: u32,
    /// Zero.
    pub reserved: u32,
    /// What used it last before the engine's commands, and what uses it first after them. Layouts other than those in
    /// which shaders sample are left for SHADER_READ_ONLY_OPTIMAL and entered again.
    pub used: UmbrageImageUse,
}

impl UmbrageImage {
    fn read(self, what: &str) -> Result<HostImage, Failure> {
        zero(self.reserved)?;
        Ok(HostImage {
            image: present(self.image, what)?,
            view: present(self.view, &format!("the view of {what}"))?,
            format: self.format,
            samples: self.samples,
            layer: self.layer,
            used: self.used.read()?,
        })
    }
}

impl From<HostImage> for UmbrageImage {
    fn from(image: HostImage) -> Self {
        let ImageUse { layout, stage, access } = image.used;
        Self {
            image: image.image,
            view: image.view,
            format: image.format,
            samples: image.samples,
            layer: image.layer,
            reserved: 0,
            used: UmbrageImageUse { layout, reserved: 0, stage, access },
        }
    }
}

/// What the camera saw.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageReceiverImages {
    /// Depth of the nearest surface: D16, X8_D24, D24_S8, D32 or D32_S8, of any perspective projection. Texels of the
    /// far end (0 where nearer is greater, else 1) are no surface.
    pub depth: UmbrageImage,
    /// R32_UINT: geometric normal towards the eye in world space (umbrage_encode_normal), or an image of
    /// VK_NULL_HANDLE: then normals come from the depths of neighbours.
    pub normal: UmbrageImage,
}

impl From<ReceiverImages> for UmbrageReceiverImages {
    fn from(images: ReceiverImages) -> Self {
        let depth = UmbrageImage::from(images.depth);
        let none = UmbrageImage { image: VkImage::null(), view: VkImageView::null(), ..depth };
        Self { depth, normal: images.normal.map_or(none, UmbrageImage::from) }
    }
}

/// One view: what its camera saw and how the host uses its mask.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageView {
    /// Width of its images in pixels, 1 to the config's.
    pub width: u32,
    /// Height of its images in pixels, 1 to the config's.
    pub height: u32,
    /// The images that frames may come with: more than one where frames in flight have images of their own.
    pub images: *const UmbrageReceiverImages,
    /// Number of these, at least 1.
    pub image_count: usize,
    /// What reads the mask after a frame, and may still read it when the next begins.
    pub mask: UmbrageImageUse,
}

/// Views of the caller with their images.
pub(super) struct Views(Vec<(UmbrageView, Vec<ReceiverImages>)>);

impl Views {
    /// # Safety
    /// Null, or `count` views whose images are null or as many as they say.
    pub(super) unsafe fn read(views: *const UmbrageView, count: usize) -> Result<Self, Failure> {
        // SAFETY: the caller vouches for the pointers
        let views = unsafe { slice(views, count, "views")? };
        let images = |view: &UmbrageView| {
            // SAFETY: as above
            let images = unsafe { slice(view.images, view.image_count, "images of a view")? };
            let read = |images: &UmbrageReceiverImages| {
                let normal = (!images.normal.image.is_null()).then(|| images.normal.read("normal")).transpose()?;
                Ok(ReceiverImages { depth: images.depth.read("depth")?, normal })
            };
            Ok((*view, images.iter().map(read).collect::<Result<_, Failure>>()?))
        };
        Ok(Self(views.iter().map(images).collect::<Result<_, Failure>>()?))
    }

    pub(super) fn receivers(&self) -> Result<Vec<Receivers<'_>>, Failure> {
        self.0
            .iter()
            .map(|(view, images)| Ok(Receivers { size: [view.width, view.height], images, mask: view.mask.read()? }))
            .collect()
    }
}

/// What changes from frame to frame in a view. All views of a frame have the same origin.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UmbrageFrameInput {
    /// World position of the eye.
    pub eye: [f64; 3],
    /// Rows: right, up and backward (against the view direction), unit vectors in world space at right angles.
    pub view_from_world: [[f64; 3]; 3],
    /// Rows of the matrix to Vulkan clip space (y down) from view space: row i times the view coordinates is clip
    /// coordinate i. Any perspective projection without a shear of depth, whether nearer is less or greater, to
    /// infinity or not, off centre (jitter, stereo) or not.
    pub clip_from_view: [[f64; 4]; 4],
    /// World position of the scene's origin.
    pub origin: [f64; 3],
    /// Index into the view's images.
    pub images: u32,
    /// Zero.
    pub reserved: u32,
}

impl UmbrageFrameInput {
    pub(super) fn read(&self) -> Result<FrameInput, Failure> {
        zero(self.reserved)?;
        Ok(FrameInput {
            eye: DVec3::from(self.eye),
            view_from_world: DMat3::from_cols_array_2d(&self.view_from_world).transpose(),
            clip_from_view: DMat4::from_cols_array_2d(&self.clip_from_view).transpose(),
            origin: DVec3::from(self.origin),
            images: self.images as usize,
        })
    }
}

/// Packs a unit vector as the normal image holds it.
#[unsafe(no_mangle)]
pub extern "C" fn umbrage_encode_normal(x: f32, y: f32, z: f32) -> u32 {
    crate::encode_normal(glam::Vec3::new(x, y, z))
}
