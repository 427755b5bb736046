//! The command lines of `rimline shadow` and `rimline film`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use rimline::Counting;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod};
use rimline_picture::Mode;

use crate::coordinates::Coordinate;
use crate::failure::Failure;
use crate::files::is_standard;
use crate::input_args::{JobsArgs, MomentArgs, ReadArgs, ViewArgs, drawing_device, verbatim};
use crate::output::note;
use crate::spec::{self, AreaSpec, ShadedLightSpec};

/// A value of an option, its name and its help.
type Named<T> = (T, &'static str, &'static str);

/// How to count shadow volumes.
const METHODS: [Named<Counting>; 5] = [
    (
        Counting::Auto,
        "auto",
        "z-pass if nothing is between the light and the near rectangle, else ZP+. The GPU decides for each model and light",
    ),
    (Counting::ZpPlus, "zp+", "z-pass with near caps, which Rimline clips itself"),
    (
        Counting::ZpPlus2005,
        "zp+paper",
        "ZP+ as published in 2005, with its corrective quads and its switch to z-fail. For comparison. Where more than 255 \
         faces lie over each other, it may be wrong, and a warning says so",
    ),
    (Counting::ZFail, "z-fail", "Count the hidden faces of shadow volumes, with light and dark caps"),
    (
        Counting::ZPass,
        "z-pass",
        "Count the visible faces of shadow volumes. Wrong if a shadow volume reaches the near plane. For comparison",
    ),
];

/// How to draw shadows.
const MODES: [Named<Mode>; 4] = [
    (
        Mode::Additive,
        "additive",
        "Ambient light, plus each light where it is not in shadow. Right for any number of lights",
    ),
    (Mode::Ambient, "ambient", "Full light; points in the shadow of any light have ambient light only"),
    (Mode::Black, "black", "Full light; points in the shadow of any light are black"),
    (Mode::Composited, "composited", "Full light; each shadow on a point halves its light, highlights included"),
];

/// Reads one of these values by its name.
fn one_of<T: Clone + Send + Sync + 'static>(values: &'static [Named<T>]) -> impl TypedValueParser<Value = T> {
    let possible = values.iter().map(|(_, name, help)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(possible).try_map(move |given| {
        let found = values.iter().find(|(_, name, _)| *name == given);
        found.map(|(value, ..)| value.clone()).ok_or("there is no such value")
    })
}

/// The name that `--method` has for a way to count.
pub(super) fn method_name(counting: Counting) -> &'static str {
    METHODS.iter().find(|(method, ..)| *method == counting).map_or("auto", |(_, name, _)| *name)
}

/// Whether a way to count takes no orthographic view.
pub(super) fn needs_perspective(counting: Counting) -> bool {
    matches!(counting, Counting::ZFail | Counting::ZpPlus2005)
}

/// Refuses an orthographic view for an option.
pub(super) fn not_orthographic(option: &str) -> Failure {
    Failure::usage(format!(
        "{option} takes a perspective view, and this one is orthographic; leave it out, or leave out --ortho or the --camera"
    ))
}

