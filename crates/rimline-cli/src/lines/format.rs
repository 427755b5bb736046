//! The formats of drawings.

use std::io::{self, Write};

use clap::ValueEnum;

use super::args::{Format, LinesArgs};
use super::{Picture, dxf, json, pdf, png, svg};
use crate::failure::UsageError;
use crate::target::{check_ending, check_folder};

impl Format {
    /// The format that is asked for, or that the name of the result has. Of numbered drawings the name is a folder's.
    pub(crate) fn of(args: &LinesArgs) -> Result<Self, UsageError> {
        if args.frames.is_some() {
            check_folder(&args.out, |out| UsageError::DrawingsFolderEnding { out })?;
            return Ok(args.format.unwrap_or(Self::Svg));
        }
        let ending = args.out.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
        let named = ending.and_then(|ending| Self::from_str(&ending, false).ok());
        let format = args.format.or(named).ok_or_else(|| UsageError::LinesFormat { out: args.out.clone() })?;
        check_ending(&args.out, format.ending())?;
        Ok(format)
    }

    /// The ending of its files.
    pub(crate) fn ending(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Pdf => "pdf",
            Self::Dxf => "dxf",
            Self::Json => "json",
            Self::Png => "png",
        }
    }

    /// The format in a sentence.
    pub(crate) fn said(self) -> &'static str {
        match self {
            Self::Svg => "an SVG",
            Self::Pdf => "a PDF",
            Self::Dxf => "a DXF",
            Self::Json => "JSON",
            Self::Png => "a PNG",
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
