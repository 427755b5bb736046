//! A row for each thing, with bars or dots along one horizontal axis.

use std::io;

use plotters::prelude::*;

use super::axis::{Axis, Coordinate};
use super::svg::{
    Area, Drawn, END, Ink, LINE, Label, Legend, MIDDLE, NAME, NUMBERS, Plotted, SMALL, START, TICK, Tips, closed,
    lines, mark, path, text_width, width, wrapped,
};
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
    /// Tooltip of the value.
    pub(crate) tip: String,
}

/// A stacked bar.
const STACKED: i32 = 52;
/// From a dot of a group to the next, and what lies between groups beside that.
const DOT: i32 = 12;
const DOTS_GAP: i32 = 20;
const GAP: i32 = 20;
const HEADING: i32 = 48;

/// Where everything lies.
struct Layout {
    narrow: bool,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
    title: Vec<String>,
}

impl Bars {
    /// The height of a group without its name.
    fn row(&self) -> i32 {
        let keys = self.keys.len() as i32;
        match self.kind {
            BarsKind::Grouped => keys * LINE + GAP,
            BarsKind::Stacked => STACKED + GAP,
            BarsKind::Dots => keys * DOT + DOTS_GAP,
        }
    }

    /// The height of a group with its heading, and on a narrow plot with its name above it.
    fn height(&self, group: &Group, narrow: bool) -> i32 {
        let heading = if group.heading.is_empty() { 0 } else { HEADING };
        heading + self.row() + if narrow { LINE } else { 0 }
    }

    fn layout(&self, target: Target<'_>) -> Layout {
        let narrow = target.is_narrow();
        let names = self.groups.iter().flat_map(|group| [group.name.as_str(), group.heading.as_str()]);
        let widest = names.map(|name| text_width(name, 26.0)).fold(120, i32::max);
        let left = if narrow { 28 } else { (widest + 52).min(720) };
        let ends = self.groups.iter().flat_map(|group| {
            group.values.iter().flatten().map(|value| value.label.as_str()).chain([group.remark.as_str()])
        });
        let end = ends.map(|end| text_width(end, SMALL)).fold(0, i32::max) + 44;
        let right = width(target) - end.min(width(target) / 4);
        let heights = self.groups.iter().map(|group| self.height(group, narrow)).sum::<i32>();
        let title = wrapped(&self.axis.title, 26.0, right - left);
        Layout { narrow, left, right, top: 0, bottom: heights + 20, title }
    }

    pub(super) fn draw(&self, target: Target<'_>) -> io::Result<String> {
        let mut layout = self.layout(target);
        let keys = if self.keys.len() > 1 { self.keys.as_slice() } else { &[] };
        let legend_left = if layout.narrow { 8 } else { layout.left };
        let legend = Legend::new(keys, legend_left, width(target) - 40);
        layout.top = legend.height + if self.marks.is_empty() { 16 } else { 48 };
        layout.bottom += layout.top;
        let height = layout.bottom + NUMBERS + layout.title.len() as i32 * LINE + 16;
        super::svg::drawing(target, height, |area, tips| {
            legend.draw(area)?;
            let size = [layout.right - layout.left, layout.bottom - layout.top];
            let coordinates = [self.axis.across(size[0]), Coordinate::rows(size[1])];
            let plotted = Plotted::new(area, (layout.left, layout.top), size, coordinates, [0, NUMBERS])?;
            let at = |value: f64| plotted.at(value, 0.0).0;
            self.draw_marks(area, &layout, at)?;
            let mut y = layout.top + 10;
            for group in &self.groups {
                self.draw_group(area, group, &layout, y, at, tips)?;
                y += self.height(group, layout.narrow);
            }
            let axis = [(layout.left, layout.top), (layout.left, layout.bottom)];
            path(area, &axis, Ink::Muted.stroke(2), None)?;
            let middle = i32::midpoint(layout.left, layout.right);
            let title = Label { anchor: MIDDLE, ..NAME };
            lines(area, title, (middle, layout.bottom + NUMBERS + 8), &layout.title)
        })
    }

    fn draw_marks(&self, area: &Area<'_>, layout: &Layout, at: impl Fn(f64) -> i32) -> Drawn {
        for (value, name) in &self.marks {
            let x = at(*value);
            path(area, &[(x, layout.top - 8), (x, layout.bottom)], Ink::Muted.stroke(3), Some([12, 8]))?;
            TICK.draw(area, (x, layout.top - 24), name)?;
        }
        Ok(())
    }

