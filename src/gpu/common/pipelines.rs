//! Pipelines made from the list of stages, and sharing of pipelines.

use std::cmp::Reverse;
use std::fmt;
use std::sync::{Arc, OnceLock};

use super::bindings::{Bindings, READ, Resource, entries, part};
use super::cache::Cache;
use super::device_error::DeviceError;
use super::memory::any_error;
use super::pass::{Dispatch, Step, Workgroups};
use super::positions::bound;
use super::requirements::{Subject, check_alive, check_device};
use super::together::{threads, together};
use crate::displace::Displacement;
use crate::gpu::shadow::format::VolumeKey;
use crate::stages::{DEFORM, Stage};

/// The pipelines of one device: all that compute, and those that draw volumes of meshes. Each is compiled when it is first
/// needed and then shared by everything that is made with the same `Pipelines` or a clone of it, on any thread. Other
/// pipelines that draw belong to the object that made them. Make one for each device, and give it to every constructor:
/// [`Scene::new`](crate::gpu::Scene::new), [`ShadowPipelines::new`](crate::gpu::ShadowPipelines::new),
/// [`Extractor::new`](crate::gpu::Extractor::new), [`OutlinePipeline::new`](crate::gpu::OutlinePipeline::new),
/// [`ShadowMasks::new`](crate::gpu::ShadowMasks::new), [`ShadowQuery::new`](crate::gpu::ShadowQuery::new),
/// [`Deformer::new`](crate::gpu::Deformer::new), and those of depth maps. Each of them also takes a `&wgpu::Device`,
/// and then has pipelines of its own.
///
/// ```no_run
/// # use rimline::gpu::{Extractor, ExtractorError, ExtractorOptions, Pipelines};
/// # fn extractors(device: &rimline::wgpu::Device, meshes: &[rimline::Mesh]) -> Result<Vec<Extractor>, ExtractorError> {
/// let pipelines = Pipelines::new(device);
/// meshes.iter().map(|mesh| Extractor::new(&pipelines, mesh, ExtractorOptions::default())).collect()
/// # }
/// ```
///
/// Options and formats have pipelines of their own, and so has a mesh with an array of several bindings. Meshes of other
/// sizes share. Displacements share a pipeline if their sources are equal and their bind group layout is the same object.
/// Pipelines live until the last clone, and the last thing made with it, are dropped. If a displacement changes again and
/// again, give [`Deformer::new`](crate::gpu::Deformer::new) the device, or the pipelines of all its sources stay.
///
/// Each constructor first compares the device with the needs of its stages. This happens once for each `Pipelines` and kind
/// of stages, such as extraction. The first limit that does not do gives a [`DeviceError`] with its name, the value needed
/// and the value of the device. The first downlevel flag that is missing gives one with the flag's name.
///
/// Limits are compared in browsers, too. Other errors of the device come later there than a function that does not wait
/// can return: running out of memory, a buffer of another device, attachments that the device refuses. They go to the
/// device's own handler, [`wgpu::Device::on_uncaptured_error`]. Only [`wgpu::Device::set_device_lost_callback`] tells
/// of a lost device there.
#[derive(Clone)]
pub struct Pipelines(Arc<Shared>);

struct Shared {
    device: wgpu::Device,
    /// Shader modules by their source.
    modules: Cache<String, wgpu::ShaderModule>,
    layouts: Cache<LayoutKey, wgpu::BindGroupLayout>,
    /// Bindings by the name of the stage's module.
    bindings: Cache<&'static str, Arc<Bindings>>,
    compute: Cache<Program, Pipeline>,
    volumes: Cache<VolumeKey, wgpu::RenderPipeline>,
    /// Whether the device has what each [`Subject`] needs. It is checked once.
    serves: [OnceLock<Result<(), DeviceError>>; 5],
}

