//! Addresses of robots, as typed on the command line.
//!
//! The protocol is part of an address only where it can't be told from the robot's answers: the Aseba protocol is
//! binary, and a node that does not know it says nothing.

use std::fmt;
use std::num::IntErrorKind;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Where a robot is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `surrogate:SEED`: a simulation that stands in for a robot.
    Surrogate(u64),
    /// At the end of a wire or a radio link.
    Wire(Wire),
}

/// Where a real robot is, or an emulated one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wire {
    /// A robot that says itself what it is: a Khepera, an e-puck or an e-puck2.
    Plain(Transport),
    /// `aseba:..`: a node of an Aseba network, such as a Thymio II. `tcp:` after it may be left out.
    Aseba {
        /// What leads to the network.
        transport: Transport,
        /// The node's number; none if there is only one that can drive.
        node: Option<u16>,
    },
}

/// What carries the bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Transport {
    /// `serial:PATH` or `serial:PATH@BAUD`: a serial port, USB or Bluetooth (RFCOMM) included.
    Serial {
        /// The port's path or name, such as `/dev/ttyUSB0` or `COM3`.
        path: String,
        /// Bits per second; none if it has to be found out or does not matter.
        baud: Option<u32>,
    },
    /// `tcp:HOST:PORT`
    Tcp {
        /// A name or an address; IPv6 in brackets.
        host: String,
        /// The port.
        port: u16,
    },
}

/// Forms of the address of a robot at the end of a link, and the robots that have it.
pub const FORMS: [(&str, &str); 5] = [
    (
        "serial:PATH",
        "Khepera, e-puck or e-puck2 at a serial port, USB or Bluetooth",
    ),
    ("serial:PATH@BAUD", "the same, if it is slow to find"),
    (
        "tcp:HOST:PORT",
        "e-puck2 over Wi-Fi (port 1000), or a serial port that a server passes on",
    ),
    (
        "aseba:serial:PATH",
        "Thymio II over USB or its radio dongle; #NODE after the path if there are several",
    ),
    (
        "aseba:HOST:PORT",
        "Thymio II behind an Aseba switch, or Aseba's simulator (port 33333); #NODE likewise",
    ),
];

/// All forms, for messages.
pub fn forms() -> String {
    FORMS.map(|(form, _)| form).join(", ") + ", the last two also with #NODE"
}

const BAUD_RATES: RangeInclusive<u32> = 300..=4_000_000;

/// The part of an address that is wrong, and what is allowed there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("robot {address}: {problem}")]
pub struct Invalid {
    address: String,
    problem: String,
}

/// Form of a surrogate's address.
const SURROGATE: &str = "surrogate";

impl FromStr for Address {
    type Err = Invalid;

    /// Parses the address of a robot that may be simulated.
    fn from_str(text: &str) -> Result<Self, Invalid> {
        let parsed = if let Some((SURROGATE, seed)) = text.split_once(':') {
            number(seed, "seed", &(0..=u64::MAX)).map(Self::Surrogate)
        } else {
            let allowed = format!("{}, or {SURROGATE}:SEED for a simulated Khepera", forms());
            wire(text, &allowed).map(Self::Wire)
        };
        parsed.map_err(|problem| Invalid::of(text, problem))
    }
}

impl FromStr for Wire {
    type Err = Invalid;

    /// Parses the address of a robot that has a link.
    fn from_str(text: &str) -> Result<Self, Invalid> {
        let parsed = match text.split_once(':') {
            Some((SURROGATE, _)) => Err(format!("a surrogate has no link; allowed: {}", forms())),
            _ => wire(text, &forms()),
        };
        parsed.map_err(|problem| Invalid::of(text, problem))
    }
}

impl Invalid {
    fn of(address: &str, problem: String) -> Self {
        Self {
            address: address.into(),
            problem,
        }
    }

    /// Whether it doesn't even begin as an address does.
    pub fn is_no_address(&self) -> bool {
        let scheme = self.address.split_once(':').map(|(scheme, _)| scheme);
        scheme.is_none_or(|scheme| ![SURROGATE, "serial", "tcp", "aseba"].contains(&scheme))
    }
}

/// Parses the address of a robot that has a link; `allowed` are the forms that the caller takes.
fn wire(text: &str, allowed: &str) -> Result<Wire, String> {
    match text.split_once(':') {
        Some(("serial", port)) => serial(port).map(Wire::Plain),
        Some(("tcp", place)) => tcp(place).map(Wire::Plain),
        Some(("aseba", place)) => aseba(place),
        scheme => {
            let problem = match scheme {
                Some((scheme, _)) => format!("`{scheme}` is no way to reach a robot"),
                None => "does not say how to reach it".to_owned(),
            };
            Err(match meant(text) {
                Some(meant) => format!("{problem}; did you mean {meant}? (allowed: {allowed})"),
                None => format!("{problem}; allowed: {allowed}"),
            })
        }
    }
}

