//! Vertices that `depth_surface`, `depth_walls` and `mesh_depth` give, against `f64` by independent code.
//! docs/numerics/depth-maps.md, "Rounding of positions", says what floats may be off by.

use std::collections::HashMap;

use bytemuck::Zeroable;
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::DepthMapOptions;
use rimline::internals::depth_map::{Placing, map_view};
use rimline::internals::layout::{DepthMapShape, DepthMapView, MeshDepthCaster, MeshDepthView};
use rimline::internals::stages::{DEPTH_SURFACE, DEPTH_WALLS, MESH_DEPTH, Stage};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::frames::vector;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::probe::{Bound, Probe};
use rimline_testkit::random::Random;
use rimline_testkit::textures::{depth_view, objects, texture};
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat;

use crate::boundary::sample;
use crate::contours::{UNIT, smooth, walls_of};
use crate::cube::{cube_of, merged, on_rays, parted};
use crate::maps::{Map, maps};
use crate::near_rectangles::ROUNDING;
use crate::parity::{any_eye, light, map};
use crate::picture::{EVERY_CELL, REVERSED, by, contours, differences};
use crate::rules::{CELL, Rule, SPLIT, TRIANGLES, listed, listed_of_cube};

pub(crate) const TESTS: &[Test] = &[
    ("vertices_of_boundaries_are_those_of_f64", of_maps),
    ("vertices_of_cubes_are_those_of_f64", of_cubes),
    ("vertices_of_walls_are_those_of_f64", of_walls),
    ("vertices_of_meshes_in_maps_are_those_of_f64", of_meshes),
];

/// Factor for products of small errors. `FLUSHED`: bound on results that are flushed to 0.
const HIGHER: f64 = 1.001;
const FLUSHED: f64 = 1e-36;

/// A vertex and the most that floats may be off it, component by component.
#[derive(Clone, Copy, Debug)]
struct Held {
    value: DVec4,
    bound: DVec4,
}

impl Held {
    /// How much of the bound something found is off by: more than 1 is wrong.
    fn share(&self, found: [f32; 4]) -> f64 {
        let shares = (DVec4::from_array(found.map(f64::from)) - self.value).abs() / self.bound;
        if shares.is_nan() { f64::INFINITY } else { shares.max_element() }
    }
}

/// Vertices that were compared, and those at infinity.
#[derive(Debug, Default)]
struct Tally {
    vertices: usize,
    far: usize,
    /// Largest part of the bound.
    worst: f64,
    /// Vertices for which a move by another 32 units in the last place of the largest component is noticed.
    noticed: usize,
}

impl Tally {
    fn add(&mut self, what: &str, held: &Held, found: [f32; 4]) -> Result<(), String> {
        let share = held.share(found);
        if share > 1.0 {
            return Err(format!("{what}: {found:?}, {share} of the bound away from {held:?}"));
        }
        self.worst = self.worst.max(share);
        self.vertices += 1;
        let mut moved = found;
        let largest = (0..4).max_by(|&a, &b| found[a].abs().total_cmp(&found[b].abs())).unwrap_or(0);
        moved[largest] *= 1.0 + 32.0 * ROUNDING as f32;
        self.noticed += usize::from(held.share(moved) > 1.0);
        Ok(())
    }

    fn check(&self, least: usize, least_far: usize) -> Result<(), String> {
        println!("{self:?}");
        let is_tried = self.vertices > least && self.far >= least_far;
        let is_sharp = self.worst > 0.05 && self.noticed * 2 > self.vertices;
        if is_tried && is_sharp { Ok(()) } else { Err(format!("not vacuous: {self:?}")) }
    }
}

/// The share and the constant that depths of a format move by.
fn steps(format: TextureFormat, depth: DepthDirection) -> [f64; 2] {
    let rule = Rule::new(EVERY_CELL, 1, depth == REVERSED, format);
    let is_share = rule.noise_exponents > 0;
    if is_share { [0.5_f64.powi(rule.noise_exponents as i32), 0.0] } else { [0.0, rule.noise.into()] }
}

