//! Devices with less: results equal those of the shared device, and what does not fit is a typed error.

use rimline::gpu::{
    DeformError, Deformer, DeformerOptions, EncodeError, Extractor, ExtractorError, ExtractorOptions, IncludeError,
    ListOptions, MemoryError, PositionBuffer, PositionError, results_bind_group_layout,
};
use rimline::shapes::{self, Shape};
use rimline::{Light, Mesh, Method, cpu};

use crate::common::device::Gpu;
use crate::common::models::{random_model, random_pose};
use crate::common::random::Random;
use crate::common::{lights, same};
use crate::deform::check_deform;
use crate::positions::interleaved;
use crate::stages::{Found, extract, read};

pub(crate) const TESTS: &[crate::Test] = &[
    ("small_limits_change_nothing", unchanged),
    ("small_limits_change_no_deformation", deform_unchanged),
    ("what_does_not_fit_is_a_typed_error", too_large),
    (
        "positions_and_models_that_do_not_fit_are_typed_errors",
        positions_and_models_too_large,
    ),
    ("a_memory_limit_refuses_before_anything_is_allocated", memory_limit),
    ("the_include_refuses_what_takes_several_bindings", include_refuses),
];

fn text<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

/// A device with these many bytes a binding and a buffer, and workgroups a dispatch.
fn limited(binding: u64, buffer: u64, workgroups: u32) -> Result<Gpu, String> {
    Gpu::with_limits(wgpu::Limits {
        max_storage_buffer_binding_size: binding,
        max_buffer_size: buffer,
        max_compute_workgroups_per_dimension: workgroups,
        ..wgpu::Limits::default()
    })
}

/// A torus, some of whose faces are there again: closed and non-manifold edges, more faces to a vertex.
fn shape(rings: u32, segments: u32, repeated: usize) -> Shape {
    let mut shape = shapes::torus(rings, segments, 1.0, 0.4);
    let again = shape.faces[..repeated].to_vec();
    shape.faces.extend(again);
    shape
}

/// How a case is run, on both devices alike.
struct Run<'a> {
    shape: &'a Shape,
    lights: &'a [Light],
    offset: u64,
    stride: u64,
    options: ExtractorOptions,
}

impl Run<'_> {
    fn on(&self, gpu: &Gpu, mesh: &Mesh) -> Result<Found, String> {
        let buffer = gpu.storage(&interleaved(&self.shape.positions, self.offset, self.stride));
        let mut extractor = Extractor::new(&gpu.device, mesh, self.options).map_err(text)?;
        let bound = PositionBuffer {
            buffer: &buffer,
            offset: self.offset,
            stride: self.stride,
        };
        gpu.submit(|encoder| extractor.encode(encoder, bound, self.lights, None).map_err(text))?;
        read(gpu, &extractor, mesh, self.options.max_lights)
    }
}

fn compare(what: &str, found: &Found, expected: &Found, capacity: u32, ordered: bool) -> Result<(), String> {
    same(&format!("{what}, facing"), &found.facing, &expected.facing)?;
    same(&format!("{what}, masks"), &found.masks, &expected.masks)?;
    same(&format!("{what}, counts"), &found.counts, &expected.counts)?;
    same(&format!("{what}, draws"), &found.draws, &expected.draws)?;
    same(
        &format!("{what}, statistics"),
        &[found.statistics],
        &[expected.statistics],
    )?;
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

/// Bytes a binding and a buffer, workgroups, rings, segments, repeated faces, offset and stride: by the arithmetic in
/// `windows`, positions and facing masks span one to four bindings.
type Limited = (u64, u64, u32, [u32; 2], usize, [u64; 2]);

const CASES: [Limited; 6] = [
    (16 << 10, 1 << 20, 64, [20, 16], 0, [0, 12]),
    (16 << 10, 1 << 20, 2, [60, 40], 0, [4, 12]),
    (16 << 10, 1 << 20, 7, [70, 50], 3000, [260, 12]),
    (16 << 10, 1 << 20, 64, [100, 54], 4000, [0, 12]),
    (64 << 10, 256 << 10, 3, [80, 60], 0, [1000, 20]),
    (64 << 10, 512 << 10, 64, [96, 64], 0, [8, 20]),
];

fn windows(bytes: u64, binding: u64) -> u64 {
    bytes.div_ceil(binding)
}

fn unchanged() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let seed = 71;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let mut spans = [std::collections::BTreeSet::new(), std::collections::BTreeSet::new()];
    for (binding, buffer, workgroups, [rings, segments], repeated, [offset, stride]) in CASES {
        let small = limited(binding, buffer, workgroups)?;
        let shape = shape(rings, segments, repeated);
        let mesh = shape.mesh().map_err(text)?;
        spans[0].insert(windows(offset % 256 + shape.positions.len() as u64 * stride, binding));
        spans[1].insert(windows(mesh.faces().len() as u64 * 4, binding));
        for (count, capacity) in [(1, 2000), (33, 100), (3, 1000)] {
            let lights = lights(&mut random, count);
            for (method, ordered) in [
                (Method::FaceMask, false),
                (Method::FaceMask, true),
                (Method::PerEdge, true),
            ] {
                let per_edge = method == Method::PerEdge;
                let lists = ListOptions {
                    capacity: Some(capacity),
                    ordered,
                    vertices_per_edge: 6,
                };
                let run = Run {
                    shape: &shape,
                    lights: &lights,
                    offset,
                    stride,
                    options: ExtractorOptions {
                        max_lights: count,
                        method,
                        masks: true,
                        // Per-edge lists have room for all edges, which is the typed error of another test.
                        lists: (!per_edge).then_some(lists),
                        memory_limit: None,
                    },
                };
                let found = run.on(&small, &mesh)?;
                let expected = run.on(gpu, &mesh)?;
                let what = format!("{binding} bytes, {workgroups} workgroups, {rings}·{segments}, {count}, {method:?}");
                compare(&what, &found, &expected, capacity, ordered)?;
            }
        }
    }
    let all = [1, 2, 3, 4].into();
    if spans == [all, [1, 2, 3, 4].into()] {
        Ok(())
    } else {
        Err(format!(
            "bindings spanned by positions and facing masks: {spans:?}, meant to be 1 to 4 each"
        ))
    }
}

