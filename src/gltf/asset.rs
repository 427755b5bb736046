//! A loaded file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use serde_json::Value;

use super::animation::{self, LoadedAnimation};
use super::budget::Budget;
use super::colors::Colors;
use super::document::{Document, Mesh, Mode, Named, Part, Skin};
use super::error::GltfError;
use super::files::{self, Beside, Bytes, Folder};
use super::graph::Graph;
use super::info::{AnimationInfo, LoadOptions, MeshInfo, SkinInfo, SkippedPrimitives};
use super::instances::{self, Built};
use super::reader::Reader;
use super::skin::{self, LoadedSkin};
use super::warning::{GltfWarning, Warnings};
use super::{container, estimate, parse};
use crate::mesh::{Weld, WeldCounts};
use crate::model::{Geometry, Influences, Model};
use crate::origin::Origin;

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
    pub(super) document: Document,
    pub(super) graph: Graph,
    pub(super) skins: Vec<Part<LoadedSkin>>,
    pub(super) animations: Vec<LoadedAnimation>,
    pub(super) animation_infos: Vec<AnimationInfo>,
    pub(super) skin_infos: Vec<SkinInfo>,
    pub(super) mesh_infos: Vec<MeshInfo>,
    pub(super) skipped: SkippedPrimitives,
    pub(super) built: Built,
    /// The joints that each geometry uses, ascending.
    pub(super) used_joints: Vec<Vec<u32>>,
    pub(super) named_files: Vec<PathBuf>,
    /// The origin of poses, lights and cameras.
    pub(super) origin: Origin,
    /// The box of each geometry in its mesh space. It is computed on first use.
    pub(super) boxes: OnceLock<Vec<Option<[[f64; 3]; 2]>>>,
    pub(super) warnings: Vec<GltfWarning>,
}

impl Asset {
    /// Loads a .gltf or .glb file; its content decides which. Buffers that it names are looked for in its folder. A
    /// [`Weld`](crate::mesh::Weld) can be given as options; the other options are then the defaults.
    ///
    /// # Errors
    /// [`GltfError`] if a file cannot be read, its content is damaged or not supported, or it takes more memory than
    /// the options allow.
    pub fn open(path: impl AsRef<Path>, options: impl Into<LoadOptions>) -> Result<Self, GltfError> {
        let (path, options) = (path.as_ref(), options.into());
        let budget = Budget::new(options.memory_limit);
        let folder = Folder { path: path.parent(), allow_outside: options.allow_outside };
        let source = Source { beside: Beside::Folder(folder), weld: options.weld, budget: &budget };
        // The JSON of a GLB comes first: it states the size of all other data.
        let json = files::glb_json(path, &budget)?;
        let header = json.map(|(json, length)| Header::read(&json, length, &source)).transpose()?;
        let bytes = files::read(path, u64::MAX, &budget)?;
        match header {
            Some(header) => Self::load(header, container::split(&bytes)?.1, &source),
            None => Self::of_bytes(&bytes, &source),
        }
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
        let LoadOptions { weld, allow_outside, memory_limit } = options.into();
        let beside = Beside::Folder(Folder { path: base_dir, allow_outside });
        Self::of_bytes(bytes, &Source { beside, weld, budget: &Budget::new(memory_limit) })
    }

    /// Loads the content of a .gltf or .glb file whose buffers are not in a folder: in an archive, or in memory. `find`
    /// gives the content of the file with a path relative to the glTF, and `None` if there is none. It is asked for the path
    /// with percent signs decoded, and then for the path as it is. The author of the glTF chooses the path. It may be
    /// absolute or lead outside by `..`, since [`LoadOptions::allow_outside`] has no effect here: check it before you join
    /// it to a folder.
    ///
    /// ```
    /// use rimline::gltf::Asset;
    /// use rimline::mesh::Weld;
    ///
    /// let gltf = br#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    ///     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    ///     "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}],
    ///     "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "a%20triangle.bin"}]}"#;
    /// let find = |path: &str| (path == "a triangle.bin").then(|| vec![0; 36]);
    /// assert_eq!(Asset::from_slices(gltf, &find, Weld::Keep)?.model().geometries()[0].faces().len(), 1);
    /// assert!(Asset::from_slices(gltf, &|_| None, Weld::Keep).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`GltfError`] as [`from_slice`](Self::from_slice), and if a buffer is used that `find` does not know.
    pub fn from_slices(
        bytes: &[u8],
        find: &dyn Fn(&str) -> Option<Vec<u8>>,
        options: impl Into<LoadOptions>,
    ) -> Result<Self, GltfError> {
        let LoadOptions { weld, memory_limit, .. } = options.into();
        Self::of_bytes(bytes, &Source { beside: Beside::Given(find), weld, budget: &Budget::new(memory_limit) })
    }

