//! `oneiro fleet twin`: the fleet's daemons as processes of this machine, in one simulated arena.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use oneiro::acting::Readings;
use oneiro::cpu::Cpu;
use oneiro::random::Key;
use oneiro::swarm::{self as arena, Drive, Driven, Line, SECOND, Swarm};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::files::directory::Filling;
use oneiro_base::plain;
use oneiro_base::program;
use oneiro_base::progress;
use oneiro_fleet::daemon::settings::Settings;
use oneiro_fleet::fleet::file::{self, Fleet};
use oneiro_fleet::fleet::twin;
use oneiro_fleet::fleet::twin::conductor::{Conductor, Daemons, Operator, Outcome, Plan, World};
use oneiro_fleet::fleet::twin::faults::Faults;
use oneiro_lab::engine::signals::stop_signal;
use oneiro_lab::exchange::radio::key::Key as Secret;
use oneiro_lab::exchange::radio::{OPERATOR, Packet, Radio};
use oneiro_lab::swarm::clock::Clock;
use oneiro_robots::guard::values::Values;
use toml::Table;

use crate::cli::Twin;

/// Daemons that are processes: `oneiro on-board robot.toml --conductor SOCKET`.
pub(crate) struct Processes {
    directory: PathBuf,
    program: PathBuf,
}

