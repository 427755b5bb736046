//! Casters in the tests of shadows: analytic ones and meshes, each on a ground.

use glam::{DVec2, DVec3};
use rimline_testkit::rays;
use rimline_testkit::shapes::Shape;

/// Half the side of the ground, which is a square at height 0.
const GROUND: f64 = 6.0;

pub(crate) enum World {
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    /// Around the y axis.
    Torus {
        centre: DVec3,
        major: f64,
        minor: f64,
    },
    Cuboid {
        centre: DVec3,
        half: DVec3,
    },
    Mesh(rays::Tracer<()>),
    /// Triangles alone, without a ground.
    Bare(rays::Tracer<()>),
}

impl World {
    pub(crate) fn mesh(shape: &Shape, scale: f64, centre: DVec3) -> Self {
        let corner = |v: u32| DVec3::from_array(shape.positions[v as usize].map(f64::from)) * scale + centre;
        Self::Mesh(rays::Tracer::build(shape.faces.iter().map(|face| (face.map(corner), ()))))
    }

    fn has_ground(&self) -> bool {
        !matches!(self, Self::Bare(_))
    }

    /// Whether a point is in the body, or below the ground.
    pub(crate) fn is_inside(&self, point: DVec3) -> bool {
        let is_in_body = match self {
            Self::Sphere { centre, radius } => point.distance(*centre) <= *radius,
            Self::Torus { centre, major, minor } => of_torus(point - centre, [*major, *minor]) <= 0.0,
            Self::Cuboid { centre, half } => (point - centre).abs().cmple(*half).all(),
            // Meshes are closed. The direction is no axis of theirs.
            Self::Mesh(tracer) | Self::Bare(tracer) => {
                let direction = DVec3::new(0.48, 0.6, 0.64);
                tracer.meetings((point, direction)).filter(|(t, _)| *t > 0.0).count() % 2 == 1
            }
        };
        (point.y <= 0.0 && self.has_ground()) || is_in_body
    }

    /// Where a ray meets the shape first, and the normal there.
    fn shape(&self, from: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
        match self {
            Self::Sphere { centre, radius } => sphere(from - centre, direction, *radius),
            Self::Torus { centre, major, minor } => torus(from - centre, direction, [*major, *minor]),
            Self::Cuboid { centre, half } => cuboid(from - centre, direction, *half),
            Self::Mesh(tracer) | Self::Bare(tracer) => {
                let (t, triangle) = tracer.nearest((from, direction))?;
                let [a, b, c] = triangle.corners;
                Some((t, (b - a).cross(c - a).normalize()))
            }
        }
    }

    /// Where a ray meets anything first, and the normal there, against the ray. The direction has length 1.
    pub(crate) fn first(&self, from: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
        let t = -from.y / direction.y;
        let at = from + t * direction;
        let ground =
            (self.has_ground() && t > 0.0 && at.x.abs() < GROUND && at.z.abs() < GROUND).then_some((t, DVec3::Y));
        let shape = self.shape(from, direction);
        let found = [ground, shape].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        found.map(|(t, normal)| (t, if normal.dot(direction) > 0.0 { -normal } else { normal }))
    }
}

/// The distance from a torus around the origin.
fn of_torus(at: DVec3, [major, minor]: [f64; 2]) -> f64 {
    DVec2::new(DVec2::new(at.x, at.z).length() - major, at.y).length() - minor
}

/// Where a ray meets a torus around the origin, and the normal there: by steps of its distance between where the ray
/// enters and leaves a sphere around it.
fn torus(from: DVec3, direction: DVec3, radii: [f64; 2]) -> Option<(f64, DVec3)> {
    let [enter, leave] = through(from, direction, radii[0] + radii[1] + 1e-6)?;
    let mut t = enter.max(0.0);
    for _ in 0..2000 {
        let at = from + t * direction;
        let distance = of_torus(at, radii);
        if t > leave {
            break;
        }
        if distance < 1e-9 {
            let slope = |axis: DVec3| of_torus(at + 1e-5 * axis, radii) - of_torus(at - 1e-5 * axis, radii);
            return Some((t, DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize()));
        }
        t += distance;
    }
    None
}

/// Where a line enters and leaves a sphere around the origin. The direction has length 1.
fn through(from: DVec3, direction: DVec3, radius: f64) -> Option<[f64; 2]> {
    let middle = -from.dot(direction);
    let aside = from + middle * direction;
    let half = radius * radius - aside.length_squared();
    (half >= 0.0).then(|| [middle - half.sqrt(), middle + half.sqrt()])
}

/// Where a ray meets a sphere around the origin, and the normal there. A ray from within meets it where it begins.
fn sphere(from: DVec3, direction: DVec3, radius: f64) -> Option<(f64, DVec3)> {
    if from.length() <= radius + 1e-9 {
        return Some((0.0, from.normalize()));
    }
    let [enter, _] = through(from, direction, radius)?;
    (enter >= 0.0).then(|| (enter, (from + enter * direction) / radius))
}

/// Where a ray meets a cuboid around the origin, and the normal there. A ray from within meets it where it begins.
fn cuboid(from: DVec3, direction: DVec3, half: DVec3) -> Option<(f64, DVec3)> {
    let outside = from.abs() - half;
    if outside.max_element() <= 1e-9 {
        return Some((0.0, axis(outside) * from.signum()));
    }
    let [first, second] = [-half, half].map(|side| (side - from) / direction);
    let (enters, leaves) = (first.min(second), first.max(second));
    let enter = enters.max_element();
    (enter >= 0.0 && enter <= leaves.min_element()).then(|| (enter, -axis(enters) * direction.signum()))
}

/// The axis of the largest component.
fn axis(of: DVec3) -> DVec3 {
    [DVec3::X, DVec3::Y, DVec3::Z][of.max_position()]
}
