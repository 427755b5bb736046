//! Options of `rimline lines`.

use std::path::PathBuf;
use std::str::FromStr as _;

use clap::{Args, ValueEnum};
use rimline_lines::{Classes, LineClass};

use crate::coordinates::Coordinate;
use crate::failure::Failure;
use crate::input_args::{CameraArgs, JobsArgs, PoseArgs, ReadArgs, verbatim};
use crate::output::note;
use crate::shadow::args::MAX_FRAMES;
use crate::spec::{self, Side};

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A vector graphic for browsers and Inkscape, with a layer a class
    Svg,
    /// A page for printing, with a layer a class
    Pdf,
    /// A drawing for CAD (R12), with a layer a class; in millimetres of the page, or see --dxf-units
    Dxf,
    /// All spans and chains, with the indices of their objects, edges and faces
    Json,
    /// A picture
    Png,
}

#[derive(Args, Debug)]
#[command(
    help_template = verbatim(EXAMPLES),
    after_help = REMARKS,
    mut_arg("weld", |weld| weld.default_value("position")),
    mut_arg("time", |time| time.help("The time of the drawing in seconds, or of the first one, for animations")),
)]
pub(crate) struct LinesArgs {
    /// One or more .gltf, .glb, .obj, .ply, .stl or .npz files, or - for standard input. All are drawn together
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) read: ReadArgs,

    #[command(flatten)]
    pub(crate) pose: PoseArgs,

    /// The side that is seen: front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees: to the right of the front,
    /// and above the ground. The front is +Z, the top is +Y. The view is orthographic unless --fov is given
    #[arg(
        long,
        value_name = "SIDE|AZ,EL",
        allow_hyphen_values = true,
        value_parser = Side::from_str,
        default_value = "iso",
        conflicts_with = "eye",
    )]
    pub(crate) view: Side,

    /// The position of the eye. The drawing has perspective, unless --ortho is given
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::coordinates::<3>)]
    pub(crate) eye: Option<[Coordinate; 3]>,

    /// The point that the eye looks at. By default it is the middle of the models
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::coordinates::<3>, requires = "eye")]
    pub(crate) target: Option<[Coordinate; 3]>,

    /// The vertical field of view in degrees. With --view it makes the view perspective, from where a ball around the models fits in
    /// it; with --eye it is what the page shows [default: what the models take, at most 100]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = spec::field_of_view)]
    pub(crate) fov: Option<f32>,

    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    /// Draw what --eye and --target see without perspective
    #[arg(long, requires = "eye", conflicts_with_all = ["fov", "camera"])]
    pub(crate) ortho: bool,

    /// The least angle between two faces whose edge is drawn as a crease, in degrees [default: 33, which is no angle of a regular prism]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = spec::crease)]
    crease: Option<f64>,

    /// The classes of lines, separated by commas: silhouette (between a face that is seen from its front and one from its back),
    /// boundary (one face), non-manifold (more than two), crease, intersection (faces pass through each other). Or `all`
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "all", value_parser = parse_classes)]
    classes: Vec<Classes>,

    /// How lines behind faces are drawn
    #[arg(long, value_enum, default_value_t = Hidden::None)]
    pub(crate) hidden: Hidden,

    /// The page: A0 to A5, upright or lying as the drawing needs it, or its width and height in millimetres, such as 200x150.
    /// By default it is A4; with --scale it is as large as the drawing
    #[arg(long, value_name = "A4|WxH", value_parser = parse_paper)]
    pub(crate) page: Option<Paper>,

    /// The scale: `fit` to the page, or such as 1:50. Only without perspective
    #[arg(long, value_name = "fit|1:N", default_value = "fit", value_parser = parse_scale)]
    pub(crate) scale: Scale,

    /// The unit of the files, for --scale 1:N and --dxf-units model. By default it is a metre for --scale, as in glTF, and unknown in a DXF
    #[arg(long, value_enum)]
    pub(crate) unit: Option<Unit>,

    /// How a DXF is measured
    #[arg(long, value_enum, default_value_t = DxfUnits::Page)]
    pub(crate) dxf_units: DxfUnits,

    /// A TOML file with widths, colours and dashes of lines
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) style: Option<PathBuf>,

    /// Pixels an inch of a PNG, 10 to 2400 [default: 150]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=2400))]
    dpi: Option<u32>,

    /// Make so many numbered drawings of a film in the folder --out, all at one scale. --animation moves the models from --time on,
    /// --turn moves the eye
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MAX_FRAMES))]
    pub(crate) frames: Option<u32>,

    /// Drawings a second of the animation, 0.001 to 100000 [default: 25]
    #[arg(long, value_name = "N", requires = "frames", allow_hyphen_values = true, value_parser = spec::within(1e-3, 1e5))]
    fps: Option<f32>,

    /// Turn the eye in the course of the film by so many degrees to the right around what it looks at. The next drawing would be
    /// at that angle, so that a film of 360 begins again
    #[arg(long, value_name = "DEG", default_value = "0", requires = "frames", allow_hyphen_values = true, value_parser = spec::within(-36e3, 36e3))]
    pub(crate) turn: f32,

    /// Where to write the drawing; its ending is the format: .svg, .pdf, .dxf, .json or .png. With --frames it is the folder for
    /// 0000.svg, 0001.svg and so on, which is made if it does not exist
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) out: PathBuf,

    /// The format, where the name does not tell it. With --frames it is SVG by default
    #[arg(long, value_enum)]
    pub(crate) format: Option<Format>,

    /// Print JSON: a line for each job, and one for all
    #[arg(id = "json", long)]
    _json: bool,

    #[command(flatten)]
    _jobs: JobsArgs,
}

