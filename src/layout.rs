//! Structs that Rust and WGSL share. The WGSL says what fields mean that have no doc here. A test reads it through naga and
//! compares every name, size, offset and type.

#![allow(missing_docs, reason = "fields that callers do not see are documented in the WGSL")]

use bytemuck::{Pod, Zeroable};

/// A field of a [`StructLayout`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    pub name: &'static str,
    /// Bytes from the start of the struct.
    pub offset: usize,
    pub size: usize,
    /// The type as Rust writes it.
    pub rust_type: &'static str,
}

/// The memory layout of a shared struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    pub name: &'static str,
    /// Size in an array, in bytes.
    pub size: usize,
    pub fields: &'static [FieldLayout],
}

/// Slots of a chunk of a scene. Smaller chunks are slower; larger ones leave more slots empty, which costs
/// memory and no time.
pub const CHUNK: u32 = 64;
/// Invocations that share a chunk, in facing and edges. Each takes slots in turn, so it looks up their caster once.
pub const LANES: u32 = 8;

/// A caster whose mesh has no clusters.
pub const NO_CLUSTERS: u32 = u32::MAX;
/// Words of a listed chunk of faces: the chunk, the bits of the lights that are decided for all of its faces, those of them
/// that the faces face, and the index mask (wgsl/interface/caster.wgsl) of lights to test: all ones if none is decided.
pub const FACE_ENTRY: u32 = 4;

/// Flags of a [`SceneCaster`].
#[cfg(feature = "gpu")]
pub(crate) mod caster_flags {
    /// The caster is closed and consistently oriented.
    pub(crate) const CLOSED: u32 = 1;
    pub(crate) const MIRRORED: u32 = 2;
    pub(crate) const RIGID: u32 = 4;
    /// The caster is rigid, and a face with three different vertices has one that is not finite.
    pub(crate) const NON_FINITE: u32 = 8;
    /// Faces are excluded, by the caller or as occluded faces.
    pub(crate) const EXCLUDES: u32 = 16;
    /// Its bits are computed in each encode: its positions may have changed, or it has polygons.
    pub(crate) const UNCACHED: u32 = 32;
    /// A caster of the group has [`EXCLUDES`].
    pub(crate) const GROUP_EXCLUDES: u32 = 64;
    /// The caster is not in the depth buffer.
    pub(crate) const PROXY: u32 = 128;
    /// The caster is deforming, and its box in world space is known: from the caller or a pose.
    pub(crate) const BOUNDED: u32 = 256;
}

