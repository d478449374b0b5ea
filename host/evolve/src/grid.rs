//! Exhaustive search: every combination of evenly spaced genes once, as Gauci et al. 2014 searched for a controller of four numbers.

use crate::error::{Error, Result};
use oneiro::parameter::Allowed::Whole;
use oneiro::parameter::{Parameter, row};
use serde::{Deserialize, Serialize};

use super::registry::{Entry, Table};
use super::settings::{Checked, Feature, Given, GivenGenomes, Ranges, Settings, Space, Surroundings, refused};
use super::{Champion, Finalists, Optimizer, Population, by_fitness, saved};

const NAME: &str = "grid";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::SetsFirstGenes, Feature::SetsGenerations, Feature::OneDraw],
    start: GivenGenomes::None("all genomes are those of the grid"),
    population: "the combinations of the last genes, at most 10,000",
    complete,
    check,
    spend,
    ..Entry::new(
        [
            NAME,
            "every combination of evenly spaced genes once: an exhaustive search",
            "up to about five genes: a map of the whole landscape and its best place",
        ],
        |beginning| Box::new(Grid::new(beginning.settings, beginning.seed, &beginning.ranges())),
    )
};

/// The most values of a gene.
const MOST_LEVELS: u32 = 10_000;

/// Values of an exhaustive search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    /// Values of each gene.
    pub levels: u32,
}

impl Default for Values {
    fn default() -> Self {
        Self { levels: 11 }
    }
}

impl Values {
    /// Combinations of the values of all genes.
    fn combinations(&self, genes: usize) -> u64 {
        u64::from(self.levels).saturating_pow(u32::try_from(genes).unwrap_or(u32::MAX))
    }

    /// A generation: all combinations of the last genes, as many as make up to 10,000 individuals.
    fn default_population(&self, genes: usize) -> u32 {
        let powers = (1..=genes).map(|genes| self.combinations(genes));
        let largest = powers.take_while(|&count| count <= 10_000).last();
        largest.map_or(self.levels, |count| count as u32)
    }
}

impl Table for Values {
    #[rustfmt::skip]
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
        vec![
            row("evolution.grid.levels", "", Whole(2, MOST_LEVELS.into()), "ours",
                "Values of each gene, evenly spaced from one end of its initial range to the other.", |values, _| Some(&mut values.as_mut().grid()?.levels)),
        ]
    }
}

fn complete(settings: &mut Settings, given: Given) {
    let grid = &settings.tables.grid;
    if !given.has_population {
        settings.population = grid.default_population(given.genes);
    }
    let generations = grid.combinations(given.genes) / u64::from(settings.population);
    settings.generations = u32::try_from(generations).unwrap_or(u32::MAX);
}

/// Takes as many levels as fit, at least two, if they are not given.
fn spend(settings: &mut Settings, given: Given, is_given: &dyn Fn(&str) -> bool, left: &dyn Fn(&Settings) -> u64) {
    if is_given("evolution.grid.levels") {
        return;
    }
    let with = |levels: u32| {
        let mut own = settings.clone();
        own.tables.grid.levels = levels;
        complete(&mut own, given);
        own
    };
    let fits = |own: &Settings| own.tables.grid.combinations(given.genes) <= left(own);
    let largest = (3..=MOST_LEVELS).map(with).take_while(fits).last();
    *settings = largest.unwrap_or_else(|| with(2));
}

/// Checks that a grid is not too large, and that generations are equal parts of it.
fn check(settings: &Settings, surroundings: &Surroundings<'_>) -> Checked {
    const MOST: u64 = 1_000_000_000;
    let (genes, grid) = (surroundings.genes.len(), &settings.tables.grid);
    let combinations = grid.combinations(genes);
    if combinations > MOST {
        let levels = grid.levels;
        let problem = format!("is {levels} for {genes} genes; allowed: up to {MOST} combinations");
        return refused("evolution.grid.levels", problem);
    }
    let population = settings.population;
    if combinations % u64::from(population) != 0 || combinations / u64::from(population) > 1_000_000 {
        let problem = format!(
            "is {population}; allowed: a divisor of the grid's {combinations} combinations, at least a millionth of them"
        );
        return refused("evolution.population", problem);
    }
    Ok(())
}

/// The search at one generation. The last gene varies fastest.
#[derive(Clone, Debug)]
struct Grid {
    owner: saved::Owner,
    size: u32,
    levels: u32,
    space: Space,
    state: GridState,
    population: Population,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct GridState {
    generation: u32,
    /// The best so far, as many as a generation has individuals: number on the grid and fitness, the best first.
    best: Vec<(u64, f32)>,
}

impl Grid {
    fn new(settings: &Settings, seed: u64, ranges: &Ranges) -> Self {
        let space = Space::new(settings, ranges);
        let mut grid = Self {
            owner: saved::Owner::new(settings, seed, ranges),
            size: settings.population,
            levels: settings.tables.grid.levels,
            population: Population::new(space.len(), Vec::new()),
            space,
            state: GridState {
                generation: 0,
                best: Vec::new(),
            },
        };
        grid.populate();
        grid
    }

