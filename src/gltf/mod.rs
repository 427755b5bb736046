//! Loading of glTF 2.0 files: triangles, skins, morph targets, animations, instances, punctual lights.
//!
//! What is read, by the sections of the glTF 2.0 specification, and what is decided where it leaves a choice:
//!
//! * All nodes of the default scene (none marked: the first; no scenes: all nodes, then the meshes that no node names,
//!   untransformed). Whatever the scene holds, every mesh, skin and animation of the file is read and checked.
//! * All triangle primitives of a mesh make one [`Geometry`](crate::Geometry); points and lines are skipped and
//!   counted, and so are primitives without positions: see [`Asset::skipped`]. A file may so have no faces at all.
//! * A vertex follows the joints of non-zero weight; weights are brought to the sum 1, and where all are zero the vertex
//!   follows the first joint listed. A joint of zero weight may be any number. A mesh used both with and without a
//!   skin gives two geometries.
//! * A matrix's last row may differ from (0, 0, 0, 1) by 10⁻⁵ and is then taken as that. Rotations are brought to
//!   length 1.
//! * Of several channels that move the same property in an animation, the last one holds. Channels without a target
//!   node, with an unknown path, or for morph weights of a node without morph targets are ignored with a warning.
//! * A quantised attribute is accepted where the file says that it uses `KHR_mesh_quantization`. Draco and meshopt data
//!   are never read: a file is refused where the plain data beside them is missing. Alignment of accessors is not
//!   asked for.
//! * Buffers are read from data URIs and from regular files in the glTF's folder or below it, nothing else. A file that
//!   a symbolic link or `..` leads to outside of it is refused, unless [`LoadOptions::allow_outside`] lets it in. Images
//!   are never read, wherever they are.
//! * Memory is charged against [`LoadOptions::memory_limit`] before it is taken.

mod animation;
mod budget;
mod buffers;
mod container;
mod curve;
mod document;
mod error;
mod extensions;
mod files;
mod formats;
mod geometry;
mod graph;
mod instances;
mod json;
mod lengths;
mod named_files;
mod options;
mod parse;
mod parse_mesh;
mod parse_scene;
mod placement;
mod pose;
mod reader;
mod skin;
mod transforms;
mod triangles;
mod vertices;

use std::path::{Path, PathBuf};

use gltf::json::Value;
use gltf::json::mesh::Mode;

pub use error::{AccessorProblem, GltfError, PoseError};
pub use options::LoadOptions;

use crate::light::Light;
use crate::mesh::WeldCounts;
use crate::model::Model;
use animation::LoadedAnimation;
use budget::Budget;
use document::Document;
use files::Folder;
use graph::Graph;
use instances::Built;
use reader::Reader;
use skin::LoadedSkin;

/// A glTF file, loaded: its model, and what poses it.
///
/// What the loading, the model's mesh and its poses take of memory is bounded: see [`LoadOptions::memory_limit`].
///
/// ```no_run
/// use rimline::gltf::Asset;
/// use rimline::mesh::Weld;
///
/// let asset = Asset::open("fox.glb", Weld::Data)?;
/// let pose = asset.pose(asset.animation_index("Run"), 0.5)?;
/// let mesh = asset.model().mesh(&pose)?;
/// println!("{} edge records, closed: {}", mesh.edges().len(), mesh.is_closed());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Asset {
    /// Without buffers, views and accessors, which are no longer needed.
    document: Document,
    graph: Graph,
    skins: Vec<LoadedSkin>,
    animations: Vec<LoadedAnimation>,
    animation_infos: Vec<AnimationInfo>,
    skin_infos: Vec<SkinInfo>,
    mesh_infos: Vec<MeshInfo>,
    skipped: Skipped,
    built: Built,
    /// Of each geometry, ascending.
    used_joints: Vec<Vec<u32>>,
    named_files: Vec<PathBuf>,
}

