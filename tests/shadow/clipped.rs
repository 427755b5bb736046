//! The vertices of clipped sides and near caps on the GPU, against their CPU twins.

use glam::Vec4;
use rimline::gpu::include_wgsl;
use rimline::mesh::EdgeKind;
use rimline::reference::cpu::{self, End, Threads};
use rimline::reference::layout::{RimlineInfo, ShadowDraw, ShadowLight, ShadowShape, ShadowView};
use rimline::reference::shadow::{self, CAST_EVERY, CAST_NOTHING, COUNT_ZP_PLUS};
use rimline::reference::stages::{CAP_FACES, SIDES};
use rimline::{Light, Predicate};

use crate::stages::spoil;
use rimline_measure::device::Gpu;
use rimline_measure::dispatch::{Dispatch, uniform};
use rimline_measure::harness::Test;
use rimline_measure::random::Random;
use rimline_measure::scenes::{Scene, scene};
use rimline_measure::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] =
    &[("clipped_vertices_equal_their_twins", clipped), ("sides_of_holes_equal_their_twins", holes)];

/// A module of vertex shaders with its entry points made functions, and a compute shader that calls one of them for each
/// of an instance's vertices.
fn probe(source: &str, entry_point: &str, vertices: usize) -> String {
    let mut source = source.to_owned();
    for (from, to) in [
        ("@vertex fn", "fn"),
        ("@fragment fn nothing() {}", ""),
        ("@invariant @builtin(position) ", ""),
        ("@builtin(vertex_index) ", ""),
        ("@builtin(instance_index) ", ""),
        // One storage buffer less, of which a stage has eight.
        ("var<storage, read> view", "var<uniform> view"),
    ] {
        source = source.replace(from, to);
    }
    format!(
        "{source}
@group(2) @binding(0) var<storage, read_write> found: array<vec4<f32>>;
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {{
  if (id.x < arrayLength(&found)) {{
    found[id.x] = {entry_point}(id.x % {vertices}u, id.x / {vertices}u).clip;
  }}
}}
"
    )
}

/// A vertex by its bits, or what is drawn of nothing.
pub(crate) fn bits(vertex: Option<&Vec4>) -> [u32; 4] {
    vertex.map_or([0.0, 0.0, 0.0, 1.0], Vec4::to_array).map(f32::to_bits)
}

/// What a strip of five vertices draws of a polygon.
fn strip(polygon: &[Vec4]) -> [[u32; 4]; 5] {
    [0, 1, 4, 2, 3].map(|place| bits(polygon.get(place).or(polygon.last())))
}

/// The vertices of a face's cap.
pub(crate) type Twin = fn(&ShadowView, &ShadowLight, [End; 3]) -> Vec<[u32; 4]>;

/// A kind of cap.
pub(crate) struct Cap {
    stage: Dispatch,
    /// Of an instance.
    vertices: usize,
    twin: Twin,
}

impl Cap {
    pub(crate) fn new(gpu: &Gpu, entry_point: &str, vertices: usize, twin: Twin) -> Self {
        let source = probe(&CAP_FACES.wgsl(), entry_point, vertices);
        Self { stage: Dispatch::new(gpu, &source, "probe"), vertices, twin }
    }

    fn near(gpu: &Gpu) -> Self {
        Self::new(gpu, "near_cap", 5, |view, light, face| strip(&cpu::near_cap(view, light, face)).to_vec())
    }
}

/// A light of a scene, with all that the vertex shaders read.
pub(crate) struct Drawn<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: ShadowView,
    pub(crate) shape: ShadowShape,
    pub(crate) lights: &'a [ShadowLight],
    pub(crate) index: usize,
    /// Of the light's word.
    pub(crate) facing: &'a [u32],
    /// Lights in a face's plane, likewise.
    pub(crate) coplanar: &'a [u32],
}

