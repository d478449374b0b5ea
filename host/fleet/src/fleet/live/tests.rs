use std::fmt::Write;
use std::net::UdpSocket;

use oneiro_lab::exchange::radio::key::Key;
use oneiro_lab::exchange::radio::{LONGEST, Packet, Radio, Status};

use super::super::operator::{Station, VERSION};
use super::super::table;
use super::*;

/// A robot that sends given messages, and records the beacon: when, the experiment's time, and whether it may move.
struct Robot {
    socket: UdpSocket,
    radio: Radio,
    operator: std::net::SocketAddr,
    heard: Vec<(Instant, i64, bool)>,
    /// The number of the operator's start that it has heard last.
    start: u64,
    /// All its messages.
    said: Vec<Vec<u8>>,
}

impl Robot {
    /// Robot `number` of an experiment with this hash.
    fn of(fleet: &Fleet, number: u16, experiment: [u8; 32], socket: UdpSocket) -> Self {
        let key = Key::read(&fleet.key).unwrap();
        let limits = fleet.experiment.settings().limits();
        Self {
            socket,
            radio: Radio::new(number, limits, &key, experiment, 1),
            operator: fleet.operator,
            heard: Vec::new(),
            start: 0,
            said: Vec::new(),
        }
    }

    fn listen(&mut self) {
        let mut room = [0; LONGEST];
        while let Ok(length) = self.socket.recv(&mut room) {
            let now = self.heard.first().map_or(Duration::ZERO, |(first, ..)| first.elapsed());
            let received = self.radio.open(&room[..length], now, None).unwrap();
            match received.packet {
                Packet::Call { start } => self.start = start,
                Packet::Beacon {
                    milliseconds,
                    go,
                    start,
                } => {
                    self.start = start;
                    self.heard.push((Instant::now(), milliseconds, go));
                }
                other => panic!("{other:?}"),
            }
        }
    }

    fn say(&mut self, packet: &Packet) {
        let datagram = self.radio.seal(packet);
        self.socket.send_to(&datagram, self.operator).unwrap();
        self.said.push(datagram);
    }

    fn hello(&mut self, program: &str, experiment: [u8; 32]) {
        let program = program.to_owned();
        let start = self.start;
        self.say(&Packet::Hello {
            program,
            experiment,
            start,
        });
    }

    fn status(&mut self, milliseconds: i64) {
        self.say(&Packet::Status(Status {
            start: self.start,
            milliseconds,
            state: 4,
            interval: 1,
            simulator: 0.5,
            real: 1.0,
            simulated: -1.0,
            controller: [0.1, 0.2],
            brought: 3,
            carries: true,
            pose: [1.5, -2.0, 0.25],
            volts: -1.0,
            problems: 0b101,
            ignored: 12,
        }));
    }
}

fn loopback() -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    socket
}

