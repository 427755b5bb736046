//! Memory that loading a glTF takes, measured by an allocator that counts. It never exceeds the limit by more than
//! [`SLACK`], for any file. The loader does not charge much more than it takes: up to 1.5 times for a large file.
//!
//! A binary of its own, whose tests run one after the other, since the allocator counts the memory of the whole process.

use std::path::Path;

use libtest_mimic::{Arguments, Failed, Trial};
use peak_alloc::PeakAlloc;
use rimline::gltf::{Asset, GltfError, LoadOptions};
use rimline::mesh::{Weld, WeldDistance};
use rimline_models::maker::{F32, Maker, U8, U32, everything, flat};
use rimline_testkit::{harness, is_long, shapes};
use serde_json::{Value, json};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

type Outcome = Result<(), Failed>;

/// Paths, messages and lists of a few entries, which are not charged.
const SLACK: u64 = 64 << 10;

fn main() {
    let mut arguments = Arguments::from_args();
    arguments.test_threads = Some(1);
    let bomb = |&(name, make, what): &Bomb| Trial::test(format!("bomb::{name}"), move || too_large(make, what));
    let mut trials: Vec<Trial> = BOMBS.iter().map(bomb).collect();
    trials.extend(LISTS.iter().map(|&(name, make)| {
        let most = if name == "everything" { 16 } else { 64 };
        Trial::test(format!("list::{name}"), move || within_limits(&make().glb(), None, most))
    }));
    trials.extend([
        Trial::test("control", control),
        Trial::test("the_limit_is_exact", exact),
        Trial::test("the_estimate_is_close_and_comes_before_the_data", estimates),
        Trial::test("buffers_that_name_one_file", one_file_many_times),
        Trial::test("long_texts", long_texts),
        Trial::test("a_sparse_file_of_a_terabyte", hole),
        Trial::test("zeros_that_no_machine_holds", no_room),
        Trial::test("the_smallest_edge_takes_no_more_than_the_mesh", smallest_edge),
        Trial::test("mutated_files_within_a_limit", mutated),
        Trial::test("by_default_too", by_default).with_ignored_flag(!is_long()),
    ]);
    trials.extend(harness::on_models("within_each_limit: ", |path: &Path| {
        within_limits(&std::fs::read(path)?, path.parent(), 16)
    }));
    libtest_mimic::run(&arguments, trials).exit();
}

fn ensure(condition: bool, message: impl FnOnce() -> String) -> Outcome {
    if condition { Ok(()) } else { Err(message().into()) }
}

/// The most memory that is used meanwhile, and what comes of it.
fn peak<T>(run: impl FnOnce() -> T) -> (u64, T) {
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let result = run();
    ((ALLOCATOR.peak_usage() - before) as u64, result)
}

fn options(memory_limit: u64) -> LoadOptions {
    LoadOptions { memory_limit, ..Weld::Data.into() }
}

/// The number of edges of an asset's mesh in a pose, made while its lights and cameras are there. A damaged animation does
/// not play.
fn used(asset: &Asset) -> usize {
    let animation = asset.animations().first().filter(|first| first.fault.is_none()).map(|_| 0);
    let _lights = asset.each_light(animation, 0.3);
    let _cameras = asset.each_camera(animation, 0.3);
    let mesh = asset.pose(animation, 0.3).ok().and_then(|pose| asset.model().mesh(&pose).ok());
    mesh.map_or(0, |mesh| mesh.edges().len())
}

/// Loads a file and uses it.
fn measured(bytes: &[u8], base: Option<&Path>, options: LoadOptions) -> (u64, Result<usize, GltfError>) {
    peak(|| Asset::from_slice(bytes, base, options).map(|asset| used(&asset)))
}

fn within(bytes: &[u8], base: Option<&Path>, limit: u64) -> Result<Result<usize, GltfError>, Failed> {
    compared(measured(bytes, base, options(limit)), limit)
}

