//! Outlines of bodies that touch: the drawn lines are those that are visible, and without gaps, by rays in `f64`.

use glam::{DMat3, DVec3};
use libtest_mimic::{Failed, Trial};
use rimline_testkit::shapes;

use super::makers::{npz_mesh, npz_model};
use super::models_of_code::{SIDES, corner};
use super::pictures::{Image, is_ink};
use super::run::{folder, is_long};
use super::verify::has_opengl;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("outlines::touching_boxes_have_whole_outlines", || check("gpu")),
    ("outlines::a_smooth_body_has_no_gap_at_its_border", smooth),
    ("outlines::an_edge_that_ends_far_away_has_a_whole_line", long),
];

/// The same on OpenGL, ignored by name where there is none.
pub(crate) fn trials() -> Vec<Trial> {
    let name = "outlines::touching_boxes_have_whole_outlines_on_opengl";
    vec![Trial::test(name, || check("opengl").map_err(Failed::from)).with_ignored_flag(!has_opengl())]
}

const SIZE: [f64; 2] = [1000.0, 840.0];
const EYE: [f64; 3] = [4.5, 3.75, 6.0];
const TARGET: [f64; 3] = [0.0, 0.75, 0.0];
const FOV: f64 = 34.0;
/// Shares of the distance from the eye. A face hides a point if it lies more than `HIDES` in front. It does not hide the
/// point if it lies less than `HOLDS` in front. In between both answers are right.
const HOLDS: f64 = 5e-7;
const HIDES: f64 = 2e-5;

/// Low and high corners: a slab; two boxes on it, side by side; one across both; a thin plate on the slab's front and one
/// that floats before its side by hardly anything.
const BOXES: [[[f64; 3]; 2]; 6] = [
    [[-2.0, 0.0, -1.5], [2.0, 0.5, 1.5]],
    [[-1.3, 0.5, -0.8], [-0.2, 1.6, 0.5]],
    [[-0.2, 0.5, -0.5], [0.9, 1.6, 0.7]],
    [[-0.7, 1.6, -0.3], [0.4, 1.9, 0.3]],
    [[-0.8, 0.1, 1.5], [0.9, 0.4, 1.53]],
    [[2.0003, 0.15, -0.6], [2.02, 0.4, 0.8]],
];

/// The boxes, turned so that no plane is an axis's, as the command reads them: corners rounded to `f32`.
fn boxes() -> Vec<[DVec3; 8]> {
    let turn = DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(0.07);
    let placed = |bounds, n: usize| (turn * DVec3::from(corner(bounds, n))).as_vec3().as_dvec3();
    BOXES.iter().map(|bounds| std::array::from_fn(|n| placed(bounds, n))).collect()
}

fn triangles(boxes: &[[DVec3; 8]]) -> Vec<[DVec3; 3]> {
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    boxes.iter().flat_map(|at| SIDES.into_iter().flat_map(halves).map(|face| face.map(|v| at[v]))).collect()
}

fn model_of(faces: &[[DVec3; 3]]) -> Vec<u8> {
    let positions: Vec<[f32; 3]> = faces.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
    npz_mesh(&positions, &(0..faces.len() as u32).map(|face| [0, 1, 2].map(|n| 3 * face + n)).collect::<Vec<_>>())
}

fn draw(model: &[u8], options: &str) -> Result<Image, String> {
    let folder = folder();
    folder.write("m.npz", model)?;
    folder.run(&format!("draw @m.npz --out @p.png {options}")).expect(0, &[])?;
    folder.image("p.png")
}

/// The edges between a side that faces the eye and one that does not.
fn silhouette(boxes: &[[DVec3; 8]]) -> Vec<[DVec3; 2]> {
    let eye = DVec3::from(EYE);
    let mut edges = Vec::new();
    for at in boxes {
        let faces_eye = SIDES.map(|[a, b, c, _]| (at[b] - at[a]).cross(at[c] - at[a]).dot(eye - at[a]) > 0.0);
        for (one, side) in SIDES.iter().enumerate() {
            for step in 0..4 {
                let [a, b] = [side[step], side[(step + 1) % 4]];
                let other = (0..6).find(|&n| (0..4).any(|k| [SIDES[n][k], SIDES[n][(k + 1) % 4]] == [b, a]));
                if other.is_some_and(|other| faces_eye[one] && !faces_eye[other]) {
                    edges.push([at[a], at[b]]);
                }
            }
        }
    }
    edges
}

