//! Where a face lies between a line and the eye: an interval of the line.

use crate::exact::{Height, PiercePositions, Plane, Value, edge_value, face_value};
use crate::world::{Pierce, World};

/// A triangle that the eye does not see edge-on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Vertices among those of all objects.
    pub(crate) corners: [u32; 3],
    /// From bit 1 on the polygon that it is part of, or [`Self::ALONE`]. Bit 0: the eye is in front of it.
    packed: u32,
}

impl Triangle {
    /// Instead of a polygon, for a triangle that is part of none.
    pub(crate) const ALONE: u32 = u32::MAX >> 1;

    pub(crate) fn new(corners: [u32; 3], polygon: u32, is_front: bool) -> Self {
        Self { corners, packed: polygon << 1 | u32::from(is_front) }
    }

    pub(crate) fn polygon(self) -> u32 {
        self.packed >> 1
    }

    /// 1 if the eye is in front of it, else −1.
    fn side(self) -> i32 {
        if self.packed & 1 != 0 { 1 } else { -1 }
    }
}

/// A line, with what its tests against many triangles share.
pub(crate) struct Segment<'a> {
    world: &'a World<'a>,
    ends: [End<'a>; 2],
    /// The plane through the line and the eye, if both ends are vertices.
    plane: Option<Plane>,
    /// Whether the page has only a part of the line. Crossings then need more than 30 bits.
    is_cut_off: bool,
}

/// An end of a line.
enum End<'a> {
    Vertex { vertex: u32, position: [f32; 3], double: [f64; 3] },
    Pierce { pierce: &'a Pierce, positions: PiercePositions, doubles: [[f64; 3]; 2] },
}

impl<'a> End<'a> {
    fn new(world: &'a World<'a>, vertex: u32) -> Self {
        let position = |vertex: u32| world.positions[vertex as usize];
        let vertices = world.positions.len();
        if (vertex as usize) < vertices {
            let position = position(vertex);
            return Self::Vertex { vertex, position, double: position.map(f64::from) };
        }
        let pierce = &world.pierces[vertex as usize - vertices];
        let positions = PiercePositions { edge: pierce.edge.map(position), face: pierce.face.map(position) };
        Self::Pierce { pierce, doubles: positions.edge.map(|end| end.map(f64::from)), positions }
    }

    fn height(&self, plane: &Plane) -> Height {
        match self {
            Self::Vertex { double, .. } => plane.height(*double),
            Self::Pierce { pierce, doubles, .. } => Height::mean(doubles.map(|end| plane.height(end)), pierce.weights),
        }
    }

    /// Whether it is on an edge by construction: as one of its vertices, or as the point where the edge pierces a face. The
    /// lower vertex of `edge` is first.
    fn is_on_edge(&self, edge: [u32; 2]) -> bool {
        match self {
            Self::Vertex { vertex, .. } => edge.contains(vertex),
            Self::Pierce { pierce, .. } => pierce.edge == edge,
        }
    }

    /// Whether it is in the plane of a face by construction: as a vertex of the face, as the point where an edge pierces it,
    /// or on one of its edges.
    fn is_in_face(&self, corners: [u32; 3]) -> bool {
        match self {
            Self::Vertex { vertex, .. } => corners.contains(vertex),
            Self::Pierce { pierce, .. } => {
                pierce.face == corners || pierce.edge.iter().all(|vertex| corners.contains(vertex))
            }
        }
    }
}

impl<'a> Segment<'a> {
    pub(crate) fn new(world: &'a World<'a>, vertices: [u32; 2], is_cut_off: bool) -> Self {
        let ends = vertices.map(|vertex| End::new(world, vertex));
        let plane = match &ends {
            [End::Vertex { position: a, .. }, End::Vertex { position: b, .. }] => {
                Some(Plane::of_edge(*a, *b, world.eye))
            }
            _ => None,
        };
        Self { world, ends, plane, is_cut_off }
    }

    /// The part of the line, from 0 to 1, whose points have the triangle strictly between them and the eye, moved by an
    /// infinitely small step as [`Value`] says. `None` if there is no such part, or `f64` cannot tell its ends apart.
    pub(crate) fn part_behind(&self, triangle: Triangle) -> Option<[f64; 2]> {
        if self.ends.iter().all(|end| end.is_in_face(triangle.corners)) {
            return None;
        }
        let (eye, corners) = (self.world.eye, triangle.corners.map(|vertex| self.world.positions[vertex as usize]));
        if let Some(plane) = &self.plane {
            // Most triangles are beside the line.
            let [a, b, c] = corners.map(|corner| plane.height(corner.map(f64::from)).certain_sign());
            if a == b && b == c && a != 0 {
                return None;
            }
        }
        let mut part = [0.0, 1.0];
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            // Both faces of an edge compute the same numbers, so that one's part ends exactly where the other's begins.
            let (i, j, turn) = if triangle.corners[i] < triangle.corners[j] { (i, j, 1) } else { (j, i, -1) };
            let (edge, from, to) = ([triangle.corners[i], triangle.corners[j]], corners[i], corners[j]);
            let exact = |end: &End<'_>| match end {
                End::Vertex { position, .. } => edge_value(from, to, *position, eye),
                End::Pierce { positions, .. } => positions.edge_value(from, to, eye),
            };
            let plane = Plane::of_edge(from, to, eye);
            self.clip(&mut part, triangle.side() * turn, &plane, |end| end.is_on_edge(edge), exact)?;
        }
        let [a, b, c] = corners;
        let exact = |end: &End<'_>| match end {
            End::Vertex { position, .. } => face_value(a, b, c, *position),
            End::Pierce { positions, .. } => positions.face_value(a, b, c),
        };
        let plane = Plane::of_face(a, b, c);
        self.clip(&mut part, -triangle.side(), &plane, |end| end.is_in_face(triangle.corners), exact)?;
        (part[0] < part[1]).then_some(part)
    }

    /// Clips `part` to where the height over a plane has the sign `wanted`. `is_on` says at which end it is known to be 0.
    /// `None` if it has that sign nowhere; else `part` may end before it begins.
    fn clip(
        &self,
        part: &mut [f64; 2],
        wanted: i32,
        plane: &Plane,
        is_on: impl Fn(&End<'_>) -> bool,
        exact: impl Fn(&End<'_>) -> Value,
    ) -> Option<()> {
        let heights = [self.ends[0].height(plane), self.ends[1].height(plane)];
        let signs = heights.map(|height| height.certain_sign() * wanted);
        if signs == [-1, -1] {
            return None;
        }
        if signs == [1, 1] {
            return Some(());
        }
        let value = |at: usize| {
            let end = &self.ends[at];
            if is_on(end) { Value::ZERO } else { heights[at].certain().unwrap_or_else(|| exact(end)) }
        };
        let mut values = [value(0), value(1)];
        let signs = values.map(|value| value.sign() * wanted);
        if signs[0].max(signs[1]) <= 0 {
            return None;
        }
        if signs[0].min(signs[1]) < 0 {
            if self.is_cut_off || heights.iter().any(|height| height.accurate().is_none()) {
                values = [exact(&self.ends[0]), exact(&self.ends[1])];
            }
            let at = values[0].crossing(values[1]);
            if signs[0] < 0 { part[0] = part[0].max(at) } else { part[1] = part[1].min(at) }
        }
        Some(())
    }
}
