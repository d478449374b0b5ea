//! Jobs: the engine's unit of work. A job is a state machine: it requests evaluations, takes the results, and eventually finishes. It
//! doesn't depend on devices, files, or the jobs that share its batches.
//!
//! The protocol:
//!
//! 1. A job's maker gives it to the [scheduler](super::scheduler), new or restored from the output of [`Job::save`].
//! 2. The scheduler calls [`Job::ask`]. It puts the [episodes](Job::rollouts) of jobs with equal [`Stage`]s into one batch and
//!    hands that to the device. While the device works, jobs aren't changed, but may be saved.
//! 3. The scheduler calls [`Job::tell`] with the job's part of the results, on any thread. The job takes a complete
//!    step: it advances, or it fails and the run ends. The step's additions to the job's tables go to the recorder at
//!    once, before the next step.
//! 4. Steps 2 and 3 repeat until `ask` returns nothing. Then [`Job::finish`] is called once.
//!
//! [`Job::save`] may be called between any two steps: before the first `ask`, while a request is being evaluated (its
//! results are lost, and a restored job asks for them again), and after the last step, before `finish`. A restored job
//! asks for exactly what the saved one would have asked for. The recorder's tables are saved with the job, so a job
//! doesn't save them.
//!
//! A job's results depend only on its experiment and its seed: never on the batches it shared, the number of threads,
//! or where it was saved and restored.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro::batch::{Rollout, Trace, TraceRequest, WorldKind};
use oneiro_base::exit::Result;
use serde::{Deserialize, Serialize};

use super::queue::Interruption;

/// A state machine that asks for evaluations, takes their results, and can be saved and restored between any two steps.
pub trait Job: Send + Sync {
    /// Returns the next request, or `None` once the job is finished. Must be cheap: it is called several times per
    /// step.
    fn ask(&self) -> Option<Request<'_>>;

    /// Appends the episodes of the next request, in the order in which results are expected. Called once per step, on any thread.
    fn rollouts<'a>(&'a self, into: &mut Vec<Rollout<'a>>);

    /// Takes the results of the last request, in the order of its episodes, and advances by one step.
    ///
    /// # Errors
    /// Impossible results: they leave the job unchanged and end its run.
    fn tell(&mut self, results: &Results<'_>) -> Result<Step>;

    /// Returns everything that is needed to restore the job, given its experiment and its seed. The caller adds a
    /// header and a hash; the job adds a version if its own format may change.
    fn save(&self) -> Vec<u8>;

    /// Returns the results of a finished job. Called once, after `ask` has returned `None`. `table` is the job's
    /// complete [table of steps](Added), from its first line, including rows added before the job was restored.
    ///
    /// # Errors
    /// As the job says.
    fn finish(&mut self, table: &str) -> Result<Finished>;
}

impl Job for Box<dyn Job> {
    fn ask(&self) -> Option<Request<'_>> {
        (**self).ask()
    }

    fn rollouts<'a>(&'a self, into: &mut Vec<Rollout<'a>>) {
        (**self).rollouts(into);
    }

    fn tell(&mut self, results: &Results<'_>) -> Result<Step> {
        (**self).tell(results)
    }

    fn save(&self) -> Vec<u8> {
        (**self).save()
    }

    fn finish(&mut self, table: &str) -> Result<Finished> {
        (**self).finish(table)
    }
}

/// A job's next request for evaluations.
pub struct Request<'a> {
    /// Requests with equal stages may share a batch.
    pub stage: Stage,
    /// Worlds of its episodes; an episode's `world` is an index into these.
    pub worlds: &'a [Place],
    /// Where the episodes run instead of in their worlds, at [`Stage::OUTSIDE`].
    pub outside: Option<&'a Arc<dyn Outside>>,
    /// To continue episodes: the [`Results::states`] of each after the previous stretch.
    pub states: &'a [Vec<u32>],
    /// Number of its episodes.
    pub lives: usize,
    /// Total robot-steps of the episodes: the room that the request takes in a batch.
    pub steps: u64,
}

