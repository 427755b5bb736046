//! Reads accessors: checks them against the data, puts sparse elements in, converts components.

use gltf::json::accessor::ComponentType;

use super::budget::Budget;
use super::buffers::Bytes;
use super::document::{Accessor, Document, Part, Sparse};
use super::error::{AccessorProblem, GltfError};
use super::extensions;
use super::formats::{Component, Format};
use super::warning::Warnings;

/// Reads a document's accessors.
pub(super) struct Reader<'a> {
    pub(super) document: &'a Document,
    buffers: &'a [Part<Bytes<'a>>],
    pub(super) budget: &'a Budget,
    pub(super) warnings: &'a Warnings<'a>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a [Part<Bytes<'a>>],
        budget: &'a Budget,
        warnings: &'a Warnings<'a>,
    ) -> Self {
        Self { document, buffers, budget, warnings }
    }

    /// Charges `count` elements of `size` bytes that are about to be allocated.
    pub(super) fn charge(&self, count: u64, size: u64, what: &dyn Fn() -> String) -> Result<(), GltfError> {
        self.budget.charge(count, size, what)
    }

    pub(super) fn accessor(&self, index: usize) -> Result<&'a Accessor, GltfError> {
        self.document.accessors[index].as_ref().map_err(|fault| GltfError::clone(fault))
    }

    /// The number of elements of an accessor, without checks.
    pub(super) fn count(&self, accessor: usize) -> Result<usize, GltfError> {
        Ok(usize::try_from(self.accessor(accessor)?.count).unwrap_or(usize::MAX))
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
            ComponentType::I8 => bytes.iter().map(|&b| signed(f32::from(b as i8), 127.0)).collect(),
            ComponentType::U8 => bytes.iter().map(|&b| f32::from(b) / scale(255.0)).collect(),
            ComponentType::I16 => words(&bytes, |w| signed(f32::from(i16::from_le_bytes(w)), 32767.0)),
            ComponentType::U16 => words(&bytes, |w| f32::from(u16::from_le_bytes(w)) / scale(65535.0)),
            ComponentType::U32 => words(&bytes, |w| u32::from_le_bytes(w) as f32),
            ComponentType::F32 => words(&bytes, f32::from_le_bytes),
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
        let accessor = self.accessor(index)?;
        self.elements(accessor, format, &|| format!("accessors[{index}], used as {user}"))
            .map_err(|failure| failure.at(index, user))
    }

    fn elements(&self, accessor: &Accessor, format: Format, place: &dyn Fn() -> String) -> Result<Vec<u8>, Failure> {
        let fits = |&(component, normalized): &Component| {
            component == accessor.component && normalized.is_none_or(|n| n == accessor.normalized)
        };
        if accessor.kind != format.kind || !format.components.iter().any(fits) {
            let found = describe(accessor);
            let expected = format.text;
            return Err(AccessorProblem::Format { found, expected }.into());
        }
        let (components, size) = (accessor.kind.multiplicity(), accessor.component.size());
        let element = components * size;
        // The check against the data comes first, so that a wrong number gets its own error.
        let source = match accessor.view {
            Some(view) => Some(self.strided(view, accessor.offset, accessor.count, element as u64)?),
            None => None,
        };
        // The bytes as they are stored and the numbers, or the numbers in one list and in one of vectors.
        self.charge(accessor.count, (element.max(4 * components) + 4 * components) as u64, place)?;
        let mut bytes = match source {
            Some((data, stride)) => pack(data, stride, element, accessor.count as usize),
            None => vec![0; accessor.count as usize * element],
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(&mut bytes, sparse, element, accessor.count, place)?;
        }
        Ok(bytes)
    }

    /// The bytes from the first to the last of `count` elements, and the distance between two elements.
    fn strided(&self, view_index: usize, offset: u64, count: u64, size: u64) -> Result<(&'a [u8], usize), Failure> {
        let view = self.document.views[view_index].as_ref().map_err(|fault| GltfError::clone(fault))?;
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            let view = view_index;
            return Err(AccessorProblem::Stride { view, stride, size }.into());
        }
        let length = match count.checked_sub(1) {
            Some(steps) => steps.checked_mul(stride).and_then(|bytes| bytes.checked_add(size)),
            None => Some(0),
        };
        let needed = length.and_then(|length| length.checked_add(offset)).unwrap_or(u64::MAX);
        if needed > view.bytes {
            return Err(AccessorProblem::TooShort { view: view_index, needed, available: view.bytes }.into());
        }
        let no_data = || match view.compressed {
            Some(name) => Failure::Compressed(name, view_index),
            None => AccessorProblem::NoData { buffer: view.buffer }.into(),
        };
        let buffer = self.buffers[view.buffer].as_ref().map_err(|fault| GltfError::clone(fault))?;
        let buffer = buffer.as_deref().ok_or_else(no_data)?;
        let start = (view.offset + offset) as usize;
        let data = buffer.get(start..start + length.unwrap_or(0) as usize).ok_or_else(no_data)?;
        Ok((data, stride as usize))
    }

    fn replace(
        &self,
        bytes: &mut [u8],
        sparse: &Sparse,
        element: usize,
        elements: u64,
        place: &dyn Fn() -> String,
    ) -> Result<(), Failure> {
        let count = sparse.count;
        if count > elements {
            return Err(AccessorProblem::SparseCount { count, elements }.into());
        }
        let (view, offset, component) = sparse.indices;
        let (indices, stride) = self.strided(view, offset, count, component.size() as u64)?;
        self.charge(count, (component.size() + 4 + element) as u64, place)?;
        let indices = unsigned(&pack(indices, stride, component.size(), count as usize), component);
        let (view, offset) = sparse.values;
        let (values, stride) = self.strided(view, offset, count, element as u64)?;
        let values = pack(values, stride, element, count as usize);
        let mut least = 0;
        for (position, (&index, value)) in indices.iter().zip(values.chunks_exact(element)).enumerate() {
            if u64::from(index) < least || u64::from(index) >= elements {
                let problem = AccessorProblem::SparseIndex { position, index, elements };
                return Err(problem.into());
            }
            least = u64::from(index) + 1;
            bytes[index as usize * element..][..element].copy_from_slice(value);
        }
        Ok(())
    }
}

