//! Builds the model: the geometries of every mesh, and the instances of the chosen scene.

use glam::{DAffine3, DVec3};

use super::budget;
use super::document::{Document, Instancing, Node, Part, Trs};
use super::error::GltfError;
use super::formats;
use super::geometry::{self, Merged};
use super::graph::Graph;
use super::placement::{Frame, Placement};
use super::reader::Reader;
use super::scene_light::SceneLight;
use super::skin::LoadedSkin;
use super::transforms::unit;
use super::warning::GltfWarning;
use crate::mesh::{Weld, WeldCounts};
use crate::model::{Geometry, GeometryOptions, Instance, Model};

/// A model with the data that its poses and reports need.
#[derive(Debug)]
pub(super) struct Built {
    pub(super) model: Model,
    /// The origin of each instance.
    pub(super) placements: Vec<Placement>,
    /// The mesh of each geometry.
    pub(super) meshes: Vec<usize>,
    /// Result of welding each geometry.
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
pub(super) fn build(
    reader: &Reader<'_>,
    graph: &Graph,
    skins: &[Part<LoadedSkin>],
    weld: Weld,
) -> Result<Built, GltfError> {
    let document = reader.document;
    let mut draft = Draft::default();
    let mut rigid_variants = vec![None; document.meshes.len()];
    let mut extra = Vec::new();
    let users = users(document, graph);
    for (mesh, users) in users.iter().enumerate() {
        let mark = reader.budget.mark();
        let merged = geometry::merge(reader, mesh, users.skinned.first().copied());
        let is_needed = users.is_shown(!users.skinned.is_empty(), document);
        let geometry = match merged {
            Ok(merged) => {
                check_joints(reader, &users.skinned, users.skinned_shown, &merged, skins)?;
                merged.geometry
            }
            Err(fault) if is_needed => return Err(fault),
            Err(fault) => left_out(reader, mesh, fault)?,
        };
        let kept = draft.push(reader, mesh, &geometry, weld)?;
        drop(geometry);
        reader.budget.settle(mark, kept);
        if !users.skinned.is_empty() && users.rigid {
            extra.push(mesh);
        }
    }
    for mesh in extra {
        rigid_variants[mesh] = Some(draft.geometries.len());
        let mark = reader.budget.mark();
        let geometry = match geometry::merge(reader, mesh, None) {
            Ok(merged) => merged.geometry,
            Err(fault) if users[mesh].is_shown(false, document) => return Err(fault),
            Err(fault) => left_out(reader, mesh, fault)?,
        };
        let kept = draft.push(reader, mesh, &geometry, weld)?;
        drop(geometry);
        reader.budget.settle(mark, kept);
    }
    let geometry_of = |mesh: usize, node: &Node| match node.skin {
        Some(_) => mesh,
        None => rigid_variants[mesh].unwrap_or(mesh),
    };
    for &n in &graph.scene {
        graph.check(document, n)?;
        let node = &document.nodes[n];
        let Some(mesh) = node.mesh else {
            continue;
        };
        if let Some(skin) = node.skin {
            let skin = skins[skin].as_ref().map_err(|fault| GltfError::clone(fault))?;
            skin.joints.iter().try_for_each(|&joint| graph.check(document, joint))?;
        }
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

/// An empty geometry for a mesh that is at fault, and that nothing shows.
fn left_out(reader: &Reader<'_>, mesh: usize, fault: GltfError) -> Result<Geometry, GltfError> {
    reader.warnings.leave_out::<()>(Err(fault))?;
    let options = GeometryOptions { name: reader.document.meshes[mesh].name.clone(), ..GeometryOptions::default() };
    let empty = Geometry::new(Vec::new(), Vec::new(), options);
    empty.map_err(|source| GltfError::Model { place: format!("meshes[{mesh}]"), source })
}

/// The nodes that use a mesh, in any scene.
#[derive(Clone, Debug, Default)]
struct Users {
    /// Nodes with a skin. Nodes that are shown come first.
    skinned: Vec<usize>,
    /// How many of them are shown.
    skinned_shown: usize,
    /// Whether nodes without a skin use it.
    rigid: bool,
    /// Whether one of these is shown.
    rigid_shown: bool,
}

impl Users {
    fn none(&self) -> bool {
        self.skinned.is_empty() && !self.rigid
    }

    /// Whether the mesh is shown, with a skin or without.
    fn is_shown(&self, skinned: bool, document: &Document) -> bool {
        // A file without scenes shows meshes that no node names.
        let is_alone = self.none() && document.scenes.is_empty();
        if skinned { self.skinned_shown > 0 } else { self.rigid_shown || is_alone }
    }
}

fn users(document: &Document, graph: &Graph) -> Vec<Users> {
    let mut users = vec![Users::default(); document.meshes.len()];
    let mut is_shown = vec![false; document.nodes.len()];
    graph.scene.iter().for_each(|&n| is_shown[n] = true);
    let shown = (0..is_shown.len()).filter(|&n| is_shown[n]);
    for n in shown.chain((0..is_shown.len()).filter(|&n| !is_shown[n])) {
        let node = &document.nodes[n];
        let Some(users) = node.mesh.map(|mesh| &mut users[mesh]) else { continue };
        if node.skin.is_some() {
            users.skinned.push(n);
            users.skinned_shown += usize::from(is_shown[n]);
        } else {
            users.rigid = true;
            users.rigid_shown |= is_shown[n];
        }
    }
    users
}

/// Checks that every joint that a vertex follows is in each skin that is used with the mesh. It is an error for the first
/// `shown` of the mesh's users.
fn check_joints(
    reader: &Reader<'_>,
    users: &[usize],
    shown: usize,
    merged: &Merged,
    skins: &[Part<LoadedSkin>],
) -> Result<(), GltfError> {
    let Some(highest) = merged.highest_joints.iter().max_by_key(|highest| highest.joint) else {
        return Ok(());
    };
    for (number, &node) in users.iter().enumerate() {
        let Some(skin) = reader.document.nodes[node].skin else { continue };
        let Ok(loaded) = &skins[skin] else { continue };
        let joints = loaded.joints.len();
        if highest.joint as usize >= joints {
            let fault = GltfError::JointOutOfRange {
                place: highest.place.clone(),
                vertex: highest.vertex,
                joint: highest.joint,
                node,
                skin,
                joints,
            };
            if number < shown {
                return Err(fault);
            }
            reader.warnings.leave_out::<()>(Err(fault))?;
        }
    }
    Ok(())
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
        let found = reader.count(accessor)?;
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
    let is_zero = |rotation: &[f32; 4]| *rotation == [0.0; 4];
    if let Some(first) = rotations.iter().flatten().position(is_zero) {
        let place = format!("{place}.ROTATION, instance {first}");
        reader.warnings.push(GltfWarning::Rotation { place })?;
    }
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
                let given = if is_zero(&rotations[i]) { [0.0, 0.0, 0.0, 1.0] } else { rotations[i] };
                trs.rotation = unit(given.map(f64::from)).ok_or_else(|| GltfError::Transform {
                    place: format!("{place}.ROTATION, instance {i}"),
                    problem: "the quaternion is not finite",
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
            let Some(Ok(light)) = node.light else {
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
        skins: &[Part<LoadedSkin>],
    ) -> Result<(), GltfError> {
        let shape = &self.geometries[geometry];
        if shape.faces().is_empty() {
            return Ok(());
        }
        let matrices = match placement.frame {
            Frame::Node(_) => 1,
            Frame::Skin(skin) => skins[skin].as_ref().map_or(0, |skin| skin.joints.len()),
        };
        let what = || format!("meshes[{}] (its instances)", placement.mesh);
        reader.budget.charge_instance(shape, matrices, name, &what)?;
        self.instances.push(Instance::new(geometry, name.cloned()));
        self.placements.push(placement);
        Ok(())
    }
}
