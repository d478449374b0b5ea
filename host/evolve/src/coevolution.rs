//! Competitive coevolution: each of two populations is scored by episodes against the other's best of earlier
//! generations (Floreano and Nolfi 1997). Both breed as the genetic algorithm does.
//!
//! A contest's genome is the first population's genes, then the second's. So worlds, batches and records need no notion
//! of two populations. Its fitness is the first one's score, and the second's is the rest of the total.

use crate::error::{Error, Result};
use oneiro::parameter::Allowed::{Any, Number, Text, Whole};
use oneiro::parameter::{Choice, Choices, Parameter, row};
use oneiro::world::Gene;
use rand::Rng;
use serde::Serialize;

use super::genetic::{FROM_MUTANTS, Genetic};
use super::random::{Stream, shuffled, stream};
use super::registry::{Entry, Table};
use super::settings::{Checked, Feature, Need, Ranges, Settings, Shares, Surroundings, breeding, refused};
use super::{Champion, Finalists, Optimizer, Population, ranked, saved};

const NAME: &str = "coevolution";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::Breeds, Feature::TwoPopulations, Feature::Unrecorded],
    start: FROM_MUTANTS,
    check,
    needs,
    ..Entry::new(
        [
            NAME,
            "two populations, bred by the genetic algorithm, that are scored against each other: Floreano and Nolfi 1997",
            "when only an opponent gives a score",
        ],
        |beginning| {
            Box::new(Coevolution::new(
                beginning.settings,
                beginning.seed,
                beginning.genes,
                beginning.init.as_ref(),
            ))
        },
    )
};

/// The opponents of two populations' individuals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    pub kind: OpponentKind,
    /// Of recent ones: of how many generations.
    pub generations: u32,
    /// Episodes of each individual in a generation.
    pub contests: u32,
    /// Name of the first gene of the second population's genomes.
    pub first_gene: String,
    /// The sum of both sides' scores of an episode.
    pub total: f64,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            kind: OpponentKind::Recent,
            generations: 10,
            contests: 10,
            first_gene: String::new(),
            total: 1.0,
        }
    }
}

impl Values {
    /// Genes of the first population's genomes; `None` if the second's have none or all.
    pub fn split(&self, genes: &[Gene]) -> Option<usize> {
        let first = genes.iter().position(|gene| gene.name == self.first_gene);
        first.filter(|first| *first > 0)
    }
}

/// The opponents, among the other population's best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum OpponentKind {
    Recent,
    HallOfFame,
}

impl Choice for OpponentKind {
    const CHOICES: Choices<Self> = &[
        (
            "recent",
            Self::Recent,
            "the best of the last generations, the last first",
        ),
        (
            "hall-of-fame",
            Self::HallOfFame,
            "the best of randomly drawn earlier generations, drawn again in each generation",
        ),
    ];
}

impl Table for Values {
    #[rustfmt::skip]
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
        vec![
            row("evolution.opponents.first_gene", "", Text("the name of a gene"), "",
                "With coevolution: the first gene of the second population's genomes; the genes before it are the first population's.", |values, _| Some(&mut values.as_mut().opponents()?.first_gene)),
            row("evolution.opponents.kind", "", Any, "Floreano and Nolfi 1997",
                "The opponents, among the other population's best.", |values, _| Some(&mut values.as_mut().opponents()?.kind)),
            row("evolution.opponents.generations", "", Whole(1, 1_000_000), "Floreano and Nolfi 1997",
                "Number of last generations whose best are recent opponents; a hall of fame has the best of all generations.", |values, _| Some(&mut values.as_mut().opponents()?.generations)),
            row("evolution.opponents.contests", "", Whole(1, 10_000), "Floreano and Nolfi 1997",
                "Episodes of each individual in a generation, each against another opponent while there are enough.", |values, _| Some(&mut values.as_mut().opponents()?.contests)),
            row("evolution.opponents.total", "", Number(-1e6, 1e6), "Floreano and Nolfi 1997",
                "The sum of both scores of an episode: fitness is the first population's score, and the second scores the rest.", |values, _| Some(&mut values.as_mut().opponents()?.total)),
        ]
    }
}

