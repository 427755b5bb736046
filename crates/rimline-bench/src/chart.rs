//! Charts by plotters: curves and points in a plane, and rows of bars or dots. The caller supplies the data; this
//! module knows nothing of silhouettes.
//!
//! A chart is SVG for the report's page, whose style sheet replaces the colours on a dark ground, and PNG by the same SVG.

use std::fmt::Write as _;
use std::io;
use std::ops::Range;
use std::sync::Arc;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::element::{DashedPathElement, DynElement};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use resvg::{tiny_skia, usvg};

use crate::row::Mark;

/// Colours of marks, told apart by people who do not see all colours (Okabe and Ito, "Color Universal Design", 2008),
/// for a light and for a dark ground; the dark ones are lifted where the original would sink.
pub(crate) const PALETTE: [(u32, u32); 8] = [
    (0xD5_5E00, 0xE8_793A),
    (0xB9_7700, 0xE6_9F00),
    (0x00_72B2, 0x4B_A3E0),
    (0x3A_93C9, 0x8C_CBF0),
    (0x00_805F, 0x2F_C397),
    (0xB0_568C, 0xD9_8BB9),
    (0x5B_5B5B, 0xB4_B4B4),
    (0x8A_7B00, 0xE0_D34A),
];
/// The other colours on a light ground, by the names of the page's CSS variables.
pub(crate) const ROLES: [(&str, u32); 4] =
    [("text", 0x1B_1F24), ("muted", 0x59_636E), ("grid", 0xDD_E2E7), ("ground", 0xFF_FFFF)];
const TEXT: RGBColor = rgb(ROLES[0].1);
const MUTED: RGBColor = rgb(ROLES[1].1);
const GRID: RGBColor = rgb(ROLES[2].1);
const GROUND: RGBColor = rgb(ROLES[3].1);

const fn rgb(hex: u32) -> RGBColor {
    RGBColor((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

fn colour(mark: Mark) -> RGBColor {
    rgb(PALETTE[mark.colour % PALETTE.len()].0)
}

/// Lengths are halves of a CSS pixel, since plotters places shapes on whole numbers; they are the pixels of the PNG file.
const FONT: f64 = 26.0;
const LINE: i32 = 36;
const MARK: i32 = 10;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<io::Error>>;
type Plot<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Coordinate, Coordinate>>;

/// How numbers become places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    Log,
}

/// An axis over a range of numbers.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    title: String,
    scale: Scale,
    /// How a tick is written.
    format: fn(f64) -> String,
    low: f64,
    high: f64,
    /// The lowest tick stands for zero, which a logarithmic axis does not have.
    has_zero: bool,
}

/// A number with the quartiles around it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) quartiles: [f64; 2],
}

/// A key, and in a plane its points: a curve, or a cloud.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) mark: Mark,
    pub(crate) points: Vec<Point>,
}

/// A row of bars or dots.
#[derive(Clone, Debug)]
pub(crate) struct Bar {
    pub(crate) name: String,
    /// Only a heading of the rows below.
    pub(crate) is_heading: bool,
    /// In the order of the keys: lengths, with quartiles.
    pub(crate) values: Vec<Option<(f64, [f64; 2])>>,
    /// Stands at the end of a stacked bar.
    pub(crate) remark: String,
}

/// A chart over a horizontal axis.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    pub(crate) axis: Axis,
    pub(crate) series: Vec<Series>,
    pub(crate) body: Body,
    /// A dashed line at this number: of the vertical axis of a plane, and of the only axis of rows.
    pub(crate) level: Option<f64>,
}

#[derive(Clone, Debug)]
pub(crate) enum Body {
    /// Points over a vertical axis, which may be joined to curves.
    Plane { y: Axis, is_joined: bool },
    /// Values of a row are parts of one bar if they are stacked, otherwise dots on one line.
    Rows { rows: Vec<Bar>, is_stacked: bool },
}

/// Where a chart goes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target<'a> {
    /// The page on a wide screen, whose text says what the chart is.
    Page,
    /// The page on a narrow screen, in letters of the same size.
    Phone,
    /// A file by itself, with a heading and a line below that says where the figures are from.
    File { title: &'a str, origin: &'a str },
}

