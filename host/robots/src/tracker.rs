//! A tracker: a program with a camera that sends robots' places, one line of JSON for each sighting, over UDP:
//! `{"id":1,"t":12.3,"x":350.0,"y":200.0,"heading":0.25}`, with the tracker's time in s, mm, and turns
//! counter-clockwise from the x axis. For a forager, a line also has `"carries":true,"brought":4,"heard":[0,7]`:
//! whether the robot carries virtual food, how many items it has brought to the nest since the experiment began, and
//! the robots that it can hear now.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::UdpSocket;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::Duration;

use oneiro_base::exit::Failure;
use serde::{Deserialize, Deserializer};

use super::link::wall;

/// Default age of a tracker's last sighting at which the robot counts as lost, ms.
pub const AGE_MS: u64 = 300;
/// What it may be, ms.
pub const AGES_MS: RangeInclusive<u64> = 50..=2000;

/// Where a tracker's sightings arrive, and what counts.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Address to listen at, such as `0.0.0.0:5005`.
    pub listen: String,
    /// The robot's number.
    pub id: u64,
    /// Age of the last sighting from which the robot counts as lost.
    pub limit: Duration,
}

impl Values {
    /// Parses `udp:HOST:PORT#ID`; without `#ID` the robot is number 0.
    ///
    /// # Errors
    /// What is allowed.
    pub fn parse(text: &str, limit: Duration) -> Result<Self, String> {
        let refused = || "allowed: udp:HOST:PORT or udp:HOST:PORT#ID, such as udp:0.0.0.0:5005#1".to_owned();
        let rest = text.strip_prefix("udp:").ok_or_else(refused)?;
        let (listen, id) = match rest.split_once('#') {
            Some((listen, id)) => (listen, id.parse().map_err(|_| refused())?),
            None => (rest, 0),
        };
        match listen.rsplit_once(':') {
            Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => Ok(Self {
                listen: listen.into(),
                id,
                limit,
            }),
            _ => Err(refused()),
        }
    }
}

/// A line of a tracker. Other keys are ignored.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Sighting {
    id: u64,
    t: f64,
    x: f64,
    y: f64,
    heading: f64,
    /// Whether the robot carries virtual food, where there is any.
    #[serde(default)]
    pub carries: Option<bool>,
    /// Items of it that the robot has brought to the nest since the experiment began.
    #[serde(default)]
    pub brought: Option<u32>,
    /// Robots that it can hear, a bit each, if the tracker reports it.
    #[serde(default, deserialize_with = "mask")]
    pub heard: Option<u128>,
}

/// A list of robots' numbers as bits; others than 0 to 127 are left out.
fn mask<'de, D: Deserializer<'de>>(list: D) -> Result<Option<u128>, D::Error> {
    let robots = Option::<Vec<u64>>::deserialize(list)?;
    let bit = |robot: u64| 1_u128.checked_shl(robot.try_into().ok()?);
    Ok(robots.map(|robots| robots.into_iter().filter_map(bit).fold(0, |mask, bit| mask | bit)))
}

impl Sighting {
    /// Farthest from the origin, mm: a hundred metres.
    const FARTHEST: f64 = 1e5;

    /// Whether its numbers are of a robot in a room.
    fn is_in_range(&self) -> bool {
        let is_near = |part: f64| part.abs() <= Self::FARTHEST;
        [self.t, self.heading].into_iter().all(f64::is_finite) && is_near(self.x) && is_near(self.y)
    }

    /// x and y in mm, heading in turns, 0 to 1.
    pub fn pose(&self) -> [f64; 3] {
        [self.x, self.y, self.heading.rem_euclid(1.0)]
    }
}

/// The lines of a datagram.
pub fn lines(datagram: &[u8]) -> impl Iterator<Item = &[u8]> {
    datagram.split(|byte| *byte == b'\n')
}

/// A place where the robot was seen, when, and by how many sightings in a row.
#[derive(Clone, Copy, Debug)]
struct Place {
    sighting: Sighting,
    at: Duration,
    sightings: u32,
}