/// How depths are moved away from the light: the multiple of slopes, and steps. Boundaries that are moved sideways
/// have slopes that are measured to one side.
#[derive(Clone, Copy)]
struct Moves {
    slope_bias: f64,
    steps: [f64; 2],
    spread: bool,
}

impl Moves {
    fn slope(&self, map: &Map, at: [i64; 2], step: [i64; 2]) -> f64 {
        let depth = |count: i64| sample(map, at[0] + count * step[0], at[1] + count * step[1]);
        let difference = |from: i64, to: i64| Some(depth(to)? - depth(from)?);
        if self.spread {
            // A slope goes on over two texels to one side.
            let side = |sign| Some(difference(0, sign)?.abs().min(difference(sign, 2 * sign)?.abs()));
            return side(-1).unwrap_or(0.0).max(side(1).unwrap_or(0.0));
        }
        match (difference(-1, 0), difference(0, 1)) {
            (Some(before), Some(after)) if before * after > 0.0 => before.abs().min(after.abs()),
            _ => 0.0,
        }
    }

    /// The moved depth of a texel, and what floats may be off by; `None` where it casts nothing.
    fn depth(&self, map: &Map, at: [i64; 2]) -> Option<(f64, f64)> {
        let depth = sample(map, at[0], at[1])?;
        let to_far = if map.is_reversed { depth } else { 1.0 - depth };
        let slopes = self.slope(map, at, [1, 0]) + self.slope(map, at, [0, 1]);
        let by = (self.slope_bias * slopes + self.steps[0] * depth + self.steps[1]).min(to_far / 2.0);
        let moved = if map.is_reversed { depth - by } else { depth + by };
        // A difference, the sum of both, its product, two sums; and the sum with the depth.
        Some((moved, ROUNDING * HIGHER * (5.0 * by + moved.abs())))
    }
}

/// From a map to the clip space of an eye.
struct Exact {
    /// Columns of x and y in device coordinates of the light, of 1, and of the depth.
    near: [DVec4; 3],
    depth: DVec4,
    /// The same for directions away from the light.
    far: [DVec4; 3],
    size: DVec2,
    jitter: DVec2,
}

impl Exact {
    /// `jitter` in parts of a texel, right and down.
    fn new(
        (light, size): (&ShadowCamera, [u32; 2]),
        (eye, format): (&ShadowCamera, TextureFormat),
        [right, down]: [f64; 2],
    ) -> Self {
        let matrix = |camera: &ShadowCamera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let origin = |camera: &ShadowCamera| DVec3::from_array(camera.origin.map(f64::from));
        let apart = origin(light) - origin(eye);
        let [share, constant] = steps(format, eye.depth);
        let sign = if eye.depth == REVERSED { -1.0 } else { 1.0 };
        let moved =
            DMat4::from_cols(DVec4::X, DVec4::Y, (1.0 - share) * DVec4::Z, DVec4::W + sign * constant * DVec4::Z);
        let to_eye = moved * matrix(eye);
        let position = |point: DVec4| to_eye * (point.truncate() + point.w * apart).extend(point.w);
        let direction = |point: DVec4| to_eye * point.truncate().extend(0.0);
        let to_light = matrix(light);
        let inverse = to_light.inverse();
        let [x, y, z, one] = [inverse.x_axis, inverse.y_axis, inverse.z_axis, inverse.w_axis];
        let far = if to_light.row(3).truncate() == DVec3::ZERO {
            [DVec4::ZERO, DVec4::ZERO, direction(if light.depth == REVERSED { -z } else { z })]
        } else {
            // The third homogeneous coordinate is where w is 0.
            [x, y, one].map(|column| direction(column - column.w / z.w * z))
        };
        let size = DVec2::from_array(size.map(f64::from));
        let jitter = 2.0 * DVec2::new(right, -down) / size;
        Self { near: [x, y, one].map(position), depth: position(z), far, size, jitter }
    }