/// The result, unless more than the limit was used.
fn compared((peak, result): (u64, Result<usize, GltfError>), limit: u64) -> Result<Result<usize, GltfError>, Failed> {
    ensure(peak <= limit + SLACK, || format!("{peak} bytes used of {limit}; then {result:?}"))?;
    Ok(result)
}

/// A small file that makes much, in one way: its name, its making, and what is too large.
type Bomb = (&'static str, fn() -> Maker, &'static str);

const BOMBS: &[Bomb] = &[
    ("faces_of_instances", || instances(zeros(2400), 880), "meshes[0] (its instances)"),
    ("faces_of_nodes", || repeat(zeros(6000), "/nodes", 500), "meshes[0] (its instances)"),
    (
        "names_of_instances",
        || with(instances(zeros(3), 10_000), "/nodes/0", "name", long_name()),
        "meshes[0] (its instances)",
    ),
    ("morph_weights_of_instances", || targets(instances(zeros(3), 20_000), 2000), "meshes[0] (its instances)"),
    (
        "palettes",
        || repeat(with(Maker::skinned([0; 4], [1.0; 4]), "/skins/0", "joints", json!(vec![1; 5000])), "/nodes", 1000),
        "meshes[0] (its instances)",
    ),
    ("instances_without_faces", || instances(zeros(0), 5_000_000), "EXT_mesh_gpu_instancing"),
    ("zero_positions", || zeros(1 << 30), "accessors[0], used as meshes[0].primitives[0].attributes.POSITION"),
    ("zero_targets", || targets(zeros(100_000), 1000), "meshes[0].primitives[0].targets["),
    ("meshes_of_one_accessor", || repeat(zeros(6000), "/meshes", 500), "meshes["),
    ("primitives_of_one_accessor", || repeat(one_vertex(), "/meshes/0/primitives", 1000), "meshes[0]"),
    // Accessors that are only read to check them are charged, too, since reading takes time.
    (
        "points_of_one_accessor",
        || repeat(with(zeros(60_000), PRIMITIVE, "mode", json!(0)), "/meshes/0/primitives", 1000),
        "meshes[0].primitives[",
    ),
    ("influences", influences, "meshes[0].primitives[0]"),
    ("sparse_over_zeros", || repeat(sparse(), "/meshes", 200), "meshes["),
    ("channels_of_one_accessor", channels, "animations[0].samplers[0]"),
    ("names_of_lights", names_of_lights, "(its light)"),
    ("names_of_cameras", names_of_cameras, "(its camera)"),
];

