//! Structs that Rust and WGSL share. A test reads the WGSL through naga and compares every size, offset and type.

use bytemuck::{Pod, Zeroable};

/// A field of a [`StructLayout`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    /// The field's name, the same in WGSL.
    pub name: &'static str,
    /// Bytes from the struct's start.
    pub offset: usize,
    /// Bytes it takes.
    pub size: usize,
    /// Its type as Rust writes it.
    pub rust_type: &'static str,
}

/// How a shared struct lies in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The struct's name, the same in WGSL.
    pub name: &'static str,
    /// Bytes it takes in an array.
    pub size: usize,
    /// Its fields in order.
    pub fields: &'static [FieldLayout],
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
    /// Up to 32 lights and where the positions lie.
    struct LightBatch {
        /// Homogeneous lights, scaled by a power of two; those past `count` repeat the last.
        lights: [[f32; 4]; 32],
        /// The lights as given, bit for bit.
        light_bits: [[u32; 4]; 32],
        /// |w| of each scaled light, as far as its products' errors count: 0 where it is a power of two, and not less
        /// than 2⁻³⁶ where it is so small that scaling and products may lose it.
        inexact_w: [[f32; 4]; 8],
        /// Of all scaled lights the largest |x|, |y| or |z|, and the largest |w| or `inexact_w`.
        reach: [f32; 2],
        /// Lights in use.
        count: u32,
        /// The lowest `count` bits.
        live: u32,
        /// First word of vertex 0 in the bound positions.
        position_offset: u32,
        /// Words from a vertex to the next.
        position_stride: u32,
        /// 0.
        reserved_0: u32,
        /// 0.
        reserved_1: u32,
    }

    /// The part of the faces or edges that one dispatch works on.
    struct Chunk {
        /// Its first item.
        first: u32,
        /// Its items.
        count: u32,
        /// The first light of the 32 at hand.
        first_light: u32,
        /// Entries that each light's list has room for.
        capacity: u32,
        /// Blocks of edges in the whole mesh.
        blocks: u32,
    }

    /// What turns counts into draws.
    struct DrawShape {
        /// Lights of all words.
        lights: u32,
        /// Entries that each light's list has room for.
        capacity: u32,
        /// Edge records in the mesh.
        edges: u32,
        /// Vertices that a silhouette edge is drawn with.
        vertices_per_edge: u32,
    }

    /// An edge record's bits, one a light.
    struct Masks {
        /// Set where the edge is a silhouette.
        silhouette: u32,
        /// Set where face 0 faces the light.
        winding: u32,
    }

    /// What an extraction counts besides its results.
    struct Statistics {
        /// Faces with an infinite or NaN vertex: they face no light.
        non_finite_faces: u32,
        /// Lists that overflowed; their lights are drawn over all edges.
        overflowed_lists: u32,
        /// Pairs of face and light that the filter left to exact arithmetic.
        undecided_pairs: u32,
        /// Those of them whose determinant is exactly zero.
        exact_zeros: u32,
    }

    /// What wgpu's `draw_indirect` reads.
    struct DrawArguments {
        /// Vertices an instance.
        vertex_count: u32,
        /// Silhouette edges, or all edges where the list overflowed.
        instance_count: u32,
        /// 0.
        first_vertex: u32,
        /// 0.
        first_instance: u32,
    }

    /// Thirty-two faces and the box around those that count: finite, and naming three vertices.
    struct FaceCluster {
        /// Bits of the lowest x, y and z, and of the largest absolute coordinate.
        low: [u32; 4],
        /// Bits of the highest x, y and z, and 1 where any face counts; 0 where the box is empty, and all zeros.
        high: [u32; 4],
        /// The same of the thirty-two clusters from this one on, in the first of each thirty-two.
        group_low: [u32; 4],
        /// The same.
        group_high: [u32; 4],
        /// Three vertices a face. Faces past the mesh's last name vertex 0 three times.
        corners: [u32; 96],
    }

    /// The points of one dispatch of the shadow depth query.
    struct PointChunk {
        /// Points in this dispatch.
        count: u32,
        /// First word of its first point in the bound points.
        offset: u32,
        /// Words from a point to the next.
        stride: u32,
        /// Lights of all words.
        lights: u32,
        /// The first light of the word at hand.
        first_light: u32,
    }

    /// The clusters of faces that one dispatch goes over.
    struct FaceRange {
        /// The first in the bound clusters; a multiple of 32.
        first: u32,
        /// The end, exclusive.
        end: u32,
        /// 1 where these are the mesh's first: depths begin here.
        is_first: u32,
    }

    /// Faces that a point and a light leave undecided.
    struct UndecidedFaces {
        /// How many.
        count: u32,
        /// The first of them.
        face_0: u32,
        /// The second.
        face_1: u32,
        /// The third.
        face_2: u32,
        /// An entry of another list: a pair of point and light that had more, and is counted anew.
        recount: u32,
    }

    /// The vertices of one instance that one dispatch deforms.
    struct DeformChunk {
        /// Vertices in this dispatch.
        count: u32,
        /// First word of the dispatch's first vertex in the bound positions.
        first_word: u32,
        /// Words in the pose where the matrices begin.
        palette: u32,
        /// Words in the pose where the active morph targets begin.
        targets: u32,
        /// Active morph targets.
        target_count: u32,
        /// 0: every vertex follows the palette's first matrix.
        skinned: u32,
        /// 0: no displacement.
        displaced: u32,
        /// Seconds, handed to `displace`.
        time: f32,
    }

    /// What the WGSL include knows of a batch of lights.
    struct RimlineInfo {
        /// Edge records in the mesh.
        edges: u32,
        /// Entries that each light's list has room for.
        capacity: u32,
        /// The first light of this word among all lights.
        first_light: u32,
        /// Lights in this word.
        lights: u32,
        /// First word of vertex 0 in the bound positions.
        position_offset: u32,
        /// Words from a vertex to the next.
        position_stride: u32,
    }

    /// A camera, as the stages of shadow volumes see it.
    struct ShadowView {
        /// Columns of the matrix from positions less `origin` to clip space.
        view_projection: [[f32; 4]; 4],
        /// Height over the near plane: this times (position − origin, 1).
        near_plane: [f32; 4],
        /// What positions are taken relative to.
        origin: [f32; 3],
        /// Clip w of points on the near plane.
        near_w: f32,
        /// Lowest corner of the near rectangle's bounds.
        near_min: [f32; 3],
        /// z / w of points on the near plane.
        near_z: f32,
        /// Highest corner of the near rectangle's bounds.
        near_max: [f32; 3],
        /// 0.
        reserved: u32,
    }

    /// A light, and what the GPU chose for it and a caster.
    struct ShadowLight {
        /// Homogeneous, scaled so that w is 0 or a power of two.
        light: [f32; 4],
        /// The same in clip space.
        clip: [f32; 4],
        /// Its height over the near plane, times its w.
        height: f32,
        /// Casters beyond are skipped; 0: none are.
        range: f32,
        /// Which faces cast: 0 none, 1 those averted from the light, 2 every one.
        casting: u32,
        /// How is counted: 0 z-pass, 1 ZP+, 2 z-fail, 4 ZP+ as published.
        counting: u32,
        /// With ZP+ as published the near end of the light's frustum: for a point light its distance over the far end's,
        /// for a light at infinity its height over the near plane.
        frustum_near: f32,
        /// Where the volume ends: a lower bound of the caster's distance from the light, over the range. 0: at infinity.
        end: f32,
        /// 1: the caster has faces with a corner that is not finite, and so sides of holes.
        holed: u32,
        /// 1: the light may lie in faces of the caster, which are excluded then.
        excludes: u32,
        /// Row x of that frustum's matrix, from (position − origin, 1).
        frustum_x: [f32; 4],
        /// Row y.
        frustum_y: [f32; 4],
        /// Row w.
        frustum_w: [f32; 4],
    }

    /// What a caster is and what the caller wants of its volumes.
    struct ShadowShape {
        /// Lights in use.
        lights: u32,
        /// Faces of the mesh.
        faces: u32,
        /// Edge records of the mesh.
        edges: u32,
        /// Entries that each light's list of silhouettes has room for.
        capacity: u32,
        /// Entries that each list of cap faces has room for.
        cap_capacity: u32,
        /// 1: closed and consistently oriented, and every face was not asked for.
        averted: u32,
        /// 0 z-pass, 1 ZP+, 2 z-fail, 3 z-pass or ZP+, 4 ZP+ as published.
        counting: u32,
        /// 1: skip casters whose shadow the camera cannot see.
        skip_unseen: u32,
        /// First word of vertex 0 in the bound positions.
        position_offset: u32,
        /// Words from a vertex to the next.
        position_stride: u32,
        /// Workgroups of the caps stage.
        cap_groups: u32,
        /// 1: volumes end where their light's range does.
        end_at_range: u32,
    }

    /// The light, or the batch of lights, that a draw or dispatch is for.
    struct ShadowDraw {
        /// Its number.
        light: u32,
        /// The first light of its word.
        first_light: u32,
        /// 0.
        reserved_0: u32,
        /// 0.
        reserved_1: u32,
    }

    /// The draws of one light's shadow volume.
    struct ShadowDraws {
        /// Sides as they are.
        plain: DrawArguments,
        /// Sides clipped at the near plane.
        clipped: DrawArguments,
        /// Caps that count up on their front.
        front: DrawArguments,
        /// Caps that count up on their back.
        back: DrawArguments,
        /// Sides that ZP+ as published leaves to z-fail.
        switched: DrawArguments,
        /// Their light and dark caps, or with z-pass the dark caps of a volume that ends: those of the first list.
        far_front: DrawArguments,
        /// Of the second.
        far_back: DrawArguments,
        /// Sides of holes, beside `plain` or `switched`.
        holes: DrawArguments,
        /// Sides of holes, clipped at the near plane, beside `clipped`.
        clipped_holes: DrawArguments,
    }

    /// What an encode of shadow volumes counts, a light at a time.
    struct ShadowStatistics {
        /// Lights for which the caster is skipped: out of range, or its shadow out of sight.
        skipped: u32,
        /// Lights for which every face casts.
        every_face: u32,
        /// Lights with a near cap.
        capped: u32,
        /// Lights whose list of cap faces overflowed; drawn over all faces.
        overflowed_caps: u32,
        /// Lights whose volume ends at their range.
        ended: u32,
        /// No stencil count of the caster exceeds this, for any light; 0 unless asked for.
        count_bound: u32,
        /// Lights for which that bound is above 255; 0 unless asked for.
        may_wrap: u32,
    }
}

