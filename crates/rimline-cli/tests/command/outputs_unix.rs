//! Results and the file system's own ways: links, rights, pipes, devices, long names.

use std::ffi::OsString;
use std::fs::{self, File};
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Stdio};

use super::archive::{array, write_zip};
use super::npz_input::tetrahedron;
use super::outputs::{extraction, refused};
use super::own_gltf::{self, Names};
use super::run::{folder, read_file, rimline, rimline_with, write_file};
use super::usage::HIDDEN;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("outputs_unix::no_input_is_written_over", inputs),
    ("outputs_unix::no_input_of_a_film_or_mask_is_written_over", numbered),
    ("outputs_unix::links_stay_and_lead_to_the_result", links),
    ("outputs_unix::a_replaced_file_keeps_its_rights", rights),
    ("outputs_unix::a_protected_file_is_not_replaced", protected),
    ("outputs_unix::pipes_are_written_through", pipe),
    ("outputs_unix::standard_output_gets_the_result_alone", standard_output),
    ("outputs_unix::a_dash_is_standard_output", dash),
    ("outputs_unix::what_is_in_the_way_is_named", in_the_way),
    ("outputs_unix::a_full_device_is_an_error_of_one_line", full),
    ("outputs_unix::parts_of_killed_runs_block_nothing", stale_part),
    ("outputs_unix::the_longest_names_work", long_names),
];

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// The result as it should be.
fn expected(line: &[OsString], folder: &Path) -> Result<Vec<u8>, String> {
    let plain = folder.join("expected.npz");
    let place = line.iter().position(|word| word == "--out").ok_or("no --out")? + 1;
    let mut line = line.to_vec();
    line[place] = plain.clone().into();
    rimline(line).expect(0, &[])?;
    let bytes = read_file(&plain)?;
    fs::remove_file(&plain).map_err(text)?;
    Ok(bytes)
}

fn inputs() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let model = own_gltf::write(folder.path(), &Names::default())?;
    let points = write_zip(&[array("points", "<f4", "False", "(1, 3)", &[0; 12])]);
    write_file(at("points.npz"), points)?;
    write_file(at("wave"), "fn displace(p: vec3<f32>, v: u32, t: f32) -> vec3<f32> { return p; }")?;
    fs::create_dir(at("below")).map_err(text)?;
    for (link, to) in [("link", "body.gltf"), ("texture", "skin.png"), ("buffer", "body.bin"), ("bytes", "points.npz")]
    {
        symlink(to, at(link)).map_err(text)?;
    }
    fs::hard_link(&model, at("hard")).map_err(text)?;
    fs::hard_link(at("body.bin"), at("hard_buffer")).map_err(text)?;
    fs::hard_link(at("wave"), at("hard_wave")).map_err(text)?;
    let extract = ["extract", "--device", "cpu", "--light", "dir:0,1,0"];
    let query = ["query", "--device", "cpu", "--light", "dir:0,1,0", "--points", "{}/points.npz"];
    let draw = ["draw", "--displace", "{}/wave"];
    let shadow = ["shadow", "--displace", "{}/wave"];
    let lines: [(&[&str], &str); 14] = [
        (&extract, "below/../hard"),
        (&extract, "link"),
        (&extract, "hard"),
        (&extract, "hard_buffer"),
        (&extract, "buffer"),
        (&query, "points.npz"),
        (&query, "bytes"),
        (&query, "texture"),
        (&draw, "skin.png"),
        (&draw, "texture"),
        (&draw, "wave"),
        (&draw, "hard_wave"),
        (&shadow, "skin.png"),
        (&shadow, "hard_wave"),
    ];
    for (line, out) in lines {
        let place = folder.path().to_string_lossy().into_owned();
        let line = line.iter().map(|word| OsString::from(word.replace("{}", &place)));
        let line = line.chain([model.clone().into(), "--out".into(), at(out).into()]);
        // No device is opened before: without any the message would be another.
        refused(folder.path(), 2, &[out, "is an input"], || rimline_with(line, HIDDEN))
            .map_err(|error| format!("{out}: {error}"))?;
    }
    // The input comes through standard input.
    let script = "exec \"$0\" draw - --out \"$1/copy\" < \"$1/model.npz\"";
    write_file(at("model.npz"), tetrahedron())?;
    fs::hard_link(at("model.npz"), at("copy")).map_err(text)?;
    refused(folder.path(), 2, &["is an input"], || shell(script, &[folder.path()]))
}

