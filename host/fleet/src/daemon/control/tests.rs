//! A daemon on a virtual clock, with an obedient robot, an operator and a tracker.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

use oneiro_lab::exchange::radio::OPERATOR;
use oneiro_lab::swarm::Plan;
use oneiro_lab::swarm::record::{Case, Kind};
use oneiro_lab::swarm::settings::Settings as Foragers;
use oneiro_robots::vehicle::{Moment, Profile};

use super::*;
use crate::daemon::settings::{Beacon, Evolution, Radio as RadioSettings, Tracker};

const KEY: &str = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";
/// The number of the operator's start.
const START_NUMBER: u64 = 77;
/// When the experiment begins on the daemon's clock.
const START: Duration = Duration::from_secs(2);

/// What surrounds the daemon.
struct World {
    now: Duration,
    operator: Radio,
    /// Whether the operator and the tracker are there.
    operates: fn(Duration) -> bool,
    sees: fn(Duration) -> bool,
    /// Whether the robot answers.
    answers: fn(Duration) -> bool,
    /// Food that the robot has brought.
    brought: fn(Duration) -> u32,
    /// What somebody else sends in the tracker's place.
    lies: fn(Duration) -> Vec<String>,
    coming: VecDeque<(Channel, Vec<u8>)>,
    /// Speeds of the left wheel from each moment on.
    driven: Vec<(Duration, f64)>,
    /// The daemon's messages.
    said: Vec<Received>,
    /// When the daemon is told to stop.
    end: Duration,
    stop: Arc<AtomicBool>,
}

impl World {
    /// Lets time pass until the next cycle begins, when the operator and the tracker speak.
    fn pass_until(&mut self, until: Duration) {
        let cycle = |time: Duration| time.as_millis() / 100;
        while self.now < until {
            let before = cycle(self.now);
            self.now = until.min(Duration::from_millis(100 * (before as u64 + 1)));
            if cycle(self.now) == before {
                continue;
            }
            if (self.operates)(self.now) {
                let milliseconds = self.now.as_millis() as i64 - START.as_millis() as i64;
                let beacon = self.operator.seal(&Packet::Beacon {
                    milliseconds,
                    go: true,
                    start: START_NUMBER,
                });
                self.coming.push_back((Channel::Radio, beacon));
            }
            if (self.sees)(self.now) {
                let (time, brought) = (self.now.as_secs_f64(), (self.brought)(self.now));
                let line = format!(
                    "{{\"id\":1,\"t\":{time},\"x\":10,\"y\":20,\"heading\":0.5,\"carries\":false,\"brought\":{brought},\"heard\":[0]}}"
                );
                self.coming.push_back((Channel::Tracker, line.into_bytes()));
            }
            let lies = (self.lies)(self.now).into_iter();
            self.coming.extend(lies.map(|lie| (Channel::Tracker, lie.into_bytes())));
        }
        if self.now >= self.end {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the wheels turned at some moment of a time.
    fn turned(&self, from: f64, until: f64) -> bool {
        let [from, until] = [from, until].map(Duration::from_secs_f64);
        let last = self
            .driven
            .iter()
            .rfind(|(at, _)| *at <= from)
            .map_or(0.0, |(_, speed)| *speed);
        let within = self.driven.iter().filter(|(at, _)| (from..until).contains(at));
        last != 0.0 || within.clone().any(|(_, speed)| *speed != 0.0)
    }

    fn statuses(&self) -> impl Iterator<Item = &Status> {
        self.said.iter().filter_map(|received| match &received.packet {
            Packet::Status(status) => Some(status),
            _ => None,
        })
    }
}

#[derive(Clone)]
struct Bench(Arc<Mutex<World>>, Profile);

impl Bench {
    fn lock(&self) -> MutexGuard<'_, World> {
        self.0.lock().unwrap()
    }
}

impl Vehicle for Bench {
    fn profile(&self) -> &Profile {
        &self.1
    }

    fn now(&self) -> Duration {
        self.lock().now
    }

