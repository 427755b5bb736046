//! Whether what a map may darken is apart from what is seen or lit, in `f64`. docs/numerics/depth-maps.md.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};

use crate::shadow::DepthDirection;
use crate::{Cone, Light, ShadowCamera};

/// By how much frusta are widened: in device coordinates.
const MARGIN: f64 = 1e-4;
/// By how much directions are spread, for rays that are parallel.
const SPREAD: f64 = 1e-6;
/// What rounding may add: a share of lengths.
const SLACK: f64 = 1e-12;

/// The convex hull of points, and of what is in some directions from them without end.
#[derive(Clone, Debug)]
pub(super) struct Convex {
    points: Vec<DVec3>,
    directions: Vec<DVec3>,
    /// Directions of its edges, and normals of its sides, any length and sign. They are tried, and prove nothing.
    edges: Vec<DVec3>,
    normals: Vec<DVec3>,
}

/// The corners of a picture, in their order around it.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

impl Convex {
    /// All that a camera sees from its near plane on, without an end, and so much more to the sides, in device coordinates.
    pub(super) fn frustum(camera: &ShadowCamera, more: [f64; 2]) -> Self {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let (inverse, origin): (DMat4, _) = (matrix.inverse(), Vec3::from_array(camera.origin).as_dvec3());
        let (near, away) = match camera.depth {
            DepthDirection::Reversed => (1.0 + MARGIN, -1.0),
            DepthDirection::Standard => (-MARGIN, 1.0),
        };
        // A place, and how it moves as depth grows.
        let ray = |[x, y]: [f64; 2]| {
            let [x, y] = [x * (1.0 + MARGIN + more[0]), y * (1.0 + MARGIN + more[1])];
            let (at, step): (DVec4, DVec4) = (inverse * DVec4::new(x, y, near, 1.0), inverse.z_axis);
            let direction = away * (at.w * step.truncate() - step.w * at.truncate());
            (origin + at.truncate() / at.w, direction.normalize())
        };
        let rays = CORNERS.map(ray);
        let points = rays.map(|(point, _)| point);
        let centre = points.iter().sum::<DVec3>() / 4.0;
        let radius = points.iter().map(|point| (point - centre).length()).fold(0.0, f64::max);
        let directions = rays.map(|(point, direction)| direction + SPREAD * (point - centre) / radius);
        let sides = [points[1] - points[0], points[2] - points[1]];
        let mut normals = vec![sides[0].cross(sides[1])];
        normals.extend((0..4).map(|at| (points[(at + 1) % 4] - points[at]).cross(directions[at])));
        let edges = [&sides[..], &directions[..]].concat();
        Self { points: points.to_vec(), directions: directions.to_vec(), edges, normals }
    }

    /// All that a map of `size` texels can darken. The far border is half a texel outside of the picture, and may be moved by as
    /// much.
    pub(super) fn shadow(camera: &ShadowCamera, size: [u32; 2]) -> Self {
        Self::frustum(camera, size.map(|texels| 2.0 / f64::from(texels)))
    }

    /// A box by its lowest and its highest corner.
    pub(super) fn cuboid([low, high]: [[f32; 3]; 2]) -> Self {
        let [low, high] = [low, high].map(|corner| Vec3::from_array(corner).as_dvec3());
        let corner =
            |number: u32| DVec3::from_array([0, 1, 2].map(|axis| [low, high][(number >> axis & 1) as usize][axis]));
        let axes = vec![DVec3::X, DVec3::Y, DVec3::Z];
        Self { points: (0..8).map(corner).collect(), directions: Vec::new(), edges: axes.clone(), normals: axes }
    }

    /// The lowest height along a vector, if there is one.
    fn lowest(&self, along: DVec3) -> f64 {
        if self.directions.iter().any(|direction| direction.dot(along) < -SLACK * along.length()) {
            return f64::NEG_INFINITY;
        }
        let size = self.points.iter().map(|point| point.length()).fold(0.0, f64::max);
        let lowest = self.points.iter().map(|point| point.dot(along)).fold(f64::INFINITY, f64::min);
        lowest - SLACK * size * along.length()
    }

    /// Whether a plane at right angles to a vector has the one on its one side and the other on the other.
    fn is_apart_along(&self, other: &Self, along: DVec3) -> bool {
        let along = along.normalize_or_zero();
        along != DVec3::ZERO && [along, -along].into_iter().any(|along| -self.lowest(-along) < other.lowest(along))
    }

    /// Whether they have no point in common. If they are near to each other, this may not find it.
    pub(super) fn is_apart(&self, other: &Self) -> bool {
        let crossed = self.edges.iter().flat_map(|edge| other.edges.iter().map(|of| edge.cross(*of)));
        let mut tried = self.normals.iter().chain(&other.normals).copied().chain(crossed);
        tried.any(|along| self.is_apart_along(other, along))
    }

