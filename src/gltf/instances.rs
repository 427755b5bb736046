//! Builds the model: the geometries of every mesh, and the instances of the chosen scene.

use glam::{DAffine3, DVec3};

use super::budget;
use super::document::{Document, Instancing, Node, Trs};
use super::error::GltfError;
use super::formats;
use super::geometry::{self, Merged};
use super::graph::Graph;
use super::placement::{Frame, Placement};
use super::reader::Reader;
use super::scene_light::SceneLight;
use super::skin::LoadedSkin;
use super::transforms::unit;
use crate::mesh::{Weld, WeldCounts};
use crate::model::{Geometry, Instance, Model};

/// A model with the data that its poses and reports need.
#[derive(Debug)]
pub(super) struct Built {
    pub(super) model: Model,
    /// The origin of each instance.
    pub(super) placements: Vec<Placement>,
    /// The mesh of each geometry.
    pub(super) meshes: Vec<usize>,
    /// What welding did to each geometry.
    pub(super) weld_counts: Vec<WeldCounts>,
}

/// The parts of a model during construction.
#[derive(Default)]
pub(super) struct Draft {
    geometries: Vec<Geometry>,
    instances: Vec<Instance>,
    placements: Vec<Placement>,
    meshes: Vec<usize>,
    weld_counts: Vec<WeldCounts>,
}

/// Merges and welds every mesh of the file, then places those of the chosen scene.
pub(super) fn build(reader: &Reader<'_>, graph: &Graph, skins: &[LoadedSkin], weld: Weld) -> Result<Built, GltfError> {
    let document = reader.document;
    let mut draft = Draft::default();
    let mut rigid_variants = vec![None; document.meshes.len()];
    let mut extra = Vec::new();
    let users = users(document);
    for (mesh, users) in users.iter().enumerate() {
        let mark = reader.budget.mark();
        let merged = geometry::merge(reader, mesh, users.skinned.first().copied())?;
        check_joints(document, &users.skinned, &merged, skins)?;
        let kept = draft.push(reader, mesh, &merged.geometry, weld)?;
        drop(merged);
        reader.budget.settle(mark, kept);
        if !users.skinned.is_empty() && users.rigid {
            extra.push(mesh);
        }
    }
    for mesh in extra {
        rigid_variants[mesh] = Some(draft.geometries.len());
        let mark = reader.budget.mark();
        let merged = geometry::merge(reader, mesh, None)?;
        let kept = draft.push(reader, mesh, &merged.geometry, weld)?;
        drop(merged);
        reader.budget.settle(mark, kept);
    }
    let geometry_of = |mesh: usize, node: &Node| match node.skin {
        Some(_) => mesh,
        None => rigid_variants[mesh].unwrap_or(mesh),
    };
    for (n, node) in document.nodes.iter().enumerate() {
        if let Some(mesh) = node.mesh {
            check_weights(document, n, node, mesh)?;
        }
    }
    for &n in &graph.scene {
        let node = &document.nodes[n];
        let Some(mesh) = node.mesh else {
            continue;
        };
        for frame in frames(reader, n, node)? {
            let placement = Placement { mesh, node: Some(n), frame };
            draft.place(reader, geometry_of(mesh, node), node.name.as_ref(), placement, skins)?;
        }
    }
    if document.scenes.is_empty() {
        for (mesh, _) in users.iter().enumerate().filter(|(_, users)| users.none()) {
            let placement = Placement { mesh, node: None, frame: Frame::Node(DAffine3::IDENTITY) };
            let name = document.meshes[mesh].name.as_ref();
            draft.place(reader, mesh, name, placement, skins)?;
        }
    }
    let Draft { geometries, instances, placements, meshes, weld_counts } = draft;
    let model =
        Model::new(geometries, instances).map_err(|source| GltfError::Model { place: "nodes".to_owned(), source })?;
    Ok(Built { model, placements, meshes, weld_counts })
}

/// The nodes that use a mesh, in any scene.
#[derive(Clone, Debug, Default)]
struct Users {
    /// Nodes with a skin.
    skinned: Vec<usize>,
    /// Whether nodes without a skin use it.
    rigid: bool,
}

impl Users {
    fn none(&self) -> bool {
        self.skinned.is_empty() && !self.rigid
    }
}

fn users(document: &Document) -> Vec<Users> {
    let mut users = vec![Users::default(); document.meshes.len()];
    for (n, node) in document.nodes.iter().enumerate() {
        match (node.mesh, node.skin) {
            (Some(mesh), Some(_)) => users[mesh].skinned.push(n),
            (Some(mesh), None) => users[mesh].rigid = true,
            (None, _) => {}
        }
    }
    users
}

/// Checks that every joint that a vertex follows is in each skin that is used with the mesh.
fn check_joints(document: &Document, users: &[usize], merged: &Merged, skins: &[LoadedSkin]) -> Result<(), GltfError> {
    let Some(highest) = merged.highest_joints.iter().max_by_key(|highest| highest.joint) else {
        return Ok(());
    };
    for &node in users {
        let Some(skin) = document.nodes[node].skin else {
            continue;
        };
        let joints = skins[skin].joints.len();
        if highest.joint as usize >= joints {
            return Err(GltfError::JointOutOfRange {
                place: highest.place.clone(),
                vertex: highest.vertex,
                joint: highest.joint,
                node,
                skin,
                joints,
            });
        }
    }
    Ok(())
}