/// Why an accessor cannot be read, without its place.
enum Failure {
    Problem(AccessorProblem),
    Compressed(&'static str, usize),
    Whole(GltfError),
}

impl From<AccessorProblem> for Failure {
    fn from(problem: AccessorProblem) -> Self {
        Self::Problem(problem)
    }
}

impl From<GltfError> for Failure {
    fn from(error: GltfError) -> Self {
        Self::Whole(error)
    }
}

impl Failure {
    fn at(self, accessor: usize, user: &str) -> GltfError {
        match self {
            Self::Problem(problem) => GltfError::Accessor { accessor, user: user.to_owned(), problem },
            Self::Compressed(name, view) => GltfError::Extension {
                name: name.to_owned(),
                place: format!("bufferViews[{view}], used by accessors[{accessor}] as {user},"),
                advice: extensions::MESHOPT_ADVICE,
            },
            Self::Whole(error) => error,
        }
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

fn unsigned(bytes: &[u8], component: ComponentType) -> Vec<u32> {
    match component {
        ComponentType::I8 | ComponentType::U8 => bytes.iter().map(|&b| u32::from(b)).collect(),
        ComponentType::I16 | ComponentType::U16 => words(bytes, |w| u32::from(u16::from_le_bytes(w))),
        ComponentType::U32 | ComponentType::F32 => words(bytes, u32::from_le_bytes),
    }
}

fn describe(accessor: &Accessor) -> String {
    let normalized = if accessor.normalized { "normalised " } else { "" };
    format!("{normalized}{:?} {:?}", accessor.component, accessor.kind)
}