    /// Whether all of it is beyond the range of a light or outside its cone. If little of it is within, this may not find it.
    pub(super) fn is_unlit(&self, light: &Light) -> bool {
        let w = f64::from(light.w);
        if w <= 0.0 {
            return false;
        }
        let place = Vec3::from_array(light.xyz).as_dvec3() / w;
        let range = f64::from(light.range);
        let from_place = || self.points.iter().map(|point| point - place);
        // The distance is at least that of any plane before it.
        let is_beyond = |along: DVec3| {
            let along = along.normalize_or_zero();
            self.lowest(along) - place.dot(along) > range * (1.0 + MARGIN) + SLACK * place.length()
        };
        let normals = self.normals.iter().flat_map(|&normal| [normal, -normal]);
        if range.is_finite() && normals.chain(from_place()).any(is_beyond) {
            return true;
        }
        light.cone.is_some_and(|cone| self.is_outside(place, cone))
    }

    /// Whether it is outside a cone of less than 90° from its axis.
    fn is_outside(&self, apex: DVec3, Cone { axis, cosine }: Cone) -> bool {
        let (axis, cosine) = (Vec3::from_array(axis).as_dvec3().normalize_or_zero(), f64::from(cosine));
        if cosine <= 0.0 || axis == DVec3::ZERO {
            return false;
        }
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let around: Vec<_> =
            self.points.iter().map(|point| point - apex).chain(self.directions.iter().copied()).collect();
        let size = self.points.iter().map(|point| point.length()).fold(apex.length(), f64::max);
        let ahead = self.directions.iter().sum::<DVec3>().normalize_or_zero();
        // A plane through the apex, with the cone strictly behind it and nothing of the other. Sides meet in the apex, and are
        // turned a little, so that rounding does not matter.
        let divides = |along: DVec3| {
            let along = (along.normalize_or_zero() + MARGIN * ahead).normalize_or_zero();
            along.dot(axis) < -sine - SPREAD && around.iter().all(|at| at.dot(along) >= SLACK * size)
        };
        self.normals.iter().flat_map(|&normal| [normal, -normal]).chain([ahead, -axis]).any(divides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from -1 to 1.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }

        /// A camera at a place, and its matrix, right for places less the origin.
        fn camera(&mut self) -> ShadowCamera {
            let (place, forward) = (4.0 * self.vector(), self.vector().normalize());
            let view = glam::camera::rh::view::look_to_mat4(place.as_vec3(), forward.as_vec3(), Vec3::Y);
            let projection = if self.next() > 0.0 {
                glam::camera::rh::proj::directx::perspective_infinite_reverse(0.8, 1.3, 0.2)
            } else {
                Mat4::from_cols_array_2d(&[
                    [0.8, 0.0, 0.0, 0.0],
                    [0.0, 1.1, 0.0, 0.0],
                    [0.0, 0.0, 0.05, 0.0],
                    [0.0, 0.0, 1.0, 1.0],
                ])
            };
            let (view_projection, depth) = ((projection * view).to_cols_array_2d(), DepthDirection::Reversed);
            ShadowCamera { view_projection, origin: [0.0; 3], depth }
        }
    }

    /// Whether a camera without a far plane sees a place.
    fn sees(camera: &ShadowCamera, place: DVec3) -> bool {
        let clip = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4() * place.extend(1.0);
        clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z <= clip.w
    }

    /// Places that a camera sees, near and far.
    fn seen(camera: &ShadowCamera, numbers: &mut Numbers) -> Vec<DVec3> {
        let inverse = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
        let mut place = |_| {
            let depth = (0.5 * numbers.next() + 0.5).powi(3);
            let at = inverse * DVec4::new(numbers.next(), numbers.next(), depth, 1.0);
            at.truncate() / at.w
        };
        (0..400).map(&mut place).collect()
    }

    #[test]
    fn bodies_that_are_apart_have_no_place_in_common() {
        println!("seed 1681");
        let mut numbers = Numbers(1681);
        let (mut apart, mut met, mut unknown) = (0, 0, 0);
        for _ in 0..2000 {
            let [light, eye] = [numbers.camera(), numbers.camera()];
            let (low, size) = (6.0 * numbers.vector(), numbers.vector().abs() * 3.0);
            let corners = [low, low + size].map(|corner| corner.as_vec3().to_array());
            let shadow = Convex::frustum(&light, [0.0; 2]);
            let places = seen(&light, &mut numbers);
            let is_in_box = |place: &DVec3| place.cmpge(low).all() && place.cmple(low + size).all();
            let frustum = (Convex::frustum(&eye, [0.0; 2]), places.iter().any(|place| sees(&eye, *place)));
            let cuboid = (Convex::cuboid(corners), places.iter().any(is_in_box));
            for (other, is_common) in [frustum, cuboid] {
                let is_apart = shadow.is_apart(&other);
                assert!(!(is_apart && is_common), "{light:?} {eye:?} {corners:?}");
                assert_eq!(is_apart, other.is_apart(&shadow));
                *(if is_apart {
                    &mut apart
                } else if is_common {
                    &mut met
                } else {
                    &mut unknown
                }) += 1;
            }
        }
        println!("{apart} apart, {met} with a common place, {unknown} without a proof");
        assert!(apart > 1000 && met > 500 && unknown < apart / 3);
    }

