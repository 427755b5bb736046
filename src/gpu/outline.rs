//! Outlines: edges of an extraction or of a scene, drawn as lines.

use std::sync::OnceLock;

use super::common::bindings::{READ, UNIFORM, entries, float_texture, part, texture, whole};
use super::common::device_error::{DeviceError, contain};
use super::common::drawing::{Drawn, depth_stencil};
use super::common::memory::{Allocation, any_error, check_bindings, filled};
use super::common::pipelines::{Pipelines, group};
use super::common::requirements::{Subject, check_alive, check_same};
use super::extract::errors::ExtractorError;
use super::extract::extraction::Extraction;
use super::extract::include::results_bind_group_layout;
use super::scene::frame::SceneFrame;
use super::scene::handles::LightHandle;
use super::scene::outlined::Outlined;
use super::shadow::errors::ShadowError;
use crate::layout::OutlineView;
use crate::shadow::{CameraError, DepthDirection, ShadowCamera};
use crate::stages::{OUTLINE_EDGES, OUTLINE_SAMPLES, SCENE_OUTLINE_EDGES, SCENE_OUTLINE_SAMPLES, Stage};

/// The attachments that an [`OutlinePipeline`] draws into, and the depth that it reads. [`Self::of_pass`] takes them
/// from the descriptor of a pass.
///
/// wgpu panics, or reports a validation error, where a pipeline draws into a pass of other attachments, and a pass does
/// not tell its attachments. [`Self::begin_pass`] compares before it begins a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutlineFormat {
    /// The format of the colour attachment. It is one that blends.
    pub color: wgpu::TextureFormat,
    /// The format of the depth attachment of the pass, if it has one. Outlines neither test nor write it.
    pub depth_stencil: Option<wgpu::TextureFormat>,
    /// Samples a pixel of the attachments.
    pub samples: u32,
    /// Whether the depth that hides lines is in a multisampled texture. Sample 0 of each pixel is read.
    pub is_depth_multisampled: bool,
}

impl OutlineFormat {
    /// The format for passes like this one, with this depth for [`OutlineInputs::depth`].
    ///
    /// Formats are those of the textures. For a view that was made with another format, as an sRGB view of a linear
    /// texture is, set [`Self::color`].
    ///
    /// # Errors
    /// [`OutlineError::Colors`] if the pass has not exactly one colour attachment.
    pub fn of_pass(pass: &wgpu::RenderPassDescriptor<'_>, depth: &wgpu::TextureView) -> Result<Self, OutlineError> {
        Ok(Self { is_depth_multisampled: depth.texture().sample_count() > 1, ..Self::of_attachments(pass)? })
    }

    /// The format for the attachments of a pass, and depth of one sample.
    fn of_attachments(pass: &wgpu::RenderPassDescriptor<'_>) -> Result<Self, OutlineError> {
        let [Some(color)] = pass.color_attachments else {
            return Err(OutlineError::Colors { given: pass.color_attachments.iter().flatten().count() });
        };
        let color = color.view.texture();
        let depth_stencil = pass.depth_stencil_attachment.as_ref().map(|attachment| attachment.view.texture().format());
        Ok(Self { color: color.format(), depth_stencil, samples: color.sample_count(), is_depth_multisampled: false })
    }

    /// Begins a pass into which an outline of this format is drawn.
    ///
    /// Colour formats that differ only in sRGB are taken, because a view does not tell its own format. wgpu reports them.
    ///
    /// # Errors
    /// [`OutlineError::Colors`] if the pass has not exactly one colour attachment.
    /// [`OutlineError::OtherAttachments`] if the formats or samples of the attachments differ from those of this
    /// format. Nothing is begun then.
    pub fn begin_pass<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        pass: &wgpu::RenderPassDescriptor<'_>,
    ) -> Result<wgpu::RenderPass<'encoder>, OutlineError> {
        let given = Self { is_depth_multisampled: self.is_depth_multisampled, ..Self::of_attachments(pass)? };
        let without_srgb = |format: &Self| Self { color: format.color.remove_srgb_suffix(), ..format.clone() };
        if without_srgb(&given) != without_srgb(self) {
            return Err(OutlineError::OtherAttachments { pass: Box::new(given), format: Box::new(self.clone()) });
        }
        Ok(encoder.begin_render_pass(pass))
    }

    /// The attachments, for messages.
    fn attachments(&self) -> String {
        let Self { color, depth_stencil, samples, .. } = self;
        let depth = depth_stencil.map_or("no depth".to_owned(), |format| format!("{format:?}"));
        format!("{color:?}, {depth} and {samples} samples a pixel")
    }
}