fn deform_unchanged() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(72);
    let model = random_model(&mut random, 2500);
    let pose = random_pose(&mut random, &model);
    let expected = crate::deform::deformed(
        gpu,
        &Deformer::new(&gpu.device, &model, DeformerOptions::default()).map_err(text)?,
        &model,
        &pose,
    )?;
    for (binding, workgroups) in [(32 << 10, 64), (32 << 10, 2), (64 << 10, 1)] {
        let small = limited(binding, 1 << 20, workgroups)?;
        let deformer = Deformer::new(&small.device, &model, DeformerOptions::default()).map_err(text)?;
        let found = crate::deform::deformed(&small, &deformer, &model, &pose)?;
        check_deform(&found, &model, &pose)?;
        same(
            &format!("{binding} bytes a binding, {workgroups} workgroups"),
            &found,
            &expected,
        )?;
    }
    Ok(())
}

/// The memory error of an extractor that must not come to be.
fn refusal(gpu: &Gpu, mesh: &Mesh, options: ExtractorOptions) -> Result<MemoryError, String> {
    match Extractor::new(&gpu.device, mesh, options) {
        Err(ExtractorError::Memory(error)) => Ok(error),
        other => Err(format!("expected a memory error, got {:?}", other.err())),
    }
}

fn expect(what: &str, error: &MemoryError, fits: fn(&MemoryError) -> bool) -> Result<(), String> {
    if fits(error) {
        Ok(())
    } else {
        Err(format!("{what}: {error:?}"))
    }
}

fn mesh_of(shape: &Shape) -> Result<Mesh, String> {
    shape.mesh().map_err(text)
}

fn too_large() -> Result<(), String> {
    let options = ExtractorOptions {
        lists: None,
        ..Default::default()
    };
    let small = limited(16 << 10, 128 << 10, 64)?;
    let error = refusal(&small, &mesh_of(&shape(100, 60, 0))?, options)?;
    expect("12,000 faces of 12 bytes", &error, |error| {
        matches!(
            error,
            MemoryError::Buffer {
                label: "faces",
                bytes: 144_000,
                limit: 131_072
            }
        )
    })?;

    let small = limited(4 << 10, 1 << 20, 64)?;
    let error = refusal(&small, &mesh_of(&shape(60, 40, 0))?, options)?;
    expect("4,800 facing masks", &error, |error| {
        matches!(
            error,
            MemoryError::Gathered {
                what: "facing masks",
                bytes: 19_200,
                limit: 16_384
            }
        )
    })?;
    let lists = ExtractorOptions {
        max_lights: 32,
        lists: Some(ListOptions {
            capacity: Some(1000),
            ..Default::default()
        }),
        ..Default::default()
    };
    let error = refusal(&small, &mesh_of(&shape(20, 20, 0))?, lists)?;
    expect("lists", &error, |error| {
        matches!(
            error,
            MemoryError::Binding {
                what: "edge lists",
                bytes: 128_000,
                limit: 4096
            }
        )
    })?;
    let error = refusal(&limited(1 << 10, 1 << 20, 64)?, &mesh_of(&shapes::cube())?, options)?;
    expect("less than a workgroup", &error, |error| {
        matches!(error, MemoryError::Binding { .. })
    })?;
    // Every face by itself: three records a face, and blocks of them past what compaction's places can be bound with.
    let mut loose = Shape::default();
    for face in 0..14_000 {
        loose.positions.extend([[0.0; 3]; 3]);
        loose.faces.push([3 * face, 3 * face + 1, 3 * face + 2]);
    }
    let ordered = ExtractorOptions {
        lists: Some(ListOptions {
            capacity: Some(1),
            ordered: true,
            ..Default::default()
        }),
        ..Default::default()
    };
    let error = refusal(&limited(16 << 10, 1 << 20, 64)?, &mesh_of(&loose)?, ordered)?;
    expect("places", &error, |error| {
        matches!(error, MemoryError::Binding { what: "places", .. })
    })?;
    let many = ExtractorOptions {
        max_lights: 1024,
        ..options
    };
    let error = refusal(&limited(16 << 10, 128 << 10, 1)?, &mesh_of(&shape(60, 40, 0))?, many)?;
    expect("chunks", &error, |error| {
        matches!(error, MemoryError::Buffer { label: "chunks", .. })
    })?;
    Ok(())
}

