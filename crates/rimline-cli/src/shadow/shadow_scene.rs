//! The scene: bodies, lights and camera as the command line asks for them.

use std::path::Path;

use glam::Vec3;
use rimline::gpu::StageTimer;
use rimline::{Displacement, Light, MAX_LIGHTS, wgpu};
use rimline_picture::{Bounds, Camera, PARTS, Part, SceneBounds, SceneView, ShadedLight, depth_format, reach};

use super::casters::Casters;
use super::casting::CastInputs;
use super::depth::too_coarse;
use super::draw_inputs::DrawInputs;
use super::posed_model::PosedModel;
use super::shaded_lights::shaded_lights;
use crate::device::{self, Gpu, Wanted};
use crate::failure::{Failure, InputError, UsageError};
use crate::gpu_error::GpuError;
use crate::input::Input;
use crate::input_args::PlacedView;
use crate::output::note;
use crate::posed_input::{self, animations};
use crate::render::camera::{camera, elevation, outermost};
use crate::render::{check_bounds, check_size, too_large};
use crate::shadow::args::{CountingArg, ShadowSceneArgs};
use crate::shown::{animation_name, listed_animations};

/// Degrees that the eye is above the models by default: enough to see shadows on the ground.
const ELEVATION: f64 = 24.0;

pub(crate) struct ShadowInputs {
    pub(crate) inputs: Vec<Input>,
    pub(crate) animations: Vec<Vec<usize>>,
    pub(crate) displacement: Option<Displacement>,
    is_plain: bool,
}

impl ShadowInputs {
    pub(crate) fn read(args: &ShadowSceneArgs) -> Result<Self, Failure> {
        if Wanted::parse(&args.posed.device.device) == Wanted::Cpu {
            return Err(UsageError::DrawOnCpu.into());
        }
        let displacement = args.posed.displace.as_deref().map(posed_input::read_displacement).transpose()?;
        let options = args.load.options(args.weld.weld());
        let open = |file: &std::path::PathBuf| Input::read(file, options, args.polygons.taken());
        let inputs = args.files.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let animations = animations(&inputs, &args.posed.pose)?;
        if !args.plain {
            inputs.iter().for_each(Input::note_colors);
        }
        Ok(Self { inputs, animations, displacement, is_plain: args.plain })
    }

    /// The files that were read, and those that models name.
    pub(crate) fn files<'a>(&'a self, args: &'a ShadowSceneArgs) -> impl Iterator<Item = &'a Path> {
        self.inputs.iter().flat_map(Input::files).chain(args.posed.displace.as_deref())
    }

    /// Plays each file's first animation that is not damaged, and says which that is.
    pub(crate) fn take_first_animations(&mut self) {
        for (input, animations) in self.inputs.iter().zip(&mut self.animations) {
            let Some(asset) = input.asset() else { continue };
            // A damaged one is taken where there is no other, and then says what is wrong with it.
            let index = asset.animations().iter().position(|info| info.fault.is_none()).unwrap_or(0);
            let Some(first) = asset.animations().get(index) else { continue };
            *animations = vec![index];
            let (file, name) = (input.file.display(), animation_name(index, first));
            let there = if asset.animations().len() > 1 { listed_animations(asset) } else { "it has no other".into() };
            note(&format!("{file}: using animation {name}, because no --animation is given; {there}"));
        }
    }

    pub(crate) fn bodies(&self, gpu: &Gpu, time_s: f32) -> Result<Vec<PosedModel<'_>>, Failure> {
        let inputs = self.inputs.iter().zip(&self.animations);
        inputs
            .map(|(input, animations)| {
                PosedModel::new(gpu, input, animations, time_s, self.displacement.as_ref(), self.is_plain)
            })
            .collect()
    }
}

/// Opens the device, if it can draw such a picture.
pub(crate) fn open_gpu(args: &ShadowSceneArgs) -> Result<Gpu, Failure> {
    let gpu = device::open_gpu(&Wanted::parse(&args.posed.device.device))?;
    check_size(&gpu, args.view.size)?;
    let [width, height] = args.view.size;
    // The multisampled linear picture is the largest array.
    let needed = 4 * 8 * u64::from(width) * u64::from(height);
    let limit = gpu.device.limits().max_buffer_size;
    if needed > limit {
        return Err(too_large(&gpu, args.view.size, 4 * 8).into());
    }
    Ok(gpu)
}

pub(crate) struct ShadowScene<'a> {
    args: &'a ShadowSceneArgs,
    pub(crate) bodies: Vec<PosedModel<'a>>,
    pub(crate) stage: SceneBounds,
    pub(crate) shaded_lights: Vec<ShadedLight>,
    pub(crate) camera: Camera,
    part: Part,
    reach: f32,
}

