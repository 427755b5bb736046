//! How wide lines are.

use rimline::gpu::OutlineStyle;
use rimline::{Light, ShadowCamera};
use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::must_fail;
use rimline_testkit::shapes::Shape;

use crate::rendered::{Attachments, Inputs, SIDE, render};

pub(crate) const TESTS: &[Test] = &[
    ("lines_are_as_wide_as_they_are_asked_for", widths),
    ("lines_of_short_edges_are_hardly_darker_than_those_of_one", joins),
];

/// The ink of a row, in pixels, against two lines of a width.
fn check(row: &[u8], width: f32, alpha: f32) -> Result<(), String> {
    let ink = row.iter().map(|&ink| f32::from(ink) / 255.0).sum::<f32>();
    // Each pixel is rounded to 1/255, and coverage is that of the pixel's middle.
    let expected = 2.0 * width * alpha;
    if (ink - expected).abs() <= 0.05 * expected + 0.02 {
        Ok(())
    } else {
        Err(format!("{ink} pixels, expected {expected}"))
    }
}

/// A parallel camera from above.
const CAMERA: ShadowCamera = ShadowCamera {
    view_projection: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0], [0.0, 0.0, 0.5, 1.0]],
    origin: [0.0; 3],
    depth: rimline::DepthDirection::Reversed,
};

/// Round ends overlap where edges meet: the ink of a band whose two sides have edges of some pixels, against one edge each.
fn joins() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for attachments in Attachments::ALL {
        // By how much the ink may be more. It would be 1.063 and 1.034 if ends had the ink of lines.
        for (width, most) in [(1.0, 1.045), (3.0, 1.026)] {
            let ink = |edges: u16| {
                let at = |n: u16, x: f32| {
                    let y = 3.0 * (f32::from(2 * n) / f32::from(edges) - 1.0);
                    [x + 0.3 * y, y, 0.0]
                };
                let faces = (0..u32::from(edges)).map(|n| 2 * n).flat_map(|a| [[a, a + 1, a + 3], [a, a + 3, a + 2]]);
                let band = Shape {
                    positions: (0..=edges).flat_map(|n| [at(n, -0.5), at(n, 0.4)]).collect(),
                    faces: faces.collect(),
                };
                let (case, light) = (case("band", band), Light::directional([0.0, 0.0, 1.0]));
                let (marks, capacity, camera) = (None, None, &CAMERA);
                let style = OutlineStyle { width, depth_bias: attachments.bias, ..OutlineStyle::default() };
                let picture = render(gpu, &Inputs { case: &case, camera, light, style, marks, capacity, attachments })?;
                Ok::<_, String>(picture.iter().map(|&ink| f64::from(ink)).sum::<f64>() / 255.0)
            };
            let [one, many] = [ink(1)?, ink(150)?];
            println!("{attachments:?}, width {width}: {one:.0} and {many:.0} pixels of ink, {:.3}", many / one);
            if one < 256.0 || !(1.0..=most).contains(&(many / one)) {
                return Err(format!("{attachments:?}, width {width}: {one} and {many} pixels of ink"));
            }
        }
    }
    Ok(())
}

fn widths() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let camera = CAMERA;
    // Rectangles from above, so high that their sides run through all rows, slightly slanted.
    for (attachments, height) in Attachments::ALL.into_iter().zip([3.0, 30_000.0, 30.0, 300_000.0]) {
        let corner = |x: f32, y: f32| [x + y / 60.0, y, 0.0];
        let rectangle = Shape {
            positions: vec![corner(-0.5, -height), corner(0.4, -height), corner(0.4, height), corner(-0.5, height)],
            faces: vec![[0, 1, 2], [0, 2, 3]],
        };
        let case = case("rectangle", rectangle);
        for (width, alpha) in [(0.5, 1.0), (1.0, 1.0), (2.0, 1.0), (7.5, 1.0), (4.0, 0.5)] {
            let style = OutlineStyle { width, boundary: Some([0.0, 0.0, 0.0, alpha]), ..OutlineStyle::default() };
            let light = Light::directional([0.0, 0.0, 1.0]);
            let inputs =
                Inputs { case: &case, camera: &camera, light, style, marks: None, capacity: None, attachments };
            let picture = render(gpu, &inputs)?;
            let across = 60.0 / (1.0_f32 + 3600.0).sqrt();
            for row in picture.chunks(SIDE as usize) {
                check(row, width / across, alpha).map_err(|error| format!("{attachments:?}, {width}: {error}"))?;
            }
            must_fail("a line of another width", &check(&picture[..SIDE as usize], width * 1.2, alpha))?;
        }
    }
    Ok(())
}
