//! Lights as homogeneous points, and checks of lists of lights.

use glam::{DAffine3, DMat3, DVec3};

/// The largest number of lights in one extraction, scene or query.
pub const MAX_LIGHTS: usize = 1024;

/// A light as a homogeneous point `(x, y, z, w)`, in the space of the positions. For outlines the camera's eye is the
/// light.
///
/// * `w = 1`: a point light at `(x, y, z)`.
/// * `w = 0`: a direction **towards** a light at infinity.
/// * Any other finite `w`: a point light at `(x, y, z) / w`.
///
/// A face `(a, b, c)` faces the light when `det[b − a, c − a, l − w·a] > 0`, for every finite `w`. So `w < 0` reverses
/// the sides. Scenes, shadow queries and the search for occluded faces refuse such a light.
///
/// Extraction uses the components as given. It never normalises or divides them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Homogeneous x, y and z.
    pub xyz: [f32; 3],
    /// The homogeneous weight.
    pub w: f32,
    /// How far the light reaches, in world space: a positive number, which every constructor sets to infinity, no
    /// limit. A caster farther away throws no shadow volume (Bergeron's sphere of influence, 1986); see also
    /// [`crate::gpu::SceneOptions::end_at_range`]. It changes no facing or silhouette bit. It has no meaning where `w`
    /// is 0.
    pub range: f32,
    /// The cone of a spot light, whose apex is the light, in world space. Nothing outside of it is lit, so a caster outside
    /// throws no shadow volume in a scene. It changes no facing or silhouette bit. It has no meaning where `w` is 0.
    pub cone: Option<Cone>,
}

/// The cone of a spot light, for [`Light::cone`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Where the light points, in world space, at any length above 0.
    pub axis: [f32; 3],
    /// The cosine of half the cone's angle, from the axis to where nothing is lit: −1 to 1. An angle of more than 90° has a
    /// negative cosine.
    pub cosine: f32,
}

impl Cone {
    /// A cone about `axis` of this half angle, in radians, clamped to 0 to π. The cosine is rounded so that the cone has the
    /// whole angle.
    /// An angle that is NaN gives a cosine that is NaN, and lights with it are refused.
    pub fn new(axis: [f32; 3], half_angle: f32) -> Self {
        let half_angle = f64::from(half_angle).clamp(0.0, std::f64::consts::PI);
        Self { axis, cosine: (half_angle.cos() as f32).next_down().clamp(-1.0, 1.0) }
    }
}

impl Light {
    /// A light at the point `xyz`, in the unit and space of the positions.
    pub const fn point(xyz: [f32; 3]) -> Self {
        Self { xyz, w: 1.0, range: f32::INFINITY, cone: None }
    }

    /// A light at infinity. `towards` points from the scene to the light and may have any length above 0.
    pub const fn directional(towards: [f32; 3]) -> Self {
        Self { xyz: towards, w: 0.0, range: f32::INFINITY, cone: None }
    }

    /// A light as a homogeneous point `(x, y, z, w)`.
    pub const fn homogeneous(xyzw: [f32; 4]) -> Self {
        let [x, y, z, w] = xyzw;
        Self { xyz: [x, y, z], w, range: f32::INFINITY, cone: None }
    }

    /// This light with another [range](Self::range).
    #[must_use]
    pub const fn with_range(self, range: f32) -> Self {
        Self { range, ..self }
    }

    /// This light with a [cone](Self::cone).
    #[must_use]
    pub const fn with_cone(self, cone: Cone) -> Self {
        Self { cone: Some(cone), ..self }
    }

    /// The four components `(x, y, z, w)`.
    pub const fn to_array(self) -> [f32; 4] {
        let [x, y, z] = self.xyz;
        [x, y, z, self.w]
    }

    /// Moves this light from world space into the space of a mesh. `mesh_to_world` transforms the mesh to world space: four
    /// columns of three rows, and the last column is the translation.
    ///
    /// With it a rigid instance can keep its positions in mesh space. The facing bits equal those of world space, but for
    /// rounding: the light's components are computed in `f64` and rounded once to `f32`. If the transform mirrors, keep the
    /// winding of the faces, too. Range and cone stay as they are, in world space.
    ///
    /// Returns `None` when the transform's determinant is 0 or not finite, or a component of the result is not finite. Such
    /// an instance casts nothing.
    pub fn to_mesh_space(self, mesh_to_world: &[[f64; 3]; 4]) -> Option<Self> {
        MeshSpace::new(DAffine3::from_cols_array_2d(mesh_to_world))?.light(self)
    }
}

/// The mesh space of a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshSpace {
    pub(crate) inverse: DMat3,
    translation: DVec3,
}

impl MeshSpace {
    /// `None` if the determinant is 0 or not finite.
    pub(crate) fn new(mesh_to_world: DAffine3) -> Option<Self> {
        let determinant = mesh_to_world.matrix3.determinant();
        let is_regular = determinant != 0.0 && determinant.is_finite();
        is_regular.then(|| Self { inverse: mesh_to_world.matrix3.inverse(), translation: mesh_to_world.translation })
    }

    /// A light of world space. `None` if a component is not finite.
    pub(crate) fn light(&self, light: Light) -> Option<Light> {
        let [x, y, z] = light.xyz.map(f64::from);
        let from_origin = DVec3::new(x, y, z) - f64::from(light.w) * self.translation;
        let xyz = (self.inverse * from_origin).as_vec3().to_array();
        xyz.iter().all(|c| c.is_finite()).then_some(Light { xyz, ..light })
    }
}

