//! The scenes of skipping by name.

use glam::Vec3;
use rimline::{Light, ModelError};

use super::crowd::View;
use super::levels::Variant;
use super::{city, crowd, house};
use crate::casters::{CasterMesh, field};
use crate::record::{Camera, IDENTITY, Setting};
use crate::shapes;
use crate::text::grouped;

/// The scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SkipScene {
    /// Figures among which nothing moves.
    Still,
    /// Buildings, seen along a street.
    CityAlong,
    /// The same, seen across the streets.
    CityOblique,
    /// Skinned figures that walk, seen as a whole.
    Crowd,
    /// The same, seen by one of them.
    CrowdWithin,
    /// Casters that all move, of which all matters.
    Moving,
    /// Rooms with a lamp and figures in each, and walls between them.
    House,
    /// One mesh of about so many times 65,536 faces.
    Big(u16),
}

impl SkipScene {
    /// The scenes of a name on the command line.
    pub(crate) fn named(name: &str, is_quick: bool) -> Option<&'static [Self]> {
        match name {
            "big" if is_quick => Some(&[Self::Big(1)]),
            "still" => Some(&[Self::Still]),
            "city" => Some(&[Self::CityAlong, Self::CityOblique]),
            "crowd" => Some(&[Self::Crowd, Self::CrowdWithin]),
            "moving" => Some(&[Self::Moving]),
            "house" => Some(&[Self::House]),
            "big" => Some(&[Self::Big(16), Self::Big(64), Self::Big(168), Self::Big(256)]),
            _ => None,
        }
    }

    /// Name on the command line and in the data.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::CityAlong | Self::CityOblique => "city",
            Self::Crowd | Self::CrowdWithin => "crowd",
            Self::Moving => "moving",
            Self::House => "house",
            Self::Big(_) => "big",
        }
    }

    /// Name of the view in the data.
    pub(crate) fn view(self) -> &'static str {
        match self {
            Self::Still | Self::Crowd | Self::Moving | Self::Big(_) => "whole",
            Self::CityAlong => "along-street",
            Self::CityOblique => "oblique",
            Self::CrowdWithin | Self::House => "within",
        }
    }

    /// `still, 1,000 figures`.
    pub(crate) fn title(self, casters: usize) -> String {
        let number = grouped(casters);
        let s = if casters == 1 { "" } else { "s" };
        match self {
            Self::Still => format!("still, {number} figure{s}"),
            Self::CityAlong => format!("city, {number} building{s}, along a street"),
            Self::CityOblique => format!("city, {number} building{s}, obliquely"),
            Self::Crowd => format!("crowd, {number} walking figure{s}"),
            Self::CrowdWithin => format!("crowd, {number} walking figure{s}, from within"),
            Self::Moving => format!("moving, {number} caster{s} of which all matters"),
            Self::House => format!("house, {number} figure{s} in rooms"),
            Self::Big(size) => {
                format!("big, a mesh of {} faces", grouped(big_faces(size)))
            }
        }
    }

    /// The usual number of casters, of a quick run and of a whole one.
    pub(crate) fn usual(self, is_quick: bool) -> usize {
        match (self, is_quick) {
            (Self::Big(_), _) => 1,
            (Self::Moving, false) => 200,
            (Self::House, is_quick) => {
                if is_quick {
                    20
                } else {
                    100
                }
            }
            (Self::Still | Self::Crowd | Self::CrowdWithin | Self::Moving, true) => 20,
            (Self::Still | Self::Crowd | Self::CrowdWithin, false) => 1000,
            (_, true) => 100,
            (_, false) => 10_000,
        }
    }

    /// The choices of levels that are measured. Meshes of many faces take long to prepare, and only clusters matter to them.
    pub(super) fn variants(self) -> Vec<Variant> {
        let is_big = matches!(self, Self::Big(_));
        let matters = |variant: &Variant| match variant {
            Variant::Without(level) if level.id == "occluders" => self == Self::House,
            Variant::Without(level) => !is_big || level.id == "clusters",
            Variant::AllOff | Variant::AllOn => true,
        };
        Variant::all().filter(matters).collect()
    }

    /// Whether it always has one caster.
    pub(crate) fn is_one_mesh(self) -> bool {
        matches!(self, Self::Big(_))
    }

    /// The most casters that it is measured with.
    pub(crate) fn most(self) -> usize {
        match self {
            Self::Still | Self::Crowd | Self::CrowdWithin | Self::Moving => 1000,
            Self::House => house::MOST,
            Self::CityAlong | Self::CityOblique => usize::MAX,
            Self::Big(_) => 1,
        }
    }

    pub(super) fn setting(self, casters: usize) -> Result<Setting, ModelError> {
        match self {
            Self::Still => Ok(field(CasterMesh::Character.shape(), casters)),
            Self::CityAlong => Ok(city::setting(casters, city::ALONG)),
            Self::CityOblique => Ok(city::setting(casters, city::OBLIQUE)),
            Self::Crowd => crowd::setting(casters, View::Whole),
            Self::CrowdWithin => crowd::setting(casters, View::Within),
            Self::Moving => Ok(moving(casters)),
            Self::House => Ok(house::setting(casters)),
            Self::Big(size) => Ok(big(big_faces(size))),
        }
    }
}

