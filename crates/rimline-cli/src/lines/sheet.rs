//! The page: where lines are on it, in millimetres.

use std::collections::HashMap;
use std::path::PathBuf;

use rimline_lines::{Chain, Drawing, LineClass, Object, PageBox, View};

use super::args::{Hidden, LinesArgs, Paper, Scale, Unit};
use super::eye::Eye;
use super::style::{Pen, Style};
use crate::coincident::is_finite;
use crate::failure::Failure;
use crate::output::{Line, counted};

const MARGIN_MM: f64 = 10.0;
/// The largest drawing; more would be a wrong scale.
const LARGEST_MM: f64 = 100_000.0;

/// Lines that lie on the page, by layers. With `units`, `size_mm` is in the unit of the files and `mm_per_unit` is 1; pens stay
/// in millimetres.
pub(crate) struct Sheet {
    pub(crate) size_mm: [f64; 2],
    pub(crate) mm_per_unit: f64,
    /// Units of a drawing in the unit of the files.
    pub(crate) units: Option<Units>,
    pub(crate) remarks: Vec<String>,
    /// The point of the view's page that is at the lower left corner.
    corner: [f64; 2],
    pub(crate) layers: Vec<Layer>,
}

/// How a drawing is measured in the unit of the files.
pub(crate) struct Units {
    /// The corners of a rectangle around all lines.
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    /// Units a millimetre of the page on which the drawing would be.
    pub(crate) per_mm: f64,
    /// Decimals of coordinates.
    pub(crate) decimals: i32,
}

pub(crate) struct Layer {
    pub(crate) class: LineClass,
    pub(crate) is_hidden: bool,
    pub(crate) pen: Pen,
    pub(crate) lines: Vec<Polyline>,
}

pub(crate) struct Polyline {
    pub(crate) object: u32,
    /// Whole micrometres from the lower left corner; in the unit of the files, in steps of its last decimal.
    pub(crate) points: Vec<[i64; 2]>,
    pub(crate) is_closed: bool,
}

impl Layer {
    pub(crate) fn name(&self) -> String {
        format!("{}-{}", self.class.name(), if self.is_hidden { "hidden" } else { "visible" })
    }
}

impl Sheet {
    pub(crate) fn new(
        args: &LinesArgs,
        style: &Style,
        drawing: &Drawing,
        bounds: PageBox,
        units: Option<[f64; 2]>,
    ) -> Result<Self, Failure> {
        let mut remarks = Vec::new();
        let size = [0, 1].map(|axis| bounds.high[axis] - bounds.low[axis]);
        let paper = args.page.unwrap_or(Paper::A4);
        let mut size_mm = turned(paper, size);
        let room = within_margin(size_mm);
        let mm_per_unit = match args.scale {
            Scale::Ratio { page, model } => args.unit.unwrap_or(Unit::M).facts().0 * page / model,
            Scale::Fit => {
                let fits = [0, 1].map(|axis| room[axis] / size[axis]).into_iter().fold(f64::INFINITY, f64::min);
                if fits.is_finite() { fits } else { 1.0 }
            }
        };
        let needed = size.map(|side| side * mm_per_unit);
        if let Some(offset) = units {
            return Ok(Self::in_units(bounds, offset, mm_per_unit).drawn(args, style, drawing));
        }
        if !needed.into_iter().all(|side| side <= LARGEST_MM) {
            let [width, height] = needed.map(short);
            return Err(Failure::usage(format!(
                "at this scale the drawing takes {width}x{height} mm, and at most 100 m each way are drawn; give \
                 a smaller --scale"
            )));
        }
        if args.scale != Scale::Fit {
            if args.page.is_none() {
                size_mm = needed.map(|side| libm::ceil(side + 2.0 * MARGIN_MM));
            } else if needed[0] > size_mm[0] || needed[1] > size_mm[1] {
                let [width, height] = size_mm;
                let [wide, high] = needed.map(libm::ceil);
                remarks.push(format!(
                    "warning: the drawing takes {wide}x{high} mm, more than the page of {width}x{height} mm; give a \
                     smaller --scale or a larger --page"
                ));
            }
        }
        let corner =
            [0, 1].map(|axis| 0.5 * (bounds.low[axis] + bounds.high[axis]) - 0.5 * size_mm[axis] / mm_per_unit);
        let sheet = Self { size_mm, mm_per_unit, units: None, remarks, corner, layers: Vec::new() };
        Ok(sheet.drawn(args, style, drawing))
    }

