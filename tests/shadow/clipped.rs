//! The vertices of clipped sides and near caps on the GPU, against their CPU twins.

use glam::Vec4;
use rimline::Predicate;
use rimline::reference::cpu::{self, End, Threads};
use rimline::reference::layout::{SceneCaster, SeenLight, ShadowDraw, ShadowLight, ShadowShape, ShadowView};
use rimline::reference::shadow::{self, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS};
use rimline::reference::stages::{CAP_FACES, SIDES};

use crate::sides;
use crate::stages::{table, with_depth};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Scene, scene};
use rimline_testkit::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] = &[("clipped_vertices_equal_their_twins", clipped)];

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
        ("var<storage, read> seen", "var<uniform> seen"),
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

/// Vertices of a strip of five that draws a polygon.
fn strip(polygon: &[Vec4]) -> [[u32; 4]; 5] {
    [0, 1, 4, 2, 3].map(|place| bits(polygon.get(place).or(polygon.last())))
}

/// The vertices of a face's cap.
pub(crate) type Twin = fn(&ShadowView, &ShadowLight, [End; 3]) -> Vec<[u32; 4]>;

/// A kind of cap.
pub(crate) struct Cap {
    stage: Dispatch,
    entry_point: &'static str,
    /// The list that is drawn.
    kind: u32,
    /// Vertices of an instance.
    vertices: usize,
    twin: Twin,
}

impl Cap {
    pub(crate) fn new(gpu: &Gpu, entry_point: &'static str, kind: u32, vertices: usize, twin: Twin) -> Self {
        let source = probe(&CAP_FACES.wgsl(), entry_point, vertices);
        let source = source.replace("CAP_KIND: u32 = 0u", &format!("CAP_KIND: u32 = {kind}u"));
        Self { stage: Dispatch::new(gpu, &source, "probe"), entry_point, kind, vertices, twin }
    }

    fn near(gpu: &Gpu) -> Self {
        Self::new(gpu, "near_cap", 0, 5, |view, light, face| strip(&cpu::near_cap(view, light, face)).to_vec())
    }

    /// Light caps of casters that are not in the depth buffer.
    fn seen_light(gpu: &Gpu) -> Self {
        let twin: Twin = |view, light, face| strip(&cpu::seen_light_cap(view, light, face))[..4].to_vec();
        Self::new(gpu, "seen_light_cap", 2, 4, twin)
    }
}

