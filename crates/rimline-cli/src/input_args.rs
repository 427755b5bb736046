//! Arguments, and limits of model files, that several subcommands share.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{NonEmptyStringValueParser, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use rimline::Origin;
use rimline::gltf::SceneCamera;
use rimline::mesh::{Weld, WeldDistance};
use rimline_files::size::bytes;
use rimline_files::{Format, Polygons, ReadOptions, Up};

use crate::coordinates::{Coordinate, relative};
use crate::device::Wanted;
use crate::spec::{self, Side};

/// The model, and how it is read.
#[derive(Args, Debug)]
pub(crate) struct ModelArgs {
    /// A .gltf, .glb, .obj, .ply, .stl or .npz file, or - for standard input. Faces of an .obj or .ply may have any
    /// number of corners. An .npz contains `positions` (V,3) float32 and `faces` (F,3) of any integer type. Faces at
    /// infinite or NaN positions face no light, cast no shadow and are not drawn; a warning counts the positions
    pub(crate) file: PathBuf,

    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// How models are read, and how their vertices are joined.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ReadArgs {
    #[command(flatten)]
    weld: WeldArgs,

    /// Take each polygon of an .obj or .ply as one face, after Bergeron (1986): its boundary decides whether it faces a
    /// light or the eye, and its diagonals are no edges. By default polygons are cut into triangles, and what is drawn
    /// is what is decided. Pictures show triangles in any case, so they may not fit a polygon that is not planar;
    /// docs/formats.md says which pixels. An .npz with `polygon_loops` is always taken so
    #[arg(long)]
    polygons: bool,

    #[command(flatten)]
    pub(crate) load: LoadArgs,
}

impl ReadArgs {
    pub(crate) fn options(self) -> ReadOptions {
        let polygons = if self.polygons { Polygons::Whole } else { Polygons::Triangles };
        self.load.options(self.weld.weld(), polygons)
    }
}

/// How vertices are joined.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct WeldArgs {
    /// Which vertices are joined to one
    #[arg(long, value_enum, default_value_t = WeldArg::Data)]
    weld: WeldArg,

    /// Join no vertices: use them as they are in the file
    #[arg(long, conflicts_with = "weld")]
    no_weld: bool,

    /// Also join vertices that are at most D apart, in the units of each mesh of the file, and vertices that others
    /// join to each other. All of them take the lexicographically smallest of their positions. It closes seams that
    /// rounding left open (`rimline info` says which). Vertices whose skin or morph data differ are joined only with
    /// `--weld position`
    #[arg(long, value_name = "D", conflicts_with = "no_weld", allow_hyphen_values = true, value_parser = spec::weld_distance)]
    weld_distance: Option<WeldDistance>,
}

impl WeldArgs {
    pub(crate) fn weld(self) -> Weld {
        match (self.weld, self.weld_distance) {
            _ if self.no_weld => Weld::Keep,
            (WeldArg::Data, None) => Weld::Data,
            (WeldArg::Position, None) => Weld::Position,
            (WeldArg::Data, Some(distance)) => Weld::Distance(distance),
            (WeldArg::Position, Some(distance)) => Weld::Distance(distance.across_data()),
        }
    }
}

/// Where the model's vertices are, and who says so.
#[derive(Args, Debug)]
pub(crate) struct MomentArgs {
    #[command(flatten)]
    pub(crate) pose: PoseArgs,

    /// A WGSL file with `fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32>`, or - for standard input.
    /// It moves vertices in world space, after morph targets and skins. Where the result has an origin, positions are
    /// relative to it. It needs a GPU, which may be software
    #[arg(long, value_name = "FILE.wgsl")]
    pub(crate) displace: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

/// A pose: animations and their time.
#[derive(Args, Debug)]
pub(crate) struct PoseArgs {
    /// The animation that poses the model, by name or by number from 0, or `all`. Without it the model is at rest. The
    /// option can be repeated: the animations play together, unless two move the same property of a node
    #[arg(long = "animation", value_name = "NAME|INDEX|all", allow_hyphen_values = true)]
    pub(crate) animations: Vec<String>,

