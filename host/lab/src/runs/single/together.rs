//! The page of `oneiro replay` that plays an episode; for swarms also a table with a row for each robot.

use std::fmt::Display;
use std::sync::Arc;

use oneiro::automode::Form;
use oneiro::batch::{LANES, Rollout, Trace, TraceRequest, Worlds};
use oneiro::compose::{DetailKind, Kind};
use oneiro::cpu::Cpu;
use oneiro::world::World;
use oneiro_base::contents::Column;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Champion;
use oneiro_report::csv::Csv;
use oneiro_report::figures::{self, EpisodeReplay};
use oneiro_report::numbers::significant;

use crate::engine::handle::Engine;

/// Words of a trace in memory at a time, 64 MB, and bytes of a page.
const WORDS: usize = 16 << 20;
const PAGE: usize = 4_900_000;

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

/// A single robot's episode, whose trace has a record each `every` cycles.
pub(super) fn of_one<'a>(
    world: &'a World,
    genes: &'a [f32],
    trace: &Trace,
    every: u32,
    title: &'a str,
) -> EpisodeReplay<'a> {
    let most = (PAGE / figures::bytes_of_record(world)).max(1);
    let thinned = trace.len().div_ceil(most).max(1);
    EpisodeReplay {
        title,
        world,
        cycles: (trace.len() as u32 * every).min(world.cycles()),
        robots: vec![trace.thinned(0, thinned)],
        generations: Vec::new(),
        every: every * thinned as u32,
        earned: Vec::new(),
        genes: genes_of_robots(world, genes),
    }
}

/// Episodes of several generations' bests, each alone in its world, whose traces have a record each `every` cycles. One that ends earlier
/// stays where it ended.
pub(super) fn of_generations<'a>(
    world: &'a World,
    bests: &'a [Champion],
    traces: &[Trace],
    every: u32,
    title: &'a str,
) -> EpisodeReplay<'a> {
    let longest = traces.iter().map(|trace| trace.len()).max().unwrap_or(0);
    let most = (PAGE / figures::bytes_of_record(world) / traces.len()).max(1);
    let thinned = longest.div_ceil(most).max(1);
    let levelled = traces.iter().map(|trace| {
        let mut levelled = trace.clone();
        let last = trace.thinned(trace.len().saturating_sub(1), 1);
        while !last.is_empty() && levelled.len() < longest {
            levelled.append(&last);
        }
        levelled.thinned(0, thinned)
    });
    let levelled: Vec<Trace> = levelled.collect();
    let earned = |trace: &Trace| trace.iter().map(|record| record.fitness).collect();
    EpisodeReplay {
        title,
        world,
        cycles: (longest as u32 * every).min(world.cycles()),
        earned: levelled.iter().map(earned).collect(),
        robots: levelled,
        generations: bests.iter().map(|best| best.generation).collect(),
        every: every * thinned as u32,
        genes: bests
            .iter()
            .flat_map(|best| genes_of_robots(world, &best.genome))
            .collect(),
    }
}

/// Re-simulates and observes an episode of a swarm. None with a warning if the world can't be observed.
pub(super) fn watch(
    world: &World,
    life: &Rollout<'_>,
    every: u32,
    fitness: f32,
    engine: &Engine,
) -> Result<(Option<Watched>, Option<String>)> {
    let none = |why: &dyn Display| (None, Some(format!("there is no page that plays the episode: {why}")));
    let observed = match world.observed() {
        Ok(observed) => observed,
        Err(invalid) => return Ok(none(&invalid)),
    };
    let mut watched = Watched::new(observed, life, every);
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
        return Ok(none(&"it ends before its first cycle"));
    }
    Ok((Some(watched), None))
}

/// The page of a swarm's episode. `None` if its world can't be observed, or the episode ends before its first cycle.
pub(super) fn page_of_swarm(world: &World, life: &Rollout<'_>, engine: &Engine, title: &str) -> Result<Option<String>> {
    let Ok(observed) = world.observed() else {
        return Ok(None);
    };
    let mut watched = Watched::new(observed, life, 1);
    watched.live(life, engine)?;
    Ok((watched.robots[0].cycles > 0).then(|| figures::episode_page(&watched.episode(title))))
}

impl Watched {
    fn new(world: World, life: &Rollout<'_>, every: u32) -> Self {
        let robots = world.robots() as usize;
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
        let scores = self.world.details().iter().any(|own| own.kind == DetailKind::Earned);
        let earned = self.robots.iter().filter(|_| scores).map(|own| own.earned.clone());
        EpisodeReplay {
            title,
            world: &self.world,
            cycles: self.robots[0].cycles,
            robots: self.robots.iter().map(|own| own.trace.clone()).collect(),
            generations: Vec::new(),
            every: self.every,
            earned: earned.collect(),
            genes: genes_of_robots(&self.world, &self.genome),
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
