//! `rimline info`: what a model holds, and whether it is closed.

mod asset;
mod polygons;
mod report;
mod seams;
mod text;

use polygons::PolygonReport;
use report::MeshReport;
use rimline::{Light, Origin};
pub(crate) use seams::Seams;
use serde_json::{Value, json};
use text::Text;

use crate::args::InfoArgs;
use crate::coordinates::{add_origin, origin_text};
use crate::failure::{Failure, InputError};
use crate::input::Input;
use crate::origin;
use crate::output::print;
use crate::report::Times;
use crate::shown::Line;
use rimline_files::Polygons;

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let taken = match args.model.polygons.taken() {
        Polygons::Triangles => Polygons::Described,
        taken => taken,
    };
    let mut input = Input::read(&args.model.file, args.model.options(), taken)?;
    origin::settle(std::slice::from_mut(&mut input), &[Vec::new()], 0.0)?;
    let lights = input.lights(&args.lights, &[], 0.0)?;
    let report = Report::new(&input, &lights)?;
    print(&if args.json { format!("{:#}\n", report.json(&input)?) } else { report.text(&input)? })
}

struct Report {
    meshes: Vec<MeshReport>,
    /// Each mesh once.
    total: MeshReport,
    /// All instances at rest, in world space: what `extract` works on.
    placed: MeshReport,
    /// The file's polygons, if it has some. Unless they are taken whole, `placed` has their triangles.
    polygons: Option<PolygonReport>,
}

impl Report {
    fn new(input: &Input, lights: &[Light]) -> Result<Self, Failure> {
        // Meshes of a glTF file have spaces of their own, and others are in the world.
        let mesh_origin = if input.asset().is_some() { Origin::ZERO } else { input.origin() };
        let geometries = input.model().geometries().iter().enumerate();
        let meshes = geometries
            .map(|(index, geometry)| MeshReport::of_geometry(geometry, input.weld_counts(index), mesh_origin))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| Failure::input(&input.file)(error.into()))?;
        let total = MeshReport::total(&meshes);
        let shape = input.shape(&[], 0.0, false)?;
        let mesh = match input.mesh(&shape) {
            Err(Failure::Input { source: InputError::EmptyScene, .. }) => {
                return Ok(Self { meshes, total, placed: MeshReport::default(), polygons: None });
            }
            mesh => mesh?,
        };
        let positions = shape.on_cpu(&mut Times::default())?;
        let placed = MeshReport::of_mesh(&mesh, &positions, input.origin());
        let polygons = match input.described() {
            Some(given) => PolygonReport::of_mesh(&given.mesh, &given.positions, lights),
            None => PolygonReport::of_mesh(&mesh, &positions, lights),
        };
        Ok(Self { meshes, total, placed, polygons })
    }

    /// Keys are stable: they are only ever added to.
    fn json(&self, input: &Input) -> Result<Value, Failure> {
        let mut value = json!({
            "file": input.file.display().to_string(),
            "instances": input.model().instances().len(),
            "meshes": self.meshes.iter().map(report::mesh).collect::<Vec<_>>(),
            "total": report::mesh(&self.total),
            "placed": report::mesh(&self.placed),
            "polygons": self.polygons.as_ref().map(PolygonReport::json),
        });
        add_origin(&mut value, input.origin());
        if let (Some(asset), Value::Object(value)) = (input.asset(), &mut value) {
            asset::json(asset, &asset::lights(asset, input)?, value);
            let warnings: Vec<String> = asset.warnings().iter().map(ToString::to_string).collect();
            value.insert("hidden_nodes".into(), asset.hidden_nodes().into());
            value.insert("warnings".into(), warnings.into());
        }
        Ok(value)
    }

    fn text(&self, input: &Input) -> Result<String, Failure> {
        let mut text = Text::titled(&Line(input.file.display()));
        text.line("meshes", self.meshes.len());
        text.line("instances", input.model().instances().len());
        let what = "what other subcommands write is relative to it; the lines below are not";
        if let Some(origin) = origin_text(input.origin(), what) {
            text.line("origin", origin);
        }
        if let Some(asset) = input.asset() {
            asset::text(asset, &asset::lights(asset, input)?, &mut text);
        }
        for (index, mesh) in self.meshes.iter().enumerate() {
            let name = mesh.name.as_ref().map_or_else(String::new, |name| format!(" \"{}\"", Line(name)));
            text.heading(format!("mesh {index}{name}, in its own space"));
            text.mesh(mesh);
        }
        if self.meshes.len() > 1 {
            text.heading("all meshes, each once");
            text.mesh(&self.total);
        }
        text.heading("all instances, at rest in world space");
        text.mesh(&self.placed);
        if let Some(polygons) = &self.polygons {
            polygons.text(&mut text, input.described().is_some());
        }
        Ok(text.finish())
    }
}
