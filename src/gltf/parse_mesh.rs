//! Reads meshes and skins of [`Document`](super::document::Document) from JSON.

use gltf::json::mesh::Mode;

use super::document::{InfluenceSet, Mesh, Primitive, Skin};
use super::error::GltfError;
use super::json::Json;
use super::lengths::Lengths;

pub(super) fn mesh(json: &Json<'_>, lengths: Lengths) -> Result<Mesh, GltfError> {
    let primitives =
        json.objects("primitives")?.iter().map(|p| primitive(p, lengths)).collect::<Result<Vec<_>, _>>()?;
    let targets = primitives.first().map_or(0, |p| p.targets.len());
    if let Some(other) = primitives.iter().position(|p| p.targets.len() != targets) {
        return Err(GltfError::Count {
            place: format!("{}.primitives[{other}].targets", json.path()),
            count: primitives[other].targets.len(),
            expected: targets,
        });
    }
    let weights = json.numbers("weights")?;
    check_weights(json, weights.as_ref(), targets)?;
    Ok(Mesh { name: json.name()?, primitives, weights, targets })
}

/// Checks that there are as many default morph weights as targets.
fn check_weights(json: &Json<'_>, weights: Option<&Vec<f64>>, targets: usize) -> Result<(), GltfError> {
    match weights {
        Some(weights) if weights.len() != targets => {
            Err(GltfError::Count { place: json.at("weights"), count: weights.len(), expected: targets })
        }
        _ => Ok(()),
    }
}

fn primitive(json: &Json<'_>, lengths: Lengths) -> Result<Primitive, GltfError> {
    let mode = match json.whole("mode")? {
        Some(0) => Mode::Points,
        Some(1) => Mode::Lines,
        Some(2) => Mode::LineLoop,
        Some(3) => Mode::LineStrip,
        None | Some(4) => Mode::Triangles,
        Some(5) => Mode::TriangleStrip,
        Some(6) => Mode::TriangleFan,
        Some(_) => return Err(json.wrong("mode", "a primitive mode from 0 to 6")),
    };
    let attributes = json.required("attributes", json.object("attributes")?)?;
    let targets = json
        .objects("targets")?
        .iter()
        .map(|target| target.index("POSITION", "accessors", lengths.accessors))
        .collect::<Result<_, _>>()?;
    Ok(Primitive {
        mode,
        indices: json.index("indices", "accessors", lengths.accessors)?,
        position: attributes.index("POSITION", "accessors", lengths.accessors)?,
        influences: influences(&attributes, lengths)?,
        targets,
        draco: json.extension("KHR_draco_mesh_compression")?.is_some(),
    })
}

/// Pairs `JOINTS_n` with `WEIGHTS_n`. It is an error if one of them is missing.
fn influences(attributes: &Json<'_>, lengths: Lengths) -> Result<Vec<InfluenceSet>, GltfError> {
    let mut sets = Vec::new();
    for key in attributes.keys() {
        if let Some(set) = key.strip_prefix("WEIGHTS_") {
            let joints = format!("JOINTS_{set}");
            attributes.required(&joints, attributes.value(&joints))?;
        }
        let Some(text) = key.strip_prefix("JOINTS_") else {
            continue;
        };
        let Ok(set) = text.parse() else {
            continue;
        };
        let index = |key: &str| attributes.required(key, attributes.index(key, "accessors", lengths.accessors)?);
        sets.push(InfluenceSet { set, joints: index(key)?, weights: index(&format!("WEIGHTS_{text}"))? });
    }
    sets.sort_by_key(|set| set.set);
    Ok(sets)
}

pub(super) fn skin(json: &Json<'_>, lengths: Lengths) -> Result<Skin, GltfError> {
    let joints = json.indices("joints", "nodes", lengths.nodes)?;
    if joints.is_empty() {
        return Err(GltfError::Missing { place: json.at("joints") });
    }
    Ok(Skin {
        name: json.name()?,
        joints,
        inverse_binds: json.index("inverseBindMatrices", "accessors", lengths.accessors)?,
    })
}
