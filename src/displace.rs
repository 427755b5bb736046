//! A caller's displacement function. naga checks it, and the deform stage takes it in, before a pipeline is made.

pub(crate) mod bounds;
mod tokens;

use naga::back::PipelineConstants;
use naga::back::pipeline_constants::process_overrides;
use naga::valid::ModuleInfo;
use naga::{Binding, Module, Span, TypeInner, VectorSize};

use crate::stages::DISPLACED_DEFORM;

/// The index of the bind group that a displacement may use.
pub const DISPLACE_GROUP: u32 = 1;

/// WGSL with a function `fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32>` and the functions that
/// it calls. It returns the displaced position in world space.
///
/// `position` is in world space, after morph and skin. `vertex` is an element of
/// [`Geometry::source_vertices`](crate::Geometry::source_vertices), the same in all instances. `time` is in seconds. The
/// source may declare its own resources in bind group [`DISPLACE_GROUP`]; within `wgpu::Limits::default()` that is up to
/// two storage buffers. The source's size has bounds, see [`DisplaceError::TooLarge`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Displacement {
    source: String,
    uses_resources: bool,
}

/// Why a displacement is refused. Lines and columns count from 1 in the caller's own source. A message of naga has its
/// first 500 characters.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum DisplaceError {
    /// It is not valid WGSL.
    #[error("displacement, line {line}, column {column}: {message}")]
    Wgsl { line: u32, column: u32, message: String },
    /// There is no function `displace`.
    #[error("the displacement declares no function `displace`; it needs `{SIGNATURE}`")]
    Missing,
    /// `displace` has other arguments or another result.
    #[error("displacement, line {line}: `displace` must be `{SIGNATURE}`")]
    Signature { line: u32 },
    /// A resource lies in another bind group.
    #[error(
        "displacement, line {line}: `{name}` is in bind group {group}; a displacement's resources belong in group 1"
    )]
    Group { line: u32, name: String, group: u32 },
    /// It is too large. A larger source could end the process in naga or in a driver. `needed` is a lower bound.
    ///
    /// Before parsing, the bounds are:
    /// * 65,536 bytes of source.
    /// * 255 brackets and operators within each other.
    /// * 1,023 declarations outside functions.
    /// * 65,536 elements of an array with a fixed length. The length is a number, or an expression of sums and products
    ///   of numbers and constants. The check multiplies all numbers of the expression, each increased by one, and
    ///   compares the product with this bound. An array of runtime size has no bound.
    /// * 262,144 words and signs, after every constant, alias and structure is replaced by what it stands for. An array
    ///   counts as a sixteenth of its elements more.
    ///
    /// After parsing, they are:
    /// * 8,192 bytes of all private variables.
    /// * 8,192 bytes of one value, and of a function's variables together with those of a called function once for each call.
    /// * 16,384 bytes of all workgroup variables.
    /// * 65,536 statements and expressions in a function, after every call is replaced by the function that it calls.
    #[error(
        "displacement, line {line}: it has {needed} {what}, more than the {limit} that are allowed; make it smaller"
    )]
    TooLarge { line: u32, what: &'static str, needed: u64, limit: u64 },
    /// An `enable` directive requests an extension of WGSL. A device has it only if it was opened with it.
    #[error(
        "displacement, line {line}: `enable {names}` asks for an extension of WGSL, which the deform stage does not have; \
         remove the line, and use WGSL without extensions"
    )]
    Enable { line: u32, names: String },
    /// The length of an array is an expression whose value has no known bound. See [`Self::TooLarge`].
    #[error(
        "displacement, line {line}: nothing bounds the length of the array; write a number, or sums and products of numbers \
         and constants"
    )]
    ArrayLength { line: u32 },
    /// The source has an entry point.
    #[error("the displacement declares the entry point `{name}`; it must have functions only")]
    EntryPoint { name: String },
}

/// The most characters of naga's message in an error.
const LONGEST_MESSAGE: usize = 500;

const SIGNATURE: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32>";

impl Displacement {
    /// Checks `source` alone and within the deform stage.
    ///
    /// # Errors
    /// [`DisplaceError`], with the line of `source`.
    pub fn new(source: &str) -> Result<Self, DisplaceError> {
        tokens::check(source)?;
        let module = parse(source, source)?;
        if let Some(entry_point) = module.entry_points.first() {
            return Err(DisplaceError::EntryPoint { name: entry_point.name.clone() });
        }
        check_signature(&module, source)?;
        let mut uses_resources = false;
        for (handle, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            uses_resources = true;
            if binding.group != DISPLACE_GROUP {
                let line = line_of(module.global_variables.get_span(handle), source);
                let name = variable.name.clone().unwrap_or_default();
                return Err(DisplaceError::Group { line, name, group: binding.group });
            }
        }
        check_overrides(&module, source)?;
        bounds::check(&module, &validate(&module, source, source)?, source)?;
        let displacement = Self { source: source.to_owned(), uses_resources };
        let composed = displacement.deform_wgsl();
        let module = parse(&composed, source)?;
        check_defaults(&module, &validate(&module, &composed, source)?, &composed, source)?;
        Ok(displacement)
    }

