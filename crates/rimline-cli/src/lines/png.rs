//! PNG: the strokes of the page on white, smoothed.

use std::io::{self, Write};

use tiny_skia::{Color, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

use super::Picture;
use super::sheet::{Layer, Polyline};
use rimline_files::size::size as memory;

/// More pixels each way are refused.
const MOST_PIXELS: u32 = 32_768;

pub(super) fn write(to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
    let per_mm = f64::from(picture.args.dpi()) / 25.4;
    let size = picture.sheet.size_mm.map(|side| libm::ceil(side * per_mm));
    let too_large = || {
        let [width, height] = size;
        io::Error::other(format!(
            "a PNG of {width}x{height} pixels is too large, at most {MOST_PIXELS} each way are written; give a lower --dpi"
        ))
    };
    if !size.into_iter().all(|side| side <= f64::from(MOST_PIXELS)) {
        return Err(too_large());
    }
    // Each pixel has four bytes where it is drawn, and three where it is written.
    let (needed, limit) = ((7.0 * size[0] * size[1]) as u64, picture.args.read.load.memory_limit);
    if needed > limit {
        return Err(io::Error::other(format!(
            "a PNG of this size takes {} of memory, more than the limit of {}; give a lower --dpi or a larger --memory-limit",
            memory(needed),
            memory(limit),
        )));
    }
    let [width, height] = size.map(|side| side as u32);
    let mut pixels = Pixmap::new(width, height).ok_or_else(too_large)?;
    pixels.fill(Color::WHITE);
    for layer in &picture.sheet.layers {
        draw(&mut pixels, layer, per_mm, size[1]);
    }
    let mut encoder = png::Encoder::new(to, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let dots = libm::round(1000.0 * per_mm) as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: dots, yppu: dots, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header()?;
    let rgb: Vec<u8> = pixels.data().chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    writer.write_image_data(&rgb)?;
    Ok(writer.finish()?)
}

fn draw(pixels: &mut Pixmap, layer: &Layer, per_mm: f64, height: f64) {
    let pen = &layer.pen;
    let mut paint = Paint::default();
    let [r, g, b] = pen.color;
    paint.set_color_rgba8(r, g, b, 255);
    let scaled = |mm: f64| (mm * per_mm) as f32;
    // Skia takes an even number of lengths; an odd one is gone through twice.
    let odd = pen.dash_mm.len() % 2;
    let lengths = pen.dash_mm.iter().chain(pen.dash_mm.iter().take(odd * pen.dash_mm.len()));
    let stroke = Stroke {
        width: scaled(pen.width_mm),
        // Round ends would fill the gaps of dashes.
        line_cap: if pen.dash_mm.is_empty() { LineCap::Round } else { LineCap::Butt },
        line_join: LineJoin::Round,
        dash: StrokeDash::new(lengths.map(|&mm| scaled(mm)).collect(), 0.0),
        ..Stroke::default()
    };
    for path in layer.lines.iter().filter_map(|line| path(line, per_mm, height)) {
        pixels.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }
}

fn path(line: &Polyline, per_mm: f64, height: f64) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (number, point) in line.points.iter().enumerate() {
        let [x, y] = point.map(|micrometres| micrometres as f64 / 1000.0 * per_mm);
        let (x, y) = (x as f32, (height - y) as f32);
        if number == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if line.is_closed {
        builder.close();
    }
    builder.finish()
}
