//! How wide lines are.

use rimline::gpu::OutlineStyle;
use rimline::{Light, ShadowCamera};
use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::must_fail;
use rimline_testkit::shapes::Shape;

use crate::rendered::{Attachments, Inputs, SIDE, render};

pub(crate) const TESTS: &[Test] = &[("lines_are_as_wide_as_they_are_asked_for", widths)];

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

fn widths() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let camera = ShadowCamera {
        view_projection: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0], [0.0, 0.0, 0.5, 1.0]],
        origin: [0.0; 3],
        depth: rimline::DepthDirection::Reversed,
    };
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
