//! How a light sees a boundary, by brute force and written apart from `src/`: the light is really moved, the boundary is
//! projected to a plane, and the plane is cut into strips at every corner and crossing. In each strip the winding numbers
//! of all positions are counted from below. All in big integers.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use num_bigint::BigInt;
use rimline::Light;
use rimline::internals::cpu::Orientation;

use super::shadow_oracle::{Homogeneous, Vector, cross, least, minus, scaled, sign};

/// Result of the oracle for a boundary and a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// How the light sees it.
    pub orientation: Orientation,
    /// Whether the boundary touches itself in space, elsewhere than at common ends of edges.
    pub touches: bool,
}

fn dot(u: &Vector, v: &Vector) -> BigInt {
    (0..3).map(|axis| &u[axis] * &v[axis]).sum()
}

fn is_zero(v: &Vector) -> bool {
    v.iter().all(|c| sign(c) == 0)
}

/// A boundary and a light, in integers of one scale.
struct Scaled {
    /// Edges that have a length.
    edges: Vec<[Vector; 2]>,
    light: Homogeneous,
}

impl Scaled {
    fn new(edges: &[[[f32; 3]; 2]], light: Light) -> Self {
        let scale = -least(edges.iter().flatten().flatten().copied());
        let integers = |p: [f32; 3]| p.map(|c| scaled(c, scale));
        let edges = edges.iter().map(|edge| edge.map(integers)).filter(|[a, b]| a != b).collect();
        Self { edges, light: Homogeneous::light(light, scale) }
    }

    fn touches(&self) -> bool {
        (0..self.edges.len()).any(|i| (0..i).any(|j| touch(&self.edges[i], &self.edges[j])))
    }

    /// The plane that the moved light sees. `None` if the boundary fits no half-space.
    fn projection(&self) -> Option<Projection> {
        let Homogeneous { xyz, w } = self.light.moved(self.edges.iter().flatten());
        Projection::new(&self.edges, &xyz, w)
    }

    fn flat(&self, projection: &Projection) -> Vec<[Vector; 2]> {
        self.edges.iter().map(|[a, b]| [projection.point(a), projection.point(b)]).collect()
    }
}

/// The boundary of these directed edges, whose numbers are finite.
pub fn find(edges: &[[[f32; 3]; 2]], light: Light) -> Found {
    let scaled = Scaled::new(edges, light);
    let touches = scaled.touches();
    if is_in_plane(&scaled.edges, &scaled.light) {
        return Found { orientation: Orientation::InPlane, touches };
    }
    let Some(projection) = scaled.projection() else { return Found { orientation: Orientation::Twisted, touches } };
    let windings = windings(&scaled.flat(&projection));
    let is_within = |allowed: [i32; 2]| windings.iter().all(|winding| allowed.contains(winding));
    let orientation = match () {
        () if is_within([0, 1]) => Orientation::FrontFacing,
        () if is_within([0, -1]) => Orientation::BackFacing,
        () => Orientation::Twisted,
    };
    Found { orientation, touches }
}

/// For each edge the others that cross it as the light sees them. `None` if the boundary fits no half-space, or touches
/// itself in space.
pub fn cuts(edges: &[[[f32; 3]; 2]], light: Light) -> Option<Vec<usize>> {
    let scaled = Scaled::new(edges, light);
    let flat = scaled.flat(&scaled.projection().filter(|_| !scaled.touches())?);
    Some(cuts_by(&flat, |a, b, c| sign(&dot(a, &cross(b, c)))))
}

/// The same, by the side on which a point lies of the line through two others.
pub fn cuts_by<P>(edges: &[[P; 2]], side: impl Fn(&P, &P, &P) -> i32) -> Vec<usize> {
    let parts = |[a, b]: &[P; 2], [c, d]: &[P; 2]| side(a, b, c) * side(a, b, d) < 0;
    let of = |edge: &[P; 2]| edges.iter().filter(|other| parts(edge, other) && parts(other, edge)).count();
    edges.iter().map(of).collect()
}

/// Which of two fractions with positive denominators is larger.
fn compare(n: &BigInt, d: &BigInt, other_n: &BigInt, other_d: &BigInt) -> Ordering {
    (n * other_d).cmp(&(other_n * d))
}

