//! Arguments of `oneiro reproduce miglino1995`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use oneiro_lab::device::Backend;
use oneiro_lab::numbers::{of_key, seed, whole};

use crate::file::{ArmParser, MIGLINO1995};

/// `oneiro reproduce miglino1995`
#[derive(Args, Debug)]
pub struct Arguments {
    /// Runs of each condition, 2 to 1000, or 1 with a connected robot [default: 5, as in the paper]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub runs: Option<u32>,
    /// Seed of everything random but the robot
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed())]
    pub seed: u64,
    /// The robot to transfer to: surrogate:SEED, which is sampled first, or a connected robot, such as `serial:/dev/ttyUSB0`, which has
    /// been sampled (--tables) and runs one episode after the other; the same command continues
    #[arg(long, value_name = "ROBOT", default_value = "surrogate:1")]
    pub robot: String,
    /// How much a surrogate differs from its simulator, 0 to 2 [default: 1.75]
    #[arg(long, value_name = "LAMBDA", value_parser = of_key::<f32>("reality.severity"))]
    pub severity: Option<f32>,
    /// Make the simulator from recordings of a robot instead of samples: wall, round and, if wanted, motors. A connected robot needs those
    /// that `oneiro robot sample` has made of it
    #[arg(long, value_name = "FILE,..", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    pub tables: Vec<PathBuf>,
    /// Add the controls of the real generations, and simulators of other noise and other tables (claim C11)
    #[arg(long)]
    pub full: bool,
    /// Change one of the preregistered assumptions
    #[arg(long, value_name = "ARM", value_parser = ArmParser(&MIGLINO1995), default_value = "main")]
    pub arm: String,
    /// Repeat the study under each other assumption, and tabulate the claims by assumption
    #[arg(long, conflicts_with = "arm")]
    pub(crate) sensitivity: bool,
    /// Instead of the study, measure the gap without noise by severity, on five other robots
    #[arg(long, conflicts_with_all = ["runs", "robot", "severity", "tables", "out", "arm", "full", "sensitivity"])]
    pub calibrate: bool,
    /// Judge the second edition of the study instead: the directories of finished sweeps of experiments/miglino1995/second
    #[arg(long, value_name = "DIR,..", value_delimiter = ',', value_hint = ValueHint::DirPath,
        conflicts_with_all = ["runs", "robot", "severity", "tables", "arm", "full", "sensitivity", "calibrate", "study"])]
    pub sweeps: Vec<PathBuf>,
    /// Device that evaluates.
    #[command(flatten)]
    pub backend: Backend,
    /// A file to use instead of the shipped experiments/miglino1995/study.toml: what the study runs, and its arms
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub study: Option<PathBuf>,
    /// The study's directory. A study that was stopped continues there [default: runs/miglino1995-SEED-HASH]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
}
