//! Real episodes and their starts. As preregistered, the robot is carried to a fresh place for each episode. In other
//! arms, an episode starts where the last one stopped, as for a robot that nobody picks up. A connected robot has one
//! arena for all runs, and drives to its starts itself.

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

use super::evolving::{Evolving, Trial, by_run, episodes};
use super::settings::RealStarts;

/// An individual's first number for the drives between episodes.
const WALKS: u64 = 16;

/// A robot that runs the episodes of several runs: one after another within a run, and all runs in parallel, as if each
/// had its arena.
pub(crate) struct RealEpisodes<'a> {
    starts: RealStarts,
    robot: Box<dyn Reality + 'a>,
    /// The same robot with episodes of [`WALK`] cycles, if it drives about between episodes.
    walker: Option<Box<dyn Reality + 'a>>,
    /// Where each episode is announced, if it runs in real time.
    announced: Option<Console>,
    world: WorldSpec,
    /// Where each run's last episode stopped: x and y in mm, heading in turns. `None` before the first episode, or if
    /// rounding leaves the body touching an object, where no episode can start. The next one then starts at a fresh
    /// free pose; in 33,000 episodes this never happened.
    places: Vec<Option<[f32; 3]>>,
}

impl<'a> RealEpisodes<'a> {
    /// Places a robot in the world of `world`, before its first episode.
    ///
    /// # Errors
    /// Exit 3 with the reason why the world is invalid. For a connected robot, those of its connection and its record.
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

    /// Runs an episode of each individual of each run, in the order of the individuals. A run is identified by its
    /// index in `runs`, which must be the same in each call.
    pub(super) fn run(&mut self, runs: &[Evolving], trial: Trial) -> Result<Vec<Vec<f32>>> {
        let episodes: Vec<Vec<Life<'_>>> = runs.iter().map(|run| episodes(run, trial).collect()).collect();
        if let Some(console) = self.announced {
            let each = runs.iter().zip(episodes);
            let fitness = each.map(|(run, episodes)| self.one_by_one(run, &episodes, trial, console));
            return fitness.collect();
        }
        if self.starts == RealStarts::Fresh {
            let lived = patiently(|| self.robot.live(&episodes.concat(), false))?;
            return Ok(by_run(runs, lived.into_iter().map(|episode| episode.fitness).collect()));
        }
        self.places.resize(runs.len(), None);
        let mut fitness = vec![Vec::new(); runs.len()];
        for individual in 0..episodes.iter().map(Vec::len).max().unwrap_or(0) {
            self.drive_about(runs, trial, individual as u64)?;
            let turn: Vec<usize> = (0..runs.len())
                .filter(|&run| individual < episodes[run].len())
                .collect();
            let now: Vec<Life<'_>> = turn
                .iter()
                .map(|&run| Life {
                    start: self.places[run],
                    ..episodes[run][individual]
                })
                .collect();
            let lived = patiently(|| self.robot.live(&now, true))?;
            for (run, lived) in turn.into_iter().zip(lived) {
                self.places[run] = self.end_pose(&lived);
                fitness[run].push(lived.fitness);
            }
        }
        Ok(fitness)
    }

    /// The same for episodes outside the sequence, which then continues from its last place.
    pub(super) fn aside(&mut self, runs: &[Evolving], trial: Trial) -> Result<Vec<Vec<f32>>> {
        let places = std::mem::take(&mut self.places);
        let fitness = self.run(runs, trial)?;
        self.places = places;
        Ok(fitness)
    }

