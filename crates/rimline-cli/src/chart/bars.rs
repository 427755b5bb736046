//! A row for each thing, with bars or dots along one horizontal axis.

use super::axis::Axis;
use super::svg::{Anchor, Ink, Label, Svg, text_width};
use super::{Key, Target};

/// How a group's values are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BarsKind {
    /// A bar each, one below the other.
    Grouped,
    /// One bar, its parts in a row; the axis is linear.
    Stacked,
    /// A dot each, all on the group's line: for many groups.
    Dots,
}

/// Groups of values.
#[derive(Clone, Debug)]
pub(crate) struct Bars {
    pub(crate) kind: BarsKind,
    pub(crate) axis: Axis,
    /// One for each value that a group may have.
    pub(crate) keys: Vec<Key>,
    pub(crate) groups: Vec<Group>,
    /// Numbers to draw a line at, with their names.
    pub(crate) marks: Vec<(f64, String)>,
}

/// A row, or a few that belong together.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) name: String,
    /// A heading above the row, where a new kind of rows begins.
    pub(crate) heading: String,
    /// In the order of the keys.
    pub(crate) values: Vec<Option<Value>>,
    /// Stands at the end of a stacked bar.
    pub(crate) remark: String,
}

/// A length.
#[derive(Clone, Debug, Default)]
pub(crate) struct Value {
    pub(crate) length: f64,
    /// From where to where values spread.
    pub(crate) spread: Option<(f64, f64)>,
    /// Stands at a bar's end.
    pub(crate) label: String,
    /// What a pointer on it is told.
    pub(crate) tip: String,
}

const WIDTH: f64 = 960.0;
const BAR: f64 = 17.0;
/// From a dot of a group to the next, and what lies between groups beside that.
const DOT: f64 = 5.0;
const DOTS_GAP: f64 = 9.0;
const GAP: f64 = 10.0;
const HEADING: f64 = 24.0;

impl Bars {
    fn rows(&self) -> f64 {
        match self.kind {
            BarsKind::Grouped => self.keys.len() as f64 * BAR + GAP,
            BarsKind::Stacked => 26.0 + GAP,
            BarsKind::Dots => self.keys.len() as f64 * DOT + DOTS_GAP,
        }
    }

    pub(super) fn draw(&self, target: Target<'_>) -> Svg {
        let names = self.groups.iter().map(|group| text_width(&group.name, 13.0));
        let left = (names.fold(60.0, f64::max) + 26.0).min(360.0);
        let ends = self.groups.iter().flat_map(|group| {
            group.values.iter().flatten().map(|value| value.label.as_str()).chain([group.remark.as_str()])
        });
        let right = WIDTH - (ends.map(|end| text_width(end, 12.0)).fold(0.0, f64::max) + 22.0).min(240.0);
        let headings = self.groups.iter().filter(|group| !group.heading.is_empty()).count();
        let legend = |svg: &mut Svg| {
            if self.keys.len() > 1 { svg.legend(&self.keys, left, 6.0, WIDTH - 20.0) + 8.0 } else { 8.0 }
        };
        let top = legend(&mut Svg::new(WIDTH, 0.0, target)) + if self.marks.is_empty() { 0.0 } else { 18.0 };
        let bottom = top + self.groups.len() as f64 * self.rows() + headings as f64 * HEADING + 6.0;
        let mut svg = Svg::new(WIDTH, bottom + 52.0, target);
        legend(&mut svg);
        self.draw_axis(&mut svg, [left, right], [top, bottom]);
        let mut y = top + 4.0;
        for group in &self.groups {
            if !group.heading.is_empty() {
                let label =
                    Label { x: left - 12.0, y: y + 17.0, size: 12.0, anchor: Anchor::End, ink: Ink::Muted, bold: true };
                svg.text(label, &group.heading);
                y += HEADING;
            }
            self.draw_group(&mut svg, group, [left, right], y);
            y += self.rows();
        }
        svg
    }

