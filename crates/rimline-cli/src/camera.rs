//! The camera of a picture, and the outermost points of a scene, to which the camera is fitted.

use glam::{DQuat, DVec3, Vec3};
use rimline::gltf::{CameraProjection, SceneCamera};
use rimline_picture::{Bounds, Camera};

use crate::failure::{EYE_AT_TARGET, EYE_TOO_FAR, Failure};
use crate::input_args::PlacedView;
use crate::spec::Side;

/// The default azimuth: degrees to the right of the model's front, which is +Z.
pub(crate) const AZIMUTH: f64 = 33.0;
/// The share of the picture's width or height that the model takes: a tenth is left on each side.
const FILLED: f64 = 0.8;

/// The camera of the command line, or of a file if `args` has one. Its picture holds all `points`, unless a file or `--eye`
/// with perspective gives the eye. Without `--eye` and `--view` it looks from `elevation` degrees above the horizon.
pub(crate) fn camera(
    args: &PlacedView,
    elevation: f64,
    bounds: &Bounds,
    points: impl Iterator<Item = [f32; 3]> + Clone,
) -> Result<Camera, Failure> {
    if let Some(file_camera) = &args.camera {
        return Ok(of_file(file_camera, args.size));
    }
    let vector = |p: [f32; 3]| Vec3::from(p).as_dvec3();
    let mut target = args.target.map_or(bounds.centre().as_dvec3(), vector);
    let scale_y = 1.0 / (f64::from(args.fov).to_radians() / 2.0).tan();
    let extent = f64::from(bounds.extent());
    let [width, height] = args.size.map(f64::from);
    let (azimuth, elevation) = (AZIMUTH.to_radians(), elevation.to_radians());
    let side = args.side.map(Side::directions);
    let backward = match (args.eye, side) {
        (Some(eye), _) => (vector(eye) - target).try_normalize().ok_or_else(|| Failure::usage(EYE_AT_TARGET))?,
        (None, Some((towards_eye, _))) => DVec3::from(towards_eye).normalize(),
        (None, None) => DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos()),
    };
    let view = View::new(-backward, side.map(|(_, up)| vector(up)), [scale_y * height / width, scale_y]);
    let nearest = extent * 1e-3;
    if args.is_parallel {
        let is_given = args.target.is_some() || args.eye.is_some();
        return Ok(view.parallel(target, is_given, points.map(vector), height / width));
    }
    let distance = if let Some(eye) = args.eye {
        (vector(eye) - target).length()
    } else {
        let (aside, distance) = view.fit(target, args.target.is_some(), points.map(vector), nearest);
        target += aside;
        distance
    };
    let eye = args.eye.map_or((target + backward * distance).as_vec3(), Vec3::from);
    let camera = view.camera(eye, view.scale, distance.min(extent) * 1e-3, None);
    // Floats end before the eye of a very narrow view.
    let is_finite = camera.eye.is_finite() && camera.scale.iter().all(|scale| scale.is_finite());
    if is_finite { Ok(camera) } else { Err(Failure::usage(EYE_TOO_FAR)) }
}

/// A camera of a file, for a picture of this size, which decides its aspect ratio. A far plane of a perspective camera is
/// ignored. Negative magnifications of an orthographic one do not mirror it.
pub(crate) fn of_file(camera: &SceneCamera, size: [u32; 2]) -> Camera {
    let [eye, forward, up] = [camera.eye, camera.forward, camera.up].map(Vec3::from);
    let [width, height] = size.map(|pixels| pixels as f32);
    let (scale_y, near, far) = match camera.projection {
        CameraProjection::Perspective { yfov, znear, .. } => ((0.5 * yfov).tan().recip(), znear, None),
        CameraProjection::Orthographic { ymag, znear, zfar, .. } => (ymag.abs().recip(), znear, Some(zfar)),
    };
    Camera { eye, right: forward.cross(up), up, forward, scale: [scale_y * height / width, scale_y], near, far }
}

/// The outermost points of a scene in 24 turns about a vertical line through `axis`, by default through the middle of their
/// bounds. A camera that sees all of them sees the scene all along an orbit about that line.
pub(crate) fn swept(points: &[[f32; 3]], axis: Option<Vec3>) -> Vec<[f32; 3]> {
    const STEPS: u32 = 24;
    let Some(bounds) = Bounds::of(points) else { return Vec::new() };
    let outermost = outermost(points, bounds.centre());
    let axis = axis.unwrap_or(bounds.centre()).as_dvec3();
    let turned = |step: u32| {
        let turn = DQuat::from_rotation_y((360.0 * f64::from(step) / f64::from(STEPS)).to_radians());
        outermost.iter().map(move |&point| (axis + turn * (DVec3::from(point.map(f64::from)) - axis)).as_vec3())
    };
    (0..STEPS).flat_map(turned).map(Into::into).collect()
}

