//! Faces and lights whose signs hang on rounding.

use rimline::Light;

use crate::random::Random;

pub type Pair = ([[f32; 3]; 3], Light);

/// Any of the kinds below.
pub fn any(random: &mut Random) -> Pair {
    [hard, grazing, tight, tiny_w][random.below(4)](random)
}

/// An axis, a coordinate on it, and a face of about this size across it there.
pub(crate) fn across(random: &mut Random, scale: f32) -> (usize, f32, [[f32; 3]; 3]) {
    let axis = random.below(3);
    let level = scale * random.between(-1.0, 1.0);
    let corners = [(); 3].map(|()| {
        let mut corner = random.direction().map(|c| c * scale);
        corner[axis] = level;
        corner
    });
    (axis, level, corners)
}

/// A face on a plane across an axis, and a light so far away along the plane that w may be lost: the sign hangs on it.
fn tiny_w(random: &mut Random) -> Pair {
    let scale = random.between(0.0, 39.0).exp2();
    let (axis, _, corners) = across(random, scale);
    let w = random.between(-149.0, -56.0).exp2() * [1.0, 1.0, random.between(1.0, 2.0), -1.0][random.below(4)];
    let mut light = random.direction();
    // From certain to nothing but w.
    light[axis] *= [0.0, w * scale, 1e-12, 1e-6][random.below(4)];
    let size = random.between(-8.0, 60.0).exp2();
    let [x, y, z] = light.map(|c| c * size);
    (corners, Light::homogeneous([x, y, z, w * size]))
}

/// A triangle, and a light that is nearly in its plane or nearly at a corner.
pub fn hard(random: &mut Random) -> Pair {
    let scale = random.between(-36.0, 30.0).exp2();
    let centre = random.direction().map(|c| c * scale * random.between(0.0, 12.0).exp2());
    let flat = random.below(4) == 0;
    let corners = [0; 3].map(|_| {
        let [x, y, z] = random.direction().map(|c| c * scale);
        [x + centre[0], if flat { centre[1] } else { y + centre[1] }, z + centre[2]]
    });
    let [a, b, c] = corners;
    let w = [0.0, 1.0, random.between(0.2, 5.0), random.between(-3.0, -0.1)][random.below(4)];
    let (s, t) = match random.below(2) {
        0 => (random.between(-2.0, 2.0), random.between(-2.0, 2.0)),
        _ => (random.between(-1e-5, 1e-5), random.between(-1e-5, 1e-5)),
    };
    let mut l: [f32; 3] = std::array::from_fn(|i| w * a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]));
    for _ in 0..random.below(4) {
        let at = random.below(3);
        l[at] = if random.below(2) == 0 { l[at].next_up() } else { l[at].next_down() };
    }
    (corners, Light::homogeneous([l[0], l[1], l[2], w]))
}

/// An ordinary triangle with a light from far above its plane to so near that `f32` cannot tell.
pub fn grazing(random: &mut Random) -> Pair {
    let corners: [[f32; 3]; 3] = [(); 3].map(|()| random.direction());
    let (s, t) = (random.between(-2.0, 2.0), random.between(-2.0, 2.0));
    let up = random.direction();
    let height = 10.0_f32.powf(random.between(-8.5, 0.0));
    let light = std::array::from_fn(|i| {
        let [a, b, c] = corners.map(|corner| corner[i]);
        a + s * (b - a) + t * (c - a) + height * up[i]
    });
    (corners, Light::point(light))
}

/// A light in the face's plane for which a face's bound is hardly more than P: the face stands on the diagonal of two
/// axes, one side along the diagonal, the other along the third axis, and the light lies on the other side of the
/// origin. Then |t| has its largest possible size on both axes, and both terms of P that are not zero cancel in D.
pub fn tight(random: &mut Random) -> Pair {
    let first = random.below(3);
    let (i, j, k) = (first, (first + 1) % 3, (first + 2) % 3);
    let scale = random.between(-20.0, 20.0).exp2();
    let mut near = |about: f32, by: f32| scale * (about + random.between(-by, by));
    let (mut a, mut b, mut c) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    // A little over a power of two a unit of the last place is largest beside the number.
    (a[i], a[j], a[k]) = (near(1.02, 0.02), -near(1.02, 0.02), near(0.0, 0.1));
    (b[i], b[j], b[k]) = (-near(0.5, 0.5), near(0.5, 0.5), a[k] + near(0.0, 1e-3));
    (c[i], c[j], c[k]) = (a[i] + near(0.0, 1e-3), a[j] + near(0.0, 1e-3), near(0.0, 1.0));
    let w = [0.0, 1.0, 1.0, random.between(0.3, 3.0)][random.below(4)];
    let far = scale * if w == 0.0 { random.between(0.5, 2.0) } else { random.between(0.1, 2.5) * w };
    let mut light = [0.0; 4];
    (light[i], light[j], light[k], light[3]) = (-far, far, w * a[k], w);
    // Into the plane: first nearly, along an axis of a large normal, then along that of a small one.
    for axis in [j, k] {
        into_plane([a, b, c], &mut light, axis);
    }
    ([a, b, c], Light::homogeneous(light))
}

/// Moves a light along an axis to where the determinant is as near zero as `f32` can have it.
fn into_plane([a, b, c]: [[f32; 3]; 3], light: &mut [f32; 4], axis: usize) {
    let [a, b, c] = [a, b, c].map(|corner| corner.map(f64::from));
    let [u, v] = [b, c].map(|corner| [corner[0] - a[0], corner[1] - a[1], corner[2] - a[2]]);
    let n: [f64; 3] = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        u[j] * v[k] - u[k] * v[j]
    });
    let w = f64::from(light[3]);
    let term = |i: usize| n[i] * (f64::from(light[i]) - w * a[i]);
    let rest = term((axis + 1) % 3) + term((axis + 2) % 3);
    let moved = w * a[axis] - rest / n[axis];
    if moved.is_finite() {
        light[axis] = moved as f32;
    }
}
