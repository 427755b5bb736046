//! Edges whose faces lie in two half-planes: where a mesh is doubled, its surface is folded there as if each face were one.

use std::iter::once;

use crate::crease::Crease;
use crate::exact::{Eye, edge_value, face_value};
use crate::object::Object;

/// An edge with several records if its faces lie in two half-planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fold {
    pub(crate) is_silhouette: bool,
    pub(crate) is_crease: bool,
    /// Whether the first half-plane is to the left of the edge on the page, from its lower vertex.
    pub(crate) is_left: bool,
}

impl Fold {
    /// Looks at the faces of one edge, all triangles, each with the side of it on the page: `true` for the left of the edge
    /// from its first vertex.
    pub(crate) fn new(
        object: &Object<'_>,
        vertices: [u32; 2],
        faces: &[(u32, bool)],
        crease: Crease,
        eye: Eye,
    ) -> Option<Self> {
        let edge = vertices.map(|vertex| object.positions[vertex as usize]);
        let apex = |face: u32| {
            let corners = object.mesh.faces()[face as usize];
            let corner = corners.into_iter().find(|corner| !vertices.contains(corner))?;
            Some(object.positions[corner as usize])
        };
        let (mut halves, mut sides): (Vec<[f32; 3]>, Vec<bool>) = (Vec::new(), Vec::new());
        for &(face, side) in faces {
            let apex = apex(face)?;
            match halves.iter().position(|&half| is_same_half_plane(edge, half, apex)) {
                // Faces that run both ways around are on one side, unless they are seen edge-on. Then the moved eye decides.
                Some(half) if sides[half] != side => sides[half] = edge_value(edge[0], edge[1], apex, eye).sign() > 0,
                Some(_) => {}
                None if halves.len() == 2 => return None,
                None => {
                    halves.push(apex);
                    sides.push(side);
                }
            }
        }
        let [one, other] = halves[..] else { return None };
        // The second face walks the edge the other way, as in a surface.
        let (first, second) = ([[edge[0], edge[1], one]], [[edge[1], edge[0], other]]);
        let is_crease = crease.is_between(first.into_iter(), second.into_iter(), false);
        Some(Self { is_silhouette: sides[0] == sides[1], is_crease, is_left: sides[0] })
    }
}

/// Whether two points are in one half-plane that an edge bounds, exactly. Points in line with the edge are in none.
pub(crate) fn is_same_half_plane([a, b]: [[f32; 3]; 2], one: [f32; 3], other: [f32; 3]) -> bool {
    // In one plane the normals are the same or opposite. With the second one turned, the same are opposite.
    face_value(a, b, one, other).sign() == 0
        && Crease::RIGHT_ANGLE.is_between(once([a, b, one]), once([a, b, other]), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_planes_are_decided_exactly() {
        const FAR: f32 = (1_u64 << 40) as f32;
        // The line passes the origin by so little that `f64` puts it on the line.
        let line = [[FAR, FAR, 0.0], [1.0 + 8.0 * f32::EPSILON, 1.0, 0.0]];
        let (near, above, below) = ([0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
        for (edge, one, other, is_same) in [
            (line, near, above, true),
            (line, near, near, true),
            (line, near, below, false),
            (line, above, below, false),
            (line, near, [0.0, 1.0, 1e-30], false),
            (line, near, line[0], false),
            ([[FAR, FAR, 0.0], [1.0, 1.0, 0.0]], near, above, false),
            ([[1.0; 3]; 2], near, above, false),
        ] {
            for [p, q] in [[one, other], [other, one]] {
                assert_eq!(is_same_half_plane(edge, p, q), is_same, "{edge:?}, {p:?}, {q:?}");
            }
        }
    }
}
