//! Reads accessors: checks them against their use and the data, puts sparse elements in, converts components.

use std::fmt::Display;

use super::budget::Budget;
use super::document::Component::{F32, I8, I16, U8, U16, U32};
use super::document::{Accessor, Component, Document, Kind, MAT4, Part, SCALAR, Sparse, VEC3, VEC4, View, checked};
use super::error::GltfError;
use super::extensions;
use super::files::Bytes;
use super::warning::Warnings;

/// The accessors that fit a use.
#[derive(Clone, Copy)]
pub(super) struct Format {
    kind: Kind,
    components: &'static [Fit],
    text: &'static str,
}

/// A component type. `Some(true)`: it must be normalised. `Some(false)`: it must not be. `None`: both are allowed.
type Fit = (Component, Option<bool>);

/// Positions with `KHR_mesh_quantization`, also those of morph targets.
pub(super) const POSITION_QUANTIZED: Format = Format {
    kind: VEC3,
    components: &[(F32, None), (I8, None), (U8, None), (I16, None), (U16, None)],
    text: "Vec3 of F32, I8, U8, I16 or U16",
};
pub(super) const JOINTS: Format = Format {
    kind: VEC4,
    components: &[(U8, Some(false)), (U16, Some(false))],
    text: "U8 Vec4 or U16 Vec4, not normalised",
};
pub(super) const WEIGHTS: Format = Format {
    kind: VEC4,
    components: &[(F32, None), (U8, Some(true)), (U16, Some(true))],
    text: "Vec4 of F32, normalised U8 or normalised U16",
};
/// Colours of vertices, of three components and of four.
pub(super) const COLORS: Format = Format { kind: VEC3, ..COLORS_WITH_ALPHA };
pub(super) const COLORS_WITH_ALPHA: Format =
    Format { text: "Vec3 or Vec4 of F32, normalised U8 or normalised U16", ..WEIGHTS };
pub(super) const INDICES: Format = Format {
    kind: SCALAR,
    components: &[(U8, Some(false)), (U16, Some(false)), (U32, Some(false))],
    text: "U8, U16 or U32 Scalar",
};
pub(super) const MATRICES: Format = Format { kind: MAT4, components: FLOATS, text: "F32 Mat4" };
/// Keyframe times.
pub(super) const TIMES: Format = Format { kind: SCALAR, components: FLOATS, text: "F32 Scalar" };
/// Positions, and translations and scales of keyframes and instances.
pub(super) const VECTORS: Format = Format { kind: VEC3, components: FLOATS, text: "F32 Vec3" };
/// Rotations of keyframes and instances.
pub(super) const ROTATIONS: Format =
    Format { kind: VEC4, components: NORMALIZED, text: "Vec4 of F32 or a normalised I8, U8, I16 or U16" };
/// Morph weights of keyframes.
pub(super) const MORPH_WEIGHTS: Format =
    Format { kind: SCALAR, components: NORMALIZED, text: "Scalar of F32 or a normalised I8, U8, I16 or U16" };

const FLOATS: &[Fit] = &[(F32, None)];
const NORMALIZED: &[Fit] = &[(F32, None), (I8, Some(true)), (U8, Some(true)), (I16, Some(true)), (U16, Some(true))];

/// Reads a document's accessors.
pub(super) struct Reader<'a> {
    pub(super) document: &'a Document,
    pub(super) buffers: &'a [Part<Bytes<'a>>],
    pub(super) budget: &'a Budget,
    pub(super) warnings: &'a Warnings<'a>,
}

/// An accessor, and the JSON path of the property that names it.
#[derive(Clone, Copy)]
struct Use<'u> {
    accessor: usize,
    user: &'u str,
}

