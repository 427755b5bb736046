//! The scene: meshes, casters and lights, and their extraction.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use slotmap::{DefaultKey, SlotMap};

use super::caster::{Caster, CasterEntry, CasterPositions, Content, MeshEntry, OccludedFacesOfLight, Placement, Rigid};
use super::handles::{CasterHandle, LightHandle, MeshHandle, SceneId};
use super::lights::Lights;
use super::mask::LightMask;
use super::model::{Deformed, ModelEntry};
use super::occluders;
use super::options::{Capacities, Measuring, SceneOptions};
use super::pages::Pages;
use super::receivers::ViewVersion;
use super::structure::{Room, Structure};
use super::table::Table;
use super::topology::Topology;
use super::volumes::Volumes;
use crate::gpu::common::pass::Step;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::Subject;
use crate::gpu::extract::of_scene::PolygonMesh;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::format::Casters;
use crate::gpu::shadow::pipelines::check_count_bits;
use crate::{Light, Mesh, Transform};

/// Many casters and lights, whose silhouettes are extracted together. Casters share the stored mesh. The commands of an
/// encode do not grow with the number of casters, but with that of position buffers, models and casters of polygons. It
/// uploads a table of all casters and their lights, of which only what moved is computed again.
///
/// Once: add meshes, lights and casters. Each frame: change what moved, call [`Scene::encode`], draw the depths of what is
/// seen, and for each light draw its shadows by [`SceneFrame::draw`](crate::gpu::SceneFrame::draw) and add its light.
/// The README has this in short; the example `scene` is a whole program.
///
/// No casters and no lights are legal, and so are mirrored and singular transforms.
#[derive(Debug)]
pub struct Scene {
    pub(crate) id: SceneId,
    pub(crate) pipelines: Pipelines,
    pub(super) queue: wgpu::Queue,
    pub(super) options: SceneOptions,
    pub(super) content: Content,
    pub(super) table: Table,
    /// Casters that changed since the table was written, without need of a new layout. Some may have been removed.
    pub(super) moved: Vec<DefaultKey>,
    /// `None`: the next encode makes a new layout, see [`Structure`].
    pub(super) structure: Option<Arc<Structure>>,
    /// The structure that was made last, current or not. The next one reuses its buffers that are large enough.
    pub(super) last: Option<Arc<Structure>>,
    /// The positions of removed models that `last` binds.
    pub(super) removed: Vec<wgpu::Buffer>,
    /// The steps of `last`.
    pub(super) steps: Vec<Step>,
    /// Shadow volumes of the structure, if any view was asked for.
    pub(super) volumes: Option<Arc<Volumes>>,
    pub(super) room: Room,
    /// The views of the last encode.
    pub(super) view_versions: Vec<ViewVersion>,
    pub(super) models: SlotMap<DefaultKey, ModelEntry>,
    /// The casters of all models, in the order of the structure's words for them.
    pub(super) deforming: Vec<DefaultKey>,
    /// Set if the models were deformed for the next encode.
    pub(super) deformed: Option<Deformed>,
    /// The occluded faces of each light.
    pub(super) occluded: Vec<OccludedFacesOfLight>,
    /// Structures so far.
    pub(super) structures: u32,
    /// Encodes so far, and calls of [`Self::deform`] that recorded.
    pub(super) encodes: Arc<AtomicU64>,
}

