//! The input of volumes from depth maps, and their options.

use super::error::DepthMapError;
use super::metric::DepthMetric;
use super::texture::MAP_FORMATS;
use crate::ShadowCamera;

/// A depth map: what a light sees.
///
/// Everything in the map must be in the eye's depth buffer at the same position, because the omitted parts of the boundary
/// lie on it.
#[derive(Clone, Copy, Debug)]
pub struct DepthMap<'a> {
    /// A view of the depth aspect, or of the only aspect, of one layer. The texture has one mip level, one sample a texel, usage
    /// `TEXTURE_BINDING`, and one of these formats: `Depth16Unorm`, `Depth24Plus`, `Depth24PlusStencil8`, `Depth32Float`,
    /// `Depth32FloatStencil8`, `R32Float`. `R32Float` holds the depths that the others would hold;
    /// [`DepthMapConversion`](crate::gpu::depth_map::DepthMapConversion) makes such a map from distances.
    ///
    /// Row 0 is at the top, where y is 1 in clip space. Texels at the far end of the depths cast nothing: 0 with reversed
    /// depth, else 1. Values beyond the far end and NaN cast nothing, either. Values before the near end are at the near end.
    pub texture: &'a wgpu::TextureView,
    /// The camera that the map was made with, at the light. It may be orthographic, for a light at infinity.
    pub light: ShadowCamera,
    /// The number of an object for each texel. Edges between different objects are found, besides those of the method: this
    /// needs no threshold, and finds contacts such as a foot on the ground. It is a view of one layer of a texture of `R32Uint`
    /// with one mip level and usage `TEXTURE_BINDING`, which has the map's size. Numbers where the map is far do not matter.
    /// [`DepthMapMethod::EveryCell`] has all edges already.
    ///
    /// With objects as the only detector ([`DepthMapMethod::Differences`] with a `threshold` of 1) take a
    /// [`slope_bias`](DepthMapOptions::slope_bias) of 0. Steep sides of objects are left out then, and moved by its slope the
    /// boundary would leave the object behind, so that rays pass through the gap. Shadows of an object onto itself are missed, and
    /// turn light and shadow round along rays through the gaps.
    pub objects: Option<&'a wgpu::TextureView>,
}

impl<'a> DepthMap<'a> {
    /// A map without objects.
    pub fn new(texture: &'a wgpu::TextureView, light: ShadowCamera) -> Self {
        Self { texture, light, objects: None }
    }
}

