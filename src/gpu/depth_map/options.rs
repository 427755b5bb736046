//! The input of volumes from depth maps, and their options.

use super::error::DepthMapError;
use super::metric::DepthMetric;
use super::texture::MAP_FORMATS;
use crate::ShadowCamera;

/// A depth map: what a light sees.
///
/// Everything in the map must be in the eye's depth buffer at the same position, because the omitted parts of the
/// boundary lie on it.
///
/// To detect edges by [`objects`](Self::objects) alone, take [`DepthMapMethod::Differences`] with a `threshold` of 1
/// and a [`slope_bias`](DepthMapOptions::slope_bias) of 0. With a larger bias, the boundary leaves steep sides of
/// objects, and rays pass through the gap. An object then casts no shadow onto itself, which swaps light and shadow
/// along rays through the gap.
#[derive(Clone, Copy, Debug)]
pub struct DepthMap<'a> {
    /// A view of one layer, of its depth aspect or its only one: one mip level, one sample a texel, usage
    /// `TEXTURE_BINDING`. Its format is `Depth16Unorm`, `Depth24Plus`, `Depth24PlusStencil8`, `Depth32Float`,
    /// `Depth32FloatStencil8`, or `R32Float` with the depths that these would hold
    /// ([`DepthMapTexture`](crate::gpu::depth_map::DepthMapTexture) is such a map of distances, or of two maps). Row 0 is at
    /// the top, where y is 1 in clip space. NaN and depths at the far end or beyond cast nothing (the far end is 0 with
    /// reversed depth, else 1), and depths before the near end count as depths at it.
    pub texture: &'a wgpu::TextureView,
    /// The camera that the map was made with, at the light. It is orthographic for a light at infinity.
    pub light: ShadowCamera,
    /// The index of an object for each texel: edges between different objects are found beside those of the method. It
    /// is a view of one layer of an `R32Uint` texture of the map's size, with one mip level and usage
    /// `TEXTURE_BINDING`. Default: `None`; set it to find contacts, such as a foot on the ground, without a threshold.
    /// Indices of texels that cast nothing are ignored, and [`DepthMapMethod::EveryCell`] ignores all, because it has
    /// every edge.
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
    /// Views like [`DepthMap::texture`]. A missing map casts nothing.
    pub textures: [Option<&'a wgpu::TextureView>; 6],
    /// The cameras that the maps were made with: those of
    /// [`DepthMapCube::cameras`](crate::gpu::depth_map::DepthMapCube::cameras), or all of them rotated together.
    pub lights: [ShadowCamera; 6],
    /// Views like [`DepthMap::objects`]: none, or one for each map that is not missing. A sample that several maps share has
    /// the object of the map with the nearest depth.
    pub objects: [Option<&'a wgpu::TextureView>; 6],
}

/// How shadows are found in a map: which edges between neighbouring samples are edges of shadows, and how the boundary is
/// rebuilt there. A missed edge can swap light and shadow along all rays through the gap, in streaks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DepthMapMethod {
    /// Every edge. It misses nothing and needs no threshold, but draws two triangles for each cell that is not far. Take it
    /// for casters that are not in the eye's depth buffer, for bodies thinner than a texel, and for cloth and leaves. Take
    /// it also where the eye's near plane cuts into bodies, or the light is within one.
    EveryCell,
    /// Edges between a depth and nothing, and edges whose depth difference exceeds twice the smaller one beside it in the
    /// same row or column by more than four steps of the map's format, where one that goes the other way, or to nothing, is
    /// 0. It needs no threshold, and a surface that goes on at its slope has no edge. It misses steps between steep slopes,
    /// such as equal stairs that are one texel wide. Bodies thinner than a texel may leave streaks, and open sheets may swap
    /// single pixels (docs/measured.md).
    Automatic {
        /// How dangling edges are continued. Default: `None`, they end.
        dangling: Option<DanglingEdges>,
    },
    /// Edges between a depth and nothing, and edges whose depth difference exceeds `threshold`. It misses edges of shadows
    /// between surfaces that are nearer to each other than that, as seen from the light, and edges on steep surfaces.
    Differences {
        /// In device depth, from 0 to 1, compared exactly. In a perspective map, a step in device depth is larger in the
        /// world the farther away it is. Take it small: 0.0005 suits scenes some ten metres across.
        threshold: f32,
        /// See [`Self::Automatic`].
        dangling: Option<DanglingEdges>,
    },
    /// Edges between a depth and nothing, and edges whose depth difference exceeds `high`, or exceeds `low` and both
    /// differences beside it in the same row or column (section 3.3 of the paper). Slopes have no edges. It misses steps
    /// below `low`, and the smaller of two neighbouring steps in one direction that are both below `high`.
    SecondDifferences {
        /// In device depth, from 0 to `high`. Take 0.0005 for scenes some ten metres across.
        low: f32,
        /// In device depth, from `low` to 1. Take 0.05 for scenes some ten metres across.
        high: f32,
        /// See [`Self::Automatic`].
        dangling: Option<DanglingEdges>,
    },
    /// Walls along rays of the light, over contours that are traced between the samples of a jump and fitted with
    /// segments (section 8.1 of the paper). They have fewer triangles and smoother borders than cells, and take several
    /// times as long to find. Shadows may be wrong at rims whose last facets are narrower than a texel, at rims close
    /// to the eye, and where the near rectangle is within two texels of a rim (docs/measured.md). Keep a `slope_bias`
    /// of 1; cubes, pipelines of more than one bit, and maps with more texels than a storage binding has words (5,790²
    /// with default limits) are refused.
    Contours {
        /// In device depth, from 0 to 1. A jump is a difference that exceeds the slopes on both sides by more than this. A
        /// difference below 16 thresholds is no jump beside one that is more than half as large.
        threshold: f32,
        /// How far a segment may be from the crossings that it is fitted to, in texels, from 0 to 0.5. Samples stay on their
        /// side of the segment with any value. Take 0.1.
        sideways: f32,
        /// How far the ends of a wall may be from the surfaces that it joins, in device depth, from 0 to 1. Take a multiple
        /// of the threshold. A larger value makes fewer walls, but rays may pass where surfaces bend along a contour.
        depth: f32,
    },
}

