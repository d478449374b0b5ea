//! The person beside a robot, at the program's terminal.

use std::io::{self, BufRead, IsTerminal};
use std::sync::mpsc::{self, Receiver};
use std::thread;

/// Hears when Enter is pressed.
pub(super) struct Person {
    /// A word for each line; none if standard input is no terminal.
    lines: Option<Receiver<()>>,
}

impl Person {
    /// The person at standard input, if that is a terminal.
    pub(super) fn at_terminal() -> Self {
        let lines = io::stdin().is_terminal().then(|| {
            let (sender, lines) = mpsc::channel();
            thread::spawn(move || {
                let heard = io::stdin().lock().lines().map_while(Result::ok);
                for _ in heard {
                    if sender.send(()).is_err() {
                        return;
                    }
                }
            });
            lines
        });
        Self { lines }
    }

    /// Whether somebody is there.
    pub(super) fn is_there(&self) -> bool {
        self.lines.is_some()
    }

    /// Whether Enter has been pressed since this was asked last.
    pub(super) fn has_answered(&self) -> bool {
        self.lines.as_ref().is_some_and(|lines| lines.try_iter().count() > 0)
    }
}
