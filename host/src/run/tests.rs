use std::fs;
use std::path::PathBuf;

use oneiro::batch::{LANES, Part};
use oneiro::evaluator::{self, Control, Error, Evaluator, PartResult};

use super::*;
use crate::record::{State, verify};

/// Likes genes near one half, and says that those who begin with more than `nan_above` are no numbers.
struct Mock {
    nan_above: f32,
    /// Evaluations until it fails.
    lasts: usize,
    failure: fn() -> Error,
    /// What it adds in traces.
    lies: f32,
}

impl Default for Mock {
    fn default() -> Self {
        Self {
            nan_above: f32::INFINITY,
            lasts: usize::MAX,
            failure: || Error::Cancelled,
            lies: 0.0,
        }
    }
}

impl Evaluator for Mock {
    fn device(&self) -> evaluator::Device {
        evaluator::Device {
            name: "mock".into(),
            detail: String::new(),
            exact: true,
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> std::result::Result<PartResult, Error> {
        if self.lasts == 0 {
            return Err((self.failure)());
        }
        self.lasts -= 1;
        control.add_steps(part.steps());
        let traced = part.batch().trace_words();
        let mut result = PartResult::default();
        for group in part.group_table() {
            for lane in 0..LANES {
                let first = (group.inputs - part.first_input()) as usize + lane;
                let genes = part.inputs()[first..].iter().step_by(LANES).skip(2).take(18);
                let genes: Vec<f32> = genes.map(|&gene| f32::from_bits(gene)).collect();
                let score = -genes.iter().map(|gene| (gene - 0.5) * (gene - 0.5)).sum::<f32>();
                let lie = if traced > 0 { self.lies } else { 0.0 };
                result.fitness.push(if genes[0] > self.nan_above {
                    f32::NAN
                } else {
                    score + lie
                });
                result.trace.extend(std::iter::repeat_n(0, traced));
            }
        }
        Ok(result)
    }
}

struct Nobody {
    /// Generations until it wants to stop.
    patience: u32,
}

impl Watch for Nobody {
    fn stops(&self) -> bool {
        self.patience == 0
    }

    fn steps(&mut self, _done: u64) {}
}

impl Follow for Nobody {
    fn lived(&mut self, _run: &Run) {
        self.patience = self.patience.saturating_sub(1);
    }
}

/// A directory of its own with an experiment, removed when the test ends.
struct Scratch {
    path: PathBuf,
    experiment: Experiment,
}

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-loop-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        let file = path.join("mock.toml");
        let text = "cycles = 5\ntrials = 2\n[evolution]\npopulation = 12\nparents = 3\ngenerations = 9\n\
                    [record]\ncheckpoint_every = 2\n";
        fs::write(&file, text).unwrap();
        Self {
            experiment: Experiment::read(&file, &[]).unwrap(),
            path,
        }
    }

    fn start(&self, seed: u64, directory: &str) -> Run {
        Run::start(&self.experiment, seed, &self.path.join(directory), session()).unwrap()
    }

    fn evolve(&self, runs: Vec<Run>, mock: Mock, patience: u32) -> Result<Vec<(Run, Done)>> {
        let worker = Worker::new(Box::new(mock));
        let result = evolve(&self.experiment, runs, &worker, &mut Nobody { patience });
        assert!(worker.close().is_empty());
        result
    }

    /// Why a run in `run` does not come to its end.
    fn failure(&self, mock: Mock) -> Failure {
        match self.evolve(vec![self.start(1, "run")], mock, u32::MAX) {
            Err(failure) => failure,
            Ok(_) => panic!("nothing failed"),
        }
    }

    fn saved(&self, directory: &str) -> SavedRun {
        SavedRun::open(&self.path.join(directory)).unwrap()
    }

    fn resume(&self, directory: &str) -> Run {
        let (run, warnings) = Run::resume(&self.saved(directory), session()).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        run
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is left in the system's directory for such files does no harm.
        let _ = fs::remove_dir_all(&self.path);
    }
}

fn session() -> Session {
    Session::new("mock", &Mock::default().device())
}

#[test]
fn runs_in_lockstep_are_what_they_are_alone() {
    let scratch = Scratch::new("lockstep");
    let together = (0..5)
        .map(|seed| scratch.start(seed, &format!("together-{seed}")))
        .collect();
    let together = scratch.evolve(together, Mock::default(), u32::MAX).unwrap();
    for (seed, (run, done)) in (0..5).zip(&together) {
        assert_eq!(run.seed(), seed);
        let alone = vec![scratch.start(seed, &format!("alone-{seed}"))];
        assert_eq!(scratch.evolve(alone, Mock::default(), u32::MAX).unwrap()[0].1, *done);
        assert_eq!(verify(run.directory()).unwrap(), *done);
    }
    assert_ne!(together[0].1.result, together[1].1.result);
}

