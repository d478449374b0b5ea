//! The engine's only loop: jobs of all kinds share the device. Jobs whose next requests may share a batch form a group.
//! Groups take turns: while the device evaluates one, this thread lets the jobs of another take their step, records the
//! results, and lets waiting runs join.

use std::collections::{HashMap, VecDeque};
use std::time::{Duration, Instant};

use oneiro::batch::{Outcome, Rollout, WorldKind, Worlds};
use oneiro::evaluator;
use oneiro_base::exit::{Failure, Result};
use rayon::prelude::*;

use super::job::{Job, Place, Progress, Request, Results, Stage, Step};
use super::queue::{Interruption, Lives, Queue, Work};
use super::watcher::Watch;

/// Target duration of a batch, long enough to hide the cost of handing it over.
const BATCH: Duration = Duration::from_millis(30);
/// Batches expected to take less than this are evaluated on the scheduler's own thread.
const SHORT: Duration = Duration::from_millis(5);
/// Robot-steps of a batch before the device's speed is known, and their minimum and maximum.
const FIRST_ROOM: f64 = 4e6;
const ROOM: [f64; 2] = [1e6, 4e9];
/// Maximum number of episodes in a batch, unless a single job has more: with 18 genes they take about 120 MB, and fill any device.
const MOST_LIVES: usize = 1 << 20;
/// Number of jobs that are worth waking a thread for.
const FEW: usize = 16;
/// Maximum number of groups: two keep the device busy, others are remainders at other stages.
const GROUPS: usize = 4;

/// Index of a run given to the scheduler.
pub(crate) type RunNumber = usize;

/// Time that the engine's thread has spent, by what it did or let other threads do.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// Jobs took their steps: an evolution selects and mutates.
    pub advance: Duration,
    /// Their requests were packed into batches.
    pub pack: Duration,
    /// What they added was recorded.
    pub record: Duration,
    /// It waited for the device.
    pub wait: Duration,
}

/// Does something, and adds how long it took.
fn timed<T>(time: &mut Duration, work: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let done = work();
    *time += began.elapsed();
    done
}

/// A run that has not begun.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    pub run: RunNumber,
    /// Kernel of its first request.
    pub kernel: &'static str,
}

/// The scheduler's source of jobs and recorder of their results: run directories are one implementation, a shard of a
/// sweep is another.
pub trait Runs {
    /// Type of the jobs: of one kind, or boxed.
    type Job: Job;
    /// Where the steps of a run in progress are recorded.
    type Record: Record<Self::Job>;

    /// Begins a run, or resumes it from where it was saved.
    ///
    /// # Errors
    /// As the implementation says; all work ends.
    fn begin(&mut self, run: RunNumber) -> Result<(Self::Job, Self::Record)>;

    /// Records the results of finished runs. All their steps have been recorded.
    ///
    /// # Errors
    /// As [`Record::add`].
    fn finish(&mut self, finished: Vec<UnderWay<Self>>) -> Result;

    /// Called from time to time with all runs in progress, whose steps have all been recorded; may save them.
    ///
    /// # Errors
    /// As [`Record::add`].
    fn pause(&mut self, _under_way: &[&UnderWay<Self>]) -> Result {
        Ok(())
    }

    /// Called at the end with the runs still in progress, to save them: none if all runs are finished, or all that had
    /// begun when the user or the device ended the work.
    ///
    /// # Errors
    /// As [`Record::add`].
    fn end(&mut self, under_way: Vec<&mut UnderWay<Self>>) -> Result;

    /// Message that tells the user how to continue after a stop.
    fn stopped(&self) -> String;
}

/// The record of a run in progress. Those of several runs are written at the same time.
pub trait Record<J>: Send + Sync {
    /// Records a step. The job has taken this step, and no later one yet.
    ///
    /// # Errors
    /// Exit 6 if writing fails; all work ends.
    fn add(&mut self, job: &J, step: Step) -> Result;
}

/// A run that has begun and isn't finished.
pub struct UnderWay<R: Runs + ?Sized> {
    pub run: RunNumber,
    pub job: R::Job,
    pub record: R::Record,
}

/// Jobs that exist before they are run and stay in memory; they hold all of their results.
pub(super) struct InMemory<J>(pub(super) Vec<Option<J>>);

