//! The command lines of `rimline shadow` and `rimline film`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use rimline::Counting;

use crate::input_args::{MomentArgs, ViewArgs, WeldArgs, drawing_device};
use crate::load_args::LoadArgs;
use crate::spec::{self, AreaSpec, ShadedLightSpec};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CountingArg {
    /// z-pass where nothing lies between light and near rectangle, else ZP+: chosen on the GPU for each model and light
    Auto,
    /// z-pass begun with near caps, clipped by Rimline itself
    #[value(name = "zp+")]
    ZpPlus,
    /// ZP+ as published in 2005, with its corrective quads and its switch to z-fail. For comparison
    #[value(name = "zp+paper")]
    ZpPlus2005,
    /// Count what is hidden; with light and dark caps
    ZFail,
    /// Count what is seen. Wrong where a shadow volume reaches the near plane; for comparison
    ZPass,
}

/// The name that an option's value goes by.
pub(crate) fn value_name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl CountingArg {
    pub(crate) fn counting(self) -> Counting {
        match self {
            Self::Auto => Counting::Auto,
            Self::ZpPlus => Counting::ZpPlus,
            Self::ZpPlus2005 => Counting::ZpPlus2005,
            Self::ZFail => Counting::ZFail,
            Self::ZPass => Counting::ZPass,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ModeArg {
    /// Ambient light, and each light added where it is not in shadow; right for any number of lights
    Additive,
    /// Everything lit; what is in shadow of any light redrawn in ambient light alone
    Ambient,
    /// Everything lit; what is in shadow of any light black
    Black,
    /// Everything lit; half of it taken away for each light that a place is in shadow of, highlights and all
    Composited,
}

/// What the pictures with shadows have alike.
#[derive(Args, Debug)]
pub(crate) struct ShadowSceneArgs {
    /// .gltf, .glb or .npz files (- for standard input), each of which casts shadows as one body; an .npz holds `positions` (V,3) float32 and
    /// `faces` (F,3) of any integer type
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) weld: WeldArgs,

    #[command(flatten)]
    pub(crate) load: LoadArgs,

    /// A light: point:x,y,z, dir:x,y,z (towards the light), hom:x,y,z,w (homogeneous), file:NAME or file:all (the
    /// first file's own lights); may be given many times, and followed by options, see below. By default one light, to the
    /// left of the eye and above
    #[arg(long = "light", value_name = "SPEC[,OPTION]...", allow_hyphen_values = true, value_parser = spec::shaded)]
    pub(crate) lights: Vec<ShadedLightSpec>,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// The distance of the near plane from the eye; by default as far as the models allow
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = spec::near)]
    pub(crate) near: Option<f32>,

    /// The height of the ground, an infinite plane that takes shadows and throws none; by default the models' lowest
    /// point, or a little lower where they are flat
    #[arg(long, value_name = "Y", allow_hyphen_values = true, value_parser = spec::any_number)]
    pub(crate) ground: Option<f32>,

    /// How shadow volumes are counted
    #[arg(long, value_enum, default_value_t = CountingArg::Auto)]
    pub(crate) method: CountingArg,

    /// What becomes of shadows
    #[arg(long, value_enum, default_value_t = ModeArg::Additive)]
    pub(crate) mode: ModeArg,

    /// Soft shadows: every light has this shape; for lights at infinity sizes are at distance 1. Without sizes their
    /// radius is 0.04 of the distance to the middle of the models
    #[arg(long, value_name = "rect[:W,H]|disc[:R]|sphere[:R]", value_parser = spec::area)]
    pub(crate) area: Option<AreaSpec>,

    /// Lights that stand for one with --area, 1 to 32; all of them share one extraction [default: 16, with --one-pattern 32]
    #[arg(long, value_name = "N", requires = "area", allow_hyphen_values = true, value_parser = spec::samples)]
    pub(crate) samples: Option<usize>,

    /// Give every pixel the same samples, to measure: a place's light is then the share of samples that reach it, and soft
    /// shadows show a step for each. Without it neighbouring pixels take different ones, of 16 times as many
    #[arg(long, requires = "area")]
    pub(crate) one_pattern: bool,

    /// Draw the shadow volumes, too, translucent and with their edges
    #[arg(long)]
    pub(crate) volumes: bool,

    #[command(flatten)]
    pub(crate) posed: MomentArgs,
}

