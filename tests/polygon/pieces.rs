//! The pieces that `cut_edges` and `cut_quads` list for twisted boundaries. They close, bit for bit. There are as many
//! as edges and their crossings, which are counted in integers. They wind around what is dark: the parity of the
//! triangles between.

use std::collections::BTreeMap;

use glam::DVec3;
use rimline::gpu::{Extractor, ExtractorOptions, PositionBuffer};
use rimline::internals::cpu::{Boundary, Orientation};
use rimline::mesh::Weld;
use rimline::{Light, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::{PolygonSet, boundary_in_planes, edge_on_polygon, folded_polygon, random_set};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, polygon_oracle, same, shadow_oracle};

use crate::lights::lights_for;

pub(crate) const TESTS: &[Test] = &[
    ("pieces_wind_once_around_what_is_dark", wind),
    ("pieces_of_boundaries_seen_edge_on_but_for_rounding", edge_on),
    ("pieces_of_boundaries_in_planes_with_the_light", in_planes),
];

/// Whether a point is in a triangle, or next to it.
fn is_on(point: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    let area = normal.length();
    let is_within = [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| (q - p).cross(point - p).dot(normal) > -1e-3 * area);
    area < 1e-6 || normal.dot(point - a).abs() < 1e-3 * area && is_within
}

fn double(point: [f32; 3]) -> DVec3 {
    DVec3::from(point.map(f64::from))
}

/// A piece as the GPU lists it: where it begins and ends, and the middle of its polygon.
pub(crate) type Listed = [[f32; 3]; 3];

