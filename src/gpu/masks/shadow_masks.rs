//! Masks of a frame of a scene.

use std::sync::Arc;

use super::errors::MaskError;
use super::pipelines::{Counting, Setting, layout, pipeline};
use super::reach::reached;
use crate::gpu::common::bindings::texture;
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::{Pipelines, group};
use crate::gpu::common::requirements::{Subject, check_alive, check_same, check_sample_shading};
use crate::gpu::scene::frame::SceneFrame;
use crate::gpu::scene::handles::LightHandle;
use crate::shadow::DepthDirection;

/// Lights whose bits one pass writes.
const GROUP: usize = 32;

/// Pipelines, and a depth and stencil buffer that Rimline owns, for [`SceneFrame::write_masks`].
///
/// Pipelines are made when they are first needed: by the first call, and by the first with other formats or another camera's depth
/// direction. Textures are made anew when the size of the picture changes. For pictures of several sizes in turn, take a value for each.
/// They take 5 to 12 bytes for each sample of each pixel.
///
/// ```no_run
/// # use rimline::gpu::{LightHandle, MaskError, MaskInputs, SceneFrame, ShadowMasks};
/// # use rimline::wgpu;
/// # fn masks(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, frame: &SceneFrame, lights: &[LightHandle],
/// #     depth: &wgpu::TextureView, target: &wgpu::Texture) -> Result<(), MaskError> {
/// // Once:
/// let mut masks = ShadowMasks::new(device)?;
/// // Every frame, after the depth was drawn. Bit `i` of a pixel of `target`, an `R32Uint` texture, is 1 where `lights[i]` is in shadow:
/// frame.write_masks(encoder, &mut masks, &MaskInputs { depth, view: 0, lights, target })?;
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct ShadowMasks {
    /// Whether vertex shaders cut volumes at the frustum, see [`ShadowFormat::trim`](crate::gpu::ShadowFormat::trim). Default: false.
    pub trim: bool,
    shared: Pipelines,
    counting: Vec<(Setting, Arc<Counting>)>,
    /// Pipelines that write targets: the format, the shader, whether bits have several samples.
    writing: Vec<((wgpu::TextureFormat, &'static str, bool), wgpu::RenderPipeline)>,
    textures: Option<Textures>,
    /// The last target, and its layers.
    target: Option<(wgpu::Texture, Vec<wgpu::TextureView>)>,
}

/// The inputs of [`SceneFrame::write_masks`].
#[derive(Clone, Copy, Debug)]
pub struct MaskInputs<'a> {
    /// The depth of the surfaces that get the light, drawn by the camera of the view, as when the commands run. It is a view of level 0 of
    /// one layer with the depth aspect only, of a texture with usage `TEXTURE_BINDING`. Any depth format and any number of samples a
    /// pixel will do. `Depth32Float` needs a device with
    /// [`Features::DEPTH32FLOAT_STENCIL8`](wgpu::Features::DEPTH32FLOAT_STENCIL8).
    pub depth: &'a wgpu::TextureView,
    /// The view of the frame, counted from 0.
    pub view: usize,
    /// The lights, in the order of their bits.
    pub lights: &'a [LightHandle],
    /// The masks. A texture with one sample, usage `RENDER_ATTACHMENT` and the size of the depth. Level 0 is written, of as many layers
    /// as the lights need:
    ///
    /// * `R8Uint`, `R32Uint`: a bit a light, 8 or 32 of them in a layer. Light `i` is bit `i mod 8` of layer `i div 8`, or bit
    ///   `i mod 32` of layer `i div 32`. It is 1 where the light is in shadow. The bits that are left are 0. Of depth with several
    ///   samples, sample 0 counts.
    /// * `R8Unorm`: a layer a light, the share of the samples of a pixel that are in shadow: 0 or 1, or antialiased if the
    ///   depth has several samples.
    pub target: &'a wgpu::Texture,
}

/// Attachments of a size.
#[derive(Debug)]
struct Textures {
    size: [u32; 2],
    formats: [wgpu::TextureFormat; 2],
    samples: u32,
    depth_stencil: wgpu::TextureView,
    bits: wgpu::TextureView,
    /// Reads the bits.
    group: wgpu::BindGroup,
}

impl ShadowMasks {
    /// Makes no pipelines yet. `pipelines` is the caller's device, or the [`Pipelines`] of the scenes.
    ///
    /// # Errors
    /// [`MaskError::Device`] if the device lacks what shadow volumes need.
    pub fn new(pipelines: impl Into<Pipelines>) -> Result<Self, MaskError> {
        let shared = pipelines.into();
        shared.clone().construct(Subject::Shadow, || {
            Ok(Self { trim: false, shared, counting: Vec::new(), writing: Vec::new(), textures: None, target: None })
        })
    }

    fn counting(&mut self, setting: Setting) -> Result<Arc<Counting>, MaskError> {
        if let Some((_, made)) = self.counting.iter().find(|(key, _)| *key == setting) {
            return Ok(Arc::clone(made));
        }
        if setting.samples > 1 {
            check_sample_shading(self.shared.device(), Subject::Shadow)?;
        }
        let made = Arc::new(Counting::new(&self.shared, &setting)?);
        self.counting.push((setting, Arc::clone(&made)));
        Ok(made)
    }

    /// The pipeline that writes a layer of the target.
    fn writing(
        &mut self,
        target: wgpu::TextureFormat,
        entry_point: &'static str,
        is_sampled: bool,
    ) -> Result<wgpu::RenderPipeline, MaskError> {
        let key = (target, entry_point, is_sampled);
        if let Some((_, made)) = self.writing.iter().find(|(made, _)| *made == key) {
            return Ok(made.clone());
        }
        let Self { shared, writing, .. } = self;
        let make = || pipeline(shared, is_sampled, entry_point, target.into(), None, 1);
        let made = any_error(shared.device(), make)
            .map_err(|message| MaskError::Refused { what: "pipelines of masks", message })?;
        writing.push((key, made.clone()));
        Ok(made)
    }

    fn textures(&mut self, size: [u32; 2], setting: &Setting) -> Result<&Textures, MaskError> {
        let (formats, samples) = ([setting.depth_stencil, setting.bits], setting.samples);
        let is_kept = |own: &Textures| (own.size, own.formats, own.samples) == (size, formats, samples);
        let kept = self.textures.take().filter(is_kept);
        let made = match kept {
            Some(kept) => kept,
            None => any_error(self.shared.device(), || Textures::new(&self.shared, size, formats, samples))
                .map_err(|message| MaskError::Refused { what: "textures of masks", message })?,
        };
        Ok(self.textures.insert(made))
    }

    /// Views of the first layers of a target that a pass can draw into.
    fn layers(&mut self, target: &wgpu::Texture, layers: u32) -> Result<Vec<wgpu::TextureView>, MaskError> {
        let is_kept = |(own, views): &(wgpu::Texture, Vec<_>)| own == target && views.len() >= layers as usize;
        let kept = self.target.take().filter(is_kept);
        let made = match kept {
            Some(kept) => kept,
            None => {
                let device = self.shared.device();
                let made = any_error(device, || {
                    let views: Vec<_> = (0..layers).map(|layer| layer_view(target, layer)).collect();
                    // A texture that is destroyed or of another device makes an encoder of the caller useless. This one is tried.
                    let mut tried = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                    views.iter().for_each(|view| drop(draw_into(&mut tried, view)));
                    drop(tried.finish());
                    (target.clone(), views)
                });
                made.map_err(|message| MaskError::Refused { what: "the target", message })?
            }
        };
        let (_, views) = self.target.insert(made);
        Ok(views.iter().take(layers as usize).cloned().collect())
    }
}

impl Textures {
    fn new(shared: &Pipelines, [width, height]: [u32; 2], formats: [wgpu::TextureFormat; 2], samples: u32) -> Self {
        let device = shared.device();
        let [depth_stencil, bits] = formats.map(|format| {
            let read = if format.has_color_aspect() {
                wgpu::TextureUsages::TEXTURE_BINDING
            } else {
                wgpu::TextureUsages::empty()
            };
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("mask"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        });
        let group = group(device, "mask bits", &layout(shared, samples > 1), &[texture(&bits)]);
        Self { size: [width, height], formats, samples, depth_stencil, bits, group }
    }

    /// Begins the pass of a group of lights, with bits and stencil at 0, and with the depth of the group before or without any.
    fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        depth: DepthDirection,
        is_copied: bool,
        is_last: bool,
    ) -> wgpu::RenderPass<'e> {
        let far = if depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
        let load = if is_copied { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(far) };
        let store = if is_last { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
        let stencil = wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Discard };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("mask bits"),
            color_attachments: &[Some(color(&self.bits))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_stencil,
                depth_ops: Some(wgpu::Operations { load, store }),
                stencil_ops: Some(stencil),
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}

/// The format that depth is copied to: one that holds every depth as it is loaded, if the device has it.
fn depth_stencil(format: wgpu::TextureFormat, features: wgpu::Features) -> Result<wgpu::TextureFormat, MaskError> {
    let needed = wgpu::Features::DEPTH32FLOAT_STENCIL8;
    match format {
        _ if features.contains(needed) => Ok(wgpu::TextureFormat::Depth32FloatStencil8),
        wgpu::TextureFormat::Depth32Float => Err(MaskError::Feature { format, needed }),
        _ => Ok(wgpu::TextureFormat::Depth24PlusStencil8),
    }
}

fn layer_view(target: &wgpu::Texture, base_array_layer: u32) -> wgpu::TextureView {
    target.create_view(&wgpu::TextureViewDescriptor {
        label: Some("mask"),
        dimension: Some(wgpu::TextureViewDimension::D2),
        mip_level_count: Some(1),
        base_array_layer,
        array_layer_count: Some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}

/// Begins a pass that writes a layer of the target.
fn draw_into<'e>(encoder: &'e mut wgpu::CommandEncoder, view: &wgpu::TextureView) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("masks"),
        color_attachments: &[Some(color(view))],
        ..wgpu::RenderPassDescriptor::default()
    })
}

