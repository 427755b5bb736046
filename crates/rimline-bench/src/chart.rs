//! Charts as SVG: curves and points in a plane, and rows of bars or dots. The caller supplies the data; this module knows
//! nothing of silhouettes. With plotters, axes would be ours in any case, and its calls take more lines than this module.
//!
//! The report's style sheet replaces the colours on a dark ground; PNG files are made of the same SVG.

use std::fmt::Write as _;
use std::io;
use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use crate::row::Mark;

/// Colours of marks, distinct for people who do not see all colours (Okabe and Ito, "Color Universal Design", 2008),
/// for a light and for a dark ground; the dark ones are lifted where the original would sink.
pub(crate) const PALETTE: [[&str; 2]; 8] = [
    ["#D55E00", "#E8793A"],
    ["#B97700", "#E69F00"],
    ["#0072B2", "#4BA3E0"],
    ["#3A93C9", "#8CCBF0"],
    ["#00805F", "#2FC397"],
    ["#B0568C", "#D98BB9"],
    ["#5B5B5B", "#B4B4B4"],
    ["#8A7B00", "#E0D34A"],
];
/// The other colours on a light ground, by the names of the page's CSS variables.
pub(crate) const ROLES: [(&str, &str); 4] = [("text", TEXT), ("muted", MUTED), ("grid", GRID), ("ground", GROUND)];
const TEXT: &str = "#1B1F24";
const MUTED: &str = "#59636E";
const GRID: &str = "#DDE2E7";
const GROUND: &str = "#FFFFFF";

/// Lengths are halves of a CSS pixel, and the pixels of the PNG file.
const FONT: f64 = 26.0;
const LINE: f64 = 36.0;
const MARK: f64 = 10.0;

/// Numbers have room on an axis below this, and on a logarithmic one above its inverse: their ratios are finite.
const MOST: f64 = 1e100;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    Log,
}

#[derive(Clone, Debug)]
pub(crate) struct Axis {
    title: String,
    scale: Scale,
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

/// A row of bars or dots. Without values it is a heading of the rows below.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bar {
    pub(crate) name: String,
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
        for value in values.into_iter().filter(|value| value.abs() < MOST) {
            if scale == Scale::Log && value < 1.0 / MOST {
                has_zero = true;
            } else {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        (low, high) = match scale {
            _ if low > high => (1.0, 10.0),
            Scale::Log => {
                let margin = (high / low).max(2.0).powf(0.07);
                (low / margin, high * margin)
            }
            Scale::Linear => (low.min(0.0), if high > 0.0 { high * 1.08 } else { 1.0 }),
        };
        if has_zero {
            low /= (high / low).max(10.0).powf(0.12);
        }
        Self { title: title.to_owned(), scale, format, low, high, has_zero }
    }

    /// Where a number lies between the ends of the axis.
    fn at(&self, value: f64, [from, to]: [f64; 2]) -> f64 {
        let position = |value: f64| if self.scale == Scale::Log { value.log10() } else { value };
        let [low, at, high] = [self.low, value.clamp(self.low, self.high), self.high].map(position);
        from + (to - from) * (at - low) / (high - low)
    }

    /// Round ticks between the ends, so many as have room: where, and their labels, which take `of_label`.
    fn ticks(&self, ends: [f64; 2], of_label: impl Fn(&str) -> f64) -> Vec<(f64, String)> {
        let labelled = |ticks: Vec<f64>| -> Vec<(f64, String)> {
            ticks.into_iter().map(|tick| (self.at(tick, ends), (self.format)(tick))).collect()
        };
        let fits = |ticks: &Vec<(f64, String)>| {
            let room = |pair: &[(f64, String)]| 0.5 * (of_label(&pair[0].1) + of_label(&pair[1].1));
            ticks.windows(2).all(|pair| (pair[1].0 - pair[0].0).abs() >= room(pair))
        };
        let mut ticks = self.round_numbers().into_iter().map(labelled).find(fits).unwrap_or_default();
        if self.has_zero {
            let room = |label: &str| (0.5 * (of_label("0") + of_label(label))).max(0.1 * (ends[1] - ends[0]).abs());
            ticks.retain(|(at, label)| (at - ends[0]).abs() > room(label));
            ticks.insert(0, (ends[0], "0".to_owned()));
        }
        ticks
    }

    /// Round numbers in the range, the most first.
    fn round_numbers(&self) -> Vec<Vec<f64>> {
        let inside = |ticks: Vec<f64>| ticks.into_iter().filter(|tick| (self.low..=self.high).contains(tick)).collect();
        let steps: [&[f64]; 4] = [&[1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];
        match self.scale {
            // Within little more than an octave lies one number of a decade, or none.
            Scale::Log if self.high > 3.0 * self.low => {
                let [first, last] = [self.low, self.high].map(|end| end.log10().floor() as i32);
                let powers = |stride: usize| (first..=last).step_by(stride).map(|power| 10_f64.powi(power));
                let all = steps.iter().map(|steps| powers(1).flat_map(|p| steps.iter().map(move |m| m * p)).collect());
                all.chain((2..9).map(|stride| powers(stride).collect())).map(inside).collect()
            }
            Scale::Log | Scale::Linear => {
                let power = 10_f64.powf(((self.high - self.low) / 10.0).log10().floor());
                let ticks = |step: f64| (0..40).map(|n| ((self.low / step).ceil() + f64::from(n)) * step).collect();
                [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].map(|m| inside(ticks(m * power))).into()
            }
        }
    }
}

fn width(text: &str) -> f64 {
    (0.54 * FONT * text.chars().count() as f64).ceil()
}

fn text([x, y]: [f64; 2], anchor: &str, text: &str, colour: &str) -> String {
    let text = escape(text);
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" dy=\"0.5ex\" text-anchor=\"{anchor}\" font-size=\"{FONT}\" fill=\"{colour}\">{text}</text>\n"
    )
}

/// A line through points, with more attributes.
fn line(points: impl IntoIterator<Item = [f64; 2]>, colour: &str, width: u32, more: &str) -> String {
    let points: Vec<String> = points.into_iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let points = points.join(" ");
    format!("<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{more}/>\n")
}

const DASHED: &str = " stroke-dasharray=\"12 8\"";

fn colour(mark: Mark) -> &'static str {
    PALETTE[mark.colour % PALETTE.len()][0]
}

