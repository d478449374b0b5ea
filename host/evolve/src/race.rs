//! An iterated race, by the principle of irace (López-Ibáñez, Dubois-Lacoste, Pérez Cáceres, Birattari and Stützle,
//! "The irace package: iterated racing for automatic algorithm configuration", Operations Research Perspectives 3,
//! 2016), without its elitist variant. Candidates run the same episodes, one generation after another, and those that
//! are worse by a test on ranks drop out. New ones are sampled around the survivors, ever closer to them.

mod friedman;
mod sampling;
mod tails;

use crate::error::{Error, Result};
use oneiro::parameter::Allowed::{Number, Whole};
use oneiro::parameter::{Parameter, row};
use oneiro::world::Gene;
use serde::{Deserialize, Serialize};

use super::random::{Stream, stream};
use super::registry::{Entry, Table};
use super::settings::{Checked, Feature, Given, GivenGenomes, Settings, Surroundings, refused};
use super::{Champion, Finalists, Optimizer, Population, saved};
use sampling::{Candidate, Model};

const NAME: &str = "race";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::SetsFirstGenes, Feature::SetsGenerations, Feature::Unrecorded],
    // As the initial configurations of irace.
    start: GivenGenomes::First("random"),
    population: "the maximum of its first race",
    complete,
    check,
    evaluations: |settings| settings.tables.race.evaluations(),
    survivors: |genes| few(genes) as u32,
    spend: |settings, given, _, left| {
        settings.tables.race.lives = left(settings) * u64::from(given.trials);
        complete(settings, given);
        // The first generation is evaluated in any case.
        let first = u64::from(settings.population) * u64::from(given.trials);
        settings.tables.race.lives = settings.tables.race.lives.max(first);
    },
    ..Entry::new(
        [
            NAME,
            "an iterated race, in which candidates drop out by a test on ranks: López-Ibáñez et al. 2016 (irace)",
            "genomes with choices, such as [state machines](controllers.md#state-machines), with rough or noisy scores",
        ],
        |beginning| {
            Box::new(Race::new(
                beginning.settings,
                beginning.seed,
                beginning.genes,
                beginning.init.as_ref(),
            ))
        },
    )
};

/// Values of a race.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    /// Episodes of all candidates.
    pub lives: u64,
    /// Episodes of a candidate in a generation: those of the experiment.
    pub trials: u32,
    /// Generations before the first test.
    pub first_test: u32,
    /// Of the test.
    pub confidence: f64,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            lives: 200_000,
            trials: 1,
            first_test: 5,
            confidence: 0.95,
        }
    }
}

impl Values {
    /// Candidates that may be evaluated for a generation.
    fn evaluations(&self) -> u64 {
        self.lives / u64::from(self.trials.max(1))
    }

    /// Candidates of the first race.
    fn greatest_population(&self, genes: usize) -> u32 {
        let iterations = few(genes) as u64;
        let count = self.evaluations() / iterations / (u64::from(self.first_test) + 1);
        u32::try_from(count)
            .unwrap_or(u32::MAX)
            .clamp(iterations as u32 + 1, 100_000)
    }
}

impl Table for Values {
    #[rustfmt::skip]
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
        vec![
            row("evolution.race.lives", "", Whole(1, 1_000_000_000), "the budget of EvoStick and AutoMoDe in Francesca et al. 2014",
                "Maximum number of episodes of all candidates; those of finalists don't count.", |values, _| Some(&mut values.as_mut().race()?.lives)),
            row("evolution.race.first_test", "", Whole(2, 100), "irace (López-Ibáñez et al. 2016)",
                "Generations before the first test of a race.", |values, _| Some(&mut values.as_mut().race()?.first_test)),
            row("evolution.race.confidence", "", Number(0.5, 0.999_999), "irace (López-Ibáñez et al. 2016)",
                "Confidence of the test by which candidates drop out.", |values, _| Some(&mut values.as_mut().race()?.confidence)),
        ]
    }
}

fn complete(settings: &mut Settings, given: Given) {
    let race = &mut settings.tables.race;
    race.trials = given.trials;
    // No generation has fewer than two.
    settings.generations = u32::try_from(race.evaluations() / 2 + 1).unwrap_or(u32::MAX);
    if !given.has_population {
        settings.population = race.greatest_population(given.genes);
    }
    settings.common.get_or_insert(true);
}

/// Checks what a race needs, and what it does not go with: its generations differ in size, and their number is not known beforehand.
fn check(settings: &Settings, surroundings: &Surroundings<'_>) -> Checked {
    let (genes, population) = (surroundings.genes.len(), settings.population);
    let few = few(genes);
    if population as usize <= few {
        let problem = format!("is {population}; allowed: more than {few}, which may survive a race of {genes} genes");
        return refused("evolution.population", problem);
    }
    if !settings.has_common_numbers() {
        let problem = "is false; allowed: true with race, whose candidates run the same episodes";
        return refused("evolution.common_random_numbers", problem);
    }
    if surroundings.records_individuals {
        let problem = "is true; allowed: false with race, whose generations differ in size";
        return refused("record.individuals", problem);
    }
    if surroundings.has_robot {
        let problem = "is given; allowed: none with race, whose number of generations is not known beforehand";
        return refused("reality.robot", problem);
    }
    Ok(())
}

