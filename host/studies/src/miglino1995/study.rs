//! The study itself: evolves in simulation, transfers to reality, evolves on, and re-evaluates champions. Its results
//! depend only on its settings and tables. Runs advance together so that their generations share each batch.
//!
//! Its runs are not [jobs](oneiro_lab::engine::job) of the engine. A job selects by the fitness of its episodes, and
//! each of its episodes is independent. Here another criterion may select, a real episode may begin where the last one
//! ended, real and simulated episodes have different keys, controls continue from the transferred generation in three
//! other ways, and champions are compared with other runs' champions. A job could take over only the loop over
//! simulated generations, ten lines that already share every batch. A version with jobs had the same bits, was longer
//! and took more processor time (`docs/measurements.md`, the surrogate and the 1995 study).
//!
//! A connected robot needs no checkpoint: the simulated generations take seconds and are the same each time, and each
//! complete real episode is recorded. A stopped study begins again, and runs the missing episodes.

use std::ops::Range;
use std::sync::Arc;

use oneiro::arena::Field;
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Difference, Differences, Surrogate};
use oneiro::tables::SensorTables;
use oneiro::world::{Collision, Noise, Robot, Start, Task, World, WorldSpec};
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Optimizer;
use oneiro_evolve::genetic::Genetic;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::reality;
use oneiro_lab::reality::site::Site;
use oneiro_statistics::cohens_d;

use super::evolving::{Evolving, Trial, by_run, episodes};
use super::measures::{Cells, Moment, Pair, Sums, effect};
use super::real_episodes::RealEpisodes;
use super::results::{Champion, Condition, Controls, DifferenceEffect, Level, MeasuredEpisode, Run, Transferred};
use super::settings::Settings;
use crate::file::Edition;

/// Number of best individuals whose mean is the peak.
pub(crate) const PEAK: usize = 20;
/// Starts from which champions' paths are compared, besides the paper's one.
const STARTS: usize = 100;
/// Starts whose traces are in memory at once.
const STARTS_AT_ONCE: usize = 10;
/// Start that all champions share: x and y in mm, heading in turns. The paper doesn't give its own.
pub(super) const SHARED_START: [f32; 3] = [100.0, 90.0, 0.125];

/// A study in progress.
pub(super) struct Study<'a> {
    settings: &'a Settings,
    evaluations: &'a Engine,
    site: Site,
    console: Console,
    /// The simulator without noise.
    simulator: WorldSpec,
    /// The robot's samples as taken: they set reality's grid, whatever the simulator looks up.
    sampled: Arc<SensorTables>,
    /// A simulator for each condition.
    simulators: [World; 3],
    /// The same simulators with other criteria of selection than fitness, if there are any.
    selecting: Option<[World; 3]>,
}

impl<'a> Study<'a> {
    /// Prepares a study with the simulator made from a robot's samples, and reality at a site.
    ///
    /// # Errors
    /// Exit 3 with the reason why a world is invalid.
    pub(super) fn new(
        settings: &'a Settings,
        robot: Robot,
        site: Site,
        evaluations: &'a Engine,
        console: Console,
    ) -> Result<Self> {
        let sampled = Arc::clone(&robot.sensors);
        let world = settings.world();
        let simulator = WorldSpec {
            robot: Robot {
                sensors: settings.looked_up(&sampled),
                collision: world.robot.collision,
                ..robot
            },
            ..world
        };
        let each = |task: Task| {
            let with_noise = |condition| {
                World::new(WorldSpec {
                    noise: settings.noise(condition),
                    task,
                    ..simulator.clone()
                })
            };
            let [none, sensor, conservative] = Condition::ALL;
            Ok::<_, Failure>([with_noise(none)?, with_noise(sensor)?, with_noise(conservative)?])
        };
        let simulators = each(simulator.task)?;
        let new_cell = settings.selection.new_cell;
        let more = (new_cell > 0.0).then(|| simulator.task.with_new_cell(new_cell));
        let selecting = more.map(each).transpose()?;
        Ok(Self {
            settings,
            evaluations,
            site,
            console,
            simulator,
            sampled,
            simulators,
            selecting,
        })
    }

