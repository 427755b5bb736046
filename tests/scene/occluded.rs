//! Casters behind occluders: only those are culled, and all bits are right when they are not culled any more.

use glam::{DAffine3, DMat3, DVec3};
use rimline::gpu::{
    Caster, CasterHandle, FrameInputs, LightHandle, Measuring, MeshHandle, Scene, SceneFrame, SceneOptions, ShadowError,
};
use rimline::internals::scene::SceneTable;
use rimline::{Light, Matrix3x4};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused};
use rimline_testkit::scenes::direction;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, is_long, must_fail, same};

use crate::found::Found;

pub(crate) const TESTS: &[Test] = &[
    ("occluded_casters_are_culled_and_others_are_not", known),
    ("most_turns_of_reach", most_tried),
    ("the_same_occluders_again_keep_the_layout", again),
    ("polygons_that_are_no_occluders_are_refused", refusals),
];

/// A caster of the test.
#[derive(Clone, Copy)]
struct Body {
    /// 0: a cube, 1: a sphere, 2: an open sheet.
    mesh: usize,
    rows: Matrix3x4,
}

fn shapes() -> [Shape; 3] {
    [shapes::cube(), shapes::sphere(2), shapes::square()]
}

/// Occluders of a mesh: sides of the cube, counter-clockwise seen from outside, faces of the sphere, the sheet from both
/// sides.
fn occluders(mesh: usize) -> Vec<Vec<[f32; 3]>> {
    if mesh == 2 {
        return vec![shapes::square().positions];
    }
    if mesh == 1 {
        let Shape { positions, faces } = shapes::sphere(2);
        return faces.iter().step_by(7).map(|face| face.map(|vertex| positions[vertex as usize]).to_vec()).collect();
    }
    let side = |(axis, sign): (usize, f32)| {
        let corner = |[u, v]: [f32; 2]| {
            let mut corner = [0.0; 3];
            (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (sign, sign * u, v);
            corner
        };
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner).to_vec()
    };
    (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]).map(side).collect()
}

struct Stage {
    scene: Scene,
    casters: Vec<CasterHandle>,
    lights: Vec<LightHandle>,
}

impl Stage {
    fn new(gpu: &Gpu, bodies: &[Body], lights: &[Light], skip_occluded: bool) -> Result<Self, String> {
        let mut options = SceneOptions { max_lights: 40, ..SceneOptions::default() };
        options.measuring.set(Measuring::CULLED_BY_OCCLUDERS, !skip_occluded);
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let add = |shape: &Shape| scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text);
        let meshes: Vec<MeshHandle> = shapes().iter().map(add).collect::<Result<_, String>>()?;
        let mut casters = Vec::new();
        for body in bodies {
            let caster = scene.insert(Caster::rigid(meshes[body.mesh], body.rows)).map_err(text)?;
            let polygons = occluders(body.mesh);
            let polygons: Vec<&[[f32; 3]]> = polygons.iter().map(|polygon| &polygon[..]).collect();
            scene.set_occluders(caster, &polygons).map_err(text)?;
            casters.push(caster);
        }
        let lights = lights.iter().map(|&light| scene.add_light(light).map_err(text)).collect::<Result<_, _>>()?;
        Ok(Self { scene, casters, lights })
    }

    fn encode(&mut self, gpu: &Gpu) -> Result<(SceneFrame, Found), String> {
        let frame = gpu.submit(|encoder| self.scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let found = Found::read(gpu, &frame)?;
        Ok((frame, found))
    }

    fn move_to(&mut self, bodies: &[Body], lights: &[Light]) -> Result<(), String> {
        for (&caster, body) in self.casters.iter().zip(bodies) {
            self.scene.set_transform(caster, body.rows).map_err(text)?;
        }
        self.lights.iter().zip(lights).try_for_each(|(&to, &light)| self.scene.set_light(to, light)).map_err(text)
    }

    /// Fails unless the last caster is culled for all lights that are not within it or for none, or if others have other bits
    /// than without occluders.
    fn check(&mut self, gpu: &Gpu, bodies: &[Body], lights: &[Light], expected: bool) -> Result<(), String> {
        let (frame, found) = self.encode(gpu)?;
        let mut plain = Self::new(gpu, bodies, lights, false)?;
        let (plain_frame, all) = plain.encode(gpu)?;
        let mut culled = 0;
        for (number, (&caster, &other)) in self.casters.iter().zip(&plain.casters).enumerate() {
            let (index, group) = frame.locate(caster).ok_or("no caster")?;
            let (plain_index, plain_group) = plain_frame.locate(other).ok_or("no caster")?;
            for batch in 0..frame.batches() {
                let at = |index: u32| batch * bodies.len() + index as usize;
                let (relevant, plain_relevant) = (found.relevant[at(index)], all.relevant[at(plain_index)]);
                same("lights that are culled without occluders", &[relevant & !plain_relevant], &[0])?;
                culled += (plain_relevant & !relevant).count_ones();
                if number + 1 == bodies.len() {
                    let bits = (0..32).filter(|bit| 32 * batch + bit < lights.len() && is_within(32 * batch + bit));
                    let within = bits.fold(0_u32, |mask, bit| mask | 1 << bit);
                    same("lights within the caster", &[plain_relevant & within], &[within])?;
                    same("relevant lights", &[relevant], &[if expected { within } else { plain_relevant }])?;
                }
                let masks = |found: &Found, group, index| -> Result<Vec<u32>, String> {
                    let caster = SceneTable(&found.table).caster(index);
                    let slots = caster.first_face_slot as usize..(caster.first_face_slot + caster.faces) as usize;
                    Ok(found.group(group, batch)?.facing[slots].iter().map(|mask| mask & relevant).collect())
                };
                let expected = masks(&all, plain_group, plain_index)?;
                same(&format!("bits of caster {number}"), &masks(&found, group, index)?, &expected)?;
            }
        }
        same("counter", &[found.statistics.pairs_culled_by_occluders], &[culled])
    }
}