impl Drawn<'_> {
    pub(crate) fn light(&self) -> &ShadowLight {
        &self.lights[self.index]
    }

    fn end(&self, vertex: u32) -> End {
        (vertex, self.scene.caster.1[vertex as usize])
    }

    /// Whether the face is left out for the light.
    fn excludes(&self, face: usize) -> bool {
        self.light().excludes != 0 && self.coplanar[face] >> (self.index % 32) & 1 != 0
    }

    fn frame(&self, gpu: &Gpu) -> [wgpu::Buffer; 4] {
        let light = self.index as u32;
        let draw = ShadowDraw { light, first_light: light / 32 * 32, reserved_0: 0, reserved_1: 0 };
        [uniform(gpu, &self.shape), uniform(gpu, &self.view), uniform(gpu, &draw), gpu.storage(self.lights)]
    }

    /// Sides as the GPU has them and as the twin has, from a list that fits or from all edges.
    fn sides(&self, gpu: &Gpu, stage: &Dispatch, overflows: bool) -> Result<[Vec<[u32; 4]>; 2], String> {
        let (_, positions, mesh) = &self.scene.caster;
        let bit = self.index as u32 % 32;
        let masks = cpu::edges(mesh.edges(), self.facing, mesh.faces().len(), 32, Threads::ONE);
        let list = cpu::compact(&masks, bit, usize::MAX);
        let capacity = if overflows { list.count.saturating_sub(1) } else { list.count };
        let is_doubled = self.light().casting == CAST_EVERY;
        let edges = if overflows && list.count > 0 { mesh.edges().len() } else { list.entries.len() };
        let instances = edges * (1 + usize::from(is_doubled));
        let first_light = self.index as u32 / 32 * 32;
        let info = RimlineInfo {
            edges: mesh.edges().len() as u32,
            capacity,
            first_light,
            lights: 32,
            position_offset: 0,
            position_stride: 3,
        };
        let mut counts = vec![0; self.lights.len()];
        counts[self.index] = list.count;
        let mut lists = vec![0; 32 * capacity as usize];
        lists[bit as usize * capacity as usize..][..capacity as usize]
            .copy_from_slice(&list.entries[..capacity as usize]);
        let vertices: Vec<[u32; 2]> = mesh.edges().iter().map(|edge| edge.vertices).collect();
        let faces: Vec<[u32; 2]> = mesh.edges().packed_faces().to_vec();
        let results = [
            uniform(gpu, &info),
            gpu.storage(positions),
            gpu.storage(&vertices),
            gpu.storage(&faces),
            gpu.storage(self.facing),
            gpu.storage(&lists),
            gpu.storage(&counts),
        ];
        let found = gpu.storage(&vec![[0.0_f32; 4]; 5 * instances]);
        let [_, view, draw, lights] = &self.frame(gpu);
        let results: Vec<_> = (0..).zip(&results).collect();
        let groups = [&[(1, view), (2, draw), (3, lights)][..], &results, &[(0, &found)]];
        stage.run_bound(gpu, &groups, (5 * instances).div_ceil(64) as u32)?;
        let mut expected = Vec::new();
        for instance in 0..instances {
            let place = if is_doubled { instance / 2 } else { instance };
            let record = if overflows { place } else { (list.entries[place] & !cpu::WINDING) as usize };
            let edge = mesh.edges().get(record).ok_or("no such edge")?;
            let is_drawn = masks[record].silhouette >> bit & 1 != 0
                && !(is_doubled && instance % 2 == 1 && edge.kind == EdgeKind::Boundary);
            let [a, b] = edge.vertices;
            let ends = if masks[record].winding >> bit & 1 != 0 { [b, a] } else { [a, b] };
            let ends = ends.map(|vertex| self.end(vertex));
            let polygon = cpu::side_clipped(&self.view, self.light(), ends);
            expected.extend(strip(if is_drawn && cpu::spans_side(self.light(), ends) { &polygon } else { &[] }));
        }
        Ok([gpu.read(&found, 5 * instances)?, expected])
    }

    /// Caps of one class, likewise.
    pub(crate) fn caps(
        &self,
        gpu: &Gpu,
        cap: &Cap,
        listed: &[u32],
        overflows: bool,
    ) -> Result<[Vec<[u32; 4]>; 2], String> {
        let (_, positions, mesh) = &self.scene.caster;
        let instances = if overflows { mesh.faces().len() } else { listed.len() };
        let cap_capacity = if overflows { listed.len() as u32 - 1 } else { listed.len() as u32 };
        let bit = self.index % 32;
        let mut counts = vec![0; 3 * self.lights.len()];
        counts[3 * self.index] = listed.len() as u32;
        let stride: u32 = cpu::list_capacities(cap_capacity).into_iter().sum();
        let mut lists = vec![0; 32 * stride as usize + 1];
        lists[bit * stride as usize..][..cap_capacity as usize].copy_from_slice(&listed[..cap_capacity as usize]);
        let [_, view, draw, lights] = &self.frame(gpu);
        let shape = &uniform(gpu, &ShadowShape { cap_capacity, ..self.shape });
        let faces = [
            gpu.storage(positions),
            gpu.storage(mesh.faces()),
            gpu.storage(self.facing),
            gpu.storage(&counts),
            gpu.storage(&lists),
            gpu.storage(self.coplanar),
        ];
        let vertices = cap.vertices * instances;
        let found = gpu.storage(&vec![[0.0_f32; 4]; vertices]);
        let faces: Vec<_> = (0..).zip(&faces).collect();
        let frame = [(0, shape), (1, view), (2, draw), (3, lights)];
        cap.stage.run_bound(gpu, &[&frame, &faces, &[(0, &found)]], vertices.div_ceil(64) as u32)?;
        let mut expected = Vec::new();
        let all: Vec<u32> = (0..mesh.faces().len() as u32).collect();
        for &index in if overflows { &all } else { listed } {
            let index = index as usize;
            let face = mesh.faces()[index];
            let faces_light = self.facing[index] >> bit & 1 != 0;
            let [a, b, c] = face;
            let is_drawn = !overflows
                || (a != b
                    && b != c
                    && c != a
                    && cpu::casts(self.light(), faces_light)
                    && !self.excludes(index)
                    && cpu::cap_class(self.light(), faces_light) == 0);
            if is_drawn {
                expected.extend((cap.twin)(&self.view, self.light(), face.map(|vertex| self.end(vertex))));
            } else {
                expected.extend((0..cap.vertices).map(|_| bits(None)));
            }
        }
        Ok([gpu.read(&found, vertices)?, expected])
    }
}

