//! Scenes with as many triangles as A to D of the paper, section 9: objects above a ground plane, and the same below it. The
//! paper has pictures of them, so these are ours: a smooth body, many bars, a tangle of fine rings, a larger smooth body.

use glam::{Mat3, Quat, Vec3};
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};

/// The paper's numbers of triangles, and its mean numbers of volume triangles with maps of 256² and 512² texels. The
/// number of A at 256² is not legible in our copy.
pub(crate) const PAPER: [(&str, usize, &str); 4] =
    [("A", 3_756, "—"), ("B", 3_132, "1.89"), ("C", 450_132, "1.80"), ("D", 7_332, "1.67")];

/// Half the side of the ground, and the radius of a ball around everything.
const GROUND: f32 = 1.6;
pub(crate) const RADIUS: f32 = 2.3;

fn push(scene: &mut Shape, shape: &Shape, place: impl Fn(Vec3) -> Vec3) {
    let first = scene.positions.len() as u32;
    scene.positions.extend(shape.positions.iter().map(|&position| place(Vec3::from(position)).to_array()));
    scene.faces.extend(shape.faces.iter().map(|face| face.map(|vertex| first + vertex)));
}

fn above(number: usize, random: &mut Random) -> Shape {
    let mut scene = Shape::default();
    let turned = |random: &mut Random| {
        let [axis, other] = [random.direction(), random.direction()].map(Vec3::from);
        Mat3::from_quat(Quat::from_rotation_arc(axis, other))
    };
    match number {
        0 => push(&mut scene, &shapes::torus(36, 26, 0.8, 0.35), |p| p + Vec3::new(0.0, 0.7, 0.0)),
        1 => {
            for _ in 0..130 {
                let turn = turned(random);
                let half = Vec3::new(random.between(0.15, 0.45), 0.025, 0.025);
                let at = Vec3::new(random.between(-1.0, 1.0), random.between(0.5, 1.5), random.between(-1.0, 1.0));
                push(&mut scene, &shapes::cube(), |p| at + turn * (p * half));
            }
        }
        2 => {
            for _ in 0..10 {
                let turn = turned(random);
                let at = Vec3::new(random.between(-0.7, 0.7), random.between(0.7, 1.2), random.between(-0.7, 0.7));
                push(&mut scene, &shapes::torus(121, 93, 0.5, 0.06), |p| at + turn * p);
            }
        }
        _ => push(&mut scene, &shapes::torus(61, 30, 0.6, 0.5), |p| p + Vec3::new(0.0, 0.8, 0.0)),
    }
    scene
}

/// A scene by its number. The ground is a thin box.
pub(crate) fn scene(number: usize, seed: u64) -> Shape {
    let above = above(number, &mut Random::new(seed));
    let mut scene = above.clone();
    push(&mut scene, &above, |p| p * Vec3::new(1.0, -1.0, 1.0));
    push(&mut scene, &shapes::cube(), |p| p * Vec3::new(GROUND, 0.01, GROUND));
    scene
}
