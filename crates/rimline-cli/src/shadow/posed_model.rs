//! A file's model at one posed.

use rimline::internals::cpu::is_finite;
use rimline::mesh::MAX_FACES;
use rimline::{Displacement, Geometry, Mesh, MeshError};

use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};
use crate::input::{Input, Shape};
use crate::posed_input::Positions;

/// The faces of an instance: those of a geometry, turned if its pose mirrors it. Instances of the same topology share a
/// mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Topology {
    pub(crate) geometry: usize,
    pub(crate) is_turned: bool,
}

pub(crate) struct PosedModel<'a> {
    pub(crate) input: &'a Input,
    pub(super) animations: &'a [usize],
    displaced: bool,
    shape: Shape<'a>,
    pub(crate) positions: Positions,
    /// Topology of each instance.
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
        animations: &'a [usize],
        time_s: f32,
        displacement: Option<&Displacement>,
        is_plain: bool,
    ) -> Result<Self, Failure> {
        let displaced = displacement.is_some();
        let shape = input.shape(animations, time_s, displaced)?;
        let failed = |error: MeshError| Failure::input(&input.file)(input.no_mesh(error));
        check_faces(input.model().placed_geometries()).map_err(failed)?;
        let positions = Positions::new(gpu, &shape, displacement).on(gpu)?;
        let (topologies, faces, world, colors) = (Vec::new(), Vec::new(), Vec::new(), None);
        let mut body =
            Self { input, animations, displaced, shape, positions, topologies, faces, world, colors, is_plain };
        body.set_pose(gpu, time_s).on(gpu)?;
        Ok(body)
    }

    pub(crate) fn pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), Failure> {
        if let Shape::Posed { .. } = self.shape {
            self.shape = self.input.shape(self.animations, time_s, self.displaced)?;
            self.set_pose(gpu, time_s).on(gpu)?;
        }
        Ok(())
    }

    fn set_pose(&mut self, gpu: &Gpu, time_s: f32) -> Result<(), GpuError> {
        let topologies = self.topologies_now();
        if topologies != self.topologies {
            self.faces = faces(self.input, &topologies);
            self.colors = if self.is_plain { None } else { self.input.corner_colors(&self.shape) };
            self.topologies = topologies;
        }
        match &self.shape {
            Shape::World(positions) => self.world = positions.to_vec(),
            Shape::Posed { model, .. } => {
                let mut encoder = gpu.encoder("deform");
                self.positions.encode(&mut encoder, &self.shape, time_s, None)?;
                gpu.submit(encoder);
                self.world = self.positions.read(gpu, model.vertex_count())?;
            }
        }
        Ok(())
    }

    fn topologies_now(&self) -> Vec<Topology> {
        let instances = self.input.model().instances().iter().zip(self.input.turned(&self.shape));
        instances.map(|(instance, is_turned)| Topology { geometry: instance.geometry(), is_turned }).collect()
    }

    pub(crate) fn mesh_of(&self, topology: Topology) -> Result<Mesh, Failure> {
        let geometry = &self.input.model().geometries()[topology.geometry];
        let mesh = Mesh::from_faces(geometry.positions().len(), topology.faces(geometry, 0).collect());
        mesh.map_err(|error| Failure::input(&self.input.file)(error.into()))
    }

    /// A mesh of some faces over so many vertices, or none of none.
    pub(super) fn part(&self, vertices: usize, faces: Vec<[u32; 3]>) -> Result<Option<Mesh>, Failure> {
        match Mesh::from_faces(vertices, faces) {
            Err(MeshError::NoFaces) => Ok(None),
            mesh => mesh.map(Some).map_err(|error| Failure::input(&self.input.file)(error.into())),
        }
    }

    /// The mesh that all instances make together.
    pub(crate) fn mesh(&self) -> Result<Mesh, Failure> {
        self.input.mesh(&self.shape)
    }

    /// Whether the mesh has polygons. The faces are their triangles.
    pub(crate) fn has_polygons(&self) -> bool {
        self.input.polygons().is_some()
    }

    /// The triangles of polygons, as a mesh over the same vertices.
    pub(crate) fn triangles(&self) -> Result<Option<Mesh>, Failure> {
        if self.has_polygons() { self.part(self.world.len(), self.faces.clone()) } else { Ok(None) }
    }

    /// The vertices of the faces that are drawn, those with finite positions; each once.
    pub(crate) fn points(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        let is_drawn = |face: &&[u32; 3]| face.iter().all(|&v| is_finite(self.world[v as usize]));
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
