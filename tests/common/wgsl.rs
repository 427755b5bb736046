//! The WGSL by itself: files and stages, validity for naga and tint, struct layouts.

mod layouts;
mod turns;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::{Arguments, Failed, Trial};
use naga::Module;
use rimline::Displacement;
use rimline::internals::displace::deform_wgsl;
use rimline::internals::stages::{DRAWN, FILES, SCENE_FACING, SIDES, STAGES, Stage, source};

type Outcome = Result<(), String>;
/// A test's name and body.
type Test = (&'static str, fn() -> Outcome);

fn main() {
    let tests: [Test; 13] = [
        ("every_file_is_a_stage_or_an_include", files),
        ("stages_have_references_or_oracles_and_entry_points_of_their_name", names),
        ("vertex_shaders_are_listed_and_have_oracles", vertex_shaders),
        ("constants_are_those_of_rust", constants),
        ("wgsl_composes", composes),
        ("a_broken_file_is_named_with_its_line", broken_file),
        ("rustdoc_tells_all_that_the_include_has", include_is_documented),
        ("layouts_are_those_of_rust", layouts::layouts),
        ("layouts_cover_every_bound_struct", layouts::bound_structs),
        ("perturbed_layouts_are_noticed", layouts::perturbed_layouts),
        ("loops_have_as_many_turns_as_stated", turns::stated),
        ("loops_of_the_command_are_short", turns::of_command),
        ("a_loop_without_a_bound_is_noticed", turns::unstated),
    ];
    let mut trials: Vec<_> =
        tests.into_iter().map(|(name, test)| Trial::test(name, move || test().map_err(Failed::from))).collect();
    let tint = Trial::test("tint_accepts_every_module", || tint().map_err(Failed::from));
    let has_tint = Command::new("tint").arg("--help").output().is_ok();
    trials.push(tint.with_ignored_flag(!has_tint));
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

fn check_files(found: &BTreeSet<String>) -> Outcome {
    let known: BTreeSet<String> = FILES.iter().map(|(name, _)| format!("{name}.wgsl")).collect();
    if *found == known {
        return Ok(());
    }
    let stray: Vec<_> = found.symmetric_difference(&known).collect();
    Err(format!("in the folder or in the list of stages, not in both: {stray:?}"))
}

/// A WGSL file outside the list of stages would be dead, untested code.
fn files() -> Outcome {
    let mut found = BTreeSet::new();
    for subject in std::fs::read_dir(root().join("wgsl")).map_err(text)? {
        let subject = subject.map_err(text)?;
        let folder = subject.file_name().to_string_lossy().into_owned();
        if !subject.path().is_dir() {
            return Err(format!("{folder} lies in wgsl/ itself; every file belongs in the folder of its subject"));
        }
        for file in std::fs::read_dir(subject.path()).map_err(text)? {
            found.insert(format!("{folder}/{}", file.map_err(text)?.file_name().to_string_lossy()));
        }
    }
    check_files(&found)?;
    found.insert("extract/stray.wgsl".to_owned());
    match check_files(&found) {
        Ok(()) => Err("negative control: a stray file went unnoticed".to_owned()),
        Err(_) => Ok(()),
    }
}

fn names() -> Outcome {
    let is_stage = |name: &str| STAGES.iter().chain(DRAWN).any(|stage| stage.name == name);
    if let Some((name, _)) = WITHOUT_REFERENCE.iter().find(|(name, _)| !is_stage(name)) {
        return Err(format!("{name} is listed as a stage without a reference, and is none"));
    }
    for stage in STAGES {
        let (module, _) = validated(&stage.wgsl())?;
        let found: Vec<_> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
        if found != stage.entry_points {
            return Err(format!("{}: entry points {found:?}, listed {:?}", stage.name, stage.entry_points));
        }
        let carries_name = |entry: &&str| **entry == *stage.name || entry.starts_with(&format!("{}_", stage.name));
        if !found.iter().all(carries_name) {
            return Err(format!("{}: entry points {found:?} do not carry the name", stage.name));
        }
        let path = reference(stage);
        if let Some((_, test)) = WITHOUT_REFERENCE.iter().find(|(name, _)| *name == stage.name) {
            check_without_reference(stage, &path, test)?;
            continue;
        }
        let reference = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        // The stage's own name, or that of a function in its WGSL file.
        let text = source(stage.file).unwrap_or_default();
        let functions = text.lines().filter_map(|line| line.strip_prefix("fn ")?.split('(').next());
        let mut shared = functions.chain([stage.name]);
        let is_shown =
            |name: &str| ["pub", "pub(crate)"].iter().any(|shown| reference.contains(&format!("{shown} fn {name}(")));
        if !shared.any(is_shown) {
            return Err(format!("{}: the reference has no function of the stage's outside of its file", stage.name));
        }
    }
    Ok(())
}

/// Stages without a CPU reference, and the test that runs them against an oracle or goldens.
const WITHOUT_REFERENCE: &[(&str, &str)] = &[
    ("compact", "tests/extract/stages.rs"),
    ("arguments", "tests/extract/stages.rs"),
    ("depth_arguments", "tests/query/shadow_query.rs"),
    ("cut_edges", "tests/polygon/pieces.rs"),
    ("cut_quads", "tests/polygon/pieces.rs"),
    ("needs", "tests/scene/needs.rs"),
    ("cull_lights", "tests/scene/cached.rs"),
    ("clusters", "tests/scene/cluster_decisions.rs"),
    ("chunks", "tests/scene/clusters.rs"),
    ("receiver_depth", "tests/shadow/receivers.rs"),
    ("receiver_pyramid", "tests/shadow/receivers.rs"),
    ("relist", "tests/scene/cached.rs"),
    ("bounds", "tests/shadow/most_turns.rs"),
    ("counting_methods", "tests/shadow/margins/boxes.rs"),
    ("zp_plus_2005_cases", "tests/shadow/zp_plus_2005.rs"),
    ("caps", "tests/shadow/trials.rs"),
    ("list_sides", "tests/shadow/trials.rs"),
    ("stencil_pencil", "tests/shadow/margins/counts.rs"),
    ("stencil_crossings", "tests/shadow/margins/counts.rs"),
    ("piece_crossings", "tests/shadow/twisted.rs"),
    ("stencil_bound", "tests/shadow/margins/counts.rs"),
    ("sides", "tests/shadow/vertices.rs"),
    ("cap_faces", "tests/shadow/vertices.rs"),
    ("shadow_arguments", "tests/shadow/thousands.rs"),
    ("piece_arguments", "tests/shadow/polygons.rs"),
    ("piece_volumes", "tests/shadow/polygons.rs"),
    ("depth_near", "tests/depth_map/near.rs"),
    ("depth_near_walls", "tests/depth_map/near.rs"),
    ("depth_metric", "tests/depth_map/metric.rs"),
    ("depth_merge", "tests/depth_map/metric.rs"),
    ("depth_cube", "tests/depth_map/cube.rs"),
    ("depth_edges", "tests/depth_map/stages.rs"),
    ("depth_cells", "tests/depth_map/stages.rs"),
    ("contour_marks", "tests/depth_map/contours.rs"),
    ("contour_tiles", "tests/depth_map/contours.rs"),
    ("contour_crossings", "tests/depth_map/crossings.rs"),
    ("contour_walls", "tests/depth_map/contours.rs"),
    ("depth_surface", "tests/depth_map/vertices.rs"),
    ("depth_walls", "tests/depth_map/wall_vertices.rs"),
    ("mesh_depth", "tests/depth_map/vertices.rs"),
    ("outline_edges", "tests/outline/gpu.rs"),
    ("shadow_masks", "tests/mask/gpu.rs"),
];

/// The test has the stage's constant, or its name in backticks, and there is no CPU reference.
fn check_without_reference(stage: &Stage, reference: &Path, test: &str) -> Outcome {
    let text =
        std::fs::read_to_string(root().join(test)).map_err(|error| format!("{}, {test}: {error}", stage.name))?;
    let constant = stage.name.to_uppercase();
    let mut words = text.split(|c: char| c != '_' && !c.is_alphanumeric());
    match (reference.exists(), words.any(|word| word == constant) || text.contains(&format!("`{}`", stage.name))) {
        (false, true) => Ok(()),
        (true, _) => Err(format!("{}: there is a reference, {}", stage.name, reference.display())),
        (_, false) => Err(format!("{}: {test} does not name the stage", stage.name)),
    }
}

/// The CPU reference's file: in `src/cpu`, in the folder of the stage's subject.
fn reference(stage: &Stage) -> PathBuf {
    let subject = stage.file.split('/').next().unwrap_or_default();
    root().join("src/cpu").join(subject).join(format!("{}.rs", stage.name))
}

/// Compares the vertex shaders of a stage's module with its listed entry points.
fn check_vertex_shaders(stage: &Stage, listed: &[&str]) -> Outcome {
    let (module, _) = validated(&stage.wgsl())?;
    let entry_points = module.entry_points.iter().filter(|entry| entry.stage == naga::ShaderStage::Vertex);
    let found: Vec<_> = entry_points.map(|entry| entry.name.as_str()).collect();
    if found == listed { Ok(()) } else { Err(format!("{}: vertex shaders {found:?}, listed {listed:?}", stage.name)) }
}

/// Each stage of draws has the vertex shaders that are listed, and a test against an oracle.
fn vertex_shaders() -> Outcome {
    for stage in DRAWN {
        check_vertex_shaders(stage, stage.entry_points)?;
        if check_vertex_shaders(stage, &stage.entry_points[1..]).is_ok() {
            return Err(format!("negative control: a vertex shader of {} is not listed, unnoticed", stage.name));
        }
        let test = WITHOUT_REFERENCE.iter().find(|(name, _)| *name == stage.name);
        let (_, test) = test.ok_or_else(|| format!("{}: no test is named", stage.name))?;
        check_without_reference(stage, &reference(stage), test)?;
    }
    Ok(())
}

fn check_constants(module: &Module, listed: &[(&str, u32)]) -> Outcome {
    for (name, value) in listed {
        let found = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
        let found = found.map(|(_, constant)| &module.global_expressions[constant.init]);
        if !matches!(found, Some(naga::Expression::Literal(naga::Literal::U32(found))) if found == value) {
            return Err(format!("{name}: WGSL has {found:?}, Rust {value}"));
        }
    }
    Ok(())
}

/// `casting` and `counting` of shared structs hold the same constants in Rust and WGSL.
fn constants() -> Outcome {
    use rimline::internals::layout::{CHUNK, LANES};
    use rimline::internals::shadow::{CAST_BACK_FACING, CAST_EVERY, CAST_NOTHING};
    use rimline::internals::shadow::{COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};
    let listed = [
        ("CAST_NOTHING", CAST_NOTHING),
        ("CAST_BACK_FACING", CAST_BACK_FACING),
        ("CAST_EVERY", CAST_EVERY),
        ("COUNT_Z_PASS", COUNT_Z_PASS),
        ("COUNT_ZP_PLUS", COUNT_ZP_PLUS),
        ("COUNT_Z_FAIL", COUNT_Z_FAIL),
        ("COUNT_AUTO", COUNT_AUTO),
        ("COUNT_ZP_PLUS_2005", COUNT_ZP_PLUS_2005),
    ];
    let (module, _) = validated(&SCENE_FACING.wgsl())?;
    check_constants(&module, &[("CHUNK", CHUNK), ("LANES", LANES)])?;
    let (module, _) = validated(&SIDES.composed_for(&listed.map(|(name, _)| name).join(" "))?.wgsl)?;
    check_constants(&module, &listed)?;
    match check_constants(&module, &[("COUNT_AUTO", COUNT_Z_FAIL)]) {
        Ok(()) => Err("negative control: a wrong constant went unnoticed".to_owned()),
        Err(_) => Ok(()),
    }
}

/// Names, signatures and members of the include, as rustdoc must have them between backticks.
fn items_of_include(module: &Module, source: &str) -> Vec<String> {
    let is_ours = |line: &&str| line.starts_with("fn rimline_");
    let signatures =
        source.lines().filter(is_ours).map(|line| line.trim_start_matches("fn ").trim_end_matches(" {").to_owned());
    let structs = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, .. } => Some((ty.name.clone()?, members)),
        _ => None,
    });
    let members = structs.flat_map(|(name, members)| {
        let of = members.iter().filter_map(|member| Some(format!("{}: ", member.name.as_ref()?)));
        std::iter::once(name).chain(of).collect::<Vec<_>>()
    });
    let bindings = module.global_variables.iter().filter_map(|(_, variable)| variable.name.clone());
    signatures.chain(members).chain(bindings).collect()
}

