//! The operator's part during an experiment: the beacon, without which robots stop, and robots' reports.
//!
//! The beacon is a dead man's switch. Ten times a second a thread sends the experiment's time and the leave to move, as
//! long as the program that watches the robots renews it. If that program ends, hangs or is stopped, or if its machine
//! or its network is lost, robots receive no beacon and stop.
//!
//! Each start draws a number, which it sends until enough robots are there, and in each beacon. Robots repeat it in all
//! their reports. So a report that was recorded before a start, and is sent again after it, shows no robot.

use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use oneiro_base::exit::{Code, Failure, Result};
use oneiro_lab::exchange::radio::key::{Key, random};
use oneiro_lab::exchange::radio::{self, LONGEST, OPERATOR, Packet, Radio, Received, Refusal, Status, Windows};

use super::file::{Fleet, Robot};
use super::live::{AWAY, Record};

/// Time between two beacons: robots that allow for a silence of 400 ms may lose three in a row.
const PERIOD: Duration = Duration::from_millis(100);
/// How long robots may move without the watching program's leave.
const LEAVE: Duration = Duration::from_secs(1);
/// Time between two calls, ms.
const CALLS: Duration = Duration::from_millis(200);

/// The operator's radio in one start, which the beacon and the watching program share.
pub struct Station {
    radio: Mutex<Radio>,
    /// The number of this start.
    start: u64,
}

impl Station {
    /// The radio of the start that a record has begun: its numbers were never used, and it takes no datagram a second time.
    ///
    /// # Errors
    /// Exit 1 if the system has no random numbers.
    pub fn new(fleet: &Fleet, key: &Key, record: &Record) -> Result<Self> {
        let limits = fleet.experiment.settings().limits();
        let mut radio = Radio::new(OPERATOR, limits, key, fleet.hash(), record.boots);
        radio.restore(record.windows.clone());
        Ok(Self {
            radio: Mutex::new(radio),
            // 0 is what robots say that have heard none.
            start: u64::from_le_bytes(random()?).max(1),
        })
    }

    fn call(&self) -> Vec<u8> {
        lock(&self.radio).seal(&Packet::Call { start: self.start })
    }

    fn beacon(&self, milliseconds: i64, go: bool) -> Vec<u8> {
        let start = self.start;
        lock(&self.radio).seal(&Packet::Beacon {
            milliseconds,
            go,
            start,
        })
    }

