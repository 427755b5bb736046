//! All stages on the CPU.

use super::{Threads, edges, facing, is_finite, per_edge};
use crate::layout::Masks;
use crate::light::{LightError, MAX_LIGHTS, check_lights};
use crate::method::Method;
use crate::{Light, Mesh};

/// What an extraction on the CPU finds, laid out as on the GPU: ⌈N/32⌉ planes, item after item.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CpuExtraction {
    /// One facing mask a face.
    pub facing: Vec<u32>,
    /// Silhouette and winding masks an edge record.
    pub masks: Vec<Masks>,
    /// Faces with an infinite or NaN vertex: they face no light.
    pub non_finite_faces: u32,
}

/// Facing, silhouette and winding bits of `mesh` at `positions`.
///
/// # Errors
/// [`LightError`] for no lights, more than [`MAX_LIGHTS`], or one that is non-finite or all zeros.
pub fn extract(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    method: Method,
    threads: Threads,
) -> Result<CpuExtraction, LightError> {
    check_lights(lights, MAX_LIGHTS)?;
    let facing = facing(positions, mesh.faces(), lights, threads);
    let masks = match method {
        Method::FaceMask => edges(mesh.edges(), &facing, mesh.faces().len(), lights.len(), threads),
        Method::PerEdge => per_edge(positions, mesh, lights, threads),
    };
    let is_usable = |v: &u32| positions.get(*v as usize).is_some_and(|&p| is_finite(p));
    let non_finite_faces = mesh.faces().iter().filter(|face| !face.iter().all(is_usable)).count() as u32;
    Ok(CpuExtraction {
        facing,
        masks,
        non_finite_faces,
    })
}
