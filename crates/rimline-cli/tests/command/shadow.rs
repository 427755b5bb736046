//! Shadows: masks whose values are known, pictures, and what is said of them.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_testkit::shapes;

use super::run::{Folder, folder, is_long, rimline};
use super::{Outcome, Test, ensure};
use crate::archive::{array, write_zip};
use rimline_testkit::assets;
use rimline_testkit::harness::{on_files, on_made, on_models};

pub(crate) const TESTS: &[Test] = &[
    ("shadow::masks_of_a_cube_over_the_ground", cube),
    ("shadow::a_near_plane_next_to_the_eye_does_no_harm", next_to_the_eye),
    ("shadow::methods_agree_but_z_pass_within_a_volume", methods),
    ("shadow::masks_of_lights_with_an_area_are_shares", area),
    ("shadow::two_files_shade_each_other", two_files),
    ("shadow::modes_and_options_draw_different_pictures", pictures),
    ("shadow::ranges_end_shadows", ranges),
    ("shadow::json_says_what_was_chosen", json),
    ("shadow::masks_end_at_a_lights_range", mask_range),
    ("shadow::counts_that_would_wrap_are_made_in_batches", may_wrap),
    ("shadow::open_casters_around_a_light_are_not_said_to_be_deep", no_false_layers),
    ("shadow::pictures_do_not_depend_on_scale", scale),
    ("shadow::lights_of_a_file_bring_colour_range_and_cone", file_lights),
];

/// Files that differ in how they are drawn: many parts, a skin, flat, no sides, a whole scene. The others run if long trials
/// are wanted.
const DRAWN: [&str; 5] = [
    "CesiumMilkTruck_quantized.glb",
    "Fox.glb",
    "SimpleSparseAccessor.gltf",
    "moebius.glb",
    "subpass_scene_opaque.gltf",
];

/// The same of the catalogue.
const MADE: [&str; 5] = ["quantized.glb", "skinned.glb", "sparse.gltf", "one_sided.glb", "mirrored_scenes.gltf"];

/// Good models have a picture and a mask.
pub(crate) fn trials() -> Vec<Trial> {
    if is_long() {
        return on_models("shadow_models::", any_model);
    }
    let mut trials = on_made("shadow_models::", MADE, any_model);
    trials.extend(on_files("shadow_models::", assets(), &DRAWN, any_model));
    trials
}

/// A grey or colour PNG.
pub(crate) struct Image {
    width: usize,
    color: png::ColorType,
    pub(crate) bytes: Vec<u8>,
}

impl Image {
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let file = std::fs::File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(file)).read_info().map_err(|error| error.to_string())?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
        let info = reader.next_frame(&mut bytes).map_err(|error| error.to_string())?;
        Ok(Self { width: info.width as usize, color: info.color_type, bytes })
    }

    /// A grey one that holds nothing but 0, 128 and 255.
    pub(crate) fn mask(path: &Path) -> Result<Self, String> {
        let image = Self::read(path)?;
        ensure!(image.color == png::ColorType::Grayscale, "{:?}", image.color);
        let other = image.bytes.iter().find(|value| ![0, 128, 255].contains(*value));
        ensure!(other.is_none(), "a mask holds {other:?}");
        Ok(image)
    }

    pub(crate) fn at(&self, x: usize, y: usize) -> u8 {
        self.bytes[y * self.width + x]
    }

    fn count(&self, value: u8) -> usize {
        self.bytes.iter().map(|byte| usize::from(*byte == value)).sum()
    }
}

/// How many pixels of `channels` values differ in two pictures: any of their values by more than `by`. With one channel, how many
/// values do.
pub(crate) fn apart([one, other]: [&[u8]; 2], channels: usize, by: u8) -> Result<usize, String> {
    ensure!(one.len() == other.len(), "pictures of {} and {} values", one.len(), other.len());
    let is_apart = |(p, q): &(&[u8], &[u8])| p.iter().zip(*q).any(|(p, q)| p.abs_diff(*q) > by);
    Ok(one.chunks(channels).zip(other.chunks(channels)).filter(is_apart).count())
}