    /// The vertex at a position in texels, of which (0, 0) is the middle of the first, with a depth and what it may be off
    /// by; far without. `off` is what the position itself may be off by, in texels.
    fn vertex(&self, texel: DVec2, depth: Option<(f64, f64)>, off: f64) -> Held {
        let twice = 2.0 * texel + 1.0 - self.size;
        let at = DVec2::new(twice.x, -twice.y) / self.size;
        let [x, y, one] = if depth.is_some() { self.near } else { self.far };
        let (depth, depth_off) = depth.unwrap_or_default();
        let middle = one + self.jitter.x * x + self.jitter.y * y;
        let value = at.x * x + at.y * y + depth * self.depth + middle;
        let terms = (at.x * x).abs() + (at.y * y).abs() + (depth * self.depth).abs() + middle.abs();
        let off = 2.0 * off / self.size;
        let moved = depth_off * self.depth.abs() + off.x * x.abs() + off.y * y.abs();
        // A term's column, its product, and three sums.
        Held { value, bound: HIGHER * (5.0 * ROUNDING * terms + moved) + FLUSHED }
    }
}

/// The vertices that a call of a stage's function gives for the inputs 0, 1, and so on.
fn vertices(
    gpu: &Gpu,
    (stage, call): (&Stage, &str),
    bound: &[(u32, Bound<'_>)],
    count: usize,
) -> Result<Vec<[f32; 4]>, String> {
    let probe = gpu.kept(call, || Ok(Probe::new(gpu, &stage.wgsl(), ("vec4<f32>", call), bound)))?;
    let inputs: Vec<_> = (0..count).map(|index| [index as f32, 0.0, 0.0, 0.0]).collect();
    Ok(probe.run(gpu, bound, &inputs)?.into_iter().map(|vertex| vertex.map(f32::from_bits)).collect())
}

/// The vertices of the draw of a list, of maps in one texture of `size`.
fn drawn(
    gpu: &Gpu,
    stage: (&Stage, &str),
    (shape, size, depths): (&DepthMapShape, [u32; 2], &[f32]),
    (list, views): (&[u32], &[DepthMapView]),
    count: usize,
) -> Result<Vec<[f32; 4]>, String> {
    let map = depth_view(&texture(gpu, size, TextureFormat::R32Float, depths)?);
    let (shape, list, views) = (uniform(gpu, shape), gpu.storage(list), gpu.storage(views));
    let objects = objects(gpu, [1, 1], &[0]);
    let bound = [
        (0, Bound::Uniform(&shape)),
        (1, Bound::Floats(&map)),
        (2, Bound::Storage(&list)),
        (3, Bound::Storage(&views)),
        (4, Bound::Integers(&objects)),
    ];
    vertices(gpu, stage, &bound, count)
}

const SURFACE: (&Stage, &str) = (&DEPTH_SURFACE, "depth_surface(u32(input.x)).position");
const WALLS: (&Stage, &str) = (&DEPTH_WALLS, "depth_walls(u32(input.x)).position");
const MESHES: (&Stage, &str) = (&MESH_DEPTH, "mesh_depth(u32(input.x))");

/// The samples of the vertices that are drawn of a list: `None` where a triangle is omitted. `first`: the position of a
/// cell's first sample.
fn corners(list: &[u32], first: impl Fn(u32) -> [u32; 2]) -> Vec<Option<[u32; 2]>> {
    let of_cell = |&entry: &u32| {
        let [x, y] = first(entry & CELL);
        let [a, b, c, d] = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let all = if entry & SPLIT == 0 { [a, b, d, a, d, c] } else { [a, b, c, b, d, c] };
        [0, 1, 2, 3, 4, 5].map(|vertex: usize| (entry & TRIANGLES[vertex / 3] != 0).then_some(all[vertex]))
    };
    list[1..].iter().flat_map(of_cell).collect()
}

fn shape(size: [u32; 2], faces: u32, is_reversed: bool) -> DepthMapShape {
    let is_reversed = u32::from(is_reversed);
    DepthMapShape { size, capacity: u32::MAX, is_reversed, faces, ..DepthMapShape::zeroed() }
}

/// An eye of any kind, and a format of its depth buffer.
fn eye(random: &mut Random) -> (ShadowCamera, TextureFormat) {
    let position = f64::from(random.between(0.5, 9.0)) * vector(random);
    let eye = any_eye(random, position, [0.05, 3.0]);
    (eye, [TextureFormat::Depth24PlusStencil8, TextureFormat::Depth32FloatStencil8][random.below(2)])
}

/// Maps of all kinds, and hostile ones, for lights and eyes of all kinds; moved aside and not.
fn of_maps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_101)?;
    let (mut tally, mut other_bias) = (Tally::default(), 0);
    for round in 0..if is_long() { 2000 } else { 160 } {
        let (camera, _) = light(&mut random);
        let is_reversed = camera.depth == REVERSED;
        let map = match round % 4 {
            0 => maps(&mut random).swap_remove(30 * usize::from(is_reversed) + random.below(30)),
            _ => map(&mut random, &camera),
        };
        let (eye, format) = eye(&mut random);
        let spread = random.below(2) == 0;
        let jitter = if spread { [0; 2].map(|_: u32| f64::from(random.between(-0.4, 0.4))) } else { [0.0; 2] };
        let slope_bias = [0.0, 0.5, 4.5][random.below(3)];
        let map_format = [TextureFormat::R32Float, TextureFormat::Depth16Unorm][random.below(2)];
        let placing = Placing { border: 1.0, jitter, slope_bias };
        let view = map_view((&camera, map.size, map_format), (&eye, format), &placing).map_err(text)?;
        let shape = DepthMapShape { spread: u32::from(spread), ..shape(map.size, 1, map.is_reversed) };
        let rule = Rule::new(differences(0.0), 1 + usize::from(spread), map.is_reversed, TextureFormat::R32Float);
        let cells = listed(&map, &[], &rule, None).0;
        let corners = corners(&cells, |cell| [cell % (map.size[0] + 1), cell / (map.size[0] + 1)]);
        let found = drawn(&gpu, SURFACE, (&shape, map.size, &map.depths), (&cells, &[view]), corners.len())?;
        let exact = Exact::new((&camera, map.size), (&eye, format), jitter);
        let moves = Moves { slope_bias, steps: steps(map_format, camera.depth), spread };
        let more = Moves { slope_bias: 1.01 * slope_bias, ..moves };
        for (corner, found) in corners.into_iter().zip(found) {
            let what = format!("round {round}, {:?}, sample {corner:?}", map.size);
            let Some(texel) = corner.map(|at| at.map(|at| i64::from(at) - 1)) else {
                if found != [0.0, 0.0, 0.0, 1.0] {
                    return Err(format!("{what}: {found:?} of an omitted triangle"));
                }
                continue;
            };
            let position = DVec2::from_array(texel.map(|at| at as f64));
            let held = |moves: &Moves| exact.vertex(position, moves.depth(&map, texel), 0.0);
            tally.add(&what, &held(&moves), found)?;
            tally.far += usize::from(sample(&map, texel[0], texel[1]).is_none());
            other_bias += usize::from(held(&more).share(found) > 1.0);
        }
    }
    println!("another bias is noticed at {other_bias}");
    tally.check(20_000, 2000)?;
    if other_bias > 1000 { Ok(()) } else { Err(format!("another bias is noticed at {other_bias}")) }
}

