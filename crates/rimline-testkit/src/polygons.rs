//! Polygons made by code: convex, concave, with holes, with bridges, nonplanar, twisted, degenerate.

use rimline::Light;
use rimline::mesh::{Mesh, MeshError, PolygonLoops, Weld};

use super::random::Random;

/// Positions and polygons over them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonSet {
    pub positions: Vec<[f32; 3]>,
    pub polygon_loops: Vec<u32>,
    pub loop_sizes: Vec<u32>,
    pub loop_corners: Vec<u32>,
}

impl PolygonSet {
    pub fn loops(&self) -> PolygonLoops<'_> {
        PolygonLoops {
            polygon_loops: &self.polygon_loops,
            loop_sizes: &self.loop_sizes,
            loop_corners: &self.loop_corners,
        }
    }

    pub fn mesh(&self, weld: Weld) -> Result<Mesh, MeshError> {
        Mesh::from_polygons_by_loop(&self.positions, self.loops(), weld)
    }

    /// Adds a polygon of these loops of vertices.
    pub fn push(&mut self, loops: &[Vec<u32>]) {
        self.polygon_loops.push(loops.len() as u32);
        for corners in loops {
            self.loop_sizes.push(corners.len() as u32);
            self.loop_corners.extend(corners);
        }
    }

    /// Adds a polygon with vertices of its own.
    pub fn push_points(&mut self, loops: &[Vec<[f32; 3]>]) {
        let loops: Vec<Vec<u32>> = loops
            .iter()
            .map(|points| {
                let first = self.positions.len() as u32;
                self.positions.extend(points);
                (first..self.positions.len() as u32).collect()
            })
            .collect();
        self.push(&loops);
    }

    /// Adds all of another set.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.polygon_loops.extend(&other.polygon_loops);
        self.loop_sizes.extend(&other.loop_sizes);
        self.loop_corners.extend(other.loop_corners.iter().map(|corner| first + corner));
    }

    /// The loops of each polygon, as vertices.
    pub fn polygons(&self) -> Vec<Vec<Vec<u32>>> {
        let (mut sizes, mut corners) = (self.loop_sizes.iter(), self.loop_corners.iter());
        let mut of_loop = |size: u32| corners.by_ref().take(size as usize).copied().collect();
        let loops = self.polygon_loops.iter();
        loops.map(|&count| sizes.by_ref().take(count as usize).map(|&size| of_loop(size)).collect()).collect()
    }
}

/// One random polygon with its name, of 3 to about `most` corners in its outer loop.
pub fn random_polygon(random: &mut Random, most: usize) -> (&'static str, PolygonSet) {
    let corners = 3 + random.below(most.max(4) - 2);
    let mut set = PolygonSet::default();
    let (name, loops) = match random.below(11) {
        0 => ("convex", vec![placed_ring(random, corners, 1.0, 1.0, 0.0)]),
        1 => ("concave", vec![placed_ring(random, corners, 0.3, 1.0, 0.0)]),
        2 | 3 => {
            let bump = [0.0, 1e-6, 1e-2, 0.3][random.below(4)];
            ("with holes", with_holes(random, corners, bump))
        }
        4 => {
            let bump = [1e-7, 1e-3, 0.1, 0.5, 2.0][random.below(5)];
            ("nonplanar", vec![placed_ring(random, corners, 0.5, 1.0, bump)])
        }
        5 => {
            let bump = [0.0, 0.1][random.below(2)];
            let mut outer = ring(random, corners, 1.0, 1.0, bump);
            let (p, q) = (random.below(corners), random.below(corners));
            outer.swap(p, q);
            ("bow tie", vec![placed(random, &outer)])
        }
        6 => ("any points", vec![(0..corners).map(|_| random.direction()).collect()]),
        7 => {
            let least = 3 + random.below(2);
            let reach = 1 + random.below(4);
            let count = corners.min(least + random.below(8));
            ("whole numbers", vec![(0..count).map(|_| lattice(random, reach)).collect()])
        }
        // On a staircase, whole numbers in one plane: straight corners, edges in line, and light in many planes.
        8 => ("staircase", vec![staircase(random, corners)]),
        9 => {
            bridged(random, corners, &mut set);
            return ("with a bridge", set);
        }
        _ => {
            let vertices = 3 + random.below(6);
            set.positions = (0..vertices).map(|_| lattice(random, 3)).collect();
            let loops = 1 + random.below(3);
            let loops: Vec<Vec<u32>> =
                (0..loops).map(|_| (0..3 + random.below(7)).map(|_| random.below(vertices) as u32).collect()).collect();
            set.push(&loops);
            return ("repeated vertices", set);
        }
    };
    set.push_points(&loops);
    (name, set)
}

fn placed_ring(random: &mut Random, corners: usize, least: f32, most: f32, bump: f32) -> Vec<[f32; 3]> {
    let ring = ring(random, corners, least, most, bump);
    placed(random, &ring)
}

