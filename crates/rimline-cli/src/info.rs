//! `rimline info`: what a model holds, and whether it is closed.

mod report;
mod seams;

use std::fmt::{Display, Write as _};

use rimline::cpu::{Boundary, Orientation};
use rimline::gltf::{AnimationInfo, Asset, SceneLight, SceneLightKind, SkippedPrimitives};
use rimline::mesh::EdgeCounts;
use rimline::{Light, Mesh, Origin};
use rimline_files::Polygons;
use rimline_picture::Bounds;
use serde_json::{Map, Value, json};

use crate::args::InfoArgs;
use crate::coordinates::{self, add_origin, origin_text};
use crate::failure::Failure;
use crate::input::Input;
use crate::output::{Line, note, print};
use crate::report::Times;
use report::{INWARD, MeshReport, kind_name};
pub(crate) use seams::Seams;

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut options = args.model.read.options();
    if options.polygons == Polygons::Triangles {
        options.polygons = Polygons::Described;
    }
    let input = Input::at_rest(&args.model.file, &options)?;
    let lights = input.lights(&args.lights, 0.0)?;
    let report = Report::new(&input, &lights)?;
    if !lights.is_empty() && report.polygons.is_none() {
        note(&format!("warning: {}: --light has no effect, because all faces are triangles", input.file.display()));
    }
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
            .map_err(|error| Failure::input(&input.file, error))?;
        let total = MeshReport::total(&meshes);
        let shape = input.shape(0.0, false)?;
        if input.asset().is_some() && input.model().placed_geometries().all(|geometry| geometry.faces().is_empty()) {
            return Ok(Self { meshes, total, placed: MeshReport::default(), polygons: None });
        }
        let mesh = input.mesh(&shape)?;
        let positions = shape.on_cpu(&mut Times::default())?;
        let placed = MeshReport::of_mesh(&mesh, &positions, input.origin());
        let polygons = match input.described() {
            Some(given) => PolygonReport::of_mesh(&given.mesh, &given.positions, lights),
            None => PolygonReport::of_mesh(&mesh, &positions, lights),
        };
        Ok(Self { meshes, total, placed, polygons })
    }

    /// Keys may be added, but never change or go.
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
        if let Some(asset) = input.asset() {
            asset_json(asset, &asset_lights(asset, input)?, &mut value);
        }
        Ok(value)
    }

    fn text(&self, input: &Input) -> Result<String, Failure> {
        let mut text = Text(format!("{}\n", Line(input.file.display())));
        text.line("meshes", self.meshes.len());
        text.line("instances", input.model().instances().len());
        let what = "what other subcommands write is relative to it; the lines below are not";
        if let Some(origin) = origin_text(input.origin(), what) {
            text.line("origin", origin);
        }
        if let Some(asset) = input.asset() {
            asset_text(asset, &asset_lights(asset, input)?, &mut text);
        }
        for (index, mesh) in self.meshes.iter().enumerate() {
            text.mesh(format!("mesh {index}{}, in its own space", quoted(mesh.name.as_deref())), mesh);
        }
        if self.meshes.len() > 1 {
            text.mesh("all meshes, each once", &self.total);
        }
        text.mesh("all instances, at rest in world space", &self.placed);
        if let Some(polygons) = &self.polygons {
            polygons.text(&mut text, input.described().is_some());
        }
        Ok(text.0)
    }
}

struct Text(String);

impl Text {
    fn line(&mut self, name: &str, value: impl Display) {
        let _ = writeln!(self.0, "  {name:<13} {value}");
    }

    /// A line below the one before.
    fn more(&mut self, value: impl Display) {
        self.line("", value);
    }

    fn mesh(&mut self, title: impl Display, report: &MeshReport) {
        let _ = writeln!(self.0, "\n{title}");
        self.elements(report);
        self.closedness(report);
        self.listed_edges(report);
        for (index, advice) in report.advice().into_iter().enumerate() {
            self.line(if index == 0 { "to do" } else { "" }, advice);
        }
        if report.joints_per_vertex > 0 {
            self.line("skinned", format!("up to {} joints a vertex", report.joints_per_vertex));
        }
        if report.morph_targets > 0 {
            self.line("morph targets", report.morph_targets);
        }
        if let Some(Bounds { min, max }) = report.bounds {
            let [min, max] = [min, max].map(|corner| point(corner.into(), report.origin));
            self.line("bounds", format!("{min} to {max}"));
        }
    }

