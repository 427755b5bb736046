//! Devices whose uncaptured errors are kept, and small things on them.

use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use glam::camera::rh::proj::directx::perspective_infinite_reverse;
use glam::camera::rh::view::look_at_mat4;
use rimline::gpu::{Extractor, ExtractorOptions, PositionBuffer, ShadowFormat};
use rimline::{DepthDirection, Light, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::texture;
use rimline_testkit::shapes::{self, Shape};

/// A device, and what went to its handler of uncaptured errors.
pub(crate) struct Watched {
    pub(crate) gpu: Gpu,
    errors: Arc<Mutex<Vec<String>>>,
}

impl Watched {
    pub(crate) fn new(features: wgpu::Features, limits: wgpu::Limits) -> Result<Self, String> {
        Ok(Self::of(Gpu::with(features, limits)?))
    }

    pub(crate) fn of(gpu: Gpu) -> Self {
        let errors = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&errors);
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            kept.lock().unwrap_or_else(PoisonError::into_inner).push(error.to_string());
        }));
        Self { gpu, errors }
    }

    pub(crate) fn plain() -> Result<Self, String> {
        Self::new(wgpu::Features::empty(), wgpu::Limits::default())
    }

    /// Fails where an error was not captured.
    pub(crate) fn quiet(&self, what: &str) -> Result<(), String> {
        let errors = std::mem::take(&mut *self.errors.lock().unwrap_or_else(PoisonError::into_inner));
        match errors.first() {
            None => Ok(()),
            Some(first) => Err(format!("{what}: {} device errors, first: {first}", errors.len())),
        }
    }

    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }
}

/// A closed mesh, and where its vertices are.
pub(crate) fn caster() -> Result<(Shape, Mesh), String> {
    let shape = shapes::torus(24, 16, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    Ok((shape, mesh))
}

pub(crate) fn extractor(watched: &Watched, mesh: &Mesh, max_lights: usize) -> Result<Extractor, String> {
    let options = ExtractorOptions { max_lights, ..Default::default() };
    Extractor::new(&watched.gpu.pipelines, mesh, options).map_err(text)
}

pub(crate) fn packed(buffer: &wgpu::Buffer) -> PositionBuffer<'_> {
    PositionBuffer { buffer, offset: 0, stride: 12 }
}

pub(crate) const LIGHT: Light = Light::point([3.0, 5.0, 2.0]);

pub(crate) fn camera() -> ShadowCamera {
    let view = look_at_mat4(Vec3::new(1.0, 2.0, 6.0), Vec3::ZERO, Vec3::Y);
    let view_projection = (perspective_infinite_reverse(1.0, 1.0, 0.1) * view).to_cols_array_2d();
    ShadowCamera { view_projection, origin: [0.0; 3], depth: DepthDirection::Reversed }
}

/// A small attachment of the default format.
pub(crate) fn depth_stencil(watched: &Watched) -> wgpu::TextureView {
    let descriptor = texture([16; 2], ShadowFormat::default().depth_stencil);
    watched.gpu.device.create_texture(&descriptor).create_view(&wgpu::TextureViewDescriptor::default())
}
