//! Novelty search (Lehman and Stanley, "Abandoning objectives: evolution through the search for novelty alone",
//! Evolutionary Computation 19(2), 2011): a genetic algorithm that selects individuals whose behaviour differs from the
//! rest of the generation and from the archive. Fitness is recorded and chooses the champion, and decides nothing else.

use crate::error::{Error, Result};
use oneiro::parameter::Allowed::{Whole, WholeUpTo};
use oneiro::parameter::{Parameter, row};
use serde::Serialize;

use super::genetic::{FROM_MUTANTS, Genetic};
use super::random::{Stream, shuffled, stream};
use super::registry::{Entry, Table};
use super::settings::{Descriptor, Feature, Ranges, Settings, breeding, descriptors};
use super::{Optimizer, Population, ranked, saved};

const NAME: &str = "novelty";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::Breeds, Feature::Behaviour],
    start: FROM_MUTANTS,
    check: |settings, _| {
        breeding::check(settings)?;
        descriptors::check(settings)
    },
    ..Entry::new(
        [
            NAME,
            "the genetic algorithm, selecting by how new a behaviour is: Lehman and Stanley 2011",
            "when fitness misleads",
        ],
        |beginning| {
            Box::new(Novelty::new(
                beginning.settings,
                beginning.seed,
                beginning.ranges(),
                beginning.init,
            ))
        },
    )
};

/// Values of novelty search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    /// Nearest behaviours whose mean distance is the novelty.
    pub neighbours: u32,
    /// Behaviours of each generation that are kept, drawn at random.
    pub added: u32,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            neighbours: 15,
            added: 6,
        }
    }
}

impl Table for Values {
    #[rustfmt::skip]
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
        vec![
            row("evolution.novelty.neighbours", "", Whole(1, 100_000), "Lehman and Stanley 2011",
                "Nearest behaviours whose mean distance is an individual's novelty.", |values, _| Some(&mut values.as_mut().novelty()?.neighbours)),
            row("evolution.novelty.added", "", WholeUpTo(0, "evolution.population"), "ours",
                "Behaviours of each generation, drawn at random, that the archive keeps.", |values, _| Some(&mut values.as_mut().novelty()?.added)),
        ]
    }

    // Experiments of other optimisers had these values from the start.
    fn is_left_out(&self) -> bool {
        false
    }
}

/// The search at one generation.
#[derive(Clone, Debug)]
struct Novelty {
    owner: saved::Owner,
    values: Values,
    descriptors: Vec<Descriptor>,
    seed: u64,
    genetic: Genetic,
    /// Kept behaviours, one after the other, as fractions of the descriptors' ranges.
    archive: Vec<f64>,
}

impl Novelty {
    fn new(settings: &Settings, seed: u64, ranges: Ranges, init: Option<Population>) -> Self {
        Self {
            owner: saved::Owner::new(settings, seed, &ranges),
            values: settings.tables.novelty.clone(),
            descriptors: settings.descriptors.clone(),
            seed,
            genetic: Genetic::new(settings, seed, ranges, init),
            archive: Vec::new(),
        }
    }

    /// How far each behaviour is from its nearest neighbours, on average; NaN of a behaviour that has one.
    fn novelty(&self, behaviours: &[f64]) -> Vec<f32> {
        let dimensions = self.descriptors.len();
        let of = |(index, behaviour): (usize, &[f64])| {
            if behaviour.iter().any(|value| value.is_nan()) {
                return f32::NAN;
            }
            let others = behaviours.chunks_exact(dimensions).enumerate();
            let others = others.filter(|(other, _)| *other != index).map(|(_, other)| other);
            let all = others.chain(self.archive.chunks_exact(dimensions));
            let square = |other: &[f64]| -> f64 { behaviour.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum() };
            let mut squares: Vec<f64> = all.map(square).filter(|square| !square.is_nan()).collect();
            let count = squares.len().min(self.values.neighbours as usize);
            if count == 0 {
                return 0.0;
            }
            squares.select_nth_unstable_by(count - 1, f64::total_cmp);
            let nearest = &mut squares[..count];
            nearest.sort_unstable_by(f64::total_cmp);
            (nearest.iter().map(|square| square.sqrt()).sum::<f64>() / count as f64) as f32
        };
        behaviours.chunks_exact(dimensions).enumerate().map(of).collect()
    }
}

