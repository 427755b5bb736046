//! The inputs of an encode of a scene.

use super::mask::LightMask;
use crate::ShadowCamera;
use crate::gpu::common::timer::StageTimer;

/// The inputs of [`Scene::encode`](crate::gpu::Scene::encode) and [`Scene::deform`](crate::gpu::Scene::deform). The lights
/// and casters are those of the scene.
#[derive(Debug, Default)]
pub struct FrameInputs<'a> {
    /// The views that shadow volumes are prepared for. Without views, the encode deforms models and extracts silhouettes,
    /// and prepares no volumes.
    pub views: &'a [View<'a>],
    /// Takes a timestamp around each stage.
    pub timer: Option<&'a mut StageTimer>,
}

impl<'a> FrameInputs<'a> {
    /// Inputs without a timer.
    pub fn new(views: &'a [View<'a>]) -> Self {
        Self { views, ..Self::default() }
    }
}

/// A camera whose shadows are drawn, and the depth to draw them against.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: ShadowCamera,
    /// The depth that the view's volumes will be drawn against, if it is drawn before the encode's commands run. Volumes
    /// in which no receiver can be are then culled, which makes the draws faster. The view's lists are then cached only
    /// if [`Receivers::version`] says that the depth is the same. Default: `None`.
    pub depth: Option<Receivers<'a>>,
    /// The lights whose shadows are drawn in this view. For others no volumes are prepared, nor models deformed that the
    /// view does not see, and [`SceneFrame::draw`](crate::gpu::SceneFrame::draw) refuses them.
    /// [Leave out](LightMask::without) a light of the scene that is the eye of outlines. Default: all.
    pub lights: LightMask,
}

impl View<'_> {
    /// A view without depth, for all lights.
    pub fn new(camera: ShadowCamera) -> Self {
        Self { camera, depth: None, lights: LightMask::ALL }
    }
}

impl From<ShadowCamera> for View<'_> {
    fn from(camera: ShadowCamera) -> Self {
        Self::new(camera)
    }
}

/// The depth attachment that the volumes of a view will be drawn against. Draw the visible surfaces before the encode's
/// commands run. Volumes in which no receiver can be are culled.
///
/// Later draws may only make depths nearer. If they cover pixels where nothing was drawn, set [`Self::sky_receives`].
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    /// A view of the depth aspect alone, of level 0 of one layer. With another level, volumes are culled wrongly. The
    /// texture has usage `TEXTURE_BINDING`, and the size of the viewport that the volumes are drawn with. All samples of
    /// a pixel count.
    pub depth: &'a wgpu::TextureView,
    /// Whether shadows fall on pixels at the cleared depth: 0 with reversed depth, else 1. Set it if something is drawn
    /// there later.
    pub sky_receives: bool,
    /// The version of the depths. While the version and the camera stay those that the view of this index had in the
    /// encode before, the depths must stay the same, and lists are cached. `None`: the depths may change in each encode.
    pub version: Option<u64>,
}
