//! Positions on the GPU, whether the file has them or a pose makes them.

use rimline::gpu::{Deformer, DeformerOptions, DeviceError, PoseInputs, PositionBuffer, StageTimer};
use rimline::{Displacement, wgpu};

use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::input::Shape;

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
                Ok(Self::Uploaded(gpu.filled("positions", bytes, wgpu::BufferUsages::STORAGE)))
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
