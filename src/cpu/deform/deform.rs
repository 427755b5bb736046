//! Deform: morph, skin, displace, from mesh space to world space.

use crate::cpu::common::parallel::Threads;
use crate::model::{Geometry, InstancePose, Model, ModelError, Pose};

/// The caller's displacement. Its arguments are the world-space position after morph and skin, the source vertex index,
/// and the time in seconds. It returns the displaced position in world space.
pub type Displace<'a> = &'a (dyn Fn([f32; 3], u32, f32) -> [f32; 3] + Sync);

/// Computes the world-space positions of all instances, in the vertex order of [`Model::mesh`]. `time_s` is for
/// `displace`, in seconds. The `f32` arithmetic has the order of `wgsl/deform/deform.wgsl`; see docs/numerics/deform.md,
/// "Deform".
///
/// # Errors
/// [`ModelError`] if the pose does not fit the model.
pub fn deform(
    model: &Model,
    pose: &Pose,
    time_s: f32,
    displace: Option<Displace<'_>>,
    threads: Threads,
) -> Result<Vec<[f32; 3]>, ModelError> {
    model.check(pose)?;
    let mut positions = vec![[0.0; 3]; model.vertex_count()];
    let mut rest = positions.as_mut_slice();
    for (geometry, pose) in model.placed_geometries().zip(pose.instances()) {
        let (of_instance, others) = rest.split_at_mut(geometry.positions().len());
        threads.share(of_instance, |first, positions| {
            for (vertex, position) in (first..).zip(positions) {
                *position = deform_vertex(geometry, pose, vertex);
                if let Some(displace) = displace {
                    *position = displace(*position, geometry.source_vertices()[vertex], time_s);
                }
            }
        });
        rest = others;
    }
    Ok(positions)
}

fn deform_vertex(geometry: &Geometry, pose: &InstancePose, vertex: usize) -> [f32; 3] {
    let mut p = geometry.positions()[vertex];
    for (target, &weight) in geometry.morph_targets().iter().zip(pose.morph_weights()) {
        if weight != 0.0 {
            p = add_scaled(p, weight, target[vertex]);
        }
    }
    let Some(influences) = geometry.influences() else {
        return transform(pose, 0, p);
    };
    let range = influences.range(vertex);
    let joints = influences.joints()[range.clone()].iter().zip(&influences.weights()[range]);
    joints.fold([0.0; 3], |sum, (&joint, &weight)| add_scaled(sum, weight, transform(pose, joint, p)))
}

fn add_scaled(sum: [f32; 3], weight: f32, v: [f32; 3]) -> [f32; 3] {
    [sum[0] + weight * v[0], sum[1] + weight * v[1], sum[2] + weight * v[2]]
}

fn transform(pose: &InstancePose, joint: u32, p: [f32; 3]) -> [f32; 3] {
    // `Model::check` made sure that the palette has every joint.
    pose.palette()[joint as usize].rows().map(|[x, y, z, w]| x * p[0] + y * p[1] + z * p[2] + w)
}
