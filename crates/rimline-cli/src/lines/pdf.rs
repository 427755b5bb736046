//! PDF 1.7: a page with a layer (optional content group) a class. No dates and no ids, so equal drawings are equal files.

use std::io::{self, Write};

use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Filter, Finish as _, Name, Pdf, Rect, Ref, TextStr};

use super::Picture;
use super::sheet::{Layer, Polyline};

/// Points a millimetre.
const POINTS_PER_MM: f64 = 72.0 / 25.4;
/// Most units of PDF that readers take each way. A unit is a point; of larger pages it is several points.
const MOST_UNITS: f64 = 14_400.0;

const CATALOG: i32 = 1;
const PAGES: i32 = 2;
const PAGE: i32 = 3;
const CONTENT: i32 = 4;
const INFO: i32 = 5;
const FIRST_LAYER: i32 = 6;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let layers = &picture.sheet.layers;
    let layer = |number: usize| Ref::new(FIRST_LAYER + number as i32);
    let groups = || (0..layers.len()).map(layer);
    let mut pdf = Pdf::new();
    pdf.document_info(Ref::new(INFO))
        .title(TextStr(&picture.title()))
        .subject(TextStr(&picture.description()))
        .creator(TextStr("rimline"));
    let mut catalog = pdf.catalog(Ref::new(CATALOG));
    catalog.pages(Ref::new(PAGES));
    if !layers.is_empty() {
        let mut properties = catalog.insert(Name(b"OCProperties")).dict();
        properties.insert(Name(b"OCGs")).array().items(groups());
        let mut default = properties.insert(Name(b"D")).dict();
        default.insert(Name(b"Order")).array().items(groups());
        default.insert(Name(b"ON")).array().items(groups());
    }
    catalog.finish();
    pdf.pages(Ref::new(PAGES)).kids([Ref::new(PAGE)]).count(1);
    let points = picture.sheet.size_mm.map(|side| side * POINTS_PER_MM);
    let points_per_unit = libm::ceil(points[0].max(points[1]) / MOST_UNITS).max(1.0);
    let [width, height] = points.map(|side| (side / points_per_unit) as f32);
    let mut page = pdf.page(Ref::new(PAGE));
    page.parent(Ref::new(PAGES)).media_box(Rect::new(0.0, 0.0, width, height)).contents(Ref::new(CONTENT));
    if points_per_unit > 1.0 {
        page.user_unit(points_per_unit as f32);
    }
    let mut resources = page.resources();
    let mut properties = resources.insert(Name(b"Properties")).dict();
    for number in 0..layers.len() {
        properties.pair(Name(key(number).as_bytes()), layer(number));
    }
    properties.finish();
    resources.finish();
    page.finish();
    for (number, content) in layers.iter().enumerate() {
        let mut group = pdf.indirect(layer(number)).dict();
        group.pair(Name(b"Type"), Name(b"OCG"));
        group.pair(Name(b"Name"), TextStr(&content.name()));
    }
    let content = compressed(&contents(layers, POINTS_PER_MM / points_per_unit))?;
    pdf.stream(Ref::new(CONTENT), &content).filter(Filter::FlateDecode);
    to.write_all(&pdf.finish())
}

fn key(layer: usize) -> String {
    format!("L{layer}")
}

fn contents(layers: &[Layer], per_mm: f64) -> Vec<u8> {
    let mut content = Content::new();
    content.set_line_join(LineJoinStyle::RoundJoin);
    for (number, layer) in layers.iter().enumerate() {
        let points = |mm: f64| (mm * per_mm) as f32;
        let pen = &layer.pen;
        let [r, g, b] = pen.color.map(|part| f32::from(part) / 255.0);
        content.begin_marked_content_with_properties(Name(b"OC")).properties_named(Name(key(number).as_bytes()));
        content.set_stroke_rgb(r, g, b).set_line_width(points(pen.width_mm));
        // Round ends would fill the gaps of dashes.
        content.set_line_cap(if pen.dash_mm.is_empty() { LineCapStyle::RoundCap } else { LineCapStyle::ButtCap });
        content.set_dash_pattern(pen.dash_mm.iter().map(|&mm| points(mm)), 0.0);
        layer.lines.iter().for_each(|line| path(&mut content, line, per_mm));
        content.end_marked_content();
    }
    content.finish().to_vec()
}

fn path(content: &mut Content, line: &Polyline, per_mm: f64) {
    for (number, point) in line.points.iter().enumerate() {
        let [x, y] = point.map(|micrometres| (micrometres as f64 / 1000.0 * per_mm) as f32);
        if number == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
    if line.is_closed {
        content.close_and_stroke()
    } else {
        content.stroke()
    };
}

fn compressed(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}
