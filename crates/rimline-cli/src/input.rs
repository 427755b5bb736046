//! Model files of any format, and the meshes that they make at one time; and their positions on the GPU.

use std::borrow::Cow;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rimline::cpu::{self, Threads};
use rimline::gltf::{CameraProjection, GltfError, SceneCamera, SceneLight};
use rimline::gpu::{Deformer, DeformerOptions, DeviceError, PoseInputs, PositionBuffer, StageTimer};
use rimline::mesh::Weld;
use rimline::{
    Displacement, Geometry, GeometryOptions, Instance, InstancePose, Light, LightError, MAX_LIGHTS, Mesh, MeshError,
    Model, ModelError, Origin, Pose, check_lights, wgpu,
};
use rimline_files::{File, FileError, ReadOptions, read_bytes, resting};
use rimline_picture::corner_colors;

use crate::device::{self, Device, Gpu, GpuError, Wanted};
use crate::failure::{Cause, DISPLACE_ON_CPU, Failure, NO_AREA};
use crate::files;
use crate::input_args::{CameraArgs, ModelArgs, MomentArgs, PlacedView, PoseArgs, ViewArgs};
use crate::output::{Line, Progress, listed, listed_animations, note};
use crate::report::Times;
use crate::spec::LightSpec;

pub(crate) struct Input {
    pub(crate) file: PathBuf,
    content: File,
    /// The animations that play, by their numbers.
    pub(crate) playing: Vec<usize>,
}

impl Deref for Input {
    type Target = File;

    fn deref(&self) -> &File {
        &self.content
    }
}

pub(crate) struct ChosenLight {
    pub(crate) light: Light,
    /// The light in the file, if it comes from the file.
    pub(crate) of_file: Option<SceneLight>,
}

/// The input at one time.
pub(crate) struct Scene<'a> {
    pub(crate) mesh: Mesh,
    pub(crate) shape: Shape<'a>,
}

pub(crate) enum Shape<'a> {
    /// World-space positions, used bit for bit.
    World(&'a [[f32; 3]]),
    /// A model that is yet to be deformed.
    Posed { model: &'a Model, pose: Pose },
}

impl<'a> Shape<'a> {
    pub(crate) fn on_cpu(&self, times: &mut Times) -> Result<Cow<'a, [[f32; 3]]>, Failure> {
        match self {
            Self::World(positions) => Ok(Cow::Borrowed(positions)),
            Self::Posed { model, pose } => {
                let deformed = times.measure("deform", || cpu::deform(model, pose, 0.0, None, Threads::all()));
                Ok(Cow::Owned(deformed?))
            }
        }
    }
}

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn triangle() -> Option<Model> {
    let geometry = Geometry::new(CORNERS.to_vec(), vec![[0, 1, 2]], GeometryOptions::default()).ok()?;
    Model::new(vec![geometry], vec![Instance::new(0, None)]).ok()
}

impl Scene<'_> {
    /// Compiles shaders before stages are timed: many drivers do so when one runs first. `work` takes a triangle, deformed
    /// on the GPU where the shape is. If no such triangle can be made, nothing fails: then the first run compiles.
    pub(crate) fn warm_up(
        &self,
        times: &mut Times,
        work: impl FnOnce(&Scene<'_>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        times.measure("compile", || {
            let Some((model, pose)) = triangle().zip(resting().ok()) else { return Ok(()) };
            let Ok(mesh) = model.mesh(&pose) else { return Ok(()) };
            let is_posed = matches!(self.shape, Shape::Posed { .. });
            let shape = if is_posed { Shape::Posed { model: &model, pose } } else { Shape::World(&CORNERS) };
            work(&Scene { mesh, shape })
        })
    }
}

impl Input {
    /// A triangle that no file has.
    pub(crate) fn triangle() -> Option<Self> {
        let content = File::in_world(triangle()?, Origin::ZERO);
        Some(Self { file: PathBuf::from("triangle"), content, playing: Vec::new() })
    }

    pub(crate) fn read(file: &Path, options: &ReadOptions) -> Result<Self, Failure> {
        const SHOWN: usize = 20;
        let content = if files::is_standard(file) {
            files::read(file, options.memory_limit).and_then(|bytes| read_bytes(&bytes, None, options))
        } else {
            rimline_files::read(file, options)
        };
        let content = content.map_err(|error| Failure::input(file, error))?;
        let input = Self { file: file.to_owned(), content, playing: Vec::new() };
        input.warnings().take(SHOWN).for_each(|warning| input.warn(Some(warning.to_string())));
        let more = input.warnings().count().saturating_sub(SHOWN);
        input.warn((more > 0).then(|| format!("{more} more warnings; `rimline info --json` lists them")));
        input.warn(input.non_finite());
        if let Weld::Distance(distance) = options.weld {
            input.warn(input.wide_groups(distance));
        }
        Ok(input)
    }

