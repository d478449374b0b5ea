//! The loop of a sweep of single robots: generations of many runs live in one batch. Crews of runs take turns: while the
//! device evaluates one, this thread evolves the other, records what has ended, and lets waiting runs join.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use oneiro::batch::{Batch, Rollout, Worlds};
use oneiro::evaluator;
use oneiro::random::Key;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Noise, World, WorldSpec};
use rayon::prelude::*;

use super::journal::{Journal, Saved};
use super::outcome::{Ended, Outcome};
use super::{Cell, Plan, RunIndex, Sweep};
use crate::evolve::genetic::Genetic;
use crate::evolve::{Evolution, Generation, Population};
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::record::Row;
use crate::run::{Interruption, keys, score};
use crate::worker::{Watch, Worker};

/// What a batch should take, so that what it costs to hand it over does not show.
const BATCH: Duration = Duration::from_millis(30);
/// Robot-steps of a batch before it is known how fast the device is, and the fewest and most.
const FIRST_ROOM: f64 = 4e6;
const ROOM: [f64; 2] = [1e6, 4e9];
/// Bytes that runs under way may need in all.
const MEMORY: u64 = 512 << 20;
/// Crews at most: two keep the device busy, others are the tails of what had another kernel.
const CREWS: usize = 4;

/// How runs go together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Runs under way at most; none: as the device is fast.
    pub(crate) jobs: Option<usize>,
    /// From one checkpoint to the next.
    pub(crate) checkpoint_every: Duration,
}

/// What runs of one cell share.
struct Site {
    experiment: Box<Experiment>,
    /// Of equal worlds only one is packed.
    world: blake3::Hash,
    /// Where the last offspring live, if they meet reality: a world for each robot.
    reality: Vec<World>,
}

impl Site {
    fn new(sweep: &Sweep, cell: usize) -> Result<Self> {
        let Cell::Khepera(experiment) = sweep.cell(cell)? else {
            return Err(Failure::failed("a sweep of swarms has no single robots"));
        };
        let reality = sweep.file().reality.iter().flat_map(|reality| {
            let differences = Differences::all(reality.severity);
            let spec = experiment.world().spec().clone();
            reality.robots.iter().map(move |&robot| {
                World::new(WorldSpec {
                    surrogate: Some(Arc::new(Surrogate::drawn(robot, differences))),
                    noise: Noise::NONE,
                    ..spec.clone()
                })
            })
        });
        Ok(Self {
            world: experiment.world_identity(),
            reality: reality.collect::<std::result::Result<_, _>>()?,
            experiment,
        })
    }

    fn kernel(&self) -> &'static str {
        self.experiment.world().kernel().name
    }

    /// Robot-steps of a generation.
    fn generation(&self) -> f64 {
        let settings = self.experiment.settings();
        f64::from(settings.evolution.population) * f64::from(settings.trials) * f64::from(settings.cycles)
    }
}

/// One run under way.
struct Life {
    run: RunIndex,
    site: Arc<Site>,
    seed: u64,
    evolution: Evolution,
    /// The lines of the generations that have lived, and how many scores were NaN.
    generations: String,
    nan: u64,
    /// What it gave, once all generations have lived; its last offspring are still to meet reality.
    outcome: Option<Outcome>,
    /// What they scored in the simulator.
    simulated: Vec<f32>,
}

impl Life {
    fn saved(&self) -> Saved {
        Saved {
            run: self.run,
            generation: self.evolution.generation(),
            population: self.evolution.ask().values().to_vec(),
            champion: self.evolution.champion().map(Into::into),
            generations: self.generations.clone(),
            nan: self.nan,
            outcome: self.outcome.clone(),
        }
    }

    /// Takes the fitness of the lives of a generation: breeds the next, or ends.
    fn tell(&mut self, fitness: &[f32], id: blake3::Hash) -> Result {
        let settings = self.site.experiment.settings();
        let lives = fitness.chunks_exact(settings.trials as usize);
        let scores = lives.map(|lives| score(settings.trial_score, lives)).collect();
        if self.outcome.is_some() {
            self.simulated = scores;
            return Ok(());
        }
        let last = self.evolution.tell(scores)?;
        let row = Row::new(&last, settings.evolution.parents);
        self.generations += &row.line();
        self.nan += u64::from(row.nan);
        if self.evolution.is_finished() {
            self.outcome = self.ended(&last, &row, id);
        }
        Ok(())
    }

