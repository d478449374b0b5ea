//! `fleet.toml`: the robots of a fleet, their computers, and what they do.
//!
//! ```toml
//! experiment = "odowd2014-over.toml"      # relative to this file, as all paths of this machine
//! seed = 1
//! key = "experiment.key"
//! operator = "10.0.0.1:4711"              # where robots reach this machine
//! binary = "oneiro-aarch64"
//!
//! [tracker]                               # these tables are those of robot.toml, for all robots
//! listen = "0.0.0.0:5005"
//!
//! [[robots]]
//! number = 0
//! host = "pi@10.0.0.10"
//! address = "serial:/dev/rfcomm0"
//! ```

use std::collections::BTreeSet;
use std::net::{IpAddr, SocketAddr};
use std::ops::Deref;
use std::path::{Path, PathBuf};

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_lab::experiment::GREATEST_SEED;
use oneiro_lab::experiment::kinds::FileKind;
use oneiro_lab::experiment::source::{Parsed, Source};
use oneiro_lab::experiment::swarm::SwarmExperiment;
use oneiro_robots::guard;
use oneiro_robots::tracker;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::alone;
use crate::daemon::settings::{BEACON_LIMITS_MS, Contact, SHARES, wire};

/// Names of a robot's files in its directory on its computer.
pub(crate) const BINARY: &str = "oneiro";
pub const EXPERIMENT: &str = "experiment.toml";
pub const ROBOT: &str = "robot.toml";
pub const KEY: &str = "experiment.key";
/// The daemon's own directory below it.
pub const STATE: &str = "state";

/// Port of the radio unless a file says otherwise.
const PORT: u16 = 4711;

/// Keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    experiment: String,
    seed: u64,
    #[serde(default = "directory")]
    directory: String,
    key: String,
    operator: String,
    binary: String,
    #[serde(default = "remote")]
    remote: String,
    #[serde(default)]
    service: Service,
    #[serde(default)]
    ssh: Ssh,
    #[serde(default)]
    radio: Radio,
    tracker: Option<Tracker>,
    #[serde(default)]
    beacon: Beacon,
    #[serde(default)]
    evolution: Evolution,
    #[serde(default)]
    guard: Table,
    robots: Vec<WrittenRobot>,
}

/// Keys of a robot.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenRobot {
    number: u32,
    host: String,
    address: String,
    radio: Option<String>,
    #[serde(default)]
    set: Values,
}

pub(super) fn directory() -> String {
    "fleet".into()
}

pub(super) fn remote() -> String {
    "oneiro".into()
}

/// What starts and stops the daemon on a robot's computer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Service {
    /// The user's own systemd: a unit that needs no rights of root.
    #[default]
    User,
    /// The system's systemd, by `sudo` without a password: a unit with less access to the rest of the system.
    System,
    /// None: the daemon is a process that nothing restarts but `oneiro fleet start`.
    Process,
}

/// How robots' computers are reached.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ssh {
    /// The system's client.
    pub program: String,
    /// Options before the host.
    pub options: Vec<String>,
    /// Robots that are served at a time.
    pub parallel: u32,
    /// Time for one command or one file, s.
    pub(crate) timeout_s: u32,
}

impl Default for Ssh {
    fn default() -> Self {
        Self {
            program: "ssh".into(),
            options: Vec::new(),
            parallel: 8,
            timeout_s: 120,
        }
    }
}

/// The radio of a robot.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Radio {
    listen: Option<String>,
    contact: Option<Contact>,
    peers: Option<Vec<String>>,
}

/// The tracker of a robot.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tracker {
    listen: String,
    age_ms: Option<u64>,
}

/// The dead man's switch of a robot.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Beacon {
    limit_ms: Option<u64>,
}

/// The simulator of a robot.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Evolution {
    share: Option<f64>,
}

/// Tables of `robot.toml` that all robots share, or that one has instead.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Values {
    radio: Radio,
    tracker: Option<Tracker>,
    beacon: Beacon,
    evolution: Evolution,
    guard: Table,
}