    /// A file that is read alone and whose animations do not play.
    pub(crate) fn at_rest(file: &Path, options: &ReadOptions) -> Result<Self, Failure> {
        let mut input = Self::read(file, options)?;
        settle(std::slice::from_mut(&mut input), 0.0)?;
        Ok(input)
    }

    fn warn(&self, warning: Option<String>) {
        if let Some(warning) = warning {
            note(&format!("warning: {}: {warning}", self.file.display()));
        }
    }

    /// The file, and those that it names, textures included.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&*self.file).chain(self.named_files().iter().map(PathBuf::as_path))
    }

    /// The file is damaged, or the command line asks for what cannot be.
    pub(crate) fn failed(&self, error: FileError) -> Failure {
        match error {
            FileError::Gltf(error @ GltfError::SameProperty { .. }) => {
                Failure::usage(format!("{}: {error}", self.file.display()))
            }
            error => Failure::input(&self.file, error),
        }
    }

    fn not_posed(&self, error: GltfError) -> Failure {
        self.failed(FileError::Gltf(error))
    }

    /// The mesh and its shape at a time. `displaced` shapes always come as a model, so that `displace` can run.
    pub(crate) fn scene(&self, time_s: f32, displaced: bool) -> Result<Scene<'_>, Failure> {
        let shape = self.shape(time_s, displaced)?;
        Ok(Scene { mesh: self.mesh(&shape)?, shape })
    }

    /// The shape at a time, without a mesh of all instances.
    pub(crate) fn shape(&self, time_s: f32, displaced: bool) -> Result<Shape<'_>, Failure> {
        match self.world_positions() {
            Some(_) if displaced && self.polygons().is_some() => Err(Failure::input(
                &self.file,
                "it has polygons, whose vertices cannot be displaced so far; cut its faces into triangles, as \
                 those of an .obj are without --polygons",
            )),
            Some(positions) if !displaced => Ok(Shape::World(positions)),
            _ => {
                let pose = self.pose(&self.playing, time_s).map_err(|error| self.failed(error))?;
                Ok(Shape::Posed { model: self.model(), pose })
            }
        }
    }

    /// Whether the faces of each instance are turned.
    pub(crate) fn turned(&self, shape: &Shape<'_>) -> impl Iterator<Item = bool> {
        let pose = match shape {
            Shape::World(_) => None,
            Shape::Posed { pose, .. } => Some(pose.instances()),
        };
        let is_turned =
            move |instance: usize| pose.and_then(|pose| pose.get(instance)).is_some_and(InstancePose::faces_turned);
        (0..self.model().instances().len()).map(is_turned)
    }

    /// The base colours of the corners of all instances, if the file has some.
    pub(crate) fn corner_colors(&self, shape: &Shape<'_>) -> Option<Vec<[u32; 3]>> {
        corner_colors(self.model(), self.turned(shape), |geometry| self.colors(geometry))
    }

    pub(crate) fn note_colors(&self) {
        self.color_notes().iter().for_each(|note| self.warn(Some(note.clone())));
    }

    pub(crate) fn mesh(&self, shape: &Shape<'_>) -> Result<Mesh, Failure> {
        if let (Some(mesh), Shape::World(_)) = (self.polygons(), shape) {
            return Ok(Mesh::clone(mesh));
        }
        let mesh = match shape {
            Shape::Posed { model, pose } => model.mesh(pose).map_err(|error| match error {
                ModelError::Mesh(error) => self.no_mesh(error),
                error => error.into(),
            }),
            Shape::World(_) => resting().and_then(|pose| self.model().mesh(&pose)).map_err(Cause::from),
        };
        mesh.map_err(|error| Failure::input(&self.file, error))
    }

    /// Why there is no mesh, in words for the whole file.
    pub(crate) fn no_mesh(&self, error: MeshError) -> Cause {
        match error {
            MeshError::NoFaces if self.asset().is_some() => {
                "its scene has no triangles; nothing is placed in it, or all of that is hidden or lines and points \
                 (`rimline info` lists it)"
                    .into()
            }
            MeshError::NoFaces if self.polygons().is_some() => NO_AREA.into(),
            error => error.into(),
        }
    }

    pub(crate) fn view(&self, args: &ViewArgs, time_s: f32) -> Result<PlacedView, Failure> {
        let camera = self.camera(&args.camera, time_s)?;
        self.warn_of_mirror(camera.as_ref());
        Ok(PlacedView { camera, ..args.relative_to(self.origin()) })
    }

    /// Warns of a camera whose picture would be a mirror image.
    pub(crate) fn warn_of_mirror(&self, camera: Option<&SceneCamera>) {
        let is_negative = |camera: &&SceneCamera| match camera.projection {
            CameraProjection::Orthographic { xmag, ymag, .. } => xmag.min(ymag) < 0.0,
            CameraProjection::Perspective { .. } => false,
        };
        let why = "its camera has a negative xmag or ymag, and pictures are not mirrored: signs have no effect";
        self.warn(camera.filter(is_negative).map(|_| why.to_owned()));
    }

    /// The camera of the file that is asked for, at a time.
    pub(crate) fn camera(&self, args: &CameraArgs, time_s: f32) -> Result<Option<SceneCamera>, Failure> {
        let Some(wanted) = args.wanted.as_deref() else { return Ok(None) };
        let file = self.file.display();
        let asset = self.asset().filter(|asset| !asset.camera_names().is_empty());
        let asset = asset.ok_or_else(|| {
            Failure::usage(format!(
                "{file}: its scene has no cameras; leave --camera out, or say with --eye and --target where to \
                 look from"
            ))
        })?;
        let names = asset.camera_names();
        let index = number_of(&names, wanted).ok_or_else(|| {
            let there = listed("camera", names.iter().copied());
            Failure::usage(format!("{file}: its scene has no camera `{wanted}`; it has {there}"))
        })?;
        let mut cameras = asset.each_camera(self.playing.clone(), time_s).map_err(|error| self.not_posed(error))?;
        cameras.swap_remove(index).map(Some).map_err(|error| self.not_posed(error))
    }

    /// The lights asked for, in the order asked for, fit for an extraction.
    pub(crate) fn lights(&self, specs: &[LightSpec], time_s: f32) -> Result<Vec<Light>, Failure> {
        Ok(self.chosen_lights(specs, time_s)?.into_iter().map(|chosen| chosen.light).collect())
    }

    /// The same, with what the file says of its own.
    pub(crate) fn chosen_lights(&self, specs: &[LightSpec], time_s: f32) -> Result<Vec<ChosenLight>, Failure> {
        let (names, file_lights) = match self.asset() {
            Some(asset) if specs.iter().any(|spec| !matches!(spec, LightSpec::Given(_))) => {
                let lights = asset.each_light(self.playing.clone(), time_s);
                (asset.light_names(), lights.map_err(|error| self.not_posed(error))?)
            }
            _ => (Vec::new(), Vec::new()),
        };
        let mut chosen = Vec::with_capacity(specs.len());
        for spec in specs {
            let numbers = match spec {
                LightSpec::Given(given) => {
                    chosen.push(ChosenLight { light: given.relative_to(self.origin()), of_file: None });
                    continue;
                }
                LightSpec::All if file_lights.is_empty() => {
                    let give = "give some with `--light point:x,y,z` or `--light dir:x,y,z`";
                    return Err(Failure::usage(format!("the file has no lights; {give}")));
                }
                LightSpec::All => 0..file_lights.len(),
                LightSpec::Named(wanted) => {
                    let number = number_of(&names, wanted).ok_or_else(|| {
                        let there = listed("light", names.iter().copied());
                        Failure::usage(format!("the scene of the file has no light `{wanted}`; it has {there}"))
                    })?;
                    number..number + 1
                }
            };
            for light in &file_lights[numbers] {
                let light = light.clone().map_err(|error| self.not_posed(error))?;
                chosen.push(ChosenLight { light: light.light, of_file: Some(light) });
            }
        }
        let lights: Vec<Light> = chosen.iter().map(|chosen| chosen.light).collect();
        match check_lights(&lights, MAX_LIGHTS) {
            Ok(()) => Ok(chosen),
            Err(error @ (LightError::NoRoom | LightError::TooMany { .. })) => Err(Failure::usage(error.to_string())),
            // Lights of the command line were checked when they were parsed, so the file has the wrong one.
            Err(error) => Err(Failure::input(&self.file, format!("its lights cannot be used: {error}"))),
        }
    }

    /// The animations that one `--animation` names, by their numbers: one, or all.
    fn named_animations(&self, wanted: &str) -> Result<Vec<usize>, Failure> {
        let found = self.asset().map_or(0..0, |asset| match asset.animation_index(wanted) {
            _ if wanted == "all" => 0..asset.animations().len(),
            index => index.map_or(0..0, |index| index..index + 1),
        });
        if found.is_empty() {
            let there = self.asset().map_or_else(|| "the file has none".to_owned(), listed_animations);
            return Err(Failure::usage(format!("there is no animation `{wanted}`; {there}")));
        }
        Ok(found.collect())
    }
}

