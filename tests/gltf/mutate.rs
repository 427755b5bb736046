//! Mutated files: whatever is changed in a good file, loading returns, and what it accepts is sound.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use libtest_mimic::{Failed, Trial};
use rimline::gltf::Asset;
use rimline::mesh::Weld;
use rimline_models::catalogue::GOOD;
use rimline_testkit::assets;

use crate::maker::{everything, glb};
use crate::{Outcome, check, ensure, test};

/// Small, so that many cases take little time.
const FILES: &[&str] = &[
    "22_vertex_color.glb",
    "AnimatedMorphCube.glb",
    "Box.glb",
    "InterpolationTest.glb",
    "SimpleSparseAccessor.gltf",
    "moebius.glb",
    "primitive_modes/Mesh_PrimitiveMode_04.gltf",
    "primitive_modes/Mesh_PrimitiveMode_05.gltf",
    "primitive_modes/Mesh_PrimitiveMode_14.gltf",
    "triple_vierbein.glb",
];
/// Rarely, for their skins.
const LARGE: &[&str] = &["CesiumMan.glb", "Fox.glb"];

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("mutate::control", control),
        test("mutate::hand_made", || {
            let seeds = [everything().glb(), everything().gltf()].map(|bytes| Seed { bytes, base: None });
            run(&seeds, &[], cases() / 2)
        }),
        test("mutate::catalogue", || {
            let folder = tempfile::tempdir()?;
            let paths = GOOD.iter().map(|good| good.write(folder.path())).collect::<Result<Vec<_>, _>>()?;
            let (small, large): (Vec<_>, Vec<_>) =
                seeds(paths)?.into_iter().partition(|seed| seed.bytes.len() < 20_000);
            let middle: Vec<_> = large.into_iter().filter(|seed| seed.bytes.len() < 1_000_000).collect();
            run(&small, &middle, cases() / 2)
        }),
        Trial::test("mutate::real files", || {
            let folder = assets().ok_or("there are no models")?;
            let read = |names: &[&str]| seeds(names.iter().map(|name| folder.join(name)));
            run(&read(FILES)?, &read(LARGE)?, cases() / 2)
        })
        .with_ignored_flag(assets().is_none()),
    ]
}

fn seeds(paths: impl IntoIterator<Item = PathBuf>) -> std::io::Result<Vec<Seed>> {
    let read = |path: PathBuf| Ok(Seed { bytes: std::fs::read(&path)?, base: path.parent().map(Path::to_owned) });
    paths.into_iter().map(read).collect()
}

/// Twice the number of cases of a test.
fn cases() -> usize {
    if std::env::var_os("RIMLINE_LONG").is_some() { 100_000 } else { 2_000 }
}

struct Seed {
    bytes: Vec<u8>,
    base: Option<PathBuf>,
}

/// `RIMLINE_SEED`, else a fixed one.
fn first_seed() -> u64 {
    let given = std::env::var("RIMLINE_SEED").ok().and_then(|text| text.parse().ok());
    given.unwrap_or(0x005e_ed0f_61f7)
}

fn run(small: &[Seed], large: &[Seed], cases: usize) -> Outcome {
    let first = first_seed();
    println!("mutate: {cases} cases from RIMLINE_SEED={first}");
    let mut accepted = 0;
    for case in 0..cases {
        let mut random = Random(first.wrapping_add(case as u64));
        let seeds = if !large.is_empty() && random.below(50) == 0 { large } else { small };
        let seed = &seeds[random.below(seeds.len())];
        let bytes = mutated(&seed.bytes, &mut random);
        match holds(&bytes, seed.base.as_deref()) {
            Ok(loaded) => accepted += usize::from(loaded),
            Err(message) => return Err(format!("case {case} of seed {first}: {message}").into()),
        }
    }
    println!("mutate: {accepted} of {cases} cases were accepted");
    // Were nothing accepted, the checks on what loads would never have run.
    ensure(accepted * 20 > cases, || format!("only {accepted} of {cases} were accepted"))?;
    ensure(accepted * 20 < cases * 19, || format!("{accepted} of {cases} were accepted: hardly mutated"))
}

/// Whether the file loads; an error for a panic or an unsound model.
fn holds(bytes: &[u8], base: Option<&Path>) -> Result<bool, String> {
    let weld = if bytes.len().is_multiple_of(2) { Weld::Data } else { Weld::Position };
    guarded(|| match Asset::from_slice(bytes, base, weld) {
        Ok(asset) => check::asset(&asset, 2, true).map(|()| true),
        Err(error) => ensure(error.to_string().len() < 500, || "a long message".to_owned()).map(|()| false),
    })
}

