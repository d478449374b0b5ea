//! Competitive coevolution: two populations, of which each is scored by contests with the other's best of earlier generations
//! (Floreano and Nolfi 1997). Both breed as the genetic algorithm does.
//!
//! A contest is a genome: the first population's genes, then the second's. So worlds, batches and records need not know that there
//! are two populations. Its fitness is the first one's score, and the second's is what is left of the total.

use oneiro::world::Gene;
use oneiro_base::exit::Result;
use rand::Rng;

use super::genetic::Genetic;
use super::random::{Stream, shuffled, stream};
use super::settings::{OpponentKind, Opponents, Ranges, Settings, Shares};
use super::{Champion, Finalists, Optimizer, Population, ranked, saved};

const NAME: &str = "coevolution";
const VERSION: u32 = 1;

/// Both populations at one generation.
#[derive(Clone, Debug)]
pub struct Coevolution {
    owner: blake3::Hash,
    seed: u64,
    opponents: Opponents,
    sides: [Side; 2],
    contests: Population,
}

/// One of the populations.
#[derive(Clone, Debug)]
struct Side {
    evolution: Genetic,
    /// The best of each generation, one after the other.
    hall: Vec<f32>,
    /// Of the generation that was evaluated last.
    scores: Scores,
}

/// The scores of a population's individuals, and their indices from the best to the worst.
#[derive(Clone, Debug, Default)]
pub struct Scores {
    pub fitness: Vec<f32>,
    pub ranking: Vec<u32>,
}

impl Coevolution {
    /// Starts from random genes, or from those given, whose genomes are a first and a second individual each.
    pub(super) fn new(settings: &Settings, seed: u64, genes: &[Gene], init: Option<&Population>) -> Self {
        let ranges: Ranges = genes.iter().map(|gene| gene.range).collect();
        let split = settings.opponents.split(genes).unwrap_or(1);
        let side = |from: usize, to: usize, seed: u64| {
            let mut own = settings.clone();
            let shares = &settings.initial_shares.0;
            own.initial_shares = Shares(shares.get(from..to).unwrap_or_default().to_vec());
            let init = init.map(|all| {
                let values = all.genomes().flat_map(|genome| &genome[from..to]).copied().collect();
                Population::new(to - from, values)
            });
            Side {
                evolution: Genetic::new(&own, seed, ranges[from..to].to_vec(), init),
                hall: Vec::new(),
                scores: Scores::default(),
            }
        };
        let second = stream(seed, Stream::SecondPopulation, 0).next_u64();
        let mut own = Self {
            owner: saved::owner(settings, seed, &ranges),
            seed,
            opponents: settings.opponents.clone(),
            sides: [side(0, split, seed), side(split, genes.len(), second)],
            contests: Population::new(genes.len(), Vec::new()),
        };
        own.meet();
        own
    }

    /// Scores of both populations in the generation that was evaluated last.
    pub fn scores(&self) -> [&Scores; 2] {
        [&self.sides[0].scores, &self.sides[1].scores]
    }

    /// The best of both populations of each generation so far, as contests.
    pub fn hall(&self) -> Population {
        let [first, second] = [0, 1].map(|side| self.best(side));
        let values = first.zip(second).flat_map(|(first, second)| [first, second].concat());
        Population::new(self.contests.genes(), values.collect())
    }

    /// The best of both populations in the generation that was evaluated last, as a contest that comes after all others of it; with
    /// the score of the first one.
    pub(super) fn pair(&self) -> Champion {
        let hall = self.hall();
        let Scores { fitness, ranking } = &self.sides[0].scores;
        Champion {
            generation: self.generation() - 1,
            individual: self.contests.len() as u32,
            fitness: fitness[ranking[0] as usize],
            genome: hall.genome(hall.len() - 1).to_vec(),
        }
    }

    /// The best of each generation of one population.
    fn best(&self, side: usize) -> impl Iterator<Item = &[f32]> {
        let genes = self.sides[side].evolution.ask().genes();
        self.sides[side].hall.chunks_exact(genes)
    }