/// Nothing is recorded.
impl<J> Record<J> for () {
    fn add(&mut self, _: &J, _: Step) -> Result {
        Ok(())
    }
}

impl<J: Job> Runs for InMemory<J> {
    type Job = J;
    type Record = ();

    fn begin(&mut self, run: RunNumber) -> Result<(J, ())> {
        let job = self.0.get_mut(run).and_then(Option::take);
        let job = job.ok_or_else(|| Failure::failed("a job was begun twice"))?;
        Ok((job, ()))
    }

    fn finish(&mut self, finished: Vec<UnderWay<Self>>) -> Result {
        for UnderWay { run, job, .. } in finished {
            self.0[run] = Some(job);
        }
        Ok(())
    }

    fn end(&mut self, _: Vec<&mut UnderWay<Self>>) -> Result {
        Ok(())
    }

    fn stopped(&self) -> String {
        "stopped; run the same command again".into()
    }
}

/// As [`super::handle::Engine::run`].
pub(super) fn run<R: Runs>(
    waiting: Vec<Waiting>,
    most: usize,
    runs: &mut R,
    queue: Queue<'_>,
    watch: &mut dyn Watch,
) -> Result {
    let mut scheduler = Scheduler {
        room: Room::new(most, waiting.len()),
        queues: Queues::new(waiting),
        groups: VecDeque::new(),
        ready: Vec::new(),
        finished: Vec::new(),
        runs,
        queue,
        times: Times::default(),
    };
    let ended = scheduler.work(watch);
    watch.ended(&scheduler.times);
    let ended = match ended {
        Err(Interruption::Other(failure)) => return Err(failure),
        ended => ended,
    };
    let saved = scheduler.end();
    match ended {
        Ok(()) => saved,
        Err(Interruption::Evaluation(evaluator::Error::Cancelled)) => {
            saved.and_then(|()| Err(Failure::stopped(scheduler.runs.stopped())))
        }
        Err(Interruption::Evaluation(error)) => saved.and_then(|()| Err(error.into())),
        // A robot that can't be stopped must be known, whatever else fails.
        Err(Interruption::Outside(failure) | Interruption::Other(failure)) => {
            Err(saved.err().into_iter().fold(failure, Failure::and))
        }
    }
}

/// A run in progress, with its next request and its latest step.
struct Entry<R: Runs> {
    own: UnderWay<R>,
    /// Its next request; `None` once it is finished.
    next: Option<Next>,
    /// Step that has not been recorded yet.
    step: Option<Step>,
}

/// Summary of a job's next request.
#[derive(Clone, Copy)]
struct Next {
    stage: Stage,
    lives: usize,
    steps: u64,
}

impl<R: Runs> Entry<R> {
    fn new(run: RunNumber, (job, record): (R::Job, R::Record)) -> Self {
        let mut entry = Self {
            own: UnderWay { run, job, record },
            next: None,
            step: None,
        };
        entry.look();
        entry
    }

    fn look(&mut self) {
        self.next = self.own.job.ask().map(|request| Next {
            stage: request.stage,
            lives: request.lives,
            steps: request.steps,
        });
    }

    /// Takes a step.
    fn tell(&mut self, results: &Results<'_>) -> Result {
        self.step = Some(self.own.job.tell(results)?);
        self.look();
        Ok(())
    }

    /// Records its step. Returns the progress made.
    fn record(&mut self) -> Result<Option<Progress>> {
        let Some(step) = self.step.take() else {
            return Ok(None);
        };
        let progress = step.progress;
        self.own.record.add(&self.own.job, step)?;
        Ok(progress)
    }

    fn is_at(&self, stage: &Stage) -> bool {
        self.next.is_some_and(|next| next.stage == *stage)
    }

    fn steps(&self) -> f64 {
        self.next.map_or(0.0, |next| next.steps as f64)
    }

    fn lives(&self) -> usize {
        self.next.map_or(0, |next| next.lives)
    }
}

/// The room in a batch that the next requests of some jobs need.
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    jobs: usize,
    lives: usize,
    /// Robot-steps.
    steps: f64,
}

