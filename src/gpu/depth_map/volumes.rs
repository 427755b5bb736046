//! The volumes of one depth map.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use super::contours::{ContourPlan, Contours};
use super::edges::{Detector, EdgeStages, threshold_bits};
use super::frame::DepthMapFrame;
use super::frame_errors::{DepthMapEncodeError, DepthMapTexture};
use super::jitter::{jitters, reach};
use super::metric::{DepthMetric, metric_steps};
use super::options::{DepthEdges, DepthMap, DepthMapOptions, DepthMapReconstruction};
use super::pipelines::DepthMapPipelines;
use super::texture::{check_objects, check_texture, object_texture};
use super::view::{Placing, depth_map_view};
use super::volumes_errors::DepthMapVolumesError;
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, buffer, check, check_bindings, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::requirements::{Subject, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::layout::{DepthMapShape, DepthMapView};
use crate::shadow::DepthDirection;
use crate::stages::{DEPTH_CELLS, DEPTH_NEAR, DEPTH_NEAR_WALLS};

/// The largest number of cells: entries have as many bits for it.
pub(super) const MOST_CELLS: u64 = 1 << 29;

/// Cells of a strip across and down. Each of its rows has a word.
const STRIP: [u64; 2] = [8, 4];
/// Strips of a block.
const BLOCK: u64 = 64;

/// Shadow volumes of what has no mesh: of anything that a light sees, from the depth map of the light. It
/// finds the edges of the map, and draws the boundary between light and shadow into one bit of the caller's stencil. It reads
/// nothing back.
///
/// docs/numerics/depth-maps.md has the method and its source.
///
/// Shadows are as precise as the map: a border can be off by the shadow of one texel. Outside the map nothing casts.
///
/// ```no_run
/// use rimline::gpu::{DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, ShadowFormat};
/// use rimline::{ShadowCamera, wgpu};
///
/// # fn shadows(
/// #     device: &wgpu::Device,
/// #     encoder: &mut wgpu::CommandEncoder,
/// #     (depth, light): (&wgpu::TextureView, ShadowCamera),
/// #     camera: &ShadowCamera,
/// #     depth_stencil: &wgpu::TextureView,
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// // Once, with the format of your depth-stencil attachment, and a bit of the stencil:
/// let pipelines = DepthMapPipelines::new(device, &ShadowFormat { depth: camera.depth, ..Default::default() }, 0)?;
/// // Once for each size of map:
/// let mut volumes = DepthMapVolumes::new(&pipelines, [512, 512], DepthMapOptions::default())?;
/// // Every frame, after what draws the map:
/// let shadows = volumes.encode(encoder, &DepthMap { texture: depth, light }, camera, None)?;
/// // After your depth pass. Where bit 0 is still 0, there is light:
/// let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
///     label: Some("light"),
///     depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
///         view: depth_stencil,
///         depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
///         stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
///     }),
///     ..Default::default()
/// });
/// shadows.draw(&mut pass, &pipelines)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct DepthMapVolumes {
    pub(super) shared: Pipelines,
    /// Count, places, list. With `edges`, its last stage counts, and these are the other two. Empty if there are contours.
    pub(super) stages: Vec<Pipeline>,
    pub(super) edges: Option<EdgeStages>,
    pub(super) contours: Option<Contours>,
    /// Tells whether near caps are drawn. `None`: they always are.
    pub(super) near: Option<Pipeline>,
    pub(super) shape: DepthMapShape,
    /// A threshold in world units, of which cells are decided without marks.
    pub(super) world: Option<f32>,
    pub(super) slope_bias: f32,
    pub(super) bits: u32,
    pub(super) rounded_to: Option<wgpu::TextureFormat>,
    metric: DepthMetric,
    pub(super) eye: (wgpu::TextureFormat, DepthDirection),
    /// Bound where there are no objects.
    pub(super) nothing: wgpu::TextureView,
    pub(super) places: wgpu::Buffer,
    pub(super) cells: wgpu::Buffer,
    pub(super) draws: wgpu::Buffer,
    pub(super) encodes: Arc<AtomicU64>,
}

/// Whether every cell is marked, and the threshold, where cells are decided without marks of edges.
fn rule(edges: DepthEdges) -> (u32, f32) {
    match edges {
        DepthEdges::Differences { threshold } => (0, threshold),
        // No difference is larger.
        DepthEdges::Outlines => (0, 1.0),
        // With marks, or steps in world units, a list that overflows is that of every cell.
        DepthEdges::EveryCell
        | DepthEdges::WorldDifferences { .. }
        | DepthEdges::SecondDifferences { .. }
        | DepthEdges::Automatic => (1, 0.0),
    }
}