    /// Tables of the study's simulator.
    pub(super) fn sensors(&self) -> &Arc<SensorTables> {
        &self.sampled
    }

    /// World of real episodes, before the surrogate is put in, whose slip says what collisions do.
    fn reality(&self) -> WorldSpec {
        WorldSpec {
            robot: Robot {
                sensors: Arc::clone(&self.sampled),
                collision: Collision::Undo,
                ..self.simulator.robot.clone()
            },
            ..self.simulator.clone()
        }
    }

    /// Runs the numbered runs of each condition, from their first genes to their last real generation.
    pub(crate) fn cohort(&self, numbers: Range<u32>) -> Result<Vec<Run>> {
        let mut runs: Vec<Evolving> = numbers
            .flat_map(|number| Condition::ALL.map(|condition| (number, condition)))
            .map(|(number, condition)| self.begin(condition, number))
            .collect();
        self.evolve(&mut runs)?;
        let mut robot = self.real_episodes(&self.site)?;
        let transferred = self.transfer(&mut runs, &mut robot)?;
        let best = self.choose_champions(&runs, &transferred)?;
        let controls = if self.settings.is_full() {
            self.controls(&runs)?.into_iter().map(Some).collect()
        } else {
            vec![None; runs.len()]
        };
        let last = self.evolve_on(&mut runs, &transferred, &mut robot)?;
        // On a wire somebody has to be there for these.
        let champions = self.champions(&runs, best, &mut robot)?;
        let rest = transferred.into_iter().zip(champions).zip(last).zip(controls);
        Ok(runs
            .into_iter()
            .zip(rest)
            .map(|(run, (((transferred, champion), last), controls))| Run {
                condition: run.condition,
                number: run.number,
                seed: run.seed,
                simulated: run.simulated,
                real: run.real,
                transferred,
                last,
                champion,
                controls,
            })
            .collect())
    }

    /// Mean real fitness of each run's generation 219 under each alternative.
    fn controls(&self, runs: &[Evolving]) -> Result<Vec<Controls>> {
        let robot = || self.real_episodes(&self.site);
        let means = |fitness: Vec<Vec<f32>>| fitness.iter().map(|of_run| level(of_run).average).collect::<Vec<_>>();

        let mut on = runs.to_vec();
        let mut neutral = runs.to_vec();
        let mut random: Vec<Evolving> = runs
            .iter()
            .map(|run| {
                let fresh = self.begin(run.condition, run.number).evolution.ask().clone();
                let settings = self.settings.evolution();
                Evolving {
                    evolution: Genetic::at(&settings, run.seed, self.settings.simulated_generations(), fresh),
                    ..run.clone()
                }
            })
            .collect();
        let mut evolving = robot()?;
        for generation in 1..self.settings.reality.generations {
            let simulated = self.simulate(&on, Trial::Simulated)?;
            self.select(&mut on, simulated)?;
            for run in &mut neutral {
                let lot = |individual: usize| {
                    let [word, ..] = pcg4d([run.seed as u32, generation, individual as u32, 1995]);
                    (word >> 8) as f32
                };
                let lots = (0..run.evolution.ask().len()).map(lot).collect();
                run.evolution.tell(lots, &[])?;
            }
            let real = evolving.run(&random, Trial::Real)?;
            for (run, fitness) in random.iter_mut().zip(real) {
                run.evolution.tell(fitness, &[])?;
            }
        }
        let simulated_on = means(robot()?.run(&on, Trial::Real)?);
        let neutral = means(robot()?.run(&neutral, Trial::Real)?);
        let from_random = means(evolving.run(&random, Trial::Real)?);
        let rows = simulated_on.into_iter().zip(neutral).zip(from_random);
        Ok(rows
            .map(|((simulated_on, neutral), from_random)| Controls {
                simulated_on,
                neutral,
                from_random,
            })
            .collect())
    }

