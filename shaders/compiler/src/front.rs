//! Parsing and validation by naga, with messages that name the part.

use naga::WithSpan;
use naga::valid::{Capabilities, ModuleInfo, ValidationError, ValidationFlags, Validator};

use crate::explain::{Logic, explained, returns_another_type, stores_another_type};
use crate::rules::Rule;
use crate::source::{Refusal, Source};
use crate::syntax::Mistake;
use crate::words::blank_comments;

/// Naga's messages for an undeclared name, and for a field that a struct doesn't have.
const UNKNOWN: [&str; 2] = ["no definition in scope", "invalid field accessor"];

fn is_unknown(message: &str) -> bool {
    UNKNOWN.iter().any(|words| message.starts_with(words))
}

/// Whether WGSL has a function with this name. If so, naga only complains about its arguments.
pub(crate) fn has_function(name: &str) -> bool {
    let call = format!("fn {name}_() {{ _ = {name}(); }}");
    naga::front::wgsl::parse_str(&call).map_or_else(|error| !is_unknown(error.message()), |_| true)
}

/// Validates a module.
pub(crate) fn validate(module: &naga::Module) -> Result<ModuleInfo, Box<WithSpan<ValidationError>>> {
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(module).map_err(Box::new)
}

/// Parses and validates a kernel.
///
/// # Errors
/// The first message of naga, with the part and its line.
pub(crate) fn parse(source: &Source) -> Result<(naga::Module, ModuleInfo), Refusal> {
    let module = naga::front::wgsl::parse_str(&source.text).map_err(|error| {
        if error.message().starts_with("Incompatible operands: Logical")
            && let Some(refusal) = refused_logic(source)
        {
            return refusal;
        }
        let places: Vec<_> = error.labels().filter_map(|(span, _)| span.to_range()).collect();
        let byte = places.first().map_or(0, |range| range.start);
        let labels: Vec<_> = error
            .labels()
            .map(|(_, text)| text.to_owned())
            .filter(|text| !text.is_empty())
            .collect();
        let is_unknown = is_unknown(error.message());
        let mistake = Mistake {
            message: error.message(),
            labels: &labels,
            text: &blank_comments(&source.text),
            at: byte,
            other: places.get(1).map(|range| source.place(range.start).to_string()),
        };
        Refusal {
            place: source.place(byte),
            function: None,
            rule: if is_unknown { Rule::UnknownName } else { Rule::ValidWgsl },
            message: mistake.explained(),
        }
    })?;
    let info = validate(&module).map_err(|error| {
        let logic = stores_another_type(error.as_inner()).then(|| refused_logic(source));
        logic
            .flatten()
            .unwrap_or_else(|| refused(source, &module, &error, Logic::AsWritten))
    })?;
    Ok((module, info))
}

/// The refusal of a `&&` or `||` between values that aren't bools, if that is a kernel's first mistake. Naga turns these operators
/// into branches and then has neither their place nor the types on both sides. Of `&` and `|`, which take the same bools and
/// bind in the same order, it has both.
fn refused_logic(source: &Source) -> Option<Refusal> {
    let text = blank_comments(&source.text).replace("&&", "& ").replace("||", "| ");
    let module = naga::front::wgsl::parse_str(&text).ok()?;
    let error = validate(&module).err()?;
    Some(refused(source, &module, &error, Logic::AsBits))
}

/// The validator's refusals of a module, with their places.
fn refused(source: &Source, module: &naga::Module, error: &WithSpan<ValidationError>, logic: Logic) -> Refusal {
    let smallest = || {
        let spans = error.spans().filter_map(|(span, _)| span.to_range());
        // The first is that of the whole function.
        spans.min_by_key(ExactSizeIterator::len)
    };
    let place = returns_another_type(module, error.as_inner()).and_then(naga::Span::to_range);
    let byte = place.or_else(smallest).map_or(0, |range| range.start);
    let message = explained(module, error.as_inner(), logic).unwrap_or_else(|| {
        let mut message = error.as_inner().to_string();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(inner) = cause {
            message = format!("{message}: {inner}");
            cause = inner.source();
        }
        message
    });
    Refusal {
        place: source.place(byte),
        function: None,
        rule: Rule::ValidWgsl,
        message,
    }
}
