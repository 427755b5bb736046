//! The folder to check: extractions of models and of every stress scene, with lights that are hard on each mesh.

use std::io;
use std::path::{Path, PathBuf};

use rimline::mesh::Weld;
use rimline::{Geometry, GeometryOptions, Light, Mesh, Origin};
use rimline_bench::stress;
use rimline_models::check::{LIGHTS, hard_lights};

use crate::args::VerifyArgs;
use crate::device::{self, Device, Wanted};
use crate::extract::{arrays, extract_exactly};
use crate::failure::{Failure, InputError};
use crate::input::{Input, Scene, Shape};
use crate::origin;
use crate::output::{Folder, Output, say};
use crate::progress::Progress;
use crate::report::Times;
use crate::shown::Line;
use rimline_files::Polygons;

/// Where in its first animation a model is posed, as a part of the whole.
const MOMENT: f32 = 0.37;

pub(super) fn run(args: &VerifyArgs, folder: &Path) -> Result<(), Failure> {
    let progress = Progress::start();
    check_names(&args.models)?;
    let names = args.models.iter().flat_map(|model| [stem(model), posed(model)]);
    for name in names.chain(stress::names().map(of_scene)) {
        refuse_existing(&target(folder, &name))?;
    }
    let _folder = Folder::create(folder)?;
    progress.step("opening the device");
    let maker = Maker {
        folder,
        device: device::open(&Wanted::parse(args.device.as_deref().unwrap_or("cpu")))?,
        progress: &progress,
    };
    for model in &args.models {
        progress.step(format!("reading {}", model.display()));
        let mut input = Input::read(model, args.load.options(Weld::Data), Polygons::Triangles)?;
        origin::settle(std::slice::from_mut(&mut input), &[Vec::new()], 0.0)?;
        maker.pose(&input, &[], 0.0, &stem(model))?;
        if let Some(asset) = input.asset()
            && let mut animations = asset.animations().iter().enumerate()
            && let Some((index, animation)) = animations.find(|(_, info)| info.fault.is_none())
        {
            maker.pose(&input, &[index], MOMENT * animation.duration_s, &posed(model))?;
        }
    }
    for scene in stress::scenes(args.faces as usize) {
        maker.scene(scene)?;
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

/// Two models must not go to one file.
fn check_names(models: &[PathBuf]) -> Result<(), Failure> {
    for (index, model) in models.iter().enumerate() {
        let takes = |other: &&PathBuf| [stem(other), posed(other)].contains(&stem(model));
        if let Some(other) = models[..index].iter().chain(&models[index + 1..]).find(takes) {
            return Err(Failure::input(model)(InputError::SameName { other: other.clone() }));
        }
    }
    Ok(())
}

fn refuse_existing(file: &Path) -> Result<(), Failure> {
    if file.symlink_metadata().is_err() {
        return Ok(());
    }
    let source = io::Error::other("it exists, and files are never written over; remove it or choose another folder");
    Err(Failure::Output { file: file.to_owned(), source })
}

struct Maker<'a> {
    folder: &'a Path,
    device: Device,
    progress: &'a Progress,
}

impl Maker<'_> {
    fn pose(&self, input: &Input, animations: &[usize], time_s: f32, name: &str) -> Result<(), Failure> {
        let Scene { mesh, shape } = input.scene(animations, time_s, false)?;
        let positions = shape.on_cpu(&mut Times::default())?;
        let lights = hard_lights(&positions, mesh.faces());
        self.write(name, &positions, mesh, &lights, input.origin())
    }

    fn scene(&self, scene: stress::Scene) -> Result<(), Failure> {
        let (lights, name) = (scene.lights(LIGHTS), of_scene(scene.name));
        let stress::Scene { positions, faces, .. } = scene;
        // No file holds it yet; the one that it was to become names it.
        let refused = |error: InputError| Failure::input(&target(self.folder, &name))(error);
        let geometry = Geometry::new(positions, faces, GeometryOptions::default());
        let (geometry, _) = geometry.map_err(|error| refused(error.into()))?.welded(Weld::Position);
        let mesh = geometry.mesh();
        let mesh = mesh.map_err(|error| refused(error.into()))?;
        self.write(&name, geometry.positions(), mesh, &lights, Origin::ZERO)
    }

    fn write(
        &self,
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
        output.finish(|to| arrays::write(to, &scene.mesh, lights, &found, origin))?;
        let faces = scene.mesh.faces().len();
        self.progress
            .aside(|| say(&format!("wrote {} ({faces} faces, {} lights)\n", Line(file.display()), lights.len())))
    }
}