/// Which faces the sides of holes are drawn of.
#[derive(Clone, Copy, PartialEq)]
enum Holes {
    /// The list of excluded faces.
    Listed,
    /// All of them, since some are not finite.
    Holed,
    /// All of them, since the list overflowed.
    Overflowed,
}

/// The sides of holes of a caster, of `vertices` each: as the GPU has them, and by `twin`.
fn hole_sides(
    gpu: &Gpu,
    drawn: &Drawn<'_>,
    stage: &Dispatch,
    holes: Holes,
    vertices: usize,
    twin: impl Fn([End; 2]) -> Vec<[u32; 4]>,
) -> Result<[Vec<[u32; 4]>; 2], String> {
    let (_, positions, mesh) = &drawn.scene.caster;
    let all: Vec<u32> = (0..mesh.faces().len() as u32).collect();
    let excluded: Vec<u32> = all.iter().copied().filter(|&face| drawn.excludes(face as usize)).collect();
    let of = if holes == Holes::Listed { &excluded } else { &all };
    let cap_capacity = if holes == Holes::Overflowed { excluded.len() as u32 - 1 } else { excluded.len() as u32 };
    let mut counts = vec![0; 3 * drawn.lights.len()];
    counts[3 * drawn.index + 2] = excluded.len() as u32;
    let [front, back, _] = cpu::list_capacities(cap_capacity);
    let stride: u32 = cpu::list_capacities(cap_capacity).into_iter().sum();
    let mut lists = vec![0; drawn.lights.len() * stride as usize + 1];
    lists[(drawn.index as u32 * stride + front + back) as usize..][..cap_capacity as usize]
        .copy_from_slice(&excluded[..cap_capacity as usize]);
    let [_, view, draw, lights] = &drawn.frame(gpu);
    let shape = &uniform(gpu, &ShadowShape { cap_capacity, ..drawn.shape });
    let invocations = 3 * vertices * of.len();
    let found = gpu.storage(&vec![[0.0_f32; 4]; invocations.max(1)]);
    let caps = [
        gpu.storage(positions),
        gpu.storage(mesh.faces()),
        gpu.storage(&counts),
        gpu.storage(&lists),
        gpu.storage(drawn.coplanar),
    ];
    let caps: Vec<_> = [0, 1, 3, 4, 5].into_iter().zip(&caps).collect();
    let groups = [&[(0, shape), (1, view), (2, draw), (3, lights)][..], &caps, &[(0, &found)]];
    stage.run_bound(gpu, &groups, invocations.div_ceil(64) as u32)?;
    let mut expected = Vec::new();
    for &face in of {
        let [a, b, c] = mesh.faces()[face as usize];
        let edges = cpu::hole_edges(drawn.light(), positions, [a, b, c], drawn.excludes(face as usize));
        for ends in [[a, b], [b, c], [c, a]] {
            let edge = edges.iter().find(|edge| edge.map(|(vertex, _)| vertex) == ends);
            expected.extend(edge.map_or_else(|| vec![bits(None); vertices], |&edge| twin(edge)));
        }
    }
    Ok([gpu.read(&found, invocations)?, expected])
}

