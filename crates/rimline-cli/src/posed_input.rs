//! A model at a posed: what `extract`, `query` and `draw` read before they open a device; and its positions on the GPU.

use std::path::Path;
use std::time::Instant;

use rimline::gpu::{Deformer, DeformerOptions, DeviceError, PoseInputs, PositionBuffer, StageTimer};
use rimline::{Displacement, Light, wgpu};

use crate::device::{self, Device, Gpu, Wanted};
use crate::failure::{Failure, InputError, UsageError};
use crate::gpu_error::GpuError;
use crate::input::{Input, Scene, Shape};
use crate::input_args::{ModelArgs, MomentArgs, PlacedView, PoseArgs, ViewArgs};
use crate::output::note;
use crate::progress::Progress;
use crate::report::Times;
use crate::shown::listed_animations;
use crate::spec::LightSpec;
use crate::{origin, source};

pub(crate) struct PosedInput<'a> {
    args: &'a MomentArgs,
    pub(crate) input: Input,
    animations: Vec<usize>,
    pub(crate) displacement: Option<Displacement>,
}

impl<'a> PosedInput<'a> {
    pub(crate) fn read(args: &'a MomentArgs, model: &ModelArgs) -> Result<Self, Failure> {
        if Wanted::parse(&args.device.device) == Wanted::Cpu && args.displace.is_some() {
            return Err(UsageError::DisplaceOnCpu.into());
        }
        let displacement = args.displace.as_deref().map(read_displacement).transpose()?;
        let mut input = Input::open(model)?;
        let chosen = animations(std::slice::from_ref(&input), &args.pose)?;
        origin::settle(std::slice::from_mut(&mut input), &chosen, args.pose.time)?;
        let animations = chosen.concat();
        note_idle_time(&args.pose, &animations, displacement.as_ref());
        Ok(Self { args, input, animations, displacement })
    }

    /// The files that were read, and those that the model names.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.input.files().chain(self.args.displace.as_deref())
    }

    /// The view of a picture.
    pub(crate) fn view(&self, args: &ViewArgs) -> Result<PlacedView, Failure> {
        self.input.view(args, &self.animations, self.time_s())
    }

    pub(crate) fn time_s(&self) -> f32 {
        self.args.pose.time
    }

    pub(crate) fn lights(&self, specs: &[LightSpec]) -> Result<Vec<Light>, Failure> {
        self.input.lights(specs, &self.animations, self.time_s())
    }

    /// The mesh, its edge records, and where its vertices are.
    pub(crate) fn scene(&self) -> Result<Scene<'_>, Failure> {
        self.input.scene(&self.animations, self.time_s(), self.displacement.is_some())
    }

    /// Does the work on the device that was asked for, or on the CPU where that may be and must be. Returns the
    /// device's name, and the times with those of the work.
    pub(crate) fn work<T>(
        &self,
        (progress, what): (&Progress, &'static str),
        times: &Times,
        mut run: impl FnMut(&Device, &mut Times) -> Result<T, Failure>,
    ) -> Result<(String, T, Times), Failure> {
        progress.step("opening the device");
        let begin = Instant::now();
        let timed = |device: &Device| {
            progress.step(what);
            let mut times = times.clone();
            times.add("device", begin.elapsed().as_secs_f64() * 1e3);
            Ok((run(device, &mut times)?, times))
        };
        let (device, (done, times)) = device::work(&Wanted::parse(&self.args.device.device), self.device()?, timed)?;
        progress.step("writing");
        Ok((device.name(), done, times))
    }

    /// Opens the device, which must be a GPU to displace vertices.
    fn device(&self) -> Result<Device, Failure> {
        let wanted = Wanted::parse(&self.args.device.device);
        if self.displacement.is_none() {
            return device::open_fastest(&wanted);
        }
        let mut device = device::open(&wanted)?;
        match &mut device {
            Device::Cpu => return Err(UsageError::DisplaceOnCpu.into()),
            Device::Gpu(gpu) => gpu.cpu_would_do = false,
        }
        Ok(device)
    }
}

