//! Where the scene is, in `f64`, and the origin that its poses are relative to.

use glam::{DAffine3, DVec3};

use super::asset::Asset;
use super::document::Placement;
use super::error::GltfError;
use super::pose::State;
use crate::model::Geometry;
use crate::origin::{Origin, half_step};

/// Where the instances of a file are at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneExtent {
    /// The lowest and the highest corner of a box in world space that holds all instances. It is not relative to
    /// [`Asset::origin`].
    pub bounds: [[f64; 3]; 2],
    /// The most by which a position may be off because it is in `f32`: as the file has it, without offsets of morph
    /// targets, and relative to [`Asset::origin`].
    pub rounding: f64,
}

/// An instance at one time, relative to the asset's origin.
struct Placed<'a> {
    geometry: &'a Geometry,
    matrices: Vec<DAffine3>,
    weights: Vec<f64>,
}

impl Asset {
    /// The origin that [`Asset::pose`], [`Asset::lights`] and [`Asset::each_camera`] are relative to. It is zero until
    /// [`Asset::set_origin`] is called.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Makes poses, lights and cameras of the asset relative to this origin, instead of the one before. Transforms of nodes
    /// are composed in `f64`, the origin is subtracted there, and the result is rounded to `f32` once. The model does not
    /// change: its geometries are in their spaces.
    ///
    /// Everything that is seen together needs one origin: models, lights and cameras of other sources, too.
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
    /// [`GltfError`] for animations or a time that [`Asset::pose`] refuses.
    pub fn suggested_origin(
        &self,
        animations: impl IntoIterator<Item = usize>,
        time_s: f32,
    ) -> Result<Origin, GltfError> {
        let state = self.state(animations, time_s)?;
        let extent = self.extent_of(&state);
        Ok(extent.map_or(Origin::ZERO, |extent| Origin::near(extent.bounds, || self.smallest_edge_of(&state))))
    }

    /// Where all instances are at one time. Positions that are not finite do not count. `None` if no position does.
    ///
    /// # Errors
    /// [`GltfError`] for animations or a time that [`Asset::pose`] refuses.
    pub fn extent(
        &self,
        animations: impl IntoIterator<Item = usize>,
        time_s: f32,
    ) -> Result<Option<SceneExtent>, GltfError> {
        Ok(self.extent_of(&self.state(animations, time_s)?))
    }

    /// The length of the smallest edge of all instances at one time, of those that have one; else infinity. It is what
    /// [`Origin::near`] asks for.
    ///
    /// # Errors
    /// [`GltfError`] for animations or a time that [`Asset::pose`] refuses.
    pub fn smallest_edge(&self, animations: impl IntoIterator<Item = usize>, time_s: f32) -> Result<f64, GltfError> {
        Ok(self.smallest_edge_of(&self.state(animations, time_s)?))
    }

    fn smallest_edge_of(&self, state: &State) -> f64 {
        let model = &self.built.model;
        let instances = self.built.placements.iter().zip(model.placed_geometries());
        let edges = instances.map(|(placement, geometry)| self.placed(placement, geometry, state).smallest_edge());
        edges.fold(f64::INFINITY, f64::min)
    }

