//! Cameras of the scene.

use glam::DAffine3;

use super::asset::Asset;
use super::document::{Named, Part};
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
    /// The direction that is up in the picture, at length 1 and at right angles to `forward`. Scales of nodes have no
    /// effect.
    pub up: [f32; 3],
    /// Its projection.
    pub projection: CameraProjection,
}

/// The projection of a camera of a file. Near and far planes are distances in front of the eye.
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
    let parameters: Json<'_> = match kind {
        "perspective" | "orthographic" => json.need(kind)?,
        _ => return Err(json.wrong("type", "perspective or orthographic")),
    };
    let checked = |key: &str, expected: &str, is_right: &dyn Fn(f32) -> bool, value: f64| {
        let value = value as f32;
        if value.is_finite() && is_right(value) { Ok(value) } else { Err(parameters.wrong(key, expected)) }
    };
    let positive = |key: &str, value: f64| checked(key, "a number of more than 0", &|value| value > 0.0, value);
    let behind = |near: f32, value: f64| checked("zfar", "a distance beyond znear", &|far| far > near, value);
    if kind == "perspective" {
        let is_angle = |angle: f32| angle > 0.0 && angle < std::f32::consts::PI;
        let znear = positive("znear", parameters.need("znear")?)?;
        return Ok(CameraProjection::Perspective {
            yfov: checked(
                "yfov",
                "an angle of more than 0 and less than a half turn, in radians",
                &is_angle,
                parameters.need("yfov")?,
            )?,
            aspect_ratio: parameters.get("aspectRatio")?.map(|ratio| positive("aspectRatio", ratio)).transpose()?,
            znear,
            zfar: parameters.get("zfar")?.map(|far| behind(znear, far)).transpose()?,
        });
    }
    let half = |key: &str| checked(key, "a number that is not 0", &|half| half != 0.0, parameters.need(key)?);
    let znear = checked("znear", "a distance of 0 or more", &|near| near >= 0.0, parameters.need("znear")?)?;
    Ok(CameraProjection::Orthographic {
        xmag: half("xmag")?,
        ymag: half("ymag")?,
        znear,
        zfar: behind(znear, parameters.need("zfar")?)?,
    })
}

impl Asset {
    /// The cameras of the chosen scene at a time in seconds, in the order of its nodes. Those of hidden nodes are
    /// there, too, since nothing of a camera is seen. One that is damaged does not refuse the others.
    ///
    /// # Errors
    /// [`GltfError`] as for [`Asset::pose`].
    pub fn each_camera(
        &self,
        animations: impl IntoIterator<Item = usize>,
        time_s: f32,
    ) -> Result<Vec<Result<SceneCamera, GltfError>>, GltfError> {
        let world = self.state(animations, time_s)?.world;
        Ok(self.camera_nodes().map(|(n, camera)| self.camera(n, camera, &world[n], time_s)).collect())
    }

    /// The name of each of [`Asset::each_camera`], or that of its node.
    pub fn camera_names(&self) -> Vec<Option<&str>> {
        let name = |(n, camera): (usize, &Part<usize>)| {
            let camera_name = camera.as_ref().ok().and_then(|&camera| self.document.cameras[camera].name.as_ref());
            camera_name.or(self.document.nodes[n].name.as_ref()).map(String::as_str)
        };
        self.camera_nodes().map(name).collect()
    }

    /// The nodes of the scene's cameras.
    fn camera_nodes(&self) -> impl Iterator<Item = (usize, &Part<usize>)> {
        self.graph.scene.iter().filter_map(|&n| Some((n, self.document.nodes[n].camera.as_ref()?)))
    }

    /// The camera of node `n`, whose world matrix is given.
    fn camera(&self, n: usize, camera: &Part<usize>, world: &DAffine3, time_s: f32) -> Result<SceneCamera, GltfError> {
        let damaged = |fault: &GltfError| GltfError::DamagedCamera { node: n, source: Box::new(fault.clone()) };
        self.graph.check(&self.document, n).map_err(|fault| damaged(&fault))?;
        let Named { name, part } = &self.document.cameras[*camera.as_ref().map_err(|fault| damaged(fault))?];
        let projection = *part.as_ref().map_err(|fault| damaged(fault))?;
        let forward = -world.matrix3.z_axis.normalize();
        let up = world.matrix3.y_axis.reject_from_normalized(forward).normalize();
        let [eye, forward, up] = [world.translation, forward, up].map(|vector| vector.as_vec3());
        if !(eye.is_finite() && forward.is_finite() && up.is_finite()) {
            return Err(GltfError::NotFinite { json_path: format!("nodes[{n}]"), time_s });
        }
        Ok(SceneCamera {
            name: name.clone().or_else(|| self.document.nodes[n].name.clone()),
            eye: eye.into(),
            forward: forward.into(),
            up: up.into(),
            projection,
        })
    }
}
