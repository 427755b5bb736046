//! What volumes are rebuilt from, and how.

use super::metric::DepthMetric;
use crate::ShadowCamera;

/// A depth map: what a light sees.
///
/// What is in the map must be in the eye's depth buffer at the same place, because the parts of the boundary that are left
/// out lie on it.
#[derive(Clone, Copy, Debug)]
pub struct DepthMap<'a> {
    /// A view of the depth aspect, or of the only aspect, of one layer. The texture has one mip level, one sample a texel, usage
    /// `TEXTURE_BINDING`, and one of these formats: `Depth16Unorm`, `Depth24Plus`, `Depth24PlusStencil8`, `Depth32Float`,
    /// `Depth32FloatStencil8`, `R32Float`. `R32Float` holds the depths that the others would hold;
    /// [`DepthMapConversion`](crate::gpu::DepthMapConversion) makes such a map from distances.
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
    /// not far. Take it where what is in the map is not in the eye's depth buffer, where bodies are thinner than a texel, and with
    /// [`DepthMapPipelines::counting`](crate::gpu::DepthMapPipelines::counting).
    EveryCell,
    /// Those between depths that differ by more than `threshold`, and those between a depth and nothing. Far fewer
    /// triangles, but where two surfaces are nearer to each other than that, as seen from the light, an edge of a shadow is
    /// missed. One missed edge can turn light and shadow round along all rays through the gap, in streaks. A threshold above the
    /// depth differences of steep surfaces has the same effect. Take it small: 0.0005 was right for scenes some ten metres
    /// across. But on slanted planes that leaves out few cells, so [`Self::Automatic`] has fewer triangles there.
    Differences {
        /// In device depth, from 0 to 1. It is compared exactly. In a perspective map a step in device depth is larger in the
        /// world the farther away it is.
        threshold: f32,
    },
    /// Those between samples whose distances from the light, along the direction that the map looks in, differ by more than
    /// `threshold`, and those between a depth and nothing. As [`Self::Differences`], but the step is the same near and far. A
    /// shadow of something that is nearer than `threshold` to what is behind it is missed, and may turn light and shadow round.
    /// Far away from the light the map's own steps can be larger than `threshold`: then every cell there is drawn.
    WorldDifferences {
        /// In units of the scene, not negative. The map's camera and this number are rounded once, to three floats; these are
        /// compared exactly.
        threshold: f32,
    },
    /// Those between a depth and nothing. Fewer triangles still. What casts must then hang freely before nothing, or the edges of
    /// objects must be taken, too ([`DepthMapOptions::objects`]).
    Outlines,
    /// Those between depths that differ by more than `high`, those that differ by more than `low` and by more than both
    /// differences beside them in the same row or column (section 3.3 of the paper), and those between a depth and nothing.
    /// Slopes have no edges within, so steep surfaces are left out. Beside marked edges, triangles are drawn for one more
    /// edge: moved by its slope, a steep surface then stays within its body. What is lost: of two steps side by side in one
    /// direction, both below `high`, the smaller, and any below `low`. Bodies that are thinner than a texel may leave
    /// streaks. 0.0005 and 0.05 had 1 wrong pixel of 995,350 (168 views of maps of 96² texels), and with
    /// [`DepthMapOptions::dangling`] none.
    /// Differences count that are larger by more than the map's precision.
    SecondDifferences {
        /// In device depth, from 0 to `high`.
        low: f32,
        /// In device depth, from `low` to 1.
        high: f32,
    },
    /// Those between depths that differ by more than twice either difference beside them in the same row or column, and
    /// four steps of the map's format; and those between a depth and nothing. So it needs no threshold, in any unit: a
    /// surface that goes on as it slopes has no edge within. Beside marked edges, triangles are drawn for one more edge, as
    /// with [`Self::SecondDifferences`]. In the trials it was as right as [`Self::EveryCell`] (none of 995,350 pixels was wrong in
    /// either), with a fifth of its triangles.
    /// Open sheets may turn single pixels round that the eye sees past their rims, along rays that graze a sheet from behind: 34 of
    /// 6.4 million with maps of 1,024² texels, and 47 of 968,394 pixels of open ground with maps of 256². Take [`Self::EveryCell`]
    /// for cloth and leaves where that matters: it had none.
    /// What is lost: a step between slopes on both sides that are each at least half as large, such as that of equal stairs,
    /// each one texel wide. Bodies that are thinner than a texel may leave streaks. Take [`Self::EveryCell`] where the eye's near
    /// plane cuts into bodies, or where the light is within one or shines into it through holes, so that it sees a shell from
    /// within: docs/measured.md has such scenes, in which 163 of 3,226,556 pixels were wrong, and none with every cell.
    #[default]
    Automatic,
}

/// How edges are continued that dangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DanglingEdges {
    /// Part of the detector's thresholds that is left there, from 0 to 1: of `threshold`, or `low`, of a difference beside an
    /// edge where those count, and of all device depths with [`DepthEdges::Outlines`], where it has to be small.
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

