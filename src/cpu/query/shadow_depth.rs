//! Occluder counts: the number of faces strictly between each point and each light.

use super::exact_shadow_depth::exactly_between;
use super::shadow_boxes::{CLUSTER, shadow_boxes};
use crate::Light;
use crate::cpu::common::double_sign::{RELATIVE, certain_sign, cross, difference, dot, sum_of_sizes, to_light};
use crate::cpu::common::parallel::Threads;
use crate::cpu::common::positions::{is_finite, position};
use crate::cpu::error::{CpuError, check_on_face, check_positions};
use crate::layout::FaceCluster;
use crate::light::{MAX_LIGHTS, check_shadow_lights};
use crate::mesh::{Mesh, NO_FACE, is_degenerate};

/// The depths of `points` for `lights`: the number of faces of `mesh` strictly between point and light. Each face
/// counts once, in either orientation. A polygon counts once if an odd number of its triangles lie between, and not at
/// all otherwise: where it is folded, it darkens what its boundary does, twisted or not. All inputs are in one space.
/// Points follow each other in the result, with one number for each light. A point that is infinite or NaN has −1.
///
/// Two kinds of faces do not count: those with an infinite or NaN vertex, and those that name a vertex twice. A face that
/// contains the point or the light does not lie between them. Other ties are broken as if the light were moved by
/// `(ε, ε², ε³)`; see docs/numerics/query.md.
///
/// A point that is on a face may lie before or behind it after rounding: [`shadow_depth_on_faces`] leaves that face out, and
/// [`Light::lift`] moves points off all faces.
///
/// The GPU gives the same integers. Here `f64` decides where a bound allows it, else integers do. Range and cone of a light
/// have no effect.
///
/// # Errors
/// [`CpuError`] for fewer positions than the mesh has vertices, more lights than [`MAX_LIGHTS`], or a light that is
/// non-finite, all zeros, has an impossible range or cone, or a negative `w`.
pub fn shadow_depth(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    points: &[[f32; 3]],
    lights: &[Light],
    threads: Threads,
) -> Result<Vec<i32>, CpuError> {
    shadow_depth_on_faces(positions, mesh, points, None, lights, threads)
}

/// Like [`shadow_depth`], for points on the surface. `on_face` has an entry for each point: the index in [`Mesh::faces`] of
/// the face that it is on, or [`NO_FACE`]. This face does not count for its point, as if the point were exactly in it,
/// wherever rounding put it. In a mesh with polygons the index names a triangle. The other triangles of its polygon
/// count, as where the point is in the triangle.
///
/// # Errors
/// The errors of [`shadow_depth`], and [`CpuError`] if `on_face` has not an entry for each point, or names a face that
/// the mesh lacks.
pub fn shadow_depth_on_faces(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    points: &[[f32; 3]],
    on_face: Option<&[u32]>,
    lights: &[Light],
    threads: Threads,
) -> Result<Vec<i32>, CpuError> {
    check_shadow_lights(lights, MAX_LIGHTS)?;
    check_positions(positions, mesh)?;
    check_on_face(on_face, points.len(), mesh.faces().len())?;
    let clusters = shadow_boxes(positions, mesh, threads);
    let mut depths = vec![0; points.len() * lights.len()];
    // A point costs about as much as the mesh has faces, so a few points are enough for a thread.
    threads.share_runs_of(16, &mut depths, |first, depths| {
        for (query, depth) in (first..).zip(depths) {
            let (point, light) = (points[query / lights.len()], lights[query % lights.len()]);
            let on_face = on_face.and_then(|faces| faces.get(query / lights.len())).copied().unwrap_or(NO_FACE);
            let segment = || Segment::new(point, light, on_face);
            *depth = if is_finite(point) { segment().depth(positions, &clusters) } else { -1 };
        }
    });
    Ok(depths)
}

/// The segment from a point to a light, or the whole ray if the light is a direction.
struct Segment {
    point: [f32; 3],
    light: [f32; 4],
    p: [f64; 3],
    l: [f64; 3],
    w: f64,
    /// `l − w·p`, from the point towards the light.
    towards: [f64; 3],
    /// The face that the point is on, which does not count, or [`NO_FACE`].
    on_face: u32,
}

impl Segment {
    fn new(point: [f32; 3], light: Light, on_face: u32) -> Self {
        let light @ [x, y, z, w] = light.to_array();
        let ([p, l], w) = ([point, [x, y, z]].map(|v| v.map(f64::from)), f64::from(w));
        Self { point, light, p, l, w, towards: to_light(p, l, w), on_face }
    }

    fn depth(&self, positions: &[[f32; 3]], clusters: &[FaceCluster]) -> i32 {
        let mut depth = 0;
        // The current polygon, by the index of its first face, and whether an odd number of its triangles lie between so
        // far.
        let mut odd = (0, false);
        for (group_index, group) in clusters.chunks(CLUSTER).enumerate() {
            if self.misses(group[0].group_low, group[0].group_high) {
                continue;
            }
            for (index, cluster) in group.iter().enumerate() {
                if self.misses(cluster.low, cluster.high) {
                    continue;
                }
                let bound = self.edge_bound(cluster);
                for lane in 0..CLUSTER {
                    if cluster.first_face.wrapping_add(lane as u32) == self.on_face {
                        continue;
                    }
                    if self.crosses(positions, corners_of(cluster, lane), bound) {
                        let head = head_of(cluster, group_index * CLUSTER + index, lane);
                        odd = (head, odd.0 == head && odd.1);
                        // 1, or −1 after an odd number of triangles of the same polygon.
                        depth += if odd.1 { -1 } else { 1 };
                        odd.1 = !odd.1;
                    }
                }
            }
        }
        depth
    }