    fn look(&mut self) -> std::result::Result<Moment, Trouble> {
        let mut world = self.lock();
        let until = world.now + Duration::from_millis(20);
        world.pass_until(until);
        if !(world.answers)(world.now) {
            return Err(Trouble::Unreadable("no answer".into()));
        }
        Ok(Moment {
            at: world.now,
            age: Duration::ZERO,
            readings: [[0.0; 8], [3000.0; 8]].concat(),
            travel: None,
        })
    }

    fn drive(&mut self, [left, _]: [f64; 2]) -> std::result::Result<(), Trouble> {
        let mut world = self.lock();
        let now = world.now;
        world.driven.push((now, left));
        Ok(())
    }

    fn keep_until(&mut self, until: Duration) -> std::result::Result<(), Trouble> {
        self.lock().pass_until(until);
        Ok(())
    }

    fn stop(&mut self) -> std::result::Result<(), Trouble> {
        self.drive([0.0; 2])
    }

    fn recover(&mut self) -> std::result::Result<(), Trouble> {
        Ok(())
    }
}

impl Air for Bench {
    fn send(&mut self, datagram: &[u8]) {
        let mut world = self.lock();
        let (now, second) = (world.now, None);
        let received = world.operator.open(datagram, now, second).unwrap();
        world.said.push(received);
    }

