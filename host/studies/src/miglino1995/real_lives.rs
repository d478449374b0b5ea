//! Real lives and their starts. As preregistered, the robot is carried to a fresh place for each life; in other arms
//! its lives follow one another, as for a robot that nobody picks up. A robot on a wire has one arena for all runs, and gets to its
//! starts by itself.

use oneiro::batch::Trace;
use oneiro::random::Key;
use oneiro::tables::SENSORS;
use oneiro::world::{Start, World, WorldSpec};
use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_evolve::Optimizer;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::reality::site::Site;
use oneiro_lab::reality::wander::{WALK, wanderer};
use oneiro_lab::reality::{Life, Lived, Reality, patiently};

use super::evolving::{Evolving, Trial, by_run, lives};
use super::settings::RealStarts;

/// First number of the drives between lives among an individual's lives.
const WALKS: u64 = 16;

/// A robot that lives the lives of several runs: one after another within a run, and all runs in parallel, as if each
/// had its own arena.
pub(crate) struct RealLives<'a> {
    starts: RealStarts,
    robot: Box<dyn Reality + 'a>,
    /// The same robot with lives of [`WALK`] cycles, if it drives about between lives.
    walker: Option<Box<dyn Reality + 'a>>,
    /// Where each life is announced, if it takes the time that it takes.
    announced: Option<Console>,
    world: WorldSpec,
    /// Where the last life of each run stopped: x and y in mm, heading in turns. `None` before the first life, or if
    /// rounding leaves the body touching an object, where no life can start. The next life then starts at a fresh free
    /// pose; in 33,000 lives this never happened.
    places: Vec<Option<[f32; 3]>>,
}

impl<'a> RealLives<'a> {
    /// Places a robot in the world of `world`, before its first life.
    ///
    /// # Errors
    /// Exit 3 with the reason why the world is invalid; as the connection and the record of a robot on a wire.
    pub(crate) fn new(
        evaluations: &'a Engine,
        site: &Site,
        world: &WorldSpec,
        starts: RealStarts,
        console: Console,
    ) -> Result<Self> {
        let walk = || WorldSpec {
            cycles: WALK,
            ..world.clone()
        };
        let walker = (starts == RealStarts::Walk).then(|| site.open(evaluations, &walk()));
        Ok(Self {
            starts,
            robot: site.open(evaluations, world)?,
            walker: walker.transpose()?,
            announced: site.is_wired().then_some(console),
            world: world.clone(),
            places: Vec::new(),
        })
    }

