//! Numbers and rows as text.

use std::fmt::Write as _;

pub(crate) use super::grouped::grouped;
use super::method::{GPU_FAST, PER_EDGE};
use super::results::Row;

/// Three figures that count.
pub(crate) fn figures(number: f64) -> String {
    match number.abs() {
        _ if !number.is_finite() => "–".to_owned(),
        0.0 => "0".to_owned(),
        size if size >= 99.95 => grouped(number.round() as usize),
        size if size >= 9.995 => format!("{number:.1}"),
        size if size >= 0.9995 => format!("{number:.2}"),
        size if size >= 0.0995 => format!("{number:.3}"),
        size if size >= 0.001 => format!("{number:.4}"),
        _ => format!("{number:.1e}"),
    }
}

/// A tick of an axis: no more figures than it needs.
pub(crate) fn tick(value: f64) -> String {
    match value {
        v if v >= 1e6 => format!("{} M", short(v / 1e6)),
        v if v >= 1e4 => format!("{} k", short(v / 1e3)),
        v if v >= 1e3 => grouped(v.round() as usize),
        v => short(v),
    }
}

fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A ratio's tick.
pub(crate) fn times(value: f64) -> String {
    format!("{}×", short(value))
}

/// A row for the terminal.
pub(crate) fn row(row: &Row) -> String {
    let subject = &row.subject;
    let mut text = format!(
        "{}, {} faces, {} {}\n  {:<36} {:>9}  {:^21} {:>4} {:>9} {:>8} {:>9} {:>10} {:>8}\n",
        subject.name,
        grouped(subject.faces),
        row.lights,
        if row.lights == 1 { "light" } else { "lights" },
        "",
        "median ms",
        "quartiles",
        "runs",
        "2003 ÷ it",
        "it ÷ f32",
        "facing",
        "silhouette",
        "open"
    );
    for entry in &row.entries {
        let id = entry.contestant.id;
        let Some(time) = entry.time() else { continue };
        let fast = if entry.contestant.is_gpu() { GPU_FAST } else { entry.contestant.compared_to[0] };
        let ratio =
            |of: &str, to: &str| row.ratio(of, to).map_or_else(String::new, |ratio| format!("{:.2}", ratio.median));
        let _ = writeln!(
            text,
            "  {:<36} {:>9}  {:>9} … {:<9} {:>4} {:>9} {:>8} {:>9} {:>10} {:>8}",
            entry.contestant.name,
            figures(time.median),
            figures(time.quartiles.0),
            figures(time.quartiles.1),
            time.count,
            ratio(PER_EDGE, id),
            ratio(id, fast),
            entry.score.wrong_facing_bits,
            entry.score.wrong_silhouette_bits,
            entry.score.unclosed_vertices
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use rimline_bench::error_metrics::Score;

    use super::super::measure::Sample;
    use super::super::method::{CONTESTANTS, GPU_EXACT};
    use super::super::results::{Entry, SubjectFacts};
    use super::*;

    #[test]
    fn numbers_are_short_and_grouped() {
        assert_eq!([grouped(0), grouped(999), grouped(1_048_576)], ["0", "999", "1,048,576"]);
        assert_eq!([1.0, 0.5, 0.01, 20_000.0, 3e6].map(tick), ["1", "0.5", "0.01", "20 k", "3 M"]);
        assert_eq!([1234.6, 12.34, 1.2, 0.1234, 0.0].map(figures), ["1,235", "12.3", "1.20", "0.123", "0"]);
    }

    #[test]
    fn speed_against_2003_is_larger_where_the_method_is_faster() {
        let entry = |id: &str, wall_ms: f64| Entry {
            contestant: CONTESTANTS.iter().find(|contestant| contestant.id == id).expect("it is there"),
            samples: vec![Sample { wall_ms, ..Sample::default() }; 3],
            score: Score::default(),
            undecided_pairs: 0,
        };
        let subject = SubjectFacts {
            name: "torus-4".to_owned(),
            class: "ordinary",
            vertices: 2,
            faces: 4,
            edges: 6,
            is_closed: true,
            topology_ms: 1.0,
            topology_bytes: 96,
        };
        let entries = vec![entry(PER_EDGE, 6.0), entry(GPU_FAST, 2.0), entry(GPU_EXACT, 3.0)];
        let text = row(&Row { subject, lights: 1, entries });
        let exact = text.lines().last().expect("a line a method");
        let ratios: Vec<&str> = exact.split_whitespace().rev().skip(3).take(2).collect();
        assert_eq!(ratios, ["1.50", "2.00"], "from the right: exact ÷ f32, 2003 ÷ exact");
    }
}
