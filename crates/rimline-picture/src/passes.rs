//! The passes of a picture with shadows: ambient light, then a pass for each light, whose shadows the stencil counts.

use wgpu::{BlendState, ColorWrites, CompareFunction, StencilFaceState, StencilOperation, TextureFormat};

use crate::bindings::depth_format;
use crate::factory::{ADD, MULTIPLY, PipelineDescriptor, color_pass, depth_state, view};
use crate::resources::Resources;
use crate::surface::Surface;
use crate::targets::{Attachments, PictureFormat, Target, Targets};

/// A scene that is drawn.
pub trait Subject {
    /// Why shadow volumes or overlays cannot be drawn.
    type Error;

    /// The number of lights, or of the samples of all lights.
    fn lights(&self) -> usize;

    /// Whether there is a ground.
    fn has_ground(&self) -> bool;

    /// The surfaces of the models.
    fn surfaces(&self) -> &[Surface];

    /// Draws the shadow volumes of a light into the stencil, which is not 0 in shadow afterwards. The pass has no colour.
    ///
    /// # Errors
    /// [`Self::Error`].
    fn draw_volumes(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Self::Error>;

    /// Whether [`Self::draw_overlays`] draws anything.
    fn has_overlays(&self) -> bool;

    /// Draws over the finished light. Pictures of several samples a pixel call it also without overlays.
    ///
    /// # Errors
    /// [`Self::Error`].
    fn draw_overlays(&self, pass: &mut wgpu::RenderPass<'_>) -> Result<(), Self::Error>;

    /// Prepares each pass.
    fn begin<'e>(&self, pass: wgpu::RenderPass<'e>) -> wgpu::RenderPass<'e> {
        pass
    }
}

/// How shadows are drawn, as `rimline shadow --mode` has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Each light adds its light where it is not in shadow.
    #[default]
    Additive,
    /// Full light; points in the shadow of any light have ambient light only.
    Ambient,
    /// Full light; points in the shadow of any light are black.
    Black,
    /// Full light; each shadow halves it.
    Composited,
}

impl Mode {
    /// All of them, with the names that the command gives them.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::Additive, "additive"),
        (Self::Ambient, "ambient"),
        (Self::Black, "black"),
        (Self::Composited, "composited"),
    ];

    /// The name that the command gives it.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// The pipelines of a picture.
#[derive(Debug)]
pub struct PicturePipelines {
    format: PictureFormat,
    backdrop: wgpu::RenderPipeline,
    ambient: ReceiverPipelines,
    lit: ReceiverPipelines,
    /// Marks what turns its back on the light, then shades what is marked or in shadow.
    shade: Option<[ReceiverPipelines; 2]>,
    mode: Mode,
    tone: wgpu::RenderPipeline,
}

impl PicturePipelines {
    /// For pictures of a format with shadows of a mode.
    pub fn new(resources: &Resources, format: PictureFormat, mode: Mode) -> Self {
        let factory = &resources.factory;
        let (source, target) = (include_str!("picture.wgsl"), format.light());
        let tone = match (format.in_parts, format.is_encoded) {
            (true, _) => "tone_parts",
            (false, true) => "tone_encoded",
            (false, false) => "tone",
        };
        // Where nothing was drawn, depth is still 0.
        let equal = CompareFunction::Equal;
        let behind = depth_state(depth_format(&factory.device), false, equal, StencilFaceState::IGNORE);
        let backdrop = PipelineDescriptor {
            samples: target.samples,
            depth: Some(behind),
            ..PipelineDescriptor::over("backdrop", source, &[], target.format)
        };
        let light = format.light_layout(factory);
        let lit = ReceiverPass::new(target, "lit", Onto::Lit);
        let mut pipelines = Self {
            format,
            backdrop: factory.pipeline(&backdrop),
            ambient: ReceiverPipelines::new(resources, ReceiverPass::new(target, "ambient", Onto::Nearest)),
            lit: ReceiverPipelines::new(resources, ReceiverPass { blend: Some(ADD), ..lit }),
            shade: None,
            mode: Mode::Additive,
            tone: factory.pipeline(&PipelineDescriptor::over(tone, source, &[&light], format.picture())),
        };
        pipelines.set_mode(resources, mode);
        pipelines
    }

    /// The format of the pictures.
    pub fn format(&self) -> PictureFormat {
        self.format
    }