fn marked([x, y]: [f64; 2], mark: Mark) -> String {
    let (colour, m) = (colour(mark), MARK);
    let paint = if mark.hollow {
        format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"4\"")
    } else {
        format!("fill=\"{colour}\"")
    };
    let corners = match mark.shape % 5 {
        0 => return format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{m}\" {paint}/>\n"),
        1 => vec![[-m, -m], [m, -m], [m, m], [-m, m]],
        2 => vec![[-m, m], [0.0, -m - 2.0], [m, m]],
        3 => vec![[0.0, -m - 2.0], [m + 2.0, 0.0], [0.0, m + 2.0], [-m - 2.0, 0.0]],
        _ => vec![[-m, -m], [m, -m], [0.0, m + 2.0]],
    };
    let points: Vec<String> = corners.iter().map(|[dx, dy]| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
    format!("<polygon points=\"{}\" {paint}/>\n", points.join(" "))
}

/// From left to right, and from the bottom to the top.
#[derive(Clone, Copy)]
struct Area {
    x: [f64; 2],
    y: [f64; 2],
}

impl Chart {
    pub(crate) fn svg(&self, target: Target<'_>, attributes: &str) -> String {
        let wide = !matches!(target, Target::Phone);
        let (head, foot) = if let Target::File { .. } = target { (90.0, 60.0) } else { (0.0, 0.0) };
        let keys = if self.series.len() > 1 { &self.series[..] } else { &[] };
        let of_keys = LINE * keys.len() as f64;
        // Beside the chart, or above it on a phone.
        let widest = keys.iter().map(|key| width(&key.name) + 90.0).fold(0.0, f64::max);
        let beside = if wide { widest.min(720.0) } else { 0.0 };
        let top = head + if wide || keys.is_empty() { 16.0 } else { 30.0 + of_keys };
        let body = match &self.body {
            Body::Plane { .. } if wide => 820.0,
            // So high that the title beside the plot does not reach the keys above.
            Body::Plane { y, .. } => (width(&y.title) + 120.0).max(640.0),
            Body::Rows { rows, .. } => (LINE + 8.0) * rows.len() as f64 + 110.0,
        };
        let bottom = top + body.max(if wide { of_keys + 120.0 } else { 0.0 });
        let (across, down) = (if wide { 1920.0 } else { 720.0 }, bottom + foot);
        let mut svg = format!(
            "<svg {attributes} viewBox=\"0 0 {across} {down}\">\n<rect width=\"{across}\" height=\"{down}\" fill=\"{GROUND}\"/>\n"
        );
        let [x, mut y] = if wide { [across - beside + 30.0, top + 20.0] } else { [20.0; 2] };
        for key in keys {
            svg += &marked([x, y], key.mark);
            svg += &text([x + 28.0, y], "start", &key.name, TEXT);
            y += LINE;
        }
        let area = Area { x: [0.0, across - beside], y: [bottom, top] };
        match &self.body {
            Body::Plane { y, is_joined } => self.plane(&mut svg, area, y, *is_joined, wide),
            Body::Rows { rows, is_stacked } => self.rows(&mut svg, area, rows, *is_stacked, wide),
        }
        if let Target::File { title, origin } = target {
            let heading = text([24.0, 46.0], "start", title, TEXT);
            svg += &heading.replacen(&format!("\"{FONT}\""), "\"36\" font-weight=\"bold\"", 1);
            svg += &text([24.0, down - 30.0], "start", origin, MUTED);
        }
        svg + "</svg>\n"
    }