/// How the boundary is rebuilt between the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum DepthMapReconstruction {
    /// Each cell by the triangles between its samples that have a marked edge: half a cell where a single edge is marked. After
    /// section 4 of the paper, its table.
    #[default]
    Triangles,
    /// Each cell that has a marked edge as a whole, by both of its triangles: the fixed mesh of section 4 of the paper. It has
    /// more triangles than [`Self::Triangles`]. Shadows are the same, but beside edges that a detector misses: where an edge
    /// dangles, it is continued by the whole cell.
    FixedMesh,
    /// By walls along rays of the light, over contours that are traced between the samples of a jump and fitted with
    /// segments. Fewer triangles, and smoother borders of shadows, which lie between the samples and not at the outer
    /// ones. After section 8.1 of the paper.
    ///
    /// It takes [`DepthEdges::Differences`], or [`DepthEdges::Outlines`] where the map is far behind what casts. Of the
    /// differences above the threshold it takes jumps alone: those that are more than the threshold larger than the slopes
    /// to both sides tell, but not where three samples lie on a plane. A jump of less than 16 thresholds does not count
    /// beside one that is more than half as large. No wall is drawn on a slope, so surfaces have no specks of their own
    /// shadow.
    ///
    /// In the trials it was wrong at 0.30 to 0.40 times as many pixels as triangles, and at 0.44 to 0.62 times as many as a
    /// lookup in the same map with a bias; on what is behind the caster at 0.32 to 0.45 times. But farther than a texel from
    /// borders it was wrong at 31 to 100 pixels in a million (docs/measured.md), where triangles were at none: at rims whose
    /// last facets are narrower than a texel. Round rims are found to a fortieth of a texel. A straight border along the rows
    /// or columns of a map is found no better than a lookup does: turn a light's camera so that few are. Keep a `slope_bias`
    /// of 1. Within two texels of a rim, a near rectangle that is no farther than `depth` from a surface may be told wrongly
    /// (docs/numerics/contours.md, "Heights"). Finding contours takes 3 to 9 times as long as finding cells with
    /// [`DepthEdges::Automatic`] in a map of 2,048², and up to 40 times in one of 256², on a software device.
    ///
    /// Close to the eye, rims of facets show specks of shadow with any threshold: 122 to 137 pixels in one trial.
    ///
    /// Maps of a cube, more than one bit, and edges that are continued are refused with contours, and so are draws by pipelines that
    /// count. Maps may have as many texels as a storage binding has words: up to 5,790² with default limits.
    Contours {
        /// How far a segment may be from the places that are found for the contour, in texels, from 0 to 0.5. It has each sample
        /// on its own side in any case. 0.1 is a good choice.
        sideways: f32,
        /// How far the ends of a wall may be from the surfaces that it joins, in device depth, from 0 to 1. A multiple of the
        /// edges' threshold is a good choice: with more, walls are fewer, and rays may slip through where surfaces bend along a
        /// contour.
        depth: f32,
    },
}

/// Options of [`DepthMapVolumes`](crate::gpu::DepthMapVolumes).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMapOptions {
    /// Which edges are taken.
    pub edges: DepthEdges,
    /// Whether edges between different objects are taken, besides those of `edges`. The objects are given to
    /// [`DepthMapVolumes::encode_objects`](crate::gpu::DepthMapVolumes::encode_objects). [`DepthEdges::EveryCell`] takes all
    /// edges already, and is refused with it. This needs no threshold, and finds contacts such as a foot on the ground. With
    /// [`DepthEdges::Outlines`], shadows that an object casts onto itself are missed, and light and shadow are turned round along
    /// rays through the gaps. Steep sides of objects are left out then, so take a `slope_bias` of 0 with outlines: moved by their
    /// slope, they would leave the object behind, and rays would pass through the gap. Other detectors keep a bias of 1.
    pub objects: bool,
    /// How the boundary is rebuilt.
    pub reconstruction: DepthMapReconstruction,
    /// Whether edges that dangle are continued, and how. An edge dangles where it ends in a cell that has no other: a contact
    /// of two surfaces, or a fold that ends. Lower thresholds hold there, cell by cell (section 3.2 of the paper). It costs two
    /// more words for 16 texels, and a short pass for each cell. `None`: they end, after one more cell. In a cube, an edge is not
    /// continued from one map into the next. [`DepthEdges::EveryCell`] has none that dangles, and contours continue none: both
    /// are refused with it.
    pub dangling: Option<DanglingEdges>,
    /// Cells that the list has room for. `None`: every cell, or as many as fit one binding. If more are found, every cell is
    /// drawn, and the vertex shader decides again: slower, never wrong, and
    /// [`DepthMapFrame::statistics`](crate::gpu::DepthMapFrame::statistics) tells. With contours, walls and flaps that the list
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
    /// What the map was converted from by [`DepthMapConversion`](crate::gpu::DepthMapConversion): the boundary moves by what the
    /// conversion may be off, besides. The map itself holds device depths. Left at [`DepthMetric::Device`], a map that was
    /// converted from distances may have specks of shadow, with reversed depth above all near the far plane.
    pub metric: DepthMetric,
    /// Bits of the stencil that take the boundary, from 1 to 8: the pipelines'
    /// ([`DepthMapPipelines::antialiased`](crate::gpu::DepthMapPipelines::antialiased)). With more than one, each takes the
    /// boundary moved sideways by another part of a texel, so that borders of shadows have as many levels of grey, and one more.
    /// The surface moves away from the light by up to as much again, and volumes are drawn as often. After section 8.3 of the
    /// paper.
    pub bits: u32,
    /// Whether near caps are left out where the near rectangle is in light as a whole: see
    /// [`DepthMapFrame::near_cap`](crate::gpu::DepthMapFrame::near_cap). No picture is another.
    pub skip_near_caps: bool,
    /// Bytes that all buffers and textures together may take.
    pub memory_limit: Option<u64>,
}

impl Default for DepthMapOptions {
    /// Automatic edges, no objects, triangles, no edges continued, room for all, a slope bias of 1, one bit, near caps where they
    /// matter, no limit of memory.
    fn default() -> Self {
        Self {
            edges: DepthEdges::Automatic,
            objects: false,
            reconstruction: DepthMapReconstruction::Triangles,
            dangling: None,
            capacity: None,
            slope_bias: 1.0,
            rounded_to: None,
            metric: DepthMetric::Device,
            bits: 1,
            skip_near_caps: true,
            memory_limit: None,
        }
    }
}