/// Runs a script whose `$0` is the command.
fn shell(script: &str, arguments: &[&Path]) -> super::run::Run {
    let output = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_rimline")])
        .args(arguments)
        .output()
        .expect("there is a shell");
    super::run::Run {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

fn numbered() -> Outcome {
    let folder = folder();
    let names = Names { texture: "0001.png", buffer: "mask.0.png", ..Names::default() };
    let model = own_gltf::write(folder.path(), &names)?;
    let film = ["film", "--frames", "2", "--out"].map(OsString::from);
    let film = film.into_iter().chain([folder.path().into(), model.clone().into()]);
    refused(folder.path(), 2, &["0001.png", "is an input"], || rimline_with(film, HIDDEN))?;
    let mask = ["shadow".into(), "--mask".into(), folder.path().join("mask").into_os_string(), model.into()];
    refused(folder.path(), 2, &["mask.0.png", "is an input"], || rimline_with(mask, HIDDEN))
}

fn links() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("there")).map_err(text)?;
    write_file(at("there/old"), "old")?;
    symlink("there/old", at("to_file")).map_err(text)?;
    symlink("there/new", at("second")).map_err(text)?;
    symlink("second", at("dangling")).map_err(text)?;
    for (link, target) in [("to_file", "there/old"), ("dangling", "there/new")] {
        let line = extraction(folder.path(), &at(link))?;
        let bytes = expected(&line, folder.path())?;
        rimline(line).expect(0, &[])?;
        let is_link = at(link).symlink_metadata().is_ok_and(|there| there.is_symlink());
        ensure!(is_link, "{link} is no link any more");
        ensure!(read_file(at(target))? == bytes, "{target} does not hold the result");
    }
    symlink("loop", at("loop")).map_err(text)?;
    symlink("nowhere/new", at("astray")).map_err(text)?;
    for out in ["loop", "astray"] {
        let line = extraction(folder.path(), &at(out))?;
        refused(folder.path(), 4, &[out, "cannot be written"], || rimline(line))?;
    }
    Ok(())
}

fn rights() -> Outcome {
    let folder = folder();
    let out = folder.path().join("out.npz");
    write_file(&out, "old")?;
    for mode in [0o600, 0o664, 0o751] {
        fs::set_permissions(&out, fs::Permissions::from_mode(mode)).map_err(text)?;
        rimline(extraction(folder.path(), &out)?).expect(0, &[])?;
        let there = out.metadata().map_err(text)?.permissions().mode() & 0o7777;
        ensure!(there == mode, "{there:o} instead of {mode:o}");
        ensure!(read_file(&out)? != b"old", "nothing was written");
    }
    // A new file has what the user's mask leaves.
    fs::remove_file(&out).map_err(text)?;
    extraction(folder.path(), &out)?;
    let script = "umask 027; exec \"$0\" extract \"$1\" --device cpu --light dir:0,1,0 --out \"$2\"";
    shell(script, &[&folder.path().join("model.npz"), &out]).expect(0, &[])?;
    let there = out.metadata().map_err(text)?.permissions().mode() & 0o7777;
    ensure!(there == 0o640, "{there:o} instead of 640");
    Ok(())
}

fn protected() -> Outcome {
    let folder = folder();
    let out = folder.path().join("out.npz");
    write_file(&out, "old")?;
    fs::set_permissions(&out, fs::Permissions::from_mode(0o444)).map_err(text)?;
    if File::options().write(true).open(&out).is_ok() {
        // The superuser may write everything.
        return Ok(());
    }
    let line = extraction(folder.path(), &out)?;
    refused(folder.path(), 4, &["cannot be written"], || rimline(line))
}

