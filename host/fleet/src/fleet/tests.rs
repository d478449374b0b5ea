use std::fmt::Write;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use oneiro_lab::exchange::radio::key::Key;

use super::file::{Fleet, Robot};
use super::install::{Installed, Stock};
use super::remote::{Remote, on_each};
use super::service::{self, ServiceState};
use super::{Outcomes, collect, enough};

/// A place with a fleet's file, and a home for each host behind a stand-in for ssh.
struct Place(PathBuf);

impl Place {
    /// Makes the folders and files of a fleet of `robots` robots.
    fn new(name: &str, robots: u32) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-fleet-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        let place = Self(path);
        for robot in 0..robots {
            fs::create_dir_all(place.home(robot)).unwrap();
        }
        Key::create(&place.0.join("experiment.key")).unwrap();
        // A program of this machine: a shell, whose first argument is the script that stands in for the daemon.
        fs::copy("/bin/sh", place.0.join("oneiro")).unwrap();
        fs::write(place.0.join("fleet.toml"), place.text(robots)).unwrap();
        place
    }

    fn text(&self, robots: u32) -> String {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()
            .unwrap();
        let (root, folder) = (root.display(), self.0.display());
        let mut text = format!(
            "experiment = \"{root}/experiments/odowd2014-over.toml\"\nseed = 1\nkey = \"experiment.key\"\n\
             operator = \"10.0.0.1:4711\"\nbinary = \"oneiro\"\nservice = \"process\"\ndirectory = \"record\"\n\
             [ssh]\nprogram = \"{root}/tests/fleet/ssh\"\noptions = [\"-F\", \"{folder}\"]\ntimeout_s = 2\nparallel = 3\n"
        );
        for robot in 0..robots {
            let number = format!("number = {robot}\nhost = \"host-{robot}\"\nradio = \"10.0.0.1{robot}:4711\"");
            writeln!(text, "[[robots]]\n{number}\naddress = \"tcp:10.0.1.{robot}:1000\"").unwrap();
        }
        text
    }

    fn fleet(&self) -> Fleet {
        Fleet::read(&self.0.join("fleet.toml")).unwrap()
    }

    fn home(&self, robot: u32) -> PathBuf {
        self.0.join(format!("host-{robot}"))
    }

    /// A file of a robot's directory on its computer.
    fn there(&self, robot: u32, name: &str) -> PathBuf {
        self.home(robot).join(format!("oneiro/robot-{robot}/{name}"))
    }

    /// Makes a host fail.
    fn make(&self, robot: u32, state: &str) {
        fs::write(self.home(robot).join(".state"), state).unwrap();
    }

    fn deploy(&self) -> Outcomes<Installed> {
        let fleet = self.fleet();
        let stock = Stock::read(&fleet, Some(&fleet.key)).unwrap();
        let robots = fleet.chosen(&[]).unwrap();
        on_each(&fleet, &robots, |robot, remote| stock.install(&fleet, robot, remote))
    }

    /// Gives a robot the script that stands in for the daemon.
    fn equip(&self, robot: u32) {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fleet/on-board");
        fs::copy(script, self.there(robot, "on-board")).unwrap();
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn problem<T>(outcomes: &Outcomes<T>, robot: usize) -> String {
    outcomes[robot]
        .1
        .as_ref()
        .err()
        .map(ToString::to_string)
        .unwrap_or_default()
}

/// Of five computers one is off, one asks for a password, one hangs and one loses a byte of each file. The fifth gets everything.
#[test]
fn computers_that_fail_keep_no_other_from_being_installed() {
    let place = Place::new("deploy", 5);
    for (robot, state) in [(0, "down"), (1, "denied"), (2, "hang"), (3, "cut")] {
        place.make(robot, state);
    }
    let began = Instant::now();
    let outcomes = place.deploy();
    assert!(began.elapsed() < Duration::from_secs(20), "{:?}", began.elapsed());
    for (robot, words) in [
        (0, "No route to host; is it on, in this network"),
        (
            1,
            "Permission denied (publickey,password).; it may ask for no password here: `ssh-copy-id host-1` once",
        ),
        (2, "took longer than 2 s (ssh.timeout_s)"),
        (3, "oneiro arrived damaged"),
    ] {
        let problem = problem(&outcomes, robot);
        assert!(problem.contains(words), "{problem}");
    }
    let installed = outcomes[4].1.as_ref().unwrap();
    assert_eq!(
        installed.sent,
        ["oneiro", "experiment.toml", "robot.toml", "experiment.key"]
    );
    let fleet = place.fleet();
    let stock = Stock::read(&fleet, Some(&fleet.key)).unwrap();
    for (parcel, mode) in stock.parcels(&fleet.robots[4]).iter().zip([0o755, 0o644, 0o644, 0o600]) {
        let path = place.there(4, parcel.name);
        assert_eq!(fs::read(&path).unwrap(), parcel.bytes, "{}", parcel.name);
        assert_eq!(
            fs::metadata(&path).unwrap().permissions().mode() & 0o777,
            mode,
            "{}",
            parcel.name
        );
    }
    // Nothing of a damaged file is left.
    assert!(!place.there(3, "oneiro").exists() && !place.there(3, ".oneiro.new").exists());
    assert!(enough(&outcomes, Some(1), "deploy").is_ok());
    for min in [None, Some(2)] {
        let failure = enough(&outcomes, min, "deploy").unwrap_err();
        assert_eq!(failure.code(), 4);
        assert!(
            failure.to_string().starts_with("deploy: 4 of 5 robots failed"),
            "{failure}"
        );
    }
}

#[test]
fn what_is_there_already_is_not_sent_again_and_a_damaged_file_replaces_nothing() {
    let place = Place::new("again", 1);
    assert_eq!(place.deploy()[0].1.as_ref().unwrap().sent.len(), 4);
    assert!(place.deploy()[0].1.as_ref().unwrap().sent.is_empty());
    let old = fs::read_to_string(place.there(0, "robot.toml")).unwrap();
    fs::write(
        place.0.join("fleet.toml"),
        place.text(1).replace("seed = 1", "seed = 2"),
    )
    .unwrap();
    place.make(0, "cut");
    assert!(problem(&place.deploy(), 0).contains("robot.toml arrived damaged"));
    assert_eq!(fs::read_to_string(place.there(0, "robot.toml")).unwrap(), old);
    place.make(0, "");
    assert_eq!(place.deploy()[0].1.as_ref().unwrap().sent, ["robot.toml"]);
    assert_eq!(
        fs::read_to_string(place.there(0, "robot.toml")).unwrap(),
        old.replace("seed = 1", "seed = 2")
    );
}

#[test]
fn a_program_for_another_processor_is_not_sent() {
    let place = Place::new("arm", 1);
    place.make(0, "arm");
    let problem = problem(&place.deploy(), 0);
    assert!(
        problem.contains("its processor is armv6l") && problem.contains("oneiro is for 64-bit"),
        "{problem}"
    );
    assert!(!place.there(0, "oneiro").exists());
}

/// A daemon as a process: started once, found, stopped, and its log read for what the wheels do.
#[test]
fn daemons_are_started_once_and_their_stop_is_confirmed_by_the_log() {
    let place = Place::new("start", 2);
    place.deploy();
    let fleet = place.fleet();
    let state = |robot: &Robot| service::state(&fleet, robot, Remote::of(&fleet, robot)).unwrap();
    let start = |robot: &Robot| Remote::of(&fleet, robot).run(&service::start_command(&fleet, robot));
    let [first, second] = &fleet.robots[..] else {
        panic!("two robots")
    };
    // Without what it needs the daemon ends at once.
    let failure = start(second).unwrap_err();
    assert_eq!(
        (failure.code(), state(second).0),
        (4, ServiceState::Stopped),
        "{failure}"
    );
    place.equip(0);
    start(first).unwrap();
    let process = fs::read_to_string(place.there(0, "pid")).unwrap();
    start(first).unwrap();
    assert_eq!(fs::read_to_string(place.there(0, "pid")).unwrap(), process);
    let (running, last) = state(first);
    assert_eq!(running, ServiceState::Running);
    assert!(last.unwrap().contains("\"start\""));
    let warnings = {
        fs::write(
            place.0.join("fleet.toml"),
            place.text(2).replace("seed = 1", "seed = 2"),
        )
        .unwrap();
        let outcomes = place.deploy();
        outcomes[0].1.as_ref().unwrap().warnings.clone()
    };
    assert!(warnings[0].contains("runs its earlier files"), "{warnings:?}");
    let stop = |robot: &Robot| service::stop(&fleet, robot, Remote::of(&fleet, robot));
    stop(first).unwrap();
    assert_eq!(state(first).0, ServiceState::Stopped);
    // Stopped again, its log still confirms it; a log without the wheels is no confirmation, nor is a missing log.
    stop(first).unwrap();
    fs::write(
        place.there(0, "state/log.jsonl"),
        "{\"event\":\"end\",\"stopped\":false}\n",
    )
    .unwrap();
    assert!(
        stop(first)
            .unwrap_err()
            .to_string()
            .contains("does not say that its wheels stand")
    );
    assert!(stop(second).unwrap_err().to_string().contains("has no log"));
}

/// Two robots that hear each other, one of which is cut off in the middle of a line, and a third that is off.
#[test]
fn records_are_copied_and_merged_and_what_was_copied_before_stays() {
    let place = Place::new("collect", 3);
    place.deploy();
    let fleet = place.fleet();
    let copied = || {
        let robots = fleet.chosen(&[]).unwrap();
        on_each(&fleet, &robots, |robot, remote| collect::copy(&fleet, robot, remote))
    };
    for robot in [0, 1] {
        fs::create_dir_all(place.there(robot, "state")).unwrap();
        let mut log = String::new();
        for second in 0..10_u32 {
            let (said, heard) = (1000 * second + 100 * robot, 1000 * second + 100 * (1 - robot) + 5);
            let times = |at: u32| format!("\"at_ms\":{at},\"experiment_ms\":{at},\"boot\":1,\"sequence\":{second}");
            writeln!(log, "{{{},\"event\":\"said\"}}", times(said)).unwrap();
            writeln!(log, "{{{},\"event\":\"heard\",\"sender\":{}}}", times(heard), 1 - robot).unwrap();
        }
        log += "{\"at_ms\":99";
        fs::write(place.there(robot, "state/log.jsonl"), log).unwrap();
        fs::write(
            place.there(robot, "state/intervals.csv"),
            format!("interval,robot\n0,{robot}\n"),
        )
        .unwrap();
        fs::write(place.there(robot, "state/checkpoint.tmp"), "half").unwrap();
    }
    place.make(2, "down");
    let outcomes = copied();
    assert_eq!(outcomes.iter().filter(|(_, outcome)| outcome.is_ok()).count(), 2);
    assert!(!fleet.collected(0).join("checkpoint.tmp").exists());
    let merged = collect::merge(&fleet, &[0, 1]).unwrap();
    assert_eq!((merged.lines, merged.clocks.len()), (40, 2));
    assert_eq!(merged.warnings, ["2 torn lines of logs were left out"]);
    let timeline = fs::read_to_string(fleet.directory.join(collect::TIMELINE)).unwrap();
    let times: Vec<f64> = timeline
        .lines()
        .map(|line| {
            serde_json::from_str::<serde_json::Value>(line).unwrap()["time_ms"]
                .as_f64()
                .unwrap()
        })
        .collect();
    assert_eq!(times.len(), 40);
    assert!(times.is_sorted(), "{times:?}");
    let intervals = fs::read_to_string(fleet.directory.join("intervals.csv")).unwrap();
    assert_eq!(intervals, "interval,robot\n0,0\n0,1\n");
    // An unreachable directory is not lost.
    place.make(1, "down");
    assert_eq!(copied().iter().filter(|(_, outcome)| outcome.is_ok()).count(), 1);
    assert_eq!(collect::merge(&fleet, &[0, 1]).unwrap().lines, 40);
}

/// A computer's answer has a maximum size: it fills no memory, and takes only a command's time.
#[test]
fn computers_that_answer_without_end_are_left() {
    let place = Place::new("endless", 4);
    let fleet = place.fleet();
    for robot in 0..4 {
        fs::create_dir_all(place.there(robot, "state")).unwrap();
        fs::write(place.there(robot, "state/log.jsonl"), "{}\n").unwrap();
    }
    for (robot, state) in [(0, "endless"), (1, "chatty"), (2, "large")] {
        place.make(robot, state);
    }
    let began = Instant::now();
    let robots = fleet.chosen(&[]).unwrap();
    let outcomes = on_each(&fleet, &robots, |robot, remote| collect::copy(&fleet, robot, remote));
    assert!(began.elapsed() < Duration::from_secs(40), "{:?}", began.elapsed());
    for (robot, words) in [
        (0, "answered with more than 1048576 bytes"),
        (1, "took longer than 2 s (ssh.timeout_s)"),
        (2, "log.jsonl: answered with more than 67108864 bytes"),
    ] {
        let problem = problem(&outcomes, robot);
        assert!(problem.contains(words), "{robot}: {problem}");
    }
    assert_eq!(outcomes[3].1.as_ref().unwrap().files, 1);
    assert!(!fleet.collected(2).join("log.jsonl").exists());
}

/// A user's own unit has no line of the system's, and both have all names filled in.
#[test]
fn units_are_whole() {
    let place = Place::new("unit", 1);
    let mut fleet = place.fleet();
    for (kind, is_system) in [
        (super::file::Service::User, false),
        (super::file::Service::System, true),
    ] {
        fleet.computers.service = kind;
        let text = service::unit_text(&fleet, &fleet.robots[0], "/home/pi/oneiro/robot-0", "pi");
        assert!(!text.contains('@') && !text.contains("#system"), "{text}");
        for line in ["Type=notify", "WatchdogSec=5", "KillMode=process", "Restart=on-failure"] {
            assert!(text.lines().any(|other| other == line), "{line}");
        }
        for line in [
            "User=pi",
            "SupplementaryGroups=dialout",
            "ProtectSystem=strict",
            "WantedBy=multi-user.target",
        ] {
            assert_eq!(text.lines().any(|other| other == line), is_system, "{line}");
        }
        assert!(text.contains("ExecStart=/home/pi/oneiro/robot-0/oneiro on-board robot.toml"));
    }
}

/// Robots of a swarm and of none have their own kinds of fleets.
#[cfg(feature = "compose")]
mod alone {
    use super::*;
    use crate::daemon::single::settings::Settings;
    use crate::fleet::file::AnyFleet;
    use oneiro_lab::experiment::source::Parsed;

    /// Two robots with their files and experiments: one with sampled tables and a custom part, one parametric.
    fn placed(name: &str) -> Place {
        let place = Place::new(name, 3);
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()
            .unwrap();
        fs::create_dir_all(place.0.join("own")).unwrap();
        let thymio = "[robot]\npreset = \"thymio2\"\n[arena]\nwidth_mm = 900\nheight_mm = 900\n";
        fs::write(place.0.join("own/thymio.toml"), thymio).unwrap();
        let sampled = root.join("studies/miglino1995/elsewhere/thymio.toml");
        for (number, experiment) in [(1, sampled.display().to_string()), (2, "thymio.toml".into())] {
            let text = format!(
                "# Robot {number}\nexperiment = \"{experiment}\"\naddress = \"serial:/dev/ttyACM0\"\nseed = {number}\n\
                 directory = \"here\"\n[lives]\ntracker = \"udp:0.0.0.0:5005#{number}\"\n[transfers]\ngenerations = 3\n"
            );
            fs::write(place.0.join(format!("own/robot-{number}.toml")), text).unwrap();
        }
        fs::write(place.0.join("fleet.toml"), text(&place)).unwrap();
        place
    }

    fn text(place: &Place) -> String {
        let swarm = place.text(0);
        // Without the keys of a swarm.
        let is_shared = |line: &&str| {
            !["experiment", "seed", "key", "operator"]
                .iter()
                .any(|key| line.starts_with(key))
        };
        let mut text = swarm.lines().filter(is_shared).collect::<Vec<_>>().join("\n") + "\n";
        for robot in [2, 1] {
            writeln!(
                text,
                "[[robots]]\nnumber = {robot}\nhost = \"host-{robot}\"\nrobot = \"own/robot-{robot}.toml\""
            )
            .unwrap();
        }
        text
    }

    fn read(place: &Place) -> oneiro_base::exit::Result<AnyFleet> {
        AnyFleet::read(&place.0.join("fleet.toml"))
    }

    /// Each computer gets its robot's own experiment, with its files, which the daemon there takes for the same one.
    #[test]
    fn each_gets_its_own_experiment_and_is_started_and_stopped() {
        let place = placed("alone");
        let any = read(&place).unwrap();
        let fleet = any.computers();
        let stock = Stock::read(fleet, any.key()).unwrap();
        let robots = fleet.chosen(&[]).unwrap();
        let deploy = || on_each(fleet, &robots, |robot, remote| stock.install(fleet, robot, remote));
        let sent = |outcomes: &Outcomes<Installed>| -> Vec<Vec<String>> {
            let sent = outcomes
                .iter()
                .map(|(_, outcome)| outcome.as_ref().unwrap().sent.clone());
            sent.collect()
        };
        let mut first = sent(&deploy());
        for sent in &mut first {
            sent.sort();
        }
        let inputs = ["inputs/equation1.wgsl", "inputs/round.sam", "inputs/wall.sam"];
        let [experiment, always @ ..] = ["experiment.toml", "oneiro", "robot.toml"];
        assert_eq!(first[0], [&[experiment], &inputs[..], &always].concat());
        assert_eq!(first[1], [&[experiment][..], &always].concat());
        assert!(sent(&deploy()).iter().all(Vec::is_empty));
        for number in [1, 2] {
            let settings = |path: PathBuf| {
                let text = fs::read_to_string(&path).unwrap();
                let parsed = Parsed::new(path.display().to_string(), &text).unwrap();
                Settings::of(&path, &parsed).unwrap()
            };
            let there = settings(place.there(number, "robot.toml"));
            let settings_of_file = settings(place.0.join(format!("own/robot-{number}.toml")));
            assert_eq!(there.identity, settings_of_file.identity);
            assert_eq!((there.seed, &there.rules), (number.into(), &settings_of_file.rules));
            assert_eq!(there.lives.trackers, settings_of_file.lives.trackers);
            assert_eq!(there.directory, place.there(number, "state"));
        }

        place.equip(1);
        let [first, second] = robots[..] else {
            panic!("two robots")
        };
        let state = |robot: &Robot| service::state(fleet, robot, Remote::of(fleet, robot)).unwrap().0;
        let start = |robot: &Robot| Remote::of(fleet, robot).run(&service::start_command(fleet, robot));
        start(first).unwrap();
        assert_eq!(
            (state(first), state(second)),
            (ServiceState::Running, ServiceState::Stopped)
        );
        service::stop(fleet, first, Remote::of(fleet, first)).unwrap();
        assert_eq!(state(first), ServiceState::Stopped);

        // Records have folders.
        fs::create_dir_all(place.there(1, "state/lives")).unwrap();
        fs::write(place.there(1, "state/lives/life-1.csv"), "cycle\n").unwrap();
        assert!(collect::copy(fleet, first, Remote::of(fleet, first)).unwrap().files >= 2);
        assert!(fleet.collected(1).join("lives/life-1.csv").exists());
    }

    #[test]
    fn the_documented_file_is_allowed() {
        let place = placed("alone-documented");
        let page = include_str!("../../../../docs/on-board.md");
        let (_, example) = page.split_once("```toml\n# fleet.toml\n").unwrap();
        let (example, _) = example.split_once("```").unwrap();
        fs::write(place.0.join("own/fleet.toml"), example).unwrap();
        let any = AnyFleet::read(&place.0.join("own/fleet.toml")).unwrap();
        assert_eq!(any.computers().robots.len(), 2);
    }

    #[test]
    fn what_is_not_allowed_is_refused_at_its_place() {
        let place = placed("alone-refused");
        let text = text(&place);
        let file = |number: u32| place.0.join(format!("own/robot-{number}.toml"));
        let good = fs::read_to_string(file(1)).unwrap();
        let failure = Fleet::read(&place.0.join("fleet.toml")).unwrap_err();
        assert!(
            failure.code() == 3
                && failure
                    .to_string()
                    .contains("fleet.toml: its robots have no swarm's experiment"),
            "{failure}"
        );
        for (fleet, robot, words) in [
            (
                text.replace("[[robots]]\nnumber = 2", "[[robots]]\nnumber = 1"),
                &*good,
                "robots[1].number: is 1 a second time",
            ),
            (
                text.replace("host-2", "-o"),
                &*good,
                "robots[0].host: is \"-o\"; allowed: a name",
            ),
            (
                text.replace("number = 2", "number = 2\naddress = \"tcp:1\""),
                &*good,
                "unknown key `address`; allowed: number, host, robot",
            ),
            // The file of a swarm.
            (
                text.replace("binary", "seed = 1\nbinary"),
                &*good,
                "unknown key `robot`; allowed: number, host, address",
            ),
            (text.replace("robot-2.toml", "none.toml"), &*good, "robots[0].robot: "),
            (
                text.clone(),
                "robot = 1\n",
                "is of a member of a swarm; allowed: a file without robot",
            ),
            (
                text.clone(),
                &*good.replace("generations = 3", "generations = 0"),
                "transfers.generations: ",
            ),
            (
                text.clone(),
                &*good.replace("tracker =", "camera ="),
                "unknown key `camera`",
            ),
        ] {
            fs::write(place.0.join("fleet.toml"), &fleet).unwrap();
            fs::write(file(1), robot).unwrap();
            let failure = read(&place).unwrap_err();
            let message = failure.to_string();
            assert!(failure.code() == 3 && message.contains(words), "{message}\n{words}");
        }
    }
}
