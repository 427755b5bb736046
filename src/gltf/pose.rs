//! Poses and lights at one time.

use std::collections::{BTreeSet, HashMap};

use glam::{DAffine3, DQuat, DVec3};

use super::animation::Channel;
use super::asset::Asset;
use super::document::{Frame, Named, Node, Part, Placement, Property, Trs, unit_vector};
use super::error::GltfError;
use super::info::{SceneLight, SceneLightKind, SpotCone};
use crate::light::Light;
use crate::model::{InstancePose, ModelError, Pose};

/// World matrices and morph weights of the nodes at one time, as animations set them. Matrices are relative to the asset's
/// origin.
pub(super) struct State {
    pub(super) world: Vec<DAffine3>,
    /// Only for nodes whose weights an animation moves.
    weights: HashMap<usize, Vec<f64>>,
}

/// The part of a list that a node has.
type PartOf = fn(&Node) -> Option<&Part<usize>>;

impl Asset {
    /// The state of the model at a time of its animations, in seconds. Several animations play together from the same
    /// start: `pose(0..2, 0.5)`. `None`, or an empty list, gives the state of the file at any time. Before the
    /// first key and after the last one, the nearest key applies. It is relative to [`Asset::origin`].
    ///
    /// # Errors
    /// [`GltfError`] for an animation that does not exist or is damaged, two that move the same property of a node,
    /// a time that is NaN, or a result that is not finite.
    pub fn pose(&self, animations: impl IntoIterator<Item = usize>, time_s: f32) -> Result<Pose, GltfError> {
        let state = self.state(animations, time_s)?;
        let (mut instances, mut mixed_determinants) = (Vec::with_capacity(self.built.placements.len()), 0);
        for (placement, instance) in self.built.placements.iter().zip(self.built.model.instances()) {
            let (posed, mixed) = self.instance(placement, instance.geometry(), &state);
            let Ok(posed) = posed else {
                let json_path = match placement.node {
                    Some(node) => format!("nodes[{node}]"),
                    None => format!("meshes[{}]", placement.mesh),
                };
                return Err(GltfError::NotFinite { json_path, time_s });
            };
            mixed_determinants += usize::from(mixed);
            instances.push(posed);
        }
        Ok(Pose { instances, mixed_determinants })
    }

    /// The lights of the chosen scene (`KHR_lights_punctual`) at a time in seconds, in world space, in the order of its
    /// nodes. Their positions are relative to [`Asset::origin`]. Lights of hidden nodes are left out.
    ///
    /// # Errors
    /// [`GltfError`] for animations or a time that [`Asset::pose`] refuses, and for a light that is damaged or not finite.
    /// [`Asset::each_light`] gives the others.
    pub fn lights(
        &self,
        animations: impl IntoIterator<Item = usize>,
        time_s: f32,
    ) -> Result<Vec<SceneLight>, GltfError> {
        self.each_light(animations, time_s)?.into_iter().collect()
    }

    /// The same as [`Asset::lights`], where a light that is damaged or not finite does not refuse the others.
    ///
    /// # Errors
    /// [`GltfError`] for animations or a time that [`Asset::pose`] refuses.
    pub fn each_light(
        &self,
        animations: impl IntoIterator<Item = usize>,
        time_s: f32,
    ) -> Result<Vec<Result<SceneLight, GltfError>>, GltfError> {
        let world = self.state(animations, time_s)?.world;
        let lights = self.nodes_with(&self.graph.scene, |node| node.light.as_ref());
        Ok(lights.map(|(n, light)| self.light(n, light, &world[n], time_s)).collect())
    }

    /// The name of each of [`Asset::each_light`], or that of its node.
    pub fn light_names(&self) -> Vec<Option<&str>> {
        self.names(&self.document.lights, self.nodes_with(&self.graph.scene, |node| node.light.as_ref()))
    }

