//! Fitness, measures and traces of genomes.

use std::sync::{Mutex, PoisonError};

use oneiro::batch::{GREATEST_GENE, LANES, Rollout, WorldKind, parts_of};
use oneiro::compose::Scalar;
use oneiro::evaluator::{Device, Evaluator};
use oneiro::random::Keys as GenerationKeys;
use oneiro::world::World;
use oneiro_base::exit::Failure;
use oneiro_evolve::Population;
use oneiro_lab::experiment::check_seed;
use oneiro_lab::lives::measures::{Descriptor, Measures, descriptors};
use oneiro_lab::lives::{Keys, LifeIndex, Lines, Lives};
use oneiro_lab::runs::single::trace::TraceTable;

use super::device;
use super::experiment::Experiment;
use super::{Error, Result, Task};

/// Lives in a batch: enough for any device.
const MOST: usize = LANES << 12;
/// Most lives of a call.
const GREATEST: usize = 1 << 32;

/// A column of a trace: its name, and the type of its words.
pub type TraceColumn = (String, Scalar);

/// What to evaluate.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Genomes, one after the other.
    pub genomes: &'a [f32],
    /// Seed of the lives' random numbers.
    pub seed: u64,
    /// Each genome's generation and number, from which its random numbers are made with the seed. By default generation 0, and its
    /// index, as `oneiro evaluate` has it.
    pub numbers: Option<&'a [[u64; 2]]>,
    /// Lives of each genome.
    pub lives: usize,
    /// Whether all genomes have the random numbers of the first, and so its starts.
    pub common_starts: bool,
    /// The device, as `--backend` names it.
    pub backend: &'a str,
    /// Names of the measures wanted of lives.
    pub descriptors: &'a [String],
    /// Whether episodes are measured as in a run, for [`Evolution::tell`](super::experiment::Evolution::tell): without the end of their
    /// last cycle, since a run's episodes aren't prolonged to see it. Otherwise `oneiro evaluate --measures` has the same numbers.
    pub as_in_run: bool,
    /// Whether to trace lives.
    pub traces: bool,
}

/// Results of lives, by genome and then by life.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Fitness.
    pub fitness: Vec<f32>,
    /// Measures, those of a life together in the order of the request; empty if they weren't requested.
    pub descriptors: Vec<f64>,
    /// Words of each cycle's columns, for as many cycles as a life has at most: zeros from an early end on. Empty if they weren't
    /// requested.
    pub traces: Vec<u32>,
    /// Cycles of each life that is in the traces.
    pub lengths: Vec<u32>,
    /// The device, such as `cpu (native256x16, 2 threads)`.
    pub device: String,
    /// Whether it guarantees the bits that every other exact device gives.
    pub exact: bool,
    /// Warnings of the device, such as that it was lost. Results are right nevertheless.
    pub warnings: Vec<String>,
}

/// Evaluates genomes.
///
/// # Errors
/// Exit 3 for swarms, for a seed above 2^63 - 1, and for genomes or numbers that aren't allowed; exit 4 if there is no such device; exit 75 if the task was
/// stopped.
pub fn evaluate(experiment: &Experiment, request: &Request<'_>, task: &Task) -> Result<Outcome> {
    check_seed(request.seed)?;
    let world = experiment.world()?;
    let genes = world.genes();
    let count = request.genomes.len() / genes;
    if count * genes != request.genomes.len() {
        let problem = format!(
            "genomes: are {} genes; allowed: genomes of {genes} each",
            request.genomes.len()
        );
        return Err(Error::input(problem));
    }
    let is_allowed = |gene: &f32| gene.abs() <= GREATEST_GENE;
    if let Some(place) = request.genomes.iter().position(|gene| !is_allowed(gene)) {
        return Err(Error::input(format_args!(
            "genomes[{}, {}]: is {}; allowed: -{GREATEST_GENE} to {GREATEST_GENE}",
            place / genes,
            place % genes,
            request.genomes[place]
        )));
    }
    if request.lives == 0 || count.saturating_mul(request.lives) > GREATEST {
        let problem = format!("lives: is {}; allowed: 1 and more, 2^32 in all", request.lives);
        return Err(Error::input(problem));
    }
    if request.numbers.is_some_and(|numbers| numbers.len() != count) {
        return Err(Error::input("keys: aren't as many as genomes; allowed: one for each"));
    }
    let lives = (count * request.lives) as u64;
    task.expect(lives * u64::from(world.cycles()) * u64::from(world.robots()));
    device::threaded(|| {
        device::with(request.backend, |evaluator| {
            let warned = evaluator.warnings().len();
            let mut outcome = if count == 0 {
                named_measures(world, request.descriptors).map(|_| Outcome::default())
            } else if !request.descriptors.is_empty() || request.traces {
                watched(world, request, evaluator, task)
            } else {
                fitness(experiment, request, evaluator, task)
            }?;
            let Device { exact, .. } = evaluator.device();
            outcome.device = device::words(&evaluator.device());
            outcome.exact = exact;
            outcome.warnings = evaluator.warnings()[warned..].to_vec();
            Ok(outcome)
        })?
    })
}

/// The genome and the number of each life's random numbers.
fn keys<'a>(request: &Request<'a>) -> Keys<'a> {
    Keys {
        common: request.common_starts,
        numbers: request.numbers,
        ..Keys::of_seed(request.seed)
    }
}

