//! The page of `oneiro replay` that plays an episode; for swarms also a table with a row for each robot.

use std::sync::Arc;

use oneiro::automode::Form;
use oneiro::batch::{Batch, LANES, Rollout, Trace, TraceRequest, Worlds};
use oneiro::compose::{DetailKind, Kind};
use oneiro::cpu::Cpu;
use oneiro::random::Key;
use oneiro::world::World;
use oneiro_base::contents::Column;
use oneiro_base::exit::{Failure, Result};
use oneiro_report::csv::Csv;
use oneiro_report::figures::{self, Compared, EpisodeReplay};
use oneiro_report::numbers::significant;

use crate::engine::handle::Engine;

/// Words of a trace in memory at a time, 64 MB, and bytes of a page.
const WORDS: usize = 16 << 20;
const PAGE: usize = 4_900_000;
/// Why an episode has no page.
pub(super) const NO_CYCLE: &str = "it ends before its first cycle";

pub(super) static COLUMNS: [Column; 6] = [
    Column::whole("robot", "", "its number, from 0"),
    Column::number(
        "score",
        "",
        "the robot's score from the task; empty if the mission scores the whole swarm",
    ),
    Column::number(
        "distance_mm",
        "mm",
        "the length of its path, from the start of the first cycle to that of the last",
    ),
    Column::whole("contacts", "cycles", "those that ended elsewhere than if it were alone"),
    Column::whole(
        "heard",
        "",
        "messages that it received; empty without a reference model",
    ),
    Column::text(
        "states",
        "cycles after which its machine was in each state, from state 0 on, or in each branch of its behaviour tree; empty without either",
    ),
];

/// An observed episode.
pub(super) struct Watched {
    /// Its world, observed.
    world: World,
    robots: Vec<Lived>,
    /// Cycles between the page's records.
    every: u32,
    genome: Vec<f32>,
}

/// What a robot did.
#[derive(Default)]
struct Lived {
    /// The page's records, and the robot's earnings by then.
    trace: Trace,
    earned: Vec<f32>,
    cycles: u32,
    score: f32,
    distance: f64,
    contacts: u32,
    heard: u64,
    /// Cycles after which its machine was in each state.
    states: Vec<u32>,
    /// The position at the start of the last cycle.
    at: Option<[f32; 2]>,
}

/// The genes of each robot's controller.
fn genes_of_robots<'a>(world: &World, genome: &'a [f32]) -> Vec<&'a [f32]> {
    (0..world.robots())
        .map(|robot| &genome[world.genes_of(robot)])
        .collect()
}

/// An episode on a page.
struct Shown<'a> {
    /// The trace of each robot, and its earnings; empty unless robots have scores.
    robots: Vec<Trace>,
    earned: Vec<Vec<f32>>,
    cycles: u32,
    genome: &'a [f32],
}

impl<'a> Shown<'a> {
    /// That of a single robot.
    fn alone(world: &World, genome: &'a [f32], trace: &Trace, every: u32) -> Self {
        Self {
            robots: vec![trace.clone()],
            earned: Vec::new(),
            cycles: (trace.len() as u32 * every).min(world.cycles()),
            genome,
        }
    }
}

/// Episodes that start alike, in worlds like this one, whose traces have a record each `every` cycles. One that ends earlier stays where it
/// ended.
fn together<'a>(
    world: &'a World,
    episodes: Vec<Shown<'a>>,
    compared: Compared<'a>,
    every: u32,
    title: &'a str,
) -> EpisodeReplay<'a> {
    let longest = episodes.iter().map(|own| own.robots[0].len()).max().unwrap_or(0);
    let cycles = episodes.iter().map(|own| own.cycles).max().unwrap_or(0);
    let robots = episodes.len() * episodes[0].robots.len();
    let most = (PAGE / figures::bytes_of_record(world) / robots).max(1);
    let thinned = longest.div_ceil(most).max(1);
    let (mut traces, mut earned, mut genes) = (Vec::new(), Vec::new(), Vec::new());
    for own in episodes {
        genes.extend(genes_of_robots(world, own.genome));
        traces.extend(own.robots.into_iter().map(|mut trace| {
            let last = trace.thinned(trace.len() - 1, 1);
            while trace.len() < longest {
                trace.append(&last);
            }
            trace.thinned(0, thinned)
        }));
        earned.extend(own.earned.into_iter().map(|mut earned| {
            earned.resize(longest, earned.last().copied().unwrap_or_default());
            earned.into_iter().step_by(thinned).collect::<Vec<_>>()
        }));
    }
    EpisodeReplay {
        title,
        world,
        cycles,
        robots: traces,
        compared,
        every: every * thinned as u32,
        earned,
        genes,
    }
}