    /// Evolves in other simulators and tests generation 200 in this study's reality. Returns the mean simulated and
    /// real fitness of each run for each simulator.
    pub(super) fn elsewhere(&self, worlds: &[World]) -> Result<Vec<(Vec<f64>, Vec<f64>)>> {
        let mut runs: Vec<Evolving> = (0..self.settings.runs)
            .map(|number| self.begin(Condition::None, number))
            .collect();
        let fresh = runs.clone();
        let mut all = Vec::new();
        for world in worlds {
            runs.clone_from(&fresh);
            let one = |runs: &[Evolving]| self.simulate_in(std::slice::from_ref(world), runs, |_| 0, Trial::Simulated);
            for _ in 0..self.settings.simulated_generations() {
                let fitness = one(&runs)?;
                for (run, fitness) in runs.iter_mut().zip(fitness) {
                    run.evolution.tell(fitness, &[])?;
                }
            }
            let means = |fitness: Vec<Vec<f32>>| fitness.iter().map(|of_run| level(of_run).average).collect();
            let mut robot = self.real_episodes(&self.site)?;
            all.push((means(one(&runs)?), means(robot.run(&runs, Trial::Real)?)));
        }
        Ok(all)
    }

    /// Cohen's d of generation 200 without noise, simulated minus real. The severity is calibrated by it.
    pub(crate) fn gap_without_noise(&self, runs: u32) -> Result<f64> {
        let mut runs: Vec<Evolving> = (0..runs).map(|number| self.begin(Condition::None, number)).collect();
        self.evolve(&mut runs)?;
        let simulated = self.simulate(&runs, Trial::Simulated)?;
        let mut robot = self.real_episodes(&self.site)?;
        let real = robot.run(&runs, Trial::Real)?;
        let [simulated, real] =
            [simulated, real].map(|fitness| fitness.into_iter().flatten().map(f64::from).collect::<Vec<_>>());
        Ok(cohens_d(&simulated, &real).unwrap_or(f64::NAN))
    }

    /// Generations 0 to 199, selected by simulated episodes.
    fn evolve(&self, runs: &mut [Evolving]) -> Result {
        for _ in 0..self.settings.simulated_generations() {
            let fitness = self.simulate(runs, Trial::Simulated)?;
            for (run, fitness) in runs.iter_mut().zip(&fitness) {
                run.simulated.push(level(fitness));
            }
            self.select(runs, fitness)?;
        }
        Ok(())
    }

    /// Generations 200 to 219, selected by real episodes; returns the fitness of the last.
    fn evolve_on(
        &self,
        runs: &mut [Evolving],
        transferred: &[Transferred],
        robot: &mut RealEpisodes<'_>,
    ) -> Result<Vec<Vec<f32>>> {
        let mut fitness: Vec<Vec<f32>> = transferred.iter().map(|run| run.real.clone()).collect();
        for generation in 0..self.settings.reality.generations {
            if generation > 0 {
                fitness = robot.run(runs, Trial::Real)?;
            }
            for (run, fitness) in runs.iter_mut().zip(&fitness) {
                run.real.push(level(fitness));
                run.evolution.tell(fitness.clone(), &[])?;
            }
        }
        Ok(fitness)
    }

    /// Selects by the fitness of simulated episodes, or by the criterion that replaces it.
    fn select(&self, runs: &mut [Evolving], fitness: Vec<Vec<f32>>) -> Result {
        let scores = match &self.selecting {
            None => fitness,
            Some(worlds) => self.simulate_in(worlds, runs, |run| run.condition as usize, Trial::Simulated)?,
        };
        for (run, scores) in runs.iter_mut().zip(scores) {
            run.evolution.tell(scores, &[])?;
        }
        Ok(())
    }