impl Use<'_> {
    fn json_path(&self) -> String {
        format!("accessors[{}], used as {}", self.accessor, self.user)
    }

    fn fault(&self, problem: impl Display) -> GltfError {
        GltfError::invalid(self.json_path(), format!(": {problem}"))
    }

    /// The elements of an accessor without a view. No data of the file bounds their number, and the memory limit may be
    /// more than there is.
    fn zeros(&self, count: u64, element: usize) -> Result<Vec<u8>, GltfError> {
        let bytes = count.saturating_mul(element as u64);
        let length = usize::try_from(bytes).unwrap_or(usize::MAX);
        let mut zeros = Vec::new();
        zeros.try_reserve_exact(length).map_err(|_| GltfError::Memory { what: self.json_path(), bytes })?;
        zeros.resize(length, 0);
        Ok(zeros)
    }

    /// There are no bytes for a view.
    fn no_data(&self, view: usize, View { buffer, compressed, .. }: &View) -> GltfError {
        let Some(name) = compressed else { return self.fault(format_args!("buffers[{buffer}] has no data")) };
        GltfError::Extension {
            name: (*name).to_owned(),
            json_path: format!("bufferViews[{view}], used by accessors[{}] as {},", self.accessor, self.user),
            advice: extensions::MESHOPT_ADVICE,
        }
    }
}