/// Those of cells; without the first, where marks are counted by a stage of their own.
fn cell_stages(shared: &Pipelines, are_marked: bool, constants: [(&'static str, bool); 3]) -> Vec<Pipeline> {
    // Only the count has them, so that more of the others are shared.
    let of_count = constants.map(|(name, is_set)| (name, f64::from(u8::from(is_set))));
    let stages = [("depth_cells_count", &of_count[..]), ("depth_cells_places", &[]), ("depth_cells_list", &[])];
    let own = stages.into_iter().skip(usize::from(are_marked));
    own.map(|(entry_point, constants)| shared.compute(&DEPTH_CELLS, entry_point, constants)).collect()
}

impl DepthMapVolumes {
    /// Makes buffers for maps of `size` texels, on the device of `pipelines`.
    ///
    /// # Errors
    /// [`DepthMapVolumesError`] if the size or an option is refused, or the buffers do not fit the device.
    pub fn new(
        pipelines: &DepthMapPipelines,
        size: [u32; 2],
        options: DepthMapOptions,
    ) -> Result<Self, DepthMapVolumesError> {
        pipelines.shared().construct(Subject::DepthMap, || Self::with(pipelines, size, (1, &[]), options))
    }

    /// Makes buffers for a map, or for the six of a cube, whose textures are yet to be made.
    pub(super) fn with(
        pipelines: &DepthMapPipelines,
        size: [u32; 2],
        (faces, textures): (u32, &[Allocation]),
        options: DepthMapOptions,
    ) -> Result<Self, DepthMapVolumesError> {
        let shared = pipelines.shared();
        let DepthMapOptions {
            edges,
            objects,
            reconstruction,
            capacity,
            slope_bias,
            rounded_to,
            metric,
            bits,
            memory_limit,
            ..
        } = options;
        // A cube has no border.
        let cells_of = |side: u32| if faces > 1 { u64::from(side).saturating_sub(1) } else { u64::from(side) + 1 };
        let count = size.map(cells_of).into_iter().fold(u64::from(faces), u64::saturating_mul);
        if size.contains(&0) || count > MOST_CELLS {
            return Err(DepthMapVolumesError::Size(size[0], size[1]));
        }
        let (every_cell, threshold) = rule(edges);
        options.check()?;
        let contours = ContourPlan::new(pipelines, size, &options)?;
        let limits = DispatchLimits::new(&shared.device().limits());
        let cells = count as u32;
        let fitting = (limits.binding / 4 - 1).min(u64::from(u32::MAX)) as u32;
        let [across, down] = size.map(cells_of);
        let strips = across.div_ceil(STRIP[0]) * down.div_ceil(STRIP[1]) * u64::from(faces);
        let blocks = strips.div_ceil(BLOCK) as u32;
        let detector = Detector::new(&options, faces, size);
        let shape = DepthMapShape {
            size,
            cells,
            blocks,
            capacity: contours
                .as_ref()
                .map_or(capacity.unwrap_or(cells).min(cells).min(fitting), |plan| plan.shape.capacity),
            every_cell: if detector.is_some() { 1 } else { every_cell },
            threshold: threshold_bits(threshold),
            is_reversed: 0,
            faces,
            objects: u32::from(objects),
            spread: u32::from(bits > 1),
            whole_cells: u32::from(reconstruction == DepthMapReconstruction::FixedMesh),
            ratio: 0,
            at_infinity: 0,
        };
        let world = match edges {
            DepthEdges::WorldDifferences { threshold } if detector.is_none() => Some(threshold),
            _ => None,
        };
        // Contours have lists of their own.
        let (listed, blocks) = if contours.is_some() { (0, 0) } else { (shape.capacity, blocks) };
        let allocations = [
            Allocation {
                label: "places of depth cells",
                bytes: 4 * (u64::from(blocks) * (1 + BLOCK * (1 + STRIP[1]))).max(1),
            },
            Allocation { label: "depth cells", bytes: 4 + 4 * u64::from(listed) },
            Allocation { label: "draws of depth cells", bytes: 16 },
        ];
        let further = detector.map(|detector| detector.allocations());
        let of_contours = contours.as_ref().map_or(&[][..], |plan| &plan.allocations);
        let all: Vec<_> = allocations.iter().chain(further.iter().flatten()).chain(of_contours).copied().collect();
        check_bindings(&all, limits.binding)?;
        check(&all, limits.buffer, None)?;
        // Textures have limits of their own.
        check(&[&all[..], textures].concat(), u64::MAX, memory_limit)?;
        let contours = contours.map(|plan| Contours::new(pipelines, plan, options.objects)).transpose()?;
        let bytes = allocations.iter().map(|allocation| allocation.bytes).sum();
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let usages = [storage, storage, storage | wgpu::BufferUsages::INDIRECT];
        let [places, cells, draws] = guarded(shared.device(), bytes, || {
            [0, 1, 2].map(|at| buffer(shared.device(), allocations[at].label, allocations[at].bytes, usages[at]))
        })?;
        let nothing = object_texture(shared.device()).create_view(&wgpu::TextureViewDescriptor::default());
        let near =
            if contours.is_some() { (&DEPTH_NEAR_WALLS, "depth_near_walls") } else { (&DEPTH_NEAR, "depth_near") };
        let near = options.skip_near_caps.then(|| shared.compute(near.0, near.1, &[]));
        let edges = detector.map(|detector| EdgeStages::new(shared, detector, objects)).transpose()?;
        let constants = [("OBJECTS", objects), ("SPREADS", bits > 1), ("WORLD", world.is_some())];
        let stages = match &contours {
            Some(_) => Vec::new(),
            None => cell_stages(shared, edges.is_some(), constants),
        };
        Ok(Self {
            stages,
            edges,
            contours,
            near,
            shape,
            world,
            slope_bias,
            bits,
            rounded_to,
            metric,
            eye: (pipelines.format().depth_stencil, pipelines.format().depth),
            nothing,
            places,
            cells,
            draws,
            encodes: Arc::default(),
            shared: shared.clone(),
        })
    }

    /// Records the stages: finds the edges of `map`, for `camera`. `timer` takes the time of each stage. What was encoded
    /// before can no longer be drawn.
    ///
    /// # Errors
    /// [`DepthMapEncodeError`] if the texture or a camera is refused. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        if self.shape.objects == 1 {
            return Err(DepthMapEncodeError::NoObjects { face: None });
        }
        self.encode_map(encoder, map, None, camera, timer)
    }

    /// As [`Self::encode`], with [`DepthMapOptions::objects`]: `objects` has the number of an object for each texel of the map.
    /// It is a view of one layer of a texture of `R32Uint` with one mip level and usage `TEXTURE_BINDING`, which has the map's
    /// size. Numbers where the map is far do not matter.
    ///
    /// # Errors
    /// [`DepthMapEncodeError`] if a texture or a camera is refused. Nothing is recorded then.
    pub fn encode_objects(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        objects: &wgpu::TextureView,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        if self.shape.objects == 0 {
            return Err(DepthMapEncodeError::UnusedObjects);
        }
        check_objects(objects.texture(), self.shape.size, DepthMapTexture::Objects)?;
        self.encode_map(encoder, map, Some(objects), camera, timer)
    }

    fn encode_map(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        objects: Option<&wgpu::TextureView>,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        let device = self.shared.device();
        check_timer(timer.as_deref(), device)?;
        let format = check_texture(map.texture.texture(), self.shape.size, DepthMapTexture::Map)?;
        let view = |jitter| self.view(&map.light, &[format], camera, 1.0, jitter).map(|view| vec![view]);
        let views = jitters(self.bits).into_iter().map(view).collect::<Result<Vec<_>, _>>()?;
        self.record(encoder, [Some(map.texture), objects], ([&map.light, camera], &[format]), views, timer)
    }

    /// The view of a map for a camera, moved by parts of a texel.
    pub(super) fn view(
        &self,
        light: &ShadowCamera,
        formats: &[wgpu::TextureFormat],
        camera: &ShadowCamera,
        border: f64,
        jitter: [f64; 2],
    ) -> Result<DepthMapView, DepthMapEncodeError> {
        if camera.depth != self.eye.1 {
            return Err(DepthMapEncodeError::Depth { camera: camera.depth, pipelines: self.eye.1 });
        }
        let formats = formats.iter().copied().chain(self.rounded_to);
        let slope_bias = f64::from(self.slope_bias) * (0.5 + reach(self.bits));
        let placing = Placing { border, jitter, slope_bias };
        let off = metric_steps(light, self.metric)?;
        depth_map_view((light, self.shape.size), (off, &mut { formats }), (camera, self.eye.0), &placing)
    }

    /// Cells, or walls and flaps, that the list has room for. With a larger number at the begin of [`Self::cells`], every cell is
    /// drawn.
    pub fn capacity(&self) -> u32 {
        self.contours.as_ref().map_or(self.shape.capacity, |own| own.shape.capacity)
    }

    /// The listed cells, on the GPU: their number, then an entry for each. Strips of eight cells across and four down follow each
    /// other, and so do the rows of a strip. An entry has the number of its cell in 29 bits. Bit 29 tells that the cell is split
    /// from its sample (1, 0) to (0, 1), and bits 30 and 31 which of its two triangles are drawn. With a number larger than
    /// [`Self::capacity`] the entries are not complete, and every cell is drawn.
    ///
    /// With [`DepthMapReconstruction::Contours`](crate::gpu::DepthMapReconstruction::Contours), the quadrilaterals: their number,
    /// three times 0, then twelve words for each. They are four vertices of three words: its place across and down the lattice,
    /// whose sample (1, 1) is texel (0, 0), in parts of 256 of a texel, and its distance from the near plane, in units of 2⁻²⁹ of
    /// the range of depths, or 2³¹ − 1 where it is far.
    pub fn cells(&self) -> &wgpu::Buffer {
        self.contours.as_ref().map_or(&self.cells, |own| &own.walls)
    }
}