    pub(super) fn begin(&self, condition: Condition, number: u32) -> Evolving {
        let seed = self.settings.run_seed(condition, number);
        Evolving {
            condition,
            number,
            seed,
            evolution: Genetic::new(
                &self.settings.evolution(),
                seed,
                self.simulator.controller.layout().ranges(),
                None,
            ),
            simulated: Vec::new(),
            real: Vec::new(),
        }
    }

    /// Simulates an episode of each individual of each run in the run's simulator.
    fn simulate(&self, runs: &[Evolving], trial: Trial) -> Result<Vec<Vec<f32>>> {
        let world = |run: &Evolving| match trial {
            Trial::Quiet => 0,
            _ => run.condition as usize,
        };
        self.simulate_in(&self.simulators, runs, world, trial)
    }

    /// Simulates an episode of each individual of each run in one of some worlds.
    fn simulate_in(
        &self,
        worlds: &[World],
        runs: &[Evolving],
        world: impl Fn(&Evolving) -> usize,
        trial: Trial,
    ) -> Result<Vec<Vec<f32>>> {
        let rollouts: Vec<Rollout<'_>> = runs
            .iter()
            .flat_map(|run| {
                let world = world(run);
                episodes(run, trial).map(move |episode| Rollout {
                    world,
                    genes: episode.genes,
                    key: episode.key,
                })
            })
            .collect();
        let outcome = self.evaluations.evaluate(&Batch::new(worlds, &rollouts, None)?)?;
        Ok(by_run(runs, outcome.fitness))
    }

