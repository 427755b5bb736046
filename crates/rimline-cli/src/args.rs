//! The command line.

use std::path::PathBuf;

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};

#[cfg(not(feature = "bench"))]
use self::LeftOutArgs as BenchArgs;
#[cfg(not(feature = "view"))]
use self::LeftOutArgs as WindowArgs;
#[cfg(feature = "bench")]
use crate::bench::BenchArgs;
use crate::input_args::{JobsArgs, LoadArgs, ModelArgs, MomentArgs, ViewArgs, drawing_device, several, verbatim};
use crate::lines::args::LinesArgs;
use crate::shadow::args::{FilmArgs, ShadowArgs};
use crate::spec::{self, LightSpec};
#[cfg(feature = "view")]
use crate::view::WindowArgs;

/// Silhouettes of triangle meshes, on the GPU.
#[derive(Parser, Debug)]
#[command(name = "rimline", version, about, long_about = LONG_ABOUT, after_help = EXIT_CODES, max_term_width = 100)]
pub(crate) struct Cli {
    /// Print nothing but results and errors: no warnings, no progress, and not what was written
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,

    #[command(subcommand)]
    pub(crate) command: Command,
}

const LONG_ABOUT: &str = "\
Finds the silhouette edges of triangle meshes as seen from any number of lights, on any GPU that wgpu can use, \
software Vulkan included, or on the CPU. Reads glTF 2.0 (.gltf, .glb), Wavefront OBJ (.obj), \
PLY (.ply), STL (.stl) and NumPy archives (.npz).

Inputs are regular files. `-` stands for standard input; it can be given once, and a glTF that comes from it cannot \
name other files.

Coordinates are those of the files, also where they are too large for 32-bit floats, as those of surveys are: results \
are then relative to a point near the models, which they state as `origin`.

Results never replace an input. The command writes a result under a temporary name in the same folder, and renames \
it when it is complete. A pipe or a device, such as /dev/stdout, also gets the complete result only. As a result's \
name, `-` stands for standard output. If a result goes there, messages go to standard error.";

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 bad input, 2 bad usage, 3 no usable device, 4 device lost or output not writable, \
5 `verify` found different bits, 6 some of several jobs failed. If a signal stops the command, the code is 128 plus the signal's number: 130 for \
Ctrl-C.";

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Look at models in a window: drag lights, see silhouettes and shadows
    View(WindowArgs),
    /// Draw a model with its outline, as a PNG
    Draw(DrawArgs),
    /// Draw models as lines without what is hidden, as SVG, PDF, DXF, JSON or PNG
    Lines(LinesArgs),
    /// Draw models with their shadows, as a PNG, and masks of what each light reaches
    Shadow(ShadowArgs),
    /// Draw an animation with its shadows, as numbered PNG files, GIF, APNG or MP4
    Film(FilmArgs),
    /// Extract facing, silhouette and winding bits for lights, as NumPy arrays
    Extract(ExtractArgs),
    /// Count the faces between each point and each light: 0 is lit, more is in shadow
    Query(QueryArgs),
    /// Show what a model contains and whether it is closed
    Info(InfoArgs),
    /// List the GPUs that can be used, with their limits
    Devices(DevicesArgs),
    /// Compare this machine's devices with a folder of extractions, bit by bit
    Verify(VerifyArgs),
    /// Measure run times and errors of all methods on this machine, and write a report with plots
    Bench(BenchArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Write manual pages, one for each subcommand
    Man(ManArgs),
}

#[derive(Args, Debug)]
#[command(after_help = COMPLETIONS_REMARKS)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
}

const COMPLETIONS_REMARKS: &str = "\
Where shells look for them: bash ~/.local/share/bash-completion/completions/rimline, fish \
~/.config/fish/completions/rimline.fish, zsh a file _rimline in a folder of $fpath.";

