//! A plane with two axes: curves from point to point, or points alone.

use super::axis::Axis;
use super::svg::{Anchor, Ink, Label, Svg, text_width};
use super::{Key, Target};

/// Curves or points over two axes.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) curves: Vec<Curve>,
    /// Lines join each curve's points, and its name stands at its end.
    pub(crate) joined: bool,
    /// A number on the y axis to draw a line at, with its name.
    pub(crate) mark: Option<(f64, String)>,
    pub(crate) zero: Option<ZeroBand>,
}

/// What has one key: a curve, or a cloud of points.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) key: Key,
    pub(crate) points: Vec<Point>,
    /// Said at a curve's end beside its name.
    pub(crate) remark: String,
}

/// A point of a curve.
#[derive(Clone, Debug, Default)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// From where to where values of y spread.
    pub(crate) spread: Option<(f64, f64)>,
    /// Points without lines are linked where their labels are equal, and labelled once if there is room; those in the
    /// strip of zeros are not linked, but labelled each.
    pub(crate) label: String,
    /// What a pointer on it is told.
    pub(crate) tip: String,
}

/// A strip below a logarithmic y axis for the points whose y is zero, each curve's on a line of its own.
#[derive(Clone, Debug)]
pub(crate) struct ZeroBand {
    /// What zero means, in a word or two.
    pub(crate) title: String,
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 86.0;
const PLOT: f64 = 380.0;
const LANE: f64 = 17.0;
const MARK: f64 = 5.5;
const SMALL: f64 = 12.0;
/// Of a point's label.
const HEIGHT: f64 = 13.0;
/// How much wider bold text is.
const BOLD: f64 = 1.2;

/// Left, top, right and bottom of something that must not be covered.
type Extent = [f64; 4];

/// Where the axes lie.
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Plane {
    fn keys(&self) -> Vec<Key> {
        self.curves.iter().map(|curve| curve.key.clone()).collect()
    }

    pub(super) fn draw(&self, target: Target<'_>) -> Svg {
        let margin = if self.joined {
            self.curves.iter().map(|curve| text_width(&curve.key.name, 13.0)).fold(0.0, f64::max) * BOLD + 26.0
        } else {
            24.0
        };
        let lanes = if self.zero.is_some() { 12.0 + LANE * self.curves.len() as f64 } else { 0.0 };
        // The legend's height shows only once it is drawn.
        let legend =
            |svg: &mut Svg| if self.joined { 12.0 } else { svg.legend(&self.keys(), LEFT, 6.0, WIDTH - 20.0) + 14.0 };
        let top = legend(&mut Svg::new(WIDTH, 0.0, target));
        let frame = Frame { left: LEFT, right: WIDTH - margin.min(420.0), top, bottom: top + PLOT };
        let mut svg = Svg::new(WIDTH, frame.bottom + lanes + 54.0, target);
        legend(&mut svg);
        self.draw_axes(&mut svg, &frame, frame.bottom + lanes);
        if !self.joined {
            for (_, places) in self.labelled(&frame) {
                svg.polyline(&places, Ink::Link, 1.5, "");
            }
        }
        let taken = self.draw_points(&mut svg, &frame);
        if self.joined {
            self.draw_end_labels(&mut svg, &frame);
        } else {
            self.draw_point_labels(&mut svg, &frame, taken);
        }
        svg
    }

    fn is_in_band(&self, point: &Point) -> bool {
        self.zero.is_some() && point.y <= 0.0
    }

    fn place(&self, frame: &Frame, curve: usize, x: f64, y: f64) -> [f64; 2] {
        let across = frame.left + self.x.place(x) * (frame.right - frame.left);
        let up = if self.zero.is_some() && y <= 0.0 {
            frame.bottom + 12.0 + LANE * (curve as f64 + 0.5)
        } else {
            frame.bottom - self.y.place(y) * (frame.bottom - frame.top)
        };
        [across, up]
    }

    fn draw_axes(&self, svg: &mut Svg, frame: &Frame, floor: f64) {
        let Frame { left, right, top, bottom } = *frame;
        let small = Label { x: 0.0, y: 0.0, size: SMALL, anchor: Anchor::End, ink: Ink::Muted, bold: false };
        if let Some(zero) = &self.zero {
            svg.rectangle([left, bottom + 12.0], [right - left, floor - bottom - 12.0], Ink::Band, "");
            let y = f64::midpoint(bottom + 12.0, floor);
            svg.text(Label { x: left - 8.0, y: y - 2.0, ink: Ink::Text, bold: true, size: 15.0, ..small }, "0");
            svg.text(Label { x: left - 8.0, y: y + 13.0, ..small }, &zero.title);
        }
        for tick in self.y.ticks(9) {
            let y = bottom - self.y.place(tick) * (bottom - top);
            svg.line([left, y], [right, y], Ink::Grid, 1.0, "");
            svg.text(Label { x: left - 8.0, y: y + 4.0, ..small }, &(self.y.format)(tick));
        }
        for tick in self.x.ticks(10) {
            let x = left + self.x.place(tick) * (right - left);
            svg.line([x, top], [x, floor], Ink::Grid, 1.0, "");
            svg.text(Label { x, y: floor + 18.0, anchor: Anchor::Middle, ..small }, &(self.x.format)(tick));
        }
        svg.line([left, floor], [right, floor], Ink::Muted, 1.0, "");
        if let Some((value, name)) = &self.mark {
            let y = bottom - self.y.place(*value) * (bottom - top);
            svg.line([left, y], [right, y], Ink::Muted, 1.5, "6 4");
            svg.text(Label { x: right - 8.0, y: y - 6.0, anchor: Anchor::End, ..small }, name);
        }
        let title = Label { size: 13.0, ink: Ink::Text, anchor: Anchor::Middle, ..small };
        svg.text(Label { x: f64::midpoint(left, right), y: floor + 42.0, ..title }, &self.x.title);
        svg.upright_text(20.0, f64::midpoint(top, bottom), 13.0, &self.y.title);
    }

    /// Draws what is no text, and says where marks are.
    fn draw_points(&self, svg: &mut Svg, frame: &Frame) -> Vec<Extent> {
        let mut taken = Vec::new();
        for (index, Curve { key, points, .. }) in self.curves.iter().enumerate() {
            let ink = Ink::Key(key.colour);
            let places: Vec<[f64; 2]> = points.iter().map(|point| self.place(frame, index, point.x, point.y)).collect();
            if self.joined {
                svg.polyline(&places, ink, 2.0, if key.hollow { "7 4" } else { "" });
            }
            for (point, &[x, y]) in points.iter().zip(&places) {
                if let Some((low, high)) = point.spread {
                    let [[_, low], [_, high]] = [low, high].map(|value| self.place(frame, index, point.x, value));
                    if low - high > 2.0 * MARK {
                        svg.line([x, low], [x, high], ink, 1.5, "");
                    }
                }
                svg.mark([x, y], key, MARK, &point.tip);
                taken.push([x - MARK, y - MARK, x + MARK, y + MARK]);
            }
        }
        taken
    }

    /// Names at the curves' ends, moved apart where they would touch.
    fn draw_end_labels(&self, svg: &mut Svg, frame: &Frame) {
        let has_remarks = self.curves.iter().any(|curve| !curve.remark.is_empty());
        let step = if has_remarks { 34.0 } else { 18.0 };
        let mut ends: Vec<(f64, f64, usize)> = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            if let Some(last) = curve.points.last() {
                let [x, y] = self.place(frame, index, last.x, last.y);
                ends.push((y, x, index));
            }
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut heights: Vec<f64> = ends.iter().map(|end| end.0).collect();
        for at in 1..heights.len() {
            heights[at] = heights[at].max(heights[at - 1] + step);
        }
        // What was pushed below the frame goes up again.
        let mut lowest = frame.bottom + 6.0;
        for height in heights.iter_mut().rev() {
            *height = height.min(lowest);
            lowest = *height - step;
        }
        for ((y, x, index), height) in ends.into_iter().zip(heights) {
            let curve = &self.curves[index];
            let ink = Ink::Key(curve.key.colour);
            let begin = frame.right + 14.0;
            svg.line([x + MARK + 1.0, y], [begin - 3.0, height], ink, 1.0, "");
            let label = Label { x: begin, y: height + 4.5, size: 13.0, anchor: Anchor::Start, ink, bold: true };
            svg.text(label, &curve.key.name);
            svg.text(Label { y: height + 19.0, size: SMALL, ink: Ink::Muted, bold: false, ..label }, &curve.remark);
        }
    }

    /// Points of equal labels, from left to right.
    fn labelled(&self, frame: &Frame) -> Vec<(&str, Vec<[f64; 2]>)> {
        let mut labelled: Vec<(&str, Vec<[f64; 2]>)> = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            for point in curve.points.iter().filter(|point| !point.label.is_empty() && !self.is_in_band(point)) {
                let place = self.place(frame, index, point.x, point.y);
                match labelled.iter_mut().find(|(label, _)| *label == point.label) {
                    Some((_, places)) => places.push(place),
                    None => labelled.push((&point.label, vec![place])),
                }
            }
        }
        for (_, places) in &mut labelled {
            places.sort_by(|a, b| a[0].total_cmp(&b[0]));
        }
        labelled
    }

