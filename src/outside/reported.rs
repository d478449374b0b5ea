//! Episodes outside the kernels: of a real robot, or in somebody else's simulation. Its readings and poses are
//! reported cycle by cycle; the controller decides, and the task rewards, by the same code and with the same bits as in the simulator.
//!
//! ```
//! use oneiro::cpu::Cpu;
//! use oneiro::random::Key;
//! use oneiro::reported::Reported;
//! use oneiro::world::WorldSpec;
//!
//! let world = Reported::new(&WorldSpec { cycles: 2, ..WorldSpec::miglino1995() })?;
//! let mut cpu = Cpu::new(Some(1))?;
//! let mut episode = world.begin(&[0.5; 18], Key::rollout(1, 0, 0, 0), [100.0, 90.0, 0.0])?;
//! // Nothing is seen: it drives ahead, by 3 mm in a cycle of 100 ms.
//! while let Some([left, right]) = episode.speeds(&mut cpu, &[0.0; 8])? {
//!     assert!(left == right && left > 0.0);
//!     let [x, y, heading] = episode.pose();
//!     episode.moved(&mut cpu, [x + 3.0, y, heading])?;
//! }
//! assert!(episode.fitness() > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use oneiro_shaders::{Kernel, episode};

use crate::batch::{Buffers, GREATEST_GENE, Outcome, Rollout, Trace, TraceRequest, WorldKind, Worlds};
use crate::evaluator::{self, Control, Evaluator};
use crate::parameter::Invalid;
use crate::parts::compose::EpisodeKind;
use crate::random::Key;
use crate::world::Build;
use crate::world::differential::Differential;
use crate::world::{Collision, Noise, Robot, World, WorldSpec};

/// Numbers of a pose: x and y in mm, heading in turns.
const POSE: usize = 3;

/// Why a forager can't act outside its simulator.
const FORAGER: &str = "is `forager`, whose food exists only in its simulator; allowed: `sampled` or `differential`";

/// A world whose reality is reported. Of its arena and its sensors only what a user's parts and the task ask for counts.
#[derive(Clone, Debug)]
pub struct Reported {
    world: World,
    worlds: Worlds,
    readings: usize,
}

/// Why a cycle has no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A report isn't allowed.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The device gave no result.
    #[error(transparent)]
    Device(#[from] evaluator::Error),
}

impl Reported {
    /// Takes the controller, the task, users' parts and the number of cycles of a simulated world. Noise, collisions, latency and
    /// acceleration are reality's own.
    ///
    /// # Errors
    /// The first invalid value. Without the feature `compose`, always.
    pub fn new(spec: &WorldSpec) -> Result<Self, Invalid> {
        let build = match &spec.robot.build {
            Build::Sampled => Build::Sampled,
            Build::Forager(_) => return Err(Invalid::new("robot.kind", FORAGER)),
            Build::Differential(robot) => Build::Differential(Differential {
                acceleration: None,
                latency: None,
                ..robot.clone()
            }),
        };
        let readings = build.readings().len();
        let world = World::composed(
            WorldSpec {
                robot: Robot {
                    collision: Collision::Undo,
                    build,
                    ..spec.robot.clone()
                },
                surrogate: None,
                noise: Noise::NONE,
                ..spec.clone()
            },
            EpisodeKind::Reported,
            None,
        )?;
        Ok(Self {
            worlds: Worlds::new(&[Packed(&world, readings)])?,
            readings,
            world,
        })
    }

    /// Its controller, its task, and the details of its traces.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Number of readings that are reported in a cycle: those of the robot, without those of a user's sensors, which are computed
    /// from its pose.
    pub fn readings(&self) -> usize {
        self.readings
    }

    /// Begins an episode with a genome, at x and y in mm and a heading in turns.
    ///
    /// # Errors
    /// Genes that are too many, too few, not finite or beyond [`GREATEST_GENE`], and likewise the pose.
    pub fn begin(&self, genes: &[f32], key: Key, start: [f32; POSE]) -> Result<Episode<'_>, Invalid> {
        if genes.len() != self.world.genes() {
            let problem = format!("are {}; allowed: {}", genes.len(), self.world.genes());
            return Err(Invalid::new("genes", problem));
        }
        check("start", &start)?;
        let inputs = [&vec![0.0; self.readings][..], &start, &start, genes].concat();
        // Genes are checked as those of any episode.
        self.worlds.stretch(&[rollout(&inputs, key)], 0..1, &[], None)?;
        Ok(Episode {
            world: self,
            inputs,
            key,
            cycle: 0,
            state: Vec::new(),
            pose: start,
            fitness: 0.0,
        })
    }
}

