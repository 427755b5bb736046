//! Where a face lies between a line and the eye: an interval of the line.

use crate::exact::{Eye, Plane, Value, edge_value, face_value};

/// A triangle that the eye sees from a side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Vertices among those of all objects.
    pub(crate) corners: [u32; 3],
    /// The polygon that it is of, or [`Self::ALONE`], and in the lowest bit whether the eye is in front.
    packed: u32,
}

impl Triangle {
    /// Not of a polygon.
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

/// A line from one vertex to another, ready to be asked.
pub(crate) struct Segment<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) eye: Eye,
    pub(crate) vertices: [u32; 2],
    ends: [[f32; 3]; 2],
    doubles: [[f64; 3]; 2],
    /// Whether 30 bits of a crossing are not enough.
    is_long: bool,
}

impl<'a> Segment<'a> {
    pub(crate) fn new(positions: &'a [[f32; 3]], eye: Eye, vertices: [u32; 2], is_long: bool) -> Self {
        let ends = vertices.map(|vertex| positions[vertex as usize]);
        Self { positions, eye, vertices, ends, doubles: ends.map(|end| end.map(f64::from)), is_long }
    }

    /// The part of the line, from 0 to 1, whose points have the triangle strictly between them and the moved eye. `None` if there is
    /// no such part, or `f64` cannot tell its ends apart.
    pub(crate) fn covered_by(&self, triangle: Triangle) -> Option<[f64; 2]> {
        let [a, b, c] = triangle.corners;
        let is_end = |vertex: u32| self.vertices.contains(&vertex);
        if u32::from(is_end(a)) + u32::from(is_end(b)) + u32::from(is_end(c)) >= 2 {
            return None;
        }
        let corners = triangle.corners.map(|vertex| self.positions[vertex as usize]);
        let mut part = [0.0, 1.0];
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            // Both faces of an edge compute the same numbers, so that one's part ends exactly where the other's begins.
            let (i, j, turn) = if triangle.corners[i] < triangle.corners[j] { (i, j, 1) } else { (j, i, -1) };
            let (from, to) = (corners[i], corners[j]);
            let is_on = |end: usize| [triangle.corners[i], triangle.corners[j]].contains(&self.vertices[end]);
            let plane = || Plane::of_edge(from, to, self.eye);
            let exact = |end: usize| edge_value(from, to, self.ends[end], self.eye);
            self.clip(&mut part, triangle.side() * turn, is_on, plane, exact)?;
        }
        let [a, b, c] = corners;
        let is_on = |end: usize| triangle.corners.contains(&self.vertices[end]);
        let exact = |end: usize| face_value(a, b, c, self.ends[end]);
        self.clip(&mut part, -triangle.side(), is_on, || Plane::of_face(a, b, c), exact)?;
        (part[0] < part[1]).then_some(part)
    }

    /// Clips `part` to where a linear function has the sign `wanted`. `is_on` says at which end it is known to be 0. `None` if
    /// nothing is left.
    fn clip(
        &self,
        part: &mut [f64; 2],
        wanted: i32,
        is_on: impl Fn(usize) -> bool,
        plane: impl Fn() -> Plane,
        exact: impl Fn(usize) -> Value,
    ) -> Option<()> {
        let plane = plane();
        let heights = self.doubles.map(|end| plane.height(end));
        let signs = heights.map(|height| height.certain_sign() * wanted);
        if signs == [-1, -1] {
            return None;
        }
        if signs == [1, 1] {
            return Some(());
        }
        let value =
            |end: usize| if is_on(end) { Value::ZERO } else { heights[end].certain().unwrap_or_else(|| exact(end)) };
        let mut values = [value(0), value(1)];
        let signs = values.map(|value| value.sign() * wanted);
        if signs[0].max(signs[1]) <= 0 {
            return None;
        }
        if signs[0].min(signs[1]) < 0 {
            if self.is_long || heights.iter().any(|height| height.accurate().is_none()) {
                values = [exact(0), exact(1)];
            }
            let at = values[0].crossing(values[1]);
            if signs[0] < 0 { part[0] = part[0].max(at) } else { part[1] = part[1].min(at) }
        }
        Some(())
    }
}
