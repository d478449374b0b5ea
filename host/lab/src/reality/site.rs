//! The site of reality: which robot it is, where it is, and how to reach it. Only this file names kinds of reality.

use std::fmt;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use oneiro::batch::Rollout;
use oneiro::differential::Build;
use oneiro::evaluator::Error;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Collision, Noise, Robot, World, WorldSpec};
use oneiro_base::console::Console;
use oneiro_base::exit::{Code, Failure};
use oneiro_robots::Kind;
use oneiro_robots::address::{Address, Wire};
use oneiro_robots::guard;
use oneiro_robots::guard::wheels::Wanted;
#[cfg(any(test, feature = "testing"))]
use oneiro_robots::vehicle::Vehicle;
use oneiro_robots::vehicle::guarded::{Guarded, Options};

use super::surrogate::SurrogateRobot;
use super::wired::{self, Shared, Time, WiredRobots};
use super::{Life, Reality, Sampled, Trouble};
use crate::engine::handle::Engine;
use crate::engine::job::Outside;
use crate::engine::queue::Interruption;

/// How much a surrogate differs from the simulator made from its samples, unless another value is given: chosen by the
/// calibration of `studies/preregistration-1995.md`, on the condition without noise and on other robots.
pub const SEVERITY: f32 = 1.75;

/// A robot in its surroundings.
#[derive(Clone, Debug, PartialEq)]
pub enum Site {
    /// A simulation that represents it.
    Surrogate {
        /// Draws the randomness of sampling.
        seed: u64,
        /// The simulation.
        surrogate: Arc<Surrogate>,
    },
    /// Connected robots.
    Wired(Wired),
}

/// One connected robot, or several that share the episodes. All clones share their connections, which are opened at first use.
#[derive(Clone)]
pub struct Wired {
    wires: Vec<Wire>,
    values: wired::Values,
    /// Settings of the guards.
    guard: Vec<String>,
    console: Console,
    /// One for each address.
    robots: Vec<Shared>,
}

impl Wired {
    /// Robots that are not connected yet. Their guards have these settings, each written `KEY=VALUE`.
    ///
    /// # Errors
    /// A robot that occurs twice, or another number of trackers.
    pub fn new(wires: Vec<Wire>, values: wired::Values, guard: &[String], console: Console) -> Result<Self, String> {
        let is_twice = |(at, wire): (usize, &Wire)| wires[..at].contains(wire).then(|| wire.clone());
        if let Some(twice) = wires.iter().enumerate().find_map(is_twice) {
            return Err(format!("names {twice} twice; allowed: each robot once"));
        }
        let (robots, trackers) = (wires.len(), values.trackers.len());
        if trackers > 0 && trackers != robots {
            return Err(format!(
                "there are {robots} robots and {trackers} trackers; allowed: a tracker for each robot, in the same order"
            ));
        }
        Ok(Self {
            robots: wires.iter().map(|_| Shared::default()).collect(),
            wires,
            values,
            guard: wired::guarded(guard),
            console,
        })
    }

    /// The same robots, with episodes recorded in a directory, and messages on a console.
    fn recorded(&self, directory: PathBuf, console: Console) -> Self {
        Self {
            console,
            values: wired::Values {
                directory,
                ..self.values.clone()
            },
            ..self.clone()
        }
    }

    /// Connects to all robots that are not connected yet, and prepares their episodes. Of several, some may fail.
    fn open(&self, stop: &Arc<AtomicBool>, spec: &WorldSpec) -> Result<WiredRobots, Failure> {
        let kinds = wired::check(spec, &self.values, &self.guard)?;
        let outcomes: Vec<Result<(), Failure>> = thread::scope(|scope| {
            let connecting: Vec<_> = (0..self.wires.len())
                .map(|robot| {
                    scope.spawn({
                        let kinds = kinds.clone();
                        move || self.connect(robot, kinds, stop)
                    })
                })
                .collect();
            let joined = connecting
                .into_iter()
                .map(|own| own.join().unwrap_or_else(|panic| resume_unwind(panic)));
            joined.collect()
        });
        let (mut robots, mut failed) = (WiredRobots::default(), None);
        for ((wire, robot), outcome) in self.wires.iter().zip(&self.robots).zip(outcomes) {
            match outcome {
                Ok(()) => robots.add(robot, &wire.to_string(), spec, &self.values, self.console)?,
                Err(failure) if failure.code() == Code::Device as u8 && self.wires.len() > 1 => {
                    self.console.ask(format!("{wire}: takes no episodes: {failure}"));
                    failed.get_or_insert(failure);
                }
                Err(failure) => return Err(failure),
            }
        }
        match failed {
            Some(failure) if robots.count() == 0 => return Err(failure),
            _ => {}
        }
        if self.wires.len() > 1 {
            robots.label();
        }
        Ok(robots)
    }

