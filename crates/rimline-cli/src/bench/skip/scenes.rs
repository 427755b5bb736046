//! The scenes of skipping by name.

use rimline::ModelError;

use super::crowd::View;
use super::setting::Setting;
use super::{city, crowd, still};

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
}

impl SkipScene {
    /// The scenes of a name on the command line.
    pub(crate) fn named(name: &str) -> Option<&'static [Self]> {
        match name {
            "still" => Some(&[Self::Still]),
            "city" => Some(&[Self::CityAlong, Self::CityOblique]),
            "crowd" => Some(&[Self::Crowd, Self::CrowdWithin]),
            _ => None,
        }
    }

    /// What the command line and the data call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::CityAlong | Self::CityOblique => "city",
            Self::Crowd | Self::CrowdWithin => "crowd",
        }
    }

    /// What the data call the view.
    pub(crate) fn view(self) -> &'static str {
        match self {
            Self::Still | Self::Crowd => "whole",
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
        }
    }

    /// The usual number of casters, of a quick run and of a whole one.
    pub(crate) fn usual(self, is_quick: bool) -> usize {
        match (self, is_quick) {
            (Self::Still | Self::Crowd | Self::CrowdWithin, true) => 20,
            (Self::Still | Self::Crowd | Self::CrowdWithin, false) => 1000,
            (_, true) => 100,
            (_, false) => 10_000,
        }
    }

    /// The most casters that it is measured with.
    pub(crate) fn most(self) -> usize {
        match self {
            Self::Still | Self::Crowd | Self::CrowdWithin => 1000,
            _ => usize::MAX,
        }
    }

    pub(super) fn setting(self, casters: usize) -> Result<Setting, ModelError> {
        match self {
            Self::Still => Ok(still::setting(casters)),
            Self::CityAlong => Ok(city::setting(casters, city::ALONG)),
            Self::CityOblique => Ok(city::setting(casters, city::OBLIQUE)),
            Self::Crowd => crowd::setting(casters, View::Whole),
            Self::CrowdWithin => crowd::setting(casters, View::Within),
        }
    }
}
