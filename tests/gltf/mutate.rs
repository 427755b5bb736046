//! Mutated files: after any change of a good file, loading returns, and what it accepts is sound.

use std::panic::catch_unwind;
use std::path::Path;

use libtest_mimic::{Failed, Trial};
use rimline::gltf::Asset;
use rimline::mesh::Weld;
use rimline_models::catalogue::GOOD;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, mutate};
use serde_json::Value;

use crate::maker::everything;
use crate::{Outcome, check, ensure, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![test("mutate::what_is_accepted_is_sound", run)]
}

fn run() -> Outcome {
    let folder = tempfile::tempdir()?;
    let base = folder.path();
    let mut files = vec![everything().glb(), everything().gltf()];
    for good in GOOD {
        files.push(std::fs::read(good.write(base)?)?);
    }
    files.retain(|file| file.len() < 1_000_000);
    let (small, large): (Vec<_>, Vec<_>) = files.into_iter().partition(|file| file.len() < 20_000);
    let [small, large] = [small, large].map(|of| of.iter().map(|file| mutate::split_gltf(file)).collect::<Vec<_>>());
    let (first, cases, mut accepted) = (0x005e_ed0f_61f7, if is_long() { 100_000_u64 } else { 2000 }, 0);
    for case in 0..cases {
        let mut random = Random::new(first + case);
        // Large files take time.
        let seeds = if random.below(50) == 0 { &large } else { &small };
        let (json, binary) = seeds[random.below(seeds.len())].clone();
        let file = mutated(json, binary, &mut random);
        match catch_unwind(|| is_accepted(&file, base)) {
            Ok(Ok(is_one)) => accepted += u64::from(is_one),
            Ok(Err(failed)) => return Err(format!("case {case}: {}", failed.message().unwrap_or_default()).into()),
            Err(_) => return Err(format!("case {case}: it panicked").into()),
        }
    }
    // Were nothing accepted, the checks on what loads would never have run.
    let are_some = (cases / 20 + 1..cases * 19 / 20).contains(&accepted);
    ensure(are_some, || format!("{accepted} of {cases} were accepted"))
}

/// Mostly one change: more tend to refuse the file before anything deeper is reached.
fn mutated(mut json: Value, mut binary: Vec<u8>, random: &mut Random) -> Vec<u8> {
    let is_glb = !binary.is_empty();
    for _ in 0..if random.below(4) == 0 { 3 } else { 1 } {
        if binary.is_empty() || random.below(3) > 0 {
            mutate::value(&mut json, random);
        } else {
            mutate::bytes(&mut binary, random);
        }
    }
    mutate::gltf(&json, &binary, is_glb, random)
}

/// Whether the file loads; an error for an unsound model.
fn is_accepted(bytes: &[u8], base: &Path) -> Result<bool, Failed> {
    let weld = if bytes.len().is_multiple_of(2) { Weld::Data } else { Weld::Position };
    match Asset::from_slice(bytes, Some(base), weld) {
        Ok(asset) => check::asset(&asset, 2, true).map(|()| true),
        Err(error) => ensure(error.to_string().len() < 500, || format!("a long message: {error}")).map(|()| false),
    }
}
