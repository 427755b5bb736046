//! The levels of skipping, and which of them a measurement has on.

use rimline::gpu::{Measuring, SceneOptions};

/// A level of skipping, with its switch.
#[derive(Debug)]
pub(crate) struct Level {
    /// Name in the data.
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    switch: fn(&mut SceneOptions, bool),
}

/// All levels that have a switch.
pub(crate) static LEVELS: &[Level] = &[
    Level {
        id: "light-reach",
        name: "light reach",
        switch: |options, on| options.measuring.set(Measuring::CULLED_BY_RANGE, !on),
    },
    Level {
        id: "shadow-reach",
        name: "shadow reach",
        switch: |options, on| options.measuring.set(Measuring::CULLED_BY_VIEW, !on),
    },
    Level {
        id: "nothing-moved",
        name: "nothing moved",
        switch: |options, on| {
            options.measuring.set(Measuring::CACHED_BITS, !on);
            options.measuring.set(Measuring::CACHED_LISTS, !on);
        },
    },
    Level {
        id: "clusters",
        name: "clusters",
        switch: |options, on| options.clusters_from = SceneOptions::default().clusters_from.filter(|_| on),
    },
    Level {
        id: "hidden-receivers",
        name: "hidden receivers",
        switch: |options, on| options.measuring.set(Measuring::CULLED_BY_RECEIVERS, !on),
    },
    Level {
        id: "unneeded-figures",
        name: "unneeded figures",
        switch: |options, on| options.measuring.set(Measuring::CULLED_CASTERS, !on),
    },
    Level {
        id: "occluders",
        name: "occluders",
        switch: |options, on| options.measuring.set(Measuring::CULLED_BY_OCCLUDERS, !on),
    },
];

/// Which levels are on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Variant {
    AllOff,
    AllOn,
    /// All but this one.
    Without(&'static Level),
}

impl Variant {
    /// All off, all on, and each level off with the others on.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        [Self::AllOff, Self::AllOn].into_iter().chain(LEVELS.iter().map(Self::Without))
    }

    /// Name in the data.
    pub(crate) fn id(self) -> String {
        match self {
            Self::AllOff => "all-off".to_owned(),
            Self::AllOn => "all-on".to_owned(),
            Self::Without(level) => format!("without-{}", level.id),
        }
    }

    pub(crate) fn name(self) -> String {
        match self {
            Self::AllOff => "all levels off".to_owned(),
            Self::AllOn => "all levels on".to_owned(),
            Self::Without(level) => format!("all but: {}", level.name),
        }
    }

    /// Options of a scene with so many lights.
    pub(crate) fn options(self, max_lights: usize) -> SceneOptions {
        let mut options = SceneOptions { max_lights, ..SceneOptions::default() };
        for level in LEVELS {
            let is_on = match self {
                Self::AllOff => false,
                Self::AllOn => true,
                Self::Without(other) => level.id != other.id,
            };
            (level.switch)(&mut options, is_on);
        }
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The switches as options have them, all other options left out.
    fn switches(variant: Variant) -> Vec<bool> {
        let options = format!("{:?}", variant.options(5));
        let is_on = |level: &Level| {
            // A switch that changes nothing is none.
            let [on, off] = [true, false].map(|on| {
                let mut options = variant.options(5);
                (level.switch)(&mut options, on);
                format!("{options:?}")
            });
            assert_ne!(on, off, "{}", level.id);
            options == on
        };
        LEVELS.iter().map(is_on).collect()
    }

    #[test]
    fn each_level_is_off_alone_once() {
        let all: Vec<Vec<bool>> = Variant::all().map(switches).collect();
        assert_eq!(all[0], vec![false; LEVELS.len()]);
        assert_eq!(all[1], vec![true; LEVELS.len()]);
        for (number, switches) in all[2..].iter().enumerate() {
            let expected: Vec<bool> = (0..LEVELS.len()).map(|level| level != number).collect();
            assert_eq!(*switches, expected);
        }
        let mut ids: Vec<String> = Variant::all().map(Variant::id).collect();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), LEVELS.len() + 2);
    }
}
