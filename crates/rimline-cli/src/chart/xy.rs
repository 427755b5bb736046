//! A plane with two axes: curves from point to point, or points alone.

use std::io;

use plotters::prelude::*;

use super::axis::{Axis, Coordinate};
use super::labels::{Extent, Room, spread};
use super::svg::{
    Area, Drawn, END, Ink, LINE, Label, Legend, MIDDLE, NAME, NUMBERS, Plotted, SMALL, START, TICK, Tips, lines, mark,
    path, text_width, upright, width, wrapped,
};
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

/// Points with one key: a curve, or a cloud of points.
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
    /// Tooltip of the point.
    pub(crate) tip: String,
}

/// A strip below a logarithmic y axis for the points whose y is zero, each curve's on a line of its own.
#[derive(Clone, Debug)]
pub(crate) struct ZeroBand {
    /// Meaning of zero, in a word or two.
    pub(crate) title: String,
}

const MARK: f64 = 11.0;
/// Between the plane and the strip of zeros.
const STRIP: i32 = 24;
/// How much wider bold text is.
const BOLD: f64 = 1.2;
const DASH: [i32; 2] = [14, 8];

/// Where everything lies.
struct Layout {
    narrow: bool,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
    /// Below the strip of zeros.
    floor: i32,
    titles: [Vec<String>; 2],
}

/// The layout with its coordinates drawn.
struct Frame<'a> {
    layout: Layout,
    plane: Plotted<'a>,
    strip: Option<Plotted<'a>>,
}

impl Plane {
    /// Keys of the legend. Empty where names stand at the curves' ends.
    fn keys(&self, narrow: bool) -> Vec<Key> {
        let named = |curve: &Curve| match curve.remark.as_str() {
            "" => curve.key.clone(),
            remark => Key { name: format!("{}: {remark}", curve.key.name), ..curve.key.clone() },
        };
        if self.joined && !narrow { Vec::new() } else { self.curves.iter().map(named).collect() }
    }

    fn layout(&self, target: Target<'_>, legend: &Legend<'_>) -> Layout {
        let narrow = target.is_narrow();
        let names = self.curves.iter().map(|curve| text_width(&curve.key.name, 26.0));
        let margin = match (narrow, self.joined) {
            (true, _) => 28,
            (false, false) => 48,
            (false, true) => ((f64::from(names.fold(0, i32::max)) * BOLD) as i32 + 52).min(840),
        };
        let (left, right) = (if narrow { 104 } else { 172 }, width(target) - margin);
        // A narrow plane has no room for a title beside it.
        let above = if narrow { wrapped(&self.y.title, SMALL, right) } else { Vec::new() };
        let below = wrapped(&self.x.title, 26.0, right - left);
        let top = legend.height + above.len() as i32 * LINE + 24;
        let bottom = top + if narrow { 600 } else { 760 };
        let strip = if self.zero.is_some() { STRIP + LINE * self.curves.len() as i32 } else { 0 };
        Layout { narrow, left, right, top, bottom, floor: bottom + strip, titles: [above, below] }
    }

    pub(super) fn draw(&self, target: Target<'_>) -> io::Result<String> {
        let keys = self.keys(target.is_narrow());
        let legend = Legend::new(&keys, if target.is_narrow() { 8 } else { 172 }, width(target) - 40);
        let layout = self.layout(target, &legend);
        let height = layout.floor + NUMBERS + layout.titles[1].len() as i32 * LINE + 16;
        super::svg::drawing(target, height, |area, tips| {
            legend.draw(area)?;
            let frame = self.draw_axes(area, layout)?;
            let mut room = Room::default();
            if !self.joined {
                for (_, places) in self.labelled(&frame) {
                    room.take_line(&places);
                    path(area, &places, Ink::Link.stroke(3), None)?;
                }
            }
            self.draw_points(area, &frame, &mut room, tips)?;
            self.draw_mark(area, &frame, &mut room)?;
            match (self.joined, frame.layout.narrow) {
                (true, false) => self.draw_end_labels(area, &frame),
                (true, true) => Ok(()),
                (false, _) => self.draw_point_labels(area, &frame, &mut room),
            }
        })
    }

    fn is_in_strip(&self, point: &Point) -> bool {
        self.zero.is_some() && point.y <= 0.0
    }

