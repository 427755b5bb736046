//! Small plots side by side on the same axes, to be compared along rows and columns.

use std::io;

use super::axis::Axis;
use super::svg::{
    Area, Drawn, Ink, LINE, Label, Legend, MIDDLE, NAME, NUMBERS, Plotted, Tips, lines, mark, path, width, wrapped,
};
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
    /// A panel for each column; fewer where there is nothing to show yet.
    pub(crate) panels: Vec<Panel>,
}

/// One small plot: curves in the order of the keys.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panel {
    pub(crate) curves: Vec<Vec<[f64; 2]>>,
}

const GAP: i32 = 36;
const HEIGHT: i32 = 340;
const MARK: f64 = 6.4;
/// The name of a row of panels, and of a panel.
const NAMES: i32 = 44;

/// A table of panels as it fits the width: fewer side by side on a narrow one.
struct Layout {
    /// Where text begins.
    margin: i32,
    left: i32,
    top: i32,
    /// Width of a panel.
    width: i32,
    side_by_side: usize,
}

impl Layout {
    fn new(columns: usize, target: Target<'_>, top: i32) -> Self {
        let narrow = target.is_narrow();
        let side_by_side = if narrow { columns.clamp(1, 2) } else { columns.max(1) };
        let (margin, left) = if narrow { (8, 84) } else { (36, 152) };
        let count = side_by_side as i32;
        let width = (width(target) - left - 24 - (count - 1) * GAP) / count;
        Self { margin, left, top, width, side_by_side }
    }

    /// A row's height: its name, and lines of panels with theirs.
    fn row(&self, columns: usize) -> i32 {
        NAMES + columns.max(1).div_ceil(self.side_by_side) as i32 * (NAMES + HEIGHT + NUMBERS)
    }

    /// The upper left corner of a panel.
    fn corner(&self, row: usize, column: usize, columns: usize) -> (i32, i32) {
        let (line, place) = (column / self.side_by_side, column % self.side_by_side);
        let x = self.left + place as i32 * (self.width + GAP);
        let top = self.top + row as i32 * self.row(columns) + NAMES;
        (x, top + line as i32 * (NAMES + HEIGHT + NUMBERS) + NAMES)
    }
}

impl Panels {
    pub(super) fn draw(&self, target: Target<'_>) -> io::Result<String> {
        let margin = Layout::new(self.columns.len(), target, 0).margin;
        let legend = Legend::new(&self.keys, margin, width(target) - 32);
        let above = wrapped(&format!("Upwards: {}. Across: {}.", self.y.title, self.x.title), 26.0, width(target) - 40);
        let top = legend.height + above.len() as i32 * LINE + 12;
        let layout = Layout::new(self.columns.len(), target, top);
        let height = top + self.rows.len() as i32 * layout.row(self.columns.len());
        super::svg::drawing(target, height, |area, tips| {
            legend.draw(area)?;
            lines(area, NAME, (margin, legend.height + 12), &above)?;
            for (row, PanelRow { name, panels }) in self.rows.iter().enumerate() {
                let (_, y) = layout.corner(row, 0, self.columns.len());
                Label { bold: true, ..NAME }.draw(area, (margin, y - NAMES - 20), name)?;
                for (column, panel) in panels.iter().enumerate() {
                    let corner = layout.corner(row, column, self.columns.len());
                    let title = Label { anchor: MIDDLE, ..NAME };
                    let name = self.columns.get(column).map_or("", String::as_str);
                    title.draw(area, (corner.0 + layout.width / 2, corner.1 - 22), name)?;
                    let is_first = column % layout.side_by_side == 0;
                    self.draw_panel(
                        area,
                        panel,
                        corner,
                        [layout.width, if is_first { layout.left - 8 } else { 0 }],
                        tips,
                    )?;
                }
            }
            Ok(())
        })
    }

    fn draw_panel(
        &self,
        area: &Area<'_>,
        panel: &Panel,
        corner: (i32, i32),
        [width, left]: [i32; 2],
        tips: &mut Tips,
    ) -> Drawn {
        let coordinates = [self.x.across(width), self.y.upright(HEIGHT)];
        let plotted = Plotted::new(area, corner, [width, HEIGHT], coordinates, [left, NUMBERS])?;
        if let Some(mark) = self.mark {
            let (_, y) = plotted.at(0.0, mark);
            path(area, &[(corner.0, y), (corner.0 + width, y)], Ink::Muted.stroke(3), Some([12, 8]))?;
        }
        for (key, curve) in self.keys.iter().zip(&panel.curves) {
            let places: Vec<(i32, i32)> = curve.iter().map(|&[x, y]| plotted.at(x, y)).collect();
            path(area, &places, Ink::Key(key.colour).stroke(3), key.hollow.then_some([14, 8]))?;
            for (at, [x, y]) in places.into_iter().zip(curve) {
                mark(area, at, key, MARK)?;
                tips.at(at, &format!("{}, {}: {}", key.name, (self.x.format)(*x), (self.y.format)(*y)));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Chart, PALETTE, Scale};

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
        for target in [Target::Page, Target::Phone, Target::File { title: "title", origin: "origin" }] {
            let svg = chart.svg(target).expect("it goes to memory");
            // Two in the legend, each with its rim.
            assert_eq!(svg.matches("<circle").count(), 2 * 5);
            assert!(svg.matches(&format!("stroke=\"#{:06X}\" stroke-width=\"3\"", PALETTE[0].0)).count() == 1);
            assert!(["here", "row"].iter().all(|text| svg.contains(&format!(">\n{text}\n<"))));
            assert!(svg.contains("Upwards: time. Across: frame."));
            assert!(!svg.contains("there"));
        }
    }
}
