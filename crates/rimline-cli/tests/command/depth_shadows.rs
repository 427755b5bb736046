//! `--from-depth`: shadows rebuilt from maps that the lights see, against those of meshes.

use rimline_testkit::shapes;

use super::run::{Folder, folder, write_file};
use super::shadow::{apart, model};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("depth_shadows::masks_are_those_of_meshes_but_for_borders", masks),
    ("depth_shadows::walls_over_contours_are_fewer_and_shown", contours),
    ("depth_shadows::lights_among_the_models_have_six_maps", cube),
    ("depth_shadows::each_detector_draws_every_mode", modes),
    ("depth_shadows::volumes_are_shown_as_those_of_meshes", volumes),
    ("depth_shadows::options_that_do_not_go_with_it_end_with_2", wrong_options),
];

const VIEW: &str = "--ground 0 --eye 4,9,14 --target 0,1,0 --size 160x120";

fn models() -> Result<Folder, String> {
    let folder = folder();
    for (name, shape, at) in
        [("ball", shapes::sphere(8), [0.0, 2.0, 0.0]), ("ring", shapes::torus(24, 12, 2.0, 0.5), [0.0, 2.0, 0.5])]
    {
        let file = folder.path().join(format!("{name}.npz"));
        write_file(file, model(&shape, 1.0, at))?;
    }
    Ok(folder)
}

/// Pixels of which two masks say different things, and of which the first says that they are dark or lit.
fn differences(folder: &Folder, names: [&str; 2]) -> Result<[usize; 3], String> {
    let [one, other] = names.map(|name| folder.mask(name));
    let (one, other) = (one?.bytes, other?.bytes);
    let count = |value: u8| one.iter().map(|&byte| usize::from(byte == value)).sum();
    Ok([apart([&one, &other], 1, 0)?, count(0), count(255)])
}

fn masks() -> Outcome {
    let folder = models()?;
    let lights = "--light point:6,12,3 --light dir:-1,2,0.5";
    let draw = |name: &str, options: &str| {
        folder.run(&format!("shadow @ball.npz @ring.npz {VIEW} {lights} {options} --mask @{name} --json")).json()
    };
    let mesh = draw("mesh", "")?;
    let found = draw("map", "--from-depth")?;
    let every = draw("every", "--from-depth --detector every")?;
    let walls = draw("walls", "--from-depth 512 --detector contours=0.002")?;
    draw("coarse", "--from-depth 8")?;
    for light in ["0", "1"] {
        let against = |name: &str| differences(&folder, [&format!("mesh.{light}.png"), &format!("{name}.{light}.png")]);
        let [different, dark, lit] = against("map")?;
        ensure!(dark > 1000 && lit > 1000 && different < 60, "light {light}: {different} of {dark} and {lit} differ");
        let [different, ..] = against("every")?;
        ensure!(different < 60, "light {light}: {different} differ with every cell");
        let [different, ..] = against("walls")?;
        ensure!(different < 60, "light {light}: {different} differ with walls");
        // Negative controls: a map of few texels, and the other light.
        let [coarse, ..] = against("coarse")?;
        ensure!(coarse > 300, "light {light}: {coarse} differ with a coarse map");
    }
    let [exchanged, ..] = differences(&folder, ["mesh.0.png", "map.1.png"])?;
    ensure!(exchanged > 1000, "{exchanged} differ with the lights exchanged");
    for light in 0..2 {
        let of_light = &found["lights"][light];
        let (map, caster) = (&of_light["depth_map"], &of_light["casters"][1]);
        ensure!(map["side"] == 1024 && map["maps"] == 1, "{found:#}");
        // By default no edge is found within a slope.
        let cells = [map, &every["lights"][light]["depth_map"]].map(|map| map["cells"].as_u64().unwrap_or(0));
        ensure!(cells[0] > 10_000 && cells[1] > 100_000 && 4 * cells[0] < 3 * cells[1], "{cells:?}");
        ensure!(caster["casting"] == "depth map" && caster["counting"] == "parity", "{found:#}");
        let walls = &walls["lights"][light]["depth_map"];
        ensure!(map["reconstruction"] == "triangles" && map["walls"].is_null(), "{map:#}");
        ensure!(walls["reconstruction"] == "contours" && walls["cells"].is_null(), "{walls:#}");
    }
    ensure!(found["count_bound"] == 1 && found["may_wrap"] == 0 && found["method"] == "parity", "{found:#}");
    // No stage of volumes of meshes runs.
    let ran = |found: &serde_json::Value, stage| found["milliseconds"].get(stage).is_some();
    for stage in ["reach", "clusters", "chunks", "choose", "caps", "bounds", "shadow_arguments"] {
        ensure!(!ran(&found, stage), "{stage}: {found:#}");
    }
    ensure!(mesh["method"] == "auto" && ran(&mesh, "choose"), "{mesh:#}");
    Ok(())
}

