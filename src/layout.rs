//! Structs that Rust and WGSL share. A test reads the WGSL through naga and compares every size, offset and type.

use bytemuck::{Pod, Zeroable};

use crate::light::{Cone, Light};

/// A field of a [`StructLayout`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    /// The field's name, the same in WGSL.
    pub name: &'static str,
    /// Bytes from the start of the struct.
    pub offset: usize,
    /// Size in bytes.
    pub size: usize,
    /// The type as Rust writes it.
    pub rust_type: &'static str,
}

/// The memory layout of a shared struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The struct's name, the same in WGSL.
    pub name: &'static str,
    /// Size in an array, in bytes.
    pub size: usize,
    /// The fields in order.
    pub fields: &'static [FieldLayout],
}

/// Slots of a chunk of a scene. With 32 the stages of 200 figures took 1.36 times as long as those of one mesh, with 64
/// 1.22 times. Boxes of 12 faces leave most of 64 slots empty, which costs memory and no time.
pub const CHUNK: u32 = 64;
/// Invocations that share a chunk, in facing and edges. Each takes slots in turn, so that it finds their caster once, and
/// ends where the caster ends.
pub const LANES: u32 = 8;

/// A caster whose mesh has no clusters.
pub const NO_CLUSTERS: u32 = u32::MAX;
/// Words of a listed chunk of faces: the chunk, the lights that are decided for all of its faces, those of them that the
/// faces face, and the places of the lights that are tested.
pub const FACE_ENTRY: u32 = 4;

/// Flags of a [`SceneCaster`].
pub(crate) mod caster_flags {
    /// The caster is closed and consistently oriented.
    pub(crate) const CLOSED: u32 = 1;
    pub(crate) const MIRRORED: u32 = 2;
    pub(crate) const RIGID: u32 = 4;
    /// A face has a corner that is not finite.
    pub(crate) const HOLED: u32 = 8;
    /// The caller excludes faces.
    pub(crate) const EXCLUDING: u32 = 16;
    /// Positions may have changed.
    pub(crate) const CHANGING: u32 = 32;
    /// The caller excludes faces of a caster of the group.
    pub(crate) const GIVEN: u32 = 64;
    /// The caster is not in the depth buffer.
    pub(crate) const PROXY: u32 = 128;
    /// The caller states a box of the positions.
    pub(crate) const BOUNDED: u32 = 256;
}

