//! Structs of the WGSL against `rimline::internals::layout::LAYOUTS`, by naga's reflection.

use std::collections::{BTreeMap, BTreeSet};

use naga::{AddressSpace, ArraySize, Module, ScalarKind, TypeInner};
use rimline::internals::layout::{FieldLayout, LAYOUTS, StructLayout};

use crate::{Outcome, modules, modules_with, validated};

/// A WGSL type as Rust writes its counterpart. An atomic counts as its scalar.
fn rust_type(module: &Module, ty: naga::Handle<naga::Type>) -> String {
    let scalar = |scalar: naga::Scalar| {
        let kind = match scalar.kind {
            ScalarKind::Uint => "u",
            ScalarKind::Sint => "i",
            ScalarKind::Float => "f",
            _ => "?",
        };
        format!("{kind}{}", 8 * scalar.width)
    };
    match &module.types[ty].inner {
        TypeInner::Scalar(of) | TypeInner::Atomic(of) => scalar(*of),
        TypeInner::Vector { size, scalar: of } => format!("[{}; {}]", scalar(*of), *size as u8),
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            format!("[{}; {count}]", rust_type(module, *base))
        }
        TypeInner::Struct { .. } => module.types[ty].name.clone().unwrap_or_default(),
        other => format!("{other:?}"),
    }
}

/// Compares a module's structs of a listed name with the list; returns the names found.
fn check_layouts(module: &Module, listed: &[StructLayout]) -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    for (_, ty) in module.types.iter() {
        let (Some(name), TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) else {
            continue;
        };
        let Some(layout) = listed.iter().find(|layout| layout.name == name) else {
            continue;
        };
        if *span as usize != layout.size || members.len() != layout.fields.len() {
            return Err(format!("{name}: {span} bytes and {} members", members.len()));
        }
        for (member, field) in members.iter().zip(layout.fields) {
            let member_name = member.name.as_deref().unwrap_or_default();
            let size = module.types[member.ty].inner.size(module.to_ctx()) as usize;
            let ty = rust_type(module, member.ty);
            let got = (member_name, member.offset as usize, size, ty.as_str());
            let expected = (field.name, field.offset, field.size, field.rust_type);
            if got != expected {
                return Err(format!("{name}: WGSL has {got:?}, Rust {expected:?}"));
            }
        }
        found.push(name.clone());
    }
    Ok(found)
}

/// The names of all structs of the list. Some are in no module, for their words are read one by one.
fn names() -> String {
    LAYOUTS.iter().map(|layout| layout.name).collect::<Vec<_>>().join(" ")
}

pub(crate) fn layouts() -> Outcome {
    let mut found = BTreeSet::new();
    for (name, source) in modules_with(&names())? {
        let (module, _) = validated(&source)?;
        found.extend(check_layouts(&module, LAYOUTS).map_err(|error| format!("{name}: {error}"))?);
    }
    match LAYOUTS.iter().find(|layout| !found.contains(layout.name)) {
        Some(layout) => Err(format!("{} is in no WGSL file", layout.name)),
        None => Ok(()),
    }
}

/// Each struct that a buffer holds must be in the list of structs that Rust writes or reads. An exception is a list
/// that only stages share, which ends in an array of no fixed size: it must have the same layout in all stages.
pub(crate) fn bound_structs() -> Outcome {
    let mut lists = BTreeMap::new();
    for (name, source) in modules()? {
        let (module, _) = validated(&source)?;
        for (_, variable) in module.global_variables.iter() {
            let is_in_group_0 = variable.binding.as_ref().is_some_and(|binding| binding.group == 0);
            if !is_in_group_0 || !matches!(variable.space, AddressSpace::Uniform | AddressSpace::Storage { .. }) {
                continue;
            }
            let mut ty = variable.ty;
            while let TypeInner::Array { base, .. } = module.types[ty].inner {
                ty = base;
            }
            let held = &module.types[ty];
            let TypeInner::Struct { members, .. } = &held.inner else { continue };
            if LAYOUTS.iter().any(|layout| Some(layout.name) == held.name.as_deref()) {
                continue;
            }
            let is_list =
                members.last().is_some_and(|last| module.types[last.ty].inner.is_dynamically_sized(&module.types));
            if !is_list {
                return Err(format!("{name}: {:?} is bound and not in LAYOUTS", held.name));
            }
            let fields: Vec<_> = members.iter().map(|m| (m.name.clone(), m.offset, element(&module, m.ty))).collect();
            let before = lists.entry(variable.name.clone()).or_insert_with(|| fields.clone());
            if *before != fields {
                return Err(format!("{name}: {:?} is {fields:?}, elsewhere {before:?}", variable.name));
            }
        }
    }
    Ok(())
}

/// A type, or that of an unsized array's elements.
fn element(module: &Module, ty: naga::Handle<naga::Type>) -> String {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Dynamic, .. } => format!("[{}]", rust_type(module, base)),
        _ => rust_type(module, ty),
    }
}

/// Moves, resizes, retypes and renames one field of every struct, and drops one: each must be noticed.
pub(crate) fn perturbed_layouts() -> Outcome {
    for layout in LAYOUTS {
        let wgsl = modules_with(layout.name)?.into_iter().map(|(_, source)| validated(&source));
        let holding = wgsl.map(|module| module.map(|(module, _)| module)).find(|module| {
            let layouts = module.as_ref().map(|module| check_layouts(module, &[*layout]));
            matches!(layouts, Ok(Ok(found)) if !found.is_empty())
        });
        let Some(Ok(module)) = holding else {
            return Err(format!("{} not found", layout.name));
        };
        let perturbations: [fn(&mut StructLayout, &mut Vec<FieldLayout>); 6] = [
            |layout, _| layout.size += 4,
            |_, fields| fields[0].offset += 4,
            |_, fields| fields[0].size += 4,
            |_, fields| fields[0].rust_type = "i32",
            |_, fields| fields[0].name = "other",
            |_, fields| fields.truncate(fields.len() - 1),
        ];
        for (number, perturb) in perturbations.into_iter().enumerate() {
            let (mut wrong, mut fields) = (*layout, layout.fields.to_vec());
            perturb(&mut wrong, &mut fields);
            wrong.fields = Vec::leak(fields);
            if check_layouts(&module, &[wrong]).is_ok() {
                return Err(format!("{}: perturbation {number} went unnoticed", layout.name));
            }
        }
    }
    Ok(())
}