/// How many of a tracker's lines were ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ignored {
    /// They are no sightings, or have numbers that none has.
    pub unreadable: u64,
    /// They are not newer than the last one.
    pub late: u64,
    /// The robot can't have got there, or can't have brought so much, since the last one.
    pub(crate) impossible: u64,
    /// More came than are looked at in the time.
    pub too_many: u64,
}

impl Ignored {
    /// Each reason and its count.
    pub fn counts(self) -> [(&'static str, u64); 4] {
        [
            ("tracker_unreadable", self.unreadable),
            ("tracker_late", self.late),
            ("tracker_impossible", self.impossible),
            ("tracker_too_many", self.too_many),
        ]
    }
}

/// Maximum number of lines read: as many in 100 ms as a camera sends of ten robots in ten times as long. So a flood
/// takes little of the reader's time.
#[derive(Debug, Default)]
pub struct Budget {
    ends: Duration,
    left: u32,
}

impl Budget {
    const LINES: u32 = 1000;
    const TIME: Duration = Duration::from_millis(100);

    /// Whether one more line is looked at now.
    pub fn take(&mut self, now: Duration) -> bool {
        if now >= self.ends {
            (self.ends, self.left) = (now + Self::TIME, Self::LINES);
        }
        let has_any = self.left > 0;
        self.left -= u32::from(has_any);
        has_any
    }
}

/// What a robot's sightings were.
#[derive(Debug)]
pub struct Seen {
    id: u64,
    /// Maximum speed of the robot, mm/s.
    speed: f64,
    /// Age of the last sighting from which the robot counts as lost.
    limit: Duration,
    /// Where it is.
    last: Option<Place>,
    /// Where else it was seen, which may be a mistake.
    other: Option<Place>,
    ignored: Ignored,
}

impl Seen {
    /// Maximum distance between two sightings by noise and the rounding of times, in addition to the robot's drive, mm.
    const NOISE: f64 = 20.0;
    /// A time that goes back by more than this is that of a tracker that has started again, s.
    const RESTART: f64 = 1.0;
    /// Sightings in a row, each within reach of the one before, that show where a robot is of which that was not known.
    const CERTAIN: u32 = 3;

    /// A robot by its number that drives no faster than `speed`, mm/s, and counts as lost when its last sighting is older than
    /// `limit`.
    pub fn new(id: u64, speed: f64, limit: Duration) -> Self {
        Self {
            id,
            speed,
            limit,
            last: None,
            other: None,
            ignored: Ignored::default(),
        }
    }

    /// The lines that were ignored so far.
    pub fn ignored(&self) -> Ignored {
        self.ignored
    }

    /// Takes a line that has come now. Of lines that are no sightings of this robot nothing is taken, and nothing of sightings out
    /// of order, beyond all rooms, or farther from the last one than the robot can have driven since; these are counted. Where a
    /// robot is that was lost, or was never seen, several sightings in a row must show. Returns a sighting that shows where it is.
    pub fn take(&mut self, line: &[u8], now: Duration) -> Option<Sighting> {
        let sighting: Option<Sighting> = serde_json::from_slice(line).ok();
        let Some(sighting) = sighting.filter(Sighting::is_in_range) else {
            // A datagram's last line may have an end.
            self.ignored.unreadable += u64::from(!line.trim_ascii().is_empty());
            return None;
        };
        if sighting.id != self.id {
            return None;
        }
        let (t, newest) = (sighting.t, self.other.or(self.last).map(|place| place.sighting.t));
        if newest.is_some_and(|newest| t <= newest && t > newest - Self::RESTART) {
            self.ignored.late += 1;
            return None;
        }
        let known = self.last.filter(|place| !self.is_lost(place, now));
        if let Some(place) = known.filter(|place| self.follows(place, &sighting, now)) {
            (self.last, self.other) = (Some(place.seen_again(sighting, now)), None);
            return Some(sighting);
        }
        let other = match self.other.filter(|place| self.follows(place, &sighting, now)) {
            Some(place) => place.seen_again(sighting, now),
            None => Place {
                sighting,
                at: now,
                sightings: 1,
            },
        };
        if known.is_none() && other.sightings >= Self::CERTAIN {
            (self.last, self.other) = (Some(other), None);
            return Some(sighting);
        }
        self.ignored.impossible += u64::from(known.is_some());
        self.other = Some(other);
        None
    }

