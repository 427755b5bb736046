//! Structs of the WGSL against `rimline::internals::layout::LAYOUTS`, by naga's reflection.

use std::collections::{BTreeMap, BTreeSet};

use naga::{AddressSpace, ArraySize, Handle, Module, ScalarKind, Type, TypeInner};
use rimline::internals::layout::{LAYOUTS, StructLayout};

use crate::{Outcome, modules, modules_with, validated};

/// A WGSL type as Rust writes its counterpart, or that of an unsized array's elements. An atomic counts as its scalar.
fn rust_type(module: &Module, ty: Handle<Type>) -> String {
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
        TypeInner::Array { base, size: ArraySize::Dynamic, .. } => format!("[{}]", rust_type(module, *base)),
        TypeInner::Struct { .. } => module.types[ty].name.clone().unwrap_or_default(),
        other => format!("{other:?}"),
    }
}

/// Compares a struct of a module with its counterpart.
fn check(module: &Module, ty: &Type, layout: &StructLayout) -> Outcome {
    let TypeInner::Struct { members, span } = &ty.inner else { return Err("no struct".to_owned()) };
    if *span as usize != layout.size || members.len() != layout.fields.len() {
        return Err(format!("{}: {span} bytes and {} members", layout.name, members.len()));
    }
    for (member, field) in members.iter().zip(layout.fields) {
        let size = module.types[member.ty].inner.size(module.to_ctx()) as usize;
        let ty = rust_type(module, member.ty);
        let got = (member.name.as_deref().unwrap_or_default(), member.offset as usize, size, ty.as_str());
        let expected = (field.name, field.offset, field.size, field.rust_type);
        if got != expected {
            return Err(format!("{}: WGSL has {got:?}, Rust {expected:?}", layout.name));
        }
    }
    Ok(())
}

/// Moves, resizes, retypes and renames one field, and drops one: each must be noticed.
fn check_perturbed(module: &Module, ty: &Type, layout: &StructLayout) -> Outcome {
    for perturbation in 0..6 {
        let (mut wrong, mut fields) = (*layout, layout.fields.to_vec());
        match perturbation {
            0 => wrong.size += 4,
            1 => fields[0].offset += 4,
            2 => fields[0].size += 4,
            3 => fields[0].rust_type = "i32",
            4 => fields[0].name = "other",
            _ => drop(fields.pop()),
        }
        wrong.fields = Vec::leak(fields);
        if check(module, ty, &wrong).is_ok() {
            return Err(format!("{}: perturbation {perturbation} went unnoticed", layout.name));
        }
    }
    Ok(())
}

/// Some structs are in no module, for their words are read one by one.
pub(crate) fn layouts() -> Outcome {
    let mut found = BTreeSet::new();
    let names = LAYOUTS.iter().map(|layout| layout.name).collect::<Vec<_>>().join(" ");
    for (name, source) in modules_with(&names)? {
        let (module, _) = validated(&source)?;
        for (_, ty) in module.types.iter() {
            if let Some(layout) = LAYOUTS.iter().find(|layout| Some(layout.name) == ty.name.as_deref()) {
                check(&module, ty, layout).map_err(|error| format!("{name}: {error}"))?;
                if found.insert(layout.name) {
                    check_perturbed(&module, ty, layout)?;
                }
            }
        }
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
            let fields: Vec<_> = members.iter().map(|m| (m.name.clone(), m.offset, rust_type(&module, m.ty))).collect();
            let before = lists.entry(variable.name.clone()).or_insert_with(|| fields.clone());
            if *before != fields {
                return Err(format!("{name}: {:?} is {fields:?}, elsewhere {before:?}", variable.name));
            }
        }
    }
    Ok(())
}