impl Load {
    fn of<'a, R: Runs + 'a>(entries: impl IntoIterator<Item = &'a Entry<R>>) -> Self {
        entries.into_iter().fold(Self::default(), Self::and)
    }

    /// With another job.
    fn and<R: Runs>(self, entry: &Entry<R>) -> Self {
        Self {
            jobs: self.jobs + 1,
            lives: self.lives + entry.lives(),
            steps: self.steps + entry.steps(),
        }
    }
}

/// Jobs whose requests are in one batch on the device.
struct Group<R: Runs> {
    stage: Stage,
    entries: Vec<Entry<R>>,
    /// Number of episodes of each entry.
    counts: Vec<usize>,
    load: Load,
    /// Words per line of a log.
    log_words: usize,
    packed: Vec<Packed>,
}

/// Packed worlds of one kernel, and the index of each place in them.
pub(super) struct Packed {
    pub(super) kernel: &'static str,
    pub(super) worlds: Worlds,
    indices: HashMap<[u8; blake3::OUT_LEN], usize>,
}

impl Packed {
    pub(super) fn new(requests: &[Request<'_>], kernel: &'static str) -> Result<Self> {
        let mut indices = HashMap::new();
        let mut places = Vec::new();
        for place in requests.iter().flat_map(|request| request.worlds) {
            indices.entry(*place.key.as_bytes()).or_insert_with(|| {
                places.push(place);
                places.len() - 1
            });
        }
        let worlds: Vec<&dyn WorldKind> = places.iter().map(|place| &*place.world as &dyn WorldKind).collect();
        Ok(Self {
            kernel,
            worlds: Worlds::new(&worlds)?,
            indices,
        })
    }

    pub(super) fn index(&self, place: &Place) -> Option<usize> {
        self.indices.get(place.key.as_bytes()).copied()
    }

    /// The episodes of the next requests of some jobs.
    fn rollouts<'a, R: Runs>(&self, entries: &'a [Entry<R>]) -> Vec<Rollout<'a>> {
        let mut rollouts = Vec::with_capacity(entries.iter().map(Entry::lives).sum());
        let mut indices: Vec<usize> = Vec::new();
        for entry in entries {
            let job = &entry.own.job;
            indices.clear();
            let places = job.ask().map_or(&[][..], |request| request.worlds);
            indices.extend(places.iter().filter_map(|place| self.index(place)));
            let before = rollouts.len();
            job.rollouts(&mut rollouts);
            debug_assert_eq!(rollouts.len() - before, entry.lives(), "as many as it said");
            for rollout in &mut rollouts[before..] {
                rollout.world = indices[rollout.world];
            }
        }
        rollouts
    }
}

impl<R: Runs> Group<R> {
    /// Packs the next requests of jobs, all of one stage.
    fn new(stage: Stage, entries: Vec<Entry<R>>, mut packed: Vec<Packed>) -> Result<(Self, Work)> {
        if stage == Stage::OUTSIDE {
            return Ok(Self::outside(entries, packed));
        }
        let requests: Vec<Request<'_>> = entries.iter().filter_map(|entry| entry.own.job.ask()).collect();
        let fits = |known: &Packed| {
            let mut places = requests.iter().flat_map(|request| request.worlds);
            known.kernel == stage.kernel && places.all(|place| known.index(place).is_some())
        };
        if !packed.iter().any(fits) {
            packed.retain(|known| known.kernel != stage.kernel);
            packed.push(Packed::new(&requests, stage.kernel)?);
        }
        let own = packed.iter().find(|known| known.kernel == stage.kernel);
        let own = own.ok_or_else(|| Failure::failed("a batch has no worlds"))?;
        // Some lists for each processor, so that all have something to do to the end.
        let share = entries.len().div_ceil(8 * rayon::current_num_threads()).max(FEW);
        let lists = on_all(entries.chunks(share).collect(), 1, |entries| Ok(own.rollouts(entries)))?;
        let batch = match stage.stretch() {
            None => own.worlds.batch_of(&lists, stage.trace())?,
            Some(cycles) => {
                let mut states: Vec<_> = requests.iter().flat_map(|request| request.states).cloned().collect();
                // Worlds that share a batch have states of the same length: that of the largest.
                let words = own.worlds.state_words();
                for state in &mut states {
                    state.resize(words, 0);
                }
                own.worlds.stretch_of(&lists, cycles, &states, stage.trace())?
            }
        };
        let group = Self {
            stage,
            counts: entries.iter().map(Entry::lives).collect(),
            load: Load::of(&entries),
            log_words: batch.record_words(),
            entries,
            packed,
        };
        Ok((group, Work::Batch(batch)))
    }

