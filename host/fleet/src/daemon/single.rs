//! A robot without a swarm: its experiment's population evolves in the simulator, the best is sometimes tried on the robot, and
//! its measured fitness decides which controller the robot returns to.
//!
//! | file | content |
//! |---|---|
//! | [`settings`] | the daemon's file |
//! | [`transfers`] | which controller is tried next, and what was measured; without clock, files or robot |
//! | [`evolving`] | the generations, in a thread at the same time |
//! | [`watched`] | tells systemd's watchdog that the daemon is alive |
//!
//! An interval is some generations in the simulator and, at the same time, an episode on the robot of the last interval's
//! best. The interval waits for both, so the simulator's proposals depend on the seed only, however fast the processor is.
//! Then everything is saved. A killed daemon repeats its interval: generations come out the same, and a complete recorded
//! episode is not repeated.

mod evolving;
pub mod settings;
pub mod transfers;
mod watched;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use oneiro::random::Keys;
use oneiro_base::console::Console;
use oneiro_base::contents::describe;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Champion;
use oneiro_lab::reality::wired::{Shared, WiredRobots};
use oneiro_lab::reality::{Life, Reality, Trouble};
use oneiro_lab::runs::single::on_board::OnBoard;
use oneiro_robots::vehicle::Vehicle;
use serde_json::{Value, json};

use self::evolving::Evolved;
use self::settings::Settings;
use self::transfers::{Saved, Transfer, Why};
use self::watched::Watched;
use super::beside::Beside;
use super::keeper::Keeper;
use super::log::{self, Log};
use super::notify::Notify;

/// Number of the generation in the keys of episodes on the robot, larger than any simulated one.
const ON_ROBOT: u64 = 1 << 33;
/// The robot's pause between two looks at whether the simulator is ready.
const PAUSE: Duration = Duration::from_millis(100);

/// A daemon before its robot is connected.
pub struct Daemon<'a> {
    settings: &'a Settings,
    keeper: Keeper<Saved>,
    saved: Saved,
    evolving: Beside<(), Evolved>,
    /// Whether it waits for the evolution, on a clock that stops for that time.
    waits: bool,
}

/// A daemon with its robot.
struct RunningDaemon<'a> {
    daemon: Daemon<'a>,
    vehicle: Shared,
    robots: WiredRobots,
    log: Log,
    notify: Notify,
    began: Duration,
}

impl<'a> Daemon<'a> {
    /// Loads the saved state.
    ///
    /// # Errors
    /// Exit 3: an unusable directory; exit 5: the saved state is damaged, or is of another experiment; exit 6: the
    /// disk.
    pub fn new(settings: &'a Settings, waits: bool) -> Result<Self> {
        let Settings {
            directory,
            seed,
            lives,
            experiment,
            ..
        } = settings;
        // Episodes with another speed or other sensors can't be compared with the measured ones.
        let lives = format!("{:?} {:?} {:?}", lives.walk, lives.speed_mm_s, lives.sensors);
        let owner = blake3::hash(&[settings.identity.as_bytes().as_slice(), lives.as_bytes()].concat());
        let (mut keeper, saved) = Keeper::<Saved>::open(directory, owner)?;
        let mut saved = saved.unwrap_or_default();
        saved.boots = saved.boots.saturating_add(1);
        keeper.save_now(&saved)?;
        describe(directory, "A robot that evolves on board", &transfers::contents())?;
        let evolution = OnBoard::new(experiment.clone(), *seed, saved.evolution.as_deref())?;
        Ok(Self {
            evolving: evolving::start(evolution, settings.rules.generations, settings.evolution.share),
            settings,
            keeper,
            saved,
            waits,
        })
    }

    /// Runs until all is done or `stop` is set. Then the wheels stand still.
    ///
    /// # Errors
    /// Exit 3: the robot is not the experiment's; exit 4: it fails for good; exit 5 and 6: a record is damaged or can't
    /// be written; exit 75: `stop` was set before all was done.
    pub fn live(self, vehicle: Box<dyn Vehicle + Send>, console: Console, stop: &AtomicBool) -> Result {
        let Settings {
            experiment,
            wire,
            lives,
            directory,
            ..
        } = self.settings;
        let began = vehicle.now();
        let vehicle = Shared::of(Watched::new(vehicle, Notify::of_environment()));
        let mut robots = WiredRobots::default();
        robots
            .add(&vehicle, &wire.to_string(), experiment.world().spec(), lives, console)
            .map_err(|failure| self.settings.at(failure))?;
        let running = RunningDaemon {
            log: Log::open(directory, 0, self.saved.boots, log::Limits::default()),
            daemon: self,
            vehicle,
            robots,
            notify: Notify::of_environment(),
            began,
        };
        running.run(stop)
    }
}

