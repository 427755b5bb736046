//! The parts of lines that are drawn; and boxes of the page and of depths, in `f32` that are rounded outwards. Only searches
//! use the boxes; no sign depends on them.

use crate::edges::Line;
use crate::error::LinesError;
use crate::options::{LineOptions, PageBox};
use crate::tree::Box3;
use crate::view::View;
use crate::world::World;

/// Where points are in a drawing: the page without its offset and size, and depths likewise.
pub(crate) struct Frame {
    view: View,
    pub(crate) near: f64,
    window: Option<PageBox>,
    low: [f64; 2],
    size: f64,
    depth_low: f64,
    depth_size: f64,
    /// A bound of the rounding errors of a depth or a product with an axis of the page.
    error: f64,
}

/// The part of a line that is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// From 0 to 1.
    pub(crate) ends: [f64; 2],
    pub(crate) depths: [f64; 2],
    pub(crate) page: [[f64; 2]; 2],
}

impl Part {
    /// How far along the part's page a parameter of the line is, 0 to 1.
    pub(crate) fn along(&self, at: f64, is_perspective: bool) -> f64 {
        let [from, to] = self.ends;
        let along = (at - from) / (to - from);
        if !is_perspective {
            return along;
        }
        let [near, far] = [(1.0 - along) * self.depths[0], along * self.depths[1]];
        far / (near + far)
    }

    /// The other way round.
    pub(crate) fn at(&self, along: f64, is_perspective: bool) -> f64 {
        let [from, to] = self.ends;
        let share = if is_perspective {
            let [near, far] = [(1.0 - along) * self.depths[1], along * self.depths[0]];
            far / (near + far)
        } else {
            along
        };
        from + share * (to - from)
    }
}

pub(crate) fn point_at([a, b]: [[f64; 3]; 2], at: f64) -> [f64; 3] {
    if at == 1.0 { b } else { [0, 1, 2].map(|axis| a[axis] + at * (b[axis] - a[axis])) }
}