fn positions_and_models_too_large() -> Result<(), String> {
    let options = ExtractorOptions {
        lists: None,
        ..Default::default()
    };
    let small = limited(4 << 10, 1 << 20, 64)?;
    let shape = shape(40, 20, 0);
    let mesh = mesh_of(&shape)?;
    let mut extractor = Extractor::new(&small.device, &mesh, options).map_err(text)?;
    let buffer = small.storage(&interleaved(&shape.positions, 0, 48));
    let bound = PositionBuffer {
        buffer: &buffer,
        offset: 0,
        stride: 48,
    };
    small.submit(|encoder| {
        let error = extractor.encode(encoder, bound, &[Light::directional([1.0, 0.0, 0.0])], None);
        match error {
            Err(EncodeError::Positions(PositionError::Memory(MemoryError::Gathered { what: "positions", .. }))) => {
                Ok(())
            }
            other => Err(format!("positions: {:?}", other.err())),
        }
    })?;
    let model = random_model(&mut Random::new(73), 500);
    match Deformer::new(
        &limited(1 << 10, 1 << 20, 64)?.device,
        &model,
        DeformerOptions::default(),
    ) {
        Err(DeformError::Memory(MemoryError::Binding { .. })) => Ok(()),
        other => Err(format!("deform: {:?}", other.err())),
    }
}

fn memory_limit() -> Result<(), String> {
    // A device of its own, where nobody else makes buffers meanwhile.
    let gpu = limited(128 << 20, 256 << 20, 65_535)?;
    let mesh = shape(60, 40, 0).mesh().map_err(text)?;
    let model = random_model(&mut Random::new(74), 500);
    let before = gpu.live_buffers()?;
    let with = |memory_limit| ExtractorOptions {
        max_lights: 40,
        masks: true,
        memory_limit,
        ..Default::default()
    };
    let MemoryError::Total { bytes, limit, largest } = refusal(&gpu, &mesh, with(Some(1000)))? else {
        return Err("not refused for the total".to_owned());
    };
    println!("{bytes} bytes wanted, most by {largest:?}");
    let one_less = refusal(&gpu, &mesh, with(Some(bytes - 1)))?;
    let expected = MemoryError::Total {
        bytes,
        limit: bytes - 1,
        largest,
    };
    same("one byte less", &[one_less], &[expected])?;
    let limited = DeformerOptions {
        memory_limit: Some(1000),
        ..Default::default()
    };
    if !matches!(
        Deformer::new(&gpu.device, &model, limited),
        Err(DeformError::Memory(MemoryError::Total { .. }))
    ) {
        return Err("deform not refused".to_owned());
    }
    same("limit", &[limit], &[1000])?;
    same("live buffers", &[gpu.live_buffers()?], &[before])?;
    let extractor = Extractor::new(&gpu.device, &mesh, with(Some(bytes))).map_err(text)?;
    let after = gpu.live_buffers()?;
    drop(extractor);
    if after <= before {
        return Err("negative control: buffers that were made are not counted".to_owned());
    }
    Ok(())
}

fn include_refuses() -> Result<(), String> {
    let gpu = limited(16 << 10, 1 << 20, 64)?;
    let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    let shape = shape(60, 40, 0);
    let mesh = shape.mesh().map_err(text)?;
    let extractor = Extractor::new(&gpu.device, &mesh, ExtractorOptions::default()).map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let bound = PositionBuffer {
        buffer: &buffer,
        offset: 0,
        stride: 12,
    };
    match extractor.results_bind_group(&layout, 0, bound) {
        Err(IncludeError::Memory(MemoryError::Binding { .. })) => Ok(()),
        other => Err(format!("{:?}", other.err())),
    }?;
    // The extraction itself goes on, in windows.
    let options = ExtractorOptions {
        masks: true,
        ..Default::default()
    };
    extract(&gpu, &shape.positions, &mesh, &[Light::point([3.0, 2.0, 1.0])], options).map(drop)
}
