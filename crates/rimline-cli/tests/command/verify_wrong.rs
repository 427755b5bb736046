//! `rimline verify` where something is wrong: one bit, a broken file, a name that is taken.

use std::path::Path;

use super::archive::{Entry, read_zip, words, write_zip};
use super::npz_input::tetrahedron;
use super::run::{folder, is_empty, read_file, rimline, write_file};
use super::verify::{check, contents, make, one_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("verify::one_flipped_bit_is_found_and_named", flipped_bits),
    ("verify::a_device_that_rounds_would_be_noticed", rounded),
    ("verify::other_arrays_and_bytes_are_noticed", other_archives),
    ("verify::broken_files_are_named_and_the_others_checked", broken_files),
    ("verify::nothing_to_check_is_an_error", nothing),
    ("verify::make_writes_over_nothing", written_over),
];

fn text<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

/// The archive with one of its entries changed; checksums are right.
fn changed(archive: &[u8], name: &str, change: impl FnOnce(&mut Entry)) -> Result<Vec<u8>, String> {
    let mut entries = read_zip(archive)?;
    let entry = entries.iter_mut().find(|entry| entry.name == format!("{name}.npy")).ok_or("no such entry")?;
    change(entry);
    Ok(write_zip(&entries))
}

fn flipped_bits() -> Outcome {
    let folder = folder();
    let good = one_file(folder.path(), "one.npz")?;
    let one = folder.path().join("one");
    check(&one, &[], 0)?;
    // Two words a row, so row 5 and light 33 are bit 1 of word 11.
    for name in ["facing", "silhouette", "winding"] {
        let bad = changed(&good, name, |entry| {
            let data = entry.bytes.len() - (entry.bytes.len() - 128) / 8 * 8;
            entry.bytes[data + 4 * 11] ^= 2;
        })?;
        write_file(one.join("one.npz"), bad)?;
        let json = check(&one, &[], 5)?;
        ensure!(json["equal"] == false, "{json:#}");
        let results = json["files"][0]["results"].as_array().ok_or("no results")?;
        ensure!(results.len() > 1, "no GPU: {json:#}");
        for result in results {
            let [found] = &result["differences"].as_array().ok_or("no differences")?[..] else {
                return Err(format!("not one difference: {result:#}"));
            };
            ensure!(found["array"] == name && found["wrong_bits"] == 1, "{name}: {found:#}");
            ensure!(found["row"] == 5 && found["light"] == 33, "{name}: {found:#}");
        }
        let run = folder.run("verify @one");
        run.expect(5, &["other bits"])?;
        for part in ["one.npz", "1 BIT", &format!("`{name}` has 1 bit otherwise"), "row 5", "light 33", "NOT all equal"]
        {
            ensure!(run.stdout.contains(part), "the table lacks `{part}`: {}", run.stdout);
        }
    }
    Ok(())
}

/// Bits that `f32` arithmetic finds, as a device that is not exact would.
fn rounded() -> Outcome {
    let folder = folder();
    let [made, one] = ["made", "one"].map(|name| folder.path().join(name));
    make(&made, &["--faces".as_ref(), "500".as_ref()])?;
    std::fs::create_dir(&one).map_err(text)?;
    let plate = made.join("stress-plate-all.npz");
    let entries = read_zip(&read_file(&plate)?)?;
    let lights = entries.iter().find(|entry| entry.name == "lights.npy").ok_or("no lights")?;
    let lights: Vec<f32> = words(&lights.bytes[128..]).into_iter().map(f32::from_bits).collect();
    let specs = lights.chunks(4).map(|l| format!("--light=hom:{:?},{:?},{:?},{:?}", l[0], l[1], l[2], l[3]));
    let specs: Vec<String> = specs.collect();
    for (predicate, code) in [("exact", 0), ("fast", 5)] {
        let out = one.join("one.npz");
        let mut line = vec!["extract".as_ref(), plate.as_os_str(), "--no-weld".as_ref(), "--out".as_ref()];
        line.extend([out.as_os_str(), "--device".as_ref(), "cpu".as_ref(), "--predicate".as_ref(), predicate.as_ref()]);
        rimline(line.into_iter().chain(specs.iter().map(AsRef::as_ref))).expect(0, &[])?;
        let json = check(&one, &[], code)?;
        for result in json["files"][0]["results"].as_array().ok_or("no results")? {
            let arrays = result["differences"].as_array().ok_or("no differences")?;
            let has_facing = arrays.iter().any(|difference| difference["array"] == "facing");
            ensure!(has_facing == (predicate == "fast"), "{predicate}: {result:#}");
        }
    }
    Ok(())
}

