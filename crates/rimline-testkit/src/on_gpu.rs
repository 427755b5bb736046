//! Extractions and deformations on the GPU, read back for tests to compare.

use rimline::gpu::{
    Deformer, Extractor, ExtractorOptions, PositionBuffer, SceneOptions, ShadowError, ShadowPipelines, View,
};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::{
    DrawArguments, EdgeMasks, ExtractionStatistics, ShadowDraws, ShadowLight, ShadowStatistics, ViewLight,
};
use rimline::{Light, Mesh, Model, Pose, ShadowCamera};

use crate::band::deform_bound;
use crate::choices;
use crate::device::Gpu;
use crate::same;
use crate::shapes::{self, Shape};
use crate::{OneCaster, OneFrame};

/// Results of one extraction, read back from its buffers.
pub struct Found {
    /// Facing masks of triangles. All triangles of a polygon have the same bits.
    pub facing: Vec<u32>,
    /// Empty without polygons.
    pub twisted: Vec<u32>,
    /// Empty without lists.
    pub excluded: Vec<u32>,
    pub masks: Vec<EdgeMasks>,
    pub lists: Vec<Vec<u32>>,
    pub counts: Vec<u32>,
    pub draws: Vec<DrawArguments>,
    pub statistics: ExtractionStatistics,
}

/// Views of a scene whose depths are not there yet.
pub fn views(cameras: &[ShadowCamera]) -> Vec<View<'static>> {
    cameras.iter().map(|&camera| camera.into()).collect()
}

/// Extracts on the GPU and reads everything back.
pub fn extract(
    gpu: &Gpu,
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    options: ExtractorOptions,
) -> Result<Found, String> {
    extract_with(gpu, positions, mesh, lights, ExtractorOptions { for_volumes: true, ..options })
}

/// The same with these options as they are.
pub fn extract_with(
    gpu: &Gpu,
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    options: ExtractorOptions,
) -> Result<Found, String> {
    let buffer = gpu.storage(positions);
    let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(|error| error.to_string())?;
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    gpu.submit(|encoder| extractor.encode(encoder, positions, lights).map_err(text))?;
    read(gpu, &extractor, mesh, options.max_lights)
}

/// Reads back what an extraction left in its buffers.
pub fn read(gpu: &Gpu, extractor: &Extractor, mesh: &Mesh, max_lights: usize) -> Result<Found, String> {
    let results = extractor.results();
    let mut found = Found {
        facing: Vec::new(),
        twisted: Vec::new(),
        excluded: Vec::new(),
        masks: Vec::new(),
        lists: Vec::new(),
        counts: gpu.read(results.counts, max_lights)?,
        draws: gpu.read(results.draw_arguments, max_lights)?,
        statistics: gpu.read(results.statistics, 1)?[0],
    };
    for plane in results.facing {
        let words = gpu.read::<u32>(plane, usize::MAX)?;
        let faces = mesh.faces().len();
        found.facing.extend(&words[..faces]);
        if mesh.polygons().is_some() {
            found.twisted.extend(&words[faces..2 * faces]);
        }
    }
    for plane in extractor.excluded_masks() {
        found.excluded.extend(gpu.read::<u32>(plane, mesh.faces().len())?);
    }
    for plane in results.masks {
        found.masks.extend(gpu.read::<EdgeMasks>(plane, mesh.edges().len())?);
    }
    for (word, list) in results.lists.iter().enumerate() {
        let capacity = results.capacity as usize;
        let entries: Vec<u32> = gpu.read(list, usize::MAX)?;
        for light in 0..(max_lights - 32 * word).min(32) {
            let count = (found.counts[32 * word + light] as usize).min(capacity);
            found.lists.push(entries[light * capacity..][..count].to_vec());
        }
    }
    Ok(found)
}

/// The lights of the only caster of a scene's last encode, with what was chosen for them.
pub fn chosen(gpu: &Gpu, frame: &OneFrame, lights: usize) -> Result<Vec<ShadowLight>, String> {
    let results = frame.frame.results().map_err(text)?;
    let (seen, shape) = results.view_lights.ok_or("no view")?;
    let seen: Vec<ViewLight> = gpu.read(seen, lights)?;
    let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, usize::MAX)?;
    Ok(choices::chosen(&shape, &seen, &words))
}

/// Its draws of each light.
pub fn draws(gpu: &Gpu, frame: &OneFrame, lights: usize) -> Result<Vec<ShadowDraws>, String> {
    let results = frame.frame.results().map_err(text)?;
    gpu.read(results.shadow_draws.first().ok_or("no caster")?, lights)
}

/// The statistics of its volumes.
pub fn shadow_statistics(gpu: &Gpu, frame: &OneFrame) -> Result<ShadowStatistics, String> {
    Ok(gpu.read(frame.frame.shadow_statistics().ok_or("no view")?, 1)?[0])
}