    /// Prepares a robot for real episodes of runs.
    pub(super) fn real_episodes(&self, site: &Site) -> Result<RealEpisodes<'a>> {
        let (world, starts) = (self.reality(), self.settings.starts());
        RealEpisodes::new(self.evaluations, site, &world, starts, self.console)
    }

    /// Tests generation 200 in every environment. `robot` is the one that later generations will live on.
    fn transfer(&self, runs: &mut [Evolving], robot: &mut RealEpisodes<'_>) -> Result<Vec<Transferred>> {
        let simulated = self.simulate(runs, Trial::Simulated)?;
        let simulated_again = self.simulate(runs, Trial::SimulatedAgain)?;
        let quiet = self.simulate(runs, Trial::Quiet)?;
        let real = robot.run(runs, Trial::Real)?;
        let real_again = robot.aside(runs, Trial::RealAgain)?;
        let other_robot = match self.settings.other_site() {
            Some(site) => self.real_episodes(&site)?.run(runs, Trial::OtherRobot)?,
            None => vec![Vec::new(); runs.len()],
        };
        for (run, fitness) in runs.iter_mut().zip(&simulated) {
            run.simulated.push(level(fitness));
        }
        let columns = simulated
            .into_iter()
            .zip(simulated_again)
            .zip(quiet)
            .zip(real)
            .zip(real_again)
            .zip(other_robot);
        Ok(columns
            .map(
                |(((((simulated, simulated_again), quiet), real), real_again), other_robot)| Transferred {
                    simulated,
                    simulated_again,
                    quiet,
                    real,
                    real_again,
                    other_robot,
                },
            )
            .collect())
    }

    /// The best individuals of each run's generation 200, with their simulated and real episodes.
    fn champions(&self, runs: &[Evolving], best: Vec<Best>, robot: &mut RealEpisodes<'_>) -> Result<Vec<Champion>> {
        if self.settings.is_wired() {
            let each = runs.iter().zip(&best);
            let each = each.map(|(run, best)| format!("{}, individual {}", run.condition.title(), best.individual));
            self.console.say(format!(
                "run {}, champions of generation {}, each from the same start: {}",
                runs.first().map_or(0, |run| run.number),
                self.settings.simulated_generations(),
                each.collect::<Vec<_>>().join("; ")
            ));
        }
        let from_shared = from_starts(runs, &best, &[SHARED_START], 0, self.after(), 0);
        let as_evolved = |condition| self.settings.noise(condition);
        let simulated = self.simulated_paths(runs, &from_shared, &[SHARED_START], as_evolved)?;
        let shared = self.pairs(runs, &best, &[SHARED_START], 0, robot)?;
        let mut sums: Vec<Sums> = runs.iter().map(|_| Sums::default()).collect();
        let starts = self.starts()?;
        for (index, some) in starts.chunks(STARTS_AT_ONCE).enumerate() {
            let first = 1 + index * STARTS_AT_ONCE;
            let pairs = self.pairs(runs, &best, some, first, robot)?;
            let again = robot.run_with_traces(&from_starts(runs, &best, some, first, self.after(), 2))?;
            for (pairs, again) in pairs.chunks(runs.len()).zip(again.chunks(runs.len())) {
                for (index, ((sums, pair), again)) in sums.iter_mut().zip(pairs).zip(again).enumerate() {
                    sums.add(pair, again, &pairs[unrelated(runs, index)]);
                }
            }
        }
        let cells = Cells::new(&self.simulator);
        let real = |trace: &Trace| {
            let episode = cells.measure_episode(trace);
            let collided = if self.settings.is_wired() {
                f64::NAN
            } else {
                episode.collided
            };
            MeasuredEpisode { collided, ..episode }
        };
        let rows = best.into_iter().zip(shared).zip(simulated).zip(sums);
        Ok(rows
            .map(|(((best, pair), simulated), sums)| Champion {
                individual: best.individual as u32,
                mean: best.mean,
                genome: best.genome,
                simulated: cells.measure_episode(&simulated),
                real: real(&pair.real),
                discrepancy: sums.mean(&pair),
            })
            .collect())
    }

    /// Each run's best individual.
    fn choose_champions(&self, runs: &[Evolving], transferred: &[Transferred]) -> Result<Vec<Best>> {
        let episodes = self.settings.champion.lives;
        let chosen: Vec<(usize, Option<f64>)> = if episodes == 1 {
            transferred.iter().map(|run| (best(&run.simulated), None)).collect()
        } else {
            let means = self.mean_fitness(runs, 0..episodes)?;
            let chosen = means.iter().map(|means| (best(means), means));
            chosen.map(|(best, means)| (best, Some(means[best]))).collect()
        };
        let each = runs.iter().zip(chosen);
        Ok(each
            .map(|(run, (individual, mean))| Best {
                individual,
                mean,
                genome: run.evolution.ask().genome(individual).to_vec(),
            })
            .collect())
    }

    /// Mean fitness of each individual of each run in some episodes in the run's simulator.
    fn mean_fitness(&self, runs: &[Evolving], episodes: Range<u32>) -> Result<Vec<Vec<f64>>> {
        let count = f64::from(episodes.end - episodes.start);
        let mut means: Vec<Vec<f64>> = runs.iter().map(|run| vec![0.0; run.evolution.ask().len()]).collect();
        for episode in episodes {
            let fitness = self.simulate(runs, Trial::Reevaluated(episode))?;
            for (mean, fitness) in means.iter_mut().flatten().zip(fitness.iter().flatten()) {
                *mean += f64::from(*fitness) / count;
            }
        }
        Ok(means)
    }

    /// Simulated and real episodes of each run's best from each start, whose paths are compared. Sorted by start, then by run.
    fn pairs(
        &self,
        runs: &[Evolving],
        best: &[Best],
        starts: &[[f32; 3]],
        first: usize,
        robot: &mut RealEpisodes<'_>,
    ) -> Result<Vec<Pair>> {
        let episodes = |trial| from_starts(runs, best, starts, first, self.after(), trial);
        // The second edition compares paths without the simulator's noise.
        let noise = |condition| match self.settings.edition {
            Edition::First => self.settings.noise(condition),
            Edition::Second => Noise::NONE,
        };
        let simulated = self.simulated_paths(runs, &episodes(0), starts, noise)?;
        let real = robot.run_with_traces(&episodes(1))?;
        let pairs = simulated.into_iter().zip(real);
        Ok(pairs.map(|(simulated, real)| Pair { simulated, real }).collect())
    }

    /// Simulated episodes from starts, sorted by start, then by run, with each condition's noise. They are one cycle longer than
    /// usual to get the final position.
    fn simulated_paths(
        &self,
        runs: &[Evolving],
        episodes: &[reality::Life<'_>],
        starts: &[[f32; 3]],
        noise: impl Fn(Condition) -> Noise,
    ) -> Result<Vec<Trace>> {
        let mut simulators = Vec::new();
        for &[x, y, heading] in starts {
            for condition in Condition::ALL {
                simulators.push(World::new(WorldSpec {
                    noise: noise(condition),
                    start: Start::At { x, y, heading },
                    cycles: self.simulator.cycles + 1,
                    ..self.simulator.clone()
                })?);
            }
        }
        let rollouts: Vec<_> = episodes
            .iter()
            .enumerate()
            .map(|(index, episode)| Rollout {
                world: index / runs.len() * Condition::ALL.len() + runs[index % runs.len()].condition as usize,
                genes: episode.genes,
                key: episode.key,
            })
            .collect();
        let batch = Batch::new(&simulators, &rollouts, Some(TraceRequest { every: 1 }))?;
        Ok(self.evaluations.evaluate(&batch)?.traces)
    }

    /// Number in the keys of champions' episodes, instead of a generation's.
    fn after(&self) -> u64 {
        u64::from(self.settings.simulated_generations()) + 1_000_000
    }

    /// Free poses, uniformly distributed over the field and the same for all champions. None on a wire, where somebody would have
    /// to put the robot at each.
    fn starts(&self) -> Result<Vec<[f32; 3]>> {
        /// A quarter of these draws or more is free.
        const DRAWS: u32 = 100 * STARTS as u32;
        if self.settings.is_wired() {
            return Ok(Vec::new());
        }
        let Field { x, y, width, height } = self.simulator.arena.field;
        let share = |word: u32| (word >> 8) as f32 / (1 << 24) as f32;
        let seed = self.settings.seed();
        let starts: Vec<[f32; 3]> = (0..DRAWS)
            .map(|draw| {
                let [across, up, heading, _] = pcg4d([seed as u32, (seed >> 32) as u32, draw, 1995]);
                [x + width * share(across), y + height * share(up), share(heading)]
            })
            .filter(|&[x, y, heading]| {
                let start = Start::At { x, y, heading };
                World::new(WorldSpec {
                    start,
                    ..self.simulator.clone()
                })
                .is_ok()
            })
            .take(STARTS)
            .collect();
        if starts.len() < STARTS {
            return Err(Failure::input("the arena has too little free space for 100 starts"));
        }
        Ok(starts)
    }

    /// Effect of each difference between reality and simulator by itself, over the first cycles of episodes of random
    /// controllers. Zero if the arm lacks the difference. Unknown for a connected robot.
    pub(super) fn differences(&self) -> Result<Vec<DifferenceEffect>> {
        const LIVES: u64 = 4000;
        /// Not the first cycle, so that delays and lags show.
        const CYCLE: usize = 2;
        let Some((_, surrogate)) = self.settings.surrogate() else {
            return Ok(Vec::new());
        };
        let genomes: Vec<Vec<f32>> = (0..LIVES)
            .map(|episode| {
                (0..self.simulator.controller.layout().genes() as u32)
                    .map(|gene| (pcg4d([episode as u32, gene, 1995, 2])[0] >> 8) as f32 / 1_677_721.6 - 5.0)
                    .collect()
            })
            .collect();
        let after = |differences| -> Result<Vec<Moment>> {
            let world = World::new(WorldSpec {
                surrogate: Some(Arc::new(Surrogate {
                    differences,
                    ..surrogate.clone()
                })),
                cycles: CYCLE as u32 + 1,
                ..self.reality()
            })?;
            let rollouts: Vec<_> = genomes
                .iter()
                .zip(0..)
                .map(|(genes, episode)| Rollout {
                    world: 0,
                    genes,
                    key: Key::rollout(self.settings.seed(), u64::MAX, episode, 0),
                })
                .collect();
            let batch = Batch::new(&[world], &rollouts, Some(TraceRequest { every: 1 }))?;
            let traces = self.evaluations.evaluate(&batch)?.traces;
            let moment = |trace: Trace| Moment {
                record: trace[CYCLE],
                activations: trace.activations(CYCLE),
            };
            Ok(traces.into_iter().map(moment).collect())
        };
        let without = after(Differences::all(0.0))?;
        Difference::ALL
            .into_iter()
            .map(|difference| {
                let differences = surrogate.differences;
                let alone = Differences::only(differences.strength(difference), difference)
                    .with_latency(differences.latency_ms);
                let with = after(alone)?;
                Ok(effect(difference.name(), &with, &without))
            })
            .collect()
    }

    /// Fitness in the simulator without noise of a handmade controller that goes to and fro between two obstacles it
    /// hardly sees, without turning: the deceptive optimum that the paper's conclusions describe.
    pub(crate) fn to_and_fro(&self) -> Result<Vec<f32>> {
        const LIVES: u64 = 100;
        let wheel = [-60.0, -60.0, -60.0, -60.0, -60.0, -60.0, 60.0, 60.0, 3.0];
        let genes = [wheel, wheel].concat();
        let rollouts: Vec<_> = (0..LIVES)
            .map(|episode| Rollout {
                world: 0,
                genes: &genes,
                key: Key::rollout(self.settings.seed(), u64::MAX, episode, 1),
            })
            .collect();
        let batch = Batch::new(&self.simulators, &rollouts, None)?;
        Ok(self.evaluations.evaluate(&batch)?.fitness)
    }
}

