//! Links that carry bytes to a robot: serial ports and TCP. All waiting in drivers happens here, so a driver also runs
//! on a virtual clock, over a link that has one.

use std::fmt;
use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use serialport::{DataBits, FlowControl, Parity, SerialPort, SerialPortType, StopBits};

use super::error::{Error, Result};

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

/// A clock that never goes back.
pub trait Clock {
    /// Time since an arbitrary moment, the same for all links of the process.
    fn now(&self) -> Duration;
}

/// A link that carries bytes both ways.
pub trait Link: Clock + Send {
    /// The address, for messages.
    fn name(&self) -> &str;

    /// Waits for bytes and returns how many came. Returns 0 once `until` has passed, even if bytes wait.
    ///
    /// # Errors
    /// The link is lost.
    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize>;

    /// Takes bytes that have come already, and returns how many.
    ///
    /// # Errors
    /// The link is lost.
    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize>;

    /// Sends all bytes, at once where the link can: some robots need a whole command in one packet.
    ///
    /// # Errors
    /// The link is lost, or did not take them until `until`; some may be sent then.
    fn write(&mut self, bytes: &[u8], until: Duration) -> Result;

    /// How much later than over a cable an answer may come.
    fn delay(&self) -> Duration {
        Duration::ZERO
    }

    /// Closes the link and opens it again.
    ///
    /// # Errors
    /// It can't be opened.
    fn reopen(&mut self) -> Result;
}

/// TCP sends a lost packet again after 1 s at first (RFC 6298).
const NETWORK_DELAY: Duration = Duration::from_secs(1);
/// Most answers come within about 100 ms over Bluetooth, but GCtronic's driver for ROS waits for 10 s. A driving
/// program can't wait as long: this limit is ours.
const BLUETOOTH_DELAY: Duration = Duration::from_secs(2);
/// Of a serial port whose address gives none, where it doesn't matter.
const BAUD_RATE: u32 = 115_200;

/// Opens a link.
///
/// # Errors
/// The link can't be opened.
pub fn open(transport: &Transport) -> Result<Box<dyn Link>> {
    let name = transport.to_string();
    let mut link: Box<dyn Link> = match transport {
        Transport::Serial { path, baud } => Box::new(Serial {
            name,
            path: path.clone(),
            baud: baud.unwrap_or(BAUD_RATE),
            is_bluetooth: is_bluetooth(path),
            port: None,
        }),
        Transport::Tcp { host, port } => Box::new(Tcp {
            name,
            host: host.clone(),
            port: *port,
            stream: None,
        }),
    };
    link.reopen()?;
    Ok(link)
}

/// Sends bytes whose parts would put the other end out of step: then the link is lost.
///
/// # Errors
/// The link is lost.
pub(crate) fn send_whole(link: &mut dyn Link, bytes: &[u8], limit: Duration) -> Result {
    let until = link.now() + limit;
    link.write(bytes, until).map_err(|error| match error {
        Error::Unsent { .. } => Error::Disconnected {
            link: link.name().into(),
            cause: format!("nothing was sent for {} ms", limit.as_millis()),
        },
        error => error,
    })
}

/// A serial port of this machine.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Port {
    pub path: String,
    /// The system's description of it, if any.
    pub about: String,
    /// Number of the vendor of a USB device.
    pub(crate) vendor: Option<u16>,
    pub(crate) is_bluetooth: bool,
}

impl Port {
    fn new(path: String, kind: SerialPortType) -> Self {
        let vendor = match &kind {
            SerialPortType::UsbPort(usb) => Some(usb.vid),
            _ => None,
        };
        let is_bluetooth = kind == SerialPortType::BluetoothPort;
        let about = match kind {
            SerialPortType::UsbPort(usb) => {
                let product = usb.product.unwrap_or_default();
                let about = format!("USB {:04x}:{:04x} {product}", usb.vid, usb.pid);
                about.trim_end().into()
            }
            SerialPortType::BluetoothPort => "Bluetooth".into(),
            SerialPortType::PciPort => "built in".into(),
            SerialPortType::Unknown => String::new(),
        };
        Self {
            path,
            about,
            vendor,
            is_bluetooth,
        }
    }
}

