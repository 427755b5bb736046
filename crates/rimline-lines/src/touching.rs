//! Surfaces that coincide: they have no lines of intersection where they end along one edge.

use std::collections::{HashMap, HashSet};

use crate::drawing::FaceId;
use crate::edges::Line;
use crate::fold::is_same_half_plane;
use crate::options::LineClass;
use crate::world::{Ends, World};

/// Takes out lines of intersection along an edge that two objects share, where a face of one lies over a face of the
/// other: surfaces that coincide do not pass through each other. Of other lines along one edge the first stays.
pub(crate) fn without_touching(lines: &mut Vec<Line>, world: &World<'_>) {
    let is_meeting = |line: &&Line| line.class == LineClass::Intersection;
    // For each edge the faces of all objects: the object and the third corner.
    let mut apexes: HashMap<Ends, Vec<(u32, [f32; 3])>> = HashMap::new();
    apexes.extend(lines.iter().filter(is_meeting).filter_map(|line| Some((world.key(line.vertices)?, Vec::new()))));
    if apexes.is_empty() {
        return;
    }
    for (number, placed) in (0..).zip(&world.placed) {
        for face in placed.object.mesh.faces() {
            for side in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|step| face[(side + step) % 3] + placed.first_vertex);
                if let Some(apexes) = world.key([a, b]).and_then(|key| apexes.get_mut(&key)) {
                    apexes.push((number, world.positions[c as usize]));
                }
            }
        }
    }
    let number = |FaceId { object, .. }: FaceId| world.placed.partition_point(|placed| placed.number < object) as u32;
    // One edge may have as many lines as pairs of faces, so each pair of objects is asked once.
    let (mut touching, mut kept) = (HashMap::new(), HashSet::new());
    lines.retain(|line| {
        let Some(key) = world.key(line.vertices).filter(|_| is_meeting(&line)) else { return true };
        let [one, other] = world.meetings[line.record as usize].map(number);
        let is_touching = *touching.entry((key, one, other)).or_insert_with(|| {
            let edge = line.vertices.map(|vertex| world.positions[vertex as usize]);
            let at_edge = || apexes.get(&key).into_iter().flatten();
            let of = |wanted: u32| at_edge().filter(move |(number, _)| *number == wanted).map(|&(_, apex)| apex);
            one != other && of(one).any(|apex| of(other).any(|other| is_same_half_plane(edge, apex, other)))
        });
        !is_touching && kept.insert(key)
    });
}
