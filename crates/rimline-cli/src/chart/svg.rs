//! The drawing that every plot begins with: plotters' SVG backend, colours, text, marks and the legend.
//!
//! Lengths are halves of a CSS pixel, since plotters places shapes on whole numbers; they are the pixels of the PNG file.

use std::fmt::Write as _;
use std::io;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Coordinate;
pub(super) use super::text_width::{NORMAL, SMALL, text_width, wrapped};
use super::{Key, Target};
use crate::shown;

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<io::Error>>;

/// Colours of keys, told apart by people who do not see all colours (Okabe and Ito, "Color Universal Design", 2008),
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
pub(crate) const ROLES: [(&str, u32); 6] = [
    ("text", 0x1B_1F24),
    ("muted", 0x59_636E),
    ("grid", 0xDD_E2E7),
    ("ground", 0xFF_FFFF),
    ("band", 0xED_F5F0),
    ("link", 0xB9_C2CB),
];

/// A colour by its role; the first ones in the order of [`ROLES`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ink {
    Text,
    Muted,
    Grid,
    Ground,
    Band,
    Link,
    Key(usize),
}

impl Ink {
    pub(super) fn rgb(self) -> RGBColor {
        let role = match self {
            Self::Text => 0,
            Self::Muted => 1,
            Self::Grid => 2,
            Self::Ground => 3,
            Self::Band => 4,
            Self::Link => 5,
            Self::Key(index) => return rgb(PALETTE[index % PALETTE.len()].0),
        };
        rgb(ROLES[role].1)
    }

    pub(super) fn stroke(self, width: u32) -> ShapeStyle {
        self.rgb().stroke_width(width)
    }
}