impl Scene {
    /// A scene without casters and lights. `pipelines` is the device, or the [`Pipelines`] that many scenes share.
    /// `queue` must be the queue of that device: it uploads topology. With the queue of another device, [`Self::add_mesh`]
    /// causes a validation error on that other device, because wgpu does not say whose queue it is.
    ///
    /// # Errors
    /// [`ShadowError`] if the device lacks what extraction needs, or `max_lights` or `count_bits` is impossible.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        queue: &wgpu::Queue,
        options: SceneOptions,
    ) -> Result<Self, ShadowError> {
        let mut options = options;
        options.stencil.count_batches = options.stencil.count_batches.max(1);
        let pipelines: Pipelines = pipelines.into();
        pipelines.construct(Subject::Extract, || Ok::<_, ShadowError>(()))?;
        let casters = if options.stencil.count_batches > 1 { Casters::Batches } else { Casters::Scene };
        check_count_bits(options.stencil.count_bits, casters)?;
        let id = SceneId::next();
        Ok(Self {
            id,
            content: Content {
                meshes: SlotMap::new(),
                pages: Pages::default(),
                casters: SlotMap::new(),
                lights: Lights::new(id, options.max_lights)?,
            },
            pipelines,
            queue: queue.clone(),
            options,
            table: Table {
                culls_by_range: !options.measuring.has(Measuring::CULLED_BY_RANGE),
                culls_by_occluders: !options.measuring.has(Measuring::CULLED_BY_OCCLUDERS),
                ..Table::default()
            },
            moved: Vec::new(),
            structure: None,
            last: None,
            removed: Vec::new(),
            steps: Vec::new(),
            volumes: None,
            room: Room::default(),
            view_versions: Vec::new(),
            models: SlotMap::new(),
            deforming: Vec::new(),
            deformed: None,
            occluded: Vec::new(),
            structures: 0,
            encodes: Arc::default(),
        })
    }

    /// Changes the room of lists, from the next encode on.
    pub fn set_capacities(&mut self, capacities: Capacities) {
        if self.options.capacities != capacities {
            self.options.capacities = capacities;
            self.structure = None;
        }
    }

    /// Uploads a mesh. `positions` are those of its source vertices in mesh space. Rigid casters read them. For casters with
    /// a position buffer, give the positions at rest. Positions that are not finite are allowed; their faces never face a
    /// light.
    ///
    /// # Errors
    /// [`ShadowError`] if positions are missing, or the mesh does not fit one binding, the memory limit or the device.
    /// Polygons of [`Mesh::from_polygons_by_loop`] have boundaries of at most
    /// [`MAX_BOUNDARY_EDGES`](crate::gpu::MAX_BOUNDARY_EDGES) edges.
    pub fn add_mesh(&mut self, mesh: &Mesh, positions: &[[f32; 3]]) -> Result<MeshHandle, ShadowError> {
        let needed = mesh.vertex_count();
        let Some(positions) = positions.get(..needed as usize) else {
            return Err(ShadowError::TooFewPositions { given: positions.len(), needed });
        };
        let topology = self.topology(mesh, positions);
        Ok(MeshHandle { scene: self.id, key: self.add_topology(mesh, &topology, positions)? })
    }

    /// Uploads a mesh with its topology and positions.
    pub(super) fn add_topology(
        &mut self,
        mesh: &Mesh,
        topology: &Topology<'_>,
        positions: &[[f32; 3]],
    ) -> Result<DefaultKey, ShadowError> {
        let (device, used, limit) = (self.pipelines.device(), self.used(), self.options.memory_limit);
        let polygons = PolygonMesh::new(device, mesh, used, limit)?;
        let further = polygons.as_ref().map_or(0, PolygonMesh::bytes);
        let region = self.content.pages.add(
            device,
            topology,
            positions.len() as u32,
            polygons.is_some(),
            used + further,
            limit,
        )?;
        if let Err(error) = self.content.pages.upload(device, &self.queue, &region, topology, positions) {
            self.content.pages.free(region);
            return Err(error.into());
        }
        self.content.pages.bytes += further;
        let entry = MeshEntry::new(region, mesh, positions, topology.order.clone(), polygons);
        Ok(self.content.meshes.insert(Arc::new(entry)))
    }

    /// The bytes of all buffers.
    pub(super) fn used(&self) -> u64 {
        let volumes = self.volumes.as_ref().map_or(0, |volumes| volumes.buffers.bytes);
        let last = self.last.as_ref().map_or(0, |last| last.bytes() + last.removed_bytes(&self.content.pages));
        let removed: u64 = self.removed.iter().map(wgpu::Buffer::size).sum();
        last + removed + volumes + self.deformed_bytes() + self.content.pages.bytes
    }

    /// The bytes of the deformers of models.
    pub(super) fn deformed_bytes(&self) -> u64 {
        self.models.values().map(|model| model.deformer.bytes).sum()
    }

    /// The topology of a mesh to upload.
    fn topology<'a>(&self, mesh: &'a Mesh, positions: &[[f32; 3]]) -> Topology<'a> {
        let clusters_from = self.options.clusters_from;
        let is_in_clusters = clusters_from.is_some_and(|least| mesh.faces().len() >= least.max(1) as usize);
        if is_in_clusters && mesh.polygons().is_none() {
            Topology::in_clusters(mesh, positions)
        } else {
            Topology::plain(mesh)
        }
    }

    /// Removes a mesh that no caster has. Its memory is not freed, unless it has polygons: after the second encode from now, a
    /// new mesh may overwrite it in the buffers. So submit or drop encoders that hold earlier encodes before you add a mesh
    /// then.
    ///
    /// # Errors
    /// [`ShadowError::MeshInUse`], or an error of the handle.
    pub fn remove_mesh(&mut self, mesh: MeshHandle) -> Result<(), ShadowError> {
        let key = mesh.key_in(self.id)?;
        let entry = self.content.meshes.get(key).ok_or(ShadowError::Removed { what: "mesh" })?;
        // Only casters share it.
        let casters = Arc::strong_count(entry) - 1;
        if casters > 0 {
            return Err(ShadowError::MeshInUse { casters });
        }
        if let Some(entry) = self.content.meshes.remove(key) {
            self.content.pages.bytes -= entry.polygons.as_ref().map_or(0, PolygonMesh::bytes);
            self.content.pages.free(entry.region.clone());
        }
        Ok(())
    }

    /// Adds a light. It takes the lowest free bit.
    ///
    /// # Errors
    /// [`ShadowError::Light`] for a light that is refused, or [`ShadowError::NoLightBit`].
    pub fn add_light(&mut self, light: Light) -> Result<LightHandle, ShadowError> {
        let handle = self.content.lights.add(light)?;
        self.structure = None;
        Ok(handle)
    }

    /// Changes a light. It keeps its bit.
    ///
    /// # Errors
    /// [`ShadowError::Light`] for a light that is refused, or an error of the handle.
    pub fn set_light(&mut self, handle: LightHandle, light: Light) -> Result<(), ShadowError> {
        self.content.lights.set(handle, light)
    }

    /// Removes a light and frees its bit.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn remove_light(&mut self, handle: LightHandle) -> Result<(), ShadowError> {
        self.content.lights.remove(handle)?;
        self.structure = None;
        Ok(())
    }

    /// Adds a caster.
    ///
    /// # Errors
    /// An error of the mesh's handle, or of the position buffer.
    pub fn insert(&mut self, caster: Caster) -> Result<CasterHandle, ShadowError> {
        let Caster { mesh, positions, lights, in_depth } = caster;
        let mesh = self.content.meshes.get(mesh.key_in(self.id)?).ok_or(ShadowError::Removed { what: "mesh" })?;
        let placement = Placement::new(&self.pipelines, positions, mesh.vertices)?;
        self.structure = None;
        let entry = CasterEntry {
            mesh: Arc::clone(mesh),
            lights,
            in_depth,
            excluded: Vec::new(),
            occluders: Vec::new(),
            occluded: Vec::new(),
            placement,
            is_moved: false,
            version: 0,
            bounds: None,
            positions_version: None,
            is_of_model: false,
            deforming_index: 0,
            index: 0,
            first_light: 0,
        };
        Ok(CasterHandle { scene: self.id, key: self.content.casters.insert(entry) })
    }

    /// Moves a rigid caster. A caster with a buffer moves by what is written to the buffer; another buffer is given by
    /// [`Self::set_positions`].
    ///
    /// # Errors
    /// [`ShadowError::NotRigid`], [`ShadowError::OfModel`], or an error of the handle.
    pub fn set_transform(
        &mut self,
        caster: CasterHandle,
        mesh_to_world: impl Into<Transform>,
    ) -> Result<(), ShadowError> {
        let mesh_to_world = mesh_to_world.into().rows();
        let entry = self.entry_of_caller(caster)?;
        let Placement::Rigid(rigid) = &mut entry.placement else { return Err(ShadowError::NotRigid) };
        if bytemuck::bytes_of(&rigid.rows) != bytemuck::bytes_of(&mesh_to_world) {
            *rigid = Rigid::new(mesh_to_world);
            self.mark_changed(caster.key);
        }
        Ok(())
    }

    /// States the version of the positions in a caster's buffer. While it stays the same, the positions must stay the same,
    /// and results are cached. Default, also after [`Self::set_positions`]: `None`, the positions may change in each encode.
    ///
    /// # Errors
    /// [`ShadowError::NoBuffer`] for a rigid caster, [`ShadowError::OfModel`], or an error of the handle.
    pub fn set_position_version(&mut self, caster: CasterHandle, version: Option<u64>) -> Result<(), ShadowError> {
        let entry = self.entry_in_buffer(caster)?;
        if entry.positions_version != version {
            entry.positions_version = version;
            self.mark_changed(caster.key);
        }
        Ok(())
    }

    /// States a box, its lowest and its highest corner in world space, that holds all positions of a caster's buffer from
    /// the next encode on. A light whose range or cone misses the box, or that [occluders](Self::set_occluders) hide the box
    /// from, then costs nothing for the caster. Default, also after [`Self::set_positions`]: `None`, the positions may be
    /// anywhere.
    ///
    /// Finite positions outside the box may lack shadows. The box of a model at rest does not hold for a pose:
    /// [`ModelBounds`](crate::ModelBounds) computes boxes of poses. [`Self::set_pose`] states the boxes of instances.
    ///
    /// # Errors
    /// [`ShadowError::NoBuffer`] for a rigid caster, [`ShadowError::OfModel`], [`ShadowError::Bounds`] for a box that
    /// is none, or an error of the handle.
    pub fn set_bounds(&mut self, caster: CasterHandle, bounds: Option<[[f32; 3]; 2]>) -> Result<(), ShadowError> {
        let entry = self.entry_in_buffer(caster)?;
        if let Some([low, high]) = bounds
            && !low.iter().zip(high).all(|(low, high)| low.is_finite() && high.is_finite() && *low <= high)
        {
            return Err(ShadowError::Bounds { low, high });
        }
        if entry.bounds != bounds {
            entry.bounds = bounds;
            self.mark_changed(caster.key);
        }
        Ok(())
    }

    /// A caster.
    fn entry(&mut self, caster: CasterHandle) -> Result<&mut CasterEntry, ShadowError> {
        self.content.casters.get_mut(caster.key_in(self.id)?).ok_or(ShadowError::Removed { what: "caster" })
    }

    /// A caster that is no instance of a model.
    fn entry_of_caller(&mut self, caster: CasterHandle) -> Result<&mut CasterEntry, ShadowError> {
        let entry = self.entry(caster)?;
        if entry.is_of_model { Err(ShadowError::OfModel) } else { Ok(entry) }
    }

    /// A caster with positions in a buffer of the caller's.
    fn entry_in_buffer(&mut self, caster: CasterHandle) -> Result<&mut CasterEntry, ShadowError> {
        let entry = self.entry_of_caller(caster)?;
        if let Placement::Rigid(_) = entry.placement { Err(ShadowError::NoBuffer) } else { Ok(entry) }
    }

    /// Marks a caster that must be written to the table.
    pub(super) fn mark_changed(&mut self, key: DefaultKey) {
        if let Some(entry) = self.content.casters.get_mut(key).filter(|entry| !entry.is_moved) {
            entry.is_moved = true;
            self.moved.push(key);
        }
    }

    /// Gives a caster other positions, for example of another buffer. It keeps its handle. Positions in a buffer end its
    /// [occluders](Self::set_occluders). Moving a rigid caster by [`Self::set_transform`] is cheaper.
    ///
    /// # Errors
    /// An error of the position buffer or of the handle, or [`ShadowError::OfModel`].
    pub fn set_positions(
        &mut self,
        caster: CasterHandle,
        positions: impl Into<CasterPositions>,
    ) -> Result<(), ShadowError> {
        let pipelines = self.pipelines.clone();
        let entry = self.entry_of_caller(caster)?;
        entry.placement = Placement::new(&pipelines, positions.into(), entry.mesh.vertices)?;
        (entry.positions_version, entry.bounds) = (None, None);
        if let Placement::World { .. } = entry.placement {
            entry.occluders.clear();
        }
        self.structure = None;
        Ok(())
    }

    /// Changes the lights for which a caster throws shadows.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn set_lights(&mut self, caster: CasterHandle, lights: LightMask) -> Result<(), ShadowError> {
        let entry = self.entry(caster)?;
        if entry.lights != lights {
            entry.lights = lights;
            self.structure = None;
        }
        Ok(())
    }

    /// Excludes faces of a caster for a light: they cast nothing. `faces` are indices of faces in the mesh, and replace those
    /// of an earlier call. An empty list excludes none. An edge between an excluded face and another then bounds the volume,
    /// once.
    ///
    /// Use it for faces whose shadow lies in the shadow of others that cast. Often only the back-facing faces of a closed mesh
    /// cast, so front-facing ones do not stand in for them. Nothing is cached for casters of the same
    /// [group](crate::gpu::SceneFrame::groups) then. Removing the light ends it.
    ///
    /// # Errors
    /// [`ShadowError::NoSuchFace`], [`ShadowError::Polygons`], or an error of a handle.
    pub fn set_excluded(&mut self, caster: CasterHandle, light: LightHandle, faces: &[u32]) -> Result<(), ShadowError> {
        let key = caster.key_in(self.id)?;
        self.content.lights.check(light)?;
        let entry = self.content.casters.get_mut(key).ok_or(ShadowError::Removed { what: "caster" })?;
        let count = entry.mesh.faces;
        if let Some(&face) = faces.iter().find(|&&face| face >= count) {
            return Err(ShadowError::NoSuchFace { face, faces: count });
        }
        if entry.mesh.polygons.is_some() && !faces.is_empty() {
            return Err(ShadowError::Polygons);
        }
        let slots = entry.mesh.slots(faces);
        let before = entry.excluded.iter().find(|(of, _)| *of == light);
        if before.map_or(slots.is_empty(), |(_, before)| *before == slots) {
            // A new layout would discard all that is cached.
            return Ok(());
        }
        entry.excluded.retain(|(of, _)| *of != light && self.content.lights.check(*of).is_ok());
        if !slots.is_empty() {
            entry.excluded.push((light, slots));
        }
        self.structure = None;
        Ok(())
    }

    /// States occluders: polygons in mesh space that **lie wholly on faces of a rigid caster**, for example a face or a
    /// wall. They have 3 to 8 corners, counter-clockwise as those of the faces, and replace those of an earlier call.
    ///
    /// A caster whose box, if it is known (rigid casters, instances of models, [`Self::set_bounds`]), is wholly behind an
    /// occluder, as seen from a light, throws no shadow for this light, because its shadow lies in that of the occluder.
    ///
    /// An occluder culls nothing for a light that its caster does not throw shadows for, from which it does not look convex, or
    /// that is near its plane. On a closed mesh only back-facing occluders cull, so give polygons on all sides. A caster with
    /// excluded faces culls nothing. Each encode tests each occluder for each caster and light, up to 128 in the scene. If
    /// there are more, those of the smallest areas cull nothing.
    ///
    /// # Errors
    /// [`ShadowError::NotRigid`], [`ShadowError::OccluderCorners`], [`ShadowError::OccluderOutside`], or an error of
    /// the handle.
    pub fn set_occluders(&mut self, caster: CasterHandle, polygons: &[&[[f32; 3]]]) -> Result<(), ShadowError> {
        let entry = self.entry(caster)?;
        if matches!(entry.placement, Placement::World { .. }) {
            return Err(ShadowError::NotRigid);
        }
        for (number, polygon) in polygons.iter().enumerate() {
            occluders::check(number, polygon, &entry.mesh)?;
        }
        let occluders: Vec<Arc<[[f32; 3]]>> = polygons.iter().map(|&polygon| polygon.into()).collect();
        if entry.occluders != occluders {
            entry.occluders = occluders;
            self.structure = None;
        }
        Ok(())
    }

    /// Removes a caster.
    ///
    /// # Errors
    /// [`ShadowError::OfModel`], or an error of the handle.
    pub fn remove(&mut self, caster: CasterHandle) -> Result<(), ShadowError> {
        self.entry_of_caller(caster)?;
        self.remove_caster(caster.key);
        Ok(())
    }

    pub(super) fn remove_caster(&mut self, key: DefaultKey) {
        if self.content.casters.remove(key).is_some() {
            self.structure = None;
        }
    }
}
