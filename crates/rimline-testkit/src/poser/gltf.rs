//! A glTF file's triangles in world space, at one time of an animation.

use std::path::Path;

use serde_json::Value;

use super::animation::{self, Moved};
use super::document::{Document, index, list, numbers};
use super::{Affine, Posed, pose_vertex};

/// A glTF file.
pub struct File {
    document: Document,
}

/// The default scene at one time.
struct Scene<'a> {
    document: &'a Document,
    moved: Moved,
    /// Transforms of all nodes to world space.
    world: Vec<Affine>,
}

impl File {
    pub fn open(path: &Path) -> Result<Self, String> {
        Ok(Self { document: Document::open(path)? })
    }

    /// The corners of all triangles of the default scene: nodes in depth-first order, primitives in the mesh's. No
    /// animation is the file as it stands. `EXT_mesh_gpu_instancing` is not read.
    pub fn corners(&self, animation: Option<usize>, time_s: f32) -> Vec<Posed> {
        let document = &self.document;
        let moved = animation.map_or_else(Moved::new, |number| animation::sample(document, number, f64::from(time_s)));
        let nodes = list(&document.json["nodes"]).len();
        let mut scene = Scene { document, moved, world: vec![Affine::IDENTITY; nodes] };
        let has_parent: Vec<usize> =
            list(&document.json["nodes"]).iter().flat_map(|node| list(&node["children"])).map(index).collect();
        for root in (0..nodes).filter(|node| !has_parent.contains(node)) {
            scene.add_node(root, &Affine::IDENTITY);
        }
        let number = document.json["scene"].as_u64().unwrap_or(0) as usize;
        let mut corners = Vec::new();
        for root in list(&document.json["scenes"][number]["nodes"]) {
            scene.visit(index(root), &mut corners);
        }
        corners
    }
}

impl Scene<'_> {
    fn node(&self, node: usize) -> &Value {
        &self.document.json["nodes"][node]
    }

    /// A property of a node: as animated, else as in the file, else the default.
    fn property<const N: usize>(&self, node: usize, path: &str, default: [f64; N]) -> [f64; N] {
        let animated = self.moved.get(&(node, path.to_owned())).cloned();
        let value = animated.or_else(|| numbers(&self.node(node)[path]));
        value.map_or(default, |value| value.try_into().expect("as many numbers as the property has"))
    }

    fn add_node(&mut self, node: usize, parent: &Affine) {
        let local = match numbers(&self.node(node)["matrix"]) {
            Some(columns) => Affine::from_columns(&columns),
            None => Affine::from_trs(
                self.property(node, "translation", [0.0; 3]),
                self.property(node, "rotation", [0.0, 0.0, 0.0, 1.0]),
                self.property(node, "scale", [1.0; 3]),
            ),
        };
        let world = parent.after(&local);
        self.world[node] = world;
        for child in list(&self.node(node)["children"]).to_vec() {
            self.add_node(index(&child), &world);
        }
    }

    fn visit(&self, node: usize, corners: &mut Vec<Posed>) {
        if let Some(mesh) = self.node(node)["mesh"].as_u64() {
            let mesh = &self.document.json["meshes"][mesh as usize];
            let animated = self.moved.get(&(node, "weights".to_owned())).cloned();
            let weights =
                animated.or_else(|| numbers(&self.node(node)["weights"])).or_else(|| numbers(&mesh["weights"]));
            for primitive in list(&mesh["primitives"]) {
                self.primitive(node, primitive, &weights.clone().unwrap_or_default(), corners);
            }
        }
        for child in list(&self.node(node)["children"]) {
            self.visit(index(child), corners);
        }
    }

    fn primitive(&self, node: usize, primitive: &Value, weights: &[f64], corners: &mut Vec<Posed>) {
        let attributes = &primitive["attributes"];
        let mode = primitive["mode"].as_u64().unwrap_or(4);
        if mode < 4 || attributes["POSITION"].is_null() {
            return;
        }
        let positions = self.document.accessor(&attributes["POSITION"]);
        let targets: Vec<_> = list(&primitive["targets"])
            .iter()
            .zip(weights)
            .filter(|(target, _)| !target["POSITION"].is_null())
            .map(|(target, weight)| (*weight, self.document.accessor(&target["POSITION"])))
            .collect();
        let joints = self.joints(node, attributes, positions.len());
        let posed: Vec<Posed> = (0..positions.len())
            .map(|vertex| {
                let targets: Vec<_> = targets.iter().map(|(weight, of)| (*weight, of.vector(vertex))).collect();
                pose_vertex(positions.vector(vertex), &targets, &joints[vertex])
            })
            .collect();
        let indices: Vec<usize> = match &primitive["indices"] {
            Value::Null => (0..posed.len()).collect(),
            accessor => self.document.accessor(accessor).values.iter().map(|&index| index as usize).collect(),
        };
        let triangles = if mode == 4 { indices.len() / 3 } else { indices.len().saturating_sub(2) };
        for i in 0..triangles {
            let triangle = match mode {
                4 => [3 * i, 3 * i + 1, 3 * i + 2],
                5 => [i, i + 1 + i % 2, i + 2 - i % 2],
                _ => [i + 1, i + 2, 0],
            };
            corners.extend(triangle.map(|corner| posed[indices[corner]]));
        }
    }

    /// The transforms that move each vertex: joints of the node's skin, with weights normalised to the sum 1, or the node
    /// alone. The transform of a node with a skin is ignored (3.7.3.3).
    fn joints(&self, node: usize, attributes: &Value, vertices: usize) -> Vec<Vec<(f64, Affine)>> {
        let Some(skin) = self.node(node)["skin"].as_u64() else {
            return vec![vec![(1.0, self.world[node])]; vertices];
        };
        let skin = &self.document.json["skins"][skin as usize];
        let inverse_binds = match &skin["inverseBindMatrices"] {
            Value::Null => None,
            accessor => Some(self.document.accessor(accessor)),
        };
        let joints = list(&skin["joints"]).iter().enumerate().map(|(joint, node)| {
            let world = self.world[index(node)];
            let inverse_bind = inverse_binds.as_ref().map(|of| Affine::from_columns(of.get(joint)));
            inverse_bind.map_or(world, |inverse_bind| world.after(&inverse_bind))
        });
        let palette: Vec<Affine> = joints.collect();
        let sets: Vec<_> = (0..)
            .map_while(|set| {
                let [joints, weights] = ["JOINTS", "WEIGHTS"].map(|name| &attributes[format!("{name}_{set}")]);
                (!joints.is_null()).then(|| (self.document.accessor(joints), self.document.accessor(weights)))
            })
            .collect();
        let influences = |vertex: usize| {
            let pairs = sets.iter().flat_map(|(joints, weights)| joints.get(vertex).iter().zip(weights.get(vertex)));
            let pairs: Vec<(f64, f64)> = pairs.map(|(&joint, &weight)| (joint, weight)).collect();
            let sum: f64 = pairs.iter().map(|(_, weight)| weight).sum();
            if sum == 0.0 {
                // The specification leaves this open; the library follows the first joint listed.
                return vec![(1.0, palette[pairs[0].0 as usize])];
            }
            let used = pairs.iter().filter(|(_, weight)| *weight != 0.0);
            used.map(|&(joint, weight)| (weight / sum, palette[joint as usize])).collect()
        };
        (0..vertices).map(influences).collect()
    }
}