/// The best individual of a run's generation 200.
struct Best {
    individual: usize,
    /// Its mean fitness, if it was chosen by that.
    mean: Option<f64>,
    genome: Vec<f32>,
}

/// An episode of each run's best from each of some starts, the first of which has a number. Sorted by start, then by
/// run. `generation` and `trial` keep their keys apart from others.
fn from_starts<'b>(
    runs: &[Evolving],
    best: &'b [Best],
    starts: &[[f32; 3]],
    first: usize,
    generation: u64,
    trial: u64,
) -> Vec<reality::Life<'b>> {
    let each = |(number, &start): (u64, &[f32; 3])| {
        let episodes = runs.iter().zip(best).map(move |(run, best)| reality::Life {
            genes: &best.genome,
            key: Key::rollout(run.seed, generation, number, trial),
            start: Some(start),
        });
        episodes.collect::<Vec<_>>()
    };
    (first as u64..).zip(starts).flat_map(each).collect()
}

/// Peak and average fitness.
fn level(fitness: &[f32]) -> Level {
    let mut ranked: Vec<f64> = fitness.iter().map(|&fitness| f64::from(fitness)).collect();
    ranked.sort_by(|a, b| b.total_cmp(a));
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    Level {
        peak: mean(&ranked[..PEAK.min(ranked.len())]),
        average: mean(&ranked),
    }
}

