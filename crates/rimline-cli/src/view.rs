//! `rimline view`: models in a window.

use std::path::PathBuf;

use clap::Args;
use rimline_files::Up;
use rimline_view::desktop::{DesktopError, DesktopOptions, run as open_window};

use crate::device::Wanted;
use crate::failure::{DRAW_ON_CPU, Failure, NoDevice};
use crate::input_args::{drawing_device, up, verbatim};
use crate::spec;

#[derive(Args, Debug)]
#[command(help_template = verbatim(EXAMPLES), mut_arg("device", drawing_device))]
pub(crate) struct WindowArgs {
    /// Models: .gltf, .glb, .obj, .ply, .stl or .npz. Without any, a built-in scene is shown. More can be dropped on
    /// the window, but not under Wayland
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,

    /// Width and height of the window in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x800", allow_hyphen_values = true, value_parser = spec::size)]
    size: [u32; 2],

    /// Where to draw
    #[arg(long, value_name = "auto|gpu|cpu|NAME", default_value = "auto")]
    device: Wanted,

    /// The axis of an .obj, .ply, .stl or .npz that is up. With `z`, as files of CAD often have it, (x, y, z) of the file is (x, z,
    /// -y) in the copied line. A glTF is always y up
    #[arg(long, value_name = "y|z", value_parser = up(), default_value = "y")]
    up: Up,

    /// The folder that screenshots go to
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    pictures: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  rimline view                          a walking figure; N shows the next scene
  rimline view fox.glb house.obj

Drag a light by its handle, or elsewhere to turn. ? lists the keys. C copies the view as
a line of `rimline shadow`, without shadows of `draw` or `lines`, which needs no window.
Overlays but volumes, flat faces and a missing ground have no option there: the message
says what of the view is not in the line.
";

pub(crate) fn run(args: &WindowArgs) -> Result<(), Failure> {
    let device = match &args.device {
        Wanted::Cpu => return Err(Failure::usage(DRAW_ON_CPU)),
        Wanted::Named(name) => Some(name.clone()),
        Wanted::Auto | Wanted::Gpu => None,
    };
    let options = DesktopOptions {
        files: args.files.clone(),
        size: args.size,
        device,
        pictures: args.pictures.clone(),
        up: args.up,
    };
    open_window(options).map_err(|error| match error {
        DesktopError::NoGpu => NoDevice::none().into(),
        DesktopError::NotNamed { name, found } => NoDevice::NotNamed { name, adapters: found }.into(),
        error => Failure::Window(error),
    })
}
