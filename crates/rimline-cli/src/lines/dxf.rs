//! DXF R12 as text, which every CAD program reads: a layer a class, polylines, millimetres of the page or the files'
//! unit. The crate `dxf` 0.6 writes dates and random ids, and brings 26 crates.

use std::io::{self, Write};

use super::Picture;
use super::args::Unit;
use super::sheet::{Layer, Polyline};
use super::svg::Decimal;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let sheet = picture.sheet;
    let (low, high) = sheet.units.as_ref().map_or(([0.0; 2], sheet.size_mm), |units| (units.low, units.high));
    pair(to, 999, picture.title())?;
    section(to, "HEADER")?;
    pair(to, 9, "$ACADVER")?;
    pair(to, 1, "AC1009")?;
    if sheet.units.is_some() {
        pair(to, 9, "$INSUNITS")?;
        pair(to, 70, picture.args.unit.map_or(0, Unit::of_dxf))?;
    }
    for (name, [x, y]) in [("$LIMMIN", low), ("$LIMMAX", high), ("$EXTMIN", low), ("$EXTMAX", high)] {
        pair(to, 9, name)?;
        pair(to, 10, x)?;
        pair(to, 20, y)?;
    }
    pair(to, 0, "ENDSEC")?;
    section(to, "TABLES")?;
    let mut dashes: Vec<&[f64]> = Vec::new();
    for layer in sheet.layers.iter().filter(|layer| !layer.pen.dash_mm.is_empty()) {
        if !dashes.contains(&&*layer.pen.dash_mm) {
            dashes.push(&layer.pen.dash_mm);
        }
    }
    table(to, "LTYPE", 1 + dashes.len())?;
    line_type(to, "CONTINUOUS", "Solid line", &[])?;
    for (number, dashes) in dashes.iter().enumerate() {
        let per_mm = sheet.units.as_ref().map_or(1.0, |units| units.per_mm);
        line_type(to, &dashed(number), "Dashed line", &dashes.iter().map(|mm| mm * per_mm).collect::<Vec<_>>())?;
    }
    pair(to, 0, "ENDTAB")?;
    table(to, "LAYER", sheet.layers.len())?;
    for layer in &sheet.layers {
        pair(to, 0, "LAYER")?;
        pair(to, 2, name(layer))?;
        pair(to, 70, 0)?;
        pair(to, 62, index_of_color(layer.pen.color))?;
        let pattern = dashes.iter().position(|dashes| *dashes == layer.pen.dash_mm);
        pair(to, 6, pattern.map_or("CONTINUOUS".to_owned(), dashed))?;
    }
    pair(to, 0, "ENDTAB")?;
    pair(to, 0, "ENDSEC")?;
    section(to, "ENTITIES")?;
    let decimals = sheet.units.as_ref().map_or(3, |units| units.decimals);
    for layer in &sheet.layers {
        let name = name(layer);
        layer.lines.iter().try_for_each(|line| polyline(to, &name, line, decimals))?;
    }
    pair(to, 0, "ENDSEC")?;
    pair(to, 0, "EOF")
}

/// The name of a line type.
fn dashed(number: usize) -> String {
    format!("DASHED{}", number + 1)
}

/// Layer names of R12 have capital letters.
fn name(layer: &Layer) -> String {
    layer.name().to_uppercase()
}

fn polyline(to: &mut impl Write, layer: &str, line: &Polyline, decimals: i32) -> io::Result<()> {
    let entity = |to: &mut _, kind: &str| {
        pair(to, 0, kind)?;
        pair(to, 8, layer)
    };
    let point = |to: &mut _, [x, y]: [i64; 2], codes: [u32; 2]| {
        pair(to, codes[0], Decimal(x, decimals))?;
        pair(to, codes[1], Decimal(y, decimals))
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

/// Colours of the palette that CAD programs share, with their numbers. 7 is black on white paper.
const PALETTE: [(u32, [u8; 3]); 15] = [
    (7, [0; 3]),
    (1, [255, 0, 0]),
    (2, [255, 255, 0]),
    (3, [0, 255, 0]),
    (4, [0, 255, 255]),
    (5, [0, 0, 255]),
    (6, [255, 0, 255]),
    (8, [128; 3]),
    (9, [192; 3]),
    (250, [51; 3]),
    (251, [91; 3]),
    (252, [132; 3]),
    (253, [173; 3]),
    (254, [214; 3]),
    (255, [255; 3]),
];

/// The number of the nearest colour of the palette.
fn index_of_color(color: [u8; 3]) -> u32 {
    let distance =
        |other: &[u8; 3]| color.iter().zip(other).map(|(a, b)| i32::from(a.abs_diff(*b)).pow(2)).sum::<i32>();
    PALETTE.iter().min_by_key(|(_, other)| distance(other)).map_or(7, |(number, _)| *number)
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

/// Dashes are positive in the file, gaps negative. An odd number of lengths is gone through twice.
fn line_type(to: &mut impl Write, name: &str, description: &str, lengths: &[f64]) -> io::Result<()> {
    pair(to, 0, "LTYPE")?;
    pair(to, 2, name)?;
    pair(to, 70, 0)?;
    pair(to, 3, description)?;
    pair(to, 72, 65)?;
    let lengths = if lengths.len().is_multiple_of(2) { lengths.to_vec() } else { lengths.repeat(2) };
    pair(to, 73, lengths.len())?;
    pair(to, 40, lengths.iter().sum::<f64>())?;
    let mut signed = lengths.iter().enumerate().map(|(number, length)| if number % 2 == 0 { *length } else { -length });
    signed.try_for_each(|length| pair(to, 49, length))
}

/// A group code and its value, each on a line.
fn pair(to: &mut impl Write, code: u32, value: impl std::fmt::Display) -> io::Result<()> {
    writeln!(to, "{code:>3}\n{value}")
}
