//! Coordinates of text, in `f64`, and the positions in `f32` that are made of them.

use rimline::Origin;

/// A number. Rounded from `f64` to `f32`, it is the `f32` that is nearest to the text. For that it may be a step of `f64` off.
pub(crate) fn number(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok().or_else(|| not_finite(text))?;
    if !is_between(number) {
        return Some(number);
    }
    // The text may lie on the other side of the middle, where a step of `f64` is enough.
    let single: f32 = text.parse().ok()?;
    Some(if number as f32 == single {
        number
    } else if f64::from(single) > number {
        number.next_up()
    } else {
        number.next_down()
    })
}

/// NaN and infinity as libraries of C write them, such as `-nan(ind)`, `1.#QNAN` and `-1.#INF00`.
fn not_finite(text: &str) -> Option<f64> {
    let magnitude = text.strip_prefix('-').unwrap_or(text);
    let is_nan = magnitude.strip_prefix("nan(").is_some_and(|kind| kind.ends_with(')'));
    match magnitude.strip_prefix("1.#") {
        Some(kind) if kind.starts_with("INF") => {
            Some(if text.starts_with('-') { f64::NEG_INFINITY } else { f64::INFINITY })
        }
        Some(kind) if ["QNAN", "SNAN", "IND"].iter().any(|nan| kind.starts_with(nan)) => Some(f64::NAN),
        _ => is_nan.then_some(f64::NAN),
    }
}

/// Whether a number may lie in the middle of two neighbouring `f32`.
fn is_between(number: f64) -> bool {
    const LOST: u64 = (1 << 29) - 1;
    let is_subnormal = number != 0.0 && number.abs() < 2.0 * f64::from(f32::MIN_POSITIVE);
    number.is_finite() && (number.to_bits() & LOST == 1 << 28 || is_subnormal)
}

/// The corners of each face, where faces have so many each.
pub(crate) fn faces<'a>(sizes: &'a [u32], corners: &'a [u32]) -> impl ExactSizeIterator<Item = &'a [u32]> {
    let mut rest = corners;
    sizes.iter().map(move |&size| {
        let (face, others) = rest.split_at_checked(size as usize).unwrap_or((rest, &[]));
        rest = others;
        face
    })
}

/// The origin of faces of so many corners each, and positions relative to it. All corners are below the number of vertices.
pub(crate) fn placed(vertices: Vec<[f64; 3]>, sizes: &[u32], corners: &[u32]) -> (Vec<[f32; 3]>, Origin) {
    let vertex = |&v: &u32| vertices.get(v as usize).copied();
    let smallest_edge = || {
        let edges = faces(sizes, corners).flat_map(|face| face.iter().zip(face.iter().cycle().skip(1)));
        Origin::smallest_edge(edges.filter_map(|(a, b)| Some([vertex(a)?, vertex(b)?])))
    };
    let bounds = Origin::bounds(corners.iter().filter_map(vertex));
    let origin = bounds.map_or(Origin::ZERO, |bounds| Origin::near(bounds, smallest_edge));
    (vertices.into_iter().map(|vertex| origin.position(vertex)).collect(), origin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_rounded_to_f32_once() {
        for text in [
            // Just above and below the middle of 1 and its neighbours; in f64 they are the middle.
            "1.00000005960464477539062500000000000001",
            "1.00000005960464477539062499999999999999",
            "1.000000059604644775390625",
            "0.99999997019767761230468750000000000001",
            "-1.00000005960464477539062500000000000001",
            // The same among subnormal numbers and at the largest.
            "7.006492321624085354618e-46",
            "7.0064923216240853546186479164495807e-46",
            "1.0507e-45",
            "340282356779733661637539395458142568447.9999999999999999999",
            "340282356779733661637539395458142568448",
            "1e39",
            "-0",
            "1e-60",
            "392143.517",
            "inf",
        ] {
            let single: f32 = text.parse().expect(text);
            let double = number(text).expect(text);
            assert_eq!((double as f32).to_bits(), single.to_bits(), "{text}");
        }
        assert!(number("nan").is_some_and(f64::is_nan) && number("zero").is_none() && number("1,5").is_none());
        for text in ["-nan", "nan(snan)", "-nan(ind)", "1.#QNAN", "-1.#IND00"] {
            assert!(number(text).is_some_and(f64::is_nan), "{text}");
        }
        assert_eq!([number("1.#INF"), number("-1.#INF00")], [Some(f64::INFINITY), Some(f64::NEG_INFINITY)]);
        assert_eq!(["nan(", "1.#", "1.#2", "-", "--nan(ind)"].map(number), [None; 5]);
        // Where it is no middle, nothing is moved.
        assert_eq!(number("392143.517"), Some(392_143.517));
    }

    #[test]
    fn a_house_far_away_is_near_its_origin() {
        let [x, z] = [392_143.517, -5_820_467.702];
        // The first vertex is no part of any face, and one edge has no length.
        let vertices = vec![[0.0; 3], [x, 34.0, z], [x + 0.2, 34.0, z], [x + 0.2, 34.3, z], [x, 34.3, z], [x, 34.3, z]];
        let (positions, origin) = placed(vertices.clone(), &[4, 3], &[1, 2, 3, 4, 5, 4, 1]);
        assert!(!origin.is_zero());
        let width = positions[2][0] - positions[1][0];
        assert!((width - 0.2).abs() < 1e-6, "{width}");
        // Edges of 300 are long enough there.
        let wide = vertices.iter().map(|[x, y, z]| [x + 1500.0 * (y - 34.0), *y, *z]).collect();
        let (positions, origin) = placed(wide, &[3], &[1, 2, 4]);
        assert!(!origin.is_zero(), "the width of 0.2 counts");
        assert_eq!(positions.len(), 6);
        let far = vec![[x, 0.0, z], [x + 300.0, 0.0, z], [x, 300.0, z]];
        assert_eq!(placed(far, &[3], &[0, 1, 2]).1, Origin::ZERO);
    }
}
