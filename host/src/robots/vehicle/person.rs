//! The person beside a robot, at the program's terminal.

use std::io::{self, BufRead, IsTerminal};
use std::sync::mpsc::{self, Receiver};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::thread;

/// Hears what is typed.
pub(crate) struct Person {
    /// Lines of standard input; none if that is no terminal.
    lines: Option<&'static Mutex<Receiver<String>>>,
}

impl Person {
    /// The person at standard input, if that is a terminal. All share its lines.
    pub(crate) fn at_terminal() -> Self {
        static LINES: LazyLock<Option<Mutex<Receiver<String>>>> = LazyLock::new(|| {
            io::stdin().is_terminal().then(|| {
                let (sender, lines) = mpsc::channel();
                // It ends with the program: nothing else ends the reading of a line.
                thread::spawn(move || {
                    let mut heard = io::stdin().lock().lines().map_while(Result::ok);
                    heard.all(|line| sender.send(line).is_ok())
                });
                Mutex::new(lines)
            })
        });
        Self { lines: LINES.as_ref() }
    }

    /// Whether somebody is there.
    pub(crate) fn is_there(&self) -> bool {
        self.lines.is_some()
    }

    /// The last line since this was asked last.
    pub(crate) fn answer(&self) -> Option<String> {
        let lines = self.lines?.lock().unwrap_or_else(PoisonError::into_inner);
        lines.try_iter().last()
    }

    /// Whether Enter has been pressed since this was asked last.
    pub(crate) fn has_answered(&self) -> bool {
        self.answer().is_some()
    }
}
