//! Differential evolution (Storn and Price, "Differential evolution - a simple and efficient heuristic for global optimization over
//! continuous spaces", Journal of Global Optimization 11, 1997): each member of the population competes with a trial vector, which
//! has some of its genes and some of a third member to which the weighted difference of two others is added. As in Price, Storn and
//! Lampinen, "Differential Evolution" (2005), the trial vector wins if both are equal. Members keep the score that they won by.

use crate::error::{Error, Result};
use oneiro::parameter::Allowed::{Any, Number};
use oneiro::parameter::{Choice, Choices, Parameter, row};
use rand::distr::Distribution;
use serde::{Deserialize, Serialize};

use super::random::{Chance, Stream, below, stream};
use super::registry::{Beginning, Entry, Table};
use super::settings::{GivenGenomes, Settings, Space, refused};
use super::{Champion, Finalists, Optimizer, Population, by_fitness, ranked, saved};

const NAME: &str = "differential-evolution";
const VERSION: u32 = 1;

/// A member, and three others.
const LEAST_POPULATION: u32 = 4;

pub(crate) const ENTRY: Entry = Entry {
    // Its steps are differences: copies would have none.
    start: GivenGenomes::First("random"),
    check: |settings, _| match settings.population {
        LEAST_POPULATION.. => Ok(()),
        few => refused(
            "evolution.population",
            format_args!("is {few}; allowed: {LEAST_POPULATION} or more"),
        ),
    },
    ..Entry::new(
        [
            NAME,
            "differential evolution, whose steps are differences between individuals: Storn and Price 1997",
            "numeric genes with hardly noisy scores; it has few settings",
        ],
        |beginning| Box::new(DifferentialEvolution::new(beginning)),
    )
};

/// Values of differential evolution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    strategy: Strategy,
    /// The factor F of differences.
    weight: f64,
    /// The chance CR of each gene to be the mutant's.
    crossover_rate: f64,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            strategy: Strategy::Rand,
            weight: 0.5,
            crossover_rate: 0.9,
        }
    }
}

impl Table for Values {
    #[rustfmt::skip]
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
        const SOURCE: &str = "Storn and Price 1997";
        vec![
            row("evolution.differential.strategy", "", Any, SOURCE,
                "The individual that the difference is added to.", |values, _| Some(&mut values.as_mut().differential()?.strategy)),
            row("evolution.differential.weight", "", Number(0.0, 2.0), SOURCE,
                "The factor F of differences.", |values, _| Some(&mut values.as_mut().differential()?.weight)),
            row("evolution.differential.crossover_rate", "", Number(0.0, 1.0), SOURCE,
                "The probability CR that a gene of a trial vector changes; at least one gene does.", |values, _| Some(&mut values.as_mut().differential()?.crossover_rate)),
        ]
    }
}

/// The individual that differences are added to, by the authors' names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
enum Strategy {
    Rand,
    Best,
}

impl Choice for Strategy {
    const CHOICES: Choices<Self> = &[
        ("rand/1/bin", Self::Rand, "a random member"),
        ("best/1/bin", Self::Best, "the best member"),
    ];
}

/// The algorithm at one generation.
#[derive(Clone, Debug)]
struct DifferentialEvolution {
    owner: saved::Owner,
    values: Values,
    seed: u64,
    space: Space,
    members: Members,
    population: Population,
}

/// The members, one after the other. Those of generation 0 have no scores yet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Members {
    /// The generation that is evaluated next.
    generation: u32,
    genes: Vec<f32>,
    fitness: Vec<f32>,
    /// The generation of each.
    generations: Vec<u32>,
}

impl DifferentialEvolution {
    /// Begins at random genomes, the first of which may be given.
    fn new(beginning: Beginning<'_>) -> Self {
        let ranges = beginning.ranges();
        let Beginning {
            settings, seed, init, ..
        } = beginning;
        let space = Space::new(settings, &ranges);
        let mut random = stream(seed, Stream::InitialGenes, 0);
        let mut genes = space.drawn(settings.population, &mut random);
        if let Some(given) = init {
            genes[..given.values().len()].copy_from_slice(given.values());
        }
        let population = Population::new(space.len(), genes);
        let members = Members {
            generation: 0,
            genes: population.values().to_vec(),
            fitness: Vec::new(),
            generations: Vec::new(),
        };
        Self {
            owner: saved::Owner::new(settings, seed, &ranges),
            values: settings.tables.differential.clone(),
            seed,
            space,
            members,
            population,
        }
    }

