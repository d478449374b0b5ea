//! `oneiro fleet start`: lets robots live, and shows how they are.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::answer::Answer;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_fleet::fleet::file::{AnyFleet, Computers, Fleet};
use oneiro_fleet::fleet::live::{End, Options, Record, live};
use oneiro_fleet::fleet::operator::{Ears, Socket, Station};
use oneiro_fleet::fleet::page::{PAGE, Page};
use oneiro_fleet::fleet::remote::on_each;
use oneiro_fleet::fleet::{enough, service, table};
use oneiro_lab::engine::signals::stop_signal;
use oneiro_lab::exchange::radio::key::Key;

use crate::cli::FleetStart;
use crate::commands::live::Live;

/// Time between two tables on a terminal, and between two lines of JSON.
const TABLE: Duration = Duration::from_millis(500);
const LINE: Duration = Duration::from_secs(1);

/// Starts all daemons and lets the robots live. Those that live by themselves don't need this program any more.
pub(super) fn run(arguments: &FleetStart, console: Console) -> Result {
    let fleet = match AnyFleet::read(&arguments.fleet)? {
        AnyFleet::Foragers(fleet) => Arc::new(*fleet),
        AnyFleet::Alone(computers) => {
            console.say(
                "robots drive from now on, without a beacon, until their evolution is over or `oneiro fleet stop`",
            );
            return daemons(&computers, arguments.min, console);
        }
    };
    let stop = stop_signal()?;
    // Refusals come before any daemon connects to its robot.
    let key = Key::read(&fleet.key)?;
    let socket = Arc::new(Socket::open(&fleet)?);
    let record = Record::next(&fleet)?;
    let station = Arc::new(Station::new(&fleet, &key, &record)?);
    let mut page = Page::open(&fleet, record.milliseconds)?;
    daemons(&fleet, arguments.min, console)?;
    let options = Options {
        min: arguments.min.map_or(fleet.robots.len(), |min| min as usize),
        wait: arguments.wait,
    };
    console.say(format!(
        "{}: open it in a browser to see the robots",
        fleet.directory.join(PAGE).display()
    ));
    console.say("robots move only while this command runs: Ctrl-C, or the end of this terminal, stops them");
    let mut display = Display::new(console);
    let end = live(&fleet, record, (&socket, &station), options, &stop, |ears, time| {
        page.look(&ears.robots, time);
        display.show(ears, time)
    });
    drop(display);
    let how = match &end {
        Ok(End::Over) => "The experiment is over: robots stand.".to_owned(),
        Ok(End::Stopped(_)) => "\u{201c}oneiro fleet start\u{201d} was stopped: robots stand.".to_owned(),
        Err(failure) => format!("Robots stand: {failure}."),
    };
    if let Err(failure) = page.end(how) {
        console.say(format!("warning: the page is not complete: {failure}"));
    }
    let end = end?;
    let minutes = |milliseconds: i64| milliseconds as f64 / 60_000.0;
    match end {
        End::Over => {
            console.say("the experiment is over, and robots stand: `oneiro fleet stop`, then `collect`");
            Ok(())
        }
        End::Stopped(at) => Err(Failure::stopped(format_args!(
            "stopped after {:.1} min of the experiment; robots stand, and their daemons run: `oneiro fleet start` continues, `stop` ends them",
            minutes(at)
        ))),
    }
}

/// Starts the daemons of all robots.
fn daemons(fleet: &Computers, min: Option<u32>, console: Console) -> Result {
    let started = on_each(fleet, &fleet.chosen(&[])?, |robot, remote| {
        let outcome = remote.run(&service::start_command(fleet, robot));
        match &outcome {
            Ok(()) => console.say(format!("robot {}: its daemon runs", robot.number)),
            Err(failure) => console.say(format!("robot {}: {failure}", robot.number)),
        }
        outcome
    });
    enough(&started, min, "start")
}

/// Shows what robots say for a while, without a beacon.
pub(super) fn listened(fleet: &Fleet, time: Duration, console: Console) -> Result {
    let stop = stop_signal()?;
    let key = Key::read(&fleet.key)?;
    let socket = Arc::new(Socket::open(fleet)?);
    // Each start has its own number, which robots repeat: statuses with other numbers are not counted.
    let mut record = Record::next(fleet)?;
    let station = Arc::new(Station::new(fleet, &key, &record)?);
    let mut ears = Ears::new(fleet, socket, Arc::clone(&station));
    let began = Instant::now();
    while began.elapsed() < time && !stop.load(std::sync::atomic::Ordering::Relaxed) {
        ears.call();
        ears.listen();
        thread::sleep(Duration::from_millis(20));
    }
    record.save(fleet, &station, true)?;
    console.print_answer(&Answer::new(table::text(&ears, None), table::json(&ears, None)))
}

/// What shows the robots.
struct Display {
    live: Live,
    shown: Option<Instant>,
}

impl Display {
    fn new(console: Console) -> Self {
        Self {
            live: Live::new(console),
            shown: None,
        }
    }

    fn show(&mut self, ears: &Ears, time: Option<i64>) -> Result {
        let pause = if self.live.has_screen() { TABLE } else { LINE };
        if self.shown.is_some_and(|shown| shown.elapsed() < pause) {
            return Ok(());
        }
        self.shown = Some(Instant::now());
        self.live.show(|| table::text(ears, time), || table::json(ears, time))
    }
}