    fn plane(&self, svg: &mut String, area: Area, y: &Axis, is_joined: bool, wide: bool) {
        let left = if wide { 200.0 } else { 160.0 };
        let plot = Area { x: [left, area.x[1] - 30.0], y: [area.y[0] - 100.0, area.y[1] + 20.0] };
        self.grid(svg, area, plot, Some(y));
        let at = |x: f64, of_y: f64| [self.axis.at(x, plot.x), y.at(of_y, plot.y)];
        if let Some(level) = self.level {
            *svg += &line(plot.x.map(|x| [x, y.at(level, plot.y)]), MUTED, 3, DASHED);
        }
        for Series { mark, points, .. } in &self.series {
            let colour = colour(*mark);
            let points = || points.iter().filter(|point| point.x.is_finite() && point.y.is_finite());
            if is_joined {
                let dashes = if mark.hollow { DASHED } else { "" };
                *svg += &line(points().map(|point| at(point.x, point.y)), colour, 4, dashes);
            }
            for Point { x, y, quartiles } in points() {
                if quartiles[0] < quartiles[1] {
                    *svg += &line(quartiles.map(|end| at(*x, end)), colour, 3, "");
                }
                *svg += &marked(at(*x, *y), *mark);
            }
        }
    }

    fn rows(&self, svg: &mut String, area: Area, rows: &[Bar], is_stacked: bool, wide: bool) {
        // On a phone headings lie across the bars.
        let named = rows.iter().filter(|row| wide || !row.values.is_empty());
        let left = (named.map(|row| width(&row.name)).fold(0.0, f64::max) + 30.0).min(area.x[1] * 5.0 / 8.0);
        let right = rows.iter().map(|row| width(&row.remark)).fold(0.0, f64::max) + 40.0;
        let plot = Area { x: [left, area.x[1] - right], y: [area.y[0] - 100.0, area.y[1] + 10.0] };
        self.grid(svg, area, plot, None);
        let at = |value: f64| self.axis.at(value, plot.x);
        if let Some(level) = self.level {
            *svg += &line(plot.y.map(|y| [at(level), y]), MUTED, 3, DASHED);
        }
        let height = (plot.y[0] - plot.y[1]) / rows.len() as f64;
        for (row, Bar { name, values, remark }) in rows.iter().enumerate() {
            let y = plot.y[1] + height * (row as f64 + 0.5);
            let color = if values.is_empty() { MUTED } else { TEXT };
            let is_across = values.is_empty() && !wide;
            let (x, anchor) = if is_across { (8.0, "start") } else { (left - 16.0, "end") };
            *svg += &text([x, y], anchor, name, color);
            let mut end = 0.0;
            for (Series { mark, .. }, value) in self.series.iter().zip(values) {
                let Some((length, quartiles)) = value.filter(|(length, _)| length.is_finite()) else { continue };
                if is_stacked {
                    let (from, to) = (at(end), at(end + length));
                    let (top, of_bar, color) = (y - 0.38 * height, 0.76 * height, colour(*mark));
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{of_bar:.1}\" fill=\"{color}\"/>",
                        to - from
                    );
                    end += length;
                } else {
                    if quartiles[0] < quartiles[1] {
                        *svg += &line(quartiles.map(|end| [at(end), y]), colour(*mark), 4, "");
                    }
                    *svg += &marked([at(length), y], *mark);
                }
            }
            if !remark.is_empty() {
                *svg += &text([at(end) + 12.0, y], "start", remark, MUTED);
            }
        }
    }

    /// The grid with its ticks, and the axes' titles: the horizontal one below its middle, if there is room.
    fn grid(&self, svg: &mut String, area: Area, plot: Area, y: Option<&Axis>) {
        let [left, bottom] = [plot.x[0], plot.y[0]];
        for (x, label) in self.axis.ticks(plot.x, |label| width(label) + 20.0) {
            *svg += &line(plot.y.map(|y| [x, y]), GRID, 2, "");
            *svg += &text([x, bottom + 28.0], "middle", &label, MUTED);
        }
        for (y, label) in y.into_iter().flat_map(|axis| axis.ticks(plot.y, |_| 52.0)) {
            *svg += &line(plot.x.map(|x| [x, y]), GRID, 2, "");
            *svg += &text([left - 14.0, y], "end", &label, MUTED);
        }
        *svg += &line([[left, plot.y[1]], [left, bottom], [plot.x[1], bottom]], MUTED, 2, "");
        let half = 0.5 * width(&self.axis.title);
        let middle = f64::midpoint(left, plot.x[1]).min(area.x[1] - half).max(half);
        *svg += &text([middle, area.y[0] - 24.0], "middle", &self.axis.title, TEXT);
        if let Some(axis) = y {
            let title = text([0.0; 2], "middle", &axis.title, TEXT);
            let turn =
                format!("<text transform=\"translate(34 {:.1}) rotate(-90)\"", f64::midpoint(plot.y[0], plot.y[1]));
            *svg += &title.replacen("<text", &turn, 1);
        }
    }
}