/// A rotation times a scale, mirrored now and then, and a shift.
fn similarity(random: &mut Random) -> DAffine3 {
    let turn = DMat3::from_axis_angle(direction(random), f64::from(random.between(-3.0, 3.0)));
    let scale = f64::from([1.0, -1.0][random.below(2)] * random.between(0.2, 5.0));
    let translation = DVec3::from([(); 3].map(|()| f64::from(random.between(-5.0, 5.0)) * scale));
    DAffine3 { matrix3: scale * turn, translation }
}

/// Whether the light of this number is within the last caster, so that nothing is between them.
const fn is_within(number: usize) -> bool {
    number % 5 == 4
}

/// Copies of a light, in two batches and with other weights, moved. Near ones have ranges, and some do not reach the caster.
/// Among them are other lights, within the caster.
fn lights(light: Light, by: &DAffine3, caster: &Body) -> Vec<Light> {
    let scale = by.matrix3.x_axis.length() as f32;
    let moved = by.matrix3 * DVec3::from(light.xyz.map(f64::from)) + f64::from(light.w) * by.translation;
    let weighted = |number: usize| {
        if is_within(number) {
            return Light::point(caster.rows.map(|row| row[3]));
        }
        let factor = [1.0, 3.0, 0.25][number % 3];
        let copy = Light::homogeneous((moved.extend(f64::from(light.w)) * factor).as_vec4().to_array());
        if light.w == 0.0 { copy } else { copy.with_range([f32::INFINITY, 30.0 * scale, scale][number / 5 % 3]) }
    };
    (0..35).map(weighted).collect()
}

fn moved(body: &Body, by: &DAffine3) -> Body {
    let [x, y, z, shift] = [0, 1, 2, 3].map(|column| DVec3::from(body.rows.map(|row| f64::from(row[column]))));
    let [x, y, z] = [x, y, z].map(|column| by.matrix3 * column);
    let shift = by.matrix3 * shift + by.translation;
    let rows = [0, 1, 2].map(|row| [x[row], y[row], z[row], shift[row]].map(|c| c as f32));
    Body { rows, ..*body }
}