/// Serial ports of this machine that could lead to a robot.
pub fn ports() -> Vec<Port> {
    let listed = serialport::available_ports().unwrap_or_default().into_iter();
    let mut ports: Vec<Port> = listed.map(|port| Port::new(port.port_name, port.port_type)).collect();
    // Bound Bluetooth channels, which the system lists among its terminals only.
    let terminals = fs::read_dir("/dev").into_iter().flatten().flatten();
    let channels = terminals.filter(|entry| entry.file_name().to_string_lossy().starts_with("rfcomm"));
    for path in channels.map(|entry| entry.path().display().to_string()) {
        ports.retain(|port| port.path != path);
        ports.push(Port::new(path, SerialPortType::BluetoothPort));
    }
    ports.sort();
    ports
}

/// Whether a path leads to a Bluetooth channel, if the system reports it.
pub(crate) fn is_bluetooth(path: &str) -> bool {
    let real = fs::canonicalize(path).map_or(path.into(), |path| path.display().to_string());
    ports().iter().any(|port| port.is_bluetooth && port.path == real)
}

/// The time on the clock of all links but those of tests.
pub(super) fn wall() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

fn closed() -> io::Error {
    io::Error::new(ErrorKind::NotConnected, "closed by the other end")
}

/// Calls until it is not interrupted; 0 if nothing comes in time.
fn patiently(mut read: impl FnMut() -> io::Result<usize>) -> io::Result<usize> {
    loop {
        match read() {
            Ok(0) => return Err(closed()),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => return Ok(0),
            other => return other,
        }
    }
}

/// Writes all bytes; `send` gets what is left and how long it may take.
fn all(
    name: &str,
    bytes: &[u8],
    until: Duration,
    mut send: impl FnMut(&[u8], Duration) -> io::Result<usize>,
) -> Result {
    let (start, mut sent) = (wall(), 0);
    while sent < bytes.len() {
        let left = until.saturating_sub(wall());
        if left.is_zero() {
            return Err(Error::Unsent {
                bytes: bytes.len(),
                limit: until.saturating_sub(start),
            });
        }
        match send(&bytes[sent..], left) {
            Ok(0) => return Err(Error::lost(name, &closed())),
            Ok(count) => sent += count,
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::Interrupted | ErrorKind::TimedOut | ErrorKind::WouldBlock
                ) => {}
            Err(error) => return Err(Error::lost(name, &error)),
        }
    }
    Ok(())
}

/// A serial port: 8 data bits, no parity, no flow control, DTR on. Two stop bits, which a Khepera wants (K-Team,
/// "Khepera II FAQ"); to a receiver that wants one, the second is a pause.
struct Serial {
    name: String,
    path: String,
    baud: u32,
    is_bluetooth: bool,
    port: Option<Box<dyn SerialPort>>,
}

impl Serial {
    fn port(&mut self) -> Result<&mut dyn SerialPort> {
        match &mut self.port {
            Some(port) => Ok(&mut **port),
            None => Err(Error::lost(&self.name, &closed())),
        }
    }

    fn take(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize> {
        let port = self.port()?;
        let taken = port
            .set_timeout(wait)
            .map_err(io::Error::from)
            .and_then(|()| patiently(|| port.read(buffer)));
        taken.map_err(|error| Error::lost(&self.name, &error))
    }
}

impl Clock for Serial {
    fn now(&self) -> Duration {
        wall()
    }
}

impl Link for Serial {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        match until.saturating_sub(wall()) {
            Duration::ZERO => Ok(0),
            wait => self.take(buffer, wait),
        }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.take(buffer, Duration::ZERO)
    }

    fn write(&mut self, bytes: &[u8], until: Duration) -> Result {
        let name = self.name.clone();
        let port = self.port()?;
        all(&name, bytes, until, |bytes, left| {
            port.set_timeout(left)?;
            port.write(bytes)
        })
    }

    fn delay(&self) -> Duration {
        if self.is_bluetooth {
            BLUETOOTH_DELAY
        } else {
            Duration::ZERO
        }
    }