/// A generation for the candidates of a race.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Round {
    /// The race's number, from 1.
    pub race: u32,
    /// Candidates that were evaluated.
    pub candidates: u32,
    /// The remaining ones: after the last generation of a race, those around which the next one samples.
    pub survivors: u32,
}

/// The race at one generation.
#[derive(Clone, Debug)]
struct Race {
    owner: saved::Owner,
    values: Values,
    /// The most evaluations.
    budget: u64,
    /// The most candidates of a race.
    most: u64,
    seed: u64,
    model: Model,
    state: RaceState,
    population: Population,
    round: Option<Round>,
}

/// A survivor of the last race that ended, and where it lived last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Elite {
    candidate: Candidate,
    generation: u32,
    individual: u32,
    fitness: f32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct RaceState {
    generation: u32,
    /// Evaluations so far, and when this race has to end.
    used: u64,
    until: u64,
    /// Number of this race, from 1.
    iteration: u32,
    /// Standard deviations of samples, in halves of the ranges.
    spread: f64,
    candidates: Vec<Candidate>,
    /// The place of each candidate in each generation of this race: how many scores were better.
    places: Vec<Vec<u32>>,
    /// The best first.
    elites: Vec<Elite>,
    is_over: bool,
}

impl Race {
    /// Begins with random candidates, the first of which may be given.
    fn new(settings: &Settings, seed: u64, genes: &[Gene], init: Option<&Population>) -> Self {
        let ranges = genes.iter().map(|gene| gene.range).collect();
        let mut race = Self {
            owner: saved::Owner::new(settings, seed, &ranges),
            values: settings.tables.race.clone(),
            budget: settings.tables.race.evaluations(),
            most: settings.population.into(),
            seed,
            model: Model::new(settings, genes),
            state: RaceState {
                generation: 0,
                used: 0,
                until: 0,
                iteration: 0,
                spread: 1.0,
                candidates: Vec::new(),
                places: Vec::new(),
                elites: Vec::new(),
                is_over: false,
            },
            population: Population::new(genes.len(), Vec::new()),
            round: None,
        };
        let given = init.into_iter().flat_map(Population::genomes);
        let given: Vec<_> = given.map(|genome| race.model.given(genome)).collect();
        race.begin(&given);
        race.populate();
        race
    }

    /// The number of candidates and of evaluations of a race. Each race to come gets an equal share of what is left of the budget; there
    /// are fewer races if that share is too small for more candidates than survive a race.
    fn planned(&self, iteration: u32) -> (usize, u64) {
        let few = few(self.model.genes());
        let to_come = self.iterations(iteration) - u64::from(iteration) + 1;
        let lives = u64::from(self.values.first_test) + u64::from(iteration.min(5));
        let rest = self.budget.saturating_sub(self.state.used);
        let mut shares = (1..=to_come).rev().map(|races| rest / races);
        let share = shares.find(|share| share / lives > few as u64).unwrap_or(rest);
        ((share / lives).min(self.most) as usize, share)
    }

    /// The number of races that the budget is divided among, counting those that have begun.
    fn iterations(&self, iteration: u32) -> u64 {
        u64::from(iteration).max(few(self.model.genes()) as u64)
    }

    /// Begins the next race, if there is budget for more candidates than survive one. The first one begins in any case, with `given`
    /// candidates and random ones.
    fn begin(&mut self, given: &[Candidate]) {
        let few = few(self.model.genes());
        let iteration = self.state.iteration + 1;
        let (count, share) = self.planned(iteration);
        if count <= few && iteration > 1 {
            self.state.is_over = true;
            return;
        }
        let count = count.max(few + 1);
        self.state.candidates = self.sampled(iteration, count, given);
        self.state.iteration = iteration;
        self.state.until = self.state.used + share;
        self.state.places.clear();
    }

    /// The candidates of a race: given and random ones, or the survivors of the last one and new ones around them.
    fn sampled(&mut self, iteration: u32, count: usize, given: &[Candidate]) -> Vec<Candidate> {
        let mut random = stream(self.seed, Stream::Sampling, self.state.generation);
        if self.state.elites.is_empty() {
            let mut candidates: Vec<_> = (0..count).map(|_| self.model.first(&mut random)).collect();
            candidates[..given.len()].clone_from_slice(given);
            return candidates;
        }
        let sharpness = f64::from(iteration - 1) / self.iterations(iteration) as f64;
        let elites = self.state.elites.iter();
        let elites: Vec<_> = elites
            .map(|candidate| self.model.sharpened(&candidate.candidate, sharpness))
            .collect();
        let new = count - elites.len();
        self.state.spread *= root(1.0 / new as f64, self.model.genes());
        let spread = self.state.spread;
        let child = |_| {
            let parent = &elites[parent(elites.len(), &mut random)];
            self.model.around(parent, spread, &mut random)
        };
        let children: Vec<_> = (0..new).map(child).collect();
        [elites, children].concat()
    }

