//! Vertices of the boundary against `f64`.

use std::collections::HashMap;

use bytemuck::Zeroable;
use glam::DVec2;
use rimline::gpu::depth_map::DepthMapCube;
use rimline::internals::depth_map::{Placing, map_view};
use rimline::internals::layout::{DepthMapShape, DepthMapView, MeshDepthCaster, MeshDepthView};
use rimline::internals::stages::{DEPTH_SURFACE, MESH_DEPTH};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::uniform;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::probe::{Bound, Probe};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat;

use crate::cube::{at_face, cube_of, merged, on_rays, parted};
use crate::exact::{Exact, Held, Moves, ROUNDING, steps};
use crate::maps::{Map, maps};
use crate::parity::{any_eye, light, map};
use crate::picture::{EVERY_CELL, differences};
use crate::rules::{CELL, Rule, corners, listed, listed_of_cube};
use crate::scene::vector;
use rimline_testkit::textures::{depth_view, objects, texture};

pub(crate) const TESTS: &[Test] = &[
    ("vertices_of_boundaries_are_those_of_f64", of_maps),
    ("vertices_of_cubes_are_those_of_f64", of_cubes),
    ("vertices_of_meshes_in_maps_are_those_of_f64", of_meshes),
];

/// Numbers of vertices compared, and the largest error as a part of its bound.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) vertices: usize,
    pub(crate) far: usize,
    /// Largest part of the bound.
    pub(crate) worst: f64,
    /// Vertices for which a move by another 32 units in the last place of the largest component is noticed.
    pub(crate) noticed: usize,
}

impl Tally {
    pub(crate) fn add(&mut self, what: &str, held: &Held, found: [f32; 4]) -> Result<(), String> {
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

    pub(crate) fn check(&self, least: usize) -> Result<(), String> {
        println!("{self:?}");
        if self.vertices > least && self.worst > 0.05 && self.noticed * 2 > self.vertices {
            Ok(())
        } else {
            Err(format!("not vacuous: {self:?}"))
        }
    }
}

/// An eye of any kind, and a format of its depth buffer.
pub(crate) fn eye(random: &mut Random) -> (ShadowCamera, TextureFormat) {
    let position = f64::from(random.between(0.5, 9.0)) * vector(random);
    let eye = any_eye(random, position, [0.05, 3.0]);
    (eye, [TextureFormat::Depth24PlusStencil8, TextureFormat::Depth32FloatStencil8][random.below(2)])
}

/// The samples of the vertices that are drawn of a list: `None` where a triangle is omitted. `position`: that of a
/// cell's first sample.
fn drawn(list: &[u32], position: impl Fn(u32) -> [u32; 2]) -> Vec<Option<[u32; 2]>> {
    let of_cell = |&entry: &u32| {
        let [x, y] = position(entry & CELL);
        corners(entry).map(|corner| corner.map(|[across, down]| [x + across, y + down]))
    };
    list.iter().skip(1).flat_map(of_cell).collect()
}

/// Bindings of the draws of a map.
pub(crate) struct Given {
    shape: wgpu::Buffer,
    map: wgpu::TextureView,
    cells: wgpu::Buffer,
    views: wgpu::Buffer,
    objects: wgpu::TextureView,
}

impl Given {
    pub(crate) fn new(
        gpu: &Gpu,
        (shape, size, depths): (&DepthMapShape, [u32; 2], &[f32]),
        cells: &[u32],
        views: &[DepthMapView],
    ) -> Result<Self, String> {
        Ok(Self {
            shape: uniform(gpu, shape),
            map: depth_view(&texture(gpu, size, TextureFormat::R32Float, depths)?),
            cells: gpu.storage(cells),
            views: gpu.storage(views),
            objects: objects(gpu, [1, 1], &[0]),
        })
    }

