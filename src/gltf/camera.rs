//! Cameras of the scene.

use super::error::GltfError;
use super::json::Json;

/// A camera of the file at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// The name of the camera, or that of its node.
    pub name: Option<String>,
    /// The position in world space, relative to [`Asset::origin`].
    pub eye: [f32; 3],
    /// The direction that it looks in, at length 1: the node's −Z.
    pub forward: [f32; 3],
    /// The direction that is up in the picture, at length 1 and at right angles to `forward`. Scales of nodes have no effect.
    pub up: [f32; 3],
    /// What it sees.
    pub projection: CameraProjection,
}

/// What a camera of a file sees. Near and far planes are distances in front of the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraProjection {
    /// From a point.
    Perspective {
        /// The vertical field of view, in radians: more than 0 and less than π.
        yfov: f32,
        /// Width by height of the picture that the author had in mind.
        aspect_ratio: Option<f32>,
        /// More than 0.
        znear: f32,
        /// More than `znear`. `None`: there is no far plane.
        zfar: Option<f32>,
    },
    /// With parallel rays.
    Orthographic {
        /// Half of the width that is seen: not 0.
        xmag: f32,
        /// Half of the height: not 0.
        ymag: f32,
        /// At least 0.
        znear: f32,
        /// More than `znear`.
        zfar: f32,
    },
}

/// A camera without its name.
pub(super) fn projection(json: &Json<'_>) -> Result<CameraProjection, GltfError> {
    let kind = json.need("type")?;
    let own: Json<'_> = match kind {
        "perspective" | "orthographic" => json.need(kind)?,
        _ => return Err(json.wrong("type", "perspective or orthographic")),
    };
    let checked = |key: &str, expected: &str, is_right: &dyn Fn(f32) -> bool, value: f64| {
        let value = value as f32;
        if value.is_finite() && is_right(value) { Ok(value) } else { Err(own.wrong(key, expected)) }
    };
    let positive = |key: &str, value: f64| checked(key, "a number of more than 0", &|value| value > 0.0, value);
    let behind = |near: f32, value: f64| checked("zfar", "a distance beyond znear", &|far| far > near, value);
    if kind == "perspective" {
        let is_angle = |angle: f32| angle > 0.0 && angle < std::f32::consts::PI;
        let znear = positive("znear", own.need("znear")?)?;
        return Ok(CameraProjection::Perspective {
            yfov: checked(
                "yfov",
                "an angle of more than 0 and less than a half turn, in radians",
                &is_angle,
                own.need("yfov")?,
            )?,
            aspect_ratio: own.get("aspectRatio")?.map(|ratio| positive("aspectRatio", ratio)).transpose()?,
            znear,
            zfar: own.get("zfar")?.map(|far| behind(znear, far)).transpose()?,
        });
    }
    let half = |key: &str| checked(key, "a number that is not 0", &|half| half != 0.0, own.need(key)?);
    let znear = checked("znear", "a distance of 0 or more", &|near| near >= 0.0, own.need("znear")?)?;
    Ok(CameraProjection::Orthographic {
        xmag: half("xmag")?,
        ymag: half("ymag")?,
        znear,
        zfar: behind(znear, own.need("zfar")?)?,
    })
}