impl Processes {
    /// Prepares the daemons of a twin that has this directory: writes the settings of each robot, in the order of their numbers.
    /// They run `program`, or this one.
    ///
    /// # Errors
    /// Exit 3: the program does not exist; exit 6.
    pub(crate) fn new(directory: &Path, settings: &[String], program: Option<&Path>) -> Result<Self> {
        let program = match program {
            Some(path) => path
                .canonicalize()
                .map_err(|error| Failure::input(format_args!("--program {}: {error}", path.display())))?,
            None => program::path()
                .map_err(|error| Failure::failed(format_args!("this program can't be found: {error}")))?,
        };
        let own = Self {
            directory: directory.to_owned(),
            program,
        };
        for (robot, settings) in (0..).zip(settings) {
            let state = own.directory(robot);
            plain::make_directory(&state).map_err(|error| Failure::storage(&state, &error))?;
            files::write_new(&own.file(robot, "toml"), settings.as_bytes())?;
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
        let stderr = plain::append_or_create(&said).map_err(|error| Failure::storage(&said, &error))?;
        let unstarted =
            |error: std::io::Error| Failure::failed(format_args!("robot {robot}: can't be started: {error}"));
        let mut daemon = Command::new(&self.program);
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

/// The arena of the 2014 study, whose robots the daemons drive.
struct Arena {
    driven: Driven,
    cpu: Cpu,
    swarm: Swarm,
    clocks: Vec<Clock>,
    cycle: u32,
}

impl Arena {
    /// The arena of an experiment with a seed.
    ///
    /// # Errors
    /// It can't be made.
    fn new(plan: &oneiro_lab::swarm::Plan) -> Result<Self> {
        let mut cpu = Cpu::new(Some(1))?;
        let swarm = plan.settings.swarm();
        let key = Key::rollout(plan.seed, 0, 0, 0);
        let driven = Driven::new(&mut cpu, &swarm, plan.lamp(), key).map_err(Failure::failed)?;
        Ok(Self {
            driven,
            cpu,
            swarm,
            clocks: plan.clocks(),
            cycle: 0,
        })
    }
}

impl World for Arena {
    fn readings(&self) -> Vec<Readings> {
        self.driven.readings().to_vec()
    }

    fn cycle(&mut self, wheels: &[[f64; 2]]) -> Result<Line> {
        let second = self.cycle / SECOND;
        let command = |(clock, wheels): (&Clock, &[f64; 2])| {
            let interval = clock.interval_at(second);
            let begins = |interval| SECOND * clock.seconds_of(interval).start == self.cycle;
            arena::Command {
                drive: interval.map(|_| Drive::of_wheels(wheels.map(|speed| speed as f32), &self.swarm.forager)),
                begins: interval.is_some_and(begins),
            }
        };
        let commands: Vec<_> = self.clocks.iter().zip(wheels).map(command).collect();
        self.cycle += 1;
        self.driven.cycle(&mut self.cpu, &commands).map_err(Failure::failed)
    }
}

/// The number of a twin's one start, which is the same each time.
const START: u64 = 1;

/// The operator's radio.
struct Voice(Radio);

impl Operator for Voice {
    fn beacon(&mut self, milliseconds: i64, go: bool) -> Vec<u8> {
        let start = START;
        self.0.seal(&Packet::Beacon {
            milliseconds,
            go,
            start,
        })
    }

    fn hear(&mut self, datagram: &[u8], now: Duration) {
        // What is refused is counted, and nobody here waits for what robots report.
        let _ = self.0.open(datagram, now, None);
    }
}

/// Lets the twin of a fleet live.
///
/// # Errors
/// Exit 3: the fleet's file, the script, or a directory that exists; otherwise as [`live`].
pub(crate) fn run(arguments: &Twin, console: Console) -> Result {
    let mut fleet = Fleet::read(&arguments.fleet)?;
    fleet.seed = arguments.seed.unwrap_or(fleet.seed);
    let plan = fleet.experiment.plan(fleet.seed);
    let robots = plan.settings.world.robots;
    let mut numbers: Vec<u32> = fleet.robots.iter().map(|robot| robot.number).collect();
    numbers.sort_unstable();
    if !numbers.iter().copied().eq(0..robots) {
        return Err(Failure::input(format_args!(
            "{}: has {} of the experiment's {robots} robots; allowed in a twin: all of them",
            arguments.fleet.display(),
            numbers.len()
        )));
    }
    let faults = match &arguments.faults {
        Some(path) => Faults::read(path, robots, plan.settings.seconds())?,
        None => Faults::default(),
    };
    let settings: Vec<String> = (0..robots)
        .map(|number| {
            let robot = fleet.robots.iter().find(|robot| robot.number == number);
            of_twin(robot.map_or("", |robot| &robot.toml), number, fleet.seed)
        })
        .collect();
    let key = Secret::read(&fleet.key)?;
    let mut arena = Arena::new(&plan)?;
    let filling = Filling::begin("--out", &arguments.out, twin::is_own)?;
    let mut daemons = Processes::new(&arguments.out, &settings, arguments.program.as_deref())?;
    let place = arguments.out.join("robots");
    files::write_new(&place.join(file::EXPERIMENT), fleet.text.as_bytes())?;
    let own_key = place.join(file::KEY);
    files::write_secret(&own_key, &files::bytes(&fleet.key)?)?;
    let guard = Settings::read(&daemons.file(0, "toml"))?.guard;
    let limits = plan.settings.limits();
    let of_conductor = Plan {
        robots,
        seconds: plan.settings.seconds(),
        tracking_loss: plan.settings.world.differences.tracking_loss.into(),
        guard: Values::of(&guard).map_err(Failure::input)?,
        faults,
        speed: arguments.speed,
        directory: arguments.out.clone(),
    };
    let mut voice = Voice(Radio::new(OPERATOR, limits, &key, fleet.hash(), 1));
    live(of_conductor, &mut arena, &mut voice, &mut daemons, filling, console)
}

/// The `robot.toml` of a robot's computer for the twin, where each robot has a directory beside the others'.
fn of_twin(toml: &str, number: u32, seed: u64) -> String {
    let mut table: Table = toml.parse().unwrap_or_default();
    table.insert("directory".into(), number.to_string().into());
    table.insert("seed".into(), (seed as i64).into());
    table.to_string()
}

/// Lets a twin live, and shows how far it is and what came of it.
///
/// # Errors
/// Those of [`Conductor`]; exit 1 if daemons ended too early or with an error; exit 75 after Ctrl-C.
fn live(
    plan: Plan,
    world: &mut dyn World,
    operator: &mut dyn Operator,
    daemons: &mut dyn Daemons,
    filling: Filling,
    console: Console,
) -> Result {
    let stop = stop_signal()?;
    stay_on_one_core();
    let directory = plan.directory.clone();
    let bar = progress::rows(plan.seconds.into(), "twin", console.bars());
    let conductor = Conductor::new(plan, world, operator, daemons)?;
    let outcome = conductor.run(&stop, |second| bar.set_position(second));
    bar.finish_and_clear();
    let outcome = outcome?;
    filling.finish()?;
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

/// Keeps this process, and those that it starts, on the core that it runs on: one of them at a time has something to do, and
/// handing over to another core takes several times as long.
fn stay_on_one_core() {
    #[cfg(target_os = "linux")]
    {
        let mut core = rustix::thread::CpuSet::new();
        core.set(rustix::thread::sched_getcpu());
        // It only takes longer otherwise.
        let _ = rustix::thread::sched_setaffinity(None, &core);
    }
}

fn show(outcome: &Outcome, console: Console) -> Result {
    let brought: u32 = outcome.brought.iter().sum();
    let robots = counted(outcome.brought.len(), "robot", "robots");
    let (seconds, hash) = (outcome.seconds, &outcome.hash);
    let text = format!("{robots}, {seconds} s: {brought} items brought; record {hash}");
    console.print_answer(&Answer::new(text, outcome))
}
