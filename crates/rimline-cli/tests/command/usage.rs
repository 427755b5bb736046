//! Help of the command, and its messages and exit codes when it is used wrongly.

use super::npz_input::tetrahedron;
use super::run::{folder, is_empty, read_file, rimline, rimline_with, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("usage::help_names_commands_and_codes", help),
    ("usage::wrong_options_end_with_2", wrong_options),
    ("usage::unknown_adapters_end_with_3", unknown_adapter),
    ("usage::without_any_adapter", no_adapter),
    ("usage::unwritable_places_end_with_4", unwritable),
    ("usage::an_old_result_survives_a_failure", old_result),
    ("usage::missing_files_end_with_1", missing_file),
];

fn help() -> Outcome {
    let run = rimline(["--help"]);
    run.expect(0, &[])?;
    let commands = ["draw", "shadow", "film", "extract", "query", "info", "devices", "verify", "bench"];
    for part in commands.into_iter().chain(["Exit codes: 0 done, 1 bad input"]) {
        ensure!(run.stdout.contains(part), "the help lacks `{part}`: {}", run.stdout);
    }
    for command in commands {
        let run = rimline([command, "--help"]);
        run.expect(0, &[])?;
        ensure!(run.stdout.contains("Usage: rimline"), "{}", run.stdout);
    }
    let version = rimline(["--version"]);
    version.expect(0, &[])?;
    ensure!(version.stdout.starts_with("rimline "), "{} is not the command's name", version.stdout);
    rimline::<&str>([]).expect(2, &["Usage"])
}

fn wrong_options() -> Outcome {
    let folder = folder();
    folder.write("model.npz", tetrahedron())?;
    let results = folder.inner("results")?;
    let cases = [
        ("extract", "", "--light"),
        ("extract", "--light sun:1,2,3", "sun"),
        ("extract", "--light point:1,2", "point:1,2"),
        ("extract", "--light point:1,2,1e39", "point:1,2,1e39"),
        ("extract", "--light point:1,2,nan", "point:1,2,nan"),
        ("extract", "--light dir:0,0,-0", "zero"),
        ("extract", "--light hom:0,0,0,0", "zero"),
        ("extract", "--light dir:0,1,0 --light dir:", "dir:"),
        ("extract", "--light file:all", "no lights"),
        ("extract", "--light file:lamp", "lamp"),
        ("extract", "--light dir:0,1,0 --animation Run", "Run"),
        ("extract", "--light dir:0,1,0 --time nan", "nan"),
        ("extract", "--light dir:0,1,0 --method best", "best"),
        ("extract", "--light dir:0,1,0 --predicate rough", "rough"),
        ("extract", "--light dir:0,1,0 --method per-edge --predicate exact", "no exact form"),
        ("extract", "--light dir:0,1,0 --weld data --no-weld", "--no-weld"),
        ("extract", "--light dir:0,1,0 --device cpu --displace a.wgsl", "--displace"),
        ("draw", "--device cpu", "GPU"),
        ("draw", "--size 0x10", "pixel"),
        ("draw", "--size 10", "1280x960"),
        ("draw", "--size 4000000000x10", "4000000000x10"),
        ("draw", "--fov 180", "180"),
        ("draw", "--eye 1,2", "1,2"),
        ("draw", "--eye 1,2,3 --target 1,2,3", "--target"),
    ];
    for (command, options, part) in cases {
        let run = folder.run(&format!("{command} @model.npz --out @results/out {options}"));
        run.expect(2, &[part]).map_err(|error| format!("{command} {options}: {error}"))?;
        is_empty(&results).map_err(|error| format!("{command} {options}: {error}"))?;
    }
    let many = "--light dir:0,1,0 ".repeat(1025);
    folder.run(&format!("extract @model.npz --out @results/out {many}")).expect(2, &["1025", "1024"])
}

/// Extracts the tetrahedron with further options; the folder is for its files.
fn extract(folder: &std::path::Path, out: &str, options: &[&str], variables: &[(&str, &str)]) -> super::run::Run {
    let model = folder.join("model.npz");
    std::fs::write(&model, tetrahedron()).expect("there is room");
    let (model, out) = (model.to_string_lossy().into_owned(), folder.join(out).to_string_lossy().into_owned());
    let line = ["extract", &model, "--light", "dir:0,1,0", "--out", &out];
    rimline_with(line.iter().chain(options), variables)
}

fn unknown_adapter() -> Outcome {
    let folder = folder();
    let run = extract(folder.path(), "out.npz", &["--device", "no such adapter"], &[]);
    run.expect(3, &["no such adapter"])
}

/// wgpu's own variable hides all adapters.
pub(crate) const HIDDEN: &[(&str, &str)] = &[("WGPU_BACKEND", "noop")];

fn no_adapter() -> Outcome {
    let folder = folder();
    let run = rimline_with(["devices"], HIDDEN);
    run.expect(3, &["--device cpu"])?;
    extract(folder.path(), "a.npz", &["--device", "gpu"], HIDDEN).expect(3, &["--device cpu"])?;
    extract(folder.path(), "b.npz", &["--device", "auto"], HIDDEN).expect(0, &["on the CPU"])?;
    ensure!(!folder.path().join("a.npz").exists(), "there is a result without a device");
    ensure!(folder.path().join("b.npz").exists(), "there is no result");
    Ok(())
}

fn unwritable() -> Outcome {
    let folder = folder();
    for out in ["no/such/folder.npz", "."] {
        extract(folder.path(), out, &["--device", "cpu"], &[])
            .expect(4, &["cannot be written"])
            .map_err(|error| format!("{out}: {error}"))?;
    }
    Ok(())
}

fn old_result() -> Outcome {
    let folder = folder();
    let out = folder.path().join("out.npz");
    write_file(&out, "an older result")?;
    extract(folder.path(), "out.npz", &["--device", "no such adapter"], &[]).expect(3, &[])?;
    let left = read_file(&out)?;
    ensure!(left == b"an older result", "the older result is gone");
    extract(folder.path(), "out.npz", &["--device", "cpu"], &[]).expect(0, &[])?;
    let names = std::fs::read_dir(folder.path()).map_err(|error| error.to_string())?.count();
    ensure!(names == 2, "{names} files instead of the model and the result");
    Ok(())
}

fn missing_file() -> Outcome {
    for file in ["missing.glb", "missing.npz", "missing"] {
        let run = rimline(["info", file]);
        run.expect(1, &[file])?;
        ensure!(run.stderr.matches(file).count() == 1, "the file is named more than once: {}", run.stderr);
    }
    Ok(())
}