fn include_is_documented() -> Result<(), String> {
    let source = rimline::gpu::include_wgsl(0);
    let (module, _) = validated(&source)?;
    let rust = std::fs::read_to_string(root().join("src/gpu/extract/include.rs")).map_err(text)?;
    let doc: String = rust.lines().filter(|line| line.starts_with("///")).collect();
    let items = items_of_include(&module, &source);
    // Functions, two structs with their members, bindings.
    if items.len() != 11 + 2 + 8 + 6 + 7 {
        return Err(format!("{} items: {items:?}", items.len()));
    }
    let missing =
        |doc: &str| items.iter().filter(|item| !doc.contains(&format!("`{item}"))).cloned().collect::<Vec<_>>();
    if !missing(&doc).is_empty() {
        return Err(format!("not in the rustdoc of `include_wgsl`: {:?}", missing(&doc)));
    }
    if missing(&doc.replace("`winding", "`turned")).len() != 1 {
        return Err("negative control: a member went unnoticed".to_owned());
    }
    Ok(())
}

const DISPLACE: &str = "
struct Waves { height: f32, phases: array<f32> }
@group(1) @binding(0) var<storage, read> waves: Waves;
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position + vec3<f32>(0.0, waves.height * sin(time + waves.phases[vertex]), 0.0);
}
";

