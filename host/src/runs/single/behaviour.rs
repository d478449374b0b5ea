//! Behaviour of individuals, for optimisers that use it.

use std::sync::Arc;

use oneiro::batch::Trace;

use crate::experiment::Experiment;
use crate::lives::measures::{self, Descriptor, Frame, Meter};

/// Measures behaviour by the descriptors of an experiment.
pub(super) struct Behaviour {
    frame: Arc<Frame>,
    descriptors: Vec<Descriptor>,
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
        Some(Self {
            frame: Arc::new(Frame::new(world, world.cycles())),
            descriptors: evolution
                .descriptors
                .iter()
                .filter_map(|wanted| own(&wanted.measure))
                .collect(),
        })
    }

    /// What describes each individual, one after the other: means over its lives. A life that ended before its first cycle has no
    /// behaviour: NaN.
    pub(super) fn of(&self, traces: &[Trace], trials: u32) -> Vec<f64> {
        let count = f64::from(trials);
        let individual = |lives: &[Trace]| {
            let measured: Vec<_> = lives.iter().map(|life| self.measured(life)).collect();
            let mean = |own: &Descriptor| measured.iter().map(|life| own.value(life)).sum::<f64>() / count;
            self.descriptors.iter().map(mean).collect::<Vec<f64>>()
        };
        traces.chunks_exact(trials as usize).flat_map(individual).collect()
    }

    fn measured(&self, life: &Trace) -> measures::Measures {
        let mut meter = Meter::new(Arc::clone(&self.frame));
        for (record, details) in life.lines() {
            meter.add(record, details);
        }
        meter.finish()
    }
}
