//! The inputs of an encode of a scene.

use super::receivers::Receivers;
use crate::ShadowCamera;
use crate::gpu::common::timer::StageTimer;

/// The inputs of [`Scene::encode`](crate::gpu::Scene::encode). Lights and casters are the scene's own.
#[derive(Debug, Default)]
pub struct FrameInputs<'a> {
    /// The views that shadow volumes are prepared for. Without views, the encode only extracts silhouettes.
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

/// A camera whose shadows are drawn, and the depth to draw them against.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: ShadowCamera,
    /// The depth that the view's volumes will be drawn against, if it is drawn before the encode. Volumes without a receiver
    /// are then culled, which makes the draws faster. The view's lists are cached only if [`Receivers::version`] says that
    /// the depth is the same. Default: `None`.
    pub depth: Option<Receivers<'a>>,
}

impl View<'_> {
    /// A view without depth.
    pub fn new(camera: ShadowCamera) -> Self {
        Self { camera, depth: None }
    }
}

impl From<ShadowCamera> for View<'_> {
    fn from(camera: ShadowCamera) -> Self {
        Self::new(camera)
    }
}