    pub(crate) fn bound(&self) -> [(u32, Bound<'_>); 5] {
        [
            (0, Bound::Uniform(&self.shape)),
            (1, Bound::Floats(&self.map)),
            (2, Bound::Storage(&self.cells)),
            (3, Bound::Storage(&self.views)),
            (4, Bound::Integers(&self.objects)),
        ]
    }

    /// The vertices of the draw of a list.
    fn vertices(&self, gpu: &Gpu, count: usize) -> Result<Vec<[f32; 4]>, String> {
        Probe::vertices(gpu, &DEPTH_SURFACE, "depth_surface(u32(input.x)).position", &self.bound(), count)
    }
}

/// Vertex of an omitted triangle.
const NOTHING: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Maps of all kinds, and hostile ones, for lights and eyes of all kinds; moved aside and not.
fn of_maps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_101)?;
    let (mut tally, mut other_bias) = (Tally::default(), 0);
    for round in 0..if is_long() { 2000 } else { 160 } {
        let (camera, _) = light(&mut random);
        let hostile = maps(&mut random);
        let is_reversed = camera.depth == DepthDirection::Reversed;
        let map = match round % 4 {
            0 => hostile.into_iter().filter(|map| map.is_reversed == is_reversed).nth(random.below(20)),
            _ => Some(map(&mut random, &camera)),
        };
        let map = map.ok_or("no map")?;
        let (eye, format) = eye(&mut random);
        let spread = random.below(2) == 0;
        let jitter = if spread { [0; 2].map(|_: u32| f64::from(random.between(-0.4, 0.4))) } else { [0.0; 2] };
        let slope_bias = [0.0, 0.5, 4.5][random.below(3)];
        let map_format = [TextureFormat::R32Float, TextureFormat::Depth16Unorm][random.below(2)];
        let placing = Placing { border: 1.0, jitter, slope_bias };
        let view = map_view((&camera, map.size, map_format), (&eye, format), &placing).map_err(text)?;
        let shape = DepthMapShape { spread: u32::from(spread), ..map.shape(0.0, u32::MAX) };
        let rule = Rule::new(differences(0.0), 1 + usize::from(spread), map.is_reversed, TextureFormat::R32Float);
        let cells = listed(&map, &[], &rule, None).0;
        let corners = drawn(&cells, |cell| [cell % (map.size[0] + 1), cell / (map.size[0] + 1)]);
        let given = Given::new(&gpu, (&shape, map.size, &map.depths), &cells, &[view])?;
        let found = given.vertices(&gpu, corners.len())?;
        let exact = Exact::new((&camera, map.size), (&eye, format), jitter);
        let moves = Moves { slope_bias, steps: steps(map_format, camera.depth), spread };
        let more = Moves { slope_bias: 1.01 * slope_bias, ..moves };
        for (corner, found) in corners.into_iter().zip(found) {
            let Some(at) = corner else {
                if found != NOTHING {
                    return Err(format!("round {round}: {found:?} of an omitted triangle"));
                }
                continue;
            };
            let texel = at.map(|at| i64::from(at) - 1);
            let held = |moves: &Moves| {
                exact.vertex(DVec2::new(texel[0] as f64, texel[1] as f64), moves.depth(&map, texel), 0.0)
            };
            let what = format!("round {round}, {:?}, sample {at:?}", map.size);
            tally.add(&what, &held(&moves), found)?;
            tally.far += usize::from(moves.depth(&map, texel).is_none());
            other_bias += usize::from(held(&more).share(found) > 1.0);
        }
    }
    println!("another bias is noticed at {other_bias}");
    tally.check(20_000)?;
    if tally.far > 2000 && other_bias > 1000 { Ok(()) } else { Err(format!("{tally:?}, {other_bias}")) }
}

/// Six maps. Samples that maps share have one vertex, on the ray of each.
fn of_cubes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_102)?;
    let (mut tally, mut shared) = (Tally::default(), 0);
    for round in 0..if is_long() { 400 } else { 30 } {
        let side = 3 + random.below(8) as u32;
        let cube = cube_of(&mut random, side);
        let (eye, format) = eye(&mut random);
        let is_reversed = cube.cameras[0].depth == DepthDirection::Reversed;
        let shape = DepthMapShape {
            size: [side; 2],
            cells: 6 * (side - 1) * (side - 1),
            capacity: u32::MAX,
            every_cell: 1,
            is_reversed: u32::from(is_reversed),
            faces: 6,
            ..DepthMapShape::zeroed()
        };
        let (depths, _) = merged(&cube, &[]);
        let slope_bias = [0.0, 0.5][random.below(2)];
        let placing = Placing { border: 0.0, jitter: [0.0; 2], slope_bias };
        let view = |camera| map_view((camera, [side; 2], TextureFormat::R32Float), (&eye, format), &placing);
        let views = cube.cameras.iter().map(view).collect::<Result<Vec<_>, _>>().map_err(text)?;
        let of_face = |depths| Map { size: [side; 2], is_reversed, depths };
        let faces: Vec<_> = parted(side, &depths).into_iter().map(of_face).collect();
        let rule = Rule::new(EVERY_CELL, 1, is_reversed, TextureFormat::R32Float);
        let cells = listed_of_cube(&faces, &[], &rule).0;
        let corners = drawn(&cells, |cell| {
            let (across, face) = (side - 1, cell / ((side - 1) * (side - 1)));
            let in_map = cell % (across * across);
            at_face(side, face, [in_map % across, in_map / across])
        });
        let given = Given::new(&gpu, (&shape, [3 * side, 2 * side], &depths), &cells, &views)?;
        let found = given.vertices(&gpu, corners.len())?;
        let rays = on_rays(&cube.cameras, side);
        let mut of_rays: HashMap<u32, [f32; 4]> = HashMap::new();
        for (corner, found) in corners.into_iter().zip(found) {
            let Some([x, y]) = corner else { continue };
            let (face, texel) = (x / side + 3 * (y / side), [x % side, y % side]);
            let on_ray = &rays[&(face, texel)];
            let what = format!("round {round}, sample {texel:?} of map {face}");
            let (first, at_first) = on_ray[0];
            if on_ray.len() > 1 {
                // All have the same bits.
                let number = (first * side + at_first[1]) * side + at_first[0];
                let other = *of_rays.entry(number).or_insert(found);
                if other.map(f32::to_bits) != found.map(f32::to_bits) {
                    return Err(format!("{what}: {found:?} and {other:?}"));
                }
                shared += 1;
            }
            // Slopes at borders continue in the next map: the oracle has no such slopes, so only samples without a bias
            // are compared.
            if on_ray.len() > 1 && slope_bias > 0.0 {
                continue;
            }
            let map = &faces[first as usize];
            let camera = &cube.cameras[first as usize];
            let exact = Exact::new((camera, [side; 2]), (&eye, format), [0.0; 2]);
            let moves = Moves { slope_bias, steps: steps(TextureFormat::R32Float, camera.depth), spread: false };
            let texel = at_first.map(i64::from);
            let position = DVec2::new(texel[0] as f64, texel[1] as f64);
            tally.add(&what, &exact.vertex(position, moves.depth(map, texel), 0.0), found)?;
        }
    }
    println!("{shared} at samples that maps share");
    let exchanged = DepthMapCube::cameras([0.0; 3], 0.1, None, DepthDirection::Reversed, 4).map_err(text)?;
    let eye = (&exchanged[0], TextureFormat::Depth24PlusStencil8);
    let held =
        |face: usize| Exact::new((&exchanged[face], [4; 2]), eye, [0.0; 2]).vertex(DVec2::ONE, Some((0.25, 0.0)), 0.0);
    let other = held(0).value.as_vec4().to_array();
    must_fail("maps that are exchanged", &Tally::default().add("map 2", &held(2), other))?;
    tally.check(5000)?;
    if shared > 2000 { Ok(()) } else { Err(format!("only {shared} are shared")) }
}