impl Default for OutlineFormat {
    /// `Bgra8UnormSrgb`, no depth attachment, one sample each.
    fn default() -> Self {
        Self {
            color: wgpu::TextureFormat::Bgra8UnormSrgb,
            depth_stencil: None,
            samples: 1,
            is_depth_multisampled: false,
        }
    }
}

/// How outlines look. Colours are RGBA from 0 to 1, not premultiplied; in an sRGB target they are linear. A class without a
/// colour is not drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlineStyle {
    /// The width of lines in pixels. Lines of less than a pixel are fainter. Time grows with the pixels that lines cover:
    /// lines thousands of pixels wide take long.
    pub width: f32,
    /// The colour of edges between a face that faces the eye and one that does not.
    pub silhouette: Option<[f32; 4]>,
    /// The colour of edges with one face.
    pub boundary: Option<[f32; 4]>,
    /// The colour of edges between faces that meet at more than [`Self::crease_angle`], if they are no silhouettes. A
    /// polygon that is one face ([`Mesh::from_polygons_by_loop`](crate::Mesh::from_polygons_by_loop)) has the normal of
    /// its first triangle.
    pub crease: Option<[f32; 4]>,
    /// The largest angle between the normals of two faces that make no crease, in radians.
    pub crease_angle: f32,
    /// The colour of the edges of [`OutlineInputs::marked`], if they are nothing else that is drawn.
    pub marked: Option<[f32; 4]>,
    /// A line is visible up to this much behind the drawn depth, in units of depth. Slopes of surfaces are allowed for in
    /// any case. It covers the rounding of depth: a few units in its last place, so 4e-5 for `Depth16Unorm`.
    pub depth_bias: f32,
}

impl Default for OutlineStyle {
    /// Two pixels, black silhouettes and boundaries, nothing else, creases from 33°, a bias of 1e-6.
    fn default() -> Self {
        const BLACK: Option<[f32; 4]> = Some([0.0, 0.0, 0.0, 1.0]);
        Self {
            width: 2.0,
            silhouette: BLACK,
            boundary: BLACK,
            crease: None,
            // No regular prism has this angle, as one of twelve sides has 30°: rounding would decide there edge by edge.
            crease_angle: 33.0_f32.to_radians(),
            marked: None,
            depth_bias: 1e-6,
        }
    }
}