/// Fitness alone: genomes are packed from where they are.
fn fitness(
    experiment: &Experiment,
    request: &Request<'_>,
    evaluator: &mut dyn Evaluator,
    task: &Task,
) -> Result<Outcome> {
    let worlds = experiment.worlds()?;
    let genes = experiment.world()?.genes();
    let keys = keys(request);
    // What all lives of a generation share is computed once.
    let all = GenerationKeys::new(request.seed, 0);
    let rollout = |life: usize| {
        let (genome, number) = (life / request.lives, life % request.lives);
        Rollout {
            world: 0,
            genes: &request.genomes[genome * genes..][..genes],
            key: match (request.numbers, request.common_starts) {
                (None, false) => all.of(genome as u64, number as u64),
                _ => keys.of(genome, number),
            },
        }
    };
    let lives = request.genomes.len() / genes * request.lives;
    let mut fitness = Vec::with_capacity(lives);
    for first in (0..lives).step_by(MOST) {
        let rollouts: Vec<_> = (first..(first + MOST).min(lives)).map(rollout).collect();
        let batch = worlds
            .batch(&rollouts, None)
            .map_err(|invalid| Failure::input(named(&invalid.to_string())))?;
        drop(rollouts);
        let own = evaluator.evaluate(&batch, &task.control)?.fitness;
        if fitness.is_empty() {
            fitness = own;
        } else {
            fitness.extend(own);
        }
    }
    Ok(Outcome {
        fitness,
        ..Outcome::default()
    })
}

/// What a batch calls rollouts are genomes here, as long as there is one life of each.
fn named(problem: &str) -> String {
    format!("genomes: {problem}")
}

/// Fitness with measures or traces.
fn watched(world: &World, request: &Request<'_>, evaluator: &mut dyn Evaluator, task: &Task) -> Result<Outcome> {
    let cycles = world.cycles();
    let spec = world.spec().clone();
    let lived = [if request.as_in_run || cycles > oneiro::stepped::GREATEST_CYCLES {
        world.clone()
    } else {
        World::new(spec.seen_to_its_end())?
    }];
    let genomes = Population::new(world.genes(), request.genomes.to_vec());
    let lives = Lives {
        worlds: &lived,
        genomes: &genomes,
        count: request.lives,
        keys: keys(request),
    };
    let count = genomes.len() * request.lives;
    let table = TraceTable::new(world);
    let words = table.scalars().len() * cycles as usize;
    let mut traces = Vec::new();
    if request.traces {
        let all = count.checked_mul(words);
        if all.is_none_or(|all| traces.try_reserve_exact(all).is_err()) {
            let problem =
                format!("traces: {count} episodes of {cycles} cycles don't fit into memory; allowed: fewer at a time");
            return Err(Error::input(problem));
        }
        traces.resize(count * words, 0);
    }
    let measures = named_measures(world, request.descriptors)?;
    let mut outcome = Outcome {
        fitness: vec![f32::NAN; count],
        descriptors: vec![f64::NAN; count * measures.len()],
        lengths: vec![0; if request.traces { count } else { 0 }],
        traces,
        ..Outcome::default()
    };
    let index = |life: LifeIndex| life.genome * request.lives + life.number;
    let width = world.record_words() as usize;
    let (columns, lengths) = (table.scalars().len(), outcome.lengths.iter_mut());
    let places = outcome.traces.chunks_exact_mut(words.max(1)).zip(lengths);
    let places: Vec<_> = places.map(Mutex::new).collect();
    let trace = |life: LifeIndex, first: u32, lines: &[u32]| {
        let (own, length) = &mut *places[index(life)].lock().unwrap_or_else(PoisonError::into_inner);
        let own = own[first as usize * columns..].chunks_exact_mut(columns);
        for (places, line) in own.zip(lines.chunks_exact(width)) {
            let (record, details) = parts_of(line);
            for (place, word) in places.iter_mut().zip(table.words(record, details)) {
                *place = word;
            }
            **length += 1;
        }
        Ok(())
    };
    let trace: Option<Lines<'_>> = if request.traces { Some(&trace) } else { None };
    let (fitness_of, descriptors_of) = (&mut outcome.fitness, &mut outcome.descriptors);
    let mut ended = |life: LifeIndex, fitness: f32, own: &Measures| {
        fitness_of[index(life)] = fitness;
        let values = descriptors_of[index(life) * measures.len()..].iter_mut();
        for (place, descriptor) in values.zip(&measures) {
            *place = descriptor.value(own);
        }
    };
    lives.measured(evaluator, &task.control, cycles, &measures, trace, &mut ended)?;
    drop(places);
    Ok(outcome)
}

/// A world's measures by their names.
fn named_measures(world: &World, names: &[String]) -> Result<Vec<Descriptor>> {
    let known = descriptors(world);
    let named = |name: &String| {
        let own = known.iter().find(|own| own.column.name == *name);
        own.cloned().ok_or_else(|| {
            let allowed: Vec<_> = known.iter().map(|own| &*own.column.name).collect();
            Error::input(format!("descriptors: has {name:?}; allowed: {}", allowed.join(", ")))
        })
    };
    names.iter().map(named).collect()
}
