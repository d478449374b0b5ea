//! Parsing and validation by naga, with messages that name the part.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use crate::explain::explained;
use crate::source::{Refusal, Refusals, Source};

/// Parses and validates a kernel.
///
/// # Errors
/// Messages of naga, with the part and its line.
pub(crate) fn parse(source: &Source) -> Result<(naga::Module, ModuleInfo), Refusals> {
    let module = naga::front::wgsl::parse_str(&source.text).map_err(|error| {
        let byte = error
            .labels()
            .next()
            .and_then(|(span, _)| span.to_range())
            .map_or(0, |range| range.start);
        let labels: Vec<_> = error
            .labels()
            .map(|(_, text)| text.to_owned())
            .filter(|text| !text.is_empty())
            .collect();
        let mut message = error.message().to_owned();
        if !labels.is_empty() {
            message = format!("{message} ({})", labels.join("; "));
        }
        vec![Refusal {
            place: source.place(byte),
            function: None,
            message,
        }]
    })?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| {
            let byte = error
                .spans()
                .filter_map(|(span, _)| span.to_range())
                // The first is that of the whole function.
                .min_by_key(ExactSizeIterator::len)
                .map_or(0, |range| range.start);
            let message = explained(&module, error.as_inner()).unwrap_or_else(|| {
                let mut message = error.as_inner().to_string();
                let mut cause = std::error::Error::source(error.as_inner());
                while let Some(inner) = cause {
                    message = format!("{message}: {inner}");
                    cause = inner.source();
                }
                message
            });
            vec![Refusal {
                place: source.place(byte),
                function: None,
                message,
            }]
        })?;
    Ok((module, info))
}
