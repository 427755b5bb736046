//! The volumes of one depth map.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::contours::Contours;
use super::edges::{BoundEdges, Detector, EdgeStages, threshold_bits};
use super::errors::{DepthMapEncodeError, DepthMapVolumesError};
use super::frame::DepthMapFrame;
use super::jitter::{jitters, reach};
use super::options::{DanglingEdges, DepthEdges, DepthMap, DepthMapOptions};
use super::pipelines::{DepthMapPipelines, layout, wall_group};
use super::texture::{MAP_FORMATS, check_objects, check_texture, object_texture};
use super::view::{Placing, depth_map_view, is_turned, world_step};
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP};
use crate::gpu::common::memory::{Allocation, any_error, buffer, check, filled, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, group};
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::layout::{DepthEdgeRule, DepthMapShape, DepthMapView};
use crate::shadow::DepthDirection;
use crate::stages::DEPTH_CELLS;

/// The largest number of cells: entries have as many bits for it.
const MOST_CELLS: u64 = 1 << 29;

/// Cells of a row that one word tells about.
const WORD_CELLS: u64 = 8;

/// Samples of the lattice across, and down.
pub(super) fn lattice([width, height]: [u32; 2], faces: u32) -> [u32; 2] {
    if faces > 1 { [3 * width, 2 * height] } else { [width + 2, height + 2] }
}

