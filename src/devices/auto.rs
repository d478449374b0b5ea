//! The CPU and a GPU side by side: each batch goes to the one expected to finish it earlier.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use oneiro_shaders::Kernel;

use crate::batch::{Batch, Observer, Outcome, Part, PartResult};
use crate::devices::background;
use crate::evaluator::{Control, Device, Error, Evaluator, pass_on};

/// Shortest CPU time, in seconds, of a batch that may go to the GPU, which takes about as long for a single episode (`docs/gpu.md`).
const LEAST_CPU_TIME: f64 = 0.001;
/// CPU time, in seconds, spent on such batches of a kind before the GPU is tried: about as long as opening it or compiling takes.
const PATIENCE: f64 = 0.25;
/// Robot-steps per CPU thread from which the GPU is opened at once while the CPU's speed is unknown: at least 0.1 s of its work. The CPU
/// then does so many at a time.
const MANY_STEPS: u64 = 10_000_000;
/// CPU time, in seconds, of a piece of a batch while the GPU is being opened, which takes 1.3 to 1.6 s (`docs/gpu.md`).
const PIECE: f64 = 0.1;
/// Every 64th batch goes to the slower device, to keep its time up to date.
const REMEASURE_EVERY: u32 = 64;
/// A device that is slower by at least this factor is not measured again.
const GIVE_UP_RATIO: f64 = 4.0;
/// Number of measurements before a device is given up.
const GIVE_UP_AFTER: u32 = 3;

/// Seconds since some moment. Tests count them, since a loaded machine would change which device is the faster one.
type Clock = Box<dyn Fn() -> f64 + Send>;

/// Opens the GPU, or returns the reason why it can't be used.
pub type Opener = Box<dyn FnOnce() -> Result<Box<dyn Evaluator>, String> + Send>;

/// Evaluates each batch on the CPU or on a GPU, judging by how long earlier batches of the same kernel took on either. The GPU is opened
/// once there is enough work for it, and the CPU works on meanwhile. Results don't depend on the choice. If the GPU fails, the CPU takes
/// over.
pub struct Auto {
    cpu: Member,
    gpu: Gpu,
    /// The GPU's name.
    name: String,
    /// Of the CPU.
    threads: usize,
    /// CPU time spent on batches that may go to the GPU, in seconds.
    spent: BTreeMap<Kind, f64>,
    clock: Clock,
    warnings: Vec<String>,
}

enum Gpu {
    /// Not needed so far.
    Closed(Opener),
    Opening(background::Work<Result<Box<dyn Evaluator>, String>>),
    Open(Member),
    /// It can't be used, as a warning says.
    Gone,
}

/// One of the two devices.
struct Member {
    evaluator: Box<dyn Evaluator>,
    /// Whether its time is proportional to the robot-steps of a batch. A GPU takes about as long for one episode as for thousands.
    is_proportional: bool,
    /// By the binary logarithm of a batch's robot-steps. Empty after the first batch of a kind, which may include compiling.
    timings: BTreeMap<Kind, BTreeMap<u32, Timing>>,
    /// Number of its warnings that have been passed on.
    heard: usize,
}

/// Batches of one kind take about the same time per step: they have the same kernel and return the same things.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    kernel: &'static str,
    is_traced: bool,
    keeps_states: bool,
}

/// Time of batches of one kind and size.
#[derive(Clone, Copy)]
struct Timing {
    /// Latest time in seconds, at most twice the one before, since a single slow batch may have had other reasons.
    seconds: f64,
    measurements: u32,
}

impl Kind {
    fn of(part: &Part<'_>) -> Self {
        Self {
            kernel: part.kernel().name,
            is_traced: part.trace_every() > 0,
            keeps_states: part.batch().keeps_states(),
        }
    }
}

/// The binary logarithm of a part's robot-steps.
fn size(part: &Part<'_>) -> u32 {
    part.steps().max(1).ilog2()
}

