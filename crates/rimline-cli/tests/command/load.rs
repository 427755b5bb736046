//! The options that say what a model file may do: `--memory-limit`, `--allow-outside`.

use std::path::Path;

use super::inputs::fed;
use super::run::{Run, folder, is_empty, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("load::small_files_that_unpack_to_much_end_with_1", bomb),
    ("load::the_memory_limit_is_the_user_s", limit),
    ("load::buffers_outside_need_an_option", outside),
    ("load::every_command_that_reads_models_has_the_options", everywhere),
    ("load::wrong_sizes_end_with_2", wrong_sizes),
];

/// 371 bytes: 800,000 faces of zeros, 880 times.
const BOMB: &str = r#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_mesh_gpu_instancing"],
    "accessors":[{"componentType":5126,"type":"VEC3","count":2400000},{"componentType":5126,"type":"VEC3","count":880}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1}}}}]}"#;

/// A triangle whose positions lie in a file of this name.
fn triangle(uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"{uri}"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]}}"#
    )
}

fn write(path: &Path, content: impl AsRef<[u8]>) -> Outcome {
    write_file(path, content)
}

fn info(model: &Path, options: &[&str]) -> Run {
    let words = options.iter().map(std::ffi::OsStr::new);
    rimline([std::ffi::OsStr::new("info"), model.as_os_str()].into_iter().chain(words))
}

fn bomb() -> Outcome {
    let folder = folder();
    let model = folder.path().join("bomb.gltf");
    write(&model, BOMB)?;
    info(&model, &["--memory-limit", "100MiB"])
        .expect(1, &["bomb.gltf: meshes[0]", "more than the limit of 100 MiB", "--memory-limit"])?;
    let line = ["info", "-", "--memory-limit", "100MiB"];
    fed(BOMB.as_ref(), &line)?.expect(1, &["-: meshes[0]", "limit of 100 MiB", "--memory-limit"])
}

fn limit() -> Outcome {
    let folder = folder();
    let model = folder.path().join("triangle.gltf");
    write(&folder.path().join("a.bin"), [0; 36])?;
    write(&model, triangle("a.bin"))?;
    info(&model, &["--memory-limit", "100"])
        .expect(1, &["triangle.gltf: the file: reading it", "more than the limit of 100 bytes"])?;
    info(&model, &["--memory-limit", "1MiB"]).expect(0, &[])?;
    info(&model, &[]).expect(0, &[])
}

fn outside() -> Outcome {
    let folder = folder();
    let inner = folder.inner("inner")?;
    write(&folder.path().join("a.bin"), [0; 36])?;
    let model = inner.join("parent.gltf");
    write(&model, triangle("../a.bin"))?;
    let mut models = vec![model];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../a.bin", inner.join("link.bin")).map_err(|error| error.to_string())?;
        let model = inner.join("link.gltf");
        write(&model, triangle("link.bin"))?;
        models.push(model);
    }
    for model in models {
        info(&model, &[]).expect(1, &["buffers[0].uri", "a.bin", "outside", "--allow-outside"])?;
        info(&model, &["--allow-outside"]).expect(0, &[])?;
    }
    Ok(())
}

fn everywhere() -> Outcome {
    let folder = folder();
    folder.write("a.gltf", triangle("../a.bin"))?;
    let results = folder.inner("results")?;
    for command in [
        "info @a.gltf",
        "draw @a.gltf --out @results/out",
        "extract @a.gltf --light dir:0,1,0 --device cpu --out @results/out",
        "shadow @a.gltf --out @results/out",
        "film @a.gltf --frames 1 --out @results/out",
        "query @a.gltf --points none.npz --light dir:0,1,0 --device cpu --out @results/out",
    ] {
        let with = |options: &str| folder.run(&format!("{command} {options}"));
        with("--memory-limit 10").expect(1, &["more than the limit of 10 bytes", "--memory-limit"])?;
        with("").expect(1, &["outside", "--allow-outside"])?;
        // Allowed, the file is looked for, and it is not there.
        let run = with("--allow-outside");
        run.expect(1, &["a.bin"])?;
        ensure!(!run.stderr.contains("--allow-outside"), "{command}: {}", run.stderr);
    }
    is_empty(&results)?;
    folder.run("verify @results/bits --memory-limit 10").expect(2, &["--make"])?;
    folder.run("verify @results/bits --allow-outside").expect(2, &["--make"])?;
    let make = "verify --make @results/bits @a.gltf --memory-limit 10";
    folder.run(make).expect(1, &["more than the limit of 10 bytes"])
}

fn wrong_sizes() -> Outcome {
    for size in ["", "much", "1.5GiB", "-1", "4GB"] {
        let option = format!("--memory-limit={size}");
        rimline(["info", "none.gltf", &option]).expect(2, &["--memory-limit"])?;
    }
    Ok(())
}