    fn reopen(&mut self) -> Result {
        // A port is opened by one at a time.
        self.port = None;
        let port = serialport::new(&self.path, self.baud)
            .data_bits(DataBits::Eight)
            .parity(Parity::None)
            .stop_bits(StopBits::Two)
            .flow_control(FlowControl::None)
            .open();
        let mut port = port.map_err(|error| Error::Unavailable {
            link: self.name.clone(),
            // The system's words for files and other devices.
            cause: match error.to_string() {
                words if ["Not a typewriter", "Inappropriate ioctl for device"].contains(&words.as_str()) => {
                    "it is no serial port".to_owned()
                }
                words => words,
            },
            advice: match error.kind {
                serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
                    "your user needs the right to use serial ports: on Debian and Ubuntu, join the group dialout and \
                     log in again"
                }
                _ => "check the path and the cable, and that no other program has the port open",
            }
            .into(),
        })?;
        // A Thymio II is silent without DTR (its firmware). Pseudo-terminals have none.
        let _ = port.write_data_terminal_ready(true);
        self.port = Some(port);
        Ok(())
    }
}

/// A TCP connection. Every write leaves at once.
struct Tcp {
    name: String,
    host: String,
    port: u16,
    stream: Option<TcpStream>,
}

impl Tcp {
    /// A robot's radio may be asleep for a moment.
    const CONNECT: Duration = Duration::from_secs(3);

    fn stream(&self) -> Result<&TcpStream> {
        self.stream.as_ref().ok_or_else(|| Error::lost(&self.name, &closed()))
    }