/// A shape from the library, scaled and moved, as an .npz.
pub(crate) fn model(shape: &shapes::Shape, scale: f32, [x, y, z]: [f32; 3]) -> Vec<u8> {
    let place = |p: &[f32; 3]| [scale * p[0] + x, scale * p[1] + y, scale * p[2] + z];
    let positions: Vec<u8> = shape.positions.iter().flat_map(place).flat_map(f32::to_le_bytes).collect();
    let faces: Vec<u8> = shape.faces.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    write_zip(&[
        array("positions", "<f4", "False", &format!("({}, 3)", shape.positions.len()), &positions),
        array("faces", "<u4", "False", &format!("({}, 3)", shape.faces.len()), &faces),
    ])
}

/// A folder with a cube of side 2 that floats a unit over the ground.
pub(crate) fn with_cube() -> Result<Folder, String> {
    let folder = folder();
    let cube = model(&shapes::cube(), 1.0, [0.0, 2.0, 0.0]);
    folder.write("cube.npz", cube)?;
    Ok(folder)
}

/// The eye looks level from a height, so that the middle row is the horizon; the cube is in the middle.
const VIEW: &str = "--ground 0 --eye 0,2,12 --target 0,2,0 --fov 60 --size 160x120 --light point:0,9,0";

fn cube() -> Outcome {
    let folder = with_cube()?;
    folder.run(&format!("shadow @cube.npz {VIEW} --mask @m")).expect(0, &[])?;
    let mask = folder.mask("m.0.png")?;
    ensure!(mask.bytes.len() == 160 * 120, "{} pixels", mask.bytes.len());
    // Sky, the cube's front (averted from the light above it), the ground below it, and far from it.
    for (x, y, wanted) in [(10, 10, 128), (80, 60, 0), (80, 75, 0), (80, 115, 255), (5, 75, 255), (155, 64, 255)] {
        ensure!(mask.at(x, y) == wanted, "{x},{y}: {} instead of {wanted}", mask.at(x, y));
    }
    // From above the cube's top is lit; from below the ground there is none, and nothing but averted faces is seen.
    let above = "--ground 0 --eye 0,30,0.01 --target 0,0,0 --size 64x64 --light point:0,9,0";
    folder.run(&format!("shadow @cube.npz {above} --mask @a")).expect(0, &[])?;
    let mask = folder.mask("a.0.png")?;
    ensure!(mask.at(32, 32) == 255 && mask.count(128) == 0, "{} on top", mask.at(32, 32));
    let below = "--ground 0 --eye 0,-20,0.01 --target 0,0,0 --size 64x64 --light point:0,9,0";
    folder.run(&format!("shadow @cube.npz {below} --mask @b")).expect(0, &[])?;
    let mask = folder.mask("b.0.png")?;
    ensure!(mask.at(32, 32) == 0 && mask.at(1, 1) == 128 && mask.count(255) == 0, "{}", mask.at(32, 32));
    Ok(())
}

fn methods() -> Outcome {
    let folder = with_cube()?;
    let mask = |method: &str, view: &str| {
        folder.run(&format!("shadow @cube.npz {view} --method {method} --mask @{method}")).expect(0, &[])?;
        folder.mask(format!("{method}.0.png"))
    };
    // The eye stands in the shadow and looks out.
    let inside = "--ground 0 --eye 0,0.5,0 --target 5,0.2,0 --size 120x90 --light point:0,9,0";
    // The published method is right from outside at least.
    for (view, methods) in [(VIEW, &["zp+", "z-fail", "zp+paper"][..]), (inside, &["zp+", "z-fail", "z-pass"])] {
        let auto = mask("auto", view)?;
        for method in methods {
            let different = apart([&auto.bytes, &mask(method, view)?.bytes], 1, 0)?;
            // The comparison can fail: z-pass misses what the eye is in.
            let is_alike = if *method == "z-pass" { different > 500 } else { different <= 4 };
            ensure!(is_alike, "{view}: auto and {method} differ at {different} pixels");
        }
    }
    Ok(())
}

