//! `cargo xtask web`: the viewer as a page of three files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process;

pub(crate) const WASM: &str = "wasm32-unknown-unknown";

/// Debian's toolchain for browsers, which has no compiled standard library for them.
const DEBIAN: &str = "rustc-web cargo-web rust-web-src rust-web-llvm lld-22";

/// The files of the page.
const FILES: [&str; 3] = ["index.html", "rimline.js", "rimline_bg.wasm"];

/// Bytes of all three files, compressed.
const MOST: u64 = 6 << 20;

/// Pictures of the README for browsers without WebGPU, as `index.html` names them.
const PICTURES: [&str; 2] = ["viewer.png", "walking_lines.png"];

/// Builds `target/web`, and says how large it is.
pub(crate) fn build() -> Result<PathBuf, String> {
    let (page, work) = (process::target().join("web"), process::target().join("web-build"));
    let compiled = compile(&work)?;
    if page.exists() {
        fs::remove_dir_all(&page).map_err(|error| format!("cannot replace {}: {error}", page.display()))?;
    }
    bind(&work, &compiled, &page)?;
    let wasm = page.join("rimline_bg.wasm");
    if process::on_path("wasm-opt") {
        process::run(Command::new("wasm-opt").args(["-Os", "--all-features", "-o"]).args([&wasm, &wasm]))?;
    } else {
        println!("note: wasm-opt is not installed; it would make the page smaller (Debian's package binaryen)");
    }
    write_index(&page)?;
    check_files(&page)?;
    report(&page)?;
    Ok(page)
}

/// Compiles the viewer, by rustup's toolchain if it has the target, else by Debian's.
fn compile(work: &Path) -> Result<PathBuf, String> {
    let arguments =
        ["build", "--package", "rimline-view", "--bin", "rimline-view", "--profile", "web", "--target", WASM];
    let mut cargo = process::cargo(arguments);
    if !has_target()? {
        let tools = ["/usr/bin/cargo", "/usr/bin/rustc", "/usr/bin/wasm-ld-22"];
        if !tools.iter().all(|tool| Path::new(tool).exists()) {
            return Err(format!(
                "this Rust cannot compile for browsers. With rustup: `rustup target add {WASM}`. On Debian without rustup: \
                 `apt-get install {DEBIAN}`"
            ));
        }
        println!("Debian's Rust compiles for browsers, with the standard library: minutes, the first time.");
        cargo = Command::new(tools[0]);
        cargo.args(arguments).arg("-Zbuild-std=std,panic_abort").current_dir(process::root());
        cargo.env("RUSTC", tools[1]).env("RUSTC_BOOTSTRAP", "1");
        cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", tools[2]);
    }
    // Flags for this machine's compiler are none for that one.
    process::run(cargo.env("CARGO_TARGET_DIR", work).env_remove("RUSTFLAGS"))?;
    Ok(work.join(WASM).join("web").join("rimline-view.wasm"))
}

/// Whether the compiler has the standard library for browsers.
pub(crate) fn has_target() -> Result<bool, String> {
    let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    let libdir = process::output(rustc.args(["--print", "target-libdir", "--target", WASM]))?;
    Ok(Path::new(libdir.trim()).is_dir())
}

/// Makes the JavaScript between page and program. The library that does must be of the version that the program has, so a
/// package of its own is made for it: nothing else here waits for its two dozen crates, and no tool has to be installed.
fn bind(work: &Path, compiled: &Path, page: &Path) -> Result<(), String> {
    let version = locked("wasm-bindgen")?;
    let package = work.join("bindgen");
    let written = |file: &str, text: &str| {
        let path = package.join(file);
        // Files that stay as they are need not be compiled again.
        if fs::read_to_string(&path).is_ok_and(|there| there == text) {
            return Ok(());
        }
        fs::write(&path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
    };
    fs::create_dir_all(package.join("src")).map_err(|error| format!("cannot make {}: {error}", package.display()))?;
    written(
        "Cargo.toml",
        &format!(
            "[package]\nname = \"bindgen\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[workspace]\n\n[dependencies]\n\
         wasm-bindgen-cli-support = \"={version}\"\n\n[profile.dev]\nopt-level = 1\ndebug = false\n"
        ),
    )?;
    written("src/main.rs", include_str!("web/bindgen.rs"))?;
    let mut cargo = process::cargo(["run", "--quiet", "--manifest-path"]);
    cargo.arg(package.join("Cargo.toml")).env("CARGO_TARGET_DIR", work.join("bindgen-target"));
    process::run(cargo.arg("--").arg(compiled).arg(page))
}

/// The version of a package in the workspace's lock file.
fn locked(package: &str) -> Result<String, String> {
    let lock = process::root().join("Cargo.lock");
    let text = fs::read_to_string(&lock).map_err(|error| format!("cannot read {}: {error}", lock.display()))?;
    let entry = format!("name = \"{package}\"\nversion = \"");
    let version = text.split_once(&entry).and_then(|(_, after)| after.split_once('"'));
    version.map(|(version, _)| version.to_owned()).ok_or_else(|| format!("{} has no {package}", lock.display()))
}

/// Writes the page with its pictures in it.
fn write_index(page: &Path) -> Result<(), String> {
    let mut index = include_str!("../../crates/rimline-view/web/index.html").to_owned();
    for picture in PICTURES {
        let path = process::root().join("docs").join(picture);
        let bytes = fs::read(&path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        index = index.replace(&format!("{{{picture}}}"), &format!("data:image/png;base64,{}", base64(&bytes)));
    }
    let path = page.join("index.html");
    fs::write(&path, index).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let quartet = |chunk: &[u8]| {
        let word = (0..3).fold(0, |word, index| word << 8 | u32::from(chunk.get(index).copied().unwrap_or(0)));
        let digit = |index: usize| char::from(DIGITS[(word >> (18 - 6 * index) & 63) as usize]);
        [0, 1, 2, 3].map(|index| if index <= chunk.len() { digit(index) } else { '=' })
    };
    bytes.chunks(3).flat_map(quartet).collect()
}

/// The page has its three files and no others: a host is given the folder as it is.
fn check_files(page: &Path) -> Result<(), String> {
    let unreadable = |error: std::io::Error| format!("cannot read {}: {error}", page.display());
    let entries = fs::read_dir(page).and_then(Iterator::collect::<Result<Vec<_>, _>>).map_err(unreadable)?;
    let mut names: Vec<_> = entries.iter().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    if names == FILES { Ok(()) } else { Err(format!("{} has {names:?} instead of {FILES:?}", page.display())) }
}

/// Prints the size of each file, and fails if all are too large together.
fn report(page: &Path) -> Result<(), String> {
    let mut total = 0;
    println!();
    for file in FILES {
        let path = page.join(file);
        let bytes = fs::metadata(&path).map_err(|error| format!("{}: {error}", path.display()))?.len();
        // Where there is no gzip, the bytes as they are.
        let compressed = Command::new("gzip").args(["-9", "-c"]).arg(&path).output();
        let compressed = compressed.map_or(bytes, |output| output.stdout.len() as u64);
        println!("{file:<16} {bytes:>9} bytes, {compressed:>9} compressed");
        total += compressed;
    }
    println!("{total} bytes in all by gzip, of {MOST}\nTry it: python3 -m http.server --directory {}", page.display());
    if total <= MOST { Ok(()) } else { Err(format!("the page has {total} bytes compressed, more than {MOST}")) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn base64_has_the_vectors_of_rfc_4648() {
        let cases =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (plain, encoded) in cases {
            assert_eq!(super::base64(plain.as_bytes()), encoded);
        }
    }
}
