//! Builds the model: the geometries of every mesh, and the instances of the chosen scene.

use glam::{DAffine3, DVec3};

use super::budget;
use super::document::{Document, INSTANCED, Named, Node, Part, Trs, checked, unit};
use super::error::GltfError;
use super::geometry::{self, Merged};
use super::graph::Graph;
use super::info::SceneLight;
use super::reader::{self, Reader};
use super::skin::LoadedSkin;
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

/// The transform of an instance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Frame {
    /// The node's world matrix times this matrix.
    Node(DAffine3),
    /// The joints of a skin. The node's own matrix does not matter.
    Skin(usize),
}

/// The origin of an instance of the model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) mesh: usize,
    /// The node. `None`: a mesh that no node names, in a file without scenes.
    pub(super) node: Option<usize>,
    pub(super) frame: Frame,
}

/// The parts of a model during construction.
struct Draft<'a> {
    reader: &'a Reader<'a>,
    skins: &'a [Part<LoadedSkin>],
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
    let (geometries, instances, placements) = (Vec::new(), Vec::new(), Vec::new());
    let (meshes, weld_counts) = (Vec::new(), Vec::new());
    let mut draft = Draft { reader, skins, geometries, instances, placements, meshes, weld_counts };
    let users = users(document, graph);
    for (mesh, users) in users.iter().enumerate() {
        draft.add(mesh, users, !users.skinned.is_empty(), weld)?;
    }
    let mut rigid_variants = vec![None; users.len()];
    for (mesh, users) in users.iter().enumerate().filter(|(_, users)| !users.skinned.is_empty() && users.rigid) {
        rigid_variants[mesh] = Some(draft.geometries.len());
        draft.add(mesh, users, false, weld)?;
    }
    for &n in &graph.scene {
        graph.check(document, n)?;
        let Named { name, content: node, .. } = &document.nodes[n];
        let Some(mesh) = node.mesh else {
            continue;
        };
        if let Some(skin) = node.skin {
            checked(&skins[skin])?.joints.iter().try_for_each(|&joint| graph.check(document, joint))?;
        }
        let rigid = rigid_variants[mesh].filter(|_| node.skin.is_none());
        for frame in frames(reader, n, node)? {
            let placement = Placement { mesh, node: Some(n), frame };
            draft.place(rigid.unwrap_or(mesh), name.as_ref(), placement)?;
        }
    }
    if document.scenes.is_empty() {
        for (mesh, _) in users.iter().enumerate().filter(|(_, users)| users.none()) {
            let placement = Placement { mesh, node: None, frame: Frame::Node(DAffine3::IDENTITY) };
            draft.place(mesh, document.meshes[mesh].name.as_ref(), placement)?;
        }
    }
    let Draft { geometries, instances, placements, meshes, weld_counts, .. } = draft;
    let model =
        Model::new(geometries, instances).map_err(|source| GltfError::Model { place: "nodes".to_owned(), source })?;
    Ok(Built { model, placements, meshes, weld_counts })
}