    fn receive(&mut self) -> Option<(Channel, Vec<u8>)> {
        self.lock().coming.pop_front()
    }
}

/// A daemon's files, in a directory that is removed at the end.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-control-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("key"), format!("{KEY}\n")).unwrap();
        fs::set_permissions(path.join("key"), fs::Permissions::from_mode(0o600)).unwrap();
        Self(path)
    }

    /// Robot 1 of two, for three minutes.
    fn settings(&self) -> Settings {
        let mut foragers = Foragers {
            case: Case::Over,
            minutes: 3,
            ..Foragers::default()
        };
        foragers.world.robots = 2;
        Settings {
            plan: Plan {
                settings: foragers,
                kind: Kind::Evolved,
                number: 0,
                seed: 5,
            },
            experiment: blake3::hash(b"experiment"),
            robot: 1,
            wire: match "serial:/dev/null".parse() {
                Ok(oneiro_robots::address::Address::Wire(wire)) => wire,
                _ => unreachable!(),
            },
            directory: self.0.join("state"),
            key: self.0.join("key"),
            radio: RadioSettings {
                listen: String::new(),
                peers: Vec::new(),
                contact: oneiro_lab::exchange::contact::Contact::Tracker,
            },
            tracker: Tracker::default(),
            beacon: Beacon::default(),
            evolution: Evolution::default(),
            guard: Vec::new(),
        }
    }

    /// What happens until `end`, with what surrounds the daemon. `starts` counts its starts and the operator's.
    fn run_daemon(&self, end: u64, starts: u32, change: impl FnOnce(&mut World)) -> (Result, Bench) {
        let settings = self.settings();
        let stop = Arc::new(AtomicBool::new(false));
        let key = Secret::read(&settings.key).unwrap();
        let limits = settings.plan.settings.limits();
        let mut world = World {
            now: Duration::ZERO,
            operator: Radio::new(OPERATOR, limits, &key, *settings.experiment.as_bytes(), starts),
            operates: |_| true,
            sees: |_| true,
            answers: |_| true,
            brought: |_| 0,
            lies: |_| Vec::new(),
            coming: VecDeque::new(),
            driven: Vec::new(),
            said: Vec::new(),
            end: Duration::from_secs(end),
            stop: Arc::clone(&stop),
        };
        change(&mut world);
        let profile = Profile {
            robot: "bench".into(),
            firmware: "1".into(),
            sensors: Vec::new(),
            greatest_mm_s: 128.0,
            unit_mm_s: 0.128,
            base_mm: 53.0,
            has_odometers: false,
        };
        let bench = Bench(Arc::new(Mutex::new(world)), profile);
        let files = Files::open(&settings).unwrap();
        let daemon = Daemon::new(&settings, files, Box::new(bench.clone()), Box::new(bench.clone()), true).unwrap();
        (daemon.live(&stop), bench)
    }

    fn log(&self) -> String {
        fs::read_to_string(self.0.join("state/log.jsonl")).unwrap()
    }

    fn intervals(&self) -> Vec<String> {
        let table = fs::read_to_string(self.0.join("state/intervals.csv")).unwrap();
        table.lines().skip(1).map(Into::into).collect()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

fn seconds(time: Duration) -> u64 {
    time.as_secs()
}

/// The wheels stand still before the robot is switched on, turn while the beacon and the tracker's sightings come, and
/// stop within half a second of the last of either. They turn again when it is back, and when the robot answers again.
#[test]
fn wheels_turn_only_while_the_operator_and_the_tracker_are_there() {
    let place = Place::new("wheels");
    let (outcome, bench) = place.run_daemon(60, 1, |world| {
        world.operates = |now| !(20..25).contains(&seconds(now));
        world.sees = |now| !(30..35).contains(&seconds(now));
        world.answers = |now| !(40..45).contains(&seconds(now));
    });
    assert_eq!(outcome.unwrap_err().code(), 75);
    let world = bench.lock();
    let on = place.settings().plan.clocks()[1].offset;
    assert!(!world.turned(0.0, f64::from(2 + on)));
    for (from, until) in [(10.0, 19.9), (26.0, 29.9), (36.0, 39.9), (46.0, 59.9)] {
        assert!(world.turned(from, until), "{from}");
    }
    for (from, until) in [(20.5, 25.0), (30.5, 35.0), (40.5, 45.0)] {
        assert!(!world.turned(from, until), "{from}");
    }
    let (last, speed) = *world.driven.last().unwrap();
    assert_eq!((seconds(last), speed), (60, 0.0));
    assert!(world.statuses().all(|status| status.start == START_NUMBER));
    let problems: Vec<u32> = world.statuses().map(|status| status.problems).collect();
    for problem in [Problems::BEACON, Problems::TRACKER, Problems::ROBOT] {
        assert!(problems.contains(&problem), "{problem}");
    }
    drop(world);
    for word in ["\"standing\"", "\"troubled\"", "no answer", "\"event\":\"end\""] {
        assert!(place.log().contains(word), "{word}");
    }
}

/// A tracker's lines that can't be true cost little, earn nothing, and are counted: the operator sees how many.
#[test]
fn lies_of_a_tracker_are_ignored_and_counted() {
    let place = Place::new("lies");
    let (_, bench) = place.run_daemon(80, 1, |world| {
        world.lies = |now| {
            let time = now.as_secs_f64() + 0.01;
            let line =
                |x: f64, more: &str| format!("{{\"id\":1,\"t\":{time},\"x\":{x},\"y\":20,\"heading\":0.5{more}}}");
            let food = |brought: u64| line(10.0, &format!(",\"carries\":true,\"brought\":{brought},\"heard\":[]"));
            match now.as_millis() / 100 % 5 {
                0 => vec![food(u32::MAX.into())],
                1 => vec![food(1_000_000)],
                2 => vec![line(1e4, "")],
                3 => vec![food(u64::MAX), line(f64::MAX, ""), "{".repeat(2000)],
                _ => vec!["\n".repeat(2000), ["{}"; 600].join("\n")],
            }
        };
        world.brought = |now| u32::from(seconds(now) >= 30);
    });
    let intervals = place.intervals();
    let row: Vec<&str> = intervals[0].split(',').collect();
    let (real, brought): (f32, u32) = (row[6].parse().unwrap(), row[7].parse().unwrap());
    assert!(brought == 1 && (30.0..40.0).contains(&real), "{row:?}");
    let world = bench.lock();
    assert!(world.statuses().all(|status| status.brought <= 1 && !status.carries));
    assert!(world.turned(70.0, 79.9), "they don't keep it from driving");
    let ignored: Vec<u32> = world.statuses().map(|status| status.ignored).collect();
    assert!(ignored.is_sorted() && ignored.last() > Some(&500), "{ignored:?}");
    drop(world);
    let log = place.log();
    let losses = log.lines().rfind(|line| line.contains("\"event\":\"losses\"")).unwrap();
    let losses: serde_json::Value = serde_json::from_str(losses).unwrap();
    for reason in ["tracker_impossible", "tracker_unreadable"] {
        assert!(losses[reason].as_u64() > Some(200), "{losses}");
    }
}

/// Its fitness is the food that it brings. After a stop it continues where its last interval ended, with unused
/// sequence numbers, and it ends when the experiment is over.
#[test]
fn it_goes_on_from_its_checkpoint() {
    let place = Place::new("goes-on");
    let brought: fn(Duration) -> u32 = |now| u32::from(seconds(now) >= 30);
    let (outcome, bench) = place.run_daemon(80, 1, |world| world.brought = brought);
    assert_eq!(outcome.unwrap_err().code(), 75);
    let first = place.intervals();
    assert_eq!(first.len(), 1, "{first:?}");
    let on = place.settings().plan.clocks()[1].offset;
    let worth: f32 = first[0].split(',').nth(6).unwrap().parse().unwrap();
    // It was brought in second 28 of the experiment.
    assert!((worth - (60 - (28 - on)) as f32).abs() < 0.01, "{worth}");
    let last = bench.lock().said.last().unwrap().sequence;

    // The daemon starts again when the experiment is in its second minute.
    let (outcome, bench) = place.run_daemon(200, 2, |world| world.brought = brought);
    outcome.unwrap();
    let intervals = place.intervals();
    assert_eq!(intervals[0], first[0]);
    assert!((2..=3).contains(&intervals.len()), "{intervals:?}");
    let world = bench.lock();
    assert!(world.said[0].sequence > last);
    let pairs: Vec<u32> = world
        .said
        .iter()
        .filter_map(|received| match received.packet {
            Packet::Pair { second, .. } => Some(second),
            _ => None,
        })
        .collect();
    assert!(pairs.len() > 100 && pairs.is_sorted_by(|a, b| a < b), "{pairs:?}");
}

/// A robot that can't save does not act: the wheels stop while nothing can be written, and turn again afterwards.
#[test]
fn nothing_is_lived_that_can_not_be_saved() {
    thread_local! {
        static STATE: RefCell<PathBuf> = RefCell::default();
    }
    let place = Place::new("disk");
    let state = place.settings().directory;
    STATE.set(state);
    // The directory is away while the first interval ends.
    let away: fn(Duration) -> bool = |now| {
        STATE.with_borrow(|state| {
            let other = state.with_extension("away");
            match seconds(now) {
                50..=79 if state.exists() => fs::rename(state, &other).unwrap(),
                80.. if other.exists() => fs::rename(&other, state).unwrap(),
                _ => {}
            }
        });
        true
    };
    let (_, bench) = place.run_daemon(100, 1, |world| world.operates = away);
    let world = bench.lock();
    assert!(world.turned(40.0, 60.0));
    assert!(!world.turned(69.0, 80.0));
    assert!(world.turned(83.0, 99.0));
    assert!(world.statuses().any(|status| status.problems == Problems::DISK));
    drop(world);
    assert_eq!(place.intervals().len(), 1);
}

/// A sender with another experiment or another version is refused by name.
#[test]
fn others_are_refused_by_name() {
    let place = Place::new("others");
    let (_, bench) = place.run_daemon(10, 1, |world| {
        let settings = place.settings();
        let key = Secret::read(&settings.key).unwrap();
        let limits = settings.plan.settings.limits();
        let mut other = Radio::new(0, limits, &key, [7; 32], 1);
        let hello = other.seal(&Packet::Hello {
            program: "0.9".into(),
            experiment: [7; 32],
            start: 0,
        });
        let mut version = other.seal(&Packet::Beacon {
            milliseconds: 0,
            go: true,
            start: 0,
        });
        version[4] = 9;
        world
            .coming
            .extend([hello, version].map(|datagram| (Channel::Radio, datagram)));
    });
    drop(bench);
    let log = place.log();
    assert!(
        log.contains("sender 0 runs another experiment, 0707070707070707, with program 0.9"),
        "{log}"
    );
    assert!(log.contains("has version 9 of datagrams; allowed: 2"), "{log}");
}