/// A name and a maker of a file.
type Made = (&'static str, fn() -> Maker);

/// Lists of many small things, where the JSON takes more memory than all else, and a file of nearly everything.
const LISTS: &[Made] = &[
    ("everything", everything),
    ("empty_objects", || repeated("extras", json!({}))),
    ("small_objects", || repeated("extras", json!({ "": 0 }))),
    ("objects_of_twelve", || repeated("extras", (0..12).map(|n| (n.to_string(), json!(0))).collect())),
    ("small_lists", || repeated("extras", json!([0]))),
    ("numbers", || repeated("extras", json!(0))),
    ("strings", || repeated("extras", json!(""))),
    ("nodes", || repeated("nodes", json!({}))),
    ("roots", roots),
    ("samplers", samplers),
    ("accessors", || repeated("accessors", json!({ "componentType": F32, "type": "VEC3", "count": 0 }))),
    ("meshes", || repeated("meshes", json!({ "primitives": [{ "attributes": {} }] }))),
    ("images", || repeated("images", json!({}))),
    ("targets", || repeated("meshes", json!({ "primitives": [{ "attributes": {}, "targets": [{}, {}, {}] }] }))),
];

/// A mesh of zeros, for which the file has no bytes.
fn zeros(count: u64) -> Maker {
    let mut maker = Maker::new();
    let positions = maker.zeros(count);
    maker.mesh(&json!({ "attributes": { "POSITION": positions } }));
    maker.push("nodes", json!({ "mesh": 0 }));
    maker
}

/// The node has this number of instances of the mesh. The mesh of all instances has the faces of each, so a file of a few
/// hundred bytes makes gigabytes.
fn instances(mut maker: Maker, count: u64) -> Maker {
    let attributes = json!({ "TRANSLATION": maker.zeros(count) });
    maker.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    maker
}

const PRIMITIVE: &str = "/meshes/0/primitives/0";

fn with(mut maker: Maker, at: &str, key: &str, value: Value) -> Maker {
    maker.json.pointer_mut(at).expect("it is there")[key] = value;
    maker
}

fn long_name() -> Value {
    json!("n".repeat(10_000))
}

/// Morph targets that move nothing.
fn targets(maker: Maker, count: usize) -> Maker {
    with(maker, PRIMITIVE, "targets", json!(vec![json!({}); count]))
}

fn repeated(list: &str, value: Value) -> Maker {
    with(Maker::new(), "", list, json!(vec![value; 20_000]))
}

/// The file with a list that has this number of copies of its first element, and no others.
fn repeat(mut maker: Maker, list: &str, count: usize) -> Maker {
    let list = maker.json.pointer_mut(list).expect("a list");
    *list = json!(vec![list[0].clone(); count]);
    maker
}

fn one_vertex() -> Maker {
    let mut maker = Maker::square();
    let indices = maker.indices(U8, &vec![0; 30_000]);
    with(maker, PRIMITIVE, "indices", json!(indices))
}

fn sparse() -> Maker {
    let mut maker = zeros(9999);
    maker.sparse(0, &[0], &[0.0; 3]);
    maker
}

/// Eight sets of influences, all of the same two accessors of bytes that are zeros.
fn influences() -> Maker {
    let mut maker = zeros(20_000);
    let accessor =
        |normalized: bool| json!({ "componentType": U8, "type": "VEC4", "count": 20_000, "normalized": normalized });
    let joints = maker.push("accessors", accessor(false));
    let weights = maker.push("accessors", accessor(true));
    for set in 0..8 {
        let attributes = &mut maker.json["meshes"][0]["primitives"][0]["attributes"];
        attributes[format!("JOINTS_{set}")] = json!(joints);
        attributes[format!("WEIGHTS_{set}")] = json!(weights);
    }
    maker.json["nodes"][0]["skin"] = json!(0);
    maker.push("skins", json!({ "joints": [0] }));
    maker
}

fn channels() -> Maker {
    let mut maker = Maker::square();
    let times: Vec<f32> = (0..20_000).map(|key| key as f32).collect();
    let (times, values) = (maker.floats("SCALAR", &times), maker.zeros(20_000));
    maker.animate(0, "translation", &json!({ "input": times, "output": values }));
    let channels = &mut maker.json["animations"][0]["channels"];
    *channels = json!(vec![channels[0].clone(); 1000]);
    maker
}

fn samplers() -> Maker {
    let mut maker = Maker::square();
    let sampler = json!({ "input": 0, "output": 0 });
    let channel = json!({ "sampler": 0, "target": { "path": "scale" } });
    maker.push("animations", json!({ "samplers": vec![sampler; 20_000], "channels": vec![channel; 20_000] }));
    maker
}

/// Roots of a scene, and names of extensions: elements of two and three bytes of text.
fn roots() -> Maker {
    let mut maker = Maker::new();
    maker.json["nodes"] = json!([{}]);
    maker.json["scenes"] = json!([{ "nodes": vec![0; 20_000] }]);
    maker.json["meshes"] = json!([{ "primitives": [], "weights": [] }]);
    maker.json["extensionsUsed"] = json!(vec![""; 20_000]);
    maker
}

/// Within limits from 4 KiB to 16 MiB. The last refuses it, too, for what it makes much of.
fn too_large(make: fn() -> Maker, part: &str) -> Outcome {
    let bytes = make().glb();
    for bits in 12..24 {
        drop(within(&bytes, None, 1 << bits)?);
    }
    match within(&bytes, None, 16 << 20)? {
        Err(GltfError::TooLarge { what, needed, limit }) => {
            let good = what.contains(part) && needed > limit && limit == 16 << 20;
            ensure(good, || format!("{what}: {needed} of {limit}"))
        }
        other => Err(format!("{other:?}").into()),
    }
}

/// Within the default limit, 4 GiB. A file of 800,000 faces, 880 times, is refused.
fn by_default() -> Outcome {
    for (name, make, _) in BOMBS {
        let result = within(&make().glb(), None, LoadOptions::DEFAULT_MEMORY_LIMIT)?;
        println!("{name}: {:?}", result.err());
    }
    let reproduction = instances(zeros(2_400_000), 880).glb();
    let result = within(&reproduction, None, LoadOptions::DEFAULT_MEMORY_LIMIT)?;
    ensure(matches!(result, Err(GltfError::TooLarge { .. })), || format!("{result:?}"))
}

/// The allocator notices what is used and given back, and [`compared`] a limit that was passed.
fn control() -> Outcome {
    let take = || drop(std::hint::black_box(vec![1_u8; 3 << 20]));
    let (peak, ()) = peak(|| (0..2).for_each(|_| take()));
    ensure((3 << 20..4 << 20).contains(&peak), || format!("{peak} bytes counted for 3 MiB, two times"))?;
    let (peak, result) = measured(&zeros(300_000).glb(), None, options(u64::MAX));
    let edges = result?;
    ensure(peak >= 3_200_000, || format!("{peak} bytes for 300,000 positions"))?;
    ensure(compared((peak, Ok(edges)), 3_000_000).is_err(), || format!("{peak} bytes are within 3,000,000"))
}

/// An error names the limit that allows what was refused. So a few errors lead to a limit that is enough for the file, and
/// no smaller one is. Welding by distance takes the most if each vertex has a cell and lists have just doubled.
fn exact() -> Outcome {
    let near = Weld::Distance(WeldDistance::new(1.0)?);
    for (maker, weld, fewest) in [(everything(), Weld::Data, 10), (scattered((1 << 16) + 1), near, 5)] {
        let bytes = maker.glb();
        let load = |limit| compared(measured(&bytes, None, LoadOptions { weld, ..options(limit) }), limit);
        let (mut limit, mut steps) = (0, 0);
        while let Err(error) = load(limit)? {
            match error {
                GltfError::TooLarge { needed, limit: named, .. } if needed > limit && named == limit => limit = needed,
                other => return Err(other.to_string().into()),
            }
            steps += 1;
        }
        let is_least = load(limit - 1)?.is_err();
        ensure(is_least && (fewest..1000).contains(&steps), || format!("{steps} steps, {limit} bytes"))?;
    }
    Ok(())
}

/// A torus. `is_soup` gives each face its own vertices, `has_normals` vertices an attribute that is not read.
fn torus(is_soup: bool, has_normals: bool) -> Maker {
    let mut shape = shapes::torus(150, 300, 3.0, 1.0);
    if is_soup {
        shape = flat(&shape);
    }
    let mut maker = Maker::new();
    let mut primitive = maker.primitive(&shape, U32);
    if has_normals {
        primitive["attributes"]["NORMAL"] = json!(maker.floats("VEC3", shape.positions.as_flattened()));
    }
    maker.mesh(&primitive);
    maker.push("nodes", json!({ "mesh": 0 }));
    maker
}

/// The first refusal of a large file names what is enough for all of it, and at most 1.5 times of what is used then. It
/// comes before the data is read.
fn estimates() -> Outcome {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("torus.glb");
    let cases =
        [(false, false, false), (false, true, false), (true, false, false), (true, true, false), (false, false, true)];
    for (is_soup, has_normals, has_uri) in cases {
        let mut maker = torus(is_soup, has_normals);
        let mut bytes = maker.glb();
        if has_uri {
            std::fs::write(folder.path().join("torus.bin"), &maker.bytes)?;
            let uri = format!("{}torus.bin", "./".repeat(400));
            maker.json["buffers"] = json!([{ "uri": uri, "byteLength": maker.bytes.len() }]);
            bytes = maker.gltf();
        }
        std::fs::write(&path, bytes)?;
        let open = |limit: u64| peak(|| Asset::open(&path, options(limit)).map(|asset| used(&asset)));
        let (used, refused) = open(1 << 20);
        let Err(GltfError::TooLarge { needed, .. }) = refused else { return Err(format!("{refused:?}").into()) };
        ensure(used <= SLACK, || format!("{used} bytes used before it was refused"))?;
        let (peak, made) = open(needed);
        ensure(made.as_ref().ok() == Some(&135_000), || format!("{needed} bytes are not enough: {made:?}"))?;
        println!("soup {is_soup}, normals {has_normals}, file beside {has_uri}: {needed} bytes requested, {peak} used");
        ensure((peak..=3 * peak / 2).contains(&needed), || format!("{needed} bytes requested, {peak} used"))?;
    }
    Ok(())
}

fn names_of_lights() -> Maker {
    let mut maker = Maker::new();
    let light = json!({ "type": "point", "name": "n".repeat(100_000) });
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let node = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    maker.json["nodes"] = json!(vec![node; 1000]);
    maker
}

fn names_of_cameras() -> Maker {
    let mut maker = Maker::new();
    let perspective = json!({ "yfov": 1, "znear": 0.1 });
    let camera = json!({ "type": "perspective", "perspective": perspective, "name": "n".repeat(100_000) });
    maker.push("cameras", camera);
    maker.json["nodes"] = json!(vec![json!({ "camera": 0 }); 1000]);
    maker
}

/// Texts that the loader copies: URIs in a folder with a long path, one that is no UTF-8 once decoded, one that leads
/// outside, and a key in the path of a fault.
fn long_texts() -> Outcome {
    let name = "d".repeat(2000);
    let folder = Some(Path::new(&name));
    let buffer = |uri: String| with(Maker::new(), "", "buffers", json!([{ "uri": uri, "byteLength": 1 }]));
    let key = format!("{}Texture", "k".repeat(1_000_000));
    let texture = with(Maker::new(), "", "materials", json!([{ key: { "index": "x" } }]));
    let outside = buffer(format!("../{}", "a".repeat(1_000_000)));
    let cases = [
        (repeated("images", json!({ "uri": "%41" })), folder),
        (buffer("%FF".repeat(333_333)), folder),
        (outside, None),
        (texture, None),
    ];
    cases.iter().try_for_each(|(maker, base)| within_limits(maker.json.to_string().as_bytes(), *base, 64))
}

fn one_file_many_times() -> Outcome {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("one.bin"), vec![0; 1 << 20])?;
    let mut maker = Maker::new();
    maker.json["buffers"] = json!(vec![json!({ "uri": "one.bin", "byteLength": 1 << 20 }); 1000]);
    match within(maker.json.to_string().as_bytes(), Some(folder.path()), 16 << 20)? {
        Err(GltfError::TooLarge { what, .. }) if what.contains("one.bin") => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// A file of a terabyte that takes no room on the disk: as a buffer, and as the glTF itself.
fn hole() -> Outcome {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("hole.bin");
    std::fs::File::create(&path)?.set_len(1 << 40)?;
    let mut maker = Maker::new();
    maker.json["buffers"] = json!([{ "uri": "hole.bin", "byteLength": 1_u64 << 40 }]);
    let as_buffer = within(maker.json.to_string().as_bytes(), Some(folder.path()), 16 << 20)?;
    for result in [as_buffer, Asset::open(&path, Weld::Data).map(|asset| used(&asset))] {
        match result {
            Err(GltfError::TooLarge { what, needed, .. }) if what.contains("hole.bin") && needed >= 1 << 40 => {}
            other => return Err(format!("{other:?}").into()),
        }
    }
    Ok(())
}

/// Without a limit, an accessor of zeros for which no machine has the memory.
fn no_room() -> Outcome {
    let (peak, result) = measured(&zeros(1 << 50).glb(), None, options(u64::MAX));
    ensure(peak <= SLACK, || format!("{peak} bytes used"))?;
    match result {
        Err(GltfError::Memory { what, bytes }) if what.contains("accessors[0]") && bytes == 12 << 50 => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// Vertices that are not near each other, and a face of the first three.
fn scattered(count: usize) -> Maker {
    let mut maker = Maker::new();
    let coordinates: Vec<f32> = (0..3 * count).map(|number| number as f32).collect();
    let (positions, indices) = (maker.floats("VEC3", &coordinates), maker.indices(U8, &[0, 1, 2]));
    maker.mesh(&json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    maker.push("nodes", json!({ "mesh": 0 }));
    maker
}

/// The mesh of all instances is charged 8 bytes a vertex and 72 a face. No face names most vertices.
fn smallest_edge() -> Outcome {
    const COUNT: usize = 100_000;
    let asset = Asset::from_slice(&scattered(COUNT).glb(), None, Weld::Data)?;
    let vertices = asset.model().geometries()[0].positions().len();
    ensure(vertices == COUNT, || format!("{vertices} vertices"))?;
    let (peak, smallest) = peak(|| asset.smallest_edge(None, 0.0));
    ensure(smallest? == 27.0_f64.sqrt(), || "another edge".to_owned())?;
    ensure(peak <= 8 * COUNT as u64 + SLACK, || format!("{peak} bytes used"))
}

/// At every limit, doubled from 4 KiB until the file loads, no more is used than that; and the last is no more than `most`
/// times of what is used and [`SLACK`].
fn within_limits(bytes: &[u8], base: Option<&Path>, most: u64) -> Outcome {
    let mut limit = 1 << 12;
    loop {
        match within(bytes, base, limit)? {
            Ok(_) => break,
            Err(GltfError::TooLarge { .. }) => limit *= 2,
            Err(error) => return Err(error.to_string().into()),
        }
    }
    let (peak, _) = measured(bytes, base, options(limit));
    println!("{} bytes: at most {peak} used, a limit of {limit} is enough", bytes.len());
    ensure(limit <= most * (peak + SLACK), || format!("{limit} bytes requested, {peak} used"))
}

/// A file of nearly everything, whose accessors have no bytes but for sparse elements: all others are zeros.
fn everything_zero() -> Maker {
    let mut maker = everything();
    let json = maker.json.as_object_mut().expect("an object");
    // Zeros are no rotations and no matrices.
    json.remove("animations");
    json["skins"][0].as_object_mut().expect("an object").remove("inverseBindMatrices");
    for accessor in json["accessors"].as_array_mut().expect("a list") {
        accessor.as_object_mut().expect("an object").remove("bufferView");
    }
    maker
}

/// Numbers of a good file replaced by others, small and huge.
fn mutated() -> Outcome {
    let (mut cases, mut refused) = (0, 0);
    for maker in [everything(), everything_zero()] {
        let text = String::from_utf8(maker.gltf()).expect("JSON");
        let limit =
            (12..40).map(|bits| 1 << bits).find(|&limit| measured(text.as_bytes(), None, options(limit)).1.is_ok());
        let limit = limit.ok_or("the file does not load")?;
        let starts = text.match_indices([':', '[', ',']).map(|(at, _)| at + 1);
        for start in starts.filter(|&at| text[at..].starts_with(|c: char| c.is_ascii_digit())) {
            let rest = text[start..].trim_start_matches(|c: char| c.is_ascii_digit());
            for new in ["0", "1", "3", "40", "3000", "100000", "5000000", "4294967295"] {
                let changed = format!("{}{new}{rest}", &text[..start]);
                let result = within(changed.as_bytes(), None, limit)
                    .map_err(|e| Failed::from(format!("{new} at byte {start}: {}", e.message().unwrap_or_default())))?;
                cases += 1;
                refused += usize::from(matches!(result, Err(GltfError::TooLarge { .. })));
            }
        }
    }
    println!("{cases} cases, {refused} over the limit");
    ensure(refused >= 10, || format!("only {refused} of {cases} were over the limit"))
}
