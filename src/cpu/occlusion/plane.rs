//! Planes, and the exact side of a point. A filter in `f64` comes first.

use crate::cpu::extract::exact_facing::exact_facing;
use crate::light::Light;

/// More than the eight roundings of a determinant, and those of the bound itself: sixteen units of `f64`.
const BOUND: f64 = 16.0 * f64::EPSILON / 2.0;

/// The sign of a determinant of two fixed vectors and the vector from `from` to a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    normal: [f64; 3],
    /// The same products, all added up without their signs.
    sizes: [f64; 3],
    from: [f32; 3],
    to: [f32; 3],
    third: Third,
}

#[derive(Clone, Copy, Debug)]
enum Third {
    /// The plane contains the light: `det[b − a, x − a, l − w·a]`.
    Light([f32; 4]),
    /// The plane is a face's: `det[b − a, c − a, x − a]`.
    Corner([f32; 3]),
}

fn apart(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| f64::from(b[axis]) - f64::from(a[axis]))
}

fn cross(u: [f64; 3], v: [f64; 3]) -> [[f64; 3]; 2] {
    let products = |axis: usize| {
        let [y, z] = [(axis + 1) % 3, (axis + 2) % 3];
        [u[y] * v[z], u[z] * v[y]]
    };
    let normal = std::array::from_fn(|axis| products(axis)[0] - products(axis)[1]);
    let sizes = std::array::from_fn(|axis| products(axis)[0].abs() + products(axis)[1].abs());
    [normal, sizes]
}

impl Plane {
    /// The plane of an edge and the light.
    pub(crate) fn of_edge(a: [f32; 3], b: [f32; 3], light: Light) -> Self {
        let [l, w] = [light.xyz.map(f64::from), [f64::from(light.w); 3]];
        let to_light: [f64; 3] = std::array::from_fn(|axis| l[axis] - w[axis] * f64::from(a[axis]));
        let [normal, sizes] = cross(to_light, apart(a, b));
        Self { normal, sizes, from: a, to: b, third: Third::Light(light.to_array()) }
    }

    /// The plane of a face.
    pub(crate) fn of_face([a, b, c]: [[f32; 3]; 3]) -> Self {
        let [normal, sizes] = cross(apart(a, b), apart(a, c));
        Self { normal, sizes, from: a, to: b, third: Third::Corner(c) }
    }

    /// The value at a point that is off by so much along each axis, and the error's bound.
    pub(crate) fn value(&self, point: [f64; 3], off: f64) -> (f64, f64) {
        let x: [f64; 3] = std::array::from_fn(|axis| point[axis] - f64::from(self.from[axis]));
        let value: f64 = self.normal.iter().zip(x).map(|(n, x)| n * x).sum();
        let error: f64 = self.sizes.iter().zip(x).map(|(size, x)| size * (BOUND * x.abs() + off)).sum();
        (value, 2.0 * error)
    }

    /// The exact side of a finite point: 1, 0 or −1.
    pub(crate) fn side(&self, point: [f32; 3]) -> i32 {
        let x = apart(self.from, point);
        let sum = |of: [f64; 3], x: [f64; 3]| of[0] * x[0] + of[1] * x[1] + of[2] * x[2];
        let (value, size) = (sum(self.normal, x), sum(self.sizes, x.map(f64::abs)));
        if value.abs() > BOUND * size {
            return if value > 0.0 { 1 } else { -1 };
        }
        let [x, y, z] = point;
        match self.third {
            Third::Light(light) => exact_facing(self.from, self.to, point, light),
            Third::Corner(c) => exact_facing(self.from, self.to, c, [x, y, z, 1.0]),
        }
    }
}
