//! The CPU twins, stage by stage.

use std::borrow::Cow;

use rimline::reference::Method;
use rimline::reference::cpu::{self, Extraction, Threads};
use rimline::{Light, Predicate};

use super::Found;
use crate::failure::{Failure, UsageError};
use crate::input::{Scene, Shape};
use crate::times::Times;

pub(super) fn extract<'a>(
    scene: &Scene<'a>,
    lights: &[Light],
    method: Method,
    predicate: Predicate,
    times: &mut Times,
) -> Result<Found<'a>, Failure> {
    let (mesh, threads) = (&scene.mesh, Threads::all());
    let positions: Cow<'a, [[f32; 3]]> = match &scene.shape {
        Shape::World(positions) => Cow::Borrowed(positions),
        Shape::Posed { model, pose } => {
            Cow::Owned(times.measure("deform", || cpu::deform(model, pose, 0.0, None, threads))?)
        }
    };
    if mesh.polygons().is_some() {
        let extract = |method| {
            let found = cpu::extract_by(&positions, mesh, lights, method, predicate, threads);
            found.map_err(|error| Failure::from(UsageError::Arguments(error)))
        };
        let Extraction { facing, twisted, mut masks, statistics } =
            times.measure("facing", || extract(Method::FaceMask))?;
        if method == Method::PerEdge {
            masks = times.measure("per_edge", || extract(method))?.masks;
        }
        return Ok(Found { positions, facing, twisted, masks, statistics });
    }
    let faces = mesh.faces();
    let mut facing = Vec::new();
    // The per-edge method has no face bits, so the file gets the exact ones.
    let of_faces = if method == Method::PerEdge { Predicate::Exact } else { predicate };
    let statistics =
        times.measure("facing", || cpu::facing_into(&mut facing, &positions, faces, lights, of_faces, threads));
    let masks = match method {
        Method::FaceMask => {
            times.measure("edges", || cpu::edges(mesh.edges(), &facing, faces.len(), lights.len(), threads))
        }
        Method::PerEdge => times.measure("per_edge", || cpu::per_edge(&positions, mesh, lights, predicate, threads)),
    };
    Ok(Found { positions, facing, twisted: Vec::new(), masks, statistics })
}
