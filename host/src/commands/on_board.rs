//! `oneiro on-board`: the daemon on a robot's own computer.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::cli;
use crate::console::Console;
use crate::daemon::air::Sockets;
use crate::daemon::control::Daemon;
use crate::daemon::settings::Settings;
use crate::exit::{Failure, Result};
use crate::robots::Kind;
use crate::robots::guard::wheels::Wanted;
use crate::robots::vehicle::guarded::{Guarded, Options};

/// Lives on board until the experiment is over, or a signal comes.
pub(crate) fn run(arguments: &cli::OnBoard, console: Console) -> Result {
    let settings = Settings::read(&arguments.file)?;
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::failed(format_args!("signals can't be listened to: {error}")))?;
    }
    #[cfg(unix)]
    if let Some(path) = &arguments.conductor {
        let (vehicle, air) = crate::fleet::twin::client::connect(path, settings.robot, Arc::clone(&stop))?;
        return Daemon::new(&settings, vehicle, air, true)?.live(&stop);
    }
    let Settings { radio, tracker, .. } = &settings;
    // The sockets first: a daemon that can't listen must not wake a robot.
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
    Daemon::new(&settings, Box::new(vehicle), Box::new(air), false)?.live(&stop)
}