    /// Lives one life of each individual of each run, in the order of the individuals. A run is identified by its index
    /// in `runs`, which must be the same in each call.
    pub(super) fn live(&mut self, runs: &[Evolving], trial: Trial) -> Result<Vec<Vec<f32>>> {
        let lives: Vec<Vec<Life<'_>>> = runs.iter().map(|run| lives(run, trial).collect()).collect();
        if let Some(console) = self.announced {
            let each = runs.iter().zip(lives);
            let fitness = each.map(|(run, lives)| self.one_by_one(run, &lives, trial, console));
            return fitness.collect();
        }
        if self.starts == RealStarts::Fresh {
            let lived = patiently(|| self.robot.live(&lives.concat(), false))?;
            return Ok(by_run(runs, lived.into_iter().map(|life| life.fitness).collect()));
        }
        self.places.resize(runs.len(), None);
        let mut fitness = vec![Vec::new(); runs.len()];
        for individual in 0..lives.iter().map(Vec::len).max().unwrap_or(0) {
            self.drive_about(runs, trial, individual as u64)?;
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

    /// The same for lives that are no part of the sequence: it goes on from where it was before.
    pub(super) fn aside(&mut self, runs: &[Evolving], trial: Trial) -> Result<Vec<Vec<f32>>> {
        let places = std::mem::take(&mut self.places);
        let fitness = self.live(runs, trial)?;
        self.places = places;
        Ok(fitness)
    }

    /// Lives lives from starts of their own, with traces that have a record more than cycles.
    pub(super) fn traced(&mut self, lives: &[Life<'_>]) -> Result<Vec<Trace>> {
        let lived = match self.announced {
            Some(_) => self.robot.live(lives, true)?,
            None => patiently(|| self.robot.live(lives, true))?,
        };
        Ok(lived.into_iter().map(|lived| lived.trace).collect())
    }

    /// Lives the lives of a run's generation on a robot on a wire, which has a patience of its own.
    fn one_by_one(&mut self, run: &Evolving, lives: &[Life<'_>], trial: Trial, console: Console) -> Result<Vec<f32>> {
        let mut fitness = Vec::with_capacity(lives.len());
        for (individual, life) in lives.iter().enumerate() {
            if !self.robot.has_lived(life) {
                console.say(format!(
                    "{}, run {}: generation {}, individual {individual} (0 to {}){}",
                    run.condition.title(),
                    run.number,
                    run.evolution.generation(),
                    lives.len() - 1,
                    trial.again()
                ));
            }
            let lived = self.robot.live(std::slice::from_ref(life), false)?;
            fitness.extend(lived.into_iter().map(|life| life.fitness));
        }
        Ok(fitness)
    }

    /// Drives on from where the last lives stopped, if that is how lives follow one another, under controllers with random genes
    /// that go straight ahead if they see nothing.
    fn drive_about(&mut self, runs: &[Evolving], trial: Trial, individual: u64) -> Result<()> {
        let Some(walker) = &mut self.walker else { return Ok(()) };
        let turn: Vec<usize> = (0..runs.len()).filter(|&run| self.places[run].is_some()).collect();
        if turn.is_empty() {
            return Ok(());
        }
        let keys: Vec<Key> = turn
            .iter()
            .map(|&run| {
                let generation = u64::from(runs[run].evolution.generation());
                Key::rollout(runs[run].seed, generation, individual, WALKS + trial.number())
            })
            .collect();
        let genomes: Vec<Vec<f32>> = keys
            .iter()
            .map(|key| wanderer(*key, SENSORS, self.world.controller.layout().genes()))
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
        let lived = patiently(|| walker.live(&lives, true))?;
        for (run, lived) in turn.into_iter().zip(lived) {
            self.places[run] = self.stopped(&lived);
        }
        Ok(())
    }

    /// The pose where a life stopped, if a life can start there.
    fn stopped(&self, lived: &Lived) -> Option<[f32; 3]> {
        let last = lived.trace.last()?;
        let (x, y) = (last.x, last.y);
        // Rounding can turn a heading into a whole turn, which is 0.
        let heading = if last.heading < 1.0 { last.heading } else { 0.0 };
        let world = World::new(WorldSpec {
            start: Start::At { x, y, heading },
            ..self.world.clone()
        });
        world.is_ok().then_some([x, y, heading])
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::Condition;
    use super::super::settings::Settings;
    use super::super::tests::{self, evaluations};
    use super::*;

    /// Reality uses part of the samples' grid.
    fn settings(arm: &str) -> Settings {
        tests::settings(arm, 0.5)
    }

    /// Lives some real lives of two runs' first generation; also returns where each run stopped.
    fn lived(arm: &str, numbers: &[u32]) -> (Vec<Vec<f32>>, Vec<Option<[f32; 3]>>) {
        let (settings, evaluations) = (settings(arm), evaluations());
        let study = tests::study(&settings, &evaluations);
        let runs: Vec<Evolving> = numbers
            .iter()
            .map(|&number| study.begin(Condition::None, number))
            .collect();
        let mut robot = study.real_lives(&settings.site()).unwrap();
        let fitness = robot.live(&runs, Trial::Real).unwrap();
        (fitness, robot.places)
    }

    /// One life of a run per call.
    #[test]
    fn a_life_starts_where_the_last_one_stopped() {
        let (settings, evaluations) = (settings("real-starts-continuing"), evaluations());
        let study = tests::study(&settings, &evaluations);
        let run = study.begin(Condition::None, 1);
        let world = settings.world();
        let mut robot = settings.site().open(&evaluations, &world).unwrap();
        let mut start = None;
        let mut expected = Vec::new();
        let mut continued = 0;
        for life in lives(&run, Trial::Real) {
            continued += u32::from(start.is_some());
            let lived = robot.live(&[Life { start, ..life }], true).unwrap().remove(0);
            assert_eq!(lived.trace.len(), 501, "500 cycles, and where they end");
            let end = lived.trace[500];
            let at = Start::At {
                x: end.x,
                y: end.y,
                heading: end.heading,
            };
            let free = World::new(WorldSpec {
                start: at,
                ..world.clone()
            });
            start = free.is_ok().then_some([end.x, end.y, end.heading]);
            expected.push(lived.fitness);
        }
        assert!(continued > 50, "{continued} of 99 lives go on from the last");
        let (fitness, places) = lived("real-starts-continuing", &[0, 1]);
        assert_eq!(fitness[1], expected);
        assert_eq!(places[1], start);
    }

    #[test]
    fn only_the_first_life_is_the_one_from_a_fresh_start() {
        let fresh = lived("main", &[0]);
        let continuing = lived("real-starts-continuing", &[0]);
        let walk = lived("real-starts-walk", &[0]);
        assert_eq!(fresh.1, []);
        let others = [
            (&fresh.0[0], &continuing.0[0]),
            (&fresh.0[0], &walk.0[0]),
            (&continuing.0[0], &walk.0[0]),
        ];
        for (one, other) in others {
            assert_eq!(one[0].to_bits(), other[0].to_bits());
            let different = one.iter().zip(other).filter(|(one, other)| one != other).count();
            assert!(different > 50, "{different} of 99 lives differ");
        }
    }

    /// Interpolating the simulator's tables leaves reality alone: its grid is that of the samples.
    #[test]
    fn interpolated_tables_leave_reality_as_it_is() {
        assert_eq!(lived("interpolated", &[0]), lived("main", &[0]));
    }

    /// Parallel runs don't affect one another.
    #[test]
    fn a_run_lives_as_if_it_were_alone() {
        for arm in ["real-starts-continuing", "real-starts-walk"] {
            let (both, places) = lived(arm, &[0, 1]);
            let (alone, place) = lived(arm, &[1]);
            assert_eq!((&both[1], places[1]), (&alone[0], place[0]), "{arm:?}");
        }
    }
}