/// The name that an option's value goes by.
pub(crate) fn value_name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Options that pictures with shadows share.
#[derive(Args, Debug)]
pub(crate) struct ShadowSceneArgs {
    /// .gltf, .glb, .obj, .ply, .stl or .npz files, or - for standard input. Each file casts shadows as one body. An .npz contains
    /// `positions` (V,3) float32 and `faces` (F,3) of any integer type
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) read: ReadArgs,

    /// A light: point:x,y,z, dir:x,y,z (the direction towards the light), hom:x,y,z,w (homogeneous), file:NAME,
    /// file:INDEX (from 0) or file:all (lights of the first file, as `info` lists them). Options can follow, see below.
    /// The option can be repeated. By default there is one light, above the eye and to its left
    #[arg(long = "light", value_name = "SPEC[,OPTION]...", allow_hyphen_values = true, value_parser = spec::shaded)]
    pub(crate) lights: Vec<ShadedLightSpec>,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// The distance of the near plane from the eye. By default it is as large as the models allow, or that of --camera
    #[arg(long, value_name = "D", conflicts_with = "ortho", allow_hyphen_values = true, value_parser = spec::near)]
    pub(crate) near: Option<f32>,

    /// The height of the ground, an infinite plane that receives shadows and casts none. It is visible from above only. By
    /// default it is at the lowest point of the models, or a little lower if they are flat
    #[arg(long, value_name = "Y", allow_hyphen_values = true, value_parser = spec::coordinate)]
    pub(crate) ground: Option<Coordinate>,

    /// How to count shadow volumes
    #[arg(long, value_parser = one_of(&METHODS), default_value = "auto")]
    pub(crate) method: Counting,

    /// How to draw shadows
    #[arg(long, value_parser = one_of(&MODES), default_value = "additive")]
    pub(crate) mode: Mode,

    /// Soft shadows: every light without a radius of its own has this shape. Sizes of lights at infinity are measured at
    /// distance 1. Without a size, the radius is 0.04 of the distance to the middle of the models. A picture is drawn in 16
    /// parts with --samples times as many lights each, which software devices take a minute for; fewer --samples or
    /// --one-pattern are faster
    #[arg(long, value_name = "rect[:W,H]|disc[:R]|sphere[:R]", value_parser = spec::area)]
    pub(crate) area: Option<AreaSpec>,

    /// The number of samples of each light with an area, 1 to 32; all share one extraction [default: 16, with --one-pattern
    /// 32]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES))]
    samples: Option<u32>,

    /// Give every pixel the same samples of areas, for measurements: the light at a point is then the share of samples that reach
    /// it, and soft shadows show one step for each sample. Without it, neighbouring pixels use different samples, out of
    /// 16 times as many
    #[arg(long)]
    pub(crate) one_pattern: bool,

    /// Show models as clay, not in their base colours
    #[arg(long)]
    pub(crate) plain: bool,

    /// Also draw the shadow volumes, translucent and with their edges
    #[arg(long)]
    pub(crate) volumes: bool,

    #[command(flatten)]
    pub(crate) posed: MomentArgs,
}

impl ShadowSceneArgs {
    /// Lights that stand for one with an area.
    pub(crate) fn samples(&self) -> usize {
        let usual = if self.one_pattern { MOST_SAMPLES } else { MOST_SAMPLES / 2 };
        self.samples.map_or(usual, i64::from) as usize
    }

    /// Whether some light has an area.
    pub(crate) fn is_soft(&self) -> bool {
        self.area.is_some() || self.has_radius()
    }

    fn has_radius(&self) -> bool {
        self.lights.iter().any(|light| light.radius.is_some())
    }

    /// Refuses options that do not go together and that clap cannot tell.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        for (option, is_given) in [("--samples", self.samples.is_some()), ("--one-pattern", self.one_pattern)] {
            if is_given && !self.is_soft() {
                return Err(Failure::usage(format!(
                    "{option} is for lights with an area; give --area, or a --light with radius=R, or leave {option} \
                     out"
                )));
            }
        }
        if self.is_soft() && self.mode != Mode::Additive {
            let mode = self.mode.name();
            return Err(Failure::usage(format!(
                "--mode {mode} cannot draw soft shadows; leave out --mode {mode}, or --area and radius="
            )));
        }
        if self.view.ortho && needs_perspective(self.method) {
            return Err(not_orthographic(&format!("--method {}", method_name(self.method))));
        }
        Ok(())
    }
}

/// Help that both commands end with, before their examples.
const LIGHT_OPTIONS: &str = "\
Options of a light, after its SPEC:
  color=R,G,B   linear color; 1,1,1 without it. The sum of all lights sets the exposure
  intensity=I   times the color; 1 without it
  range=R       distance at which the light ends: it fades to nothing, models farther away cast no
                shadow, and masks are 0; not for lights at infinity
  begin=D       distance at which the light begins to fade, at most R; 0 without it
  exponent=E    the light fades with ((R - distance) / (R - D))^E; 1 without it (Bergeron 1986)
  radius=R      the light is a sphere of this radius, with soft shadows; as --area, for this light alone
  cone=A,B      the light is a spot: full within A degrees of its direction, nothing beyond B, 90 at
                most; not for lights at infinity
  target=X,Y,Z  the point that a spot shines at; without it a spot of the file has its direction there,
                and others shine at the middle of the models

