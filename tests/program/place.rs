//! Shared by tests of the program: a directory to run it in, and the outcome of a command.

pub(crate) mod table;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

/// Waits until a condition holds.
pub(crate) fn wait_for(mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_mins(1), "waited for a minute");
        thread::sleep(Duration::from_millis(2));
    }
}

/// A temporary directory, removed when the test ends.
pub(crate) struct Place(PathBuf);

impl Place {
    /// Named by the calling file too, since names repeat among files.
    #[track_caller]
    pub(crate) fn new(name: &str) -> Self {
        let file = Path::new(std::panic::Location::caller().file()).file_stem().unwrap();
        let name = format!("oneiro-{}-{name}-{}", file.display(), std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Path of a name in the directory.
    pub(crate) fn at(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.join(name)
    }

    pub(crate) fn write(&self, name: impl AsRef<Path>, content: impl AsRef<[u8]>) {
        fs::write(self.at(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: impl AsRef<Path>) -> Vec<u8> {
        let path = self.at(name);
        fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    pub(crate) fn text(&self, name: impl AsRef<Path>) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// A file in a directory below it.
    pub(crate) fn json(&self, directory: impl AsRef<Path>, file: &str) -> Value {
        serde_json::from_slice(&self.read(directory.as_ref().join(file))).unwrap()
    }

    /// Checkpoints in a directory below it, newest first; none if there is no such directory.
    pub(crate) fn checkpoints(&self, directory: impl AsRef<Path>) -> Vec<PathBuf> {
        let Ok(entries) = fs::read_dir(self.at(directory)) else {
            return Vec::new();
        };
        let number = |path: &PathBuf| {
            let name = path.file_name().unwrap().to_str().unwrap();
            name.strip_prefix("checkpoint-")?.parse::<u64>().ok()
        };
        let mut found: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        found.retain(|path| number(path).is_some());
        found.sort_by_key(|path| std::cmp::Reverse(number(path)));
        found
    }

    /// The program in this directory, to be run in any way.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_oneiro"));
        command
            .args(arguments)
            .current_dir(&self.0)
            .env_remove("NO_COLOR")
            // Tests may run in a job array, whose task would take a share of a sweep.
            .env_remove("SLURM_ARRAY_TASK_ID")
            .stdin(Stdio::null());
        command
    }

    /// Starts the program, with its output in pipes.
    pub(crate) fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Runs the program until it ends.
    pub(crate) fn run(&self, arguments: &[&str]) -> Ran {
        Ran::ended(arguments, self.start(arguments))
    }

    /// Runs a command that must succeed, and returns its standard output.
    #[track_caller]
    pub(crate) fn good(&self, arguments: &[&str]) -> String {
        self.run(arguments).exits(0).stdout
    }

    /// Runs an experiment on the CPU into a directory, with more arguments.
    #[track_caller]
    #[allow(dead_code, reason = "some tests run no experiment")]
    pub(crate) fn evolved(&self, experiment: &str, seed: &str, out: &str, more: &[&str]) {
        let fixed = [
            "run",
            experiment,
            "--seed",
            seed,
            "--out",
            out,
            "--backend",
            "cpu",
            "--quiet",
        ];
        self.good(&[&fixed, more].concat());
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        // A leftover in the system's temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Outcome of a command.
pub(crate) struct Ran {
    pub(crate) arguments: String,
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    /// Waits for a program's end.
    pub(crate) fn ended(arguments: &[&str], program: Child) -> Self {
        Self::new(arguments, &program.wait_with_output().unwrap())
    }

    pub(crate) fn new(arguments: &[&str], output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        Self {
            arguments: arguments.join(" "),
            code: output.status.code(),
            stdout: text(&output.stdout),
            stderr: text(&output.stderr),
        }
    }

    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Self {
        let Self {
            arguments,
            stdout,
            stderr,
            ..
        } = &self;
        assert_eq!(self.code, Some(code), "oneiro {arguments}\n{stdout}\n{stderr}");
        assert!(!stderr.contains("panicked"), "oneiro {arguments}\n{stderr}");
        self
    }

    /// Asserts that its message contains all of these words.
    #[track_caller]
    pub(crate) fn says(self, words: &[&str]) -> Self {
        for word in words {
            assert!(
                self.stderr.contains(word),
                "oneiro {}: no `{word}` in\n{}",
                self.arguments,
                self.stderr
            );
        }
        self
    }
}
