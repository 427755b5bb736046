//! `rimline info`: what a model holds, and whether it is closed.

mod json;
mod report;
mod text;

use rimline::cpu::{self, Threads};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::failure::{Failure, InputError};
use crate::input::{Input, Shape};
use crate::output::print;
use report::MeshReport;
use text::Text;

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let file = args.model.file.as_path();
    let input = Input::open(&args.model)?;
    let report = Report::new(&input).map_err(Failure::input(file))?;
    print(&if args.json {
        format!("{:#}\n", report.json(&input))
    } else {
        report.text(&input, &file.display().to_string())
    })
}

struct Report {
    meshes: Vec<MeshReport>,
    /// Each mesh once.
    total: MeshReport,
    /// All instances at rest, in world space: what `extract` works on.
    placed: MeshReport,
}

impl Report {
    fn new(input: &Input) -> Result<Self, InputError> {
        let geometries = &input.model().geometries;
        let meshes = geometries
            .iter()
            .zip(&*input.weld_counts())
            .map(|(geometry, &weld)| MeshReport::of_geometry(geometry, weld))
            .collect::<Result<Vec<_>, _>>()?;
        let scene = input.scene(None, 0.0, false)?;
        let placed = match &scene.shape {
            Shape::World(positions) => MeshReport::of_mesh(&scene.mesh, positions),
            Shape::Posed { model, pose } => {
                let positions = cpu::deform(model, pose, 0.0, None, Threads::all());
                MeshReport::of_mesh(&scene.mesh, &positions)
            }
        };
        Ok(Self {
            total: MeshReport::total(&meshes),
            meshes,
            placed,
        })
    }

    /// Keys are stable: they are only ever added to.
    fn json(&self, input: &Input) -> Value {
        let mut value = json!({
            "meshes": self.meshes.iter().map(json::mesh).collect::<Vec<_>>(),
            "total": json::mesh(&self.total),
            "placed": json::mesh(&self.placed),
        });
        input.info_json(&mut value);
        value
    }

    fn text(&self, input: &Input, title: &str) -> String {
        let mut text = Text::titled(&title);
        text.line("meshes", self.meshes.len());
        text.line("instances", input.model().instances.len());
        input.info_text(&mut text);
        for (index, mesh) in self.meshes.iter().enumerate() {
            let name = mesh.name.as_ref().map_or_else(String::new, |name| format!(" \"{name}\""));
            text.heading(format!("mesh {index}{name}, in its own space"));
            text.mesh(mesh);
        }
        if self.meshes.len() > 1 {
            text.heading("all meshes, each once");
            text.mesh(&self.total);
        }
        text.heading("all instances, at rest in world space");
        text.mesh(&self.placed);
        text.finish()
    }
}