/// A plane that is seen from the light as counter-clockwise.
struct Projection {
    light: Vector,
    w: BigInt,
    u: Vector,
    v: Vector,
    /// All directions from the light to corners have a positive product with it. Not used for a light at infinity.
    forward: Vector,
}

impl Projection {
    fn new(edges: &[[Vector; 2]], light: &Vector, w: BigInt) -> Option<Self> {
        let axis_beside = |v: &Vector| -> Vector {
            let size = |axis: &usize| v[*axis].magnitude().clone();
            let least = (0..3).min_by_key(size).unwrap_or(0);
            std::array::from_fn(|axis| BigInt::from(i32::from(axis == least)))
        };
        if sign(&w) == 0 {
            let u = cross(light, &axis_beside(light));
            let v = cross(light, &u);
            return Some(Self { light: light.clone(), w, u, v, forward: light.clone() });
        }
        let directions: Vec<Vector> = edges.iter().map(|[a, _]| direction(a, light, &w)).collect();
        let forward = forward(&directions)?;
        let u = axis_beside(&forward);
        let v = cross(&u, &forward);
        Some(Self { light: light.clone(), w, u, v, forward })
    }

    /// A homogeneous point of the plane, with positive z.
    fn point(&self, p: &Vector) -> Vector {
        if sign(&self.w) == 0 {
            return [dot(&self.u, p), dot(&self.v, p), BigInt::from(1)];
        }
        let d = direction(p, &self.light, &self.w);
        [&self.u, &self.v, &self.forward].map(|axis| dot(axis, &d))
    }
}

/// From the light to a point, times w.
fn direction(p: &Vector, light: &Vector, w: &BigInt) -> Vector {
    std::array::from_fn(|axis| w * &p[axis] - &light[axis])
}

/// A vector that has positive products with all directions, if there is one.
fn forward(directions: &[Vector]) -> Option<Vector> {
    let serves = |h: &Vector| directions.iter().all(|d| sign(&dot(h, d)) > 0);
    // The mean of the directions often serves, and has few bits.
    let bits = directions.iter().flatten().map(BigInt::bits).max().unwrap_or(0);
    let rough = |c: &BigInt| c >> bits.saturating_sub(12);
    let mean: Vector = std::array::from_fn(|axis| directions.iter().map(|d| rough(&d[axis])).sum());
    if serves(&mean) {
        return Some(mean);
    }
    // The planes through two directions that have all others on one side.
    let mut sum: Vector = std::array::from_fn(|_| BigInt::ZERO);
    let mut is_any = false;
    for (index, d) in directions.iter().enumerate() {
        for other in &directions[..index] {
            let normal = cross(d, other);
            let (mut is_below, mut is_above) = (false, false);
            for third in directions {
                let side = sign(&dot(&normal, third));
                is_above |= side > 0;
                is_below |= side < 0;
                if is_above && is_below {
                    break;
                }
            }
            if is_above != is_below {
                is_any = true;
                for (sum, n) in sum.iter_mut().zip(&normal) {
                    *sum += if is_above { n.clone() } else { -n };
                }
            }
        }
    }
    if is_any {
        assert!(serves(&sum), "the oracle's own half-space does not hold the boundary");
        return Some(sum);
    }
    // The light is in the hull, and so in a tetrahedron at the first corner.
    assert!(is_enclosed(directions), "the oracle found neither a half-space nor a tetrahedron around the light");
    None
}

/// Whether some tetrahedron with the first direction has the light in it.
fn is_enclosed(directions: &[Vector]) -> bool {
    let Some((d, others)) = directions.split_first() else { return false };
    let side = |a: &Vector, b: &Vector, c: &Vector| sign(&dot(&cross(a, b), c));
    others.iter().enumerate().any(|(i, p)| {
        others[..i].iter().enumerate().any(|(j, q)| {
            let whole = side(d, p, q);
            whole != 0
                && others[..j].iter().any(|r| {
                    // Each is opposite to the cone of the other three.
                    whole == -side(r, p, q) && whole == -side(d, r, q) && whole == -side(d, p, r)
                })
        })
    })
}

/// Whether all corners are in one plane with the light, which is not moved.
fn is_in_plane(edges: &[[Vector; 2]], light: &Homogeneous) -> bool {
    let corners: Vec<&Vector> = edges.iter().map(|[a, _]| a).collect();
    let is_level = |a: &Vector, b: &Vector, c: &Vector| {
        let to_light: Vector = std::array::from_fn(|axis| &light.xyz[axis] - &light.w * &a[axis]);
        sign(&dot(&cross(&minus(b, a), &minus(c, a)), &to_light)) == 0
    };
    (0..corners.len()).all(|i| (0..i).all(|j| (0..j).all(|k| is_level(corners[i], corners[j], corners[k]))))
}