impl Axis {
    /// An axis on which all of `values` have room; those that cannot be shown count for nothing. On a logarithmic axis zero
    /// lies below all others.
    pub(crate) fn over(
        title: &str,
        scale: Scale,
        format: fn(f64) -> String,
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        let (mut low, mut high, mut has_zero) = (f64::INFINITY, f64::NEG_INFINITY, false);
        for value in values.into_iter().filter(|value| value.is_finite()) {
            if scale == Scale::Log && value <= 0.0 {
                has_zero = true;
            } else {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        let (low, high) = match scale {
            _ if low > high => (1.0, 10.0),
            Scale::Log => {
                let margin = (high / low).max(2.0).powf(0.07);
                (low / margin, high * margin)
            }
            Scale::Linear => (low.min(0.0), if high > low.min(0.0) { high * 1.08 } else { 1.0 }),
        };
        Self { title: title.to_owned(), scale, format, low, high, has_zero }
    }

    /// The same with a number shown that may lie outside.
    pub(crate) fn including(mut self, value: f64) -> Self {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
        self
    }

    /// The same with room for zero below the least number of a logarithmic axis.
    pub(crate) fn with_zero(mut self) -> Self {
        self.low /= (self.high / self.low).max(10.0).powf(0.12);
        self
    }

    /// A number as plotters is to place it: its logarithm on a logarithmic axis.
    fn position(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value.clamp(self.low, self.high),
            Scale::Log => value.clamp(self.low, self.high).log10(),
        }
    }

    /// The coordinate, with as many round ticks as have room.
    fn coordinate(&self, room: i32, of_tick: impl Fn(&str) -> i32) -> Coordinate {
        let [low, high] = [self.low, self.high].map(|end| self.position(end));
        let fits = |ticks: &Vec<f64>| {
            ticks.windows(2).all(|pair| {
                let between = f64::from(room) * (self.position(pair[1]) - self.position(pair[0])) / (high - low);
                let [one, other] = [pair[0], pair[1]].map(|tick| of_tick(&(self.format)(tick)));
                between >= f64::from(one + other) / 2.0
            })
        };
        let mut ticks = self.ticks().into_iter().find(fits).unwrap_or_default();
        if self.has_zero {
            let least = self.low * 10_f64.powf(0.1 * (high - low));
            ticks.retain(|tick| *tick > least);
            ticks.insert(0, self.low);
        }
        let ticks = ticks.into_iter().map(|tick| self.position(tick)).collect();
        Coordinate { positions: (low..high).into(), ticks }
    }

    /// The text of a tick.
    fn label(&self, position: f64) -> String {
        match self.scale {
            Scale::Log if self.has_zero && position <= self.position(self.low) => "0".to_owned(),
            Scale::Log => (self.format)(10_f64.powf(position)),
            Scale::Linear => (self.format)(position),
        }
    }

    /// Round numbers in the range, the most first.
    fn ticks(&self) -> Vec<Vec<f64>> {
        let inside = |ticks: Vec<f64>| ticks.into_iter().filter(|tick| (self.low..=self.high).contains(tick)).collect();
        let steps: [&[f64]; 4] = [&[1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];
        match self.scale {
            Scale::Log => {
                let [first, last] = [self.low, self.high].map(|end| end.log10().floor() as i32);
                let powers = |stride: usize| (first..=last).step_by(stride).map(|power| 10_f64.powi(power));
                let all = steps.iter().map(|steps| powers(1).flat_map(|p| steps.iter().map(move |m| m * p)).collect());
                all.chain((2..9).map(|stride| powers(stride).collect())).map(inside).collect()
            }
            Scale::Linear => {
                let power = 10_f64.powf(((self.high - self.low) / 10.0).log10().floor());
                let ticks = |step: f64| (0..40).map(|n| ((self.low / step).ceil() + f64::from(n)) * step).collect();
                [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].map(|m| inside(ticks(m * power))).into()
            }
        }
    }
}

/// An axis with its ticks. plotters' own ticks of a logarithm are whole decades, too few for the spans of these charts.
struct Coordinate {
    positions: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Ranged for Coordinate {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.positions.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.positions.range()
    }
}

/// About how wide a text is, a little more rather than less; fonts differ.
fn width(text: &str) -> i32 {
    (0.54 * FONT * text.chars().count() as f64).ceil() as i32
}

fn style(color: RGBColor) -> TextStyle<'static> {
    // `font-size` in the SVG is plotters' size ÷ 1.24.
    let font = FontDesc::new(FontFamily::Name("Ubuntu"), FONT * 1.24, FontStyle::Normal);
    TextStyle { color: color.to_backend_color(), ..TextStyle::from(font) }
}

fn text(area: &Area<'_>, at: (i32, i32), text: &str, anchor: HPos, color: RGBColor) -> Drawn {
    area.draw(&Text::new(text.to_owned(), at, style(color).pos(Pos::new(anchor, VPos::Center))))
}

/// A mark as an element, in the colour that it has.
fn marked<'a>(at: (i32, i32), mark: Mark) -> DynElement<'a, SVGBackend<'a>, (i32, i32)> {
    let filled = if mark.hollow { colour(mark).stroke_width(4) } else { colour(mark).filled() };
    let corners = |corners: &[(i32, i32)]| corners.iter().map(|&(x, y)| (at.0 + x, at.1 + y)).collect::<Vec<_>>();
    let polygon = |points: Vec<(i32, i32)>| {
        if mark.hollow {
            let ring: Vec<_> = points.iter().chain(&points[..2]).copied().collect();
            PathElement::new(ring, filled).into_dyn()
        } else {
            Polygon::new(points, filled).into_dyn()
        }
    };
    let m = MARK;
    match mark.shape % 5 {
        0 => Circle::new(at, m, filled).into_dyn(),
        1 => polygon(corners(&[(-m, -m), (m, -m), (m, m), (-m, m)])),
        2 => polygon(corners(&[(-m, m), (0, -m - 2), (m, m)])),
        3 => polygon(corners(&[(0, -m - 2), (m + 2, 0), (0, m + 2), (-m - 2, 0)])),
        _ => polygon(corners(&[(-m, -m), (m, -m), (0, m + 2)])),
    }
}