/// A small body below or above plates and bodies, and a light above. Where they do not touch, all are also turned, scaled,
/// mirrored and moved, so that a caster is culled in one frame and not in the next.
fn known() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(4601)?;
    let body = |mesh, rows| Body { mesh, rows };
    let sheet = |x, half| body(2, [[half, 0.0, 0.0, x], [0.0, 0.0, 1.0, 0.0], [0.0, 2.0, 0.0, 0.0]]);
    let at = |mesh, x, y, size| body(mesh, [[size, 0.0, 0.0, x], [0.0, size, 0.0, y], [0.0, 0.0, size, 0.0]]);
    let (wide, ball) = (sheet(0.0, 2.0), at(1, 0.0, -1.0, 0.2));
    let sun = Light::directional([0.0, 1.0, 0.0]);
    let [lamp, level] = [[0.0, 4.0, 0.0], [9.0, 0.0, 0.0]].map(Light::point);
    // A hundredth of a texel of 2,048 across a sheet.
    let crack = 2.0 / 2048.0 / 100.0;
    let apart = |by: f32| [sheet(-1.0 - by * crack, 1.0), sheet(1.0 + by * crack, 1.0)];
    // The last is whether all may move.
    let cases: [(&str, Vec<Body>, Light, bool, bool); 14] = [
        ("below a sheet", vec![wide, ball], sun, true, true),
        ("above it", vec![wide, at(1, 0.0, 1.0, 0.2)], sun, false, true),
        ("below a sheet, near light", vec![wide, ball], lamp, true, true),
        ("beyond the light", vec![wide, at(1, 0.0, 6.0, 0.2)], lamp, false, true),
        ("below it again", vec![wide, ball], lamp, true, true),
        ("through it", vec![wide, at(1, 0.0, -0.1, 0.2)], sun, false, true),
        ("the light is in the plane", vec![wide, ball], level, false, false),
        ("its box touches the plane", vec![wide, at(0, 0.0, -0.25, 0.25)], sun, false, false),
        ("its box touches a side plane", vec![wide, at(0, 1.75, -1.0, 0.25)], sun, false, false),
        ("nearly", vec![wide, at(0, 1.749, -1.0, 0.25)], sun, true, false),
        ("below a crack", [&apart(0.5)[..], &[ball]].concat(), sun, false, false),
        ("beside the crack", [&apart(1.0)[..], &[at(1, 0.5, -1.0, 0.2)]].concat(), sun, true, true),
        ("below a cube", vec![at(0, 0.0, 2.0, 1.0), ball], sun, true, true),
        // Faces of closed bodies that face the light cast nothing.
        ("in a cube", vec![at(0, 0.0, -1.0, 2.0), ball], lamp, false, true),
    ];
    let mut last: Option<(Vec<usize>, Stage)> = None;
    for (what, bodies, light, expected, may_move) in cases {
        let meshes: Vec<usize> = bodies.iter().map(|body| body.mesh).collect();
        let given = lights(light, &DAffine3::IDENTITY, &bodies[bodies.len() - 1]);
        let (_, stage) = match &mut last {
            Some(last) if last.0 == meshes => last,
            last => last.insert((meshes, Stage::new(&gpu, &bodies, &given, true)?)),
        };
        stage.move_to(&bodies, &given)?;
        let what = |error: String| format!("{what}: {error}");
        stage.check(&gpu, &bodies, &given, expected).map_err(what)?;
        must_fail("the opposite", &stage.check(&gpu, &bodies, &given, !expected))?;
        for _ in 0..if !may_move {
            0
        } else if is_long() {
            200
        } else {
            6
        } {
            let by = similarity(&mut random);
            let bodies: Vec<Body> = bodies.iter().map(|body| moved(body, &by)).collect();
            let given = lights(light, &by, &bodies[bodies.len() - 1]);
            stage.move_to(&bodies, &given)?;
            stage.check(&gpu, &bodies, &given, expected).map_err(|error| what(format!("{by:?}: {error}")))?;
        }
    }
    // Without the switch, and with excluded faces, nothing is culled.
    for (switch, excludes, expected) in [(true, false, 1), (false, false, 0), (true, true, 0)] {
        let mut stage = Stage::new(&gpu, &[wide, ball], &[sun], switch)?;
        if excludes {
            stage.scene.set_excluded(stage.casters[0], stage.lights[0], &[1]).map_err(text)?;
        }
        same("culled", &[stage.encode(&gpu)?.1.statistics.pairs_culled_by_occluders], &[expected])?;
    }
    Ok(())
}

