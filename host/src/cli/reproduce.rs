//! Arguments of `oneiro reproduce`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueHint};
use oneiro_lab::swarm::record::Credit;
use oneiro_studies::file::{Edition, MIGLINO1995, ODOWD2014};

use super::choices::{ArmParser, choice};
use super::device::Backend;
use super::numbers::{of_key, seed, whole};

/// Instead of an arm's name, lists all of them.
pub(crate) const ALL_ARMS: &str = "list";

/// `oneiro reproduce`
#[derive(Args, Debug)]
pub(crate) struct Reproduce {
    /// Which paper.
    #[command(subcommand)]
    pub(crate) study: Paper,
}

/// The papers.
#[derive(Debug, Subcommand)]
pub(crate) enum Paper {
    /// Miglino, Lund and Nolfi 1995: mobile robots in simulated and real environments
    Miglino1995(Miglino1995),
    /// O'Dowd, Studley and Winfield 2014: a swarm co-evolves on-board simulators
    Odowd2014(Odowd2014),
}

/// `oneiro reproduce miglino1995`
#[derive(Args, Debug)]
pub(crate) struct Miglino1995 {
    /// Runs of each condition, 2 to 1000, or 1 with a connected robot [default: 5, as in the paper]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) runs: Option<u32>,
    /// Seed of everything random except the robots
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed())]
    pub(crate) seed: u64,
    /// The robot for the transfer: surrogate:SEED, or an address, such as `serial:/dev/ttyUSB0`, with --tables
    #[arg(long, value_name = "ROBOT", default_value = "surrogate:1")]
    pub(crate) robot: String,
    /// How much a surrogate differs from its simulator, 0 to 2 [default: 1, and 0.5 in motion and latency]
    #[arg(long, value_name = "LAMBDA", value_parser = of_key::<f32>("reality.severity"))]
    pub(crate) severity: Option<f32>,
    /// Make the simulator from these samples: wall, round and, optionally, motors. A connected robot needs those of `oneiro robot
    /// sample`
    #[arg(long, value_name = "FILE,..", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    pub(crate) tables: Vec<PathBuf>,
    /// Add controls for the real generations, and simulators with other noise and tables (claim C11)
    #[arg(long)]
    pub(crate) full: bool,
    /// Edition of the study, with its values and criteria
    #[arg(long, value_name = "EDITION", value_parser = choice::<Edition>(), default_value = "second")]
    pub(crate) edition: Edition,
    /// Change a preregistered assumption; `list` lists the edition's
    #[arg(long, value_name = "ARM", hide_possible_values = true, value_parser = ArmParser(&MIGLINO1995), default_value = "main")]
    pub(crate) arm: String,
    /// Repeat the study under each other assumption, and tabulate the claims
    #[arg(long, conflicts_with = "arm")]
    pub(crate) sensitivity: bool,
    /// Instead: measure the first edition's gap without noise by severity, on five other robots
    #[arg(long, conflicts_with_all = ["runs", "robot", "severity", "tables", "out", "edition", "arm", "full", "sensitivity"])]
    pub(crate) calibrate: bool,
    /// Instead: judge finished sweeps of studies/miglino1995/second or third, by their edition's rules
    #[arg(long, value_name = "DIR,..", value_delimiter = ',', value_hint = ValueHint::DirPath,
        conflicts_with_all = ["runs", "robot", "severity", "tables", "edition", "arm", "full", "sensitivity", "calibrate", "study"])]
    pub(crate) sweeps: Vec<PathBuf>,
    /// Device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Use this study file instead of experiments/miglino1995/study.toml
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) study: Option<PathBuf>,
    /// The study's directory; an interrupted study continues there [default: runs/miglino1995-SEED]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
}

/// `oneiro reproduce odowd2014`
#[derive(Args, Debug)]
pub(crate) struct Odowd2014 {
    /// Runs of each case, 2 to 400 [default: 10, as in the paper]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) runs: Option<u32>,
    /// Seed of everything random except the robots
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed())]
    pub(crate) seed: u64,
    /// Standard deviations of mutations to try [default: 2,0.2,0.02]
    #[arg(long, value_name = "S,..", value_delimiter = ',', value_parser = of_key::<f64>("swarm.controllers.mutation_scale"))]
    pub(crate) scale: Vec<f64>,
    /// Rules that credit a robot's fitness to a simulator [default: lagged,matched]
    #[arg(long, value_name = "RULE,..", value_delimiter = ',', value_parser = choice::<Credit>())]
    pub(crate) credit: Vec<Credit>,
    /// Run the paper's six cases only, without the null and the interventions
    #[arg(long)]
    pub(crate) only_cases: bool,
    /// Also run the open questions: number of robots, density, range
    #[arg(long)]
    pub(crate) questions: bool,
    /// Change a preregistered assumption; `list` lists them
    #[arg(long, value_name = "ARM", hide_possible_values = true, value_parser = ArmParser(&ODOWD2014), default_value = "main")]
    pub(crate) arm: String,
    /// Repeat the study under each other assumption, and tabulate the claims
    #[arg(long, conflicts_with = "arm")]
    pub(crate) sensitivity: bool,
    /// Device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Instead: judge the study's second edition from finished sweeps of studies/odowd2014/second; --out gets its tables
    #[arg(long, value_name = "DIR,..", value_delimiter = ',', value_hint = ValueHint::DirPath, conflicts_with_all = ["runs", "seed", "scale", "credit", "only_cases", "questions", "arm", "sensitivity", "study"])]
    pub(crate) sweeps: Vec<PathBuf>,
    /// Use this study file instead of experiments/odowd2014/study.toml
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) study: Option<PathBuf>,
    /// The study's directory; an interrupted study continues there [default: runs/odowd2014-SEED]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
}