impl Chart {
    /// The drawing.
    pub(crate) fn svg(&self, target: Target<'_>) -> io::Result<String> {
        let wide = !matches!(target, Target::Phone);
        let (head, foot) = if let Target::File { .. } = target { (90, 60) } else { (0, 0) };
        let keys = if self.series.len() > 1 { &self.series[..] } else { &[] };
        // Beside the chart, or above it on a phone.
        let beside = if wide { keys.iter().map(|key| width(&key.name) + 90).max().unwrap_or(0).min(720) } else { 0 };
        let above = if wide || keys.is_empty() { 16 } else { 30 + LINE * keys.len() as i32 };
        let total_width = if wide { 1920 } else { 720 };
        let body = match &self.body {
            Body::Plane { .. } if wide => 820,
            Body::Plane { .. } => 640,
            Body::Rows { rows, .. } => (LINE + 8) * rows.len() as i32 + 110,
        };
        let body = body.max(if wide { LINE * keys.len() as i32 + 120 } else { 0 });
        let size = (total_width, head + above + body + foot);
        let mut svg = String::new();
        let draw = |svg: &mut String| -> Drawn {
            let root = SVGBackend::with_string(svg, (size.0 as u32, size.1 as u32)).into_drawing_area();
            root.fill(&GROUND)?;
            let legend = if wide { (total_width - beside + 30, head + above + 20) } else { (20, 20) };
            for (row, key) in (0..).zip(keys) {
                let at = (legend.0, legend.1 + LINE * row);
                root.draw(&marked(at, key.mark))?;
                text(&root, (at.0 + 28, at.1), &key.name, HPos::Left, TEXT)?;
            }
            let inner = root.margin(head + above, foot, 0, beside);
            match &self.body {
                Body::Plane { y, is_joined } => self.plane(&inner, y, *is_joined, wide)?,
                Body::Rows { rows, is_stacked } => self.rows(&inner, rows, *is_stacked, wide)?,
            }
            if let Target::File { title, origin } = target {
                let heading = FontDesc::new(FontFamily::Name("Ubuntu"), 36.0 * 1.24, FontStyle::Bold);
                let heading = TextStyle::from(heading).color(&TEXT).pos(Pos::new(HPos::Left, VPos::Center));
                root.draw(&Text::new(title.to_owned(), (24, 46), heading))?;
                text(&root, (24, size.1 - 30), origin, HPos::Left, MUTED)?;
            }
            root.present()
        };
        draw(&mut svg).map_err(io::Error::other)?;
        if let Target::File { .. } = target {
            return Ok(svg);
        }
        // The page scales it, and knows what it is.
        let sized = format!("<svg width=\"{}\" height=\"{}\" ", size.0, size.1);
        Ok(svg.replacen(&sized, "<svg ", 1).replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1))
    }

    fn plane(&self, area: &Area<'_>, y: &Axis, is_joined: bool, wide: bool) -> Drawn {
        let (x, (across, down)) = (&self.axis, area.dim_in_pixel());
        let left = if wide { 170 } else { 130 };
        let mut chart = ChartBuilder::on(area)
            .margin_right(30)
            .margin_left(30)
            .margin_top(20)
            .x_label_area_size(100)
            .y_label_area_size(left)
            .build_cartesian_2d(
                x.coordinate(across as i32 - left - 60, |tick| width(tick) + 20),
                y.coordinate(down as i32 - 120, |_| 52),
            )?;
        self.mesh(area, &mut chart, Some(y), [left + 30, 30])?;
        let position = |point: &Point| (x.position(point.x), y.position(point.y));
        let ends = [x.low, x.high].map(|end| x.position(end));
        self.dashed(&chart, |level| ends.map(|end| (end, y.position(level))))?;
        for Series { mark, points, .. } in &self.series {
            let color = colour(*mark);
            if is_joined {
                let line = points.iter().map(position);
                if mark.hollow {
                    chart.draw_series(DashedLineSeries::new(line, 14, 8, color.stroke_width(4)))?;
                } else {
                    chart.draw_series(LineSeries::new(line, color.stroke_width(4)))?;
                }
            }
            let spreads = points.iter().filter(|point| point.quartiles[1] > point.quartiles[0]);
            chart.draw_series(spreads.map(|point| {
                let ends = point.quartiles.map(|end| (x.position(point.x), y.position(end)));
                PathElement::new(ends, color.stroke_width(3))
            }))?;
            for point in points {
                area.draw(&marked(relative(area, &chart, position(point)), *mark))?;
            }
        }
        Ok(())
    }

    fn rows(&self, area: &Area<'_>, rows: &[Bar], is_stacked: bool, wide: bool) -> Drawn {
        let (axis, (across, _)) = (&self.axis, area.dim_in_pixel());
        // On a phone headings lie across the bars.
        let names = rows.iter().filter(|row| wide || !row.is_heading).map(|row| width(&row.name)).max().unwrap_or(0);
        let left = (names + 30).min(across as i32 * 5 / 8);
        let right = rows.iter().map(|row| width(&row.remark)).max().unwrap_or(0) + 40;
        let count = rows.len() as f64;
        let mut chart = ChartBuilder::on(area)
            .margin_right(right)
            .margin_top(10)
            .x_label_area_size(100)
            .y_label_area_size(left)
            .build_cartesian_2d(
                axis.coordinate(across as i32 - left - right, |tick| width(tick) + 20),
                // The first row is at the top.
                Coordinate { positions: (count..0.0).into(), ticks: Vec::new() },
            )?;
        self.mesh(area, &mut chart, None, [left, right])?;
        let at = |value: f64, y: f64| (axis.position(value), y);
        self.dashed(&chart, |level| [0.0, count].map(|y| at(level, y)))?;
        for (row, Bar { name, is_heading, values, remark }) in (0..).map(f64::from).zip(rows) {
            let middle = row + 0.5;
            let (x, y) = relative(area, &chart, at(axis.low, middle));
            let color = if *is_heading { MUTED } else { TEXT };
            let (x, anchor) = if *is_heading && !wide { (8, HPos::Left) } else { (x - 16, HPos::Right) };
            text(area, (x, y), name, anchor, color)?;
            let mut end = 0.0;
            for (Series { mark, .. }, value) in self.series.iter().zip(values) {
                let Some((length, quartiles)) = value else { continue };
                if is_stacked {
                    let corners = [at(end, row + 0.12), at(end + length, row + 0.88)];
                    chart.draw_series([Rectangle::new(corners, colour(*mark).filled())])?;
                    end += length;
                } else {
                    let ends = quartiles.map(|end| at(end, middle));
                    chart.draw_series([PathElement::new(ends, colour(*mark).stroke_width(4))])?;
                    area.draw(&marked(relative(area, &chart, at(*length, middle)), *mark))?;
                }
            }
            if !remark.is_empty() {
                let (x, y) = relative(area, &chart, at(end, middle));
                text(area, (x + 12, y), remark, HPos::Left, MUTED)?;
            }
        }
        Ok(())
    }

    /// The grid with its ticks, and the axes' titles: the horizontal one below its middle, as far as there is room.
    fn mesh(&self, area: &Area<'_>, chart: &mut Plot<'_>, y: Option<&Axis>, [left, right]: [i32; 2]) -> Drawn {
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID.stroke_width(2))
            .axis_style(MUTED.stroke_width(2))
            .label_style(style(MUTED))
            .axis_desc_style(style(TEXT))
            .x_label_formatter(&|position| self.axis.label(*position))
            .y_label_formatter(&|position| y.map_or_else(String::new, |y| y.label(*position)))
            .y_desc(y.map_or("", |y| &y.title))
            .draw()?;
        let (across, down) = area.dim_in_pixel();
        let half = width(&self.axis.title) / 2;
        let middle = i32::midpoint(left, across as i32 - right).min(across as i32 - half).max(half);
        text(area, (middle, down as i32 - 24), &self.axis.title, HPos::Center, TEXT)
    }

    /// The line at the level.
    fn dashed(&self, chart: &Plot<'_>, ends: impl Fn(f64) -> [(f64, f64); 2]) -> Drawn {
        let Some(level) = self.level else { return Ok(()) };
        chart.plotting_area().draw(&DashedPathElement::new(ends(level), 12, 8, MUTED.stroke_width(3)))
    }
}