/// A fleet of two robots on loopback, and their sockets.
pub(in crate::fleet) fn fleet(name: &str) -> (Arc<Fleet>, [UdpSocket; 2]) {
    let (operator, robots) = (loopback().local_addr().unwrap(), [loopback(), loopback()]);
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap();
    let place = std::env::temp_dir().join(format!("oneiro-fleet-live-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&place);
    std::fs::create_dir_all(&place).unwrap();
    Key::create(&place.join("key")).unwrap();
    let mut text = format!(
        "experiment = \"{}/experiments/odowd2014-over.toml\"\nseed = 1\nkey = \"key\"\nbinary = \"b\"\noperator = \"{operator}\"\n",
        root.display()
    );
    for (number, robot) in robots.iter().enumerate() {
        let radio = robot.local_addr().unwrap();
        let table = "[[robots]]\nhost = \"h\"\naddress = \"serial:/dev/x\"";
        writeln!(text, "{table}\nnumber = {number}\nradio = \"{radio}\"").unwrap();
    }
    std::fs::write(place.join("fleet.toml"), text).unwrap();
    (Arc::new(Fleet::read(&place.join("fleet.toml")).unwrap()), robots)
}

/// A start of the operator: its record and its radio.
fn station(fleet: &Fleet) -> (Record, Arc<Station>) {
    let record = Record::next(fleet).unwrap();
    let key = Key::read(&fleet.key).unwrap();
    let station = Station::new(fleet, &key, &record).unwrap();
    (record, Arc::new(station))
}

/// Robots may move while the operator's program runs, and no longer: not when it hangs, nor after its end.
#[test]
fn a_program_that_hangs_gives_no_leave_to_move() {
    let (fleet, [first, _other]) = fleet("leave");
    let mut robot = Robot::of(&fleet, 0, fleet.hash(), first);
    let socket = Arc::new(Socket::open(&fleet).unwrap());
    let began = Instant::now();
    let beacon = Beacon::begin(socket, station(&fleet).1, Time::from(5000)).unwrap();
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
    // About ten a second, as other tests also use the machine, and the experiment's time in each.
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

/// One robot has another version: it is named, and the fleet runs without it if it may. Robots' time goes on, and at a
/// stop the last message is to stand still.
#[test]
fn a_fleet_lives_with_those_that_may_take_part() {
    let (fleet, [first, second]) = fleet("live");
    let hash = fleet.hash();
    let mut robots = [Robot::of(&fleet, 0, hash, first), Robot::of(&fleet, 1, hash, second)];
    let mut stranger = Robot::of(&fleet, 7, hash, loopback());
    let stop = AtomicBool::new(false);
    let mut run = |min: usize| {
        let (record, station) = station(&fleet);
        let socket = Arc::new(Socket::open(&fleet).unwrap());
        let options = Options {
            min,
            wait: Duration::from_millis(500),
        };
        let began = Instant::now();
        let mut spoken = 0;
        live(&fleet, record, (&socket, &station), options, &stop, |ears, time| {
            robots.iter_mut().for_each(Robot::listen);
            if began.elapsed() >= Duration::from_millis(300) * spoken {
                spoken += 1;
                robots[0].hello(VERSION, hash);
                robots[0].status(61_000);
                robots[1].hello("0.0.1", hash);
                stranger.status(99_000);
                let mut forged = robots[0].radio.seal(&Packet::Beacon {
                    milliseconds: 0,
                    go: true,
                    start: 0,
                });
                *forged.last_mut().unwrap() ^= 1;
                robots[0].socket.send_to(&forged, fleet.operator).unwrap();
            }
            if time.is_some() && began.elapsed() > Duration::from_millis(900) {
                assert!(
                    ears.refused["forged"] > 0 && ears.refused["not_in_the_fleet"] > 0,
                    "{:?}",
                    ears.refused
                );
                let text = table::text(ears, time);
                assert!(
                    text.starts_with("1:0") && text.contains("food 3; 1 of 2 robots here, "),
                    "{text}"
                );
                assert!(
                    text.contains("0      troubled") && text.contains("tracker, robot"),
                    "{text}"
                );
                assert!(
                    text.contains("1      refused") && text.contains("has oneiro 0.0.1, and this is"),
                    "{text}"
                );
                let json = table::json(ears, time);
                assert_eq!(json["robots"][0]["status"]["brought"], 3);
                assert_eq!(json["robots"][0]["status"]["ignored"], 12);
                assert_eq!(json["robots"][0]["status"]["volts"], serde_json::Value::Null);
                assert_eq!(json["robots"][1]["state"], "refused");
                stop.store(true, Ordering::Relaxed);
            }
            Ok(())
        })
    };
    let failure = run(2).unwrap_err();
    assert_eq!(failure.code(), 4);
    let words = "1 robot is ready, and 2 are needed (--min N begins with fewer): robot 1 has oneiro 0.0.1, and this is";
    assert!(failure.to_string().contains(words), "{failure}");
    let began = Instant::now();
    let End::Stopped(at) = run(1).unwrap() else {
        panic!("it was stopped")
    };
    // Robot 7 is not in the fleet: its time does not count.
    let latest = 61_000 + began.elapsed().as_millis() as i64;
    assert!((61_000..=latest).contains(&at), "{at}");
    robots[0].listen();
    let heard = &robots[0].heard;
    assert!(heard.iter().any(|(_, _, go)| *go) && !heard.last().unwrap().2);
    assert!(
        heard.iter().all(|(_, milliseconds, _)| *milliseconds >= 61_000),
        "time never goes back"
    );
    // The next record continues from there, with new numbers.
    let next = Record::next(&fleet).unwrap();
    assert!(next.boots == 3 && next.milliseconds >= at, "{next:?}");
}

/// A robot with another experiment and the same key is named, and takes no part.
#[test]
fn a_robot_of_another_experiment_is_refused_by_name() {
    let (fleet, [first, _second]) = fleet("other");
    let other = [7; 32];
    let mut robot = Robot::of(&fleet, 0, other, first);
    let socket = Arc::new(Socket::open(&fleet).unwrap());
    let mut ears = Ears::new(&fleet, socket, station(&fleet).1);
    robot.hello(VERSION, other);
    hear_until(&mut ears, |ears| !ears.refused.is_empty());
    assert_eq!(ears.present(), 0);
    let refused = ears.robots[&0].refusal().unwrap().to_owned();
    assert!(
        refused.contains("runs another experiment, 0707070707070707, with program"),
        "{refused}"
    );
}

/// Lets ears hear until something is so, for 5 s at most.
#[track_caller]
fn hear_until(ears: &mut Ears, is_so: impl Fn(&Ears) -> bool) {
    let until = Instant::now() + Duration::from_secs(5);
    while !is_so(ears) {
        assert!(Instant::now() < until, "{:?} {:?}", ears.robots, ears.refused);
        ears.listen();
        thread::sleep(GLANCE);
    }
}

/// An attacker who records all of a fleet's messages in one start, and sends them again at the next one, shows no
/// robot: neither with those that the operator has taken, nor with others.
#[test]
fn what_was_recorded_before_a_start_shows_no_robot() {
    let (fleet, [first, second]) = fleet("replayed");
    let hash = fleet.hash();
    let mut robots = [Robot::of(&fleet, 0, hash, first), Robot::of(&fleet, 1, hash, second)];
    let stop = AtomicBool::new(false);
    let options = Options {
        min: 2,
        wait: Duration::from_millis(1500),
    };
    let (record, yesterday) = station(&fleet);
    let socket = Arc::new(Socket::open(&fleet).unwrap());
    let began = Instant::now();
    let mut spoken = 0;
    let end = live(&fleet, record, (&socket, &yesterday), options, &stop, |_, time| {
        robots.iter_mut().for_each(Robot::listen);
        if began.elapsed() >= Duration::from_millis(100) * spoken {
            spoken += 1;
            for robot in &mut robots {
                robot.hello(VERSION, hash);
                robot.status(1000);
            }
        }
        if time.is_some_and(|time| time > 600) {
            stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    });
    assert!(matches!(end, Ok(End::Stopped(_))));
    // Datagrams that came after the operator had stopped.
    for robot in &mut robots {
        robot.listen();
        robot.status(70_000);
    }
    drop(socket);
    let recorded: Vec<Vec<u8>> = robots.iter().flat_map(|robot| robot.said.clone()).collect();
    assert!(recorded.len() > 12, "{}", recorded.len());
    let beacons = robots.each_ref().map(|robot| robot.heard.len());

    let mut shown = Vec::new();
    for has_windows in [true, false] {
        let (mut record, mut station) = station(&fleet);
        assert!(record.windows != Windows::default() && record.milliseconds < 60_000);
        if !has_windows {
            record.windows = Windows::default();
            station = Arc::new(Station::new(&fleet, &Key::read(&fleet.key).unwrap(), &record).unwrap());
        }
        let socket = Arc::new(Socket::open(&fleet).unwrap());
        let (mut sent, mut old) = (recorded.iter().cycle(), 0);
        let failure = live(
            &fleet,
            record,
            (&socket, &station),
            options,
            &AtomicBool::new(false),
            |ears, time| {
                for datagram in sent.by_ref().take(20) {
                    robots[0].socket.send_to(datagram, fleet.operator).unwrap();
                }
                assert_eq!((ears.present(), time, ears.farthest()), (0, None, None));
                old = ears.refused.get("of_another_start").copied().unwrap_or_default();
                Ok(())
            },
        );
        shown.push(old);
        let failure = failure.unwrap_err();
        let words = if has_windows {
            "robot 0 sends numbers that were accepted before: old datagrams are replayed"
        } else {
            "robot 1 sends, but does not answer this start: it does not receive this machine, or old datagrams are \
             replayed"
        };
        assert!(failure.code() == 4 && failure.to_string().contains(words), "{failure}");
    }
    // With its windows the operator takes none a second time: only what it had not heard any more, six datagrams, is of another start.
    assert!((1..=6).contains(&shown[0]) && shown[1] > shown[0], "{shown:?}");
    robots.iter_mut().for_each(Robot::listen);
    assert_eq!(
        robots.each_ref().map(|robot| robot.heard.len()),
        beacons,
        "no beacon was sent"
    );
}

/// Old datagrams, and those without a valid key, are no reason to refuse a robot that answers this start.
#[test]
fn who_answers_is_not_refused_by_what_others_say() {
    let (fleet, [first, _second]) = fleet("doubts");
    let hash = fleet.hash();
    let socket = Arc::new(Socket::open(&fleet).unwrap());
    let mut ears = Ears::new(&fleet, socket, station(&fleet).1);
    let mut robot = Robot::of(&fleet, 0, hash, first);
    // A robot's own address shows which it is.
    let older = [&b"1ONE"[..], &[1, 0], &[0; 60]].concat();
    robot.socket.send_to(&older, fleet.operator).unwrap();
    hear_until(&mut ears, |ears| ears.robots[&0].refusal().is_some());
    let refused = ears.robots[&0].refusal().unwrap().to_owned();
    assert_eq!(
        refused,
        "sends datagrams of version 1, and this machine of version 2: deploy again"
    );
    assert_eq!(table::json(&ears, None)["robots"][0]["state"], "refused");
    ears.call();
    while robot.start == 0 {
        robot.listen();
    }
    robot.status(0);
    hear_until(&mut ears, |ears| ears.present() == 1);
    let mut elsewhere = Robot::of(&fleet, 0, [7; 32], loopback());
    elsewhere.hello(VERSION, [7; 32]);
    robot.socket.send_to(&older, fleet.operator).unwrap();
    hear_until(&mut ears, |ears| {
        ears.refused.get("other_experiment") == Some(&1) && ears.refused["other_version"] == 2
    });
    assert_eq!(ears.present(), 1);
}

/// A record of an earlier version, which has no windows, is continued.
#[test]
fn a_record_of_an_earlier_version_is_read() {
    let (fleet, _) = fleet("earlier");
    std::fs::create_dir_all(&fleet.directory).unwrap();
    std::fs::write(
        fleet.directory.join(Record::FILE),
        r#"{"milliseconds": 1234, "boots": 7}"#,
    )
    .unwrap();
    let next = Record::next(&fleet).unwrap();
    assert_eq!(
        (next.milliseconds, next.boots, next.windows),
        (1234, 8, Windows::default())
    );
    std::fs::write(
        fleet.directory.join(Record::FILE),
        r#"{"milliseconds": 1, "boots": 4294967295}"#,
    )
    .unwrap();
    assert_eq!(Record::next(&fleet).unwrap_err().code(), 5);
}

/// A record that is damaged is none to begin from: its numbers would be used again.
#[test]
fn a_damaged_record_is_refused() {
    let (fleet, _) = fleet("record");
    assert_eq!(Record::next(&fleet).unwrap().boots, 1);
    std::fs::write(fleet.directory.join(Record::FILE), "{").unwrap();
    assert_eq!(Record::next(&fleet).unwrap_err().code(), 5);
}

/// A log of a robot's computer may have any number of starts: so many are aligned, the others are left out.
#[test]
fn a_log_of_endless_starts_is_cut_short() {
    let (fleet, _) = fleet("starts");
    let directory = fleet.collected(0);
    std::fs::create_dir_all(&directory).unwrap();
    let line = |boot: u32| format!("{{\"at_ms\":1,\"boot\":{boot},\"event\":\"start\"}}\n");
    let text: String = (0..10_000).map(line).collect();
    std::fs::write(directory.join("log.jsonl"), text).unwrap();
    let merged = super::super::collect::merge(&fleet, &[0]).unwrap();
    assert_eq!((merged.lines, merged.clocks.len()), (4096, 4096));
    let words = "5904 lines of logs were left out: daemons have started more than 4096 times";
    assert!(
        merged.warnings.iter().any(|warning| warning == words),
        "{:?}",
        merged.warnings.last()
    );
}