/// Casters with vertices that are not finite, and with excluded faces.
fn holes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 106;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let stage = |entry_point, vertices| Dispatch::new(gpu, &probe(&CAP_FACES.wgsl(), entry_point, vertices), "probe");
    let [plain, clipped] = [stage("hole_side", 5), stage("hole_side_clipped", 6)];
    let (mut sides, mut drawn_of) = (0, [0; 3]);
    for number in 0..if is_long() { 300 } else { 24 } {
        let mut scene = scene(&mut random, number, 8);
        // On vertices, where edges have no side, and between two.
        for (index, light) in scene.lights.iter_mut().enumerate().take(5) {
            let [a, b, _] = scene.caster.2.faces()[random.below(scene.caster.2.faces().len())];
            let [a, b] = [a, if index < 3 { a } else { b }].map(|vertex| scene.caster.1[vertex as usize]);
            *light = Light::point(std::array::from_fn(|axis| f32::midpoint(a[axis], b[axis])));
        }
        spoil(&mut random, &mut scene.caster.1, 6);
        let view = shadow::view(&scene.camera).map_err(|error| error.to_string())?;
        let mut lights: Vec<_> = scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect();
        for light in &mut lights {
            (light.holed, light.excludes) = [(1, 0), (1, 1), (0, 1), (0, 1)][random.below(4)];
        }
        let mesh = &scene.caster.2;
        let coplanar: Vec<u32> =
            mesh.faces().iter().map(|_| if random.below(6) == 0 { random.below(256) as u32 } else { 0 }).collect();
        for index in 0..lights.len() {
            let shape = ShadowShape { position_stride: 3, ..bytemuck::Zeroable::zeroed() };
            let drawn = Drawn { scene: &scene, view, shape, lights: &lights, index, facing: &[], coplanar: &coplanar };
            let light = drawn.light();
            let excluded = (0..coplanar.len()).filter(|&face| drawn.excludes(face)).count();
            let holes = match (light.holed, excluded) {
                (1, _) => Holes::Holed,
                (_, 1..) if random.below(2) == 0 => Holes::Overflowed,
                _ => Holes::Listed,
            };
            drawn_of[holes as usize] += usize::from(excluded > 0);
            let [found, expected] = hole_sides(gpu, &drawn, &plain, holes, 5, |ends| {
                cpu::hole_side(&view, light, ends).iter().map(|vertex| bits(Some(vertex))).collect()
            })?;
            sides += expected.chunks(5).filter(|side| side[0] != bits(None)).count();
            same(&format!("{}, light {index} {light:?}", scene.name), &found, &expected)?;
            let [mut found, expected] = hole_sides(gpu, &drawn, &clipped, holes, 6, |ends| {
                let mut polygon = cpu::hole_side_clipped(&view, light, ends);
                polygon.reverse();
                let strip = strip(&polygon);
                [&strip[..1], &strip].concat()
            })?;
            same(&format!("{}, light {index} {light:?}, clipped", scene.name), &found, &expected)?;
            if let Some(vertex) = found.iter_mut().find(|vertex| vertex[0] != 0) {
                vertex[0] ^= 1;
                must_fail("a moved vertex", &same(&scene.name, &found, &expected))?;
            }
        }
    }
    println!("{sides} sides of holes; of a list, of all and of all after an overflow: {drawn_of:?} lights");
    if sides < 1000 || drawn_of.into_iter().any(|lights| lights < 10) { Err("too few".to_owned()) } else { Ok(()) }
}

