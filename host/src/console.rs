//! Where words go: data to standard output, messages to standard error.

use std::io::{self, Write};

use crate::cli::Output;
use crate::exit::{Failure, Result};

/// The program's two voices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    output: Output,
}

impl Console {
    /// Talks as the command line asks.
    pub(crate) fn new(output: Output) -> Self {
        Self { output }
    }

    /// Whether data are to be JSON.
    pub(crate) fn json(self) -> bool {
        self.output.json
    }

    /// Whether messages and progress are unwanted.
    pub(crate) fn quiet(self) -> bool {
        self.output.quiet
    }

    /// Prints data; a missing line end is added.
    #[expect(clippy::unused_self, reason = "all that is printed goes through the console")]
    pub(crate) fn data(self, text: impl AsRef<str>) -> Result {
        let text = text.as_ref();
        let mut stdout = io::stdout().lock();
        stdout
            .write_all(text.as_bytes())
            .and_then(|()| {
                if text.ends_with('\n') {
                    Ok(())
                } else {
                    stdout.write_all(b"\n")
                }
            })
            .and_then(|()| stdout.flush())
            .map_err(|error| Failure::stdout(&error))
    }

    /// Prints data as JSON, indented.
    pub(crate) fn json_data(self, value: &impl serde::Serialize) -> Result {
        let text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
        self.data(text)
    }

    /// Tells the user something, unless they asked for quiet.
    pub(crate) fn say(self, text: impl AsRef<str>) {
        if !self.output.quiet {
            // Nothing is lost when standard error is closed.
            let _ = writeln!(io::stderr(), "{}", text.as_ref());
        }
    }
}
