//! Who places the robot: a person at a terminal, or nobody.

use std::thread;
use std::time::Duration;

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::reality::{Object, Trouble};
use oneiro_robots::vehicle::{Vehicle, person};

/// Where the robot has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place<'a> {
    /// Before an object.
    Before {
        /// The object.
        object: &'a Object,
        /// See [`Sampled::turn_before`](oneiro_lab::reality::Sampled::turn_before).
        view: f64,
        /// From the robot's rim to the object, mm.
        gap: f32,
    },
    /// On free ground, as far as this on all sides, mm.
    Open(f64),
}

/// What the person answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// Continue.
    Go,
    /// Repeat the same row.
    Again,
    /// Repeat the previous row.
    Back,
    /// Stop here.
    Quit,
}

/// Who places the robot and looks at its rows.
pub(super) trait Person {
    /// Places the robot where `words` ask for it.
    ///
    /// # Errors
    /// Nobody is there to ask, or the robot fails.
    fn place(&mut self, vehicle: &mut dyn Vehicle, place: &Place<'_>, words: &str) -> Result<Answer>;

    /// Decides whether a doubtful row is kept: `words` are the doubts.
    ///
    /// # Errors
    /// Nobody is there to ask, and the row is useless; or the robot fails.
    fn decide(&mut self, vehicle: &mut dyn Vehicle, words: &str, is_useless: bool) -> Result<Answer>;

    /// Called for each row that is kept.
    fn row_kept(&mut self) {}

    /// Called for each trouble that may pass, after which the row is sampled again from the beginning.
    ///
    /// # Errors
    /// The trouble, after too many of them.
    fn troubled(&mut self, trouble: Trouble) -> Result;
}

/// A person at the terminal of standard input.
pub(super) struct AtTerminal {
    terminal: person::Person,
    console: Console,
}

impl AtTerminal {
    /// Listens to standard input.
    ///
    /// # Errors
    /// Exit 3: it is no terminal.
    pub(super) fn new(console: Console) -> Result<Self> {
        let terminal = person::Person::at_terminal(None);
        if !terminal.is_there() {
            return Err(Failure::input(
                "standard input is no terminal, and somebody has to place the robot for each row; allowed: a terminal, or \
                 --yes if a machine places the robot or the object",
            ));
        }
        Ok(Self { terminal, console })
    }

    /// Asks until one of the answers is given, which begin with these letters; Enter alone means to continue. The wheels stand
    /// meanwhile.
    fn ask(&mut self, vehicle: &mut dyn Vehicle, words: &str, answers: &[(char, Answer)]) -> Result<Answer> {
        const GLANCE: Duration = Duration::from_millis(50);
        // What was typed before is no answer to this.
        self.terminal.answer();
        let mut is_troubled = false;
        self.console.ask(words);
        loop {
            // Placing a robot may lift it, and pull at its cable.
            match vehicle.keep_until(vehicle.now() + GLANCE) {
                Ok(()) => {}
                Err(trouble) if trouble.may_pass() => {
                    is_troubled = true;
                    thread::sleep(GLANCE);
                }
                Err(trouble) => return Err(trouble.into()),
            }
            let Some(line) = self.terminal.answer() else { continue };
            let letter = line.trim().chars().next().map(|letter| letter.to_ascii_lowercase());
            let answer = match letter {
                None => Some(Answer::Go),
                Some(letter) => answers
                    .iter()
                    .find(|(known, _)| *known == letter)
                    .map(|(_, answer)| *answer),
            };
            match answer {
                Some(answer) => {
                    if is_troubled && answer != Answer::Quit {
                        vehicle.recover()?;
                    }
                    return Ok(answer);
                }
                None => self.console.ask(words),
            }
        }
    }
}

impl Person for AtTerminal {
    fn place(&mut self, vehicle: &mut dyn Vehicle, _: &Place<'_>, words: &str) -> Result<Answer> {
        let words = format!("\n{words}\nEnter: continue   S: repeat the previous row   Q: quit");
        self.ask(vehicle, &words, &[('s', Answer::Back), ('q', Answer::Quit)])
    }

    fn decide(&mut self, vehicle: &mut dyn Vehicle, words: &str, _: bool) -> Result<Answer> {
        let words = format!("{words}\nEnter: keep it   R: repeat it   Q: quit");
        self.ask(vehicle, &words, &[('r', Answer::Again), ('q', Answer::Quit)])
    }

    fn troubled(&mut self, trouble: Trouble) -> Result {
        self.console.say(format!("{trouble}; the row will be repeated"));
        Ok(())
    }
}

/// Nobody: rows follow at once, and each is tried three times.
pub(super) struct Nobody {
    console: Console,
    tries: u32,
}

impl Nobody {
    const TRIES: u32 = 3;

    pub(super) fn new(console: Console) -> Self {
        Self { console, tries: 0 }
    }
}

impl Person for Nobody {
    fn place(&mut self, _: &mut dyn Vehicle, _: &Place<'_>, words: &str) -> Result<Answer> {
        self.console.say(words);
        Ok(Answer::Go)
    }

    fn decide(&mut self, _: &mut dyn Vehicle, words: &str, is_useless: bool) -> Result<Answer> {
        self.console.say(words);
        self.tries += 1;
        if self.tries < Self::TRIES {
            return Ok(Answer::Again);
        }
        if is_useless {
            return Err(Failure::device(format_args!("{words}, three times")));
        }
        Ok(Answer::Go)
    }

    fn row_kept(&mut self) {
        self.tries = 0;
    }

    fn troubled(&mut self, trouble: Trouble) -> Result {
        self.tries += 1;
        if self.tries >= Self::TRIES {
            return Err(trouble.into());
        }
        self.console.say(format!("{trouble}; the row will be repeated"));
        Ok(())
    }
}
