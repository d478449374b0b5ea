//! The daemon's messages to systemd (`sd_notify(3)`): ready, alive, stopping. One datagram each to the socket in
//! `NOTIFY_SOCKET`; without that variable, nothing is sent.

use std::env;
use std::ffi::OsStr;
#[cfg(target_os = "linux")]
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};

/// The connection to systemd, if it has started this process and expects messages.
#[derive(Debug)]
pub(crate) struct Notify {
    socket: Option<(UnixDatagram, SocketAddr)>,
}

impl Notify {
    /// From the environment.
    pub(crate) fn of_environment() -> Self {
        Self::new(env::var_os("NOTIFY_SOCKET").as_deref())
    }

    /// From the value of `NOTIFY_SOCKET`. An unusable socket counts as none: the daemon also works without systemd.
    fn new(socket: Option<&OsStr>) -> Self {
        Self {
            socket: socket.and_then(open_socket),
        }
    }

    /// The wheels stand, and all is ready for the experiment.
    pub(crate) fn ready(&self) {
        self.send("READY=1");
    }

    /// The control thread is alive. Sent once a second, several times per `WatchdogSec` of the daemon's unit.
    pub(crate) fn watchdog(&self) {
        self.send("WATCHDOG=1");
    }

    /// It ends on purpose.
    pub(crate) fn stopping(&self) {
        self.send("STOPPING=1");
    }

    /// One line for `systemctl status`.
    pub(crate) fn status(&self, words: &str) {
        self.send(&format!("STATUS={}", words.replace('\n', " ")));
    }

    /// Sends without waiting. If systemd doesn't take it, there is nobody else to tell.
    fn send(&self, message: &str) {
        if let Some((socket, systemd)) = &self.socket {
            let _ = socket.send_to_addr(message.as_bytes(), systemd);
        }
    }
}

/// A socket for the address of systemd's: a path, or a name that begins with `@`.
fn open_socket(name: &OsStr) -> Option<(UnixDatagram, SocketAddr)> {
    let address = match name.as_bytes() {
        #[cfg(target_os = "linux")]
        [b'@', name @ ..] => SocketAddr::from_abstract_name(name).ok()?,
        [b'/', ..] => SocketAddr::from_pathname(name).ok()?,
        _ => return None,
    };
    let socket = UnixDatagram::unbound().ok()?;
    socket.set_nonblocking(true).ok()?;
    Some((socket, address))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::fs;

    use super::*;

    fn heard(socket: &UnixDatagram) -> String {
        let mut bytes = [0; 256];
        let length = socket.recv(&mut bytes).unwrap();
        String::from_utf8(bytes[..length].to_vec()).unwrap()
    }

    #[test]
    fn systemd_hears_each_message_at_a_path_and_at_a_name() {
        let path = env::temp_dir().join(format!("oneiro-notify-{}", std::process::id()));
        let name = format!("oneiro-notify-{}", std::process::id());
        let at_path = UnixDatagram::bind(&path).unwrap();
        let abstract_name = SocketAddr::from_abstract_name(&name).unwrap();
        let at_name = UnixDatagram::bind_addr(&abstract_name).unwrap();
        for (systemd, address) in [
            (&at_path, path.as_os_str().to_owned()),
            (&at_name, format!("@{name}").into()),
        ] {
            let notify = Notify::new(Some(&address));
            notify.ready();
            notify.watchdog();
            notify.status("two\nlines");
            notify.stopping();
            let all: Vec<String> = (0..4).map(|_| heard(systemd)).collect();
            assert_eq!(all, ["READY=1", "WATCHDOG=1", "STATUS=two lines", "STOPPING=1"]);
        }
        fs::remove_file(path).unwrap();
    }

    /// A socket whose reader is gone, or has more in its queue than fits, must not hold the control thread.
    #[test]
    fn nobody_waits_for_systemd() {
        let path = env::temp_dir().join(format!("oneiro-notify-full-{}", std::process::id()));
        let systemd = UnixDatagram::bind(&path).unwrap();
        let notify = Notify::new(Some(path.as_os_str()));
        for _ in 0..10_000 {
            notify.watchdog();
        }
        assert_eq!(heard(&systemd), "WATCHDOG=1");
        drop(systemd);
        notify.watchdog();
        fs::remove_file(path).unwrap();
        notify.watchdog();
        Notify::new(None).ready();
        Notify::new(Some(OsStr::new("relative"))).ready();
    }
}
