//! A tracker: a program with a camera that says where robots are, one line of JSON for each sighting, over UDP:
//! `{"id":1,"t":12.3,"x":350.0,"y":200.0,"heading":0.25}`, with the tracker's time in s, mm, and turns counter-clockwise from the x axis.

use std::io::ErrorKind;
use std::net::UdpSocket;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::Duration;

use serde::Deserialize;

use super::link::wall;
use crate::exit::Failure;

/// Age of a tracker's last sighting from which a robot counts as lost, unless told otherwise, ms.
pub(crate) const AGE_MS: u64 = 300;
/// What it may be, ms.
pub(crate) const AGES_MS: RangeInclusive<u64> = 50..=2000;

/// Where a tracker's sightings arrive, and what counts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Values {
    /// Address to listen at, such as `0.0.0.0:5005`.
    pub(crate) listen: String,
    /// The robot's number.
    pub(crate) id: u64,
    /// Age of the last sighting from which the robot counts as lost.
    pub(crate) limit: Duration,
}

impl Values {
    /// Parses `udp:HOST:PORT#ID`; without `#ID` the robot is number 0.
    ///
    /// # Errors
    /// What is allowed.
    pub(crate) fn parse(text: &str, limit: Duration) -> Result<Self, String> {
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

/// A line of a tracker. Other keys are left alone.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Sighting {
    id: u64,
    t: f64,
    x: f64,
    y: f64,
    heading: f64,
}

/// What a robot's sightings were.
#[derive(Debug)]
struct Seen {
    id: u64,
    /// Greatest speed of the robot, mm/s.
    speed: f64,
    last: Option<(Sighting, Duration)>,
}

impl Seen {
    /// Farthest that noise and the rounding of times let a sighting be from the last one, beside what the robot drives, mm.
    const NOISE: f64 = 20.0;
    /// A time that goes back by more than this is that of a tracker that has started again, s.
    const RESTART: f64 = 1.0;
    /// Farthest from the origin, mm: a hundred metres.
    const FARTHEST: f64 = 1e5;

    /// Takes a line that has come now. One that is no sighting of the robot is dropped, and so are sightings out of order, beyond
    /// all rooms, or farther from the last one than the robot can have driven since.
    fn take(&mut self, line: &[u8], now: Duration) {
        let Ok(sighting) = serde_json::from_slice::<Sighting>(line) else {
            return;
        };
        let Sighting { id, t, x, y, heading } = sighting;
        let is_number = [t, heading].into_iter().all(f64::is_finite) && x.abs().max(y.abs()) <= Self::FARTHEST;
        if id != self.id || !is_number || x.is_nan() || y.is_nan() {
            return;
        }
        if let Some((last, at)) = self.last {
            let is_old = t <= last.t && t > last.t - Self::RESTART;
            let reach = self.speed * now.saturating_sub(at).as_secs_f64() + Self::NOISE;
            if is_old || (x - last.x).hypot(y - last.y) > reach {
                return;
            }
        }
        self.last = Some((sighting, now));
    }
}

/// Listens to a tracker as long as this is alive.
#[derive(Debug)]
pub(crate) struct Tracker {
    seen: Arc<Mutex<Seen>>,
    limit: Duration,
}

impl Tracker {
    /// Between two looks at whether to go on.
    const GLANCE: Duration = Duration::from_millis(100);

    /// Listens for a robot that drives no faster than this, mm/s.
    ///
    /// # Errors
    /// Exit 3: nobody can listen at the address.
    pub(crate) fn listen(values: &Values, speed: f64) -> Result<Self, Failure> {
        let refused = |error| Failure::input(format_args!("--tracker udp:{}: {error}", values.listen));
        let socket = UdpSocket::bind(&values.listen).map_err(refused)?;
        socket.set_read_timeout(Some(Self::GLANCE)).map_err(refused)?;
        let seen = Arc::new(Mutex::new(Seen {
            id: values.id,
            speed,
            last: None,
        }));
        let heard = Arc::downgrade(&seen);
        thread::spawn(move || hear(&socket, &heard));
        Ok(Self {
            seen,
            limit: values.limit,
        })
    }

    /// Where the robot is: x and y in mm, heading in turns, 0 to 1. None if it is lost.
    pub(crate) fn pose(&self) -> Option<[f64; 3]> {
        let (Sighting { x, y, heading, .. }, at) = lock(&self.seen).last?;
        let is_lost = wall().saturating_sub(at) > self.limit;
        (!is_lost).then_some([x, y, heading.rem_euclid(1.0)])
    }
}

fn lock(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes what comes, until nobody needs it any more.
fn hear(socket: &UdpSocket, seen: &Weak<Mutex<Seen>>) {
    let mut buffer = [0; 2048];
    while let Some(seen) = seen.upgrade() {
        match socket.recv(&mut buffer) {
            Ok(count) => {
                let lines = buffer[..count].split(|byte| *byte == b'\n');
                lines.for_each(|line| lock(&seen).take(line, wall()));
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(_) => thread::sleep(Tracker::GLANCE),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Duration = Duration::from_millis(300);

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// A robot with number 1 that drives at up to 200 mm/s.
    fn seen(lines: &[(u64, &str)]) -> Option<[f64; 3]> {
        let mut seen = Seen {
            id: 1,
            speed: 200.0,
            last: None,
        };
        for (at, line) in lines {
            seen.take(line.as_bytes(), ms(*at));
        }
        seen.last
            .map(|(sighting, _)| [sighting.x, sighting.y, sighting.heading])
    }

    const FIRST: (u64, &str) = (0, r#"{"id":1,"t":5.0,"x":100,"y":100,"heading":0.5}"#);

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
            let pose = seen(&[FIRST, (100, line)]).unwrap();
            assert_eq!(pose != [100.0, 100.0, 0.5], counts, "{line}");
        }
        // The longer it was out of sight, the farther it may be.
        let far = r#"{"id":1,"t":9.0,"x":500,"y":100,"heading":0.5}"#;
        assert_eq!(seen(&[FIRST, (1800, far)]).unwrap()[0], 100.0);
        assert_eq!(seen(&[FIRST, (2000, far)]).unwrap()[0], 500.0);
        assert_eq!(seen(&[(0, "{}")]), None);
    }

    /// A local sender: what it sends is seen, and lost when it has been silent for the limit.
    #[test]
    fn a_robot_is_lost_when_nobody_has_seen_it_for_long() {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let values = Values::parse(&format!("udp:{free}#1"), LIMIT).unwrap();
        let tracker = Tracker::listen(&values, 200.0).unwrap();
        assert_eq!(tracker.pose(), None);
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        let line = |(t, heading)| format!("{{\"id\":1,\"t\":{t},\"x\":10,\"y\":20,\"heading\":{heading}}}\n");
        let text = [(1.0, -0.25), (1.1, 1.25)].map(line).concat();
        sender.send_to(text.as_bytes(), free).unwrap();
        let start = wall();
        while tracker.pose() != Some([10.0, 20.0, 0.25]) {
            assert!(wall() < start + ms(5000), "{:?}", tracker.pose());
            thread::sleep(ms(1));
        }
        thread::sleep(LIMIT + ms(20));
        assert_eq!(tracker.pose(), None);
        let error = Tracker::listen(&values, 200.0).unwrap_err().to_string();
        assert!(error.contains(&format!("--tracker udp:{free}: ")), "{error}");
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