/// Declares `#[repr(C)]` structs and lists their layouts in [`LAYOUTS`]. Fields that follow each other share the name of
/// their type.
macro_rules! shared_structs {
    ($($(#[$doc:meta])* struct $name:ident {
        $($(#[$field_doc:meta])* $field:ident $(, $next:ident)*: $type:ty;)*
    })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
            #[repr(C)]
            pub struct $name { $($(#[$field_doc])* pub $field: $type, $(pub $next: $type,)*)* }
        )*

        /// Every struct shared with WGSL.
        pub const LAYOUTS: &[StructLayout] = &[$(StructLayout {
            name: stringify!($name),
            size: size_of::<$name>(),
            fields: &[$(
                field!($name, $field, $type),
                $(field!($name, $next, $type),)*
            )*],
        },)*];
    };
}

/// The layout of a field.
macro_rules! field {
    ($name:ident, $field:ident, $type:ty) => {
        FieldLayout {
            name: stringify!($field),
            offset: std::mem::offset_of!($name, $field),
            size: size_of::<$type>(),
            rust_type: stringify!($type),
        }
    };
}

shared_structs! {
    /// A batch of up to 32 lights, and the layout of the positions.
    struct LightBatch {
        lights: [[f32; 4]; 32];
        light_bits: [[u32; 4]; 32];
        inexact_w: [[f32; 4]; 8];
        magnitudes: [f32; 2];
        count, active_bits, position_offset, position_stride, reserved_0, reserved_1: u32;
    }

    /// The range of faces or edges of one dispatch.
    struct Chunk {
        first, count, first_light, capacity, blocks, twisted_offset: u32;
    }

    /// The sizes for turning counts of edges into draws.
    struct DrawShape {
        lights, capacity, edges, vertices_per_edge: u32;
    }

    /// The bits of an edge record, one for each light of a batch.
    struct EdgeMasks {
        /// Set if the edge is a silhouette edge.
        silhouette: u32;
        /// Set if face 0 faces the light. If face 0 is twisted, it is the bit of face 1, inverted for a consistent record.
        winding: u32;
    }

    /// Statistics of an extraction.
    struct ExtractionStatistics {
        /// Faces with an infinite or NaN vertex. They face no light. Here and below a polygon counts as a face.
        non_finite_faces: u32;
        /// Lists that overflowed. The draws of their lights go over all edges.
        overflowed_lists: u32;
        /// Pairs of face and light that the filter left to exact arithmetic.
        undecided_pairs: u32;
        /// The undecided pairs whose determinant is exactly zero.
        exact_zeros: u32;
        /// A bit for each light for which a polygon is twisted. Lights whose numbers differ by 32 share a bit.
        twisted_lights: u32;
    }

    /// The arguments that wgpu's `draw_indirect` reads.
    struct DrawArguments {
        /// Vertices of an instance.
        vertex_count: u32;
        /// Instances: silhouette edges, or all edges if the list overflowed.
        instance_count: u32;
        /// 0.
        first_vertex: u32;
        /// 0.
        first_instance: u32;
    }

    /// Up to thirty-two faces and their box. The box holds the faces that count: those that are finite and name three
    /// different vertices. Entries without a face name vertex 0 three times.
    struct FaceCluster {
        low, high, group_low, group_high: [u32; 4];
        corners: [u32; 96];
        continues, head, first_face, padding: u32;
    }

    /// The points of one dispatch of a query of occluder counts.
    struct PointChunk {
        count, offset, stride, lights, first_light, on_face: u32;
    }

    /// The clusters of faces that one dispatch goes over.
    struct FaceRange {
        first, end, is_first, before: u32;
    }

    /// The undecided faces of a pair of point and light.
    struct UndecidedFaces {
        state, face_0, face_1, face_2, recount: u32;
    }

    /// A dispatch of the deform stage.
    struct DeformDispatch {
        workgroups, displaced: u32;
        time: f32;
        instances: u32;
    }

    /// A range of vertices of one instance, for whole workgroups. Words count from where the dispatch binds the arrays.
    struct DeformChunk {
        first_workgroup, count, rest, morph, skin, sources, positions, palette, targets, target_count, skinned,
        before: u32;
    }

    /// The part of a batch of lights that the WGSL include reads.
    struct RimlineInfo {
        edges, capacity, first_light, lights, position_offset, position_stride, twisted_offset, vertices_per_edge: u32;
    }

    /// A caster in the table of casters. Slots are indices in the masks of its group; other indices count in the bound
    /// buffers.
    struct SceneCaster {
        row_0, row_1, row_2: [f32; 4];
        low: [f32; 3];
        scale: f32;
        high: [f32; 3];
        flags, first_face_slot, faces, first_face, position_offset, first_edge_slot, edges, first_edge, position_stride,
        version, group, first_caster, clusters_or_deforming_index: u32;
    }

    /// The input of the stage that finds the deforming casters that a frame needs.
    struct NeedsDispatch {
        casters, views, lights, parts, all, cull_by_range, cull_by_view, reserved: u32;
    }

    /// The lights of a caster of a scene in a batch.
    struct CasterLights {
        allowed, first: u32;
        magnitudes: [f32; 2];
    }

    /// A dispatch over a group of casters for a batch of lights.
    struct SceneDispatch {
        casters, batches, batch, lists_offset, lights_offset, ranges_offset, face_chunks_offset, edge_chunks_offset,
        face_chunks, edge_chunks, work_count, face_work, edge_work, capacity, structure, uses_cache, clusters_offset,
        occluders_offset, occluders, world_lights_offset: u32;
    }

    /// Counts of an encode of a scene.
    struct SceneStatistics {
        /// Relevant pairs of caster and light: the light is allowed and culled by none of the rules below.
        pairs: u32;
        /// The relevant pairs whose facing bits an earlier encode cached.
        cached_pairs: u32;
        /// Pairs of caster and allowed light that are culled by the light's range or cone, except those of `culled_casters`.
        pairs_culled_by_range: u32;
        /// Pairs of caster and light that are culled by an occluder between them.
        pairs_culled_by_occluders: u32;
        /// Faces that were tested, for each batch of 32 lights.
        faces: u32;
        /// Edge records that were tested, for each batch of 32 lights.
        edges: u32;
        /// Faces that were not tested, because the whole cluster is decided for each active light.
        untested_faces: u32;
        /// Edge records that were not tested, because their clusters have no silhouette edge.
        untested_edges: u32;
        /// Instances of models that the frame does not need, so they were not deformed:
        /// [`Scene::insert_model`](crate::gpu::Scene::insert_model).
        culled_casters: u32;
    }

    /// A camera, as a caster sees it. The camera's frame has the world's axes and the camera's origin at 0.
    struct ShadowView {
        view_projection: [[f32; 4]; 4];
        near_plane: [f32; 4];
        placement: [[f32; 4]; 3];
        near_min: [f32; 3];
        near_w: f32;
        near_max: [f32; 3];
        near_z: f32;
    }

    /// A light, and what the GPU chose for it and a caster.
    struct ShadowLight {
        light, clip: [f32; 4];
        height, range: f32;
        casting, counting: u32;
        frustum_near, end: f32;
        excludes: u32;
        scale: f32;
        frustum_x, frustum_y, frustum_w: [f32; 4];
    }

    /// A light and a camera, with 512 bytes: bindings begin at multiples of 256.
    struct ViewLight {
        view: ShadowView;
        light: ShadowLight;
        version: [u32; 4];
        cone: LightCone;
        reserved: [[u32; 4]; 12];
    }

    /// The cone of a spot light, in world space.
    struct LightCone {
        apex, axis: [f32; 4];
    }

    /// The receivers of a view.
    struct ReceiverView {
        inverse: [[f32; 4]; 4];
        near_min: [f32; 3];
        near_z: f32;
        near_max: [f32; 3];
        sky_receives: u32;
        pixels: [u32; 2];
        offset, reserved: u32;
    }

    /// A depth map, and how its edges are found.
    struct DepthMapShape {
        size: [u32; 2];
        cells, blocks, capacity, every_cell, threshold, is_reversed, faces, has_objects, spread, unused: u32;
    }

    /// How the contours of a depth map are traced and fitted. Distances count from the near plane on, in units of 2⁻²⁹ of the
    /// range of device depths.
    struct ContourShape {
        tiles: [u32; 2];
        words, capacity: u32;
        threshold, certain_threshold, sideways, tolerance: i32;
        shift: u32;
        slope_bias, noise_share, noise_constant: i32;
    }

    /// The rule that marks edges of a depth map. The second value of `low_thresholds` and of `slopes` applies next to the
    /// end of a marked edge.
    struct DepthEdgeRule {
        words: [u32; 2];
        blocks, high_threshold: u32;
        low_thresholds, slopes: [u32; 2];
        noise, noise_exponents: u32;
    }

    /// The samples of a depth map whose surfaces may be before the near rectangle of a camera.
    struct DepthNearBox {
        first, size: [u32; 2];
        key: u32;
        distance: i32;
        unused: [u32; 2];
    }

    /// How distances become the device depths of a depth map.
    struct DepthMetricView {
        across, down, middle: [f32; 4];
        far, far_remainder, has_far, scale, min_distance, max_distance: f32;
        metric, is_parallel: u32;
    }

    /// A depth map as a camera sees it. A position on the lattice is twice the distance from its middle.
    struct DepthMapView {
        across, down, depth, middle, far_across, far_down, far_middle, near_across, near_up, near_middle, infinity,
        bias: [f32; 4];
    }

    /// The light of a depth map that meshes are drawn into.
    struct MeshDepthView {
        columns: [[f32; 4]; 4];
    }

    /// A mesh that is drawn into a depth map.
    struct MeshDepthCaster {
        row_0, row_1, row_2: [f32; 4];
        position_offset, position_stride, first_face, face_count: u32;
    }

    /// Camera and style of outlines.
    struct OutlineView {
        columns: [[f32; 4]; 4];
        origin: [f32; 3];
        half_width: f32;
        silhouette, boundary, crease, marked: [f32; 4];
        size: [f32; 2];
        depth_bias, crease_cosine: f32;
        light, classes, is_reversed, reserved: u32;
    }

    /// A group of a scene's casters and a light, whose outlines are drawn.
    struct OutlinedGroup {
        edge_chunks_offset, relevant_lights_offset, capacity, twisted_offset, bit, reserved_0, reserved_1,
        reserved_2: u32;
    }

    /// Casters that are drawn together, and the caller's options for their volumes.
    struct ShadowShape {
        casters, lights, batches, faces, edges, capacity, side_capacity, near_capacity, far_capacity, allow_back_facing,
        counting, cull_by_range, cull_by_view, end_at_range, choices_offset, measures_offset, lights_offset,
        face_chunks_offset, edge_chunks_offset, views, count_batches, proxies, group_and_batch, first_caster,
        lists_offset, uses_cache, needs_boxes, used_lights, has_receivers, largest_count, piece_capacity: u32;
    }

    /// The light, or the batch of lights, of a draw or dispatch.
    struct ShadowDraw {
        light, first_light, view, count_batch: u32;
    }

    /// The draws of one light's shadow volume.
    struct ShadowDraws {
        plain, clipped, near_front, near_back, far_front, far_back, light_front, light_back: DrawArguments;
    }

    /// The draws of the pieces of a light's twisted polygons.
    struct PieceDraws {
        plain, clipped, near_front, near_back, light_cap, dark_cap: DrawArguments;
    }

    /// A pencil of half planes that bounds the stencil counts of a light.
    struct StencilPencil {
        light_position: [f32; 3];
        kind: u32;
        forward: [f32; 3];
        first_key: f32;
        aside: [f32; 3];
        bins_per_key: f32;
    }

    /// Statistics of an encode of shadow volumes. A pair is a caster and a light in one view. A list is for a group of
    /// casters and a light in one view. A group has one page of topology and one source of positions.
    struct ShadowStatistics {
        /// Pairs whose light is relevant to the caster, but of which nothing is drawn: the caster is out of range or has no
        /// finite face, or its shadow is out of sight or falls on no receiver.
        skipped: u32;
        /// Pairs for which every face casts.
        every_face: u32;
        /// Lists with near caps.
        near_capped: u32;
        /// Lists whose cap faces overflowed. Their draws go over all faces.
        overflowed_caps: u32;
        /// Lists whose sides overflowed. Their draws go over all edges.
        overflowed_sides: u32;
        /// Pairs whose volume ends, at the light's range or behind all receivers.
        ended: u32;
        /// The largest bound of all lights, views and batches of casters
        /// ([`StencilCounts::count_batches`](crate::gpu::StencilCounts::count_batches)): no stencil count of a batch is
        /// larger, but for rounding of where sides lie. 0 unless it was requested
        /// ([`StencilCounts::bound_counts`](crate::gpu::StencilCounts::bound_counts)).
        count_bound: u32;
        /// Pairs of light and view whose bound, the largest of all batches, is larger than the largest count: 255, or less
        /// with fewer [`count_bits`](crate::gpu::ShadowFormat::count_bits), and half as much, rounded down, where casters are
        /// counted in several batches. 0 unless it was requested.
        may_wrap: u32;
        /// Lists of sides and caps that an earlier encode made, and that are drawn again.
        cached_lists: u32;
        /// Skipped pairs whose volume no receiver can be in. Pairs that were skipped in an earlier encode, and are cached,
        /// are not among them.
        culled_by_receivers: u32;
        /// Skipped pairs whose box the light does not reach, likewise. Scenes cull most of these pairs earlier:
        /// [`SceneStatistics::pairs_culled_by_range`].
        culled_by_range: u32;
        /// Pieces of twisted polygons that there was no room for, once for each view. If there are any, shadows are wrong
        /// where they would be, and [`Capacities::pieces`](crate::gpu::Capacities::pieces) must be larger.
        lost_pieces: u32;
        /// The most pieces that a caster has for a light, pairs of which nothing is drawn left out: room for so many loses
        /// none of what is drawn.
        most_pieces: u32;
    }
}

/// A mask of the lowest `count` bits of a word. `count` is at most 32.
pub const fn low_bits(count: usize) -> u32 {
    if count >= 32 { u32::MAX } else { (1 << count) - 1 }
}

/// The set bits of a word, lowest first.
pub(crate) fn bits(mut word: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 32).then_some(bit)
    })
}
