//! The CPU and a GPU side by side: each batch goes to the one that is expected to finish it sooner.

use std::collections::BTreeMap;
use std::time::Instant;

use oneiro_shaders::Kernel;

use crate::batch::{Part, PartResult};
use crate::evaluator::{Control, Device, Error, Evaluator, pass_on};

/// A GPU takes about as long for a single life (`docs/gpu.md`), so it gets no batch that the CPU does in less time, s.
const LEAST_CPU_TIME: f64 = 0.001;
/// Time that longer batches of a kind take on the CPU before the GPU tries one, s: about what opening it or compiling takes.
const PATIENCE: f64 = 0.25;
/// Robot-steps of a batch, for each thread of the CPU, that the GPU tries if nothing is known of the CPU: they take 0.1 s or more there.
const MANY_STEPS: u64 = 10_000_000;
/// One in so many choices between the two goes to the slower one, to measure it again.
const MEASURE_AGAIN: u32 = 64;
/// A device that takes at least this many times as long is not measured again.
const HOPELESS: f64 = 4.0;
/// Measurements of a size before a device counts as hopeless.
const SURE: u32 = 3;

/// Opens a GPU, if it is exact; else says why not.
pub type Opener = Box<dyn FnOnce() -> Result<Box<dyn Evaluator>, String> + Send>;

/// Evaluates each batch on the CPU or on a GPU, which is opened once there is enough to do. What is expected of either is what batches
/// of the same kernel took there. Results don't depend on the choice. If the GPU fails, the CPU does its work.
pub struct Auto {
    cpu: Member,
    gpu: Option<Member>,
    opener: Option<Opener>,
    name: String,
    /// Robot-steps of a batch that goes to the GPU if nothing is known of the CPU.
    many_steps: u64,
    /// For each kind the time that the CPU has worked on batches that a GPU might have done sooner, s.
    spent: BTreeMap<Kind, f64>,
    warnings: Vec<String>,
}

/// One of the two.
struct Member {
    evaluator: Box<dyn Evaluator>,
    times: BTreeMap<Kind, BTreeMap<u32, Known>>,
    /// Number of its warnings that have been passed on.
    heard: usize,
}

/// Batches of one kind take similar time for a step: those of a kernel that bring back as much.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    kernel: &'static str,
    is_traced: bool,
    keeps_states: bool,
}

/// What is known of batches of a kind and size on one device.
#[derive(Clone, Copy, Default)]
struct Known {
    /// The last one, s; if it was longer than twice the one before, twice that.
    time: f64,
    measurements: u32,
    /// Of the CPU: how often it was compared with the GPU.
    choices: u32,
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
    /// Joins the CPU's evaluator, which has some threads, and a GPU of this name, which is not opened yet.
    pub fn new(cpu: Box<dyn Evaluator>, threads: usize, name: String, opener: Opener) -> Self {
        Self {
            many_steps: MANY_STEPS * threads as u64,
            cpu: Member::new(cpu),
            gpu: None,
            opener: Some(opener),
            name,
            spent: BTreeMap::new(),
            warnings: Vec::new(),
        }
    }

    /// The CPU's description, and the GPU's name if there may be one.
    fn beside(&self, cpu: Device) -> Device {
        if self.gpu.is_none() && self.opener.is_none() {
            return cpu;
        }
        Device {
            name: format!("{} or {}", cpu.name, self.name),
            ..cpu
        }
    }

    /// Whether the GPU should try a part that is expected to take the CPU this long, s, if that is known.
    fn is_worth_trying(&self, part: &Part<'_>, expected: Option<f64>) -> bool {
        let spent = self.spent.get(&Kind::of(part)).copied().unwrap_or_default();
        match expected {
            None => part.steps() >= self.many_steps,
            Some(time) => time >= PATIENCE || (time >= LEAST_CPU_TIME && spent >= PATIENCE),
        }
    }

