//! Results of the study of 2014: plain numbers from which claims are judged and reports are drawn.

use oneiro::parameter::Choice;
use serde::{Deserialize, Serialize};

pub(super) use oneiro_lab::swarm::record::{Case, Credit, Kind, RobotInterval, Run};

/// All results of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Results {
    /// Robots of a swarm.
    pub robots: u32,
    /// Duration of a run, and the time when the light moves, in minutes.
    pub minutes: u32,
    pub light_moves_minute: u32,
    /// Runs of each case and kind.
    pub runs: u32,
    /// Whether ten simulated episodes of a minute took less than 34 s on one core (claim D11).
    pub(crate) generation_within_34_s: bool,
    /// Results by mutation scale and rule of credit.
    pub combinations: Vec<Combination>,
    /// The open questions; empty if they were not requested.
    pub questions: Vec<Question>,
}

/// Runs of other swarms, with the light over the nest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Question {
    /// Subject: `density`, `arena`, `range` or `lamp`.
    pub about: String,
    /// Robots of a swarm.
    pub robots: u32,
    /// Radius of the arena, mm.
    pub arena_radius: f64,
    /// Range of messages, mm.
    pub range: f64,
    /// Distance of the lamp behind the wall, mm.
    pub lamp: f64,
    pub runs: Vec<Run>,
}

/// Runs at one mutation scale with one rule of credit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Combination {
    /// Standard deviation of mutations, for genes from 0 to 0.99.
    pub scale: f64,
    /// Rule that credits fitness to a simulator.
    pub credit: Credit,
    pub runs: Vec<Run>,
}

impl Combination {
    /// Name for readers, such as `0.2, matched`.
    pub(crate) fn title(&self) -> String {
        format!("{}, {}", self.scale, self.credit.word())
    }

    /// The runs of a case and kind.
    pub(crate) fn of(&self, case: Case, kind: Kind) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |run| run.case == case && run.kind == kind)
    }
}
