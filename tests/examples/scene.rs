//! Example `scene`: its figures and boxes stand where `contents` and `cpu::deform` say and throw the right shadows, by rays
//! in `f64`.

#[path = "../../examples/scene/main.rs"]
#[allow(dead_code, reason = "the example's own main is not run here")]
mod scene;

use std::array::from_fn;

use glam::{DMat4, DVec3, Mat4, Vec3};
use rimline::cpu::{self, Threads};
use rimline::wgpu;
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;
use rimline_testkit::{must_fail, shapes};
use scene::contents::{self, AMBIENT, LAMPS};
use scene::stage::Placed;
use scene::support::Canvas;

/// Smaller than the example's picture, of the same shape.
const SIZE: [u32; 2] = [576, 384];
const PIXELS: usize = 3000;

/// Surface that a ray from the eye meets.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Ground,
    Walker,
    Box,
}

/// The scene at a time.
struct Truth {
    tracer: Tracer<(Kind, Vec3)>,
}

/// The surface that should be seen at a position in the picture, or, by [`Truth::samples`], in a whole pixel.
struct Sample {
    pixel: [u32; 2],
    kind: Kind,
    /// For each lamp: whether it could light the point, and whether something is in between. The second is false, and the
    /// light counts, where the lamp gives no more than a hundredth of its colour.
    lamps: [[bool; 2]; LAMPS.len()],
    /// 0 to 255.
    color: DVec3,
}

fn corners(positions: &[[f32; 3]], face: [u32; 3]) -> [DVec3; 3] {
    face.map(|vertex| Vec3::from(positions[vertex as usize]).as_dvec3())
}

impl Truth {
    fn new(seconds: f32) -> Self {
        let model = contents::walkers().expect("a model");
        let pose = contents::pose(seconds).expect("a pose");
        let positions = cpu::deform(&model, &pose, seconds, None, Threads::all()).expect("the pose fits");
        let (walker, cube) = (&model.geometries()[0], shapes::cube());
        let walker_faces = |placed: &Placed| {
            let (vertices, albedo) = (&positions[placed.first_vertex as usize..], Vec3::from(placed.albedo));
            walker.faces().iter().map(|&face| (corners(vertices, face), (Kind::Walker, albedo))).collect::<Vec<_>>()
        };
        let box_of = |placed: &Placed| {
            let rows = placed.rows.map(|[x, y, z, shift]| (DVec3::from([x, y, z].map(f64::from)), f64::from(shift)));
            let transform = |p: DVec3| DVec3::from(rows.map(|(row, shift)| row.dot(p) + shift));
            let corners = |face| corners(&cube.positions, face).map(transform);
            cube.faces.iter().map(|&face| (corners(face), (Kind::Box, Vec3::from(placed.albedo)))).collect::<Vec<_>>()
        };
        let ground = [[-200.0, 200.0], [200.0, 200.0], [200.0, -200.0], [-200.0, -200.0]];
        let [a, b, c, d] = ground.map(|[x, z]| DVec3::new(x, 0.0, z));
        let ground = [[a, b, c], [a, c, d]].map(|corners| (corners, (Kind::Ground, Vec3::new(0.80, 0.79, 0.77))));
        let walkers = contents::dressed(walker.positions().len() as u32);
        let boxes = contents::boxes(seconds);
        let casters = walkers.iter().flat_map(walker_faces).chain(boxes.iter().flat_map(box_of));
        Self { tracer: Tracer::build(casters.chain(ground)) }
    }

    /// The sample at a position in the picture, in pixels.
    fn seen(&self, [x, y]: [f64; 2]) -> Option<Sample> {
        let camera = contents::camera();
        let matrix: DMat4 = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let eye = DVec3::from(camera.eye.map(f64::from));
        let [right, up, ahead] = [0, 1, 3].map(|row| matrix.row(row).truncate());
        let [x_ndc, y_ndc] = [2.0 * x / f64::from(SIZE[0]) - 1.0, 1.0 - 2.0 * y / f64::from(SIZE[1])];
        let ray = right * (x_ndc / right.length_squared()) + up * (y_ndc / up.length_squared()) + ahead;
        let (point, triangle) = self.tracer.first((eye, ray))?;
        let ([a, b, c], (kind, albedo)) = (triangle.corners, triangle.of);
        let normal = (b - a).cross(c - a).normalize();
        let around = DVec3::new(0.88, 0.95, 1.06) * f64::from(AMBIENT) * (0.75 + 0.25 * normal.y);
        let mut light = around;
        let lamps = LAMPS.map(|lamp| {
            let xyz = DVec3::from(lamp.light.xyz.map(f64::from));
            let [w, range] = [lamp.light.w, lamp.light.range].map(f64::from);
            let towards = xyz - w * point;
            let falloff = (1.0 - w * towards.length_squared() / (range * range)).max(0.0).powi(2);
            let strength = falloff * normal.dot(towards.normalize()).max(0.0);
            // The surface itself is at 0 on this ray, but for rounding, and a point light at 1.
            let is_between = |t: f64| t > 1e-5 && (w == 0.0 || t < 1.0);
            let is_dark = strength > 0.01 && self.tracer.meetings((point, towards)).any(|(t, _)| is_between(t));
            if !is_dark {
                light += DVec3::from(lamp.color.map(f64::from)) * strength;
            }
            [strength > 0.05, is_dark]
        });
        let color = (light * albedo.as_dvec3()).min(DVec3::ONE).powf(1.0 / 2.2) * 255.0;
        Some(Sample { pixel: [x as u32, y as u32], kind, lamps, color })
    }