    /// The genome with a number on the grid.
    fn genome(&self, number: u64) -> impl Iterator<Item = f32> {
        let levels = u64::from(self.levels);
        (0..self.space.len()).map(move |gene| {
            let faster = (self.space.len() - 1 - gene) as u32;
            let level = number / levels.pow(faster) % levels;
            // From -1 to 1, and exactly 0 in the middle.
            let at = (2.0 * level as f64 - (levels - 1) as f64) / (levels - 1) as f64;
            self.space.gene(gene, at)
        })
    }

    /// The number on the grid of the first individual of this generation.
    fn first(&self) -> u64 {
        u64::from(self.state.generation) * u64::from(self.size)
    }

    fn populate(&mut self) {
        let numbers = self.first()..self.first() + u64::from(self.size);
        let genomes = numbers.flat_map(|number| self.genome(number)).collect();
        self.population = Population::new(self.space.len(), genomes);
    }
}

impl Optimizer for Grid {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.state.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    /// The best of the whole grid.
    fn finalists<'a>(&'a self, luckiest: &'a Champion, _: &'a [f32], _: &'a [f32]) -> Finalists<'a> {
        let size = u64::from(self.size);
        let best = self.state.best.iter().map(move |&(number, fitness)| Champion {
            generation: (number / size) as u32,
            individual: (number % size) as u32,
            fitness,
            genome: self.genome(number).collect(),
        });
        Box::new(best.filter(|champion| !champion.is_individual(luckiest)))
    }

    fn advance(&mut self, fitness: &[f32], _: &[u32], _: &[f64]) -> Population {
        let first = self.first();
        let state = &mut self.state;
        // NaN counts as the worst.
        let scores = fitness
            .iter()
            .map(|score| if score.is_nan() { f32::NEG_INFINITY } else { *score });
        state.best.extend((first..).zip(scores));
        // Stable, so that of equals the lower number is first.
        state.best.sort_by(|a, b| by_fitness(a.1, b.1));
        state.best.truncate(self.size as usize);
        state.generation += 1;
        let evaluated = self.population.clone();
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
        let state: GridState = saved::open(NAME, VERSION, &self.owner, bytes)?;
        let told = u64::from(state.generation) * u64::from(self.size);
        let count = told.min(self.size.into()) as usize;
        if state.best.len() != count || state.best.iter().any(|&(number, _)| number >= told) {
            return Err(Error::Lengths);
        }
        self.state = state;
        self.populate();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 3 levels of 2 genes, in 3 generations.
    fn grid() -> Grid {
        let mut settings = Settings {
            kind: super::super::settings::Kind::Grid,
            initial: [-2.0, 1.0],
            ..Settings::default()
        };
        settings.tables.grid.levels = 3;
        settings.complete(2, 1, false);
        assert_eq!((settings.population, settings.generations), (9, 1));
        settings.population = 3;
        settings.complete(2, 1, true);
        assert_eq!(settings.generations, 3);
        Grid::new(&settings, 1, &vec![None, Some([0.0, 10.0])])
    }

    #[test]
    fn each_combination_lives_once_and_the_best_of_all_are_finalists() {
        let mut tested = grid();
        let fitness = [[1.0, f32::NAN, 4.0], [4.0, 9.0, 0.0], [4.0, -1.0, 8.0]];
        let mut genomes = Vec::new();
        for scores in fitness {
            genomes.extend(tested.ask().genomes().map(<[f32]>::to_vec));
            let mut resumed = grid();
            resumed.restore(&tested.save()).unwrap();
            assert_eq!(resumed.ask(), tested.ask());
            tested.tell(scores.into(), &[]).unwrap();
        }
        let levels = [-2.0, -0.5, 1.0].map(|a| [0.0, 5.0, 10.0].map(|b| vec![a, b]));
        assert_eq!(genomes, levels.concat());
        let luckiest = Champion {
            generation: 1,
            individual: 1,
            fitness: 9.0,
            genome: vec![-0.5, 5.0],
        };
        let finalists: Vec<_> = tested.finalists(&luckiest, &[], &[]).collect();
        let places: Vec<_> = finalists
            .iter()
            .map(|champion| (champion.generation, champion.individual, champion.fitness))
            .collect();
        assert_eq!(places, [(2, 2, 8.0), (0, 2, 4.0)]);
        assert_eq!(finalists[1].genome, [-2.0, 10.0]);
    }

    #[test]
    fn a_state_with_numbers_that_have_not_lived_is_refused() {
        let mut tested = grid();
        tested.tell(vec![1.0, 2.0, 3.0], &[]).unwrap();
        tested.state.best[0].0 = 3;
        let saved = tested.save();
        assert!(grid().restore(&saved).is_err());
    }
}
