//! The counts and times that `query` prints.

use std::fmt::Write as _;
use std::path::Path;

use rimline::mesh::NO_FACE;
use rimline::{Mesh, Origin};
use serde_json::json;

use super::asked::Asked;
use crate::coordinates::{add_origin, origin_text};
use crate::extract::report::per_light;
use crate::shown::Line;
use crate::times::Times;

pub(super) struct Report {
    vertices: u32,
    faces: usize,
    points: usize,
    points_on_faces: usize,
    non_finite_points: usize,
    /// One a light.
    points_in_shadow: Vec<usize>,
    deepest: Vec<usize>,
    origin: Origin,
    adapter: String,
    times: Times,
}

impl Report {
    pub(super) fn new(
        mesh: &Mesh,
        asked: &Asked<'_>,
        depths: &[i32],
        origin: Origin,
        adapter: String,
        times: Times,
    ) -> Self {
        let lights = asked.lights.len();
        let points_on_faces = asked.on_face.map_or(0, |faces| faces.iter().filter(|&&face| face != NO_FACE).count());
        let (mut points_in_shadow, mut deepest) = (vec![0; lights], vec![0; lights]);
        let mut non_finite_points = 0;
        for point in depths.chunks(lights) {
            non_finite_points += usize::from(point[0] < 0);
            for ((in_shadow, deepest), &depth) in points_in_shadow.iter_mut().zip(&mut deepest).zip(point) {
                *in_shadow += usize::from(depth > 0);
                *deepest = usize::try_from(depth).map_or(*deepest, |depth| depth.max(*deepest));
            }
        }
        let points = depths.len() / lights;
        let (vertices, faces) = (mesh.vertex_count(), mesh.faces().len());
        Self {
            vertices,
            faces,
            points,
            points_on_faces,
            non_finite_points,
            points_in_shadow,
            deepest,
            origin,
            adapter,
            times,
        }
    }

    /// Keys are stable: they are only ever added to. Lists have an entry a light, in the order given.
    pub(super) fn json(&self) -> String {
        let [set_up, work] = self.times.set_up_and_work();
        let mut report = json!({
            "adapter": self.adapter,
            "vertices": self.vertices,
            "faces": self.faces,
            "points": self.points,
            "points_on_faces": self.points_on_faces,
            "non_finite_points": self.non_finite_points,
            "lights": self.deepest.len(),
            "points_in_shadow": self.points_in_shadow,
            "deepest": self.deepest,
            "milliseconds": self.times.json(),
            "set_up_milliseconds": set_up,
            "work_milliseconds": work,
        });
        add_origin(&mut report, self.origin);
        format!("{report:#}\n")
    }

    pub(super) fn text(&self, out: &Path) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<18} {value}");
        };
        line("device", &self.adapter);
        line("vertices", &self.vertices.to_string());
        line("faces", &self.faces.to_string());
        if let Some(origin) = origin_text(self.origin) {
            line("origin", &origin);
        }
        line("points", &self.points.to_string());
        if self.points_on_faces > 0 {
            line("", &format!("{} name their face", self.points_on_faces));
        }
        if self.non_finite_points > 0 {
            line("", &format!("{} not finite: their depth is -1", self.non_finite_points));
        }
        line("points in shadow", &per_light(&self.points_in_shadow));
        let deepest: Vec<String> = self.deepest.iter().take(8).map(usize::to_string).collect();
        let more = if self.deepest.len() > 8 { ", …" } else { "" };
        line("deepest", &format!("{}{more}", deepest.join(", ")));
        line("milliseconds", &self.times.sums());
        line("by stage", &self.times.text());
        let _ = writeln!(text, "wrote {}", Line(out.display()));
        text
    }
}