    /// The next requests of jobs whose episodes run outside of the device.
    fn outside(entries: Vec<Entry<R>>, packed: Vec<Packed>) -> (Self, Work) {
        let mut lives: Vec<Lives> = Vec::new();
        for job in entries.iter().map(|entry| &entry.own.job) {
            if let Some(outside) = job.ask().and_then(|request| request.outside) {
                let mut rollouts = Vec::new();
                job.rollouts(&mut rollouts);
                lives.push(Lives::new(outside, &rollouts));
            }
        }
        let group = Self {
            stage: Stage::OUTSIDE,
            counts: lives.iter().map(Lives::len).collect(),
            load: Load::of(&entries),
            log_words: 0,
            entries,
            packed,
        };
        (group, Work::Outside(lives))
    }

    /// Lets all of its jobs take their step.
    fn tell(&mut self, outcome: &Outcome) -> Result {
        let mut rest = 0;
        let shares = self.counts.iter().map(|count| {
            rest += count;
            rest - count..rest
        });
        let log_words = self.log_words;
        on_all(self.entries.iter_mut().zip(shares).collect(), FEW, |(entry, own)| {
            entry.tell(&Results {
                fitness: outcome.fitness.get(own.clone()).unwrap_or_default(),
                traces: outcome.traces.get(own.clone()).unwrap_or_default(),
                logs: outcome.logs.get(own.clone()).unwrap_or_default(),
                log_words,
                states: outcome.states.get(own).unwrap_or_default(),
            })
        })?;
        Ok(())
    }
}

/// Does something with all items, on all processors if there are more than `few`: in pieces of half as many, small enough that
/// all processors finish together. Of several errors it returns that of the first item.
fn on_all<T: Send, U: Send>(items: Vec<T>, few: usize, work: impl Fn(T) -> Result<U> + Send + Sync) -> Result<Vec<U>> {
    let done: Vec<Result<U>> = if items.len() > few {
        items.into_par_iter().with_max_len(few.div_ceil(2)).map(work).collect()
    } else {
        items.into_iter().map(work).collect()
    };
    done.into_iter().collect()
}

