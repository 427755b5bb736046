//! The triangles that polygons are drawn as, each polygon with at least one.

use std::hash::{BuildHasher, RandomState};

use super::Polygons;
use crate::mesh::topology::is_degenerate;
use crate::mesh::weld;

impl Polygons {
    /// The surface of all polygons, from the triangles of each, and the polygon of each triangle.
    pub(super) fn surface(self, triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, Vec<u32>) {
        if self.are_triangles() {
            let polygons = (0..self.len() as u32).collect();
            return (self.into_triangles(), polygons);
        }
        let first_alike = self.first_alike();
        let is_plain =
            |(polygon, &first): (usize, &u32)| polygon == first as usize && !self.triangles(polygon).is_empty();
        if first_alike.iter().enumerate().all(is_plain) {
            return (triangles, self.triangle_polygons());
        }
        let mut surface = Vec::with_capacity(triangles.len() + self.len());
        let mut polygons = Vec::with_capacity(surface.capacity());
        for (polygon, &first) in first_alike.iter().enumerate() {
            let first = first as usize;
            let of_first = &triangles[self.triangles(first)];
            if of_first.is_empty() {
                surface.extend(self.nowhere(polygon));
            } else if polygon == first || self.sorted_boundary(polygon, false) == self.sorted_boundary(first, false) {
                surface.extend(of_first);
            } else {
                surface.extend(of_first.iter().map(|&[a, b, c]| [a, c, b]));
            }
            polygons.resize(surface.len(), polygon as u32);
        }
        (surface, polygons)
    }

    /// For each polygon the first one with the same boundary, in the same direction or the opposite. A diagonal of the one
    /// need not be one of the other otherwise, and what is one surface to the user would be two.
    fn first_alike(&self) -> Vec<u32> {
        // The sum does not depend on where a boundary begins. Vertices are mixed with a random key, so that no input can
        // choose polygons that collide.
        let key = RandomState::new().hash_one(0);
        let mixed = |vertex: u32| {
            let mixed = (u64::from(vertex) ^ key).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (mixed ^ (mixed >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93)
        };
        let sum =
            |polygon: usize| self.boundary(polygon).iter().fold(0_u64, |sum, edge| sum.wrapping_add(mixed(edge[0])));
        let sums: Vec<u64> = (0..self.len()).map(sum).collect();
        weld::groups(
            self.len(),
            |polygon| sums[polygon],
            |one, other| sums[one] == sums[other] && self.are_alike(one, other),
        )
    }

    fn are_alike(&self, one: usize, other: usize) -> bool {
        let of_one = self.sorted_boundary(one, false);
        // A triangle is its own surface, from any corner.
        of_one.len() > 3
            && of_one.len() == self.boundary(other).len()
            && [false, true].into_iter().any(|is_turned| of_one == self.sorted_boundary(other, is_turned))
    }

    fn sorted_boundary(&self, polygon: usize, is_turned: bool) -> Vec<[u32; 2]> {
        let turned = |&[a, b]: &[u32; 2]| if is_turned { [b, a] } else { [a, b] };
        let mut boundary: Vec<[u32; 2]> = self.boundary(polygon).iter().map(turned).collect();
        boundary.sort_unstable();
        boundary
    }

    /// The triangle of a polygon without a surface: it names a vertex twice.
    fn nowhere(&self, polygon: usize) -> Option<[u32; 3]> {
        let &[a, b, c] = self.loops(polygon).next()?.first_chunk()?;
        Some(if is_degenerate([a, b, c]) { [a, b, c] } else { [a, b, a] })
    }
}
