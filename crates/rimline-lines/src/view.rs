//! The eye, and the page that it sees.

use rimline::Light;

use crate::error::LinesError;

/// An eye with the axes of the page. Visibility depends on the eye alone, which is exact. The axes are `f64`; they only say
/// where a point is on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    eye: Light,
    right: [f64; 3],
    up: [f64; 3],
    /// From the eye into the scene.
    ahead: [f64; 3],
}

impl View {
    /// An eye at a point that looks at `target`. Pages are in tangents: right and up at a distance of 1 ahead of the
    /// eye. The point (0, 0) is the target's.
    ///
    /// # Errors
    /// [`LinesError::View`] for numbers that are not finite, a target at the eye, or an `up` along the line of sight.
    pub fn perspective(eye: [f32; 3], target: [f32; 3], up: [f32; 3]) -> Result<Self, LinesError> {
        let ahead = [0, 1, 2].map(|axis| f64::from(target[axis]) - f64::from(eye[axis]));
        Self::new(Light::point(eye), ahead, up)
    }

    /// An eye at infinity. `towards_eye` points from the scene to the eye and may have any length above 0. Pages are in
    /// the unit of the positions. The point (0, 0) is the origin's.
    ///
    /// # Errors
    /// [`LinesError::View`] for numbers that are not finite, a direction of length 0, or an `up` along it.
    pub fn orthographic(towards_eye: [f32; 3], up: [f32; 3]) -> Result<Self, LinesError> {
        Self::new(Light::directional(towards_eye), towards_eye.map(|c| -f64::from(c)), up)
    }

    fn new(eye: Light, ahead: [f64; 3], up: [f32; 3]) -> Result<Self, LinesError> {
        let ahead = unit(ahead).filter(|_| eye.xyz.iter().all(|c| c.is_finite())).ok_or(LinesError::View)?;
        let up = unit(up.map(f64::from)).ok_or(LinesError::View)?;
        let right = cross(ahead, up);
        if dot(right, right) < 1e-12 {
            return Err(LinesError::View);
        }
        let right = unit(right).ok_or(LinesError::View)?;
        Ok(Self { eye, right, up: cross(right, ahead), ahead })
    }

    /// The eye as a light: what faces it is seen from its front.
    pub fn eye(&self) -> Light {
        self.eye
    }

    /// Whether the eye is a point.
    pub fn is_perspective(&self) -> bool {
        self.eye.w != 0.0
    }

    /// How far ahead of the eye a point is; for an eye at infinity, ahead of the origin.
    pub fn depth(&self, point: [f64; 3]) -> f64 {
        dot(self.ahead, self.seen(point))
    }

    /// Where a point is on the page. A perspective eye needs a depth above 0; else the result means nothing.
    pub fn page(&self, point: [f64; 3]) -> [f64; 2] {
        let from_eye = self.seen(point);
        let [x, y] = [dot(self.right, from_eye), dot(self.up, from_eye)];
        if self.is_perspective() {
            let depth = dot(self.ahead, from_eye);
            [x / depth, y / depth]
        } else {
            [x, y]
        }
    }

    fn seen(&self, point: [f64; 3]) -> [f64; 3] {
        if self.is_perspective() { [0, 1, 2].map(|axis| point[axis] - f64::from(self.eye.xyz[axis])) } else { point }
    }
}

pub(crate) fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

pub(crate) fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// The vector with length 1, if it is finite and not 0.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.into_iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    let v = v.map(|c| c / largest);
    let length = dot(v, v).sqrt();
    (largest > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}
