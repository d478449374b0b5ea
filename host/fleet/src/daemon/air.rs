//! Carriers of datagrams to and from a robot's daemon: UDP sockets, or a test's emulated air.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};

use oneiro_base::exit::Failure;
use oneiro_lab::exchange::radio;

/// Whom a datagram is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Other robots and the operator.
    Radio,
    /// The tracker.
    Tracker,
}

/// Carries datagrams, and may lose some.
pub trait Air: Send {
    /// Sends a datagram to all other robots and to the operator.
    fn send(&mut self, datagram: &[u8]);

    /// Returns the next datagram that has come, if one has.
    fn receive(&mut self) -> Option<(Channel, Vec<u8>)>;

    /// What has been lost on this side so far.
    fn losses(&self) -> Losses {
        Losses::default()
    }
}

/// How many datagrams were lost on this side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Not sent to a peer: its address can't be reached, or the system's buffer was full.
    pub(crate) unsent: u64,
    /// Longer than any that is valid.
    pub too_long: u64,
    /// System errors instead of a datagram.
    pub errors: u64,
}

/// UDP sockets. Nothing waits.
#[derive(Debug)]
pub struct Sockets {
    radio: UdpSocket,
    peers: Vec<SocketAddr>,
    tracker: Option<UdpSocket>,
    /// Whose turn it is, and how many have had theirs since [`Air::receive`] returned none.
    turn: Channel,
    in_a_row: u32,
    losses: Losses,
}

/// The longest datagram of a tracker, in bytes: several lines.
const LONGEST_LINES: usize = 2048;

impl Sockets {
    /// Maximum datagrams received in a row, so that a flood ends. Ten times a second it is more than are authenticated.
    const IN_A_ROW: u32 = 256;

    /// Listens at an address for robots and the operator, who are at `peers` (also a broadcast address), and at another
    /// one for the tracker. Names of hosts are looked up once, now.
    ///
    /// # Errors
    /// Exit 3, with the key of the robots' settings: nobody can listen at an address, or a peer has none.
    pub fn open(listen: &str, peers: &[String], tracker: Option<&str>) -> Result<Self, Failure> {
        let radio = bind("radio.listen", listen)?;
        let refused = |error| refused("radio.listen", listen, &error);
        radio.set_broadcast(true).map_err(refused)?;
        let local = radio.local_addr().map_err(refused)?;
        let address = |peer: &String| {
            let missing = || io::Error::new(ErrorKind::NotFound, "the host has no address that this one can send to");
            let addresses = peer.to_socket_addrs();
            addresses
                .and_then(|mut all| {
                    all.find(|address| address.is_ipv4() == local.is_ipv4())
                        .ok_or_else(missing)
                })
                .map_err(|error| self::refused("radio.peers", peer, &error))
        };
        Ok(Self {
            peers: peers.iter().map(address).collect::<Result<_, _>>()?,
            tracker: tracker.map(|listen| bind("tracker.listen", listen)).transpose()?,
            radio,
            turn: Channel::Radio,
            in_a_row: 0,
            losses: Losses::default(),
        })
    }

    /// Takes what has come on a channel; none if nothing has, or what has come is no datagram.
    fn take(&mut self, channel: Channel) -> Taken {
        let (socket, longest) = match channel {
            Channel::Radio => (Some(&self.radio), radio::LONGEST),
            Channel::Tracker => (self.tracker.as_ref(), LONGEST_LINES),
        };
        let Some(socket) = socket else {
            return Taken::Nothing;
        };
        // The rest of a longer one is cut off.
        let mut buffer = [0; LONGEST_LINES + 1];
        match socket.recv(&mut buffer[..=longest]) {
            Ok(count) if count <= longest => return Taken::Datagram(buffer[..count].to_vec()),
            Ok(_) => self.losses.too_long += 1,
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Taken::Nothing,
            Err(error) if is_too_long(&error) => self.losses.too_long += 1,
            Err(_) => self.losses.errors += 1,
        }
        Taken::Loss
    }
}

/// What a socket had.
enum Taken {
    Datagram(Vec<u8>),
    /// A datagram that is lost, or an error.
    Loss,
    Nothing,
}

/// Windows reports what others cut off.
fn is_too_long(error: &io::Error) -> bool {
    const WSAEMSGSIZE: i32 = 10040;
    cfg!(windows) && error.raw_os_error() == Some(WSAEMSGSIZE)
}

fn bind(key: &str, address: &str) -> Result<UdpSocket, Failure> {
    let open = || {
        let socket = UdpSocket::bind(address)?;
        socket.set_nonblocking(true)?;
        Ok(socket)
    };
    open().map_err(|error| refused(key, address, &error))
}

fn refused(key: &str, address: &str, error: &io::Error) -> Failure {
    Failure::input(format_args!(
        "{key}: \"{address}\": {error}; allowed: HOST:PORT, such as 0.0.0.0:4711, with a host and a port that this computer can use"
    ))
}

impl Air for Sockets {
    fn send(&mut self, datagram: &[u8]) {
        for peer in &self.peers {
            let sent = self.radio.send_to(datagram, peer);
            self.losses.unsent += u64::from(sent.is_err());
        }
    }

    /// Robots and the tracker take turns.
    fn receive(&mut self) -> Option<(Channel, Vec<u8>)> {
        let mut nothing = 0;
        while self.in_a_row < Self::IN_A_ROW && nothing < 2 {
            let channel = self.turn;
            self.turn = match channel {
                Channel::Radio => Channel::Tracker,
                Channel::Tracker => Channel::Radio,
            };
            let taken = self.take(channel);
            if matches!(taken, Taken::Nothing) {
                nothing += 1;
                continue;
            }
            nothing = 0;
            self.in_a_row += 1;
            if let Taken::Datagram(bytes) = taken {
                return Some((channel, bytes));
            }
        }
        self.in_a_row = 0;
        None
    }