    /// The nodes among these that have a part of a list: a light, or a camera.
    pub(super) fn nodes_with<'a>(
        &'a self,
        nodes: &'a [usize],
        part: PartOf,
    ) -> impl Iterator<Item = (usize, &'a Part<usize>)> {
        nodes.iter().filter_map(move |&n| Some((n, part(&self.document.nodes[n])?)))
    }

    /// The names of these parts of a list, or of their nodes.
    pub(super) fn names<'a, T>(
        &'a self,
        list: &'a [Named<T>],
        nodes: impl Iterator<Item = (usize, &'a Part<usize>)>,
    ) -> Vec<Option<&'a str>> {
        let name = |(n, part): (usize, &'a Part<usize>)| {
            let of_part = part.as_ref().ok().and_then(|&part| list[part].name.as_ref());
            of_part.or(self.document.nodes[n].name.as_ref()).map(String::as_str)
        };
        nodes.map(name).collect()
    }

    /// A part of a list that node `n` has, and the name of the part, or that of the node.
    pub(super) fn part_of<'a, T>(
        &'a self,
        n: usize,
        list: &'a [Named<T>],
        part: &Part<usize>,
    ) -> Result<(Option<String>, &'a T), Box<GltfError>> {
        let Named { name, part } = &list[*part.as_ref().map_err(Box::clone)?];
        let part = part.as_ref().map_err(Box::clone)?;
        Ok((name.clone().or_else(|| self.document.nodes[n].name.clone()), part))
    }

    /// The light of node `n`, whose world matrix is given.
    fn light(&self, n: usize, light: &Part<usize>, world: &DAffine3, time_s: f32) -> Result<SceneLight, GltfError> {
        let found = self.part_of(n, &self.document.lights, light);
        let (name, light) = found.map_err(|source| GltfError::DamagedLight { node: n, source })?;
        let backwards = unit_vector(world.matrix3.z_axis);
        let (w, xyz) = match light.kind {
            SceneLightKind::Directional => (0.0, backwards),
            SceneLightKind::Point | SceneLightKind::Spot => (1.0, world.translation),
        };
        let [x, y, z] = xyz.as_vec3().to_array();
        if ![x, y, z].iter().all(|c| c.is_finite()) {
            let json_path = format!("nodes[{n}]");
            return Err(GltfError::NotFinite { json_path, time_s });
        }
        let direction = (-backwards).as_vec3();
        let spot = |[inner_angle, outer_angle]: [f32; 2]| {
            let direction = direction.to_array();
            SpotCone { direction, inner_angle, outer_angle }
        };
        // A node without extent along Z gives its light no direction.
        let cone = light.cone.filter(|_| direction.is_finite()).map(spot);
        Ok(SceneLight {
            name,
            light: Light::homogeneous([x, y, z, w]),
            kind: light.kind,
            color: light.color,
            intensity: light.intensity,
            range: light.range,
            cone,
        })
    }

    pub(super) fn state(&self, animations: impl IntoIterator<Item = usize>, time_s: f32) -> Result<State, GltfError> {
        if time_s.is_nan() {
            return Err(GltfError::Time);
        }
        let nodes = &self.document.nodes;
        let mut moved: Vec<Trs> = nodes.iter().map(|node| node.trs).collect();
        let mut weights = HashMap::new();
        for channel in self.playing(animations)? {
            apply(channel, f64::from(time_s), &mut moved[channel.node], &mut weights);
        }
        let mut world = self.graph.world(|node| nodes[node].matrix.unwrap_or_else(|| moved[node].matrix()));
        let shift = self.shift();
        // A sum with zero would turn −0 into 0.
        if shift != DVec3::ZERO {
            for matrix in &mut world {
                matrix.translation += shift;
            }
        }
        Ok(State { world, weights })
    }

    /// The channels of the animations, each once. No two animations move the same property of a node.
    fn playing(&self, animations: impl IntoIterator<Item = usize>) -> Result<Vec<&Channel>, GltfError> {
        let count = self.animations.len();
        let (mut playing, mut added, mut moved) = (Vec::new(), BTreeSet::new(), HashMap::new());
        for index in animations {
            let channels = self.animations.get(index).ok_or(GltfError::NoAnimation { index, count })?;
            let channels =
                channels.as_ref().map_err(|fault| GltfError::DamagedAnimation { index, source: fault.clone() })?;
            if !added.insert(index) {
                continue;
            }
            for &Channel { node, property, .. } in channels {
                let first = *moved.entry((node, property)).or_insert(index);
                if first != index {
                    let property = property.name();
                    return Err(GltfError::SameProperty { first, second: index, node, property });
                }
            }
            playing.extend(channels);
        }
        Ok(playing)
    }

    /// The translation of the scene: from its zero to the world's, and from there to the origin.
    fn shift(&self) -> DVec3 {
        self.document.center - DVec3::from_array(self.origin.to_array())
    }

    /// The matrices of an instance: one, or one for each joint.
    pub(super) fn matrices(&self, placement: &Placement, state: &State) -> Vec<DAffine3> {
        match placement.frame {
            Frame::Node(local) => {
                let world = placement.node.map_or_else(|| DAffine3::from_translation(self.shift()), |n| state.world[n]);
                vec![world * local]
            }
            Frame::Skin(skin) => {
                // Loading refused a skin that is at fault and that an instance needs.
                let skin = self.skins[skin].as_ref().ok();
                let (joints, inverse_binds) = skin.map_or((&[][..], &[][..]), |s| (&s.joints, &s.inverse_binds));
                let joints = joints.iter().zip(inverse_binds);
                joints.map(|(&joint, inverse_bind)| state.world[joint] * *inverse_bind).collect()
            }
        }
    }

    /// The pose of an instance, and whether some of its joints mirror and some do not.
    fn instance(
        &self,
        placement: &Placement,
        geometry: usize,
        state: &State,
    ) -> (Result<InstancePose, ModelError>, bool) {
        let matrices = self.matrices(placement, state);
        let is_rigid = self.built.model.geometries()[geometry].influences().is_none();
        let used = if is_rigid { &[0] } else { &self.used_joints[geometry][..] };
        let determinants = used.iter().map(|&joint| matrices[joint as usize].matrix3.determinant());
        let mirrored = determinants.clone().filter(|determinant| *determinant < 0.0).count();
        let unmirrored = determinants.filter(|determinant| *determinant > 0.0).count();
        let palette = matrices.into_iter().map(Into::into).collect();
        let pose = InstancePose::with(palette, self.morph_weights(placement, state), mirrored > unmirrored);
        (pose, mirrored > 0 && unmirrored > 0)
    }

    pub(super) fn morph_weights(&self, placement: &Placement, state: &State) -> Vec<f32> {
        let animated = placement.node.and_then(|node| state.weights.get(&node));
        let of_node = placement.node.and_then(|node| self.document.nodes[node].weights.as_ref());
        let mesh = self.document.meshes[placement.mesh].part.as_ref().ok();
        match animated.or(of_node).or(mesh.and_then(|mesh| mesh.weights.as_ref())) {
            Some(weights) => weights.iter().map(|&w| w as f32).collect(),
            None => vec![0.0; self.document.targets(placement.mesh)],
        }
    }
}

/// Sets the property that a channel moves.
fn apply(channel: &Channel, time: f64, trs: &mut Trs, weights: &mut HashMap<usize, Vec<f64>>) {
    let value = channel.curve.sample(time, channel.property == Property::Rotation);
    match (channel.property, &value[..]) {
        (Property::Translation, &[x, y, z]) => trs.translation = DVec3::new(x, y, z),
        (Property::Scale, &[x, y, z]) => trs.scale = DVec3::new(x, y, z),
        (Property::Rotation, &[x, y, z, w]) => trs.rotation = DQuat::from_xyzw(x, y, z, w),
        _ => drop(weights.insert(channel.node, value)),
    }
}