/// Index of the maximum, and of the first one if several are equal.
fn best<T: PartialOrd>(fitness: &[T]) -> usize {
    let better = |best: usize, index: usize| if fitness[index] > fitness[best] { index } else { best };
    (1..fitness.len()).fold(0, better)
}

/// Index of another run of the same condition, or of another condition if there is none.
fn unrelated(runs: &[Evolving], index: usize) -> usize {
    let others = (1..runs.len()).map(|step| (index + step) % runs.len());
    let same = |&other: &usize| runs[other].condition == runs[index].condition;
    others.clone().find(same).or(others.clone().next()).unwrap_or(index)
}

#[cfg(test)]
mod tests {
    use super::super::settings::Settings;
    use super::super::tests::{self, evaluations};
    use super::*;

    fn settings(arm: &str) -> Settings {
        tests::settings(arm, 1.0)
    }

    /// Two runs of each condition at their first generation.
    fn first_generations(study: &Study<'_>) -> Vec<Evolving> {
        let numbers = (0..2).flat_map(|number| Condition::ALL.map(|condition| (condition, number)));
        numbers
            .map(|(condition, number)| study.begin(condition, number))
            .collect()
    }

    /// New cells count five each in selection, and don't change any measure.
    #[test]
    fn cells_visited_select_and_are_not_fitness() {
        let evaluations = evaluations();
        let settings = settings("cells-visited");
        let study = tests::study(&settings, &evaluations);
        let mut runs = first_generations(&study);
        let fitness = study.simulate(&runs, Trial::Simulated).unwrap();
        let by_fitness = {
            let mut runs = runs.clone();
            for (run, fitness) in runs.iter_mut().zip(&fitness) {
                run.evolution.tell(fitness.clone(), &[]).unwrap();
            }
            runs
        };
        let worlds = study.selecting.as_ref().unwrap();
        let scores = study
            .simulate_in(worlds, &runs, |run| run.condition as usize, Trial::Simulated)
            .unwrap();
        let mut most = 0.0_f32;
        for (fitness, score) in fitness.concat().iter().zip(scores.concat()) {
            let cells = (score - fitness) / 5.0;
            assert!((cells - cells.round()).abs() < 1e-3 && cells > 0.5, "{cells} cells");
            most = most.max(cells);
        }
        assert!((10.0..=84.0).contains(&most), "{most} cells");
        study.select(&mut runs, fitness).unwrap();
        for (one, other) in runs.iter().zip(&by_fitness) {
            assert_ne!(one.evolution.ask(), other.evolution.ask());
        }
    }