    fn draw_axis(&self, svg: &mut Svg, [left, right]: [f64; 2], [top, bottom]: [f64; 2]) {
        let small =
            Label { x: 0.0, y: bottom + 18.0, size: 12.0, anchor: Anchor::Middle, ink: Ink::Muted, bold: false };
        let at = |value: f64| left + self.axis.place(value) * (right - left);
        for tick in self.axis.ticks(9) {
            let x = at(tick);
            svg.line([x, top], [x, bottom], Ink::Grid, 1.0, "");
            svg.text(Label { x, ..small }, &(self.axis.format)(tick));
        }
        for (value, name) in &self.marks {
            svg.line([at(*value), top - 4.0], [at(*value), bottom], Ink::Muted, 1.5, "6 4");
            svg.text(Label { x: at(*value), y: top - 8.0, ..small }, name);
        }
        svg.line([left, top], [left, bottom], Ink::Muted, 1.0, "");
        let title = Label { x: f64::midpoint(left, right), y: bottom + 42.0, size: 13.0, ink: Ink::Text, ..small };
        svg.text(title, &self.axis.title);
    }

    fn draw_group(&self, svg: &mut Svg, group: &Group, [left, right]: [f64; 2], top: f64) {
        let at = |value: f64| left + self.axis.place(value) * (right - left);
        let middle = top + 0.5 * (self.rows() - if self.kind == BarsKind::Dots { 0.0 } else { GAP });
        let name =
            Label { x: left - 12.0, y: middle + 4.5, size: 13.0, anchor: Anchor::End, ink: Ink::Text, bold: false };
        svg.text(name, &group.name);
        let end = Label { anchor: Anchor::Start, size: 12.0, ..name };
        if self.kind == BarsKind::Dots {
            svg.line([left, middle], [right, middle], Ink::Grid, 1.0, "");
        }
        let mut sum = 0.0;
        for (index, (key, value)) in self.keys.iter().zip(&group.values).enumerate() {
            let Some(value) = value else { continue };
            match self.kind {
                BarsKind::Grouped => {
                    let y = top + index as f64 * BAR;
                    svg.bar([left, y + 1.5], [at(value.length) - left, BAR - 3.0], key, &value.tip);
                    draw_spread(svg, value, Ink::Text, y + 0.5 * BAR, at);
                    let past = value.spread.map_or(value.length, |(_, high)| high.max(value.length));
                    svg.text(Label { x: at(past) + 6.0, y: y + 0.5 * BAR + 4.0, ..end }, &value.label);
                }
                BarsKind::Stacked => {
                    let [begin, finish] = [at(sum), at(sum + value.length)];
                    svg.rectangle([begin, top], [finish - begin - 1.0, 26.0], Ink::Key(key.colour), &value.tip);
                    if finish - begin > text_width(&value.label, 12.0) + 6.0 {
                        let x = f64::midpoint(begin, finish);
                        let ink = Ink::Ground;
                        svg.text(
                            Label { x, y: middle + 4.5, ink, bold: true, anchor: Anchor::Middle, ..end },
                            &value.label,
                        );
                    }
                    sum += value.length;
                }
                BarsKind::Dots => {
                    // A little apart, so that equal values show both.
                    let y = middle + DOT * (index as f64 - 0.5 * (self.keys.len() - 1) as f64);
                    draw_spread(svg, value, Ink::Key(key.colour), y, at);
                    svg.mark([at(value.length), y], key, 4.5, &value.tip);
                }
            }
        }
        if self.kind == BarsKind::Stacked {
            svg.text(Label { x: at(sum) + 6.0, ..end }, &group.remark);
        }
    }
}

/// A line over the spread, where it is long enough to see.
fn draw_spread(svg: &mut Svg, value: &Value, ink: Ink, y: f64, at: impl Fn(f64) -> f64) {
    if let Some((low, high)) = value.spread
        && at(high) - at(low) > 3.0
    {
        svg.line([at(low), y], [at(high), y], ink, 1.5, "");
    }
}
