use std::fmt::Write;
use std::net::UdpSocket;

use super::super::operator::{self, VERSION};
use super::super::table;
use super::*;
use crate::exchange::radio::key::Key;
use crate::exchange::radio::{LONGEST, Packet, Radio, Status};

/// A robot that says what it is told to, and hears the beacon: when, the experiment's time, and whether it may move.
struct Robot {
    socket: UdpSocket,
    radio: Radio,
    operator: std::net::SocketAddr,
    heard: Vec<(Instant, i64, bool)>,
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
        }
    }

    fn listen(&mut self) {
        let mut room = [0; LONGEST];
        while let Ok(length) = self.socket.recv(&mut room) {
            let now = self.heard.first().map_or(Duration::ZERO, |(first, ..)| first.elapsed());
            let received = self.radio.open(&room[..length], now, None).unwrap();
            let Packet::Beacon { milliseconds, go } = received.packet else {
                panic!("{received:?}")
            };
            self.heard.push((Instant::now(), milliseconds, go));
        }
    }

    fn say(&mut self, packet: &Packet) {
        let datagram = self.radio.seal(packet);
        self.socket.send_to(&datagram, self.operator).unwrap();
    }

    fn hello(&mut self, program: &str, experiment: [u8; 32]) {
        let program = program.to_owned();
        self.say(&Packet::Hello { program, experiment });
    }

    fn status(&mut self, milliseconds: i64) {
        self.say(&Packet::Status(Status {
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
        }));
    }
}

fn socket() -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    socket
}

/// A fleet of two robots on loopback, and their sockets.
pub(in crate::fleet) fn fleet(name: &str) -> (Arc<Fleet>, [UdpSocket; 2]) {
    let (operator, robots) = (socket().local_addr().unwrap(), [socket(), socket()]);
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
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

/// Robots may move while the operator's program lives, and no longer: not when it hangs, nor after its end.
#[test]
fn a_program_that_hangs_gives_no_leave_to_move() {
    let (fleet, [own, _other]) = fleet("leave");
    let mut robot = Robot::of(&fleet, 0, fleet.hash(), own);
    let socket = Arc::new(Socket::open(&fleet).unwrap());
    let began = Instant::now();
    let beacon = Beacon::begin(socket, operator::radio(&fleet, 1).unwrap(), Time::from(5000)).unwrap();
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
    let (fleet, [first, second]) = fleet("live");
    let hash = fleet.hash();
    let mut robots = [Robot::of(&fleet, 0, hash, first), Robot::of(&fleet, 1, hash, second)];
    let mut stranger = Robot::of(&fleet, 7, hash, socket());
    let stop = AtomicBool::new(false);
    let mut run = |min: usize| {
        let record = Record::next(&fleet).unwrap();
        let radio = operator::radio(&fleet, record.boots).unwrap();
        let options = Options {
            min,
            wait: Duration::from_millis(500),
        };
        let began = Instant::now();
        let mut spoken = 0;
        live(&fleet, record, &radio, options, &stop, |ears, time| {
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
    // The next time, it goes on from there, with numbers of its own.
    let next = Record::next(&fleet).unwrap();
    assert!(next.boots == 3 && next.milliseconds >= at, "{next:?}");
}

/// A robot that lives another experiment with the same key is named, and takes no part.
#[test]
fn a_robot_of_another_experiment_is_refused_by_name() {
    let (fleet, [first, _second]) = fleet("other");
    let other = [7; 32];
    let mut robot = Robot::of(&fleet, 0, other, first);
    let socket = Arc::new(Socket::open(&fleet).unwrap());
    let mut ears = Ears::new(&fleet, socket, operator::radio(&fleet, 1).unwrap());
    robot.hello(VERSION, other);
    let until = Instant::now() + Duration::from_secs(5);
    while ears.refused.is_empty() && Instant::now() < until {
        ears.listen();
        thread::sleep(GLANCE);
    }
    assert_eq!(ears.present(AWAY), 0);
    let refused = ears.robots[&0].refused.clone().unwrap();
    assert!(
        refused.contains("lives another experiment, 0707070707070707, with program"),
        "{refused}"
    );
}

/// A record that is damaged is none to begin from: its numbers would be used again.
#[test]
fn a_damaged_record_is_refused() {
    let (fleet, _) = fleet("record");
    assert_eq!(Record::next(&fleet).unwrap().boots, 1);
    std::fs::write(fleet.directory.join(Record::FILE), "{").unwrap();
    assert_eq!(Record::next(&fleet).unwrap_err().code(), 5);
}
