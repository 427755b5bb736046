//! `rimline devices` lists GPUs and what they can do. docs/formats.md describes its JSON.

use std::fmt::Write as _;

use rimline::wgpu;
use serde_json::{Value, json};

use crate::args::DevicesArgs;
use crate::device::{self, OPTIONAL_FEATURES};
use crate::failure::{Failure, NoDevice};
use crate::output::print;

pub(crate) fn run(args: &DevicesArgs) -> Result<(), Failure> {
    let adapters = device::adapters();
    if args.json {
        let list: Vec<Value> = adapters.iter().map(to_json).collect();
        print(&format!("{:#}\n", json!({ "adapters": list })))?;
    } else {
        let blocks: Vec<String> = adapters.iter().map(to_text).collect();
        print(&blocks.join("\n"))?;
    }
    if adapters.is_empty() {
        return Err(NoDevice::none().into());
    }
    Ok(())
}

/// Limits that decide what fits and what runs: JSON key, what it is called for people, value.
fn limits(limits: &wgpu::Limits) -> [(&'static str, &'static str, u64); 6] {
    macro_rules! named {
        ($($limit:ident: $name:literal),*) => { [$((stringify!($limit), $name, u64::from(limits.$limit))),*] };
    }
    named! {
        max_buffer_size: "buffer",
        max_storage_buffer_binding_size: "storage binding",
        max_storage_buffers_per_shader_stage: "storage buffers a stage",
        max_compute_workgroups_per_dimension: "workgroups a dimension",
        max_compute_invocations_per_workgroup: "invocations a workgroup",
        max_texture_dimension_2d: "picture width and height"
    }
}

fn feature_name(feature: wgpu::Features) -> String {
    feature.iter_names().map(|(name, _)| name).collect::<Vec<_>>().join("+")
}

fn to_text(adapter: &wgpu::Adapter) -> String {
    let info = adapter.get_info();
    let mut text = format!("{}\n", info.name);
    let mut line = |name: &str, value: &str| {
        let _ = writeln!(text, "  {name:<26}{value}");
    };
    line("backend", device::backend_name(info.backend));
    line("type", device::kind_name(info.device_type));
    line("driver", format!("{} {}", info.driver, info.driver_info).trim());
    let lacking = device::lacks(adapter).map(|lacking| format!("no, it lacks {lacking}"));
    line("usable", lacking.as_deref().unwrap_or("yes"));
    line("clipping", &clipping(device::wrong_slivers(adapter)));
    for (key, name, value) in limits(&adapter.limits()) {
        let shown = if key.ends_with("size") { format!("{} MiB", value >> 20) } else { value.to_string() };
        line(name, &shown);
    }
    let features = adapter.features();
    for (feature, purpose) in OPTIONAL_FEATURES {
        let there = if features.contains(feature) { "yes" } else { "no" };
        line(&feature_name(feature), &format!("{there:<4} {purpose}"));
    }
    text
}

fn clipping(wrong: Option<usize>) -> String {
    match wrong {
        None => "unknown".into(),
        Some(0) => "right".into(),
        Some(wrong) => format!(
            "wrong at {wrong} pixels of a trial: shadows have specks in programs that do not set `ShadowFormat::trim` (`rimline \
             shadow` sets it)"
        ),
    }
}

fn to_json(adapter: &wgpu::Adapter) -> Value {
    let info = adapter.get_info();
    let features = adapter.features();
    let limits: serde_json::Map<String, Value> =
        limits(&adapter.limits()).into_iter().map(|(key, _, value)| (key.to_owned(), value.into())).collect();
    let named = |present: bool| -> Vec<String> {
        let all = OPTIONAL_FEATURES.iter().filter(|(feature, _)| features.contains(*feature) == present);
        all.map(|&(feature, _)| feature_name(feature)).collect()
    };
    json!({
        "name": info.name,
        "backend": device::backend_name(info.backend),
        "type": device::kind_name(info.device_type),
        "driver": info.driver,
        "driver_info": info.driver_info,
        "usable": device::lacks(adapter).is_none(),
        "lacks": device::lacks(adapter),
        "wrong_clipping": device::wrong_slivers(adapter),
        "limits": limits,
        "optional_features": { "present": named(true), "missing": named(false) },
    })
}