/// Six depth maps around a light.
#[derive(Clone, Copy, Debug)]
pub struct DepthCubeMaps<'a> {
    /// Views as [`DepthMap::texture`]. A map that is not there casts nothing.
    pub textures: [Option<&'a wgpu::TextureView>; 6],
    /// The cameras that the maps were made with: those of [`DepthMapCube::cameras`](crate::gpu::depth_map::DepthMapCube::cameras), which
    /// may be turned all together.
    pub lights: [ShadowCamera; 6],
    /// Like [`DepthMap::objects`]: none, or one for each map that is there. A sample that maps share has the object of the
    /// map that its depth is from.
    pub objects: [Option<&'a wgpu::TextureView>; 6],
}

/// How shadows are found in a map: which edges between neighbouring samples are taken for edges of shadows, and how the
/// boundary is rebuilt there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DepthMapMethod {
    /// Every edge. Nothing is missed, and nothing needs a threshold. The surface has two triangles for each cell that is
    /// not far. Take it where what is in the map is not in the eye's depth buffer, for bodies thinner than a texel, for cloth and
    /// leaves, and where the eye's near plane cuts into bodies or the light is within one.
    EveryCell,
    /// Edges between depths that differ by more than twice either difference beside them in the same row or column, and
    /// four steps of the map's format; and those between a depth and nothing. So it needs no threshold, in any unit: a
    /// surface that goes on as it slopes has no edge within.
    ///
    /// It misses a step between slopes on both sides that are each at least half as large, such as that of equal stairs, each one
    /// texel wide. Bodies that are thinner than a texel may leave streaks, and open sheets may turn single pixels round.
    /// docs/measured.md has figures.
    Automatic {
        /// How edges are continued that dangle. `None`: they end.
        dangling: Option<DanglingEdges>,
    },
    /// Edges between depths that differ by more than `threshold`, and those between a depth and nothing. Where two surfaces are
    /// nearer to each other than that, as seen from the light, an edge of a shadow is missed. One missed edge can turn light and
    /// shadow round along all rays through the gap, in streaks. A threshold above the depth differences of steep surfaces has the
    /// same effect. Take it small: 0.0005 was right for scenes some ten metres across.
    Differences {
        /// In device depth, from 0 to 1. It is compared exactly. In a perspective map a step in device depth is larger in the
        /// world the farther away it is.
        threshold: f32,
        /// See [`Self::Automatic`].
        dangling: Option<DanglingEdges>,
    },
    /// Edges between depths that differ by more than `high`, those that differ by more than `low` and by more than both
    /// differences beside them in the same row or column (section 3.3 of the paper), and those between a depth and nothing.
    /// Slopes have no edges within. It misses the smaller of two steps side by side in one direction, both below `high`, and any
    /// step below `low`. Take 0.0005 and 0.05.
    SecondDifferences {
        /// In device depth, from 0 to `high`.
        low: f32,
        /// In device depth, from `low` to 1.
        high: f32,
        /// See [`Self::Automatic`].
        dangling: Option<DanglingEdges>,
    },
    /// Walls along rays of the light, over contours that are traced between the samples of a jump and fitted with
    /// segments. Fewer triangles, and smoother borders of shadows, which lie between the samples and not at the outer
    /// ones. After section 8.1 of the paper.
    ///
    /// A jump is a difference that exceeds the slopes on both sides by more than the threshold. Samples of which three lie on
    /// a plane have no jump. A jump of less than 16 thresholds does not count beside one that is more than half as large. No
    /// wall is drawn on a slope, so surfaces have no specks of their own shadow. Keep a `slope_bias` of 1.
    ///
    /// Rims whose last facets are narrower than a texel, rims that are close to the eye, and near rectangles within two texels of
    /// a rim may be wrong (docs/measured.md). Finding contours takes several times as long as finding cells.
    ///
    /// Cubes and pipelines of more than one bit are refused. Maps may have as many texels as a storage binding has words: up to
    /// 5,790² with default limits.
    Contours {
        /// In device depth, from 0 to 1.
        threshold: f32,
        /// How far a segment may be from the places that are found for the contour, in texels, from 0 to 0.5. It has each sample
        /// on its own side in any case. 0.1 is a good choice.
        sideways: f32,
        /// How far the ends of a wall may be from the surfaces that it joins, in device depth, from 0 to 1. A multiple of the
        /// threshold is a good choice: with more, walls are fewer, and rays may slip through where surfaces bend along a contour.
        depth: f32,
    },
}

impl Default for DepthMapMethod {
    /// Automatic, and no edge is continued.
    fn default() -> Self {
        Self::Automatic { dangling: None }
    }
}

/// How edges are continued that dangle. An edge dangles where it ends in a cell that has no other: a contact of two surfaces, or a
/// fold that ends. Lower thresholds hold there, cell by cell (section 3.2 of the paper). It costs two more words for 16 texels,
/// and a short pass for each cell. In a cube, an edge is not continued from one map into the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DanglingEdges {
    /// Part of the thresholds that is left there, from 0 to 1: of `threshold`, or `low`, or of a difference beside an edge where
    /// those count.
    pub share: f32,
    /// Cells by which an edge is continued at most, from 1 to 64.
    pub cells: u32,
}

impl Default for DanglingEdges {
    /// Half of the thresholds, and 8 cells.
    fn default() -> Self {
        Self { share: 0.5, cells: 8 }
    }
}

