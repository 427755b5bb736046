//! The scene: bodies, lights and camera as the command line asks for them.

use std::borrow::Cow;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use rimline::gltf::{SceneLight, SpotCone};
use rimline::gpu::StageTimer;
use rimline::{AreaLight, AreaShape, Displacement, Light, MAX_LIGHTS, Origin, check_shadow_lights, wgpu};
use rimline_picture::{Bounds, Camera, PARTS, Part, SceneBounds, SceneView, ShadedLight, depth_format, reach};

use super::args::{ShadowSceneArgs, method_name, needs_perspective, not_orthographic};
use super::casters::Casters;
use super::casting::{CastInputs, PosedModel};
use super::pictures::DrawInputs;
use super::shadows::too_coarse;
use crate::camera::{AZIMUTH, camera, elevation, of_file, outermost, swept};
use crate::coordinates::relative;
use crate::device::{self, Gpu, GpuError, Wanted};
use crate::failure::{DRAW_ON_CPU, Failure, NO_FINITE_FACE};
use crate::image::{check_bounds, check_size};
use crate::input::{ChosenLight, Input, play, read_displacement};
use crate::input_args::PlacedView;
use crate::output::{listed_animations, note, numbered_name};
use crate::spec::{AreaSpec, ShadedLightSpec};

/// Degrees that the eye is above the models by default: enough to see shadows on the ground.
const ELEVATION: f64 = 24.0;
/// The ground has faded before it is so many extents away from below the models: at 3.3 · 1.1 · 60 at most ([`reach`]).
const FADED: f32 = 300.0;

pub(crate) struct ShadowInputs {
    pub(crate) inputs: Vec<Input>,
    pub(crate) displacement: Option<Displacement>,
}

impl ShadowInputs {
    pub(crate) fn read(args: &ShadowSceneArgs) -> Result<Self, Failure> {
        if args.posed.device.device == Wanted::Cpu {
            return Err(Failure::usage(DRAW_ON_CPU));
        }
        let displacement = args.posed.displace.as_deref().map(read_displacement).transpose()?;
        let options = args.read.options();
        let mut inputs = args.files.iter().map(|file| Input::read(file, &options)).collect::<Result<Vec<_>, _>>()?;
        play(&mut inputs, &args.posed.pose)?;
        if !args.plain {
            inputs.iter().for_each(Input::note_colors);
        }
        Ok(Self { inputs, displacement })
    }

    /// Whether positions depend on the time.
    pub(crate) fn is_moving(&self) -> bool {
        self.displacement.is_some() || self.inputs.iter().any(|input| !input.playing.is_empty())
    }

    /// The files that were read, and those that models name.
    pub(crate) fn files<'a>(&'a self, args: &'a ShadowSceneArgs) -> impl Iterator<Item = &'a Path> {
        self.inputs.iter().flat_map(Input::files).chain(args.posed.displace.as_deref())
    }

    pub(crate) fn bodies(&self, gpu: &Gpu, args: &ShadowSceneArgs) -> Result<Vec<PosedModel<'_>>, Failure> {
        let time_s = args.posed.pose.time;
        let body = |input| PosedModel::new(gpu, input, time_s, self.displacement.as_ref(), args.plain);
        self.inputs.iter().map(body).collect()
    }
}

/// Plays the file's first animation that is not damaged, and says which that is.
pub(crate) fn take_first_animation(input: &mut Input) {
    let Some(asset) = input.asset() else { return };
    // A damaged one is taken where there is no other, and then says what is wrong with it.
    let index = asset.animations().iter().position(|info| info.fault.is_none()).unwrap_or(0);
    let Some(first) = asset.animations().get(index) else { return };
    let (file, name) = (input.file.display(), numbered_name(index, first.name.as_deref()));
    let there = if asset.animations().len() > 1 { listed_animations(asset) } else { "it has no other".into() };
    note(&format!("{file}: using animation {name}, because no --animation is given; {there}"));
    input.playing = vec![index];
}

