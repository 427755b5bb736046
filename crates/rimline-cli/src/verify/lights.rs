//! Lights that are hard on a mesh, the same for the same mesh.

use rimline::Light;

/// Two batches of lights, the second not full.
pub(super) const COUNT: usize = 40;

/// Points and directions about the mesh, some of them on its vertices and edges, in its faces' planes, with other w.
pub(super) fn hard_lights(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Light> {
    let mut chance = Chance(0x5eed);
    let (centre, size) = extent(positions);
    (0..COUNT)
        .map(|index| {
            let away = [0; 3].map(|_| chance.between(-1.0, 1.0));
            let near: [f32; 3] = std::array::from_fn(|i| centre[i] + away[i] * 2.0 * size);
            let light = on_mesh(index, positions, faces, &mut chance).unwrap_or_else(|| match index % 4 {
                0 => Light::directional(away),
                1 => scaled(near, 2.5),
                2 => scaled(near, -0.7),
                _ => Light::point(near),
            });
            let is_light = light.to_array().iter().all(|c| c.is_finite()) && light.to_array() != [0.0; 4];
            if is_light { light } else { Light::directional([away[0], away[1], 1.0]) }
        })
        .collect()
}

/// The point, as a light of this weight.
fn scaled(point: [f32; 3], w: f32) -> Light {
    let [x, y, z] = point.map(|c| c * w);
    Light::homogeneous([x, y, z, w])
}

/// Every other light: on a vertex, on an edge, in a face's plane, at infinity in its plane, on its plane with a tiny w.
fn on_mesh(index: usize, positions: &[[f32; 3]], faces: &[[u32; 3]], chance: &mut Chance) -> Option<Light> {
    if index.is_multiple_of(2) {
        return None;
    }
    let [a, b, c] = (*faces.get(chance.below(faces.len()))?).map(|v| positions.get(v as usize).copied());
    let (a, b, c) = (a?, b?, c?);
    let (s, t) = (chance.between(-2.0, 2.0), chance.between(-2.0, 2.0));
    let plane: [f32; 3] = std::array::from_fn(|i| s * (b[i] - a[i]) + t * (c[i] - a[i]));
    Some(match index / 2 % 5 {
        0 => Light::point(a),
        1 => Light::point(std::array::from_fn(|i| 0.5 * (a[i] + b[i]))),
        2 => Light::point(std::array::from_fn(|i| a[i] + plane[i])),
        3 => Light::directional(plane),
        _ => scaled(std::array::from_fn(|i| a[i] + plane[i]), 1e-12),
    })
}

/// The middle of the finite positions' bounds, and the longest half side.
fn extent(positions: &[[f32; 3]]) -> ([f32; 3], f32) {
    let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position in positions.iter().filter(|position| position.iter().all(|c| c.is_finite())) {
        for axis in 0..3 {
            least[axis] = least[axis].min(position[axis]);
            most[axis] = most[axis].max(position[axis]);
        }
    }
    let half = |axis: usize| 0.5 * most[axis] - 0.5 * least[axis];
    let centre = std::array::from_fn(|axis| least[axis] + half(axis));
    (centre, half(0).max(half(1)).max(half(2)))
}

/// `SplitMix64`.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (self.next() >> 40) as f32 / (1_u64 << 24) as f32 * (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimline::MAX_LIGHTS;
    use rimline::internals::light::check_lights;

    #[test]
    fn they_are_lights_whatever_the_mesh() {
        let strange = [[0.0; 3], [f32::NAN, 1.0, f32::INFINITY], [f32::MAX, -f32::MAX, 1e-45]];
        for positions in [&strange[..], &strange[..1], &[]] {
            for faces in [&[[0, 1, 2]][..], &[]] {
                let lights = hard_lights(positions, faces);
                assert_eq!((lights.len(), check_lights(&lights, MAX_LIGHTS)), (COUNT, Ok(())));
                assert_eq!(lights, hard_lights(positions, faces));
            }
        }
    }
}
