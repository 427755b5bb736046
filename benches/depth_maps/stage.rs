//! Parts that all measurements share: the device, cameras, maps, passes, and times of commands.

use glam::{DMat4, DVec3, DVec4};
use rimline::gpu::depth_map::{
    DepthMap, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, MeshDepth,
};
use rimline::gpu::{PositionBuffer, ShadowFormat};
use rimline::{DepthDirection, ShadowCamera};
use rimline_bench::Error;
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::shapes::Shape;
use wgpu::TextureFormat;

/// 24 bits, as in the paper.
pub(crate) const MAP: TextureFormat = TextureFormat::Depth24Plus;
pub(crate) const EYE: TextureFormat = TextureFormat::Depth24PlusStencil8;

pub(crate) const AUTOMATIC: DepthMapMethod = DepthMapMethod::Automatic { dangling: None };
pub(crate) const CONTOURS: DepthMapMethod = DepthMapMethod::Contours { threshold: 0.005, sideways: 0.1, depth: 0.02 };

/// A near plane as in games, where units are metres.
const NEAR: f64 = 0.1;

/// A camera that looks from `distance` along `axes[2]` to the origin, and sees a ball of `radius` there. Lights have
/// standard depth from before the ball to behind it, eyes reversed depth from [`NEAR`] on.
pub(crate) fn camera([right, up, forward]: [DVec3; 3], distance: f64, radius: f64, is_light: bool) -> ShadowCamera {
    let eye = -distance * forward;
    let scale = (distance * distance - radius * radius).sqrt() / radius;
    let row = |axis: DVec3| axis.extend(-axis.dot(eye));
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
    /// The adapter's.
    pub(crate) name: String,
    /// Into an attachment without color.
    pub(crate) pipelines: DepthMapPipelines,
}

/// Positions of a mesh on the GPU, and what draws its depth into maps and for the eye.
pub(crate) struct Drawn {
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
    pub(crate) fn new() -> Result<Self, Error> {
        let (gpu, name) = Gpu::first()?;
        let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 0)?;
        Ok(Self { gpu, name, pipelines })
    }

    pub(crate) fn drawn(&self, shape: &Shape) -> Result<Drawn, Error> {
        let mesh = shape.mesh()?;
        let depth = |format, depth| MeshDepth::new(&self.gpu.pipelines, &mesh, format, depth);
        Ok(Drawn {
            into_map: depth(MAP, DepthDirection::Standard)?,
            for_eye: depth(EYE, DepthDirection::Reversed)?,
            positions: self.gpu.buffer(wgpu::BufferUsages::STORAGE, &shape.positions),
        })
    }

    pub(crate) fn target(&self, side: u32, format: TextureFormat) -> Target {
        let texture = self.gpu.texture(side, format);
        let aspect = wgpu::TextureAspect::DepthOnly;
        Target {
            depths: texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() }),
            all: texture.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    pub(crate) fn volumes(&self, side: u32, method: DepthMapMethod) -> Result<DepthMapVolumes, Error> {
        let options = DepthMapOptions { method, ..Default::default() };
        Ok(DepthMapVolumes::new(&self.pipelines, [side; 2], options)?)
    }

    /// Draws the depth of a mesh into a map.
    pub(crate) fn draw_map(
        encoder: &mut wgpu::CommandEncoder,
        drawn: &Drawn,
        map: &Target,
        light: &ShadowCamera,
    ) -> Result<(), Error> {
        let mut pass = pass(encoder, &map.all, Some(1.0), false);
        Ok(drawn.into_map.draw(&mut pass, drawn.positions(), light)?)
    }

    /// Draws what the eye sees.
    pub(crate) fn draw_eye(
        encoder: &mut wgpu::CommandEncoder,
        drawn: &[&Drawn],
        target: &Target,
        eye: &ShadowCamera,
    ) -> Result<(), Error> {
        let mut pass = pass(encoder, &target.all, Some(0.0), true);
        drawn.iter().try_for_each(|drawn| Ok(drawn.for_eye.draw(&mut pass, drawn.positions(), eye)?))
    }

    /// Milliseconds that commands take, from their submission on.
    pub(crate) fn clock(
        &self,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), Error>,
    ) -> Result<f64, Error> {
        Ok(Stopwatch::new(&self.gpu).by_clock(record)?[1])
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
