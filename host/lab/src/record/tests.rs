//! Runs in directories, on a device that prefers genes near one half.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro::batch::{LANES, Part, PartResult};
use oneiro::evaluator::{self, Control, Error, Evaluator};
use oneiro_base::console::Console;
use oneiro_base::console::Output;
use oneiro_base::exit::{Failure, Result};

use super::*;
use crate::engine::handle::Engine;
use crate::engine::job::Progress;
use crate::engine::watcher::Watch;
use crate::runs::{self, Experiment};

/// Prefers genes near one half, and gives NaN to genomes whose first gene is above `nan_above`.
struct Mock {
    nan_above: f32,
    /// Evaluations until it fails.
    lasts: usize,
    failure: fn() -> Error,
    /// Error that it adds to traces.
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
                let genes = part.inputs()[first..].iter().step_by(LANES).skip(3).take(18);
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

struct Impatient {
    /// Generations until it stops the work.
    patience: u32,
}

impl Watch for Impatient {
    fn stops(&self) -> bool {
        self.patience == 0
    }

    fn steps(&mut self, _: u64) {}

    fn advanced(&mut self, _: Progress) {
        self.patience = self.patience.saturating_sub(1);
    }
}

/// A temporary directory with an experiment, removed when the test ends.
struct Scratch {
    path: PathBuf,
    experiment: Arc<dyn Experiment>,
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
            experiment: runs::read(&file, &[]).unwrap(),
            path,
        }
    }

    fn new_run(&self, seed: u64, directory: &str) -> RunPlace {
        RunPlace::New {
            experiment: Arc::clone(&self.experiment),
            seed,
            directory: self.path.join(directory),
            name: None,
        }
    }

    /// Does runs and returns their results, in the order of their directories.
    fn run(places: Vec<RunPlace>, mock: Mock, patience: u32) -> Result<Vec<(PathBuf, Done)>> {
        let engine = Engine::new(Box::new(mock), Arc::new(AtomicBool::new(false)));
        let session = Session::new("f00d", "mock", engine.description());
        let console = Console::new(Output {
            json: false,
            quiet: true,
            verbose: false,
        });
        let mut runs = Directories::new(places, session, console);
        engine.run(
            runs.waiting(),
            Directories::MOST,
            &mut runs,
            &mut Impatient { patience },
        )?;
        assert!(engine.close().warnings.is_empty());
        let mut done = runs.done();
        done.sort_by(|(a, _), (b, _)| a.cmp(b));
        Ok(done)
    }

    /// Failure of a run in `run`.
    fn failure(&self, mock: Mock) -> Failure {
        match Self::run(vec![self.new_run(1, "run")], mock, u32::MAX) {
            Err(failure) => failure,
            Ok(_) => panic!("nothing failed"),
        }
    }

    fn state(&self, directory: &str) -> State {
        let run = self.saved(directory);
        run.state(run.done().unwrap().is_some())
    }

    fn saved(&self, directory: &str) -> SavedRun {
        SavedRun::open(&self.path.join(directory)).unwrap()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A leftover in the system's temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.path);
    }
}

