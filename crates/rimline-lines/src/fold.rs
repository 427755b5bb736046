//! Edges whose faces lie in two half-planes: where a mesh is doubled, its surface is folded there as if each face were one.

use std::collections::HashMap;

use crate::crease::Crease;
use crate::drawing::FaceId;
use crate::edges::Line;
use crate::exact::face_value;
use crate::object::Object;
use crate::options::LineClass;
use crate::view::{cross, dot};
use crate::world::World;

/// What an edge with several records is if its faces lie in two half-planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fold {
    pub(crate) is_silhouette: bool,
    pub(crate) is_crease: bool,
    /// Whether the first half-plane is to the left of the edge on the page, from its lower vertex.
    pub(crate) is_left: bool,
}

impl Fold {
    /// Of faces of one edge, each with the side of it on the page: `true` for the left.
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
fn is_same_half_plane([a, b]: [[f32; 3]; 2], one: [f32; 3], other: [f32; 3]) -> bool {
    if face_value(a, b, one, other).sign() != 0 {
        return false;
    }
    // In one plane, the normals are the same or opposite.
    let minus = |p: [f32; 3]| [0, 1, 2].map(|axis| f64::from(p[axis]) - f64::from(a[axis]));
    dot(cross(minus(b), minus(one)), cross(minus(b), minus(other))) > 0.0
}

/// The bits of the positions of a line's ends, the lower one first.
type Ends = [[u32; 3]; 2];

/// Takes out lines of intersection along an edge that two objects share, where a face of one lies over a face of the other: surfaces
/// that coincide do not pass through each other.
pub(crate) fn without_touching(lines: &mut Vec<Line>, world: &World<'_>) {
    let key = |vertices: [u32; 2]| {
        let positions =
            vertices.map(|vertex| world.positions.get(vertex as usize).map(|p| p.map(|c| (c + 0.0).to_bits())));
        let [Some(a), Some(b)] = positions else { return None };
        Some([a.min(b), a.max(b)])
    };
    let is_meeting = |line: &&Line| line.class == LineClass::Intersection;
    let mut apexes: HashMap<Ends, Vec<(u32, [f32; 3])>> = HashMap::new();
    apexes.extend(lines.iter().filter(is_meeting).filter_map(|line| Some((key(line.vertices)?, Vec::new()))));
    if apexes.is_empty() {
        return;
    }
    for (number, placed) in (0..).zip(&world.placed) {
        for face in placed.object.mesh.faces() {
            for side in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|step| face[(side + step) % 3] + placed.first_vertex);
                if let Some(apexes) = key([a, b]).and_then(|key| apexes.get_mut(&key)) {
                    apexes.push((number, world.positions[c as usize]));
                }
            }
        }
    }
    let number = |FaceId { object, .. }: FaceId| world.placed.partition_point(|placed| placed.number < object) as u32;
    lines.retain(|line| {
        let Some(apexes) = key(line.vertices).filter(|_| is_meeting(&line)).and_then(|key| apexes.get(&key)) else {
            return true;
        };
        let edge = line.vertices.map(|vertex| world.positions[vertex as usize]);
        let [one, other] = world.meetings[line.record as usize].map(number);
        let of = |wanted: u32| apexes.iter().filter(move |(number, _)| *number == wanted).map(|(_, apex)| *apex);
        !of(one).any(|apex| of(other).any(|other| is_same_half_plane(edge, apex, other)))
    });
}
