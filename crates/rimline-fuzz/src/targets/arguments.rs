//! The command's arguments: each case is a run of the command, in a folder of its own, without a GPU.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rimline_files::npz::{ElementType, NpzWriter};
use rimline_testkit::random::Random;

use crate::options::Options;
use crate::supervisor::SLOW;
use rimline_testkit::mutate;

/// Lines that do something on the CPU, fail for want of a GPU, or print.
const SEEDS: [&str; 19] = [
    "info tetra.npz",
    "info --json --weld position tetra.npz --memory-limit 64MiB",
    "info bad.npz",
    "extract tetra.npz --device cpu --light point:1,2,3 --light dir:0,1,0 --out out.npz --json",
    "extract tetra.npz --device cpu --light hom:1,2,3,.5 --method per-edge --predicate plane --no-weld --out out.npz",
    "extract tetra.npz --device cpu --light file:all --time -1e3 --out out.npz",
    "extract tetra.npz --device gpu --displace wave.wgsl --light dir:1,0,0 --out out.npz",
    "query tetra.npz --points points.npz --device cpu --light point:5,5,5 --out depths.npz",
    "draw tetra.npz --out out.png --size 64x64 --eye 1,2,3 --target 0,0,0 --device gpu",
    "shadow tetra.npz --out out.png --size 64x48 --light dir:0,1,0 --ground -1 --fov 40 --near 0.01",
    "shadow tetra.npz --mask m --light point:1,2,3 --area 0.5 --samples 16",
    "shadow tetra.npz --mask m --size 32x32 --from-depth 16 --detector contours=0.1",
    "film tetra.npz --out frames --frames 2 --size 32x32 --displace wave.wgsl",
    "verify folder --device cpu",
    "verify --make folder tetra.npz",
    "devices --json",
    "bench --schema",
    "shadow --help",
    "--version",
];

const WORDS: [&str; 40] = [
    "--light",
    "--out",
    "--device",
    "cpu",
    "gpu",
    "--json",
    "--time",
    "--animation",
    "--weld",
    "--no-weld",
    "position",
    "data",
    "--size",
    "1x1",
    "0x0",
    "99999x99999",
    "-1",
    "--",
    "-",
    "",
    "=",
    "--help",
    "-h",
    "tetra.npz",
    "bad.npz",
    "missing.glb",
    "wave.wgsl",
    "folder",
    "\u{1b}[31m",
    "é\u{202e}",
    "\n",
    "point:nan,inf,-0",
    "dir:0,0,0",
    "hom:0,0,0,0",
    "file:",
    "file:all",
    "--memory-limit",
    "0",
    "18446744073709551615TiB",
    "--allow-outside",
];

pub(crate) struct Seeds {
    program: PathBuf,
    folder: PathBuf,
    slow: Duration,
}

impl Seeds {
    pub(crate) fn new(options: &Options) -> Result<Self, String> {
        let here = std::env::current_exe().map_err(|error| error.to_string())?;
        let program = here.with_file_name(format!("rimline{}", std::env::consts::EXE_SUFFIX));
        if !program.is_file() {
            return Err(format!("{} is not there: run `cargo build -p rimline-cli`", program.display()));
        }
        let folder = options.out.join("arguments");
        let program = std::path::absolute(program).map_err(|error| error.to_string())?;
        fill(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(Self { program, folder, slow: Duration::from_secs(options.slow) })
    }

    #[expect(clippy::unused_self, reason = "as the other targets")]
    pub(crate) fn case(&self, random: &mut Random) -> Vec<String> {
        let split = |line: &str| -> Vec<String> { line.split(' ').map(str::to_owned).collect() };
        let mut words = split(SEEDS[random.below(SEEDS.len())]);
        for _ in 0..=random.below(4) {
            let at = random.below(words.len());
            match random.below(10) {
                0 | 1 => words.insert(at, WORDS[random.below(WORDS.len())].to_owned()),
                2 => drop(words.remove(at)),
                3 => {
                    let other = random.below(words.len());
                    words.swap(at, other);
                }
                4 => {
                    let other = split(SEEDS[random.below(SEEDS.len())]);
                    let from = random.below(other.len());
                    words.extend(other.into_iter().skip(from));
                }
                5 => {
                    let copies = vec![words[at].clone(); 1 << random.below(8)];
                    words.splice(at..at, copies);
                }
                _ => mutate::text(
                    &mut words[at],
                    &[":", ",", "-", "=", "x", "e9", ".", "\u{0}", "é", "nan", "--"],
                    random,
                ),
            }
            if words.is_empty() {
                words.push(String::new());
            }
        }
        // No system refuses 300 arguments.
        words.iter().take(300).map(|word| tame(word)).collect()
    }

    /// The command ends by itself, with one of its own codes, and without a panic.
    pub(crate) fn run(&self, words: &[String]) -> Result<bool, String> {
        let mut command = Command::new(&self.program);
        command.args(words).current_dir(&self.folder).env("RUST_BACKTRACE", "0");
        // Neither Vulkan nor OpenGL: what is fuzzed is not a driver.
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "__EGL_VENDOR_LIBRARY_FILENAMES"] {
            command.env(variable, "no such file");
        }
        let file =
            |name: &str| std::fs::File::create(self.folder.with_extension(name)).map_err(|error| error.to_string());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file("stderr")?);
        let start = Instant::now();
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        let status = loop {
            if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
                break status;
            }
            if start.elapsed() > self.slow {
                let _ = child.kill();
                let _ = child.wait();
                // Measuring takes as long as it was asked to.
                let is_bench = words.iter().any(|word| word == "bench");
                return if is_bench { Ok(false) } else { Err(format!("{SLOW} {} s", self.slow.as_secs())) };
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let said = std::fs::read(self.folder.with_extension("stderr")).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        if said.contains("panicked at") {
            return Err(format!("it panicked: {said:.1000}"));
        }
        if said.chars().any(|c| c.is_control() && c != '\n') {
            return Err(format!("control characters reach the terminal: {said:.1000?}"));
        }
        match status.code() {
            Some(0) => Ok(true),
            Some(1..=6) => Ok(false),
            _ => Err(format!("{status}: {said:.1000}")),
        }
    }
}

/// Without null characters, which no argument has, and without ways out of the folder.
fn tame(word: &str) -> String {
    word.replace(['\0', '/', '\\'], "_").replace("..", "_").chars().take(2_000).collect()
}

fn fill(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let positions: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let floats: Vec<u8> = positions.as_flattened().iter().flat_map(|c| c.to_ne_bytes()).collect();
    let faces = [0_u8, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
    for (name, array) in [("tetra.npz", "positions"), ("points.npz", "points")] {
        let mut npz = NpzWriter::new(std::fs::File::create(folder.join(name))?);
        npz.array(array, ElementType::F32, &[4, 3], |to| to.write_all(&floats))?;
        npz.array("faces", ElementType::U8, &[4, 3], |to| to.write_all(&faces))?;
        npz.finish()?;
    }
    std::fs::write(folder.join("bad.npz"), b"PK\x03\x04")?;
    let head = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32>";
    std::fs::write(folder.join("wave.wgsl"), format!("{head} {{ return position + sin(time); }}"))
}
