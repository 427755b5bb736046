//! Sides that a view shows.

use std::str::FromStr;

const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// Where an eye at infinity is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    Named(&'static str, [f32; 3]),
    /// To the right of the front, and above the ground, in degrees.
    Angles(f64, f64),
}

/// Names of sides, and where the eye is.
const SIDES: [(&str, [f32; 3]); 7] = [
    ("front", [0.0, 0.0, 1.0]),
    ("back", [0.0, 0.0, -1.0]),
    ("left", [-1.0, 0.0, 0.0]),
    ("right", [1.0, 0.0, 0.0]),
    ("top", [0.0, 1.0, 0.0]),
    ("bottom", [0.0, -1.0, 0.0]),
    ("iso", [1.0, 1.0, 1.0]),
];

impl FromStr for Side {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((name, side)) = SIDES.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)) {
            return Ok(Self::Named(name, side));
        }
        let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
            let angle = |text: &str| text.trim().parse().ok().filter(|degrees: &f64| degrees.abs() <= 360.0);
            Some((angle(azimuth)?, angle(elevation).filter(|degrees| degrees.abs() <= 90.0)?))
        });
        let (azimuth, elevation) = angles.ok_or(
            "a side is front, back, left, right, top, bottom, iso, or an azimuth from -360 to 360 and an elevation from -90 to 90 \
             degrees, such as 30,15",
        )?;
        Ok(Self::Angles(azimuth, elevation))
    }
}

impl Side {
    /// The direction towards the eye, of any length, and the direction that is up on the page.
    pub(crate) fn directions(self) -> ([f64; 3], [f32; 3]) {
        match self {
            Self::Named(_, side) => (side.map(f64::from), up_of(side.map(f64::from))),
            Self::Angles(azimuth, elevation) => of_angles(azimuth, elevation),
        }
    }
}

/// The direction that is up on the page: +Y, or for an eye above or below -Z or +Z.
pub(crate) fn up_of([x, y, z]: [f64; 3]) -> [f32; 3] {
    if libm::sqrt(x * x + z * z) > 1e-6 * y.abs() { UP } else { [0.0, 0.0, if y < 0.0 { 1.0 } else { -1.0 }] }
}

/// The direction towards an eye at these angles in degrees, and what is up on the page.
fn of_angles(azimuth: f64, elevation: f64) -> ([f64; 3], [f32; 3]) {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let (sine, cosine) = (libm::sin(azimuth), libm::cos(azimuth));
    let level = libm::cos(elevation);
    let towards_eye = [sine * level, libm::sin(elevation), cosine * level];
    // Straight from above or below the azimuth still turns the page.
    let up = if level > 1e-6 { UP } else { [-sine, 0.0, -cosine].map(|c| (c * towards_eye[1]) as f32) };
    let towards_eye = if level > 1e-6 { towards_eye } else { [0.0, towards_eye[1], 0.0] };
    (towards_eye, up)
}