    /// The time in seconds, for the animation and for `displace`
    #[arg(long, value_name = "S", default_value = "0", allow_hyphen_values = true, value_parser = spec::within(-1e9, 1e9))]
    pub(crate) time: f32,
}

#[derive(Args, Debug)]
pub(crate) struct DeviceArgs {
    /// Where to compute: `auto` (a GPU if there is one that is no software and takes the model, else the CPU, which is
    /// faster than software GPUs), `gpu` (any GPU, software GPUs included), `cpu`, or a part of a device's name or
    /// backend (`rimline devices` lists them)
    #[arg(long, value_name = "auto|gpu|cpu|NAME", default_value = "auto", value_parser = device())]
    pub(crate) device: Wanted,
}

/// Reads which device is asked for. A part of its name that is empty would fit all.
pub(crate) fn device() -> impl TypedValueParser<Value = Wanted> {
    NonEmptyStringValueParser::new().map(|name| Wanted::from(&*name))
}

/// A help text with examples and tables as they are. clap breaks the lines of every other text, which would make examples
/// that cannot be pasted.
pub(crate) fn verbatim(examples: &str) -> String {
    format!("{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{{all-args}}\n\n{examples}{{after-help}}")
}

/// Help of `--device` where pictures are drawn, which takes a GPU.
pub(crate) fn drawing_device(arg: clap::Arg) -> clap::Arg {
    arg.value_name("auto|gpu|NAME").help(
        "Where to draw: `auto` or `gpu` (any GPU, Mesa's software Vulkan included), or a part of a device's name or backend \
         (`rimline devices` lists them)",
    )
}

/// Where the picture is taken from, and its size.
#[derive(Args, Clone, Debug)]
pub(crate) struct ViewArgs {
    /// The position of the eye. By default it is in front of the model, to the right and above, as near as possible with
    /// the whole model in view
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::coordinates::<3>)]
    eye: Option<[Coordinate; 3]>,

    /// The point that the eye looks at. By default it is the middle of the model
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::coordinates::<3>)]
    target: Option<[Coordinate; 3]>,

    /// The side that is seen: front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees: to the right of the front,
    /// and above the ground. The front is +Z, the top is +Y. The eye is as near as possible with the whole model in view
    #[arg(long, value_name = "SIDE|AZ,EL", allow_hyphen_values = true, value_parser = Side::from_str, conflicts_with = "eye")]
    view: Option<Side>,

    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    /// Show the view without perspective, as large as fits. --eye and --target then say in which direction it looks. Shadows take
    /// --method auto, zp+ or z-pass, and no depth maps
    #[arg(long, conflicts_with_all = ["fov", "camera"])]
    pub(crate) ortho: bool,

    /// The vertical field of view in degrees
    #[arg(long, value_name = "DEG", default_value = "35", allow_hyphen_values = true, value_parser = spec::field_of_view)]
    fov: f32,

    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x960", allow_hyphen_values = true, value_parser = spec::size)]
    pub(crate) size: [u32; 2],
}

/// A camera of the file, instead of an eye and a target.
#[derive(Args, Clone, Debug)]
pub(crate) struct CameraArgs {
    /// Take the view of a camera of the glTF, by name or by number from 0; of the first file, if there are several. It moves with
    /// its animation. The height of the picture, or of the page within its border, is the camera's field of view. Only pictures
    /// of orthographic cameras have a far plane
    #[arg(
        id = "camera",
        long = "camera",
        value_name = "NAME|INDEX",
        allow_hyphen_values = true,
        conflicts_with_all = ["eye", "target", "view", "fov"],
    )]
    pub(crate) wanted: Option<String>,
}

/// [`ViewArgs`] relative to the run's origin.
#[derive(Clone, Debug)]
pub(crate) struct PlacedView {
    pub(crate) eye: Option<[f32; 3]>,
    pub(crate) target: Option<[f32; 3]>,
    /// In degrees.
    pub(crate) fov: f32,
    pub(crate) size: [u32; 2],
    pub(crate) side: Option<Side>,
    pub(crate) is_parallel: bool,
    /// The camera of a file, which says all but the size.
    pub(crate) camera: Option<SceneCamera>,
}

