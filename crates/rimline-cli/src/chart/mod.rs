//! Plots: curves and points in a plane, rows of bars, and tables of small plots. The caller supplies the data; this
//! module knows nothing of silhouettes.
//!
//! plotters draws plots as SVG for the report's page, and in the same colours for its PNG files. The page's style sheet
//! replaces the colours on a dark background.

mod axis;
mod bars;
mod labels;
mod panels;
mod raster;
mod svg;
mod text_width;
mod xy;

use std::io;

pub(crate) use axis::{Axis, Scale};
pub(crate) use bars::{Bars, BarsKind, Group, Value};
pub(crate) use panels::{Panel, PanelRow, Panels};
pub(crate) use raster::write_png;
pub(crate) use svg::{PALETTE, ROLES, escape};
pub(crate) use xy::{Curve, Plane, Point, ZeroBand};

/// A plot of any kind.
#[derive(Clone, Debug)]
pub(crate) enum Chart {
    /// Two axes, curves or points.
    Plane(Plane),
    /// A row for each thing, one horizontal axis.
    Bars(Bars),
    /// Small plots side by side on the same axes.
    Panels(Panels),
}

/// The look that several marks of a plot have in common: a name in the legend, a colour and a shape. Shapes differ, so
/// that colour is never the only difference.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub(crate) name: String,
    /// Index into the palette.
    pub(crate) colour: usize,
    /// Index into the marker shapes.
    pub(crate) shape: usize,
    /// Marks are drawn hollow, lines dashed.
    pub(crate) hollow: bool,
}

/// Where a drawing goes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target<'a> {
    /// The page, whose text says what the plot is.
    Page,
    /// The page on a narrow screen: the same plot drawn for that width, in letters of the same size.
    Phone,
    /// A file by itself, with a heading and a line below that says where the figures are from.
    File { title: &'a str, origin: &'a str },
}

impl Target<'_> {
    fn is_narrow(self) -> bool {
        matches!(self, Self::Phone)
    }
}

impl Chart {
    /// The drawing.
    pub(crate) fn svg(&self, target: Target<'_>) -> io::Result<String> {
        match self {
            Self::Plane(plane) => plane.draw(target),
            Self::Bars(bars) => bars.draw(target),
            Self::Panels(panels) => panels.draw(target),
        }
    }
}
