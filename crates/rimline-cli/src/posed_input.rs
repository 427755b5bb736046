//! A model at a posed: what `extract`, `query` and `draw` read before they open a device.

use std::path::Path;

use rimline::{Displacement, Light};

use crate::chosen_animations;
use crate::device::{self, Device, Wanted};
use crate::displacement;
use crate::failure::{Failure, UsageError};
use crate::input::{Input, Scene};
use crate::input_args::{ModelArgs, MomentArgs};
use crate::origin;
use crate::spec::LightSpec;

pub(crate) struct PosedInput<'a> {
    args: &'a MomentArgs,
    pub(crate) input: Input,
    animations: Vec<usize>,
    pub(crate) displacement: Option<Displacement>,
}

impl<'a> PosedInput<'a> {
    /// Reads the model and the displacement.
    pub(crate) fn read(args: &'a MomentArgs, model: &ModelArgs) -> Result<Self, Failure> {
        if Wanted::parse(&args.device.device) == Wanted::Cpu && args.displace.is_some() {
            return Err(UsageError::DisplaceOnCpu.into());
        }
        let displacement = args.displace.as_deref().map(displacement::read).transpose()?;
        let mut input = Input::open(model)?;
        let chosen = chosen_animations::animations(std::slice::from_ref(&input), &args.pose)?;
        origin::settle(std::slice::from_mut(&mut input), &chosen, args.pose.time)?;
        let animations = chosen.concat();
        displacement::note_idle_time(&args.pose, &animations, displacement.as_ref());
        Ok(Self { args, input, animations, displacement })
    }

    /// The files that were read, and those that the model names.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.input.files().chain(self.args.displace.as_deref())
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

    /// Does the work on the device that was asked for, or on the CPU where that may be and must be. Returns the device.
    pub(crate) fn work<T>(&self, run: impl FnMut(&Device) -> Result<T, Failure>) -> Result<(Device, T), Failure> {
        device::work(&Wanted::parse(&self.args.device.device), self.device()?, run)
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
