//! The casters of a frame as all ways to shadows take them, the silhouettes of a file by itself, and faces that
//! other faces hide from the lights.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use rimline::cpu::{self, OccludedFaces, OcclusionCaster, OcclusionOptions, Threads};
use rimline::gpu::{
    Extraction, ExtractionStatistics, Extractor, ExtractorOptions, LightHandle, Scene, ShadowError, StageTimer,
};
use rimline::mesh::MAX_FACES;
use rimline::{Displacement, Geometry, Light, Mesh, MeshError, Predicate, ShadowCamera, wgpu};
use rimline_picture::FacingMasks;

use crate::coincident::is_finite;
use crate::device::{Gpu, GpuError, On as _};
use crate::failure::Failure;
use crate::input::{Input, Positions, Shape};

/// The casters of a frame, the viewer's camera, and the lights.
#[derive(Clone, Copy)]
pub(crate) struct CastInputs<'a> {
    pub(crate) bodies: &'a [PosedModel<'a>],
    /// Bodies that depth maps of the lights must see: `bodies`, or those that they stand in for.
    pub(crate) seen: &'a [PosedModel<'a>],
    pub(crate) camera: &'a ShadowCamera,
    pub(crate) lights: &'a [Light],
}

/// Gives a scene these lights, which have been checked: their handles are in order.
pub(super) fn set_lights(
    scene: &mut Scene,
    handles: &mut Vec<LightHandle>,
    lights: &[Light],
) -> Result<(), ShadowError> {
    for (number, &light) in lights.iter().enumerate() {
        match handles.get(number) {
            Some(&handle) => scene.set_light(handle, light)?,
            None => handles.push(scene.add_light(light)?),
        }
    }
    Ok(())
}

/// Replaces the element of this index by `made`, or adds it behind the last.
pub(super) fn put<T>(list: &mut Vec<T>, number: usize, made: T) {
    match list.get_mut(number) {
        Some(old) => *old = made,
        None => list.push(made),
    }
}

/// The extractor of a single file's mesh, and what it extracted last.
pub(super) struct Extracted {
    extractor: Extractor,
    pub(super) extraction: Option<Extraction>,
    /// Topologies that its mesh was made of.
    topologies: Vec<Topology>,
}

impl Extracted {
    /// `mesh` has some of the file's faces, over its vertices.
    pub(super) fn new(gpu: &Gpu, mesh: &Mesh, body: &PosedModel<'_>, max_lights: usize) -> Result<Self, Failure> {
        let options = ExtractorOptions { max_lights, ..ExtractorOptions::default() };
        let extractor = Extractor::new(&gpu.pipelines, mesh, options).on(gpu)?;
        Ok(Self { extractor, extraction: None, topologies: body.topologies.clone() })
    }

    /// Whether it is of the faces that the body has now: an instance that is mirrored turns its faces.
    pub(super) fn is_of(&self, body: &PosedModel<'_>) -> bool {
        self.topologies == body.topologies
    }

    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        body: &PosedModel<'_>,
        lights: &[Light],
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        self.extraction = Some(self.extractor.encode_timed(encoder, body.positions.buffer(), lights, timer)?);
        Ok(())
    }

    /// Where the facing masks of the body's faces lie. The mesh must have all of them, in their order.
    pub(super) fn facing(&self, body: &PosedModel<'_>) -> FacingMasks {
        let faces = 0..body.faces.len() as u32;
        FacingMasks { slots: faces.clone().collect(), runs: vec![(faces, self.extractor.results().facing.to_vec())] }
    }

    /// The silhouette edges of each light, and the statistics. Waits for the device.
    pub(super) fn found(&self, gpu: &Gpu, lights: usize) -> Result<(Vec<u32>, ExtractionStatistics), GpuError> {
        let results = self.extractor.results();
        let mut silhouettes: Vec<u32> = gpu.read(results.counts)?;
        silhouettes.truncate(lights);
        Ok((silhouettes, gpu.read_first(results.statistics)?))
    }
}

/// The version of all positions: they stay.
pub(super) const VERSION: u64 = 0;

/// Faces whose shadow other faces cast, of the instances of all files.
pub(crate) struct Occlusion {
    /// For each file.
    meshes: Vec<BTreeMap<Topology, Mesh>>,
    /// For each light.
    pub(super) found: Vec<OccludedFaces>,
}