fn clipped() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 105;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let side =
        Dispatch::new(gpu, &probe(&format!("{}\n{}", SIDES.wgsl(), include_wgsl(1)), "side_clipped", 5), "probe");
    let cap = Cap::near(gpu);
    let (mut sides, mut caps) = (0, 0);
    for number in 0..if is_long() { 600 } else { 24 } {
        let scene = scene(&mut random, number, 36);
        let (_, positions, mesh) = &scene.caster;
        let view = shadow::view(&scene.camera).map_err(|error| error.to_string())?;
        let counts = mesh.edges().counts();
        let shape = ShadowShape {
            lights: 36,
            faces: mesh.faces().len() as u32,
            edges: mesh.edges().len() as u32,
            averted: u32::from(counts.boundary == 0 && counts.inconsistent == 0),
            counting: COUNT_ZP_PLUS,
            position_stride: 3,
            ..bytemuck::Zeroable::zeroed()
        };
        let mut lights: Vec<_> = scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect();
        // What a mask says of a face has nothing to do with where the light is.
        cpu::choose(&shape, &view, cpu::bounds(positions, mesh.faces()), true, &mut lights);
        let coplanar: Vec<u32> = (0..2 * mesh.faces().len()).map(|_| 1 << random.below(64).min(31)).collect();
        let plain = &scene.lights;
        let facing = cpu::facing(positions, mesh.faces(), plain, Predicate::Exact, Threads::ONE);
        let lists = cpu::caps(&view, positions, mesh.faces(), &facing, &coplanar, &lights);
        for _ in 0..6 {
            let index = random.below(36);
            let plane = |masks: &'_ [u32]| masks[index / 32 * mesh.faces().len()..][..mesh.faces().len()].to_vec();
            let (facing, coplanar) = (&plane(&facing), &plane(&coplanar));
            let drawn = Drawn { scene: &scene, view, shape, lights: &lights, index, facing, coplanar };
            if drawn.light().casting == CAST_NOTHING {
                continue;
            }
            let what = format!("{}, light {index} {:?}", scene.name, drawn.light());
            for overflows in [false, true] {
                let mut vertices = drawn.sides(gpu, &side, overflows)?;
                sides += vertices[0].len() / 5;
                same(&format!("{what}, sides"), &vertices[0], &vertices[1])?;
                if let Some(vertex) = vertices[0].iter_mut().find(|vertex| vertex[0] != 0) {
                    vertex[0] ^= 1;
                    must_fail("a moved vertex", &same(&what, &vertices[0], &vertices[1]))?;
                }
                let [front, ..] = &lists[index];
                if !front.is_empty() {
                    let vertices = drawn.caps(gpu, &cap, front, overflows)?;
                    caps += vertices[0].len() / 5;
                    same(&format!("{what}, caps"), &vertices[0], &vertices[1])?;
                }
            }
        }
    }
    println!("{sides} sides, {caps} caps");
    if sides.min(caps) < 1000 { Err("too few".to_owned()) } else { Ok(()) }
}