Lights of the file have color, range and cone as KHR_lights_punctual says, unless an option changes
them. Masks are 0 outside a cone. Intensities of these lights are measured at the middle of the
models; the brightest one counts as 1. Options of file:all apply to each light that can have them.
";

#[derive(Args, Debug)]
#[command(
    help_template = verbatim(&[LIGHT_OPTIONS, SHADOW_EXAMPLES].concat()),
    after_help = SHADOW_REMARKS,
    mut_arg("device", drawing_device),
)]
pub(crate) struct ShadowArgs {
    #[command(flatten)]
    pub(crate) scene: ShadowSceneArgs,

    /// Where to write the picture, a PNG
    #[arg(long, value_name = "FILE.png", required_unless_present = "mask")]
    pub(crate) out: Option<PathBuf>,

    /// Also write PREFIX.<light>.png for each light: 255 is lit, 128 is background, 0 is in shadow, turned away from the
    /// light, or outside its range or cone. Values are exact at each pixel's centre, unless depth maps cast. Of a light with
    /// an area a value is 255 times the share of samples that reach the pixel
    #[arg(long, value_name = "PREFIX")]
    pub(crate) mask: Option<PathBuf>,

    /// Search, before anything is drawn, for faces whose shadow lies wholly in the shadow of other faces, and leave
    /// them out of the shadow volumes, where that spares sides. Shadows stay the same. It pays where a model covers
    /// much of others
    #[arg(long, conflicts_with = "area")]
    pub(crate) hide_covered: bool,

    /// Let each light see the models in a depth map of SIDE × SIDE texels, 3 to 4096, 1024 without a number, and rebuild
    /// the shadows from it, without silhouettes. A light among the models has six maps. Borders of shadows are off by up
    /// to a texel. For comparison, and to try out depth maps
    #[arg(
        long,
        value_name = "SIDE",
        num_args = 0..=1,
        default_missing_value = "1024",
        value_parser = spec::map_side,
        conflicts_with_all = ["method", "hide_covered"],
        group = "depth_maps",
    )]
    pub(crate) from_depth: Option<u32>,

    /// Let the depth map in this file cast the only shadows: one that any program made, with its projection. The models
    /// are lit from where it was seen, and receive its shadows. One --light may be given, for its color and range; it must be
    /// where the map was seen from. docs/formats.md has the arrays
    #[arg(
        long,
        value_name = "MAP.npz",
        conflicts_with_all = ["method", "hide_covered", "area"],
        group = "depth_maps",
    )]
    pub(crate) depth: Option<PathBuf>,

    /// With --from-depth: also write PREFIX.<light>.npz for each light, its depth map with its projection, as --depth
    /// takes it
    #[arg(long, value_name = "PREFIX", requires = "from_depth", conflicts_with_all = ["area", "depth"])]
    pub(crate) save_depth: Option<PathBuf>,

    /// With --from-depth or --depth: how shadows are found in a map. `automatic`, the default with --from-depth, takes
    /// edges where depths jump by more than slopes beside them tell; `every` takes all, and is the default with
    /// --depth; `differences` those where device depths differ by more than T, 0 to 1; `second` by more than HIGH, or
    /// by more than LOW and than beside them; `contours` draws walls over smooth contours of jumps of more than T. With
    /// all but `automatic` and `every` --from-depth takes one map a light, and with all but `every` the models must
    /// contain all that a map casts, at the same position. A threshold that is too large turns shadows round in streaks
    #[arg(
        long,
        value_name = "automatic|every|differences=T|second=LOW,HIGH|contours=T",
        requires = "depth_maps",
        value_parser = spec::detector,
    )]
    pub(crate) detector: Option<DepthMapMethod>,

    /// With any --detector but `every` and `contours`: go on where an edge dangles, that is, ends in a cell that has no
    /// other. There SHARE of the detector's thresholds, 0 to 1, is left, for up to CELLS cells, 1 to 64. Without
    /// values: 0.5,8
    #[arg(
        long,
        value_name = "SHARE,CELLS",
        requires = "depth_maps",
        num_args = 0..=1,
        default_missing_value = "0.5,8",
        value_parser = spec::dangling,
    )]
    pub(crate) dangling: Option<DanglingEdges>,

    /// Print the chosen methods, counts and times as JSON
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    _jobs: JobsArgs,
}

