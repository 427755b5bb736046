//! Masks of a frame of a scene.

use std::sync::Arc;

use super::light_bounds::affected_pixels;
use super::passes::{Attachment, around, begin, draw_into, layer_view, scissor};
use super::pipelines::{Counting, Setting, layout, pipeline, tried};
use crate::gpu::common::bindings::texture;
use crate::gpu::common::pipelines::{Pipelines, group};
use crate::gpu::common::requirements::{Subject, check_same, check_sample_shading};
use crate::gpu::scene::frame::{EncodedView, SceneFrame};
use crate::gpu::scene::handles::LightHandle;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::pipelines::Convention;

/// Lights of a batch: one pass writes their bits.
const BATCH: usize = 32;

/// Lights whose bits fit one channel.
const FEW: usize = 8;

/// Pipelines, and a depth and stencil buffer that Rimline owns, for [`SceneFrame::write_masks`].
///
/// The first call makes pipelines, and so does the first call with other formats, another depth direction, or 1, up to 8 or
/// more lights. A change of the image size makes new textures, so use one value for each size. Textures take 5 to 13 bytes
/// for each sample of each pixel. The target of the last call stays alive.
#[derive(Debug)]
pub struct ShadowMasks {
    /// Whether vertex shaders cut volumes at the frustum, see [`ShadowFormat::trim`](crate::gpu::ShadowFormat::trim).
    /// Default: false.
    pub trim: bool,
    shared: Pipelines,
    counting: Vec<(Setting, Arc<Counting>)>,
    writing: Vec<(Writing, wgpu::RenderPipeline)>,
    depth_stencil: Option<Attachment>,
    /// The bits of up to 8 lights, and of more.
    bits: [Option<Attachment>; 2],
    /// The last target, and its layers.
    target: Option<(wgpu::Texture, Vec<wgpu::TextureView>)>,
}

/// The settings of a pipeline that writes targets.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Writing {
    target: wgpu::TextureFormat,
    entry_point: &'static str,
    /// Whether the bits have several samples.
    is_sampled: bool,
}

/// The bits of a batch of lights, and the pipeline that writes them into layers of the target.
struct Bits {
    attachment: Attachment,
    pipeline: wgpu::RenderPipeline,
}

impl Bits {
    /// Records passes that write layers of the target, inside a rectangle.
    fn write(&self, encoder: &mut wgpu::CommandEncoder, layers: &[wgpu::TextureView], rectangle: [u32; 4]) {
        for (layer, view) in (0..).zip(layers) {
            let mut pass = draw_into(encoder, view);
            scissor(&mut pass, rectangle);
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, self.attachment.group.as_ref(), &[]);
            pass.draw(0..3, layer..layer + 1);
        }
    }
}

/// The inputs of [`SceneFrame::write_masks`].
#[derive(Clone, Copy, Debug)]
pub struct MaskInputs<'a> {
    /// The depth of the surfaces that get the light, drawn by the camera of the view before the commands run: a view of the
    /// depth aspect, of level 0 of one layer, of a texture with usage `TEXTURE_BINDING`. Any depth format and number of
    /// samples works. `Depth32Float` needs a device with
    /// [`Features::DEPTH32FLOAT_STENCIL8`](wgpu::Features::DEPTH32FLOAT_STENCIL8).
    pub depth: &'a wgpu::TextureView,
    /// The view of the frame, counted from 0.
    pub view: usize,
    /// The lights. The index in this list is the light's number `i` in the target, not its
    /// [`bit`](LightHandle::bit) in the scene.
    pub lights: &'a [LightHandle],
    /// The masks: a texture with one sample, usage `RENDER_ATTACHMENT` and the size of the depth. The call writes level
    /// 0 of as many layers as the lights need:
    ///
    /// * `R8Uint`, `R32Uint`: bit `i mod 8` of layer `i div 8`, or bit `i mod 32` of layer `i div 32`, is 1 if light
    ///   `i` is in shadow, by sample 0 of the depth; other bits are 0.
    /// * `R8Unorm`: a layer a light, the share of the samples of a pixel that are in shadow: 0 or 1, or antialiased if
    ///   the depth has several samples.
    pub target: &'a wgpu::Texture,
}

impl ShadowMasks {
    /// Makes no pipelines yet. `pipelines` is the caller's device, or the [`Pipelines`] of the scenes.
    ///
    /// # Errors
    /// [`ShadowError::Device`] if the device lacks what shadow volumes need.
    pub fn new(pipelines: impl Into<Pipelines>) -> Result<Self, ShadowError> {
        let shared = pipelines.into();
        shared.clone().construct(Subject::Shadow, || {
            Ok(Self {
                trim: false,
                shared,
                counting: Vec::new(),
                writing: Vec::new(),
                depth_stencil: None,
                bits: [None, None],
                target: None,
            })
        })
    }

