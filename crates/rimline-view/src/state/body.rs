//! Models that are shown.

use std::collections::HashMap;
use std::fmt::{self, Debug, Formatter};

use rimline::cpu::{Threads, deform};
use rimline::gltf::{Asset, Colors, GltfError, SceneCamera, SceneLight};
use rimline::internals::clusters::{CLUSTER_FACES, Clusters};
use rimline::mesh::{Edge, EdgeKind, MeshDiagnostics};
use rimline::{Mesh, MeshError, Model, ModelError, Pose};
use rimline_files::{File, FileError};
use rimline_picture::Bounds;

/// The largest coordinate of models, so that cameras are finite a thousand sizes away.
const FARTHEST: f32 = 1e34;

/// Why a model cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// The file, or an animation of it, is damaged or not supported.
    #[error(transparent)]
    Gltf(#[from] GltfError),
    /// The pose does not fit the model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Faces make no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// There is nothing to look at.
    #[error("it has no faces with finite corners")]
    NoFaces,
    /// Cameras and lights around it would not be finite.
    #[error("it has corners beyond 1e34, which is too far to be shown; scale it down")]
    TooFar,
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Data that a model is posed from. A reader of files implements it.
pub trait Source: Send {
    /// The model.
    fn model(&self) -> &Model;

    /// The state of the model at a time of one of its animations, or at rest.
    ///
    /// # Errors
    /// [`BodyError`] if the animation is damaged.
    fn pose(&self, animation: Option<usize>, seconds: f32) -> Result<Pose, BodyError>;

    /// Names and durations of animations, in seconds.
    fn animations(&self) -> Vec<(String, f32)> {
        Vec::new()
    }

    /// Lights of the file, at rest, without damaged ones.
    fn lights(&self) -> Vec<SceneLight> {
        Vec::new()
    }

    /// Cameras of the file, at rest, without damaged ones.
    fn cameras(&self) -> Vec<SceneCamera> {
        Vec::new()
    }

    /// Base colours of one of the model's geometries. `None`: all is white.
    fn colors(&self, _geometry: usize) -> Option<&Colors> {
        None
    }
}

impl Source for Asset {
    fn model(&self) -> &Model {
        self.model()
    }

    fn pose(&self, animation: Option<usize>, seconds: f32) -> Result<Pose, BodyError> {
        Ok(self.pose(animation, seconds)?)
    }

    fn animations(&self) -> Vec<(String, f32)> {
        let name = |(number, info): (usize, &rimline::gltf::AnimationInfo)| {
            (info.name.as_deref().map_or_else(|| format!("animation {number}"), short), info.duration_s)
        };
        self.animations().iter().enumerate().map(name).collect()
    }

    fn lights(&self) -> Vec<SceneLight> {
        self.each_light(None, 0.0).into_iter().flatten().flatten().collect()
    }

    fn cameras(&self) -> Vec<SceneCamera> {
        self.each_camera(None, 0.0).into_iter().flatten().flatten().collect()
    }

    fn colors(&self, geometry: usize) -> Option<&Colors> {
        self.colors(geometry)
    }
}

/// A file of any format.
impl Source for File {
    fn model(&self) -> &Model {
        self.model()
    }

    fn pose(&self, animation: Option<usize>, seconds: f32) -> Result<Pose, BodyError> {
        Ok(self.pose(animation.as_slice(), seconds)?)
    }

    fn animations(&self) -> Vec<(String, f32)> {
        self.asset().map_or_else(Vec::new, Source::animations)
    }

    fn lights(&self) -> Vec<SceneLight> {
        self.asset().map_or_else(Vec::new, Source::lights)
    }

    fn cameras(&self) -> Vec<SceneCamera> {
        self.asset().map_or_else(Vec::new, Source::cameras)
    }

    fn colors(&self, geometry: usize) -> Option<&Colors> {
        self.colors(geometry)
    }
}

/// A model in one pose.
impl Source for (Model, Pose) {
    fn model(&self) -> &Model {
        &self.0
    }

    fn pose(&self, _: Option<usize>, _: f32) -> Result<Pose, BodyError> {
        Ok(self.1.clone())
    }
}

/// A model that is shown, and what was found out about it when it was opened.
pub struct Body {
    /// The name that it is listed by.
    pub name: String,
    /// The name that the command gives it: a file, or nothing for a model of the viewer's own.
    pub file: Option<String>,
    /// The animation that plays. [`Viewer::play`](crate::Viewer::play) changes it, so that renderers notice.
    pub animation: Option<usize>,
    source: Box<dyn Source>,
    animations: Vec<(String, f32)>,
    cameras: Vec<SceneCamera>,
    report: Report,
    bounds: Bounds,
}

impl Debug for Body {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("Body").field("name", &self.name).field("report", &self.report).finish_non_exhaustive()
    }
}

