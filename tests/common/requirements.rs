//! A device that has less than the stages need: one typed error that names it, and no error of the device.

use std::collections::BTreeSet;

use rimline::gpu::depth_map::{DepthMap, DepthMapError, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
use rimline::gpu::{
    DeformError, Deformer, DeformerOptions, DeviceError, Extractor, ExtractorError, ExtractorOptions, ListOptions,
    Pipelines, QueryError, SceneOptions, ShadowError, ShadowFormat, ShadowPipelines, ShadowQuery, ShadowQueryOptions,
    StencilCounts,
};
use rimline::internals::Method;
use rimline::{Counting, Light};
use rimline_testkit::harness::Test;
use rimline_testkit::models::{random_model, random_pose};
use rimline_testkit::on_gpu::{shadow_statistics, text};
use rimline_testkit::passes::{CLEARED, depth_pass, texture};
use rimline_testkit::random::Random;
use rimline_testkit::{OneCaster, made_anew, must_fail, same};

use crate::watched::{Watched, camera, caster, depth_stencil, packed};

pub(crate) const TESTS: &[Test] = &[
    ("small_presets_are_one_typed_error", presets),
    ("limits_one_too_low_are_typed_errors_and_those_that_they_name_are_enough", named),
];

/// Objects that a caller creates on its own device, each without the others.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Subject {
    Extract,
    Shadow,
    Query,
    Deform,
    DepthMap,
}

const SUBJECTS: [Subject; 5] = [Subject::Extract, Subject::Shadow, Subject::Query, Subject::Deform, Subject::DepthMap];

/// The device error of what a constructor gives, if any.
macro_rules! device_error {
    ($made:expr, $kind:ident) => {
        match $made {
            Ok(_) => Ok(None),
            Err($kind::Device(error)) => Ok(Some(error)),
            Err(error) => Err(error.to_string()),
        }
    };
}

/// The device error of a subject's constructor, if any.
fn refusal(watched: &Watched, subject: Subject) -> Result<Option<DeviceError>, String> {
    let (pipelines, format) = (&Pipelines::new(&watched.gpu.device), &ShadowFormat::default());
    let (_, mesh) = caster()?;
    let model = random_model(&mut Random::new(91), 50);
    let error = match subject {
        Subject::Extract => {
            device_error!(Extractor::new(pipelines, &mesh, ExtractorOptions::default()), ExtractorError)
        }
        Subject::Shadow => device_error!(ShadowPipelines::new(pipelines, format, Counting::Auto), ShadowError),
        Subject::Query => device_error!(ShadowQuery::new(pipelines, &mesh, ShadowQueryOptions::default()), QueryError),
        Subject::Deform => device_error!(Deformer::new(pipelines, &model, DeformerOptions::default()), DeformError),
        Subject::DepthMap => device_error!(DepthMapPipelines::new(pipelines, format, 0), DepthMapError),
    };
    // A memory error concerns this mesh or model only, not the limits that every one needs.
    let is_of_mesh = matches!(subject, Subject::Extract | Subject::Query | Subject::Deform);
    let error = error.map_err(|error| format!("{subject:?}: {error}"))?;
    Ok(error.filter(|error| !(is_of_mesh && error.is_memory())))
}

/// The first of the limits that are too low is named.
fn presets() -> Result<(), String> {
    use wgpu::Limits;
    for (limits, expected) in [
        (Limits::downlevel_defaults(), "max_storage_buffers_per_shader_stage"),
        (Limits::downlevel_webgl2_defaults(), "max_compute_workgroups_per_dimension"),
    ] {
        let watched = Watched::new(wgpu::Features::empty(), limits.clone())?;
        for subject in SUBJECTS {
            match refusal(&watched, subject)? {
                // Depth maps need four storage buffers, as many as these limits have.
                None if subject == Subject::DepthMap && limits.max_storage_buffers_per_shader_stage == 4 => {}
                Some(DeviceError::Limit { limit, .. }) => same(&format!("{subject:?}"), &[limit], &[expected])?,
                other => return Err(format!("{subject:?}: {other:?}")),
            }
        }
        watched.quiet(expected)?;
    }
    Ok(())
}