#[derive(Args, Debug)]
pub(crate) struct ManArgs {
    /// The folder, such as ~/.local/share/man/man1. It is made if it does not exist
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

/// All options are taken, and none is followed: this build leaves the subcommand out.
#[cfg(not(all(feature = "bench", feature = "view")))]
#[derive(Args, Debug)]
#[command(disable_help_flag = true)]
pub(crate) struct LeftOutArgs {
    /// This build leaves them out
    #[arg(hide = true, allow_hyphen_values = true, trailing_var_arg = true)]
    _rest: Vec<std::ffi::OsString>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodArg {
    /// Decide each face once, then compare the bits of each edge's two faces. Loops are always closed
    FaceMask,
    /// The method of 2003: each edge tests its two faces by itself, so loops may stay open. For comparison. The face bits
    /// in the file are exact
    PerEdge,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PredicateArg {
    /// The sign in exact arithmetic: the same bits on every device
    Exact,
    /// The sign in f32 arithmetic: may be wrong if a light is nearly in a face's plane. For comparison
    Fast,
    /// The sign of the face's plane equation in f32 arithmetic, as published in 2003: less exact far from the origin. For
    /// comparison
    Plane,
}

#[derive(Args, Debug)]
#[command(help_template = verbatim(EXTRACT_EXAMPLES), after_help = EXTRACT_KEYS, mut_arg("file", several))]
pub(crate) struct ExtractArgs {
    #[command(flatten)]
    pub(crate) model: ModelArgs,

    /// A light: point:x,y,z, dir:x,y,z (the direction towards the light), hom:x,y,z,w (homogeneous), file:NAME,
    /// file:INDEX (from 0) or file:all (lights of the model file, as `info` lists them). The option can be repeated
    #[arg(long = "light", value_name = "SPEC", required = true, allow_hyphen_values = true, value_parser = spec::light)]
    pub(crate) lights: Vec<LightSpec>,

    #[command(flatten)]
    pub(crate) posed: MomentArgs,

    /// How to find silhouette edges
    #[arg(long, value_enum, default_value_t = MethodArg::FaceMask)]
    pub(crate) method: MethodArg,

    /// How to decide which side of a face a light is on [default: exact; with `--method per-edge`: plane]
    #[arg(long, value_enum)]
    pub(crate) predicate: Option<PredicateArg>,

    /// Where to write the arrays
    #[arg(long, value_name = "FILE.npz")]
    pub(crate) out: PathBuf,

    /// Print counts and times as JSON instead of as text
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    _jobs: JobsArgs,
}

const EXTRACT_EXAMPLES: &str = "\
Examples:
  rimline extract fox.glb --light point:-1,2e2,.5 --light dir:0,1,0 --out fox.npz
  rimline extract fox.glb --light hom:0,1,0,0 --animation Run --time 0.4 --out fox.npz
  rimline extract fox.npz --no-weld --light dir:0,1,0 --device cpu --out again.npz
  rimline extract models/*.obj --light dir:0,1,0 --out bits/{stem}.npz --resume

Arrays written, V vertices, F faces, E edge records, N lights, W = N / 32 rounded up:
  positions (V,3) float32   welded, deformed, in world space less the origin
  faces (F,3) uint32        counter-clockwise
  lights (N,4) float32      as given; less w times the origin
  edges (E,2) uint32        a, b: face 0 runs from a to b
  edge_faces (E,2) uint32   face 1 is 0xFFFFFFFF where there is none
  edge_kind (E) uint8       0 consistent, 1 inconsistent, 2 boundary
  facing (F,W), silhouette (E,W), winding (E,W) uint32
                            light l is bit l % 32 of word l / 32
  origin (3) float64        last, and only where it is not zero: a point near a
                            model whose coordinates are too large for float32
Polygons taken whole have a row each in `facing`, and more arrays: docs/formats.md.
";

const EXTRACT_KEYS: &str = "\
Keys of --json: adapter, method, predicate, origin (only where it is not zero), vertices, faces, degenerate_faces, non_finite_faces, edges (consistent, \
inconsistent, boundary), lights, silhouette_edges and unclosed_vertices (a number a light), \
undecided_pairs and exact_zeros (pairs of face and light that integers decided), twisted_polygons (a number a light, \
for polygons), milliseconds (by stage), set_up_milliseconds (opening the device, buffers, compiling shaders), work_milliseconds \
(all other stages).";

#[derive(Args, Debug)]
#[command(help_template = verbatim(DRAW_EXAMPLES), after_help = DRAW_REMARKS, mut_arg("device", drawing_device), mut_arg("file", several))]
pub(crate) struct DrawArgs {
    #[command(flatten)]
    pub(crate) model: ModelArgs,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    #[command(flatten)]
    pub(crate) posed: MomentArgs,

    /// Show the model as clay, not in its base colours
    #[arg(long)]
    pub(crate) plain: bool,

    /// Draw open boundaries in orange
    #[arg(long)]
    pub(crate) show_boundary: bool,

    /// Where to write the picture, a PNG
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: PathBuf,

    /// Print what was drawn as JSON
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    _jobs: JobsArgs,
}

const DRAW_EXAMPLES: &str = "\
Examples:
  rimline draw fox.glb --out fox.png
  rimline draw fox.glb --animation Run --time 0.4 --eye -150,80,2e2 --out fox.png
  rimline draw cloth.glb --show-boundary --out cloth.png
  rimline draw --jobs jobs.jsonl --size 640x480 --out pictures/{index}-{stem}.png
";

const DRAW_REMARKS: &str = "\
Silhouette edges and open boundaries are dark; with --show-boundary, boundaries are orange. World space is right-handed with +Y up.

Keys of --json: adapter, out, size, vertices, faces, origin (only where it is not zero).";

#[derive(Args, Debug)]
#[command(help_template = verbatim(INFO_EXAMPLES), after_help = INFO_KEYS, mut_arg("file", several))]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) model: ModelArgs,

    /// A light, as of `extract`: of polygons it says how many face it, and how many are twisted as seen from it. The option can
    /// be repeated
    #[arg(long = "light", value_name = "SPEC", allow_hyphen_values = true, value_parser = spec::light)]
    pub(crate) lights: Vec<LightSpec>,

    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    _jobs: JobsArgs,
}

const INFO_EXAMPLES: &str = "\
Examples:
  rimline info fox.glb
  rimline info fox.glb --json
  rimline info house.obj --light dir:1,2,0
";

const INFO_KEYS: &str = "\
Keys of --json: file, instances, origin (only where it is not zero), meshes (a list), total (each mesh once), placed (all \
instances at rest in world space); each of these three with name, vertices (before, after, apart), faces, degenerate_faces, \
collapsed_faces, duplicate_faces, flipped_faces (of these the flipped copies), edges (consistent, inconsistent, boundary), \
non_manifold_edges, components, inward_components, closed, \
why_open, offending_edges (kind, vertices, positions), near_boundary (null where no two boundary edges nearly meet; edges, \
gap, weld_distance, closes, collapses, across_data, by_position), t_junctions, advice (what to do, texts), joints_per_vertex, morph_targets, bounds (min, \
max); polygons (null where all faces are triangles; triangles, quadrilaterals, larger, most_corners, with_holes, \
nonplanar, non_finite, seen: for each light facing, back_facing, in_plane, twisted); and of a glTF file skins (name, joints), \
animations (name, duration_seconds, channels), lights \
(name, kind, xyzw; the last two null for a damaged light), skipped_primitives (points, lines, without_position), \
hidden_nodes (with all below them), warnings (texts).";

#[derive(Args, Debug)]
#[command(after_help = DEVICES_KEYS)]
pub(crate) struct DevicesArgs {
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

const DEVICES_KEYS: &str = "\
Keys of --json: adapters, a list of name, backend, type, driver, driver_info, usable, lacks, wrong_clipping (pixels of \
a trial that the driver clips wrongly, null if unknown), limits (named \
as in WebGPU), optional_features (present, missing). The exit code is 3 if there is no GPU.";

#[derive(Args, Debug)]
#[command(help_template = verbatim(VERIFY_EXAMPLES), after_help = VERIFY_REMARKS, mut_args(when_making))]
pub(crate) struct VerifyArgs {
    /// The folder with .npz files of `rimline extract` or `rimline verify --make`
    #[arg(value_name = "DIR", required_unless_present = "built_in", conflicts_with = "built_in")]
    pub(crate) folder: Option<PathBuf>,

    /// Instead of files, check scenes that the command makes: those of the viewer and every stress scene, on each GPU against the
    /// CPU. The page of the viewer does the same in a browser, at `?check`
    #[arg(long, conflicts_with = "make")]
    pub(crate) built_in: bool,

    /// Write the files instead of checking them: an extraction of every stress scene, and of each MODEL at rest and within
    /// its first animation. The lights are hard cases for each model. Existing files are never replaced
    #[arg(long)]
    pub(crate) make: bool,

    /// With --make: .gltf, .glb, .obj, .ply, .stl or .npz files to extract, in addition to the stress scenes
    #[arg(value_name = "MODEL", requires = "make")]
    pub(crate) models: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) load: LoadArgs,

    /// With --make: the approximate number of faces of a stress scene, 1 to 4194304
    #[arg(
        long,
        value_name = "N",
        requires = "make",
        default_value = "2000",
        value_parser = clap::value_parser!(u32).range(1..=4_194_304),
    )]
    pub(crate) faces: u32,

    /// The devices to check: `all` (every GPU, and the CPU), `gpu` (every GPU), `cpu`, or a part of their name or backend
    /// (`rimline devices` lists them). With --make: the one device that computes the files, not `all` [default: all; with
    /// --built-in: gpu; with --make: cpu]
    #[arg(long, value_name = "all|gpu|cpu|NAME", value_parser = NonEmptyStringValueParser::new())]
    pub(crate) device: Option<String>,

    /// Print JSON instead of text
    #[arg(long, conflicts_with = "make")]
    pub(crate) json: bool,
}

/// Makes options of loading require `--make`, because `verify` reads models only then.
fn when_making(arg: clap::Arg) -> clap::Arg {
    let is_of_models = ["memory_limit", "input_format", "allow_outside", "up"].contains(&arg.get_id().as_str());
    if is_of_models { arg.requires("make") } else { arg }
}

const VERIFY_EXAMPLES: &str = "\
Examples:
  rimline verify --make bits fox.glb    # writes bits/fox.npz and the stress scenes
  rimline verify bits                   # compares every device with the files
  rimline verify bits --device vulkan --json
  rimline verify --built-in             # needs no files: a table of scenes and wrong bits
";

const VERIFY_REMARKS: &str = "\
Each device computes all other arrays again from the positions, faces and lights of each file. The command compares \
the result with the file byte by byte. The exit code is 0 if everything is equal, and 5 if any bit or byte differs. If \
a check cannot be done, the code is that of the first such check: 1 for a file that cannot be read, for example because \
of a wrong checksum. Another machine needs only the command and the folder. Files of `rimline extract` with another --method or \
--predicate than the default ones may differ on every device.

Keys of --json: devices (names), clips_wrongly (names of those whose driver clips slivers wrongly; bits are not \
concerned), unusable (what was left out, and why), equal, files: a list of file, faces, edges, \
lights, error (null unless the file cannot be read), results: a list of device, equal, error (null unless the device \
failed), differences: a list of array, wrong_bits, row, column, light, file, found (bits of the first element that \
differs), message. With --built-in: equal, unusable, devices: a list of device, scenes: a list of scene, pairs (of face \
and light), wrong_bits (null if it failed), error.";

#[derive(Args, Debug)]
#[command(help_template = verbatim(QUERY_EXAMPLES), after_help = QUERY_REMARKS)]
pub(crate) struct QueryArgs {
    #[command(flatten)]
    pub(crate) model: ModelArgs,

    /// An .npz file with `points` (P,3) float32 or float64 in world space, or - for standard input. With `origin` (3)
    /// they are relative to it. With `on_face` (P) integers each point names the face that it is on, which does not
    /// count for it: a row of `faces` as `extract` writes them, or -1
    #[arg(long, value_name = "FILE.npz")]
    pub(crate) points: PathBuf,

    /// A light: point:x,y,z, dir:x,y,z (the direction towards the light), hom:x,y,z,w (homogeneous, w not negative),
    /// file:NAME, file:INDEX (from 0) or file:all (lights of the model file, as `info` lists them). The option can be
    /// repeated
    #[arg(long = "light", value_name = "SPEC", required = true, allow_hyphen_values = true, value_parser = spec::light)]
    pub(crate) lights: Vec<LightSpec>,

    /// Move each point towards each light by D, in units of the file, and not beyond the light: computed in float64,
    /// rounded once. For points on a surface whose faces are not known
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = spec::lift)]
    pub(crate) lift: Option<f64>,

    #[command(flatten)]
    pub(crate) posed: MomentArgs,

    /// Where to write the arrays
    #[arg(long, value_name = "FILE.npz")]
    pub(crate) out: PathBuf,

    /// Print counts and times as JSON instead of as text
    #[arg(long)]
    pub(crate) json: bool,
}

const QUERY_EXAMPLES: &str = "\
Examples:
  rimline query fox.glb --points ground.npz --light point:-1,2e2,.5 --out depth.npz
  rimline query fox.glb --points ground.npz --light dir:1,2,1 --animation Run \\
      --time 0.4 --out depth.npz

Arrays written, P points, N lights:
  points (P,3) float32   as given, less the origin
  lights (N,4) float32   as given, less w times the origin
  depth (P,N) int32      number of faces strictly between the point and the light;
                         each face counts 1, whatever its orientation; 0 is lit,
                         -1 is a point that is infinite or NaN; a polygon counts
                         1 if an odd number of its triangles lie between
  origin (3) float64     only where it is not zero: a point near a model whose
                         coordinates are too large for float32
";

const QUERY_REMARKS: &str = "\
A face that contains the point or the light does not count. A point on a surface is seldom in its face exactly: rounding puts it a \
little before or behind, and behind, its own face hides it. So name the face in `on_face`, which is exact; of a polygon it is the \
triangle, and its other triangles count. Or give --lift: D is more than what rounding moves the points by (some 1e-7 of the largest \
coordinate), and less than the gaps that light must not pass; a point of a face that is lit at a low angle leaves it by little. \
`depth` is that of the moved points, and `points` are as given. On a closed model the depth is odd if exactly one of point \
and light is inside. Depths are computed in exact arithmetic: they are the same on every device.

Keys of --json: adapter, origin (only where it is not zero), vertices, faces, points, points_on_faces, non_finite_points, lights, points_in_shadow and deepest \
(a number for each light), milliseconds (by stage), set_up_milliseconds (opening the device, buffers, compiling \
shaders), work_milliseconds (all other stages).";