    fn counting(&mut self, setting: Setting) -> Result<Arc<Counting>, ShadowError> {
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
    fn writing(&mut self, key: Writing) -> Result<wgpu::RenderPipeline, ShadowError> {
        if let Some((_, made)) = self.writing.iter().find(|(made, _)| *made == key) {
            return Ok(made.clone());
        }
        let Writing { target, entry_point, is_sampled } = key;
        let make = || pipeline(&self.shared, is_sampled, entry_point, target.into(), None, 1);
        let made = tried(self.shared.device(), ["pipelines of masks", ""], make)?;
        self.writing.push((key, made.clone()));
        Ok(made)
    }

    /// The bits of lights that are not drawn into the target directly.
    fn bits(&mut self, setting: &Setting, inputs: &MaskInputs<'_>) -> Result<Bits, ShadowError> {
        let (map, is_few) = (inputs.depth.texture(), inputs.lights.len() <= FEW);
        let entry_point = match inputs.target.format() {
            wgpu::TextureFormat::R8Unorm => "mask_share",
            // Textures with one channel have no other bits.
            wgpu::TextureFormat::R32Uint if !is_few => "mask_word",
            _ => "mask_byte",
        };
        let size = [map.width(), map.height()];
        let [few, many] = &mut self.bits;
        let bits = if is_few { few } else { many };
        let attachment = Attachment::of(bits, &self.shared, size, setting.color, setting.samples)?;
        let target = inputs.target.format();
        let pipeline = self.writing(Writing { target, entry_point, is_sampled: setting.samples > 1 })?;
        Ok(Bits { attachment, pipeline })
    }

    /// The bind group of a depth.
    fn depth_group(&self, depth: &wgpu::TextureView) -> Result<wgpu::BindGroup, ShadowError> {
        let (device, is_sampled) = (self.shared.device(), depth.texture().sample_count() > 1);
        let layout = layout(&self.shared, is_sampled);
        let what = ["the depth", "is it a view of the depth aspect alone, of one layer? "];
        // The group of a destroyed texture would spoil the caller's submission, so none is kept.
        tried(device, what, || group(device, "mask depth", &layout, &[texture(depth)]))
    }

    /// Views of the first layers of a target that a pass can draw into.
    fn layers(&mut self, target: &wgpu::Texture, layers: u32) -> Result<Vec<wgpu::TextureView>, ShadowError> {
        let is_same = |(cached, views): &(wgpu::Texture, Vec<_>)| cached == target && views.len() >= layers as usize;
        let cached = self.target.take().filter(is_same);
        let device = self.shared.device();
        let made = tried(device, ["the target", ""], || {
            if let Some(cached) = cached {
                // The texture may have been destroyed since. No view of it can be made then.
                drop(layer_view(target, 0));
                return cached;
            }
            let views: Vec<_> = (0..layers).map(|layer| layer_view(target, layer)).collect();
            // A destroyed texture, or one of another device, would spoil the caller's encoder. Try it in this one.
            let mut tried = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for view in &views {
                drop(draw_into(&mut tried, view));
            }
            drop(tried.finish());
            (target.clone(), views)
        })?;
        let (_, views) = self.target.insert(made);
        Ok(views.iter().take(layers as usize).cloned().collect())
    }
}

/// The format of the copy of the depth: one that holds every loaded depth exactly, if the device has it.
fn depth_stencil(format: wgpu::TextureFormat, features: wgpu::Features) -> Result<wgpu::TextureFormat, ShadowError> {
    let needed = wgpu::Features::DEPTH32FLOAT_STENCIL8;
    match format {
        _ if features.contains(needed) => Ok(wgpu::TextureFormat::Depth32FloatStencil8),
        wgpu::TextureFormat::Depth32Float => Err(ShadowError::MaskFeature { format, needed }),
        _ => Ok(wgpu::TextureFormat::Depth24PlusStencil8),
    }
}

impl MaskInputs<'_> {
    /// Lights that a layer of the target holds.
    fn lights_a_layer(&self) -> Result<usize, ShadowError> {
        match self.target.format() {
            wgpu::TextureFormat::R8Uint => Ok(8),
            wgpu::TextureFormat::R32Uint => Ok(32),
            wgpu::TextureFormat::R8Unorm => Ok(1),
            format => Err(ShadowError::MaskFormat { format }),
        }
    }

    /// Refuses textures that do not match. Returns the number of layers to write.
    fn check(&self) -> Result<u32, ShadowError> {
        let (map, target) = (self.depth.texture(), self.target);
        let format = map.format();
        if !(format.has_depth_aspect() && map.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING)) {
            return Err(ShadowError::MaskDepth { format });
        }
        let (lights, a_layer) = (self.lights.len(), self.lights_a_layer()?);
        let (samples, dimension, usage) = (target.sample_count(), target.dimension(), target.usage());
        let is_drawn = usage.contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
        if samples > 1 || dimension != wgpu::TextureDimension::D2 || !is_drawn {
            return Err(ShadowError::MaskTarget { samples, dimension, usage });
        }
        let [depth, size] = [map, target].map(|texture| [texture.width(), texture.height()]);
        if depth != size {
            return Err(ShadowError::MaskSize { target: size, depth });
        }
        let (needed, layers) = (lights.div_ceil(a_layer).max(1) as u32, target.depth_or_array_layers());
        if needed > layers {
            return Err(ShadowError::MaskLayers { lights, needed, format: target.format(), layers });
        }
        Ok(needed)
    }
}

