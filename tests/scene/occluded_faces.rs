//! Occluded faces in scenes: culled as excluded faces are, and only while all conditions of the search hold.

use std::ops::ControlFlow;

use rimline::cpu::{OccludedFaces, OcclusionCaster, OcclusionOptions};
use rimline::gpu::{
    Caster, CasterHandle, CasterPositions, FrameInputs, LightHandle, LightMask, OccludedCounts, Scene, ShadowError,
};
use rimline::mesh::Weld;
use rimline::{Light, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::quad_box;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, must_fail, same};

use crate::found::Found;
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("occluded_faces_are_left_out_while_all_holds", holds),
    ("occluded_faces_of_other_casters_are_typed_errors", refused),
    ("occluded_polygons_are_a_typed_error", polygons),
];

const LIGHT: Light = Light::point([0.0, 0.0, 10.0]);

fn shapes() -> [Shape; 3] {
    let wall = vec![[-40.0, -40.0, 5.0], [40.0, -40.0, 5.0], [0.0, 60.0, 5.0]];
    // Half of the last is beside the wall's shadow.
    let mut torus = shapes::torus(9, 7, 30.0, 4.0);
    torus.positions.iter_mut().for_each(|position| *position = [position[0] + 60.0, position[1], position[2] - 20.0]);
    [Shape { positions: wall, faces: vec![[0, 1, 2]] }, shapes::sphere(8), torus]
}

/// The shapes, and what a search finds among them. The second has a version.
fn searched() -> Result<(Vec<(Shape, Mesh)>, OccludedFaces), String> {
    let meshes = shapes().into_iter().map(|shape| shape.mesh().map(|mesh| (shape, mesh)).map_err(text));
    let meshes = meshes.collect::<Result<Vec<_>, _>>()?;
    let occluded = search(&meshes)?;
    Ok((meshes, occluded))
}

fn search(meshes: &[(Shape, Mesh)]) -> Result<OccludedFaces, String> {
    let all: Vec<OcclusionCaster<'_>> = meshes
        .iter()
        .zip([None, Some(7), None])
        .map(|((shape, mesh), version)| OcclusionCaster { mesh, positions: &shape.positions, version })
        .collect();
    let go_on = |_, _| ControlFlow::Continue(());
    OccludedFaces::find(LIGHT, &all, OcclusionOptions::default(), go_on).map_err(text)
}

/// A scene of the shapes, the second of which reads its positions from a buffer.
struct Placed {
    scene: Scene,
    lights: [LightHandle; 2],
    casters: Vec<CasterHandle>,
}

fn casters(gpu: &Gpu, meshes: &[(Shape, Mesh)]) -> Result<Placed, String> {
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, roomy(40)).map_err(text)?;
    let lights = [scene.add_light(LIGHT).map_err(text)?, scene.add_light(Light::point([9.0; 3])).map_err(text)?];
    let mut casters = Vec::new();
    for (number, (shape, mesh)) in meshes.iter().enumerate() {
        let handle = scene.add_mesh(mesh, &shape.positions).map_err(text)?;
        let mut caster = Caster::rigid(handle, IDENTITY);
        if number == 1 {
            let buffer = gpu.storage(&shape.positions);
            caster.positions = CasterPositions::Buffer { buffer, offset: 0, stride: 12 };
        }
        casters.push(scene.insert(caster).map_err(text)?);
    }
    scene.set_position_version(casters[1], Some(7)).map_err(text)?;
    Ok(Placed { scene, lights, casters })
}

/// The masks of excluded faces and the lists of a new frame, by groups; and its counts.
type Results = (Vec<(Vec<u32>, Vec<Vec<u32>>)>, OccludedCounts);

fn results(gpu: &Gpu, scene: &mut Scene) -> Result<Results, String> {
    let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
    let groups = Found::read(gpu, &frame)?.groups;
    Ok((groups.into_iter().map(|group| (group.excluded, group.lists)).collect(), frame.occluded_faces()))
}

/// A change of something that the search read, or its reversal.
type Change = Box<dyn Fn(&mut Scene, bool) -> Result<(), ShadowError>>;