    /// How many vertices, faces, edges and parts.
    fn elements(&mut self, MeshReport { vertices: weld, faces, diagnostics, .. }: &MeshReport) {
        let mut vertices = weld.after.to_string();
        if weld.before != weld.after {
            let _ = write!(vertices, ", welded from {}", weld.before);
        }
        if weld.apart > 0 {
            let _ = write!(vertices, ", {} kept apart by their skin or morph data", weld.apart);
        }
        self.line("vertices", vertices);
        let copies = match diagnostics.flipped_faces {
            0 => "duplicate".to_owned(),
            flipped => format!("duplicate ({flipped} flipped, so that both sides are fronts)"),
        };
        let by_kind = [
            (diagnostics.degenerate_faces, "degenerate"),
            (weld.collapsed, "of them collapsed by welding"),
            (diagnostics.duplicate_faces, &copies),
        ];
        self.line("faces", counted(*faces, &by_kind));
        let EdgeCounts { consistent, inconsistent, boundary } = diagnostics.edges;
        let by_kind = [(consistent, "consistent"), (inconsistent, "inconsistent"), (boundary, "boundary")];
        let mut edges = counted(consistent + inconsistent + boundary, &by_kind);
        if diagnostics.non_manifold_edges > 0 {
            let _ = write!(edges, "; more than two faces at {} of them", diagnostics.non_manifold_edges);
        }
        self.line("edge records", edges);
        self.line("parts", diagnostics.components);
    }

    /// Whether the mesh is closed, and what seams are left open.
    fn closedness(&mut self, report: &MeshReport) {
        match report.why_open() {
            None if report.faces == 0 => self.line("closed", "nothing to close: no faces"),
            None if report.faces == report.diagnostics.degenerate_faces => {
                self.line("closed", "nothing to close: no face has an area");
            }
            None => self.line("closed", "yes"),
            Some(why) => self.line("closed", format!("no: {why}")),
        }
        let inward = report.diagnostics.inward_components.unwrap_or(0);
        if let Some(found) = INWARD.of(inward) {
            let whose = if inward == 1 { "its" } else { "their" };
            self.more(format!("{found}: {whose} faces are clockwise from outside"));
        }
        if let Some(seams) = &report.seams {
            self.more(seams.text());
        }
        if report.t_junctions > 0 {
            self.more(format!("{} T-junctions: vertices on boundary edges that end elsewhere", report.t_junctions));
        }
    }

    /// The first edges that are not consistent, and how many more there are.
    fn listed_edges(&mut self, MeshReport { diagnostics, listed_positions, origin, .. }: &MeshReport) {
        for (edge, positions) in diagnostics.listed_edges.iter().zip(listed_positions) {
            let [a, b] = positions.map(|position| point(position, *origin));
            let [va, vb] = edge.vertices;
            self.more(format!("  {} edge {va}-{vb}, {a} to {b}", kind_name(edge.kind)));
        }
        let listed = diagnostics.listed_edges.len();
        let all = diagnostics.edges.inconsistent + diagnostics.edges.boundary;
        if listed > 0 && all > listed {
            self.more(format!("  and {} more", all - listed));
        }
    }
}

/// `12: 10 of this, 2 of that`, what is zero left out.
fn counted(all: usize, parts: &[(usize, &str)]) -> String {
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}")).collect();
    if parts.is_empty() { all.to_string() } else { format!("{all}: {}", parts.join(", ")) }
}

fn point(point: [f32; 3], origin: Origin) -> String {
    format!("({})", coordinates::point(point, origin).to_string().replace(',', ", "))
}

/// A light at rest and its name. A damaged one has no more.
type NamedLight<'a> = (Option<&'a str>, Option<SceneLight>);

fn asset_lights<'a>(asset: &'a Asset, input: &Input) -> Result<Vec<NamedLight<'a>>, Failure> {
    let lights = asset.each_light(None, 0.0).map_err(|error| Failure::input(&input.file, error))?;
    Ok(asset.light_names().into_iter().zip(lights.into_iter().map(Result::ok)).collect())
}

fn asset_json(asset: &Asset, lights: &[NamedLight<'_>], value: &mut Value) {
    let skins = asset.skins().iter().map(|skin| json!({ "name": skin.name, "joints": skin.joints }));
    let animation = |info: &AnimationInfo| json!({ "name": info.name, "duration_seconds": info.duration_s, "channels": info.channels });
    let shown_lights = lights.iter().map(|(name, light)| {
        let kind = light.as_ref().map(|light| light_kind(light.kind));
        let xyzw = light.as_ref().map(|light| coordinates::light(&light.light, asset.origin()));
        json!({ "name": name, "kind": kind, "xyzw": xyzw })
    });
    let SkippedPrimitives { points, lines, without_position } = asset.skipped();
    value["skins"] = skins.collect();
    value["animations"] = asset.animations().iter().map(animation).collect();
    value["lights"] = shown_lights.collect();
    value["skipped_primitives"] = json!({ "points": points, "lines": lines, "without_position": without_position });
    value["hidden_nodes"] = asset.hidden_nodes().into();
    value["warnings"] = asset.warnings().iter().map(|warning| json!(warning.to_string())).collect();
}

fn asset_text(asset: &Asset, lights: &[NamedLight<'_>], text: &mut Text) {
    type Named<'a> = (Option<&'a str>, String);
    let list = |text: &mut Text, what: &str, all: Vec<Named<'_>>| {
        text.line(what, all.len());
        for (index, (name, line)) in all.into_iter().enumerate() {
            text.more(format!("  {index}{}, {line}", quoted(name)));
        }
    };
    let skins = asset.skins().iter();
    list(text, "skins", skins.map(|skin| (skin.name.as_deref(), format!("{} joints", skin.joints))).collect());
    let damaged = || "damaged".to_owned();
    let animations = asset.animations().iter().map(|info| {
        (info.name.as_deref(), if info.fault.is_some() { damaged() } else { format!("{} s", info.duration_s) })
    });
    list(text, "animations", animations.collect());
    let lights = lights.iter().map(|(name, light)| {
        let Some(light) = light else { return (*name, damaged()) };
        let is_far = light.kind == SceneLightKind::Directional;
        let at = if is_far { "towards" } else { "at" };
        let position = point(light.light.xyz, if is_far { Origin::ZERO } else { asset.origin() });
        (*name, format!("{}, {at} {position}", light_kind(light.kind)))
    });
    list(text, "lights", lights.collect());
    if asset.hidden_nodes() > 0 {
        text.line("hidden", format!("{} nodes, and what is on them", asset.hidden_nodes()));
    }
    let SkippedPrimitives { points, lines, without_position } = asset.skipped();
    if (points, lines, without_position) != (0, 0, 0) {
        text.line("skipped", format!("{points} point, {lines} line primitives, {without_position} without positions"));
    }
}

