//! Where faces pass through each other.

use std::collections::HashMap;
use std::ops::ControlFlow;

use rimline::cpu::Threads;

use crate::drawing::FaceId;
use crate::edges::Line;
use crate::error::{LinesError, check_count};
use crate::exact::{Height, Plane, face_value, sum_of_sizes};
use crate::options::LineClass;
use crate::tree::{Box3, Tree};
use crate::view::{cross, dot};
use crate::world::{Pierce, World};

/// An end of a line where two faces meet.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum End {
    Vertex(u32),
    /// Where an edge, the lower vertex first, pierces a face.
    Pierce([u32; 2], [u32; 3]),
}

/// A triangle of an object.
#[derive(Clone, Copy)]
struct Face {
    placed: u32,
    /// The face that edge records name: the triangle or its polygon.
    number: u32,
    corners: [u32; 3],
    positions: [[f32; 3]; 3],
}

/// Adds the lines where faces pass through each other, and what they are made of to the world.
///
/// A vertex in the plane of another face counts as in front of it, so surfaces that touch from there meet nowhere.
pub(crate) fn meet(
    world: &mut World<'_>,
    lines: &mut Vec<Line>,
    threads: Threads,
    tick: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<(), LinesError> {
    let faces = Faces::new(world);
    let finite = world.positions.iter().filter(|position| position.iter().all(|c| c.is_finite()));
    let around = finite.fold(Box3::EMPTY, |all, &position| all.join(Box3::of(position)));
    let tree = Tree::new(faces.count as usize, (3, &around), threads, |number| {
        let corners = faces.corners(number as u32);
        let [a, b, c] = faces.positions(corners).map(Box3::of);
        (a.join(b).join(c), (number as u32, corners))
    });
    let prepare = |&(number, corners): &(u32, [u32; 3])| PreparedFace::new(number, corners, &world.positions);
    let found = tree.pairs(threads, tick, prepare, |found, face: &PreparedFace, &(other, corners)| {
        if face.may_meet(corners, &world.positions) {
            let numbers = [face.number.min(other), face.number.max(other)];
            let [one, other] = numbers.map(|number| faces.get(number));
            if let Some(ends) = meeting(&one, &other) {
                found.push((numbers, ends, [one, other].map(|face| (face.placed, face.number))));
            }
        }
    });
    drop(tree);
    let Some(found) = found else { return Err(LinesError::Cancelled) };
    let mut found = found.concat();
    found.sort_unstable_by_key(|&(numbers, ..)| numbers);
    check_count("points where faces meet", world.positions.len() + 2 * found.len(), u32::MAX as usize)?;
    let (mut numbers, vertices) = (HashMap::new(), world.positions.len() as u32);
    for (_, ends, of) in found {
        let vertices = ends.map(|end| match end {
            End::Vertex(vertex) => vertex,
            End::Pierce(edge, face) => {
                let next = vertices + numbers.len() as u32;
                *numbers.entry(end).or_insert_with(|| {
                    world.pierces.push(Pierce::new(&world.positions, edge, face));
                    next
                })
            }
        });
        let record = world.meetings.len() as u32;
        world.meetings.push(of.map(|(placed, face)| FaceId { object: world.placed[placed as usize].number, face }));
        lines.push(Line { vertices, class: LineClass::Intersection, placed: of[0].0, record });
    }
    Ok(())
}

/// The triangles of all objects, by one number.
struct Faces<'a> {
    world: &'a World<'a>,
    /// The first triangle of each object.
    first: Vec<u32>,
    polygons: Vec<Option<Vec<u32>>>,
    count: u32,
}

impl<'a> Faces<'a> {
    fn new(world: &'a World<'a>) -> Self {
        let mut count = 0;
        let first = world.placed.iter().map(|placed| {
            count += placed.object.mesh.faces().len() as u32;
            count - placed.object.mesh.faces().len() as u32
        });
        let first = first.collect();
        let polygons = world
            .placed
            .iter()
            .map(|placed| placed.object.mesh.polygons().map(rimline::mesh::Polygons::triangle_polygons));
        Self { world, first, polygons: polygons.collect(), count }
    }

