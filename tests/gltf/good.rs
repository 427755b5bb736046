//! Every good file of the catalogue and of the shared models loads, with the counts that its table states, and poses at
//! any time.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use libtest_mimic::Trial;
use rimline::gltf::Asset;
use rimline::mesh::Weld;
use rimline::model::{Geometry, InstancePose};

use rimline_models::catalogue::GOOD;
use rimline_testkit::harness::{on_both, on_files, on_made};
use rimline_testkit::{assets, files};

use crate::{Outcome, check, ensure, test};

/// File; counts over its meshes, each once, welded by position, without degenerate faces, as `Good::counts` has them;
/// instances, joints of all skins, morph targets, animations. Only what is drawn counts: `22_vertex_color` has more
/// vertices and instances in lines and points.
type Row = (&'static str, [usize; 10], [usize; 4]);

const ROWS: &[Row] = &[
    ("22_vertex_color.glb", [5, 13, 13, 13, 0, 0, 0, 0, 0, 3], [3, 0, 0, 0]),
    ("AnimatedMorphCube.glb", [12, 24, 8, 0, 0, 0, 0, 0, 1, 1], [1, 0, 2, 1]),
    ("AntiqueCamera.glb", [20_066, 21_178, 10_227, 206, 83, 10, 0, 0, 0, 2], [2, 0, 0, 0]),
    ("Box.glb", [12, 24, 8, 0, 0, 0, 0, 0, 1, 1], [1, 0, 0, 0]),
    ("CesiumMan.glb", [4672, 3273, 2338, 0, 0, 0, 0, 0, 1, 1], [1, 19, 0, 1]),
    ("CesiumMan_8influences_morph.glb", [4672, 3273, 2338, 0, 0, 0, 0, 0, 1, 1], [1, 19, 1, 1]),
    ("CesiumMilkTruck_quantized.glb", [2856, 2978, 1452, 8, 0, 0, 0, 0, 1, 2], [3, 0, 0, 1]),
    ("FlightHelmet.glb", [94_722, 60_366, 47_561, 296, 0, 0, 0, 0, 3, 5], [5, 0, 0, 0]),
    ("Fox.glb", [576, 1728, 290, 0, 0, 0, 0, 0, 1, 1], [1, 24, 0, 3]),
    ("InfiniteSkinnedTentacle.glb", [76, 40, 40, 0, 0, 0, 0, 0, 1, 1], [84, 840, 0, 1]),
    ("InterpolationTest.glb", [110, 220, 76, 4, 0, 0, 0, 0, 9, 10], [10, 0, 0, 9]),
    ("Knight.glb", [6952, 7024, 3665, 278, 0, 0, 0, 0, 4, 15], [15, 41, 0, 76]),
    ("MorphStressTest.gltf", [2412, 1528, 1224, 0, 0, 0, 0, 0, 1, 1], [1, 0, 8, 3]),
    ("RobotExpressive.glb", [3237, 7214, 1820, 232, 0, 0, 3, 0, 9, 14], [14, 86, 3, 14]),
    ("SheenCloth.glb", [115_200, 58_081, 58_081, 960, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0]),
    ("SimpleSparseAccessor.gltf", [12, 14, 14, 14, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0]),
    ("moebius.glb", [448, 280, 280, 112, 0, 4, 0, 0, 0, 1], [1, 0, 0, 0]),
    ("primitive_modes/Mesh_PrimitiveMode_04.gltf", [2, 4, 4, 4, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0]),
    ("primitive_modes/Mesh_PrimitiveMode_05.gltf", [2, 4, 4, 4, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0]),
    ("primitive_modes/Mesh_PrimitiveMode_14.gltf", [2, 4, 4, 4, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0]),
    ("scallop.glb", [120_000, 60_002, 60_002, 0, 0, 0, 0, 0, 1, 1], [1, 0, 0, 0]),
    ("spot.glb", [5856, 3225, 2930, 0, 0, 0, 0, 0, 1, 1], [1, 0, 0, 0]),
    ("spot_catmull_big.glb", [374_784, 187_394, 187_394, 0, 0, 0, 0, 0, 1, 1], [1, 0, 0, 0]),
    ("subpass_scene_opaque.gltf", [11_132, 15_719, 3145, 0, 897, 0, 4100, 0, 9, 12], [70, 0, 0, 0]),
    ("triple_vierbein.glb", [108, 75, 75, 60, 20, 3, 0, 0, 0, 1], [1, 0, 0, 0]),
];

pub(crate) fn tests() -> Vec<Trial> {
    let mut tests = vec![
        on_both("good::corners_are_joined_when_welded_by_data", ["skinned_without_indices.glb", "Fox.glb"], corners),
        on_both("good::instances_are_turned", ["mirrored_scenes.gltf", "subpass_scene_opaque.gltf"], turned),
        test("good::counts_control", control),
    ];
    tests.extend(on_made("good::", GOOD.iter().map(|good| good.name), |path| {
        let good = GOOD.iter().find(|good| path.ends_with(good.name)).ok_or("no row")?;
        file(path, good.counts, good.parts)
    }));
    let names: Vec<_> = ROWS.iter().map(|row| row.0).collect();
    tests.extend(on_files("good::", assets(), &names, |path| {
        let &(_, counts, parts) = ROWS.iter().find(|row| path.ends_with(row.0)).ok_or("no row")?;
        file(path, counts, parts)
    }));
    tests.extend(assets().map(|folder| test("good::table_is_complete", move || table_is_complete(&folder))));
    tests
}

fn open(path: &Path, weld: Weld) -> Result<Asset, String> {
    Asset::open(path, weld).map_err(|error| format!("{}: {error}", path.display()))
}

fn file(path: &Path, counts: [usize; 10], expected: [usize; 4]) -> Outcome {
    let asset = open(path, Weld::Position)?;
    compare(&asset, counts)?;
    let model = asset.model();
    let found = [
        model.instances().len(),
        asset.skins().iter().map(|skin| skin.joints).sum(),
        asset.meshes().iter().map(|mesh| mesh.morph_targets).sum(),
        asset.animations().len(),
    ];
    ensure(found == expected, || format!("instances, joints, targets, animations {found:?}, expected {expected:?}"))?;
    check::asset(&asset, usize::MAX, false)?;
    check::asset(&open(path, Weld::Data)?, 3, false)?;
    check::asset(&open(path, Weld::Keep)?, 0, false)
}

fn compare(asset: &Asset, expected: [usize; 10]) -> Outcome {
    let mut found = [0; 10];
    for (mesh, info) in asset.meshes().iter().enumerate() {
        assert_eq!(info.geometries[0], mesh);
        let geometry = &asset.model().geometries()[mesh];
        if !geometry.faces().is_empty() {
            let before = asset.weld_counts(mesh).map_or(0, |weld| weld.before);
            found.iter_mut().zip(counts(geometry, before)).for_each(|(sum, count)| *sum += count);
        }
    }
    ensure(found == expected, || format!("{found:?}, expected\n{expected:?}"))
}

/// Counted anew from the faces, not by the library's edge records.
fn counts(geometry: &Geometry, vertices: usize) -> [usize; 10] {
    let mut edges: HashMap<[u32; 2], (usize, usize)> = HashMap::new();
    let (mut seen, mut used) = (HashSet::new(), HashSet::new());
    let (mut degenerate, mut duplicate) = (0, 0);
    for &[a, b, c] in geometry.faces() {
        if a == b || b == c || c == a {
            degenerate += 1;
            continue;
        }
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        duplicate += usize::from(!seen.insert(sorted));
        for [from, to] in [[a, b], [b, c], [c, a]] {
            used.insert(from);
            let (up, down) = edges.entry([from.min(to), from.max(to)]).or_default();
            *if from < to { up } else { down } += 1;
        }
    }
    let number = |test: fn(usize, usize) -> bool| edges.values().filter(|&&(up, down)| test(up, down)).count();
    let boundary = number(|up, down| up + down == 1);
    let non_manifold = number(|up, down| up + down > 2);
    let misoriented = number(|up, down| up + down == 2 && up != down);
    let closed = usize::from(boundary == 0 && non_manifold == 0);
    let triangles = geometry.faces().len();
    [triangles, vertices, used.len(), boundary, non_manifold, misoriented, degenerate, duplicate, closed, 1]
}

fn control() -> Outcome {
    let row = GOOD[0].counts;
    let asset = open(&files::made(GOOD[0].name)?.path, Weld::Position)?;
    compare(&asset, row)?;
    for column in 0..row.len() {
        let mut wrong = row;
        wrong[column] += 1;
        let noticed = compare(&asset, wrong).is_err();
        ensure(noticed, || format!("column {column} went unnoticed"))?;
    }
    Ok(())
}

fn table_is_complete(assets: &Path) -> Outcome {
    let mut files = Vec::new();
    for folder in ["", "primitive_modes"] {
        for entry in std::fs::read_dir(assets.join(folder))? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            let extension = Path::new(&name).extension();
            if extension == Some("glb".as_ref()) || extension == Some("gltf".as_ref()) {
                files.push(if folder.is_empty() { name } else { format!("{folder}/{name}") });
            }
        }
    }
    let missing: Vec<_> = files.iter().filter(|file| !ROWS.iter().any(|row| row.0 == **file)).collect();
    ensure(missing.is_empty(), || format!("no row for {missing:?}"))
}

