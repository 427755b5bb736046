//! Where the scene is, in `f64`, and the origin that its poses are relative to.

use glam::{DAffine3, DVec3};

use super::asset::Asset;
use super::error::AnimationError;
use super::node_state::State;
use crate::model::Geometry;
use crate::origin::{Origin, bounds, half_step, smallest};

/// Where the instances of a file are at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneExtent {
    /// The lowest and the highest corner of a box in world space that holds all instances.
    pub bounds: [[f64; 3]; 2],
    /// The most by which a position may be off because it is in `f32`: as the file has it, and relative to
    /// [`Asset::origin`].
    pub rounding: f64,
}

/// An instance at one time, relative to the asset's origin.
struct Placed<'a> {
    geometry: &'a Geometry,
    matrices: Vec<DAffine3>,
    weights: Vec<f64>,
}

impl Asset {
    /// What [`Asset::pose`] and [`Asset::lights`] are relative to. It is zero until [`Asset::set_origin`] is called.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Makes poses and lights relative to this origin. Transforms of nodes are composed in `f64`, the origin is subtracted
    /// there, and the result is rounded to `f32` once. The model itself does not change: its geometries are in their own
    /// spaces.
    ///
    /// Everything that is seen together needs one origin: other models, lights and cameras, too.
    ///
    /// ```no_run
    /// # use rimline::gltf::Asset;
    /// # use rimline::mesh::Weld;
    /// let mut asset = Asset::open("town.glb", Weld::Data)?;
    /// asset.set_origin(asset.suggested_origin(None, 0.0)?);
    /// let pose = asset.pose(None, 0.0)?;
    /// let lamp = asset.origin().light([392_143.5, 40.0, -5_820_467.25, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_origin(&mut self, origin: Origin) {
        self.origin = origin;
    }

    /// The origin for all instances at one time, as [`Origin::near`] chooses it: zero for files that `f32` holds well.
    ///
    /// # Errors
    /// [`AnimationError`] as for [`Asset::pose`].
    pub fn suggested_origin(&self, animation: Option<usize>, time_s: f32) -> Result<Origin, AnimationError> {
        let state = self.state(animation, time_s)?;
        let smallest_edge =
            || self.placed(&state).map(|(_, placed)| placed.smallest_edge()).fold(f64::INFINITY, f64::min);
        Ok(self.extent_of(&state).map_or(Origin::ZERO, |extent| Origin::near(extent.bounds, smallest_edge)))
    }

    /// Where all instances are at one time. `None` if nothing has a finite position.
    ///
    /// # Errors
    /// [`AnimationError`] as for [`Asset::pose`].
    pub fn extent(&self, animation: Option<usize>, time_s: f32) -> Result<Option<SceneExtent>, AnimationError> {
        Ok(self.extent_of(&self.state(animation, time_s)?))
    }

    /// All instances, each with the number of its geometry.
    fn placed<'a>(&'a self, state: &'a State) -> impl Iterator<Item = (usize, Placed<'a>)> {
        let model = &self.built.model;
        let instances = self.built.placements.iter().zip(model.instances()).zip(model.placed_geometries());
        instances.map(|((placement, instance), geometry)| {
            let matrices = self.matrices(placement, state);
            let weights = self.morph_weights(placement, state).into_iter().map(f64::from).collect();
            (instance.geometry(), Placed { geometry, matrices, weights })
        })
    }

    fn extent_of(&self, state: &State) -> Option<SceneExtent> {
        // Many instances share a geometry, whose vertices are then looked at once.
        let boxes = self.boxes.get_or_init(|| self.built.model.geometries().iter().map(box_of).collect());
        let (mut corners, mut stored) = (Vec::new(), 0.0_f64);
        for (geometry, placed) in self.placed(state) {
            let Some(own @ [low, high]) = boxes.get(geometry).copied().flatten() else { continue };
            let matrices = || placed.matrices.iter().filter(|matrix| matrix.is_finite());
            let sizes = [0, 1, 2].map(|axis: usize| half_step(low[axis].abs().max(high[axis].abs())));
            let moved = |matrix: &DAffine3| {
                let columns = [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis];
                columns.iter().zip(sizes).map(|(column, size)| column.length() * size).sum()
            };
            stored = matrices().map(moved).fold(stored, f64::max);
            if placed.is_rigid() {
                corners.extend(matrices().flat_map(|matrix| corners_of(own).map(|c| matrix.transform_point3(c))));
            } else {
                let vertices = 0..placed.geometry.positions().len();
                let used = used(placed.geometry);
                corners.extend(vertices.filter(|&v| used[v]).map(|v| placed.position(v)));
            }
            // What is not needed any more is not kept.
            corners = bounds(corners.iter().map(DVec3::to_array)).into_iter().flatten().map(DVec3::from).collect();
        }
        let corners = bounds(corners.iter().map(DVec3::to_array))?;
        let origin = self.origin.to_array();
        let bounds = corners.map(|corner| [0, 1, 2].map(|axis| corner[axis] + origin[axis]));
        Some(SceneExtent { bounds, rounding: stored + self.origin.rounding(bounds) })
    }
}

impl Placed<'_> {
    /// Whether its vertices move together.
    fn is_rigid(&self) -> bool {
        self.geometry.influences().is_none() && self.weights.iter().all(|&weight| weight == 0.0)
    }

    /// A vertex after morph and skin.
    fn position(&self, vertex: usize) -> DVec3 {
        let vector = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
        let mut place = vector(self.geometry.positions()[vertex]);
        for (target, &weight) in self.geometry.morph_targets().iter().zip(&self.weights) {
            if weight != 0.0 {
                place += weight * vector(target[vertex]);
            }
        }
        let moved = |joint: usize| self.matrices.get(joint).map_or(DVec3::NAN, |matrix| matrix.transform_point3(place));
        let Some(influences) = self.geometry.influences() else { return moved(0) };
        let range = influences.range(vertex);
        let joints = influences.joints()[range.clone()].iter().zip(&influences.weights()[range]);
        joints.map(|(&joint, &weight)| f64::from(weight) * moved(joint as usize)).sum()
    }

    fn smallest_edge(&self) -> f64 {
        let edges = self.geometry.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        smallest(edges.map(|ends| ends.map(|v| self.position(v as usize).to_array())))
    }
}

/// Which vertices faces name.
fn used(geometry: &Geometry) -> Vec<bool> {
    let mut used = vec![false; geometry.positions().len()];
    for &v in geometry.faces().as_flattened() {
        used[v as usize] = true;
    }
    used
}

/// The box of the vertices that faces name, in the geometry's own space.
fn box_of(geometry: &Geometry) -> Option<[[f64; 3]; 2]> {
    let used = geometry.positions().iter().zip(used(geometry)).filter(|(_, used)| *used);
    bounds(used.map(|(position, _)| position.map(f64::from)))
}

fn corners_of([low, high]: [[f64; 3]; 2]) -> [DVec3; 8] {
    let corners = [low, high];
    std::array::from_fn(|number| DVec3::from([0, 1, 2].map(|axis| corners[number >> axis & 1][axis])))
}