impl Frame {
    /// Finds the part of each line that is on the page, and the frame around all. Lines that are nowhere on it, or a point
    /// there, have `None`.
    pub(crate) fn new(
        world: &World<'_>,
        lines: &[Line],
        options: &LineOptions,
    ) -> Result<(Self, Vec<Option<Part>>), LinesError> {
        let view = world.view;
        let largest = world
            .positions
            .iter()
            .flatten()
            .fold(0.0_f32, |largest, c| if c.is_finite() { largest.max(c.abs()) } else { largest });
        let eye = if view.is_perspective() { view.eye().xyz } else { [0.0; 3] };
        let reach = eye.into_iter().fold(f64::from(largest), |reach, c| reach.max(f64::from(c.abs())));
        let ends = |line: &Line| line.vertices.map(|vertex| world.point(vertex));
        let near = near_of(&view, options, || lines.iter().flat_map(ends))?;
        let (window, error) = (options.window, 1e-14 * reach);
        let (low, size, depth_low, depth_size) = ([0.0; 2], 1.0, 0.0, 1.0);
        let mut frame = Self { view, near, window, low, size, depth_low, depth_size, error };
        let parts: Vec<_> = lines.iter().map(|line| frame.part(ends(line))).collect();
        let (mut low, mut high, mut depths) =
            ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], [f64::INFINITY, f64::NEG_INFINITY]);
        for part in parts.iter().flatten() {
            for (page, depth) in part.page.into_iter().zip(part.depths) {
                low = [0, 1].map(|axis| low[axis].min(page[axis]));
                high = [0, 1].map(|axis| high[axis].max(page[axis]));
                depths = [depths[0].min(depth), depths[1].max(depth)];
            }
        }
        let positive = |size: f64| if size > 0.0 && size.is_finite() { size } else { 1.0 };
        frame.low = low.map(|c| if c.is_finite() { c } else { 0.0 });
        frame.size = positive((high[0] - low[0]).max(high[1] - low[1]));
        (frame.depth_low, frame.depth_size) = (depths[0].min(f64::MAX), positive(depths[1] - depths[0]));
        Ok((frame, parts))
    }

    /// The part of a line that is ahead of the near plane and in the window.
    fn part(&self, ends: [[f64; 3]; 2]) -> Option<Part> {
        let depths = ends.map(|end| self.view.depth(end));
        let mut part = [0.0, 1.0];
        if self.view.is_perspective() {
            let is_cut = depths.into_iter().any(|depth| depth < self.near);
            let near = if is_cut { self.near_of_cut(ends) } else { self.near };
            clip(&mut part, depths.map(|depth| depth - near))?;
        }
        if let Some(PageBox { low, high }) = self.window {
            // Beyond the near plane, the inside of the window's four sides is where linear functions are positive.
            let on_page = |at: f64| self.view.page(point_at(ends, at));
            let weights = |at: f64| if self.view.is_perspective() { self.view.depth(point_at(ends, at)) } else { 1.0 };
            let from = part;
            for axis in 0..2 {
                let inside =
                    |at: f64| [on_page(at)[axis] - low[axis], high[axis] - on_page(at)[axis]].map(|d| d * weights(at));
                let [first, last] = from.map(inside);
                for side in 0..2 {
                    let mut inside_side = [0.0, 1.0];
                    clip(&mut inside_side, [first[side], last[side]])?;
                    let inside_side =
                        inside_side.map(|at| if at == 1.0 { from[1] } else { from[0] + at * (from[1] - from[0]) });
                    part = [part[0].max(inside_side[0]), part[1].min(inside_side[1])];
                }
            }
        }
        let points = part.map(|at| point_at(ends, at));
        let (depths, page) = (points.map(|point| self.view.depth(point)), points.map(|point| self.view.page(point)));
        let is_finite = page.as_flattened().iter().all(|c| c.is_finite());
        (part[0] < part[1] && page[0] != page[1] && is_finite).then_some(Part { ends: part, depths, page })
    }

    /// Where a line is cut that reaches too near to a perspective eye. Depths on it are rounded by less than a tenth of the
    /// least, so that of the cut is above 0.
    fn near_of_cut(&self, ends: [[f64; 3]; 2]) -> f64 {
        let eye = self.view.eye().xyz.map(f64::from);
        let reach = ends.iter().chain([&eye]).flatten().fold(0.0, |reach: f64, c| reach.max(c.abs()));
        self.near.max(1e-13 * reach)
    }

    /// The box around a part of a line.
    pub(crate) fn bounds_of_part(&self, part: &Part) -> Box3 {
        let ends = [0, 1].map(|end| self.bounds(part.page[end], part.depths[end]));
        ends[0].join(ends[1])
    }

    /// The box around a vertex. Those of a face's corners, joined, hold all of the face that is ahead of the eye. A vertex
    /// behind the eye has the far depth −∞, and so has a face with no others.
    pub(crate) fn bounds_of_vertex(&self, position: [f32; 3]) -> Box3 {
        let point = position.map(f64::from);
        let depth = self.view.depth(point);
        if self.view.is_perspective() && depth < (0.5 * self.near).max(self.error) {
            // A face with such a corner may be anywhere on the page. One with no other corners hides nothing.
            let far = if depth < -self.error { f32::NEG_INFINITY } else { f32::INFINITY };
            return Box3 { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY, f32::INFINITY, far] };
        }
        self.bounds(self.view.page(point), depth)
    }

    /// A point of the page without its offset and size.
    pub(crate) fn on_page(&self, page: [f64; 2]) -> [f32; 2] {
        [0, 1].map(|axis| ((page[axis] - self.low[axis]) / self.size) as f32)
    }

    /// A bound of the rounding errors of a part's page, without the page's size.
    pub(crate) fn error_of_part(&self, part: &Part) -> f32 {
        let [from, to] = [0, 1].map(|end| self.error_on_page(part.page[end], part.depths[end]));
        (from.max(to) / self.size) as f32
    }

    fn error_on_page(&self, page: [f64; 2], depth: f64) -> f64 {
        let scale = if self.view.is_perspective() { (1.0 + page[0].abs() + page[1].abs()) / depth } else { 1.0 };
        self.error * scale
    }

    fn bounds(&self, page: [f64; 2], depth: f64) -> Box3 {
        let error = self.error_on_page(page, depth);
        let at = |axis: usize, error: f64| (page[axis] + error - self.low[axis]) / self.size;
        let deep = |error: f64| (depth + error - self.depth_low) / self.depth_size;
        Box3 {
            low: [below(at(0, -error)), below(at(1, -error)), below(deep(-self.error))],
            high: [above(at(0, error)), above(at(1, error)), above(deep(self.error))],
        }
    }
}

/// The depth from which on lines are drawn.
pub(crate) fn near_of<I: Iterator<Item = [f64; 3]>>(
    view: &View,
    options: &LineOptions,
    points: impl FnOnce() -> I,
) -> Result<f64, LinesError> {
    match options.near {
        Some(near) if near.is_finite() && near > 0.0 => Ok(near),
        Some(near) => Err(LinesError::Near { near }),
        None => Ok(1e-3 * points().map(|point| view.depth(point)).fold(f64::MIN_POSITIVE, f64::max)),
    }
}

/// Clips an interval to where a function that is linear in it, with these values at 0 and 1, is not negative.
fn clip(part: &mut [f64; 2], [first, last]: [f64; 2]) -> Option<()> {
    if first < 0.0 && last < 0.0 {
        return None;
    }
    if first < 0.0 {
        part[0] = part[0].max(first / (first - last));
    }
    if last < 0.0 {
        part[1] = part[1].min(first / (first - last));
    }
    (part[0] < part[1]).then_some(())
}

fn below(value: f64) -> f32 {
    (value as f32).next_down()
}

fn above(value: f64) -> f32 {
    (value as f32).next_up()
}