    /// Whether the segment certainly crosses no face in this box.
    fn misses(&self, low: [u32; 4], high: [u32; 4]) -> bool {
        if high[3] == 0 {
            return true;
        }
        let [low, high] = [low, high].map(corner_of);
        // The box is before both ends or beyond both. These signs are exact.
        let ends = |c: f64, axis: usize| [c - self.p[axis], self.w * c - self.l[axis]];
        let is_apart = |axis: usize| {
            ends(high[axis], axis).into_iter().all(|d| d < 0.0) || ends(low[axis], axis).into_iter().all(|d| d > 0.0)
        };
        if (0..3).any(is_apart) {
            return true;
        }
        // The line passes beside the box, seen along an axis.
        let middle = [0, 1, 2].map(|axis| ((low[axis] - self.p[axis]) + (high[axis] - self.p[axis])) * 0.5);
        let extent = [0, 1, 2].map(|axis| {
            let half = (high[axis] - low[axis]) * 0.5;
            half + MARGIN * (half + middle[axis].abs())
        });
        let d = self.towards;
        [(0, 1), (1, 2), (2, 0)]
            .into_iter()
            .any(|(i, j)| (middle[i] * d[j] - middle[j] * d[i]).abs() > extent[i] * d[j].abs() + extent[j] * d[i].abs())
    }

    /// A bound on the error of a determinant for any edge of the cluster. The box of the cluster holds all its edges.
    fn edge_bound(&self, cluster: &FaceCluster) -> f64 {
        let [low, high] = [cluster.low, cluster.high].map(corner_of);
        let distance = [0, 1, 2].map(|axis| (low[axis] - self.p[axis]).abs().max((high[axis] - self.p[axis]).abs()));
        RELATIVE * sum_of_sizes(difference(high, low)) * sum_of_sizes(distance) * sum_of_sizes(self.towards)
    }

    /// Whether a face lies strictly between point and light. `bound` is that of its cluster.
    fn crosses(&self, positions: &[[f32; 3]], face: [u32; 3], bound: f64) -> bool {
        let corners = face.map(|vertex| position(positions, vertex));
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let [from_a, from_b, from_c] = [a, b, c].map(|corner| difference(self.p, corner));
        let edge = |a: [f64; 3], b: [f64; 3], from_a: [f64; 3]| dot(difference(b, a), cross(from_a, self.towards));
        let sides = [edge(a, b, from_a), edge(b, c, from_b), edge(c, a, from_c)];
        let lowest = sides[0].min(sides[1]).min(sides[2]);
        let highest = sides[0].max(sides[1]).max(sides[2]);
        // Most faces end here. A NaN belongs to a face that does not count.
        if lowest < -bound && highest > bound || !corners.into_iter().all(is_finite) || is_degenerate(face) {
            return false;
        }
        let vectors = [(a, b, from_a), (b, c, from_b), (c, a, from_c)];
        let sides = [0, 1, 2].map(|side| {
            let (a, b, from_a) = vectors[side];
            certain_sign(sides[side], [difference(b, a), from_a, self.towards])
        });
        if sides.contains(&1) && sides.contains(&-1) {
            return false;
        }
        let [u, v] = [difference(b, a), difference(c, a)];
        let normal = cross(u, v);
        let plane_side = |to: [f64; 3]| certain_sign(dot(normal, to), [u, v, to]);
        let [point_side, light_side] = [from_a, to_light(a, self.l, self.w)].map(plane_side);
        if point_side * light_side > 0 {
            return false;
        }
        if point_side * light_side < 0 && sides == [light_side; 3] {
            return true;
        }
        exactly_between(corners, self.point, self.light)
    }
}

/// More than ten times the rounding errors of a box test, relative to its terms.
const MARGIN: f64 = 1e-14;
/// A corner of a box.
fn corner_of([x, y, z, _]: [u32; 4]) -> [f64; 3] {
    [x, y, z].map(|bits| f64::from(f32::from_bits(bits)))
}

/// The index of the first face of a face's polygon. `index` is the index of the cluster, `lane` that of the face in it.
fn head_of(cluster: &FaceCluster, index: usize, lane: usize) -> usize {
    let begins = !cluster.continues & (u32::MAX >> (CLUSTER - 1 - lane));
    begins.checked_ilog2().map_or(cluster.head as usize, |begin| CLUSTER * index + begin as usize)
}

/// The vertices of a face of a cluster.
fn corners_of(cluster: &FaceCluster, lane: usize) -> [u32; 3] {
    [0, 1, 2].map(|corner| cluster.corners[3 * lane + corner])
}
