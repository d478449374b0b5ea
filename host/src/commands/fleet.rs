//! `oneiro fleet`: installs, starts, watches and stops a fleet of robots with a computer each, and collects its records.

mod compare;
mod start;
#[cfg(all(unix, feature = "twin"))]
pub(crate) mod twin;

use std::path::Path;

use oneiro_base::answer::Answer;
use oneiro_base::console::counted;
use oneiro_base::console::{Console, columns};
use oneiro_base::contents::describe;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_fleet::fleet::file::{AnyFleet, Computers, Fleet, Robot};
use oneiro_fleet::fleet::install::Stock;
use oneiro_fleet::fleet::remote::{Remote, on_each};
use oneiro_fleet::fleet::{Outcomes, collect, enough, page, service};
use oneiro_lab::exchange::radio::key::Key;
use serde_json::{Value, json};

use super::places::found;
use crate::cli::{self, FleetCommand, FleetFile, FleetStatus, FleetWork};

/// Runs the subcommand.
pub(super) fn run(arguments: &cli::Fleet, console: Console) -> Result {
    match &arguments.command {
        FleetCommand::Key { file } => key(file, console),
        FleetCommand::Plan(arguments) => plan(arguments, console),
        FleetCommand::Deploy(arguments) => deploy(arguments, console),
        FleetCommand::Start(arguments) => start::run(arguments, console),
        FleetCommand::Status(arguments) => status(arguments, console),
        FleetCommand::Stop(arguments) => stop(arguments, console),
        FleetCommand::Collect(arguments) => collected(arguments, console),
        #[cfg(all(unix, feature = "twin"))]
        FleetCommand::Twin(arguments) => twin::run(arguments, console),
        FleetCommand::Compare(arguments) => compare::run(arguments, console),
        FleetCommand::Replay { record } => replay(record, console),
    }
}

/// Makes a key.
fn key(file: &Path, console: Console) -> Result {
    Key::create(file)?;
    console.say(format!("{}: a new key, which only you can read", file.display()));
    Ok(())
}

/// Prints what would be done.
fn plan(arguments: &FleetFile, console: Console) -> Result {
    let any = AnyFleet::read(&arguments.fleet)?;
    let fleet = any.computers();
    let robots = fleet.chosen(&arguments.robots)?;
    let stock = Stock::read(fleet, any.key())?;
    let robot = |robot: &&Robot| {
        let files = stock.parcels(robot);
        let files = files
            .iter()
            .map(|file| json!({ "name": file.name, "bytes": file.bytes.len() }));
        let remote = Remote::of(fleet, robot);
        json!({
            "number": robot.number,
            "host": robot.host,
            "address": robot.address,
            "radio": robot.radio,
            "share": robot.share,
            "time": robot.time,
            "directory": fleet.place(robot),
            "files": files.collect::<Vec<_>>(),
            "start": remote.shown(&service::start_command(fleet, robot)),
            "stop": remote.shown(&service::stop_command(fleet, robot)),
            "robot_toml": robot.toml,
        })
    };
    let mut plan = json!({
        "service": fleet.service,
        "robots": robots.iter().map(robot).collect::<Vec<_>>(),
    });
    let mut text = match &any {
        AnyFleet::Foragers(fleet) => {
            let (minutes, battery) = minutes(fleet);
            plan["experiment"] = fleet.experiment.name().into();
            plan["seed"] = fleet.seed.into();
            plan["minutes"] = fleet.experiment.settings().minutes.into();
            plan["robot_minutes"] = (minutes * robots.len() as f64).into();
            plan["battery_minutes"] = battery.into();
            members(fleet, &robots)
        }
        AnyFleet::Alone(_) => alone(&robots),
    };
    if let Some(first) = robots.first() {
        text += &example(fleet, first, &stock);
    }
    console.print_answer(&Answer::new(text, plan))
}

/// How long the experiment of a swarm takes, and how long a battery must last, min.
fn minutes(fleet: &Fleet) -> (f64, f64) {
    let settings = fleet.experiment.settings();
    let minutes = f64::from(settings.minutes);
    (minutes, minutes + f64::from(settings.clock.offset_s) / 60.0)
}