/// Shadow volumes of what has no mesh: of anything that a light sees, from the depth map of the light. It
/// finds the edges of the map, and draws the boundary between light and shadow into one bit of the caller's stencil. It reads nothing back.
///
/// NUMERICS.md, "Volumes from depth maps", has the method and its source.
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
    shared: Pipelines,
    /// Count, places, list. With `edges`, its last stage counts. Empty if there are contours.
    stages: Vec<Pipeline>,
    edges: Option<EdgeStages>,
    contours: Option<Contours>,
    shape: DepthMapShape,
    slope_bias: f32,
    bits: u32,
    /// A threshold in world units.
    world: Option<f32>,
    rounded_to: Option<wgpu::TextureFormat>,
    eye: (wgpu::TextureFormat, DepthDirection),
    /// Bound where there are no objects.
    nothing: wgpu::TextureView,
    places: wgpu::Buffer,
    cells: wgpu::Buffer,
    draws: wgpu::Buffer,
    encodes: Arc<AtomicU64>,
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
        pipelines.shared().construct(Subject::DepthMap, || Self::with(pipelines, size, 1, options))
    }

    /// Makes buffers for a map, or for the six of a cube.
    pub(super) fn with(
        pipelines: &DepthMapPipelines,
        size: [u32; 2],
        faces: u32,
        options: DepthMapOptions,
    ) -> Result<Self, DepthMapVolumesError> {
        let shared = pipelines.shared();
        let DepthMapOptions { edges, objects, dangling, capacity, slope_bias, rounded_to, bits, memory_limit, .. } =
            options;
        // A cube has no border.
        let cells_of = |side: u32| if faces > 1 { u64::from(side).saturating_sub(1) } else { u64::from(side) + 1 };
        let count = size.map(cells_of).into_iter().fold(u64::from(faces), u64::saturating_mul);
        if size.contains(&0) || count > MOST_CELLS {
            return Err(DepthMapVolumesError::Size(size[0], size[1]));
        }
        let (every_cell, threshold) = match edges {
            DepthEdges::Differences { threshold } => (0, threshold),
            // No difference is larger.
            DepthEdges::Outlines => (0, 1.0),
            // Each encode has its own.
            DepthEdges::WorldDifferences { .. } => (0, 0.0),
            // With marks, a list that overflows is that of every cell.
            DepthEdges::EveryCell | DepthEdges::SecondDifferences { .. } | DepthEdges::Automatic => (1, 0.0),
        };
        if let DepthEdges::SecondDifferences { low, high } = edges
            && !(0.0 <= low && low <= high && high <= 1.0)
        {
            return Err(DepthMapVolumesError::SecondThresholds { low, high });
        }
        if let Some(DanglingEdges { share, cells }) = dangling
            && !((0.0..=1.0).contains(&share) && (1..=64).contains(&cells))
        {
            return Err(DepthMapVolumesError::Dangling { share, cells });
        }
        if !(0.0..=1.0).contains(&threshold) {
            return Err(DepthMapVolumesError::Threshold(threshold));
        }
        let world = match edges {
            DepthEdges::WorldDifferences { threshold } if !(threshold.is_finite() && threshold >= 0.0) => {
                return Err(DepthMapVolumesError::WorldThreshold(threshold));
            }
            DepthEdges::WorldDifferences { threshold } => Some(threshold),
            _ => None,
        };
        if !(slope_bias.is_finite() && slope_bias >= 0.0) {
            return Err(DepthMapVolumesError::Bias(slope_bias));
        }
        if !(1..=8).contains(&bits) {
            return Err(DepthMapVolumesError::Bits(bits));
        }
        if let Some(format) = rounded_to
            && !MAP_FORMATS.contains(&format)
        {
            return Err(DepthMapVolumesError::RoundedTo(format));
        }
        let contours = Contours::new(pipelines, size, &options)?;
        let limits = DispatchLimits::new(&shared.device().limits());
        let cells = count as u32;
        let fitting = (limits.binding / 4 - 1).min(u64::from(u32::MAX)) as u32;
        // The words of cells that follow each other in a row.
        let [across, down] = size.map(cells_of);
        let words = across.div_ceil(WORD_CELLS) * down * u64::from(faces);
        let blocks = words.div_ceil(u64::from(WORKGROUP)) as u32;
        let detector = Detector::new(&options, faces, size);
        let shape = DepthMapShape {
            size,
            cells,
            blocks,
            capacity: contours
                .as_ref()
                .map_or(capacity.unwrap_or(cells).min(cells).min(fitting), |own| own.shape.capacity),
            every_cell: if detector.is_some() { 1 } else { every_cell },
            threshold: threshold_bits(threshold),
            is_reversed: 0,
            faces,
            objects: u32::from(objects),
            ratio: 0,
            at_infinity: 0,
            spread: u32::from(bits > 1),
            unused: 0,
        };
        // Contours have lists of their own.
        let (listed, blocks) = if contours.is_some() { (0, 0) } else { (shape.capacity, blocks) };
        let allocations = [
            Allocation {
                label: "places of depth cells",
                bytes: 4 * (u64::from(blocks) * u64::from(1 + WORKGROUP)).max(1),
            },
            Allocation { label: "depth cells", bytes: 4 + 4 * u64::from(listed) },
            Allocation { label: "draws of depth cells", bytes: 16 },
        ];
        check(&allocations[..1], limits.binding, None)?;
        let further = detector.map(|detector| detector.allocations());
        check(further.as_ref().map_or(&[], |further| &further[..]), limits.binding, None)?;
        let all: Vec<_> = allocations.iter().chain(further.iter().flatten()).copied().collect();
        check(&all, limits.buffer, memory_limit)?;
        let bytes = allocations.iter().map(|allocation| allocation.bytes).sum();
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let usages = [storage, storage, storage | wgpu::BufferUsages::INDIRECT];
        let [places, cells, draws] = guarded(shared.device(), bytes, || {
            [0, 1, 2].map(|at| buffer(shared.device(), allocations[at].label, allocations[at].bytes, usages[at]))
        })?;
        let nothing = object_texture(shared.device()).create_view(&wgpu::TextureViewDescriptor::default());
        let constants = [("DECIDES", world.is_some()), ("OBJECTS", objects), ("SPREADS", bits > 1)]
            .map(|(name, is_set)| (name, f64::from(u8::from(is_set))));
        let edges = detector.map(|detector| EdgeStages::new(shared, detector, objects)).transpose()?;
        let entry_points = ["depth_cells_count", "depth_cells_places", "depth_cells_list"];
        let of_cells = entry_points.iter().filter(|_| contours.is_none());
        Ok(Self {
            stages: of_cells.map(|entry_point| shared.compute(&DEPTH_CELLS, entry_point, &constants)).collect(),
            edges,
            contours,
            shape,
            slope_bias,
            bits,
            world,
            rounded_to,
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
            return Err(DepthMapEncodeError::NoObjects);
        }
        self.encode_map(encoder, map, None, camera, timer)
    }

    /// As [`Self::encode`], with [`DepthMapOptions::objects`]: `objects` has the number of an object for each texel of the map. It is a view of one layer and
    /// level of a texture of `R32Uint` with usage `TEXTURE_BINDING`, which has the map's size. Numbers where the map is far do not matter.
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
        check_objects(objects.texture(), self.shape.size)?;
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
        let format = check_texture(map.texture.texture(), self.shape.size)?;
        let view = |jitter| self.view(&map.light, &[format], camera, 1.0, jitter).map(|view| vec![view]);
        let views = jitters(self.bits).into_iter().map(view).collect::<Result<Vec<_>, _>>()?;
        self.record(encoder, [Some(map.texture), objects], ([&map.light, camera], &[format]), &views, timer)
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
        depth_map_view((light, self.shape.size, &mut { formats }), (camera, self.eye.0), &placing)
    }

    /// Records the stages for a texture and, for each bit, the views of its maps.
    pub(super) fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        [texture, objects]: [Option<&wgpu::TextureView>; 2],
        ([light, eye], formats): ([&ShadowCamera; 2], &[wgpu::TextureFormat]),
        views: &[Vec<DepthMapView>],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        let device = self.shared.device();
        check_alive(device)?;
        let is_reversed = u32::from(light.depth == DepthDirection::Reversed);
        let mut shape = DepthMapShape { is_reversed, ..self.shape };
        let mut formats = formats.iter().copied().chain(self.rounded_to);
        let rule = self.edges.as_ref().map(|edges| edges.rule(light, &mut formats)).transpose()?;
        if let Some((_, at_infinity)) = rule {
            shape.at_infinity = at_infinity;
        } else if let Some(threshold) = self.world {
            [shape.threshold, shape.ratio, shape.at_infinity] = world_step(light, threshold)?;
        }
        let refused = |message| DepthMapEncodeError::Refused { message };
        let bound =
            any_error(device, || self.bind([texture, objects], &shape, rule.map(|rule| rule.0).as_ref(), views))
                .map_err(refused)?;
        let mut own = 0;
        if let (Some(edges), Some(bound)) = (&self.edges, &bound.edges) {
            let most = device.limits().max_compute_workgroups_per_dimension;
            edges.record(encoder, bound, most, timer.as_deref_mut());
            own = 1;
        }
        for (stage, group, [x, y]) in bound.stages.iter().skip(own) {
            let timestamp_writes = timer.as_deref_mut().and_then(|timer| timer.compute_pass(stage.label));
            let label = Some(stage.label);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
            pass.set_pipeline(&stage.compute);
            // Each uniform begins at its buffer's start.
            let offsets = if self.contours.is_some() { &[0, 0][..] } else { &[0] };
            pass.set_bind_group(0, group, offsets);
            pass.dispatch_workgroups(*x, *y, 1);
        }
        Ok(DepthMapFrame {
            device: device.clone(),
            groups: bound.draws,
            has_walls: self.contours.is_some(),
            draws: self.contours.as_ref().map_or(&self.draws, |own| &own.draws).clone(),
            depth: self.eye.1,
            is_turned: is_turned(light, eye),
            encode: self.encodes.fetch_add(1, Ordering::Relaxed) + 1,
            encodes: Arc::clone(&self.encodes),
        })
    }

    /// The listed cells, on the GPU: their number, then an entry for each, in their order. An entry has the number of its cell
    /// in 29 bits. Bit 29 tells that the cell is split from its sample (1, 0) to (0, 1), and bits 30 and 31 which of its two triangles are drawn.
    /// With a number larger than the capacity the entries are not complete, and every cell was drawn.
    ///
    /// With [`DepthMapReconstruction::Contours`](crate::gpu::DepthMapReconstruction::Contours), the quadrilaterals: their number, three times 0, then twelve words for each. They are four
    /// vertices of three words: its place across and down the lattice, whose sample (1, 1) is texel (0, 0), in parts of 256 of a texel, and its distance from the near plane, in
    /// units of 2⁻²⁹ of the range of depths, or 2³¹ − 1 where it is far.
    pub fn cells(&self) -> &wgpu::Buffer {
        self.contours.as_ref().map_or(&self.cells, |own| &own.walls)
    }

    /// Binds the stages and the draws of an encode. Their uniforms are their own, so encodes may follow each other.
    fn bind(
        &self,
        textures: [Option<&wgpu::TextureView>; 2],
        shape: &DepthMapShape,
        rule: Option<&DepthEdgeRule>,
        views: &[Vec<DepthMapView>],
    ) -> Bound<'_> {
        let device = self.shared.device();
        let uniform = filled(device, "depth map", bytemuck::bytes_of(shape), wgpu::BufferUsages::UNIFORM);
        let [texture, objects] =
            textures.map(|texture| wgpu::BindingResource::TextureView(texture.unwrap_or(&self.nothing)));
        let edges = self.edges.as_ref().zip(rule).map(|(edges, rule)| {
            let textures = [texture.clone(), objects.clone()];
            edges.bind(&self.shared, (shape, &uniform), rule, &textures, &self.places)
        });
        let most = device.limits().max_compute_workgroups_per_dimension;
        let rows = shape.blocks.div_ceil(most).min(most);
        let every = [shape.blocks.div_ceil(rows).min(most), rows];
        if let (Some(contours), Some([view, ..])) = (&self.contours, views.first().map(Vec::as_slice)) {
            let contour = contours.uniform(&self.shared, view);
            let stages = contours.bind(device, &uniform, &contour, [texture.clone(), objects.clone()]);
            let view = filled(device, "depth map view", bytemuck::bytes_of(view), wgpu::BufferUsages::STORAGE);
            let resources = [
                (0, uniform.as_entire_binding()),
                (1, texture),
                (2, contours.walls.as_entire_binding()),
                (3, view.as_entire_binding()),
                (4, objects),
            ];
            let entries: Vec<_> = resources.into_iter().chain(contours.of_draws(&contour)).collect();
            return Bound { edges: None, stages, draws: vec![wall_group(&self.shared, entries)] };
        }
        let mut counts = [every, [1, 1], every].into_iter();
        let stages = self.stages.iter().map(|stage| {
            let group = stage.bind(
                device,
                &[
                    ("depth_map", entry::<DepthMapShape>(&uniform)),
                    ("depth_texture", texture.clone()),
                    ("object_texture", objects.clone()),
                    ("places", self.places.as_entire_binding()),
                    ("cells", self.cells.as_entire_binding()),
                    ("draws", self.draws.as_entire_binding()),
                ],
            );
            (stage, group, counts.next().unwrap_or(every))
        });
        let draw = |views: &Vec<DepthMapView>| {
            let view = filled(device, "depth map view", bytemuck::cast_slice(views), wgpu::BufferUsages::STORAGE);
            let resources = [
                uniform.as_entire_binding(),
                texture.clone(),
                self.cells.as_entire_binding(),
                view.as_entire_binding(),
                objects.clone(),
            ];
            group(device, "depth surface", &layout(&self.shared), &resources)
        };
        Bound { edges, stages: stages.collect(), draws: views.iter().map(draw).collect() }
    }
}

/// The bind groups of an encode, and the workgroups of each stage.
struct Bound<'a> {
    edges: Option<BoundEdges>,
    stages: Vec<(&'a Pipeline, wgpu::BindGroup, [u32; 2])>,
    /// For each bit.
    draws: Vec<wgpu::BindGroup>,
}
