//! Coordinates at the interface, which are those of the files, and inside, where they are relative to the run's origin.

use rimline::{Light, Origin};
use serde_json::{Value, json};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coordinate {
    /// The nearest `f32`, rounded once.
    pub(crate) single: f32,
    pub(crate) double: f64,
}

/// The components of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GivenLight(pub(crate) [Coordinate; 4]);

impl Coordinate {
    /// Relative to a coordinate of the origin.
    pub(crate) fn relative_to(self, origin: f64) -> f32 {
        if origin == 0.0 { self.single } else { (self.double - origin) as f32 }
    }
}

pub(crate) fn relative(point: [Coordinate; 3], origin: Origin) -> [f32; 3] {
    let ([x, y, z], [ox, oy, oz]) = (point, origin.to_array());
    [x.relative_to(ox), y.relative_to(oy), z.relative_to(oz)]
}

impl GivenLight {
    /// Each component the nearest `f32`.
    pub(crate) fn light(self) -> Light {
        Light::homogeneous(self.0.map(|c| c.single))
    }

    pub(crate) fn relative_to(self, origin: Origin) -> Light {
        let light = self.light();
        if origin.is_zero() { light } else { Light { w: light.w, ..origin.light(self.0.map(|c| c.double)) } }
    }
}

/// A number relative to `origin` in the file's coordinates: of those that are rounded to it, the one with the fewest digits.
fn shown(relative: f32, origin: f64) -> f64 {
    let exact = f64::from(relative) + origin;
    let is_same = |number: &f64| ((number - origin) as f32).to_bits() == relative.to_bits();
    let rounded = (0..17).filter_map(|digits| format!("{exact:.digits$}").parse().ok());
    rounded.into_iter().find(is_same).unwrap_or(exact)
}

/// A point for a report, in the file's coordinates.
pub(crate) fn point(point: [f32; 3], origin: Origin) -> Point {
    if origin.is_zero() {
        return Point::Single(point);
    }
    let ([x, y, z], [ox, oy, oz]) = (point, origin.to_array());
    Point::Double([shown(x, ox), shown(y, oy), shown(z, oz)])
}

/// A light's components for a report, in the file's coordinates.
pub(crate) fn light(light: &Light, origin: Origin) -> Value {
    if origin.is_zero() || light.w == 0.0 {
        return json!(light.to_array());
    }
    let ([x, y, z], w) = (light.xyz, f64::from(light.w));
    let [ox, oy, oz] = origin.to_array().map(|c| w * c);
    json!([shown(x, ox), shown(y, oy), shown(z, oz), light.w])
}

/// A point in the file's coordinates. `f32` is printed as `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Point {
    Single([f32; 3]),
    Double([f64; 3]),
}

impl Point {
    pub(crate) fn json(self) -> Value {
        match self {
            Self::Single(point) => json!(point),
            Self::Double(point) => json!(point),
        }
    }
}

/// Formats a point as `x,y,z`, the form that the command line takes.
impl std::fmt::Display for Point {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Single([x, y, z]) => write!(to, "{x},{y},{z}"),
            Self::Double([x, y, z]) => write!(to, "{x},{y},{z}"),
        }
    }
}

/// Adds the key `origin` to a report, unless it is zero.
pub(crate) fn add_origin(report: &mut Value, origin: Origin) {
    if !origin.is_zero() {
        report["origin"] = json!(origin.to_array());
    }
}

/// Text about the origin, and what it is for, for a report for people. `None` if the origin is zero.
pub(crate) fn origin_text(origin: Origin, what: &str) -> Option<String> {
    let [x, y, z] = origin.to_array();
    (!origin.is_zero()).then(|| format!("{x},{y},{z}: {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_have_the_files_coordinates() {
        let origin = Origin::new([392_160.0, 32.0, -5_820_448.0]);
        let position = [392_143.517, 34.128, -5_820_467.702];
        let relative = origin.position(position);
        assert_eq!(point(relative, origin), Point::Double(position));
        assert_eq!(
            light(&origin.light([position[0], position[1], position[2], 1.0]), origin),
            json!([392_143.517, 34.128, -5_820_467.702, 1.0])
        );
        assert_eq!(light(&Light::directional([0.5, 1.0, 0.0]), origin), json!([0.5, 1.0, 0.0, 0.0]));
        // Without an origin it is f32.
        assert_eq!(point([0.1, 2.0, -3.5], Origin::ZERO).json(), json!([0.1_f32, 2.0_f32, -3.5_f32]));
        assert!(point([f32::NAN, 0.0, 0.0], origin) != point([0.0; 3], origin));
    }

    #[test]
    fn what_is_given_is_moved_before_it_is_rounded() {
        let origin = Origin::new([392_160.0, 32.0, 0.0]);
        let given = |text: &str| Coordinate { single: text.parse().expect(text), double: text.parse().expect(text) };
        assert_eq!(relative([given("392143.517"), given("34.128"), given("0.1")], origin), [-16.483, 2.128, 0.1]);
        assert_eq!(relative([given("392143.517"), given("0"), given("0")], Origin::ZERO)[0], 392_143.53);
        let lamp = GivenLight(["392143.517", "34.128", "0.1", "1"].map(given));
        assert_eq!(lamp.relative_to(origin).to_array(), [-16.483, 2.128, 0.1, 1.0]);
        let far = GivenLight(["0.1", "1", "0", "0"].map(given));
        assert_eq!(far.relative_to(origin), far.light());
    }
}