/// NaN ranks last, is counted in the table of generations and never becomes the champion.
#[test]
fn nan_fitness_ranks_last_and_is_counted() {
    let scratch = Scratch::new("nan");
    let mock = Mock {
        nan_above: 0.2,
        ..Mock::default()
    };
    let runs = scratch.evolve(vec![scratch.start(1, "run")], mock, u32::MAX).unwrap();
    let champion = runs[0].0.evolution().champion().unwrap();
    assert!(champion.genome[0] <= 0.2 && champion.fitness.is_finite());
    let saved = scratch.saved("run");
    let individuals = saved.individuals().unwrap();
    let mut all = 0;
    for row in saved.rows().unwrap() {
        let own = (0..individuals.len()).filter(|&index| individuals.place(index).0 == row.generation);
        let own: Vec<f32> = own.filter_map(|index| Some(individuals.get(index)?.1)).collect();
        assert_eq!(own.len(), 12);
        assert_eq!(row.nan as usize, own.iter().filter(|score| score.is_nan()).count());
        assert_eq!(row.best, own.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        all += row.nan;
    }
    assert!(all > 5, "{all}");
}

#[test]
fn stopped_runs_go_on() {
    let scratch = Scratch::new("stopped");
    let whole = scratch.evolve(
        vec![scratch.start(1, "whole"), scratch.start(2, "whole-2")],
        Mock::default(),
        u32::MAX,
    );
    let whole = whole.unwrap();
    for patience in [0, 1, 4, 9, 16, 17] {
        let (one, two) = (format!("one-{patience}"), format!("two-{patience}"));
        let runs = vec![scratch.start(1, &one), scratch.start(2, &two)];
        let Err(failure) = scratch.evolve(runs, Mock::default(), patience) else {
            panic!("it did not stop after {patience} generations");
        };
        assert_eq!(failure.code(), 75);
        assert_eq!(scratch.saved(&one).state().unwrap(), State::Stopped);
        let runs = vec![scratch.resume(&one), scratch.resume(&two)];
        for ((_, done), (_, expected)) in scratch
            .evolve(runs, Mock::default(), u32::MAX)
            .unwrap()
            .iter()
            .zip(&whole)
        {
            assert_eq!(done, expected);
        }
        assert_eq!(scratch.saved(&one).state().unwrap(), State::Done);
    }
}

/// What a broken device leaves can be gone on with, at the generation where it broke.
#[test]
fn a_broken_device_costs_no_generation() {
    let scratch = Scratch::new("broken");
    let mock = Mock {
        lasts: 5,
        failure: || Error::Lost {
            device: "mock".into(),
            reason: "it is one".into(),
        },
        ..Mock::default()
    };
    let failure = scratch.failure(mock);
    assert_eq!(failure.code(), 1);
    assert!(failure.to_string().contains("the device mock was lost"), "{failure}");
    assert_eq!(scratch.resume("run").evolution().generation(), 5);
}

/// A device that gives a life another fitness in its trace is found out.
#[test]
fn a_device_that_contradicts_itself_is_found_out() {
    let mut scratch = Scratch::new("lies");
    let file = scratch.path.join("mock.toml");
    scratch.experiment = Experiment::read(&file, &["trials=1".into()]).unwrap();
    let mock = Mock {
        lies: 1e-6,
        ..Mock::default()
    };
    let failure = scratch.failure(mock);
    assert_eq!(failure.code(), 1);
    assert!(
        failure.to_string().contains("results of this device can't be trusted"),
        "{failure}"
    );
    assert!(matches!(scratch.saved("run").state(), Ok(State::Interrupted)));
}

#[test]
fn scores_of_several_lives() {
    assert_eq!(score(TrialScore::Mean, &[1.0, 2.0, 6.0]), 3.0);
    assert_eq!(score(TrialScore::Least, &[1.0, -2.0, 6.0]), -2.0);
    assert_eq!(score(TrialScore::Mean, &[0.1]), 0.1);
    assert!(score(TrialScore::Least, &[1.0, f32::NAN]).is_nan());
    assert!(score(TrialScore::Mean, &[f32::NAN, 1.0]).is_nan());
}
