//! The guard: stops the wheels when a program that drives hangs, dies or misses something.
//!
//! Firmware keeps the last speed for ever, and a killed process does nothing more. So another process owns the link
//! (`process.rs`), and this decides for it: a state machine without clock, input or output, whose whole table is
//! tested.
//!
//! A stop condition takes any state to a stop in one step. After it the wheels turn only by a command that came after
//! the robot had confirmed the stop and the condition had ended; most conditions also need a `resume` before that.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use values::Values;

#[cfg(all(unix, feature = "twin"))]
pub mod alone;
mod brake;
pub mod client;
pub mod message;
pub mod process;
#[cfg(test)]
mod stops;
#[cfg(test)]
mod tests;
pub mod values;
pub mod wheels;

pub use brake::Brake;

/// Why the wheels must stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// The program that drives is gone: its end of the pipe is closed.
    Closed,
    /// A signal has asked the guard to end.
    Terminated,
    /// The operator has asked for a stop.
    Operator,
    /// The tracker does not see the robot.
    Tracker,
    /// The battery is low.
    Battery,
    /// The robot has been lifted.
    Lifted,
    /// Several messages of the program in a row were invalid.
    Messages,
    /// The robot's answers are invalid, also to repeated questions.
    Answers,
    /// The robot has restarted.
    Restarted,
    /// The program has sent no command for long.
    Silent,
    /// The last command has expired.
    Expired,
    /// The robot has not answered in time.
    Late,
}

impl Condition {
    /// All conditions.
    pub const ALL: [Self; 12] = [
        Self::Closed,
        Self::Terminated,
        Self::Operator,
        Self::Tracker,
        Self::Battery,
        Self::Lifted,
        Self::Messages,
        Self::Answers,
        Self::Restarted,
        Self::Silent,
        Self::Expired,
        Self::Late,
    ];

    /// Whether nobody is left to resume.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Closed | Self::Terminated)
    }

    /// Whether a fresh command is not enough once it has ended.
    fn latches(self) -> bool {
        !matches!(self, Self::Expired | Self::Late)
    }

    /// Whether the robot may no longer do what it has confirmed.
    fn is_doubt(self) -> bool {
        matches!(self, Self::Answers | Self::Restarted | Self::Late)
    }

    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Closed => "the program that drives has ended",
            Self::Terminated => "the guard was ended by a signal",
            Self::Operator => "the operator stopped it",
            Self::Tracker => "the tracker does not see the robot",
            Self::Battery => "the battery is low",
            Self::Lifted => "the robot was lifted",
            Self::Messages => "the program's messages are invalid",
            Self::Answers => "the robot's answers are invalid",
            Self::Restarted => "the robot has restarted",
            Self::Silent => "the program has sent nothing for too long",
            Self::Expired => "no new command arrived in time",
            Self::Late => "the robot did not answer in time",
        }
    }
}

/// A set of conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conditions(u16);

impl Conditions {
    /// Adds a condition, if it holds.
    pub fn add(&mut self, condition: Condition, holds: bool) {
        self.0 |= u16::from(holds) << condition as u16;
    }

    /// Adds a condition if it holds, and removes it if not.
    pub fn set(&mut self, condition: Condition, holds: bool) {
        self.0 &= !(1 << condition as u16);
        self.add(condition, holds);
    }

    /// Whether a condition is in the set.
    pub fn has(self, condition: Condition) -> bool {
        self.0 & 1 << condition as u16 != 0
    }

    /// Whether none is.
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// The conditions in the set.
    pub fn iter(self) -> impl Iterator<Item = Condition> {
        Condition::ALL.into_iter().filter(move |condition| self.has(*condition))
    }

    /// Those for which `keep` holds.
    pub fn filter(self, keep: impl Fn(Condition) -> bool) -> Self {
        self.iter().filter(|condition| keep(*condition)).collect()
    }

    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl FromIterator<Condition> for Conditions {
    fn from_iter<I: IntoIterator<Item = Condition>>(conditions: I) -> Self {
        let mut all = Self::default();
        for condition in conditions {
            all.add(condition, true);
        }
        all
    }
}

/// What the wheels do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Told to stop; the robot has not confirmed it yet.
    Stopping,
    /// They stand, and the robot has confirmed it.
    Standing,
    /// They turn, or may.
    Moving,
}

/// What has happened since the last step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs {
    /// The time that has passed.
    pub passed: Duration,
    /// The newest command that came: speeds of the left and the right wheel, mm/s.
    pub command: Option<[f64; 2]>,
    /// Whether a resume came.
    pub resume: bool,
    /// Conditions that were sensed or came; those of time are found by the guard.
    pub conditions: Conditions,
    /// The latest stop that the robot has confirmed, by its number.
    pub confirmed: u64,
    /// How long the robot has answered nothing.
    pub quiet: Duration,
}

/// The robot's next action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Stop, and confirm it under this number.
    Stop(u64),
    /// Turn the left and the right wheel at these speeds, mm/s.
    Drive([f64; 2]),
}

/// Decides what the wheels do.
#[derive(Clone, Debug)]
pub struct Guard {
    values: Values,
    /// Maximum speed of a wheel, mm/s.
    greatest: f64,
    state: State,
    /// Number of the last stop.
    stop: u64,
    /// Since when it has waited for confirmation.
    waited: Duration,
    /// Of the newest command.
    age: Duration,
    /// The newest command's speeds, mm/s.
    target: [f64; 2],
    /// Commanded speeds of the wheels, mm/s.
    speeds: [f64; 2],
    /// Conditions that wait for a resume.
    latched: Conditions,
    /// Why the wheels stand, for messages.
    reasons: Conditions,
    /// How long the robot has answered nothing.
    quiet: Duration,
}

