//! DXF R12 as text, which every CAD program reads: a layer a class, polylines, millimetres of the page or the files'
//! unit. The crate `dxf` 0.6 writes dates and random ids, and brings 26 crates.

use std::fmt::Display;
use std::io::{self, Write};

use super::Picture;
use super::sheet::{Layer, Polyline};
use super::svg::Decimal;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let sheet = picture.sheet;
    let (low, high) = sheet.units.as_ref().map_or(([0.0; 2], sheet.size_mm), |units| (units.low, units.high));
    pairs(to, &[(999, &picture.title()), (0, &"SECTION"), (2, &"HEADER"), (9, &"$ACADVER"), (1, &"AC1009")])?;
    if sheet.units.is_some() {
        pairs(to, &[(9, &"$INSUNITS"), (70, &picture.args.unit.map_or(0, |unit| unit.facts().2))])?;
    }
    for (name, [x, y]) in [("$LIMMIN", low), ("$LIMMAX", high), ("$EXTMIN", low), ("$EXTMAX", high)] {
        pairs(to, &[(9, &name), (10, &x), (20, &y)])?;
    }
    let mut dashes: Vec<&[f64]> = Vec::new();
    for layer in sheet.layers.iter().filter(|layer| !layer.pen.dash_mm.is_empty()) {
        if !dashes.contains(&&*layer.pen.dash_mm) {
            dashes.push(&layer.pen.dash_mm);
        }
    }
    pairs(to, &[(0, &"ENDSEC"), (0, &"SECTION"), (2, &"TABLES")])?;
    pairs(to, &[(0, &"TABLE"), (2, &"LTYPE"), (70, &(1 + dashes.len()))])?;
    line_type(to, "CONTINUOUS", "Solid line", &[])?;
    for (number, dashes) in dashes.iter().enumerate() {
        let per_mm = sheet.units.as_ref().map_or(1.0, |units| units.per_mm);
        line_type(to, &dashed(number), "Dashed line", &dashes.iter().map(|mm| mm * per_mm).collect::<Vec<_>>())?;
    }
    pairs(to, &[(0, &"ENDTAB"), (0, &"TABLE"), (2, &"LAYER"), (70, &sheet.layers.len())])?;
    for layer in &sheet.layers {
        let pattern = dashes.iter().position(|dashes| *dashes == layer.pen.dash_mm);
        let (color, pattern) = (index_of_color(layer.pen.color), pattern.map_or("CONTINUOUS".to_owned(), dashed));
        pairs(to, &[(0, &"LAYER"), (2, &name(layer)), (70, &0), (62, &color), (6, &pattern)])?;
    }
    pairs(to, &[(0, &"ENDTAB"), (0, &"ENDSEC"), (0, &"SECTION"), (2, &"ENTITIES")])?;
    let decimals = sheet.units.as_ref().map_or(3, |units| units.decimals);
    for layer in &sheet.layers {
        let name = name(layer);
        layer.lines.iter().try_for_each(|line| polyline(to, &name, line, decimals))?;
    }
    pairs(to, &[(0, &"ENDSEC"), (0, &"EOF")])
}

fn dashed(number: usize) -> String {
    format!("DASHED{}", number + 1)
}

/// Layer names of R12 have capital letters.
fn name(layer: &Layer) -> String {
    layer.name().to_uppercase()
}

fn polyline(to: &mut impl Write, layer: &str, line: &Polyline, decimals: i32) -> io::Result<()> {
    let point = |point: [i64; 2]| point.map(|c| Decimal(c, decimals));
    if let ([a, b], false) = (&*line.points, line.is_closed) {
        let [[ax, ay], [bx, by]] = [point(*a), point(*b)];
        return pairs(to, &[(0, &"LINE"), (8, &layer), (10, &ax), (20, &ay), (11, &bx), (21, &by)]);
    }
    let closed = i32::from(line.is_closed);
    pairs(to, &[(0, &"POLYLINE"), (8, &layer), (66, &1), (10, &0), (20, &0), (70, &closed)])?;
    for &vertex in &line.points {
        let [x, y] = point(vertex);
        pairs(to, &[(0, &"VERTEX"), (8, &layer), (10, &x), (20, &y)])?;
    }
    pairs(to, &[(0, &"SEQEND"), (8, &layer)])
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

/// Dashes are positive in the file, gaps negative. An odd number of lengths is gone through twice.
fn line_type(to: &mut impl Write, name: &str, description: &str, lengths: &[f64]) -> io::Result<()> {
    let lengths = if lengths.len().is_multiple_of(2) { lengths.to_vec() } else { lengths.repeat(2) };
    pairs(to, &[(0, &"LTYPE"), (2, &name), (70, &0), (3, &description), (72, &65)])?;
    pairs(to, &[(73, &lengths.len()), (40, &lengths.iter().sum::<f64>())])?;
    let mut signed = lengths.iter().enumerate().map(|(number, length)| if number % 2 == 0 { *length } else { -length });
    signed.try_for_each(|length| pairs(to, &[(49, &length)]))
}

/// Group codes and their values, each on a line.
fn pairs(to: &mut impl Write, pairs: &[(u32, &dyn Display)]) -> io::Result<()> {
    pairs.iter().try_for_each(|(code, value)| writeln!(to, "{code:>3}\n{value}"))
}