/// In 24 bits of depth everything beyond some distance was as far away as everything else.
fn next_to_the_eye() -> Outcome {
    let folder = with_cube()?;
    let mask = |method: &str, near: &str| {
        let line = format!("shadow @cube.npz {VIEW} --method {method} --near {near} --mask @{method}{near}");
        folder.run(&line).expect(0, &[])?;
        folder.mask(format!("{method}{near}.0.png"))
    };
    // 10⁻⁶ and 10⁻¹² of the distance, and as near as there are numbers for.
    for (method, nears) in [("auto", &["1e-30"][..]), ("zp+", &["1e-11"]), ("z-fail", &["1e-5", "1e-30"])] {
        let far = mask(method, "1")?;
        ensure!(far.count(0) > 400 && far.count(255) > 5000, "{method}: {} dark, {} lit", far.count(0), far.count(255));
        for near in nears {
            let different = apart([&far.bytes, &mask(method, near)?.bytes], 1, 0)?;
            ensure!(different <= 4, "{method}: with the near plane at {near}, {different} pixels differ");
        }
    }
    // The comparison can fail.
    let other = folder.run(&format!("shadow @cube.npz {} --mask @other", VIEW.replace("0,9,0", "1,9,0")));
    other.expect(0, &[])?;
    let [one, other] = ["auto1", "other"].map(|name| folder.mask(format!("{name}.0.png")));
    let (one, other) = (one?, other?);
    ensure!(one.bytes != other.bytes, "another light, the same mask");
    Ok(())
}

fn area() -> Outcome {
    let folder = with_cube()?;
    folder.run(&format!("shadow @cube.npz {VIEW} --area disc:1 --samples 8 --mask @m")).expect(0, &[])?;
    let mask = folder.image("m.0.png")?;
    ensure!(mask.at(80, 77) == 0 && mask.at(80, 115) == 255 && mask.at(10, 10) == 128, "the middle is not as without");
    let shares: Vec<u8> = (0..=8_u32).map(|lit| ((510 * lit + 8) / 16) as u8).collect();
    let other = mask.bytes.iter().find(|value| **value != 128 && !shares.contains(value));
    ensure!(other.is_none(), "{other:?} is no share of 8 samples");
    let soft = mask.bytes.iter().filter(|value| shares[1..8].contains(value) && **value != 128).count();
    // Without an area there are none, as every mask of one light shows.
    ensure!(soft > 40, "{soft} pixels of penumbra");
    Ok(())
}

fn two_files() -> Outcome {
    let folder = with_cube()?;
    let roof = model(&shapes::plane_grid(1, 1), 4.0, [0.0, 5.0, 0.0]);
    folder.write("roof.npz", roof)?;
    let json = folder.run(&format!("shadow @cube.npz @roof.npz {VIEW} --mask @m --json")).json()?;
    ensure!(json["files"].as_array().is_some_and(|files| files.len() == 2), "{json}");
    // An open sheet casts with every face, a closed cube with its averted ones.
    let casters = &json["lights"][0]["casters"];
    ensure!(casters[0]["casting"] == "averted" && casters[1]["casting"] == "every", "{json}");
    let alone = folder.run(&format!("shadow @cube.npz {VIEW} --mask @n"));
    alone.expect(0, &[])?;
    let [with, without] = ["m.0.png", "n.0.png"].map(|name| folder.mask(name).map(|mask| mask.count(255)));
    let (with, without) = (with?, without?);
    ensure!(with < without, "{with} pixels are lit with a roof, {without} without");
    Ok(())
}

fn pictures() -> Outcome {
    let folder = with_cube()?;
    let plain = "--size 120x90 --light point:3,6,4,color=1,.4,.2,intensity=2 --light dir:-1,1,.3,color=.2,.5,1";
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for options in [
        "",
        "--mode ambient",
        "--mode black",
        "--mode composited",
        "--volumes",
        "--ground -2",
        "--area rect:2,1 --samples 4",
        "--area sphere --samples 4",
        "--eye 3,4,5 --target 0,2,0 --fov 60 --near 0.1",
    ] {
        folder
            .run(&format!("shadow @cube.npz {plain} {options} --out @p.png"))
            .expect(0, &[])
            .map_err(|error| format!("{options}: {error}"))?;
        let image = folder.image("p.png")?;
        ensure!(image.color == png::ColorType::Rgb && image.width == 120, "{:?}", image.color);
        ensure!(!seen.contains(&image.bytes), "{options}: as an earlier picture");
        seen.push(image.bytes);
    }
    // The same again is the same.
    folder.run(&format!("shadow @cube.npz {plain} --out @p.png")).expect(0, &[])?;
    ensure!(folder.image("p.png")?.bytes == seen[0], "two runs differ");
    Ok(())
}

fn ranges() -> Outcome {
    let folder = with_cube()?;
    let lit = |option: &str| folder.run(&format!("shadow @cube.npz {VIEW}{option} --mask @m --json")).json();
    let near = lit(",range=3")?;
    ensure!(near["lights"][0]["casters"][0]["casting"] == "nothing", "{near}");
    ensure!(near["lights"][0]["range"] == 3.0, "{near}");
    ensure!(near["statistics"][0]["skipped"] == 1, "{near}");
    let far = lit(",range=30,begin=2,exponent=2")?;
    ensure!(far["lights"][0]["casters"][0]["casting"] == "averted", "{far}");
    ensure!(lit("")?["lights"][0]["range"].is_null(), "a range where none was given");
    Ok(())
}