/// The edges that outlines show, and the light that stands for the eye: for a perspective camera
/// [`Light::point`](crate::Light::point) at the eye, for an orthographic one
/// [`Light::directional`](crate::Light::directional) towards it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum OutlineSource<'a> {
    /// The edges of an extraction, and the number of the light. The extractor has lists of quads, the default.
    Extraction(&'a Extraction, usize),
    /// The edges of all casters of a frame of a scene, and a light of that frame, with one draw for each group of
    /// casters. Leave the light out of all views by [`View::lights`](crate::gpu::View::lights), else the encode
    /// prepares shadow volumes for it; an encode without [views](crate::gpu::FrameInputs::views) prepares none. A
    /// caster has no outline if its [`Caster::lights`](crate::gpu::Caster::lights) lack the light, if it is out of the
    /// light's range or cone (so give it neither), or if [`Scene::set_occluders`](crate::gpu::Scene::set_occluders)
    /// hide it from the light. An instance of a model beside the picture may have none, though half of a wide line could
    /// reach into the picture. Faces that count nowhere in shadows, by
    /// [`Scene::set_excluded`](crate::gpu::Scene::set_excluded), have outlines like all others.
    ///
    /// ```no_run
    /// use rimline::gpu::{FrameInputs, LightHandle, LightMask, View};
    /// use rimline::gpu::{OutlineInputs, OutlinePipeline, OutlineSource, OutlineStyle, Scene};
    /// # use rimline::{Light, ShadowCamera, wgpu};
    /// # fn outlines(scene: &mut Scene, eye: LightHandle, outlines: &OutlinePipeline, encoder: &mut wgpu::CommandEncoder,
    /// #     (camera, position): (&ShadowCamera, [f32; 3]), depth: &wgpu::TextureView, pass: &wgpu::RenderPassDescriptor<'_>)
    /// #     -> Result<(), Box<dyn std::error::Error>> {
    /// // Once: let eye = scene.add_light(Light::point(position))?;
    /// scene.set_light(eye, Light::point(position))?;
    /// let view = View { lights: LightMask::ALL.without(eye), ..View::new(*camera) }; // the eye casts no shadows
    /// let frame = scene.encode(encoder, FrameInputs::new(&[view]))?;
    /// let (of, style) = (OutlineSource::Scene(&frame, eye), OutlineStyle::default());
    /// let outline = outlines.prepare(&OutlineInputs { of, camera, depth, style, marked: None })?;
    /// outline.draw(&mut encoder.begin_render_pass(pass))?;
    /// # Ok(()) }
    /// ```
    Scene(&'a SceneFrame, LightHandle),
}

/// The outline to draw.
#[derive(Clone, Copy, Debug)]
pub struct OutlineInputs<'a> {
    /// The edges, and the light that stands for the eye.
    pub of: OutlineSource<'a>,
    /// The camera. It maps the positions of the extraction, or for a scene world space. If the scene has models and the
    /// encode has views, the camera is that of a view: models that no view needs are not deformed.
    pub camera: &'a ShadowCamera,
    /// The depth of what hides lines, the model itself too, drawn by this camera. It is a view of level 0 of one layer
    /// with the depth aspect only, of a texture with usage `TEXTURE_BINDING`. It may be the depth attachment of the
    /// pass if that is read-only there; wgpu refuses that on OpenGL. Its size is that of the picture, else lines are missing.
    pub depth: &'a wgpu::TextureView,
    /// How lines look.
    pub style: OutlineStyle,
    /// A bit for each edge record of the mesh, least significant first, in 32-bit words: the edges that are drawn as
    /// [marked](OutlineStyle::marked). A buffer with usage `STORAGE`. Outlines of scenes have none.
    pub marked: Option<&'a wgpu::Buffer>,
}

/// Why outlines cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum OutlineError {
    /// The device lacks what outlines need, or is lost, or objects of two devices were used together.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The camera is refused.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The extraction has no such light, is out of date, or lacks what outlines read.
    #[error(transparent)]
    Extraction(ExtractorError),
    /// The scene's frame has no such light, or is out of date.
    #[error(transparent)]
    Scene(ShadowError),
    /// Edges of a scene are marked.
    #[error(
        "edges of scenes cannot be marked; set `OutlineInputs::marked` to `None`, or take the caster's own extraction"
    )]
    MarkedScene,
    /// Models in the scene may not be deformed for this camera.
    #[error(
        "the camera is none of the encode's views, which decide the models that are deformed; add it to `FrameInputs::views`"
    )]
    NoView,
    /// The pass has no colour attachment, or several, and outlines are drawn into one.
    #[error(
        "the pass has {given} colour attachments, and outlines are drawn into one; draw them in a pass of their own"
    )]
    Colors { given: usize },
    /// A pass has other attachments than the pipeline was made for.
    #[error(
        "the pass has {}, and the outline is drawn into {}; make the pipeline with `OutlineFormat::of_pass` of the same pass",
        .pass.attachments(), .format.attachments()
    )]
    OtherAttachments { pass: Box<OutlineFormat>, format: Box<OutlineFormat> },
    /// The extractor's draws have too few vertices.
    #[error(
        "the extractor draws {given} vertices for each edge, and outlines need 4; set `ListOptions::topology` to a triangle strip"
    )]
    Vertices { given: u32 },
    /// The depth texture has no depth, or shaders may not read it.
    #[error("the depth texture, of format {format:?}, cannot be read; give one with depth and usage TEXTURE_BINDING")]
    Depth { format: wgpu::TextureFormat },
    /// The depth texture is not what the pipeline was made for.
    #[error(
        "the depth texture has {given} samples a pixel, and the pipeline reads {}; set `OutlineFormat::is_depth_multisampled`",
        if *.is_depth_multisampled { "several" } else { "one" }
    )]
    DepthSamples { given: u32, is_depth_multisampled: bool },
    /// There are too few marks.
    #[error(
        "the marks have {given} bytes, and {edges} edge records need {needed}; give a bit for each, in 32-bit words"
    )]
    Marks { given: u64, needed: u64, edges: usize },
    /// Width, angle or bias is negative or not finite.
    #[error("`{field}` of the style is {given}; it must be finite and not negative")]
    Style { field: &'static str, given: f32 },
    /// The device refuses the attachments or a resource.
    #[error("the device refuses outlines: {message}")]
    Refused { message: String },
}