/// Where a point is in the picture.
fn project(point: DVec3) -> [f64; 2] {
    let (eye, forward) = (DVec3::from(EYE), (DVec3::from(TARGET) - DVec3::from(EYE)).normalize());
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let focal = 0.5 * SIZE[1] / (0.5 * FOV.to_radians()).tan();
    let from_eye = point - eye;
    let depth = from_eye.dot(forward);
    [0.5 * SIZE[0] + focal * from_eye.dot(right) / depth, 0.5 * SIZE[1] - focal * from_eye.dot(up) / depth]
}

/// How far in front of the point the faces over it lie, at most; as a share of its distance.
fn cover(point: DVec3, faces: &[[DVec3; 3]]) -> f64 {
    let eye = DVec3::from(EYE);
    let ray = point - eye;
    let gaps = faces.iter().filter_map(|&[a, b, c]| {
        let normal = (b - a).cross(c - a).normalize();
        let turn = normal.dot(a - eye).signum();
        let is_over = [[a, b], [b, c], [c, a]]
            .into_iter()
            .all(|[from, to]| turn * (from - eye).cross(to - from).normalize().dot(point - from) > -1e-9);
        is_over.then(|| turn * normal.dot(point - a) / ray.length())
    });
    gaps.fold(0.0, f64::max)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Visible,
    Hidden,
    Undecided,
}

/// Points along the edges, four a pixel, where they are in the picture and whether they are seen there. Within three pixels
/// of a change that is left open, as is the last pixel at the ends.
fn expected() -> Vec<([f64; 2], Seen)> {
    let boxes = boxes();
    let faces = triangles(&boxes);
    let mut points = Vec::new();
    for [a, b] in silhouette(&boxes) {
        let ([ax, ay], [bx, by]) = (project(a), project(b));
        let count = (4.0 * (bx - ax).hypot(by - ay)).ceil() as usize;
        let samples: Vec<DVec3> = (0..=count).map(|n| a.lerp(b, n as f64 / count as f64)).collect();
        let seen: Vec<Seen> = samples
            .iter()
            .map(|&sample| match cover(sample, &faces) {
                gap if gap <= HOLDS => Seen::Visible,
                gap if gap >= HIDES => Seen::Hidden,
                _ => Seen::Undecided,
            })
            .collect();
        for n in 4..samples.len().saturating_sub(4) {
            let around = &seen[n.saturating_sub(12)..(n + 13).min(seen.len())];
            let is_alike = around.iter().all(|&other| other == seen[n]);
            points.push((project(samples[n]), if is_alike { seen[n] } else { Seen::Undecided }));
        }
    }
    points
}

/// Every visible point is in ink, and no hidden one that is far from all that may be drawn.
fn compare(picture: &Image, points: &[([f64; 2], Seen)]) -> Outcome {
    let pixel = |[x, y]: [f64; 2]| y as usize * picture.size[0] + x as usize;
    let is_inked = |&at: &[f64; 2]| is_ink(picture.pixels()[pixel(at)]);
    let of = |wanted| points.iter().filter(move |(_, seen)| *seen == wanted).map(|&(at, _)| at);
    let gaps: Vec<_> = of(Seen::Visible).filter(|at| !is_inked(at)).collect();
    ensure!(gaps.is_empty(), "{} visible points are blank: {:?}", gaps.len(), &gaps[..gaps.len().min(9)]);
    let mut is_near = vec![false; picture.pixels().len()];
    for &([x, y], _) in points.iter().filter(|(_, seen)| *seen != Seen::Hidden) {
        for (dx, dy) in (-4..=4).flat_map(|dy| (-4..=4).map(move |dx| (dx, dy))) {
            is_near[pixel([x + f64::from(dx), y + f64::from(dy)])] = true;
        }
    }
    let hidden: Vec<_> = of(Seen::Hidden).filter(|&at| !is_near[pixel(at)]).collect();
    ensure!(hidden.len() > 300, "only {} hidden points count", hidden.len());
    let drawn: Vec<_> = hidden.iter().filter(|at| is_inked(at)).collect();
    ensure!(drawn.is_empty(), "{} hidden points are drawn: {:?}", drawn.len(), &drawn[..drawn.len().min(9)]);
    Ok(())
}

/// The options of the picture that [`project`] is of.
fn view() -> String {
    let list = |numbers: [f64; 3]| numbers.map(|c| c.to_string()).join(",");
    let [width, height] = SIZE;
    format!("--size {width}x{height} --eye {} --target {} --fov {FOV}", list(EYE), list(TARGET))
}

