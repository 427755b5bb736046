//! Clusters of one to three faces, and lights, whose decision hangs on rounding.

use crate::random::Random;
use rimline::internals::clusters::{ClusterBound, Clusters};
use rimline::internals::cpu::Threads;
use rimline::{Light, Mesh};

use crate::pairs;

/// A face across an axis, so far away that even a tiny w counts, and a light along its plane.
fn far_away(random: &mut Random) -> pairs::Pair {
    let scale = random.between(30.0, 118.0).exp2();
    let (axis, level, corners) = pairs::across(random, scale);
    let w = random.between(-149.0, -58.0).exp2() * [1.0, random.between(1.0, 2.0), -1.0][random.below(3)];
    let mut light = random.direction();
    light[axis] *= [0.0, w * level, random.between(-1e-5, 1e-5), 1.0][random.below(4)];
    let [x, y, z] = light;
    (corners, Light::homogeneous([x, y, z, w]))
}

/// A face so long and thin that `f64` loses its normal, and a light around it. The sides are whole numbers.
fn needle(random: &mut Random) -> pairs::Pair {
    let mut lattice = |most: usize| [(); 3].map(|()| random.below(2 * most + 1) as f32 - most as f32);
    let (fine, side) = (lattice(7), lattice(7));
    let (small, long) = (random.between(-20.0, -10.0).floor().exp2(), random.between(20.0, 60.0).floor().exp2());
    let a = fine.map(|c| c * small);
    let b = std::array::from_fn(|i| a[i] + side[i]);
    let light = random.direction().map(|c| c * random.between(-3.0, 60.0).exp2());
    ([a, b, side.map(|c| c * long)], Light::point(light))
}

/// One to three faces that hardly differ, and a light.
fn case(random: &mut Random) -> (Vec<[[f32; 3]; 3]>, Light) {
    let (corners, mut light) = match random.below(10) {
        0 | 1 => far_away(random),
        2 => needle(random),
        _ => pairs::any(random),
    };
    let mut faces = vec![corners];
    for _ in 0..random.below(3) {
        let mut corners = corners;
        let coordinate = &mut corners[random.below(3)][random.below(3)];
        *coordinate = if random.below(2) == 0 { coordinate.next_up() } else { coordinate.next_down() };
        faces.push(corners);
    }
    // So small that results are flushed.
    if random.below(5) == 0 {
        let largest = corners.as_flattened().iter().chain(&light.xyz).fold(0.0_f32, |most, c| most.max(c.abs()));
        let by = (random.between(-124.0, -100.0) - largest.log2()).floor().exp2();
        faces.iter_mut().flatten().flatten().for_each(|c| *c *= by);
        light.xyz = light.xyz.map(|c| c * by);
    }
    (faces, light)
}

/// A cluster with a bound that decides, and a light.
pub struct Bounded {
    pub faces: Vec<[[f32; 3]; 3]>,
    pub light: Light,
    pub bound: ClusterBound,
}

/// A random one; nothing, where light or faces have no such bound.
pub fn bounded(random: &mut Random) -> Result<Option<Bounded>, String> {
    let (faces, light) = case(random);
    if light.to_array() == [0.0; 4] {
        return Ok(None);
    }
    let positions = faces.concat();
    let corners = (0..faces.len() as u32).map(|face| [0, 1, 2].map(|corner| 3 * face + corner)).collect();
    let mesh = Mesh::from_faces(positions.len(), corners).map_err(|error| error.to_string())?;
    let found = Clusters::new(&mesh, &positions, Threads::ONE);
    Ok(found.bounds().first().filter(|bound| bound.kind == 1).map(|&bound| Bounded { faces, light, bound }))
}
