//! The node forest: the order of parents and children, the nodes of the chosen scene, world matrices.

use glam::DAffine3;

use super::document::{Document, checked};
use super::error::GltfError;
use super::warning::{GltfWarning, Warnings};

/// The forest that the nodes of a document form.
#[derive(Debug)]
pub(super) struct Graph {
    parents: Vec<Option<usize>>,
    /// All nodes but those in cycles and below them, parents first.
    order: Vec<usize>,
    /// All nodes of the chosen scene, parents first but for cycles. [`Graph::check`] finds those.
    pub(super) all: Vec<usize>,
    /// The shown ones among them.
    pub(super) scene: Vec<usize>,
    /// For each node: the node at or above it that is at fault, so that its transform is not known.
    spoilt_by: Vec<Option<usize>>,
}

/// The children of each node.
type Children = Vec<Vec<usize>>;

impl Graph {
    pub(super) fn new(document: &Document, warnings: &Warnings<'_>) -> Result<Self, GltfError> {
        let nodes = &document.nodes;
        let scene = match document.scene.or((!document.scenes.is_empty()).then_some(0)) {
            Some(scene) => Some(checked(&document.scenes[scene])?),
            None => None,
        };
        let (parents, children) = trees(document, scene.map_or(&[][..], Vec::as_slice), warnings)?;
        let roots: Vec<usize> = (0..nodes.len()).filter(|&node| parents[node].is_none()).collect();
        let order = preorder(&children, &roots, |_| true);
        let mut spoilt_by: Vec<Option<usize>> = (0..nodes.len()).map(Some).collect();
        for &node in &order {
            let above: Option<usize> = parents[node].and_then(|parent| spoilt_by[parent]);
            spoilt_by[node] = nodes[node].fault.as_ref().map(|_| node).or(above);
        }
        // Every node has at most one parent. So a node that no root reaches is in a cycle or below one. A file without
        // scenes has all nodes.
        let is_shown = |node: usize| !nodes[node].is_hidden;
        let (all, scene) = match scene {
            Some(roots) => (preorder(&children, roots, |_| true), preorder(&children, roots, is_shown)),
            None if order.len() < nodes.len() => ((0..nodes.len()).collect(), (0..nodes.len()).collect()),
            None => (order.clone(), preorder(&children, &roots, is_shown)),
        };
        Ok(Self { parents, order, all, scene, spoilt_by })
    }

    /// Checks that the transform of a node is known.
    pub(super) fn check(&self, document: &Document, node: usize) -> Result<(), GltfError> {
        self.spoilt_by[node].map_or(Ok(()), |by| Err(fault(document, by)))
    }

    /// Faults that leave the transforms of nodes unknown.
    pub(super) fn faults(&self, document: &Document) -> impl Iterator<Item = GltfError> {
        let is_at_fault = |&node: &usize| self.spoilt_by[node] == Some(node);
        // All nodes of cycles together are one fault.
        let mut cycles = 0;
        (0..self.parents.len()).filter(is_at_fault).filter_map(move |node| {
            let is_cycle = document.nodes[node].fault.is_none();
            cycles += usize::from(is_cycle);
            (cycles < 2 || !is_cycle).then(|| fault(document, node))
        })
    }

    /// The world matrix of every node: the identity for those in cycles and below them. `local` gives the matrix of a node
    /// to its parent's space.
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

/// The fault of a node whose transform is unknown. A node without a fault of its own is in a cycle or below one.
fn fault(document: &Document, node: usize) -> GltfError {
    let cycle = || GltfError::invalid(format!("nodes[{node}]"), " is its own ancestor; nodes must form trees");
    document.nodes[node].fault.as_ref().map_or_else(cycle, |fault| GltfError::clone(fault))
}

/// The parent and the children of each node. A child of two nodes stays with the first that a walk from `roots` meets, or
/// else with the first in the file.
fn trees(
    document: &Document,
    roots: &[usize],
    warnings: &Warnings<'_>,
) -> Result<(Vec<Option<usize>>, Children), GltfError> {
    let listed: Children = document.nodes.iter().map(|node| node.children.clone()).collect();
    let count = listed.len();
    let (mut parents, mut children) = (vec![None; count], vec![Vec::new(); count]);
    let mut is_met = vec![false; count];
    for parent in preorder(&listed, roots, |_| true).into_iter().chain(0..count) {
        if std::mem::replace(&mut is_met[parent], true) {
            continue;
        }
        for &node in &listed[parent] {
            match parents[node] {
                None => {
                    parents[node] = Some(parent);
                    children[parent].push(node);
                }
                Some(first) => {
                    let twice =
                        format!(" is a child of nodes[{first}] and again of nodes[{parent}]; nodes must form trees");
                    let problem = format!("{twice}, so it is placed below nodes[{first}] only");
                    warnings.push(GltfWarning::Changed { json_path: format!("nodes[{node}]"), problem })?;
                }
            }
        }
    }
    Ok((parents, children))
}

/// The nodes at and below `roots`, each once, in depth-first order, without those below and at nodes that `enters` refuses.
fn preorder(children: &Children, roots: &[usize], enters: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut seen = vec![false; children.len()];
    let mut order = Vec::new();
    let mut pending: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(node) = pending.pop() {
        if enters(node) && !std::mem::replace(&mut seen[node], true) {
            order.push(node);
            pending.extend(children[node].iter().rev());
        }
    }
    order
}