/// An animation of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationInfo {
    /// Its name.
    pub name: Option<String>,
    /// The time of its last key, in seconds; it starts at 0.
    pub duration_s: f32,
    /// Channels that move something.
    pub channels: usize,
}

/// A skin of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinInfo {
    /// Its name.
    pub name: Option<String>,
    /// Joints it has.
    pub joints: usize,
}

/// A mesh of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshInfo {
    /// Its name.
    pub name: Option<String>,
    /// Its primitives, skipped ones too.
    pub primitives: usize,
    /// Morph targets of each.
    pub morph_targets: usize,
    /// Indices into [`Model::geometries`]: one; or two, skinned and rigid, where nodes use it both ways.
    pub geometries: Vec<usize>,
}

/// Primitives that were not loaded, counted once a mesh, not once an instance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Point primitives.
    pub points: usize,
    /// Line, line loop and line strip primitives.
    pub lines: usize,
    /// Triangle primitives without a POSITION attribute, which leave nothing to draw.
    pub without_position: usize,
}

/// What a light in the file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SceneLightKind {
    /// At infinity.
    Directional,
    /// At a point, to all sides.
    Point,
    /// At a point, in a cone.
    Spot,
}

/// A light of the file at some time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// The light's name, or its node's.
    pub name: Option<String>,
    /// World space. Point and spot: the node's position, w = 1. Directional: the node's +Z at length 1, w = 0, for it
    /// shines along −Z and [`Light`] points towards the light.
    pub light: Light,
    /// What it is.
    pub kind: SceneLightKind,
    /// Red, green and blue, linear.
    pub color: [f32; 3],
    /// Candela of a point or spot light, lux of a directional one.
    pub intensity: f32,
    /// The distance at which a point or spot light's light ends, in the file's unit, scaled by no node; `None`: nowhere.
    pub range: Option<f32>,
    /// A spot light's cone.
    pub cone: Option<SpotCone>,
}

/// Where a spot light shines: all of it within the inner angle, none beyond the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotCone {
    /// The way it shines, in world space, at length 1: the node's −Z.
    pub direction: [f32; 3],
    /// From the direction to where the light begins to fade, in radians.
    pub inner_angle: f32,
    /// From the direction to where it has faded, in radians; at least the inner angle.
    pub outer_angle: f32,
}

impl Asset {
    /// Loads a .gltf or .glb file, told apart by content. Buffers named in it are looked for in its folder. A
    /// [`Weld`](crate::mesh::Weld) serves as options: the others are then the default ones.
    ///
    /// # Errors
    /// [`GltfError`] for a file that cannot be read, whose content is damaged or not supported, or that takes more
    /// memory than the options allow.
    pub fn open(path: impl AsRef<Path>, options: impl Into<LoadOptions>) -> Result<Self, GltfError> {
        let (path, options) = (path.as_ref(), options.into());
        let budget = Budget::new(options.memory_limit);
        let bytes = files::read(path, u64::MAX, &budget)?;
        Self::load(&bytes, path.parent(), options, &budget)
    }

    /// Loads a .gltf or .glb file's content. Buffers named in it are looked for in `base_dir`.
    ///
    /// # Errors
    /// [`GltfError`] for content that is damaged or not supported, that names files where there is no `base_dir`, or
    /// that takes more memory than the options allow.
    pub fn from_slice(
        bytes: &[u8],
        base_dir: Option<&Path>,
        options: impl Into<LoadOptions>,
    ) -> Result<Self, GltfError> {
        let options = options.into();
        Self::load(bytes, base_dir, options, &Budget::new(options.memory_limit))
    }

