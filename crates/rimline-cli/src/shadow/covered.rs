//! Faces that other faces hide from the lights.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::{ControlFlow, Range};

use rimline::cpu::{self, HiddenCaster, HiddenFaces, HiddenOptions, Threads};
use rimline::{Light, Mesh, MeshError, Predicate};

use super::posed_model::{PosedModel, Topology};
use crate::failure::{Failure, UsageError};

/// The version of all positions: they stay.
pub(super) const VERSION: u64 = 0;

/// The casters of all files: the instances of one after those of the other.
pub(crate) struct CoveredFaces {
    files: Vec<File>,
    lights: Vec<Light>,
    /// For each light.
    pub(super) found: Vec<HiddenFaces>,
}

struct File {
    meshes: BTreeMap<Topology, Mesh>,
    /// The topology of each instance, and where its vertices are among the file's.
    instances: Vec<(Topology, Range<usize>)>,
    /// How many instances files before have.
    first: usize,
}

impl CoveredFaces {
    pub(crate) fn find(bodies: &[PosedModel<'_>], lights: &[Light]) -> Result<Self, Failure> {
        let (mut files, mut first) = (Vec::with_capacity(bodies.len()), 0);
        for body in bodies {
            let (mut meshes, mut instances, mut vertices) = (BTreeMap::new(), Vec::new(), 0);
            for &topology in &body.topologies {
                if let Entry::Vacant(place) = meshes.entry(topology) {
                    place.insert(body.mesh_of(topology)?);
                }
                let end = vertices + body.input.model().geometries()[topology.geometry].positions().len();
                instances.push((topology, vertices..end));
                vertices = end;
            }
            first += instances.len();
            files.push(File { meshes, first: first - instances.len(), instances });
        }
        let casters: Vec<HiddenCaster<'_>> =
            files.iter().zip(bodies).flat_map(|(file, body)| file.casters(body)).collect();
        let options = HiddenOptions::default();
        let search = |&light: &Light| {
            HiddenFaces::find(light, &casters, options, |_, _| ControlFlow::Continue(())).map_err(UsageError::Covered)
        };
        let found = lights.iter().map(search).collect::<Result<Vec<_>, _>>()?;
        drop(casters);
        Ok(Self { files, lights: lights.to_vec(), found })
    }

    /// The faces of a file's instances that cast for a light where averted faces suffice, as a mesh over the file's vertices.
    /// There is none if no face casts.
    pub(super) fn casting(&self, file: usize, body: &PosedModel<'_>, light: usize) -> Result<Option<Mesh>, Failure> {
        let (Some(of), Some(found), Some(&light)) =
            (self.files.get(file), self.found.get(light), self.lights.get(light))
        else {
            return Ok(None);
        };
        let mut faces = Vec::new();
        for (number, (HiddenCaster { mesh, positions, .. }, (_, vertices))) in
            (of.first..).zip(of.casters(body).zip(&of.instances))
        {
            let extracted = cpu::extract(positions, mesh, &[light], Predicate::Exact, Threads::default());
            let facing = extracted.map_err(UsageError::Arguments)?.facing;
            let covered = found.faces(number);
            for ((face, corners), mask) in (0_u32..).zip(mesh.faces()).zip(facing) {
                let casts = mask & 1 == 0 || !mesh.is_closed();
                if casts && covered.binary_search(&face).is_err() {
                    faces.push(corners.map(|vertex| vertex + vertices.start as u32));
                }
            }
        }
        match Mesh::from_faces(body.world.len(), faces) {
            Ok(mesh) => Ok(Some(mesh)),
            Err(MeshError::NoFaces) => Ok(None),
            Err(error) => Err(Failure::input(&body.input.file)(error.into())),
        }
    }
}

impl File {
    fn casters<'a>(&'a self, body: &'a PosedModel<'_>) -> impl Iterator<Item = HiddenCaster<'a>> {
        self.instances.iter().map(|(topology, vertices)| HiddenCaster {
            mesh: &self.meshes[topology],
            positions: &body.world[vertices.clone()],
            version: Some(VERSION),
        })
    }
}