fn color(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

impl MaskInputs<'_> {
    /// Lights that a layer of the target holds.
    fn lights_a_layer(&self) -> Result<usize, MaskError> {
        match self.target.format() {
            wgpu::TextureFormat::R8Uint => Ok(8),
            wgpu::TextureFormat::R32Uint => Ok(32),
            wgpu::TextureFormat::R8Unorm => Ok(1),
            format => Err(MaskError::TargetFormat { format }),
        }
    }

    /// Refuses textures that do not go together, as far as they tell. Returns the layers that are written.
    fn check(&self) -> Result<u32, MaskError> {
        let (map, target) = (self.depth.texture(), self.target);
        let format = map.format();
        if !(format.has_depth_aspect() && map.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING)) {
            return Err(MaskError::Depth { format });
        }
        let (lights, a_layer) = (self.lights.len(), self.lights_a_layer()?);
        let (samples, dimension, usage) = (target.sample_count(), target.dimension(), target.usage());
        let is_drawn = usage.contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
        if samples > 1 || dimension != wgpu::TextureDimension::D2 || !is_drawn {
            return Err(MaskError::Target { samples, dimension, usage });
        }
        let [depth, size] = [map, target].map(|texture| [texture.width(), texture.height()]);
        if depth != size {
            return Err(MaskError::Size { target: size, depth });
        }
        let (needed, layers) = (lights.div_ceil(a_layer).max(1) as u32, target.depth_or_array_layers());
        if needed > layers {
            return Err(MaskError::TooManyLights { lights, needed, format: target.format(), layers });
        }
        Ok(needed)
    }
}