    /// Opens the GPU, unless that was done before.
    fn open(&mut self) {
        let Some(open) = self.opener.take() else { return };
        match open() {
            Ok(gpu) => self.gpu = Some(Member::new(gpu)),
            Err(problem) => self
                .warnings
                .push(format!("{}: {problem}; the CPU does all work", self.name)),
        }
    }

    /// Whether the GPU gets a part.
    fn is_for_gpu(&mut self, part: &Part<'_>) -> bool {
        let expected = self.cpu.expected(part, |time, ratio| time * ratio);
        let is_worth_trying = self.is_worth_trying(part, expected);
        if is_worth_trying {
            self.open();
        }
        let Some(gpu) = &mut self.gpu else {
            return false;
        };
        // As long for any number of steps: that is right for few, and lets it try more.
        let (Some(here), Some(there)) = (expected, gpu.expected(part, |time, _| time)) else {
            return is_worth_trying;
        };
        if here < LEAST_CPU_TIME {
            return false;
        }
        let is_sooner = there < here;
        let (Some(there), Some(here)) = (gpu.known(part), self.cpu.known(part)) else {
            return is_sooner;
        };
        here.choices += 1;
        let is_turn = here.choices.is_multiple_of(MEASURE_AGAIN);
        let (fast, slow) = if is_sooner { (there, here) } else { (here, there) };
        let is_hopeless = slow.measurements >= SURE && slow.time >= HOPELESS * fast.time;
        is_sooner != (is_turn && !is_hopeless)
    }

    /// Runs a part on the GPU. `None`: it can't, and the CPU must.
    fn on_gpu(&mut self, part: &Part<'_>, control: &Control) -> Option<Result<PartResult, Error>> {
        let gpu = self.gpu.as_mut()?;
        let done = gpu.evaluate(part, control);
        pass_on(gpu.evaluator.as_ref(), &mut gpu.heard, &mut self.warnings);
        let is_gone = match &done {
            Err(error @ Error::TooLarge(_)) => {
                self.warnings.push(format!("{error}; the CPU does this batch"));
                return None;
            }
            Err(error @ Error::NoDevice(_)) => {
                self.warnings
                    .push(format!("{error}; from now on the CPU does all work"));
                true
            }
            // It was lost, and something else does its work already.
            _ => gpu.evaluator.device().name == self.cpu.evaluator.device().name,
        };
        if is_gone {
            self.gpu = None;
        }
        match done {
            Err(Error::NoDevice(_)) => None,
            done => Some(done.map(|(result, _)| result)),
        }
    }
}

impl Member {
    fn new(evaluator: Box<dyn Evaluator>) -> Self {
        Self {
            evaluator,
            times: BTreeMap::new(),
            heard: 0,
        }
    }

    /// What was measured of batches of the same kind and size.
    fn known(&mut self, part: &Part<'_>) -> Option<&mut Known> {
        self.times.get_mut(&Kind::of(part))?.get_mut(&size(part))
    }

    /// The time that a part is expected to take, s: `scaled` of the time of the batch whose size is nearest, and the ratio of their
    /// steps. `None` if there was no such batch.
    fn expected(&self, part: &Part<'_>, scaled: impl Fn(f64, f64) -> f64) -> Option<f64> {
        let (own, times) = (size(part), self.times.get(&Kind::of(part))?);
        let (size, known) = times.iter().min_by_key(|(size, _)| size.abs_diff(own))?;
        Some(scaled(known.time, 2.0_f64.powi(own as i32 - *size as i32)))
    }

    /// Runs a part. Also returns how long that took, s.
    fn evaluate(&mut self, part: &Part<'_>, control: &Control) -> Result<(PartResult, f64), Error> {
        let start = Instant::now();
        let result = self.evaluator.evaluate_part(part, control)?;
        let time = start.elapsed().as_secs_f64();
        // The first batch of a kind may include compiling, so it only opens the list.
        let is_first = !self.times.contains_key(&Kind::of(part));
        let times = self.times.entry(Kind::of(part)).or_default();
        if !is_first {
            let known = times.entry(size(part)).or_default();
            // A single slow batch may have had other reasons.
            known.time = if known.measurements == 0 {
                time
            } else {
                time.min(2.0 * known.time)
            };
            known.measurements += 1;
        }
        Ok((result, time))
    }
}

