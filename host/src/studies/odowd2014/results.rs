//! What the study of 2014 finds: plain numbers, from which claims are judged and reports are drawn.

use serde::{Deserialize, Serialize};

pub(crate) use crate::swarm::record::{Case, Credit, Kind, RobotInterval, Run};

/// All that the study found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Results {
    /// Robots of a swarm.
    pub(crate) robots: u32,
    /// Minutes of a run, and after how many the light moves.
    pub(crate) minutes: u32,
    pub(crate) light_moves_minute: u32,
    /// Runs of each case and kind.
    pub(crate) runs: u32,
    /// Whether ten simulated lives of a minute took less than 34 s of one core (claim D11).
    pub(crate) generation_within_34_s: bool,
    /// By mutation scale and rule of credit.
    pub(crate) combinations: Vec<Combination>,
    /// The open questions; none where they were not asked.
    pub(crate) questions: Vec<Question>,
}

/// Runs of other swarms, with the light over the nest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Question {
    /// What is asked: `density`, `arena`, `range` or `lamp`.
    pub(crate) about: String,
    /// Robots of a swarm.
    pub(crate) robots: u32,
    /// Radius of the arena, mm.
    pub(crate) arena_radius: f64,
    /// How far messages reach, mm.
    pub(crate) range: f64,
    /// How far behind the wall the lamp is, mm.
    pub(crate) lamp: f64,
    /// Its runs.
    pub(crate) runs: Vec<Run>,
}

/// Runs at one mutation scale with one rule of credit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Combination {
    /// Standard deviation of mutations, of genes from 0 to 0.99.
    pub(crate) scale: f64,
    /// To whom fitness is credited.
    pub(crate) credit: Credit,
    /// All runs.
    pub(crate) runs: Vec<Run>,
}

impl Combination {
    /// What readers see, such as `0.2, matched`.
    pub(crate) fn title(&self) -> String {
        format!("{}, {}", self.scale, self.credit.title())
    }

    /// The runs of a case and kind.
    pub(crate) fn of(&self, case: Case, kind: Kind) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |run| run.case == case && run.kind == kind)
    }
}