fn pipe() -> Outcome {
    let folder = folder();
    let out = folder.path().join("pipe");
    let line = extraction(folder.path(), &out)?;
    let bytes = expected(&line, folder.path())?;
    ensure!(Command::new("mkfifo").arg(&out).status().is_ok_and(|status| status.success()), "no pipe could be made");
    let reader = std::thread::spawn({
        let out = out.clone();
        move || fs::read(out)
    });
    let run = rimline(line);
    let is_pipe = out.symlink_metadata().is_ok_and(|there| there.file_type().is_fifo());
    // Lets the reader end if nobody wrote.
    drop(File::options().read(true).write(true).open(&out));
    run.expect(0, &[])?;
    ensure!(is_pipe, "the pipe was replaced");
    let read = reader.join().map_err(|_| "the reader panicked")?.map_err(text)?;
    ensure!(read == bytes, "{} bytes came through the pipe instead of {}", read.len(), bytes.len());
    Ok(())
}

fn standard_output() -> Outcome {
    let folder = folder();
    // By a link of the test's own, which may be lost.
    let out = folder.path().join("out");
    symlink("/dev/stdout", &out).map_err(text)?;
    let line = extraction(folder.path(), &out)?;
    let bytes = expected(&line, folder.path())?;
    let run = || Command::new(env!("CARGO_BIN_EXE_rimline")).args(&line).output().map_err(text);
    let piped = run()?;
    ensure!(out.symlink_metadata().is_ok_and(|there| there.is_symlink()), "the link was replaced");
    ensure!(piped.stdout == bytes, "{} bytes instead of {}", piped.stdout.len(), bytes.len());
    ensure!(String::from_utf8_lossy(&piped.stderr).contains("faces"), "the report is nowhere");
    // A file that the shell opened, with something in it already.
    let log = folder.path().join("log");
    write_file(&log, "before ")?;
    let append = File::options().append(true).open(&log).map_err(text)?;
    let status = Command::new(env!("CARGO_BIN_EXE_rimline"))
        .args(&line)
        .stdout(append)
        .stderr(Stdio::null())
        .status()
        .map_err(text)?;
    ensure!(status.success(), "{status}");
    ensure!(read_file(&log)? == [b"before ", &bytes[..]].concat(), "the file has not the result alone");
    Ok(())
}

fn dash() -> Outcome {
    let folder = folder();
    let line = extraction(folder.path(), Path::new("-"))?;
    let bytes = expected(&line, folder.path())?;
    let run = |line: &[OsString]| {
        Command::new(env!("CARGO_BIN_EXE_rimline")).args(line).current_dir(folder.path()).output().map_err(text)
    };
    let piped = run(&[&line[..], &["--json".into()]].concat())?;
    ensure!(piped.stdout == bytes, "{} bytes instead of {}", piped.stdout.len(), bytes.len());
    ensure!(String::from_utf8_lossy(&piped.stderr).starts_with('{'), "the report is nowhere");
    ensure!(!folder.path().join("-").exists(), "there is a file of that name");
    // Where it is the model.
    let script = "exec \"$0\" extract \"$1\" --device cpu --light dir:0,1,0 --out - >> \"$1\"";
    let model = folder.path().join("model.npz");
    refused(folder.path(), 2, &["is an input"], || shell(script, &[&model]))?;
    // A file of that name is written by its path.
    let line = extraction(folder.path(), Path::new("./-"))?;
    ensure!(run(&line)?.status.success(), "./- was refused");
    ensure!(folder.read("-")? == bytes, "./- is not the result");
    Ok(())
}

/// The folder of files in the making, by what the user knows of it.
fn in_the_way() -> Outcome {
    let folder = folder();
    let line = extraction(folder.path(), Path::new("/dev/full"))?;
    let run = rimline_with(&line, &[("TMPDIR", "/none/such")]);
    run.expect(4, &["a temporary file in /none/such", "TMPDIR"])?;
    one_error(&run.stderr)?;
    let sealed = folder.path().join("sealed");
    fs::create_dir(&sealed).map_err(text)?;
    fs::set_permissions(&sealed, fs::Permissions::from_mode(0o555)).map_err(text)?;
    // The superuser may write everywhere but there.
    let place = if File::create(sealed.join("probe")).is_ok() { Path::new("/proc") } else { &sealed };
    let run = rimline(extraction(folder.path(), &place.join("out.npz"))?);
    run.expect(4, &["out.npz: cannot be written: no file can be made in its folder: ", "os error"])?;
    ensure!(!run.stderr.contains(".part") && !run.stderr.contains(".rimline"), "{}", run.stderr);
    one_error(&run.stderr)
}

