//! Skins: joints, and the matrices from mesh space to the space of each joint.

use glam::DAffine3;

use super::document::{Part, affine, checked};
use super::error::GltfError;
use super::reader::{self, Reader};

/// A skin.
#[derive(Debug)]
pub(super) struct LoadedSkin {
    /// The nodes of the joints.
    pub(super) joints: Vec<usize>,
    /// One matrix for each joint.
    pub(super) inverse_binds: Vec<DAffine3>,
}

/// Reads all skins of the document, each with its fault.
pub(super) fn load(reader: &Reader<'_>) -> Result<Vec<Part<LoadedSkin>>, GltfError> {
    (0..reader.document.skins.len()).map(|skin| reader.warnings.keep(load_one(reader, skin))).collect()
}

fn load_one(reader: &Reader<'_>, index: usize) -> Result<LoadedSkin, GltfError> {
    let skin = checked(&reader.document.skins[index].part)?;
    let (json_path, expected) = (format!("skins[{index}].inverseBindMatrices"), skin.joints.len());
    let count = skin.inverse_binds.map_or(Ok(expected), |accessor| reader.count(accessor))?;
    if count < expected {
        return Err(GltfError::count(json_path, count, expected));
    }
    // A list that doubles.
    reader.budget.charge(expected as u64, 3 * size_of::<DAffine3>() as u64, &|| format!("skins[{index}].joints"))?;
    let inverse_binds = match skin.inverse_binds {
        None => vec![DAffine3::IDENTITY; expected],
        Some(accessor) => {
            let matrices = reader.vectors::<16>(accessor, reader::MATRICES, &json_path)?;
            let matrix = |(joint, columns): (usize, &[f32; 16])| {
                affine(columns.map(f64::from), || format!("{json_path}, matrix {joint}"))
            };
            matrices.iter().take(expected).enumerate().map(matrix).collect::<Result<_, _>>()?
        }
    };
    Ok(LoadedSkin { joints: skin.joints.clone(), inverse_binds })
}