    /// Connects to a robot that is not connected yet.
    fn connect(&self, robot: usize, kinds: Vec<Kind>, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
        let mut connected = self.robots[robot].lock();
        if connected.is_none() {
            let options = Options {
                wire: self.wires[robot].clone(),
                wanted: Wanted { kinds, odometry: true },
                settings: self.guard.clone(),
                record: None,
                tracker: self.values.trackers.get(robot).cloned(),
                number: (self.wires.len() > 1).then_some(robot + 1),
            };
            *connected = Some(Box::new(Guarded::open(&options, Arc::clone(stop), self.console)?));
        }
        Ok(())
    }

    /// Their addresses, with spaces between them.
    fn addresses(&self) -> String {
        let addresses: Vec<String> = self.wires.iter().map(Wire::to_string).collect();
        addresses.join(" ")
    }
}

impl fmt::Debug for Wired {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?} {:?}", self.addresses(), self.values, self.guard)
    }
}

impl PartialEq for Wired {
    fn eq(&self, other: &Self) -> bool {
        (&self.wires, &self.values, &self.guard) == (&other.wires, &other.values, &other.guard)
    }
}

/// The folder of a run's directory with its episodes on a robot.
pub const LIVES: &str = "lives";

/// A run's episodes on connected robots.
struct OnWire {
    wired: Wired,
    spec: WorldSpec,
    /// Opened for the first episode.
    robots: Mutex<Option<WiredRobots>>,
}

impl fmt::Debug for OnWire {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.wired.fmt(f)
    }
}

impl Outside for OnWire {
    fn live(&self, rollouts: &[Rollout<'_>], stop: &Arc<AtomicBool>) -> Result<Vec<f32>, Interruption> {
        let mut robots = self.robots.lock().unwrap_or_else(PoisonError::into_inner);
        let robots = match &mut *robots {
            Some(robots) => robots,
            none => none.insert(self.wired.open(stop, &self.spec).map_err(Interruption::Outside)?),
        };
        let lives: Vec<Life<'_>> = rollouts
            .iter()
            .map(|rollout| Life {
                genes: rollout.genes,
                key: rollout.key,
                start: None,
            })
            .collect();
        match robots.live(&lives, false) {
            Ok(lived) => Ok(lived.into_iter().map(|life| life.fitness).collect()),
            Err(Trouble::Stopped) => Err(Error::Cancelled.into()),
            Err(trouble) => Err(Interruption::Outside(trouble.into())),
        }
    }
}

impl Site {
    /// The robot at an address, or several connected robots. Two severities scale a surrogate's differences from its simulator:
    /// the first what sensors read, the second motion and the age of readings. Connected robots have values for their episodes
    /// and for their guards.
    ///
    /// # Errors
    /// The problem of the addresses, or of the guard's values.
    pub fn at(
        addresses: &[String],
        differences: Differences,
        values: wired::Values,
        guard: &[String],
    ) -> Result<Self, String> {
        match Robots::at(addresses)? {
            Robots::Surrogate(seed) => Ok(Self::surrogate(seed, Surrogate::drawn(seed, differences))),
            Robots::Wired(wires) => {
                guard::values::Values::of(guard)?;
                Ok(Self::Wired(Wired::new(wires, values, guard, Console::default())?))
            }
        }
    }

    /// A surrogate with all differences from its simulator, scaled by the severity.
    pub fn drawn(seed: u64, severity: f32) -> Self {
        Self::surrogate(seed, Surrogate::drawn(seed, Differences::all(severity)))
    }