/// Why a list of lights is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum LightError {
    /// The requested room is 0 lights.
    #[error("`max_lights` is 0; make room for at least one light")]
    NoRoom,
    /// There are more lights than [`MAX_LIGHTS`], or more than the extractor has room for.
    #[error(
        "{count} lights given, at most {limit} fit; {}",
        if *.limit < MAX_LIGHTS { "raise `max_lights`" } else { "split them over several extractions" }
    )]
    TooMany { count: usize, limit: usize },
    /// All four components are zero, which is no point.
    #[error("light {index} is (0, 0, 0, 0), which is neither a point nor a direction")]
    Zero { index: usize },
    /// A component is infinite or NaN.
    #[error("light {index} is ({}, {}, {}, {}), and every component must be finite", .xyzw[0], .xyzw[1], .xyzw[2], .xyzw[3])]
    NotFinite { index: usize, xyzw: [f32; 4] },
    /// The range is NaN, or not above 0.
    #[error("light {index} has the range {range}; it must be positive, or infinite for no limit")]
    Range { index: usize, range: f32 },
    /// The axis of a cone has no direction, or its cosine is not in −1 to 1.
    #[error(
        "light {index} has a cone about ({}, {}, {}) of cosine {cosine}; the axis must be finite and not zero, and the cosine \
         -1 to 1",
        .axis[0], .axis[1], .axis[2]
    )]
    Cone { index: usize, axis: [f32; 3], cosine: f32 },
    /// The weight is negative, and shadows refuse it.
    #[error(
        "light {index} has w = {w}, and a negative w reverses its sides, which shadows have no use for; negate all four \
         components"
    )]
    NegativeWeight { index: usize, w: f32 },
}

/// Checks a list of lights: at most `limit` of them, all finite, none all zeros, ranges positive, cones with a direction.
/// Extraction refuses the same; a tool may check what it read before any work.
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
        if let Some(Cone { axis, cosine }) = light.cone
            && (axis.iter().any(|c| !c.is_finite()) || axis == [0.0; 3] || !(-1.0..=1.0).contains(&cosine))
        {
            return Err(LightError::Cone { index, axis, cosine });
        }
    }
    Ok(())
}

/// Checks a list of lights for shadows: as [`check_lights`], and none with a negative weight. Scenes and queries refuse the
/// same.
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

/// Checks the number of lights that room is requested for: 1 to [`MAX_LIGHTS`].
#[cfg(feature = "gpu")]
pub(crate) fn check_room(max_lights: usize) -> Result<(), LightError> {
    match max_lights {
        0 => Err(LightError::NoRoom),
        count if count > MAX_LIGHTS => Err(LightError::TooMany { count, limit: MAX_LIGHTS }),
        _ => Ok(()),
    }
}

/// The number of batches that `lights` lights take: ⌈lights / 32⌉.
pub(crate) const fn batches(lights: usize) -> usize {
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

    #[test]
    fn cones_are_checked() {
        let check = |axis, cosine| check_lights(&[Light::point([0.0; 3]).with_cone(Cone { axis, cosine })], 1);
        let down = [0.0, -2.0, 0.0];
        for cosine in [-1.0, 0.0, -0.0, 0.5, 1.0] {
            assert_eq!(check(down, cosine), Ok(()));
        }
        assert_eq!(check([0.0, 1e-45, 0.0], 0.5), Ok(()));
        for (axis, cosine) in
            [([0.0; 3], 0.5), ([0.0, -0.0, 0.0], 0.5), ([f32::INFINITY, 0.0, 0.0], 0.5), (down, 1.5), (down, -1.1)]
        {
            assert_eq!(check(axis, cosine), Err(LightError::Cone { index: 0, axis, cosine }));
        }
        assert!(matches!(check(down, f32::NAN), Err(LightError::Cone { .. })));
        for (half_angle, cosine) in [(0.0, 1.0), (1.0, 0.540_302_3), (std::f32::consts::PI, -1.0), (9.0, -1.0)] {
            let found = Cone::new(down, half_angle).cosine;
            assert!(found <= cosine && found > cosine - 2e-7, "{half_angle}: {found}");
        }
        assert!(matches!(check(down, Cone::new(down, f32::NAN).cosine), Err(LightError::Cone { .. })));
    }

    #[test]
    fn room_is_for_one_light_to_the_most() {
        for (count, expected) in [
            (0, Err(LightError::NoRoom)),
            (1, Ok(())),
            (MAX_LIGHTS, Ok(())),
            (MAX_LIGHTS + 1, Err(LightError::TooMany { count: MAX_LIGHTS + 1, limit: MAX_LIGHTS })),
        ] {
            assert_eq!(check_room(count), expected);
        }
    }

    #[test]
    fn transforms_without_an_inverse_give_no_light() {
        let scale = |[x, y, z]: [f64; 3]| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], [0.0; 3]];
        let light = Light::point([1.0, 2.0, 4.0]);
        let halved = light.to_mesh_space(&scale([2.0; 3])).expect("a scale has an inverse");
        assert_eq!(halved.to_array(), [0.5, 1.0, 2.0, 1.0]);
        // The determinant is 0, infinite, or not a number.
        for singular in [[1.0, 0.0, 1.0], [1e200, 1e200, 1.0], [f64::NAN, 1.0, 1.0]] {
            assert_eq!(light.to_mesh_space(&scale(singular)), None);
        }
    }
}