/// `cull_lights` tests at most 128 occluders, each with the maximum of corners, for all lights of a batch. For all but the
/// last occluder the box is outside the last edge alone. llvmpipe ends an invocation's loops after 65,535 turns without an
/// error, and `cull_lights` would then miss the last occluder. A further occluder is not tested, unless it is larger.
fn most_tried() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    // In the plane of a sheet, with an edge on the right, from its last corner to its first.
    let octagon: Vec<[f32; 3]> = (0..8)
        .map(|corner| {
            let (sine, cosine) = ((2 * corner + 1) as f32 * std::f32::consts::PI / 8.0).sin_cos();
            [0.9 * cosine, 0.9 * sine, 0.0]
        })
        .collect();
    // The ball's middle is that far beyond the edge of an octagon at the left, or in the middle of one.
    let apart = 0.9 * (std::f32::consts::PI / 8.0).cos() + 0.12;
    let flat = |x: f32| [[1.0, 0.0, 0.0, x], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]];
    let ball = [[0.02, 0.0, 0.0, 0.0], [0.0, 0.02, 0.0, -0.1], [0.0, 0.0, 0.02, 0.0]];
    let light = |number: u8| {
        let [x, z] = [number % 6, number / 6].map(|step| f32::from(step) / 40.0 - 0.06);
        Light::directional([x, 1.0, z])
    };
    let lights: Vec<Light> = (0..32).map(light).collect();
    for (near_misses, scale, expected) in [(127, 1.0_f32, 32), (128, 1.0, 0), (128, 1.01, 32)] {
        let xs = (0..=near_misses).map(|number| if number < near_misses { -apart } else { 0.0 });
        let mut bodies: Vec<Body> = xs.map(|x| Body { mesh: 2, rows: flat(x) }).collect();
        bodies.push(Body { mesh: 1, rows: ball });
        let mut stage = Stage::new(gpu, &bodies, &lights, true)?;
        let (occluded, sheets) = stage.casters.split_last().ok_or("no caster")?;
        sheets.iter().try_for_each(|&sheet| stage.scene.set_occluders(sheet, &[&octagon])).map_err(text)?;
        let last: Vec<_> = octagon.iter().map(|corner| corner.map(|c| scale * c)).collect();
        stage.scene.set_occluders(sheets[near_misses], &[&last]).map_err(text)?;
        stage.scene.set_occluders(*occluded, &[]).map_err(text)?;
        let (frame, found) = stage.encode(gpu)?;
        let indices: Option<Vec<_>> = stage.casters.iter().map(|&caster| frame.locate(caster)).collect();
        let indices = indices.ok_or("no caster")?;
        if !indices[..=near_misses].is_sorted() {
            return Err("the occluder that culls is not the last".to_owned());
        }
        let relevant = found.relevant[indices[near_misses + 1].0 as usize];
        let what = format!("{near_misses} near misses, the last larger by {scale}");
        same(&what, &[found.statistics.pairs_culled_by_occluders, (!relevant).count_ones()], &[expected; 2])?;
    }
    Ok(())
}

/// The same occluders keep the layout, and so what is cached. Others do not.
fn again() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let bodies = [Body { mesh: 2, rows: IDENTITY }];
    let mut stage = Stage::new(gpu, &bodies, &[Light::directional([0.0, 1.0, 0.0])], true)?;
    let (first, _) = stage.encode(gpu)?;
    let mut keeps = |polygons: &[&[[f32; 3]]]| -> Result<bool, String> {
        stage.scene.set_occluders(stage.casters[0], polygons).map_err(text)?;
        Ok(stage.encode(gpu)?.0.has_layout_of(&first))
    };
    let positions = shapes::square().positions;
    same("the layout is the same", &[keeps(&[&positions])?, keeps(&[&positions[..3]])?], &[true, false])
}

fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let bodies = [Body { mesh: 0, rows: IDENTITY }];
    let mut stage = Stage::new(gpu, &bodies, &[], true)?;
    let caster = stage.casters[0];
    let good: &[[f32; 3]] = &[[1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0]];
    let corners = |number, corners| is(ShadowError::OccluderCorners { number, corners });
    let outside = |position| is(ShadowError::OccluderOutside { number: 0, corner: 2, position });
    let [far, nan] = [1.5, f32::NAN].map(|c| [1.0, c, 1.0]);
    let mut set = |polygons: &[&[[f32; 3]]]| stage.scene.set_occluders(caster, polygons);
    refused([
        refusal("good", set(&[good, good]), Expected::Taken),
        refusal("two corners", set(&[good, &good[..2]]), corners(1, 2)),
        refusal("nine corners", set(&[&[[1.0; 3]; 9]]), corners(0, 9)),
        refusal("outside", set(&[&[good[0], good[1], far]]), outside(far)),
        refusal("NaN", set(&[&[good[0], good[1], nan]]), outside(nan)),
    ])?;
    // Only rigid casters have occluders.
    let buffer = gpu.storage(&shapes::cube().positions);
    let positions = rimline::gpu::PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    stage.scene.set_positions(caster, positions).map_err(text)?;
    refused([refusal("in a buffer", stage.scene.set_occluders(caster, &[good]), is(ShadowError::NotRigid))])
}
