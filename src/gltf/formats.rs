//! The accessor formats that the specification allows for each use.

use gltf::json::accessor::ComponentType::{F32, I8, I16, U8, U16, U32};
use gltf::json::accessor::{ComponentType, Type};

/// The accessors that fit a use.
#[derive(Clone, Copy)]
pub(super) struct Format {
    pub(super) kind: Type,
    pub(super) components: &'static [Component],
    pub(super) text: &'static str,
}

/// A component type. `Some(true)`: it must be normalised. `Some(false)`: it must not be. `None`: both are allowed.
pub(super) type Component = (ComponentType, Option<bool>);

pub(super) const POSITION: Format = Format { kind: Type::Vec3, components: &[(F32, None)], text: "F32 Vec3" };
/// Positions with `KHR_mesh_quantization`, also those of morph targets.
pub(super) const POSITION_QUANTIZED: Format = Format {
    kind: Type::Vec3,
    components: &[(F32, None), (I8, None), (U8, None), (I16, None), (U16, None)],
    text: "Vec3 of F32, I8, U8, I16 or U16",
};
pub(super) const JOINTS: Format = Format {
    kind: Type::Vec4,
    components: &[(U8, Some(false)), (U16, Some(false))],
    text: "U8 Vec4 or U16 Vec4, not normalised",
};
pub(super) const WEIGHTS: Format = Format {
    kind: Type::Vec4,
    components: &[(F32, None), (U8, Some(true)), (U16, Some(true))],
    text: "Vec4 of F32, normalised U8 or normalised U16",
};
pub(super) const INDICES: Format = Format {
    kind: Type::Scalar,
    components: &[(U8, Some(false)), (U16, Some(false)), (U32, Some(false))],
    text: "U8, U16 or U32 Scalar",
};
pub(super) const MATRICES: Format = Format { kind: Type::Mat4, components: &[(F32, None)], text: "F32 Mat4" };
/// Keyframe times.
pub(super) const TIMES: Format = Format { kind: Type::Scalar, components: &[(F32, None)], text: "F32 Scalar" };
/// Translations and scales of keyframes and instances.
pub(super) const VECTORS: Format = Format { kind: Type::Vec3, components: &[(F32, None)], text: "F32 Vec3" };
/// Rotations of keyframes and instances.
pub(super) const ROTATIONS: Format =
    Format { kind: Type::Vec4, components: NORMALIZED, text: "Vec4 of F32 or a normalised I8, U8, I16 or U16" };
/// Morph weights of keyframes.
pub(super) const MORPH_WEIGHTS: Format =
    Format { kind: Type::Scalar, components: NORMALIZED, text: "Scalar of F32 or a normalised I8, U8, I16 or U16" };

const NORMALIZED: &[Component] =
    &[(F32, None), (I8, Some(true)), (U8, Some(true)), (I16, Some(true)), (U16, Some(true))];