/// Six maps. Samples that maps share have one vertex, on the ray of each.
fn of_cubes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_102)?;
    let (mut tally, mut shared, mut exchanged) = (Tally::default(), 0, Ok(()));
    for round in 0..if is_long() { 400 } else { 30 } {
        let side = 3 + random.below(8) as u32;
        let cube = cube_of(&mut random, side);
        let (eye, format) = eye(&mut random);
        let is_reversed = cube.cameras[0].depth == REVERSED;
        let depths = merged(&cube, &[]).0;
        let slope_bias = [0.0, 0.5][random.below(2)];
        let placing = Placing { border: 0.0, jitter: [0.0; 2], slope_bias };
        let view = |camera| map_view((camera, [side; 2], TextureFormat::R32Float), (&eye, format), &placing);
        let views = cube.cameras.iter().map(view).collect::<Result<Vec<_>, _>>().map_err(text)?;
        let of_face = |depths| Map { size: [side; 2], is_reversed, depths };
        let faces: Vec<_> = parted(side, &depths).into_iter().map(of_face).collect();
        let rule = Rule::new(EVERY_CELL, 1, is_reversed, TextureFormat::R32Float);
        let cells = listed_of_cube(&faces, &[], &rule).0;
        let corners = corners(&cells, |cell| {
            let (across, face) = (side - 1, cell / ((side - 1) * (side - 1)));
            let in_map = cell % (across * across);
            [face % 3 * side + in_map % across, face / 3 * side + in_map / across]
        });
        let shape = &shape([side; 2], 6, is_reversed);
        let found = drawn(&gpu, SURFACE, (shape, [3 * side, 2 * side], &depths), (&cells, &views), corners.len())?;
        let rays = on_rays(&cube.cameras, side);
        let moves = Moves { slope_bias, steps: steps(TextureFormat::R32Float, cube.cameras[0].depth), spread: false };
        let mut of_rays = HashMap::new();
        for (corner, found) in corners.into_iter().zip(found) {
            let Some([x, y]) = corner else { continue };
            let (face, texel) = (x / side + 3 * (y / side), [x % side, y % side]);
            let (on_ray, what) = (&rays[&(face, texel)], format!("round {round}, sample {texel:?} of map {face}"));
            let (first, at_first) = on_ray[0];
            if on_ray.len() > 1 {
                // All have the same bits.
                let other = *of_rays.entry(on_ray[0]).or_insert(found);
                if other.map(f32::to_bits) != found.map(f32::to_bits) {
                    return Err(format!("{what}: {found:?} and {other:?}"));
                }
                shared += 1;
                // Slopes at borders continue in the next map. The oracle has no such slopes.
                if slope_bias > 0.0 {
                    continue;
                }
            }
            let held = |face: u32| {
                let exact = Exact::new((&cube.cameras[face as usize], [side; 2]), (&eye, format), [0.0; 2]);
                let depth = moves.depth(&faces[first as usize], at_first.map(i64::from));
                exact.vertex(DVec2::from_array(at_first.map(f64::from)), depth, 0.0)
            };
            tally.add(&what, &held(first), found)?;
            exchanged = exchanged.and_then(|()| Tally::default().add(&what, &held((first + 2) % 6), found));
        }
    }
    println!("{shared} at samples that maps share");
    must_fail("maps that are exchanged", &exchanged)?;
    tally.check(5000, 0)?;
    if shared > 2000 { Ok(()) } else { Err(format!("only {shared} are shared")) }
}