impl ShadowArgs {
    /// Refuses options that do not go together and that clap cannot tell. Warns of options without effect.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let scene = &self.scene;
        scene.check()?;
        let of_picture =
            [("--mode", scene.mode != Mode::Additive), ("--plain", scene.plain), ("--volumes", scene.volumes)];
        for (option, _) in of_picture.into_iter().filter(|(_, is_given)| *is_given && self.out.is_none()) {
            note(&format!("warning: {option} has no effect on masks; give --out for a picture, too"));
        }
        for (option, is_given) in [("--from-depth", self.from_depth.is_some()), ("--depth", self.depth.is_some())] {
            if is_given && scene.view.ortho {
                return Err(not_orthographic(option));
            }
        }
        for (option, prefix) in [("--mask", &self.mask), ("--save-depth", &self.save_depth)] {
            let Some(prefix) = prefix else { continue };
            let is_picture = option == "--mask" && prefix.extension().is_some_and(|it| it.eq_ignore_ascii_case("png"));
            let (what, better) = if is_standard(prefix) {
                ("standard output", PathBuf::from("light"))
            } else if prefix.is_dir() || prefix.to_string_lossy().ends_with(std::path::is_separator) {
                // The files would lie beside the folder, or their names would begin with a dot.
                ("the name of a folder", prefix.join("light"))
            } else if is_picture {
                ("the name of a picture", prefix.with_extension(""))
            } else {
                continue;
            };
            return Err(Failure::usage(format!(
                "{option} is the beginning of files' names, and {} is {what}; give one such as {}",
                prefix.display(),
                better.display()
            )));
        }
        for (option, is_given) in [
            ("--hide-covered", self.hide_covered),
            ("--depth", self.depth.is_some()),
            ("--save-depth", self.save_depth.is_some()),
        ] {
            if is_given && scene.has_radius() {
                return Err(Failure::usage(format!(
                    "{option} takes lights without an area; leave out {option}, or radius="
                )));
            }
        }
        Ok(())
    }
}

const SHADOW_EXAMPLES: &str = "
Examples:
  rimline shadow fox.glb --out fox.png
  rimline shadow fox.glb --animation Run --time 0.4 --out fox.png \\
      --light dir:1,2,1,color=1,.8,.6 --light point:-90,80,60,range=300
  rimline shadow fox.glb box.glb --area disc --out soft.png
  rimline shadow fox.glb --light point:9,80,60,radius=5,cone=20,30 --out spot.png
  rimline shadow fox.glb --light point:50,150,100 --mask fox --json
  rimline shadow house.glb chairs.glb --hide-covered --volumes --out house.png
  rimline shadow fox.glb --from-depth 2048 --mask fox
  rimline shadow room.glb --depth lamp.npz --volumes --out room.png
";

const SHADOW_REMARKS: &str = "\
World space is right-handed with +Y up. The ground is visible from above only: an eye below it sees no ground.

Keys of --json: adapter, method, mode, origin (only where it is not zero), files, faces, samples (of a light with an area, else 1), count_bound (an upper bound of the stencil \
counts of all files together), may_wrap (the number of lights or samples whose counts may exceed 255, the most that \
the stencil holds, and are not made in batches: points in their shadow may look lit), lights (a list of light, range, color and casters, a list of \
file, casting, counting, silhouette_edges, each with one value a sample of a light with an area; casting and counting are the \
most that any instance in the file needs; with --hide-covered also occluded: tried, occluded, undecided, without_room and left_out \
count faces of all files, sides and sides_left are the sides of shadow volumes before and after; with --from-depth or --depth \
also \
depth_map: size, side (null unless square), maps, reconstruction (triangles or contours), cells (those that the boundary of the shadow has \
triangles in, null with contours), walls (with their flaps; null but with contours) and overflowed (whether these are more than their list has \
room for: every cell is drawn then); casting is then depth map, and counting and method are parity), statistics (a list, one \
for each file, of file, skipped, every_face, \
near_capped, count_bound, may_wrap, overflowed_caps, undecided_pairs, overflowed_lists; count_bound, may_wrap and \
overflowed_caps are null where there are several files), totals (of all files: skipped and every_face count pairs of \
instance and light, near_capped lights, once for each group of instances that are drawn together, then overflowed_caps, overflowed_sides, undecided_pairs, overflowed_lists, occluded_faces: those \
left out), milliseconds \
(by stage, null where only their sum is known), set_up_milliseconds (opening the device, pipelines, compiling shaders), work_milliseconds (all other \
stages).";