fn check_weights(document: &Document, n: usize, node: &Node, mesh: usize) -> Result<(), GltfError> {
    let expected = document.meshes[mesh].targets;
    match &node.weights {
        Some(weights) if weights.len() != expected => {
            Err(GltfError::Count { place: format!("nodes[{n}].weights"), count: weights.len(), expected })
        }
        _ => Ok(()),
    }
}

/// The frames of a node's mesh: one, or one for each of its GPU instances.
fn frames(reader: &Reader<'_>, n: usize, node: &Node) -> Result<Vec<Frame>, GltfError> {
    match (node.skin, &node.instancing) {
        (Some(_), Some(_)) => Err(GltfError::InstancedSkin { node: n }),
        (Some(skin), None) => Ok(vec![Frame::Skin(skin)]),
        (None, None) => Ok(vec![Frame::Node(DAffine3::IDENTITY)]),
        (None, Some(instancing)) => instanced(reader, n, instancing),
    }
}

fn instanced(reader: &Reader<'_>, n: usize, instancing: &Instancing) -> Result<Vec<Frame>, GltfError> {
    let place = format!("nodes[{n}].extensions.EXT_mesh_gpu_instancing.attributes");
    let attributes =
        [("TRANSLATION", instancing.translation), ("ROTATION", instancing.rotation), ("SCALE", instancing.scale)];
    let mut count = None;
    for (name, accessor) in attributes {
        let Some(accessor) = accessor else {
            continue;
        };
        let found = reader.count(accessor);
        let expected = *count.get_or_insert(found);
        if found != expected {
            return Err(GltfError::Count { place: format!("{place}.{name}"), count: found, expected });
        }
    }
    let count = count.ok_or_else(|| GltfError::Missing { place: format!("{place}.TRANSLATION") })?;
    let vectors = |name: &str, accessor: Option<usize>| {
        let place = format!("{place}.{name}");
        accessor.map(|accessor| reader.vectors::<3>(accessor, formats::VECTORS, &place)).transpose()
    };
    let translations = vectors("TRANSLATION", instancing.translation)?;
    let scales = vectors("SCALE", instancing.scale)?;
    let rotations = match instancing.rotation {
        Some(accessor) => Some(reader.vectors::<4>(accessor, formats::ROTATIONS, &format!("{place}.ROTATION"))?),
        None => None,
    };
    reader.charge(count as u64, 3 * size_of::<Frame>() as u64, &|| place.clone())?;
    let vector = |vectors: &Option<Vec<[f32; 3]>>, i: usize| {
        vectors.as_ref().map(|vectors| DVec3::from_array(vectors[i].map(f64::from)))
    };
    (0..count)
        .map(|i| {
            let mut trs = Trs::IDENTITY;
            trs.translation = vector(&translations, i).unwrap_or(trs.translation);
            trs.scale = vector(&scales, i).unwrap_or(trs.scale);
            if let Some(rotations) = &rotations {
                trs.rotation = unit(rotations[i].map(f64::from)).ok_or_else(|| GltfError::Transform {
                    place: format!("{place}.ROTATION, instance {i}"),
                    problem: "the quaternion has no direction; write (0, 0, 0, 1) for no rotation",
                })?;
            }
            Ok(Frame::Node(trs.matrix()))
        })
        .collect()
}

impl Draft {
    /// Welds a mesh, and returns the bytes that are kept of it.
    fn push(&mut self, reader: &Reader<'_>, mesh: usize, geometry: &Geometry, weld: Weld) -> Result<u64, GltfError> {
        reader.budget.charge_welding(geometry, weld, &|| format!("meshes[{mesh}]"))?;
        let (welded, counts) = geometry.welded(weld);
        let kept = budget::kept(&welded);
        self.geometries.push(welded);
        self.weld_counts.push(counts);
        self.meshes.push(mesh);
        Ok(kept)
    }

    /// Charges the lights of the chosen scene, as they are when they are asked for, with their names.
    pub(super) fn charge_lights(reader: &Reader<'_>, graph: &Graph) -> Result<(), GltfError> {
        let document = reader.document;
        for &n in &graph.scene {
            let node = &document.nodes[n];
            let Some(light) = node.light else {
                continue;
            };
            let name = document.lights[light].name.as_ref().or(node.name.as_ref()).map_or(0, String::len);
            // A list that doubles.
            let bytes = 3 * size_of::<SceneLight>() + name;
            reader.charge(1, bytes as u64, &|| format!("nodes[{n}] (its light)"))?;
        }
        Ok(())
    }

    /// Adds an instance, unless its geometry has no faces.
    fn place(
        &mut self,
        reader: &Reader<'_>,
        geometry: usize,
        name: Option<&String>,
        placement: Placement,
        skins: &[LoadedSkin],
    ) -> Result<(), GltfError> {
        let shape = &self.geometries[geometry];
        if shape.faces().is_empty() {
            return Ok(());
        }
        let matrices = match placement.frame {
            Frame::Node(_) => 1,
            Frame::Skin(skin) => skins[skin].joints.len(),
        };
        let what = || format!("meshes[{}] (its instances)", placement.mesh);
        reader.budget.charge_instance(shape, matrices, name, &what)?;
        self.instances.push(Instance::new(geometry, name.cloned()));
        self.placements.push(placement);
        Ok(())
    }
}