/// The likely address for a port's or a computer's name alone.
fn meant(text: &str) -> Option<String> {
    let is_port = text.starts_with("/dev/") || text.strip_prefix("COM").is_some_and(|port| port.parse::<u8>().is_ok());
    if is_port {
        return Some(format!("serial:{text}"));
    }
    if text.starts_with("tty") {
        return Some(format!("serial:/dev/{text}"));
    }
    let (host, port) = text.split_once(':')?;
    let is_host = host == "localhost" || host.contains('.');
    (is_host && port.parse::<u16>().is_ok()).then(|| format!("tcp:{text}"))
}

fn aseba(text: &str) -> Result<Wire, String> {
    let (place, node) = match text.rsplit_once('#') {
        Some((place, node)) => (place, Some(number(node, "node", &(1..=u64::from(u16::MAX)))? as u16)),
        None => (text, None),
    };
    let transport = match place.strip_prefix("serial:") {
        Some(port) => serial(port)?,
        None => tcp(place.strip_prefix("tcp:").unwrap_or(place))?,
    };
    Ok(Wire::Aseba { transport, node })
}

fn serial(text: &str) -> Result<Transport, String> {
    let (path, baud) = match text.rsplit_once('@') {
        Some((path, baud)) => {
            let allowed = u64::from(*BAUD_RATES.start())..=u64::from(*BAUD_RATES.end());
            (path, Some(number(baud, "baud rate", &allowed)? as u32))
        }
        None => (text, None),
    };
    if path.is_empty() {
        return Err("names no port; allowed: a path or a name, such as /dev/ttyUSB0 or COM3".into());
    }
    Ok(Transport::Serial {
        path: path.into(),
        baud,
    })
}

fn tcp(text: &str) -> Result<Transport, String> {
    let (host, port) = text
        .rsplit_once(':')
        .ok_or_else(|| format!("`{text}` has no port; allowed: HOST:PORT, such as 192.168.1.7:1000"))?;
    let port = number(port, "port", &(1..=u64::from(u16::MAX)))? as u16;
    let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    match bare.unwrap_or(host) {
        "" => Err("names no host; allowed: a name or an address, IPv6 in brackets".into()),
        host if host.contains(['[', ']']) => Err(format!(
            "`{host}` has an extra bracket; allowed: a name or an address, IPv6 in brackets"
        )),
        host if bare.is_none() && host.contains(':') => Err(format!(
            "`{host}` has colons; allowed: a name or an address, IPv6 in brackets"
        )),
        host => Ok(Transport::Tcp {
            host: host.into(),
            port,
        }),
    }
}

fn number(text: &str, what: &str, allowed: &RangeInclusive<u64>) -> Result<u64, String> {
    let range = || format!("allowed: whole numbers from {} to {}", allowed.start(), allowed.end());
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    match text.parse::<u64>() {
        Ok(value) if digits && allowed.contains(&value) => Ok(value),
        Err(error) if *error.kind() == IntErrorKind::Empty => Err(format!("has an empty {what}; {}", range())),
        _ => Err(format!("`{text}` is no {what}; {}", range())),
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surrogate(seed) => write!(f, "surrogate:{seed}"),
            Self::Wire(wire) => wire.fmt(f),
        }
    }
}

impl fmt::Display for Wire {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain(transport) => transport.fmt(f),
            Self::Aseba { transport, node } => {
                let transport = transport.to_string();
                // A host may have a name that would be taken for a scheme.
                let is_plain = |place: &&str| !["serial:", "tcp:"].iter().any(|scheme| place.starts_with(scheme));
                let place = transport.strip_prefix("tcp:").filter(is_plain);
                write!(f, "aseba:{}", place.unwrap_or(&transport))?;
                node.map_or(Ok(()), |node| write!(f, "#{node}"))
            }
        }
    }
}

