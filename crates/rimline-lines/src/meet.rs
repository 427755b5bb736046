//! Where faces pass through each other.

use std::collections::HashMap;
use std::ops::ControlFlow;

use rimline::cpu::Threads;

use crate::drawing::FaceId;
use crate::edges::Line;
use crate::error::{LinesError, check_count};
use crate::exact::{Plane, face_value};
use crate::options::LineClass;
use crate::parallel::ranges;
use crate::tree::{Box3, Tree};
use crate::world::{Pierce, World};

/// Faces at a time.
const RUN: usize = 1 << 14;

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
    let boxes = ranges(threads, faces.count as usize, RUN, |range| {
        range
            .map(|number| (Box3::around(faces.positions(faces.corners(number as u32))), number as u32))
            .collect::<Vec<_>>()
    });
    let tree = Tree::new(boxes.concat(), 3, threads);
    let found = tree.pairs(threads, tick, |found, one: u32, other: u32| {
        let numbers = [one.min(other), one.max(other)];
        let [corners, others] = numbers.map(|number| faces.corners(number));
        // Faces of an edge meet there.
        if corners.iter().filter(|vertex| others.contains(vertex)).count() < 2 {
            let [one, other] = numbers.map(|number| faces.get(number));
            if let Some(ends) = meeting(&one, &other) {
                found.push((numbers, ends, [one, other].map(|face| (face.placed, face.number))));
            }
        }
    });
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
    fn place(&self, number: u32) -> (usize, usize) {
        let placed = if self.first.len() == 1 { 0 } else { self.first.partition_point(|&first| first <= number) - 1 };
        (placed, (number - self.first[placed]) as usize)
    }

    fn corners(&self, number: u32) -> [u32; 3] {
        let (placed, triangle) = self.place(number);
        let placed = &self.world.placed[placed];
        placed.object.mesh.faces()[triangle].map(|vertex| vertex + placed.first_vertex)
    }

    fn positions(&self, corners: [u32; 3]) -> [[f32; 3]; 3] {
        corners.map(|vertex| self.world.positions[vertex as usize])
    }

    fn get(&self, number: u32) -> Face {
        let (placed, triangle) = self.place(number);
        let corners = self.corners(number);
        let number = self.polygons[placed].as_ref().map_or(triangle as u32, |of| of[triangle]);
        Face { placed: placed as u32, number, corners, positions: self.positions(corners) }
    }
}

/// The ends of the line where two faces pass through each other.
fn meeting(one: &Face, other: &Face) -> Option<[End; 2]> {
    if (one.placed, one.number) == (other.placed, other.number) {
        return None;
    }
    let crossings = [crossings(one, other)?, crossings(other, one)?];
    // All four are in line, along the axis where they are farthest apart.
    let points = crossings.map(|ends| ends.map(|(_, point)| point));
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
    let is_forward = crate::view::cross(n, m)[axis] > 0.0;
    (from.1[axis] < to.1[axis]).then_some(if is_forward { [from.0, to.0] } else { [to.0, from.0] })
}

/// Where the edges of a face cross the plane of another one: two points, or none.
fn crossings(face: &Face, other: &Face) -> Option<[(End, [f64; 3]); 2]> {
    let [a, b, c] = other.positions;
    let plane = Plane::of_face(a, b, c);
    let is_shared = face.corners.map(|vertex| other.corners.contains(&vertex));
    let heights = face.positions.map(|p| plane.height(p.map(f64::from)));
    // A shared corner is in the plane. With all others on one side, that is all that is.
    let is_on = |side: i32| (0..3).all(|at| is_shared[at] || heights[at].certain_sign() == side);
    if is_on(1) || is_on(-1) {
        return None;
    }
    let value = |at: usize| {
        if is_shared[at] {
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
