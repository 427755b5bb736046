//! Parts that all measurements share: the device, cameras, maps, passes, and times of commands.

use std::time::Instant;

use glam::{DMat4, DVec3, DVec4};
use rimline::gpu::{
    DepthMap, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, MeshDepth, PositionBuffer,
    ShadowFormat,
};
use rimline::{DepthDirection, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::shapes::Shape;
use wgpu::TextureFormat;

/// 24 bits, as in the paper.
pub(crate) const MAP: TextureFormat = TextureFormat::Depth24Plus;
pub(crate) const EYE: TextureFormat = TextureFormat::Depth24PlusStencil8;

/// Detectors and their names.
pub(crate) const DETECTORS: [(&str, DepthMapMethod); 6] = [
    ("every cell", DepthMapMethod::EveryCell),
    ("differences 0.0005", DepthMapMethod::Differences { threshold: 0.0005, dangling: None }),
    ("differences 0.02", DepthMapMethod::Differences { threshold: 0.02, dangling: None }),
    ("automatic", DepthMapMethod::Automatic { dangling: None }),
    ("second differences 0.0005, 0.05", DepthMapMethod::SecondDifferences { low: 0.0005, high: 0.05, dangling: None }),
    ("contours 0.005", DepthMapMethod::Contours { threshold: 0.005, sideways: 0.1, depth: 0.02 }),
];

/// One of the detectors.
pub(crate) fn way(wanted: &str) -> Result<DepthMapMethod, String> {
    let found = DETECTORS.into_iter().find(|(name, _)| *name == wanted);
    found.map(|(_, way)| way).ok_or_else(|| format!("no detector {wanted}"))
}

/// A near plane as in games, where units are metres.
const NEAR: f64 = 0.1;

/// A camera that looks from `distance` along `axes[2]` to the origin, and sees a ball of `radius` there. Lights have standard
/// depth from before the ball to behind it, eyes reversed depth from [`NEAR`] on.
pub(crate) fn camera([right, up, forward]: [DVec3; 3], distance: f64, radius: f64, is_light: bool) -> ShadowCamera {
    let place = -distance * forward;
    let scale = (distance * distance - radius * radius).sqrt() / radius;
    let row = |axis: DVec3| axis.extend(-axis.dot(place));
    let (w, near, far) = (row(forward), distance - radius, distance + radius);
    let (z, depth) = if is_light {
        ((w - DVec4::W * near) * (far / (far - near)), DepthDirection::Standard)
    } else {
        (DVec4::W * NEAR, DepthDirection::Reversed)
    };
    let rows = DMat4::from_cols(row(right) * scale, row(up) * scale, z, w);
    ShadowCamera { view_projection: rows.transpose().as_mat4().to_cols_array_2d(), origin: [0.0; 3], depth }
}

/// Axes of a camera, from a direction that it looks in and one that is up or nearly so.
pub(crate) fn axes(forward: DVec3, up: DVec3) -> [DVec3; 3] {
    let right = forward.cross(up).normalize();
    [right, right.cross(forward), forward]
}

pub(crate) struct Bench {
    pub(crate) gpu: Gpu,
    /// Into an attachment without color.
    pub(crate) pipelines: DepthMapPipelines,
}

/// A mesh with its positions on the GPU, and what draws its depth into maps and for the eye.
pub(crate) struct Drawn {
    pub(crate) mesh: Mesh,
    pub(crate) positions: wgpu::Buffer,
    pub(crate) into_map: MeshDepth,
    pub(crate) for_eye: MeshDepth,
}

impl Drawn {
    pub(crate) fn positions(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 }
    }
}

/// A depth texture with the view of its depths, and that of all aspects to draw to.
pub(crate) struct Target {
    pub(crate) depths: wgpu::TextureView,
    pub(crate) all: wgpu::TextureView,
}

impl Bench {
    pub(crate) fn new() -> Result<Self, String> {
        let timestamps = Gpu::with(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default());
        let gpu = timestamps.or_else(|_| Gpu::with_limits(wgpu::Limits::default()))?;
        let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 0).map_err(text)?;
        Ok(Self { gpu, pipelines })
    }

    pub(crate) fn drawn(&self, shape: &Shape) -> Result<Drawn, String> {
        let mesh = shape.mesh().map_err(text)?;
        let depth = |format, depth| MeshDepth::new(&self.gpu.pipelines, &mesh, format, depth).map_err(text);
        Ok(Drawn {
            into_map: depth(MAP, DepthDirection::Standard)?,
            for_eye: depth(EYE, DepthDirection::Reversed)?,
            positions: self.gpu.storage(&shape.positions),
            mesh,
        })
    }

    pub(crate) fn target(&self, side: u32, format: TextureFormat) -> Target {
        let texture = self.texture(side, format, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let aspect = wgpu::TextureAspect::DepthOnly;
        Target {
            depths: texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() }),
            all: texture.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    pub(crate) fn texture(&self, side: u32, format: TextureFormat, usage: wgpu::TextureUsages) -> wgpu::Texture {
        self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("bench"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    }

    pub(crate) fn volumes(&self, side: u32, method: DepthMapMethod) -> Result<DepthMapVolumes, String> {
        let options = DepthMapOptions { method, ..Default::default() };
        DepthMapVolumes::new(&self.pipelines, [side; 2], options).map_err(text)
    }

    /// Draws the depth of a mesh into a map.
    pub(crate) fn draw_map(
        encoder: &mut wgpu::CommandEncoder,
        drawn: &Drawn,
        map: &Target,
        light: &ShadowCamera,
    ) -> Result<(), String> {
        let mut pass = pass(encoder, &map.all, Some(1.0), false);
        drawn.into_map.draw(&mut pass, drawn.positions(), light).map_err(text)
    }

    /// Draws what the eye sees.
    pub(crate) fn draw_eye(
        encoder: &mut wgpu::CommandEncoder,
        drawn: &[&Drawn],
        target: &Target,
        eye: &ShadowCamera,
    ) -> Result<(), String> {
        let mut pass = pass(encoder, &target.all, Some(0.0), true);
        drawn.iter().try_for_each(|drawn| drawn.for_eye.draw(&mut pass, drawn.positions(), eye).map_err(text))
    }

    /// Milliseconds that commands take.
    pub(crate) fn clock(
        &self,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), String>,
    ) -> Result<f64, String> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        record(&mut encoder)?;
        let commands = encoder.finish();
        let begin = Instant::now();
        self.gpu.queue.submit([commands]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(text)?;
        Ok(begin.elapsed().as_secs_f64() * 1e3)
    }
}

/// The map of a light.
pub(crate) fn map_of(target: &Target, light: ShadowCamera) -> DepthMap<'_> {
    DepthMap { texture: &target.depths, light, objects: None }
}

/// A pass without color. `clear`: the depth that is far; without it, depth is read only and the stencil begins with 0.
pub(crate) fn pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    clear: Option<f32>,
    has_stencil: bool,
) -> wgpu::RenderPass<'a> {
    let store = wgpu::StoreOp::Store;
    let depth_ops = clear.map(|depth| wgpu::Operations { load: wgpu::LoadOp::Clear(depth), store });
    let stencil_ops = has_stencil.then_some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops }),
        ..Default::default()
    })
}

/// The median of each column of interleaved rounds.
pub(crate) fn medians<const N: usize>(rounds: &[[f64; N]]) -> [f64; N] {
    std::array::from_fn(|column| {
        let mut values: Vec<f64> = rounds.iter().map(|round| round[column]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    })
}
