//! Builds the model: the geometries of every mesh, and the instances of the chosen scene.

use std::collections::HashSet;

use glam::{DAffine3, DVec3};

use super::budget;
use super::camera::SceneCamera;
use super::colors::{self, Colors};
use super::document::{Document, Frame, INSTANCED, Node, Part, Placement, Trs, checked, unit};
use super::error::GltfError;
use super::geometry::{self, Merged};
use super::graph::Graph;
use super::info::SceneLight;
use super::reader::{self, Reader};
use super::skin::LoadedSkin;
use super::vertices::HighestJoint;
use super::warning::GltfWarning;
use crate::mesh::{Weld, WeldCounts};
use crate::model::{Geometry, GeometryOptions, Instance, Model};

/// A model with the data that its poses and reports need.
#[derive(Debug, Default)]
pub(super) struct Built {
    pub(super) model: Model,
    /// The colours of each geometry.
    pub(super) colors: Vec<Colors>,
    /// The origin of each instance.
    pub(super) placements: Vec<Placement>,
    /// The mesh of each geometry: every mesh in order, so the first indices are equal, then rigid variants.
    pub(super) meshes: Vec<usize>,
    /// Result of welding each geometry.
    pub(super) weld_counts: Vec<WeldCounts>,
}

/// A model during construction: its parts, and all but the model.
struct Draft<'a> {
    reader: &'a Reader<'a>,
    skins: &'a [Part<LoadedSkin>],
    geometries: Vec<Geometry>,
    instances: Vec<Instance>,
    built: Built,
}

/// Merges and welds every mesh of the file, then adds the instances of the chosen scene.
pub(super) fn build(
    reader: &Reader<'_>,
    graph: &Graph,
    skins: &[Part<LoadedSkin>],
    weld: Weld,
) -> Result<Built, GltfError> {
    let document = reader.document;
    let mut draft = Draft { reader, skins, geometries: Vec::new(), instances: Vec::new(), built: Built::default() };
    let users = users(document, graph);
    let (is_skinned, is_rigid) = (|user: &User| user.skin.is_some(), |user: &User| user.skin.is_none());
    for (mesh, users) in users.iter().enumerate() {
        draft.add(mesh, users, users.iter().any(is_skinned), weld)?;
    }
    let mut rigid_variants = vec![None; users.len()];
    for (mesh, users) in users.iter().enumerate() {
        if users.iter().any(is_skinned) && users.iter().any(is_rigid) {
            rigid_variants[mesh] = Some(draft.geometries.len());
            draft.add(mesh, users, false, weld)?;
        }
    }
    // Many nodes may share a skin of many joints.
    let mut checked_skins = HashSet::new();
    for &n in &graph.scene {
        graph.check(document, n)?;
        let node = &document.nodes[n];
        let Some(mesh) = node.mesh else {
            continue;
        };
        if let Some(skin) = node.skin.filter(|&skin| checked_skins.insert(skin)) {
            checked(&skins[skin])?.joints.iter().try_for_each(|&joint| graph.check(document, joint))?;
        }
        let rigid = rigid_variants[mesh].filter(|_| node.skin.is_none());
        for frame in frames(reader, n, node)? {
            let placement = Placement { mesh, node: Some(n), frame };
            draft.add_instance(rigid.unwrap_or(mesh), node.name.as_ref(), placement)?;
        }
    }
    if document.scenes.is_empty() {
        for (mesh, _) in users.iter().enumerate().filter(|(_, users)| users.is_empty()) {
            let placement = Placement { mesh, node: None, frame: Frame::Node(DAffine3::IDENTITY) };
            draft.add_instance(mesh, document.meshes[mesh].name.as_ref(), placement)?;
        }
    }
    let model = Model::new(draft.geometries, draft.instances).map_err(GltfError::model("nodes"))?;
    Ok(Built { model, ..draft.built })
}

/// Charges the lights that the chosen scene shows and all its cameras, as callers get them, with their names.
pub(super) fn charge_lights_and_cameras(reader: &Reader<'_>, graph: &Graph) -> Result<(), GltfError> {
    let document = reader.document;
    // In a list that doubles.
    let charge = |n: usize, size: usize, name: Option<&String>, what: &str| {
        let bytes = 3 * size + name.or(document.nodes[n].name.as_ref()).map_or(0, String::len);
        reader.budget.charge(1, bytes as u64, &|| format!("nodes[{n}] (its {what})"))
    };
    for &n in &graph.scene {
        if let Some(Ok(light)) = document.nodes[n].light {
            charge(n, size_of::<SceneLight>(), document.lights[light].name.as_ref(), "light")?;
        }
    }
    for &n in &graph.all {
        if let Some(Ok(camera)) = document.nodes[n].camera {
            charge(n, size_of::<SceneCamera>(), document.cameras[camera].name.as_ref(), "camera")?;
        }
    }
    Ok(())
}

/// A node that uses a mesh, in any scene.
#[derive(Clone, Copy, Debug)]
struct User {
    node: usize,
    skin: Option<usize>,
    is_shown: bool,
}

