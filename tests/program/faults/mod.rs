//! A failing disk: a small library, preloaded into the program, makes its calls to the disk fail.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::place::Place;

/// Ways for a call to fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Fails with an I/O error.
    Broken,
    /// Fails because the disk is full.
    Full,
    /// A write takes half of its bytes, and the next one fails because the disk is full.
    Short,
    /// Kills the process instead.
    Kill,
}

impl Fault {
    fn word(self) -> &'static str {
        match self {
            Self::Broken => "EIO",
            Self::Full => "ENOSPC",
            Self::Short => "SHORT",
            Self::Kill => "KILL",
        }
    }
}

/// A call that failed.
#[derive(Clone, Debug)]
pub(crate) struct Failed {
    /// Name of the call, such as `rename`.
    pub(crate) call: String,
    pub(crate) path: PathBuf,
}

/// The library, for calls below one directory.
pub(crate) struct Faults {
    preloaded: PathBuf,
    below: PathBuf,
    report: PathBuf,
}

impl Faults {
    /// Builds the library with the linker that Rust needs, too.
    pub(crate) fn below(place: &Place, directory: &Path) -> Self {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/program/faults/faults.c");
        let preloaded = place.at("faults.so");
        let built = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([&preloaded, &source])
            .arg("-ldl")
            .output()
            .expect("cc");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        Self {
            preloaded,
            below: directory.to_owned(),
            report: place.at("failed"),
        }
    }

    /// Makes the call with that number, from 1 on, fail.
    pub(crate) fn at(&self, mut command: Command, number: u32, fault: Fault) -> Command {
        self.load(&mut command)
            .env("FAULTS_AT", number.to_string())
            .env("FAULTS_KIND", fault.word());
        command
    }

    /// Makes all calls fail for files whose path ends with this.
    pub(crate) fn named(&self, mut command: Command, name: &str, fault: Fault) -> Command {
        self.load(&mut command)
            .env("FAULTS_NAME", name)
            .env("FAULTS_KIND", fault.word());
        command
    }

    /// Runs a command of which no call fails, and returns how many there were.
    pub(crate) fn counted(&self, mut command: Command) -> (Output, u32) {
        let count = self.report.with_extension("count");
        let output = self.load(&mut command).env("FAULTS_COUNT", &count).output().unwrap();
        let calls = fs::read_to_string(&count).map_or(0, |count| count.parse().unwrap());
        (output, calls)
    }

    /// Makes no call fail, but skips waiting for the disk.
    pub(crate) fn none(&self, mut command: Command) -> Command {
        self.load(&mut command);
        command
    }

    /// Simulates a disk with room for `bytes` bytes.
    pub(crate) fn space(&self, mut command: Command, bytes: u64) -> Command {
        self.load(&mut command).env("FAULTS_SPACE", bytes.to_string());
        command
    }

    fn load<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        let _ = fs::remove_file(&self.report);
        command
            .env("LD_PRELOAD", &self.preloaded)
            .env("FAULTS_BELOW", &self.below)
            .env("FAULTS_REPORT", &self.report)
    }

    /// The call that failed in the last command, if it made enough calls.
    pub(crate) fn failed(&self) -> Option<Failed> {
        let report = fs::read_to_string(&self.report).ok()?;
        let (call, path) = report.split_once(' ')?;
        Some(Failed {
            call: call.into(),
            path: path.into(),
        })
    }
}
