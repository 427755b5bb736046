//! Receivers: what the shadows of a view may fall on, from the depth that they are drawn against.

use glam::Mat4;

use crate::ShadowCamera;
use crate::gpu::common::bindings::{texture, uniform, whole};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pass::{Step, Workgroups};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::shadow::errors::ShadowError;
use crate::layout::{ReceiverView, ShadowView};
use crate::stages::{RECEIVER_DEPTH, RECEIVER_PYRAMID, RECEIVER_SAMPLES};

/// Words before the levels of the pyramid.
const HEAD: u64 = 16;
/// Pixels along a side of a tile.
const TILE: u32 = 8;
/// Invocations of a workgroup that take a tile each.
const TILES_PER_WORKGROUP: u32 = 64;

/// The depth attachment that the volumes of a view will be drawn against, as it is when the encode's commands run. So draw
/// the visible surfaces before. A caster throws no volume for a view in which no receiver can be in it.
///
/// Draws after that must be nearer than the depth that was there. If they cover pixels where nothing was, set
/// [`Self::sky_receives`].
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    /// A view of the depth aspect alone, of one layer and level. The texture has usage `TEXTURE_BINDING` besides. It has the
    /// size of the viewport that the volumes are drawn with. All samples of a pixel enter.
    pub depth: &'a wgpu::TextureView,
    /// Whether shadows fall on pixels at the depth that is cleared to, 0 with reversed depth and else 1. Usually nothing is
    /// lit there.
    pub sky_receives: bool,
    /// Which version of the depths it is. While the version and the camera stay the same, the depths are the same, and lists
    /// are kept. `None`: they may be others in each encode.
    pub version: Option<u64>,
}

/// The receivers of a view as an encode knew them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SeenReceivers {
    None,
    /// They may be others in each encode.
    Changing,
    /// The version, whether the sky receives, and the size.
    Known(u64, bool, [u32; 2]),
}

impl SeenReceivers {
    pub(crate) fn of(receivers: Option<&Receivers<'_>>) -> Self {
        receivers.map_or(Self::None, |of| match of.version {
            Some(version) => Self::Known(version, of.sky_receives, of.pixels()),
            None => Self::Changing,
        })
    }
}

impl Receivers<'_> {
    fn pixels(&self) -> [u32; 2] {
        let texture = self.depth.texture();
        [texture.width(), texture.height()]
    }

    /// Words of the pyramid.
    pub(crate) fn words(&self) -> u64 {
        let mut cells = self.pixels().map(|pixels| u64::from(pixels.div_ceil(TILE)));
        let mut words = HEAD + cells[0] * cells[1];
        while cells[0] * cells[1] > 1 {
            cells = cells.map(|cells| cells.div_ceil(2));
            words += cells[0] * cells[1];
        }
        words
    }

    /// Refuses what cannot be read, as far as a texture tells.
    pub(crate) fn check(&self, view: usize) -> Result<(), ShadowError> {
        let texture = self.depth.texture();
        let format = texture.format();
        if !format.has_depth_aspect() {
            return Err(ShadowError::ReceiversFormat { view, format });
        }
        if !texture.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING) {
            return Err(ShadowError::ReceiversUsage { view });
        }
        Ok(())
    }
}

/// The view of receivers that their stages read.
fn receiver_view(camera: &ShadowCamera, view: &ShadowView, receivers: &Receivers<'_>, at: u32) -> ReceiverView {
    let inverse = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
    ReceiverView {
        inverse: inverse.as_mat4().to_cols_array_2d(),
        near_min: view.near_min,
        near_z: view.near_z,
        near_max: view.near_max,
        sky_receives: u32::from(receivers.sky_receives),
        pixels: receivers.pixels(),
        at,
        reserved: 0,
    }
}

/// A view, as given and as stages see it, and its receivers.
pub(crate) type SeenDepth<'a> = (&'a ShadowCamera, &'a ShadowView, Option<&'a Receivers<'a>>);

/// The stages of the views that have receivers. `target` has room for `words` words of each view, after the first word.
pub(crate) fn steps<'a>(
    pipelines: &Pipelines,
    views: impl Iterator<Item = SeenDepth<'a>>,
    (target, words): (&wgpu::Buffer, u64),
) -> Result<Vec<Step>, ShadowError> {
    let mut table = UniformTable::default();
    let mut given = Vec::new();
    for (number, (camera, view, receivers)) in views.enumerate() {
        if let Some(receivers) = receivers {
            let at = at(number, words);
            given.push((number, receivers, table.push(&receiver_view(camera, view, receivers, at))));
        }
    }
    if given.is_empty() {
        return Ok(Vec::new());
    }
    let device = pipelines.device();
    let uniforms = table.into_buffer(device, "receiver views");
    let mut steps = Vec::new();
    for (view, receivers, offset) in given {
        let tiles = receivers.pixels().map(|pixels| pixels.div_ceil(TILE));
        let over = Workgroups::over(device, (tiles[0] * tiles[1]).div_ceil(TILES_PER_WORKGROUP));
        let is_single = receivers.depth.texture().sample_count() == 1;
        let of_tiles = if is_single { &RECEIVER_DEPTH } else { &RECEIVER_SAMPLES };
        let get = |name: &str| {
            Some(match name {
                "receiver_view" => uniform::<ReceiverView>(&uniforms, offset),
                "receivers" => whole(target),
                "depth_texture" => texture(receivers.depth),
                _ => return None,
            })
        };
        for (stage, workgroups) in [(of_tiles, over), (&RECEIVER_PYRAMID, Workgroups::Known([1, 1]))] {
            let pipeline = pipelines.compute(stage, stage.name, &[]);
            let dispatch = any_error(device, || pipeline.dispatch(device, workgroups, get));
            let refused = |message| ShadowError::ReceiversRefused { view, message };
            steps.push(pipeline.pass([dispatch.map_err(refused)?]));
        }
    }
    Ok(steps)
}

/// The word where the receivers of a view begin. 0 says that there are none.
pub(crate) fn at(view: usize, words: u64) -> u32 {
    1 + (view as u64 * words) as u32
}
