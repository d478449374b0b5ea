//! Jobs: what the engine runs. A job is a state machine. It names what it wants evaluated next, takes the results, and
//! is finished at some point. It knows nothing of devices, files, or the jobs that share its batches.
//!
//! Who calls what, in which order:
//!
//! 1. Whoever makes a job gives it to the [scheduler](super::scheduler), new or restored from what [`Job::save`] gave.
//! 2. The scheduler calls [`Job::ask`]. It puts the requests of jobs that are equal in their [`Stage`] into one batch, and
//!    hands that to the device. While the device works, jobs are not changed; they may be saved.
//! 3. The scheduler calls [`Job::tell`] with the job's own share of the results, on any thread. The job takes its step as
//!    a whole: it advances, or it fails and the run ends. What the step added to the job's tables goes to the recorder at
//!    once, before the next step.
//! 4. Steps 2 and 3 repeat until `ask` gives nothing. Then [`Job::finish`] is called once.
//!
//! [`Job::save`] may be called between any two steps: before the first `ask`, while a request is being evaluated (its
//! results are then lost, and asked for again after a restore), and after the last step, before `finish`. A restored job
//! asks for exactly what the saved one would have asked for. What the recorder holds is saved beside the job, so a job
//! doesn't save its tables.
//!
//! The results of a job are a function of what it is and of its seed: never of the batches it shared, of the number of
//! threads, or of where it was saved and restored.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use oneiro::batch::{Record, Rollout, TraceRequest, WorldKind};
use serde::{Deserialize, Serialize};

use crate::exit::Result;

/// A state machine that asks for evaluations, takes their results, and can be saved and restored between any two steps.
pub(crate) trait Job: Send {
    /// The next request, or nothing once the job is finished. Cheap: it is called several times a step.
    fn ask(&self) -> Option<Request<'_>>;

    /// Takes the results of the last request, which are of its rollouts in their order, and advances by one step.
    ///
    /// # Errors
    /// Results that can't be: nothing of the job has changed then, and its run ends.
    fn tell(&mut self, results: &Results<'_>) -> Result<Step>;

    /// All that is needed to restore the job, with its experiment and its seed. Whoever stores these bytes adds a header
    /// and a hash; the job adds a version where its own format may change.
    fn save(&self) -> Vec<u8>;

    /// The results of a finished job: called once, after `ask` gave nothing. `table` is the job's
    /// [table of steps](Added), its first line and all that steps added, also before the job was restored.
    ///
    /// # Errors
    /// As the job says.
    fn finish(&mut self, table: &str) -> Result<Finished>;
}

impl Job for Box<dyn Job> {
    fn ask(&self) -> Option<Request<'_>> {
        (**self).ask()
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

/// What a job wants evaluated next.
pub(crate) struct Request<'a> {
    /// Requests of equal stages may share a batch.
    pub(crate) stage: Stage,
    /// The worlds that the rollouts live in; a rollout's `world` is an index of these.
    pub(crate) worlds: &'a [Place],
    /// The rollouts, in the order in which their results are to come.
    pub(crate) rollouts: Box<dyn Iterator<Item = Rollout<'a>> + 'a>,
    /// For a stretch of lives that have begun: what each rollout's [`Results::states`] were after the stretch before.
    pub(crate) states: &'a [Vec<u32>],
    /// Robot-steps of all rollouts: how much room in a batch the request takes.
    pub(crate) steps: u64,
}

/// What requests that share a batch have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stage {
    /// The name of the worlds' kernel.
    pub(crate) kernel: &'static str,
    /// How far the job is, where jobs that are equally far go on together: the cycle that a swarm has reached. 0 for jobs
    /// whose steps are all alike, such as generations.
    pub(crate) reached: u32,
    /// The cycles that are lived, of worlds whose lives are cut into stretches; nothing for whole lives.
    pub(crate) cycles: Option<[u32; 2]>,
    /// Cycles from one record of a trace to the next; nothing without a trace.
    pub(crate) trace_every: Option<u32>,
}

impl Stage {
    /// Whole lives without a trace, of jobs whose steps are all alike.
    pub(crate) fn lives(kernel: &'static str) -> Self {
        Self {
            kernel,
            reached: 0,
            cycles: None,
            trace_every: None,
        }
    }

    /// The stretch of cycles, if lives are cut.
    pub(super) fn stretch(&self) -> Option<Range<u32>> {
        self.cycles.map(|[first, end]| first..end)
    }

    /// What is asked of the evaluator besides fitness.
    pub(super) fn trace(&self) -> Option<TraceRequest> {
        self.trace_every.map(|every| TraceRequest { every })
    }
}

/// A world of a request. Places with equal keys are one world: it is packed once, and rollouts of several jobs share the
/// device's groups of lanes.
#[derive(Clone)]
pub(crate) struct Place {
    /// The hash of all that decides how rollouts live in it.
    pub(crate) key: blake3::Hash,
    /// The world.
    pub(crate) world: Arc<dyn WorldKind + Send + Sync>,
}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.key, self.world.kernel().name)
    }
}

/// What came of a request: a value for each of its rollouts, in their order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Results<'a> {
    /// Fitness.
    pub(crate) fitness: &'a [f32],
    /// Traces of single lives; none unless asked for.
    pub(crate) traces: &'a [Vec<Record>],
    /// Traces of worlds of several robots, as words of lines; none unless asked for.
    pub(crate) logs: &'a [Vec<u32>],
    /// Words from one line of a log to the next: at least as many as the world's own lines have.
    pub(crate) log_words: usize,
    /// What each rollout is to go on with; none of whole lives. They may be longer than the world's own state: the
    /// engine cuts and pads what comes back in [`Request::states`].
    pub(crate) states: &'a [Vec<u32>],
}

/// What one step of a job gave.
#[derive(Debug, Default)]
pub(crate) struct Step {
    /// What is added to the job's tables.
    pub(crate) added: Vec<Added>,
    /// What people are shown; nothing if nothing has changed for them.
    pub(crate) progress: Option<Progress>,
    /// Whether a run that has a directory of its own should be saved here. A shard of a sweep has a clock of its own.
    pub(crate) is_checkpoint: bool,
}

/// Bytes for the end of one of a job's tables: files that only grow. One of them is the table of steps that
/// [`Job::finish`] gets: the generations of an evolution, the intervals of a swarm. Which it is, and how each begins, the
/// kind of experiment says.
#[derive(Debug)]
pub(crate) struct Added {
    /// The file's name in a run's directory.
    pub(crate) file: &'static str,
    /// Whole lines, or whole values.
    pub(crate) bytes: Vec<u8>,
}

/// How far a job is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Progress {
    /// Steps of those that people count: generations of an evolution, minutes of a swarm.
    pub(crate) done: u32,
    /// The best so far: the champion's fitness, the swarm's food.
    pub(crate) best: f32,
}

/// What a finished job gave.
#[derive(Debug, Default)]
pub(crate) struct Finished {
    /// Files that are written once, and their contents; those of its tables not among them.
    pub(crate) files: Vec<(&'static str, Vec<u8>)>,
    /// Its row in a sweep's table of results: a cell for each column that its kind of experiment names.
    pub(crate) cells: Vec<String>,
    /// The champion's genes; none where there is no champion.
    pub(crate) champion: Vec<f32>,
}
