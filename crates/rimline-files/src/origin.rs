//! Where a file's model is, and the origin that it needs.

use rimline::gltf::{GltfError, SceneExtent};
use rimline::{Geometry, GeometryOptions, Instance, Model, ModelError, Origin};

use crate::error::FileError;
use crate::file::{Content, File};

/// The share of a model's size that rounding may move a vertex by without a warning.
const UNSEEN: f64 = 1e-4;

fn size(SceneExtent { bounds: [low, high], .. }: &SceneExtent) -> f64 {
    low.iter().zip(high).map(|(low, high)| high - low).fold(0.0, f64::max)
}

/// Whether rounding moves vertices by too much of the size.
fn is_coarse(extent: &SceneExtent) -> bool {
    size(extent) > 0.0 && extent.rounding > UNSEEN * size(extent)
}

/// Files at one origin.
#[derive(Debug)]
pub struct Settled {
    /// Their origin.
    pub origin: Origin,
    /// A warning for each file where `f32` still loses much.
    pub warnings: Vec<Option<String>>,
}

/// Moves files to one origin, each with the animations that play. It is the origin that the model of the smallest size needs
/// of those that need one: what is far from it is large, too.
///
/// # Errors
/// The index of a file that has no such pose, and what is wrong with it.
pub fn settle(files: &mut [(&mut File, &[usize])], time_s: f32) -> Result<Settled, (usize, FileError)> {
    let at = |index: usize| move |error: GltfError| (index, FileError::Gltf(error));
    let of =
        |(index, (file, playing)): (usize, &(&mut File, &[usize]))| file.extent(playing, time_s).map_err(at(index));
    let extents = files.iter().enumerate().map(of).collect::<Result<Vec<_>, _>>()?;
    let mut chosen: Option<(f64, Origin)> = None;
    for ((file, playing), extent) in files.iter().zip(&extents) {
        let Some(extent) = extent else { continue };
        let origin = file.suggested_origin(extent, playing, time_s);
        if !origin.is_zero() && chosen.is_none_or(|(smallest, _)| size(extent) < smallest) {
            chosen = Some((size(extent), origin));
        }
    }
    let origin = chosen.map_or(Origin::ZERO, |(_, origin)| origin);
    let mut warnings = Vec::with_capacity(files.len());
    for (index, ((file, playing), before)) in files.iter_mut().zip(extents).enumerate() {
        let is_there = file.origin == origin;
        file.move_to(origin).map_err(|error| (index, error))?;
        let extent = if is_there { before } else { file.extent(playing, time_s).map_err(at(index))? };
        warnings.push(extent.as_ref().filter(|extent| is_coarse(extent)).map(coarse));
    }
    Ok(Settled { origin, warnings })
}

fn coarse(extent: &SceneExtent) -> String {
    let rounding = extent.rounding;
    format!(
        "32-bit floats move its vertices by up to {rounding:.2e}, {:.2e} of its size; store them relative to a point near \
         the model, and keep files that are far apart for runs of their own",
        rounding / size(extent)
    )
}

impl File {
    /// The origin for the model at a time at which it has this extent: zero for files that `f32` holds well. The origin of
    /// arrays is known since they were read.
    fn suggested_origin(&self, extent: &SceneExtent, animations: &[usize], time_s: f32) -> Origin {
        let Content::Gltf(asset) = &self.content else { return self.origin };
        // There is a pose, since there is an extent.
        let smallest_edge = || asset.smallest_edge(animations.iter().copied(), time_s).unwrap_or(f64::INFINITY);
        Origin::near(extent.bounds, smallest_edge)
    }

    /// The size of the model and its rounding at one time. `None` if nothing has a finite position. The bounds are in world
    /// space only for a glTF. Those of other files are relative to [`File::origin`], and may leave faces out: they tell the
    /// size, not where the model is.
    ///
    /// # Errors
    /// [`GltfError`] as for [`File::pose`].
    pub fn extent(&self, animations: &[usize], time_s: f32) -> Result<Option<SceneExtent>, GltfError> {
        match &self.content {
            Content::Gltf(asset) => asset.extent(animations.iter().copied(), time_s),
            Content::World(model) => {
                let [geometry] = model.geometries() else { return Ok(None) };
                Ok(extent(geometry, self.origin))
            }
        }
    }

    /// Makes positions, poses and lights relative to another origin. The positions of [`File::described`] stay.
    ///
    /// # Errors
    /// [`FileError`] if the moved positions make no model.
    pub fn move_to(&mut self, origin: Origin) -> Result<(), FileError> {
        match &mut self.content {
            Content::Gltf(asset) => asset.set_origin(origin),
            Content::World(_) if self.origin == origin => {}
            Content::World(model) => *model = moved(model, self.origin, origin)?,
        }
        self.origin = origin;
        Ok(())
    }
}

/// Bounds of the positions as they are, which are relative to the origin. Without one a part of the faces may tell enough:
/// then the bounds are those of that part, and the rounding is that of all vertices.
fn extent(geometry: &Geometry, origin: Origin) -> Option<SceneExtent> {
    let (positions, faces) = (geometry.positions(), geometry.faces());
    let double = |position: &[f32; 3]| position.map(f64::from);
    let of_faces = |step: usize| {
        let corners = faces.iter().step_by(step).flatten();
        Origin::bounds(corners.filter_map(|&v| positions.get(v as usize).map(double)))
    };
    let rounded = |bounds| Origin::ZERO.rounding(bounds);
    let all = Origin::bounds(positions.iter().map(double))?;
    if origin.is_zero()
        && let Some(some) = of_faces(1 + faces.len() / 1000)
    {
        // Where not even the farthest vertex of any of them moves by much of their size.
        let guess = SceneExtent { bounds: some, rounding: rounded(all) };
        if size(&guess) > 0.0 && !is_coarse(&guess) {
            return Some(guess);
        }
    }
    of_faces(1).map(|bounds| SceneExtent { bounds, rounding: rounded(bounds) })
}

/// The same model relative to another origin. Its faces, and what was welded, stay.
fn moved(model: &Model, from: Origin, to: Origin) -> Result<Model, ModelError> {
    let moved = |geometry: &Geometry| {
        let positions = geometry.positions().iter().map(|&position| to.position(from.to_world(position))).collect();
        let options = GeometryOptions {
            name: geometry.name().map(str::to_owned),
            source_vertices: Some(geometry.source_vertices().to_vec()),
            ..GeometryOptions::default()
        };
        Geometry::new(positions, geometry.faces().to_vec(), options)
    };
    let geometries = model.geometries().iter().map(moved).collect::<Result<_, _>>()?;
    let placed = |instance: &Instance| Instance::new(instance.geometry(), instance.name().map(str::to_owned));
    Model::new(geometries, model.instances().iter().map(placed).collect())
}