impl RunningDaemon<'_> {
    fn run(mut self, stop: &AtomicBool) -> Result {
        let experiment = self.daemon.settings.identity.to_hex();
        self.log(
            "start",
            json!({ "program": env!("CARGO_PKG_VERSION"), "experiment": experiment.as_str() }),
        );
        self.log("connected", json!({ "robot": self.robots.describe() }));
        self.notify.ready();
        let outcome = loop {
            if stop.load(Ordering::Relaxed) {
                break Err(Trouble::Stopped.into());
            }
            match self.interval() {
                Ok(true) => {}
                Ok(false) => break Ok(()),
                Err(failure) => break Err(failure),
            }
        };
        self.notify.stopping();
        let stopped = self.with_vehicle(|vehicle| vehicle.stop());
        self.log("end", json!({ "stopped": stopped.is_ok() }));
        outcome.and(stopped)
    }

    /// Runs an interval, and saves it. Returns whether there was anything to do.
    fn interval(&mut self) -> Result<bool> {
        let is_evolving = !self.daemon.saved.is_evolved;
        if is_evolving {
            self.daemon.evolving.ask(());
        }
        let next = self.daemon.saved.next(&self.daemon.settings.rules);
        let next = next.map(|(why, controller)| (why, controller.clone()));
        let is_idle = next.is_none() && !is_evolving;
        if is_idle {
            return Ok(false);
        }
        let status = next.as_ref().map_or("waits for the simulator", |(why, _)| why.word());
        let number = self.daemon.saved.transfers.len();
        self.notify.status(&format!("transfer {number}: {status}"));
        if let Some((why, controller)) = next {
            self.transfer(why, controller)?;
        }
        if is_evolving {
            let evolved = self.evolved()?;
            self.take(evolved);
        }
        self.daemon.keeper.save_now(&self.daemon.saved)?;
        Ok(true)
    }

    /// Lets a controller live on the robot.
    fn transfer(&mut self, why: Why, controller: Champion) -> Result {
        let number = self.daemon.saved.transfers.len();
        let life = Life {
            genes: &controller.genome,
            key: Keys::new(self.daemon.settings.seed, ON_ROBOT).of(0, number as u64),
            start: None,
        };
        let lived = self.robots.live(&[life], false)?;
        let measured = lived.first().map_or(f32::NAN, |lived| lived.fitness);
        self.log(
            "transfer",
            json!({
                "transfer": number, "why": why.word(), "generation": controller.generation,
                "individual": controller.individual, "simulated": controller.fitness, "measured": measured,
            }),
        );
        self.daemon.saved.waiting = None;
        self.daemon.saved.transfers.push(Transfer {
            why,
            controller,
            measured,
        });
        Ok(())
    }

    /// Waits for the simulator, with the wheels stopped.
    fn evolved(&mut self) -> Result<Evolved> {
        loop {
            if let Some(evolved) = self.daemon.evolving.result(self.daemon.waits)? {
                return Ok(evolved);
            }
            self.with_vehicle(|vehicle| vehicle.keep_until(vehicle.now() + PAUSE))?;
        }
    }

    /// Takes what the simulator has left.
    fn take(&mut self, evolved: Evolved) {
        let [worked, taken] = [evolved.worked, evolved.taken].map(|time| time.as_secs_f64());
        let best = evolved.best.as_ref().map(|best| best.fitness);
        self.log(
            "simulated",
            json!({ "generations": evolved.generation, "best": best, "worked_s": worked, "taken_s": taken }),
        );
        let saved = &mut self.daemon.saved;
        saved.waiting = evolved.best;
        saved.evolution = Some(evolved.saved);
        saved.is_evolved = evolved.is_over;
    }

    fn with_vehicle(&self, call: impl FnOnce(&mut dyn Vehicle) -> std::result::Result<(), Trouble>) -> Result {
        match &mut *self.vehicle.lock() {
            Some(vehicle) => call(&mut **vehicle).map_err(Failure::from),
            None => Ok(()),
        }
    }

    fn log(&self, event: &str, fields: Value) {
        let now = self.vehicle.lock().as_ref().map_or(self.began, |vehicle| vehicle.now());
        self.log.event(now.saturating_sub(self.began), None, event, fields);
    }
}

#[cfg(test)]
mod tests;
