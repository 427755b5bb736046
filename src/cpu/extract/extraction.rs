//! All stages on the CPU.

use super::edges::edges_into;
use super::facing::FacingCounts;
use super::facing::facing_into;
#[cfg(feature = "reference")]
use super::per_edge::per_edge;
use crate::cpu::common::parallel::Threads;
use crate::layout::Masks;
use crate::light::{LightError, MAX_LIGHTS, check_lights};
#[cfg(feature = "reference")]
use crate::method::Method;
use crate::method::Predicate;
use crate::{Light, Mesh};

/// What an extraction on the CPU finds, laid out as on the GPU: ⌈N/32⌉ planes, item after item.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CpuExtraction {
    /// One facing mask a face; empty for the per-edge method.
    pub facing: Vec<u32>,
    /// Silhouette and winding masks an edge record.
    pub masks: Vec<Masks>,
    /// What facing counted.
    pub counts: FacingCounts,
}

impl CpuExtraction {
    /// Facing, silhouette and winding bits of `mesh` at `positions`. Memory of an earlier call is used again.
    ///
    /// # Errors
    /// [`LightError`] for no lights, more than [`MAX_LIGHTS`], or one that is non-finite or all zeros.
    pub fn update(
        &mut self,
        positions: &[[f32; 3]],
        mesh: &Mesh,
        lights: &[Light],
        predicate: Predicate,
        threads: Threads,
    ) -> Result<(), LightError> {
        check_lights(lights, MAX_LIGHTS)?;
        let faces = mesh.faces().len();
        self.counts = facing_into(&mut self.facing, positions, mesh.faces(), lights, predicate, threads);
        edges_into(&mut self.masks, mesh.edges(), &self.facing, faces, lights.len(), threads);
        Ok(())
    }

    /// [`Self::update`] by any method.
    ///
    /// # Errors
    /// The same.
    #[cfg(feature = "reference")]
    pub fn update_by(
        &mut self,
        positions: &[[f32; 3]],
        mesh: &Mesh,
        lights: &[Light],
        method: Method,
        predicate: Predicate,
        threads: Threads,
    ) -> Result<(), LightError> {
        if method == Method::FaceMask {
            return self.update(positions, mesh, lights, predicate, threads);
        }
        check_lights(lights, MAX_LIGHTS)?;
        self.facing.clear();
        self.counts = FacingCounts::default();
        self.masks = per_edge(positions, mesh, lights, predicate, threads);
        Ok(())
    }
}

/// [`CpuExtraction::update`] from nothing.
///
/// # Errors
/// The same.
pub fn extract(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    predicate: Predicate,
    threads: Threads,
) -> Result<CpuExtraction, LightError> {
    let mut extraction = CpuExtraction::default();
    extraction.update(positions, mesh, lights, predicate, threads)?;
    Ok(extraction)
}

/// [`extract`] by any method.
///
/// # Errors
/// The same.
#[cfg(feature = "reference")]
pub fn extract_by(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    method: Method,
    predicate: Predicate,
    threads: Threads,
) -> Result<CpuExtraction, LightError> {
    let mut extraction = CpuExtraction::default();
    extraction.update_by(positions, mesh, lights, method, predicate, threads)?;
    Ok(extraction)
}