/// A loop around the z axis, counter-clockwise, with radii from `least` to `most` and heights up to `bump`.
fn ring(random: &mut Random, corners: usize, least: f32, most: f32, bump: f32) -> Vec<[f32; 3]> {
    let start = random.between(0.0, 1.0);
    (0..corners)
        .map(|corner| {
            let angle = (corner as f32 + start) / corners as f32 * std::f32::consts::TAU;
            let radius = random.between(least, most);
            [radius * angle.cos(), radius * angle.sin(), random.between(-bump, bump)]
        })
        .collect()
}

fn with_holes(random: &mut Random, corners: usize, bump: f32) -> Vec<Vec<[f32; 3]>> {
    let outer = ring(random, corners.max(5), 0.9, 1.1, bump);
    let mut loops = vec![outer];
    for hole in 0..=random.below(3) {
        let count = 3 + random.below(6);
        let mut points = ring(random, count, 0.1, 0.2, bump);
        let angle = hole as f32 / 3.0 * std::f32::consts::TAU;
        for p in &mut points {
            *p = [p[0] + 0.4 * angle.cos(), p[1] + 0.4 * angle.sin(), p[2]];
        }
        // Now and then one that is wound as the outer loop is.
        if random.below(8) > 0 {
            points.reverse();
        }
        loops.push(points);
    }
    let turn = random.next_u64();
    loops.iter().map(|points| placed(&mut Random::new(turn), points)).collect()
}

/// Points in a random plane.
fn placed(random: &mut Random, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let x = random.direction();
    let y = random.direction();
    let z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let at = |p: &[f32; 3]| std::array::from_fn(|axis| p[0] * x[axis] + p[1] * y[axis] + p[2] * z[axis]);
    points.iter().map(at).collect()
}

fn lattice(random: &mut Random, reach: usize) -> [f32; 3] {
    std::array::from_fn(|_| random.below(2 * reach + 1) as f32 - reach as f32)
}

fn staircase(random: &mut Random, corners: usize) -> Vec<[f32; 3]> {
    let steps = corners.div_ceil(2).max(2);
    let slope = lattice(random, 2);
    let height = |x: f32, y: f32| slope[0] * x + slope[1] * y;
    let mut top: Vec<[f32; 2]> = Vec::new();
    for step in 0..steps {
        let y = 1.0 + random.below(3) as f32;
        top.push([step as f32, y]);
        top.push([step as f32 + 1.0, y]);
    }
    // From the right end of the bottom back along the top.
    let mut boundary = vec![[0.0, 0.0], [steps as f32, 0.0]];
    boundary.extend(top.into_iter().rev());
    boundary.dedup();
    boundary.into_iter().map(|[x, y]| [x, y, height(x, y)]).collect()
}

/// A ring with a hole, as one loop that walks an edge from the one to the other both ways.
fn bridged(random: &mut Random, corners: usize, set: &mut PolygonSet) {
    let bump = [0.0, 1e-3, 0.2][random.below(3)];
    let outer = ring(random, corners.max(4), 0.9, 1.1, bump);
    let mut hole = ring(random, 3 + corners / 3, 0.2, 0.5, bump);
    hole.reverse();
    let count = outer.len() as u32;
    let around = (0..=count).map(|at| at % count);
    let within = (0..=hole.len()).map(|at| count + (at % hole.len()) as u32);
    let walk: Vec<u32> = around.chain(within).collect();
    let turn = random.next_u64();
    set.positions = placed(&mut Random::new(turn), &[outer, hole].concat());
    set.push(&[walk]);
}

/// A closed torus of quadrilaterals. `bump` moves each vertex that far at most, so its faces are not planar.
pub fn quad_torus(random: &mut Random, rings: u32, segments: u32, bump: f32) -> PolygonSet {
    let mut set = PolygonSet::default();
    for ring in 0..rings {
        let (sin_u, cos_u) = (ring as f32 / rings as f32 * std::f32::consts::TAU).sin_cos();
        for segment in 0..segments {
            let (sin_v, cos_v) = (segment as f32 / segments as f32 * std::f32::consts::TAU).sin_cos();
            let radius = 1.0 + 0.4 * cos_v;
            let point = [radius * cos_u, 0.4 * sin_v, radius * sin_u];
            set.positions.push(point.map(|c| c + random.between(-bump, bump)));
        }
    }
    for ring in 0..rings {
        let (here, there) = (ring * segments, (ring + 1) % rings * segments);
        for v in 0..segments {
            let w = (v + 1) % segments;
            set.push(&[vec![here + v, here + w, there + w, there + v]]);
        }
    }
    set
}