fn json() -> Outcome {
    let folder = with_cube()?;
    let json = folder.run(&format!("shadow @cube.npz {VIEW} --out @p.png --json")).json()?;
    for key in ["adapter", "method", "mode", "files", "faces", "samples", "lights", "statistics", "milliseconds"] {
        ensure!(!json[key].is_null(), "no `{key}`: {json}");
    }
    let caster = &json["lights"][0]["casters"][0];
    ensure!(json["method"] == "auto" && json["faces"][0] == 12, "{json}");
    ensure!(caster["counting"] == "z-pass" && caster["silhouette_edges"] == 4, "{caster}");
    let inside = "--ground 0 --eye 0,0.5,0 --target 5,0.2,0 --size 32x32 --light point:0,9,0";
    let json = folder.run(&format!("shadow @cube.npz {inside} --out @p.png --json")).json()?;
    ensure!(json["lights"][0]["casters"][0]["counting"] == "zp+", "{json}");
    ensure!(json["statistics"][0]["capped"] == 1, "{json}");
    let soft = "--area disc:1 --samples 3";
    let json = folder.run(&format!("shadow @cube.npz {VIEW} {soft} --out @p.png --json")).json()?;
    let edges = json["lights"][0]["casters"][0]["silhouette_edges"].as_array().map(Vec::len);
    ensure!(edges == Some(3), "{json}");
    Ok(())
}

fn mask_range() -> Outcome {
    let folder = with_cube()?;
    let mask = |option: &str| {
        let view = "--ground 0 --eye 0,40,0.01 --target 0,0,0 --fov 60 --size 101x101 --light point:0,9,0";
        folder.run(&format!("shadow @cube.npz {view}{option} --mask @m")).expect(0, &[])?;
        folder.mask("m.0.png")
    };
    let (all, some, none) = (mask("")?, mask(",range=15")?, mask(",range=5")?);
    // The ground is lit up to 12 from below the light, sqrt(15² - 9²), and 2.19 pixels are 1 there.
    for (pixels, lit) in [(20, true), (25, true), (28, false), (45, false)] {
        for (x, y) in [(50 + pixels, 50), (50 - pixels, 50), (50, 50 + pixels), (50, 50 - pixels)] {
            ensure!(all.at(x, y) == 255, "without a range {x},{y} is {}", all.at(x, y));
            ensure!((some.at(x, y) == 255) == lit, "{x},{y} is {} within a range of 15", some.at(x, y));
        }
    }
    // The cube's top is 6 below the light.
    ensure!(some.at(50, 50) == 255 && none.at(50, 50) == 0, "{} on top", none.at(50, 50));
    ensure!(none.count(255) == 0, "{} pixels are lit out of range", none.count(255));
    Ok(())
}

/// A stack of open sheets under a light: `layers` times the same square, one over the other.
fn stack(layers: u16) -> Vec<u8> {
    let mut shape = shapes::plane_grid(1, 1);
    let (positions, faces) = (shape.positions.clone(), shape.faces.clone());
    for layer in 1..layers {
        let first = shape.positions.len() as u32;
        let raised = |&[x, y, z]: &[f32; 3]| [x, y + f32::from(layer) / 4096.0, z];
        shape.positions.extend(positions.iter().map(raised));
        shape.faces.extend(faces.iter().map(|face| face.map(|v| v + first)));
    }
    model(&shape, 2.0, [0.0, 2.0, 0.0])
}