fn extracted(gpu: &Gpu, set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> Result<Extractor, String> {
    let options = ExtractorOptions { max_lights: lights.len(), for_volumes: true, ..ExtractorOptions::default() };
    let buffer = gpu.storage(&set.positions);
    let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    gpu.submit(|encoder| extractor.encode(encoder, positions, lights).map_err(text))?;
    Ok(extractor)
}

/// How many pieces each of up to 32 lights has, and how many there is room for.
pub(crate) fn piece_counts(
    gpu: &Gpu,
    set: &PolygonSet,
    mesh: &Mesh,
    lights: &[Light],
) -> Result<(Vec<u32>, u32), String> {
    let extractor = extracted(gpu, set, mesh, lights)?;
    let buffer = extractor.pieces().first().ok_or("no pieces")?;
    Ok((gpu.read(buffer, lights.len())?, extractor.piece_capacity()))
}

fn listed(gpu: &Gpu, set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> Result<Vec<Vec<Listed>>, String> {
    let extractor = extracted(gpu, set, mesh, lights)?;
    let capacity = extractor.piece_capacity() as usize;
    let mut lists = Vec::new();
    for (batch, buffer) in extractor.pieces().iter().enumerate() {
        let words: Vec<u32> = gpu.read(buffer, usize::MAX)?;
        for light in 0..(lights.len() - 32 * batch).min(32) {
            let count = words[light] as usize;
            if count > capacity {
                return Err(format!("{count} pieces, and room for {capacity}"));
            }
            let words = &words[32 + 9 * light * capacity..][..9 * count];
            let point = |at: &[u32]| [0, 1, 2].map(|axis| f32::from_bits(at[axis]));
            lists.push(words.chunks(9).map(|at| [point(&at[..3]), point(&at[3..6]), point(&at[6..])]).collect());
        }
    }
    Ok(lists)
}

/// The bits of a point. Zeros have one sign.
pub(crate) fn bits(point: [f32; 3]) -> [u32; 3] {
    point.map(|c| (c + 0.0).to_bits())
}

/// The number of pieces that begin at a point, bit for bit, equals the number that end there.
pub(crate) fn check_closed(pieces: &[Listed]) -> Result<(), String> {
    let mut balance = BTreeMap::<[u32; 3], i32>::new();
    for &[from, to, _] in pieces {
        *balance.entry(bits(from)).or_default() += 1;
        *balance.entry(bits(to)).or_default() -= 1;
    }
    match balance.into_iter().find(|&(_, sum)| sum != 0) {
        None => Ok(()),
        Some((point, sum)) => Err(format!("{sum} pieces too many begin at {:?}", point.map(f32::from_bits))),
    }
}

/// A polygon that a light sees twisted, and its pieces.
pub(crate) struct Twisted {
    name: String,
    light: Light,
    /// The edges of the boundary, and the triangles.
    pub(crate) edges: Vec<[[f32; 3]; 2]>,
    triangles: Vec<[f32; 3]>,
    pub(crate) pieces: Vec<Listed>,
}

/// The twisted polygons of each light. No other polygon has pieces. Those with a common middle are left out.
pub(crate) fn twisted(gpu: &Gpu, set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> Result<Vec<Twisted>, String> {
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let position = |vertex: u32| set.positions[vertex as usize];
    let mut all = Vec::new();
    for (&light, list) in lights.iter().zip(listed(gpu, set, mesh, lights)?) {
        let mut pieces = BTreeMap::<_, Vec<Listed>>::new();
        for piece in list {
            pieces.entry(bits(piece[2])).or_default().push(piece);
        }
        let mut by_middle = BTreeMap::<_, Vec<usize>>::new();
        for polygon in (0..polygons.len()).filter(|&polygon| !polygons.boundary(polygon).is_empty()) {
            let edges = polygons.boundary(polygon);
            if Boundary::new(edges, &set.positions).ok_or("not finite")?.orientation(light) == Orientation::Twisted {
                let [a, b, c, d] = [0, 1, 2, 3].map(|quarter| position(edges[quarter * edges.len() / 4][0]));
                let middle = [0, 1, 2].map(|axis| ((a[axis] + b[axis]) + (c[axis] + d[axis])) * 0.25);
                by_middle.entry(bits(middle)).or_default().push(polygon);
            }
        }
        if let Some(middle) = pieces.keys().find(|middle| !by_middle.contains_key(*middle)) {
            return Err(format!("{light:?}: pieces around {:?}, where nothing is twisted", middle.map(f32::from_bits)));
        }
        for (middle, polygon) in by_middle.into_iter().filter(|(_, polygon)| polygon.len() == 1) {
            all.push(Twisted {
                name: format!("polygon {}, {light:?}", polygon[0]),
                light,
                edges: polygons.boundary(polygon[0]).iter().map(|edge| edge.map(position)).collect(),
                triangles: mesh.faces()[polygons.triangles(polygon[0])]
                    .iter()
                    .flatten()
                    .map(|&v| position(v))
                    .collect(),
                pieces: pieces.remove(&middle).unwrap_or_default(),
            });
        }
    }
    Ok(all)
}

impl Twisted {
    /// The pieces are as many as edges and their cuts.
    pub(crate) fn check_count(&self, cuts: &[usize]) -> Result<(), String> {
        let expected = self.edges.len() + cuts.iter().sum::<usize>();
        same(&format!("{}, pieces", self.name), &[self.pieces.len()], &[expected])
    }

    /// Directions from a point light, or points of a plane across a light at infinity, one unit before it.
    fn project(&self, point: [f32; 3]) -> DVec3 {
        let (point, light, w) = (double(point), double(self.light.xyz), f64::from(self.light.w));
        if w != 0.0 {
            return (point - light / w).normalize();
        }
        let l = light.normalize();
        (point - (point.dot(l) + 1.0) * l).normalize()
    }

    /// Whether the light is on the polygon or next to it, where rounding tells what it sees.
    fn is_lit_from_within(&self) -> bool {
        let (light, w) = (double(self.light.xyz), f64::from(self.light.w));
        let is_on = |corners: &[[f32; 3]]| is_on(light / w, [0, 1, 2].map(|corner| double(corners[corner])));
        w != 0.0 && self.triangles.chunks(3).any(is_on)
    }

    /// A point far beyond all corners, as seen from the light.
    fn beyond(&self, random: &mut Random) -> [f32; 3] {
        let extent = self.edges.iter().flatten().flatten().fold(0.0, |extent: f32, c| extent.max(c.abs()));
        let [corner, other] = [(); 2].map(|()| self.edges[random.below(self.edges.len())][0]);
        let part = random.between(-0.3, 1.3);
        let aim =
            |axis: usize| corner[axis] + part * (other[axis] - corner[axis]) + extent * random.between(-0.05, 0.05);
        let aim = [0, 1, 2].map(aim);
        let [x, y, z, w] = self.light.to_array();
        let away = if w == 0.0 { [-x, -y, -z] } else { [aim[0] - x / w, aim[1] - y / w, aim[2] - z / w] };
        let length = away.iter().map(|c| c * c).sum::<f32>().sqrt().max(1e-3 * extent);
        [0, 1, 2].map(|axis| aim[axis] + 100.0 * extent * away[axis] / length)
    }

    /// The winding number of the pieces at `p` less that at `q`. `None` where rounding may decide.
    fn winding_from(&self, q: [f32; 3], p: [f32; 3]) -> Option<i32> {
        let [q, p] = [q, p].map(|point| self.project(point));
        if p.dot(q) < -0.9 || p.dot(q) > 0.999_999 {
            return None;
        }
        let mut sum = 0;
        for &[from, to, _] in &self.pieces {
            let [a, b] = [from, to].map(|end| self.project(end));
            // 0 where rounding may decide.
            let side = |value: f64| i32::from(value > 1e-6) - i32::from(value < -1e-6);
            let [of_a, of_b] = [a, b].map(|end| side(q.cross(p).dot(end)));
            let [of_q, of_p] = [q, p].map(|end| side(a.cross(b).dot(end)));
            if of_a * of_b > 0 || of_q * of_p > 0 {
                continue;
            }
            if of_a * of_b * of_q * of_p == 0 && a.dot(p) > -0.5 {
                return None;
            }
            // Directions turn the other way round than points seen from the light. Not where they cross the opposite step.
            if of_a * of_p > 0 {
                sum -= of_p;
            }
        }
        Some(sum)
    }

    /// Steps between points beyond the polygon change the winding number of the pieces as they change the parity of the
    /// triangles between. Returns how many steps tell something, and in how many of these the parity changes.
    pub(crate) fn check_dark(&self, random: &mut Random, points: usize) -> Result<[usize; 2], String> {
        let mut counts = [0; 2];
        if self.light.w < 0.0 || self.is_lit_from_within() {
            return Ok(counts);
        }
        let faces: Vec<[u32; 3]> =
            (0..self.triangles.len() as u32 / 3).map(|face| [0, 1, 2].map(|v| 3 * face + v)).collect();
        let points: Vec<_> = (0..points).map(|_| self.beyond(random)).collect();
        let depths = shadow_oracle::shadow_depth(&self.triangles, &faces, &points, &[self.light]);
        for at in 1..points.len() {
            let Some(found) = self.winding_from(points[at - 1], points[at]) else { continue };
            let expected = depths[at] % 2 - depths[at - 1] % 2;
            if found != expected {
                let (name, from, to) = (&self.name, points[at - 1], points[at]);
                return Err(format!("{name}: {found} from {from:?} to {to:?}, expected {expected}"));
            }
            counts[0] += 1;
            counts[1] += usize::from(expected != 0);
        }
        Ok(counts)
    }

    /// The same with all pieces turned, and with one: where the former tells of darkness, both must fail.
    fn must_notice(&mut self, random: &Random) -> Result<(), String> {
        self.pieces.iter_mut().for_each(|piece| piece.swap(0, 1));
        must_fail("turned pieces", &self.check_dark(&mut random.clone(), 12))?;
        let length = |[from, to, _]: &Listed| double(*from).distance(double(*to));
        let longest = self.pieces.iter_mut().max_by(|p, q| length(p).total_cmp(&length(q))).ok_or("no piece")?;
        longest.swap(0, 1);
        must_fail("a turned piece", &check_closed(&self.pieces))
    }
}

fn wind() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 57_000;
    println!("seeds from {first}");
    let [mut pairs, mut quads, mut large, mut touching, mut around, mut steps, mut dark] = [0; 7];
    for seed in first..first + if is_long() { 400 } else { 24 } {
        let mut random = Random::new(seed);
        let most = [6, 8, 12, 24, 36][random.below(5)];
        let (mut set, mut lights) = (random_set(&mut random, most), Vec::new());
        for _ in 0..random.below(9) {
            set.push_points(&[folded_polygon(&mut random)]);
            let (points, light) = edge_on_polygon(&mut random);
            set.push_points(&[points]);
            lights.push(Light::point(light));
        }
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        let light_count = [2, 17, 25][random.below(3)];
        lights.extend(lights_for(&mut random, &set.positions, light_count));
        for mut polygon in twisted(gpu, &set, &mesh, &lights)? {
            let what = |error| format!("seed {seed}, {}: {error}", polygon.name);
            check_closed(&polygon.pieces).map_err(what)?;
            match polygon_oracle::cuts(&polygon.edges, polygon.light) {
                Some(cuts) => polygon.check_count(&cuts).map_err(|error| format!("seed {seed}: {error}"))?,
                None if polygon_oracle::find(&polygon.edges, polygon.light).touches => touching += 1,
                None => around += 1,
            }
            let before = random.clone();
            let counts = polygon.check_dark(&mut random, 12).map_err(|error| format!("seed {seed}: {error}"))?;
            pairs += 1;
            quads += usize::from(polygon.edges.len() == 4);
            large += usize::from(polygon.edges.len() > 32);
            (steps, dark) = (steps + counts[0], dark + counts[1]);
            if pairs % 16 == 0 && counts[1] > 0 {
                polygon.must_notice(&before)?;
            }
        }
    }
    println!("{pairs} twisted: {quads} quads, {large} large, {touching} touch themselves, {around} around the light");
    println!("{steps} steps between points, {dark} of them from light to dark or back");
    let are_enough = pairs > 1000 && quads.min(large).min(touching).min(around) > 20 && dark > 1000;
    if are_enough { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// Planar polygons that were turned, so that they are planar but for rounding, and lights in their planes but for rounding.
fn edge_on() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 207_000;
    println!("seeds from {first}");
    let (mut pairs, mut cut) = (0, 0);
    for seed in first..first + if is_long() { 1_000 } else { 40 } {
        let mut random = Random::new(seed);
        let (mut set, mut lights) = (PolygonSet::default(), Vec::new());
        for _ in 0..16 {
            let (points, light) = edge_on_polygon(&mut random);
            set.push_points(&[points]);
            lights.push(Light::point(light));
        }
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        for polygon in twisted(gpu, &set, &mesh, &lights)? {
            check_closed(&polygon.pieces).map_err(|error| format!("seed {seed}, {}: {error}", polygon.name))?;
            pairs += 1;
            cut += polygon.pieces.len() - polygon.edges.len();
        }
    }
    if pairs > 400 && cut > 4000 { Ok(()) } else { Err(format!("{pairs} twisted, {cut} cuts")) }
}

/// Corners in planes with the light but for some, so that it sees edges in line. Turns are those of the moved light,
/// and the order of cuts is.
fn in_planes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 700_000;
    let seeds = if is_long() { 1_000 } else { 60 };
    println!("seeds from {first}");
    let (mut touching, mut steps) = ([0; 2], 0);
    for (planes, others) in [(1, 1), (1, 2), (1, 5), (2, 0), (2, 1), (3, 0), (3, 1)] {
        let (mut pairs, mut open) = (0, [0; 2]);
        for seed in first..first + seeds {
            let mut random = Random::new(seed);
            let (points, light) = boundary_in_planes(&mut random, planes, others);
            // Fixed point holds whole numbers. Other edges in line are cut in their middles, which a light among them
            // may see on its other side.
            let is_whole = points.iter().flatten().all(|c| c.fract() == 0.0);
            let scale = if seed % 5 == 0 { (random.below(100) as f32 - 50.0).exp2() } else { 1.0 };
            let mut set = PolygonSet::default();
            set.push_points(&[points.into_iter().map(|point| point.map(|c| c * scale)).collect()]);
            let mesh = set.mesh(Weld::Position).map_err(text)?;
            if mesh.polygons().is_none() {
                continue;
            }
            let [x, y, z, w] = light.to_array();
            let light = if w == 0.0 { light } else { Light::point([x, y, z].map(|c| c * scale)) };
            let Some(polygon) = twisted(gpu, &set, &mesh, &[light])?.pop() else { continue };
            let what = format!("{planes} planes, {others} others, seed {seed}");
            let touches = polygon_oracle::find(&polygon.edges, light).touches;
            if let Some(cuts) = polygon_oracle::cuts(&polygon.edges, light) {
                polygon.check_count(&cuts).map_err(|error| format!("{what}: {error}"))?;
            }
            match check_closed(&polygon.pieces) {
                Ok(()) if !is_whole => {}
                Ok(()) => steps += polygon.check_dark(&mut random, 12).map_err(|error| format!("{what}: {error}"))?[0],
                Err(error) => {
                    println!("{what}, touches: {touches}: {error}");
                    open[usize::from(touches)] += 1;
                }
            }
            touching[usize::from(touches)] += 1;
            pairs += 1;
        }
        println!("{planes} planes, {others} others: {pairs} twisted, {open:?} open");
        // Boundaries that touch themselves in space, or have many edges through one point, need not close.
        if 4 * pairs < 3 * seeds || open[0] > 0 || planes == 1 && open[1] > 0 || 100 * open[1] > pairs {
            return Err(format!("{open:?} of {pairs} are open, of {planes} planes and {others} others"));
        }
    }
    println!("{touching:?} that do not touch themselves, and that do; {steps} steps between points");
    let are_enough = touching.iter().all(|&count| 4 * count > 3 * seeds) && steps > 1000;
    if are_enough { Ok(()) } else { Err(format!("too few: {touching:?}, {steps}")) }
}