fn corners(path: &Path) -> Outcome {
    let asset = open(path, Weld::Data)?;
    let mesh = asset.model().mesh(&asset.pose(Some(0), 0.5)?)?;
    ensure(mesh.is_closed(), || "open".to_owned())?;
    let unwelded = open(path, Weld::Keep)?;
    let mesh = unwelded.model().mesh(&unwelded.pose(None, 0.0)?)?;
    ensure(!mesh.is_closed(), || "closed without welding".to_owned())?;
    let names: Vec<_> = asset.animations().iter().map(|a| a.name.as_deref().unwrap_or("")).collect();
    ensure(asset.animation_index(names[2]) == Some(2), || format!("{names:?}"))?;
    ensure(asset.animation_index("1") == Some(1), || "by number".to_owned())?;
    ensure(asset.animation_index("3").is_none(), || "past the end".to_owned())
}

/// The catalogue's file has an instance that is mirrored twice, and a skin that is not mirrored is not turned.
fn turned(path: &Path) -> Outcome {
    let asset = open(path, Weld::Data)?;
    let pose = asset.pose(None, 0.0)?;
    let turned = pose.instances().iter().filter(|instance| instance.faces_turned()).count();
    let expected = pose.instances().len() - usize::from(path.ends_with("mirrored_scenes.gltf"));
    ensure(turned == expected, || format!("{turned} are turned, not {expected}"))?;
    let upright = open(&files::made("skinned.glb")?.path, Weld::Data)?.pose(None, 0.0)?;
    ensure(!upright.instances().iter().any(InstancePose::faces_turned), || "a body is turned".to_owned())
}