impl Values {
    /// These values, where they are given, over those of the fleet.
    fn over(self, fleet: &Self) -> Self {
        let tracker = match (self.tracker, fleet.tracker.clone()) {
            (Some(tracker), fleet) => Some(Tracker {
                age_ms: tracker.age_ms.or(fleet.and_then(|fleet| fleet.age_ms)),
                ..tracker
            }),
            (None, fleet) => fleet,
        };
        let mut guard = fleet.guard.clone();
        guard.extend(self.guard);
        Self {
            radio: Radio {
                listen: self.radio.listen.or_else(|| fleet.radio.listen.clone()),
                contact: self.radio.contact.or(fleet.radio.contact),
                peers: self.radio.peers.or_else(|| fleet.radio.peers.clone()),
            },
            tracker,
            beacon: Beacon {
                limit_ms: self.beacon.limit_ms.or(fleet.beacon.limit_ms),
            },
            evolution: Evolution {
                share: self.evolution.share.or(fleet.evolution.share),
            },
            guard,
        }
    }

    /// Checks the values below a key of the file.
    fn check(&self, at: &str, source: &Source<'_>) -> Result {
        let key = |key: &str| format!("{at}{key}");
        if let Some(listen) = &self.radio.listen {
            socket(listen, &key("radio.listen"), source)?;
        }
        for (index, peer) in self.radio.peers.iter().flatten().enumerate() {
            socket(peer, &key(&format!("radio.peers[{index}]")), source)?;
        }
        if let Some(tracker) = &self.tracker {
            socket(&tracker.listen, &key("tracker.listen"), source)?;
            if let Some(age) = tracker.age_ms {
                source.within(&key("tracker.age_ms"), age, &tracker::AGES_MS)?;
            }
        }
        if let Some(limit) = self.beacon.limit_ms {
            source.within(&key("beacon.limit_ms"), limit, &BEACON_LIMITS_MS)?;
        }
        if let Some(share) = self.evolution.share {
            source.within(&key("evolution.share"), share, &SHARES)?;
        }
        for (name, value) in &self.guard {
            let refused = |problem: String| {
                let prefix = format!("guard {name}: ");
                let problem = problem.strip_prefix(&prefix).unwrap_or(&problem).to_owned();
                source.invalid(&key(&format!("guard.{name}")), problem)
            };
            guard::values::Values::of(&[format!("{name}={value}")]).map_err(refused)?;
        }
        Ok(())
    }
}

/// A robot of the fleet.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its number in the experiment.
    pub number: u32,
    /// Its computer, as `ssh` knows it.
    pub host: String,
    /// The robot, as seen from its computer.
    pub address: String,
    /// Where the others reach its radio, if it has one.
    pub radio: Option<SocketAddr>,
    /// The fraction of one core's time that its simulator may take, if the file sets it.
    pub share: Option<f64>,
    /// The duration of its experiment, in words, if it is of no swarm.
    pub time: Option<String>,
    /// The file `robot.toml` of its computer.
    pub toml: String,
    /// Its experiment and the files that this names: names there and contents.
    pub files: Vec<(String, Vec<u8>)>,
}

/// Robots with a computer each, and how these are reached.
#[derive(Clone, Debug)]
pub struct Computers {
    /// The fleet's record on this machine.
    pub directory: PathBuf,
    /// The program for the robots' computers.
    pub binary: PathBuf,
    /// Folder on robots' computers that has a directory for each robot.
    pub remote: String,
    pub service: Service,
    pub ssh: Ssh,
    pub robots: Vec<Robot>,
}

impl Computers {
    /// Checks what fleets of both kinds say of their computers; paths of this machine are relative to `folder`. Robots are still missing.
    pub(super) fn new(
        folder: &Path,
        [directory, binary, remote]: [String; 3],
        service: Service,
        ssh: Ssh,
        source: &Source<'_>,
    ) -> Result<Self> {
        plain_path(&remote, "remote", source)?;
        source.within("ssh.parallel", ssh.parallel, &(1..=64))?;
        source.within("ssh.timeout_s", ssh.timeout_s, &(1..=3600))?;
        Ok(Self {
            directory: folder.join(directory),
            binary: folder.join(binary),
            remote,
            service,
            ssh,
            robots: Vec::new(),
        })
    }