contain!(ExtractorError in OutlineError::Extraction but Device);
contain!(ShadowError in OutlineError::Scene but Device);

/// Draws edges of extractions and of scenes as lines of a width in pixels, with round joins, smoothed by coverage, and
/// hidden behind the depth that the caller drew. Nothing is read back. The page of the crate has an example, and
/// [`OutlineSource`] one with a scene.
///
/// A line is hidden where the depth at the line says so, not at the pixel beside it. It can be up to a pixel too long
/// at what hides it, and within two pixels of the picture's border parts may be missing. Lines of a translucent colour
/// are darker where they join, and so, a little, are the soft borders of all lines.
#[derive(Debug)]
pub struct OutlinePipeline {
    shared: Pipelines,
    format: OutlineFormat,
    of_extractions: Pair,
    of_scenes: Pair,
}

/// The pipelines of extractions, or those of scenes. Each is made when it is first prepared, the silhouettes of extractions
/// with [`OutlinePipeline::new`].
#[derive(Debug)]
struct Pair {
    stage: &'static Stage,
    layouts: [wgpu::BindGroupLayout; 2],
    silhouettes: OnceLock<wgpu::RenderPipeline>,
    /// Creases and marked edges.
    features: OnceLock<wgpu::RenderPipeline>,
}

/// An outline that is ready to be drawn.
#[derive(Clone, Debug)]
pub struct Outline {
    source: Source,
    parts: Vec<Part>,
}

/// The results that an outline reads. It keeps their buffers alive.
#[derive(Clone, Debug)]
enum Source {
    Extraction(Extraction),
    Scene(SceneFrame),
}

/// The draws of an extraction, or of a group of casters.
#[derive(Clone, Debug)]
struct Part {
    groups: [wgpu::BindGroup; 2],
    silhouettes: Option<Silhouettes>,
    /// The pipeline of creases and marked edges, and the number of edge records, or of edge slots in a scene.
    features: Option<(wgpu::RenderPipeline, u32)>,
}

/// The draw of silhouettes and boundaries.
#[derive(Clone, Debug)]
struct Silhouettes {
    pipeline: wgpu::RenderPipeline,
    /// The buffer of its arguments, and their offset.
    arguments: wgpu::Buffer,
    offset: u64,
}

impl Part {
    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        for (index, group) in (0..).zip(&self.groups) {
            pass.set_bind_group(index, group, &[]);
        }
    }
}

