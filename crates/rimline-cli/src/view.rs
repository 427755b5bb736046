//! `rimline view`: models in a window.

use std::path::PathBuf;

use clap::Args;
use rimline_files::Polygons;
use rimline_view::desktop::{DesktopError, DesktopOptions, run as open_window};

use crate::device::Wanted;
use crate::failure::{DRAW_ON_CPU, Failure, NoDevice};
use crate::input_args::{LoadArgs, WeldArgs, device, drawing_device, verbatim};
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
    #[arg(long, value_name = "auto|gpu|cpu|NAME", default_value = "auto", value_parser = device())]
    device: Wanted,

    /// The folder that screenshots go to
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    pictures: PathBuf,

    #[command(flatten)]
    weld: WeldArgs,

    #[command(flatten)]
    load: LoadArgs,
}

const EXAMPLES: &str = "\
Examples:
  rimline view                          a walking figure; N shows the next scene
  rimline view fox.glb house.obj
  rimline view --weld position scan.obj   seams of split vertices are joined

Drag a light by its handle, or elsewhere to turn. ? lists the keys, and Tab goes through
the panel, so nothing needs a pointer. C copies a command that draws the view without a
window: `rimline shadow`, `draw` or `lines`. Options of files hold for those that are
dropped on the window, too.
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
        // Triangles are drawn, and decide.
        read: args.load.options(args.weld.weld(), Polygons::Triangles),
    };
    open_window(options).map_err(|error| match error {
        DesktopError::NoGpu => NoDevice::none().into(),
        DesktopError::NotNamed { name, found } => NoDevice::NotNamed { name, adapters: found }.into(),
        error => Failure::Window(error),
    })
}