/// The number of what has a name, or else that number.
fn number_of(names: &[Option<&str>], wanted: &str) -> Option<usize> {
    let numbered = || wanted.parse().ok().filter(|&index| index < names.len());
    names.iter().position(|name| *name == Some(wanted)).or_else(numbered)
}

/// Plays the animations of each file that `--animation` names. Every name must be that of an animation in one of the files.
pub(crate) fn play(inputs: &mut [Input], args: &PoseArgs) -> Result<(), Failure> {
    for wanted in &args.animations {
        let found: Vec<_> = inputs.iter().map(|input| input.named_animations(wanted)).collect();
        let is_there = found.iter().any(Result::is_ok);
        for (input, found) in inputs.iter_mut().zip(found) {
            match found {
                Ok(found) => input.playing.extend(found),
                Err(missing) if !is_there => return Err(missing),
                Err(_) => {}
            }
        }
    }
    for input in inputs.iter().filter(|input| !input.playing.is_empty()) {
        // An error at one time occurs at all times.
        let lights = input.asset().map_or(Ok(Vec::new()), |asset| asset.each_light(input.playing.clone(), 0.0));
        lights.map_err(|error| input.not_posed(error))?;
    }
    Ok(())
}

/// Moves the files to one origin near the models, where coordinates are too large for `f32`, and warns where `f32` still
/// loses much.
pub(crate) fn settle(inputs: &mut [Input], time_s: f32) -> Result<Origin, Failure> {
    let mut files: Vec<_> = inputs.iter_mut().map(|input| (&mut input.content, &*input.playing)).collect();
    let settled = rimline_files::settle(&mut files, time_s).map_err(|(index, error)| inputs[index].failed(error))?;
    for (input, warning) in inputs.iter().zip(settled.warnings) {
        if let Some(warning) = warning {
            note(&format!("warning: {}: {warning}", Line(input.file.display())));
        }
    }
    Ok(settled.origin)
}