    /// Pixels at random, without those with a corner near another kind of surface or near the border of a shadow. Borders
    /// between two figures, boxes or faces of one are in: the mean of four positions is right there, too.
    fn samples(&self, seed: u64) -> Vec<Sample> {
        let mut random = Random::new(seed);
        let sample = |_| {
            let pixel = SIZE.map(|size| 2 + random.below(size as usize - 4) as u32);
            let at = |[x, y]: [f64; 2]| self.seen([f64::from(pixel[0]) + x, f64::from(pixel[1]) + y]);
            // The picture's pixel is the mean of four.
            let within = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]].map(at);
            let about = [[-0.5, -0.5], [1.5, -0.5], [-0.5, 1.5], [1.5, 1.5]].map(at);
            let [first, ..] = &within;
            let (kind, lamps) = first.as_ref().map(|first| (first.kind, first.lamps))?;
            let shadows = lamps.map(|[_, is_dark]| is_dark);
            let alike = |part: &&Sample| part.kind == kind && part.lamps.map(|[_, is_dark]| is_dark) == shadows;
            let is_steady = within.iter().chain(&about).flatten().filter(alike).count() == 8;
            let color = within.iter().flatten().map(|part| part.color).sum::<DVec3>() / 4.0;
            is_steady.then_some(Sample { pixel, kind, lamps, color })
        };
        (0..PIXELS).filter_map(sample).collect()
    }
}

/// Whether the picture has the colours of the samples.
fn compare(picture: &[u8], samples: &[Sample]) -> Result<(), String> {
    let mut wrong = samples.iter().filter_map(|sample| {
        let [x, y] = sample.pixel.map(|at| at as usize);
        let at = 4 * (y * SIZE[0] as usize + x);
        let drawn = DVec3::from([0, 1, 2].map(|channel| f64::from(picture[at + channel])));
        let Sample { pixel, kind, lamps, color } = sample;
        let is_right = (drawn - color).abs().max_element() <= 4.0;
        (!is_right).then(|| format!("{kind:?} at pixel {pixel:?} is {drawn} and not {color}; lamps {lamps:?}"))
    });
    match wrong.next() {
        None => Ok(()),
        Some(first) => Err(format!("{} of {} pixels, first {first}", 1 + wrong.count(), samples.len())),
    }
}

#[test]
fn surfaces_have_the_light_that_reaches_them() {
    let canvas = Canvas::of_size(SIZE).expect("there is a GPU");
    let mut world = scene::World::new(&canvas).expect("a world");
    let mut frames = Vec::new();
    for (seed, seconds) in [(1, 0.75), (2, 3.2)] {
        let mut encoder = canvas.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        world.frame(&mut encoder, seconds).expect("it is drawn");
        let picture = canvas.pixels(encoder).expect("it is read");
        let mut samples = Truth::new(seconds).samples(seed);
        let count = |is: &dyn Fn(&Sample) -> bool| samples.iter().filter(|sample| is(sample)).count();
        let kinds = [Kind::Ground, Kind::Walker, Kind::Box].map(|kind| count(&|sample| sample.kind == kind));
        let lit: [_; LAMPS.len()] = from_fn(|lamp| count(&|sample| sample.lamps[lamp] == [true, false]));
        let dark: [_; LAMPS.len()] = from_fn(|lamp| count(&|sample| sample.lamps[lamp] == [true, true]));
        println!("seed {seed}: {kinds:?} on ground, figures and boxes; by lamp {lit:?} lit and {dark:?} in shadow");
        assert!(kinds.iter().chain(&lit).chain(&dark).all(|&count| count >= 15), "too few of a kind");
        compare(&picture, &samples).unwrap_or_else(|error| panic!("seed {seed}, {seconds} s: {error}"));
        // A shadow of the sun that is a little too light.
        let is_shadow = |sample: &Sample| sample.lamps[0] == [true, true];
        let shadow = samples.iter().position(is_shadow).expect("there are some");
        samples[shadow].color += 20.0;
        must_fail("a lit shadow", &compare(&picture, &samples)).expect("it is noticed");
        samples[shadow].color -= 20.0;
        frames.push((picture, samples));
    }
    must_fail("figures of another time", &compare(&frames[0].0, &frames[1].1)).expect("they are noticed");
}