    /// Makes what another mode needs.
    pub fn set_mode(&mut self, resources: &Resources, mode: Mode) {
        if self.mode == mode {
            return;
        }
        let shade = match mode {
            Mode::Additive => None,
            Mode::Ambient => Some(("ambient", None)),
            Mode::Black => Some(("black", None)),
            Mode::Composited => Some(("dim", Some(MULTIPLY))),
        };
        let target = self.format.light();
        self.mode = mode;
        self.shade = shade.map(|(fragment, blend)| {
            let marking = ReceiverPass::new(target, "back_facing", Onto::Lit);
            let shading = ReceiverPass::new(target, fragment, Onto::Shadowed);
            [ReceiverPass { write: ColorWrites::empty(), ..marking }, ReceiverPass { blend, ..shading }]
                .map(|pass| ReceiverPipelines::new(resources, pass))
        });
    }

    /// Records the light of the whole picture, or of a part.
    ///
    /// # Errors
    /// The errors of the subject.
    pub fn record<S: Subject>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        attachments: &Attachments,
        subject: &S,
    ) -> Result<(), S::Error> {
        self.record_receivers(encoder, resources, attachments, subject);
        self.record_lights(encoder, resources, attachments, subject)
    }

    /// Records what is seen in ambient light, and its depth. It needs positions and normals, but no facing masks.
    pub fn record_receivers<S: Subject>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        attachments: &Attachments,
        subject: &S,
    ) {
        let mut pass = subject.begin(attachments.pass(encoder, "ambient", Some(wgpu::Color::BLACK)));
        self.ambient.paint(&mut pass, resources, subject, 0);
        resources.factory.draw(&mut pass, &self.backdrop, &[], 3);
    }

    /// Records the light that falls on [`Self::record_receivers`].
    ///
    /// # Errors
    /// The errors of the subject.
    pub fn record_lights<S: Subject>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        attachments: &Attachments,
        subject: &S,
    ) -> Result<(), S::Error> {
        for light in 0..subject.lights() {
            let mut volumes = subject.begin(attachments.count_pass(encoder));
            if self.shade.is_none() {
                subject.draw_volumes(&mut volumes, light)?;
            }
            drop(volumes);
            let mut pass = subject.begin(attachments.pass(encoder, "light", None));
            self.lit.paint(&mut pass, resources, subject, light);
        }
        if let Some(shade) = &self.shade {
            for light in 0..subject.lights() {
                subject.draw_volumes(&mut subject.begin(attachments.count_pass(encoder)), light)?;
                let mut pass = subject.begin(attachments.pass(encoder, "shade", None));
                for receivers in shade {
                    receivers.paint(&mut pass, resources, subject, light);
                }
            }
        }
        if subject.has_overlays() || attachments.resolved.is_some() {
            subject.draw_overlays(&mut subject.begin(attachments.last_pass(encoder)))?;
        }
        Ok(())
    }

    /// Records how the light becomes the picture.
    pub fn develop(&self, encoder: &mut wgpu::CommandEncoder, resources: &Resources, targets: &Targets) {
        let (target, black) = (view(&targets.picture), Some(wgpu::Color::BLACK));
        let mut pass = color_pass(encoder, "tone", (&target, None), black, None);
        resources.factory.draw(&mut pass, &self.tone, &[&targets.light], 3);
    }
}

/// Surfaces that a pass draws onto.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Onto {
    /// The nearest surface, which this pass finds.
    Nearest,
    /// The nearest again, where the stencil is still 0; which it is no more afterwards, so that faces that coincide add
    /// their light once.
    Lit,
    /// The nearest again, where the stencil is not 0; which it is afterwards.
    Shadowed,
    /// The nearest again, for any stencil.
    Again,
}

impl Onto {
    /// The state of depth and stencil.
    pub fn state(self, format: TextureFormat) -> wgpu::DepthStencilState {
        let (compare, stencil, pass_op) = match self {
            Self::Nearest => (CompareFunction::Greater, CompareFunction::Always, StencilOperation::Keep),
            Self::Lit => (CompareFunction::Equal, CompareFunction::Equal, StencilOperation::IncrementClamp),
            Self::Shadowed => (CompareFunction::Equal, CompareFunction::NotEqual, StencilOperation::Zero),
            Self::Again => (CompareFunction::Equal, CompareFunction::Always, StencilOperation::Keep),
        };
        let face = StencilFaceState { compare: stencil, pass_op, ..StencilFaceState::IGNORE };
        depth_state(format, self == Self::Nearest, compare, face)
    }
}

