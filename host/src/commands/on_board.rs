//! `oneiro on-board`: the daemon on a robot's own computer.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::cli;
use crate::console::Console;
use crate::daemon::air::{Air, Sockets};
use crate::daemon::control::Daemon;
use crate::daemon::settings::Settings;
use crate::exit::{Failure, Result};
use crate::fleet::twin;
use crate::robots::Kind;
use crate::robots::guard::wheels::Wanted;
use crate::robots::vehicle::Vehicle;
use crate::robots::vehicle::guarded::{Guarded, Options};

/// Lives on board until the experiment is over, or a signal comes.
pub(crate) fn run(arguments: &cli::OnBoard, console: Console) -> Result {
    let settings = Settings::read(&arguments.file)?;
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::failed(format_args!("signals can't be listened to: {error}")))?;
    }
    let (vehicle, air): (Box<dyn Vehicle>, Box<dyn Air>) = if let Some(path) = &arguments.conductor {
        let (vehicle, air) = twin::client::connect(path, settings.robot, Arc::clone(&stop))?;
        (vehicle, air)
    } else {
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
        };
        let vehicle = Guarded::open(&options, Arc::clone(&stop), console)?;
        (Box::new(vehicle), Box::new(air))
    };
    Daemon::new(&settings, vehicle, air, arguments.conductor.is_some())?.live(&stop)
}
