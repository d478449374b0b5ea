//! How a race samples candidates: at random, and around others.

use oneiro::world::{Gene, GeneKind};
use rand::Rng;
use rand::distr::Distribution;
use serde::{Deserialize, Serialize};

use super::super::random::{Normal, Uniform, unit};
use super::super::settings::{Settings, initial_range};

/// A genome, and for each gene that is a choice the probabilities with which its children choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Candidate {
    pub(super) genome: Vec<f32>,
    chances: Vec<Vec<f64>>,
}

/// What a gene may be.
#[derive(Clone, Debug)]
struct Place {
    low: f64,
    high: f64,
    kind: GeneKind,
    only: Option<(usize, &'static [u32])>,
    /// Its index among choices.
    choice: usize,
}

/// What genomes may be.
#[derive(Clone, Debug)]
pub(super) struct Model(Vec<Place>);

impl Place {
    /// The number of the choice, or the whole number, that a value is.
    fn index(&self, gene: f32) -> usize {
        let most = (self.high - self.low).ceil() as usize - 1;
        ((f64::from(gene) - self.low) as usize).min(most)
    }

    /// A value as stored: in the middle between whole numbers, if it is one.
    fn kept(&self, value: f64) -> f32 {
        match self.kind {
            GeneKind::Number => {
                let gene = value.clamp(self.low, self.high) as f32;
                if gene.is_normal() { gene } else { 0.0 }
            }
            GeneKind::Whole | GeneKind::Choice => {
                let index = self.index(value as f32) as f64;
                (self.low + index + 0.5) as f32
            }
        }
    }

    fn drawn(&self, random: &mut impl Rng) -> f32 {
        let uniform = Uniform {
            low: self.low,
            high: self.high,
        };
        self.kept(uniform.sample(random))
    }

    /// From a normal distribution around a value, cut off at the range's ends.
    fn near(&self, value: f32, spread: f64, random: &mut impl Rng) -> f32 {
        const TRIES: u32 = 100;
        let normal = Normal {
            deviation: 0.5 * spread * (self.high - self.low),
        };
        for _ in 0..TRIES {
            let sample = f64::from(value) + normal.sample(random);
            if (self.low..=self.high).contains(&sample) {
                return self.kept(sample);
            }
        }
        value
    }
}

impl Model {
    pub(super) fn new(settings: &Settings, genes: &[Gene]) -> Self {
        let mut choices = 0;
        let place = |gene: &Gene| {
            let [low, high] = initial_range(settings, gene.range);
            let choice = choices;
            choices += usize::from(gene.kind == GeneKind::Choice);
            Place {
                low,
                high,
                kind: gene.kind,
                only: gene.only,
                choice,
            }
        };
        Self(genes.iter().map(place).collect())
    }

    pub(super) fn genes(&self) -> usize {
        self.0.len()
    }

    fn choices(&self) -> impl Iterator<Item = &Place> {
        self.0.iter().filter(|place| place.kind == GeneKind::Choice)
    }

    /// Whether a saved candidate is one of these.
    pub(super) fn fits(&self, candidate: &Candidate) -> bool {
        let counts = self.choices().map(|place| place.index(place.high as f32) + 1);
        candidate.genome.len() == self.genes() && counts.eq(candidate.chances.iter().map(Vec::len))
    }

    /// Whether a gene has an effect.
    fn is_active(&self, genome: &[f32], mut gene: usize) -> bool {
        while let Some((of, values)) = self.0[gene].only {
            if !values.contains(&(genome[of] as u32)) {
                return false;
            }
            gene = of;
        }
        true
    }

    /// A random candidate.
    pub(super) fn first(&self, random: &mut impl Rng) -> Candidate {
        let genome: Vec<f32> = self.0.iter().map(|place| place.drawn(random)).collect();
        self.given(&genome)
    }

    /// A candidate with a given genome.
    pub(super) fn given(&self, genome: &[f32]) -> Candidate {
        let even = |place: &Place| {
            let count = place.index(place.high as f32) + 1;
            vec![1.0 / count as f64; count]
        };
        Candidate {
            genome: genome.to_vec(),
            chances: self.choices().map(even).collect(),
        }
    }

    /// A candidate with more of its chances on its own choices.
    pub(super) fn sharpened(&self, candidate: &Candidate, share: f64) -> Candidate {
        let mut sharper = candidate.clone();
        for (gene, place) in self.0.iter().enumerate() {
            // A choice without an effect has nothing for it.
            if place.kind == GeneKind::Choice && self.is_active(&sharper.genome, gene) {
                let chances = &mut sharper.chances[place.choice];
                for chance in chances.iter_mut() {
                    *chance *= 1.0 - share;
                }
                chances[place.index(sharper.genome[gene])] += share;
            }
        }
        sharper
    }

    /// A child of a candidate.
    pub(super) fn around(&self, parent: &Candidate, spread: f64, random: &mut impl Rng) -> Candidate {
        let mut child = parent.clone();
        // The genes that decide whether a gene has an effect come before it.
        for (gene, place) in self.0.iter().enumerate() {
            if !self.is_active(&child.genome, gene) {
                continue;
            }
            child.genome[gene] = if place.kind == GeneKind::Choice {
                place.kept(place.low + chosen(&parent.chances[place.choice], random) as f64)
            } else if self.is_active(&parent.genome, gene) {
                place.near(parent.genome[gene], spread, random)
            } else {
                place.drawn(random)
            };
        }
        child
    }
}

/// A choice by its chances, which add up to about 1.
fn chosen(chances: &[f64], random: &mut impl Rng) -> usize {
    let mut rest = unit(random);
    for (index, chance) in chances.iter().enumerate() {
        if rest < *chance {
            return index;
        }
        rest -= chance;
    }
    chances.len() - 1
}
