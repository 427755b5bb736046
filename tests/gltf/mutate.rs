//! Mutated files: whatever is changed in a good file, loading returns, and what it accepts is sound.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use libtest_mimic::{Failed, Trial};
use rimline::gltf::Asset;
use rimline::mesh::Weld;
use rimline_models::catalogue::GOOD;
use rimline_testkit::random::Random;
use rimline_testkit::{assets, mutate};
use serde_json::Value;

use crate::maker::everything;
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
            let seeds = [everything().glb(), everything().gltf()].map(|bytes| Seed::new(&bytes, None));
            run(&seeds, &[], cases() / 2)
        }),
        test("mutate::catalogue", || {
            let folder = tempfile::tempdir()?;
            let paths = GOOD.iter().map(|good| good.write(folder.path())).collect::<Result<Vec<_>, _>>()?;
            let (small, large): (Vec<_>, Vec<_>) = seeds(paths)?.into_iter().partition(|seed| seed.length < 20_000);
            let middle: Vec<_> = large.into_iter().filter(|seed| seed.length < 1_000_000).collect();
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
    paths.into_iter().map(|path| Ok(Seed::new(&std::fs::read(&path)?, path.parent()))).collect()
}

/// Twice the number of cases of a test.
fn cases() -> usize {
    if std::env::var_os("RIMLINE_LONG").is_some() { 100_000 } else { 2_000 }
}

struct Seed {
    json: Value,
    binary: Vec<u8>,
    length: usize,
    base: Option<PathBuf>,
}

impl Seed {
    fn new(file: &[u8], base: Option<&Path>) -> Self {
        let (json, binary) = mutate::split_gltf(file);
        Self { json, binary, length: file.len(), base: base.map(Path::to_owned) }
    }

    /// Mostly one change: more tend to refuse the file before anything deeper is reached.
    fn mutated(&self, random: &mut Random) -> Vec<u8> {
        let (mut json, mut binary) = (self.json.clone(), self.binary.clone());
        for _ in 0..if random.below(4) == 0 { 3 } else { 1 } {
            if binary.is_empty() || random.below(3) > 0 {
                mutate::value(&mut json, random);
            } else {
                mutate::bytes(&mut binary, random);
            }
        }
        mutate::gltf(&json, &binary, !self.binary.is_empty(), random)
    }
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
        let mut random = Random::new(first.wrapping_add(case as u64));
        let seeds = if !large.is_empty() && random.below(50) == 0 { large } else { small };
        let seed = &seeds[random.below(seeds.len())];
        match holds(&seed.mutated(&mut random), seed.base.as_deref()) {
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

/// The harness notices a panic and an unsound model, and its mutations change something.
fn control() -> Outcome {
    let caught = guarded(|| std::panic::resume_unwind(Box::new("on purpose")));
    ensure(caught.is_err(), || "a panic went unnoticed".to_owned())?;
    let unsound = guarded(|| Err("on purpose".into()));
    ensure(unsound.is_err(), || "an unsound model went unnoticed".to_owned())?;
    let file = everything().glb();
    ensure(holds(&file, None) == Ok(true), || "the unmutated file is not sound".to_owned())?;
    let seed = Seed::new(&file, None);
    let same = (0..200).filter(|&number| seed.mutated(&mut Random::new(number)) == file).count();
    ensure(same < 20, || format!("{same} of 200 mutations changed nothing"))
}
