//! SVG 1.1: millimetres, a group a layer, a path an object.

use std::fmt::{self, Display, Formatter};
use std::io::{self, Write};

use super::Picture;
use super::sheet::{Layer, Polyline};
use super::style::Pen;
use crate::output::Line;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let [width, height] = picture.sheet.size_mm;
    writeln!(to, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        to,
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">"#
    )?;
    writeln!(to, "<title>{}</title>", Escaped(&picture.title()))?;
    writeln!(to, "<desc>{}</desc>", Escaped(&picture.description()))?;
    for layer in &picture.sheet.layers {
        group(to, picture, layer)?;
    }
    writeln!(to, "</svg>")
}

fn group(to: &mut impl Write, picture: &Picture<'_>, layer: &Layer) -> io::Result<()> {
    let (name, Pen { width_mm, color: [r, g, b], dash_mm }) = (layer.name(), &layer.pen);
    write!(
        to,
        r##"<g id="{name}" inkscape:groupmode="layer" inkscape:label="{name}" fill="none" stroke="#{r:02x}{g:02x}{b:02x}" stroke-width="{width_mm}" stroke-linejoin="round""##
    )?;
    // Round ends would fill the gaps of dashes.
    if dash_mm.is_empty() {
        write!(to, r#" stroke-linecap="round""#)?;
    } else {
        let lengths: Vec<_> = dash_mm.iter().map(f64::to_string).collect();
        write!(to, r#" stroke-dasharray="{}""#, lengths.join(" "))?;
    }
    writeln!(to, ">")?;
    // Lines of an object may lie apart in the layer.
    let mut lines: Vec<&Polyline> = layer.lines.iter().collect();
    lines.sort_by_key(|line| line.object);
    for of_object in lines.chunk_by(|one, other| one.object == other.object) {
        let object = of_object[0].object;
        write!(to, r#"<path id="{name}-{object}" d=""#)?;
        for line in of_object {
            path(to, line, picture.sheet.size_mm[1])?;
        }
        let name = picture.objects.get(object as usize).map_or("", |object| &*object.name);
        writeln!(to, r#""><title>{}</title></path>"#, Escaped(&Line(name).to_string()))?;
    }
    writeln!(to, "</g>")
}

/// From one point to the next by differences, which are short.
fn path(to: &mut impl Write, line: &Polyline, height_mm: f64) -> io::Result<()> {
    let height = libm::round(1000.0 * height_mm) as i64;
    let mut before = [0; 2];
    for (number, &[x, y]) in line.points.iter().enumerate() {
        let point = [x, height - y];
        let [dx, dy] = [0, 1].map(|axis| Decimal(point[axis] - before[axis], 3));
        let command = ["M", "l", " "][number.min(2)];
        let gap = if dy.0 < 0 { "" } else { " " };
        write!(to, "{command}{dx}{gap}{dy}")?;
        before = point;
    }
    if line.is_closed { write!(to, "z") } else { Ok(()) }
}

/// A number in steps of its last decimal, and how many decimals it has, without zeros that say nothing.
pub(super) struct Decimal(pub(super) i64, pub(super) i32);

impl Display for Decimal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let &Self(steps, decimals) = self;
        let (sign, after) = (if steps < 0 { "-" } else { "" }, decimals.max(0) as usize);
        let digits = format!("{:0>1$}", steps.unsigned_abs(), after + 1);
        let (whole, part) = digits.split_at(digits.len() - after);
        let zeros = if steps == 0 { 0 } else { decimals.min(0).unsigned_abs() as usize };
        match part.trim_end_matches('0') {
            "" => write!(f, "{sign}{whole}{:0<zeros$}", ""),
            part => write!(f, "{sign}{whole}.{part}"),
        }
    }
}

/// Text in XML. Characters that XML has no way to write become a replacement character.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            match c {
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '&' => f.write_str("&amp;")?,
                '"' => f.write_str("&quot;")?,
                c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => f.write_str("\u{fffd}")?,
                c => write!(f, "{c}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_text_is_escaped() {
        let shown = [0, 5, -250, 1000, 12_340, -1_001].map(|length| Decimal(length, 3).to_string());
        assert_eq!(shown, ["0", "0.005", "-0.25", "1", "12.34", "-1.001"]);
        let shown =
            [(0, -3), (12, -3), (-5, 12), (1_200_000, 5)].map(|(steps, decimals)| Decimal(steps, decimals).to_string());
        assert_eq!(shown, ["0", "12000", "-0.000000000005", "12"]);
        assert_eq!(Escaped("a<b>&\"\u{1}").to_string(), "a&lt;b&gt;&amp;&quot;\u{fffd}");
    }

    #[test]
    fn a_path_takes_steps_from_the_top() {
        let line = Polyline { object: 0, points: vec![[0, 0], [1000, 0], [1000, 2500]], is_closed: true };
        // A thousand times the second is a little less than 2002.
        for (height_mm, expected) in [(10.0, "M0 10l1 0 0-2.5z"), (2.002, "M0 2.002l1 0 0-2.5z")] {
            let mut text = Vec::new();
            path(&mut text, &line, height_mm).expect("memory can be written");
            assert_eq!(String::from_utf8(text).as_deref(), Ok(expected));
        }
    }
}