impl Outline {
    /// Draws the outline into a pass with the attachments of the pipeline's format, from [`OutlineFormat::of_pass`]. It sets
    /// pipelines and bind groups 0 and 1. [`OutlineFormat::begin_pass`] begins such a pass, and refuses others.
    ///
    /// # Errors
    /// [`ExtractorError::Stale`] if the extractor was encoded again, [`ShadowError::StaleFrame`] if the scene was.
    /// Nothing is drawn then.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) -> Result<(), OutlineError> {
        match &self.source {
            Source::Extraction(extraction) => extraction.check_current()?,
            Source::Scene(frame) => frame.check_current()?,
        }
        for part in &self.parts {
            if let Some((pipeline, edges)) = &part.features {
                part.bind(pass);
                pass.set_pipeline(pipeline);
                pass.draw(0..4, 0..*edges);
            }
        }
        for part in &self.parts {
            if let Some(Silhouettes { pipeline, arguments, offset }) = &part.silhouettes {
                part.bind(pass);
                pass.set_pipeline(pipeline);
                pass.draw_indirect(arguments, *offset);
            }
        }
        Ok(())
    }
}

impl OutlinePipeline {
    /// Makes the pipeline. `pipelines` is the caller's device, or the [`Pipelines`] of the extractor or scene.
    ///
    /// # Errors
    /// [`OutlineError`] if the device lacks what outlines need, or cannot draw into the attachments.
    pub fn new(pipelines: impl Into<Pipelines>, format: &OutlineFormat) -> Result<Self, OutlineError> {
        let shared = pipelines.into();
        shared.clone().construct(Subject::Shadow, || {
            let device = shared.device().clone();
            let stages = if format.is_depth_multisampled {
                [&OUTLINE_SAMPLES, &SCENE_OUTLINE_SAMPLES]
            } else {
                [&OUTLINE_EDGES, &SCENE_OUTLINE_EDGES]
            };
            let made = any_error(&device, || {
                let results = results_bind_group_layout(&device, wgpu::ShaderStages::VERTEX);
                let [of_extractions, of_scenes] =
                    [(results, true), (scene_layout(&shared), false)].map(|(first, marks)| {
                        let layouts = [first, view_layout(&shared, format.is_depth_multisampled, marks)];
                        let stage = stages[usize::from(!marks)];
                        Pair { stage, layouts, silhouettes: OnceLock::new(), features: OnceLock::new() }
                    });
                of_extractions.silhouettes(&shared, format);
                Self { format: format.clone(), of_extractions, of_scenes, shared }
            });
            made.map_err(|message| OutlineError::Refused { message })
        })
    }

    /// Makes what a draw of the outline reads. It is right for the camera and the style given here, and until the
    /// extractor or the scene is encoded again.
    ///
    /// # Errors
    /// [`OutlineError`] if an input is refused.
    pub fn prepare(&self, inputs: &OutlineInputs<'_>) -> Result<Outline, OutlineError> {
        let OutlineInputs { of, camera, depth, style, marked } = *inputs;
        let device = self.shared.device();
        let (what, theirs) = match of {
            OutlineSource::Extraction(extraction, _) => ("the extraction", extraction.shared.device()),
            OutlineSource::Scene(frame, _) => ("the scene", &frame.device),
        };
        check_same([what, "the outline's pipeline"], [theirs, device])?;
        check_alive(device)?;
        camera.check_any_hand()?;
        style.check()?;
        self.check_depth(depth)?;
        match of {
            OutlineSource::Extraction(extraction, light) => {
                let view = style.view(camera, light, depth, marked.is_some());
                let parts = vec![self.of_extraction(extraction, light, depth, marked, &view)?];
                Ok(Outline { source: Source::Extraction(extraction.clone()), parts })
            }
            OutlineSource::Scene(frame, light) => {
                frame.check_current()?;
                frame.check_light(light)?;
                if marked.is_some() {
                    return Err(OutlineError::MarkedScene);
                }
                if !frame.has_positions_for(camera) {
                    return Err(OutlineError::NoView);
                }
                let parts = self.of_scene(frame, light, depth, &style.view(camera, 0, depth, false))?;
                Ok(Outline { source: Source::Scene(frame.clone()), parts })
            }
        }
    }