    /// A surrogate. The seed draws the randomness of sampling.
    pub fn surrogate(seed: u64, surrogate: Surrogate) -> Self {
        Self::Surrogate {
            seed,
            surrogate: Arc::new(surrogate),
        }
    }

    /// Whether episodes take real time and can't be repeated.
    pub fn is_wired(&self) -> bool {
        matches!(self, Self::Wired(_))
    }

    /// The maximum time of generations with `lives` episodes of `cycles` cycles each; `None` for a simulated robot.
    pub fn generations(&self, generations: u32, lives: u64, cycles: u32) -> Option<Time> {
        match self {
            Self::Wired(wired) => {
                let cycles = cycles + wired.values.walk();
                Some(Time::new(lives, generations, cycles, wired.wires.len()))
            }
            Self::Surrogate { .. } => None,
        }
    }

    /// The maximum time of `lives` episodes of `cycles` cycles each, in words; `None` for a simulated robot.
    pub fn time(&self, lives: u64, cycles: u32) -> Option<String> {
        match self {
            Self::Wired(wired) => Some(wired.values.time(lives, cycles, wired.wires.len())),
            Self::Surrogate { .. } => None,
        }
    }

    /// The same site, with a connected robot's episodes recorded in a directory, and messages on a console.
    pub fn recorded(&self, directory: PathBuf, console: Console) -> Self {
        match self {
            Self::Wired(wired) => Self::Wired(wired.recorded(directory, console)),
            Self::Surrogate { .. } => self.clone(),
        }
    }

    /// The same site with this vehicle as its connected robot, unless it is a surrogate.
    #[cfg(any(test, feature = "testing"))]
    pub fn connected(&self, vehicle: impl Vehicle + Send + 'static) -> Self {
        match self {
            Self::Wired(wired) => Self::Wired(Wired {
                robots: vec![Shared::of(vehicle)],
                ..wired.clone()
            }),
            Self::Surrogate { .. } => self.clone(),
        }
    }

    /// The robot as a place of a run's episodes, recorded in the run's directory, with messages on the run's console; none for a
    /// surrogate, whose episodes are simulated in [`Site::world`].
    pub fn outside(&self, spec: &WorldSpec, directory: &Path, console: Console) -> Option<Arc<dyn Outside>> {
        let Self::Wired(wired) = self else { return None };
        Some(Arc::new(OnWire {
            wired: wired.recorded(directory.join(LIVES), console),
            spec: spec.clone(),
            robots: Mutex::new(None),
        }))
    }

    /// Hash of everything that decides how controllers perform there, apart from the world's other values.
    pub fn hash(&self) -> blake3::Hash {
        match self {
            Self::Surrogate { surrogate, .. } => blake3::hash(format!("{surrogate:?}").as_bytes()),
            Self::Wired(wired) => blake3::hash(format!("{wired:?}").as_bytes()),
        }
    }

    /// Whether episodes of this specification are possible there, as far as this can be checked before a robot is connected.
    ///
    /// # Errors
    /// The problem.
    pub fn allows(&self, spec: &WorldSpec) -> Result<(), String> {
        match self {
            Self::Surrogate { .. } => self.world(spec).map(drop).map_err(|failure| failure.to_string()),
            Self::Wired(own) => wired::possible(spec, &own.values, &own.guard)
                .map(drop)
                .map_err(|failure| failure.to_string()),
        }
    }

    /// The world of its episodes, for batches shared with others, if reality is a simulation. `spec` has everything except its
    /// noise and the effect of a Khepera's collisions.
    ///
    /// # Errors
    /// Exit 3: the first value that the world doesn't allow; a connected robot, always.
    pub fn world(&self, spec: &WorldSpec) -> Result<World, Failure> {
        let (_, surrogate) = self.surrogate_of()?;
        let collision = match spec.robot.build {
            Build::Sampled => Collision::Undo,
            Build::Differential(_) | Build::Forager(_) => spec.robot.collision,
        };
        let world = World::new(WorldSpec {
            surrogate: Some(Arc::clone(surrogate)),
            noise: Noise::NONE,
            robot: Robot {
                collision,
                ..spec.robot.clone()
            },
            ..spec.clone()
        })?;
        Ok(world)
    }

