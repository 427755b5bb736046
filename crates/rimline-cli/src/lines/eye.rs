//! The eye of a drawing.

use rimline::Origin;
use rimline_lines::{LinesError, Object, View};
use rimline_picture::Bounds;

use super::args::LinesArgs;
use crate::coordinates::relative;
use crate::failure::{Failure, InputError, UsageError};
use crate::side::{Side, up_of};

/// A view, and what it was made of.
#[derive(Clone, Copy)]
pub(crate) struct Eye {
    pub(crate) view: View,
    /// A point, or the direction towards an eye at infinity.
    at: [f32; 3],
    /// The target of an eye at a point.
    target: Option<[f32; 3]>,
    up: [f32; 3],
    turned: f64,
}

/// The corners of the faces of objects that are finite.
pub(crate) fn corners(objects: &[Object<'_>]) -> Vec<[f32; 3]> {
    let of_object = |object: &'_ Object<'_>| {
        let faces = object.mesh.faces().iter().flatten();
        faces.filter_map(|&vertex| object.positions.get(vertex as usize).copied()).collect::<Vec<_>>()
    };
    objects.iter().flat_map(of_object).filter(|corner| corner.iter().all(|c| c.is_finite())).collect()
}

impl Eye {
    /// The eye that the options ask for, or that sees all corners.
    pub(crate) fn new(args: &LinesArgs, origin: Origin, corners: &[[f32; 3]]) -> Result<Self, Failure> {
        let failed = Failure::input(&args.files[0]);
        let bounds = Bounds::of(corners).ok_or_else(|| failed(InputError::NoFiniteFace))?;
        let of = |at, target, up| Self::of(at, target, up).map_err(|error| failed(InputError::Lines(error)));
        let middle = [0, 1, 2].map(|axis| f64::from(bounds.min[axis]) / 2.0 + f64::from(bounds.max[axis]) / 2.0);
        let nearest = |point: [f64; 3]| point.map(|c| c as f32);
        if let Some(eye) = args.eye {
            let eye = relative(eye, origin);
            let target = args.target.map_or(nearest(middle), |target| relative(target, origin));
            if eye == target {
                let is_given = args.target.is_some();
                let error = if is_given { UsageError::EyeAtTarget } else { UsageError::EyeInMiddle };
                return Err(error.into());
            }
            let up = up_of([0, 1, 2].map(|axis| f64::from(eye[axis]) - f64::from(target[axis])));
            if args.ortho {
                return of([0, 1, 2].map(|axis| eye[axis] - target[axis]), None, up);
            }
            return of(eye, Some(target), up);
        }
        let (towards_eye, up) = args.view.directions();
        let Some(degrees) = args.fov else {
            return of(nearest(towards_eye), None, up);
        };
        // A ball around all fits into the field of view.
        let length = |v: [f64; 3]| libm::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        let radius = corners.iter().map(|corner| length([0, 1, 2].map(|axis| f64::from(corner[axis]) - middle[axis])));
        let distance = radius.fold(f64::MIN_POSITIVE, f64::max) / libm::sin(f64::from(degrees).to_radians() / 2.0);
        let size = length(towards_eye);
        let eye = [0, 1, 2].map(|axis| middle[axis] + distance / size * towards_eye[axis]);
        of(nearest(eye), Some(nearest(middle)), up)
    }

    fn of(at: [f32; 3], target: Option<[f32; 3]>, up: [f32; 3]) -> Result<Self, LinesError> {
        let view = match target {
            Some(target) => View::perspective(at, target, up)?,
            None => View::orthographic(at, up)?,
        };
        Ok(Self { view, at, target, up, turned: 0.0 })
    }

    /// Moved to the right around what it looks at, by an angle in degrees about a vertical line.
    pub(crate) fn turned(&self, degrees: f64) -> Result<Self, LinesError> {
        if degrees == 0.0 {
            return Ok(*self);
        }
        let (sine, cosine) = (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()));
        let turn = |v: [f32; 3]| {
            let [x, y, z] = v.map(f64::from);
            [cosine * x + sine * z, y, cosine * z - sine * x].map(|c| c as f32)
        };
        let around = self.target.unwrap_or_default();
        let from = turn([0, 1, 2].map(|axis| self.at[axis] - around[axis]));
        let turned = Self::of([0, 1, 2].map(|axis| around[axis] + from[axis]), self.target, turn(self.up))?;
        Ok(Self { turned: degrees, ..turned })
    }

    /// The offset to add to a point of the page of an eye at infinity, so that it is relative to the origin of the files.
    pub(crate) fn page_of_origin(&self, origin: Origin) -> [f64; 2] {
        self.view.page(origin.to_array())
    }

    /// From where it looks, in words.
    pub(crate) fn said(&self, args: &LinesArgs) -> String {
        let how = if self.view.is_perspective() { "perspective" } else { "orthographic" };
        let turned = if self.turned == 0.0 { String::new() } else { format!(", turned by {}°", self.turned) };
        match (args.eye, args.view) {
            (Some(_), _) => format!("{how} view of an eye at {:?}", self.view.eye().xyz),
            (None, Side::Named(name, _)) => format!("{how} view, {name}{turned}"),
            (None, Side::Angles(azimuth, elevation)) => {
                format!("{how} view, azimuth {azimuth}°, elevation {elevation}°{turned}")
            }
        }
    }
}