const USER: &str = "
@group(1) @binding(0) var<storage, read_write> lengths: array<f32>;
@compute @workgroup_size(64)
fn user(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x < rimline_silhouettes(0u)) {
    let edge = rimline_silhouette(0u, id.x);
    lengths[id.x] = distance(rimline_position(edge.a), rimline_position(edge.b));
  }
}
";

/// Every module that a pipeline may be made of, by name.
fn modules() -> Result<Vec<(String, String)>, String> {
    modules_with("")
}

/// The same, with the items that `further` names where a stage's files have them.
fn modules_with(further: &str) -> Result<Vec<(String, String)>, String> {
    let module = |stage: &Stage| Ok((stage.module.to_owned(), stage.composed_for(further)?.wgsl));
    let mut modules = STAGES.iter().chain(DRAWN).map(module).collect::<Result<Vec<_>, String>>()?;
    let displaced = deform_wgsl(&Displacement::new(DISPLACE).map_err(text)?);
    modules.push(("deform_displaced".to_owned(), displaced));
    let include = rimline::gpu::include_wgsl(0);
    modules.push(("results_before_user".to_owned(), format!("{include}{USER}")));
    modules.push(("results_after_user".to_owned(), format!("{USER}{include}")));
    Ok(modules)
}

/// Parses and validates with naga's default capabilities, as a browser would.
fn validated(source: &str) -> Result<(Module, naga::valid::ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok((module, info))
}

