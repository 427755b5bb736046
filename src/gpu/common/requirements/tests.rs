//! Compares the table with the WGSL, by naga's reflection, and with `wgpu::Limits`.

use std::collections::BTreeMap;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module};

use super::*;
use crate::gpu::depth_map::pipelines::drawn_wgsl;
use crate::stages::{DEFORM, DEPTH_SURFACE, DEPTH_WALLS, DRAWN, STAGES, Stage};

/// Limits by name.
type Found = BTreeMap<&'static str, u64>;

/// The subject is the folder of the stage's file.
fn subject(stage: &Stage) -> Subject {
    match stage.file.split_once('/').expect("files lie in folders").0 {
        // A scene is an extraction of many casters.
        "extract" | "scene" | "polygon" => Subject::Extract,
        "shadow" | "outline" | "mask" => Subject::Shadow,
        "query" => Subject::Query,
        "deform" => Subject::Deform,
        "depth_map" => Subject::DepthMap,
        other => panic!("{}: no subject is called {other}", stage.name),
    }
}

fn raise(found: &mut Found, limit: &'static str, value: u64) {
    let most = found.entry(limit).or_default();
    *most = (*most).max(value);
}

/// Raises the limits to what a module needs. Every binding is in its pipelines' layout, for one shader stage.
fn reflect(found: &mut Found, wgsl: &str, is_drawn: bool) {
    let module = naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).expect("valid WGSL");
    let size = |variable: &naga::GlobalVariable| u64::from(module.types[variable.ty].inner.size(module.to_ctx()));
    let [mut uniforms, mut storage, mut textures, mut written, mut groups] = [0; 5];
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else { continue };
        raise(found, "max_bindings_per_bind_group", u64::from(binding.binding) + 1);
        groups = groups.max(u64::from(binding.group) + 1);
        match variable.space {
            AddressSpace::Uniform => {
                uniforms += 1;
                raise(found, "max_uniform_buffer_binding_size", size(variable));
            }
            AddressSpace::Storage { .. } => {
                storage += 1;
                raise(found, "max_storage_buffer_binding_size", size(variable));
            }
            AddressSpace::Handle => match module.types[variable.ty].inner {
                naga::TypeInner::Image { class: naga::ImageClass::Storage { .. }, .. } => written += 1,
                _ => textures += 1,
            },
            other => panic!("{:?} is bound in {other:?}", variable.name),
        }
    }
    raise(found, "max_sampled_textures_per_shader_stage", textures);
    raise(found, "max_storage_textures_per_shader_stage", written);
    raise(found, "max_bind_groups", groups);
    raise(found, "max_uniform_buffers_per_shader_stage", uniforms);
    raise(found, "max_storage_buffers_per_shader_stage", storage);
    raise(found, "max_buffers_and_acceleration_structures_per_shader_stage", uniforms + storage);
    if is_drawn {
        raise(found, "max_bind_groups_plus_vertex_buffers", groups);
        // A light and a camera that are read as one value, not as an array, have a dynamic offset.
        let is_value = |ty| matches!(module.types[ty].inner, naga::TypeInner::Struct { .. });
        let storage = |variable: &&naga::GlobalVariable| matches!(variable.space, AddressSpace::Storage { .. });
        let bound = module.global_variables.iter().map(|(_, variable)| variable).filter(storage);
        let dynamic = bound.filter(|variable| is_value(variable.ty)).count() as u64;
        raise(found, "max_dynamic_storage_buffers_per_pipeline_layout", dynamic);
        return;
    }
    // Every uniform of a compute stage has a dynamic offset.
    raise(found, "max_dynamic_uniform_buffers_per_pipeline_layout", uniforms);
    for (index, entry_point) in module.entry_points.iter().enumerate() {
        let [x, y, z] = entry_point.workgroup_size.map(u64::from);
        raise(found, "max_compute_workgroup_size_x", x);
        raise(found, "max_compute_workgroup_size_y", y);
        raise(found, "max_compute_workgroup_size_z", z);
        raise(found, "max_compute_invocations_per_workgroup", x * y * z);
        raise(found, "max_compute_workgroup_storage_size", workgroup_bytes(&module, &info, index));
    }
}

/// Bytes of workgroup memory that an entry point uses, as WebGPU counts them.
fn workgroup_bytes(module: &Module, info: &naga::valid::ModuleInfo, entry_point: usize) -> u64 {
    let function = info.get_entry_point(entry_point);
    let used = module
        .global_variables
        .iter()
        .filter(|(handle, variable)| variable.space == AddressSpace::WorkGroup && !function[*handle].is_empty());
    used.map(|(_, variable)| u64::from(module.types[variable.ty].inner.size(module.to_ctx())).next_multiple_of(16))
        .sum()
}

/// The workgroups of one dispatch. Two stages of shadow volumes take a workgroup for each light of a batch. A query
/// takes 64 points of a batch of lights, with as many invocations in each workgroup. Other dispatches are cut, or their
/// workgroups take turns.
fn workgroups(subject: Subject) -> u64 {
    if matches!(subject, Subject::Shadow | Subject::Query) { 32 } else { 1 }
}

