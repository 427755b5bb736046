//! Small plots side by side on the same axes, to be compared along rows and columns.

use super::axis::Axis;
use super::svg::{Anchor, Ink, Label, Svg};
use super::{Key, Target};

/// A table of small plots.
#[derive(Clone, Debug)]
pub(crate) struct Panels {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// One for each curve that a panel may have.
    pub(crate) keys: Vec<Key>,
    pub(crate) columns: Vec<String>,
    pub(crate) rows: Vec<PanelRow>,
    /// A number on the y axis to draw a line at in each panel.
    pub(crate) mark: Option<f64>,
}

/// Panels side by side.
#[derive(Clone, Debug)]
pub(crate) struct PanelRow {
    pub(crate) name: String,
    /// As many as there are columns; fewer where there is nothing to show yet.
    pub(crate) panels: Vec<Panel>,
}

/// One small plot: curves in the order of the keys.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panel {
    pub(crate) curves: Vec<Vec<[f64; 2]>>,
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 16.0;
const GAP: f64 = 14.0;
const HEIGHT: f64 = 170.0;
const MARK: f64 = 3.2;
const SMALL: f64 = 12.0;

impl Panels {
    pub(super) fn draw(&self, target: Target<'_>) -> Svg {
        let legend = |svg: &mut Svg| svg.legend(&self.keys, LEFT, 6.0, WIDTH - RIGHT) + 8.0;
        let top = legend(&mut Svg::new(WIDTH, 0.0, target)) + 24.0;
        let bottom = top + self.rows.len() as f64 * (HEIGHT + GAP) - GAP;
        let mut svg = Svg::new(WIDTH, bottom + 54.0, target);
        legend(&mut svg);
        let columns = self.columns.len().max(1) as f64;
        let width = (WIDTH - LEFT - RIGHT - (columns - 1.0) * GAP) / columns;
        let left_of = |column: usize| LEFT + column as f64 * (width + GAP);
        let plain = Label { x: 0.0, y: 0.0, size: SMALL, anchor: Anchor::Middle, ink: Ink::Muted, bold: false };
        for (column, name) in self.columns.iter().enumerate() {
            let x = left_of(column) + 0.5 * width;
            svg.text(Label { x, y: top - 10.0, size: 13.0, ink: Ink::Text, bold: true, ..plain }, name);
        }
        for (row, PanelRow { name, panels }) in self.rows.iter().enumerate() {
            let above = top + row as f64 * (HEIGHT + GAP);
            svg.upright_text(42.0, above + 0.5 * HEIGHT, 13.0, name);
            for tick in self.y.ticks(6) {
                let y = above + HEIGHT * (1.0 - self.y.place(tick)) + 4.0;
                svg.text(Label { x: LEFT - 6.0, y, anchor: Anchor::End, ..plain }, &(self.y.format)(tick));
            }
            for (column, panel) in panels.iter().enumerate() {
                self.draw_panel(&mut svg, panel, [left_of(column), above], width);
            }
        }
        for column in 0..self.columns.len() {
            for tick in self.x.ticks(5) {
                let x = left_of(column) + self.x.place(tick) * width;
                svg.text(Label { x, y: bottom + 18.0, ..plain }, &(self.x.format)(tick));
            }
        }
        let title = Label { x: f64::midpoint(LEFT, WIDTH - RIGHT), y: bottom + 42.0, size: 13.0, ..plain };
        svg.text(Label { ink: Ink::Text, ..title }, &self.x.title);
        svg.upright_text(18.0, f64::midpoint(top, bottom), 13.0, &self.y.title);
        svg
    }

    fn draw_panel(&self, svg: &mut Svg, panel: &Panel, [left, top]: [f64; 2], width: f64) {
        let bottom = top + HEIGHT;
        let at = |[x, y]: [f64; 2]| [left + self.x.place(x) * width, bottom - self.y.place(y) * HEIGHT];
        for tick in self.y.ticks(6) {
            let [_, y] = at([0.0, tick]);
            svg.line([left, y], [left + width, y], Ink::Grid, 1.0, "");
        }
        for tick in self.x.ticks(5) {
            let [x, _] = at([tick, 1.0]);
            svg.line([x, top], [x, bottom], Ink::Grid, 1.0, "");
        }
        if let Some(mark) = self.mark {
            let [_, y] = at([0.0, mark]);
            svg.line([left, y], [left + width, y], Ink::Muted, 1.5, "6 4");
        }
        svg.line([left, bottom], [left + width, bottom], Ink::Muted, 1.0, "");
        for (key, curve) in self.keys.iter().zip(&panel.curves) {
            let places: Vec<[f64; 2]> = curve.iter().map(|&point| at(point)).collect();
            svg.polyline(&places, Ink::Key(key.colour), 1.6, if key.hollow { "7 4" } else { "" });
            for (place, [x, y]) in places.into_iter().zip(curve) {
                let tip = format!("{}, {}: {}", key.name, (self.x.format)(*x), (self.y.format)(*y));
                svg.mark(place, key, MARK, &tip);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Chart, Scale};

    #[test]
    fn every_point_has_its_mark_and_missing_panels_are_left_out() {
        let axis = |title: &str| Axis::over(title, Scale::Linear, |value| format!("{value}"), [0.0, 3.0]);
        let key = |name: &str, colour| Key { name: name.to_owned(), colour, shape: 0, hollow: false };
        let panel = Panel { curves: vec![vec![[0.0, 1.0], [3.0, 2.0]], vec![[1.0, 1.0]]] };
        let chart = Chart::Panels(Panels {
            x: axis("frame"),
            y: axis("time"),
            keys: vec![key("one", 0), key("other", 1)],
            columns: vec!["here".to_owned(), "there".to_owned()],
            rows: vec![PanelRow { name: "row".to_owned(), panels: vec![panel] }],
            mark: Some(1.0),
        });
        for target in [Target::Page, Target::File { title: "title", origin: "origin" }] {
            let svg = chart.svg(target);
            // Two in the legend.
            assert_eq!(svg.matches("<circle").count(), 5);
            assert_eq!(svg.matches("<polyline").count(), 2);
            assert!(["here", "there", "row", "frame", "time"].iter().all(|text| svg.contains(&format!(">{text}<"))));
        }
    }
}
