//! The pixels that a light may affect.

use glam::{DVec3, DVec4, Vec3};

use crate::{Light, ShadowCamera};

/// How much farther a surface may be than its depth says: a share of the range, radians for a cone.
const SLACK: f64 = 1e-4;
/// The same as a share of coordinates: some units in the last place, for shaders that compute positions from depth.
const ROUNDING: f64 = 1e-6;

/// The points within the range and the cone of a light.
struct Sector {
    /// The position of the light, relative to the camera's origin.
    apex: DVec3,
    range: f64,
    /// The unit axis, and the half angle in radians, π for none.
    axis: DVec3,
    angle: f64,
    /// The distance around the sector within which surfaces may be lit.
    slack: f64,
}

impl Sector {
    /// `None` for a light at infinity.
    fn new(camera: &ShadowCamera, light: &Light) -> Option<Self> {
        if light.w == 0.0 {
            return None;
        }
        let position = Vec3::from(light.xyz).as_dvec3() / f64::from(light.w);
        let origin = camera.origin_point();
        let axis = light.cone.and_then(|cone| Vec3::from(cone.axis).as_dvec3().try_normalize());
        let angle = light.cone.map_or(std::f64::consts::PI, |cone| f64::from(cone.cosine).acos() + SLACK);
        Some(Self {
            apex: position - origin,
            range: f64::from(light.range) * (1.0 + SLACK),
            axis: axis.unwrap_or(DVec3::Z),
            angle: if axis.is_some() { angle } else { std::f64::consts::PI },
            slack: ROUNDING * (position.abs().max_element() + origin.abs().max_element()),
        })
    }

    /// Whether all of it is on the negative side of a plane.
    fn is_behind(&self, plane: DVec4) -> bool {
        let normal = plane.truncate();
        let length = normal.length();
        // The largest slope against the plane within the cone.
        let tilt = (normal.dot(self.axis) / length).clamp(-1.0, 1.0).acos();
        let steepest = length * (tilt - self.angle).max(0.0).cos();
        let rise = if steepest > 0.0 { self.range * steepest } else { 0.0 };
        plane.dot(self.apex.extend(1.0)) + rise + self.slack * length < 0.0
    }

    /// A bounding sphere: centre and radius.
    fn sphere(&self) -> (DVec3, f64) {
        let (sine, cosine) = self.angle.sin_cos();
        let (along, radius) = if cosine <= 0.0 {
            (0.0, self.range)
        } else if cosine < std::f64::consts::FRAC_1_SQRT_2 {
            (self.range * cosine, self.range * sine)
        } else {
            (0.5 * self.range / cosine, 0.5 * self.range / cosine)
        };
        (self.apex + along * self.axis, radius + self.slack)
    }
}

/// A rectangle with all pixels that a light may affect, in an image of `size` pixels: x, y, width and height. `None`: there
/// are none. It is the whole image for lights at infinity, around the eye, or without a range, unless their cone misses it.
pub(super) fn affected_pixels(camera: &ShadowCamera, light: &Light, size: [u32; 2]) -> Option<[u32; 4]> {
    let whole = Some([0, 0, size[0], size[1]]);
    let Some(sector) = Sector::new(camera, light) else { return whole };
    let matrix = camera.matrix();
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
    if [w + x, w - x, w + y, w - y, z, w - z].into_iter().any(|plane| sector.is_behind(plane)) {
        return None;
    }
    let (centre, radius) = sector.sphere();
    if !radius.is_finite() {
        return whole;
    }
    let centre = centre.extend(1.0);
    let [columns, rows] = [(x, size[0], 1.0), (y, size[1], -1.0)].map(|(row, pixels, sign)| {
        let pixels = f64::from(pixels);
        let all = [0.0, pixels];
        let [low, high] =
            extent(row, w, centre, radius).map_or(all, |ends| ends.map(|end| (0.5 + 0.5 * sign * end) * pixels));
        // Room for the rounding of the rasteriser, and of the camera's matrix.
        let [low, high] = [low.min(high).floor() - 1.0, low.max(high).ceil() + 1.0];
        [low, high].map(|end| end.clamp(0.0, pixels) as u32)
    });
    let rectangle = [columns[0], rows[0], columns[1] - columns[0], rows[1] - rows[0]];
    (rectangle[2] > 0 && rectangle[3] > 0).then_some(rectangle)
}

/// The least and the largest quotient of the distances of two planes over a sphere: a plane of their pencil then touches it.
/// `None` if the sphere touches the plane `below` or is behind it: quotients have no bounds.
fn extent(above: DVec4, below: DVec4, centre: DVec4, radius: f64) -> Option<[f64; 2]> {
    let square = radius * radius;
    let [a, b, c] = [(above, above), (above, below), (below, below)].map(|(p, q)| p.truncate().dot(q.truncate()));
    let [height, over] = [above.dot(centre), below.dot(centre)];
    if over <= radius * c.sqrt() * (1.0 + SLACK) {
        return None;
    }
    // (height − t over)² = radius² |above − t below|²
    let [first, half, last] = [over * over - square * c, height * over - square * b, height * height - square * a];
    let root = (half * half - first * last).max(0.0).sqrt();
    let ends = [half - root, half + root].map(|end| end / first);
    ends.iter().all(|end| end.is_finite()).then_some(ends)
}
