//! Edges whose faces lie in two half-planes: where a mesh is doubled, its surface is folded there as if each face were one.

use crate::crease::Crease;
use crate::exact::face_value;
use crate::object::Object;
use crate::view::{cross, dot};

/// An edge with several records if its faces lie in two half-planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fold {
    pub(crate) is_silhouette: bool,
    pub(crate) is_crease: bool,
    /// Whether the first half-plane is to the left of the edge on the page, from its lower vertex.
    pub(crate) is_left: bool,
}

impl Fold {
    /// Looks at the faces of one edge, each with the side of it on the page: `true` for the left.
    pub(crate) fn new(object: &Object<'_>, vertices: [u32; 2], faces: &[(u32, bool)], crease: Crease) -> Option<Self> {
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
                Some(half) if sides[half] != side => return None,
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
    if face_value(a, b, one, other).sign() != 0 {
        return false;
    }
    // In one plane, the normals are the same or opposite.
    let minus = |p: [f32; 3]| [0, 1, 2].map(|axis| f64::from(p[axis]) - f64::from(a[axis]));
    dot(cross(minus(b), minus(one)), cross(minus(b), minus(other))) > 0.0
}
