//! Options of `rimline lines`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use rimline_lines::{Classes, LineClass};

use crate::coordinates::Coordinate;
use crate::failure::UsageError;
use crate::input_args::{LoadArgs, PolygonArgs, PoseArgs, WeldArgs, verbatim};
use crate::spec;

#[derive(Args, Debug)]
#[command(help_template = verbatim(EXAMPLES), after_help = REMARKS, mut_arg("weld", |weld| weld.default_value("position")))]
pub(crate) struct LinesArgs {
    /// One or more .gltf, .glb, .obj or .npz files, or - for standard input. All are drawn together
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) weld: WeldArgs,

    #[command(flatten)]
    pub(crate) polygons: PolygonArgs,

    #[command(flatten)]
    pub(crate) load: LoadArgs,

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

    /// The position of the eye, of a perspective drawing
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::coordinates::<3>)]
    pub(crate) eye: Option<[Coordinate; 3]>,

    /// The point that the eye looks at. By default it is the middle of the models
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::coordinates::<3>, requires = "eye")]
    pub(crate) target: Option<[Coordinate; 3]>,

    /// The vertical field of view in degrees. With --view it makes the view perspective, from where the models just fit in it; with
    /// --eye it is what the page shows [default: what the models take, at most 100]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = spec::field_of_view)]
    pub(crate) fov: Option<f32>,

    /// Draw what --eye and --target see without perspective
    #[arg(long, requires = "eye", conflicts_with = "fov")]
    pub(crate) ortho: bool,

    /// The least angle between two faces whose edge is drawn as a crease, in degrees
    #[arg(long, value_name = "DEG", default_value = "30", allow_hyphen_values = true, value_parser = spec::crease)]
    pub(crate) crease: f64,

    /// The classes of lines, separated by commas: silhouette (between a face that is seen from its front and one from its back),
    /// boundary (one face), non-manifold (more than two), crease, intersection (faces pass through each other). Or `all`
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "all")]
    classes: Vec<ClassArg>,

    /// How lines behind faces are drawn
    #[arg(long, value_enum, default_value_t = Hidden::None)]
    pub(crate) hidden: Hidden,

    /// The page: A0 to A5, upright or lying as the drawing needs it, or its width and height in millimetres, such as 200x150.
    /// By default it is A4; with --scale it is as large as the drawing
    #[arg(long, value_name = "A4|WxH", value_parser = Paper::from_str)]
    pub(crate) page: Option<Paper>,

    /// The scale: `fit` to the page, or such as 1:50, if one unit of the files is a metre, as in glTF. Only without perspective
    #[arg(long, value_name = "fit|1:N", default_value = "fit", value_parser = Scale::from_str)]
    pub(crate) scale: Scale,

    /// A TOML file with widths, colours and dashes of lines
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) style: Option<PathBuf>,

    /// Pixels an inch of a PNG, 10 to 2400
    #[arg(long, value_name = "N", default_value = "150", value_parser = clap::value_parser!(u32).range(10..=2400))]
    pub(crate) dpi: u32,

    /// Where to write the drawing; its ending is the format: .svg, .pdf, .dxf, .json or .png
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,

    /// The format, where the name does not tell it
    #[arg(long, value_enum)]
    pub(crate) format: Option<super::format::Format>,
}

const EXAMPLES: &str = "\
Examples:
  rimline lines house.obj --out house.svg
  rimline lines house.obj --view front --scale 1:50 --hidden dashed --out front.pdf
  rimline lines fox.glb --animation Run --view 30,15 --out fox.svg
  rimline lines part.obj --scale 1:0.05 --out part.dxf   # 1:50, in mm

A style, with the defaults of some lines; widths and dashes in millimetres:
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
equal files, on every machine. No GPU is needed. Vertices of a glTF mesh that its pose puts at one point are joined in any case. \
--memory-limit is for the drawing, too.

Layers of .svg, .pdf and .dxf: one a class for visible lines, and one for hidden lines if they are drawn. Keys of --format json: rimline, \
title, view (eye, perspective), page_mm, mm_per_unit (null with perspective), objects (names), left_out (object, why), spans and \
chains. A span has class, faces_in_front, object, edge (null for an intersection), faces (object and face of each), world (its two \
ends) and page (the same in millimetres from the lower left corner); a chain has class, hidden, closed, first and count (of its \
spans).";