/// The needs of all stages of a subject together.
fn needed(wanted: Subject) -> Found {
    let mut found = Found::new();
    for stage in STAGES.iter().filter(|stage| subject(stage) == wanted) {
        reflect(&mut found, &stage.wgsl(), false);
    }
    for stage in DRAWN.iter().filter(|stage| subject(stage) == wanted) {
        reflect(&mut found, &stage.wgsl(), true);
    }
    found.entry("max_bind_groups_plus_vertex_buffers").or_default();
    found.entry("max_dynamic_storage_buffers_per_pipeline_layout").or_default();
    // Bindings are cut to multiples of the alignment of offsets, so this is the smallest useful size.
    raise(&mut found, "max_storage_buffer_binding_size", 256);
    let largest = found["max_uniform_buffer_binding_size"].max(found["max_storage_buffer_binding_size"]);
    found.insert("max_buffer_size", largest);
    found.insert("max_compute_workgroups_per_dimension", workgroups(wanted));
    found
}

fn table(subject: Subject) -> Found {
    AT_LEAST.iter().map(|need| (need.limit, need.needed[subject as usize])).collect()
}

#[test]
fn the_table_is_what_the_wgsl_needs() {
    for subject in Subject::ALL {
        assert_eq!(table(subject), needed(subject), "{}", subject.name());
    }
}

/// Negative control: a larger workgroup, a further binding, more workgroup memory, a larger uniform.
#[test]
fn a_stage_that_needs_more_is_noticed() {
    for more in [
        "@compute @workgroup_size(512) fn more() {}",
        "@compute @workgroup_size(1, 2) fn more() {}",
        "@group(0) @binding(11) var<storage> more: u32;",
        "@group(1) @binding(0) var<uniform> more: u32;",
        "@group(0) @binding(11) var<uniform> more: array<vec4<u32>, 500>;",
        "var<workgroup> more: array<u32, 9000>; @compute @workgroup_size(1) fn used() { more[0] = 1u; }",
    ] {
        for wanted in Subject::ALL {
            let mut found = needed(wanted);
            for stage in STAGES.iter().filter(|stage| subject(stage) == wanted && **stage != DEFORM) {
                reflect(&mut found, &format!("{}\n{more}", stage.wgsl()), false);
            }
            assert!(wanted == Subject::Deform || found != table(wanted), "{}: {more}", wanted.name());
        }
    }
}

#[test]
fn default_limits_serve_and_lower_ones_do_not() {
    for subject in Subject::ALL {
        let check = |limits| check_limits(&limits, subject);
        assert_eq!(check(wgpu::Limits::default()), Ok(()));
        assert_eq!(check(wgpu::Limits::unlimited()), Ok(()));
        let (name, index) = (subject.name(), subject as usize);
        // Depth maps have five storage buffers, deformation has six, all others eight.
        let needed = AT_LEAST.iter().find(|need| need.limit == "max_storage_buffers_per_shader_stage");
        let needed = needed.expect("the table has it").needed[index];
        let limit = "max_storage_buffers_per_shader_stage";
        let too_few = DeviceError::Limit { subject: name, limit, needed, there: 4 };
        let expected = if needed > 4 { Err(too_few) } else { Ok(()) };
        assert_eq!(check(wgpu::Limits::downlevel_defaults()), expected);
        let limit = "max_compute_workgroups_per_dimension";
        let none = DeviceError::Limit { subject: name, limit, needed: workgroups(subject), there: 0 };
        assert_eq!(check(wgpu::Limits::downlevel_webgl2_defaults()), Err(none));
    }
}

#[test]
fn coarse_alignments_do_not_serve() {
    for subject in Subject::ALL {
        for coarse in [
            wgpu::Limits { min_uniform_buffer_offset_alignment: 512, ..Default::default() },
            wgpu::Limits { min_storage_buffer_offset_alignment: 512, ..Default::default() },
        ] {
            let found = check_limits(&coarse, subject);
            assert!(matches!(found, Err(DeviceError::Alignment { needed: 256, there: 512, .. })), "{found:?}");
        }
    }
}

#[test]
fn a_message_names_limit_need_and_what_is_there() {
    let found = check_limits(&wgpu::Limits::downlevel_defaults(), Subject::Extract).expect_err("4 are too few");
    let message = found.to_string();
    assert!(message.starts_with("extraction needs `max_storage_buffers_per_shader_stage` of at least 8"), "{message}");
    assert!(message.contains("the device has 4"), "{message}");
}

/// Whether an adapter without sample-rate shading takes a module.
fn is_valid_without_sample_shading(wgsl: &str) -> bool {
    let module = naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    let capabilities = Capabilities::default() - Capabilities::MULTISAMPLED_SHADING;
    Validator::new(ValidationFlags::all(), capabilities).validate(&module).is_ok()
}

#[test]
fn only_draws_with_several_samples_need_sample_shading() {
    for stage in STAGES.iter().chain(DRAWN).filter(|stage| ![DEPTH_SURFACE, DEPTH_WALLS].contains(stage)) {
        let is_taken = is_valid_without_sample_shading(&drawn_wgsl(stage, 1));
        assert!(is_taken, "{}", stage.name);
    }
    for stage in [&DEPTH_SURFACE, &DEPTH_WALLS] {
        let is_valid = [1, 4].map(|samples| is_valid_without_sample_shading(&drawn_wgsl(stage, samples)));
        assert_eq!(is_valid, [true, false], "{}", stage.name);
    }
    // This module needs sample shading and nothing else.
    assert!(!is_valid_without_sample_shading(SAMPLE_SHADING));
    assert!(is_valid_without_sample_shading(&SAMPLE_SHADING.replace(", sample", "")));
}