    #[test]
    fn shadows_at_the_border_of_a_map_are_in_what_it_may_darken() {
        println!("seed 1683");
        let mut numbers = Numbers(1683);
        let mut outside = 0;
        for _ in 0..2000 {
            let camera = numbers.camera();
            let inverse = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
            let size = [0; 2].map(|_: u32| (5.5 + 4.5 * numbers.next()) as u32 + 1);
            // Texels across and down, from the middle of the picture's edge on: a sample within, and the far one half a texel
            // outside.
            let axis = usize::from(numbers.next() > 0.0);
            let sign = if numbers.next() > 0.0 { 1.0 } else { -1.0 };
            let texel = size.map(|texels| 2.0 / f64::from(texels));
            let along = numbers.next();
            // Several bits move both by less than half a texel.
            let moved = [0; 2].map(|_: u32| 0.49 * numbers.next());
            let ray = |outward: f64| {
                let mut at = [along; 2];
                at[axis] = sign * (1.0 + outward * texel[axis]);
                let [x, y] = [0, 1].map(|axis| at[axis] + moved[axis] * texel[axis]);
                let place = |depth: f64| {
                    let at = inverse * DVec4::new(x, y, depth, 1.0);
                    at.truncate() / at.w
                };
                let (near, next) = (place(1.0), place(0.9));
                (near, (next - near).normalize())
            };
            let ((sample, direction), (_, far)) = (ray(-0.5), ray(0.5));
            let vertex = sample + (1.0 + numbers.next()) * direction;
            // On the triangle between them, and behind it.
            let place = vertex + 40.0 * (1.0 + numbers.next()) * far + (1.0 + numbers.next()) * direction;
            let corners = [-1e-3, 1e-3].map(|by| (place + by).as_vec3().to_array());
            let there = Convex::cuboid(corners);
            assert!(!Convex::shadow(&camera, size).is_apart(&there), "{camera:?} {size:?} {place}");
            outside += u32::from(Convex::frustum(&camera, [0.0; 2]).is_apart(&there));
        }
        println!("{outside} outside of the picture");
        assert!(outside > 200);
    }

    #[test]
    fn what_a_light_does_not_reach_has_no_lit_place() {
        println!("seed 1682");
        let mut numbers = Numbers(1682);
        let (mut unlit, mut lit, mut unknown) = (0, 0, 0);
        for _ in 0..2000 {
            let map = numbers.camera();
            let inverse = Mat4::from_cols_array_2d(&map.view_projection).as_dmat4().inverse();
            // Where its rays meet, as a rule.
            let meeting = inverse * DVec4::Z;
            let is_there = numbers.next() > -0.8 && meeting.w != 0.0;
            let place = if is_there { meeting.truncate() / meeting.w } else { 4.0 * numbers.vector() };
            let mut light = Light::point(place.as_vec3().to_array());
            if numbers.next() > 0.0 {
                light.range = 0.01 + 2.0 * numbers.next().abs().powi(3) as f32;
            } else {
                light.cone =
                    Some(Cone::new(numbers.vector().as_vec3().to_array(), 0.1 + 1.6 * numbers.next().abs() as f32));
            }
            let is_lit = |at: &DVec3| {
                let from = *at - Vec3::from_array(light.xyz).as_dvec3();
                from.length() <= f64::from(light.range)
                    && light.cone.is_none_or(|Cone { axis, cosine }| {
                        let axis = Vec3::from_array(axis).as_dvec3().normalize();
                        from.normalize().dot(axis) >= f64::from(cosine)
                    })
            };
            let is_unlit = Convex::frustum(&map, [0.0; 2]).is_unlit(&light);
            let is_common = seen(&map, &mut numbers).iter().any(is_lit);
            assert!(!(is_unlit && is_common), "{map:?} {light:?}");
            *(if is_unlit {
                &mut unlit
            } else if is_common {
                &mut lit
            } else {
                &mut unknown
            }) += 1;
        }
        println!("{unlit} unlit, {lit} with a lit place, {unknown} without a proof");
        assert!(unlit > 400 && lit > 400 && unknown < unlit / 2);
    }
}
