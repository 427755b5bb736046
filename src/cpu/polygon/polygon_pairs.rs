//! Polygon pairs: the side of a polygon that a light sees, by all pairs of edges of its boundary.

use super::corner_turn::{turn, turn_as_given};
use super::edge_pair::{Edge, edge_pair};
use super::half_space::fits_half_space;
use super::many_edges::{MANY_EDGES, many_edges};
use super::orientation::Orientation;
use super::polygon_turns::polygon_turns;
use crate::cpu::common::positions::{is_finite, position};
use crate::light::Light;
use crate::mesh::is_loop;

/// The boundary of a polygon at the positions of its corners, without edges of length 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    edges: Vec<Edge>,
    /// Where each edge begins. Every corner is here.
    corners: Vec<[f32; 3]>,
    /// Whether the edges follow each other around once.
    is_loop: bool,
}

impl Boundary {
    /// The edges are those of [`Polygons::boundary`](crate::mesh::Polygons::boundary). `None` if a corner is not finite or
    /// `positions` lacks it.
    pub fn new(edges: &[[u32; 2]], positions: &[[f32; 3]]) -> Option<Self> {
        let placed = edges.iter().map(|edge| edge.map(|vertex| position(positions, vertex)));
        let mut edges: Vec<Edge> = placed.collect();
        if !edges.iter().flatten().copied().all(is_finite) {
            return None;
        }
        edges.retain(|[a, b]| a != b);
        Some(Self { corners: edges.iter().map(|edge| edge[0]).collect(), is_loop: is_loop(&edges), edges })
    }

    /// The side that a finite light sees, exactly. [`Extraction`](crate::cpu::Extraction) has its bits. A boundary without
    /// edges is [`Orientation::InPlane`].
    pub fn orientation(&self, light: Light) -> Orientation {
        self.decide(light.to_array()).0
    }

    /// The edges that have a length.
    pub fn edges(&self) -> &[[[f32; 3]; 2]] {
        &self.edges
    }

    /// The side that the light `(l, w)` sees, and whether the fast test did not decide it.
    #[doc(hidden)]
    pub fn decide(&self, light: [f32; 4]) -> (Orientation, bool) {
        if let Some(seen) = if self.is_loop { polygon_turns(&self.corners, light) } else { None } {
            return (seen, false);
        }
        let many = if self.edges.len() > MANY_EDGES { many_edges(&self.edges, light) } else { None };
        (many.unwrap_or_else(|| self.orientation_by_pairs(light)), true)
    }

    /// The same by pairs of edges that are close to each other, as for boundaries of many edges. `None` where this way does
    /// not decide.
    #[doc(hidden)]
    pub fn orientation_by_close_pairs(&self, light: [f32; 4]) -> Option<Orientation> {
        many_edges(&self.edges, light)
    }

    /// The same for every boundary, by all pairs of edges.
    #[doc(hidden)]
    pub fn orientation_by_pairs(&self, light: [f32; 4]) -> Orientation {
        if self.is_in_plane(light) {
            return Orientation::InPlane;
        }
        if !fits_half_space(&self.corners, light) {
            return Orientation::Twisted;
        }
        let mut windings = vec![0; self.edges.len()];
        for (index, &e) in self.edges.iter().enumerate() {
            for (other, &f) in self.edges.iter().enumerate().skip(index + 1) {
                let pair = edge_pair(e, f, light);
                if pair.meets {
                    return Orientation::Twisted;
                }
                windings[index] += pair.left_of_e;
                windings[other] += pair.left_of_f;
            }
        }
        Orientation::of_windings(&windings)
    }

    /// Whether all corners are in one plane.
    pub fn is_planar(&self) -> bool {
        let Some(&[a, b]) = self.edges.first() else { return true };
        let is_aside = |&&c: &&[f32; 3]| turn(a, b, c, [1.0, 0.0, 0.0, 0.0]) != 0;
        let Some(&c) = self.corners.iter().find(is_aside) else { return true };
        self.corners.iter().all(|&[x, y, z]| turn_as_given(a, b, c, [x, y, z, 1.0]) == 0)
    }

    /// Whether each edge is in one plane with the light and each corner.
    fn is_in_plane(&self, light: [f32; 4]) -> bool {
        self.edges.iter().all(|&[a, b]| self.corners.iter().all(|&c| turn_as_given(a, b, c, light) == 0))
    }
}
