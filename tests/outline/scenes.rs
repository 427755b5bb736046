//! Outlines of a scene's casters, against those of extractions, and rays in `f64`.
//!
//! The stage is `outline_edges`, in the variant for scenes.

use glam::{DMat3, DQuat, DVec3};
use rimline::gpu::{
    Capacities, Caster, CasterHandle, CasterPositions, Deformer, DeformerOptions, FrameInputs, LightHandle, LightMask,
    OutlineError, OutlineInputs, OutlineSource, OutlineStyle, Scene, SceneOptions, View as FrameView,
};
use rimline::mesh::Weld;
use rimline::{Light, Matrix3x4};
use rimline_testkit::cases::{Case, case, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::{deformed, interleaved, text};
use rimline_testkit::polygons::{PolygonSet, folded_polygon, quad_box, quad_torus};
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Pose, direction};
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, lights, must_fail};

use crate::rendered::{Attachments, Inputs, Picture, corners, render};
use crate::{CLASSES, Truth, View, check, style, truth};

pub(crate) const TESTS: &[Test] = &[
    ("outlines_of_a_caster_are_those_of_its_extraction", same_as_extractions),
    ("outlines_of_casters_are_what_rays_see", seen),
    ("outlines_of_models_are_those_of_their_positions", models),
];

/// A scene, and its light that stands for the eye.
pub(crate) struct Outlined {
    pub(crate) scene: Scene,
    pub(crate) eye: LightHandle,
}

impl Outlined {
    /// So many other lights come first. `lists` is the room of each list of edges.
    pub(crate) fn new(gpu: &Gpu, light: Light, others: usize, lists: Option<u32>) -> Result<Self, String> {
        let capacities = Capacities { lists, ..Capacities::default() };
        // Some meshes are in clusters, so that their edges have another order.
        let options =
            SceneOptions { max_lights: others + 1, capacities, clusters_from: Some(500), ..SceneOptions::default() };
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        for other in lights(&mut Random::new(5), others) {
            scene.add_light(other).map_err(text)?;
        }
        let eye = scene.add_light(light).map_err(text)?;
        Ok(Self { scene, eye })
    }

    pub(crate) fn insert(&mut self, (_, positions, mesh): &Case, transform: Matrix3x4) -> Result<CasterHandle, String> {
        let mesh = self.scene.add_mesh(mesh, positions).map_err(text)?;
        self.scene.insert(Caster::rigid(mesh, transform)).map_err(text)
    }