    /// The robot, ready for episodes. `spec` says how it is evaluated, except for its noise and the effect of collisions.
    ///
    /// # Errors
    /// Exit 3 with the value that the world doesn't allow; as a connected robot's connection and record.
    pub fn open<'a>(&self, engine: &'a Engine, spec: &WorldSpec) -> Result<Box<dyn Reality + 'a>, Failure> {
        match self {
            Self::Surrogate { .. } => Ok(Box::new(self.simulated(engine, spec)?)),
            Self::Wired(wired) => Ok(Box::new(wired.open(engine.stop(), spec)?)),
        }
    }

    /// The robot, ready to be sampled without a person.
    ///
    /// # Errors
    /// Exit 3 with the value that the world doesn't allow; for a connected robot, always.
    pub fn sampled<'a>(&self, engine: &'a Engine, spec: &WorldSpec) -> Result<Box<dyn Sampled + 'a>, Failure> {
        Ok(Box::new(self.simulated(engine, spec)?))
    }

    fn simulated<'a>(&self, engine: &'a Engine, spec: &WorldSpec) -> Result<SurrogateRobot<'a>, Failure> {
        let (seed, surrogate) = self.surrogate_of()?;
        Ok(SurrogateRobot::new(
            engine,
            seed,
            Arc::clone(surrogate),
            self.world(spec)?,
        ))
    }

    /// The seed and the simulation of a surrogate.
    fn surrogate_of(&self) -> Result<(u64, &Arc<Surrogate>), Failure> {
        match self {
            Self::Surrogate { seed, surrogate } => Ok((*seed, surrogate)),
            Self::Wired(_) => Err(Failure::input(
                "a connected robot can't be simulated; allowed: surrogate:SEED",
            )),
        }
    }
}

/// Where robots are.
pub enum Robots {
    /// A surrogate, by its seed.
    Surrogate(u64),
    /// One or more connected robots.
    Wired(Vec<Wire>),
}

impl Robots {
    /// The robots at some addresses.
    ///
    /// # Errors
    /// The problem of an address, or of several.
    pub fn at(addresses: &[String]) -> Result<Self, String> {
        let of = |address: &String| address.parse().map_err(|invalid| format!("{invalid}"));
        let all: Vec<Address> = addresses.iter().map(of).collect::<Result<_, _>>()?;
        if let [Address::Surrogate(seed)] = all[..] {
            return Ok(Self::Surrogate(seed));
        }
        let wire = |address| match address {
            Address::Wire(wire) => Ok(wire),
            Address::Surrogate(seed) => Err(format!(
                "names surrogate:{seed} with other robots; allowed: one surrogate alone, or connected robots"
            )),
        };
        let wires: Vec<Wire> = all.into_iter().map(wire).collect::<Result<_, _>>()?;
        if wires.is_empty() {
            return Err("names no robot; allowed: an address, or a list of several".into());
        }
        Ok(Self::Wired(wires))
    }
}

/// A robot's address.
///
/// # Errors
/// Exit 3 with the problem of the address, and what is allowed.
pub fn address(text: &str) -> Result<Address, Failure> {
    text.parse()
        .map_err(|invalid| Failure::input(format_args!("--robot: {invalid}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_parsed() {
        assert_eq!(address("surrogate:17").unwrap(), Address::Surrogate(17));
        for bad in [
            "surrogate",
            "surrogate:",
            "surrogate:-1",
            "surrogate:1.0",
            "khepera:1",
            "",
        ] {
            assert!(address(bad).unwrap_err().to_string().contains("allowed: "), "{bad}");
        }
    }

    #[test]
    fn sites_differ_by_robot_and_severity() {
        let hash = |seed, severity| Site::drawn(seed, severity).hash();
        assert_eq!(hash(1, 1.0), hash(1, 1.0));
        assert_ne!(hash(1, 1.0), hash(2, 1.0));
        assert_ne!(hash(1, 1.0), hash(1, 1.5));
    }
}