    fn ended(&mut self, last: &Generation, row: &Row, id: blake3::Hash) -> Option<Outcome> {
        let ended = Ended {
            run: self.run,
            seed: self.seed,
            trials: self.site.experiment.settings().trials,
            identity: id,
            last,
            row,
            champion: self.evolution.champion()?,
            generations: std::mem::take(&mut self.generations),
            nan: self.nan,
        };
        Some(ended.outcome())
    }

    /// Whether nothing is left to be simulated.
    fn is_simulated(&self) -> bool {
        self.outcome.is_some() && (self.site.reality.is_empty() || !self.simulated.is_empty())
    }
}

/// A world among all of a sweep: its simulator's, and which robot's reality it is, if any.
type WorldKey = ([u8; blake3::OUT_LEN], Option<usize>);

/// Runs whose lives share batches.
struct Crew {
    lives: Vec<Life>,
    stage: Stage,
    worlds: Worlds,
    /// Where in them each world is.
    places: BTreeMap<WorldKey, usize>,
    /// Robot-steps of a batch.
    steps: f64,
}

/// Where a crew's individuals live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// In their simulators, generation after generation.
    Simulation,
    /// In reality, once.
    Reality,
}

impl Stage {
    /// The worlds that a run's individuals live in.
    fn worlds(self, site: &Site) -> impl Iterator<Item = (WorldKey, &World)> {
        let own = *site.world.as_bytes();
        let simulator = (self == Self::Simulation).then(|| ((own, None), site.experiment.world()));
        let robots = if self == Self::Reality { &site.reality[..] } else { &[] };
        let real = robots
            .iter()
            .enumerate()
            .map(move |(robot, world)| ((own, Some(robot)), world));
        simulator.into_iter().chain(real)
    }

    /// Robot-steps of a run's next lives.
    fn steps(self, site: &Site) -> f64 {
        match self {
            Self::Simulation => site.generation(),
            Self::Reality => {
                site.generation() * site.reality.len() as f64 / f64::from(site.experiment.settings().trials)
            }
        }
    }

    /// Robot-steps of the next lives of some runs.
    fn steps_of(self, lives: &[Life]) -> f64 {
        lives.iter().map(|life| self.steps(&life.site)).sum()
    }
}

impl Crew {
    /// Of one run and more, all of one kernel.
    fn new(lives: Vec<Life>, stage: Stage) -> Result<Self> {
        let mut places = BTreeMap::new();
        let mut worlds = Vec::new();
        for (key, world) in lives.iter().flat_map(|life| stage.worlds(&life.site)) {
            places.entry(key).or_insert_with(|| {
                worlds.push(world.clone());
                worlds.len() - 1
            });
        }
        Ok(Self {
            worlds: Worlds::new(&worlds)?,
            steps: stage.steps_of(&lives),
            lives,
            stage,
            places,
        })
    }

    /// The same crew with other runs.
    fn with(self, lives: Vec<Life>) -> Result<Self> {
        let is_packed = |life: &Life| {
            self.stage
                .worlds(&life.site)
                .all(|(key, _)| self.places.contains_key(&key))
        };
        if lives.iter().all(is_packed) {
            return Ok(Self {
                steps: self.stage.steps_of(&lives),
                lives,
                ..self
            });
        }
        Self::new(lives, self.stage)
    }

    /// The next lives of all its runs, run by run.
    fn batch(&self) -> Result<Batch> {
        let mut rollouts = Vec::new();
        for life in &self.lives {
            let generation = life.evolution.generation();
            let individuals = || life.evolution.ask().genomes().zip(0..);
            match self.stage {
                Stage::Simulation => {
                    let world = self.places[&(*life.site.world.as_bytes(), None)];
                    let trials = life.site.experiment.settings().trials;
                    rollouts.extend(individuals().flat_map(|(genes, individual)| {
                        keys(life.seed, generation, individual, trials).map(move |key| Rollout { world, genes, key })
                    }));
                }
                Stage::Reality => {
                    for robot in 0..life.site.reality.len() {
                        let world = self.places[&(*life.site.world.as_bytes(), Some(robot))];
                        rollouts.extend(individuals().map(|(genes, individual)| Rollout {
                            world,
                            genes,
                            key: real_life(life.seed, generation, individual, robot),
                        }));
                    }
                }
            }
        }
        Ok(self.worlds.batch(&rollouts, None)?)
    }