    fn draw_axes<'a>(&self, area: &Area<'a>, layout: Layout) -> Drawn<Frame<'a>> {
        let Layout { narrow, left, right, top, bottom, floor, .. } = layout;
        let size = [right - left, bottom - top];
        let (x, y) = (self.x.across(size[0]), self.y.upright(size[1]));
        let numbers = if self.zero.is_some() { 0 } else { NUMBERS };
        let plane = Plotted::new(area, (left, top), size, [x.clone(), y], [left - 8, numbers])?;
        let strip = match &self.zero {
            None => None,
            Some(zero) => {
                let corner = (left, bottom + STRIP);
                let ground = Rectangle::new([corner, (right, floor)], Ink::Band.rgb().filled());
                area.draw(&ground)?;
                let size = [right - left, floor - bottom - STRIP];
                let title = wrapped(&zero.title, SMALL, left - 24);
                let middle = i32::midpoint(corner.1, floor) - title.len() as i32 * LINE / 2;
                let big = Label { size: 30.0, ink: Ink::Text, bold: true, anchor: END };
                big.draw(area, (left - 16, middle), "0")?;
                lines(area, Label { anchor: END, ..TICK }, (left - 16, middle + LINE), &title)?;
                let rows = Coordinate::rows(self.curves.len() as i32);
                Some(Plotted::new(area, corner, size, [x, rows], [0, NUMBERS])?)
            }
        };
        let [above, below] = &layout.titles;
        if !narrow {
            upright(area, (36, i32::midpoint(top, bottom)), &self.y.title)?;
        }
        lines(area, Label { size: SMALL, ..NAME }, (8, top - above.len() as i32 * LINE - 4), above)?;
        let middle = i32::midpoint(left, right);
        lines(area, Label { anchor: MIDDLE, ..NAME }, (middle, floor + NUMBERS + 8), below)?;
        Ok(Frame { layout, plane, strip })
    }

    /// Where a point of a curve is.
    fn place(frame: &Frame<'_>, curve: usize, x: f64, y: f64) -> (i32, i32) {
        match &frame.strip {
            Some(strip) if y <= 0.0 => strip.at(x, curve as f64 + 0.5),
            _ => frame.plane.at(x, y),
        }
    }

    /// A dashed line with its name, where that covers nothing.
    fn draw_mark(&self, area: &Area<'_>, frame: &Frame<'_>, room: &mut Room) -> Drawn {
        let Some((value, name)) = &self.mark else { return Ok(()) };
        let Layout { left, right, top, bottom, .. } = frame.layout;
        let (_, y) = frame.plane.at(1.0, *value);
        path(area, &[(left, y), (right, y)], Ink::Muted.stroke(3), Some([12, 8]))?;
        let room_right = right - text_width(name, SMALL) - 12;
        let starts = (left + 12..room_right.max(left + 13)).rev().step_by(20).flat_map(|x| [(x, y - 22), (x, y + 22)]);
        match room.find(name, SMALL, [left, top, right, bottom], starts) {
            Some(at) => Label { anchor: START, ..TICK }.draw(area, at, name),
            None => Ok(()),
        }
    }

    /// Draws what is no text.
    fn draw_points(&self, area: &Area<'_>, frame: &Frame<'_>, room: &mut Room, tips: &mut Tips) -> Drawn {
        for (index, Curve { key, points, .. }) in self.curves.iter().enumerate() {
            let ink = Ink::Key(key.colour);
            let places: Vec<(i32, i32)> =
                points.iter().map(|point| Self::place(frame, index, point.x, point.y)).collect();
            if self.joined {
                path(area, &places, ink.stroke(4), key.hollow.then_some(DASH))?;
                room.take_line(&places);
            }
            for (point, &(x, _)) in points.iter().zip(&places) {
                if let Some((low, high)) = point.spread {
                    let [(_, low), (_, high)] = [low, high].map(|value| Self::place(frame, index, point.x, value));
                    if f64::from(low - high) > 2.0 * MARK {
                        path(area, &[(x, low), (x, high)], ink.stroke(3), None)?;
                        room.take_line(&[(x, low), (x, high)]);
                    }
                }
            }
            for (point, &at) in points.iter().zip(&places) {
                mark(area, at, key, MARK)?;
                room.take_mark(at, 14);
                tips.at(at, &point.tip);
            }
        }
        Ok(())
    }

    /// Names at the curves' ends, moved apart where they would touch.
    fn draw_end_labels(&self, area: &Area<'_>, frame: &Frame<'_>) -> Drawn {
        let has_remarks = self.curves.iter().any(|curve| !curve.remark.is_empty());
        let step = if has_remarks { 68 } else { 36 };
        let ends = self.curves.iter().enumerate().filter_map(|(index, curve)| {
            let last = curve.points.last()?;
            Some((Self::place(frame, index, last.x, last.y), curve))
        });
        let mut ends: Vec<((i32, i32), &Curve)> = ends.collect();
        ends.sort_by_key(|((_, y), _)| *y);
        let mut heights: Vec<i32> = ends.iter().map(|((_, y), _)| *y).collect();
        spread(&mut heights, step, frame.layout.bottom + 12);
        for (((x, y), curve), height) in ends.into_iter().zip(heights) {
            let ink = Ink::Key(curve.key.colour);
            let begin = frame.layout.right + 28;
            path(area, &[(x + 14, y), (begin - 6, height)], ink.stroke(2), None)?;
            Label { ink, bold: true, ..NAME }.draw(area, (begin, height), &curve.key.name)?;
            Label { anchor: START, ..TICK }.draw(area, (begin, height + 31), &curve.remark)?;
        }
        Ok(())
    }

    /// Points of equal labels, from left to right.
    fn labelled(&self, frame: &Frame<'_>) -> Vec<(&str, Vec<(i32, i32)>)> {
        let mut labelled: Vec<(&str, Vec<(i32, i32)>)> = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            for point in curve.points.iter().filter(|point| !point.label.is_empty() && !self.is_in_strip(point)) {
                let place = Self::place(frame, index, point.x, point.y);
                match labelled.iter_mut().find(|(label, _)| *label == point.label) {
                    Some((_, places)) => places.push(place),
                    None => labelled.push((&point.label, vec![place])),
                }
            }
        }
        for (_, places) in &mut labelled {
            places.sort_by_key(|place| place.0);
        }
        labelled
    }

    /// Each label once, beside one of its points, the last if there is room, where it covers nothing; without any room
    /// it is left to the table.
    fn draw_point_labels(&self, area: &Area<'_>, frame: &Frame<'_>, room: &mut Room) -> Drawn {
        let Layout { left, right, top, bottom, floor, .. } = frame.layout;
        let extent: Extent = [left, top - 16, right, bottom + STRIP];
        let label = Label { ink: Ink::Text, anchor: START, ..TICK };
        for (text, points) in self.labelled(frame) {
            let width = text_width(text, SMALL);
            let beside = |&(x, y): &(i32, i32)| {
                let [behind, before] = [x - 20 - width, x + 20];
                [
                    (before, y),
                    (before - 6, y - 28),
                    (before - 6, y + 28),
                    (behind, y),
                    (behind, y - 28),
                    (behind, y + 28),
                ]
            };
            if let Some(at) = room.find(text, SMALL, extent, points.iter().rev().flat_map(beside)) {
                label.draw(area, at, text)?;
            }
        }
        // Beside a point without error its label, where there is room on its curve's line; the last ones first, since the
        // others mostly lie close together.
        let extent = [left, bottom, right, floor + 16];
        for (index, curve) in self.curves.iter().enumerate() {
            let points = curve.points.iter().filter(|point| !point.label.is_empty() && self.is_in_strip(point));
            let mut places: Vec<((i32, i32), &str)> =
                points.map(|point| (Self::place(frame, index, point.x, 0.0), point.label.as_str())).collect();
            places.sort_by_key(|((x, _), _)| -x);
            for ((x, y), text) in places {
                let starts = [(x + 20, y), (x - 20 - text_width(text, SMALL), y)];
                if let Some(at) = room.find(text, SMALL, extent, starts) {
                    Label { ink: Ink::Muted, ..label }.draw(area, at, text)?;
                }
            }
        }
        Ok(())
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
        for target in [Target::Page, Target::Phone] {
            let svg = plane.draw(target).expect("it goes to memory");
            let coloured = svg.matches("<circle").count();
            assert_eq!(coloured, 2 * 21, "twenty points and the legend, each with its rim");
            assert_eq!(svg.matches("same place\n").count(), 3, "above zero, and at zero on either side of the mark");
            assert!(svg.contains("a &lt;b&gt; &amp; c"));
        }
    }
}
