//! The formats of drawings.

use std::io::{self, Write};

use clap::ValueEnum;

use super::args::LinesArgs;
use super::{Picture, dxf, json, pdf, png, svg};
use crate::failure::UsageError;
use crate::target::check_ending;

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A vector graphic for browsers and Inkscape, with a layer a class
    Svg,
    /// A page for printing, with a layer a class
    Pdf,
    /// A drawing for CAD (R12), with a layer a class; in millimetres of the page
    Dxf,
    /// All spans and chains with their ids
    Json,
    /// A picture
    Png,
}

impl Format {
    /// The format that is asked for, or that the name of the result has.
    pub(crate) fn of(args: &LinesArgs) -> Result<Self, UsageError> {
        let ending = args.out.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
        let named = ending.and_then(|ending| Self::from_str(&ending, false).ok());
        let format = args.format.or(named).ok_or_else(|| UsageError::LinesFormat { out: args.out.clone() })?;
        check_ending(&args.out, format.ending())?;
        Ok(format)
    }

    /// The ending of its files.
    fn ending(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Pdf => "pdf",
            Self::Dxf => "dxf",
            Self::Json => "json",
            Self::Png => "png",
        }
    }

    pub(crate) fn write(self, to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
        match self {
            Self::Svg => svg::write(to, picture),
            Self::Pdf => pdf::write(to, picture),
            Self::Dxf => dxf::write(to, picture),
            Self::Json => json::write(to, picture),
            Self::Png => png::write(to, picture),
        }
    }
}