/// Waiting runs, by the kernel that they begin with, each queue in the given order.
struct Queues(Vec<(&'static str, VecDeque<RunNumber>)>);

impl Queues {
    fn new(waiting: Vec<Waiting>) -> Self {
        let mut queues: Vec<(&'static str, VecDeque<RunNumber>)> = Vec::new();
        for Waiting { run, kernel } in waiting {
            match queues.iter_mut().find(|(known, _)| *known == kernel) {
                Some((_, queue)) => queue.push_back(run),
                None => queues.push((kernel, VecDeque::from([run]))),
            }
        }
        Self(queues)
    }

    /// A kernel that runs are waiting for.
    fn kernel(&self) -> Option<&'static str> {
        self.0
            .iter()
            .find(|(_, queue)| !queue.is_empty())
            .map(|(kernel, _)| *kernel)
    }

    /// Whether any waiting run could join a stage, which requires a stage that jobs begin with.
    fn has(&self, stage: &Stage) -> bool {
        let is_own = |(kernel, queue): &(&str, VecDeque<_>)| *kernel == stage.kernel && !queue.is_empty();
        stage.reached == 0 && self.0.iter().any(is_own)
    }

    fn next(&mut self, kernel: &str) -> Option<RunNumber> {
        let (_, queue) = self.0.iter_mut().find(|(known, _)| *known == kernel)?;
        queue.pop_front()
    }
}

/// Room in batches.
struct Room {
    /// Robot-steps of a batch.
    steps: f64,
    /// Maximum number of jobs of a group, and of all groups together.
    jobs: usize,
    all: usize,
    last: Instant,
    /// Seconds that a robot-step of the last batch took.
    pace: f64,
}

impl Room {
    fn new(most: usize, waiting: usize) -> Self {
        Self {
            steps: FIRST_ROOM,
            jobs: most.min(waiting).div_ceil(2),
            all: most,
            last: Instant::now(),
            pace: f64::INFINITY,
        }
    }

    /// Measures the device's speed by a returned batch of `steps` robot-steps.
    fn learn(&mut self, steps: f64) {
        let took = self.last.elapsed().as_secs_f64();
        self.last = Instant::now();
        self.pace = took / steps;
        let aim = steps / took.max(1e-6) * BATCH.as_secs_f64();
        self.steps = (0.75 * self.steps + 0.25 * aim).clamp(ROOM[0], ROOM[1]);
    }

    /// Whether a batch with this load is so short that it need not be interruptible.
    fn is_short(&self, load: Load) -> bool {
        load.steps * self.pace < SHORT.as_secs_f64()
    }

    /// Whether a batch with this load has room for another job.
    fn has(&self, load: Load) -> bool {
        load.jobs == 0 || (load.jobs < self.jobs && load.lives < MOST_LIVES && load.steps < self.steps)
    }
}

/// Everything in progress.
struct Scheduler<'a, R: Runs> {
    queues: Queues,
    room: Room,
    /// Groups whose batches are with the device, in order.
    groups: VecDeque<Group<R>>,
    /// Jobs waiting for a batch of their stage.
    ready: Vec<Entry<R>>,
    /// Finished jobs that have not been recorded as such.
    finished: Vec<Entry<R>>,
    runs: &'a mut R,
    queue: Queue<'a>,
    times: Times,
}

impl<R: Runs> Scheduler<'_, R> {
    fn work(&mut self, watch: &mut dyn Watch) -> std::result::Result<(), Interruption> {
        loop {
            self.send_groups()?;
            self.record(watch)?;
            let Some(group) = self.groups.front() else {
                return Ok(());
            };
            let steps = group.load.steps;
            let outcome = timed(&mut self.times.wait, || self.queue.receive(watch))?;
            self.room.learn(steps);
            if let Some(mut group) = self.groups.pop_front() {
                timed(&mut self.times.advance, || group.tell(&outcome))?;
                self.go_on(group)?;
            }
        }
    }

    /// Sends a group off again, without the jobs that are finished or have come to another stage, and with others instead.
    fn go_on(&mut self, group: Group<R>) -> Result {
        let mut entries = group.entries;
        self.finished.extend(entries.extract_if(.., |own| own.next.is_none()));
        let stays = entries.iter().any(|own| own.is_at(&group.stage));
        let first = entries.first().and_then(|own| own.next).map(|next| next.stage);
        let Some(stage) = first.map(|first| if stays { group.stage } else { first }) else {
            return Ok(());
        };
        self.ready.extend(entries.extract_if(.., |own| !own.is_at(&stage)));
        // Jobs may ask for more episodes than before.
        while entries.len() > 1 && Load::of(&entries).lives > MOST_LIVES {
            let half = entries.split_off(entries.len() / 2);
            self.ready.extend(half);
        }
        let entries = self.joined(entries, &stage)?;
        self.send(stage, entries, group.packed)
    }

    /// Sends groups off while the device has less than two large batches to do.
    fn send_groups(&mut self) -> Result {
        loop {
            let stage = if self.groups.len() >= GROUPS {
                return Ok(());
            } else if let Some(full) = self.full_stage() {
                full
            } else if !self.wants_group() {
                return Ok(());
            } else if let Some(begun) = self.begun_stage()? {
                begun
            } else if let Some(next) = self.ready.first().and_then(|own| own.next) {
                next.stage
            } else {
                return Ok(());
            };
            let entries = self.joined(Vec::new(), &stage)?;
            self.send(stage, entries, Vec::new())?;
        }
    }

    /// A stage for which enough jobs are ready to fill a batch.
    fn full_stage(&self) -> Option<Stage> {
        let stages = self.ready.iter().filter_map(|own| own.next).map(|next| next.stage);
        let is_full = |stage: &Stage| {
            !self
                .room
                .has(Load::of(self.ready.iter().filter(|own| own.is_at(stage))))
        };
        let mut looked_at: Vec<Stage> = Vec::new();
        for stage in stages {
            if !looked_at.contains(&stage) {
                if is_full(&stage) {
                    return Some(stage);
                }
                looked_at.push(stage);
            }
        }
        None
    }

    /// Whether the device would soon be idle: fewer than two groups are large or can grow.
    fn wants_group(&self) -> bool {
        let lasts = |group: &&Group<R>| !self.room.has(group.load) || self.queues.has(&group.stage);
        self.groups.iter().filter(lasts).count() < 2
    }

    /// Begins the next run, if one is waiting and there is room for it. Returns its first stage.
    fn begun_stage(&mut self) -> Result<Option<Stage>> {
        while let Some(kernel) = self.queues.kernel()
            && self.under_way() < self.room.all
        {
            if self.begin(kernel)?
                && let Some(next) = self.ready.last().and_then(|own| own.next)
            {
                return Ok(Some(next.stage));
            }
        }
        Ok(None)
    }

    /// Begins a run of a kernel. Returns whether it is ready now.
    fn begin(&mut self, kernel: &str) -> Result<bool> {
        let Some(run) = self.queues.next(kernel) else {
            return Ok(false);
        };
        let entry = Entry::new(run, self.runs.begin(run)?);
        let is_ready = entry.next.is_some();
        if is_ready {
            self.ready.push(entry);
        } else {
            self.finished.push(entry);
        }
        Ok(is_ready)
    }

    /// Adds jobs of a stage as long as there is room: first those that are ready, then waiting runs.
    fn joined(&mut self, mut entries: Vec<Entry<R>>, stage: &Stage) -> Result<Vec<Entry<R>>> {
        let mut load = Load::of(&entries);
        let mut ready = std::mem::take(&mut self.ready).into_iter();
        while self.room.has(load)
            && let Some(entry) = ready.next()
        {
            if entry.is_at(stage) {
                load = load.and(&entry);
                entries.push(entry);
            } else {
                self.ready.push(entry);
            }
        }
        self.ready.extend(ready);
        while self.queues.has(stage) && self.under_way() + entries.len() < self.room.all && self.room.has(load) {
            if !self.begin(stage.kernel)? {
                continue;
            }
            let Some(entry) = self.ready.pop_if(|own| own.is_at(stage)) else {
                // It was saved at another stage, or its stage covers other cycles.
                break;
            };
            load = load.and(&entry);
            entries.push(entry);
        }
        Ok(entries)
    }

    /// Number of jobs that have begun and not finished.
    fn under_way(&self) -> usize {
        let groups = self.groups.iter().map(|group| group.entries.len());
        groups.sum::<usize>() + self.ready.len()
    }

    fn send(&mut self, stage: Stage, entries: Vec<Entry<R>>, packed: Vec<Packed>) -> Result {
        let (group, work) = timed(&mut self.times.pack, || Group::new(stage, entries, packed))?;
        self.queue.submit(work, self.room.is_short(group.load));
        self.groups.push_back(group);
        Ok(())
    }

    /// Records all steps that jobs have taken, after the device has got its next batch.
    fn record(&mut self, watch: &mut dyn Watch) -> Result {
        let began = Instant::now();
        let groups = self.groups.iter_mut().flat_map(|group| &mut group.entries);
        let all = groups.chain(&mut self.ready).chain(&mut self.finished);
        let new: Vec<_> = all.filter(|entry| entry.step.is_some()).collect();
        let has_advanced = !new.is_empty();
        for progress in on_all(new, FEW, Entry::record)?.into_iter().flatten() {
            watch.advanced(progress);
        }
        let finished: Vec<_> = self.finished.drain(..).map(|entry| entry.own).collect();
        if !finished.is_empty() {
            self.runs.finish(finished)?;
        }
        if has_advanced {
            let groups = self.groups.iter().flat_map(|group| &group.entries);
            let under_way: Vec<_> = groups.chain(&self.ready).map(|entry| &entry.own).collect();
            self.runs.pause(&under_way)?;
        }
        self.times.record += began.elapsed();
        Ok(())
    }

    fn end(&mut self) -> Result {
        let groups = self.groups.iter_mut().flat_map(|group| &mut group.entries);
        let under_way = groups.chain(&mut self.ready).map(|entry| &mut entry.own).collect();
        self.runs.end(under_way)
    }
}