impl Occlusion {
    pub(crate) fn find(bodies: &[PosedModel<'_>], lights: &[Light]) -> Result<Self, Failure> {
        let meshes = |body: &PosedModel<'_>| {
            let topologies: BTreeSet<Topology> = body.topologies.iter().copied().collect();
            let meshes = topologies.into_iter().map(|topology| Ok((topology, body.mesh_of(topology)?)));
            meshes.collect::<Result<BTreeMap<_, _>, Failure>>()
        };
        let meshes = bodies.iter().map(meshes).collect::<Result<Vec<_>, _>>()?;
        let casters: Vec<OcclusionCaster<'_>> =
            meshes.iter().zip(bodies).flat_map(|(meshes, body)| casters(meshes, body)).collect();
        let options = OcclusionOptions::default();
        let search = |&light: &Light| {
            OccludedFaces::find(light, &casters, options, |_, _| ControlFlow::Continue(()))
                .map_err(|error| Failure::usage(format!("{error}; give another light, or leave out --hide-covered")))
        };
        let found = lights.iter().map(search).collect::<Result<Vec<_>, _>>()?;
        drop(casters);
        Ok(Self { meshes, found })
    }

    /// The faces of a file's instances that cast for a light, without occluded ones, as a mesh over the file's vertices. Closed
    /// meshes cast by their back-facing faces here, others by all. There is none if no face casts.
    pub(super) fn casting(
        &self,
        bodies: &[PosedModel<'_>],
        file: usize,
        light: usize,
    ) -> Result<Option<Mesh>, Failure> {
        let (Some(meshes), Some(body), Some(found)) = (self.meshes.get(file), bodies.get(file), self.found.get(light))
        else {
            return Ok(None);
        };
        let first: usize = bodies.iter().take(file).map(|body| body.topologies.len()).sum();
        let (mut faces, mut first_vertex) = (Vec::new(), 0);
        for (number, OcclusionCaster { mesh, positions, .. }) in (first..).zip(casters(meshes, body)) {
            let extracted = cpu::extract(positions, mesh, &[found.light()], Predicate::Exact, Threads::default());
            let facing = extracted.map_err(|error| Failure::usage(error.to_string()))?.facing;
            let occluded = found.faces(number);
            for ((face, corners), mask) in (0_u32..).zip(mesh.faces()).zip(facing) {
                let casts = mask & 1 == 0 || !mesh.is_closed();
                if casts && occluded.binary_search(&face).is_err() {
                    faces.push(corners.map(|vertex| vertex + first_vertex));
                }
            }
            first_vertex += positions.len() as u32;
        }
        body.part(faces)
    }
}

/// The instances of a file, with the positions of one after those of the other.
fn casters<'a>(
    meshes: &'a BTreeMap<Topology, Mesh>,
    body: &'a PosedModel<'_>,
) -> impl Iterator<Item = OcclusionCaster<'a>> {
    let mut rest = body.world.as_slice();
    body.topologies.iter().map(move |topology| {
        let mesh = &meshes[topology];
        let (positions, others) = rest.split_at(mesh.vertex_count() as usize);
        rest = others;
        OcclusionCaster { mesh, positions, version: Some(VERSION) }
    })
}

/// The faces of an instance: those of a geometry, turned if its pose mirrors it. Instances of the same topology share a
/// mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Topology {
    pub(crate) geometry: usize,
    pub(crate) is_turned: bool,
}

pub(crate) struct PosedModel<'a> {
    pub(crate) input: &'a Input,
    displaced: bool,
    shape: Shape<'a>,
    pub(crate) positions: Positions,
    pub(crate) topologies: Vec<Topology>,
    /// Faces of all instances, one after the other, as [`Model::mesh`](rimline::Model::mesh) has them.
    pub(crate) faces: Vec<[u32; 3]>,
    /// World space, as they lie on the GPU.
    pub(crate) world: Vec<[f32; 3]>,
    /// Base colours of the corners of the faces, packed. `None`: the model is shown as clay.
    pub(super) colors: Option<Vec<[u32; 3]>>,
    is_plain: bool,
}