    fn draw_group(
        &self,
        area: &Area<'_>,
        group: &Group,
        layout: &Layout,
        mut top: i32,
        at: impl Fn(f64) -> i32,
        tips: &mut Tips,
    ) -> Drawn {
        let (x, anchor) = if layout.narrow { (layout.left + 12, START) } else { (layout.left - 24, END) };
        // The grid's lines stay off the letters.
        let clear = |text: &str, y: i32| {
            let end = x + text_width(text, 26.0);
            let ground = Rectangle::new([(x - 4, y - 16), (end, y + 16)], Ink::Ground.rgb().filled());
            if layout.narrow { area.draw(&ground) } else { Ok(()) }
        };
        if !group.heading.is_empty() {
            let y = top + 28;
            clear(&group.heading, y)?;
            Label { size: SMALL, ink: Ink::Muted, bold: true, anchor }.draw(area, (x, y), &group.heading)?;
            top += HEADING;
        }
        let gap = if self.kind == BarsKind::Dots { 0 } else { GAP };
        let mut middle = top + (self.row() - gap) / 2;
        if layout.narrow {
            clear(&group.name, top + 16)?;
            NAME.draw(area, (x, top + 16), &group.name)?;
            top += LINE;
            middle += LINE;
        } else {
            Label { anchor, ..NAME }.draw(area, (x, middle), &group.name)?;
        }
        if self.kind == BarsKind::Dots {
            path(area, &[(layout.left, middle), (layout.right, middle)], Ink::Grid.stroke(2), None)?;
        }
        let label = Label { ink: Ink::Text, anchor: START, ..TICK };
        let end = |(x, y): (i32, i32), text: &str| {
            let ground = [(x - 4, y - 14), (x + text_width(text, SMALL), y + 14)];
            area.draw(&Rectangle::new(ground, Ink::Ground.rgb().filled()))?;
            label.draw(area, (x, y), text)
        };
        let mut sum = 0.0;
        for (index, (key, value)) in (0..).zip(self.keys.iter().zip(&group.values)) {
            let Some(value) = value else { continue };
            match self.kind {
                BarsKind::Grouped => {
                    let y = top + index * LINE;
                    draw_bar(area, [(at(0.0), y + 3), (at(value.length), y + 31)], key)?;
                    tips.over((at(0.0), y + 3), (at(value.length), y + 31), &value.tip);
                    draw_spread(area, value, Ink::Text, y + 17, &at)?;
                    let past = value.spread.map_or(value.length, |(_, high)| high.max(value.length));
                    end((at(past) + 12, y + 17), &value.label)?;
                }
                BarsKind::Stacked => {
                    let [begin, finish] = [at(sum), at(sum + value.length)];
                    let corners = [(begin, top), ((finish - 2).max(begin), top + STACKED)];
                    area.draw(&Rectangle::new(corners, Ink::Key(key.colour).rgb().filled()))?;
                    tips.over(corners[0], corners[1], &value.tip);
                    if finish - begin > text_width(&value.label, SMALL) + 12 {
                        let inside = Label { size: SMALL, ink: Ink::Ground, bold: true, anchor: MIDDLE };
                        inside.draw(area, (i32::midpoint(begin, finish), middle), &value.label)?;
                    }
                    sum += value.length;
                }
                BarsKind::Dots => {
                    // A little apart, so that equal values show both.
                    let y = middle + (f64::from(DOT) * (f64::from(index) - 0.5 * (self.keys.len() - 1) as f64)) as i32;
                    draw_spread(area, value, Ink::Key(key.colour), y, &at)?;
                    mark(area, (at(value.length), y), key, 9.0)?;
                    tips.at((at(value.length), y), &value.tip);
                }
            }
        }
        if self.kind == BarsKind::Stacked {
            end((at(sum) + 12, middle), &group.remark)?;
        }
        Ok(())
    }
}

/// A key's bar: filled, or an outline.
fn draw_bar(area: &Area<'_>, [(left, top), (right, bottom)]: [(i32, i32); 2], key: &Key) -> Drawn {
    let ink = Ink::Key(key.colour);
    if !key.hollow {
        return area.draw(&Rectangle::new([(left, top), (right, bottom)], ink.rgb().filled()));
    }
    let (left, top, right, bottom) = (left + 2, top + 2, (right - 2).max(left + 3), bottom - 2);
    area.draw(&Rectangle::new([(left, top), (right, bottom)], Ink::Ground.rgb().filled()))?;
    closed(area, vec![(left, top), (right, top), (right, bottom), (left, bottom)], ink.stroke(4))
}

/// A line over the spread, where it is long enough to see.
fn draw_spread(area: &Area<'_>, value: &Value, ink: Ink, y: i32, at: impl Fn(f64) -> i32) -> Drawn {
    match value.spread.map(|(low, high)| (at(low), at(high))) {
        Some((low, high)) if high - low > 6 => path(area, &[(low, y), (high, y)], ink.stroke(3), None),
        _ => Ok(()),
    }
}