impl Guard {
    /// A guard of a robot whose wheels turn at up to `greatest` mm/s. It begins with a stop.
    pub fn new(values: Values, greatest: f64) -> Self {
        Self {
            greatest: values.speed_mm_s.min(greatest),
            values,
            state: State::Stopping,
            stop: 1,
            waited: Duration::ZERO,
            age: Duration::ZERO,
            target: [0.0; 2],
            speeds: [0.0; 2],
            latched: Conditions::default(),
            reasons: Conditions::default(),
            quiet: Duration::ZERO,
        }
    }

    /// What the wheels do.
    pub fn state(&self) -> State {
        self.state
    }

    /// Commanded speeds of the wheels, mm/s.
    pub fn speeds(&self) -> [f64; 2] {
        self.speeds
    }

    /// Why the wheels stand; empty if by command.
    pub fn reasons(&self) -> Conditions {
        self.reasons
    }

    /// Whether a resume is needed before they can move.
    pub fn needs_resume(&self) -> bool {
        !self.latched.is_empty()
    }

    /// Whether the link does not carry the stop.
    pub fn cannot_stop(&self) -> bool {
        let limit = self.values.unconfirmed();
        self.state == State::Stopping && (self.waited >= limit || self.quiet >= limit)
    }

    /// Whether the guard may end: the wheels stand still and nobody can drive them any more, or it has tried for long
    /// enough.
    pub fn is_over(&self) -> bool {
        let is_final = self.latched.iter().any(Condition::is_final);
        is_final && (self.state == State::Standing || self.waited >= self.values.give_up())
    }

    /// Decides what the wheels do next.
    pub fn step(&mut self, inputs: &Inputs) -> Order {
        self.age = self.age.saturating_add(inputs.passed);
        self.quiet = inputs.quiet;
        // What came while the guard itself did not run may be as old as that.
        let in_time = inputs.passed < self.values.expiry();
        let valid = |speeds: &[f64; 2]| speeds.iter().all(|speed| speed.is_finite());
        let command = inputs.command.filter(|speeds| in_time && valid(speeds));
        if command.is_some() {
            self.age = Duration::ZERO;
        }
        let mut conditions = inputs.conditions;
        conditions.add(
            Condition::Messages,
            inputs.command.is_some_and(|speeds| !valid(&speeds)),
        );
        conditions.add(Condition::Expired, self.age >= self.values.expiry());
        conditions.add(Condition::Silent, self.age >= self.values.silence());
        conditions.add(Condition::Late, self.quiet >= self.values.link());
        if inputs.resume {
            self.latched = self
                .latched
                .filter(|condition| condition.is_final() || conditions.has(condition));
            self.reasons = self.latched;
        }
        self.latched = self.latched.or(conditions.filter(Condition::latches));
        let holding = self.latched.or(conditions);
        if holding.is_empty() {
            self.go(inputs, command);
        } else {
            self.reasons = self.reasons.or(holding);
            self.hold(inputs, conditions);
        }
        match self.state {
            State::Moving => Order::Drive(self.speeds),
            State::Stopping | State::Standing => Order::Stop(self.stop),
        }
    }

    /// The step when nothing forbids to move.
    fn go(&mut self, inputs: &Inputs, command: Option<[f64; 2]>) {
        match (self.state, command) {
            (State::Stopping, _) => self.settle(inputs),
            // A command that came with the resume was given before anybody could see what it does.
            (State::Standing, Some(target)) if target != [0.0; 2] && !inputs.resume => {
                self.state = State::Moving;
                self.reasons = Conditions::default();
                self.turn(target, inputs.passed);
            }
            (State::Standing, _) => {}
            (State::Moving, Some([0.0, 0.0])) => self.halt(),
            (State::Moving, command) => self.turn(command.unwrap_or(self.target), inputs.passed),
        }
    }

    /// The step when something forbids to move.
    fn hold(&mut self, inputs: &Inputs, conditions: Conditions) {
        let in_doubt = conditions.iter().any(Condition::is_doubt);
        match self.state {
            State::Moving => self.halt(),
            State::Standing if in_doubt => self.halt(),
            State::Stopping if in_doubt => self.waited = self.waited.saturating_add(inputs.passed),
            State::Stopping => self.settle(inputs),
            State::Standing => {}
        }
    }

    /// Begins a stop.
    fn halt(&mut self) {
        self.state = State::Stopping;
        self.stop += 1;
        self.waited = Duration::ZERO;
        self.target = [0.0; 2];
        self.speeds = [0.0; 2];
    }

    /// Waits for the confirmation of a stop.
    fn settle(&mut self, inputs: &Inputs) {
        if inputs.confirmed == self.stop {
            self.state = State::Standing;
        } else {
            self.waited = self.waited.saturating_add(inputs.passed);
        }
    }

    /// Turns the wheels towards a target, within the limits of speed and acceleration.
    fn turn(&mut self, target: [f64; 2], passed: Duration) {
        let fastest = target[0].abs().max(target[1].abs());
        let share = if fastest > self.greatest {
            self.greatest / fastest
        } else {
            1.0
        };
        self.target = target.map(|speed| speed * share);
        let gain = self.values.acceleration_mm_s2 * passed.as_secs_f64();
        for (speed, target) in self.speeds.iter_mut().zip(self.target) {
            *speed = accelerated(*speed, target, gain);
        }
    }
}

/// A speed on its way to a target: it becomes slower, or turns its direction, at once, and gains at most `gain`.
fn accelerated(speed: f64, target: f64, gain: f64) -> f64 {
    let already = if speed * target > 0.0 { speed.abs() } else { 0.0 };
    target.abs().min(already + gain).copysign(target)
}