impl<'a> Reader<'a> {
    pub(super) fn accessor(&self, index: usize) -> Result<&'a Accessor, GltfError> {
        checked(&self.document.accessors[index])
    }

    /// The number of elements of an accessor, without checks.
    pub(super) fn count(&self, accessor: usize) -> Result<usize, GltfError> {
        Ok(usize::try_from(self.accessor(accessor)?.count).unwrap_or(usize::MAX))
    }

    /// Checks the number of elements of an accessor.
    pub(super) fn check_count(&self, accessor: usize, expected: usize, json_path: &str) -> Result<(), GltfError> {
        let count = self.count(accessor)?;
        if count == expected { Ok(()) } else { Err(GltfError::count(json_path, count, expected)) }
    }

    /// Vectors of floats. Normalised integers are dequantised, others are converted.
    pub(super) fn vectors<const N: usize>(
        &self,
        accessor: usize,
        format: Format,
        user: &str,
    ) -> Result<Vec<[f32; N]>, GltfError> {
        let mark = self.budget.mark();
        let floats = self.floats(accessor, format, user)?;
        let vectors = floats.as_chunks().0.to_vec();
        drop(floats);
        self.budget.settle(mark, size_of_val(&*vectors) as u64);
        Ok(vectors)
    }

    /// All components as floats, element after element.
    pub(super) fn floats(&self, accessor: usize, format: Format, user: &str) -> Result<Vec<f32>, GltfError> {
        let bytes = self.raw(accessor, format, user)?;
        let &Accessor { component, normalized, .. } = self.accessor(accessor)?;
        let scale = |largest: f32| if normalized { largest } else { 1.0 };
        let signed = |value: f32, largest: f32| (value / scale(largest)).max(if normalized { -1.0 } else { f32::MIN });
        Ok(match component {
            I8 => bytes.iter().map(|&b| signed(f32::from(b as i8), 127.0)).collect(),
            U8 => bytes.iter().map(|&b| f32::from(b) / scale(255.0)).collect(),
            I16 => words(&bytes, |w| signed(f32::from(i16::from_le_bytes(w)), 32767.0)),
            U16 => words(&bytes, |w| f32::from(u16::from_le_bytes(w)) / scale(65535.0)),
            U32 => words(&bytes, |w| u32::from_le_bytes(w) as f32),
            F32 => words(&bytes, f32::from_le_bytes),
        })
    }

    /// All components of an unsigned integer accessor, element after element.
    pub(super) fn integers(&self, accessor: usize, format: Format, user: &str) -> Result<Vec<u32>, GltfError> {
        let mark = self.budget.mark();
        let bytes = self.raw(accessor, format, user)?;
        let integers = unsigned(&bytes, self.accessor(accessor)?.component);
        drop(bytes);
        self.budget.settle(mark, size_of_val(&*integers) as u64);
        Ok(integers)
    }

    /// The bytes of the elements without gaps, in the accessor's own component type.
    fn raw(&self, index: usize, format: Format, user: &str) -> Result<Vec<u8>, GltfError> {
        let (accessor, at) = (self.accessor(index)?, Use { accessor: index, user });
        let &Accessor { view, offset, count, component, kind, normalized, sparse } = accessor;
        let fits = |&(fit, is_normalized): &Fit| fit == component && is_normalized.is_none_or(|n| n == normalized);
        if kind != format.kind || !format.components.iter().any(fits) {
            let normalized = if normalized { "normalised " } else { "" };
            let expected = format.text;
            return Err(at.fault(format_args!("it holds {normalized}{component:?} {}, expected {expected}", kind.1)));
        }
        let (components, element) = (kind.2, accessor.element());
        // The check against the data comes first, so that a wrong number gets its own error.
        let source = view.map(|view| self.strided(view, offset, count, element, at)).transpose()?;
        // The bytes as they are stored and the numbers, or the numbers in one list and in one of vectors.
        self.budget.charge(count, (element.max(4 * components) + 4 * components) as u64, &|| at.json_path())?;
        let mut bytes = match source {
            Some((data, stride)) => pack(data, stride, element, count as usize),
            None => at.zeros(count, element)?,
        };
        if let Some(sparse) = sparse {
            self.replace(&mut bytes, sparse, element, count, at)?;
        }
        Ok(bytes)
    }

    /// The bytes from the first to the last of `count` elements, and the distance between two elements.
    fn strided(
        &self,
        index: usize,
        offset: u64,
        count: u64,
        size: usize,
        at: Use<'_>,
    ) -> Result<(&'a [u8], usize), GltfError> {
        let view = checked(&self.document.views[index])?;
        let [stride, length] = view.extent(count, size as u64);
        if stride < size as u64 {
            return Err(at.fault(format_args!(
                "the byteStride {stride} of bufferViews[{index}] is smaller than an element's {size} bytes"
            )));
        }
        let (needed, available) = (length.saturating_add(offset), view.bytes);
        if needed > available {
            return Err(
                at.fault(format_args!("it needs {needed} bytes of bufferViews[{index}], which has {available}"))
            );
        }
        let buffer = checked(&self.buffers[view.buffer])?.as_deref();
        // A buffer that is there holds the whole view, so the sum does not overflow.
        let data = buffer.and_then(|buffer| buffer.get((view.offset + offset) as usize..)?.get(..length as usize));
        Ok((data.ok_or_else(|| at.no_data(index, view))?, stride as usize))
    }

    fn replace(
        &self,
        bytes: &mut [u8],
        sparse: Sparse,
        element: usize,
        elements: u64,
        at: Use<'_>,
    ) -> Result<(), GltfError> {
        let Sparse { count, indices, component, values } = sparse;
        if count > elements {
            return Err(at.fault(format_args!("it replaces {count} elements of {elements}")));
        }
        let (indices, stride) = self.strided(indices.view, indices.offset, count, component.size(), at)?;
        self.budget.charge(count, (component.size() + 4 + element) as u64, &|| at.json_path())?;
        let indices = unsigned(&pack(indices, stride, component.size(), count as usize), component);
        let (values, stride) = self.strided(values.view, values.offset, count, element, at)?;
        let values = pack(values, stride, element, count as usize);
        let mut least = 0;
        for (position, (&index, value)) in indices.iter().zip(values.chunks_exact(element)).enumerate() {
            if u64::from(index) < least || u64::from(index) >= elements {
                return Err(at.fault(format_args!(
                    "sparse index {position} is {index}; they must increase and stay below {elements}"
                )));
            }
            least = u64::from(index) + 1;
            bytes[index as usize * element..][..element].copy_from_slice(value);
        }
        Ok(())
    }
}

/// Copies elements into one block. `data` reaches from the start of the first to the end of the last.
fn pack(data: &[u8], stride: usize, element: usize, count: usize) -> Vec<u8> {
    if stride == element {
        return data.to_vec();
    }
    let mut packed = Vec::with_capacity(count * element);
    for chunk in data.chunks(stride).take(count) {
        packed.extend_from_slice(&chunk[..element.min(chunk.len())]);
    }
    packed
}

fn words<const N: usize, T>(bytes: &[u8], convert: impl Fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks().0.iter().map(|word| convert(*word)).collect()
}

fn unsigned(bytes: &[u8], component: Component) -> Vec<u32> {
    match component {
        I8 | U8 => bytes.iter().map(|&b| u32::from(b)).collect(),
        I16 | U16 => words(bytes, |w| u32::from(u16::from_le_bytes(w))),
        U32 | F32 => words(bytes, u32::from_le_bytes),
    }
}