impl SceneFrame {
    /// Writes which lights are in shadow at each pixel, for renderers without a stencil: from the depth that the caller drew, a bit
    /// or a share for each light.
    ///
    /// A mask has no meaning where nothing was drawn, where the light does not reach because of its range or cone, and on the side
    /// of a surface that is turned away from it: nothing is to be lit there. Masks of lights that do not reach the view cost nothing.
    /// Masks that reach a part of the picture are 0 in the rest of it.
    ///
    /// The value that `textureLoad` gives of the depth is the value that volumes are compared with, to the bit, on devices with
    /// [`Features::DEPTH32FLOAT_STENCIL8`](wgpu::Features::DEPTH32FLOAT_STENCIL8). Without it, depth of 16 and 24 bits is stored in 24 bits
    /// again, and may be off by one unit of the last place where the device rounds. [`Counting::ZFail`](crate::Counting::ZFail) compares
    /// caps with surfaces at the same depth, so casters with an open surface need `Depth32Float` for it.
    ///
    /// It records one pass for each 32 lights, and one for each layer of the target. One encoder may hold several calls.
    ///
    /// # Errors
    /// [`MaskError`] if the frame is out of date, an input is refused, or the device lacks something. Nothing is recorded then.
    pub fn write_masks(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        masks: &mut ShadowMasks,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), MaskError> {
        let MaskInputs { depth, view, lights, target } = *inputs;
        let (convention, camera) = self.check_view(view)?;
        let encoded = lights.iter().map(|&light| self.check_light(light)).collect::<Result<Vec<_>, _>>()?;
        check_same(["the masks", "the scene"], [masks.shared.device(), &self.device])?;
        check_alive(&self.device)?;
        let layers = inputs.check()?;
        let (map, trim) = (depth.texture(), masks.trim);
        let (size, samples) = ([map.width(), map.height()], map.sample_count());
        let bits = if lights.len() <= 8 { wgpu::TextureFormat::R8Unorm } else { wgpu::TextureFormat::Rgba8Unorm };
        let reach: Vec<_> =
            lights.iter().zip(&encoded).map(|(&light, of)| (light, reached(camera, of, size))).collect();
        let depth_stencil = depth_stencil(map.format(), self.device.features())?;
        let is_in_batches = self.count_batches > 1;
        let setting = Setting { convention, is_in_batches, depth_stencil, bits, samples, trim };
        let counting = masks.counting(setting.clone())?;
        let entry_point = match target.format() {
            wgpu::TextureFormat::R8Unorm => "mask_share",
            // The other channels of textures with one are no bits.
            wgpu::TextureFormat::R32Uint if lights.len() > 8 => "mask_word",
            _ => "mask_byte",
        };
        let writing = masks.writing(target.format(), entry_point, samples > 1)?;
        let given = any_error(&self.device, || {
            group(&self.device, "mask depth", &layout(&masks.shared, samples > 1), &[texture(depth)])
        });
        let given = given.map_err(|message| MaskError::Refused { what: "the depth", message })?;
        let views = masks.layers(target, layers)?;
        let textures = masks.textures(size, &setting)?;

        let mut is_copied = false;
        let (groups, of_layer) = (lights.len().div_ceil(GROUP).max(1), inputs.lights_a_layer()?);
        for group in 0..groups {
            let of_group = reach.iter().skip(GROUP * group).take(GROUP);
            let drawn: Vec<_> = (0..).zip(of_group).filter_map(|(n, (light, at))| Some((n, *light, (*at)?))).collect();
            if !drawn.is_empty() {
                let mut pass = textures.begin(encoder, convention.depth, is_copied, group + 1 == groups);
                pass.set_bind_group(0, &given, &[]);
                if !is_copied {
                    pass.set_pipeline(&counting.depth);
                    pass.draw(0..3, 0..1);
                    is_copied = true;
                }
                for &(number, light, [x, y, width, height]) in &drawn {
                    pass.set_scissor_rect(x, y, width, height);
                    self.record(&mut pass, &counting.volumes, view, light);
                    pass.set_pipeline(&counting.bit);
                    pass.set_bind_group(0, &given, &[]);
                    pass.draw(0..3, number..number + 1);
                }
            }
            let first = group * GROUP / of_layer;
            for (number, view) in (0..).zip(views.iter().skip(first).take(GROUP / of_layer)) {
                let mut pass = draw_into(encoder, view);
                if !drawn.is_empty() {
                    pass.set_pipeline(&writing);
                    pass.set_bind_group(0, &textures.group, &[]);
                    pass.draw(0..3, number..number + 1);
                }
            }
        }
        Ok(())
    }
}
