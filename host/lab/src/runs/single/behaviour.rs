//! Behaviour of individuals, for optimisers that use it.

use oneiro::batch::Trace;
use oneiro::random::Key;
use oneiro_base::contents::Column;
use rayon::prelude::*;

use super::job::means;
use crate::experiment::Experiment;
use crate::lives::measures::{self, Descriptor, Frames, Meter};

/// Columns of the table of individuals without a behaviour.
pub(super) static COLUMNS: [Column; 2] = [
    Column::whole("generation", "", "its number, from 0"),
    Column::whole(
        "nan",
        "individuals",
        "the number of individuals that have a measure that is not a number (NaN): they have no behaviour",
    ),
];

/// Measures behaviour by the descriptors of an experiment.
pub(super) struct Behaviour {
    frames: Frames,
    descriptors: Vec<Descriptor>,
    /// Cycles between the records that are needed.
    every: u32,
    /// Records of an episode that doesn't end early.
    records: usize,
}

impl Behaviour {
    /// None if the experiment's optimiser does not use behaviour.
    pub(super) fn new(experiment: &Experiment) -> Option<Self> {
        let evolution = &experiment.settings().evolution;
        if !evolution.uses_behaviour() {
            return None;
        }
        let (world, known) = (experiment.world(), measures::descriptors(experiment.world()));
        let own = |measure: &str| known.iter().find(|own| own.column.name == measure).cloned();
        let wanted = evolution.descriptors.iter();
        let descriptors: Vec<_> = wanted.filter_map(|wanted| own(&wanted.measure)).collect();
        let frames = Frames::new(world, world.cycles(), &descriptors);
        // If only the end is needed, the first and the last cycle have a record.
        let last = world.cycles() - 1;
        let every = if frames.needs_only_the_end() { last.max(1) } else { 1 };
        Some(Self {
            frames,
            descriptors,
            every,
            records: (last / every) as usize + 1,
        })
    }

    /// The number of individuals that have a measure that is not a number, among behaviours of [`Behaviour::of`].
    pub(super) fn unmeasured(&self, behaviours: &[f64]) -> u32 {
        let individuals = behaviours.chunks_exact(self.descriptors.len());
        individuals
            .filter(|own| own.iter().any(|measure| measure.is_nan()))
            .count() as u32
    }

    /// Cycles between records of the traces that it measures.
    pub(super) fn every(&self) -> u32 {
        self.every
    }

    /// The behaviour of each individual, one after the other, given the keys of one's episodes: means over its episodes; NaN if an episode ended before its first
    /// cycle. None if an episode ended early, so that its last record lies between the requested ones: from then on all are
    /// requested.
    pub(super) fn of(&mut self, traces: &[Trace], keys: &[Key]) -> Option<Vec<f64>> {
        if self.every > 1 && traces.iter().any(|life| life.len() < self.records) {
            self.every = 1;
            return None;
        }
        let individual = |lives: &[Trace]| {
            let mut measured = Vec::with_capacity(lives.len() * self.descriptors.len());
            for (life, key) in lives.iter().zip(keys) {
                let life = self.measured(life, *key);
                measured.extend(self.descriptors.iter().map(|own| own.value(&life)));
            }
            means(&measured, self.descriptors.len()).collect::<Vec<f64>>()
        };
        let all = traces.par_chunks_exact(keys.len()).map(individual);
        Some(all.collect::<Vec<_>>().concat())
    }

    fn measured(&self, life: &Trace, key: Key) -> measures::Measures {
        let mut meter = Meter::new(self.frames.of(key));
        meter.add_all(life);
        meter.finish()
    }
}
