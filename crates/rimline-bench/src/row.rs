//! The one form of results: a scene, its variants, and of each variant the values of its metrics, round by round.

use serde_json::{Value, json};

use crate::engine::{Contender, Metric, Rounds, Sample, Summary, interleave};
use crate::{Error, Host};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    Extraction,
    Shadows,
    Casters,
    /// A scene of one caster against an extractor.
    OneMesh,
    Skipping,
    DepthMaps,
}

impl Section {
    pub fn id(self) -> &'static str {
        match self {
            Self::Extraction => "extraction",
            Self::Shadows => "shadows",
            Self::Casters => "casters",
            Self::OneMesh => "one-mesh",
            Self::Skipping => "skipping",
            Self::DepthMaps => "depth-maps",
        }
    }

    /// The variants with which all others are compared.
    pub(crate) fn compared_to(self) -> &'static [&'static str] {
        match self {
            Self::Extraction => &["gpu-per-edge-plane", "gpu-mask-local", "cpu-f32-one", "cpu-f32-all"],
            Self::Shadows => &["z-pass"],
            Self::Casters => &["merged"],
            Self::OneMesh => &["extractor"],
            Self::Skipping => &["all-on"],
            Self::DepthMaps => &["lookup"],
        }
    }
}

/// The mark of a series in a chart: indices of its colour and shape, and whether it is hollow, as those of the CPU are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    pub colour: usize,
    pub shape: usize,
    pub hollow: bool,
}

#[derive(Clone, Debug)]
pub struct Variant {
    pub id: String,
    pub name: String,
    pub mark: Mark,
}

impl Variant {
    pub fn new(id: &str, name: &str, colour: usize, shape: usize) -> Self {
        Self { id: id.to_owned(), name: name.to_owned(), mark: Mark { colour, shape, hollow: false } }
    }
}

/// A variant of a bench that prints a table.
impl From<&str> for Variant {
    fn from(name: &str) -> Self {
        Self::new(name, name, 6, 4)
    }
}

/// Runs variants in turn, by [`interleave`].
pub fn compare<V: Into<Variant>>(
    rounds: Rounds,
    contenders: Vec<(V, Contender<'_>)>,
    host: &dyn Host,
) -> Result<Vec<Entry>, Error> {
    let (variants, contenders): (Vec<_>, Vec<_>) = contenders.into_iter().unzip();
    let samples = interleave(rounds, contenders, host)?;
    Ok(variants.into_iter().zip(samples).map(|(variant, samples)| Entry::new(variant.into(), &samples)).collect())
}

#[derive(Clone, Debug)]
pub struct Entry {
    pub variant: Variant,
    pub(crate) metrics: Vec<(Metric, Vec<f64>)>,
}

impl Entry {
    /// The metrics of some rounds. A stage that did not run in a round took no time there.
    pub fn new(variant: Variant, samples: &[Sample]) -> Self {
        let mut entry = Self { variant, metrics: Vec::new() };
        for &(metric, _) in samples.iter().flatten() {
            if entry.metrics.iter().any(|(known, _)| *known == metric) {
                continue;
            }
            let of = |sample: &Sample| {
                let mut found = sample.iter().filter(|(other, _)| *other == metric).map(|(_, value)| *value).peekable();
                let is_there = found.peek().is_some() || matches!(metric, Metric::Stage(_));
                is_there.then(|| found.sum())
            };
            entry.metrics.push((metric, samples.iter().filter_map(of).collect()));
        }
        entry
    }

    #[must_use]
    pub fn with(mut self, metric: Metric, values: impl IntoIterator<Item = f64>) -> Self {
        self.metrics.push((metric, values.into_iter().collect()));
        self
    }

    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        self.metrics.extend(other.metrics.iter().cloned());
        self
    }

    #[must_use]
    pub fn with_count(self, name: &'static str, count: usize) -> Self {
        self.with(Metric::Count(name), [count as f64])
    }

    /// Values round by round, of wrong pixels frame by frame; none if it was not measured.
    pub fn values(&self, metric: Metric) -> &[f64] {
        self.metrics.iter().find(|(known, _)| *known == metric).map_or(&[], |(_, values)| values)
    }

    pub fn summary(&self, metric: Metric) -> Option<Summary> {
        Summary::of(self.values(metric).iter().copied())
    }

    pub fn median(&self, metric: Metric) -> Option<f64> {
        self.summary(metric).map(|summary| summary.median)
    }

    /// The median time of a whole, not a number if it was not measured.
    pub fn ms(&self, whole: &'static str) -> f64 {
        self.median(Metric::Time(whole)).unwrap_or(f64::NAN)
    }

    /// The sum of a count over all rounds, or all frames.
    pub fn count(&self, name: &'static str) -> f64 {
        self.values(Metric::Count(name)).iter().sum()
    }
}