impl LightBatch {
    /// The batch of up to 32 `lights`.
    pub fn new(lights: &[crate::Light], position_offset: u32, position_stride: u32) -> Self {
        let mut word = Self { count: lights.len() as u32, live: live_bits(lights.len()), ..Self::zeroed() };
        for slot in 0..32 {
            let Some(light) = lights.get(slot).or(lights.last()) else { break };
            let given = light.to_array();
            let scaled = ScaledLight::new(given);
            let [x, y, z, w] = scaled.light.map(f32::abs);
            let w = w.max(scaled.inexact_w);
            word.lights[slot] = scaled.light;
            word.light_bits[slot] = given.map(f32::to_bits);
            word.inexact_w[slot / 4][slot % 4] = scaled.inexact_w;
            word.reach = [word.reach[0].max(x).max(y).max(z), word.reach[1].max(w)];
        }
        Self { position_offset, position_stride, ..word }
    }
}

/// Scaling and products may lose a w below this, all of it.
const TINY_W: f32 = f32::from_bits((127 - 60) << 23);
/// What then stands for it in the bounds.
const LEAST_INEXACT_W: f32 = f32::from_bits((127 - 36) << 23);

/// A light as the filter sees it; NUMERICS.md, "Filter".
struct ScaledLight {
    light: [f32; 4],
    inexact_w: f32,
}

impl ScaledLight {
    fn new(given: [f32; 4]) -> Self {
        let largest = given.iter().fold(0.0_f64, |largest, &c| largest.max(f64::from(c).abs()));
        // Lights are finite, as `check_lights` holds; others give bits that mean nothing, but no panic.
        // In f64 neither the power of two nor the product can round, whatever finite f32 the light has.
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

/// The lowest `count` bits of a word, `count` up to 32.
pub const fn live_bits(count: usize) -> u32 {
    if count >= 32 { u32::MAX } else { (1 << count) - 1 }
}
