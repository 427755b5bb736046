//! The levels of skipping, and which of them a measurement has on.

use rimline::gpu::{Measuring, SceneOptions};

/// A level of skipping: its name in the data, its name for people, and the work that is done without it.
type Level = (&'static str, &'static str, &'static [Measuring]);

/// All levels that have a switch. Clusters have an option of their own.
pub(super) const LEVELS: [Level; 7] = [
    ("light-reach", "light reach", &[Measuring::CULLED_BY_RANGE]),
    ("shadow-reach", "shadow reach", &[Measuring::CULLED_BY_VIEW]),
    ("nothing-moved", "nothing moved", &[Measuring::CACHED_BITS, Measuring::CACHED_LISTS]),
    (CLUSTERS, "clusters", &[]),
    ("hidden-receivers", "hidden receivers", &[Measuring::CULLED_BY_RECEIVERS]),
    ("unneeded-figures", "unneeded figures", &[Measuring::CULLED_CASTERS]),
    (OCCLUDERS, "occluders", &[Measuring::CULLED_BY_OCCLUDERS]),
];
pub(super) const CLUSTERS: &str = "clusters";
pub(super) const OCCLUDERS: &str = "occluders";

/// A choice of levels.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    /// Names in the data, and for people.
    pub(super) id: String,
    pub(super) name: String,
    /// The level that is off alone, or none.
    pub(super) without: Option<&'static str>,
    is_on: [bool; LEVELS.len()],
}

impl Choice {
    /// All off, all on, and each level off with the others on.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let whole = |id: &str, name: &str, is_on| Self {
            id: id.to_owned(),
            name: name.to_owned(),
            without: None,
            is_on: [is_on; LEVELS.len()],
        };
        let without = LEVELS.into_iter().enumerate().map(|(number, (id, name, _))| Self {
            id: format!("without-{id}"),
            name: format!("all but: {name}"),
            without: Some(id),
            is_on: std::array::from_fn(|level| level != number),
        });
        [whole("all-off", "all levels off", false), whole("all-on", "all levels on", true)].into_iter().chain(without)
    }

    /// Options of a scene with so many lights.
    pub(super) fn options(&self, max_lights: usize) -> SceneOptions {
        let mut options = SceneOptions { max_lights, ..SceneOptions::default() };
        for ((id, _, bits), is_on) in LEVELS.iter().zip(self.is_on) {
            bits.iter().for_each(|bit| options.measuring.set(*bit, !is_on));
            if *id == CLUSTERS && !is_on {
                options.clusters_from = None;
            }
        }
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_level_is_off_alone_once() {
        let all: Vec<Choice> = Choice::all().collect();
        assert_eq!(all.len(), LEVELS.len() + 2);
        let of = |choice: &Choice| format!("{:?}", choice.options(5));
        let mut different: Vec<String> = all.iter().map(of).collect();
        different.sort();
        different.dedup();
        // A switch that changes nothing is none.
        assert_eq!(different.len(), all.len());
        let defaults = SceneOptions { max_lights: 5, ..SceneOptions::default() };
        assert_eq!(of(&all[1]), format!("{defaults:?}"));
        for (choice, (id, ..)) in all[2..].iter().zip(LEVELS) {
            assert_eq!((choice.is_on.iter().filter(|is_on| !**is_on).count(), choice.without), (1, Some(id)));
        }
    }
}