impl<'a> PosedModel<'a> {
    pub(crate) fn new(
        gpu: &Gpu,
        input: &'a Input,
        time_s: f32,
        displacement: Option<&Displacement>,
        is_plain: bool,
    ) -> Result<Self, Failure> {
        let displaced = displacement.is_some();
        let shape = input.shape(time_s, displaced)?;
        let failed = |error: MeshError| Failure::input(&input.file, input.no_mesh(error));
        check_faces(input.model().placed_geometries()).map_err(failed)?;
        let positions = Positions::new(gpu, &shape, displacement).on(gpu)?;
        let (topologies, faces, world, colors) = (Vec::new(), Vec::new(), Vec::new(), None);
        let mut body = Self { input, displaced, shape, positions, topologies, faces, world, colors, is_plain };
        body.set_pose(gpu, time_s).on(gpu)?;
        Ok(body)
    }

    pub(crate) fn pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), Failure> {
        if let Shape::Posed { .. } = self.shape {
            self.shape = self.input.shape(time_s, self.displaced)?;
            self.set_pose(gpu, time_s).on(gpu)?;
        }
        Ok(())
    }

    fn set_pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), GpuError> {
        let instances = self.input.model().instances().iter().zip(self.input.turned(&self.shape));
        let topologies: Vec<Topology> =
            instances.map(|(instance, is_turned)| Topology { geometry: instance.geometry(), is_turned }).collect();
        if topologies != self.topologies {
            self.faces = faces(self.input, &topologies);
            self.colors = if self.is_plain { None } else { self.input.corner_colors(&self.shape) };
            self.topologies = topologies;
        }
        self.positions.submit(gpu, &self.shape, time_s)?;
        self.world = self.positions.read(gpu, &self.shape)?.into_owned();
        Ok(())
    }

    pub(crate) fn mesh_of(&self, topology: Topology) -> Result<Mesh, Failure> {
        let geometry = &self.input.model().geometries()[topology.geometry];
        let mesh = Mesh::from_faces(geometry.positions().len(), topology.faces(geometry, 0).collect());
        mesh.map_err(|error| Failure::input(&self.input.file, error))
    }

    /// A mesh of some faces over all vertices, or none of none.
    pub(super) fn part(&self, faces: Vec<[u32; 3]>) -> Result<Option<Mesh>, Failure> {
        match Mesh::from_faces(self.world.len(), faces) {
            Err(MeshError::NoFaces) => Ok(None),
            mesh => mesh.map(Some).map_err(|error| Failure::input(&self.input.file, error)),
        }
    }

    pub(crate) fn mesh(&self) -> Result<Mesh, Failure> {
        self.input.mesh(&self.shape)
    }

    /// Whether the mesh has polygons. The faces are their triangles.
    pub(crate) fn has_polygons(&self) -> bool {
        self.input.polygons().is_some()
    }

    /// The triangles of polygons, as a mesh over the same vertices.
    pub(crate) fn triangles(&self) -> Result<Option<Mesh>, Failure> {
        if self.has_polygons() { self.part(self.faces.clone()) } else { Ok(None) }
    }

    /// The vertices of the faces that are drawn, those with finite positions; each once.
    pub(crate) fn points(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        let is_drawn = |face: &&[u32; 3]| is_finite(&self.world, face);
        let mut is_used = vec![false; self.world.len()];
        for &v in self.faces.iter().filter(is_drawn).flatten() {
            is_used[v as usize] = true;
        }
        self.world.iter().zip(is_used).filter_map(|(&position, is_used)| is_used.then_some(position))
    }
}

impl Topology {
    /// The faces, with vertices counted from `first_vertex` on.
    fn faces(self, geometry: &Geometry, first_vertex: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        geometry.faces().iter().map(move |&face| {
            let [a, b, c] = face.map(|v| v + first_vertex);
            if self.is_turned { [a, c, b] } else { [a, b, c] }
        })
    }
}

/// The faces of all instances, with the vertices of one after those of the other.
fn faces(input: &Input, topologies: &[Topology]) -> Vec<[u32; 3]> {
    let mut faces = Vec::new();
    let mut first_vertex = 0;
    for (geometry, topology) in input.model().placed_geometries().zip(topologies) {
        faces.extend(topology.faces(geometry, first_vertex));
        first_vertex += geometry.positions().len() as u32;
    }
    faces
}

/// Refuses models without faces, and those whose instances would fill the memory.
fn check_faces<'a>(geometries: impl Iterator<Item = &'a Geometry>) -> Result<(), MeshError> {
    match geometries.fold(0, |sum: usize, geometry| sum.saturating_add(geometry.faces().len())) {
        0 => Err(MeshError::NoFaces),
        faces if faces > MAX_FACES => Err(MeshError::TooManyFaces { faces }),
        _ => Ok(()),
    }
}
