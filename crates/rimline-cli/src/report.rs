//! Parts that the reports of `extract`, `query` and `shadow` share.

use std::fmt::{Display, Write as _};

use rimline::Origin;
use serde_json::Value;

use crate::coordinates::{add_origin, origin_text};
use crate::times::Times;

/// Lines of a name and a value, for people.
#[derive(Default)]
pub(crate) struct Lines(pub(crate) String);

impl Lines {
    pub(crate) fn line(&mut self, name: &str, value: impl Display) {
        let _ = writeln!(self.0, "{name:<18} {value}");
    }

    pub(crate) fn origin(&mut self, origin: Origin) {
        if let Some(origin) = origin_text(origin) {
            self.line("origin", origin);
        }
    }

    pub(crate) fn times(&mut self, times: &Times) {
        self.line("milliseconds", times.sums());
        self.line("by stage", times.text());
    }
}

/// A report for programs, with the keys that all have. Keys are stable: they are only ever added to.
pub(crate) fn json(mut report: Value, origin: Origin, times: &Times) -> String {
    let [set_up, work] = times.set_up_and_work();
    report["milliseconds"] = times.json().into();
    report["set_up_milliseconds"] = set_up.into();
    report["work_milliseconds"] = work.into();
    add_origin(&mut report, origin);
    format!("{report:#}\n")
}

/// A number a light; many lights are summed up.
pub(crate) fn per_light(counts: &[usize]) -> String {
    let (shown, more) = first_lights(counts);
    if more { format!("{shown}, … ({} for {} lights)", counts.iter().sum::<usize>(), counts.len()) } else { shown }
}

/// The numbers of the first lights, and whether there are more.
pub(crate) fn first_lights(counts: &[usize]) -> (String, bool) {
    const SHOWN: usize = 8;
    let shown: Vec<String> = counts.iter().take(SHOWN).map(usize::to_string).collect();
    (shown.join(", "), counts.len() > SHOWN)
}
