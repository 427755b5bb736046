//! Skins: joints, and the matrices from mesh space to the space of each joint.

use glam::DAffine3;

use super::document::{Part, Skin};
use super::error::GltfError;
use super::formats;
use super::reader::Reader;
use super::transforms::affine;

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
    let skins = reader.document.skins.iter().enumerate();
    skins.map(|(index, skin)| reader.warnings.keep(load_one(reader, index, skin))).collect()
}

fn place(skin: usize) -> String {
    format!("skins[{skin}].inverseBindMatrices")
}

fn load_one(reader: &Reader<'_>, index: usize, skin: &Skin) -> Result<LoadedSkin, GltfError> {
    if let Some(fault) = &skin.fault {
        return Err(GltfError::clone(fault));
    }
    let (count, expected) = (skin.inverse_binds.map(|a| reader.count(a)).transpose()?, skin.joints.len());
    if let Some(count) = count.filter(|&count| count < expected) {
        return Err(GltfError::Count { place: place(index), count, expected });
    }
    // A list that doubles.
    reader.charge(skin.joints.len() as u64, 3 * size_of::<DAffine3>() as u64, &|| format!("skins[{index}].joints"))?;
    let inverse_binds = match skin.inverse_binds {
        None => vec![DAffine3::IDENTITY; skin.joints.len()],
        Some(accessor) => {
            let place = place(index);
            let matrices = reader.vectors::<16>(accessor, formats::MATRICES, &place)?;
            let matrix = |(joint, columns): (usize, &[f32; 16])| {
                affine(columns.map(f64::from), || format!("{place}, matrix {joint}"))
            };
            let used = matrices.iter().take(skin.joints.len()).enumerate();
            used.map(matrix).collect::<Result<_, _>>()?
        }
    };
    Ok(LoadedSkin { joints: skin.joints.clone(), inverse_binds })
}
