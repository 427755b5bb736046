//! Which occluded faces are left out: docs/numerics/occluded-faces.md, "Faces left out".

use super::min_cut::MinCut;
use crate::mesh::{Edge, EdgeKind, Mesh};

/// A caster, and which of its faces are front-facing.
pub(crate) struct Silhouette<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) facing: &'a [bool],
}

impl Silhouette<'_> {
    fn is_facing(&self, face: u32) -> bool {
        self.facing.get(face as usize).copied().unwrap_or(false)
    }

    /// How many sides are drawn if some faces, which are ascending, are left out.
    pub(crate) fn sides(&self, left_out: &[u32]) -> usize {
        let is_closed = self.mesh.is_closed();
        let term = |face: u32| {
            let is_facing = self.is_facing(face);
            match (is_facing && is_closed) || left_out.binary_search(&face).is_ok() {
                true => 0,
                false if is_facing => 1,
                false => -1_i32,
            }
        };
        let weight = |edge: Edge| {
            let second = edge.face_1.map_or(0, term);
            let second = if edge.kind == EdgeKind::Inconsistent { second } else { -second };
            (term(edge.face_0) + second).unsigned_abs() as usize
        };
        self.mesh.edges().iter().map(weight).sum()
    }

    /// The occluded faces to leave out, ascending, so that the fewest sides are left. `occluded` is ascending.
    pub(crate) fn shortest(&self, occluded: &[u32]) -> Vec<u32> {
        if occluded.is_empty() {
            return Vec::new();
        }
        let node = |face: u32| occluded.binary_search(&face).ok();
        let mut cut = MinCut::new(occluded.len());
        for edge in self.mesh.edges().iter() {
            let Some(face_1) = edge.face_1 else {
                cut.cost_of_keeping(node(edge.face_0));
                continue;
            };
            let [first, second] = [edge.face_0, face_1].map(node);
            let is_opposite = edge.kind == EdgeKind::Consistent;
            if (self.is_facing(edge.face_0) == self.is_facing(face_1)) != is_opposite {
                // Both faces add to the side.
                cut.cost_of_keeping(first);
                cut.cost_of_keeping(second);
                continue;
            }
            // There is no side while both cast, or neither.
            match (first, second) {
                (Some(first), Some(second)) => cut.cost_of_parting(first, second),
                (Some(node), None) | (None, Some(node)) => cut.cost_of_leaving_out(node),
                (None, None) => {}
            }
        }
        let kept = cut.solve();
        occluded.iter().zip(kept).filter(|(_, is_kept)| !is_kept).map(|(&face, _)| face).collect()
    }
}