/// A drawing for a file as PNG, sharp on screens with two pixels to a CSS pixel.
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

pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '"' => escaped.push_str("&quot;"),
            // No letter, and not allowed there.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {
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

    #[test]
    fn positions_stay_inside_and_ticks_are_in_order() {
        for values in
            [[0.001, 1e6].as_slice(), &[1.0, 1.3], &[3.0], &[], &[f64::NAN, 0.0], &[0.001, 5.0, 70.0], &[1e-300, 1e300]]
        {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = Axis::over("", scale, |value| value.to_string(), values.iter().copied());
                let at = [-1.0, 0.0, 0.001, 5.0, 70.0, 1e9, f64::INFINITY].map(|value| axis.at(value, [10.0, 20.0]));
                assert!(at.is_sorted() && at[0] >= 10.0 && at[6] < 20.0 + 1e-9, "{values:?}: {at:?}");
                for ticks in axis.round_numbers() {
                    assert!(ticks.is_sorted(), "{values:?}: {ticks:?}");
                }
            }
        }
        let axis = Axis::over("", Scale::Log, |value| value.to_string(), [1.0, 1e5]);
        assert!(axis.round_numbers().iter().any(|ticks| ticks.contains(&10.0)));
        assert!(axis.at(5.0, [0.0, 1.0]) < axis.at(70.0, [0.0, 1.0]));
    }

    fn axis(scale: Scale, values: &[f64]) -> Axis {
        Axis::over("", scale, crate::text::tick, values.iter().copied())
    }

    #[test]
    fn ticks_differ_and_do_not_touch() {
        let short = [[2.1, 2.3].as_slice(), &[8.0, 9.0], &[3.0], &[2.1e-5, 2.3e-5], &[-3.0, -2.9], &[0.0, 2.1]];
        let long = [[0.0, 4e-5, 3e5].as_slice(), &[4e-4, 2e-3], &[0.0, 1e-5, 1e-4]];
        let of_label = |label: &str| width(label) + 20.0;
        for (values, scale) in short.iter().chain(&long).flat_map(|&v| [(v, Scale::Linear), (v, Scale::Log)]) {
            for ends in [[160.0, 690.0], [200.0, 1500.0]] {
                let ticks = axis(scale, values).ticks(ends, of_label);
                assert!(ticks.len() > 1, "{values:?}, {scale:?}: {ticks:?}");
                for pair in ticks.windows(2) {
                    let room = 0.5 * (of_label(&pair[0].1) + of_label(&pair[1].1));
                    let is_apart = pair[1].0 - pair[0].0 >= room && pair[0].1 != pair[1].1;
                    assert!(is_apart, "{values:?}, {scale:?}: {ticks:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let values = [1.0, f64::NAN, 5.0, f64::INFINITY, f64::NEG_INFINITY];
        let points: Vec<Point> = values.map(|y| Point { x: 2.0, y, quartiles: [f64::NAN, y] }).into();
        let rows: Vec<Bar> =
            values.map(|length| Bar { values: vec![Some((length, [f64::NAN; 2]))], ..Bar::default() }).into();
        let plane = Body::Plane { y: axis(Scale::Log, &values), is_joined: true };
        let dots = Body::Rows { rows: rows.clone(), is_stacked: false };
        // The ground is a rectangle, too.
        for (body, shape, count) in
            [(plane, "<circle", 2), (dots, "<circle", 2), (Body::Rows { rows, is_stacked: true }, "<rect", 3)]
        {
            let mark = Mark { colour: 0, shape: 0, hollow: false };
            let series = vec![Series { name: String::new(), mark, points: points.clone() }];
            let chart = Chart { axis: axis(Scale::Log, &values), series, body, level: None };
            let svg = chart.svg(Target::Phone, "");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            assert_eq!(svg.matches(shape).count(), count, "{svg}");
        }
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("<a\x1b\0&\u{9b}\u{ffff}>"), r"&lt;a\u001b\u0000&amp;\u009b\uffff&gt;");
    }
}