    /// Which datagrams it has taken, to be saved.
    pub fn windows(&self) -> Windows {
        lock(&self.radio).windows().clone()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A socket where robots reach this machine, and their addresses.
#[derive(Debug)]
pub struct Socket {
    socket: UdpSocket,
    robots: Vec<SocketAddr>,
}

impl Socket {
    /// Listens at the port of the fleet's operator.
    ///
    /// # Errors
    /// Exit 4: another program listens there.
    pub fn open(fleet: &Fleet) -> Result<Self> {
        let operator = fleet.operator;
        let any: IpAddr = match operator {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let open = || -> io::Result<UdpSocket> {
            let socket = UdpSocket::bind((any, operator.port()))?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let busy = |error| {
            let problem = format!(
                "can't listen at port {}: {error}; does `oneiro fleet start` run already?",
                operator.port()
            );
            Failure::of(Code::Device, problem)
        };
        let socket = open().map_err(busy)?;
        let robots = fleet.robots.iter().filter_map(|robot| robot.radio).collect();
        Ok(Self { socket, robots })
    }

    /// Sends to all robots. Unsent datagrams are lost, as on the way.
    fn send(&self, datagram: &[u8]) {
        for robot in &self.robots {
            let _ = self.socket.send_to(datagram, robot);
        }
    }

    /// The next datagram, if one has come: its length, and where it is from.
    fn receive(&self, room: &mut [u8]) -> Option<(usize, SocketAddr)> {
        loop {
            match self.socket.recv_from(room) {
                Ok(datagram) => return Some(datagram),
                // Of a datagram that was sent before: its receiver was not there.
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => (),
                Err(_) => return None,
            }
        }
    }
}

/// The experiment's time.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// What it was when it began to run, ms, and when that was.
    base: i64,
    began: Instant,
}

impl Time {
    /// Time that runs from `base` on.
    pub fn from(base: i64) -> Self {
        Self {
            base,
            began: Instant::now(),
        }
    }

    /// What it is now, ms.
    pub fn now(self) -> i64 {
        self.base + self.began.elapsed().as_millis() as i64
    }
}

/// The beacon's thread.
#[derive(Debug)]
pub struct Beacon {
    /// Until when robots may move.
    leave: Arc<Mutex<Instant>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Beacon {
    /// Begins to say that robots may move.
    ///
    /// # Errors
    /// Exit 1 if there is no thread for it.
    pub fn begin(socket: Arc<Socket>, station: Arc<Station>, time: Time) -> Result<Self> {
        let leave = Arc::new(Mutex::new(Instant::now() + LEAVE));
        let ends = Arc::new(AtomicBool::new(false));
        let (until, end) = (Arc::clone(&leave), Arc::clone(&ends));
        let say = move || {
            let mut next = Instant::now();
            while !end.load(Ordering::Relaxed) {
                let go = Instant::now() < *lock(&until);
                socket.send(&station.beacon(time.now(), go));
                // After a pause of the machine, no beacons are made up for.
                next = (next + PERIOD).max(Instant::now());
                thread::sleep(next.saturating_duration_since(Instant::now()));
            }
            // Stand at once, rather than when the silence has lasted long enough; several, since datagrams get lost.
            for _ in 0..5 {
                socket.send(&station.beacon(time.now(), false));
                thread::sleep(PERIOD / 5);
            }
        };
        let thread = thread::Builder::new().name("beacon".into()).spawn(say);
        let thread = thread.map_err(|error| Failure::failed(format_args!("the beacon has no thread: {error}")))?;
        Ok(Self {
            leave,
            ends,
            thread: Some(thread),
        })
    }

    /// Gives robots leave to move for another second.
    pub(crate) fn renew(&self) {
        *lock(&self.leave) = Instant::now() + LEAVE;
    }

    /// Tells robots to stop, and ends.
    pub fn end(mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If it has crashed, robots have stopped already.
            let _ = thread.join();
        }
    }
}

impl Drop for Beacon {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
    }
}

/// What is known of a robot.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// Time of its last message in this start.
    pub heard: Option<Instant>,
    /// Its last status.
    pub status: Option<Status>,
    /// Why it can't take part: another version of the program.
    pub refused: Option<String>,
    /// What may be wrong with it, by datagrams that may be old or anybody's: they count for nothing else.
    pub(crate) doubt: Option<String>,
    /// Whether datagrams of another start have come in its name.
    pub(crate) is_stale: bool,
}

impl Known {
    /// Whether it has recently sent a message.
    pub(crate) fn is_here(&self) -> bool {
        self.heard.is_some_and(|at| at.elapsed() <= AWAY)
    }

    /// Why it can't take part, if known.
    pub fn refusal(&self) -> Option<&str> {
        let doubt = self.doubt.as_deref().filter(|_| !self.is_here());
        self.refused.as_deref().or(doubt)
    }
}

/// All reports of robots.
pub struct Ears {
    socket: Arc<Socket>,
    station: Arc<Station>,
    began: Instant,
    /// When it has called for robots last.
    called: Option<Instant>,
    /// Where robots send from.
    addresses: Vec<(SocketAddr, u32)>,
    /// The experiment's time, when it runs.
    pub time: Option<Time>,
    pub robots: BTreeMap<u32, Known>,
    /// Datagrams that were refused, by reason.
    pub refused: BTreeMap<&'static str, u64>,
}

/// Version of the program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

impl Ears {
    /// Ears for all robots of a fleet.
    pub fn new(fleet: &Fleet, socket: Arc<Socket>, station: Arc<Station>) -> Self {
        let known = |robot: &Robot| (robot.number, Known::default());
        let address = |robot: &Robot| robot.radio.map(|address| (address, robot.number));
        Self {
            socket,
            station,
            began: Instant::now(),
            called: None,
            addresses: fleet.robots.iter().filter_map(address).collect(),
            time: None,
            robots: fleet.robots.iter().map(known).collect(),
            refused: BTreeMap::new(),
        }
    }