/// Options of [`DepthMapVolumes`](crate::gpu::depth_map::DepthMapVolumes).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMapOptions {
    /// How shadows are found.
    pub method: DepthMapMethod,
    /// Cells that the list has room for. `None`: every cell, or as many as fit one binding. If more are found, every cell is
    /// drawn, and the vertex shader decides again: slower, never wrong, and
    /// [`DepthMapFrame::statistics`](crate::gpu::depth_map::DepthMapFrame::statistics) tells. With contours, walls and flaps that the list
    /// has room for. `None`: a fourth of the cells, and at least 1,024.
    pub capacity: Option<u32>,
    /// How far the boundary moves away from the light where it slopes: in multiples of the depth difference over half a
    /// texel in each direction. 1 covers what a surface can deviate from the triangles between the samples while its slope
    /// is at most the one measured there. With less, steep surfaces may have specks of shadow. With more, shadows detach
    /// from what they touch. With contours it is at most 255.
    pub slope_bias: f32,
    /// A format that depths were rounded to before they came into the map, if it is coarser than the map's. `None`: the map's
    /// own. The boundary moves by four of its steps. Without it, a map of `R32Float` that was copied or merged from
    /// `Depth16Unorm` has specks of shadow.
    pub rounded_to: Option<wgpu::TextureFormat>,
    /// The quantity that [`DepthMapConversion`](crate::gpu::depth_map::DepthMapConversion) converted the map from. The boundary also
    /// moves by the error of the conversion. The map itself holds device depths. Without the right value, a map converted
    /// from distances may have specks of shadow, with reversed depth above all near the far plane.
    pub metric: DepthMetric,
    /// Whether near caps are left out where the near rectangle is in light as a whole. The image does not change.
    pub skip_near_caps: bool,
    /// Bytes that all buffers and textures together may take.
    pub memory_limit: Option<u64>,
}

impl Default for DepthMapOptions {
    /// The automatic method, room for all, a slope bias of 1, near caps where they matter, no limit of memory.
    fn default() -> Self {
        Self {
            method: DepthMapMethod::default(),
            capacity: None,
            slope_bias: 1.0,
            rounded_to: None,
            metric: DepthMetric::Device,
            skip_near_caps: true,
            memory_limit: None,
        }
    }
}

/// The largest slope bias that the stages of contours calculate with.
const MOST_SLOPE_BIAS: f32 = 255.0;

impl DepthMapOptions {
    /// Whether volumes can be made with them.
    pub(super) fn check(&self) -> Result<(), DepthMapError> {
        use DepthMapMethod::{Automatic, Contours, Differences, EveryCell, SecondDifferences};
        let taken = |name, given: f32, is_taken: bool, range| {
            if is_taken { Ok(()) } else { Err(DepthMapError::Option { name, given, range }) }
        };
        let of_depth = |name, given| taken(name, given, (0.0..=1.0).contains(&given), "a device depth from 0 to 1");
        match self.method {
            EveryCell | Automatic { .. } => {}
            Differences { threshold, .. } => of_depth("threshold", threshold)?,
            SecondDifferences { low, high, .. } => {
                of_depth("high", high)?;
                taken("low", low, (0.0..=high).contains(&low), "a device depth from 0 to `high`")?;
            }
            Contours { threshold, sideways, depth } => {
                of_depth("threshold", threshold)?;
                of_depth("depth", depth)?;
                taken("sideways", sideways, (0.0..=0.5).contains(&sideways), "0 to 0.5 texels")?;
                taken("slope_bias", self.slope_bias, self.slope_bias <= MOST_SLOPE_BIAS, "at most 255 with contours")?;
            }
        }
        if let Some(DanglingEdges { share, cells }) = self.method.dangling() {
            taken("share", share, (0.0..=1.0).contains(&share), "a share from 0 to 1")?;
            taken("cells", cells as f32, (1..=64).contains(&cells), "1 to 64 cells")?;
        }
        let is_bias = self.slope_bias.is_finite() && self.slope_bias >= 0.0;
        taken("slope_bias", self.slope_bias, is_bias, "a finite number that is not negative")?;
        match self.rounded_to {
            Some(format) if !MAP_FORMATS.contains(&format) => Err(DepthMapError::RoundedTo(format)),
            _ => Ok(()),
        }
    }
}

impl DepthMapMethod {
    pub(super) fn dangling(self) -> Option<DanglingEdges> {
        match self {
            Self::Automatic { dangling }
            | Self::Differences { dangling, .. }
            | Self::SecondDifferences { dangling, .. } => dangling,
            Self::EveryCell | Self::Contours { .. } => None,
        }
    }
}