    /// A drawing in the unit of the files, with their coordinates: `offset` is what the page's lack. On a page it would
    /// have this scale.
    fn in_units(bounds: PageBox, offset: [f64; 2], mm_per_unit: f64) -> Self {
        let [low, high] = [bounds.low, bounds.high].map(|corner| [0, 1].map(|axis| corner[axis] + offset[axis]));
        let largest = low.into_iter().chain(high).fold(f64::MIN_POSITIVE, |largest, c| largest.max(c.abs()));
        // Ten digits, which `f32` does not have.
        let decimals = 9 - libm::floor(libm::log10(largest)) as i32;
        let units = Units { low, high, per_mm: 1.0 / mm_per_unit, decimals };
        let (units, remarks, layers) = (Some(units), Vec::new(), Vec::new());
        let size_mm = [0, 1].map(|axis| high[axis] - low[axis]);
        Self { size_mm, mm_per_unit: 1.0, units, remarks, corner: offset.map(|c| -c), layers }
    }

    /// With the lines of a drawing.
    fn drawn(mut self, args: &LinesArgs, style: &Style, drawing: &Drawing) -> Self {
        for is_hidden in [true, false] {
            for class in LineClass::ALL.into_iter().rev().filter(|_| !is_hidden || args.hidden != Hidden::None) {
                let chains = drawing.chains.iter().filter(|chain| (chain.class, chain.is_hidden) == (class, is_hidden));
                let lines: Vec<_> = chains.filter_map(|chain| self.polyline(drawing, chain)).collect();
                if !lines.is_empty() {
                    let pen = style.pen(class, is_hidden, args.hidden);
                    self.layers.push(Layer { class, is_hidden, pen, lines });
                }
            }
        }
        if self.layers.is_empty() && !drawing.chains.is_empty() {
            self.remarks.push("warning: all lines are hidden, or shorter than a micrometre at this scale".to_owned());
        }
        self
    }

    /// Whether a fifth of the visible lines, by length, is where ink covers most of the page, so that lines clot.
    pub(crate) fn is_crowded(&self) -> bool {
        const CELL_UM: i64 = 2000;
        if self.units.is_some() {
            return false;
        }
        // By cells of the page: length in nanometres and ink in square micrometres. Sums of integers need no order.
        let mut cells: HashMap<[i64; 2], [u64; 2]> = HashMap::new();
        for layer in self.layers.iter().filter(|layer| !layer.is_hidden) {
            for line in &layer.lines {
                let last = line.is_closed.then(|| [line.points[line.points.len() - 1], line.points[0]]);
                let segments = line.points.windows(2).map(|pair| [pair[0], pair[1]]).chain(last);
                for [from, to] in segments {
                    let [dx, dy] = [0, 1].map(|axis| (to[axis] - from[axis]) as f64);
                    let length = (dx * dx + dy * dy).sqrt();
                    let steps = libm::ceil(length / 100.0).clamp(1.0, 1000.0);
                    let part = length / steps;
                    for step in 0..steps as u32 {
                        let along = (f64::from(step) + 0.5) / steps;
                        let at = [(0, dx), (1, dy)].map(|(axis, by)| from[axis] + (along * by) as i64);
                        let cell = cells.entry(at.map(|um| um.div_euclid(CELL_UM))).or_default();
                        cell[0] += (1000.0 * part) as u64;
                        cell[1] += (1000.0 * part * layer.pen.width_mm) as u64;
                    }
                }
            }
        }
        let all: u64 = cells.values().map(|[length, _]| length).sum();
        let crowded = cells.values().filter(|[_, ink]| 10 * ink > 6 * (CELL_UM * CELL_UM) as u64);
        5 * crowded.map(|[length, _]| length).sum::<u64>() > all
    }

