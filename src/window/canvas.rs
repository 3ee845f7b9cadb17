//! The picture in the making: visibility and surfaces to colours, text over them, and into the window's image.

use super::overlay::Overlay;
use super::palette;
use super::show::Show;
use super::swapchain::Target;
use crate::Light;
use crate::gpu::structs::{AtlasPush, Frame, ShadeLight, ShadePush};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Image, ImageSpec, Memory, spirv};
use crate::lab::{Lab, LabError};
use crate::methods::{Masks, PageViews};
use crate::output::Picture;
use crate::output::shade::{NIGHT, SUN_AT};
use ash::vk;
use glam::{DVec3, Vec3};

/// Most lights that are shaded: what one command writes into a buffer.
const MOST_LIGHTS: usize = 65536 / size_of::<ShadeLight>();

/// Visibility of a method's last frame.
pub(super) enum Lit<'a> {
    /// On the device.
    Masks(Masks<'a>),
    /// From the CPU: an image for each light.
    Values(Vec<Vec<f32>>),
}

pub(super) struct Canvas {
    size: [u32; 2],
    image: Image,
    frame: Buffer,
    /// Constants of the view that `prepare` saw.
    camera: Frame,
    palette: Buffer,
    lights: Buffer,
    text: Buffer,
    /// What stands for pages where a method has none.
    nothing: Buffer,
    overlay: Compute,
    visibility: Visibility,
    shade: Option<Shade>,
}

/// Visibility as the shader reads it, and the way there from the CPU.
struct Visibility {
    words: Buffer,
    staging: Option<Buffer>,
    bits: u32,
}

/// Passes that depend on the method.
struct Shade {
    /// Visibility and pages that they read.
    of: [vk::Buffer; 2],
    shade: Compute,
    atlas: Option<(Compute, u32)>,
}

impl Canvas {
    /// For a lab's present size.
    pub(super) fn new(lab: &Lab) -> Result<Self, LabError> {
        use vk::{BufferUsageFlags as B, ImageUsageFlags as I};
        let gpu = lab.gpu();
        let size = lab.view().size;
        let [width, height] = size;
        let format = vk::Format::R8G8B8A8_UNORM;
        let image = ImageSpec { format, width, height, layers: 0, usage: I::STORAGE | I::TRANSFER_SRC };
        let image = Image::new(gpu, "picture", &image)?;
        let colors = palette::colors();
        let colors: &[u8] = bytemuck::cast_slice(&colors);
        let mut palette = Buffer::new(gpu, "palette", colors.len() as u64, B::STORAGE_BUFFER, Memory::Upload)?;
        palette.bytes_mut()[..colors.len()].copy_from_slice(colors);
        let text =
            Buffer::new(gpu, "text", 4 * u64::from(width) * u64::from(height), B::STORAGE_BUFFER, Memory::Upload)?;
        let over = [Binding::Storage(&text), Binding::StorageImage(&image)];
        let uniform = B::UNIFORM_BUFFER | B::TRANSFER_DST;
        let count = lab.view().lights.len().clamp(1, MOST_LIGHTS) as u64;
        Ok(Self {
            size,
            camera: lab.camera_constants()?,
            frame: Buffer::new(gpu, "camera of the picture", size_of::<Frame>() as u64, uniform, Memory::Device)?,
            lights: Buffer::storage(gpu, "lights of the picture", count * size_of::<ShadeLight>() as u64, B::empty())?,
            overlay: Compute::new(gpu, "overlay", spirv!("window/overlay.comp"), &over, &[], 0)?,
            nothing: Buffer::storage(gpu, "no pages", 16, B::empty())?,
            visibility: Visibility {
                words: Buffer::storage(gpu, "visibility", 16, B::empty())?,
                staging: None,
                bits: 32,
            },
            image,
            palette,
            text,
            shade: None,
        })
    }

    /// Readies the passes for a method's results.
    pub(super) fn prepare(&mut self, lab: &Lab, lit: &Lit<'_>, pages: Option<&PageViews<'_>>) -> Result<(), LabError> {
        self.camera = lab.camera_constants()?;
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let gpu = lab.gpu();
        let layers = match lit {
            Lit::Masks(masks) => masks.images.iter().map(|image| u64::from(image.layers)).sum(),
            Lit::Values(values) => values.len() as u64,
        };
        let bytes = 4 * pixels * layers;
        if self.visibility.words.size < bytes {
            self.visibility.words = Buffer::storage(gpu, "visibility", bytes, vk::BufferUsageFlags::empty())?;
        }
        self.visibility.bits = 32;
        match lit {
            Lit::Masks(masks) => self.visibility.bits = masks.bits,
            Lit::Values(values) => {
                let staging = match self.visibility.staging.take().filter(|staging| staging.size >= bytes) {
                    Some(staging) => staging,
                    None => {
                        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
                        Buffer::new(gpu, "visibility of the CPU", bytes, usage, Memory::Upload)?
                    }
                };
                let staging = self.visibility.staging.insert(staging);
                for (image, target) in values.iter().zip(staging.bytes_mut().chunks_exact_mut(4 * pixels as usize)) {
                    // a method that has made no frame yet has no values
                    let image: &[u8] = bytemuck::cast_slice(image);
                    let length = image.len().min(target.len());
                    target[..length].copy_from_slice(&image[..length]);
                }
            }
        }
        let of = [self.visibility.words.raw, pages.map_or(self.nothing.raw, |pages| pages.pages.raw)];
        if self.shade.as_ref().is_none_or(|shade| shade.of != of) {
            self.shade = Some(self.passes(lab, of, pages)?);
        }
        Ok(())
    }