impl Default for DepthMapMethod {
    /// Automatic, and no edge is continued.
    fn default() -> Self {
        Self::Automatic { dangling: None }
    }
}

/// How dangling edges are continued: lower thresholds hold at their ends, cell by cell (section 3.2 of the paper). An edge
/// dangles where it ends in a cell that has no other edge, such as at a contact of two surfaces, or where a fold ends. It
/// costs two words for 16 texels, with [`DepthMapMethod::Differences`] four, and a short pass for each cell. In a cube, no
/// edge is continued from one map into the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DanglingEdges {
    /// Factor of the thresholds at the end of an edge, from 0 to 1. By the method, thresholds are `threshold`, or `low` and
    /// the differences beside an edge, or these differences alone; `high` stays. Default: 0.5. A lower one continues more
    /// edges.
    pub share: f32,
    /// Cells by which an edge is continued at most, from 1 to 64. Default: 8. Each costs a pass.
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
    /// How shadows are found. Default: [`DepthMapMethod::Automatic`].
    pub method: DepthMapMethod,
    /// Cells that the list has room for; with contours, walls and flaps. Default: `None`, every cell or as many as fit
    /// one binding; with contours, a fourth of the cells and at least 1,024. If the list overflows, every cell is
    /// drawn, which is slower: for methods that look beside an edge or continue edges with the shadows of
    /// [`DepthMapMethod::EveryCell`], for contours with those of [`DepthMapMethod::Differences`] with the same
    /// threshold. Lower it to save memory, by what
    /// [`DepthMapFrame::statistics`](crate::gpu::depth_map::DepthMapFrame::statistics) counts.
    pub capacity: Option<u32>,
    /// How far the boundary moves away from the light on slopes, in multiples of the depth difference over half a texel in
    /// each direction; with contours at most 255. Default: 1, which covers surfaces that are nowhere steeper than between
    /// their samples. A lower value may leave specks of shadow on steep surfaces. A higher value detaches shadows from what
    /// they touch.
    pub slope_bias: f32,
    /// A coarser format that depths were rounded to before they came into the map. Default: `None`, the map's own format.
    /// The boundary moves by four of its steps. Set it for a map of `R32Float` that was copied or merged from
    /// `Depth16Unorm`, which has specks of shadow otherwise.
    pub rounded_to: Option<wgpu::TextureFormat>,
    /// The quantity that [`DepthMapTexture`](crate::gpu::depth_map::DepthMapTexture) converted the map from. Default:
    /// [`DepthMetric::Device`], not converted. The boundary moves by the error of the conversion. Set it for a map converted
    /// from distances, which may have specks of shadow otherwise, with reversed depth above all near the far plane.
    pub metric: DepthMetric,
    /// Whether near caps are skipped where the whole near rectangle is lit, which changes no image: for measuring.
    #[doc(hidden)]
    pub skip_near_caps: bool,
    /// Bytes that all buffers and textures together may have. Default: `None`, no limit. Making more is a [`DepthMapError`].
    pub memory_limit: Option<u64>,
}

impl Default for DepthMapOptions {
    /// See the fields.
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

/// The largest slope bias of the stages of contours.
const MAX_SLOPE_BIAS: f32 = 255.0;

impl DepthMapOptions {
    /// Refuses options that volumes cannot be made with.
    pub(super) fn check(&self) -> Result<(), DepthMapError> {
        use DepthMapMethod::{Automatic, Contours, Differences, EveryCell, SecondDifferences};
        let check = |name, given: f32, is_allowed: bool, range| {
            if is_allowed { Ok(()) } else { Err(DepthMapError::Option { name, given, range }) }
        };
        let check_depth = |name, given| check(name, given, (0.0..=1.0).contains(&given), "a device depth from 0 to 1");
        match self.method {
            EveryCell | Automatic { .. } => {}
            Differences { threshold, .. } => check_depth("threshold", threshold)?,
            SecondDifferences { low, high, .. } => {
                check_depth("high", high)?;
                check("low", low, (0.0..=high).contains(&low), "a device depth from 0 to `high`")?;
            }
            Contours { threshold, sideways, depth } => {
                check_depth("threshold", threshold)?;
                check_depth("depth", depth)?;
                check("sideways", sideways, (0.0..=0.5).contains(&sideways), "0 to 0.5 texels")?;
                check("slope_bias", self.slope_bias, self.slope_bias <= MAX_SLOPE_BIAS, "at most 255 with contours")?;
            }
        }
        if let Some(DanglingEdges { share, cells }) = self.method.dangling() {
            check("share", share, (0.0..=1.0).contains(&share), "a share from 0 to 1")?;
            check("cells", cells as f32, (1..=64).contains(&cells), "1 to 64 cells")?;
        }
        let is_bias = self.slope_bias.is_finite() && self.slope_bias >= 0.0;
        check("slope_bias", self.slope_bias, is_bias, "a finite number that is not negative")?;
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