/// The robots of a swarm.
fn members(fleet: &Fleet, robots: &[&Robot]) -> String {
    let share = |robot: &Robot| {
        robot
            .share
            .map_or_else(|| "default".to_owned(), |share| format!("{share} of a core"))
    };
    let row = |robot: &&Robot| {
        let radio = robot.radio.map_or_else(String::new, |radio| radio.to_string());
        let words = [robot.host.clone(), robot.address.clone(), radio, share(robot)];
        std::iter::once(robot.number.to_string()).chain(words).collect()
    };
    let table = columns(
        &["robot", "computer", "robot's address", "radio", "simulator"],
        &robots.iter().map(row).collect::<Vec<_>>(),
    );
    let absent = fleet.experiment.settings().world.robots as usize - fleet.robots.len();
    let absent = if absent > 0 {
        format!("; {absent} of the experiment's robots are absent")
    } else {
        String::new()
    };
    let (minutes, battery) = minutes(fleet);
    format!(
        "{}, seed {}: {} for {minutes} min, {} robot-minutes; a battery must last {battery:.0} min{absent}\n\n{table}",
        fleet.experiment.name(),
        fleet.seed,
        counted(robots.len(), "robot", "robots"),
        minutes * robots.len() as f64,
    )
}

/// Robots that live by themselves.
fn alone(robots: &[&Robot]) -> String {
    let row = |robot: &&Robot| {
        let time = robot.time.clone().unwrap_or_default();
        vec![
            robot.number.to_string(),
            robot.host.clone(),
            robot.address.clone(),
            time,
        ]
    };
    let table = columns(
        &["robot", "computer", "robot's address", "time"],
        &robots.iter().map(row).collect::<Vec<_>>(),
    );
    let count = robots.len();
    format!("single robots: {count}; each drives while its daemon runs\n\n{table}")
}

/// What one robot gets, and the commands on its computer.
fn example(fleet: &Computers, robot: &Robot, stock: &Stock) -> String {
    let files = stock.parcels(robot);
    let row =
        |file: &oneiro_fleet::fleet::install::Parcel<'_>| vec![file.name.to_owned(), file.bytes.len().to_string()];
    let files = columns(&["file", "bytes"], &files.iter().map(row).collect::<Vec<_>>());
    let remote = Remote::of(fleet, robot);
    format!(
        "\nFiles for each robot's computer, here in {} of robot {}:\n\n{files}\nrobot.toml:\n\n{}\nstart: {}\nstop:  {}\n",
        fleet.place(robot),
        robot.number,
        robot.toml,
        remote.shown(&service::start_command(fleet, robot)),
        remote.shown(&service::stop_command(fleet, robot)),
    )
}

/// Installs all robots.
fn deploy(arguments: &FleetWork, console: Console) -> Result {
    let any = AnyFleet::read(&arguments.file.fleet)?;
    let fleet = any.computers();
    let robots = fleet.chosen(&arguments.file.robots)?;
    let stock = Stock::read(fleet, any.key())?;
    let outcomes = print_outcomes(
        fleet,
        &robots,
        |robot, remote| report_done(robot, stock.install(fleet, robot, remote), console),
        |installed| {
            let sent = match &installed.sent[..] {
                [] => "unchanged".to_owned(),
                sent => format!("sent {}, {} bytes", sent.join(", "), installed.bytes),
            };
            let warnings: Vec<String> = installed.warnings.iter().map(|own| format!("warning: {own}")).collect();
            (
                std::iter::once(sent).chain(warnings).collect::<Vec<_>>().join("; "),
                json!(installed),
            )
        },
        console,
    )?;
    enough(&outcomes, arguments.min, "deploy")
}

/// Asks all daemons for their state.
fn status(arguments: &FleetStatus, console: Console) -> Result {
    if let Some(time) = arguments.listen {
        return start::listened(&Fleet::read(&arguments.file.fleet)?, time, console);
    }
    let any = AnyFleet::read(&arguments.file.fleet)?;
    let fleet = any.computers();
    let robots = fleet.chosen(&arguments.file.robots)?;
    let outcomes = print_outcomes(
        fleet,
        &robots,
        |robot, remote| service::state(fleet, robot, remote),
        |(state, last)| {
            let last: Option<Value> = last.as_deref().and_then(|line| serde_json::from_str(line).ok());
            let words = last.as_ref().map_or_else(|| "no log".to_owned(), last_event);
            (
                format!("{}; {words}", state.word()),
                json!({ "state": state.word(), "last": last }),
            )
        },
        console,
    )?;
    enough(&outcomes, None, "status")
}

/// The event and the time of day in the last line of a log.
fn last_event(line: &Value) -> String {
    let word = |key: &str| line[key].as_str().unwrap_or("?").to_owned();
    format!("last event `{}` at {}", word("event"), word("utc"))
}

/// Stops all daemons.
fn stop(arguments: &FleetWork, console: Console) -> Result {
    let any = AnyFleet::read(&arguments.file.fleet)?;
    let fleet = any.computers();
    let robots = fleet.chosen(&arguments.file.robots)?;
    let outcomes = print_outcomes(
        fleet,
        &robots,
        |robot, remote| service::stop(fleet, robot, remote),
        |()| ("stopped, wheels confirmed".to_owned(), json!(true)),
        console,
    )?;
    enough(&outcomes, arguments.min, "stop")
}