    fn check_depth(&self, depth: &wgpu::TextureView) -> Result<(), OutlineError> {
        let map = depth.texture();
        let format = map.format();
        if !(format.has_depth_aspect() && map.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING)) {
            return Err(OutlineError::Depth { format });
        }
        let is_depth_multisampled = self.format.is_depth_multisampled;
        if (map.sample_count() > 1) != is_depth_multisampled {
            return Err(OutlineError::DepthSamples { given: map.sample_count(), is_depth_multisampled });
        }
        Ok(())
    }

    fn of_extraction(
        &self,
        extraction: &Extraction,
        light: usize,
        depth: &wgpu::TextureView,
        marked: Option<&wgpu::Buffer>,
        view: &OutlineView,
    ) -> Result<Part, OutlineError> {
        let (device, shared) = (self.shared.device(), &extraction.shared);
        let (arguments, offset) = extraction.draw_arguments(light)?;
        if let given @ ..4 = shared.vertices_per_edge {
            return Err(OutlineError::Vertices { given });
        }
        let edges = shared.shape.edges;
        // Marks of no edges may be a buffer of 0 bytes, which cannot be bound.
        let marked = marked.filter(|_| edges > 0);
        let needed = 4 * edges.div_ceil(32) as u64;
        if let Some(given) = marked.map(wgpu::Buffer::size).filter(|&given| given < needed) {
            return Err(OutlineError::Marks { given, needed, edges });
        }
        let arrays = [("faces", shared.buffers.faces.size()), ("marks", marked.map_or(0, |_| needed))];
        check_bindings(&arrays.map(|(label, bytes)| Allocation { label, bytes }), shared.limits.binding)?;
        let pair = &self.of_extractions;
        let results = extraction.bind_group(&pair.layouts[0], light / 32)?;
        let of_view = any_error(device, || {
            let view = filled(device, "outline view", bytemuck::bytes_of(view), wgpu::BufferUsages::UNIFORM);
            // The caller's buffer may be longer, by any number of bytes.
            let marks = marked.map_or_else(|| whole(&shared.buffers.unused), |marks| part(marks, 0..needed));
            let resources = [whole(&view), texture(depth), whole(&shared.buffers.faces), marks];
            group(device, "outline", &pair.layouts[1], &resources)
        });
        let hint = "is `depth` a view of the depth aspect alone, of one layer, and has `marked` usage STORAGE?";
        let of_view = of_view.map_err(|message| OutlineError::Refused { message: format!("{hint} {message}") })?;
        Ok(self.part(pair, view, [results, of_view], edges as u32, (arguments, offset)))
    }

    fn of_scene(
        &self,
        frame: &SceneFrame,
        light: LightHandle,
        depth: &wgpu::TextureView,
        view: &OutlineView,
    ) -> Result<Vec<Part>, OutlineError> {
        let (device, pair) = (self.shared.device(), &self.of_scenes);
        let made = any_error(device, || {
            let of_view = filled(device, "outline view", bytemuck::bytes_of(view), wgpu::BufferUsages::UNIFORM);
            let part = |outlined: Outlined<'_>| {
                let of_group = outlined.uniform();
                let of_group =
                    filled(device, "outlined group", bytemuck::bytes_of(&of_group), wgpu::BufferUsages::UNIFORM);
                let resources: Vec<_> = std::iter::once(whole(&of_group)).chain(outlined.resources()).collect();
                let edges = group(device, "outlined edges", &pair.layouts[0], &resources);
                let resources = [whole(&of_view), texture(depth), whole(&outlined.topology.page.faces)];
                let of_style = group(device, "outline", &pair.layouts[1], &resources);
                self.part(pair, view, [edges, of_style], outlined.edges(), outlined.arguments())
            };
            frame.outlined(light).map(part).collect()
        });
        made.map_err(|message| OutlineError::Refused { message })
    }

    fn part(
        &self,
        pair: &Pair,
        view: &OutlineView,
        groups: [wgpu::BindGroup; 2],
        edges: u32,
        (arguments, offset): (&wgpu::Buffer, u64),
    ) -> Part {
        let draws = |classes: u32| view.classes & classes != 0;
        let features = (draws(0b1100) && edges > 0).then(|| (pair.features(&self.shared, &self.format).clone(), edges));
        let silhouettes = || {
            let pipeline = pair.silhouettes(&self.shared, &self.format).clone();
            Silhouettes { pipeline, arguments: arguments.clone(), offset }
        };
        Part { groups, silhouettes: draws(0b11).then(silhouettes), features }
    }
}