impl ShadowSceneArgs {
    /// Lights that stand for one.
    pub(crate) fn samples(&self) -> usize {
        let usual = if self.one_pattern { spec::MOST_SAMPLES } else { spec::MOST_SAMPLES / 2 };
        self.area.map_or(1, |_| self.samples.unwrap_or(usual as usize))
    }
}

/// Help that both commands end with.
macro_rules! light_options {
    () => {
        "\
Options of a light, after its SPEC:
  color=R,G,B   linear; 1,1,1 without it. All lights together set the exposure
  intensity=I   times the color; 1 without it
  range=R       where a light with a place ends: it fades to nothing, models farther away throw no
                shadow, and masks are 0
  begin=D       where it begins to fade, at most R; 0 without it
  exponent=E    how: by what is left of the way to R, to the power of E; 1 without it (Bergeron
                1986)

What the options leave open, a light of the file has as KHR_lights_punctual gives it: color, range, and a spot's cone, \
out of which masks are 0, too. Its intensity is what arrives at the middle of the models, the brightest such light \
counted as 1. Options of file:all are for those lights that can have them.
"
    };
}

#[derive(Args, Debug)]
#[command(after_help = SHADOW_EXAMPLES, mut_arg("device", drawing_device))]
pub(crate) struct ShadowArgs {
    #[command(flatten)]
    pub(crate) scene: ShadowSceneArgs,

    /// Where to write the picture
    #[arg(long, value_name = "FILE.png", required_unless_present = "mask")]
    pub(crate) out: Option<PathBuf>,

    /// Write PREFIX.<light>.png, too, for each light: 255 lit, 0 in shadow, averted from the light or out of its range or
    /// cone, 128 background; exact at each pixel's centre (with --area the share of samples that reach it, times 255)
    #[arg(long, value_name = "PREFIX")]
    pub(crate) mask: Option<PathBuf>,

    /// Print what was chosen and counted, and times, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

const SHADOW_EXAMPLES: &str = concat!(
    light_options!(),
    "
Examples:
  rimline shadow fox.glb --out fox.png
  rimline shadow fox.glb --animation Run --time 0.4 --light dir:1,2,1,color=1,.8,.6 --light point:-90,80,60,range=300 --out fox.png
  rimline shadow fox.glb box.glb --area disc --out soft.png
  rimline shadow fox.glb --light point:50,150,100 --mask fox --json

World space is right-handed with +Y up.

Keys of --json: adapter, method, mode, files, faces, samples (of a light), count_bound (no stencil count of all \
files together exceeds it), may_wrap (lights, or samples, for which that may be more than the 255 that the stencil \
holds: places in shadow may look lit), lights (a list of light, range, color and casters, a list of file, casting, \
counting, silhouette_edges, each of them a value a sample with --area), statistics (a list, one a file, of skipped, \
every_face, capped, count_bound, may_wrap, overflowed_caps, undecided_pairs, overflowed_lists), milliseconds (by stage)."
);

#[derive(Args, Debug)]
#[command(after_help = FILM_EXAMPLES, mut_arg("device", drawing_device), mut_arg("animation", film_animation))]
pub(crate) struct FilmArgs {
    #[command(flatten)]
    pub(crate) scene: ShadowSceneArgs,

    /// Pictures a second
    #[arg(long, value_name = "N", default_value = "25", allow_hyphen_values = true, value_parser = spec::positive)]
    pub(crate) fps: f32,

    /// How many pictures; by default as many as the animation lasts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MAX_FRAMES))]
    pub(crate) frames: Option<u32>,

    /// How long, in seconds, instead of --frames
    #[arg(long, value_name = "S", conflicts_with = "frames", allow_hyphen_values = true, value_parser = spec::positive)]
    pub(crate) seconds: Option<f32>,

    /// The folder to write 0000.png, 0001.png and so on into; made if it is not there; see below for one with an
    /// earlier film
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

/// Help of `--animation` where something should move.
fn film_animation(arg: clap::Arg) -> clap::Arg {
    arg.help(
        "The animation to play, by name or by number from 0; without it, and without --displace, each file's first one",
    )
}

const FILM_EXAMPLES: &str = concat!(
    light_options!(),
    "
Example:
  rimline film fox.glb --animation Run --fps 30 --out frames

Each file is complete as soon as it is there; Ctrl-C keeps those that are done. Camera and lights stand still.
Pictures of an earlier film by the same names are replaced, all from the first picture on. A folder with other \
pictures of that kind, of a longer film, is refused before anything is written: remove them first."
);

/// Five digits of frames.
pub(crate) const MAX_FRAMES: i64 = 100_000;
