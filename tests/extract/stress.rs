//! Stress scenes: exact facing is exact on every one, face masks of each predicate close, and the predicates that are
//! not exact err.

use std::collections::BTreeMap;

use rimline::gpu::ExtractorOptions;
use rimline::internals::Method;
use rimline::internals::cpu::{self, Threads};
use rimline::{Mesh, Predicate};
use rimline_testkit::error_metrics::{Candidate, Score};
use rimline_testkit::stress::{self, Scene};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{extract, text};
use rimline_testkit::{is_long, oracle};

use super::exact;

pub(crate) const TESTS: &[Test] = &[
    ("exact_facing_is_exact_on_every_stress_scene", exact_facing),
    ("face_masks_close_on_every_stress_scene_and_per_edge_does_not", methods),
];

/// Faces of a scene, and its lights.
fn size() -> (usize, usize) {
    if is_long() { (30_000, 33) } else { (1000, 8) }
}

fn options(lights: usize, method: Method, predicate: Predicate) -> ExtractorOptions {
    ExtractorOptions { max_lights: lights, method, predicate, masks: true, lists: None, ..Default::default() }
}

fn exact_facing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (faces, count) = size();
    for scene in stress::scenes(faces) {
        let (mesh, lights) = (scene.mesh().map_err(text)?, scene.lights(count));
        exact::check(gpu, scene.name, &scene.positions, &mesh, &lights, exact::exact(count))?;
    }
    Ok(())
}

/// The ways that are compared with exact face masks.
const WAYS: [(&str, Method, Predicate); 4] = [
    ("face-mask fast", Method::FaceMask, Predicate::Fast),
    ("face-mask plane", Method::FaceMask, Predicate::Plane),
    ("per-edge fast", Method::PerEdge, Predicate::Fast),
    ("per-edge plane", Method::PerEdge, Predicate::Plane),
];

fn scores(gpu: &Gpu, scene: &Scene, mesh: &Mesh, count: usize) -> Result<Vec<Score>, String> {
    let lights = scene.lights(count);
    let right = oracle::facing(&scene.positions, mesh.faces(), &lights);
    let masks = cpu::edges(mesh.edges(), &right, mesh.faces().len(), count, Threads::all());
    let right = cpu::Extraction { facing: right, masks, ..Default::default() };
    let score = |(_, method, predicate)| {
        let found = extract(gpu, &scene.positions, mesh, &lights, options(count, method, predicate))?;
        let facing = (method == Method::FaceMask).then_some(found.facing.as_slice());
        Score::of(mesh, count, &right, Candidate { facing, masks: &found.masks }).map_err(text)
    };
    WAYS.into_iter().map(score).collect()
}

fn methods() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (faces, count) = size();
    let mut classes: BTreeMap<&str, [Score; 4]> = BTreeMap::new();
    println!("wrong facing bits / wrong silhouette bits / unclosed vertices: {:?}", WAYS.map(|(name, ..)| name));
    for scene in stress::scenes(faces) {
        let mesh = scene.mesh().map_err(text)?;
        let scores = scores(gpu, &scene, &mesh, count)?;
        let shown: Vec<String> = scores
            .iter()
            .map(|of| format!("{}/{}/{}", of.wrong_facing_bits, of.wrong_silhouette_bits, of.unclosed_vertices))
            .collect();
        println!("{:<22} {:?}", scene.name, shown);
        for ((way, method, _), score) in WAYS.iter().zip(&scores) {
            if *method == Method::FaceMask && score.unclosed_vertices != 0 {
                return Err(format!("{}, {way}: {} vertices unclosed", scene.name, score.unclosed_vertices));
            }
        }
        for (sum, score) in classes.entry(scene.class).or_default().iter_mut().zip(&scores) {
            sum.wrong_facing_bits += score.wrong_facing_bits;
            sum.wrong_silhouette_bits += score.wrong_silhouette_bits;
            sum.unclosed_vertices += score.unclosed_vertices;
        }
    }
    // The comparison has something to show: what 2003's method opens, and where f32 errs at all.
    for (class, [fast, plane, _, edge_plane]) in &classes {
        if ["translation", "plate", "noise"].contains(class) && edge_plane.unclosed_vertices == 0 {
            return Err(format!("{class}: the per-edge method opens no vertex"));
        }
        // A device that fuses multiplications with additions errs less by the local form.
        let errors = fast.wrong_silhouette_bits + plane.wrong_silhouette_bits;
        if ["translation", "scale", "plate", "subnormal"].contains(class) && errors == 0 {
            return Err(format!("{class}: f32 makes no error"));
        }
        if *class == "translation" && plane.wrong_facing_bits <= fast.wrong_facing_bits {
            return Err("far from the origin the plane form should err more than the local one".to_owned());
        }
    }
    Ok(())
}