impl Pair {
    fn silhouettes(&self, shared: &Pipelines, format: &OutlineFormat) -> &wgpu::RenderPipeline {
        self.silhouettes.get_or_init(|| pipeline(shared, format, self, "outline_silhouette"))
    }

    fn features(&self, shared: &Pipelines, format: &OutlineFormat) -> &wgpu::RenderPipeline {
        self.features.get_or_init(|| pipeline(shared, format, self, "outline_feature"))
    }
}

impl OutlineStyle {
    fn check(&self) -> Result<(), OutlineError> {
        let fields = [("width", self.width), ("crease_angle", self.crease_angle), ("depth_bias", self.depth_bias)];
        match fields.into_iter().find(|(_, given)| !(given.is_finite() && *given >= 0.0)) {
            Some((field, given)) => Err(OutlineError::Style { field, given }),
            None => Ok(()),
        }
    }

    fn view(&self, camera: &ShadowCamera, light: usize, depth: &wgpu::TextureView, has_marks: bool) -> OutlineView {
        let size = [depth.texture().width(), depth.texture().height()];
        let colors = [self.silhouette, self.boundary, self.crease, self.marked.filter(|_| has_marks)];
        let classes = (0..).zip(colors).fold(0, |bits, (class, color)| bits | u32::from(color.is_some()) << class);
        // A line of less than a pixel is one of a pixel that is fainter.
        let fainter = |[red, green, blue, alpha]: [f32; 4]| [red, green, blue, alpha * self.width.min(1.0)];
        let [silhouette, boundary, crease, marked] = colors.map(|color| color.map_or([0.0; 4], fainter));
        OutlineView {
            columns: camera.view_projection,
            origin: camera.origin,
            half_width: 0.5 * self.width.max(1.0),
            silhouette,
            boundary,
            crease,
            marked,
            size: size.map(|pixels| pixels as f32),
            depth_bias: self.depth_bias,
            crease_cosine: self.crease_angle.min(std::f32::consts::PI).cos(),
            light: light as u32,
            classes,
            is_reversed: u32::from(camera.depth == DepthDirection::Reversed),
            reserved: 0,
        }
    }
}

/// The layout of a group of casters and a light.
fn scene_layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    let types = (0..).zip([UNIFORM].into_iter().chain([READ; 7]));
    pipelines.layout("outlined edges", entries(wgpu::ShaderStages::VERTEX, types))
}

/// The layout of the bind group beside the results.
fn view_layout(pipelines: &Pipelines, is_depth_multisampled: bool, has_marks: bool) -> wgpu::BindGroupLayout {
    let depth = float_texture(is_depth_multisampled);
    let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
    let types = [(vertex | fragment, UNIFORM), (fragment, depth), (vertex, READ), (vertex, READ)];
    let types = types.into_iter().take(if has_marks { 4 } else { 3 });
    let entry = |(binding, (visibility, ty))| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    pipelines.layout("outline", (0..).zip(types).map(entry).collect())
}

fn pipeline(
    shared: &Pipelines,
    format: &OutlineFormat,
    Pair { stage, layouts, .. }: &Pair,
    entry_point: &str,
) -> wgpu::RenderPipeline {
    let module = &shared.module(stage.module, &stage.wgsl());
    let [results, view] = layouts;
    let state = |format| depth_stencil(format, false, wgpu::CompareFunction::Always, wgpu::StencilState::default());
    shared.draws(&Drawn {
        label: entry_point,
        layouts: &[results, view],
        vertex: (module, entry_point),
        fragment: Some((module, "outline_ink")),
        constants: &[],
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        depth_stencil: format.depth_stencil.map(state),
        samples: format.samples,
        targets: &[Some(wgpu::ColorTargetState {
            format: format.color,
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            write_mask: wgpu::ColorWrites::ALL,
        })],
    })
}
