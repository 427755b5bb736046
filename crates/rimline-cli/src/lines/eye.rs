//! The eye of a drawing.

use glam::{DVec3, Vec3};
use rimline::Origin;
use rimline::gltf::{CameraProjection, SceneCamera};
use rimline_lines::{LinesError, Object, PageBox, View};
use rimline_picture::Bounds;

use super::args::LinesArgs;
use crate::coordinates::{self, relative};
use crate::failure::{EYE_AT_TARGET, EYE_TOO_FAR, Failure};
use crate::output::Line;
use crate::spec::{Side, up_of};

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
    /// The part of the page that is shown, if the options say so.
    shown: Option<Shown>,
    /// Lines nearer than this are not drawn. `None`: by the models.
    pub(crate) near: Option<f64>,
}

#[derive(Clone, Copy)]
struct Shown {
    middle: [f32; 3],
    half_height: f64,
}

/// The corners of the faces of objects that are finite.
pub(crate) fn corners(objects: &[Object<'_>]) -> Vec<[f32; 3]> {
    let of_object = |object: &'_ Object<'_>| {
        let faces = object.mesh.faces().iter().flatten();
        faces.filter_map(|&vertex| object.positions.get(vertex as usize).copied()).collect::<Vec<_>>()
    };
    objects.iter().flat_map(of_object).filter(|corner| corner.iter().all(|c| c.is_finite())).collect()
}

fn middle(bounds: &Bounds) -> DVec3 {
    0.5 * bounds.min.as_dvec3() + 0.5 * bounds.max.as_dvec3()
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().into()
}

fn double(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

impl Eye {
    /// The eye that the options ask for, or that sees all corners, which lie in `bounds`.
    pub(crate) fn new(
        args: &LinesArgs,
        origin: Origin,
        corners: &[[f32; 3]],
        bounds: &Bounds,
    ) -> Result<Self, Failure> {
        let refused = |error: LinesError| Failure::input(&args.files[0], error);
        let of = |at, target, up| Self::of(at, target, up).map_err(refused);
        let middle = middle(bounds);
        if let Some(eye) = args.eye {
            let eye = relative(eye, origin);
            let target = args.target.map_or(single(middle), |target| relative(target, origin));
            if eye == target {
                let middle = "--eye is in the middle of the models, where it looks by default; give --target";
                return Err(Failure::usage(if args.target.is_some() { EYE_AT_TARGET } else { middle }));
            }
            let up = up_of((double(eye) - double(target)).to_array());
            if args.ortho {
                let towards_eye = Vec3::from(eye) - Vec3::from(target);
                if !towards_eye.is_finite() {
                    return Err(Failure::usage(EYE_TOO_FAR));
                }
                return of(towards_eye.into(), None, up);
            }
            let half_height = args.fov.map(|degrees| libm::tan(f64::from(degrees).to_radians() / 2.0));
            let shown = half_height.map(|half_height| Shown { middle: target, half_height });
            return Ok(Self { shown, ..of(eye, Some(target), up)? });
        }
        let (towards_eye, up) = args.view.directions();
        let towards_eye = DVec3::from(towards_eye);
        let Some(degrees) = args.fov else {
            return of(single(towards_eye), None, up);
        };
        // A ball around all fits into the field of view.
        let radius = corners.iter().map(|&corner| (double(corner) - middle).length());
        let distance = radius.fold(f64::MIN_POSITIVE, f64::max) / libm::sin(f64::from(degrees).to_radians() / 2.0);
        let eye = single(middle + distance / towards_eye.length() * towards_eye);
        if !eye.iter().all(|c| c.is_finite()) {
            return Err(Failure::usage(EYE_TOO_FAR));
        }
        of(eye, Some(single(middle)), up)
    }

    /// The eye of a camera of the file. It goes around a point ahead of it, beside the middle of `bounds`.
    pub(crate) fn of_camera(camera: &SceneCamera, bounds: &Bounds) -> Result<Self, LinesError> {
        let SceneCamera { eye, forward, up, .. } = *camera;
        let ahead = (middle(bounds) - double(eye)).dot(double(forward)).max(bounds.extent().into());
        let target = single(double(eye) + ahead * double(forward));
        let shown = |half_height| Some(Shown { middle: target, half_height });
        Ok(match camera.projection {
            CameraProjection::Perspective { yfov, znear, .. } => Self {
                shown: shown(libm::tan(f64::from(yfov) / 2.0)),
                near: Some(znear.into()),
                ..Self::of(eye, Some(target), up)?
            },
            CameraProjection::Orthographic { ymag, .. } => {
                Self { shown: shown(f64::from(ymag).abs()), ..Self::of(forward.map(|c| -c), None, up)? }
            }
        })
    }

    fn of(at: [f32; 3], target: Option<[f32; 3]>, up: [f32; 3]) -> Result<Self, LinesError> {
        let view = match target {
            Some(target) => View::perspective(at, target, up)?,
            None => View::orthographic(at, up)?,
        };
        Ok(Self { view, at, target, up, turned: 0.0, shown: None, near: None })
    }

    /// Moved to the right around what it looks at, by an angle in degrees about a vertical line.
    pub(crate) fn turned(&self, degrees: f64) -> Result<Self, LinesError> {
        if degrees == 0.0 {
            return Ok(*self);
        }
        let (sine, cosine) = (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()));
        let turn = |v: [f32; 3]| {
            let [x, y, z] = v.map(f64::from);
            Vec3::from([cosine * x + sine * z, y, cosine * z - sine * x].map(|c| c as f32))
        };
        let around = Vec3::from(self.target.unwrap_or_default());
        let at = around + turn((Vec3::from(self.at) - around).into());
        let turned = Self::of(at.into(), self.target, turn(self.up).into())?;
        Ok(Self { turned: degrees, shown: self.shown, near: self.near, ..turned })
    }

    /// The part of the view's page that the options ask for, as wide as it is `aspect` times high.
    pub(crate) fn window(&self, aspect: f64) -> Option<PageBox> {
        let Shown { middle, half_height } = self.shown?;
        // A point that an eye looks at is in the middle, but for rounding.
        let is_perspective = self.view.is_perspective();
        let [x, y] = if is_perspective { [0.0; 2] } else { self.view.page(middle.map(f64::from)) };
        let half_width = half_height * aspect;
        Some(PageBox { low: [x - half_width, y - half_height], high: [x + half_width, y + half_height] })
    }

    /// From where it looks, in words.
    pub(crate) fn said(&self, args: &LinesArgs, origin: Origin) -> String {
        let how = if self.view.is_perspective() { "perspective" } else { "orthographic" };
        let turned = if self.turned == 0.0 { String::new() } else { format!(", turned by {}°", self.turned) };
        if let Some(camera) = &args.camera.wanted {
            return format!("{how} view of the camera {}{turned}", Line(camera));
        }
        match (args.eye, args.view) {
            (Some(_), _) if self.target.is_some() => {
                format!("{how} view of an eye at {}", coordinates::point(self.at, origin))
            }
            (Some(_), _) => format!("{how} view of an eye towards {}", coordinates::point(self.at, Origin::ZERO)),
            (None, Side::Named(name, _)) => format!("{how} view, {name}{turned}"),
            (None, Side::Angles(azimuth, elevation)) => {
                format!("{how} view, azimuth {azimuth}°, elevation {elevation}°{turned}")
            }
        }
    }
}