/// Facts about the mesh of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Triangles of all instances.
    pub faces: usize,
    /// Vertices of all instances, as they are welded.
    pub vertices: usize,
    /// Edge records.
    pub edges: usize,
    /// Edges of one face.
    pub boundary: usize,
    /// Edges of more than two faces.
    pub non_manifold: usize,
    /// Edges of two faces that run opposite ways.
    pub inconsistent: usize,
}

impl Report {
    /// Advice about edges that have other than two faces which agree. `None`: there are none.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            Self { boundary: 0, inconsistent: 0, non_manifold: 0, .. } => None,
            Self { boundary: 0, inconsistent: 0, .. } => {
                Some("Shadows are right, also where several parts share an edge. Nothing is to be done.")
            }
            Self { boundary: 0, .. } => {
                Some("Faces disagree about which side is out. Shadows are right; turn them in a modeller for outlines.")
            }
            _ => Some(
                "Shadows are right, also of open surfaces. If edges are seams of split vertices, `rimline view --weld position` \
                 joins them.",
            ),
        }
    }
}

impl Body {
    /// Examines a model. `file` is what the command calls it.
    ///
    /// # Errors
    /// [`BodyError`] if nothing of it can be shown.
    pub fn new(name: &str, file: Option<String>, source: impl Source + 'static) -> Result<Self, BodyError> {
        let animations = source.animations();
        // The first animation that plays; a file may have damaged ones.
        let animation = (0..animations.len()).find(|&index| source.pose(Some(index), 0.0).is_ok());
        let pose = source.pose(animation, 0.0)?;
        let mesh = source.model().mesh(&pose)?;
        let world = deform(source.model(), &pose, 0.0, None, Threads::new(1))?;
        let used = mesh.faces().iter().flatten().filter_map(|&vertex| world.get(vertex as usize).copied());
        let bounds = Bounds::of(used).ok_or(BodyError::NoFaces)?;
        if bounds.min.min_element() < -FARTHEST || bounds.max.max_element() > FARTHEST {
            return Err(BodyError::TooFar);
        }
        let found = MeshDiagnostics::of(&mesh, 0);
        let report = Report {
            faces: mesh.faces().len(),
            vertices: mesh.vertex_count() as usize,
            edges: mesh.edges().len(),
            boundary: found.edges.boundary,
            non_manifold: found.non_manifold_edges,
            inconsistent: found.edges.inconsistent,
        };
        let cameras = source.cameras();
        Ok(Self {
            name: name.to_owned(),
            file,
            animation,
            source: Box::new(source),
            animations,
            cameras,
            report,
            bounds,
        })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        self.source.model()
    }

    /// The pose at a time of the animation that plays.
    ///
    /// # Errors
    /// [`BodyError`] if the animation is damaged.
    pub fn pose(&self, seconds: f32) -> Result<Pose, BodyError> {
        self.source.pose(self.animation, seconds)
    }

    /// Whether an animation is not damaged at its start.
    pub(super) fn plays(&self, animation: usize) -> bool {
        self.source.pose(Some(animation), 0.0).is_ok()
    }

    /// Names and durations of animations.
    pub fn animations(&self) -> &[(String, f32)] {
        &self.animations
    }

    /// The duration of the animation that plays, in seconds. 0: none does, or it has one key.
    pub fn duration(&self) -> f32 {
        self.animation.and_then(|index| self.animations.get(index)).map_or(0.0, |(_, duration)| *duration)
    }

    /// Lights of the file.
    pub fn lights(&self) -> Vec<SceneLight> {
        self.source.lights()
    }

    /// Cameras of the file.
    pub fn cameras(&self) -> &[SceneCamera] {
        &self.cameras
    }

    /// Base colours of one of the model's geometries. `None`: all is white.
    pub fn colors(&self, geometry: usize) -> Option<&Colors> {
        self.source.colors(geometry)
    }

