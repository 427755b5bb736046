//! Scenes of the viewer that are made of shapes.

use glam::{Affine3A, Quat, Vec3};
use rimline::{Geometry, GeometryOptions, Instance, InstancePose, Model, ModelError, Pose};
use rimline_bench::shapes::{self, Shape};

/// A model that does not move, and its name.
pub type Still = (&'static str, Model, Pose);

/// Shapes beside and on each other, which throw shadows on each other.
pub fn still_life() -> Result<Vec<Still>, ModelError> {
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let round = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let placed = [
        ("Stone", shapes::blob(40, 0.55, 11), Vec3::splat(0.62), Quat::from_rotation_y(0.4), at(-0.95, 0.74, -0.35)),
        ("Ring", shapes::torus(96, 48, 1.0, 0.36), Vec3::splat(0.52), Quat::IDENTITY, at(0.55, 0.19, 0.75)),
        ("Ball", shapes::sphere(28), Vec3::splat(0.33), Quat::IDENTITY, at(0.55, 0.52, 0.75)),
        ("Block", shapes::cube(), Vec3::new(0.42, 0.62, 0.42), Quat::from_rotation_y(0.5), at(0.75, 0.62, -0.75)),
        (
            "Hoop",
            shapes::torus(80, 32, 1.0, 0.2),
            Vec3::splat(0.3),
            Quat::from_rotation_y(0.9) * round,
            at(0.75, 1.6, -0.75),
        ),
    ];
    let model = |(name, shape, scale, turn, at): (&'static str, Shape, Vec3, Quat, Vec3)| {
        still(name, shape, Affine3A::from_scale_rotation_translation(scale, turn, at))
    };
    placed.into_iter().map(model).collect()
}

/// An open surface with one side: it has a boundary, and no inside.
pub fn moebius() -> Result<Still, ModelError> {
    let turn = Affine3A::from_rotation_x(-1.1) * Affine3A::from_rotation_z(0.4);
    still("Moebius band", shapes::moebius(128, 12), turn)
}

fn still(name: &'static str, shape: Shape, transform: Affine3A) -> Result<Still, ModelError> {
    let geometry = Geometry::new(shape.positions, shape.faces, GeometryOptions::default())?;
    let model = Model::new(vec![geometry], vec![Instance::new(0, None)])?;
    Ok((name, model, Pose::new(vec![InstancePose::new([transform], Vec::new())?])))
}
