//! The triangles that polygons are drawn as, each polygon with at least one.

use std::hash::{BuildHasher, RandomState};

use super::Polygons;
use crate::mesh::topology::is_degenerate;
use crate::mesh::weld;

/// The fewest edges of polygons that share their triangles. A triangle is its own surface, from any corner.
const LEAST_ALIKE: usize = 4;

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
        let hashes = self.hashes();
        weld::groups(
            self.len(),
            |polygon| hashes[polygon],
            |one, other| hashes[one] == hashes[other] && self.are_alike(one, other),
        )
    }

    /// A hash of each polygon, the same for those that are equal. Edges are mixed with a random key, so that no input can
    /// choose other polygons that collide.
    fn hashes(&self) -> Vec<u64> {
        let key = RandomState::new().hash_one(0);
        let mixed = |[a, b]: [u32; 2]| {
            let mixed = ((u64::from(a) << 32 | u64::from(b)) ^ key).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (mixed ^ (mixed >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93)
        };
        let hash = |polygon: usize| {
            let boundary = self.boundary(polygon);
            if boundary.len() < LEAST_ALIKE {
                return mixed([polygon as u32; 2]);
            }
            // Sums do not depend on where a boundary begins, and the lower of both not on its direction.
            let there = boundary.iter().fold(0_u64, |sum, &edge| sum.wrapping_add(mixed(edge)));
            let back = boundary.iter().fold(0_u64, |sum, &[a, b]| sum.wrapping_add(mixed([b, a])));
            there.min(back)
        };
        (0..self.len()).map(hash).collect()
    }

    fn are_alike(&self, one: usize, other: usize) -> bool {
        let of_one = self.sorted_boundary(one, false);
        of_one.len() >= LEAST_ALIKE
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

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::mesh::PolygonLoops;

    /// The hashes of polygons of one loop each that are not equal.
    fn distinct_hashes(loops: &[Vec<u32>]) -> usize {
        let (polygon_loops, loop_corners) = (vec![1; loops.len()], loops.concat());
        let loop_sizes: Vec<u32> = loops.iter().map(|corners| corners.len() as u32).collect();
        let given =
            PolygonLoops { polygon_loops: &polygon_loops, loop_sizes: &loop_sizes, loop_corners: &loop_corners };
        let (polygons, _) = Polygons::new(&[[0.0; 3]; 40], given, &[]);
        polygons.hashes().into_iter().collect::<HashSet<_>>().len()
    }

    /// Each polygon is compared with those of its hash, so many of one hash would take quadratic time.
    #[test]
    fn polygons_that_are_not_alike_differ_in_their_hashes() {
        assert_eq!(distinct_hashes(&vec![vec![0, 1, 2]; 1000]), 1000, "copies of a triangle");
        assert_eq!(distinct_hashes(&vec![vec![0, 1, 2, 1]; 1000]), 1000, "polygons without a boundary");
        // The same vertices in other orders.
        let order = |n: u32| (0..10).map(|at| if n >> (at / 2) & 1 == 1 { at ^ 1 } else { at }).collect::<Vec<u32>>();
        assert_eq!(distinct_hashes(&(0..16).map(order).collect::<Vec<_>>()), 16);
        // Petals around vertex 0, each of them in either direction.
        let petal = |n: u32, petal: u32| {
            let [a, b, c] = [1, 2, 3].map(|corner| 3 * petal + corner);
            if n >> petal & 1 == 1 { [0, c, b, a] } else { [0, a, b, c] }
        };
        let flower = |n: u32| (0..12).flat_map(|at| petal(n, at)).collect::<Vec<u32>>();
        assert_eq!(distinct_hashes(&(0..1 << 11).map(flower).collect::<Vec<_>>()), 1 << 11);
        let alike = [vec![0, 1, 2, 3], vec![2, 3, 0, 1], vec![3, 2, 1, 0]];
        assert_eq!(distinct_hashes(&alike), 1, "one polygon, begun elsewhere and turned");
    }
}