/// The axes and the scale of a camera without a position.
struct View {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    scale: [f64; 2],
}

impl View {
    fn new(forward: DVec3, up: Option<DVec3>, scale: [f64; 2]) -> Self {
        // For a view straight up or down, the right of the picture is +X, unless `up` is given.
        let right = forward.cross(up.unwrap_or(DVec3::Y)).try_normalize();
        let right = right.filter(|_| up.is_some() || forward.y.abs() < 0.999_999).unwrap_or(DVec3::X);
        let up = right.cross(forward);
        Self { right, up, forward, scale }
    }

    fn camera(&self, eye: Vec3, scale: [f64; 2], near: f64, far: Option<f64>) -> Camera {
        let [right, up, forward] = [self.right, self.up, self.forward].map(DVec3::as_vec3);
        let (scale, near, far) = (scale.map(|scale| scale as f32), near as f32, far.map(|far| far as f32));
        Camera { eye, right, up, forward, scale, near, far }
    }

    /// How far right, up and forward of the target a point is.
    fn seen(&self, target: DVec3, point: DVec3) -> [f64; 3] {
        let p = point - target;
        [p.dot(self.right), p.dot(self.up), p.dot(self.forward)]
    }

    /// An orthographic camera whose picture holds all points, in its middle unless the target `is_given`. They lie between near and
    /// far plane.
    fn parallel(&self, target: DVec3, is_given: bool, points: impl Iterator<Item = DVec3>, aspect: f64) -> Camera {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        points.map(|point| DVec3::from(self.seen(target, point))).for_each(|seen| {
            (low, high) = (low.min(seen), high.max(seen));
        });
        let middle = if is_given { DVec3::ZERO } else { 0.5 * (low + high) };
        let half = (high - middle).max(middle - low);
        let (size, depth) = ((half.x * aspect).max(half.y), high.z - low.z);
        // All points may be one, or on a line that is seen end on.
        let size = if size > 0.0 { size } else { depth.max(f64::from(f32::MIN_POSITIVE)) };
        let room = depth.max(size);
        let eye = target + self.right * middle.x + self.up * middle.y + self.forward * (low.z - room);
        let scale = FILLED / size;
        self.camera(eye.as_vec3(), [scale * aspect, scale], 0.5 * room, Some(depth + 2.0 * room))
    }

    /// The nearest eye from which the picture holds all points, in its middle unless the target `is_given`. No point is
    /// nearer to the eye than `least`, measured forward. Returns the offset from the target to the point that it looks at,
    /// and its distance from that point.
    fn fit(&self, target: DVec3, is_given: bool, points: impl Iterator<Item = DVec3>, least: f64) -> (DVec3, f64) {
        // An eye at (x, y) a distance d before the target sees (a, b, z) where |a − x| s ≤ FILLED (z + d) and the like for
        // b: each side of the picture bounds d + x s / FILLED or d − x s / FILLED from below by its outermost point.
        let (mut sides, mut nearest) = ([[f64::NEG_INFINITY; 2]; 2], f64::INFINITY);
        for point in points {
            let [x, y, z] = self.seen(target, point);
            for (axis, c) in [x, y].into_iter().enumerate() {
                let aside = c * self.scale[axis] / FILLED;
                sides[axis] = [sides[axis][0].max(aside - z), sides[axis][1].max(-aside - z)];
            }
            nearest = nearest.min(z);
        }
        if is_given || nearest == f64::INFINITY {
            // Twice as far as needed, since a far target makes the near plane as far away as `least`.
            let behind_near = least.max(2.0 * least - nearest);
            return (DVec3::ZERO, sides.into_iter().flatten().fold(behind_near, f64::max));
        }
        let wanted = sides.iter().map(|[high, low]| 0.5 * (high + low)).fold(f64::NEG_INFINITY, f64::max);
        let middle = |axis: usize| 0.5 * (sides[axis][0] - sides[axis][1]) * FILLED / self.scale[axis];
        (self.right * middle(0) + self.up * middle(1), wanted.max(least - nearest))
    }
}

/// The elevation of the default camera in degrees: `usual`, or more for flat models, up to 45.
pub(crate) fn elevation(usual: f64, bounds: &Bounds) -> f64 {
    const STEEP: f64 = 45.0;
    let [x, y, z] = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).to_array();
    let upright = (4.0 * y / x.min(z).max(f64::MIN_POSITIVE)).min(1.0);
    STEEP + (usual - STEEP) * upright
}

/// The number of directions of [`outermost`], beside the axes and the diagonals.
const DIRECTIONS: u32 = 128;