/// Vertices of walls and flaps, between samples.
fn of_walls() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_105)?;
    let mut tally = Tally::default();
    for round in 0..if is_long() { 1000 } else { 60 } {
        let (camera, _) = light(&mut random);
        let (eye, format) = eye(&mut random);
        let size = [3 + random.below(30) as u32, 3 + random.below(30) as u32];
        let map = smooth(&mut random, size, camera.depth == REVERSED);
        let method = contours([0.005, 0.25, 20.0 / 1024.0]);
        let walls = walls_of(&gpu, &map, None, DepthMapOptions { capacity: Some(100_000), ..by(method) })?;
        if walls.is_empty() {
            continue;
        }
        let mut list = vec![walls.len() as u32, 0, 0, 0];
        list.extend(walls.iter().flatten().flatten().map(|&word| word as u32));
        let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.5 };
        let view = map_view((&camera, size, TextureFormat::R32Float), (&eye, format), &placing).map_err(text)?;
        let shape = &shape(size, 1, map.is_reversed);
        let found = drawn(&gpu, WALLS, (shape, size, &map.depths), (&list, &[view]), 6 * walls.len())?;
        let exact = Exact::new((&camera, size), (&eye, format), [0.0; 2]);
        for (index, found) in found.into_iter().enumerate() {
            let [x, y, distance] = walls[index / 6][[0, 1, 2, 0, 2, 3][index % 6]];
            // Texel 0 is a texel after the border's.
            let texel = DVec2::new(f64::from(x), f64::from(y)) / 256.0 - 1.0;
            let depth = (distance != i32::MAX).then(|| {
                let depth = f64::from(distance) / UNIT;
                let depth = if map.is_reversed { 1.0 - depth } else { depth };
                // A conversion, and a quotient, 2.5 units.
                (depth, 3.5 * ROUNDING * depth)
            });
            // The quotient, 2.5 units, of twice the position.
            let off = 2.5 * ROUNDING * (texel.max_element() + 1.0);
            tally.add(&format!("round {round}, vertex {index}"), &exact.vertex(texel, depth, off), found)?;
            tally.far += usize::from(depth.is_none());
        }
    }
    tally.check(5000, 1000)
}