/// Counts that are too large for the stencil are made in batches, without a message.
fn may_wrap() -> Outcome {
    let folder = folder();
    let line = |files: &str, command: &str| {
        let view = "--ground 0 --size 64x48 --eye 9,12,14 --target 0,1,0 --light dir:0.3,1,0.1";
        folder.run(&format!("{command} {files} {view}"))
    };
    let stacks = [("few.npz", 100), ("half.npz", 160), ("half_less.npz", 96), ("many.npz", 256), ("more.npz", 300)];
    for (name, layers) in stacks {
        folder.write(name, stack(layers))?;
    }
    let few = line("@few.npz", "shadow --mask @few --json");
    ensure!(few.json()?["may_wrap"] == 0 && !few.stderr.contains("stencil"), "{} {}", few.stdout, few.stderr);
    ensure!(few.json()?["count_bound"].as_u64().is_some_and(|bound| (100..256).contains(&bound)), "{}", few.stdout);
    let few = folder.mask("few.0.png")?;
    // One stack of 256 sheets, which look like none to eight bits, two stacks with as many in all, and one of 300.
    for (name, files) in [("a", "@many.npz"), ("b", "@half.npz @half_less.npz"), ("c", "@more.npz")] {
        let many = line(files, &format!("shadow --mask @{name} --json"));
        let json = many.json()?;
        ensure!(!many.stderr.contains("stencil"), "{files}: {}", many.stderr);
        ensure!(json["may_wrap"] == 0 && json["count_bound"].as_u64() > Some(255), "{json}");
        let mask = folder.mask(format!("{name}.0.png"))?;
        // The stacks are of nearly the same height, and so are their shadows on the ground.
        let (dark, expected) = (mask.count(0), few.count(0));
        ensure!(expected > 80 && dark.abs_diff(expected) < 10, "{files}: {dark} dark pixels, {expected} of few sheets");
    }
    let film = line("@many.npz", "film --frames 1 --out @frames");
    film.expect(0, &[])?;
    ensure!(!film.stderr.contains("stencil"), "{}", film.stderr);
    line("@many.npz", "shadow --out @picture.png").expect(0, &[])?;
    let [film, picture] = ["frames/0000.png", "picture.png"].map(|name| folder.image(name));
    ensure!(film?.bytes == picture?.bytes, "a film's picture is another");
    Ok(())
}

/// A light within an open shade, or on a leaky body, has few faces over each other, whatever the number of faces.
fn no_false_layers() -> Outcome {
    let folder = folder();
    let mut leaky = shapes::sphere(30);
    let mut number = 0;
    leaky.faces.retain(|_| {
        number += 1;
        number % 3 != 0
    });
    // Within the sphere and on its surface; the stages' bound is the number of faces there.
    folder.write("leaky.npz", model(&leaky, 1.0, [0.0, 1.2, 0.0]))?;
    ensure!(leaky.faces.len() > 512, "{} faces", leaky.faces.len());
    for light in ["point:0,1.2,0", "point:0.1,2.19,0.05", "point:0.3,1.0,0.2"] {
        let found = folder.run(&format!("shadow @leaky.npz --size 32x24 --light {light} --mask @m --json"));
        let json = found.json()?;
        ensure!(!found.stderr.contains("stencil"), "{light}: {}", found.stderr);
        let bound = json["count_bound"].as_u64();
        ensure!(json["may_wrap"] == 0 && bound.is_some_and(|bound| bound < 256), "{light}: {json}");
    }
    Ok(())
}

fn scale() -> Outcome {
    let folder = folder();
    let mut drawn = Vec::new();
    // Powers of two leave every position as exact as it was. Squares of some are no numbers any more, or zero.
    let all = [1.0, 2.0_f32.powi(-100), 1e19, 1e37, 2.0_f32.powi(64), 2.0_f32.powi(120), 1e-30];
    let scales = if is_long() { &all[..] } else { &all[..4] };
    for &scale in scales {
        folder.write("cube.npz", model(&shapes::cube(), scale, [0.0, 2.0 * scale, 0.0]))?;
        let mut images = Vec::new();
        let light = format!("--light point:{},{},{},range={}", 3.0 * scale, 6.0 * scale, 4.0 * scale, 9.0 * scale);
        for (place, options) in
            ["", &format!("{light} --light dir:1,2,1 --volumes"), "--area disc --samples 2"].iter().enumerate()
        {
            folder
                .run(&format!("shadow @cube.npz --size 96x72 {options} --out @p.png"))
                .expect(0, &[])
                .map_err(|error| format!("{scale:e}, {place}: {error}"))?;
            images.push(folder.image("p.png")?.bytes);
        }
        drawn.push(images);
    }
    // From -3e38 to 3e38 is further than the numbers go.
    let vast = model(&shapes::cube(), 3e38, [0.0; 3]);
    folder.write("vast.npz", vast)?;
    for command in ["draw", "shadow", "film --frames 1"] {
        let line = format!("{command} @vast.npz --size 96x72 --out @vast");
        folder.run(&line).expect(1, &["vast.npz: the model is larger", "scale it down"])?;
    }
    for (scale, images) in scales.iter().zip(&drawn) {
        for (place, (image, first)) in images.iter().zip(&drawn[0]).enumerate() {
            let different = apart([image, first], 1, 2)?;
            ensure!(different <= 60, "{scale:e}, {place}: {different} bytes differ");
        }
    }
    // The comparison can fail.
    let different = apart([&drawn[0][0], &drawn[0][1]], 1, 2)?;
    ensure!(different > 1000, "another light changes {different} bytes only");
    Ok(())
}