    /// Runs episodes with their given starts. Traces have one record more than cycles.
    pub(super) fn run_with_traces(&mut self, episodes: &[Life<'_>]) -> Result<Vec<Trace>> {
        let lived = match self.announced {
            Some(_) => self.robot.live(episodes, true)?,
            None => patiently(|| self.robot.live(episodes, true))?,
        };
        Ok(lived.into_iter().map(|lived| lived.trace).collect())
    }

    /// Runs the episodes of a run's generation on a connected robot, which has its limit of patience.
    fn one_by_one(
        &mut self,
        run: &Evolving,
        episodes: &[Life<'_>],
        trial: Trial,
        console: Console,
    ) -> Result<Vec<f32>> {
        let mut fitness = Vec::with_capacity(episodes.len());
        for (individual, episode) in episodes.iter().enumerate() {
            if !self.robot.has_lived(episode) {
                console.say(format!(
                    "{}, run {}: generation {}, individual {individual} (0 to {}){}",
                    run.condition.title(),
                    run.number,
                    run.evolution.generation(),
                    episodes.len() - 1,
                    trial.again()
                ));
            }
            let lived = self.robot.live(std::slice::from_ref(episode), false)?;
            fitness.extend(lived.into_iter().map(|episode| episode.fitness));
        }
        Ok(fitness)
    }

    /// Drives on from where the last episodes stopped, if that is how episodes follow one another, under controllers
    /// with random genes that go straight ahead if they see nothing.
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
        let episodes: Vec<Life<'_>> = turn
            .iter()
            .zip(&genomes)
            .zip(&keys)
            .map(|((&run, genes), &key)| Life {
                genes,
                key,
                start: self.places[run],
            })
            .collect();
        let lived = patiently(|| walker.live(&episodes, true))?;
        for (run, lived) in turn.into_iter().zip(lived) {
            self.places[run] = self.end_pose(&lived);
        }
        Ok(())
    }

    /// The pose where an episode stopped, if an episode can start there.
    fn end_pose(&self, lived: &Lived) -> Option<[f32; 3]> {
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

    /// Runs some real episodes of two runs' first generation; also returns where each run stopped.
    fn run_real_episodes(arm: &str, numbers: &[u32]) -> (Vec<Vec<f32>>, Vec<Option<[f32; 3]>>) {
        let (settings, evaluations) = (settings(arm), evaluations());
        let study = tests::study(&settings, &evaluations);
        let runs: Vec<Evolving> = numbers
            .iter()
            .map(|&number| study.begin(Condition::None, number))
            .collect();
        let mut robot = study.real_episodes(&settings.site()).unwrap();
        let fitness = robot.run(&runs, Trial::Real).unwrap();
        (fitness, robot.places)
    }

    /// One episode of a run per call.
    #[test]
    fn an_episode_starts_where_the_last_one_stopped() {
        let (settings, evaluations) = (settings("real-starts-continuing"), evaluations());
        let study = tests::study(&settings, &evaluations);
        let run = study.begin(Condition::None, 1);
        let world = settings.world();
        let mut robot = settings.site().open(&evaluations, &world).unwrap();
        let mut start = None;
        let mut expected = Vec::new();
        let mut continued = 0;
        for episode in episodes(&run, Trial::Real) {
            continued += u32::from(start.is_some());
            let lived = robot.live(&[Life { start, ..episode }], true).unwrap().remove(0);
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
        assert!(continued > 50, "{continued} of 99 episodes go on from the last");
        let (fitness, places) = run_real_episodes("real-starts-continuing", &[0, 1]);
        assert_eq!(fitness[1], expected);
        assert_eq!(places[1], start);
    }

    #[test]
    fn only_the_first_episode_is_the_one_from_a_fresh_start() {
        let fresh = run_real_episodes("main", &[0]);
        let continuing = run_real_episodes("real-starts-continuing", &[0]);
        let walk = run_real_episodes("real-starts-walk", &[0]);
        assert_eq!(fresh.1, []);
        let others = [
            (&fresh.0[0], &continuing.0[0]),
            (&fresh.0[0], &walk.0[0]),
            (&continuing.0[0], &walk.0[0]),
        ];
        for (one, other) in others {
            assert_eq!(one[0].to_bits(), other[0].to_bits());
            let different = one.iter().zip(other).filter(|(one, other)| one != other).count();
            assert!(different > 50, "{different} of 99 episodes differ");
        }
    }

    /// Interpolating the simulator's tables does not change reality, whose grid is that of the samples.
    #[test]
    fn interpolated_tables_leave_reality_as_it_is() {
        assert_eq!(run_real_episodes("interpolated", &[0]), run_real_episodes("main", &[0]));
    }

    /// Parallel runs don't affect one another.
    #[test]
    fn runs_do_not_affect_each_other() {
        for arm in ["real-starts-continuing", "real-starts-walk"] {
            let (both, places) = run_real_episodes(arm, &[0, 1]);
            let (alone, place) = run_real_episodes(arm, &[1]);
            assert_eq!((&both[1], places[1]), (&alone[0], place[0]), "{arm:?}");
        }
    }
}
