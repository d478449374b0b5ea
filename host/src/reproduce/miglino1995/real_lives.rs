//! Real lives, and where each of them starts. As preregistered the robot is carried to a fresh place for each; in other
//! arms its lives follow one another, as those of a robot that nobody picks up.

use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::Surrogate;
use oneiro::world::{Start, World, WorldSpec};

use super::study::{Evolving, Trial, by_run, lives};
use crate::exit::Result;
use crate::reality::surrogate::{Evaluations, SurrogateRobot};
use crate::reality::{Life, Lived, Reality, patiently};

/// How the robot gets to the start of a life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RealStarts {
    /// It is put at a fresh free pose.
    Fresh,
    /// It stays where the last life of the same run stopped.
    Continuing,
    /// From there it drives about for [`WALK`] cycles, and starts where it then is.
    Walk,
}

/// Cycles of 100 ms that a robot drives about between two lives.
const WALK: u32 = 100;
/// Lives between lives are numbered from here on among an individual's lives.
const WALKS: u64 = 16;

/// A robot that lives the lives of some runs: one after the other within a run, and all runs beside one another, as
/// if each had an arena to itself.
pub(crate) struct RealLives<'a> {
    starts: RealStarts,
    robot: SurrogateRobot<'a>,
    /// The same robot, for [`WALK`] cycles.
    walker: SurrogateRobot<'a>,
    world: WorldSpec,
    /// Where the last life of each run stopped: x and y in mm, heading in turns. None: nowhere yet, or where the body
    /// touches an object by a rounding, from where no life can start. The next life then starts at a fresh free pose.
    places: Vec<Option<[f32; 3]>>,
}

impl<'a> RealLives<'a> {
    /// A robot that has not lived yet, in the world of `world`.
    ///
    /// # Errors
    /// Exit 3 with what the world does not allow.
    pub(crate) fn new(
        evaluations: &'a Evaluations,
        seed: u64,
        surrogate: &Surrogate,
        world: &WorldSpec,
        starts: RealStarts,
    ) -> Result<Self> {
        let walk = WorldSpec {
            cycles: WALK,
            ..world.clone()
        };
        Ok(Self {
            starts,
            robot: SurrogateRobot::new(evaluations, seed, surrogate.clone(), world)?,
            walker: SurrogateRobot::new(evaluations, seed, surrogate.clone(), &walk)?,
            world: world.clone(),
            places: Vec::new(),
        })
    }

    /// One life of each individual of each run, in the order of the individuals. A run is known by its place among the
    /// runs, which must be the same in each call.
    pub(super) fn live(&mut self, runs: &[Evolving], trial: Trial) -> Result<Vec<Vec<f32>>> {
        let lives: Vec<Vec<Life<'_>>> = runs.iter().map(|run| lives(run, trial).collect()).collect();
        if self.starts == RealStarts::Fresh {
            let lived = patiently(|| self.robot.live(&lives.concat(), false))?;
            return Ok(by_run(runs, lived.into_iter().map(|life| life.fitness).collect()));
        }
        self.places.resize(runs.len(), None);
        let mut fitness = vec![Vec::new(); runs.len()];
        for individual in 0..lives.iter().map(Vec::len).max().unwrap_or(0) {
            if self.starts == RealStarts::Walk {
                self.drive_about(runs, trial, individual as u64)?;
            }
            let turn: Vec<usize> = (0..runs.len()).filter(|&run| individual < lives[run].len()).collect();
            let now: Vec<Life<'_>> = turn
                .iter()
                .map(|&run| Life {
                    start: self.places[run],
                    ..lives[run][individual]
                })
                .collect();
            let lived = patiently(|| self.robot.live(&now, true))?;
            for (run, lived) in turn.into_iter().zip(lived) {
                self.places[run] = self.stopped(&lived);
                fitness[run].push(lived.fitness);
            }
        }
        Ok(fitness)
    }

    /// Drives from where the last lives stopped, if any did, under controllers of random genes that go ahead where
    /// they see nothing.
    fn drive_about(&mut self, runs: &[Evolving], trial: Trial, individual: u64) -> Result<()> {
        let turn: Vec<usize> = (0..runs.len()).filter(|&run| self.places[run].is_some()).collect();
        if turn.is_empty() {
            return Ok(());
        }
        let keys: Vec<Key> = turn
            .iter()
            .map(|&run| {
                let generation = u64::from(runs[run].evolution.generation());
                Key::rollout(runs[run].seed, generation, individual, WALKS + trial as u64)
            })
            .collect();
        let genomes: Vec<Vec<f32>> = keys
            .iter()
            .map(|key| wanderer(*key, self.world.controller.genes()))
            .collect();
        let lives: Vec<Life<'_>> = turn
            .iter()
            .zip(&genomes)
            .zip(&keys)
            .map(|((&run, genes), &key)| Life {
                genes,
                key,
                start: self.places[run],
            })
            .collect();
        let lived = patiently(|| self.walker.live(&lives, true))?;
        for (run, lived) in turn.into_iter().zip(lived) {
            self.places[run] = self.stopped(&lived);
        }
        Ok(())
    }

    /// Where a life stopped, if one can start there.
    fn stopped(&self, lived: &Lived) -> Option<[f32; 3]> {
        let last = lived.trace.last()?;
        let (x, y) = (last.x, last.y);
        // A turn that a rounding made whole is none.
        let heading = if last.heading < 1.0 { last.heading } else { 0.0 };
        let world = World::new(WorldSpec {
            start: Start::At { x, y, heading },
            ..self.world.clone()
        });
        world.is_ok().then_some([x, y, heading])
    }
}

/// Genes of a perceptron, from its key alone: weights U(-5, 5), which turn anywhere before an object, and biases
/// U(0, 5), which go ahead without.
fn wanderer(key: Key, genes: usize) -> Vec<f32> {
    /// The genes of an output: eight weights, then its bias.
    const OUTPUT: u32 = 9;
    let gene = |gene: u32| {
        let [word, ..] = pcg4d([key.0[0], key.0[1], gene, 1995]);
        let share = (word >> 8) as f32 / (1 << 24) as f32;
        if gene % OUTPUT == OUTPUT - 1 {
            5.0 * share
        } else {
            10.0 * share - 5.0
        }
    };
    (0..genes as u32).map(gene).collect()
}