pub(crate) fn read_displacement(file: &Path) -> Result<Displacement, Failure> {
    let displacement = Displacement::new(&files::read_text(file)?).map_err(|error| Failure::input(file, error))?;
    if displacement.uses_resources() {
        return Err(Failure::input(
            file,
            "the displacement declares bindings, but the command has no resources for them; use functions \
             and constants only",
        ));
    }
    Ok(displacement)
}

/// Tells whoever gives a time that nothing moves with it.
pub(crate) fn note_idle_time(pose: &PoseArgs, is_moving: bool) {
    if pose.time != 0.0 && !is_moving {
        note("warning: --time has no effect without --animation or --displace");
    }
}

/// Work that a device did.
pub(crate) struct Done<T> {
    /// The device's name.
    pub(crate) device: String,
    pub(crate) result: T,
    /// The times until then, with those of the work.
    pub(crate) times: Times,
}

/// A model at a time: what `extract`, `query` and `draw` read before they open a device.
pub(crate) struct PosedInput<'a> {
    args: &'a MomentArgs,
    pub(crate) input: Input,
    pub(crate) displacement: Option<Displacement>,
}

impl<'a> PosedInput<'a> {
    pub(crate) fn read(args: &'a MomentArgs, model: &ModelArgs) -> Result<Self, Failure> {
        if args.device.device == Wanted::Cpu && args.displace.is_some() {
            return Err(Failure::usage(DISPLACE_ON_CPU));
        }
        let displacement = args.displace.as_deref().map(read_displacement).transpose()?;
        let mut input = Input::read(&model.file, &model.read.options())?;
        play(std::slice::from_mut(&mut input), &args.pose)?;
        settle(std::slice::from_mut(&mut input), args.pose.time)?;
        note_idle_time(&args.pose, displacement.is_some() || !input.playing.is_empty());
        Ok(Self { args, input, displacement })
    }

