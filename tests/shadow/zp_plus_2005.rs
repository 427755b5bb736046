//! ZP+ as published: right where its authors had no trouble, and how wrong it is elsewhere.
//!
//! Its stage is `zp_plus_2005_cases`.

use glam::{DMat4, DVec3, DVec4};
use rimline::internals::cpu::{self, Threads};
use rimline::{Counting, DepthDirection, Mesh, Predicate};

use crate::classes::CLASSES;
use crate::render::Renderer;
use crate::scene::Placed;
use crate::trials::{Test, Traced, every, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;

pub(crate) const TESTS: &[Test] =
    &[("published_zp_plus", published), ("case_d_goes_over_to_z_fail", switches), ("auto_never_takes_published", auto)];

/// The codes of [`ShadowLight::counting`].
const Z_FAIL: u32 = 2;
const ZP_PLUS_PAPER: u32 = 4;

/// From cameras outside the shadow no pixel is wrong that is right by `Counting::Auto`. Sides that begin at a concave crease
/// may fight with the surfaces there, by every method. Of the other classes the wrong pixels are printed.
fn published() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer::new(&gpu);
    println!("ZP+ as published: wrong pixels of those compared, in the worst frame; frames, pairs left to z-fail");
    let mut failures = Vec::new();
    for class in CLASSES {
        let (mut wrong, mut most, mut compared, mut switched) = (0, 0, 0, 0);
        let is_outside = class.name == "camera outside the shadow";
        let frames = if is_long() { 105 } else { 1 + 2 * u64::from(is_outside) };
        for number in 0..frames {
            let traced = Traced::new(class, number);
            let counted = renderer.count(&traced.frame, Counting::ZpPlus2005)?;
            let lit = traced.compared().lit(&counted.stencils[0], &every(&counted, 0));
            if is_outside {
                let ours = renderer.count(&traced.frame, Counting::Auto)?;
                let ours = traced.compared().lit(&ours.stencils[0], &every(&ours, 0));
                if lit.compared == 0 || lit.pixels.iter().any(|pixel| !ours.pixels.contains(pixel)) {
                    failures.push(format!("{}, seed {}: {lit:?}, auto {ours:?}", class.name, traced.seed));
                }
            }
            wrong += lit.pixels.len();
            most = most.max(lit.pixels.len());
            compared += lit.compared;
            switched += counted.chosen.iter().flatten().filter(|light| light.counting == Z_FAIL).count();
        }
        println!("  {}: {wrong} of {compared}, {most}; {frames}, {switched}", class.name);
    }
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n")) }
}

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
    let (mut found, mut checked) = ([0; 5], [0; 2]);
    for class in CLASSES.iter().filter(|class| class.name.contains("near plane") || class.name == "directional lights")
    {
        for number in 30..if is_long() { 60 } else { 33 } {
            let seed = seed(class, number);
            let frame = (class.frame)(&mut Random::new(seed));
            let counted = Renderer::new(&gpu).count(&frame, Counting::ZpPlus2005)?;
            let got: Vec<u32> = counted.chosen.iter().map(|lights| lights[0].counting).collect();
            for ((body, &got), lights) in frame.bodies.iter().filter(|body| body.casts).zip(&got).zip(&counted.chosen) {
                let is_case = if lights[0].casting == 0 { None } else { is_case_d(&frame.placed(body))? };
                // With excluded faces it is z-fail in any case.
                let is_right = |got: u32| match is_case {
                    Some(true) => got == Z_FAIL,
                    Some(false) => got == ZP_PLUS_PAPER || lights[0].excludes != 0,
                    None => true,
                };
                if !is_right(got) || (is_case == Some(true) && is_right(ZP_PLUS_PAPER)) {
                    return Err(format!("{}, seed {seed}: {got} where case D is {is_case:?}", class.name));
                }
                checked[usize::from(is_case == Some(true))] += usize::from(is_case.is_some());
            }
            for counting in got {
                found[counting as usize] += 1;
            }
        }
    }
    println!("pairs of caster and light: {} left to z-fail, {} not; {checked:?} of them certain", found[2], found[4]);
    if found[2] > 0 && found[4] > 0 && !checked.contains(&0) {
        Ok(())
    } else {
        Err(format!("one of both never happened: {found:?}"))
    }
}

/// Auto is z-pass or the library's ZP+.
fn auto() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    for class in CLASSES {
        let seed = seed(class, 0);
        let counted = Renderer::new(&gpu).count(&(class.frame)(&mut Random::new(seed)), Counting::Auto)?;
        if let Some(light) = counted.chosen.iter().flatten().find(|light| light.counting > 1) {
            return Err(format!("{}, seed {seed}: {light:?}", class.name));
        }
    }
    Ok(())
}
