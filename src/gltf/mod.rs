//! Loads glTF 2.0 files: triangles, skins, morph targets, animations, instances, punctual lights.
//!
//! This is what is read, in the order of the glTF 2.0 specification, and what is decided where it leaves a choice:
//!
//! * **Scene.** All nodes of the default scene are loaded, or of the first scene if none is marked as default. A file
//!   without scenes gives all nodes, and then the meshes that no node names, without a transform. Every mesh, skin and
//!   animation of the file is read and checked, whatever the scene holds.
//! * **Primitives.** All triangle primitives of a mesh make one [`Geometry`](crate::Geometry). Points, lines, and
//!   primitives without positions are skipped and counted, see [`Asset::skipped`]. So a file may have no faces at all.
//! * **Joints.** A vertex follows the joints whose weight is not zero. Weights are scaled to the sum 1. If all are
//!   zero, the vertex follows the first joint listed. A joint of weight zero may have any index. A mesh that is used
//!   both with and without a skin gives two geometries.
//! * **Matrices.** The last row of a matrix may differ from (0, 0, 0, 1) by 10⁻⁵, and is then taken as that. Rotations
//!   are scaled to length 1.
//! * **Animations.** If several channels of an animation move the same property, the last one applies. Channels are
//!   ignored with a warning if they have no target node or an unknown path, or move the morph weights of a node without
//!   morph targets.
//! * **Accessors.** A quantised attribute is accepted if the file says that it uses `KHR_mesh_quantization`. Draco and
//!   meshopt data are never read; a file is refused where the plain data beside them is missing. Alignment is not
//!   checked.
//! * **Files.** Buffers are read from data URIs, and from regular files in the folder of the glTF or below it. A file
//!   outside, reached by a symbolic link or `..`, is refused unless [`LoadOptions::allow_outside`] is set. Images are
//!   never read.
//! * **Memory.** Memory is charged against [`LoadOptions::memory_limit`] before it is allocated.

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

pub use error::{AccessorProblem, AnimationError, GltfError};
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

/// A glTF file that is loaded: its model, and the data for its poses and lights.
///
/// The memory of loading, of the model's mesh and of its poses has a bound: see [`LoadOptions::memory_limit`].
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
    /// The document without buffers, views and accessors, which are no longer needed.
    document: Document,
    graph: Graph,
    skins: Vec<LoadedSkin>,
    animations: Vec<LoadedAnimation>,
    animation_infos: Vec<AnimationInfo>,
    skin_infos: Vec<SkinInfo>,
    mesh_infos: Vec<MeshInfo>,
    skipped: SkippedPrimitives,
    built: Built,
    /// The joints that each geometry uses, ascending.
    used_joints: Vec<Vec<u32>>,
    named_files: Vec<PathBuf>,
}

/// An animation of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The time of the last key, in seconds. The animation starts at 0.
    pub duration_s: f32,
    /// The number of channels that move something.
    pub channels: usize,
}

/// A skin of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The number of joints.
    pub joints: usize,
}

/// A mesh of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The number of primitives, including skipped ones.
    pub primitives: usize,
    /// The number of morph targets of each primitive.
    pub morph_targets: usize,
    /// Indices into [`Model::geometries`]: one, or two (skinned and rigid) if nodes use the mesh both ways.
    pub geometries: Vec<usize>,
}

/// The number of primitives that were not loaded. Each counts once for its mesh, not for each instance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkippedPrimitives {
    /// Point primitives.
    pub points: usize,
    /// Line, line loop and line strip primitives.
    pub lines: usize,
    /// Triangle primitives without a POSITION attribute.
    pub without_position: usize,
}

/// The kind of a light in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SceneLightKind {
    /// A light at infinity.
    Directional,
    /// A light at a point that shines to all sides.
    Point,
    /// A light at a point that shines in a cone.
    Spot,
}

/// A light of the file at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// The name of the light, or that of its node.
    pub name: Option<String>,
    /// The light in world space, without a range. A point or spot light has the node's position and w = 1. A
    /// directional light has the node's +Z at length 1 and w = 0: it shines along −Z, and [`Light`] points towards the
    /// light.
    pub light: Light,
    /// The kind of the light.
    pub kind: SceneLightKind,
    /// Red, green and blue, linear.
    pub color: [f32; 3],
    /// In candela for a point or spot light, in lux for a directional one.
    pub intensity: f32,
    /// The distance where a point or spot light ends, in the unit of the file. Nodes do not scale it. `None`: it does
    /// not end.
    pub range: Option<f32>,
    /// The cone of a spot light. `None` for other lights, and for a node without extent along Z.
    pub cone: Option<SpotCone>,
}

/// The cone of a spot light. It shines fully within the inner angle and not at all beyond the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotCone {
    /// The direction in which it shines, in world space, at length 1: the node's −Z.
    pub direction: [f32; 3],
    /// The angle from the direction to where the light begins to fade, in radians.
    pub inner_angle: f32,
    /// The angle from the direction to where the light has faded, in radians. It is at least the inner angle.
    pub outer_angle: f32,
}

impl Asset {
    /// Loads a .gltf or .glb file; its content tells which. Buffers that it names are looked for in its folder. A
    /// [`Weld`](crate::mesh::Weld) can be given as options; the other options are then the defaults.
    ///
    /// # Errors
    /// [`GltfError`] if a file cannot be read, its content is damaged or not supported, or it takes more memory than
    /// the options allow.
    pub fn open(path: impl AsRef<Path>, options: impl Into<LoadOptions>) -> Result<Self, GltfError> {
        let (path, options) = (path.as_ref(), options.into());
        let budget = Budget::new(options.memory_limit);
        let bytes = files::read(path, u64::MAX, &budget)?;
        Self::load(&bytes, path.parent(), options, &budget)
    }

    /// Loads the content of a .gltf or .glb file. Buffers that it names are looked for in `base_dir`.
    ///
    /// # Errors
    /// [`GltfError`] if the content is damaged or not supported, names files and there is no `base_dir`, or takes more
    /// memory than the options allow.
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
        let skipped = SkippedPrimitives::count(&document);
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

    /// The files that the glTF names by relative URIs, whether they were read or not: buffers, textures, files of
    /// extensions. They need not exist. The list is empty without a folder to look in.
    pub fn named_files(&self) -> &[PathBuf] {
        &self.named_files
    }

    /// The model: the geometries of every mesh and the instances of the chosen scene. Only geometries with faces have
    /// instances.
    pub fn model(&self) -> &Model {
        &self.built.model
    }

    /// What welding did to the geometry with this index, or `None` past the end.
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

    /// The index of the first animation with this name. If there is none, the name is read as an index.
    pub fn animation_index(&self, name_or_index: &str) -> Option<usize> {
        let named = |info: &AnimationInfo| info.name.as_deref() == Some(name_or_index);
        let number = || name_or_index.parse().ok().filter(|&index| index < self.animation_infos.len());
        self.animation_infos.iter().position(named).or_else(number)
    }

    /// The primitives that were not loaded.
    pub fn skipped(&self) -> SkippedPrimitives {
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

impl SkippedPrimitives {
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