    /// Sends the number of this start, from time to time, to robots that receive no beacon with it.
    pub fn call(&mut self) {
        if self.called.is_none_or(|at| at.elapsed() >= CALLS) {
            self.called = Some(Instant::now());
            self.socket.send(&self.station.call());
        }
    }

    /// Takes all received datagrams, but no more than a flood should cost at a time.
    pub fn listen(&mut self) {
        const MOST: usize = 1000;
        // One more, to notice datagrams that are too long.
        let mut room = [0; LONGEST + 1];
        for _ in 0..MOST {
            let Some((length, from)) = self.socket.receive(&mut room) else {
                return;
            };
            let second = self.time.and_then(|time| u32::try_from(time.now() / 1000).ok());
            let opened = lock(&self.station.radio).open(&room[..length], self.began.elapsed(), second);
            match opened {
                Ok(received) => self.take(received),
                Err(refusal) => self.refuse(&refusal, from),
            }
        }
    }

    fn take(&mut self, Received { sender, packet, .. }: Received) {
        let Some(robot) = self.robots.get_mut(&sender.into()) else {
            *self.refused.entry("not_in_the_fleet").or_default() += 1;
            return;
        };
        let start = match &packet {
            Packet::Hello { start, .. } | Packet::Status(Status { start, .. }) => *start,
            // These are for robots.
            Packet::Pair { .. } | Packet::Beacon { .. } | Packet::Call { .. } => return,
        };
        if start != self.station.start {
            *self.refused.entry("of_another_start").or_default() += 1;
            robot.is_stale = true;
            return;
        }
        robot.heard = Some(Instant::now());
        match packet {
            Packet::Hello { program, .. } => {
                let other = format!("has oneiro {program}, and this is {VERSION}: deploy again");
                robot.refused = (program != VERSION).then_some(other);
            }
            Packet::Status(status) => robot.status = Some(status),
            Packet::Pair { .. } | Packet::Beacon { .. } | Packet::Call { .. } => (),
        }
    }

    /// Counts a refused datagram. One of another version or experiment, or with an old number, shows a possible problem
    /// with a robot, as long as nothing else does: anybody can send these.
    fn refuse(&mut self, refusal: &Refusal, from: SocketAddr) {
        *self.refused.entry(refusal.reason()).or_default() += 1;
        let at = || {
            self.addresses
                .iter()
                .find(|(address, _)| *address == from)
                .map(|(_, number)| *number)
        };
        let (number, doubt) = match refusal {
            Refusal::OtherExperiment {
                sender,
                program: Some(_),
                ..
            } => (Some(u32::from(*sender)), format!("{refusal}: deploy again")),
            Refusal::OtherVersion(version) => {
                let ours = radio::VERSION;
                let doubt =
                    format!("sends datagrams of version {version}, and this machine of version {ours}: deploy again");
                (at(), doubt)
            }
            Refusal::Replayed => {
                let doubt = "sends numbers that were accepted before: old datagrams are replayed, or it has lost its \
                             directory. All robots need a new key";
                (at(), doubt.to_owned())
            }
            _ => return,
        };
        if let Some(robot) = number.and_then(|number| self.robots.get_mut(&number)) {
            robot.doubt = Some(doubt);
        }
    }

    /// Number of robots that recently sent a message, and may take part.
    pub fn present(&self) -> usize {
        let may_take_part = |known: &&Known| known.is_here() && known.refusal().is_none();
        self.robots.values().filter(may_take_part).count()
    }

    /// The experiment's time that the farthest of the robots has reached, ms.
    pub fn farthest(&self) -> Option<i64> {
        let status = self.robots.values().filter_map(|known| known.status.as_ref());
        status.map(|status| status.milliseconds).max()
    }
}