/// A light of a scene, with all that the vertex shaders read.
pub(crate) struct Drawn<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: ShadowView,
    pub(crate) shape: ShadowShape,
    pub(crate) lights: &'a [ShadowLight],
    pub(crate) index: usize,
    /// Facing masks of the light's batch, one a face.
    pub(crate) facing: &'a [u32],
    /// Lights for which a face is excluded, likewise.
    pub(crate) excluded: &'a [u32],
    /// For which lights near caps were found.
    pub(crate) capped: &'a [bool],
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
        self.light().excludes != 0 && self.excluded[face] >> (self.index % 32) & 1 != 0
    }

    /// The light. It is z-pass that counts where ZP+ found no near cap.
    fn drawn_light(&self) -> ShadowLight {
        let light = *self.light();
        let is_plain = light.counting == COUNT_ZP_PLUS && !self.capped[self.index];
        ShadowLight { counting: if is_plain { COUNT_Z_PASS } else { light.counting }, ..light }
    }

    /// Whether a face that casts is in a list of caps.
    fn has_cap(&self, facing: bool, kind: usize) -> bool {
        let light = self.light();
        if kind < 2 {
            return light.counting == COUNT_ZP_PLUS && cpu::near_kind(light, facing) == kind;
        }
        cpu::has_far_caps(light, self.shape.proxies == 0) && cpu::far_kind(facing) == kind
    }

    /// Whether the light has caps of a kind at all.
    fn is_seen(&self, cap: &Cap) -> bool {
        match cap.entry_point {
            "seen_light_cap" => self.shape.proxies != 0,
            "dark_cap" => self.light().counting == COUNT_Z_FAIL || self.light().end > 0.0,
            _ => true,
        }
    }

    /// Bind group 0, for lists with this room.
    fn frame(&self, gpu: &Gpu, shape: ShadowShape) -> [wgpu::Buffer; 4] {
        let light = self.index as u32;
        let (_, _, mesh) = &self.scene.caster;
        let draw = ShadowDraw { light, first_light: light / 32 * 32, view: 0, count_batch: 0 };
        let table = with_depth(table(mesh, (0, 3), self.lights, self.capped), shape.proxies == 0);
        let choices_at = size_of::<SceneCaster>() as u32 / 16;
        let batches = self.lights.len().div_ceil(32) as u32;
        let shape = ShadowShape {
            casters: 1,
            views: 1,
            lights: self.lights.len() as u32,
            batches,
            choices_at,
            measures_at: choices_at + 2 * batches,
            ..shape
        };
        // The stage reads choices from the table only, so other values here change nothing.
        let given = ShadowLight { casting: 7, counting: 7, excludes: 7, ..*self.light() };
        let seen = SeenLight {
            view: self.view,
            light: given,
            version: [0; 4],
            cone: bytemuck::Zeroable::zeroed(),
            reserved: [[0; 4]; 12],
        };
        [uniform(gpu, &shape), uniform(gpu, &draw), uniform(gpu, &seen), gpu.storage(&table)]
    }

    /// Sides as the GPU has them and as the twin has, from a list that fits or from all edges.
    fn sides(&self, gpu: &Gpu, stage: &Dispatch, overflows: bool) -> Result<[Vec<[u32; 4]>; 2], String> {
        let (_, positions, mesh) = &self.scene.caster;
        let bit = self.index % 32;
        let masks = [self.facing, self.excluded];
        let [plain, clipped] = &sides::lists(mesh, (bit, self.light()), masks, self.capped[self.index]);
        let count = plain.len() + clipped.len();
        let capacity = if overflows { count.saturating_sub(1) } else { count };
        let mut sides = vec![0_u32; 64 + 32 * capacity + 1];
        (sides[2 * bit], sides[2 * bit + 1]) = (plain.len() as u32, clipped.len() as u32);
        if !overflows {
            let entries: Vec<u32> = plain.iter().chain(clipped.iter().rev()).copied().collect();
            sides[64 + bit * capacity..][..capacity].copy_from_slice(&entries);
        }
        // Each instance: the edge, and which of its sides; a list that is empty does not overflow.
        let instances: Vec<(u32, usize)> = if overflows && count > 0 {
            (0..2 * mesh.edges().len()).map(|instance| (instance as u32 / 2, instance % 2)).collect()
        } else {
            clipped.iter().map(|&entry| (entry & !cpu::WINDING, 0)).collect()
        };
        let vertices: Vec<[u32; 2]> = mesh.edges().iter().map(|edge| edge.vertices).collect();
        let data = [
            gpu.storage(positions),
            gpu.storage(&vertices),
            gpu.storage(mesh.edges().packed_faces()),
            gpu.storage(self.facing),
            gpu.storage(self.excluded),
            gpu.storage(&sides),
        ];
        let found = gpu.storage(&vec![[0.0_f32; 4]; 5 * instances.len()]);
        let frame = self.frame(gpu, ShadowShape { side_capacity: capacity as u32, ..self.shape });
        let (frame, data): (Vec<_>, Vec<_>) = ((0..).zip(&frame).collect(), (0..).zip(&data).collect());
        let groups = [&frame[..], &data, &[(0, &found)]];
        stage.run_bound(gpu, &groups, (5 * instances.len()).div_ceil(64) as u32)?;
        let mut expected = Vec::new();
        for (record, number) in instances {
            let [a, b] = mesh.edges().get(record as usize).ok_or("no such edge")?.vertices;
            let mut entries = clipped.iter().filter(|&&entry| entry & !cpu::WINDING == record);
            let entry = entries.nth(number).copied();
            let ends = if entry.is_some_and(|entry| entry >= cpu::WINDING) { [b, a] } else { [a, b] };
            let ends = ends.map(|vertex| self.end(vertex));
            let polygon = cpu::side_clipped(&self.view, self.light(), ends);
            expected.extend(strip(if entry.is_some() { &polygon } else { &[] }));
        }
        Ok([gpu.read(&found, expected.len())?, expected])
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
        let capacity = if overflows { listed.len() as u32 - 1 } else { listed.len() as u32 };
        let bit = self.index % 32;
        let kind = cap.kind as usize;
        let mut lists = vec![0; 128 + 32 * (capacity as usize + 1) + 1];
        lists[4 * bit + kind] = listed.len() as u32;
        let shape = if kind < 2 {
            ShadowShape { near_capacity: capacity, far_capacity: 1, ..self.shape }
        } else {
            ShadowShape { near_capacity: 1, far_capacity: capacity, ..self.shape }
        };
        let first = 128 + bit * (capacity as usize + 1) + kind / 2;
        lists[first..][..capacity as usize].copy_from_slice(&listed[..capacity as usize]);
        let frame = self.frame(gpu, shape);
        let faces = [
            gpu.storage(positions),
            gpu.storage(mesh.faces()),
            gpu.storage(self.facing),
            gpu.storage(self.excluded),
            gpu.storage(&lists),
        ];
        let vertices = cap.vertices * instances;
        let found = gpu.storage(&vec![[0.0_f32; 4]; vertices]);
        let (frame, faces): (Vec<_>, Vec<_>) = ((0..).zip(&frame).collect(), (0..).zip(&faces).collect());
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
                    && self.has_cap(faces_light, kind));
            let is_drawn = is_drawn && self.is_seen(cap);
            if is_drawn {
                expected.extend((cap.twin)(&self.view, &self.drawn_light(), face.map(|vertex| self.end(vertex))));
            } else {
                expected.extend((0..cap.vertices).map(|_| bits(None)));
            }
        }
        Ok([gpu.read(&found, vertices)?, expected])
    }
}

