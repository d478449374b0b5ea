//! Arguments of `oneiro reproduce`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueHint};
use oneiro_lab::swarm::record::Credit;
use oneiro_studies::file::{MIGLINO1995, ODOWD2014};

use super::choices::{ArmParser, choice};
use super::device::Backend;
use super::numbers::{of_key, seed, whole};

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
    /// Miglino, Lund and Nolfi, "Evolving mobile robots in simulated and real environments", 1995
    Miglino1995(Miglino1995),
    /// O'Dowd, Studley and Winfield, "The distributed co-evolution of an on-board simulator and controller for swarm
    /// robot behaviours", 2014
    Odowd2014(Odowd2014),
}

/// `oneiro reproduce miglino1995`
#[derive(Args, Debug)]
pub(crate) struct Miglino1995 {
    /// Runs of each condition, 2 to 1000, or 1 with a connected robot [default: 5, as in the paper]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) runs: Option<u32>,
    /// Seed of everything random but the robot
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed())]
    pub(crate) seed: u64,
    /// The robot to transfer to: surrogate:SEED, which is sampled first, or a connected robot, such as `serial:/dev/ttyUSB0`, which has
    /// been sampled (--tables) and runs one episode after the other; the same command continues
    #[arg(long, value_name = "ROBOT", default_value = "surrogate:1")]
    pub(crate) robot: String,
    /// How much a surrogate differs from its simulator, 0 to 2 [default: 1.75]
    #[arg(long, value_name = "LAMBDA", value_parser = of_key::<f32>("reality.severity"))]
    pub(crate) severity: Option<f32>,
    /// Make the simulator from recordings of a robot instead of samples: wall, round and, if wanted, motors. A connected robot needs those
    /// that `oneiro robot sample` has made of it
    #[arg(long, value_name = "FILE,..", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    pub(crate) tables: Vec<PathBuf>,
    /// Add the controls of the real generations, and simulators of other noise and other tables (claim C11)
    #[arg(long)]
    pub(crate) full: bool,
    /// Change one of the preregistered assumptions
    #[arg(long, value_name = "ARM", value_parser = ArmParser(&MIGLINO1995), default_value = "main")]
    pub(crate) arm: String,
    /// Repeat the study under each other assumption, and tabulate the claims by assumption
    #[arg(long, conflicts_with = "arm")]
    pub(crate) sensitivity: bool,
    /// Instead of the study, measure the gap without noise by severity, on five other robots
    #[arg(long, conflicts_with_all = ["runs", "robot", "severity", "tables", "out", "arm", "full", "sensitivity"])]
    pub(crate) calibrate: bool,
    /// Judge the second edition of the study instead: the directories of finished sweeps of studies/miglino1995/second
    #[arg(long, value_name = "DIR,..", value_delimiter = ',', value_hint = ValueHint::DirPath,
        conflicts_with_all = ["runs", "robot", "severity", "tables", "arm", "full", "sensitivity", "calibrate", "study"])]
    pub(crate) sweeps: Vec<PathBuf>,
    /// Device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// A file to use instead of the shipped experiments/miglino1995/study.toml: what the study runs, and its arms
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) study: Option<PathBuf>,
    /// The study's directory. A study that was stopped continues there [default: runs/miglino1995-SEED]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
}

/// `oneiro reproduce odowd2014`
#[derive(Args, Debug)]
pub(crate) struct Odowd2014 {
    /// Runs of each case, 2 to 400 [default: 10, as in the paper]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) runs: Option<u32>,
    /// Seed of everything random but the robots
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed())]
    pub(crate) seed: u64,
    /// Standard deviations of mutations to try [default: 2,0.2,0.02]
    #[arg(long, value_name = "S,..", value_delimiter = ',', value_parser = of_key::<f64>("swarm.controllers.mutation_scale"))]
    pub(crate) scale: Vec<f64>,
    /// Rules to try for which simulator a robot's fitness is credited to [default: lagged,matched]
    #[arg(long, value_name = "RULE,..", value_delimiter = ',', value_parser = choice::<Credit>())]
    pub(crate) credit: Vec<Credit>,
    /// Run only the paper's six cases, without the null and the interventions
    #[arg(long)]
    pub(crate) only_cases: bool,
    /// Also run the open questions: number of robots, density, range
    #[arg(long)]
    pub(crate) questions: bool,
    /// Change one of the preregistered assumptions
    #[arg(long, value_name = "ARM", value_parser = ArmParser(&ODOWD2014), default_value = "main")]
    pub(crate) arm: String,
    /// Repeat the study under each other assumption, and tabulate the claims by assumption
    #[arg(long, conflicts_with = "arm")]
    pub(crate) sensitivity: bool,
    /// Device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Judge the second edition of the study instead: the directories of finished sweeps of studies/odowd2014/second
    /// (studies/preregistration-2014-second.md). With --out, its tables are written there
    #[arg(long, value_name = "DIR,..", value_delimiter = ',', value_hint = ValueHint::DirPath, conflicts_with_all = ["runs", "seed", "scale", "credit", "only_cases", "questions", "arm", "sensitivity", "study"])]
    pub(crate) sweeps: Vec<PathBuf>,
    /// A file to use instead of the shipped experiments/odowd2014/study.toml: what the study runs, and its arms
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) study: Option<PathBuf>,
    /// The study's directory. A study that was stopped continues there [default: runs/odowd2014-SEED]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
}