#[derive(Clone, Debug)]
pub struct Row {
    pub section: Section,
    pub scene: String,
    pub title: String,
    /// Scenes of one kind.
    pub group: String,
    pub facts: Vec<(&'static str, Value)>,
    pub entries: Vec<Entry>,
}

impl Row {
    pub fn fact(&self, name: &str) -> Option<&Value> {
        self.facts.iter().find(|(known, _)| *known == name).map(|(_, value)| value)
    }

    /// A fact that is a number; 0 if it is none.
    pub fn number(&self, name: &str) -> f64 {
        self.fact(name).and_then(Value::as_f64).unwrap_or(0.0)
    }

    pub fn lights(&self) -> usize {
        self.number("lights") as usize
    }

    pub fn faces(&self) -> usize {
        self.number("faces") as usize
    }

    pub fn entry(&self, id: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.variant.id == id)
    }

    pub fn summary(&self, id: &str, metric: Metric) -> Option<Summary> {
        self.entry(id)?.summary(metric)
    }

    /// A metric of one variant divided by that of another, round by round. Both have it in the same rounds.
    pub fn ratio(&self, metric: Metric, id: &str, to: &str) -> Option<Summary> {
        let [values, others] = [self.entry(id)?, self.entry(to)?].map(|entry| entry.values(metric));
        Summary::of(values.iter().zip(others).map(|(value, other)| value / other).filter(|ratio| ratio.is_finite()))
    }

    pub(crate) fn json(&self) -> Value {
        let mut row =
            json!({ "section": self.section.id(), "scene": self.scene, "title": self.title, "group": self.group });
        for (name, value) in &self.facts {
            row[*name] = value.clone();
        }
        row["variants"] = self.entries.iter().map(|entry| self.entry_json(entry)).collect();
        row
    }

    fn entry_json(&self, entry: &Entry) -> Value {
        let Variant { id, name, .. } = &entry.variant;
        let mut found = json!({ "variant": id, "name": name, "times": {}, "stages": {}, "counts": {}, "ratios": [] });
        for (metric, values) in &entry.metrics {
            match metric {
                Metric::Time(name) if values.is_empty() => found["times"][name] = Value::Null,
                Metric::Time(name) => {
                    found["times"][name] = summary_json(entry.summary(*metric));
                    found["times"][name]["rounds"] = json!(values);
                    let ratios = self.section.compared_to().iter().filter(|to| *to != id).filter_map(|to| {
                        let mut ratio = summary_json(Some(self.ratio(*metric, id, to)?));
                        ratio["to"] = (*to).into();
                        ratio["time"] = (*name).into();
                        Some(ratio)
                    });
                    found["ratios"].as_array_mut().into_iter().for_each(|all| all.extend(ratios.clone()));
                }
                Metric::Stage(name) => found["stages"][name] = summary_json(entry.summary(*metric)),
                // A single count is a whole number in the data.
                Metric::Count(name) => {
                    found["counts"][name] = if let [one] = values[..] { json!(one as u64) } else { json!(values) };
                }
            }
        }
        found
    }
}

/// Null if there is none.
pub(crate) fn summary_json(summary: Option<Summary>) -> Value {
    let json = |Summary { median, quartiles: [q1, q3], range: [low, high], count }| json!({ "median": median, "q1": q1, "q3": q3, "low": low, "high": high, "runs": count });
    summary.map_or(Value::Null, json)
}

/// 1048576 as `1,048,576`.
pub(crate) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_rounds_and_a_stage_that_did_not_run_took_no_time() {
        let (time, stage) = (Metric::Time("frame"), Metric::Stage("facing"));
        let entry = |id: &str, times: [f64; 3]| {
            let sample =
                |ms: f64| if ms > 5.0 { vec![(time, ms)] } else { vec![(time, ms), (stage, ms), (stage, 1.0)] };
            Entry::new(Variant::new(id, id, 0, 0), &times.map(sample))
        };
        let row = Row {
            section: Section::Shadows,
            scene: String::new(),
            title: String::new(),
            group: String::new(),
            facts: vec![("faces", json!(12))],
            entries: vec![entry("auto", [2.0, 9.0, 6.0]), entry("z-pass", [1.0, 3.0, 1.0])],
        };
        assert_eq!(row.ratio(time, "auto", "z-pass").map(|ratio| ratio.median), Some(3.0));
        assert_eq!(row.ratio(time, "auto", "zp+"), None);
        assert_eq!(row.entries[0].values(stage), [3.0, 0.0, 0.0]);
        assert_eq!((row.faces(), row.lights()), (12, 0));
        let ratio = &row.json()["variants"][0]["ratios"][0];
        assert_eq!((&ratio["to"], &ratio["median"]), (&json!("z-pass"), &json!(3.0)));
        // A time that is not known has its key.
        let unknown = row.entries.iter().map(|entry| entry.clone().with(Metric::Time("deform"), [])).collect();
        let variant = &Row { entries: unknown, ..row }.json()["variants"][0];
        assert_eq!(variant["times"].get("deform"), Some(&Value::Null));
        assert_eq!(variant["ratios"].as_array().map(Vec::len), Some(1));
    }
}