/// Declares `#[repr(C)]` structs and lists their layouts in [`LAYOUTS`].
macro_rules! shared_structs {
    ($($(#[$doc:meta])* struct $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
            #[repr(C)]
            pub struct $name { $($(#[$field_doc])* pub $field: $type,)* }
        )*

        /// Every struct shared with WGSL.
        pub const LAYOUTS: &[StructLayout] = &[$(StructLayout {
            name: stringify!($name),
            size: size_of::<$name>(),
            fields: &[$(FieldLayout {
                name: stringify!($field),
                offset: std::mem::offset_of!($name, $field),
                size: size_of::<$type>(),
                rust_type: stringify!($type),
            },)*],
        },)*];
    };
}

shared_structs! {
    /// A batch of up to 32 lights, and the layout of the positions.
    struct LightBatch {
        /// Homogeneous lights, scaled by a power of two. Entries past `count` repeat the last light.
        lights: [[f32; 4]; 32],
        /// The lights as given, bit for bit.
        light_bits: [[u32; 4]; 32],
        /// |w| of each scaled light, as far as it adds to the error of products. It is 0 if w is a power of two. It is
        /// at least 2⁻³⁶ if w is so small that scaling and products may lose it.
        inexact_w: [[f32; 4]; 8],
        /// The largest |x|, |y| or |z| of all scaled lights, and their largest |w| or `inexact_w`.
        reach: [f32; 2],
        /// Number of lights in use.
        count: u32,
        /// A mask of the lowest `count` bits.
        live: u32,
        /// Word of vertex 0 in the bound positions.
        position_offset: u32,
        /// Words from one vertex to the next.
        position_stride: u32,
        /// 0.
        reserved_0: u32,
        /// 0.
        reserved_1: u32,
    }

    /// The range of faces or edges of one dispatch.
    struct Chunk {
        /// First item.
        first: u32,
        /// Number of items.
        count: u32,
        /// First light of the batch.
        first_light: u32,
        /// Entries that the list of each light has room for.
        capacity: u32,
        /// Blocks of edges in the whole mesh.
        blocks: u32,
    }

    /// The sizes for turning counts of edges into draws.
    struct DrawShape {
        /// Number of lights in all batches.
        lights: u32,
        /// Entries that the list of each light has room for.
        capacity: u32,
        /// Edge records of the mesh.
        edges: u32,
        /// Vertices that draw one silhouette edge.
        vertices_per_edge: u32,
    }

    /// The bits of an edge record, one for each light of a batch.
    struct EdgeMasks {
        /// Set if the edge is a silhouette edge.
        silhouette: u32,
        /// Set if face 0 faces the light.
        winding: u32,
    }

    /// Statistics of an extraction.
    struct ExtractionStatistics {
        /// Faces with an infinite or NaN vertex. They face no light.
        non_finite_faces: u32,
        /// Lists that overflowed. The draws of their lights go over all edges.
        overflowed_lists: u32,
        /// Pairs of face and light that the filter left to exact arithmetic.
        undecided_pairs: u32,
        /// The undecided pairs whose determinant is exactly zero.
        exact_zeros: u32,
        /// A bit for each light for which a polygon is L-twisted. Lights whose numbers differ by 32 share a bit.
        twisted_lights: u32,
    }

    /// The arguments that wgpu's `draw_indirect` reads.
    struct DrawArguments {
        /// Vertices of an instance.
        vertex_count: u32,
        /// Instances: silhouette edges, or all edges if the list overflowed.
        instance_count: u32,
        /// 0.
        first_vertex: u32,
        /// 0.
        first_instance: u32,
    }

    /// Thirty-two faces and their box. The box holds the faces that count: those that are finite and name three
    /// different vertices.
    struct FaceCluster {
        /// Bits of the lowest x, y and z, and of the largest absolute coordinate.
        low: [u32; 4],
        /// Bits of the highest x, y and z, and 1 if any face counts. All are 0 for an empty box.
        high: [u32; 4],
        /// `low` for the group of thirty-two clusters that begins here. Only the first cluster of a group has it.
        group_low: [u32; 4],
        /// `high` for this group.
        group_high: [u32; 4],
        /// Three vertices for each face. Entries past the last face of the mesh name vertex 0 three times.
        corners: [u32; 96],
        /// A bit for each face, set if it belongs to the same polygon as the face before it.
        continues: u32,
        /// If the first face continues a polygon, the place of the first triangle of that. Places count faces from the first
        /// cluster of the run that one binding holds.
        head: u32,
        /// The mesh's index of the first face. The indices of the others follow it.
        first_face: u32,
        /// 0.
        padding: u32,
    }

    /// The points of one dispatch of the shadow depth query.
    struct PointChunk {
        /// Points in this dispatch.
        count: u32,
        /// First word of the first point in the bound points.
        offset: u32,
        /// Words from one point to the next.
        stride: u32,
        /// Number of lights in all batches.
        lights: u32,
        /// First light of the batch.
        first_light: u32,
        /// Words from a point to the number of the face that it is on. 0 if points name no face.
        on_face: u32,
    }

    /// The clusters of faces that one dispatch goes over.
    struct FaceRange {
        /// First cluster in the bound clusters, a multiple of 32.
        first: u32,
        /// End of the range, exclusive.
        end: u32,
        /// 1 if these are the first clusters of the mesh, so the depths begin at 0.
        is_first: u32,
        /// The first cluster of the range before. The same as `first` if these are the first clusters of the binding.
        before: u32,
    }

    /// The undecided faces of a pair of point and light.
    struct UndecidedFaces {
        /// Number of undecided faces, at most 4. Bits 3 to 5, one for each of the first three, are set if an odd number of the
        /// decided triangles of its polygon are between, and bit 6 if an odd number of triangles are, of the polygon of the last
        /// face of the range.
        state: u32,
        /// First undecided face. If there are more than three: bits of polygons that go on behind their group of clusters, set if
        /// an odd number of their triangles are between. Bit 0 is that of one that began before the range, and bit 1 + n that of
        /// one that began in group n of the range.
        face_0: u32,
        /// Second undecided face.
        face_1: u32,
        /// Third undecided face.
        face_2: u32,
        /// An entry of another list: a pair of point and light that had more, and is counted again.
        recount: u32,
    }

    /// A dispatch of the deform stage.
    struct DeformDispatch {
        /// The word in the pose where the chunks of its workgroups begin, a word each.
        workgroups: u32,
        /// 0: the displacement is not called.
        displaced: u32,
        /// The time for the displacement, in seconds.
        time: f32,
        /// Instances of the model.
        instances: u32,
    }

    /// A run of vertices of one instance, for whole workgroups. Words count from where the dispatch binds the arrays.
    struct DeformChunk {
        /// The number of its first workgroup in the dispatch.
        first_workgroup: u32,
        /// Vertices.
        count: u32,
        /// The word of the first vertex in the rest positions.
        rest: u32,
        /// The word of the first vertex's first morph target. The offsets of one target follow each other.
        morph: u32,
        /// The word where its influences begin: offsets, then joints and weights.
        skin: u32,
        /// The word of the first vertex in the source vertices.
        sources: u32,
        /// The word of the first vertex in the positions.
        positions: u32,
        /// The word in the pose where the matrices begin.
        palette: u32,
        /// The word in the pose where the active morph targets begin.
        targets: u32,
        /// Active morph targets.
        target_count: u32,
        /// 0: all vertices follow the first matrix of the palette.
        skinned: u32,
        /// The word in the pose that is 1 if the positions of the instance are a point, since it was not needed before. So many
        /// words behind it as there are instances, a word is 1 if it is not needed now.
        before: u32,
    }

    /// The part of a batch of lights that the WGSL include reads.
    struct RimlineInfo {
        /// Edge records of the mesh.
        edges: u32,
        /// Entries that the list of each light has room for.
        capacity: u32,
        /// First light of this batch.
        first_light: u32,
        /// Number of lights in this batch.
        lights: u32,
        /// Word of vertex 0 in the bound positions.
        position_offset: u32,
        /// Words from one vertex to the next.
        position_stride: u32,
        /// Where the masks of L-twisted polygons lie behind the facing masks. 0: there are none.
        twisted_at: u32,
        /// Vertices that the draw has for each edge.
        vertices_per_edge: u32,
    }

    /// A caster in the table of casters. Slots are places in the masks of what is drawn together; other places are in the
    /// buffers of the mesh.
    struct SceneCaster {
        /// Row x of the matrix from mesh space to world space.
        row_0: [f32; 4],
        /// Row y.
        row_1: [f32; 4],
        /// Row z.
        row_2: [f32; 4],
        /// Lowest corner of the box of the finite faces, in mesh space. Low is above high if there is none.
        low: [f32; 3],
        /// At most the smallest factor by which the matrix scales a length.
        scale: f32,
        /// Highest corner of the box.
        high: [f32; 3],
        /// Bits: 1 closed; 2 mirrored; 4 rigid, so lights are moved to its mesh space and the box is known; 8 a face is not
        /// finite; 16 the caller excludes faces; 32 positions may have changed; 64 the caller excludes faces of a caster of
        /// the group; 128 not in the depth buffer; 256 the box is one that the caller states, in world space.
        flags: u32,
        /// First face slot, a multiple of [`CHUNK`].
        first_face_slot: u32,
        /// Number of faces.
        faces: u32,
        /// First face in the page.
        first_face: u32,
        /// Word of vertex 0 in the bound positions.
        position_offset: u32,
        /// First edge slot, a multiple of [`CHUNK`].
        first_edge_slot: u32,
        /// Number of edge records.
        edges: u32,
        /// First edge record in the page.
        first_edge: u32,
        /// Words from one vertex to the next.
        position_stride: u32,
        /// The encode that was the first to have it as it is.
        version: u32,
        /// Its group of casters.
        group: u32,
        /// The first caster of the group.
        first_caster: u32,
        /// A rigid caster: the word of the page's clusters where the clusters of its mesh begin, or [`NO_CLUSTERS`]. Any
        /// other caster: its number among the figures that may not be needed, counted from 1, or 0 if it is none.
        clusters_or_figure: u32,
    }

    /// The input of the stage that finds the needed figures of a scene.
    struct NeedsDispatch {
        /// Figures.
        figures: u32,
        /// Views.
        views: u32,
        /// Lights of each view, at least 1.
        lights: u32,
        /// Units of 16 bytes of each figure.
        parts: u32,
        /// 1: every figure is needed.
        all: u32,
        /// 1: casters that a light's range does not reach are skipped.
        skip_unreached: u32,
        /// 1: shadows that a camera cannot see are skipped.
        skip_unseen: u32,
        /// 0.
        reserved: u32,
    }

    /// The lights of a caster of a scene in a batch.
    struct CasterLights {
        /// The bits of the lights that its mask allows and that its space has.
        allowed: u32,
        /// Where its lights begin in the table: for each the bits as given, and scaled as in [`LightBatch`].
        first: u32,
        /// The largest |x|, |y| or |z| of the scaled lights, and their largest |w| or inexact w.
        reach: [f32; 2],
    }

    /// A dispatch over a group of casters for a batch of lights.
    struct SceneDispatch {
        /// Casters of the scene.
        casters: u32,
        /// Batches of the scene.
        batches: u32,
        /// The batch.
        batch: u32,
        /// Word of what is kept where 32 words begin: for each light the encode that made its list.
        lists_at: u32,
        /// Where the lights of casters begin in the table, in units of 16 bytes.
        lights_at: u32,
        /// Where the ranges of lights begin.
        ranges_at: u32,
        /// Where the casters of the group's face chunks begin.
        face_chunks_at: u32,
        /// Where the casters of the group's edge chunks begin.
        edge_chunks_at: u32,
        /// Face chunks of the group.
        face_chunks: u32,
        /// Edge chunks of the group.
        edge_chunks: u32,
        /// Word of the work lists with the number of listed face chunks. The number of edge chunks is next. Then come the
        /// lights whose lists are made anew, and the lights of which bits are cached.
        work_count: u32,
        /// Word of the work lists where the listed face chunks begin.
        face_work: u32,
        /// Word of the work lists where the listed edge chunks begin.
        edge_work: u32,
        /// Entries that the list of each light has room for.
        capacity: u32,
        /// The number of this layout of the scene.
        structure: u32,
        /// Whether bits of an earlier encode are kept.
        keeps: u32,
        /// Word of what is kept where the clusters of the group and batch begin: two for each chunk of faces.
        clusters_at: u32,
        /// Where the occluders begin in the table: for each batch and occluder the lights for which it hides, those that see its
        /// corners counter-clockwise, its caster, and where its corners are.
        occluders_at: u32,
        /// The number of occluders.
        occluders: u32,
        /// Where the scaled lights begin in the table, in world space: 32 for each batch.
        world_lights_at: u32,
    }

    /// Counts of an encode of a scene.
    struct SceneStatistics {
        /// Pairs of caster and light that matter: the light is allowed, and may reach the caster.
        pairs: u32,
        /// The part of `pairs` whose facing bits an earlier encode cached.
        kept_pairs: u32,
        /// Pairs of caster and allowed light that do not matter, because the light does not reach the caster.
        unreached_pairs: u32,
        /// Pairs of caster and light that do not matter, because an occluder hides the caster from the light.
        occluded_pairs: u32,
        /// Faces that were tested, for each batch of 32 lights.
        faces: u32,
        /// Edge records that were tested, for each batch of 32 lights.
        edges: u32,
        /// Faces that were not tested, since all faces of a cluster are on one side of each light.
        spared_faces: u32,
        /// Edge records that were not tested, since clusters tell that none is a silhouette edge.
        spared_edges: u32,
        /// Instances of models that the frame does not need, and which were not deformed:
        /// [`Scene::insert_model`](crate::gpu::Scene::insert_model).
        unneeded: u32,
    }

    /// A camera, as a caster sees it. The camera's frame has the world's axes and the camera's origin at 0.
    struct ShadowView {
        /// Columns of the matrix that maps the camera's frame to clip space.
        view_projection: [[f32; 4]; 4],
        /// The near plane. Its product with (place, 1) is the height over the plane.
        near_plane: [f32; 4],
        /// Rows of the matrix from positions to the camera's frame.
        placement: [[f32; 4]; 3],
        /// Lowest corner of the box of the near rectangle, in the camera's frame.
        near_min: [f32; 3],
        /// Clip w of points on the near plane.
        near_w: f32,
        /// Highest corner of the box of the near rectangle.
        near_max: [f32; 3],
        /// z / w of points on the near plane.
        near_z: f32,
    }

    /// A light, and what the GPU chose for it and a caster.
    struct ShadowLight {
        /// The homogeneous light, in the space of the positions, scaled so that w is 0 or a power of two.
        light: [f32; 4],
        /// The light in clip space.
        clip: [f32; 4],
        /// The light's height over the near plane, times its w.
        height: f32,
        /// The range. Casters farther away are skipped. 0: no limit.
        range: f32,
        /// The faces that cast: 0 none, 1 those averted from the light, 2 every face.
        casting: u32,
        /// The counting method: 0 z-pass, 1 ZP+, 2 z-fail, 4 ZP+ as published.
        counting: u32,
        /// The near end of the light's frustum, for ZP+ as published. For a point light it is the distance of the near
        /// end over that of the far end. For a light at infinity it is the height over the near plane.
        frustum_near: f32,
        /// The end of the volume: a lower bound of the caster's distance from the light, divided by the range. 0: at
        /// infinity.
        end: f32,
        /// 1: faces of the caster may be excluded: those in whose plane the light is, and those that are not finite.
        excludes: u32,
        /// The light as given times this is the homogeneous light.
        scale: f32,
        /// Row x of the matrix of that frustum. It maps (position − origin, 1).
        frustum_x: [f32; 4],
        /// Row y.
        frustum_y: [f32; 4],
        /// Row w.
        frustum_w: [f32; 4],
    }

    /// A light and a camera, with 512 bytes: bindings begin at multiples of 256.
    struct SeenLight {
        /// The camera.
        view: ShadowView,
        /// The light.
        light: ShadowLight,
        /// The encode that was the first to have the camera as it is; the word where the view's receivers begin, 0 for none;
        /// zeros.
        version: [u32; 4],
        /// The light's cone.
        cone: LightCone,
        /// 0.
        reserved: [[u32; 4]; 12],
    }

    /// The cone of a spot light, in world space.
    struct LightCone {
        /// The apex, and 1. All zeros: the light has no cone.
        apex: [f32; 4],
        /// The axis at length 1, and the cosine of the angle from it to the cone's border.
        axis: [f32; 4],
    }

    /// The receivers of a view.
    struct ReceiverView {
        /// Columns of the matrix from normalised device coordinates to the camera's frame.
        inverse: [[f32; 4]; 4],
        /// Lowest corner of the box of the near rectangle, in the camera's frame.
        near_min: [f32; 3],
        /// Depth of the near plane.
        near_z: f32,
        /// Highest corner of the box of the near rectangle.
        near_max: [f32; 3],
        /// 1: pixels at the cleared depth are receivers.
        sky_receives: u32,
        /// Pixels across and down.
        pixels: [u32; 2],
        /// The word where the view's receivers begin.
        at: u32,
        /// 0.
        reserved: u32,
    }

    /// A depth map, and how its edges are found.
    struct DepthMapShape {
        /// Texels across and down.
        size: [u32; 2],
        /// Cells between four samples of the lattice.
        cells: u32,
        /// Blocks of cells: 64 strips each, of eight cells across and four down.
        blocks: u32,
        /// Cells that the list has room for.
        capacity: u32,
        /// 1: every cell that is not far is marked.
        every_cell: u32,
        /// Bits of the threshold, in device depth.
        threshold: u32,
        /// 1: near is 1 and far is 0.
        is_reversed: u32,
        /// Maps: 1, or the 6 of a cube.
        faces: u32,
        /// 1: edges between different objects are marked.
        objects: u32,
        /// 1: triangles at the ends of marked edges are drawn, too.
        spread: u32,
        /// 0.
        unused: u32,
    }

    /// How the contours of a depth map are traced and fitted. Distances count from the near plane on, in units of 2⁻²⁹ of the
    /// range of device depths.
    struct ContourShape {
        /// Tiles of 16 × 16 cells across, and all of them.
        tiles: [u32; 2],
        /// Words of a row of marks.
        words: u32,
        /// Walls that the list has room for.
        capacity: u32,
        /// The distance that an edge's samples must be apart, more than their slopes tell.
        threshold: i32,
        /// The distance from which on they are at a jump, whatever is behind it.
        sure: i32,
        /// How far a segment may be from a place of the contour, in parts of 256 of a texel.
        sideways: i32,
        /// How far the ends of a wall may be from those of the surfaces there: a number, and the bits that it and depths are
        /// moved down by.
        tolerance: i32,
        /// See `tolerance`.
        shift: u32,
        /// The move away from the light: parts of 256 of a texel's depth difference, parts of 2²⁹ of the depth, a distance.
        slope_bias: i32,
        /// See `slope_bias`.
        share: i32,
        /// See `slope_bias`.
        constant: i32,
    }

    /// The rule that marks edges of a depth map. Where a field has two values, the second applies next to the end of a marked
    /// edge.
    struct DepthEdgeRule {
        /// Words of a row of the lattice, and rows.
        words: [u32; 2],
        /// Blocks of 256 words.
        blocks: u32,
        /// Bits of what every larger difference is marked above.
        high: u32,
        /// Bits of what every smaller difference is not marked below.
        low: [u32; 2],
        /// Bits of how many times the difference beside it a difference is.
        slopes: [u32; 2],
        /// Bits of what two differences are off by.
        noise: u32,
        /// The same as a share of the depth: so many exponents less. 0: no share.
        noise_exponents: u32,
    }

    /// The samples of a depth map that the near rectangle of a camera is among.
    struct DepthNearBox {
        /// The first sample, on the lattice.
        first: [u32; 2],
        /// Samples across and down, 65,536 at most.
        size: [u32; 2],
        /// The key of what is behind all of the near rectangle.
        key: u32,
        /// The same as a distance from the near plane, in units of 2⁻²⁹ of the range of device depths.
        distance: i32,
        /// 0.
        unused: [u32; 2],
    }

    /// How distances become the device depths of a depth map.
    struct DepthMetricView {
        /// How the ray through a texel changes for each step of half a texel across. w: the same of the nearness at
        /// infinity, which is 1 at the near plane and 0 at the far end.
        across: [f32; 4],
        /// The same for each step down.
        down: [f32; 4],
        /// The ray in the middle, and 0. Its component along the light's axis is 1.
        middle: [f32; 4],
        /// The far distance, or without a far plane what nearness times distance is.
        head: f32,
        /// The part of the far distance that rounding took off `head`, if there is a far plane.
        rest: f32,
        /// 1: there is a far plane.
        has_far: f32,
        /// The factor from the distance left to the far plane to a depth.
        scale: f32,
        /// The least distance. Smaller ones are clamped to it.
        least: f32,
        /// The distance from which on nothing casts, whatever the planes are.
        most: f32,
        /// 0: device depths. 1: distances in the direction that the planes are apart in. 2: distances along rays from a place.
        metric: u32,
        /// 1: depth is linear in the distance.
        is_parallel: u32,
    }

    /// A depth map as a camera sees it. A place on the lattice is twice the distance from its middle.
    struct DepthMapView {
        /// Clip space for each step across.
        across: [f32; 4],
        /// Clip space for each step down.
        down: [f32; 4],
        /// Clip space for each unit of depth.
        depth: [f32; 4],
        /// Clip space at the middle and depth 0.
        middle: [f32; 4],
        /// Like `across`, at infinity.
        far_across: [f32; 4],
        /// Like `down`, at infinity.
        far_down: [f32; 4],
        /// Like `middle`, at infinity.
        far_middle: [f32; 4],
        /// Homogeneous place on the lattice and depth, for each unit of x on the near rectangle.
        near_across: [f32; 4],
        /// The same for each unit of y.
        near_up: [f32; 4],
        /// The same in the middle of the near rectangle.
        near_middle: [f32; 4],
        /// The depth at infinity for each step across, for each step down, and in the middle. w is 1 if there is none.
        infinity: [f32; 4],
        /// The distance that the surface is moved: a share of the slopes, a share of the depth, a constant, 0.
        bias: [f32; 4],
    }

    /// The light of a depth map that meshes are drawn into.
    struct MeshDepthView {
        /// Columns of the matrix that maps positions less the origin to the light's clip space.
        columns: [[f32; 4]; 4],
    }

    /// A mesh that is drawn into a depth map.
    struct MeshDepthCaster {
        /// The first row that places positions, less the light's origin.
        row_0: [f32; 4],
        /// The second row.
        row_1: [f32; 4],
        /// The third row.
        row_2: [f32; 4],
        /// The word of x of vertex 0, the words from one vertex to the next, the first face, and how many there are.
        place: [u32; 4],
    }

    /// Camera and style of outlines.
    struct OutlineView {
        /// Columns of the matrix that maps positions less the origin to clip space.
        columns: [[f32; 4]; 4],
        /// The point that positions are relative to.
        origin: [f32; 3],
        /// Half the width of a line, in pixels.
        half_width: f32,
        /// The colour of silhouettes, not premultiplied.
        silhouette: [f32; 4],
        /// The colour of boundaries.
        boundary: [f32; 4],
        /// The colour of creases.
        crease: [f32; 4],
        /// The colour of marked edges.
        marked: [f32; 4],
        /// Width and height of the picture, in pixels.
        size: [f32; 2],
        /// How far behind what is seen a line may lie, as depth.
        depth_bias: f32,
        /// Faces whose normals have a smaller cosine meet at a crease.
        crease_cosine: f32,
        /// The light's number in its batch.
        light: u32,
        /// The classes that are drawn, a bit each.
        classes: u32,
        /// 1 if the larger depth is nearer.
        is_reversed: u32,
        /// Not used.
        reserved: u32,
    }

    /// A group of a scene's casters and a light, whose outlines are drawn.
    struct OutlinedGroup {
        /// The offset in the table, in units of 16 bytes, of the casters of all chunks of edges.
        edge_chunks_at: u32,
        /// The offset in the lights of casters of the first caster, in the light's batch, in words.
        lit_at: u32,
        /// Entries that the list of each light has room for.
        capacity: u32,
        /// The offset of the twisted masks, which lie behind the facing masks, in words. 0: there are none.
        twisted_at: u32,
        /// The light's bit in its batch.
        bit: u32,
        /// 0.
        reserved_0: u32,
        /// 0.
        reserved_1: u32,
        /// 0.
        reserved_2: u32,
    }

    /// Casters that are drawn together, and the caller's options for their volumes.
    struct ShadowShape {
        /// Casters in the table.
        casters: u32,
        /// Lights of all batches.
        lights: u32,
        /// Batches of lights.
        batches: u32,
        /// Slots of faces.
        faces: u32,
        /// Slots of edge records.
        edges: u32,
        /// Entries that the list of silhouettes of each light has room for.
        capacity: u32,
        /// Entries that the two lists of sides of each light have room for together.
        side_capacity: u32,
        /// Entries that the two lists of near caps of each light have room for together.
        near_capacity: u32,
        /// Entries that the two lists of other caps of each light have room for together.
        far_capacity: u32,
        /// 1: averted faces may cast, of casters that are closed. The caller did not ask for every face.
        averted: u32,
        /// The counting method that was asked for: 0 z-pass, 1 ZP+, 2 z-fail, 3 z-pass or ZP+, 4 ZP+ as published.
        counting: u32,
        /// 1: skip casters that the light's range does not reach.
        skip_unreached: u32,
        /// 1: skip casters where the camera cannot see their shadow.
        skip_unseen: u32,
        /// 1: volumes end at the range of their light.
        end_at_range: u32,
        /// Where choices begin in the table, in units of 16 bytes.
        choices_at: u32,
        /// Where measures begin.
        measures_at: u32,
        /// Where the lights of casters begin.
        lights_at: u32,
        /// Where the casters of the chunks of face slots begin.
        face_chunks_at: u32,
        /// Where the casters of the chunks of edge slots begin.
        edge_chunks_at: u32,
        /// Views.
        views: u32,
        /// Batches in which casters are counted, one after the other.
        count_batches: u32,
        /// 1: some casters are not in the depth buffer.
        proxies: u32,
        /// The number of the group and batch.
        part: u32,
        /// The first caster of the group.
        first_caster: u32,
        /// The word of what is kept of the extraction where the encodes are that made its lists.
        lists_at: u32,
        /// 1: lists for views are kept.
        keeps: u32,
        /// 1: boxes are needed for more than what is chosen.
        needs_boxes: u32,
        /// Numbers up to that of the last light.
        used_lights: u32,
        /// 1: views may have receivers. Then volumes may end behind all of them.
        has_receivers: u32,
        /// The largest count that the bits which count hold. One bit of counts is that of darkness where there are several
        /// batches.
        most_count: u32,
        /// Pieces of L-twisted polygons that the list of each light has room for.
        piece_capacity: u32,
    }

    /// The light, or the batch of lights, of a draw or dispatch.
    struct ShadowDraw {
        /// Index of the light.
        light: u32,
        /// First light of its batch.
        first_light: u32,
        /// The view.
        view: u32,
        /// The batch of casters that is counted.
        count_batch: u32,
    }

    /// The draws of one light's shadow volume.
    struct ShadowDraws {
        /// Sides that are not clipped.
        plain: DrawArguments,
        /// Sides clipped at the near plane, or sides of ZP+ as published.
        clipped: DrawArguments,
        /// Near caps that count up on their front.
        near_front: DrawArguments,
        /// Near caps that count up on their back.
        near_back: DrawArguments,
        /// Light and dark caps of z-fail, of faces that count up on their front. With z-pass, the dark caps of volumes that
        /// end.
        far_front: DrawArguments,
        /// The same of faces that count up on their back.
        far_back: DrawArguments,
        /// With z-pass and ZP+, the light caps of casters that are not in the depth buffer, likewise.
        light_front: DrawArguments,
        /// Likewise.
        light_back: DrawArguments,
    }

    /// The draws of the pieces of a light's L-twisted polygons.
    struct PieceDraws {
        /// Sides that are not clipped.
        plain: DrawArguments,
        /// Sides clipped at the near plane.
        clipped: DrawArguments,
        /// Near caps that count up on their front.
        near_front: DrawArguments,
        /// Near caps that count up on their back.
        near_back: DrawArguments,
        /// Caps at the polygon. The faces that pieces make are not in the depth buffer, so the eye sees through them.
        light_cap: DrawArguments,
        /// Caps at the far end: with z-fail, and of volumes that end.
        dark_cap: DrawArguments,
    }

    /// A pencil of half planes that bounds the stencil counts of a light.
    struct StencilPencil {
        /// The position of the light. 0 if it is at infinity.
        place: [f32; 3],
        /// 0: parallel half planes of a light at infinity. 1: the light is outside the box of all casters. 2: the half
        /// planes go all around a coordinate axis.
        kind: u32,
        /// A direction at right angles to the axis.
        forward: [f32; 3],
        /// The number of the half plane where the first bin begins.
        first: f32,
        /// Another such direction.
        aside: [f32; 3],
        /// Bins for each unit.
        scale: f32,
    }

    /// Statistics of an encode of shadow volumes. `count_bound` apart, they count lights, or pairs of caster and light.
    struct ShadowStatistics {
        /// Lights for which the caster is skipped: it is out of range, or its shadow is out of sight or falls on no receiver.
        skipped: u32,
        /// Lights for which every face casts.
        every_face: u32,
        /// Lights with a near cap.
        capped: u32,
        /// Lights with a list of cap faces that overflowed. Their draws go over all faces.
        overflowed_caps: u32,
        /// Lights with a list of sides that overflowed. Their draws go over all edges.
        overflowed_sides: u32,
        /// Lights whose volume ends, at the light's range or behind all receivers.
        ended: u32,
        /// An upper bound of the stencil counts of all casters together, for any light and view. 0 unless it was asked for.
        count_bound: u32,
        /// Lights, in each view, whose bound is larger than the largest count: 255, or less with fewer
        /// [`count_bits`](crate::gpu::ShadowFormat::count_bits), and half as much where casters are counted in several batches. 0
        /// unless it was asked for.
        may_wrap: u32,
        /// Pairs of light and view whose lists of sides and caps were kept from an earlier encode, for each group of casters of
        /// a scene. A group has one page of topology and one source of positions.
        kept_lists: u32,
        /// Skipped pairs whose volume no receiver can be in. Pairs that were skipped in an earlier encode, and are cached,
        /// are not among them.
        hidden: u32,
        /// Skipped pairs whose box the light does not reach, likewise. Scenes cull most of these pairs earlier:
        /// [`SceneStatistics::unreached_pairs`].
        unreached: u32,
        /// Pieces of L-twisted polygons that there was no room for. If there are any, shadows are wrong where they would be, and
        /// [`Capacities::pieces`](crate::gpu::Capacities::pieces) must be larger.
        lost_pieces: u32,
        /// The most pieces that a caster has for a light: room for so many loses none.
        most_pieces: u32,
    }
}

impl LightBatch {
    /// The batch of up to 32 `lights`.
    pub fn new(lights: &[Light], position_offset: u32, position_stride: u32) -> Self {
        let of_bit = |bit: usize| lights.get(bit).map(|light| light.to_array());
        Self::of_bits(of_bit, lights.len() as u32, position_offset, position_stride)
    }

    /// The batch of the lights that some of the lowest `count` bits have. The others have no bit in any mask; they repeat a light,
    /// so that nothing is left undecided for them.
    pub(crate) fn of_bits(
        light: impl Fn(usize) -> Option<[f32; 4]>,
        count: u32,
        position_offset: u32,
        position_stride: u32,
    ) -> Self {
        let mut batch = Self { count, ..Self::zeroed() };
        let last = (0..count as usize).rev().find_map(&light);
        for slot in 0..32 {
            let own = if slot < count as usize { light(slot) } else { None };
            let Some(given) = own.or(last) else { break };
            batch.live |= u32::from(own.is_some()) << slot;
            let scaled = ScaledLight::new(given);
            let [x, y, z, w] = scaled.light.map(f32::abs);
            let w = w.max(scaled.inexact_w);
            batch.lights[slot] = scaled.light;
            batch.light_bits[slot] = given.map(f32::to_bits);
            batch.inexact_w[slot / 4][slot % 4] = scaled.inexact_w;
            batch.reach = [batch.reach[0].max(x).max(y).max(z), batch.reach[1].max(w)];
        }
        Self { position_offset, position_stride, ..batch }
    }
}

/// A w below this may be lost in scaling and products.
const TINY_W: f32 = f32::from_bits((127 - 60) << 23);
/// The value that replaces such a w in the error bounds.
const LEAST_INEXACT_W: f32 = f32::from_bits((127 - 36) << 23);

/// A light as the filter sees it. See docs/numerics/facing.md, "Filter".
pub(crate) struct ScaledLight {
    pub(crate) light: [f32; 4],
    pub(crate) inexact_w: f32,
}

impl ScaledLight {
    pub(crate) fn new(given: [f32; 4]) -> Self {
        let largest = given.iter().fold(0.0_f64, |largest, &c| largest.max(f64::from(c).abs()));
        // `check_lights` makes sure that lights are finite. Other lights give meaningless bits, but no panic.
        // In f64 neither the power of two nor the product rounds, whatever finite f32 the light has.
        let scale = if largest == 0.0 || !largest.is_finite() {
            1.0
        } else {
            f64::from_bits((2046 - (largest.to_bits() >> 52)) << 52)
        };
        let light = given.map(|c| (f64::from(c) * scale) as f32);
        let w = light[3].abs();
        let is_power_of_two = w == 0.0 || w.to_bits().trailing_zeros() >= 23;
        let inexact_w = if given[3] != 0.0 && w < TINY_W {
            LEAST_INEXACT_W
        } else if is_power_of_two {
            0.0
        } else {
            w
        };
        Self { light, inexact_w }
    }
}

impl LightCone {
    /// The cone of a light. Zeros if it has none, or is at infinity.
    pub(crate) fn of(light: &Light) -> Self {
        let Some(Cone { axis, cosine }) = light.cone.filter(|_| light.w != 0.0) else { return Self::zeroed() };
        // In f64 squares of finite f32 neither overflow nor vanish.
        let [x, y, z] = axis.map(f64::from);
        let length = (x * x + y * y + z * z).sqrt();
        let [x, y, z] = [x, y, z].map(|c| (c / length) as f32);
        let [apex_x, apex_y, apex_z] = light.xyz.map(|c| (f64::from(c) / f64::from(light.w)) as f32);
        Self { apex: [apex_x, apex_y, apex_z, 1.0], axis: [x, y, z, cosine] }
    }
}

/// A mask of the lowest `count` bits of a word. `count` is at most 32.
pub const fn live_bits(count: usize) -> u32 {
    if count >= 32 { u32::MAX } else { (1 << count) - 1 }
}