    /// The generations whose best are the opponents of this generation, one for each contest of an individual.
    fn met(&self) -> Vec<usize> {
        let (generation, contests) = (self.generation() as usize, self.opponents.contests as usize);
        let (first, order) = match self.opponents.kind {
            OpponentKind::Recent => {
                let last = generation.min(self.opponents.generations as usize);
                (generation - last, (0..last).rev().collect())
            }
            OpponentKind::HallOfFame => {
                let mut random = stream(self.seed, Stream::Opponents, self.generation());
                (0, shuffled(generation, &mut random))
            }
        };
        order
            .iter()
            .cycle()
            .take(contests)
            .map(|place: &usize| first + place)
            .collect()
    }

    /// Makes the contests of this generation: those of the first population's individuals, then those of the second's. In generation
    /// 0, which has no earlier ones, the opponents are the first individuals of the other population.
    fn meet(&mut self) {
        let met = self.met();
        let count = self.opponents.contests as usize;
        let opponents = [0, 1].map(|side| -> Vec<&[f32]> {
            let (hall, first): (Vec<&[f32]>, _) = (self.best(side).collect(), self.sides[side].evolution.ask());
            if met.is_empty() {
                (0..count).map(|contest| first.genome(contest % first.len())).collect()
            } else {
                met.iter().map(|&generation| hall[generation]).collect()
            }
        });
        let [first, second] = [0, 1].map(|side| self.sides[side].evolution.ask().genomes());
        let ours = first.flat_map(|own| opponents[1].iter().map(move |other| [own, other]));
        let theirs = second.flat_map(|own| opponents[0].iter().map(move |other| [other, own]));
        let values = ours.chain(theirs).flat_map(|pair| pair.concat()).collect();
        self.contests = Population::new(self.contests.genes(), values);
    }
}

/// An individual's score: the mean of its contests; NaN if one of them is.
fn score(contests: impl Iterator<Item = f64>, count: usize) -> f32 {
    (contests.sum::<f64>() / count as f64) as f32
}

impl Optimizer for Coevolution {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.sides[0].evolution.generation()
    }

    fn ask(&self) -> &Population {
        &self.contests
    }

    fn coevolution(&self) -> Option<&Coevolution> {
        Some(self)
    }

    /// Scores of different generations can't be compared, since their opponents differ: there are no others than the last pair.
    fn finalists<'a>(&'a self, _: &'a Champion, _: &'a [f32], _: &'a [f32]) -> Finalists<'a> {
        Box::new(std::iter::empty())
    }

    fn advance(&mut self, fitness: &[f32], _: &[u32], _: &[f64]) -> Population {
        let (count, total) = (self.opponents.contests as usize, self.opponents.total);
        let (first, second) = fitness.split_at(fitness.len() / 2);
        let scored = |lives: &[f32], own: &dyn Fn(f64) -> f64| -> Vec<f32> {
            let contests = lives.chunks_exact(count);
            contests
                .map(|lives| score(lives.iter().map(|&life| own(life.into())), count))
                .collect()
        };
        let scores = [scored(first, &|life| life), scored(second, &|life| total - life)];
        for (side, fitness) in self.sides.iter_mut().zip(scores) {
            let ranking = ranked(&fitness);
            let evaluated = side.evolution.advance(&fitness, &ranking, &[]);
            side.hall.extend_from_slice(evaluated.genome(ranking[0] as usize));
            side.scores = Scores { fitness, ranking };
        }
        let evaluated = self.contests.clone();
        self.meet();
        evaluated
    }

    fn save(&self) -> Vec<u8> {
        let state = [0, 1].map(|side| (self.sides[side].evolution.save(), &self.sides[side].hall));
        saved::seal(NAME, VERSION, &self.owner, &state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let state: [(Vec<u8>, Vec<f32>); 2] = saved::open(NAME, VERSION, &self.owner, bytes)?;
        let mut sides = self.sides.clone();
        for (side, (evolution, hall)) in sides.iter_mut().zip(state) {
            side.evolution.restore(&evolution)?;
            let generations = side.evolution.generation() as usize;
            if hall.len() != generations * side.evolution.ask().genes() {
                return Err(saved::corrupt());
            }
            side.hall = hall;
        }
        if sides[0].evolution.generation() != sides[1].evolution.generation() {
            return Err(saved::corrupt());
        }
        self.sides = sides;
        self.meet();
        Ok(())
    }
}
