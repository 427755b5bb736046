//! Displacements, resources of callers, models of nothing, and refusals of the stage `deform`.

use rimline::gpu::{DeformError, Deformer, DeformerOptions, PoseInputs};
use rimline::internals::cpu::{self, Threads};
use rimline::wgpu;
use rimline::{Displacement, Geometry, InstancePose, ModelError, Pose};

use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::storage_layout;
use rimline_testkit::harness::Test;
use rimline_testkit::models::{random_model, random_pose};
use rimline_testkit::on_gpu::{deformed, text};
use rimline_testkit::random::Random;
use rimline_testkit::{IDENTITY, same};

pub(crate) const TESTS: &[Test] = &[
    ("displace_sees_position_vertex_and_time", displaced),
    ("displace_reads_the_callers_bind_group", resources),
    ("wrong_poses_and_missing_resources_are_typed_errors", refused),
];

const PASS_THROUGH: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return select(vec3<f32>(f32(vertex), time, position.z), position, vertex % 2u == 0u);
}";

fn displaced() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(62);
    let model = random_model(&mut random, 300);
    let pose = random_pose(&mut random, &model);
    let plain = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let undisplaced = deformed(gpu, &plain, &model, &pose)?;
    let displacement = Displacement::new(PASS_THROUGH).map_err(text)?;
    if displacement.uses_resources() {
        return Err("a displacement without resources says it has some".to_owned());
    }
    let options = DeformerOptions { displacement: Some(&displacement), ..Default::default() };
    let deformer = Deformer::new(&gpu.pipelines, &model, options).map_err(text)?;
    let sources: Vec<u32> = model.placed_geometries().flat_map(Geometry::source_vertices).copied().collect();
    // Two times in one encoder: the last one counts, and the first is not overwritten before it is used.
    let first = gpu.storage(&undisplaced);
    gpu.submit(|encoder| {
        deformer.encode(encoder, PoseInputs { time_s: 0.25, ..PoseInputs::new(&pose) }).map_err(text)?;
        encoder.copy_buffer_to_buffer(deformer.positions().buffer, 0, &first, 0, first.size());
        deformer.encode(encoder, PoseInputs { time_s: -7.5, ..PoseInputs::new(&pose) }).map_err(text)
    })?;
    for (buffer, time) in [(&first, 0.25), (deformer.positions().buffer, -7.5)] {
        let found: Vec<[f32; 3]> = gpu.read(buffer, model.vertex_count())?;
        let function = |position: [f32; 3], vertex: u32, time: f32| match vertex % 2 {
            0 => position,
            _ => [vertex as f32, time, position[2]],
        };
        let expected: Vec<_> =
            undisplaced.iter().zip(&sources).map(|(&position, &vertex)| function(position, vertex, time)).collect();
        same(&format!("time {time}"), &found, &expected)?;
        // The CPU reference hands the closure the same vertex and time.
        let twin = cpu::deform(&model, &pose, time, Some(&function), Threads::all()).map_err(text)?;
        for ((got, twin), vertex) in found.iter().zip(&twin).zip(&sources) {
            if vertex % 2 != 0 {
                same("twin", &got[..2], &twin[..2])?;
            }
        }
    }
    Ok(())
}

const FROM_BUFFER: &str = "@group(1) @binding(3) var<storage, read> offsets: array<vec4<f32>>;
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return offsets[vertex].xyz;
}";

