//! Entries of the registry of drivers. The registry is in `lib.rs`: one line a driver, from which the forms of addresses, the order
//! in which robots are asked what they are, messages and the page follow.

use super::error::Result;
use super::link::Link;
use super::{DRIVERS, Robot};

/// A driver's entry in the registry.
pub(crate) struct Driver {
    /// Its robots, as messages and pages name them.
    pub(crate) robots: &'static [&'static str],
    /// How they are reached and recognised.
    pub(crate) reach: Reach,
}

/// How robots are reached and recognised.
pub(crate) enum Reach {
    /// By TCP. They are asked before all others, each driver's on a new connection.
    Tcp {
        /// The usual port.
        port: u16,
        ask: Ask,
    },
    /// At a serial port, or by TCP through a server that passes one on. They are asked in the registry's order, on one link.
    Serial {
        /// Baud rates, the likeliest first.
        bauds: &'static [u32],
        ask: Ask,
    },
    /// By a protocol that begins the address, since a robot that does not know it says nothing.
    Protocol(Protocol),
}

/// Asks what is at the end of a link whether it is one of a driver's robots, and stops it.
///
/// # Errors
/// It is, and does not stop, or the link fails.
pub(crate) type Ask = fn(Box<dyn Link>) -> Result<Met>;

/// What is at the end of a link.
pub(crate) enum Met {
    Robot(Box<dyn Robot>),
    /// None of the driver's robots; the link is for the next driver.
    Stranger(Box<dyn Link>),
}

impl Met {
    /// What a robot is after `begun`, the outcome of the first exchange. One that has answered is no stranger, whatever has failed.
    ///
    /// # Errors
    /// That of `begun`.
    pub(crate) fn of<R: Robot + 'static>(
        robot: R,
        begun: Result,
        has_answered: bool,
        into_link: fn(R) -> Box<dyn Link>,
    ) -> Result<Self> {
        match begun {
            Err(error) if error.may_pass() && !has_answered => Ok(Self::Stranger(into_link(robot))),
            begun => begun.map(|()| Self::Robot(Box::new(robot))),
        }
    }
}

type Connect = fn(Box<dyn Link>, Option<u16>) -> Result<Box<dyn Robot>>;

/// A protocol that is part of an address.
#[derive(Debug)]
pub struct Protocol {
    /// The beginning of its addresses.
    pub(crate) name: &'static str,
    /// What is at a serial port, in the list of addresses.
    pub(crate) serial: &'static str,
    /// What is at a host and a port.
    pub(crate) tcp: &'static str,
    /// Vendors of USB devices that speak it.
    pub(crate) usb_vendors: &'static [u16],
    /// Connects to a robot and stops it: the one with a number, if the address has one.
    pub(crate) connect: Connect,
}

impl PartialEq for Protocol {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Protocol {}

/// All protocols that are part of an address.
pub(crate) fn protocols() -> impl Iterator<Item = &'static Protocol> {
    DRIVERS.iter().filter_map(|driver| match &driver.reach {
        Reach::Protocol(protocol) => Some(protocol),
        _ => None,
    })
}

/// Requests to robots reached by TCP, each on its own connection.
pub(crate) fn at_tcp(drivers: &[&Driver]) -> Vec<Ask> {
    let ask = |driver: &&Driver| match driver.reach {
        Reach::Tcp { ask, .. } => Some(ask),
        _ => None,
    };
    drivers.iter().filter_map(ask).collect()
}

/// What asks, in this order, robots at a serial port: all, or those that use a baud rate.
pub(crate) fn at_serial(drivers: &[&Driver], baud: Option<u32>) -> Vec<Ask> {
    let ask = |driver: &&Driver| match driver.reach {
        Reach::Serial { bauds, ask } if baud.is_none_or(|baud| bauds.contains(&baud)) => Some(ask),
        _ => None,
    };
    drivers.iter().filter_map(ask).collect()
}

/// Baud rates to try, the likeliest first.
pub(crate) fn bauds() -> Vec<u32> {
    let mut all: Vec<u32> = Vec::new();
    for driver in DRIVERS {
        if let Reach::Serial { bauds, .. } = driver.reach {
            let new: Vec<u32> = bauds.iter().copied().filter(|baud| !all.contains(baud)).collect();
            all.extend(new);
        }
    }
    all
}

/// Names of the robots that are recognised at a serial port, or, with `has_tcp`, at a host and a port.
pub(crate) fn robot_names(has_tcp: bool) -> String {
    let is_one = |driver: &&&Driver| match driver.reach {
        Reach::Tcp { .. } => has_tcp,
        Reach::Serial { .. } => true,
        Reach::Protocol(_) => false,
    };
    let names = DRIVERS.iter().filter(is_one).flat_map(|driver| driver.robots);
    any_of(names.copied())
}

/// The address to write for robots that are not recognised.
pub(crate) fn advice() -> String {
    let of = |driver: &&Driver| match &driver.reach {
        Reach::Protocol(protocol) => Some(format!(
            "; for a {}, write {}: before the address",
            any_of(driver.robots.iter().copied()),
            protocol.name
        )),
        _ => None,
    };
    DRIVERS.iter().filter_map(of).collect()
}

/// Forms of the address of a robot at the end of a link, and the robots that have it.
pub fn forms() -> Vec<[String; 2]> {
    let bauds: Vec<String> = bauds().iter().map(u32::to_string).collect();
    let tcp = DRIVERS.iter().filter_map(|driver| match driver.reach {
        Reach::Tcp { port, .. } => Some(format!("{} (port {port})", any_of(driver.robots.iter().copied()))),
        _ => None,
    });
    let mut forms = vec![
        [
            "serial:PATH".to_owned(),
            format!("{} at a serial port, USB or Bluetooth", robot_names(false)),
        ],
        [
            "serial:PATH@BAUD".into(),
            format!(
                "the same, faster to find: otherwise {} baud are tried",
                bauds.join(", ")
            ),
        ],
        [
            "tcp:HOST:PORT".into(),
            format!(
                "{}, or a serial port that a server passes on",
                tcp.collect::<Vec<_>>().join(", ")
            ),
        ],
    ];
    for Protocol { name, serial, tcp, .. } in protocols() {
        forms.push([format!("{name}:serial:PATH[#NODE]"), (*serial).into()]);
        forms.push([format!("{name}:HOST:PORT[#NODE]"), (*tcp).into()]);
    }
    forms
}

/// `a, b or c`.
fn any_of<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let words: Vec<&str> = words.collect();
    match words.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => words.concat(),
    }
}