/// The animations of each file that `--animation` names. Every name must be that of an animation in one of the files.
pub(crate) fn animations(inputs: &[Input], args: &PoseArgs) -> Result<Vec<Vec<usize>>, Failure> {
    let mut chosen = vec![Vec::new(); inputs.len()];
    for wanted in &args.animations {
        let found: Vec<_> = inputs.iter().map(|input| named(input, wanted)).collect();
        let is_there = found.iter().any(Result::is_ok);
        for (chosen, found) in chosen.iter_mut().zip(found) {
            match found {
                Ok(found) => chosen.extend(found),
                Err(missing) if !is_there => return Err(missing),
                Err(_) => {}
            }
        }
    }
    inputs.iter().zip(&chosen).try_for_each(|(input, chosen)| check(input, chosen))?;
    Ok(chosen)
}

/// The animations of a file that one `--animation` names, by their numbers: one, or all.
fn named(input: &Input, wanted: &str) -> Result<Vec<usize>, Failure> {
    let (found, there) = match input.asset() {
        Some(asset) if wanted == "all" => (0..asset.animations().len(), listed_animations(asset)),
        Some(asset) => {
            let found = asset.animation_index(wanted).map_or(0..0, |index| index..index + 1);
            (found, listed_animations(asset))
        }
        None => (0..0, "the file has none".to_owned()),
    };
    if found.is_empty() {
        return Err(UsageError::Animation { wanted: wanted.to_owned(), there }.into());
    }
    Ok(found.collect())
}

fn check(input: &Input, animations: &[usize]) -> Result<(), Failure> {
    match input.asset() {
        // An error at one time occurs at all times.
        Some(asset) if !animations.is_empty() => {
            asset.each_light(animations.iter().copied(), 0.0).map(drop).map_err(|error| input.not_posed(error))
        }
        _ => Ok(()),
    }
}

pub(crate) fn read_displacement(file: &Path) -> Result<Displacement, Failure> {
    let read = || -> Result<Displacement, InputError> {
        let displacement = Displacement::new(&source::read_text(file)?)?;
        if displacement.uses_resources() {
            return Err(InputError::DisplacementResources);
        }
        Ok(displacement)
    };
    read().map_err(Failure::input(file))
}

/// Tells whoever gives a time that nothing moves with it.
pub(crate) fn note_idle_time(pose: &PoseArgs, animations: &[usize], displacement: Option<&Displacement>) {
    if pose.time != 0.0 && animations.is_empty() && displacement.is_none() {
        note("warning: --time has no effect without --animation or --displace");
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
                let (size, limit) = (bytes.len() as u64, gpu.device.limits().max_buffer_size);
                if size > limit {
                    let label = "positions";
                    return Err(DeviceError::BufferTooLarge { label, bytes: size, limit }.into());
                }
                Ok(Self::Uploaded(rimline_picture::filled(
                    (&gpu.device, &gpu.queue),
                    "positions",
                    bytes,
                    wgpu::BufferUsages::STORAGE,
                )))
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

    pub(crate) fn buffer(&self) -> PositionBuffer<'_> {
        match self {
            Self::Uploaded(buffer) => PositionBuffer { buffer, offset: 0, stride: 12 },
            Self::Deformed(deformer) => deformer.positions(),
        }
    }

    pub(crate) fn of_instance(&self, instance: usize) -> Option<PositionBuffer<'_>> {
        match self {
            Self::Uploaded(_) => (instance == 0).then(|| self.buffer()),
            Self::Deformed(deformer) => deformer.instance_positions(instance),
        }
    }

    pub(crate) fn read(&self, gpu: &Gpu, vertices: usize) -> Result<Vec<[f32; 3]>, GpuError> {
        let mut positions = gpu.read(self.buffer().buffer)?;
        positions.truncate(vertices);
        Ok(positions)
    }
}