/// `target/wgsl`, where every composed module is written for other tools to look at.
fn folder() -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR"));
    target.parent().unwrap_or(target).join("wgsl")
}

fn write_modules() -> Result<Vec<PathBuf>, String> {
    std::fs::create_dir_all(folder()).map_err(text)?;
    let mut paths = Vec::new();
    for (name, source) in modules()? {
        let path = folder().join(format!("{name}.wgsl"));
        // Tests of one binary run at the same time, and a reader must never see half a file.
        let partial = folder().join(format!("{name}.{:?}.partial", std::thread::current().id()));
        std::fs::write(&partial, source).map_err(text)?;
        std::fs::rename(&partial, &path).map_err(text)?;
        paths.push(path);
    }
    Ok(paths)
}

/// Validates a stage's module. An error names the file and line that it is about.
fn validated_stage(stage: &Stage) -> Outcome {
    let composed = stage.composed()?;
    let at = |location: Option<naga::SourceLocation>| location.map_or(0, |location| location.line_number as usize);
    let module = naga::front::wgsl::parse_str(&composed.wgsl)
        .map_err(|error| composed.located(at(error.location(&composed.wgsl)), error.message()))?;
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    let valid = validator.validate(&module);
    valid
        .map_err(|error| composed.located(at(error.location(&composed.wgsl)), &error.emit_to_string(&composed.wgsl)))?;
    Ok(())
}

