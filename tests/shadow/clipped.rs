//! The vertices of sides and caps as vertex shaders draw them from lists, by a compute shader that calls them.

use rimline::internals::cpu;
use rimline::internals::layout::{ShadowDraw, ShadowLight, ShadowShape, ShadowView};
use rimline::internals::stages::{CAP_FACES, SIDES};

use crate::sides;
use crate::stages::{Staged, table, with_depth};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::same;
use rimline_testkit::scenes::Scene;
use rimline_testkit::stage_probe::seen_light;

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
        ("var<storage, read> view_light", "var<uniform> view_light"),
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

/// Vertices of an instance that is not drawn.
pub(crate) const NOTHING: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Vertices, some for each instance.
pub(crate) type Vertices = Vec<[f32; 4]>;

/// Sides that are clipped, or caps of a kind.
pub(crate) struct Shapes {
    stage: Dispatch,
    /// The list that is drawn, of caps.
    kind: usize,
    /// Vertices of an instance.
    pub(crate) vertices: usize,
}

impl Shapes {
    pub(crate) fn sides(gpu: &Gpu) -> Self {
        Self { stage: Dispatch::new(gpu, &probe(&SIDES.wgsl(), "side_clipped", 5), "probe"), kind: 0, vertices: 5 }
    }

    pub(crate) fn caps(gpu: &Gpu, entry_point: &'static str, kind: usize, vertices: usize) -> Self {
        let source = probe(&CAP_FACES.wgsl(), entry_point, vertices);
        let source = source.replace("CAP_KIND: u32 = 0u", &format!("CAP_KIND: u32 = {kind}u"));
        Self { stage: Dispatch::new(gpu, &source, "probe"), kind, vertices }
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

impl<'a> Drawn<'a> {
    pub(crate) fn of(staged: &'a Staged<'_>, lights: &'a [ShadowLight], capped: &'a [bool], index: usize) -> Self {
        let faces = staged.scene.caster.2.faces().len();
        let plane = |masks: &'a [u32]| &masks[index / 32 * faces..][..faces];
        let (facing, excluded) = (plane(&staged.facing), plane(&staged.excluded));
        Self { scene: staged.scene, view: staged.view, shape: staged.shape, lights, index, facing, excluded, capped }
    }

    pub(crate) fn light(&self) -> &ShadowLight {
        &self.lights[self.index]
    }

    /// Bind group 0, for lists with this room.
    fn frame(&self, gpu: &Gpu, shape: ShadowShape) -> [wgpu::Buffer; 4] {
        let light = self.index as u32;
        let (_, _, mesh) = &self.scene.caster;
        let draw = ShadowDraw { light, first_light: light / 32 * 32, view: 0, count_batch: 0 };
        let table = with_depth(table(mesh, (0, 3), self.lights, self.capped), shape.proxies == 0);
        // The stage reads choices from the table only, so other values here change nothing.
        let given = ShadowLight { casting: 7, counting: 7, excludes: 7, ..*self.light() };
        let seen = seen_light(self.view, given);
        [uniform(gpu, &shape), uniform(gpu, &draw), uniform(gpu, &seen), gpu.storage(&table)]
    }

    fn run(
        &self,
        gpu: &Gpu,
        shapes: &Shapes,
        shape: ShadowShape,
        data: &[wgpu::Buffer],
        instances: usize,
    ) -> Result<Vertices, String> {
        let vertices = shapes.vertices * instances;
        if vertices == 0 {
            return Ok(Vec::new());
        }
        let found = gpu.storage(&vec![[0.0_f32; 4]; vertices]);
        let frame = self.frame(gpu, shape);
        let (frame, data): (Vec<_>, Vec<_>) = ((0..).zip(&frame).collect(), (0..).zip(data).collect());
        shapes.stage.run_bound(gpu, &[&frame, &data, &[(0, &found)]], vertices.div_ceil(64) as u32)?;
        gpu.read(&found, vertices)
    }

    /// Entries of the list of clipped sides, and the vertices of each. A list that overflows must draw the same.
    pub(crate) fn sides(&self, gpu: &Gpu, shapes: &Shapes, checks: bool) -> Result<(Vec<u32>, Vertices), String> {
        let (_, positions, mesh) = &self.scene.caster;
        let bit = self.index % 32;
        let masks = [self.facing, self.excluded];
        let [plain, clipped] = sides::lists(mesh, (bit, self.light()), masks, self.capped[self.index]);
        let count = plain.len() + clipped.len();
        let run = |capacity: usize, listed: &[u32], instances: usize| {
            let mut sides = vec![0_u32; 64 + 32 * capacity + 1];
            (sides[2 * bit], sides[2 * bit + 1]) = (plain.len() as u32, clipped.len() as u32);
            sides[64 + bit * capacity..][..listed.len()].copy_from_slice(listed);
            let data = [
                gpu.storage(positions),
                gpu.storage(mesh.edges().vertices()),
                gpu.storage(mesh.edges().packed_faces()),
                gpu.storage(self.facing),
                gpu.storage(self.excluded),
                gpu.storage(&sides),
            ];
            self.run(gpu, shapes, ShadowShape { side_capacity: capacity as u32, ..self.shape }, &data, instances)
        };
        let listed: Vec<u32> = plain.iter().chain(clipped.iter().rev()).copied().collect();
        let found = run(count, &listed, clipped.len())?;
        // A list that is empty does not overflow.
        if checks && count > 0 {
            // Each edge is two instances: which of its sides, if it has so many.
            let mut expected = vec![NOTHING; 2 * shapes.vertices * mesh.edges().len()];
            let mut last = (u32::MAX, 0);
            for (entry, strip) in clipped.iter().zip(found.chunks(shapes.vertices)) {
                let edge = entry & !cpu::WINDING;
                last = (edge, if last.0 == edge { last.1 + 1 } else { 0 });
                let at = shapes.vertices * (2 * edge as usize + last.1);
                expected[at..][..shapes.vertices].copy_from_slice(strip);
            }
            let whole = run(count - 1, &[], 2 * mesh.edges().len())?;
            same_bits(&format!("{}, light {}, sides", self.scene.name, self.index), &whole, &expected)?;
        }
        Ok((clipped, found))
    }

    /// Faces that cast and have caps of the class, near caps wherever they are, and the vertices of each. A list that
    /// overflows must draw the same.
    pub(crate) fn caps(&self, gpu: &Gpu, shapes: &Shapes, checks: bool) -> Result<(Vec<u32>, Vertices), String> {
        let (_, positions, mesh) = &self.scene.caster;
        let light = (self.index % 32, self.light());
        let lists = sides::caps(mesh, positions, light, [self.facing, self.excluded], self.shape.proxies == 0);
        let listed = lists[shapes.kind].clone();
        let found = self.listed_caps(gpu, shapes, &listed, listed.len())?;
        if checks && !listed.is_empty() {
            let mut expected = vec![NOTHING; shapes.vertices * mesh.faces().len()];
            for (face, strip) in listed.iter().zip(found.chunks(shapes.vertices)) {
                expected[shapes.vertices * *face as usize..][..shapes.vertices].copy_from_slice(strip);
            }
            let whole = self.listed_caps(gpu, shapes, &listed, listed.len() - 1)?;
            same_bits(&format!("{}, light {}, caps", self.scene.name, self.index), &whole, &expected)?;
        }
        Ok((listed, found))
    }

    /// Caps of these faces, or of all that the list has no room for.
    pub(crate) fn listed_caps(
        &self,
        gpu: &Gpu,
        shapes: &Shapes,
        listed: &[u32],
        capacity: usize,
    ) -> Result<Vertices, String> {
        let (_, positions, mesh) = &self.scene.caster;
        let (bit, kind) = (self.index % 32, shapes.kind);
        let mut lists = vec![0; 128 + 32 * (capacity + 1) + 1];
        lists[4 * bit + kind] = listed.len() as u32;
        let [mut near_capacity, mut far_capacity] = [1, 1];
        *(if kind < 2 { &mut near_capacity } else { &mut far_capacity }) = capacity as u32;
        // The second list of a run is at its end.
        let mut run = listed[..capacity.min(listed.len())].to_vec();
        if kind % 2 == 1 {
            run.reverse();
        }
        lists[128 + bit * (capacity + 1) + usize::from(kind >= 2)..][..run.len()].copy_from_slice(&run);
        let data = [
            gpu.storage(positions),
            gpu.storage(mesh.faces()),
            gpu.storage(self.facing),
            gpu.storage(self.excluded),
            gpu.storage(&lists),
        ];
        let instances = if listed.len() > capacity { mesh.faces().len() } else { listed.len() };
        self.run(gpu, shapes, ShadowShape { near_capacity, far_capacity, ..self.shape }, &data, instances)
    }
}

fn same_bits(what: &str, found: &[[f32; 4]], expected: &[[f32; 4]]) -> Result<(), String> {
    let bits = |vertices: &[[f32; 4]]| vertices.iter().map(|vertex| vertex.map(f32::to_bits)).collect::<Vec<_>>();
    same(what, &bits(found), &bits(expected))
}