/// About so many faces has the mesh of [`SkipScene::Big`].
fn big_faces(size: u16) -> usize {
    usize::from(size) << 16
}

/// A sphere of radius 1 with at least so many faces, but for rounding, and a light that circles above it.
fn big(faces: usize) -> Setting {
    let shape = shapes::sphere((faces as f64 / 8.0).sqrt().round() as u32);
    // So high that the eye is never in shadow.
    let lights = vec![Light::point([0.0, 5.0, -3.0])];
    let camera = Camera::level(Vec3::new(0.0, 0.0, 3.5), Vec3::NEG_Z, 2.0, 0.1);
    Setting { turn: 0.05, ..Setting::rigid(vec![shape], vec![(0, IDENTITY)], lights, &camera) }
}

/// From a caster of [`moving`] to the next, in units of which a caster is 3 wide.
const PITCH: f32 = 6.0;

/// Casters on the ground that all move, under lights that reach them all, before an eye that sees all shadows: what skipping
/// costs where it spares nothing.
fn moving(casters: usize) -> Setting {
    // 4,000 faces, and 5,780, which are in clusters.
    let shapes = vec![CasterMesh::Character.shape(), shapes::blob(27, 0.4, 3)];
    let columns = (casters as f32).sqrt().ceil().max(1.0) as usize;
    let rows = casters.div_ceil(columns);
    let line = |index: usize, count: usize| PITCH * (index as f32 - 0.5 * (count - 1) as f32);
    let placed = (0..casters).map(|number| {
        let [x, z] = [line(number % columns, columns), line(number / columns, rows)];
        (number % 2, [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, z]])
    });
    let lights = [[0.2, 1.0, 0.3], [-0.3, 1.0, 0.1], [0.1, 1.0, -0.3], [-0.2, 1.0, -0.2], [0.0, 1.0, 0.1]];
    let lights = lights.map(Light::directional).into();
    let width = PITCH * columns as f32;
    let eye = Vec3::new(0.0, width + 6.0, 0.3 * width + 2.0);
    let setting = Setting::rigid(shapes, placed.collect(), lights, &Camera::level(eye, -eye, 1.4, 0.1));
    Setting { ground: Some(0.0), drift: 0.01, ..setting }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sphere_has_about_as_many_faces_as_asked() {
        for faces in [1 << 16, 100_000, 1 << 20] {
            let found = big(faces).casters.faces();
            assert!(found.abs_diff(faces) < faces / 20, "{found} for {faces}");
        }
    }
}
