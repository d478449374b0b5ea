//! The operator's part while robots live: the beacon, without which they stand, and what they report.
//!
//! The beacon is a dead man's switch. A thread says ten times a second what time it is in the experiment, and that robots may move: as
//! long as the program that watches the robots renews its leave to do so. If that program ends, hangs or is stopped, or if its machine or
//! its network is lost, robots hear no beacon any more and stand.

use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::file::{Fleet, Robot};
use crate::exchange::radio::key::Key;
use crate::exchange::radio::{LONGEST, OPERATOR, Packet, Radio, Refusal, Status};
use crate::exit::{Code, Failure, Result};

/// Time between two beacons: robots that allow for a silence of 400 ms may lose three in a row.
const PERIOD: Duration = Duration::from_millis(100);
/// How long robots may move without the watching program's leave.
const LEAVE: Duration = Duration::from_secs(1);
/// A radio that the beacon and the watching program share.
pub(crate) type Shared = Arc<Mutex<Radio>>;

/// The operator's radio at its start number `boots`.
///
/// # Errors
/// Exit 3: the key can't be read.
pub(crate) fn radio(fleet: &Fleet, boots: u32) -> Result<Shared> {
    let (key, limits) = (Key::read(&fleet.key)?, fleet.experiment.settings().limits());
    let radio = Radio::new(OPERATOR, limits, &key, fleet.hash(), boots);
    Ok(Arc::new(Mutex::new(radio)))
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A socket where robots reach this machine, and their addresses.
#[derive(Debug)]
pub(crate) struct Socket {
    socket: UdpSocket,
    robots: Vec<SocketAddr>,
}

impl Socket {
    /// Listens at the port of the fleet's operator.
    ///
    /// # Errors
    /// Exit 4: another program listens there.
    pub(crate) fn open(fleet: &Fleet) -> Result<Self> {
        let own = fleet.operator;
        let any: IpAddr = match own {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let open = || -> io::Result<UdpSocket> {
            let socket = UdpSocket::bind((any, own.port()))?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let busy = |error| {
            let problem = format!(
                "can't listen at port {}: {error}; does `oneiro fleet start` run already?",
                own.port()
            );
            Failure::of(Code::Device, problem)
        };
        let socket = open().map_err(busy)?;
        let robots = fleet.robots.iter().filter_map(|robot| robot.radio).collect();
        Ok(Self { socket, robots })
    }

    /// Sends to all robots. What can't be sent is lost, as on the way.
    fn send(&self, datagram: &[u8]) {
        for robot in &self.robots {
            let _ = self.socket.send_to(datagram, robot);
        }
    }

    /// The next datagram, if one has come.
    fn receive(&self, room: &mut [u8]) -> Option<usize> {
        loop {
            match self.socket.recv(room) {
                Ok(length) => return Some(length),
                // Of a datagram that was sent before: its receiver was not there.
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => (),
                Err(_) => return None,
            }
        }
    }
}

/// The experiment's time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Time {
    /// What it was when it began to run, ms, and when that was.
    base: i64,
    began: Instant,
}

impl Time {
    /// Time that runs from `base` on.
    pub(crate) fn from(base: i64) -> Self {
        Self {
            base,
            began: Instant::now(),
        }
    }

    /// What it is now, ms.
    pub(crate) fn now(self) -> i64 {
        self.base + self.began.elapsed().as_millis() as i64
    }
}

/// The beacon's thread.
#[derive(Debug)]
pub(crate) struct Beacon {
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
    pub(crate) fn begin(socket: Arc<Socket>, radio: Shared, time: Time) -> Result<Self> {
        let leave = Arc::new(Mutex::new(Instant::now() + LEAVE));
        let ends = Arc::new(AtomicBool::new(false));
        let (until, end) = (Arc::clone(&leave), Arc::clone(&ends));
        let say = move || {
            let mut next = Instant::now();
            while !end.load(Ordering::Relaxed) {
                let go = Instant::now() < *locked(&until);
                let milliseconds = time.now();
                let beacon = locked(&radio).seal(&Packet::Beacon { milliseconds, go });
                socket.send(&beacon);
                // After a pause of the machine, no beacons are made up for.
                next = (next + PERIOD).max(Instant::now());
                thread::sleep(next.saturating_duration_since(Instant::now()));
            }
            // Stand at once, rather than when the silence has lasted long enough; several, since datagrams get lost.
            for _ in 0..5 {
                let (milliseconds, go) = (time.now(), false);
                let beacon = locked(&radio).seal(&Packet::Beacon { milliseconds, go });
                socket.send(&beacon);
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
        *locked(&self.leave) = Instant::now() + LEAVE;
    }

    /// Tells robots to stand, and ends.
    pub(crate) fn end(mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If it has crashed, robots stand already.
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
pub(crate) struct Known {
    /// When it last said anything.
    pub(crate) heard: Option<Instant>,
    /// Its last status.
    pub(crate) status: Option<Status>,
    /// Why it can't take part: another version or another experiment.
    pub(crate) refused: Option<String>,
}

/// All that robots said.
pub(crate) struct Ears {
    socket: Arc<Socket>,
    radio: Shared,
    began: Instant,
    /// The experiment's time, when it runs.
    pub(crate) time: Option<Time>,
    pub(crate) robots: BTreeMap<u32, Known>,
    /// Datagrams that were refused, by reason.
    pub(crate) refused: BTreeMap<&'static str, u64>,
}

/// Version of the program.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

impl Ears {
    /// Ears for all robots of a fleet.
    pub(crate) fn new(fleet: &Fleet, socket: Arc<Socket>, radio: Shared) -> Self {
        let known = |robot: &Robot| (robot.number, Known::default());
        Self {
            socket,
            radio,
            began: Instant::now(),
            time: None,
            robots: fleet.robots.iter().map(known).collect(),
            refused: BTreeMap::new(),
        }
    }

    /// Takes all that has come, but no more than a flood should cost at a time.
    pub(crate) fn listen(&mut self) {
        const MOST: usize = 1000;
        // One more, so that what is longer than any datagram shows.
        let mut room = [0; LONGEST + 1];
        for _ in 0..MOST {
            let Some(length) = self.socket.receive(&mut room) else {
                return;
            };
            let second = self.time.and_then(|time| u32::try_from(time.now() / 1000).ok());
            let opened = locked(&self.radio).open(&room[..length], self.began.elapsed(), second);
            match opened {
                Ok(received) => self.take(received.sender.into(), received.packet),
                Err(refusal) => self.refuse(&refusal),
            }
        }
    }

    fn take(&mut self, sender: u32, packet: Packet) {
        let Some(robot) = self.robots.get_mut(&sender) else {
            *self.refused.entry("not_in_the_fleet").or_default() += 1;
            return;
        };
        robot.heard = Some(Instant::now());
        match packet {
            Packet::Hello { program, .. } => {
                let other = format!("has oneiro {program}, and this is {VERSION}: deploy again");
                robot.refused = (program != VERSION).then_some(other);
            }
            Packet::Status(status) => robot.status = Some(status),
            Packet::Pair { .. } | Packet::Beacon { .. } => (),
        }
    }

    /// Counts a datagram that is refused; a robot that lives another experiment is named.
    fn refuse(&mut self, refusal: &Refusal) {
        *self.refused.entry(refusal.reason()).or_default() += 1;
        if let Refusal::OtherExperiment { sender, program, .. } = refusal
            && program.is_some()
            && let Some(robot) = self.robots.get_mut(&u32::from(*sender))
        {
            robot.heard = Some(Instant::now());
            robot.refused = Some(format!("{refusal}: deploy again"));
        }
    }

    /// Robots that said something within this time, and may take part.
    pub(crate) fn present(&self, within: Duration) -> usize {
        let is_here = |known: &&Known| known.heard.is_some_and(|at| at.elapsed() < within) && known.refused.is_none();
        self.robots.values().filter(is_here).count()
    }

    /// The experiment's time that the farthest of the robots has reached, ms.
    pub(crate) fn farthest(&self) -> Option<i64> {
        let status = self.robots.values().filter_map(|known| known.status.as_ref());
        status.map(|status| status.milliseconds).max()
    }
}