    /// Refuses a list without robots, and a number that an earlier robot has.
    pub(super) fn check_numbers(numbers: &[u32], source: &Source<'_>) -> Result {
        if numbers.is_empty() {
            return Err(source.invalid("robots", "is empty; allowed: a table [[robots]] for each robot"));
        }
        let mut known = BTreeSet::new();
        for (index, number) in numbers.iter().enumerate() {
            if !known.insert(number) {
                let problem = format!("is {number} a second time; allowed: each number once");
                return Err(source.invalid(&format!("robots[{index}].number"), problem));
            }
        }
        Ok(())
    }

    /// Directory of a robot on its computer: a path without characters that a shell would interpret.
    pub fn place(&self, robot: &Robot) -> String {
        format!("{}/robot-{}", self.remote, robot.number)
    }

    /// Directory of a robot's record on this machine.
    pub fn collected(&self, number: u32) -> PathBuf {
        self.directory.join(format!("robot-{number}"))
    }

    /// The robots of some numbers, all without any.
    ///
    /// # Errors
    /// Exit 2 for a number that no robot has.
    pub fn chosen(&self, numbers: &[u32]) -> Result<Vec<&Robot>> {
        if let Some(unknown) = numbers.iter().find(|number| self.robot(**number).is_none()) {
            let known: Vec<String> = self.robots.iter().map(|robot| robot.number.to_string()).collect();
            let known = known.join(", ");
            return Err(Failure::usage(format_args!(
                "--robots {unknown}: is not in the fleet; allowed: {known}"
            )));
        }
        let is_chosen = |robot: &&Robot| numbers.is_empty() || numbers.contains(&robot.number);
        Ok(self.robots.iter().filter(is_chosen).collect())
    }

    /// The robot of a number.
    pub fn robot(&self, number: u32) -> Option<&Robot> {
        self.robots.iter().find(|robot| robot.number == number)
    }
}

/// The fleet of a swarm, checked.
#[derive(Clone, Debug)]
pub struct Fleet {
    pub experiment: SwarmExperiment,
    /// Contents of the experiment's file.
    pub text: String,
    pub seed: u64,
    /// The file with the experiment's key on this machine.
    pub key: PathBuf,
    /// Where robots reach this machine.
    pub operator: SocketAddr,
    pub computers: Computers,
}

impl Deref for Fleet {
    type Target = Computers;

    fn deref(&self) -> &Computers {
        &self.computers
    }
}

impl Fleet {
    /// Reads and checks the file of a swarm's fleet and its experiment. The other files that it names are read when they are needed.
    ///
    /// # Errors
    /// Exit 3: the file, the line and column in it, the key, the problem and the allowed values; the robots are of no swarm.
    pub fn read(path: &Path) -> Result<Self> {
        match AnyFleet::read(path)? {
            AnyFleet::Foragers(fleet) => Ok(*fleet),
            AnyFleet::Alone(_) => Err(Failure::input(format_args!(
                "{}: its robots have no swarm's experiment; allowed for them: oneiro fleet plan, deploy, start, \
                 status, stop and collect",
                path.display()
            ))),
        }
    }

    fn of(path: &Path, file: &Parsed<'_>) -> Result<Self> {
        let (written, source): (Written, _) = Source::read(file, &[])?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let (experiment, text) = experiment(&folder.join(&written.experiment), &source)?;
        source.within("seed", written.seed, &(0..=GREATEST_SEED))?;
        let operator = socket(&written.operator, "operator", &source)?;
        let paths = [written.directory, written.binary, written.remote];
        let computers = Computers::new(folder, paths, written.service, written.ssh, &source)?;
        let values = Values {
            radio: written.radio,
            tracker: written.tracker,
            beacon: written.beacon,
            evolution: written.evolution,
            guard: written.guard,
        };
        values.check("", &source)?;
        let most = experiment.settings().world.robots;
        let mut fleet = Self {
            experiment,
            text,
            seed: written.seed,
            key: folder.join(written.key),
            operator,
            computers,
        };
        fleet.take(written.robots, &values, most, &source)?;
        Ok(fleet)
    }