impl Evaluator for Auto {
    fn device(&self) -> Device {
        self.beside(self.cpu.evaluator.device())
    }

    fn device_for(&self, kernel: &'static Kernel) -> Device {
        self.beside(self.cpu.evaluator.device_for(kernel))
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        if self.is_for_gpu(part)
            && let Some(done) = self.on_gpu(part, control)
        {
            return done;
        }
        let done = self.cpu.evaluate(part, control);
        pass_on(self.cpu.evaluator.as_ref(), &mut self.cpu.heard, &mut self.warnings);
        let (result, time) = done?;
        if time >= LEAST_CPU_TIME {
            *self.spent.entry(Kind::of(part)).or_default() += time;
        }
        Ok(result)
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn specialised_steps(&self) -> u64 {
        let members = [Some(&self.cpu), self.gpu.as_ref()].into_iter().flatten();
        members.map(|own| own.evaluator.specialised_steps()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{Batch, Rollout};
    use crate::random::Key;
    use crate::world::{World, WorldSpec};

    struct Named(&'static str);

    impl Evaluator for Named {
        fn device(&self) -> Device {
            Device {
                name: self.0.into(),
                detail: String::new(),
                exact: true,
            }
        }

        fn evaluate_part(&mut self, _: &Part<'_>, _: &Control) -> Result<PartResult, Error> {
            unreachable!("only the choice is tested")
        }
    }

    /// A batch of some rollouts of 512 cycles.
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

    /// Of 320 batches of `rollouts`, how many go to the GPU, given the time of 64 rollouts on both, s.
    fn to_gpu(rollouts: usize, cpu: f64, gpu: f64) -> usize {
        let mut auto = Auto::new(
            Box::new(Named("cpu")),
            1,
            "gpu".into(),
            Box::new(|| Err("it is there".into())),
        );
        auto.gpu = Some(Member::new(Box::new(Named("gpu"))));
        let known = batch(64);
        let measured = |time| Known {
            time,
            measurements: SURE,
            choices: 0,
        };
        let times = |time| {
            BTreeMap::from([(
                Kind::of(&known.all()),
                BTreeMap::from([(size(&known.all()), measured(time))]),
            )])
        };
        auto.cpu.times = times(cpu);
        auto.gpu.as_mut().unwrap().times = times(gpu);
        let batch = batch(rollouts);
        (0..320).filter(|_| auto.is_for_gpu(&batch.all())).count()
    }

    #[test]
    fn the_slower_device_gets_another_chance_now_and_then() {
        assert_eq!(to_gpu(64, 0.020, 0.010), 315);
        assert_eq!(to_gpu(64, 0.010, 0.020), 5);
        assert_eq!(to_gpu(64, 0.010, 0.050), 0, "hopeless");
        assert_eq!(to_gpu(64, 0.050, 0.010), 320, "hopeless");
        assert_eq!(to_gpu(64, 0.0005, 0.0001), 0, "too short");
    }

    #[test]
    fn batches_of_other_sizes_are_judged_by_what_is_known() {
        // Twice the steps take the CPU twice the time. The GPU, which may take as long as before, must try.
        assert_eq!(to_gpu(128, 0.010, 0.019), 320);
        assert_eq!(to_gpu(128, 0.010, 0.021), 0);
        // An eighth of them takes the CPU an eighth of its time, and the GPU as long as before.
        assert_eq!(to_gpu(8, 0.016, 0.005), 0);
        assert_eq!(to_gpu(8, 0.016, 0.001), 320);
    }
}