fn rollout(inputs: &[f32], key: Key) -> Rollout<'_> {
    Rollout {
        world: 0,
        genes: inputs,
        key,
    }
}

pub(super) fn check(field: &str, numbers: &[f32]) -> Result<(), Invalid> {
    let is_allowed = |number: &f32| number.abs() <= GREATEST_GENE;
    match numbers.iter().position(|number| !is_allowed(number)) {
        None => Ok(()),
        Some(index) => {
            let problem = format!("is {}; allowed: up to {GREATEST_GENE} either way", numbers[index]);
            Err(Invalid::new(format!("{field}[{index}]"), problem))
        }
    }
}

/// A world with room for reports before the genes.
struct Packed<'a>(&'a World, usize);

impl WorldKind for Packed<'_> {
    fn check(&self) -> Result<(), Invalid> {
        Ok(())
    }

    fn kernel(&self) -> &'static Kernel {
        self.0.kernel()
    }

    fn genes(&self) -> usize {
        self.1 + 2 * POSE + self.0.genes()
    }

    fn may_end_early(&self) -> bool {
        self.0.may_end_early()
    }

    fn pack(&self, variant: usize, buffers: &mut Buffers) -> episode::World {
        self.0.pack(variant, buffers)
    }
}

/// An episode in progress. Each cycle is a call of [`Episode::speeds`], and one of [`Episode::moved`] when the cycle has passed.
#[derive(Clone, Debug)]
pub struct Episode<'a> {
    world: &'a Reported,
    /// Readings, the pose at the start, the pose at the end of the cycle, and the genes.
    inputs: Vec<f32>,
    key: Key,
    /// Cycles that have passed.
    cycle: u32,
    /// What the parts remember; empty at first.
    state: Vec<Vec<u32>>,
    pose: [f32; POSE],
    fitness: f32,
}

impl Episode<'_> {
    /// Speeds of the left and of the right wheel that the controller commands for the next cycle, as fractions of the maximum, -1 to 1;
    /// none once the episode is over. Readings are activations as the controller knows them; most robots' are 0 to 1.
    ///
    /// # Errors
    /// Another number of readings, or one that isn't finite or beyond [`GREATEST_GENE`]; those of the device.
    pub fn speeds(&mut self, device: &mut dyn Evaluator, readings: &[f32]) -> Result<Option<[f32; 2]>, Error> {
        if readings.len() != self.world.readings {
            let problem = format!("are {}; allowed: {}", readings.len(), self.world.readings);
            return Err(Invalid::new("readings", problem).into());
        }
        check("readings", readings)?;
        self.inputs[..readings.len()].copy_from_slice(readings);
        let pose = self.pose;
        // Where the cycle ends is not known yet, and the controller doesn't ask.
        let outcome = self.simulate(device, pose)?;
        Ok(outcome.and_then(|outcome| {
            let record = outcome.traces.first()?.first()?;
            Some([record.speed_left, record.speed_right])
        }))
    }

    /// Completes the cycle that [`Episode::speeds`] began, with the pose where it has ended, and returns its trace: one record, or none
    /// if the episode was over.
    ///
    /// # Errors
    /// A pose that isn't finite or beyond [`GREATEST_GENE`]; those of the device.
    pub fn moved(&mut self, device: &mut dyn Evaluator, end: [f32; POSE]) -> Result<Trace, Error> {
        check("end", &end)?;
        let Some(mut outcome) = self.simulate(device, end)? else {
            return Ok(Trace::default());
        };
        let trace = outcome.traces.pop().unwrap_or_default();
        if !trace.is_empty() {
            self.cycle += 1;
            self.pose = end;
            self.fitness = outcome.fitness[0];
            self.state = outcome.states;
        }
        Ok(trace)
    }

    /// The next cycle, if there is one.
    fn simulate(&mut self, device: &mut dyn Evaluator, end: [f32; POSE]) -> Result<Option<Outcome>, Error> {
        if self.cycle >= self.world.world.cycles() {
            return Ok(None);
        }
        let first = self.world.readings + POSE;
        self.inputs[first..first + POSE].copy_from_slice(&end);
        let batch = self.world.worlds.stretch(
            &[rollout(&self.inputs, self.key)],
            self.cycle..self.cycle + 1,
            &self.state,
            Some(TraceRequest { every: 1 }),
        )?;
        Ok(Some(device.evaluate(&batch, &Control::new())?))
    }

    /// Cycles that have passed.
    pub fn cycles(&self) -> u32 {
        self.cycle
    }

    /// The pose at the end of the last cycle.
    pub fn pose(&self) -> [f32; POSE] {
        self.pose
    }

    /// The fitness so far.
    pub fn fitness(&self) -> f32 {
        self.fitness
    }
}