fn guarded(run: impl FnOnce() -> Result<bool, Failed>) -> Result<bool, String> {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(result) => result.map_err(|failed| failed.message().unwrap_or("unsound").to_owned()),
        Err(_) => Err("it panicked".to_owned()),
    }
}

/// `SplitMix64` (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next_u64() % count.max(1) as u64) as usize
    }
}

fn mutated(file: &[u8], random: &mut Random) -> Vec<u8> {
    let (mut json, mut binary) = split(file);
    // Mostly one change: more tend to break the JSON before anything deeper is reached.
    let changes = if random.below(4) == 0 { 3 } else { 1 };
    for _ in 0..changes {
        match random.below(16) {
            0 => flip(&mut json, random),
            1..=5 => flip(&mut binary, random),
            6 => {
                let part = if random.below(2) == 0 { &mut json } else { &mut binary };
                part.truncate(random.below(part.len() + 1));
            }
            7..=10 => copy_number(&mut json, random),
            _ => replace_number(&mut json, random),
        }
    }
    if !file.starts_with(b"glTF") {
        return json;
    }
    let mut file = glb(&json, &binary);
    match random.below(20) {
        0 => file.truncate(random.below(file.len())),
        1 => flip(&mut file, random),
        2 => {
            let at = random.below(28);
            file[at] = random.next_u64() as u8;
        }
        _ => {}
    }
    file
}

/// JSON and binary chunk, or text alone.
fn split(file: &[u8]) -> (Vec<u8>, Vec<u8>) {
    if !file.starts_with(b"glTF") {
        return (file.to_vec(), Vec::new());
    }
    let word = |at: usize| u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]]) as usize;
    let json = 20 + word(12);
    let binary = file.get(json + 8..).unwrap_or_default();
    (file[20..json].to_vec(), binary.to_vec())
}

fn flip(bytes: &mut [u8], random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        bytes[at] ^= 1 << random.below(8);
    }
}

/// Where the runs of digits lie.
fn numbers(json: &[u8]) -> Vec<std::ops::Range<usize>> {
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, _) in json.iter().enumerate().filter(|(_, byte)| byte.is_ascii_digit()) {
        match runs.last_mut() {
            Some(run) if run.end == at => run.end += 1,
            _ => runs.push(at..at + 1),
        }
    }
    runs
}

fn replace_number(json: &mut Vec<u8>, random: &mut Random) {
    let runs = numbers(json);
    if runs.is_empty() {
        return;
    }
    let run = runs[random.below(runs.len())].clone();
    let old = String::from_utf8_lossy(&json[run.clone()]).into_owned();
    let value: u64 = old.parse().unwrap_or(0);
    let new = match random.below(16) {
        0 => "0".to_owned(),
        1 => "-1".to_owned(),
        2 => "18446744073709551615".to_owned(),
        3 => "4294967295".to_owned(),
        4 => "9007199254740993".to_owned(),
        5 => "1e30".to_owned(),
        6 => format!("{old}0"),
        7 => format!("{old}000000"),
        8 => value.saturating_sub(1).to_string(),
        9 => "null".to_owned(),
        10 => value.saturating_mul(2).to_string(),
        11..=13 => random.below(12).to_string(),
        _ => value.saturating_add(1).to_string(),
    };
    json.splice(run, new.into_bytes());
}

/// Puts one number of the file in another's place.
fn copy_number(json: &mut Vec<u8>, random: &mut Random) {
    let runs = numbers(json);
    if runs.is_empty() {
        return;
    }
    let from = json[runs[random.below(runs.len())].clone()].to_vec();
    json.splice(runs[random.below(runs.len())].clone(), from);
}

/// The harness notices a panic and an unsound model, and its mutations change something.
fn control() -> Outcome {
    let caught = guarded(|| std::panic::resume_unwind(Box::new("on purpose")));
    ensure(caught.is_err(), || "a panic went unnoticed".to_owned())?;
    let unsound = guarded(|| Err("on purpose".into()));
    ensure(unsound.is_err(), || "an unsound model went unnoticed".to_owned())?;
    let file = everything().glb();
    ensure(holds(&file, None) == Ok(true), || "the unmutated file is not sound".to_owned())?;
    let same = (0..200).filter(|&seed| mutated(&file, &mut Random(seed)) == file).count();
    ensure(same < 20, || format!("{same} of 200 mutations changed nothing"))
}
