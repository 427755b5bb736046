//! Cameras of the scene.

/// A camera of the file, posed at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// The name of the camera, otherwise that of its node.
    pub name: Option<String>,
    /// The position in world space, relative to [`Asset::origin`](super::Asset::origin).
    pub eye: [f32; 3],
    /// The direction that it looks in, at length 1: the node's −Z.
    pub forward: [f32; 3],
    /// The direction that is up in the picture, at length 1 and at right angles to `forward`.
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
        /// Width by height of the picture that the author had in mind: more than 0.
        aspect_ratio: Option<f32>,
        /// More than 0.
        znear: f32,
        /// More than `znear`. `None`: there is no far plane.
        zfar: Option<f32>,
    },
    /// With parallel rays.
    Orthographic {
        /// Half of the width that is seen: not 0. A negative one mirrors the picture from left to right.
        xmag: f32,
        /// Half of the height that is seen: not 0. A negative one mirrors the picture from top to bottom.
        ymag: f32,
        /// At least 0.
        znear: f32,
        /// More than `znear`.
        zfar: f32,
    },
}