    fn of_bytes(bytes: &[u8], source: &Source<'_>) -> Result<Self, GltfError> {
        let (json, binary) = container::split(bytes)?;
        Self::load(Header::read(json, 0, source)?, binary, source)
    }

    fn load(header: Header<'_>, binary: Option<&[u8]>, source: &Source<'_>) -> Result<Self, GltfError> {
        let Header { mut document, graph, named_files, warnings } = header;
        let budget = source.budget;
        let buffers = files::buffers(&document.buffers, binary, source.beside, budget, &warnings)?;
        let reader = Reader { document: &document, buffers: &buffers, budget, warnings: &warnings };
        let skins = skin::load(&reader)?;
        let built = instances::build(&reader, &graph, &skins, source.weld)?;
        instances::charge_lights_and_cameras(&reader, &graph)?;
        let (animations, animation_infos) = animation::load(&reader)?;
        let skipped = skipped_primitives(&document);
        if skipped != SkippedPrimitives::default() {
            warnings.push(GltfWarning::Skipped(skipped))?;
        }
        warnings.damaged(&skins)?;
        warnings.damaged(&animations)?;
        warn_of_the_rest(&document, &graph, &buffers, &warnings)?;
        let warnings = warnings.finish();
        document.buffers = Vec::new();
        document.views = Vec::new();
        document.accessors = Vec::new();
        document.materials = Vec::new();
        Ok(Self {
            skin_infos: skin_infos(&document),
            mesh_infos: mesh_infos(&document, &built),
            used_joints: built.model.geometries().iter().map(used_joints).collect(),
            document,
            graph,
            skins,
            animations,
            animation_infos,
            skipped,
            built,
            named_files,
            origin: Origin::ZERO,
            boxes: OnceLock::new(),
            warnings,
        })
    }

    /// The paths of all URIs in the glTF but data, whether they were read or not: buffers, textures, files of extensions.
    /// They need not exist. A name with percent signs gives two, as it is and decoded, and a web address becomes a path
    /// in the folder. The list is empty without a folder to look in.
    pub fn named_files(&self) -> &[PathBuf] {
        &self.named_files
    }

    /// Parts of the file that were skipped, or read in another way than they are written. The command prints all of them.
    ///
    /// A damaged part that the chosen scene needs is refused, and the file with it. Every other one, but for cameras and for
    /// colours that no face and no vertex gets, is a [`GltfWarning::Damaged`]: animations, lights, materials, and meshes,
    /// skins, nodes and data that the scene does not show.
    pub fn warnings(&self) -> &[GltfWarning] {
        &self.warnings
    }

    /// The number of nodes of the chosen scene that are hidden (`KHR_node_visibility`), those below hidden ones included.
    /// They have no instances and no lights.
    pub fn hidden_nodes(&self) -> usize {
        self.graph.all.len() - self.graph.scene.len()
    }

    /// The model: the geometries of every mesh and the instances of the chosen scene. Only geometries with faces have
    /// instances.
    pub fn model(&self) -> &Model {
        &self.built.model
    }

    /// The base colours of the geometry with this index: of its faces and its vertices. `None` past the end, and if the file
    /// gives it none: all is white then.
    pub fn colors(&self, geometry: usize) -> Option<&Colors> {
        self.built.colors.get(geometry).filter(|colors| !colors.is_white())
    }

