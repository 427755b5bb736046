//! Example `soft`: its penumbra is as smooth as a light's whole area makes it.

#[path = "../../examples/soft/main.rs"]
#[allow(dead_code, reason = "the example's own main is not run here")]
mod soft;

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
use rimline::AreaLight;
use rimline_testkit::shapes;

const SIZE: [usize; 2] = [960, 720];
/// Pixels of a block, each way.
const BLOCK: usize = 8;

/// The whole light: a grid over the disc that has nothing to do with the samples.
fn lamp_points() -> Vec<DVec3> {
    let AreaLight { light, shape, normal } = soft::LAMP;
    let rimline::AreaShape::Disc { radius } = shape else { panic!("the lamp is a disc") };
    let middle = DVec3::from(light.xyz.map(f64::from));
    let normal = DVec3::from(normal.map(f64::from)).normalize();
    let (right, up) = normal.any_orthonormal_pair();
    let steps = 26;
    let at = |n: i32| (2.0 * f64::from(n) + 1.0) / f64::from(steps) - 1.0;
    let grid = (0..steps).flat_map(|y| (0..steps).map(move |x| DVec2::new(at(x), at(y))));
    // Turned, so that its rows are no direction of the picture.
    let turned = grid.filter(|p| p.length() < 1.0).map(|p| DVec2::from_angle(0.37).rotate(p) * f64::from(radius));
    turned.map(|p| middle + p.x * right + p.y * up).collect()
}

/// Which pixels' centres a triangle covers; its corners in pixels. Nothing of it is behind the eye here. Of a closed shape those
/// that turn one way cover all that the others do, so these are left out.
fn cover(corners: [DVec2; 3], mut mark: impl FnMut(usize)) {
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let range = |low: f64, high: f64, size: usize| {
        let clamp = |at: f64| at.clamp(0.0, size as f64) as usize;
        clamp((low - 0.5).ceil())..clamp((high - 0.5).floor() + 1.0)
    };
    if (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]) < 0.0 {
        return;
    }
    for y in range(low.y, high.y, SIZE[1]) {
        for x in range(low.x, high.x, SIZE[0]) {
            let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let inside = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a) >= 0.0;
            let [a, b, c] = corners;
            if inside(a, b) && inside(b, c) && inside(c, a) {
                mark(y * SIZE[0] + x);
            }
        }
    }
}

/// Eye and the matrix from positions less the eye to clip space.
fn view() -> (DVec3, DMat4) {
    let camera = soft::camera();
    (DVec3::from(camera.eye.map(f64::from)), Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4())
}

fn to_pixels(point: DVec3) -> DVec2 {
    let (eye, matrix) = view();
    let DVec4 { x, y, w, .. } = matrix * (point - eye).extend(1.0);
    DVec2::new(0.5 + 0.5 * x / w, 0.5 - 0.5 * y / w) * DVec2::new(SIZE[0] as f64, SIZE[1] as f64)
}

/// The floor at each pixel's centre; none above the horizon.
fn floor() -> Vec<Option<DVec3>> {
    let (eye, matrix) = view();
    let [right, up, ahead] = [0, 1, 3].map(|row| matrix.row(row).truncate());
    let pixels = (0..SIZE[0] * SIZE[1]).map(|n| [n % SIZE[0], n / SIZE[0]]);
    let at = |[x, y]: [usize; 2]| {
        let ndc =
            DVec2::new(2.0 * (x as f64 + 0.5) / SIZE[0] as f64 - 1.0, 1.0 - 2.0 * (y as f64 + 0.5) / SIZE[1] as f64);
        let ray = right * (ndc.x / right.length_squared()) + up * (ndc.y / up.length_squared()) + ahead;
        (ray.y < -1e-3).then(|| eye - ray * (eye.y / ray.y))
    };
    pixels.map(at).collect()
}

struct Expected {
    /// Expected colours, 0 to 255, where the floor is seen.
    pixels: Vec<[f64; 3]>,
    is_floor: Vec<bool>,
    /// Some of the light comes and some does not.
    is_penumbra: Vec<bool>,
}