    fn connected(&self) -> io::Result<TcpStream> {
        let mut last = io::Error::new(ErrorKind::NotFound, "the host has no address");
        for address in (self.host.as_str(), self.port).to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, Self::CONNECT) {
                Ok(stream) => return stream.set_nodelay(true).map(|()| stream),
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

impl Clock for Tcp {
    fn now(&self) -> Duration {
        wall()
    }
}

impl Link for Tcp {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let mut stream = self.stream()?;
        let wait = until.saturating_sub(wall());
        if wait.is_zero() {
            return Ok(0);
        }
        let taken = stream
            .set_read_timeout(Some(wait))
            .and_then(|()| patiently(|| stream.read(buffer)));
        taken.map_err(|error| Error::lost(&self.name, &error))
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let mut stream = self.stream()?;
        let taken = stream
            .set_nonblocking(true)
            .and_then(|()| patiently(|| stream.read(buffer)));
        let taken = taken.and_then(|count| stream.set_nonblocking(false).map(|()| count));
        taken.map_err(|error| Error::lost(&self.name, &error))
    }

    fn write(&mut self, bytes: &[u8], until: Duration) -> Result {
        let mut stream = self.stream()?;
        all(&self.name, bytes, until, |bytes, left| {
            stream.set_write_timeout(Some(left))?;
            stream.write(bytes)
        })
    }

    fn delay(&self) -> Duration {
        NETWORK_DELAY
    }

    fn reopen(&mut self) -> Result {
        self.stream = None;
        let stream = self.connected().map_err(|error| Error::Unavailable {
            link: self.name.clone(),
            cause: error.to_string(),
            advice: "check the host and the port, that the robot is in the same network, and that no other program is \
                     connected to it"
                .into(),
        })?;
        self.stream = Some(stream);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;
    use crate::address::Wire;

    const LONG: Duration = Duration::from_secs(10);

    fn pair() -> (Box<dyn Link>, TcpStream, TcpListener) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let host = "127.0.0.1".into();
        let link = open(&Transport::Tcp { host, port }).unwrap();
        let (peer, _) = listener.accept().unwrap();
        (link, peer, listener)
    }

    #[test]
    fn tcp_carries_bytes_waits_and_ends() {
        let (mut link, mut peer, _listener) = pair();
        let mut buffer = [0; 16];
        assert_eq!(link.waiting(&mut buffer).unwrap(), 0);
        let until = link.now() + Duration::from_millis(30);
        assert_eq!(link.read(&mut buffer, until).unwrap(), 0);
        assert!(link.now() >= until);

        peer.write_all(b"abc").unwrap();
        let until = link.now() + LONG;
        assert_eq!(link.read(&mut buffer, until).unwrap(), 3);
        link.write(b"defg", until).unwrap();
        peer.read_exact(&mut buffer[..4]).unwrap();
        assert_eq!(&buffer[..4], b"defg");

        // Bytes that come after the time given are left for later.
        peer.write_all(b"h").unwrap();
        assert_eq!(link.read(&mut buffer, Duration::ZERO).unwrap(), 0);
        assert_eq!(link.read(&mut buffer, until).unwrap(), 1);

        drop(peer);
        assert!(matches!(
            link.read(&mut buffer, until),
            Err(Error::Disconnected { cause, .. }) if cause.contains("closed by the other end")
        ));
    }

    /// The buffers of both ends are filled first; they have no size that this test could know.
    #[test]
    fn a_peer_that_reads_nothing_does_not_hold_the_writer() {
        let (mut link, _peer, _listener) = pair();
        let megabyte = vec![0; 1 << 20];
        let start = link.now();
        let refused = (0..64).find_map(|_| {
            let until = link.now() + Duration::from_millis(50);
            link.write(&megabyte, until).err()
        });
        assert!(matches!(refused, Some(Error::Unsent { .. })));
        assert!(link.now() < start + LONG);
    }

    #[test]
    fn a_link_is_opened_again() {
        let (mut link, peer, listener) = pair();
        drop(peer);
        link.reopen().unwrap();
        let (mut peer, _) = listener.accept().unwrap();
        peer.write_all(b"x").unwrap();
        let until = link.now() + LONG;
        assert_eq!(link.read(&mut [0; 4], until).unwrap(), 1);
        drop((peer, listener));
        assert!(matches!(link.reopen(), Err(Error::Unavailable { .. })));
        assert!(matches!(link.waiting(&mut [0]), Err(Error::Disconnected { .. })));
    }

    /// A pseudo-terminal: bytes both ways, a read that ends in time, and the other end gone.
    #[test]
    #[cfg(unix)]
    fn a_serial_port_carries_bytes_waits_and_ends() {
        let (mut peer, port) = serialport::TTYPort::pair().unwrap();
        let path = port.name().unwrap();
        drop(port);
        let baud = Some(38_400);
        let mut link = open(&Transport::Serial { path, baud }).unwrap();
        let mut buffer = [0; 16];
        assert_eq!(link.waiting(&mut buffer).unwrap(), 0);
        let until = link.now() + Duration::from_millis(30);
        assert_eq!(link.read(&mut buffer, until).unwrap(), 0);
        assert!(link.now() >= until);

        peer.write_all(b"n,1\r\n").unwrap();
        let until = link.now() + LONG;
        assert_eq!(link.read(&mut buffer, until).unwrap(), 5);
        assert_eq!(&buffer[..5], b"n,1\r\n");
        link.write(b"N\r", until).unwrap();
        peer.read_exact(&mut buffer[..2]).unwrap();
        assert_eq!(&buffer[..2], b"N\r");

        link.reopen().unwrap();
        peer.write_all(b"x").unwrap();
        assert_eq!(link.read(&mut buffer, until).unwrap(), 1);
        // A peer that reads nothing does not hold the writer.
        let start = link.now();
        let refused = (0..1000).find_map(|_| {
            let until = link.now() + Duration::from_millis(20);
            link.write(&[0; 1024], until).err()
        });
        assert!(matches!(refused, Some(Error::Unsent { .. })));
        assert!(link.now() < start + LONG);
        drop(peer);
        assert!(matches!(link.read(&mut buffer, until), Err(Error::Disconnected { .. })));
    }

    #[test]
    fn ports_say_what_the_system_knows() {
        let usb = |vid, product: Option<&str>| {
            let (pid, manufacturer, serial_number) = (0x000a, None, None);
            SerialPortType::UsbPort(serialport::UsbPortInfo {
                vid,
                pid,
                serial_number,
                manufacturer,
                product: product.map(Into::into),
            })
        };
        for (kind, about, address, is_bluetooth) in [
            (
                usb(0x0617, Some("Thymio-II")),
                "USB 0617:000a Thymio-II",
                "aseba:serial:/dev/x",
                false,
            ),
            (usb(0x0403, None), "USB 0403:000a", "serial:/dev/x", false),
            (SerialPortType::BluetoothPort, "Bluetooth", "serial:/dev/x", true),
            (SerialPortType::Unknown, "", "serial:/dev/x", false),
        ] {
            let port = Port::new("/dev/x".into(), kind);
            assert_eq!(
                (&port.about[..], &Wire::at(&port).to_string()[..], port.is_bluetooth),
                (about, address, is_bluetooth)
            );
        }
    }

    #[test]
    fn what_can_not_be_opened_says_what_to_do() {
        let path = "/dev/there is no such port".into();
        let refusal = open(&Transport::Serial { path, baud: None }).err().unwrap();
        let words = refusal.to_string();
        assert!(
            words.starts_with("serial:/dev/there is no such port: can't be opened: "),
            "{words}"
        );
        assert!(words.ends_with("no other program has the port open"), "{words}");
    }
}
