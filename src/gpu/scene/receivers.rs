//! Receivers: the surfaces that shadows of a view may fall on, from the depth that the shadows are drawn against.

use glam::Mat4;

use super::view::View;
use crate::ShadowCamera;
use crate::gpu::common::bindings::{texture, uniform, whole};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pass::{Step, Workgroups};
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::shadow::buffers::SizedBuffers;
use crate::gpu::shadow::errors::ShadowError;
use crate::layout::{ReceiverView, ShadowView};
use crate::stages::{RECEIVER_DEPTH, RECEIVER_PYRAMID, RECEIVER_SAMPLES};

/// Words before the levels of the pyramid.
const HEAD: u64 = 16;
/// Pixels along a side of a tile.
const TILE: u32 = 8;
/// Invocations of a workgroup that take a tile each.
const TILES_PER_WORKGROUP: u32 = 64;

/// The depth attachment that the volumes of a view will be drawn against. Draw the visible surfaces before the encode's
/// commands run. Volumes in which no receiver can be are culled.
///
/// Later draws must be nearer than this depth. If they cover pixels where nothing was drawn, set [`Self::sky_receives`].
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    /// A view of the depth aspect alone, of one layer and level. The texture has usage `TEXTURE_BINDING`, and the size of
    /// the viewport that the volumes are drawn with. All samples of a pixel count.
    pub depth: &'a wgpu::TextureView,
    /// Whether shadows fall on pixels at the cleared depth, 0 with reversed depth and else 1. Set it if something is drawn
    /// there later.
    pub sky_receives: bool,
    /// The version of the depths. While the version and the camera stay the same, the depths must stay the same, and lists
    /// are cached. `None`: the depths may change in each encode.
    pub version: Option<u64>,
}

/// The receivers of a view in an encode, to compare with the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ReceiverState {
    None,
    /// They may change in each encode.
    Changing,
    Known {
        version: u64,
        sky_receives: bool,
        pixels: [u32; 2],
    },
}

/// A view of an encode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewVersion {
    pub(crate) view: ShadowView,
    /// The first encode with this view and these receivers.
    pub(crate) version: u32,
    pub(crate) receivers: ReceiverState,
}

impl ReceiverState {
    pub(crate) fn of(receivers: Option<&Receivers<'_>>) -> Self {
        receivers.map_or(Self::None, |of| match of.version {
            Some(version) => Self::Known { version, sky_receives: of.sky_receives, pixels: of.pixels() },
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

    /// Refuses a texture that shaders cannot read as depth.
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

/// The uniform of the stages of receivers.
fn receiver_view(camera: &ShadowCamera, view: &ShadowView, receivers: &Receivers<'_>, offset: u32) -> ReceiverView {
    let inverse = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
    ReceiverView {
        inverse: inverse.as_mat4().to_cols_array_2d(),
        near_min: view.near_min,
        near_z: view.near_z,
        near_max: view.near_max,
        sky_receives: u32::from(receivers.sky_receives),
        pixels: receivers.pixels(),
        offset,
        reserved: 0,
    }
}

/// The stages of the views that have receivers. The buffer has one word, then `sizes.receivers` words for each view.
pub(crate) fn steps(
    pipelines: &Pipelines,
    views: &[View<'_>],
    shadow_views: &[ShadowView],
    buffers: &SizedBuffers,
) -> Result<Vec<Step>, ShadowError> {
    let (target, words) = (&buffers.of.receivers, buffers.sizes.receivers);
    let mut table = UniformTable::default();
    let mut uniform_offsets = Vec::new();
    for (number, (given, view)) in views.iter().zip(shadow_views).enumerate() {
        if let Some(receivers) = &given.depth {
            let uniform = receiver_view(&given.camera, view, receivers, offset(number, words));
            uniform_offsets.push((number, receivers, table.push(&uniform)));
        }
    }
    if uniform_offsets.is_empty() {
        return Ok(Vec::new());
    }
    let device = pipelines.device();
    let uniforms = table.into_buffer(device, "receiver views");
    let mut steps = Vec::new();
    for (view, receivers, offset) in uniform_offsets {
        let tiles = receivers.pixels().map(|pixels| pixels.div_ceil(TILE));
        let over = Workgroups::over(device, (tiles[0] * tiles[1]).div_ceil(TILES_PER_WORKGROUP));
        let is_single = receivers.depth.texture().sample_count() == 1;
        let tile_stage = if is_single { &RECEIVER_DEPTH } else { &RECEIVER_SAMPLES };
        let get = |name: &str| {
            Some(match name {
                "receiver_view" => uniform::<ReceiverView>(&uniforms, offset),
                "receivers" => whole(target),
                "depth_texture" => texture(receivers.depth),
                _ => return None,
            })
        };
        for (stage, workgroups) in [(tile_stage, over), (&RECEIVER_PYRAMID, Workgroups::Known([1, 1]))] {
            let pipeline = pipelines.compute(stage, stage.name, &[]);
            let dispatch = any_error(device, || pipeline.dispatch(device, workgroups, get));
            let refused = |message| ShadowError::ReceiversRefused { view, message };
            steps.push(pipeline.pass([dispatch.map_err(refused)?]));
        }
    }
    Ok(steps)
}

/// The first word of the receivers of a view. Stages read 0 as no receivers.
pub(crate) fn offset(view: usize, words: u64) -> u32 {
    1 + (view as u64 * words) as u32
}