/// Opens the device, if it can draw such a picture.
pub(crate) fn open_gpu(args: &ShadowSceneArgs) -> Result<Gpu, Failure> {
    let gpu = device::open_gpu(&args.posed.device.device)?;
    // The multisampled linear picture is the largest array.
    check_size(&gpu, args.view.size, 4 * 8)?;
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
    /// `points` are those that the camera must see, if it is not given, and all along where it is `on_orbit` about a target.
    /// `map_light` is the light of the map of `--depth`, for where the command line gives none.
    pub(crate) fn new(
        args: &'a ShadowSceneArgs,
        bodies: Vec<PosedModel<'a>>,
        points: &[[f32; 3]],
        on_orbit: bool,
        map_light: Option<Light>,
    ) -> Result<Self, Failure> {
        let first = &bodies[0];
        let file = &first.input.file;
        let bounds = Bounds::of(points).ok_or_else(|| Failure::input(file, NO_FINITE_FACE))?;
        check_bounds(&bounds).map_err(|error| Failure::input(file, error))?;
        let origin = first.input.origin();
        let view = first.input.view(&args.view, args.posed.pose.time)?;
        let given_ground = args.ground.map(|height| height.relative_to(origin.to_array()[1]));
        let stage = SceneBounds { models: bounds, ground: given_ground.unwrap_or_else(|| bounds.ground()) };
        let shaded_lights = shaded_lights(args, (first, &view), &stage, map_light)?;
        let samples: usize = shaded_lights.iter().map(|shaded| shaded.samples.len()).sum();
        if samples > MAX_LIGHTS {
            let (lights, limit) = (shaded_lights.len(), MAX_LIGHTS);
            return Err(Failure::usage(format!(
                "{lights} lights have {samples} samples, and at most {limit} fit; give fewer lights or --samples"
            )));
        }
        let outermost = outermost(points, bounds.centre());
        let reach = reach(&shaded_lights, &outermost, &stage);
        let shadows = seen_shadows(&view, &shaded_lights, &outermost, &stage);
        // Seen from a camera that turns about a target, everything turns about it. Lights and ground stay by the models.
        let target = view.target.filter(|_| on_orbit);
        let axis = on_orbit.then(|| view.target.map_or(bounds.centre(), Vec3::from));
        let (points, shadows) = (turned(points, target), turned(&shadows, target));
        let seen = points.iter().chain(&*shadows).copied();
        let mut camera = camera(&view, elevation(ELEVATION, &bounds), &bounds, seen)?;
        match camera.far {
            Some(_) if needs_perspective(args.method) => {
                return Err(not_orthographic(&format!("--method {}", method_name(args.method))));
            }
            // The ground that is seen lies between its planes, too.
            Some(far) if view.is_parallel => {
                let room = 4.0 * (1.8 * stage.models.extent()).max(1.1 * reach);
                camera.eye -= room * camera.forward;
                camera.far = Some(far + 2.0 * room);
            }
            _ if view.camera.is_some() => camera.near = args.near.unwrap_or(camera.near),
            _ => camera.near = args.near.unwrap_or_else(|| near(&camera, &stage, &points, axis)),
        }
        check_near(&camera, farthest(&camera, &stage), args.near.is_some())?;
        if view.camera.is_some() {
            camera = camera.with_nearer_far_plane(&stage, FADED);
        }
        Ok(Self { args, bodies, stage, shaded_lights, camera, part: Part::WHOLE, reach })
    }

    /// Moves the bodies to their poses at another time. Lights and camera stay. [`Casters::set_bodies`] and [`Self::cast`] have
    /// to follow.
    pub(crate) fn pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), Failure> {
        self.bodies.iter_mut().try_for_each(|body| body.pose(gpu, time_s))
    }

    /// The camera of the file at another time, if one is asked for.
    pub(crate) fn camera_at(&self, time_s: f32) -> Result<Option<Camera>, Failure> {
        let camera = self.bodies[0].input.camera(&self.args.view.camera, time_s)?;
        let camera = camera.map(|camera| of_file(&camera, self.args.view.size));
        let with_near = |camera: Camera| Camera { near: self.args.near.unwrap_or(camera.near), ..camera };
        Ok(camera.map(|camera| with_near(camera).with_nearer_far_plane(&self.stage, FADED)))
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

    fn view(&self) -> SceneView<'_> {
        let Self { camera, part, stage: bounds, shaded_lights: lights, reach, .. } = self;
        SceneView { camera, size: self.args.view.size, part, bounds, lights, reach: *reach }
    }

    pub(crate) fn subject<'b>(&self, casters: &'b Casters<'b>) -> DrawInputs<'b> {
        let (samples, has_ground) = (self.samples(), self.view().sees_ground());
        DrawInputs { casters, pipelines: None, overlay: None, samples, has_ground, is_trial: false }
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

    /// Finds what the casters need for the pose that the bodies have, and makes them ready to be drawn.
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

/// The shadows of points that the camera must see, if it is not given.
fn seen_shadows(view: &PlacedView, lights: &[ShadedLight], points: &[[f32; 3]], stage: &SceneBounds) -> Vec<[f32; 3]> {
    // A level view without perspective shows no ground.
    let is_level = view.is_parallel && view.side.is_some_and(|side| side.directions().0[1] < 1e-6);
    if view.eye.is_some() || view.camera.is_some() || is_level {
        return Vec::new();
    }
    lights.iter().flat_map(|shaded| points.iter().map(|&point| shaded.shadow_of(point, stage))).collect()
}

/// Points, or those of all turns about a target.
fn turned(points: &[[f32; 3]], target: Option<[f32; 3]>) -> Cow<'_, [[f32; 3]]> {
    target.map_or(Cow::Borrowed(points), |axis| Cow::Owned(swept(points, Some(axis.into()))))
}