    /// Counts a sighting with impossible data, whose place may still be right.
    pub fn disbelieve(&mut self) {
        self.ignored.impossible += 1;
    }

    /// Counts a line that nobody looks at, since too many have come.
    pub fn skip(&mut self) {
        self.ignored.too_many += 1;
    }

    fn is_lost(&self, place: &Place, now: Duration) -> bool {
        now.saturating_sub(place.at) > self.limit
    }

    /// Whether the robot can have driven from a place to where it is seen now.
    fn follows(&self, place: &Place, sighting: &Sighting, now: Duration) -> bool {
        let reach = self.speed * now.saturating_sub(place.at).as_secs_f64() + Self::NOISE;
        (sighting.x - place.sighting.x).hypot(sighting.y - place.sighting.y) <= reach
    }

    /// Where the robot is, unless it is lost.
    pub fn place(&self, now: Duration) -> Option<Sighting> {
        let place = self.last.filter(|place| !self.is_lost(place, now))?;
        Some(place.sighting)
    }
}

impl Place {
    fn seen_again(self, sighting: Sighting, at: Duration) -> Self {
        Self {
            sighting,
            at,
            sightings: self.sightings.saturating_add(1),
        }
    }
}

/// Listens to a tracker until this is dropped.
#[derive(Debug)]
pub struct Tracker {
    seen: Arc<Mutex<Seen>>,
}

impl Tracker {
    /// Between two checks of whether to stop listening.
    const GLANCE: Duration = Duration::from_millis(100);

    /// Listens for a robot that drives no faster than this, mm/s. Robots that are seen by one tracker share its address.
    ///
    /// # Errors
    /// Exit 3: nobody can listen at the address.
    pub fn listen(values: &Values, speed: f64) -> Result<Self, Failure> {
        let seen = Arc::new(Mutex::new(Seen::new(values.id, speed, values.limit)));
        let mut ears = lock(&EARS);
        if let Some(robots) = ears.get_mut(&values.listen) {
            robots.push(Arc::downgrade(&seen));
            return Ok(Self { seen });
        }
        let refused = |error| Failure::input(format_args!("--tracker udp:{}: {error}", values.listen));
        let socket = UdpSocket::bind(&values.listen).map_err(refused)?;
        socket.set_read_timeout(Some(Self::GLANCE)).map_err(refused)?;
        ears.insert(values.listen.clone(), vec![Arc::downgrade(&seen)]);
        let listen = values.listen.clone();
        thread::spawn(move || hear(&socket, &listen));
        Ok(Self { seen })
    }

    /// Where the robot is: x and y in mm, heading in turns, 0 to 1. None if it is lost.
    pub fn pose(&self) -> Option<[f64; 3]> {
        Some(lock(&self.seen).place(wall())?.pose())
    }

    /// The robot drives no faster than this, mm/s.
    pub fn limit(&self, speed: f64) {
        lock(&self.seen).speed = speed;
    }