impl ViewArgs {
    pub(crate) fn relative_to(&self, origin: Origin) -> PlacedView {
        let [eye, target] = [self.eye, self.target].map(|point| point.map(|point| relative(point, origin)));
        let Self { fov, size, view: side, ortho: is_parallel, .. } = *self;
        PlacedView { eye, target, fov, size, side, is_parallel, camera: None }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WeldArg {
    /// Vertices with equal positions and equal skin and morph data
    Data,
    /// Vertices with equal positions, even if their skin and morph data differ
    Position,
}

/// Limits for model files.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct LoadArgs {
    /// The largest memory that reading one file, and making its mesh, may take at one time, such as 512MiB, 16GiB or a
    /// number of bytes. A file that states more is refused before its data is read. Small files can need a lot of
    /// memory
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = bytes)]
    pub(crate) memory_limit: u64,

    /// Read every model file in this format. By default its content tells the format, and where that says nothing its name
    #[arg(long, value_name = "FORMAT", value_parser = format())]
    input_format: Option<Format>,

    /// Allow a glTF file to read buffers outside its folder, through `..`, an absolute path or a symbolic link
    #[arg(long)]
    allow_outside: bool,

    /// The axis of an .obj, .ply, .stl or .npz that is up. With `z`, as files of CAD often have it, (x, y, z) of the file is (x, z,
    /// -y) everywhere else, also in options and results. A glTF is always y up
    #[arg(long, value_name = "y|z", value_parser = up(), default_value = "y")]
    up: Up,
}

/// Reads the axis that is up.
fn up() -> impl TypedValueParser<Value = Up> {
    PossibleValuesParser::new(["y", "z"]).map(|axis| if axis == "z" { Up::Z } else { Up::Y })
}

/// Reads a format of models.
fn format() -> impl TypedValueParser<Value = Format> {
    PossibleValuesParser::new(["gltf", "obj", "ply", "stl", "npz"]).map(|format| match &*format {
        "gltf" => Format::Gltf,
        "obj" => Format::Obj,
        "ply" => Format::Ply,
        "stl" => Format::Stl,
        _ => Format::Npz,
    })
}

impl LoadArgs {
    pub(crate) fn options(self, weld: Weld, polygons: Polygons) -> ReadOptions {
        let Self { memory_limit, input_format: format, allow_outside, up } = self;
        ReadOptions { format, weld, memory_limit, allow_outside, polygons, up }
    }
}

/// Many jobs in one run.
#[derive(Args, Debug)]
#[command(next_help_heading = "Many files")]
pub(crate) struct JobsArgs {
    /// A file with a job a line, or - for standard input, for many jobs in one run
    ///
    /// The run opens the device once. A line is a JSON object. Its keys are `file`, a name or a list of names, and the long options
    /// of this subcommand, such as {"file": "a.obj", "time": 0.4}. Values are texts, numbers, true, false, or lists for options
    /// that can be repeated. Options of the command line are for all jobs; those of a line replace them.
    ///
    /// Without this option, `extract`, `draw` and `info` take each FILE as a job. `lines` and `shadow` take all FILEs as one drawing
    /// or scene, and each as a job if the name of a result has a pattern. Patterns are {stem}, the file's name without its ending,
    /// {name}, the whole name, and {index}, the number of the job from 0000: `--out out/{stem}.png`. Two jobs must not write the
    /// same file. A job that fails does not stop the others; the exit code is then 6. With --json there is a line for each job,
    /// and one for all: docs/formats.md has the keys
    #[arg(long, value_name = "FILE.jsonl")]
    pub(crate) jobs: Option<PathBuf>,

    /// Skip jobs whose results are all there. Results are complete or not there, so a run that was stopped goes on so. Jobs
    /// of `info` have none and always run
    #[arg(long)]
    pub(crate) resume: bool,

    /// Do only job I, counted from 0, where I modulo N is K - 1. N runs with K from 1 to N do each job once
    #[arg(long, value_name = "K/N", value_parser = shard)]
    pub(crate) shard: Option<[u32; 2]>,
}

/// An argument that takes several files, each of which is a job.
pub(crate) fn several(file: clap::Arg) -> clap::Arg {
    file.num_args(1..)
}

/// K and N of `K/N`.
fn shard(text: &str) -> Result<[u32; 2], &'static str> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some([k.parse().ok()?, n.parse().ok()?]));
    numbers.filter(|[k, n]| (1..=*n).contains(k)).ok_or("a shard is K/N with K from 1 to N, such as 2/8")
}
