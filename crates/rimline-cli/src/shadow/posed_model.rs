//! A file's model at one posed.

use rimline::reference::cpu::is_finite;
use rimline::{Displacement, wgpu};

use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use crate::input::{Input, Scene, Shape};
use crate::input_args::PoseArgs;
use crate::positions::Positions;

/// A model and where its vertices are.
pub(crate) struct PosedModel<'a> {
    pub(crate) input: &'a Input,
    animation: Option<usize>,
    displaced: bool,
    pub(crate) scene: Scene<'a>,
    pub(crate) positions: Positions,
    /// World space, as they lie on the GPU.
    pub(crate) world: Vec<[f32; 3]>,
}

impl<'a> PosedModel<'a> {
    pub(crate) fn new(
        gpu: &Gpu,
        input: &'a Input,
        animation: Option<usize>,
        time_s: f32,
        displacement: Option<&Displacement>,
    ) -> Result<Self, Failure> {
        let displaced = displacement.is_some();
        let scene = input.scene(animation, time_s, displaced)?;
        let positions = Positions::new(gpu, &scene.shape, displacement).map_err(|error| error.on(gpu))?;
        let mut body = Self { input, animation, displaced, scene, positions, world: Vec::new() };
        body.place(gpu, time_s).map_err(|error| error.on(gpu))?;
        Ok(body)
    }

    /// Moves to another posed.
    pub(crate) fn pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), Failure> {
        if let Shape::Posed { .. } = self.scene.shape {
            self.scene = self.input.scene(self.animation, time_s, self.displaced)?;
            self.place(gpu, time_s).map_err(|error| error.on(gpu))?;
        }
        Ok(())
    }

    fn place(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), GpuError> {
        match &self.scene.shape {
            Shape::World(positions) => self.world = positions.to_vec(),
            Shape::Posed { .. } => {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                self.positions.encode(&mut encoder, &self.scene.shape, time_s, None)?;
                gpu.queue.submit([encoder.finish()]);
                self.world = self.positions.read(gpu, self.scene.mesh.vertex_count() as usize)?;
            }
        }
        Ok(())
    }

    pub(crate) fn animation(&self) -> Option<usize> {
        self.animation
    }

    /// The vertices of the faces that are drawn, those with finite positions; each once.
    pub(crate) fn points(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        let is_drawn = |face: &&[u32; 3]| face.iter().all(|&v| is_finite(self.world[v as usize]));
        let mut is_used = vec![false; self.world.len()];
        for &v in self.scene.mesh.faces().iter().filter(is_drawn).flatten() {
            is_used[v as usize] = true;
        }
        self.world.iter().zip(is_used).filter_map(|(&position, is_used)| is_used.then_some(position))
    }
}

/// Which animation of each file `--animation` names: of those that have it, as at least one must.
pub(crate) fn animations(inputs: &[Input], args: &PoseArgs) -> Result<Vec<Option<usize>>, Failure> {
    let found: Vec<Result<Option<usize>, Failure>> = inputs.iter().map(|input| input.animation(args)).collect();
    let has_one = found.iter().any(Result::is_ok);
    found.into_iter().map(|animation| if has_one { Ok(animation.unwrap_or(None)) } else { animation }).collect()
}