fn resources() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(63);
    let model = random_model(&mut random, 280);
    let pose = random_pose(&mut random, &model);
    let displacement = Displacement::new(FROM_BUFFER).map_err(text)?;
    let layout = storage_layout(gpu, &[(3, true)]);
    let offsets: Vec<[f32; 4]> = (0..4000).map(|v| [v as f32, random.between(-9.0, 9.0), 0.5, 7.0]).collect();
    let buffer = gpu.storage(&offsets);
    let group_of = |layout: &wgpu::BindGroupLayout, binding: u32, buffer: &wgpu::Buffer| {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("offsets"),
            layout,
            entries: &[wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }],
        })
    };
    let group = group_of(&layout, 3, &buffer);
    let other = group_of(&storage_layout(gpu, &[(0, true)]), 0, &buffer);
    let with = |displacement_layout| DeformerOptions {
        displacement: Some(&displacement),
        displacement_layout,
        memory_limit: None,
    };
    let error = Deformer::new(&gpu.pipelines, &model, with(None)).err();
    same("no layout", &[error], &[Some(DeformError::Resources)])?;
    let unasked = DeformerOptions { displacement_layout: Some(&layout), ..Default::default() };
    let error = Deformer::new(&gpu.pipelines, &model, unasked).err();
    same("a layout and no displacement", &[error], &[Some(DeformError::Resources)])?;
    let empty = storage_layout(gpu, &[]);
    match Deformer::new(&gpu.pipelines, &model, with(Some(&empty))) {
        Err(DeformError::Pipeline { .. }) => {}
        other => return Err(format!("another layout: {:?}", other.err())),
    }
    let deformer = Deformer::new(&gpu.pipelines, &model, with(Some(&layout))).map_err(text)?;
    gpu.submit(|encoder| {
        let error = deformer.encode(encoder, &pose).err();
        same("no bind group", &[error], &[Some(DeformError::Resources)])?;
        let mut encode = |resources| deformer.encode(encoder, PoseInputs { resources, ..PoseInputs::new(&pose) });
        // A group that was refused or accepted before is so again.
        for _ in 0..2 {
            match encode(Some(&other)) {
                Err(DeformError::BindGroup { .. }) => {}
                found => return Err(format!("another layout: {found:?}")),
            }
            encode(Some(&group)).map_err(text)?;
        }
        Ok(())
    })?;
    let found: Vec<[f32; 3]> = gpu.read(deformer.positions().buffer, model.vertex_count())?;
    let mut expected = Vec::new();
    for geometry in model.placed_geometries() {
        let sources = geometry.source_vertices().iter();
        expected.extend(sources.map(|&v| [v as f32, offsets[v as usize][1], 0.5]));
    }
    same("positions", &found, &expected)
}

/// A pose of another model is refused, on the GPU, on the CPU and for meshes, and nothing changes.
fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(64);
    let model = random_model(&mut random, 30);
    let pose = random_pose(&mut random, &model);
    let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let before = deformed(gpu, &deformer, &model, &pose)?;
    let sizes = pose.instances().iter().map(|of| [of.palette().len(), of.morph_weights().len()]).collect::<Vec<_>>();
    let with = |instance: usize, size: [usize; 2]| {
        let mut sizes = sizes.clone();
        sizes.resize(sizes.len().max(instance + 1), size);
        sizes[instance] = size;
        sizes
    };
    for (wrong, expected) in [
        (sizes[..6].to_vec(), ModelError::PoseInstances { given: 6, needed: 7 }),
        (with(7, [1, 0]), ModelError::PoseInstances { given: 8, needed: 7 }),
        (with(1, [0, 0]), ModelError::PosePalette { instance: 1, given: 0, needed: 1 }),
        (with(3, [1, 4]), ModelError::PoseMorphWeights { instance: 3, given: 4, needed: 5 }),
        (with(2, [12, 1]), ModelError::PoseMorphWeights { instance: 2, given: 1, needed: 0 }),
    ] {
        let instance =
            |&[matrices, weights]: &[usize; 2]| InstancePose::new(vec![IDENTITY; matrices], vec![0.0; weights]);
        let wrong = Pose::new(wrong.iter().map(instance).collect::<Result<_, _>>().map_err(text)?);
        gpu.submit(|encoder| {
            let error = deformer.encode(encoder, &wrong).err();
            same("pose", &[error], &[Some(DeformError::Model(expected))])
        })?;
        same("on the CPU", &[cpu::deform(&model, &wrong, 0.0, None, Threads::ONE).err()], &[Some(expected)])?;
        same("mesh", &[model.mesh(&wrong).err()], &[Some(expected)])?;
    }
    same("positions stay", &gpu.read(deformer.positions().buffer, before.len())?, &before)
}
