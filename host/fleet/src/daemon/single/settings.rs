//! The file of the daemon of a robot that has no swarm.
//!
//! ```toml
//! experiment = "khepera-avoidance.toml"   # of a single robot, relative to this file
//! address = "serial:/dev/ttyUSB0"
//! seed = 1
//! directory = "state"                     # of all that is kept, relative to this file
//!
//! [transfers]
//! generations = 10
//! again_every = 4
//! least_lives = 3
//! final_lives = 1
//!
//! [lives]
//! walk_s = 10.0
//!
//! [evolution]
//! share = 0.8
//!
//! [guard]
//! speed_mm_s = 100
//! ```

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use oneiro::reported::Reported;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::files;
use oneiro_lab::experiment::kinds::FileKind;
use oneiro_lab::experiment::settings::{Addresses, Transfer};
use oneiro_lab::experiment::source::{Parsed, Source};
use oneiro_lab::experiment::{Experiment, Files, GREATEST_SEED};
use oneiro_lab::reality::site::LIVES;
use oneiro_lab::reality::wired::{self, Time};
use oneiro_robots::address::Wire;
use oneiro_robots::guard::wheels::Wanted;
use oneiro_robots::tracker;
use oneiro_robots::vehicle::guarded::Options;
use serde::Deserialize;

use super::transfers::Rules;
use crate::daemon::settings::{Evolution, SHARES, guard, wire};

/// Allowed numbers of generations, and of episodes.
const GENERATIONS: RangeInclusive<u32> = 1..=1_000_000;
const COUNTS: RangeInclusive<u32> = 0..=100_000;

/// Keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    experiment: PathBuf,
    address: String,
    #[serde(default)]
    seed: u64,
    directory: PathBuf,
    #[serde(default)]
    transfers: Rules,
    #[serde(default)]
    lives: Lives,
    #[serde(default)]
    evolution: Evolution,
    #[serde(default)]
    guard: BTreeMap<String, f64>,
}

/// How episodes run on the robot, as in `[reality]` of an experiment.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Lives {
    walk_s: Option<f32>,
    speed_mm_s: Option<f32>,
    sensors: BTreeMap<String, String>,
    tracker: Option<String>,
    tracker_age_ms: Option<u64>,
}

/// A daemon's checked values.
#[derive(Debug)]
pub struct Settings {
    pub experiment: Experiment,
    pub seed: u64,
    /// BLAKE3 hash of the experiment and the seed.
    pub identity: blake3::Hash,
    /// Where the robot is, and the place of that in the file, for messages.
    pub wire: Wire,
    pub place: String,
    /// Where the daemon keeps its files.
    pub directory: PathBuf,
    pub rules: Rules,
    pub lives: wired::Values,
    pub evolution: Evolution,
    /// Settings of the guard, each written `KEY=VALUE`.
    pub guard: Vec<String>,
}

impl Settings {
    /// Reads and checks a daemon's file and the experiment that it names.
    ///
    /// # Errors
    /// Exit 3: the file, the line and the column, the key, the value found, and the values allowed.
    pub fn of(path: &Path, parsed: &Parsed<'_>) -> Result<Self> {
        let (file, source): (File, _) = Source::read(parsed, &[])?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let experiment = experiment(&folder.join(&file.experiment), &file, &source)?;
        check(&file, &source)?;
        let directory = folder.join(&file.directory);
        Ok(Self {
            seed: file.seed,
            identity: experiment.identities().of(file.seed),
            experiment,
            wire: wire(&file.address, "address", &source)?,
            place: source.place_of("address"),
            lives: wired::Values {
                directory: directory.join(LIVES),
                ..lives(file.lives, &source)?
            },
            directory,
            rules: file.transfers,
            evolution: file.evolution,
            guard: guard(&file.guard, &source)?,
        })
    }
}

impl Settings {
    /// How to connect to the robot.
    ///
    /// # Errors
    /// Exit 3: a kind of sensor that no connected robot has.
    pub fn options(&self) -> Result<Options> {
        let kinds = wired::kinds(self.experiment.world().spec()).map_err(Failure::input)?;
        Ok(Options {
            wire: self.wire.clone(),
            wanted: Wanted { kinds, odometry: true },
            settings: wired::guarded(&self.guard),
            record: None,
            tracker: self.lives.trackers.first().cloned(),
            number: None,
        })
    }

