//! How many faces lie over each other as seen from a light: a bound that holds for every ray, where every face casts.
//!
//! The number N(r) of faces that a ray r meets is at least any count along it. If r moves, N changes only where r crosses an
//! edge at which faces begin or end, all turned to the light: by at most the sum of their signs there. So in a convex cell of
//! rays N is at most N of one of them, plus these sums for the edges that touch the cell, and at most the faces that touch it.
//! A cell with too large a bound is cut into four. A ray that meets too many faces ends the search. Signs and touching are
//! decided in `f64` with a slack; what is undecided counts. Around a vertex with many faces that share no edges, the bound is
//! their number. A bound for 8 bits of stencil: docs/numerics/receivers.md, "Bound on counts".

use rimline::Light;
use rimline::internals::cpu::is_finite;

use super::rays::{Cell, Rays, Side, may_meet};

/// Cells are cut into four so many times.
const MOST_CUTS: u32 = 24;
/// Faces and edges that are looked at for a light, besides some turns over all of them.
const MOST_WORK: usize = 1 << 26;

/// At most so many faces meet any ray from the light. If that is not above `enough`, it holds; else more may be there than that,
/// or it is not known.
pub(super) fn deepest(light: Light, positions: &[[f32; 3]], faces: &[[u32; 3]], enough: u32) -> u32 {
    let is_drawn = |face: &&[u32; 3]| face.iter().all(|&v| positions.get(v as usize).is_some_and(|&p| is_finite(p)));
    let faces: Vec<[u32; 3]> = faces.iter().filter(is_drawn).copied().collect();
    if faces.len() <= enough as usize {
        return faces.len() as u32;
    }
    let (mut rays, roots) = Rays::new(light, positions, faces);
    // The light is in the plane of a face that it is a corner of, and such faces count nowhere.
    let places = &rays.places;
    rays.faces.retain(|face| face.iter().all(|&v| places[v as usize] != glam::DVec3::ZERO));
    let all: Vec<u32> = (0..rays.faces.len() as u32).collect();
    let sides = rays.sides();
    let mut search = Search { rays, enough, left: MOST_WORK + 64 * (all.len() + sides.len()), most: 0 };
    for cell in roots {
        if search.most > enough {
            break;
        }
        search.cut(cell, &all, &sides, 0);
    }
    search.most
}

struct Search {
    rays: Rays,
    enough: u32,
    /// Work that may still be done.
    left: usize,
    /// The largest bound of a cell that was not cut.
    most: u32,
}

impl Search {
    /// Bounds the faces over each other in a cell, which may meet these faces and sides. From the middle ray to any other the number
    /// changes at sides alone.
    fn cut(&mut self, cell: Cell, faces: &[u32], sides: &[Side], cuts: u32) {
        let ray = cell.middle();
        let met = faces.iter().filter(|&&face| self.rays.meets(ray, face)).count();
        let crossed: usize = sides.iter().map(|side| side.weight as usize).sum();
        let bound = u32::try_from(faces.len().min(met + crossed)).unwrap_or(u32::MAX);
        let is_deep = met > self.enough as usize;
        let work = 4 * (faces.len() + sides.len());
        if bound <= self.enough || is_deep || cuts == MOST_CUTS || self.left < work {
            self.most = self.most.max(bound);
            return;
        }
        self.left -= work;
        for quarter in cell.quarters() {
            if self.most > self.enough {
                return;
            }
            let (planes, corners) = (quarter.planes(), quarter.corners());
            let rays = &self.rays;
            let near = |face: &u32| may_meet(rays.corners(*face), &planes, &corners);
            let faces: Vec<u32> = faces.iter().copied().filter(near).collect();
            let near = |side: &Side| may_meet(side.ends.map(|v| rays.places[v as usize]), &planes, &corners);
            let sides: Vec<Side> = sides.iter().copied().filter(near).collect();
            self.cut(quarter, &faces, &sides, cuts + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles for each square of a lattice in a plane at this height.
    fn sheet(height: f32, squares: u32, positions: &mut Vec<[f32; 3]>, faces: &mut Vec<[u32; 3]>) {
        let first = positions.len() as u32;
        let at = |n: u32| 2.0 * n as f32 / squares as f32 - 1.0;
        positions.extend((0..=squares).flat_map(|z| (0..=squares).map(move |x| [at(x), height, at(z)])));
        for z in 0..squares {
            for x in 0..squares {
                let a = first + z * (squares + 1) + x;
                faces.extend([[a, a + squares + 1, a + 1], [a + 1, a + squares + 1, a + squares + 2]]);
            }
        }
    }

    /// A sphere of two poles with many faces around each.
    fn sphere(segments: u32, rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mut positions = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
        for ring in 1..rings {
            let polar = std::f32::consts::PI * ring as f32 / rings as f32;
            positions.extend((0..segments).map(|segment| {
                let turn = std::f32::consts::TAU * segment as f32 / segments as f32;
                [polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()]
            }));
        }
        let at = |ring: u32, segment: u32| 2 + (ring - 1) * segments + segment % segments;
        let mut faces = Vec::new();
        for s in 0..segments {
            faces.extend([[0, at(1, s + 1), at(1, s)], [1, at(rings - 1, s), at(rings - 1, s + 1)]]);
            for r in 1..rings - 1 {
                faces.push([at(r, s), at(r, s + 1), at(r + 1, s)]);
                faces.push([at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)]);
            }
        }
        (positions, faces)
    }

    #[test]
    fn bounds_hold_and_are_not_far_off() {
        let above = [Light::point([0.1, 30.0, 0.2]), Light::directional([0.1, 1.0, 0.05])];
        for light in above {
            for layers in [1, 40, 300] {
                let (mut positions, mut faces) = (Vec::new(), Vec::new());
                (0..layers).for_each(|n| sheet(n as f32 / 256.0, 3, &mut positions, &mut faces));
                let found = deepest(light, &positions, &faces, 255);
                // A bound of at most 255 is valid, although a smaller one may exist.
                assert!(found >= layers, "{light:?}, {layers} layers: {found}");
                assert_eq!(found > 255, layers > 255, "{light:?}, {layers} layers: {found}");
            }
        }
    }

    #[test]
    fn poles_and_lights_within_are_no_layers() {
        let (positions, faces) = sphere(300, 30);
        for light in [[0.0, 3.0, 0.0], [0.0, 0.0, 0.0], [0.3, -0.2, 0.1], [0.0, 1.0, 0.0]] {
            let found = deepest(Light::point(light), &positions, &faces, 255);
            assert!((1..=255).contains(&found), "{light:?}: {found}");
        }
        // Every third face is left out: full of holes, around the light and beside it.
        let leaky: Vec<_> = faces.iter().enumerate().filter(|(n, _)| n % 3 != 0).map(|(_, face)| *face).collect();
        for light in [Light::point([0.0; 3]), Light::point([0.2, 0.9, 0.1]), Light::directional([0.3, 1.0, 0.2])] {
            let found = deepest(light, &positions, &leaky, 255);
            assert!((1..=255).contains(&found), "{light:?}: {found}");
        }
    }
}