/// The users of each mesh. Nodes that are shown come first.
fn users(document: &Document, graph: &Graph) -> Vec<Vec<User>> {
    let mut users = vec![Vec::new(); document.meshes.len()];
    let mut is_shown = vec![false; document.nodes.len()];
    graph.scene.iter().for_each(|&n| is_shown[n] = true);
    for shown in [true, false] {
        for (node, of_node) in document.nodes.iter().enumerate().filter(|&(node, _)| is_shown[node] == shown) {
            if let Some(mesh) = of_node.mesh {
                users[mesh].push(User { node, skin: of_node.skin, is_shown: shown });
            }
        }
    }
    users
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
    let json_path = format!("nodes[{n}].extensions.EXT_mesh_gpu_instancing.attributes");
    let json_paths = INSTANCED.map(|name| format!("{json_path}.{name}"));
    let mut count = None;
    for (accessor, json_path) in accessors.iter().zip(&json_paths) {
        let Some(accessor) = *accessor else { continue };
        let found = reader.count(accessor)?;
        reader.check_count(accessor, *count.get_or_insert(found), json_path)?;
    }
    let count = count.ok_or_else(|| GltfError::missing(&*json_paths[0]))?;
    let vectors = |at: usize| {
        accessors[at].map(|accessor| reader.vectors::<3>(accessor, reader::VECTORS, &json_paths[at])).transpose()
    };
    let (translations, scales) = (vectors(0)?, vectors(2)?);
    let rotations = accessors[1].map(|accessor| reader.vectors::<4>(accessor, reader::ROTATIONS, &json_paths[1]));
    let rotations = rotations.transpose()?;
    let is_zero = |rotation: &[f32; 4]| *rotation == [0.0; 4];
    if let Some(first) = rotations.iter().flatten().position(is_zero) {
        reader.warnings.push(GltfWarning::no_rotation(format!("{}, instance {first}", json_paths[1])))?;
    }
    reader.budget.charge(count as u64, 3 * size_of::<Frame>() as u64, &|| json_path.clone())?;
    let vector = |vectors: &Option<Vec<[f32; 3]>>, i: usize| {
        vectors.as_ref().map(|vectors| DVec3::from_array(vectors[i].map(f64::from)))
    };
    let frame = |i: usize| {
        let mut trs = Trs::default();
        trs.translation = vector(&translations, i).unwrap_or(trs.translation);
        trs.scale = vector(&scales, i).unwrap_or(trs.scale);
        if let Some(rotation) = rotations.as_ref().map(|all| all[i]).filter(|rotation| !is_zero(rotation)) {
            let json_path = || format!("{}, instance {i}", json_paths[1]);
            trs.rotation = unit(rotation.map(f64::from))
                .ok_or_else(|| GltfError::invalid(json_path(), ": the quaternion is not finite"))?;
        }
        Ok(Frame::Node(trs.matrix()))
    };
    (0..count).map(frame).collect()
}

impl Draft<'_> {
    /// Merges and welds a mesh, with a skin or without. A fault is an error only where something shows the mesh.
    fn add(&mut self, mesh: usize, users: &[User], is_skinned: bool, weld: Weld) -> Result<(), GltfError> {
        let Reader { document, budget, warnings, .. } = self.reader;
        let mark = budget.mark();
        let mut these = users.iter().filter(|user| user.skin.is_some() == is_skinned);
        let skinned_by = these.clone().next().filter(|_| is_skinned).map(|user| user.node);
        // A file without scenes shows meshes that no node names.
        let is_alone = users.is_empty() && document.scenes.is_empty();
        let (geometry, mut colors) = match geometry::merge(self.reader, mesh, skinned_by) {
            Ok(Merged { geometry, colors, highest_joints }) => {
                let highest = highest_joints.iter().max_by_key(|highest| highest.joint);
                these.try_for_each(|user| highest.map_or(Ok(()), |highest| self.check_joints(user, highest)))?;
                (geometry, colors)
            }
            Err(fault) if is_alone || these.any(|user| user.is_shown) => return Err(fault),
            Err(fault) => {
                warnings.leave_out::<()>(Err(fault))?;
                let name = document.meshes[mesh].name.clone();
                let empty = Geometry::new(Vec::new(), Vec::new(), GeometryOptions { name, ..Default::default() });
                (empty.map_err(GltfError::model(format!("meshes[{mesh}]")))?, Colors::default())
            }
        };
        budget.charge_welding(&geometry, weld, &|| format!("meshes[{mesh}]"))?;
        if colors.vertices.is_some() {
            let [vertex, face] = colors::WELDING;
            budget.charge(geometry.positions().len() as u64, vertex, &|| format!("meshes[{mesh}]"))?;
            budget.charge(geometry.faces().len() as u64, face, &|| format!("meshes[{mesh}]"))?;
            colors.split_seams(geometry.positions(), geometry.faces().iter().map(<[u32; 3]>::as_slice));
        }
        let (welded, counts) = geometry.welded(weld);
        let colors = colors.welded(geometry.faces(), &welded);
        drop(geometry);
        budget.settle(mark, budget::remaining_bytes(&welded) + colors.bytes());
        self.geometries.push(welded);
        self.built.colors.push(colors);
        self.built.weld_counts.push(counts);
        self.built.meshes.push(mesh);
        Ok(())
    }

    /// Checks that the skin of a user has the highest joint that its mesh names. It is an error where the user is shown.
    fn check_joints(&self, user: &User, highest: &HighestJoint) -> Result<(), GltfError> {
        let &User { node, is_shown, .. } = user;
        let Some(skin) = user.skin else { return Ok(()) };
        let (joint, joints) = (highest.joint, self.skins[skin].as_ref().map_or(usize::MAX, |skin| skin.joints.len()));
        if (joint as usize) < joints {
            return Ok(());
        }
        let json_path = format!("{}, vertex {}", highest.json_path, highest.vertex);
        let problem = format!(" names joint {joint}, but skins[{skin}] of nodes[{node}] has {joints} joints");
        let fault = Err(GltfError::invalid(json_path, problem));
        if is_shown { fault } else { self.reader.warnings.leave_out(fault).map(drop) }
    }

    /// Adds an instance, unless its geometry has no faces.
    fn add_instance(&mut self, geometry: usize, name: Option<&String>, placement: Placement) -> Result<(), GltfError> {
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
        self.built.placements.push(placement);
        Ok(())
    }
}