/// The near plane for models with these points, which are those of [`swept`] for a camera on an orbit about `axis`.
fn near(camera: &Camera, stage: &SceneBounds, points: &[[f32; 3]], axis: Option<Vec3>) -> f32 {
    let ahead = |point: Vec3| (point - camera.eye).dot(camera.forward);
    let nearest = points.iter().map(|&point| ahead(point.into())).fold(f32::INFINITY, f32::min);
    let near = camera.near_plane(stage, nearest);
    let Some(axis) = axis else { return near };
    // Between two steps of 15° a point at a distance r from the axis comes nearer, by up to r (1 − cos 7.5°), 0.86 % of r: it is
    // nearest where it is straight between axis and eye. The near plane is at most half as far as the steps, so it stays
    // unless that is nearer still.
    let towards_eye = -Vec3::new(camera.forward.x, 0.0, camera.forward.z).normalize_or_zero();
    let between = |[x, y, z]: [f32; 3]| {
        let radius = Vec2::new(x - axis.x, z - axis.z).length();
        Vec3::new(axis.x, y, axis.z) + radius * towards_eye
    };
    let nearest = points.iter().map(|&point| ahead(between(point))).fold(f32::INFINITY, f32::min);
    if near > nearest { near.min(camera.near_plane(stage, nearest)) } else { near }
}

/// How far away the farthest shadows are that matter.
fn farthest(camera: &Camera, stage: &SceneBounds) -> f32 {
    let ahead = |corner: Vec3| (corner - camera.eye).dot(camera.forward);
    // Shadows on the ground are about as far beyond the models as those are large.
    stage.models.corners().map(ahead).into_iter().fold(0.0, f32::max) + stage.models.extent()
}