    /// Whether the source declares resources. The deform stage then needs a bind group from the caller.
    pub fn uses_resources(&self) -> bool {
        self.uses_resources
    }

    /// The WGSL of the deform stage with this displacement. The caller's source comes first, so its line numbers hold.
    pub(crate) fn deform_wgsl(&self) -> String {
        format!("{}\n{}", self.source, DISPLACED_DEFORM.wgsl())
    }
}

/// Parses `text`, which begins with the caller's `source`. Errors give lines and columns of `source`.
fn parse(text: &str, source: &str) -> Result<Module, DisplaceError> {
    naga::front::wgsl::parse_str(text).map_err(|error| {
        let spans: Vec<Span> = error.labels().map(|(span, _)| span).collect();
        wgsl_error(error.message().to_owned(), &spans, source)
    })
}

fn validate(module: &Module, text: &str, source: &str) -> Result<ModuleInfo, DisplaceError> {
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    validator.validate(module).map_err(|error| {
        let spans: Vec<Span> = error.spans().map(|(span, _)| *span).collect();
        // The outer error only names the function; the inner one says what is wrong.
        let mut message = error.as_inner().to_string();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(error) = cause {
            message = format!("{message}: {error}");
            cause = error.source();
        }
        debug_assert!(text.starts_with(source));
        wgsl_error(message, &spans, source)
    })
}

/// An error at the first of `spans` that lies in `source`. The most precise span comes first.
fn wgsl_error(message: String, spans: &[Span], source: &str) -> DisplaceError {
    let ranges = spans.iter().filter_map(|span| span.to_range()).filter(|range| range.start <= source.len());
    let span = ranges.min_by_key(ExactSizeIterator::len).map_or(Span::UNDEFINED, |range| {
        let end = range.end.min(source.len());
        Span::new(range.start.min(end) as u32, end as u32)
    });
    let location = span.location(source);
    // naga quotes whole words, which may be as long as the source.
    let message = match message.char_indices().nth(LONGEST_MESSAGE) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message,
    };
    DisplaceError::Wgsl { line: location.line_number.max(1), column: location.line_position.max(1), message }
}

/// Refuses an override without a default. Nobody gives it a value, so the pipeline would fail.
fn check_overrides(module: &Module, source: &str) -> Result<(), DisplaceError> {
    let mut overrides = module.overrides.iter();
    match overrides.find(|(_, constant)| constant.init.is_none()) {
        None => Ok(()),
        Some((handle, constant)) => {
            let name = constant.name.as_deref().unwrap_or_default();
            let message = format!("override `{name}` has no default, and nothing sets it; write `const` or a default");
            Err(wgsl_error(message, &[module.overrides.get_span(handle)], source))
        }
    }
}

/// Refuses overrides whose defaults make no number, for example an infinite product, or too large a workgroup array. Only
/// making a pipeline computes them. `text` begins with `source`.
fn check_defaults(module: &Module, info: &ModuleInfo, text: &str, source: &str) -> Result<(), DisplaceError> {
    let computed = process_overrides(module, info, None, &PipelineConstants::default());
    let (computed, _) = computed.map_err(|error| {
        let spans: Vec<Span> = module.overrides.iter().map(|(handle, _)| module.overrides.get_span(handle)).collect();
        wgsl_error(format!("what the defaults of the overrides come to: {error}"), &spans, source)
    })?;
    // Private variables have no such lengths, and some are those of the stage.
    bounds::check_variables(&computed, text, &[naga::AddressSpace::WorkGroup])
}

fn line_of(span: Span, source: &str) -> u32 {
    span.location(source).line_number
}

fn check_signature(module: &Module, source: &str) -> Result<(), DisplaceError> {
    let mut functions = module.functions.iter();
    let Some((handle, function)) = functions.find(|(_, function)| function.name.as_deref() == Some("displace")) else {
        return Err(DisplaceError::Missing);
    };
    let is = |ty: naga::Handle<naga::Type>, inner: &TypeInner| &module.types[ty].inner == inner;
    let vec3 = TypeInner::Vector { size: VectorSize::Tri, scalar: naga::Scalar::F32 };
    let expected = [vec3.clone(), TypeInner::Scalar(naga::Scalar::U32), TypeInner::Scalar(naga::Scalar::F32)];
    let plain = |binding: &Option<Binding>| binding.is_none();
    let arguments_fit = function.arguments.len() == expected.len()
        && function.arguments.iter().zip(&expected).all(|(given, inner)| is(given.ty, inner) && plain(&given.binding));
    let result_fits = function.result.as_ref().is_some_and(|result| is(result.ty, &vec3) && plain(&result.binding));
    if arguments_fit && result_fits {
        Ok(())
    } else {
        Err(DisplaceError::Signature { line: line_of(module.functions.get_span(handle), source) })
    }
}