/// A bind group layout: its label and its entries.
type LayoutKey = (&'static str, Vec<wgpu::BindGroupLayoutEntry>);

/// An entry point of a stage, with constants, and what a caller adds: all that a compute pipeline is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Program {
    stage: &'static Stage,
    entry_point: &'static str,
    /// Names and bits of the constants.
    constants: Vec<(&'static str, u64)>,
    /// The caller's part of the module, and the layout of its bind group, which is group 1.
    displacement: Option<Displacement>,
    displacement_layout: Option<wgpu::BindGroupLayout>,
}

/// A constant that is 1 or 0.
pub(crate) fn switch(is_on: bool) -> f64 {
    f64::from(u8::from(is_on))
}

impl Program {
    /// The entry point with the name of the stage.
    pub(crate) fn of(stage: &'static Stage, constants: &[(&'static str, f64)]) -> Self {
        Self::at(stage, stage.name, constants)
    }

    /// An entry point of a stage.
    pub(crate) fn at(stage: &'static Stage, entry_point: &'static str, constants: &[(&'static str, f64)]) -> Self {
        let constants = constants.iter().map(|&(name, value)| (name, value.to_bits())).collect();
        Self { stage, entry_point, constants, displacement: None, displacement_layout: None }
    }

    /// The deform stage, with a displacement and the layout of its bind group.
    pub(crate) fn deform(displacement: Option<&Displacement>, layout: Option<&wgpu::BindGroupLayout>) -> Self {
        let (displacement, displacement_layout) = (displacement.cloned(), layout.cloned());
        Self { displacement, displacement_layout, ..Self::of(&DEFORM, &[]) }
    }

    fn wgsl(&self) -> String {
        self.displacement.as_ref().map_or_else(|| self.stage.wgsl(), Displacement::deform_wgsl)
    }
}

impl Pipelines {
    /// No pipelines yet. Nothing is compiled here.
    pub fn new(device: &wgpu::Device) -> Self {
        Self(Arc::new(Shared {
            device: device.clone(),
            modules: Cache::default(),
            layouts: Cache::default(),
            bindings: Cache::default(),
            compute: Cache::default(),
            volumes: Cache::default(),
            serves: Default::default(),
        }))
    }

    /// Runs a constructor, if the device is alive and has what `subject` needs. Other errors of the device are returned
    /// too, except in a browser; see [`super::memory::scoped`].
    pub(crate) fn construct<T, E: From<DeviceError>>(
        &self,
        subject: Subject,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.0.serves[subject as usize].get_or_init(|| check_device(self.device(), subject)).clone()?;
        check_alive(self.device())?;
        any_error(self.device(), make).unwrap_or_else(|message| Err(DeviceError::Refused { message }.into()))
    }

    /// The device of these pipelines.
    pub fn device(&self) -> &wgpu::Device {
        &self.0.device
    }

    /// The number of shared pipelines made so far. Waits for those that other threads are making.
    #[doc(hidden)]
    pub fn len(&self) -> usize {
        self.0.compute.len() + self.0.volumes.len()
    }

    /// Whether no shared pipeline was made yet.
    #[doc(hidden)]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The pipeline of an entry point of a stage.
    pub(crate) fn compute(
        &self,
        stage: &'static Stage,
        entry_point: &'static str,
        constants: &[(&'static str, f64)],
    ) -> Pipeline {
        self.get(&Program::at(stage, entry_point, constants))
    }

    /// The pipeline of a program.
    pub(crate) fn get(&self, program: &Program) -> Pipeline {
        self.0.compute.get(self.device(), program, || Pipeline::new(self, program, &program.wgsl()))
    }

    /// Makes the pipelines of these programs that do not exist, on several threads but with OpenGL. A pipeline that the
    /// device refuses is not cached, so [`Self::get`] makes it again and the device reports the error there.
    pub(crate) fn make_together(&self, programs: &[Program]) {
        let missing = programs.iter().filter(|program| !self.0.compute.has(program));
        let mut missing: Vec<_> = missing.map(|program| (program, program.wgsl())).collect();
        // The longest sources first: a long compilation that began last would keep the others waiting.
        missing.sort_by_key(|(_, wgsl)| Reverse(wgsl.len()));
        together(threads(self.device()), &missing, |(program, wgsl)| {
            self.0.compute.fill(self.device(), *program, || Pipeline::new(self, program, wgsl));
        });
    }

    /// The same for pipelines of volumes.
    pub(crate) fn make_volumes(
        &self,
        keys: &[VolumeKey],
        make: impl Fn(&VolumeKey) -> wgpu::RenderPipeline + wgpu::WasmNotSync,
    ) {
        let missing: Vec<_> = keys.iter().filter(|key| !self.0.volumes.has(key)).collect();
        let threads = threads(self.device());
        together(threads, &missing, |key| self.0.volumes.fill(self.device(), *key, || make(key)));
    }

    /// A pipeline that draws volumes. `make` makes it if it does not exist.
    pub(crate) fn volume(&self, key: &VolumeKey, make: impl Fn() -> wgpu::RenderPipeline) -> wgpu::RenderPipeline {
        self.0.volumes.get(self.device(), key, make)
    }

    /// A shader module.
    pub(crate) fn module(&self, label: &str, wgsl: &str) -> wgpu::ShaderModule {
        self.0.modules.get(self.device(), &wgsl.to_owned(), || {
            self.device().create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            })
        })
    }

    /// Refuses a caller's buffer that the device cannot bind.
    pub(crate) fn check_bindable(&self, buffer: &wgpu::Buffer) -> Result<(), DeviceError> {
        self.check_all_bindable(std::slice::from_ref(buffer))
    }

    /// The same for several buffers.
    pub(crate) fn check_all_bindable(&self, buffers: &[wgpu::Buffer]) -> Result<(), DeviceError> {
        if buffers.is_empty() {
            return Ok(());
        }
        let layout = self.layout("bindable", entries(wgpu::ShaderStages::COMPUTE, [(0, READ)]));
        bound(self.device(), || {
            for buffer in buffers {
                drop(group(self.device(), "bindable", &layout, &[part(buffer, 0..4)]));
            }
        })
    }

    /// A bind group layout.
    pub(crate) fn layout(
        &self,
        label: &'static str,
        entries: Vec<wgpu::BindGroupLayoutEntry>,
    ) -> wgpu::BindGroupLayout {
        let key = (label, entries);
        self.0.layouts.get(self.device(), &key, || {
            let (label, entries) = (Some(key.0), &key.1[..]);
            self.device().create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries })
        })
    }
}