/// Refuses a near plane that is so near that depths lose bits: devices flush slopes of depth that are no normal numbers. One that
/// `is_given` must not be beyond what it should show, either. With a far plane depths are linear, and may begin anywhere before
/// it.
fn check_near(camera: &Camera, farthest: f32, is_given: bool) -> Result<(), Failure> {
    let near = camera.near;
    // Slopes of depths above 2⁻¹⁰⁴ keep 22 bits.
    let least = farthest * 2.0_f32.powi(-104);
    match camera.far {
        Some(far) if near >= far => Err(Failure::usage(format!(
            "--near {near:e} is not before the far plane of the camera, which is {far} away; give less"
        ))),
        _ if is_given && near > farthest => Err(Failure::usage(format!(
            "--near {near:e} is beyond the models, which end before {farthest}; give less, or the picture shows none of them"
        ))),
        None if near < least => Err(Failure::usage(format!(
            "--near {near:e} is too near: depths of what lies {farthest} away leave the normal range of \
             32-bit floats; give {least:.1e} or more"
        ))),
        _ => Ok(()),
    }
}

/// A little warm.
const DEFAULT_COLOR: [f32; 3] = [1.0, 0.95, 0.87];

/// The lights of the command line, or else `map_light`, or the one that is there by default.
fn shaded_lights(
    args: &ShadowSceneArgs,
    (first, view): (&PosedModel<'_>, &PlacedView),
    stage: &SceneBounds,
    map_light: Option<Light>,
) -> Result<Vec<ShadedLight>, Failure> {
    let mut chosen = Vec::new();
    for spec in &args.lights {
        let lights = first.input.chosen_lights(std::slice::from_ref(&spec.light), args.posed.pose.time)?;
        check_options(spec, &lights)?;
        chosen.extend(lights.into_iter().map(|light| (spec, light)));
    }
    let of_file = chosen.iter().filter_map(|(_, chosen)| chosen.of_file.as_ref());
    let brightest = of_file.map(|of_file| illuminance(of_file, stage)).fold(0.0, f64::max);
    let origin = first.input.origin();
    let mut shaded_lights = Vec::new();
    for (spec, chosen) in &chosen {
        shaded_lights.push(ShadedLight {
            cone: cone(spec, chosen, stage, origin).map_err(|problem| lamp_options(chosen, &problem))?,
            ..shaded(spec, chosen, brightest, stage)
        });
    }
    if shaded_lights.is_empty() {
        let light = map_light.unwrap_or_else(|| default_light(view, stage));
        shaded_lights.push(ShadedLight { color: DEFAULT_COLOR, ..ShadedLight::new(light) });
    }
    // Once for every way to cast: depth maps and areas would take such a light for another.
    let lights: Vec<Light> = shaded_lights.iter().map(|shaded| shaded.light).collect();
    check_shadow_lights(&lights, usize::MAX).map_err(|error| Failure::usage(error.to_string()))?;
    let sphere = |radius| AreaSpec { shape: AreaShape::Sphere { radius }, is_relative: false };
    let areas = chosen.iter().map(|(spec, _)| spec.radius.map(sphere)).chain([None]);
    for (shaded, area) in shaded_lights.iter_mut().zip(areas) {
        if let Some(area) = area.or(args.area) {
            spread(shaded, area, args.samples(), stage);
        }
    }
    Ok(shaded_lights)
}

/// Takes a light's options from the command line, or else from the file. The brightest light of its file counts as 1.
fn shaded(spec: &ShadedLightSpec, chosen: &ChosenLight, brightest: f64, stage: &SceneBounds) -> ShadedLight {
    let light = chosen.light;
    let of_file = chosen.of_file.as_ref();
    let relative = |of_file| if brightest > 0.0 { (illuminance(of_file, stage) / brightest) as f32 } else { 0.0 };
    let intensity = spec.intensity.or_else(|| of_file.map(relative)).unwrap_or(1.0);
    let color = spec.color.or(of_file.map(|of_file| of_file.color)).unwrap_or([1.0; 3]);
    let range = spec.range.or(of_file.and_then(|of_file| of_file.range)).unwrap_or(f32::INFINITY);
    ShadedLight {
        color: color.map(|c| c * intensity),
        range: if light.w == 0.0 { f32::INFINITY } else { range },
        begin: spec.begin.unwrap_or(0.0),
        exponent: spec.exponent.unwrap_or(1.0),
        ..ShadedLight::new(light)
    }
}

/// The cone of a spot: from the command line, or else from the file.
fn cone(
    spec: &ShadedLightSpec,
    chosen: &ChosenLight,
    stage: &SceneBounds,
    origin: Origin,
) -> Result<Option<SpotCone>, String> {
    let of_file = chosen.of_file.as_ref().and_then(|of_file| of_file.cone);
    let given = spec.cone.filter(|_| chosen.light.w != 0.0).map(|angles| angles.map(f32::to_radians));
    let Some([inner_angle, outer_angle]) = given.or(of_file.map(|cone| [cone.inner_angle, cone.outer_angle])) else {
        return Ok(None);
    };
    let direction = match (spec.target, of_file) {
        (None, Some(cone)) => cone.direction,
        (target, _) => {
            let target = target.map_or(stage.models.centre(), |target| relative(target, origin).into());
            let at_target = "a spot at the point that it shines at has no direction; give another target=X,Y,Z";
            let way = target.as_dvec3() - ShadedLight::new(chosen.light).position_or_direction();
            way.try_normalize().ok_or(at_target)?.as_vec3().into()
        }
    };
    Ok(Some(SpotCone { direction, inner_angle, outer_angle }))
}

fn spread(shaded: &mut ShadedLight, area: AreaSpec, count: usize, stage: &SceneBounds) {
    let normal = stage.models.centre().as_dvec3() - shaded.position_or_direction();
    let distance = normal.length().max(1e-3 * f64::from(stage.models.extent()));
    let scale = if !area.is_relative {
        1.0
    } else if shaded.light.w == 0.0 {
        AREA_RADIUS as f32
    } else {
        (AREA_RADIUS * distance) as f32
    };
    let shape = match area.shape {
        AreaShape::Rectangle { width, height } => AreaShape::Rectangle { width: width * scale, height: height * scale },
        AreaShape::Disc { radius } => AreaShape::Disc { radius: radius * scale },
        AreaShape::Sphere { radius } => AreaShape::Sphere { radius: radius * scale },
    };
    let normal = normal.normalize_or_zero().as_vec3().into();
    let area = AreaLight { light: shaded.light, shape, normal };
    shaded.samples = area.samples(count);
    shaded.area = Some(area);
}

/// The default size of a light with an area, over its distance: soft, and its samples' shadows run together.
const AREA_RADIUS: f64 = 0.04;

fn vector(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Illuminance of the file's light at the middle of the models, in lux, on a surface perpendicular to its rays. It
/// ignores range and cone. Lights among the models count as half their extent away.
fn illuminance(light: &SceneLight, stage: &SceneBounds) -> f64 {
    let intensity = f64::from(light.intensity);
    if light.light.w == 0.0 {
        return intensity;
    }
    let distance = (vector(light.light.xyz) - stage.models.centre().as_dvec3())
        .length()
        .max(0.5 * f64::from(stage.models.extent()));
    intensity / (distance * distance)
}

fn lamp_options(light: &ChosenLight, problem: &str) -> Failure {
    match &light.of_file {
        Some(of_file) => {
            Failure::usage(format!("the file's light `{}`: {problem}", of_file.name.as_deref().unwrap_or_default()))
        }
        None => Failure::usage(format!("--light: {problem}")),
    }
}

/// Refuses options that none of the lights that they are given to can have.
fn check_options(spec: &ShadedLightSpec, lights: &[ChosenLight]) -> Result<(), Failure> {
    let checked = lights.iter().map(|chosen| (chosen, spec.check(chosen.light, chosen.of_file.as_ref())));
    let wrong: Vec<_> = checked.filter_map(|(chosen, checked)| Some((chosen, checked.err()?))).collect();
    // With `file:all`, options apply to the lights that can have them.
    let of_all = wrong.first().filter(|_| wrong.len() == lights.len());
    let found = wrong.iter().find(|(_, (is_grave, _))| *is_grave).or(of_all);
    found.map_or(Ok(()), |(chosen, (_, problem))| Err(lamp_options(chosen, problem)))
}

/// To the left of the eye, above, and a little before the models: their shadow falls beside them.
fn default_light(view: &PlacedView, stage: &SceneBounds) -> Light {
    let azimuth = AZIMUTH.to_radians();
    let target = view.target.map_or(stage.models.centre().as_dvec3(), vector);
    let towards_eye = match (view.eye, view.side, &view.camera) {
        (Some(eye), ..) => vector(eye) - target,
        (_, Some(side), _) => DVec3::from(side.directions().0),
        (.., Some(camera)) => -vector(camera.forward),
        _ => DVec3::ZERO,
    };
    let level = (towards_eye * DVec3::new(1.0, 0.0, 1.0)).try_normalize();
    let backward = level.unwrap_or(DVec3::new(azimuth.sin(), 0.0, azimuth.cos()));
    let right = DVec3::Y.cross(backward);
    let towards = (-0.8 * right + 1.15 * DVec3::Y + 0.42 * backward).normalize();
    let position = stage.models.centre().as_dvec3() + 3.5 * f64::from(stage.models.extent()) * towards;
    Light::point(position.as_vec3().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec;
    use rimline_picture::Bounds;

    const STAGE: SceneBounds =
        SceneBounds { models: Bounds { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) }, ground: 0.0 };

    fn chosen(light: Light, intensity: f32, range: Option<f32>) -> ChosenLight {
        let kind = rimline::gltf::SceneLightKind::Point;
        ChosenLight {
            light,
            of_file: Some(SceneLight { name: None, light, kind, color: [1.0; 3], intensity, range, cone: None }),
        }
    }

    #[test]
    fn the_files_brightest_light_counts_as_1() {
        let spec = spec::shaded("file:all").expect("a good light");
        let [near, far] = [2.0, 4.0].map(|x| chosen(Light::point([x, 1.0, 0.0]), 80.0, None));
        let brightest = near.of_file.as_ref().map_or(0.0, |of_file| illuminance(of_file, &STAGE));
        let color = |chosen| shaded(&spec, chosen, brightest, &STAGE).color;
        assert_eq!((color(&near), color(&far)), ([1.0; 3], [0.25; 3]));
        assert_eq!(
            illuminance(&chosen(Light::directional([0.0, 3.0, 0.0]), 7.0, None).of_file.expect("own"), &STAGE),
            7.0
        );
        let dark = shaded(&spec, &chosen(Light::point([9.0; 3]), 0.0, None), 0.0, &STAGE);
        assert_eq!(dark.color, [0.0; 3]);
    }

    #[test]
    fn a_near_plane_of_an_orbit_is_before_what_comes_between_its_steps() {
        // Halfway between two steps it is straight before the eye.
        let (sine, cosine) = 7.5_f32.to_radians().sin_cos();
        let points = swept(&[[sine, 1.0, cosine]], Some(Vec3::ZERO));
        let camera = |z: f32| Camera {
            eye: Vec3::new(0.0, 1.0, z),
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            scale: [1.0; 2],
            near: 1.0,
            far: None,
        };
        let near = |z: f32, axis| near(&camera(z), &STAGE, &points, axis);
        assert!(near(1.002, None) > 0.002 && near(1.002, Some(Vec3::ZERO)) < 0.0019);
        for z in [1.0175, 1.1, 3.0, 0.5] {
            assert_eq!(near(z, Some(Vec3::ZERO)).to_bits(), near(z, None).to_bits(), "{z}");
        }
    }

    #[test]
    fn options_serve_those_lights_of_a_file_that_can_have_them() {
        let (point, sun) = (Light::point([1.0; 3]), Light::directional([1.0; 3]));
        let check =
            |text: &str, lights: &[ChosenLight]| check_options(&spec::shaded(text).expect(text), lights).is_ok();
        let both = [chosen(point, 1.0, Some(5.0)), chosen(sun, 1.0, None)];
        assert!(check("file:all,range=3", &both) && check("file:all,begin=3", &both));
        assert!(!check("file:all,range=3", &both[1..]) && !check("file:all,begin=3", &both[1..]));
        assert!(!check("file:all,begin=6", &both));
    }
}
