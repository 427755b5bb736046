//! One fixed triangulation of each polygon, with the polygon's boundary.
//!
//! `earcut` finds the triangles in the plane along whose normal the polygon looks largest. It leaves out corners that
//! lie straight between their neighbours, and cuts off parts that cross themselves. So its triangles may have another
//! boundary. The difference is a set of closed loops, and a fan fills each of them. Where the boundary is simple, these
//! fans look like lines.

use earcut::Earcut;

use super::fans::OpenEdges;
use crate::mesh::topology::is_degenerate;

/// Triangulates polygons. It reuses its memory from one to the next.
#[derive(Default)]
pub(super) struct Triangulator {
    earcut: Option<Earcut<f64>>,
    vertices: Vec<u32>,
    points: Vec<[f64; 2]>,
    holes: Vec<u32>,
    found: Vec<u32>,
    open: OpenEdges,
}

impl Triangulator {
    /// Appends triangles with the boundary `boundary`, that of the polygon with these loops. None of them names a
    /// vertex twice.
    pub(super) fn append_triangles<'a>(
        &mut self,
        triangles: &mut Vec<[u32; 3]>,
        positions: &[[f32; 3]],
        loops: impl ExactSizeIterator<Item = &'a [u32]> + Clone,
        boundary: &[[u32; 2]],
    ) {
        if let [[a, b], [c, d], [e, f]] = *boundary
            && (b, d, f) == (c, e, a)
        {
            triangles.push([a, b, d]);
            return;
        }
        if boundary.is_empty() {
            return;
        }
        let first = triangles.len();
        self.cut_ears(triangles, positions, loops);
        self.open.clear();
        for &edge in boundary {
            self.open.add(edge);
        }
        for &[a, b, c] in &triangles[first..] {
            for edge in [[b, a], [c, b], [a, c]] {
                self.open.add(edge);
            }
        }
        self.open.append_fans(triangles);
    }

    /// Appends what `earcut` finds.
    fn cut_ears<'a>(
        &mut self,
        triangles: &mut Vec<[u32; 3]>,
        positions: &[[f32; 3]],
        loops: impl ExactSizeIterator<Item = &'a [u32]> + Clone,
    ) {
        let at = |vertex: u32| positions[vertex as usize].map(f64::from);
        let Some([u, v]) = plane(loops.clone().map(|corners| corners.iter().map(|&vertex| at(vertex)))) else { return };
        let flat = |vertex: u32| [at(vertex)[u], at(vertex)[v]];
        if is_too_tangled(loops.clone().flatten().map(|&vertex| positions[vertex as usize])) {
            return;
        }
        self.vertices.clear();
        self.holes.clear();
        for (index, corners) in loops.enumerate() {
            if index > 0 {
                self.holes.push(self.vertices.len() as u32);
            }
            self.vertices.extend(corners);
        }
        self.points.clear();
        self.points.extend(self.vertices.iter().map(|&vertex| flat(vertex)));
        let earcut = self.earcut.get_or_insert_with(Earcut::new);
        earcut.earcut(self.points.iter().copied(), &self.holes, &mut self.found);
        let found = self.found.as_chunks::<3>().0.iter().map(|face| face.map(|index| self.vertices[index as usize]));
        // The projection is counter-clockwise, and so are these.
        triangles.extend(found.filter(|&face| !is_degenerate(face)));
    }
}

/// The most corners with equal positions, and the most in all, for which ears are cut. Without ears, `earcut` may take time
/// with the cube of the number of corners. Fans fill the remaining loops.
const MOST_COINCIDENT: usize = 16;
const MOST_CORNERS: usize = 1 << 15;

/// Whether loops visit a position many times, which only loops without a sensible surface do, or have very many corners.
fn is_too_tangled(corners: impl Iterator<Item = [f32; 3]>) -> bool {
    let mut points: Vec<[u32; 3]> = corners.map(|p| p.map(|c| (c + 0.0).to_bits())).collect();
    if points.len() <= MOST_COINCIDENT {
        return false;
    }
    points.sort_unstable();
    points.len() > MOST_CORNERS
        || points.windows(MOST_COINCIDENT + 1).any(|window| window[0] == window[MOST_COINCIDENT])
}

/// The two axes onto which loops are projected: they are counter-clockwise there. `None` for loops without an area, or
/// with a corner that is not finite.
fn plane(loops: impl Iterator<Item = impl ExactSizeIterator<Item = [f64; 3]> + Clone>) -> Option<[usize; 2]> {
    let mut normal = [0.0; 3];
    for corners in loops {
        let Some(origin) = corners.clone().next() else { continue };
        let from_origin = |p: [f64; 3]| [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
        for (p, q) in corners.clone().zip(corners.skip(1)) {
            let (p, q) = (from_origin(p), from_origin(q));
            for (axis, sum) in normal.iter_mut().enumerate() {
                let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
                *sum += p[y] * q[z] - p[z] * q[y];
            }
        }
    }
    let axis = (0..3).reduce(|best, axis| if normal[axis].abs() > normal[best].abs() { axis } else { best })?;
    let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
    let is_flat = normal.iter().all(|&n| n == 0.0) || !normal.iter().all(|n: &f64| n.is_finite());
    (!is_flat).then_some(if normal[axis] > 0.0 { [y, z] } else { [z, y] })
}