    fn placed<'a>(&self, placement: &Placement, geometry: &'a Geometry, state: &State) -> Placed<'a> {
        let matrices = self.matrices(placement, state);
        let weights = self.morph_weights(placement, state).into_iter().map(f64::from).collect();
        Placed { geometry, matrices, weights }
    }

    fn extent_of(&self, state: &State) -> Option<SceneExtent> {
        let model = &self.built.model;
        // Many instances share a geometry, whose vertices are then looked at once.
        let boxes = self.boxes.get_or_init(|| model.geometries().iter().map(box_of).collect());
        let (mut low, mut high, mut stored) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0_f64);
        let mut add = |center: DVec3, half: DVec3| {
            // Positions that `f32` cannot hold do not count.
            if let Some([from, to]) = Origin::bounds([(center - half).to_array(), (center + half).to_array()]) {
                (low, high) = (low.min(from.into()), high.max(to.into()));
            }
        };
        let instances = self.built.placements.iter().zip(model.instances()).zip(model.placed_geometries());
        for ((placement, instance), geometry) in instances {
            let Some(geometry_box) = boxes.get(instance.geometry()).copied().flatten() else { continue };
            let [from, to] = geometry_box.map(DVec3::from);
            let sizes = DVec3::from(from.abs().max(to.abs()).to_array().map(half_step));
            let rounding = |matrix: &DAffine3| {
                let [x, y, z] = columns(matrix).map(DVec3::length);
                DVec3::new(x, y, z).dot(sizes)
            };
            if let Some(matrix) = self.rigid_matrix(placement, geometry, state) {
                stored = stored.max(rounding(&matrix));
                let half = 0.5 * (to - from);
                let [x, y, z] = columns(&matrix).map(DVec3::abs);
                add(matrix.transform_point3(from.midpoint(to)), x * half.x + y * half.y + z * half.z);
            } else {
                let placed = self.placed(placement, geometry, state);
                stored = placed.matrices.iter().map(rounding).filter(|most| most.is_finite()).fold(stored, f64::max);
                let used = used(geometry).into_iter().enumerate().filter(|(_, is_used)| *is_used);
                used.for_each(|(vertex, _)| add(placed.position(vertex), DVec3::ZERO));
            }
        }
        let origin = DVec3::from(self.origin.to_array());
        let bounds = [low + origin, high + origin].map(DVec3::into);
        (low.x <= high.x).then(|| SceneExtent { bounds, rounding: stored + self.origin.rounding(bounds) })
    }

    /// The matrix of an instance whose vertices move together.
    fn rigid_matrix(&self, placement: &Placement, geometry: &Geometry, state: &State) -> Option<DAffine3> {
        let is_rigid = geometry.influences().is_none() && geometry.morph_targets().is_empty();
        is_rigid.then(|| self.matrices(placement, state).into_iter().find(DAffine3::is_finite)).flatten()
    }
}

impl Placed<'_> {
    /// A vertex after morph and skin.
    fn position(&self, vertex: usize) -> DVec3 {
        let vector = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
        let mut position = vector(self.geometry.positions()[vertex]);
        for (target, &weight) in self.geometry.morph_targets().iter().zip(&self.weights) {
            if weight != 0.0 {
                position += weight * vector(target[vertex]);
            }
        }
        let moved =
            |joint: usize| self.matrices.get(joint).map_or(DVec3::NAN, |matrix| matrix.transform_point3(position));
        let Some(influences) = self.geometry.influences() else { return moved(0) };
        let range = influences.range(vertex);
        let joints = influences.joints()[range.clone()].iter().zip(&influences.weights()[range]);
        joints.map(|(&joint, &weight)| f64::from(weight) * moved(joint as usize)).sum()
    }

    /// It takes less memory than the mesh of all instances, which is charged when the file is loaded.
    fn smallest_edge(&self) -> f64 {
        let used = used(self.geometry);
        let mut positions = Vec::with_capacity(used.iter().filter(|is_used| **is_used).count());
        let mut numbers = Vec::with_capacity(used.len());
        // Each vertex is moved once, however many faces name it: it may have many morph targets.
        for (vertex, is_used) in used.into_iter().enumerate() {
            numbers.push(positions.len() as u32);
            if is_used {
                positions.push(self.position(vertex).to_array());
            }
        }
        let edges = self.geometry.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        Origin::smallest_edge(edges.map(|ends| ends.map(|v| positions[numbers[v as usize] as usize])))
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
    Origin::bounds(used.map(|(position, _)| position.map(f64::from)))
}

fn columns(matrix: &DAffine3) -> [DVec3; 3] {
    [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis]
}
