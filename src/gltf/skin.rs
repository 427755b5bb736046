//! Skins: joints and what takes mesh space to each joint's.

use glam::DAffine3;

use super::GltfError;
use super::formats;
use super::parse_scene::affine;
use super::reader::Reader;

/// A skin.
#[derive(Debug)]
pub(super) struct LoadedSkin {
    /// Joint nodes.
    pub(super) joints: Vec<usize>,
    /// One a joint.
    pub(super) inverse_binds: Vec<DAffine3>,
}

/// Reads all skins of the document.
pub(super) fn load(reader: &Reader<'_>) -> Result<Vec<LoadedSkin>, GltfError> {
    reader
        .document
        .skins
        .iter()
        .enumerate()
        .map(|(s, _)| skin(reader, s))
        .collect()
}

fn skin(reader: &Reader<'_>, index: usize) -> Result<LoadedSkin, GltfError> {
    let skin = &reader.document.skins[index];
    let count = skin.joints.len();
    let place = format!("skins[{index}].inverseBindMatrices");
    let inverse_binds = match skin.inverse_binds {
        None => vec![DAffine3::IDENTITY; count],
        Some(accessor) => {
            let matrices = reader.vectors::<16>(accessor, formats::MATRICES, &place)?;
            if matrices.len() < count {
                return Err(GltfError::Count {
                    place,
                    count: matrices.len(),
                    expected: count,
                });
            }
            let matrix = |(joint, columns): (usize, &[f32; 16])| {
                affine(columns.map(f64::from), || format!("{place}, matrix {joint}"))
            };
            matrices[..count]
                .iter()
                .enumerate()
                .map(matrix)
                .collect::<Result<_, _>>()?
        }
    };
    Ok(LoadedSkin {
        joints: skin.joints.clone(),
        inverse_binds,
    })
}