fn holds() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (meshes, occluded) = searched()?;
    let [wall, sphere, torus] = [0, 1, 2].map(|number| occluded.faces(number).len());
    let count = wall + sphere + torus;
    if sphere != meshes[1].0.faces.len() || torus == 0 || torus == meshes[2].0.faces.len() {
        return Err(format!("{sphere} faces of the sphere and {torus} of the torus are occluded"));
    }
    let Placed { mut scene, lights: [light, other], casters } = casters(gpu, &meshes)?;
    let (plain, nothing) = results(gpu, &mut scene)?;
    same("nothing is set", &[nothing], &[OccludedCounts::default()])?;
    let mut by_caller = self::casters(gpu, &meshes)?;
    for (number, &caster) in by_caller.casters.iter().enumerate() {
        by_caller.scene.set_excluded(caster, by_caller.lights[0], occluded.faces(number)).map_err(text)?;
    }
    let (expected, _) = results(gpu, &mut by_caller.scene)?;
    must_fail("nothing left out", &same("groups", &plain, &expected))?;

    scene.set_occluded_faces(light, &casters, Some(&occluded)).map_err(text)?;
    let used = |scene: &mut Scene, what: &str| {
        let (groups, counts) = results(gpu, scene)?;
        same(what, &groups, &expected)?;
        same(what, &[counts], &[OccludedCounts { faces: count, ignored: 0, ignored_faces: 0 }])
    };
    let all_ignored = OccludedCounts { faces: 0, ignored: 1, ignored_faces: count };
    used(&mut scene, "set")?;
    used(&mut scene, "again")?;
    let moved = [[1.0, 0.0, 0.0, 1.0], IDENTITY[1], IDENTITY[2]];
    let (wall, ball, without) = (casters[0], casters[1], LightMask::ALL.without(light));
    let changes: [(&str, Change); 5] = [
        ("light", Box::new(move |s, on| s.set_light(light, if on { Light::point([0.0, 0.0, 11.0]) } else { LIGHT }))),
        ("transform", Box::new(move |s, on| s.set_transform(wall, if on { moved } else { IDENTITY }))),
        ("version", Box::new(move |s, on| s.set_position_version(ball, Some(if on { 8 } else { 7 })))),
        ("lights", Box::new(move |s, on| s.set_lights(wall, if on { without } else { LightMask::ALL }))),
        ("excluded", Box::new(move |s, on| s.set_excluded(wall, light, if on { &[0] } else { &[] }))),
    ];
    for (what, change) in &changes {
        change(&mut scene, true).map_err(text)?;
        same(what, &[results(gpu, &mut scene)?.1], &[all_ignored])?;
        change(&mut scene, false).map_err(text)?;
        used(&mut scene, what)?;
    }
    // Another light, and a range, have no effect.
    scene.set_light(other, Light::point([8.0; 3])).map_err(text)?;
    scene.set_light(other, Light::point([9.0; 3])).map_err(text)?;
    scene.set_light(light, LIGHT.with_range(1e4)).map_err(text)?;
    used(&mut scene, "others")?;
    scene.set_light(light, LIGHT).map_err(text)?;
    scene.set_occluded_faces(light, &[], None).map_err(text)?;
    same("ended", &[results(gpu, &mut scene)?], &[(plain, nothing)])?;
    // A caster that is gone, then a light.
    scene.set_occluded_faces(light, &casters, Some(&occluded)).map_err(text)?;
    scene.remove(wall).map_err(text)?;
    same("removed", &[results(gpu, &mut scene)?.1], &[all_ignored])?;
    scene.remove_light(light).map_err(text)?;
    same("without its light", &[results(gpu, &mut scene)?.1], &[nothing])
}

fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (meshes, occluded) = searched()?;
    let Placed { mut scene, lights: [light, _], casters } = casters(gpu, &meshes)?;
    let mut set = |casters: &[CasterHandle]| scene.set_occluded_faces(light, casters, Some(&occluded)).err();
    let [wall, ball, ring] = [casters[0], casters[1], casters[2]];
    let [sphere, torus] = [1, 2].map(|number| meshes[number].0.faces.len());
    same("too few", &[set(&[wall, ball])], &[Some(ShadowError::OcclusionCasters { given: 2, found: 3 })])?;
    let swapped = ShadowError::OcclusionCaster { caster: 1, faces: torus, found: sphere };
    same("swapped", &[set(&[wall, ring, ball])], &[Some(swapped)])
}

/// A box of squares, each of which is one face.
fn square_box(at: [f32; 3]) -> Result<(Shape, Mesh), String> {
    let mut squares = quad_box(2);
    for position in &mut squares.positions {
        *position = std::array::from_fn(|axis| position[axis] + at[axis]);
    }
    let mesh = squares.mesh(Weld::Position).map_err(text)?;
    Ok((Shape { positions: squares.positions, faces: mesh.faces().to_vec() }, mesh))
}

/// Polygons cannot be excluded. A caster of polygons is taken if none of its faces is occluded.
fn polygons() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let [wall, ..] = shapes();
    let of_wall = wall.mesh().map_err(text)?;
    let below = [(wall, of_wall), square_box([1.0, 1.0, 0.0])?];
    let apart = [square_box([1.0, 1.0, 0.0])?, square_box([21.0, 1.0, 0.0])?];
    for (meshes, expected) in [(below, Some(ShadowError::Polygons)), (apart, None)] {
        let occluded = search(&meshes)?;
        same("no face is occluded", &[occluded.faces(1).is_empty()], &[expected.is_none()])?;
        let Placed { mut scene, lights: [light, _], casters } = casters(gpu, &meshes)?;
        same("set", &[scene.set_occluded_faces(light, &casters, Some(&occluded)).err()], &[expected])?;
    }
    Ok(())
}