    /// A point of the view's page in millimetres from the lower left corner.
    pub(crate) fn to_mm(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (point[axis] - self.corner[axis]) * self.mm_per_unit)
    }

    /// `None` for what is shorter than a micrometre.
    fn polyline(&self, drawing: &Drawing, chain: &Chain) -> Option<Polyline> {
        let object = drawing.spans.get(chain.spans.start)?.object;
        let steps = power_of_ten(self.units.as_ref().map_or(3, |units| units.decimals));
        let whole = |point: [f64; 2]| self.to_mm(point).map(|length| libm::round(steps * length) as i64);
        let mut points: Vec<[i64; 2]> = drawing.page_points(chain).into_iter().map(whole).collect();
        points.dedup();
        if chain.is_closed && points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        (points.len() > 1).then_some(Polyline { object, points, is_closed: chain.is_closed })
    }

    pub(crate) fn scale_said(&self, args: &LinesArgs, is_perspective: bool) -> String {
        match (args.scale, &self.units) {
            (_, Some(_)) => "1:1 in the unit of the files".to_owned(),
            (Scale::Ratio { page, model }, _) => {
                format!("scale {page}:{model}, a unit taken as {}", args.unit.unwrap_or(Unit::M).facts().1)
            }
            (Scale::Fit, _) if is_perspective => "fitted to the page".to_owned(),
            (Scale::Fit, _) => format!("fitted to the page: a unit is {} mm", short(self.mm_per_unit)),
        }
    }

    /// A line for the user that says how much was drawn, in the first file or in all from it to the last.
    pub(crate) fn said(&self, args: &LinesArgs, is_perspective: bool, files: [&PathBuf; 2]) -> String {
        let scale = self.scale_said(args, is_perspective);
        let page = match &self.units {
            Some(_) => String::new(),
            None => format!("on {}x{} mm, ", self.size_mm[0], self.size_mm[1]),
        };
        let [first, last] = files.map(|file| Line(file.display()).to_string());
        if let Some(frames) = args.frames.filter(|_| first != last) {
            return format!("wrote {frames} drawings, {first} to {last}, {page}{scale}\n");
        }
        let lines = |is_hidden: bool, what: &str| {
            let layers = self.layers.iter().filter(|layer| layer.is_hidden == is_hidden);
            counted(layers.map(|layer| layer.lines.len()).sum(), what)
        };
        let hidden = match args.hidden {
            Hidden::None => String::new(),
            _ => format!(" and {}", lines(true, "hidden line")),
        };
        let gap = if page.is_empty() { ", " } else { " " };
        format!("wrote {first}: {}{hidden}{gap}{page}{scale}\n", lines(false, "line"))
    }
}

/// The part of the view's page from which lines are taken. An eye within a model sees lines at any angle, so there is a
/// limit.
pub(crate) fn taken(args: &LinesArgs, eye: &Eye) -> Option<PageBox> {
    const MOST: f64 = 1.19; // The tangent of 50 degrees.
    let most = PageBox { low: [-MOST; 2], high: [MOST; 2] };
    window(args, eye).or_else(|| args.eye.filter(|_| !args.ortho).map(|_| most))
}

/// The part of the view's page that the options ask for: as high as a field of view, and as wide as the page within its border.
fn window(args: &LinesArgs, eye: &Eye) -> Option<PageBox> {
    let [width_mm, height_mm] = within_margin(turned(args.page.unwrap_or(Paper::A4), [2.0, 1.0]));
    eye.window(width_mm / height_mm)
}

/// The part of a page within its margin, which is narrower on small pages.
fn within_margin(size_mm: [f64; 2]) -> [f64; 2] {
    size_mm.map(|side| (side - 2.0 * MARGIN_MM).max(0.5 * side))
}