    /// Facts about the mesh as it was opened: at the start of the first animation that is not damaged.
    pub fn report(&self) -> Report {
        self.report
    }

    /// The box of the model as it was opened: at the start of the first animation that is not damaged. It does not follow the
    /// animation that plays.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The positions of all vertices in world space at a time, computed without a device.
    ///
    /// # Errors
    /// [`BodyError`] if the animation is damaged.
    pub fn positions(&self, seconds: f32) -> Result<Vec<[f32; 3]>, BodyError> {
        Ok(deform(self.model(), &self.pose(seconds)?, seconds, None, Threads::new(1))?)
    }
}

/// A name in a file as a list shows it: in one line, since names may have any length and characters.
pub(crate) fn short(name: &str) -> String {
    const LONGEST: usize = 60;
    let mut short: String = name.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if name.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}

/// A bit for each edge record, in words, for edges of more than two faces and of faces that run opposite ways.
pub(crate) fn non_manifold_bits(mesh: &Mesh) -> Vec<u32> {
    let undirected = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut records: HashMap<[u32; 2], u32> = HashMap::new();
    for &vertices in mesh.edges().vertices() {
        *records.entry(undirected(vertices)).or_default() += 1;
    }
    let is_shared = |edge: &Edge| records.get(&undirected(edge.vertices)).is_some_and(|&count| count > 1);
    edge_bits(mesh, |edge| is_shared(edge) || edge.kind == EdgeKind::Inconsistent)
}

/// A bit for each edge record, in words, for edges of these faces.
pub(crate) fn bits_of_faces(mesh: &Mesh, faces: &[bool]) -> Vec<u32> {
    let is_of = |face: u32| faces.get(face as usize).is_some_and(|&is_marked| is_marked);
    edge_bits(mesh, |edge| is_of(edge.face_0) || edge.face_1.is_some_and(is_of))
}

/// A bit for each edge record, in words, for edges between faces of two clusters: those of the mesh at these positions.
pub(crate) fn bits_of_clusters(mesh: &Mesh, positions: &[[f32; 3]]) -> Vec<u32> {
    let clusters = Clusters::new(mesh, positions, Threads::new(1));
    let mut of_faces = vec![0; mesh.faces().len()];
    for (slot, &face) in clusters.faces().iter().enumerate() {
        of_faces[face as usize] = slot / CLUSTER_FACES;
    }
    edge_bits(mesh, |edge| edge.face_1.is_some_and(|other| of_faces[other as usize] != of_faces[edge.face_0 as usize]))
}

/// A bit for each edge record, in words.
fn edge_bits(mesh: &Mesh, is_marked: impl Fn(&Edge) -> bool) -> Vec<u32> {
    let mut bits = vec![0_u32; mesh.edges().len().div_ceil(32).max(1)];
    for (number, edge) in mesh.edges().iter().enumerate() {
        bits[number / 32] |= u32::from(is_marked(&edge)) << (number % 32);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_edge_has_its_advice() {
        let advice = |boundary, non_manifold, inconsistent| {
            Report { boundary, non_manifold, inconsistent, ..Report::default() }.advice().unwrap_or_default()
        };
        assert_eq!(advice(0, 0, 0), "");
        assert!(advice(0, 1, 0).contains("share an edge"));
        assert!(advice(0, 1, 1).contains("which side is out"));
        assert!(advice(1, 1, 1).contains("--weld position"));
    }

    #[test]
    fn names_of_files_are_short_lines() {
        assert_eq!(short("walk\nand run"), "walk and run");
        assert_eq!(short(&"é".repeat(60)), "é".repeat(60));
        assert_eq!(short(&"é".repeat(1 << 20)), "é".repeat(60) + "…");
    }

    #[test]
    fn edges_of_three_faces_are_marked() {
        let faces = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let mesh = Mesh::from_faces(5, faces).expect("three sheets");
        let bits = non_manifold_bits(&mesh);
        let marked: Vec<_> =
            mesh.edges().iter().enumerate().filter(|(n, _)| bits[n / 32] >> (n % 32) & 1 != 0).collect();
        assert_eq!(marked.len(), 2);
        assert!(marked.iter().all(|(_, edge)| edge.vertices.iter().all(|&v| v < 2)));
    }
}