/// Vertices of a mesh as the light sees them.
fn of_meshes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_103)?;
    let mut tally = Tally::default();
    for round in 0..if is_long() { 400 } else { 40 } {
        let (camera, _) = light(&mut random);
        let stride = 3 + random.below(4) as u32;
        // Every third caster has the unit matrix.
        let mut rows = [0, 1, 2].map(|axis| {
            let mut row = [0; 4].map(|_: u32| random.between(-2.0, 2.0));
            if round % 3 == 0 {
                row = [0.0; 4];
                row[axis] = 1.0;
            }
            row
        });
        (0..3).for_each(|axis| rows[axis][3] -= camera.origin[axis]);
        let [row_0, row_1, row_2] = rows;
        let position_offset = random.below(9) as u32;
        let (position_stride, first_face, face_count) = (stride, 0, 1);
        let caster = MeshDepthCaster { row_0, row_1, row_2, position_offset, position_stride, first_face, face_count };
        let size = 10_f32.powi(random.below(6) as i32 - 2);
        let positions: Vec<_> =
            (0..256).map(|_| random.direction().map(|axis| axis * random.between(0.0, size))).collect();
        let mut words = vec![f32::NAN; position_offset as usize];
        for position in &positions {
            words.extend(position);
            words.resize(words.len() + stride as usize - 3, f32::NAN);
        }
        let views = gpu.storage(&[MeshDepthView { columns: camera.view_projection }]);
        let (words, casters) = (gpu.storage(&words), gpu.storage(&[caster]));
        let bound = [(0, Bound::Storage(&views)), (1, Bound::Storage(&words)), (2, Bound::Storage(&casters))];
        let found = vertices(&gpu, MESHES, &bound, positions.len())?;
        let columns = camera.view_projection.map(|column| DVec4::from_array(column.map(f64::from)));
        for (position, found) in positions.iter().zip(found) {
            // World coordinates, and the terms of each; then the same of clip coordinates.
            let world = rows.map(|row| {
                let terms = [0, 1, 2].map(|axis| f64::from(row[axis]) * f64::from(position[axis]));
                let absolute: f64 = terms.iter().map(|term| term.abs()).sum();
                [terms.iter().sum::<f64>() + f64::from(row[3]), absolute + f64::from(row[3]).abs()]
            });
            let sum = |at: usize, columns: [DVec4; 4]| {
                columns[0] * world[0][at] + columns[1] * world[1][at] + columns[2] * world[2][at] + columns[3]
            };
            // A product and three sums, twice.
            let bound = 8.001 * ROUNDING * sum(1, columns.map(DVec4::abs));
            let held = Held { value: sum(0, columns), bound };
            tally.add(&format!("round {round}, {position:?}"), &held, found)?;
        }
    }
    tally.check(5000, 0)
}
