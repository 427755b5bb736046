//! The page: where lines are on it, in millimetres.

use rimline_lines::{Chain, Drawing, LineClass, PageBox};

use super::args::{Hidden, LinesArgs, Paper, Scale};
use super::style::{Pen, Style};
use crate::failure::UsageError;
use crate::output::note;

/// The empty border of a page.
const MARGIN_MM: f64 = 10.0;
/// The largest drawing; more would be a wrong scale.
const LARGEST_MM: f64 = 100_000.0;

/// Lines that lie on the page, by layers.
pub(crate) struct Sheet {
    /// Width and height.
    pub(crate) size_mm: [f64; 2],
    pub(crate) mm_per_unit: f64,
    /// The point of the view's page that is at the lower left corner.
    corner: [f64; 2],
    pub(crate) layers: Vec<Layer>,
    is_perspective: bool,
    scale: Scale,
}

/// Lines of one class, visible or hidden.
pub(crate) struct Layer {
    pub(crate) class: LineClass,
    pub(crate) is_hidden: bool,
    pub(crate) pen: Pen,
    pub(crate) lines: Vec<Polyline>,
}

/// A chain on the page.
pub(crate) struct Polyline {
    pub(crate) object: u32,
    /// Whole micrometres from the lower left corner.
    pub(crate) points: Vec<[i64; 2]>,
    pub(crate) is_closed: bool,
}

impl Layer {
    /// A name for it, such as `crease-hidden`.
    pub(crate) fn name(&self) -> String {
        format!("{}-{}", self.class.name(), if self.is_hidden { "hidden" } else { "visible" })
    }
}

impl Sheet {
    pub(crate) fn new(
        args: &LinesArgs,
        style: &Style,
        drawing: &Drawing,
        is_perspective: bool,
    ) -> Result<Self, UsageError> {
        let most = if args.hidden == Hidden::None { 0 } else { u32::MAX };
        // A drawing without lines has the origin in its middle.
        let nothing = PageBox { low: [0.0; 2], high: [0.0; 2] };
        let bounds = window(args).or_else(|| drawing.bounds(most)).unwrap_or(nothing);
        let size = [0, 1].map(|axis| bounds.high[axis] - bounds.low[axis]);
        let paper = args.page.unwrap_or(Paper::A4);
        let mut size_mm = turned(paper, size);
        let room = size_mm.map(|side| (side - 2.0 * MARGIN_MM).max(0.5 * side));
        let mm_per_unit = match args.scale {
            Scale::Ratio { page, model } => 1000.0 * page / model,
            Scale::Fit => {
                let fits = [0, 1].map(|axis| room[axis] / size[axis]).into_iter().fold(f64::INFINITY, f64::min);
                if fits.is_finite() { fits } else { 1.0 }
            }
        };
        let needed = size.map(|side| side * mm_per_unit);
        if !needed.into_iter().all(|side| side <= LARGEST_MM) {
            let [width, height] = needed.map(short);
            return Err(UsageError::DrawingTooLarge { width, height });
        }
        if args.scale != Scale::Fit {
            if args.page.is_none() {
                size_mm = needed.map(|side| libm::ceil(side + 2.0 * MARGIN_MM));
            } else if needed[0] > size_mm[0] || needed[1] > size_mm[1] {
                let [width, height] = size_mm;
                let [wide, high] = needed.map(libm::ceil);
                note(&format!(
                    "warning: the drawing takes {wide}x{high} mm, more than the page of {width}x{height} mm; give a smaller --scale or a larger --page"
                ));
            }
        }
        let corner =
            [0, 1].map(|axis| 0.5 * (bounds.low[axis] + bounds.high[axis]) - 0.5 * size_mm[axis] / mm_per_unit);
        let mut sheet = Self { size_mm, mm_per_unit, corner, layers: Vec::new(), is_perspective, scale: args.scale };
        for is_hidden in [true, false] {
            for class in LineClass::ALL.into_iter().rev().filter(|_| !is_hidden || args.hidden != Hidden::None) {
                let chains = drawing.chains.iter().filter(|chain| (chain.class, chain.is_hidden) == (class, is_hidden));
                let lines: Vec<_> = chains.filter_map(|chain| sheet.polyline(drawing, chain)).collect();
                if !lines.is_empty() {
                    let pen = style.pen(class, is_hidden, args.hidden);
                    sheet.layers.push(Layer { class, is_hidden, pen, lines });
                }
            }
        }
        if sheet.layers.is_empty() && !drawing.chains.is_empty() {
            note("warning: all lines are hidden, or shorter than a micrometre at this scale");
        }
        Ok(sheet)
    }

