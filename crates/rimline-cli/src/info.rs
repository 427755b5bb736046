//! `rimline info`: what a model holds, and whether it is closed.

mod asset;
mod json;
mod polygons;
mod report;
mod text;

use std::borrow::Cow;

use rimline::Light;
use rimline::reference::cpu::{self, Threads};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::failure::Failure;
use crate::input::{Input, Shape, Source};
use crate::output::print;
use crate::shown::Line;
use polygons::PolygonReport;
use report::MeshReport;
use text::Text;

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let input = Input::open(&args.model)?;
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
    /// Its polygons, if it has some.
    polygons: Option<PolygonReport>,
}

impl Report {
    fn new(input: &Input, lights: &[Light]) -> Result<Self, Failure> {
        let geometries = input.model().geometries().iter().enumerate();
        let meshes = geometries
            .map(|(index, geometry)| MeshReport::of_geometry(geometry, input.weld_counts(index)))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| Failure::input(&input.file)(error.into()))?;
        let scene = input.scene(&[], 0.0, false)?;
        let positions = match &scene.shape {
            Shape::World(positions) => Cow::Borrowed(*positions),
            Shape::Posed { model, pose } => Cow::Owned(cpu::deform(model, pose, 0.0, None, Threads::all())?),
        };
        let placed = MeshReport::of_mesh(&scene.mesh, &positions);
        let polygons = PolygonReport::of_mesh(&scene.mesh, &positions, lights);
        Ok(Self { total: MeshReport::total(&meshes), meshes, placed, polygons })
    }

    /// Keys are stable: they are only ever added to.
    fn json(&self, input: &Input) -> Result<Value, Failure> {
        let mut value = json!({
            "file": input.file.display().to_string(),
            "instances": input.model().instances().len(),
            "meshes": self.meshes.iter().map(json::mesh).collect::<Vec<_>>(),
            "total": json::mesh(&self.total),
            "placed": json::mesh(&self.placed),
            "polygons": self.polygons.as_ref().map(PolygonReport::json),
        });
        if let (Source::Gltf(asset), Value::Object(value)) = (&input.source, &mut value) {
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
        if let Source::Gltf(asset) = &input.source {
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
            polygons.text(&mut text);
        }
        Ok(text.finish())
    }
}
