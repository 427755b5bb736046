//! The whole extraction on the CPU.

use super::edges::{FaceMasks, edges_into};
use super::facing::{FacingStatistics, facing_into};
use super::per_edge::per_edge;
use crate::cpu::common::parallel::Threads;
use crate::cpu::error::{CpuError, check_positions};
use crate::cpu::polygon::polygon_facing::polygon_facing;
use crate::layout::EdgeMasks;
use crate::light::{MAX_LIGHTS, check_lights};
use crate::mesh::Silhouette;
use crate::method::{Method, Predicate};
use crate::{Light, Mesh};

/// The result of an extraction on the CPU. Masks have ⌈N/32⌉ planes, each with all items in order, as the GPU's buffers
/// have them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extraction {
    /// One facing mask for each triangle of [`Mesh::faces`], the same for all of a polygon.
    /// [`Polygons::masks_of`](crate::mesh::Polygons::masks_of) makes one a polygon of them. Empty for the per-edge method.
    pub facing: Vec<u32>,
    /// For each triangle the lights for which its polygon is twisted: its boundary is not simple as seen from them.
    /// For these it faces nothing, and its edges are boundaries of its neighbours. Empty for a mesh without
    /// [`Mesh::polygons`], and for the per-edge method.
    pub twisted: Vec<u32>,
    /// Silhouette and winding masks for each edge record.
    pub masks: Vec<EdgeMasks>,
    /// The statistics of facing.
    pub statistics: FacingStatistics,
}

impl Extraction {
    /// Computes facing, silhouette and winding bits of `mesh` at `positions`. Lights are in the space of the positions.
    /// The memory of an earlier call is reused. `lights` may be empty. Polygons are decided exactly by any predicate.
    ///
    /// # Errors
    /// [`CpuError`] for fewer positions than the mesh has vertices, more lights than [`MAX_LIGHTS`], or a light that
    /// is non-finite, all zeros or has an impossible range or cone. Nothing is changed then.
    pub fn update(
        &mut self,
        positions: &[[f32; 3]],
        mesh: &Mesh,
        lights: &[Light],
        predicate: Predicate,
        threads: Threads,
    ) -> Result<(), CpuError> {
        check_lights(lights, MAX_LIGHTS)?;
        check_positions(positions, mesh)?;
        self.twisted.clear();
        let mut edges = |facing: &[u32], twisted: &[u32]| {
            let faces = FaceMasks { facing, twisted };
            edges_into(&mut self.masks, mesh.edges(), faces, mesh.face_count(), lights.len(), threads);
        };
        if let Some(polygons) = mesh.polygons() {
            let (masks, statistics) = polygon_facing(positions, polygons, lights, threads);
            self.statistics = statistics;
            let (facing, twisted): (Vec<_>, Vec<_>) = masks.iter().map(|masks| (masks.facing, masks.twisted)).unzip();
            edges(&facing, &twisted);
            self.facing.clear();
            self.facing.extend(polygons.masks_of_triangles(&facing));
            self.twisted.extend(polygons.masks_of_triangles(&twisted));
        } else {
            self.statistics = facing_into(&mut self.facing, positions, mesh.faces(), lights, predicate, threads);
            edges(&self.facing, &[]);
        }
        Ok(())
    }

    /// The silhouette of light number `light` of `mesh`, which is the mesh of the extraction. It is empty for a light
    /// that was not extracted.
    pub fn silhouette(&self, mesh: &Mesh, light: usize) -> Silhouette {
        let (edges, bit) = (mesh.edges().len(), 1 << (light % 32));
        let plane = self.masks.chunks(edges.max(1)).nth(light / 32).unwrap_or_default();
        let found = (0..).zip(plane).filter(|(_, masks)| masks.silhouette & bit != 0);
        Silhouette::new(mesh, found.map(|(record, masks)| (record, masks.winding & bit != 0)))
    }

    /// Like [`Self::update`], by any method.
    ///
    /// # Errors
    /// The errors of [`Self::update`].
    #[doc(hidden)]
    pub fn update_by(
        &mut self,
        positions: &[[f32; 3]],
        mesh: &Mesh,
        lights: &[Light],
        method: Method,
        predicate: Predicate,
        threads: Threads,
    ) -> Result<(), CpuError> {
        if method == Method::FaceMask {
            return self.update(positions, mesh, lights, predicate, threads);
        }
        check_lights(lights, MAX_LIGHTS)?;
        check_positions(positions, mesh)?;
        self.facing.clear();
        self.twisted.clear();
        self.statistics = FacingStatistics::default();
        self.masks = per_edge(positions, mesh, lights, predicate, threads);
        Ok(())
    }
}

/// Computes facing, silhouette and winding bits of `mesh` at `positions`. [`Extraction::update`] does the same and
/// reuses memory.
///
/// # Errors
/// The errors of [`Extraction::update`].
pub fn extract(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    predicate: Predicate,
    threads: Threads,
) -> Result<Extraction, CpuError> {
    let mut extraction = Extraction::default();
    extraction.update(positions, mesh, lights, predicate, threads)?;
    Ok(extraction)
}

/// Like [`extract`], by any method.
///
/// # Errors
/// The errors of [`extract`].
pub fn extract_by(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    method: Method,
    predicate: Predicate,
    threads: Threads,
) -> Result<Extraction, CpuError> {
    let mut extraction = Extraction::default();
    extraction.update_by(positions, mesh, lights, method, predicate, threads)?;
    Ok(extraction)
}