/// Vertices of a mesh as the light sees them.
fn of_meshes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_103)?;
    let mut tally = Tally::default();
    for round in 0..if is_long() { 400 } else { 40 } {
        let (camera, _) = light(&mut random);
        let stride = 3 + random.below(4) as u32;
        let view = MeshDepthView { columns: camera.view_projection };
        // Every third caster has the unit matrix.
        let row = |axis: usize, random: &mut Random| {
            let mut row = [0.0; 4].map(|_: f32| random.between(-2.0, 2.0));
            if round % 3 == 0 {
                row = [0.0; 4];
                row[axis] = 1.0;
            }
            row[3] -= camera.origin[axis];
            row
        };
        let caster = MeshDepthCaster {
            row_0: row(0, &mut random),
            row_1: row(1, &mut random),
            row_2: row(2, &mut random),
            position_offset: random.below(9) as u32,
            position_stride: stride,
            first_face: 0,
            face_count: 1,
        };
        let size = 10_f32.powi(random.below(6) as i32 - 2);
        let positions: Vec<_> =
            (0..256).map(|_| random.direction().map(|axis| axis * random.between(0.0, size))).collect();
        let mut words = vec![f32::NAN; caster.position_offset as usize];
        for position in &positions {
            words.extend(position);
            words.resize(words.len() + stride as usize - 3, f32::NAN);
        }
        let (views, words, casters) = (gpu.storage(&[view]), gpu.storage(&words), gpu.storage(&[caster]));
        let bound = [(0, Bound::Storage(&views)), (1, Bound::Storage(&words)), (2, Bound::Storage(&casters))];
        let found = Probe::vertices(&gpu, &MESH_DEPTH, "mesh_depth(u32(input.x))", &bound, positions.len())?;
        let columns = camera.view_projection.map(|column| glam::DVec4::from_array(column.map(f64::from)));
        for (position, found) in positions.iter().zip(found) {
            // The terms of each world coordinate, and of each clip coordinate.
            let world = [caster.row_0, caster.row_1, caster.row_2].map(|row| {
                let terms = [0, 1, 2].map(|axis| f64::from(row[axis]) * f64::from(position[axis]));
                let shift = f64::from(row[3]);
                let absolute: f64 = terms.iter().map(|term| term.abs()).sum();
                (terms.iter().sum::<f64>() + shift, absolute + shift.abs())
            });
            let sum = |of: [f64; 3]| columns[0] * of[0] + columns[1] * of[1] + columns[2] * of[2];
            let value = sum(world.map(|(value, _)| value)) + columns[3];
            let sizes = [0, 1, 2].map(|axis| columns[axis].abs() * world[axis].1);
            let size = sizes[0] + sizes[1] + sizes[2] + columns[3].abs();
            // A product and three sums, twice.
            let held = Held { value, bound: 8.001 * ROUNDING * size };
            tally.add(&format!("round {round}, {position:?}"), &held, found)?;
        }
    }
    tally.check(5000)
}