    /// How many lives a run's part of a batch has.
    fn part(&self, life: &Life) -> usize {
        let lives = match self.stage {
            Stage::Simulation => life.site.experiment.settings().trials as usize,
            Stage::Reality => life.site.reality.len(),
        };
        life.evolution.ask().len() * lives
    }

    /// Gives all its runs the fitness of their lives.
    fn tell(&mut self, fitness: &[f32], plan: &Plan) -> Result {
        /// Runs that are worth waking a thread for.
        const FEW: usize = 16;
        let stage = self.stage;
        let mut rest = fitness;
        let parts = self
            .lives
            .iter()
            .map(|life| rest.split_off(..self.part(life)).unwrap_or_default());
        let parts: Vec<&[f32]> = parts.collect();
        // A fast device would wait for one thread.
        self.lives
            .par_iter_mut()
            .zip(parts)
            .with_min_len(FEW)
            .try_for_each(|(life, own)| match (stage, &mut life.outcome) {
                (Stage::Reality, Some(outcome)) => {
                    outcome.met_reality(&life.simulated, own);
                    Ok(())
                }
                _ => life.tell(own, plan.ids[life.run as usize]),
            })
    }
}

/// The key of an individual's life in reality: no simulated trial has so large a number.
fn real_life(seed: u64, generation: u32, individual: u32, robot: usize) -> Key {
    Key::rollout(seed, generation.into(), individual.into(), (1 << 32) + robot as u64)
}

/// Runs that wait: those of one kernel together, each kind in the order of the sweep.
struct Waiting<'a> {
    sweep: &'a Sweep,
    sites: BTreeMap<usize, Weak<Site>>,
    /// Those of each kernel.
    kinds: Vec<(&'static str, VecDeque<RunIndex>)>,
    saved: BTreeMap<RunIndex, Saved>,
}

impl<'a> Waiting<'a> {
    fn new(sweep: &'a Sweep, plan: &Plan, runs: Vec<RunIndex>, saved: Vec<Saved>) -> Self {
        let mut kinds: Vec<(&'static str, VecDeque<RunIndex>)> = Vec::new();
        for run in runs {
            let kernel = plan.kernels[sweep.cell_of(run)];
            match kinds.iter_mut().find(|(known, _)| *known == kernel) {
                Some((_, queue)) => queue.push_back(run),
                None => kinds.push((kernel, VecDeque::from([run]))),
            }
        }
        Self {
            sweep,
            sites: BTreeMap::new(),
            kinds,
            saved: saved.into_iter().map(|saved| (saved.run, saved)).collect(),
        }
    }

    /// A kernel that runs wait for.
    fn kernel(&self) -> Option<&'static str> {
        self.kinds
            .iter()
            .find(|(_, queue)| !queue.is_empty())
            .map(|(kernel, _)| *kernel)
    }

    /// Whether any wait for one.
    fn has(&self, kernel: &str) -> bool {
        self.kinds
            .iter()
            .any(|(known, queue)| *known == kernel && !queue.is_empty())
    }

    /// How many wait.
    fn len(&self) -> usize {
        self.kinds.iter().map(|(_, queue)| queue.len()).sum()
    }

    /// The next run of a kernel begins, or goes on where it was saved.
    fn next(&mut self, kernel: &str) -> Result<Option<Life>> {
        let queue = self.kinds.iter_mut().find(|(known, _)| *known == kernel);
        let Some(run) = queue.and_then(|(_, queue)| queue.pop_front()) else {
            return Ok(None);
        };
        let site = self.site(self.sweep.cell_of(run))?;
        let seed = self.sweep.seed_of(run);
        let experiment = &site.experiment;
        let settings = &experiment.settings().evolution;
        let genes = experiment.world().genes();
        let fits = |saved: &Saved| {
            saved.population.len() == settings.population as usize * genes && saved.generation <= settings.generations
        };
        let life = match self.saved.remove(&run).filter(fits) {
            Some(saved) => Life {
                run,
                seed,
                evolution: Evolution::new(
                    Genetic::at(
                        settings,
                        seed,
                        saved.generation,
                        Population::new(genes, saved.population),
                    ),
                    settings.generations,
                    saved.champion.map(Into::into),
                ),
                generations: saved.generations,
                nan: saved.nan,
                outcome: saved.outcome,
                simulated: Vec::new(),
                site,
            },
            None => Life {
                run,
                seed,
                evolution: experiment.evolution(seed),
                generations: String::new(),
                nan: 0,
                outcome: None,
                simulated: Vec::new(),
                site,
            },
        };
        Ok(Some(life))
    }

