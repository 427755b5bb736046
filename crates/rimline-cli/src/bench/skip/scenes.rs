//! The scenes of skipping by name.

use rimline::ModelError;

use super::crowd::View;
use super::levels::Variant;
use super::setting::Setting;
use super::{big, city, crowd, moving, still};

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
            Self::Big(_) => "big",
        }
    }

    /// Name of the view in the data.
    pub(crate) fn view(self) -> &'static str {
        match self {
            Self::Still | Self::Crowd | Self::Moving | Self::Big(_) => "whole",
            Self::CityAlong => "along-street",
            Self::CityOblique => "oblique",
            Self::CrowdWithin => "within",
        }
    }

    /// `still, 1,000 figures`.
    pub(crate) fn title(self, casters: usize) -> String {
        let number = super::super::grouped::grouped(casters);
        let s = if casters == 1 { "" } else { "s" };
        match self {
            Self::Still => format!("still, {number} figure{s}"),
            Self::CityAlong => format!("city, {number} building{s}, along a street"),
            Self::CityOblique => format!("city, {number} building{s}, obliquely"),
            Self::Crowd => format!("crowd, {number} walking figure{s}"),
            Self::CrowdWithin => format!("crowd, {number} walking figure{s}, from within"),
            Self::Moving => format!("moving, {number} caster{s} of which all matters"),
            Self::Big(size) => {
                format!("big, a mesh of {} faces", super::super::grouped::grouped(big_faces(size)))
            }
        }
    }

    /// The usual number of casters, of a quick run and of a whole one.
    pub(crate) fn usual(self, is_quick: bool) -> usize {
        match (self, is_quick) {
            (Self::Big(_), _) => 1,
            (Self::Moving, false) => 200,
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
            Self::CityAlong | Self::CityOblique => usize::MAX,
            Self::Big(_) => 1,
        }
    }

    pub(super) fn setting(self, casters: usize) -> Result<Setting, ModelError> {
        match self {
            Self::Still => Ok(still::setting(casters)),
            Self::CityAlong => Ok(city::setting(casters, city::ALONG)),
            Self::CityOblique => Ok(city::setting(casters, city::OBLIQUE)),
            Self::Crowd => crowd::setting(casters, View::Whole),
            Self::CrowdWithin => crowd::setting(casters, View::Within),
            Self::Moving => Ok(moving::setting(casters)),
            Self::Big(size) => Ok(big::setting(big_faces(size))),
        }
    }
}

/// About so many faces has the mesh of [`SkipScene::Big`].
fn big_faces(size: u16) -> usize {
    usize::from(size) << 16
}