    /// The lines that were ignored so far.
    pub fn ignored(&self) -> Ignored {
        lock(&self.seen).ignored()
    }
}

/// Robots of which sightings are heard, by the address at which a thread listens for them.
static EARS: Mutex<BTreeMap<String, Vec<Weak<Mutex<Seen>>>>> = Mutex::new(BTreeMap::new());

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes what comes, until nobody needs it any more.
fn hear(socket: &UdpSocket, listen: &str) {
    let (mut buffer, mut budget) = ([0; 2048], Budget::default());
    while let Some(robots) = listening(listen) {
        match socket.recv(&mut buffer) {
            Ok(count) => {
                let mut is_taken = true;
                for line in lines(&buffer[..count]) {
                    let now = wall();
                    is_taken = budget.take(now);
                    for seen in &robots {
                        let mut seen = lock(seen);
                        if is_taken {
                            seen.take(line, now);
                        } else {
                            seen.skip();
                        }
                    }
                }
                if !is_taken {
                    // A flood must not take a whole processor: the system drops the rest.
                    thread::sleep(Budget::TIME / 10);
                }
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(_) => thread::sleep(Tracker::GLANCE),
        }
    }
}

/// The robots for which somebody still listens at an address; none if the last is gone, which frees the address.
fn listening(listen: &str) -> Option<Vec<Arc<Mutex<Seen>>>> {
    let mut ears = lock(&EARS);
    let robots: Vec<_> = ears.get(listen)?.iter().filter_map(Weak::upgrade).collect();
    if robots.is_empty() {
        ears.remove(listen);
        return None;
    }
    Some(robots)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Duration = Duration::from_millis(300);

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// Where a robot with number 1 is, which drives at up to 200 mm/s, at the time of the last line.
    fn seen(lines: &[(u64, &str)]) -> Option<[f64; 3]> {
        let mut seen = Seen::new(1, 200.0, LIMIT);
        for (at, line) in lines {
            seen.take(line.as_bytes(), ms(*at));
        }
        let place = seen.place(ms(lines.last()?.0))?;
        Some([place.x, place.y, place.heading])
    }

    /// It is seen until 200 ms.
    const FIRST: [(u64, &str); 3] = [
        (0, r#"{"id":1,"t":4.8,"x":100,"y":100,"heading":0.5}"#),
        (100, r#"{"id":1,"t":4.9,"x":101,"y":100,"heading":0.5}"#),
        (200, r#"{"id":1,"t":5.0,"x":100,"y":100,"heading":0.5}"#),
    ];

    #[test]
    fn only_sightings_that_can_be_the_robots_count() {
        for (line, counts) in [
            (
                r#"{"id":1,"t":5.1,"x":139.9,"y":100,"heading":0.5,"sharpness":3}"#,
                true,
            ),
            // 100 ms at 200 mm/s, and 20 mm of noise.
            (r#"{"id":1,"t":5.1,"x":140.1,"y":100,"heading":0.5}"#, false),
            (r#"{"id":1,"t":5.1,"x":130,"y":130,"heading":0.5}"#, false),
            (r#"{"id":2,"t":5.1,"x":101,"y":100,"heading":0.5}"#, false),
            (r#"{"id":1,"t":5.0,"x":101,"y":100,"heading":0.5}"#, false),
            (r#"{"id":1,"t":4.5,"x":101,"y":100,"heading":0.5}"#, false),
            // A tracker that has started again.
            (r#"{"id":1,"t":0.0,"x":101,"y":100,"heading":0.5}"#, true),
            (r#"{"id":1,"t":5.1,"x":null,"y":100,"heading":0.5}"#, false),
            (r#"{"id":1,"t":5.1,"x":NaN,"y":100,"heading":0.5}"#, false),
            (r#"{"id":1,"t":5.1,"x":1e300,"y":100,"heading":0.5}"#, false),
            (r#"{"id":1,"t":5.1,"x":101,"y":100}"#, false),
            ("", false),
        ] {
            let pose = seen(&[&FIRST[..], &[(300, line)]].concat()).unwrap();
            assert_eq!(pose != [100.0, 100.0, 0.5], counts, "{line}");
        }
        assert_eq!(seen(&[(0, "{}")]), None);
    }

    /// Ignored lines are counted by reason, and a flood is cut short.
    #[test]
    fn ignored_lines_are_counted() {
        let mut seen = Seen::new(1, 200.0, LIMIT);
        for (at, line) in FIRST {
            seen.take(line.as_bytes(), ms(at));
        }
        assert_eq!(seen.ignored(), Ignored::default());
        for line in [
            r#"{"id":1,"t":5.1,"x":999,"y":100,"heading":0.5}"#,
            r#"{"id":1,"t":5.0,"x":101,"y":100,"heading":0.5}"#,
            r#"{"id":1,"t":5.1,"x":1e300,"y":100,"heading":0.5}"#,
            r#"{"id":1,"t":1e999,"x":101,"y":100,"heading":0.5}"#,
            r#"{"id":1,"t":5.1,"x":101,"y":100,"heading":0.5,"brought":4294967296}"#,
            r#"{"id":7,"t":5.1,"x":101,"y":100,"heading":0.5}"#,
            "nonsense",
            "",
            "\r",
        ] {
            assert_eq!(seen.take(line.as_bytes(), ms(300)), None, "{line}");
        }
        seen.disbelieve();
        seen.skip();
        let counts = [
            ("tracker_unreadable", 4),
            ("tracker_late", 1),
            ("tracker_impossible", 2),
            ("tracker_too_many", 1),
        ];
        assert_eq!(seen.ignored().counts(), counts);
        let mut budget = Budget::default();
        let taken = |budget: &mut Budget, at| (0..5000).filter(|_| budget.take(ms(at))).count();
        assert_eq!(
            [0, 99, 100, 1000].map(|at| taken(&mut budget, at)),
            [1000, 0, 1000, 1000]
        );
    }

    /// Three sightings in a row show where a robot is that was lost or put elsewhere; a mistake does not, whenever it comes.
    #[test]
    fn a_mistake_is_no_place() {
        const FAR: [(u64, &str); 4] = [
            (600, r#"{"id":1,"t":5.4,"x":3000,"y":100,"heading":0.5}"#),
            (650, r#"{"id":1,"t":5.45,"x":3001,"y":100,"heading":0.5}"#),
            (700, r#"{"id":1,"t":5.5,"x":3002,"y":100,"heading":0.5}"#),
            (750, r#"{"id":1,"t":5.55,"x":3003,"y":100,"heading":0.5}"#),
        ];
        const NEAR: (u64, &str) = (420, r#"{"id":1,"t":5.22,"x":110,"y":100,"heading":0.5}"#);
        let at = |lines: &[&[(u64, &str)]]| seen(&lines.concat()).map(|pose| pose[0]);
        assert_eq!(at(&[&FIRST[..2]]), None, "one more is needed");
        assert_eq!(at(&[&FAR[..1], &FIRST[..2]]), None);
        assert_eq!(at(&[&FIRST, &[NEAR]]), Some(110.0));
        // While it is seen elsewhere it is where it was last, and then lost, until three say so.
        assert_eq!(at(&[&FIRST, &[NEAR], &FAR[..2]]), Some(110.0));
        assert_eq!(at(&[&FIRST, &FAR[..2]]), None);
        assert_eq!(at(&[&FIRST, &FAR[..3]]), Some(3002.0));
        assert_eq!(at(&[&FIRST, &[NEAR], &FAR]), Some(3003.0));
    }

    /// Only a forager's sightings that count have its food, carried and brought, and the robots that it hears.
    #[test]
    fn a_swarm_s_tracker_says_more() {
        let mut seen = Seen::new(1, 200.0, LIMIT);
        let mut take = |at: u64, x: f64, more: &str| {
            let line = format!("{{\"id\":1,\"t\":{at},\"x\":{x},\"y\":0,\"heading\":-0.25{more}}}");
            let sighting = seen.take(line.as_bytes(), ms(50 * at))?;
            assert_eq!(sighting.pose(), [x, 0.0, 0.75]);
            Some((sighting.carries, sighting.brought, sighting.heard))
        };
        let full = r#","carries":true,"brought":4,"heard":[0,7,127,128,18446744073709551615,7]"#;
        assert_eq!(
            (take(1, 0.0, full), take(2, 0.0, full)),
            (None, None),
            "not certain yet"
        );
        let heard = 1 << 127 | 0b1000_0001;
        assert_eq!(take(3, 0.0, full), Some((Some(true), Some(4), Some(heard))));
        assert_eq!(take(4, 0.0, ""), Some((None, None, None)));
        assert_eq!(take(5, 0.0, r#","heard":[]"#), Some((None, None, Some(0))));
        assert_eq!(take(5, 0.0, full), None, "the same again");
        assert_eq!(take(6, 500.0, full), None, "somewhere else");
        for bad in [
            r#","carries":1"#,
            r#","brought":-1"#,
            r#","brought":1.5"#,
            r#","heard":7"#,
            r#","heard":[-1]"#,
        ] {
            assert_eq!(take(7, 0.0, bad), None, "{bad}");
        }
        assert_eq!(take(7, 0.0, r#","carries":false"#), Some((Some(false), None, None)));
    }

    /// A local sender: its sightings arrive, and are lost when it has been silent for the limit.
    #[test]
    fn a_robot_is_lost_when_nobody_has_seen_it_for_long() {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let values = Values::parse(&format!("udp:{free}#1"), LIMIT).unwrap();
        let tracker = Tracker::listen(&values, 200.0).unwrap();
        assert_eq!(tracker.pose(), None);
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        let line = |(t, heading)| format!("{{\"id\":1,\"t\":{t},\"x\":10,\"y\":20,\"heading\":{heading}}}\n");
        let text = [(0.9, 0.0), (1.0, -0.25), (1.1, 1.25)].map(line).concat();
        sender.send_to(text.as_bytes(), free).unwrap();
        let start = wall();
        while tracker.pose() != Some([10.0, 20.0, 0.25]) {
            assert!(wall() < start + ms(5000), "{:?}", tracker.pose());
            thread::sleep(ms(1));
        }
        thread::sleep(LIMIT + ms(20));
        assert_eq!(tracker.pose(), None);
        let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
        let values = Values::parse(&format!("udp:{}", taken.local_addr().unwrap()), LIMIT).unwrap();
        let error = Tracker::listen(&values, 200.0).unwrap_err().to_string();
        assert!(error.contains(&format!("--tracker udp:{}: ", values.listen)), "{error}");
    }

    /// A tracker sends its sightings of all robots to one address, which is free once nobody listens for any of them.
    #[test]
    fn robots_share_a_tracker() {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let [one, two] = [1, 2].map(|id| Values::parse(&format!("udp:{free}#{id}"), LIMIT).unwrap());
        let trackers = [&one, &two].map(|values| Tracker::listen(values, 200.0).unwrap());
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        let line = |(id, t)| format!("{{\"id\":{id},\"t\":{t},\"x\":{id}00,\"y\":20,\"heading\":0.25}}\n");
        let times = [0.9, 1.0, 1.1];
        let text: String = times
            .into_iter()
            .flat_map(|t| [(1, t), (2, t), (3, t)])
            .map(line)
            .collect();
        sender.send_to(text.as_bytes(), free).unwrap();
        let poses = || trackers.each_ref().map(Tracker::pose);
        let start = wall();
        while poses() != [Some([100.0, 20.0, 0.25]), Some([200.0, 20.0, 0.25])] {
            assert!(wall() < start + ms(5000), "{:?}", poses());
            thread::sleep(ms(1));
        }
        drop(trackers);
        let start = wall();
        while UdpSocket::bind(free).is_err() {
            assert!(wall() < start + ms(5000));
            thread::sleep(ms(1));
        }
    }

    #[test]
    fn addresses_are_parsed() {
        let parsed = Values::parse("udp:0.0.0.0:5005#7", LIMIT).unwrap();
        assert_eq!((&*parsed.listen, parsed.id, parsed.limit), ("0.0.0.0:5005", 7, LIMIT));
        assert_eq!(Values::parse("udp:[::]:5005", LIMIT).unwrap().id, 0);
        for bad in [
            "",
            "udp:",
            "udp:5005",
            "udp::5005",
            "tcp:0.0.0.0:5005",
            "udp:0.0.0.0:70000",
            "udp:0.0.0.0:5005#x",
        ] {
            let refusal = Values::parse(bad, LIMIT).unwrap_err();
            assert!(refusal.contains("udp:HOST:PORT#ID"), "{bad}");
        }
    }
}