fn other_archives() -> Outcome {
    let folder = folder();
    let good = one_file(folder.path(), "one.npz")?;
    let one = folder.path().join("one");
    let entries = read_zip(&good)?;
    let fewer = write_zip(&entries[..entries.len() - 1]);
    // Kinds as 32 bits, and other bytes around equal arrays.
    let wider = changed(&good, "edge_kind", |entry| {
        let header = String::from_utf8_lossy(&entry.bytes[..128]).len();
        let at = entry.bytes[..header].windows(3).position(|part| part == b"|u1").unwrap_or_default();
        entry.bytes[at..at + 3].copy_from_slice(b"|i1");
    })?;
    for (archive, message) in
        [(fewer, "its arrays are positions"), (wider, "`edge_kind` is |i1"), (write_zip(&entries), "did not write it")]
    {
        write_file(one.join("one.npz"), archive)?;
        let run = folder.run("verify @one --device cpu");
        run.expect(5, &["other bits"])?;
        ensure!(run.stdout.contains(message), "the table lacks `{message}`: {}", run.stdout);
    }
    Ok(())
}

fn broken_files() -> Outcome {
    let folder = folder();
    let good = one_file(folder.path(), "good.npz")?;
    let one = folder.path().join("one");
    let mut stale = good.clone();
    let last = stale.windows(11).position(|part| part == b"winding.npy").ok_or("no winding")? + 11 + 128;
    stale[last] ^= 1;
    for (name, bytes, message) in [
        ("garbage.npz", b"nothing of the kind".to_vec(), "ZIP"),
        ("short.npz", good[..good.len() / 2].to_vec(), "ZIP"),
        ("no_lights.npz", tetrahedron(), "`lights`"),
        ("checksum.npz", stale, "`winding`"),
        ("no_lamp.npz", changed(&good, "lights", |entry| entry.bytes[128..144].fill(0))?, "light 0 is"),
        ("index.npz", changed(&good, "faces", |entry| entry.bytes[130] = 0x7f)?, "names vertex"),
    ] {
        let file = one.join(name);
        write_file(&file, bytes)?;
        let run = folder.run("verify @one --device cpu");
        run.expect(1, &["could not be done", name, message])?;
        ensure!(run.stdout.contains("cannot be checked") && run.stdout.contains("equal"), "{name}: {}", run.stdout);
        let json = check(&one, &["--device", "cpu"], 1)?;
        let files = json["files"].as_array().ok_or("no files")?;
        ensure!(files.len() == 2 && json["equal"] == false, "{name}: {json:#}");
        for file in files {
            let is_good = file["file"] == "good.npz";
            ensure!(file["error"].is_null() == is_good, "{name}: {file:#}");
        }
        std::fs::remove_file(file).map_err(text)?;
    }
    Ok(())
}

fn nothing() -> Outcome {
    let folder = folder();
    let empty = folder.inner("empty")?;
    folder.run("verify @empty").expect(1, &["empty", "no .npz", "--make"])?;
    write_file(empty.join(".half.npz.77.part"), b"")?;
    write_file(empty.join(".half.npz"), b"")?;
    folder.run("verify @empty").expect(1, &["no .npz"])?;
    folder.run("verify @missing").expect(1, &["missing", "cannot be read"])?;
    folder.write("file", b"")?;
    folder.run("verify @file").expect(1, &["not a folder", "give the folder"])?;
    one_file(folder.path(), "one.npz")?;
    for (options, code, message) in [
        ("--device nonesuch", 3, "nonesuch"),
        ("model.glb", 2, "--make"),
        ("--faces 7", 2, "--make"),
        ("--make --json", 2, "--json"),
    ] {
        folder.run(&format!("verify @one {options}")).expect(code, &[message])?;
    }
    Ok(())
}

fn written_over() -> Outcome {
    let folder = folder();
    let [model, made] = ["model.npz", "made"].map(|name| folder.path().join(name));
    write_file(&model, tetrahedron())?;
    let small = ["--faces", "12"].map(AsRef::as_ref);
    let options = [&[model.as_os_str()], &small[..]].concat();
    make(&made, &options)?;
    let before = contents(&made)?;
    ensure!(
        before.contains_key("model.npz") && before.len() == rimline_testkit::stress::names().len() + 1,
        "{:?}",
        before.keys()
    );
    let again = |options: &[&std::ffi::OsStr]| {
        rimline(["verify".as_ref(), "--make".as_ref(), made.as_os_str()].iter().chain(options))
    };
    again(&options).expect(4, &["model.npz", "exists", "written over"])?;
    again(&small).expect(4, &["stress-", "exists"])?;
    ensure!(contents(&made)? == before, "something was written over");
    // Nothing is left of what cannot be made.
    let other = folder.path().join("other");
    std::fs::create_dir(&other).map_err(text)?;
    let make_other = |models: [&Path; 2]| {
        let line = ["verify".as_ref(), "--make".as_ref(), other.as_os_str()];
        rimline(line.into_iter().chain(models.map(Path::as_os_str)))
    };
    let twin = folder.path().join("twin");
    std::fs::create_dir(&twin).map_err(text)?;
    std::fs::copy(&model, twin.join("model.npz")).map_err(text)?;
    make_other([&model, &twin.join("model.npz")]).expect(1, &["same name", "model.npz"])?;
    is_empty(&other)?;
    write_file(&model, b"PK")?;
    make_other([&model, &twin.join("other.npz")]).expect(1, &["model.npz"])?;
    is_empty(&other)
}
