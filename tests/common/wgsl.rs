//! The WGSL by itself: files and stages, validity for naga, struct layouts. CI gives the modules to tint, too.

mod layouts;
mod turns;

use std::collections::BTreeSet;
use std::path::Path;

use libtest_mimic::{Arguments, Failed, Trial};
use naga::Module;
use rimline::Displacement;
use rimline::internals::displace::deform_wgsl;
use rimline::internals::stages::{DRAWN, FILES, SCENE_FACING, SIDES, STAGES, Stage};

type Outcome = Result<(), String>;
/// A test's name and body.
type Test = (&'static str, fn() -> Outcome);

fn main() {
    let tests: [Test; 9] = [
        ("every_file_is_a_stage_or_an_include", files),
        ("constants_are_those_of_rust", constants),
        ("wgsl_composes", composes),
        ("rustdoc_tells_all_that_the_include_has", include_is_documented),
        ("layouts_are_those_of_rust", layouts::layouts),
        ("layouts_cover_every_bound_struct", layouts::bound_structs),
        ("loops_have_as_many_turns_as_stated", turns::stated),
        ("loops_of_the_command_are_short", turns::of_command),
        ("a_loop_without_a_bound_is_noticed", turns::unstated),
    ];
    let trials =
        tests.into_iter().map(|(name, test)| Trial::test(name, move || test().map_err(Failed::from))).collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

/// A WGSL file outside the list of stages would be dead, untested code.
fn files() -> Outcome {
    let mut found = BTreeSet::new();
    for subject in std::fs::read_dir(root().join("wgsl")).map_err(text)? {
        let subject = subject.map_err(text)?;
        let folder = subject.file_name().to_string_lossy().into_owned();
        for file in std::fs::read_dir(subject.path()).map_err(|error| format!("{folder}: {error}"))? {
            found.insert(format!("{folder}/{}", file.map_err(text)?.file_name().to_string_lossy()));
        }
    }
    let known: BTreeSet<String> = FILES.iter().map(|(name, _)| format!("{name}.wgsl")).collect();
    let stray: Vec<_> = found.symmetric_difference(&known).collect();
    if stray.is_empty() {
        Ok(())
    } else {
        Err(format!("in the folder or in the list of stages, not in both: {stray:?}"))
    }
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

/// The rustdoc of the include has all its functions, structs, members and bindings between backticks.
fn include_is_documented() -> Outcome {
    let source = rimline::gpu::include_wgsl(0);
    let (module, _) = validated(&source)?;
    let rust = std::fs::read_to_string(root().join("src/gpu/extract/include.rs")).map_err(text)?;
    let doc: String = rust.lines().filter(|line| line.starts_with("///")).collect();
    let signatures =
        source.lines().filter_map(|line| line.strip_prefix("fn ")).filter(|line| line.starts_with("rimline_"));
    let mut items: Vec<String> = signatures.map(|line| line.trim_end_matches(" {").to_owned()).collect();
    items.extend(module.global_variables.iter().filter_map(|(_, variable)| variable.name.clone()));
    for (_, ty) in module.types.iter() {
        if let naga::TypeInner::Struct { members, .. } = &ty.inner {
            items.extend(ty.name.clone());
            items.extend(members.iter().filter_map(|member| Some(format!("{}: ", member.name.as_ref()?))));
        }
    }
    let missing =
        |doc: &str| items.iter().filter(|item| !doc.contains(&format!("`{item}"))).cloned().collect::<Vec<_>>();
    if items.len() < 30 || !missing(&doc).is_empty() {
        return Err(format!("of {} items not in the rustdoc of `include_wgsl`: {:?}", items.len(), missing(&doc)));
    }
    match missing(&doc.replace("`winding", "`turned")).len() {
        1 => Ok(()),
        _ => Err("negative control: a member went unnoticed".to_owned()),
    }
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

/// Validates a stage's module. An error names the file and line that it is about.
fn validated_stage(stage: &Stage) -> Outcome {
    let composed = stage.composed()?;
    let at = |location: Option<naga::SourceLocation>| location.map_or(0, |location| location.line_number as usize);
    let module = naga::front::wgsl::parse_str(&composed.wgsl)
        .map_err(|error| composed.located(at(error.location(&composed.wgsl)), error.message()))?;
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    let valid = validator.validate(&module).map(drop);
    valid.map_err(|error| composed.located(at(error.location(&composed.wgsl)), &error.emit_to_string(&composed.wgsl)))
}

/// All modules are valid. They are written to `target/wgsl` for other tools to look at.
fn composes() -> Outcome {
    for stage in STAGES.iter().chain(DRAWN) {
        validated_stage(stage)?;
    }
    let target = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = target.parent().unwrap_or(target).join("wgsl");
    std::fs::create_dir_all(&folder).map_err(text)?;
    for (name, source) in modules()? {
        validated(&source).map_err(|error| format!("{name}: {error}"))?;
        std::fs::write(folder.join(format!("{name}.wgsl")), source).map_err(text)?;
    }
    match validated("fn broken() -> u32 { return 1.0; }") {
        Ok(_) => Err("negative control: naga took a wrong module".to_owned()),
        Err(_) => Ok(()),
    }
}
