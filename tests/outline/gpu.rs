//! Outlines that the GPU draws, against rays and projections in `f64`.
//!
//! The stage is `outline_edges`.

mod refusals;
mod rendered;
mod scenes;
mod widths;

use glam::{DMat4, DVec2, DVec3, DVec4};
use rendered::{Attachments, Inputs, SIDE, render};
use rimline::gpu::OutlineStyle;
use rimline::mesh::Edge;
use rimline::{Light, Mesh, ShadowCamera};
use rimline_testkit::cases::{Case, case, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::{self, Test};
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;
use rimline_testkit::scenes::{Pose, direction};
use rimline_testkit::shapes::{self, Shape};

fn main() {
    let tests: [&[Test]; 4] = [TESTS, scenes::TESTS, widths::TESTS, refusals::TESTS];
    harness::run(harness::gpu_trials(tests.concat()));
}

const TESTS: &[Test] = &[("outlines_are_what_rays_see", seen)];

/// Half the width of lines, in pixels.
const HALF: f64 = 1.5;
/// The angle of creases, which no edge of the cases has.
const ANGLE: f64 = 0.5;

const CLASSES: [Classes; 6] = [
    [true, true, false, false],
    [true; 4],
    [true, false, true, false],
    [false, true, false, true],
    [true, false, false, true],
    [false, false, false, true],
];

/// A camera, and the light that stands for its eye.
struct View {
    pose: Pose,
    is_parallel: bool,
    camera: ShadowCamera,
    light: Light,
    matrix: DMat4,
}

impl View {
    fn new(random: &mut Random, projection: usize) -> Self {
        let forward = direction(random);
        let right = forward.cross(direction(random)).normalize();
        // Some eyes are so near that the near plane cuts the model.
        let far = if projection / 2 < 2 && random.below(3) == 0 { 1.3 } else { 3.5 };
        let pose = Pose { eye: -far * forward, forward, right, up: right.cross(forward), near: 0.4, scale: 2.2 };
        let camera = pose.camera(projection, random.below(2) == 0);
        let is_parallel = projection / 2 == 2;
        let light = if is_parallel {
            Light::directional((-forward).as_vec3().into())
        } else {
            Light::point(pose.eye.as_vec3().into())
        };
        let matrix = DMat4::from_cols_array_2d(&camera.view_projection.map(|column| column.map(f64::from)));
        Self { pose, is_parallel, camera, light, matrix }
    }

    fn pixel(&self, point: DVec3) -> DVec2 {
        let origin = DVec3::from(self.camera.origin.map(f64::from));
        let clip: DVec4 = self.matrix * (point - origin).extend(1.0);
        DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * f64::from(SIDE)
    }

    /// How far before the near plane a point is.
    fn before_near(&self, point: DVec3) -> f64 {
        (point - self.pose.eye).dot(self.pose.forward) - self.pose.near
    }

    /// The part of an edge before the near plane.
    fn cut(&self, [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let [x, y] = [a, b].map(|point| self.before_near(point) - 1e-6);
        let at = a.lerp(b, x / (x - y));
        match (x > 0.0, y > 0.0) {
            (true, true) => Some([a, b]),
            (true, false) => Some([a, at]),
            (false, true) => Some([at, b]),
            (false, false) => None,
        }
    }

    /// Whether the ray to `point`, moved by this number of pixels, meets a face before this share of its length.
    fn is_blocked(&self, tracer: &Tracer<()>, point: DVec3, moved: DVec2, share: f64) -> bool {
        let [right, up] = [self.pose.right, self.pose.up];
        // The world's length of a pixel there, by a small step, along each axis.
        let step = 1e-5;
        let length = |axis: DVec3| step / (self.pixel(point + step * axis) - self.pixel(point)).length();
        let point = point + right * moved.x * length(right) + up * moved.y * length(up);
        let from = if self.is_parallel { point - 6.0 * self.pose.forward } else { self.pose.eye };
        let direction = point - from;
        let is_met = |t: f64| t < share && self.before_near(from + t * direction) > 0.0;
        tracer.meetings((from, direction)).any(|(t, _)| is_met(t))
    }
}

/// Which classes of lines are drawn: silhouettes, boundaries, creases, marked edges.
type Classes = [bool; 4];

/// Black lines of these classes.
fn style(classes: Classes, attachments: Attachments) -> OutlineStyle {
    let [silhouette, boundary, crease, marked] = classes.map(|is_drawn| is_drawn.then_some([0.0, 0.0, 0.0, 1.0]));
    OutlineStyle {
        width: 2.0 * HALF as f32,
        silhouette,
        boundary,
        crease,
        crease_angle: ANGLE as f32,
        marked,
        depth_bias: attachments.bias,
    }
}

/// Whether an edge is of a class that is drawn.
fn is_drawn(edge: &Edge, number: usize, (_, positions, mesh): &Case, view: &View, classes: Classes) -> bool {
    let [silhouettes, boundaries, creases, marked] = classes;
    let at = |v: u32| DVec3::from(positions[v as usize].map(f64::from));
    let normal = |face: u32| {
        let [a, b, c] = mesh.faces()[face as usize].map(at);
        (b - a).cross(c - a)
    };
    let faces = |face: u32| {
        let to_eye =
            if view.is_parallel { -view.pose.forward } else { view.pose.eye - at(mesh.faces()[face as usize][0]) };
        normal(face).dot(to_eye) > 0.0
    };
    let is_marked = marked && is_marked(number);
    let Some(other) = edge.face_1 else { return boundaries || is_marked };
    let is_consistent = edge.kind == rimline::mesh::EdgeKind::Consistent;
    if (faces(edge.face_0) == faces(other)) != is_consistent {
        return silhouettes || is_marked;
    }
    let turned = if is_consistent { 1.0 } else { -1.0 };
    let angle = normal(edge.face_0).angle_between(turned * normal(other));
    (creases && angle > ANGLE) || is_marked
}

fn is_marked(record: usize) -> bool {
    record % 7 == 3
}

fn marks(mesh: &Mesh) -> Vec<u32> {
    let mut words = vec![0; mesh.edges().len().div_ceil(32)];
    (0..mesh.edges().len())
        .filter(|&record| is_marked(record))
        .for_each(|record| words[record / 32] |= 1 << (record % 32));
    words
}

/// The ink that each pixel has to have.
struct Truth {
    /// A line passes through the pixel that nothing hides.
    must: Vec<bool>,
    /// A line that something may leave visible is near the pixel.
    may: Vec<bool>,
}

/// `has_outline` tells it of a vertex.
fn truth(case: &Case, view: &View, classes: Classes, has_outline: impl Fn(u32) -> bool) -> Truth {
    let at = |v: u32| DVec3::from(case.1[v as usize].map(f64::from));
    let tracer = Tracer::build(case.2.faces().iter().map(|face| (face.map(at), ())));
    let pixels = (SIDE * SIDE) as usize;
    let mut truth = Truth { must: vec![false; pixels], may: vec![false; pixels] };
    let around: Vec<DVec2> =
        (0..9_u8).map(|n| DVec2::new(f64::from(n % 3) - 1.0, f64::from(n / 3) - 1.0) * 1.6).collect();
    for (number, edge) in case.2.edges().iter().enumerate() {
        if !has_outline(edge.vertices[0]) || !is_drawn(&edge, number, case, view, classes) {
            continue;
        }
        let Some([a, b]) = view.cut(edge.vertices.map(at)) else { continue };
        let span = view.pixel(b) - view.pixel(a);
        let steps = (span.length() / 0.4).ceil().max(1.0) as usize;
        // A pixel and a half farther on the edge, as a share of it.
        let further = 1.5 / span.length().max(1e-9);
        for step in 0..=steps {
            let share = step as f64 / steps as f64;
            let point = a.lerp(b, share);
            let pixel = view.pixel(point);
            if (pixel / f64::from(SIDE) - 0.5).abs().max_element() > 0.52 {
                continue;
            }
            let is_clear = |further: f64| {
                let point = a.lerp(b, (share + further).clamp(0.0, 1.0));
                !view.is_blocked(&tracer, point, DVec2::ZERO, 1.0 - 1e-6)
            };
            // How many of the pixels around see something much nearer: a gap may be too narrow to see a line through.
            let blocked = around.iter().filter(|&&moved| view.is_blocked(&tracer, point, moved, 0.9)).count();
            // At the border nothing tells what lies beyond it.
            let is_inner = (pixel / f64::from(SIDE) - 0.5).abs().max_element() < 0.49;
            if is_inner && blocked == 0 && [0.0, further, -further].into_iter().all(is_clear) {
                mark(&mut truth.must, pixel, 0.0);
            }
            if blocked < around.len() {
                mark(&mut truth.may, pixel, HALF + 1.25);
            }
        }
    }
    truth
}

/// Marks the pixel of a point, or those whose middles are this near.
fn mark(pixels: &mut [bool], point: DVec2, near: f64) {
    let reach = near.ceil() as i32;
    let (x, y) = (point.x.floor() as i32, point.y.floor() as i32);
    for [dx, dy] in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [dx, dy])) {
        let (x, y) = (x + dx, y + dy);
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let is_in = (0..SIDE as i32).contains(&x) && (0..SIDE as i32).contains(&y);
        if is_in && (reach == 0 || middle.distance(point) <= near) {
            pixels[(y * SIDE as i32 + x) as usize] = true;
        }
    }
}

