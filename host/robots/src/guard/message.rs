//! Messages between a program that drives and the guard: lines of JSON. The program writes [`Request`]s to the guard's
//! standard input, and reads [`Report`]s from its standard output.

use serde::{Deserialize, Serialize};

use super::{Condition, State};
use crate::Description;

/// Version of the messages. Both sides say theirs first, and it must be the same.
pub const VERSION: u32 = 1;

/// The longest line, in bytes.
pub const LONGEST: u64 = 4096;

/// A program's request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// The first message.
    Hello {
        /// The program's [`VERSION`].
        version: u32,
    },
    /// New speeds. They count until they expire.
    Command {
        /// Greater than that of the command before.
        sequence: u64,
        /// Speed of the left wheel, mm/s.
        left_mm_s: f64,
        /// Speed of the right wheel, mm/s.
        right_mm_s: f64,
    },
    /// Whether a tracker sees the robot. Until this comes for the first time, no tracker is expected to.
    Tracker {
        /// Whether it has lost it.
        lost: bool,
    },
    /// The operator stops the robot.
    Stop,
    /// The operator allows it to move again.
    Resume,
    /// The guard is to stop the robot and end.
    End,
}

/// A report of the guard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// The first message.
    Hello {
        /// The guard's [`VERSION`].
        version: u32,
    },
    /// The robot is connected.
    Connected {
        /// Its kind.
        robot: String,
        /// Its firmware.
        firmware: String,
        /// Maximum allowed speed of a wheel, mm/s.
        greatest_mm_s: f64,
        /// One of the robot's own units of speed, mm/s.
        unit_mm_s: f64,
        /// Distance between the wheels, mm.
        base_mm: f64,
        /// Whether it measures how far its wheels have turned.
        has_odometers: bool,
        /// The sensors that are read.
        sensors: Vec<Sensors>,
    },
    /// Readings of one kind of sensors.
    Reading {
        /// The kind.
        kind: String,
        /// When they arrived, s since the guard began.
        time_s: f64,
        /// Maximum age of a value then, ms.
        age_ms: f64,
        /// The readings.
        values: Vec<f64>,
    },
    /// How far the wheels have turned since the first reading of the odometers, whether or not their counters have wrapped or
    /// restarted since. Only if it is wanted.
    Travel {
        /// Of the left wheel, mm.
        left_mm: f64,
        /// Of the right wheel, mm.
        right_mm: f64,
        /// When it arrived, s since the guard began.
        time_s: f64,
        /// Its maximum age then, ms.
        age_ms: f64,
    },
    /// The state of the battery, if the robot reports it.
    Battery {
        /// Its voltage, if the robot reports it.
        volts: Option<f64>,
        /// Whether it should be charged now.
        low: bool,
    },
    /// What the wheels do: at each change, and ten times a second.
    State(Status),
    /// Why the guard ends, if it was not asked to.
    Failed {
        /// The exit code.
        code: u8,
        /// The problem.
        message: String,
    },
}

/// Sensors of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensors {
    /// The kind.
    pub kind: String,
    /// Their names, in the order of readings.
    pub names: Vec<String>,
    /// Unit of a reading; empty for the converter's own.
    pub unit: String,
    /// Usual minimum and maximum reading.
    pub range: (f64, f64),
}

/// What the wheels do, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// What they do.
    pub state: State,
    /// Commanded speed of the left wheel, mm/s.
    pub left_mm_s: f64,
    /// Commanded speed of the right wheel, mm/s.
    pub right_mm_s: f64,
    /// Sequence number of the newest command.
    pub sequence: u64,
    /// Why they stand; empty if by command.
    pub reasons: Vec<Condition>,
    /// Whether a resume is needed before they can move.
    pub needs_resume: bool,
    /// Whether the robot does not confirm a stop: the wheels may be turning.
    pub cannot_stop: bool,
    /// The link's last problem since the robot has answered.
    pub problem: Option<String>,
}

/// Sensors of a description.
pub fn sensors(description: &Description, kinds: &[crate::Kind]) -> Vec<Sensors> {
    let groups = description.sensors.iter().filter(|group| kinds.contains(&group.kind));
    groups
        .map(|group| Sensors {
            kind: group.kind.to_string(),
            names: group.names.iter().map(|name| (*name).to_owned()).collect(),
            unit: group.unit.to_owned(),
            range: group.range,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_lines_of_json_and_nothing_else() {
        for (request, line) in [
            (Request::Hello { version: 1 }, r#"{"hello":{"version":1}}"#),
            (
                Request::Command {
                    sequence: 7,
                    left_mm_s: 50.0,
                    right_mm_s: -0.5,
                },
                r#"{"command":{"sequence":7,"left_mm_s":50.0,"right_mm_s":-0.5}}"#,
            ),
            (Request::Tracker { lost: true }, r#"{"tracker":{"lost":true}}"#),
            (Request::Stop, r#""stop""#),
            (Request::Resume, r#""resume""#),
            (Request::End, r#""end""#),
        ] {
            assert_eq!(serde_json::to_string(&request).unwrap(), line);
            assert_eq!(serde_json::from_str::<Request>(line).unwrap(), request);
        }
        for line in [
            "",
            "{}",
            "\"go\"",
            r#"{"command":{"sequence":7,"left_mm_s":50.0}}"#,
            r#"{"command":{"sequence":-7,"left_mm_s":50.0,"right_mm_s":0}}"#,
            r#"{"command":{"sequence":7,"left_mm_s":null,"right_mm_s":0}}"#,
            r#"{"command":{"sequence":7,"left_mm_s":NaN,"right_mm_s":0}}"#,
            r#"{"command":{"sequence":7,"left_mm_s":1e999,"right_mm_s":0}}"#,
            r#"{"command":{"sequence":7,"left_mm_s":1,"right_mm_s":0,"for_ever":true}}"#,
            r#""stop" "resume""#,
        ] {
            assert!(serde_json::from_str::<Request>(line).is_err(), "{line}");
        }
    }
}