    /// Another method comes: what the passes read of the last one may be gone, and its handles taken by others.
    pub(super) fn forget(&mut self) {
        self.shade = None;
    }

    fn passes(&self, lab: &Lab, of: [vk::Buffer; 2], pages: Option<&PageViews<'_>>) -> Result<Shade, LabError> {
        let (gpu, prepass) = (lab.gpu(), lab.prepass());
        let (palette, target) = (Binding::Storage(&self.palette), Binding::StorageImage(&self.image));
        let bindings = [
            Binding::Uniform(&self.frame),
            Binding::Sampled(&prepass.depth),
            Binding::Sampled(&prepass.normal),
            Binding::Sampled(&prepass.albedo),
            Binding::External(of[0]),
            Binding::Storage(&self.lights),
            palette,
            Binding::External(of[1]),
            target,
        ];
        let atlas = |pages: &PageViews<'_>| {
            let (layers, states) = (Binding::Storage(pages.layers), Binding::Storage(pages.states));
            let bindings = [Binding::Sampled(pages.atlas), layers, states, palette, target];
            let code = spirv!("window/atlas.comp");
            let count = pages.atlas.layers;
            Ok::<_, LabError>((Compute::new(gpu, "atlas", code, &bindings, &[count], size_of::<AtlasPush>())?, count))
        };
        Ok(Shade {
            of,
            shade: Compute::new(gpu, "shade", spirv!("window/shade.comp"), &bindings, &[], size_of::<ShadePush>())?,
            atlas: pages.map(atlas).transpose()?,
        })
    }

    /// Puts text over the next picture.
    pub(super) fn write(&mut self, overlay: &Overlay) {
        let words: &[u8] = bytemuck::cast_slice(overlay.words());
        let text = self.text.bytes_mut();
        let length = words.len().min(text.len());
        text[..length].copy_from_slice(&words[..length]);
    }

    /// Draws the picture of the lab's view. [`Canvas::prepare`] came before with the same results.
    pub(super) fn record(&self, lab: &Lab, cmd: vk::CommandBuffer, lit: &Lit<'_>, show: Show) {
        use Access::*;
        let device = &lab.gpu().device;
        let Some(passes) = &self.shade else { return };
        let view = lab.view();
        let (lights, push) = shading(lab, show, self.visibility.bits);
        sync::barrier(device, cmd, &[(ComputeRead, TransferWrite)]);
        // SAFETY: the command buffer is recording; the data is smaller than 64 KiB and fits its buffers
        unsafe {
            device.cmd_update_buffer(cmd, self.frame.raw, 0, bytemuck::bytes_of(&self.camera));
            device.cmd_update_buffer(cmd, self.lights.raw, 0, bytemuck::cast_slice(&lights));
        }
        self.gather(lab, cmd, lit);
        sync::barrier(device, cmd, &[(TransferWrite, ComputeRead)]);
        sync::discard(device, cmd, &self.image, TransferRead, StorageImage);
        let groups = [view.size[0].div_ceil(8), view.size[1].div_ceil(8), 1];
        match (&passes.atlas, show) {
            (Some((atlas, count)), Show::Atlas) => atlas.dispatch(cmd, &cells(view.size, *count), groups),
            _ => passes.shade.dispatch(cmd, &push, groups),
        }
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
        self.overlay.dispatch(cmd, &(), groups);
        sync::image(device, cmd, &self.image, StorageImage, TransferRead);
    }

    /// Copies visibility to where the shader reads it.
    fn gather(&self, lab: &Lab, cmd: vk::CommandBuffer, lit: &Lit<'_>) {
        let device = &lab.gpu().device;
        let words = &self.visibility.words;
        match (lit, &self.visibility.staging) {
            (Lit::Masks(masks), _) => {
                let mut offset = 0;
                for image in &masks.images {
                    let region = [vk::BufferImageCopy::default()
                        .buffer_offset(offset)
                        .image_subresource(vk::ImageSubresourceLayers {
                            aspect_mask: image.aspect(),
                            mip_level: 0,
                            base_array_layer: 0,
                            layer_count: image.layers,
                        })
                        .image_extent(vk::Extent3D {
                            width: image.extent.width,
                            height: image.extent.height,
                            depth: 1,
                        })];
                    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                    // SAFETY: `prepare` made the buffer large enough for all images
                    unsafe { device.cmd_copy_image_to_buffer(cmd, image.raw, layout, words.raw, &region) };
                    offset +=
                        4 * u64::from(image.extent.width) * u64::from(image.extent.height) * u64::from(image.layers);
                }
            }
            (Lit::Values(_), Some(staging)) => {
                let copy = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: words.size.min(staging.size) }];
                // SAFETY: both buffers have this size
                unsafe { device.cmd_copy_buffer(cmd, staging.raw, words.raw, &copy) };
            }
            (Lit::Values(_), None) => (),
        }
    }

    /// Copies the picture into an image of the window, stretched while the window has just got another size.
    pub(super) fn present(&self, lab: &Lab, cmd: vk::CommandBuffer, target: &Target) {
        use Access::*;
        let device = &lab.gpu().device;
        let corner = |width: u32, height: u32| vk::Offset3D { x: width as i32, y: height as i32, z: 1 };
        let layer = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let zero = vk::Offset3D::default();
        let region = [vk::ImageBlit::default()
            .src_subresource(layer)
            .src_offsets([zero, corner(self.size[0], self.size[1])])
            .dst_subresource(layer)
            .dst_offsets([zero, corner(target.extent.width, target.extent.height)])];
        let same = target.extent == self.image.extent;
        sync::swapchain_image(device, cmd, target.image, Acquired, TransferWrite);
        // SAFETY: both images have the layouts named; the picture was left in TRANSFER_SRC_OPTIMAL
        unsafe {
            device.cmd_blit_image(
                cmd,
                self.image.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                target.image,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &region,
                if same { vk::Filter::NEAREST } else { vk::Filter::LINEAR },
            );
        }
        sync::swapchain_image(device, cmd, target.image, TransferWrite, Presented);
    }

    /// The last picture.
    pub(super) fn read(&self, lab: &Lab) -> Result<Picture, LabError> {
        let bytes = lab.read_image(&self.image, Access::TransferRead, 4)?;
        let [width, height] = self.size;
        Ok(Picture {
            width,
            height,
            rgb: bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect(),
        })
    }
}

