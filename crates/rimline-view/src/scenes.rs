//! Scenes that need no file.

use glam::{Affine3A, Quat, Vec3};
use rimline::gltf::{Asset, LoadOptions};
use rimline::{Geometry, GeometryOptions, Instance, InstancePose, Model, Pose};
use rimline_bench::shapes::{self, Shape};
use rimline_models::figure::{Figure, glb};

use crate::state::body::{Body, BodyError};

/// Makes the models of a scene.
pub type Make = fn() -> Result<Vec<Body>, BodyError>;

/// Names and makers of all scenes.
pub const ALL: [(&str, Make); 3] =
    [("Walking figure", walking_figure), ("Still life", still_life), ("Moebius band", moebius)];

/// A figure that walks, skinned and closed.
///
/// # Errors
/// [`BodyError`], which this scene never gives.
pub fn walking_figure() -> Result<Vec<Body>, BodyError> {
    let asset = Asset::from_slice(&glb::encode(&Figure::new()), None, LoadOptions::default())?;
    Ok(vec![Body::new("Walking figure", None, asset)?])
}

/// Shapes beside and on each other, which throw shadows on each other.
///
/// # Errors
/// [`BodyError`], which this scene never gives.
pub fn still_life() -> Result<Vec<Body>, BodyError> {
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let round = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let placed = [
        (shapes::blob(40, 0.55, 11), Vec3::splat(0.62), Quat::from_rotation_y(0.4), at(-0.95, 0.74, -0.35)),
        (shapes::torus(96, 48, 1.0, 0.36), Vec3::splat(0.52), Quat::IDENTITY, at(0.55, 0.19, 0.75)),
        (shapes::sphere(28), Vec3::splat(0.33), Quat::IDENTITY, at(0.55, 0.52, 0.75)),
        (shapes::cube(), Vec3::new(0.42, 0.62, 0.42), Quat::from_rotation_y(0.5), at(0.75, 0.62, -0.75)),
        (shapes::torus(80, 32, 1.0, 0.2), Vec3::splat(0.3), Quat::from_rotation_y(0.9) * round, at(0.75, 1.6, -0.75)),
    ];
    let body = |(number, (shape, scale, turn, at)): (usize, (Shape, Vec3, Quat, Vec3))| {
        const NAMES: [&str; 5] = ["Stone", "Ring", "Ball", "Block", "Hoop"];
        of_shape(NAMES[number], shape, Affine3A::from_scale_rotation_translation(scale, turn, at))
    };
    placed.into_iter().enumerate().map(body).collect()
}

/// An open surface with one side: it has a boundary, and no inside.
///
/// # Errors
/// [`BodyError`], which this scene never gives.
pub fn moebius() -> Result<Vec<Body>, BodyError> {
    let turn = Affine3A::from_rotation_x(-1.1) * Affine3A::from_rotation_z(0.4);
    Ok(vec![of_shape("Moebius band", shapes::moebius(128, 12), turn)?])
}

fn of_shape(name: &str, shape: Shape, place: Affine3A) -> Result<Body, BodyError> {
    let geometry = Geometry::new(shape.positions, shape.faces, GeometryOptions::default())?;
    let model = Model::new(vec![geometry], vec![Instance::new(0, None)])?;
    let pose = Pose::new(vec![InstancePose::new([place], Vec::new())?]);
    Body::new(name, None, (model, pose))
}