    /// A failure of the robot, at the place of its address if it is not the experiment's robot.
    pub fn at(&self, failure: Failure) -> Failure {
        if failure.code() == Code::Input as u8 {
            return failure.at(&format!("{}: address", self.place));
        }
        failure
    }

    /// The robot's minimum time, in words.
    pub fn time(&self) -> String {
        let generations = self.experiment.settings().evolution.generations;
        let least = generations.div_ceil(self.rules.generations) + self.rules.final_lives;
        let cycles = self.experiment.world().cycles() + self.lives.walk;
        let time = Time::new(least.into(), 1, cycles, 1);
        format!("at least {least} episodes on the robot: {time}, less those already recorded")
    }
}

/// Reads an experiment whose episodes can run on a robot, as far as that can be checked without one.
fn experiment(path: &Path, file: &File, source: &Source<'_>) -> Result<Experiment> {
    let invalid = |problem: &str| {
        let name = file.experiment.display();
        source.invalid("experiment", format_args!("is {name}, {problem}"))
    };
    let text = files::text(path)?;
    let parsed = FileKind::Experiment.parsed(path, &text)?;
    if parsed.has("swarm") {
        let allowed =
            "allowed: an experiment of a single robot, or a member's file with robot, key and [radio] (docs/fleet.md)";
        return Err(invalid(&format!("which has a swarm; {allowed}")));
    }
    let experiment = Experiment::of(path, &parsed, &[], &Files::default())?;
    let spec = experiment.world().spec();
    match experiment.world().robots() {
        1 => {}
        robots => {
            return Err(invalid(&format!(
                "whose {robots} robots share a world; allowed: an experiment of a single robot"
            )));
        }
    }
    if experiment.first_real().is_some() {
        return Err(invalid(&format!(
            "whose last generations run on reality.robot; allowed: one without it, since the robot on board is that of `address`, {}",
            file.address
        )));
    }
    let kinds = wired::kinds(spec).map(drop);
    let reported = Reported::new(spec).map(drop).map_err(|error| error.to_string());
    kinds
        .and(reported)
        .map_err(|problem| invalid(&format!("which can't run on a robot: {problem}")))?;
    Ok(experiment)
}

/// Checks the ranges of values.
fn check(file: &File, source: &Source<'_>) -> Result {
    let Rules {
        generations,
        again_every,
        least_lives,
        final_lives,
    } = file.transfers;
    source.within("seed", file.seed, &(0..=GREATEST_SEED))?;
    source.within("transfers.generations", generations, &GENERATIONS)?;
    if again_every == 1 || !COUNTS.contains(&again_every) {
        let greatest = COUNTS.end();
        let problem = format!("is {again_every}; allowed: 0 for never, or 2 to {greatest}");
        return Err(source.invalid("transfers.again_every", problem));
    }
    source.within("transfers.least_lives", least_lives, &(1..=*COUNTS.end()))?;
    source.within("transfers.final_lives", final_lives, &COUNTS)?;
    if let Some(walk) = file.lives.walk_s {
        source.within("lives.walk_s", walk, &(0.0..=wired::LONGEST_WALK_S as f32))?;
    }
    if let Some(speed) = file.lives.speed_mm_s {
        let [least, greatest] = wired::SPEEDS_MM_S.map(|speed| speed as f32);
        source.within("lives.speed_mm_s", speed, &(least..=greatest))?;
    }
    if let Some(age) = file.lives.tracker_age_ms {
        source.within("lives.tracker_age_ms", age, &tracker::AGES_MS)?;
    }
    source.within("evolution.share", file.evolution.share, &SHARES)
}

/// The same values as an experiment's. Nobody can put the robot anywhere, so it drives to its starts.
fn lives(values: Lives, source: &Source<'_>) -> Result<wired::Values> {
    let values = Transfer {
        walk: values.walk_s,
        speed: values.speed_mm_s,
        sensors: values.sensors,
        tracker: Addresses(values.tracker.into_iter().collect()),
        tracker_age: values.tracker_age_ms.map(|age| age as f32),
        ..Transfer::default()
    };
    values
        .values()
        .map_err(|problem| source.invalid("lives.tracker", problem))
}
