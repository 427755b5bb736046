//! ZP+ as published: where it falls back to z-fail. tests/shadow/range.rs has its pictures.
//!
//! Its stage is `zp_plus_2005_cases`.

use glam::{DMat4, DVec3, DVec4};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::shadow::{CAST_NOTHING, COUNT_Z_FAIL, COUNT_ZP_PLUS_2005};
use rimline::{Counting, DepthDirection, Mesh, Predicate};

use crate::render::Renderer;
use crate::trials::{Test, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::Placed;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;

pub(crate) const TESTS: &[Test] = &[("case_d_goes_over_to_z_fail", switches)];

/// Whether the near plane cuts both finite edges of a side, the mesh's own and that between the far vertices, for a caster's
/// light: case D of Hornus et al. (2005), section 5. In `f64`; `None` where rounding decides.
fn is_case_d(placed: &Placed) -> Result<Option<bool>, String> {
    let Placed { shape, camera, lights } = placed;
    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).map_err(text)?;
    let found = cpu::extract(&shape.positions, &mesh, lights, Predicate::Exact, Threads::all()).map_err(text)?;
    let matrix = DMat4::from_cols_array_2d(&camera.view_projection.map(|column| column.map(f64::from)));
    let [x, y, z, w] = lights[0].to_array().map(f64::from);
    let origin = DVec3::from(camera.origin.map(f64::from));
    // Whether a vertex is on the eye's side of the near plane.
    let is_cut = |vertex: DVec4| {
        let clip = matrix * vertex;
        let before = if camera.depth == DepthDirection::Standard { -clip.z } else { clip.z - clip.w };
        let slack = 1e-5 * matrix.to_cols_array().iter().fold(0.0, |most: f64, c| most.max(c.abs())) * vertex.length();
        let signs = [before, -clip.w].map(|c| if c.abs() > slack { Some(c > 0.0) } else { None });
        if signs.contains(&Some(true)) { Some(true) } else { signs[0].and(signs[1]) }
    };
    let crosses = |ends: [DVec4; 2]| Some(is_cut(ends[0])? != is_cut(ends[1])?);
    let mut is_case = Some(false);
    for (edge, _) in mesh.edges().vertices().iter().zip(&found.masks).filter(|(_, masks)| masks.silhouette & 1 != 0) {
        let ends = edge.map(|vertex| DVec3::from(shape.positions[vertex as usize].map(f64::from)));
        let near = crosses(ends.map(|end| (end - origin).extend(1.0)));
        match (near, crosses(ends.map(|end| (w * end - DVec3::new(x, y, z)).extend(0.0)))) {
            (Some(true), Some(true)) => return Ok(Some(true)),
            (Some(false), _) | (_, Some(false)) => {}
            _ => is_case = None,
        }
    }
    Ok(is_case)
}

/// The stage goes over to z-fail in case D alone.
fn switches() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut checked = [0; 2];
    for class in CLASSES.iter().filter(|class| class.name.contains("near plane") || class.name == "directional lights")
    {
        for number in 30..if is_long() { 60 } else { 33 } {
            let seed = seed(class, number);
            let frame = (class.frame)(&mut Random::new(seed));
            let counted = Renderer::new(&gpu).count(&frame, Counting::ZpPlus2005)?;
            let casters = frame.bodies.iter().filter(|body| body.casts);
            for (body, light) in casters.zip(&counted.chosen).map(|(body, lights)| (body, &lights[0])) {
                let is_case = if light.casting == CAST_NOTHING { None } else { is_case_d(&frame.placed(body))? };
                // With excluded faces it is z-fail in any case.
                let is_right = |got: u32| match is_case {
                    Some(true) => got == COUNT_Z_FAIL,
                    Some(false) => got == COUNT_ZP_PLUS_2005 || light.excludes != 0,
                    None => true,
                };
                let got = light.counting;
                if !is_right(got) || (is_case == Some(true) && is_right(COUNT_ZP_PLUS_2005)) {
                    return Err(format!("{}, seed {seed}: {got} where case D is {is_case:?}", class.name));
                }
                checked[usize::from(is_case == Some(true))] += usize::from(is_case.is_some());
            }
        }
    }
    println!("pairs of caster and light that are certain: {checked:?}");
    if checked.contains(&0) { Err("one of both never happened".to_owned()) } else { Ok(()) }
}
