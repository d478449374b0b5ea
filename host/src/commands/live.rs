//! What changes while it is shown: a text in place on a person's terminal, otherwise lines of JSON.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use oneiro_base::console::{Console, shown};
use oneiro_base::exit::Result;
use serde_json::Value;

/// Shows the latest data. At the end they stay on the terminal.
pub(super) struct Live {
    /// None without a terminal, or with `--json`.
    screen: Option<ProgressBar>,
    console: Console,
}

impl Live {
    pub(super) fn new(console: Console) -> Self {
        let screen = || {
            let screen = ProgressBar::with_draw_target(None, ProgressDrawTarget::stdout());
            match ProgressStyle::with_template("{msg}") {
                Ok(style) => screen.with_style(style),
                Err(_) => screen,
            }
        };
        Self {
            screen: console.has_screen().then(screen),
            console,
        }
    }

    /// Whether text is shown, instead of lines of JSON.
    pub(super) fn has_screen(&self) -> bool {
        self.screen.is_some()
    }

    /// Shows data, in the one form that is made.
    pub(super) fn show(&self, text: impl FnOnce() -> String, value: impl FnOnce() -> Value) -> Result {
        match &self.screen {
            Some(screen) => {
                screen.set_message(shown(&text()).into_owned());
                Ok(())
            }
            None => self.console.print_json_line(&value()),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        if let Some(screen) = &self.screen {
            screen.abandon();
        }
    }
}