/// A box of whole numbers, of six squares that are cut into `cuts²` squares each.
pub fn quad_box(cuts: u32) -> PolygonSet {
    let mut set = PolygonSet::default();
    for axis in 0..3 {
        for upper in [false, true] {
            for (i, j) in (0..cuts).flat_map(|i| (0..cuts).map(move |j| (i, j))) {
                let mut square = vec![[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
                if !upper {
                    square.reverse();
                }
                let points = square.into_iter().map(|[u, v]| {
                    let mut point = [0.0; 3];
                    point[axis] = if upper { cuts as f32 } else { 0.0 };
                    point[(axis + 1) % 3] = u as f32;
                    point[(axis + 2) % 3] = v as f32;
                    point
                });
                set.push_points(&[points.collect()]);
            }
        }
    }
    set
}

/// A polygon that is planar but for rounding, and a position for a light in its plane but for rounding.
pub fn edge_on_polygon(random: &mut Random) -> (Vec<[f32; 3]>, [f32; 3]) {
    let corners = 4 + random.below(29);
    let [u, v] = [random.direction(), random.direction()];
    let middle = [0, 1, 2].map(|_| random.between(-3.0, 3.0));
    let at = |x: f32, y: f32| [0, 1, 2].map(|axis| middle[axis] + x * u[axis] + y * v[axis]);
    let on_circle = |radius: f32, angle: f32| at(radius * angle.cos(), radius * angle.sin());
    let is_regular = random.below(2) == 0;
    let points = (0..corners)
        .map(|corner| {
            let radius = if is_regular { 1.0 } else { random.between(0.3, 1.0) };
            on_circle(radius, std::f32::consts::TAU * corner as f32 / corners as f32)
        })
        .collect();
    (points, on_circle(4.0, random.between(0.0, 6.0)))
}

/// A boundary whose corners are in `planes` planes through the light but for `others` of them, and that light. All is
/// exact: whole numbers, or planes of two axes.
pub fn boundary_in_planes(random: &mut Random, planes: usize, others: usize) -> (Vec<[f32; 3]>, Light) {
    let is_whole = planes > 1 || random.below(2) == 0;
    let is_far = random.below(2) == 0;
    let reach = [3, 20, 300][random.below(3)];
    let axis = random.below(3);
    // A number, or a coordinate.
    let any = |random: &mut Random| {
        if is_whole { (random.below(2 * reach + 1) as f32) - reach as f32 } else { random.between(-4.0, 4.0) }
    };
    let vector = |random: &mut Random| loop {
        let v = lattice(random, 2);
        if v != [0.0; 3] {
            break v;
        }
    };
    let (origin, sight) = (lattice(random, 4), vector(random));
    let spans: Vec<_> = (0..planes).map(|_| [if is_far { sight } else { vector(random) }, vector(random)]).collect();
    let is_ahead = random.below(2) == 0;
    let in_plane = |random: &mut Random| {
        let [mut along, aside] = [any(random), any(random)];
        if is_ahead {
            along = along.abs() + 1.0;
        }
        let [u, v] = spans[random.below(planes)];
        std::array::from_fn(|at| {
            if is_whole { origin[at] + along * u[at] + aside * v[at] } else { [along, aside, 0.0][(at + axis) % 3] }
        })
    };
    let count = 5 + random.below(24);
    let mut corners: Vec<[f32; 3]> = (0..count).map(|_| in_plane(random)).collect();
    for _ in 0..others {
        corners[random.below(count)] = std::array::from_fn(|_| any(random));
    }
    if random.below(4) == 0 {
        // It comes back to a corner.
        corners[random.below(count)] = corners[random.below(count)];
    }
    let aims: [f32; 3] = std::array::from_fn(|at| [1.0, 0.25, 0.0][(at + axis) % 3]);
    let light = match (is_whole, is_far) {
        (true, true) => Light::directional(sight),
        (true, false) => Light::point(if random.below(6) == 0 { corners[random.below(count)] } else { origin }),
        (false, true) => Light::directional(aims),
        (false, false) => Light::point([0, 1, 2].map(|at| [any(random), any(random), 0.0][(at + axis) % 3])),
    };
    (corners, light)
}

/// A polygon with whole coordinates whose edges run back and forth on few lines, so that they overlap in part.
pub fn folded_polygon(random: &mut Random) -> Vec<[f32; 3]> {
    let mut points = vec![lattice(random, 3)];
    let count = 6 + random.below(8);
    let mut along = lattice(random, 1);
    while points.len() < count {
        if random.below(4) == 0 {
            points.push(lattice(random, 3));
            along = lattice(random, 1);
            continue;
        }
        let last = points[points.len() - 1];
        let steps = random.below(7) as f32 - 3.0;
        points.push([0, 1, 2].map(|axis| last[axis] + steps * along[axis]));
    }
    points
}

/// Many random polygons together, and bodies of quadrilaterals.
pub fn random_set(random: &mut Random, most: usize) -> PolygonSet {
    let mut set = match random.below(4) {
        0 => {
            let bump = [0.0, 0.01, 0.1, 0.3][random.below(4)];
            quad_torus(random, 12, 8, bump)
        }
        1 => quad_box(1 + random.below(3) as u32),
        _ => PolygonSet::default(),
    };
    for _ in 0..5 + random.below(30) {
        set.append(&random_polygon(random, most).1);
    }
    set
}