/// Checks that there are two populations, and what they do not go with.
fn check(settings: &Settings, surroundings: &Surroundings<'_>) -> Checked {
    breeding::check(settings)?;
    let (genes, opponents) = (surroundings.genes, &settings.tables.opponents);
    if opponents.split(genes).is_none() {
        let names: Vec<&str> = genes.iter().skip(1).map(|gene| &*gene.name).collect();
        if names.is_empty() {
            let problem = "is \"coevolution\" with one gene; allowed: at least two genes, one for each population";
            return refused("evolution.kind", problem);
        }
        let (first, names) = (&opponents.first_gene, names.join(", "));
        let problem = format!("is {first:?}; allowed: a gene except the first: {names}");
        return refused("evolution.opponents.first_gene", problem);
    }
    if surroundings.has_robot {
        let problem = "is given; allowed: none with coevolution, whose two robots share a world";
        return refused("reality.robot", problem);
    }
    Ok(())
}

fn needs(settings: &Settings) -> Vec<Need> {
    vec![Need::new(
        &["evolution.opponents.generations"],
        settings.tables.opponents.kind == OpponentKind::Recent,
        "with evolution.opponents.kind = \"recent\"",
        &["evolution.opponents.kind"],
    )]
}

/// Both populations at one generation.
#[derive(Clone, Debug)]
pub struct Coevolution {
    owner: saved::Owner,
    seed: u64,
    opponents: Values,
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
    /// Starts from random genes, or from given genomes, which are a first and a second individual each.
    fn new(settings: &Settings, seed: u64, genes: &[Gene], init: Option<&Population>) -> Self {
        let ranges: Ranges = genes.iter().map(|gene| gene.range).collect();
        let split = settings.tables.opponents.split(genes).unwrap_or(1);
        let side = |from: usize, to: usize, seed: u64| {
            let mut of_side = settings.clone();
            let shares = &settings.initial_shares.0;
            of_side.initial_shares = Shares(shares.get(from..to).unwrap_or_default().to_vec());
            let init = init.map(|all| {
                let values = all.genomes().flat_map(|genome| &genome[from..to]).copied().collect();
                Population::new(to - from, values)
            });
            Side {
                evolution: Genetic::new(&of_side, seed, ranges[from..to].to_vec(), init),
                hall: Vec::new(),
                scores: Scores::default(),
            }
        };
        let second = stream(seed, Stream::SecondPopulation, 0).next_u64();
        let mut coevolution = Self {
            owner: saved::Owner::new(settings, seed, &ranges),
            seed,
            opponents: settings.tables.opponents.clone(),
            sides: [side(0, split, seed), side(split, genes.len(), second)],
            contests: Population::new(genes.len(), Vec::new()),
        };
        coevolution.meet();
        coevolution
    }

    /// Scores of both populations in the generation that was evaluated last.
    pub fn scores(&self) -> [&Scores; 2] {
        [&self.sides[0].scores, &self.sides[1].scores]
    }

    /// The best of both populations of each generation so far, as pairs.
    pub fn hall(&self) -> Population {
        let [first, second] = [0, 1].map(|side| self.best(side));
        let values = first.zip(second).flat_map(|(first, second)| [first, second].concat());
        Population::new(self.contests.genes(), values.collect())
    }

    /// The best of both populations in the last evaluated generation, as a pair numbered after its other episodes; with
    /// the first one's score.
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

    /// The generations whose best are this generation's opponents, one for each episode of an individual.
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

    /// Makes the episodes of this generation: those of the first population's individuals, then those of the second's.
    /// In generation 0, which has no earlier ones, the opponents are the first individuals of the other population.
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
        let ours = first.flat_map(|individual| opponents[1].iter().map(move |other| [individual, other]));
        let theirs = second.flat_map(|individual| opponents[0].iter().map(move |other| [other, individual]));
        let values = ours.chain(theirs).flat_map(|pair| pair.concat()).collect();
        self.contests = Population::new(self.contests.genes(), values);
    }
}

/// An individual's score: the mean of its episodes; NaN if one of them is.
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
        let scored = |lives: &[f32], of_side: &dyn Fn(f64) -> f64| -> Vec<f32> {
            let contests = lives.chunks_exact(count);
            contests
                .map(|lives| score(lives.iter().map(|&life| of_side(life.into())), count))
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

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
        for side in &mut self.sides {
            side.evolution.set_generations(generations);
        }
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
                return Err(Error::Lengths);
            }
            side.hall = hall;
        }
        if sides[0].evolution.generation() != sides[1].evolution.generation() {
            return Err(Error::Lengths);
        }
        self.sides = sides;
        self.meet();
        Ok(())
    }
}
