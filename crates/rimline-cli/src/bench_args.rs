//! Options of `rimline bench`.

use std::path::PathBuf;

use clap::Args;

use crate::input_args::{DeviceArgs, LoadArgs, verbatim};
use crate::spec::{self, LightSpec};

#[derive(Args, Debug)]
#[command(help_template = verbatim(EXAMPLES), after_help = REMARKS)]
pub(crate) struct BenchArgs {
    /// A model to measure instead of meshes and scenes made by code: a .gltf, .glb, .obj, .ply, .stl or .npz file. It is measured
    /// at rest
    pub(crate) file: Option<PathBuf>,

    /// A light for the model, as of `extract`. The option can be repeated. Without it there are lights all around
    #[arg(long, value_name = "SPEC", requires = "file", allow_hyphen_values = true, value_parser = spec::light)]
    pub(crate) light: Vec<LightSpec>,

    #[command(flatten)]
    pub(crate) load: LoadArgs,

    /// Measure smaller meshes, one scene of each class, fewer casters and fewer rounds. It takes about a minute instead of
    /// about half an hour
    #[arg(long)]
    pub(crate) quick: bool,

    /// The folder for the report: index.html, plots as PNG, data.json. It is made if it does not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,

    /// Where to write the data as JSON (--schema describes it)
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    /// Face counts of the closed meshes, or `none` [default: 1,024 to 4 million, by fours; `none` with a model]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = parse_meshes)]
    pub(crate) meshes: Option<Vec<usize>>,

    /// Names of stress scenes, `casters` for scenes of many casters, `still`, `city`, `crowd`, `moving`, `house` and
    /// `big` for what a frame skips, `all` or `none` [default: all, and `none` with a model]
    #[arg(long, visible_alias = "scene", value_name = "NAME,…", value_delimiter = ',')]
    pub(crate) scenes: Option<Vec<String>>,

    /// Numbers of casters for the scenes `casters`, `still`, `city`, `crowd`, `moving` and `house`, or `none`: boxes, and up
    /// to 1,000 figures of 4,000 faces [default: 1, 10, 100, 200, 1,000 and 10,000 (quick: 1, 10 and 100); 1,000
    /// figures (quick: 20) and 10,000 buildings (quick: 100)]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = parse_casters)]
    pub(crate) casters: Option<Vec<usize>>,

    /// The approximate number of faces of a stress scene [default: 65,536]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4_194_304))]
    pub(crate) scene_faces: Option<u32>,

    /// Numbers of lights [default: 1, 8 and 32; for stress scenes 8]. `casters`, `still` and `moving` always have 5,
    /// `house` 9, `city` and `big` 1, and `crowd` 32
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) lights: Option<Vec<u16>>,

    /// The largest number of counted runs of each method. Slow rows have fewer, but at least 5 (quick: 3) [default: 21
    /// (quick: 9)]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) rounds: Option<u16>,

    /// Frames of each camera path for shadows. 0 leaves shadows out [default: 16 (quick: 6)]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub(crate) frames: Option<u16>,

    /// Also show the times in this file, which `cargo bench --bench depth_maps -- casters --json FILE` writes: shadows
    /// by depth maps, by meshes and by lookups
    #[arg(long, value_name = "FILE")]
    pub(crate) depth_maps: Option<PathBuf>,

    /// Print the JSON Schema of the data and measure nothing
    #[arg(long)]
    pub(crate) schema: bool,
}

const EXAMPLES: &str = "\
Examples:
  rimline bench --quick --report report
  rimline bench fox.glb --light point:-1,2e2,.5 --light dir:0,1,0
  rimline bench --report report --json figures.json
  rimline bench --scene casters --meshes none --frames 0 --casters 200,10000
  rimline bench --scene still,city,crowd,moving,house,big --meshes none \\
      --frames 0 --report report
  rimline bench --meshes none --scenes none --frames 0 --depth-maps times.json \\
      --report report
  rimline bench --meshes 65536 --lights 8 --scenes translation-1e6,plate-third \\
      --rounds 5
";

const REMARKS: &str = "\
At the end, a line for each question: how fast, at which price, how right. Report and data have everything else. The methods \
run in turn, round by round, for each mesh and number of lights. Errors are bits that differ from exact arithmetic, and \
vertices where loops stay open. A model of yours also casts in the room of the camera paths, as large as the others there. For \
the scene `casters`, CPU times are of recording a frame with one view, and GPU times are compared with the same faces merged \
into one mesh. The scenes `still`, `city`, `crowd`, `moving`, `house` and `big` are measured with all levels of skipping on, with all \
off, and with each off alone. Ctrl-C ends the run. Report and data then contain the finished rows and say so, and the exit code \
is 130.";

/// A number of faces or casters; 0 for none.
fn count(text: &str, most: usize, what: &str) -> Result<usize, String> {
    match text.parse() {
        _ if text == "none" => Ok(0),
        Ok(count) if (1..=most).contains(&count) => Ok(count),
        _ => Err(format!("give numbers of {what}, or `none`")),
    }
}

fn parse_meshes(text: &str) -> Result<usize, String> {
    count(text, 16_777_216, "faces up to 16,777,216")
}

fn parse_casters(text: &str) -> Result<usize, String> {
    count(text, 100_000, "casters up to 100,000")
}
