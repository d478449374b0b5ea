//! A fleet's life: the operator waits for the robots, lets them live by the beacon until the experiment is over, and starts the daemons of
//! robots again that have fallen silent.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::file::Fleet;
use super::operator::{Beacon, Ears, Shared, Socket, Time};
use super::remote::Remote;
use super::service;
use crate::engine::disk;
use crate::exit::{Code, Failure, Result};
use crate::files;

/// How often the operator looks at what has come.
const GLANCE: Duration = Duration::from_millis(20);
/// A robot that has said nothing for this long is away.
pub(crate) const AWAY: Duration = Duration::from_secs(3);
/// A robot that has said nothing for this long has its daemon started again: a restart by systemd takes some seconds.
const SILENT: Duration = Duration::from_secs(15);
/// How often a daemon is started again in one silence, each time after twice the pause.
const ATTEMPTS: u32 = 5;

/// The operator's own record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// The experiment's time so far, ms.
    pub(crate) milliseconds: i64,
    /// How often the operator has begun: no number of a datagram is used twice.
    pub(crate) boots: u32,
}

impl Record {
    const FILE: &str = "operator.json";

    /// The record of this beginning, which is on disk before anything is said.
    ///
    /// # Errors
    /// Exit 5 if the record is damaged: without it, robots would take old numbers for replayed ones. Exit 6 if it can't be written.
    pub(crate) fn next(fleet: &Fleet) -> Result<Self> {
        std::fs::create_dir_all(&fleet.directory).map_err(|error| Failure::storage(&fleet.directory, &error))?;
        let path = fleet.directory.join(Self::FILE);
        let last = if path.exists() {
            let damaged = |error| Failure::corrupt(format_args!("{}: {error}", path.display()));
            serde_json::from_slice(&files::bytes(&path)?).map_err(damaged)?
        } else {
            Self::default()
        };
        let next = Self {
            boots: last.boots + 1,
            ..last
        };
        disk::write(&path, &disk::json(&next))?;
        disk::sync_directory(&fleet.directory)?;
        Ok(next)
    }

    fn save(self, fleet: &Fleet) -> Result {
        disk::note(&fleet.directory.join(Self::FILE), &disk::json(&self))
    }
}

/// How a fleet is to live.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Robots without which the experiment does not begin.
    pub(crate) min: usize,
    /// How long to wait for them.
    pub(crate) wait: Duration,
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The experiment is over.
    Over,
    /// Somebody stopped it at this time of the experiment, ms.
    Stopped(i64),
}

/// Lets a fleet live until the experiment is over or `stop` is set. `show` sees all that is known, with the experiment's time in ms, at each
/// glance; before the experiment's time runs it is `None`.
///
/// # Errors
/// Exit 4 if too few robots answer; those of `show` and of writing the record, after which robots stand.
pub(crate) fn live(
    fleet: &Arc<Fleet>,
    mut record: Record,
    voice: &Shared,
    options: Options,
    stop: &AtomicBool,
    mut show: impl FnMut(&Ears, Option<i64>) -> Result,
) -> Result<End> {
    let socket = Arc::new(Socket::open(fleet)?);
    let mut ears = Ears::new(fleet, Arc::clone(&socket), Arc::clone(voice));
    let began = Instant::now();
    while ears.present(AWAY) < options.min {
        ears.listen();
        show(&ears, None)?;
        if stop.load(Ordering::Relaxed) {
            return Ok(End::Stopped(record.milliseconds));
        }
        if began.elapsed() > options.wait {
            return Err(absent(&ears, options));
        }
        thread::sleep(GLANCE);
    }
    // Never back: robots may have lived on for a moment after the operator was lost.
    let time = Time::from(record.milliseconds.max(ears.farthest().unwrap_or(0)));
    let over = 1000 * i64::from(fleet.experiment.settings().seconds());
    let beacon = Beacon::begin(Arc::clone(&socket), Arc::clone(voice), time)?;
    let mut revivals = Revivals::default();
    let mut saved = record.milliseconds;
    let end = loop {
        ears.listen();
        beacon.renew();
        record.milliseconds = time.now();
        if record.milliseconds - saved >= 1000 {
            record.save(fleet)?;
            saved = record.milliseconds;
        }
        show(&ears, Some(record.milliseconds))?;
        if record.milliseconds >= over {
            break End::Over;
        }
        if stop.load(Ordering::Relaxed) {
            break End::Stopped(record.milliseconds);
        }
        revivals.look(fleet, &ears);
        thread::sleep(GLANCE);
    };
    beacon.end();
    record.save(fleet)?;
    // What they say to that.
    let until = Instant::now() + Duration::from_millis(1500);
    while Instant::now() < until {
        ears.listen();
        thread::sleep(GLANCE);
    }
    show(&ears, Some(record.milliseconds))?;
    Ok(end)
}

