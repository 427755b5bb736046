//! The folder to check: extractions of models and of every stress scene, with lights that are hard on each mesh.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use rimline::gltf::Asset;
use rimline::mesh::Weld;
use rimline::{Geometry, GeometryOptions, Light, Mesh, Origin};
use rimline_bench::stress;
use rimline_files::Polygons;
use rimline_files::npz::NpzError;
use rimline_models::check::{LIGHTS, hard_lights};

use crate::args::VerifyArgs;
use crate::device::{self, Device};
use crate::extract::{extract_exactly, write_arrays};
use crate::failure::Failure;
use crate::files::check_folder;
use crate::input::{Input, Scene, Shape};
use crate::output::{Filled, Folder, Line, Output, Progress, say};
use crate::report::Times;

/// Where in its first animation a model is posed, as a part of the whole.
const MOMENT: f32 = 0.37;

pub(super) fn run(args: &VerifyArgs, folder: &Path) -> Result<(), Failure> {
    let wanted = args.device.as_deref().unwrap_or("cpu");
    if wanted.eq_ignore_ascii_case("all") {
        return Err(Failure::usage("--make computes on one device; give --device gpu, cpu or a name"));
    }
    check_folder(folder, "--make writes a folder of archives; give the name of a folder")?;
    let progress = Progress::start();
    check_names(&args.models)?;
    let names = args.models.iter().flat_map(|model| [stem(model), posed(model)]);
    for name in names.chain(stress::names().map(of_scene)) {
        let file = target(folder, &name);
        if file.symlink_metadata().is_ok() {
            let why = "it exists, and files are never written over; remove it or choose another folder";
            return Err(Failure::output(&file)(io::Error::other(why)));
        }
    }
    let _folder = Folder::create(folder)?;
    progress.step("opening the device");
    let (device, made, said) = (device::open(&wanted.into())?, Vec::new(), String::new());
    let mut maker = Maker { folder, device, progress: &progress, made, said };
    // All are read and checked before the first file is written.
    let read = |model: &PathBuf| {
        progress.step(format!("reading {}", model.display()));
        read(model, args)
    };
    for mut input in args.models.iter().map(read).collect::<Result<Vec<_>, _>>()? {
        each_pose(&mut input, |input, time_s, name| maker.pose(input, time_s, name))?;
    }
    for scene in stress::scenes(args.faces as usize) {
        maker.scene(scene)?;
    }
    // Files are never written over, so after a failure the same command must find none.
    Filled::finish_all(maker.made)?;
    progress.aside(|| say(&maker.said))
}

/// Reads a model, and refuses one that has no mesh of triangles in each of its poses.
fn read(model: &Path, args: &VerifyArgs) -> Result<Input, Failure> {
    let mut input = Input::at_rest(model, &args.load.options(Weld::Data, Polygons::Triangles))?;
    if input.polygons().is_some_and(|mesh| mesh.polygons().is_some()) {
        return Err(Failure::input(model, NpzError::Polygons));
    }
    each_pose(&mut input, |input, time_s, _| input.scene(time_s, false).map(drop))?;
    Ok(input)
}

/// Calls `run` for a model at rest and, if an animation can play, for a moment of the first one: with the time and the name
/// of the archive.
fn each_pose(input: &mut Input, mut run: impl FnMut(&Input, f32, &str) -> Result<(), Failure>) -> Result<(), Failure> {
    input.playing.clear();
    run(input, 0.0, &stem(&input.file))?;
    let mut animations = input.asset().map_or(&[][..], Asset::animations).iter().enumerate();
    if let Some((index, animation)) = animations.find(|(_, info)| info.fault.is_none()) {
        let time_s = MOMENT * animation.duration_s;
        input.playing = vec![index];
        run(input, time_s, &posed(&input.file))?;
    }
    Ok(())
}

fn of_scene(name: &str) -> String {
    format!("stress-{name}")
}

fn stem(model: &Path) -> String {
    model.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn posed(model: &Path) -> String {
    format!("{}-posed", stem(model))
}

fn target(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.npz"))
}

/// Two models, or a model and a scene, must not go to one file, and none to a file in the making.
fn check_names(models: &[PathBuf]) -> Result<(), Failure> {
    const BOTH: &str = "so both would be written to the same file; rename";
    for (index, model) in models.iter().enumerate() {
        let takes = |other: &&PathBuf| [stem(other), posed(other)].contains(&stem(model));
        if let Some(other) = models[..index].iter().chain(&models[index + 1..]).find(takes) {
            let why = format!("it has the same name as {}, {BOTH} one of them", other.display());
            return Err(Failure::input(model, why));
        }
        if stem(model).starts_with('.') {
            return Err(Failure::input(
                model,
                "its name begins with a dot, and such archives are never checked; rename it",
            ));
        }
        if stress::names().map(of_scene).any(|scene| [stem(model), posed(model)].contains(&scene)) {
            return Err(Failure::input(model, format!("it has the name of a stress scene, {BOTH} it")));
        }
    }
    Ok(())
}

struct Maker<'a> {
    folder: &'a Path,
    device: Device,
    progress: &'a Progress,
    made: Vec<Filled>,
    /// The message once they are at their paths.
    said: String,
}

impl Maker<'_> {
    fn pose(&mut self, input: &Input, time_s: f32, name: &str) -> Result<(), Failure> {
        let Scene { mesh, shape } = input.scene(time_s, false)?;
        let positions = shape.on_cpu(&mut Times::default())?;
        let lights = hard_lights(&positions, mesh.faces());
        self.write(name, &positions, mesh, &lights, input.origin())
    }

    fn scene(&mut self, scene: stress::Scene) -> Result<(), Failure> {
        let (lights, name) = (scene.lights(LIGHTS), of_scene(scene.name));
        let stress::Scene { positions, faces, .. } = scene;
        // No file holds it yet; the one that it was to become names it.
        let file = target(self.folder, &name);
        let geometry = Geometry::new(positions, faces, GeometryOptions::default());
        let (geometry, _) = geometry.map_err(|error| Failure::input(&file, error))?.welded(Weld::Position);
        let mesh = geometry.mesh().map_err(|error| Failure::input(&file, error))?;
        self.write(&name, geometry.positions(), mesh, &lights, Origin::ZERO)
    }

    fn write(
        &mut self,
        name: &str,
        positions: &[[f32; 3]],
        mesh: Mesh,
        lights: &[Light],
        origin: Origin,
    ) -> Result<(), Failure> {
        let file = target(self.folder, name);
        self.progress.step(format!("writing {}", file.display()));
        let output = Output::create(&file)?;
        let scene = Scene { mesh, shape: Shape::World(positions) };
        let found = extract_exactly(&self.device, &scene, lights)?;
        self.made.push(output.fill(|to| write_arrays(to, &scene.mesh, lights, &found, origin))?);
        let faces = scene.mesh.faces().len();
        let _ = writeln!(self.said, "wrote {} ({faces} faces, {} lights)", Line(file.display()), lights.len());
        Ok(())
    }
}