/// Width and height of a page for a drawing of this size.
fn turned(paper: Paper, [width, height]: [f64; 2]) -> [f64; 2] {
    match paper {
        Paper::Turned([short, long]) if width > height => [long, short],
        Paper::Given(size) | Paper::Turned(size) => size,
    }
}

/// The rectangle of the page around the faces of objects, whether lines are drawn of them or not, as far as lines are taken.
#[derive(Default)]
pub(crate) struct Extent(Option<PageBox>);

impl Extent {
    /// Adds objects as an eye sees them.
    pub(crate) fn add(&mut self, args: &LinesArgs, eye: &Eye, objects: &[Object<'_>]) {
        let view = &eye.view;
        let are_finite =
            |object: &&Object<'_>| object.mesh.faces().iter().all(|face| is_finite(&object.positions, face));
        let is_face = |[a, b, c]: &&[u32; 3]| a != b && b != c && c != a;
        let faces = || {
            objects.iter().filter(are_finite).flat_map(|object| {
                let faces = object.mesh.faces().iter().filter(is_face);
                faces.map(move |face| face.map(|vertex| object.positions[vertex as usize].map(f64::from)))
            })
        };
        let near = if view.is_perspective() {
            // Lines begin this way by default.
            1e-3 * faces().flatten().map(|point| view.depth(point)).fold(0.0, f64::max)
        } else {
            f64::NEG_INFINITY
        };
        let most = taken(args, eye);
        for face in faces() {
            let points = beyond(face, near, view).map(|point| view.page(point));
            let Some(around) = points.map(|point| PageBox { low: point, high: point }).reduce(join) else { continue };
            let part = most.map_or(around, |most| PageBox {
                low: [0, 1].map(|axis| around.low[axis].max(most.low[axis])),
                high: [0, 1].map(|axis| around.high[axis].min(most.high[axis])),
            });
            if (0..2).all(|axis| part.low[axis] <= part.high[axis]) {
                self.0 = Some(self.0.map_or(part, |before| join(before, part)));
            }
        }
    }

    /// The part of the view's page that is drawn: what the options say, or all.
    pub(crate) fn window(&self, args: &LinesArgs, eye: &Eye) -> PageBox {
        // A drawing of nothing has the origin in its middle.
        window(args, eye).or(self.0).unwrap_or(PageBox { low: [0.0; 2], high: [0.0; 2] })
    }
}

/// The corners of the part of a face that is at least so far ahead of the eye.
fn beyond(face: [[f64; 3]; 3], near: f64, view: &View) -> impl Iterator<Item = [f64; 3]> {
    let depths = face.map(|corner| view.depth(corner));
    (0..3).flat_map(move |at| {
        let next = (at + 1) % 3;
        let corner = (depths[at] >= near).then_some(face[at]);
        let is_crossing = (depths[at] >= near) != (depths[next] >= near);
        let crossing = is_crossing.then(|| {
            let share = (near - depths[at]) / (depths[next] - depths[at]);
            [0, 1, 2].map(|axis| face[at][axis] + share * (face[next][axis] - face[at][axis]))
        });
        corner.into_iter().chain(crossing)
    })
}

fn join(one: PageBox, other: PageBox) -> PageBox {
    PageBox {
        low: [0, 1].map(|axis| one.low[axis].min(other.low[axis])),
        high: [0, 1].map(|axis| one.high[axis].max(other.high[axis])),
    }
}

/// The nearest number to a power of ten.
fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::INFINITY)
}

/// A number with four digits that count.
fn short(number: f64) -> String {
    if !(1e-4..1e7).contains(&number.abs()) {
        return format!("{number:.3e}");
    }
    let digits = (3.0 - libm::floor(libm::log10(number.abs().max(f64::MIN_POSITIVE)))).clamp(0.0, 9.0) as usize;
    format!("{number:.digits$}")
}
