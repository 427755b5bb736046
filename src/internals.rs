//! Internals for `rimline-bench`, the command and the tests of this repository. Anything here, and every other item that is
//! hidden in the documentation, **may change in any release**.

pub use crate::method::Method;

/// Structs that Rust and WGSL share.
pub mod layout {
    pub use crate::layout::*;
}

/// Most items that an invocation takes in turn.
#[cfg(feature = "gpu")]
pub mod turns {
    pub use crate::turns::*;
}

/// Cameras and lights as the GPU sees them, and the codes of the choices that the GPU makes.
pub mod shadow {
    use crate::layout::{ShadowLight, ShadowView};
    pub use crate::shadow::{
        CAST_BACK_FACING, CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS,
        COUNT_ZP_PLUS_2005,
    };
    use crate::{CameraError, Light, ShadowCamera};

    /// The camera as the GPU needs it.
    ///
    /// # Errors
    /// [`CameraError`] for the reasons of [`ShadowCamera::check`], but mirror images are allowed.
    pub fn view(camera: &ShadowCamera) -> Result<ShadowView, CameraError> {
        camera.view()
    }

    /// The light as a camera sees it. `view` is [`view`] of this camera. No stage has chosen yet: `casting` and
    /// `counting` are 0.
    pub fn light(camera: &ShadowCamera, view: &ShadowView, light: Light) -> ShadowLight {
        camera.light(view, light)
    }
}

/// Internals of depth maps: the decision on near caps before the map is read, the input of draws, and the error of converted
/// distances.
#[cfg(feature = "depth-map")]
pub mod depth_map {
    use crate::ShadowCamera;
    use crate::gpu::depth_map::DepthMapError;
    pub use crate::gpu::depth_map::frame::DepthMapNearCap;
    pub use crate::gpu::depth_map::metric::metric_steps;
    use crate::gpu::depth_map::near::near_shadow;
    pub use crate::gpu::depth_map::view::Placing;
    use crate::gpu::depth_map::view::{depth_map_view, steps};
    use crate::layout::{DepthMapView, DepthNearBox};

    /// The input of the vertex stages for a map of `size` texels with depths in `format`. `eye` has the format of its depth
    /// buffer.
    ///
    /// # Errors
    /// [`DepthMapError`] if a camera is refused.
    pub fn map_view(
        (light, size, format): (&ShadowCamera, [u32; 2], wgpu::TextureFormat),
        eye: (&ShadowCamera, wgpu::TextureFormat),
        placing: &Placing,
    ) -> Result<DepthMapView, DepthMapError> {
        depth_map_view((light, size), steps([format], light.depth), eye, placing)
    }

    /// The samples that affect the near rectangle of an eye with a depth format, if they decide about it. `lights` are the
    /// cameras of one map of `size` texels, or of six. `has_walls`: the map's contours have walls.
    pub fn near_box(
        lights: &[ShadowCamera],
        size: [u32; 2],
        eye: (&ShadowCamera, wgpu::TextureFormat),
        has_walls: bool,
    ) -> Option<DepthNearBox> {
        near_shadow(lights, size, eye, has_walls).ok()
    }
}

/// The list of stages, with their WGSL.
#[cfg(feature = "gpu")]
pub mod stages {
    pub use crate::stages::*;
}

/// The bounds of a displacement, and its WGSL.
#[cfg(feature = "gpu")]
pub mod displace {
    use crate::Displacement;
    pub use crate::displace::bounds::{MAX_FUNCTION_BYTES, MAX_NESTING, MAX_PRIVATE_BYTES, MAX_SOURCE_BYTES};

    /// The WGSL of the deform stage with this displacement. The caller's source comes first, so its line numbers hold.
    pub fn deform_wgsl(displacement: &Displacement) -> String {
        displacement.deform_wgsl()
    }
}

/// Faces that `f32` cannot decide.
pub mod facing {
    pub use crate::cpu::extract::facing::undecided_faces;
}

/// Clusters of faces that are decided whole.
#[cfg(feature = "gpu")]
pub mod clusters {
    pub use crate::mesh::clusters::{Arranged, CLUSTER_FACES, ClusterBound, Clusters, WIDENING, edge_order};
}

/// The scene table and the choices, as the GPU keeps them.
#[cfg(feature = "gpu")]
pub mod scene {
    use bytemuck::Zeroable;

    use crate::layout::SceneCaster;

    /// Words of a caster's choices for a batch of lights and a view: `wgsl/shadow/choices.wgsl`.
    pub const CHOICE_WORDS: usize = 8;

    /// The scene table, in units of 16 bytes. Reading past its end gives zero.
    #[derive(Clone, Copy, Debug)]
    pub struct SceneTable<'a>(pub &'a [[u32; 4]]);

    impl SceneTable<'_> {
        /// A caster.
        pub fn caster(&self, index: u32) -> SceneCaster {
            let first = 8 * index as usize;
            let parts = self.0.get(first..first + 8).map(bytemuck::cast_slice::<_, SceneCaster>);
            parts.and_then(|casters| casters.first().copied()).unwrap_or(SceneCaster::zeroed())
        }

        /// Four words.
        pub fn part(&self, at: u32) -> [u32; 4] {
            self.0.get(at as usize).copied().unwrap_or_default()
        }

        /// Word `index` from part `at` on.
        pub fn word(&self, at: u32, index: u32) -> u32 {
            self.part(at + index / 4)[index as usize % 4]
        }
    }
}

/// CPU references of stages. File and function have the name of the stage. Tests compare them bit for bit, except `deform`.
pub mod cpu {
    /// The bit of an entry of a list that is set if the edge's winding bit is set.
    pub const WINDING: u32 = 1 << 31;

    pub use crate::cpu::common::filter::{RELATIVE, UNDERFLOW};
    pub use crate::cpu::common::positions::is_finite;
    pub use crate::cpu::extract::edges::{edges, silhouettes_into};
    pub use crate::cpu::extract::exact_facing::{exact_facing, excluded};
    pub use crate::cpu::extract::extraction::extract_by;
    pub use crate::cpu::extract::facing::{facing, facing_into};
    pub use crate::cpu::extract::per_edge::per_edge;
    pub use crate::cpu::polygon::edge_pair::edge_pair;
    pub use crate::cpu::polygon::half_space::fits_half_space;
    pub use crate::cpu::polygon::polygon_facing::polygon_facing;
    pub use crate::cpu::polygon::polygon_masks::{PolygonMasks, polygon_masks};
    pub use crate::cpu::polygon::polygon_turns::polygon_turns;
    pub use crate::cpu::query::shadow_boxes::shadow_boxes;
    pub use crate::cpu::*;
}
