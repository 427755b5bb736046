//! Faces between a point and a light by brute force, written apart from `src/`: the light is really moved, by an epsilon
//! that is a power of two below every root of every polynomial that comes up, and the crossing is a point in a plane,
//! found and looked at along an axis. All in big integers.

use num_bigint::{BigInt, Sign};
use rimline::Light;

pub type Vector = [BigInt; 3];

/// A finite f32 as `mantissa · 2^exponent`; zero has the highest exponent there is, so that it never sets a scale.
fn decode(value: f32) -> (i32, i32) {
    let bits = value.to_bits();
    let (exponent, fraction) = ((bits >> 23 & 0xff) as i32, (bits & 0x7f_ffff) as i32);
    let (mantissa, exponent) = match (exponent, fraction) {
        (0, 0) => (0, i32::MAX),
        (0, _) => (fraction, -149),
        _ => (fraction | 1 << 23, exponent - 150),
    };
    (if bits >> 31 == 0 { mantissa } else { -mantissa }, exponent)
}

/// A finite value times 2^`exponent`, which must make an integer of it: `-least` does.
pub fn scaled(value: f32, exponent: i32) -> BigInt {
    let (mantissa, exponent_of_value) = decode(value);
    if mantissa == 0 { BigInt::ZERO } else { BigInt::from(mantissa) << (exponent_of_value + exponent) as usize }
}

/// The least power of two in these values; 0 where all are zero.
pub(crate) fn least(values: impl IntoIterator<Item = f32>) -> i32 {
    let exponents = values.into_iter().map(decode).filter(|&(mantissa, _)| mantissa != 0).map(|(_, exponent)| exponent);
    exponents.min().unwrap_or(0)
}

pub fn minus(p: &Vector, q: &Vector) -> Vector {
    std::array::from_fn(|axis| &p[axis] - &q[axis])
}

pub fn sign(value: &BigInt) -> i32 {
    match value.sign() {
        Sign::Plus => 1,
        Sign::NoSign => 0,
        Sign::Minus => -1,
    }
}

pub fn cross(u: &Vector, v: &Vector) -> Vector {
    std::array::from_fn(|axis| {
        let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
        &u[y] * &v[z] - &u[z] * &v[y]
    })
}

/// A light `(l, w)`, or a point, in the scale of a mesh.
#[derive(Clone)]
pub struct Homogeneous {
    pub xyz: Vector,
    pub w: BigInt,
}

impl Homogeneous {
    /// A light of which coordinates over w are times 2^scale.
    pub(crate) fn light(light: Light, scale: i32) -> Self {
        let [x, y, z, w] = light.to_array();
        // Exponent that makes integers of w and of the light's coordinates times 2^scale.
        let common = (-least([x, y, z]) - scale).max(-least([w])).max(0);
        Self { xyz: [x, y, z].map(|c| scaled(c, scale + common)), w: scaled(w, common) }
    }

    /// The light moved by (ε, ε², ε³). A determinant has products of two coordinates of these points with one of the
    /// light's or w and a coordinate. ε is below the inverse of any, with room for their sums.
    pub(crate) fn moved<'a>(&self, points: impl Iterator<Item = &'a Vector>) -> Self {
        let bits = |v: &Vector| v.iter().map(BigInt::bits).max().unwrap_or(0);
        let epsilon = 4 * (points.map(bits).max().unwrap_or(0) + bits(&self.xyz).max(self.w.bits())) + 64;
        let Self { mut xyz, mut w } = self.clone();
        xyz.iter_mut().chain([&mut w]).for_each(|c| *c <<= 3 * epsilon);
        for (axis, coordinate) in xyz.iter_mut().enumerate() {
            *coordinate += BigInt::from(1) << ((2 - axis as u64) * epsilon);
        }
        Self { xyz, w }
    }
}

/// A triangle that is not a line, with its normal.
pub struct Triangle {
    pub corners: [Vector; 3],
    normal: Vector,
}

impl Triangle {
    pub fn new(corners: [Vector; 3]) -> Option<Self> {
        let normal = cross(&minus(&corners[1], &corners[0]), &minus(&corners[2], &corners[0]));
        normal.iter().any(|n| sign(n) != 0).then_some(Self { corners, normal })
    }

    /// How far the homogeneous point lies before the plane.
    pub fn height(&self, point: &Homogeneous) -> BigInt {
        let a = &self.corners[0];
        (0..3).map(|axis| &self.normal[axis] * (&point.xyz[axis] - &point.w * &a[axis])).sum()
    }

    /// Whether a point of the plane, with positive w, lies in the triangle, its edges included.
    pub fn holds(&self, point: &Homogeneous) -> bool {
        let axis = (0..3).find(|&axis| sign(&self.normal[axis]) != 0).expect("it has a normal");
        let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
        let turn = sign(&self.normal[axis]);
        (0..3).all(|at| {
            let (from, to) = (&self.corners[at], &self.corners[(at + 1) % 3]);
            let to_point = |axis: usize| &point.xyz[axis] - &point.w * &from[axis];
            let area = (&to[y] - &from[y]) * to_point(z) - (&to[z] - &from[z]) * to_point(y);
            sign(&area) * turn >= 0
        })
    }

    /// Whether it lies between a point and the light, which touch it nowhere.
    fn is_between(&self, point: &Homogeneous, light: &Homogeneous, moved: &Homogeneous) -> bool {
        let (before, beyond) = (self.height(point), self.height(moved));
        if sign(&before) == 0 && self.holds(point) {
            return false;
        }
        if sign(&light.w) > 0 && sign(&self.height(light)) == 0 && self.holds(light) {
            return false;
        }
        if sign(&before) * sign(&beyond) >= 0 {
            return false;
        }
        let size = |value: &BigInt| if sign(value) < 0 { -value } else { value.clone() };
        let (before, beyond) = (size(&before), size(&beyond));
        let xyz = std::array::from_fn(|axis| &point.xyz[axis] * &beyond + &moved.xyz[axis] * &before);
        self.holds(&Homogeneous { xyz, w: &beyond + &moved.w * &before })
    }
}

/// The depth of each point for each light, as `rimline::internals::cpu::shadow_depth` lays them out.
pub fn shadow_depth(positions: &[[f32; 3]], faces: &[[u32; 3]], points: &[[f32; 3]], lights: &[Light]) -> Vec<i32> {
    let is_finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
    let coordinates = positions.iter().chain(points).filter(|p| is_finite(p)).flatten().copied();
    let scale = -least(coordinates);
    let integers = |p: &[f32; 3]| p.map(|c| scaled(c, scale));
    let triangles: Vec<Triangle> = faces
        .iter()
        .map(|face| face.map(|v| positions[v as usize]))
        .filter(|corners| corners.iter().all(is_finite))
        .filter_map(|corners| Triangle::new(corners.map(|p| integers(&p))))
        .collect();
    let points: Vec<_> = points.iter().map(|point| is_finite(point).then(|| integers(point))).collect();
    let all = || triangles.iter().flat_map(|triangle| &triangle.corners).chain(points.iter().flatten());
    let lights = lights.iter().map(|&light| Homogeneous::light(light, scale));
    let lights: Vec<_> = lights.map(|light| (light.clone(), light.moved(all()))).collect();
    let depths = points.iter().flat_map(|point| {
        let at = point.clone().map(|xyz| Homogeneous { xyz, w: BigInt::from(1) });
        let triangles = &triangles;
        lights.iter().map(move |(light, moved)| match &at {
            None => -1,
            Some(at) => triangles.iter().filter(|triangle| triangle.is_between(at, light, moved)).count() as i32,
        })
    });
    depths.collect()
}
