//! The scene: meshes, casters and lights, and their extraction.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use slotmap::{DefaultKey, SlotMap};

use super::caster::{Caster, CasterEntry, CasterPositions, MeshEntry, Placement, Rigid};
use super::errors::SceneError;
use super::frame::SceneFrame;
use super::handles::{CasterHandle, LightHandle, MeshHandle, SceneId};
use super::layout::put_lights;
use super::lights::Lights;
use super::mask::LightMask;
use super::options::SceneOptions;
use super::pages::Pages;
use super::sources::{Sources, bind};
use super::stages::Passes;
use super::structure::{Making, Number, Structure};
use super::table::{Part, Table};
use super::volumes::Volumes;
use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::common::requirements::{Subject, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::upload;
use crate::gpu::shadow::pipelines::Convention;
use crate::layout::{SeenLight, ShadowView};
use crate::light::check_shadow_lights;
use crate::{Light, Matrix3x4, Mesh, ShadowCamera};

/// Many casters and lights, whose silhouettes are extracted together. A mesh is stored once, however many casters have
/// it. The work of recording an encode does not depend on the number of casters, but for those that moved.
///
/// Once: add meshes, lights and casters. Each frame: change what moved, call [`Scene::encode`], draw the depths of what is
/// seen, and for each light draw its shadows by [`SceneFrame::draw`] and add its light. The README has this in short; the
/// example `scene` is a whole program.
///
/// No casters and no lights are legal, and so are mirrored and singular transforms.
#[derive(Debug)]
pub struct Scene {
    id: SceneId,
    pipelines: Pipelines,
    queue: wgpu::Queue,
    options: SceneOptions,
    meshes: SlotMap<DefaultKey, MeshEntry>,
    casters: SlotMap<DefaultKey, CasterEntry>,
    sources: Sources,
    lights: Lights,
    pages: Pages,
    table: Table,
    /// Casters whose transform is not in the table yet. Some may have been removed.
    moved: Vec<DefaultKey>,
    /// `None`: casters or lights came or went.
    structure: Option<Arc<Structure>>,
    /// The structure before, whose buffers are taken where they are large enough.
    last: Option<Arc<Structure>>,
    /// The passes of the structure.
    passes: Passes,
    /// Shadow volumes of the structure, if any view was asked for.
    volumes: Option<Arc<Volumes>>,
    /// The most views of an encode so far.
    views: usize,
    /// Structures so far.
    structures: u32,
    encodes: Arc<AtomicU64>,
}

impl Scene {
    /// A scene without casters and lights. `pipelines` is the device, or the [`Pipelines`] that many scenes share.
    /// `queue` is the queue of that device; topology is uploaded by it. wgpu does not tell which device a queue is of. To a
    /// queue of another one, [`Self::add_mesh`] causes a validation error on that other device.
    ///
    /// # Errors
    /// [`SceneError`] if the device lacks what extraction needs, or `max_lights` is impossible.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        queue: &wgpu::Queue,
        options: SceneOptions,
    ) -> Result<Self, SceneError> {
        let pipelines: Pipelines = pipelines.into();
        pipelines.construct(Subject::Extract, || Ok::<_, SceneError>(()))?;
        let id = SceneId::next();
        Ok(Self {
            id,
            lights: Lights::new(id, options.max_lights)?,
            pipelines,
            queue: queue.clone(),
            options,
            meshes: SlotMap::new(),
            casters: SlotMap::new(),
            sources: Sources::default(),
            pages: Pages::new(),
            table: Table::default(),
            moved: Vec::new(),
            structure: None,
            last: None,
            passes: Passes::default(),
            volumes: None,
            views: 0,
            structures: 0,
            encodes: Arc::default(),
        })
    }

    /// Uploads a mesh. `positions` are those of its source vertices in mesh space. Rigid casters read them. Casters with a
    /// buffer of their own do not, but the mesh has positions in any case: give those at rest. Positions that are not finite
    /// are allowed; their faces never face a light.
    ///
    /// # Errors
    /// [`SceneError`] if positions are missing, or the mesh does not fit one binding, the memory limit or the device.
    pub fn add_mesh(&mut self, mesh: &Mesh, positions: &[[f32; 3]]) -> Result<MeshHandle, SceneError> {
        let needed = mesh.vertex_count();
        let Some(own) = positions.get(..needed as usize) else {
            return Err(SceneError::TooFewPositions { given: positions.len(), needed });
        };
        let volumes = self.volumes.as_ref().map_or(0, |volumes| volumes.buffers.bytes());
        let used = self.last.as_ref().map_or(0, |last| last.bytes()) + volumes;
        let device = self.pipelines.device();
        let run = self.pages.add(device, mesh, used, self.options.memory_limit)?;
        if let Err(error) = self.pages.upload(device, &self.queue, &run, mesh, own) {
            self.pages.free(run, self.encodes.load(Ordering::Relaxed));
            return Err(error.into());
        }
        let key = self.meshes.insert(MeshEntry::new(run, mesh, own));
        Ok(MeshHandle { scene: self.id, key })
    }

    /// Removes a mesh that no caster has. From the second encode after this on, a new mesh may take its place in the
    /// buffers. So submit or drop encoders that hold earlier encodes before you add a mesh then.
    ///
    /// # Errors
    /// [`SceneError::MeshInUse`], or an error of the handle.
    pub fn remove_mesh(&mut self, mesh: MeshHandle) -> Result<(), SceneError> {
        let key = mesh.key_in(self.id)?;
        let casters = self.meshes.get(key).ok_or(SceneError::Stale { what: "mesh" })?.casters;
        if casters > 0 {
            return Err(SceneError::MeshInUse { casters });
        }
        if let Some(entry) = self.meshes.remove(key) {
            self.pages.free(entry.run, self.encodes.load(Ordering::Relaxed));
        }
        Ok(())
    }

    /// Adds a light. It takes the lowest free bit.
    ///
    /// # Errors
    /// [`SceneError::Light`] for a light that is refused, or [`SceneError::NoLightBit`].
    pub fn add_light(&mut self, light: Light) -> Result<LightHandle, SceneError> {
        let handle = self.lights.add(light)?;
        self.structure = None;
        Ok(handle)
    }

    /// Changes a light. It keeps its bit.
    ///
    /// # Errors
    /// [`SceneError::Light`] for a light that is refused, or an error of the handle.
    pub fn set_light(&mut self, handle: LightHandle, light: Light) -> Result<(), SceneError> {
        self.lights.set(handle, light)
    }

    /// Removes a light and frees its bit.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn remove_light(&mut self, handle: LightHandle) -> Result<(), SceneError> {
        self.lights.remove(handle)?;
        self.structure = None;
        Ok(())
    }

    /// Adds a caster.
    ///
    /// # Errors
    /// An error of the mesh's handle, or of the position buffer.
    pub fn insert(&mut self, caster: Caster) -> Result<CasterHandle, SceneError> {
        let Caster { mesh, positions, lights, in_depth } = caster;
        let mesh = mesh.key_in(self.id)?;
        let (placement, source) = self.place(mesh, positions)?;
        if let Some(entry) = self.meshes.get_mut(mesh) {
            entry.casters += 1;
        }
        self.structure = None;
        let entry = CasterEntry {
            mesh,
            source,
            lights,
            in_depth,
            excluded: Vec::new(),
            placement,
            is_moved: false,
            version: 0,
            positions_version: None,
            index: 0,
            first_light: 0,
        };
        Ok(CasterHandle { scene: self.id, key: self.casters.insert(entry) })
    }

    /// Moves a rigid caster. A caster with a buffer moves by what is written to the buffer; another buffer is given by
    /// [`Self::set_positions`].
    ///
    /// # Errors
    /// [`SceneError::NotRigid`], or an error of the handle.
    pub fn set_transform(&mut self, caster: CasterHandle, mesh_to_world: Matrix3x4) -> Result<(), SceneError> {
        let key = caster.key_in(self.id)?;
        let entry = self.casters.get_mut(key).ok_or(SceneError::Stale { what: "caster" })?;
        let Placement::Rigid(rigid) = &mut entry.placement else { return Err(SceneError::NotRigid) };
        *rigid = Rigid::new(mesh_to_world);
        self.note_change(key);
        Ok(())
    }

    /// Says which version of a caster's positions is in its buffer. While the version stays the same, the positions are the
    /// same, and what was computed from them is kept. `None`, as after [`Self::insert`] and [`Self::set_positions`]: they may
    /// be others in each encode.
    ///
    /// # Errors
    /// [`SceneError::NoBuffer`] for a rigid caster, or an error of the handle.
    pub fn set_position_version(&mut self, caster: CasterHandle, version: Option<u64>) -> Result<(), SceneError> {
        let key = caster.key_in(self.id)?;
        let entry = self.casters.get_mut(key).ok_or(SceneError::Stale { what: "caster" })?;
        if matches!(entry.placement, Placement::Rigid(_)) {
            return Err(SceneError::NoBuffer);
        }
        if entry.positions_version != version {
            entry.positions_version = version;
            self.note_change(key);
        }
        Ok(())
    }

    /// Notes that a caster is to be written to the table.
    fn note_change(&mut self, key: DefaultKey) {
        if let Some(entry) = self.casters.get_mut(key).filter(|entry| !entry.is_moved) {
            entry.is_moved = true;
            self.moved.push(key);
        }
    }

    /// Gives a caster other positions, for example of another buffer. It keeps its handle. Moving a rigid caster by
    /// [`Self::set_transform`] is cheaper.
    ///
    /// # Errors
    /// An error of the position buffer, or of the handle.
    pub fn set_positions(
        &mut self,
        caster: CasterHandle,
        positions: impl Into<CasterPositions>,
    ) -> Result<(), SceneError> {
        let key = caster.key_in(self.id)?;
        let mesh = self.casters.get(key).ok_or(SceneError::Stale { what: "caster" })?.mesh;
        let (placement, source) = self.place(mesh, positions.into())?;
        if let Some(entry) = self.casters.get_mut(key) {
            entry.placement = placement;
            entry.positions_version = None;
            self.sources.give_back(std::mem::replace(&mut entry.source, source));
        }
        self.structure = None;
        Ok(())
    }

    /// Where a caster of a mesh is, and the source of its positions, which counts it.
    fn place(&mut self, mesh: DefaultKey, positions: CasterPositions) -> Result<(Placement, DefaultKey), SceneError> {
        let entry = self.meshes.get(mesh).ok_or(SceneError::Stale { what: "mesh" })?;
        let (page, vertices) = (entry.run.page, entry.vertices);
        let (placement, bound) = match positions {
            CasterPositions::Rigid(matrix) => (Placement::Rigid(Rigid::new(matrix)), None),
            CasterPositions::Buffer { buffer, offset, stride } => {
                let positions = PositionBuffer { buffer: &buffer, offset, stride };
                let (placement, bound) = bind(&self.pipelines, &positions, vertices)?;
                (placement, Some(bound))
            }
        };
        Ok((placement, self.sources.take(page, bound)))
    }

    /// Changes the lights for which a caster throws shadows.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn set_lights(&mut self, caster: CasterHandle, lights: LightMask) -> Result<(), SceneError> {
        let key = caster.key_in(self.id)?;
        let entry = self.casters.get_mut(key).ok_or(SceneError::Stale { what: "caster" })?;
        if entry.lights != lights {
            entry.lights = lights;
            self.structure = None;
        }
        Ok(())
    }

    /// Excludes faces of a caster for a light: they count nowhere, as if the caster had no such faces. `faces` are numbers of
    /// faces in the mesh, and replace those of an earlier call. An empty list excludes none. A surface is then closed by
    /// its boundary: an edge between an excluded face and another bounds the volume once.
    ///
    /// This is for faces of which it is known that their shadow lies in that of others. It goes with the light.
    ///
    /// # Errors
    /// [`SceneError::NoSuchFace`], or an error of a handle.
    pub fn set_excluded(&mut self, caster: CasterHandle, light: LightHandle, faces: &[u32]) -> Result<(), SceneError> {
        let key = caster.key_in(self.id)?;
        self.lights.check(light)?;
        let entry = self.casters.get_mut(key).ok_or(SceneError::Stale { what: "caster" })?;
        let count = self.meshes.get(entry.mesh).map_or(0, |mesh| mesh.faces);
        if let Some(&face) = faces.iter().find(|&&face| face >= count) {
            return Err(SceneError::NoSuchFace { face, faces: count });
        }
        entry.excluded.retain(|(of, _)| *of != light && self.lights.check(*of).is_ok());
        if !faces.is_empty() {
            entry.excluded.push((light, faces.into()));
        }
        self.structure = None;
        Ok(())
    }

    /// Removes a caster.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn remove(&mut self, caster: CasterHandle) -> Result<(), SceneError> {
        let key = caster.key_in(self.id)?;
        let entry = self.casters.remove(key).ok_or(SceneError::Stale { what: "caster" })?;
        if let Some(mesh) = self.meshes.get_mut(entry.mesh) {
            mesh.casters -= 1;
        }
        self.sources.give_back(entry.source);
        self.structure = None;
        Ok(())
    }

    /// Records the extraction of all casters for all lights. One encoder may hold several encodes. Each sees the scene
    /// of its moment, and overwrites the results of the one before. An encoder may be dropped, or submitted after a
    /// later one.
    ///
    /// `cameras` are the views that shadow volumes are prepared for. There may be none. Memory is kept for the most views of
    /// an encode so far. `timer` takes a timestamp around each stage.
    ///
    /// # Errors
    /// [`SceneError`] if a camera is refused, the scene does not fit the device or the memory limit, or the device is lost or
    /// not the timer's. With a camera, lights of negative `w` are refused; `index` is the bit of the light then. Nothing is
    /// recorded then, and the next encode is not affected.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        cameras: &[ShadowCamera],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<SceneFrame, SceneError> {
        check_timer(timer.as_deref(), self.pipelines.device())?;
        let views = self.check_views(cameras)?;
        let (structure, volumes) = self.prepare_views(cameras.len())?;
        let seen = volumes.as_ref().map_or_else(Vec::new, |volumes| self.seen(volumes, cameras, &views));
        let uploaded: &[Part] = self.table.parts.get(..structure.layout.uploaded).unwrap_or_default();
        let mut uploads: Vec<(&wgpu::Buffer, &[u8])> = Vec::new();
        if !structure.parts.is_empty() {
            uploads.push((&structure.table, bytemuck::cast_slice(uploaded)));
            uploads.extend(volumes.iter().map(|volumes| (&volumes.buffers.seen, bytemuck::cast_slice(&seen[..]))));
            upload(self.pipelines.device(), encoder, &uploads)?;
        }
        self.passes.record(&structure, encoder, timer.as_deref_mut());
        if let Some(volumes) = &volumes {
            volumes.record(encoder, timer);
        }
        let encode = self.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        self.pages.reclaim(encode);
        let (encodes, lights) = (Arc::clone(&self.encodes), self.lights.listed());
        let views = cameras.iter().map(|camera| self.convention(camera)).collect();
        let count_batches = self.options.count_batches.max(1);
        let device = self.pipelines.device().clone();
        Ok(SceneFrame { structure, volumes, views, count_batches, device, scene: self.id, lights, encodes, encode })
    }

    /// The cameras as stages see them.
    fn check_views(&self, cameras: &[ShadowCamera]) -> Result<Vec<ShadowView>, SceneError> {
        if cameras.is_empty() {
            return Ok(Vec::new());
        }
        if self.options.counting.is_zp_plus_2005() {
            return Err(SceneError::Counting(self.options.counting));
        }
        // Errors name the bit of a light.
        let none = Light::directional([0.0, 0.0, 1.0]);
        let bits = 0..32 * self.lights.batches() as u32;
        let lights: Vec<Light> = bits.map(|bit| self.lights.get(bit).unwrap_or(none)).collect();
        check_shadow_lights(&lights, lights.len())?;
        let view =
            |(view, camera): (usize, &ShadowCamera)| camera.view().map_err(|error| SceneError::Camera { view, error });
        cameras.iter().enumerate().map(view).collect()
    }

    /// What pipelines must be to draw a camera's volumes.
    fn convention(&self, camera: &ShadowCamera) -> Convention {
        let counting = self.options.counting;
        let is_unclipped = counting.may_fail() && camera.has_far_plane();
        Convention { counting, depth: camera.depth, is_unclipped }
    }

    /// The volumes of the structure.
    fn volumes(&mut self, structure: &Structure) -> Result<Arc<Volumes>, SceneError> {
        if let Some(volumes) = &self.volumes {
            return Ok(Arc::clone(volumes));
        }
        let Self { pipelines, options, meshes, sources, lights, pages, views, .. } = self;
        let making = Making { pipelines, meshes, sources, pages, lights, options, views: *views };
        let others = pages.bytes + structure.bytes();
        let made = Arc::new(Volumes::new(&making, structure, *views, others)?);
        self.volumes = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Each light as each camera sees it. Views that are not used are empty, and their lights reach nothing.
    fn seen(&self, volumes: &Volumes, cameras: &[ShadowCamera], views: &[ShadowView]) -> Vec<SeenLight> {
        let mut seen = Vec::with_capacity(volumes.seen());
        for (camera, &view) in cameras.iter().zip(views) {
            for bit in 0..volumes.lights() as u32 {
                let light = self.lights.get(bit).map(|light| camera.light(&view, light));
                let light = light.unwrap_or_else(bytemuck::Zeroable::zeroed);
                seen.push(SeenLight { view, light, reserved: [[0; 4]; 15] });
            }
        }
        seen.resize(volumes.seen(), bytemuck::Zeroable::zeroed());
        seen
    }

    /// Brings everything up to date, with room for so many views.
    fn prepare_views(&mut self, views: usize) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), SceneError> {
        let before = self.views;
        if views > before {
            self.views = views;
            self.structure = None;
        }
        let made = match self.prepare_all(views) {
            Err(SceneError::Memory(MemoryError::Total { .. } | MemoryError::OutOfMemory { .. })) => {
                // Buffers that are kept may be larger than what is needed.
                (self.structure, self.last, self.volumes) = (None, None, None);
                self.prepare_all(views)
            }
            made => made,
        };
        if made.is_err() && views > before {
            self.views = before;
            self.structure = None;
        }
        made
    }

    fn prepare_all(&mut self, views: usize) -> Result<(Arc<Structure>, Option<Arc<Volumes>>), SceneError> {
        let structure = self.prepare()?;
        let volumes = if views == 0 { None } else { Some(self.volumes(&structure)?) };
        Ok((structure, volumes))
    }

    /// Brings the table up to date.
    fn prepare(&mut self) -> Result<Arc<Structure>, SceneError> {
        let structure = match &self.structure {
            Some(structure) => {
                let structure = Arc::clone(structure);
                self.update(&structure);
                structure
            }
            None => self.lay_out()?,
        };
        self.moved.clear();
        Ok(structure)
    }

    /// The number of the encode at hand.
    fn encode_number(&self) -> u32 {
        (self.encodes.load(Ordering::Relaxed) + 1) as u32
    }

    fn lay_out(&mut self) -> Result<Arc<Structure>, SceneError> {
        self.structures = self.structures.wrapping_add(1).max(1);
        let number = Number { structure: self.structures, encode: self.encode_number() };
        self.lights.renew(number.encode);
        let Self { pipelines, options, meshes, casters, sources, lights, pages, table, .. } = self;
        let making = Making { pipelines, meshes, sources, pages, lights, options, views: self.views };
        let made = Arc::new(Structure::new(&making, casters, table, self.last.as_deref(), number)?);
        self.passes = Passes::new(&making, &made)?;
        self.volumes = None;
        self.last = Some(Arc::clone(&made));
        self.structure = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Writes what moved to the table.
    fn update(&mut self, structure: &Structure) {
        let encode = self.encode_number();
        let Self { casters, lights, table, moved, .. } = self;
        let lights_moved = lights.moved;
        if lights_moved.is_empty() {
            for &key in &*moved {
                let Some(caster) = casters.get_mut(key) else { continue };
                put_change(table, caster, encode);
                put_lights(table, caster, lights);
            }
            return;
        }
        lights.renew(encode);
        table.put_ranges(lights);
        for &key in &structure.layout.order {
            let Some(caster) = casters.get_mut(key) else { continue };
            let is_moved = caster.is_moved;
            if is_moved {
                put_change(table, caster, encode);
            }
            if is_moved || !caster.lights.and(&lights_moved).is_empty() {
                put_lights(table, caster, lights);
            }
        }
    }
}

/// Writes what changed of a caster to the table.
fn put_change(table: &mut Table, caster: &mut CasterEntry, encode: u32) {
    caster.is_moved = false;
    caster.version = encode;
    table.put_change(caster);
}
