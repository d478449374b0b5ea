//! `oneiro fleet twin`: the fleet's daemons as processes of this machine, in one simulated arena.

use std::fs::{self, File};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use clap::{Args, ValueHint};

use crate::console::{Console, counted};
use crate::engine::watcher::stop_signal;
use crate::exit::{Failure, Result};
use crate::fleet::twin::conductor::{Conductor, Daemons, Operator, Outcome, Plan, World};
use crate::progress;

/// `oneiro fleet twin`
#[derive(Args, Debug)]
pub(crate) struct Twin {
    /// The fleet's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// A script of faults: packets lost, daemons killed, lines that hang, clocks that drift, full disks
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) faults: Option<PathBuf>,
    /// The twin's directory, which must not exist
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// How many times faster than in reality time passes at most, 0.1 to 10000 [default: as fast as possible]
    #[arg(long, value_name = "X", value_parser = speed)]
    pub(crate) speed: Option<f64>,
}

fn speed(text: &str) -> std::result::Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.1..=10_000.0).contains(value));
    value.ok_or_else(|| "allowed: 0.1 to 10000".to_owned())
}

/// Daemons that are processes: `oneiro on-board robot.toml --conductor SOCKET`.
pub(crate) struct Processes {
    directory: PathBuf,
}

impl Processes {
    /// Prepares the daemons of a twin that has this directory: writes the settings of each robot, in the order of their numbers.
    ///
    /// # Errors
    /// Exit 3: the directory exists; exit 6.
    pub(crate) fn new(directory: &Path, settings: &[String]) -> Result<Self> {
        crate::files::must_be_new(directory)?;
        let own = Self {
            directory: directory.to_owned(),
        };
        for (robot, settings) in (0..).zip(settings) {
            let state = own.directory(robot);
            fs::create_dir_all(&state).map_err(|error| Failure::storage(&state, &error))?;
            crate::files::write_new(&own.file(robot, "toml"), settings.as_bytes())?;
        }
        Ok(own)
    }

    /// A file beside the directory of a robot.
    fn file(&self, robot: u32, extension: &str) -> PathBuf {
        self.directory(robot).with_extension(extension)
    }
}

impl Daemons for Processes {
    fn start(&mut self, robot: u32, socket: &Path) -> Result<Option<Child>> {
        let said = self.file(robot, "stderr");
        let stderr = File::options().create(true).append(true).open(&said);
        let stderr = stderr.map_err(|error| Failure::storage(&said, &error))?;
        let unstarted =
            |error: std::io::Error| Failure::failed(format_args!("robot {robot}: can't be started: {error}"));
        let mut daemon = Command::new(std::env::current_exe().map_err(unstarted)?);
        daemon
            .arg("on-board")
            .arg(self.file(robot, "toml"))
            .arg("--conductor")
            .arg(socket)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(stderr)
            // A Ctrl-C at the terminal is for the conductor.
            .process_group(0);
        daemon.spawn().map(Some).map_err(unstarted)
    }

    fn directory(&self, robot: u32) -> PathBuf {
        self.directory.join("robots").join(robot.to_string())
    }
}

/// Lets a twin live, and shows how far it is and what came of it.
///
/// # Errors
/// Those of [`Conductor`]; exit 1 if daemons ended too early or with an error; exit 75 after Ctrl-C.
pub(crate) fn run(
    plan: Plan,
    world: &mut dyn World,
    operator: &mut dyn Operator,
    daemons: &mut dyn Daemons,
    console: Console,
) -> Result {
    let stop = stop_signal()?;
    let directory = plan.directory.clone();
    let bar = progress::rows(plan.seconds.into(), "twin", console);
    let conductor = Conductor::new(plan, world, operator, daemons)?;
    let outcome = conductor.run(&stop, |second| bar.set_position(second));
    bar.finish_and_clear();
    let outcome = outcome?;
    show(&outcome, console)?;
    if outcome.stopped {
        return Err(Failure::stopped(format_args!(
            "stopped after {} s; {} has the record until then",
            outcome.seconds,
            directory.display()
        )));
    }
    if outcome.problems.is_empty() {
        return Ok(());
    }
    Err(Failure::failed(outcome.problems.join("\n")))
}

fn show(outcome: &Outcome, console: Console) -> Result {
    if console.json() {
        return console.json_data(outcome);
    }
    let brought: u32 = outcome.brought.iter().sum();
    let robots = counted(outcome.brought.len() as u32, "robot", "robots");
    let (seconds, hash) = (outcome.seconds, &outcome.hash);
    console.data(format!("{robots}, {seconds} s: {brought} items brought; record {hash}"))
}