/// A scene of one caster. `pipelines` are those that draw it.
pub fn one_caster(
    gpu: &Gpu,
    pipelines: &ShadowPipelines,
    mesh: &Mesh,
    options: SceneOptions,
) -> Result<OneCaster, ShadowError> {
    let options = SceneOptions { counting: pipelines.counting(), ..options };
    OneCaster::new(&gpu.pipelines, &gpu.queue, mesh, options)
}

/// An error in words.
pub fn text<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

/// A device with these many bytes a binding and a buffer, and workgroups a dispatch.
pub fn limited(binding: u64, buffer: u64, workgroups: u32) -> Result<Gpu, String> {
    Gpu::with_limits(wgpu::Limits {
        max_storage_buffer_binding_size: binding,
        max_buffer_size: buffer,
        max_compute_workgroups_per_dimension: workgroups,
        ..wgpu::Limits::default()
    })
}

/// A torus, some of whose faces are there again: closed and non-manifold edges, more faces to a vertex.
pub fn repeated_torus(rings: u32, segments: u32, repeated: usize) -> Shape {
    let mut shape = shapes::torus(rings, segments, 1.0, 0.4);
    let again = shape.faces[..repeated].to_vec();
    shape.faces.extend(again);
    shape
}

/// Whether two extractions found the same, the order of unordered lists apart. Lists that overflowed are compared only if
/// they are ordered.
pub fn compare(what: &str, found: &Found, expected: &Found, capacity: u32, ordered: bool) -> Result<(), String> {
    same(&format!("{what}, facing"), &found.facing, &expected.facing)?;
    same(&format!("{what}, twisted"), &found.twisted, &expected.twisted)?;
    same(&format!("{what}, excluded"), &found.excluded, &expected.excluded)?;
    same(&format!("{what}, masks"), &found.masks, &expected.masks)?;
    same(&format!("{what}, counts"), &found.counts, &expected.counts)?;
    same(&format!("{what}, draws"), &found.draws, &expected.draws)?;
    same(&format!("{what}, statistics"), &[found.statistics], &[expected.statistics])?;
    same(&format!("{what}, number of lists"), &[found.lists.len()], &[expected.lists.len()])?;
    for (light, (list, whole)) in found.lists.iter().zip(&expected.lists).enumerate() {
        let sorted = |list: &[u32]| {
            let mut list = list.to_vec();
            list.sort_by_key(|entry| entry & !cpu::WINDING);
            list
        };
        // Which entries an unordered list that overflowed keeps is chance.
        if ordered {
            same(&format!("{what}, list {light}"), list, whole)?;
        } else if found.counts[light] <= capacity {
            same(&format!("{what}, list {light}"), &sorted(list), &sorted(whole))?;
        }
    }
    Ok(())
}

/// Words of a buffer with vertices at `offset` and `stride`; NaN in between, so that a wrong read shows.
pub fn interleaved(positions: &[[f32; 3]], offset: u64, stride: u64) -> Vec<f32> {
    let (offset, stride) = (offset as usize / 4, stride as usize / 4);
    let mut words = vec![f32::NAN; offset + (positions.len() - 1) * stride + 3];
    for (vertex, position) in positions.iter().enumerate() {
        words[offset + vertex * stride..][..3].copy_from_slice(position);
    }
    words
}

/// Positions of all vertices after one encode.
pub fn deformed(gpu: &Gpu, deformer: &Deformer, model: &Model, pose: &Pose) -> Result<Vec<[f32; 3]>, String> {
    gpu.submit(|encoder| deformer.encode(encoder, pose).map_err(text))?;
    gpu.read(deformer.positions().buffer, model.vertex_count())
}

/// Fails where a coordinate is further from the CPU reference's than the bound; returns how many differ at all.
pub fn check_deform(found: &[[f32; 3]], model: &Model, pose: &Pose) -> Result<usize, String> {
    let twin = cpu::deform(model, pose, 0.0, None, Threads::all()).map_err(text)?;
    if found.len() != twin.len() {
        return Err(format!("{} vertices, expected {}", found.len(), twin.len()));
    }
    let (mut at, mut differ) = (0, 0);
    for (geometry, pose) in model.placed_geometries().zip(pose.instances()) {
        for vertex in 0..geometry.positions().len() {
            let bound = deform_bound(geometry, pose, vertex);
            for ((got, expected), bound) in found[at].into_iter().zip(twin[at]).zip(bound) {
                let error = (f64::from(got) - f64::from(expected)).abs();
                if error.is_nan() || error > bound {
                    return Err(format!("vertex {at}: {got}, twin {expected}, apart {error:e}, bound {bound:e}"));
                }
                differ += usize::from(got.to_bits() != expected.to_bits());
            }
            at += 1;
        }
    }
    Ok(differ)
}
