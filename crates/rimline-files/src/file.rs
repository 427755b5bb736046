//! A file that was read.

use std::path::PathBuf;

use rimline::gltf::{Asset, Colors, GltfWarning};
use rimline::mesh::{WeldCounts, WeldDistance};
use rimline::{Geometry, InstancePose, Mesh, Model, ModelError, Origin, Pose};

use crate::error::FileError;

/// A file that was read: a glTF, or positions in world space.
#[derive(Debug)]
pub struct File {
    pub(crate) content: Content,
    /// Result of welding the content in world space.
    pub(crate) weld: WeldCounts,
    pub(crate) polygons: Option<Box<Mesh>>,
    pub(crate) described: Option<Box<GivenPolygons>>,
    pub(crate) origin: Origin,
    /// Colours of positions in world space.
    pub(crate) colors: Colors,
    pub(crate) color_notes: Vec<String>,
    /// Files that a file other than a glTF names.
    pub(crate) named_files: Vec<PathBuf>,
}

#[derive(Debug)]
pub(crate) enum Content {
    Gltf(Box<Asset>),
    /// Positions in world space less the origin: one geometry, one instance. It is welded, unless its polygons are whole.
    World(Model),
}

/// Polygons of a file that were taken as triangles.
#[derive(Debug)]
pub struct GivenPolygons {
    /// A mesh of polygons.
    pub mesh: Mesh,
    /// Positions of the file, which the mesh is of, relative to the origin that the file had when it was read.
    pub positions: Vec<[f32; 3]>,
}

/// The pose of a model of one instance whose positions are in world space.
///
/// # Errors
/// [`ModelError`] as for [`InstancePose::new`], which takes the identity.
pub fn resting() -> Result<Pose, ModelError> {
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    Ok(Pose::new(vec![InstancePose::new(vec![identity], Vec::new())?]))
}

impl File {
    pub(crate) fn of_asset(asset: Asset) -> Self {
        Self::new(Content::Gltf(Box::new(asset)), Origin::ZERO)
    }

    /// A model made by code, of one instance whose positions are in world space less the origin.
    pub fn in_world(model: Model, origin: Origin) -> Self {
        Self::new(Content::World(model), origin)
    }

    fn new(content: Content, origin: Origin) -> Self {
        Self {
            content,
            weld: WeldCounts::default(),
            polygons: None,
            described: None,
            origin,
            colors: Colors::default(),
            color_notes: Vec::new(),
            named_files: Vec::new(),
        }
    }

    /// The glTF, with its animations, lights and names, if it is one.
    pub fn asset(&self) -> Option<&Asset> {
        if let Content::Gltf(asset) = &self.content { Some(asset) } else { None }
    }

    /// Geometries, and instances of them.
    pub fn model(&self) -> &Model {
        match &self.content {
            Content::Gltf(asset) => asset.model(),
            Content::World(model) => model,
        }
    }

    /// The base colours of one of the model's geometries, if they are not all white. They are linear, and go by its
    /// faces and vertices.
    pub fn colors(&self, geometry: usize) -> Option<&Colors> {
        let file_colors = Some(&self.colors)
            .filter(|file_colors| geometry == 0 && (file_colors.faces.is_some() || file_colors.vertices.is_some()));
        self.asset().map_or(file_colors, |asset| asset.colors(geometry))
    }

    /// Why colours are missing, in words.
    pub fn color_notes(&self) -> &[String] {
        &self.color_notes
    }

    /// Positions in world space less the origin, of a file that is no glTF: those of its model, bit for bit.
    pub fn world_positions(&self) -> Option<&[[f32; 3]]> {
        match &self.content {
            Content::Gltf(_) => None,
            Content::World(model) => model.geometries().first().map(Geometry::positions),
        }
    }

    /// The mesh, if polygons were taken whole. The model has their triangles. `None` if all faces of an OBJ or a PLY
    /// are triangles.
    pub fn polygons(&self) -> Option<&Mesh> {
        self.polygons.as_deref()
    }

    /// The polygons that were taken as triangles, if they were to be described. `None` if all faces are triangles.
    pub fn described(&self) -> Option<&GivenPolygons> {
        self.described.as_deref()
    }

    /// Result of welding one of the model's geometries; zeros if a glTF has no such geometry.
    pub fn weld_counts(&self, geometry: usize) -> WeldCounts {
        self.asset().map_or(self.weld, |asset| asset.weld_counts(geometry).unwrap_or_default())
    }

    /// Where the instances are while these animations play, by their indices in the file. Only a glTF has animations: other
    /// files rest, and do not look at either argument.
    ///
    /// # Errors
    /// [`FileError::Gltf`] if animations of a glTF are not there, are damaged, or move the same.
    pub fn pose(&self, animations: &[usize], time_s: f32) -> Result<Pose, FileError> {
        match self.asset() {
            Some(asset) => asset.pose(animations.iter().copied(), time_s).map_err(FileError::Gltf),
            None => Ok(resting()?),
        }
    }

    /// The origin of positions in world space, poses and lights: the file's own until [`settle`](crate::settle) moves it.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Other files that the file names, textures included.
    pub fn named_files(&self) -> &[PathBuf] {
        self.asset().map_or(&self.named_files, Asset::named_files)
    }

    /// Parts of a glTF that the reader skipped or changed; other files have none. Positions that are not finite are counted
    /// apart: [`File::non_finite`].
    pub fn warnings(&self) -> impl Iterator<Item = &GltfWarning> {
        let is_reported = |warning: &&GltfWarning| !matches!(warning, GltfWarning::NonFinite { is_target: false, .. });
        self.asset().map_or(&[][..], Asset::warnings).iter().filter(is_reported)
    }

    /// How many positions are infinite or NaN, in words.
    pub fn non_finite(&self) -> Option<String> {
        let is_finite = |position: &&[f32; 3]| position.iter().all(|c| c.is_finite());
        let positions = self.model().geometries().iter().flat_map(Geometry::positions);
        let count = positions.filter(|position| !is_finite(position)).count();
        let (vertices, are, their) = if count == 1 { ("vertex", "is", "its") } else { ("vertices", "are", "their") };
        (count > 0).then(|| {
            format!(
                "{count} {vertices} {are} infinite or NaN; {their} faces face no light, cast no shadow and are not drawn"
            )
        })
    }

    /// How many groups of vertices within a distance are much wider than that, in words: a chain of vertices, each near the
    /// next, becomes one point.
    pub fn wide_groups(&self, distance: WeldDistance) -> Option<String> {
        let counts = (0..self.model().geometries().len()).map(|geometry| self.weld_counts(geometry));
        let count = counts.map(|counts| counts.wide).sum::<usize>();
        let (groups, are, theirs) = if count == 1 { ("group", "is", "it lies") } else { ("groups", "are", "they lie") };
        (count > 0).then(|| {
            format!(
                "{count} {groups} of vertices joined by --weld-distance {:e} {are} wider than 10 times that, since {theirs} \
                 in chains; each is one point now, so give a smaller distance if that is not meant",
                distance.get()
            )
        })
    }
}