    /// The genomes of all candidates.
    fn populate(&mut self) {
        let genomes = self.state.candidates.iter().flat_map(|candidate| &candidate.genome);
        self.population = Population::new(self.model.genes(), genomes.copied().collect());
    }

    /// Takes the scores of a generation.
    fn race(&mut self, fitness: &[f32], ranking: &[u32]) {
        let few = few(self.model.genes());
        let state = &mut self.state;
        state.places.push(places(fitness, ranking));
        state.used += fitness.len() as u64;
        let lives = state.places.len();
        let mut kept = vec![true; fitness.len()];
        if lives >= self.values.first_test as usize {
            kept = friedman::kept(&state.places, self.values.confidence);
        }
        let alive = kept.iter().filter(|kept| **kept).count();
        let limit = state.until.min(self.budget);
        let is_over = lives >= 2 && alive <= few || state.used + alive as u64 > limit;
        if is_over {
            state.elites = elites(state, fitness, &kept, few);
        }
        self.round = Some(Round {
            race: state.iteration,
            candidates: fitness.len() as u32,
            survivors: if is_over { state.elites.len() } else { alive } as u32,
        });
        let mut is_kept = kept.iter().copied();
        state.candidates.retain(|_| is_kept.next().unwrap_or(true));
        for places in &mut state.places {
            let mut is_kept = kept.iter().copied();
            places.retain(|_| is_kept.next().unwrap_or(true));
        }
        state.generation += 1;
        if is_over {
            self.begin(&[]);
        }
    }
}

/// The most candidates that survive a race, and the number of races that the budget is planned for: 2 + log2(genes), rounded down.
fn few(genes: usize) -> usize {
    2 + genes.max(1).ilog2() as usize
}

/// Counts, for each score, how many are better. NaN counts as the worst.
fn places(fitness: &[f32], ranking: &[u32]) -> Vec<u32> {
    let mut places = vec![0; fitness.len()];
    let is_equal = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|index| fitness[index as usize]);
        a == b || a.is_nan() && b.is_nan()
    };
    let mut better = 0;
    for equals in ranking.chunk_by(|&a, &b| is_equal(a, b)) {
        for &index in equals {
            places[index as usize] = better;
        }
        better += equals.len() as u32;
    }
    places
}

/// The best survivors of a race, as many as `few`, by the sums of their ranks.
fn elites(state: &RaceState, fitness: &[f32], kept: &[bool], few: usize) -> Vec<Elite> {
    let sums = friedman::sums(&state.places);
    let mut order: Vec<usize> = (0..fitness.len()).filter(|&index| kept[index]).collect();
    order.sort_by(|&a, &b| sums[a].total_cmp(&sums[b]));
    let elite = |index: usize| Elite {
        candidate: state.candidates[index].clone(),
        generation: state.generation,
        individual: index as u32,
        fitness: fitness[index],
    };
    order.into_iter().take(few).map(elite).collect()
}

/// Draws the place of a parent among elites, which are sorted from the best on: the chance falls linearly with the place.
fn parent(elites: usize, random: &mut impl rand::Rng) -> usize {
    let total = elites * (elites + 1) / 2;
    let mut drawn = super::random::below(total, random);
    for place in 0..elites {
        let weight = elites - place;
        if drawn < weight {
            return place;
        }
        drawn -= weight;
    }
    elites - 1
}

/// The n-th root of a positive number.
fn root(x: f64, n: usize) -> f64 {
    oneiro::exact::exponential(oneiro::exact::logarithm(x) / n as f64)
}

impl Optimizer for Race {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.state.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn round(&self) -> Option<Round> {
        self.round
    }

    fn is_over(&self) -> bool {
        self.state.is_over
    }

    /// The survivors of the last race, without the luckiest's genome: it may have lived in many generations.
    fn finalists<'a>(&'a self, luckiest: &'a Champion, _: &'a [f32], _: &'a [f32]) -> Finalists<'a> {
        let survivors = self.state.elites.iter().map(|elite| Champion {
            generation: elite.generation,
            individual: elite.individual,
            fitness: elite.fitness,
            genome: elite.candidate.genome.clone(),
        });
        Box::new(survivors.filter(|champion| champion.genome != luckiest.genome))
    }

    fn advance(&mut self, fitness: &[f32], ranking: &[u32], _: &[f64]) -> Population {
        let evaluated = self.population.clone();
        self.race(fitness, ranking);
        self.populate();
        evaluated
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        saved::seal(NAME, VERSION, &self.owner, &self.state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let state: RaceState = saved::open(NAME, VERSION, &self.owner, bytes)?;
        let all = state
            .candidates
            .iter()
            .chain(state.elites.iter().map(|candidate| &candidate.candidate));
        let is_whole = all.clone().all(|candidate| self.model.fits(candidate)) && !state.candidates.is_empty();
        let count = state.candidates.len();
        if !is_whole || state.places.iter().any(|places| places.len() != count) {
            return Err(Error::Lengths);
        }
        self.state = state;
        self.populate();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