/// Compares a picture, the ink of each pixel, with what it has to be. Tells the first pixel of each kind.
fn check(what: &str, ink: &[u8], truth: &Truth) -> Result<(), String> {
    let point = |at: usize| [at as u32 % SIDE, at as u32 / SIDE];
    let missing: Vec<_> = (0..ink.len()).filter(|&at| truth.must[at] && ink[at] < 200).map(point).collect();
    let wrong: Vec<_> = (0..ink.len()).filter(|&at| !truth.may[at] && ink[at] > 0).map(point).collect();
    if missing.is_empty() && wrong.is_empty() {
        return Ok(());
    }
    let [first_missing, first_wrong] = [missing.first(), wrong.first()];
    let counts = format!("{} pixels missing {first_missing:?}, {} wrong {first_wrong:?}", missing.len(), wrong.len());
    Err(format!("{what}: {counts}"))
}

fn cases() -> Vec<Case> {
    let mut two = shapes::torus(40, 24, 0.9, 0.3);
    let ball = shapes::blob(6, 0.2, 5);
    let first = two.positions.len() as u32;
    two.positions.extend(ball.positions.iter().map(|p| [0.45 * p[0] + 0.3, 0.45 * p[1] + 0.2, 0.45 * p[2] + 0.5]));
    two.faces.extend(ball.faces.iter().map(|face| face.map(|v| first + v)));
    let half = |Shape { positions, faces }: Shape| Shape {
        positions: positions.into_iter().map(|p| p.map(|c| 0.7 * c)).collect(),
        faces,
    };
    let mut cases: Vec<Case> = topologies().into_iter().filter(|(name, ..)| name != "soup").collect();
    cases.extend([case("cube", half(shapes::cube())), case("torus and ball", two)]);
    cases
}

