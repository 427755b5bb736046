//! Casters behind occluders: only those are culled, and all bits are right when they are not culled any more.

use glam::{DMat3, DVec3};
use rimline::gpu::{
    Caster, CasterHandle, FrameInputs, LightHandle, Measuring, MeshHandle, Scene, SceneFrame, SceneOptions, ShadowError,
};
use rimline::internals::scene::SceneTable;
use rimline::{Light, Matrix3x4, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused};
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail, same};

use crate::found::Found;

pub(crate) const TESTS: &[Test] = &[
    ("occluded_casters_are_culled_and_others_are_not", random),
    ("cracks_and_edges_cull_nothing", edges),
    ("most_turns_of_reach", most_tried),
    ("polygons_that_are_no_occluders_are_refused", refusals),
];

/// A caster of the test.
#[derive(Clone, Copy)]
struct Body {
    /// 0: a cube, 1: a sphere, 2: an open sheet.
    mesh: usize,
    rows: Matrix3x4,
}

/// Quads of a cube from −1 to 1, counter-clockwise seen from outside.
fn cube_sides() -> Vec<Vec<[f32; 3]>> {
    let side = |axis: usize, sign: f32| {
        let corner = |u: f32, v: f32| {
            let mut corner = [0.0; 3];
            (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (sign, sign * u, v);
            corner
        };
        vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
    };
    [0, 1, 2].into_iter().flat_map(|axis| [side(axis, -1.0), side(axis, 1.0)]).collect()
}

fn sheet() -> Shape {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3]] }
}

fn shapes() -> [Shape; 3] {
    [shapes::cube(), shapes::sphere(2), sheet()]
}

/// Occluders of a mesh: sides of the cube, faces of the sphere, the sheet from both sides.
fn occluders(mesh: usize) -> Vec<Vec<[f32; 3]>> {
    match mesh {
        0 => cube_sides(),
        1 => {
            let shape = shapes::sphere(2);
            let triangle = |face: &[u32; 3]| face.map(|vertex| shape.positions[vertex as usize]).to_vec();
            shape.faces.iter().step_by(7).map(triangle).collect()
        }
        _ => vec![sheet().positions],
    }
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
        let add = |shape: &Shape| {
            let mesh: Mesh = shape.mesh().map_err(text)?;
            scene.add_mesh(&mesh, &shape.positions).map_err(text)
        };
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

    fn encode(&mut self, gpu: &Gpu) -> Result<SceneFrame, String> {
        gpu.submit(|encoder| self.scene.encode(encoder, FrameInputs::default()).map_err(text))
    }
}

fn rows(random: &mut Random, scales: [f32; 3], at: [f32; 3]) -> Matrix3x4 {
    let axis = DVec3::from(random.direction().map(f64::from)).normalize();
    let turn = DMat3::from_axis_angle(axis, f64::from(random.between(-3.0, 3.0)));
    let sign = if random.below(3) == 0 { -1.0 } else { 1.0 };
    let turn = if random.below(3) == 0 { DMat3::IDENTITY } else { turn };
    std::array::from_fn(|row| {
        std::array::from_fn(|column| match column {
            3 => at[row],
            0 => (sign * turn.col(0)[row] * f64::from(scales[0])) as f32,
            _ => (turn.col(column)[row] * f64::from(scales[column])) as f32,
        })
    })
}

fn placed(rows: &Matrix3x4, position: [f32; 3]) -> DVec3 {
    let position = DVec3::from(position.map(f64::from));
    DVec3::from(rows.map(|row| {
        let [x, y, z, shift] = row.map(f64::from);
        x * position.x + y * position.y + z * position.z + shift
    }))
}

/// Whether a polygon is strictly between a point and the light: by where the ray meets its plane.
fn is_between(polygon: &[DVec3], point: DVec3, light: Light) -> bool {
    let normal = polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(a, b)| a.cross(*b)).sum::<DVec3>();
    let xyz = DVec3::from(light.xyz.map(f64::from));
    let (toward, end) = if light.w == 0.0 { (xyz, f64::INFINITY) } else { (xyz / f64::from(light.w) - point, 1.0) };
    let at = normal.dot(polygon[0] - point) / normal.dot(toward);
    if !(at > 0.0 && at < end) {
        return false;
    }
    let met = point + at * toward;
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    edges.into_iter().all(|(a, b)| (*b - *a).cross(met - *a).dot(normal) > 0.0)
}