/// Shaders are read from a folder that is named at run time, and an error in one names its file and line.
fn broken_file() -> Outcome {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("broken_wgsl");
    for (name, wgsl) in FILES {
        let path = folder.join(format!("{name}.wgsl"));
        std::fs::create_dir_all(path.parent().unwrap_or(&folder)).map_err(text)?;
        std::fs::write(path, wgsl).map_err(text)?;
    }
    let composes = |folder: &Path| -> Result<std::process::Output, String> {
        let program = std::env::current_exe().map_err(text)?;
        Command::new(program).arg("wgsl_composes").env("RIMLINE_WGSL", folder).output().map_err(text)
    };
    if !composes(&folder)?.status.success() {
        return Err("negative control: the files as they are do not compose from a folder".to_owned());
    }
    let path = folder.join("common/positions.wgsl");
    let wgsl = std::fs::read_to_string(&path).map_err(text)?;
    let line = wgsl.lines().position(|line| line.starts_with("fn position_bits(")).ok_or("no such function")? + 2;
    let broken = |(number, text)| if number == line { "  let word = 1.0 + 1u;" } else { text };
    let broken: Vec<_> = (1..).zip(wgsl.lines()).map(broken).collect();
    std::fs::write(&path, broken.join("\n") + "\n").map_err(text)?;
    let output = composes(&folder)?;
    let message = String::from_utf8_lossy(&output.stdout);
    let location = format!("wgsl/common/positions.wgsl:{line}: ");
    if output.status.success() || !message.contains(&location) {
        return Err(format!("no error at {location}: {message}"));
    }
    Ok(())
}

fn composes() -> Outcome {
    for stage in STAGES.iter().chain(DRAWN) {
        validated_stage(stage)?;
    }
    write_modules()?;
    for (name, source) in modules()? {
        validated(&source).map_err(|error| format!("{name}: {error}"))?;
    }
    match validated("fn broken() -> u32 { return 1.0; }") {
        Ok(_) => Err("negative control: naga took a wrong module".to_owned()),
        Err(_) => Ok(()),
    }
}

fn run_tint(path: &Path) -> Outcome {
    let output = Command::new("tint").arg("--format").arg("wgsl").arg(path).output().map_err(text)?;
    let message = String::from_utf8_lossy(&output.stderr);
    if output.status.success() && !message.contains("error:") && !message.contains("warning:") {
        Ok(())
    } else {
        Err(format!("{}: {message}", path.display()))
    }
}

fn tint() -> Outcome {
    for path in write_modules()? {
        run_tint(&path)?;
    }
    let broken = folder().join("broken_on_purpose.wgsl");
    std::fs::write(&broken, "fn broken() -> u32 { return 1.0; }").map_err(text)?;
    let outcome = run_tint(&broken);
    std::fs::remove_file(&broken).map_err(text)?;
    match outcome {
        Ok(()) => Err("negative control: tint took a wrong module".to_owned()),
        Err(_) => Ok(()),
    }
}