fn check(device: &str) -> Outcome {
    let points = expected();
    let count = |wanted| points.iter().filter(|(_, seen)| *seen == wanted).count();
    ensure!(count(Seen::Visible) > 8000, "only {} visible points", count(Seen::Visible));
    ensure!(count(Seen::Undecided) < points.len() / 20, "{} points are left open", count(Seen::Undecided));
    let picture = draw(&model_of(&triangles(&boxes())), &format!("{} --device {device}", view()))?;
    compare(&picture, &points)?;
    // The comparison notices wrong lines.
    let moved: Vec<_> = points.iter().map(|&([x, y], seen)| ([x + 4.0, y], seen)).collect();
    ensure!(compare(&picture, &moved).is_err(), "lines four pixels aside pass");
    let all: Vec<_> = points.iter().map(|&(at, _)| (at, Seen::Visible)).collect();
    ensure!(compare(&picture, &all).is_err(), "hidden lines pass as visible");
    let mut dotted = picture;
    for ([x, y], _) in points.iter().filter(|(_, seen)| *seen == Seen::Visible).step_by(1000) {
        let at = *y as usize * dotted.size[0] + *x as usize;
        dotted.pixels_mut()[at] = [200; 3];
    }
    ensure!(compare(&dotted, &points).is_err(), "a line with holes passes");
    Ok(())
}

/// Two faces with an edge from close to the eye to far away, which runs from its far end to its near one. Measured from the far
/// end, rounding moves every third point near the other behind its own face.
fn long() -> Outcome {
    let corners: [[f32; 3]; 4] = [[0.5, 1.5, 0.7], [-32.0, -921.0, -1181.0], [1.8, 2.4, 0.6], [1.5, 2.2, -0.1]];
    let [near, far] = [0, 1].map(|end: usize| DVec3::from(corners[end].map(f64::from)));
    let picture = draw(&npz_mesh(&corners, &[[1, 0, 3], [0, 1, 2]]), &format!("{} --device gpu", view()))?;
    let is_blank = |metres: &f64| {
        let [x, y] = project(near + *metres * (far - near).normalize());
        !is_ink(picture.pixels()[y as usize * picture.size[0] + x as usize])
    };
    let blank: Vec<f64> = (2..180).map(|step| 0.05 * f64::from(step)).filter(is_blank).collect();
    ensure!(blank.is_empty(), "the line has gaps at {blank:?}");
    Ok(())
}

/// Pixels where the body meets the background without a line between: the body is blue, the background is not.
fn gaps(picture: &Image) -> Vec<[usize; 2]> {
    let [width, height] = picture.size;
    let (is_body, is_background) =
        (|[red, _, blue]: [u8; 3]| blue > red.saturating_add(8), |[red, _, blue]: [u8; 3]| red >= blue && red > 150);
    let pixels = (0..height - 1).flat_map(|y| (0..width - 1).map(move |x| [x, y]));
    let meets = |[x, y]: &[usize; 2]| {
        let here = picture.pixels()[y * width + x];
        [picture.pixels()[y * width + x + 1], picture.pixels()[(y + 1) * width + x]]
            .into_iter()
            .any(|next| (is_body(here) && is_background(next)) || (is_body(next) && is_background(here)))
    };
    pixels.filter(meets).collect()
}

/// At the border of a smooth body many faces are seen edge-on, thinner than rounding tells: they hide nothing.
fn smooth() -> Outcome {
    let model = npz_model(&shapes::blob(96, 0.6, 7), 1.0, [0.0; 3]);
    let eyes = ["3.2,2.4,5.2", "-4,1.5,4", "1,5,-3.5"];
    for eye in &eyes[..if is_long() { 3 } else { 1 }] {
        let mut picture = draw(&model, &format!("--size 600x750 --eye {eye} --target 0,0,0 --fov 36 --device gpu"))?;
        let found = gaps(&picture);
        ensure!(found.is_empty(), "eye {eye}: {} gaps: {:?}", found.len(), &found[..found.len().min(9)]);
        // Rub out a piece of the topmost line.
        let width = picture.size[0];
        let first = picture.pixels().iter().position(|&pixel| is_ink(pixel)).ok_or("no line")?;
        for y in 0..7 {
            picture.pixels_mut()[first + y * width..][..3].fill([240; 3]);
        }
        ensure!(!gaps(&picture).is_empty(), "eye {eye}: a gap passes");
    }
    Ok(())
}