    /// Checks the robots, and writes the `robot.toml` of each.
    fn take(&mut self, robots: Vec<WrittenRobot>, values: &Values, most: u32, source: &Source<'_>) -> Result {
        let numbers: Vec<u32> = robots.iter().map(|robot| robot.number).collect();
        Computers::check_numbers(&numbers, source)?;
        let mut all = Vec::new();
        for (index, robot) in robots.into_iter().enumerate() {
            let at = |key: &str| format!("robots[{index}].{key}");
            let WrittenRobot {
                number,
                host,
                address,
                radio,
                set,
            } = robot;
            if number >= most {
                let problem = format!("is {number}; allowed: 0 to {} (swarm.robots is {most})", most - 1);
                return Err(source.invalid(&at("number"), problem));
            }
            check_host(&host, &at("host"), source)?;
            wire(&address, &at("address"), source)?;
            set.check(&at("set."), source)?;
            let values = set.over(values);
            let listen = values.radio.listen.as_ref().and_then(|listen| listen.parse().ok());
            let radio = match radio {
                Some(radio) => socket(&radio, &at("radio"), source)?,
                None => radio_address(&host, listen).ok_or_else(|| {
                    let problem =
                        format!("lacks `radio`; allowed: IP:PORT of its radio, since {host} is no IP address");
                    source.invalid(&format!("robots[{index}]"), problem)
                })?,
            };
            all.push((number, host, address, radio, values));
        }
        let radios: Vec<SocketAddr> = all.iter().map(|(_, _, _, radio, _)| *radio).collect();
        for (index, (number, host, address, radio, values)) in all.into_iter().enumerate() {
            let others = radios.iter().enumerate().filter(|(other, _)| *other != index);
            let others = others.map(|(_, radio)| *radio).chain([self.operator]);
            let share = values.evolution.share;
            let others = others.map(|address| address.to_string()).collect();
            let toml = self.robot_toml(number, &address, values, others);
            self.computers.robots.push(Robot {
                number,
                host,
                address,
                radio: Some(radio),
                share,
                time: None,
                toml,
                files: vec![(EXPERIMENT.into(), self.text.clone().into_bytes())],
            });
        }
        self.computers.robots.sort_by_key(|robot| robot.number);
        Ok(())
    }

    /// The file `robot.toml` of a robot.
    fn robot_toml(&self, number: u32, address: &str, values: Values, others: Vec<String>) -> String {
        #[derive(Serialize)]
        struct File {
            experiment: &'static str,
            robot: u32,
            address: String,
            seed: u64,
            directory: &'static str,
            key: &'static str,
            radio: Radio,
            #[serde(skip_serializing_if = "Option::is_none")]
            tracker: Option<Tracker>,
            #[serde(skip_serializing_if = "Table::is_empty")]
            beacon: Table,
            #[serde(skip_serializing_if = "Table::is_empty")]
            evolution: Table,
            #[serde(skip_serializing_if = "Table::is_empty")]
            guard: Table,
        }
        let table = |key: &str, value: Option<Value>| value.map(|value| (key.to_owned(), value)).into_iter().collect();
        let file = File {
            experiment: EXPERIMENT,
            robot: number,
            address: address.to_owned(),
            seed: self.seed,
            directory: STATE,
            key: KEY,
            radio: Radio {
                listen: values.radio.listen.or_else(|| Some(format!("0.0.0.0:{PORT}"))),
                peers: values.radio.peers.or(Some(others)),
                contact: values.radio.contact,
            },
            tracker: values.tracker,
            beacon: table(
                "limit_ms",
                values.beacon.limit_ms.map(|limit| Value::Integer(limit as i64)),
            ),
            evolution: table("share", values.evolution.share.map(Value::Float)),
            guard: values.guard,
        };
        toml::to_string(&file).expect("the values are words, numbers and tables of them")
    }

    /// Hash of the experiment with the fleet's seed, by which robots and operator know that they take part in the same one.
    pub fn hash(&self) -> [u8; 32] {
        *self.experiment.identities().of(self.seed).as_bytes()
    }
}

/// A fleet of either kind.
#[derive(Debug)]
pub enum AnyFleet {
    /// Of a swarm's experiment.
    Foragers(Box<Fleet>),
    /// Of robots without a swarm.
    Alone(Computers),
}