    /// Each label once, beside one of its points, the last if there is room, where it covers nothing; without any room
    /// it is left to the table.
    fn draw_point_labels(&self, svg: &mut Svg, frame: &Frame, mut taken: Vec<Extent>) {
        for (text, points) in self.labelled(frame) {
            let width = text_width(text, SMALL);
            let beside = |&[x, y]: &[f64; 2]| {
                [
                    [x + 10.0, y - 6.5],
                    [x + 6.0, y - 20.0],
                    [x + 6.0, y + 7.0],
                    [x - 10.0 - width, y - 6.5],
                    [x - 6.0 - width, y - 20.0],
                    [x - 6.0 - width, y + 7.0],
                ]
            };
            let places = points.iter().rev().flat_map(beside);
            let free = places.map(|[x, y]| [x, y, x + width, y + HEIGHT]).find(|place| {
                let is_inside = place[0] > frame.left && place[2] < frame.right && place[1] > frame.top - 8.0;
                is_inside && !taken.iter().any(|other| overlap(place, other))
            });
            if let Some(place) = free {
                // Lines behind it stay off the letters.
                svg.rectangle([place[0] - 2.0, place[1]], [width * 0.95, HEIGHT], Ink::Ground, "");
                let (x, y, anchor) = (place[0], place[1] + 10.5, Anchor::Start);
                svg.text(Label { x, y, size: SMALL, anchor, ink: Ink::Text, bold: false }, text);
                taken.push(place);
            }
        }
        self.draw_band_labels(svg, frame, taken);
    }

