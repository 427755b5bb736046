//! The error bounds of docs/numerics, with its constants. Evaluated in f64, whose own error the last digits cover.

use rimline::{Geometry, InstancePose, Light};

use super::oracle::ExactFace;

/// One whole ulp: WGSL names no rounding mode.
const U: f64 = 1.192_092_895_507_812_5e-7;
/// The least normal f32, 2⁻¹²⁶: what flushing may lose.
const TAU: f64 = 1.175_494_350_822_287_5e-38;
/// Beyond these magnitudes an intermediate of "Error band" or "Per edge" may overflow, and nothing is promised.
const MOST: f64 = 1e12;
const MOST_PER_EDGE: f64 = 1_073_741_824.0;

/// A few f64 operations' worth, so that a bound evaluated in f64 is no smaller than the exact one.
const EVALUATED: f64 = 1.0 + 1e-12;

/// (1 + u)ⁿ − 1.
pub fn gamma(n: i32) -> f64 {
    (1.0 + U).powi(n) - 1.0
}

/// The determinant of a face and a light, its P and Q, and the largest magnitude, in f64.
struct Terms {
    determinant: f64,
    p: f64,
    q: f64,
    l: f64,
    largest: f64,
}

impl Terms {
    fn new(corners: [[f32; 3]; 3], [x, y, z, w]: [f64; 4]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let (l, wa) = ([x, y, z], a.map(|c| w * c));
        let mut terms = Self { determinant: 0.0, p: 0.0, q: 0.0, l: 0.0, largest: w.abs() };
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let [first, second] = [(b[j] - a[j]) * (c[k] - a[k]), (b[k] - a[k]) * (c[j] - a[j])];
            let n = first.abs() + second.abs();
            terms.determinant += (first - second) * (l[i] - wa[i]);
            terms.p += n * (l[i] - wa[i]).abs();
            terms.q += n * wa[i].abs();
            terms.l += n * l[i].abs();
            for value in [a[i], b[i], c[i], l[i], wa[i]] {
                terms.largest = terms.largest.max(value.abs());
            }
        }
        terms
    }
}

/// The light times the power of two that brings its largest component between 1 and 2; exact in f64.
pub fn scaled(light: Light) -> [f64; 4] {
    let mut given = light.to_array().map(f64::from);
    let largest = given.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
    if largest > 0.0 {
        let exponent = (largest.to_bits() >> 52) as i32 - 1023;
        let scale = 2.0_f64.powi(-exponent);
        given = given.map(|c| c * scale);
    }
    given
}

/// The determinant that a bound is for, and the bound.
pub type Bound = fn([[f32; 3]; 3], Light) -> (f64, Option<f64>);

/// D and B of docs/numerics/facing.md, "Error band": where |D| > B, the f32 local form has the right sign. No B: nothing is
/// promised.
pub fn facing_bound(corners: [[f32; 3]; 3], light: Light) -> (f64, Option<f64>) {
    let light_scaled = scaled(light);
    // Products with a power of two are exact.
    let is_exact = light.w.to_bits() << 9 == 0;
    let q = if is_exact { 0.0 } else { Terms::new(corners, light_scaled).q };
    let (determinant, bound) = facing_bound_without_q(corners, light);
    (determinant, bound.map(|bound| bound + U * (1.0 + gamma(8)) * q * EVALUATED))
}

/// A bound that forgets what the rounding of w·a does: for negative controls.
pub fn facing_bound_without_q(corners: [[f32; 3]; 3], light: Light) -> (f64, Option<f64>) {
    let Terms { p, largest: m, determinant, .. } = Terms::new(corners, scaled(light));
    let underflow = 256.0 * TAU * m * (1.0 + m).powi(2) + 16.0 * TAU;
    // The determinant in f64 is itself wrong by at most 2⁻⁴⁹ P.
    (determinant, (m <= MOST).then_some((gamma(8) * p + underflow) * EVALUATED + 2e-15 * p))
}

/// The same of docs/numerics/facing.md, "Per edge", for the first corner as origin.
pub fn per_edge_bound(corners: [[f32; 3]; 3], light: Light) -> (f64, Option<f64>) {
    let terms = Terms::new(corners, light.to_array().map(f64::from));
    let Terms { p, q, l, largest: m, determinant } = terms;
    let bound = (gamma(11) * (l + q) + 512.0 * TAU * (1.0 + m).powi(3)) * EVALUATED + 2e-15 * p;
    (determinant, (m <= MOST_PER_EDGE).then_some(bound))
}