impl AnyFleet {
    /// Reads and checks a fleet's file: as [`Fleet::read`], or as [`alone::read`] if it has nothing of a swarm.
    ///
    /// # Errors
    /// Exit 3, as those.
    pub fn read(path: &Path) -> Result<Self> {
        let text = FileKind::Fleet.text(path)?;
        let file = FileKind::Fleet.parsed(path, &text)?;
        if ["experiment", "seed", "key", "operator"]
            .iter()
            .any(|key| file.has(key))
        {
            return Ok(Self::Foragers(Box::new(Fleet::of(path, &file)?)));
        }
        alone::read(path, &file).map(Self::Alone)
    }

    pub fn computers(&self) -> &Computers {
        match self {
            Self::Foragers(fleet) => fleet,
            Self::Alone(computers) => computers,
        }
    }

    /// The file with the key of a swarm's experiment.
    pub fn key(&self) -> Option<&Path> {
        match self {
            Self::Foragers(fleet) => Some(&fleet.key),
            Self::Alone(_) => None,
        }
    }
}

/// Reads the experiment, which must have a swarm.
fn experiment(path: &Path, source: &Source<'_>) -> Result<(SwarmExperiment, String)> {
    let refused = |problem: Failure| source.invalid("experiment", problem);
    let text = files::text(path).map_err(refused)?;
    let values = FileKind::Experiment.parsed(path, &text).map_err(refused)?;
    if !values.has("swarm") {
        let problem = format!(
            "{} has no table [swarm]; allowed: an experiment with a swarm",
            path.display()
        );
        return Err(source.invalid("experiment", problem));
    }
    let experiment = SwarmExperiment::of_robots(path, &values).map_err(refused)?;
    Ok((experiment, text))
}

/// Checks the name of a computer: `ssh` must not take it for an option, nor a shell for anything else.
pub(super) fn check_host(host: &str, key: &str, source: &Source<'_>) -> Result {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-@:%".contains(c);
    if host.is_empty() || host.starts_with('-') || !host.chars().all(is_plain) {
        let problem = format!("is \"{host}\"; allowed: a name of ssh's configuration, a host, or USER@HOST");
        return Err(source.invalid(key, problem));
    }
    Ok(())
}

/// Checks a path on robots' computers, which goes into commands of a shell.
fn plain_path(path: &str, key: &str, source: &Source<'_>) -> Result {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let is_whole = path.split('/').all(|part| part != ".." && !part.starts_with('-'));
    if path.is_empty() || path == "/" || !is_whole || !path.chars().all(is_plain) {
        let problem = format!(
            "is \"{path}\"; allowed: a path of letters, digits, `.`, `_`, `-` and `/`, from the user's home or absolute"
        );
        return Err(source.invalid(key, problem));
    }
    Ok(())
}

/// The address of a robot's radio if its file doesn't give it: its computer, if that is named by its address, at the
/// port at which it listens.
fn radio_address(host: &str, listen: Option<SocketAddr>) -> Option<SocketAddr> {
    let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
    let address: IpAddr = host.parse().ok()?;
    Some(SocketAddr::new(address, listen.map_or(PORT, |listen| listen.port())))
}