    /// The picture of a frame for these cameras.
    fn ink(
        &mut self,
        gpu: &Gpu,
        picture: &Picture<'_>,
        style: OutlineStyle,
        views: &[FrameView<'_>],
    ) -> Result<Vec<u8>, String> {
        picture.ink(gpu, |encoder, outlines, depth| {
            let frame = self.scene.encode(encoder, FrameInputs::new(views)).map_err(text)?;
            let of = OutlineSource::Scene(&frame, self.eye);
            let camera = picture.camera;
            outlines.prepare(&OutlineInputs { of, camera, depth, style, marked: None }).map_err(text)
        })
    }
}

/// Fails where two pictures differ by more than the order of lines does, since each is rounded as it is drawn.
fn same(what: &str, found: &[u8], expected: &[u8]) -> Result<(), String> {
    let apart = found.iter().zip(expected).filter(|(found, expected)| found.abs_diff(**expected) > 3).count();
    if apart == 0 { Ok(()) } else { Err(format!("{what}: {apart} pixels differ")) }
}

fn of_polygons(name: &str, set: &PolygonSet, scale: f32, shift: f32) -> Result<Case, String> {
    let mesh = set.mesh(Weld::Position).map_err(text)?;
    Ok((name.to_owned(), set.positions.iter().map(|p| p.map(|c| scale * c + shift)).collect(), mesh))
}

/// Polygons that are planar, that are not, and that are twisted as seen from somewhere.
fn polygons(random: &mut Random) -> Result<Vec<Case>, String> {
    let mut folded = PolygonSet::default();
    (0..6).for_each(|_| folded.push_points(&[folded_polygon(random)]));
    Ok(vec![
        of_polygons("box of squares", &quad_box(2), 0.7, -0.7)?,
        of_polygons("bent torus", &quad_torus(random, 12, 8, 0.1), 0.8, 0.0)?,
        of_polygons("folded polygons", &folded, 0.25, 0.0)?,
    ])
}

/// Meshes of all topologies, at the identity, by lists with room or without, of a light in the first or the second batch.
fn same_as_extractions() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(96)?;
    let cases = [topologies(), polygons(&mut random)?].concat();
    let [mut pictures, mut wires, mut moves] = [0; 3];
    for (number, case) in cases.iter().enumerate() {
        for turn in 0..4 {
            let view = View::new(&mut random, (number + turn) % 6);
            let attachments = Attachments::ALL[turn];
            // The others draw nothing but silhouettes without marks, or nothing at all.
            let [silhouette, boundary, crease, _] = CLASSES[(number + turn) % 4];
            let style = style([silhouette, boundary, crease, false], attachments);
            let (light, camera) = (view.light, &view.camera);
            let [others, lists] = [[0, 33][turn / 2], [u32::MAX, 5][turn % 2]];
            let what = format!("{}, {others} other lights, room for {lists}", case.0);
            let inputs = Inputs { case, camera, light, style, marks: None, capacity: None, attachments };
            let expected = render(&gpu, &inputs)?;
            let mut drawing = Outlined::new(&gpu, light, others as usize, Some(lists))?;
            let caster = drawing.insert(case, IDENTITY)?;
            let picture = Picture { camera, corners: corners(case), attachments };
            same(&what, &drawing.ink(&gpu, &picture, style, &[])?, &expected)?;
            // A list that overflows would draw this without a test of each edge.
            let every = OutlineStyle { crease: Some([0.0, 0.0, 0.0, 1.0]), crease_angle: 0.0, ..style };
            let is_noticed = |found: &[u8]| usize::from(same(&what, found, &expected).is_err());
            pictures += 1;
            wires += is_noticed(&drawing.ink(&gpu, &picture, every, &[])?);
            drawing.scene.set_transform(caster, moved(IDENTITY, DVec3::splat(0.05))).map_err(text)?;
            moves += is_noticed(&drawing.ink(&gpu, &picture, style, &[])?);
        }
    }
    // Flat meshes have no creases, and some eyes are too near to see an edge.
    println!("all edges are noticed in {wires} of {pictures} pictures, and moved ones in {moves}");
    if 2 * wires > pictures && 4 * moves > 3 * pictures { Ok(()) } else { Err("too little is compared".to_owned()) }
}

fn moved(rows: Matrix3x4, by: DVec3) -> Matrix3x4 {
    std::array::from_fn(|axis| {
        let [x, y, z, w] = rows[axis];
        [x, y, z, w + by[axis] as f32]
    })
}

/// A caster, as the oracle knows it.
struct Body {
    case: Case,
    transform: Matrix3x4,
    /// Its positions in world space are in a buffer.
    buffer: Option<wgpu::Buffer>,
    handle: CasterHandle,
    has_outline: bool,
}

impl Body {
    fn world(&self) -> Vec<[f32; 3]> {
        in_world(&self.case.1, &self.transform)
    }

    /// Moves it, in its buffer or by its matrix.
    fn move_to(&mut self, gpu: &Gpu, scene: &mut Scene, transform: Matrix3x4) -> Result<(), String> {
        self.transform = transform;
        match &self.buffer {
            Some(buffer) => {
                gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&interleaved(&self.world(), 8, 20)));
                Ok(())
            }
            None => scene.set_transform(self.handle, transform).map_err(text),
        }
    }
}