/// A glTF with a triangle near the origin and this light, 4 above it, that shines down.
fn lit_triangle(light: &str) -> String {
    use base64::Engine as _;
    let corners: [[f32; 3]; 3] = [[0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {{ "KHR_lights_punctual": {{ "lights": [{light}] }} }},
            "buffers": [{{ "byteLength": 36, "uri": "data:application/octet-stream;base64,{data}" }}],
            "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}],
            "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 1, 0], "max": [1, 1, 1] }}],
            "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }} }}] }}],
            "nodes": [{{ "mesh": 0 }}, {{ "name": "lamp", "translation": [0, 4, 0],
                "rotation": [-0.7071068, 0, 0, 0.7071068],
                "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }} }}],
            "scenes": [{{ "nodes": [0, 1] }}], "scene": 0 }}"#
    )
}

fn file_lights() -> Outcome {
    let folder = folder();
    let shadow = |light: &str, options: &str| {
        folder.write("m.gltf", lit_triangle(light))?;
        let view = "--ground 0 --eye 0,20,0.01 --target 0,0,0 --fov 60 --size 101x101 --mask @m --json";
        let json = folder.run(&format!("shadow @m.gltf {view} {options}")).json()?;
        Ok::<_, String>((json["lights"][0].clone(), folder.mask("m.0.png")?))
    };
    let point = r#"{ "type": "point", "color": [1, 0.5, 0.25], "intensity": 800, "range": 7 }"#;
    let (light, mask) = shadow(point, "--light file:all")?;
    // The brightest counts as 1, whatever its unit.
    ensure!(light["color"] == serde_json::json!([1.0, 0.5, 0.25]) && light["range"] == 7.0, "{light}");
    // The range ends on the ground 5.7 from below the light, and a unit is 4.4 pixels.
    ensure!(mask.at(30, 50) == 255 && mask.at(22, 50) == 0, "{} and {}", mask.at(30, 50), mask.at(22, 50));
    let (light, mask) = shadow(point, "--light file:all,color=0,1,0,intensity=0.5,range=30")?;
    ensure!(light["color"] == serde_json::json!([0.0, 0.5, 0.0]) && light["range"] == 30.0, "{light}");
    ensure!(mask.at(22, 50) == 255, "the file's range, in spite of the option's");
    let begin = shadow(point, "--light file:lamp,begin=8").err().unwrap_or_default();
    ensure!(begin.contains("exit code 2") && begin.contains("begin=8") && begin.contains("lamp"), "{begin}");
    // A cone of half a right angle ends on the ground 4 from below the light.
    let spot = r#"{ "type": "spot" }"#;
    let (_, mask) = shadow(spot, "--light file:all")?;
    ensure!(mask.at(36, 50) == 255 && mask.at(29, 50) == 0, "{} and {}", mask.at(36, 50), mask.at(29, 50));
    let endless = shadow(spot, "--light file:all,begin=1").err().unwrap_or_default();
    ensure!(endless.contains("exit code 2") && endless.contains("range"), "{endless}");
    Ok(())
}

fn any_model(file: &Path) -> Outcome {
    let folder = folder();
    let (out, mask) = (folder.path().join("p.png"), folder.path().join("m"));
    let mut line = vec!["shadow".into(), file.as_os_str().to_owned()];
    line.extend(["--size", "96x72", "--out"].map(Into::into));
    line.extend([out.as_os_str().to_owned(), "--mask".into(), mask.into_os_string()]);
    rimline(line).expect(0, &[])?;
    let picture = Image::read(&out)?;
    ensure!(picture.bytes.iter().any(|&value| value != picture.bytes[0]), "an empty picture");
    let mask = folder.mask("m.0.png")?;
    ensure!(mask.count(0) > 20 && mask.count(255) > 20, "{} dark, {} lit pixels", mask.count(0), mask.count(255));
    Ok(())
}
