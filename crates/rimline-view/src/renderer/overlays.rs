//! Edges over the picture: silhouettes, volumes, boundaries. They have extractions of their own.

use rimline::gpu::{
    Extraction, Extractor, ExtractorOptions, ListOptions, Outline, OutlineInputs, OutlineSource, OutlineStyle,
};
use rimline::internals::facing::undecided_faces;
use rimline::{Light, Mesh, ShadowCamera};
use rimline_picture::{Resources, VolumeOverlay, filled};

use super::canvas::Canvas;
use super::error::RenderError;
use super::gpu::{Gpu, granted};
use super::models::Models;
use super::pipelines::Pipelines;
use crate::state::body::{Body, bits_of_clusters, bits_of_faces, non_manifold_bits};
use crate::state::lamp::MAX_LAMPS;
use crate::state::viewer::Viewer;

/// Extractors of all models, for the lights and the eye.
pub(super) struct Overlays {
    generation: u64,
    bodies: Vec<Extracted>,
    /// Results of the last encode.
    extractions: Vec<Extraction>,
}

/// A model's extractor, and bits of its edges that are marked.
struct Extracted {
    extractor: Extractor,
    mesh: Mesh,
    non_manifold: wgpu::Buffer,
    exact: wgpu::Buffer,
    /// Made for the pose in which they were switched on. `None` while they are off.
    clusters: Option<wgpu::Buffer>,
}

const BOUNDARY: [f32; 4] = [0.86, 0.12, 0.10, 1.0];
const NON_MANIFOLD: [f32; 4] = [0.72, 0.10, 0.78, 1.0];
const EXACT: [f32; 4] = [0.95, 0.45, 0.05, 1.0];
const CLUSTERS: [f32; 4] = [0.05, 0.35, 0.65, 1.0];
const CREASE: [f32; 4] = [0.12, 0.13, 0.16, 0.75];
const SILHOUETTE: [f32; 4] = [0.04, 0.05, 0.07, 1.0];

impl Overlays {
    pub(super) fn new(gpu: &Gpu, viewer: &Viewer) -> Result<Self, RenderError> {
        // Where soft lines join, their order decides the last bits of the picture.
        let lists = Some(ListOptions { ordered: true, ..ListOptions::default() });
        let options = ExtractorOptions { max_lights: MAX_LAMPS + 1, lists, ..ExtractorOptions::default() };
        let mut bodies = Vec::with_capacity(viewer.bodies.len());
        for body in &viewer.bodies {
            let failed = |error: &dyn ToString| RenderError::overlays(&body.name, error);
            let pose = body.pose(viewer.clock.seconds).map_err(|error| failed(&error))?;
            let mesh = body.model().mesh(&pose).map_err(|error| failed(&error))?;
            let extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(|error| failed(&error))?;
            let bits = non_manifold_bits(&mesh);
            let marked = |label| filled(gpu.on(), label, bytemuck::cast_slice(&bits), wgpu::BufferUsages::STORAGE);
            let made = granted(&gpu.device, || ["non-manifold", "exact"].map(marked));
            let [non_manifold, exact] = made.map_err(|why| failed(&why))?;
            bodies.push(Extracted { extractor, mesh, non_manifold, exact, clusters: None });
        }
        Ok(Self { generation: viewer.generation(), bodies, extractions: Vec::new() })
    }

    pub(super) fn is_of(&self, viewer: &Viewer) -> bool {
        self.generation == viewer.generation() && self.bodies.len() == viewer.bodies.len()
    }

    /// Extracts from positions that were encoded before: for the first sample of each light that is on, then for the eye.
    pub(super) fn encode(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        models: &Models,
        viewer: &Viewer,
        camera: &ShadowCamera,
    ) -> Result<(), RenderError> {
        let mut sources = viewer.sources();
        sources.dedup_by_key(|(number, _)| *number);
        let lights = sources.iter().map(|(_, source)| source.light());
        let lights: Vec<Light> = lights.chain([Light::point(camera.origin)]).collect();
        self.extractions.clear();
        for (index, (extracted, body)) in self.bodies.iter_mut().zip(&viewer.bodies).enumerate() {
            let extraction = extracted.extractor.encode(encoder, models.positions(index)?, &lights);
            self.extractions.push(extraction.map_err(|error| RenderError::overlays(&body.name, &error))?);
            extracted.mark(gpu, viewer, body, &lights[..lights.len() - 1])?;
        }
        Ok(())
    }

