//! Scenes that need no file.

use rimline::gltf::{Asset, LoadOptions};
use rimline_models::figure::{Figure, glb};
use rimline_models::scenes as made;

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
    made::still_life()?.into_iter().map(body).collect()
}

/// An open surface with one side: it has a boundary, and no inside.
///
/// # Errors
/// [`BodyError`], which this scene never gives.
pub fn moebius() -> Result<Vec<Body>, BodyError> {
    Ok(vec![body(made::moebius()?)?])
}

fn body((name, model, pose): made::Still) -> Result<Body, BodyError> {
    Body::new(name, None, (model, pose))
}