/// What the shader needs of the view.
fn shading(lab: &Lab, show: Show, bits: u32) -> (Vec<ShadeLight>, ShadePush) {
    let view = lab.view();
    let eye = view.camera.eye;
    let day = view.lights.iter().any(|light| matches!(light, Light::Directional { .. }));
    let lights: Vec<_> = view.lights.iter().take(MOST_LIGHTS).map(|light| shade_light(light, eye)).collect();
    let up = view.camera.up.normalize_or(DVec3::Y).as_vec3();
    let push = ShadePush {
        up: up.extend(if day { 1.0 } else { NIGHT }).to_array(),
        count: lights.len() as u32,
        bits,
        show: show.word(),
        sun_at: SUN_AT as f32,
    };
    (lights, push)
}

/// `eye`: world space, like the light.
fn shade_light(light: &Light, eye: DVec3) -> ShadeLight {
    let unit = |v: DVec3| v.normalize_or_zero().as_vec3();
    let place = |position: DVec3, range: f64| (position - eye).as_vec3().extend(range as f32).to_array();
    let kind = |direction: Vec3, kind: f32| direction.extend(kind).to_array();
    let cosine = |degrees: f64| degrees.to_radians().cos() as f32;
    match light {
        Light::Directional { direction, .. } => {
            ShadeLight { place: [0.0; 4], direction: kind(unit(*direction), 0.0), cone: [0.0; 4] }
        }
        Light::Spot { position, direction, inner_angle_deg, outer_angle_deg, range } => ShadeLight {
            place: place(*position, *range),
            direction: kind(unit(*direction), 1.0),
            cone: [cosine(*inner_angle_deg), cosine(*outer_angle_deg), 0.0, 0.0],
        },
        Light::Point { position, range } => {
            ShadeLight { place: place(*position, *range), direction: kind(Vec3::ZERO, 2.0), cone: [0.0; 4] }
        }
        // no method here serves it
        Light::Area { .. } => ShadeLight { place: [0.0, 0.0, 0.0, 1.0], direction: [0.0; 4], cone: [0.0; 4] },
    }
}

/// The largest cells with which `count` of them fit the picture.
fn cells([width, height]: [u32; 2], count: u32) -> AtlasPush {
    let fits = |cell: &u32| (width / cell) * (height / cell) >= count;
    let cell = (1..=width.min(height).max(1)).rev().find(fits).unwrap_or(1);
    AtlasPush { columns: (width / cell).max(1), cell }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_the_atlas_fit() {
        assert_eq!(cells([1280, 720], 1024), AtlasPush { columns: 44, cell: 29 });
        assert_eq!(cells([100, 100], 1), AtlasPush { columns: 1, cell: 100 });
        // more cells than pixels: as many as there is room for
        assert_eq!(cells([8, 8], 1024), AtlasPush { columns: 8, cell: 1 });
        assert_eq!(cells([1, 1], 16), AtlasPush { columns: 1, cell: 1 });
    }
}
