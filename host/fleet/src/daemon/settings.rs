//! The file of the daemon of a swarm's member.
//!
//! ```toml
//! experiment = "odowd2014.toml"                 # a swarm's experiment, relative to this file
//! robot = 3                                     # its number, from 0
//! address = "serial:/dev/rfcomm0"
//! seed = 1
//! directory = "state"                           # of the checkpoint, the record and the log, relative to this file
//! key = "experiment.key"                        # shared by all robots and the operator
//!
//! [radio]
//! listen = "0.0.0.0:4711"
//! peers = ["10.0.0.11:4711", "10.0.0.1:4711"]   # the other robots and the operator, or a broadcast address
//! contact = "tracker"
//!
//! [tracker]
//! listen = "0.0.0.0:5005"
//! age_ms = 300
//!
//! [beacon]
//! limit_ms = 400
//!
//! [evolution]
//! share = 0.8
//!
//! [guard]
//! speed_mm_s = 128
//! ```

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

use oneiro_base::exit::Result;
use oneiro_base::files;
use serde::Deserialize;

pub use oneiro_lab::exchange::contact::Contact;
use oneiro_lab::exchange::radio::beacon;
pub use oneiro_lab::exchange::radio::beacon::LIMITS_MS as BEACON_LIMITS_MS;
use oneiro_lab::experiment::GREATEST_SEED;
use oneiro_lab::experiment::source::{Parsed, Source};
use oneiro_lab::experiment::swarm::SwarmExperiment;
use oneiro_lab::kinds::FileKind;
use oneiro_lab::swarm::Plan;
use oneiro_robots::address::{Invalid, Wire};
use oneiro_robots::guard::values::Values;
use oneiro_robots::tracker;

/// Allowed fractions of a processor.
pub const SHARES: RangeInclusive<f64> = 0.01..=1.0;

/// Keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    experiment: PathBuf,
    robot: u32,
    address: String,
    #[serde(default)]
    seed: u64,
    directory: PathBuf,
    key: PathBuf,
    radio: Radio,
    #[serde(default)]
    tracker: Tracker,
    #[serde(default)]
    beacon: Beacon,
    #[serde(default)]
    evolution: Evolution,
    #[serde(default)]
    guard: BTreeMap<String, f64>,
}

/// How datagrams reach the others.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Radio {
    /// Address to listen at.
    pub listen: String,
    /// The others and the operator.
    pub peers: Vec<String>,
    /// Who is near enough to be heard.
    #[serde(default)]
    pub contact: Contact,
}

/// The tracker.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tracker {
    /// Address to listen at.
    pub listen: String,
    /// Age of the last sighting from which the robot counts as lost, ms.
    age_ms: u64,
}

impl Default for Tracker {
    fn default() -> Self {
        Self {
            listen: "0.0.0.0:5005".into(),
            age_ms: tracker::AGE_MS,
        }
    }
}

impl Tracker {
    /// Age of the last sighting from which the robot counts as lost.
    pub fn age(&self) -> Duration {
        Duration::from_millis(self.age_ms)
    }
}

/// The operator's beacon, without which the wheels stand.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Beacon {
    limit_ms: u64,
}

impl Default for Beacon {
    fn default() -> Self {
        Self {
            limit_ms: beacon::LIMIT_MS,
        }
    }
}

impl Beacon {
    /// How long the beacon may be silent.
    pub fn limit(&self) -> Duration {
        Duration::from_millis(self.limit_ms)
    }
}

/// The evolution on board.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Evolution {
    /// Share of one processor's time that it may take.
    pub share: f64,
}

impl Default for Evolution {
    fn default() -> Self {
        Self { share: 0.8 }
    }
}

/// A daemon's checked values.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The swarm's run that it takes part in.
    pub plan: Plan,
    /// BLAKE3 hash of the experiment and the seed.
    pub experiment: blake3::Hash,
    /// The robot's number.
    pub robot: u32,
    /// Where the robot is.
    pub wire: Wire,
    /// Where the daemon keeps its files.
    pub directory: PathBuf,
    /// File of the experiment's key.
    pub key: PathBuf,
    pub radio: Radio,
    pub tracker: Tracker,
    pub beacon: Beacon,
    pub evolution: Evolution,
    /// Settings of the guard, each written `KEY=VALUE`.
    pub guard: Vec<String>,
}

impl Settings {
    /// Reads and checks a daemon's file and the experiment that it names.
    ///
    /// # Errors
    /// Exit 3: the file, the line and the column, the key, the value found, and the values allowed.
    #[cfg(any(test, feature = "twin"))]
    pub fn read(path: &Path) -> Result<Self> {
        let text = files::text(path)?;
        let parsed = Parsed::new(path.display().to_string(), &text)?;
        Self::of(path, &parsed)
    }

    /// Whether a file has what the daemon of a swarm's member needs, and that of another robot does not.
    pub fn is_of_member(parsed: &Parsed<'_>) -> bool {
        let keys = ["robot", "key", "radio", "tracker", "beacon"];
        keys.iter().any(|key| parsed.has(key))
    }

