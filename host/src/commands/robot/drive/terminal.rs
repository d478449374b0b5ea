//! The terminal while keys drive: keys come at once and are not shown.

use std::io;

use oneiro_base::exit::{Failure, Result};

/// A terminal that passes keys on at once. It is as before when this is dropped.
#[cfg(unix)]
pub(super) struct Terminal {
    before: rustix::termios::Termios,
    keys: rustix::termios::Termios,
}

#[cfg(unix)]
impl Terminal {
    /// Sets the terminal of standard input. Ctrl-C and Ctrl-Z keep their meaning.
    ///
    /// # Errors
    /// There is no terminal.
    pub(super) fn enter() -> Result<Self> {
        use rustix::termios::{LocalModes, tcgetattr};

        let before = tcgetattr(io::stdin()).map_err(|error| unusable(&error.into()))?;
        let mut keys = before.clone();
        keys.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
        let terminal = Self { before, keys };
        terminal.again().map(|()| terminal)
    }

    /// Sets it again, after a shell may have changed it.
    ///
    /// # Errors
    /// It can't be set.
    pub(super) fn again(&self) -> Result {
        use rustix::termios::{OptionalActions, tcsetattr};

        tcsetattr(io::stdin(), OptionalActions::Now, &self.keys).map_err(|error| unusable(&error.into()))
    }
}

#[cfg(unix)]
impl Drop for Terminal {
    /// Discards keys that nobody has read, so that a shell does not get them.
    fn drop(&mut self) {
        use rustix::termios::{OptionalActions, tcsetattr};

        // A terminal that is gone needs nothing.
        let _ = tcsetattr(io::stdin(), OptionalActions::Flush, &self.before);
    }
}

#[cfg(not(unix))]
pub(super) struct Terminal;

#[cfg(not(unix))]
impl Terminal {
    pub(super) fn enter() -> Result<Self> {
        Err(unusable(&io::ErrorKind::Unsupported.into()))
    }

    pub(super) fn again(&self) -> Result {
        Ok(())
    }
}

fn unusable(error: &io::Error) -> Failure {
    Failure::input(format_args!(
        "standard input gives no keys: {error}; allowed: a terminal, or commands of a file by --commands"
    ))
}
