//! Arguments that several subcommands share.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use rimline::gltf::LoadOptions;
use rimline::mesh::Weld;

use crate::load_args::LoadArgs;
use crate::spec;
/// The model and how its vertices are joined.
#[derive(Args, Debug)]
pub(crate) struct ModelArgs {
    /// A .gltf, .glb, .obj or .npz file, or - for standard input. Faces of an .obj may have any number of corners. An .npz
    /// contains `positions` (V,3) float32 and `faces` (F,3) of any integer type. Faces at infinite or NaN positions face no
    /// light, cast no shadow and are not drawn; a warning counts the positions
    pub(crate) file: PathBuf,

    #[command(flatten)]
    weld: WeldArgs,

    #[command(flatten)]
    load: LoadArgs,
}

#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct WeldArgs {
    /// Which vertices are joined to one
    #[arg(long, value_enum, default_value_t = WeldArg::Data)]
    weld: WeldArg,

    /// Join no vertices: use them as they are in the file
    #[arg(long, conflicts_with = "weld")]
    no_weld: bool,
}

impl WeldArgs {
    pub(crate) fn weld(self) -> Weld {
        match self.weld {
            _ if self.no_weld => Weld::Keep,
            WeldArg::Data => Weld::Data,
            WeldArg::Position => Weld::Position,
        }
    }
}

/// Where the model's vertices are, and who says so.
#[derive(Args, Debug)]
pub(crate) struct MomentArgs {
    #[command(flatten)]
    pub(crate) pose: PoseArgs,

    /// A WGSL file with `fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32>`, or - for standard input.
    /// It moves vertices in world space, after morph targets and skins. It needs a GPU
    #[arg(long, value_name = "FILE.wgsl")]
    pub(crate) displace: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

/// The posed.
#[derive(Args, Debug)]
pub(crate) struct PoseArgs {
    /// The animation that poses the model, by name or by number from 0, or `all`. Without it the model is at rest. The
    /// option can be repeated: the animations play together, unless two move the same property of a node
    #[arg(long = "animation", value_name = "NAME|INDEX|all", allow_hyphen_values = true)]
    pub(crate) animations: Vec<String>,

    /// The time in seconds, for the animation and for `displace`
    #[arg(long, value_name = "S", default_value = "0", allow_hyphen_values = true, value_parser = spec::seconds)]
    pub(crate) time: f32,
}

#[derive(Args, Debug)]
pub(crate) struct DeviceArgs {
    /// Where to compute: `auto` (a GPU if there is one, else the CPU), `gpu` (any GPU, software GPUs included), `cpu`, or a
    /// part of a device's name or backend (`rimline devices` lists them)
    #[arg(long, value_name = "auto|gpu|cpu|NAME", default_value = "auto")]
    pub(crate) device: String,
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
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::point)]
    pub(crate) eye: Option<[f32; 3]>,

    /// The point that the eye looks at. By default it is the middle of the model
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = spec::point)]
    pub(crate) target: Option<[f32; 3]>,

    /// The vertical field of view in degrees
    #[arg(long, value_name = "DEG", default_value = "35", allow_hyphen_values = true, value_parser = spec::field_of_view)]
    pub(crate) fov: f32,

    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x960", allow_hyphen_values = true, value_parser = spec::size)]
    pub(crate) size: [u32; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WeldArg {
    /// Vertices with equal positions and equal skin and morph data
    Data,
    /// Vertices with equal positions, even if their skin and morph data differ
    Position,
}

impl ModelArgs {
    pub(crate) fn options(&self) -> LoadOptions {
        self.load.options(self.weld.weld())
    }
}