/// A name, if there is one, behind what it names.
fn quoted(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" \"{}\"", Line(name)))
}

fn light_kind(kind: SceneLightKind) -> &'static str {
    match kind {
        SceneLightKind::Directional => "directional",
        SceneLightKind::Point => "point",
        SceneLightKind::Spot => "spot",
        _ => "other",
    }
}

#[derive(Debug, Default)]
struct PolygonReport {
    triangles: usize,
    quadrilaterals: usize,
    larger: usize,
    most_corners: usize,
    with_holes: usize,
    nonplanar: usize,
    /// With a corner that is not finite. They are in no other count of how polygons are seen.
    non_finite: usize,
    /// For each light, how many are seen in each way of `SEEN`.
    seen: Vec<[usize; 4]>,
}

/// How a polygon is seen from a light: the key of JSON, and words.
const SEEN: [(Orientation, &str, &str); 4] = [
    (Orientation::FrontFacing, "facing", "facing"),
    (Orientation::BackFacing, "back_facing", "back-facing"),
    (Orientation::InPlane, "in_plane", "in a plane with it"),
    (Orientation::Twisted, "twisted", "twisted"),
];

impl PolygonReport {
    /// `None` if all faces are triangles.
    fn of_mesh(mesh: &Mesh, positions: &[[f32; 3]], lights: &[Light]) -> Option<Self> {
        let polygons = mesh.polygons()?;
        let mut report = Self { seen: vec![[0; 4]; lights.len()], ..Self::default() };
        for polygon in 0..polygons.len() {
            let loops = polygons.loops(polygon);
            report.with_holes += usize::from(loops.len() > 1);
            let corners = loops.map(<[u32]>::len).sum::<usize>();
            report.most_corners = report.most_corners.max(corners);
            *match corners {
                ..=3 => &mut report.triangles,
                4 => &mut report.quadrilaterals,
                _ => &mut report.larger,
            } += 1;
            let Some(boundary) = Boundary::new(polygons.boundary(polygon), positions) else {
                report.non_finite += 1;
                continue;
            };
            report.nonplanar += usize::from(!boundary.is_planar());
            for (counts, light) in report.seen.iter_mut().zip(lights) {
                let found = boundary.orientation(*light);
                counts.iter_mut().zip(SEEN).for_each(|(count, (way, ..))| *count += usize::from(found == way));
            }
        }
        Some(report)
    }

    fn json(&self) -> Value {
        let seen = |counts: &[usize; 4]| -> Map<String, Value> {
            SEEN.iter().zip(counts).map(|((_, key, _), count)| ((*key).to_owned(), json!(count))).collect()
        };
        json!({
            "triangles": self.triangles,
            "quadrilaterals": self.quadrilaterals,
            "larger": self.larger,
            "most_corners": self.most_corners,
            "with_holes": self.with_holes,
            "nonplanar": self.nonplanar,
            "non_finite": self.non_finite,
            "seen": self.seen.iter().map(seen).collect::<Vec<_>>(),
        })
    }

    /// `are_cut`: the faces are their triangles.
    fn text(&self, text: &mut Text, are_cut: bool) {
        let Self { triangles, quadrilaterals, larger, most_corners, with_holes, nonplanar, non_finite, .. } = self;
        let up_to = if *larger > 0 { format!(", {larger} of up to {most_corners}") } else { String::new() };
        text.line("polygons", format_args!("{triangles} of 3 corners, {quadrilaterals} of 4{up_to}"));
        text.more(format_args!("{nonplanar} not planar, {with_holes} with holes"));
        if are_cut {
            text.more("cut into the triangles above; --polygons takes each as one face");
        }
        if *non_finite > 0 {
            text.more(format_args!("{non_finite} with a corner that is not finite"));
        }
        for (number, counts) in self.seen.iter().enumerate() {
            let ways = SEEN.iter().zip(counts).map(|((.., words), count)| format!("{count} {words}"));
            text.line(&format!("light {number}"), ways.collect::<Vec<_>>().join(", "));
        }
    }
}
