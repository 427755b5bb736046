//! Lights as homogeneous points.

use glam::{DAffine3, DVec3};

/// The most lights that one extraction takes.
pub const MAX_LIGHTS: usize = 1024;

/// A light (or, for outlines, a camera eye) as a homogeneous point `(x, y, z, w)`, in the space of the positions.
///
/// `w = 1`: a point light at `(x, y, z)`. `w = 0`: a direction **towards** a light at infinity. Any other finite `w`:
/// a point light at `(x, y, z) / w`. A face `(a, b, c)` faces the light when `det[b − a, c − a, l − w·a] > 0`, for
/// every finite `w`; with `w < 0` the sides are therefore reversed, and shadow volumes refuse such a light.
///
/// The components are used as given: never normalised, never divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Homogeneous x, y and z.
    pub xyz: [f32; 3],
    /// The homogeneous weight.
    pub w: f32,
    /// How far the light reaches, in the unit of the positions: Bergeron's sphere of influence (1986). Positive; infinite
    /// for no limit, which is what every constructor sets. It changes no facing or silhouette bit. Casters farther away
    /// throw no shadow volume; see [`crate::gpu::ShadowOptions::end_at_range`], too. Without meaning where `w` is 0.
    pub range: f32,
}

impl Light {
    /// A light at a point, in the unit and space of the positions.
    pub const fn point(xyz: [f32; 3]) -> Self {
        Self { xyz, w: 1.0, range: f32::INFINITY }
    }

    /// A light at infinity; `towards` points from the scene to the light and need not be of unit length.
    pub const fn directional(towards: [f32; 3]) -> Self {
        Self { xyz: towards, w: 0.0, range: f32::INFINITY }
    }

    /// A light as a homogeneous point.
    pub const fn homogeneous(xyzw: [f32; 4]) -> Self {
        let [x, y, z, w] = xyzw;
        Self { xyz: [x, y, z], w, range: f32::INFINITY }
    }

    /// This light with a range, see [`Self::range`].
    #[must_use]
    pub const fn with_range(self, range: f32) -> Self {
        Self { range, ..self }
    }

    /// The four components `(x, y, z, w)`.
    pub const fn to_array(self) -> [f32; 4] {
        let [x, y, z] = self.xyz;
        [x, y, z, self.w]
    }

    /// This light, given in world space, in the space of a mesh that `mesh_to_world` places: four columns of three rows,
    /// the last one the translation.
    ///
    /// A rigid instance may so keep its mesh-space positions: a face's bit is then the one in world space, up to one
    /// rounding of the light's components (computed in `f64`, rounded once to `f32`), for mirrored transforms too,
    /// without turning the mesh's faces. The range stays as it is, in the world's unit. `None` when the transform is singular
    /// or the result is not finite: such an instance casts nothing.
    pub fn to_mesh_space(self, mesh_to_world: &[[f64; 3]; 4]) -> Option<Self> {
        let mesh_to_world = DAffine3::from_cols_array_2d(mesh_to_world);
        let determinant = mesh_to_world.matrix3.determinant();
        if determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        let [x, y, z] = self.xyz.map(f64::from);
        let from_origin = DVec3::new(x, y, z) - f64::from(self.w) * mesh_to_world.translation;
        let xyz = (mesh_to_world.matrix3.inverse() * from_origin).as_vec3().to_array();
        xyz.iter().all(|c| c.is_finite()).then_some(Self { xyz, ..self })
    }
}