/// Common properties of requests that share a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// Name of the worlds' kernel.
    pub kernel: &'static str,
    /// Progress of jobs that advance together only if they are equally far: the cycle that a swarm has reached. 0 for
    /// jobs whose steps are all alike, such as generations.
    pub reached: u32,
    /// Range of cycles to simulate, in worlds whose episodes are cut into stretches; `None` for whole episodes.
    pub cycles: Option<[u32; 2]>,
    /// Cycles between records of a trace; `None` for no trace.
    pub(crate) trace_every: Option<u32>,
}

impl Stage {
    /// Episodes outside of the device.
    pub(crate) const OUTSIDE: Self = Self {
        kernel: "outside",
        reached: 0,
        cycles: None,
        trace_every: None,
    };

    /// Whole episodes without a trace, for jobs whose steps are all alike.
    pub(crate) fn lives(kernel: &'static str) -> Self {
        Self {
            kernel,
            reached: 0,
            cycles: None,
            trace_every: None,
        }
    }

    /// The stretch of cycles, if episodes are cut.
    pub(super) fn stretch(&self) -> Option<Range<u32>> {
        self.cycles.map(|[first, end]| first..end)
    }

    /// The trace to request from the evaluator, if any.
    pub(crate) fn trace(&self) -> Option<TraceRequest> {
        self.trace_every.map(|every| TraceRequest { every })
    }
}

/// A place outside of the device where episodes run, such as a robot.
pub trait Outside: fmt::Debug + Send + Sync {
    /// Runs episodes one after the other, and returns the fitness of each. Their `world` has no meaning. Episodes that a stopped call
    /// has completed are not repeated by the next.
    ///
    /// # Errors
    /// [`Error::Cancelled`](oneiro::evaluator::Error::Cancelled) once `stop` is set; [`Interruption::Outside`] for everything else.
    fn live(&self, rollouts: &[Rollout<'_>], stop: &Arc<AtomicBool>) -> std::result::Result<Vec<f32>, Interruption>;
}

/// A world of a request. Places with equal keys are one world: it is packed once, and episodes of several jobs share the device's
/// groups of lanes.
#[derive(Clone)]
pub struct Place {
    /// Hash of everything that affects episodes in it.
    pub key: blake3::Hash,
    pub world: Arc<dyn WorldKind + Send + Sync>,
}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.key, self.world.kernel().name)
    }
}

/// Results of a request, with one value for each episode, in the order of the episodes.
#[derive(Clone, Copy, Debug)]
pub struct Results<'a> {
    pub fitness: &'a [f32],
    /// Traces of worlds of one robot; empty unless requested.
    pub traces: &'a [Trace],
    /// Traces of worlds of several robots, as words of lines; empty unless requested.
    pub logs: &'a [Vec<u32>],
    /// Words per line of a log; at least as many as the lines of the world have.
    pub(crate) log_words: usize,
    /// State from which each episode continues; empty for whole episodes. It may be longer than the world's own state: the engine cuts
    /// and pads the states that come back in [`Request::states`].
    pub states: &'a [Vec<u32>],
}

/// Output of one step of a job.
#[derive(Debug, Default)]
pub struct Step {
    /// Additions to the job's tables.
    pub added: Vec<Added>,
    /// Progress to show to the user; `None` if unchanged.
    pub progress: Option<Progress>,
    /// Whether a run with its own directory should be saved here. A shard of a sweep saves on its own clock.
    pub(crate) is_checkpoint: bool,
}

/// Bytes to append to one of a job's tables, which only grow. One of them is the table of steps that [`Job::finish`] gets: the
/// generations of an evolution, the intervals of the foraging study. The kind of experiment defines which one it is, and how each table
/// begins.
#[derive(Debug)]
pub struct Added {
    /// File name in a run's directory.
    pub file: &'static str,
    /// Complete lines, or complete values.
    pub bytes: Vec<u8>,
}

/// Progress of a job.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Finished steps in the user's units: generations of an evolution, minutes of the foraging study.
    pub done: u32,
    /// Best so far: the champion's fitness, the foragers' food.
    pub best: f32,
}

/// Table cells by the names of their columns. Missing values are left out.
pub type Named = BTreeMap<Cow<'static, str>, String>;

/// Results of a finished job.
#[derive(Debug, Default)]
pub struct Finished {
    /// Files to write once, with their contents; tables aren't among them.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// Its values in a sweep's table of results, by the names of the columns.
    pub outcomes: Named,
    /// The champion's genes; none where there is no champion.
    pub champion: Vec<f32>,
}