    fn load(bytes: &[u8], base: Option<&Path>, options: LoadOptions, budget: &Budget) -> Result<Self, GltfError> {
        let (json, binary) = container::split(bytes)?;
        // A byte order mark is not allowed, but harmless.
        let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
        budget.charge_json(json)?;
        let value: Value = gltf::json::deserialize::from_slice(json).map_err(GltfError::Json)?;
        let mut document = parse::document(&value, budget)?;
        let named_files = named_files::find(&value, base);
        drop(value);
        let graph = Graph::new(&document)?;
        let folder = Folder { path: base, allow_outside: options.allow_outside };
        let buffers = buffers::load(&document, binary, folder, budget)?;
        let reader = Reader::new(&document, &buffers, budget);
        let skins = skin::load(&reader)?;
        let built = instances::build(&reader, &graph, &skins, options.weld)?;
        instances::Draft::charge_lights(&reader, &graph)?;
        let (animations, animation_infos) = animation::load(&reader)?;
        let skipped = Skipped::count(&document);
        skipped.warn();
        document.buffers = Vec::new();
        document.views = Vec::new();
        document.accessors = Vec::new();
        Ok(Self {
            skin_infos: skin_infos(&document),
            mesh_infos: mesh_infos(&document, &built),
            used_joints: built.model.geometries().iter().map(pose::used_joints).collect(),
            document,
            graph,
            skins,
            animations,
            animation_infos,
            skipped,
            built,
            named_files,
        })
    }

    /// The files that the glTF names by relative URIs, whether they were read or not: buffers, textures, what extensions
    /// name. They need not exist. Empty without a folder to look in.
    pub fn named_files(&self) -> &[PathBuf] {
        &self.named_files
    }

    /// Geometry of every mesh, instances of the chosen scene. Only geometries with faces have instances.
    pub fn model(&self) -> &Model {
        &self.built.model
    }

    /// What welding did to a geometry; `None` past the end.
    pub fn weld_counts(&self, geometry: usize) -> Option<WeldCounts> {
        self.built.weld_counts.get(geometry).copied()
    }

    /// The file's meshes, in its order.
    pub fn meshes(&self) -> &[MeshInfo] {
        &self.mesh_infos
    }

    /// The file's skins, in its order.
    pub fn skins(&self) -> &[SkinInfo] {
        &self.skin_infos
    }

    /// The file's animations, in its order.
    pub fn animations(&self) -> &[AnimationInfo] {
        &self.animation_infos
    }

    /// The first animation of this name, else the one of this number.
    pub fn animation_index(&self, name_or_index: &str) -> Option<usize> {
        let named = |info: &AnimationInfo| info.name.as_deref() == Some(name_or_index);
        let number = || name_or_index.parse().ok().filter(|&index| index < self.animation_infos.len());
        self.animation_infos.iter().position(named).or_else(number)
    }

    /// What was left out on loading.
    pub fn skipped(&self) -> Skipped {
        self.skipped
    }
}

fn skin_infos(document: &Document) -> Vec<SkinInfo> {
    let info = |skin: &document::Skin| SkinInfo { name: skin.name.clone(), joints: skin.joints.len() };
    document.skins.iter().map(info).collect()
}

fn mesh_infos(document: &Document, built: &Built) -> Vec<MeshInfo> {
    let info = |mesh: &document::Mesh| MeshInfo {
        name: mesh.name.clone(),
        primitives: mesh.primitives.len(),
        morph_targets: mesh.targets,
        geometries: Vec::new(),
    };
    let mut infos: Vec<MeshInfo> = document.meshes.iter().map(info).collect();
    for (geometry, &mesh) in built.meshes.iter().enumerate() {
        infos[mesh].geometries.push(geometry);
    }
    infos
}

impl Skipped {
    fn count(document: &Document) -> Self {
        let mut skipped = Self::default();
        for primitive in document.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            match primitive.mode {
                Mode::Points => skipped.points += 1,
                Mode::Lines | Mode::LineLoop | Mode::LineStrip => skipped.lines += 1,
                _ if primitive.position.is_none() => skipped.without_position += 1,
                _ => {}
            }
        }
        skipped
    }

    fn warn(self) {
        if self != Self::default() {
            let Self { points, lines, without_position } = self;
            log::warn!(
                "skipped {points} point primitives, {lines} line primitives and {without_position} primitives \
                 without positions"
            );
        }
    }
}