    /// The files that were read, and those that the model names.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.input.files().chain(self.args.displace.as_deref())
    }

    pub(crate) fn time_s(&self) -> f32 {
        self.args.pose.time
    }

    /// The mesh, its edge records, and where its vertices are.
    pub(crate) fn scene(&self) -> Result<Scene<'_>, Failure> {
        self.input.scene(self.time_s(), self.displacement.is_some())
    }

    /// Does the work on the device that was asked for, or on the CPU if `auto` finds no GPU that does it. `run` may run
    /// twice: on a GPU that the model does not fit, then on the CPU.
    pub(crate) fn work<T>(
        &self,
        (progress, what): (&Progress, &'static str),
        times: &Times,
        mut run: impl FnMut(&Device, &mut Times) -> Result<T, Failure>,
    ) -> Result<Done<T>, Failure> {
        progress.step("opening the device");
        let begin = Instant::now();
        let timed = |device: &Device| {
            progress.step(what);
            let mut times = times.clone();
            times.add("device", begin.elapsed().as_secs_f64() * 1e3);
            Ok((run(device, &mut times)?, times))
        };
        let (device, (result, times)) = device::work(&self.args.device.device, self.device()?, timed)?;
        progress.step("writing");
        Ok(Done { device: device.name(), result, times })
    }

    /// Opens the device, which must be a GPU to displace vertices.
    fn device(&self) -> Result<Device, Failure> {
        let wanted = &self.args.device.device;
        if self.displacement.is_none() {
            return device::open_fastest(wanted);
        }
        let mut device = device::open(wanted)?;
        match &mut device {
            Device::Cpu => return Err(Failure::usage(DISPLACE_ON_CPU)),
            Device::Gpu(gpu) => gpu.cpu_would_do = false,
        }
        Ok(device)
    }
}

/// World-space positions on the GPU: uploaded, or deformed there.
pub(crate) enum Positions {
    Uploaded(wgpu::Buffer),
    Deformed(Box<Deformer>),
}

impl Positions {
    pub(crate) fn new(gpu: &Gpu, shape: &Shape<'_>, displacement: Option<&Displacement>) -> Result<Self, GpuError> {
        match shape {
            Shape::World(positions) => {
                let bytes: &[u8] = bytemuck::cast_slice(positions);
                let (label, size, limit) = ("positions", bytes.len() as u64, gpu.device.limits().max_buffer_size);
                if size > limit {
                    return Err(DeviceError::BufferTooLarge { label, bytes: size, limit }.into());
                }
                let on = (&gpu.device, &gpu.queue);
                Ok(Self::Uploaded(rimline_picture::filled(on, label, bytes, wgpu::BufferUsages::STORAGE)))
            }
            Shape::Posed { model, .. } => {
                let options = DeformerOptions { displacement, ..DeformerOptions::default() };
                Ok(Self::Deformed(Box::new(Deformer::new(&gpu.pipelines, model, options)?)))
            }
        }
    }

    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        shape: &Shape<'_>,
        time_s: f32,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        if let (Self::Deformed(deformer), Shape::Posed { pose, .. }) = (self, shape) {
            deformer.encode_timed(encoder, PoseInputs { time_s, ..PoseInputs::new(pose) }, timer)?;
        }
        Ok(())
    }

    /// Encodes and submits it by itself.
    pub(crate) fn submit(&self, gpu: &Gpu, shape: &Shape<'_>, time_s: f32) -> Result<(), GpuError> {
        let mut encoder = gpu.encoder("positions");
        self.encode(&mut encoder, shape, time_s, None)?;
        gpu.submit(encoder);
        Ok(())
    }

    pub(crate) fn buffer(&self) -> PositionBuffer<'_> {
        match self {
            Self::Uploaded(buffer) => PositionBuffer { buffer, offset: 0, stride: 12 },
            Self::Deformed(deformer) => deformer.positions(),
        }
    }

    /// Uploaded positions are those of one instance.
    pub(crate) fn of_instance(&self, instance: usize) -> Option<PositionBuffer<'_>> {
        match self {
            Self::Uploaded(_) => (instance == 0).then(|| self.buffer()),
            Self::Deformed(deformer) => deformer.instance_positions(instance),
        }
    }

    /// The positions of a shape as they lie on the GPU. Waits for the device.
    pub(crate) fn read<'s>(&self, gpu: &Gpu, shape: &Shape<'s>) -> Result<Cow<'s, [[f32; 3]]>, GpuError> {
        match shape {
            Shape::World(positions) => Ok(Cow::Borrowed(positions)),
            Shape::Posed { model, .. } => {
                let mut positions = gpu.read(self.buffer().buffer)?;
                positions.truncate(model.vertex_count());
                Ok(Cow::Owned(positions))
            }
        }
    }
}
