//! `oneiro on-board`: the daemon on a robot's own computer.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_fleet::daemon::air::Sockets;
use oneiro_fleet::daemon::control::{Daemon, Files};
use oneiro_fleet::daemon::settings::Settings;
#[cfg(feature = "compose")]
use oneiro_fleet::daemon::single;
use oneiro_lab::experiment::kinds::FileKind;
use oneiro_lab::experiment::source::Parsed;
#[cfg(feature = "compose")]
use oneiro_lab::reality::wired;
use oneiro_robots::Kind;
use oneiro_robots::guard::wheels::Wanted;
use oneiro_robots::vehicle::guarded::{Guarded, Options};

use crate::cli;

/// Lives on board until the experiment is over, or a signal comes.
pub(crate) fn run(arguments: &cli::OnBoard, console: Console) -> Result {
    let text = FileKind::Robot.text(&arguments.file)?;
    let parsed = FileKind::Robot.parsed(&arguments.file, &text)?;
    if Settings::is_of_member(&parsed) {
        return member(arguments, &parsed, console);
    }
    alone(&arguments.file, &parsed, console)
}

/// A member of a swarm.
fn member(arguments: &cli::OnBoard, parsed: &Parsed<'_>, console: Console) -> Result {
    let settings = Settings::of(&arguments.file, parsed)?;
    let stop = stopped_by_signals()?;
    // Its files and its sockets first: a daemon that can't read its key, or can't listen, must not wake a robot.
    let files = Files::open(&settings)?;
    #[cfg(unix)]
    if let Some(path) = &arguments.conductor {
        let (vehicle, air) = oneiro_fleet::fleet::twin::client::connect(path, settings.robot, Arc::clone(&stop))?;
        return Daemon::new(&settings, files, vehicle, air, true)?.live(&stop);
    }
    let Settings { radio, tracker, .. } = &settings;
    let air = Sockets::open(&radio.listen, &radio.peers, Some(&tracker.listen))?;
    let options = Options {
        wire: settings.wire.clone(),
        wanted: Wanted {
            kinds: vec![Kind::Proximity, Kind::Light],
            odometry: false,
        },
        settings: settings.guard.clone(),
        record: None,
        tracker: None,
        number: None,
    };
    let vehicle = Guarded::open(&options, Arc::clone(&stop), console)?;
    Daemon::new(&settings, files, Box::new(vehicle), Box::new(air), false)?.live(&stop)
}

/// A robot without a swarm.
#[cfg(feature = "compose")]
fn alone(file: &Path, parsed: &Parsed<'_>, console: Console) -> Result {
    let settings = single::settings::Settings::of(file, parsed)?;
    let stop = stopped_by_signals()?;
    // Its files first, for the same reason.
    let options = settings.options()?;
    let daemon = single::Daemon::new(&settings, false)?;
    wired::check(settings.experiment.world().spec(), &settings.lives, &options.settings)?;
    console.say(settings.time());
    let vehicle = Guarded::open(&options, Arc::clone(&stop), console).map_err(|failure| settings.at(failure))?;
    daemon.live(Box::new(vehicle), console, &stop)
}

/// A robot without a swarm, whose lives need what this program lacks.
#[cfg(not(feature = "compose"))]
fn alone(file: &Path, _: &Parsed<'_>, _: Console) -> Result {
    Err(Failure::input(format_args!(
        "{}: has neither robot nor key nor [radio], so it is not for a forager; this program was built without the feature \
         `compose`, which other robots need; allowed: a program built with it (docs/robots-on-the-wire.md)",
        file.display()
    )))
}

/// Set once a signal asks the daemon to end.
fn stopped_by_signals() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::failed(format_args!("signals can't be listened to: {error}")))?;
    }
    Ok(stop)
}