#[derive(Args, Debug)]
#[command(
    help_template = verbatim(&[LIGHT_OPTIONS, FILM_EXAMPLES].concat()),
    after_help = FILM_REMARKS,
    mut_arg("device", drawing_device),
    mut_arg("animations", film_animation),
    mut_arg("time", |time| time.help("The time of the first picture in seconds, for animations and for `displace`")),
)]
pub(crate) struct FilmArgs {
    #[command(flatten)]
    pub(crate) scene: ShadowSceneArgs,

    /// Pictures a second, 0.001 to 100000 [default: 25]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = spec::within(1e-3, 1e5))]
    pub(crate) fps: Option<f32>,

    /// The number of pictures. By default the film lasts as long as the longest animation. After the end of an animation
    /// the models stand still
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MAX_FRAMES))]
    pub(crate) frames: Option<u32>,

    /// The length in seconds, instead of --frames
    #[arg(long, value_name = "S", conflicts_with = "frames", allow_hyphen_values = true, value_parser = spec::within(1e-5, 1e9))]
    pub(crate) seconds: Option<f32>,

    /// Lead the camera around what it looks at, by so many degrees in the whole film: 360 is once around, against the
    /// clock from above. The camera then stands so far away that all is seen from everywhere, unless --eye or --camera says
    /// where it is. Without an animation, the film lasts 4 seconds
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = spec::within(-3600.0, 3600.0))]
    pub(crate) orbit: Option<f32>,

    /// The folder for 0000.png, 0001.png and so on, which is made if it does not exist. See below if it has an earlier
    /// film. Or a file that moves: .gif, .apng, or .mp4, which needs ffmpeg
    #[arg(long, value_name = "DIR|FILE")]
    pub(crate) out: PathBuf,

    /// Keep the pictures that are in the folder, and draw those that are missing. They must be of the same film: of the same
    /// models and options, --device included, because devices differ in some pixels
    #[arg(long)]
    pub(crate) resume: bool,

    /// Print what was written as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

impl FilmArgs {
    pub(crate) fn fps(&self) -> f32 {
        self.fps.unwrap_or(25.0)
    }
}

/// Help of `--animation` where something should move.
fn film_animation(arg: clap::Arg) -> clap::Arg {
    arg.help(
        "The animation to play, by name or by number from 0, or `all`. By default it is the first animation of each file, or \
         none with --displace. The option can be repeated: the animations play together, unless two move the same property \
         of a node",
    )
}

const FILM_EXAMPLES: &str = "
Examples:
  rimline film house.glb --orbit 360 --out house.gif
  rimline film fox.glb --animation Run --fps 30 --out frames
";

const FILM_REMARKS: &str = "\
Every file in the folder is complete. Ctrl-C keeps the finished pictures, \
and --resume goes on from there. Lights do not move. The camera moves with --orbit, and if --camera names one that an \
animation moves.

An earlier film in the folder is replaced: its pictures are removed as soon as the first new picture is complete. If \
the earlier film is longer, the command refuses the folder and writes nothing: remove its pictures first.

A GIF has 256 colors a picture, and hundredths of a second. An MP4 is H.264; a side of an odd number of pixels gets one more.

Keys of --json: adapter, out, frames, fps, size.";

/// Five digits of frames.
pub(crate) const MAX_FRAMES: i64 = 100_000;

/// At most so many lights stand for one.
const MOST_SAMPLES: i64 = 32;