/// The light is within the ring, beside the ball.
fn cube() -> Outcome {
    let folder = models()?;
    let line = |options: &str| format!("shadow @ball.npz @ring.npz {VIEW} --light point:1.2,2.4,0.9 {options} --json");
    folder.run(&line("--mask @mesh")).json()?;
    let found = folder.run(&line("--from-depth 512 --detector every --mask @map")).json()?;
    ensure!(found["lights"][0]["depth_map"]["maps"] == 6, "{found:#}");
    let [different, dark, lit] = differences(&folder, ["mesh.0.png", "map.0.png"])?;
    ensure!(dark > 1000 && lit > 1000 && different < 200, "{different} of {dark} and {lit} differ");
    let message = ["light 0", "--detector every or automatic"];
    for detector in ["differences=0.01", "second=0.01,0.1", "contours=0.01"] {
        folder.run(&line(&format!("--from-depth --detector {detector} --mask @m"))).expect(2, &message)?;
    }
    let automatic = folder.run(&line("--from-depth 512 --mask @automatic")).json()?;
    let [different, ..] = differences(&folder, ["mesh.0.png", "automatic.0.png"])?;
    ensure!(different < 200, "{different} differ with automatic");
    let cells = |found: &serde_json::Value| found["lights"][0]["depth_map"]["cells"].as_u64().unwrap_or(0);
    ensure!(3 * cells(&automatic) < cells(&found), "{automatic:#}");
    ensure!(!folder.path().join("m.0.png").exists(), "a mask is left");
    Ok(())
}

fn modes() -> Outcome {
    let folder = models()?;
    let lights = "--light point:6,12,3 --light dir:-1,2,0.5";
    for (mode, detectors) in [
        ("ambient", &["every"][..]),
        ("composited", &["differences=0.0002"]),
        ("additive", &["differences=0"]),
        ("black", &["automatic", "second=0.0005,0.05 --dangling", "automatic --dangling 0.25,4"]),
    ] {
        let draw = |options: &str| {
            let line = format!("shadow @ball.npz @ring.npz {VIEW} {lights} --mode {mode} {options} --out @p.png");
            folder.run(&line).expect(0, &[])?;
            Ok::<_, String>(folder.image("p.png")?.bytes)
        };
        let mesh = draw("")?;
        for detector in detectors {
            let map = draw(&format!("--from-depth 256 --detector {detector}"))?;
            let apart = apart([&mesh, &map], 1, 24)?;
            ensure!(mesh != map && apart * 30 < mesh.len(), "{mode}: {apart} of {} are apart", mesh.len());
        }
    }
    // Edges that dangle go on, the farther, the more cells.
    let continued = |dangling: &str| {
        let map = "--from-depth 128 --detector second=0.02,0.3";
        let line = format!("shadow @ball.npz @ring.npz {VIEW} {lights} {map} {dangling} --mask @d --json");
        let found = folder.run(&line).json()?;
        found["lights"][0]["depth_map"]["cells"].as_u64().ok_or(format!("{found:#}"))
    };
    let cells = [continued("")?, continued("--dangling")?, continued("--dangling 0,64")?];
    ensure!(cells[0] < cells[1] && cells[1] < cells[2], "{cells:?} cells");
    ensure!(cells[1] == continued("--dangling 0.5,8")?, "--dangling is not 0.5,8");
    // Samples of an area have maps of their own.
    let line = format!(
        "shadow @ball.npz {VIEW} --light point:6,12,3 --area disc:0.5 --samples 3 --from-depth 64 --one-pattern --out @s.png \
         --json"
    );
    let found = folder.run(&line).json()?;
    let cells = &found["lights"][0]["depth_map"]["cells"];
    ensure!(cells.as_array().is_some_and(|cells| cells.len() == 3), "{found:#}");
    Ok(())
}

