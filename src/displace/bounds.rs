//! The bounds of [`DisplaceError::TooLarge`]. They are WGSL's own limits where it has them (section "Limits").

use naga::proc::TypeResolution;
use naga::valid::ModuleInfo;
use naga::{AddressSpace, Block, Function, Handle, Module, Statement};

use super::{DisplaceError, line_of};

/// The largest size of the source, in bytes.
pub const MAX_SOURCE_BYTES: usize = 1 << 16;
/// The deepest nesting of brackets and operators. Compilers recurse as deep.
pub const MAX_NESTING: u64 = 255;
/// The largest number of words and signs with names of constants and types replaced by what they stand for. naga copies a
/// constant into a function wherever an element is read from it.
pub(crate) const MAX_EXPANDED: u64 = 1 << 18;
/// The largest number of declarations outside functions.
pub(crate) const MAX_DECLARATIONS: u64 = 1023;
/// The largest number of elements of an array with a fixed length.
pub(crate) const MAX_ARRAY_ELEMENTS: u64 = 1 << 16;
/// The largest size of all private variables, in bytes.
pub const MAX_PRIVATE_BYTES: u64 = 8192;
/// The largest size of one value, and of a function's variables together with those of a called function once for each
/// call, in bytes.
pub const MAX_FUNCTION_BYTES: u64 = 8192;
/// The largest size of all workgroup variables, in bytes.
pub(crate) const MAX_WORKGROUP_BYTES: u64 = 16384;
/// The largest number of statements and expressions with calls replaced by what they call, which drivers do.
pub(crate) const MAX_OPERATIONS: u64 = 1 << 16;

pub(super) fn too_large(line: u32, what: &'static str, needed: u64, limit: u64) -> DisplaceError {
    DisplaceError::TooLarge { line, what, needed, limit }
}

/// Checks what a driver would have to hold: variables, values, and functions inlined into their callers.
pub(super) fn check(module: &Module, info: &ModuleInfo, source: &str) -> Result<(), DisplaceError> {
    let size = |ty| size(module, ty);
    check_variables(module, source, &[AddressSpace::Private, AddressSpace::WorkGroup])?;
    for (handle, _) in module.global_expressions.iter() {
        let line = || line_of(module.global_expressions.get_span(handle), source);
        check_value(&info[handle], &size, line)?;
    }
    // Functions come after the functions that they call.
    let mut costs: Vec<Cost> = Vec::new();
    for (handle, function) in module.functions.iter() {
        for (expression, _) in function.expressions.iter() {
            let line = || line_of(function.expressions.get_span(expression), source);
            check_value(&info[handle][expression].ty, &size, line)?;
        }
        let cost = cost(function, &costs, &size);
        let line = || line_of(module.functions.get_span(handle), source);
        let bounds = [
            ("bytes of variables in a function and those it calls", cost.bytes, MAX_FUNCTION_BYTES),
            ("operations in a function and those it calls", cost.operations, MAX_OPERATIONS),
        ];
        if let Some((what, needed, limit)) = bounds.into_iter().find(|(_, needed, limit)| needed > limit) {
            return Err(too_large(line(), what, needed, limit));
        }
        costs.push(cost);
    }
    Ok(())
}

/// Checks the private or workgroup variables in these address spaces. Workgroup arrays whose lengths are computed from
/// overrides count as empty while the module has overrides.
pub(super) fn check_variables(module: &Module, source: &str, spaces: &[AddressSpace]) -> Result<(), DisplaceError> {
    let (mut private, mut workgroup) = (0, 0);
    for (handle, variable) in module.global_variables.iter().filter(|(_, variable)| spaces.contains(&variable.space)) {
        let (sum, what, limit) = match variable.space {
            AddressSpace::Private => (&mut private, "bytes of private variables", MAX_PRIVATE_BYTES),
            AddressSpace::WorkGroup => (&mut workgroup, "bytes of workgroup variables", MAX_WORKGROUP_BYTES),
            _ => continue,
        };
        *sum += size(module, variable.ty);
        if *sum > limit {
            return Err(too_large(line_of(module.global_variables.get_span(handle), source), what, *sum, limit));
        }
    }
    Ok(())
}

fn size(module: &Module, ty: Handle<naga::Type>) -> u64 {
    u64::from(module.types[ty].inner.try_size(module.to_ctx()).unwrap_or(u32::MAX))
}

fn check_value(
    ty: &TypeResolution,
    size: &impl Fn(Handle<naga::Type>) -> u64,
    line: impl Fn() -> u32,
) -> Result<(), DisplaceError> {
    // Types without a handle are scalars, vectors, matrices and pointers.
    let TypeResolution::Handle(handle) = ty else { return Ok(()) };
    let bytes = size(*handle);
    if bytes > MAX_FUNCTION_BYTES {
        return Err(too_large(line(), "bytes of one value", bytes, MAX_FUNCTION_BYTES));
    }
    Ok(())
}

/// The cost of a function with all that it calls.
#[derive(Clone, Copy, Default)]
struct Cost {
    bytes: u64,
    operations: u64,
}

fn cost(function: &Function, costs: &[Cost], size: &impl Fn(Handle<naga::Type>) -> u64) -> Cost {
    let mut cost = Cost { bytes: 0, operations: function.expressions.len() as u64 };
    for (_, variable) in function.local_variables.iter() {
        cost.bytes = cost.bytes.saturating_add(size(variable.ty));
    }
    add_calls(&function.body, costs, &mut cost);
    cost
}

/// Adds the cost of the functions that a block calls. Statements nest no deeper than brackets may.
fn add_calls(block: &Block, costs: &[Cost], cost: &mut Cost) {
    for statement in block {
        cost.operations = cost.operations.saturating_add(1);
        match statement {
            Statement::Block(block) => add_calls(block, costs, cost),
            Statement::If { accept, reject, .. } => {
                add_calls(accept, costs, cost);
                add_calls(reject, costs, cost);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| add_calls(&case.body, costs, cost)),
            Statement::Loop { body, continuing, .. } => {
                add_calls(body, costs, cost);
                add_calls(continuing, costs, cost);
            }
            Statement::Call { function, .. } => {
                let called = costs.get(function.index()).copied().unwrap_or_default();
                cost.bytes = cost.bytes.saturating_add(called.bytes);
                cost.operations = cost.operations.saturating_add(called.operations);
            }
            _ => {}
        }
    }
}