/// A limit's name, and how it is set.
type Limit = (&'static str, fn(&mut wgpu::Limits, u64));

macro_rules! limits {
    ($($name:ident: $kind:ty),*) => { [$((stringify!($name), |limits, value| limits.$name = value as $kind)),*] };
}

const LIMITS: [Limit; 16] = limits![
    max_compute_workgroups_per_dimension: u32,
    max_compute_invocations_per_workgroup: u32,
    max_compute_workgroup_size_x: u32,
    max_compute_workgroup_size_y: u32,
    max_compute_workgroup_size_z: u32,
    max_compute_workgroup_storage_size: u32,
    max_storage_buffers_per_shader_stage: u32,
    max_uniform_buffers_per_shader_stage: u32,
    max_buffers_and_acceleration_structures_per_shader_stage: u32,
    max_dynamic_uniform_buffers_per_pipeline_layout: u32,
    max_bind_groups: u32,
    max_bind_groups_plus_vertex_buffers: u32,
    max_bindings_per_bind_group: u32,
    max_uniform_buffer_binding_size: u64,
    max_storage_buffer_binding_size: u64,
    max_buffer_size: u64
];

fn with(set: fn(&mut wgpu::Limits, u64), value: u64) -> Result<Watched, String> {
    let mut limits = wgpu::Limits::default();
    set(&mut limits, value);
    Watched::new(wgpu::Features::empty(), limits)
}

/// The limit that each subject needs, from the error for a device that has none of it. 0 if the subject does not need it.
fn needed((name, set): Limit) -> Result<[u64; 5], String> {
    let none = with(set, 0)?;
    let mut found = [0; 5];
    for (needed_here, subject) in found.iter_mut().zip(SUBJECTS) {
        match refusal(&none, subject)? {
            Some(DeviceError::Limit { limit, needed, there: 0, .. }) if limit == name => *needed_here = needed,
            None => {}
            other => return Err(format!("{subject:?} with no {name}: {other:?}")),
        }
    }
    none.quiet(name)?;
    Ok(found)
}

type Used = fn(&Watched) -> Result<(), String>;

/// Everything that a subject can do, on a device with the very limits that errors name; sizes of bindings and buffers apart, which
/// meshes need more of. With one less of any limit there is an error, and none for subjects that need no more.
fn named() -> Result<(), String> {
    let mut least = SUBJECTS.map(|_| wgpu::Limits::default());
    for limit @ (name, set) in LIMITS {
        let all = needed(limit)?;
        println!("{name}: {all:?}");
        let tried: BTreeSet<u64> = all.into_iter().filter(|&needed| needed > 1).map(|needed| needed - 1).collect();
        for there in tried {
            let watched = with(set, there)?;
            for (needed, subject) in all.into_iter().zip(SUBJECTS) {
                let found = refusal(&watched, subject)?.map(|error| match error {
                    DeviceError::Limit { limit, needed, there, .. } => Ok((limit, needed, there)),
                    error => Err(error),
                });
                let expected = (needed > there).then_some(Ok((name, needed, there)));
                same(&format!("{subject:?}, {name} of {there}"), &[found], &[expected])?;
            }
            watched.quiet(name)?;
        }
        if !matches!(name, "max_storage_buffer_binding_size" | "max_buffer_size") {
            let [extract, shadow, query, deform, maps] = all;
            // Volumes are of an extraction.
            for (limits, value) in least.iter_mut().zip([extract, shadow.max(extract), query, deform, maps]) {
                set(limits, value);
            }
        }
    }
    let on = |limits| Watched::new(wgpu::Features::empty(), limits);
    let uses: [Used; 5] = [extractions, shadows, queries, deformations, depth_maps];
    for (used, limits) in uses.into_iter().zip(least) {
        used(&on(limits)?)?;
    }
    // Negative control: volumes on a device that is enough for extraction alone.
    must_fail("volumes with one bind group", &shadows(&on(wgpu::Limits { max_bind_groups: 1, ..Default::default() })?))
}

fn lights() -> Vec<Light> {
    (0..40_u8).map(|number| Light::point([3.0 + f32::from(number), 5.0, 2.0])).collect()
}

fn extractions(watched: &Watched) -> Result<(), String> {
    let (shape, mesh) = caster()?;
    let positions = watched.gpu.storage(&shape.positions);
    for (method, ordered) in [(Method::FaceMask, false), (Method::FaceMask, true), (Method::PerEdge, true)] {
        let lists = Some(ListOptions { ordered, ..Default::default() });
        let options = ExtractorOptions { max_lights: 40, method, masks: true, lists, ..Default::default() };
        let mut extractor = Extractor::new(&watched.gpu.pipelines, &mesh, options).map_err(text)?;
        watched
            .gpu
            .submit(|encoder| extractor.encode(encoder, packed(&positions), &lights()).map_err(text).map(drop))?;
        let counts: Vec<u32> = watched.gpu.read(extractor.results().counts, 40)?;
        if counts.contains(&0) {
            return Err(format!("{method:?}, ordered {ordered}: {counts:?}"));
        }
    }
    watched.quiet("extraction")
}

fn shadows(watched: &Watched) -> Result<(), String> {
    let (shape, mesh) = caster()?;
    let positions = watched.gpu.storage(&shape.positions);
    let pipelines = &watched.gpu.pipelines;
    let view = depth_stencil(watched);
    for counting in [Counting::Auto, Counting::ZPass, Counting::ZpPlus, Counting::ZpPlus2005, Counting::ZFail] {
        let drawing = ShadowPipelines::new(pipelines, &ShadowFormat::default(), counting).map_err(text)?;
        let stencil = StencilCounts { bound_counts: true, ..StencilCounts::default() };
        let options = SceneOptions { stencil, end_at_range: true, ..made_anew(40, counting) };
        let mut caster = OneCaster::new(pipelines, &watched.gpu.queue, &mesh, options).map_err(text)?;
        let shadows = watched.gpu.submit(|encoder| {
            let shadows = caster.encode(encoder, packed(&positions), &lights(), Some(&camera()), None).map_err(text)?;
            let mut pass = encoder.begin_render_pass(&depth_pass(&view, CLEARED));
            (0..40).try_for_each(|light| shadows.draw(&mut pass, &drawing, light)).map_err(text)?;
            drop(pass);
            Ok(shadows)
        })?;
        shadow_statistics(&watched.gpu, &shadows)?;
    }
    watched.quiet("shadow volumes")
}

fn queries(watched: &Watched) -> Result<(), String> {
    let (shape, mesh) = caster()?;
    let positions = watched.gpu.storage(&shape.positions);
    for skip in [true, false] {
        let options = ShadowQueryOptions { max_points: 100, max_lights: 40, skip_by_boxes: skip, ..Default::default() };
        let mut query = ShadowQuery::new(&watched.gpu.pipelines, &mesh, options).map_err(text)?;
        let packed_positions = packed(&positions);
        watched.gpu.submit(|encoder| {
            query.encode_at(encoder, packed_positions, packed_positions, 30, &lights()).map_err(text)
        })?;
        watched.gpu.read::<i32>(query.occluder_counts(), 30 * 40)?;
    }
    watched.quiet("query")
}

fn deformations(watched: &Watched) -> Result<(), String> {
    let mut random = Random::new(92);
    let model = random_model(&mut random, 50);
    let pose = random_pose(&mut random, &model);
    let deformer = Deformer::new(&watched.gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    watched.gpu.submit(|encoder| deformer.encode(encoder, &pose).map_err(text))?;
    watched.gpu.read::<f32>(deformer.positions().buffer, 3)?;
    watched.quiet("deformation")
}

fn depth_maps(watched: &Watched) -> Result<(), String> {
    let map = watched.gpu.device.create_texture(&texture([60; 2], wgpu::TextureFormat::Depth16Unorm));
    let (map, view) = (map.create_view(&wgpu::TextureViewDescriptor::default()), depth_stencil(watched));
    let pipelines = DepthMapPipelines::new(&watched.gpu.pipelines, &ShadowFormat::default(), 0).map_err(text)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [60, 60], DepthMapOptions::default()).map_err(text)?;
    watched.gpu.submit(|encoder| {
        let map = DepthMap { texture: &map, light: camera(), objects: None };
        let frame = volumes.encode(encoder, &map, &camera()).map_err(text)?;
        frame.draw(&mut encoder.begin_render_pass(&depth_pass(&view, CLEARED)), &pipelines).map_err(text)
    })?;
    watched.gpu.read::<u32>(volumes.cells(), 1)?;
    watched.quiet("volumes from depth maps")
}