    /// A point of the view's page in millimetres from the lower left corner.
    pub(crate) fn to_mm(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (point[axis] - self.corner[axis]) * self.mm_per_unit)
    }

    /// `None` for what is shorter than a micrometre.
    fn polyline(&self, drawing: &Drawing, chain: &Chain) -> Option<Polyline> {
        let object = drawing.spans.get(chain.spans.start)?.object;
        let micrometres = |point: [f64; 2]| self.to_mm(point).map(|mm| libm::round(1000.0 * mm) as i64);
        let mut points: Vec<[i64; 2]> = drawing.page_points(chain).into_iter().map(micrometres).collect();
        points.dedup();
        if chain.is_closed && points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        (points.len() > 1).then_some(Polyline { object, points, is_closed: chain.is_closed })
    }

    /// The scale in words.
    pub(crate) fn scale_said(&self) -> String {
        match self.scale {
            Scale::Ratio { page, model } => format!("scale {page}:{model}, a unit taken as a metre"),
            Scale::Fit if self.is_perspective => "fitted to the page".to_owned(),
            Scale::Fit => format!("fitted to the page: a unit is {} mm", short(self.mm_per_unit)),
        }
    }

    /// A line for the user that says how much was drawn.
    pub(crate) fn said(&self, args: &LinesArgs) -> String {
        let count = |is_hidden: bool| {
            let layers = self.layers.iter().filter(|layer| layer.is_hidden == is_hidden);
            layers.map(|layer| layer.lines.len()).sum::<usize>()
        };
        let s = |count: usize| if count == 1 { "" } else { "s" };
        let (visible, behind, [width, height]) = (count(false), count(true), self.size_mm);
        let hidden = match args.hidden {
            Hidden::None => String::new(),
            _ => format!(" and {behind} hidden line{}", s(behind)),
        };
        let s = s(visible);
        let (out, scale) = (args.out.display(), self.scale_said());
        format!("wrote {out}: {visible} line{s}{hidden} on {width}x{height} mm, {scale}\n")
    }
}

/// The part of the view's page from which lines are taken. An eye within a model sees lines at any angle, so there is a limit.
pub(crate) fn taken(args: &LinesArgs) -> Option<PageBox> {
    const MOST: f64 = 1.19; // The tangent of 50 degrees.
    let most = PageBox { low: [-MOST; 2], high: [MOST; 2] };
    window(args).or_else(|| args.eye.filter(|_| !args.ortho).map(|_| most))
}

/// The part of the view's page that `--fov` asks for, if the eye is given.
fn window(args: &LinesArgs) -> Option<PageBox> {
    let (Some(_), Some(degrees)) = (args.eye, args.fov) else { return None };
    let height = libm::tan(f64::from(degrees).to_radians() / 2.0);
    let [width_mm, height_mm] = turned(args.page.unwrap_or(Paper::A4), [2.0, 1.0]).map(|side| side - 2.0 * MARGIN_MM);
    let width = height * (width_mm / height_mm).max(f64::MIN_POSITIVE);
    Some(PageBox { low: [-width, -height], high: [width, height] })
}

/// Width and height of a page for a drawing of this size.
fn turned(paper: Paper, [width, height]: [f64; 2]) -> [f64; 2] {
    match paper {
        Paper::Turned([short, long]) if width > height => [long, short],
        Paper::Given(size) | Paper::Turned(size) => size,
    }
}

/// A number with four digits that count.
fn short(number: f64) -> String {
    if !(1e-4..1e7).contains(&number.abs()) {
        return format!("{number:.3e}");
    }
    let digits = (3.0 - libm::floor(libm::log10(number.abs().max(f64::MIN_POSITIVE)))).clamp(0.0, 9.0) as usize;
    format!("{number:.digits$}")
}