/// A place of the plot, as the area counts.
fn relative(area: &Area<'_>, chart: &Plot<'_>, position: (f64, f64)) -> (i32, i32) {
    let ((x, y), (left, top)) = (chart.backend_coord(&position), area.get_base_pixel());
    (x - left, y - top)
}

/// A drawing for a file as PNG. Its lengths are pixels already, two of them to a CSS pixel: sharp on screens that have
/// so many.
pub(crate) fn png(svg: &str) -> io::Result<Vec<u8>> {
    let mut options = usvg::Options { font_family: "Ubuntu".to_owned(), ..usvg::Options::default() };
    Arc::make_mut(&mut options.fontdb).load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let tree = usvg::Tree::from_str(svg, &options).map_err(io::Error::other)?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| side.ceil() as u32);
    let mut picture = tiny_skia::Pixmap::new(width, height).ok_or_else(|| io::Error::other("the chart has no size"))?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut picture.as_mut());
    // The ground is opaque, so alpha says nothing.
    let colours: Vec<u8> = picture.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(io::Error::from)?;
    writer.write_image_data(&colours).map_err(io::Error::from)?;
    writer.finish().map_err(io::Error::from)?;
    Ok(bytes)
}

/// A text in HTML.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '"' => escaped.push_str("&quot;"),
            // No letter, and not allowed there.
            c if c.is_control() => {
                let _ = write!(escaped, "\\u{:04x}", u32::from(c));
            }
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(scale: Scale, values: &[f64]) -> Axis {
        Axis::over("", scale, |value| value.to_string(), values.iter().copied())
    }

    #[test]
    fn positions_keep_the_order_and_stay_inside() {
        for scale in [Scale::Linear, Scale::Log] {
            let axis = axis(scale, &[0.001, 5.0, 70.0]);
            assert!(axis.position(0.001) < axis.position(5.0) && axis.position(5.0) < axis.position(70.0));
            for value in [-1.0, 0.0, 1e9, f64::INFINITY] {
                assert!(
                    (axis.position(axis.low)..=axis.position(axis.high)).contains(&axis.position(value)),
                    "{value}"
                );
            }
        }
    }

    #[test]
    fn ticks_are_in_order_and_in_range() {
        for values in [[0.001, 1e6].as_slice(), &[1.0, 1.3], &[3.0], &[], &[f64::NAN, 0.0]] {
            for scale in [Scale::Linear, Scale::Log] {
                for ticks in axis(scale, values).ticks() {
                    assert!(ticks.is_sorted(), "{values:?}: {ticks:?}");
                }
            }
        }
        assert!(axis(Scale::Log, &[1.0, 1e5]).ticks().iter().any(|ticks| ticks.contains(&10.0)));
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("<a\x1b\0&\u{9b}>"), r"&lt;a\u001b\u0000&amp;\u009b&gt;");
    }
}