fn in_world(positions: &[[f32; 3]], transform: &Matrix3x4) -> Vec<[f32; 3]> {
    let rows = transform.map(|row| row.map(f64::from));
    let at = |p: [f64; 3]| rows.map(|[x, y, z, w]| (x * p[0] + y * p[1] + z * p[2] + w) as f32);
    positions.iter().map(|p| at(p.map(f64::from))).collect()
}

/// A matrix that turns, scales each axis otherwise, mirrors on request, and moves.
fn placed(random: &mut Random, is_mirrored: bool) -> Matrix3x4 {
    let turn = DQuat::from_axis_angle(direction(random), f64::from(random.between(0.0, 6.0)));
    let mut scale = DVec3::from([0, 1, 2].map(|_| f64::from(random.between(0.3, 0.6))));
    scale.x *= if is_mirrored { -1.0 } else { 1.0 };
    let matrix = DMat3::from_quat(turn) * DMat3::from_diagonal(scale);
    let to = 0.7 * direction(random);
    std::array::from_fn(|axis| matrix.row(axis).extend(to[axis]).as_vec4().to_array())
}

/// All bodies as one mesh in world space, and whether each vertex is of one with an outline.
fn together(bodies: &[Body]) -> (Case, Vec<bool>) {
    let (mut shape, mut have_outlines) = (Shape::default(), Vec::new());
    for body in bodies {
        let first = shape.positions.len() as u32;
        shape.positions.extend(body.world());
        shape.faces.extend(body.case.2.faces().iter().map(|face| face.map(|v| first + v)));
        have_outlines.resize(shape.positions.len(), body.has_outline);
    }
    (case("bodies", shape), have_outlines)
}

fn bodies(gpu: &Gpu, drawing: &mut Outlined, random: &mut Random) -> Result<Vec<Body>, String> {
    let squares = of_polygons("box of squares", &quad_box(2), 1.0, -1.0)?;
    let cases = [
        case("blob", shapes::blob(4, 0.3, 1)),
        case("torus", shapes::torus(30, 20, 1.0, 0.4)),
        squares,
        case("three sheets", shapes::three_sheets(5)),
        case("mirrored cube", shapes::cube()),
    ];
    let mut bodies = Vec::new();
    for (number, case) in cases.into_iter().enumerate() {
        let transform = placed(random, number == 4);
        let mesh = drawing.scene.add_mesh(&case.2, &case.1).map_err(text)?;
        let buffer = (number == 1).then(|| gpu.storage(&interleaved(&in_world(&case.1, &transform), 8, 20)));
        let mut caster = Caster::rigid(mesh, transform);
        if let Some(buffer) = buffer.clone() {
            caster.positions = CasterPositions::Buffer { buffer, offset: 8, stride: 20 };
        }
        let handle = drawing.scene.insert(caster).map_err(text)?;
        bodies.push(Body { case, transform, buffer, handle, has_outline: true });
    }
    Ok(bodies)
}