    /// The object of a triangle, and its number there.
    fn object_and_triangle(&self, number: u32) -> (usize, usize) {
        let placed = if self.first.len() == 1 { 0 } else { self.first.partition_point(|&first| first <= number) - 1 };
        (placed, (number - self.first[placed]) as usize)
    }

    fn corners(&self, number: u32) -> [u32; 3] {
        let (placed, triangle) = self.object_and_triangle(number);
        let placed = &self.world.placed[placed];
        placed.object.mesh.faces()[triangle].map(|vertex| vertex + placed.first_vertex)
    }

    fn positions(&self, corners: [u32; 3]) -> [[f32; 3]; 3] {
        corners.map(|vertex| self.world.positions[vertex as usize])
    }

    fn get(&self, number: u32) -> Face {
        let (placed, triangle) = self.object_and_triangle(number);
        let corners = self.corners(number);
        let number = self.polygons[placed].as_ref().map_or(triangle as u32, |of| of[triangle]);
        Face { placed: placed as u32, number, corners, positions: self.positions(corners) }
    }
}

/// A face that is asked for several others.
struct PreparedFace {
    number: u32,
    corners: [u32; 3],
    plane: Plane,
}

impl PreparedFace {
    fn new(number: u32, corners: [u32; 3], positions: &[[f32; 3]]) -> Self {
        let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
        Self { number, corners, plane: Plane::of_face(a, b, c) }
    }

    /// Whether another face may pass through this one. `false` is certain.
    fn may_meet(&self, others: [u32; 3], positions: &[[f32; 3]]) -> bool {
        let is_shared = |at: usize| self.corners.contains(&others[at]);
        let is_in = [is_shared(0), is_shared(1), is_shared(2)];
        let position = |at: usize| positions[others[at] as usize];
        match is_in {
            [false, false, false] => !is_beside(&self.plane, is_in, [position(0), position(1), position(2)], &[1, -1]),
            [true, false, false] => self.may_meet_at(others[0], [position(1), position(2)], positions),
            [false, true, false] => self.may_meet_at(others[1], [position(2), position(0)], positions),
            [false, false, true] => self.may_meet_at(others[2], [position(0), position(1)], positions),
            // Faces of an edge meet there.
            _ => false,
        }
    }

    /// The same for a face that shares one corner, and has two others.
    fn may_meet_at(&self, shared: u32, [p, q]: [[f32; 3]; 2], positions: &[[f32; 3]]) -> bool {
        let heights = [self.plane.height(p.map(f64::from)), self.plane.height(q.map(f64::from))];
        let signs = heights.map(Height::certain_sign);
        if signs[0] * signs[1] > 0 {
            return false;
        }
        let at = positions[shared as usize];
        let [a, b] = match self.corners {
            [first, b, c] if first == shared => [b, c],
            [c, first, b] if first == shared => [b, c],
            [b, c, _] => [b, c],
        };
        let away = |to: [f32; 3]| [0, 1, 2].map(|axis| f64::from(to[axis]) - f64::from(at[axis]));
        let edges = [(away(positions[a as usize]), 1.0), (away(positions[b as usize]), -1.0)];
        let [p, q] = [away(p), away(q)];
        // Whether a direction, off by less than `error`, leads out of the plane across this face through one of its edges.
        let is_outside = |(edge, turn): ([f64; 3], f64), direction: [f64; 3], error: f64| {
            let inside = turn * dot(cross(self.plane.normal(), edge), direction);
            inside < -(error * self.plane.size() * sum_of_sizes(edge)).max(f64::MIN_POSITIVE)
        };
        let [Some(from_p), Some(from_q)] = heights.map(Height::accurate) else {
            // Faces of a fan are often about in one plane. Most are beside each other.
            let is_beyond = |edge| [p, q].into_iter().all(|to| is_outside(edge, to, 1e-13 * sum_of_sizes(to)));
            return !edges.into_iter().any(is_beyond);
        };
        // Both planes meet along the line from the corner to where the other face's third edge pierces this plane. This face is
        // there, between its two edges, or elsewhere.
        let (from_p, from_q) = (from_p.number().abs(), from_q.number().abs());
        let along = [0, 1, 2].map(|axis| from_q * p[axis] + from_p * q[axis]);
        let size = from_q * sum_of_sizes(p) + from_p * sum_of_sizes(q);
        !edges.into_iter().any(|edge| is_outside(edge, along, 1e-7 * size))
    }
}