#[test]
fn runs_that_share_batches_are_what_they_are_alone() {
    let scratch = Scratch::new("lockstep");
    let together = (0..5).map(|seed| scratch.new_run(seed, &format!("together-{seed}")));
    let together = Scratch::run(together.collect(), Mock::default(), u32::MAX).unwrap();
    for (seed, (directory, done)) in (0..5).zip(&together) {
        let alone = vec![scratch.new_run(seed, &format!("alone-{seed}"))];
        assert_eq!(Scratch::run(alone, Mock::default(), u32::MAX).unwrap()[0].1, *done);
        assert_eq!(verify(directory).unwrap(), *done);
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
    Scratch::run(vec![scratch.new_run(1, "run")], mock, u32::MAX).unwrap();
    let directory = scratch.path.join("run");
    let champion: serde_json::Value =
        serde_json::from_slice(&fs::read(directory.join("champion.json")).unwrap()).unwrap();
    assert!(champion["genome"][0].as_f64().unwrap() <= 0.2 && champion["fitness"].is_number());
    // A generation's individuals: 18 genes and a score each.
    let individuals = fs::read(directory.join("individuals.npy")).unwrap();
    let individuals = oneiro_base::npy::floats(&individuals[individuals.len() - 9 * 12 * 19 * 4..]);
    let table = fs::read_to_string(directory.join("generations.csv")).unwrap();
    let mut all = 0;
    for (line, generation) in table.lines().skip(1).zip(individuals.chunks_exact(12 * 19)) {
        let cells: Vec<&str> = line.split(',').collect();
        let scores = || generation.iter().copied().skip(18).step_by(19);
        let nan = scores().filter(|score| score.is_nan()).count();
        assert_eq!(cells[7], nan.to_string());
        let best = scores().fold(f32::NEG_INFINITY, f32::max);
        assert_eq!(cells[8], format!("{:08x}", best.to_bits()));
        all += nan;
    }
    assert!(all > 5, "{all}");
}

#[test]
fn stopped_runs_go_on() {
    let scratch = Scratch::new("stopped");
    let whole = Scratch::run(
        vec![scratch.new_run(1, "whole"), scratch.new_run(2, "whole-2")],
        Mock::default(),
        u32::MAX,
    );
    let whole = whole.unwrap();
    for patience in [0, 1, 4, 9, 16, 17, 18] {
        let names = [format!("{patience}-one"), format!("{patience}-two")];
        let runs = vec![scratch.new_run(1, &names[0]), scratch.new_run(2, &names[1])];
        let Err(failure) = Scratch::run(runs, Mock::default(), patience) else {
            panic!("it did not stop after {patience} generations");
        };
        assert_eq!(failure.code(), 75);
        for name in &names {
            assert!(
                failure.to_string().contains(&format!("{name}  (generation ")),
                "{failure}"
            );
            assert_eq!(scratch.state(name), State::Stopped);
        }
        let runs = names.iter().map(|name| RunPlace::Saved(scratch.saved(name))).collect();
        let resumed = Scratch::run(runs, Mock::default(), u32::MAX).unwrap();
        for ((_, done), (_, expected)) in resumed.iter().zip(&whole) {
            assert_eq!(done, expected);
        }
        assert_eq!(scratch.state(&names[0]), State::Done);
    }
}

/// After a device breaks, the run can be resumed at the generation where it broke.
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
    assert!(scratch.path.join("run/checkpoint-5").is_file());
}

/// A device whose trace gives an episode another fitness is detected.
#[test]
fn a_device_that_contradicts_itself_is_detected() {
    let mut scratch = Scratch::new("lies");
    let file = scratch.path.join("mock.toml");
    scratch.experiment = runs::read(&file, &["trials=1".into()]).unwrap();
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
    assert_eq!(scratch.state("run"), State::Interrupted);
}

/// A run that an earlier version began is refused as such.
#[test]
fn runs_of_earlier_versions_are_refused_with_what_to_do() {
    let scratch = Scratch::new("version");
    let stopped = Scratch::run(vec![scratch.new_run(1, "run")], Mock::default(), 4);
    assert_eq!(stopped.unwrap_err().code(), 75);
    let directory = scratch.path.join("run");
    for (_, path) in crate::engine::checkpoint::list(&directory).unwrap() {
        let content = b"{\"format\":\"oneiro checkpoint\",\"version\":1,\"generation\":4}\n\0\0\0\0";
        fs::write(path, [&content[..], blake3::hash(content).as_bytes()].concat()).unwrap();
    }
    let resumed = Scratch::run(vec![RunPlace::Saved(scratch.saved("run"))], Mock::default(), u32::MAX);
    let failure = resumed.unwrap_err();
    assert_eq!(failure.code(), 3);
    for words in ["another version of oneiro", "begin anew in another directory"] {
        assert!(failure.to_string().contains(words), "{failure}");
    }
}
