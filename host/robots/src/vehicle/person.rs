//! The person next to the robots, at the program's terminal.

use std::io::{self, BufRead, IsTerminal};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Hears what is typed.
pub struct Person {
    /// All lines of standard input so far; none if that is no terminal.
    lines: Option<&'static Mutex<Vec<String>>>,
    /// How many of them have been heard.
    heard: usize,
    /// With several robots, this one's number, to be typed before Enter.
    number: Option<usize>,
}

impl Person {
    /// The person at standard input, if that is a terminal. With a number, only lines that begin with it are heard.
    pub fn at_terminal(number: Option<usize>) -> Self {
        static LINES: Mutex<Vec<String>> = Mutex::new(Vec::new());
        static IS_THERE: LazyLock<bool> = LazyLock::new(|| {
            let is_there = io::stdin().is_terminal();
            if is_there {
                // It ends with the program: nothing else ends the reading of a line.
                thread::spawn(|| {
                    for line in io::stdin().lock().lines().map_while(Result::ok) {
                        lock(&LINES).push(line);
                    }
                });
            }
            is_there
        });
        let lines = IS_THERE.then_some(&LINES);
        Self {
            heard: lines.map_or(0, |lines| lock(lines).len()),
            lines,
            number,
        }
    }

    /// Whether somebody is there.
    pub fn is_there(&self) -> bool {
        self.lines.is_some()
    }

    /// The next action once it is done, in words.
    pub fn confirms(&self) -> String {
        match self.number {
            Some(number) => format!("type {number} and press Enter"),
            None => "press Enter".into(),
        }
    }

    /// The last line since this was asked last.
    pub fn answer(&mut self) -> Option<String> {
        let lines = lock(self.lines?);
        let new = &lines[self.heard..];
        self.heard = lines.len();
        let number = self.number.map(|number| number.to_string());
        let is_own = |line: &&String| number.as_ref().is_none_or(|number| line.trim() == number);
        new.iter().rfind(is_own).cloned()
    }

    /// Whether Enter has been pressed since this was asked last.
    pub(crate) fn has_answered(&mut self) -> bool {
        self.answer().is_some()
    }
}

fn lock(lines: &Mutex<Vec<String>>) -> MutexGuard<'_, Vec<String>> {
    lines.lock().unwrap_or_else(PoisonError::into_inner)
}