/// Parses the address of a socket.
fn socket(text: &str, key: &str, source: &Source<'_>) -> Result<SocketAddr> {
    let parsed = text.parse::<SocketAddr>().ok().filter(|address| address.port() != 0);
    let allowed = || {
        source.invalid(
            key,
            format_args!("is \"{text}\"; allowed: IP:PORT, such as 10.0.0.1:{PORT}"),
        )
    };
    parsed.ok_or_else(allowed)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const HEAD: &str = "experiment = \"experiments/odowd2014-over.toml\"\nseed = 7\nkey = \"k\"\noperator = \"10.0.0.1:4711\"\nbinary = \"b\"\n";
    const ROBOT_0: &str = "[[robots]]\nnumber = 0\nhost = \"pi@10.0.0.10\"\naddress = \"serial:/dev/rfcomm0\"\n";

    /// Reads a fleet's file whose text follows the required keys.
    fn read(name: &str, text: &str) -> Result<Fleet> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()
            .unwrap();
        let path = std::env::temp_dir().join(format!("oneiro-fleet-file-{name}-{}.toml", std::process::id()));
        let head = HEAD.replace("experiments/", &format!("{}/experiments/", root.display()));
        fs::write(&path, head + text).unwrap();
        let fleet = Fleet::read(&path);
        fs::remove_file(path).unwrap();
        fleet
    }

    #[test]
    fn a_robot_s_file_has_what_it_shares_and_what_it_has_instead() {
        let text = format!(
            "[tracker]\nlisten = \"0.0.0.0:5005\"\nage_ms = 250\n[evolution]\nshare = 0.5\n[guard]\nexpiry_ms = 200\nerrors = 5\n\
             {ROBOT_0}[[robots]]\nnumber = 3\nhost = \"epuck-3\"\nradio = \"10.0.0.13:4800\"\n\
             address = \"tcp:10.0.1.3:1000\"\n[robots.set]\nradio.listen = \"0.0.0.0:4800\"\nbeacon.limit_ms = 300\nguard.errors = 2\n"
        );
        let fleet = read("whole", &text).unwrap();
        assert_eq!(fleet.robots.len(), 2);
        assert_eq!(fleet.robots[0].radio.unwrap().to_string(), "10.0.0.10:4711");
        assert_eq!(
            fleet.robots[1].toml,
            "experiment = \"experiment.toml\"\nrobot = 3\naddress = \"tcp:10.0.1.3:1000\"\nseed = 7\ndirectory = \"state\"\n\
             key = \"experiment.key\"\n\n[radio]\nlisten = \"0.0.0.0:4800\"\n\
             peers = [\"10.0.0.10:4711\", \"10.0.0.1:4711\"]\n\n[tracker]\nlisten = \"0.0.0.0:5005\"\nage_ms = 250\n\n\
             [beacon]\nlimit_ms = 300\n\n[evolution]\nshare = 0.5\n\n[guard]\nexpiry_ms = 200\nerrors = 2\n"
        );
        // Values without a setting are left to the daemon.
        let fleet = read("least", ROBOT_0).unwrap();
        assert!(
            !["contact", "[tracker]", "[beacon]", "[evolution]", "[guard]"]
                .iter()
                .any(|no| fleet.robots[0].toml.contains(no))
        );
        assert_eq!(fleet.place(&fleet.robots[0]), "oneiro/robot-0");
    }

    /// The daemon reads what the fleet writes, and finds the same experiment in it.
    #[test]
    fn the_daemon_takes_a_robot_s_file() {
        let text = format!(
            "[radio]\ncontact = \"range\"\n[tracker]\nlisten = \"0.0.0.0:5005\"\nage_ms = 250\n[beacon]\nlimit_ms = 300\n\
             [evolution]\nshare = 1\n[guard]\nexpiry_ms = 200\n{ROBOT_0}"
        );
        let fleet = read("daemon", &text).unwrap();
        let directory = std::env::temp_dir().join(format!("oneiro-fleet-daemon-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join(ROBOT), &fleet.robots[0].toml).unwrap();
        fs::write(directory.join(EXPERIMENT), &fleet.text).unwrap();
        let settings = crate::daemon::settings::Settings::read(&directory.join(ROBOT)).unwrap();
        assert_eq!(*settings.experiment.as_bytes(), fleet.hash());
        assert_eq!(settings.radio.peers, [fleet.operator.to_string()]);
        assert_eq!(settings.guard, ["expiry_ms=200"]);
        fs::remove_dir_all(directory).unwrap();
    }

    /// The experiment's hash is that of a run with the fleet's seed, which another seed does not have.
    #[test]
    fn the_hash_depends_on_the_experiment_and_the_seed() {
        let of = |seed: &str| {
            let root = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../..")
                .canonicalize()
                .unwrap();
            let path = std::env::temp_dir().join(format!("oneiro-fleet-hash-{seed}-{}.toml", std::process::id()));
            let head = HEAD.replace("experiments/", &format!("{}/experiments/", root.display()));
            fs::write(&path, head.replace("seed = 7", &format!("seed = {seed}")) + ROBOT_0).unwrap();
            let fleet = Fleet::read(&path).unwrap();
            fs::remove_file(path).unwrap();
            (
                fleet.hash(),
                *fleet.experiment.identities().of(seed.parse().unwrap()).as_bytes(),
            )
        };
        let (seven, eight) = (of("7"), of("8"));
        assert_eq!((seven.0, eight.0), (seven.1, eight.1));
        assert_ne!(seven.0, eight.0);
    }

    /// Each mistake with its place, its key and what is allowed.
    #[test]
    fn mistakes_are_refused_with_their_place() {
        let robot = |lines: &str| format!("{ROBOT_0}{lines}");
        for (text, words) in [
            (String::new(), "lacks `robots`"),
            (
                "robots = []\n".into(),
                ":6:10: robots: is empty; allowed: a table [[robots]] for each robot",
            ),
            (
                ROBOT_0.replace("number = 0", "number = 10"),
                ":7:10: robots[0].number: is 10; allowed: 0 to 9 (swarm.robots is 10)",
            ),
            (
                format!("{ROBOT_0}{ROBOT_0}"),
                ":11:10: robots[1].number: is 0 a second time; allowed: each number once",
            ),
            (
                ROBOT_0.replace("pi@10.0.0.10", "-oProxyCommand=x"),
                ":8:8: robots[0].host: is \"-oProxyCommand=x\"; allowed: a name",
            ),
            (
                ROBOT_0.replace("pi@10.0.0.10", "-J10.0.0.9"),
                "robots[0].host: is \"-J10.0.0.9\"",
            ),
            (
                ROBOT_0.replace("pi@10.0.0.10", "pi;reboot"),
                "robots[0].host: is \"pi;reboot\"",
            ),
            (
                ROBOT_0.replace("serial:/dev/rfcomm0", "usb:0"),
                ":9:11: robots[0].address: robot usb:0: `usb` is no way to reach a robot",
            ),
            (
                ROBOT_0.replace("serial:/dev/rfcomm0", "surrogate:1"),
                "robots[0].address: robot surrogate:1: a surrogate has no link; allowed: serial:PATH",
            ),
            (
                robot("radio = \"10.0.0.9\"\n"),
                ":10:9: robots[0].radio: is \"10.0.0.9\"; allowed: IP:PORT, such as 10.0.0.1:4711",
            ),
            (
                ROBOT_0.replace("pi@10.0.0.10", "epuck-0"),
                ":6:1: robots[0]: lacks `radio`; allowed: IP:PORT of its radio, since epuck-0 is no IP address",
            ),
            (
                robot("colour = 1\n"),
                "unknown key `colour`; allowed: number, host, address, radio, set",
            ),
            (
                robot("set.guard.expiry_ms = 5\n"),
                ":10:23: robots[0].set.guard.expiry_ms: `5` is out of range; allowed: 100 to 500 ms",
            ),
            (
                robot("set.beacon.limit_ms = 900\n"),
                "robots[0].set.beacon.limit_ms: is 900; allowed: 100 to 450",
            ),
            (
                format!("[evolution]\nshare = 1.5\n{ROBOT_0}"),
                ":7:9: evolution.share: is 1.5; allowed: 0.01 to 1",
            ),
            (
                format!("[tracker]\nlisten = \"5005\"\n{ROBOT_0}"),
                ":7:10: tracker.listen: is \"5005\"; allowed: IP:PORT",
            ),
            (
                format!("[tracker]\nlisten = \"0.0.0.0:5005\"\nage_ms = 9\n{ROBOT_0}"),
                "tracker.age_ms: is 9; allowed: 50 to 2000",
            ),
            (
                format!("[radio]\ncontact = \"smell\"\n{ROBOT_0}"),
                "radio.contact: unknown choice `smell`; allowed: tracker",
            ),
            (
                format!("[guard]\nexpiry = 5\n{ROBOT_0}"),
                "guard.expiry: is no value of the guard; allowed: expiry_ms, silence_ms",
            ),
            (
                format!("remote = \"a b\"\n{ROBOT_0}"),
                ":6:10: remote: is \"a b\"; allowed: a path of letters",
            ),
            (format!("remote = \"../x\"\n{ROBOT_0}"), "remote: is \"../x\""),
            (
                format!("service = \"cron\"\n{ROBOT_0}"),
                "service: unknown choice `cron`; allowed: user, system, process",
            ),
            (
                format!("[ssh]\nparallel = 0\n{ROBOT_0}"),
                ":7:12: ssh.parallel: is 0; allowed: 1 to 64",
            ),
            (
                format!("colour = 1\n{ROBOT_0}"),
                "unknown key `colour`; allowed: experiment, seed, directory",
            ),
        ] {
            let failure = read("bad", &text).unwrap_err();
            let message = failure.to_string();
            assert!(
                message.contains(words) && failure.code() == 3,
                "{text}\n{message}\n{words}"
            );
        }
    }

    /// The page's example is a fleet, and its table has a row for each key, which are those that refusals list.
    #[test]
    fn the_page_has_every_key_and_an_example_that_works() {
        let page = include_str!("../../../../docs/fleet.md");
        let (_, example) = page.split_once("```toml\n").unwrap();
        let (example, _) = example.split_once("```").unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()
            .unwrap();
        let example = example.replace(
            "odowd2014-over.toml",
            &format!("{}/experiments/odowd2014-over.toml", root.display()),
        );
        let path = std::env::temp_dir().join(format!("oneiro-fleet-page-{}.toml", std::process::id()));
        fs::write(&path, example).unwrap();
        assert_eq!(Fleet::read(&path).unwrap().robots.len(), 2);
        fs::remove_file(path).unwrap();
        let robot = |line: &str| ROBOT_0.to_owned() + line;
        for (table, text) in [
            ("", format!("colour = 1\n{ROBOT_0}")),
            ("ssh.", format!("[ssh]\ncolour = 1\n{ROBOT_0}")),
            ("radio.", format!("[radio]\ncolour = 1\n{ROBOT_0}")),
            ("tracker.", format!("[tracker]\ncolour = 1\n{ROBOT_0}")),
            ("beacon.", format!("[beacon]\ncolour = 1\n{ROBOT_0}")),
            ("evolution.", format!("[evolution]\ncolour = 1\n{ROBOT_0}")),
            ("robots[].", robot("colour = 1\n")),
        ] {
            let refusal = read("page", &text).unwrap_err().to_string();
            let (_, keys) = refusal.split_once("unknown key `colour`; allowed: ").unwrap();
            // Each other problem has a line.
            let keys = keys.lines().next().unwrap();
            for key in keys
                .split(';')
                .next()
                .unwrap()
                .split(", ")
                .flat_map(|keys| keys.split(" or "))
            {
                let is_table = table.is_empty() && page.contains(&format!("| `{key}."));
                let is_list = key == "robots" && page.contains("| `robots[].number` |");
                assert!(
                    is_table || is_list || page.contains(&format!("| `{table}{key}` |")),
                    "{table}{key}"
                );
            }
        }
    }

    #[test]
    fn only_foragers_run_on_fleets() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()
            .unwrap();
        let path = std::env::temp_dir().join(format!("oneiro-fleet-khepera-{}.toml", std::process::id()));
        let control = path.with_extension("control.toml");
        fs::write(&control, "[swarm]\ncontrol = \"fitness-shuffled\"\n").unwrap();
        let [ring, rare] = ["ring", "rare"].map(|name| path.with_extension(format!("{name}.toml")));
        fs::write(&ring, "[swarm]\nmessages.topology = \"ring\"\n").unwrap();
        fs::write(&rare, "[swarm]\nmessages.migration = 0.5\n").unwrap();
        for (experiment, words) in [
            (
                ring.to_str().unwrap(),
                "swarm.messages.topology: is `ring`, which needs the evolution of all robots in one program; allowed: encounters",
            ),
            (
                rare.to_str().unwrap(),
                "swarm.messages.migration: is 0.5, which needs the evolution of all robots in one program; allowed: 1",
            ),
            (
                control.to_str().unwrap(),
                "swarm.control: is a control, which needs the evolution of all robots in one program; allowed: evolved",
            ),
            (
                "experiments/khepera-avoidance.toml",
                "has no table [swarm]; allowed: an experiment with a swarm",
            ),
            ("experiments/none.toml", "No such file"),
        ] {
            let head = HEAD.replace(
                "experiments/odowd2014-over.toml",
                &root.join(experiment).display().to_string(),
            );
            fs::write(&path, head + ROBOT_0).unwrap();
            let message = Fleet::read(&path).unwrap_err().to_string();
            assert!(
                message.contains(":1:14: experiment: ") && message.contains(words),
                "{message}"
            );
        }
        for file in [path, control, ring, rare] {
            fs::remove_file(file).unwrap();
        }
    }
}