/// Copies all records, and merges those of a swarm.
fn collected(arguments: &FleetWork, console: Console) -> Result {
    let any = AnyFleet::read(&arguments.file.fleet)?;
    let fleet = any.computers();
    let robots = fleet.chosen(&arguments.file.robots)?;
    let outcomes = print_outcomes(
        fleet,
        &robots,
        |robot, remote| report_done(robot, collect::copy(fleet, robot, remote), console),
        |own| {
            let (files, bytes) = (own.files, own.bytes);
            (
                format!("{}, {bytes} bytes", counted(files, "file", "files")),
                json!({ "files": files, "bytes": bytes }),
            )
        },
        console,
    )?;
    // What an earlier collection has of a robot that can't be reached now belongs to the record, too.
    let here = |robot: &&Robot| fleet.collected(robot.number).is_dir();
    let numbers: Vec<u32> = fleet
        .robots
        .iter()
        .filter(|robot| here(robot))
        .map(|robot| robot.number)
        .collect();
    if numbers.is_empty() {
        return Err(Failure::of(Code::Device, "collect: no robot's record could be copied"));
    }
    match &any {
        AnyFleet::Foragers(fleet) => merged(fleet, &numbers, console)?,
        AnyFleet::Alone(_) => {
            describe(&fleet.directory, "Records of single robots", &collect::contents_alone())?;
            let directory = fleet.directory.display();
            console.say(format!(
                "the records of {} are in {directory}; robot-N/best.npy is robot N's best",
                counted(numbers.len(), "robot", "robots")
            ));
        }
    }
    enough(&outcomes, arguments.min, "collect")
}

/// Merges the records of a swarm's robots.
fn merged(fleet: &Fleet, numbers: &[u32], console: Console) -> Result {
    let merged = collect::merge(fleet, numbers)?;
    console.warn(&merged.warnings);
    let residual = merged
        .clocks
        .iter()
        .filter(|clock| clock.pairs > 0)
        .map(|clock| clock.residual)
        .fold(0.0, f64::max);
    console.say(format!(
        "{} of {} in {}; clocks agree to {residual:.1} ms (maximum root mean square; {} has all)",
        counted(merged.lines, "line", "lines"),
        counted(merged.clocks.len(), "clock", "clocks"),
        fleet.directory.join(collect::TIMELINE).display(),
        oneiro_fleet::fleet::timeline::CLOCKS,
    ));
    Ok(())
}

/// Writes a page that plays the record of a fleet, or of a twin.
fn replay(record: &Path, console: Console) -> Result {
    let record = &found(record, &[], console)?;
    #[cfg(all(unix, feature = "twin"))]
    let page = if record.is_dir() {
        oneiro_fleet::fleet::twin::replay::write(record)?
    } else {
        page::replay(&Fleet::read(record)?)?
    };
    #[cfg(not(all(unix, feature = "twin")))]
    let page = page::replay(&Fleet::read(record)?)?;
    let page = page.display().to_string();
    console.print_answer(&Answer::new(page.as_str(), json!({ "page": page })))
}

/// Reports progress: the work for a robot has ended, well or not.
fn report_done<T>(robot: &Robot, outcome: Result<T>, console: Console) -> Result<T> {
    console.say(format!("robot {}: done with {}", robot.number, robot.host));
    outcome
}

/// Runs `work` for each robot and prints the outcomes, one row per robot. `describe` gives a success in words and as JSON.
fn print_outcomes<T: Send>(
    fleet: &Computers,
    robots: &[&Robot],
    work: impl Fn(&Robot, Remote<'_>) -> Result<T> + Sync,
    describe: impl Fn(&T) -> (String, Value),
    console: Console,
) -> Result<Outcomes<T>> {
    let outcomes = on_each(fleet, robots, work);
    let host = |number: u32| fleet.robot(number).map(|robot| robot.host.clone()).unwrap_or_default();
    let row = |(number, outcome): &(u32, Result<T>)| {
        let host = host(*number);
        let mut value = json!({ "robot": number, "host": host });
        let words = match outcome {
            Ok(own) => {
                let (words, done) = describe(own);
                value["done"] = done;
                words
            }
            Err(failure) => {
                value["problem"] = failure.to_string().into();
                format!("FAILED: {failure}")
            }
        };
        (vec![number.to_string(), host, words], value)
    };
    let (rows, values): (Vec<_>, Vec<_>) = outcomes.iter().map(row).unzip();
    let text = columns(&["robot", "computer", "outcome"], &rows);
    console.print_answer(&Answer::new(text, values))?;
    Ok(outcomes)
}
