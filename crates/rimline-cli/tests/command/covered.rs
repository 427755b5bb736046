//! `--hide-covered`: the shadows stay, and the volumes get fewer sides.

use rimline_testkit::shapes;

use super::run::{Folder, folder, write_file};
use super::shadow::model;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("covered::faces_under_a_roof_are_left_out", left_out),
    ("covered::options_that_do_not_go_with_it_end_with_2", wrong_options),
];

const VIEW: &str = "--ground 0 --eye 4,9,14 --target 0,1,0 --size 160x120 --light point:0,9,0 --light dir:-1,0.2,0";

fn with_roof() -> Result<Folder, String> {
    let folder = folder();
    for (name, shape, scale, at) in [
        ("roof", shapes::plane_grid(2, 2), 3.0, [0.0, 5.0, 0.0]),
        ("ball", shapes::sphere(4), 1.0, [0.0, 2.0, 0.0]),
        // Beside the roof, and not covered.
        ("ring", shapes::torus(12, 8, 2.0, 0.5), 1.0, [12.0, 1.0, 0.0]),
    ] {
        let file = folder.path().join(format!("{name}.npz"));
        write_file(file, model(&shape, scale, at))?;
    }
    Ok(folder)
}

fn left_out() -> Outcome {
    let folder = with_roof()?;
    let draw = |name: &str, options: &str| {
        let files = "@ball.npz @ring.npz @roof.npz";
        folder.run(&format!("shadow {files} {VIEW} {options} --mask @{name} --out @{name}.png --json")).json()
    };
    let (with, without) = (draw("with", "")?, draw("without", "--hide-covered")?);
    for light in ["0", "1"] {
        let mask = |name: &str| folder.mask(format!("{name}.{light}.png"));
        let (with, without) = (mask("with")?.bytes, mask("without")?.bytes);
        ensure!(with == without, "light {light}: the masks differ");
        ensure!([0, 255].iter().all(|value| with.contains(value)), "light {light}: all alike");
    }
    // Under the point all of the ball is covered, and its outline spared. From the side the ring covers a bit of itself, and
    // there is nothing to spare.
    let number = |light: usize, key: &str| without["lights"][light]["covered"][key].as_u64().unwrap_or(u64::MAX);
    let (sphere, ball) = (shapes::sphere(4).faces.len() as u64, &with["lights"][0]["casters"][0]);
    ensure!(number(0, "left_out") == sphere && number(0, "hidden") == sphere, "{without:#}");
    let outline = ball["silhouette_edges"].as_u64().unwrap_or(0);
    ensure!(outline > 8 && number(0, "sides_left") + outline == number(0, "sides"), "{without:#}");
    let beside = number(1, "left_out");
    ensure!(beside < sphere / 2 && number(1, "sides_left") == number(1, "sides"), "{without:#}");
    ensure!(without["totals"]["covered_faces"] == sphere + beside, "{without:#}");
    ensure!(with["lights"][0]["covered"].is_null() && with["totals"]["covered_faces"].is_null(), "{with:#}");
    // The volumes that are shown are those that are drawn.
    let files = ["with.png", "without.png"];
    let [plain, same] = files.map(|name| folder.image(name).map(|image| image.bytes));
    ensure!(plain? == same?, "the pictures differ");
    draw("with", "--volumes")?;
    draw("without", "--volumes --hide-covered")?;
    let [shown, fewer] = files.map(|name| folder.image(name).map(|image| image.bytes));
    ensure!(shown? != fewer?, "volumes of covered faces are shown");
    // Where nothing is covered, the same volumes are shown.
    for (name, options) in [("with", ""), ("without", "--hide-covered")] {
        let line = format!(
            "shadow @ring.npz @ball.npz --size 160x120 --light dir:0,1,0 --volumes --out @{name}.png {options}"
        );
        folder.run(&line).expect(0, &[])?;
    }
    let [shown, alike] = files.map(|name| folder.image(name).map(|image| image.bytes));
    ensure!(shown? == alike?, "other volumes are shown where nothing is covered");
    Ok(())
}

fn wrong_options() -> Outcome {
    let folder = with_roof()?;
    for (options, part) in [("--area disc", "--area"), ("--method zp+paper", "--method zp+paper")] {
        let line = format!("shadow @ball.npz --hide-covered {options} --out @p.png");
        folder.run(&line).expect(2, &["--hide-covered", part])?;
        ensure!(!folder.path().join("p.png").exists(), "{options}: a picture");
    }
    Ok(())
}