/// A ball's boundary is that of its mesh's volume, but for what lies behind its surface.
fn volumes() -> Outcome {
    let folder = models()?;
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

fn contours() -> Outcome {
    let folder = models()?;
    let draw = |name: &str, options: &str| {
        let lights = "--light point:6,12,3 --light dir:-1,2,0.5";
        let line =
            format!("shadow @ball.npz @ring.npz {VIEW} {lights} --from-depth 256 {options} --out @{name}.png --json");
        let json = folder.run(&line).json()?;
        Ok::<_, String>((json, folder.image(format!("{name}.png"))?.bytes))
    };
    let (triangles, plain) = draw("plain", "--detector differences=0.002")?;
    let (contours, shown) = draw("walls", "--detector contours=0.002 --volumes")?;
    for light in 0..2 {
        let [cells, walls] = [&triangles, &contours].map(|found| &found["lights"][light]["depth_map"]);
        let [cells, walls] = [&cells["cells"], &walls["walls"]].map(|count| count.as_u64().unwrap_or(0));
        ensure!(0 < walls && 4 * walls < cells, "light {light}: {walls} walls, {cells} cells");
    }
    let changed = apart([&plain, &shown], 1, 4)?;
    ensure!(changed > 2000, "{changed} bytes changed");
    Ok(())
}

fn wrong_options() -> Outcome {
    let folder = models()?;
    for (options, part) in [
        ("--from-depth --method zp+", "--method"),
        ("--from-depth --hide-covered", "--hide-covered"),
        ("--detector every", "--from-depth"),
        ("--from-depth 2", "3..=4096"),
        ("--from-depth 5000", "3..=4096"),
        ("--from-depth --detector some", "there is no detector `some`"),
        ("--from-depth --detector differences=1.5", "0 to 1, not 1.5"),
        ("--from-depth --detector contours=-1", "0 to 1, not -1"),
        ("--from-depth --detector second=0.1", "second"),
        ("--from-depth --detector second=0.1,0.05", "lower threshold first, not 0.1,0.05"),
        ("--from-depth --detector second=0.1,2", "0 to 1, not 2"),
        ("--dangling", "--from-depth"),
        ("--from-depth --detector every --dangling", "add --detector automatic"),
        ("--from-depth --detector contours=0.1 --dangling", "add --detector automatic"),
        ("--from-depth --detector automatic --dangling 1.5,8", "SHARE,CELLS"),
        ("--from-depth --detector automatic --dangling 0.5,65", "1 to 64 whole cells"),
        ("--from-depth --detector automatic --dangling 0.5,2.5", "1 to 64 whole cells"),
        ("--from-depth --detector automatic --dangling 0.5", "0.5"),
    ] {
        folder.run(&format!("shadow @ball.npz {options} --out @p.png")).expect(2, &[part])?;
        ensure!(!folder.path().join("p.png").exists(), "{options}: a picture");
    }
    Ok(())
}