/// Whether the polygon is back-facing.
fn is_back_facing(polygon: &[DVec3], light: Light, is_mirrored: bool) -> bool {
    let normal = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]);
    let toward = DVec3::from(light.xyz.map(f64::from)) - f64::from(light.w) * polygon[0];
    (normal.dot(toward) < 0.0) != is_mirrored
}

/// Whether one polygon of another caster is between the light and all corners of a caster's box.
fn is_occluded(bodies: &[Body], number: usize, light: Light) -> bool {
    let shape = &shapes()[bodies[number].mesh];
    let end = |pick: fn(f32, f32) -> f32| {
        shape.positions.iter().copied().reduce(|a, b| std::array::from_fn(|axis| pick(a[axis], b[axis])))
    };
    let (Some(low), Some(high)) = (end(f32::min), end(f32::max)) else { return false };
    let corners: Vec<DVec3> = (0..8)
        .map(|corner| {
            let position = std::array::from_fn(|axis| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] });
            placed(&bodies[number].rows, position)
        })
        .collect();
    bodies.iter().enumerate().filter(|(other, _)| *other != number).any(|(_, body)| {
        let columns = [0, 1, 2].map(|column| DVec3::from(body.rows.map(|row| f64::from(row[column]))));
        let is_mirrored = columns[0].dot(columns[1].cross(columns[2])) < 0.0;
        occluders(body.mesh).iter().any(|polygon| {
            let polygon: Vec<DVec3> = polygon.iter().map(|&corner| placed(&body.rows, corner)).collect();
            (body.mesh == 2 || is_back_facing(&polygon, light, is_mirrored))
                && corners.iter().all(|&corner| is_between(&polygon, corner, light))
        })
    })
}

fn lights(random: &mut Random) -> Vec<Light> {
    let count = [3, 35][usize::from(random.below(4) == 0)];
    let light = |_| {
        let xyz = [(); 3].map(|()| random.between(-12.0, 12.0));
        match random.below(3) {
            0 => Light::directional(random.direction()),
            1 => Light::homogeneous([3.0 * xyz[0], 3.0 * xyz[1], 3.0 * xyz[2], 3.0]),
            _ => Light::point(xyz).with_range(random.between(5.0, 40.0)),
        }
    };
    (0..count).map(light).collect()
}

/// Large plates and boxes, small bodies among them.
fn random_body(random: &mut Random) -> Body {
    let at = [(); 3].map(|()| random.between(-5.0, 5.0));
    if random.below(3) > 0 {
        let size = random.between(0.02, 0.3);
        return Body { mesh: random.below(3), rows: rows(random, [size; 3], at) };
    }
    let size = random.between(2.0, 5.0);
    let scales = [[size, 0.05, size], [size; 3], [size, size, 0.5]][random.below(3)];
    Body { mesh: random.below(3), rows: rows(random, scales, at) }
}

