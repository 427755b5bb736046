//! Options of `rimline query`.

use std::path::PathBuf;

use clap::Args;

use crate::input_args::{ModelArgs, MomentArgs, verbatim};
use crate::spec::{self, LightSpec};

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