impl Auto {
    /// Combines the CPU's evaluator, which has `threads` threads, and a GPU of this name, which is opened when it is needed.
    pub fn new(cpu: Box<dyn Evaluator>, threads: usize, name: String, opener: Opener) -> Self {
        let start = Instant::now();
        Self {
            cpu: Member::new(cpu, true),
            gpu: Gpu::Closed(opener),
            name,
            threads,
            spent: BTreeMap::new(),
            clock: Box::new(move || start.elapsed().as_secs_f64()),
            warnings: Vec::new(),
        }
    }

    /// Adds the GPU's name to the CPU's description, unless it can't be used.
    fn with_gpu(&self, cpu: Device) -> Device {
        if matches!(self.gpu, Gpu::Gone) {
            return cpu;
        }
        Device {
            name: format!("{} or {}", cpu.name, self.name),
            ..cpu
        }
    }

    fn many_steps(&self) -> u64 {
        MANY_STEPS * self.threads as u64
    }

    /// Whether to try the GPU on a part, given the CPU's expected time in seconds, if known.
    fn is_worth_trying(&self, part: &Part<'_>, expected: Option<f64>) -> bool {
        let spent = self.spent.get(&Kind::of(part)).copied().unwrap_or_default();
        match expected {
            None => part.steps() >= self.many_steps(),
            Some(time) => time >= PATIENCE || (time >= LEAST_CPU_TIME && spent >= PATIENCE),
        }
    }

    /// Begins to open the GPU, or takes the one that was opened meanwhile.
    fn open(&mut self) {
        self.gpu = match std::mem::replace(&mut self.gpu, Gpu::Gone) {
            Gpu::Closed(open) => Gpu::Opening(background::Work::begin(open)),
            Gpu::Opening(mut work) => match work.result(Duration::ZERO) {
                None => Gpu::Opening(work),
                Some(Ok(gpu)) => Gpu::Open(Member::new(gpu, false)),
                Some(Err(reason)) => {
                    let warning = format!("{}: {reason}; the CPU evaluates everything", self.name);
                    self.warnings.push(warning);
                    Gpu::Gone
                }
            },
            known => known,
        };
    }

    /// Number of a part's groups that the CPU does before the GPU is thought of again.
    fn piece(&self, part: &Part<'_>) -> u32 {
        let all = part.groups().len();
        let share = match (&self.gpu, self.cpu.expected(part)) {
            (Gpu::Open(_) | Gpu::Gone, _) => return all as u32,
            (_, Some(time)) => PIECE / time,
            (_, None) => self.many_steps() as f64 / part.steps() as f64,
        };
        ((all as f64 * share) as usize).clamp(self.threads.min(all), all) as u32
    }

    /// Whether the GPU gets a part.
    fn is_for_gpu(&mut self, part: &Part<'_>) -> bool {
        let expected = self.cpu.expected(part);
        let is_worth_trying = self.is_worth_trying(part, expected);
        if is_worth_trying {
            self.open();
        }
        let Gpu::Open(gpu) = &self.gpu else { return false };
        let (Some(here), Some(there)) = (expected, gpu.expected(part)) else {
            return is_worth_trying;
        };
        if here < LEAST_CPU_TIME {
            return false;
        }
        let is_sooner = there < here;
        let (Some(here), Some(there)) = (self.cpu.timing(part), gpu.timing(part)) else {
            return is_sooner;
        };
        let (fast, slow) = if is_sooner { (there, here) } else { (here, there) };
        let is_due = (fast.measurements + slow.measurements).is_multiple_of(REMEASURE_EVERY);
        let is_given_up = slow.measurements >= GIVE_UP_AFTER && slow.seconds >= GIVE_UP_RATIO * fast.seconds;
        is_sooner != (is_due && !is_given_up)
    }

    /// Runs a part on the GPU. `None` if it can't, and the CPU must.
    fn on_gpu(&mut self, part: &Part<'_>, control: &Control) -> Option<Result<PartResult, Error>> {
        let Gpu::Open(gpu) = &mut self.gpu else { return None };
        let done = gpu.evaluate(part, control, &self.clock, &mut self.warnings);
        match done {
            Err(error @ Error::TooLarge(_)) => self.warnings.push(format!("{error}; the CPU evaluates this batch")),
            Err(error @ Error::NoDevice(_)) => {
                self.warnings
                    .push(format!("{error}; from now on the CPU evaluates everything"));
                self.gpu = Gpu::Gone;
            }
            done => return Some(done.map(|(result, _)| result)),
        }
        None
    }
}

