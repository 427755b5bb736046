//! What `rimline query` is asked.

use std::path::PathBuf;

use clap::Args;

use crate::input_args::{ModelArgs, MomentArgs};
use crate::spec::{self, LightSpec};

#[derive(Args, Debug)]
#[command(after_help = QUERY_EXAMPLES)]
pub(crate) struct QueryArgs {
    #[command(flatten)]
    pub(crate) model: ModelArgs,

    /// An .npz archive with the points, or - for standard input: `points` (P,3) float32, in world space
    #[arg(long, value_name = "FILE.npz")]
    pub(crate) points: PathBuf,

    /// A light: point:x,y,z, dir:x,y,z (towards the light), hom:x,y,z,w (homogeneous, w not negative), file:NAME or
    /// file:all (the model file's own lights); may be given many times
    #[arg(long = "light", value_name = "SPEC", required = true, allow_hyphen_values = true, value_parser = spec::light)]
    pub(crate) lights: Vec<LightSpec>,

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
  rimline query fox.glb --points ground.npz --light file:all --animation Run --out depth.npz

Arrays written, P points, N lights:
  points (P,3) float32   as given
  lights (N,4) float32   as given
  depth (P,N) int32      faces strictly between the point and the light, each counted
                         once, whatever its orientation; 0 is lit, -1 a point that is
                         infinite or NaN

A face that contains the point or the light is not between. On a closed model the depth of a point is odd \
where one of point and light is inside and the other is not. Depths are decided in exact arithmetic: the same on every device.

Keys of --json: adapter, vertices, faces, points, non_finite_points, lights, points_in_shadow and deepest \
(a number a light), milliseconds (by stage).";