impl fmt::Debug for Pipelines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (compute, render) = (self.0.compute.len(), self.0.volumes.len());
        f.debug_struct("Pipelines").field("compute", &compute).field("render", &render).finish_non_exhaustive()
    }
}

/// Pipelines that are not shared with anything else.
impl From<&wgpu::Device> for Pipelines {
    fn from(device: &wgpu::Device) -> Self {
        Self::new(device)
    }
}

/// The same pipelines.
impl From<&Self> for Pipelines {
    fn from(pipelines: &Self) -> Self {
        pipelines.clone()
    }
}

/// A pipeline of a stage, with its bind group layout.
#[derive(Clone, Debug)]
pub(crate) struct Pipeline {
    pub(crate) label: &'static str,
    pub(crate) compute: wgpu::ComputePipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
    bindings: Arc<Bindings>,
}

impl Pipeline {
    fn new(pipelines: &Pipelines, program: &Program, wgsl: &str) -> Self {
        let Program { stage, entry_point, ref constants, ref displacement_layout, .. } = *program;
        let constants: Vec<_> = constants.iter().map(|&(name, bits)| (name, f64::from_bits(bits))).collect();
        let module = pipelines.module(stage.module, wgsl);
        // A displacement adds none to group 0, so the module's name is enough as a key.
        let read = || Arc::new(Bindings::of(wgsl));
        let bindings = pipelines.0.bindings.get(pipelines.device(), &stage.module, read);
        let layout = pipelines.layout(stage.name, bindings.named().map(|(_, entry)| entry).collect());
        let mut groups = vec![Some(&layout)];
        groups.extend(displacement_layout.as_ref().map(Some));
        let device = pipelines.device();
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry_point),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let compute = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            cache: None,
        });
        Self { label: entry_point, compute, layout, bindings }
    }

    /// A dispatch of the stage with its bind group. `get` gives the resource of each name that the WGSL has. If one is
    /// missing, the device refuses the bind group.
    pub(crate) fn dispatch<'a>(
        &self,
        device: &wgpu::Device,
        workgroups: Workgroups,
        get: impl Fn(&str) -> Option<Resource<'a>>,
    ) -> Dispatch {
        let (mut entries, mut offsets) = (Vec::new(), Vec::new());
        for (name, entry) in self.bindings.named() {
            let Some(Resource { bound, offset }) = get(name) else { continue };
            entries.push(wgpu::BindGroupEntry { binding: entry.binding, resource: bound });
            // Only uniforms have a dynamic offset.
            if matches!(entry.ty, wgpu::BindingType::Buffer { has_dynamic_offset: true, .. }) {
                offsets.push(offset);
            }
        }
        let (label, layout) = (Some(self.label), &self.layout);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries });
        Dispatch { pipeline: self.compute.clone(), group, offsets, workgroups }
    }

    /// A pass of the stage's dispatches.
    pub(crate) fn pass(&self, dispatches: impl IntoIterator<Item = Dispatch>) -> Step {
        Step::Pass(self.label, dispatches.into_iter().collect())
    }
}

/// A bind group with `resources` numbered from 0. Their dynamic offsets are not in it; who sets the group gives them.
pub(crate) fn group(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[Resource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.bound.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
