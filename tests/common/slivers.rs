//! Closed surfaces of plain triangles that leave the picture, without any stage of Rimline: whether this driver covers each
//! pixel by as many fronts as backs. Where it does not, the tests prove why, and what helps.

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::slivers::{End, SIZE, Triangle, tube, unbalanced, wrong_pixels};

pub(crate) const TESTS: &[Test] = &[
    ("slivers_that_need_no_clipping_are_watertight", unclipped),
    ("slivers_that_leave_the_picture_are_watertight_or_the_driver_is_told", leaving),
    ("slivers_with_a_hole_are_noticed", control),
];

const SEEDS: std::ops::Range<u64> = 1..5;

/// Wrong pixels of the tubes of all seeds.
fn count(gpu: &Gpu, end: End, change: impl Fn(Vec<Triangle>) -> Vec<Triangle>) -> Result<usize, String> {
    SEEDS.map(|seed| unbalanced(&gpu.device, &gpu.queue, &change(tube(end, seed)))).sum()
}

fn none(what: &str, wrong: usize) -> Result<(), String> {
    if wrong == 0 { Ok(()) } else { Err(format!("{what}: {wrong} pixels are counted wrongly")) }
}

const LEAVING: [End; 4] = [End::Times(4.0), End::OUTSIDE, End::Times(1000.0), End::Infinity];

/// Lavapipe has to be right. Another driver may have the fault; then the small trial has to find it.
fn leaving() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let found = wrong_pixels(&gpu.device, &gpu.queue)?;
    let mut all = 0;
    for end in LEAVING {
        let wrong = count(&gpu, end, |triangles| triangles)?;
        println!("{}: {end:?}: {wrong} of {} pixels", gpu.name, SEEDS.count() * (SIZE * SIZE) as usize);
        all += wrong;
    }
    if gpu.name.contains("llvmpipe") {
        return none("leaving the picture", all + found);
    }
    let is_found = (all > 0) == (found > 0);
    if is_found { Ok(()) } else { Err(format!("{all} pixels are wrong, and the small trial finds {found}")) }
}

/// A part of a triangle within the picture, as a fan. Each edge is cut from its inner to its outer end, at the sides of the
/// picture in turn. So both triangles of an edge get the same vertices, bit for bit.
fn cut(triangle: Triangle) -> Vec<Triangle> {
    let mut polygon = triangle.to_vec();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let height = |v: [f32; 4]| v[3] + sign * v[axis];
        let mut next = Vec::new();
        for (corner, &from) in polygon.iter().enumerate() {
            let to = polygon[(corner + 1) % polygon.len()];
            let is_in = height(from) >= 0.0;
            if is_in {
                next.push(from);
            }
            if is_in != (height(to) >= 0.0) {
                let (inner, outer) = if is_in { (from, to) } else { (to, from) };
                let part = height(inner) / (height(inner) - height(outer));
                let mut meeting: [f32; 4] = std::array::from_fn(|i| inner[i] + (outer[i] - inner[i]) * part);
                meeting[axis] = -sign * meeting[3];
                next.push(meeting);
            }
        }
        polygon = next;
    }
    (2..polygon.len()).map(|corner| [polygon[0], polygon[corner - 1], polygon[corner]]).collect()
}

/// Within the picture, or cut by us: so what is wrong of others is the driver's clipping.
fn unclipped() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    none("within the picture", count(&gpu, End::INSIDE, |triangles| triangles)?)?;
    for end in LEAVING {
        let wrong = count(&gpu, end, |triangles| triangles.into_iter().flat_map(cut).collect())?;
        none(&format!("{end:?}, cut"), wrong)?;
    }
    Ok(())
}

/// Negative control: of a tube one sliver is left out.
fn control() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    for end in [End::INSIDE, End::OUTSIDE] {
        let whole = tube(end, 1);
        // The longest of both slivers of a corner crosses many pixels.
        let found = (0..40).any(|number| {
            let mut holed = whole.clone();
            holed.remove(1 + 4 * number);
            unbalanced(&gpu.device, &gpu.queue, &holed).is_ok_and(|wrong| wrong > 0)
        });
        if !found {
            return Err(format!("negative control: holes in a tube to {end:?} went unnoticed"));
        }
    }
    Ok(())
}
