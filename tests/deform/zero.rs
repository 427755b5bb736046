//! Zero of anything in a model that deforms: no geometry, no instance, no vertex, no joint, no target. Its positions
//! are those of the CPU, of which there may be none.

use rimline::gpu::{DeformError, Deformer, DeformerOptions, DeviceError};
use rimline::internals::cpu::{self, Threads};
use rimline::{Geometry, GeometryOptions, Influences, Instance, InstancePose, Matrix3x4, Model, Pose};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{deformed, text};
use rimline_testkit::same;

pub(crate) const TESTS: &[Test] = &[("models_of_nothing_deform_to_nothing", nothing)];

const MOVED: Matrix3x4 = [[1.0, 0.0, 0.0, 2.0], [0.0, 1.0, 0.0, 3.0], [0.0, 0.0, 1.0, 4.0]];

/// A geometry of so many vertices, joints for each and morph targets.
fn geometry(vertices: u32, influences: Option<u32>, targets: usize) -> Result<Geometry, String> {
    let of_vertices = |each: u32| {
        let all = (vertices * each) as usize;
        Influences::new((0..=vertices).map(|vertex| vertex * each).collect(), vec![0; all], vec![1.0; all])
    };
    let options = GeometryOptions {
        influences: influences.map(of_vertices).transpose().map_err(text)?,
        morph_targets: vec![vec![[0.0, 0.0, 1.0]; vertices as usize]; targets],
        ..GeometryOptions::default()
    };
    let faces = if vertices > 2 { vec![[0, 1, 2]] } else { Vec::new() };
    Geometry::new(vec![[1.0; 3]; vertices as usize], faces, options).map_err(text)
}

fn nothing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut kinds = Vec::new();
    for vertices in [0, 3] {
        for influences in [None, Some(0), Some(1)] {
            for targets in [0, 1] {
                kinds.push((vertices, influences, targets));
            }
        }
    }
    let geometries = kinds.iter().map(|&(vertices, influences, targets)| geometry(vertices, influences, targets));
    let geometries = geometries.collect::<Result<Vec<_>, _>>()?;
    let pose_of = |geometry: &Geometry, weight: f32| {
        InstancePose::new(vec![MOVED], vec![weight; geometry.morph_targets().len()]).map_err(text)
    };
    let check = |geometries: &[Geometry], instances: &[usize]| {
        let placed = instances.iter().map(|&geometry| Instance::new(geometry, None)).collect();
        let model = Model::new(geometries.to_vec(), placed).map_err(text)?;
        let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
        for weight in [0.0, 0.5] {
            let poses = instances.iter().map(|&geometry| pose_of(&geometries[geometry], weight));
            let pose = Pose::new(poses.collect::<Result<_, _>>()?);
            let truth = cpu::deform(&model, &pose, 0.0, None, Threads::ONE).map_err(text)?;
            let mut found = deformed(gpu, &deformer, &model, &pose)?;
            found.truncate(truth.len());
            same(&format!("{instances:?} of {kinds:?}, weight {weight}"), &found, &truth)?;
        }
        same("an instance too many", &[deformer.instance_positions(instances.len()).is_some()], &[false])
    };
    check(&[], &[])?;
    check(&geometries, &[])?;
    for (number, geometry) in geometries.iter().enumerate() {
        check(std::slice::from_ref(geometry), &[0])?;
        check(&geometries, &[number, number])?;
    }
    // Geometries without vertices stand between others.
    check(&geometries, &(0..geometries.len()).rev().chain(0..geometries.len()).collect::<Vec<_>>())?;
    let model = Model::new(geometries, vec![Instance::new(kinds.len() - 1, None)]).map_err(text)?;
    let options = DeformerOptions { memory_limit: Some(0), ..DeformerOptions::default() };
    match Deformer::new(&gpu.pipelines, &model, options).err() {
        Some(DeformError::Device(DeviceError::MemoryLimit { limit: 0, .. })) => Ok(()),
        other => Err(format!("no memory: {other:?}")),
    }
}