impl LinesArgs {
    /// Refuses options that do not go together and that clap cannot tell.
    pub(crate) fn check(&self) -> Result<(), UsageError> {
        let is_perspective = self.fov.is_some() || (self.eye.is_some() && !self.ortho);
        if is_perspective && self.scale != Scale::Fit {
            return Err(UsageError::ScaleOfPerspective);
        }
        Ok(())
    }

    pub(crate) fn classes(&self) -> Classes {
        let named = |class: &ClassArg| match class {
            ClassArg::All => Classes::ALL,
            ClassArg::One(class) => Classes::NONE.with(*class),
        };
        let classes = self.classes.iter().map(named);
        LineClass::ALL.into_iter().filter(|&class| classes.clone().any(|some| some.contains(class))).collect()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ClassArg {
    All,
    One(LineClass),
}

impl FromStr for ClassArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim().to_lowercase();
        let is_named = |class: &LineClass| *class != LineClass::Marked && class.name() == text;
        match LineClass::ALL.into_iter().find(is_named) {
            _ if text == "all" => Ok(Self::All),
            Some(class) => Ok(Self::One(class)),
            None => Err("the classes are all, silhouette, boundary, non-manifold, crease and intersection".to_owned()),
        }
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

/// Where an eye at infinity is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    Named(&'static str, [f32; 3]),
    /// To the right of the front, and above the ground, in degrees.
    Angles(f64, f64),
}

/// Names of sides, and where the eye is.
const SIDES: [(&str, [f32; 3]); 7] = [
    ("front", [0.0, 0.0, 1.0]),
    ("back", [0.0, 0.0, -1.0]),
    ("left", [-1.0, 0.0, 0.0]),
    ("right", [1.0, 0.0, 0.0]),
    ("top", [0.0, 1.0, 0.0]),
    ("bottom", [0.0, -1.0, 0.0]),
    ("iso", [1.0, 1.0, 1.0]),
];

impl FromStr for Side {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((name, side)) = SIDES.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)) {
            return Ok(Self::Named(name, side));
        }
        let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
            let angle = |text: &str| text.trim().parse().ok().filter(|degrees: &f64| degrees.abs() <= 360.0);
            Some((angle(azimuth)?, angle(elevation).filter(|degrees| degrees.abs() <= 90.0)?))
        });
        let (azimuth, elevation) = angles.ok_or(
            "a side is front, back, left, right, top, bottom, iso, or an azimuth from -360 to 360 and an elevation from -90 to 90 \
             degrees, such as 30,15",
        )?;
        Ok(Self::Angles(azimuth, elevation))
    }
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

impl FromStr for Paper {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = text.strip_prefix(['A', 'a']).and_then(|number| number.parse::<usize>().ok());
        if let Some(size) = named.and_then(|number| Self::SIZES.get(number)) {
            return Ok(Self::Turned(*size));
        }
        let side = |text: &str| text.trim().parse().ok().filter(|side: &f64| (1.0..=20_000.0).contains(side));
        let given = text.split_once(['x', 'X']).and_then(|(width, height)| Some([side(width)?, side(height)?]));
        given.map(Self::Given).ok_or_else(|| {
            "a page is A0 to A5, or its width and height in millimetres, 1 to 20000 each, such as 200x150".to_owned()
        })
    }
}

/// How large things are on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// The largest that fits the page.
    Fit,
    /// So many metres of the page a unit.
    Ratio {
        /// A length on the page.
        page: f64,
        /// The same length of the models.
        model: f64,
    },
}

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("fit") {
            return Ok(Self::Fit);
        }
        let part = |text: &str| text.trim().parse().ok().filter(|part: &f64| (1e-9..=1e9).contains(part));
        let ratio = text.split_once(':').and_then(|(page, model)| Some((part(page)?, part(model)?)));
        let (page, model) = ratio.ok_or("a scale is `fit`, or two numbers such as 1:50, 1e-9 to 1e9 each")?;
        Ok(Self::Ratio { page, model })
    }
}
