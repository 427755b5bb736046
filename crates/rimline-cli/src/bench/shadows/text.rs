//! A row for the terminal.

use std::fmt::Write as _;

use super::super::text::{figures, grouped};
use super::method::Z_PASS;
use super::results::{Part, ShadowRow};

pub(super) fn row(row: &ShadowRow) -> String {
    let mut text = format!(
        "shadows of a {}, {} faces: {}\n  {:<18} {:>10} {:>9} {:>10} {:>9} {:>13}\n",
        row.model,
        grouped(row.faces),
        row.path.name(),
        "",
        "stencil ms",
        "÷ z-pass",
        "frame ms",
        "÷ z-pass",
        "wrong pixels"
    );
    for entry in &row.entries {
        let time = |part| entry.mean(part).map_or_else(String::new, |time| figures(time.median));
        let ratio = |part| {
            let ratio = row.ratio(part, entry.method.id, Z_PASS);
            ratio.map_or_else(String::new, |ratio| format!("{:.2}", ratio.median))
        };
        let _ = writeln!(
            text,
            "  {:<18} {:>10} {:>9} {:>10} {:>9} {:>13}",
            entry.method.name,
            time(Part::Stencil),
            ratio(Part::Stencil),
            time(Part::Frame),
            ratio(Part::Frame),
            figures(entry.wrong())
        );
    }
    text
}
