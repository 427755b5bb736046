//! The run's origin: one for all files, near the models, where coordinates are too large for `f32`.

use rimline::gltf::SceneExtent;
use rimline::internals::origin::bounds;
use rimline::{Geometry, GeometryOptions, Instance, Model, ModelError, Origin};

use crate::failure::Failure;
use crate::input::{Input, Source};
use crate::output::note;
use crate::shown::Line;

/// The share of a model's size that rounding may move a vertex by without a warning.
const UNSEEN: f64 = 1e-4;

/// Moves the files to one origin, and warns where `f32` still loses much. `animations` has those of each. It is the origin
/// that the model of the smallest size needs of those that need one: what is far from it is large, too.
pub(crate) fn settle(inputs: &mut [Input], animations: &[Vec<usize>], time_s: f32) -> Result<Origin, Failure> {
    let of = |(input, animations): (&Input, &Vec<usize>)| input.extent(animations, time_s);
    let extents = inputs.iter().zip(animations).map(of).collect::<Result<Vec<_>, _>>()?;
    let mut chosen: Option<(f64, Origin)> = None;
    for ((input, playing), extent) in inputs.iter().zip(animations).zip(&extents) {
        let Some(extent) = extent else { continue };
        let origin = input.suggested_origin(extent, playing, time_s)?;
        if !origin.is_zero() && chosen.is_none_or(|(smallest, _)| size(extent) < smallest) {
            chosen = Some((size(extent), origin));
        }
    }
    let origin = chosen.map_or(Origin::ZERO, |(_, origin)| origin);
    for ((input, playing), before) in inputs.iter_mut().zip(animations).zip(extents) {
        let is_there = input.origin == origin;
        input.move_to(origin)?;
        let extent = if is_there { before } else { input.extent(playing, time_s)? };
        if let Some(extent) = extent {
            warn(&extent, input);
        }
    }
    Ok(origin)
}

fn size(SceneExtent { bounds: [low, high], .. }: &SceneExtent) -> f64 {
    low.iter().zip(high).map(|(low, high)| high - low).fold(0.0, f64::max)
}

/// Whether rounding moves vertices by too much of the size.
fn is_coarse(extent: &SceneExtent) -> bool {
    size(extent) > 0.0 && extent.rounding > UNSEEN * size(extent)
}

fn warn(extent: &SceneExtent, input: &Input) {
    if is_coarse(extent) {
        let (file, rounding) = (Line(input.file.display()), extent.rounding);
        note(&format!(
            "warning: {file}: 32-bit floats move its vertices by up to {rounding:.2e}, {:.2e} of its size; store them \
             relative to a point near the model, and keep files that are far apart for runs of their own",
            rounding / size(extent)
        ));
    }
}

impl Input {
    /// The origin that the file needs. The origin of arrays is known since they were read.
    fn suggested_origin(&self, extent: &SceneExtent, animations: &[usize], time_s: f32) -> Result<Origin, Failure> {
        let Source::Gltf(asset) = &self.source else { return Ok(self.origin) };
        let mut failure = None;
        let smallest_edge = || {
            asset.smallest_edge(animations.iter().copied(), time_s).unwrap_or_else(|error| {
                failure = Some(self.not_posed(error));
                f64::INFINITY
            })
        };
        let origin = Origin::near(extent.bounds, smallest_edge);
        failure.map_or(Ok(origin), Err)
    }

    fn extent(&self, animations: &[usize], time_s: f32) -> Result<Option<SceneExtent>, Failure> {
        match &self.source {
            Source::Gltf(asset) => {
                asset.extent(animations.iter().copied(), time_s).map_err(|error| self.not_posed(error))
            }
            Source::World { model, .. } => {
                let [geometry] = model.geometries() else { return Ok(None) };
                Ok(extent(geometry, self.origin))
            }
        }
    }

    fn move_to(&mut self, origin: Origin) -> Result<(), Failure> {
        match &mut self.source {
            Source::Gltf(asset) => asset.set_origin(origin),
            Source::World { .. } if self.origin == origin => {}
            Source::World { model, .. } => {
                let moved = moved(model, self.origin, origin);
                *model = moved.map_err(|error| Failure::input(&self.file)(error.into()))?;
            }
        }
        self.origin = origin;
        Ok(())
    }
}

/// Where the faces are. Positions are relative to the origin already; without one a part of the faces may tell enough.
fn extent(geometry: &Geometry, origin: Origin) -> Option<SceneExtent> {
    let (positions, faces) = (geometry.positions(), geometry.faces());
    let double = |position: &[f32; 3]| position.map(f64::from);
    let of_faces = |step: usize| {
        let corners = faces.iter().step_by(step).flatten();
        bounds(corners.filter_map(|&v| positions.get(v as usize).map(double)))
    };
    let rounded = |bounds| Origin::ZERO.rounding(bounds);
    let all = bounds(positions.iter().map(double))?;
    if origin.is_zero()
        && let Some(some) = of_faces(1 + faces.len() / 1000)
    {
        // Where not even the farthest vertex, whatever it is of, moves by much of their size.
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
