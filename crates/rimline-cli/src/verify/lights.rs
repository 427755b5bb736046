//! Lights that are hard on a mesh, the same for the same mesh.

use rimline::Light;
use rimline::mesh::Bounds;
use rimline_bench::random::Random;

/// Two batches of lights, the second not full.
pub(super) const COUNT: usize = 40;

/// Points and directions about the mesh, some of them on its vertices and edges, in its faces' planes, with other w.
pub(super) fn hard_lights(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Light> {
    let mut chance = Random::new(0x5eed);
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
fn on_mesh(index: usize, positions: &[[f32; 3]], faces: &[[u32; 3]], chance: &mut Random) -> Option<Light> {
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
    let Some(Bounds { min, max }) = Bounds::of(positions) else { return ([f32::NAN; 3], f32::NAN) };
    let half = [0, 1, 2].map(|axis| 0.5 * max[axis] - 0.5 * min[axis]);
    ([0, 1, 2].map(|axis| min[axis] + half[axis]), half.into_iter().fold(0.0, f32::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimline::MAX_LIGHTS;
    use rimline::reference::light::check_lights;

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