impl fmt::Display for Transport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path, baud: Some(baud) } => write!(f, "serial:{path}@{baud}"),
            Self::Serial { path, baud: None } => write!(f, "serial:{path}"),
            Self::Tcp { host, port } if host.contains(':') => write!(f, "tcp:[{host}]:{port}"),
            Self::Tcp { host, port } => write!(f, "tcp:{host}:{port}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_read_and_shown_as_it_was() {
        for text in [
            "serial:/dev/ttyUSB0",
            "serial:/dev/ttyUSB0@38400",
            "serial:COM3@9600",
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0@115200",
            "tcp:192.168.1.7:1000",
            "tcp:[fe80::1]:1000",
            "aseba:localhost:33333",
            "aseba:localhost:33333#2",
            "aseba:[::1]:33333",
            "aseba:tcp:serial:33333",
            "aseba:serial:/dev/ttyACM0",
            "aseba:serial:/dev/ttyACM0@115200#33084",
            "surrogate:7",
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
        assert_eq!(
            "aseba:serial:/dev/ttyACM0#2".parse::<Address>().unwrap(),
            Address::Wire(Wire::Aseba {
                transport: Transport::Serial {
                    path: "/dev/ttyACM0".into(),
                    baud: None
                },
                node: Some(2),
            })
        );
        let with_tcp = "aseba:tcp:localhost:33333#2".parse::<Address>().unwrap();
        assert_eq!(with_tcp, "aseba:localhost:33333#2".parse().unwrap());
        assert_eq!(
            "tcp:[::1]:33333".parse::<Address>().unwrap(),
            Address::Wire(Wire::Plain(Transport::Tcp {
                host: "::1".into(),
                port: 33333
            }))
        );
    }

    #[test]
    fn errors_name_the_wrong_part_and_what_is_allowed() {
        for (text, words) in [
            ("", "allowed: serial:PATH, serial:PATH@BAUD, tcp:HOST:PORT"),
            ("khepera", "does not say how to reach it; allowed: serial:PATH"),
            (
                "/dev/ttyUSB0",
                "does not say how to reach it; did you mean serial:/dev/ttyUSB0? (allowed: serial:PATH, ",
            ),
            ("ttyACM1", "did you mean serial:/dev/ttyACM1?"),
            ("COM3", "did you mean serial:COM3?"),
            (
                "192.168.1.7:1000",
                "`192.168.1.7` is no way to reach a robot; did you mean tcp:192.168.1.7:1000?",
            ),
            ("usb:x", "`usb` is no way to reach a robot; allowed: serial:PATH"),
            ("serial:", "names no port"),
            ("serial:@9600", "names no port"),
            (
                "serial:/dev/ttyUSB0@fast",
                "`fast` is no baud rate; allowed: whole numbers from 300 to 4000000",
            ),
            ("serial:/dev/ttyUSB0@+9600", "`+9600` is no baud rate"),
            ("serial:/dev/ttyUSB0@", "has an empty baud rate"),
            ("tcp:robot", "`robot` has no port"),
            ("tcp::1000", "names no host"),
            ("tcp:robot:0", "`0` is no port; allowed: whole numbers from 1 to 65535"),
            ("tcp:robot:99999999999999999999", "is no port"),
            ("tcp:fe80::1:1000", "`fe80::1` has colons"),
            ("tcp:[[fe80::1]]:1000", "`[fe80::1]` has an extra bracket"),
            ("tcp:[robot:1000", "`[robot` has an extra bracket"),
            ("aseba:robot", "`robot` has no port"),
            (
                "aseba:robot:33333#x",
                "`x` is no node; allowed: whole numbers from 1 to 65535",
            ),
            ("aseba:serial:", "names no port"),
            ("surrogate:-1", "`-1` is no seed; allowed: whole numbers from 0"),
        ] {
            let refusal = text.parse::<Address>().unwrap_err().to_string();
            assert!(refusal.starts_with(&format!("robot {text}: ")), "{refusal}");
            assert!(refusal.contains(words), "{refusal}");
        }
    }

    #[test]
    fn surrogates_are_offered_only_where_they_are_taken() {
        for text in ["", "khepera", "usb:1", "/dev/ttyUSB0", "surrogate"] {
            let refusal = text.parse::<Address>().unwrap_err().to_string();
            assert!(
                refusal.contains(", or surrogate:SEED for a simulated Khepera"),
                "{refusal}"
            );
            let refusal = text.parse::<Wire>().unwrap_err().to_string();
            assert!(
                refusal.contains("serial:PATH, ") && !refusal.contains("SEED"),
                "{refusal}"
            );
        }
        let refusal = "surrogate:1".parse::<Wire>().unwrap_err().to_string();
        assert!(
            refusal.starts_with("robot surrogate:1: a surrogate has no link; allowed: serial:PATH, "),
            "{refusal}"
        );
        assert!(!refusal.contains("SEED"), "{refusal}");
    }
}