/// How a pass draws onto models and ground.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverPass {
    /// Its target.
    pub target: Target,
    /// The name of its fragment shaders.
    pub fragment: &'static str,
    /// The surfaces that it draws onto.
    pub onto: Onto,
    /// How colours are blended, if they are.
    pub blend: Option<BlendState>,
    /// The channels that are written.
    pub write: ColorWrites,
}

impl ReceiverPass {
    /// Writes all channels over what is there.
    pub fn new(target: Target, fragment: &'static str, onto: Onto) -> Self {
        Self { target, fragment, onto, blend: None, write: ColorWrites::ALL }
    }

    /// The pipeline of [`Surface::draw`].
    pub fn surface_pipeline(&self, resources: &Resources) -> wgpu::RenderPipeline {
        let source = include_str!("surface.wgsl");
        self.pipeline(resources, ("surface", source), &[&resources.light, &resources.surface])
    }

    fn pipeline(
        &self,
        resources: &Resources,
        (vertex, source): (&str, &str),
        groups: &[&wgpu::BindGroupLayout],
    ) -> wgpu::RenderPipeline {
        let Self { target, fragment, onto, blend, write } = *self;
        let factory = &resources.factory;
        let depth = Some(onto.state(depth_format(&factory.device)));
        let descriptor = PipelineDescriptor::new(fragment, source, groups, target.format);
        factory.pipeline(&PipelineDescriptor { vertex, blend, samples: target.samples, write, depth, ..descriptor })
    }
}

/// Draws models and ground with fragment shaders of one name.
#[derive(Debug)]
pub struct ReceiverPipelines {
    surface: wgpu::RenderPipeline,
    ground: wgpu::RenderPipeline,
}

impl ReceiverPipelines {
    /// For a pass.
    pub fn new(resources: &Resources, pass: ReceiverPass) -> Self {
        let (vertex, source) = ("ground", include_str!("ground.wgsl"));
        let ground = pass.pipeline(resources, (vertex, source), &[&resources.light]);
        Self { surface: pass.surface_pipeline(resources), ground }
    }

    /// Draws everything for one light.
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>, resources: &Resources, subject: &impl Subject, light: usize) {
        resources.select(pass, light);
        pass.set_pipeline(&self.surface);
        subject.surfaces().iter().for_each(|surface| surface.draw(pass, light));
        if subject.has_ground() {
            pass.set_pipeline(&self.ground);
            pass.draw(0..12, 0..1);
        }
    }
}

#[cfg(test)]
mod tests {
    /// Such branches made Mesa's software Vulkan compile shaders anew in each frame, and keep all of them: a megabyte a frame.
    #[test]
    fn nothing_branches_on_uniforms_alone() {
        let of_command = concat!(env!("CARGO_MANIFEST_DIR"), "/../rimline-cli/src/shadow/depth_overlay.wgsl");
        let of_command = std::fs::read_to_string(of_command).expect("the command has an overlay of maps");
        let sources = [
            include_str!("common.wgsl"),
            include_str!("scene.wgsl"),
            include_str!("surface.wgsl"),
            include_str!("ground.wgsl"),
            include_str!("picture.wgsl"),
            include_str!("overlay.wgsl"),
            of_command.as_str(),
        ];
        let branches = |text: &str| {
            // Both sides of `||` and `&&` are branches, also outside of conditions.
            let conditions = text.lines().map(str::trim_start).filter_map(|line| {
                let value = || line.split_once("return ").or_else(|| line.split_once(" = "));
                let joined =
                    || (line.contains("||") || line.contains("&&")).then(|| value().map_or(line, |(_, of)| of));
                line.strip_prefix("if (").or_else(joined)
            });
            // A function without arguments reads nothing else.
            let is_of_uniforms = |term: &str| {
                let term = term.trim_start_matches(['!', ' ', '(']);
                let uniforms = ["frame.", "shaded.", "clay.", "maps."];
                term.contains("()") || uniforms.iter().any(|uniform| term.starts_with(uniform))
            };
            let are_uniform =
                |condition: &&str| condition.split("||").flat_map(|all| all.split("&&")).any(is_of_uniforms);
            conditions.filter(are_uniform).map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(branches("  if (shaded.range > 0.0) {\n  if (x > shaded.range) {"), ["shaded.range > 0.0) {"]);
        assert_eq!(branches("if (x > y) {\nif (x > y || !is_lit()) {"), ["x > y || !is_lit()) {"]);
        assert_eq!(branches("return maps.maps == 0u && x > y;"), ["maps.maps == 0u && x > y;"]);
        assert_eq!(sources.iter().flat_map(|text| branches(text)).collect::<Vec<_>>(), [""; 0]);
    }
}
