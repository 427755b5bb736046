//! Rows for the terminal.

use std::fmt::Write as _;

use super::super::text::{figures, grouped};
use super::results::{COUNTERS, PARTS, SkipRow};

pub(super) fn row(row: &SkipRow) -> String {
    let mut text = format!(
        "{}, {} faces in all, {} {}, {} of {} pairs in range\n",
        row.title(),
        grouped(row.faces),
        row.lights,
        if row.lights == 1 { "light" } else { "lights" },
        grouped(row.pairs_in_range),
        grouped(row.casters * row.lights)
    );
    let _ = write!(text, "  {:<28}", "median ms, and ÷ all on");
    for part in PARTS {
        let _ = write!(text, " {:>22}", part.name());
    }
    let _ = writeln!(text, " {:>22} {:>14}", "volume fragments", "parts ÷ frame");
    for entry in &row.entries {
        let _ = write!(text, "  {:<28}", entry.variant.name());
        let mut cell = |value: String, ratio: Option<f64>| {
            let ratio = ratio.map_or_else(String::new, |ratio| format!("{}×", figures(ratio)));
            let _ = write!(text, " {value:>13} {ratio:>8}");
        };
        for part in PARTS {
            let ms = entry.part(part).map_or_else(String::new, |ms| figures(ms.median));
            cell(ms, row.ratio(entry, part).map(|ratio| ratio.median));
        }
        let fragments = entry.fragments.map_or_else(|| "–".to_owned(), |fragments| grouped(fragments as usize));
        cell(fragments, row.fragments_ratio(entry));
        let together = entry.parts_of_frame().map_or_else(|| "–".to_owned(), |share| format!("{:.2}", share.median));
        let _ = writeln!(text, " {together:>14}");
    }
    for entry in &row.entries {
        let counts: Vec<String> = COUNTERS
            .iter()
            .map(|counter| format!("{} {}", grouped((counter.of)(&entry.counted) as usize), counter.name))
            .collect();
        let _ = writeln!(text, "  {:<28} {}", entry.variant.name(), counts.join(", "));
    }
    text
}
