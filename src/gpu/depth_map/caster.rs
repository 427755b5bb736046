//! What a caster with a depth map is, and what is left out of it.

use slotmap::DefaultKey;

use super::cube::DepthMapCube;
use super::volumes::DepthMapVolumes;
use crate::ShadowCamera;
use crate::gpu::scene::handles::{LightHandle, SceneId};

/// A depth map that casts in a scene. What it casts are volumes, [`DepthMapVolumes`].
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMapCaster {
    /// The light of the scene that sees the map.
    pub light: LightHandle,
    /// As [`DepthMap::texture`](crate::gpu::DepthMap::texture).
    pub texture: wgpu::TextureView,
    /// The objects, with [`DepthMapOptions::objects`](crate::gpu::DepthMapOptions::objects): as for
    /// [`DepthMapVolumes::encode_objects`](crate::gpu::DepthMapVolumes::encode_objects). Else `None`.
    pub objects: Option<wgpu::TextureView>,
    /// The camera that the map was made with, at the light. It moves with the light: nothing moves it by itself.
    pub camera: ShadowCamera,
    /// Which version of the map is in the textures. While the version, the textures and the camera stay the same, their
    /// contents are the same, and the cells that were found are kept. `None`: they may be others in each encode.
    pub version: Option<u64>,
}

/// Six depth maps that cast in a scene. What they cast are volumes, [`DepthMapCube`].
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMapCubeCaster {
    /// The light of the scene that sees the maps.
    pub light: LightHandle,
    /// The maps that are there, as for [`DepthMapCube::encode`], in the order of the cameras.
    pub textures: [Option<wgpu::TextureView>; 6],
    /// The objects, with [`DepthMapOptions::objects`](crate::gpu::DepthMapOptions::objects): as for
    /// [`DepthMapCube::encode_objects`]. Else `None` for each.
    pub objects: [Option<wgpu::TextureView>; 6],
    /// The cameras that the maps were made with, at the light, as for [`DepthMapCube::set_cameras`]. They move with the light:
    /// nothing moves them by itself.
    pub cameras: [ShadowCamera; 6],
    /// As [`DepthMapCaster::version`], for all maps.
    pub version: Option<u64>,
}

/// The volumes of a caster that was removed.
#[derive(Debug)]
pub enum DepthMapCasterVolumes {
    /// Those of one map.
    Map(Box<DepthMapVolumes>),
    /// Those of six.
    Cube(Box<DepthMapCube>),
}

/// What [`DepthMapCasters`](crate::gpu::DepthMapCasters) leave out. No switch changes a shadow that is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct DepthMapCastersOptions {
    /// Keep the cells of a map while its version says that it is the same.
    pub keep_cells: bool,
    /// Skip a map all of whose shadow is beyond the range of its light or outside its cone. Skip it for a camera all of whose
    /// view, or box of what receives, is.
    pub skip_unreached: bool,
    /// Skip a map for a camera that cannot see its shadow.
    pub skip_unseen: bool,
    /// Skip a map for a camera if none of what receives can be in its shadow. It takes effect where
    /// [`DepthMapCasters::encode_for`](crate::gpu::DepthMapCasters::encode_for) has a box.
    pub skip_hidden: bool,
}

impl Default for DepthMapCastersOptions {
    /// All of it.
    fn default() -> Self {
        Self { keep_cells: true, skip_unreached: true, skip_unseen: true, skip_hidden: true }
    }
}

/// What was done with the maps in an encode. Each is one of the first three. What only the GPU knows, such as lists that
/// overflowed, [`DepthMapCastersFrame::statistics`](crate::gpu::DepthMapCastersFrame::statistics) has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DepthMapCasterCounts {
    /// Maps whose cells were found.
    pub encoded: u32,
    /// Maps whose cells were kept.
    pub kept: u32,
    /// Maps that no camera draws. Nothing is recorded of them.
    pub skipped: u32,
    /// Of those skipped: their light was removed from the scene.
    pub unlit: u32,
    /// Of those skipped: their light does not reach what they may darken.
    pub unreached: u32,
    /// Draws of a map for a camera.
    pub draws: u32,
    /// Of these, without a near cap: the camera's near rectangle is in light as a whole.
    pub near_caps_lit: u32,
    /// Of these, whose near cap the GPU draws or leaves out.
    pub near_caps_told: u32,
}

/// A caster of [`DepthMapCasters`](crate::gpu::DepthMapCasters).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DepthMapCasterHandle {
    pub(super) casters: SceneId,
    pub(super) key: DefaultKey,
}

impl DepthMapCasterHandle {
    pub(super) fn is_of(self, casters: SceneId) -> bool {
        self.casters == casters
    }
}