    /// In a hundred new episodes, champions chosen by a mean do better than those chosen by one good episode.
    #[test]
    fn champions_by_mean_stay_good() {
        let evaluations = evaluations();
        let in_other_lives = |arm| {
            let settings = settings(arm);
            let study = tests::study(&settings, &evaluations);
            let mut runs = first_generations(&study);
            let mut robot = study.real_episodes(&settings.site()).unwrap();
            let transferred = study.transfer(&mut runs, &mut robot).unwrap();
            let chosen = study.choose_champions(&runs, &transferred).unwrap();
            let others = study.mean_fitness(&runs, 1000..1100).unwrap();
            for ((best, run), others) in chosen.iter().zip(&transferred).zip(&others) {
                let (individual, mean) = (best.individual, best.mean);
                match mean {
                    None => assert!(
                        run.simulated
                            .iter()
                            .all(|episode| *episode <= run.simulated[individual])
                    ),
                    // Other episodes of the same individual.
                    Some(mean) => assert!(mean != others[individual] && (mean / others[individual] - 1.0).abs() < 0.3),
                }
                assert_eq!(mean.is_some(), arm == "champion-by-mean");
            }
            let fitness: Vec<f64> = chosen
                .iter()
                .zip(&others)
                .map(|(best, fitness)| fitness[best.individual])
                .collect();
            fitness
        };
        let (by_life, by_mean) = (in_other_lives("main"), in_other_lives("champion-by-mean"));
        let sum = |fitness: &[f64]| fitness.iter().sum::<f64>();
        assert!(sum(&by_mean) > 1.05 * sum(&by_life), "{by_mean:?}, {by_life:?}");
    }

    /// Only differences in force have an effect.
    #[test]
    fn differences_that_an_arm_has_not_do_nothing() {
        let evaluations = evaluations();
        let settings = settings("only-motor-lag");
        let study = tests::study(&settings, &evaluations);
        for effect in study.differences().unwrap() {
            let change = effect.activation + effect.displacement + effect.turn;
            assert_eq!(change > 0.0, effect.name == "motor_lag", "{}: {change}", effect.name);
        }
    }
}
