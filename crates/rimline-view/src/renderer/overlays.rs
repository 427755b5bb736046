//! Edges over the picture: silhouettes, volumes, boundaries. They have extractions of their own.

use rimline::gpu::{Extraction, Extractor, ExtractorOptions, Outline, OutlineInputs, OutlineSource, OutlineStyle};
use rimline::internals::facing::undecided_faces;
use rimline::{Light, Mesh, ShadowCamera};
use rimline_picture::{Resources, VolumeOverlay, filled};

use super::canvas::Canvas;
use super::error::RenderError;
use super::gpu::{Gpu, granted};
use super::models::Models;
use super::pipelines::Pipelines;
use crate::state::body::{bits_of_faces, non_manifold_bits};
use crate::state::viewer::{MAX_LAMPS, Viewer};

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
}

const BOUNDARY: [f32; 4] = [0.86, 0.12, 0.10, 1.0];
const NON_MANIFOLD: [f32; 4] = [0.72, 0.10, 0.78, 1.0];
const EXACT: [f32; 4] = [0.95, 0.45, 0.05, 1.0];
const CREASE: [f32; 4] = [0.12, 0.13, 0.16, 0.75];
const SILHOUETTE: [f32; 4] = [0.04, 0.05, 0.07, 1.0];

impl Overlays {
    pub(super) fn new(gpu: &Gpu, viewer: &Viewer) -> Result<Self, RenderError> {
        let options = ExtractorOptions { max_lights: MAX_LAMPS + 1, ..ExtractorOptions::default() };
        let mut bodies = Vec::with_capacity(viewer.bodies.len());
        for (index, body) in viewer.bodies.iter().enumerate() {
            let failed = |error: &dyn ToString| RenderError::body(index, &body.name, error);
            let pose = body.pose(viewer.clock.seconds).map_err(|error| failed(&error))?;
            let mesh = body.model().mesh(&pose).map_err(|error| failed(&error))?;
            let extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(|error| failed(&error))?;
            let bits = non_manifold_bits(&mesh);
            let marked = |label| filled(gpu.on(), label, bytemuck::cast_slice(&bits), wgpu::BufferUsages::STORAGE);
            let made = granted(&gpu.device, || ["non-manifold", "exact"].map(marked));
            let [non_manifold, exact] = made.map_err(|why| failed(&why))?;
            bodies.push(Extracted { extractor, mesh, non_manifold, exact });
        }
        Ok(Self { generation: viewer.generation(), bodies, extractions: Vec::new() })
    }

    pub(super) fn is_of(&self, viewer: &Viewer) -> bool {
        self.generation == viewer.generation()
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
        for (index, Extracted { extractor, mesh, exact, .. }) in self.bodies.iter_mut().enumerate() {
            self.extractions.push(extractor.encode(encoder, models.positions(index)?, &lights)?);
            if viewer.options.overlays.exact {
                let body = &viewer.bodies[index];
                let positions = body.positions(viewer.clock.seconds);
                let positions = positions.map_err(|error| RenderError::body(index, &body.name, &error))?;
                let faces = undecided_faces(&positions, mesh.faces(), &lights[..lights.len() - 1]);
                gpu.queue.write_buffer(exact, 0, bytemuck::cast_slice(&bits_of_faces(mesh, &faces)));
            }
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
        for (extraction, body) in self.extractions.iter().zip(&self.bodies) {
            let prepare = |number, style, marked| {
                let of = OutlineSource::Extraction(extraction, number);
                let depth = &canvas.depth;
                pipelines.outlines.prepare(&OutlineInputs { of, camera, depth, style, marked })
            };
            for (number, lamp) in lamps.iter().enumerate().filter(|_| shown.light_silhouettes) {
                let brightest = lamp.color.iter().copied().fold(1e-6, f32::max);
                let [r, g, b] = lamp.color.map(|c| (c / brightest).powf(1.0 / 2.2));
                let color = Some([r, g, b, 1.0]);
                let style = OutlineStyle { width, silhouette: color, boundary: color, ..OutlineStyle::default() };
                outlines.push(prepare(number, style, None)?);
            }
            let is_shown = [eye.silhouette, eye.boundary, eye.crease, eye.marked].iter().any(Option::is_some);
            if is_shown {
                outlines.push(prepare(lamps.len(), eye, eye.marked.map(|_| &body.non_manifold))?);
            }
            if shown.exact {
                let style = OutlineStyle {
                    width,
                    silhouette: None,
                    boundary: None,
                    marked: Some(EXACT),
                    ..OutlineStyle::default()
                };
                outlines.push(prepare(lamps.len(), style, Some(&body.exact))?);
            }
        }
        Ok(outlines)
    }
}