/// Turned, scaled and mirrored casters, rigid and in a buffer, of triangles and of polygons, that move, go, and lose
/// the light.
fn seen() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(97)?;
    let [mut musts, mut pictures, mut changes, mut noticed] = [0; 4];
    for projection in 0..6 {
        let view = View::new(&mut random, projection);
        let (others, lists) = ([0, 33][projection % 2], [None, Some(5)][projection / 2 % 2]);
        let mut drawing = Outlined::new(&gpu, view.light, others, lists)?;
        let mut bodies = bodies(&gpu, &mut drawing, &mut random)?;
        // Excluded faces cast nothing, and are seen.
        drawing.scene.set_excluded(bodies[3].handle, drawing.eye, &[0, 1, 2]).map_err(text)?;
        let attachments = Attachments::ALL[projection % Attachments::ALL.len()];
        let classes = [true, true, projection % 3 > 0, false];
        let mut before: Option<(Truth, Vec<u8>)> = None;
        for change in ["none", "moved", "without the light", "removed", "out of range"] {
            match change {
                "moved" => {
                    for body in &mut bodies {
                        body.move_to(&gpu, &mut drawing.scene, placed(&mut random, body.case.0 == "mirrored cube"))?;
                    }
                }
                "without the light" => {
                    drawing.scene.set_lights(bodies[0].handle, LightMask::ALL.without(drawing.eye)).map_err(text)?;
                    bodies[0].has_outline = false;
                }
                "removed" => drawing.scene.remove(bodies.remove(2).handle).map_err(text)?,
                "out of range" => {
                    // Directions have no range, and nothing is known of what is in a buffer.
                    drawing.scene.set_light(drawing.eye, view.light.with_range(1e-3)).map_err(text)?;
                    for body in &mut bodies {
                        body.has_outline &= view.is_parallel || body.buffer.is_some();
                    }
                }
                _ => {}
            }
            let what = format!("projection {projection}, {change}, {others} other lights, lists {lists:?}");
            let (case, have_outlines) = together(&bodies);
            let picture = Picture { camera: &view.camera, corners: corners(&case), attachments };
            let ink = drawing.ink(&gpu, &picture, style(classes, attachments), &[])?;
            let truth = truth(&case, &view, classes, |vertex| have_outlines[vertex as usize]);
            check(&what, &ink, &truth)?;
            (pictures, musts) = (pictures + 1, musts + truth.must.iter().filter(|&&must| must).count());
            if let Some((truth_before, ink_before)) = before.replace((truth, ink)) {
                let (truth, ink) = before.as_ref().ok_or("a picture")?;
                changes += 2;
                noticed += usize::from(check(&what, &ink_before, truth).is_err());
                noticed += usize::from(check(&what, ink, &truth_before).is_err());
            }
        }
    }
    println!("{musts} pixels of lines in {pictures} pictures; {noticed} of {changes} changes are noticed");
    if musts > 20_000 && 10 * noticed > 7 * changes { Ok(()) } else { Err("too little is compared".to_owned()) }
}

/// A model that the scene deforms. Another camera than that of a view is refused, since the model may not be deformed
/// for it.
fn models() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(98)?;
    let (model, pose) = bending_tube();
    let pose = pose(1.3);
    let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let case = &("tube".to_owned(), deformed(&gpu, &deformer, &model, &pose)?, model.mesh(&pose).map_err(text)?);
    for projection in [0, 5] {
        let view = View::new(&mut random, projection);
        let (camera, light, attachments) = (&view.camera, view.light, Attachments::ALL[0]);
        let style = style([true, true, true, false], attachments);
        let expected = render(&gpu, &Inputs { case, camera, light, style, marks: None, capacity: None, attachments })?;
        let mut drawing = Outlined::new(&gpu, light, 0, None)?;
        let handle = drawing.scene.insert_model(&model, &pose, DeformerOptions::default()).map_err(text)?;
        let picture = Picture { camera, corners: corners(case), attachments };
        let from_behind = Pose { forward: -view.pose.forward, right: -view.pose.right, ..view.pose }.camera(0, false);
        let views = [from_behind, *camera].map(FrameView::new);
        same("no view", &drawing.ink(&gpu, &picture, style, &[])?, &expected)?;
        same("one of two views", &drawing.ink(&gpu, &picture, style, &views)?, &expected)?;
        let other = drawing.ink(&gpu, &picture, style, &views[..1]);
        let no_view = OutlineError::NoView.to_string();
        if other != Err(no_view.clone()) {
            return Err(format!("{:?}, expected {no_view}", other.map(|ink| ink.len())));
        }
        drawing.scene.set_pose(handle, &bending_tube().1(2.6)).map_err(text)?;
        must_fail("another pose", &same("pose", &drawing.ink(&gpu, &picture, style, &[])?, &expected))?;
    }
    Ok(())
}