/// A flat grid of so many vertices each way.
fn grid(side: usize) -> Vec<u8> {
    let positions: Vec<u8> =
        (0..side * side).flat_map(|v| [(v % side) as f32, (v / side) as f32, 0.0]).flat_map(f32::to_le_bytes).collect();
    let faces: Vec<u8> = [0_u32, 1, 2].iter().flat_map(|index| index.to_le_bytes()).collect();
    write_zip(&[
        array("positions", "<f4", "False", &format!("({}, 3)", side * side), &positions),
        array("faces", "<u4", "False", "(1, 3)", &faces),
    ])
}

/// Nothing but one line is printed.
fn one_error(stderr: &str) -> Outcome {
    let is_one = stderr.starts_with("rimline: error: ") && stderr.lines().count() == 1;
    ensure!(is_one, "more than the error is printed: {stderr}");
    Ok(())
}

fn full() -> Outcome {
    let folder = folder();
    let model = folder.path().join("model.npz");
    // More than what is kept before it is written.
    write_file(&model, grid(256))?;
    let limited =
        "trap '' XFSZ; ulimit -f 8; exec \"$0\" extract \"$1\" --no-weld --device cpu --light dir:0,1,0 --out \"$2\"";
    let out = folder.path().join("out.npz");
    let run = shell(limited, &[&model, &out]);
    run.expect(4, &["cannot be written"])?;
    one_error(&run.stderr)?;
    let left = super::outputs::contents(folder.path())?;
    ensure!(left.len() == 1, "left behind: {:?}", left.keys());

    let device = folder.path().join("full");
    symlink("/dev/full", &device).map_err(text)?;
    let run = rimline(extraction(folder.path(), &device)?);
    run.expect(4, &["cannot be written", "full: ", "No space"])?;
    one_error(&run.stderr)?;
    ensure!(fs::read_link(&device).map_err(text)? == Path::new("/dev/full"), "the link was replaced");
    let is_device = fs::metadata("/dev/full").is_ok_and(|there| there.file_type().is_char_device());
    ensure!(is_device, "the device was replaced");
    Ok(())
}

fn stale_part() -> Outcome {
    let folder = folder();
    let out = folder.path().join("out.npz");
    extraction(folder.path(), &out)?;
    // The names that parts have had, with the number that this very process is going to have.
    let script =
        "cd \"$1\"; : > .out.npz.$$.part; exec \"$0\" extract model.npz --device cpu --light dir:0,1,0 --out out.npz";
    shell(script, &[folder.path()]).expect(0, &[])?;
    ensure!(out.metadata().is_ok_and(|there| there.len() > 0), "nothing was written");
    Ok(())
}

fn long_names() -> Outcome {
    let folder = folder();
    for length in [200, 250, 255] {
        let name = format!("{}.npz", "x".repeat(length - 4));
        rimline(extraction(folder.path(), &folder.path().join(&name))?)
            .expect(0, &[])
            .map_err(|error| format!("{length} letters: {error}"))?;
        ensure!(folder.path().join(&name).is_file(), "{length} letters: nothing was written");
        fs::remove_file(folder.path().join(name)).map_err(text)?;
    }
    let line = extraction(folder.path(), &folder.path().join("x".repeat(256)))?;
    refused(folder.path(), 4, &["cannot be written"], || rimline(line))?;
    // Known before any device is looked for.
    let prefix = folder.path().join("x".repeat(250));
    let mask = ["shadow".into(), "--mask".into(), prefix.into_os_string(), folder.path().join("model.npz").into()];
    refused(folder.path(), 4, &["cannot be written"], || rimline_with(mask, HIDDEN))
}
