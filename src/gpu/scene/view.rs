//! The inputs of an encode of a scene.

use super::receivers::Receivers;
use crate::ShadowCamera;
use crate::gpu::common::timer::StageTimer;

/// The inputs of [`Scene::encode`](crate::gpu::Scene::encode). Lights and casters are the scene's own.
#[derive(Debug, Default)]
pub struct FrameInputs<'a> {
    /// The views that shadow volumes are prepared for. There may be none: then silhouettes are extracted only.
    pub views: &'a [View<'a>],
    /// Takes a timestamp around each stage.
    pub timer: Option<&'a mut StageTimer>,
}

impl<'a> FrameInputs<'a> {
    /// A frame without a timer.
    pub fn new(views: &'a [View<'a>]) -> Self {
        Self { views, ..Self::default() }
    }
}

/// A camera that sees shadows, and the depth that is there before they are drawn.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: ShadowCamera,
    /// The depth that the view's volumes will be drawn against, if it is drawn before the encode. The view then has no volume
    /// that none of its receivers can be in (receiver culling), which spares the passes that draw. Each encode makes the view's
    /// lists anew, since the depth may have changed. It uses cached lists only if [`Receivers::version`] says that the depth is
    /// the same.
    pub depth: Option<Receivers<'a>>,
}

impl View<'_> {
    /// A view whose depth is not there yet.
    pub fn new(camera: ShadowCamera) -> Self {
        Self { camera, depth: None }
    }
}

impl From<ShadowCamera> for View<'_> {
    fn from(camera: ShadowCamera) -> Self {
        Self::new(camera)
    }
}
