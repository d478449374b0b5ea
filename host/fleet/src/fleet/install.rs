//! What a robot's computer gets: the program, the experiment, `robot.toml`, the key, and a unit of systemd.

use std::path::Path;

use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::files;
use oneiro_lab::exchange::radio::key::Key;
use serde::Serialize;

use super::file::{BINARY, Computers, KEY, ROBOT, Robot};
use super::remote::Remote;
use super::{service, sha256_hex};

/// A file of a robot's directory.
#[derive(Clone, Debug)]
pub struct Parcel<'a> {
    /// Its path below that directory.
    pub name: &'a str,
    /// Its permissions, as `chmod` takes them.
    mode: &'static str,
    pub bytes: &'a [u8],
}

/// Files of this machine that all robots get.
#[derive(Debug)]
pub struct Stock {
    binary: Vec<u8>,
    machine: Machine,
    /// The key of a swarm's experiment.
    key: Option<Vec<u8>>,
}

/// What came of a robot's installation.
#[derive(Debug, Serialize)]
pub struct Installed {
    /// Files that were sent; the others were there.
    pub sent: Vec<String>,
    pub bytes: usize,
    /// What a person should know.
    pub warnings: Vec<String>,
}

impl Stock {
    /// Reads the program and the key, if the fleet has one.
    ///
    /// # Errors
    /// Exit 3: one is missing, the program is not one for Linux, or the key is none.
    pub fn read(fleet: &Computers, key: Option<&Path>) -> Result<Self> {
        let binary = files::bytes(&fleet.binary)?;
        let machine = Machine::of(&binary).ok_or_else(|| {
            let path = fleet.binary.display();
            Failure::input(format_args!(
                "{path}: is no program for Linux (ELF); allowed: oneiro for the robots' computers"
            ))
        })?;
        let read = |path: &Path| Key::read(path).and_then(|_| files::bytes(path));
        let key = key.map(read).transpose()?;
        Ok(Self { binary, machine, key })
    }

    /// The files of a robot.
    pub fn parcels<'a>(&'a self, robot: &'a Robot) -> Vec<Parcel<'a>> {
        let parcel = |name, mode, bytes| Parcel { name, mode, bytes };
        let files = robot.files.iter().map(|(name, bytes)| parcel(name, "644", bytes));
        let key = self.key.as_ref().map(|key| parcel(KEY, "600", key));
        std::iter::once(parcel(BINARY, "755", &self.binary))
            .chain(files)
            .chain([parcel(ROBOT, "644", robot.toml.as_bytes())])
            .chain(key)
            .collect()
    }

    /// Installs a robot. Files that are there already are not sent again.
    ///
    /// # Errors
    /// Exit 4: the computer can't be reached, its processor is not the program's, or a command there fails.
    pub fn install(&self, fleet: &Computers, robot: &Robot, remote: Remote<'_>) -> Result<Installed> {
        let place = fleet.place(robot);
        let parcels = self.parcels(robot);
        let there = Computer::ask(remote, &place, &parcels)?;
        if !self.machine.runs_on(&there.machine, there.bits) {
            let (ours, bits) = (self.machine.words(), there.bits);
            let problem = format!(
                "its processor is {} ({bits} bits), and {} is for {ours}",
                there.machine,
                fleet.binary.display()
            );
            return Err(Failure::of(Code::Device, problem));
        }
        let mut installed = Installed {
            sent: Vec::new(),
            bytes: 0,
            warnings: Vec::new(),
        };
        for parcel in parcels {
            if !there.has(&parcel) {
                let path = format!("{place}/{}", parcel.name);
                let (folder, name) = path.rsplit_once('/').unwrap_or_default();
                remote.put(folder, name, parcel.mode, parcel.bytes)?;
                installed.sent.push(parcel.name.into());
                installed.bytes += parcel.bytes.len();
            }
        }
        let directory = format!("{}/{place}", there.home);
        let directory = if place.starts_with('/') { &place } else { &directory };
        installed.warnings = service::install(fleet, robot, remote, directory, &there.user)?;
        if robot.address.contains("serial:") && !there.groups.iter().any(|group| PORTS.contains(&&**group)) {
            let user = &there.user;
            let warning = format!("{user} may not open serial ports: sudo usermod -aG dialout {user}");
            installed.warnings.push(warning);
        }
        let (state, _) = service::state(fleet, robot, remote)?;
        if state == service::ServiceState::Running && !installed.sent.is_empty() {
            installed
                .warnings
                .push("runs its earlier files until `oneiro fleet stop` and `start`".into());
        }
        Ok(installed)
    }
}

/// Groups that serial ports belong to, and root.
const PORTS: [&str; 3] = ["dialout", "uucp", "root"];

/// A robot computer's description of itself.
#[derive(Debug)]
struct Computer {
    machine: String,
    bits: u32,
    home: String,
    user: String,
    groups: Vec<String>,
    /// Hashes and names of files that are there.
    files: Vec<(String, String)>,
}