/// A single robot's episode, whose trace has a record each `every` cycles.
pub(super) fn of_one<'a>(
    world: &'a World,
    genome: &'a [f32],
    trace: &Trace,
    every: u32,
    title: &'a str,
) -> EpisodeReplay<'a> {
    let own = Shown::alone(world, genome, trace, every);
    together(world, vec![own], Compared::Nothing, every, title)
}

/// Simulates episodes with the same random numbers, each in its world and of its genome. Returns what `show` makes of them, and
/// their fitness.
///
/// # Errors
/// `refused` says that an episode, by its number, can't be shown, and why.
pub(super) fn compare<T>(
    episodes: &[(World, &[f32])],
    key: Key,
    (compared, every, title): (Compared<'_>, u32, &str),
    engine: &Engine,
    refused: impl Fn(usize, &str) -> Failure,
    show: impl FnOnce(&EpisodeReplay<'_>) -> Result<T>,
) -> Result<(T, Vec<f32>)> {
    let every = every.min(episodes[0].0.cycles());
    let (mut fitness, mut traces, mut watched) = (Vec::new(), Vec::new(), Vec::new());
    let in_own = |(world, genes): &(World, _)| (world.of(key).clone(), *genes);
    let episodes: Vec<(World, &[f32])> = episodes.iter().map(in_own).collect();
    for (number, (world, genes)) in episodes.iter().enumerate() {
        let life = Rollout { world: 0, genes, key };
        let trace = (world.robots() == 1).then_some(TraceRequest { every });
        // Worlds may have different kernels.
        let outcome = engine.evaluate(&Batch::new(std::slice::from_ref(world), &[life], trace)?)?;
        fitness.push(outcome.fitness[0]);
        if world.robots() == 1 {
            let trace = outcome.traces.into_iter().next().filter(|trace| !trace.is_empty());
            traces.push(trace.ok_or_else(|| refused(number, NO_CYCLE))?);
        } else {
            let own = watch(world, &life, every, outcome.fitness[0], episodes.len(), engine)?;
            watched.push(own.map_err(|why| refused(number, &why))?);
        }
    }
    let alone = episodes.iter().zip(&traces);
    let alone = alone.map(|((world, genes), trace)| Shown::alone(world, genes, trace, every));
    let shown = alone.chain(watched.iter().map(Watched::shown)).collect();
    let (world, every) = watched
        .first()
        .map_or((&episodes[0].0, every), |own| (&own.world, own.every));
    Ok((show(&together(world, shown, compared, every, title))?, fitness))
}

/// Re-simulates and observes an episode of a swarm, one of `episodes` of a page; or says why it can't be shown.
pub(super) fn watch(
    world: &World,
    life: &Rollout<'_>,
    every: u32,
    fitness: f32,
    episodes: usize,
    engine: &Engine,
) -> Result<std::result::Result<Watched, String>> {
    let observed = match world.of(life.key).observed() {
        Ok(observed) => observed,
        Err(invalid) => return Ok(Err(invalid.to_string())),
    };
    let mut watched = Watched::new(observed, life, every, episodes);
    // The code requested by the user may exist only for unobserved worlds; the bits are the same.
    let processor = Engine::new(Box::new(Cpu::new(Some(1))?), Arc::clone(engine.stop()));
    let lived = watched.live(life, &processor)?;
    if lived.to_bits() != fitness.to_bits() {
        return Err(Failure::failed(format_args!(
            "the watched episode has the fitness {lived} on this processor, but {fitness} on {}",
            engine.name()
        )));
    }
    if watched.robots[0].cycles == 0 {
        return Ok(Err(NO_CYCLE.to_owned()));
    }
    Ok(Ok(watched))
}

/// The page of a swarm's episode. `None` if its world can't be observed, or the episode ends before its first cycle.
pub(super) fn page_of_swarm(world: &World, life: &Rollout<'_>, engine: &Engine, title: &str) -> Result<Option<String>> {
    let Ok(observed) = world.of(life.key).observed() else {
        return Ok(None);
    };
    let mut watched = Watched::new(observed, life, 1, 1);
    watched.live(life, engine)?;
    Ok((watched.robots[0].cycles > 0).then(|| figures::episode_page(&watched.episode(title))))
}

impl Watched {
    fn new(world: World, life: &Rollout<'_>, every: u32, episodes: usize) -> Self {
        let robots = episodes * world.robots() as usize;
        let most = PAGE / (robots * figures::bytes_of_record(&world));
        let form = Form::of(world.gene_layout());
        let own = |genes: &[f32]| Lived {
            states: vec![0; form.map_or(0, |form| form.behaviours(genes).len())],
            ..Lived::default()
        };
        Self {
            every: every.max(world.cycles().div_ceil(most.max(1) as u32)),
            robots: genes_of_robots(&world, life.genes).into_iter().map(own).collect(),
            genome: life.genes.to_vec(),
            world,
        }
    }

    /// Simulates an episode in stretches whose traces fit in memory; returns the fitness.
    fn live(&mut self, life: &Rollout<'_>, engine: &Engine) -> Result<f32> {
        let worlds = Worlds::new(std::slice::from_ref(&self.world))?;
        let lives = [Rollout { world: 0, ..*life }];
        let (mut first, mut states, mut fitness) = (0, Vec::new(), f32::NAN);
        // The first cycle tells how long a record is.
        let mut stretch = 1;
        while first < self.world.cycles() {
            let end = (first + stretch).min(self.world.cycles());
            let batch = worlds.stretch(&lives, first..end, &states, Some(TraceRequest { every: 1 }))?;
            stretch = (WORDS / LANES / batch.record_words()).max(1) as u32;
            let outcome = engine.evaluate(&batch)?;
            for (own, trace) in self
                .robots
                .iter_mut()
                .zip(outcome.traces[0].by_robot(self.world.robots()))
            {
                own.add(&self.world, &trace, first, self.every);
            }
            (states, fitness, first) = (outcome.states, outcome.fitness[0], end);
        }
        Ok(fitness)
    }

    /// What is shown of it.
    pub(super) fn episode<'a>(&'a self, title: &'a str) -> EpisodeReplay<'a> {
        together(&self.world, vec![self.shown()], Compared::Nothing, self.every, title)
    }

    fn shown(&self) -> Shown<'_> {
        let scores = self.world.details().iter().any(|own| own.kind == DetailKind::Earned);
        Shown {
            robots: self.robots.iter().map(|own| own.trace.clone()).collect(),
            earned: self
                .robots
                .iter()
                .filter(|_| scores)
                .map(|own| own.earned.clone())
                .collect(),
            cycles: self.robots[0].cycles,
            genome: &self.genome,
        }
    }

    /// A row for each robot.
    pub(super) fn table(&self) -> String {
        let has = |kind| self.world.details().iter().any(|own| own.kind == kind);
        let (scores, hears) = (has(DetailKind::Earned), has(DetailKind::Heard));
        let only = |is_known: bool, value: String| if is_known { value } else { String::new() };
        let mut csv = Csv::new(&COLUMNS);
        for (robot, own) in self.robots.iter().enumerate() {
            let states: Vec<String> = own.states.iter().map(u32::to_string).collect();
            csv.row([
                robot.to_string(),
                only(scores, own.score.to_string()),
                significant(own.distance, 6),
                own.contacts.to_string(),
                only(hears, own.heard.to_string()),
                states.join(" "),
            ]);
        }
        csv.text()
    }
}

impl Lived {
    /// Adds the records of the next cycles, `first` and following.
    fn add(&mut self, world: &World, trace: &Trace, first: u32, every: u32) {
        let acting = Form::of(world.gene_layout()).map(Form::acting);
        self.cycles += trace.len() as u32;
        for ((record, details), cycle) in trace.lines().zip(first..) {
            let at = [record.x, record.y];
            if let Some(before) = self.at.replace(at) {
                self.distance += f64::from(at[0] - before[0]).hypot(f64::from(at[1] - before[1]));
            }
            self.contacts += u32::from(record.collided > 0.0);
            for (detail, &word) in world.details().iter().zip(details) {
                match detail.kind {
                    // Adds in the kernel's order of operations.
                    DetailKind::Earned => self.score += f32::from_bits(word),
                    DetailKind::Heard => self.heard += u64::from(word.count_ones()),
                    DetailKind::Memory(Kind::Controller) if Some(detail.name.as_str()) == acting => {
                        if let Some(cycles) = self.states.get_mut(word as usize) {
                            *cycles += 1;
                        }
                    }
                    _ => {}
                }
            }
            if cycle % every == 0 {
                self.earned.push(self.score);
            }
        }
        let skipped = (every - first % every) % every;
        self.trace.append(&trace.thinned(skipped as usize, every as usize));
    }
}
