//! Reads meshes and skins of [`Document`](super::document::Document) from JSON.

use gltf::json::mesh::Mode;

use super::document::{InfluenceSet, Mesh, Primitive, Skin};
use super::error::GltfError;
use super::json::Json;
use super::lengths::Lengths;
use super::warning::{GltfWarning, Warnings};

/// Reads a mesh. An error in it becomes its fault.
pub(super) fn mesh(
    json: Result<Json<'_>, GltfError>,
    lengths: Lengths,
    warnings: &Warnings<'_>,
) -> Result<Mesh, GltfError> {
    let json = match warnings.keep(json)? {
        Ok(json) => json,
        Err(fault) => return Ok(Mesh { fault: Some(fault), ..Mesh::default() }),
    };
    let name = json.name(warnings)?;
    Ok(match warnings.keep(mesh_content(&json, lengths, warnings))? {
        Ok(mesh) => Mesh { name, ..mesh },
        Err(fault) => Mesh { name, fault: Some(fault), ..Mesh::default() },
    })
}

fn mesh_content(json: &Json<'_>, lengths: Lengths, warnings: &Warnings<'_>) -> Result<Mesh, GltfError> {
    let primitives =
        json.objects("primitives")?.iter().map(|p| primitive(p, lengths, warnings)).collect::<Result<Vec<_>, _>>()?;
    let targets = primitives.first().map_or(0, |p| p.targets.len());
    if let Some(other) = primitives.iter().position(|p| p.targets.len() != targets) {
        return Err(GltfError::Count {
            place: format!("{}.primitives[{other}].targets", json.path()),
            count: primitives[other].targets.len(),
            expected: targets,
        });
    }
    let weights = match json.numbers("weights")? {
        Some(weights) => checked_weights(weights, targets, || json.at("weights"), warnings)?,
        None => None,
    };
    Ok(Mesh { name: None, primitives, weights, targets, fault: None })
}

/// Checks that there are as many morph weights as targets. Weights without any target are left out.
pub(super) fn checked_weights(
    weights: Vec<f64>,
    targets: usize,
    place: impl Fn() -> String,
    warnings: &Warnings<'_>,
) -> Result<Option<Vec<f64>>, GltfError> {
    if targets == 0 && !weights.is_empty() {
        warnings.push(GltfWarning::MorphWeights { place: place(), weights: weights.len() })?;
        return Ok(None);
    }
    if weights.len() != targets {
        return Err(GltfError::Count { place: place(), count: weights.len(), expected: targets });
    }
    Ok(Some(weights))
}

fn primitive(json: &Json<'_>, lengths: Lengths, warnings: &Warnings<'_>) -> Result<Primitive, GltfError> {
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
    let (influences, influences_fault) = match warnings.keep(influences(&attributes, lengths))? {
        Ok(influences) => (influences, None),
        Err(fault) => (Vec::new(), Some(fault)),
    };
    Ok(Primitive {
        mode,
        indices: json.index("indices", "accessors", lengths.accessors)?,
        position: attributes.index("POSITION", "accessors", lengths.accessors)?,
        influences,
        influences_fault,
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

/// Reads a skin. An error in it becomes its fault.
pub(super) fn skin(
    json: Result<Json<'_>, GltfError>,
    lengths: Lengths,
    warnings: &Warnings<'_>,
) -> Result<Skin, GltfError> {
    let json = match warnings.keep(json)? {
        Ok(json) => json,
        Err(fault) => return Ok(Skin { fault: Some(fault), ..Skin::default() }),
    };
    let name = json.name(warnings)?;
    Ok(match warnings.keep(skin_content(&json, lengths))? {
        Ok(skin) => Skin { name, ..skin },
        Err(fault) => Skin { name, fault: Some(fault), ..Skin::default() },
    })
}

fn skin_content(json: &Json<'_>, lengths: Lengths) -> Result<Skin, GltfError> {
    let joints = json.indices("joints", "nodes", lengths.nodes)?;
    if joints.is_empty() {
        return Err(GltfError::Missing { place: json.at("joints") });
    }
    let inverse_binds = json.index("inverseBindMatrices", "accessors", lengths.accessors)?;
    Ok(Skin { name: None, joints, inverse_binds, fault: None })
}