/// Whether two edges meet in space elsewhere than at an end of both.
fn touch([a, b]: &[Vector; 2], [c, d]: &[Vector; 2]) -> bool {
    let (u, v, from_a) = (minus(b, a), minus(d, c), minus(c, a));
    let normal = cross(&u, &v);
    let is_end = |at: &BigInt, whole: &BigInt| sign(at) == 0 || at == whole;
    let is_within = |at: &BigInt, whole: &BigInt| sign(at) >= 0 && at <= whole;
    if is_zero(&normal) {
        if !is_zero(&cross(&u, &from_a)) {
            return false;
        }
        let whole = dot(&u, &u);
        let (from, to) = (dot(&u, &from_a), dot(&u, &minus(d, a)));
        let (low, high) = if from < to { (from, to) } else { (to, from) };
        return low < whole && sign(&high) > 0;
    }
    if sign(&dot(&normal, &from_a)) != 0 {
        return false;
    }
    let whole = dot(&normal, &normal);
    let (s, t) = (dot(&cross(&from_a, &v), &normal), dot(&cross(&from_a, &u), &normal));
    is_within(&s, &whole) && is_within(&t, &whole) && !(is_end(&s, &whole) && is_end(&t, &whole))
}

/// The winding numbers of all regions of the plane with an area.
fn windings(edges: &[[Vector; 2]]) -> BTreeSet<i32> {
    let lines: Vec<Vector> = edges.iter().map(|[p, q]| cross(p, q)).collect();
    let mut cuts: Vec<(BigInt, BigInt)> = edges.iter().map(|[[x, _, z], _]| (x.clone(), z.clone())).collect();
    for (i, [p, q]) in edges.iter().enumerate() {
        for (j, [r, s]) in edges.iter().enumerate().take(i) {
            let side = |line: &Vector, p: &Vector| sign(&dot(line, p));
            let is_crossing =
                side(&lines[i], r) * side(&lines[i], s) < 0 && side(&lines[j], p) * side(&lines[j], q) < 0;
            if is_crossing {
                let [x, _, z] = cross(&lines[i], &lines[j]);
                cuts.push(if sign(&z) < 0 { (-x, -z) } else { (x, z) });
            }
        }
    }
    cuts.sort_by(|(x, z), (other_x, other_z)| compare(x, z, other_x, other_z));
    let mut found = BTreeSet::new();
    for pair in cuts.windows(2) {
        let [(x, z), (other_x, other_z)] = pair else { continue };
        if compare(x, z, other_x, other_z) == Ordering::Equal {
            continue;
        }
        // Between both.
        strip(edges, &lines, &(x + other_x), &(z + other_z), &mut found);
    }
    found
}

/// The winding numbers along the vertical line at x / z, which meets no corner and no crossing.
fn strip(edges: &[[Vector; 2]], lines: &[Vector], x: &BigInt, z: &BigInt, found: &mut BTreeSet<i32>) {
    let mut heights: Vec<(BigInt, BigInt, i32)> = Vec::new();
    for ([p, q], [a, b, c]) in edges.iter().zip(lines) {
        let [from, to] = [p, q].map(|[at, _, unit]| compare(at, unit, x, z));
        if from == to {
            continue;
        }
        // a·x + b·y + c·z = 0.
        let (n, d) = (-(a * x + c * z), b * z);
        let (n, d) = if sign(&d) < 0 { (-n, -d) } else { (n, d) };
        heights.push((n, d, if from == Ordering::Less { 1 } else { -1 }));
    }
    heights.sort_by(|(n, d, _), (other_n, other_d, _)| compare(n, d, other_n, other_d));
    let mut winding = 0;
    for (index, (n, d, step)) in heights.iter().enumerate() {
        winding += step;
        let next = heights.get(index + 1);
        if next.is_none_or(|(next_n, next_d, _)| compare(n, d, next_n, next_d) == Ordering::Less) {
            found.insert(winding);
        }
    }
    assert_eq!(winding, 0, "a boundary that is not closed");
}
