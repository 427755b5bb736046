//! Example `deferred`: surfaces have the light that reaches them, of eight lamps and of 32 samples, by rays in `f64`.

#[path = "../../examples/deferred/main.rs"]
#[allow(dead_code, reason = "the example's own main is not run here")]
mod deferred;

use deferred::{AREA, AREA_COLOR, corners, lamps};
use glam::{DVec3, Mat4};
use rimline::Light;
use rimline_testkit::must_fail;
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;

/// Smaller than the example's picture, of the same shape.
const SIZE: [u32; 2] = [384, 256];
const PIXELS: usize = 4000;

fn position(light: Light) -> DVec3 {
    DVec3::from(light.xyz.map(f64::from))
}

/// A surface at a pixel of the picture.
struct Seen {
    albedo: DVec3,
    normal: DVec3,
    position: DVec3,
    /// Whether something is between the surface and a lamp.
    dark: [bool; 8],
    /// How many samples of the area light are in shadow.
    area: usize,
}

struct Truth(Tracer<DVec3>);

impl Truth {
    fn new() -> Self {
        let corners = corners();
        let face = |face: &[[f32; 8]]| {
            let corners = [0, 1, 2].map(|at| DVec3::new(face[at][0].into(), face[at][1].into(), face[at][2].into()));
            (corners, DVec3::new(face[0][4].into(), face[0][5].into(), face[0][6].into()))
        };
        Self(Tracer::build(corners.chunks(3).map(face)))
    }

    fn at(&self, [x, y]: [f64; 2]) -> Option<Seen> {
        let camera = deferred::camera();
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let [right, up, ahead] = [0, 1, 3].map(|row| matrix.row(row).truncate());
        let [x, y] = [2.0 * x / f64::from(SIZE[0]) - 1.0, 1.0 - 2.0 * y / f64::from(SIZE[1])];
        let ray = right * (x / right.length_squared()) + up * (y / up.length_squared()) + ahead;
        let (point, triangle) = self.0.first((DVec3::from(camera.eye.map(f64::from)), ray))?;
        let [a, b, c] = triangle.corners;
        let is_dark = |light: Light| {
            let mut meetings = self.0.meetings((point, position(light) - point));
            meetings.any(|(t, other)| t > 1e-6 && t < 1.0 && !std::ptr::eq(other, triangle))
        };
        let area = AREA.samples(32).into_iter().filter(|light| is_dark(*light)).count();
        let normal = (b - a).cross(c - a).normalize();
        Some(Seen {
            albedo: triangle.of,
            normal,
            position: point,
            dark: lamps().map(|(light, _)| is_dark(light)),
            area,
        })
    }
}

impl Seen {
    /// The colour with so many samples of the area light in shadow, 0 to 1.
    fn color(&self, area: usize) -> DVec3 {
        let light_of = |light: Light, color: [f32; 3]| {
            let towards = position(light) - self.position;
            let falloff = (1.0 - towards.length_squared() / f64::from(light.range).powi(2)).max(0.0).powi(2);
            DVec3::from(color.map(f64::from)) * falloff * self.normal.dot(towards.normalize()).max(0.0)
        };
        let lamps = lamps().into_iter().zip(self.dark).filter(|(_, is_dark)| !is_dark);
        let lamps: DVec3 = lamps.map(|((light, color), _)| light_of(light, color)).sum();
        let share = (32 - area) as f64 / 32.0;
        let light = DVec3::new(0.05, 0.05, 0.06) + lamps + share * light_of(AREA.light, AREA_COLOR);
        (self.albedo * light).min(DVec3::ONE).powf(1.0 / 2.2)
    }
}

/// The darkest and the brightest colour that a pixel may have, and the samples in shadow there.
struct Expected {
    pixel: [u32; 2],
    colors: [DVec3; 2],
    area: usize,
    dark: [bool; 8],
}

/// A pixel without a border of a body or of a lamp's shadow near it.
fn expected(truth: &Truth, pixel: [u32; 2]) -> Option<Expected> {
    let at = |[x, y]: [f64; 2]| truth.at([f64::from(pixel[0]) + x, f64::from(pixel[1]) + y]);
    let around = [[-0.5, -0.5], [1.5, -0.5], [-0.5, 1.5], [1.5, 1.5], [0.5, 0.5]].map(at);
    let within = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]].map(at);
    let all = within.iter().chain(&around).map(Option::as_ref).collect::<Option<Vec<&Seen>>>()?;
    let first = all[0];
    let is_steady =
        |seen: &&Seen| seen.dark == first.dark && seen.albedo == first.albedo && seen.normal.dot(first.normal) > 0.97;
    if !all.iter().all(is_steady) {
        return None;
    }
    let areas = all.iter().map(|seen| seen.area);
    let (least, most) = (areas.clone().min()?, areas.max()?);
    // The example writes the mean of four, each as it is shown.
    let mean = |area| all[..4].iter().map(|seen| seen.color(area)).sum::<DVec3>() / 4.0;
    Some(Expected { pixel, colors: [most, least].map(mean), area: first.area, dark: first.dark })
}

fn compare(picture: &[u8], all: &[Expected]) -> Result<(), String> {
    let mut wrong = all.iter().filter_map(|Expected { pixel: [x, y], colors: [low, high], area, dark }| {
        let at = 4 * (y * SIZE[0] + x) as usize;
        let drawn = DVec3::from([0, 1, 2].map(|channel| f64::from(picture[at + channel])));
        let is_in = drawn.cmpge(*low * 255.0 - 3.0).all() && drawn.cmple(*high * 255.0 + 3.0).all();
        let between = || format!("{drawn} at {:?}, not from {low} to {high}; {area}, {dark:?}", [x, y]);
        (!is_in).then(between)
    });
    match wrong.next() {
        None => Ok(()),
        Some(first) => Err(format!("{} of {} pixels, first {first}", 1 + wrong.count(), all.len())),
    }
}

#[test]
fn surfaces_have_the_light_that_reaches_them() {
    let canvas = deferred::support::Canvas::of_size(SIZE).expect("there is a GPU");
    let picture = canvas.pixels(deferred::picture(&canvas).expect("it is drawn")).expect("it is read");
    let (truth, mut random) = (Truth::new(), Random::new(5));
    let pixels = (0..PIXELS).map(|_| SIZE.map(|size| 2 + random.below(size as usize - 4) as u32));
    let mut all: Vec<Expected> = pixels.filter_map(|pixel| expected(&truth, pixel)).collect();
    let lamps: Vec<usize> = (0..8).map(|lamp| all.iter().filter(|one| one.dark[lamp]).count()).collect();
    let soft = all.iter().filter(|one| (1..32).contains(&one.area)).count();
    println!("{} pixels; in shadow of the lamps {lamps:?}; {soft} in the penumbra", all.len());
    assert!(all.len() > 1000 && soft > 50 && lamps.iter().all(|&count| count > 50), "too few of a kind");
    compare(&picture, &all).expect("the picture is what rays see");
    all.iter_mut().filter(|one| one.dark[3]).take(1).for_each(|one| one.colors = one.colors.map(|color| color + 0.05));
    must_fail("a lamp that shines through a slab", &compare(&picture, &all)).expect("it is noticed");
}