    /// Result of welding the geometry with this index, or `None` past the end.
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

/// Where the files of a glTF are, and how to read them.
struct Source<'a> {
    beside: Beside<'a>,
    weld: Weld,
    budget: &'a Budget,
}

/// A parsed glTF before its buffers are read.
struct Header<'a> {
    document: Document,
    graph: Graph,
    named_files: Vec<PathBuf>,
    warnings: Warnings<'a>,
}

impl<'a> Header<'a> {
    /// Reads the JSON and refuses what is not going to fit with `files` bytes of files that are yet to be read.
    fn read(json: &[u8], files: u64, source: &Source<'a>) -> Result<Self, GltfError> {
        let budget = source.budget;
        let warnings = Warnings::new(budget);
        // A byte order mark is not allowed, but harmless.
        let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
        let (json, zeros) = container::unpadded(json);
        if zeros > 0 {
            let problem = format!(" has {zeros} zero bytes at its end, where only spaces may be; they are ignored");
            warnings.push(GltfWarning::Changed { json_path: "the JSON".to_owned(), problem })?;
        }
        budget.charge_json(json)?;
        let value: Value = serde_json::from_slice(json).map_err(|error| GltfError::Json(Arc::new(error)))?;
        let document = parse::document(&value, budget, &warnings)?;
        let named_files = files::named(&value, source.beside.folder(), budget)?;
        drop(value);
        let graph = Graph::new(&document, &warnings)?;
        estimate::check(&document, &graph, files, budget)?;
        Ok(Self { document, graph, named_files, warnings })
    }
}

/// Warns of faults in parts that the scene does not need. Faults in parts that it needs were refused before.
fn warn_of_the_rest(
    document: &Document,
    graph: &Graph,
    buffers: &[Part<Bytes<'_>>],
    warnings: &Warnings<'_>,
) -> Result<(), GltfError> {
    for fault in graph.faults(document) {
        warnings.leave_out::<()>(Err(fault))?;
    }
    warnings.damaged(document.nodes.iter().filter_map(|node| node.light.as_ref()))?;
    warnings.damaged(document.lights.iter().map(|light| &light.part))?;
    warnings.damaged(document.materials.iter().map(|material| &material.part))?;
    warnings.damaged(&document.scenes)?;
    warnings.damaged(buffers)?;
    warnings.damaged(&document.views)?;
    warnings.damaged(&document.accessors)
}

fn skipped_primitives(document: &Document) -> SkippedPrimitives {
    let mut skipped = SkippedPrimitives::default();
    for primitive in document.meshes.iter().flat_map(|mesh| &mesh.part).flat_map(|mesh| &mesh.primitives) {
        match primitive.mode {
            Mode::Points => skipped.points += 1,
            Mode::Lines => skipped.lines += 1,
            _ if primitive.position.is_none() => skipped.without_position += 1,
            _ => {}
        }
    }
    skipped
}

fn skin_infos(document: &Document) -> Vec<SkinInfo> {
    let info = |Named { name, part }: &Named<Skin>| SkinInfo {
        name: name.clone(),
        joints: part.as_ref().map_or(0, |skin| skin.joints.len()),
    };
    document.skins.iter().map(info).collect()
}

fn mesh_infos(document: &Document, built: &Built) -> Vec<MeshInfo> {
    let info = |(mesh, Named { name, part }): (usize, &Named<Mesh>)| MeshInfo {
        name: name.clone(),
        primitives: part.as_ref().map_or(0, |mesh| mesh.primitives.len()),
        morph_targets: document.targets(mesh),
        geometries: Vec::new(),
    };
    let mut infos: Vec<MeshInfo> = document.meshes.iter().enumerate().map(info).collect();
    for (geometry, &mesh) in built.meshes.iter().enumerate() {
        infos[mesh].geometries.push(geometry);
    }
    infos
}

/// The joints that the vertices of a geometry follow. A rigid geometry has none.
fn used_joints(geometry: &Geometry) -> Vec<u32> {
    let joints = geometry.influences().map_or(&[][..], Influences::joints);
    joints.iter().copied().collect::<BTreeSet<_>>().into_iter().collect()
}