/// Whether `f64` is certain that the corners are on one of these sides of a plane, but for those that are in it.
fn is_beside(plane: &Plane, is_in: [bool; 3], corners: [[f32; 3]; 3], sides: &[i32]) -> bool {
    let signs = corners.map(|corner| plane.height(corner.map(f64::from)).certain_sign());
    sides.iter().any(|&side| (0..3).all(|at| is_in[at] || signs[at] == side))
}

/// The ends of the line where two faces pass through each other.
fn meeting(one: &Face, other: &Face) -> Option<[End; 2]> {
    if (one.placed, one.number) == (other.placed, other.number) {
        return None;
    }
    // Fans of large polygons have many pairs in one plane. Where that is across an axis, they need no integers.
    let is_flat = |axis: usize| {
        let [level, ..] = one.positions.map(|position| position[axis]);
        one.positions.iter().chain(&other.positions).all(|position| position[axis] == level)
    };
    if (0..3).any(is_flat) {
        return None;
    }
    let crossings = [crossings(one, other)?, crossings(other, one)?];
    let points = crossings.map(|ends| ends.map(|(_, point)| point));
    // Neighbours whose vertices are not welded meet along one edge of both.
    let is_edge = |ends: &[(End, [f64; 3]); 2]| ends.iter().all(|(end, _)| matches!(end, End::Vertex(_)));
    let [[a, b], ends] = points;
    if one.placed == other.placed && crossings.iter().all(is_edge) && (ends == [a, b] || ends == [b, a]) {
        return None;
    }
    // All four are in line, along the axis where they are farthest apart.
    let extent = |axis: usize| {
        let all = || points.as_flattened().iter().map(|point| point[axis]);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    let axis = (1..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
    let [[a, b], [c, d]] = crossings.map(|[from, to]| if from.1[axis] <= to.1[axis] { [from, to] } else { [to, from] });
    let from = if a.1[axis] >= c.1[axis] { a } else { c };
    let to = if b.1[axis] <= d.1[axis] { b } else { d };
    // One direction for all faces of two surfaces that meet: across the normals of both.
    let [n, m] =
        [one, other].map(|face| Plane::of_face(face.positions[0], face.positions[1], face.positions[2]).normal());
    let is_forward = cross(n, m)[axis] > 0.0;
    (from.1[axis] < to.1[axis]).then_some(if is_forward { [from.0, to.0] } else { [to.0, from.0] })
}

/// Where the edges of a face cross the plane of another one: two points, or none.
fn crossings(face: &Face, other: &Face) -> Option<[(End, [f64; 3]); 2]> {
    let [a, b, c] = other.positions;
    let plane = Plane::of_face(a, b, c);
    let is_in = face.positions.map(|position| other.positions.contains(&position));
    // Corners that both faces have are in the plane. With all others on one side this face does not pass through it; but an
    // edge in the plane is drawn if the third corner is behind.
    let is_edge_in = is_in.into_iter().filter(|is_in| *is_in).count() == 2;
    if is_beside(&plane, is_in, face.positions, if is_edge_in { &[1] } else { &[1, -1] }) {
        return None;
    }
    let heights = face.positions.map(|p| plane.height(p.map(f64::from)));
    let value = |at: usize| {
        if is_in[at] {
            0.0
        } else {
            heights[at].accurate().unwrap_or_else(|| face_value(a, b, c, face.positions[at])).number()
        }
    };
    let values = [0, 1, 2].map(value);
    let is_behind = values.map(|value| value < 0.0);
    let alone =
        (0..3).find(|&at| is_behind[at] != is_behind[(at + 1) % 3] && is_behind[at] != is_behind[(at + 2) % 3])?;
    Some([1, 2].map(|step| {
        let other_end = (alone + step) % 3;
        for at in [alone, other_end] {
            if values[at] == 0.0 {
                return (End::Vertex(face.corners[at]), face.positions[at].map(f64::from));
            }
        }
        let [i, j] =
            if face.corners[alone] < face.corners[other_end] { [alone, other_end] } else { [other_end, alone] };
        let share = values[i].abs() / (values[i].abs() + values[j].abs());
        let [p, q] = [i, j].map(|at| face.positions[at].map(f64::from));
        let point = [0, 1, 2].map(|axis| p[axis] + share * (q[axis] - p[axis]));
        (End::Pierce([face.corners[i], face.corners[j]], other.corners), point)
    }))
}

#[cfg(test)]
mod tests {
    use rimline_testkit::random::Random;

    use super::*;

    fn may_meet(corners: [[u32; 3]; 2], positions: &[[f32; 3]]) -> bool {
        PreparedFace::new(0, corners[0], positions).may_meet(corners[1], positions)
    }

    /// Faces of a fan that is flat, exactly or but for rounding, need no integers.
    #[test]
    fn faces_of_a_flat_fan_are_set_aside() {
        let planes: [fn(f32, f32) -> [f32; 3]; 2] =
            [|x, y| [x, y, x], |x, y| [0.3 + x + 0.1 * y, 0.2 + 0.3 * x + 0.9 * y, 0.1 - 0.2 * x + 0.4 * y]];
        for position in planes {
            let rim = |number: u32| {
                let (sin, cos) = (std::f32::consts::TAU * number as f32 / 41.0).sin_cos();
                position(cos, sin)
            };
            let positions: Vec<_> = [position(0.0, 0.0)].into_iter().chain((0..41).map(rim)).collect();
            let face = |number: u32| [0, 1 + number, 1 + (number + 1) % 41];
            let pairs = (0..41).flat_map(|one| (0..41).map(move |other| [one, other]));
            let left: Vec<_> = pairs.filter(|pair| may_meet(pair.map(face), &positions)).collect();
            assert!(left.is_empty(), "{left:?}");
        }
    }

    /// Faces that share a corner and are set aside meet nowhere, also where their corners are in one plane or in line.
    #[test]
    fn faces_set_aside_meet_nowhere() {
        let mut random = Random::new(77);
        let (mut set_aside, mut met) = (0, 0);
        for _ in 0..20_000 {
            let flat = random.below(2);
            let mut position = || [5, 5, if flat == 0 { 5 } else { 1 }].map(|most| random.below(most) as f32);
            let turn = |[x, y, z]: [f32; 3]| [x + y - z, y + 2.0 * z, x - z];
            let positions: Vec<_> = (0..5).map(|_| turn(position())).collect();
            let corners = [
                [[0, 1, 2], [1, 2, 0], [2, 0, 1]][random.below(3)],
                [[0, 3, 4], [3, 4, 0], [4, 0, 3]][random.below(3)],
            ];
            let face = |number: u32| {
                let corners = corners[number as usize];
                Face { placed: number, number, corners, positions: corners.map(|vertex| positions[vertex as usize]) }
            };
            let meets = meeting(&face(0), &face(1)).is_some();
            for corners in [corners, [corners[1], corners[0]]] {
                let may_meet = may_meet(corners, &positions);
                assert!(may_meet || !meets, "{corners:?} of {positions:?}");
                set_aside += u32::from(!may_meet);
            }
            met += u32::from(meets);
        }
        assert!(set_aside > 10_000 && met > 500, "{set_aside} set aside, {met} met");
    }
}