/// Fails if a pair is culled that is not occluded, or has other bits than in a new scene. Returns how many pairs are
/// culled, and how many are occluded.
fn check(gpu: &Gpu, stage: &mut Stage, bodies: &[Body], given: &[Light]) -> Result<[u32; 2], String> {
    let frame = stage.encode(gpu)?;
    let found = Found::read(gpu, &frame)?;
    let mut plain = Stage::new(gpu, bodies, given, false)?;
    let plain_frame = plain.encode(gpu)?;
    let all = Found::read(gpu, &plain_frame)?;
    let (mut culled, mut occluded) = (0, 0);
    for (number, (&caster, &other)) in stage.casters.iter().zip(&plain.casters).enumerate() {
        let (index, group) = frame.locate(caster).ok_or("no caster")?;
        let (plain_index, plain_group) = plain_frame.locate(other).ok_or("no caster")?;
        for batch in 0..frame.batches() {
            let at = |index: u32| batch * bodies.len() + index as usize;
            let (relevant, plain_relevant) = (found.relevant[at(index)], all.relevant[at(plain_index)]);
            same("lights that are culled without occluders", &[relevant & !plain_relevant], &[0])?;
            for bit in (0..32).filter(|bit| plain_relevant >> bit & 1 != 0) {
                let Some(&light) = given.get(32 * batch + bit) else { continue };
                let [is_culled, is_occluded] = [relevant >> bit & 1 == 0, is_occluded(bodies, number, light)];
                if is_culled && !is_occluded {
                    return Err(format!("caster {number} is not occluded from light {bit}, {light:?}"));
                }
                culled += u32::from(is_culled);
                occluded += u32::from(is_occluded);
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
    same("counter", &[found.statistics.pairs_culled_by_occluders], &[culled])?;
    Ok([culled, occluded])
}

fn random() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut sum, mut shown) = ([0; 2], 0);
    for seed in 4601..if is_long() { 5601 } else { 4641 } {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let mut bodies: Vec<Body> = (0..2 + random.below(24)).map(|_| random_body(&mut random)).collect();
        let mut given = lights(&mut random);
        let mut stage = Stage::new(gpu, &bodies, &given, true)?;
        let mut last = 0;
        for _ in 0..5 {
            let [culled, occluded] = check(gpu, &mut stage, &bodies, &given)?;
            shown += u32::from(culled < last);
            last = culled;
            sum = [sum[0] + culled, sum[1] + occluded];
            match random.below(3) {
                0 => {
                    let light = random.below(given.len());
                    given[light] = lights(&mut random)[0];
                    stage.scene.set_light(stage.lights[light], given[light]).map_err(text)?;
                }
                _ => {
                    for (body, &caster) in bodies.iter_mut().zip(&stage.casters) {
                        if random.below(3) == 0 {
                            body.rows = random_body(&mut random).rows;
                            stage.scene.set_transform(caster, body.rows).map_err(text)?;
                        }
                    }
                }
            }
        }
    }
    println!("{} pairs culled of {} that are occluded; fewer than before in {shown} frames", sum[0], sum[1]);
    if sum[0] < 50 || 100 * sum[0] < 99 * sum[1] || shown == 0 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// A small sphere below plates, and a light above.
fn edges() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let body = |mesh, rows| Body { mesh, rows };
    let sheet = |x, half| body(2, [[half, 0.0, 0.0, x], [0.0, 0.0, 1.0, 0.0], [0.0, 2.0, 0.0, 0.0]]);
    let at = |mesh, x, y, size| body(mesh, [[size, 0.0, 0.0, x], [0.0, size, 0.0, y], [0.0, 0.0, size, 0.0]]);
    let (wide, ball) = (sheet(0.0, 2.0), at(1, 0.0, -1.0, 0.2));
    let sun = Light::directional([0.0, 1.0, 0.0]);
    let [lamp, level] = [[0.0, 4.0, 0.0], [9.0, 0.0, 0.0]].map(Light::point);
    // A hundredth of a texel of 2,048 across a sheet.
    let crack = 2.0 / 2048.0 / 100.0;
    let apart = |by: f32| [sheet(-1.0 - by * crack, 1.0), sheet(1.0 + by * crack, 1.0)];
    let cases: [(&str, Vec<Body>, Light, bool); 11] = [
        ("below a sheet", vec![wide, ball], sun, true),
        ("below a sheet, near light", vec![wide, ball], lamp, true),
        ("above it", vec![wide, at(1, 0.0, 1.0, 0.2)], sun, false),
        ("beyond the light", vec![wide, at(1, 0.0, 6.0, 0.2)], lamp, false),
        ("through it", vec![wide, at(1, 0.0, -0.1, 0.2)], sun, false),
        ("its box touches the plane", vec![wide, at(0, 0.0, -0.25, 0.25)], sun, false),
        ("below a crack", [&apart(0.5)[..], &[ball]].concat(), sun, false),
        ("beside the crack", [&apart(1.0)[..], &[at(1, 0.5, -1.0, 0.2)]].concat(), sun, true),
        ("its box touches a side plane", vec![wide, at(0, 1.75, -1.0, 0.25)], sun, false),
        ("nearly", vec![wide, at(0, 1.749, -1.0, 0.25)], sun, true),
        ("the light is in the plane", vec![wide, ball], level, false),
    ];
    for (what, bodies, light, expected) in cases {
        let mut stage = Stage::new(gpu, &bodies, &[light], true)?;
        check(gpu, &mut stage, &bodies, &[light]).map_err(|error| format!("{what}: {error}"))?;
        let frame = stage.encode(gpu)?;
        let found = Found::read(gpu, &frame)?;
        let (index, _) = frame.locate(*stage.casters.last().ok_or("no caster")?).ok_or("no caster")?;
        same(what, &[found.relevant[index as usize] == 0], &[expected])?;
        must_fail("the opposite", &same(what, &[found.relevant[index as usize] == 0], &[!expected]))?;
    }
    // Without the switch, and with excluded faces, nothing is culled.
    let bodies = [wide, ball];
    for (switch, excludes, expected) in [(true, false, 1), (false, false, 0), (true, true, 0)] {
        let mut stage = Stage::new(gpu, &bodies, &[sun], switch)?;
        if excludes {
            stage.scene.set_excluded(stage.casters[0], stage.lights[0], &[1]).map_err(text)?;
        }
        let frame = stage.encode(gpu)?;
        same("culled", &[Found::read(gpu, &frame)?.statistics.pairs_culled_by_occluders], &[expected])?;
    }
    Ok(())
}

/// The most occluders that are tested, as in `cull_lights.wgsl`.
const MOST_OCCLUDERS: usize = 128;

/// `cull_lights` tests the maximum number of occluders, each with the maximum of corners, for all lights of a batch.
/// For all but the last occluder the box is outside the last edge alone. llvmpipe ends an invocation's loops after
/// 65,535 turns without an error, and `cull_lights` would then miss the last occluder. A further occluder is not
/// tested.
fn most_tried() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    // In the plane of a sheet, with an edge on the right, from its last corner to its first.
    let octagon: Vec<[f32; 3]> = (0..8)
        .map(|corner| {
            let (sine, cosine) = ((2 * corner + 1) as f32 * std::f32::consts::PI / 8.0).sin_cos();
            [0.9 * cosine, 0.9 * sine, 0.0]
        })
        .collect();
    // Its middle is that far beyond the edge of an octagon at the left, or in the middle of one.
    let apart = 0.9 * (std::f32::consts::PI / 8.0).cos() + 0.12;
    let flat = |x: f32| [[1.0, 0.0, 0.0, x], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]];
    let ball = [[0.02, 0.0, 0.0, 0.0], [0.0, 0.02, 0.0, -0.1], [0.0, 0.0, 0.02, 0.0]];
    for (near_misses, expected) in [(MOST_OCCLUDERS - 1, 32), (MOST_OCCLUDERS, 0)] {
        let options = SceneOptions::default();
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let [sheet, sphere] = [sheet(), shapes::sphere(2)].map(|shape| {
            let mesh = shape.mesh().map_err(text)?;
            scene.add_mesh(&mesh, &shape.positions).map_err(text)
        });
        let (sheet, sphere) = (sheet?, sphere?);
        let mut casters = Vec::new();
        for number in 0..=near_misses {
            let x = if number < near_misses { -apart } else { 0.0 };
            let caster = scene.insert(Caster::rigid(sheet, flat(x))).map_err(text)?;
            scene.set_occluders(caster, &[&octagon]).map_err(text)?;
            casters.push(caster);
        }
        let hidden = scene.insert(Caster::rigid(sphere, ball)).map_err(text)?;
        for number in 0..32 {
            let [x, z] = [number % 6, number / 6].map(|step| step as f32 / 40.0 - 0.06);
            scene.add_light(Light::directional([x, 1.0, z])).map_err(text)?;
        }
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let found = Found::read(gpu, &frame)?;
        let index = |caster: CasterHandle| frame.locate(caster).map(|(index, _)| index).ok_or("no caster");
        let indices = casters.iter().map(|&caster| index(caster)).collect::<Result<Vec<_>, _>>()?;
        if !indices.is_sorted() {
            return Err("the occluder that culls is not the last".to_owned());
        }
        let relevant = found.relevant[index(hidden)? as usize];
        let what = format!("{near_misses} near misses");
        same(&what, &[found.statistics.pairs_culled_by_occluders, (!relevant).count_ones()], &[expected; 2])?;
    }
    Ok(())
}

fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let bodies = [Body { mesh: 0, rows: rows(&mut Random::new(1), [1.0; 3], [0.0; 3]) }];
    let mut stage = Stage::new(gpu, &bodies, &[], true)?;
    let caster = stage.casters[0];
    let mut row = |what, polygons: &[&[[f32; 3]]], expected| {
        refused([refusal(what, stage.scene.set_occluders(caster, polygons), expected)])
    };
    let good: &[[f32; 3]] = &[[1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0]];
    let corners = |number, corners| is(ShadowError::OccluderCorners { number, corners });
    row("good", &[good, good], Expected::Taken)?;
    row("two corners", &[good, &good[..2]], corners(1, 2))?;
    row("nine corners", &[&[[1.0; 3]; 9]], corners(0, 9))?;
    for c in [1.5, f32::NAN, f32::INFINITY] {
        let position = [1.0, c, 1.0];
        let outside = ShadowError::OccluderOutside { number: 0, corner: 2, position };
        row("outside", &[&[good[0], good[1], position]], is(outside))?;
    }
    // Only rigid casters have occluders.
    let shape = shapes::cube();
    let buffer = gpu.storage(&shape.positions);
    let positions = rimline::gpu::PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    stage.scene.set_positions(caster, positions).map_err(text)?;
    same("in a buffer", &[stage.scene.set_occluders(caster, &[good]).err()], &[Some(ShadowError::NotRigid)])
}
