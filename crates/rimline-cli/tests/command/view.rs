//! The command that the viewer copies draws the picture that the viewer shows.

use std::path::Path;
use std::process::Command;

use rimline::mesh::Weld;
use rimline_files::{Format, ReadOptions, Up, read_bytes};
use rimline_testkit::device::Gpu as Device;
use rimline_testkit::on_gpu::text;
use rimline_testkit::shapes;
use rimline_view::{Event, Gpu, Lamp, LampKind, Mode, Renderer, Viewer, scenes};

use super::makers::npz_model;
use super::pictures::apart;
use super::run::{Folder, folder, rimline, run_command};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("view::a_copied_command_draws_the_picture_of_the_viewer", copied),
    ("view::a_copied_command_reads_files_as_the_viewer_did", read_alike),
];

const SIZE: [u32; 2] = [320, 240];

/// A view's name, and how a viewer gets there.
type State<'a> = (&'a str, &'a dyn Fn(&mut Viewer));

/// Noise of half a step of 8 bits is added to darkness after and before the curve of sRGB, and by then is larger.
const CHANNEL: u8 = 8;

/// Channels of a screenshot of the viewer.
fn screenshot(renderer: &mut Renderer, viewer: &Viewer) -> Result<Vec<u8>, String> {
    let picture = renderer.screenshot(viewer, 1).map_err(text)?;
    renderer.gpu().device.poll(wgpu::PollType::wait_indefinitely()).map_err(text)?;
    Ok(pollster::block_on(picture).map_err(text)?.pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect())
}

fn renderer() -> Result<Renderer, String> {
    let device = Device::shared_with_depth_features()?;
    let gpu = Gpu::of(device.device.clone(), device.queue.clone(), device.name.clone(), true);
    Renderer::new(gpu).map_err(text)
}

/// A viewer of one file.
fn viewer(model: &[u8], read: ReadOptions) -> Result<Viewer, String> {
    let mut viewer = Viewer::new(scenes::moebius().map_err(text)?);
    viewer.handle(Event::Resized(SIZE));
    viewer.read = read;
    let file = read_bytes(model, Some(Path::new("torus.npz")), &viewer.read);
    viewer.open("torus.npz", "torus.npz".into(), file);
    ensure!(!viewer.is_built_in(), "{:?}", viewer.message);
    Ok(viewer)
}

/// Channels of the picture that a command draws in a folder.
fn drawn(folder: &Folder, command: &str) -> Result<Vec<u8>, String> {
    let words = command.strip_prefix("rimline ").ok_or("another command")?.split(' ');
    let run = run_command(Command::new(env!("CARGO_BIN_EXE_rimline")).args(words).current_dir(folder.path()));
    run.expect(0, &[])?;
    Ok(folder.image("view.png")?.bytes)
}

fn copied() -> Outcome {
    let folder = folder();
    let model = npz_model(&shapes::torus(24, 16, 1.0, 0.4), 1.0, [3.0, 1.0, -2.0]);
    folder.write("torus.npz", &model)?;
    let (mut renderer, mut viewer) = (renderer()?, viewer(&model, ReadOptions::default())?);
    let bounds = viewer.bounds();
    let spot = |viewer: &mut Viewer| viewer.lamps[0].set_spot(true, &bounds);
    let states: [State<'_>; 5] = [
        ("points", &|_| ()),
        ("a spot", &|viewer| {
            spot(viewer);
            viewer.lamps[0].aim(bounds.centre() + 0.4);
            viewer.lamps.truncate(1);
        }),
        ("ranges", &|viewer| viewer.lamps.iter_mut().for_each(|lamp| lamp.range = Some(1.2 * bounds.extent()))),
        ("areas", &|viewer| {
            spot(viewer);
            viewer.lamps[0].radius = Some(0.2 * bounds.extent());
            let towards = (viewer.lamps[1].handle(&bounds) - bounds.centre()).normalize();
            viewer.lamps[1] = Lamp { kind: LampKind::Sun(towards), radius: Some(0.1), ..viewer.lamps[1].clone() };
        }),
        ("areas in another mode", &|viewer| {
            viewer.lamps[0].radius = Some(0.2 * bounds.extent());
            viewer.options.mode = Mode::Composited;
        }),
    ];
    let (lamps, options) = (viewer.lamps.clone(), viewer.options);
    for (name, set) in states {
        (viewer.lamps, viewer.options) = (lamps.clone(), options);
        set(&mut viewer);
        let command = viewer.command();
        let (shown, drawn) = (screenshot(&mut renderer, &viewer)?, drawn(&folder, &command)?);
        let count = apart([&shown, &drawn], 3, CHANNEL)?;
        ensure!(count == 0, "{name}: {count} pixels are apart: {command}");
    }
    // A spot is no light all around.
    (viewer.lamps, viewer.options) = (lamps, options);
    let around = drawn(&folder, &viewer.command())?;
    spot(&mut viewer);
    let count = apart([&screenshot(&mut renderer, &viewer)?, &around], 3, CHANNEL)?;
    ensure!(count > 1000, "only {count} pixels differ");
    Ok(())
}

fn read_alike() -> Outcome {
    let folder = folder();
    let model = npz_model(&shapes::torus(24, 16, 1.0, 0.4), 1.0, [3.0, 1.0, -2.0]);
    folder.write("torus.npz", &model)?;
    let (weld, format) = (Weld::Position, Some(Format::Npz));
    let read =
        ReadOptions { weld, format, memory_limit: 1 << 30, allow_outside: true, up: Up::Z, ..ReadOptions::default() };
    let viewer = viewer(&model, read)?;
    let command = viewer.command();
    let options = " --weld position --memory-limit 1073741824 --input-format npz --allow-outside --up z ";
    ensure!(command.contains(options), "{command}");
    let (shown, drawn) = (screenshot(&mut renderer()?, &viewer)?, drawn(&folder, &command)?);
    let count = apart([&shown, &drawn], 3, CHANNEL)?;
    ensure!(count == 0, "{count} pixels are apart: {command}");
    // The window's own command takes them, too, and then opens no file: there is none.
    let words = ["view", "--weld-distance", "0.1", "--no-weld", "nope.npz"];
    rimline(words).expect(2, &["--no-weld"])?;
    let words =
        "view --weld position --weld-distance 0.1 --input-format npz --memory-limit 1GiB --allow-outside nope.npz";
    rimline(words.split(' ')).expect(1, &["nope.npz"])
}