impl Optimizer for Novelty {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.genetic.generation()
    }

    fn ask(&self) -> &Population {
        self.genetic.ask()
    }

    fn descriptors(&self) -> usize {
        self.descriptors.len()
    }

    fn advance(&mut self, fitness: &[f32], _: &[u32], behaviour: &[f64]) -> Population {
        let shares = behaviour.iter().zip(self.descriptors.iter().cycle());
        let behaviours: Vec<f64> = shares.map(|(value, descriptor)| descriptor.share(*value)).collect();
        let novelty = self.novelty(&behaviours);
        let mut random = stream(self.seed, Stream::Archive, self.generation());
        let evaluated = self.genetic.advance(&novelty, &ranked(&novelty), &[]);
        let dimensions = self.descriptors.len();
        let lots = shuffled(fitness.len(), &mut random);
        let kept = lots
            .into_iter()
            .map(|individual| &behaviours[individual * dimensions..][..dimensions])
            .filter(|behaviour| behaviour.iter().all(|value| !value.is_nan()));
        for behaviour in kept.take(self.values.added as usize) {
            self.archive.extend_from_slice(behaviour);
        }
        evaluated
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
        self.genetic.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        saved::seal(NAME, VERSION, &self.owner, &(self.genetic.save(), &self.archive))
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let (genetic, archive): (Vec<u8>, Vec<f64>) = saved::open(NAME, VERSION, &self.owner, bytes)?;
        if !archive.len().is_multiple_of(self.descriptors.len()) {
            return Err(Error::Lengths);
        }
        self.genetic.restore(&genetic)?;
        self.archive = archive;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::Kind;
    use super::*;

    fn search(neighbours: u32, added: u32) -> Novelty {
        let mut settings = Settings {
            kind: Kind::Novelty,
            population: 4,
            parents: 2,
            ..Settings::default()
        };
        settings.tables.novelty = Values { neighbours, added };
        settings.descriptors = vec![
            Descriptor::named("x", [0.0, 10.0], 1),
            Descriptor::named("y", [-1.0, 1.0], 1),
        ];
        Novelty::new(&settings, 1, vec![None; 3], None)
    }

    /// Distances in fractions of the ranges, worked out by hand: places (0, 0), (0.3, 0), (0, 0.4) and one without a
    /// place.
    #[test]
    fn novelty_is_the_mean_distance_from_neighbours() {
        let of_two = search(2, 0);
        let novelty = of_two.novelty(&[0.0, 0.0, 0.3, 0.0, 0.0, 0.4, f64::NAN, 0.0]);
        let expected = [0.35_f32, 0.4, 0.45];
        for (value, expected) in novelty.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-7, "{novelty:?}");
        }
        assert!(novelty[3].is_nan());
        let nearest = search(1, 0).novelty(&[0.0, 0.0, 0.3, 0.0, 0.0, 0.4]);
        assert!(
            (nearest[0] - 0.3).abs() < 1e-7 && (nearest[2] - 0.4).abs() < 1e-7,
            "{nearest:?}"
        );
        assert_eq!(search(9, 0).novelty(&[0.5, 0.5]), [0.0], "alone");
    }

    /// Behaviour like the archive's is not new, whatever its fitness; fitness is recorded.
    #[test]
    fn fitness_decides_nothing_but_the_record() {
        let mut of_one = search(1, 4);
        let behaviour = [0.0, 0.0, 0.1, 0.0, 0.2, 0.0, 10.0, 1.0];
        let asked = of_one.ask().clone();
        let generation = of_one.tell(vec![9.0, 8.0, 7.0, -1.0], &behaviour).unwrap();
        assert_eq!(
            (generation.ranking[0], &generation.fitness[..]),
            (0, &[9.0, 8.0, 7.0, -1.0][..])
        );
        assert_eq!(of_one.archive.len(), 8);
        // The last individual is the parent of the first family: most of its genes are still there.
        let shared = |child: usize, parent| {
            let genes = of_one.ask().genome(child).iter().zip(asked.genome(parent));
            genes.filter(|(a, b)| a == b).count()
        };
        assert!(shared(0, 3) + shared(1, 3) >= 2);
        // All four places are in the archive now: another one is the newest.
        let novelty = of_one.novelty(&[0.0, 0.5, 0.01, 0.5, 0.02, 0.5, 0.5, 0.9]);
        assert!(novelty[3] > 10.0 * novelty[0], "{novelty:?}");
    }
}