    /// The same of a file that was parsed.
    ///
    /// # Errors
    /// As [`Settings::read`].
    pub fn of(path: &Path, parsed: &Parsed<'_>) -> Result<Self> {
        let (file, source): (File, _) = Source::read(parsed, &[])?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let experiment = directory.join(&file.experiment);
        let text = files::text(&experiment)?;
        let parsed = FileKind::Experiment.parsed(&experiment, &text)?;
        if !parsed.has("swarm") {
            let problem = format!(
                "is {}, which has no swarm; allowed: an experiment with a table [swarm]",
                file.experiment.display()
            );
            return Err(source.invalid("experiment", problem));
        }
        let experiment = SwarmExperiment::of_robots(&experiment, &parsed)?;
        check(&file, experiment.settings().world.robots, &source)?;
        Ok(Self {
            experiment: experiment.identities().of(file.seed),
            plan: experiment.plan(file.seed),
            robot: file.robot,
            wire: wire(&file.address, "address", &source)?,
            directory: directory.join(file.directory),
            key: directory.join(file.key),
            radio: file.radio,
            tracker: file.tracker,
            beacon: file.beacon,
            evolution: file.evolution,
            guard: guard(&file.guard, &source)?,
        })
    }
}

/// Parses a robot's address, the value of `key`, which must have a link.
pub fn wire(address: &str, key: &str, source: &Source<'_>) -> Result<Wire> {
    address.parse().map_err(|invalid: Invalid| source.invalid(key, invalid))
}

/// The guard's values as settings, each written `KEY=VALUE`.
pub(super) fn guard(values: &BTreeMap<String, f64>, source: &Source<'_>) -> Result<Vec<String>> {
    let guard: Vec<String> = values.iter().map(|(key, value)| format!("{key}={value}")).collect();
    Values::of(&guard).map_err(|problem| source.invalid("guard", problem))?;
    Ok(guard)
}

/// Checks the ranges of values.
fn check(file: &File, robots: u32, source: &Source<'_>) -> Result {
    source.within("robot", file.robot, &(0..=robots - 1))?;
    source.within("seed", file.seed, &(0..=GREATEST_SEED))?;
    source.within("tracker.age_ms", file.tracker.age_ms, &tracker::AGES_MS)?;
    source.within("beacon.limit_ms", file.beacon.limit_ms, &BEACON_LIMITS_MS)?;
    source.within("evolution.share", file.evolution.share, &SHARES)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const FILE: &str = r#"
experiment = "swarm.toml"
robot = 3
address = "serial:/dev/rfcomm0"
seed = 5
directory = "state"
key = "experiment.key"
[radio]
listen = "127.0.0.1:4711"
peers = ["127.0.0.1:4712"]
[beacon]
limit_ms = 300
[guard]
speed_mm_s = 128
"#;

    /// The values of the file in a new directory, with some text replaced by another.
    fn read(name: &str, replaced: &str, by: &str) -> Result<Settings> {
        let directory = std::env::temp_dir().join(format!("oneiro-daemon-{name}-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        assert!(FILE.contains(replaced), "{replaced}");
        fs::write(directory.join("robot.toml"), FILE.replace(replaced, by)).unwrap();
        fs::write(directory.join("swarm.toml"), "[swarm]\nrobots = 10\nminutes = 3\n").unwrap();
        fs::write(directory.join("single.toml"), "trials = 1\n").unwrap();
        fs::write(
            directory.join("control.toml"),
            "[swarm]\ncontrol = \"simulator-right\"\n",
        )
        .unwrap();
        let settings = Settings::read(&directory.join("robot.toml"));
        fs::remove_dir_all(&directory).unwrap();
        settings
    }

    #[test]
    fn a_file_is_read_with_its_experiment() {
        let settings = read("whole", "", "").unwrap();
        assert_eq!(
            (settings.robot, settings.plan.seed, settings.plan.settings.minutes),
            (3, 5, 3)
        );
        assert!(settings.directory.ends_with("state") && settings.key.ends_with("experiment.key"));
        assert_eq!(settings.guard, ["speed_mm_s=128"]);
        assert_eq!(settings.beacon.limit(), Duration::from_millis(300));
        assert_eq!(settings.tracker, Tracker::default());
        assert_eq!(settings.radio.contact, Contact::Tracker);
        let other = read("seed", "seed = 5", "seed = 6").unwrap();
        assert_ne!(other.experiment, settings.experiment);
    }

    #[test]
    fn what_is_not_allowed_is_refused_at_its_place() {
        for (name, replaced, by, expected) in [
            (
                "robot",
                "robot = 3",
                "robot = 10",
                "robot.toml:3:9: robot: is 10; allowed: 0 to 9",
            ),
            (
                "limit",
                "limit_ms = 300",
                "limit_ms = 500",
                "beacon.limit_ms: is 500; allowed: 100 to 450",
            ),
            (
                "address",
                "serial:/dev/rfcomm0",
                "surrogate:1",
                "a surrogate has no link; allowed: serial:PATH",
            ),
            (
                "guard",
                "speed_mm_s = 128",
                "speed = 128",
                "guard speed: is no value of the guard; allowed: expiry_ms",
            ),
            (
                "kind",
                "swarm.toml",
                "single.toml",
                "which has no swarm; allowed: an experiment with a table [swarm]",
            ),
            (
                "control",
                "swarm.toml",
                "control.toml",
                "control.toml:2:11: swarm.control: is a control, which needs the evolution of all robots in one program; allowed: evolved",
            ),
            ("peer", "\"127.0.0.1:4712\"", "3", "robot.toml:10:"),
            (
                "key",
                "[radio]",
                "[radio]\nrange = 3",
                "radio.range: unknown key `range`; allowed: listen, peers, contact",
            ),
            (
                "share",
                "[beacon]",
                "[evolution]\nshare = 0\n[beacon]",
                "evolution.share",
            ),
        ] {
            let refusal = read(name, replaced, by).unwrap_err();
            assert_eq!(refusal.code(), 3);
            assert!(refusal.to_string().contains(expected), "{refusal}");
        }
    }
}