impl Auto {
    /// Runs a part on the CPU.
    fn on_cpu(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        let (result, seconds) = self.cpu.evaluate(part, control, &self.clock, &mut self.warnings)?;
        self.count(part, seconds);
        Ok(result)
    }

    /// Counts CPU time that the GPU might have saved.
    fn count(&mut self, part: &Part<'_>, seconds: f64) {
        if seconds >= LEAST_CPU_TIME {
            *self.spent.entry(Kind::of(part)).or_default() += seconds;
        }
    }
}

impl Member {
    fn new(evaluator: Box<dyn Evaluator>, is_proportional: bool) -> Self {
        Self {
            evaluator,
            is_proportional,
            timings: BTreeMap::new(),
            heard: 0,
        }
    }

    /// Timing of batches of the same kind and size.
    fn timing(&self, part: &Part<'_>) -> Option<Timing> {
        self.timings.get(&Kind::of(part))?.get(&size(part)).copied()
    }

    /// Expected time of a part in seconds, from batches of the same kind and the nearest size, if there were any.
    fn expected(&self, part: &Part<'_>) -> Option<f64> {
        let (size_of_part, timings) = (size(part), self.timings.get(&Kind::of(part))?);
        let (size, timing) = timings.iter().min_by_key(|(size, _)| size.abs_diff(size_of_part))?;
        let ratio = 2.0_f64.powi(size_of_part as i32 - *size as i32);
        Some(timing.seconds * if self.is_proportional { ratio } else { 1.0 })
    }

    /// Runs a part, and passes on new warnings. Also returns the time in seconds.
    fn evaluate(
        &mut self,
        part: &Part<'_>,
        control: &Control,
        clock: &Clock,
        warnings: &mut Vec<String>,
    ) -> Result<(PartResult, f64), Error> {
        let start = clock();
        let done = self.evaluator.evaluate_part(part, control);
        let seconds = clock() - start;
        pass_on(self.evaluator.as_ref(), &mut self.heard, warnings);
        let result = done?;
        self.record(part, seconds);
        Ok((result, seconds))
    }

    /// Records the time of a part.
    fn record(&mut self, part: &Part<'_>, seconds: f64) {
        let Some(timings) = self.timings.get_mut(&Kind::of(part)) else {
            self.timings.insert(Kind::of(part), BTreeMap::new());
            return;
        };
        let timing = timings.entry(size(part)).or_insert(Timing {
            seconds,
            measurements: 0,
        });
        timing.seconds = seconds.min(2.0 * timing.seconds);
        timing.measurements += 1;
    }
}

impl Evaluator for Auto {
    fn device(&self) -> Device {
        self.with_gpu(self.cpu.evaluator.device())
    }

    fn device_for(&self, kernel: &'static Kernel) -> Device {
        self.with_gpu(self.cpu.evaluator.device_for(kernel))
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        let all = part.groups().len() as u32;
        let (mut pieces, mut next) = (None, 0);
        loop {
            let rest = part.part(next..all);
            let on_gpu = if self.is_for_gpu(&rest) {
                self.on_gpu(&rest, control)
            } else {
                None
            };
            let (end, result) = if let Some(done) = on_gpu {
                (all, done?)
            } else {
                let end = next + self.piece(&rest);
                (end, self.on_cpu(&part.part(next..end), control)?)
            };
            if (next, end) == (0, all) {
                return Ok(result);
            }
            let whole = match &mut pieces {
                Some(whole) => whole,
                none => none.insert(PartResult::blank(part.batch(), part.slots())?),
            };
            whole.put(part.batch(), &(next..end), &result);
            next = end;
            if next == all {
                return Ok(pieces.unwrap_or_default());
            }
        }
    }