fn rgb(hex: u32) -> RGBColor {
    RGBColor((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// A bar or line of text in a list.
pub(super) const LINE: i32 = 34;

/// Where a text's given point is; vertically it is the middle.
pub(super) const START: HPos = HPos::Left;
pub(super) const MIDDLE: HPos = HPos::Center;
pub(super) const END: HPos = HPos::Right;

/// A text's look.
#[derive(Clone, Copy)]
pub(super) struct Label {
    pub(super) size: f64,
    pub(super) ink: Ink,
    pub(super) bold: bool,
    pub(super) anchor: HPos,
}

pub(super) const TICK: Label = Label { size: SMALL, ink: Ink::Muted, bold: false, anchor: MIDDLE };
pub(super) const NAME: Label = Label { size: NORMAL, ink: Ink::Text, bold: false, anchor: START };

impl Label {
    /// `font-size` in the SVG is plotters' size ÷ 1.24.
    pub(super) fn style(self) -> TextStyle<'static> {
        let weight = if self.bold { FontStyle::Bold } else { FontStyle::Normal };
        let font = FontDesc::new(FontFamily::Name("Ubuntu"), self.size * 1.24, weight);
        let (color, pos) = (self.ink.rgb().to_backend_color(), Pos::new(self.anchor, VPos::Center));
        TextStyle { color, pos, ..TextStyle::from(font) }
    }

    pub(super) fn draw(self, area: &Area<'_>, at: (i32, i32), text: &str) -> Drawn {
        if text.is_empty() { Ok(()) } else { area.draw(&Text::new(text.to_owned(), at, self.style())) }
    }
}

/// How wide a plot is drawn: for a page on a wide screen and for files, or for a phone.
pub(super) fn width(target: Target<'_>) -> i32 {
    if target.is_narrow() { 692 } else { 1920 }
}

/// Tooltips: areas of the drawing with their texts.
#[derive(Debug, Default)]
pub(super) struct Tips(Vec<([i32; 4], String)>);

impl Tips {
    pub(super) fn at(&mut self, (x, y): (i32, i32), tip: &str) {
        self.over((x - 16, y - 16), (x + 16, y + 16), tip);
    }

    pub(super) fn over(&mut self, low: (i32, i32), high: (i32, i32), tip: &str) {
        self.0.push(([low.0, low.1, high.0, high.1], tip.to_owned()));
    }

    /// Transparent shapes on top of everything; plotters has no titles.
    fn svg(&self) -> String {
        let mut svg = String::new();
        for ([left, top, right, bottom], tip) in self.0.iter().filter(|(_, tip)| !tip.is_empty()) {
            let (width, height) = (right - left, bottom - top);
            let _ = writeln!(
                svg,
                "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" \
                 pointer-events=\"all\"><title>{}</title></rect>",
                escape(tip)
            );
        }
        svg
    }
}

/// A drawing of this height, heading and last line of a file not counted. `paint` gets the area between those.
pub(super) fn drawing(
    target: Target<'_>,
    height: i32,
    paint: impl FnOnce(&Area<'_>, &mut Tips) -> Drawn,
) -> io::Result<String> {
    const HEADING: i32 = 92;
    const ORIGIN: i32 = 60;
    let mut svg = String::new();
    let mut tips = Tips::default();
    let width = width(target);
    let paint_all = |svg: &mut String, tips: &mut Tips| -> Drawn {
        let Target::File { title, origin } = target else {
            let root = SVGBackend::with_string(svg, (width as u32, height as u32)).into_drawing_area();
            paint(&root, tips)?;
            return root.present();
        };
        let size = (width as u32, (height + HEADING + ORIGIN) as u32);
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        root.fill(&Ink::Ground.rgb())?;
        Label { size: 38.0, bold: true, ..NAME }.draw(&root, (36, 54), title)?;
        Label { anchor: START, ..TICK }.draw(&root, (36, HEADING + height + 24), origin)?;
        paint(&root.margin(HEADING, ORIGIN, 0, 0), tips)?;
        root.present()
    };
    paint_all(&mut svg, &mut tips).map_err(io::Error::other)?;
    if let Target::File { .. } = target {
        return Ok(svg.replacen(">\n", &format!(">\n<style>{}</style>\n", weights()), 1));
    }
    // HTML knows what an svg element is, and its style gives it a width.
    let svg = svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1);
    Ok(if let Target::Page = target { svg.replacen("</svg>", &format!("{}</svg>", tips.svg()), 1) } else { svg })
}

/// The files' only font has one weight, a thin one; an outline in a text's colour makes it bolder.
fn weights() -> String {
    let mut css = "text { stroke-width: 0.3px } text[font-weight=\"bold\"] { stroke-width: 1px }".to_owned();
    for hex in ROLES.iter().map(|role| role.1).chain(PALETTE.map(|colours| colours.0)) {
        let _ = write!(css, " text[fill=\"#{hex:06X}\"] {{ stroke: #{hex:06X} }}");
    }
    css
}

/// A key's mark.
pub(super) fn mark(area: &Area<'_>, (x, y): (i32, i32), key: &Key, size: f64) -> Drawn {
    let ink = Ink::Key(key.colour);
    let corners: &[[f64; 2]] = match key.shape % 5 {
        0 => {
            let radius = size.round() as i32;
            if key.hollow {
                return area.draw(&Circle::new((x, y), radius, ink.stroke(4)));
            }
            area.draw(&Circle::new((x, y), radius + 2, Ink::Ground.rgb().filled()))?;
            return area.draw(&Circle::new((x, y), radius, ink.rgb().filled()));
        }
        1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        2 => &[[0.0, -1.25], [1.15, 0.85], [-1.15, 0.85]],
        3 => &[[0.0, -1.35], [1.35, 0.0], [0.0, 1.35], [-1.35, 0.0]],
        _ => &[[0.0, 1.25], [1.15, -0.85], [-1.15, -0.85]],
    };
    let outline = |size: f64| -> Vec<(i32, i32)> {
        let at = |[dx, dy]: [f64; 2]| (x + (dx * size).round() as i32, y + (dy * size).round() as i32);
        corners.iter().map(|&corner| at(corner)).collect()
    };
    if key.hollow {
        return closed(area, outline(size), ink.stroke(4));
    }
    area.draw(&Polygon::new(outline(size + 3.0), Ink::Ground.rgb().filled()))?;
    area.draw(&Polygon::new(outline(size), ink.rgb().filled()))
}

/// The outline of a polygon.
pub(super) fn closed(area: &Area<'_>, mut corners: Vec<(i32, i32)>, style: ShapeStyle) -> Drawn {
    corners.extend(corners.first().copied().into_iter().chain(corners.get(1).copied()).collect::<Vec<_>>());
    area.draw(&PathElement::new(corners, style))
}

/// A path that is dashed or not.
pub(super) fn path(area: &Area<'_>, points: &[(i32, i32)], style: ShapeStyle, dash: Option<[i32; 2]>) -> Drawn {
    match dash {
        Some([dash, gap]) => area.draw(&DashedPathElement::new(points.iter().copied(), dash, gap, style)),
        None => area.draw(&PathElement::new(points.to_vec(), style)),
    }
}

/// Keys with their names in rows.
pub(super) struct Legend<'a> {
    places: Vec<((i32, i32), &'a Key)>,
    /// Height of the legend, with the space below it.
    pub(super) height: i32,
}

impl<'a> Legend<'a> {
    pub(super) fn new(keys: impl IntoIterator<Item = &'a Key>, left: i32, right: i32) -> Self {
        const STEP: i32 = 44;
        let (mut x, mut y) = (left, 30);
        let mut places = Vec::new();
        for key in keys {
            let width = 40 + text_width(&key.name, NORMAL) + 40;
            if x + width - 40 > right && x > left {
                (x, y) = (left, y + STEP);
            }
            places.push(((x, y), key));
            x += width;
        }
        let height = if places.is_empty() { 0 } else { y + 40 };
        Self { places, height }
    }

    pub(super) fn draw(&self, area: &Area<'_>) -> Drawn {
        for &((x, y), key) in &self.places {
            mark(area, (x + 12, y), key, 11.0)?;
            NAME.draw(area, (x + 36, y), &key.name)?;
        }
        Ok(())
    }
}

/// Text as it stands in XML and HTML.
pub(crate) fn escape(text: &str) -> String {
    shown::Text(text).to_string().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Axes with a grid, whose places are asked for.
pub(super) struct Plotted<'a> {
    chart: ChartContext<'a, SVGBackend<'a>, Cartesian2d<Coordinate, Coordinate>>,
    base: (i32, i32),
}

/// Height of a horizontal axis' numbers.
pub(super) const NUMBERS: i32 = 62;

impl<'a> Plotted<'a> {
    /// The grid over a part of `area`, numbers of the y axis in `left` pixels of it and those of the x axis below where
    /// `has_numbers` says so. `corner` is the grid's upper left corner.
    pub(super) fn new(
        area: &Area<'a>,
        corner: (i32, i32),
        [width, height]: [i32; 2],
        [x, y]: [Coordinate; 2],
        [left, below]: [i32; 2],
    ) -> Drawn<Self> {
        let part = area.clone().shrink((corner.0 - left, corner.1), (width + left, height + below));
        let mut chart =
            ChartBuilder::on(&part).y_label_area_size(left).x_label_area_size(below).build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(Ink::Grid.stroke(2))
            .axis_style(Ink::Muted.stroke(2))
            .label_style(TICK.style())
            .set_all_tick_mark_size(8)
            .draw()?;
        Ok(Self { chart, base: area.get_base_pixel() })
    }

    /// Where a pair of numbers is in the area.
    pub(super) fn at(&self, x: f64, y: f64) -> (i32, i32) {
        let (x, y) = self.chart.backend_coord(&(x, y));
        (x - self.base.0, y - self.base.1)
    }
}

/// Lines of text below each other, the first one at a point.
pub(super) fn lines(area: &Area<'_>, label: Label, (x, y): (i32, i32), texts: &[String]) -> Drawn {
    (0..).zip(texts).try_for_each(|(line, text)| label.draw(area, (x, y + line * LINE), text))
}

/// A text that runs upwards, its middle at a point.
pub(super) fn upright(area: &Area<'_>, at: (i32, i32), text: &str) -> Drawn {
    let style = Label { anchor: MIDDLE, ..NAME }.style().transform(FontTransform::Rotate270);
    area.draw(&Text::new(text.to_owned(), at, style))
}