impl<'a> ShadowScene<'a> {
    /// `points` are those that the camera must see, if it is not given. `own_light` is the light if none is given.
    pub(crate) fn new(
        args: &'a ShadowSceneArgs,
        bodies: Vec<PosedModel<'a>>,
        points: &[[f32; 3]],
        file_light: Option<Light>,
    ) -> Result<Self, Failure> {
        let first = &bodies[0];
        let failed = Failure::input(&first.input.file);
        let bounds = Bounds::of(points).ok_or_else(|| failed(InputError::NoFiniteFace))?;
        check_bounds(&bounds).map_err(failed)?;
        let origin = first.input.origin();
        let view = placed(args, first, args.posed.pose.time)?;
        let given_ground = args.ground.map(|height| height.relative_to(origin.to_array()[1]));
        let stage = SceneBounds { models: bounds, ground: given_ground.unwrap_or_else(|| bounds.ground()) };
        let shaded_lights = shaded_lights(args, (first, &view), &stage, file_light)?;
        let samples = shaded_lights.iter().map(|shaded| shaded.samples.len()).sum();
        if samples > MAX_LIGHTS {
            let (lights, limit) = (shaded_lights.len(), MAX_LIGHTS);
            return Err(UsageError::Samples { lights, samples, limit }.into());
        }
        let mut shadows: Vec<[f32; 3]> = Vec::new();
        let outermost = outermost(points, bounds.centre());
        let reach = reach(&shaded_lights, &outermost, &stage);
        // A level view without perspective shows no ground.
        let is_level = view.is_parallel && view.side.is_some_and(|side| side.directions().0[1] < 1e-6);
        if view.eye.is_none() && view.camera.is_none() && !is_level {
            shadows.extend(
                shaded_lights.iter().flat_map(|shaded| outermost.iter().map(|&point| shaded.shadow_of(point, &stage))),
            );
        }
        let seen = points.iter().chain(&shadows).copied();
        let mut camera = camera(&view, elevation(ELEVATION, &bounds), &bounds, seen)?;
        match camera.far {
            Some(_) if matches!(args.method, CountingArg::ZFail | CountingArg::ZpPlus2005) => {
                let what = if args.method == CountingArg::ZFail { "--method z-fail" } else { "--method zp+paper" };
                return Err(UsageError::Orthographic { what }.into());
            }
            // The ground that is seen lies between its planes, too.
            Some(far) if view.is_parallel => {
                let room = 4.0 * (1.8 * stage.models.extent()).max(1.1 * reach);
                camera.eye -= room * camera.forward;
                camera.far = Some(far + 2.0 * room);
            }
            _ if view.camera.is_some() => camera.near = args.near.unwrap_or(camera.near),
            _ => camera.near = args.near.unwrap_or_else(|| near(&camera, &stage, points)),
        }
        if camera.far.is_none() {
            check_near(camera.near, farthest(&camera, &stage))?;
        }
        Ok(Self { args, bodies, stage, shaded_lights, camera, part: Part::WHOLE, reach })
    }

