//! What volumes are rebuilt from, and how.

use crate::ShadowCamera;

/// A depth map: what a light sees.
///
/// What is in the map must be in the eye's depth buffer at the same place, because the parts of the boundary that are left
/// out lie on it.
#[derive(Clone, Copy, Debug)]
pub struct DepthMap<'a> {
    /// A view of the depth aspect, or of the only aspect, of one layer and level. The texture has one sample a texel, usage
    /// `TEXTURE_BINDING`, and one of these formats: `Depth16Unorm`, `Depth24Plus`, `Depth24PlusStencil8`, `Depth32Float`,
    /// `Depth32FloatStencil8`, `R32Float`. `R32Float` holds the depths that the others would hold.
    ///
    /// Row 0 is at the top, where y is 1 in clip space. Texels at the far end of the depths cast nothing: 0 with reversed
    /// depth, else 1. Values beyond the far end and NaN cast nothing, either. Values before the near end are at the near end.
    pub texture: &'a wgpu::TextureView,
    /// The camera that the map was made with, at the light. It may be orthographic, for a light at infinity.
    pub light: ShadowCamera,
}

/// Which edges between neighbouring samples are taken for edges of shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum DepthEdges {
    /// Every one. Nothing is missed, and nothing needs a threshold. The surface has two triangles for each cell that is
    /// not far.
    #[default]
    EveryCell,
    /// Those between depths that differ by more than `threshold`, and those between a depth and nothing. Far fewer
    /// triangles, but where two surfaces are nearer to each other than that, as seen from the light, an edge of a shadow is
    /// missed. One missed edge can turn light and shadow round along all rays through the gap, in streaks. A threshold above the
    /// depth differences of steep surfaces has the same effect. Take it small: 0.0005 was right for scenes some ten metres across.
    Differences {
        /// In device depth, from 0 to 1. It is compared exactly. In a perspective map a step in device depth is larger in the
        /// world the farther away it is.
        threshold: f32,
    },
}

/// Options of [`DepthMapVolumes`](crate::gpu::DepthMapVolumes).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMapOptions {
    /// Which edges are taken.
    pub edges: DepthEdges,
    /// Cells that the list has room for. `None`: every cell, or as many as fit one binding. If more are found, every cell is
    /// drawn, and the vertex shader decides again: slower, never wrong.
    pub capacity: Option<u32>,
    /// How far the boundary moves away from the light where it slopes: in multiples of the depth difference over half a
    /// texel in each direction. 1 covers what a surface can deviate from the triangles between the samples while its slope
    /// is at most the one measured there. With less, steep surfaces may have specks of shadow. With more, shadows detach
    /// from what they touch.
    pub slope_bias: f32,
    /// Bytes that all buffers together may take.
    pub memory_limit: Option<u64>,
}

impl Default for DepthMapOptions {
    /// Every cell, room for all, a slope bias of 1, no limit of memory.
    fn default() -> Self {
        Self { edges: DepthEdges::EveryCell, capacity: None, slope_bias: 1.0, memory_limit: None }
    }
}