impl Computer {
    /// Asks a computer.
    fn ask(remote: Remote<'_>, place: &str, parcels: &[Parcel<'_>]) -> Result<Self> {
        let names: Vec<&str> = parcels.iter().map(|parcel| parcel.name).collect();
        let names = names.join(" ");
        let text = remote.text(&format!(
            "command -v sha256sum >/dev/null || {{ echo it has no sha256sum >&2; exit 1; }}; uname -sm; \
             getconf LONG_BIT 2>/dev/null || echo 0; pwd; id -un; id -Gn; \
             cd {place} 2>/dev/null && sha256sum {names} 2>/dev/null; true"
        ))?;
        let mut lines = text.lines();
        let mut next = || lines.next().unwrap_or_default().trim().to_owned();
        let (system, bits, home, user, groups) = (next(), next(), next(), next(), next());
        let Some(machine) = system.strip_prefix("Linux ") else {
            return Err(Failure::of(
                Code::Device,
                format_args!("it runs {system}; allowed: Linux"),
            ));
        };
        let file = |line: &str| {
            line.split_once(' ')
                .map(|(hash, name)| (hash.to_owned(), name.trim().to_owned()))
        };
        Ok(Self {
            machine: machine.to_owned(),
            bits: bits.parse().unwrap_or(0),
            home,
            user,
            groups: groups.split(' ').map(str::to_owned).collect(),
            files: lines.filter_map(file).collect(),
        })
    }

    /// Whether a file is there already.
    fn has(&self, parcel: &Parcel<'_>) -> bool {
        let known = self.files.iter().find(|(_, name)| name == parcel.name);
        known.is_some_and(|(hash, _)| *hash == sha256_hex(parcel.bytes))
    }
}

/// The processor that a program is for, by its ELF header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Machine {
    /// 32 or 64.
    bits: u32,
    /// `e_machine` of the header.
    number: u16,
}

impl Machine {
    /// Numbers of processors in ELF headers, their names, and how the first letters of `uname -m` begin there.
    const KNOWN: [(u16, &str, &[&str]); 5] = [
        (3, "32-bit x86", &["i386", "i486", "i586", "i686"]),
        (40, "32-bit ARM", &["armv"]),
        (62, "64-bit x86", &["x86_64"]),
        (183, "64-bit ARM", &["aarch64", "arm64"]),
        (243, "RISC-V", &["riscv"]),
    ];

    /// Of a program's bytes, unless they are no ELF file of little-endian words.
    fn of(bytes: &[u8]) -> Option<Self> {
        let head: &[u8; 20] = bytes.first_chunk()?;
        let bits = match head {
            [0x7f, b'E', b'L', b'F', 1, 1, ..] => 32,
            [0x7f, b'E', b'L', b'F', 2, 1, ..] => 64,
            _ => return None,
        };
        let number = u16::from_le_bytes([head[18], head[19]]);
        Some(Self { bits, number })
    }

    fn words(self) -> String {
        let known = Self::KNOWN.iter().find(|(number, ..)| *number == self.number);
        known.map_or_else(
            || format!("processor {}", self.number),
            |(_, name, _)| (*name).to_owned(),
        )
    }

    /// Returns whether it runs where `uname -m` prints `machine` and programs have `bits` bits, 0 if that is not known.
    fn runs_on(self, machine: &str, bits: u32) -> bool {
        let is = |number: u16| {
            let known = Self::KNOWN.iter().find(|(known, ..)| *known == number);
            known.is_some_and(|(_, _, names)| names.iter().any(|name| machine.starts_with(name)))
        };
        // A system of 32 bits on a processor of 64.
        let is_small = self.bits == 32 && bits == 32 && (self.number == 40 && is(183) || self.number == 3 && is(62));
        is_small || is(self.number) && (bits == 0 || self.bits == bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(class: u8, machine: u16) -> Vec<u8> {
        let mut bytes = vec![0x7f, b'E', b'L', b'F', class, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0];
        bytes.extend_from_slice(&machine.to_le_bytes());
        bytes
    }

    #[test]
    fn programs_are_for_the_processor_that_their_header_names() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let machine = Machine::of(&program).unwrap();
        assert!(machine.runs_on(std::env::consts::ARCH, usize::BITS), "{machine:?}");
        let of = |class, machine| Machine::of(&header(class, machine)).unwrap();
        for (machine, name, bits, runs) in [
            (of(2, 183), "aarch64", 64, true),
            (of(2, 183), "aarch64", 32, false),
            (of(1, 40), "aarch64", 32, true),
            (of(1, 40), "aarch64", 64, false),
            (of(1, 40), "armv7l", 32, true),
            (of(2, 183), "armv7l", 32, false),
            (of(2, 62), "aarch64", 64, false),
            (of(2, 62), "x86_64", 0, true),
            (of(1, 3), "x86_64", 32, true),
            (of(2, 999), "x86_64", 64, false),
        ] {
            assert_eq!(machine.runs_on(name, bits), runs, "{machine:?} on {name}, {bits}");
        }
        let mut big = header(2, 183);
        big[5] = 2;
        for none in [&big[..], b"#!/bin/sh\nexit 0\n   ", &header(2, 183)[..19], b""] {
            assert_eq!(Machine::of(none), None);
        }
    }
}