    /// Draws the volumes of a light. `numbers`: that of its first sample, and its own.
    pub(super) fn draw_volumes(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        volumes: &VolumeOverlay,
        resources: &Resources,
        numbers: [usize; 2],
    ) -> Result<(), RenderError> {
        for extraction in &self.extractions {
            volumes.draw(pass, resources, extraction, numbers)?;
        }
        Ok(())
    }

    /// The lines that are drawn over a picture, those of the eye last.
    pub(super) fn outlines(
        &self,
        pipelines: &Pipelines,
        canvas: &Canvas,
        viewer: &Viewer,
        camera: &ShadowCamera,
    ) -> Result<Vec<Outline>, RenderError> {
        let shown = viewer.options.overlays;
        let lamps: Vec<_> = viewer.lamps.iter().filter(|lamp| lamp.is_on).collect();
        // Two pixels at 800 rows.
        let width = (canvas.size[1] as f32 / 400.0).clamp(1.5, 12.0);
        let silhouette = shown.silhouettes.then_some(SILHOUETTE);
        let boundary = if shown.boundary { Some(BOUNDARY) } else { silhouette };
        let eye = OutlineStyle {
            width,
            silhouette,
            boundary,
            crease: shown.creases.then_some(CREASE),
            marked: shown.non_manifold.then_some(NON_MANIFOLD),
            ..OutlineStyle::default()
        };
        let mut outlines = Vec::new();
        for ((extraction, extracted), body) in self.extractions.iter().zip(&self.bodies).zip(&viewer.bodies) {
            let prepare = |number, style, marked| {
                let of = OutlineSource::Extraction(extraction, number);
                let depth = &canvas.depth;
                let outline = pipelines.outlines.prepare(&OutlineInputs { of, camera, depth, style, marked });
                outline.map_err(|error| RenderError::overlays(&body.name, &error))
            };
            for (number, lamp) in lamps.iter().enumerate().filter(|_| shown.light_silhouettes) {
                let [r, g, b] = lamp.shown_color();
                let color = Some([r, g, b, 1.0]);
                let style = OutlineStyle { width, silhouette: color, boundary: color, ..OutlineStyle::default() };
                outlines.push(prepare(number, style, None)?);
            }
            let is_shown = [eye.silhouette, eye.boundary, eye.crease, eye.marked].iter().any(Option::is_some);
            if is_shown {
                outlines.push(prepare(lamps.len(), eye, eye.marked.map(|_| &extracted.non_manifold))?);
            }
            let exact = Some(&extracted.exact).filter(|_| shown.exact);
            let clusters = extracted.clusters.as_ref().filter(|_| shown.clusters);
            for (color, marked) in [(EXACT, exact), (CLUSTERS, clusters)] {
                let only = OutlineStyle { silhouette: None, boundary: None, ..OutlineStyle::default() };
                if marked.is_some() {
                    let style = OutlineStyle { width, marked: Some(color), ..only };
                    outlines.push(prepare(lamps.len(), style, marked)?);
                }
            }
        }
        Ok(outlines)
    }
}

impl Extracted {
    /// Finds the edges of faces that `lights` leave to exact arithmetic, and those between clusters, where they are shown.
    fn mark(&mut self, gpu: &Gpu, viewer: &Viewer, body: &Body, lights: &[Light]) -> Result<(), RenderError> {
        let shown = viewer.options.overlays;
        if !shown.clusters {
            self.clusters = None;
        }
        let needs_clusters = shown.clusters && self.clusters.is_none();
        if !shown.exact && !needs_clusters {
            return Ok(());
        }
        let failed = |error: &dyn ToString| RenderError::overlays(&body.name, error);
        let positions = body.positions(viewer.clock.seconds).map_err(|error| failed(&error))?;
        if shown.exact {
            let faces = undecided_faces(&positions, self.mesh.faces(), lights);
            gpu.queue.write_buffer(&self.exact, 0, bytemuck::cast_slice(&bits_of_faces(&self.mesh, &faces)));
        }
        if needs_clusters {
            let bits = bits_of_clusters(&self.mesh, &positions);
            let usage = wgpu::BufferUsages::STORAGE;
            let made = granted(&gpu.device, || filled(gpu.on(), "clusters", bytemuck::cast_slice(&bits), usage));
            self.clusters = Some(made.map_err(|why| failed(&why))?);
        }
        Ok(())
    }
}
