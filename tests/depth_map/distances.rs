//! Distances of positions from a light, and back, in `f64`, from the rows of the light's matrix.

use glam::{DMat3, DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::DepthMetric;
use rimline::{DepthDirection, ShadowCamera};

/// A light's camera: the rows of its matrix and its origin.
pub(crate) struct Measured {
    rows: [DVec4; 4],
    origin: DVec3,
    /// Where all rays meet. `None` if they are parallel.
    position: Option<DVec3>,
    near_z: f64,
    /// 1 if depth grows away from the light, else -1.
    away: f64,
}

/// The point that three rows map to given values.
fn solved(rows: [DVec4; 3], values: DVec3) -> DVec3 {
    let constants = DVec3::from_array(rows.map(|row| row.w));
    let [x, y, z] = rows.map(DVec4::truncate);
    DMat3::from_cols(x, y, z).transpose().inverse() * (values - constants)
}

impl Measured {
    pub(crate) fn new(camera: &ShadowCamera) -> Self {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let rows = [0, 1, 2, 3].map(|row| matrix.row(row));
        let [x, y, _, w] = rows;
        let is_parallel = w.truncate() == DVec3::ZERO;
        let is_reversed = camera.depth == DepthDirection::Reversed;
        Self {
            rows,
            origin: DVec3::from_array(camera.origin.map(f64::from)),
            position: (!is_parallel).then(|| solved([x, y, w], DVec3::ZERO)),
            near_z: f64::from(u8::from(is_reversed)),
            away: if is_reversed { -1.0 } else { 1.0 },
        }
    }

    /// The direction of the ray through a position of the picture, of length 1, away from the light.
    fn ray(&self, at: DVec2) -> DVec3 {
        let [x, y, z, w] = self.rows.map(DVec4::truncate);
        let along = (x - at.x * w).cross(y - at.y * w).normalize();
        let forward = if self.position.is_some() { w } else { self.away * z };
        along * along.dot(forward).signum()
    }

    /// Where the ray through a position of the picture, from -1 to 1 to the right and up, begins to be measured, its
    /// direction, and that of the axis.
    fn measure(&self, at: DVec2) -> [DVec3; 3] {
        let [x, y, z, w] = self.rows;
        if let Some(position) = self.position {
            return [position, self.ray(at), w.truncate().normalize()];
        }
        let near = solved([x, y, z], DVec3::new(at.x, at.y, self.near_z) * w.w);
        [near, self.ray(at), (self.away * z.truncate()).normalize()]
    }

    /// The position at a distance, on the ray through a position of the picture.
    pub(crate) fn position(&self, metric: DepthMetric, at: DVec2, distance: f64) -> DVec3 {
        let [from, ray, axis] = self.measure(at);
        let along = if metric == DepthMetric::AlongAxis { distance / ray.dot(axis) } else { distance };
        self.origin + from + along * ray
    }

    /// The distance of a position.
    pub(crate) fn distance(&self, metric: DepthMetric, position: DVec3) -> f64 {
        let clip = self.clip(position);
        let [from, ray, axis] = self.measure(DVec2::new(clip.x, clip.y) / clip.w);
        let way = position - self.origin - from;
        way.dot(if metric == DepthMetric::AlongAxis { axis } else { ray })
    }

    fn clip(&self, position: DVec3) -> DVec4 {
        let from = (position - self.origin).extend(1.0);
        DVec4::from_array(self.rows.map(|row| row.dot(from)))
    }

    /// The device depth of a position, of any size, and whether it is before the light.
    pub(crate) fn depth(&self, position: DVec3) -> (f64, bool) {
        let clip = self.clip(position);
        (clip.z / clip.w, clip.w > 0.0)
    }
}
