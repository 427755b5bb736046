//! The node forest: the order of parents and children, the nodes of the chosen scene, world matrices.

use glam::DAffine3;

use super::document::Document;
use super::error::GltfError;

/// The forest that the nodes of a document form.
#[derive(Debug)]
pub(super) struct Graph {
    parents: Vec<Option<usize>>,
    /// All nodes, parents first.
    order: Vec<usize>,
    /// Nodes of the chosen scene, parents first.
    pub(super) scene: Vec<usize>,
}

impl Graph {
    pub(super) fn new(document: &Document) -> Result<Self, GltfError> {
        let count = document.nodes.len();
        let mut parents = vec![None; count];
        for (parent, node) in document.nodes.iter().enumerate() {
            for &child in &node.children {
                if let Some(first) = parents[child].replace(parent) {
                    return Err(GltfError::TwoParents { node: child, first, second: parent });
                }
            }
        }
        let roots: Vec<usize> = (0..count).filter(|&node| parents[node].is_none()).collect();
        let order = preorder(document, &roots);
        if order.len() < count {
            // Every node has at most one parent. So a node that no root reaches is in a cycle or below one.
            let mut reached = vec![false; count];
            for &node in &order {
                reached[node] = true;
            }
            let node = reached.iter().position(|&reached| !reached).unwrap_or(0);
            return Err(GltfError::NodeCycle { node });
        }
        let scene = match document.scene.or((!document.scenes.is_empty()).then_some(0)) {
            Some(scene) => preorder(document, &document.scenes[scene]),
            None => order.clone(),
        };
        Ok(Self { parents, order, scene })
    }

    /// The world matrix of every node. `local` gives the matrix of a node to its parent's space.
    pub(super) fn world(&self, local: impl Fn(usize) -> DAffine3) -> Vec<DAffine3> {
        let mut world = vec![DAffine3::IDENTITY; self.parents.len()];
        for &node in &self.order {
            let local = local(node);
            world[node] = match self.parents[node] {
                Some(parent) => world[parent] * local,
                None => local,
            };
        }
        world
    }
}

/// The nodes at and below `roots`, each once, in depth-first order.
fn preorder(document: &Document, roots: &[usize]) -> Vec<usize> {
    let mut seen = vec![false; document.nodes.len()];
    let mut order = Vec::new();
    let mut pending: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(node) = pending.pop() {
        if !std::mem::replace(&mut seen[node], true) {
            order.push(node);
            pending.extend(document.nodes[node].children.iter().rev());
        }
    }
    order
}