    fn site(&mut self, cell: usize) -> Result<Arc<Site>> {
        if let Some(site) = self.sites.get(&cell).and_then(Weak::upgrade) {
            return Ok(site);
        }
        let site = Arc::new(Site::new(self.sweep, cell)?);
        self.sites.retain(|_, site| site.strong_count() > 0);
        self.sites.insert(cell, Arc::downgrade(&site));
        Ok(site)
    }
}

/// How large batches are to be.
struct Room {
    /// Robot-steps of a batch.
    steps: f64,
    /// Runs of a crew, and of all crews.
    lives: usize,
    all: usize,
    last: Instant,
}

impl Room {
    fn new(plan: &Plan, pace: Pace, waiting: &Waiting<'_>) -> Self {
        let fit = (MEMORY / plan.bytes.max(1)).max(2) as usize;
        let all = pace.jobs.unwrap_or(usize::MAX).min(fit);
        Self {
            steps: FIRST_ROOM,
            lives: all.min(waiting.len()).div_ceil(2),
            all,
            last: Instant::now(),
        }
    }

    /// A batch of so many steps has come back.
    fn learn(&mut self, steps: f64) {
        let took = self.last.elapsed().as_secs_f64();
        self.last = Instant::now();
        let aim = steps / took.max(1e-6) * BATCH.as_secs_f64();
        self.steps = (0.75 * self.steps + 0.25 * aim).clamp(ROOM[0], ROOM[1]);
    }

    /// Whether there is room for more than so many runs, whose lives take so many steps.
    fn has(&self, lives: usize, steps: f64) -> bool {
        lives == 0 || (lives < self.lives && steps < self.steps)
    }
}

/// Does runs of a sweep, those that were under way first.
///
/// # Errors
/// Exit 75 when it was stopped, and as the evaluator's errors, both with a checkpoint; exit 6 when recording fails.
pub(crate) fn run(
    (sweep, plan): (&Sweep, &Plan),
    runs: Vec<RunIndex>,
    saved: Vec<Saved>,
    pace: Pace,
    worker: &Worker,
    journal: &Journal,
    watch: &mut dyn Watch,
) -> Result {
    let waiting = Waiting::new(sweep, plan, runs, saved);
    let mut shift = Shift {
        plan,
        room: Room::new(plan, pace, &waiting),
        waiting,
        under_way: VecDeque::new(),
        meeting: Vec::new(),
        worker,
        journal,
        checkpoint_every: pace.checkpoint_every,
        checkpointed: Instant::now(),
    };
    let ended = shift.work(watch);
    // Also when all is done: what the last checkpoint held is in the table of results by now.
    let kept = shift.checkpoint();
    match ended {
        Ok(()) => kept,
        Err(Interruption::Evaluation(evaluator::Error::Cancelled)) => {
            Err(Failure::stopped("stopped; the same command goes on"))
        }
        Err(Interruption::Evaluation(error)) => Err(error.into()),
        Err(Interruption::Other(failure)) => Err(failure),
    }
}

/// All that is under way.
struct Shift<'a> {
    plan: &'a Plan,
    waiting: Waiting<'a>,
    room: Room,
    /// Those whose batches the device has, in their order.
    under_way: VecDeque<Crew>,
    /// Runs whose last offspring are to meet reality.
    meeting: Vec<Life>,
    worker: &'a Worker,
    journal: &'a Journal,
    checkpoint_every: Duration,
    checkpointed: Instant,
}

