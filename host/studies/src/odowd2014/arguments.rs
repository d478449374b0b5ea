//! Arguments of `oneiro reproduce odowd2014`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use oneiro_lab::device::Backend;
use oneiro_lab::numbers::{of_key, seed, whole};
use oneiro_lab::swarm::record::Credit;

use crate::file::{ArmParser, ODOWD2014};

/// `oneiro reproduce odowd2014`
#[derive(Args, Debug)]
pub struct Arguments {
    /// Runs of each case, 2 to 400 [default: 10, as in the paper]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub runs: Option<u32>,
    /// Seed of everything random but the robots
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed())]
    pub seed: u64,
    /// Standard deviations of mutations to try [default: 2,0.2,0.02]
    #[arg(long, value_name = "S,..", value_delimiter = ',', value_parser = of_key::<f64>("swarm.controllers.mutation_scale"))]
    pub scale: Vec<f64>,
    /// Rules to try for which simulator a robot's fitness is credited to [default: lagged,matched]
    #[arg(long, value_name = "RULE,..", value_delimiter = ',', value_enum)]
    pub credit: Vec<Credit>,
    /// Run only the paper's six cases, without the null and the interventions
    #[arg(long)]
    pub(crate) only_cases: bool,
    /// Also run the open questions: number of robots, density, range
    #[arg(long)]
    pub questions: bool,
    /// Change one of the preregistered assumptions
    #[arg(long, value_name = "ARM", value_parser = ArmParser(&ODOWD2014), default_value = "main")]
    pub arm: String,
    /// Repeat the study under each other assumption, and tabulate the claims by assumption
    #[arg(long, conflicts_with = "arm")]
    pub(crate) sensitivity: bool,
    /// Device that evaluates.
    #[command(flatten)]
    pub backend: Backend,
    /// Judge the second edition of the study instead: the directories of finished sweeps of experiments/odowd2014/second
    /// (docs/preregistration-2014-second.md). With --out, its tables are written there
    #[arg(long, value_name = "DIR,..", value_delimiter = ',', value_hint = ValueHint::DirPath, conflicts_with_all = ["runs", "seed", "scale", "credit", "only_cases", "questions", "arm", "sensitivity", "study"])]
    pub sweeps: Vec<PathBuf>,
    /// A file to use instead of the shipped experiments/odowd2014/study.toml: what the study runs, and its arms
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub study: Option<PathBuf>,
    /// The study's directory. A study that was stopped continues there [default: runs/odowd2014-SEED-HASH]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
}