    /// Beside a point without error its label, where there is room on its curve's line; the last ones first, since the
    /// others mostly lie close together.
    fn draw_band_labels(&self, svg: &mut Svg, frame: &Frame, mut taken: Vec<Extent>) {
        for (index, curve) in self.curves.iter().enumerate() {
            let points = curve.points.iter().filter(|point| !point.label.is_empty() && self.is_in_band(point));
            let mut places: Vec<(f64, &str)> = Vec::new();
            for point in points {
                places.push((self.place(frame, index, point.x, 0.0)[0], &point.label));
            }
            places.sort_by(|a, b| b.0.total_cmp(&a.0));
            let y = self.place(frame, index, 1.0, 0.0)[1] - 0.5 * HEIGHT;
            for (x, text) in places {
                let width = text_width(text, SMALL);
                let beside = [x + 9.0, x - 9.0 - width].map(|x| [x, y, x + width, y + HEIGHT]);
                let free = beside.into_iter().find(|place| {
                    let is_inside = place[0] > frame.left && place[2] < frame.right;
                    is_inside && !taken.iter().any(|other| overlap(place, other))
                });
                if let Some(place) = free {
                    let (x, y, anchor) = (place[0], y + 10.5, Anchor::Start);
                    svg.text(Label { x, y, size: SMALL, anchor, ink: Ink::Muted, bold: false }, text);
                    taken.push(place);
                }
            }
        }
    }

    /// The slope of the line through a curve's points in the logarithms, by least squares; the power by which y grows
    /// with x.
    pub(crate) fn slope(points: &[Point]) -> Option<f64> {
        let logs: Vec<[f64; 2]> =
            points.iter().filter(|p| p.x > 0.0 && p.y > 0.0).map(|p| [p.x.ln(), p.y.ln()]).collect();
        let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / logs.len() as f64;
        let [x, y] = [mean(0), mean(1)];
        let [mut above, mut below] = [0.0; 2];
        for p in &logs {
            above += (p[0] - x) * (p[1] - y);
            below += (p[0] - x) * (p[0] - x);
        }
        (below > 0.0).then(|| above / below)
    }
}

fn overlap(a: &Extent, b: &Extent) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Scale;

    fn point(x: f64, y: f64) -> Point {
        Point { x, y, ..Point::default() }
    }

    #[test]
    fn a_power_has_its_slope() {
        let points: Vec<Point> = [1.0, 10.0, 300.0].map(|x: f64| point(x, 7.0 * x.powf(0.8))).into();
        let slope = Plane::slope(&points).expect("it has three points");
        assert!((slope - 0.8).abs() < 1e-9, "{slope}");
        assert_eq!(Plane::slope(&points[..1]), None);
    }

    #[test]
    fn zeros_lie_below_the_axis_and_labels_apart() {
        let key = Key { name: "a <b> & c".into(), colour: 0, shape: 0, hollow: false };
        let points: Vec<Point> =
            (0..20).map(|n| Point { label: "same place".into(), ..point(1.0, f64::from(n % 2)) }).collect();
        let plane = Plane {
            x: Axis::over("x", Scale::Log, |v| v.to_string(), [1.0]),
            y: Axis::over("y", Scale::Log, |v| v.to_string(), [1.0]),
            curves: vec![Curve { key, points, remark: String::new() }],
            joined: false,
            mark: None,
            zero: Some(ZeroBand { title: "none".into() }),
        };
        let svg = plane.draw(Target::Page).finish();
        assert_eq!(svg.matches("<circle").count(), 21, "twenty points and the legend");
        assert_eq!(svg.matches(">same place<").count(), 3, "once above zero, and at zero on either side of the mark");
        assert!(svg.contains("a &lt;b&gt; &amp; c"));
    }
}