    fn observe(&mut self, batch: &Batch, control: &Control, observer: Observer<'_>) -> Result<Outcome, Error> {
        let part = batch.all();
        if self.is_for_gpu(&part) {
            let result = self.evaluate_part(&part, control)?;
            return Ok(batch.observed(result, observer));
        }
        let start = (self.clock)();
        let done = self.cpu.evaluator.observe(batch, control, observer);
        pass_on(self.cpu.evaluator.as_ref(), &mut self.cpu.heard, &mut self.warnings);
        let seconds = (self.clock)() - start;
        let outcome = done?;
        self.cpu.record(&part, seconds);
        self.count(&part, seconds);
        Ok(outcome)
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn specialised_steps(&self) -> u64 {
        let on_gpu = match &self.gpu {
            Gpu::Open(gpu) => gpu.evaluator.specialised_steps(),
            _ => 0,
        };
        self.cpu.evaluator.specialised_steps() + on_gpu
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

    use super::*;
    use crate::batch::{Batch, Rollout};
    use crate::cpu::Cpu;
    use crate::random::Key;
    use crate::world::{World, WorldSpec};

    /// The CPU under a name. A part takes it a given time of a clock that nothing else moves.
    struct Named {
        name: &'static str,
        cpu: Cpu,
        milliseconds: u64,
        clock: Arc<AtomicU64>,
        parts: Arc<AtomicUsize>,
        warnings: Vec<String>,
    }

    impl Named {
        fn new(name: &'static str, milliseconds: u64, clock: &Arc<AtomicU64>) -> Self {
            Self {
                name,
                cpu: Cpu::new(Some(1)).unwrap(),
                milliseconds,
                clock: Arc::clone(clock),
                parts: Arc::default(),
                warnings: vec![format!("{name} is slow")],
            }
        }
    }

    impl Evaluator for Named {
        fn device(&self) -> Device {
            Device {
                name: self.name.into(),
                ..self.cpu.device()
            }
        }

        fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
            self.clock.fetch_add(self.milliseconds, Ordering::Relaxed);
            self.parts.fetch_add(1, Ordering::Relaxed);
            self.cpu.evaluate_part(part, control)
        }

        fn warnings(&self) -> &[String] {
            &self.warnings
        }
    }

    fn clock(milliseconds: &Arc<AtomicU64>) -> Clock {
        let milliseconds = Arc::clone(milliseconds);
        Box::new(move || milliseconds.load(Ordering::Relaxed) as f64 / 1000.0)
    }

    /// A batch of some episodes of 512 cycles.
    fn batch(rollouts: usize) -> Batch {
        let spec = WorldSpec {
            cycles: 512,
            ..WorldSpec::miglino1995()
        };
        let rollout = Rollout {
            world: 0,
            genes: &[0.0; 18],
            key: Key::rollout(0, 0, 0, 0),
        };
        Batch::new(&[World::new(spec).unwrap()], &vec![rollout; rollouts], None).unwrap()
    }

    /// A CPU and an open GPU, with the time of 64 episodes on both in seconds.
    fn auto(cpu: f64, gpu: f64) -> Auto {
        let member = |name, is_proportional, seconds| {
            let mut member = Member::new(Box::new(Named::new(name, 0, &Arc::default())), is_proportional);
            for _ in 0..=GIVE_UP_AFTER {
                member.record(&batch(64).all(), seconds);
            }
            member
        };
        let opener: Opener = Box::new(|| Err("it is open".into()));
        Auto {
            cpu: member("cpu", true, cpu),
            gpu: Gpu::Open(member("gpu", false, gpu)),
            ..Auto::new(Box::new(Named::new("cpu", 0, &Arc::default())), 1, "gpu".into(), opener)
        }
    }

    /// Of 320 batches of 64 episodes, how many go to the GPU.
    fn to_gpu(cpu: f64, gpu: f64) -> usize {
        let (mut auto, batch) = (auto(cpu, gpu), batch(64));
        let part = batch.all();
        let chosen = (0..320).filter(|_| {
            let is_for_gpu = auto.is_for_gpu(&part);
            match &mut auto.gpu {
                Gpu::Open(member) if is_for_gpu => member.record(&part, gpu),
                _ => auto.cpu.record(&part, cpu),
            }
            is_for_gpu
        });
        chosen.count()
    }

    #[test]
    fn the_slower_device_is_measured_again_now_and_then() {
        assert_eq!(to_gpu(0.020, 0.010), 315);
        assert_eq!(to_gpu(0.010, 0.020), 5);
        assert_eq!(to_gpu(0.010, 0.050), 0, "given up");
        assert_eq!(to_gpu(0.050, 0.010), 320, "given up");
        assert_eq!(to_gpu(0.0005, 0.0001), 0, "too short");
    }

    #[test]
    fn batches_of_other_sizes_are_judged_by_what_is_known() {
        let is_for_gpu = |rollouts, cpu, gpu| auto(cpu, gpu).is_for_gpu(&batch(rollouts).all());
        // Twice the steps take the CPU twice the time. The GPU may take as long as before.
        assert!(is_for_gpu(128, 0.010, 0.019));
        assert!(!is_for_gpu(128, 0.010, 0.021));
        // An eighth of them takes the CPU an eighth of its time.
        assert!(is_for_gpu(8, 0.016, 0.001));
        assert!(!is_for_gpu(8, 0.016, 0.005));
    }

    /// How many of some equal batches the CPU and the GPU get, which is opened at once, and the warnings.
    fn shared(cpu_time: u64, gpu_time: Option<u64>, batches: usize) -> (usize, usize, Vec<String>) {
        let milliseconds = Arc::default();
        let here = Named::new("cpu", cpu_time, &milliseconds);
        let there = gpu_time.map(|time| Named::new("a card", time, &milliseconds));
        let counts = [Some(&here), there.as_ref()].map(|device| device.map(|device| Arc::clone(&device.parts)));
        let opener: Opener = Box::new(|| {
            there
                .map(|it| Box::new(it) as Box<dyn Evaluator>)
                .ok_or("it burnt".into())
        });
        let mut auto = Auto {
            clock: clock(&milliseconds),
            ..Auto::new(Box::new(here), 1, "a card".into(), opener)
        };
        assert_eq!(auto.device().name, "cpu or a card");
        let batch = batch(8);
        let fitness = |evaluator: &mut dyn Evaluator| evaluator.evaluate(&batch, &Control::new()).unwrap().fitness;
        let right = fitness(&mut Cpu::new(Some(1)).unwrap());
        for _ in 0..batches {
            assert_eq!(fitness(&mut auto), right);
            while matches!(auto.gpu, Gpu::Opening(_)) {
                std::thread::yield_now();
                auto.open();
            }
        }
        let is_gone = matches!(auto.gpu, Gpu::Gone);
        assert_eq!(auto.device().name, if is_gone { "cpu" } else { "cpu or a card" });
        let [here, there] = counts.map(|parts| parts.map_or(0, |parts| parts.load(Ordering::Relaxed)));
        (here, there, auto.warnings)
    }

    #[test]
    fn batches_go_where_they_are_done_sooner() {
        // After 0.25 s of the CPU's work the GPU is opened, during its sixth batch.
        let (here, there, warnings) = shared(50, Some(5), 40);
        assert_eq!((here, there), (6, 34));
        assert_eq!(warnings, ["cpu is slow", "a card is slow"]);
        // A GPU that is much slower gets its first two batches and one that measures it again.
        let (here, there, _) = shared(20, Some(300), 100);
        assert_eq!((here, there), (97, 3));
        let (here, there, warnings) = shared(50, None, 10);
        assert_eq!((here, there), (10, 0));
        let gone = "a card: it burnt; the CPU evaluates everything";
        assert_eq!(warnings, ["cpu is slow", gone]);
        // Batches shorter than a millisecond open no GPU, however many there are.
        let (here, there, warnings) = shared(0, None, 1000);
        assert_eq!((here, there), (1000, 0));
        assert_eq!(warnings, ["cpu is slow"]);
    }
}