impl Shift<'_> {
    fn work(&mut self, watch: &mut dyn Watch) -> std::result::Result<(), Interruption> {
        loop {
            self.call()?;
            let Some(crew) = self.under_way.front_mut() else {
                return Ok(());
            };
            let outcome = self.worker.receive(watch)?;
            self.room.learn(crew.steps);
            crew.tell(&outcome.fitness, self.plan)?;
            let ended = self.go_on()?;
            // The device has its next batch by now.
            for outcome in ended {
                let id = self.plan.ids[outcome.run as usize];
                self.journal.done(outcome, id)?;
            }
            if self.checkpointed.elapsed() >= self.checkpoint_every {
                self.checkpoint()?;
            }
        }
    }

    /// Sends crews off while there are runs to do and the device has less than two batches to do.
    fn call(&mut self) -> Result {
        while self.wants_crew() {
            let Some(kernel) = self.waiting.kernel() else {
                break;
            };
            let lives = self.joined(Vec::new(), kernel)?;
            if lives.is_empty() {
                break;
            }
            self.send(Crew::new(lives, Stage::Simulation)?)?;
        }
        let is_last = self.under_way.len() < 2 && self.waiting.kernel().is_none();
        let steps = Stage::Reality.steps_of(&self.meeting);
        let is_due = is_last || !self.room.has(self.meeting.len(), steps);
        if let Some(kernel) = self.meeting.first().map(|life| life.site.kernel())
            && is_due
        {
            let (lives, others) = std::mem::take(&mut self.meeting)
                .into_iter()
                .partition(|life| life.site.kernel() == kernel);
            self.meeting = others;
            self.send(Crew::new(lives, Stage::Reality)?)?;
        }
        Ok(())
    }

    /// Whether the device would soon have nothing to do: fewer than two crews are large, or can grow.
    fn wants_crew(&self) -> bool {
        let lasts = |crew: &&Crew| {
            let kernel = crew.lives.first().map(|life| life.site.kernel());
            !self.room.has(crew.lives.len(), crew.steps) || kernel.is_some_and(|kernel| self.waiting.has(kernel))
        };
        self.under_way.len() < CREWS && self.under_way.iter().filter(lasts).count() < 2
    }

    /// Lets waiting runs join, as many as there is room for.
    fn joined(&mut self, mut lives: Vec<Life>, kernel: &str) -> Result<Vec<Life>> {
        let others: usize = self.under_way.iter().map(|crew| crew.lives.len()).sum();
        let mut steps = Stage::Simulation.steps_of(&lives);
        while others + lives.len() < self.room.all && self.room.has(lives.len(), steps) {
            let Some(life) = self.waiting.next(kernel)? else {
                break;
            };
            steps += Stage::Simulation.steps(&life.site);
            lives.push(life);
        }
        Ok(lives)
    }

    fn send(&mut self, crew: Crew) -> Result {
        self.worker.submit(crew.batch()?);
        self.under_way.push_back(crew);
        Ok(())
    }

    /// Sends the first crew off again, without the runs that have ended and with others in their place. What has ended.
    fn go_on(&mut self) -> Result<Vec<Outcome>> {
        let Some(mut crew) = self.under_way.pop_front() else {
            return Ok(Vec::new());
        };
        let lives = std::mem::take(&mut crew.lives);
        if crew.stage == Stage::Reality {
            return Ok(lives.into_iter().filter_map(|life| life.outcome).collect());
        }
        let kernel = lives.first().map_or("", |life| life.site.kernel());
        let (simulated, lives): (Vec<Life>, Vec<Life>) = lives.into_iter().partition(Life::is_simulated);
        let lives = self.joined(lives, kernel)?;
        if !lives.is_empty() {
            let crew = crew.with(lives)?;
            self.send(crew)?;
        }
        let (ended, meeting): (Vec<Life>, Vec<Life>) =
            simulated.into_iter().partition(|life| life.site.reality.is_empty());
        self.meeting.extend(meeting);
        Ok(ended.into_iter().filter_map(|life| life.outcome).collect())
    }

    /// Has the runs under way written down.
    fn checkpoint(&mut self) -> Result {
        self.checkpointed = Instant::now();
        let crews = self.under_way.iter().flat_map(|crew| &crew.lives);
        self.journal
            .checkpoint(crews.chain(&self.meeting).map(Life::saved).collect())
    }
}
