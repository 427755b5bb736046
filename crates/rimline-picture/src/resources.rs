//! The resources that all pictures and masks of a device share: the frame, the lights, layouts.

use crate::bindings::{READ_ONLY, UNIFORM, UNIFORM_AT_OFFSET};
use crate::factory::PipelineFactory;
use crate::frame::{Frame, SceneView};
use crate::lights::ShadedLightData;

/// The frame and the lights on a device, and the layouts of their groups.
#[derive(Debug)]
pub struct Resources {
    /// Makes pipelines behind `scene.wgsl`.
    pub factory: PipelineFactory,
    /// The layout of group 1, a light.
    pub light: wgpu::BindGroupLayout,
    /// The layout of group 2, a surface.
    pub(crate) surface: wgpu::BindGroupLayout,
    lights: wgpu::Buffer,
    light_group: wgpu::BindGroup,
}

/// From a light's data to the next's.
const STRIDE: u64 = 256;

impl Resources {
    /// With room for so many lights, or samples of lights.
    pub fn new(on: (&wgpu::Device, &wgpu::Queue), lights: usize) -> Self {
        let factory = PipelineFactory::new(on, include_str!("scene.wgsl"), &[0; size_of::<Frame>()]);
        let light = factory.layout(&[UNIFORM_AT_OFFSET]);
        let surface = factory.layout(&[UNIFORM, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY]);
        let lights = factory.uniform("lights", &vec![0; STRIDE as usize * lights.max(1)]);
        let size = wgpu::BufferSize::new(size_of::<ShadedLightData>() as u64);
        let one = wgpu::BufferBinding { buffer: &lights, offset: 0, size };
        let light_group = factory.group(&light, &[wgpu::BindingResource::Buffer(one)]);
        Self { factory, light, surface, lights, light_group }
    }

    /// Shows a scene with what is submitted from now on.
    pub fn set(&self, view: &SceneView<'_>) {
        self.factory.set_frame(bytemuck::bytes_of(&view.frame()));
        for (offset, light) in (0..).map(|number| number * STRIDE).zip(view.light_data()) {
            self.factory.write(&self.lights, offset, bytemuck::bytes_of(&light));
        }
    }

    /// Binds the frame and a light.
    pub fn select(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) {
        pass.set_bind_group(0, &self.factory.frame_group, &[]);
        pass.set_bind_group(1, &self.light_group, &[light as u32 * STRIDE as u32]);
    }
}