impl SceneFrame {
    /// The settings of the pipelines that draw bits.
    fn mask_setting(
        &self,
        convention: Convention,
        trim: bool,
        inputs: &MaskInputs<'_>,
    ) -> Result<Setting, ShadowError> {
        let (map, lights) = (inputs.depth.texture(), inputs.lights.len());
        let samples = map.sample_count();
        let is_direct = lights == 1 && samples == 1;
        Ok(Setting {
            convention,
            is_in_batches: self.count_batches > 1,
            depth_stencil: depth_stencil(map.format(), self.device.features())?,
            color: match lights {
                _ if is_direct => inputs.target.format(),
                ..=FEW => wgpu::TextureFormat::R8Unorm,
                _ => wgpu::TextureFormat::Rgba8Unorm,
            },
            is_direct,
            samples,
            trim,
        })
    }

    /// Writes which lights are in shadow at each pixel, from the depth that the caller drew, for renderers without a
    /// stencil: a bit or a share for each light.
    ///
    /// A mask has no meaning at pixels where nothing was drawn, out of the light's range or cone, and where the side that
    /// is seen is turned away from the light: add no light there. A light out of the view costs nothing. A mask is 0 outside
    /// a rectangle around the light's range and cone.
    ///
    /// On devices with [`Features::DEPTH32FLOAT_STENCIL8`](wgpu::Features::DEPTH32FLOAT_STENCIL8), volumes are compared with
    /// exactly the depth that `textureLoad` returns. Without it, depth of 16 and 24 bits is stored in 24 bits again, and may
    /// differ by one unit in the last place if the device rounds. [`Counting::ZFail`](crate::Counting::ZFail) compares caps
    /// with surfaces at the same depth, so with it casters with an open surface need `Depth32Float`.
    ///
    /// The call records one pass for each 32 lights, and, but for a single light without multisampling, one for each layer that
    /// it writes. One encoder may hold several calls.
    ///
    /// # Errors
    /// [`ShadowError`] if the frame is out of date, an input is refused, the buffer of a caster was destroyed, or the device
    /// lacks something. Nothing is recorded then.
    pub fn write_masks(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        masks: &mut ShadowMasks,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), ShadowError> {
        let MaskInputs { depth, view, lights, target } = *inputs;
        let EncodedView { convention, camera, .. } = self.check_view(view)?;
        let encoded = lights.iter().map(|&light| self.check_drawn(view, light)).collect::<Result<Vec<_>, _>>()?;
        check_same(["`ShadowMasks`", "the scene"], [masks.shared.device(), &self.device])?;
        let layers = inputs.check()?;
        self.structure.check_positions(&masks.shared)?;
        let map = depth.texture();
        let (size, samples) = ([map.width(), map.height()], map.sample_count());
        let bounds = lights.iter().zip(&encoded).map(|(&handle, light)| (handle, affected_pixels(camera, light, size)));
        let bounds: Vec<_> = bounds.collect();
        let setting = self.mask_setting(*convention, masks.trim, inputs)?;
        let bits = if setting.is_direct { None } else { Some(masks.bits(&setting, inputs)?) };
        let stencil = Attachment::of(&mut masks.depth_stencil, &masks.shared, size, setting.depth_stencil, samples)?;
        let depth_group = masks.depth_group(depth)?;
        let views = masks.layers(target, layers)?;
        let counting = masks.counting(setting)?;

        // Outside of it no light has volumes or bits.
        let Some(all) = bounds.iter().filter_map(|(_, pixels)| *pixels).reduce(around) else {
            for view in &views {
                drop(draw_into(encoder, view));
            }
            return Ok(());
        };
        let batches = bounds.chunks(BATCH).zip(views.chunks(BATCH / inputs.lights_a_layer()?));
        let last = batches.len() - 1;
        for (number, (lights, views)) in batches.enumerate() {
            let color = bits.as_ref().map(|bits| &bits.attachment.view).or(views.first());
            let mut pass = begin(encoder, color, &stencil.view, convention.depth, [number == 0, number == last]);
            pass.set_bind_group(0, &depth_group, &[]);
            if number == 0 {
                scissor(&mut pass, all);
                pass.set_pipeline(&counting.depth);
                pass.draw(0..3, 0..1);
            }
            for (bit, &(light, pixels)) in (0..).zip(lights) {
                let Some(pixels) = pixels else { continue };
                scissor(&mut pass, pixels);
                self.record(&mut pass, &counting.volumes, view, light);
                pass.set_pipeline(&counting.bit);
                pass.set_bind_group(0, &depth_group, &[]);
                pass.draw(0..3, bit..bit + 1);
            }
            drop(pass);
            if let Some(bits) = &bits {
                bits.write(encoder, views, all);
            }
        }
        Ok(())
    }
}