    /// The genomes of a generation: the first members, or trial vectors, one for each member.
    fn asked(&self) -> Population {
        let Members {
            generation,
            ref genes,
            ref fitness,
            ..
        } = self.members;
        let members = Population::new(self.space.len(), genes.clone());
        if generation == 0 {
            return members;
        }
        let mut picks = stream(self.seed, Stream::Selection, generation);
        let mut crossing = stream(self.seed, Stream::Crossover, generation);
        let (changed, best) = (Chance(self.values.crossover_rate), ranked(fitness)[0] as usize);
        let mut trials = Vec::with_capacity(genes.len());
        for (number, member) in members.genomes().enumerate() {
            let [random, plus, minus] = others(number, members.len(), |count| below(count, &mut picks));
            let base = match self.values.strategy {
                Strategy::Rand => random,
                Strategy::Best => best,
            };
            let certain = below(self.space.len(), &mut crossing);
            for (gene, &value) in member.iter().enumerate() {
                let is_changed = changed.sample(&mut crossing) || gene == certain;
                let [base, plus, minus] = [base, plus, minus].map(|other| f64::from(members.genome(other)[gene]));
                let mutant = self.space.kept(gene, base + self.values.weight * (plus - minus));
                trials.push(if is_changed { mutant } else { value });
            }
        }
        Population::new(self.space.len(), trials)
    }
}

/// Three different members besides one, of as many as there are. `below` draws a number below another.
fn others(member: usize, count: usize, mut below: impl FnMut(usize) -> usize) -> [usize; 3] {
    let mut taken = vec![member];
    [(); 3].map(|()| {
        // The number among those that are not taken.
        let free = below(count - taken.len());
        let picked = taken
            .iter()
            .fold(free, |place, &taken| place + usize::from(place >= taken));
        taken.push(picked);
        taken.sort_unstable();
        picked
    })
}

impl Optimizer for DifferentialEvolution {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.members.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    /// The best members.
    fn finalists<'a>(&'a self, luckiest: &'a Champion, _: &'a [f32], _: &'a [f32]) -> Finalists<'a> {
        let genes = self.space.len();
        let members = ranked(&self.members.fitness).into_iter().map(move |individual| {
            let number = individual as usize;
            Champion {
                generation: self.members.generations[number],
                individual,
                fitness: self.members.fitness[number],
                genome: self.members.genes[number * genes..][..genes].to_vec(),
            }
        });
        Box::new(members.filter(|champion| !champion.is_individual(luckiest)))
    }