/// Why a list of lights is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// Room for no light was asked for.
    #[error("`max_lights` is 0; make room for at least one light")]
    NoRoom,
    /// More than [`MAX_LIGHTS`], or more than the extractor was made for.
    #[error("{count} lights given, at most {limit} fit; split them over several extractions")]
    TooMany {
        /// Lights given.
        count: usize,
        /// Lights that fit.
        limit: usize,
    },
    /// `(0, 0, 0, 0)` is no point.
    #[error("light {index} is (0, 0, 0, 0), which is neither a point nor a direction")]
    Zero {
        /// Position in the list.
        index: usize,
    },
    /// A component is infinite or not a number.
    #[error("light {index} is ({}, {}, {}, {}), and every component must be finite", .xyzw[0], .xyzw[1], .xyzw[2], .xyzw[3])]
    NotFinite {
        /// Position in the list.
        index: usize,
        /// The light as given.
        xyzw: [f32; 4],
    },
    /// A range must be positive, or infinite.
    #[error("light {index} has the range {range}; it must be positive, or infinite for no limit")]
    Range {
        /// Position in the list.
        index: usize,
        /// The range given.
        range: f32,
    },
    /// A negative weight, which shadows refuse.
    #[error(
        "light {index} has w = {w}, and a negative w reverses its sides, which shadows have no use for; negate all four components"
    )]
    NegativeWeight {
        /// Position in the list.
        index: usize,
        /// Its weight.
        w: f32,
    },
}

/// Checks a list of lights: at most `limit` of them, all finite, none all zeros, ranges positive.
///
/// # Errors
/// The first [`LightError`] found.
pub fn check_lights(lights: &[Light], limit: usize) -> Result<(), LightError> {
    if lights.len() > limit {
        return Err(LightError::TooMany { count: lights.len(), limit });
    }
    for (index, light) in lights.iter().enumerate() {
        let xyzw = light.to_array();
        if xyzw.iter().any(|c| !c.is_finite()) {
            return Err(LightError::NotFinite { index, xyzw });
        }
        if xyzw.iter().all(|&c| c == 0.0) {
            return Err(LightError::Zero { index });
        }
        if light.range.is_nan() || light.range <= 0.0 {
            return Err(LightError::Range { index, range: light.range });
        }
    }
    Ok(())
}

/// Checks a list of lights for shadows: as [`check_lights`], and none with a negative weight.
///
/// # Errors
/// The first [`LightError`] found.
pub fn check_shadow_lights(lights: &[Light], limit: usize) -> Result<(), LightError> {
    check_lights(lights, limit)?;
    match lights.iter().enumerate().find(|(_, light)| light.w < 0.0) {
        Some((index, &Light { w, .. })) => Err(LightError::NegativeWeight { index, w }),
        None => Ok(()),
    }
}

/// Checks how many lights there shall be room for: 1 to [`MAX_LIGHTS`].
///
/// # Errors
/// [`LightError::NoRoom`] and [`LightError::TooMany`].
pub(crate) fn check_room(max_lights: usize) -> Result<(), LightError> {
    match max_lights {
        0 => Err(LightError::NoRoom),
        count if count > MAX_LIGHTS => Err(LightError::TooMany { count, limit: MAX_LIGHTS }),
        _ => Ok(()),
    }
}

/// Batches of 32 light bits that `lights` lights take, ⌈N/32⌉.
pub const fn batches(lights: usize) -> usize {
    lights.div_ceil(32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_weights_are_checked() {
        let point = Light::point([1.0, 2.0, 3.0]);
        let check = |light: Light, range| check_shadow_lights(&[point, light.with_range(range)], 2);
        assert_eq!(check(point, 1.0), Ok(()));
        assert_eq!(check(point, f32::INFINITY), Ok(()));
        for range in [0.0, -1.0, f32::NEG_INFINITY] {
            assert_eq!(check(point, range), Err(LightError::Range { index: 1, range }));
        }
        assert!(matches!(check(point, f32::NAN), Err(LightError::Range { index: 1, range }) if range.is_nan()));
        let negative = Light::homogeneous([1.0, 2.0, 3.0, -1.0]);
        assert_eq!(check(negative, 1.0), Err(LightError::NegativeWeight { index: 1, w: -1.0 }));
        assert_eq!(check(Light::homogeneous([1.0, 2.0, 3.0, -0.0]), 1.0), Ok(()));
        let zero = Light::homogeneous([0.0; 4]);
        assert_eq!(check(zero, 1.0), Err(LightError::Zero { index: 1 }));
        assert_eq!(check_shadow_lights(&[point; 3], 2), Err(LightError::TooMany { count: 3, limit: 2 }));
        assert_eq!(check_shadow_lights(&[], 2), Ok(()));
    }
}