/// Whether `bound` decides the pair: its exact determinant lies outside the band.
pub fn is_outside(corners: [[f32; 3]; 3], light: Light, bound: Bound) -> bool {
    let (determinant, bound) = bound(corners, light);
    bound.is_some_and(|bound| determinant.abs() > bound)
}

/// Facing bits that were checked, and those that lay in the band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Checked {
    pub outside: usize,
    pub inside: usize,
}

/// Fails on the first facing bit that is wrong outside the band of the local form, or set past the lights. Bits in the band
/// pass, right or wrong, so a caller looks at how many were outside.
pub fn check_facing(
    what: &str,
    facing: &[u32],
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    lights: &[Light],
) -> Result<Checked, String> {
    check_facing_by(facing_bound, what, facing, positions, faces, lights)
}

/// The same outside another form's band.
pub fn check_facing_by(
    bound: Bound,
    what: &str,
    facing: &[u32],
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    lights: &[Light],
) -> Result<Checked, String> {
    if facing.len() != faces.len() * lights.len().div_ceil(32) {
        return Err(format!("{what}: {} masks for {} faces", facing.len(), faces.len()));
    }
    let mut checked = Checked::default();
    for (index, &face) in faces.iter().enumerate() {
        let exact = ExactFace::new(positions, face);
        let corners = face.map(|v| positions[v as usize]);
        for (number, &light) in lights.iter().enumerate() {
            let bit = facing[number / 32 * faces.len() + index] >> (number % 32) & 1 != 0;
            let right = exact.as_ref().is_some_and(|exact| exact.sign(light) > 0);
            if exact.is_some() && !is_outside(corners, light, bound) {
                checked.inside += 1;
            } else if bit == right {
                checked.outside += 1;
            } else {
                return Err(format!(
                    "{what}: face {index}, light {number}: bit {bit} outside the error band, exactly {right}"
                ));
            }
        }
        for (word, lights) in lights.chunks(32).enumerate() {
            let past = facing[word * faces.len() + index].checked_shr(lights.len() as u32).unwrap_or(0);
            if past != 0 {
                return Err(format!("{what}: face {index} has bits past the lights of word {word}"));
            }
        }
    }
    Ok(checked)
}

/// The bound of docs/numerics/deform.md, "Deform", between any two evaluations of one coordinate each: GPU against CPU.
pub fn deform_bound(geometry: &Geometry, pose: &InstancePose, vertex: usize) -> [f64; 3] {
    let magnitude = |value: f32| f64::from(value).abs();
    let mut morphed = geometry.positions()[vertex].map(magnitude);
    let mut largest = morphed.into_iter().fold(1.0, f64::max);
    let active = geometry.morph_targets().iter().zip(pose.morph_weights());
    let active: Vec<_> = active.filter(|&(_, &weight)| weight != 0.0).collect();
    for &(target, &weight) in &active {
        for (sum, offset) in morphed.iter_mut().zip(target[vertex].map(magnitude)) {
            *sum += magnitude(weight) * offset;
            largest = largest.max(*sum).max(offset).max(magnitude(weight));
        }
    }
    let influences: Vec<(u32, f32)> = match geometry.influences() {
        None => vec![(0, 1.0)],
        Some(of) => of.range(vertex).map(|at| (of.joints()[at], of.weights()[at])).collect(),
    };
    let mut sums = [0.0; 3];
    for &(joint, weight) in &influences {
        for (sum, row) in sums.iter_mut().zip(pose.palette()[joint as usize].rows()) {
            let [x, y, z, w] = row.map(magnitude);
            let along = x * morphed[0] + y * morphed[1] + z * morphed[2] + w;
            *sum += magnitude(weight) * along;
            for value in [x, y, z, w, along, *sum, magnitude(weight)] {
                largest = largest.max(value);
            }
        }
    }
    let (targets, joints) = (active.len() as i32, influences.len() as i32);
    let operations = targets + 5 + if geometry.influences().is_some() { joints + 1 } else { 0 };
    let underflow = 32.0 * TAU * f64::from(joints.max(1) * (targets + 1)) * largest.powi(3);
    sums.map(|sum| 2.0 * (gamma(operations) * sum + underflow) * EVALUATED)
}