/// Says which robots keep the experiment from beginning.
fn absent(ears: &Ears, options: Options) -> Failure {
    let why = ears
        .robots
        .iter()
        .filter_map(|(number, known)| match (&known.refused, known.heard) {
            (Some(refused), _) => Some(format!("robot {number} {refused}")),
            (None, None) => Some(format!("robot {number} was not heard")),
            (None, Some(_)) => None,
        });
    let why: Vec<String> = why
        .chain(ears.refused.iter().map(|(reason, count)| format!("{count} x {reason}")))
        .collect();
    let (seconds, present) = (options.wait.as_secs(), ears.present(AWAY));
    Failure::of(
        Code::Device,
        format_args!(
            "after {seconds} s {present} robots are ready, and {} are needed (--min N begins with fewer): {}",
            options.min,
            why.join("; ")
        ),
    )
}

/// Daemons that are started again.
#[derive(Default)]
struct Revivals(BTreeMap<u32, Revival>);

/// Attempts in one silence of a robot.
struct Revival {
    attempts: u32,
    due: Instant,
    work: Option<JoinHandle<()>>,
}

impl Revivals {
    /// Starts the daemons again of robots that have been silent for long. A thread does it: `ssh` may take minutes.
    fn look(&mut self, fleet: &Arc<Fleet>, ears: &Ears) {
        for (&number, known) in &ears.robots {
            let silent = known.heard.is_none_or(|at| at.elapsed() > SILENT);
            if !silent || known.refused.is_some() {
                self.0.remove(&number);
                continue;
            }
            let now = Instant::now();
            let revival = self.0.entry(number).or_insert_with(|| Revival {
                attempts: 0,
                // A robot that was never there gets the time that one has that left.
                due: if known.heard.is_some() { now } else { now + SILENT },
                work: None,
            });
            let is_busy = revival.work.as_ref().is_some_and(|work| !work.is_finished());
            if revival.attempts < ATTEMPTS && now >= revival.due && !is_busy {
                revival.attempts += 1;
                revival.due = now + SILENT * 2_u32.pow(revival.attempts - 1);
                let fleet = Arc::clone(fleet);
                let work = thread::Builder::new().spawn(move || {
                    if let Some(robot) = fleet.robot(number) {
                        // Whether it worked shows by what the robot says, or doesn't.
                        let _ = Remote::of(&fleet, robot).run(&service::start_command(&fleet, robot));
                    }
                });
                revival.work = work.ok();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::UdpSocket;
    use std::sync::Mutex;

    use super::super::operator::{Said, Status, VERSION, Voice};
    use super::*;
    use crate::fleet::table;

    /// Datagrams as plain text, in place of sealed ones: `beacon MS GO`, `N hello VERSION HASH`, `N status MS`, `N pair`.
    struct Plain;

    impl Voice for Plain {
        fn beacon(&mut self, milliseconds: i64, go: bool) -> Vec<u8> {
            format!("beacon {milliseconds} {go}").into_bytes()
        }

        fn open(&mut self, datagram: &[u8], _: Duration) -> std::result::Result<(u32, Said), String> {
            let text = String::from_utf8_lossy(datagram).into_owned();
            let words: Vec<&str> = text.split(' ').collect();
            match words[..] {
                [robot, "hello", program, hash] => {
                    let experiment = *blake3::Hash::from_hex(hash).unwrap().as_bytes();
                    let program = program.to_owned();
                    Ok((robot.parse().unwrap(), Said::Hello { program, experiment }))
                }
                [robot, "status", ms] => Ok((
                    robot.parse().unwrap(),
                    Said::Status(Status {
                        milliseconds: ms.parse().unwrap(),
                        state: "lives".into(),
                        interval: 0,
                        simulator: 0.5,
                        real: 1.0,
                        simulated: 2.0,
                        controller: [0.1, 0.2],
                        brought: 3,
                        carries: false,
                        pose: [0.0; 3],
                        volts: None,
                        problems: Vec::new(),
                    }),
                )),
                [robot, "pair"] => Ok((robot.parse().unwrap(), Said::Else)),
                _ => Err("forged".into()),
            }
        }
    }

    /// A robot that hears the beacon: when, the experiment's time, and whether it may move.
    struct Robot {
        socket: UdpSocket,
        heard: Vec<(Instant, i64, bool)>,
    }

    impl Robot {
        fn listen(&mut self) {
            let mut room = [0; 100];
            while let Ok(length) = self.socket.recv(&mut room) {
                let text = String::from_utf8_lossy(&room[..length]).into_owned();
                let words: Vec<&str> = text.split(' ').collect();
                self.heard
                    .push((Instant::now(), words[1].parse().unwrap(), words[2] == "true"));
            }
        }
    }

    /// A fleet of two robots on loopback, and their sockets.
    fn fleet(name: &str) -> (Arc<Fleet>, [Robot; 2]) {
        let free = || {
            let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
            socket.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
            socket
        };
        let (operator, robots) = (free().local_addr().unwrap(), [free(), free()]);
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .canonicalize()
            .unwrap();
        let place = std::env::temp_dir().join(format!("oneiro-fleet-live-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&place);
        std::fs::create_dir_all(&place).unwrap();
        let mut text = format!(
            "experiment = \"{}/experiments/odowd2014-over.toml\"\nseed = 1\nkey = \"k\"\nbinary = \"b\"\noperator = \"{operator}\"\n",
            root.display()
        );
        for (number, robot) in robots.iter().enumerate() {
            let radio = robot.local_addr().unwrap();
            text += &format!(
                "[[robots]]\nnumber = {number}\nhost = \"h\"\nradio = \"{radio}\"\naddress = \"serial:/dev/x\"\n"
            );
        }
        std::fs::write(place.join("fleet.toml"), text).unwrap();
        let fleet = Fleet::read(&place.join("fleet.toml")).unwrap();
        let robot = |socket| Robot {
            socket,
            heard: Vec::new(),
        };
        (Arc::new(fleet), robots.map(robot))
    }

    fn voice() -> Shared {
        Arc::new(Mutex::new(Plain))
    }

    /// Robots may move while the operator's program lives, and no longer: not when it hangs, nor after its end.
    #[test]
    fn a_program_that_hangs_gives_no_leave_to_move() {
        let (fleet, [mut robot, _other]) = fleet("leave");
        let socket = Arc::new(Socket::open(&fleet).unwrap());
        let began = Instant::now();
        let beacon = Beacon::begin(socket, voice(), Time::from(5000)).unwrap();
        while began.elapsed() < Duration::from_millis(600) {
            beacon.renew();
            robot.listen();
        }
        beacon.renew();
        let renewed = Instant::now();
        // It hangs.
        while renewed.elapsed() < Duration::from_millis(1500) {
            robot.listen();
        }
        let last = robot.heard.iter().rfind(|(_, _, go)| *go).unwrap().1 - 5000;
        let leave = last - renewed.duration_since(began).as_millis() as i64;
        assert!((500..1100).contains(&leave), "{leave} ms");
        assert!(!robot.heard.last().unwrap().2);
        // Ten a second, but for what other tests take of the machine, and the experiment's time in each.
        assert!((8..=24).contains(&robot.heard.len()), "{}", robot.heard.len());
        assert!(robot.heard.is_sorted_by_key(|(_, milliseconds, _)| *milliseconds));
        for (at, milliseconds, _) in &robot.heard {
            assert!(*milliseconds - 5000 <= at.duration_since(began).as_millis() as i64);
        }
        beacon.renew();
        beacon.end();
        robot.listen();
        assert!(!robot.heard.last().unwrap().2);
        let count = robot.heard.len();
        thread::sleep(Duration::from_millis(250));
        robot.listen();
        assert_eq!(robot.heard.len(), count);
    }

    /// One robot has another version: it is named, and the fleet lives without it if it may. The time goes on where robots are, and at a
    /// stop the last word is to stand.
    #[test]
    fn a_fleet_lives_with_those_that_may_take_part() {
        let (fleet, mut robots) = fleet("live");
        let hash = blake3::Hash::from_bytes(fleet.hash()).to_hex();
        let speak = |robots: &[Robot; 2]| {
            for (robot, word) in robots.iter().zip([
                vec![
                    format!("0 hello {VERSION} {hash}"),
                    "0 status 61000".to_owned(),
                    "0 pair".to_owned(),
                ],
                vec![
                    format!("1 hello 0.0.1 {hash}"),
                    "junk".to_owned(),
                    "7 status 1".to_owned(),
                ],
            ]) {
                for word in word {
                    robot.socket.send_to(word.as_bytes(), fleet.operator).unwrap();
                }
            }
        };
        let stop = AtomicBool::new(false);
        let run = |robots: &mut [Robot; 2], min: usize| {
            let record = Record::next(&fleet).unwrap();
            let began = Instant::now();
            let options = Options {
                min,
                wait: Duration::from_millis(500),
            };
            live(&fleet, record, &voice(), options, &stop, |ears, time| {
                speak(robots);
                robots.iter_mut().for_each(Robot::listen);
                if time.is_some() && began.elapsed() > Duration::from_millis(900) {
                    assert_eq!(
                        ears.refused["forged"] > 0,
                        ears.refused["robot 7 is not in the fleet"] > 0
                    );
                    let text = table::text(ears, time);
                    assert!(
                        text.starts_with("1:0") && text.contains("food 3; 1 of 2 robots here"),
                        "{text}"
                    );
                    assert!(
                        text.contains("0      lives") && text.contains("1      refused"),
                        "{text}"
                    );
                    let json = table::json(ears, time);
                    assert_eq!(json["robots"][0]["status"]["brought"], 3);
                    assert_eq!(json["robots"][1]["state"], "refused");
                    stop.store(true, Ordering::Relaxed);
                }
                Ok(())
            })
        };
        let failure = run(&mut robots, 2).unwrap_err();
        assert_eq!(failure.code(), 4);
        let words = "after 0 s 1 robots are ready, and 2 are needed (--min N begins with fewer): robot 1 has oneiro 0.0.1, this is";
        assert!(failure.to_string().contains(words), "{failure}");
        assert!(robots[0].heard.is_empty(), "robots stand until enough are there");
        let began = Instant::now();
        let End::Stopped(at) = run(&mut robots, 1).unwrap() else {
            panic!("it was stopped")
        };
        assert!(
            (61_000..=61_000 + began.elapsed().as_millis() as i64).contains(&at),
            "{at}"
        );
        robots[0].listen();
        let heard = &robots[0].heard;
        assert!(heard.iter().any(|(_, _, go)| *go) && !heard.last().unwrap().2);
        assert!(
            heard.iter().all(|(_, milliseconds, _)| *milliseconds >= 61_000),
            "time never goes back"
        );
        // The next time, it goes on from there, with numbers of its own.
        let next = Record::next(&fleet).unwrap();
        assert!(next.boots == 3 && next.milliseconds >= at, "{next:?}");
    }
}