/// Finds, for each of [`directions`], the point that lies farthest that way from `centre`. These points are few, have no
/// order, and have the same bounds as all points. Others may lie outside of their hull: on a ball by a hundredth of its
/// size, at the tip of a flat cone by a ninth.
pub(crate) fn outermost(points: &[[f32; 3]], centre: Vec3) -> Vec<[f32; 3]> {
    let centre = centre.as_dvec3();
    let directions: Vec<DVec3> = directions().collect();
    let mut farthest = vec![(f64::NEG_INFINITY, None); directions.len()];
    for &point in points {
        let from_centre = DVec3::from(point.map(f64::from)) - centre;
        for (direction, (most, found)) in directions.iter().zip(&mut farthest) {
            let height = direction.dot(from_centre);
            if height > *most {
                (*most, *found) = (height, Some(point));
            }
        }
    }
    let mut found: Vec<[f32; 3]> = farthest.into_iter().filter_map(|(_, found)| found).collect();
    found.sort_unstable_by_key(|point| point.map(f32::to_bits));
    found.dedup();
    found
}

/// The axes, the diagonals, and directions that are spread evenly in a spiral.
fn directions() -> impl Iterator<Item = DVec3> {
    let sides = [-1.0, 0.0, 1.0];
    let grid = sides.into_iter().flat_map(move |x| sides.into_iter().map(move |y| (x, y)));
    let grid = grid.flat_map(move |(x, y)| sides.into_iter().map(move |z| DVec3::new(x, y, z)));
    let spiral = (0..DIRECTIONS).map(|number| {
        let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let y = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(DIRECTIONS);
        let (sine, cosine) = (f64::from(number) * golden_angle).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        DVec3::new(radius * cosine, y, radius * sine)
    });
    grid.filter(|direction| *direction != DVec3::ZERO).chain(spiral)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};

    fn args(options: &str) -> PlacedView {
        let line = format!("rimline draw a.glb --out a.png {options}");
        match Cli::parse_from(line.split_whitespace()).command {
            Command::Draw(args) => args.view.relative_to(rimline::Origin::ZERO),
            _ => panic!("draw was asked for"),
        }
    }

    const AROUND: Bounds = Bounds { min: Vec3::splat(9.0), max: Vec3::splat(11.0) };

    fn cube() -> impl Iterator<Item = [f32; 3]> + Clone {
        AROUND.corners().into_iter().map(|corner| corner.to_array())
    }

    #[test]
    fn the_default_shows_every_point_and_wastes_little() {
        for options in ["", "--size 300x900 --fov 70", "--size 900x300", "--fov 100", "--fov 150", "--fov 5"] {
            let camera = camera(&args(options), 17.0, &AROUND, cube()).expect("it has an eye");
            let mut sides = [[0.0_f32; 2]; 2];
            let widest = cube()
                .map(|point| {
                    let p = Vec3::from(point) - camera.eye;
                    let distance = p.dot(camera.forward);
                    assert!(distance > camera.near);
                    let x = p.dot(camera.right) * camera.scale[0] / distance;
                    let y = p.dot(camera.up) * camera.scale[1] / distance;
                    for (side, c) in sides.iter_mut().zip([x, y]) {
                        *side = [side[0].min(c), side[1].max(c)];
                    }
                    x.abs().max(y.abs())
                })
                .fold(0.0, f32::max);
            // In the middle of what is wider, so margins are equal.
            let is_centred = sides.iter().any(|[low, high]| (low + high).abs() < 1e-3 && (high - widest).abs() < 1e-3);
            assert!(is_centred, "{options}: {sides:?}");
            assert!((widest - FILLED as f32).abs() < 1e-3, "{options}: {widest}");
        }
    }

    #[test]
    fn the_basis_is_right_handed_even_straight_down() {
        for options in ["--eye 10,50,10", "--eye 10,-50,10", "--eye -3,4,5"] {
            let camera = camera(&args(options), 17.0, &AROUND, cube()).expect("it has an eye");
            assert!((camera.right.cross(camera.up) + camera.forward).length() < 1e-5);
            assert!(camera.up.length() > 0.999);
        }
    }

    #[test]
    fn views_without_perspective_hold_every_point_between_their_planes() {
        for options in
            ["--view front", "--view top --size 300x900", "--view 200,-30", "--eye 9,50,3", "--target 9,9,9", ""]
        {
            let camera = camera(&args(&format!("--ortho {options}")), 17.0, &AROUND, cube()).expect("a camera");
            camera.shadow_camera().check().expect("a camera of shadows");
            assert!((camera.right.cross(camera.up) + camera.forward).length() < 1e-5, "{options}");
            let seen = |point: [f32; 3]| {
                let p = Vec3::from(point) - camera.eye;
                let far = camera.far.expect("a far plane");
                assert!(p.dot(camera.forward) > camera.near && p.dot(camera.forward) < far, "{options}");
                (p.dot(camera.right) * camera.scale[0]).abs().max((p.dot(camera.up) * camera.scale[1]).abs())
            };
            let widest = cube().map(seen).fold(0.0, f32::max);
            assert!((widest - FILLED as f32).abs() < 1e-3, "{options}: {widest}");
        }
    }

    #[test]
    fn an_orbit_about_a_target_sees_the_models_all_along() {
        let cube: Vec<[f32; 3]> = cube().collect();
        let target = Vec3::new(15.0, 10.0, 10.0);
        let swept = swept(&cube, Some(target));
        for options in ["--target 15,10,10", "--target 15,10,10 --ortho", "--target 15,10,10 --eye 15,12,25 --fov 60"] {
            let camera = camera(&args(options), 17.0, &AROUND, swept.iter().copied()).expect("it has an eye");
            for degrees in 0..360 {
                let camera = camera.turned(target, f64::from(degrees));
                for &point in &cube {
                    let p = Vec3::from(point) - camera.eye;
                    let ahead = p.dot(camera.forward);
                    assert!(ahead > camera.near && camera.far.is_none_or(|far| ahead < far), "{options}: {degrees}");
                    let distance = if camera.far.is_some() { 1.0 } else { ahead };
                    let [x, y] = [(camera.right, 0), (camera.up, 1)].map(|(way, axis)| p.dot(way) * camera.scale[axis]);
                    assert!(x.abs().max(y.abs()) < distance, "{options}: {degrees}");
                }
            }
        }
    }

    #[test]
    fn a_needle_along_the_view_is_behind_the_near_plane() {
        let needle: [[f32; 3]; 3] = [[1e-5, 0.0, 5.0], [-1e-5, 0.0, 5.0], [0.0, 1e-5, -5.0]];
        let bounds = Bounds::of(needle).expect("it is finite");
        for options in ["--view front", "--view front --target 0,0,0", "--view front --target 0,0,-4000"] {
            let camera = camera(&args(options), 17.0, &bounds, needle.into_iter()).expect("it has an eye");
            for point in needle {
                let ahead = (Vec3::from(point) - camera.eye).dot(camera.forward);
                assert!(ahead > camera.near, "{options}: {ahead} before {}", camera.near);
            }
        }
    }

    #[test]
    fn what_lies_flat_is_seen_from_higher() {
        let of = |y| elevation(17.0, &Bounds { min: Vec3::ZERO, max: Vec3::new(2.0, y, 1.0) });
        assert_eq!((of(0.0), of(0.25), of(7.0)), (45.0, 17.0, 17.0));
        assert!(of(0.1) > 25.0 && of(0.1) < 40.0);
    }

    #[test]
    fn an_eye_at_its_target_sees_nothing() {
        let camera = camera(&args("--eye 1,2,3 --target 1,2,3"), 17.0, &AROUND, cube());
        assert!(matches!(camera, Err(Failure::Usage(_))));
    }

    #[test]
    fn few_points_hold_the_rest() {
        // Points all over a ball.
        let ball: Vec<[f32; 3]> = (0..20_000)
            .map(|number: u32| {
                let t = f64::from(number) / 20_000.0;
                let (sine, cosine) = (f64::from(number) * 2.4).sin_cos();
                let radius = 2.0 * (t * (1.0 - t)).sqrt();
                [radius * cosine, 1.0 - 2.0 * t, radius * sine].map(|c| (100.0 + 3.0 * c) as f32)
            })
            .collect();
        let few = outermost(&ball, Vec3::splat(100.0));
        assert!(few.len() <= DIRECTIONS as usize + 26, "{} are left", few.len());
        assert_eq!(Bounds::of(&few), Bounds::of(&ball));
        for degrees in 0..360 {
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let direction = DVec3::new(cosine, 0.3 * sine, sine).normalize();
            let height = |p: &[f32; 3]| direction.dot(DVec3::from(p.map(f64::from)) - 100.0);
            let most = |points: &[[f32; 3]]| points.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
            assert!(most(&few) > 0.97 * most(&ball), "{degrees}: {} of {}", most(&few), most(&ball));
        }
    }

    #[test]
    fn a_box_keeps_its_corners() {
        let corners: Vec<[f32; 3]> = (0..8_u32).map(|n| [n & 1, n >> 1 & 1, n >> 2].map(|c| c as f32)).collect();
        assert_eq!(outermost(&corners, Vec3::splat(0.5)).len(), 8);
        assert!(outermost(&[], Vec3::ZERO).is_empty());
    }
}
