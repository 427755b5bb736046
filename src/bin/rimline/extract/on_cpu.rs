//! The CPU twins, stage by stage.

use std::borrow::Cow;

use rimline::cpu::{self, Threads};
use rimline::{Light, Method};

use super::{Found, Times};
use crate::input::{Scene, Shape};

pub(super) fn extract<'a>(scene: &Scene<'a>, lights: &[Light], method: Method, times: &mut Times) -> Found<'a> {
    let (mesh, threads) = (&scene.mesh, Threads::all());
    let positions: Cow<'a, [[f32; 3]]> = match &scene.shape {
        Shape::World(positions) => Cow::Borrowed(positions),
        Shape::Posed { model, pose } => {
            Cow::Owned(times.measure("deform", || cpu::deform(model, pose, 0.0, None, threads)))
        }
    };
    let faces = mesh.faces();
    let facing = times.measure("facing", || cpu::facing(&positions, faces, lights, threads));
    let masks = match method {
        Method::FaceMask => times.measure("edges", || {
            cpu::edges(mesh.edges(), &facing, faces.len(), lights.len(), threads)
        }),
        Method::PerEdge => times.measure("per_edge", || cpu::per_edge(&positions, mesh, lights, threads)),
    };
    let is_finite = |&v: &u32| cpu::is_finite(positions[v as usize]);
    let non_finite_faces = faces.iter().filter(|face| !face.iter().all(is_finite)).count() as u32;
    Found {
        positions,
        facing,
        masks,
        non_finite_faces,
    }
}