    fn losses(&self) -> Losses {
        self.losses
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::{Duration, Instant};

    use super::*;

    /// Waits until something is so.
    fn within_10_s(mut is_so: impl FnMut() -> bool) {
        let start = Instant::now();
        while !is_so() {
            assert!(start.elapsed() < Duration::from_secs(10));
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// The next datagrams that come.
    fn all(air: &mut Sockets, count: usize) -> Vec<(Channel, Vec<u8>)> {
        let mut all = Vec::new();
        within_10_s(|| {
            all.extend(std::iter::from_fn(|| air.receive()));
            all.len() >= count
        });
        all
    }

    fn open(peers: &[SocketAddr], tracker: Option<&str>) -> Sockets {
        let peers: Vec<String> = peers.iter().map(ToString::to_string).collect();
        Sockets::open("127.0.0.1:0", &peers, tracker).unwrap()
    }

    fn sender() -> UdpSocket {
        UdpSocket::bind("127.0.0.1:0").unwrap()
    }

    #[test]
    fn datagrams_go_to_all_peers_and_come_from_two_channels() {
        let (one, two) = (open(&[], None), open(&[], None));
        let peers = [&one, &two].map(|air| air.radio.local_addr().unwrap());
        let mut air = open(&peers, Some("127.0.0.1:0"));
        air.send(b"to all");
        for mut air in [one, two] {
            assert_eq!(all(&mut air, 1), [(Channel::Radio, b"to all".to_vec())]);
            assert_eq!(air.receive(), None);
        }
        let (radio, tracker) = (
            air.radio.local_addr().unwrap(),
            air.tracker.as_ref().unwrap().local_addr().unwrap(),
        );
        let sender = sender();
        sender.send_to(b"a robot", radio).unwrap();
        sender.send_to(&[7; LONGEST_LINES], tracker).unwrap();
        sender.send_to(&[], radio).unwrap();
        let heard = all(&mut air, 3);
        assert!(
            heard.contains(&(Channel::Radio, b"a robot".to_vec())) && heard.contains(&(Channel::Radio, Vec::new()))
        );
        assert!(heard.contains(&(Channel::Tracker, vec![7; LONGEST_LINES])));
        assert_eq!((air.receive(), air.losses()), (None, Losses::default()));
    }

    /// Invalid datagrams are dropped, unsent ones are counted, and a flood on one channel ends so that the other has
    /// its turn.
    #[test]
    fn nothing_that_comes_stops_or_holds_the_air() {
        let mut air = open(&[], Some("127.0.0.1:0"));
        let (radio, tracker) = (
            air.radio.local_addr().unwrap(),
            air.tracker.as_ref().unwrap().local_addr().unwrap(),
        );
        let sender = sender();
        for count in [radio::LONGEST + 1, 1000, 60_000] {
            sender.send_to(&vec![1; count], radio).unwrap();
        }
        sender.send_to(&[2; LONGEST_LINES + 1], tracker).unwrap();
        sender.send_to(&[3; radio::LONGEST], radio).unwrap();
        assert_eq!(all(&mut air, 1), [(Channel::Radio, vec![3; radio::LONGEST])]);
        within_10_s(|| {
            assert_eq!(air.receive(), None);
            air.losses().too_long == 4
        });
        for _ in 0..100 {
            sender.send_to(b"flood", radio).unwrap();
        }
        sender.send_to(b"pose", tracker).unwrap();
        within_10_s(|| air.tracker.as_ref().unwrap().peek(&mut [0; 8]).is_ok());
        let heard = all(&mut air, 101);
        let place = heard.iter().position(|(channel, _)| *channel == Channel::Tracker);
        assert!(
            place.is_some_and(|place| place < 100) && heard.len() == 101,
            "{place:?} {}",
            heard.len()
        );
        // A flood without an end: there is always another one, and still an end.
        let mut in_a_row = 0;
        loop {
            sender.send_to(b"flood", radio).unwrap();
            sender.send_to(b"flood", radio).unwrap();
            match air.receive() {
                Some(_) => in_a_row += 1,
                None if in_a_row > 0 => break,
                None => {}
            }
            assert!(in_a_row <= Sockets::IN_A_ROW, "{in_a_row}");
        }
        // Unsent datagrams are counted for each peer. Where nobody listens, some systems report it at the next
        // reception.
        let mut air = open(
            &["127.0.0.1:9".parse().unwrap(), "255.255.255.255:0".parse().unwrap()],
            None,
        );
        air.send(b"a");
        air.send(b"b");
        assert!(air.losses().unsent >= 2, "{:?}", air.losses());
        assert_eq!(air.receive(), None);
    }

    #[test]
    fn addresses_that_can_t_be_used_are_refused_by_their_keys() {
        let peers = |peer: &str| Sockets::open("127.0.0.1:0", &[peer.to_owned()], None);
        for (refusal, key) in [
            (Sockets::open("127.0.0.1", &[], None), "radio.listen: \"127.0.0.1\""),
            (
                Sockets::open("192.0.2.1:4711", &[], None),
                "radio.listen: \"192.0.2.1:4711\"",
            ),
            (peers("127.0.0.1:70000"), "radio.peers: \"127.0.0.1:70000\""),
            (peers("[::1]:4711"), "radio.peers: \"[::1]:4711\""),
            (
                Sockets::open("127.0.0.1:0", &[], Some("127.0.0.1:x")),
                "tracker.listen: \"127.0.0.1:x\"",
            ),
        ] {
            let refusal = refusal.unwrap_err();
            assert_eq!(refusal.code(), 3);
            assert!(refusal.to_string().starts_with(key), "{refusal}");
        }
    }
}
