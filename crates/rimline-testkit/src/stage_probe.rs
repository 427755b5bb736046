//! Functions of the stages, evaluated on the GPU for many cameras, lights and positions at once.

use std::sync::Arc;

use rimline::internals::layout::{ShadowLight, ShadowView, ViewLight};
use rimline::internals::stages::Stage;

use crate::device::Gpu;
use crate::dispatch::Dispatch;

/// Bindings of a probe, beside those of the stage.
const SEEN: u32 = 100;

/// A compute shader in the module of a stage, which calls functions of it.
pub struct Probe {
    stage: Dispatch,
    outputs: usize,
    takes_light: bool,
}

/// The number of a camera and light, and positions.
pub type Input<const N: usize> = (u32, [[f32; 3]; N]);

impl Probe {
    /// `body` sets `out[0]` and so on to four numbers each, from `input_position(0)` and so on, and from `pair`, a
    /// camera and a light, if it names that. Inputs of [`Self::run`] have as many `positions`. A probe is made once for a
    /// device.
    pub fn of(gpu: &Gpu, stage: &Stage, [positions, outputs]: [usize; 2], body: &str) -> Result<Arc<Self>, String> {
        gpu.kept(&format!("{} {positions} {outputs} {body}", stage.module), || {
            let takes_light = body.contains("pair.");
            let pair = if takes_light { "let pair = probe_seen[probe_inputs[probe_first].w];" } else { "" };
            let source = format!(
                "{}
@group(0) @binding({SEEN}) var<storage, read> probe_seen: array<ViewLight>;
@group(0) @binding({}) var<storage, read> probe_inputs: array<vec4<u32>>;
@group(0) @binding({}) var<storage, read_write> probe_found: array<vec4<f32>>;
var<private> probe_first: u32;
fn input_position(number: u32) -> vec3<f32> {{ return bitcast<vec3<f32>>(probe_inputs[probe_first + number].xyz); }}
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {{
  probe_first = id.x * {positions}u;
  if (probe_first < arrayLength(&probe_inputs)) {{
    {pair}
    var out: array<vec4<f32>, {outputs}>;
    {body}
    for (var number = 0u; number < {outputs}u; number++) {{
      probe_found[id.x * {outputs}u + number] = out[number];
    }}
  }}
}}
",
                stage.composed_for(body)?.wgsl,
                SEEN + 1,
                SEEN + 2,
            );
            Ok(Self { stage: Dispatch::new(gpu, &source, "probe"), outputs, takes_light })
        })
    }

    /// `bound` are resources of the stage in group 0.
    pub fn run<const N: usize>(
        &self,
        gpu: &Gpu,
        bound: &[(u32, &wgpu::Buffer)],
        seen: &[(ShadowView, ShadowLight)],
        inputs: &[Input<N>],
    ) -> Result<Vec<Vec<[f32; 4]>>, String> {
        if inputs.is_empty() {
            return Ok(Vec::new());
        }
        let seen: Vec<ViewLight> = seen.iter().map(|(view, light)| seen_light(*view, *light)).collect();
        let words = inputs.iter().flat_map(|(seen, positions)| {
            positions.map(|position| {
                let [x, y, z] = position.map(f32::to_bits);
                [x, y, z, *seen]
            })
        });
        let words: Vec<[u32; 4]> = words.collect();
        let found = gpu.storage(&vec![[0.0_f32; 4]; self.outputs * inputs.len()]);
        let probe_buffers = [(SEEN, &gpu.storage(&seen)), (SEEN + 1, &gpu.storage(&words)), (SEEN + 2, &found)];
        let probe_buffers = &probe_buffers[usize::from(!self.takes_light)..];
        self.stage.run_bound(gpu, &[&[bound, probe_buffers].concat()], (inputs.len() as u32).div_ceil(64))?;
        let found: Vec<[f32; 4]> = gpu.read(&found, usize::MAX)?;
        Ok(found.chunks(self.outputs).map(<[_]>::to_vec).collect())
    }
}

/// A light that a camera sees.
pub fn seen_light(view: ShadowView, light: ShadowLight) -> ViewLight {
    ViewLight { view, light, ..bytemuck::Zeroable::zeroed() }
}
