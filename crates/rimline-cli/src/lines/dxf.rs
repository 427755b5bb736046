//! DXF R12 as text, which every CAD program reads: a layer a class, polylines, millimetres of the page. The crate `dxf` 0.6
//! writes dates and random ids, and brings 26 crates.

use std::io::{self, Write};

use super::Picture;
use super::sheet::{Layer, Polyline};
use super::svg::Micrometres;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let sheet = picture.sheet;
    let [width, height] = sheet.size_mm;
    pair(to, 999, picture.title())?;
    section(to, "HEADER")?;
    pair(to, 9, "$ACADVER")?;
    pair(to, 1, "AC1009")?;
    for (name, x, y) in
        [("$LIMMIN", 0.0, 0.0), ("$LIMMAX", width, height), ("$EXTMIN", 0.0, 0.0), ("$EXTMAX", width, height)]
    {
        pair(to, 9, name)?;
        pair(to, 10, x)?;
        pair(to, 20, y)?;
    }
    pair(to, 0, "ENDSEC")?;
    section(to, "TABLES")?;
    let has_dashes = sheet.layers.iter().any(|layer| !layer.pen.dash_mm.is_empty());
    table(to, "LTYPE", 1 + usize::from(has_dashes))?;
    line_type(to, "CONTINUOUS", "Solid line", &[])?;
    if has_dashes {
        line_type(to, "HIDDEN", "Dashed line", &[1.5, -0.8])?;
    }
    pair(to, 0, "ENDTAB")?;
    table(to, "LAYER", sheet.layers.len())?;
    for layer in &sheet.layers {
        pair(to, 0, "LAYER")?;
        pair(to, 2, name(layer))?;
        pair(to, 70, 0)?;
        pair(to, 62, index_of_color(layer.pen.color))?;
        pair(to, 6, if layer.pen.dash_mm.is_empty() { "CONTINUOUS" } else { "HIDDEN" })?;
    }
    pair(to, 0, "ENDTAB")?;
    pair(to, 0, "ENDSEC")?;
    section(to, "ENTITIES")?;
    for layer in &sheet.layers {
        let name = name(layer);
        layer.lines.iter().try_for_each(|line| polyline(to, &name, line))?;
    }
    pair(to, 0, "ENDSEC")?;
    pair(to, 0, "EOF")
}

/// Layer names of R12 have capital letters.
fn name(layer: &Layer) -> String {
    layer.name().to_uppercase()
}

fn polyline(to: &mut impl Write, layer: &str, line: &Polyline) -> io::Result<()> {
    let entity = |to: &mut _, kind: &str| {
        pair(to, 0, kind)?;
        pair(to, 8, layer)
    };
    let point = |to: &mut _, [x, y]: [i64; 2], codes: [u32; 2]| {
        pair(to, codes[0], Micrometres(x))?;
        pair(to, codes[1], Micrometres(y))
    };
    if let ([a, b], false) = (&*line.points, line.is_closed) {
        entity(to, "LINE")?;
        point(to, *a, [10, 20])?;
        return point(to, *b, [11, 21]);
    }
    entity(to, "POLYLINE")?;
    pair(to, 66, 1)?;
    point(to, [0; 2], [10, 20])?;
    pair(to, 70, i32::from(line.is_closed))?;
    for &vertex in &line.points {
        entity(to, "VERTEX")?;
        point(to, vertex, [10, 20])?;
    }
    entity(to, "SEQEND")
}

/// A number of the palette: black and white are 7; other colours take the nearest of its first six.
fn index_of_color(color: [u8; 3]) -> u32 {
    let [r, g, b] = color.map(|part| part > 127);
    match (r, g, b) {
        (true, false, false) => 1,
        (true, true, false) => 2,
        (false, true, false) => 3,
        (false, true, true) => 4,
        (false, false, true) => 5,
        (true, false, true) => 6,
        _ => 7,
    }
}

fn section(to: &mut impl Write, name: &str) -> io::Result<()> {
    pair(to, 0, "SECTION")?;
    pair(to, 2, name)
}

fn table(to: &mut impl Write, name: &str, count: usize) -> io::Result<()> {
    pair(to, 0, "TABLE")?;
    pair(to, 2, name)?;
    pair(to, 70, count)
}

/// Dashes are positive, gaps negative.
fn line_type(to: &mut impl Write, name: &str, description: &str, lengths: &[f64]) -> io::Result<()> {
    pair(to, 0, "LTYPE")?;
    pair(to, 2, name)?;
    pair(to, 70, 0)?;
    pair(to, 3, description)?;
    pair(to, 72, 65)?;
    pair(to, 73, lengths.len())?;
    pair(to, 40, lengths.iter().map(|length: &f64| length.abs()).sum::<f64>())?;
    lengths.iter().try_for_each(|length| pair(to, 49, length))
}

/// A group code and its value, each on a line.
fn pair(to: &mut impl Write, code: u32, value: impl std::fmt::Display) -> io::Result<()> {
    writeln!(to, "{code:>3}\n{value}")
}