    fn advance(&mut self, fitness: &[f32], _: &[u32], _: &[f64]) -> Population {
        let (genes, members) = (self.space.len(), &mut self.members);
        if members.generation == 0 {
            members.fitness = fitness.to_vec();
            members.generations = vec![0; fitness.len()];
        } else {
            for (number, (&score, trial)) in fitness.iter().zip(self.population.genomes()).enumerate() {
                if by_fitness(score, members.fitness[number]).is_le() {
                    members.fitness[number] = score;
                    members.generations[number] = members.generation;
                    members.genes[number * genes..][..genes].copy_from_slice(trial);
                }
            }
        }
        members.generation += 1;
        let next = self.asked();
        std::mem::replace(&mut self.population, next)
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        saved::seal(NAME, VERSION, &self.owner, &self.members)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let members: Members = saved::open(NAME, VERSION, &self.owner, bytes)?;
        let scored = if members.generation == 0 {
            0
        } else {
            self.population.len()
        };
        let lengths = [members.genes.len(), members.fitness.len(), members.generations.len()];
        if lengths != [self.population.values().len(), scored, scored] {
            return Err(Error::Lengths);
        }
        self.members = members;
        self.population = self.asked();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Kind;
    use super::super::settings::Surroundings;
    use super::super::tests::{fitness, number};
    use super::*;

    const GENES: usize = 6;

    fn settings(population: u32, change: impl FnOnce(&mut Values)) -> Settings {
        let mut settings = Settings {
            kind: Kind::DifferentialEvolution,
            population,
            ..Settings::default()
        };
        change(&mut settings.tables.differential);
        settings
    }

    fn evolution(settings: &Settings, seed: u64) -> DifferentialEvolution {
        DifferentialEvolution::new(Beginning {
            settings,
            seed,
            genes: &vec![number(None); GENES],
            init: None,
        })
    }

    /// Each gene of a trial vector is its member's, or that of a base and two others: the same three in all genes.
    #[test]
    fn trial_vectors_are_those_of_the_formula() {
        let scores = [3.0, f32::NAN, 7.0, 1.0, 7.0];
        for (strategy, rate) in [
            (Strategy::Rand, 0.5),
            (Strategy::Best, 0.5),
            (Strategy::Rand, 1.0),
            (Strategy::Rand, 0.0),
        ] {
            let settings = settings(5, |values| {
                (values.strategy, values.crossover_rate, values.weight) = (strategy, rate, 0.7);
            });
            let mut evolution_of_two = evolution(&settings, 2);
            let members = evolution_of_two.tell(scores.to_vec(), &[]).unwrap().population;
            let mut changed = Vec::new();
            for (number, trial) in evolution_of_two.ask().genomes().enumerate() {
                let member = members.genome(number);
                let is_made_of = |[base, plus, minus]: [usize; 3]| {
                    (0..GENES).all(|gene| {
                        let of = |other: usize| f64::from(members.genome(other)[gene]);
                        let mutant = (of(base) + 0.7 * (of(plus) - of(minus))) as f32;
                        trial[gene] == member[gene] || trial[gene] == mutant
                    })
                };
                let all = (0..125).map(|index| [index / 25, index / 5 % 5, index % 5]);
                // The best of equals is the first.
                let is_allowed = |[base, plus, minus]: &[usize; 3]| {
                    let is_base = match strategy {
                        Strategy::Rand => ![number, *plus, *minus].contains(base),
                        Strategy::Best => *base == 2,
                    };
                    is_base && plus != minus && ![*plus, *minus].contains(&number)
                };
                assert!(all.filter(is_allowed).any(is_made_of), "{strategy:?}, {number}");
                changed.push((0..GENES).filter(|&gene| trial[gene] != member[gene]).count());
            }
            match rate {
                0.0 => assert_eq!(changed, [1; 5]),
                1.0 => assert_eq!(changed, [GENES; 5]),
                _ => assert!(
                    changed.iter().all(|&count| count > 0) && changed.iter().any(|&count| count < GENES),
                    "{changed:?}"
                ),
            }
        }
    }

    /// The draws of all others, each as often: with 4 members the three others in all orders.
    #[test]
    fn others_are_different() {
        for (member, count) in [(0, 4), (2, 4), (3, 4), (2, 6)] {
            let mut all = Vec::new();
            for draws in 0..(count - 1) * (count - 2) * (count - 3) {
                let mut rest = draws;
                let picked = others(member, count, |below| {
                    let drawn = rest % below;
                    rest /= below;
                    drawn
                });
                assert!(
                    picked.iter().all(|&other| other != member && other < count),
                    "{picked:?}"
                );
                all.push(picked);
            }
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), (count - 1) * (count - 2) * (count - 3));
            assert!(all.iter().all(|[a, b, c]| a != b && b != c && c != a));
        }
    }

    /// The worse stay out, equals come in, and NaN is worse than all numbers. Finalists are the best members, where they were made.
    #[test]
    fn trial_vectors_replace_members_that_are_not_better() {
        let mut differential = evolution(&settings(4, |_| ()), 1);
        let first = differential
            .tell(vec![5.0, 4.0, f32::NAN, f32::NAN], &[])
            .unwrap()
            .population;
        let trials = differential
            .tell(vec![4.9, 4.0, f32::NAN, -9.0], &[])
            .unwrap()
            .population;
        let expected = [first.genome(0), trials.genome(1), trials.genome(2), trials.genome(3)].concat();
        assert_eq!(differential.members.genes, expected);
        assert_eq!(differential.members.generations, [0, 1, 1, 1]);
        differential.tell(vec![f32::NAN; 4], &[]).unwrap();
        assert_eq!(differential.members.generations, [0, 1, 2, 1]);
        let luckiest = Champion {
            generation: 0,
            individual: 0,
            fitness: 5.0,
            genome: first.genome(0).to_vec(),
        };
        let finalists: Vec<_> = differential.finalists(&luckiest, &[], &[]).collect();
        let places: Vec<_> = finalists
            .iter()
            .map(|champion| (champion.generation, champion.individual))
            .collect();
        assert_eq!(places, [(1, 1), (1, 3), (2, 2)]);
        assert_eq!(finalists[0].genome, trials.genome(1));
    }

    /// The defaults find the optimum of a sphere, which lies off the middle, to the last places.
    #[test]
    fn it_finds_the_optimum_of_a_sphere() {
        let best = |strategy| {
            let mut differential = evolution(&settings(30, |values| values.strategy = strategy), 5);
            (0..150).fold(f32::MIN, |best, _| {
                let scores = fitness(differential.ask());
                let generation = differential.tell(scores, &[]).unwrap();
                best.max(generation.fitness[generation.ranking[0] as usize])
            })
        };
        for strategy in [Strategy::Rand, Strategy::Best] {
            assert!(best(strategy) > -1e-6, "{strategy:?}: {}", best(strategy));
        }
    }

    /// Evaluations up to the first value of 1e-9: the median of 21 seeds.
    fn median(values: &Values, factor: fn(i32) -> f64) -> f64 {
        let settings = Settings {
            initial: [-1.0, 3.0],
            ..settings(50, |table| *table = values.clone())
        };
        let evaluations = |seed| {
            let mut differential = DifferentialEvolution::new(Beginning {
                settings: &settings,
                seed,
                genes: &vec![number(None); 10],
                init: None,
            });
            for generation in 0..2000 {
                let square = |(gene, at): (&f32, i32)| factor(at) * f64::from(*gene) * f64::from(*gene);
                let genomes = differential.ask().genomes();
                let found: Vec<f64> = genomes.map(|genes| genes.iter().zip(0..).map(square).sum()).collect();
                if let Some(first) = found.iter().position(|value| *value <= 1e-9) {
                    return 50 * generation + first as u32 + 1;
                }
                differential
                    .tell(found.iter().map(|value| -*value as f32).collect(), &[])
                    .unwrap();
            }
            panic!("{values:?}, seed {seed}: not found")
        };
        let mut counts: Vec<u32> = (1..=21).map(evaluations).collect();
        counts.sort_unstable();
        f64::from(counts[10])
    }

    /// Medians are within 5 % of those of `scipy`'s differential evolution, which `tests/optimisers.sh` repeats.
    #[test]
    fn it_needs_as_many_evaluations_as_scipy() {
        let mut worst = 0.0_f64;
        for line in include_str!("differential_evolution/evaluations.txt").lines() {
            let [function, strategy, weight, expected] = line.split(' ').collect::<Vec<_>>()[..] else {
                panic!("{line}")
            };
            let found = Strategy::CHOICES.iter().find(|(word, ..)| *word == strategy);
            let values = Values {
                strategy: found.unwrap().1,
                weight: weight.parse().unwrap(),
                ..Values::default()
            };
            let factor = if function == "sphere" {
                |_| 1.0
            } else {
                |at| 1e6_f64.powf(f64::from(at) / 9.0)
            };
            let expected: f64 = expected.parse().unwrap();
            let apart = |values: &Values| {
                let found = median(values, factor);
                println!("{line}: {found}");
                (found / expected - 1.0).abs()
            };
            worst = worst.max(apart(&values));
            let control = Values {
                weight: values.weight + 0.05,
                ..values
            };
            assert!(apart(&control) > 0.05, "CONTROL: {line}");
        }
        assert!(worst < 0.05, "{worst}");
    }

    #[test]
    fn genes_stay_within_their_bounds() {
        let settings = Settings {
            limits: Some([-1.0, 0.25]),
            ..settings(10, |values| values.weight = 2.0)
        };
        let mut differential = evolution(&settings, 3);
        let mut at_bounds = 0;
        for _ in 0..20 {
            let scores = fitness(differential.ask());
            differential.tell(scores, &[]).unwrap();
            assert!(
                differential
                    .ask()
                    .values()
                    .iter()
                    .all(|gene| (-1.0..=0.25).contains(gene))
            );
            at_bounds += differential.ask().values().iter().filter(|gene| **gene == 0.25).count();
        }
        assert!(at_bounds > 20, "{at_bounds}");
    }

    #[test]
    fn too_few_individuals_are_refused() {
        let surroundings = Surroundings {
            genes: &[],
            records_individuals: true,
            has_robot: false,
        };
        let check = |population| settings(population, |_| ()).check(&surroundings);
        assert_eq!(
            check(3).unwrap_err().to_string(),
            "evolution.population: is 3; allowed: 4 or more"
        );
        check(4).unwrap();
    }

    #[test]
    fn a_state_of_other_lengths_is_refused() {
        let settings = settings(4, |_| ());
        let mut differential = evolution(&settings, 1);
        differential.members.fitness.push(1.0);
        assert!(evolution(&settings, 1).restore(&differential.save()).is_err());
    }
}
