//! `--from-depth`: shadows rebuilt from maps that the lights see, against those of meshes.

use rimline_testkit::shapes;

use super::makers::npz_model;
use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("depth_shadows::volumes_are_shown_as_those_of_meshes", volumes)];

const VIEW: &str = "--ground 0 --eye 4,9,14 --target 0,1,0 --size 160x120";

/// A ball's boundary is that of its mesh's volume, but for what lies behind its surface.
fn volumes() -> Outcome {
    let folder = folder();
    folder.write("ball.npz", npz_model(&shapes::sphere(8), 1.0, [0.0, 2.0, 0.0]))?;
    for (light, detector) in [("point:6,12,3", "every"), ("dir:-1,2,0.5", "automatic"), ("point:1.2,3.2,0.3", "every")]
    {
        let draw = |name: &str, options: &str| {
            let line = format!("shadow @ball.npz {VIEW} --light {light} {options} --out @{name}.png");
            folder.run(&line).expect(0, &[])?;
            Ok::<_, String>(folder.image(format!("{name}.png"))?.bytes)
        };
        let from_depth = format!("--from-depth 256 --detector {detector}");
        // Sums over squares of 8 × 8 pixels, so that lines do not count one by one.
        let blurred = |bytes: &[u8]| {
            let square = |at: usize| {
                let (x, y) = (at % 20 * 8, at / 20 * 8);
                let rows = (y..y + 8).map(|y| &bytes[3 * (160 * y + x)..3 * (160 * y + x + 8)]);
                rows.flatten().map(|&byte| i64::from(byte)).sum::<i64>()
            };
            (0..300).map(square).collect::<Vec<_>>()
        };
        let apart =
            |one: &[u8], other: &[u8]| blurred(one).iter().zip(blurred(other)).map(|(a, b)| a.abs_diff(b)).sum::<u64>();
        let plain = draw("plain", &from_depth)?;
        let (map, mesh) = (draw("map", &format!("{from_depth} --volumes"))?, draw("mesh", "--volumes")?);
        let (shown, wrong) = (apart(&mesh, &plain), apart(&mesh, &map));
        ensure!(2 * wrong < shown, "{light}: {wrong} apart, and {shown} where nothing is shown");
    }
    Ok(())
}