/// Charges the lights of the chosen scene, as they are when they are asked for, with their names.
pub(super) fn charge_lights(reader: &Reader<'_>, graph: &Graph) -> Result<(), GltfError> {
    let document = reader.document;
    for &n in &graph.scene {
        let node = &document.nodes[n];
        if let Some(Ok(light)) = node.light {
            let name = document.lights[light].0.as_ref().or(node.name.as_ref()).map_or(0, String::len);
            // A list that doubles.
            let bytes = 3 * size_of::<SceneLight>() + name;
            reader.charge(1, bytes as u64, &|| format!("nodes[{n}] (its light)"))?;
        }
    }
    Ok(())
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

/// Checks that every joint that a vertex follows is in each skin that is used with the mesh. It is an error for users that are
/// shown.
fn check_joints(
    reader: &Reader<'_>,
    users: &Users,
    merged: &Merged,
    skins: &[Part<LoadedSkin>],
) -> Result<(), GltfError> {
    let Some(highest) = merged.highest_joints.iter().max_by_key(|highest| highest.joint) else {
        return Ok(());
    };
    for (number, &node) in users.skinned.iter().enumerate() {
        let Some(skin) = reader.document.nodes[node].skin else { continue };
        let Ok(loaded) = &skins[skin] else { continue };
        let (joint, joints) = (highest.joint, loaded.joints.len());
        if joint as usize >= joints {
            let place = format!("{}, vertex {}", highest.place, highest.vertex);
            let problem = format!(" names joint {joint}, but skins[{skin}] of nodes[{node}] has {joints} joints");
            let fault = Err(GltfError::invalid(place, problem));
            if number < users.skinned_shown {
                return fault;
            }
            reader.warnings.leave_out(fault)?;
        }
    }
    Ok(())
}

/// The frames of a node's mesh: one, or one for each of its GPU instances.
fn frames(reader: &Reader<'_>, n: usize, node: &Node) -> Result<Vec<Frame>, GltfError> {
    match (node.skin, node.instancing) {
        (Some(_), Some(_)) => {
            let problem = " has both a skin and EXT_mesh_gpu_instancing; remove one";
            Err(GltfError::invalid(format!("nodes[{n}]"), problem))
        }
        (Some(skin), None) => Ok(vec![Frame::Skin(skin)]),
        (None, None) => Ok(vec![Frame::Node(DAffine3::IDENTITY)]),
        (None, Some(instancing)) => instanced(reader, n, instancing),
    }
}

fn instanced(reader: &Reader<'_>, n: usize, accessors: [Option<usize>; 3]) -> Result<Vec<Frame>, GltfError> {
    let place = format!("nodes[{n}].extensions.EXT_mesh_gpu_instancing.attributes");
    let places = INSTANCED.map(|name| format!("{place}.{name}"));
    let mut count = None;
    for (accessor, place) in accessors.iter().zip(&places) {
        let Some(accessor) = *accessor else { continue };
        let found = reader.count(accessor)?;
        reader.check_count(accessor, *count.get_or_insert(found), place)?;
    }
    let count = count.ok_or_else(|| GltfError::missing(&*places[0]))?;
    let vectors = |at: usize| {
        accessors[at].map(|accessor| reader.vectors::<3>(accessor, reader::VECTORS, &places[at])).transpose()
    };
    let (translations, scales) = (vectors(0)?, vectors(2)?);
    let rotations = accessors[1].map(|accessor| reader.vectors::<4>(accessor, reader::ROTATIONS, &places[1]));
    let rotations = rotations.transpose()?;
    let is_zero = |rotation: &[f32; 4]| *rotation == [0.0; 4];
    if let Some(first) = rotations.iter().flatten().position(is_zero) {
        reader.warnings.push(GltfWarning::no_rotation(format!("{}, instance {first}", places[1])))?;
    }
    reader.charge(count as u64, 3 * size_of::<Frame>() as u64, &|| place.clone())?;
    let vector = |vectors: &Option<Vec<[f32; 3]>>, i: usize| {
        vectors.as_ref().map(|vectors| DVec3::from_array(vectors[i].map(f64::from)))
    };
    let frame = |i: usize| {
        let mut trs = Trs::IDENTITY;
        trs.translation = vector(&translations, i).unwrap_or(trs.translation);
        trs.scale = vector(&scales, i).unwrap_or(trs.scale);
        if let Some(rotation) = rotations.as_ref().map(|all| all[i]).filter(|rotation| !is_zero(rotation)) {
            let place = || format!("{}, instance {i}", places[1]);
            trs.rotation = unit(rotation.map(f64::from))
                .ok_or_else(|| GltfError::invalid(place(), ": the quaternion is not finite"))?;
        }
        Ok(Frame::Node(trs.matrix()))
    };
    (0..count).map(frame).collect()
}

impl Draft<'_> {
    /// Merges and welds a mesh, with a skin or without. A fault is an error only where something shows the mesh.
    fn add(&mut self, mesh: usize, users: &Users, is_skinned: bool, weld: Weld) -> Result<(), GltfError> {
        let Reader { document, budget, warnings, .. } = self.reader;
        let mark = budget.mark();
        let skinned_by = users.skinned.first().copied().filter(|_| is_skinned);
        let geometry = match geometry::merge(self.reader, mesh, skinned_by) {
            Ok(merged) => {
                if is_skinned {
                    check_joints(self.reader, users, &merged, self.skins)?;
                }
                merged.geometry
            }
            Err(fault) if users.is_shown(is_skinned, document) => return Err(fault),
            Err(fault) => {
                warnings.leave_out::<()>(Err(fault))?;
                let name = document.meshes[mesh].name.clone();
                let empty = Geometry::new(Vec::new(), Vec::new(), GeometryOptions { name, ..Default::default() });
                empty.map_err(|source| GltfError::Model { place: format!("meshes[{mesh}]"), source })?
            }
        };
        budget.charge_welding(&geometry, weld, &|| format!("meshes[{mesh}]"))?;
        let (welded, counts) = geometry.welded(weld);
        drop(geometry);
        budget.settle(mark, budget::kept(&welded));
        self.geometries.push(welded);
        self.weld_counts.push(counts);
        self.meshes.push(mesh);
        Ok(())
    }

    /// Adds an instance, unless its geometry has no faces.
    fn place(&mut self, geometry: usize, name: Option<&String>, placement: Placement) -> Result<(), GltfError> {
        let shape = &self.geometries[geometry];
        if shape.faces().is_empty() {
            return Ok(());
        }
        let matrices = match placement.frame {
            Frame::Node(_) => 1,
            Frame::Skin(skin) => self.skins[skin].as_ref().map_or(0, |skin| skin.joints.len()),
        };
        let what = || format!("meshes[{}] (its instances)", placement.mesh);
        self.reader.budget.charge_instance(shape, matrices, name, &what)?;
        self.instances.push(Instance::new(geometry, name.cloned()));
        self.placements.push(placement);
        Ok(())
    }
}