    /// Moves everything to another posed; the camera stays.
    pub(crate) fn pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), Failure> {
        self.bodies.iter_mut().try_for_each(|body| body.pose(gpu, time_s))
    }

    /// The camera of the file at another time, if one is asked for.
    pub(crate) fn camera_at(&self, time_s: f32) -> Result<Option<Camera>, Failure> {
        if self.args.view.camera.wanted.is_none() {
            return Ok(None);
        }
        let view = placed(self.args, &self.bodies[0], time_s)?;
        let camera = camera(&view, ELEVATION, &self.stage.models, std::iter::empty())?;
        Ok(Some(Camera { near: self.args.near.unwrap_or(camera.near), ..camera }))
    }

    /// A point of the vertical line that a camera on an orbit goes around: what it looks at.
    pub(crate) fn orbit_axis(&self) -> Vec3 {
        let view = self.args.view.relative_to(self.bodies[0].input.origin());
        view.target.map_or(self.stage.models.centre(), Vec3::from)
    }

    /// Tells the user where depth is too coarse for the shadows that are seen.
    pub(crate) fn warn_of_depth(&self, gpu: &Gpu) {
        let farthest = farthest(&self.camera, &self.stage);
        let pixel = 2.0 / (self.camera.scale[1] * self.args.view.size[1] as f32);
        if self.camera.far.is_none()
            && let Some(warning) = too_coarse(depth_format(&gpu.device), self.camera.near, farthest, pixel)
        {
            note(&format!("warning: {warning}"));
        }
    }

    pub(crate) fn ranged(&self) -> Vec<Light> {
        self.shaded_lights.iter().flat_map(ShadedLight::ranged).collect()
    }

    /// The numbers of a light's samples among those of all.
    pub(super) fn samples_of(&self, light: usize) -> std::ops::Range<usize> {
        let count = |lights: usize| self.shaded_lights.iter().take(lights).map(|shaded| shaded.samples.len()).sum();
        count(light)..count(light + 1)
    }

    pub(crate) fn samples(&self) -> usize {
        self.shaded_lights.iter().map(|shaded| shaded.samples.len()).sum()
    }

    /// The scene as a picture shows it.
    fn view(&self) -> SceneView<'_> {
        let Self { camera, part, stage: bounds, shaded_lights: lights, reach, .. } = self;
        SceneView { camera, size: self.args.view.size, part, bounds, lights, reach: *reach }
    }

    pub(crate) fn subject<'b>(&self, casters: &'b Casters<'b>) -> DrawInputs<'b> {
        let (samples, has_ground) = (self.samples(), self.view().sees_ground());
        DrawInputs { casters, drawn: None, samples, has_ground, is_trial: false }
    }

    /// The same with one pixel of one light.
    pub(crate) fn trial<'b>(&self, casters: &'b Casters<'b>) -> DrawInputs<'b> {
        DrawInputs { samples: self.samples().min(1), is_trial: true, ..self.subject(casters) }
    }

    /// Pixels take turns with patterns of samples.
    pub(crate) fn is_in_parts(&self) -> bool {
        self.args.is_soft() && !self.args.one_pattern
    }

    /// Takes a part's view and samples, or those of the whole.
    pub(crate) fn take_part(&mut self, part: Option<usize>) {
        self.part = part.map_or(Part::WHOLE, |part| Part::of(self.args.view.size, part));
        let (pattern, patterns) = part.map_or((0, 1), |part| (part, PARTS));
        self.shaded_lights.iter_mut().for_each(|shaded| shaded.take_pattern(pattern, patterns));
    }

    /// Finds what the casters need for the posed at hand, and makes them ready to be drawn.
    pub(crate) fn cast(&self, casters: &mut Casters<'_>, mut timer: Option<&mut StageTimer>) -> Result<(), GpuError> {
        let gpu = casters.gpu();
        let mut encoder = gpu.encoder("cast");
        self.encode_lights(&mut encoder, casters, timer.as_deref_mut())?;
        if let Some(timer) = timer {
            timer.resolve(&mut encoder);
        }
        gpu.submit(encoder);
        casters.bind(&self.bodies, self.camera.distant_eye())
    }

    /// Sees to it that what lies over each other is counted, after [`Self::cast`]. Waits for the device.
    pub(crate) fn count_layers(&mut self, casters: &mut Casters<'_>) -> Result<(), Failure> {
        let mut all = self.ranged();
        if self.is_in_parts() {
            for part in 0..PARTS {
                self.take_part(Some(part));
                all.extend(self.ranged());
            }
            self.take_part(None);
        }
        self.with_inputs(|inputs| casters.shadows.count_layers(inputs, &all))
    }

    /// Records the same for bodies that are where they were.
    pub(crate) fn encode_lights(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        casters.resources.shared.set(&self.view());
        self.with_inputs(|inputs| casters.encode(encoder, inputs, timer))
    }

    fn with_inputs<T>(&self, run: impl FnOnce(CastInputs<'_>) -> T) -> T {
        let (camera, lights) = (self.view().shadow_camera(), self.ranged());
        run(CastInputs { bodies: &self.bodies, seen: &self.bodies, camera: &camera, lights: &lights })
    }
}

/// The view that the command line asks for, at a time.
fn placed(args: &ShadowSceneArgs, first: &PosedModel<'_>, time_s: f32) -> Result<PlacedView, Failure> {
    first.input.view(&args.view, first.animations, time_s)
}

/// The near plane for models with these points.
fn near(camera: &Camera, stage: &SceneBounds, points: &[[f32; 3]]) -> f32 {
    let ahead = |&point: &[f32; 3]| (Vec3::from(point) - camera.eye).dot(camera.forward);
    camera.near_plane(stage, points.iter().map(ahead).fold(f32::INFINITY, f32::min))
}

/// How far away the farthest shadows are that matter.
fn farthest(camera: &Camera, stage: &SceneBounds) -> f32 {
    let ahead = |corner: Vec3| (corner - camera.eye).dot(camera.forward);
    // Shadows on the ground are about as far beyond the models as those are large.
    stage.models.corners().map(ahead).into_iter().fold(0.0, f32::max) + stage.models.extent()
}

/// Refuses a near plane that is so near that depths lose bits: devices flush slopes of depth that are no normal numbers.
fn check_near(near: f32, farthest: f32) -> Result<(), UsageError> {
    // Slopes of depths above 2⁻¹⁰⁴ keep 22 bits.
    let least = farthest * 2.0_f32.powi(-104);
    if near < least { Err(UsageError::Near { near, farthest, least }) } else { Ok(()) }
}