fn seen() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(94);
    let [mut musts, mut hidden, mut pictures, mut noticed] = [0; 4];
    for (number, case) in cases().iter().enumerate() {
        for projection in 0..6 {
            let view = View::new(&mut random, projection);
            let attachments = Attachments::ALL[(number + projection) % Attachments::ALL.len()];
            let classes = CLASSES[random.below(CLASSES.len())];
            let style = style(classes, attachments);
            let marks = marks(&case.2);
            let capacity = [None, Some(5)][random.below(2)];
            let inputs = Inputs {
                case,
                camera: &view.camera,
                light: view.light,
                style,
                marks: Some(&marks),
                capacity,
                attachments,
            };
            let what = format!("{}, projection {projection}, {attachments:?}, {classes:?}, list {capacity:?}", case.0);
            let picture = render(gpu, &inputs)?;
            let truth = truth(case, &view, classes, |_| true);
            check(&what, &picture, &truth)?;
            pictures += 1;
            musts += truth.must.iter().filter(|&&must| must).count();
            hidden += truth.may.iter().filter(|&&may| !may).count();
            let shifted: Vec<u8> = [&[0; 3], &picture[..picture.len() - 3]].concat();
            noticed += usize::from(check(&what, &shifted, &truth).is_err());
        }
    }
    println!("{musts} pixels of lines, {hidden} without; shifted ones are noticed in {noticed} of {pictures} pictures");
    // Before some near eyes there are no lines.
    if musts > 20_000 && 10 * noticed > 9 * pictures { Ok(()) } else { Err("too little is compared".to_owned()) }
}