const EXAMPLES: &str = "\
Examples:
  rimline lines house.obj --out house.svg
  rimline lines house.obj --view front --scale 1:50 --hidden dashed --out front.pdf
  rimline lines fox.glb --animation Run --view 30,15 --out fox.svg
  rimline lines room.glb --camera door --out room.svg
  rimline lines part.obj --unit mm --dxf-units model --view top --out part.dxf
  rimline lines parts/*.stl --out drawings/{stem}.pdf
  rimline lines fox.glb --animation Run --frames 24 --turn 90 --out frames --format png

A style; widths and dashes in millimetres. All but its last line are defaults, with --hidden dashed.
Default widths are halved if, in the first drawing, more than a fifth of the visible lines is where
ink covers most of the page:
  [silhouette]
  width = 0.5
  color = \"#000000\"
  [crease]
  width = 0.25
  [hidden]                 # all hidden lines
  width = 0.18
  dash = [1.5, 0.8]
  [hidden.crease]          # only hidden creases
  color = \"#808080\"
";

const REMARKS: &str = "\
Whether a line is hidden is decided exactly, by faces that lie strictly in front of it; both sides of a face hide. Equal input gives \
equal files, on every machine. No GPU is needed. Vertices of a glTF mesh that its pose puts at one point are joined, also with \
--no-weld. --memory-limit also limits the drawing.

With --dxf-units model a DXF has coordinates of the files: x to the right and y up on the page, and the origin of the files at 0,0. \
Dashes are as long as if the drawing were fitted to a page of A4.

Layers of .svg, .pdf and .dxf: one a class for visible lines, and one for hidden lines if they are drawn. Keys of --format json: rimline, \
title, view (eye, perspective), page_mm, mm_per_unit (null with perspective), objects (names), left_out (object, why), spans and \
chains. A span has class, faces_in_front, object, edge (null for an intersection), faces (object and face of each), world (its two \
ends) and page (the same in millimetres from the lower left corner); a chain has class, hidden, closed, first and count (of its \
spans).";

impl LinesArgs {
    /// Refuses options that do not go together and that clap cannot tell. Warns of options without effect.
    pub(crate) fn check(&self, format: Format) -> Result<(), Failure> {
        let (in_units, is_scaled) = (self.is_in_units(), self.scale != Scale::Fit);
        for (option, is_given) in [("--page", self.page.is_some()), ("--scale", is_scaled)] {
            if in_units && is_given {
                return Err(Failure::usage(format!("--dxf-units model is 1:1 and has no page; leave out {option}")));
            }
        }
        if self.fov.is_some() || (self.eye.is_some() && !self.ortho) {
            self.check_perspective()?;
        }
        let has_pens = format != Format::Json;
        let warn = |option: &str, why: &str| note(&format!("warning: {option} has no effect {why}"));
        for (option, is_given, has_effect) in [
            ("--dpi", self.dpi.is_some(), format == Format::Png),
            ("--style", self.style.is_some(), has_pens),
            ("--hidden", self.hidden != Hidden::None, has_pens),
            ("--dxf-units", in_units, format == Format::Dxf),
        ] {
            if is_given && !has_effect {
                let all = if option == "--hidden" { ", which has all lines" } else { "" };
                warn(option, &format!("on {}{all}", format.names().1));
            }
        }
        if self.crease.is_some() && !self.classes().contains(LineClass::Crease) {
            warn("--crease", "without creases among --classes");
        }
        if self.unit.is_some() && !is_scaled && !in_units {
            warn("--unit", "without --scale 1:N or --dxf-units model");
        }
        if self.fps.is_some() && self.pose.animations.is_empty() {
            warn("--fps", "without --animation");
        }
        if self.frames == Some(1) && self.turn != 0.0 {
            warn("--turn", "on one drawing");
        }
        if self.frames.is_some_and(|frames| frames > 1) && self.turn == 0.0 && self.pose.animations.is_empty() {
            note("warning: all drawings are the same; give --animation or --turn");
        }
        Ok(())
    }

    /// Refuses options that a perspective view does not have.
    pub(crate) fn check_perspective(&self) -> Result<(), Failure> {
        for (option, is_given) in [("--scale", self.scale != Scale::Fit), ("--dxf-units model", self.is_in_units())] {
            if is_given {
                return Err(Failure::usage(format!(
                    "{option} needs an orthographic view; leave out --fov or --camera, or give --ortho with --eye"
                )));
            }
        }
        Ok(())
    }

    fn is_in_units(&self) -> bool {
        self.dxf_units == DxfUnits::Model
    }

    pub(crate) fn crease(&self) -> f64 {
        self.crease.unwrap_or(33.0)
    }

    pub(crate) fn fps(&self) -> f32 {
        self.fps.unwrap_or(25.0)
    }

    pub(crate) fn dpi(&self) -> u32 {
        self.dpi.unwrap_or(150)
    }

    pub(crate) fn classes(&self) -> Classes {
        LineClass::ALL.into_iter().filter(|&class| self.classes.iter().any(|some| some.contains(class))).collect()
    }
}

/// The classes that a name stands for.
fn parse_classes(text: &str) -> Result<Classes, &'static str> {
    let text = text.trim().to_lowercase();
    let is_named = |class: &LineClass| *class != LineClass::Marked && class.name() == text;
    match LineClass::ALL.into_iter().find(is_named) {
        _ if text == "all" => Ok(Classes::ALL),
        Some(class) => Ok(Classes::NONE.with(class)),
        None => Err("the classes are all, silhouette, boundary, non-manifold, crease and intersection"),
    }
}

/// How hidden lines are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Hidden {
    /// They are not drawn
    None,
    /// They are dashed
    Dashed,
    /// They are thin
    Thin,
}

/// A unit of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Unit {
    M,
    Cm,
    Mm,
    /// Inches
    In,
    /// Feet
    Ft,
}

impl Unit {
    /// Millimetres, the unit in words, and the number that `$INSUNITS` of a DXF has for it.
    pub(crate) fn facts(self) -> (f64, &'static str, u32) {
        match self {
            Self::M => (1000.0, "a metre", 6),
            Self::Cm => (10.0, "a centimetre", 5),
            Self::Mm => (1.0, "a millimetre", 4),
            Self::In => (25.4, "an inch", 1),
            Self::Ft => (304.8, "a foot", 2),
        }
    }
}

/// How a DXF is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DxfUnits {
    /// In millimetres of the page
    Page,
    /// 1:1 in the unit of the files, which --unit names for CAD. Only without perspective, --page and --scale
    Model,
}

/// The size of the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Paper {
    /// The shorter and the longer side in millimetres; which is the width depends on the drawing.
    Turned([f64; 2]),
    /// Width and height in millimetres.
    Given([f64; 2]),
}

impl Paper {
    pub(crate) const A4: Self = Self::Turned([210.0, 297.0]);
    /// The sizes A0 to A5, in millimetres.
    const SIZES: [[f64; 2]; 6] =
        [[841.0, 1189.0], [594.0, 841.0], [420.0, 594.0], [297.0, 420.0], [210.0, 297.0], [148.0, 210.0]];
}

fn parse_paper(text: &str) -> Result<Paper, &'static str> {
    let is_named = |number: usize| text.eq_ignore_ascii_case(&format!("A{number}"));
    if let Some((_, size)) = (0..).zip(Paper::SIZES).find(|(number, _)| is_named(*number)) {
        return Ok(Paper::Turned(size));
    }
    let side = |text: &str| text.trim().parse().ok().filter(|side: &f64| (1.0..=20_000.0).contains(side));
    let given = text.split_once(['x', 'X']).and_then(|(width, height)| Some([side(width)?, side(height)?]));
    let needed = "a page is A0 to A5, or its width and height in millimetres, 1 to 20000 each, such as 200x150";
    given.map(Paper::Given).ok_or(needed)
}

/// How large things are on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// The largest that fits the page.
    Fit,
    /// A length on the page for a length of the models, both in one unit.
    Ratio {
        /// A length on the page.
        page: f64,
        /// The length of the models that it stands for.
        model: f64,
    },
}

fn parse_scale(text: &str) -> Result<Scale, &'static str> {
    if text.eq_ignore_ascii_case("fit") {
        return Ok(Scale::Fit);
    }
    let part = |text: &str| text.trim().parse().ok().filter(|part: &f64| (1e-9..=1e9).contains(part));
    let ratio = text.split_once(':').and_then(|(page, model)| Some((part(page)?, part(model)?)));
    let (page, model) = ratio.ok_or("a scale is `fit`, or two numbers such as 1:50, 1e-9 to 1e9 each")?;
    Ok(Scale::Ratio { page, model })
}