fn clipped() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 105;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let side = Dispatch::new(gpu, &probe(&SIDES.wgsl(), "side_clipped", 5), "probe");
    let cap = Cap::near(gpu);
    let light_cap = Cap::seen_light(gpu);
    let (mut sides, mut caps, mut light_caps, mut clipped_light_caps) = (0, 0, 0, 0);
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
            counting: [COUNT_ZP_PLUS, COUNT_AUTO, COUNT_Z_PASS][number % 3],
            proxies: u32::from(number / 3 % 2 == 0),
            end_at_range: u32::from(number % 5 == 0),
            skip_unreached: 1,
            ..bytemuck::Zeroable::zeroed()
        };
        let mut lights: Vec<_> = scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect();
        // Random masks are valid input: a mask need not fit the light's position.
        cpu::choose(&shape, &view, cpu::bounds(positions, mesh.faces()), true, &mut lights);
        let excluded: Vec<u32> = (0..2 * mesh.faces().len()).map(|_| 1 << random.below(64).min(31)).collect();
        let plain = &scene.lights;
        let facing = cpu::facing(positions, mesh.faces(), plain, Predicate::Exact, Threads::ONE);
        let lists = cpu::caps(&view, positions, mesh.faces(), &facing, &excluded, &lights, shape.proxies == 0);
        // Some casters have near caps without a face.
        let capped: Vec<bool> = lists.iter().map(|lists| !lists[0].is_empty() || !lists[1].is_empty()).collect();
        for _ in 0..6 {
            let index = random.below(36);
            let plane = |masks: &'_ [u32]| masks[index / 32 * mesh.faces().len()..][..mesh.faces().len()].to_vec();
            let (facing, excluded) = (&plane(&facing), &plane(&excluded));
            let drawn = Drawn { scene: &scene, view, shape, lights: &lights, index, facing, excluded, capped: &capped };
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
                let [front, _, far, _] = &lists[index];
                if !far.is_empty() {
                    let vertices = drawn.caps(gpu, &light_cap, far, overflows)?;
                    same(&format!("{what}, light caps"), &vertices[0], &vertices[1])?;
                    light_caps += vertices[0].iter().filter(|&&vertex| vertex != bits(None)).count() / 4;
                    // A fourth vertex of its own.
                    let quads = vertices[0].chunks(4).filter(|quad| quad[2] != quad[3]).count();
                    clipped_light_caps += if drawn.light().counting == COUNT_ZP_PLUS { quads } else { 0 };
                }
                if !front.is_empty() {
                    let vertices = drawn.caps(gpu, &cap, front, overflows)?;
                    caps += vertices[0].len() / 5;
                    same(&format!("{what}, caps"), &vertices[0], &vertices[1])?;
                }
            }
        }
    }
    println!("{sides} sides, {caps} near caps, {light_caps} light caps, {clipped_light_caps} of which are quads");
    if clipped_light_caps < 100 {
        return Err("too few light caps that the near plane cuts".to_owned());
    }
    if sides.min(caps).min(light_caps) < 1000 { Err("too few".to_owned()) } else { Ok(()) }
}