/// The floor under the whole light: each of its points' shadows, drawn exactly.
fn expected() -> Expected {
    let shape = shapes::blob(96, 0.6, 7);
    let positions: Vec<DVec3> = soft::placed(&shape).into_iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    let floor = floor();
    let mut is_floor: Vec<bool> = floor.iter().map(Option::is_some).collect();
    let outline: Vec<DVec2> = positions.iter().map(|&p| to_pixels(p)).collect();
    for face in &shape.faces {
        cover(face.map(|v| outline[v as usize]), |pixel| is_floor[pixel] = false);
    }
    let lamps = lamp_points();
    // The light at each pixel, and how many of its points come there.
    let mut arrived = vec![(0.0, 0_u32); floor.len()];
    for &lamp in &lamps {
        let onto = |p: DVec3| lamp + (p - lamp) * (lamp.y / (lamp.y - p.y));
        let shadow: Vec<DVec2> = positions.iter().map(|&p| to_pixels(onto(p))).collect();
        let mut is_dark = vec![false; floor.len()];
        for face in &shape.faces {
            cover(face.map(|v| shadow[v as usize]), |pixel| is_dark[pixel] = true);
        }
        for (pixel, point) in floor.iter().enumerate().filter(|(pixel, _)| !is_dark[*pixel]) {
            let (light, count) = &mut arrived[pixel];
            *light += point.map_or(0.0, |point| (lamp - point).normalize().y) / lamps.len() as f64;
            *count += 1;
        }
    }
    let shade = |&(light, _): &(f64, u32)| {
        let albedo = [0.80, 0.79, 0.77];
        let (color, around) = ([0.95, 0.90, 0.82], [0.88, 0.95, 1.06]);
        std::array::from_fn(|c| {
            255.0 * (albedo[c] * (0.22 * around[c] + color[c] * light)).min(1.0_f64).powf(1.0 / 2.2)
        })
    };
    let is_penumbra = arrived.iter().map(|&(_, count)| count > 0 && (count as usize) < lamps.len()).collect();
    Expected { pixels: arrived.iter().map(shade).collect(), is_floor, is_penumbra }
}

/// The largest difference between steps of neighbouring blocks' means and the steps that they should have, in the penumbra
/// on the floor; how many pairs there are; and the largest step that there should be.
fn worst_step(picture: &[u8], expected: &Expected) -> (f64, usize, f64) {
    let [columns, rows] = SIZE.map(|pixels| pixels / BLOCK);
    let pixels = |column: usize, row: usize| {
        (0..BLOCK * BLOCK).map(move |n| (row * BLOCK + n / BLOCK) * SIZE[0] + column * BLOCK + n % BLOCK)
    };
    let mean = |at: &dyn Fn(usize) -> f64, column, row| pixels(column, row).map(at).sum::<f64>() / 64.0;
    let is_floor = |column, row| pixels(column, row).all(|pixel| expected.is_floor[pixel]);
    let is_soft = |column, row| pixels(column, row).all(|pixel| expected.is_penumbra[pixel]);
    let (mut worst, mut pairs, mut steepest) = (0.0_f64, 0, 0.0_f64);
    for row in 1..rows - 1 {
        for column in 1..columns - 1 {
            // A block's breadth from the body.
            if !(column - 1..=column + 1).all(|x| (row - 1..=row + 1).all(|y| is_floor(x, y))) {
                continue;
            }
            for (x, y) in [(column + 1, row), (column, row + 1)] {
                if !is_soft(column, row) || !is_soft(x, y) {
                    continue;
                }
                pairs += 1;
                for channel in 0..3 {
                    let drawn = |pixel: usize| f64::from(picture[4 * pixel + channel]);
                    let wanted = |pixel: usize| expected.pixels[pixel][channel];
                    let step = mean(&drawn, x, y) - mean(&drawn, column, row);
                    let right = mean(&wanted, x, y) - mean(&wanted, column, row);
                    worst = worst.max((step - right).abs());
                    steepest = steepest.max(right.abs());
                }
            }
        }
    }
    (worst, pairs, steepest)
}

#[test]
fn the_penumbra_steps_no_more_than_the_whole_light_makes_it() {
    let canvas = soft::support::Canvas::of_size(SIZE.map(|pixels| pixels as u32)).expect("there is a GPU");
    let draw = |parts| canvas.pixels(soft::picture(&canvas, parts).expect("it is drawn")).expect("it is read");
    let expected = expected();
    let (worst, pairs, steepest) = worst_step(&draw(soft::stage::PARTS), &expected);
    println!("{pairs} pairs: steps up to {worst} of 255 off; the whole light's own are up to {steepest}");
    assert!(pairs > 300, "only {pairs} pairs of blocks in the penumbra");
    assert!(
        worst <= 2.0,
        "means of neighbouring blocks step by {worst} of 255 too much or too little, of {pairs} pairs"
    );
    // 32 samples alone are seen as steps.
    let (worst, ..) = worst_step(&draw(1), &expected);
    assert!(worst > 4.0, "the same 32 samples everywhere step by {worst} only");
}
